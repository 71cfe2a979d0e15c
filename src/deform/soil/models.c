/* The soil models: one row each. What differs between them in a number or a flag stands here; the rest is in the model's file. */
#include "deform/internal.h"

const struct soil_model deform_soil_models[DEFORM_MODELS] = {
	[DEFORM_NONE] = {
		.contact = deform_none,
		.shader = "deform/none.frag",
		.contact_effect = "displace",
		.window_effect = "dirt",
	},
	[DEFORM_BOX_FILTER] = {
		.contact = deform_box,
		.shader = "deform/none.frag",
		.contact_effect = "displace",
		.window_effect = "box",
	},
	[DEFORM_SUMNER] = {
		.contact = deform_sumner,
		.shader = "deform/sumner.frag",
		.contact_effect = "sumner",
		.window_effect = "sumner",
		.slide_effect = "shed",
		.conserves = true,
		.slide_passes = 2,
	},
	[DEFORM_SLIPPAGE] = {
		.contact = deform_slippage,
		.shader = "deform/slippage.frag",
		.contact_effect = "slippage",
		.window_effect = "slippage",
		.slide_effect = "slide",
		.conserves = true,
		.slide_passes = 1,
	},
	[DEFORM_SCM] = {
		.contact = deform_scm,
		.shader = "deform/scm.frag",
		.contact_effect = "scm",
		.window_effect = "scm",
		.slide_effect = "slide",
		.planes = PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_PLASTIC_SINKAGE) | PLANE_BIT(PLANE_SHEAR),
		.conserves = true,
		.slide_passes = 1,
	},
};

bool deform_conserves(enum deform_model model)
{
	return deform_soil_models[model].conserves;
}

unsigned deform_planes(enum deform_model model, bool dirt)
{
	return PLANE_BIT(PLANE_OFFSET) | (dirt ? PLANE_BIT(PLANE_DISTURBANCE) : 0) | deform_soil_models[model].planes;
}

const char *deform_press_effect(enum deform_model model)
{
	return deform_soil_models[model].contact_effect;
}

const char *deform_slide_effect(enum deform_model model)
{
	return deform_soil_models[model].slide_effect;
}

const char *deform_contact_effect(enum deform_model model)
{
	return deform_soil_models[model].window_effect;
}
