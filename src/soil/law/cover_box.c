/* What a tilted box covers of the cells of posts: see cover_box.h. */
#include "soil/law/cover_box.h"

#include "soil/law/parts.h"
#include "soil/law/polygon.h"

#define LEAST_PART 1e-9 /* of a cell */

/* --- the box and the lattice --- */

/* A parallelogram in plan: across . (at - middle) is -1 .. 1 in it, twice. */
struct sole {
	bool is;
	double middle[2], across[2][2], beside[2];
};

struct box {
	struct sole soles[3];
	double corner[2], east[2], north[2], spacing; /* m in the frame: a post of the lattice, and the steps from it to the next ones */
	const struct soil_form *form;
};

static struct sole sole_of(const struct soil_box_sole *s, bool is)
{
	const double a[2][2] = {{(double)s->half[0][0], (double)s->half[0][1]}, {(double)s->half[1][0], (double)s->half[1][1]}}, area = a[0][0] * a[1][1] - a[0][1] * a[1][0];
	struct sole sole = {.is = is && fabs(area) > 1e-18, .middle = {(double)s->middle[0], (double)s->middle[1]}};
	for (int k = 0; k < 2 && sole.is; k++) {
		const double *other = a[1 - k], sign = k == 0 ? 1 : -1;
		sole.across[k][0] = sign * other[1] / area;
		sole.across[k][1] = -sign * other[0] / area;
		sole.beside[k] = 1 + (double)BESIDE * hypot(sole.across[k][0], sole.across[k][1]);
	}
	return sole;
}

static struct box box_of(const struct soil_body *body, const struct soil_form *form, const struct soil_posts *posts)
{
	const double d = (double)form->spacing;
	struct box box = {
		.corner = {(double)posts->x[0], (double)posts->y[0]}, .east = {body->axis[0] * d, -body->axis[1] * d}, .north = {body->axis[1] * d, body->axis[0] * d}, .spacing = d, .form = form,
	};
	for (int k = 0; k < 3; k++)
		box.soles[k] = sole_of(&form->soles[k], form->is_sole[k]);
	return box;
}

static void place_of(const struct box *box, const int64_t post[2], double at[2])
{
	for (int k = 0; k < 2; k++)
		at[k] = box->corner[k] + (double)post[0] * box->east[k] + (double)post[1] * box->north[k];
}

/* Returns below which sole a post lies; -1: below none. */
static int sole_at(const struct box *box, const int64_t post[2])
{
	double at[2];
	place_of(box, post, at);
	for (int k = 0; k < 3; k++) {
		const struct sole *s = &box->soles[k];
		const double x = at[0] - s->middle[0], y = at[1] - s->middle[1];
		if (s->is && fabs(s->across[0][0] * x + s->across[0][1] * y) <= s->beside[0] && fabs(s->across[1][0] * x + s->across[1][1] * y) <= s->beside[1])
			return k;
	}
	return -1;
}

static bool same(const int64_t a[2], const int64_t b[2])
{
	return a[0] == b[0] && a[1] == b[1];
}

/* Gives the posts around a cell, up to `far` posts away, that lie below a sole. Returns how many there are. */
static int posts_around(const struct box *box, const int64_t cell[2], int far, int sole, int64_t posts[25][2])
{
	int count = 0;
	for (int64_t y = cell[1] - far; y <= cell[1] + far; y++)
		for (int64_t x = cell[0] - far; x <= cell[0] + far; x++)
			if (sole_at(box, (const int64_t[2]){x, y}) == sole) {
				posts[count][0] = x;
				posts[count++][1] = y;
			}
	return count;
}

/* The posts that can bear what is in a cell: its own, if that lies below the sole. If not, those beside it that do. If none does, those next to these. */
struct bearers {
	int count;
	int64_t posts[25][2];
};

static struct bearers bearers_of(const struct box *box, const int64_t cell[2], int sole)
{
	struct bearers bearers;
	for (int far = 0; far <= 2; far++) {
		bearers.count = posts_around(box, cell, far, sole, bearers.posts);
		if (bearers.count > 0)
			break;
	}
	return bearers;
}

static bool can_bear(const struct bearers *bearers, const int64_t post[2])
{
	for (int n = 0; n < bearers->count; n++)
		if (same(bearers->posts[n], post))
			return true;
	return false;
}

/* Returns true if a post bears what is at a place: it is the nearest of them. */
static bool bears(const struct box *box, const struct bearers *bearers, const double at[2], const int64_t post[2])
{
	double nearest = 1e9;
	int bearer = 0;
	for (int n = 0; n < bearers->count; n++) {
		double from[2];
		place_of(box, bearers->posts[n], from);
		const double away = hypot(at[0] - from[0], at[1] - from[1]);
		bearer = away < nearest ? n : bearer;
		nearest = fmin(nearest, away);
	}
	return same(bearers->posts[bearer], post);
}

/* Returns what a sole covers of a cell, in plan. */
static struct amounts part_below(const struct box *box, const int64_t cell[2], int sole)
{
	const struct sole *s = &box->soles[sole];
	struct polygon p = {.count = 4};
	double at[2];
	place_of(box, cell, at);
	for (int i = 0; i < 4; i++)
		for (int k = 0; k < 2; k++)
			p.at[i][k] = at[k] - s->middle[k] + (i == 0 || i == 3 ? -0.5 : 0.5) * box->east[k] + (i < 2 ? -0.5 : 0.5) * box->north[k];
	for (int k = 0; k < 2; k++) {
		cut_polygon(s->across[k], 1, &p);
		cut_polygon((const double[2]){-s->across[k][0], -s->across[k][1]}, 1, &p);
	}
	return amounts_of(&p);
}

/* Gives the part of a wall's edge in a cell: its middle. Returns its length. */
static double edge_in(const struct box *box, const int64_t cell[2], const struct soil_box_wall *wall, double middle[2])
{
	const double d2 = box->spacing * box->spacing, half = hypot((double)wall->along[0], (double)wall->along[1]);
	double at[2], from = -1, to = 1;
	place_of(box, cell, at);
	for (int k = 0; k < 2; k++) {
		const double *axis = k == 0 ? box->east : box->north;
		const double begins = (((double)wall->at[0] - at[0]) * axis[0] + ((double)wall->at[1] - at[1]) * axis[1]) / d2, goes = ((double)wall->along[0] * axis[0] + (double)wall->along[1] * axis[1]) / d2;
		if (fabs(goes) < 1e-12) {
			if (begins < -0.5 || begins >= 0.5)
				return 0;
			continue;
		}
		const double a = (-0.5 - begins) / goes, b = (0.5 - begins) / goes;
		from = fmax(from, fmin(a, b));
		to = fmin(to, fmax(a, b));
	}
	for (int k = 0; k < 2; k++)
		middle[k] = (double)wall->at[k] + 0.5 * (from + to) * (double)wall->along[k];
	return to > from ? (to - from) * half : 0;
}

/* --- a post --- */

/* What a post bears: of its sole, moments from the post; of the edges of walls, their length and moments. */
struct borne {
	struct amounts sole;
	double edges[2][3];
};

static void add_cell(const struct box *box, const int64_t post[2], const int64_t cell[2], int sole, struct borne *borne)
{
	const struct sole *s = &box->soles[sole];
	double from[2];
	if (!same(cell, post) && sole_at(box, cell) == sole)
		return;
	const struct bearers bearers = bearers_of(box, cell, sole);
	if (!can_bear(&bearers, post))
		return;
	const struct amounts part = part_below(box, cell, sole);
	place_of(box, post, from);
	if (part.area > LEAST_PART * box->spacing * box->spacing) {
		const double at[2] = {s->middle[0] + part.by[0] / part.area, s->middle[1] + part.by[1] / part.area};
		if (bears(box, &bearers, at, post)) {
			const double x = s->middle[0] - from[0], y = s->middle[1] - from[1], a = part.area, u = part.by[0], v = part.by[1];
			const double moved[5] = {u + a * x, v + a * y, part.by[2] + 2 * x * u + a * x * x, part.by[3] + x * v + y * u + a * x * y, part.by[4] + 2 * y * v + a * y * y};
			borne->sole.area += a;
			for (int k = 0; k < 5; k++)
				borne->sole.by[k] += moved[k];
		}
	}
	for (int w = 0; w < box->form->wall_count; w++) {
		const struct soil_box_wall *wall = &box->form->walls[w];
		double at[2];
		const double length = wall->sole == sole ? edge_in(box, cell, wall, at) : 0;
		if (length > 0 && bears(box, &bearers, at, post)) {
			borne->edges[w][0] += length;
			for (int k = 0; k < 2; k++)
				borne->edges[w][1 + k] += length * at[k];
		}
	}
}

/* Returns true if a post and all around it lie below one sole. */
static bool is_inner(const struct box *box, const int64_t post[2], int sole)
{
	for (int n = 0; n < 9; n++)
		if (sole_at(box, (const int64_t[2]){post[0] + n % 3 - 1, post[1] + n / 3 - 1}) != sole)
			return false;
	return true;
}

/* Puts the part of the sole. It goes over from the part of a level box as the box begins to tilt. */
static void put_sole(const struct soil_form *f, const struct borne *borne, struct soil_posts *p, size_t i)
{
	const double cell = (double)f->spacing * (double)f->spacing, area = borne->sole.area, by = 1 / fmax(area, 1e-30), x = borne->sole.by[0] * by, y = borne->sole.by[1] * by;
	const double part[3] = {area / cell, x, y}, tilts = (double)f->tilts;
	float *const to[3] = {&p->share[i], &p->middle_x[i], &p->middle_y[i]};
	for (int k = 0; k < 3; k++)
		*to[k] = (float)((double)*to[k] + tilts * (part[k] - (double)*to[k]));
	/* The two places at which a line is looked at lie as the part does. */
	const double u = (double)(p->rise_x[i] - p->slope_x[i]), v = (double)(p->rise_y[i] - p->slope_y[i]), squares = u * u + v * v;
	const double spread = (u * u * (borne->sole.by[2] * by - x * x) + 2 * u * v * (borne->sole.by[3] * by - x * y) + v * v * (borne->sole.by[4] * by - y * y)) / fmax(squares, 1e-30);
	const double half = squares >= 1e-8 ? sqrt(fmax(3 * spread, 0)) : (double)f->half_across;
	p->half_line[i] = (float)((double)f->half_across + tilts * (half - (double)f->half_across));
}

static void put_edges(const struct soil_form *f, const struct borne *borne, struct soil_posts *p, size_t i)
{
	float *const to[2][3] = {{&p->edge_long[i], &p->edge_x[i], &p->edge_y[i]}, {&p->other_long[i], &p->other_x[i], &p->other_y[i]}};
	for (int w = 0; w < 2; w++) {
		const double length = borne->edges[w][0];
		*to[w][0] = (float)(length * (double)f->tilts / (double)f->spacing);
		for (int k = 0; k < 2; k++)
			*to[w][1 + k] = (float)(borne->edges[w][1 + k] / fmax(length, 1e-30));
	}
}

void soil_cover_box(const struct soil_body *body, const struct soil_form *form, struct soil_posts *posts)
{
	const struct box box = box_of(body, form, posts);
	const double d2 = box.spacing * box.spacing;
	for (size_t i = 0; i < posts->count; i++) {
		const double x = (double)posts->x[i] - box.corner[0], y = (double)posts->y[i] - box.corner[1];
		const int64_t post[2] = {llround((x * box.east[0] + y * box.east[1]) / d2), llround((x * box.north[0] + y * box.north[1]) / d2)};
		const int sole = sole_at(&box, post);
		struct borne borne = {.sole = {.area = 0}};
		if (posts->base[i] != BASE_NODATA && sole >= 0 && is_inner(&box, post, sole))
			borne.sole = (struct amounts){d2, {0, 0, d2 * d2 / 12, 0, d2 * d2 / 12}};
		else if (posts->base[i] != BASE_NODATA && sole >= 0)
			for (int n = 0; n < 25; n++)
				add_cell(&box, post, (const int64_t[2]){post[0] + n % 5 - 2, post[1] + n / 5 - 2}, sole, &borne);
		posts->own[i] = form->tilts >= 1 && sole >= 0 ? (float)(1 + sole) : 0;
		put_sole(form, &borne, posts, i);
		put_edges(form, &borne, posts, i);
	}
	/* The lanes after the last post. */
	for (size_t i = posts->count; i < soil_posts_end(posts); i++)
		posts->own[i] = posts->share[i] = posts->edge_long[i] = posts->other_long[i] = 0;
}
