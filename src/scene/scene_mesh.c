/* Meshes, in a build without them. */
#include "scene/scene_mesh.h"

enum status scene_mesh_load(const char *path, const char *told, double scale, struct deform_mesh **out)
{
	(void)path;
	(void)scale;
	(void)out;
	return fail_with(STATUS_INPUT, "%s: mesh: this furrow was built without meshes; allowed: wheel, sphere, box",
			 told);
}

void scene_mesh_destroy(struct deform_mesh *mesh)
{
	if (mesh == NULL)
		return;
	mem_free(mesh->vertices);
	mem_free(mesh->triangles);
	mem_free(mesh);
}
