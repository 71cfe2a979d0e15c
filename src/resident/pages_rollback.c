/*
 * Marks, and going back to the last one. The store puts its rows back. Pages in slots that changed since are dropped, at the
 * working level. All pages above them are dropped too. A coarser page follows its finer ones on the GPU without being dirty.
 */
#include "base/key_set.h"
#include "resident/pages_internal.h"

struct going_back {
	struct pages *pages;
	struct key_set changed; /* pages and all above them */
	enum status status;     /* of the set */
};

static enum status nothing(void *user, uint64_t key)
{
	(void)user;
	(void)key;
	return STATUS_OK;
}

enum status resident_pages_mark(struct pages *pages)
{
	int64_t revision;
	struct pages_marked *marked = &pages->marked;
	if (marked->reader == NULL)
		TRY(store_reader_create(pages->params.store, &marked->reader));
	TRY(store_each_changed(marked->reader, INT64_MAX - 1, nothing, NULL, &revision));
	TRY(store_mark(pages->params.store));
	*marked = (struct pages_marked){true, marked->reader, revision, pages->io.step, pages->tallied, pages->io.sums};
	return STATUS_OK;
}

static enum status add(void *user, uint64_t key)
{
	struct going_back *going = user;
	const int coarsest = extent_coarsest(&store_meta(going->pages->params.store)->extent);
	enum status status = STATUS_OK;
	for (struct tile tile = tile_from_key(key); status == STATUS_OK; tile = tile_ancestor(tile, tile.level + 1)) {
		if (key_set_has(&going->changed, tile_key(tile)))
			break;
		status = key_set_add(&going->changed, tile_key(tile));
		if (tile.level >= coarsest)
			break;
	}
	return status;
}

static void add_uncommitted(void *user, uint64_t key)
{
	struct going_back *going = user;
	if (going->status == STATUS_OK)
		going->status = add(going, key);
}

static enum status back(void *user)
{
	struct going_back *going = user;
	struct pages *pages = going->pages;
	int64_t now;
	page_cache_each_changed(pages->cache, add_uncommitted, going);
	enum status status = going->status;
	if (status == STATUS_OK)
		status = store_each_changed(pages->marked.reader, pages->marked.revision, add, going, &now);
	if (status == STATUS_OK)
		status = store_rollback(pages->params.store);
	return status == STATUS_OK ? store_bound_wal(pages->params.store) : status;
}

static bool changed(void *user, uint64_t key)
{
	const struct going_back *going = user;
	return key_set_has(&going->changed, key);
}

static void dropped(void *user, uint64_t key)
{
	(void)user;
	(void)key;
}

enum status resident_pages_rollback(struct pages *pages)
{
	struct going_back going = {.pages = pages};
	const struct page_rollback rollback = {&going, back, changed, dropped};
	if (!pages->marked.is)
		return fail_with(STATUS_FAILED, "rollback: there is no checkpoint to go back to; make one first");
	enum status status = page_cache_rollback(pages->cache, &rollback);
	key_set_finish(&going.changed);
	if (status != STATUS_OK)
		return status;
	mutex_lock(&pages->mutex);
	pages->io.sums = pages->marked.sums;
	pages->io.step = pages->marked.step;
	mutex_unlock(&pages->mutex);
	pages->tallied = pages->marked.tallied;
	return STATUS_OK;
}

static enum status stay(void *user)
{
	(void)user;
	return STATUS_OK;
}

static bool always(void *user, uint64_t key)
{
	(void)user;
	(void)key;
	return true;
}

enum status resident_pages_forget(struct pages *pages)
{
	const struct page_rollback rollback = {pages, stay, always, dropped};
	return page_cache_rollback(pages->cache, &rollback);
}
