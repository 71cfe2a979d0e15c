/* The curves of actuators: columns f:ACTUATOR of vehicles.csv, each vehicle's apart. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "html_actuators.h"

#define CURVES_MOST 4096

enum status html_actuators_find(struct html_actuators *actuators, char *const *names, size_t count)
{
	actuators->cells = mem_calloc(count + 1, sizeof *actuators->cells);
	actuators->names = mem_calloc(count + 1, sizeof *actuators->names);
	TRY_MEM(actuators->cells != NULL && actuators->names != NULL, "the rows of a drive");
	for (size_t i = 0; i < count; i++) {
		if (strncmp(names[i], "f:", 2) != 0)
			continue;
		actuators->cells[actuators->count] = i;
		actuators->names[actuators->count] = mem_strdup(names[i] + 2);
		TRY_MEM(actuators->names[actuators->count++], "the rows of a drive");
	}
	return STATUS_OK;
}

void html_actuators_finish(struct html_actuators *actuators)
{
	mem_free_list(actuators->names, actuators->count);
	mem_free(actuators->cells);
}

static struct html_body *curve_of(struct html_bodies *bodies, const char *vehicle, const char *actuator)
{
	char name[400];
	snprintf(name, sizeof name, "%.190s: %.200s", vehicle, actuator);
	for (size_t i = 0; i < bodies->count; i++)
		if (strcmp(bodies->list[i].name, name) == 0)
			return &bodies->list[i];
	return bodies->count < CURVES_MOST ? html_bodies_add(bodies, name) : NULL;
}

static enum status add(struct html_body *curve, const struct html_body *vehicle, double force)
{
	TRY(html_body_room(curve));
	const size_t from = vehicle->count - 1, to = curve->count++;
	curve->time[to] = vehicle->time[from];
	curve->way[to] = vehicle->way[from];
	curve->x[to] = vehicle->x[from];
	curve->y[to] = vehicle->y[from];
	for (int k = 0; k < HTML_VALUES; k++)
		curve->values[k][to] = k == HTML_FORCE ? force : (double)NAN;
	return STATUS_OK;
}

enum status html_actuators_take(const struct html_actuators *actuators, char *const *cells, const struct html_body *vehicle, struct html_bodies *bodies)
{
	for (size_t i = 0; i < actuators->count; i++) {
		const char *cell = cells[actuators->cells[i]];
		char *end;
		const double force = strtod(cell, &end);
		if (end == cell || *end != '\0') /* the vehicle has no such actuator */
			continue;
		struct html_body *curve = curve_of(bodies, vehicle->name, actuators->names[i]);
		TRY_MEM(curve, "the rows of a drive");
		bodies->there = true;
		TRY(add(curve, vehicle, isfinite(force) ? force : (double)NAN));
	}
	return STATUS_OK;
}
