/*
 * The soil model "sheet": an elastic sheet on a bed of springs, after Chanclou, Luciani and Habibi (1996). An object holds it down, and it comes back
 * when the object leaves; beyond the yield a rut stays. The CPU computes it: src/soil/kinematic/sheet.h.
 */
#include "deform/internal.h"

const struct soil_model deform_model_sheet = {
	.name = "sheet",
	.use = "an elastic sheet on springs: mats, crusts, membranes; comes back, and keeps a rut beyond its yield",
	.volume = "exact: offsets + compacted",
	.effect = {
		"sheet", "redistribute.model", "", EFFECT_LIST_NONE, "base, offset, floor", "offset, floor", 97,
		EFFECT_LIST("redistribute.tension", "redistribute.stiffness", "redistribute.yield", "redistribute.rut"),
		"its length sqrt(tension / stiffness) is at most 16 posts; a deflection is less than 8 m; computed on the CPU, with the same bits on every machine",
		"bends around what holds it, and comes back"},
	.keys = EFFECT_LIST("tension", "stiffness", "yield", "rut"),
	.elastic = true,
	.planes = PLANE_BIT(PLANE_FLOOR),
};
