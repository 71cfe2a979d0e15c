/*
 * The memory of soil that the CPU computes, for plans and for run.json. A plane of the window has a whole number of cache lines (window.c), so bytes are posts times
 * bytes a post.
 */
#include "bearing/internal.h"

/* Returns the bytes of a post of the window, without the planes that a scene may ask for. Each model has base, offset and contact. Others are planes
 * that the model keeps, and deposits with what posts carry. One that bears has owners and patch. */
static uint64_t window_bytes(enum deform_model model)
{
	const unsigned kept = deform_planes(model, false, 0);
	uint64_t whole = 2;
	whole += (kept & PLANE_BIT(PLANE_DEPOSITED)) != 0;
	whole += (kept & PLANE_BIT(PLANE_PLASTIC_SINKAGE)) != 0;
	whole += (kept & PLANE_BIT(PLANE_SHEAR)) != 0;
	whole += 2 * (uint64_t)deform_conserves(model);
	return whole * sizeof(int32_t) + (deform_tells_forces(model) ? 3 : 1) * sizeof(uint8_t);
}

/* Returns the bytes of a post that an interval changes: offset, and deposited and slope if they are kept. */
static uint64_t result_bytes(const struct deform_params *params)
{
	const unsigned kept = deform_planes(params->model, false, deform_memory(params));
	return (1 + ((kept & PLANE_BIT(PLANE_DEPOSITED)) != 0) + ((kept & PLANE_BIT(PLANE_SLOPE)) != 0)) * sizeof(int32_t);
}

static void add(struct plan *plan, const char *effect, enum plan_unit unit, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = unit, .effect = effect, .object = -1, .amount = 1, .bytes = bytes}, name);
}

void bearing_plan(const struct deform_params *params, struct plan *plan)
{
	const char *model = deform_displace_effect(params->model);
	deform_plan_planes(params, plan);
	add(plan, model, PLAN_ONCE, sizeof(struct bearing), deform_tells_forces(params->model) ? "bearing soil" : "soil on the CPU");
	add(plan, model, PLAN_WINDOW_POST, window_bytes(params->model), "window");
	static const struct {
		enum plane plane;
		const char *name;
	} memories[] = {{PLANE_DUG, "window: dug"}, {PLANE_SETTLED, "window: settled"}, {PLANE_LOOSE, "window: loose"}, {PLANE_FLOOR, "window: floor"},
			{PLANE_DENSITY, "window: density"}, {PLANE_SLOPE, "window: slope"}, {PLANE_HEALED, "window: healed"}, {PLANE_RISEN, "window: risen"},
			{PLANE_GROWN, "window: grown"}};
	for (size_t i = 0; i < sizeof memories / sizeof *memories; i++)
		if (deform_planes(params->model, params->disturbance, deform_memory(params)) & PLANE_BIT(memories[i].plane))
			add(plan, deform_plane_effect(params->model, memories[i].plane), PLAN_WINDOW_POST, sizeof(int32_t), memories[i].name);
	if (params->disturbance)
		add(plan, deform_plane_effect(params->model, PLANE_DISTURBANCE), PLAN_WINDOW_POST, sizeof(uint8_t), "window: dirt");
	if (params->soil_count > 1)
		add(plan, "soil_map", PLAN_WINDOW_POST, sizeof(uint8_t), "window: classes");
	if (params->raster_count > 0)
		add(plan, "soil_rasters", PLAN_WINDOW_POST, SOIL_RASTERS * sizeof(uint8_t), "window: numbers");
	add(plan, model, PLAN_WINDOW_SCRATCH, 1, "window: scratch");
	if (deform_conserves(params->model))
		add(plan, deform_slide_effect(params->model), PLAN_RESULT_POST, result_bytes(params), "soil that slid");
	if (params->loaded_bodies > 0)
		add(plan, "load", PLAN_ONCE, params->loaded_bodies * sizeof(int32_t), "heights of the loaded");
}

/* Adds what one hand has allocated. */
static void add_hand(const struct bearing *hand, struct bearing_figures *figures)
{
	const struct bearing_window *window = &hand->window;
	size_t bytes = hand->member_room * (sizeof *hand->members + sizeof *hand->others + sizeof *hand->rests) + hand->claim_room * sizeof *hand->claims +
		       hand->held_room * sizeof *hand->held + window->scratch_bytes + window->highest_posts * (sizeof *window->highest + (window->touched != NULL)) + window->roof_bytes + window->before_posts * sizeof *window->before + window->word_count * sizeof *window->words;
	for (size_t i = 0; i < hand->member_room; i++)
		bytes += soil_work_bytes(hand->members[i].work);
	figures->window_posts += window->posts;
	figures->scratch_bytes += bytes + (hand->main != hand ? sizeof *hand : 0);
	figures->bytes += window->bytes;
}

void bearing_figures(const struct bearing *bearing, struct bearing_figures *figures)
{
	*figures = (struct bearing_figures){.contacts = bearing->contacts, .feels = bearing->feels, .regions = bearing->slid, .result_posts = bearing->results_most};
	add_hand(bearing, figures);
	for (size_t i = 0; i < bearing->hand_count; i++)
		add_hand(bearing->hands[i], figures);
	figures->bytes += sizeof *bearing + bearing->params.loaded_bodies * sizeof *bearing->standing + figures->scratch_bytes +
			  figures->result_posts * result_bytes(&bearing->params);
}
