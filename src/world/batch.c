/*
 * Contacts of one step that wait, to be computed together (deform/batch.c).
 *
 * Contacts act in the order of the events. But two contacts whose windows share no post may act in any order, or together: neither reads
 * or changes a post of the other. So each contact that waits has a round. It is one more than the last round of those that share a block of
 * posts with it. Rounds are computed one after another. The contacts of a round share no post, so they are computed in batches.
 *
 * Invariants: (1) Tiles are pinned only while their batch is computed. (2) A contact that is computed alone first waits for all that share
 * a block with it. (3) Nothing waits between steps, nor while soil relaxes.
 */
#include <string.h>

#include "world/internal.h"

#define TILES_MOST DEFORM_BATCH_TILES /* of a contact that may wait: with smaller tiles it is computed alone */
#define WAITING_MOST 8192

struct waiting {
	const struct event *event;
	struct deform_contact contact;
	struct deform_window window;
	uint64_t keys[TILES_MOST];
	size_t tiles;
	size_t round;
};

/* One of a batch that is being computed. */
struct chosen {
	const struct waiting *waiting;
	bool held;
};

struct batches {
	struct waiting *list;
	size_t count, room, rounds;
	struct key_map last;  /* of a block: the last round, from 1, of the contacts whose windows have posts in it */
	size_t *order;        /* contacts by round */
	size_t order_room;
	struct chosen chosen[DEFORM_BATCH_MOST];
	size_t chosen_count;
};

enum status world_batches_create(struct world *world)
{
	struct deform_params params;
	world_deform_params(world, &params);
	if (!params.batches)
		return STATUS_OK;
	return mem_zeroed(&world->batches, 1, sizeof *world->batches, "contacts that wait");
}

void world_batches_free(struct world *world)
{
	if (world->batches == NULL)
		return;
	key_map_finish(&world->batches->last);
	mem_free_all(world->batches->list, world->batches->order, world->batches);
	world->batches = NULL;
}

/* Lists the tiles that hold a post of the rectangle. Returns their number; more than `room`: they are not listed. */
static size_t tiles_of(const struct world *world, struct post_rect rect, uint64_t *keys, size_t room)
{
	struct tile first, last;
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, rect, &first, &last))
		return 0;
	size_t count = (size_t)(last.x - first.x + 1) * (last.y - first.y + 1), at = 0;
	for (uint32_t y = first.y; y <= last.y && count <= room; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			keys[at++] = tile_key((struct tile){world->resident.level, x, y});
	return count;
}

static size_t last_round(const struct batches *batches, struct post_rect rect)
{
	const struct post_rect blocks = world_blocks_of(rect);
	size_t last = 0;
	for (int64_t y = blocks.y0; y < blocks.y1; y++)
		for (int64_t x = blocks.x0; x < blocks.x1; x++) {
			const struct key_pair *pair = key_map_find(&batches->last, world_block_key(x, y));
			if (pair != NULL && (size_t)pair->a > last)
				last = (size_t)pair->a;
		}
	return last;
}

static enum status add(struct batches *batches, const struct waiting *waiting)
{
	const struct post_rect blocks = world_blocks_of(waiting->window.read);
	TRY(mem_grow(&batches->list, &batches->room, batches->count + 1, sizeof *batches->list, "contacts that wait"));
	batches->list[batches->count++] = *waiting;
	enum status status = STATUS_OK;
	for (int64_t y = blocks.y0; y < blocks.y1; y++)
		for (int64_t x = blocks.x0; x < blocks.x1 && status == STATUS_OK; x++)
			status = key_map_put(&batches->last, world_block_key(x, y), (double)waiting->round, 0);
	return status;
}

/* Returns the round of the last contact of a body that waits; 0: none does. The search for the height of a loaded body begins at the height
 * that its last contact found. So its contacts keep their order, even if it jumped, and they share no post. */
static size_t round_of_body(const struct batches *batches, size_t body)
{
	for (size_t i = batches->count; i > 0; i--)
		if (batches->list[i - 1].event->body == body)
			return batches->list[i - 1].round;
	return 0;
}

enum status world_batches_take(struct world *world, const struct event *event, const struct deform_contact *contact,
			       const struct deform_window *windows, size_t count, bool *taken)
{
	struct batches *batches = world->batches;
	struct waiting waiting = {.event = event, .contact = *contact, .window = windows[0]};
	*taken = deform_is_batched(world->deform, contact, windows, count);
	if (*taken) {
		waiting.tiles = tiles_of(world, windows[0].read, waiting.keys, TILES_MOST);
		*taken = waiting.tiles > 0 && waiting.tiles <= TILES_MOST;
	}
	const size_t before = contact->load > 0 ? round_of_body(batches, event->body) : 0;
	if (!*taken && before > 0)
		return world_batches_flush(world);
	if (!*taken)
		return world_batches_flush_near(world, windows, count);
	if (batches->count == WAITING_MOST)
		TRY(world_batches_flush(world));
	const size_t near = last_round(batches, windows[0].read), own = batches->count > 0 ? before : 0;
	waiting.round = (near > own ? near : own) + 1;
	batches->rounds = waiting.round > batches->rounds ? waiting.round : batches->rounds;
	return add(batches, &waiting);
}

enum status world_batches_flush_near(struct world *world, const struct deform_window *windows, size_t count)
{
	struct batches *batches = world->batches;
	bool near = false;
	for (size_t i = 0; i < count && !near && batches->count > 0; i++)
		near = last_round(batches, windows[i].read) > 0;
	return near ? world_batches_flush(world) : STATUS_OK;
}

static void release(struct world *world, struct chosen *chosen)
{
	for (size_t i = 0; i < chosen->waiting->tiles && chosen->held; i++)
		page_cache_unpin(world->resident.cache, chosen->waiting->keys[i]);
	chosen->held = false;
}

/* Pins the tiles of a contact and adds its window to the batch. *added is false if the batch has no room. */
static enum status choose(struct world *world, const struct waiting *waiting, bool *added)
{
	struct batches *batches = world->batches;
	struct held_tiles held;
	enum status status = world_hold(world, waiting->window.read, &held);
	*added = false;
	if (status != STATUS_OK)
		return status;
	struct chosen *chosen = &batches->chosen[batches->chosen_count];
	*chosen = (struct chosen){.waiting = waiting, .held = true};
	status = deform_batch_add(world->deform, &waiting->contact, &waiting->window, held.tiles, held.count, added);
	if (status == STATUS_OK && *added)
		batches->chosen_count++;
	else
		release(world, chosen);
	return status;
}

/* Marks what a window of the batch changed. */
static enum status mark(struct world *world, const struct waiting *waiting)
{
	struct held_tiles held = {.count = waiting->tiles};
	for (size_t i = 0; i < waiting->tiles; i++) {
		held.keys[i] = waiting->keys[i];
		held.tiles[i].tile = tile_from_key(waiting->keys[i]);
	}
	enum status status;
	TRY_OR(done, world_tell_contact(world, waiting->event, &waiting->contact, &waiting->window, 1));
	TRY_OR(done, world_mark(world, waiting->window.write, &held));
done:
	world_happened_relaxes(world);
	return status;
}

/* Computes the contacts that were chosen. A contact without others is counted as one that is computed alone. */
static enum status compute(struct world *world)
{
	struct batches *batches = world->batches;
	TRY(deform_batch_compute(world->deform));
	for (size_t i = 0; i < batches->chosen_count; i++)
		TRY(mark(world, batches->chosen[i].waiting));
	if (batches->chosen_count == 1)
		world_count_windows(world_body_at(world, batches->chosen[0].waiting->event->body), &batches->chosen[0].waiting->contact, 1);
	return STATUS_OK;
}

/* Computes contacts order[*at] .. that are of one round, as many as fit a batch. Half of the slots remain for other tiles. */
static enum status one_batch(struct world *world, size_t *at)
{
	struct batches *batches = world->batches;
	const size_t round = batches->list[batches->order[*at]].round, most = world->facts.limits.slots / 2;
	size_t tiles = 0;
	bool added = true;
	enum status status = STATUS_OK;
	batches->chosen_count = 0;
	deform_batch_begin(world->deform);
	while (*at < batches->count && batches->chosen_count < DEFORM_BATCH_MOST) {
		const struct waiting *waiting = &batches->list[batches->order[*at]];
		tiles += waiting->tiles;
		if (waiting->round != round || (batches->chosen_count > 0 && tiles > most))
			break;
		status = choose(world, waiting, &added);
		if (status != STATUS_OK || !added)
			break;
		++*at;
	}
	if (status == STATUS_OK)
		status = compute(world);
	for (size_t i = 0; i < batches->chosen_count; i++)
		release(world, &batches->chosen[i]);
	return status;
}

/* Fills `order`: contacts by round, those of one round in the order of the events. */
static enum status sort(struct batches *batches)
{
	const size_t needed = batches->count + batches->rounds + 1;
	TRY(mem_grow(&batches->order, &batches->order_room, needed, sizeof *batches->order, "contacts that wait"));
	size_t *first = batches->order + batches->count; /* of a round: how many come before it */
	memset(first, 0, (batches->rounds + 1) * sizeof *first);
	for (size_t i = 0; i < batches->count; i++)
		first[batches->list[i].round]++;
	for (size_t round = 1; round <= batches->rounds; round++)
		first[round] += first[round - 1];
	for (size_t i = 0; i < batches->count; i++)
		batches->order[first[batches->list[i].round - 1]++] = i;
	return STATUS_OK;
}

void world_batches_forget(struct world *world)
{
	struct batches *batches = world->batches;
	if (batches == NULL || batches->count == 0)
		return;
	batches->count = batches->rounds = 0;
	key_map_clear(&batches->last);
}

enum status world_batches_flush(struct world *world)
{
	struct batches *batches = world->batches;
	if (batches == NULL || batches->count == 0)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, sort(batches));
	for (size_t at = 0; at < batches->count;)
		TRY_OR(done, one_batch(world, &at));
done:
	world_batches_forget(world);
	return status;
}
