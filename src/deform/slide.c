/*
 * Sliding: `iterations` of the model's rule, from one copy of the planes into the other and back.
 *
 * Invariants: (1) what a post gives the other end of the pair takes: the sum of a window's written
 * posts changes by what was deposited and not compacted, and by nothing else; (2) nothing passes the rim of what is
 * written. Both ends work out the same number from the same integers, in whatever window or block they lie.
 */
#include <math.h>
#include <stdio.h>

#include "deform/internal.h"
#include "deform/stand.h"

struct excess_params {
	int32_t place[4], written[4];
	int32_t stands[DEFORM_SOILS][4];
};

static int32_t loose_depth(const struct deform *deform)
{
	double quanta = floor(ldexp(deform->params.depth, OFFSET_BITS)), most = (1 << 30) - 1;
	return (int32_t)(quanta < most ? quanta : most);
}

int deform_soil_slots(const struct deform *deform)
{
	return deform->params.soil_count > 1 ? DEFORM_SOILS : 1;
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

static enum status excess_program(struct deform *deform, bool first, struct gpu_program **program)
{
	char soils[16];
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "deform/slide_excess.frag"};
	size_t count = 0;
	snprintf(soils, sizeof soils, "SOILS %d", deform_soil_slots(deform));
	request.defines[count++] = soils;
	if (first)
		request.defines[count++] = "FIRST";
	if (deform->planes & PLANE_BIT(PLANE_HEAPED))
		request.defines[count++] = "HEAPED";
	if (isfinite(deform->params.depth))
		request.defines[count++] = "BOUNDED";
	enum status status = deform_program(deform, &request, &deform->excess[first]);
	*program = deform->excess[first];
	return status;
}

static enum status excess(struct deform *deform, struct gpu_rect written, uint32_t layer, bool first)
{
	struct gpu_program *program;
	enum status status = excess_program(deform, first, &program);
	if (status != STATUS_OK)
		return status;
	struct layer *scratch = &deform->scratch[layer];
	int now = scratch->now[PLANE_OFFSET];
	struct excess_params params = {
		.place = {(int32_t)layer, isfinite(deform->params.depth) ? loose_depth(deform) : 0},
		.written = {(int32_t)written.x, (int32_t)written.y, (int32_t)(written.x + written.width),
			    (int32_t)(written.y + written.height)},
	};
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < 2; k++)
			params.stands[i][k] = deform->stands[i][k];
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_REDISTRIBUTE,
		.program = program,
		.target = scratch->to[now == 0 ? TO_SECOND : TO_FIRST],
		.viewport = written,
		.textures = {deform->bases, deform->planes_of[now][PLANE_OFFSET], deform->contacts, deform->deposits,
			     deform->planes_of[now][PLANE_HEAPED], deform->classes},
		.storage = {deform->tally},
		.params = &params,
		.params_bytes = sizeof params,
	});
	scratch->now[PLANE_OFFSET] = 1 - now;
	scratch->now[PLANE_HEAPED] = 1 - now;
	return STATUS_OK;
}

/* Offset and heaped go together: from the same copy into the other. */
static void heaped_beside_offset(struct deform *deform, struct gpu_rect written, uint32_t layer)
{
	struct layer *scratch = &deform->scratch[layer];
	int now = scratch->now[PLANE_OFFSET], was = scratch->now[PLANE_HEAPED];
	if (deform->planes_of[0][PLANE_HEAPED] != NULL && was != now)
		gpu_texture_copy(deform->planes_of[was][PLANE_HEAPED], layer, written.x, written.y,
				 deform->planes_of[now][PLANE_HEAPED], layer, written);
	scratch->now[PLANE_HEAPED] = now;
}

enum status deform_slide(struct deform *deform, const struct deform_window *window, uint32_t layer)
{
	struct gpu_rect written = deform_written(window);
	heaped_beside_offset(deform, written, layer);
	enum status status = STATUS_OK;
	for (int i = 0; i < deform->params.iterations && status == STATUS_OK; i++)
		status = excess(deform, written, layer, i == 0);
	return status;
}
