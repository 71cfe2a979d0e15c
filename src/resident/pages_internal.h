/*
 * Shared by the files pages*.c: the bytes of a page, and which thread uses what.
 *
 *     loader threads --- pages_io.c ---> image ---> pages_slots.c ---> slot      (base, planes)
 *     the writer     <-- pages_io.c ---- image <--- pages_slots.c <--- slot      (planes)
 */
#ifndef FURROW_RESIDENT_PAGES_INTERNAL_H
#define FURROW_RESIDENT_PAGES_INTERNAL_H

#include "resident/resident.h"

/* Head of a loaded image. After it come base posts or a patch, the planes, and numbers and classes if there are any. A changed image
 * has only the planes; a snapshot has the tally. page_image.flags: the planes that are filled; 0: the tile is not deformed. */
struct pages_head {
	int shift; /* 0: the base is posts; otherwise it is a patch, and the tile is this many levels below 0 */
	uint32_t sub_x, sub_y;
};

struct pages_layout {
	uint32_t cells;
	size_t posts;                /* number of posts of a tile */
	/* base, planes, numbers, classes: where they begin, in bytes; loaded: size of a loaded image */
	size_t base, planes, numbers, classes, loaded;
	size_t places[PLANES];       /* where each plane begins, in bytes after the first plane */
	size_t changed;              /* size of all planes together, in bytes */
};

/* In pages.c. `planes`: as params.planes. */
struct pages_layout resident_pages_layout_of(uint32_t cells, unsigned planes, bool classes, bool numbers);
size_t resident_pages_plane_room(const struct pages_layout *layout, enum plane plane); /* bytes that the plane takes in an image */

struct pages {
	struct pages_params params;
	unsigned planes; /* params.planes */
	struct pages_layout layout;
	struct page_cache *cache;
	struct ground *grounds[16];      /* one for each loader */
	struct store_page *commit_pages; /* used by the writer thread */
	size_t commit_room;
	struct pages_sums tallied;       /* used by the writer thread: what the tally gave at the last commit; below and above are 0 */
	struct pages_marked {            /* pages_rollback.c */
		bool is;
		struct store_reader *reader; /* used by the owner; NULL before the first mark */
		int64_t revision, step;
		struct pages_sums tallied, sums;
	} marked;
	struct pages_moved {             /* pages_move.c: for a page whose newest version is in the store */
		struct store_reader *reader; /* NULL before the first */
		void *bytes;
	} moved;
	double readback_ms;              /* readback_ms and the next two are used by the GPU's thread */
	uint64_t host_bytes, changed_images;
	struct mutex mutex;              /* guards io and volume */
	struct pages_volume {            /* file NULL: none */
		FILE *file;
		double unit;             /* m3 */
	} volume;
	struct resident_pages_io io;
};

static inline struct pages_head *pages_head(const struct page_image *loaded)
{
	return loaded->bytes;
}

static inline int32_t *pages_base(const struct pages *pages, const struct page_image *loaded)
{
	return (int32_t *)((char *)loaded->bytes + pages->layout.base);
}

static inline void *pages_planes(const struct pages *pages, const struct page_image *loaded)
{
	return (char *)loaded->bytes + pages->layout.planes;
}

/* Returns a plane in an image whose planes begin at `planes`. */
static inline void *pages_plane(const struct pages *pages, void *planes, enum plane plane)
{
	return (char *)planes + pages->layout.places[plane];
}

static inline bool pages_have_classes(const struct pages *pages, struct tile tile)
{
	return pages->params.classes != NULL && (tile.level == pages->params.level || pages->params.classes_drawn);
}

/* Contacts alone read numbers, so tiles of the working level alone have them. */
static inline bool pages_have_numbers(const struct pages *pages, struct tile tile)
{
	return pages->params.numbers != NULL && tile.level == pages->params.level;
}

struct page_io resident_pages_io_of(struct pages *pages);             /* pages_io.c */
struct page_executor resident_pages_executor_of(struct pages *pages); /* pages_slots.c */

#endif
