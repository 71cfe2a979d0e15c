/* Takes the rocks of a scene. Their soil is checked with the other ones. */
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_schema.h"

enum status scene_rocks_take(const struct scene_tree *tree, const struct raw_ground *raw, struct scene *scene)
{
	const struct raw_rocks *rocks = raw != NULL ? raw->rocks : NULL;
	if (rocks == NULL)
		return STATUS_OK;
	if (!(rocks->cover > 0))
		return scene_tell_unused(scene, "ground.rocks: a cover of 0 has no rocks; take it away, or give more");
	const struct rocks_spec spec = {
		.cover = rocks->cover,
		.k = rocks->k != NULL ? *rocks->k : rocks->cover,
		.smallest = rocks->smallest != NULL ? *rocks->smallest : 0,
		.largest = rocks->largest,
		.seed = rocks->seed != NULL ? (uint32_t)*rocks->seed : (uint32_t)scene_absent("ground.rocks.seed"),
	};
	if (spec.smallest >= spec.largest)
		return scene_error(tree->file, scene_tree_find(tree, "ground.rocks.smallest"), "%g m is not below the largest, %g m; allowed: less than that", spec.smallest,
				   spec.largest);
	if (spec.smallest > 0 && spec.smallest * ROCKS_RANGE < spec.largest)
		return scene_error(tree->file, scene_tree_find(tree, "ground.rocks.smallest"), "%g m is less than 1/%d of the largest, %g m; allowed: %g m and more", spec.smallest,
				   ROCKS_RANGE, spec.largest, spec.largest / ROCKS_RANGE);
	scene->rocks = spec;
	return STATUS_OK;
}
