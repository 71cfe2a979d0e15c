/* What sensors are: their words, units and frames. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/senses.h"

enum axes { NONE, OWN, MAP }; /* MAP: the world's, or those of the sensor's reference */

/* Units with a | are of a hinge, and of a slide. */
static const struct {
	const char *word, *unit;
	enum axes axes;
} kinds[] = {
	[mjSENS_TOUCH] = {"touch", "N", NONE},
	[mjSENS_ACCELEROMETER] = {"accelerometer", "m/s2", OWN},
	[mjSENS_VELOCIMETER] = {"velocimeter", "m/s", OWN},
	[mjSENS_GYRO] = {"gyro", "rad/s", OWN},
	[mjSENS_FORCE] = {"force", "N", OWN},
	[mjSENS_TORQUE] = {"torque", "N m", OWN},
	[mjSENS_MAGNETOMETER] = {"magnetometer", "", OWN},
	[mjSENS_RANGEFINDER] = {"rangefinder", "m", NONE},
	[mjSENS_CAMPROJECTION] = {"camprojection", "pixels", NONE},
	[mjSENS_JOINTPOS] = {"jointpos", "rad|m", NONE},
	[mjSENS_JOINTVEL] = {"jointvel", "rad/s|m/s", NONE},
	[mjSENS_TENDONPOS] = {"tendonpos", "m", NONE},
	[mjSENS_TENDONVEL] = {"tendonvel", "m/s", NONE},
	[mjSENS_ACTUATORPOS] = {"actuatorpos", "", NONE},
	[mjSENS_ACTUATORVEL] = {"actuatorvel", "", NONE},
	[mjSENS_ACTUATORFRC] = {"actuatorfrc", "", NONE},
	[mjSENS_JOINTACTFRC] = {"jointactuatorfrc", "N m|N", NONE},
	[mjSENS_TENDONACTFRC] = {"tendonactuatorfrc", "N", NONE},
	[mjSENS_BALLQUAT] = {"ballquat", "", NONE},
	[mjSENS_BALLANGVEL] = {"ballangvel", "rad/s", NONE},
	[mjSENS_JOINTLIMITPOS] = {"jointlimitpos", "rad|m", NONE},
	[mjSENS_JOINTLIMITVEL] = {"jointlimitvel", "rad/s|m/s", NONE},
	[mjSENS_JOINTLIMITFRC] = {"jointlimitfrc", "N m|N", NONE},
	[mjSENS_TENDONLIMITPOS] = {"tendonlimitpos", "m", NONE},
	[mjSENS_TENDONLIMITVEL] = {"tendonlimitvel", "m/s", NONE},
	[mjSENS_TENDONLIMITFRC] = {"tendonlimitfrc", "N", NONE},
	[mjSENS_FRAMEPOS] = {"framepos", "m", MAP},
	[mjSENS_FRAMEQUAT] = {"framequat", "", MAP},
	[mjSENS_FRAMEXAXIS] = {"framexaxis", "", MAP},
	[mjSENS_FRAMEYAXIS] = {"frameyaxis", "", MAP},
	[mjSENS_FRAMEZAXIS] = {"framezaxis", "", MAP},
	[mjSENS_FRAMELINVEL] = {"framelinvel", "m/s", MAP},
	[mjSENS_FRAMEANGVEL] = {"frameangvel", "rad/s", MAP},
	[mjSENS_FRAMELINACC] = {"framelinacc", "m/s2", MAP},
	[mjSENS_FRAMEANGACC] = {"frameangacc", "rad/s2", MAP},
	[mjSENS_SUBTREECOM] = {"subtreecom", "m", MAP},
	[mjSENS_SUBTREELINVEL] = {"subtreelinvel", "m/s", MAP},
	[mjSENS_SUBTREEANGMOM] = {"subtreeangmom", "kg m2/s", MAP},
	[mjSENS_INSIDESITE] = {"insidesite", "", NONE},
	[mjSENS_GEOMDIST] = {"distance", "m", NONE},
	[mjSENS_GEOMNORMAL] = {"normal", "", MAP},
	[mjSENS_GEOMFROMTO] = {"fromto", "m", MAP},
	[mjSENS_CONTACT] = {"contact", "", NONE},
	[mjSENS_E_POTENTIAL] = {"e_potential", "J", NONE},
	[mjSENS_E_KINETIC] = {"e_kinetic", "J", NONE},
	[mjSENS_CLOCK] = {"clock", "s", NONE},
	[mjSENS_TACTILE] = {"tactile", "", OWN},
	[mjSENS_PLUGIN] = {"plugin", "", NONE},
	[mjSENS_USER] = {"user", "", NONE},
};

static const char *unit_of(const mjModel *model, int sensor)
{
	const char *unit = kinds[model->sensor_type[sensor]].unit, *bar = strchr(unit, '|');
	if (bar == NULL)
		return unit;
	if (model->jnt_type[model->sensor_objid[sensor]] == mjJNT_SLIDE)
		return bar + 1;
	return strncmp(unit, "rad|", 4) == 0 ? "rad" : strncmp(unit, "rad/s|", 6) == 0 ? "rad/s" : "N m";
}

static const char *word_of(int type)
{
	switch (type) {
	case mjOBJ_BODY:
		return "inertia"; /* the axes of its inertia */
	case mjOBJ_XBODY:
		return "body";
	case mjOBJ_JOINT:
		return "joint";
	case mjOBJ_GEOM:
		return "geom";
	case mjOBJ_SITE:
		return "site";
	case mjOBJ_CAMERA:
		return "camera";
	case mjOBJ_TENDON:
		return "tendon";
	case mjOBJ_ACTUATOR:
		return "actuator";
	default:
		return "";
	}
}

static void name_part(const mjModel *model, int type, int part, char text[160])
{
	const mjtObj kind = type == mjOBJ_XBODY ? mjOBJ_BODY : (mjtObj)type;
	const char *name = word_of(type)[0] != '\0' && part >= 0 ? vehicle_part_name(model, kind, part) : NULL;
	snprintf(text, 160, "%.159s", name != NULL ? name : "");
}

/* Gives the body of what a sensor is on, its place and its axes now. Returns false if it has no place. */
static bool place_of(const mjModel *model, const mjData *data, int type, int part, int *body, const double **at, const double **axes)
{
	switch (type) {
	case mjOBJ_BODY:
		*body = part, *at = data->xipos + 3 * part, *axes = data->ximat + 9 * part;
		return true;
	case mjOBJ_XBODY:
		*body = part, *at = data->xpos + 3 * part, *axes = data->xmat + 9 * part;
		return true;
	case mjOBJ_GEOM:
		*body = model->geom_bodyid[part], *at = data->geom_xpos + 3 * part, *axes = data->geom_xmat + 9 * part;
		return true;
	case mjOBJ_SITE:
		*body = model->site_bodyid[part], *at = data->site_xpos + 3 * part, *axes = data->site_xmat + 9 * part;
		return true;
	default:
		return false;
	}
}

/* Finds a place and axes against a frame whose axes are the columns of `of`, at `origin`. */
static void against(const double *at, const double *axes, const double *origin, const double *of, double place[3], double mat[9])
{
	double between[3];
	mju_sub3(between, at, origin);
	mju_mulMatTVec3(place, of, between);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			mat[3 * i + k] = of[i] * axes[k] + of[3 + i] * axes[3 + k] + of[6 + i] * axes[6 + k];
}

static void find_place(const struct vehicle *vehicle, int type, int part, struct vehicle_sensor *out)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	const double *at, *axes;
	double root[9];
	int body;
	if (!place_of(model, data, type, part, &body, &at, &axes))
		return;
	const char *name = vehicle_part_name(model, mjOBJ_BODY, body);
	out->body = name != NULL ? name : "";
	out->is_fixed = model->body_weldid[body] == model->body_weldid[vehicle->root];
	vehicle_root_axes(vehicle, data, root);
	if (out->is_fixed)
		against(at, axes, data->xpos + 3 * vehicle->root, root, out->at, out->axes);
	else
		against(at, axes, data->xpos + 3 * body, data->xmat + 9 * body, out->at, out->axes);
}

size_t vehicle_sensor_count(const struct vehicles *vehicles, size_t index)
{
	return range_count(vehicles->list[index].own.sensor);
}

/* A camera's rays do not know the ground. Neither do plugins and callbacks, of which there are none. */
bool vehicle_senses_unknown(const mjModel *model, int sensor)
{
	const int type = model->sensor_type[sensor];
	return type == mjSENS_PLUGIN || type == mjSENS_USER || type == mjSENS_TACTILE || (type == mjSENS_RANGEFINDER && model->sensor_objtype[sensor] != mjOBJ_SITE);
}

/* Returns true for a site that the scene's imu is: spec_imu.c. */
static bool is_scenes(const struct vehicle *vehicle, int type, int part)
{
	const char *name = vehicle->scene->imu.present && type == mjOBJ_SITE ? vehicle_part_name(vehicle->model, mjOBJ_SITE, part) : NULL;
	return name != NULL && strcmp(name, IMU_SITE) == 0;
}

double vehicle_senses_noise(const struct vehicles *vehicles, const struct vehicle *vehicle, int sensor)
{
	const mjModel *model = vehicle->model;
	if (is_scenes(vehicle, model->sensor_objtype[sensor], model->sensor_objid[sensor])) {
		const int type = model->sensor_type[sensor];
		return type == mjSENS_ACCELEROMETER ? vehicle->scene->imu.noise[0] : type == mjSENS_GYRO ? vehicle->scene->imu.noise[1] : 0;
	}
	return vehicles->scene->noise_seeded ? model->sensor_noise[sensor] : 0;
}

void vehicle_sensor(const struct vehicles *vehicles, size_t index, size_t number, struct vehicle_sensor *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjModel *model = vehicle->model;
	const int sensor = vehicle->own.sensor.first + (int)number, type = model->sensor_type[sensor];
	const char *name = vehicle_part_name(model, mjOBJ_SENSOR, sensor);
	*out = (struct vehicle_sensor){
		.type = kinds[type].word, .unit = unit_of(model, sensor), .size = (size_t)model->sensor_dim[sensor],
		.turns = model->sensor_datatype[sensor] == mjDATATYPE_QUATERNION, .later = model->sensor_needstage[sensor] == mjSTAGE_ACC,
		.known = !vehicle_senses_unknown(model, sensor), .kind = word_of(model->sensor_objtype[sensor]),
		.noise = vehicle_senses_noise(vehicles, vehicle, sensor), .cutoff = model->sensor_cutoff[sensor],
	};
	if (name != NULL && name[0] != '\0')
		snprintf(out->name, sizeof out->name, "%.159s", name);
	else
		snprintf(out->name, sizeof out->name, "%.140s_%zu", out->type, number);
	name_part(model, model->sensor_objtype[sensor], model->sensor_objid[sensor], out->on);
	if (is_scenes(vehicle, model->sensor_objtype[sensor], model->sensor_objid[sensor]) && vehicle_find_part(vehicle, mjOBJ_SITE, "imu") < 0)
		snprintf(out->on, sizeof out->on, "imu"); /* it keeps its own name beside a site of the model's that has this one */
	name_part(model, model->sensor_reftype[sensor], model->sensor_refid[sensor], out->reference);
	if (kinds[type].axes == NONE)
		snprintf(out->reference, sizeof out->reference, "-");
	else if (kinds[type].axes == MAP && out->reference[0] == '\0')
		snprintf(out->reference, sizeof out->reference, "map");
	find_place(vehicle, model->sensor_objtype[sensor], model->sensor_objid[sensor], out);
}
