/*
 * Shared by the files pages*.c: the bytes of a page, and which thread uses what.
 *
 *     loader threads --- pages_io.c ---> image ---> pages_slots.c ---> slot      (base, planes)
 *     the writer     <-- pages_io.c ---- image <--- pages_slots.c <--- slot      (planes)
 */
#ifndef FURROW_RESIDENT_PAGES_INTERNAL_H
#define FURROW_RESIDENT_PAGES_INTERNAL_H

#include "resident/resident.h"

/* The bytes of a loaded image: this head, base posts or a patch, the planes, and classes if there are any. A changed image has
 * only the planes; a snapshot has the tally. page_image.flags: the planes that are filled; 0: not deformed. */
struct pages_head {
	int shift; /* 0: the base is posts; else a patch to subdivide */
	uint32_t sub_x, sub_y;
};

struct pages_layout {
	uint32_t cells;
	size_t posts;                /* of a tile */
	size_t base, planes, classes, loaded; /* bytes: where they begin, and all of a loaded image */
	size_t places[PLANES];       /* bytes from the planes' begin; of those there are */
	size_t changed;              /* bytes: all of the planes */
};

/* pages.c; `planes`: params.planes. */
struct pages_layout resident_pages_layout_of(uint32_t cells, unsigned planes, bool classes);
size_t resident_pages_plane_room(const struct pages_layout *layout, enum plane plane); /* bytes of it in an image */

struct pages {
	struct pages_params params;
	unsigned planes; /* params.planes */
	struct pages_layout layout;
	struct page_cache *cache;
	struct ground *grounds[16];      /* one a loader */
	struct store_page *commit_pages; /* the writer's */
	size_t commit_room;
	int64_t tallied;                 /* the writer's: what was compacted at the last commit, by the tally */
	struct pages_marked {            /* pages_rollback.c */
		bool is;
		struct store_reader *reader; /* the owner's; NULL until the first mark */
		int64_t revision, tallied;
		struct pages_sums sums;
	} marked;
	double readback_ms;              /* the GPU's thread's, and */
	uint64_t host_bytes, changed_images;
	struct mutex mutex;              /* guards io */
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

/* In an image whose planes begin at `planes`. */
static inline void *pages_plane(const struct pages *pages, void *planes, enum plane plane)
{
	return (char *)planes + pages->layout.places[plane];
}

static inline bool pages_have_classes(const struct pages *pages, struct tile tile)
{
	return pages->params.classes != NULL && (tile.level == pages->params.level || pages->params.classes_drawn);
}

struct page_io resident_pages_io_of(struct pages *pages);             /* pages_io.c */
struct page_executor resident_pages_executor_of(struct pages *pages); /* pages_slots.c */

#endif
