/*
 * The adaptor between store, page cache and GPU: what a page's bytes mean.
 *
 * Loader threads read through a ground of their own; the writer thread commits epochs; the GPU's
 * thread uploads and reads back. A page of the working level carries its planes when it was
 * deformed, and classes of soil where there are such; a coarser page, which has the planes that are drawn, is
 * overlaid, when it becomes resident, with what is not committed.
 */
#ifndef FURROW_RUN_PAGES_H
#define FURROW_RUN_PAGES_H

#include <stdio.h>

#include "base/base.h"
#include "base/plan.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "world/record.h"
#include "scene/scene.h"
#include "store/store.h"

struct pages;

/* What an epoch's snapshot holds, little-endian: quanta that were compacted since the drive's beginning
 * (int64), posts that refused and that confined (uint64 each). */
#define PAGES_TALLY_BYTES 24

struct pages_params {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots; /* of params.count slots */
	unsigned planes;         /* of the slots' that are read and committed; 0: nothing is or will be deformed */
	int level;               /* the working level */
	uint32_t count, loaders;
	uint32_t step_pages;     /* most pages one step can change, for the queue's bound */
	const struct scene *scene; /* whose record goes with each epoch */
	int64_t below, above;    /* what this drive changed the sums of offsets by before, quanta */
	int64_t compacted;       /* what it compacted before, quanta */
	FILE *epochs;            /* a line for each commit */
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
struct pages_budget {
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

struct pages_io {
	int64_t commits, tiles_read, tiles_written, bytes_read, bytes_written;
	int64_t below, above; /* change of the sums of offsets by the drive as a whole, quanta */
	int64_t compacted;    /* by the drive as a whole, quanta */
	double load_ms, readback_ms, writeback_ms;
	uint64_t host_bytes; /* of images made so far; they are kept */
	uint64_t changed_images; /* made so far, for changed pages */
	struct pages_counts counts;
};

/* The planes that are read and committed: those of the scene's model and dirt where it has objects; where it has none,
 * those that are drawn of what earlier drives left, if the store `was_deformed`. */
unsigned pages_planes_of(const struct scene *scene, bool was_deformed);
/* The lines of the pages of a drive over a store of tiles of so many cells: threads, staging, statements, also those of
 * the ground and of the view, which go by the same figures. After deform's lines, whose planes say which effect calls
 * for them. Pure. */
void pages_plan(const struct scene *scene, uint32_t cells, bool was_deformed, struct plan *plan);
/* What pages of such parameters may take at most, over tiles of so many cells; store, gpu and slots are not looked at.
 * Pure. */
void pages_budget(const struct pages_params *params, uint32_t cells, struct pages_budget *budget);
enum status pages_create(const struct pages_params *params, struct pages **out) FURROW_CHECKED;
/* Stops the threads; commits nothing. */
void pages_destroy(struct pages *pages);
/* Stops the threads, so that figures are whole: then only pages_io and pages_destroy. */
void pages_stop(struct pages *pages);
struct page_cache *pages_cache(struct pages *pages);
void pages_io(struct pages *pages, struct pages_io *io);

#endif
