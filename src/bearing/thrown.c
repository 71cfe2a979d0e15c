/*
 * Thrown soil that lands, as deposited soil. src/bearing/throws.h tells how it leaves and flies.
 *
 * Invariant: what is added to offsets, and what is lost, is together what landed, to the unit.
 */
#include <math.h>

#include "bearing/internal.h"

#define HIGHEST (INT32_MAX / 2) /* fixed-point units: no post is raised above that */
#define PART 256 /* of a cell, by which a place shares its volume among four posts */

/* A place on the ground: the south-west post of its cell, and how far it lies in the cell, of PART. */
struct place {
	int64_t x, y;
	int32_t east, north;
};

static void along(int64_t at, double spacing, int64_t *post, int32_t *part)
{
	const double posts = lattice_offset_metres(at) / spacing, whole = floor(posts);
	*post = (int64_t)whole;
	*part = (int32_t)lround((posts - whole) * PART);
}

static struct place place_of(const struct bearing *bearing, const struct bearing_landing *landing)
{
	struct place place;
	along(landing->x, bearing->law.spacing, &place.x, &place.east);
	along(landing->y, bearing->law.spacing, &place.y, &place.north);
	return place;
}

struct post_rect bearing_thrown_posts(const struct bearing *bearing, const struct bearing_landing *landings, size_t count)
{
	struct post_rect all = {0, 0, 0, 0};
	for (size_t i = 0; i < count; i++) {
		const struct place at = place_of(bearing, &landings[i]);
		all = post_rect_joined(all, post_rect_grown((struct post_rect){at.x, at.y, at.x + 2, at.y + 2}, BEARING_LANDS_NEAR));
	}
	return post_rect_intersect(all, bearing->world);
}

/* Tells whether a post can take soil. */
static bool takes(const struct soil_planes *planes, int64_t x, int64_t y, int64_t volume)
{
	if (x < planes->rect.x0 || y < planes->rect.y0 || x >= planes->rect.x1 || y >= planes->rect.y1)
		return false;
	const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
	if (planes->base[at] == BASE_NODATA || (planes->contact[at] & (SOIL_LOWERED | SOIL_HELD)) != 0 || volume > HIGHEST)
		return false;
	return planes->offset[at] <= HIGHEST - volume && planes->deposited[at] <= HIGHEST - volume;
}

static void put(const struct soil_planes *planes, int64_t x, int64_t y, int64_t volume, struct post_rect *changed)
{
	const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
	planes->offset[at] += (int32_t)volume;
	planes->deposited[at] += (int32_t)volume;
	*changed = post_rect_joined(*changed, (struct post_rect){x, y, x + 1, y + 1});
}

/* Adds soil to the nearest post that takes it; of several to the first one from the south-west. Returns false if none does. */
static bool put_near(const struct soil_planes *planes, int64_t x, int64_t y, int64_t volume, struct post_rect *changed)
{
	int64_t nearest = INT64_MAX, to_x = 0, to_y = 0;
	for (int64_t dy = -BEARING_LANDS_NEAR; dy <= BEARING_LANDS_NEAR; dy++)
		for (int64_t dx = -BEARING_LANDS_NEAR; dx <= BEARING_LANDS_NEAR; dx++)
			if (dx * dx + dy * dy < nearest && takes(planes, x + dx, y + dy, volume)) {
				nearest = dx * dx + dy * dy;
				to_x = x + dx;
				to_y = y + dy;
			}
	if (nearest == INT64_MAX)
		return false;
	put(planes, to_x, to_y, volume, changed);
	return true;
}

/* Puts down what landed at one place. Returns what found no post. */
static int64_t land(const struct bearing *bearing, const struct bearing_landing *landing, struct post_rect *changed)
{
	const struct soil_planes *planes = &bearing->window.planes;
	const struct place at = place_of(bearing, landing);
	const int64_t nearest_x = at.x + (2 * at.east > PART), nearest_y = at.y + (2 * at.north > PART);
	int64_t rest = landing->volume;
	for (int k = 0; k < 4; k++) {
		const int64_t weight = (int64_t)(k % 2 == 0 ? PART - at.east : at.east) * (k < 2 ? PART - at.north : at.north);
		const int64_t part = landing->volume * weight / (PART * PART);
		if (part == 0 || !takes(planes, at.x + k % 2, at.y + k / 2, part))
			continue;
		put(planes, at.x + k % 2, at.y + k / 2, part, changed);
		rest -= part;
	}
	return rest == 0 || put_near(planes, nearest_x, nearest_y, rest, changed) ? 0 : rest;
}

enum status bearing_thrown_land(struct bearing *bearing, const struct bearing_landing *landings, size_t count, const struct deform_rest *rests, size_t rest_count,
				const struct tile_slot *held, size_t held_count, struct post_rect *changed, int64_t *lost)
{
	const struct post_rect rect = bearing_thrown_posts(bearing, landings, count);
	const unsigned written = bearing->planes & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DEPOSITED));
	*changed = (struct post_rect){0, 0, 0, 0};
	*lost = 0;
	for (size_t i = 0; i < count && post_rect_empty(rect); i++)
		*lost += landings[i].volume;
	if (post_rect_empty(rect))
		return STATUS_OK;
	TRY(bearing_window_need(bearing, rect));
	bearing_window_clear(bearing);
	bearing_window_gather(bearing, held, held_count, true, true);
	bearing_roofs_clear(bearing);
	TRY(bearing_hold(bearing, rests, rest_count));
	bearing_roofs_close(bearing);
	for (size_t i = 0; i < held_count; i++)
		TRY(resident_host_write(bearing->slots, held[i].slot, written));
	for (size_t i = 0; i < count; i++) {
		const int64_t rest = land(bearing, &landings[i], changed);
		bearing->tally.compacted -= landings[i].volume - rest;
		*lost += rest;
	}
	if (post_rect_empty(*changed))
		return STATUS_OK;
	resident_host_scatter(bearing->slots, held, held_count, &bearing->window.planes, *changed, written);
	return bearing_wake(bearing, *changed);
}
