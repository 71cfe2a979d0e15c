/* Adds up what the facets of a body push at a height. */
#include "soil/faces/ahead.h"
#include "soil/faces/footing.h"
#include "soil/faces/push.h"
#include "soil/shape/body.h"

#define LANES POSTS_LANES
#define EACH_LANE for (int i = 0; i < LANES; i++)

#define WALL 0.19185f  /* alpha of an upright wall that moves level along its normal, across it */
#define PLATE 0.87574f /* alpha of a level plate that moves straight down */
#define NARROW 3.0f    /* a body is narrow if it is less wide than so many times its depth. The law of faces was fitted to narrow plates; a wide one has a plane wedge */
#define PRANDTL 5.14f  /* 2 + pi: bearing capacity of a level plate over cohesion */

/* Where facets look up the ground. */
struct look {
	float axis[2], x, y, by;  /* of the frame; the first post from the centre, m east and north; posts for each m */
	float columns, rows;
	int32_t stride, east;     /* `east` is 1: gcc's gathers need a variable */
};

static struct look look_of(const struct soil_body *body, const struct soil_form *form, const struct soil_faces *faces)
{
	const struct soil_motion *motion = body->motion;
	const double spacing = (double)form->spacing;
	const int32_t columns = (int32_t)(faces->rect.x1 - faces->rect.x0), rows = (int32_t)(faces->rect.y1 - faces->rect.y0);
	return (struct look){
		.axis = {(float)body->axis[0], (float)body->axis[1]}, .by = 1 / form->spacing,
		.x = -(float)((double)soil_body_from_post(motion->to.x, faces->rect.x0, spacing) + motion->beyond[0]),
		.y = -(float)((double)soil_body_from_post(motion->to.y, faces->rect.y0, spacing) + motion->beyond[1]),
		.columns = (float)columns - 1.001f, .rows = (float)rows - 1.001f, .stride = columns, .east = 1,
	};
}

/* A place between four posts. */
struct spot {
	int32_t at;
	float p, q;
};

SOIL_INLINED struct spot spot_at(const struct look *look, float x, float y)
{
	const float east = (look->axis[0] * x - look->axis[1] * y - look->x) * look->by, north = (look->axis[1] * x + look->axis[0] * y - look->y) * look->by;
	const float u = clamped(east, 0, look->columns), v = clamped(north, 0, look->rows);
	const int32_t column = (int32_t)u, row = (int32_t)v;
	return (struct spot){row * look->stride + column, u - (float)column, v - (float)row};
}

SOIL_INLINED float value_at(const struct look *look, const float *plane, const struct spot *s)
{
	const float a = plane[s->at], b = plane[s->at + look->east], c = plane[s->at + look->stride], d = plane[s->at + look->stride + look->east];
	const float low = a + s->p * (b - a), high = c + s->p * (d - c);
	return low + s->q * (high - low);
}

/* Returns the ground from which a facet counts its depth, m above the centre at motion->to. */
SOIL_INLINED float ground_at(const struct look *look, const struct soil_faces *faces, float x, float y, float faces_way)
{
	const struct spot spot = spot_at(look, x, y);
	const float under = value_at(look, faces->under_from, &spot), ahead = value_at(look, faces->ahead, &spot);
	return under + faces_way * (ahead - under);
}

/* Returns how that grows with depth, 1/m. in: the share. */
SOIL_INLINED float sinks_in(float in, float tall, float size)
{
	return either(in > 0, either(in < 1, 1 / most(2 * tall, size), 0), 0);
}

/* Finds how deep the middles of the facets of a block are. `deep` is below the ground that pushes them, `found` below it as the body finds it. Adds to what tells where the body
 * is in soil, across its way: sums of area, and of area times place. */
SOIL_CLONED static void find_depths(const struct soil_faces *restrict faces, size_t b, const struct look *restrict look, float raised, float size, const float across[restrict 2],
				    float *restrict deep, float *restrict found, float *restrict heap, float sums[restrict 2][LANES])
{
	EACH_LANE {
		const size_t n = b + (size_t)i;
		const struct spot spot = spot_at(look, faces->x[n], faces->y[n]);
		const float depth = ground_at(look, faces, faces->x[n], faces->y[n], faces->faces_way[n]) - faces->z[n] - raised;
		const float aside = faces->x[n] * across[0] + faces->y[n] * across[1], in = faces->whole[n] * soil_facet_in(depth, faces->tall[n], size);
		deep[n] = depth;
		found[n] = value_at(look, faces->found, &spot) - faces->z[n] - raised;
		heap[n] = value_at(look, faces->heap_ahead, &spot);
		sums[0][i] += in;
		sums[1][i] += in * aside;
	}
}

/* What holds for all facets of a body at a height. */
struct pushing {
	float xi, weight, cohesion; /* N/m3, N/m3, Pa */
	float narrow;               /* 1: the body is narrow, 0: it is wide */
	float size;                 /* m: of a facet */
	float upright;              /* weight of the wedge ahead of an upright wall */
};

/* Finds what soil pushes on the facets of a block for each unit of alpha, Pa, and how that grows with depth. The depth is a mean over the facet, so a facet that comes
 * out of the soil loses its force evenly. */
SOIL_CLONED static void find_pressures(const struct soil_faces *restrict faces, size_t b, const struct pushing *restrict p, float *restrict pressure, float *restrict steepens)
{
	EACH_LANE {
		const size_t n = b + (size_t)i;
		const float deep = faces->deep[n], tall = faces->tall[n], weight = faces->weight[n], cohesive = faces->cohesive[n], sole = faces->sole[n];
		const float in = soil_facet_in(deep, tall, p->size), sinks = sinks_in(in, tall, p->size);
		const float top = clamped(deep + tall, 0, 2 * tall), by_tall = 1 / most(4 * tall, 1e-9f);
		const float depth = top * top * by_tall + most(deep - tall, 0), deepens = most(2 * top * by_tall, deep > tall ? 1.0f : 0.0f);
		const float by_weight = p->weight * weight * (1 / WALL), heap = (1 - p->narrow) * faces->heap[n], fitted = p->narrow * weight / p->upright;
		const float plain = p->xi * depth, wide = by_weight * (depth + heap * in), mixed = fitted * plain + (1 - p->narrow) * wide, held = PRANDTL / PLATE * p->cohesion;
		const float cohesion = p->cohesion * cohesive * (1 / WALL), wedge = wide + cohesion * in, widens = by_weight * (deepens + heap * sinks);
		const float wall = most(mixed, wedge), floor = most(plain, held * in);
		steepens[n] = sole * either(plain > held * in, p->xi * deepens, held * sinks) +
			     (1 - sole) * either(mixed > wedge, fitted * p->xi * deepens + (1 - p->narrow) * widens, widens + cohesion * sinks);
		pressure[n] = sole * floor + (1 - sole) * wall;
	}
}

/* Forces and moments of a block, whole numbers, and for the search how the vertical force grows. */
struct facet_sums {
	int32_t force[3][LANES], moment[3][LANES], pull[LANES], saturated[LANES];
	float grows[LANES];
};

/* unit: of the sums, for each newton; by_arm: of moments. */
SOIL_CLONED static void add_block(const struct soil_form *restrict f, const struct soil_faces *restrict faces, size_t b, float unit, struct facet_sums *restrict sums)
{
	EACH_LANE {
		const size_t n = b + (size_t)i;
		float moment[3], belt[3], large = 0;
		const float in = soil_facet_in(faces->deep[n], faces->tall[n], f->spacing), thrown = unit * faces->thrown[n] * in, by = unit * faces->pressure[n];
		const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
		const float force[3] = {by * faces->px[n] - thrown * normal[0], by * faces->py[n] - thrown * normal[1], by * faces->pz[n] - thrown * normal[2]};
		cross3(at, force, moment);
		cross3(f->belt, normal, belt);
		for (int k = 0; k < 3; k++) {
			const float turns = moment[k] * f->by_arm;
			large = most(large, most(fabsf(force[k]), fabsf(turns)));
			sums->force[k][i] = whole_of(clamped(force[k], -BEAR_MOST, BEAR_MOST));
			sums->moment[k][i] = whole_of(clamped(turns, -BEAR_MOST, BEAR_MOST));
		}
		sums->pull[i] = whole_of(clamped(-dot3(force, belt), -BEAR_MOST, BEAR_MOST));
		sums->saturated[i] = large > BEAR_MOST ? 1 : 0;
		const float more = unit * faces->thrown[n] * sinks_in(in, faces->tall[n], f->spacing) * normal[2];
		sums->grows[i] = faces->steepens[n] * unit * faces->pz[n] - more;
	}
}

/* Returns how far the surface rises at a place for each m, in the frame. */
static void slope_at(const struct look *look, const struct soil_faces *faces, size_t n, float spacing, float slope[2])
{
	const float by = 0.5f / spacing, x = faces->x[n], y = faces->y[n], way = faces->faces_way[n];
	slope[0] = (ground_at(look, faces, x + spacing, y, way) - ground_at(look, faces, x - spacing, y, way)) * by;
	slope[1] = (ground_at(look, faces, x, y + spacing, way) - ground_at(look, faces, x, y - spacing, way)) * by;
}

/* Adds how the force at a place changes with its motion. A place moves as the centre does, and as the body turns across the arm. */
static void add_placed(const float at[3], const float place[3][3], struct soil_matrix *changes)
{
	for (int k = 0; k < 3; k++) {
		double row[6];
		const double a[3] = {(double)place[k][0], (double)place[k][1], (double)place[k][2]}, r[3] = {(double)at[0], (double)at[1], (double)at[2]};
		for (int j = 0; j < 3; j++) {
			row[j] = a[j];
			row[3 + j] = r[(j + 1) % 3] * a[(j + 2) % 3] - r[(j + 2) % 3] * a[(j + 1) % 3];
		}
		for (int j = 0; j < 6; j++) {
			changes->at[k][j] += row[j];
			changes->at[3 + (k + 1) % 3][j] += r[(k + 2) % 3] * row[j];
			changes->at[3 + (k + 2) % 3][j] -= r[(k + 1) % 3] * row[j];
		}
	}
}

/* Adds how the force of a facet changes: with its depth, with the recent motion of its place, and with its speed. bends: of soil_push_changes, of its block. */
static void add_changes(const struct soil_form *f, const struct soil_faces *faces, size_t n, const float bends[3][3][LANES], const struct look *look, struct soil_changes *changes)
{
	const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, push[3] = {faces->px[n], faces->py[n], faces->pz[n]};
	const float pressure = faces->pressure[n], grows = faces->steepens[n];
	float slope[2], place[3][3];
	slope_at(look, faces, n, f->spacing, slope);
	const float deeper[3] = {slope[0], slope[1], -1}, in = soil_facet_in(faces->deep[n], faces->tall[n], f->spacing), thrown = faces->thrown[n] * in;
	const float more = faces->thrown[n] * sinks_in(in, faces->tall[n], f->spacing), slows = either(faces->into[n] > 0, 2 * thrown / most(faces->into[n], 1e-12f), 0);
	const float normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
	float rates[3][3];
	for (int k = 0; k < 3; k++)
		for (int j = 0; j < 3; j++) {
			place[k][j] = (grows * push[k] - more * normal[k]) * deeper[j] + pressure * bends[k][j][n % LANES];
			rates[k][j] = -slows * normal[k] * normal[j];
		}
	add_placed(at, (const float(*)[3])place, &changes->stiffness);
	if (slows > 0)
		add_placed(at, (const float(*)[3])rates, &changes->damping);
	const double force[3] = {(double)(pressure * push[0]), (double)(pressure * push[1]), (double)(pressure * push[2])};
	const double across = force[0] * (double)normal[0] + force[1] * (double)normal[1] + force[2] * (double)normal[2];
	changes->normal_force += fabs(across) + (double)thrown;
	changes->shear_limit += (double)faces->tangent * fabs(across);
	for (int k = 0; k < 3; k++)
		changes->sheared[k] += force[k] - across * (double)normal[k];
}

static int64_t total(const int32_t lanes[LANES])
{
	int64_t sum = 0;
	for (int i = 0; i < LANES; i++)
		sum += lanes[i];
	return sum;
}

/* Adds how the forces of the facets of a block that are in soil change. */
static void add_block_changes(const struct soil_form *f, const struct soil_faces *faces, size_t b, const struct look *look, struct soil_changes *changes)
{
	float bends[3][3][LANES];
	bool any = false;
	for (size_t i = 0; i < LANES; i++) {
		if (!(faces->deep[b + i] + faces->tall[b + i] > 0))
			continue;
		if (!any)
			soil_push_changes(f, faces, b, faces->by_modulus, bends);
		any = true;
		add_changes(f, faces, b + i, (const float(*)[3][LANES])bends, look, changes);
	}
}

/* Finds depths, and from them how narrow the body is. */
static struct pushing pushing_of(const struct soil_body *body, const struct soil_form *form, const struct look *look, float raised, struct soil_faces *faces)
{
	float way[2];
	soil_faces_way(body, faces, way);
	const float across[2] = {-way[1], way[0]};
	float sums[2][LANES] = {{0}}, deepest = 0, all[2] = {0}, left = 0, right = 0;
	for (size_t b = 0; b < faces->count; b += LANES)
		find_depths(faces, b, look, raised, form->spacing, across, faces->deep, faces->found_deep, faces->heap, sums);
	for (int k = 0; k < 2; k++)
		for (int i = 0; i < LANES; i++)
			all[k] += sums[k][i];
	/* A facet counts for the width as far as it is in soil, so the width changes evenly as the body sinks. */
	const float middle = all[1] / most(all[0], 1e-12f);
	for (size_t n = 0; n < faces->count; n++) {
		const float in = either(faces->whole[n] > 0, soil_facet_in(faces->deep[n], faces->tall[n], form->spacing), 0);
		const float aside = faces->x[n] * across[0] + faces->y[n] * across[1] - middle, half = 0.5f * sqrtf(faces->whole[n]);
		deepest = most(deepest, either(in > 0, faces->found_deep[n] + faces->tall[n], 0));
		left = most(left, in * (aside + half));
		right = most(right, in * (half - aside));
	}
	const float width = left + right;
	const float share = width / (NARROW * most(deepest, 1e-6f)), narrow = 1 / (1 + share * share * share * share);
	return (struct pushing){faces->xi, faces->unit_weight, faces->cohesion, narrow, form->spacing, faces->wedge.weight[WEDGE_RAKES - 1]};
}

/* Tells whether a facet of a block is in soil. */
static bool is_in_soil(const struct soil_faces *faces, size_t b)
{
	bool any = false;
	for (size_t i = 0; i < LANES; i++)
		any |= faces->deep[b + i] + faces->tall[b + i] > 0;
	return any;
}

void soil_faces_look(const struct soil_planes *planes, const struct soil_body *body, struct soil_form *form, struct soil_posts *posts, int32_t raised, struct soil_faces *faces)
{
	const float up = (float)raised * SOIL_UNIT + form->beyond;
	if (faces->count == 0)
		return;
	const struct look look = look_of(body, form, faces);
	const struct spot centre = spot_at(&look, 0, 0);
	const float deep = most(value_at(&look, faces->found, &centre) + form->reach - up, 0);
	soil_ahead_put(planes, body, form, posts, up, deep * faces->wedge_length, faces);
	const struct pushing pushing = pushing_of(body, form, &look, up + form->scooped, faces); /* what bars have taken away does not push */
	for (size_t b = 0; b < faces->count; b += LANES) {
		if (is_in_soil(faces, b))
			soil_push_forces(form, faces, b);
		find_pressures(faces, b, &pushing, faces->pressure, faces->steepens);
	}
	if (!soil_footing_is(form))
		return;
	float way[2];
	soil_faces_way(body, faces, way);
	form->sole = soil_footing_share(form, faces, way);
}

void soil_faces_add(const struct soil_body *body, const struct soil_form *form, float share, struct soil_faces *faces, struct soil_sums *sums, struct soil_changes *changes)
{
	const float unit = BEAR_UNITS_A_PASCAL / (share * form->spacing * form->spacing);
	struct facet_sums block;
	if (faces->count == 0)
		return;
	const struct look look = look_of(body, form, faces);
	for (size_t b = 0; b < faces->count; b += LANES) {
		add_block(form, faces, b, unit, &block);
		for (int k = 0; k < 3; k++) {
			sums->force[k] += total(block.force[k]);
			sums->moment[k] += total(block.moment[k]);
		}
		sums->pull += total(block.pull);
		sums->saturated += total(block.saturated);
		for (int i = 0; i < LANES && changes == NULL; i++)
			sums->grows += (double)block.grows[i];
		if (changes != NULL)
			add_block_changes(form, faces, b, &look, changes);
	}
}
