/*
 * The soil contact model of Krenn and Hirzinger (2009). Pressure and sinkage are Bekker's, shear is Janosi and Hanamoto's, and
 * the soil rebounds elastically. Displaced soil is deposited around the object and slides to its angle of repose. The CPU computes it: src/soil,
 * src/bearing.
 */
#include "deform/internal.h"
#include "soil/stability.h"

static int32_t critical(const struct soil_numbers *soil, double apart)
{
	return soil_critical_difference(soil->repose, apart);
}

static double laid_at(const struct soil_numbers *soil)
{
	return soil->repose;
}

static double laid_share(const struct deform_params *params, const struct soil_numbers *soil)
{
	(void)soil;
	return params->bulldozing;
}

const struct soil_model deform_model_scm = {
	.name = "scm",
	.use = "Bekker, Janosi, elastic rebound, a rim; loads, slip, forces",
	.volume = "exact",
	.effect = {
		"scm", "redistribute.model", "", EFFECT_LIST_NONE, "base, offset, heaped, pressed, shear",
		"offset, heaped, pressed, shear", 1,
		EFFECT_LIST("redistribute.bulldozing", "redistribute.normals", "redistribute.faces", "redistribute.inertia", "soil.bekker_kc", "soil.bekker_kphi", "soil.bekker_n", "soil.cohesion",
			    "soil.friction_angle", "soil.janosi_shear", "soil.elastic_stiffness", "soil.damping", "soil.thickness", "soil.over", "soil.density", "soil.unit_weight", "soil.face_strength", "soil.face_cohesion", "objects[].slip", "objects[].carry",
			    "objects[].interface.friction_angle", "objects[].interface.adhesion"),
		"a stress is at most 1e20 Pa; a slope counts as at most 87 degrees; computed on the CPU, with the same bits on every machine",
		"sinks and springs back by the soil's pressure"},
	.keys = EFFECT_LIST("iterations", "interval", "depth", "undisturbed", "tolerance", "bulldozing", "slip_sinkage", "loosening", "hardening", "normals", "faces", "inertia", "thrown"),
	.numbers = EFFECT_LIST("bekker_kc", "bekker_kphi", "bekker_n", "cohesion", "friction_angle", "janosi_shear",
			       "elastic_stiffness", "damping", "density", "unit_weight", "face_strength", "face_cohesion", "repose", "compaction"),
	.bears = true,
	.planes = PLANE_BIT(PLANE_DEPOSITED) | PLANE_BIT(PLANE_PLASTIC_SINKAGE) | PLANE_BIT(PLANE_SHEAR),
	.slide = &deform_slide_excess,
	.directions = 2,
	.critical = critical,
	.laid_at = laid_at,
	.laid_share = laid_share,
};
