/*
 * Identifies the base of a store: one hash over the terrain's description and over the hash of every base row. With it an
 * overlay (store_overlay.c) names the base it belongs to.
 */
#include "store/internal.h"

#include <xxhash.h>

static void add_meta(XXH3_state_t *state, const struct store_meta *meta)
{
	const uint64_t words[] = {
		(uint64_t)meta->extent.width, (uint64_t)meta->extent.height, meta->extent.cells,
		store_hash_real(meta->extent.spacing), store_hash_real(meta->step), store_hash_real(meta->origin[0]),
		store_hash_real(meta->origin[1]), store_hash_real(meta->low), store_hash_real(meta->high),
	};
	store_hash_words(state, words, sizeof words / sizeof *words);
	store_hash_text(state, meta->srs);
	store_hash_text(state, meta->vertical);
}

static enum status add_rows(XXH3_state_t *state, sqlite3 *db, const char *path)
{
	sqlite3_stmt *statement = NULL;
	enum status status;
	TRY_OR(done, store_sql_prepare(db, path, &statement, "SELECT key, hash FROM base ORDER BY key"));
	int code;
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		if (code == SQLITE_ROW)
			store_hash_words(state, (uint64_t[]){(uint64_t)sqlite3_column_int64(statement, 0),
						       (uint64_t)sqlite3_column_int64(statement, 1)}, 2);
		else
			TRY_OR(done, store_sql_fail(db, code, path, "reading its tiles"));
	}
done:
	sqlite3_finalize(statement);
	return status;
}

enum status store_identity_compute(struct store *store, uint64_t *hash)
{
	XXH3_state_t *state = XXH3_createState();
	TRY_MEM(state, "a base's hash");
	XXH3_64bits_reset(state);
	add_meta(state, &store->meta);
	enum status status;
	TRY_OR(done, add_rows(state, store->base->db, store->base->path));
	*hash = XXH3_64bits_digest(state);
done:
	XXH3_freeState(state);
	return status;
}

uint64_t store_base_hash(const struct store *store)
{
	return store->base_hash;
}
