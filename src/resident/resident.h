/*
 * resident: the ground that is in memory. It holds base heights on the CPU, and pages of the store in slots. For kinematic models these are
 * slots of the GPU, for bearing soil slots in host memory. It also updates coarser levels, gives the newest values, and reads the map of soils.
 *
 * Loader threads read pages, and the writer thread commits them. Everything else has one owner thread, named at each part.
 */
#ifndef FURROW_RESIDENT_H
#define FURROW_RESIDENT_H

#include <stdio.h>

#include "base/base.h"
#include "base/key_map.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "resident/heights.h"
#include "resident/look_ahead.h"
#include "soil/soil.h"
#include "store/store.h"

/*
 * --- base heights ---
 *
 * A ground holds base heights on the CPU: decoded tiles of the store. It keeps the most recently used tiles. Each page loader
 * has one. Another one is used to place bodies on the ground, and to find bounds for culling.
 *
 * A ground has one owner, the thread that calls these functions. Other threads may call only the functions under "any thread"
 * below, to load tiles that the owner will need. They change when a tile is read, but never a result. If a tile is missing, the
 * owner reads it and waits.
 */
struct ground;

/* Makes a ground that keeps at most `tiles` decoded tiles (at least 1), each (cells + 1)^2 int32. Each thread that calls
 * resident_ground_warm adds memory for one tile. The store must stay open longer than the ground. */
enum status resident_ground_create(struct store *store, uint32_t tiles, struct ground **out) FURROW_CHECKED;
void resident_ground_destroy(struct ground *ground);
/* From now on it keeps at most `tiles` tiles, if that is more than before. The owner calls it. */
enum status resident_ground_grow(struct ground *ground, uint32_t tiles) FURROW_CHECKED;
struct store_reader *resident_ground_reader(struct ground *ground);
/* returns the reference height of all base heights of this store, in metres */
int32_t resident_ground_reference(const struct store *store);

/* Copies the (cells + 1)^2 base heights of a tile. What an inset does not have below level 0 is
 * interpolated, and raised by the store's relief. Units: 2^-18 m, counted from
 * resident_ground_reference. BASE_NODATA: a hole. */
enum status resident_ground_posts(struct ground *ground, struct tile tile, int32_t *posts) FURROW_CHECKED;
/* Computes the arguments of lattice_subdivide for a tile below level 0. `patch`: room for (cells +
 * 1)^2 posts. *shift is 0 where an inset lies, and where relief depends on classes: then `patch`
 * gets the tile's own posts, as resident_ground_posts gives them. */
enum status resident_ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y) FURROW_CHECKED;
/* Finds the lowest and highest base height of the tile and of all finer tiles below it, in metres. *any is false if all is
 * nodata. */
enum status resident_ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
	FURROW_CHECKED;
/* Tells if the store has this base tile: always at level >= 0, and where an inset lies below. Looked up once. */
enum status resident_ground_has_base(struct ground *ground, struct tile tile, bool *stored) FURROW_CHECKED;
/* Finds the base range of a tile of any level, as resident_ground_range does, with its error. Of
 * relief the error has three times the root mean square that finer levels add: more is rare. If no
 * other thread has loaded it, the owner reads it, and this counts as a wait. */
enum status resident_ground_base_range(struct ground *ground, struct tile tile, struct store_range *range) FURROW_CHECKED;
/* Finds how far the triangles between the tile's posts are off the ground between them, in metres, in the cell where that is most. Relief
 * and offsets do not count. `tile` is of level 0 or below. The owner may have to read the stored tiles above it. Kept once found. */
enum status resident_ground_bend(struct ground *ground, struct tile tile, double *bend) FURROW_CHECKED;
/* Returns true if the owner need not read a tile for that. Where insets lie it may be false although nothing is missing. */
bool resident_ground_has_bend(struct ground *ground, struct tile tile);
/* Finds the range of the offsets that the store has for the tile and all finer tiles below it, in metres. low <= 0 <= high. If
 * there are none, *found is false and both are 0. If no other thread has loaded the range, the owner reads it. The range stays
 * as first read, also after later commits, until resident_ground_forget_offsets(). */
enum status resident_ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
	FURROW_CHECKED;
/* Forgets all ranges of offsets, so that they are read again. A range that another thread reads meanwhile is not kept. */
void resident_ground_forget_offsets(struct ground *ground);
/* Finds a height that no base height of the rectangle exceeds, in 2^-20 m; INT64_MIN: no post has
 * data. At level >= 0 it is the highest post of the rectangle. Below level 0 it is the highest of
 * the stored posts from which the rectangle is interpolated, and what relief may add. */
enum status resident_ground_highest(struct ground *ground, int level, struct post_rect rect, int64_t *highest) FURROW_CHECKED;
/* Finds the base height at a local point; all in 2^-20 m. It is bilinear in a cell of the finest
 * level that has posts of its own there. These are level 0, an inset's, and the last one with
 * relief. *any is false outside the world, or if a corner with weight is nodata. */
enum status resident_ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
	FURROW_CHECKED;

/* --- any thread --- */

struct resident_ground_figures {
	uint64_t reads, waits; /* tiles read by any thread; tiles that the owner had to read itself */
	uint64_t ranges;       /* base ranges that any thread read without their tile */
	uint64_t offset_ranges;
	uint64_t range_waits;  /* ranges of bases and offsets that the owner had to read itself */
	double wait_ms, range_wait_ms;
};
void resident_ground_figures(struct ground *ground, struct resident_ground_figures *figures);
/* Returns the level-0 tile that contains the point (x, y), in posts of level 0. The point must be in the world. */
struct tile resident_ground_tile(const struct extent *extent, double x, double y);
struct tile resident_ground_tile_of(const struct extent *extent, int level, double x, double y); /* the same, of another level */
/* Tells what resident_ground_has_base does. What is not known yet is looked up with the caller's own reader. */
enum status resident_ground_stored(struct ground *ground, struct store_reader *reader, struct tile tile, bool *stored) FURROW_CHECKED;
/* Returns true if the tile is in memory, and marks it as just used. */
bool resident_ground_touch(struct ground *ground, struct tile tile);
/* Reads a tile that the store has, with the caller's own reader, and keeps it. The owner is not delayed. The tile replaces the least recently used
 * one, but never the one that the owner used last. On failure nothing changes. */
enum status resident_ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile) FURROW_CHECKED;

/* A range that the owner may look up: the base heights of a tile, or its offsets in the store. */
enum ground_range_kind { GROUND_BASE, GROUND_OFFSETS };
struct ground_range_key {
	enum ground_range_kind kind;
	struct tile tile;
};
/* Returns true if the range is in memory, so that the owner need not read it. */
bool resident_ground_has_range(struct ground *ground, const struct ground_range_key *key);
/* Reads a range with the caller's own reader and keeps it. For the base of a tile below level 0 it also reads the stored
 * tiles above it, from which it is interpolated. */
enum status resident_ground_warm_range(struct ground *ground, struct store_reader *reader, const struct ground_range_key *key) FURROW_CHECKED;

/*
 * --- bounds of offsets ---
 *
 * Bounds for the offsets of a tile and all finer tiles below it. Two ranges are combined: the range in the store
 * (resident_ground_offset_range), and a range of the changes since, which is kept here. Every offset lies between the lower of
 * the two lows and the higher of the two highs. Metres. One thread. Set `extent` and zero the rest before use.
 *
 * Invariant: the added range of a tile is within that of the tile above it.
 */
struct offset_bounds {
	const struct extent *extent;
	struct key_map added; /* by tile. a: lowest, b: highest; infinite: the changes are not known */
};

/* Adds a range of changes to a tile and to all coarser tiles above it. */
enum status resident_bounds_add(struct offset_bounds *bounds, struct tile tile, double low, double high) FURROW_CHECKED;
/* Widens low .. high by the range that was added to the tile. Returns false if none was added. */
bool resident_bounds_widen(const struct offset_bounds *bounds, struct tile tile, double *low, double *high);
void resident_bounds_clear(struct offset_bounds *bounds); /* removes all ranges */
void resident_bounds_finish(struct offset_bounds *bounds);

/*
 * --- map of soils ---
 *
 * What tells the soil class of each post: the values of a raster, roads over it, and rocks over these. Each loader thread has its own handle of the raster.
 */
struct soil_map;

/* A straight part of a road, metres from the south-west post. */
struct road_part {
	double from[2], to[2], half_width;
	uint8_t soil; /* index of the soil */
};

struct soil_map_params {
	const char *path;              /* of the raster; NULL: none, and its class is 0 everywhere */
	const struct road_part *parts; /* of all roads, later ones over earlier ones; read while it is opened */
	size_t part_count;
	const struct rocks *rocks;     /* over the roads; NULL: none. They outlive the map */
	uint8_t rocks_soil;            /* index of their soil */
	const uint8_t *classes;        /* 256: the index of the soil for each value of the raster */
	unsigned loaders;              /* number of loader threads; 0: only the owner reads */
	bool places;                   /* resident_soil_map_at will be called */
	const struct store_meta *meta; /* gives the place of the terrain */
};

/* Opens the map. The data that `params` points to must stay valid while the map is open. */
enum status resident_soil_map_open(const struct soil_map_params *params, struct soil_map **out) FURROW_CHECKED;
void resident_soil_map_close(struct soil_map *map); /* takes NULL */
/* Reads the soil index of each of the tile's (cells + 1)^2 posts. Call it on the thread of loader `loader`. */
enum status resident_soil_map_read(struct soil_map *map, unsigned loader, struct tile tile, uint8_t *classes) FURROW_CHECKED;
/* Reads the soil index of each post of a rectangle of a level, as loader 0 does. One thread at a
 * time. */
enum status resident_soil_map_rect(struct soil_map *map, int level, struct post_rect rect,
				   uint8_t *classes) FURROW_CHECKED;
#define SOIL_MAP_NONE (-1) /* the raster has no value there */
#define SOIL_MAP_ROAD (-2) /* a road is there */
#define SOIL_MAP_ROCK (-3) /* a rock is there */
/* Reads the raster's own value at one post of a level, as loader 0 does, or tells what is there in its place. *soil: the soil's index. One thread at a time. */
enum status resident_soil_map_value(struct soil_map *map, int level, int64_t x, int64_t y, int *value, uint8_t *soil) FURROW_CHECKED;
/* Reads the soil index of one post of a level. Only if params.places is set, and on the owner's thread. It may read the
 * raster's file. */
enum status resident_soil_map_at(struct soil_map *map, int level, int64_t x, int64_t y, uint8_t *soil) FURROW_CHECKED;

/*
 * --- rasters of soil numbers ---
 *
 * Rasters whose values are numbers of the soil: cohesion, friction angle. A post keeps a byte for each raster. 0: the raster has
 * no value there. 1 to 255: levels from the raster's least value to its greatest.
 */
#define PAGES_NUMBER_BYTES 4 /* of a post: a level of each raster */
struct soil_rasters;

struct soil_raster_params {
	const char *path;
	const char *name, *unit; /* of the number, for messages; unit NULL: none */
	double low, high;        /* allowed values of the raster's pixels */
	bool above;              /* `low` itself is not allowed */
};

struct soil_rasters_params {
	struct soil_raster_params rasters[PAGES_NUMBER_BYTES];
	int count;
	unsigned loaders;              /* number of loader threads; 0: only the owner reads */
	bool places;                   /* resident_soil_rasters_at will be called */
	const struct store_meta *meta; /* gives the place of the terrain */
};

/* Opens the rasters, and reads each whole to find its range. `meta` must stay valid while they are open. STATUS_INPUT: a raster
 * cannot be read, or has a value that is not allowed. */
enum status resident_soil_rasters_open(const struct soil_rasters_params *params, struct soil_rasters **out) FURROW_CHECKED;
void resident_soil_rasters_close(struct soil_rasters *rasters); /* takes NULL */
/* Gives the least and the greatest value of a raster, in its own unit. */
void resident_soil_rasters_range(const struct soil_rasters *rasters, int raster, double *low, double *high);
/* Reads PAGES_NUMBER_BYTES for each of the tile's (cells + 1)^2 posts. Call it on the thread of loader `loader`. */
enum status resident_soil_rasters_read(struct soil_rasters *rasters, unsigned loader, struct tile tile, uint8_t *numbers)
	FURROW_CHECKED;
/* Reads PAGES_NUMBER_BYTES of one post of a level, as loader 0 does. One thread at a time. */
enum status resident_soil_rasters_levels(struct soil_rasters *rasters, int level, int64_t x, int64_t y, uint8_t *numbers) FURROW_CHECKED;
/* Reads PAGES_NUMBER_BYTES of one post of a level. Only if params.places is set, and on the owner's thread. */
enum status resident_soil_rasters_at(struct soil_rasters *rasters, int level, int64_t x, int64_t y, uint8_t *numbers) FURROW_CHECKED;

/*
 * --- slots in host memory ---
 *
 * A slot holds one tile in host memory: base heights, planes (base/plane.h), soil classes, and levels of the soil's rasters. Memory is made when
 * it is first needed, reused, and freed at the end. A tile that nothing touched has no planes: they count as zeros.
 *
 * The image of a page that waits for a commit shares the planes of its slot, so a commit and an eviction copy nothing. Who writes a plane that an
 * image still shares gets a copy first: resident_host_write does that. A plane that is shared is never written.
 *
 * Threads. Slots belong to the owner of the page cache. Some functions may change which memory a slot has: resident_host_write,
 * resident_host_decimate, and those of pages, the cache and coarser levels. The owner alone calls them. Between two such calls any thread may
 * gather, scatter, and use the pointers of pinned slots. But no post that one thread writes may be used by another one. Loader threads fill
 * tiles of their own. These come into slots when the owner makes a page resident. The writer thread reads shared planes.
 * resident_host_figures may be called on any thread.
 */
struct host_slots;

/* Makes `count` empty slots for tiles of (cells + 1)^2 posts. `planes`: a mask of the planes that may be used; the offset is always one of
 * them. Destroy pages over the slots first. */
enum status resident_host_create(uint32_t cells, uint32_t count, unsigned planes, struct host_slots **out) FURROW_CHECKED;
void resident_host_destroy(struct host_slots *slots); /* slots may be NULL */
unsigned resident_host_planes(const struct host_slots *slots); /* returns the mask of planes that may be used */

/* What a slot has. Pointers are valid until the owner's next call as above, and are read only. */
struct host_slot {
	const int32_t *base;             /* 2^-18 m above the store's reference; NULL: no tile was ever loaded into this slot */
	const uint8_t *classes, *levels; /* a byte, and PAGES_NUMBER_BYTES, for each post; NULL: none were ever loaded */
	const void *planes[PLANES];      /* in the plane's own type; NULL: zeros */
};
void resident_host_get(const struct host_slots *slots, uint32_t slot, struct host_slot *out);
/* Makes planes of the mask ready to be written: missing ones become zeros, shared ones are copied. On failure some are not ready. */
enum status resident_host_write(struct host_slots *slots, uint32_t slot, unsigned planes) FURROW_CHECKED;
/* Returns a plane to write, in its own type. resident_host_write must have made it ready since the last commit began. */
void *resident_host_plane(struct host_slots *slots, uint32_t slot, enum plane plane);
/* Notes that posts of the slot changed, in posts of its tile, so that pictures show them. resident_pyramid_flush does it for what was
 * told to resident_pyramid_changed. */
void resident_host_changed(struct host_slots *slots, uint32_t slot, struct gpu_rect rect);

/* Copies the posts of into->rect from slots into each plane that is not NULL. `held`: every tile that has posts of the rectangle, as
 * tile_range_of gives them, in any order. Posts beyond the terrain get BASE_NODATA and zeros. Ignores into->contact. Allocates nothing. */
void resident_host_gather(const struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *into);
/* Copies the posts of `rect` within from->rect back into all of the tiles that have them. `planes`: a mask of those to copy, none of which
 * is NULL. They must be ready to be written. Allocates nothing. */
void resident_host_scatter(struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *from,
			   struct post_rect rect, unsigned planes);

/* The same two for a plane of marks that fade, whose posts are not in struct soil_planes. rows: the rectangle and the width of `into`, or of `from`. Posts of
 * no tile are 0. */
void resident_host_gather_mark(const struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *rows, enum plane plane,
			       int32_t *into);
void resident_host_scatter_mark(struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *rows, enum plane plane,
				const int32_t *from, struct post_rect rect);

/* Copies every 2^steps-th post of slot `fine` inside `rect` into slot `coarse`, as gpu_slots_decimate does. */
enum status resident_host_decimate(struct host_slots *slots, uint32_t fine, struct gpu_rect rect, int steps, uint32_t coarse,
				   uint32_t to_x, uint32_t to_y) FURROW_CHECKED;

/* What was made so far, which is also the most that existed at once. */
struct resident_host_figures {
	uint64_t bases, classes, levels, planes[PLANES];
	uint64_t base_bytes, class_bytes, level_bytes, plane_bytes[PLANES];
	uint64_t bytes;     /* of all of these */
	uint64_t decimated; /* decimations of a deformed tile */
};
void resident_host_figures(struct host_slots *slots, struct resident_host_figures *figures);
/* How many tiles in slots have a base, classes, levels and planes now, and their bytes. A plane that a slot shares with a commit counts, too. */
struct resident_host_in_slots {
	uint64_t bases, classes, levels, planes[PLANES];
	uint64_t deformed; /* tiles that have any plane */
	uint64_t base_bytes, class_bytes, level_bytes, plane_bytes[PLANES];
};
void resident_host_in_slots(const struct host_slots *slots, struct resident_host_in_slots *in);
/* Adds the plan's lines of host slots, and of images of pages, with these planes (0: nothing is deformed). Their units are PLAN_HOST_BASE and
 * those after it. An effect NULL of classes or levels: there are none. `effects`: what needs each plane. resident_pages_plan calls it. Pure. */
void resident_host_plan(uint32_t cells, unsigned planes, const char *classes_effect, const char *levels_effect,
			const char *const effects[PLANES], struct plan *plan);

/*
 * --- pages ---
 *
 * Connects store, page cache and slots. The home of a page is a slot of the GPU, or a slot in host memory (params.host). Rows, figures and
 * messages are the same.
 *
 * Loader threads read through their own grounds. The writer thread commits. The owner's thread, which is the GPU's, moves pages into slots and
 * out of them. A page of the working level has its planes if it was deformed, and the soil classes if there are any. A coarser page has
 * only the drawn planes. When it becomes resident, changes that are not committed yet are applied to it.
 */
struct pages;

/* Size of the snapshot (the "tally") that is committed with the pages. Little-endian: the soil compacted since the drive's
 * beginning, in fixed-point units (int64); the numbers of posts refused and confined (uint64 each). Then the numbers of loaded
 * contacts that sank and that slide (uint64 each). */
#define PAGES_TALLY_BYTES 40

/* How much a drive changed the sums of negative and of positive offsets, and how much soil it compacted. In fixed-point units. Then
 * in how many contacts the soil did not carry a load, or not hold it on its slope. Then how much soil was brought from outside, in fixed-point
 * units; below 0: taken. Then what is neither on the ground nor lost: what bodies carry, and what is in flight. `compacted` includes both. */
struct pages_sums {
	int64_t below, above, compacted;
	int64_t sunk, slid;
	int64_t added;
	int64_t carried, in_flight;
};

/* What a record tells of soil, in fixed-point units: added since the pages were made; aboard bodies, and in flight, at its time. */
struct pages_soil {
	int64_t added, carried, in_flight;
};

/* How the record is written that is committed with the pages, so that a drive can be resumed. The record itself is copied as
 * bytes. */
struct pages_record {
	size_t bytes;
	const char *scene_hash;
	const void *user;
	/* Gives step and time of a record. On the writer thread. */
	void (*when)(const void *record, int64_t *step, double *time);
	/* Returns the record's text, which the caller frees with mem_free; NULL: out of memory. On the writer thread. */
	char *(*print)(const void *user, const void *record, const struct pages_sums *sums);
	/* Gives the soil of a record; NULL: there is none. On the writer thread. */
	struct pages_soil (*soil)(const void *user, const void *record);
};

struct pages_params {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots; /* with params.count slots */
	/* With params.count slots: the home of pages. Then gpu and slots are those of pictures, or NULL: resident_pages_mirror. NULL: the home
	 * is `slots`. */
	struct host_slots *host;
	unsigned planes;         /* planes of the slots that are read and committed; 0: nothing is deformed, and nothing will be */
	int level;               /* the working level */
	uint32_t count, loaders;
	uint32_t step_pages;     /* most pages that one step can change; bounds the queue */
	uint32_t work_pages;     /* pages that change step after step; fewer than twice as many do not start a commit */
	uint32_t images;         /* images of changed pages that are made before a page waits for one; 0: as many as four commits have */
	uint64_t queue_bytes;    /* most bytes of images of changed pages, unless twice as many as are made without a wait are more; 0: no limit */
	struct pages_record record;
	struct pages_sums before; /* sums of this drive at the time when these pages were made */
	FILE *commit_log;           /* a line for each commit; NULL: none */
	double commit_age;        /* s after which a change is committed */
	bool commits_begun;       /* as in struct page_params */
	struct page_trace *trace; /* may be NULL */
	/* Called before a page of the working level is read back. Afterwards the page may be evicted. */
	enum status (*before_read_back)(void *user, struct tile tile, uint32_t slot);
	/* Begins to read the tally into `staging`, PAGES_TALLY_BYTES. Called on the GPU's thread when a commit begins. Tally
	 * and pages are committed as the same step left them. NULL: there is no tally. */
	enum status (*snapshot)(void *user, struct gpu_staging *staging);
	/* The same if the home is host memory: fills PAGES_TALLY_BYTES. `snapshot` is not used then. */
	enum status (*tally)(void *user, uint8_t *bytes);
	/* Fills the soil class of each post of a tile. Called on loader thread `loader`. NULL: there are no classes, and no
	 * memory is reserved for them. */
	enum status (*classes)(void *user, unsigned loader, struct tile tile, uint8_t *classes);
	/* Fills PAGES_NUMBER_BYTES for each post of a tile of the working level. On loader thread `loader`. NULL: there are none. */
	enum status (*numbers)(void *user, unsigned loader, struct tile tile, uint8_t *numbers);
	/* true: classes are loaded for tiles of the working level and all coarser ones; false: only for the working level */
	bool classes_drawn;
	/* On the GPU's thread, before a commit takes the record; may be NULL. */
	enum status (*begin_commit)(void *user);
	/* On the writer thread, before each commit, which fails if this fails; may be NULL. */
	enum status (*before_commit)(void *user);
	void *user; /* passed to all functions above */
};

/* The most bytes that pages can use: planes in slots, images for loads, images of changed pages, and base tiles that loaders
 * keep. */
struct resident_pages_budget {
	uint64_t slots, loads, queue, ground;
	/* Part of `queue`: so many images are made before a page waits for the commit in flight. More are made only if that was not enough. */
	uint64_t queue_few;
	uint32_t images_few;
};

/* How many rows of the store were read for pages, and how many rows commits changed. */
struct pages_counts {
	int64_t loaded, loaded_coarser;       /* tiles whose planes were read: of the working level, and coarser ones */
	int64_t bases, ranges;                /* bases read for pages, and ranges of bases */
	/* tiles of the working level that were committed, and coarser tiles updated with them */
	int64_t committed, committed_coarser;
	int64_t changed[PLANES];              /* rows that were written or removed */
	int64_t looked_up[PLANES];            /* rows of the soil's state that commits looked up */
	int64_t header;                       /* entries of the header that were written */
};

struct resident_pages_io {
	int64_t commits, tiles_read, tiles_written, bytes_read, bytes_written;
	int64_t step;           /* of the last commit; 0 if there is none */
	struct pages_sums sums; /* sums of the whole drive */
	double load_ms, readback_ms, writeback_ms;
	uint64_t host_bytes; /* bytes of all images made so far, which are kept until the end; with a home in host memory also of its slots */
	uint64_t changed_images; /* images made so far for changed pages */
	struct pages_counts counts;
};

/* What decides the plan of a drive's pages. Effects are names for the plan's lines. */
struct pages_planned {
	uint32_t cells;      /* of the store's tiles */
	unsigned planes;     /* as in pages_params */
	uint32_t loaders;
	bool was_deformed;   /* the store was deformed before the drive */
	bool history;        /* the store has a history, or the drive keeps one */
	bool inherits;       /* the store is an overlay, whose rows may be in a file under it */
	bool deforms;        /* there are bodies */
	bool lowers;         /* there are bodies, and they only lower the ground */
	bool classes;        /* there is a map of soils */
	bool numbers;        /* there are rasters of soil numbers */
	bool picture;        /* pictures are drawn */
	bool host;           /* the home of pages is host memory */
	const char *loaders_effect, *classes_effect, *numbers_effect, *picture_effect;
};
/* Adds the plan's lines of a drive's pages: threads, staging or planes in host memory, and statements. This includes lines of the ground and the view
 * with the same counts. Call it after deform_plan, which notes the effect that needs each plane. Pure. */
void resident_pages_plan(const struct pages_planned *planned, struct plan *plan);
/* Gives the most bytes that pages with these parameters can use, for tiles of `cells` cells. Ignores store, gpu, slots and host.
 * Pure. */
void resident_pages_budget(const struct pages_params *params, uint32_t cells, struct resident_pages_budget *budget);
enum status resident_pages_create(const struct pages_params *params, struct pages **out) FURROW_CHECKED;
/* Stops the threads and frees everything. Commits nothing. */
void resident_pages_destroy(struct pages *pages);
/* Stops the threads, so that figures are final. Afterwards call only resident_pages_io and resident_pages_destroy. */
void resident_pages_stop(struct pages *pages);
struct page_cache *resident_pages_cache(struct pages *pages);
/* Marks the committed state, so that resident_pages_rollback can restore it. Replaces the earlier mark, which stays on failure. Call it
 * between two steps, after page_cache_flush. */
enum status resident_pages_mark(struct pages *pages) FURROW_CHECKED;
/* Restores the store, the sums and the pages to the mark. Pages that changed since are dropped. Call it between two steps. On
 * failure nothing changes. */
enum status resident_pages_rollback(struct pages *pages) FURROW_CHECKED;
/* Drops all pages: another process has changed the store, which is only read here. Call it between two steps. On failure some may stay. */
enum status resident_pages_forget(struct pages *pages) FURROW_CHECKED;
void resident_pages_io(struct pages *pages, struct resident_pages_io *io);
/*
 * Pictures of pages whose home is host memory. Slots of the GPU mirror them, with the same numbers. They need not have other planes than the
 * drawn ones.
 *
 * resident_pages_mirror sets the GPU and its slots; NULL: there are none from now on. resident_pages_show brings the slot of a resident page up to
 * date, before it is drawn. It uploads the base and drawn classes once after a load. Of drawn planes it uploads the rectangle that changed
 * since the last time. `planes` false: only the base is needed, so planes stay as they are. It does nothing if the home is the GPU. Call both on the owner's thread, the second between two steps, after resident_pyramid_flush.
 */
void resident_pages_mirror(struct pages *pages, struct gpu *gpu, struct gpu_slots *slots);
enum status resident_pages_show(struct pages *pages, uint32_t slot, bool planes) FURROW_CHECKED;
/* Returns true if the tile in the slot is deformed, wherever its home is. */
bool resident_pages_is_deformed(const struct pages *pages, uint32_t slot);
/* A file with a row for each step at whose end there was a commit: time (s), step, and three volumes (m3). These are what the whole drive removed,
 * raised and compacted until then. */
struct resident_volume {
	FILE *file;
	double unit;       /* m3 of a fixed-point unit */
	int64_t step, row; /* of the last row: its step, and the byte of the file where it begins. step -1: there is no row */
};
/* From now on writes a row into the file after each commit. It replaces the last row if that is of the same step. The file must outlive the
 * pages' threads. Call it before the first commit. */
void resident_pages_volume(struct pages *pages, const struct resident_volume *volume);
/*
 * Pages that move to another process, between two steps, as page_cache_take and page_cache_put do. `bytes`: resident_pages_moved_bytes()
 * bytes, each plane of params.planes in turn. `planes`: those that the tile has; 0: it is not deformed, and there are no bytes.
 */
size_t resident_pages_moved_bytes(const struct pages *pages);
typedef enum status (*pages_taken_fn)(void *user, struct tile tile, unsigned planes, const void *bytes);
enum status resident_pages_take(struct pages *pages, const uint64_t *keys, size_t count, pages_taken_fn fn, void *user) FURROW_CHECKED;
/* planes 0: all planes become 0. */
enum status resident_pages_put(struct pages *pages, struct tile tile, unsigned planes, const void *bytes) FURROW_CHECKED;
/* Lets `fn` change the newest planes of a tile of the working level, wherever its home is, between two steps. `planes`: the posts of each plane of
 * params.planes, zeros where the tile has none; NULL for other planes. Afterwards the page has changed, and is in no slot. On failure the tile may have
 * lost what was not committed. */
typedef void (*pages_edit_fn)(void *user, struct tile tile, void *const planes[PLANES]);
enum status resident_pages_edit(struct pages *pages, struct tile tile, pages_edit_fn fn, void *user) FURROW_CHECKED;

/*
 * --- coarser levels ---
 *
 * Updates resident coarser tiles, where their home is, when posts of the working level change. That is the level which bodies deform. The
 * changes of a step are collected as one rectangle for each tile. Each rectangle is decimated once, before a coarser tile is read or a changed tile leaves its slot.
 */
struct pyramid;

/* The home of pages is `host`, or the GPU's `slots` if that is NULL. */
enum status resident_pyramid_create(const struct extent *extent, int level, struct gpu_slots *slots, struct host_slots *host,
				    struct pyramid **out) FURROW_CHECKED;
void resident_pyramid_destroy(struct pyramid *pyramid);
/* Notes that the posts of `rect` (global coordinates) changed in this tile. */
enum status resident_pyramid_changed(struct pyramid *pyramid, struct tile tile, struct post_rect rect) FURROW_CHECKED;
/* Updates the resident coarser tiles above this tile. Does nothing if the tile did not change. */
enum status resident_pyramid_flush_tile(struct pyramid *pyramid, struct page_cache *cache, struct tile tile, uint32_t slot)
	FURROW_CHECKED;
/* Updates the coarser tiles above all changed tiles. Call it at the end of a step. */
enum status resident_pyramid_flush(struct pyramid *pyramid, struct page_cache *cache) FURROW_CHECKED;
/* Forgets all noted changes, after a rollback. pyramid may be NULL. */
void resident_pyramid_forget(struct pyramid *pyramid);
struct resident_pyramid_figures {
	uint64_t updated, resident; /* coarser tiles that were updated, and that were resident; both summed over the steps */
};
void resident_pyramid_figures(const struct pyramid *pyramid, struct resident_pyramid_figures *figures);

/*
 * --- newest values ---
 *
 * Queries of the present ground (resident/heights.h): the base, and the newest planes of each tile. The newest planes may be in
 * a slot, in the queue for the next commit, or in the store.
 *
 * For a running drive: call it on the drive's thread, between two steps. A query only reads. It pins, loads and uses no page of
 * the cache; it has its own reader of the store and its own tiles. So queries never change the results of a drive.
 *
 * For a store without a drive: any one thread, without GL. Commits that another process makes meanwhile may be seen or not.
 *
 * Tiles and ranges that were read are kept: about 32 MB of tiles, at least 4, or as many as resident_newest_keep tells. If a tile is dirty in its slot, it is read
 * there. From a slot of a hardware GPU this waits for all earlier GPU work; from host memory it waits for nothing. It happens once for each
 * tile until the ground changes.
 */
struct newest;

/* `pages` NULL: reads only the store. Store and pages must stay valid longer than `newest`. */
enum status resident_newest_create(struct store *store, struct pages *pages, struct newest **out) FURROW_CHECKED;
void resident_newest_destroy(struct newest *newest); /* newest may be NULL */
#define RESIDENT_NEWEST_LEAST 4 /* tiles that it keeps at least */
uint32_t resident_newest_tiles(uint32_t cells); /* tiles that it keeps from its creation on */
uint64_t resident_newest_tile_bytes(uint32_t cells);
uint64_t resident_newest_base_bytes(uint32_t cells); /* of what it keeps beside them */
/* From now on it keeps at most so many tiles, at least RESIDENT_NEWEST_LEAST. With fewer than before all are dropped. */
enum status resident_newest_keep(struct newest *newest, uint32_t tiles) FURROW_CHECKED;
/* Notes that the ground has changed since the last query. May be called inside a step. newest may be NULL. */
void resident_newest_changed(struct newest *newest);
enum status resident_newest_heights(struct newest *newest, const struct resident_point *points, size_t count, struct resident_height *heights)
	FURROW_CHECKED;
enum status resident_newest_rays(struct newest *newest, const struct resident_ray *rays, size_t count, struct resident_hit *hits) FURROW_CHECKED;
/*
 * Reads the posts of a rectangle of any level, row by row from the south-west. Units are those of store_read_posts. So are the
 * values at levels finer or coarser than those that the layer has. NaN: nodata, or outside the terrain. Keeps nothing in
 * memory.
 */
enum status resident_read_posts(struct newest *newest, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

/*
 * The ground of one terrain in memory: the store and all that is between it and who reads or changes the ground. world makes the parts one after
 * the other, and frees them. Pictures, reports and queries reach them here. A part that a run has no use for is NULL.
 */
struct resident {
	struct store *store;
	const struct store_meta *meta;
	int level;                         /* the working level */
	double spacing;                    /* m, of the working level */
	bool was_deformed;                 /* the store was deformed before it was opened */
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct host_slots *host;           /* where the CPU computes: the home of pages */
	struct ground *ground;
	struct soil_map *soil_map;         /* NULL: one soil */
	struct soil_rasters *soil_rasters; /* NULL: every number is that of a post's soil */
	struct pages *pages;
	struct page_cache *cache;
	struct page_trace *trace;          /* NULL: no trace was asked for */
	struct pyramid *pyramid;           /* NULL: coarser levels are not used */
	struct newest *newest;             /* NULL until the first query */
};

#endif
