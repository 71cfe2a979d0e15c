/*
 * Follows a path by pure pursuit: steers on a circle through a point of the path that lies ahead.
 *
 * All wheels turn about one middle. It lies at the circle's radius to the left, on the line through the wheels that do not steer. If
 * all steer, it is on the line through the middle of all. A wheel that steers heads at a right angle to its line to this middle. A driven wheel
 * gets the speed that it has on this circle. So a vehicle without steering turns by the speeds of its sides.
 *
 * An actuator that is a velocity servo gets the wheel's angular velocity. Any other gets a torque, which grows with what the
 * vehicle lacks of its speed (PI).
 */
#include <math.h>

#include "vehicle/powertrain.h"

#define AHEAD_BASES 1.2 /* the point ahead: in wheelbases, */
#define AHEAD_TIME 1.0  /* and at least as far as it goes in this time, s */
#define START_TIME 1.0  /* s in which the speed grows to its value */
#define STOP_TIME 1.0   /* s before the path's end from which on the speed falls */
#define GAIN 2.0        /* 1/s, 1/s2: acceleration by lack of speed, and by its sum */
#define GAIN_SUM 1.0
#define SUM_MOST 10.0   /* m */

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
	double from[3], own[3], axis[3];
	struct wheel wheel = {.radius = 0};
	mju_sub3(from, belt ? &data->geom_xpos[3 * driven->geom] : &data->xanchor[3 * joint], &data->xpos[3 * vehicle->root]);
	mju_mulMatTVec3(own, &data->xmat[9 * vehicle->root], from);
	mju_mulMatTVec3(axis, &data->xmat[9 * vehicle->root], &data->xaxis[3 * joint]);
	wheel.x = own[0];
	wheel.y = own[1];
	wheel.side = axis[up ? 2 : 1] >= 0 ? 1 : -1;
	if (driven != NULL)
		wheel.radius = belt ? fabs(driven->sprocket) : driven->shape.radius;
	wheel.half = belt ? driven->shape.size[0] / 2 : 0;
	return wheel;
}

/* The line about which it turns, and its wheelbase. Wheels that steer and drive stand within 1 cm of the actuator that steers. */
static void measure(const struct vehicle *vehicle, double *middle, double *base)
{
	const struct driver *driver = &vehicle->driver;
	double low = INFINITY, high = -INFINITY, sum = 0, all = 0;
	size_t fixed = 0;
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

static bool is_servo(const mjModel *model, int actuator)
{
	const double *gain = &model->actuator_gainprm[actuator * mjNGAIN], *bias = &model->actuator_biasprm[actuator * mjNBIAS];
	return model->actuator_biastype[actuator] == mjBIAS_AFFINE && bias[1] == 0 && bias[2] != 0 && bias[2] == -gain[0];
}

/* Acceleration that it needs, m/s2. */
static double lacks(struct vehicle *vehicle, double speed)
{
	struct driver *driver = &vehicle->driver;
	double velocity[6];
	mj_objectVelocity(vehicle->model, vehicle->data, mjOBJ_BODY, vehicle->root, velocity, 1);
	const double behind = speed - velocity[3];
	driver->sum = fmin(fmax(driver->sum + behind * vehicle->model->opt.timestep, -SUM_MOST), SUM_MOST);
	return GAIN * behind + GAIN_SUM * driver->sum;
}

static void drive(struct vehicle *vehicle, double middle, double curvature, double speed)
{
	const struct driver *driver = &vehicle->driver;
	const mjModel *model = vehicle->model;
	bool torque = false;
	if (vehicle->train != NULL && vehicle->train->scene != NULL) {
		vehicle_train_effort(vehicle, vehicle_train_effort_for(vehicle, lacks(vehicle, speed)));
		return;
	}
	for (size_t i = 0; i < driver->drive_count; i++)
		torque = torque || !is_servo(model, driver->drive[i]);
	const double needs = torque ? lacks(vehicle, speed) : 0;
	for (size_t i = 0; i < driver->drive_count; i++) {
		const int actuator = driver->drive[i];
		const struct wheel wheel = wheel_of(vehicle, actuator, false);
		const double side = 1 - curvature * wheel.y, gear = vehicle_gear(model, actuator)[0];
		const double way = copysign(hypot(side, curvature * (wheel.x - middle)), side);
		const double each = vehicle_mass(vehicle) * needs * wheel.radius / (double)driver->drive_count;
		const double gain = model->actuator_gainprm[actuator * mjNGAIN];
		*vehicle_ctrl(vehicle, actuator) = is_servo(model, actuator) ? gear * wheel.side * speed * way / wheel.radius
									     : wheel.side * each / (gear * (gain != 0 ? gain : 1));
	}
}

static void steer(struct vehicle *vehicle, double middle, double curvature)
{
	const struct driver *driver = &vehicle->driver;
	for (size_t i = 0; i < driver->steer_count; i++) {
		const int actuator = driver->steer[i];
		const struct wheel wheel = wheel_of(vehicle, actuator, true);
		const double angle = atan2(curvature * (wheel.x - middle), fmax(1 - curvature * wheel.y, 1e-3));
		*vehicle_ctrl(vehicle, actuator) = vehicle_gear(vehicle->model, actuator)[0] * wheel.side * angle;
	}
}

void vehicle_pursue(struct vehicle *vehicle, double time)
{
	struct driver *driver = &vehicle->driver;
	const mjData *data = vehicle->data;
	const double *forward = &data->xmat[9 * vehicle->root];
	const double heading = atan2(forward[3], forward[0]), wanted = vehicle->scene->way.speed;
	double middle, base, goal[2];
	measure(vehicle, &middle, &base);
	const double x = vehicle->origin[0] + data->xpos[3 * vehicle->root] + middle * cos(heading);
	const double y = vehicle->origin[1] + data->xpos[3 * vehicle->root + 1] + middle * sin(heading);
	if (driver->point_count < 2) {
		driver->arrived = true;
		return;
	}
	const double left = driver->left = go_on(driver, x, y);
	look(driver, fmax(AHEAD_BASES * base, AHEAD_TIME * wanted), goal);
	const double ahead = (goal[0] - x) * cos(heading) + (goal[1] - y) * sin(heading);
	const double aside = -(goal[0] - x) * sin(heading) + (goal[1] - y) * cos(heading);
	const double squares = ahead * ahead + aside * aside, curvature = squares > 0 ? 2 * aside / squares : 0;
	driver->arrived = driver->at >= (double)(driver->point_count - 1);
	const double speed = driver->arrived ? 0 : wanted * fmin(1, fmin(time / START_TIME, fmax(left / (STOP_TIME * wanted), 0.1)));
	steer(vehicle, middle, curvature);
	drive(vehicle, middle, curvature, speed);
	if (driver->arrived)
		vehicle_train_hold(vehicle);
}
