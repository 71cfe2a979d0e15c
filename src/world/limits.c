/*
 * How many tiles a world keeps in memory: in slots, as images of changed pages, as base heights on the CPU, for queries.
 *
 * They follow the scene: its bodies, how large they are and how far they travel. With `cache.memory` they follow that, too: slots are as
 * many as it leaves room for. What is counted is what world_budget tells, but for steps that change more pages than images are made for.
 */
#include <math.h>

#include "world/internal.h"

/* Base heights: for few bodies a few tiles each. For many, what they stand on and come to, and a third more for what they left. */
#define FEW_TILES 256
#define LEAST_TILES 16
#define GROUND_BYTES ((uint64_t)256 << 20) /* most, unless slots take more, or cache.memory tells */
#define GROUND_PART 8                      /* most of cache.memory: an eighth */
#define QUERIES_PART 16                    /* most of cache.memory: a sixteenth */
#define LEAST_PART (GROUND_PART * QUERIES_PART) /* of this base heights and queries get so little that they keep the fewest tiles */

static uint64_t plane_bytes_of(const struct world *world)
{
	const uint64_t side = tile_posts(&world->resident.meta->extent);
	return side * side * sizeof(int32_t);
}

/* Returns the number of tiles of `side` metres that a square of `across` metres lies on, in the mean over where it lies. */
static double tiles_under(double across, double side)
{
	return (1 + across / side) * (1 + across / side);
}

/* --- base heights --- */

static double ground_under(const struct world *world, const struct soil_shape *shape, double speed)
{
	const struct extent *extent = &world->resident.meta->extent;
	const int finest = world->resident.store != NULL ? store_finest_base(world->resident.store) : 0;
	double tiles = 0;
	for (int level = finest; level <= 0; level++) {
		const double side = extent_spacing(extent, level) * extent->cells;
		tiles += tiles_under(2 * soil_shape_bound(shape), side) + speed * world->facts.limits.prefetch / side;
	}
	return tiles;
}

/* Returns how many base tiles the world's bodies need. */
static double ground_need(const struct world *world)
{
	const struct scene *scene = world->scene;
	const double insets = world->resident.store != NULL ? -store_finest_base(world->resident.store) : 0;
	double need = world->facts.limits.hosts_need, few = (4 + insets) * ((double)scene->object_count + 1);
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct track *track = world->bodies[i]->track;
		need += ground_under(world, &scene->objects[i].shape, track != NULL ? motion_track_fastest(track) : 0);
	}
	return fmax(fmin(few, FEW_TILES), 4 * need / 3);
}

/* Returns the number of base tiles of the terrain; INFINITY: it is not known. */
static double base_tiles(const struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	double tiles = 0;
	if (world->resident.store == NULL || store_finest_base(world->resident.store) < 0)
		return INFINITY;
	for (int level = 0; level <= extent_coarsest(extent); level++)
		tiles += (double)extent_tiles_x(extent, level) * extent_tiles_y(extent, level);
	return tiles;
}

static uint32_t ground_tiles(const struct world *world, uint32_t slots, uint64_t bytes)
{
	const uint64_t plane = plane_bytes_of(world);
	const double fit = bytes > 0 ? (double)(bytes / plane) : fmax((double)(GROUND_BYTES / plane), slots);
	const double tiles = fmin(fmin(ground_need(world), fit), base_tiles(world));
	return tiles > LEAST_TILES ? (uint32_t)tiles : LEAST_TILES;
}

/* --- queries --- */

static uint32_t query_tiles(const struct world *world, uint64_t bytes)
{
	const uint32_t cells = world->resident.meta->extent.cells, most = resident_newest_tiles(cells);
	if (!scene_moves_bodies(world->scene))
		return 0;
	const uint64_t bases = resident_newest_base_bytes(cells);
	const double fit = bytes > 0 ? (double)((bytes > bases ? bytes - bases : 0) / resident_newest_tile_bytes(cells)) : INFINITY;
	const double tiles = fmin(fmax(most, 2.0 * world_work_pages(world)), fit);
	return tiles > RESIDENT_NEWEST_LEAST ? (uint32_t)tiles : RESIDENT_NEWEST_LEAST;
}

/* --- all --- */

uint32_t world_work_pages(const struct world *world)
{
	const double side = world->resident.spacing * world->resident.meta->extent.cells;
	double pages = world->facts.limits.hosts_work;
	for (size_t i = 0; i < world->scene->object_count; i++)
		if (world->bodies[i]->kind == BODY_PATH)
			pages += tiles_under(2 * soil_shape_bound(&world->scene->objects[i].shape), side);
	return pages < 1e6 ? (uint32_t)ceil(pages) : 1000000;
}

/* Tells whether so many slots hold every tile that the drive may come to. A picture also draws base tiles finer than the working level. A window
 * never waits for a tile, so it always needs loaders. */
static bool holds_all(const struct world *world, uint32_t slots)
{
	return world->resident.store != NULL && !world->params.drops && store_finest_base(world->resident.store) >= world->resident.level && world_all_tiles(world) <= slots;
}

/* Fills the limits for so many slots. `part`: bytes from which base heights and queries get their parts; 0: they have no limit of bytes. */
static void set(struct world *world, uint32_t slots, uint64_t part)
{
	world->facts.limits.slots = slots;
	world->facts.limits.all = holds_all(world, slots);
	world->facts.limits.loaders = world->facts.limits.all ? 0 : world->scene->loaders;
	world->facts.limits.prefetch = world->facts.limits.all ? 0 : world->scene->prefetch;
	world->facts.limits.images = world->scene->memory > 0 ? slots / 2 + 1 : 0;
	world->facts.limits.ground = ground_tiles(world, slots, part / GROUND_PART);
	world->facts.limits.queries = query_tiles(world, part / QUERIES_PART);
}

/* Returns the bytes that the limits allow, as explain tells them. */
static uint64_t told(const struct world *world)
{
	struct resident_pages_budget most;
	world_budget(world, &most);
	return most.slots + most.loads + most.queue_few + most.ground;
}

/* Finds the most slots with which the limits fit into `memory`. Returns false if not even `least` do. */
static bool fit(struct world *world, uint32_t least, uint32_t most, uint64_t memory, uint64_t part)
{
	uint32_t low = least, high = most > least ? most : least;
	set(world, high, part); /* may need less than one slot fewer: without loaders */
	if (told(world) <= memory)
		return true;
	set(world, least, part);
	if (told(world) > memory)
		return false;
	while (low < high) {
		const uint32_t middle = high - (high - low) / 2;
		set(world, middle, part);
		if (told(world) <= memory)
			low = middle;
		else
			high = middle - 1;
	}
	set(world, low, part);
	return true;
}

/* Returns how many tiles all levels have from the working level on, as far as a cache may hold them. */
static uint32_t slots_of_all(const struct world *world)
{
	struct scene_parameter slots;
	scene_parameter("cache.slots", &slots);
	return world->resident.store != NULL && world_all_tiles(world) < slots.high ? (uint32_t)world_all_tiles(world) : (uint32_t)slots.high;
}

static uint64_t memory_for(const struct world *world, uint32_t slots)
{
	struct world trial = *world;
	struct scene scene = *world->scene;
	const uint64_t unit = 1000000;
	trial.scene = &scene;
	scene.memory = unit;
	set(&trial, slots, LEAST_PART);
	return (told(&trial) + unit - 1) / unit * unit;
}

enum status world_settle_limits(struct world *world)
{
	const struct scene *scene = world->scene;
	struct scene_parameter slots;
	scene_parameter("cache.slots", &slots);
	world->facts.limits.usable = mem_usable();
	if (scene->memory == 0) {
		set(world, scene->slots, 0);
		return STATUS_OK;
	}
	size_t tiles = world_least_slots(world);
	const uint32_t least = tiles > slots.low ? (uint32_t)tiles : (uint32_t)slots.low;
	/* With little memory base heights and queries get the least. */
	if (fit(world, least, slots_of_all(world), scene->memory, scene->memory) || fit(world, least, least, scene->memory, LEAST_PART))
		return STATUS_OK;
	struct resident_pages_budget most;
	world_budget(world, &most);
	return fail_with(STATUS_INPUT, "%s: cache.memory: %.6g MB is too little for %u slots, %u changed tiles on their way to the store and %u tiles of base "
				       "heights; give at least %.0f MB",
			 scene->file, (double)scene->memory / 1e6, least, most.images_few, world->facts.limits.ground, (double)memory_for(world, least) / 1e6);
}

void world_advise_limits(const struct world *world, scene_advice_fn tell, void *user)
{
	const uint32_t work = world_work_pages(world), enough = 2 * work;
	struct scene_parameter slots;
	char text[240];
	scene_parameter("cache.slots", &slots);
	if (scene_moves_bodies(world->scene) || work <= world->facts.limits.slots || enough > slots.high)
		return;
	if (world->scene->memory > 0)
		snprintf(text, sizeof text, "cache.memory: %.6g MB leaves %u slots, and the objects lie on about %u tiles: each step loads tiles "
					    "again; give about %.0f MB",
			 (double)world->scene->memory / 1e6, world->facts.limits.slots, work, (double)memory_for(world, enough) / 1e6);
	else
		snprintf(text, sizeof text, "cache.slots: %u, and the objects lie on about %u tiles: each step loads tiles again; give %u, or "
					    "cache.memory: %.0f MB",
			 world->facts.limits.slots, work, enough, (double)memory_for(world, enough) / 1e6);
	tell(user, text);
}

enum status world_limits_add(struct world *world, const struct soil_shape *shape)
{
	world->facts.limits.hosts_need += ground_under(world, shape, 0);
	world->facts.limits.hosts_work += tiles_under(2 * soil_shape_bound(shape), world->resident.spacing * world->resident.meta->extent.cells);
	const uint64_t part = world->scene->memory;
	world->facts.limits.ground = ground_tiles(world, world->facts.limits.slots, part / GROUND_PART);
	world->facts.limits.queries = query_tiles(world, part / QUERIES_PART);
	return resident_ground_grow(world->resident.ground, world->facts.limits.ground);
}
