/*
 * The soil contact model of Krenn and Hirzinger (2009): Bekker's pressure and sinkage, elastic rebound, Janosi and
 * Hanamoto's shear; what is displaced is laid beside and slides to its angle of repose.
 */
#include <math.h>

#include "deform/shape/body.h"
#include "deform/internal.h"

struct gpu_rect deform_rows(const int32_t posts[4])
{
	/* Of no rows the first invocations find nothing to do: a window's passes are as many wherever it lies. */
	uint32_t rows = posts[3] > posts[1] ? (uint32_t)(posts[3] - posts[1]) : 1;
	return (struct gpu_rect){0, 0, DEFORM_ROWS_ABREAST, (rows + DEFORM_ROWS_ABREAST - 1) / DEFORM_ROWS_ABREAST};
}

/* 1 / b; 0: it follows from the posts that the object touches. */
static double by_width(const struct deform_shape *shape, const double extent[2], bool counted)
{
	if (shape->kind == DEFORM_WHEEL)
		return 1 / shape->width;
	if (shape->kind == DEFORM_BOX)
		return 1 / fmin(shape->size[0], shape->size[1]);
	/* Too large to count in one place: as if all of its shadow touched. */
	double shadow = shape->kind == DEFORM_SPHERE ? M_PI * shape->radius * shape->radius : 4 * extent[0] * extent[1];
	return counted ? 0 : 1 / sqrt(shadow / M_PI);
}

/* A reciprocal that is a number in single precision too, and small enough to be multiplied. */
static float inverse(double value)
{
	return (float)fmin(1 / value, 1e30);
}

/* A power of two that no post it touches is farther from its centre than, about: moments are counted in it. */
static double arm_of(const struct deform_shape *shape, const double extent[2])
{
	return exp2(ceil(log2(hypot(hypot(extent[0], extent[1]), deform_shape_reach(shape, 0, 0)))));
}

static void fill_motion(const struct deform_sweep *sweep, struct scm_params *params)
{
	if (deform_is_contact_only(sweep))
		return;
	params->way[0] = (float)lattice_offset_metres(sweep->to.x - sweep->from.x);
	params->way[1] = (float)lattice_offset_metres(sweep->to.y - sweep->from.y);
	params->way[2] = (float)lattice_offset_metres(sweep->to.z - sweep->from.z);
	params->way[3] = sweep->seconds > 0 ? (float)(1 / sweep->seconds) : 0;
	/* About the wheel's own y, which lies level. */
	params->spin[0] = (float)(-sin(sweep->to.yaw) * sweep->turned);
	params->spin[1] = (float)(cos(sweep->to.yaw) * sweep->turned);
	/* Damping is of the rate at which soil is pressed: a smooth wheel that spins presses none the faster. */
	double turned = sweep->shape->kind == DEFORM_WHEEL ? (params->way[0] * cos(sweep->to.yaw) + params->way[1] * sin(sweep->to.yaw)) /
								     sweep->shape->radius
							   : 0;
	params->rolls[0] = (float)(-sin(sweep->to.yaw) * turned);
	params->rolls[1] = (float)(cos(sweep->to.yaw) * turned);
}

static void fill_soils(const struct deform_params *params, struct scm_soil *soils)
{
	for (int i = 0; i < params->soil_count; i++) {
		const struct deform_soil *s = &params->soils[i];
		soils[i] = (struct scm_soil){
			.a = {(float)s->bekker_kc, (float)s->bekker_kphi, (float)s->bekker_n, inverse(s->elastic_stiffness)},
			.b = {(float)s->cohesion, (float)tan(s->friction_angle), inverse(s->janosi_shear), (float)s->damping},
		};
	}
}

/* Metres: no load presses an object deeper than it is high. A mesh's centre may lie anywhere in it. */
static double deepest(const struct deform_sweep *sweep)
{
	const struct deform_shape *shape = sweep->shape;
	return 2 * (shape->kind == DEFORM_MESH ? deform_shape_bound(shape)
					       : deform_shape_reach(shape, sweep->to.pitch, sweep->to.roll));
}

static struct scm_params params_of(const struct deform *deform, const struct deform_sweep *sweep,
				   const struct deform_window *window, uint32_t layer, const double extent[2])
{
	const struct gpu_rect written = deform_written(window);
	int64_t zero = sweep->to.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	int64_t base = zero >> (OFFSET_BITS - BASE_BITS);
	base = base < INT32_MIN + 1 ? INT32_MIN + 1 : base > INT32_MAX ? INT32_MAX : base;
	double spacing = deform->spacing;
	struct scm_params params = {
		.zero = {(int32_t)base, (int32_t)(zero & 3), (int32_t)layer},
		.written = {(int32_t)written.x, (int32_t)written.y, (int32_t)(written.x + written.width),
			    (int32_t)(written.y + written.height)},
		.scale = {(float)(ldexp(1, -OFFSET_BITS) / spacing), (float)spacing, DEFORM_UNITS_A_PASCAL},
		.spin = {[3] = (float)deform->params.bulldozing},
		.place = {(float)-deform_body_from_post(sweep->to.x, window->read.x0, spacing),
			  (float)-deform_body_from_post(sweep->to.y, window->read.y0, spacing), (float)(1 / arm_of(sweep->shape, extent)),
			  (float)(spacing * spacing)},
		.load = {(float)fmax(sweep->load, 1e-6), (float)fmin(ldexp(deepest(sweep), OFFSET_BITS), 0x1p28), (float)sweep->loaded_body},
	};
	struct post_rect shadow = post_rect_intersect(deform_shadow(deform, sweep), window->write);
	if (!post_rect_empty(shadow)) {
		const int64_t sides[4] = {shadow.x0 - window->read.x0, shadow.y0 - window->read.y0, shadow.x1 - window->read.x0,
					  shadow.y1 - window->read.y0};
		for (int i = 0; i < 4; i++)
			params.shadow[i] = (int32_t)sides[i];
	}
	fill_motion(sweep, &params);
	fill_soils(&deform->params, params.soils);
	return params;
}

static enum status press(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			 uint32_t layer, struct gpu_buffer *tally)
{
	double extent[2];
	deform_body_extent(sweep->shape, &sweep->to, extent);
	struct scm_params params = params_of(deform, sweep, window, layer, extent);
	bool counted = deform_is_counted(&deform->params, sweep->shape, sweep->load > 0) &&
		       deform_fits_window(deform, deform_reached(deform, sweep));
	params.scale[3] = (float)by_width(sweep->shape, extent, counted);
	unsigned with = (sweep->tag != 0 ? WITH_FORCES : 0) | (params.scale[3] == 0 ? WITH_PATCH : 0) |
			(sweep->load > 0 ? WITH_LOAD : 0);
	struct gpu_buffer *records = NULL;
	uint32_t record = 0;
	int last = 0;
	struct deform_request request;
	deform_programs_press(&deform->params, with, &request);
	enum status status = deform_program(deform, &request, &deform->scm[with]);
	if (status == STATUS_OK && (with & (WITH_PATCH | WITH_LOAD)))
		status = deform_find(deform, &params, layer, with / WITH_PATCH, &last);
	if (status == STATUS_OK && (with & WITH_FORCES))
		status = deform_forces_record(deform, sweep, layer == 0, arm_of(sweep->shape, extent), &records, &record);
	if (status != STATUS_OK)
		return status;
	params.zero[3] = (int32_t)record | last << 16;
	gpu_texture_clear(deform->contacts, layer, deform_written(window), 0);
	gpu_texture_clear(deform->carried, layer, deform_written(window), 0);
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_CONTACT,
		.program = deform->scm[with],
		.target = deform->scratch[layer].to[TO_BARE],
		.viewport = deform_rows(params.written),
		.textures = {deform->under, deform->classes},
		.images = {deform->bases, deform->planes_of[1][PLANE_DEPOSITED], deform->rest, deform->planes_of[1][PLANE_OFFSET],
			   deform->planes_of[0][PLANE_PLASTIC_SINKAGE], deform->planes_of[0][PLANE_SHEAR], deform->contacts,
			   deform->carried},
		.storage = {tally, records, deform->tries, deform->standing},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

enum status deform_scm_feel(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window, uint32_t layer)
{
	deform->scratch[layer].now[PLANE_OFFSET] = deform->scratch[layer].now[PLANE_DEPOSITED] = 1;
	return press(deform, sweep, window, layer, deform->felt);
}

enum status deform_scm(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
		       uint32_t layer)
{
	deform->scratch[layer].now[PLANE_OFFSET] = deform->scratch[layer].now[PLANE_DEPOSITED] = 1;
	enum status status = press(deform, sweep, window, layer, deform->tally);
	if (status == STATUS_OK)
		status = deform_spread(deform, window, layer);
	if (status == STATUS_OK)
		status = deform_slide(deform, window, layer);
	return status;
}
