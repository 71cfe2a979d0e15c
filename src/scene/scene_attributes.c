/* Checks what is kept beside the height, and fills its values. */
#include "scene/scene_check.h"
#include "scene/scene_error.h"

static enum status check_class(const struct scene_tree *tree, const struct raw_vegetation *raw, uint32_t index, bool given[SOIL_CLASSES], struct scene *scene)
{
	const struct raw_cover *class = &raw->classes[index];
	const struct scene_node *node = scene_tree_find(tree, "attributes.vegetation.classes[%u].value", index);
	uint8_t soil;
	TRY(scene_check_class(tree, node, (int)class->value, scene, given, &soil));
	scene->vegetation.cover[soil] = class->cover;
	return STATUS_OK;
}

static enum status check_vegetation(const struct scene_tree *tree, const struct raw_vegetation *raw, struct scene *scene)
{
	struct scene_vegetation *vegetation = &scene->vegetation;
	bool given[SOIL_CLASSES] = {false};
	*vegetation = (struct scene_vegetation){
		.present = true,
		.height = scene_number(raw->height, "attributes.vegetation.height"),
		.tears = scene_number(raw->tears, "attributes.vegetation.tears"),
		.rises = scene_number(raw->rises, "attributes.vegetation.rises"),
		.grows = scene_number(raw->grows, "attributes.vegetation.grows"),
	};
	for (int i = 0; i < SOIL_CLASSES; i++)
		vegetation->cover[i] = scene_number(raw->cover, "attributes.vegetation.cover");
	if (raw->classes_count > 0 && scene->soil_map == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "attributes.vegetation.classes"), "is of a map of soils, and there is none; allowed with: "
				   "soil: {map: FILE, classes: {...}, default: ...}");
	for (uint32_t i = 0; i < raw->classes_count; i++)
		TRY(check_class(tree, raw, i, given, scene));
	return STATUS_OK;
}

enum status scene_check_attributes(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const struct raw_attributes *attributes = raw->attributes;
	if (attributes == NULL)
		return STATUS_OK;
	scene->disturbance = attributes->disturbance != NULL;
	if (scene->disturbance && attributes->disturbance->heals != NULL)
		scene->heals = *attributes->disturbance->heals;
	scene->elapsed = scene_number(attributes->elapsed, "attributes.elapsed");
	if (attributes->vegetation != NULL)
		TRY(check_vegetation(tree, attributes->vegetation, scene));
	if (attributes->elapsed != NULL && scene->heals <= 0 && !scene->vegetation.present)
		return scene_error(tree->file, scene_tree_find(tree, "attributes.elapsed"), "is the time in which marks fade, and no mark here does; allowed with: "
				   "disturbance: {heals: 86400}, or vegetation");
	return STATUS_OK;
}
