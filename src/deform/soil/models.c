/* Collects the rows of all soil models. Each model's own file defines its row, a struct soil_model. */
#include <string.h>

#include "deform/internal.h"

#define DECLARE(number, word) extern const struct soil_model deform_model_##word;
DEFORM_MODELS_EACH(DECLARE)
#define ROW(number, word) [number] = &deform_model_##word,
static const struct soil_model *const rows[DEFORM_MODELS] = {DEFORM_MODELS_EACH(ROW)};

const struct soil_model *deform_model_row(enum deform_model model)
{
	return rows[model];
}

static bool has(const char *const *list, const char *word)
{
	for (; list != NULL && *list != NULL; list++)
		if (strcmp(*list, word) == 0)
			return true;
	return false;
}

bool deform_model_takes(enum deform_model model, const char *key)
{
	return has(rows[model]->keys, key);
}

bool deform_model_reads(enum deform_model model, const char *number)
{
	return has(rows[model]->numbers, number);
}

bool deform_conserves(enum deform_model model)
{
	return rows[model]->slide != NULL;
}

bool deform_sheds(enum deform_model model)
{
	return rows[model]->slide == &deform_slide_shed;
}

bool deform_tells_forces(enum deform_model model)
{
	return rows[model]->bears;
}

bool deform_is_elastic(enum deform_model model)
{
	return rows[model]->elastic;
}

bool deform_raises(enum deform_model model)
{
	return deform_conserves(model) || deform_is_elastic(model);
}

bool deform_on_cpu(enum deform_model model)
{
	return rows[model]->contact == NULL;
}

bool deform_for_cpu(enum deform_model model)
{
	return deform_on_cpu(model) || rows[model]->elastic;
}

unsigned deform_planes(enum deform_model model, bool disturbance, unsigned memory)
{
	const unsigned loose = PLANE_BIT(PLANE_SETTLED) | PLANE_BIT(PLANE_LOOSE) | PLANE_BIT(PLANE_FLOOR);
	return PLANE_BIT(PLANE_OFFSET) | (disturbance ? PLANE_BIT(PLANE_DISTURBANCE) : 0) | (memory & DEFORM_DIGS ? PLANE_BIT(PLANE_DUG) : 0) |
	       (memory & DEFORM_LOOSENS ? loose : 0) | (memory & DEFORM_HARDENS ? PLANE_BIT(PLANE_DENSITY) : 0) |
	       (memory & DEFORM_SLOPES ? PLANE_BIT(PLANE_SLOPE) : 0) | (memory & DEFORM_HEALS ? PLANE_BIT(PLANE_HEALED) : 0) |
	       (memory & DEFORM_GROWS ? PLANE_BIT(PLANE_RISEN) | PLANE_BIT(PLANE_GROWN) : 0) | rows[model]->planes;
}

bool deform_slopes_count(enum deform_model model, const struct soil_numbers *soils, int count)
{
	bool cohesive = false;
	for (int i = 0; i < count; i++)
		cohesive = cohesive || soils[i].cohesion > 0;
	return cohesive && rows[model]->cotangent != NULL;
}

unsigned deform_memory(const struct deform_params *params)
{
	return (params->slip_sinkage > 0 ? DEFORM_DIGS : 0) | (params->loosening > 0 ? DEFORM_LOOSENS : 0) | (params->hardening > 0 ? DEFORM_HARDENS : 0) |
	       (deform_has_slopes(params) ? DEFORM_SLOPES : 0) | deform_marks(params);
}

unsigned deform_marks(const struct deform_params *params)
{
	return (params->heals > 0 ? DEFORM_HEALS : 0) | (params->rises > 0 ? DEFORM_GROWS : 0);
}

struct soil_mark deform_mark_of(const struct deform_params *params, const struct deform_contact *contact)
{
	return (struct soil_mark){
		.now = contact->now, .heals = params->heals,
		.risen = params->rises > 0 ? plane_mark(contact->now, PLANE_MARK_MOST, params->rises) : 0,
		.grown = params->grows > 0 && contact->torn > 0 ? plane_mark(contact->now, contact->torn, params->grows) : 0,
	};
}

const char *deform_plane_effect(enum deform_model model, enum plane plane)
{
	if ((plane == PLANE_SETTLED || plane == PLANE_LOOSE || plane == PLANE_FLOOR) && !deform_is_elastic(model))
		return "loose";
	if (plane == PLANE_SLOPE)
		return deform_slide_effect(model);
	if (plane == PLANE_RISEN || plane == PLANE_GROWN)
		return "vegetation";
	return plane == PLANE_DISTURBANCE || plane == PLANE_HEALED ? "dirt" : plane == PLANE_DUG ? "slip" : plane == PLANE_DENSITY ? "dense" : deform_displace_effect(model);
}

const char *deform_displace_effect(enum deform_model model)
{
	return rows[model]->contact_effect != NULL ? rows[model]->contact_effect : rows[model]->effect.name;
}

const char *deform_slide_effect(enum deform_model model)
{
	return rows[model]->slide != NULL ? rows[model]->slide->effect : NULL;
}

const char *deform_contact_effect(enum deform_model model)
{
	return rows[model]->touched_effect != NULL ? rows[model]->touched_effect : rows[model]->effect.name;
}
