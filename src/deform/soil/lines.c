/*
 * Sliding along lines. In one iteration soil slides from a post to the posts beside it, so on finer posts it comes less far. In a
 * contact each line of posts also comes to rest at once, as far as it can by itself. Lines are rows, columns, and diagonals both
 * ways. Each of these directions is one pass (slide_lines.frag). A model has all four in each contact, or two of them in turn. SOIL.md,
 * "Along lines", has the rule.
 *
 * Invariants: (1) Each post lies on one line of a direction, and a line is computed by one invocation. So the order of
 * invocations does not matter. (2) Soil goes from higher to lower posts in whole units: the sum stays, and the potential energy never
 * rises. (3) Where the rule from post to post moves nothing, neither does this one.
 */

#include "deform/internal.h"

/* std140 twin of slide_lines.frag's block. */
struct lines_params {
	int32_t place[4], window[4], around[4];
	int32_t limits[SOIL_CLASSES][4];
};

int deform_line_passes(const struct deform_params *params)
{
	return params->along_lines ? deform_model_row(params->model)->directions : 0;
}

static enum status run(struct deform *deform, const struct slide_place *place, int heights, int direction)
{
	bool diagonal = direction > 1, stood = deform_asks_what_stood(&deform->params);
	struct deform_request request;
	deform_programs_lines(&deform->params, diagonal, &request);
	struct gpu_program **program = &deform->lines[diagonal];
	TRY(deform_program(deform, &request, program));
	/* Longer lines would take more turns of a loop than drivers allow. The pass still runs, and its invocations do nothing. */
	bool large = place->all.width > SIDE || place->all.height > SIDE;
	const struct gpu_rect w = large ? (struct gpu_rect){0, 0, 0, 0} : place->written;
	struct lines_params params = {
		.place = {(int32_t)place->layer, direction, deform->sliding.tolerance, deform->sliding.least[diagonal]}, .around = {place->around},
	};
	deform_posts_of(w, params.window);
	for (int i = 0; i < deform->params.soil_count; i++)
		params.limits[i][0] = deform->sliding.classes[i].critical[diagonal];
	const int32_t rows[4] = {0, 0, 0, (int32_t)(direction == 1 ? w.width : w.height)};
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_SLIDE,
		.program = *program,
		.target = deform->scratch[place->layer].to[TO_BARE],
		.viewport = deform_rows(rows),
		.images = {deform->heights[heights], deform->floors, deform->classes, [7] = stood ? deform->bases : NULL},
		.block = deform->laying,
		.params = &params,
		.params_bytes = (size_t)((char *)params.limits[deform_soil_slots(&deform->params)] - (char *)&params),
	});
	return STATUS_OK;
}

enum status deform_lines_run(struct deform *deform, const struct slide_place *place, int heights)
{
	for (int i = 0; i < deform_line_passes(&deform->params); i++)
		TRY(run(deform, place, heights, soil_sliding_direction(place->first, i)));
	return STATUS_OK;
}
