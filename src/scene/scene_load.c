/* A file to a scene: text, tree, settings, shorthands, schema, types, checks. */
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_fold.h"
#include "scene/scene_match.h"
#include "scene/scene_mesh.h"
#include "scene/scene_set.h"
#include "scene/scene_typed.h"

static enum status read_tree(const char *path, struct scene_tree *tree)
{
	char *text;
	size_t length;
	enum status status = scene_file_read(path, path, SCENE_BYTES, &text, &length);
	if (status != STATUS_OK)
		return status;
	status = scene_tree_parse(path, NULL, text, length, &tree->root);
	mem_free(text);
	if (status == STATUS_OK && tree->root->kind != SCENE_MAPPING)
		return scene_error(path, tree->root, "not a scene; allowed: a mapping of keys");
	return status;
}

enum status scene_load(const char *path, const struct scene_setting *settings, size_t count,
		       struct scene **out)
{
	struct scene_tree tree = {.file = path};
	struct raw_scene *raw = NULL;
	struct scene *scene = NULL;
	enum status status;

	*out = NULL;
	status = read_tree(path, &tree);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = scene_set(&tree, &settings[i]);
	if (status == STATUS_OK)
		status = scene_fold(&tree);
	if (status == STATUS_OK)
		status = scene_match(&tree);
	if (status == STATUS_OK)
		status = scene_typed_load(&tree, &raw);
	if (status != STATUS_OK)
		goto out;
	scene = mem_calloc(1, sizeof *scene);
	if (scene == NULL || (scene->file = mem_strdup(path)) == NULL) {
		status = fail_memory("reading the scene");
		goto out;
	}
	status = scene_check(&tree, raw, scene);
out:
	scene_typed_destroy(raw);
	scene_tree_finish(&tree);
	if (status == STATUS_OK)
		*out = scene;
	else
		scene_destroy(scene);
	return status;
}

void scene_destroy(struct scene *scene)
{
	if (scene == NULL)
		return;
	for (size_t i = 0; i < scene->object_count; i++) {
		scene_mesh_destroy(scene->objects[i].mesh);
		mem_free(scene->objects[i].name);
		mem_free(scene->objects[i].path.points);
	}
	for (size_t i = 0; i < scene->unused_count; i++)
		mem_free(scene->unused[i]);
	mem_free(scene->unused);
	mem_free(scene->objects);
	mem_free(scene->file);
	mem_free(scene->store);
	mem_free(scene->soil_map);
	mem_free(scene->srs);
	mem_free(scene);
}
