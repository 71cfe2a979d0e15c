/*
 * Relaxation of the whole ground. Every `interval` of simulated time soil slides in active blocks, after the path samples of
 * the same time. Tiles are pinned only while posts are gathered from them, and while posts are scattered to them.
 */
#include <math.h>

#include "world/internal.h"

/* Returns the number of intervals that are over at `time`. They end at multiples of the interval. */
int64_t world_intervals_by(const struct world *world, double time)
{
	double interval = world->scene->interval, whole = floor(time / interval);
	if (!deform_conserves(world->scene->model) || !(whole < 0x1p52)) /* none, or more blocks than exist */
		return 0;
	int64_t count = (int64_t)whole;
	while ((double)(count + 1) * interval <= time)
		count++;
	while (count > 0 && (double)count * interval > time)
		count--;
	return count;
}

void world_intervals_from(struct world *world, double time)
{
	world->relaxation.intervals = world_intervals_by(world, time);
}

enum status world_wake_all(struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct post_rect all = {0, 0, extent_posts(extent->width, world->resident.level), extent_posts(extent->height, world->resident.level)};
	return world_wake(world, all);
}

size_t world_rests(const struct world *world)
{
	const double time = (double)(world->relaxation.intervals + 1) * world->scene->interval;
	const bool kinematic = !world_feels(world);
	size_t count = 0;
	for (size_t i = 0; i < world->body_count; i++) {
		const struct body *body = world->bodies[i];
		if (body != NULL && body->has_last && !body->host.removed && !body->elsewhere)
			world->relaxation.rests[count++] = (struct deform_rest){&body->object->shape, body->last, body->loaded_body, kinematic && world_is_at_rest(body, time)};
	}
	return count;
}

static enum status gather_part(struct world *world, struct bearing *hand, size_t region, struct post_rect part)
{
	struct held_tiles held;
	if (post_rect_empty(part))
		return STATUS_OK;
	TRY(world_hold(world, part, &held));
	if (world->bearing != NULL)
		bearing_interval_gather(hand, held.tiles, held.count);
	else
		deform_interval_gather_part(world->deform, region, held.tiles, held.count);
	world_release(world, &held);
	return STATUS_OK;
}

/* Gathers a region from tiles that are pinned four at a time, however many it reads. hand: of bearing. */
static enum status gather(struct world *world, struct bearing *hand, size_t region)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct post_rect reads = world->bearing != NULL ? bearing_interval_reads(world->bearing, region) : deform_interval_reads(world->deform, region);
	const int64_t cells = extent->cells;
	struct tile first, last;
	if (hand != NULL)
		TRY(bearing_interval_start(hand, region));
	bool any = tile_range_of(extent, world->resident.level, reads, &first, &last);
	for (uint32_t y = first.y; any && y <= last.y; y += 2)
		for (uint32_t x = first.x; x <= last.x; x += 2) {
			/* Tiles x, x + 1 and y, y + 1, without the posts that they share with others. */
			struct post_rect part = post_rect_intersect(reads, (struct post_rect){x * cells + (x > first.x), y * cells + (y > first.y),
											  (x + 2) * cells, (y + 2) * cells});
			TRY(gather_part(world, hand, region, part));
		}
	if (hand != NULL)
		return STATUS_OK;
	return deform_interval_gather(world->deform, region, NULL, 0);
}

/* Regions that are computed at once. */
struct regions {
	struct bearing *bearing;
	size_t first;
};

static enum status slide(void *user, size_t member, size_t number)
{
	const struct regions *regions = user;
	(void)member;
	return bearing_interval_slide(bearing_hand(regions->bearing, number), regions->first + number);
}

/* Gathers and computes all regions of soil that the CPU computes. */
static enum status slide_all(struct world *world, size_t count)
{
	struct bearing *bearing = world->bearing;
	double posts = 0;
	for (size_t i = 0; i < count; i++) {
		const struct post_rect reads = bearing_interval_reads(bearing, i);
		posts += (double)(reads.x1 - reads.x0) * (double)(reads.y1 - reads.y0);
	}
	const size_t hands = world_hands_for(world, posts);
	for (size_t first = 0; first < count; first += hands) {
		const size_t some = count - first < hands ? count - first : hands;
		for (size_t i = 0; i < some; i++)
			TRY(gather(world, bearing_hand(bearing, i), first + i));
		TRY(world_crew_run(world, some, slide, &(struct regions){bearing, first}));
		TRY(bearing_hands_join(bearing));
	}
	return STATUS_OK;
}

/* Writes a part of the result back: the region of soil that bears, or a run of regions. */
static enum status scatter(struct world *world, size_t i)
{
	const struct post_rect writes = world->bearing != NULL ? bearing_interval_writes(world->bearing, i) : deform_interval_writes(world->deform, i);
	struct held_tiles held;
	enum status status;
	TRY_OR(done, world_hold(world, writes, &held));
	TRY_OR(done, world->bearing != NULL ? bearing_interval_scatter(world->bearing, i, held.tiles, held.count)
	       : deform_interval_scatter(world->deform, i, held.tiles, held.count));
	TRY_OR(done, world_mark(world, writes, &held));
done:
	world_release(world, &held);
	return status;
}

struct interval_size {
	size_t blocks, regions, parts; /* active blocks; regions that are gathered; parts of the result */
};

static enum status begin_interval(struct world *world, struct interval_size *size)
{
	const struct deform_rest *rests = world->relaxation.rests;
	const size_t count = world_rests(world);
	struct bearing_interval bearing = {0};
	struct deform_interval deform = {0};
	const enum status status = world->bearing != NULL ? bearing_interval_begin(world->bearing, rests, count, &bearing)
							  : deform_interval_begin(world->deform, rests, count, &deform);
	*size = world->bearing != NULL ? (struct interval_size){bearing.blocks, bearing.regions, bearing.regions}
				       : (struct interval_size){deform.blocks, deform.regions, deform.runs};
	return status;
}

static enum status interval(struct world *world, size_t *blocks)
{
	struct interval_size size;
	TRY(begin_interval(world, &size));
	*blocks = size.blocks;
	if (world->bearing != NULL)
		TRY(slide_all(world, size.regions));
	for (size_t i = 0; i < size.regions && world->bearing == NULL; i++)
		TRY(gather(world, NULL, i));
	for (size_t i = 0; i < size.parts; i++)
		TRY(scatter(world, i));
	if (*blocks == 0)
		return world_carried_settle(world, (double)(world->relaxation.intervals + 1) * world->scene->interval, world_rests(world));
	TRY(world->bearing != NULL ? bearing_interval_end(world->bearing) : deform_interval_end(world->deform));
	return world_carried_settle(world, (double)(world->relaxation.intervals + 1) * world->scene->interval, world_rests(world));
}

static enum status one_interval(struct world *world, size_t *blocks)
{
	const enum status status = interval(world, blocks);
	struct page_stats pages;
	int64_t side = (world->resident.meta->extent.cells + SOIL_BLOCK - 1) / SOIL_BLOCK;
	page_cache_stats(world->resident.cache, &pages);
	world->counts.visited += *blocks;
	world->counts.possible += pages.touched * (uint64_t)(side * side);
	return status;
}

/* Runs intervals until `over` of them are over. rows: forces may be told at their ends. */
static enum status run_until(struct world *world, int64_t over, bool rows)
{
	while (world->relaxation.intervals < over) {
		size_t blocks = 0;
		const double ends = (double)(world->relaxation.intervals + 1) * world->scene->interval;
		TRY(world_batches_flush(world));
		if (rows && world_carries(world))
			TRY(world_forces_early(world->forces, ends));
		if (world->thrown != NULL)
			TRY(world_thrown_until(world, ends, true));
		TRY(one_interval(world, &blocks));
		/* If no block is active, none becomes active by itself, by what lands, or by soil aboard. */
		world->relaxation.intervals = blocks > 0 || world_thrown_flies(world) || world_carried_unsettled(world) ? world->relaxation.intervals + 1 : over;
	}
	return STATUS_OK;
}

enum status world_intervals(struct world *world, double time, bool at_it)
{
	if (!world_changes_ground(world) || !deform_conserves(world->scene->model))
		return STATUS_OK;
	enum status status = STATUS_OK;
	int64_t over = world_intervals_by(world, time);
	if (!at_it && over > 0 && (double)over * world->scene->interval >= time)
		over--;
	if (world->relaxation.intervals >= over && world->thrown == NULL)
		return STATUS_OK;
	const enum world_stage stage = world_stage_enter(world, WORLD_RELAX);
	TRY_OR(done, run_until(world, over, true));
	if (world->thrown != NULL)
		TRY_OR(done, world_thrown_until(world, time, at_it));
done:
	world_stage_enter(world, stage);
	return status;
}

enum status world_relax_for(struct world *world, double seconds)
{
	const enum world_stage stage = world_stage_enter(world, WORLD_RELAX);
	const enum status status = run_until(world, world->relaxation.intervals + (int64_t)ceil(seconds / world->scene->interval), false);
	world_stage_enter(world, stage);
	return status;
}

enum status world_let_go(struct world *world, struct body *body)
{
	const struct deform_contact rest = {.shape = &body->object->shape, .from = body->last, .to = body->last, .loaded_body = body->loaded_body, .leaves = deform_is_elastic(world->scene->model)};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count = 0;
	if (!body->has_last || body->elsewhere || !deform_raises(world->scene->model))
		return STATUS_OK;
	if (deform_is_elastic(world->scene->model))
		return world->bearing != NULL ? world_kinematic_leave(world, &rest) : world_contact_leave(world, body, &rest);
	TRY(deform_cut(&world->surface, &rest, windows, &count));
	for (size_t i = 0; i < count; i++)
		TRY(world_wake(world, windows[i].write));
	return STATUS_OK;
}
