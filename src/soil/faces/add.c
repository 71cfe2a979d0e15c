/* Adds up what the facets of a body press at a height. */
#include "soil/faces/ahead.h"
#include "soil/faces/press.h"
#include "soil/shape/body.h"

#define LANES POSTS_LANES
#define EACH_LANE for (int i = 0; i < LANES; i++)

/* Where facets look up the surface. */
struct look {
	const float *ahead;
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
		.ahead = faces->ahead, .axis = {(float)body->axis[0], (float)body->axis[1]}, .by = 1 / form->spacing,
		.x = -(float)((double)soil_body_from_post(motion->to.x, faces->rect.x0, spacing) + motion->beyond[0]),
		.y = -(float)((double)soil_body_from_post(motion->to.y, faces->rect.y0, spacing) + motion->beyond[1]),
		.columns = (float)columns - 1.001f, .rows = (float)rows - 1.001f, .stride = columns, .east = 1,
	};
}

/* Gives the surface at a place of the frame, m above the centre at motion->to. */
SOIL_INLINED float surface_at(const struct look *look, float x, float y)
{
	const float east = (look->axis[0] * x - look->axis[1] * y - look->x) * look->by, north = (look->axis[1] * x + look->axis[0] * y - look->y) * look->by;
	const float u = clamped(east, 0, look->columns), v = clamped(north, 0, look->rows);
	const int32_t column = (int32_t)u, row = (int32_t)v, at = row * look->stride + column;
	const float a = look->ahead[at], b = look->ahead[at + look->east], c = look->ahead[at + look->stride], d = look->ahead[at + look->stride + look->east];
	const float p = u - (float)column, q = v - (float)row, low = a + p * (b - a), high = c + p * (d - c);
	return low + q * (high - low);
}

/* Forces and moments of a block, whole numbers, and for the search how the vertical force grows. */
struct facet_sums {
	int32_t force[3][LANES], moment[3][LANES], pull[LANES], saturated[LANES];
	float grows[LANES], depth[LANES];
};

/* unit: of the sums, for each newton; by_arm: of moments. */
SOIL_CLONED static void add_block(const struct soil_form *restrict f, const struct soil_faces *restrict faces, size_t b, const struct look *restrict look, float raised, float unit,
				  struct facet_sums *restrict sums)
{
	EACH_LANE {
		const size_t n = b + (size_t)i;
		const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, normal[3] = {faces->nx[n], faces->ny[n], faces->nz[n]};
		const float depth = most(surface_at(look, at[0], at[1]) - at[2] - raised, 0), by = faces->xi * depth * unit;
		const float force[3] = {by * faces->px[n], by * faces->py[n], by * faces->pz[n]};
		float moment[3], belt[3], large = 0;
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
		sums->grows[i] = either(depth > 0, faces->xi * unit * faces->pz[n], 0);
		sums->depth[i] = depth;
	}
}

/* Returns how far the surface rises at a place for each m, in the frame. */
static void slope_at(const struct look *look, float x, float y, float spacing, float slope[2])
{
	const float by = 0.5f / spacing;
	slope[0] = (surface_at(look, x + spacing, y) - surface_at(look, x - spacing, y)) * by;
	slope[1] = (surface_at(look, x, y + spacing) - surface_at(look, x, y - spacing)) * by;
}

/* Adds how the force of a facet changes: with its depth, and with the recent motion of its place. inverse: 1 / the shear modulus, in which a motion counts. */
static void add_changes(const struct soil_form *f, const struct soil_faces *faces, size_t n, const struct look *look, float depth, struct soil_changes *changes)
{
	const float at[3] = {faces->x[n], faces->y[n], faces->z[n]}, press[3] = {faces->px[n], faces->py[n], faces->pz[n]}, xi = faces->xi;
	float slope[2], bends[3][3], place[3][3];
	slope_at(look, at[0], at[1], f->spacing, slope);
	soil_press_changes(f, faces, n, bends);
	const float deeper[3] = {slope[0], slope[1], -1};
	for (int k = 0; k < 3; k++)
		for (int j = 0; j < 3; j++)
			place[k][j] = xi * (press[k] * deeper[j] + depth * bends[k][j] * faces->by_modulus);
	/* A motion of the place is that of the centre and the turn across the arm. */
	for (int k = 0; k < 3; k++) {
		double row[6];
		const double a[3] = {(double)place[k][0], (double)place[k][1], (double)place[k][2]}, r[3] = {(double)at[0], (double)at[1], (double)at[2]};
		for (int j = 0; j < 3; j++) {
			row[j] = a[j];
			row[3 + j] = r[(j + 1) % 3] * a[(j + 2) % 3] - r[(j + 2) % 3] * a[(j + 1) % 3];
		}
		for (int j = 0; j < 6; j++) {
			changes->stiffness.at[k][j] += row[j];
			changes->stiffness.at[3 + (k + 1) % 3][j] += r[(k + 2) % 3] * row[j];
			changes->stiffness.at[3 + (k + 2) % 3][j] -= r[(k + 1) % 3] * row[j];
		}
	}
	const double force[3] = {(double)(xi * depth * press[0]), (double)(xi * depth * press[1]), (double)(xi * depth * press[2])};
	const double normal[3] = {(double)faces->nx[n], (double)faces->ny[n], (double)faces->nz[n]};
	const double across = force[0] * normal[0] + force[1] * normal[1] + force[2] * normal[2];
	changes->normal_force += fabs(across);
	changes->shear_limit += (double)faces->tangent * fabs(across);
	for (int k = 0; k < 3; k++)
		changes->sheared[k] += force[k] - across * normal[k];
}

static int64_t total(const int32_t lanes[LANES])
{
	int64_t sum = 0;
	for (int i = 0; i < LANES; i++)
		sum += lanes[i];
	return sum;
}

void soil_faces_add(const struct soil_planes *planes, const struct soil_body *body, const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share,
		    struct soil_faces *faces, struct soil_sums *sums, struct soil_changes *changes)
{
	const float up = (float)raised * SOIL_UNIT + form->beyond, unit = BEAR_UNITS_A_PASCAL / (share * form->spacing * form->spacing);
	struct facet_sums block;
	if (faces->count == 0)
		return;
	soil_ahead_put(planes, body, form, posts, up, faces);
	const struct look look = look_of(body, form, faces);
	for (size_t b = 0; b < faces->count; b += LANES) {
		add_block(form, faces, b, &look, up, unit, &block);
		for (int k = 0; k < 3; k++) {
			sums->force[k] += total(block.force[k]);
			sums->moment[k] += total(block.moment[k]);
		}
		sums->pull += total(block.pull);
		sums->saturated += total(block.saturated);
		for (size_t i = 0; i < LANES; i++) {
			sums->grows += changes == NULL ? (double)block.grows[i] : 0;
			if (changes != NULL && block.depth[i] > 0)
				add_changes(form, faces, b + i, &look, block.depth[i], changes);
		}
	}
}
