/* What a drive needs at least, and what it takes at most: found before it begins. */
#include <math.h>

#include "run/internal.h"

/* Tiles that so many posts in a row can lie in, shared edges included. */
static size_t tiles_across(int64_t posts, uint32_t cells, int64_t most)
{
	int64_t tiles = (posts - 1) / cells + 2;
	return (size_t)(tiles < most ? tiles : most);
}

/* Elsewhere between its posts an object can touch one more of them in a row; a window has no more than it has. */
static int64_t at_most(int64_t posts)
{
	return posts < DEFORM_WINDOW_POSTS ? posts + 1 : DEFORM_WINDOW_POSTS;
}

/* Of the sphere around the object, a station's sweep in the middle of the world. Where several windows are cut from
 * it depends on the place: one may have all there is in a row. */
static size_t window_tiles(const struct drive *drive, const struct deform_params *params, const struct deform_shape *shape)
{
	const struct world *world = &drive->meta->world;
	const struct deform_shape around = {.kind = DEFORM_SPHERE, .radius = deform_shape_bound(shape)};
	int64_t post = lattice_offset(drive->spacing);
	int64_t x = lattice_offset((double)(world->width - 1) * world->spacing / 2);
	int64_t y = lattice_offset((double)(world->height - 1) * world->spacing / 2);
	struct deform_sweep sweep = {.shape = &around, .from = {.x = x, .y = y}, .to = {.x = x + post, .y = y + post}};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct post_rect all = {0, 0, DEFORM_WINDOW_POSTS, DEFORM_WINDOW_POSTS};
	size_t count;
	/* The sphere may need too many; the object, which is smaller, needs none larger than a window. */
	if (deform_cut(params, &sweep, windows, &count) == STATUS_OK && count > 0) {
		const struct post_rect *first = &windows[0].read, *last = &windows[count - 1].read;
		all = (struct post_rect){first->x0, first->y0, last->x1, last->y1};
	}
	return tiles_across(at_most(all.x1 - all.x0), world->cells, world_tiles_x(world, drive->level)) *
	       tiles_across(at_most(all.y1 - all.y0), world->cells, world_tiles_y(world, drive->level));
}

/* Of a block's square. */
static size_t block_tiles(const struct drive *drive, const struct deform_params *params)
{
	const struct world *world = &drive->meta->world;
	int64_t side = deform_interval_side(params);
	return tiles_across(side, world->cells, world_tiles_x(world, drive->level)) *
	       tiles_across(side, world->cells, world_tiles_y(world, drive->level));
}

/* Ground that slides undisturbed. */
static enum status check_awake(const struct drive *drive)
{
	const struct world *world = &drive->meta->world;
	double blocks = ceil((double)world_posts(world->width, drive->level) / DEFORM_BLOCK) *
			ceil((double)world_posts(world->height, drive->level) / DEFORM_BLOCK);
	if (blocks > DEFORM_BLOCKS_MAX)
		return fail_with(STATUS_INPUT, "redistribute.undisturbed: slides: the whole terrain slides then, and its %.0f blocks of %d x %d "
					       "posts are more than the %d that may at once; let it stand, import a smaller part, or give a "
					       "coarser spacing",
				 blocks, DEFORM_BLOCK, DEFORM_BLOCK, DEFORM_BLOCKS_MAX);
	return STATUS_OK;
}

enum status budget_check(struct drive *drive)
{
	const struct scene *scene = drive->scene;
	struct deform_params params;
	/* Of a terrain that is not known it is not known either. */
	bool slides = scene->object_count > 0 && scene->undisturbed == SCENE_SLIDES && drive->store != NULL;
	enum status status = slides ? check_awake(drive) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	drive_deform_params(drive, &params);
	size_t block = scene->object_count > 0 && deform_conserves(scene->model) ? block_tiles(drive, &params) : 0;
	if (block > BUDGET_WINDOW_TILES || block > scene->slots)
		return fail_with(STATUS_INPUT, "cache.slots: a block of ground that slides touches up to %zu tiles of %u cells at "
					       "once, and there are %u slots (at most %d are used); give more, or import with "
					       "larger tiles (--tile)",
				 block, drive->meta->world.cells, scene->slots, BUDGET_WINDOW_TILES);
	drive->window_tiles = block;
	for (size_t i = 0; i < scene->object_count; i++) {
		size_t tiles = window_tiles(drive, &params, &scene->objects[i].shape);
		if (tiles > BUDGET_WINDOW_TILES)
			return fail_with(STATUS_INPUT, "%s: it touches up to %zu tiles of %u cells at once, and %d is the "
						       "most; import with larger tiles (--tile)",
					 scene->objects[i].name, tiles, drive->meta->world.cells, BUDGET_WINDOW_TILES);
		if (tiles > scene->slots)
			return fail_with(STATUS_INPUT, "cache.slots: %s touches up to %zu tiles at once and there are %u slots; "
						       "give at least %zu, or import with larger tiles (--tile)",
					 scene->objects[i].name, tiles, scene->slots, tiles);
		if (tiles > drive->window_tiles)
			drive->window_tiles = tiles;
	}
	return STATUS_OK;
}

uint32_t budget_step_pages(const struct drive *drive)
{
	/* Stations a step can bring an object, and the tiles they can lie on: a path's length crosses
	 * at most two rows and two columns more than its extent asks for. */
	double pages = 0, side = drive->spacing * drive->meta->world.cells;
	for (size_t i = 0; i < drive->scene->object_count; i++) {
		double size = 2 * deform_shape_bound(&drive->scene->objects[i].shape) + 16 * drive->spacing; /* and what is smoothed around it */
		double along = track_fastest(drive->riders[i].track) * drive->scene->time_step / side + 2, across = ceil(size / side) + 1;
		pages += 2 * along * across + across * across;
	}
	/* What slides on behind them: a block on a tile of its own each, at worst. */
	if (deform_conserves(drive->scene->model))
		pages += fmin(DEFORM_BLOCKS_MAX, (double)world_tiles_x(&drive->meta->world, drive->level) *
							 world_tiles_y(&drive->meta->world, drive->level));
	return pages < 1e6 ? (uint32_t)pages + 4 : 1000000;
}

void budget_bytes(const struct drive *drive, struct pages_budget *budget)
{
	uint64_t side = tile_posts(&drive->meta->world);
	struct pages_params params;
	drive_pages_params(drive, &params);
	pages_budget(&params, drive->meta->world.cells, budget);
	budget->ground += ((uint64_t)drive->ground_tiles + 1) * side * side * sizeof(int32_t);
}
