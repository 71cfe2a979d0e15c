/*
 * Lays down the soil that an object displaces: from `carried` into `deposits`, in bands beside the patch that the object touches
 * (SOIL.md, "Laying"). All lengths are metres: they come from the object, its motion and the depth, not from the posts.
 */
#include <math.h>
#include <string.h>

#include "soil/shape/body.h"
#include "deform/internal.h"

#define STEEPEST_TAN 1.0        /* steeper soil is laid as if it stood at 45 degrees */
#define ONE 65536.0
#define FARTHEST 8192.0         /* posts: more than a window has */

enum { AHEAD, BEHIND, LEFT, RIGHT, FACES };

/* How an object lays soil: all around its patch, or beside the faces of a rectangle around its patch. */
struct laying {
	bool around;
	double heading;       /* rad: of the rectangle */
	double shares[FACES]; /* of the soil */
	double along;         /* share of the patch's length, beside its width, in the width of a band */
	double rolls;         /* share of the soil that is not pushed */
	double behind;        /* length_behind */
};

/* Computes by how much of its way an object pushes soil ahead of itself: forwards and to the left, each -1 .. 1. A wheel that rolls
 * pushes none ahead, a locked one as a sledge does. So does a belt. */
static void push_of(const struct deform_contact *contact, double way, double forward, double aside, double push[2])
{
	push[0] = push[1] = 0;
	if (way == 0)
		return;
	double turned = soil_shape_ran(contact->shape, contact->turned);
	bool braked = forward * turned >= 0 && fabs(turned) < fabs(forward);
	push[0] = braked ? (forward - turned) / way : 0;
	push[1] = aside / way;
}

/* A wheel that goes on lays its soil beside itself, from a whole to five eighths of its radius behind its axle. Laid farther ahead, it would slide in
 * front of the wheel. The more it moves sideways, the farther ahead it lays too. If it hardly goes on, it lays all along its patch. Returns the
 * length, metres, below 0 if the wheel rolls backwards; 0: all along. */
static double length_behind(const struct soil_shape *shape, double spacing, double forward, double aside, double down)
{
	double way = hypot(forward, aside);
	if (way == 0 || fabs(down) > way)
		return 0;
	double length = fmax(fmax(fabs(forward), spacing), 0.375 * shape->radius) + aside * aside / (way * way) * shape->radius;
	return copysign(length, forward);
}

/* Half of the pushed soil goes ahead, half aside. So a heap ahead stops growing at about the height that the cut is deep. */
static struct laying laying_of(const struct deform_contact *contact, double spacing)
{
	double dx = lattice_offset_metres(contact->to.x - contact->from.x), dy = lattice_offset_metres(contact->to.y - contact->from.y);
	double dz = lattice_offset_metres(contact->to.z - contact->from.z), way = hypot(dx, dy), push[2] = {1, 0};
	struct laying laying = {.heading = contact->to.yaw};
	if (deform_is_contact_only(contact))
		way = 0;
	const bool wheel = contact->shape->kind == SOIL_WHEEL;
	if (wheel || (contact->shape->belt && (way > fabs(dz) || contact->turned != 0))) {
		double ahead[2] = {cos(laying.heading), sin(laying.heading)};
		double forward = dx * ahead[0] + dy * ahead[1], aside = dy * ahead[0] - dx * ahead[1];
		push_of(contact, way, forward, aside, push);
		laying.behind = wheel && way > 0 ? length_behind(contact->shape, spacing, forward, aside, dz) : 0;
	} else if (way > fabs(dz)) {
		laying.heading = atan2(dy, dx);
	} else {
		laying.around = true;
		laying.heading = 0;
		push[0] = 0;
	}
	double along = push[0] * push[0], across = push[1] * push[1], rolls = fmax(0, 1 - along - across);
	laying.along = across;
	laying.rolls = rolls;
	for (int face = 0; face < FACES; face++)
		laying.shares[face] = face < LEFT ? across / 4 : rolls / 2 + along / 4;
	laying.shares[push[0] > 0 ? AHEAD : BEHIND] += along / 2;
	laying.shares[push[1] > 0 ? LEFT : RIGHT] += across / 2;
	return laying;
}

/* Returns the widest band of an object, metres. */
static double widest(const struct soil_shape *shape)
{
	double x = shape->size[0], y = shape->size[1], z = shape->size[2];
	switch (shape->kind) {
	case SOIL_WHEEL:
		return shape->width;
	case SOIL_BOX: /* the middle one of its sizes: a plate may lie or stand */
		return fmax(fmin(x, y), fmin(fmax(x, y), z));
	case SOIL_ELLIPSOID: /* twice its middle half axis, halved */
		return fmax(fmin(x, y), fmin(fmax(x, y), z));
	case SOIL_MESH:
		return soil_shape_bound(shape) / 2;
	case SOIL_SPHERE:
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
	case SOIL_SHAPES:
		break;
	}
	return shape->radius;
}

static double band_posts(const struct deform *deform, const struct soil_shape *shape)
{
	return fmin(fmax(widest(shape) / deform->spacing, 2), DEFORM_BAND_POSTS);
}

double deform_spread_band(const struct deform *deform, const struct soil_shape *shape)
{
	return deform_conserves(deform->params.model) ? band_posts(deform, shape) : 0;
}

/* Returns how far from a wheel's axle, along it, soil is laid beside the wheel, metres. A wheel that goes on lays it behind only. */
static double beside(const struct soil_shape *shape, const struct laying *laying)
{
	return laying->behind != 0 ? shape->radius : shape->radius / 2;
}

/* Widens `rect` by places of the object's frame: x from first to last, y from -far to far, metres. */
static struct post_rect with_band(struct post_rect rect, const struct deform_contact *contact, double heading, double spacing, double first,
				  double last, double far)
{
	double c = cos(heading), s = sin(heading), middle[2] = {(first + last) / 2 * c, (first + last) / 2 * s};
	double half[2] = {(last - first) / 2 * fabs(c) + far * fabs(s), (last - first) / 2 * fabs(s) + far * fabs(c)};
	double x = lattice_offset_metres(contact->to.x) + middle[0], y = lattice_offset_metres(contact->to.y) + middle[1];
	const struct post_rect band = {(int64_t)floor((x - half[0]) / spacing), (int64_t)floor((y - half[1]) / spacing),
				       (int64_t)ceil((x + half[0]) / spacing) + 1, (int64_t)ceil((y + half[1]) / spacing) + 1};
	return post_rect_around(rect, band);
}

/* Returns the shadow of a wheel and the posts on which it may lay soil. */
static struct post_rect wheel_posts(const struct deform_contact *contact, const struct laying *laying, double spacing, double band,
				    struct post_rect shadow)
{
	const struct soil_shape *shape = contact->shape;
	double along = soil_body_wheel_radius(shape), across = shape->width / 2, ends = beside(shape, laying);
	double to = laying->behind != 0 ? fmin(fabs(laying->behind) - ends, ends) : ends;
	double first = laying->behind < 0 ? -to : -ends, last = laying->behind < 0 ? ends : to;
	if (laying->shares[AHEAD] + laying->shares[BEHIND] > 0)
		shadow = with_band(shadow, contact, laying->heading, spacing, -along - band, along + band, across);
	if (laying->shares[LEFT] + laying->shares[RIGHT] > 0)
		shadow = with_band(shadow, contact, laying->heading, spacing, first, last, across + band);
	return shadow;
}

struct post_rect deform_spread_posts(const struct deform *deform, const struct deform_contact *contact, struct post_rect shadow)
{
	const struct laying laying = laying_of(contact, deform->spacing);
	double spacing = deform->spacing, band = band_posts(deform, contact->shape) * spacing;
	if (contact->shape->kind == SOIL_WHEEL)
		return wheel_posts(contact, &laying, spacing, band, shadow);
	/* Around a rectangle that turns with the object. */
	double ahead[2] = {fabs(cos(laying.heading)), fabs(sin(laying.heading))}, reach[2] = {band, band};
	bool faces[2] = {laying.shares[AHEAD] + laying.shares[BEHIND] > 0, laying.shares[LEFT] + laying.shares[RIGHT] > 0};
	for (int k = 0; k < 2 && !laying.around; k++)
		reach[k] = fmax(faces[0] ? band * ahead[k] : 0, faces[1] ? band * ahead[1 - k] : 0);
	return (struct post_rect){shadow.x0 - (int64_t)ceil(reach[0] / spacing), shadow.y0 - (int64_t)ceil(reach[1] / spacing),
				  shadow.x1 + (int64_t)ceil(reach[0] / spacing), shadow.y1 + (int64_t)ceil(reach[1] / spacing)};
}

static int32_t fixed(double value)
{
	return (int32_t)lround(value * ONE);
}

/* Fills how each soil is laid. A band's cross-section is 2/9 of its width squared, times the tangent of its sides. */
static void fill_soils(const struct deform *deform, int32_t soils[SOIL_CLASSES][4])
{
	const struct deform_params *params = &deform->params;
	const struct soil_model *model = deform_model_row(params->model);
	for (int i = 0; i < params->soil_count; i++) {
		double angle = model->laid_at(&params->soils[i]), tangent = angle < M_PI / 4 ? fmax(tan(angle), 0.01) : STEEPEST_TAN;
		soils[i][0] = (int32_t)fmin(fmax(lround(4.5 * 64 * 16 / (tangent * deform->spacing)), 1), 1 << 24);
		soils[i][1] = fixed(model->laid_share(params, &params->soils[i]));
	}
}

/* Finds where the window's first post lies in the frame. It computes from the post south-west of the object's centre, in
 * whole steps of a post. So the result is the same in any window. */
static void place_frame(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			const double ahead[2], struct spread_params *params)
{
	double spacing = deform->spacing;
	int64_t x = (int64_t)floorl(soil_body_from_post(contact->to.x, 0, spacing) / spacing);
	int64_t y = (int64_t)floorl(soil_body_from_post(contact->to.y, 0, spacing) / spacing);
	double east = -(double)soil_body_from_post(contact->to.x, x, spacing) / spacing;
	double north = -(double)soil_body_from_post(contact->to.y, y, spacing) / spacing;
	int64_t by_x = x - window->read.x0, by_y = y - window->read.y0;
	params->axis[0] = fixed(ahead[0]);
	params->axis[1] = fixed(ahead[1]);
	params->origin[0] = (int32_t)(fixed(east * ahead[0] + north * ahead[1]) - by_x * params->axis[0] - by_y * params->axis[1]);
	params->origin[1] = (int32_t)(fixed(north * ahead[0] - east * ahead[1]) - by_y * params->axis[0] + by_x * params->axis[1]);
}

struct spread_params deform_spread_params(const struct deform *deform, const struct deform_contact *contact,
					  const struct deform_window *window, uint32_t layer)
{
	const struct laying laying = laying_of(contact, deform->spacing);
	const struct soil_shape *shape = contact->shape;
	const double ahead[2] = {cos(laying.heading), sin(laying.heading)};
	struct spread_params params = {
		.place = {(int32_t)layer, laying.around, (int32_t)ceil(64 * band_posts(deform, shape)), fixed(laying.rolls)},
		.origin = {0, 0, shape->kind == SOIL_WHEEL ? fixed(shape->width / 2 / deform->spacing) : 0, fixed(laying.along)},
		.axis = {0, 0, shape->kind == SOIL_WHEEL ? fixed(fmax(beside(shape, &laying) / deform->spacing, 1)) : INT32_MAX,
			 fixed(fmax(fmin(laying.behind / deform->spacing, FARTHEST), -FARTHEST))},
	};
	deform_posts_in(window, window->write, params.written);
	place_frame(deform, contact, window, ahead, &params);
	fill_soils(deform, params.soils);
	for (int face = 0; face < FACES; face++)
		params.shares[face] = laying.around ? (face == AHEAD) * (int32_t)ONE : (int32_t)(laying.shares[face] * ONE);
	struct post_rect shadow = post_rect_intersect(deform_shadow(deform, contact), window->write);
	if (!post_rect_empty(shadow))
		deform_posts_in(window, shadow, params.shadow);
	return params;
}

void deform_spread_begin(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	/* Sliding on steep ground reads the posts around those that are written, too (slide_begin.frag). */
	gpu_texture_clear(deform->deposits, layer, deform_window_rect(window), 0);
	gpu_buffer_clear(deform->laying, 0, DEFORM_LAYING_BYTES);
}

/* Runs the passes from `first` on. `batch`: over all windows of a batch. */
static enum status run(struct deform *deform, const struct spread_params *params, enum spread_pass first, uint32_t layer, bool batch)
{
	/* The heights are not used before soil slides. */
	struct gpu_texture *const images[SPREAD_PASSES][3] = {
		[SPREAD_MEASURE] = {deform->contacts, deform->carried, deform->planes_of[1][PLANE_OFFSET]},
		[SPREAD_WEIGH] = {deform->contacts, deform->heights[0], deform->deposits},
		[SPREAD_LAY] = {deform->deposits},
	};
	for (int pass = first; pass < SPREAD_PASSES; pass++) {
		struct deform_request request;
		deform_programs_spread(&deform->params, (enum spread_pass)pass, batch, &request);
		enum status status = deform_program(deform, &request, &deform->spread[batch][pass]);
		if (status != STATUS_OK)
			return status;
		struct gpu_pass spreads = {
			.stage = GPU_SPREAD,
			.program = deform->spread[batch][pass],
			.target = deform->scratch[layer].to[TO_BARE],
			.viewport = deform_rows(pass == SPREAD_MEASURE ? params->shadow : params->written),
			.textures = {[4] = pass == SPREAD_MEASURE ? deform->classes : NULL},
			.images = {images[pass][0], images[pass][1], images[pass][2], pass == SPREAD_WEIGH ? deform->bases : NULL, [7] = pass == SPREAD_MEASURE ? deform->heights[0] : NULL},
			.storage = {deform->tally, [4] = deform->laying},
			.params = params,
			.params_bytes = (size_t)((const char *)params->soils[deform_soil_slots(&deform->params)] - (const char *)params),
		};
		if (batch)
			deform_together_run(deform, TOGETHER_ALL, &spreads);
		else
			gpu_pass_run(deform->params.gpu, &spreads);
	}
	return STATUS_OK;
}

enum status deform_spread(struct deform *deform, const struct spread_params *params, const struct deform_window *window, uint32_t layer)
{
	const enum spread_pass first = deform_spread_first(deform->params.model);
	if (first == SPREAD_MEASURE)
		deform_spread_begin(deform, window, layer);
	return run(deform, params, first, layer, false);
}

enum status deform_spread_together(struct deform *deform)
{
	struct spread_params params = {.place = {0}};
	deform_together_draw(deform, TOGETHER_SPREAD, params.place);
	fill_soils(deform, params.soils);
	return run(deform, &params, SPREAD_WEIGH, 0, true);
}

void deform_spread_numbers(const struct spread_params *params, const struct gpu_rect *posts, int32_t numbers[6][4])
{
	const int32_t x = (int32_t)posts->x, y = (int32_t)posts->y;
	memcpy(numbers, params, 6 * sizeof *numbers);
	for (int k = 0; k < 4; k++) {
		numbers[1][k] += k % 2 == 0 ? x : y; /* `written` and `shadow` */
		numbers[2][k] += k % 2 == 0 ? x : y;
	}
	/* The frame's place of the layer's first post, not of the window's. */
	numbers[3][0] -= x * params->axis[0] + y * params->axis[1];
	numbers[3][1] -= y * params->axis[0] - x * params->axis[1];
}

enum status deform_spread_create(struct deform *deform)
{
	return gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_LAYING_BYTES, NULL, &deform->laying);
}

void deform_spread_plan(struct plan *plan)
{
	deform_plan_buffer(plan, "spread", 1, DEFORM_LAYING_BYTES, "laying");
}
