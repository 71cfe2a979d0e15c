/* Replaces scene_mesh_import.c in a build without assimp. */
#include "scene/scene_mesh_import.h"

enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners)
{
	*corners = (struct mesh_corners){0};
	return fail_with(STATUS_INPUT, "%s: this build reads no meshes; build it with assimp (-Dmesh=enabled)", told);
}

enum status scene_mesh_import_parts(const char *path, const char *told, struct mesh_corners *corners)
{
	return scene_mesh_import(path, told, corners);
}
