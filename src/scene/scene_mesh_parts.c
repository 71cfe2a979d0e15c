/* Makes the meshes of a mesh file that is to be looked at: one for each of its colours. */
#include <string.h>

#include "scene/scene_mesh_import.h"

/* Scales the corners. A triangle that is mirrored is turned round, so that it is still seen from outside. */
static void scale_corners(struct mesh_corners *corners, const double scale[3])
{
	const bool mirrored = scale[0] * scale[1] * scale[2] < 0;
	for (size_t i = 0; i < 3 * corners->triangles; i++)
		for (int k = 0; k < 3; k++)
			corners->at[i][k] *= scale[k];
	for (size_t t = 0; t < corners->triangles && mirrored; t++) {
		double second[3];
		memcpy(second, corners->at[3 * t + 1], sizeof second);
		memcpy(corners->at[3 * t + 1], corners->at[3 * t + 2], sizeof second);
		memcpy(corners->at[3 * t + 2], second, sizeof second);
	}
}

/* Moves the triangles of a part to the front of `room`. */
static void pick(const struct mesh_corners *all, size_t part, struct mesh_corners *room)
{
	room->triangles = 0;
	for (size_t t = 0; t < all->triangles; t++)
		if (all->parts[t] == part)
			memcpy(room->at[3 * room->triangles++], all->at[3 * t], 3 * sizeof *all->at);
}

static enum status make_parts(const struct mesh_corners *all, const char *told, struct scene_mesh_part *parts, size_t *count)
{
	struct mesh_corners room = {.at = NULL};
	enum status status;
	TRY(mem_make(&room.at, 3 * all->triangles + 1, sizeof *room.at, "a mesh"));
	for (size_t i = 0; i < all->part_count; i++) {
		struct scene_mesh_part *part = &parts[*count];
		pick(all, i, &room);
		if (room.triangles == 0)
			continue;
		++*count;
		TRY_OR(done, mem_zeroed(&part->mesh, 1, sizeof *part->mesh, "a mesh"));
		memcpy(part->colour, all->colours[i], sizeof part->colour);
		part->coloured = all->colours[i][3] > 0;
		status = scene_mesh_of(&room, told, 1, part->mesh);
		if (status == STATUS_OK)
			continue;
		if (status != STATUS_INPUT)
			goto done;
		scene_mesh_destroy(part->mesh); /* no triangle of this colour has an area */
		*part = (struct scene_mesh_part){.mesh = NULL};
		--*count;
	}
	status = *count > 0 ? STATUS_OK : fail_with(STATUS_INPUT, "%s: none of its triangles has an area; needed: a surface", told);
done:
	mem_free(room.at);
	return status;
}

enum status scene_mesh_parts_load(const char *path, const char *told, const double scale[3], struct scene_mesh_part **parts, size_t *count)
{
	struct mesh_corners corners = {.at = NULL};
	enum status status;
	*count = 0;
	*parts = NULL;
	TRY_OR(done, scene_mesh_import_parts(path, told, &corners));
	scale_corners(&corners, scale);
	TRY_OR(done, scene_mesh_check(&corners, told, 1));
	TRY_OR(done, mem_zeroed(parts, corners.part_count + 1, sizeof **parts, "a mesh"));
	TRY_OR(done, make_parts(&corners, told, *parts, count));
done:
	mem_free_all(corners.at, corners.parts, corners.colours);
	return status;
}

void scene_mesh_parts_destroy(struct scene_mesh_part *parts, size_t count)
{
	for (size_t i = 0; parts != NULL && i < count; i++)
		scene_mesh_destroy(parts[i].mesh);
	mem_free(parts);
}
