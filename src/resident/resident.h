/*
 * resident: the ground that is in memory. Base heights on the CPU, the pages of the store in slots of the GPU and back, the
 * coarser levels of what changed, the newest values wherever they are, and the map of soils.
 *
 * Pages are read by loader threads and committed by the writer thread. All else has one owner, said at each part.
 */
#ifndef FURROW_RESIDENT_H
#define FURROW_RESIDENT_H

#include <stdio.h>

#include "base/base.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "store/store.h"
#include "terrain/terrain.h"

/*
 * --- base heights ---
 *
 * The base as the lattice has it, on the CPU: decoded tiles of levels >= 0, the last used of them kept. For the
 * page loaders (one each), for resting objects on the ground, and for bounds to cull by.
 *
 * A ground has one owner, the thread that calls all of this but the last few functions. With those others bring
 * what the owner will ask for: they change when a tile is read, never what is found. What is not there the owner
 * reads itself, and waits.
 */
struct ground;

/* Keeps up to `tiles` decoded tiles, at least 1, of (cells + 1)^2 int32 each, and one more for each thread that
 * warms it. The store must outlive it. */
enum status resident_ground_create(struct store *store, uint32_t tiles, struct ground **out) FURROW_CHECKED;
void resident_ground_destroy(struct ground *ground);
struct store_reader *resident_ground_reader(struct ground *ground);
int32_t resident_ground_reference(const struct store *store); /* metres, of all bases of this store */

/* Copies the (cells + 1)^2 posts, relative to the reference. level >= 0. */
enum status resident_ground_posts(struct ground *ground, struct tile tile, int32_t *posts) FURROW_CHECKED;
/* The arguments of lattice_subdivide for a tile below level 0. `patch`: room for (cells + 1)^2. */
enum status resident_ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y) FURROW_CHECKED;
/* Lowest and highest base of the tile's subtree, metres; *any false if all is nodata. */
enum status resident_ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
	FURROW_CHECKED;
/* What the store has of a tile from level 0 up, and of the offsets of any tile. The owner reads what no other thread brought, and
 * that is counted as a wait. Offsets that were brought are of the time when they were. */
enum status resident_ground_base_range(struct ground *ground, struct tile tile, struct store_range *range) FURROW_CHECKED;
enum status resident_ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
	FURROW_CHECKED;
/* No post of the rectangle, of any level, has a higher base than this, 2^-18 m from the reference. Below level 0 that is the
 * highest of the posts of level 0 they are interpolated from, else their own highest. *any false: none has data. */
enum status resident_ground_highest(struct ground *ground, int level, struct post_rect rect, int32_t *highest, bool *any)
	FURROW_CHECKED;
/* Height at a point (quanta of 2^-20 m, local, absolute height), bilinear in the level-0 cell.
 * *any false outside the world and where a corner with weight is nodata. */
enum status resident_ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
	FURROW_CHECKED;

/* --- any thread --- */

struct resident_ground_figures {
	uint64_t reads, waits; /* tiles read by whoever, and those of them that the owner read itself */
	uint64_t ranges;       /* of bases, read without a tile by whoever */
	uint64_t offset_ranges;
	uint64_t range_waits;  /* of both, read by the owner */
	double wait_ms, range_wait_ms;
};
void resident_ground_figures(struct ground *ground, struct resident_ground_figures *figures);
/* The level-0 tile whose posts a height at (x, y), in posts of level 0, comes from. Within the world only. */
struct tile resident_ground_tile(const struct extent *extent, double x, double y);
/* Whether it is there; if so it is kept as one just used. */
bool resident_ground_touch(struct ground *ground, struct tile tile);
/* Puts a tile there, read with the caller's own reader and without holding the owner up. In its place goes the one
 * used longest ago, never the owner's last. On failure nothing changed. */
enum status resident_ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile) FURROW_CHECKED;

/* A range that a look-up needs: of a tile's base, or of its offsets as the store has them. */
enum ground_range_kind { GROUND_BASE, GROUND_OFFSETS };
struct ground_range_key {
	enum ground_range_kind kind;
	struct tile tile;
};
/* Returns true if the owner's look-up of this range reads nothing now. */
bool resident_ground_has_range(struct ground *ground, const struct ground_range_key *key);
/* Brings a range, read with the caller's own reader; of a base below level 0, also the tile it comes from. */
enum status resident_ground_warm_range(struct ground *ground, struct store_reader *reader, const struct ground_range_key *key) FURROW_CHECKED;

/*
 * --- map of soils ---
 *
 * A raster that says which class each post is of. Each loader thread has its own handle on it.
 */
struct soil_map;

struct soil_map_params {
	const char *path;              /* of the raster */
	const uint8_t *classes;        /* 256: the index of the soil that each value of the raster stands for */
	unsigned loaders;              /* 0: one thread, the owner, reads */
	bool places;                   /* resident_soil_map_at will be asked */
	const struct store_meta *meta; /* where the terrain lies */
};

/* What params point to must outlive it. */
enum status resident_soil_map_open(const struct soil_map_params *params, struct soil_map **out) FURROW_CHECKED;
void resident_soil_map_close(struct soil_map *map); /* takes NULL */
/* Loader `loader`'s thread: indices of soils, (cells + 1)^2. */
enum status resident_soil_map_read(struct soil_map *map, unsigned loader, struct tile tile, uint8_t *classes) FURROW_CHECKED;
/* The soil of one post of a level, if params say `places`. Only the owner's thread. It may read the raster's file. */
enum status resident_soil_map_at(struct soil_map *map, int level, int64_t x, int64_t y, uint8_t *soil) FURROW_CHECKED;

/*
 * --- pages ---
 *
 * The adaptor between store, page cache and GPU: what a page's bytes mean.
 *
 * Loader threads read through a ground of their own; the writer thread commits epochs; the GPU's
 * thread uploads and reads back. A page of the working level carries its planes when it was
 * deformed, and classes of soil where there are such; a coarser page, which has the planes that are drawn, is
 * overlaid, when it becomes resident, with what is not committed.
 */
struct pages;

/* What an epoch's snapshot holds, little-endian: quanta that were compacted since the drive's beginning
 * (int64), posts that refused and that confined (uint64 each). */
#define PAGES_TALLY_BYTES 24

/* What a drive changed the sums of offsets below and above zero by, and what it compacted: quanta. */
struct pages_sums {
	int64_t below, above, compacted;
};

/* What goes with each epoch so that a drive can go on from there. Pages copy it and do not look inside. */
struct pages_record {
	size_t bytes;
	const char *scene_hash;
	const void *user;
	/* The writer thread. */
	void (*when)(const void *record, int64_t *step, double *time);
	/* The writer thread: its text, for mem_free; NULL: out of memory. */
	char *(*print)(const void *user, const void *record, const struct pages_sums *sums);
};

struct pages_params {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots; /* of params.count slots */
	unsigned planes;         /* of the slots' that are read and committed; 0: nothing is or will be deformed */
	int level;               /* the working level */
	uint32_t count, loaders;
	uint32_t step_pages;     /* most pages one step can change, for the queue's bound */
	struct pages_record record;
	struct pages_sums before; /* of this drive, before these pages were made */
	FILE *epochs;            /* a line for each commit; NULL: none */
	double epoch_age;        /* s */
	struct page_trace *trace; /* may be NULL */
	/* Called before a page of the working level is read back: it may leave its slot after. */
	enum status (*before_read_back)(void *user, struct tile tile, uint32_t slot);
	/* The GPU's thread, when an epoch begins: begins to read the tally, as the step left it, into the staging's
	 * PAGES_TALLY_BYTES; it is committed with what that step left in the pages. NULL: there is none. */
	enum status (*snapshot)(void *user, struct gpu_staging *staging);
	/* A loader thread, of which each has its number: the class of soil of every post of a tile. NULL: there are no classes, and nothing is made for them. */
	enum status (*classes)(void *user, unsigned loader, struct tile tile, uint8_t *classes);
	bool classes_drawn; /* of all tiles at and above the working level, and not of those at it alone */
	/* The GPU's thread, before an epoch takes the record; may be NULL. */
	enum status (*before_epoch)(void *user);
	/* The writer thread, before each commit, which it may fail; may be NULL. */
	enum status (*before_commit)(void *user);
	void *user; /* of all of them */
};

/* Bytes at most: of planes in slots, of images for loads, of images of changed pages, and of the base
 * tiles that those who load keep. */
struct resident_pages_budget {
	uint64_t slots, loads, queue, ground;
	uint64_t queue_few; /* of the queue, while no step changes more pages than an epoch waits for */
};

/* Of the store: what pages were made of, and what epochs did to its tables. */
struct pages_counts {
	int64_t loaded, loaded_coarser;       /* tiles whose planes were read: of the working level, and coarser ones */
	int64_t bases, ranges;                /* bases read for pages, and ranges of bases */
	int64_t committed, committed_coarser; /* tiles of the working level in epochs, and those above that followed */
	int64_t changed[PLANES];              /* rows that were written or removed */
	int64_t looked_up[PLANES];            /* rows of the soil's state that were looked up by epochs */
	int64_t header;                       /* entries written */
};

struct resident_pages_io {
	int64_t commits, tiles_read, tiles_written, bytes_read, bytes_written;
	struct pages_sums sums; /* of the drive as a whole */
	double load_ms, readback_ms, writeback_ms;
	uint64_t host_bytes; /* of images made so far; they are kept */
	uint64_t changed_images; /* made so far, for changed pages */
	struct pages_counts counts;
};

/* What the plan of a drive's pages follows from. Effects are names for the plan's lines. */
struct pages_planned {
	uint32_t cells;      /* of the store's tiles */
	unsigned planes;     /* as the params' */
	uint32_t loaders;
	bool was_deformed;   /* the store, before */
	bool deforms;        /* there are bodies */
	bool lowers;         /* there are bodies, and they only lower the ground */
	bool classes;        /* there is a map of soils */
	bool picture;        /* somebody draws */
	const char *loaders_effect, *classes_effect, *picture_effect;
};
/* The lines of the pages of a drive: threads, staging, statements, also those of the ground and of the view, which go by the
 * same figures. After deform's lines, whose planes say which effect calls for them. Pure. */
void resident_pages_plan(const struct pages_planned *planned, struct plan *plan);
/* What pages of such parameters may take at most, over tiles of so many cells; store, gpu and slots are not looked at.
 * Pure. */
void resident_pages_budget(const struct pages_params *params, uint32_t cells, struct resident_pages_budget *budget);
enum status resident_pages_create(const struct pages_params *params, struct pages **out) FURROW_CHECKED;
/* Stops the threads; commits nothing. */
void resident_pages_destroy(struct pages *pages);
/* Stops the threads, so that figures are whole: then only resident_pages_io and resident_pages_destroy. */
void resident_pages_stop(struct pages *pages);
struct page_cache *resident_pages_cache(struct pages *pages);
/* What is committed now is what resident_pages_rollback goes back to; the mark before is given up. Between two steps, after page_cache_flush. */
enum status resident_pages_mark(struct pages *pages) FURROW_CHECKED;
/* Back to the mark: the store, the sums, and the pages, of which those that changed are dropped. Between two steps. On failure
 * nothing changed. */
enum status resident_pages_rollback(struct pages *pages) FURROW_CHECKED;
void resident_pages_io(struct pages *pages, struct resident_pages_io *io);

/*
 * --- coarser levels ---
 *
 * Keeps resident coarser tiles up to date with what changed at the working level, on the GPU.
 * Changes of a step are gathered as one rectangle a tile and decimated once, before anybody looks or
 * the tile leaves its slot.
 */
struct pyramid;

enum status resident_pyramid_create(const struct extent *extent, int level, struct gpu_slots *slots, struct pyramid **out)
	FURROW_CHECKED;
void resident_pyramid_destroy(struct pyramid *pyramid);
/* Posts of `rect` (global) changed in this tile. */
enum status resident_pyramid_changed(struct pyramid *pyramid, struct tile tile, struct post_rect rect) FURROW_CHECKED;
/* Brings the tile's resident ancestors up to date; nothing if it did not change. */
enum status resident_pyramid_flush_tile(struct pyramid *pyramid, struct page_cache *cache, struct tile tile, uint32_t slot)
	FURROW_CHECKED;
/* All of them, at a step's end. */
enum status resident_pyramid_flush(struct pyramid *pyramid, struct page_cache *cache) FURROW_CHECKED;
/* What changed is not as it was: nothing waits to be brought up to date. Takes NULL. */
void resident_pyramid_forget(struct pyramid *pyramid);
struct resident_pyramid_figures {
	uint64_t updated, resident; /* coarser tiles, both summed over the steps */
};
void resident_pyramid_figures(const struct pyramid *pyramid, struct resident_pyramid_figures *figures);

/*
 * --- newest values ---
 *
 * The ground as it is now, for queries (terrain/terrain.h): the base, and the newest planes of a tile, wherever those are:
 * in a slot, in the queue of what is to be committed, or in the store.
 *
 * Over a running drive: on the drive's thread, between two steps. It reads and changes nothing else: it pins, loads and uses
 * no page, has its own reader of the store and its own tiles, so that a drive gives the same bits however it is asked. Over a
 * store alone: any one thread, without GL; what another process commits meanwhile may or may not be seen.
 *
 * What is asked is kept, bounded: some 32 MB of tiles, or 4, and ranges. A tile that is dirty in its slot is read from there,
 * which on a real GPU waits for all work that was begun before; once a tile until the ground changes, however much is asked.
 */
struct newest;

/* `pages` NULL: the store alone. Both must outlive it. */
enum status resident_newest_create(struct store *store, struct pages *pages, struct newest **out) FURROW_CHECKED;
void resident_newest_destroy(struct newest *newest); /* takes NULL */
/* The ground is not as it was when last asked: within a step, too. Takes NULL. */
void resident_newest_changed(struct newest *newest);
enum status resident_newest_heights(struct newest *newest, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status resident_newest_rays(struct newest *newest, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;
/*
 * Posts of a rectangle of any level, row by row from the south-west, in the units of store_read_posts, which says what each
 * layer is at finer and coarser levels than it is kept at. NaN: no data, or outside the terrain. Nothing is kept.
 */
enum status resident_read_posts(struct newest *newest, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

#endif
