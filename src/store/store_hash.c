/*
 * Computes the hash that tells whether two stores have the same content. It covers the posts of all rows, not their packing or the
 * time when they were written.
 */
#include "store/internal.h"

#include <string.h>
#include <xxhash.h>

void store_hash_words(struct XXH3_state_s *state, const uint64_t *words, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		uint8_t bytes[8];
		for (int b = 0; b < 8; b++)
			bytes[b] = (uint8_t)(words[i] >> (8 * b));
		XXH3_64bits_update(state, bytes, sizeof bytes);
	}
}

uint64_t store_hash_real(double value)
{
	uint64_t word = 0;
	if (value == value) /* NaN: 0 */
		memcpy(&word, &value, sizeof word);
	return word;
}

void store_hash_text(struct XXH3_state_s *state, const char *text)
{
	uint64_t length = strlen(text);
	store_hash_words(state, &length, 1);
	XXH3_64bits_update(state, text, length);
}

void store_hash_added(struct XXH3_state_s *state, int64_t added)
{
	const uint64_t word = (uint64_t)added;
	if (added == 0)
		return;
	store_hash_text(state, "added");
	store_hash_words(state, &word, 1);
}

/* --- the content --- */

struct hashing {
	struct store *store;
	XXH3_state_t *state;
	enum row_table table;
	int32_t *posts;
};

/* Adds the description of the terrain to the hash, but not its sources or how it is packed. */
static void add_meta(struct hashing *hashing)
{
	const struct store *store = hashing->store;
	const struct store_meta *meta = &store->meta;
	const uint64_t words[] = {
		(uint64_t)meta->extent.width, (uint64_t)meta->extent.height, meta->extent.cells,
		store_hash_real(meta->extent.spacing), store_hash_real(meta->step), store_hash_real(meta->max_error),
		store_hash_real(meta->origin[0]), store_hash_real(meta->origin[1]), store_hash_real(meta->low),
		store_hash_real(meta->high), store->working_stored,
		store->working_stored ? (uint64_t)(int64_t)store->working : 0, (uint64_t)store->compacted,
	};
	store_hash_words(hashing->state, words, sizeof words / sizeof *words);
	store_hash_added(hashing->state, store->added);
	if (store->working_stored && store->relief_text != NULL)
		store_hash_text(hashing->state, store->relief_text);
	store_hash_text(hashing->state, meta->srs);
	store_hash_text(hashing->state, meta->vertical);
}

static enum status add_row(void *user, const struct row_entry *entry)
{
	struct hashing *hashing = user;
	enum row_table table = hashing->table;
	struct rows *rows = store_table(hashing->store, table);
	size_t side = tile_posts(rows->extent), count = side * side;
	uint64_t key = entry->key;
	struct tile tile = tile_from_key(key);
	struct row row;
	bool found;
	if (!extent_has(rows->extent, tile) || tile_key(tile) != key)
		return fail_with(STATUS_INPUT, "%s: it has a tile outside its terrain; the store is damaged, "
				 "restore it", rows->path);
	TRY(store_rows_read(rows, table, tile, hashing->posts, &row, &found));
	if (!found) { /* its keys are out of order: one way leads to it, another does not */
		char text[256];
		store_rows_text(rows, table, tile, text, sizeof text);
		return fail_with(STATUS_INPUT, "%s: it is listed and cannot be found; the store is damaged, restore or import it again", text);
	}
	const uint64_t words[] = {(uint64_t)table, key, store_hash_real(row.low), store_hash_real(row.high),
				  store_hash_real(row.error), (uint64_t)row.below, (uint64_t)row.above};
	store_hash_words(hashing->state, words, sizeof words / sizeof *words);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
	for (size_t i = 0; i < count; i++)
		hashing->posts[i] = (int32_t)__builtin_bswap32((uint32_t)hashing->posts[i]);
#endif
	XXH3_64bits_update(hashing->state, hashing->posts, count * sizeof *hashing->posts);
	return STATUS_OK;
}

enum status store_content_hash(struct store *store, uint64_t *hash)
{
	size_t side = tile_posts(&store->meta.extent);
	struct hashing hashing = {.store = store, .state = XXH3_createState()};
	hashing.posts = mem_alloc(side * side, sizeof *hashing.posts);
	enum status status = STATUS_OK;
	if (hashing.posts == NULL || hashing.state == NULL)
		TRY_OR(done, fail_memory("a content hash"));
	XXH3_64bits_reset(hashing.state);
	add_meta(&hashing);
	for (int table = 0; table < ROW_TABLES; table++) {
		hashing.table = (enum row_table)table;
		TRY_OR(done, store_rows_each(store_table(store, hashing.table), hashing.table, 0, INT64_MAX, add_row, &hashing));
	}
	const uint64_t imagery = store_imagery_hash(store);
	if (imagery != 0)
		store_hash_words(hashing.state, &imagery, 1);
	*hash = XXH3_64bits_digest(hashing.state);
done:
	mem_free(hashing.posts);
	XXH3_freeState(hashing.state);
	return status;
}
