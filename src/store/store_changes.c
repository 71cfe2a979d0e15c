/*
 * Remembers which tiles of the working level changed after which revision.
 *
 * Each row has the revision that wrote it. But no row tells that another row was removed. Also, reading all rows takes longer the
 * more ground is deformed. So a table in memory holds each tile that changed since the store was opened, with the last revision
 * that changed it. A tile takes 16 bytes, and the table is at most half full. For changes before the opening, the rows are read
 * when they are first needed.
 */
#include "store/internal.h"

#include <assert.h>

#define LEAST_ROOM 64

void store_changes_begin(struct changes *changes)
{
	mutex_init(&changes->mutex);
}

void store_changes_finish(struct changes *changes)
{
	mem_free_all(changes->entries, changes->pending);
	mutex_finish(&changes->mutex);
}

void store_changes_restart(struct changes *changes, int64_t revision)
{
	mutex_lock(&changes->mutex);
	for (size_t i = 0; i < changes->room; i++)
		changes->entries[i].revision = 0;
	changes->count = 0;
	changes->from = changes->now = revision;
	mutex_unlock(&changes->mutex);
}

enum status store_changes_note(struct changes *changes, uint64_t key)
{
	TRY(mem_grow(&changes->pending, &changes->pending_room, changes->pending_count + 1, sizeof *changes->pending, "the changed tiles"));
	changes->pending[changes->pending_count++] = key;
	return STATUS_OK;
}

/* --- the table --- */

static void put(struct changes *changes, uint64_t key, int64_t revision)
{
	size_t mask = changes->room - 1, at = (size_t)((key * 0x9e3779b97f4a7c15u) >> 20) & mask;
	while (changes->entries[at].revision != 0 && changes->entries[at].key != key)
		at = (at + 1) & mask;
	struct changes_entry *entry = &changes->entries[at];
	changes->count += entry->revision == 0;
	*entry = (struct changes_entry){key, revision > entry->revision ? revision : entry->revision};
}

static enum status reserve_locked(struct changes *changes, size_t more)
{
	struct changes old = *changes;
	size_t room = old.room != 0 ? old.room : LEAST_ROOM;
	while (room < 2 * (old.count + more))
		room *= 2;
	if (room == old.room)
		return STATUS_OK;
	struct changes_entry *entries = mem_calloc(room, sizeof *entries);
	TRY_MEM(entries, "the changed tiles");
	changes->entries = entries;
	changes->room = room;
	changes->count = 0;
	for (size_t i = 0; i < old.room; i++)
		if (old.entries[i].revision != 0)
			put(changes, old.entries[i].key, old.entries[i].revision);
	mem_free(old.entries);
	return STATUS_OK;
}

enum status store_changes_reserve(struct changes *changes)
{
	mutex_lock(&changes->mutex);
	enum status status = reserve_locked(changes, changes->pending_count);
	mutex_unlock(&changes->mutex);
	return status;
}

void store_changes_commit(struct changes *changes, int64_t revision)
{
	mutex_lock(&changes->mutex);
	assert(revision > changes->now);
	for (size_t i = 0; i < changes->pending_count; i++)
		put(changes, changes->pending[i], revision);
	changes->now = revision;
	changes->pending_count = 0;
	mutex_unlock(&changes->mutex);
}

void store_changes_drop(struct changes *changes)
{
	changes->pending_count = 0;
}

/* --- asking --- */

struct reaching {
	struct store_reader *reader;
	enum row_table table;
	int64_t since;
};

/* Takes a row of the working level that an earlier opening wrote after `since`. */
static enum status take_row_locked(void *user, const struct row_entry *entry)
{
	const struct reaching *reaching = user;
	const struct rows *rows = &reaching->reader->rows;
	struct changes *changes = &reaching->reader->store->changes;
	if (entry->revision <= reaching->since || entry->revision > changes->from)
		return STATUS_OK;
	if (!extent_has(rows->extent, tile_from_key(entry->key)))
		return fail_with(STATUS_INPUT, "%s: it has an %s tile outside its terrain; the store is damaged, restore it",
				 rows->path, store_rows_name(reaching->table));
	TRY(reserve_locked(changes, 1));
	put(changes, entry->key, entry->revision);
	return STATUS_OK;
}

static enum status reach_back_locked(struct store_reader *reader, int64_t since)
{
	struct reaching reaching = {.reader = reader, .since = since};
	uint64_t first, last;
	TRY(store_reader_begin(reader));
	level_keys(reader->store->working, &first, &last);
	for (int table = ROW_OFFSET; table < ROW_TABLES && reader->store->has_working; table++) {
		reaching.table = (enum row_table)table;
		TRY(store_rows_each(&reader->rows, reaching.table, first, last, take_row_locked, &reaching));
	}
	reader->store->changes.from = since;
	return STATUS_OK;
}

enum status store_each_changed(struct store_reader *reader, int64_t since, store_key_fn fn, void *user, int64_t *now)
{
	struct changes *changes = &reader->store->changes;
	enum status status = STATUS_OK;
	assert(since >= 0);
	mutex_lock(&changes->mutex);
	if (since < changes->from)
		TRY_OR(done, reach_back_locked(reader, since));
	for (size_t i = 0; i < changes->room; i++)
		if (changes->entries[i].revision > since)
			TRY_OR(done, fn(user, changes->entries[i].key));
	*now = changes->now;
done:
	mutex_unlock(&changes->mutex);
	return status;
}
