/*
 * resident: the ground that is in memory. It holds base heights on the CPU, and the pages of the store in slots of the GPU. It
 * also updates coarser levels, finds the newest values, and reads the map of soils.
 *
 * Pages are read by loader threads and committed by the writer thread. Everything else has one owner, named at each part.
 */
#ifndef FURROW_RESIDENT_H
#define FURROW_RESIDENT_H

#include <stdio.h>

#include "base/base.h"
#include "base/key_map.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "store/store.h"
#include "terrain/terrain.h"

/*
 * --- base heights ---
 *
 * The base heights on the CPU: decoded tiles of levels >= 0. The tiles used last are kept. Page loaders use one each. Others
 * set bodies upon the ground with it and find bounds for culling.
 *
 * A ground has one owner, the thread that calls these functions. Other threads call only the last few, to load what the owner
 * will need. This changes when a tile is read, never what the owner finds. The owner reads a missing tile itself, and waits.
 */
struct ground;

/* Makes a ground that keeps up to `tiles` decoded tiles, at least 1, each (cells + 1)^2 int32. Each thread that warms it adds
 * one tile. The store must outlive it. */
enum status resident_ground_create(struct store *store, uint32_t tiles, struct ground **out) FURROW_CHECKED;
void resident_ground_destroy(struct ground *ground);
struct store_reader *resident_ground_reader(struct ground *ground);
int32_t resident_ground_reference(const struct store *store); /* metres: the reference of all bases of this store */

/* Copies the (cells + 1)^2 posts of a tile of level >= 0, relative to the reference. */
enum status resident_ground_posts(struct ground *ground, struct tile tile, int32_t *posts) FURROW_CHECKED;
/* Finds the arguments of lattice_subdivide for a tile below level 0. `patch`: room for (cells + 1)^2. */
enum status resident_ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y) FURROW_CHECKED;
/* Finds the lowest and highest base of the tile's subtree, metres. *any false: all of it is nodata. */
enum status resident_ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
	FURROW_CHECKED;
/* Finds the base range of a tile from level 0 up. If no other thread brought it, the owner reads it, and this counts as a
 * wait. */
enum status resident_ground_base_range(struct ground *ground, struct tile tile, struct store_range *range) FURROW_CHECKED;
/* Finds the lowest (0 or less) and highest (0 or more) offset that the store has of the tile's subtree, metres. *found false: it
 * has none, and both are 0. The owner waits as above. The range stays as first read, whatever is committed later. */
enum status resident_ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
	FURROW_CHECKED;
/* Forgets all offset ranges, so that they are read anew. */
void resident_ground_forget_offsets(struct ground *ground);
/* Finds an absolute height that no base of the rectangle exceeds, 2^-20 m; INT64_MIN: no post has data. Below level 0 it is the
 * highest post of level 0 that the rectangle is interpolated from; otherwise the rectangle's own highest post. */
enum status resident_ground_highest(struct ground *ground, int level, struct post_rect rect, int64_t *highest) FURROW_CHECKED;
/* Finds the absolute base height at a local point, all in 2^-20 m, bilinear in the level-0 cell. *any false: outside the world,
 * or a corner with weight is nodata. */
enum status resident_ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
	FURROW_CHECKED;

/* --- any thread --- */

struct resident_ground_figures {
	uint64_t reads, waits; /* tiles read by any thread; those that the owner read itself */
	uint64_t ranges;       /* ranges of bases, read without a tile by any thread */
	uint64_t offset_ranges;
	uint64_t range_waits;  /* ranges of both kinds that the owner read */
	double wait_ms, range_wait_ms;
};
void resident_ground_figures(struct ground *ground, struct resident_ground_figures *figures);
/* Returns the level-0 tile that gives the height at (x, y), in posts of level 0. Only inside the world. */
struct tile resident_ground_tile(const struct extent *extent, double x, double y);
/* Returns true if the tile is kept, and marks it as just used. */
bool resident_ground_touch(struct ground *ground, struct tile tile);
/* Reads a tile with the caller's own reader and keeps it. Does not hold up the owner. It replaces the tile used longest ago,
 * never the one the owner used last. On failure nothing changes. */
enum status resident_ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile) FURROW_CHECKED;

/* A range that the owner looks up: of a tile's base, or of its offsets in the store. */
enum ground_range_kind { GROUND_BASE, GROUND_OFFSETS };
struct ground_range_key {
	enum ground_range_kind kind;
	struct tile tile;
};
/* Returns true if the owner could look up this range now without reading. */
bool resident_ground_has_range(struct ground *ground, const struct ground_range_key *key);
/* Reads a range with the caller's own reader and keeps it. For a base below level 0 it also reads the tile it comes from. */
enum status resident_ground_warm_range(struct ground *ground, struct store_reader *reader, const struct ground_range_key *key) FURROW_CHECKED;

/*
 * --- bounds of offsets ---
 *
 * Every offset of a tile's subtree is within one of two ranges, or between them. The store had the first one
 * (resident_ground_offset_range). The owner of these bounds has added the second one since. Metres. One thread. Starts with only
 * the extent set.
 *
 * Invariant: the added range of a tile is within that of the tile above it.
 */
struct offset_bounds {
	const struct extent *extent;
	struct key_map added; /* by tile. a: lowest, b: highest; infinite: it is not known what changed */
};

/* Adds a range to a tile and to all tiles above it. */
enum status resident_bounds_add(struct offset_bounds *bounds, struct tile tile, double low, double high) FURROW_CHECKED;
/* Widens a range by what was added to the tile. Returns false if nothing was. */
bool resident_bounds_widen(const struct offset_bounds *bounds, struct tile tile, double *low, double *high);
void resident_bounds_clear(struct offset_bounds *bounds); /* removes all that was added */
void resident_bounds_finish(struct offset_bounds *bounds);

/*
 * --- map of soils ---
 *
 * A raster that says which class each post is of. Each loader thread has its own handle on it.
 */
struct soil_map;

struct soil_map_params {
	const char *path;              /* of the raster */
	const uint8_t *classes;        /* 256: the index of the soil for each value of the raster */
	unsigned loaders;              /* 0: one thread, the owner, reads */
	bool places;                   /* resident_soil_map_at will be asked */
	const struct store_meta *meta; /* where the terrain lies */
};

/* Opens the map. What `params` points to must outlive it. */
enum status resident_soil_map_open(const struct soil_map_params *params, struct soil_map **out) FURROW_CHECKED;
void resident_soil_map_close(struct soil_map *map); /* takes NULL */
/* Reads the soil's index of each of (cells + 1)^2 posts. On the thread of loader `loader`. */
enum status resident_soil_map_read(struct soil_map *map, unsigned loader, struct tile tile, uint8_t *classes) FURROW_CHECKED;
/* Reads the soil of one post of a level. Only if params say `places`, and on the owner's thread. It may read the raster's file. */
enum status resident_soil_map_at(struct soil_map *map, int level, int64_t x, int64_t y, uint8_t *soil) FURROW_CHECKED;

/*
 * --- pages ---
 *
 * Connects store, page cache and GPU: it defines what the bytes of a page mean.
 *
 * Loader threads read through a ground of their own. The writer thread commits. The GPU's thread uploads and reads back. A page
 * of the working level carries its planes if it was deformed, and the classes of soil if there are any. A coarser page has only
 * the planes that are drawn. When it becomes resident, changes that are not committed are laid over it.
 */
struct pages;

/* The bytes of the snapshot that goes with a commit, little-endian. First what was compacted since the drive's beginning, in
 * fixed-point units (int64). Then the numbers of posts that were refused and confined (uint64 each). */
#define PAGES_TALLY_BYTES 24

/* By how much a drive changed the sums of offsets below and above zero, and how much it compacted. All in fixed-point units. */
struct pages_sums {
	int64_t below, above, compacted;
};

/* The record that goes with each commit, so that a drive can be resumed. Pages copy it and do not look inside. */
struct pages_record {
	size_t bytes;
	const char *scene_hash;
	const void *user;
	/* On the writer thread: tells step and time of a record. */
	void (*when)(const void *record, int64_t *step, double *time);
	/* On the writer thread: returns the record's text, to free with mem_free; NULL: out of memory. */
	char *(*print)(const void *user, const void *record, const struct pages_sums *sums);
};

struct pages_params {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots; /* of params.count slots */
	unsigned planes;         /* planes of the slots that are read and committed; 0: nothing is or will be deformed */
	int level;               /* the working level */
	uint32_t count, loaders;
	uint32_t step_pages;     /* most pages one step can change, which bounds the queue */
	struct pages_record record;
	struct pages_sums before; /* sums of this drive before these pages were made */
	FILE *commit_log;           /* a line for each commit; NULL: none */
	double commit_age;        /* s */
	struct page_trace *trace; /* may be NULL */
	/* Called before a page of the working level is read back. After that the page may leave its slot. */
	enum status (*before_read_back)(void *user, struct tile tile, uint32_t slot);
	/* On the GPU's thread, when a commit begins: begins to read the tally into `staging`, PAGES_TALLY_BYTES. It is
	 * committed with the pages as the same step left them. NULL: there is no tally. */
	enum status (*snapshot)(void *user, struct gpu_staging *staging);
	/* On a loader thread, by its number: fills the class of soil of each post of a tile. NULL: there are no classes, and no
	 * memory is made for them. */
	enum status (*classes)(void *user, unsigned loader, struct tile tile, uint8_t *classes);
	bool classes_drawn; /* classes are loaded for all tiles at and above the working level, not only for those at it */
	/* On the GPU's thread, before a commit takes the record; may be NULL. */
	enum status (*begin_commit)(void *user);
	/* On the writer thread, before each commit, which fails if this fails; may be NULL. */
	enum status (*before_commit)(void *user);
	void *user; /* passed to all functions above */
};

/* Bytes used at most: planes in slots, images for loads, images of changed pages, and base tiles that loaders keep. */
struct resident_pages_budget {
	uint64_t slots, loads, queue, ground;
	uint64_t queue_few; /* of the queue, if no step changes more pages than a commit waits for */
};

/* Rows of the store that were read for pages, and rows that commits changed. */
struct pages_counts {
	int64_t loaded, loaded_coarser;       /* tiles whose planes were read: of the working level, and coarser ones */
	int64_t bases, ranges;                /* bases read for pages, and ranges of bases */
	int64_t committed, committed_coarser; /* tiles of the working level in commits, and coarser tiles that followed */
	int64_t changed[PLANES];              /* rows that were written or removed */
	int64_t looked_up[PLANES];            /* rows of the soil's state that commits looked up */
	int64_t header;                       /* entries of the header that were written */
};

struct resident_pages_io {
	int64_t commits, tiles_read, tiles_written, bytes_read, bytes_written;
	struct pages_sums sums; /* sums of the whole drive */
	double load_ms, readback_ms, writeback_ms;
	uint64_t host_bytes; /* bytes of images made so far; images are kept */
	uint64_t changed_images; /* images made so far for changed pages */
	struct pages_counts counts;
};

/* The facts that decide the plan of a drive's pages. Effects are names for the plan's lines. */
struct pages_planned {
	uint32_t cells;      /* of the store's tiles */
	unsigned planes;     /* as in pages_params */
	uint32_t loaders;
	bool was_deformed;   /* the store was deformed before the drive */
	bool deforms;        /* there are bodies */
	bool lowers;         /* there are bodies, and they only lower the ground */
	bool classes;        /* there is a map of soils */
	bool picture;        /* somebody draws */
	const char *loaders_effect, *classes_effect, *picture_effect;
};
/* Adds the lines of a drive's pages: threads, staging and statements. Lines of the ground and the view that use the same counts
 * are among them. Call it after deform_plan, whose planes say which effect calls for them. Pure. */
void resident_pages_plan(const struct pages_planned *planned, struct plan *plan);
/* Tells what pages with these parameters use at most, for tiles of `cells` cells. Ignores store, gpu and slots. Pure. */
void resident_pages_budget(const struct pages_params *params, uint32_t cells, struct resident_pages_budget *budget);
enum status resident_pages_create(const struct pages_params *params, struct pages **out) FURROW_CHECKED;
/* Stops the threads and frees everything. Commits nothing. */
void resident_pages_destroy(struct pages *pages);
/* Stops the threads, so that figures are complete. After it call only resident_pages_io and resident_pages_destroy. */
void resident_pages_stop(struct pages *pages);
struct page_cache *resident_pages_cache(struct pages *pages);
/* Marks the committed state as the one that resident_pages_rollback goes back to. Replaces the mark before. Call it between two
 * steps, after page_cache_flush. */
enum status resident_pages_mark(struct pages *pages) FURROW_CHECKED;
/* Goes back to the mark: the store, the sums and the pages. Pages that changed since are dropped. Call it between two steps. On
 * failure nothing changes. */
enum status resident_pages_rollback(struct pages *pages) FURROW_CHECKED;
void resident_pages_io(struct pages *pages, struct resident_pages_io *io);

/*
 * --- coarser levels ---
 *
 * Keeps resident coarser tiles up to date with changes of the working level, on the GPU. The changes of a step are gathered as
 * one rectangle for each tile. They are decimated once, before anybody reads the tile or it leaves its slot.
 */
struct pyramid;

enum status resident_pyramid_create(const struct extent *extent, int level, struct gpu_slots *slots, struct pyramid **out)
	FURROW_CHECKED;
void resident_pyramid_destroy(struct pyramid *pyramid);
/* Says that the posts of `rect` (global) changed in this tile. */
enum status resident_pyramid_changed(struct pyramid *pyramid, struct tile tile, struct post_rect rect) FURROW_CHECKED;
/* Brings the tile's resident ancestors up to date. Does nothing if the tile did not change. */
enum status resident_pyramid_flush_tile(struct pyramid *pyramid, struct page_cache *cache, struct tile tile, uint32_t slot)
	FURROW_CHECKED;
/* Brings the ancestors of all changed tiles up to date. Call it at the end of a step. */
enum status resident_pyramid_flush(struct pyramid *pyramid, struct page_cache *cache) FURROW_CHECKED;
/* Forgets all changes, after a rollback. Takes NULL. */
void resident_pyramid_forget(struct pyramid *pyramid);
struct resident_pyramid_figures {
	uint64_t updated, resident; /* coarser tiles that were updated, and that were resident; both summed over the steps */
};
void resident_pyramid_figures(const struct pyramid *pyramid, struct resident_pyramid_figures *figures);

/*
 * --- newest values ---
 *
 * The ground as it is now, for queries (terrain/terrain.h): the base and the newest planes of each tile. The newest planes are
 * in a slot, in the queue for the next commit, or in the store.
 *
 * Over a running drive: on the drive's thread, between two steps. It reads, and changes nothing else. It pins, loads and uses
 * no page of the cache, and has its own reader of the store and its own tiles. So queries never change the bits of a drive.
 *
 * Over a store alone: on any one thread, without GL. Commits of another process in the meantime may or may not be seen.
 *
 * It keeps what it read: about 32 MB of tiles, at least 4 tiles, and ranges. A tile that is dirty in its slot is read back from
 * there. On a hardware GPU this waits for all work begun before. It happens once for each tile until the ground changes.
 */
struct newest;

/* `pages` NULL: reads the store alone. Both must outlive it. */
enum status resident_newest_create(struct store *store, struct pages *pages, struct newest **out) FURROW_CHECKED;
void resident_newest_destroy(struct newest *newest); /* takes NULL */
/* Says that the ground has changed since the last query. It may be called inside a step. Takes NULL. */
void resident_newest_changed(struct newest *newest);
enum status resident_newest_heights(struct newest *newest, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status resident_newest_rays(struct newest *newest, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;
/*
 * Reads the posts of a rectangle of any level, row by row from the south-west. store_read_posts gives the units. It also says
 * what each layer holds at levels finer or coarser than its own. NaN: no data, or outside the terrain. Keeps nothing.
 */
enum status resident_read_posts(struct newest *newest, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

#endif
