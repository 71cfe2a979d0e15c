/*
 * Sliding: `iterations` of the model's rule. One pass turns offsets into heights, the last one turns them back.
 *
 * Invariants: (1) what a post gives the other end of the pair takes: the sum of a window's written
 * posts changes by what was deposited and not compacted, and by nothing else; (2) nothing passes the rim of what is
 * written. Both ends work out the same number from the same integers, in whatever window or block they lie.
 */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "deform/internal.h"
#include "deform/stand.h"

struct begin_params {
	int32_t place[4], written[4];
};

struct excess_params {
	int32_t place[4];
	int32_t stands[DEFORM_SOILS][4];
};

int deform_soil_slots(const struct deform *deform)
{
	return deform->params.soil_count > 1 ? DEFORM_SOILS : 1;
}

bool deform_is_bounded(const struct deform *deform)
{
	return isfinite(deform->params.depth);
}

static int32_t loose_depth(const struct deform *deform)
{
	double quanta = floor(ldexp(deform->params.depth, OFFSET_BITS)), most = (1 << 30) - 1;
	return (int32_t)(quanta < most ? quanta : most);
}

void deform_slide_prepare(struct deform *deform)
{
	double axial = deform->spacing, diagonal = deform->spacing * M_SQRT2;
	for (int i = 0; i < deform->params.soil_count; i++) {
		const struct deform_soil *soil = &deform->params.soils[i];
		int32_t *stands = deform->stands[i];
		if (deform->params.model == DEFORM_SCM) {
			stands[0] = deform_stands_at(soil->repose, axial);
			stands[1] = deform_stands_at(soil->repose, diagonal);
		} else {
			stands[0] = deform_stands_cohesive(soil, axial);
			stands[1] = deform_stands_cohesive(soil, diagonal);
		}
	}
}

/* One more define of a request, if it is called for. */
static void define(struct gpu_program_request *request, const char *name, bool wanted)
{
	size_t count = 0;
	while (request->defines[count] != NULL)
		count++;
	if (wanted)
		request->defines[count] = name;
}

static bool is_heaped(const struct deform *deform)
{
	return (deform->planes & PLANE_BIT(PLANE_HEAPED)) != 0;
}

/* From planes_of[1] into planes_of[0] and the heights. */
static enum status begin(struct deform *deform, const struct slide_place *place)
{
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "deform/slide_begin.frag"};
	define(&request, "DEPOSITS", true);
	define(&request, "HEAPED", is_heaped(deform));
	define(&request, "BOUNDED", deform_is_bounded(deform));
	define(&request, "STEEP", !(deform->params.relief < STEEP_RELIEF));
	enum status status = deform_program(deform, &request, &deform->slide_begin);
	if (status != STATUS_OK)
		return status;
	struct gpu_rect written = place->written;
	const struct begin_params params = {
		.place = {(int32_t)place->layer, deform_is_bounded(deform) ? loose_depth(deform) : 0},
		.written = {(int32_t)written.x, (int32_t)written.y, (int32_t)(written.x + written.width),
			    (int32_t)(written.y + written.height)},
	};
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_REDISTRIBUTE,
		.program = deform->slide_begin,
		.target = deform->scratch[place->layer].to[TO_BEGUN],
		.viewport = place->all,
		.images = {deform->bases, deform->planes_of[1][PLANE_OFFSET], deform->contacts, deform->deposits,
			   deform->planes_of[1][PLANE_HEAPED]},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

static enum status excess(struct deform *deform, const struct slide_place *place, int iteration)
{
	bool last = iteration == deform->params.iterations - 1;
	char soils[16];
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "deform/slide_excess.frag"};
	snprintf(soils, sizeof soils, "SOILS %d", deform_soil_slots(deform));
	define(&request, soils, true);
	define(&request, "BOUNDED", deform_is_bounded(deform));
	define(&request, "LAST", last);
	define(&request, "HEAPED", last && is_heaped(deform));
	enum status status = deform_program(deform, &request, &deform->excess[last]);
	if (status != STATUS_OK)
		return status;
	struct excess_params params = {.place = {(int32_t)place->layer}};
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < 2; k++)
			params.stands[i][k] = deform->stands[i][k];
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_REDISTRIBUTE,
		.program = deform->excess[last],
		.target = deform->scratch[place->layer].to[last ? TO_SLID : iteration % 2 == 0 ? TO_HEIGHTS_1 : TO_HEIGHTS_0],
		.viewport = place->all,
		.images = {deform->heights[iteration % 2], deform->floors, deform->classes, deform->bases,
			   deform->planes_of[0][PLANE_OFFSET], deform->stills, deform->planes_of[0][PLANE_HEAPED]},
		.params = &params,
		.params_bytes = (size_t)((char *)params.stands[deform_soil_slots(deform)] - (char *)&params),
	});
	return STATUS_OK;
}

enum status deform_slide(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct layer *scratch = &deform->scratch[layer];
	const struct slide_place place = {
		.layer = layer,
		.all = deform_window_rect(window),
		.written = deform_written(window),
	};
	assert(scratch->now[PLANE_OFFSET] == 1);
	/* The heaped soil lies beside the offset: a press need not touch it. */
	if (is_heaped(deform) && scratch->now[PLANE_HEAPED] == 0)
		gpu_texture_copy(deform->planes_of[0][PLANE_HEAPED], layer, 0, 0, deform->planes_of[1][PLANE_HEAPED],
				 layer, place.all);
	scratch->now[PLANE_HEAPED] = 1;
	enum status status = begin(deform, &place);
	for (int i = 0; i < deform->params.iterations && status == STATUS_OK; i++)
		status = excess(deform, &place, i);
	return status;
}
