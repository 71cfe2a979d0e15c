/*
 * What the soil would do to a body in a state, by the law of scm on the host, over the mirrored ground (patch.c).
 *
 * The force is that of a straight motion from the pose of the last contact to the probed pose, as deform_feel would tell it. With it comes
 * how the force changes. Each place of the patch gives a normal and a shear stiffness along its own directions. These add up to two
 * matrices of 6 x 6. So a probe needs one pass over the posts.
 */
#include <math.h>
#include <string.h>

#include "deform/internal.h"
#include "deform/probe/law.h"
#include "deform/probe/low.h"
#include "deform/probe/sums.h"
#include "soil/shape/body.h"

/* --- the posts --- */

/* Finds the posts that the body may bear on. Returns false if the patch has not all of them, with their neighbours. */
static bool posts_below(const struct deform_patch *patch, const struct deform_probe *probe, struct post_rect *below)
{
	const double spacing = patch->deform->spacing;
	double extent[2];
	soil_body_extent(probe->shape, &probe->to, extent);
	const double x = lattice_offset_metres(probe->to.x), y = lattice_offset_metres(probe->to.y);
	*below = (struct post_rect){(int64_t)floor((x - extent[0]) / spacing), (int64_t)floor((y - extent[1]) / spacing),
				    (int64_t)ceil((x + extent[0]) / spacing) + 1, (int64_t)ceil((y + extent[1]) / spacing) + 1};
	const struct post_rect *has = &patch->rect;
	return patch->known && !patch->coming && below->x0 > has->x0 && below->y0 > has->y0 && below->x1 < has->x1 && below->y1 < has->y1;
}

struct post_rect deform_probe_posts(const struct deform *deform, const struct soil_shape *shape, const struct soil_pose *pose, int64_t margin)
{
	const struct deform_contact standing = {.shape = shape, .from = *pose, .to = *pose};
	const struct post_rect shadow = deform_shadow(deform, &standing);
	return (struct post_rect){shadow.x0 - margin - 1, shadow.y0 - margin - 1, shadow.x1 + margin + 1, shadow.y1 + margin + 1};
}

/* A walk over the posts below a body, row by row. */
struct walk {
	struct post_rect below;
	double corner[2], step[2]; /* of the first post from the body's centre, to the east and to the north; from a post to the next, in the body's frame */
};

static struct walk walk_of(const struct probe_form *form, const struct deform_probe *probe, struct post_rect below)
{
	const double spacing = form->spacing;
	return (struct walk){
		.below = below,
		.corner = {-(double)soil_body_from_post(probe->to.x, below.x0, spacing) - probe->beyond[0],
			   -(double)soil_body_from_post(probe->to.y, below.y0, spacing) - probe->beyond[1]},
		.step = {form->axis[0] * spacing, -form->axis[1] * spacing},
	};
}

/* Gives the place of a post in the body's frame. Returns its number in the patch. */
static size_t begin_row(const struct walk *walk, const struct probe_form *form, const struct deform_patch *patch, int64_t x, int64_t y, double at[2])
{
	const double east = walk->corner[0] + (double)(x - walk->below.x0) * form->spacing;
	const double north = walk->corner[1] + (double)(y - walk->below.y0) * form->spacing;
	at[0] = form->axis[0] * east + form->axis[1] * north;
	at[1] = form->axis[0] * north - form->axis[1] * east;
	return (size_t)(y - patch->rect.y0) * patch->width + (size_t)(x - patch->rect.x0);
}

/* Leaves the columns at which first + column x step is within `most` of 0. */
static void cut(double first, double step, double most, int64_t columns[2])
{
	if (fabs(step) < 1e-6 * most)
		return;
	const double a = (-most - first) / step, b = (most - first) / step;
	columns[0] = (int64_t)probe_clamp(floor(probe_least(a, b)), (double)columns[0], (double)columns[1]);
	columns[1] = (int64_t)probe_clamp(ceil(probe_most(a, b)) + 1, (double)columns[0], (double)columns[1]);
}

/* Finds the posts of a row that a wheel, or a cylinder's side, may bear on: deform_law_in_strip. at: of the first of the row. */
static void cut_row(const struct walk *walk, const struct probe_form *form, const double at[2], int64_t columns[2])
{
	const double leans = fabs(form->lean) * form->radius, aside = probe_most(form->half[1], 0.5 * form->step_aside) + leans;
	columns[0] = 0;
	columns[1] = walk->below.x1 - walk->below.x0;
	if (form->kind != SOIL_WHEEL && !probe_strips(form))
		return;
	cut(at[1], walk->step[1], aside + 1e-2 * form->spacing, columns);
	cut(at[0], walk->step[0], form->outer + form->half_across + form->spacing, columns);
}

static size_t touched_posts(const struct probe_law *law, const struct walk *walk)
{
	size_t count = 0;
	for (int64_t y = walk->below.y0; y < walk->below.y1; y++) {
		double at[2], height;
		size_t number = begin_row(walk, &law->form, law->patch, walk->below.x0, y, at);
		for (int64_t x = walk->below.x0; x < walk->below.x1; x++, number++) {
			count += deform_law_touches(law, number, at, &height);
			at[0] += walk->step[0];
			at[1] += walk->step[1];
		}
	}
	return count;
}

/* Returns 1 / b, b the width of the contact patch: src/deform/soil/scm.c. touched: posts; 0: they are not counted. */
static double width_of(const struct probe_law *law, const struct deform_probe *probe, size_t touched)
{
	const struct soil_shape *shape = probe->shape;
	double extent[2];
	if (shape->kind == SOIL_WHEEL || shape->kind == SOIL_CYLINDER) {
		const double squares = law->form.lean * law->form.lean;
		return (1 - squares) / (shape->kind == SOIL_WHEEL ? shape->width : shape->length) + squares / shape->radius;
	}
	if (shape->kind == SOIL_BOX)
		return 1 / fmin(shape->size[0], shape->size[1]);
	const struct deform *deform = law->patch->deform;
	soil_body_extent(shape, &probe->to, extent);
	const double shadow = shape->kind == SOIL_SPHERE ? M_PI * shape->radius * shape->radius : 4 * extent[0] * extent[1];
	return 1 / sqrt((touched > 0 ? (double)touched * deform->spacing * deform->spacing : shadow) / M_PI);
}

/* Sets all but `by_width`. law->form points to itself, so a law is not copied. */
static void put_law(const struct deform_patch *patch, const struct deform_probe *probe, const struct post_rect *below, struct probe_law *law)
{
	const struct soil_interface *interface = &probe->interface;
	deform_probe_form_of(patch->deform, probe, &law->form);
	deform_low_of(patch, probe, below, &law->form);
	law->patch = patch;
	law->above_zero = lattice_offset_metres(probe->to.z - patch->zero) + probe->beyond[2];
	law->lowest = -soil_shape_bound(probe->shape);
	law->surface[0] = interface->has_adhesion ? interface->adhesion : 0;
	law->surface[1] = interface->has_friction ? tan(interface->friction_angle) : 0;
	law->own[0] = interface->has_adhesion ? 0 : 1;
	law->own[1] = interface->has_friction ? 0 : 1;
}

/* --- the answer --- */

/* Turns a vector from the body's frame to local axes. */
static void out_of_frame(const struct probe_form *form, const double v[3], double out[3])
{
	out[0] = form->axis[0] * v[0] - form->axis[1] * v[1];
	out[1] = form->axis[1] * v[0] + form->axis[0] * v[1];
	out[2] = v[2];
}

/* Turns a matrix of such vectors: rows, then columns. */
static void turn_matrix(const struct probe_form *form, const double from[6][6], double to[6][6])
{
	double half[6][6];
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k += 3)
			out_of_frame(form, &from[i][k], &half[i][k]);
	for (int k = 0; k < 6; k++)
		for (int i = 0; i < 6; i += 3) {
			const double column[3] = {half[i][k], half[i + 1][k], half[i + 2][k]};
			double turned[3];
			out_of_frame(form, column, turned);
			for (int j = 0; j < 3; j++)
				to[i + j][k] = turned[j];
		}
}

/* The moment is about the centre, which moves with the body. */
static void move_centre(const double f[3], double stiffness[6][6])
{
	const double skew[3][3] = {{0, -f[2], f[1]}, {f[2], 0, -f[0]}, {-f[1], f[0], 0}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			stiffness[3 + i][k] += skew[i][k];
}

static double total(const double lanes[LANES])
{
	double sums[4] = {0, 0, 0, 0};
	for (int i = 0; i < LANES; i += 4) {
		sums[0] += lanes[i];
		sums[1] += lanes[i + 1];
		sums[2] += lanes[i + 2];
		sums[3] += lanes[i + 3];
	}
	return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

static void total_matrix(const struct lane_matrix *lanes, double matrix[6][6])
{
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k++)
			matrix[i][k] = total(lanes->at[i][k]);
}

static enum deform_state state_of(const struct deform_probe *probe, const struct deform_probed *out, const double sheared[3])
{
	if (!(out->area > 0))
		return DEFORM_AIR;
	if (out->sinkage > 2 * soil_shape_reach(probe->shape, probe->to.pitch, probe->to.roll))
		return DEFORM_SUNK;
	return sqrt(sheared[0] * sheared[0] + sheared[1] * sheared[1] + sheared[2] * sheared[2]) > 0.99 * out->shear_limit ? DEFORM_SLIDES : DEFORM_TOUCHING;
}

static void answer(const struct deform_probe *probe, const struct probe_form *form, const struct sums *sums, struct deform_probed *out)
{
	double force[6], normal[3], sheared[3], matrix[6][6];
	for (int k = 0; k < 6; k++)
		force[k] = total(sums->force[k]);
	for (int k = 0; k < 3; k++) {
		normal[k] = total(sums->normal[k]);
		sheared[k] = total(sums->sheared[k]);
	}
	out->known = true;
	out_of_frame(form, force, out->force);
	out_of_frame(form, force + 3, out->moment);
	total_matrix(&sums->stiffness, matrix);
	move_centre(force, matrix);
	turn_matrix(form, (const double(*)[6])matrix, out->stiffness);
	total_matrix(&sums->damping, matrix);
	turn_matrix(form, (const double(*)[6])matrix, out->damping);
	const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	out_of_frame(form, normal, out->normal);
	for (int k = 0; k < 3; k++)
		out->normal[k] = length > 0 ? out->normal[k] / length : NAN;
	out->pull = total(sums->pull);
	out->normal_force = total(sums->normal_force);
	out->shear_limit = total(sums->shear_limit);
	out->area = total(sums->area);
	out->sinkage = 0;
	for (int i = 0; i < LANES; i++)
		out->sinkage = fmax(out->sinkage, sums->sinkage[i]);
	out->state = state_of(probe, out, sheared);
}

/* Computes a batch, adds what it bears, and empties it. In the first one the lanes without a post take its last one. */
static void add_batch(const struct probe_law *law, struct lanes *lanes, struct sums *sums)
{
	const int count = lanes->count;
	if (count == 0)
		return;
	const double at[2] = {lanes->at[0][count - 1], lanes->at[1][count - 1]};
	while (lanes->count < LANES && lanes->used < LANES)
		deform_law_take(law, lanes->number[count - 1], at, lanes);
	lanes->count = count;
	lanes->used = LANES;
	if (deform_law_bear(law, lanes))
		deform_sums_add(law, lanes, sums);
	lanes->count = 0;
}

static void add_posts(const struct probe_law *law, const struct walk *walk, struct sums *sums)
{
	struct lanes lanes;
	lanes.count = lanes.used = 0;
	for (int64_t y = walk->below.y0; y < walk->below.y1; y++) {
		double first[2], at[2];
		int64_t columns[2];
		begin_row(walk, &law->form, law->patch, walk->below.x0, y, first);
		cut_row(walk, &law->form, first, columns);
		size_t number = begin_row(walk, &law->form, law->patch, walk->below.x0 + columns[0], y, at);
		for (int64_t column = columns[0]; column < columns[1]; column++, number++) {
			if (deform_law_may_bear(law, number, at))
				deform_law_take(law, number, at, &lanes);
			if (lanes.count == LANES)
				add_batch(law, &lanes, sums);
			at[0] += walk->step[0];
			at[1] += walk->step[1];
		}
	}
	add_batch(law, &lanes, sums);
}

void deform_probe(const struct deform_patch *patch, const struct deform_probe *probe, struct deform_probed *out)
{
	struct probe_law law;
	struct post_rect below;
	struct sums sums;
	*out = (struct deform_probed){.known = false};
	if (!posts_below(patch, probe, &below))
		return;
	put_law(patch, probe, &below, &law);
	memset(&sums, 0, sizeof sums);
	const struct walk walk = walk_of(&law.form, probe, below);
	const bool counted = deform_is_counted(&patch->deform->params, probe->shape, false);
	const size_t touched = counted ? touched_posts(&law, &walk) : 0;
	law.by_width = width_of(&law, probe, counted && touched == 0 ? 1 : touched);
	/* Between posts only the slope of a mesh is known, which may reach below the mesh. */
	if (law.form.kind != SOIL_MESH || !deform_low_is_aloft(&law, &below))
		add_posts(&law, &walk, &sums);
	answer(probe, &law.form, &sums, out);
}

void deform_patch_reach(struct deform_patch *patch, const struct deform_probe *probe)
{
	struct probe_law law;
	struct post_rect below;
	if (!posts_below(patch, probe, &below))
		return;
	put_law(patch, probe, &below, &law);
	const struct walk walk = walk_of(&law.form, probe, below);
	for (int64_t y = below.y0; y < below.y1; y++) {
		double at[2], height;
		size_t number = begin_row(&walk, &law.form, patch, below.x0, y, at);
		for (int64_t x = below.x0; x < below.x1; x++, number++) {
			struct probe_post *post = &patch->posts[number];
			if (deform_law_touches(&law, number, at, &height))
				post->reached = fmin(post->reached, height);
			at[0] += walk.step[0];
			at[1] += walk.step[1];
		}
	}
}
