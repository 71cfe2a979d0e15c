/*
 * Follows a path by pure pursuit: steers on a circle through a point of the path that lies ahead.
 *
 * All wheels turn about one middle. It lies at the circle's radius to the left, on the line through the wheels that do not steer. If
 * all steer, it is on the line through the middle of all. A wheel that steers heads at a right angle to its line to this middle. A driven wheel
 * gets the speed that it has on this circle. So a vehicle without steering turns by the speeds of its sides. Racks, halves that turn against
 * each other, and wheels that follow others were measured: steering.c has what they do on each circle.
 *
 * The path is followed by the place of that line on the vehicle's axis, or by its origin. A speed below 0 drives it backward: all is the same as seen
 * from its tail.
 *
 * A vehicle that is slower than it should be sums up the difference in time (I), and its rims go faster by that sum. An actuator that keeps
 * a rate gets the rate of its rim. Any other one gets a force in proportion to how much its rim is too slow (P). The yaw of a vehicle without steering is
 * controlled in the same way.
 */
#include <math.h>

#include "vehicle/powertrain.h"

#define AHEAD_BASES 1.2 /* the point ahead: in wheelbases, */
#define AHEAD_TIME 1.0  /* and at least as far as it goes in this time, s, */
#define AHEAD_ORIGIN 2.5 /* and in distances of the origin from the line about which it turns, if the origin follows */
#define START_TIME 1.0  /* s: the speed takes at least so long to grow from 0 to what is asked for, */
#define START 0.2       /* of the gravity: and its acceleration is no larger */
#define STOP 0.1        /* of the gravity: the deceleration before the path's end */
#define CREEP 0.05      /* m/s, or a tenth of the speed, if that is less: at this speed it arrives at the end */
#define GAIN 8.0        /* 1/s: acceleration by what a rim lacks */
#define GAIN_TRAIN 2.0  /* 1/s: the same with a powertrain, which answers later */
#define STABLE 0.5      /* of what a wheel lacks, in a step of the engine */
#define GAIN_SUM 1.0    /* 1/s: how fast what is lacking is summed up */
#define GAIN_HOLD 5.0   /* 1/s: while it shall stand */
#define FORCE_MOST 0.5  /* of the gravity: what forces that are summed up give, for a slope */
#define SUM_SHARE 0.5   /* of the speed: what rims may be faster, */
#define SUM_LEAST 0.05  /* m/s: or this */
#define GAIN_TURN 2.0   /* 1/s: the same of the yaw */
#define TURN_SHARE 1.5  /* of the yaw rate that is wanted */
#define TURN_LEAST 0.3  /* rad, times the speed and by the wheelbase */

/* A wheel or a belt of the vehicle, in the axes of its root: x forward, y left. `radius`: of a belt that of its sprocket. */
struct wheel {
	double x, y, radius;
	double half; /* m: half of the length of a belt */
	double side; /* 1: its joint turns about left or up, -1: about right or down */
};

/* `up`: whether the joint's axis is compared with up, of a steering one, or with left. */
static struct wheel wheel_of(const struct vehicle *vehicle, int actuator, bool up)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	const int joint = model->actuator_trnid[2 * actuator];
	const struct soil_geom *driven = vehicle_driven(vehicle, joint);
	const bool belt = driven != NULL && driven->shape.belt;
	double axes[9], from[3], own[3], axis[3];
	struct wheel wheel = {.radius = 0};
	vehicle_root_axes(vehicle, data, axes);
	mju_sub3(from, belt ? &data->geom_xpos[3 * driven->geom] : &data->xanchor[3 * joint], &data->xpos[3 * vehicle->root]);
	mju_mulMatTVec3(own, axes, from);
	mju_mulMatTVec3(axis, axes, &data->xaxis[3 * joint]);
	wheel.x = own[0];
	wheel.y = own[1];
	wheel.side = axis[up ? 2 : 1] >= 0 ? 1 : -1;
	if (driven != NULL)
		wheel.radius = belt || driven->dof < 0 ? fabs(vehicle_turning_radius(driven)) : soil_shape_rolling(&driven->shape);
	wheel.half = belt ? driven->shape.size[0] / 2 : 0;
	return wheel;
}

/* The line about which it turns, and its wheelbase. Wheels that steer and drive stand within 1 cm of the actuator that steers. */
static void measure(const struct vehicle *vehicle, double *middle, double *base)
{
	const struct driver *driver = &vehicle->driver;
	double low = INFINITY, high = -INFINITY, sum = 0, all = 0;
	size_t fixed = 0;
	*middle = driver->steering.middle;
	*base = driver->steering.base;
	if (!driver->steering.plain)
		return;
	for (size_t i = 0; i < driver->drive_count; i++) {
		const struct wheel wheel = wheel_of(vehicle, driver->drive[i], false);
		bool steers = false;
		for (size_t s = 0; s < driver->steer_count; s++) {
			const struct wheel steered = wheel_of(vehicle, driver->steer[s], true);
			low = fmin(low, steered.x);
			high = fmax(high, steered.x);
			steers = steers || hypot(steered.x - wheel.x, steered.y - wheel.y) < 0.25 * wheel.radius + 0.01;
		}
		low = fmin(low, wheel.x - wheel.half);
		high = fmax(high, wheel.x + wheel.half);
		all += wheel.x;
		sum += steers ? 0 : wheel.x;
		fixed += !steers;
	}
	*middle = fixed > 0 ? sum / (double)fixed : all / (double)driver->drive_count;
	*base = fmax(high - low, 0.1);
}

double vehicle_wheelbase(const struct vehicle *vehicle)
{
	double middle, base;
	measure(vehicle, &middle, &base);
	return base;
}

/* --- the path --- */

static double length_of(const struct driver *driver, size_t segment)
{
	return hypot(driver->points[segment + 1][0] - driver->points[segment][0], driver->points[segment + 1][1] - driver->points[segment][1]);
}

/* Moves `at` to the place of the path that is nearest to (x, y), never back. Returns the metres that are left. */
static double go_on(struct driver *driver, double x, double y)
{
	const size_t last = driver->point_count - 1;
	size_t segment = (size_t)driver->at;
	double share = driver->at - (double)segment;
	for (; segment < last; segment++, share = 0) {
		const double *a = driver->points[segment], *b = driver->points[segment + 1], length = length_of(driver, segment);
		const double along = length > 0 ? ((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / (length * length) : 1;
		share = fmax(share, along);
		if (share < 1)
			break;
	}
	driver->at = segment < last ? (double)segment + share : (double)last;
	double left = segment < last ? (1 - share) * length_of(driver, segment) : 0;
	for (size_t i = segment + 1; i < last; i++)
		left += length_of(driver, i);
	return left;
}

/* Finds the place `ahead` metres on. Beyond its end the path goes straight on. */
static void look(const struct driver *driver, double ahead, double place[2])
{
	const size_t last = driver->point_count - 1;
	size_t segment = (size_t)driver->at < last ? (size_t)driver->at : last - 1;
	double share = driver->at - (double)segment, length = length_of(driver, segment);
	double left = (1 - share) * length;
	while (ahead > left && segment + 1 < last) {
		ahead -= left;
		share = 0;
		left = length = length_of(driver, ++segment);
	}
	const double *a = driver->points[segment], *b = driver->points[segment + 1];
	const double to = length > 0 ? share + ahead / length : 1;
	for (int i = 0; i < 2; i++)
		place[i] = a[i] + to * (b[i] - a[i]);
}

/* --- the actuators --- */

/* What the driver asks of the vehicle: the way's curvature for its own forward, and the speed of its rims. Below 0 it goes backward. */
struct order {
	double middle, curvature, speed, grows; /* grows: m/s2, how the speed changes */
};

/* Finds the rows of the table between which a curvature lies, and how far it is on to the second one. */
static size_t find_row(const struct steering *steering, double curvature, double *share)
{
	size_t row = steering->first;
	while (row + 2 < steering->end && steering->curvatures[row + 1] <= curvature)
		row++;
	const double low = steering->curvatures[row], high = steering->curvatures[row + 1];
	*share = fmin(fmax((curvature - low) / (high - low), 0), 1);
	return row;
}

static double between(const double *table, size_t row, size_t count, size_t i, double share)
{
	const double low = table[row * count + i];
	return low + share * (table[(row + 1) * count + i] - low);
}

/* Returns the rate of a driving actuator on this circle, for each m/s of the vehicle. */
static double rate_of(const struct vehicle *vehicle, size_t i, double middle, double curvature)
{
	const struct driver *driver = &vehicle->driver;
	if (!driver->steering.plain) {
		double share;
		const size_t row = find_row(&driver->steering, curvature, &share);
		return between(driver->steering.rates, row, driver->drive_count, i, share);
	}
	const struct wheel wheel = wheel_of(vehicle, driver->drive[i], false);
	const double side = 1 - curvature * wheel.y, gear = vehicle_gear(vehicle->model, driver->drive[i])[0];
	return gear * wheel.side * copysign(hypot(side, curvature * (wheel.x - middle)), side) / wheel.radius;
}

static void drive(const struct vehicle *vehicle, const struct order *order)
{
	const struct driver *driver = &vehicle->driver;
	const mjModel *model = vehicle->model;
	const double mass = model->body_subtreemass[vehicle->root] / (double)driver->drive_count;
	for (size_t i = 0; i < driver->drive_count; i++) {
		const int actuator = driver->drive[i];
		const double rate = rate_of(vehicle, i, order->middle, order->curvature);
		if (vehicle_keeps_rate(model, actuator)) {
			vehicle_ask_rate(vehicle, actuator, rate * order->speed);
			continue;
		}
		const double straight = rate_of(vehicle, i, order->middle, 0);
		const int out = model->actuator_outadr[actuator];
		/* A light wheel in the air must not swing. */
		const double stiff = fmin(mass * GAIN / (straight * straight), STABLE / (model->actuator_acc0[out] * model->opt.timestep));
		vehicle_ask_force(vehicle, actuator, stiff * (rate * order->speed - vehicle->data->actuator_velocity[out]) + mass * order->grows / straight);
	}
}

static void steer(const struct vehicle *vehicle, const struct order *order)
{
	const struct driver *driver = &vehicle->driver;
	double share = 0;
	const size_t row = driver->steering.plain ? 0 : find_row(&driver->steering, order->curvature, &share);
	for (size_t i = 0; i < driver->steer_count; i++) {
		const int actuator = driver->steer[i];
		if (!driver->steering.plain) {
			vehicle_ask_place(vehicle, actuator, between(driver->steering.lengths, row, driver->steer_count, i, share));
			continue;
		}
		const struct wheel wheel = wheel_of(vehicle, actuator, true);
		const double angle = atan2(order->curvature * (wheel.x - order->middle), fmax(1 - order->curvature * wheel.y, 1e-3));
		vehicle_ask_place(vehicle, actuator, vehicle_gear(vehicle->model, actuator)[0] * wheel.side * angle);
	}
}

/* --- speed and yaw --- */

/* Where the vehicle is in plan, and how it moves. */
struct motion {
	double x, y, heading; /* of its origin; the heading is that in which it goes, so of its tail if it goes backward */
	double backward;      /* 1: it goes forward, -1: backward */
	double speed, yaw;    /* m/s in that direction; rad/s */
};

static struct motion motion_of(const struct vehicle *vehicle, double backward)
{
	const mjData *data = vehicle->data;
	double axes[9], velocity[6]; /* rad/s, then m/s */
	vehicle_root_axes(vehicle, data, axes);
	mj_objectVelocity(vehicle->model, data, mjOBJ_XBODY, vehicle->root, velocity, 0);
	return (struct motion){
		.x = vehicle->origin[0] + data->xpos[3 * vehicle->root],
		.y = vehicle->origin[1] + data->xpos[3 * vehicle->root + 1],
		.heading = atan2(backward * axes[3], backward * axes[0]),
		.backward = backward,
		.speed = backward * (velocity[3] * axes[0] + velocity[4] * axes[3] + velocity[5] * axes[6]),
		.yaw = velocity[0] * axes[2] + velocity[1] * axes[5] + velocity[2] * axes[8],
	};
}

/* The speed that the scene asks for here and now, below 0 backward. */
static double asked(const struct vehicle *vehicle)
{
	const struct driver *driver = &vehicle->driver;
	const double *speeds = vehicle->scene->speeds;
	if (driver->sent.is)
		return driver->sent.speed;
	const size_t last = driver->point_count - 1, from = (size_t)driver->at < last ? (size_t)driver->at : last - 1;
	return speeds != NULL ? speeds[from] + (driver->at - (double)from) * (speeds[from + 1] - speeds[from]) : vehicle->scene->way.speed;
}

static bool shall_stand(const struct vehicle *vehicle, double time)
{
	bool stops = false;
	for (size_t i = 0; i < vehicle->scene->stop_count; i++)
		stops = stops || (time >= vehicle->scene->stops[i][0] && time < vehicle->scene->stops[i][1]);
	return stops;
}

/* Brings the speed that is wanted nearer to what is asked for. `left`: m of the path. Returns how it grows, m/s2. */
static double want(struct vehicle *vehicle, double most, double left, double time)
{
	struct driver *driver = &vehicle->driver;
	const double gravity = -vehicle->model->opt.gravity[2], h = vehicle->model->opt.timestep;
	const double ends = fmax(sqrt(2 * STOP * gravity * left), fmin(CREEP, 0.1 * most));
	const double grows = fmin(most / START_TIME, START * gravity), before = driver->speed;
	const double to = fmin(shall_stand(vehicle, time) ? 0 : most, ends);
	driver->speed = driver->arrived ? 0 : fmin(fmax(to, before - START * gravity * h), before + grows * h);
	return fmax((driver->speed - before) / h, -START * gravity);
}

static bool all_at_limit(const struct vehicle *vehicle)
{
	const struct driver *driver = &vehicle->driver;
	const mjModel *model = vehicle->model;
	bool all = driver->drive_count > 0;
	for (size_t i = 0; i < driver->drive_count && all; i++) {
		const int actuator = driver->drive[i];
		const double force = vehicle->data->actuator_force[model->actuator_outadr[actuator]];
		all = model->actuator_forcelimited[actuator] && (force <= model->actuator_forcerange[2 * actuator] || force >= model->actuator_forcerange[2 * actuator + 1]);
	}
	return all;
}

/* Returns how fast rims go, so that the vehicle goes as fast as it should. `before`: the speed that it should have had. */
static double rims(struct vehicle *vehicle, const struct motion *motion, double before)
{
	struct driver *driver = &vehicle->driver;
	bool force = vehicle_has_engine(vehicle);
	for (size_t i = 0; i < driver->drive_count; i++)
		force = force || !vehicle_keeps_rate(vehicle->model, driver->drive[i]);
	if (!force && before > 0 && driver->speed == 0)
		driver->sum = 0; /* that was slip, and there is none at rest */
	const double speed = driver->speed + driver->sum, behind = driver->speed - motion->speed;
	const double most = fmax(SUM_SHARE * driver->speed, SUM_LEAST) - (force ? FORCE_MOST * vehicle->model->opt.gravity[2] / GAIN : 0);
	if (behind * driver->sum <= 0 || !all_at_limit(vehicle)) /* what actuators cannot do is not summed up */
		driver->sum += (driver->speed > 0 ? GAIN_SUM : GAIN_HOLD) * behind * vehicle->model->opt.timestep;
	driver->sum = fmin(fmax(driver->sum, -most), most);
	return speed;
}

/* Returns the curvature that a vehicle without steering is asked for, so that it turns as it should. Its belts and wheels slip to their sides. */
static double turned(struct vehicle *vehicle, const struct motion *motion, double curvature, double base)
{
	struct driver *driver = &vehicle->driver;
	const double wanted = curvature * driver->speed, most = TURN_SHARE * fabs(wanted) + TURN_LEAST * driver->speed / base;
	if (driver->steer_count > 0 || driver->speed <= 0)
		return curvature;
	driver->turn = fmin(fmax(driver->turn + GAIN_TURN * (wanted - motion->yaw) * vehicle->model->opt.timestep, -most), most);
	return (wanted + driver->turn) / driver->speed;
}

/* --- the pursuit --- */

void vehicle_pursue(struct vehicle *vehicle, double time)
{
	struct driver *driver = &vehicle->driver;
	const struct motion motion = motion_of(vehicle, !driver->sent.is && vehicle->scene->way.speed < 0 ? -1 : 1);
	double middle, base, goal[2];
	measure(vehicle, &middle, &base);
	const double along = motion.backward * middle; /* from the origin, in the direction in which it goes */
	const double x = motion.x + along * cos(motion.heading), y = motion.y + along * sin(motion.heading);
	const bool origin = vehicle->scene->follows_origin;
	if (driver->sent.fresh && driver->sent.turns)
		driver->speed = driver->sum = driver->turn = 0; /* they were of its way backward */
	driver->sent.fresh = driver->sent.turns = false;
	if (driver->point_count < 2) {
		driver->arrived = true;
		return;
	}
	const double left = driver->left = origin ? go_on(driver, motion.x, motion.y) : go_on(driver, x, y);
	driver->arrived = driver->at >= (double)(driver->point_count - 1);
	const double before = driver->speed, grows = want(vehicle, fabs(asked(vehicle)), left, time);
	look(driver, fmax(fmax(AHEAD_BASES * base, AHEAD_TIME * driver->speed), origin ? AHEAD_ORIGIN * fabs(middle) : 0), goal);
	const double ahead = (goal[0] - x) * cos(motion.heading) + (goal[1] - y) * sin(motion.heading);
	const double aside = -(goal[0] - x) * sin(motion.heading) + (goal[1] - y) * cos(motion.heading);
	const double squares = ahead * ahead + aside * aside - (origin ? middle * middle : 0);
	const double curvature = squares > 0 ? 2 * aside / squares : 0;
	const struct order order = {middle, motion.backward * turned(vehicle, &motion, curvature, base), motion.backward * rims(vehicle, &motion, before), motion.backward * grows};
	steer(vehicle, &order);
	if (vehicle_has_engine(vehicle) && motion.backward < 0)
		*vehicle_train_control(vehicle, POWERTRAIN_GEAR) = -1;
	if (vehicle_has_engine(vehicle))
		vehicle_train_effort(vehicle, vehicle_train_effort_for(vehicle, GAIN_TRAIN * (driver->speed - motion.speed) + GAIN * driver->sum + grows));
	else
		drive(vehicle, &order);
	if (driver->arrived || driver->speed == 0)
		vehicle_train_hold(vehicle);
}
