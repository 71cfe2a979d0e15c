/*
 * The ground from which a facet's depth counts. Below a body that pushes, the surface is the body itself, so it says nothing. So the ground ahead is
 * carried below the body, line by line against the way in which the body slides:
 *
 * - ahead: the ground that the body slides towards, as it finds it. Facets that face the way count their depth from it.
 * - under_from: the same below the front half of the body. Below the rear half it is the surface as it is: the floor of the rut. Facets that face down count
 *   from it. Below a mesh each line has a front and a rear of its own, so a body of several feet has several.
 * - heap_ahead: the mean height of the heap ahead, over the length of a passive wedge.
 * - laid_ahead: how high soil lies on the base ahead, but for what slip dug. The law of the lower envelope counts its depth from there. It bears what is left where
 *   a body slides. So it must not count the body's own heap, and must count what the body has pushed off.
 *
 * What is carried is the height above the base. So a slope, and a bump that is pushed off, count as they are at each post.
 *
 * The law of faces was fitted to plates that push their own heap, so that heap must not count as depth again. What the body finds is the base
 * and what lies on it `beyond` ahead, where its own heap has ended, or goes on falling. All this changes evenly as the body moves.
 */
#include "soil/faces/ahead.h"

#include "soil/faces/slid.h"
#include "soil/law/polygon.h"
#include "soil/shape/body.h"

#define NEAR 0.25f     /* posts: a lower envelope that is higher above the ground is outside of the soil */
#define HALVES 0.2f    /* of a body's radius, or of the length of a line in it: over so much the front half goes over to the rear half */
#define SPINS 0.02f    /* of the way of a rim: below this way of its axle a wheel spins on the spot */
#define HOLE (-1e6f)   /* m: there is no soil */
#define SLID_COUNTS 0.1f /* share of the way: where a body slides by more, the lower envelope counts its depth from where faces do */
#define CELL_LEAST 1e-9 /* a smaller share of a cell is none */
#define CELL_PARTS 7   /* of a cell at an edge of a body, each way. So a post that the edge passes does not show. With 5 a wheel that slides aside differed by 1.5 % from step to step */

void soil_ahead_read(const struct soil_planes *planes, int32_t reference, const struct soil_pose *to, struct post_rect knows, struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const int64_t zero = to->z - (int64_t)reference * ((int64_t)1 << OFFSET_BITS);
	const size_t columns = (size_t)(rect->x1 - rect->x0);
	for (int64_t y = rect->y0; y < rect->y1; y++) {
		const size_t from = (size_t)(y - planes->rect.y0) * planes->width + (size_t)(rect->x0 - planes->rect.x0), to_row = (size_t)(y - rect->y0) * columns;
		for (size_t i = 0; i < columns; i++) {
			const int32_t base = planes->base[from + i];
			const int64_t height = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) - zero;
			const bool hole = base == BASE_NODATA;
			faces->ground[to_row + i] = hole ? HOLE : (float)height * SOIL_UNIT;
			faces->offset[to_row + i] = hole ? 0 : (float)planes->offset[from + i] * SOIL_UNIT;
			const bool known = planes->dug != NULL && y >= knows.y0 && y < knows.y1 && rect->x0 + (int64_t)i >= knows.x0 && rect->x0 + (int64_t)i < knows.x1;
			faces->laid[to_row + i] = hole || planes->deposited == NULL ? 0 : (float)(planes->deposited[from + i] + (known ? planes->dug[from + i] : 0)) * SOIL_UNIT;
			faces->surface[to_row + i] = hole ? HOLE : (float)(height + planes->offset[from + i]) * SOIL_UNIT;
		}
	}
}

/* Returns how high the surface lies above the base at a place, m. x, y: posts from the first of `within`, a part of the planes. A place beyond counts as its edge. */
static float offset_at(const struct soil_planes *planes, const struct post_rect *within, float x, float y)
{
	const float u = clamped(x, 0, (float)(within->x1 - within->x0) - 1.001f), v = clamped(y, 0, (float)(within->y1 - within->y0) - 1.001f);
	const size_t first = (size_t)(within->y0 - planes->rect.y0) * planes->width + (size_t)(within->x0 - planes->rect.x0);
	const size_t at = first + (size_t)v * planes->width + (size_t)u, corners[4] = {at, at + 1, at + planes->width, at + planes->width + 1};
	const float p = u - (float)(size_t)u, q = v - (float)(size_t)v;
	float o[4];
	for (int k = 0; k < 4; k++)
		o[k] = planes->base[corners[k]] == BASE_NODATA ? 0 : (float)planes->offset[corners[k]] * SOIL_UNIT;
	const float low = o[0] + p * (o[1] - o[0]), high = o[2] + p * (o[3] - o[2]);
	return low + q * (high - low);
}

/* Sets the ground as the body finds it: the base and what lies on it `beyond` farther ahead. */
void soil_ahead_find(const struct soil_planes *planes, const struct post_rect *within, float spacing, struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const float by = faces->beyond / spacing, dx = by * faces->d[0], dy = by * faces->d[1];
	size_t at = 0;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++, at++) {
			const float there = offset_at(planes, within, (float)(x - within->x0) + dx, (float)(y - within->y0) + dy);
			/* A heap that still falls there goes on falling. */
			const float on = 2 * there - faces->offset[at];
			faces->found[at] = faces->ground[at] + clamped(on, least(there, 0), there);
		}
}

/* The lines of posts across the way in which the body slides, and how each post finds the place of the next line ahead. */
struct lines {
	int32_t count, places, line, step, way; /* lines; posts of each; elements to the next line, to the next post; towards the front: 1 or -1 */
	float aside, length;                    /* posts, to the side on the way to the next line; m of that way */
};

static struct lines lines_of(const struct soil_faces *faces, float spacing)
{
	const int32_t columns = (int32_t)(faces->rect.x1 - faces->rect.x0), rows = (int32_t)(faces->rect.y1 - faces->rect.y0);
	const bool east = fabsf(faces->d[0]) >= fabsf(faces->d[1]);
	const float along = east ? faces->d[0] : faces->d[1], aside = (east ? faces->d[1] : faces->d[0]) / most(fabsf(along), 1e-9f);
	return (struct lines){east ? columns : rows, east ? rows : columns, east ? 1 : columns, east ? columns : 1, along < 0 ? -1 : 1, aside, spacing * sqrtf(1 + aside * aside)};
}

/* A place of a line between two posts. */
struct between {
	int32_t first, second;
	float share;
};

static struct between between_at(const struct lines *l, int32_t line, int32_t place, float aside)
{
	const float at = clamped((float)place + aside, 0, (float)(l->places - 1)), low = (float)(int32_t)at;
	const int32_t first = (int32_t)low, from = line * l->line;
	return (struct between){from + first * l->step, from + (first + 1 < l->places ? first + 1 : first) * l->step, at - low};
}

static float value_at(const float *plane, const struct between *b)
{
	return plane[b->first] + b->share * (plane[b->second] - plane[b->first]);
}

/* Sets `ahead`, `heap_ahead`, `since` and `inside` of each post, line by line from the front to the rear. raised: height of the body above motion->to, m. */
static void look_ahead(const struct lines *l, float raised, float spacing, float wedge, struct soil_faces *faces)
{
	const float mixes = least(l->length / most(wedge, l->length), 1);
	for (int32_t k = 0; k < l->count; k++) {
		const int32_t here = l->way > 0 ? l->count - 1 - k : k;
		for (int32_t i = 0; i < l->places; i++) {
			const int32_t at = here * l->line + i * l->step;
			const float heap = most(faces->surface[at] - faces->found[at], 0);
			float ahead = faces->found[at] - faces->ground[at], heap_ahead = heap, since = 0, inside = 0;
			float laid = faces->laid[at] - heap;
			if (k > 0) {
				const struct between from = between_at(l, here + l->way, i, l->aside);
				const float reached = value_at(faces->over_base, &from), behind = value_at(faces->heap_ahead, &from);
				inside = faces->cover[at] * clamped(1 - (faces->envelope[at] + raised - faces->ground[at] - reached) / (NEAR * spacing), 0, 1);
				ahead += inside * (reached - ahead);
				laid += inside * (value_at(faces->laid_ahead, &from) - laid);
				heap_ahead = behind + (1 - inside) * mixes * (heap - behind);
				since = inside * (value_at(faces->since, &from) + l->length);
			}
			faces->over_base[at] = ahead;
			faces->ahead[at] = faces->ground[at] + ahead;
			faces->laid_ahead[at] = laid;
			faces->heap_ahead[at] = heap_ahead;
			faces->since[at] = since;
			faces->inside[at] = inside;
		}
	}
}

/* The same of one round or flat shape, whose middle is known: its front half lies ahead of that. */
static void put_halves(const struct soil_body *body, const struct soil_form *form, struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const double spacing = (double)form->spacing;
	const double x0 = -(double)soil_body_from_post(body->motion->to.x, rect->x0, spacing) - body->motion->beyond[0];
	const double y0 = -(double)soil_body_from_post(body->motion->to.y, rect->y0, spacing) - body->motion->beyond[1];
	const float by = 1 / most(HALVES * form->radius, form->spacing);
	size_t at = 0;
	for (int64_t y = rect->y0; y < rect->y1; y++)
		for (int64_t x = rect->x0; x < rect->x1; x++, at++) {
			const float along = (float)(x0 + (double)(x - rect->x0) * spacing) * faces->d[0] + (float)(y0 + (double)(y - rect->y0) * spacing) * faces->d[1];
			faces->under_from[at] = faces->surface[at] + faces->inside[at] * clamped(0.5f + along * by, 0, 1) * (faces->ahead[at] - faces->surface[at]);
		}
}

/* Finds how far the rear is, and where a facet that faces down counts its depth from. */
static void look_behind(const struct lines *l, struct soil_faces *faces)
{
	for (int32_t k = 0; k < l->count; k++) {
		const int32_t here = l->way > 0 ? k : l->count - 1 - k;
		for (int32_t i = 0; i < l->places; i++) {
			const int32_t at = here * l->line + i * l->step;
			float until = 0;
			if (k > 0) {
				const struct between from = between_at(l, here - l->way, i, -l->aside);
				until = faces->inside[at] * (value_at(faces->until, &from) + l->length);
			}
			faces->until[at] = until;
			const float since = faces->since[at], halves = most(HALVES * (since + until), l->length);
			const float front = faces->inside[at] * clamped(0.5f + (until - since) / halves, 0, 1);
			faces->under_from[at] = faces->surface[at] + front * (faces->ahead[at] - faces->surface[at]);
		}
	}
}

/* Returns the lower envelope of a mesh at a place, m east and north of its centre; FINE_NONE: it is not there. */
static float mesh_at(const struct soil_fine *fine, float east, float north)
{
	const int32_t column = whole_of(clamped((east - fine->x) * fine->by_step, -1e6f, 1e6f)), row = whole_of(clamped((north - fine->y) * fine->by_step, -1e6f, 1e6f));
	const bool within = column >= 0 && row >= 0 && column < fine->columns && row < fine->rows;
	return within ? fine->drawn[row * fine->stride + column] : FINE_NONE;
}

/* Returns how high the lower envelope of a body is at a place, m above its centre. The place is in m east and north of that. FINE_NONE: it is not above it. */
static float envelope_at(const struct soil_body *body, const struct soil_form *form, double east, double north)
{
	struct lower_place place;
	if (form->kind == FORM_RASTER)
		return mesh_at(&form->fine, (float)east, (float)north);
	return soil_lower_at(&body->lower, east, north, &place) ? (float)place.z : FINE_NONE;
}

/* envelope_row of an ellipsoid, or a ball: side by side what soil_lower_at computes. */
SOIL_CLONED static void ellipsoid_row(const struct lower_envelope *restrict u, double east, double step, double north, int64_t first, int64_t count, float *restrict to)
{
	const double inside[3] = {u->inside[0], u->inside[1], u->inside[2]}, rise[2] = {u->rise[0], u->rise[1]}, lift = u->lift, y = north;
	for (int64_t i = 0; i < count; i++) {
		const double x = east + (double)(int32_t)(first + i) * step;
		const double left = 1 - (inside[0] * x * x + 2 * inside[1] * x * y + inside[2] * y * y);
		const float z = (float)(rise[0] * x + rise[1] * y - lift * sqrt(left < 0 ? 0 : left));
		to[i] = left < 0 ? FINE_NONE : z;
	}
}

/* Puts how high the lower envelope of a body is along a row of places into `to`: at east + (first + i) step. */
static void envelope_row(const struct soil_body *body, const struct soil_form *form, double east, double step, double north, int64_t first, int64_t count, float *to)
{
	if (form->kind != FORM_RASTER && body->lower.shape->kind == SOIL_ELLIPSOID) {
		ellipsoid_row(&body->lower, east, step, north, first, count, to);
		return;
	}
	for (int64_t i = 0; i < count; i++)
		to[i] = envelope_at(body, form, east + (double)(first + i) * step, north);
}

/* Finds which share of a cell the body is above, and its mean height there. */
static void put_part(const struct soil_body *body, const struct soil_form *form, double east, double north, float *envelope, float *cover)
{
	const double part = (double)form->spacing / CELL_PARTS;
	float sum = 0, count = 0, heights[CELL_PARTS];
	for (int i = 0; i < CELL_PARTS; i++) {
		envelope_row(body, form, east, part, north + (i - CELL_PARTS / 2) * part, -(CELL_PARTS / 2), CELL_PARTS, heights);
		for (int k = 0; k < CELL_PARTS; k++) {
			sum += heights[k] < FINE_NONE ? heights[k] : 0;
			count += heights[k] < FINE_NONE ? 1 : 0;
		}
	}
	*envelope = count > 0 ? sum / count : FINE_NONE;
	*cover = count / (CELL_PARTS * CELL_PARTS);
}

/* Tells whether the outline of a body in plan is a rectangle, as that of an upright wheel or a level box is. half: half its sides along the frame's axes, m. */
static bool is_rectangle(const struct soil_body *body, const struct soil_form *form, double half[2])
{
	const bool wheel = body->motion->shape->kind == SOIL_WHEEL && body->motion->shape->grousers == 0 && form->lean == 0;
	half[0] = (double)(wheel ? form->radius : form->half[0]);
	half[1] = (double)form->half[1];
	return wheel || (form->kind == FORM_BOX && form->tilts == 0);
}

/* Tells whether a cut would leave a polygon as it is. */
static bool is_uncut(const double normal[2], double limit, const struct polygon *p)
{
	bool is = true;
	for (int i = 0; i < p->count; i++)
		is &= normal[0] * p->at[i][0] + normal[1] * p->at[i][1] - limit <= 0;
	return is;
}

/* The same as put_part, of a body with a straight outline. */
static void put_exact_part(const struct soil_body *body, const struct soil_form *form, const double outline[2], double east, double north, float *envelope, float *cover)
{
	const double half = 0.5 * (double)form->spacing;
	struct polygon part = {4, {{east - half, north - half}, {east + half, north - half}, {east + half, north + half}, {east - half, north + half}}};
	for (int side = 0; side < 4; side++) {
		const double sign = side % 2 == 0 ? 1 : -1, along[2] = {body->axis[0], body->axis[1]}, aside[2] = {-body->axis[1], body->axis[0]};
		const double *axis = side < 2 ? along : aside;
		const double normal[2] = {sign * axis[0], sign * axis[1]};
		if (!is_uncut(normal, outline[side / 2], &part)) /* most sides are far away */
			cut_polygon(normal, outline[side / 2], &part);
	}
	const struct amounts sum = amounts_of(&part);
	const double share = sum.area / (4 * half * half);
	const bool is = share > CELL_LEAST;
	*envelope = is ? envelope_at(body, form, sum.by[0] / sum.area, sum.by[1] / sum.area) : FINE_NONE;
	*cover = is && *envelope < FINE_NONE ? (float)share : 0;
}

/* Counts above how many of the posts y - 1, y and y + 1 of each column the body is. Returns how many of these rows there are. */
SOIL_CLONED static float count_columns(const float *restrict envelope, int64_t y, int64_t columns, int64_t rows, float *restrict counts)
{
	const int64_t from = y > 0 ? y - 1 : 0, end = y + 2 < rows ? y + 2 : rows;
	for (int64_t x = 0; x < columns; x++)
		counts[x] = 0;
	for (int64_t j = from; j < end; j++)
		for (int64_t x = 0; x < columns; x++)
			counts[x] += envelope[j * columns + x] < FINE_NONE ? 1 : 0;
	return (float)(end - from);
}

/* Tells whether an edge of the body passes beside a post: it is above some posts beside it, but not above all. high: rows that were counted. */
static bool at_edge(const float *counts, int64_t x, int64_t columns, float high)
{
	const float before = x > 0 ? counts[x - 1] : 0, after = x + 1 < columns ? counts[x + 1] : 0, sum = before + counts[x] + after;
	return sum > 0 && sum < high * (float)(1 + (x > 0) + (x + 1 < columns));
}

void soil_ahead_body(const struct soil_body *body, const struct soil_form *form, struct soil_faces *faces)
{
	const struct post_rect *rect = &faces->rect;
	const double spacing = (double)form->spacing;
	const int64_t columns = rect->x1 - rect->x0, rows = rect->y1 - rect->y0;
	const double x0 = -(double)soil_body_from_post(body->motion->to.x, rect->x0, spacing) - body->motion->beyond[0];
	const double y0 = -(double)soil_body_from_post(body->motion->to.y, rect->y0, spacing) - body->motion->beyond[1];
	/* Neither is needed yet. */
	float *heights = faces->until, *counts = faces->inside;
	double outline[2];
	const bool exact = is_rectangle(body, form, outline);
	for (int64_t y = 0; y < rows; y++)
		envelope_row(body, form, x0, spacing, y0 + (double)y * spacing, 0, columns, heights + y * columns);
	for (int64_t y = 0; y < rows; y++) {
		const float high = count_columns(heights, y, columns, rows, counts);
		for (int64_t x = 0; x < columns; x++) {
			const int64_t at = y * columns + x;
			faces->envelope[at] = heights[at];
			faces->cover[at] = heights[at] < FINE_NONE ? 1 : 0;
			if (!at_edge(counts, x, columns, high))
				continue;
			if (exact)
				put_exact_part(body, form, outline, x0 + (double)x * spacing, y0 + (double)y * spacing, &faces->envelope[at], &faces->cover[at]);
			else
				put_part(body, form, x0 + (double)x * spacing, y0 + (double)y * spacing, &faces->envelope[at], &faces->cover[at]);
		}
	}
}

/* Returns where a post that was gathered lies in the rectangle of the faces. */
static size_t place_of(const struct soil_planes *planes, const struct soil_faces *faces, const struct soil_posts *posts, size_t i)
{
	const struct post_rect *rect = &faces->rect;
	const uint32_t at = (uint32_t)posts->index[i], width = (uint32_t)planes->width; /* a window's: short divisions */
	const int64_t x = planes->rect.x0 + (int64_t)(at % width) - rect->x0, y = planes->rect.y0 + (int64_t)(at / width) - rect->y0;
	return (size_t)y * (size_t)(rect->x1 - rect->x0) + (size_t)x;
}

/* Sets how far the ground of each post is above where the law of the lower envelope counts its depth from. */
static void put_heaps(const struct soil_planes *planes, const struct soil_form *form, float slides, const struct soil_faces *faces, struct soil_posts *posts)
{
	for (size_t i = 0; i < posts->count; i++) {
		const size_t place = place_of(planes, faces, posts, i);
		const float off = posts->base[i] == BASE_NODATA ? 0 : slides * (faces->laid[place] - faces->laid_ahead[place]);
		posts->heap[i] = off == 0 ? 0 : off * clamped((slid_at(form, posts->x[i], posts->y[i]) - SLID_LEAST) * (1 / SLID_COUNTS), 0, 1);
	}
}

/* Where the body does not slide, soil below it counts as it was before the body pushed it. slides: 1: it does; 0: it does not. */
static void put_still(const struct soil_planes *planes, const struct soil_posts *posts, float raised, float spacing, float slides, struct soil_faces *faces)
{
	for (size_t i = 0; i < posts->count && slides < 1; i++) {
		const size_t place = place_of(planes, faces, posts, i);
		const float ground = (float)posts->ground[i] * SOIL_UNIT, inside = faces->cover[place] * clamped(1 - (faces->envelope[place] + raised - ground) / (NEAR * spacing), 0, 1);
		const float still = (1 - slides) * inside * (posts->base[i] == BASE_NODATA ? 0.0f : 1.0f);
		faces->under_from[place] += still * (ground - faces->under_from[place]);
		faces->ahead[place] += still * (ground - faces->ahead[place]);
	}
}

void soil_ahead_put(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts, float raised, float wedge,
		    struct soil_faces *faces)
{
	const struct soil_recent *m = &form->recent;
	const float plan = sqrtf(m->way[0] * m->way[0] + m->way[1] * m->way[1]), up = fabsf(m->way[2]), turns = form->rim_reach * sqrtf(dot3(m->turning, m->turning));
	/* A body that goes nowhere has no way ahead: not one that turns or sinks, or a wheel that spins on the spot. */
	const float slides = clamped(4 * plan / (plan + up + turns + SPINS * form->rim_reach * sqrtf(dot3(m->rolling, m->rolling)) + 1e-6f), 0, 1);
	const struct lines lines = lines_of(faces, form->spacing);
	look_ahead(&lines, raised, form->spacing, wedge, faces);
	if (form->kind == FORM_RASTER)
		look_behind(&lines, faces);
	else
		put_halves(body, form, faces);
	put_still(planes, posts, raised, form->spacing, slides, faces);
	put_heaps(planes, form, slides, faces, posts);
}
