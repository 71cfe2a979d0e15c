/* Makes and ends soil that the CPU computes over pages in host memory; its active blocks and sums. */
#include "bearing/internal.h"

#include <math.h>

static struct soil_law law_of(const struct deform_params *params)
{
	struct soil_law law = {
		.spacing = extent_spacing(params->extent, params->level), .reference = params->reference, .soil_count = params->soil_count,
		.raster_count = params->raster_count, .bulldozing = params->bulldozing, .slip_sinkage = params->slip_sinkage,
		.loosening = params->loosening, .hardening = params->hardening, .ground_normals = params->ground_normals, .faces = params->faces, .inertia = params->inertia,
	};
	memcpy(law.soils, params->soils, sizeof law.soils);
	memcpy(law.rasters, params->rasters, sizeof law.rasters);
	soil_law_set_layers(&law);
	return law;
}

/* Prepares how soil slides and is laid, for a model that moves soil. */
static void prepare(struct bearing *bearing)
{
	const struct deform_params *params = &bearing->params;
	const struct soil_model *model = deform_model_row(params->model);
	const bool sheds = deform_sheds(params->model);
	if (sheds)
		soil_shed_begin(&bearing->shed, params->soils, params->soil_count, bearing->law.spacing, params->tolerance, params->undisturbed_stable);
	bearing->held_is_stable = !sheds || soil_shed_held_is_stable(&bearing->shed, params->soil_count);
	soil_sliding_prepare(&(struct soil_sliding_params){
		.soils = params->soils, .soil_count = params->soil_count, .spacing = bearing->law.spacing, .critical = model->critical, .cotangent = model->cotangent,
		.iterations = params->iterations, .directions = deform_line_passes(params), .depth = params->depth,
		.tolerance = params->tolerance, .relief = params->relief, .undisturbed_stable = params->undisturbed_stable,
		.shed = sheds ? &bearing->shed : NULL,
	}, &bearing->rule);
	for (int i = 0; i < SOIL_CLASSES; i++) {
		const struct soil_numbers *soil = &params->soils[i < params->soil_count ? i : 0];
		bearing->laid[i] = soil_laid_of(model->laid_at(soil), model->laid_share(params, soil), bearing->law.spacing);
	}
}

/* Prepares contacts of a kinematic model. */
static void prepare_kinematic(struct bearing *bearing)
{
	const struct deform_params *params = &bearing->params;
	struct soil_kinematic *kinematic = &bearing->kinematic;
	*kinematic = (struct soil_kinematic){.spacing = bearing->law.spacing, .reference = params->reference};
	if (deform_model_row(params->model)->smooths) {
		kinematic->radius = params->box_radius;
		kinematic->repetitions = params->box_repetitions;
	}
	if (bearing->elastic)
		soil_sheet_prepare(&bearing->sheet, sqrt(params->tension / params->stiffness), params->yield, params->rut, bearing->law.spacing);
	if (deform_sheds(params->model))
		soil_kinematic_sumner(kinematic, params->soils, params->soil_count);
	else if (bearing->conserves)
		soil_kinematic_slippage(kinematic);
}

enum status bearing_create(const struct deform_params *params, struct host_slots *slots, struct bearing **out)
{
	struct bearing *bearing = mem_calloc(1, sizeof *bearing);
	*out = bearing;
	TRY_MEM(bearing, "bearing soil");
	const struct extent *extent = params->extent;
	bearing->main = bearing;
	bearing->params = *params;
	bearing->slots = slots;
	bearing->planes = deform_planes(params->model, params->disturbance, deform_memory(params)) & resident_host_planes(slots);
	bearing->world = (struct post_rect){0, 0, extent_posts(extent->width, params->level), extent_posts(extent->height, params->level)};
	bearing->law = law_of(params);
	bearing->conserves = deform_conserves(params->model);
	bearing->bears = deform_tells_forces(params->model);
	bearing->elastic = deform_is_elastic(params->model);
	if (bearing->conserves)
		prepare(bearing);
	if (!bearing->bears)
		prepare_kinematic(bearing);
	bearing->around = bearing->conserves ? params->iterations + 2 : bearing->kinematic.radius;
	if (bearing->bears)
		TRY(bearing_members_need(bearing, 1));
	if (params->loaded_bodies > 0)
		TRY(mem_zeroed(&bearing->standing, params->loaded_bodies, sizeof *bearing->standing, "bearing soil"));
	return STATUS_OK;
}

void bearing_destroy(struct bearing *bearing)
{
	if (bearing == NULL)
		return;
	mem_free_all(bearing->regions, bearing->memory);
	soil_block_set_finish(&bearing->active);
	soil_block_set_finish(&bearing->next);
	bearing_window_finish(&bearing->window);
	bearing_members_finish(bearing);
	bearing_hands_finish(bearing);
	mem_free_all(bearing->held, bearing->standing, bearing);
}

struct soil_trend bearing_trend_of(const struct bearing *bearing, const struct soil_motion *motion)
{
	return soil_trend_after(&bearing->law, motion);
}

struct soil_trend bearing_trend_after(const struct bearing *bearing, const struct deform_contact *contact)
{
	const struct soil_motion motion = bearing_motion_of(contact);
	return soil_trend_after(&bearing->law, &motion);
}

void bearing_set_equilibrium(struct bearing *bearing, uint32_t loaded_body, int32_t raised)
{
	bearing->standing[loaded_body - 1] = raised;
}

/* --- active blocks --- */

int64_t bearing_interval_rim(const struct bearing *bearing)
{
	return soil_sliding_rim(&bearing->rule);
}

enum status bearing_wake(struct bearing *bearing, struct post_rect changed)
{
	return !bearing->conserves ? STATUS_OK : soil_active_add_near(&bearing->active, bearing->world, bearing_interval_rim(bearing), changed);
}

struct post_rect bearing_wakes(const struct bearing *bearing, struct post_rect changed)
{
	return soil_active_near(bearing->world, bearing_interval_rim(bearing), changed);
}

enum status bearing_wake_block(struct bearing *bearing, struct soil_block block)
{
	return bearing->conserves ? soil_active_add(&bearing->active, bearing->world, block) : STATUS_OK;
}

enum status bearing_active_blocks(struct bearing *bearing, const struct soil_block **blocks, size_t *count)
{
	soil_block_set_sort(&bearing->active);
	*blocks = bearing->active.blocks;
	*count = bearing->active.count;
	if (*count > DEFORM_BLOCKS_MAX)
		return fail_with(STATUS_FAILED, "relaxation: soil slides in more than %d blocks of %d x %d posts at once; use a coarser spacing, or a soil that "
						"is steeper at rest", DEFORM_BLOCKS_MAX, SOIL_BLOCK, SOIL_BLOCK);
	return STATUS_OK;
}

void bearing_forget_active(struct bearing *bearing)
{
	soil_block_set_clear(&bearing->active);
}

int64_t bearing_contact_reach(const struct bearing *bearing, const struct soil_shape *shape)
{
	/* A band of soil is laid along the sides of a rectangle around the body, which may lie aslant. */
	const double spacing = bearing->law.spacing, band = bearing->conserves ? M_SQRT2 * soil_laying_band(shape, spacing) : 0;
	const double bound = soil_shape_bound(shape) / spacing;
	const int64_t border = bearing->conserves ? 1 : (int64_t)bearing->kinematic.radius * bearing->kinematic.repetitions;
	return (int64_t)ceil(bound + band) + 3 + bearing->around + border + 2 * (int64_t)bearing->sheet.reach;
}

/* --- sums --- */

void bearing_tally(const struct bearing *bearing, struct deform_tally *tally)
{
	*tally = bearing->tally;
}

void bearing_restore(struct bearing *bearing, const struct deform_tally *tally)
{
	bearing->tally = *tally;
	bearing_forget_active(bearing);
}
