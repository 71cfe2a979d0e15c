/* Sensors of the plugin: what the soil does to a geom. What they read is the instance's key `reads`, in its order. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plugin.h"

#define READS "slip sinkage force"

struct reading {
	const char *name;
	int numbers;
};

static const struct reading readings[] = {{"slip", 1}, {"sinkage", 1}, {"force", 3}, {"moment", 3}, {"slip_velocity", 1}, {"area", 1}, {"normal_force", 1}, {"carried", 1}};
enum { SLIP, SINKAGE, FORCE, MOMENT, SLIP_VELOCITY, AREA, NORMAL_FORCE, CARRIED, READINGS };

static const char *reads_of(const mjModel *model, int instance)
{
	const char *reads = mj_getPluginConfig(model, instance, "reads");
	return reads != NULL && reads[0] != '\0' ? reads : READS;
}

/* Takes the next word of `*text`. Returns its number; READINGS: it is none that is known; -1: there is no more. */
static int next_reading(const char **text)
{
	*text += strspn(*text, " \t\n");
	const size_t length = strcspn(*text, " \t\n");
	if (length == 0)
		return -1;
	int found = READINGS;
	for (int i = 0; i < READINGS; i++)
		if (strlen(readings[i].name) == length && strncmp(readings[i].name, *text, length) == 0)
			found = i;
	*text += length;
	return found;
}

int plugin_sensor_size(const mjModel *model, int instance, int sensor)
{
	int size = 0;
	(void)sensor;
	const char *text = reads_of(model, instance);
	for (int reading; (reading = next_reading(&text)) >= 0;)
		size += reading < READINGS ? readings[reading].numbers : 0;
	return size > 0 ? size : 1;
}

static int soil_geom_of(const struct plugin_soil *soil, int geom)
{
	for (int i = 0; i < soil->count; i++)
		if (soil->geoms[i] == geom)
			return i;
	return -1;
}

const char *plugin_check_sensors(const mjModel *model, int instance, const struct plugin_soil *soil)
{
	const char *text = reads_of(model, instance);
	for (int reading; (reading = next_reading(&text)) >= 0;)
		if (reading == READINGS)
			return "reads has a word that is none of slip, sinkage, force, moment, slip_velocity, area, normal_force, carried";
	for (int i = 0; i < model->nsensor; i++)
		if (model->sensor_type[i] == mjSENS_PLUGIN && model->sensor_plugin[i] == instance &&
		    (model->sensor_objtype[i] != mjOBJ_GEOM || soil_geom_of(soil, model->sensor_objid[i]) < 0))
			return "a sensor reads what is no geom that presses the ground; give it objtype=\"geom\" and an objname that `geoms` names";
	return NULL;
}

void plugin_sense(const mjModel *model, mjData *data, int instance, const struct plugin_soil *soil)
{
	for (int i = 0; i < model->nsensor; i++) {
		if (model->sensor_type[i] != mjSENS_PLUGIN || model->sensor_plugin[i] != instance)
			continue;
		struct furrow_contact contact;
		mjtNum *out = data->sensordata + model->sensor_adr[i];
		plugin_must(furrow_mujoco_geom(soil->soil, (size_t)soil_geom_of(soil, model->sensor_objid[i]), NULL, NULL, &contact, sizeof contact));
		/* In the air and before the first step most numbers are not known; a slip also where nothing turns. */
		const bool known = contact.state != FURROW_UNKNOWN;
		const double one[READINGS] = {[SLIP] = contact.slip, [SINKAGE] = contact.sinkage, [SLIP_VELOCITY] = contact.slip_velocity, [AREA] = contact.area,
					      [NORMAL_FORCE] = contact.normal_force, [CARRIED] = contact.carried};
		const char *text = reads_of(model, instance);
		for (int reading; (reading = next_reading(&text)) >= 0;)
			for (int k = 0; reading < READINGS && k < readings[reading].numbers; k++) {
				const double value = reading == FORCE ? contact.force[k] : reading == MOMENT ? contact.moment[k] : one[reading];
				*out++ = known && isfinite(value) ? value : 0;
			}
	}
}
