/*
 * Draws the moving faces of a wheel's bars over posts, in doubles. Each post keeps the lowest height. facets.c draws the same in whole numbers.
 *
 * A post that is back in a triangle's motion by a share of it sees the triangle there. So the shares at which a post is below the triangle are those
 * of a segment, cut by the triangle's three edges. Along it the height is linear: it is lowest at an end.
 */
#include "soil/law/grousers.h"

#include "soil/shape/bars.h"
#include "soil/shape/body.h"

#define BESIDE 1e-9     /* m: a post that lies beside an edge by less is below both triangles of the edge */
#define STEEPEST 4096.0 /* a steeper triangle counts as upright: the triangles beside it have its edges */

/* Posts that are drawn. */
struct drawing {
	float *rests, *lowest;
	double spacing, corner[2]; /* of the first post from the centre, m */
	int32_t sizes[2];
};

/* A triangle at the end of its motion, m from the body's centre. */
struct moving {
	double edges[3][3]; /* above 0 inside: edge[0] + edge[1] x + edge[2] y, m */
	double plane[3];    /* the height, as a sum like those of the edges, m */
	double low, high;   /* m: of its vertices. No height is beyond these */
	double way[3];
	bool resting;
};

/* Returns false if the triangle has no area from above. */
static bool moving_of(const double at[3][3], const double way[3], bool resting, struct moving *m)
{
	const double px = at[1][0] - at[0][0], py = at[1][1] - at[0][1], qx = at[2][0] - at[0][0], qy = at[2][1] - at[0][1];
	const double area = px * qy - py * qx, sign = area < 0 ? -1 : 1;
	if (!(fabs(area) > 0))
		return false;
	for (int k = 0; k < 3; k++) {
		const double *a = at[k], *b = at[(k + 1) % 3], x = b[0] - a[0], y = b[1] - a[1], by = sign / sqrt(fmax(x * x + y * y, 1e-30));
		m->edges[k][1] = -y * by;
		m->edges[k][2] = x * by;
		m->edges[k][0] = -m->edges[k][1] * a[0] - m->edges[k][2] * a[1];
		m->way[k] = way[k];
	}
	const double pz = at[1][2] - at[0][2], qz = at[2][2] - at[0][2];
	m->plane[1] = (pz * qy - qz * py) / area;
	m->plane[2] = (qz * px - pz * qx) / area;
	if (!(fmax(fabs(m->plane[1]), fabs(m->plane[2])) < STEEPEST))
		return false;
	m->low = fmin(at[0][2], fmin(at[1][2], at[2][2]));
	m->high = fmax(at[0][2], fmax(at[1][2], at[2][2]));
	m->plane[0] = at[0][2] - m->plane[1] * at[0][0] - m->plane[2] * at[0][1];
	m->resting = resting;
	return true;
}

/* Of numbers, in a line of code: fmin and fmax are calls. */
static double smaller(double a, double b)
{
	return a < b ? a : b;
}

static double larger(double a, double b)
{
	return a > b ? a : b;
}

static double along(const double f[3], double x, double y)
{
	return f[0] + f[1] * x + f[2] * y;
}

static double height_of(const struct moving *m, double x, double y)
{
	return smaller(larger(along(m->plane, x, y), m->low), m->high);
}

/* Gives the shares of the motion, back from its end, at which the triangle is above a place. Returns false if there are none. */
static bool shares_of(const struct moving *m, double x, double y, double shares[2])
{
	shares[0] = 0;
	shares[1] = 1;
	for (int k = 0; k < 3; k++) {
		const double *edge = m->edges[k], inside = along(edge, x, y) + BESIDE, grows = edge[1] * m->way[0] + edge[2] * m->way[1];
		if (grows > 0)
			shares[0] = larger(shares[0], -inside / grows);
		else if (grows < 0)
			shares[1] = smaller(shares[1], -inside / grows);
		else if (inside < 0)
			return false;
	}
	return shares[0] <= shares[1];
}

static void draw_at(const struct drawing *d, const struct moving *m, int32_t column, int32_t row)
{
	const double x = d->corner[0] + column * d->spacing, y = d->corner[1] + row * d->spacing;
	const size_t at = (size_t)row * (size_t)d->sizes[0] + (size_t)column;
	double shares[2];
	if (!shares_of(m, x, y, shares))
		return;
	for (int k = 0; k < 2; k++) {
		const double z = height_of(m, x + shares[k] * m->way[0], y + shares[k] * m->way[1]) - shares[k] * m->way[2];
		d->lowest[at] = least(d->lowest[at], (float)z);
	}
	if (m->resting && shares[0] <= 0)
		d->rests[at] = least(d->rests[at], (float)height_of(m, x, y));
}

static int32_t post_from(const struct drawing *d, double place, int axis)
{
	return (int32_t)fmin(fmax(ceil((place - d->corner[axis]) / d->spacing), 0), (double)d->sizes[axis]);
}

static void draw(const struct drawing *d, const double at[3][3], const double way[3], bool resting)
{
	struct moving m;
	if (!moving_of(at, way, resting, &m))
		return;
	int32_t from[2], to[2];
	for (int k = 0; k < 2; k++) {
		from[k] = post_from(d, fmin(at[0][k], fmin(at[1][k], at[2][k])) - fmax(way[k], 0) - BESIDE, k);
		to[k] = post_from(d, fmax(at[0][k], fmax(at[1][k], at[2][k])) - fmin(way[k], 0) + BESIDE, k);
	}
	for (int32_t row = from[1]; row < to[1]; row++)
		for (int32_t column = from[0]; column < to[0]; column++)
			draw_at(d, &m, column, row);
}

static void draw_face(void *user, const struct bar_face *face)
{
	const double way[3] = {face->to[0] - face->from[0], face->to[1] - face->from[1], face->to[2] - face->from[2]};
	double at[3][3];
	for (int i = 0; i < 2; i++) {
		for (int k = 0; k < 3; k++) {
			at[0][k] = face->at[0][k];
			at[1][k] = face->at[1 + i][k];
			at[2][k] = face->at[2 + i][k];
		}
		draw(user, (const double(*)[3])at, way, face->resting);
	}
}

enum status soil_grousers_draw(const struct soil_body *body, const struct post_rect *below, struct soil_form *form, struct soil_grousers_work *work)
{
	const struct soil_motion *motion = body->motion;
	const double *axis = body->axis, spacing = (double)form->spacing;
	const size_t count = (size_t)(below->x1 - below->x0) * (size_t)(below->y1 - below->y0);
	if (2 * count > work->room) {
		TRY(mem_resize(&work->memory, 3 * count, sizeof *work->memory, "grousers"));
		work->room = 3 * count;
	}
	struct drawing d = {
		.rests = work->memory, .lowest = work->memory + count, .spacing = spacing,
		.corner = {-(double)soil_body_from_post(motion->to.x, below->x0, spacing) - motion->beyond[0],
			   -(double)soil_body_from_post(motion->to.y, below->y0, spacing) - motion->beyond[1]},
		.sizes = {(int32_t)(below->x1 - below->x0), (int32_t)(below->y1 - below->y0)},
	};
	for (size_t i = 0; i < 2 * count; i++)
		work->memory[i] = FINE_NONE;
	const double way[3] = {axis[0] * body->way[0] - axis[1] * body->way[1], axis[1] * body->way[0] + axis[0] * body->way[1], body->way[2]};
	const bool moves = way[0] != 0 || way[1] != 0 || way[2] != 0;
	const struct bars_motion bars = {.x = -way[0], .y = -way[1], .dx = way[0], .dy = way[1], .z = -way[2], .dz = way[2], .turned = moves ? motion->turned : 0};
	soil_bars(motion->shape, &motion->to, &bars, draw_face, &d);
	form->grousers = (struct soil_grousers){d.rests, d.lowest, d.sizes[0], d.sizes[1], (float)d.corner[0], (float)d.corner[1]};
	return STATUS_OK;
}

void soil_grousers_finish(struct soil_grousers_work *work)
{
	mem_free(work->memory);
	*work = (struct soil_grousers_work){0};
}

void soil_grousers_cover(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts)
{
	const struct soil_grousers *bars = &form->grousers;
	const float c = (float)body->axis[0], s = (float)body->axis[1], by = 1 / form->spacing;
	for (size_t i = 0; i < posts->count; i++) {
		const float x = posts->x[i], y = posts->y[i], height = posts->height[i];
		const int32_t column = whole_of((c * x - s * y - bars->x) * by), row = whole_of((s * x + c * y - bars->y) * by);
		if (column < 0 || row < 0 || column >= bars->columns || row >= bars->rows || posts->base[i] == BASE_NODATA)
			continue;
		const size_t at = (size_t)row * (size_t)bars->columns + (size_t)column;
		if (form->all_round > 0) { /* a drum counts for them, and they leave their prints */
			posts->bars[i] = bars->lowest[at];
			continue;
		}
		const float rests = bars->rests[at], passed = bars->lowest[at], rim = posts->swept[i] > 0 || posts->over[i] > 0 ? height - posts->lowered[i] : FINE_NONE;
		if (rests < 0.5f * FINE_NONE) {
			posts->above[i] = least(rests - height, 0);
			posts->over[i] = 1;
		}
		if (passed < 0.5f * FINE_NONE)
			posts->swept[i] = 1;
		if (posts->swept[i] > 0)
			posts->lowered[i] = most(height + posts->above[i] - least(rim, passed), 0);
	}
}
