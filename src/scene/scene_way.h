/* Ways of objects and vehicles: reads what the scene says of a path, and finds the paths that follow others. */
#ifndef FURROW_SCENE_WAY_H
#define FURROW_SCENE_WAY_H

#include "scene/scene.h"
#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

/* Fills `path` from the mapping at `where` ("objects[1].path"). A path that is relative to another object's gets no points here. */
enum status scene_way_take(const struct scene_tree *tree, const struct raw_path *raw, const char *where, struct scene_path *path)
	FURROW_CHECKED;

/* Gives each path that is relative to another object's the waypoints of that one. Call this when all objects have their names. */
enum status scene_way_follow(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene) FURROW_CHECKED;

#endif
