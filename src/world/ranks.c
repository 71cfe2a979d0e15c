/*
 * A world that several processes (ranks) step together. A rank asks its own world here which ground a step may touch. And bodies, blocks
 * and tiles that move to another rank are packed and unpacked here.
 *
 * Every rank has all bodies. A body that is `elsewhere` has no events here, no contacts and no rows. Its state is then only what every
 * rank knows: its next path sample. Bodies of vehicles move on every rank alike, and only their contacts with the ground are computed on
 * one rank.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

/* --- where bodies are --- */

bool world_ranked(const struct world *world, size_t number)
{
	return world_follows_path(world, number) || world_is_set_down(world_body(world, number));
}

void world_forget_events(struct world *world)
{
	while (world->events.count > 0)
		world->bodies[world->events.list[--world->events.count].body]->next--;
}

void world_body_here(struct world *world, size_t number, bool here)
{
	world->bodies[number]->elsewhere = !here;
}

/* --- what a step may touch --- */

static void include(struct post_rect *area, const struct world *world, int64_t x, int64_t y, int64_t posts)
{
	const double spacing = world->resident.spacing;
	const int64_t post_x = (int64_t)floor(lattice_offset_metres(x) / spacing), post_y = (int64_t)floor(lattice_offset_metres(y) / spacing);
	*area = post_rect_around(*area, (struct post_rect){post_x - posts, post_y - posts, post_x + posts + 2, post_y + posts + 2});
}

int64_t world_intervals_due(const struct world *world, double until)
{
	return deform_conserves(world->scene->model) ? world_intervals_by(world, until) - world->relaxation.intervals : 0;
}

/* In each interval soil may begin to slide in the blocks next to those where it slid, and an interval reads a rim around blocks. */
static int64_t slides_beyond(const struct world *world, int64_t intervals)
{
	return (intervals > 1 ? intervals - 1 : 0) * SOIL_BLOCK + world_interval_rim(world);
}

struct post_rect world_block_area(const struct world *world, struct soil_block block, int64_t intervals)
{
	const int64_t x = block.x * SOIL_BLOCK, y = block.y * SOIL_BLOCK;
	return post_rect_grown((struct post_rect){x, y, x + SOIL_BLOCK, y + SOIL_BLOCK}, slides_beyond(world, intervals));
}

struct post_rect world_slides_from(const struct world *world, struct post_rect changed, int64_t intervals)
{
	return post_rect_grown(world_wakes(world, changed), slides_beyond(world, intervals));
}

#define STEEPEST 8.0 /* a rim on a slope runs so many times faster than the body goes in plan, at most */
#define WHIRLS 128.0 /* 1/s: a corner of a path turns a body at once, and that speed is measured over 2^-6 s */

/* Returns how far grains come that a body on a path throws until then, m. */
static double path_throws(const struct world *world, const struct body *body, double seconds)
{
	const struct scene_object *object = body->object;
	const double runs = 1 + (object->slip < 1 ? STEEPEST / (1 - object->slip) : 0);
	const double whirls = body->carried != NULL ? WHIRLS * soil_shape_bound(&object->shape) * seconds : 0; /* of soil that falls off it */
	return runs * (motion_track_fastest(body->track) * seconds + world->resident.spacing) + whirls; /* a sample's motion is of a post's way */
}

/* The same of a body that a host moves: by its motion since its last contact, and by its rates. */
static double host_throws(const struct body *body, double seconds)
{
	const struct body_hosted *host = &body->host;
	const struct furrow_state *now = &host->now, *next = host->has_next ? &host->next : &host->now;
	const double radius = soil_shape_bound(&body->object->shape);
	double spin = 0, rotated = 0, fast = 0, way = 0;
	for (int k = 0; k < 3; k++) {
		spin += fabs(now->angular[k]) + fabs(next->angular[k]);
		fast += fabs(now->linear[k]) + fabs(next->linear[k]);
		rotated += fabs(host->rotated[k]);
		way += fabs(next->pose.position[k] - now->pose.position[k]);
	}
	if (body->has_last)
		way += fabs(now->pose.position[0] - lattice_offset_metres(body->last.x)) + fabs(now->pose.position[1] - lattice_offset_metres(body->last.y)) +
		       fabs(now->pose.position[2] - lattice_offset_metres(body->last.z));
	const double belt = body->object->shape.belt ? fabs(host->turned) + (fabs(host->belt.speed) + fabs(host->next_belt.speed)) * seconds : 0;
	const double runs = (rotated + fabs(host->turned) + spin * seconds) * radius + belt;
	return 3 * (isfinite(fast) ? way + fast * seconds : way) + 3 * (isfinite(runs) ? runs : 0);
}

/* Returns how many posts beyond its place a body's grains may come down, until then; 0: nothing is thrown. */
static int64_t throws_beyond(const struct world *world, const struct body *body, double until)
{
	const double seconds = fmax(until - world->time, 0), spacing = world->resident.spacing;
	if (world->thrown == NULL)
		return 0;
	const double way = soil_shape_bound(&body->object->shape) + (world_is_hosted(body) ? host_throws(body, seconds) : path_throws(world, body, seconds));
	return (int64_t)ceil(way / spacing) + BEARING_LANDS_NEAR + 3;
}

/* Includes the last path sample that was made, and all that are due until then. Samples are one post apart. The way between two
 * of them is so much longer than the straight line. No place on it is farther than half of that from the rectangle around both. */
static void include_path(const struct world *world, const struct body *body, double until, int64_t posts, struct post_rect *area)
{
	struct track_point from, to;
	const int64_t first = body->next > 0 ? body->next - 1 : 0, end = (int64_t)world_samples_until(body->track, until);
	if (end <= first)
		return;
	motion_track_sample(body->track, first, &from);
	motion_track_sample(body->track, end - 1, &to);
	const double straight = hypot(to.x - from.x, to.y - from.y) / world->resident.spacing, way = (double)(end - 1 - first);
	const int64_t more = posts + (int64_t)ceil(fmax(way - straight, 0) / 2);
	include(area, world, from.qx, from.qy, more);
	include(area, world, to.qx, to.qy, more);
}

static void include_hosted(const struct world *world, const struct body *body, int64_t posts, struct post_rect *area)
{
	const struct furrow_state *states[] = {&body->host.now, &body->host.next};
	for (int i = 0; i < 1 + body->host.has_next; i++) {
		const double *place = states[i]->pose.position;
		include(area, world, lattice_offset(place[0]), lattice_offset(place[1]), posts);
	}
	if (body->has_last)
		include(area, world, body->last.x, body->last.y, posts);
	include(area, world, body->host.felt.x, body->host.felt.y, posts);
}

struct post_rect world_body_area(const struct world *world, size_t number, double until)
{
	enum { PROBED = 6 }; /* posts: a probed pose may lie so far beyond the body */
	enum { CARRIES = 8 }; /* posts: soil aboard may be put down so far beside it (soil_carried_reach) */
	struct post_rect area = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	const struct body *body = world->bodies[number];
	const int64_t posts = world_contact_reach(world, &body->object->shape) + (body->carried != NULL ? CARRIES : 0) + throws_beyond(world, body, until);
	if (world_is_hosted(body))
		include_hosted(world, body, posts + PROBED, &area);
	else
		include_path(world, body, until, posts, &area);
	const int64_t intervals = world_intervals_due(world, until);
	if (area.x0 >= area.x1 || intervals <= 0)
		return area;
	return world_slides_from(world, area, intervals);
}

void world_pass_elsewhere(struct world *world, double until)
{
	for (size_t i = 0; i < world->scene->object_count; i++) {
		struct body *body = world->bodies[i];
		if (!body->elsewhere || body->kind != BODY_PATH)
			continue;
		const int64_t samples = motion_track_samples(body->track);
		while (body->next < samples && motion_track_sample_time(body->track, body->next) <= until)
			body->next++;
	}
}

/* --- bodies that move --- */

void world_body_pack(const struct world *world, size_t number, struct world_moved *moved)
{
	const struct body *body = world->bodies[number];
	memset(moved, 0, sizeof *moved); /* its padding, too: it is sent as bytes */
	moved->number = (int64_t)number;
	if (world_is_hosted(body))
		return;
	moved->next = body->next;
	moved->skipped = body->skipped;
	moved->has_last = body->has_last;
	moved->last = body->last;
	moved->trend = body->trend;
	moved->distance = body->distance;
	moved->sinkage = body->sinkage;
	moved->equilibrium = body->equilibrium;
	moved->windows = body->windows;
	moved->windows_moved = body->windows_moved;
	moved->regions = body->regions;
	moved->regions_moved = body->regions_moved;
	world_forces_pack(world->forces, number, moved);
}

enum status world_body_unpack(struct world *world, const struct world_moved *moved, bool here)
{
	const size_t number = (size_t)moved->number;
	if (moved->number < 0 || !world_ranked(world, number))
		return fail_with(STATUS_FAILED, "ranks: a body came that this rank does not have; report this");
	world_body_here(world, number, here);
	struct body *body = world->bodies[number];
	if (world_is_hosted(body))
		return STATUS_OK;
	body->next = moved->next;
	body->skipped = moved->skipped;
	body->has_last = moved->has_last;
	body->last = moved->last;
	body->trend = moved->trend;
	body->distance = moved->distance;
	body->sinkage = moved->sinkage;
	body->equilibrium = moved->equilibrium;
	body->raised = body->loaded_body > 0 && body->has_last ? body->equilibrium - body->last.z : 0;
	body->windows = moved->windows;
	body->windows_moved = moved->windows_moved;
	body->regions = moved->regions;
	body->regions_moved = moved->regions_moved;
	world->record->objects[number].force = moved->force;
	if (!here)
		return STATUS_OK;
	world_forces_unpack(world->forces, number, moved);
	world_set_equilibrium(world, body, body->raised);
	return STATUS_OK;
}

/* --- blocks where soil may slide --- */

enum status world_active_keep(struct world *world, world_block_fn keeps, void *user)
{
	const struct soil_block *list;
	size_t count = 0;
	enum status status = world_active_blocks(world, &list, &count);
	if (status != STATUS_OK || count == 0)
		return status;
	struct soil_block *copy = mem_alloc(count, sizeof *copy);
	TRY_MEM(copy, "active blocks");
	memcpy(copy, list, count * sizeof *copy);
	status = world_forget_active(world);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		if (keeps(user, copy[i]))
			status = world_wake_block(world, copy[i]);
	mem_free(copy);
	return status;
}

enum status world_tile_came(struct world *world, struct tile tile, unsigned planes, const void *bytes)
{
	const struct post_rect posts = tile_post_rect(&world->resident.meta->extent, tile);
	TRY(resident_pages_put(world->resident.pages, tile, planes, bytes));
	if (world->aloft.asks_touched)
		TRY(deform_touch(world->deform, posts));
	return STATUS_OK;
}

/* --- commits --- */

enum status world_record_ranks(struct world *world, const struct soil_block *others, size_t count)
{
	enum status status = world_fill_record(world);
	struct record *record = world->record;
	if (status != STATUS_OK || count == 0)
		return status;
	/* Two ranks may both have woken a block between their ground. */
	struct soil_block *all = mem_alloc(record->active_count + count, sizeof *all);
	TRY_MEM(all, "active blocks");
	memcpy(all, record->active, record->active_count * sizeof *all);
	memcpy(all + record->active_count, others, count * sizeof *all);
	const size_t kept = soil_blocks_sort(all, record->active_count + count);
	if (kept > DEFORM_BLOCKS_MAX) {
		status = fail_with(STATUS_FAILED, "soil: the ground slides in more than %d blocks of %d x %d posts at once; choose a soil that stands "
						  "steeper, a coarser spacing, or model none", DEFORM_BLOCKS_MAX, SOIL_BLOCK, SOIL_BLOCK);
	} else {
		memcpy(record->active, all, kept * sizeof *all);
		record->active_count = kept;
	}
	mem_free(all);
	return status;
}
