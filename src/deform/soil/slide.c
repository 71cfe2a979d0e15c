/*
 * Sliding: `iterations` iterations of the model's relaxation rule. The first pass turns offsets into heights. The last one turns
 * heights into offsets.
 *
 * Invariants: (1) The two posts of a pair exchange the same amount of soil. So the sum over a window's written posts changes
 * only by the deposited soil that is not compacted. (2) No soil leaves the written posts. Both posts of a pair
 * compute the same amount from the same integers, whatever window or block they lie in.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "deform/internal.h"
#include "soil/kinematic/shed.h"

/* std140 twins of the parameters of slide_begin.frag and slide_take.frag, slide_excess.frag, and slide_shed.frag. */
struct slide_params {
	int32_t region[4], place[4], written[4], sides[4], view[4];
};
struct excess_params {
	struct slide_params slide;
	int32_t limits[SOIL_CLASSES][4];
};
struct shed_params {
	struct slide_params slide;
	struct {
		int32_t out_in[4], stop[4];
		uint32_t share[8];
	} soils[SOIL_CLASSES];
};

static const struct soil_slide *slide_of(const struct deform_params *params)
{
	return deform_model_row(params->model)->slide;
}

int deform_soil_slots(const struct deform_params *params)
{
	return deform_has_classes(params) ? SOIL_CLASSES : 1;
}

bool deform_is_bounded(const struct deform_params *params)
{
	const struct soil_slide *slide = slide_of(params);
	return slide != NULL && slide->bounded && isfinite(params->depth);
}

/* If only deposited soil slides, undisturbed ground needs no comparison. */
bool deform_asks_what_stood(const struct deform_params *params)
{
	return params->undisturbed_stable && !(deform_is_bounded(params) && params->depth == 0);
}

bool deform_is_steep(const struct deform_params *params)
{
	return !(params->relief < SOIL_STEEP_RELIEF);
}

bool deform_has_slopes(const struct deform_params *params)
{
	return deform_slopes_count(params->model, params->soils, params->soil_count);
}

/* The pass that begins, those that find slopes or slide along lines, and those of the iterations. */
int deform_slide_passes(const struct deform_params *params, bool blocks)
{
	int more = blocks ? deform_slope_passes(params) : deform_line_passes(params);
	return 1 + more + params->iterations * slide_of(params)->pass_count;
}

/* A pass of an iteration depends on the posts beside a post. */
int64_t deform_slide_step(const struct deform *deform)
{
	const struct soil_slide *slide = slide_of(&deform->params);
	return slide != NULL ? slide->pass_count : 1;
}

/* The result at a post is right if all posts within the rim were read. */
int64_t deform_slide_rim(const struct deform *deform)
{
	return deform_slide_step(deform) * deform->params.iterations + deform_is_steep(&deform->params) + deform_slope_reach(&deform->params);
}

static void prepare_shed(struct deform *deform)
{
	soil_shed_begin(&deform->sheds, deform->params.soils, deform->params.soil_count, deform->spacing, deform->params.tolerance,
			deform_asks_what_stood(&deform->params));
	for (int i = 0; i < deform->params.soil_count; i++) {
		const struct soil_shed_class *limits = &deform->sheds.classes[i];
		struct shed_soil *to = &deform->soils[i];
		memcpy(to->critical, limits->critical, sizeof to->critical);
		memcpy(to->held, limits->held, sizeof to->held);
		memcpy(to->stop, limits->stop, sizeof to->stop);
		memcpy(to->share, limits->share, sizeof to->share);
	}
}

void deform_slide_prepare(struct deform *deform)
{
	const struct deform_params *params = &deform->params;
	const struct soil_model *model = deform_model_row(params->model);
	const bool sheds = deform_sheds(params->model);
	if (sheds)
		prepare_shed(deform);
	soil_sliding_prepare(&(struct soil_sliding_params){
		.soils = params->soils,
		.soil_count = params->soil_count,
		.spacing = deform->spacing,
		.critical = model->critical,
		.cotangent = model->cotangent,
		.iterations = params->iterations,
		.directions = deform_line_passes(params),
		.depth = model->slide->bounded ? params->depth : (double)INFINITY,
		.tolerance = params->tolerance,
		.relief = params->relief,
		.undisturbed_stable = params->undisturbed_stable,
		.shed = sheds ? &deform->sheds : NULL,
	}, &deform->sliding);
	/* If soil beside a held post slides at a smaller difference, another object can set it in motion. A contact's flags cannot tell
	 * that. */
	deform->contacts_flag = !sheds || soil_shed_held_is_stable(&deform->sheds, params->soil_count);
}

static void fill_window(const struct slide_place *place, struct slide_params *params)
{
	const int32_t view[4] = {(int32_t)place->all.width, (int32_t)place->all.height, place->around, place->flags.step};
	deform_posts_of(place->written, params->written);
	memcpy(params->sides, place->flags.sides, sizeof params->sides);
	memcpy(params->view, view, sizeof view);
}

/* Returns the parameters of an iteration. */
static struct slide_params slide_params(const struct slide_place *place, int64_t rim)
{
	const struct place_flags *flags = &place->flags;
	struct slide_params params = {.place = {(int32_t)place->layer, (int32_t)rim}};
	if (place->atlas != NULL)
		return params;
	params.region[0] = flags->from[0];
	params.region[1] = flags->from[1];
	params.region[2] = (int32_t)flags->columns;
	params.region[3] = (int32_t)flags->first;
	fill_window(place, &params);
	return params;
}

static enum deform_over over_of(const struct slide_place *place)
{
	return place->atlas != NULL ? OVER_BLOCKS : OVER_WINDOW;
}

/* Tells passes over windows from passes over blocks. */
static enum gpu_stage stage_of(const struct slide_place *place)
{
	return place->atlas != NULL ? GPU_SETTLE : GPU_SLIDE;
}

static struct slide_params begin_params(const struct deform *deform, const struct slide_place *place)
{
	struct slide_params params = {
		.place = {(int32_t)place->layer, deform->sliding.depth},
	};
	fill_window(place, &params);
	return params;
}

static struct excess_params excess_params(const struct deform *deform, const struct slide_place *place)
{
	struct excess_params params = {.slide = slide_params(place, deform_slide_rim(deform))};
	for (int i = 0; i < deform->params.soil_count; i++) {
		const struct soil_sliding_class *soil = &deform->sliding.classes[i];
		const int32_t limits[4] = {soil->critical[0], soil->critical[1], deform->sliding.tolerance, soil->rise[0]};
		memcpy(params.limits[i], limits, sizeof limits);
	}
	return params;
}

/* Runs the first pass: reads planes_of[1]; writes the heights. */
static enum status begin(struct deform *deform, const struct slide_place *place)
{
	const bool blocks = place->atlas != NULL;
	struct deform_request request;
	deform_programs_begin(&deform->params, over_of(place), &request);
	struct gpu_program **program = &deform->slide_begin[over_of(place)];
	TRY(deform_program(deform, &request, program));
	struct slide_params params = begin_params(deform, place);
	/* Iterations need no heights where only the extents of slopes are found. Marking steep posts reads one post more. */
	int64_t reach = deform_slope_reach(&deform->params);
	deform_atlas_run(deform, place, ATLAS_REGIONS, reach > 0 ? reach - 1 : 0, &(struct gpu_pass){
		.stage = stage_of(place),
		.program = *program,
		.target = deform->scratch[place->layer].to[TO_BEGUN],
		.images = {deform->bases, deform->planes_of[1][PLANE_OFFSET], deform->contacts, blocks ? NULL : deform->deposits},
		.storage = {deform->tally},
		.block = blocks ? NULL : deform->laying,
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

/* Gives a pass the roofs. */
static void roof(struct deform *deform, const struct slide_place *place, struct gpu_pass *pass)
{
	if (!place->roofed)
		return;
	pass->images[place->atlas != NULL ? 3 : 6] = deform->roofs;
	pass->images[7] = deform->bases;
}

/* Runs the pass that ends an iteration. The last iteration needs no post around the blocks. */
static void run(struct deform *deform, const struct slide_place *place, int iteration, struct gpu_pass *pass)
{
	int64_t left = deform_slide_step(deform) * (deform->params.iterations - 1 - iteration);
	bool last = iteration == deform->params.iterations - 1, blocks = place->atlas != NULL;
	const enum scratch_target heights = iteration % 2 == 0 ? TO_HEIGHTS_1 : TO_HEIGHTS_0;
	struct gpu_texture *const *planes = deform->planes_of[1];
	pass->stage = stage_of(place);
	pass->target = deform->scratch[place->layer].to[last ? TO_BARE : heights];
	pass->images[0] = deform->heights[iteration % 2];
	pass->storage[1] = last ? place->flags.words : NULL;
	pass->block = blocks ? NULL : deform->laying;
	roof(deform, place, pass);
	if (last) {
		pass->images[3] = blocks ? pass->images[3] : deform->deposits;
		pass->images[4] = planes[PLANE_OFFSET];
		pass->images[5] = deform->stills;
		pass->images[7] = deform->bases;
	}
	bool cells = deform_has_slopes(&deform->params);
	enum atlas_part part = !last ? ATLAS_REGIONS : cells ? ATLAS_BLOCK_CELLS : ATLAS_BLOCKS;
	deform_atlas_run(deform, place, part, deform_slide_rim(deform) - left, pass);
}

static enum status excess(struct deform *deform, const struct slide_place *place, int iteration)
{
	bool last = iteration == deform->params.iterations - 1, stood = deform_asks_what_stood(&deform->params);
	struct deform_request request;
	deform_programs_slide(&deform->params, SLIDE_EXCESS, over_of(place), last, place->roofed, &request);
	struct gpu_program **program = &deform->slide[place->roofed][over_of(place)][last];
	TRY(deform_program(deform, &request, program));
	bool slopes = place->atlas != NULL && deform_has_slopes(&deform->params);
	struct excess_params params = excess_params(deform, place);
	if (slopes)
		params.slide.region[2] = deform->sliding.slope_least;
	run(deform, place, iteration, &(struct gpu_pass){
		.program = *program,
		.images = {NULL, deform->floors, deform->classes, [6] = slopes ? deform_slopes_found(deform) : NULL,
			   [7] = stood ? deform->bases : NULL},
		.params = &params,
		.params_bytes = (size_t)((char *)params.limits[deform_soil_slots(&deform->params)] - (char *)&params),
	});
	return STATUS_OK;
}

static enum status shed(struct deform *deform, const struct slide_place *place, int iteration)
{
	bool stood = deform_asks_what_stood(&deform->params);
	struct deform_request request;
	deform_programs_slide(&deform->params, SLIDE_SHED, over_of(place), false, place->roofed, &request);
	struct gpu_program **program = &deform->shed[place->roofed][over_of(place)];
	TRY(deform_program(deform, &request, program));
	int64_t rim = deform_slide_rim(deform), left = deform->params.iterations - 1 - iteration;
	struct shed_params params = {.slide = slide_params(place, rim)};
	for (int i = 0; i < deform->params.soil_count; i++) {
		const struct shed_soil *soil = &deform->soils[i];
		for (int k = 0; k < 2; k++) {
			params.soils[i].out_in[k] = soil->critical[k];
			params.soils[i].out_in[2 + k] = soil->held[k];
			params.soils[i].stop[k] = soil->stop[k];
		}
		params.soils[i].stop[2] = deform->sliding.tolerance;
		for (int n = 0; n < 8; n++)
			params.soils[i].share[n] = soil->share[n];
	}
	struct gpu_pass pass = {
		.stage = stage_of(place),
		.program = *program,
		.target = deform->scratch[place->layer].to[TO_SHED],
		.images = {deform->heights[iteration % 2], deform->contacts, deform->classes,
			   [7] = stood ? deform->bases : NULL},
		.block = place->atlas != NULL ? NULL : deform->laying,
		.params = &params,
		.params_bytes = (size_t)((char *)&params.soils[deform_soil_slots(&deform->params)] - (char *)&params),
	};
	roof(deform, place, &pass);
	deform_atlas_run(deform, place, ATLAS_REGIONS, rim - 2 * left - 1, &pass);
	return STATUS_OK;
}

static enum status shed_and_take(struct deform *deform, const struct slide_place *place, int iteration)
{
	bool last = iteration == deform->params.iterations - 1;
	TRY(shed(deform, place, iteration));
	struct deform_request request;
	deform_programs_slide(&deform->params, SLIDE_TAKE, over_of(place), last, place->roofed, &request);
	struct gpu_program **program = &deform->slide[place->roofed][over_of(place)][last];
	TRY(deform_program(deform, &request, program));
	const struct slide_params params = slide_params(place, deform_slide_rim(deform));
	run(deform, place, iteration, &(struct gpu_pass){
		.program = *program,
		.images = {NULL, deform->carried},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

const struct soil_slide deform_slide_excess = {
	.effect = "slide",
	.pass_count = 1,
	.passes = {SLIDE_EXCESS},
	.bounded = true,
	.held_still = true,
	.iterate = excess,
};
const struct soil_slide deform_slide_shed = {
	.effect = "shed",
	.pass_count = 2,
	.passes = {SLIDE_SHED, SLIDE_TAKE},
	.iterate = shed_and_take,
};

/* Lines do not know roofs. */
static enum status run_lines(struct deform *deform, const struct slide_place *place, int heights)
{
	const bool roofed = place->roofed && deform_line_passes(&deform->params) > 0;
	if (roofed)
		TRY(deform_roof_run(deform, ROOF_CLOSE, place->all, place->layer, deform->heights[heights]));
	TRY(deform_lines_run(deform, place, heights));
	return roofed ? deform_roof_run(deform, ROOF_OPEN, place->all, place->layer, deform->heights[heights]) : STATUS_OK;
}

enum status deform_slide_run(struct deform *deform, const struct slide_place *place)
{
	TRY(begin(deform, place));
	if (place->atlas != NULL && deform_has_slopes(&deform->params))
		TRY(deform_slopes_run(deform, place));
	for (int i = 0; i < deform->params.iterations; i++) {
		if (i == deform->params.iterations - 1 && place->atlas == NULL)
			TRY(run_lines(deform, place, i % 2));
		TRY(slide_of(&deform->params)->iterate(deform, place, i));
	}
	return STATUS_OK;
}

struct slide_place deform_slide_place(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	return (struct slide_place){
		.layer = layer,
		.all = deform_window_rect(window),
		.written = deform_written(window),
		.around = deform->scratch[layer].near ? (int32_t)deform->reach : -1,
		.first = window->write,
		.flags = deform_active_flags(deform, window, layer),
		.roofed = deform->scratch[layer].roofed,
	};
}

enum status deform_slide(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	const struct slide_place place = deform_slide_place(deform, window, layer);
	assert(deform->scratch[layer].now[PLANE_OFFSET] == 1);
	return deform_slide_run(deform, &place);
}

enum status deform_spread_and_slide(struct deform *deform, const struct deform_contact *contact, const struct spread_params *spread,
				    const struct deform_window *window, uint32_t layer)
{
	TRY(deform_spread(deform, contact, spread, window, layer));
	return deform_slide(deform, window, layer);
}
