/*
 * Lays down the soil that an object displaces: from `carried` into `deposits`, in bands beside the patch that the object touches
 * (SOIL.md, "Laying"). All lengths are metres: they come from the object, its motion and the depth, not from the posts.
 */
#include <string.h>

#include "deform/internal.h"

#define LAYING_BYTES (47 * 4) /* lib/laying.glsl */

double deform_spread_band(const struct deform *deform, const struct soil_shape *shape)
{
	return deform_conserves(deform->params.model) ? soil_laying_band(shape, deform->spacing) : 0;
}

struct soil_laying deform_laying(const struct deform *deform, const struct deform_contact *contact)
{
	return soil_laying_of(contact->shape, &contact->from, &contact->to, contact->turned, contact->rotated, deform->spacing);
}

struct post_rect deform_spread_posts(const struct deform *deform, const struct deform_contact *contact, struct post_rect shadow)
{
	const struct soil_laying laying = deform_laying(deform, contact);
	return soil_laying_posts(&laying, contact->shape, &contact->to, deform->spacing, shadow);
}

void deform_laid(const struct deform *deform, struct soil_laid soils[SOIL_CLASSES])
{
	const struct deform_params *params = &deform->params;
	const struct soil_model *model = deform_model_row(params->model);
	memset(soils, 0, SOIL_CLASSES * sizeof *soils);
	for (int i = 0; i < params->soil_count; i++)
		soils[i] = soil_laid_of(model->laid_at(&params->soils[i]), model->laid_share(params, &params->soils[i]), deform->spacing);
}

static void fill_soils(const struct deform *deform, int32_t soils[SOIL_CLASSES][4])
{
	struct soil_laid laid[SOIL_CLASSES];
	deform_laid(deform, laid);
	for (int i = 0; i < deform->params.soil_count; i++) {
		soils[i][0] = laid[i].factor;
		soils[i][1] = laid[i].share;
	}
}

struct spread_params deform_spread_params(const struct deform *deform, const struct deform_contact *contact,
					  const struct deform_window *window, uint32_t layer)
{
	const struct soil_laying laying = deform_laying(deform, contact);
	struct spread_params params = {
		.place = {(int32_t)layer, laying.around, laying.widest, laying.rolls},
		/* The place of the window's first post. */
		.origin = {soil_laying_place(&laying, window->read.x0, window->read.y0, 0), soil_laying_place(&laying, window->read.x0, window->read.y0, 1),
			   laying.half_width, laying.along},
		.axis = {laying.axis[0], laying.axis[1], laying.beside, laying.goes_on},
	};
	deform_posts_in(window, window->write, params.written);
	fill_soils(deform, params.soils);
	memcpy(params.shares, laying.shares, sizeof params.shares);
	struct post_rect shadow = post_rect_intersect(deform_shadow(deform, contact), window->write);
	if (!post_rect_empty(shadow))
		deform_posts_in(window, shadow, params.shadow);
	return params;
}

struct gpu_rect deform_rows(const int32_t posts[4])
{
	/* Without rows the pass still runs, and its invocations do nothing. A window always runs the same number of passes. */
	uint32_t rows = posts[3] > posts[1] ? (uint32_t)(posts[3] - posts[1]) : 1;
	return (struct gpu_rect){0, 0, DEFORM_ROWS_ABREAST, (rows + DEFORM_ROWS_ABREAST - 1) / DEFORM_ROWS_ABREAST};
}

enum status deform_spread(struct deform *deform, const struct deform_contact *contact, const struct spread_params *params, const struct deform_window *window,
			  uint32_t layer)
{
	/* The heights are not used before soil slides. */
	struct gpu_texture *const images[SPREAD_PASSES][3] = {
		[SPREAD_MEASURE] = {deform->contacts, deform->carried, deform->planes_of[1][PLANE_OFFSET]},
		[SPREAD_WEIGH] = {deform->contacts, deform->heights[0], deform->deposits},
		[SPREAD_LAY] = {deform->deposits},
	};
	/* Sliding on steep ground reads the posts around those that are written, too (slide_begin.frag). */
	gpu_texture_clear(deform->deposits, layer, deform_window_rect(window), 0);
	gpu_buffer_clear(deform->laying, 0, LAYING_BYTES);
	for (int pass = 0; pass < SPREAD_PASSES; pass++) {
		struct deform_request request;
		deform_programs_spread(&deform->params, (enum spread_pass)pass, &request);
		TRY(deform_program(deform, &request, &deform->spread[pass]));
		gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
			.stage = GPU_SPREAD,
			.program = deform->spread[pass],
			.target = deform->scratch[layer].to[TO_BARE],
			.viewport = deform_rows(pass == SPREAD_MEASURE ? params->shadow : params->written),
			.textures = {[4] = pass == SPREAD_MEASURE ? deform->classes : NULL},
			.images = {images[pass][0], images[pass][1], images[pass][2], pass == SPREAD_WEIGH ? deform->bases : NULL, [7] = pass == SPREAD_MEASURE ? deform->heights[0] : NULL},
			.storage = {deform->tally, [4] = deform->laying},
			.params = params,
			.params_bytes = (size_t)((const char *)params->soils[deform_soil_slots(&deform->params)] - (const char *)params),
		});
		/* What others hold is no part of the patch that was measured. */
		if (pass == SPREAD_MEASURE && contact->rest_count > 0)
			TRY(deform_find_roofs(deform, contact, window, layer));
	}
	return contact->rest_count > 0 ? deform_roof_run(deform, ROOF_LIMIT, deform_window_rect(window), layer, NULL) : STATUS_OK;
}

enum status deform_spread_create(struct deform *deform)
{
	return gpu_buffer_create(deform->params.gpu, GPU_STORAGE, LAYING_BYTES, NULL, &deform->laying);
}

void deform_spread_plan(struct plan *plan)
{
	deform_plan_buffer(plan, "spread", 1, LAYING_BYTES, "laying");
}
