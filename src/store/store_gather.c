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
#include "store/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COMPACTED_MOST (INT64_MAX / 4) /* as of the header */

/* What is known of a part. */
struct head {
	const char *path; /* NULL: it is missing */
	struct store_part part;
	uint64_t parent_hash;
	int64_t parent_revision, commit;
	struct store_run_copy run; /* of the commit that is gathered, as is the next */
	struct store_run_header header;
};

struct claim {
	uint64_t key;
	int64_t commit;
	uint32_t part; /* index of its head */
};

struct gather {
	struct store *store; /* what the parts are over */
	const struct store_gathering *gathering;
	struct head *heads; /* by index of the part */
	uint32_t count;     /* of them */
	const struct head *first; /* the first one that is not missing */
	int64_t commit;     /* which is gathered */
	struct claim *claims; /* sorted by key, each key once, when all are read */
	size_t claim_count, claim_room;
	uint32_t reading;   /* index of the part that is read */
	struct store *part; /* which is open */
	enum row_table table;
	struct climb_item *items;
	int32_t *posts, *scratch; /* a tile each */
	bool has_level;
	int level;
	char *relief; /* of the level; NULL: none */
	struct store_commit_result *result;
};

/* --- heads --- */

static enum status take_head(struct gather *gather, const char *path, const struct store *part)
{
	const struct store_part *id = &part->part;
	if (gather->heads == NULL) {
		gather->heads = mem_calloc(id->count, sizeof *gather->heads);
		if (gather->heads == NULL)
			return fail_memory("parts");
		gather->count = id->count;
		gather->first = &gather->heads[id->index];
	}
	const struct head *first = gather->first;
	struct head *head = &gather->heads[id->index < gather->count ? id->index : 0];
	if (first->path != NULL && (id->run != first->part.run || id->count != first->part.count ||
				    part->parent_hash != first->parent_hash || part->parent_revision != first->parent_revision))
		return fail_with(STATUS_INPUT, "%s: it is a part of another run than %s; name parts of one run", path, first->path);
	if (head->path != NULL)
		return fail_with(STATUS_INPUT, "%s: it is part %u, and so is %s; name each part once", path, id->index, head->path);
	*head = (struct head){
		.path = path, .part = *id, .parent_hash = part->parent_hash, .parent_revision = part->parent_revision, .commit = part->commit,
	};
	return STATUS_OK;
}

static enum status take_heads(struct gather *gather, const char *const *paths, size_t count)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct store *part = NULL;
		status = store_part_open(paths[i], &part);
		if (status == STATUS_OK)
			status = take_head(gather, paths[i], part);
		store_close(part);
	}
	return status;
}

/* Opens a part again. It must be as it was when its head was taken. */
static enum status open_part(struct gather *gather, uint32_t index)
{
	const struct head *head = &gather->heads[index];
	enum status status = store_part_open(head->path, &gather->part);
	gather->reading = index;
	if (status != STATUS_OK)
		return status;
	if (gather->part->part.run != head->part.run || gather->part->commit != head->commit)
		return fail_with(STATUS_FAILED, "%s: it changed while it was gathered; wait until its run has ended", head->path);
	if (gather->part->base_hash != gather->store->base_hash ||
	    !store_overlay_same_terrain(&gather->part->meta, &gather->store->meta))
		return fail_with(STATUS_INPUT, "%s: its header is not that of %s, which it is over; it is damaged, restore it", head->path,
				 gather->store->path);
	return STATUS_OK;
}

static void close_part(struct gather *gather)
{
	store_close(gather->part);
	gather->part = NULL;
}

/* Finds the last commit that all parts have. A part that is missing has none. */
static enum status settle_commit(struct gather *gather)
{
	const struct head *least = NULL, *most = gather->first;
	uint32_t missing = 0;
	gather->commit = INT64_MAX;
	for (uint32_t i = gather->count; i-- > 0;) {
		const struct head *head = &gather->heads[i];
		int64_t commit = head->path != NULL ? head->commit : gather->first->parent_revision;
		missing = head->path != NULL ? missing : i;
		most = head->path != NULL && head->commit > most->commit ? head : most;
		least = commit < gather->commit ? head : least;
		gather->commit = commit < gather->commit ? commit : gather->commit;
	}
	if (most->commit <= gather->commit + 1)
		return STATUS_OK;
	if (least->path == NULL)
		return fail_with(STATUS_INPUT, "%s: it has %lld commits, but part %u of its run of %u processes is missing; restore that file, or "
				 "remove the parts and drive again", most->path, (long long)(most->commit - most->parent_revision), missing,
				 gather->count);
	return fail_with(STATUS_INPUT, "%s: it ends at commit %lld, and %s at %lld, but parts of a run are one commit apart at most; one of them "
			 "is an older copy or damaged: restore it, or remove the parts and drive again", least->path,
			 (long long)least->commit, most->path, (long long)most->commit);
}

/* --- claims --- */

static enum status take_claim(void *user, uint64_t key, int64_t commit)
{
	struct gather *gather = user;
	if (gather->claim_count == gather->claim_room) {
		size_t room = gather->claim_room != 0 ? 2 * gather->claim_room : 256;
		struct claim *claims = mem_realloc(gather->claims, room, sizeof *claims);
		if (claims == NULL)
			return fail_memory("parts");
		gather->claims = claims;
		gather->claim_room = room;
	}
	gather->claims[gather->claim_count++] = (struct claim){key, commit, gather->reading};
	return STATUS_OK;
}

static int compare_claims(const void *a, const void *b)
{
	const struct claim *one = a, *other = b;
	if (one->key != other->key)
		return one->key < other->key ? -1 : 1;
	if (one->commit != other->commit)
		return one->commit > other->commit ? -1 : 1;
	return one->part < other->part ? -1 : one->part > other->part;
}

/* Keeps the last claim of each tile. */
static enum status settle_claims(struct gather *gather)
{
	size_t kept = 0;
	if (gather->claim_count > 0)
		qsort(gather->claims, gather->claim_count, sizeof *gather->claims, compare_claims);
	for (size_t i = 0; i < gather->claim_count; i++) {
		const struct claim *claim = &gather->claims[i], *last = kept > 0 ? &gather->claims[kept - 1] : NULL;
		if (last == NULL || last->key != claim->key) {
			gather->claims[kept++] = *claim;
		} else if (last->commit == claim->commit) {
			struct tile tile = tile_from_key(claim->key);
			return fail_with(STATUS_INPUT, "%s: its commit %lld has tile level %d x %u y %u, and so has that of %s; they are not of "
					 "one run, or damaged: restore them", gather->heads[claim->part].path, (long long)claim->commit,
					 tile.level, tile.x, tile.y, gather->heads[last->part].path);
		}
	}
	gather->claim_count = kept;
	return STATUS_OK;
}

static bool is_claimed(const struct gather *gather, uint64_t key)
{
	size_t low = 0, high = gather->claim_count;
	while (low < high) {
		size_t middle = low + (high - low) / 2;
		if (gather->claims[middle].key < key)
			low = middle + 1;
		else
			high = middle;
	}
	return low < gather->claim_count && gather->claims[low].key == key;
}

/* All parts are deformed at one level and over one relief, and so is what they are over if it was deformed. */
static enum status take_level(struct gather *gather, size_t claims_before)
{
	const struct store *part = gather->part;
	if (gather->claim_count == claims_before)
		return STATUS_OK; /* it may not have a level yet */
	if (!gather->has_level) {
		gather->has_level = true;
		gather->level = part->working;
		gather->relief = part->relief_text != NULL ? mem_strdup(part->relief_text) : NULL;
		if (part->relief_text != NULL && gather->relief == NULL)
			return fail_memory("parts");
	}
	const struct store *store = gather->store;
	bool same = gather->level == part->working && store_relief_equal(gather->relief, part->relief_text);
	if (store->working_stored)
		same &= gather->level == store->working && store_relief_equal(gather->relief, store->relief_text);
	return same ? STATUS_OK
		    : fail_with(STATUS_INPUT, "%s: it is deformed at another level or over another relief than the other parts or %s; it is "
				"damaged, restore it", part->path, store->path);
}

/* Reads what a part has of its run's record, and its claims. */
static enum status read_part(struct gather *gather, uint32_t index)
{
	struct head *head = &gather->heads[index];
	enum status status = open_part(gather, index);
	if (status != STATUS_OK)
		return status;
	struct store *part = gather->part;
	size_t before = gather->claim_count;
	if (part->commit > gather->commit) {
		status = store_run_copy_kept(part, gather->commit, &head->run, &head->header);
	} else {
		status = store_run_copy(part, &head->run);
		head->header = (struct store_run_header){part->working_stored, part->compacted};
	}
	if (status == STATUS_OK && (head->header.compacted > COMPACTED_MOST || head->header.compacted < -COMPACTED_MOST))
		status = fail_with(STATUS_INPUT, "%s: it compacted more soil than can be counted; it is damaged, restore it", part->path);
	if (status == STATUS_OK)
		status = store_part_claims(part, gather->commit, take_claim, gather);
	return status == STATUS_OK ? take_level(gather, before) : status;
}

/* All records are of one step of one scene. */
static enum status compare_runs(const struct gather *gather)
{
	const struct store_run_copy *first = &gather->heads[0].run;
	for (uint32_t i = 0; i < gather->count; i++) {
		const struct head *head = &gather->heads[i];
		if (!head->run.found)
			return fail_with(STATUS_INPUT, "%s: it has commits and no record of a run; it is damaged, restore it", head->path);
		if (strcmp(head->run.scene_hash, first->scene_hash) != 0)
			return fail_with(STATUS_INPUT, "%s: it is of another scene than %s; name parts of one run", head->path, gather->heads[0].path);
		if (head->run.step != first->step || head->run.time != first->time)
			return fail_with(STATUS_INPUT, "%s: its commit %lld is of step %lld, and that of %s of step %lld; they are not of one run, or "
					 "damaged: restore them", head->path, (long long)gather->commit, (long long)head->run.step,
					 gather->heads[0].path, (long long)first->step);
	}
	return STATUS_OK;
}

static enum status read_parts(struct gather *gather)
{
	enum status status = STATUS_OK;
	for (uint32_t i = 0; i < gather->count && status == STATUS_OK; i++) {
		status = read_part(gather, i);
		close_part(gather);
	}
	if (status == STATUS_OK)
		status = compare_runs(gather);
	return status == STATUS_OK ? settle_claims(gather) : status;
}

/* --- in the transaction --- */

static enum status part_posts(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **posts)
{
	struct gather *gather = user;
	bool found;
	struct tile tile = tile_from_key(item->key);
	enum status status = store_part_posts(gather->part, table, tile, gather->commit, scratch, &found);
	*posts = scratch;
	return status == STATUS_OK && !found ? store_rows_bad(&gather->part->rows, table, tile, "it was there and cannot be found") : status;
}

/* Lists the tiles of which the open part has the last page and a row of its own. */
static enum status list_items(struct gather *gather, size_t *count)
{
	enum status status = STATUS_OK;
	size_t side = tile_posts(&gather->store->meta.extent);
	*count = 0;
	for (size_t i = 0; i < gather->claim_count && status == STATUS_OK; i++) {
		bool found = false;
		const struct claim *claim = &gather->claims[i];
		if (claim->part != gather->reading)
			continue;
		status = store_part_posts(gather->part, gather->table, tile_from_key(claim->key), gather->commit, NULL, &found);
		if (found)
			gather->items[(*count)++] = (struct climb_item){.key = claim->key, .posts = side * side};
	}
	return status;
}

/* Sets to zero the posts of a tile that no part committed where this part has set them to zero. */
static enum status trim(void *user, uint64_t key)
{
	struct gather *gather = user;
	struct tile tile = tile_from_key(key);
	size_t side = tile_posts(&gather->store->meta.extent);
	struct row row;
	bool found, had;
	if (is_claimed(gather, key))
		return STATUS_OK;
	enum status status = store_part_posts(gather->part, gather->table, tile, gather->commit, gather->posts, &found);
	if (status == STATUS_OK)
		status = store_rows_read(&gather->store->rows, gather->table, tile, gather->scratch, &row, &had);
	if (status != STATUS_OK || !found || !had)
		return status;
	for (size_t i = 0; i < side * side; i++)
		gather->scratch[i] = gather->posts[i] != 0 ? gather->scratch[i] : 0;
	return store_state_put_tile(gather->store, gather->table, tile, gather->scratch, gather->result);
}

static enum status put_state(struct gather *gather, size_t count)
{
	const int32_t *posts;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		status = part_posts(gather, gather->table, &gather->items[i], gather->posts, &posts);
		if (status == STATUS_OK)
			status = store_state_put_tile(gather->store, gather->table, tile_from_key(gather->items[i].key), posts, gather->result);
	}
	return status == STATUS_OK ? store_part_each(gather->part, gather->table, gather->commit, trim, gather) : status;
}

static enum status put_part(struct gather *gather, uint32_t index)
{
	const struct climb_source source = {gather, part_posts};
	const struct store_run run = {0}; /* asks nobody whether to go on */
	size_t count;
	enum status status = open_part(gather, index);
	for (int table = ROW_OFFSET; table < ROW_TABLES && status == STATUS_OK; table++) {
		gather->table = (enum row_table)table;
		status = list_items(gather, &count);
		if (status == STATUS_OK && row_is_state(gather->table))
			status = put_state(gather, count);
		else if (status == STATUS_OK)
			status = store_climb(gather->store, gather->table, gather->items, count, &source, &run, gather->result);
	}
	return status;
}

static enum status put_record(struct gather *gather)
{
	const struct store_gathering *gathering = gather->gathering;
	const struct store_run_copy *first = &gather->heads[0].run;
	struct store_run *runs = mem_calloc(gather->count, sizeof *runs);
	if (runs == NULL)
		return fail_memory("parts");
	for (uint32_t i = 0; i < gather->count; i++) {
		const struct head *head = &gather->heads[i];
		runs[i] = (struct store_run){
			.scene_hash = head->run.scene_hash, .step = head->run.step, .time = head->run.time, .state = head->run.state,
			.what = head->run.what, .compacted = head->header.compacted - gather->store->compacted,
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
	enum status status = STATUS_OK;
	int64_t compacted = 0;
	if (gather->has_level && !store->working_stored) {
		status = store_meta_put_working(store, gather->level, gather->relief);
		gather->result->header += gather->relief != NULL ? 2 : 1;
	}
	for (uint32_t i = 0; i < gather->count && status == STATUS_OK; i++)
		if (__builtin_add_overflow(compacted, gather->heads[i].header.compacted - store->compacted, &compacted))
			status = fail_with(STATUS_INPUT, "%s: more soil was compacted than can be counted; it is damaged, restore it", gather->heads[i].path);
	if (status == STATUS_OK)
		status = store_meta_add_compacted(store, compacted);
	if (status == STATUS_OK)
		status = store_meta_put_integer(store, "gathered", (int64_t)gather->first->part.run);
	gather->result->header += 1 + (compacted != 0);
	return status == STATUS_OK ? put_record(gather) : status;
}

static enum status put_all(struct gather *gather)
{
	struct store *store = gather->store;
	enum status status = store_history_begin(store, false);
	for (uint32_t i = 0; i < gather->count && status == STATUS_OK; i++) {
		status = put_part(gather, i);
		close_part(gather);
	}
	if (status == STATUS_OK)
		status = put_header(gather);
	if (status == STATUS_OK)
		status = store_sql_exec(store->db, store->path, "committing what was gathered", "COMMIT");
	store_history_end(store, status == STATUS_OK);
	return status;
}

static enum status commit(struct gather *gather)
{
	struct store *store = gather->store;
	size_t side = tile_posts(&store->meta.extent);
	gather->posts = mem_alloc(side * side, sizeof *gather->posts);
	gather->scratch = mem_alloc(side * side, sizeof *gather->scratch);
	gather->items = mem_alloc(gather->claim_count + 1, sizeof *gather->items);
	if (gather->posts == NULL || gather->scratch == NULL || gather->items == NULL)
		return fail_memory("parts");
	if (gather->has_level) {
		store->has_working = true;
		store->working = gather->level;
	}
	enum status status = store_sql_begin(store->db, store->path, "gathering its parts");
	if (status == STATUS_OK)
		status = put_all(gather);
	if (status != STATUS_OK)
		store_sql_undo(store->db);
	store_changes_drop(&store->changes); /* nobody asks this connection */
	return status;
}

/* --- the whole --- */

static enum status was_gathered(struct gather *gather, bool *was)
{
	int64_t count;
	char sql[112];
	snprintf(sql, sizeof sql, "SELECT count(*) FROM meta WHERE key = 'gathered' AND value = %lld", (long long)gather->first->part.run);
	enum status status = store_sql_integer(gather->store->db, gather->store->path, sql, &count);
	*was = status == STATUS_OK && count > 0;
	return status;
}

/* The parts are over this store, and it is as it was when they were made. */
static enum status check_parent(struct gather *gather)
{
	struct store *store = gather->store;
	struct lineage lineage = {0};
	uint64_t hash = 0;
	enum status status = store_lineage_make(store, store->commit, &lineage);
	if (status == STATUS_OK)
		status = store_lineage_hash(store, &lineage, &hash);
	store_lineage_finish(&lineage);
	if (status == STATUS_OK && hash != gather->first->parent_hash)
		status = fail_with(STATUS_INPUT, "%s: it is not over %s, or that has changed since: it was at revision %lld, and is at %lld; restore it "
				   "to that revision, or remove the parts and drive again", gather->first->path, store->path,
				   (long long)gather->first->parent_revision, (long long)store->commit);
	return status;
}

static enum status gather_all(struct gather *gather)
{
	bool was;
	enum status status = was_gathered(gather, &was);
	if (status != STATUS_OK || was) {
		gather->result->commit = was ? gather->store->commit : 0;
		return status;
	}
	status = settle_commit(gather);
	if (status != STATUS_OK || gather->commit == gather->first->parent_revision)
		return status;
	status = check_parent(gather);
	if (status == STATUS_OK)
		status = read_parts(gather);
	if (status == STATUS_OK) {
		gather->result->commit = gather->store->commit + 1;
		status = commit(gather);
	}
	return status;
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
	enum status status = take_heads(&gather, parts, count);
	if (status == STATUS_OK)
		status = store_open(path, &options, &gather.store);
	if (status == STATUS_OK)
		status = gather_all(&gather);
	for (uint32_t i = 0; i < gather.count; i++)
		store_run_copy_finish(&gather.heads[i].run);
	close_part(&gather);
	store_close(gather.store);
	mem_free(gather.heads);
	mem_free(gather.claims);
	mem_free(gather.items);
	mem_free(gather.posts);
	mem_free(gather.scratch);
	mem_free(gather.relief);
	return status;
}
