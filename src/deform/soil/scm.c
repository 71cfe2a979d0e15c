/*
 * The soil contact model of Krenn and Hirzinger (2009). Pressure and sinkage are Bekker's, shear is Janosi and Hanamoto's, and
 * the soil rebounds elastically. Displaced soil is deposited around the object and slides to its angle of repose.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "soil/shape/body.h"
#include "soil/shape/lower_envelope.h"
#include "deform/internal.h"
#include "soil/stability.h"

struct gpu_rect deform_rows(const int32_t posts[4])
{
	/* Without rows the pass still runs, and its invocations do nothing. A window always runs the same number of passes. */
	uint32_t rows = posts[3] > posts[1] ? (uint32_t)(posts[3] - posts[1]) : 1;
	return (struct gpu_rect){0, 0, DEFORM_ROWS_ABREAST, (rows + DEFORM_ROWS_ABREAST - 1) / DEFORM_ROWS_ABREAST};
}

/* Returns 1 / b, b the width of the contact patch; 0: b is computed from the number of posts that the object touches. */
static double by_width(const struct deform_contact *contact, const double extent[2], bool counted)
{
	const struct soil_shape *shape = contact->shape;
	if (shape->kind == SOIL_WHEEL || shape->kind == SOIL_CYLINDER) { /* between a level wheel and a round plate */
		double axis[3];
		soil_shape_axis(shape, &contact->to, axis);
		return (1 - axis[2] * axis[2]) / (shape->kind == SOIL_WHEEL ? shape->width : shape->length) + axis[2] * axis[2] / shape->radius;
	}
	if (shape->kind == SOIL_BOX)
		return 1 / fmin(shape->size[0], shape->size[1]);
	/* An object too large for one window is not counted. Its whole shadow is taken as the patch. */
	double shadow = shape->kind == SOIL_SPHERE ? M_PI * shape->radius * shape->radius : 4 * extent[0] * extent[1];
	return counted ? 0 : 1 / sqrt(shadow / M_PI);
}

/* Returns 1 / value, limited so that it is finite in single precision and can be multiplied. */
static float inverse(double value)
{
	return (float)fmin(1 / value, 1e30);
}

/* Returns the unit of length of moments, metres: a power of two, about the largest distance of a touched post from the centre. */
static double arm_of(const struct soil_shape *shape, const double extent[2])
{
	if (shape->kind >= SOIL_CYLINDER)
		return exp2(ceil(log2(soil_shape_bound(shape))));
	return exp2(ceil(log2(hypot(hypot(extent[0], extent[1]), soil_shape_reach(shape, 0, 0)))));
}

double deform_area_units(const struct deform *deform, const struct deform_contact *contact)
{
	/* A post bears the area of four at most. */
	const struct post_rect shadow = deform_shadow(deform, contact);
	double posts = 4.0 * (double)(shadow.x1 - shadow.x0) * (double)(shadow.y1 - shadow.y0);
	return exp2(fmin(floor(log2(0x1p32 / posts)) - 1, 20));
}

/* Returns the angle by which a wheel would turn if it rolled, rad. way: its motion, m. */
static double rolled(const struct deform_contact *contact, const float way[3])
{
	return deform_way_along(way[0] * cos(contact->to.yaw) + way[1] * sin(contact->to.yaw), way[2]) / contact->shape->radius;
}

/* Returns how far an object with a belt slips: along its own x axis by its way beyond what the belt ran, and aside. */
static double slip_of_belt(const struct deform_contact *contact)
{
	const struct soil_pose *to = &contact->to, *from = &contact->from;
	const double way[3] = {lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y), lattice_offset_metres(to->z - from->z)};
	double axes[3][3], forward = 0, aside = 0;
	soil_axes(to->yaw, to->pitch, to->roll, 0, axes);
	for (int k = 0; k < 3; k++) {
		forward += way[k] * axes[0][k];
		aside += way[k] * axes[1][k];
	}
	return hypot(forward - contact->turned, aside);
}

/* Returns how far the object slips over the ground during the contact, metres. A wheel slips by its way beyond rolling. */
static double slip_of(const struct deform_contact *contact, const float way[3])
{
	const double east = lattice_offset_metres(contact->to.x - contact->from.x), north = lattice_offset_metres(contact->to.y - contact->from.y);
	const double ahead[2] = {cos(contact->to.yaw), sin(contact->to.yaw)};
	if (contact->shape->belt)
		return slip_of_belt(contact);
	if (contact->shape->kind != SOIL_WHEEL)
		return hypot(east, north);
	return hypot((rolled(contact, way) - contact->turned) * contact->shape->radius, north * ahead[0] - east * ahead[1]);
}

static void fill_motion(const struct deform_contact *contact, struct scm_params *params)
{
	if (deform_is_contact_only(contact))
		return;
	params->way[0] = (float)lattice_offset_metres(contact->to.x - contact->from.x);
	params->way[1] = (float)lattice_offset_metres(contact->to.y - contact->from.y);
	params->way[2] = (float)lattice_offset_metres(contact->to.z - contact->from.z);
	/* How the soil carries a load does not depend on speed. */
	params->way[3] = contact->seconds > 0 && contact->load == 0 ? (float)(1 / contact->seconds) : 0;
	/* The rotation about the wheel's own y axis. */
	const double level = cos(contact->to.roll), axle[3] = {-sin(contact->to.yaw) * level, cos(contact->to.yaw) * level, sin(contact->to.roll)};
	for (int k = 0; k < 3; k++)
		params->spin[k] = (float)(axle[k] * contact->turned);
	for (int k = 0; k < 3 && contact->shape->kind != SOIL_WHEEL; k++)
		params->spin[k] = (float)contact->rotated[k];
	/* Damping depends on how fast soil is pushed down. A smooth wheel that spins does not push it down faster. So its slip is left
	 * out here. */
	double turned = contact->shape->kind == SOIL_WHEEL ? rolled(contact, params->way) : 0;
	for (int k = 0; k < 3; k++)
		params->rolls[k] = (float)(axle[k] * turned);
	if (!contact->shape->belt)
		return;
	double axes[3][3];
	soil_axes(contact->to.yaw, contact->to.pitch, contact->to.roll, 0, axes);
	for (int k = 0; k < 3; k++)
		params->belt[k] = (float)axes[1][k];
	params->belt[3] = (float)contact->turned;
}

/* Needs `way`. In digs[0] it needs for which share of the contact the surface of a wheel or a belt passes over the soil. So long its slip digs. */
static void fill_digging(const struct deform *deform, const struct deform_contact *contact, struct scm_params *params)
{
	const float passes = params->digs[0] > 0 ? params->digs[0] : 1;
	params->digs[0] = 0;
	params->digs[1] = (float)deform->params.slip_sinkage;
	params->digs[2] = contact->shape->kind == SOIL_WHEEL ? (float)soil_body_wheel_radius(contact->shape) : 0;
	params->digs[3] = contact->hosted ? 1 + (float)contact->stamped : 0;
	if (deform_is_contact_only(contact))
		return;
	const float slip = (float)slip_of(contact, params->way) * passes;
	params->digs[0] = slip >= (float)SOIL_SLIP_LEAST ? slip : 0;
}

static void fill_surface(const struct soil_interface *interface, float surface[4])
{
	surface[0] = interface->has_adhesion ? (float)interface->adhesion : 0;
	surface[1] = interface->has_friction ? (float)tan(interface->friction_angle) : 0;
	surface[2] = interface->has_adhesion ? 0 : 1;
	surface[3] = interface->has_friction ? 0 : 1;
}

static void fill_soils(const struct deform_params *params, struct scm_soil *soils)
{
	for (int i = 0; i < params->soil_count; i++) {
		const struct soil_numbers *s = &params->soils[i];
		soils[i] = (struct scm_soil){
			.a = {(float)s->bekker_kc, (float)s->bekker_kphi, (float)s->bekker_n, inverse(s->elastic_stiffness)},
			.b = {(float)s->cohesion, (float)tan(s->friction_angle), inverse(s->janosi_shear), (float)s->damping},
			.c = {(float)fmin(s->elastic_stiffness, 1e30), (float)fmin(s->janosi_shear, 1e30)},
		};
	}
}

static void fill_rasters(const struct deform_params *params, float rasters[SOIL_RASTERS][4])
{
	for (int i = 0; i < SOIL_RASTERS; i++) {
		const struct soil_raster *raster = &params->rasters[i];
		bool used = i < params->raster_count;
		rasters[i][0] = used ? (float)raster->low : 0;
		rasters[i][1] = used ? (float)raster->high : 0;
		rasters[i][2] = used ? (float)((raster->high - raster->low) / (SOIL_LEVELS - 1)) : 0;
	}
}

/* Returns the largest sinkage of a loaded object, metres: its height. A mesh's centre may lie anywhere in the mesh. */
static double deepest(const struct deform_contact *contact)
{
	const struct soil_shape *shape = contact->shape;
	return 2 * (shape->kind == SOIL_MESH ? soil_shape_bound(shape)
					       : soil_shape_reach(shape, contact->to.pitch, contact->to.roll));
}

/* Copies what the contact pass needs to measure for the passes that lay soil. */
static void fill_laying(const struct spread_params *spread, struct scm_params *params)
{
	/* Of all soils the same share of the depth is laid. */
	const int32_t frame[4] = {spread->origin[0], spread->origin[1], spread->place[1], spread->soils[0][1]};
	memcpy(params->written, spread->written, sizeof params->written);
	memcpy(params->shadow, spread->shadow, sizeof params->shadow);
	memcpy(params->frame, frame, sizeof frame);
	memcpy(params->frame_axis, spread->axis, 2 * sizeof spread->axis[0]);
	params->frame_axis[2] = spread->place[3];
}

/* Tells whether the posts that the object touches are counted before its contact. */
static bool is_counted(const struct deform *deform, const struct deform_contact *contact)
{
	return deform_is_counted(&deform->params, contact->shape, contact->load > 0) && deform_fits_window(deform, contact);
}

static struct scm_params params_of(const struct deform *deform, const struct deform_contact *contact, const struct spread_params *spread,
				   const struct deform_window *window, uint32_t layer, const double extent[2])
{
	int64_t zero = contact->to.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	int64_t base = zero >> (OFFSET_BITS - BASE_BITS);
	base = base < INT32_MIN + 1 ? INT32_MIN + 1 : base > INT32_MAX ? INT32_MAX : base;
	double spacing = deform->spacing;
	struct scm_params params = {
		.zero = {(int32_t)base, (int32_t)(zero & 3), (int32_t)layer},
		.scale = {(float)(ldexp(1, -OFFSET_BITS) / spacing), (float)spacing, DEFORM_UNITS_A_PASCAL},
		.spin = {[3] = (float)deform->params.bulldozing},
		.place = {(float)-soil_body_from_post(contact->to.x, window->read.x0, spacing),
			  (float)-soil_body_from_post(contact->to.y, window->read.y0, spacing), (float)(1 / arm_of(contact->shape, extent)),
			  (float)(spacing * spacing)},
		.load = {(float)fmax(contact->load, 1e-6), (float)fmin(ldexp(deepest(contact), OFFSET_BITS), 0x1p28), (float)contact->loaded_body},
	};
	fill_motion(contact, &params);
	fill_surface(&contact->interface, params.surface);
	deform_between_posts(deform, contact, window, &params);
	fill_digging(deform, contact, &params);
	deform_turn_into_frame(&params);
	fill_laying(spread, &params);
	params.faces[0][3] = (float)deform_area_units(deform, contact);
	fill_soils(&deform->params, params.soils);
	fill_rasters(&deform->params, params.rasters);
	params.scale[3] = (float)by_width(contact, extent, is_counted(deform, contact));
	return params;
}

/* Returns the variant of the contact pass. */
static unsigned variant(const struct deform *deform, const struct deform_contact *contact)
{
	return (contact->tag != 0 ? WITH_FORCES : 0) | (is_counted(deform, contact) ? WITH_PATCH : 0) | (contact->load > 0 ? WITH_LOAD : 0) |
	       (contact->shape->belt ? WITH_BELT : 0) |
	       WITH_SHAPE * (unsigned)soil_kind_in(contact->shape, &contact->to);
}

/* Fills the textures, images and buffers of the contact pass. */
static void bind(struct deform *deform, bool posts_only, struct gpu_buffer *tally, struct gpu_buffer *records, struct gpu_pass *pass)
{
	const struct gpu_pass bound = {
		.stage = GPU_CONTACT,
		.textures = {deform->under, deform->classes, deform->numbers, posts_only ? deform->bases : deform->rest},
		.images = {deform->planes_of[0][PLANE_DUG], deform->planes_of[1][PLANE_DEPOSITED], posts_only ? deform->rest : deform->bases, deform->planes_of[1][PLANE_OFFSET],
			   deform->planes_of[0][PLANE_PLASTIC_SINKAGE], deform->planes_of[0][PLANE_SHEAR], deform->contacts,
			   deform->heights[0]}, /* the heights are not used before soil slides */
		.storage = {tally, records},
	};
	*pass = bound;
}

static enum status run_contact(struct deform *deform, const struct deform_contact *contact, const struct spread_params *spread,
			       const struct deform_window *window, uint32_t layer, struct gpu_buffer *tally)
{
	double extent[2];
	soil_body_extent(contact->shape, &contact->to, extent);
	const enum soil_shape_kind form = soil_kind_in(contact->shape, &contact->to);
	struct scm_params params = params_of(deform, contact, spread, window, layer, extent);
	const unsigned with = variant(deform, contact);
	struct gpu_buffer *records = NULL;
	uint32_t record = 0;
	struct deform_request request;
	deform_programs_contact(&deform->params, with, false, &request);
	enum status status = deform_program(deform, &request, &deform->scm[0][with]);
	if (status == STATUS_OK && (with & (WITH_PATCH | WITH_LOAD)))
		status = deform_find(deform, &params, with / WITH_PATCH % FIND_SHAPE, form, tally);
	if (status == STATUS_OK && (with & WITH_FORCES))
		status = deform_forces_record(deform, contact, layer == 0, arm_of(contact->shape, extent), &records, &record);
	if (status != STATUS_OK)
		return status;
	params.zero[3] = (int32_t)record;
	gpu_texture_clear(deform->contacts, layer, deform_written(window), 0);
	struct gpu_pass pass;
	bind(deform, contact->shape->kind == SOIL_MESH, tally, records, &pass); /* lib/soil.glsl */
	pass.program = deform->scm[0][with];
	pass.target = deform->scratch[layer].to[TO_BARE];
	pass.viewport = deform_rows(params.shadow);
	pass.storage[2] = deform->found;
	pass.storage[3] = deform->standing;
	pass.storage[4] = deform->laying;
	pass.params = &params;
	pass.params_bytes = sizeof params;
	gpu_pass_run(deform->params.gpu, &pass);
	return STATUS_OK;
}

static enum status feel(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer)
{
	deform->scratch[layer].now[PLANE_OFFSET] = deform->scratch[layer].now[PLANE_DEPOSITED] = 1;
	const struct spread_params spread = deform_spread_params(deform, contact, window, layer);
	return run_contact(deform, contact, &spread, window, layer, deform->felt);
}

static enum status contact(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			   uint32_t layer)
{
	deform->scratch[layer].now[PLANE_OFFSET] = deform->scratch[layer].now[PLANE_DEPOSITED] = 1;
	const struct spread_params spread = deform_spread_params(deform, contact, window, layer);
	deform_spread_begin(deform, window, layer);
	enum status status = run_contact(deform, contact, &spread, window, layer, deform->tally);
	return status == STATUS_OK ? deform_spread_and_slide(deform, &spread, window, layer) : status;
}

/* --- over a batch --- */

static enum status fill_numbers(struct deform *deform, const struct deform_contact *contact, const struct spread_params *spread,
				const struct deform_window *window, int32_t numbers[TOGETHER_CONTACT_NUMBERS][4])
{
	double extent[2];
	struct gpu_buffer *records;
	uint32_t record = 0;
	enum status status = STATUS_OK;
	soil_body_extent(contact->shape, &contact->to, extent);
	struct scm_params params = params_of(deform, contact, spread, window, 0, extent);
	if (contact->tag != 0)
		status = deform_forces_record(deform, contact, true, arm_of(contact->shape, extent), &records, &record);
	params.zero[3] = (int32_t)record;
	_Static_assert(offsetof(struct scm_params, soils) == TOGETHER_CONTACT_NUMBERS * 16, "lib/soil.glsl");
	memcpy(numbers, &params, offsetof(struct scm_params, soils));
	return status;
}

static enum status run_together(struct deform *deform, unsigned with, uint32_t first, uint32_t count)
{
	struct scm_params params = {.zero = {0}};
	struct gpu_pass pass;
	struct deform_request request;
	deform_programs_contact(&deform->params, with, true, &request);
	enum status status = deform_program(deform, &request, &deform->scm[1][with]);
	if (status != STATUS_OK)
		return status;
	deform_together_draw(deform, TOGETHER_CONTACT, params.zero);
	params.zero[0] = (int32_t)first;
	fill_soils(&deform->params, params.soils);
	fill_rasters(&deform->params, params.rasters);
	if (with & (WITH_PATCH | WITH_LOAD))
		status = deform_find_together(deform, &params, with / WITH_PATCH % FIND_SHAPE, (enum soil_shape_kind)(with / WITH_SHAPE), count);
	if (status != STATUS_OK)
		return status;
	bind(deform, false, deform->tally, with & WITH_FORCES ? deform_forces_records(deform) : NULL, &pass);
	pass.program = deform->scm[1][with];
	pass.target = deform->scratch[0].to[TO_BARE];
	pass.params = &params;
	pass.params_bytes = sizeof params;
	pass.storage[2] = deform_together_found(deform);
	pass.storage[3] = deform->standing;
	pass.beside = first > 0 && !(with & (WITH_PATCH | WITH_LOAD));
	deform_together_run(deform, count, &pass);
	return STATUS_OK;
}

static enum status batch(struct deform *deform)
{
	static const struct together_model model = {.variant = variant, .fill = fill_numbers, .contact = run_together};
	return deform_together(deform, &model);
}

static int32_t critical(const struct soil_numbers *soil, double apart)
{
	return soil_critical_difference(soil->repose, apart);
}

static double laid_at(const struct soil_numbers *soil)
{
	return soil->repose;
}

static double laid_share(const struct deform_params *params, const struct soil_numbers *soil)
{
	(void)soil;
	return params->bulldozing;
}

const struct soil_model deform_model_scm = {
	.name = "scm",
	.use = "Bekker, Janosi, elastic rebound, a rim; loads, slip, forces",
	.volume = "exact",
	.effect = {
		"scm", "redistribute.model", "", EFFECT_LIST_NONE, "base, offset, heaped, pressed, shear",
		"offset, heaped, pressed, shear", 1,
		EFFECT_LIST("redistribute.bulldozing", "redistribute.normals", "soil.bekker_kc", "soil.bekker_kphi", "soil.bekker_n", "soil.cohesion",
			    "soil.friction_angle", "soil.janosi_shear", "soil.elastic_stiffness", "soil.damping", "objects[].slip",
			    "objects[].interface.friction_angle", "objects[].interface.adhesion"),
		"a stress is at most 1e20 Pa; a slope counts as at most 87 degrees; computed on the CPU, with the same bits on every machine",
		"sinks and springs back by the soil's pressure"},
	.keys = EFFECT_LIST("iterations", "interval", "depth", "undisturbed", "tolerance", "bulldozing", "slip_sinkage", "normals"),
	.numbers = EFFECT_LIST("bekker_kc", "bekker_kphi", "bekker_n", "cohesion", "friction_angle", "janosi_shear",
			       "elastic_stiffness", "damping", "repose"),
	.contact = contact,
	.feel = feel,
	.batch = batch,
	.shader = "deform/scm.frag",
	.planes = PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_PLASTIC_SINKAGE) | PLANE_BIT(PLANE_SHEAR),
	.measures = true,
	.in_place = true,
	.rasters = true,
	.slide = &deform_slide_excess,
	.directions = 2,
	.critical = critical,
	.laid_at = laid_at,
	.laid_share = laid_share,
};
