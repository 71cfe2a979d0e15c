/* What pictures show of vehicles: the geoms of their models, in groups 0 to 2, as MuJoCo shows them. */
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/settle.h"

#define GROUPS 3 /* geoms of these groups are shown */

static bool is_shown(const mjModel *model, int geom)
{
	const int type = model->geom_type[geom];
	return !vehicle_is_fixed(model, geom) && model->geom_group[geom] < GROUPS && type != mjGEOM_PLANE && type != mjGEOM_HFIELD &&
	       model->geom_rgba[4 * geom + 3] > 0;
}

static const struct soil_geom *soil_geom_of(const struct vehicle *vehicle, int geom)
{
	for (size_t g = 0; g < vehicle->geom_count; g++)
		if (vehicle->geoms[g].geom == geom)
			return &vehicle->geoms[g];
	return NULL;
}

static enum status make_figure(const struct vehicle *vehicle, struct figure *figure, struct scene_object *drawn)
{
	const mjModel *model = vehicle->model;
	const double *size = &model->geom_size[3 * figure->geom];
	const struct soil_geom *soil = soil_geom_of(vehicle, figure->geom);
	static const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
	char name[256];
	vehicle_geom_name(model, figure->geom, name, sizeof name);
	TRY(mem_text(&drawn->name, name, "the parts of a vehicle"));
	memcpy(figure->axes, soil != NULL ? soil->axes : same, sizeof figure->axes);
	if (soil != NULL && soil->shape.kind == SOIL_WHEEL) {
		drawn->shape = soil->shape;
		return STATUS_OK;
	}
	if (model->geom_type[figure->geom] == mjGEOM_SPHERE) {
		drawn->shape = (struct soil_shape){.kind = SOIL_SPHERE, .radius = size[0]};
		return STATUS_OK;
	}
	if (model->geom_type[figure->geom] == mjGEOM_BOX) {
		drawn->shape = (struct soil_shape){.kind = SOIL_BOX, .size = {2 * size[0], 2 * size[1], 2 * size[2]}};
		return STATUS_OK;
	}
	TRY(vehicle_make_mesh(model, figure->geom, &figure->mesh));
	drawn->shape = (struct soil_shape){.kind = SOIL_MESH, .mesh = figure->mesh};
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

enum status vehicle_make_figures(struct vehicles *vehicles)
{
	size_t most = 0;
	for (size_t v = 0; v < vehicles->count; v++)
		most += range_count(vehicles->list[v].own.geom);
	vehicles->drawn = mem_calloc(most + 1, sizeof *vehicles->drawn);
	vehicles->figures = mem_calloc(most + 1, sizeof *vehicles->figures);
	vehicles->places = mem_calloc(most + 1, sizeof *vehicles->places);
	vehicles->frames = mem_calloc(vehicles->count + vehicles->scene->camera_count, sizeof *vehicles->frames);
	TRY_MEM(vehicles->drawn != NULL && vehicles->figures != NULL && vehicles->places != NULL && vehicles->frames != NULL, "the parts of a vehicle");
	list_frames(vehicles);
	for (size_t v = 0; v < vehicles->count; v++)
		for (int i = vehicles->list[v].own.geom.first; i < vehicles->list[v].own.geom.end; i++) {
			if (!is_shown(vehicles->list[v].model, i))
				continue;
			struct figure *figure = &vehicles->figures[vehicles->figure_count];
			*figure = (struct figure){.vehicle = v, .geom = i};
			TRY(make_figure(&vehicles->list[v], figure, &vehicles->drawn[vehicles->figure_count++]));
		}
	return STATUS_OK;
}

void vehicle_free_figures(struct vehicles *vehicles)
{
	for (size_t i = 0; i < vehicles->figure_count; i++) {
		mem_free(vehicles->drawn[i].name);
		vehicle_free_mesh(vehicles->figures[i].mesh);
	}
	mem_free_all(vehicles->drawn, vehicles->figures, vehicles->places, vehicles->frames);
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
		double columns[9];
		mju_mulMatMat(columns, &vehicle->data->geom_xmat[9 * figure->geom], figure->axes, 3, 3, 3);
		set_place(vehicle, &vehicle->data->geom_xpos[3 * figure->geom], columns, &vehicles->places[i]);
	}
	for (size_t i = 0; i < vehicles->frame_count; i++) {
		struct world_frame *frame = &vehicles->frames[i];
		const struct vehicle *vehicle = &vehicles->list[frame->vehicle];
		const int body = frame->body != NULL ? mj_name2id(vehicle->model, mjOBJ_BODY, frame->body) : vehicle->root;
		set_place(vehicle, &vehicle->data->xpos[3 * body], &vehicle->data->xmat[9 * body], &frame->place);
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
		if (mj_name2id(vehicle->model, mjOBJ_BODY, camera->body) <= 0)
			return no_body(scene, camera, vehicle);
	}
	return STATUS_OK;
}

struct world_figures vehicle_figures(const struct vehicles *vehicles)
{
	if (vehicles == NULL)
		return (struct world_figures){.count = 0};
	return (struct world_figures){vehicles->drawn, vehicles->places, vehicles->figure_count, vehicles->frames, vehicles->frame_count};
}
