/*
 * Answers what terrain asks of a drive: where there is ground, which tiles are resident, and which may be divided. Also limits a
 * picture to the slots that deformation leaves.
 */
#include <math.h>

#include "render/view.h"

/* A base's range does not change. It is read once, and kept while it is asked for. The range of a tile above may be used instead. */
enum status render_view_base_range(struct view *view, struct tile tile, struct key_pair *range)
{
	uint64_t key = tile_key(tile);
	bool found, any = false;
	TRY(key_cache_find(&view->ranges, key, range, &found));
	if (found)
		return STATUS_OK;
	if (render_view_lacks_range(view, GROUND_BASE, tile))
		return render_view_base_range(view, tile_ancestor(tile, tile.level + 1), range);
	TRY(resident_ground_range(world_resident(view->world)->ground, tile, &range->a, &range->b, &any));
	if (!any)
		range->a = NAN;
	return key_cache_put(&view->ranges, key, range->a, range->b);
}

static bool is_expected(const struct view *view, struct tile tile)
{
	return view->expected.count > 0 && key_set_has(&view->expected, tile_key(tile));
}

/* --- ground that is interpolated --- */

/* A tile below level 0 is drawn if the triangles of the tile above it are off the ground by more than this, in metres. */
#define BEND_LEAST 0.0005

bool render_view_smooths(const struct world *world)
{
	return world_resident(world)->level < 0 && !relief_has_level(world_relief(world), -1) && world_rocks(world) == NULL;
}

enum status render_view_bend(struct view *view, struct tile tile, double *bend)
{
	const struct tile below = tile.level < 0 ? tile : (struct tile){-1, 2 * tile.x, 2 * tile.y};
	*bend = 0;
	/* Until the look-ahead has read the tile of level 0, nothing finer is drawn. */
	if (!view->exact && !resident_ground_has_bend(world_resident(view->world)->ground, tile) && render_view_lacks_range(view, GROUND_BASE, below))
		return STATUS_OK;
	return resident_ground_bend(world_resident(view->world)->ground, tile, bend);
}

/* Returns true if the tile above this one would show the ground here too coarsely. */
static bool is_bent(struct view *view, struct tile tile)
{
	double bend;
	if (tile.level >= 0 || tile.level < world_resident(view->world)->level || !render_view_smooths(view->world))
		return false;
	enum status status = render_view_bend(view, tile, &bend);
	if (status != STATUS_OK)
		view->failed = status;
	return 4 * bend > BEND_LEAST;
}

/* Returns true if it or a tile below it has offsets, or will have by the time that is looked at. */
static bool is_deformed(const struct view *view, struct tile tile)
{
	return render_view_is_deformed(view, tile) || is_expected(view, tile);
}

/* Returns true if relief or rocks raise tiles of this level or finer ones, as far as they are drawn. */
static bool raised(const struct view *view, int level)
{
	return (world_relief(view->world) != NULL || world_rocks(view->world) != NULL) && level >= world_resident(view->world)->level;
}

/* Returns true if the tile has base heights of its own. It may read the store, once for each tile. */
static bool stored(void *user, struct tile tile)
{
	struct view *view = user;
	/* Below the working level there is no relief: its cells would be drawn as planes with sharp edges. */
	bool found = tile.level >= world_resident(view->world)->level && (relief_has_level(world_relief(view->world), tile.level) || world_rocks(view->world) != NULL);
	if (found)
		return true;
	enum status status = resident_ground_has_base(world_resident(view->world)->ground, tile, &found);
	if (status != STATUS_OK)
		view->failed = status;
	return found;
}

static bool bounds(void *user, struct tile tile, double *low, double *high)
{
	struct view *view = user;
	const struct world *world = view->world;
	if (!extent_has(&world_resident(world)->meta->extent, tile))
		return false;
	bool deformed = is_deformed(view, tile);
	if (!deformed && !raised(view, tile.level) && !stored(view, tile) && !is_bent(view, tile))
		return false;
	struct key_pair range = {.a = NAN};
	double lowest = 0, highest = 0;
	enum status status = render_view_base_range(view, tile, &range);
	if (status == STATUS_OK && deformed)
		status = render_view_offsets(view, tile, is_expected(view, tile), &lowest, &highest);
	if (status != STATUS_OK) {
		view->failed = status;
		return false;
	}
	*low = range.a + lowest;
	*high = range.b + highest;
	return !isnan(range.a);
}

static bool resident(void *user, struct tile tile, uint32_t *slot)
{
	struct view *view = user;
	return page_cache_peek(world_resident(view->world)->cache, tile_key(tile), false, slot);
}

static bool divisible(void *user, struct tile tile)
{
	struct view *view = user;
	const struct extent *extent = &world_resident(view->world)->meta->extent;
	bool deformed = is_deformed(view, tile);
	/* Offsets are kept at the working level. No finer tile has them, so none is drawn in their place, not even an inset's. */
	if (deformed || tile.level > 0)
		return deformed ? tile.level > world_resident(view->world)->level : true;
	if (raised(view, tile.level - 1) || (tile.level > world_resident(view->world)->level && render_view_smooths(view->world)))
		return true;
	for (unsigned i = 0; i < 4; i++) {
		const struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		if (extent_has(extent, child) && stored(view, child))
			return true;
	}
	return false;
}

enum status render_view_add_chain(const struct view *view, struct key_set *set, struct tile tile)
{
	int coarsest = extent_coarsest(&world_resident(view->world)->meta->extent);
	for (int level = tile.level; level <= coarsest; level++) {
		uint64_t key = tile_key(tile_ancestor(tile, level));
		if (key_set_has(set, key))
			return STATUS_OK;
		TRY(key_set_add(set, key));
	}
	return STATUS_OK;
}

enum status render_view_contact(struct view *view, const struct world_touch *touch)
{
	TRY(render_view_offsets_contact(view, touch != NULL ? &touch->area : NULL));
	return view->errors != NULL ? render_view_errors_contact(view, touch) : STATUS_OK;
}

enum status render_view_deformed(struct view *view, struct tile tile)
{
	TRY(render_view_offsets_touch(view, tile));
	return view->errors != NULL ? render_view_errors_touch(view, tile) : STATUS_OK;
}

static double error_of(void *user, struct tile tile)
{
	struct view *view = user;
	double error = 0;
	enum status status = render_view_error(view, tile, is_expected(view, tile), &error);
	if (status != STATUS_OK)
		view->failed = status;
	return error;
}

static bool not_resident(void *user, struct tile tile, uint32_t *slot)
{
	return false;
}

/* --- selecting --- */

/* Most draws of a selection. The rest of the list is room for tiles that are being divided. */
#define MOST (RENDER_DRAWS_MAX - 2 * (TILE_LEVEL_MAX - TILE_LEVEL_MIN))

/* Returns how many of the slots pictures and their requests may take. *budget: those of one picture. */
static size_t room_of(const struct world *world, size_t slots, size_t *budget)
{
	/* For each object, the tiles that one window touches, and as many for the next window. */
	size_t half = slots / 2, hold = 2 * 4 * world_scene(world)->object_count;
	hold = hold < 4 ? 4 : hold;
	size_t room = slots - (hold < half ? hold : half);
	/* Leave some for running loads. */
	size_t loads = 3 * (size_t)world_facts(world)->limits.loaders, quarter = room / 4;
	*budget = room - (loads < quarter ? loads : quarter);
	if (*budget > MOST)
		*budget = MOST;
	return room;
}

void render_view_find_room(struct view *view)
{
	view->room = room_of(view->world, world_facts(view->world)->limits.slots, &view->budget);
}

static void tell(struct view *view)
{
	size_t needed = view->selection->needed, enough = world_facts(view->world)->limits.slots, budget = view->budget;
	if (view->told)
		return;
	view->told = true;
	if (view->budget == MOST) {
		note("the view needs %zu tiles and draws at most %d: drawn coarser; import with larger tiles", needed, MOST);
		return;
	}
	while (budget < needed && budget < MOST)
		room_of(view->world, ++enough, &budget);
	note("the view needs %zu tiles here, and of %u slots objects and loads leave it %zu: drawn coarser, without the finest "
	     "ruts; give cache.slots at least %zu", needed, world_facts(view->world)->limits.slots, view->budget, enough);
}

enum status render_view_select(struct view *view, const struct render_camera *camera, bool everything)
{
	struct render_view whole;
	render_view(view->render, camera, &whole);
	return render_view_select_seen(view, &whole, everything);
}

enum status render_view_select_seen(struct view *view, const struct render_view *whole, bool everything)
{
	const struct extent *extent = &world_resident(view->world)->meta->extent;
	const struct render_source source = {view, bounds, everything ? not_resident : resident, divisible, error_of, stored};
	struct render_view looking;
	view->failed = STATUS_OK;
	view->guessed = false;
	looking = *whole;
	/* Always begin with the whole view, so that a picture does not depend on the pictures before. */
	render_select(extent, &looking, &source, view->selection);
	view->coarse = view->selection->needed > view->budget;
	if (view->coarse) {
		tell(view);
		view->coarse = !render_fit(extent, &source, view->budget, &looking);
		render_select(extent, &looking, &source, view->selection);
	}
	return view->failed;
}

void render_view_mark_used(struct view *view, bool stand_ins)
{
	struct page_cache *cache = world_resident(view->world)->cache;
	const struct render_selection *selection = view->selection;
	uint32_t slot;
	/* From far to near, since the tile used last is evicted last. The coarsest tile, which can replace all, comes after them. */
	for (size_t i = selection->draw_count; i-- > 0;) {
		const struct render_draw *draw = &selection->draws[i];
		if (draw->replaces && !stand_ins)
			continue;
		page_cache_peek(cache, tile_key(draw->tile), true, &slot);
		if (draw->ground_level != draw->tile.level)
			page_cache_peek(cache, tile_key(tile_ancestor(draw->tile, draw->ground_level)), true, &slot);
	}
	struct tile coarsest = {extent_coarsest(&world_resident(view->world)->meta->extent), 0, 0};
	page_cache_peek(cache, tile_key(coarsest), true, &slot);
}
