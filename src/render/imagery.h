/*
 * Imagery: the colours of the ground from the store, drawn where nothing disturbed it. Shared by the files imagery*.c and view*.c.
 *
 * A page is a tile of the store's imagery: (cells + 1)^2 pixels. Pages lie in one texture, as many as the budget allows. A page cache of
 * their own (src/page) decides which are there. Its loader threads read and decode. The pages are never dirty.
 *
 * Which level a pixel of a picture shows depends on its place and on the eye alone. So neither the budget nor a thread shows in a picture
 * that waits for its pages. If it needs more pages than there are slots, it is drawn in several groups of draws, one after another.
 *
 * Call it on the GPU's thread.
 */
#ifndef FURROW_RENDER_IMAGERY_H
#define FURROW_RENDER_IMAGERY_H

#include "base/key_set.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "render/internal.h"

#define IMAGERY_TABLES 4
#define IMAGERY_TABLE_SIDE 256u /* texels along a side of a texture of tables; lib/imagery.glsl has it, too */
#define IMAGERY_VECTORS (IMAGERY_TABLE_SIDE * IMAGERY_TABLE_SIDE) /* vectors of four floats in the tables of one group */
#define IMAGERY_NO_SLOT UINT32_MAX

/* A set of pages; each comes after the page above it. Initialise it with {0}. */
struct imagery_pages {
	uint64_t *keys;
	size_t count, room;
};

/* A part of the ground. Metres: x and y from the store's south-west post, z as the store has it. */
struct imagery_area {
	const struct render_view *view; /* its eye and planes */
	double focal;                   /* pixels */
	double low[3], high[3];
};

/* A draw of some blocks of a tile. */
struct imagery_draw {
	size_t draw;           /* the caller's */
	uint32_t first, count; /* blocks */
	struct tile tile;
	/* for the shader: of struct picture_params */
	float layer[4], levels[RENDER_IMAGERY_LEVELS][2][4];
	struct imagery_pages pages;
};

struct imagery_loader {
	struct store_reader *reader;
};

struct render_imagery {
	struct gpu *gpu;
	struct extent extent;
	int finest, coarsest; /* levels */
	uint32_t slots, across; /* pages; pages along a side of a layer */
	bool complete;          /* frames wait for their pages */
	struct gpu_texture *texture;
	struct gpu_texture *tables[IMAGERY_TABLES]; /* written in turn: what is drawn with the last one need not be over */
	uint32_t table;        /* the one that was written last */
	struct page_cache *cache;
	struct imagery_loader *loaders;
	uint32_t loader_count;
	/* the group of draws that is collected now */
	struct imagery_draw *draws;
	size_t draw_count, draw_room;
	struct key_set keys; /* pages of the group */
	struct imagery_pages group; /* the same, by their numbers */
	uint32_t *places;    /* slot of each of these */
	size_t place_room, pinned; /* pinned: how many of them, from the first */
	float *vectors;      /* tables of the group's draws */
	size_t vector_count; /* in vectors of four */
	/* pages that the last frame lacked, if it did not wait */
	struct imagery_pages lacking, wanted;
	struct key_set seen;
	bool told[2];        /* that frames are drawn in parts, and that some are coarser */
	bool parted;         /* this frame needed more pages than there are slots */
	uint64_t parted_frames;
};

/* --- imagery.c --- */
/* Makes the texture, the cache and its threads, and fails as render_imagery_check does. `budget`: MB. `loaders`: threads; 0: frames read what they need. */
enum status render_imagery_create(struct gpu *gpu, struct store *store, double budget, uint32_t loaders, struct render_imagery **out) FURROW_CHECKED;
void render_imagery_destroy(struct render_imagery *imagery); /* imagery may be NULL */
void render_imagery_plan(const struct extent *extent, double budget, uint32_t loaders, struct plan *plan); /* pure */
/* Executes work of the cache that is ready. Never waits. Call it once a step. */
enum status render_imagery_poll(struct render_imagery *imagery) FURROW_CHECKED;
/* Requests pages for future frames, soonest needed first, as many as fit. Keys may come twice. */
enum status render_imagery_want(struct render_imagery *imagery, const uint64_t *keys, size_t count) FURROW_CHECKED;
/* Makes the pages of the group resident, and fills `places`. Those that are not, and are not waited for, have no slot. */
enum status render_imagery_bring(struct render_imagery *imagery) FURROW_CHECKED;
void render_imagery_release(struct render_imagery *imagery); /* lets them go */

/* --- imagery_pages.c --- */
/* Adds the pages of imagery that this part of the ground is drawn with. */
enum status render_imagery_need(const struct render_imagery *imagery, const struct imagery_area *area, struct imagery_pages *pages) FURROW_CHECKED;
/* Drops the finest level of these pages. Returns false if there is but one level. */
bool render_imagery_coarsen(struct imagery_pages *pages);
/* Returns the vectors that the table of a draw takes. */
size_t render_imagery_table_size(const struct render_imagery *imagery, const struct imagery_draw *draw);
/* Appends the table of a draw to imagery->vectors, and fills what the shader needs in the draw. Call it after render_imagery_bring. */
void render_imagery_tabulate(struct render_imagery *imagery, struct imagery_draw *draw);

/* --- imagery_group.c --- */
typedef enum status (*imagery_run_fn)(void *user, const struct imagery_draw *draw);
void render_imagery_begin_frame(struct render_imagery *imagery);
/* Draws blocks of a tile, now or together with later ones. `blocks`: the words of struct render_blocks, from the first of the list. */
enum status render_imagery_draw(struct render_imagery *imagery, const struct render_view *view, double focal, const struct render_draw *draw, size_t index,
				const uint32_t *blocks, uint32_t first, uint32_t count, imagery_run_fn run, void *user) FURROW_CHECKED;
/* Draws what was not drawn yet. */
enum status render_imagery_flush(struct render_imagery *imagery, imagery_run_fn run, void *user) FURROW_CHECKED;

#endif
