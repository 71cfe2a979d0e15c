/*
 * The soil model "sheet": an elastic sheet on a bed of springs, after Chanclou, Luciani and Habibi (1996). An object holds it down, and it comes back
 * when the object leaves; beyond the yield a rut stays. src/soil/kinematic/sheet.h is the same on the CPU, with the same bits.
 */
#include <math.h>
#include <string.h>

#include "deform/internal.h"
#include "soil/kinematic/sheet.h"

#define SET_ABREAST 16 /* shaders/deform/sheet_set.frag */

/* std140 twin of lib/sheet.glsl's block. */
struct sheet_params {
	int32_t zero[4], written[4], window[4];
	uint32_t relax[4], law[4];
};

struct soil_sheet deform_sheet(const struct deform_params *params)
{
	struct soil_sheet sheet;
	const double spacing = params->extent != NULL ? extent_spacing(params->extent, params->level) : 1;
	soil_sheet_prepare(&sheet, sqrt(params->tension / params->stiffness), params->yield, params->rut, spacing);
	return sheet;
}

int deform_sheet_passes(const struct deform_params *params)
{
	return 2 * deform_sheet(params).rounds + 3; /* two that mark posts, one that sets them */
}

struct post_rect deform_sheet_changes(const struct deform_params *params, struct post_rect shadow)
{
	return post_rect_grown(shadow, deform_sheet(params).reach);
}

/* One contact. */
struct bending {
	struct deform *deform;
	uint32_t layer;
	struct gpu_rect window; /* its posts, in the layer */
	struct sheet_params params;
	int rounds;
};

static void prepare(struct bending *bending, const struct deform_contact *contact, const struct deform_window *window)
{
	const struct deform *deform = bending->deform;
	const struct soil_sheet sheet = deform_sheet(&deform->params);
	const struct post_rect shadow = deform_shadow(deform, contact), read = window->read;
	bending->window = deform_window_rect(window);
	bending->rounds = sheet.rounds;
	bending->params = (struct sheet_params){
		.window = {(int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0), sheet.reach, 0},
		.relax = {sheet.relax[1], sheet.relax[2], sheet.relax[3], sheet.relax[4]},
		.law = {sheet.relax[0], sheet.over, (uint32_t)sheet.yield, sheet.share},
	};
	/* Of windows that lie beyond the world no post changes. They warm programs. */
	struct post_rect written = post_rect_intersect(deform_sheet_changes(&deform->params, shadow), read);
	if (post_rect_empty(written))
		written = (struct post_rect){read.x0, read.y0, read.x0, read.y0};
	deform_posts_in(window, written, bending->params.written);
}

static enum status run(struct bending *bending, enum sheet_pass which, enum gpu_stage stage, enum scratch_target target, struct gpu_rect viewport,
		       struct gpu_pass *pass)
{
	struct deform *deform = bending->deform;
	struct deform_request request;
	deform_programs_sheet(which, &request);
	TRY(deform_program(deform, &request, &deform->sheet[which]));
	pass->stage = stage;
	pass->program = deform->sheet[which];
	pass->target = deform->scratch[bending->layer].to[target];
	pass->viewport = viewport;
	pass->params = &bending->params;
	pass->params_bytes = sizeof bending->params;
	gpu_pass_run(deform->params.gpu, pass);
	return STATUS_OK;
}

/* Draws the envelopes of a motion. Heights count from its end. */
static enum status envelope(struct bending *bending, const struct deform_contact *contact, const struct deform_window *window)
{
	const struct contact_params params = deform_contact_params(bending->deform, contact, window, bending->layer);
	memcpy(bending->params.zero, params.zero, sizeof bending->params.zero);
	bending->params.zero[3] = contact->leaves;
	return deform_envelope(bending->deform, contact, window, bending->layer);
}

/* The body lets go, and holds posts down. */
static enum status touch(struct bending *bending, const struct deform_contact *contact, const struct deform_window *window)
{
	struct deform *deform = bending->deform;
	struct deform_contact before = *contact;
	before.to = before.from;
	TRY(envelope(bending, &before, window));
	TRY(run(bending, SHEET_FREE, GPU_CONTACT, TO_FREED, bending->window, &(struct gpu_pass){
		.textures = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->planes_of[0][PLANE_FLOOR], deform->rest},
	}));
	TRY(envelope(bending, contact, window));
	return run(bending, SHEET_CONTACT, GPU_CONTACT, TO_CONTACT, bending->window, &(struct gpu_pass){
		.textures = {deform->bases, deform->planes_of[0][PLANE_OFFSET], deform->planes_of[1][PLANE_FLOOR], deform->under, deform->rest},
		.storage = {deform->tally},
	});
}

/* Tells which posts move. The envelopes are not needed any more, so marks take their place. */
static enum status find(struct bending *bending)
{
	struct deform *deform = bending->deform;
	const int32_t *written = bending->params.written, rows[4] = {0, 0, 0, bending->params.window[1]}, columns[4] = {0, written[0], 0, written[2]};
	TRY(run(bending, SHEET_MARK_ROWS, GPU_BEND, TO_BARE, deform_rows(rows), &(struct gpu_pass){.images = {deform->holders, deform->under}}));
	return run(bending, SHEET_MARK_COLUMNS, GPU_BEND, TO_BARE, deform_rows(columns), &(struct gpu_pass){
		.images = {deform->under, deform->rest, deform->holders, deform->bent, deform->contacts},
	});
}

/* Returns the viewport of a pass with one invocation for so many posts of a row that may change. */
static struct gpu_rect strips(const struct bending *bending, uint32_t abreast)
{
	const int32_t *written = bending->params.written;
	const uint32_t width = (uint32_t)(written[2] - written[0]), height = (uint32_t)(written[3] - written[1]);
	return (struct gpu_rect){0, 0, width > 0 ? (width + abreast - 1) / abreast : 1, height > 0 ? height : 1};
}

static enum status bend(struct bending *bending, struct post_rect read)
{
	struct deform *deform = bending->deform;
	for (int half = 0; half < 2 * bending->rounds; half++) {
		bending->params.window[3] = (int32_t)((read.x0 + read.y0 + half) & 1);
		TRY(run(bending, SHEET_BEND, GPU_BEND, TO_BARE, strips(bending, 2), &(struct gpu_pass){.images = {deform->bent, deform->holders}}));
	}
	return run(bending, SHEET_SET, GPU_BEND, TO_BARE, strips(bending, SET_ABREAST), &(struct gpu_pass){
		.images = {deform->bent, deform->holders, deform->contacts, deform->planes_of[0][PLANE_OFFSET], deform->planes_of[1][PLANE_OFFSET],
			   deform->planes_of[1][PLANE_FLOOR]},
		.storage = {deform->tally},
	});
}

static enum status contact(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer)
{
	struct bending bending = {.deform = deform, .layer = layer};
	prepare(&bending, contact, window);
	TRY(touch(&bending, contact, window));
	TRY(find(&bending));
	TRY(bend(&bending, window->read));
	deform->scratch[layer].now[PLANE_OFFSET] = deform->scratch[layer].now[PLANE_FLOOR] = 1;
	return STATUS_OK;
}

const struct soil_model deform_model_sheet = {
	.name = "sheet",
	.use = "an elastic sheet on springs: mats, crusts, membranes; comes back, and keeps a rut beyond its yield",
	.volume = "exact: offsets + compacted",
	.effect = {
		"sheet", "redistribute.model", "",
		EFFECT_LIST("deform/sheet_free.frag", "deform/sheet_contact.frag", "deform/sheet_rows.frag", "deform/sheet_columns.frag", "deform/sheet_bend.frag",
			    "deform/sheet_set.frag"),
		"base, offset, floor", "offset, floor", 97,
		EFFECT_LIST("redistribute.tension", "redistribute.stiffness", "redistribute.yield", "redistribute.rut"),
		"its length sqrt(tension / stiffness) is at most 16 posts; a deflection is less than 8 m",
		"bends around what holds it, and comes back"},
	.keys = EFFECT_LIST("tension", "stiffness", "yield", "rut"),
	.elastic = true,
	.contact = contact,
	.planes = PLANE_BIT(PLANE_FLOOR),
};
