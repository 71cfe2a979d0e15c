/* Finds the posts that a contact can change, and cuts them into windows. */
#include <math.h>

#include "deform/shape/body.h"
#include "deform/internal.h"

/* Heights within an object are int32 fixed-point units. Half its height and the rise of a contact must fit. */
#define SIZE_MAX_METRES 512.0
#define GROUSERS_MAX 360
#define LARGE 20.0 /* m across: larger bodies are probably given in mm */
#define THINNEST 1000.0 /* an ellipsoid is at most so many times as long as it is thick */

static enum status check_grousers(const struct deform_shape *shape)
{
	if (shape->grousers < 0 || shape->grousers > GROUSERS_MAX)
		return fail_with(STATUS_INPUT, "wheel: %d lugs; give 0 to %d", shape->grousers, GROUSERS_MAX);
	if (shape->grousers > 0 && (!(shape->grouser_height > 0) || !(shape->grouser_thickness > 0)))
		return fail_with(STATUS_INPUT, "wheel: its lugs have no size; give lug_height and lug_thickness above 0");
	double room = 2 * M_PI * shape->radius / (shape->grousers > 0 ? shape->grousers : 1);
	if (shape->grousers > 0 && shape->grouser_thickness > room)
		return fail_with(STATUS_INPUT, "wheel: %d lugs %g m thick do not fit around it; give at most %s m", shape->grousers,
				 shape->grouser_thickness, number_at_most(room, 6).text);
	return STATUS_OK;
}

/* Returns a mesh's width in any attitude, counted from its origin, metres. Windows are cut around the origin. */
static double mesh_across(const struct deform_mesh *mesh)
{
	double squares = 0;
	for (int k = 0; k < 3; k++) {
		double far = fmax(fabs(mesh->low[k]), fabs(mesh->high[k]));
		squares += far * far;
	}
	return 2 * sqrt(squares);
}

enum status deform_shape_check(const struct deform_shape *shape, double spacing)
{
	double least = 2 * shape->radius, most = 2 * shape->radius;
	enum status status = shape->kind == DEFORM_WHEEL ? check_grousers(shape) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	if (shape->kind == DEFORM_WHEEL) {
		least = fmin(least, shape->width);
		most = hypot(2 * deform_body_wheel_radius(shape), shape->width);
	} else if (shape->kind == DEFORM_MESH) {
		least = most = mesh_across(shape->mesh); /* a flat mesh has no thickness, and still is a surface */
	} else if (shape->kind == DEFORM_BOX) {
		least = fmin(fmin(shape->size[0], shape->size[1]), shape->size[2]);
		most = hypot(hypot(shape->size[0], shape->size[1]), shape->size[2]);
	}
	if (shape->kind == DEFORM_CYLINDER || shape->kind == DEFORM_CAPSULE) {
		least = shape->kind == DEFORM_CYLINDER ? fmin(least, shape->length) : least;
		most = 2 * deform_shape_bound(shape);
	} else if (shape->kind == DEFORM_ELLIPSOID) {
		least = 2 * fmin(fmin(shape->size[0], shape->size[1]), shape->size[2]);
		most = 2 * deform_shape_bound(shape);
		if (most > THINNEST * least)
			return fail_with(STATUS_INPUT, "ellipsoid: radii of %g and %g m are too different; give radii of which none is more than %g times "
					 "another", least / 2, most / 2, THINNEST);
	}
	double limit = fmin((DEFORM_WINDOW_POSTS - 32) * 3 * spacing, SIZE_MAX_METRES);
	if (!(least > 0))
		return fail_with(STATUS_INPUT, "shape: it has no width; give sizes above 0");
	if (most > limit)
		return fail_with(STATUS_INPUT, "shape: %g m across is too large for posts %g m apart; give at most %s m, or a "
					       "coarser spacing%s",
				 most, spacing, number_at_most(limit, 6).text, most > LARGE ? "; the unit of a size is m: if it is in mm, give thousandths of it" : "");
	return STATUS_OK;
}

bool deform_shape_runs(const struct deform_shape *shape)
{
	return shape->kind == DEFORM_WHEEL || shape->belt;
}

double deform_shape_ran(const struct deform_shape *shape, double turned)
{
	if (shape->kind == DEFORM_WHEEL)
		return shape->radius * turned;
	return shape->belt ? turned : 0;
}

double deform_shape_bound(const struct deform_shape *shape)
{
	switch (shape->kind) {
	case DEFORM_WHEEL:
		return hypot(deform_body_wheel_radius(shape), shape->width / 2);
	case DEFORM_BOX:
		return hypot(hypot(shape->size[0], shape->size[1]), shape->size[2]) / 2;
	case DEFORM_MESH:
		return mesh_across(shape->mesh) / 2;
	case DEFORM_CYLINDER:
		return hypot(shape->radius, shape->length / 2);
	case DEFORM_CAPSULE:
		return shape->radius + shape->length / 2;
	case DEFORM_ELLIPSOID:
		return fmax(fmax(shape->size[0], shape->size[1]), shape->size[2]);
	case DEFORM_SPHERE:
	case DEFORM_SHAPES:
		break;
	}
	return shape->radius;
}

double deform_shape_reach(const struct deform_shape *shape, double pitch, double roll)
{
	if (shape->kind == DEFORM_MESH)
		return deform_mesh_reach(shape->mesh, pitch, roll);
	double axes[3][3];
	switch (shape->kind) {
	case DEFORM_WHEEL: /* its pitch does not count */
		return (shape->radius + (shape->grousers > 0 ? shape->grouser_height : 0)) * fabs(cos(roll)) + shape->width / 2 * fabs(sin(roll));
	case DEFORM_BOX:
		deform_body_axes(shape->size, 0, pitch, roll, axes);
		return fabs(axes[0][2]) + fabs(axes[1][2]) + fabs(axes[2][2]);
	case DEFORM_ELLIPSOID:
		deform_body_axes(shape->size, 0, pitch, roll, axes); /* half of its half axes */
		return 2 * hypot(hypot(axes[0][2], axes[1][2]), axes[2][2]);
	case DEFORM_CYLINDER:
	case DEFORM_CAPSULE:
		deform_axes(0, pitch, roll, 0, axes);
		return fabs(axes[2][2]) * shape->length / 2 +
		       shape->radius * (shape->kind == DEFORM_CAPSULE ? 1 : hypot(axes[2][0], axes[2][1]));
	case DEFORM_SPHERE:
	case DEFORM_MESH:
	case DEFORM_SHAPES:
		break;
	}
	return shape->radius;
}

bool deform_is_contact_only(const struct deform_contact *contact)
{
	int64_t rise = contact->to.z - contact->from.z;
	return (contact->to.x == contact->from.x && contact->to.y == contact->from.y && rise == 0) || rise > BODY_RISE_MAX ||
	       rise < -BODY_RISE_MAX;
}

bool deform_is_swept(const struct deform *deform, const struct deform_contact *contact)
{
	const struct deform_pose *from = &contact->from, *to = &contact->to;
	double turned = fabs(remainder(to->yaw - from->yaw, 2 * M_PI)) + fabs(to->pitch - from->pitch) + fabs(to->roll - from->roll);
	if (!deform_is_contact_only(contact))
		return turned * deform_shape_bound(contact->shape) <= deform->spacing;
	return turned == 0 && to->turn == from->turn && to->x == from->x && to->y == from->y && to->z == from->z;
}

/* Finds the posts between a and b, `extent` metres more on both sides, with one post to spare for rounding. */
static void span(const struct deform *deform, int64_t a, int64_t b, double extent, int64_t *first, int64_t *last)
{
	double low = lattice_offset_metres(a < b ? a : b) - extent, high = lattice_offset_metres(a > b ? a : b) + extent;
	*first = (int64_t)floor(low / deform->spacing);
	*last = (int64_t)ceil(high / deform->spacing) + 1;
}

static struct post_rect grown(struct post_rect rect, int64_t by)
{
	return (struct post_rect){rect.x0 - by, rect.y0 - by, rect.x1 + by, rect.y1 + by};
}

static int64_t floor_to(int64_t v, int64_t step)
{
	int64_t rest = v % step;
	return v - rest - (rest < 0 ? step : 0);
}

struct post_rect deform_shadow(const struct deform *deform, const struct deform_contact *contact)
{
	const struct deform_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	double extent[2];
	struct post_rect shadow;
	deform_body_extent(contact->shape, &contact->to, extent);
	span(deform, from->x, contact->to.x, extent[0], &shadow.x0, &shadow.x1);
	span(deform, from->y, contact->to.y, extent[1], &shadow.y0, &shadow.y1);
	return shadow;
}

static struct post_rect world_of(const struct deform *deform)
{
	return (struct post_rect){0, 0, extent_posts(deform->params.extent->width, deform->params.level),
				  extent_posts(deform->params.extent->height, deform->params.level)};
}

/* Returns the posts below the object, and those around them that soil beside it may slide to. */
static struct post_rect below(const struct deform *deform, const struct deform_contact *contact)
{
	return post_rect_intersect(grown(deform_shadow(deform, contact), deform->reach), world_of(deform));
}

struct post_rect deform_reached(const struct deform *deform, const struct deform_contact *contact)
{
	struct post_rect rect = deform_shadow(deform, contact);
	if (deform_conserves(deform->params.model))
		rect = deform_spread_posts(deform, contact, rect);
	return post_rect_intersect(grown(rect, deform->reach), world_of(deform));
}

bool deform_covers(const struct deform *deform, const struct deform_contact *contact, const struct deform_pose *rest)
{
	const struct deform_contact standing = {.shape = contact->shape, .from = *rest, .to = *rest};
	struct post_rect held = post_rect_intersect(grown(deform_shadow(deform, &standing), deform_slide_step(deform)), world_of(deform));
	struct post_rect all = deform_reached(deform, contact);
	return post_rect_empty(held) || (held.x0 >= all.x0 && held.y0 >= all.y0 && held.x1 <= all.x1 && held.y1 <= all.y1);
}

int64_t deform_contact_reach(const struct deform *deform, const struct deform_shape *shape)
{
	/* A band of soil is laid along the sides of a rectangle around the object, which may lie aslant. */
	const double band = M_SQRT2 * deform_spread_band(deform, shape), bound = deform_shape_bound(shape) / deform->spacing;
	return (int64_t)ceil(bound + band) + 3 + deform->reach + deform->border;
}

int64_t deform_reach(const struct deform_params *params)
{
	if (deform_conserves(params->model))
		return params->iterations + 2; /* displaced soil is deposited beside the object, then slides by a post an iteration */
	return deform_model_row(params->model)->smooths ? params->box_radius : 0;
}

int64_t deform_border(const struct deform_params *params)
{
	if (deform_conserves(params->model))
		return 1; /* sliding reads the heights of the neighbours */
	/* Each repetition makes `box_radius` more posts along the border wrong. */
	return deform_model_row(params->model)->smooths ? (int64_t)params->box_radius * params->box_repetitions : 0;
}

int64_t deform_core(const struct deform_params *params)
{
	return DEFORM_WINDOW_POSTS - 2 * deform_border(params);
}

static bool fits(struct post_rect rect, int64_t most)
{
	return rect.x1 - rect.x0 <= most && rect.y1 - rect.y0 <= most;
}

bool deform_fits_window(const struct deform *deform, const struct deform_contact *contact)
{
	return fits(below(deform, contact), deform_core(&deform->params));
}

static enum status too_large(struct post_rect write)
{
	return fail_with(STATUS_INPUT, "shape: its footprint of %lld x %lld posts needs more than %d windows; make it smaller or the "
				       "spacing coarser",
			 (long long)(write.x1 - write.x0), (long long)(write.y1 - write.y0), DEFORM_WINDOWS_MAX);
}

/* Soil goes from post to post over the whole contact. So the parts of a model that conserves soil are computed as one, and where
 * they are cut does not matter. Windows of other models are computed alone. They are cut at multiples of the core. So cuts depend
 * on the terrain alone, not on the object or the tiles. */
static enum status cut(const struct deform *deform, const struct deform_contact *contact, struct deform_window *windows,
		       size_t *count)
{
	*count = 0;
	struct post_rect write = deform_reached(deform, contact), under = below(deform, contact);
	if (post_rect_empty(write))
		return STATUS_OK;
	int64_t core = deform_core(&deform->params);
	if (contact->load > 0 && !fits(under, core))
		return fail_with(STATUS_INPUT, "load: an object of %lld x %lld posts is too large for one; give sink instead, or a "
					       "coarser spacing than %g m",
				 (long long)(under.x1 - under.x0), (long long)(under.y1 - under.y0), deform->spacing);
	bool one = fits(write, core), whole = deform_conserves(deform->params.model);
	if (whole && !fits(grown(write, deform->border), DEFORM_WHOLE_POSTS))
		return too_large(write);
	int64_t x0 = one || whole ? write.x0 : floor_to(write.x0, core), y0 = one || whole ? write.y0 : floor_to(write.y0, core);
	for (int64_t y = y0; y < write.y1; y += core)
		for (int64_t x = x0; x < write.x1; x += core) {
			if (*count == DEFORM_WINDOWS_MAX)
				return too_large(write);
			struct deform_window *window = &windows[*count];
			*window = (struct deform_window){.part = (uint32_t)(*count)++};
			window->write = post_rect_intersect(write, (struct post_rect){x, y, x + core, y + core});
			window->read = grown(window->write, deform->border);
		}
	for (size_t i = 0; whole && *count > 1 && i < *count; i++) {
		windows[i].whole = write;
		windows[i].parts = (uint32_t)*count;
	}
	return STATUS_OK;
}

enum status deform_cut(const struct deform_params *params, const struct deform_contact *contact,
		       struct deform_window *windows, size_t *count)
{
	const struct deform deform = {
		.params = *params,
		.spacing = extent_spacing(params->extent, params->level),
		.reach = deform_reach(params),
		.border = deform_border(params),
	};
	return cut(&deform, contact, windows, count);
}

enum status deform_windows(struct deform *deform, const struct deform_contact *contact,
			   struct deform_window *windows, size_t *count)
{
	enum status status = cut(deform, contact, windows, count);
	if (status != STATUS_OK || *count == 0)
		return status;
	if (windows[0].parts == 0)
		return deform_need_layers(deform, (uint32_t)*count, SIDE);
	struct post_rect read = deform_whole(deform, &windows[0]).read;
	uint32_t side = SIDE;
	while (!fits(read, side))
		side *= 2;
	return deform_need_layers(deform, 1, side);
}

size_t deform_windows_computed(const struct deform_window *windows, size_t count)
{
	return count > 0 && windows[0].parts > 0 ? 1 : count;
}

struct deform_window deform_whole(const struct deform *deform, const struct deform_window *window)
{
	struct deform_window whole = *window;
	if (window->parts > 0) {
		whole.write = window->whole;
		whole.read = grown(window->whole, deform->border);
	}
	return whole;
}
