/* A vehicle with a powertrain in a host's world: on a stand with its wheels in the air, or on the ground. */
#ifndef TESTS_VEHICLE_TRAIN_H
#define TESTS_VEHICLE_TRAIN_H

#include <math.h>

#include "../api/hosted.h"
#include "../support/near.h"
#include "drive.h"

#include "api/library.h"
#include "vehicle/powertrain.h"

#define RADIUS 0.3
#define WHEEL_MASS 20.0
#define WHEEL_INERTIA (WHEEL_MASS * RADIUS * RADIUS / 2)
#define RPM (M_PI / 30)
#define STEP 0.002

static const struct extent extent = {129, 129, 0.25, 32};
static double slope; /* tangent */
static bool welded;  /* wheels have no hinges */
static double damping[4]; /* N m s: of the hinges fl, fr, rl, rr */
static double looks;      /* degrees: the direction from x to y in which the model looks */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 50 + slope * extent.spacing * (double)x;
}

/* Four wheels fl, fr, rl, rr on hinges turn_*, at 1 m ahead and behind, 0.6 m aside. `low`: how far a stand reaches below them, m; 0: none. mass: kg, of the hull. */
static inline void write_model(double low, double mass, const char *more)
{
	static const char *const names[] = {"fl", "fr", "rl", "rr"};
	const double c = cos(looks * M_PI / 180), s = sin(looks * M_PI / 180);
	char text[4096], at[4][64];
	for (int i = 0; i < 4; i++) {
		const double x = i < 2 ? 1 : -1, y = i & 1 ? -0.6 : 0.6;
		snprintf(at[i], sizeof at[i], "%.9g %.9g", c * x - s * y, s * x + c * y);
	}
	int length = snprintf(text, sizeof text, "<mujoco><option timestep=\"0.002\" integrator=\"implicitfast\"/><worldbody><body name=\"hull\" pos=\"0 0 %g\">%s"
					       "<inertial pos=\"0 0 0\" mass=\"%g\" diaginertia=\"%g %g %g\" euler=\"0 0 %g\"/>", RADIUS + low, low > 0 ? "" : "<freejoint/>", mass, 0.2 * mass,
			      0.6 * mass, 0.6 * mass, looks);
	if (low > 0)
		length += snprintf(text + length, sizeof text - (size_t)length, "<geom name=\"stand\" type=\"box\" size=\"0.2 0.2 %g\" pos=\"0 0 %g\"/>", low, -RADIUS);
	for (int i = 0; i < 4 && welded; i++)
		length += snprintf(text + length, sizeof text - (size_t)length, "<geom name=\"%s\" type=\"cylinder\" pos=\"%s 0\" size=\"%g 0.1\" euler=\"90 0 0\" mass=\"%g\"/>", names[i], at[i],
				   RADIUS, WHEEL_MASS);
	for (int i = 0; i < 4 && !welded; i++)
		length += snprintf(text + length, sizeof text - (size_t)length,
				   "<body pos=\"%s 0\" euler=\"0 0 %g\"><joint name=\"turn_%s\" axis=\"0 1 0\" damping=\"%g\"/><geom name=\"%s\" type=\"cylinder\" size=\"%g 0.1\" euler=\"90 0 0\" mass=\"%g\"/></body>",
				   at[i], looks, names[i], damping[i], names[i], RADIUS, WHEEL_MASS);
	snprintf(text + length, sizeof text - (size_t)length, "</body></worldbody>%s</mujoco>", more);
	support_write(support_path("model.xml"), text);
}

/* Opens a world with the vehicle, which settles. `keys`: of the vehicle, as "powertrain: {...}, brakes: 100". */
static inline struct furrow_world *open_train(const char *keys, double step, double yaw, const char *soil)
{
	char text[4096];
	snprintf(text, sizeof text, "scene: 1\nend_time: 100\ntime_step: %g\nsoil: {name: %s}\nspacing: 0.0625\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: model.xml, start: {at: [12, 12], yaw: %g}, %s}\n", step, soil, yaw, keys);
	support_write(support_path("scene.yaml"), text);
	support_store(support_path("ground.furrow"), extent, ground);
	struct furrow_world *world = NULL;
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("ground.furrow"), .overlay = support_path("over.furrow"),
					 .output = support_path("out")};
	unlink(support_path("over.furrow"));
	done(furrow_world_open(&open, &world));
	return world;
}

static inline struct vehicle *vehicle_of(struct furrow_world *world)
{
	return &world->vehicles->list[0];
}

static inline struct powertrain *train_of(struct furrow_world *world)
{
	return vehicle_of(world)->train;
}

/* Sets the controls of the powertrain, and leaves the actuators to the driver. */
static inline void control(struct furrow_world *world, double throttle, double brake, double gear)
{
	const size_t own = range_count(vehicle_of(world)->own.actuator), count = vehicle_control_count(vehicle_of(world));
	double values[64];
	for (size_t i = 0; i < count; i++)
		values[i] = (double)NAN;
	values[own + POWERTRAIN_BRAKE] = brake;
	if (count - own == POWERTRAIN_CONTROLS) {
		values[own + POWERTRAIN_THROTTLE] = throttle;
		values[own + POWERTRAIN_GEAR] = gear;
	}
	done(furrow_set_controls(world, 0, count, values));
}

static inline void go(struct furrow_world *world, double seconds)
{
	const double ends = furrow_time(world) + seconds;
	while (furrow_time(world) < ends - 1e-9)
		done(furrow_step(world, 0));
}

/* rad/s and N m of a wheel: fl, fr, rl, rr. */
static inline double turns(struct furrow_world *world, size_t wheel)
{
	return vehicle_of(world)->data->qvel[train_of(world)->wheels[wheel].dof];
}

static inline double pulls(struct furrow_world *world, size_t wheel)
{
	return train_of(world)->wheels[wheel].drive;
}

#endif
