/* The resources that a drive needs at least and uses at most, found before it begins. */
#include <math.h>

#include "world/internal.h"

bool world_deforms(const struct world *world)
{
	return world->scene->object_count > 0 || scene_moves_bodies(world->scene);
}

/* Returns the most tiles that so many posts in a row can lie in, shared edges included. */
static size_t tiles_across(int64_t posts, uint32_t cells, int64_t most)
{
	int64_t tiles = (posts - 1) / cells + 2;
	return (size_t)(tiles < most ? tiles : most);
}

/* At another place between posts an object can touch one more post in a row. A window has no more than its size. */
static int64_t at_most(int64_t posts)
{
	return posts < DEFORM_WINDOW_POSTS ? posts + 1 : DEFORM_WINDOW_POSTS;
}

/* Returns the most tiles that a window of this object touches. It takes a contact of the object's bounding sphere in the middle
 * of the world. How several windows are cut depends on the place, so one of them may have the full size. */
static size_t window_tiles(const struct world *world, const struct deform_params *params, const struct soil_shape *shape)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct soil_shape around = {.kind = SOIL_SPHERE, .radius = soil_shape_bound(shape)};
	int64_t post = lattice_offset(world->resident.spacing);
	int64_t x = lattice_offset((double)(extent->width - 1) * extent->spacing / 2);
	int64_t y = lattice_offset((double)(extent->height - 1) * extent->spacing / 2);
	struct deform_contact contact = {.shape = &around, .from = {.x = x, .y = y}, .to = {.x = x + post, .y = y + post}};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct post_rect all = {0, 0, DEFORM_WINDOW_POSTS, DEFORM_WINDOW_POSTS};
	const bool whole = world_feels(world); /* all windows are one */
	size_t count;
	/* The sphere may need too many windows. The object is smaller, and no window of it is larger than a full one. */
	if (deform_cut(params, &contact, windows, &count) == STATUS_OK && count > 0) {
		const struct post_rect *first = &windows[0].read, *last = &windows[count - 1].read;
		all = (struct post_rect){first->x0, first->y0, last->x1, last->y1};
	}
	const int64_t width = all.x1 - all.x0, height = all.y1 - all.y0;
	return tiles_across(whole ? width + 1 : at_most(width), extent->cells, extent_tiles_x(extent, world->resident.level)) *
	       tiles_across(whole ? height + 1 : at_most(height), extent->cells, extent_tiles_y(extent, world->resident.level));
}

/* Returns how many tiles a block may write at once. It reads at most four at a time, so reading needs no more slots. */
static size_t block_tiles(const struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	return tiles_across(SOIL_BLOCK, extent->cells, extent_tiles_x(extent, world->resident.level)) *
	       tiles_across(SOIL_BLOCK, extent->cells, extent_tiles_y(extent, world->resident.level));
}

/* Checks that undisturbed ground that relaxes fits into the active blocks. */
static enum status check_active(const struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	double blocks = ceil((double)extent_posts(extent->width, world->resident.level) / SOIL_BLOCK) *
			ceil((double)extent_posts(extent->height, world->resident.level) / SOIL_BLOCK);
	if (blocks > DEFORM_BLOCKS_MAX)
		return fail_with(STATUS_INPUT, "redistribute.undisturbed: slides: the whole terrain slides then, and its %.0f blocks of %d x %d "
					       "posts are more than the %d that may at once; let it stand, import a smaller part, or give a "
					       "coarser spacing",
				 blocks, SOIL_BLOCK, SOIL_BLOCK, DEFORM_BLOCKS_MAX);
	return STATUS_OK;
}

static enum status shape_budget(struct world *world, const struct deform_params *params, const char *name, const struct soil_shape *shape)
{
	TRY(deform_check_sheet(params));
	const size_t tiles = window_tiles(world, params, shape);
	if (tiles > WORLD_TILES_MOST)
		return fail_with(STATUS_INPUT, "%s: it touches up to %zu tiles of %u cells at once, and %d is the most; import with larger "
					       "tiles (--tile)", name, tiles, world->resident.meta->extent.cells, WORLD_TILES_MOST);
	if (tiles > world->facts.limits.slots)
		return fail_with(STATUS_INPUT, "cache.slots: %s touches up to %zu tiles at once and there are %u slots; give at least %zu, or "
					       "import with larger tiles (--tile)", name, tiles, world->facts.limits.slots, tiles);
	if (tiles > world->counts.windows.tiles)
		world->counts.windows.tiles = tiles;
	return STATUS_OK;
}

enum status world_shape_budget(struct world *world, const char *name, const struct soil_shape *shape)
{
	struct deform_params params;
	world_deform_params(world, &params);
	return shape_budget(world, &params, name, shape);
}

size_t world_least_slots(const struct world *world)
{
	struct deform_params params;
	world_deform_params(world, &params);
	size_t least = world_deforms(world) && deform_conserves(world->scene->model) ? block_tiles(world) : 0;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const size_t tiles = window_tiles(world, &params, &world->scene->objects[i].shape);
		least = tiles > least ? tiles : least;
	}
	return least < WORLD_TILES_MOST ? least : WORLD_TILES_MOST;
}

enum status world_budget_check(struct world *world)
{
	const struct scene *scene = world->scene;
	struct deform_params params;
	/* For an assumed terrain it is not known. */
	bool slides = world_deforms(world) && scene->undisturbed == SCENE_SLIDES && world->resident.store != NULL;
	TRY(slides ? check_active(world) : STATUS_OK);
	world_deform_params(world, &params);
	size_t block = world_deforms(world) && deform_conserves(scene->model) ? block_tiles(world) : 0;
	if (block > WORLD_TILES_MOST || block > world->facts.limits.slots)
		return fail_with(STATUS_INPUT, "cache.slots: a block of ground that slides touches up to %zu tiles of %u cells at "
					       "once, and there are %u slots (at most %d are used); give more, or import with "
					       "larger tiles (--tile)",
				 block, world->resident.meta->extent.cells, world->facts.limits.slots, WORLD_TILES_MOST);
	world->counts.windows.tiles = block;
	for (size_t i = 0; i < scene->object_count; i++)
		TRY(shape_budget(world, &params, scene->objects[i].name, &scene->objects[i].shape));
	return STATUS_OK;
}

uint32_t world_step_pages(const struct world *world)
{
	/* Path samples that one step can have for an object, and the tiles that they can lie on. A way crosses at most two rows
	 * and two columns more than its extent needs. */
	double pages = scene_moves_bodies(world->scene) ? WORLD_HOST_PAGES : 0, side = world->resident.spacing * world->resident.meta->extent.cells;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		if (world->bodies[i]->kind != BODY_PATH)
			continue;
		/* also the posts that are smoothed around it */
		double size = 2 * soil_shape_bound(&world->scene->objects[i].shape) + 16 * world->resident.spacing;
		double way = motion_track_fastest(world->bodies[i]->track) * world->scene->time_step;
		double along = way / side + 2, across = ceil(size / side) + 1, around = ceil((size + way) / side) + 1;
		pages += fmin(2 * along * across + across * across, around * around);
	}
	/* Blocks that relax behind the objects: at worst each lies on a tile of its own. */
	if (deform_conserves(world->scene->model))
		pages += fmin(DEFORM_BLOCKS_MAX, (double)extent_tiles_x(&world->resident.meta->extent, world->resident.level) *
							 extent_tiles_y(&world->resident.meta->extent, world->resident.level));
	if (world->resident.store != NULL)
		pages = fmin(pages, (double)extent_tiles_x(&world->resident.meta->extent, world->resident.level) * extent_tiles_y(&world->resident.meta->extent, world->resident.level));
	return pages < 1e6 ? (uint32_t)pages + 4 : 1000000;
}

/* Returns the bytes of tiles that the steps' thread, the look-ahead and queries keep. */
static uint64_t kept_bytes(const struct world *world)
{
	const uint64_t side = tile_posts(&world->resident.meta->extent);
	/* each thread that loads ahead has one tile of its own */
	const unsigned ahead = resident_look_ahead_threads(world->facts.limits.prefetch, world->scene->object_count);
	const uint32_t cells = world->resident.meta->extent.cells, queries = world->facts.limits.queries;
	return ((uint64_t)world->facts.limits.ground + (ahead > 1 ? ahead : 1)) * side * side * sizeof(int32_t) + queries * resident_newest_tile_bytes(cells) +
	       (queries > 0 ? resident_newest_base_bytes(cells) : 0);
}

/* Returns the bytes of the GPU's slots that mirror tiles in host memory for pictures. */
static uint64_t mirror_bytes(const struct world *world)
{
	const uint64_t side = tile_posts(&world->resident.meta->extent);
	if (!world_is_bearing(world) || !(world->scene->view.present || world->params.draws))
		return 0;
	uint64_t post = sizeof(int32_t) + (scene_draws_classes(world->scene) || scene_covers_by_class(world->scene) ? 1 : 0);
	for (int plane = 0; plane < PLANES; plane++)
		post += world_planes(world) & GPU_DRAWN_PLANES & PLANE_BIT(plane) ? plane_bytes((enum plane)plane) : 0;
	return world->facts.limits.slots * side * side * post;
}

uint64_t world_queue_bytes(const struct world *world, const struct pages_params *params)
{
	const uint64_t usable = world->facts.limits.usable.bytes;
	struct resident_pages_budget others;
	if (usable == 0)
		return 0;
	resident_pages_budget(params, world->resident.meta->extent.cells, &others);
	const uint64_t taken = others.slots + mirror_bytes(world) + others.loads + others.ground + kept_bytes(world);
	return usable > taken + 1 ? (usable - taken) / 2 : 1;
}

void world_budget(const struct world *world, struct resident_pages_budget *budget)
{
	struct pages_params params;
	world_pages_params(world, &params);
	resident_pages_budget(&params, world->resident.meta->extent.cells, budget);
	budget->slots += mirror_bytes(world);
	budget->ground += kept_bytes(world);
}
