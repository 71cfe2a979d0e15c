/* Shared by the files of src/exchange: frames, zoom levels, samples and files of tiles. */
#ifndef FURROW_EXCHANGE_INTERNAL_H
#define FURROW_EXCHANGE_INTERNAL_H

#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "base/key_map.h"
#include "base/key_set.h"
#include "dem/dem.h"
#include "exchange/exchange.h"

#define EXCHANGE_CELLS 64   /* along a mesh tile */
#define EXCHANGE_ZOOM_MOST 24
#define EXCHANGE_ZOOMS (2 * (EXCHANGE_ZOOM_MOST + 1))

/*
 * --- frame.c: where a terrain lies ---
 *
 * A frame gives each point of the store a longitude and a latitude, and a place on the map. The map is Web Mercator. For a store in
 * local metres it is a square that begins at the south-west post. A local store has degrees too: it is laid out around 0, 0. One thread at a
 * time uses a frame.
 */
struct exchange_frame {
	const struct store_meta *meta;
	struct dem_globe *globe; /* NULL: local metres */
	double semi_major, flattening;
	bool earth;
	double bounds[4]; /* degrees: west, south, east, north of all posts, a little more */
	double side;      /* metres: of a local map's square */
	double metres[4]; /* what is exported: west, south, east, north from the south-west post */
	bool clipped;     /* of it only what lies in `clip` */
	double clip[4];   /* degrees: west, south, east, north */
	int pixels;       /* along a map tile */
	bool fine_globe;
	bool maps_only;   /* no tiles for globes */
	bool whole_only;  /* of maps only the zoom levels that have all tiles */
};
enum status exchange_frame_init(struct exchange_frame *frame, const struct exchange_tiles_params *params) FURROW_CHECKED;
/* Returns true if the frame shows a point: within its window and its clip. Metres from the south-west post, and degrees. */
static inline bool exchange_frame_shows(const struct exchange_frame *frame, double x, double y)
{
	const double beside = 1e-6 * frame->meta->extent.spacing;
	return x >= frame->metres[0] - beside && y >= frame->metres[1] - beside && x <= frame->metres[2] + beside && y <= frame->metres[3] + beside;
}
static inline bool exchange_frame_clips(const struct exchange_frame *frame, double longitude, double latitude)
{
	const double *clip = frame->clip;
	return frame->clipped && !(longitude >= clip[0] && longitude <= clip[2] && latitude >= clip[1] && latitude <= clip[3]);
}
void exchange_frame_finish(struct exchange_frame *frame); /* frame may be all zero */
/* Convert points in place between metres east and north of the south-west post and degrees. NaN: no such point. */
void exchange_frame_to_degrees(const struct exchange_frame *frame, size_t count, double *x, double *y);
void exchange_frame_from_degrees(const struct exchange_frame *frame, size_t count, double *x, double *y);
/* Return the metres of a degree to the east and to the north, at a latitude in degrees. */
void exchange_frame_degree(const struct exchange_frame *frame, double latitude, double *east, double *north);
/* Returns the point (longitude, latitude in degrees, height in metres) in coordinates from the body's centre. */
void exchange_frame_earth_centred(const struct exchange_frame *frame, double longitude, double latitude, double height, double out[3]);

/*
 * --- zooms.c: the tiles of each zoom level ---
 *
 * A dense zoom level has all tiles that touch the terrain. Zoom levels finer than level 0 of the store are sparse. They have the
 * tiles that touch a deformed tile of the working level, if that is as fine. They also have those that touch an inset as fine as that.
 */
struct exchange_zoom {
	bool imagery; /* map tiles finer than those of heights: imagery alone */
	bool globe;  /* mesh tiles, y from the south; otherwise map tiles, y from the north */
	int z;
	int level;   /* of the store: the one whose spacing is nearest to a sample's */
	double step; /* metres between two samples, at the middle of the terrain */
	int control; /* exact positions are that many samples apart, a power of two; between them they are interpolated */
	int64_t x0, y0, x1, y1; /* the tiles lie in this rectangle, x0 <= x < x1 */
	bool sparse;
	struct key_set tiles;    /* of a sparse one: those that are there, by exchange_zoom_key */
	struct key_set deformed; /* of maps from zoom level `ruts` on: those that touch a deformed tile */
	bool some;            /* only the tiles in `due` are to be made */
	struct key_set due;
	uint64_t *order;      /* of a sparse one, or of `due`: the keys, sorted; NULL: dense and whole */
	size_t count;         /* of `order` */
	int64_t units;        /* units of work, each of at most EXCHANGE_UNIT tiles */
};
struct exchange_zooms {
	struct exchange_zoom zooms[EXCHANGE_ZOOMS]; /* in the order of work: maps, then globe, each from fine to coarse */
	size_t count;
	int map[2], mesh[2];  /* least and greatest zoom */
	int imagery;          /* greatest zoom of imagery, at least map[1]; -1: there is none */
	int64_t revision;
	bool deformed;        /* the store has a working level */
	int working;
	int finest;           /* level of the store, at most 0, that the finest zoom level shows */
	int ruts;             /* the map whose pixels are as fine as the working level; coarser ruts are made of finer ones */
};
static inline uint64_t exchange_zoom_key(const struct exchange_zoom *zoom, int64_t x, int64_t y)
{
	return tile_key((struct tile){zoom->z, (uint32_t)x, (uint32_t)y});
}
/* Plans all zoom levels. `since` as in exchange_tiles_params. */
enum status exchange_zooms_init(struct exchange_zooms *zooms, const struct exchange_frame *frame, struct store_reader *reader,
				struct store *store, int64_t since) FURROW_CHECKED;
void exchange_zooms_finish(struct exchange_zooms *zooms);
bool exchange_zoom_has(const struct exchange_zoom *zoom, int64_t x, int64_t y);
/* Gives the tiles of a unit of work, at most EXCHANGE_UNIT. Returns their number. */
#define EXCHANGE_UNIT 16
size_t exchange_zoom_unit(const struct exchange_zoom *zoom, int64_t unit, struct tile tiles[EXCHANGE_UNIT]);

/* --- place.c: positions of samples --- */
/* Fills the positions of samples i0 <= i < i0 + nx, j0 <= j < j0 + ny: degrees for a globe or a map on one, else metres. Sample i of
 * a map is the centre of pixel i from the west, j from the north. Sample (i, j) of a globe is a corner of cells of the mesh tiles,
 * j from the south. */
void exchange_place_degrees(const struct exchange_frame *frame, const struct exchange_zoom *zoom, double i, double j, double *x,
			    double *y);
/* The same in metres east and north of the south-west post. `count` points, exact. NaN: outside the body or the terrain's bounds. */
void exchange_place_exact(const struct exchange_frame *frame, const struct exchange_zoom *zoom, size_t count, const double *i,
			  const double *j, double *x, double *y);
/* Returns the largest `control` whose interpolation is within 1/32 of a sample in the zoom level's corners and its middle. */
int exchange_place_control(const struct exchange_frame *frame, const struct exchange_zoom *zoom);
/* Gives the metres of the ground between two samples at row j. */
void exchange_place_steps(const struct exchange_frame *frame, const struct exchange_zoom *zoom, double j, double *east, double *north);

/* --- sampler.c: heights at positions; a sampler for each thread --- */
struct exchange_sampler {
	struct store_reader *reader;
	const struct extent *extent;
	struct exchange_frame frame;
	const struct exchange_zoom *zoom; /* of the positions */
	bool windowed;         /* not the whole terrain is shown */
	int64_t nx, ny;
	double *x, *y;         /* positions in posts of the zoom's level */
	double *control[4];    /* i, j, x, y of the exact positions */
	size_t room, control_room, posts_room;
	double *posts;
	struct post_rect rect; /* posts around all positions; empty: none is inside */
};
enum status exchange_sampler_init(struct exchange_sampler *sampler, const struct exchange_tiles_params *params) FURROW_CHECKED;
void exchange_sampler_finish(struct exchange_sampler *sampler); /* sampler may be all zero */
/* Places samples i0 <= i < i0 + nx, j0 <= j < j0 + ny. */
enum status exchange_sampler_place(struct exchange_sampler *sampler, const struct exchange_zoom *zoom, int64_t i0, int64_t j0, int64_t nx,
				   int64_t ny) FURROW_CHECKED;
/* Reads a layer at these positions, bilinear between posts; NaN: a hole, or outside. `values`: nx * ny, rows as placed. */
enum status exchange_sampler_read(struct exchange_sampler *sampler, enum store_layer layer, double *values) FURROW_CHECKED;

/* --- png.c: square PNGs in memory --- */
struct exchange_bytes {
	uint8_t *data;
	size_t size, room;
};
enum status exchange_bytes_add(struct exchange_bytes *bytes, const void *data, size_t size) FURROW_CHECKED;
void exchange_bytes_finish(struct exchange_bytes *bytes);
/* Appends a PNG of side x side pixels. `pixels`: rows from the north, RGB, or with a palette one byte each. Palette entry 0 is transparent. */
enum status exchange_png_encode(int side, const uint8_t *pixels, const struct chart_colour *palette, struct exchange_bytes *out) FURROW_CHECKED;
/* Reads the palette indices of such a PNG. STATUS_INPUT: it is not one; the message names `path`. */
enum status exchange_png_decode(const struct exchange_bytes *in, int side, const char *path, uint8_t *indices) FURROW_CHECKED;

/* --- folder.c: the files of a folder of tiles --- */
/* Writes `bytes` to a path as PATH.part, renamed when complete; makes folders on the way. Does not touch a file that has these bytes
 * already: *written tells. */
enum status exchange_file_put(const char *path, const struct exchange_bytes *bytes, bool *written) FURROW_CHECKED;
/* Reads a file. *found is false if it is not there. `most`: bytes; a longer file counts as not there. */
enum status exchange_file_get(const char *path, size_t most, struct exchange_bytes *out, bool *found) FURROW_CHECKED;
enum status exchange_file_folder(const char *directory) FURROW_CHECKED; /* makes a folder and those above it */
enum status exchange_file_remove(const char *path, bool *removed) FURROW_CHECKED;
#define EXCHANGE_PATH 4096
/* The path of a tile's file. STATUS_INPUT: the folder's path is too long. */
enum status exchange_tile_path(const char *directory, enum exchange_set set, struct tile tile, char path[EXCHANGE_PATH]) FURROW_CHECKED;
/* Calls `fn` for each tile of a set that has a file. */
typedef enum status (*exchange_tile_fn)(void *user, struct tile tile);
enum status exchange_folder_each(const char *directory, enum exchange_set set, exchange_tile_fn fn, void *user) FURROW_CHECKED;

/* --- cover.c: heights for globes where the terrain has none; any thread reads one --- */
struct exchange_cover {
	double *heights; /* metres: posts of a level of the base, rows from the south; all are known */
	int64_t width, height;
	double spacing; /* metres */
};
enum status exchange_cover_init(struct exchange_cover *cover, const struct exchange_frame *frame, struct store_reader *reader) FURROW_CHECKED;
void exchange_cover_finish(struct exchange_cover *cover); /* cover may be all zero */
/* Returns the height, metres, at metres east and north of the south-west post, or of the nearest place within the terrain's rectangle. */
double exchange_cover_at(const struct exchange_cover *cover, double x, double y);
/* The same at degrees. `frame`: of the calling thread. */
double exchange_cover_degrees(const struct exchange_cover *cover, const struct exchange_frame *frame, double longitude, double latitude);

/* How heights are coded: the height in metres of code 0, and codes a metre. */
#define EXCHANGE_CODE_MOST 16777215
struct exchange_coding {
	double zero, parts;
};
static inline struct exchange_coding exchange_coding_of(const struct exchange_tiles_params *params, const struct store_meta *meta)
{
	/* A zero that stays whatever a drive digs: at least 256 m below the base. */
	if (params->step > 0)
		return (struct exchange_coding){1024 * floor((meta->low - 256) / 1024), 1 / params->step};
	return params->terrarium ? (struct exchange_coding){-32768, 256} : (struct exchange_coding){-10000, 10};
}
static inline const char *exchange_coding_name(const struct exchange_tiles_params *params)
{
	return params->step > 0 ? "custom" : params->terrarium ? "terrarium" : "mapbox";
}

/* --- map_tile.c and mesh_tile.c: one tile; a maker for each thread --- */
struct exchange_steps; /* of mesh tiles; shared by threads */
struct exchange_maker {
	const struct exchange_tiles_params *params;
	const struct exchange_zooms *zooms;
	struct exchange_steps *steps;
	const struct exchange_cover *cover; /* of globes */
	struct exchange_sampler sampler;
	struct exchange_mbtiles *file; /* the tiles of `only` go into it; NULL: all go into the folder */
	enum exchange_set only;
	size_t side; /* pixels along a map tile */
	struct exchange_coding coding;
	double *heights, *slopes;
	uint8_t *imagery, *posts; /* of imagery: 4 bytes each; of a tile, and of the posts under it. NULL: none yet */
	size_t posts_room;
	uint8_t *pixels, *indices;
	void *mesh;
	struct exchange_bytes bytes, packed;
	double range[2];
	struct chart_colour greys[256], colours[256]; /* palettes */
	int64_t made[EXCHANGE_SETS], written[EXCHANGE_SETS], removed;
};
enum status exchange_maker_init(struct exchange_maker *maker, const struct exchange_tiles_params *params, const struct exchange_zooms *zooms,
				struct exchange_steps *steps, const double range[2]) FURROW_CHECKED;
void exchange_maker_finish(struct exchange_maker *maker);
/* Puts maker->bytes into the file of a tile, or removes the file if they are empty. */
enum status exchange_maker_put(struct exchange_maker *maker, enum exchange_set set, struct tile tile) FURROW_CHECKED;
enum status exchange_map_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile) FURROW_CHECKED;
/* imagery_tile.c: colours, if the store has imagery. Places the sampler anew. */
enum status exchange_imagery_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile) FURROW_CHECKED;
enum status exchange_mesh_tile(struct exchange_maker *maker, const struct exchange_zoom *zoom, struct tile tile) FURROW_CHECKED;
/* Returns the palette index of an offset in metres: 0 none, 1 to 127 down, 129 to 255 up. */
uint8_t exchange_rut_index(const double range[2], double offset);
void exchange_rut_palette(struct chart_colour palette[256]);

/* Heights of mesh tiles are multiples of a power of two. The exponents of tiles that are asked for are kept. Any thread. */
enum status exchange_steps_create(struct exchange_steps **out) FURROW_CHECKED;
void exchange_steps_destroy(struct exchange_steps *steps);
bool exchange_steps_find(struct exchange_steps *steps, uint64_t key, int *exponent);
enum status exchange_steps_put(struct exchange_steps *steps, uint64_t key, int exponent) FURROW_CHECKED;

/* --- quantized.c: the bytes of a quantized-mesh tile --- */
#define EXCHANGE_SIDE (EXCHANGE_CELLS + 1)
struct exchange_quantized {
	double bounds[4];       /* degrees: west, south, east, north */
	double minimum, unit;   /* metres: height of a vertex = minimum + unit * heights[] */
	uint16_t heights[EXCHANGE_SIDE * EXCHANGE_SIDE]; /* at most 32767; rows from the south */
	float slopes[EXCHANGE_SIDE * EXCHANGE_SIDE][2]; /* rise to the east and to the north */
};
/* Appends the tile: header, vertices, triangles, edges, and the extension of oct-encoded normals. */
enum status exchange_quantized_write(const struct exchange_quantized *tile, const struct exchange_frame *frame, struct exchange_bytes *out)
	FURROW_CHECKED;

/* --- gzip.c --- */
/* Compresses all bytes; `out` is replaced. */
enum status exchange_gzip(const struct exchange_bytes *in, struct exchange_bytes *out) FURROW_CHECKED;

/* --- mbtiles.c: a set of map tiles in one SQLite file; any thread --- */
struct exchange_mbtiles;
enum status exchange_mbtiles_create(const char *path, struct exchange_mbtiles **out) FURROW_CHECKED;
void exchange_mbtiles_destroy(struct exchange_mbtiles *file); /* removes what was not published; NULL: nothing */
enum status exchange_mbtiles_put(struct exchange_mbtiles *file, struct tile tile, const struct exchange_bytes *bytes) FURROW_CHECKED;
enum status exchange_mbtiles_get(struct exchange_mbtiles *file, struct tile tile, struct exchange_bytes *out, bool *found) FURROW_CHECKED;
/* Adds a row of metadata. */
enum status exchange_mbtiles_say(struct exchange_mbtiles *file, const char *name, const char *value) FURROW_CHECKED;
enum status exchange_mbtiles_publish(struct exchange_mbtiles *file) FURROW_CHECKED;

/* --- page.c: index.html, tiles.js, layer.json, and Leaflet's files --- */
enum status exchange_page_write(const struct exchange_tiles_params *params, const struct exchange_frame *frame,
				const struct exchange_zooms *zooms, const struct exchange_tiles_result *result) FURROW_CHECKED;
/* STATUS_FAILED: Leaflet is not there. */
enum status exchange_page_check(const struct exchange_tiles_params *params) FURROW_CHECKED;

/* --- stamp.c: what a folder holds, and what of it is done --- */
struct exchange_stamp {
	char terrain[24]; /* hash of the base, in hex */
	int64_t revision;
	int64_t resets;   /* of the store until then; an earlier furrow wrote none: 0 */
	double range[2];
	uint64_t look;    /* hash of sun, exaggeration and range */
	char version[32]; /* as in exchange_tiles_result; "": an earlier furrow did not write it */
};
struct exchange_journal {
	FILE *file;
	char path[EXCHANGE_PATH];
	uint8_t *done; /* by unit */
	int64_t units, kept;
};
/* Reads the stamp of a folder. *found: it has one. */
enum status exchange_stamp_read(const char *directory, struct exchange_stamp *stamp, bool *found) FURROW_CHECKED;
enum status exchange_stamp_remove(const char *directory) FURROW_CHECKED;
enum status exchange_stamp_write(const char *directory, const struct exchange_stamp *stamp) FURROW_CHECKED;
/* Opens the journal of an export of `units` units of work. Units that an unfinished export of the same `request` has made are done
 * already. STATUS_FAILED: another export writes to the folder. */
enum status exchange_journal_begin(struct exchange_journal *journal, const char *directory, const char *request, int64_t units)
	FURROW_CHECKED;
enum status exchange_journal_add(struct exchange_journal *journal, int64_t unit) FURROW_CHECKED;
/* Removes the journal: all is done. */
enum status exchange_journal_end(struct exchange_journal *journal) FURROW_CHECKED;
void exchange_journal_finish(struct exchange_journal *journal); /* journal may be all zero */

#endif
