/* sensors.json: what each sensor of a drive is, where it is, and which columns or files it has. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/json.h"
#include "report/poses.h"
#include "report/sensors.h"

void report_sensor_column(const struct vehicle_sensor *sensor, size_t k, char text[400])
{
	static const char *const axes[] = {"x", "y", "z"}, *const turns[] = {"w", "x", "y", "z"};
	if (sensor->size == 1)
		snprintf(text, 400, "%s", sensor->name);
	else if (sensor->turns && sensor->size == 4)
		snprintf(text, 400, "%s.%s", sensor->name, turns[k]);
	else if (sensor->size == 3)
		snprintf(text, 400, "%s.%s", sensor->name, axes[k]);
	else
		snprintf(text, 400, "%s.%zu", sensor->name, k);
}

static const char *label_of(const struct vehicle_sensor *sensor)
{
	return sensor->on[0] != '\0' ? sensor->on : sensor->name;
}

/* Two sensors on one thing have one frame. Things without a name have none in common. */
static bool is_same_thing(const struct vehicle_sensor *a, const struct vehicle_sensor *b)
{
	return strcmp(a->kind, b->kind) == 0 && (a->on[0] != '\0') == (b->on[0] != '\0');
}

/* Names of sites, geoms and bodies may be the same. Writes the name of a sensor's frame, with its kind where another frame has that name. A body keeps its own. */
static void name_frame(const char *vehicle, const struct vehicle_sensor *all, size_t count, const struct vehicle_sensor *sensor, char text[600])
{
	const char *label = label_of(sensor);
	const bool is_body = strcmp(sensor->kind, "body") == 0;
	bool taken = strcmp(label, "base_link") == 0;
	for (size_t i = 0; i < count && !taken && !is_body; i++)
		taken = all[i].body != NULL && ((strcmp(label_of(&all[i]), label) == 0 && !is_same_thing(&all[i], sensor)) || (!all[i].is_fixed && strcmp(all[i].body, label) == 0));
	snprintf(text, 600, "%s/%s%s%s", vehicle, label, taken ? "." : "", !taken ? "" : sensor->on[0] != '\0' ? sensor->kind : "sensor");
}

static void add_frame(cJSON *to, const char *vehicle, const struct vehicle_sensor *all, size_t count, const struct vehicle_sensor *sensor)
{
	char text[600];
	double q[4], columns[3][3];
	if (sensor->body == NULL) {
		cJSON_AddNullToObject(to, "frame");
		return;
	}
	cJSON *frame = cJSON_AddObjectToObject(to, "frame");
	name_frame(vehicle, all, count, sensor, text);
	cJSON_AddStringToObject(frame, "name", text);
	cJSON_AddStringToObject(frame, "body", sensor->body);
	snprintf(text, sizeof text, "%s/%s%s", vehicle, sensor->is_fixed ? "base_link" : sensor->body, !sensor->is_fixed && strcmp(sensor->body, "base_link") == 0 ? ".body" : "");
	cJSON_AddStringToObject(frame, "parent", text);
	json_numbers(frame, "position", sensor->at, 3);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			columns[i][k] = sensor->axes[3 * k + i];
	report_quaternion(columns, q);
	json_numbers(frame, "orientation", q, 4);
}

static void add_sensor(cJSON *list, const char *vehicle, const struct vehicle_sensor *all, size_t count, const struct vehicle_sensor *sensor)
{
	cJSON *one = cJSON_CreateObject();
	cJSON_AddItemToArray(list, one);
	cJSON_AddStringToObject(one, "vehicle", vehicle);
	cJSON_AddStringToObject(one, "name", sensor->name);
	cJSON_AddStringToObject(one, "type", sensor->type);
	cJSON *columns = cJSON_AddArrayToObject(one, "columns");
	for (size_t k = 0; k < sensor->size; k++) {
		char text[400];
		report_sensor_column(sensor, k, text);
		cJSON_AddItemToArray(columns, cJSON_CreateString(text));
	}
	cJSON_AddStringToObject(one, "unit", sensor->unit);
	cJSON_AddStringToObject(one, "kind", sensor->kind);
	cJSON_AddStringToObject(one, "on", sensor->on);
	if (strcmp(sensor->reference, "-") == 0)
		cJSON_AddNullToObject(one, "axes");
	else
		cJSON_AddStringToObject(one, "axes", sensor->reference[0] != '\0' ? sensor->reference : "own");
	cJSON_AddBoolToObject(one, "known", sensor->known);
	cJSON_AddBoolToObject(one, "mean_of_last_step", sensor->later);
	json_number(one, "noise", sensor->noise);
	json_number(one, "cutoff", sensor->cutoff);
	add_frame(one, vehicle, all, count, sensor);
}

static enum status add_of_vehicle(cJSON *list, const struct vehicles *vehicles, size_t v)
{
	const size_t count = vehicle_sensor_count(vehicles, v);
	struct vehicle_sensor *all;
	struct vehicle_info info;
	TRY(mem_zeroed(&all, count + 1, sizeof *all, "sensors.json"));
	vehicle_info(vehicles, v, &info);
	for (size_t i = 0; i < count; i++)
		vehicle_sensor(vehicles, v, i, &all[i]);
	for (size_t i = 0; i < count; i++)
		add_sensor(list, info.name, all, count, &all[i]);
	mem_free(all);
	return STATUS_OK;
}

static enum status add_sensors(cJSON *root, const struct vehicles *vehicles, const struct scene *scene)
{
	json_number(root, "rate", scene->sensor_rows);
	if (scene->noise_seeded)
		json_integer(root, "noise_seed", scene->noise_seed);
	cJSON *list = cJSON_AddArrayToObject(root, "sensors");
	for (size_t v = 0; v < vehicle_count(vehicles) && scene->sensor_rows > 0; v++)
		TRY(add_of_vehicle(list, vehicles, v));
	return STATUS_OK;
}

/* Cameras and lidars have files of their own, which tell more. */
static void add_folders(cJSON *root, const struct scene *scene)
{
	char text[200];
	cJSON *list = cJSON_AddArrayToObject(root, "lidars");
	for (size_t i = 0; i < scene->lidar_count; i++) {
		cJSON *one = cJSON_CreateObject();
		cJSON_AddItemToArray(list, one);
		report_lidar_add(one, scene, &scene->lidars[i]);
		snprintf(text, sizeof text, REPORT_LIDARS "/%s", scene->lidars[i].name);
		cJSON_AddStringToObject(one, "folder", text);
	}
	list = cJSON_AddArrayToObject(root, "cameras");
	for (size_t i = 0; i < scene->camera_count; i++) {
		cJSON *one = cJSON_CreateObject();
		cJSON_AddItemToArray(list, one);
		cJSON_AddStringToObject(one, "name", scene->cameras[i].name);
		snprintf(text, sizeof text, RENDER_CAMERAS "/%s", scene->cameras[i].name);
		cJSON_AddStringToObject(one, "folder", text);
	}
}

enum status report_sensors_json(const struct world *world, const struct vehicles *vehicles, const char *directory)
{
	const struct scene *scene = world_scene(world);
	char path[4096];
	struct aside aside;
	snprintf(path, sizeof path, "%s/sensors.json", directory);
	if (!(scene->sensor_rows > 0) && scene->lidar_count == 0) {
		unlink(path); /* that another run left */
		return STATUS_OK;
	}
	cJSON *root = cJSON_CreateObject();
	TRY_MEM(root, "sensors.json");
	enum status status = add_sensors(root, vehicles, scene);
	add_folders(root, scene);
	char *text = status == STATUS_OK ? json_text(root) : NULL;
	cJSON_Delete(root);
	TRY(status);
	TRY_MEM(text, "sensors.json");
	status = aside_begin(&aside, path);
	if (status == STATUS_OK) {
		fprintf(aside.file, "%s\n", text); /* a failure returns when the file is completed */
		status = aside_end(&aside, false, STATUS_OK);
	}
	cJSON_free(text);
	return status;
}
