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
#include "deform/probe/terms.h"
#include "deform/shape/body.h"

/* Sums in the body's frame: x forwards, y to its left. Forces come before moments, translations before rotations. */
struct sums {
	double force[6];
	double normal[3], normal_force, shear_limit, sheared[3], area, sinkage, pull;
	struct terms stiffness, damping;
};

static void cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

/* A vector at a place, and its moment about the body's centre. */
static void wrench(const double v[3], const double arm[3], double out[6])
{
	memcpy(out, v, 3 * sizeof *v);
	cross(arm, v, out + 3);
}

/* Adds how the normals turn as the body moves, while the place on the ground stays. They turn with the body, and a round body shows
 * another part of its surface. */
static void add_turning(const struct probe_form *form, const struct probe_place *place, double area, struct sums *sums)
{
	const double *n = place->normal, x = n[0] / n[2], y = n[1] / n[2], by = area * n[2] * place->stress, *arm = place->arm;
	double rows[2][6] = {
		{0, 0, 0, -x * y * by, (1 + x * x) * by, -y * by},
		{0, 0, 0, (-1 - y * y) * by, x * y * by, x * by},
	};
	if (probe_is_round(form)) {
		const double bends = by / (form->radius * n[2]), wheel = form->kind == DEFORM_WHEEL;
		const double level[2][6] = {{1, 0, 0, 0, arm[2], -arm[1]}, {0, 1, 0, -arm[2], 0, arm[0]}};
		for (int k = 0; k < 6; k++) {
			const double along = x * level[0][k] + y * level[1][k];
			rows[0][k] += bends * (level[0][k] + x * along);
			rows[1][k] += wheel ? 0 : bends * (level[1][k] + y * along);
		}
	}
	const double ahead[6] = {1, 0, 0, 0, arm[2], -arm[1]}, aside[6] = {0, 1, 0, -arm[2], 0, arm[0]};
	terms_put(&sums->stiffness, ahead, rows[0]);
	terms_put(&sums->stiffness, aside, rows[1]);
}

/* Gives the stress on the body at a place, Pa: of the surface. shear: of its shear, the direction times the share of the strength. */
static void stress_at(const struct probe_place *place, double shear[3], double stress[3])
{
	for (int k = 0; k < 3; k++) {
		shear[k] = place->mobilised[0] * place->across[0][k] + place->mobilised[1] * place->across[1][k];
		stress[k] = place->stress * place->normal[k] - place->strength * shear[k] - place->dragged[0] * place->across[0][k] -
			    place->dragged[1] * place->across[1][k];
	}
}

/* Returns the pull of a belt against the soil's shear at a place, Pa. */
static double pull_at(const struct probe_form *form, const struct probe_place *place, const double stress[3])
{
	double along[3];
	cross(place->normal, form->belt, along);
	return -(stress[0] * along[0] + stress[1] * along[1] + stress[2] * along[2]);
}

static void add_force(const struct probe_form *form, const struct probe_place *place, double post, struct sums *sums)
{
	const double area = place->area * post;
	double shear[3], force[3], column[6];
	stress_at(place, shear, force);
	wrench(force, place->arm, column);
	for (int k = 0; k < 6; k++)
		sums->force[k] += area * column[k];
	for (int k = 0; k < 3; k++)
		sums->sheared[k] += area * place->strength * shear[k];
	sums->pull += area * pull_at(form, place, force);
	sums->normal_force += area * place->stress;
	sums->shear_limit += area * place->strength;
	sums->area += place->ground * post;
}

/* Adds how the force at a place changes. */
static void add_changes(const struct probe_form *form, const struct probe_place *place, double area, struct sums *sums)
{
	const double *n = place->normal, by_up = 1 / n[2];
	double shear[3], force[3], grows[3], column[6], row[6], along[2][6];
	stress_at(place, shear, force);
	for (int k = 0; k < 3; k++)
		grows[k] = (n[k] - place->holds * shear[k]) * area;
	/* The surface rises above a place of the ground by row . motion. */
	wrench(n, place->arm, row);
	wrench(grows, place->arm, column);
	double slower[6];
	for (int k = 0; k < 6; k++) {
		slower[k] = -place->damps * column[k];
		column[k] *= -place->sinks * by_up;
	}
	terms_put(&sums->damping, slower, row);
	column[3] -= force[1] * area * by_up;
	column[4] += force[0] * area * by_up;
	terms_put(&sums->stiffness, column, row);
	wrench(place->across[0], place->arm, along[0]);
	wrench(place->across[1], place->arm, along[1]);
	for (int i = 0; i < 2; i++) {
		const double less = -area * place->strength, slow = -area;
		double stiff[6], drags[6];
		for (int k = 0; k < 6; k++) {
			stiff[k] = less * (place->shears[i][0] * along[0][k] + place->shears[i][1] * along[1][k]);
			drags[k] = slow * (place->drags[i][0] * along[0][k] + place->drags[i][1] * along[1][k]);
		}
		terms_put(&sums->stiffness, along[i], stiff);
		terms_put(&sums->damping, along[i], drags);
	}
	if (!form->ground_normals)
		add_turning(form, place, area, sums);
}

/* Adds how the part of the cell grows as a side of the body moves over it. */
static void add_sides(const struct probe_form *form, const struct probe_bearing *bearing, const struct probe_place *place, double area,
		      struct sums *sums)
{
	for (int side = 0; side < 4; side++) {
		const int axis = side / 2;
		const double ahead = side % 2 == 0 ? -1 : 1, by = ahead * area * form->by_step / bearing->share;
		if (!bearing->sides[side])
			continue;
		double shear[3], force[3], column[6], row[6], arm[3];
		const double out[3] = {axis == 0 ? by : 0, axis == 1 ? by : 0, 0};
		memcpy(arm, place->arm, sizeof arm);
		arm[axis] = ahead * form->half[axis];
		stress_at(place, shear, force);
		wrench(force, arm, column);
		wrench(out, arm, row);
		terms_put(&sums->stiffness, column, row);
	}
}

/* Gives the mean of a post's places, by area. Returns their area, posts. */
static double mean_of(const struct probe_bearing *bearing, struct probe_place *mean)
{
	const struct probe_place *a = &bearing->places[0], *b = &bearing->places[1];
	_Static_assert(sizeof *mean % sizeof(double) == 0, "a place has nothing but doubles");
	if (bearing->count == 1) {
		*mean = *a;
		return a->area;
	}
	const double area = a->area + b->area, of_b = b->area / area, of_a = 1 - of_b;
	const double *from_a = (const double *)a, *from_b = (const double *)b;
	double *to = (double *)mean;
	for (size_t i = 0; i < sizeof *mean / sizeof *to; i++)
		to[i] = of_a * from_a[i] + of_b * from_b[i];
	return area;
}

static void add_bearing(const struct probe_law *law, const struct probe_post *ground, const struct probe_bearing *bearing, struct sums *sums)
{
	const struct probe_form *form = law->form;
	const double post = form->spacing * form->spacing;
	struct probe_place mean;
	double bears = 0;
	for (int i = 0; i < bearing->count; i++) {
		add_force(form, &bearing->places[i], post, sums);
		bears += bearing->places[i].ground;
	}
	if (bears <= 0)
		return;
	const double area = mean_of(bearing, &mean) * post;
	add_changes(form, &mean, area, sums);
	add_sides(form, bearing, &mean, area, sums);
	sums->normal[0] -= bears * ground->up * ground->rise[0];
	sums->normal[1] -= bears * ground->up * ground->rise[1];
	sums->normal[2] += bears * ground->up;
	sums->sinkage = fmax(sums->sinkage, bearing->sinkage);
}

/* --- the posts --- */

/* Finds the posts that the body may bear on. Returns false if the patch has not all of them, with their neighbours. */
static bool posts_below(const struct deform_patch *patch, const struct deform_probe *probe, struct post_rect *below)
{
	const double spacing = patch->deform->spacing;
	double extent[2];
	deform_body_extent(probe->shape, &probe->to, extent);
	const double x = lattice_offset_metres(probe->to.x), y = lattice_offset_metres(probe->to.y);
	*below = (struct post_rect){(int64_t)floor((x - extent[0]) / spacing), (int64_t)floor((y - extent[1]) / spacing),
				    (int64_t)ceil((x + extent[0]) / spacing) + 1, (int64_t)ceil((y + extent[1]) / spacing) + 1};
	const struct post_rect *has = &patch->rect;
	return patch->known && !patch->coming && below->x0 > has->x0 && below->y0 > has->y0 && below->x1 < has->x1 && below->y1 < has->y1;
}

struct post_rect deform_probe_posts(const struct deform *deform, const struct deform_shape *shape, const struct deform_pose *pose, int64_t margin)
{
	const struct deform_contact standing = {.shape = shape, .from = *pose, .to = *pose};
	const struct post_rect shadow = deform_shadow(deform, &standing);
	return (struct post_rect){shadow.x0 - margin - 1, shadow.y0 - margin - 1, shadow.x1 + margin + 1, shadow.y1 + margin + 1};
}

static size_t first_of_row(const struct deform_patch *patch, const struct post_rect *below, int64_t y)
{
	return (size_t)(y - patch->rect.y0) * patch->width + (size_t)(below->x0 - patch->rect.x0);
}

/* Gives the place of the first post of a row in the body's frame. */
static void first_place(const struct probe_form *form, const double corner[2], double row, double at[2])
{
	const double east = corner[0], north = corner[1] + row * form->spacing;
	at[0] = form->axis[0] * east + form->axis[1] * north;
	at[1] = form->axis[0] * north - form->axis[1] * east;
}

static size_t touched_posts(const struct probe_law *law, const struct post_rect *below, const double corner[2])
{
	const struct probe_form *form = law->form;
	const double step[2] = {form->axis[0] * form->spacing, -form->axis[1] * form->spacing};
	size_t count = 0;
	for (int64_t y = below->y0; y < below->y1; y++) {
		double at[2];
		first_place(form, corner, (double)(y - below->y0), at);
		const size_t first = first_of_row(law->patch, below, y);
		for (int64_t x = below->x0; x < below->x1; x++) {
			double height;
			count += deform_law_touches(law, first + (size_t)(x - below->x0), at, &height);
			at[0] += step[0];
			at[1] += step[1];
		}
	}
	return count;
}

/* Returns 1 / b, b the width of the contact patch. */
static double width_of(const struct probe_law *law, const struct deform_shape *shape, const struct post_rect *below, const double corner[2])
{
	if (shape->kind == DEFORM_WHEEL)
		return 1 / shape->width;
	if (shape->kind == DEFORM_BOX)
		return 1 / fmin(shape->size[0], shape->size[1]);
	const struct deform *deform = law->patch->deform;
	const double shadow = M_PI * shape->radius * shape->radius, post = deform->spacing * deform->spacing;
	if (!deform_is_counted(&deform->params, shape, false))
		return 1 / sqrt(shadow / M_PI);
	return 1 / sqrt(fmax((double)touched_posts(law, below, corner), 1) * post / M_PI);
}

static void put_law(const struct deform_patch *patch, const struct deform_probe *probe, const struct probe_form *form, struct probe_law *law)
{
	const struct deform_interface *interface = &probe->interface;
	*law = (struct probe_law){
		.form = form, .patch = patch, .above_zero = lattice_offset_metres(probe->to.z - patch->zero) + probe->beyond[2],
		.surface = {interface->has_adhesion ? interface->adhesion : 0, interface->has_friction ? tan(interface->friction_angle) : 0},
		.own = {!interface->has_adhesion, !interface->has_friction},
	};
}

static bool is_probed(const struct deform_shape *shape)
{
	return shape->kind == DEFORM_SPHERE || shape->kind == DEFORM_BOX || (shape->kind == DEFORM_WHEEL && shape->grousers == 0);
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
static void move_centre(struct sums *sums)
{
	const double *f = sums->force;
	const double skew[3][3] = {{0, -f[2], f[1]}, {f[2], 0, -f[0]}, {-f[1], f[0], 0}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			sums->stiffness.matrix[3 + i][k] += skew[i][k];
}

static void clear(struct sums *sums)
{
	memset(sums, 0, offsetof(struct sums, stiffness));
	sums->stiffness.count = sums->damping.count = 0;
	memset(sums->stiffness.matrix, 0, sizeof sums->stiffness.matrix);
	memset(sums->damping.matrix, 0, sizeof sums->damping.matrix);
}

static enum deform_state state_of(const struct deform_probe *probe, const struct sums *sums)
{
	const double *t = sums->sheared, shear = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
	if (!(sums->area > 0))
		return DEFORM_AIR;
	if (sums->sinkage > 2 * deform_shape_reach(probe->shape, probe->to.pitch, probe->to.roll))
		return DEFORM_SUNK;
	return shear > 0.99 * sums->shear_limit ? DEFORM_SLIDES : DEFORM_TOUCHING;
}

static void answer(const struct deform_probe *probe, const struct probe_form *form, struct sums *sums, struct deform_probed *out)
{
	const double *n = sums->normal, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	deform_terms_add_up(&sums->stiffness);
	deform_terms_add_up(&sums->damping);
	move_centre(sums);
	out->known = true;
	out_of_frame(form, sums->force, out->force);
	out_of_frame(form, sums->force + 3, out->moment);
	turn_matrix(form, (const double(*)[6])sums->stiffness.matrix, out->stiffness);
	turn_matrix(form, (const double(*)[6])sums->damping.matrix, out->damping);
	for (int k = 0; k < 3; k++)
		out->normal[k] = length > 0 ? n[k] / length : NAN;
	out->pull = sums->pull;
	out->normal_force = sums->normal_force;
	out->shear_limit = sums->shear_limit;
	out->area = sums->area;
	out->sinkage = sums->sinkage;
	out->state = state_of(probe, sums);
}

void deform_probe(const struct deform_patch *patch, const struct deform_probe *probe, struct deform_probed *out)
{
	struct probe_form form;
	struct probe_law law;
	struct post_rect below;
	struct sums sums; /* its terms need not be cleared */
	*out = (struct deform_probed){.known = false};
	if (!is_probed(probe->shape) || !posts_below(patch, probe, &below))
		return;
	deform_probe_form_of(patch->deform, probe, &form);
	put_law(patch, probe, &form, &law);
	clear(&sums);
	const double spacing = form.spacing;
	const double corner[2] = {-(double)deform_body_from_post(probe->to.x, below.x0, spacing) - probe->beyond[0],
				  -(double)deform_body_from_post(probe->to.y, below.y0, spacing) - probe->beyond[1]};
	const double step[2] = {form.axis[0] * spacing, -form.axis[1] * spacing};
	law.by_width = width_of(&law, probe->shape, &below, corner);
	for (int64_t y = below.y0; y < below.y1; y++) {
		double at[2];
		first_place(&form, corner, (double)(y - below.y0), at);
		const size_t first = first_of_row(patch, &below, y);
		for (int64_t x = below.x0; x < below.x1; x++) {
			struct probe_bearing bearing;
			const size_t number = first + (size_t)(x - below.x0);
			if (deform_law_may_bear(&law, number, at)) {
				deform_law_bearing(&law, number, at, &bearing);
				if (bearing.count > 0)
					add_bearing(&law, &patch->posts[number], &bearing, &sums);
			}
			at[0] += step[0];
			at[1] += step[1];
		}
	}
	answer(probe, &form, &sums, out);
}

void deform_patch_reach(struct deform_patch *patch, const struct deform_probe *probe)
{
	struct probe_form form;
	struct probe_law law;
	struct post_rect below;
	if (!is_probed(probe->shape) || !posts_below(patch, probe, &below))
		return;
	deform_probe_form_of(patch->deform, probe, &form);
	put_law(patch, probe, &form, &law);
	const double corner[2] = {-(double)deform_body_from_post(probe->to.x, below.x0, form.spacing) - probe->beyond[0],
				  -(double)deform_body_from_post(probe->to.y, below.y0, form.spacing) - probe->beyond[1]};
	const double step[2] = {form.axis[0] * form.spacing, -form.axis[1] * form.spacing};
	for (int64_t y = below.y0; y < below.y1; y++) {
		double at[2];
		first_place(&form, corner, (double)(y - below.y0), at);
		const size_t first = first_of_row(patch, &below, y);
		for (int64_t x = below.x0; x < below.x1; x++) {
			struct probe_post *post = &patch->posts[first + (size_t)(x - below.x0)];
			double height;
			if (deform_law_touches(&law, first + (size_t)(x - below.x0), at, &height))
				post->reached = fmin(post->reached, height);
			at[0] += step[0];
			at[1] += step[1];
		}
	}
}
