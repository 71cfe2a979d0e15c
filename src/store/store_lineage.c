/*
 * Finds, for each tile, the file of a chain of overlays that has its newest row.
 *
 *   plain store <- overlay <- overlay <- overlay, the one that is open
 *     layer 0       layer 1    layer 2
 *
 * An overlay reads a row from its own file first. If it has none, one search in a sorted array tells which other file has it. So a
 * read costs at most two lookups however many files there are. The array is made when the overlay is opened: each file takes the
 * array of the file under it and puts its own rows in.
 *
 * A row of an overlay with a range from 0 to 0 says that there is no row. The overlay has undone what the files under it have there.
 * No other row has that range, since a row exists only where a post is not zero.
 */
#include "store/internal.h"

#include <assert.h>
#include <xxhash.h>

static_assert(LINEAGE_TABLES == (int)ROW_TABLES, "a lineage has an array for each table");

void store_lineage_finish(struct lineage *lineage)
{
	for (int table = 0; table < LINEAGE_TABLES; table++)
		mem_free(lineage->entries[table]);
	*lineage = (struct lineage){0};
}

size_t store_lineage_from(const struct lineage *lineage, int table, uint64_t key)
{
	size_t low = 0, high = lineage->count[table];
	while (low < high) {
		size_t middle = low + (high - low) / 2;
		if (lineage->entries[table][middle].key < key)
			low = middle + 1;
		else
			high = middle;
	}
	return low;
}

const struct lineage_entry *store_lineage_find(const struct lineage *lineage, int table, uint64_t key)
{
	size_t at = store_lineage_from(lineage, table, key);
	return at < lineage->count[table] && lineage->entries[table][at].key == key ? &lineage->entries[table][at] : NULL;
}

bool store_lineage_uses(const struct lineage *lineage, uint32_t layer)
{
	for (int table = 0; table < LINEAGE_TABLES; table++)
		for (size_t i = 0; i < lineage->count[table]; i++)
			if (lineage->entries[table][i].layer == layer)
				return true;
	return false;
}

/* --- making one --- */

struct gathering {
	struct lineage *lineage;
	enum row_table table;
	size_t room;
	uint32_t layer;
	int64_t newest; /* no revision counts as newer */
};

static enum status gather(void *user, const struct row_entry *row)
{
	struct gathering *gathering = user;
	struct lineage *lineage = gathering->lineage;
	size_t count = lineage->count[gathering->table];
	TRY(mem_grow(&lineage->entries[gathering->table], &gathering->room, count + 1, sizeof *lineage->entries[gathering->table], "an overlay"));
	struct lineage_entry *entry = &lineage->entries[gathering->table][count];
	if (row->inherited != NULL) {
		*entry = *row->inherited;
	} else {
		*entry = (struct lineage_entry){row->key, row->hash, row->revision, row->size, gathering->layer};
		if (entry->revision > gathering->newest)
			entry->revision = gathering->newest;
	}
	lineage->count[gathering->table]++;
	return STATUS_OK;
}

enum status store_lineage_make(struct store *under, int64_t newest, struct lineage *out)
{
	struct gathering gathering = {.lineage = out, .layer = (uint32_t)under->depth, .newest = newest};
	enum status status;
	*out = (struct lineage){0};
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		gathering.table = (enum row_table)table;
		gathering.room = 0;
		TRY_OR(failed, store_rows_each(&under->rows, gathering.table, 0, INT64_MAX, gather, &gathering));
	}
	return STATUS_OK;
failed:
	store_lineage_finish(out);
	return status;
}

enum status store_lineage_hash(const struct store *under, const struct lineage *lineage, uint64_t *hash)
{
	XXH3_state_t *state = XXH3_createState();
	TRY_MEM(state, "an overlay");
	XXH3_64bits_reset(state);
	const uint64_t head[] = {under->base_hash, under->working_stored, under->working_stored ? (uint64_t)(int64_t)under->working : 0,
				 (uint64_t)under->compacted};
	store_hash_words(state, head, sizeof head / sizeof *head);
	store_hash_added(state, under->added);
	if (under->working_stored && under->relief_text != NULL)
		store_hash_text(state, under->relief_text);
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++)
		for (size_t i = 0; i < lineage->count[table]; i++) {
			const struct lineage_entry *entry = &lineage->entries[table][i];
			const uint64_t words[] = {(uint64_t)table, entry->key, entry->hash};
			store_hash_words(state, words, sizeof words / sizeof *words);
		}
	*hash = XXH3_64bits_digest(state);
	XXH3_freeState(state);
	return STATUS_OK;
}

enum status store_lineage_state(struct store *store, uint64_t *hash)
{
	struct lineage lineage = {0};
	enum status status;
	TRY_OR(done, store_lineage_make(store, store->commit, &lineage));
	TRY_OR(done, store_lineage_hash(store, &lineage, hash));
done:
	store_lineage_finish(&lineage);
	return status;
}
