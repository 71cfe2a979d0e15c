/*
 * Bodies at rest keep ground out of themselves: soil that slides does not rise above their lower envelopes, and what is laid goes elsewhere. A body whose
 * contact is being computed is none of them: its contact lowers the ground below it.
 */
#include <string.h>

#include "base/memory.h"
#include "bearing/internal.h"

#define CLOSED_HERE 64 /* a bit of a post's contact: it is held only while soil is laid */

static size_t posts_of(const struct bearing *bearing)
{
	const struct soil_planes *planes = &bearing->window.planes;
	return planes->width * (size_t)(planes->rect.y1 - planes->rect.y0);
}

static enum status need(struct bearing *bearing)
{
	struct bearing_window *window = &bearing->window;
	const size_t posts = posts_of(bearing), bytes = soil_roofs_scratch(&window->planes);
	if (posts > window->highest_posts) {
		mem_free(window->highest);
		mem_free(window->touched);
		window->touched = NULL;
		window->highest_posts = 0;
		TRY(mem_make(&window->highest, posts, sizeof *window->highest, "bodies at rest"));
		if (!bearing->bears)
			TRY(mem_make(&window->touched, posts, sizeof *window->touched, "bodies at rest"));
		window->highest_posts = posts;
	}
	if (bytes > window->roof_bytes) {
		mem_free(window->roof_scratch);
		window->roof_bytes = 0;
		TRY(mem_make(&window->roof_scratch, bytes, 1, "bodies at rest"));
		window->roof_bytes = bytes;
	}
	return STATUS_OK;
}

enum status bearing_roof(struct bearing *bearing, const struct soil_shape *shape, const struct soil_pose *pose)
{
	struct bearing_window *window = &bearing->window;
	struct soil_planes *planes = &window->planes;
	const struct soil_kinematic kinematic = {.spacing = bearing->law.spacing, .reference = bearing->law.reference};
	const struct soil_kinematic_contact contact = {.shape = shape};
	const struct post_rect shadow = post_rect_intersect(soil_shadow(shape, pose, pose, bearing->law.spacing), planes->rect);
	if (post_rect_empty(shadow))
		return STATUS_OK;
	const size_t bytes = soil_kinematic_room(&kinematic, &contact, (size_t)(shadow.x1 - shadow.x0), (size_t)(shadow.y1 - shadow.y0));
	struct soil_mesh mirrored = {.vertices = NULL};
	TRY(bearing_scratch_need(bearing, 2 * bytes));
	TRY(need(bearing));
	if (!window->roofed)
		for (size_t i = 0, count = posts_of(bearing); i < count; i++)
			window->highest[i] = SOIL_ROOF_NONE;
	if (shape->kind == SOIL_MESH)
		TRY(soil_kinematic_mirror(shape->mesh, &mirrored));
	window->roofed |= soil_kinematic_roof(&kinematic, shape, mirrored.vertices != NULL ? &mirrored : NULL, pose, planes, window->highest, window->scratch);
	mem_free(mirrored.vertices);
	return STATUS_OK;
}

enum status bearing_roofs_keep_touched(struct bearing *bearing, const uint8_t **touched)
{
	TRY(need(bearing));
	memcpy(bearing->window.touched, bearing->window.planes.contact, posts_of(bearing));
	*touched = bearing->window.touched;
	return STATUS_OK;
}

void bearing_roofs_clear(struct bearing *bearing)
{
	bearing->window.roofed = false;
}

const struct soil_roofs *bearing_roofs(const struct bearing *bearing, struct soil_roofs *roofs)
{
	*roofs = (struct soil_roofs){bearing->window.highest, bearing->window.roof_scratch};
	return bearing->window.roofed ? roofs : NULL;
}

void bearing_roofs_close(struct bearing *bearing)
{
	const struct bearing_window *window = &bearing->window;
	const int32_t least = (int32_t)lattice_offset(fmin(bearing->law.spacing, 500));
	uint8_t *contact = window->planes.contact;
	for (size_t i = 0, count = window->roofed ? posts_of(bearing) : 0; i < count; i++)
		if (window->highest[i] != SOIL_ROOF_NONE && (int64_t)window->highest[i] - window->planes.offset[i] < least && (contact[i] & SOIL_HELD) == 0)
			contact[i] |= SOIL_HELD | CLOSED_HERE;
}

void bearing_roofs_open(struct bearing *bearing)
{
	uint8_t *contact = bearing->window.planes.contact;
	for (size_t i = 0, count = bearing->window.roofed ? posts_of(bearing) : 0; i < count; i++)
		if ((contact[i] & CLOSED_HERE) != 0)
			contact[i] &= (uint8_t)~(SOIL_HELD | CLOSED_HERE);
}

/* Tells whether soil was laid on a post that has no roof. */
static bool takes(const struct bearing_window *window, size_t at)
{
	return window->deposits[at] != 0 && window->highest[at] == SOIL_ROOF_NONE;
}

int64_t bearing_roofs_part(struct bearing *bearing, struct post_rect laid)
{
	const struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	const struct post_rect rect = post_rect_intersect(laid, planes->rect);
	int64_t more = 0, takers = 0;
	for (int pass = 0; pass < 2 && window->roofed; pass++) {
		if (pass == 1 && (more == 0 || takers == 0))
			break;
		const int64_t each = pass == 1 ? more / takers : 0;
		int64_t rest = pass == 1 ? more % takers : 0;
		for (int64_t y = rect.y0; y < rect.y1; y++)
			for (int64_t x = rect.x0; x < rect.x1; x++) {
				const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
				if (pass == 1 && takes(window, at)) {
					const int64_t gets = each + (rest > 0);
					window->deposits[at] = (int32_t)((uint32_t)window->deposits[at] + (uint32_t)gets);
					more -= gets;
					rest -= rest > 0;
				} else if (pass == 0 && window->highest[at] != SOIL_ROOF_NONE) {
					const int64_t room = (int64_t)window->highest[at] - planes->offset[at], fits = room > 0 ? room : 0, has = (uint32_t)window->deposits[at];
					more += has > fits ? has - fits : 0;
					window->deposits[at] = (int32_t)(has > fits ? fits : has);
				} else if (pass == 0) {
					takers += takes(window, at);
				}
			}
	}
	return more;
}

int64_t bearing_roofs_limit(struct bearing *bearing, struct post_rect laid)
{
	const struct bearing_window *window = &bearing->window;
	const struct soil_planes *planes = &window->planes;
	const struct post_rect rect = post_rect_intersect(laid, planes->rect);
	int64_t more = 0;
	for (int64_t y = rect.y0; y < rect.y1 && window->roofed; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			const size_t at = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(x - planes->rect.x0);
			const int64_t room = (int64_t)window->highest[at] - planes->offset[at], fits = room > 0 ? room : 0, has = (uint32_t)window->deposits[at];
			if (window->highest[at] == SOIL_ROOF_NONE || has <= fits)
				continue;
			more += has - fits;
			window->deposits[at] = (int32_t)fits;
		}
	return more;
}

void bearing_roofs_finish(struct bearing_window *window)
{
	mem_free_all(window->highest, window->touched, window->roof_scratch);
}
