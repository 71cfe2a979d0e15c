/*
 * What pictures show of a URDF: its <visual>s. MuJoCo does not know them: it would take time and memory for them in each step, and refuses meshes that it
 * cannot weigh. So a drive with pictures has the bits of one without.
 *
 * A file that is missing or cannot be read is told, and never ends a drive. A body without any visual is shown by what collides.
 */
#include <math.h>
#include <string.h>

#include "scene/scene.h"
#include "vehicle/figures.h"
#include "vehicle/spec.h"
#include "vehicle/urdf.h"

#define SEEN_TRIANGLES 8000000u /* most triangles of all files of a scene */
#define NEARLY 1e-3             /* of a size: a visual that differs less from a wheel is the wheel */

struct visuals {
	struct vehicles *vehicles;
	size_t vehicle;
	const struct urdf *urdf;
	struct spec spec;           /* for its names and folders alone */
	struct spec_names missing, strange;
	size_t textured;
	bool *hidden;
};

static const struct vehicle *vehicle_of(const struct visuals *visuals)
{
	return &visuals->vehicles->list[visuals->vehicle];
}

/* --- files --- */

static size_t triangles_of(const struct vehicles *vehicles)
{
	size_t triangles = 0;
	for (size_t i = 0; i < vehicles->seen_count; i++)
		for (size_t p = 0; p < vehicles->seen[i].count; p++)
			triangles += vehicles->seen[i].parts[p].mesh->triangle_count;
	return triangles;
}

/* Reads a mesh, or finds it among those that were read. A file that is no mesh has no parts. */
static enum status see(struct visuals *visuals, const char *path, const double scale[3], const struct seen_mesh **out)
{
	struct vehicles *vehicles = visuals->vehicles;
	for (size_t i = 0; i < vehicles->seen_count; i++)
		if (strcmp(vehicles->seen[i].path, path) == 0 && memcmp(vehicles->seen[i].scale, scale, sizeof vehicles->seen[i].scale) == 0) {
			*out = &vehicles->seen[i];
			return STATUS_OK;
		}
	TRY(mem_grow(&vehicles->seen, &vehicles->seen_room, vehicles->seen_count + 1, sizeof *vehicles->seen, "the parts of a vehicle"));
	struct seen_mesh *seen = &vehicles->seen[vehicles->seen_count];
	*seen = (struct seen_mesh){.path = mem_strdup(path)};
	TRY_MEM(seen->path, "the parts of a vehicle");
	memcpy(seen->scale, scale, sizeof seen->scale);
	vehicles->seen_count++;
	*out = seen;
	if (triangles_of(vehicles) > SEEN_TRIANGLES)
		return STATUS_OK;
	const enum status status = scene_mesh_parts_load(path, visuals->spec.path, scale, &seen->parts, &seen->count);
	if (status == STATUS_OK)
		return STATUS_OK;
	scene_mesh_parts_destroy(seen->parts, seen->count);
	seen->parts = NULL;
	seen->count = 0;
	return status == STATUS_INPUT ? STATUS_OK : status;
}

/* --- figures --- */

/* Finds the body that a link is part of, and the link's place on it. */
static int body_of(const struct visuals *visuals, size_t link, struct urdf_place *place)
{
	const struct vehicle *vehicle = vehicle_of(visuals);
	const struct range bodies = vehicle->own.body;
	*place = (struct urdf_place){{0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
	for (size_t far = 0; link != SIZE_MAX && far <= visuals->urdf->link_count; far++) {
		const struct urdf_link *at = &visuals->urdf->links[link];
		for (int i = bodies.first; i < bodies.end; i++) {
			const char *name = vehicle_part_name(vehicle->model, mjOBJ_BODY, i);
			if (name != NULL && at->name != NULL && strcmp(name, at->name) == 0)
				return i;
		}
		vehicle_urdf_join(&at->place, place, place);
		link = at->parent;
	}
	return -1;
}

/* Returns the wheel that a cylinder of a body is, so that it is drawn as a tyre on a rim. NULL: it is none. */
static const struct soil_geom *wheel_of(const struct vehicle *vehicle, int body, const struct urdf_visual *visual, const struct urdf_place *place)
{
	for (size_t g = 0; g < vehicle->geom_count && visual->form == URDF_CYLINDER; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		const double *at = &vehicle->model->geom_pos[3 * geom->geom], apart = mju_dist3(at, place->at), near = NEARLY * visual->size[0];
		if (vehicle->model->geom_type[geom->geom] == mjGEOM_CYLINDER && geom->shape.kind == SOIL_WHEEL && vehicle->model->geom_bodyid[geom->geom] == body && apart <= near &&
		    fabs(geom->shape.radius - visual->size[0]) <= near && fabs(geom->shape.width - visual->size[1]) <= near)
			return geom;
	}
	return NULL;
}

static enum status add(struct visuals *visuals, const struct urdf_visual *visual, int body, const struct urdf_place *place, const struct soil_shape *shape, const float colour[3])
{
	const struct vehicle *vehicle = vehicle_of(visuals);
	const struct soil_geom *wheel = wheel_of(vehicle, body, visual, place);
	struct figure *figure;
	struct scene_object *drawn;
	struct world_look *look;
	const char *name = visuals->urdf->links[visual->link].name;
	TRY(vehicle_add_figure(visuals->vehicles, visuals->vehicle, body, name != NULL ? name : "a link", &figure, &drawn, &look));
	memcpy(figure->at, place->at, sizeof figure->at);
	memcpy(figure->axes, place->axes, sizeof figure->axes);
	drawn->shape = *shape;
	if (wheel != NULL) {
		figure->geom = wheel->geom;
		memcpy(figure->axes, wheel->axes, sizeof figure->axes);
		drawn->shape = wheel->shape;
	}
	if (colour != NULL)
		vehicle_paint(look, colour);
	visuals->hidden[body - vehicle->own.body.first] = true;
	return STATUS_OK;
}

static enum status add_mesh(struct visuals *visuals, const struct urdf_visual *visual, int body, const struct urdf_place *place)
{
	const struct seen_mesh *seen = NULL;
	char path[PATH_MAX];
	if (visual->file == NULL)
		return STATUS_OK;
	if (!vehicle_spec_find(&visuals->spec, visual->file, path)) {
		vehicle_spec_name(&visuals->missing, vehicle_spec_base(visual->file));
		return STATUS_OK;
	}
	TRY(see(visuals, path, visual->size, &seen));
	if (seen->count == 0)
		vehicle_spec_name(&visuals->strange, vehicle_spec_base(visual->file));
	for (size_t i = 0; i < seen->count; i++) {
		const struct scene_mesh_part *part = &seen->parts[i];
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = part->mesh};
		TRY(add(visuals, visual, body, place, &shape, visual->coloured ? visual->colour : part->coloured ? part->colour : NULL));
	}
	return STATUS_OK;
}

static enum status add_visual(struct visuals *visuals, const struct urdf_visual *visual)
{
	const double *size = visual->size;
	struct urdf_place place;
	const int body = body_of(visuals, visual->link, &place);
	if (body < 0 || (visual->coloured && visual->colour[3] < FIGURE_CLEAR))
		return STATUS_OK;
	vehicle_urdf_join(&place, &visual->place, &place);
	visuals->textured += visual->textured && !visual->coloured;
	const float *colour = visual->coloured ? visual->colour : NULL;
	struct soil_shape shape = {.kind = SOIL_BOX, .size = {size[0], size[1], size[2]}};
	switch (visual->form) {
	case URDF_NONE:
		return STATUS_OK;
	case URDF_MESH:
		return add_mesh(visuals, visual, body, &place);
	case URDF_CYLINDER:
	case URDF_CAPSULE:
		shape = (struct soil_shape){.kind = visual->form == URDF_CYLINDER ? SOIL_CYLINDER : SOIL_CAPSULE, .radius = size[0], .length = size[1]};
		break;
	case URDF_SPHERE:
		shape = (struct soil_shape){.kind = SOIL_SPHERE, .radius = size[0]};
		break;
	case URDF_BOX:
		break;
	}
	return soil_shape_bound(&shape) > 0 ? add(visuals, visual, body, &place, &shape, colour) : STATUS_OK;
}

static void tell(struct visuals *visuals)
{
	struct spec *spec = &visuals->spec;
	if (visuals->missing.count > 0)
		vehicle_spec_tell(spec, "pictures lack %zu visual mesh%s (%s), whose files are not found: bodies without any show what collides; name the folder of its packages in model_path",
				  visuals->missing.count, visuals->missing.count > 1 ? "es" : "", visuals->missing.text);
	if (visuals->strange.count > 0)
		vehicle_spec_tell(spec, "pictures lack %zu visual mesh%s (%s), whose files cannot be read: bodies without any show what collides; export them as OBJ, STL or COLLADA",
				  visuals->strange.count, visuals->strange.count > 1 ? "es" : "", visuals->strange.text);
	if (visuals->textured > 0)
		vehicle_spec_tell(spec, "%zu of its visuals have textures, which pictures do not show: they have the colour of their mesh; give their material a color", visuals->textured);
}

enum status vehicle_add_visuals(struct vehicles *vehicles, size_t index, bool *hidden)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	struct urdf urdf;
	struct visuals visuals = {.vehicles = vehicles, .vehicle = index, .urdf = &urdf, .spec = {.path = vehicle->scene->model, .scene = vehicle->scene}, .hidden = hidden};
	char where[VEHICLE_WHERE];
	enum status status;
	vehicle_where(vehicle, vehicles->scene, where);
	visuals.spec.where = where;
	TRY_OR(done, vehicle_urdf_read(where, vehicle->scene->model, &urdf));
	visuals.spec.meshdir = urdf.meshdir;
	for (size_t i = 0; i < urdf.visual_count; i++)
		TRY_OR(done, add_visual(&visuals, &urdf.visuals[i]));
	tell(&visuals);
done:
	vehicle_urdf_finish(&urdf);
	vehicle_spec_free(&visuals.spec);
	return status;
}

void vehicle_free_seen(struct vehicles *vehicles)
{
	for (size_t i = 0; i < vehicles->seen_count; i++) {
		scene_mesh_parts_destroy(vehicles->seen[i].parts, vehicles->seen[i].count);
		mem_free(vehicles->seen[i].path);
	}
	mem_free(vehicles->seen);
}
