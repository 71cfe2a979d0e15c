#include "html_run.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "scene/scene_file.h"

#define JSON_BYTES (32u << 20)

bool html_is_file(const char *path)
{
	struct stat found;
	return stat(path, &found) == 0 && S_ISREG(found.st_mode);
}

static enum status read_json(const char *path, cJSON **out)
{
	char *bytes;
	size_t length;
	TRY(scene_file_read(path, path, JSON_BYTES, &bytes, &length));
	*out = cJSON_ParseWithLength(bytes, length);
	mem_free(bytes);
	const cJSON *ended = cJSON_GetObjectItemCaseSensitive(*out, "ended"), *steps = cJSON_GetObjectItemCaseSensitive(*out, "steps");
	if (!cJSON_IsString(ended) || !cJSON_IsNumber(steps))
		return fail_with(STATUS_INPUT, "%s: is no run.json of a drive; give a folder that furrow drive left", path);
	return STATUS_OK;
}

/* The corners of one way. What is no point ends it. */
static enum status take_way(const cJSON *way, struct html_body *body)
{
	const cJSON *point;
	cJSON_ArrayForEach(point, way) {
		const cJSON *x = cJSON_GetArrayItem(point, 0), *y = cJSON_GetArrayItem(point, 1);
		if (!cJSON_IsNumber(x) || !cJSON_IsNumber(y) || !isfinite(x->valuedouble) || !isfinite(y->valuedouble))
			return STATUS_OK;
		TRY(html_body_room(body));
		const size_t at = body->count++;
		body->x[at] = x->valuedouble;
		body->y[at] = y->valuedouble;
		body->way[at] = at > 0 ? body->way[at - 1] + hypot(body->x[at] - body->x[at - 1], body->y[at] - body->y[at - 1]) : 0;
	}
	return STATUS_OK;
}

static enum status read_ways(struct html_run *run, const char *list)
{
	const cJSON *object;
	cJSON_ArrayForEach(object, html_members(run, list)) {
		const cJSON *way = cJSON_GetObjectItemCaseSensitive(object, "way");
		if (!cJSON_IsArray(cJSON_GetArrayItem(way, 0)))
			continue;
		struct html_body *body = html_bodies_add(&run->ways, object->string);
		TRY_MEM(body, "the ways of a drive");
		TRY(take_way(way, body));
	}
	run->ways.there = run->ways.count > 0;
	return STATUS_OK;
}

const struct html_bodies *html_ways(const struct html_run *run)
{
	/* no file of rows has vehicles and objects, but not the vehicles' wheels */
	const bool both = run->vehicles.there && run->ways.there && cJSON_GetArraySize(html_members(run, "objects")) > 0;
	return both ? &run->ways : run->vehicles.there ? &run->vehicles : run->objects.there ? &run->objects : &run->ways;
}

enum status html_run_read(const char *folder, struct html_run *out)
{
	char path[4096];
	*out = (struct html_run){.folder = folder};
	if ((size_t)snprintf(path, sizeof path, "%s/run.json", folder) >= sizeof path)
		return fail_with(STATUS_INPUT, "%.80s...: the name is too long; give a shorter one", folder);
	if (!html_is_file(path))
		return fail_with(STATUS_INPUT, "%s: there is no run.json in it; give a folder that furrow drive left", folder);
	TRY(read_json(path, &out->json));
	TRY(html_rows_objects(out));
	TRY(html_rows_vehicles(out));
	TRY(html_volumes_read(out));
	html_rows_join(out);
	TRY(read_ways(out, "objects"));
	return read_ways(out, "vehicles");
}

void html_run_finish(struct html_run *run)
{
	cJSON_Delete(run->json);
	html_bodies_finish(&run->objects);
	html_bodies_finish(&run->vehicles);
	html_bodies_finish(&run->actuators);
	html_bodies_finish(&run->ways);
	html_volumes_finish(&run->volumes);
	*run = (struct html_run){.folder = NULL};
}

const cJSON *html_at(const struct html_run *run, const char *path)
{
	const cJSON *at = run->json;
	char key[128];
	while (at != NULL && *path != '\0') {
		const size_t length = strcspn(path, ".");
		snprintf(key, sizeof key, "%.*s", (int)length, path);
		at = cJSON_GetObjectItemCaseSensitive(at, key);
		path += length + (path[length] == '.');
	}
	return at;
}

const cJSON *html_members(const struct html_run *run, const char *path)
{
	const cJSON *at = html_at(run, path);
	return cJSON_IsObject(at) ? at : NULL;
}

double html_number(const struct html_run *run, const char *path)
{
	const cJSON *at = html_at(run, path);
	return cJSON_IsNumber(at) && isfinite(at->valuedouble) ? at->valuedouble : (double)NAN;
}

const char *html_string(const struct html_run *run, const char *path)
{
	return cJSON_GetStringValue(html_at(run, path));
}

const char *html_setting(const struct html_run *run, const char *key)
{
	return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(html_members(run, "scene.values"), key));
}
