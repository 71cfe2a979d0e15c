/*
 * What sensors of vehicles measure: those of their models, and of the scene's `imu`.
 *
 * MuJoCo computes sensors at the start of its step, and knows neither the terrain nor the soil's forces as contacts. So rows are computed here, at
 * the end of a time step:
 *
 *  1. Places and velocities are those of the row's time.
 *  2. Accelerations are those that the velocities had in the last step of the engine: their change, divided by its length.
 *  3. Forces between bodies count the soil's as forces from outside on its geoms. Touch sensors count the soil's force through their site.
 *  4. Rangefinders see the ground, besides bodies.
 *
 * All of it is computed beside the state, which stays as it is to the bit.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/noise.h"
#include "vehicle/senses.h"

struct senses {
	bool felt;              /* there was a step of the engine */
	double *change;         /* nv: accelerations in the last one */
	double *kept;           /* room for what MuJoCo's functions change: nv accelerations, 6 nbody forces, nq places */
	double *values;         /* nsensordata: what was found */
	struct resident_ray *rays; /* of rangefinders: one for each sensor */
	struct resident_hit *hits;
	double *reach;          /* m: to the first body along each */
	double (*normals)[3];   /* of bodies there */
	int *ranging;           /* sensors that they are of */
	size_t ray_count;
};

void vehicle_feel(const struct vehicles *vehicles, double h, const double *before)
{
	struct senses *senses = vehicles->senses;
	if (senses == NULL)
		return;
	for (int i = 0; i < (int)vehicles->model->nv; i++)
		senses->change[i] = (vehicles->data->qvel[i] - before[i]) / h;
	senses->felt = true;
}

/* --- what MuJoCo does not know --- */

/* Adds the soil's force on a geom, and the weight of soil aboard, to the forces from outside on its body. */
static void add_soil(const struct vehicles *vehicles, const struct soil_geom *geom)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	const int body = model->geom_bodyid[geom->geom];
	double force[6], arm[3], moment[3], *outside = data->xfrc_applied + 6 * body;
	if (geom->aloft)
		return;
	mju_copy(force, geom->force, 6);
	if (geom->load > 0) {
		force[2] -= geom->load;
		force[3] -= geom->load_at[1] * geom->load;
		force[4] += geom->load_at[0] * geom->load;
	}
	mju_sub3(arm, data->geom_xpos + 3 * geom->geom, data->xipos + 3 * body);
	mju_cross(moment, arm, force);
	mju_addTo3(moment, force + 3);
	mju_addTo3(outside, force);
	mju_addTo3(outside + 3, moment);
}

/* Returns the soil's force through the site of a touch sensor, N, along the normal of the ground. It counts where that line meets the site, as with contacts of MuJoCo. */
static double touch_of_soil(const struct vehicles *vehicles, int site)
{
	const mjModel *model = vehicles->model;
	const mjData *data = vehicles->data;
	double sum = 0;
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			const struct soil_geom *geom = &vehicles->list[v].geoms[g];
			if (geom->aloft || model->geom_bodyid[geom->geom] != model->site_bodyid[site] || geom->contact.state == FURROW_AIR ||
			    geom->contact.state == FURROW_UNKNOWN)
				continue;
			const double force = mju_dot3(geom->force, geom->contact.normal);
			double point[3], down[3];
			mju_sub3(point, geom->contact.point, vehicles->origin);
			mju_scl3(down, geom->contact.normal, -1);
			if (force > 0 && mju_rayGeom(data->site_xpos + 3 * site, data->site_xmat + 9 * site, model->site_size + 3 * site, point, down, model->site_type[site], NULL) >= 0)
				sum += force;
		}
	return sum;
}

static void prepare_ray(const struct vehicles *vehicles, struct senses *senses, int sensor)
{
	const mjModel *model = vehicles->model;
	const mjData *data = vehicles->data;
	const int site = model->sensor_objid[sensor];
	const double *mat = data->site_xmat + 9 * site, way[3] = {mat[2], mat[5], mat[8]};
	struct resident_ray *ray = &senses->rays[senses->ray_count];
	*ray = (struct resident_ray){.length = INFINITY};
	mju_add3(ray->origin, vehicles->origin, data->site_xpos + 3 * site);
	mju_copy3(ray->direction, way);
	senses->reach[senses->ray_count] = vehicle_ray(vehicles, data->site_xpos + 3 * site, way, model->site_bodyid[site], senses->normals[senses->ray_count]);
	senses->ranging[senses->ray_count++] = sensor;
}

/* Writes what a rangefinder tells of the nearer one of ground and bodies. -1: of neither, as MuJoCo has it. */
static void tell_range(const struct vehicles *vehicles, struct senses *senses, size_t number)
{
	const mjModel *model = vehicles->model;
	const int sensor = senses->ranging[number], fields = model->sensor_intprm[sensor * mjNSENS];
	const struct resident_ray *ray = &senses->rays[number];
	const struct resident_hit *hit = &senses->hits[number];
	const double cutoff = model->sensor_cutoff[sensor], body = senses->reach[number], ground = hit->hit ? hit->distance : INFINITY, distance = fmin(body, ground);
	const double *normal = ground < body ? hit->normal : senses->normals[number];
	double *to = senses->values + model->sensor_adr[sensor];
	const bool any = isfinite(distance);
	for (int field = 0; field < mjNRAYDATA; field++) {
		if (!(fields >> field & 1))
			continue;
		if (field == mjRAYDATA_DIST || field == mjRAYDATA_DEPTH) {
			*to++ = !any ? -1 : cutoff > 0 ? fmin(distance, cutoff) : distance;
			continue;
		}
		for (int i = 0; i < 3; i++)
			to[i] = field == mjRAYDATA_DIR ? (any ? ray->direction[i] : 0) : field == mjRAYDATA_ORIGIN ? ray->origin[i] : !any ? 0 : field == mjRAYDATA_POINT ? ray->origin[i] + distance * ray->direction[i] : normal[i];
		to += 3;
	}
}

/* MuJoCo's origin is not the store's. */
static void shift(const struct vehicles *vehicles, double *place)
{
	mju_addTo3(place, vehicles->origin);
}

static void shift_contacts(const struct vehicles *vehicles, int sensor, double *to)
{
	static const int sizes[mjNCONDATA] = {[mjCONDATA_FOUND] = 1, [mjCONDATA_FORCE] = 3, [mjCONDATA_TORQUE] = 3, [mjCONDATA_DIST] = 1, [mjCONDATA_POS] = 3,
					      [mjCONDATA_NORMAL] = 3, [mjCONDATA_TANGENT] = 3, [mjCONDATA_LINVEL] = 3, [mjCONDATA_ANGVEL] = 3};
	const int fields = vehicles->model->sensor_intprm[sensor * mjNSENS], all = vehicles->model->sensor_dim[sensor];
	int size = 0, at = -1;
	for (int field = 0; field < mjNCONDATA; field++) {
		if (!(fields >> field & 1))
			continue;
		at = field == mjCONDATA_POS ? size : at;
		size += sizes[field];
	}
	for (int i = 0; at >= 0 && i + size <= all; i += size)
		shift(vehicles, to + i + at);
}

static void mend(const struct vehicles *vehicles, struct senses *senses, int sensor)
{
	const mjModel *model = vehicles->model;
	double *to = senses->values + model->sensor_adr[sensor];
	const int type = model->sensor_type[sensor], size = model->sensor_dim[sensor];
	if (vehicle_senses_unknown(model, sensor) || (model->sensor_needstage[sensor] == mjSTAGE_ACC && !senses->felt)) {
		for (int i = 0; i < size; i++)
			to[i] = (double)NAN;
		return;
	}
	if (type == mjSENS_TOUCH) {
		*to += touch_of_soil(vehicles, model->sensor_objid[sensor]);
		*to = model->sensor_cutoff[sensor] > 0 ? fmin(*to, model->sensor_cutoff[sensor]) : *to;
	} else if (type == mjSENS_RANGEFINDER) {
		prepare_ray(vehicles, senses, sensor);
	} else if ((type == mjSENS_FRAMEPOS && model->sensor_refid[sensor] < 0) || type == mjSENS_SUBTREECOM) {
		shift(vehicles, to);
	} else if (type == mjSENS_GEOMFROMTO) {
		shift(vehicles, to);
		shift(vehicles, to + 3);
	} else if (type == mjSENS_CONTACT) {
		shift_contacts(vehicles, sensor, to);
	} else if (type == mjSENS_CLOCK) {
		*to = world_time(vehicles->world);
	}
}

/* --- measuring --- */

static void compute(const struct vehicles *vehicles)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	struct senses *senses = vehicles->senses;
	double *places = senses->kept + model->nv + 6 * model->nbody;
	mju_copy(places, data->qpos, (int)model->nq);
	mju_copy(senses->kept, data->qacc, (int)model->nv);
	mju_copy(senses->kept + model->nv, data->xfrc_applied, 6 * (int)model->nbody);
	data->flg_energypos = data->flg_energyvel = data->flg_subtreevel = data->flg_rnepost = 0;
	mj_camlight(model, data);
	mj_tendon(model, data);
	mj_transmission(model, data);
	mj_sensorPos(model, data);
	mj_fwdVelocity(model, data);
	mj_sensorVel(model, data);
	mju_copy(data->qacc, senses->change, (int)model->nv);
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			add_soil(vehicles, &vehicles->list[v].geoms[g]);
	data->flg_rnepost = 0;
	mj_rnePostConstraint(model, data);
	mj_sensorAcc(model, data);
	mju_copy(data->qpos, places, (int)model->nq);
	mju_copy(data->qacc, senses->kept, (int)model->nv);
	mju_copy(data->xfrc_applied, senses->kept + model->nv, 6 * (int)model->nbody);
}

static void measure(void *argument)
{
	const struct vehicles *vehicles = argument;
	struct senses *senses = vehicles->senses;
	compute(vehicles);
	mju_copy(senses->values, vehicles->data->sensordata, (int)vehicles->model->nsensordata);
	senses->ray_count = 0;
	for (int i = 0; i < (int)vehicles->model->nsensor; i++)
		mend(vehicles, senses, i);
}

/* --- noise --- */

/* Only distances have it, of what was met. They stay what a rangefinder can tell: from 0 to its cutoff. */
static void add_noise_of_range(const mjModel *model, int sensor, double deviation, uint64_t stream, uint64_t first, double *to)
{
	const int fields = model->sensor_intprm[sensor * mjNSENS];
	const double cutoff = model->sensor_cutoff[sensor] > 0 ? model->sensor_cutoff[sensor] : INFINITY;
	for (int field = 0, at = 0; field < mjNRAYDATA; field++) {
		if (!(fields >> field & 1))
			continue;
		const bool distance = field == mjRAYDATA_DIST || field == mjRAYDATA_DEPTH;
		if (distance && to[at] >= 0)
			to[at] = fmin(fmax(to[at] + deviation * noise_normal(stream, first + (uint64_t)at), 0), cutoff);
		at += distance ? 1 : 3;
	}
}

static void add_noise(const struct vehicles *vehicles, const struct vehicle *vehicle, int sensor)
{
	const mjModel *model = vehicles->model;
	const double deviation = vehicle_senses_noise(vehicles, vehicle, sensor);
	double *to = vehicles->senses->values + model->sensor_adr[sensor];
	const char *name = vehicle_part_name(model, mjOBJ_SENSOR, sensor);
	if (deviation <= 0)
		return;
	uint64_t stream = noise_stream(vehicles->scene->noise_seed, vehicle->scene->name);
	stream = noise_stream(stream, name != NULL ? name : "");
	stream += (uint64_t)(sensor - vehicle->own.sensor.first) << 48;
	const uint64_t row = (uint64_t)llround(world_time(vehicles->world) / vehicles->scene->time_step);
	if (model->sensor_type[sensor] == mjSENS_RANGEFINDER) {
		add_noise_of_range(model, sensor, deviation, stream, row * 4096, to);
		return;
	}
	for (int i = 0; i < model->sensor_dim[sensor]; i++)
		to[i] += deviation * noise_normal(stream, row * 4096 + (uint64_t)i);
	if (model->sensor_datatype[sensor] == mjDATATYPE_QUATERNION)
		mju_normalize4(to);
}

enum status vehicle_sense(struct vehicles *vehicles)
{
	struct senses *senses = vehicles->senses;
	TRY(vehicle_guard("sensors", measure, vehicles));
	if (senses->ray_count > 0)
		TRY(world_rays(vehicles->world, senses->rays, senses->ray_count, senses->hits));
	for (size_t i = 0; i < senses->ray_count; i++)
		tell_range(vehicles, senses, i);
	for (size_t v = 0; v < vehicles->count; v++)
		for (int i = vehicles->list[v].own.sensor.first; i < vehicles->list[v].own.sensor.end; i++)
			add_noise(vehicles, &vehicles->list[v], i);
	return STATUS_OK;
}

bool vehicle_sensors_due(struct vehicles *vehicles)
{
	if (vehicles == NULL || vehicles->senses == NULL)
		return false;
	const double now = world_time(vehicles->world) * vehicles->scene->sensor_rows * (1 + 1e-12);
	if (now < vehicles->sensor_row)
		return false;
	vehicles->sensor_row = floor(now) + 1;
	return true;
}

const double *vehicle_sensed(const struct vehicles *vehicles, size_t index, size_t sensor)
{
	return vehicles->senses->values + vehicles->model->sensor_adr[vehicles->list[index].own.sensor.first + (int)sensor];
}

/* --- life --- */

static enum status check_lidars(const struct vehicles *vehicles)
{
	const struct scene *scene = vehicles->scene;
	for (size_t i = 0; i < scene->lidar_count; i++) {
		const struct scene_lidar *lidar = &scene->lidars[i];
		if (lidar->body == NULL || vehicle_find_part(&vehicles->list[lidar->vehicle - 1], mjOBJ_BODY, lidar->body) > 0)
			continue;
		const struct vehicle *vehicle = &vehicles->list[lidar->vehicle - 1];
		char names[VEHICLE_NAMES];
		vehicle_list_names(vehicle->model, mjOBJ_BODY, vehicle->own.body.first, vehicle->own.body.end, names);
		return fail_with(STATUS_INPUT, "%s: lidars.%s.body: %.64s is no body of %s; there are: %s", scene->file, lidar->name, lidar->body, vehicle->scene->name, names);
	}
	return STATUS_OK;
}

/* Sensors have rows of their own, so their own delays and intervals do not count. */
static void take_histories(const struct vehicles *vehicles)
{
	mjModel *model = vehicles->model;
	bool any = false;
	for (int i = 0; i < (int)model->nsensor; i++) {
		any = any || model->sensor_delay[i] > 0 || model->sensor_interval[2 * i] > 0;
		model->sensor_historyadr[i] = -1;
		model->sensor_history[2 * i] = 0;
		model->sensor_delay[i] = model->sensor_interval[2 * i] = 0;
	}
	if (any)
		note("output.sensors: delay and interval of the models' sensors do not count: all have a row %g times a second", vehicles->scene->sensor_rows);
}

enum status vehicle_make_senses(struct vehicles *vehicles)
{
	const mjModel *model = vehicles->model;
	TRY(check_lidars(vehicles));
	if (!(vehicles->scene->sensor_rows > 0))
		return STATUS_OK;
	if (vehicles->list[vehicles->order[vehicles->all - 1]].own.sensor.end != model->nsensor)
		return fail_with(STATUS_FAILED, "output.sensors: MuJoCo makes other sensors of the models together than of each alone; drive the vehicles in scenes of their own");
	struct senses *senses = mem_calloc(1, sizeof *senses);
	TRY_MEM(senses, "the sensors");
	vehicles->senses = senses;
	const size_t count = (size_t)model->nsensor + 1;
	TRY(mem_zeroed(&senses->change, (size_t)model->nv + 1, sizeof *senses->change, "the sensors"));
	TRY(mem_zeroed(&senses->kept, (size_t)(model->nv + 6 * model->nbody + model->nq) + 1, sizeof *senses->kept, "the sensors"));
	TRY(mem_zeroed(&senses->values, (size_t)model->nsensordata + 1, sizeof *senses->values, "the sensors"));
	TRY(mem_zeroed(&senses->rays, count, sizeof *senses->rays, "the sensors"));
	TRY(mem_zeroed(&senses->hits, count, sizeof *senses->hits, "the sensors"));
	TRY(mem_zeroed(&senses->reach, count, sizeof *senses->reach, "the sensors"));
	TRY(mem_zeroed(&senses->normals, count, sizeof *senses->normals, "the sensors"));
	TRY(mem_zeroed(&senses->ranging, count, sizeof *senses->ranging, "the sensors"));
	take_histories(vehicles);
	return STATUS_OK;
}

void vehicle_free_senses(struct senses *senses)
{
	if (senses != NULL)
		mem_free_all(senses->change, senses->kept, senses->values, senses->rays, senses->hits, senses->reach, senses->normals, senses->ranging, senses);
}
