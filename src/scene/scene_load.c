/* Makes a scene from a text or a file. Steps: tree, settings, short forms, typed values, checks. */
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_alias.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_fold.h"
#include "scene/scene_read.h"
#include "scene/scene_set.h"
#include "scene/scene_template.h"
#include "scene/scene_values.h"

/* Makes the tree of the scene from `text`, in tree->root. Replaces old names of keys, applies the settings, and expands the short
 * forms. */
static enum status read_tree(struct scene_tree *tree, const char *text, size_t length,
			     const struct scene_setting *settings, size_t count)
{
	TRY(scene_tree_parse(tree->file, NULL, text, length, &tree->root));
	if (tree->root->kind != SCENE_MAPPING)
		return scene_error(tree->file, tree->root, "not a scene; allowed: a mapping of keys");
	TRY(scene_alias(tree));
	for (size_t i = 0; i < count; i++)
		TRY(scene_set(tree, &settings[i]));
	if (count > 0)
		TRY(scene_alias(tree)); /* the values of the settings may have old names, too */
	TRY(scene_template(tree));
	TRY(scene_fold(tree));
	return scene_tree_list(tree);
}

/* Fills the scene from `text`. The caller has already set the members file, folder and hosted. */
static enum status fill(struct scene *scene, const char *text, size_t length,
			const struct scene_setting *settings, size_t count)
{
	struct scene_tree tree = {.file = scene->file, .folder = scene->folder, .hosted = scene->hosted};
	struct raw_scene *raw = NULL;
	enum status status;
	TRY_OR(done, read_tree(&tree, text, length, settings, count));
	TRY_OR(done, scene_read(&tree, &raw));
	TRY_OR(done, scene_check(&tree, raw, scene));
	TRY_OR(done, scene_values_take(&tree, scene));
done:
	scene_raw_destroy(raw);
	scene_tree_finish(&tree);
	return status;
}

/* Makes a scene from a text. `name`: the name of the text in messages. `beside`: the folder for the files that the scene names, or
 * a file in that folder. */
static enum status load(const char *name, const char *beside, const char *text, size_t length,
			const struct scene_setting *settings, size_t count, enum scene_reader reader,
			struct scene **out)
{
	struct scene *scene = mem_calloc(1, sizeof *scene);
	enum status status;
	if (scene == NULL || (scene->file = mem_strdup(name)) == NULL)
		TRY_OR(failed, fail_memory("reading the scene"));
	scene->hosted = reader == SCENE_HOST;
	TRY_OR(failed, scene_folder_of(beside, scene->hosted, &scene->folder));
	TRY_OR(failed, fill(scene, text, length, settings, count));
	*out = scene;
	return STATUS_OK;
failed:
	scene_destroy(scene);
	return status;
}

enum status scene_load_file(const char *path, const struct scene_setting *settings, size_t count,
			    enum scene_reader reader, struct scene **out)
{
	char *text;
	size_t length;
	*out = NULL;
	TRY(scene_file_read(path, path, SCENE_BYTES, &text, &length));
	const enum status status = load(path, path, text, length, settings, count, reader, out);
	mem_free(text);
	return status;
}

enum status scene_load(const char *path, const struct scene_setting *settings, size_t count,
		       struct scene **out)
{
	return scene_load_file(path, settings, count, SCENE_COMMAND, out);
}

static const char name[] = "scene text";

const char *scene_text_reason(const char *message)
{
	const size_t length = strlen(name);
	if (strncmp(message, name, length) != 0 || message[length] != ':')
		return message;
	const char *reason = message + length + 1;
	for (int i = 0; i < 2; i++) { /* line and column */
		reason += strspn(reason, "0123456789");
		reason += *reason == ':';
	}
	return reason + (*reason == ' ');
}

enum status scene_load_text(const char *text, const char *folder, const struct scene_setting *settings,
			    size_t count, enum scene_reader reader, struct scene **out)
{
	size_t length = strnlen(text, SCENE_BYTES + 1), folder_length = folder != NULL ? strlen(folder) : 0;
	*out = NULL;
	if (length > SCENE_BYTES)
		return fail_with(STATUS_INPUT, "%s: it is too large; allowed: %u bytes", name, SCENE_BYTES);
	char *beside = mem_alloc(folder_length + 2, 1);
	TRY_MEM(beside, "reading the scene");
	snprintf(beside, folder_length + 2, "%s%s", folder_length > 0 ? folder : "", folder_length > 0 ? "/" : "");
	enum status status = load(name, beside, text, length, settings, count, reader, out);
	mem_free(beside);
	return status;
}

void scene_destroy(struct scene *scene)
{
	if (scene == NULL)
		return;
	for (size_t i = 0; i < scene->object_count; i++)
		scene_object_finish(&scene->objects[i]);
	for (size_t i = 0; i < scene->vehicle_count; i++)
		scene_vehicle_finish(&scene->vehicles[i]);
	mem_free(scene->vehicles);
	if (scene->things != NULL)
		scene_vehicle_finish(scene->things);
	mem_free(scene->things);
	for (size_t i = 0; i < scene->camera_count; i++)
		scene_camera_finish(&scene->cameras[i]);
	mem_free(scene->cameras);
	for (size_t i = 0; i < scene->lidar_count; i++)
		scene_lidar_finish(&scene->lidars[i]);
	mem_free(scene->lidars);
	scene_roads_finish(scene);
	mem_free_list(scene->unused, scene->unused_count);
	scene_drop_doubts(scene);
	scene_values_finish(scene);
	mem_free_all(scene->objects, scene->file, scene->folder, scene->store, scene->soil_map);
	for (int i = 0; i < scene->raster_count; i++)
		mem_free(scene->rasters[i].path);
	mem_free_all(scene->srs, scene);
}
