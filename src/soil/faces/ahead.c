/*
 * The surface of the soil that a facet's depth counts from. Below a body that presses, the surface is the body itself, so it says nothing. There it is the
 * surface that the body slides towards: of each post that the body presses, the one ahead of it. So a heap ahead counts, and behind the body the floor of its rut.
 *
 * How much a post is pressed, `held`, is 1 where the lower envelope is below the surface, and 0 from a quarter of a post above it. It is 0, too, where the
 * envelope rises backwards, as behind an axle: the body does not press there. All this changes evenly as the body moves.
 */
#include "soil/faces/ahead.h"

#define NEAR 0.25f   /* posts: a body that is higher above the surface does not press */
#define LEANS 0.15f  /* an envelope that rises backwards by more does not press */
#define HOLE (-1e6f) /* m: there is no soil */

void soil_ahead_read(const struct soil_planes *planes, int32_t reference, const struct soil_pose *to, struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const int64_t zero = to->z - (int64_t)reference * ((int64_t)1 << OFFSET_BITS);
	const size_t columns = (size_t)(rect->x1 - rect->x0);
	for (int64_t y = rect->y0; y < rect->y1; y++) {
		const size_t from = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(rect->x0 - planes->rect.x0);
		float *to_row = faces->surface + (size_t)(y - rect->y0) * columns;
		for (size_t i = 0; i < columns; i++) {
			const int32_t base = planes->base[from + i];
			const int64_t height = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) + planes->offset[from + i] - zero;
			to_row[i] = base == BASE_NODATA ? HOLE : (float)height * SOIL_UNIT;
		}
	}
}

/* Sets how much the body presses on each post, and the surface there without it. */
static void put_held(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct soil_posts *posts, float raised,
		     struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const size_t columns = (size_t)(rect->x1 - rect->x0), count = columns * (size_t)(rect->y1 - rect->y0);
	const float c = (float)body->axis[0], s = (float)body->axis[1], d[2] = {c * faces->d[0] + s * faces->d[1], c * faces->d[1] - s * faces->d[0]};
	const float plan = sqrtf(form->recent.way[0] * form->recent.way[0] + form->recent.way[1] * form->recent.way[1]), slides = clamped(4 * plan, 0, 1);
	memset(faces->held, 0, count * sizeof *faces->held);
	memcpy(faces->ahead, faces->surface, count * sizeof *faces->ahead);
	for (size_t i = 0; i < posts->count; i++) {
		if (!(posts->over[i] > 0) || posts->base[i] == BASE_NODATA)
			continue;
		const size_t at = (size_t)posts->index[i];
		const int64_t x = planes->rect.x0 + (int64_t)(at % planes->width) - rect->x0, y = planes->rect.y0 + (int64_t)(at / planes->width) - rect->y0;
		const size_t place = (size_t)y * columns + (size_t)x;
		const float above = posts->height[i] + posts->above[i] + raised - faces->surface[place], leans = posts->slope_x[i] * d[0] + posts->slope_y[i] * d[1];
		const float held = clamped(1 - above / (NEAR * form->spacing), 0, 1) * clamped(1 + leans * (1 / LEANS), 0, 1);
		faces->held[place] = held * slides;
		/* Where it does not slide, the soil counts as it was before the body pressed it. */
		faces->ahead[place] += held * (1 - slides) * ((float)posts->ground[i] * SOIL_UNIT - faces->surface[place]);
	}
}

/* Gives each pressed post the surface ahead of it: from the next line of posts ahead, between two of them. */
static void look_ahead(struct soil_faces *faces)
{
	const int32_t columns = (int32_t)(faces->rect.x1 - faces->rect.x0), rows = (int32_t)(faces->rect.y1 - faces->rect.y0);
	const bool east = fabsf(faces->d[0]) >= fabsf(faces->d[1]);
	const float along = east ? faces->d[0] : faces->d[1], aside = (east ? faces->d[1] : faces->d[0]) / most(fabsf(along), 1e-9f);
	const int32_t lines = east ? columns : rows, places = east ? rows : columns, line = east ? 1 : columns, step = east ? columns : 1, way = along < 0 ? -1 : 1;
	if (!(fabsf(along) > 0))
		return;
	for (int32_t k = 1; k < lines; k++) {
		const int32_t here = way > 0 ? lines - 1 - k : k;
		const float *from = faces->ahead + (here + way) * line;
		float *to = faces->ahead + here * line;
		const float *held = faces->held + here * line;
		for (int32_t i = 0; i < places; i++) {
			const float at = clamped((float)i + aside, 0, (float)(places - 1)), low = (float)(int32_t)at;
			const int32_t first = (int32_t)low, second = first + 1 < places ? first + 1 : first;
			const float a = from[first * step], b = from[second * step], ahead = a + (at - low) * (b - a);
			to[i * step] += held[i * step] * (ahead - to[i * step]);
		}
	}
}

void soil_ahead_put(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct soil_posts *posts, float raised,
		    struct soil_faces *faces)
{
	put_held(planes, body, form, posts, raised, faces);
	look_ahead(faces);
}
