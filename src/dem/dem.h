/*
 * dem: reads elevation sources as rows of posts, cuts rows of posts into tiles, and writes rows of posts as rasters.
 *
 * Sources are opened through GDAL; PNG and raw heightmaps also without it. They are joined into one raster, and projected to
 * metres if they are not in metres. They are read from south to north in strips, so memory does not grow with the source. One
 * thread at a time uses a struct dem.
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
	const char *s_srs;          /* overrides the sources' own; NULL: theirs */
	const char *t_srs;          /* NULL or "auto": see cli.md */
	double spacing;             /* metres; 0: the source's own (1 if it has none) */
	enum dem_resample resample;
	const double *nodata; /* more values that mean nodata, in the source's unit */
	size_t nodata_count;
	int64_t jobs; /* threads for projecting; 0: 1 */
	bool fill; /* fill holes by interpolation from their edges */
	bool has_height_range;
	double height_min, height_max; /* metres that 0 and full scale of a PNG mean */
};

struct dem_info {
	int64_t width, height; /* posts */
	double spacing;        /* metres */
	double unit;           /* metres of the source's own unit if its values are whole numbers, else 0 */
	bool whole;            /* every height is exactly a whole number of units: nothing was resampled */
	int64_t panel_posts;   /* posts of a row that are best read together, strip by strip, before others; 0: all */
	const char *srs;       /* WKT; "" for local metres. Owned by the dem */
	double origin[2];      /* x, y of the south-west post in `srs` */
	const char *vertical;  /* the vertical reference as far as known, "" if not */
	const char *projected; /* SRS from which the sources were projected, "" if they were not */
	size_t source_count;   /* number of sources, with those of directories and lists */
	const char *const *sources;
	size_t file_count; /* other files that belong to them, as far as GDAL says: parts of a VRT, sidecars */
	const char *const *files;
	/* Where sources overlap: posts compared, posts that differ, and the greatest difference (metres). */
	int64_t overlap_posts, overlap_differing;
	double overlap_difference;
};

struct dem;

enum status dem_open(const struct dem_params *params, struct dem **out) FURROW_CHECKED;
void dem_close(struct dem *dem); /* takes NULL */
const struct dem_info *dem_info(const struct dem *dem);

/* Reads the posts of `rect` (within the terrain), row by row from the south, metres, NaN for nodata. Fastest in strips from
 * south to north. */
enum status dem_read(struct dem *dem, struct post_rect rect, double *heights) FURROW_CHECKED;

/* One tile as it is cut. Finest tiles come first: every tile comes after the tiles that it covers. */
struct dem_tile {
	struct tile tile;
	const int32_t *codes; /* (cells + 1)^2 height codes, row 0 south; HEIGHT_CODE_NODATA */
	double low, high;     /* metres, over the whole subtree; both NaN if all is nodata */
	double error;         /* metres: the greatest distance of a finer post from this level's bilinear surface */
};

typedef enum status (*dem_tile_fn)(void *user, const struct dem_tile *tile);
/* Tells progress: `done` of `total` rows of level 0, of every panel. Return another status than STATUS_OK to stop (Ctrl-C). */
typedef enum status (*dem_progress_fn)(void *user, int64_t done, int64_t total);
/* Reads posts of a rectangle, as dem_read. */
typedef enum status (*dem_posts_fn)(void *user, struct post_rect rect, double *heights);
/* Reads the codes of a level-0 tile from an earlier cut that was broken off. *known false: it is not there. */
typedef enum status (*dem_known_fn)(void *user, struct tile tile, int32_t *codes, bool *known);

struct dem_cut {
	const struct extent *extent;
	double step; /* step of height codes (base/height_code.h) */
	dem_posts_fn posts;
	void *posts_user;
	dem_tile_fn emit;
	void *emit_user;
	dem_known_fn known; /* NULL: no tile is known. Otherwise the cut emits the same tiles and asks for fewer posts */
	void *known_user;
	dem_progress_fn progress; /* NULL: not told */
	void *progress_user;
	int64_t panel_posts; /* most posts of a row that are cut together; 0: so many that memory stays below 100 MB */
};

/* Cuts posts into tiles of every level from 0 to the coarsest, by decimation. The order of tiles depends only on the world and
 * on panel_posts. STATUS_INPUT: a height cannot be coded. */
enum status dem_cut(const struct dem_cut *cut) FURROW_CHECKED;

/* Synthetic terrain. Any rows may be asked for. A post is the same whichever posts are asked for with it. */
enum dem_synth_kind { DEM_SYNTH_RIDGED, DEM_SYNTH_DUNES, DEM_SYNTH_PLAIN };

struct dem_synth {
	enum dem_synth_kind kind;
	int64_t width, height;
	double spacing, relief; /* metres */
	uint64_t seed;
};

void dem_synth_posts(const struct dem_synth *synth, struct post_rect rect, double *heights);

bool dem_path_ends(const char *path, const char *extension); /* ignores case; extension as in ".png" */

/* Rasters are written row by row from the south, under another name first, then renamed when complete. */
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
/* Writes the next rows to the north. `values`: in the raster's own unit, rounded to its type. */
enum status dem_writer_rows(struct dem_writer *writer, int64_t rows, const double *values) FURROW_CHECKED;
enum status dem_writer_publish(struct dem_writer *writer) FURROW_CHECKED; /* renames; destroy the writer afterwards */
void dem_writer_destroy(struct dem_writer *writer);                      /* removes a file that was not published */

/*
 * A raster of classes, whole numbers from 0 to 255, beside a store. It tells the class of each post of any level. One thread at
 * a time uses a handle. Each reading thread opens its own: 10 MB, and for a PNG a temporary file of two bytes a pixel. The file
 * is untrusted input.
 */
struct dem_classes_params {
	/* A grey PNG of 8 or 16 bits: one pixel for each post of level 0, from the store's north-west post, north up. With GDAL
	 * also a GeoTIFF in any SRS. Without an SRS it is in the store's coordinates. */
	const char *path;
	const struct extent *extent;
	const char *srs;  /* the store's WKT; "" for local metres */
	double origin[2]; /* the store's south-west post in `srs` */
};
struct dem_classes;
/* Opens a raster, and copies the parameters. STATUS_INPUT: the file is something else; the message says what. */
enum status dem_classes_open(const struct dem_classes_params *params, struct dem_classes **out) FURROW_CHECKED;
void dem_classes_close(struct dem_classes *classes); /* takes NULL */
/*
 * Fills `out` for each post of `rect` of `level` with table[value of the nearest pixel]. Row 0 is south, at most 2^18 posts a
 * row. `rect` may lie beyond the world. `absent` is used where the raster has no value: beyond its edge, and for nodata.
 * STATUS_INPUT: it cannot be read, or a value is no class.
 */
enum status dem_classes_read(struct dem_classes *classes, int level, struct post_rect rect,
			     const uint8_t table[256], uint8_t absent, uint8_t *out) FURROW_CHECKED;

/* Transforms coordinates in place, from `from_srs` (anything GDAL takes) to the store's WKT. Without GDAL: STATUS_FAILED. */
enum status dem_transform(const char *from_srs, const char *to_wkt, size_t count, double *x, double *y)
	FURROW_CHECKED;

/* --- GDAL's own messages --- */

/* GDAL's own messages are not printed, since the messages of this library tell each error. The command calls dem_quiet_process
 * once. A caller of the library uses dem_quiet_begin and dem_quiet_end on its thread, which may nest. These leave the process's
 * handler unchanged. */
void dem_quiet_process(void);
void dem_quiet_begin(void);
void dem_quiet_end(void);

#endif
