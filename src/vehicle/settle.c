/*
 * Setting vehicles down before a drive begins.
 *
 * A vehicle starts in its model's first pose, at `start`, so high that its lowest soil geom touches. First all motion is slowed, so
 * that the soil is loaded slowly: it sinks as deep as a resting load does, and no deeper. In this time it does not move along the level, nor
 * does it yaw. Soil that yields under a body hardly holds it on a slope. Then it moves freely until it is at rest.
 * All controls are 0, and wheels do not turn. The time of this does not count; what it does to the ground does.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "vehicle/between.h"
#include "vehicle/settle.h"

#define SLOWED 100.0    /* 1/s: what slows all motion at first, */
#define SLOWED_LATER 25.0 /* and after a second, so that springs find their balance sooner */
#define STILL_SLOWED 1e-4 /* m/s: slower than this, the slowed vehicle is in balance within about a thousandth of its weight */
#define STILL 2e-5      /* m/s: slower than this, the free vehicle is at rest */
#define CALM 0.1        /* s: for so long */
#define SLOWED_MOST 60.0 /* s */
#define FREE_MOST 20.0  /* s */
#define TREMBLES 2e-3   /* m/s: slower than this at the end, its wheels tremble by micrometres; their sides lie on a row of posts */
#define TOLD_SECONDS 10.0 /* of the clock, between two lines that tell how far it is */
#define SIDES 8         /* directions each way in which the lowest places of a geom are looked for */

/* --- where it starts --- */

enum status vehicle_fail_start(const struct vehicles *vehicles, const struct vehicle *vehicle, const char *format, ...)
{
	char why[700], line[16] = "";
	va_list args;
	va_start(args, format);
	vsnprintf(why, sizeof why, format, args);
	va_end(args);
	if (vehicle->scene->line > 0)
		snprintf(line, sizeof line, ":%d", vehicle->scene->line);
	return fail_with(STATUS_INPUT, "%s%s: vehicles.%s.start: %s", vehicles->scene->file, line, vehicle->scene->name, why);
}

/* Turns and shifts a root body of the model: its free joint, or its place in the model's world. */
static void place_root(struct vehicle *vehicle, int body)
{
	const mjModel *model = vehicle->model;
	mjData *data = vehicle->data;
	const double half = vehicle->scene->yaw / 2, yaw[4] = {cos(half), 0, 0, sin(half)};
	const int joint = model->body_jntadr[body];
	const bool free = joint >= 0 && model->jnt_type[joint] == mjJNT_FREE;
	double *pos = free ? &data->qpos[model->jnt_qposadr[joint]] : &model->body_pos[3 * body];
	double *quat = free ? pos + 3 : &model->body_quat[4 * body];
	double turned[4], place[3];
	mju_rotVecQuat(place, pos, yaw);
	mju_mulQuat(turned, yaw, quat);
	mju_copy3(pos, place);
	mju_copy4(quat, turned);
}

static void lift_root(struct vehicle *vehicle, int body, double height)
{
	const mjModel *model = vehicle->model;
	const int joint = model->body_jntadr[body];
	const bool free = joint >= 0 && model->jnt_type[joint] == mjJNT_FREE;
	*(free ? &vehicle->data->qpos[model->jnt_qposadr[joint] + 2] : &model->body_pos[3 * body + 2]) += height;
}

static void each_root(struct vehicle *vehicle, void (*act)(struct vehicle *vehicle, int body, double height), double height)
{
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		if (vehicle->model->body_parentid[body] == 0)
			act(vehicle, body, height);
}

static void turn_root(struct vehicle *vehicle, int body, double height)
{
	(void)height;
	place_root(vehicle, body);
}

/* Finds how far a geom is below the ground at most; negative: above it. *any false: there is no ground under one of its places. */
static enum status depth_of(const struct vehicles *vehicles, const struct vehicle *vehicle, int geom, double *depth, bool *any)
{
	*depth = -INFINITY;
	*any = true;
	for (int i = -SIDES; i <= SIDES; i++)
		for (int j = -SIDES; j <= SIDES; j++) {
			const double direction[3] = {(double)i / SIDES, (double)j / SIDES, -1};
			double place[3];
			int64_t height;
			bool found;
			vehicle_geom_support(vehicle->model, vehicle->data, geom, direction, place);
			mju_addTo3(place, vehicle->origin);
			TRY(resident_ground_height(world_resident(vehicles->world)->ground, lattice_offset(place[0]), lattice_offset(place[1]), &height, &found));
			*any = *any && found;
			if (found)
				*depth = fmax(*depth, lattice_offset_metres(height) - place[2]);
		}
	return STATUS_OK;
}

static enum status check_start(const struct vehicles *vehicles, const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++) {
		double depth;
		bool any, soil = false;
		char name[256];
		for (size_t g = 0; g < vehicle->geom_count; g++)
			soil = soil || vehicle->geoms[g].geom == i;
		if (soil || vehicle_is_fixed(model, i) || (model->geom_contype[i] == 0 && model->geom_conaffinity[i] == 0))
			continue;
		TRY(depth_of(vehicles, vehicle, i, &depth, &any));
		if (depth <= 0)
			continue;
		vehicle_geom_name(model, i, name, sizeof name);
		return vehicle_fail_start(vehicles, vehicle, "its geom %s starts %.3g m under ground, and does not press it; name it in soil, or start elsewhere",
					  name, depth);
	}
	return STATUS_OK;
}

static enum status turn(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	TRY(world_start_point(vehicles->world, vehicle->scene, vehicle->origin));
	each_root(vehicle, turn_root, 0);
	return STATUS_OK;
}

enum status vehicle_replace(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	TRY(turn(vehicles, vehicle));
	each_root(vehicle, lift_root, vehicle->lift);
	return STATUS_OK;
}

/* Fails for a vehicle that starts where there is no ground. Small numbers off a terrain that knows degrees are probably degrees. */
static enum status fail_ground(const struct vehicles *vehicles, const struct vehicle *vehicle, const struct soil_geom *geom)
{
	const struct extent *extent = &world_resident(vehicles->world)->meta->extent;
	const double *at = vehicle->origin, *from = &vehicle->data->geom_xpos[3 * geom->geom];
	const bool degrees = !extent_holds(extent, at[0], at[1]) && vehicles->scene->coordinates == SCENE_LOCAL && world_resident(vehicles->world)->meta->srs[0] != '\0' && fabs(at[0]) <= 360 && fabs(at[1]) <= 90;
	return vehicle_fail_start(vehicles, vehicle, "no ground under %s at %g, %g m; start on the terrain, %g x %g m, away from holes%s", geom->name, at[0] + from[0], at[1] + from[1],
				  extent_side(extent, 0), extent_side(extent, 1),
				  degrees ? "; if these are longitude and latitude, give coordinates: degrees" : "");
}

static enum status set_down(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	double deepest = -INFINITY;
	TRY(turn(vehicles, vehicle));
	mj_kinematics(vehicle->model, vehicle->data);
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		double depth;
		bool any;
		TRY(depth_of(vehicles, vehicle, vehicle->geoms[g].geom, &depth, &any));
		if (!any)
			return fail_ground(vehicles, vehicle, &vehicle->geoms[g]);
		deepest = fmax(deepest, depth);
	}
	/* Whole metres are the origin's, so that MuJoCo's numbers stay small. */
	const double whole = floor(deepest);
	vehicle->origin[2] = whole;
	vehicle->lift = deepest - whole;
	each_root(vehicle, lift_root, vehicle->lift);
	mj_forward(vehicle->model, vehicle->data);
	return check_start(vehicles, vehicle);
}

/* --- settling --- */

static double speed_of(const struct vehicle *vehicle)
{
	return sqrt(2 * fmax(vehicle_kinetic(vehicle), 0) / mj_getTotalmass(vehicle->model));
}

static void begin(struct vehicles *vehicles, double stage)
{
	for (size_t v = 0; v < vehicles->count; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		vehicle->begun = stage;
		vehicle->slow = vehicle->settle_seconds; /* when the stage began */
		vehicle->calm = 0;
	}
}

/* Makes all geoms change the ground in the next step, so that it knows how deep they sank. */
static void touch_all(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->count; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			vehicles->list[v].geoms[g].is_touched = false;
}

static void tell_unrest(const struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->count; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		if (vehicle->calm < CALM && speed_of(vehicle) > TREMBLES)
			note("vehicles.%s: is not at rest after %.3g s of settling: it still moves at %.3g m/s; the drive begins", vehicle->scene->name,
			     vehicle->settle_seconds, speed_of(vehicle));
	}
}

const struct soil_geom *vehicle_sunk(const struct vehicle *vehicle)
{
	const struct soil_geom *deepest = NULL;
	for (const struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++)
		if (geom->contact.state == FURROW_SUNK && (deepest == NULL || geom->contact.sinkage > deepest->contact.sinkage))
			deepest = geom;
	return deepest;
}

void vehicle_say_sunk(const struct vehicles *vehicles, const struct vehicle *vehicle, const struct soil_geom *geom, char *text, size_t size)
{
	char soil[64] = "";
	if (vehicles->scene->soil_count == 1)
		snprintf(soil, sizeof soil, ", here %g", vehicles->scene->soils[0].bekker_kphi);
	snprintf(text, size, "vehicles.%s: is %.3g m deep in the soil, deeper than it is high: the soil does not carry the vehicle, which weighs %.4g N; "
			     "check bekker_kphi (in N/m^(n+2)%s), the vehicle's mass, and spacing", geom->name, geom->contact.sinkage,
		 mj_getTotalmass(vehicle->model) * vehicles->scene->gravity, soil);
}

/* Soil that yields does not lift a geom again. So a vehicle is refused once a geom is deeper than it is large in any direction. A thin plate
 * that is only deeper than it is high may be carried. */
static enum status check_sunk(const struct vehicles *vehicles)
{
	char text[500];
	for (size_t v = 0; v < vehicles->count; v++) {
		const struct soil_geom *geom = vehicle_sunk(&vehicles->list[v]);
		if (geom == NULL || geom->contact.sinkage <= 2 * soil_shape_bound(&geom->shape))
			continue;
		vehicle_say_sunk(vehicles, &vehicles->list[v], geom, text, sizeof text);
		return fail_with(STATUS_INPUT, "%s: while it settles, %s", vehicles->scene->file, text);
	}
	return STATUS_OK;
}

/* Tells now and then how far it is: settling may take minutes of computing. */
static void tell_settling(struct vehicles *vehicles, double still)
{
	const double now = clock_seconds();
	double fastest = 0;
	if (vehicles->settling_told == 0)
		vehicles->settling_told = now;
	if (now - vehicles->settling_told < TOLD_SECONDS)
		return;
	vehicles->settling_told = now;
	for (size_t v = 0; v < vehicles->count; v++)
		fastest = fmax(fastest, speed_of(&vehicles->list[v]));
	note("vehicles: settling before the first step, %.3g s simulated of at most %g: still at %.2g mm/s, at rest below %g", vehicles->list[0].settle_seconds,
	     SLOWED_MOST + FREE_MOST, 1e3 * fastest, 1e3 * still);
}

/* Lets all vehicles move until each was at rest for a while. */
static enum status until_still(struct vehicles *vehicles, double rate, double still, double most)
{
	const double seconds = vehicles->scene->time_step;
	bool all = false;
	while (!all && vehicles->list[0].settle_seconds - vehicles->list[0].slow <= most) {
		const bool later = vehicles->list[0].settle_seconds - vehicles->list[0].slow >= 1;
		if (world_stopped(vehicles->world))
			return world_interrupted(vehicles->world);
		TRY(vehicle_move(vehicles, later ? fmin(rate, SLOWED_LATER) : rate, false));
		all = true;
		for (size_t v = 0; v < vehicles->count; v++) {
			struct vehicle *vehicle = &vehicles->list[v];
			vehicle->settle_seconds += seconds;
			vehicle->calm = speed_of(vehicle) < still ? vehicle->calm + seconds : 0;
			all = all && vehicle->calm >= CALM;
		}
		TRY(check_sunk(vehicles));
		TRY(world_move_hosts(vehicles->world));
		TRY(vehicle_record(vehicles));
		tell_settling(vehicles, still);
	}
	return STATUS_OK;
}

/* The bodies are placed first, so that the world reads the ground around them. */
static enum status place_bodies(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->count; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			struct soil_geom *geom = &vehicles->list[v].geoms[g];
			vehicle_geom_state(&vehicles->list[v], geom, &geom->now, &geom->now_belt);
			TRY(vehicle_lift_hull(vehicles, &vehicles->list[v], geom));
			if (geom->aloft)
				continue;
			TRY(world_body_place(vehicles->world, geom->number, &geom->now.pose));
			TRY(world_bodies_set(vehicles->world, 1, &geom->number, &geom->now, &geom->now_belt));
			geom->touched = geom->now;
			geom->touched_belt = geom->now_belt;
			geom->is_touched = true;
		}
	TRY(world_move_hosts(vehicles->world));
	return vehicle_record(vehicles);
}

static enum status start(struct vehicles *vehicles)
{
	begin(vehicles, VEHICLE_SLOWED); /* also after a failure: a vehicle is set down once */
	for (size_t v = 0; v < vehicles->count; v++)
		TRY(set_down(vehicles, &vehicles->list[v]));
	TRY(vehicle_between_check_start(vehicles));
	return place_bodies(vehicles);
}

enum status vehicle_settle(struct vehicles *vehicles)
{
	const struct vehicle *first = &vehicles->list[0];
	if (first->begun == VEHICLE_ABOVE)
		TRY(start(vehicles));
	if (first->begun == VEHICLE_SLOWED) {
		enum status status = until_still(vehicles, SLOWED, STILL_SLOWED, SLOWED_MOST);
		touch_all(vehicles);
		TRY(status);
		begin(vehicles, VEHICLE_FREE);
	}
	if (first->begun == VEHICLE_FREE) {
		enum status status = until_still(vehicles, 0, STILL, FREE_MOST);
		tell_unrest(vehicles);
		TRY(status);
	}
	begin(vehicles, VEHICLE_DRIVES);
	for (size_t v = 0; v < vehicles->count; v++) {
		vehicles->list[v].slow = 0;
		vehicles->list[v].data->time = 0;
	}
	return STATUS_OK;
}
