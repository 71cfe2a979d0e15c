/*
 * Reads what the parts of a run have, before they are gathered (store_gather.c).
 *
 * The heads tell the last commit that all parts have. The claims tell for each tile which part committed it last.
 */
#include "store/gather.h"

#include <stdlib.h>
#include <string.h>

#define COMPACTED_MOST (INT64_MAX / 4) /* as of the header */

/* --- heads --- */

static enum status take_head(struct gather *gather, const char *path, const struct store *part)
{
	const struct store_part *id = &part->part;
	if (gather->heads == NULL) {
		TRY(mem_zeroed(&gather->heads, id->count, sizeof *gather->heads, "parts"));
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

enum status store_gather_heads(struct gather *gather, const char *const *paths, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		struct store *part = NULL;
		TRY(store_part_open(paths[i], &part));
		enum status status = take_head(gather, paths[i], part);
		store_close(part);
		TRY(status);
	}
	return STATUS_OK;
}

enum status store_gather_open(struct gather *gather, uint32_t index)
{
	const struct head *head = &gather->heads[index];
	TRY(store_part_open(head->path, &gather->part));
	gather->reading = index;
	if (gather->part->part.run != head->part.run || gather->part->commit != head->commit)
		return fail_with(STATUS_FAILED, "%s: it changed while it was gathered; wait until its run has ended", head->path);
	if (gather->part->base_hash != gather->store->base_hash ||
	    !store_overlay_same_terrain(&gather->part->meta, &gather->store->meta))
		return fail_with(STATUS_INPUT, "%s: its header is not that of %s, which it is over; it is damaged, restore it", head->path,
				 gather->store->path);
	return STATUS_OK;
}

void store_gather_close(struct gather *gather)
{
	store_close(gather->part);
	gather->part = NULL;
}

enum status store_gather_settle(struct gather *gather)
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
	TRY(mem_grow(&gather->claims, &gather->claim_room, gather->claim_count + 1, sizeof *gather->claims, "parts"));
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

bool store_gather_claimed(const struct gather *gather, uint64_t key)
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
	TRY(store_gather_open(gather, index));
	struct store *part = gather->part;
	size_t before = gather->claim_count;
	if (part->commit > gather->commit) {
		TRY(store_run_copy_kept(part, gather->commit, &head->run, &head->header));
	} else {
		TRY(store_run_copy(part, &head->run));
		head->header = (struct store_run_header){part->working_stored, part->compacted, part->added};
	}
	if (head->header.compacted > COMPACTED_MOST || head->header.compacted < -COMPACTED_MOST)
		return fail_with(STATUS_INPUT, "%s: it compacted more soil than can be counted; it is damaged, restore it", part->path);
	TRY(store_part_claims(part, gather->commit, take_claim, gather));
	return take_level(gather, before);
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

enum status store_gather_read(struct gather *gather)
{
	for (uint32_t i = 0; i < gather->count; i++) {
		enum status status = read_part(gather, i);
		store_gather_close(gather);
		TRY(status);
	}
	TRY(compare_runs(gather));
	return settle_claims(gather);
}
