/* The one table of effects: what each is called, what calls for it, and what it costs. */
#include <assert.h>

#include "scene/scene.h"

#define STATE "base, offset, heaped, pressed, shear"
#define STATE_CHANGED "offset, heaped, pressed, shear"

static const struct scene_effect_row rows[EFFECT_COUNT] = {
	[EFFECT_DISPLACE] = {"displace", "objects", "", "deform/none.frag", "base, offset",
			     "offset", 0, "presses each object's underside into the ground"},
	[EFFECT_BOX] = {"box", "redistribute.model", "", "deform/box.frag", "base, offset", "offset",
			1, "smooths the trail: the mean offset of the posts around each"},
	[EFFECT_SUMNER] = {"sumner", "redistribute.model", "", "deform/sumner.frag", "base, offset",
			   "offset", 0, "takes what an object presses away, and lays part of it around"},
	[EFFECT_SLIPPAGE] = {"slippage", "redistribute.model", "", "deform/slippage.frag", "base, offset",
			     "offset", 0, "takes what an object presses away, and lays all of it around"},
	[EFFECT_SCM] = {"scm", "redistribute.model", "", "deform/scm.frag", STATE, STATE_CHANGED, 1,
			"sinks, yields and springs back by the soil's pressure, which it remembers"},
	[EFFECT_SPREAD] = {"spread", "redistribute.model", "", "deform/spread.frag", "offset", "offset",
			   DEFORM_WINDOW_POSTS, "lays the soil that an object moved on the nearest free posts"},
	[EFFECT_SHED] = {"shed", "redistribute.model", "", "deform/slide_shed.frag", "base, offset",
			 "offset", 1, "slides soil from steep posts by their roughness"},
	[EFFECT_SLIDE] = {"slide", "redistribute.model", "", "deform/slide_excess.frag",
			  "base, offset, heaped", "offset, heaped", 1,
			  "slides soil down what is steeper than it can stand"},
	[EFFECT_SOIL_MAP] = {"soil_map", "soil.map", "SOIL_MAP", "lib/soil.glsl", "class", "class", 0,
			     "reads which soil each post is of"},
	[EFFECT_MESH] = {"mesh", "objects.shape.mesh", "", "deform/facet.frag", "", "underside", 0,
			 "finds the underside of a shape made of triangles"},
	[EFFECT_LUGS] = {"lugs", "objects.shape.wheel.lugs", "", "deform/facet.frag", "", "underside", 0,
			 "finds the underside of the bars across a wheel's rim, as they turn"},
	[EFFECT_LOAD] = {"load", "objects.load", "", "deform/scm_find.frag", STATE, "height", 1,
			 "finds how deep an object stands for the soil to carry its load"},
	[EFFECT_FORCES] = {"forces", "output.forces", "FORCES", "deform/scm.frag", STATE, "forces", 1,
			   "sums the soil's forces and moments on each object"},
	[EFFECT_DIRT] = {"dirt", "attributes", "", "deform/dirt.frag", "offset, dirt", "dirt", 0,
			 "keeps where the ground was disturbed"},
	[EFFECT_TEXTURE] = {"texture", "view.effects", "TEXTURE", "terrain.frag", "base, offset",
			    "colour", 0, "colours the ground by its height, slope and dirt"},
	[EFFECT_DETAIL] = {"detail", "view.effects", "DETAIL", "terrain.frag", "base, offset",
			   "colour", 0, "adds fine grain to the ground near the eye"},
	[EFFECT_FOG] = {"fog", "view.effects", "FOG", "terrain.frag", "", "colour", 0,
			"fades what is far into the air"},
	[EFFECT_SKY] = {"sky", "view.effects", "", "sky.frag", "", "colour", 0,
			"draws the sky behind the ground"},
	[EFFECT_GEOMORPH] = {"geomorph", "view.effects", "GEOMORPH", "terrain.vert", "base, offset",
			     "depth", 1, "blends each level into the next, so that none pops in"},
	[EFFECT_SKIRTS] = {"skirts", "view.effects", "SKIRTS", "terrain.vert", "base, offset",
			   "depth", 0, "hangs an edge under each tile to hide cracks between levels"},
};

const struct scene_effect_row *scene_effect_row(enum scene_effect effect)
{
	assert((unsigned)effect < EFFECT_COUNT);
	return &rows[effect];
}

static unsigned model_effects(enum deform_model model)
{
	switch (model) {
	case DEFORM_NONE:
		return 1u << EFFECT_DISPLACE;
	case DEFORM_BOX_FILTER:
		return 1u << EFFECT_DISPLACE | 1u << EFFECT_BOX;
	case DEFORM_SUMNER:
		return 1u << EFFECT_SUMNER | 1u << EFFECT_SPREAD | 1u << EFFECT_SHED;
	case DEFORM_SLIPPAGE:
		return 1u << EFFECT_SLIPPAGE | 1u << EFFECT_SPREAD | 1u << EFFECT_SLIDE;
	case DEFORM_SCM:
		return 1u << EFFECT_SCM | 1u << EFFECT_SPREAD | 1u << EFFECT_SLIDE;
	case DEFORM_MODELS:
		break;
	}
	return 0;
}

unsigned scene_effects(const struct scene *scene)
{
	unsigned effects = 0;
	if (scene->object_count > 0) {
		effects |= model_effects(scene->model);
		if (scene->dirt)
			effects |= 1u << EFFECT_DIRT;
		if (scene->soil_map != NULL)
			effects |= 1u << EFFECT_SOIL_MAP;
		if (scene->forces > 0)
			effects |= 1u << EFFECT_FORCES;
	}
	for (size_t i = 0; i < scene->object_count; i++) {
		if (scene->objects[i].shape.kind == DEFORM_MESH)
			effects |= 1u << EFFECT_MESH;
		if (scene->objects[i].shape.lugs > 0)
			effects |= 1u << EFFECT_LUGS;
		if (scene->objects[i].load > 0)
			effects |= 1u << EFFECT_LOAD;
	}
	if (scene->view.present)
		effects |= scene->view.effects;
	return effects;
}
