/* The planes of pages that move to another process, of those that come from one, and of those that are changed where they are. */
#include <string.h>

#include "resident/pages_internal.h"

struct taking {
	struct pages *pages;
	pages_taken_fn fn;
	void *user;
};

size_t resident_pages_moved_bytes(const struct pages *pages)
{
	return pages->layout.changed;
}

static enum status make_reader(struct pages *pages)
{
	struct pages_moved *moved = &pages->moved;
	if (moved->reader != NULL)
		return STATUS_OK;
	moved->bytes = mem_alloc(pages->layout.changed, 1);
	return moved->bytes != NULL ? store_reader_create(pages->params.store, &moved->reader) : fail_memory("a page");
}

static enum status taken(void *user, uint64_t key, const struct page_image *image)
{
	const struct taking *taking = user;
	struct pages *pages = taking->pages;
	struct tile tile = tile_from_key(key);
	void *into[PLANES] = {NULL};
	unsigned present;
	TRY(make_reader(pages));
	if (image != NULL) {
		for (int plane = 0; plane < PLANES; plane++)
			if (image->flags & PLANE_BIT(plane))
				memcpy(pages_plane(pages, pages->moved.bytes, (enum plane)plane), pages->home->plane(pages, image, (enum plane)plane),
				       pages->layout.posts * plane_bytes((enum plane)plane));
		return taking->fn(taking->user, tile, image->flags, pages->moved.bytes);
	}
	memset(pages->moved.bytes, 0, pages->layout.changed);
	for (int plane = 0; plane < PLANES; plane++)
		if (pages->planes & PLANE_BIT(plane))
			into[plane] = pages_plane(pages, pages->moved.bytes, (enum plane)plane);
	TRY(store_read_deformed(pages->moved.reader, tile, pages->planes, into, &present));
	return taking->fn(taking->user, tile, present, pages->moved.bytes);
}

enum status resident_pages_take(struct pages *pages, const uint64_t *keys, size_t count, pages_taken_fn fn, void *user)
{
	struct taking taking = {pages, fn, user};
	return page_cache_take(pages->cache, keys, count, taken, &taking);
}

struct putting {
	struct pages *pages;
	unsigned planes;
	const void *bytes;
};

/* A plane that the tile does not have is 0 in every post. So the next commit drops what this store has of it from before. */
static enum status fill(void *user, struct page_image *image)
{
	const struct putting *putting = user;
	image->flags = putting->pages->planes;
	return putting->pages->home->fill(putting->pages, image, putting->planes != 0 ? putting->bytes : NULL);
}

enum status resident_pages_put(struct pages *pages, struct tile tile, unsigned planes, const void *bytes)
{
	struct putting putting = {pages, planes, bytes};
	return page_cache_put(pages->cache, tile_key(tile), fill, &putting);
}

/* --- a page is changed in between --- */

struct editing {
	struct pages *pages;
	pages_edit_fn fn;
	void *user;
};

static enum status edit(void *user, struct tile tile, unsigned planes, const void *bytes)
{
	const struct editing *editing = user;
	struct pages *pages = editing->pages;
	void *posts[PLANES] = {NULL};
	(void)bytes; /* pages->moved.bytes */
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(pages->planes & PLANE_BIT(plane)))
			continue;
		posts[plane] = pages_plane(pages, pages->moved.bytes, (enum plane)plane);
		if (!(planes & PLANE_BIT(plane)))
			memset(posts[plane], 0, pages->layout.posts * plane_bytes((enum plane)plane));
	}
	editing->fn(editing->user, tile, posts);
	return STATUS_OK;
}

enum status resident_pages_edit(struct pages *pages, struct tile tile, pages_edit_fn fn, void *user)
{
	struct editing editing = {pages, fn, user};
	const uint64_t key = tile_key(tile);
	TRY(resident_pages_take(pages, &key, 1, edit, &editing));
	return resident_pages_put(pages, tile, pages->planes, pages->moved.bytes);
}
