/*
 * dem: reads elevation sources as rows of posts, cuts the posts into tiles, and writes rasters.
 *
 * Sources are read with GDAL. PNG and raw heightmaps are also read without it. Several sources are joined into one raster. If
 * they are not in metres, they are projected to metres. They are read from south to north in strips, so memory does not grow
 * with the source. One thread at a time uses a struct dem.
 */
#ifndef FURROW_DEM_H
#define FURROW_DEM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

enum dem_resample { DEM_BILINEAR, DEM_CUBIC, DEM_NEAR, DEM_AVERAGE, DEM_LANCZOS };
/* Heights that are coded in the red, green and blue of a picture, 8 bits each, as terrain tiles are. Metres are
 * TERRARIUM: red * 256 + green + blue / 256 - 32768. MAPBOX: (red * 65536 + green * 256 + blue) / 10 - 10000. */
enum dem_encoding { DEM_PLAIN, DEM_TERRARIUM, DEM_MAPBOX };
/* Whether values are distances from the middle of the body, not heights. AUTO: if they are near the radius of their SRS's sphere. */
enum dem_radii { DEM_RADII_AUTO, DEM_RADII_YES, DEM_RADII_NO };

struct dem_params {
	const char *const *sources; /* rasters, directories, or "@list.txt" */
	size_t source_count;        /* at least 1 */
	const char *vrt_folder;     /* a folder in which files lie that a VRT may name beside those in its own; NULL: none */
	const char *s_srs;          /* overrides the SRS of the sources; NULL: no override */
	/* SRS of the result. NULL or "auto": the first source's, if it is in true metres, otherwise a metric one that suits the
	 * place. "source": the first source's, true or not, but metres. */
	const char *t_srs;
	/* What heights are above: "ellipsoid", "egm96", "egm2008", or a vertical SRS. s_vertical overrides what the sources say, NULL: no
	 * override. Heights are converted to t_vertical, NULL: they stay as they are. */
	const char *s_vertical, *t_vertical;
	const char *s_unit; /* unit of the sources' values, as "us-ft"; NULL: what each says, or metres */
	double spacing;             /* metres; 0: that of the source (1 if it has none) */
	/* x and y in t_srs of a post with which all posts of the result are aligned, at multiples of `spacing`; NULL: any posts */
	const double *anchor;
	enum dem_resample resample;
	enum dem_radii radii; /* whether values are distances from the centre of the planet, which become heights over the sphere of the SRS */
	int64_t band; /* of a raster, from 1; 0: the first. An inset of one band has no other */
	enum dem_encoding encoding;
	const double *nodata; /* further values that mean nodata, in the source's unit; of coded colours in metres */
	size_t nodata_count;
	bool has_window; /* only posts in the window are read */
	double window[4]; /* west, south, east, north */
	const char *window_srs; /* of the window; NULL: it is in the result's coordinates */
	/* Without a spacing: leave out what is at least twice as fine as the other sources and lies within them; dem_info tells it. */
	bool apart;
	bool fill; /* fill holes by interpolation from their edges */
	int64_t jobs; /* threads that resample sources; 0 or 1: the thread that reads. Heights do not depend on it */
	bool has_height_range;
	double height_min, height_max; /* metres for 0 and for the largest value of a PNG */
};

struct dem_info {
	int64_t width, height; /* posts */
	double spacing;        /* metres */
	double unit;           /* metres of the source's unit, if its values are whole numbers; otherwise 0 */
	bool resampled;        /* posts of some sources are not the result's; dem_misfit tells by how much it is off them */
	bool whole;            /* every height is exactly a whole number of units, so nothing was resampled */
	bool shifted;          /* heights of a source are converted to another vertical reference */
	int64_t panel_posts;   /* posts of a row that are best read together, in strips, before the next panel; 0: whole rows */
	const char *srs;       /* WKT; "" for local metres. Owned by the dem */
	double origin[2];      /* x, y of the south-west post in `srs` */
	const char *vertical;  /* what heights are above, as the first source says, or t_vertical; "" if not said */
	const char *projected; /* the SRS from which the sources were projected; "" if they were not */
	bool keepable;         /* they were projected by t_srs `auto`; `source` would keep the first one's SRS */
	double ground_off;     /* what dem_ground_off returns for the SRS and its posts */
	size_t source_count;   /* number of sources, including those in directories and lists */
	const char *const *sources;
	size_t file_count; /* other files that belong to the sources, as GDAL tells: parts of a VRT, sidecars */
	const char *const *files;
	/* Sources left out, as finer: those with one number in finer_sets lie side by side, and have about the same spacing. */
	size_t finer_count;
	const char *const *finer;
	const size_t *finer_sets;
	double covered; /* share of the posts that lie in the sources' rectangles, at most; of one source 1 */
	/* Where sources overlap: number of posts compared, number that differ, and the largest difference in metres. */
	int64_t overlap_posts, overlap_differing;
	double overlap_difference;
};

struct dem;

enum status dem_open(const struct dem_params *params, struct dem **out) FURROW_CHECKED;
void dem_close(struct dem *dem); /* dem may be NULL */
const struct dem_info *dem_info(const struct dem *dem);

/* Reads the posts of `rect`, which is within the terrain. Row by row from the south, in metres; NaN: nodata. Strips from south
 * to north are fastest. */
enum status dem_read(struct dem *dem, struct post_rect rect, double *heights) FURROW_CHECKED;

/*
 * Adds to `misfit` by how much a tile's surface is off the sources at their own posts. The surface is bilinear between the codes.
 * Posts that lie in several tiles count once; where sources overlap, only posts of the one that was taken; none beside holes.
 * For a level-0 tile, if dem_info says `resampled`. `step`: of the codes.
 */
struct dem_tile;
enum status dem_misfit(struct dem *dem, const struct extent *extent, const struct dem_tile *tile, double step,
		       struct misfit *misfit) FURROW_CHECKED;

/* The same for the surface between heights of posts of `rect`, metres, NaN: not measured. Source posts from column ends[0], or row ends[1],
 * on are not measured, unless the terrain ends there. */
enum status dem_misfit_heights(struct dem *dem, struct post_rect rect, const double *heights, const int64_t ends[2],
			       struct misfit *misfit) FURROW_CHECKED;

/* One finished tile of a cut. Every tile comes after the finer tiles that it covers. */
struct dem_tile {
	struct tile tile;
	const int32_t *codes; /* (cells + 1)^2 height codes, row 0 south; HEIGHT_CODE_NODATA */
	double low, high;     /* metres, over the tile and all finer tiles below it; both NaN if all is nodata */
	double error;         /* metres: largest height difference between a finer post and the bilinear surface of this level */
	/* By how much the codes are off the heights they were made from. Below level 0 only posts count that are an inset's alone. A post
	 * that tiles share counts once. Nothing of posts that were known already. */
	struct misfit misfit;
	struct misfit source; /* the same, or by how much the surface is off the sources at their own posts */
};

typedef enum status (*dem_tile_fn)(void *user, const struct dem_tile *tile);
/* Called with progress: `done` of `total` rows of level 0, summed over panels. If it does not return STATUS_OK, the cut stops
 * (Ctrl-C). */
typedef enum status (*dem_progress_fn)(void *user, int64_t done, int64_t total);
/* Reads the posts of a rectangle, as dem_read does. */
typedef enum status (*dem_posts_fn)(void *user, struct post_rect rect, double *heights);
/* Gives what insets make of a level-0 tile. Replaces the codes of posts that an inset has. *low, *high, *error: range and error, as
 * in struct dem_tile, of the finer tiles below it. They come as NaN, NaN, 0. */
typedef enum status (*dem_finer_fn)(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error);
/* Gives the codes of a level-0 tile from an earlier, unfinished cut. *known is false if it has no such tile. */
typedef enum status (*dem_known_fn)(void *user, struct tile tile, int32_t *codes, bool *known);

struct dem_cut {
	const struct extent *extent;
	double step; /* step of height codes (base/height_code.h) */
	double rounded; /* metres, a multiple of step: heights are rounded to multiples of it first; 0: they are not */
	dem_posts_fn posts;
	void *posts_user;
	/* Called for each tile of level 0 before insets change it. It may set by how much the tile is off the sources. May be NULL. */
	enum status (*measure)(void *user, const struct dem_tile *tile, struct misfit *source);
	void *measure_user;
	dem_tile_fn emit;
	void *emit_user;
	dem_finer_fn finer; /* NULL: there are no insets */
	void *finer_user;
	dem_known_fn known; /* NULL: no tile is known. With it the cut emits the same tiles but reads fewer posts */
	void *known_user;
	dem_progress_fn progress; /* NULL: progress is not told */
	void *progress_user;
	int64_t panel_posts; /* most posts of a row that are cut together; 0: chosen so that memory stays below 100 MB */
};

/* Cuts posts into tiles of all levels from 0 to the coarsest, by decimation. The order of tiles depends only on the extent and
 * on panel_posts. STATUS_INPUT: a height cannot be coded. */
enum status dem_cut(const struct dem_cut *cut) FURROW_CHECKED;

/*
 * Insets: finer sources in a part of a terrain, each stored at a level below 0.
 *
 * The level is the coarsest whose spacing is at most the source's. Its heights are blended with what surrounds it, over `feather` metres
 * inwards from its outline: the country, or a coarser inset. Its holes are filled from their edges, and deep inside one from what surrounds
 * the inset. Finer insets lie over coarser ones; of the same level the first named lies on top. One thread at a time.
 */
struct dem_insets;
struct dem_inset_source {
	const char *const *paths; /* rasters, directories or "@list.txt", which together are the inset */
	size_t count;
	bool found; /* nobody named it as an inset: it is left out, with a note, if it does not lie in the terrain */
};
struct dem_insets_params {
	struct dem *country;           /* must outlive the insets */
	const struct extent *extent;   /* of the terrain */
	const struct dem_params *dem;  /* of the country: nodata, resampling and threads count for insets too */
	const struct dem_inset_source *sources;
	size_t count;
	double feather;                /* metres; below 0: ten posts of what surrounds the inset. At most a quarter of its shorter side */
	bool match;                    /* lower or raise each inset by its offset */
};
struct dem_inset_info {
	const char *source; /* its first path */
	size_t paths;
	bool found;         /* as in dem_inset_source */
	int level;
	int64_t x, y;           /* its south-west post, counted at that level from the terrain's */
	int64_t width, height;  /* posts, at that level */
	double spacing;         /* metres */
	double unit;            /* as in dem_info */
	double feather;         /* metres */
	double offset;          /* metres that it is above what surrounds it: the median over its rim */
	int64_t rim_posts;      /* posts that the median is of; 0: there is nothing around it */
	bool matched;           /* that offset was taken off */
};
enum status dem_insets_open(const struct dem_insets_params *params, struct dem_insets **out) FURROW_CHECKED;
void dem_insets_close(struct dem_insets *insets); /* insets may be NULL */
size_t dem_insets_count(const struct dem_insets *insets);
/* In the order in which they were named; those that were left out are not among them. */
const struct dem_inset_info *dem_insets_info(const struct dem_insets *insets, size_t index);
const struct dem_info *dem_insets_files(const struct dem_insets *insets, size_t index); /* of the inset with this index; owned by `insets` */

struct dem_insets_cut {
	struct dem_insets *insets;
	double step; /* as in struct dem_cut */
	dem_tile_fn emit;
	void *emit_user;
	/* Gives a tile that was emitted before; all of the finer level were. *found is false if there is none. */
	enum status (*get)(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error, bool *found);
	void *get_user;
	/* called before the tiles of a level are asked for; NULL: no calls */
	enum status (*settle)(void *user);
	dem_progress_fn progress; /* asked for each row of tiles whether to go on; done is 0 */
	void *progress_user;
};
/* Emits all tiles below level 0, finer levels first. The order depends only on the insets and the extent. */
enum status dem_insets_cut(const struct dem_insets_cut *cut) FURROW_CHECKED;
/* A dem_finer_fn; `user` is a struct dem_insets_cut whose tiles were all emitted. */
enum status dem_insets_finer(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error) FURROW_CHECKED;

/* Synthetic terrain. Any rectangle may be read. A post's height does not depend on the rectangle. */
enum dem_synth_kind { DEM_SYNTH_RIDGED, DEM_SYNTH_DUNES, DEM_SYNTH_PLAIN };

struct dem_synth {
	enum dem_synth_kind kind;
	int64_t width, height;
	double spacing, relief; /* metres */
	uint64_t seed;
};

void dem_synth_posts(const struct dem_synth *synth, struct post_rect rect, double *heights);

bool dem_path_ends(const char *path, const char *extension); /* ignores case; extension as in ".png" */

/* Rasters are written row by row from the south, under another name. When complete they are renamed. */
enum dem_raster_type { DEM_FLOAT32, DEM_FLOAT64, DEM_INT32, DEM_UINT8, DEM_UINT16 };

struct dem_raster {
	const char *path;    /* .tif/.tiff (GDAL), .png, or .r16/.raw: little-endian, north row first */
	int64_t width, height;
	enum dem_raster_type type; /* PNG: UINT8 and UINT16 only; raw: UINT16 only */
	const char *srs;           /* WKT or "" */
	const char *vertical;      /* what its values, heights in metres, are above, as dem_info tells it; NULL or "": not said. Valid during dem_writer_create */
	const char *unit, *band;   /* of a GeoTIFF: unit of the values, and what they are; NULL: not said. Valid during dem_writer_create */
	double west, south;        /* SRS coordinates of the south-west post */
	double spacing;
	bool has_nodata;
	double nodata;
};

struct dem_writer;
enum status dem_writer_create(const struct dem_raster *raster, struct dem_writer **out) FURROW_CHECKED;
/* Writes the next rows to the north. `values`: in the unit of the raster; they are rounded to its type. */
enum status dem_writer_rows(struct dem_writer *writer, int64_t rows, const double *values) FURROW_CHECKED;
enum status dem_writer_publish(struct dem_writer *writer) FURROW_CHECKED; /* renames the file; destroy the writer afterwards */
void dem_writer_destroy(struct dem_writer *writer);                      /* removes the file if it was not published */

/*
 * A raster that lies over a store's terrain and gives a class or a number for each post of any level. One thread at a time uses a
 * handle, so each reading thread opens its own. A handle takes 9 MB for classes, 3 MB for numbers. For a PNG it also takes a
 * temporary file of two bytes for each pixel. The file is untrusted input.
 */
enum dem_placed_kind {
	DEM_PLACED_CLASSES, /* pixels are whole numbers from 0 to 255 */
	DEM_PLACED_NUMBERS, /* pixels are any real numbers; GDAL's scale and offset are applied */
};
struct dem_placed_params {
	/* A grey PNG of 8 or 16 bits: one pixel for each post of level 0, beginning at the store's north-west post, north up.
	 * With GDAL also a GeoTIFF in any SRS. A GeoTIFF without an SRS is in metres from the store's south-west post. */
	const char *path;
	const struct extent *extent;
	const char *srs;  /* the store's WKT; "" for local metres */
	double origin[2]; /* the store's south-west post in `srs` */
};
struct dem_pixels;
/* Opens a raster and copies the parameters. STATUS_INPUT: the file is not such a raster; the message says why. */
enum status dem_pixels_open(const struct dem_placed_params *params, enum dem_placed_kind kind, struct dem_pixels **out) FURROW_CHECKED;
void dem_pixels_close(struct dem_pixels *pixels); /* pixels may be NULL */
/*
 * Classes. Fills `out` for each post of `rect` of `level` with table[value of the nearest pixel]. The south row comes first. A row
 * has at most 2^18 posts. `rect` may extend beyond the world. `absent` is used where the raster has no value: beyond its edge, and
 * for nodata. STATUS_INPUT: the raster cannot be read, or a value is not a class.
 */
enum status dem_classes_read(struct dem_pixels *pixels, int level, struct post_rect rect,
			     const uint8_t table[256], uint8_t absent, uint8_t *out) FURROW_CHECKED;
/* Numbers. Reads all pixels, and finds the least and the greatest value. STATUS_INPUT: a value is out of `range`; no pixel has a
 * value; the raster cannot be read. */
struct dem_numbers_range {
	const char *name, *unit; /* for messages; unit NULL: none */
	double low, high;        /* allowed values */
	bool above;              /* `low` itself is not allowed */
};
enum status dem_numbers_extremes(struct dem_pixels *pixels, const struct dem_numbers_range *range, double *low, double *high)
	FURROW_CHECKED;
/*
 * Numbers. Fills `out` for each post of `rect` of `level`, the south row first. A row has at most 2^16 posts. `rect` may extend
 * beyond the world. A number is bilinear between the four pixels around the post. NaN: the nearest pixel has no value, or there is
 * none.
 */
enum status dem_numbers_read(struct dem_pixels *pixels, int level, struct post_rect rect, double *out) FURROW_CHECKED;

/*
 * --- imagery: colours over a terrain that there is ---
 *
 * Sources are rasters that GDAL reads, of 8 bits a band: red, green and blue, or grey, or a palette; opacity where they have it. Each has its own
 * SRS and resolution. One without an SRS is in metres from the store's south-west post. Where several overlap the first named wins.
 */
struct dem_imagery_params {
	const char *const *sources; /* as of dem_params: rasters, folders, "@list.txt" */
	size_t count;
	const char *vrt_folder;     /* may be NULL */
	const struct extent *extent; /* of the terrain */
	const char *srs;            /* of the store: WKT; "" for local metres */
	double origin[2];           /* of the store */
	int64_t jobs;               /* threads that resample; at least 1 */
};
struct dem_imagery_info {
	size_t source_count;
	const char *const *paths;
	double pixel;      /* metres: side of the smallest pixel of all sources, where it lies on the terrain */
	double low[2], high[2]; /* the area of all sources, metres from the store's south-west post; it may extend beyond the terrain */
};
struct dem_imagery;
/* Opens the sources, and copies the parameters but for *extent. STATUS_INPUT: a source is no picture, has no place, or none lies on the terrain. */
enum status dem_imagery_open(const struct dem_imagery_params *params, struct dem_imagery **out) FURROW_CHECKED;
void dem_imagery_close(struct dem_imagery *imagery); /* imagery may be NULL */
const struct dem_imagery_info *dem_imagery_info(const struct dem_imagery *imagery);
/* Fills 4 bytes for each post of `rect` of `level`: red, green, blue, opacity; row 0 south. A pixel's centre is its post. A source with pixels
 * much smaller than the spacing is averaged, others are bilinear. One thread at a time. STATUS_INPUT: a source cannot be read. */
enum status dem_imagery_read(struct dem_imagery *imagery, int level, struct post_rect rect, uint8_t *pixels) FURROW_CHECKED;

/* A line on the globe, or every line of a file, one after the other. */
struct dem_line {
	double (*points)[2]; /* degrees east and north; DEM_SRS_DEGREES says of what */
	double *times;       /* s since 1970 UTC, one a point; NULL: the points have none */
	size_t count;
	size_t *starts; /* the first point of each line */
	size_t lines;
};
#define DEM_EVERY_LINE SIZE_MAX
/*
 * Reads line `number` (from 1; 0: the only one; or DEM_EVERY_LINE) of a GPX or GeoJSON file. Lines of GPX are its tracks, each with all its segments; without
 * tracks, its routes. Lines of GeoJSON are every LineString, and each part of a MultiLineString. `told`: names the file in messages. The
 * caller frees the arrays, by dem_line_finish. STATUS_INPUT: no such line, or number is 0 and there are several; the message tells how many there are.
 * Without GDAL: STATUS_FAILED. Thread-safe.
 */
enum status dem_line_read(const char *path, const char *told, size_t number, struct dem_line *line) FURROW_CHECKED;
void dem_line_finish(struct dem_line *line);

/* The name of a system: longitude and latitude in degrees on the body of the other SRS. On the Earth they are WGS 84's. */
#define DEM_SRS_DEGREES "degrees"
/* Converts coordinates in place, from `from_srs` (any form that GDAL accepts) to the SRS `to_wkt`. One of them may be DEM_SRS_DEGREES.
 * Without GDAL: STATUS_FAILED. */
enum status dem_transform(const char *from_srs, const char *to_wkt, size_t count, double *x, double *y)
	FURROW_CHECKED;

/* Returns by what share distances on the ground differ most from those of the SRS `wkt`. -0.18: they are up to 18 % shorter. 0: they differ by
 * less than 0.5 %, or cannot be computed. It looks at nine places of the rectangle from `low` to `high`, coordinates of the SRS. */
double dem_ground_off(const char *wkt, const double low[2], const double high[2]);

/*
 * Longitude and latitude of the points of an SRS, in degrees: WGS84 on the Earth, on another body that body's own. One thread at a
 * time uses a handle.
 */
struct dem_globe;
struct dem_globe_info {
	double semi_major, flattening; /* of the ellipsoid: metres, and a share of 1 */
	bool earth;
	char name[80]; /* of the system of the degrees */
};
/* *out is NULL, and the status is STATUS_OK, if the SRS is local and lies on no body. STATUS_INPUT: it is not an SRS, or has no way
 * to degrees. STATUS_FAILED: there is no GDAL. */
enum status dem_globe_create(const char *wkt, struct dem_globe **out) FURROW_CHECKED;
void dem_globe_destroy(struct dem_globe *globe); /* globe may be NULL */
const struct dem_globe_info *dem_globe_info(const struct dem_globe *globe);
/* Convert points in place: x, y of the SRS to longitude and latitude, and back. A point without a result becomes NaN. */
void dem_globe_to_degrees(struct dem_globe *globe, size_t count, double *x, double *y);
void dem_globe_from_degrees(struct dem_globe *globe, size_t count, double *x, double *y);

/* --- GDAL's own messages --- */

/* Suppress GDAL's own messages, since this library reports each error itself. dem_quiet_process: for the whole process; the
 * command calls it once. dem_quiet_begin and dem_quiet_end: on the calling thread, for callers of the library. They may be
 * nested, and leave the process's handler unchanged. */
void dem_quiet_process(void);
void dem_quiet_begin(void);
void dem_quiet_end(void);

/* GDAL uses no network on a thread between dem_quiet_begin and dem_quiet_end, and in the command. These allow it, for all threads, from
 * the one call to the other; they are called on one thread, and may be nested. */
void dem_network_begin(void);
void dem_network_end(void);

#endif
