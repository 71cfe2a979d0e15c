/* Which posts a contact can change, and the windows they are worked on in. */
#include <math.h>

#include "deform/shape/body.h"
#include "deform/internal.h"

/* Heights within an object are int32 fixed-point units: its half and what a contact may rise must fit. */
#define SIZE_MAX_METRES 512.0
#define LUGS_MAX 360

static enum status check_lugs(const struct deform_shape *shape)
{
	if (shape->lugs < 0 || shape->lugs > LUGS_MAX)
		return fail_with(STATUS_INPUT, "wheel: %d lugs; give 0 to %d", shape->lugs, LUGS_MAX);
	if (shape->lugs > 0 && (!(shape->lug_height > 0) || !(shape->lug_thickness > 0)))
		return fail_with(STATUS_INPUT, "wheel: its lugs have no size; give lug_height and lug_thickness above 0");
	double room = 2 * M_PI * shape->radius / (shape->lugs > 0 ? shape->lugs : 1);
	if (shape->lugs > 0 && shape->lug_thickness > room)
		return fail_with(STATUS_INPUT, "wheel: %d lugs %g m thick do not fit around it; give at most %g m", shape->lugs,
				 shape->lug_thickness, room);
	return STATUS_OK;
}

/* Across in any attitude, about its origin: windows are cut around that. */
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
	enum status status = shape->kind == DEFORM_WHEEL ? check_lugs(shape) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	if (shape->kind == DEFORM_WHEEL) {
		least = fmin(least, shape->width);
		most = hypot(2 * deform_body_wheel_radius(shape), shape->width);
	} else if (shape->kind == DEFORM_MESH) {
		least = most = mesh_across(shape->mesh); /* a sheet has no thickness, and is a surface */
	} else if (shape->kind == DEFORM_BOX) {
		least = fmin(fmin(shape->size[0], shape->size[1]), shape->size[2]);
		most = hypot(hypot(shape->size[0], shape->size[1]), shape->size[2]);
	}
	double limit = fmin((DEFORM_WINDOW_POSTS - 32) * 3 * spacing, SIZE_MAX_METRES);
	if (!(least > 0))
		return fail_with(STATUS_INPUT, "shape: it has no width; give sizes above 0");
	if (most > limit)
		return fail_with(STATUS_INPUT, "shape: %g m across is too large for posts %g m apart; give at most %g m, or a "
					       "coarser spacing",
				 most, spacing, limit);
	return STATUS_OK;
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
	if (shape->kind != DEFORM_BOX)
		return shape->radius + (shape->kind == DEFORM_WHEEL && shape->lugs > 0 ? shape->lug_height : 0);
	double axes[3][3];
	deform_body_axes(shape->size, 0, pitch, roll, axes);
	return fabs(axes[0][2]) + fabs(axes[1][2]) + fabs(axes[2][2]);
}

bool deform_is_contact_only(const struct deform_sweep *sweep)
{
	int64_t rise = sweep->to.z - sweep->from.z;
	return (sweep->to.x == sweep->from.x && sweep->to.y == sweep->from.y && rise == 0) || rise > BODY_RISE_MAX ||
	       rise < -BODY_RISE_MAX;
}

/* First post at or above, last at or below, with one to spare for rounding. */
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

struct post_rect deform_shadow(const struct deform *deform, const struct deform_sweep *sweep)
{
	const struct deform_pose *from = deform_is_contact_only(sweep) ? &sweep->to : &sweep->from;
	double extent[2];
	struct post_rect shadow;
	deform_body_extent(sweep->shape, &sweep->to, extent);
	span(deform, from->x, sweep->to.x, extent[0], &shadow.x0, &shadow.x1);
	span(deform, from->y, sweep->to.y, extent[1], &shadow.y0, &shadow.y1);
	return shadow;
}

struct post_rect deform_reached(const struct deform *deform, const struct deform_sweep *sweep)
{
	const struct post_rect extent = {0, 0, extent_posts(deform->params.extent->width, deform->params.level),
					extent_posts(deform->params.extent->height, deform->params.level)};
	return post_rect_intersect(grown(deform_shadow(deform, sweep), deform->reach), extent);
}

bool deform_covers(const struct deform *deform, const struct deform_sweep *sweep, const struct deform_pose *rest)
{
	const struct deform_sweep standing = {.shape = sweep->shape, .from = *rest, .to = *rest};
	const struct post_rect extent = {0, 0, extent_posts(deform->params.extent->width, deform->params.level),
					extent_posts(deform->params.extent->height, deform->params.level)};
	struct post_rect held = post_rect_intersect(grown(deform_shadow(deform, &standing), deform_slide_step(deform)), extent);
	struct post_rect all = deform_reached(deform, sweep);
	return post_rect_empty(held) || (held.x0 >= all.x0 && held.y0 >= all.y0 && held.x1 <= all.x1 && held.y1 <= all.y1);
}

int64_t deform_reach(const struct deform_params *params)
{
	if (deform_conserves(params->model))
		return params->iterations + 2; /* what is pressed is laid down beside it, and slides on by a post an iteration */
	return deform_model_row(params->model)->smooths ? params->box_radius : 0;
}

int64_t deform_border(const struct deform_params *params)
{
	if (deform_conserves(params->model))
		return 1; /* whose heights are looked at */
	/* A window's posts are right as far in as wrong ones from beyond its rim can reach. */
	return deform_model_row(params->model)->smooths ? (int64_t)params->box_radius * params->box_repetitions : 0;
}

int64_t deform_core(const struct deform_params *params)
{
	return DEFORM_WINDOW_POSTS - 2 * deform_border(params);
}

bool deform_fits_window(const struct deform *deform, struct post_rect reached)
{
	return reached.x1 - reached.x0 <= deform_core(&deform->params) && reached.y1 - reached.y0 <= deform_core(&deform->params);
}

static enum status cut(const struct deform *deform, const struct deform_sweep *sweep, struct deform_window *windows,
		       size_t *count)
{
	*count = 0;
	if (sweep->shape->kind == DEFORM_WHEEL && sweep->to.roll != 0)
		return fail_with(STATUS_INPUT, "wheel: its axis lies level, and its pose has it rolled by %g rad; give roll 0",
				 sweep->to.roll);
	struct post_rect write = deform_reached(deform, sweep);
	if (post_rect_empty(write))
		return STATUS_OK;
	/* Cut on multiples of the core, so that the cuts are the terrain's, not the object's or the tiles'. */
	int64_t core = deform_core(&deform->params);
	bool one = deform_fits_window(deform, write);
	if (!one && sweep->load > 0)
		return fail_with(STATUS_INPUT, "load: an object of %lld x %lld posts is too large for one; give sink instead, or a "
					       "coarser spacing than %g m",
				 (long long)(write.x1 - write.x0), (long long)(write.y1 - write.y0), deform->spacing);
	int64_t x0 = one ? write.x0 : floor_to(write.x0, core), y0 = one ? write.y0 : floor_to(write.y0, core);
	for (int64_t y = y0; y < write.y1; y += core)
		for (int64_t x = x0; x < write.x1; x += core) {
			if (*count == DEFORM_WINDOWS_MAX)
				return fail_with(STATUS_INPUT, "shape: its footprint of %lld x %lld posts needs more than %d windows; "
							       "make it smaller or the spacing coarser",
						 (long long)(write.x1 - write.x0), (long long)(write.y1 - write.y0),
						 DEFORM_WINDOWS_MAX);
			struct deform_window *window = &windows[(*count)++];
			window->write = post_rect_intersect(write, (struct post_rect){x, y, x + core, y + core});
			window->read = grown(window->write, deform->border);
		}
	return STATUS_OK;
}

enum status deform_cut(const struct deform_params *params, const struct deform_sweep *sweep,
		       struct deform_window *windows, size_t *count)
{
	const struct deform deform = {
		.params = *params,
		.spacing = extent_spacing(params->extent, params->level),
		.reach = deform_reach(params),
		.border = deform_border(params),
	};
	return cut(&deform, sweep, windows, count);
}

enum status deform_windows(struct deform *deform, const struct deform_sweep *sweep,
			   struct deform_window *windows, size_t *count)
{
	enum status status = cut(deform, sweep, windows, count);
	return status == STATUS_OK && *count > 0 ? deform_need_layers(deform, (uint32_t)*count) : status;
}
