/* Draws the triangles of a mesh over the places of its raster: see fine.h. */
#include "soil/law/fine.h"

#include "soil/shape/body.h"

#define UPRIGHT 1e-3f /* places squared: a triangle with less area from above counts as upright */
#define ROWS 8     /* of a triangle, at once */
#define NEAR 1e-4f /* places: what lies beside an edge by less is below both triangles of the edge */

/* Puts the vertices in places, from the first place. */
SOIL_CLONED static void place(const struct soil_surface *restrict s, const float axes[restrict 3][3], const float centre[restrict 2], float *restrict u, float *restrict v,
			      float *restrict z)
{
	for (size_t i = 0; i < s->vertex_count; i++) {
		const float x = s->x[i], y = s->y[i], h = s->z[i];
		u[i] = centre[0] + (x * axes[0][0] + y * axes[1][0] + h * axes[2][0]);
		v[i] = centre[1] + (x * axes[0][1] + y * axes[1][1] + h * axes[2][1]);
		z[i] = x * axes[0][2] + y * axes[1][2] + h * axes[2][2];
	}
}

/* Puts the turned vertices in places. */
SOIL_CLONED static void put_places(const struct soil_surface *restrict s, const float centre[restrict 2], float by_step, float *restrict u, float *restrict v, float *restrict z)
{
	const float *x = s->turned[0], *y = s->turned[1], *h = s->turned[2];
	for (size_t i = 0; i < s->vertex_count; i++) {
		u[i] = centre[0] + x[i] * by_step;
		v[i] = centre[1] + y[i] * by_step;
		z[i] = h[i];
	}
}

SOIL_CLONED static void bounds_of(const float *restrict at, size_t count, float bounds[restrict 2])
{
	float low = at[0], high = at[0];
	for (size_t i = 0; i < count; i++) {
		low = least(low, at[i]);
		high = most(high, at[i]);
	}
	bounds[0] = low;
	bounds[1] = high;
}

/* --- triangles --- */

SOIL_INLINED int32_t floor_of(float v)
{
	const int32_t whole = (int32_t)v;
	return whole - ((float)whole > v);
}

SOIL_INLINED int32_t ceil_of(float v)
{
	return -floor_of(-v);
}

struct corner {
	float u, v, z;
};

SOIL_INLINED void order(struct corner *a, struct corner *b)
{
	if (a->v > b->v) {
		const struct corner other = *a;
		*a = *b;
		*b = other;
	}
}

/* Lowers the places below a triangle. area: twice its area, signed. */
SOIL_INLINED void draw(struct corner a, struct corner b, struct corner c, float area, const int32_t size[2], int32_t stride, float *restrict drawn)
{
	const float left_most = least(a.u, least(b.u, c.u)) - NEAR, right_most = most(a.u, most(b.u, c.u)) + NEAR;
	if (ceil_of(left_most) > floor_of(right_most))
		return;
	const float by = 1 / area, low = least(a.z, least(b.z, c.z)), high = most(a.z, most(b.z, c.z));
	const float du = ((b.z - a.z) * (c.v - a.v) - (c.z - a.z) * (b.v - a.v)) * by, dv = ((c.z - a.z) * (b.u - a.u) - (b.z - a.z) * (c.u - a.u)) * by;
	const float at = a.z - du * a.u - dv * a.v;
	order(&a, &b);
	order(&b, &c);
	order(&a, &b);
	const int32_t low_row = ceil_of(a.v - NEAR), high_row = floor_of(c.v + NEAR), first = low_row < 0 ? 0 : low_row, last = high_row < size[1] ? high_row : size[1] - 1;
	const float tall = most(c.v - a.v, 1e-9f), along = (c.u - a.u) / tall, below = (b.u - a.u) / most(b.v - a.v, 1e-9f), above = (c.u - b.u) / most(c.v - b.v, 1e-9f);
	for (int32_t row = first; row <= last; row += ROWS) {
		int32_t from[ROWS], to[ROWS];
		for (int32_t i = 0; i < ROWS; i++) {
			const float v = clamped((float)(row + i), a.v, c.v), one = a.u + (v - a.v) * along;
			const float two = either(v < b.v, a.u + (v - a.v) * below, either(c.v > b.v, b.u + (v - b.v) * above, b.u));
			/* Numbers are at least 0 here, so a conversion rounds down. */
			const float left = clamped(least(one, two) - NEAR, 0, (float)size[0]), right = clamped(most(one, two) + NEAR, -1, (float)(size[0] - 1));
			const int32_t whole = (int32_t)left;
			from[i] = whole + ((float)whole < left);
			to[i] = (int32_t)(right + 1) - 1;
		}
		for (int32_t i = 0; i < ROWS && row + i <= last; i++) {
			float *places = drawn + (size_t)(row + i) * (size_t)stride;
			const float level = at + dv * (float)(row + i);
			for (int32_t column = from[i]; column <= to[i]; column++)
				places[column] = least(places[column], clamped(level + du * (float)column, low, high));
		}
	}
}

SOIL_CLONED static void put_looks(const struct soil_surface *restrict s, const float *restrict u, const float *restrict v, uint8_t *restrict looks)
{
	for (size_t t = 0; t < s->triangle_count; t++) {
		const uint32_t *c = s->corners[t], i = c[0], j = c[1], k = c[2];
		const float area = (u[j] - u[i]) * (v[k] - v[i]) - (u[k] - u[i]) * (v[j] - v[i]);
		looks[t] = area < -UPRIGHT ? FINE_SOLE : FINE_UP;
	}
}

/* Draws the triangles that look so. Of a mesh that is not closed all triangles are drawn. */
SOIL_CLONED static void draw_all(const struct soil_surface *restrict s, const float *restrict u, const float *restrict v, const float *restrict z,
				 const int32_t size[restrict 2], int32_t stride, const uint8_t *restrict looks, uint8_t which, float *restrict drawn)
{
	for (size_t t = 0; t < s->triangle_count; t++) {
		if (s->closed && looks[t] != which)
			continue;
		const uint32_t *c = s->corners[t], i = c[0], j = c[1], k = c[2];
		const float area = (u[j] - u[i]) * (v[k] - v[i]) - (u[k] - u[i]) * (v[j] - v[i]);
		if (area < 0 || area > 0)
			draw((struct corner){u[i], v[i], z[i]}, (struct corner){u[j], v[j], z[j]}, (struct corner){u[k], v[k], z[k]}, area, size, stride, drawn);
	}
}

/* --- memory --- */

static enum status need(struct soil_fine_work *work, const struct soil_fine *fine, size_t vertices, size_t triangles)
{
	const size_t places = (size_t)fine->stride * (size_t)fine->rows, cells = (size_t)(fine->cells[0] + 1) * (size_t)fine->cells[1], strips = (size_t)fine->strips;
	const size_t pad = 16, counts[] = {vertices, vertices, vertices, places, places, places, places, places, cells, cells, cells, cells, cells,
					   cells, cells, cells, cells, cells, cells, cells, strips, strips, 3 * (size_t)fine->stride, vertices, vertices, vertices, vertices, (triangles + 3) / 4, places,
					   cells * sizeof(struct soil_brim) / sizeof(float)};
	struct soil_brim **const brims = &work->brims;
	float **arrays[] = {&work->u, &work->v, &work->z, &work->drawn, &work->heights, &work->less, &work->since, &work->swept, &work->sums[0], &work->sums[1],
			    &work->sums[2], &work->sums[3], &work->sums[4], &work->areas, &work->middles[0], &work->middles[1], &work->lows, &work->passed, &work->earlier[0],
			    &work->earlier[1], &work->front, &work->rear, &work->row, &work->earlier_u, &work->earlier_v, &work->earlier_z, NULL, NULL, &work->walls, NULL};
	size_t all = 0;
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
		all += (counts[i] + pad) / pad * pad;
	if (all * sizeof(float) > work->room) {
		mem_free(work->memory);
		work->room = 0;
		TRY(mem_make(&work->memory, all + all / 2, sizeof(float), "the raster of a mesh"));
		work->room = (all + all / 2) * sizeof(float);
	}
	float *memory = work->memory;
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		if (arrays[i] != NULL)
			*arrays[i] = memory;
		else if (i + 1 == sizeof counts / sizeof *counts)
			*brims = (struct soil_brim *)(void *)memory;
		else if (i + 3 == sizeof counts / sizeof *counts)
			work->looks = (uint8_t *)memory;
		else
			work->onward = (uint32_t *)(void *)memory;
		memory += (counts[i] + pad) / pad * pad;
	}
	return STATUS_OK;
}

void soil_fine_finish(struct soil_fine_work *work)
{
	soil_surfaces_finish(&work->surfaces);
	mem_free(work->memory);
	*work = (struct soil_fine_work){0};
}

/* --- the raster --- */

/* Lays the raster so that posts are places. extent: m: how far the mesh reaches from its centre, east and north. */
static void lay_out(const struct soil_body *body, const struct soil_form *form, const double extent[2], struct soil_fine *fine, double centre[2])
{
	const struct soil_motion *motion = body->motion;
	const double spacing = (double)form->spacing;
	double first[2];
	const double across = 2 * fmax(extent[0], extent[1]);
	int parts = across >= FINE_ENOUGH * spacing ? 1 : (int)fmin(ceil(FINE_ACROSS * spacing / fmax(across, 1e-9)), FINE_PARTS_MOST);
	parts += parts % 2 == 0;
	const double step = spacing / parts;
	const int64_t at[2] = {motion->to.x, motion->to.y};
	for (int k = 0; k < 2; k++) {
		const int64_t post = (int64_t)floor(body->centre[k] / spacing);
		const double from = (double)soil_body_from_post(at[k], post, spacing) + motion->beyond[k];
		/* Cells of posts below the mesh during its motion, and one more on each side. */
		const double way = k == 0 ? body->axis[0] * body->way[0] - body->axis[1] * body->way[1] : body->axis[1] * body->way[0] + body->axis[0] * body->way[1];
		const int64_t low = (int64_t)floor((from - fmax(way, 0) - extent[k]) / spacing + 0.5) - 1;
		const int64_t high = (int64_t)floor((from - fmin(way, 0) + extent[k]) / spacing + 0.5) + 1;
		fine->cells[k] = (int32_t)(high - low + 1);
		first[k] = (double)low * spacing - (0.5 * (parts - 1)) * step - from;
		centre[k] = -first[k] / step;
	}
	fine->parts = parts;
	fine->columns = fine->cells[0] * parts;
	fine->rows = fine->cells[1] * parts;
	fine->stride = (fine->columns + 15) / 16 * 16;
	fine->east = 1;
	fine->x = (float)first[0];
	fine->y = (float)first[1];
	fine->step = (float)step;
	fine->by_step = (float)(1 / step);
	fine->axis[0] = (float)body->axis[0];
	fine->axis[1] = (float)body->axis[1];
	const double reach = fabs(body->axis[1]) * extent[0] + fabs(body->axis[0]) * extent[1];
	fine->aside = (float)(-reach - step);
	fine->sides[0] = FINE_NONE;
	fine->sides[1] = -FINE_NONE;
	fine->strips = (int32_t)ceil(2 * reach / step) + 3;
}

/* --- a mesh that turns --- */

/* Puts the vertices where they were `share` of the motion ago. own: the object's axes at the end; at: the place of its centre. */
static void place_earlier(const struct soil_fine_work *work, const struct soil_form *form, const double own[3][3], const double at[2], double share, float *lift)
{
	const struct soil_fine *fine = &form->fine;
	const double c = (double)fine->axis[0], s = (double)fine->axis[1], by = (double)fine->by_step;
	const double spin[3] = {c * (double)form->spin[0] - s * (double)form->spin[1], s * (double)form->spin[0] + c * (double)form->spin[1], (double)form->spin[2]};
	const double way[2] = {c * (double)form->way[0] - s * (double)form->way[1], s * (double)form->way[0] + c * (double)form->way[1]};
	const double angle = sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]), back = -share * angle, by_angle = 1 / fmax(angle, 1e-12);
	const double n[3] = {spin[0] * by_angle, spin[1] * by_angle, spin[2] * by_angle}, cosine = cos(back), sine = sin(back);
	float axes[3][3];
	for (int i = 0; i < 3; i++) {
		const double *a = own[i], along = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
		const double crossed[3] = {n[1] * a[2] - n[2] * a[1], n[2] * a[0] - n[0] * a[2], n[0] * a[1] - n[1] * a[0]};
		for (int k = 0; k < 3; k++)
			axes[i][k] = (float)((a[k] * cosine + crossed[k] * sine + n[k] * along * (1 - cosine)) * (k < 2 ? by : 1));
	}
	const float centre[2] = {(float)(at[0] - share * way[0] * by), (float)(at[1] - share * way[1] * by)};
	place(work->surface, (const float(*)[3])axes, centre, work->earlier_u, work->earlier_v, work->earlier_z);
	*lift = (float)(-share * (double)form->way[2]);
}

/* Returns true if the lower envelope of a mesh changes as the mesh turns about its centre. */
static bool changes(const struct soil_fine_work *work, const struct soil_form *form, const double own[3][3], const double at[2])
{
	const struct soil_fine *fine = &form->fine;
	const float *spin = form->spin, limit = FINE_ROUND * form->reach;
	struct soil_form still = *form;
	float lift;
	if (!((fabsf(spin[0]) + fabsf(spin[1]) + fabsf(spin[2])) * form->radius > limit))
		return false;
	still.way[0] = still.way[1] = still.way[2] = 0;
	place_earlier(work, &still, own, at, 0.381966, &lift);
	for (size_t i = 0; i < work->surface->vertex_count; i++) {
		const float u = clamped(work->earlier_u[i], 0, (float)fine->columns - 1.001f), v = clamped(work->earlier_v[i], 0, (float)fine->rows - 1.001f);
		const size_t from = (size_t)v * (size_t)fine->stride + (size_t)u;
		const float *h = work->heights + from, p = u - floorf(u), q = v - floorf(v), low = h[0] + p * (h[1] - h[0]), high = h[fine->stride] + p * (h[fine->stride + 1] - h[fine->stride]);
		if (work->earlier_z[i] < low + q * (high - low) - limit && work->earlier_z[i] < -0.95f * form->reach)
			return true;
	}
	return false;
}

SOIL_CLONED static void merge(const float *restrict drawn, size_t count, float lift, float share, float *restrict swept, float *restrict since)
{
	for (size_t i = 0; i < count; i++) {
		const float height = drawn[i] + lift;
		since[i] = either(height < swept[i], share, since[i]);
		swept[i] = least(swept[i], height);
	}
}

static void keep_posts(const struct soil_fine_work *work, const struct soil_fine *fine, float lift, float *earlier)
{
	for (int32_t y = 0; y < fine->cells[1]; y++)
		for (int32_t x = 0; x < fine->cells[0]; x++) {
			const float height = work->less[(y * fine->parts + fine->parts / 2) * fine->stride + x * fine->parts + fine->parts / 2];
			earlier[y * fine->cells[0] + x] = height < 0.5f * FINE_NONE ? height + lift : FINE_NONE;
		}
}

/* Draws the mesh in its earlier attitudes. */
static void swept_turning(const struct soil_fine_work *work, struct soil_form *form, const double own[3][3], const double at[2])
{
	struct soil_fine *fine = &form->fine;
	const float *spin = form->spin, angle = sqrtf(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]), run = form->passes[0];
	const float before = fabsf(form->way[2]) <= run ? least(form->half_across / run, 1) : 0;
	const int32_t own_count = 2 * (int32_t)clamped(ceilf(0.5f * angle / FINE_TURNS), 1, FINE_ATTITUDES / 2), all = own_count + (int32_t)ceilf(before * (float)own_count);
	const size_t count = (size_t)fine->stride * (size_t)fine->rows;
	memcpy(work->swept, work->any_wall ? work->walls : work->drawn, count * sizeof *work->swept);
	memset(work->since, 0, count * sizeof *work->since);
	for (int32_t i = 1; i <= all; i++) {
		const float share = least((float)i / (float)own_count, 1 + before);
		float lift;
		place_earlier(work, form, own, at, (double)share, &lift);
		for (size_t k = 0; k < count; k++)
			work->less[k] = FINE_NONE;
		put_looks(work->surface, work->earlier_u, work->earlier_v, work->looks);
		soil_fine_mark(work);
		draw_all(work->surface, work->earlier_u, work->earlier_v, work->earlier_z, (const int32_t[2]){fine->columns, fine->rows}, fine->stride, work->looks, FINE_SOLE, work->less);
		if (work->any_wall)
			draw_all(work->surface, work->earlier_u, work->earlier_v, work->earlier_z, (const int32_t[2]){fine->columns, fine->rows}, fine->stride, work->looks, FINE_SIDE, work->less);
		merge(work->less, count, lift, share, work->swept, work->since);
		if (2 * i == own_count || i == own_count)
			keep_posts(work, fine, lift, work->earlier[i == own_count]);
		if (i == own_count)
			soil_fine_passed(work, fine);
	}
	soil_fine_less(work, fine);
	fine->earlier[0] = work->earlier[0];
	fine->earlier[1] = work->earlier[1];
}

/* Draws the rim of an even drum round. So its facets, which are narrower than posts, leave no pattern in the soil. */
SOIL_CLONED static void round_off(const struct soil_fine *restrict fine, const float axis[restrict 3], float radius, float *restrict drawn)
{
	const float level = sqrtf(axis[0] * axis[0] + axis[1] * axis[1]), by_level = 1 / level, along[2] = {axis[0] * by_level, axis[1] * by_level}, far = 0.9f * radius;
	for (int32_t row = 0; row < fine->rows; row++) {
		float *restrict places = drawn + (size_t)row * (size_t)fine->stride;
		const float north = fine->y + (float)row * fine->step;
		for (int32_t i = 0; i < fine->columns; i++) {
			const float east = fine->x + (float)i * fine->step, across = along[0] * north - along[1] * east, on = along[0] * east + along[1] * north;
			const float height = (axis[2] * on - sqrtf(most(radius * radius - across * across, 0))) * by_level;
			places[i] = either((places[i] < 0.5f * FINE_NONE) & (fabsf(across) < far), height, places[i]);
		}
	}
}

/* Returns true if a body turns but little beside its turning about the axis of an even drum. */
static bool turns_evenly(const struct soil_surface *surface, const struct soil_body *body, const struct soil_form *form, const double own[3][3])
{
	double axis[3], about;
	if (!surface->even)
		return false;
	for (int k = 0; k < 3; k++)
		axis[k] = surface->axis[0] * own[0][k] + surface->axis[1] * own[1][k] + surface->axis[2] * own[2][k];
	const double turned[3] = {body->axis[0] * axis[0] + body->axis[1] * axis[1], body->axis[0] * axis[1] - body->axis[1] * axis[0], axis[2]};
	about = turned[0] * (double)form->spin[0] + turned[1] * (double)form->spin[1] + turned[2] * (double)form->spin[2];
	double rest = 0;
	for (int k = 0; k < 3; k++)
		rest += fabs((double)form->spin[k] - about * turned[k]);
	return rest * (double)form->radius <= (double)(FINE_ROUND * form->reach);
}

static void swept(const struct soil_body *body, const struct soil_fine_work *work, struct soil_form *form, const double own[3][3], const double at[2])
{
	form->fine.earlier[0] = form->fine.earlier[1] = NULL;
	if (form->passes[0] > 0 && !turns_evenly(work->surface, body, form, own) && changes(work, form, own, at))
		swept_turning(work, form, own, at);
	else
		soil_fine_swept(work, form, &form->fine);
}

/* Draws what bears and the walls. */
static void draw_walls(const struct soil_fine_work *work, struct soil_fine *fine)
{
	const size_t places = (size_t)fine->stride * (size_t)fine->rows;
	fine->walls = NULL;
	if (!work->any_wall)
		return;
	memcpy(work->walls, work->drawn, places * sizeof *work->walls);
	draw_all(work->surface, work->u, work->v, work->z, (const int32_t[2]){fine->columns, fine->rows}, fine->stride, work->looks, FINE_SIDE, work->walls);
	fine->walls = work->walls;
}

enum status soil_fine_draw(const struct soil_body *body, struct soil_form *form, struct soil_fine_work *work)
{
	struct soil_fine *fine = &form->fine;
	const struct soil_pose *to = &body->motion->to;
	double at[2], own[3][3], extent[2];
	float axes[3][3], bounds[3][2];
	TRY(soil_surface_of(&work->surfaces, body->motion->shape->mesh, &work->surface));
	const struct soil_surface *surface = work->surface;
	soil_axes(to->yaw, to->pitch, to->roll, 0, own);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			axes[i][k] = (float)own[i][k];
	place(surface, (const float(*)[3])axes, (const float[2]){0, 0}, surface->turned[0], surface->turned[1], surface->turned[2]);
	for (int k = 0; k < 3; k++)
		bounds_of(surface->turned[k], surface->vertex_count, bounds[k]);
	for (int k = 0; k < 2; k++)
		extent[k] = (double)most(-bounds[k][0], bounds[k][1]);
	lay_out(body, form, extent, fine, at);
	TRY(need(work, fine, surface->vertex_count, surface->triangle_count));
	put_places(surface, (const float[2]){(float)at[0], (float)at[1]}, fine->by_step, work->u, work->v, work->z);
	const size_t places = (size_t)fine->stride * (size_t)fine->rows;
	for (size_t i = 0; i < places; i++)
		work->drawn[i] = FINE_NONE;
	const int32_t size[2] = {fine->columns, fine->rows};
	put_looks(surface, work->u, work->v, work->looks);
	soil_fine_walls(work, (const double(*)[3])own);
	draw_all(surface, work->u, work->v, work->z, size, fine->stride, work->looks, FINE_SOLE, work->drawn);
	if (surface->even) {
		float axis[3];
		for (int k = 0; k < 3; k++)
			axis[k] = (float)(surface->axis[0] * own[0][k] + surface->axis[1] * own[1][k] + surface->axis[2] * own[2][k]);
		if (fabsf(axis[2]) <= (float)FORM_LEANS_MOST)
			round_off(fine, axis, (float)surface->mean, work->drawn);
	}
	soil_fine_outline(work, fine);
	soil_fine_brims(work, fine);
	draw_walls(work, fine);
	soil_fine_beside(work, fine, most(fabsf(bounds[2][0]), fabsf(bounds[2][1])));
	swept(body, work, form, (const double(*)[3])own, at);
	fine->heights = work->heights;
	fine->drawn = work->drawn;
	fine->areas = work->areas;
	fine->middles[0] = work->middles[0];
	fine->middles[1] = work->middles[1];
	fine->lows = work->lows;
	soil_fine_lows(work, fine);
	fine->front = work->front;
	fine->rear = work->rear;
	return STATUS_OK;
}
