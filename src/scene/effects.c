/* The one table of effects: what each is called, what calls for it, and what it costs. */
#include <assert.h>

#include "scene/scene.h"

static const struct scene_effect_row rows[EFFECT_COUNT] = {
	[EFFECT_DISPLACE] = {"displace", "objects", "", "deform/none.frag", "base, offset",
			     "offset", 0, "presses each object's underside into the ground"},
	[EFFECT_BOX] = {"box", "redistribute.model", "", "deform/box.frag", "base, offset", "offset",
			1, "smooths the trail: the mean offset of the posts around each"},
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

unsigned scene_effects(const struct scene *scene)
{
	unsigned effects = 0;
	if (scene->object_count > 0) {
		effects |= 1u << EFFECT_DISPLACE;
		if (scene->model == DEFORM_BOX_FILTER)
			effects |= 1u << EFFECT_BOX;
		if (scene->dirt)
			effects |= 1u << EFFECT_DIRT;
	}
	if (scene->view.present)
		effects |= scene->view.effects;
	return effects;
}
