/*
 * Setting vehicles down before a drive begins.
 *
 * A vehicle starts in its model's first pose, at `start`, so high that its lowest soil geom touches. First all motion is slowed, so
 * that the soil is loaded slowly: it sinks as deep as a resting load does, and no deeper. In this time it does not move along the level, nor
 * does it yaw. Soil that yields under a body hardly holds it on a slope. Then it moves freely until it is at rest.
 * All controls are 0, and wheels do not turn. The time of this does not count; what it does to the ground does.
 */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"
#include "vehicle/start.h"

#define SLOWED 100.0    /* 1/s: rate at which all velocities decay in the first second, */
#define SLOWED_LATER 25.0 /* and after it: slower, so that springs find their balance sooner */
#define STILL_SLOWED 1e-4 /* m/s: slower than this, the slowed vehicle is in balance within about a thousandth of its weight */
#define STILL 2e-5      /* m/s: slower than this, the free vehicle is at rest */
#define CALM 0.1        /* s: for so long */
#define SLOWED_MOST 60.0 /* s */
#define SLOWED_WILD 15.0 /* s: at most so long, if all that is not calm then moves faster than TREMBLES: it swings, and more time calms nothing */
#define SLOWED_RESTLESS 25.0 /* s: the same for what moves faster than RESTLESS */
#define FREE_MOST 20.0  /* s */
#define FREE_WILD 10.0  /* s: the same */
#define FREE_RESTLESS 15.0 /* s: the same */
#define RESTLESS 3e-4   /* m/s: faster than this after so long, it trembles, and will go on to */
#define TREMBLES 2e-3   /* m/s: slower than this at the end, its wheels tremble by micrometres; their sides lie on a row of posts */
#define WORK_MOST 15.0  /* s of the clock: for so long a vehicle may sink that is deeper than it is high, */
#define SINKS 1e-3      /* m/s: faster than this */
#define HEAVY 2000      /* triangles: a mesh of more is told where settling takes long */
#define TOLD_SECONDS 10.0 /* of the clock, between two lines that tell how far it is */
#define UNREST_WORK 15.0 /* s of work: from then on a vehicle that trembles, and comes no nearer to rest, fails its start. */
#define NEARER 0.8      /* It comes nearer to rest if its mean speed is that much less than the least before, */
#define NEARER_WORK 4.0 /* in each time of so much work, s, */
#define NEARER_TIME 1.0 /* and of so long a motion, s */
#define FIRST_TIME 1.0  /* s of a stage's motion that do not count: what was set down finds its way, and is slowed more */
#define INSIDE 1e-3     /* m: deeper than this, a vehicle starts inside another one */

/* --- settling --- */

static double speed_of(const struct vehicle *vehicle)
{
	return sqrt(2 * fmax(vehicle_kinetic(vehicle), 0) / vehicle_mass(vehicle));
}

static void begin(struct vehicles *vehicles, double stage)
{
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		vehicle->begun = stage;
		vehicle->slow = vehicle->settle_seconds; /* when the stage began */
		vehicle->calm = 0;
	}
	vehicles->unrest = (struct unrest){.samples = 0};
}

/* Makes all geoms change the ground in the next step, so that it knows how deep they sank. */
static void touch_all(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			vehicles->list[v].geoms[g].is_touched = false;
}

static void tell_unrest(const struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->count; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		if (vehicle->calm < CALM && !vehicle->scene->start.unsettled && speed_of(vehicle) > TREMBLES)
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
	const double *at = geom->now.pose.position;
	snprintf(text, size, "%s%s: is %.3g m deep in the soil, deeper than it is high, at %.3f, %.3f, %.3f m: the soil does not carry the vehicle, which weighs "
			     "%.4g N; check bekker_kphi (in N/m^(n+2)%s), the vehicle's mass, and spacing, %g m", vehicle->is_world ? "" : "vehicles.", geom->name, geom->contact.sinkage, at[0], at[1], at[2],
		 vehicle_mass(vehicle) * vehicles->scene->gravity, soil, world_resident(vehicles->world)->spacing);
}

/* Soil that yields does not lift a geom again. So a vehicle is refused once a geom is deeper than it is large in any direction. A thin plate
 * that is only deeper than it is high may be carried. But if it still sinks after so much work, that is told at once. */
/* Seconds of work since settling began: of the clock, or of the processor where that is less, since other programs may have had it. */
static double work_so_far(const struct vehicles *vehicles)
{
	return vehicles->settling_begun > 0 ? fmin(clock_seconds() - vehicles->settling_begun, clock_process_seconds() - vehicles->settling_processor) : 0;
}

static enum status check_sunk(const struct vehicles *vehicles)
{
	char text[500];
	for (size_t v = 0; v < vehicles->all; v++) {
		const struct soil_geom *geom = vehicle_sunk(&vehicles->list[v]);
		if (geom == NULL)
			continue;
		const bool works_long = work_so_far(vehicles) > WORK_MOST && speed_of(&vehicles->list[v]) > SINKS;
		if (geom->contact.sinkage <= 2 * soil_shape_bound(&geom->shape) && !works_long)
			continue;
		vehicle_say_sunk(vehicles, &vehicles->list[v], geom, text, sizeof text);
		return fail_with(STATUS_INPUT, "%s: while it settles, %s", vehicles->scene->file, text);
	}
	return STATUS_OK;
}

/* Writes which mesh costs most, if it has many triangles. */
static void say_heavy(const struct vehicles *vehicles, char *text, size_t size)
{
	uint32_t most = HEAVY;
	text[0] = '\0';
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			const struct soil_geom *geom = &vehicles->list[v].geoms[g];
			if (geom->shape.kind != SOIL_MESH || geom->shape.mesh->triangle_count <= most)
				continue;
			most = geom->shape.mesh->triangle_count;
			snprintf(text, size, "; the mesh of %s%s has %u triangles, which take the time: thin it, or leave it out of soil", vehicles->list[v].is_world ? "" : "vehicles.",
				 geom->name, most);
		}
}

/* Writes which geom of a vehicle is deepest in the soil, where, and how deep. */
static void say_deepest(const struct vehicle *vehicle, char *text, size_t size)
{
	const struct soil_geom *deepest = NULL;
	for (const struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++)
		if (geom->contact.area > 0 && (deepest == NULL || geom->contact.sinkage > deepest->contact.sinkage))
			deepest = geom;
	if (deepest == NULL) {
		snprintf(text, size, "none of its geoms touches the ground");
		return;
	}
	const double *at = deepest->now.pose.position;
	snprintf(text, size, "vehicles.%s is deepest, by %.3g mm, at %.3f, %.3f, %.3f m", deepest->name, 1e3 * deepest->contact.sinkage, at[0], at[1], at[2]);
}

static const struct vehicle *fastest_of(const struct vehicles *vehicles)
{
	const struct vehicle *fastest = &vehicles->list[0];
	for (size_t v = 1; v < vehicles->count; v++)
		if (speed_of(&vehicles->list[v]) > speed_of(fastest))
			fastest = &vehicles->list[v];
	return fastest;
}

bool vehicle_unrest_fails(struct unrest *unrest, double speed, double time, double work)
{
	if (time < FIRST_TIME || unrest->least == 0) /* a stage begins */
		*unrest = (struct unrest){.least = INFINITY, .time = time, .work = work};
	unrest->sum += speed;
	unrest->samples++;
	if (work - unrest->work < NEARER_WORK || time - unrest->time < NEARER_TIME)
		return false;
	const double mean = unrest->sum / unrest->samples;
	const bool nearer = mean < NEARER * unrest->least;
	*unrest = (struct unrest){.least = fmin(unrest->least, mean), .mean = mean, .time = time, .work = work};
	return !nearer && work >= UNREST_WORK && mean > TREMBLES;
}

/* Fails for vehicles that tremble, and have come no nearer to rest for a while, after much work. */
static enum status check_unrest(struct vehicles *vehicles)
{
	const struct vehicle *fastest = fastest_of(vehicles);
	const double work = work_so_far(vehicles), time = vehicles->list[0].settle_seconds;
	char heavy[300], deepest[300];
	if (!vehicle_unrest_fails(&vehicles->unrest, speed_of(fastest), time - vehicles->list[0].slow, work) || fastest->scene->start.unsettled)
		return STATUS_OK;
	say_heavy(vehicles, heavy, sizeof heavy);
	say_deepest(fastest, deepest, sizeof deepest);
	return vehicle_fail_start(vehicles, fastest, "it comes to no rest: after %.3g s of work it has moved for %.3g s, still at %.2g mm/s, and comes no nearer to rest; %s; "
						     "give a finer spacing (now %g m) or time_step (now %.3g s), or begin without settling (start: {settle: false})%s",
				  work, time, 1e3 * vehicles->unrest.mean, deepest, world_resident(vehicles->world)->spacing, vehicles->scene->time_step, heavy);
}

/* Tells now and then how far it is: settling may take minutes of computing. */
static void tell_settling(struct vehicles *vehicles, double still)
{
	const double now = clock_seconds();
	char heavy[300], deepest[300];
	if (vehicles->settling_begun == 0) {
		vehicles->settling_told = vehicles->settling_begun = now;
		vehicles->settling_processor = clock_process_seconds();
	}
	if (now - vehicles->settling_told < TOLD_SECONDS)
		return;
	vehicles->settling_told = now;
	say_heavy(vehicles, heavy, sizeof heavy);
	say_deepest(fastest_of(vehicles), deepest, sizeof deepest);
	note("vehicles: settling before the first step, %.3g s simulated of at most %g: still at %.2g mm/s, at rest below %g; %s%s", vehicles->list[0].settle_seconds,
	     SLOWED_MOST + FREE_MOST, 1e3 * speed_of(fastest_of(vehicles)), 1e3 * still, deepest, heavy);
}

/* Returns true if all vehicles that settle have been at rest for a while. */
static bool all_calm(const struct vehicles *vehicles)
{
	bool all = true;
	for (size_t v = 0; v < vehicles->all; v++)
		all = all && (vehicles->list[v].calm >= CALM || vehicles->list[v].is_world || vehicles->list[v].scene->start.unsettled); /* a thing may swing for ever */
	return all;
}

static enum status settle_step(struct vehicles *vehicles, double rate, double still)
{
	const double seconds = vehicles->scene->time_step;
	if (world_stopped(vehicles->world))
		return world_interrupted(vehicles->world);
	TRY(vehicle_move(vehicles, rate, false));
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		vehicle->settle_seconds += seconds;
		vehicle->calm = speed_of(vehicle) < still ? vehicle->calm + seconds : 0;
		if (!vehicle->is_world)
			TRY(vehicle_check_moved(vehicles, vehicle));
	}
	TRY(check_sunk(vehicles));
	TRY(world_move_hosts(vehicles->world));
	TRY(vehicle_record(vehicles));
	tell_settling(vehicles, still);
	return check_unrest(vehicles);
}

/* Returns true if each vehicle that is not calm moves faster than that, m/s. It is by what the record has, so a resumed start ends alike. */
static bool all_faster(const struct vehicles *vehicles, double speed)
{
	bool all = true;
	for (size_t v = 0; v < vehicles->all; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		all = all && (vehicle->calm >= CALM || vehicle->is_world || vehicle->scene->start.unsettled || speed_of(vehicle) > speed);
	}
	return all;
}

/* How long a stage of settling takes at most, s: at all; of what is wild, or restless. */
struct limits {
	double most, wild, restless;
};

static bool goes_on(const struct vehicles *vehicles, const struct limits *limits)
{
	const double time = vehicles->list[0].settle_seconds - vehicles->list[0].slow;
	return !all_calm(vehicles) && time <= limits->most && (time <= limits->wild || !all_faster(vehicles, TREMBLES)) && (time <= limits->restless || !all_faster(vehicles, RESTLESS));
}

/* Lets all vehicles move until each was at rest for a while. */
static enum status until_still(struct vehicles *vehicles, double rate, double still, struct limits limits)
{
	const struct vehicle *first = &vehicles->list[0];
	while (goes_on(vehicles, &limits)) {
		const bool later = first->settle_seconds - first->slow >= 1;
		TRY(settle_step(vehicles, later ? fmin(rate, SLOWED_LATER) : rate, still));
	}
	return STATUS_OK;
}

/* The bodies are placed first, so that the world reads the ground around them. */
static enum status place_bodies(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++)
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

static void find_forces(void *argument)
{
	struct vehicles *vehicles = argument;
	mj_forward(vehicles->model, vehicles->data);
}

/* A vehicle must not start inside another one, or inside a thing of `world`. */
static enum status check_inside(const struct vehicles *vehicles)
{
	const mjData *data = vehicles->data;
	const mjContact *deepest = NULL;
	for (int i = 0; i < data->ncon; i++) {
		const mjContact *contact = &data->contact[i];
		if (contact->geom[0] >= 0 && contact->geom[1] >= 0 && vehicle_of_geom(vehicles, contact->geom[0]) != vehicle_of_geom(vehicles, contact->geom[1]) &&
		    (deepest == NULL || contact->dist < deepest->dist))
			deepest = contact;
	}
	if (deepest == NULL || deepest->dist >= -INSIDE)
		return STATUS_OK;
	const struct vehicle *of[2] = {vehicle_of_geom(vehicles, deepest->geom[0]), vehicle_of_geom(vehicles, deepest->geom[1])};
	const int second = of[0]->is_world ? 1 : of[1]->is_world || of[0] > of[1] ? 0 : 1; /* that is told: the later vehicle of the scene */
	char names[2][200];
	for (int k = 0; k < 2; k++)
		vehicle_geom_name(of[k], deepest->geom[k], names[k], sizeof names[k]);
	return vehicle_fail_start(vehicles, of[second], "its geom %s starts %.3g m inside %s of %s%s; move the start of one of them", names[second],
				  -deepest->dist, names[1 - second], of[1 - second]->is_world ? "" : "vehicles.", of[1 - second]->scene->name);
}

static enum status start(struct vehicles *vehicles)
{
	begin(vehicles, VEHICLE_SLOWED); /* also after a failure: a vehicle is set down once */
	TRY(vehicle_find_origin(vehicles));
	for (size_t i = 0; i < vehicles->all; i++)
		TRY(vehicle_set_down(vehicles, &vehicles->list[vehicles->order[i]]));
	TRY(vehicle_guard("vehicles", find_forces, vehicles));
	for (size_t v = 0; v < vehicles->all; v++)
		TRY(vehicles->list[v].is_world ? vehicle_check_things(vehicles, &vehicles->list[v]) : vehicle_check_start(vehicles, &vehicles->list[v]));
	TRY(check_inside(vehicles));
	return place_bodies(vehicles);
}

static enum status settle(struct vehicles *vehicles)
{
	const struct vehicle *first = &vehicles->list[0];
	if (first->begun == VEHICLE_SLOWED) {
		enum status status = until_still(vehicles, SLOWED, STILL_SLOWED, (struct limits){SLOWED_MOST, SLOWED_WILD, SLOWED_RESTLESS});
		touch_all(vehicles);
		TRY(status);
		begin(vehicles, VEHICLE_FREE);
	}
	if (first->begun == VEHICLE_FREE) {
		TRY(until_still(vehicles, 0, STILL, (struct limits){FREE_MOST, FREE_WILD, FREE_RESTLESS}));
		tell_unrest(vehicles);
	}
	return STATUS_OK;
}

enum status vehicle_settle(struct vehicles *vehicles)
{
	if (vehicles->list[0].begun == VEHICLE_ABOVE)
		TRY(start(vehicles));
	TRY(settle(vehicles));
	begin(vehicles, VEHICLE_DRIVES);
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		vehicle->slow = 0;
		vehicle->settle_seconds = vehicle->scene->start.unsettled ? 0 : vehicle->settle_seconds;
		TRY(vehicle_start_speed(vehicles, vehicle));
	}
	vehicles->data->time = 0;
	return STATUS_OK;
}
