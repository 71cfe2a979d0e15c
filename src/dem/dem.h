/*
 * dem: elevation sources to rows of posts, rows of posts to tiles, and rows of posts to rasters.
 *
 * Sources are opened through GDAL (PNG and raw heightmaps also without it), put together into one
 * raster, projected to metres where they are not in metres, and read south to north in strips, so
 * that memory does not grow with the source. A struct dem is used by one thread at a time.
 */
#ifndef FURROW_DEM_H
#define FURROW_DEM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

enum dem_resample { DEM_BILINEAR, DEM_CUBIC, DEM_NEAR };

struct dem_params {
	const char *const *sources; /* rasters, directories, or "@list.txt" */
	size_t source_count;        /* at least 1 */
	const char *s_srs;          /* overrides the sources' own; NULL: as they say */
	const char *t_srs;          /* NULL or "auto": see cli.md */
	double spacing;             /* metres; 0: the source's own (1 where it has no place) */
	enum dem_resample resample;
	const double *nodata; /* further values that mean nodata, in the source's unit */
	size_t nodata_count;
	int64_t jobs; /* threads that may project; 0: 1 */
	bool fill; /* fill holes by interpolation from their rims */
	bool has_height_range;
	double height_min, height_max; /* metres that a PNG's 0 and full scale mean */
};

struct dem_info {
	int64_t width, height; /* posts */
	double spacing;        /* metres */
	double unit;           /* metres of the source's own unit if it holds whole numbers, else 0 */
	bool whole;            /* every height is a whole number of units, to the last bit: nothing was resampled */
	int64_t panel_posts;   /* of a row that are best read at once, strip by strip, before others; 0: all */
	const char *srs;       /* WKT; "" for local metres. Owned by the dem */
	double origin[2];      /* x, y of the south-west post in `srs` */
	const char *vertical;  /* what is known of the vertical reference, "" if nothing */
	const char *projected; /* what the sources were projected from, "" if they were not */
	size_t source_count;   /* after directories and lists were opened */
	const char *const *sources;
	size_t file_count; /* what they are made of beside themselves, as far as GDAL says: parts of a VRT, sidecars */
	const char *const *files;
	/* Where sources overlap: posts compared and by how much they disagree at most (metres). */
	int64_t overlap_posts, overlap_differing;
	double overlap_difference;
};

struct dem;

enum status dem_open(const struct dem_params *params, struct dem **out) FURROW_CHECKED;
void dem_close(struct dem *dem); /* takes NULL */
const struct dem_info *dem_info(const struct dem *dem);

/* Posts of `rect` (row 0 south, within the terrain), row by row, metres, NaN where nodata. Best read in
 * strips, from south to north. */
enum status dem_read(struct dem *dem, struct post_rect rect, double *heights) FURROW_CHECKED;

/* One tile as it is cut, finest first: every tile comes after the tiles it covers. */
struct dem_tile {
	struct tile tile;
	const int32_t *codes; /* (cells + 1)^2 height codes, row 0 south; HEIGHT_CODE_NODATA */
	double low, high;     /* metres, over the whole subtree; both NaN if all is nodata */
	double error;         /* metres: most that this level's bilinear surface is off a finer post */
};

typedef enum status (*dem_tile_fn)(void *user, const struct dem_tile *tile);
/* `done` of `total` rows of level 0 (of every panel); return other than STATUS_OK to stop (Ctrl-C). */
typedef enum status (*dem_progress_fn)(void *user, int64_t done, int64_t total);
/* As dem_read: posts of a rectangle. */
typedef enum status (*dem_posts_fn)(void *user, struct post_rect rect, double *heights);
/* A tile of level 0 cut before, by a cut that was broken off: its codes. *known false: not there. */
typedef enum status (*dem_known_fn)(void *user, struct tile tile, int32_t *codes, bool *known);

struct dem_cut {
	const struct extent *extent;
	double step; /* of height codes (base/height_code.h) */
	dem_posts_fn posts;
	void *posts_user;
	dem_tile_fn emit;
	void *emit_user;
	dem_known_fn known; /* NULL: nothing is; else a cut emits the same tiles, and asks for fewer posts */
	void *known_user;
	dem_progress_fn progress; /* NULL: not told */
	void *progress_user;
	int64_t panel_posts; /* of a row that are cut at once at most; 0: so that memory stays below 100 MB */
};

/* Cuts posts into tiles of every level from 0 to the coarsest, decimating. The order of the tiles depends
 * on the world and panel_posts alone. A height that cannot be coded is STATUS_INPUT. */
enum status dem_cut(const struct dem_cut *cut) FURROW_CHECKED;

/* Synthetic terrain: any row of any size at once, the same posts whatever is asked with them. */
enum dem_synth_kind { DEM_SYNTH_RIDGED, DEM_SYNTH_DUNES, DEM_SYNTH_PLAIN };

struct dem_synth {
	enum dem_synth_kind kind;
	int64_t width, height;
	double spacing, relief; /* metres */
	uint64_t seed;
};

void dem_synth_posts(const struct dem_synth *synth, struct post_rect rect, double *heights);

bool dem_path_ends(const char *path, const char *extension); /* in any case, as in ".png" */

/* Rasters out, row by row from the south, written aside and renamed when whole. */
enum dem_raster_type { DEM_FLOAT32, DEM_INT32, DEM_UINT8, DEM_UINT16 };

struct dem_raster {
	const char *path;    /* .tif/.tiff (GDAL) or .png */
	int64_t width, height;
	enum dem_raster_type type; /* PNG: UINT8 and UINT16 only */
	const char *srs;           /* WKT or "" */
	double west, south;        /* SRS coordinates of the south-west post */
	double spacing;
	bool has_nodata;
	double nodata;
};

struct dem_writer;
enum status dem_writer_create(const struct dem_raster *raster, struct dem_writer **out) FURROW_CHECKED;
/* The next rows to the north; `values` in the raster's own meaning, rounded to its type. */
enum status dem_writer_rows(struct dem_writer *writer, int64_t rows, const double *values) FURROW_CHECKED;
enum status dem_writer_publish(struct dem_writer *writer) FURROW_CHECKED; /* renames; still to be destroyed */
void dem_writer_destroy(struct dem_writer *writer);                      /* removes what was not published */

/*
 * A raster of classes, whole numbers from 0 to 255, beside a store: which each post of any level is of. A handle
 * is for one thread at a time: a thread that reads opens its own (10 MB, and for a PNG a temporary file of two
 * bytes a pixel). The file is untrusted.
 */
struct dem_classes_params {
	/* A grey PNG of 8 or 16 bits, a pixel a post of level 0 from the store's north-west one, north up; or,
	 * with GDAL, a GeoTIFF in any SRS. One without an SRS is in the store's coordinates. */
	const char *path;
	const struct extent *extent;
	const char *srs;  /* the store's WKT; "" for local metres */
	double origin[2]; /* its south-west post there */
};
struct dem_classes;
/* Copies what it is given. STATUS_INPUT: what the file is instead. */
enum status dem_classes_open(const struct dem_classes_params *params, struct dem_classes **out) FURROW_CHECKED;
void dem_classes_close(struct dem_classes *classes); /* takes NULL */
/*
 * For each post of `rect` of `level` (row 0 south, row by row, at most 2^18 a row; it may lie beyond the world)
 * table[the value of the pixel nearest to it], `absent` where the raster has none: beyond it, and nodata.
 * STATUS_INPUT: it cannot be read, or a value is no class.
 */
enum status dem_classes_read(struct dem_classes *classes, int level, struct post_rect rect,
			     const uint8_t table[256], uint8_t absent, uint8_t *out) FURROW_CHECKED;

/* Coordinates: from `srs` (anything GDAL takes) to the store's WKT. Without GDAL: STATUS_FAILED. */
enum status dem_transform(const char *from_srs, const char *to_wkt, size_t count, double *x, double *y)
	FURROW_CHECKED;

/* --- GDAL's own messages --- */

/* Errors are told by this library's messages. The command keeps GDAL from printing its own in the whole process; a library's caller
 * does so on its thread from begin to end, which nest, and leaves the process's handler alone. */
void dem_quiet_process(void);
void dem_quiet_begin(void);
void dem_quiet_end(void);

#endif
