/*
 * The soil model "sumner", by Sumner, O'Brien and Hodgins (1999). The object compacts a part of the soil and pushes the rest
 * aside. Steep ground then erodes.
 */
#include <math.h>

#include "deform/internal.h"

struct sumner_params {
	struct contact_params contact;
	uint32_t kept[SOIL_CLASSES][4];
};

static enum status contact(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			   uint32_t layer)
{
	struct sumner_params params = {.contact = deform_contact_params(deform, contact, window, layer)};
	for (int i = 0; i < deform->params.soil_count; i++)
		params.kept[i][0] = (uint32_t)floor(ldexp(1 - deform->params.soils[i].compression, 31));
	const struct spread_params spread = deform_spread_params(deform, contact, window, layer);
	TRY(deform_run_contact(deform, &params, sizeof params, window, layer));
	return deform_spread_and_slide(deform, contact, &spread, window, layer);
}

static double laid_at(const struct soil_numbers *soil)
{
	return fmin(soil->theta_out, soil->theta_stop);
}

static double laid_share(const struct deform_params *params, const struct soil_numbers *soil)
{
	(void)params;
	return 1 - soil->compression;
}

const struct soil_model deform_model_sumner = {
	.name = "sumner",
	.use = "sand, mud, snow by appearance: displaced soil is laid around and erodes",
	.volume = "exact: offsets + compacted",
	.effect = {
		"sumner", "redistribute.model", "", EFFECT_LIST("deform/sumner.frag"), "base, offset", "offset", 0,
		EFFECT_LIST("soil.compression"),
		"gives away at most 8 m of soil a post and sweep",
		"lays part of what objects press away around"},
	.keys = EFFECT_LIST("iterations", "interval", "undisturbed", "tolerance"),
	.numbers = EFFECT_LIST("theta_in", "theta_out", "theta_stop", "roughness", "compression"),
	.depth = (double)INFINITY,
	.contact = contact,
	.shader = "deform/sumner.frag",
	.contact_soils = true,
	.slide = &deform_slide_shed,
	.laid_at = laid_at,
	.laid_share = laid_share,
};
