/* objects.csv: the forces of the soil on each body, a row for each multiple of 1 / output.forces. SCENE.md has the columns. With vehicles
 * there are two more, their work on the soil and slip_velocity. Bodies that carry soil have it, too, and what is aboard. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "report/rows_file.h"

#define COLUMNS "t,name,x,y,z,sinkage,fx,fy,fz,tx,ty,tz,slip,contact_area,load,soil,state,residual"
#define CARRIED ",carried,carried_weight"
#define SLIPS ",slip_velocity"
static const char header_of_all[] = COLUMNS ",work" SLIPS CARRIED "\n";

/* The first line of the file: columns that a scene has no use for are left out. */
static const char *header_of(const struct scene *scene)
{
	if (scene->vehicle_count == 0)
		return scene_carries(scene) ? COLUMNS ",work" CARRIED "\n" : COLUMNS "\n";
	return scene_carries(scene) ? header_of_all : COLUMNS ",work" SLIPS "\n";
}

const char *report_objects_columns(void)
{
	return "t, x, y, z, sinkage, fx, fy, fz, tx, ty, tz, slip, contact_area, load, residual; with vehicles work, slip_velocity, too; with carry work, carried, carried_weight";
}

bool report_objects_column(const char *name)
{
	static const char *const texts[] = {"name", "soil", "state"};
	for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
		if (strcmp(name, texts[i]) == 0)
			return false;
	const size_t length = strlen(name);
	for (const char *at = header_of_all; *at != '\0'; at += strcspn(at, ",\n") + 1)
		if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\n'))
			return true;
	return false;
}

struct report_rows {
	const struct world *world;
	const char *directory;
	FILE *file;
};

static enum status failed(const struct report_rows *rows)
{
	return fail_with(STATUS_FAILED, "%s/objects.csv: %s; free some disk space", rows->directory, strerror(errno));
}

static enum status write_row(const struct report_rows *rows, const struct world_row *row)
{
	const struct scene_object *object = row->object;
	const struct world_force *force = &row->force;
	static const char *const states[DEFORM_STATES] = {
		[DEFORM_TOUCHING] = "touching", [DEFORM_SLIDES] = "slides", [DEFORM_SUNK] = "sunk", [DEFORM_AIR] = "air",
	};
	const char *soil = row->soil >= 0 ? world_scene(rows->world)->soil_names[row->soil] : "";
	const struct body *body = world_body(rows->world, row->body);
	const bool tells = scene_carries(world_scene(rows->world)), carries = body->carried != NULL;
	char load[32] = "", work[64] = "", aboard[64] = "";
	const bool slips = world_scene(rows->world)->vehicle_count > 0;
	if (slips || tells)
		strcpy(work, slips ? ",," : ",");
	if (object->load > 0)
		snprintf(load, sizeof load, "%.9g", object->load);
	if (body->kind == BODY_VEHICLE || carries)
		snprintf(work, sizeof work, ",%.9g", force->work);
	if (slips && body->kind == BODY_VEHICLE)
		snprintf(work + strlen(work), sizeof work - strlen(work), ",%.9g", force->slip_velocity);
	else if (slips && carries)
		strcat(work, ",");
	if (carries)
		snprintf(aboard, sizeof aboard, ",%.9g,%.9g", row->aboard.volume, row->aboard.weight);
	else if (tells)
		strcpy(aboard, ",,");
	int printed = fprintf(rows->file, "%.9g,%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%s,%s,%s,%.9g%s%s\n", row->time, object->name,
			      row->position[0], row->position[1], row->position[2], force->sinkage, force->force[0], force->force[1],
			      force->force[2], force->moment[0], force->moment[1], force->moment[2], row->slip, force->area, load, soil,
			      states[force->state], force->residual, work, aboard);
	return printed > 0 ? STATUS_OK : failed(rows);
}

enum status report_rows_write(const struct report_rows *rows, const struct world_row *list, size_t count)
{
	if (rows == NULL)
		return STATUS_OK;
	for (size_t i = 0; i < count; i++)
		TRY(write_row(rows, &list[i]));
	return fflush(rows->file) == 0 ? STATUS_OK : failed(rows);
}

enum status report_rows_mark(const struct report_rows *rows, int64_t *end)
{
	return rows == NULL || report_rows_file_end(rows->file, end) ? STATUS_OK : failed(rows);
}

enum status report_rows_rollback(const struct report_rows *rows, int64_t end)
{
	return rows == NULL || report_rows_file_cut(rows->file, end) ? STATUS_OK : failed(rows);
}

enum status report_rows_open(const struct world *world, const char *directory, struct report_rows **out)
{
	char path[4096];
	*out = NULL;
	snprintf(path, sizeof path, "%s/objects.csv", directory);
	if (world_scene(world)->object_count + world_scene(world)->vehicle_count == 0 || world_scene(world)->forces == 0) {
		unlink(path); /* that another run left */
		return STATUS_OK;
	}
	struct report_rows *rows = mem_calloc(1, sizeof *rows);
	TRY_MEM(rows, "objects.csv");
	*rows = (struct report_rows){.world = world, .directory = directory};
	enum status status;
	TRY_OR(failed, report_rows_file_open(world, path, header_of(world_scene(world)), true, &rows->file, NULL));
	*out = rows;
	return STATUS_OK;
failed:
	report_rows_close(rows);
	return status;
}

void report_rows_close(struct report_rows *rows)
{
	if (rows == NULL)
		return;
	if (rows->file != NULL)
		fclose(rows->file);
	mem_free(rows);
}
