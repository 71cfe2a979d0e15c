/* Names of parts. All vehicles are one model, so each part's name has the number of its vehicle before it, which no user sees. */
#define VEHICLE_NAMES_HERE
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"

/* The prefix has the number of the vehicle in the order by names, not its name. So vehicles may have a slash in their names, and one name may begin
 * as another one does. */
void vehicle_prefix(const struct vehicles *vehicles, size_t index, char prefix[VEHICLE_PREFIX])
{
	size_t place = 0;
	while (vehicles->order[place] != index)
		place++;
	snprintf(prefix, VEHICLE_PREFIX, "%zu/", place);
}

/* In a model that a host lends names are as they are, and its table of names may be of another version. */
static int find_lent(const struct vehicle *vehicle, mjtObj kind, const char *name)
{
	const struct range range = kind == mjOBJ_JOINT ? vehicle->own.joint : kind == mjOBJ_TEXT ? vehicle->own.text : vehicle->own.numeric;
	for (int i = range.first; i < range.end; i++) {
		const char *one = mj_id2name(vehicle->model, kind, i);
		if (one != NULL && strcmp(one, name) == 0)
			return i;
	}
	return -1;
}

int vehicle_find_part(const struct vehicle *vehicle, mjtObj kind, const char *name)
{
	if (vehicle->prefix[0] == '\0')
		return find_lent(vehicle, kind, name);
	char whole[1024];
	const int length = snprintf(whole, sizeof whole, "%s%s", vehicle->prefix, name);
	return length < (int)sizeof whole ? mj_name2id(vehicle->model, kind, whole) : -1;
}

const char *vehicle_part_name(const mjModel *model, mjtObj kind, int part)
{
	const char *whole = mj_id2name(model, kind, part);
	const size_t digits = whole != NULL ? strspn(whole, "0123456789") : 0;
	return digits > 0 && whole[digits] == '/' ? whole + digits + 1 : whole;
}

void vehicle_geom_name(const struct vehicle *vehicle, int geom, char *text, size_t size)
{
	const mjModel *model = vehicle->model;
	const int body = model->geom_bodyid[geom];
	const char *own = vehicle_part_name(model, mjOBJ_GEOM, geom), *of = vehicle_part_name(model, mjOBJ_BODY, body);
	if (own != NULL)
		snprintf(text, size, "%s", own);
	else if (body > 0 && of != NULL && model->body_geomnum[body] == 1)
		snprintf(text, size, "%s", of);
	else if (body > 0)
		snprintf(text, size, "geom_%d", geom - vehicle->own.geom.first + vehicle->own.geom_number);
	else
		snprintf(text, size, "geom_%d", geom - vehicle->own.fixed.first);
}

static void list(const mjModel *model, mjtObj kind, struct range parts, bool prefixed, char text[VEHICLE_NAMES])
{
	size_t length = 0;
	int told = parts.first;
	for (; told < parts.end && length + 80 < VEHICLE_NAMES; told++) {
		const char *one = prefixed ? vehicle_part_name(model, kind, told) : mj_id2name(model, kind, told);
		if (one != NULL)
			length += (size_t)snprintf(text + length, VEHICLE_NAMES - length, "%s%.64s", length > 0 ? ", " : "", one);
	}
	if (length == 0)
		length = (size_t)snprintf(text, VEHICLE_NAMES, "none with a name");
	if (told < parts.end)
		snprintf(text + length, VEHICLE_NAMES - length, ", ...");
}

void vehicle_list_names(const mjModel *model, mjtObj kind, int first, int end, char text[VEHICLE_NAMES])
{
	list(model, kind, (struct range){first, end}, true, text);
}

void vehicle_list_own_names(const mjModel *model, mjtObj kind, char text[VEHICLE_NAMES])
{
	list(model, kind, (struct range){0, kind == mjOBJ_KEY ? (int)model->nkey : 0}, false, text);
}
