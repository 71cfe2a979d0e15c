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
#include "deform/shape/body.h"

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

/* Returns 1 / b, b the width of the contact patch: src/deform/soil/scm.c. touched: posts; 0: they are not counted. */
static double width_of(const struct probe_law *law, const struct deform_probe *probe, size_t touched)
{
	const struct deform_shape *shape = probe->shape;
	double extent[2];
	if (shape->kind == DEFORM_WHEEL || shape->kind == DEFORM_CYLINDER) {
		const double squares = law->form->lean * law->form->lean;
		return (1 - squares) / (shape->kind == DEFORM_WHEEL ? shape->width : shape->length) + squares / shape->radius;
	}
	if (shape->kind == DEFORM_BOX)
		return 1 / fmin(shape->size[0], shape->size[1]);
	const struct deform *deform = law->patch->deform;
	deform_body_extent(shape, &probe->to, extent);
	const double shadow = shape->kind == DEFORM_SPHERE ? M_PI * shape->radius * shape->radius : 4 * extent[0] * extent[1];
	return 1 / sqrt((touched > 0 ? (double)touched * deform->spacing * deform->spacing : shadow) / M_PI);
}

static void put_law(const struct deform_patch *patch, const struct deform_probe *probe, const struct probe_form *form, struct probe_law *law)
{
	const struct deform_interface *interface = &probe->interface;
	*law = (struct probe_law){
		.form = form, .patch = patch, .above_zero = lattice_offset_metres(probe->to.z - patch->zero) + probe->beyond[2],
		.lowest = -deform_shape_bound(probe->shape),
		.surface = {interface->has_adhesion ? interface->adhesion : 0, interface->has_friction ? tan(interface->friction_angle) : 0},
		.own = {!interface->has_adhesion, !interface->has_friction},
	};
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
	if (!posts_below(patch, probe, &below))
		return;
	deform_probe_form_of(patch->deform, probe, &form);
	deform_low_of(patch, probe, &below, &form);
	put_law(patch, probe, &form, &law);
	clear(&sums);
	const double spacing = form.spacing;
	const double corner[2] = {-(double)deform_body_from_post(probe->to.x, below.x0, spacing) - probe->beyond[0],
				  -(double)deform_body_from_post(probe->to.y, below.y0, spacing) - probe->beyond[1]};
	const double step[2] = {form.axis[0] * spacing, -form.axis[1] * spacing};
	const bool counted = deform_is_counted(&patch->deform->params, probe->shape, false);
	const size_t touched = counted ? touched_posts(&law, &below, corner) : 0;
	law.by_width = width_of(&law, probe, counted && touched == 0 ? 1 : touched);
	if (form.kind == DEFORM_MESH && deform_low_is_aloft(&law, &below))
		below.y1 = below.y0; /* between posts only its slope is known, which may reach below the mesh */
	for (int64_t y = below.y0; y < below.y1; y++) {
		double at[2];
		first_place(&form, corner, (double)(y - below.y0), at);
		const size_t first = first_of_row(patch, &below, y);
		for (int64_t x = below.x0; x < below.x1; x++) {
			struct probe_bearing bearing;
			const size_t number = first + (size_t)(x - below.x0);
			if (deform_law_may_bear(&law, number, at)) {
				deform_law_bearing(&law, number, at, &bearing);
				if (bearing.count > 0 || bearing.has_brim)
					deform_sums_add(&law, &patch->posts[number], &bearing, &sums);
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
	if (!posts_below(patch, probe, &below))
		return;
	deform_probe_form_of(patch->deform, probe, &form);
	deform_low_of(patch, probe, &below, &form);
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
