/* Finds the posts that a contact can change, and cuts them into windows. */
#include <math.h>

#include "soil/kinematic/sheet.h"
#include "soil/shape/affine.h"
#include "deform/internal.h"

_Static_assert(SOIL_SHAPE_POSTS == (DEFORM_WINDOW_POSTS - 32) * 3, "the widest body fits its windows");
_Static_assert(FUNCTIONAL_POSTS == DEFORM_WINDOWS_MAX * DEFORM_WINDOW_POSTS, "functionals hold over all windows of a body");

bool deform_is_contact_only(const struct deform_contact *contact)
{
	return soil_only_set_down(&contact->from, &contact->to);
}

bool deform_slides_near(const struct deform_contact *contact, double spacing)
{
	const struct soil_pose *from = &contact->from, *to = &contact->to;
	double turned = fabs(remainder(to->yaw - from->yaw, 2 * M_PI)) + fabs(to->pitch - from->pitch) + fabs(to->roll - from->roll);
	if (!deform_is_contact_only(contact))
		return turned * soil_shape_bound(contact->shape) <= spacing;
	return turned == 0 && to->turn == from->turn && to->x == from->x && to->y == from->y && to->z == from->z;
}

bool deform_is_swept(const struct deform *deform, const struct deform_contact *contact)
{
	return deform_slides_near(contact, deform->spacing);
}

static int64_t floor_to(int64_t v, int64_t step)
{
	int64_t rest = v % step;
	return v - rest - (rest < 0 ? step : 0);
}

/* Returns the posts that a body over an elastic sheet may hold down or let go of. */
static struct post_rect held_down(const struct deform *deform, const struct deform_contact *contact)
{
	const struct soil_sheet_contact own = {.body = {.shape = contact->shape, .from = contact->from, .to = contact->to}};
	return soil_sheet_posts(&own, 0, deform->spacing);
}

struct post_rect deform_shadow(const struct deform *deform, const struct deform_contact *contact)
{
	if (deform_is_elastic(deform->params.model))
		return held_down(deform, contact);
	const struct soil_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	return soil_shadow(contact->shape, from, &contact->to, deform->spacing);
}

static struct post_rect world_of(const struct deform *deform)
{
	return (struct post_rect){0, 0, extent_posts(deform->params.extent->width, deform->params.level),
				  extent_posts(deform->params.extent->height, deform->params.level)};
}

/* Returns the posts below the object, and those around them that soil beside it may slide to. */
static struct post_rect below(const struct deform *deform, const struct deform_contact *contact)
{
	return post_rect_intersect(post_rect_grown(deform_shadow(deform, contact), deform->reach), world_of(deform));
}

struct post_rect deform_reached(const struct deform *deform, const struct deform_contact *contact)
{
	struct post_rect rect = deform_shadow(deform, contact);
	if (deform_conserves(deform->params.model))
		rect = deform_spread_posts(deform, contact, rect);
	return post_rect_intersect(post_rect_grown(rect, deform->reach), world_of(deform));
}

bool deform_covers_sheet(const struct deform_contact *contact)
{
	const struct soil_pose *from = &contact->from, *to = &contact->to;
	return !soil_only_set_down(from, to) || (from->x == to->x && from->y == to->y);
}

bool deform_covers(const struct deform *deform, const struct deform_contact *contact, const struct soil_pose *rest)
{
	const struct deform_contact standing = {.shape = contact->shape, .from = *rest, .to = *rest};
	if (deform_is_elastic(deform->params.model))
		return deform_covers_sheet(contact);
	struct post_rect held = post_rect_intersect(post_rect_grown(deform_shadow(deform, &standing), deform_slide_step(deform)), world_of(deform));
	struct post_rect all = deform_reached(deform, contact);
	return post_rect_empty(held) || (held.x0 >= all.x0 && held.y0 >= all.y0 && held.x1 <= all.x1 && held.y1 <= all.y1);
}

int64_t deform_contact_reach(const struct deform *deform, const struct soil_shape *shape)
{
	/* A band of soil is laid along the sides of a rectangle around the object, which may lie aslant. */
	const double band = M_SQRT2 * deform_spread_band(deform, shape), bound = soil_shape_bound(shape) / deform->spacing;
	return (int64_t)ceil(bound + band) + 3 + deform->reach + deform->border;
}

int64_t deform_reach(const struct deform_params *params)
{
	if (deform_conserves(params->model))
		return params->iterations + 2; /* displaced soil is deposited beside the object, then slides by a post an iteration */
	if (deform_is_elastic(params->model)) /* others within the reach of what may change tell whether it does */
		return 2 * soil_sheet_reach(sqrt(params->tension / params->stiffness), extent_spacing(params->extent, params->level));
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

static enum status too_large(struct post_rect write)
{
	return fail_with(STATUS_INPUT, "shape: its footprint of %lld x %lld posts needs more than %d windows; make it smaller or the "
				       "spacing coarser",
			 (long long)(write.x1 - write.x0), (long long)(write.y1 - write.y0), DEFORM_WINDOWS_MAX);
}

/* A sheet's deflection goes some lengths far, and the work to find it grows with its length in posts. */
enum status deform_check_sheet(const struct deform_params *params)
{
	const double length = sqrt(params->tension / params->stiffness), spacing = extent_spacing(params->extent, params->level);
	if (!deform_is_elastic(params->model) || length <= SOIL_SHEET_POSTS * spacing)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "redistribute.tension: a sheet of %g N/m on %g Pa/m bends over %.4g m, which is more than %d posts of %g m; give a "
				       "coarser spacing, or a tension of at most %s N/m",
			 params->tension, params->stiffness, length, SOIL_SHEET_POSTS, spacing,
			 number_at_most(params->stiffness * SOIL_SHEET_POSTS * SOIL_SHEET_POSTS * spacing * spacing, 4).text);
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
	TRY(deform_check_sheet(&deform->params));
	int64_t core = deform_core(&deform->params);
	if (contact->load > 0 && !deform_is_elastic(deform->params.model) && !fits(under, core))
		return fail_with(STATUS_INPUT, "load: an object of %lld x %lld posts is too large for one; give sink instead, or a "
					       "coarser spacing than %g m",
				 (long long)(under.x1 - under.x0), (long long)(under.y1 - under.y0), deform->spacing);
	bool one = fits(write, core), whole = deform_conserves(deform->params.model) || deform_is_elastic(deform->params.model);
	if (whole && !fits(post_rect_grown(write, deform->border), DEFORM_WHOLE_POSTS))
		return too_large(write);
	int64_t x0 = one || whole ? write.x0 : floor_to(write.x0, core), y0 = one || whole ? write.y0 : floor_to(write.y0, core);
	for (int64_t y = y0; y < write.y1; y += core)
		for (int64_t x = x0; x < write.x1; x += core) {
			if (*count == DEFORM_WINDOWS_MAX)
				return too_large(write);
			struct deform_window *window = &windows[*count];
			*window = (struct deform_window){.part = (uint32_t)(*count)++};
			window->write = post_rect_intersect(write, (struct post_rect){x, y, x + core, y + core});
			window->read = post_rect_grown(window->write, deform->border);
		}
	for (size_t i = 0; whole && *count > 1 && i < *count; i++) {
		windows[i].whole = write;
		windows[i].parts = (uint32_t)*count;
	}
	/* A sheet reads as far again as it changes. */
	const struct post_rect changes = deform_is_elastic(deform->params.model) ? deform_sheet_changes(&deform->params, deform_shadow(deform, contact)) : write;
	for (size_t i = 0; i < *count; i++)
		windows[i].write = post_rect_intersect(windows[i].write, changes);
	return STATUS_OK;
}

enum status deform_cut(const struct deform_params *params, const struct deform_contact *contact,
		       struct deform_window *windows, size_t *count)
{
	struct deform deform; /* large: what no cut reads is not set */
	deform.params = *params;
	deform.spacing = extent_spacing(params->extent, params->level);
	deform.reach = deform_reach(params);
	deform.border = deform_border(params);
	return cut(&deform, contact, windows, count);
}

enum status deform_windows(struct deform *deform, const struct deform_contact *contact,
			   struct deform_window *windows, size_t *count)
{
	TRY(cut(deform, contact, windows, count));
	if (*count == 0)
		return STATUS_OK;
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
		whole.read = post_rect_grown(window->whole, deform->border);
	}
	return whole;
}
