/*
 * Gathers the parts of a run into what they are over, in one transaction.
 *
 *   heads of all parts -> claims of all parts -> BEGIN -> part by part -> header, the run's record -> COMMIT
 *
 * The heads tell the last commit that all parts have. The claims tell for each tile which part committed it last. Of each part its tiles
 * are written, with every coarser level above them, and the soil's state. One part is open at a time. Only rows in its own file are read.
 * Where it has none, the row that it inherits is there already.
 *
 * A part may also have rows of the soil's state for tiles that no part committed. They come from commits without that plane, which set
 * to zero the posts that such a tile shares with a tile of theirs (store_state.c). So their posts are zero where those of one part are.
 *
 * The header keeps the number of the run that was gathered last. So a second time changes nothing.
 */
#include "store/gather.h"

#include <stdio.h>

/* --- in the transaction --- */

static enum status part_posts(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **posts)
{
	struct gather *gather = user;
	bool found;
	struct tile tile = tile_from_key(item->key);
	TRY(store_part_posts(gather->part, table, tile, gather->commit, scratch, &found));
	*posts = scratch;
	return found ? STATUS_OK : store_rows_bad(&gather->part->rows, table, tile, "it was there and cannot be found");
}

/* Lists the tiles of which the open part has the last page and a row of its own. */
static enum status list_items(struct gather *gather, size_t *count)
{
	size_t side = tile_posts(&gather->store->meta.extent);
	*count = 0;
	for (size_t i = 0; i < gather->claim_count; i++) {
		bool found = false;
		const struct claim *claim = &gather->claims[i];
		if (claim->part != gather->reading)
			continue;
		TRY(store_part_posts(gather->part, gather->table, tile_from_key(claim->key), gather->commit, NULL, &found));
		if (found)
			gather->items[(*count)++] = (struct climb_item){.key = claim->key, .posts = side * side};
	}
	return STATUS_OK;
}

/* Sets to zero the posts of a tile that no part committed where this part has set them to zero. */
static enum status trim(void *user, uint64_t key)
{
	struct gather *gather = user;
	struct tile tile = tile_from_key(key);
	size_t side = tile_posts(&gather->store->meta.extent);
	struct row row;
	bool found, had;
	if (store_gather_claimed(gather, key))
		return STATUS_OK;
	TRY(store_part_posts(gather->part, gather->table, tile, gather->commit, gather->posts, &found));
	TRY(store_rows_read(&gather->store->rows, gather->table, tile, gather->scratch, &row, &had));
	if (!found || !had)
		return STATUS_OK;
	for (size_t i = 0; i < side * side; i++)
		gather->scratch[i] = gather->posts[i] != 0 ? gather->scratch[i] : 0;
	return store_state_put_tile(gather->store, gather->table, tile, gather->scratch, gather->result);
}

static enum status put_state(struct gather *gather, size_t count)
{
	const int32_t *posts;
	for (size_t i = 0; i < count; i++) {
		TRY(part_posts(gather, gather->table, &gather->items[i], gather->posts, &posts));
		TRY(store_state_put_tile(gather->store, gather->table, tile_from_key(gather->items[i].key), posts, gather->result));
	}
	return store_part_each(gather->part, gather->table, gather->commit, trim, gather);
}

static enum status put_part(struct gather *gather, uint32_t index)
{
	const struct climb_source source = {gather, part_posts};
	const struct store_run run = {0}; /* asks nobody whether to go on */
	size_t count;
	TRY(store_gather_open(gather, index));
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		gather->table = (enum row_table)table;
		TRY(list_items(gather, &count));
		if (row_is_state(gather->table))
			TRY(put_state(gather, count));
		else
			TRY(store_climb(gather->store, gather->table, gather->items, count, &source, &run, gather->result));
	}
	store_gather_close(gather);
	return STATUS_OK;
}

static enum status put_record(struct gather *gather)
{
	const struct store_gathering *gathering = gather->gathering;
	const struct store_run_copy *first = &gather->heads[0].run;
	struct store_run *runs = mem_calloc(gather->count, sizeof *runs);
	TRY_MEM(runs, "parts");
	for (uint32_t i = 0; i < gather->count; i++) {
		const struct head *head = &gather->heads[i];
		runs[i] = (struct store_run){
			.scene_hash = head->run.scene_hash, .step = head->run.step, .time = head->run.time, .state = head->run.state,
			.what = head->run.what, .compacted = head->header.compacted - gather->store->compacted,
			.added = head->header.added - gather->store->added,
		};
	}
	const struct store_run run = {.scene_hash = first->scene_hash, .step = first->step, .time = first->time, .what = first->what};
	const char *state = gathering->describe(gathering->user, runs, gather->count, gather->result);
	enum status status = state != NULL ? store_run_put(gather->store, &run, state) : fail_memory("the run's record");
	mem_free(runs);
	return status;
}

static enum status put_header(struct gather *gather)
{
	struct store *store = gather->store;
	int64_t compacted = 0, added = 0;
	if (gather->has_level && !store->working_stored) {
		TRY(store_meta_put_working(store, gather->level, gather->relief));
		gather->result->header += gather->relief != NULL ? 2 : 1;
	}
	for (uint32_t i = 0; i < gather->count; i++)
		if (__builtin_add_overflow(compacted, gather->heads[i].header.compacted - store->compacted, &compacted) ||
		    __builtin_add_overflow(added, gather->heads[i].header.added - store->added, &added))
			return fail_with(STATUS_INPUT, "%s: more soil was compacted or added than can be counted; it is damaged, restore it", gather->heads[i].path);
	TRY(store_meta_add_compacted(store, compacted));
	TRY(store_meta_add_added(store, added));
	TRY(store_meta_put_integer(store, "gathered", (int64_t)gather->first->part.run));
	gather->result->header += 1 + (compacted != 0) + (added != 0);
	return put_record(gather);
}

static enum status put_all(struct gather *gather)
{
	struct store *store = gather->store;
	TRY(store_history_begin(store, false));
	for (uint32_t i = 0; i < gather->count; i++)
		TRY(put_part(gather, i));
	TRY(put_header(gather));
	return store_sql_exec(store->db, store->path, "committing what was gathered", "COMMIT");
}

/* Ends the transaction. `status`: how it went; it is returned. */
static enum status end(struct gather *gather, enum status status)
{
	store_gather_close(gather); /* if it failed in a part */
	status = store_history_end(gather->store, status);
	store_changes_drop(&gather->store->changes); /* nobody asks this connection */
	return status;
}

static enum status commit(struct gather *gather)
{
	struct store *store = gather->store;
	size_t side = tile_posts(&store->meta.extent);
	gather->posts = mem_alloc(side * side, sizeof *gather->posts);
	gather->scratch = mem_alloc(side * side, sizeof *gather->scratch);
	gather->items = mem_alloc(gather->claim_count + 1, sizeof *gather->items);
	TRY_MEM(gather->posts != NULL && gather->scratch != NULL && gather->items != NULL, "parts");
	if (gather->has_level) {
		store->has_working = true;
		store->working = gather->level;
	}
	TRY(store_sql_begin(store->db, store->path, "gathering its parts"));
	return end(gather, put_all(gather));
}

/* --- the whole --- */

static enum status was_gathered(struct gather *gather, bool *was)
{
	int64_t count;
	char sql[112];
	snprintf(sql, sizeof sql, "SELECT count(*) FROM meta WHERE key = 'gathered' AND value = %lld", (long long)gather->first->part.run);
	TRY(store_sql_integer(gather->store->db, gather->store->path, sql, &count));
	*was = count > 0;
	return STATUS_OK;
}

/* The parts are over this store, and it is as it was when they were made. */
static enum status check_parent(struct gather *gather)
{
	struct store *store = gather->store;
	uint64_t hash = 0;
	TRY(store_lineage_state(store, &hash));
	if (hash != gather->first->parent_hash)
		return fail_with(STATUS_INPUT, "%s: it is not over %s, or that has changed since: it was at revision %lld, and is at %lld; restore it "
				 "to that revision, or remove the parts and drive again", gather->first->path, store->path,
				 (long long)gather->first->parent_revision, (long long)store->commit);
	return STATUS_OK;
}

static enum status gather_all(struct gather *gather)
{
	bool was;
	TRY(was_gathered(gather, &was));
	if (was) {
		gather->result->commit = gather->store->commit;
		return STATUS_OK;
	}
	TRY(store_gather_settle(gather));
	if (gather->commit == gather->first->parent_revision)
		return STATUS_OK;
	TRY(check_parent(gather));
	TRY(store_gather_read(gather));
	gather->result->commit = gather->store->commit + 1;
	return commit(gather);
}

enum status store_gather(const char *path, const char *const *parts, size_t count, const struct store_gathering *gathering,
			 struct store_commit_result *result)
{
	struct gather gather = {.gathering = gathering, .result = result};
	/* The parts are removed when this has returned: its commit must be on the disk then. */
	const struct store_options options = {.mode = STORE_WRITE, .durable_full = true};
	*result = (struct store_commit_result){0};
	if (count == 0)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, store_gather_heads(&gather, parts, count));
	TRY_OR(done, store_open(path, &options, &gather.store));
	TRY_OR(done, gather_all(&gather));
done:
	for (uint32_t i = 0; i < gather.count; i++)
		store_run_copy_finish(&gather.heads[i].run);
	store_gather_close(&gather);
	store_close(gather.store);
	mem_free_all(gather.heads, gather.claims, gather.items, gather.posts, gather.scratch, gather.relief);
	return status;
}
