/*
 * Merges two overlays into a new overlay of what both are over.
 *
 *   tiles that one of them changed -> post by post -> a new overlay, its coarser levels made anew -> published
 *
 * A post that one of the two changed is as that one has it. A post that both changed must be the same in both, in every plane.
 * Otherwise nothing is made, and the places are told. The new file is made beside its name and renamed, so that it is whole or absent.
 *
 * The three grounds are compared row by row first: rows with one hash have the same posts.
 */
#include "store/internal.h"

#include <stdio.h>
#include <string.h>

enum { OURS, THEIRS, BASE, SIDES }; /* BASE: what both began with */

struct merging {
	struct store *sides[SIDES];     /* BASE: NULL if it was never deformed */
	struct lineage rows[SIDES];     /* the rows that count */
	struct climb_item *items;       /* of one table: tiles that one or both changed */
	size_t count;
	int32_t *posts[SIDES];          /* a tile each */
	int level;
	const char *relief;                /* under both; NULL: none */
	struct store_conflicts *conflicts; /* while they are sought; else NULL */
};

/* --- what both are over --- */

/* Returns the file whose deformation an overlay shows, too; NULL: it has only a base. */
static struct store *shown(const struct store *store)
{
	return store->inherits ? store->under : NULL;
}

/* Finds the nearest file of one chain whose state a file of the other has, too. A file that both chains have, at two of its revisions, is
 * shared as it was at the older one. *found NULL: none, they share only the base. */
static enum status find_base(struct store *ours, struct store *theirs, struct store **found)
{
	*found = NULL;
	for (struct store *a = ours; a != NULL; a = shown(a)) {
		uint64_t mine, other;
		TRY(store_lineage_state(a, &mine));
		for (struct store *b = theirs; b != NULL; b = shown(b)) {
			TRY(store_lineage_state(b, &other));
			if (mine == other) {
				*found = a;
				return STATUS_OK;
			}
			if (strcmp(a->real_path, b->real_path) == 0) {
				*found = a->commit < b->commit ? a : b;
				return STATUS_OK;
			}
		}
	}
	return STATUS_OK;
}

/* --- tiles that differ --- */

/* Lists the tiles of a table that one side or both have otherwise than the base. All three lists are in the order of keys. */
static enum status list_tiles(struct merging *merging, enum row_table table)
{
	size_t at[SIDES] = {0}, room = 0;
	mem_free(merging->items);
	merging->items = NULL;
	merging->count = 0;
	for (int side = 0; side < SIDES; side++)
		room += merging->rows[side].count[table];
	if (room == 0)
		return STATUS_OK;
	TRY(mem_make(&merging->items, room, sizeof *merging->items, "a merge"));
	for (;;) {
		uint64_t key = UINT64_MAX, hashes[SIDES] = {0};
		for (int side = 0; side < SIDES; side++)
			if (at[side] < merging->rows[side].count[table] && merging->rows[side].entries[table][at[side]].key < key)
				key = merging->rows[side].entries[table][at[side]].key;
		if (key == UINT64_MAX)
			return STATUS_OK;
		for (int side = 0; side < SIDES; side++) {
			const struct lineage_entry *entry = &merging->rows[side].entries[table][at[side]];
			if (at[side] < merging->rows[side].count[table] && entry->key == key) {
				hashes[side] = entry->hash;
				at[side]++;
			}
		}
		bool differs = hashes[OURS] != hashes[BASE] || hashes[THEIRS] != hashes[BASE];
		if (differs && tile_from_key(key).level == merging->level)
			merging->items[merging->count++] = (struct climb_item){.key = key};
	}
}

static enum status read_side(struct merging *merging, int side, enum row_table table, struct tile tile, size_t count)
{
	struct row row;
	bool found = false;
	struct store *store = merging->sides[side];
	if (store != NULL)
		TRY(store_rows_read(&store->rows, table, tile, merging->posts[side], &row, &found));
	if (!found)
		memset(merging->posts[side], 0, count * sizeof *merging->posts[side]);
	return STATUS_OK;
}

static void note_conflict(struct store_conflicts *conflicts, struct post_rect rect, int64_t posts)
{
	conflicts->posts += posts;
	for (int64_t i = 0; i < conflicts->places && i < STORE_CONFLICTS_MOST; i++) {
		struct post_rect *known = &conflicts->rects[i];
		if (known->x0 >= rect.x1 || rect.x0 >= known->x1 || known->y0 >= rect.y1 || rect.y0 >= known->y1)
			continue;
		known->x0 = known->x0 < rect.x0 ? known->x0 : rect.x0;
		known->y0 = known->y0 < rect.y0 ? known->y0 : rect.y0;
		known->x1 = known->x1 > rect.x1 ? known->x1 : rect.x1;
		known->y1 = known->y1 > rect.y1 ? known->y1 : rect.y1;
		return;
	}
	if (conflicts->places < STORE_CONFLICTS_MOST)
		conflicts->rects[conflicts->places] = rect;
	conflicts->places++;
}

/* Gives the posts of both sides together. Notes posts that both changed otherwise. */
static enum status join(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **out)
{
	struct merging *merging = user;
	struct tile tile = tile_from_key(item->key);
	const struct extent *extent = &merging->sides[OURS]->meta.extent;
	size_t side = tile_posts(extent);
	for (int i = 0; i < SIDES; i++)
		TRY(read_side(merging, i, table, tile, side * side));
	const struct post_rect own = tile_post_rect(extent, tile);
	struct post_rect rect = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	int64_t posts = 0;
	for (size_t i = 0; i < side * side; i++) {
		int32_t ours = merging->posts[OURS][i], theirs = merging->posts[THEIRS][i], base = merging->posts[BASE][i];
		scratch[i] = ours == base ? theirs : ours;
		if (PLANE_MARKS & PLANE_BIT(row_plane(table))) { /* as if both had made their marks on one ground */
			scratch[i] = ours > theirs ? ours : theirs;
			continue;
		}
		if (ours == base || theirs == base || ours == theirs)
			continue;
		int64_t x = own.x0 + (int64_t)(i % side), y = own.y0 + (int64_t)(i / side);
		rect.x0 = x < rect.x0 ? x : rect.x0;
		rect.y0 = y < rect.y0 ? y : rect.y0;
		rect.x1 = x + 1 > rect.x1 ? x + 1 : rect.x1;
		rect.y1 = y + 1 > rect.y1 ? y + 1 : rect.y1;
		posts++;
	}
	if (posts > 0 && merging->conflicts != NULL)
		note_conflict(merging->conflicts, rect, posts);
	*out = scratch;
	return STATUS_OK;
}

static enum status seek_conflicts(struct merging *merging, struct store_conflicts *conflicts, int32_t *scratch)
{
	const int32_t *posts;
	merging->conflicts = conflicts;
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		TRY(list_tiles(merging, (enum row_table)table));
		for (size_t i = 0; i < merging->count; i++)
			TRY(join(merging, (enum row_table)table, &merging->items[i], scratch, &posts));
	}
	merging->conflicts = NULL;
	if (conflicts->posts > 0)
		return fail_with(STATUS_INPUT, "%s: %s changed the same ground otherwise, at %lld places; drive them apart, or go on from one of "
				 "them", merging->sides[OURS]->path, merging->sides[THEIRS]->path, (long long)conflicts->places);
	return STATUS_OK;
}

/* --- the new overlay --- */

/* The store's time: the later one, as the record has it. Empty without marks that fade. */
static enum status age_of(struct merging *merging, char *text, size_t room)
{
	struct store_marks marks[2];
	TRY(store_marks(merging->sides[OURS], &marks[0]));
	TRY(store_marks(merging->sides[THEIRS], &marks[1]));
	const double ours = marks[0].since + marks[0].time, theirs = marks[1].since + marks[1].time;
	const struct store_marks *later = marks[1].any && (!marks[0].any || theirs > ours) ? &marks[1] : &marks[0], *other = later == &marks[0] ? &marks[1] : &marks[0];
	const struct store_marks *plants = later->rises > 0 ? later : other;
	text[0] = '\0';
	if (later->any)
		snprintf(text, room, "{\"since\":\"%a\",\"heals\":\"%a\",\"rises\":\"%a\",\"grows\":\"%a\"}", later->since + later->time,
			 later->heals > 0 ? later->heals : other->heals, plants->rises, plants->grows);
	return STATUS_OK;
}

static enum status put_header(struct merging *merging, struct store *out)
{
	const struct store_run run = {.scene_hash = "", .what = "merge"};
	const struct store *base = merging->sides[BASE];
	int64_t compacted = merging->sides[OURS]->compacted + merging->sides[THEIRS]->compacted - (base != NULL ? base->compacted : 0);
	TRY(store_meta_put_working(out, merging->level, merging->relief));
	if (compacted != 0)
		TRY(store_meta_put_integer(out, "compacted", compacted));
	char age[256];
	TRY(age_of(merging, age, sizeof age));
	return store_run_put(out, &run, age);
}

static enum status put_rows(struct merging *merging, struct store *out, int32_t *scratch)
{
	const struct climb_source source = {merging, join};
	const struct store_run run = {0};
	struct store_commit_result result = {0};
	const int32_t *posts;
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		TRY(list_tiles(merging, (enum row_table)table));
		if (!row_is_state((enum row_table)table))
			TRY(store_climb(out, (enum row_table)table, merging->items, merging->count, &source, &run, &result));
		for (size_t i = 0; i < merging->count && row_is_state((enum row_table)table); i++) {
			TRY(join(merging, (enum row_table)table, &merging->items[i], scratch, &posts));
			TRY(store_state_put_tile(out, (enum row_table)table, tile_from_key(merging->items[i].key), posts, &result));
		}
	}
	return STATUS_OK;
}

static enum status fill(struct store *out, void *user)
{
	struct merging *merging = user;
	size_t side = tile_posts(&out->meta.extent);
	int32_t *scratch = mem_alloc(side * side, sizeof *scratch);
	TRY_MEM(scratch, "a merge");
	out->has_working = true;
	out->working = merging->level;
	enum status status = put_rows(merging, out, scratch);
	mem_free(scratch);
	store_changes_drop(&out->changes);
	TRY(status);
	return put_header(merging, out);
}

static enum status settle_level(struct merging *merging)
{
	const struct store *ours = merging->sides[OURS], *theirs = merging->sides[THEIRS];
	if (ours->base_hash != theirs->base_hash)
		return fail_with(STATUS_INPUT, "%s: it is over another base than %s; merge overlays of one store", theirs->path, ours->path);
	if (ours->under == NULL || theirs->under == NULL)
		return fail_with(STATUS_INPUT, "%s: it is a whole store, not an overlay; give two overlays of one store, as furrow branch and drive --overlay make them",
				 ours->under == NULL ? ours->path : theirs->path);
	if (!ours->working_stored && !theirs->working_stored)
		return fail_with(STATUS_INPUT, "%s: neither it nor %s has ruts; drive them first", ours->path, theirs->path);
	if (ours->working_stored && theirs->working_stored && ours->working != theirs->working)
		return fail_with(STATUS_INPUT, "%s: it is deformed at a spacing of %s m, and %s at %s m; merge what has one spacing", ours->path,
				 number_exact(extent_spacing(&ours->meta.extent, ours->working)).text, theirs->path,
				 number_exact(extent_spacing(&ours->meta.extent, theirs->working)).text);
	if (ours->working_stored && theirs->working_stored &&
	    !store_relief_equal(ours->relief_text, theirs->relief_text))
		return fail_with(
			STATUS_INPUT,
			"%s: it is deformed over another relief than %s; merge what has one relief",
			ours->path, theirs->path);
	merging->level = ours->working_stored ? ours->working : theirs->working;
	merging->relief = ours->working_stored ? ours->relief_text : theirs->relief_text;
	return STATUS_OK;
}

/* Fails if there are conflicts, which are told in *conflicts. */
static enum status compare(struct merging *merging, struct store_conflicts *conflicts)
{
	struct store *ours = merging->sides[OURS];
	size_t side = tile_posts(&ours->meta.extent);
	TRY(settle_level(merging));
	TRY(find_base(ours, merging->sides[THEIRS], &merging->sides[BASE]));
	for (int i = 0; i < SIDES; i++) {
		TRY(mem_make(&merging->posts[i], side * side, sizeof *merging->posts[i], "a merge"));
		if (merging->sides[i] != NULL)
			TRY(store_lineage_make(merging->sides[i], merging->sides[i]->commit, &merging->rows[i]));
	}
	int32_t *scratch = mem_alloc(side * side, sizeof *scratch);
	TRY_MEM(scratch, "a merge");
	enum status status = seek_conflicts(merging, conflicts, scratch);
	mem_free(scratch);
	return status;
}

static enum status merge(struct merging *merging, const char *path, struct store_conflicts *conflicts)
{
	TRY(compare(merging, conflicts));
	struct store *base = merging->sides[BASE];
	const char *parent = base != NULL ? base->real_path : store_base_path(merging->sides[OURS]);
	uint64_t state = 0;
	bool earlier = base != NULL && base->shown >= 0;
	if (earlier)
		TRY(store_lineage_state(base, &state));
	return store_overlay_make(path, parent, earlier ? &state : NULL, NULL, fill, merging);
}

enum status store_merge(const char *ours, const char *theirs, const char *path, struct store_conflicts *conflicts)
{
	struct merging merging = {0};
	const struct store_options reading = {.mode = STORE_READ};
	*conflicts = (struct store_conflicts){0};
	enum status status;
	TRY_OR(done, store_open(ours, &reading, &merging.sides[OURS]));
	TRY_OR(done, store_open(theirs, &reading, &merging.sides[THEIRS]));
	TRY_OR(done, merge(&merging, path, conflicts));
done:
	conflicts->level = merging.level;
	mem_free(merging.items);
	for (int i = 0; i < SIDES; i++) {
		store_lineage_finish(&merging.rows[i]);
		mem_free(merging.posts[i]);
	}
	store_close(merging.sides[OURS]);
	store_close(merging.sides[THEIRS]);
	return status;
}
