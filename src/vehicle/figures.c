/*
 * What pictures show of vehicles: the <visual>s of a URDF, and geoms of the groups 0 to 2, as MuJoCo's viewer does. A body that has
 * visuals shows them in place of its geoms. A vehicle without any of these is shown by its geoms of all groups, or it would not be seen.
 */
#include <stdio.h>
#include <string.h>

#include "vehicle/figures.h"
#include "vehicle/settle.h"

static bool is_shown(const struct vehicle *vehicle, int geom, bool all)
{
	const mjModel *model = vehicle->model;
	const int type = model->geom_type[geom];
	return (vehicle->is_world || !vehicle_is_fixed(model, geom)) && (all || model->geom_group[geom] < FIGURE_GROUPS) && type != mjGEOM_PLANE && type != mjGEOM_HFIELD &&
	       vehicle_alpha_of(model, geom) >= FIGURE_CLEAR;
}

/* What is fixed to MuJoCo's world is one body of `world`, before its others. */
static size_t bodies_of(const struct vehicle *vehicle)
{
	return range_count(vehicle->own.body) + vehicle->is_world;
}

/* Returns the first number of a vehicle's bodies in body_names. */
static size_t first_body(const struct vehicles *vehicles, size_t vehicle)
{
	size_t first = 0;
	for (size_t v = 0; v < vehicle; v++)
		first += bodies_of(&vehicles->list[v]);
	return first;
}

enum status vehicle_add_figure(struct vehicles *vehicles, size_t vehicle, int body, const char *name, struct figure **figure, struct scene_object **drawn, struct world_look **look)
{
	const size_t at = vehicles->figure_count;
	TRY(mem_grow(&vehicles->figures, &vehicles->figure_room, at + 1, sizeof *vehicles->figures, "the parts of a vehicle"));
	TRY(mem_grow(&vehicles->drawn, &vehicles->drawn_room, at + 1, sizeof *vehicles->drawn, "the parts of a vehicle"));
	TRY(mem_grow(&vehicles->looks, &vehicles->look_room, at + 1, sizeof *vehicles->looks, "the parts of a vehicle"));
	*figure = &vehicles->figures[at];
	*drawn = &vehicles->drawn[at];
	*look = &vehicles->looks[at];
	**figure = (struct figure){.vehicle = vehicle, .body = body, .geom = -1, .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
	**drawn = (struct scene_object){.name = mem_strdup(name)};
	**look = (struct world_look){.body = first_body(vehicles, vehicle) + (body > 0 ? (size_t)(body - vehicles->list[vehicle].own.body.first) + vehicles->list[vehicle].is_world : 0)};
	vehicles->figure_count++;
	return (*drawn)->name != NULL ? STATUS_OK : fail_memory("the parts of a vehicle");
}

/* Gives the mesh of an earlier figure that shows the same; NULL: none does. */
static struct soil_mesh *same_mesh(const struct vehicles *vehicles, const mjModel *model, int geom)
{
	for (size_t i = 0; i + 1 < vehicles->figure_count && model->geom_type[geom] == mjGEOM_MESH; i++) {
		const struct figure *figure = &vehicles->figures[i];
		if (figure->mesh != NULL && figure->geom >= 0 && vehicles->list[figure->vehicle].model == model && model->geom_type[figure->geom] == mjGEOM_MESH &&
		    model->geom_dataid[figure->geom] == model->geom_dataid[geom])
			return figure->mesh;
	}
	return NULL;
}

static enum status set_shape(const struct vehicles *vehicles, const mjModel *model, struct figure *figure, struct soil_shape *shape)
{
	const double *size = &model->geom_size[3 * figure->geom];
	if (vehicle_plain_shape(model, figure->geom, shape))
		return STATUS_OK;
	if (model->geom_type[figure->geom] != mjGEOM_MESH) { /* an SDF */
		*shape = (struct soil_shape){.kind = SOIL_ELLIPSOID, .size = {size[0], size[1], size[2]}};
		return STATUS_OK;
	}
	*shape = (struct soil_shape){.kind = SOIL_MESH, .mesh = same_mesh(vehicles, model, figure->geom)};
	if (shape->mesh == NULL)
		TRY(vehicle_make_mesh(model, figure->geom, &figure->mesh));
	shape->mesh = shape->mesh != NULL ? shape->mesh : figure->mesh;
	return STATUS_OK;
}

static enum status add_geom(struct vehicles *vehicles, size_t index, int geom)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjModel *model = vehicle->model;
	const struct soil_geom *soil = vehicle_soil_geom_of(vehicle, geom);
	struct figure *figure;
	struct scene_object *drawn;
	struct world_look *look;
	char name[256];
	vehicle_geom_name(vehicle, geom, name, sizeof name);
	TRY(vehicle_add_figure(vehicles, index, model->geom_bodyid[geom], name, &figure, &drawn, &look));
	figure->geom = geom;
	vehicle_look_of(model, geom, look);
	if (soil == NULL || soil->shape.kind != SOIL_WHEEL || model->geom_type[geom] != mjGEOM_CYLINDER)
		return set_shape(vehicles, model, figure, &drawn->shape);
	memcpy(figure->axes, soil->axes, sizeof figure->axes); /* a tyre on a rim, with its grousers */
	drawn->shape = soil->shape;
	return STATUS_OK;
}

static enum status add_geoms(struct vehicles *vehicles, size_t index, const bool *hidden, bool all)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	for (int i = vehicle->own.fixed.first; i < vehicle->own.fixed.end; i++)
		if (is_shown(vehicle, i, all))
			TRY(add_geom(vehicles, index, i));
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++)
		if (is_shown(vehicle, i, all) && !hidden[vehicle->model->geom_bodyid[i] - vehicle->own.body.first])
			TRY(add_geom(vehicles, index, i));
	return STATUS_OK;
}

static enum status add_vehicle(struct vehicles *vehicles, size_t index)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const size_t before = vehicles->figure_count;
	bool *hidden;
	enum status status;
	TRY(mem_zeroed(&hidden, range_count(vehicle->own.body) + 1, sizeof *hidden, "the parts of a vehicle"));
	TRY_OR(done, vehicle_add_visuals(vehicles, index, hidden));
	TRY_OR(done, add_geoms(vehicles, index, hidden, false));
	if (vehicles->figure_count > before)
		goto done;
	TRY_OR(done, add_geoms(vehicles, index, hidden, true));
	if (vehicles->figure_count > before)
		note("vehicles.%s: none of its geoms is in groups 0 to 2: pictures show those of all groups", vehicle->scene->name);
done:
	mem_free(hidden);
	return status;
}

/* Names all bodies, in the order in which pictures number them. */
static enum status name_bodies(struct vehicles *vehicles)
{
	const size_t all = first_body(vehicles, vehicles->all);
	TRY(mem_zeroed(&vehicles->body_names, all + 1, sizeof *vehicles->body_names, "the parts of a vehicle"));
	for (size_t v = 0; v < vehicles->all; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		if (vehicle->is_world) {
			vehicles->body_names[vehicles->body_count] = mem_strdup(vehicle->scene->name);
			TRY_MEM(vehicles->body_names[vehicles->body_count++], "the parts of a vehicle");
		}
		for (int i = vehicle->own.body.first; i < vehicle->own.body.end; i++) {
			const char *bare = vehicle_part_name(vehicle->model, mjOBJ_BODY, i);
			char own[24], name[300];
			snprintf(own, sizeof own, "body_%d", i - vehicle->own.body.first + 1);
			snprintf(name, sizeof name, "%.128s.%.128s", vehicle->scene->name, bare != NULL && bare[0] != '\0' ? bare : own);
			vehicles->body_names[vehicles->body_count] = mem_strdup(name);
			TRY_MEM(vehicles->body_names[vehicles->body_count++], "the parts of a vehicle");
		}
	}
	return STATUS_OK;
}

/* A frame for the root body of each vehicle, and one for each body that a camera of the scene names. */
static void list_frames(struct vehicles *vehicles)
{
	const struct scene *scene = vehicles->scene;
	for (size_t v = 0; v < vehicles->count; v++)
		vehicles->frames[vehicles->frame_count++].vehicle = v;
	for (size_t i = 0; i < scene->camera_count; i++)
		if (scene->cameras[i].body != NULL)
			vehicles->frames[vehicles->frame_count++] = (struct world_frame){.vehicle = scene->cameras[i].aim.vehicle - 1, .body = scene->cameras[i].body};
}

/* Tells once of textures, which pictures do not show. */
static void tell_textures(const struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++) {
		size_t count = 0;
		for (size_t i = 0; i < vehicles->figure_count; i++)
			count += vehicles->figures[i].vehicle == v && vehicles->figures[i].geom >= 0 && vehicle_has_pattern(vehicles->model, vehicles->figures[i].geom);
		if (count > 0)
			note("%s%s: %zu of its geoms ha%s textures: pictures show their mean colour", vehicles->list[v].is_world ? "" : "vehicles.", vehicles->list[v].scene->name, count,
			     count == 1 ? "s" : "ve");
	}
}

enum status vehicle_make_figures(struct vehicles *vehicles, uint64_t effects)
{
	vehicles->frames = mem_calloc(vehicles->count + vehicles->scene->camera_count, sizeof *vehicles->frames);
	TRY_MEM(vehicles->frames, "the parts of a vehicle");
	list_frames(vehicles);
	TRY(name_bodies(vehicles));
	for (size_t v = 0; v < vehicles->all && (effects >> EFFECT_OBJECTS & 1); v++)
		TRY(add_vehicle(vehicles, v));
	tell_textures(vehicles);
	return mem_zeroed(&vehicles->places, vehicles->figure_count + 1, sizeof *vehicles->places, "the parts of a vehicle");
}

enum status vehicle_draw(struct vehicles *vehicles, uint64_t effects)
{
	if (vehicles == NULL || vehicles->frames != NULL)
		return STATUS_OK;
	TRY(vehicle_make_figures(vehicles, effects));
	vehicle_show(vehicles);
	return STATUS_OK;
}

void vehicle_free_figures(struct vehicles *vehicles)
{
	for (size_t i = 0; i < vehicles->figure_count; i++) {
		mem_free(vehicles->drawn[i].name);
		vehicle_free_mesh(vehicles->figures[i].mesh);
	}
	for (size_t i = 0; i < vehicles->body_count; i++)
		mem_free(vehicles->body_names[i]);
	vehicle_free_seen(vehicles);
	mem_free_all(vehicles->drawn, vehicles->figures, vehicles->looks, vehicles->body_names, vehicles->places, vehicles->frames);
}

/* --- where they are --- */

/* Sets a place from a middle, and axes as the columns of a matrix, in a vehicle's own coordinates. */
static void set_place(const struct vehicle *vehicle, const double middle[3], const double columns[9], struct world_place *place)
{
	place->there = vehicle->begun != VEHICLE_ABOVE;
	for (int i = 0; i < 3; i++) {
		place->at[i] = vehicle->origin[i] + middle[i];
		for (int k = 0; k < 3; k++)
			place->axes[i][k] = columns[3 * k + i];
	}
}

void vehicle_show(struct vehicles *vehicles)
{
	for (size_t i = 0; i < vehicles->figure_count; i++) {
		const struct figure *figure = &vehicles->figures[i];
		const struct vehicle *vehicle = &vehicles->list[figure->vehicle];
		const double *mat = figure->geom >= 0 ? &vehicle->data->geom_xmat[9 * figure->geom] : &vehicle->data->xmat[9 * figure->body];
		double columns[9], middle[3];
		mju_mulMatMat(columns, mat, figure->axes, 3, 3, 3);
		mju_mulMatVec3(middle, mat, figure->at);
		mju_addTo3(middle, figure->geom >= 0 ? &vehicle->data->geom_xpos[3 * figure->geom] : &vehicle->data->xpos[3 * figure->body]);
		set_place(vehicle, middle, columns, &vehicles->places[i]);
	}
	for (size_t i = 0; i < vehicles->frame_count; i++) {
		struct world_frame *frame = &vehicles->frames[i];
		const struct vehicle *vehicle = &vehicles->list[frame->vehicle];
		const int body = frame->body != NULL ? vehicle_find_part(vehicle, mjOBJ_BODY, frame->body) : vehicle->root;
		double axes[9];
		vehicle_root_axes(vehicle, vehicle->data, axes);
		set_place(vehicle, &vehicle->data->xpos[3 * body], body == vehicle->root ? axes : &vehicle->data->xmat[9 * body], &frame->place);
	}
}

static enum status no_body(const struct scene *scene, const struct scene_camera *camera, const struct vehicle *vehicle)
{
	char names[VEHICLE_NAMES];
	vehicle_list_names(vehicle->model, mjOBJ_BODY, vehicle->own.body.first, vehicle->own.body.end, names);
	return fail_with(STATUS_INPUT, "%s: cameras.%s.body: %.64s names no body of the model of %.64s; give one of them, or leave body out for the root "
				       "body; there are: %s", scene->file, camera->name, camera->body, vehicle->scene->name, names);
}

enum status vehicle_check_cameras(const struct vehicles *vehicles)
{
	const struct scene *scene = vehicles->scene;
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		if (camera->body == NULL)
			continue;
		const struct vehicle *vehicle = &vehicles->list[camera->aim.vehicle - 1];
		if (vehicle_find_part(vehicle, mjOBJ_BODY, camera->body) <= 0)
			return no_body(scene, camera, vehicle);
	}
	return STATUS_OK;
}

struct world_figures vehicle_figures(const struct vehicles *vehicles)
{
	if (vehicles == NULL)
		return (struct world_figures){.count = 0};
	return (struct world_figures){vehicles->drawn, vehicles->places, vehicles->looks, vehicles->figure_count, (const char *const *)vehicles->body_names, vehicles->body_count,
				      vehicles->frames, vehicles->frame_count};
}
