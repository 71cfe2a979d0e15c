/* The IMU that a scene adds to a model: a site, and the sensors on it. The site has its place once the root body is known: axes.c. */
#define VEHICLE_NAMES_HERE /* a model alone has no prefixes */
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"

static bool add_sensor(struct spec *spec, mjtSensor type, const char *name)
{
	mjsSensor *sensor = mjs_addSensor(spec->spec);
	if (sensor == NULL)
		return false;
	(void)mjs_setName(sensor->element, name);
	sensor->type = type;
	sensor->objtype = mjOBJ_SITE;
	mjs_setString(sensor->objname, IMU_SITE);
	return true;
}

/* A part that has one of these names would get the scene's noise and place, or hide the IMU. */
static enum status check_names(const struct spec *spec)
{
	static const char *const names[] = {IMU_SITE, "imu.accelerometer", "imu.gyro", "imu.orientation"};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		if (mjs_findElement(spec->spec, i == 0 ? mjOBJ_SITE : mjOBJ_SENSOR, names[i]) != NULL)
			return fail_with(STATUS_INPUT, "%s: imu: the model has a %s %s already; call that otherwise, or take imu away and use the model's own", spec->where,
					 i == 0 ? "site" : "sensor", names[i]);
	return STATUS_OK;
}

/* The body that the scene names; without a name the first one, since the root body is not known yet. */
static mjsBody *find_body(const struct spec *spec, const char *name)
{
	if (name != NULL)
		return strcmp(name, "world") != 0 ? mjs_findBody(spec->spec, name) : NULL;
	mjsElement *first = mjs_firstChild(mjs_findBody(spec->spec, "world"), mjOBJ_BODY, 0);
	return first != NULL ? mjs_asBody(first) : NULL;
}

static enum status no_body(const struct spec *spec, const char *name)
{
	char names[VEHICLE_NAMES] = "";
	size_t length = 0;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL && length + 80 < sizeof names; each = mjs_nextElement(spec->spec, each))
		if (strcmp(mjs_getString(mjs_getName(each)), "world") != 0)
			length += (size_t)snprintf(names + length, sizeof names - length, "%s%.64s", length > 0 ? ", " : "", mjs_getString(mjs_getName(each)));
	return fail_with(STATUS_INPUT, "%s: imu.body: %.64s is no body of the model; there are: %s", spec->where, name != NULL ? name : "its root", names);
}

enum status vehicle_spec_imu(struct spec *spec)
{
	const struct scene_imu *imu = &spec->scene->imu;
	if (!imu->present)
		return STATUS_OK;
	TRY(check_names(spec));
	mjsBody *body = find_body(spec, imu->body);
	if (body == NULL)
		return no_body(spec, imu->body);
	mjsSite *site = mjs_addSite(body, NULL);
	if (site == NULL)
		return fail_memory("a vehicle");
	(void)mjs_setName(site->element, IMU_SITE);
	return add_sensor(spec, mjSENS_ACCELEROMETER, "imu.accelerometer") && add_sensor(spec, mjSENS_GYRO, "imu.gyro") && add_sensor(spec, mjSENS_FRAMEQUAT, "imu.orientation")
		       ? STATUS_OK : fail_memory("a vehicle");
}
