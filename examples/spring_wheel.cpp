/*
 * Drives a wheel on a spring of this program's own over dunes, as a vehicle's model would.
 *
 *     furrow synth -o dunes.furrow --kind dunes --posts 257x257 --spacing 0.25 --relief 2
 *     c++ -std=c++17 spring_wheel.cpp -o spring_wheel $(pkg-config --cflags --libs furrow)
 *     ./spring_wheel dunes.furrow spring_wheel.furrow
 *
 * A carriage of 60 kg moves east at 1 m/s. A spring and a damper hold a wheel of 15 kg below it. The wheel turns 20 % faster
 * than it rolls. Carriage and wheel move up and down freely; the program integrates both. Printed are the wheel's sinkage,
 * what the soil carries, and the drawbar pull.
 */
#include <furrow.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace {

constexpr double radius = 0.3, width = 0.25;                /* m */
constexpr double speed = 1, slip = 0.2;                     /* m/s; share of 1 */
constexpr double wheel_mass = 15, carriage_mass = 60;       /* kg */
constexpr double stiffness = 8000, damping = 900;           /* N/m, N s/m */
constexpr double length = 0.5;                              /* m: the spring without a load */
constexpr double step = 0.001;                              /* s */
constexpr int steps = 3000, told_every = 250;

struct failure : std::runtime_error {
	furrow_status status;
	explicit failure(furrow_status why) : std::runtime_error(furrow_last_error()), status(why) {}
};

void must(furrow_status status)
{
	if (status != FURROW_OK)
		throw failure(status);
}

struct closer {
	void operator()(furrow_world *world) const { furrow_world_close(world); }
};
using world_ptr = std::unique_ptr<furrow_world, closer>;

world_ptr open_world(const char *store, const char *overlay)
{
	furrow_open open{};
	open.size = sizeof open;
	open.scene = "scene: 1\n"
		     "spacing: 0.03125\n"
		     "soil: {name: sandy_loam_15}\n"
		     "redistribute: {model: scm}\n";
	open.store = store;
	open.overlay = overlay;
	furrow_world *world = nullptr;
	must(furrow_world_open(&open, &world));
	return world_ptr(world);
}

double height_at(furrow_world *world, double x, double y)
{
	const double xy[2] = {x, y};
	furrow_point point;
	must(furrow_points(world, 1, xy, &point));
	return point.height;
}

void drive(furrow_world *world)
{
	struct furrow_info info{};
	info.size = sizeof info;
	must(furrow_info(world, &info));
	const double x0 = info.extent[0] / 4, y = info.extent[1] / 2;

	char object[96];
	std::snprintf(object, sizeof object, "{name: wheel, shape: {wheel: {radius: %g, width: %g}}}", radius, width);
	furrow_body wheel;
	must(furrow_body_add(world, object, &wheel));

	/* The wheel lies on the ground, the carriage above it so that the spring carries it. */
	furrow_state state{};
	state.pose.orientation[0] = 1;
	state.pose.position[0] = x0;
	state.pose.position[1] = y;
	state.pose.position[2] = height_at(world, x0, y) + radius;
	must(furrow_place(world, wheel, &state.pose));
	double carriage = state.pose.position[2] + length - carriage_mass * info.gravity / stiffness, carriage_rises = 0;
	double turned = 0;
	furrow_contact contact{};

	std::printf("time_s,x_m,sinkage_m,soil_N,drawbar_pull_N\n");
	for (int i = 0; i < steps; i++) {
		double &z = state.pose.position[2], &rises = state.linear[2];
		const double spring = stiffness * (length - (carriage - z)) - damping * (carriage_rises - rises);
		carriage_rises += (spring / carriage_mass - info.gravity) * step;
		rises += ((contact.force[2] - spring) / wheel_mass - info.gravity) * step;
		carriage += carriage_rises * step;
		z += rises * step;
		state.pose.position[0] += speed * step;
		state.linear[0] = speed;
		/* It rolls to the east: it turns about its own y axis, which points north. */
		state.angular[1] = speed / (radius * (1 - slip));
		turned += state.angular[1] * step;
		state.pose.orientation[0] = std::cos(turned / 2);
		state.pose.orientation[2] = std::sin(turned / 2);
		must(furrow_set_states(world, 1, &wheel, &state));
		must(furrow_step(world, step));
		must(furrow_get_contacts(world, 1, &wheel, &contact, sizeof contact));
		if ((i + 1) % told_every == 0)
			std::printf("%.3f,%.3f,%.4f,%.1f,%.1f\n", furrow_time(world), state.pose.position[0], contact.sinkage, contact.force[2],
				    contact.force[0]);
	}
}

} // namespace

int main(int argc, char **argv)
{
	if (argc != 3) {
		std::fprintf(stderr, "usage: spring_wheel STORE OVERLAY\n");
		return FURROW_USAGE;
	}
	try {
		const world_ptr world = open_world(argv[1], argv[2]);
		drive(world.get());
	} catch (const failure &why) {
		std::fprintf(stderr, "spring_wheel: %s\n", why.what());
		return why.status;
	}
	return 0;
}
