/* Checks the relief of a scene and fills its values, for all ground or for each class of soil. */
#include <string.h>
#include <xxhash.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"

_Static_assert(RELIEF_CLASSES == SOIL_CLASSES, "a class of relief is a soil");

static enum status check_class(const struct scene_tree *tree, const struct raw_relief *raw, uint32_t index, bool given[RELIEF_CLASSES],
			       struct scene *scene)
{
	const struct raw_relief_class *class = &raw->classes[index];
	const struct scene_node *node = scene_tree_find(tree, "relief.classes[%u].value", index);
	uint8_t soil;
	TRY(scene_check_class(tree, node, (int)class->value, scene, given, &soil));
	scene->relief.waves[soil] =
		(struct relief_waves){class->roughness, class->wavelength != NULL ? *class->wavelength : raw->wavelength};
	return STATUS_OK;
}

/* Which class is where: the raster's bytes, and what each of its values means. */
static void hash_map(const struct scene *scene, uint64_t hash[2])
{
	struct {
		uint64_t raster[2];
		uint8_t classes[sizeof scene->soil_class];
	} parts = {.raster = {scene->soil_map_hash[0], scene->soil_map_hash[1]}};
	memcpy(parts.classes, scene->soil_class, sizeof parts.classes);
	const XXH128_hash_t whole = XXH3_128bits(&parts, sizeof parts);
	hash[0] = whole.high64;
	hash[1] = whole.low64;
}

enum status scene_check_relief(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const struct raw_relief *relief = raw->relief;
	bool given[RELIEF_CLASSES] = {false}, any = false;
	if (relief == NULL)
		return STATUS_OK;
	struct relief_spec *spec = &scene->relief;
	spec->seed = relief->seed != NULL ? (uint32_t)*relief->seed : (uint32_t)scene_absent("relief.seed");
	spec->classes = 1;
	if (relief->classes_count > 0 && scene->soil_map == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "relief.classes"), "is of a map of soils, and there is none; allowed with: "
				   "soil: {map: FILE, classes: {...}, default: ...}");
	if (relief->classes_count > 0) {
		spec->classes = scene->soil_count;
		hash_map(scene, spec->map);
	}
	for (int i = 0; i < spec->classes; i++)
		spec->waves[i] = (struct relief_waves){relief->roughness, relief->wavelength};
	for (uint32_t i = 0; i < relief->classes_count; i++)
		TRY(check_class(tree, relief, i, given, scene));
	for (int i = 0; i < spec->classes; i++)
		any |= spec->waves[i].roughness > 0;
	if (any)
		return STATUS_OK;
	*spec = (struct relief_spec){0};
	return scene_tell_unused(scene, "relief: a roughness of 0 raises nothing; take it away, or give more");
}
