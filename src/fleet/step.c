/*
 * Before a step: who computes what. All ranks tell where soil may slide on their ground, and what they have for rank 0.
 *
 * A plan holds for some steps, in which ranks do not wait for each other: areas are those of all these steps. The more steps, the larger
 * the areas, and the more bodies share tiles. So bodies may travel a quarter of a tile in them, and soil may spread by one block. Vehicles go
 * where the soil lets them, so with vehicles each step has a plan.
 */
#include "fleet/internal.h"

#include <math.h>
#include <string.h>

#define BALANCE_PLANS 16 /* plans after which work is balanced again */
#define HORIZON_MOST 16  /* steps of a plan */
#define TILE_SHARE 0.25  /* of a tile's side that a body may travel in the steps of a plan */
#define INTERVALS_MOST 2 /* of relaxation in the steps of a plan, if one step has fewer */

struct planning {
	struct fleet *fleet;
	double until;
};

/* --- tiles --- */

bool fleet_tiles_of(const struct fleet *fleet, struct post_rect posts, struct fleet_item *item)
{
	const struct world *world = fleet->world;
	struct tile first, last;
	if (!tile_range_of(&world_resident(world)->meta->extent, world_resident(world)->level, posts, &first, &last))
		return false;
	item->x0 = first.x;
	item->y0 = first.y;
	item->x1 = last.x;
	item->y1 = last.y;
	return true;
}

struct fleet_item fleet_block_item(const struct fleet *fleet, struct soil_block block, int64_t intervals)
{
	struct fleet_item item = {.owner = fleet->rank, .weight = 1};
	/* A block is inside the terrain, so it has tiles. */
	(void)fleet_tiles_of(fleet, world_block_area(fleet->world, block, intervals), &item);
	return item;
}

/* --- telling --- */

static enum status put_links(struct fleet *fleet, double until)
{
	const struct world *world = fleet->world;
	const int64_t intervals = world_intervals_due(world, until);
	const struct soil_block *blocks;
	size_t count = 0;
	uint32_t links = 0; /* active blocks that lie on the same tiles are told as one */
	if (!world_changes_ground(world))
		return fleet_put(&fleet->sent, &links, sizeof links);
	TRY(world_active_blocks(world, &blocks, &count));
	const size_t at = fleet->sent.size;
	struct fleet_link last = {0};
	TRY(fleet_put(&fleet->sent, &links, sizeof links));
	for (size_t i = 0; i <= count; i++) {
		struct fleet_link link = {0};
		if (i < count) {
			const struct fleet_item item = fleet_block_item(fleet, blocks[i], intervals);
			link = (struct fleet_link){item.x0, item.y0, item.x1, item.y1, 1};
		}
		const bool same = i < count && last.weight > 0 && link.x0 == last.x0 && link.y0 == last.y0 && link.x1 == last.x1 && link.y1 == last.y1;
		if (same) {
			last.weight++;
			continue;
		}
		if (last.weight > 0) {
			TRY(fleet_put(&fleet->sent, &last, sizeof last));
			links++;
		}
		last = link;
	}
	memcpy(fleet->sent.bytes + at, &links, sizeof links);
	return STATUS_OK;
}

static enum status take_links(void *user, int rank, struct fleet_bytes *bytes)
{
	const struct planning *planning = user;
	struct fleet *fleet = planning->fleet;
	uint32_t links;
	TRY(fleet_rows_get(fleet, bytes));
	TRY(fleet_get(bytes, &links, sizeof links));
	for (uint32_t i = 0; i < links; i++) {
		struct fleet_link link;
		TRY(fleet_get(bytes, &link, sizeof link));
		TRY(fleet_groups_add(&fleet->groups, &(struct fleet_item){link.x0, link.y0, link.x1, link.y1, rank, link.weight, 0}));
	}
	return fleet_grains_get_links(fleet, rank, bytes);
}

/* --- planning --- */

static enum status make_owners(struct fleet *fleet)
{
	const size_t count = world_body_count(fleet->world);
	TRY(mem_grow(&fleet->planned_bodies, &fleet->planned_room, count, sizeof *fleet->planned_bodies, "the ranks of bodies"));
	fleet->planned_count = 0;
	if (count <= fleet->owner_count)
		return STATUS_OK;
	TRY(mem_resize(&fleet->owners, count, sizeof *fleet->owners, "the ranks of bodies"));
	while (fleet->owner_count < count)
		fleet->owners[fleet->owner_count++] = FLEET_NONE;
	return STATUS_OK;
}

/* Bodies come first, in the scene's order. A body with no tile to touch keeps its rank. */
static enum status add_bodies(struct fleet *fleet, double until)
{
	const struct world *world = fleet->world;
	struct post_rect *areas;
	struct fleet_item item;
	TRY(make_owners(fleet));
	TRY(fleet_together_need(&fleet->together, fleet->owner_count));
	areas = fleet->together.areas;
	for (size_t i = 0; i < fleet->owner_count; i++) {
		if (!world_ranked(world, i))
			continue;
		areas[fleet->planned_count] = world_body_area(world, i, until);
		if (fleet_tiles_of(fleet, areas[fleet->planned_count], &item))
			fleet->planned_bodies[fleet->planned_count++] = i;
		else if (fleet->owners[i] == FLEET_NONE)
			fleet->owners[i] = 0;
	}
	if (world_meets(world))
		TRY(fleet_together_join(&fleet->together, fleet->planned_count));
	for (size_t i = 0; i < fleet->planned_count; i++) {
		item = (struct fleet_item){.owner = fleet->owners[fleet->planned_bodies[i]], .weight = 1};
		(void)fleet_tiles_of(fleet, areas[i], &item); /* it has some */
		TRY(fleet_groups_add(&fleet->groups, &item));
	}
	return STATUS_OK;
}

static void note_balance(struct fleet *fleet)
{
	uint64_t most = 0, all = 0;
	for (int r = 0; r < fleet->ranks; r++) {
		all += fleet->groups.loads[r];
		most = fleet->groups.loads[r] > most ? fleet->groups.loads[r] : most;
	}
	fleet->balance += all > 0 ? (double)most * fleet->ranks / (double)all : 1;
}

/* Returns for how many steps plans hold. The same on every rank. */
static int64_t horizon_of(const struct fleet *fleet)
{
	const struct world *world = fleet->world;
	const struct scene *scene = world_scene(world);
	double fastest = 0, steps = HORIZON_MOST;
	if (scene->vehicle_count > 0 || world_grains_most(world) > 0) /* grains fly far */
		return 1;
	for (size_t i = 0; i < scene->object_count; i++)
		if (world_body(world, i)->kind == BODY_PATH)
			fastest = fmax(fastest, motion_track_fastest(world_body(world, i)->track));
	if (fastest > 0)
		steps = fmin(steps, TILE_SHARE * world_resident(world)->spacing * world_resident(world)->meta->extent.cells / (fastest * scene->time_step));
	if (deform_conserves(scene->model))
		steps = fmin(steps, INTERVALS_MOST * scene->interval / scene->time_step);
	return steps >= 2 ? (int64_t)steps : 1;
}

/* Tells whether a body leaves the ground before `until`. Then each step has a plan, so that all ranks end after the same step. */
static bool leaves(struct fleet *fleet, double until)
{
	struct world *world = fleet->world;
	if (world_scene(world)->outside != SCENE_STOP)
		return false;
	return world_check_events(world, until) != STATUS_OK;
}

static enum status put_plan(struct fleet *fleet, double until)
{
	TRY(fleet_grains_allowed(fleet));
	TRY(fleet_begin(fleet, FLEET_STEP, STATUS_OK));
	TRY(fleet_rows_put(fleet));
	TRY(put_links(fleet, until));
	TRY(fleet_grains_put_links(fleet));
	return add_bodies(fleet, until); /* bodies are items before links */
}

/* A failure of any rank is returned on all. *mine: a failure of this rank alone, after which the others go on to move what the plan moves. */
static enum status plan(struct fleet *fleet, double until, enum status status, enum status *mine)
{
	struct planning planning = {fleet, until};
	struct fleet_told told;
	const struct world *world = fleet->world;
	fleet_groups_clear(&fleet->groups);
	world_forget_events(fleet->world); /* so that areas are the same on all ranks */
	if (fleet->horizon == 0)
		fleet->horizon = horizon_of(fleet);
	fleet->ahead = fleet->horizon;
	if (fleet->horizon > 1)
		until = world_step_time(world_scene(world), world_steps_done(world) + fleet->horizon);
	fleet->intervals = world_intervals_due(world, until);
	fleet->until = until;
	fleet->leaves = fleet->horizon > 1 && status == STATUS_OK && leaves(fleet, until);
	if (status == STATUS_OK)
		status = put_plan(fleet, until);
	TRY(fleet_tell(fleet, FLEET_STEP, status, &told, take_links, &planning));
	TRY(fleet_grains_check(fleet));
	fleet->stop = fleet->stop || told.stop;
	if (told.leaves)
		fleet->ahead = 1; /* the areas are larger than they need be */
	*mine = world_steps_done(world) > 0 ? fleet_rows_write(fleet, world_step_time(world_scene(world), world_steps_done(world))) : STATUS_OK;
	if (told.due)
		*mine = fleet_commit(fleet, *mine);
	if (fleet->failed)
		return *mine;
	if (fleet_groups_make(&fleet->groups, world_resident(world)->level, fleet->ranks, fleet->plans % BALANCE_PLANS == BALANCE_PLANS - 1) != STATUS_OK)
		fleet_comm_give_up(failure_message());
	return STATUS_OK;
}

enum status fleet_step(void *user, double until, enum status status)
{
	struct fleet *fleet = user;
	struct world *world = fleet->world;
	if (fleet->plans > 0 && fleet->ahead > 1 && world_steps_done(world) < fleet->planned_until && !world_unplaced(world)) {
		fleet->steps++;
		note_balance(fleet);
		return status;
	}
	if (fleet->plans == 0) {
		fleet->began = clock_process_seconds();
		fleet->spun = 0;
	}
	const double began = clock_thread_seconds(), spun = fleet->spun;
	enum status mine = STATUS_OK;
	status = plan(fleet, until, status, &mine);
	const double planned = clock_thread_seconds();
	fleet->planning += planned - began - (fleet->spun - spun);
	TRY(status);
	note_balance(fleet);
	fleet->plans++;
	fleet->steps++;
	fleet->planned_until = world_steps_done(world) + fleet->ahead;
	world_placed(world);
	/* From here on this rank's ground is not whole until the end of the step. */
	world_tear(world);
	const double waited = fleet->spun;
	status = fleet_move(fleet, mine);
	fleet->moving += clock_thread_seconds() - planned - (fleet->spun - waited);
	TRY(status);
	world_mend(world);
	return STATUS_OK;
}

/* --- tiles of this rank --- */

bool fleet_has(void *user, uint64_t key)
{
	const struct fleet *fleet = user;
	const int32_t owner = fleet_groups_owner(&fleet->groups, key);
	return owner == fleet->rank || owner == FLEET_NONE;
}

bool fleet_is_changed(const struct fleet *fleet, uint64_t key)
{
	uint32_t number;
	return key_set_find(&fleet->changed, key, &number) && fleet->mine[number];
}

enum status fleet_note_changed(struct fleet *fleet, uint64_t key, bool mine)
{
	uint32_t number;
	bool fresh;
	TRY(key_set_number(&fleet->changed, key, &number, &fresh));
	TRY(mem_grow(&fleet->mine, &fleet->mine_room, (size_t)number + 1, sizeof *fleet->mine, "the tiles of a rank"));
	fleet->mine[number] = mine;
	return STATUS_OK;
}

enum status fleet_changes(void *user, uint64_t key)
{
	struct fleet *fleet = user;
	if (fleet_groups_owner(&fleet->groups, key) != fleet->rank)
		return fail_with(STATUS_FAILED, "ranks: a step changes ground of another rank; report this");
	return fleet_note_changed(fleet, key, true);
}
