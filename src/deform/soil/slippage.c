/*
 * The soil model "slippage", by Li and Moshell (1993). The object pushes all soil aside. Then soil slips down slopes that are too
 * steep.
 */
#include <math.h>

#include "deform/internal.h"
#include "soil/stability.h"

static enum status contact(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			   uint32_t layer)
{
	const struct spread_params spread = deform_spread_params(deform, contact, window, layer);
	TRY(deform_contact_plainly(deform, contact, window, layer));
	return deform_spread_and_slide(deform, contact, &spread, window, layer);
}

static double laid_at(const struct soil_numbers *soil)
{
	return soil->friction_angle;
}

static double laid_share(const struct deform_params *params, const struct soil_numbers *soil)
{
	(void)params;
	(void)soil;
	return 1;
}

const struct soil_model deform_model_slippage = {
	.name = "slippage",
	.use = "granular soil by Culmann's wedge: slides until it stands",
	.volume = "exact",
	.effect = {
		"slippage", "redistribute.model", "", EFFECT_LIST("deform/slippage.frag"), "base, offset", "offset", 0,
		EFFECT_LIST_NONE,
		"gives away at most 8 m of soil a post and sweep",
		"lays all that objects press away around"},
	.keys = EFFECT_LIST("iterations", "interval", "depth", "undisturbed", "tolerance"),
	.numbers = EFFECT_LIST("cohesion", "friction_angle", "density", "unit_weight"),
	.depth = (double)INFINITY,
	.contact = contact,
	.shader = "deform/slippage.frag",
	.slide = &deform_slide_excess,
	.directions = 4,
	.critical = soil_critical_difference_cohesive,
	.cotangent = soil_critical_cotangent,
	.laid_at = laid_at,
	.laid_share = laid_share,
};
