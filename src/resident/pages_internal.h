/*
 * Shared by the files pages*.c: the bytes of a page, and which thread uses what.
 *
 *     loader threads --- pages_io.c ---> image ---> pages_slots.c ---> slot      (base, planes)
 *     the writer     <-- pages_io.c ---- image <--- pages_slots.c <--- slot      (planes)
 *
 * What an image is, and how it comes into a slot, depends on the home of pages: pages_gpu.c, pages_host.c. In a slot of the GPU: the image is a
 * staging buffer with the layout below. In host memory: the image is a tile (host_slots.h). It changes places with the tile of the slot when it
 * is uploaded, and shares its planes when it is read back. All other files are the same for both.
 */
#ifndef FURROW_RESIDENT_PAGES_INTERNAL_H
#define FURROW_RESIDENT_PAGES_INTERNAL_H

#include "resident/host_slots.h"

struct pages;

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

/* What differs between homes. `image` is that of a page, and image->flags the planes that it has. */
struct pages_home {
	/* On the owner's thread. */
	enum status (*create)(struct pages *pages, enum page_image_kind kind, struct page_image *image);
	void (*destroy)(struct pages *pages, struct page_image *image);
	/* On any thread, as page_executor.drop; NULL: nothing to do. */
	void (*drop)(struct pages *pages, struct page_image *image);
	/* Of a loaded image, on the thread that fills it. base: fills it. room: gives memory for classes, numbers; NULL: not wanted. */
	enum status (*base)(struct pages *pages, struct ground *ground, struct page_image *image);
	enum status (*room)(struct pages *pages, struct page_image *image, uint8_t **classes, uint8_t **numbers);
	/* Gives memory for planes of the mask, to write all of their posts. `zeros`: those that the image lacks are zeros, and it has them then. */
	enum status (*planes)(struct pages *pages, struct page_image *image, unsigned mask, bool zeros, void *into[PLANES]);
	void (*keep)(struct pages *pages, struct page_image *image, unsigned present); /* it has these planes and no other ones */
	void (*copy)(struct pages *pages, struct page_image *image, const struct page_image *queued); /* it has the planes of `queued` */
	/* Fills a changed image, each plane of params.planes, from bytes as those of a page that moves. NULL: all are zeros. */
	enum status (*fill)(struct pages *pages, struct page_image *image, const void *bytes);
	/* Returns a plane that a changed image has. On any thread that may read it. */
	const void *(*plane)(const struct pages *pages, const struct page_image *image, enum plane plane);
	/* On the owner's thread: as in struct page_executor, but `upload` leaves overlays to the caller. */
	enum status (*upload)(struct pages *pages, uint32_t slot, struct page_image *image);
	enum status (*read_back)(struct pages *pages, uint32_t slot, struct page_image *image);
	enum status (*snapshot)(struct pages *pages, struct page_image *image); /* if there is a tally */
	enum status (*settled)(const struct pages *pages, const struct page_image *image, bool *settled);
	/* Copies a plane of a slot; zeros if it has none. On the owner's thread. May wait. */
	enum status (*read_plane)(const struct pages *pages, uint32_t slot, enum plane plane, void *posts);
	bool (*is_deformed)(const struct pages *pages, uint32_t slot);
};
extern const struct pages_home resident_pages_gpu, resident_pages_host;

struct pages {
	struct pages_params params;
	const struct pages_home *home;
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
	struct resident_volume volume;   /* file NULL: none */
	struct resident_pages_io io;
};

/* Returns a plane in bytes that have all planes, one after the other: those of a page that moves. */
static inline void *pages_plane(const struct pages *pages, void *planes, enum plane plane)
{
	return (char *)planes + pages->layout.places[plane];
}

static inline bool pages_have_tally(const struct pages_params *params)
{
	return params->host != NULL ? params->tally != NULL : params->snapshot != NULL;
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
