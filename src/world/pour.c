/*
 * Soil that is brought and taken between two steps, by no body: a heap that is poured, a pit that is dug by hand.
 *
 * All that can refuse is looked at before anything changes. Then the tiles change one after the other, and the record counts what was added. Ground and
 * record are of one commit. Soil that comes or goes loose may slide afterwards, as soil that a body has moved.
 *
 * Invariant: the sum of all offsets changes by what the record counts as added, to the unit.
 */
#include <math.h>
#include <stdlib.h>

#include "world/internal.h"

#define ROWS_AT_ONCE 64 /* that are read to look at them */
#define FEW_TILES 16    /* each world has images for so many changed pages besides those of its bodies */

static size_t width_of(const struct world_pour *pour)
{
	return (size_t)(pour->rect.x1 - pour->rect.x0);
}

static const int32_t *row_of(const struct world_pour *pour, int64_t y)
{
	return pour->amounts + (size_t)(y - pour->rect.y0) * width_of(pour);
}

static int32_t amount_at(const struct world_pour *pour, int64_t x, int64_t y)
{
	return row_of(pour, y)[x - pour->rect.x0];
}

static bool is_any(const struct world_pour *pour, struct post_rect part)
{
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++)
			if (amount_at(pour, x, y) != 0)
				return true;
	return false;
}

/* --- what is there --- */

/* Ground that is poured on, a few rows at a time. */
struct looking {
	struct world *world;
	const struct world_pour *pour;
	struct post_rect rows;
	double *surface, *offset; /* m; m */
	double highest;           /* m: how far a post will be off its base at most */
};

static enum status refuse(const struct world *world, enum status status, int64_t x, int64_t y, const char *why, const char *what_to_do)
{
	const double spacing = world->resident.spacing;
	return fail_with(status, "pour: post %lld, %lld (at %.10g, %.10g m) %s; %s", (long long)x, (long long)y, (double)x * spacing, (double)y * spacing,
			 why, what_to_do);
}

static enum status look_at_soil(struct world *world, const struct world_pour *pour, int64_t x, int64_t y)
{
	char why[160];
	int soil;
	if (pour->soil < 0 || world->resident.soil_map == NULL)
		return STATUS_OK;
	TRY(world_soil_at(world, (double)x * world->resident.spacing, (double)y * world->resident.spacing, &soil));
	if (soil < 0 || soil == pour->soil)
		return STATUS_OK;
	snprintf(why, sizeof why, "has soil %d of the scene, and soil %d was to be poured. A place keeps the class that the soil map gives it", soil, pour->soil);
	return refuse(world, STATUS_INPUT, x, y, why, "give the class there, or -1 for the class of each post");
}

static enum status look_at_post(struct looking *looking, int64_t x, int64_t y)
{
	struct world *world = looking->world;
	const struct world_pour *pour = looking->pour;
	const size_t at = (size_t)(y - looking->rows.y0) * width_of(pour) + (size_t)(x - pour->rect.x0);
	const double after = looking->offset[at] + lattice_offset_metres(amount_at(pour, x, y));
	if (isnan(looking->surface[at]))
		return refuse(world, STATUS_INPUT, x, y, "is a hole of the terrain", "leave it 0, or import with holes filled (furrow import --fill)");
	if (!(fabs(after) <= lattice_offset_metres(BEARING_POUR_MOST))) {
		char why[80];
		snprintf(why, sizeof why, "would be %.10g m off its base, and %g m is the most", after, lattice_offset_metres(BEARING_POUR_MOST));
		return refuse(world, STATUS_INPUT, x, y, why, "pour or take less there");
	}
	looking->highest = fmax(looking->highest, fabs(after));
	return look_at_soil(world, pour, x, y);
}

/* --- bodies in the ground --- */

/* Gives the pose of a body that is somewhere. Returns false if it is nowhere. */
static bool place_of(const struct body *body, struct soil_pose *pose)
{
	if (body == NULL || body->elsewhere)
		return false;
	if (body->kind == BODY_PATH) {
		*pose = body->last;
		pose->z += body->loaded_body > 0 ? body->raised : 0;
		return body->has_last;
	}
	return world_is_set_down(body) &&
	       world_attitude(&body->object->shape, body->object->name, &body->host.now.pose, pose) == STATUS_OK;
}

/* STATUS_INPUT: the body is in the ground at a post of these rows, before or after. */
static enum status look_at_body(const struct looking *looking, const struct body *body)
{
	const struct world_pour *pour = looking->pour;
	const double spacing = looking->world->resident.spacing;
	struct soil_pose pose;
	if (!place_of(body, &pose))
		return STATUS_OK;
	const struct deform_contact rest = {.shape = &body->object->shape, .from = pose, .to = pose};
	const double lowest = lattice_offset_metres(world_lowest(&rest));
	const struct post_rect below = post_rect_intersect(soil_shadow(rest.shape, &pose, &pose, spacing), looking->rows);
	for (int64_t y = below.y0; y < below.y1; y++)
		for (int64_t x = below.x0; x < below.x1; x++) {
			const int32_t amount = amount_at(pour, x, y);
			const double surface = looking->surface[(size_t)(y - looking->rows.y0) * width_of(pour) + (size_t)(x - pour->rect.x0)];
			if (amount == 0 || surface + fmax(lattice_offset_metres(amount), 0) < lowest)
				continue;
			char why[400];
			snprintf(why, sizeof why, "is below %.300s, which is in the ground there", body->object->name);
			return refuse(looking->world, STATUS_INPUT, x, y, why, "leave posts below bodies 0, or move the body away first");
		}
	return STATUS_OK;
}

static enum status look_at_rows(struct looking *looking)
{
	struct world *world = looking->world;
	const struct post_rect rows = looking->rows;
	if (!is_any(looking->pour, rows))
		return STATUS_OK;
	TRY(world_read_posts(world, STORE_SURFACE, world->resident.level, rows, looking->surface));
	TRY(world_read_posts(world, STORE_OFFSET, world->resident.level, rows, looking->offset));
	for (int64_t y = rows.y0; y < rows.y1; y++)
		for (int64_t x = rows.x0; x < rows.x1; x++)
			if (amount_at(looking->pour, x, y) != 0)
				TRY(look_at_post(looking, x, y));
	for (size_t i = 0; i < world->body_count; i++)
		TRY(look_at_body(looking, world->bodies[i]));
	return STATUS_OK;
}

static enum status look(struct world *world, const struct world_pour *pour, double *highest)
{
	struct looking looking = {.world = world, .pour = pour};
	const size_t posts = ROWS_AT_ONCE * width_of(pour);
	enum status status = STATUS_OK;
	looking.surface = mem_alloc(posts, sizeof *looking.surface);
	looking.offset = mem_alloc(posts, sizeof *looking.offset);
	TRY_OR(done, looking.surface != NULL && looking.offset != NULL ? STATUS_OK : fail_memory("posts"));
	for (int64_t y = pour->rect.y0; y < pour->rect.y1; y += ROWS_AT_ONCE) {
		const int64_t end = y + ROWS_AT_ONCE < pour->rect.y1 ? y + ROWS_AT_ONCE : pour->rect.y1;
		looking.rows = (struct post_rect){pour->rect.x0, y, pour->rect.x1, end};
		TRY_OR(done, look_at_rows(&looking));
	}
	*highest = looking.highest;
done:
	mem_free_all(looking.surface, looking.offset);
	return status;
}

/* Returns the most tiles that may change at once. Half of the images of changed pages are left for others. */
static uint32_t tiles_most(const struct world *world)
{
	struct resident_pages_budget budget;
	world_budget(world, &budget);
	const uint64_t image = budget.images_few > 0 ? budget.queue_few / budget.images_few : 0;
	const uint64_t images = image > 0 ? budget.queue / image / 2 : WORLD_HOST_PAGES;
	const uint32_t pages = world_step_pages(world), most = pages < WORLD_HOST_PAGES ? pages : WORLD_HOST_PAGES;
	return images < most ? (uint32_t)images : most;
}

enum status world_pour_rect(const struct world *world, struct post_rect rect)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct post_rect all = {0, 0, extent_posts(extent->width, world->resident.level), extent_posts(extent->height, world->resident.level)};
	const uint32_t most = tiles_most(world);
	if (rect.x0 < 0 || rect.y0 < 0 || rect.x1 > all.x1 || rect.y1 > all.y1)
		return fail_with(STATUS_INPUT, "pour: posts %lld, %lld to %lld, %lld are not all on the terrain, which has %lld x %lld; leave those beyond it out",
				 (long long)rect.x0, (long long)rect.y0, (long long)rect.x1 - 1, (long long)rect.y1 - 1, (long long)all.x1, (long long)all.y1);
	if (world_tiles_in(world, rect) > most)
		return fail_with(STATUS_INPUT, "pour: it lies on %zu tiles, and %u is the most at once, as memory allows; pour one part after the other",
				 world_tiles_in(world, rect), most);
	return STATUS_OK;
}

static enum status check(struct world *world, const struct world_pour *pour)
{
	if (world_is_torn(world))
		return fail_with(STATUS_FAILED, "pour: the last step failed half-way; roll back first, or close the world");
	if (world->ranks != NULL)
		return fail_with(STATUS_USAGE, "pour: a world that several processes step takes no soil from outside; pour before, by one process");
	if (!pour->looks && !world_changes_ground(world))
		return fail_with(STATUS_USAGE, "pour: nothing changes the ground in this world; open it without readonly");
	if (pour->soil >= world->scene->soil_count)
		return fail_with(STATUS_USAGE, "pour: soil %d is none; the scene has %d, from 0 on; -1: the soil of each post", pour->soil,
				 world->scene->soil_count);
	return world_pour_rect(world, pour->rect);
}

/* --- pouring --- */

struct pouring {
	const struct world *world;
	const struct world_pour *pour;
};

static void change(void *user, struct tile tile, void *const planes[PLANES])
{
	const struct pouring *pouring = user;
	const struct extent *extent = &pouring->world->resident.meta->extent;
	const struct post_rect own = tile_post_rect(extent, tile), part = post_rect_intersect(own, pouring->pour->rect);
	const size_t side = tile_posts(extent);
	for (int64_t y = part.y0; y < part.y1; y++)
		for (int64_t x = part.x0; x < part.x1; x++)
			bearing_pour(planes, (size_t)(y - own.y0) * side + (size_t)(x - own.x0), amount_at(pouring->pour, x, y), pouring->pour->loose);
}

/* Changes a tile, then marks what changed, so that coarser levels, queries and pictures learn of it. */
static enum status change_tile(struct world *world, const struct world_pour *pour, struct tile tile)
{
	struct pouring pouring = {world, pour};
	const struct post_rect part = post_rect_intersect(tile_post_rect(&world->resident.meta->extent, tile), pour->rect);
	struct held_tiles held;
	if (!is_any(pour, part))
		return STATUS_OK;
	TRY(resident_pages_edit(world->resident.pages, tile, change, &pouring));
	TRY(world_hold_tile(world, tile, &held));
	const enum status status = world_mark(world, part, &held);
	world_release(world, &held);
	return status;
}

/* What is known of the ground from the time before holds no more. */
static enum status tell(struct world *world, const struct world_pour *pour, double highest)
{
	int64_t most = 0;
	for (int64_t y = pour->rect.y0; y < pour->rect.y1; y++)
		for (int64_t x = pour->rect.x0; x < pour->rect.x1; x++)
			most = llabs(amount_at(pour, x, y)) > most ? llabs(amount_at(pour, x, y)) : most;
	world->aloft.poured += most;
	world_happened_reach(world, highest);
	if (world->deform != NULL && world->aloft.asks_touched)
		TRY(deform_touch(world->deform, pour->rect));
	return pour->loose && deform_conserves(world->scene->model) ? world_wake(world, pour->rect) : STATUS_OK;
}

static enum status change_all(struct world *world, const struct world_pour *pour, double highest)
{
	struct tile first, last;
	world_tear(world);
	world->near.stale = true;
	TRY(tell(world, pour, highest));
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, pour->rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			TRY(change_tile(world, pour, (struct tile){world->resident.level, x, y}));
	return STATUS_OK;
}

static int64_t sum_of(const struct world_pour *pour)
{
	int64_t sum = 0;
	for (int64_t y = pour->rect.y0; y < pour->rect.y1; y++)
		for (int64_t x = pour->rect.x0; x < pour->rect.x1; x++)
			sum += amount_at(pour, x, y);
	return sum;
}

double world_poured(const struct world *world)
{
	return lattice_offset_metres(world->aloft.poured);
}

enum status world_pour(struct world *world, const struct world_pour *pour)
{
	double highest = 0;
	if (post_rect_empty(pour->rect))
		return STATUS_OK;
	TRY(check(world, pour));
	TRY(world_hosts_commit(world));
	TRY(look(world, pour, &highest));
	if (pour->looks || !is_any(pour, pour->rect))
		return STATUS_OK;
	TRY(world_begin_run(world));
	if (world_tiles_in(world, pour->rect) > FEW_TILES)
		TRY(page_cache_flush(world->resident.cache, world->record)); /* so that no other page waits */
	TRY(change_all(world, pour, highest));
	world->record->added += sum_of(pour);
	return world_end_change(world);
}
