/* Checks the powertrain of a vehicle, and reads the torque of its engine. */
#include "scene/scene_powertrain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"

#define TABLE_BYTES ((size_t)1 << 20)
#define POINTS_MOST 1000
#define KEY "vehicles[%zu].powertrain"
/* Of a clutch that the scene does not tell. */
#define ENGAGE 1.5 /* times the speed of idle: from this engine speed on the clutch is fully engaged */
#define SPARE 1.5  /* times the engine's greatest torque: the most that the clutch holds */

static enum status add_point(struct scene_powertrain *train, const double point[2])
{
	const size_t count = train->engine_count;
	TRY(mem_resize(&train->engine, count + 1, sizeof *train->engine, "reading the vehicles"));
	memcpy(train->engine[count], point, sizeof train->engine[count]);
	train->engine_count = count + 1;
	return STATUS_OK;
}

/* Reads "rpm,torque" rows. The first line may name the columns. */
static enum status read_rows(const struct scene_tree *tree, const struct scene_node *node, char *text, struct scene_powertrain *train)
{
	int line = 0;
	for (char *row, *rest = text; (row = strsep(&rest, "\n")) != NULL;) {
		double point[2];
		char *end, *last;
		line++;
		row[strcspn(row, "\r")] = '\0';
		if (row[0] == '\0' || row[0] == '#')
			continue;
		point[0] = strtod(row, &end);
		if (end == row && train->engine_count == 0 && line == 1)
			continue;
		point[1] = *end == ',' ? strtod(end + 1, &last) : 0;
		if (end == row || *end != ',' || last == end + 1 || *last != '\0' || !(fabs(point[0]) <= 1e6) || !(fabs(point[1]) <= 1e6))
			return scene_error(tree->file, node, "line %d, %s, is no row of the engine; allowed: rpm,torque: two numbers with a comma between them", line, scene_quote(row).text);
		if (train->engine_count == POINTS_MOST)
			return scene_error(tree->file, node, "has more than %d rows; allowed: at most that many", POINTS_MOST);
		TRY(add_point(train, point));
	}
	return STATUS_OK;
}

static enum status read_table(const struct scene_tree *tree, const struct scene_node *node, const char *name, struct scene_powertrain *train)
{
	char *path = scene_file_beside(tree->folder, name), *text = NULL;
	size_t length;
	TRY_MEM(path, "reading the vehicles");
	enum status status = scene_file_read(path, scene_told(tree->file, node, name).text, TABLE_BYTES, &text, &length);
	if (status == STATUS_OK)
		status = read_rows(tree, node, text, train);
	mem_free_all(text, path);
	return status;
}

static enum status take_engine(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, struct scene_powertrain *train)
{
	const struct scene_node *node = scene_tree_find(tree, KEY ".%s", index, raw->engine != NULL ? "engine" : "torque");
	if ((raw->engine != NULL) == (raw->torque != NULL))
		return scene_error(tree->file, scene_tree_find(tree, KEY, index), "names %s; allowed: exactly one of engine, torque",
				   raw->engine != NULL ? "its engine twice" : "no engine");
	if (raw->engine != NULL)
		TRY(read_table(tree, node, raw->engine, train));
	for (uint32_t i = 0; i < raw->torque_count; i++)
		TRY(add_point(train, raw->torque[i]));
	double most = 0;
	for (size_t i = 0; i < train->engine_count; i++) {
		const double *point = train->engine[i];
		if (!(point[0] >= 0) || !(point[1] >= 0) || (i > 0 && !(point[0] > train->engine[i - 1][0])))
			return scene_error(tree->file, node, "its row %zu, %g rpm with %g N m, does not go on from the one before; allowed: speeds that grow, torques from 0",
					   i + 1, point[0], point[1]);
		most = fmax(most, point[1]);
	}
	return train->engine_count >= 2 && most > 0 ? STATUS_OK : scene_error(tree->file, node, "is no engine; needed: at least two speeds, and a torque above 0");
}

static enum status take_gears(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, struct scene_powertrain *train)
{
	train->gears[0] = 1;
	train->gear_count = raw->gears != NULL ? raw->gears_count : 1;
	for (uint32_t i = 0; i < raw->gears_count; i++)
		train->gears[i] = raw->gears[i];
	train->reverse = scene_or(raw->reverse, train->gears[0]);
	train->final = scene_number(raw->final, "vehicles[].powertrain.final");
	train->shift_time = scene_number(raw->shift_time, "vehicles[].powertrain.shift_time");
	train->shifts = raw->shift != NULL;
	if (!train->shifts)
		return STATUS_OK;
	const struct scene_node *node = scene_tree_find(tree, KEY ".shift", index);
	train->down = raw->shift[0];
	train->up = raw->shift[1];
	for (size_t i = 0; i + 1 < train->gear_count; i++) {
		const double after = train->up * train->gears[i + 1] / train->gears[i];
		if (!(train->gears[i + 1] < train->gears[i]))
			return scene_error(tree->file, node, "needs ratios that fall from gear to gear, and gear %zu has %g after %g; allowed: falling ratios", i + 2, train->gears[i + 1],
					   train->gears[i]);
		if (!(after > train->down))
			return scene_error(tree->file, node, "shifts up from gear %zu at %g rpm, has %.4g rpm then, and shifts down again below %g; allowed: down below %.4g", i + 1,
					   train->up, after, train->down, after);
	}
	return STATUS_OK;
}

static enum status take_clutch(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, struct scene_powertrain *train)
{
	double most = 0;
	for (size_t i = 0; i < train->engine_count; i++)
		most = fmax(most, train->engine[i][1]);
	if (raw->clutch != NULL && raw->converter != NULL)
		return scene_error(tree->file, scene_tree_find(tree, KEY ".converter", index), "is given, and a clutch is, too; allowed: one of clutch, converter");
	if (raw->converter != NULL) {
		train->capacity = raw->converter->capacity;
		train->stall_ratio = scene_number(raw->converter->ratio, "vehicles[].powertrain.converter.ratio");
		train->coupling = scene_number(raw->converter->coupling, "vehicles[].powertrain.converter.coupling");
		return STATUS_OK;
	}
	train->clutch = scene_or(raw->clutch != NULL ? raw->clutch->torque : NULL, SPARE * most);
	train->engage = scene_or(raw->clutch != NULL ? raw->clutch->engage : NULL, ENGAGE * train->idle);
	if (!(train->engage > train->idle))
		return scene_error(tree->file, scene_tree_find(tree, KEY ".clutch", index), "engages at %g rpm, and the engine idles at %g; allowed: above idle", train->engage, train->idle);
	return STATUS_OK;
}

static enum status take_differentials(const struct scene_tree *tree, const struct raw_differentials *raw, size_t index, struct scene_powertrain *train)
{
	train->bias = scene_absent("vehicles[].powertrain.differentials.bias");
	if (raw == NULL)
		return STATUS_OK;
	train->centre = raw->centre != NULL ? (enum scene_differential)*raw->centre : SCENE_OPEN;
	train->front = raw->front != NULL ? (enum scene_differential)*raw->front : SCENE_OPEN;
	train->rear = raw->rear != NULL ? (enum scene_differential)*raw->rear : SCENE_OPEN;
	train->bias = scene_or(raw->bias, train->bias);
	train->lock = scene_number(raw->lock, "vehicles[].powertrain.differentials.lock");
	const bool limited = train->centre == SCENE_LIMITED || train->front == SCENE_LIMITED || train->rear == SCENE_LIMITED;
	if (!limited && (raw->bias != NULL || raw->lock != NULL))
		return scene_error(tree->file, scene_tree_find(tree, KEY ".differentials.%s", index, raw->bias != NULL ? "bias" : "lock"),
				   "is of limited differentials, and there is none; allowed with: limited");
	return STATUS_OK;
}

static enum status take_wheels(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, const struct scene_vehicle *vehicle,
			       struct scene_powertrain *train)
{
	if (raw->wheels == NULL && vehicle->drive.count == 0)
		return scene_error(tree->file, scene_tree_find(tree, KEY, index), "names no wheels that it drives; needed: wheels, or driver.drive");
	return scene_take_texts(raw->wheels, raw->wheels_count, &train->wheels);
}

enum status scene_check_powertrain(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, struct scene_vehicle *vehicle)
{
	struct scene_powertrain *train = &vehicle->powertrain;
	train->present = true;
	TRY(take_engine(tree, raw, index, train));
	train->inertia = scene_number(raw->inertia, "vehicles[].powertrain.inertia");
	train->idle = scene_or(raw->idle, train->engine[0][0]);
	train->drag = scene_number(raw->drag, "vehicles[].powertrain.drag");
	if (!(train->idle > 0 && train->idle < train->engine[train->engine_count - 1][0]))
		return scene_error(tree->file, scene_tree_find(tree, KEY ".%s", index, raw->idle != NULL ? "idle" : raw->engine != NULL ? "engine" : "torque"),
				   "makes an idle speed of %g rpm, and the engine's last is %g; allowed: idle above 0 and below the engine's last speed", train->idle,
				   train->engine[train->engine_count - 1][0]);
	TRY(take_gears(tree, raw, index, train));
	TRY(take_clutch(tree, raw, index, train));
	TRY(take_differentials(tree, raw->differentials, index, train));
	return take_wheels(tree, raw, index, vehicle, train);
}
