/* The common model of all colliding geoms. */
#include "vehicle/between.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_NAME "vehicles.xml"

static bool collides(const mjModel *model, int geom)
{
	return !vehicle_is_fixed(model, geom) && (model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0);
}

/* --- the common model --- */

static void write_mesh(FILE *file, const struct vehicle *vehicle, const struct part *part)
{
	const mjModel *model = vehicle->model;
	const int mesh = model->geom_dataid[part->geom];
	const float *from = &model->mesh_vert[3 * model->mesh_vertadr[mesh]];
	fprintf(file, "<mesh name=\"g%d\" vertex=\"", part->here);
	for (int i = 0; i < 3 * model->mesh_vertnum[mesh]; i++)
		fprintf(file, "%.9g ", (double)from[i]);
	fprintf(file, "\"/>");
}

static void write_geom(FILE *file, const struct vehicle *vehicle, const struct part *part)
{
	static const char *const types[mjNGEOMTYPES] = {[mjGEOM_SPHERE] = "sphere", [mjGEOM_CAPSULE] = "capsule", [mjGEOM_ELLIPSOID] = "ellipsoid",
							[mjGEOM_CYLINDER] = "cylinder", [mjGEOM_BOX] = "box"};
	const double *size = &vehicle->model->geom_size[3 * part->geom];
	if (vehicle->model->geom_type[part->geom] == mjGEOM_MESH)
		fprintf(file, "<geom name=\"g%d\" type=\"mesh\" mesh=\"g%d\"/>", part->here, part->here);
	else
		fprintf(file, "<geom name=\"g%d\" type=\"%s\" size=\"%.17g %.17g %.17g\"/>", part->here, types[vehicle->model->geom_type[part->geom]],
			size[0], size[1], size[2]);
}

/* Writes the common model as MJCF. *text is to be freed with free. */
static enum status write_model(const struct vehicles *vehicles, size_t parts, char **text, size_t *size)
{
	const struct between *between = vehicles->between;
	FILE *file = open_memstream(text, size);
	TRY_MEM(file, "the vehicles' model");
	fprintf(file, "<mujoco><compiler angle=\"radian\"/><option><flag multiccd=\"enable\"/></option><asset>");
	for (size_t i = 0; i < parts; i++) {
		const struct vehicle *vehicle = &vehicles->list[between->parts[i].vehicle];
		if (vehicle->model->geom_type[between->parts[i].geom] == mjGEOM_MESH)
			write_mesh(file, vehicle, &between->parts[i]);
	}
	fprintf(file, "</asset><worldbody>");
	for (size_t i = 0; i < parts; i++)
		write_geom(file, &vehicles->list[between->parts[i].vehicle], &between->parts[i]);
	fprintf(file, "</worldbody></mujoco>");
	const bool failed = ferror(file) != 0;
	return fclose(file) != 0 || failed ? fail_memory("the vehicles' model") : STATUS_OK;
}

struct reading {
	struct between *between;
	mjVFS *files;
	const char *text;
	size_t size;
	char error[300];
};

static void read_model(void *argument)
{
	struct reading *reading = argument;
	struct between *between = reading->between;
	mj_defaultVFS(reading->files);
	if (mj_addBufferVFS(reading->files, FILE_NAME, reading->text, (int)reading->size) != 0)
		return;
	between->model = mj_loadXML(FILE_NAME, reading->files, reading->error, sizeof reading->error);
	if (between->model != NULL)
		between->data = mj_makeData(between->model);
	mj_deleteVFS(reading->files);
}

static enum status load_model(const struct vehicles *vehicles, const char *text, size_t size)
{
	struct between *between = vehicles->between;
	struct reading reading = {.between = between, .text = text, .size = size, .error = "out of memory"};
	TRY(mem_make(&reading.files, 1, sizeof *reading.files, "the vehicles' model"));
	enum status status = vehicle_guard("vehicles", read_model, &reading);
	mem_free(reading.files);
	TRY(status);
	if (between->data == NULL)
		return fail_with(STATUS_FAILED, "vehicles: their geoms cannot be put into one model of MuJoCo: %.200s; change their models", reading.error);
	return STATUS_OK;
}

static enum status make_model(const struct vehicles *vehicles, size_t parts)
{
	struct between *between = vehicles->between;
	char *text = NULL, name[32];
	size_t size = 0;
	enum status status;
	TRY_OR(done, write_model(vehicles, parts, &text, &size));
	TRY_OR(done, load_model(vehicles, text, size));
	for (size_t i = 0; i < parts; i++) {
		snprintf(name, sizeof name, "g%d", between->parts[i].here);
		between->parts[i].here = mj_name2id(between->model, mjOBJ_GEOM, name);
	}
done:
	free(text);
	return status;
}

static enum status make_movers(const struct vehicles *vehicles)
{
	struct between *between = vehicles->between;
	for (size_t v = 0; v < vehicles->count; v++) {
		const size_t nv = (size_t)vehicles->list[v].model->nv;
		between->movers[v].inertia = mem_calloc(nv * nv + 1, sizeof(double));
		between->movers[v].velocity = mem_calloc(nv + 1, sizeof(double));
		TRY_MEM(between->movers[v].inertia != NULL && between->movers[v].velocity != NULL, "the vehicles");
	}
	return STATUS_OK;
}

static void sort_by_name(const struct vehicles *vehicles, size_t *order)
{
	for (size_t i = 0; i < vehicles->count; i++) {
		size_t at = i;
		for (; at > 0 && strcmp(vehicles->list[order[at - 1]].scene->name, vehicles->list[i].scene->name) > 0; at--)
			order[at] = order[at - 1];
		order[at] = i;
	}
}

enum status vehicle_between_create(struct vehicles *vehicles)
{
	size_t most = 0, parts = 0;
	if (vehicles->count < 2)
		return STATUS_OK;
	struct between *between = vehicles->between = mem_calloc(1, sizeof *between);
	TRY_MEM(between, "the vehicles");
	for (size_t v = 0; v < vehicles->count; v++)
		most += (size_t)vehicles->list[v].model->ngeom;
	between->parts = mem_calloc(most + 1, sizeof *between->parts);
	between->first = mem_calloc(vehicles->count + 1, sizeof *between->first);
	between->movers = mem_calloc(vehicles->count, sizeof *between->movers);
	between->order = mem_calloc(vehicles->count, sizeof *between->order);
	TRY_MEM(between->order != NULL && between->parts != NULL && between->first != NULL && between->movers != NULL, "the vehicles");
	sort_by_name(vehicles, between->order);
	for (size_t v = 0; v < vehicles->count; v++) {
		for (int geom = 0; geom < vehicles->list[v].model->ngeom; geom++)
			if (collides(vehicles->list[v].model, geom)) {
				between->parts[parts] = (struct part){v, geom, (int)parts};
				parts++;
			}
		between->first[v + 1] = parts;
	}
	TRY(make_movers(vehicles));
	return make_model(vehicles, parts);
}

void vehicle_between_destroy(struct vehicles *vehicles)
{
	struct between *between = vehicles->between;
	if (between == NULL)
		return;
	for (size_t v = 0; v < vehicles->count && between->movers != NULL; v++)
		mem_free_all(between->movers[v].inertia, between->movers[v].velocity);
	if (between->data != NULL)
		mj_deleteData(between->data);
	if (between->model != NULL)
		mj_deleteModel(between->model);
	mem_free_all(between->parts, between->first, between->movers, between->order, between->meetings, between->rows, between);
}
