/* Scenes with a vehicle, from texts. */
#ifndef TESTS_VEHICLE_RIG_H
#define TESTS_VEHICLE_RIG_H

#include "../support.h"
#include "vehicle/vehicle.h"

/* A carriage with one wheel. %s in turn: what <option> has, what stands beside the body, what the wheel's body has beside its joint. */
static const char rig_wheel[] =
	"<mujoco><option timestep=\"0.002\" %s/><worldbody>%s<body name=\"carriage\" pos=\"0 0 0.5\"><freejoint/>"
	"<inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"5 5 5\"/><body name=\"wheel\"><joint name=\"turn\" axis=\"0 1 0\"/>%s"
	"<geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/></body></body></worldbody>"
	"<actuator><velocity name=\"drive\" joint=\"turn\" kv=\"100\"/></actuator></mujoco>";

static inline void rig_model(const char *option, const char *beside, const char *on_wheel)
{
	char text[4096];
	snprintf(text, sizeof text, rig_wheel, option, beside, on_wheel);
	support_write(support_path("model.xml"), text);
}

/* `keys`: lines of the scene, and `more`: keys of the vehicle, after a comma. */
static inline enum status rig_load(const char *keys, const char *more, struct scene **scene, struct vehicles **vehicles)
{
	char text[4096];
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n%s\nvehicles:\n"
				    "  - {name: car, model: model.xml, start: {at: [5, 5]}%s}\n", keys, more);
	support_write(support_path("scene.yaml"), text);
	*vehicles = NULL;
	enum status status = scene_load(support_path("scene.yaml"), NULL, 0, scene);
	return status == STATUS_OK ? vehicle_load(*scene, vehicles) : status;
}

static inline void rig_refused(const char *keys, const char *more, enum status expected, const char *says)
{
	struct scene *scene = NULL;
	struct vehicles *vehicles;
	enum status status = rig_load(keys, more, &scene, &vehicles);
	if (status != expected || strstr(failure_message(), says) == NULL || strchr(failure_message(), '\n') != NULL)
		fail_msg("%d \"%s\" does not say \"%s\"", status, failure_message(), says);
	assert_null(vehicles);
	if (scene != NULL)
		scene_destroy(scene);
}

#endif
