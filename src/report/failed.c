/* Notes after a drive on loads that the soil did not carry, or did not hold on a slope. They name the object, the soil, and the first place. */
#include <stdio.h>

#include "base/json.h"
#include "report/report.h"

static const struct body_failed *of(const struct body *body, bool sunk)
{
	return sunk ? &body->sunk : &body->slid;
}

/* Returns the object with the most such steps in this run. NULL: none has any. Then all were before it was resumed, or in other processes. */
static const struct body *worst(const struct world *world, bool sunk)
{
	const struct body *most = NULL;
	for (size_t i = 0; i < world_scene(world)->object_count; i++)
		if (of(world_body(world, i), sunk)->steps > (most != NULL ? of(most, sunk)->steps : 0))
			most = world_body(world, i);
	return most;
}

/* Returns the name of the soil there; NULL: it is not known. */
static const char *soil_at(const struct world *world, const struct body_failed *failed)
{
	const int soil = world_scene(world)->hosted ? -1 : world_soil_index(world, failed->x, failed->y);
	return soil >= 0 ? world_scene(world)->soil_names[soil] : NULL;
}

static void tell(const struct world *world, int64_t times, bool sunk, const char *why, const char *state)
{
	const struct body *body = worst(world, sunk);
	char text[320] = "", rows[160];
	if (body != NULL) {
		const struct body_failed *failed = of(body, sunk);
		const char *soil = soil_at(world, failed);
		snprintf(text, sizeof text, "; most often %.100s (%.6g N), first after %.4g s at %.2f, %.2f m%s%.64s", body->object->name, body->object->load, failed->time,
			 failed->x, failed->y, soil != NULL ? ", on " : "", soil != NULL ? soil : "");
	}
	if (world_params(world)->rows && world_scene(world)->forces > 0)
		snprintf(rows, sizeof rows, "state %s of objects.csv", state);
	else
		snprintf(rows, sizeof rows, "output.forces: 10 in the scene writes objects.csv, whose rows then have the state %s", state);
	note("%lld times %s%s (%s)", (long long)times, why, text, rows);
}

static void add(struct cJSON *forces, const char *key, const struct world *world, bool sunk)
{
	const struct body *body = worst(world, sunk);
	if (body == NULL)
		return;
	const struct body_failed *failed = of(body, sunk);
	const char *soil = soil_at(world, failed);
	cJSON *most = cJSON_AddObjectToObject(forces, key);
	cJSON_AddStringToObject(most, "object", body->object->name);
	json_integer(most, "steps", failed->steps);
	json_number(most, "first_time", failed->time);
	cJSON_AddItemToObject(most, "first_place", cJSON_CreateDoubleArray((const double[2]){failed->x, failed->y}, 2));
	if (soil != NULL)
		cJSON_AddStringToObject(most, "soil", soil);
}

void report_failed(struct cJSON *forces, const struct world *world, int64_t sunk, int64_t slid)
{
	if (sunk > 0)
		tell(world, sunk, true, "the soil did not carry an object's load, which sank as deep as it is high", "sunk");
	if (slid > 0)
		tell(world, slid, false, "a loaded object stood on a slope where the soil cannot hold it: only its path did", "slides");
	add(forces, "sunk_most", world, true);
	add(forces, "slides_most", world, false);
}
