/* A file to a scene: text, tree, settings, schema, types, checks. */
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_match.h"
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

/* A camera may be written flat, {over, height}, as well as under its name: moves the keys there. */
static enum status fold_camera(struct scene_node *camera, const char *name,
			       const char *const keys[2])
{
	struct scene_node *inner = NULL;
	if (scene_node_child(camera, name) != NULL)
		return STATUS_OK;
	for (int i = 0; i < 2; i++) {
		struct scene_node *child = scene_node_child(camera, keys[i]);
		if (child == NULL)
			continue;
		if (inner == NULL) {
			inner = scene_node_create(SCENE_MAPPING, name);
			if (inner == NULL)
				return fail_memory("reading the scene");
			inner->line = child->line;
			inner->setting = child->setting;
			scene_node_append(camera, inner);
		}
		scene_node_remove(child);
		scene_node_append(inner, child);
	}
	return STATUS_OK;
}

static enum status fold_cameras(struct scene_tree *tree)
{
	static const char *const overhead[] = {"over", "height"}, *const fixed[] = {"eye", "target"};
	struct scene_node *view = scene_node_child(tree->root, "view");
	struct scene_node *camera = view != NULL ? scene_node_child(view, "camera") : NULL;
	if (camera == NULL || camera->kind != SCENE_MAPPING)
		return STATUS_OK;
	enum status status = fold_camera(camera, "overhead", overhead);
	return status != STATUS_OK ? status : fold_camera(camera, "fixed", fixed);
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
		status = fold_cameras(&tree);
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
		mem_free(scene->objects[i].name);
		mem_free(scene->objects[i].path.points);
	}
	mem_free(scene->objects);
	mem_free(scene->file);
	mem_free(scene->store);
	mem_free(scene->soil);
	mem_free(scene->srs);
	mem_free(scene);
}
