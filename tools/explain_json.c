/* furrow explain --json. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "explain.h"
#include "json.h"
#include "soil/kinematic/sheet.h"

static void add_words(cJSON *object, const char *name, const char *const *words)
{
	cJSON *array = cJSON_AddArrayToObject(object, name);
	for (; *words != NULL; words++)
		cJSON_AddItemToArray(array, cJSON_CreateString(*words));
}

/* "base, offset" as a list. */
static void add_planes(cJSON *object, const char *name, const char *planes)
{
	cJSON *array = cJSON_AddArrayToObject(object, name);
	while (*planes != '\0') {
		char plane[32];
		size_t length = strcspn(planes, ",");
		snprintf(plane, sizeof plane, "%.*s", (int)length, planes);
		cJSON_AddItemToArray(array, cJSON_CreateString(plane));
		planes += length + strspn(planes + length, ", ");
	}
}

static void add_text(cJSON *object, const char *name, const char *text)
{
	json_string(object, name, text != NULL && text[0] != '\0' ? text : NULL);
}

static void add_parameters(cJSON *object, const char *const *keys)
{
	cJSON *array = cJSON_AddArrayToObject(object, "parameters");
	for (; *keys != NULL; keys++) {
		struct scene_parameter parameter;
		cJSON *entry = cJSON_CreateObject();
		cJSON_AddItemToArray(array, entry);
		cJSON_AddStringToObject(entry, "key", *keys);
		if (!scene_parameter(*keys, &parameter))
			continue;
		cJSON_AddStringToObject(entry, "kind", parameter.kind);
		add_text(entry, "unit", parameter.unit);
		if (isfinite(parameter.low)) {
			json_pair(entry, "range", parameter.low, parameter.high);
			cJSON_AddBoolToObject(entry, "above", parameter.above);
		}
		add_planes(entry, "words", parameter.words);
		if (isfinite(parameter.absent))
			json_number(entry, "default", parameter.absent);
		else
			add_text(entry, "default", parameter.otherwise);
	}
}

static void add_effects(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	cJSON *array = cJSON_AddArrayToObject(root, "effects");
	for (int e = 0; e < EFFECT_COUNT; e++) {
		const struct effect_row *row = scene_effect_row((enum scene_effect)e);
		bool called = plan->effects >> e & 1;
		char reason[160] = "";
		cJSON *effect = cJSON_CreateObject();
		cJSON_AddItemToArray(array, effect);
		if (called)
			scene_effect_reason(scene, (enum scene_effect)e, reason, sizeof reason);
		cJSON_AddStringToObject(effect, "name", row->name);
		cJSON_AddStringToObject(effect, "key", row->key);
		cJSON_AddBoolToObject(effect, "called", called);
		add_text(effect, "reason", reason);
		cJSON_AddStringToObject(effect, "what", row->what);
		add_planes(effect, "reads", row->reads);
		add_planes(effect, "writes", row->writes);
		json_integer(effect, "stencil", row->stencil);
		add_parameters(effect, row->parameters);
		add_words(effect, "shaders", row->shaders);
		add_text(effect, "define", row->define);
		cJSON_AddStringToObject(effect, "limits", row->limits);
	}
}

static cJSON *line_json(const struct scene *scene, const struct report_plan *plan, const struct plan_line *line)
{
	char reason[160];
	cJSON *object = cJSON_CreateObject();
	cJSON_AddStringToObject(object, line->kind == PLAN_PASS ? "stage" : "name", line->name);
	if (line->kind == PLAN_PASS)
		add_text(object, "object", line->object >= 0 ? plan->bodies[line->object].name : NULL);
	if (line->kind != PLAN_PLANE && line->kind != PLAN_PROGRAM && line->kind != PLAN_THREAD)
		cJSON_AddStringToObject(object, "unit", plan_unit_name(line->unit));
	if (line->kind != PLAN_PLANE && line->kind != PLAN_PROGRAM)
		json_integer(object, "amount", line->amount);
	if (line->kind == PLAN_PLANE || line->kind == PLAN_TEXTURE || line->kind == PLAN_BUFFER)
		json_integer(object, "bytes", (int64_t)line->bytes);
	explain_reason(scene, line->effect, reason, sizeof reason);
	add_text(object, "effect", line->effect);
	cJSON_AddStringToObject(object, "reason", reason);
	return object;
}

static void add_lines(cJSON *root, const char *name, const struct scene *scene, const struct report_plan *plan,
		      enum plan_kind kind)
{
	cJSON *array = cJSON_AddArrayToObject(root, name);
	for (size_t i = 0; i < plan->plan.count; i++)
		if (plan->plan.lines[i].kind == kind)
			cJSON_AddItemToArray(array, line_json(scene, plan, &plan->plan.lines[i]));
}

static void add_memory(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	cJSON *memory = cJSON_AddObjectToObject(root, "memory");
	cJSON *units = cJSON_AddObjectToObject(memory, "per_unit");
	for (int unit = 0; unit < PLAN_UNITS; unit++) {
		uint64_t bytes = 0;
		for (size_t i = 0; i < plan->plan.count; i++) {
			const struct plan_line *line = &plan->plan.lines[i];
			if ((int)line->unit == unit && (line->kind == PLAN_TEXTURE || line->kind == PLAN_BUFFER))
				bytes += line->bytes;
		}
		if (bytes > 0)
			json_integer(units, plan_unit_name((enum plan_unit)unit), (int64_t)bytes);
	}
	report_most(memory, "most", &plan->most);
	report_tile_counts(memory, &plan->tiles);
	report_usable(memory, &plan->usable);
	cJSON_AddBoolToObject(memory, "holds_all", plan->all);
	if (scene->memory > 0)
		json_integer(memory, "asked", (int64_t)scene->memory);
}

static void add_rasters(cJSON *root, const struct report_plan *plan)
{
	cJSON *rasters = cJSON_AddArrayToObject(root, "rasters");
	for (int i = 0; i < plan->raster_count; i++) {
		const struct world_raster *told = &plan->rasters[i];
		cJSON *raster = cJSON_CreateObject();
		cJSON_AddItemToArray(rasters, raster);
		cJSON_AddStringToObject(raster, "number", told->key);
		cJSON_AddStringToObject(raster, "file", told->path);
		add_text(raster, "unit", told->unit);
		json_pair(raster, "range", told->low, told->high);
		json_number(raster, "step", told->step);
		if (plan->soils_known)
			json_number(raster, "share", plan->covered[i]);
	}
}

static void add_rocks(cJSON *root, const struct report_plan *plan)
{
	if (!(plan->rocks.cover > 0))
		return;
	cJSON *rocks = cJSON_AddObjectToObject(root, "rocks");
	json_number(rocks, "cover", rocks_cover(&plan->rocks, 0));
	json_number(rocks, "smallest", plan->rocks.smallest);
	json_number(rocks, "largest", plan->rocks.largest);
	json_number(rocks, "highest", plan->rocks.largest * ROCKS_HEIGHT_MOST);
	json_number(rocks, "a_square_metre", rocks_density(&plan->rocks));
	json_number(rocks, "count", plan->rocks_count);
}

static void add_soils(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	if (deform_model_row(scene->model)->numbers == NULL)
		return;
	cJSON *soils = cJSON_AddArrayToObject(root, "soils");
	for (int soil = 0; soil < scene->soil_count; soil++) {
		const char *key;
		double value;
		cJSON *row = cJSON_CreateObject();
		cJSON_AddItemToArray(soils, row);
		cJSON_AddStringToObject(row, "name", scene->soil_names[soil]);
		if (scene_soil_value(scene, soil) >= 0)
			json_integer(row, "class", scene_soil_value(scene, soil));
		else if (soil > 0)
			cJSON_AddTrueToObject(row, soil == scene->rocks_soil ? "rock" : "road");
		if (plan->soils_known)
			json_number(row, "share", plan->soils[soil]);
		for (size_t i = 0; explain_number(scene, soil, i, &key, &value); i++) {
			if (isnan(value))
				continue;
			cJSON *number = cJSON_AddObjectToObject(row, key);
			json_number(number, "value", value);
			cJSON_AddStringToObject(number, "from", explain_number_from(scene, soil, key));
		}
		if (scene->soils[soil].over == NULL)
			continue;
		json_number(row, "thickness", scene->soils[soil].thickness);
		cJSON *over = cJSON_AddObjectToObject(row, "over");
		cJSON_AddStringToObject(over, "name", scene->base_names[soil]);
		for (size_t i = 0; !soil_is_rigid(scene->soils[soil].over) && scene_soil_number(scene->soils[soil].over, i, &key, &value); i++)
			if (!isnan(value) && deform_model_reads(scene->model, key))
				json_number(over, key, value);
	}
}

static void add_vehicles(cJSON *root, const struct report_plan *plan)
{
	if (plan->vehicles == NULL)
		return;
	cJSON *vehicles = cJSON_AddObjectToObject(root, "vehicles");
	for (size_t i = 0; i < vehicle_count(plan->vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(plan->vehicles, i, &info);
		cJSON *vehicle = cJSON_AddObjectToObject(vehicles, info.name);
		json_number(vehicle, "mass", info.mass);
		json_integer(vehicle, "soil_geoms", (int64_t)info.geom_count);
		json_integer(vehicle, "engine_steps", info.engine_steps);
		json_number(vehicle, "largest_step", info.largest_step);
		cJSON *contacts = cJSON_AddObjectToObject(vehicle, "contacts_per_metre");
		cJSON *shapes = cJSON_AddObjectToObject(vehicle, "shapes");
		cJSON *shares = cJSON_AddObjectToObject(vehicle, "shares");
		for (size_t g = 0; g < info.geom_count; g++) {
			struct vehicle_geom geom;
			char shape[160];
			vehicle_geom(plan->vehicles, i, g, plan->spacing, &geom);
			json_number(contacts, geom.name, geom.contacts);
			json_number(shares, geom.name, geom.share);
			explain_geom(geom.shape, shape, sizeof shape);
			cJSON_AddStringToObject(shapes, geom.name, shape);
		}
		cJSON *actuators = cJSON_AddObjectToObject(vehicle, "actuators");
		for (size_t a = 0; a < info.actuator_count; a++)
			if (vehicle_actuator_name(plan->vehicles, i, a)[0] != '\0')
				add_text(actuators, vehicle_actuator_name(plan->vehicles, i, a), vehicle_actuator_key(plan->vehicles, i, a));
		cJSON *by = cJSON_AddObjectToObject(vehicle, "by");
		cJSON_AddStringToObject(by, "geom", info.largest_geom);
		json_number(by, "mass", info.largest_mass);
		json_number(by, "area", info.largest_area);
	}
}

enum status explain_json(const struct scene *scene, const struct report_plan *plan)
{
	cJSON *root = cJSON_CreateObject();
	cJSON_AddStringToObject(root, "scene", scene->file);
	add_text(root, "store", plan->store);
	add_text(root, "missing", plan->missing);
	cJSON_AddBoolToObject(root, "assumed", plan->store == NULL);
	json_integer(root, "cells", plan->cells);
	json_integer(root, "level", plan->level);
	json_number(root, "spacing", plan->spacing);
	cJSON_AddBoolToObject(root, "deformed", plan->deformed);
	json_integer(root, "steps", plan->steps);
	json_integer(root, "pictures", plan->pictures);
	cJSON_AddBoolToObject(root, "map", scene->map);
	json_string(root, "compute", plan->body_count == 0 ? NULL : plan->bearing ? "cpu" : "gpu");
	if (deform_is_elastic(scene->model) && plan->body_count > 0) {
		struct soil_sheet sheet;
		const double length = sqrt(scene->tension / scene->stiffness);
		soil_sheet_prepare(&sheet, length, scene->yield, scene->rut, plan->spacing);
		cJSON *told = cJSON_AddObjectToObject(root, "sheet");
		json_number(told, "length", length);
		json_integer(told, "rounds", sheet.rounds);
		json_integer(told, "reach", sheet.reach);
	}
	json_integer(root, "window_tiles", (int64_t)plan->window_tiles);
	json_integer(root, "batch_windows", (int64_t)plan->batch_windows);
	json_integer(root, "batch_bytes", (int64_t)plan->batch_bytes);
	cJSON *samples = cJSON_AddObjectToObject(root, "stations");
	for (size_t i = 0; i < scene->object_count; i++)
		json_integer(samples, scene->objects[i].name, (int64_t)plan->samples[i]);
	add_effects(root, scene, plan);
	add_rasters(root, plan);
	add_rocks(root, plan);
	add_soils(root, scene, plan);
	add_vehicles(root, plan);
	explain_laws_json(root, scene, plan);
	report_sun_add(root, &plan->sun);
	explain_cameras_json(root, scene, plan);
	add_lines(root, "planes", scene, plan, PLAN_PLANE);
	add_lines(root, "programs", scene, plan, PLAN_PROGRAM);
	add_lines(root, "passes", scene, plan, PLAN_PASS);
	add_lines(root, "textures", scene, plan, PLAN_TEXTURE);
	add_lines(root, "buffers", scene, plan, PLAN_BUFFER);
	add_lines(root, "threads", scene, plan, PLAN_THREAD);
	add_lines(root, "tables", scene, plan, PLAN_STATEMENT);
	add_memory(root, scene, plan);
	cJSON *notes = cJSON_AddArrayToObject(root, "notes");
	for (size_t i = 0; i < plan->note_count; i++)
		cJSON_AddItemToArray(notes, cJSON_CreateString(plan->notes[i]));
	return json_print(root);
}
