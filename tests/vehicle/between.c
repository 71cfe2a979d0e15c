/*
 * Two vehicles that meet in free flight: what one gets, the other loses, and they never have more energy than before. Head on they part as the
 * law of MuJoCo's contacts says, which is integrated here on its own.
 */
#include <math.h>

#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"
#include "vehicle/internal.h"

static const char free_body[] = "<mujoco>%s<option timestep=\"%g\"/><worldbody><body><freejoint/>"
				"<inertial pos=\"0 0 0\" mass=\"%g\" diaginertia=\"%g %g %g\"/><geom name=\"body\" %s friction=\"%g\"/>"
			   "<geom name=\"foot\" type=\"sphere\" size=\"0.01\" contype=\"0\" conaffinity=\"0\"/></body></worldbody></mujoco>";
static const char wedge[] = "<asset><mesh name=\"wedge\" vertex=\"-1 -1 -0.5  1 -1 -0.5  1 1 -0.5  -1 1 -0.5  0.2 0 0.9\" scale=\"0.3 0.3 0.3\"/></asset>";

struct pair {
	struct scene *scene;
	struct vehicles *vehicles;
};

struct thing {
	const char *geom;
	double mass;
};

/* Two vehicles that float. */
static struct pair make(const struct thing *a, const struct thing *b, double step, double friction)
{
	struct pair pair;
	char text[2048];
	const struct thing *const both[] = {a, b};
	for (int i = 0; i < 2; i++) {
		const double mass = both[i]->mass;
		snprintf(text, sizeof text, free_body, strstr(both[i]->geom, "wedge") != NULL ? wedge : "", step, mass, mass / 20, mass / 20,
			 mass / 20, both[i]->geom, friction);
		support_write(support_path(i == 0 ? "a.xml" : "b.xml"), text);
	}
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\ntime_step: %g\ngravity: 1e-9\nsoil: {name: dry_sand, elastic_stiffness: 1e3}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: a, model: a.xml, start: {at: [5, 5]}, soil: [foot]}\n"
				    "  - {name: b, model: b.xml, start: {at: [5, 5]}, soil: [foot]}\n", step);
	support_write(support_path("scene.yaml"), text);
	must(scene_load(support_path("scene.yaml"), NULL, 0, &pair.scene));
	must(vehicle_load(pair.scene, &pair.vehicles));
	for (int v = 0; v < 2; v++)
		pair.vehicles->list[v].geoms[0].contact.state = FURROW_AIR;
	mju_zero3(pair.vehicles->model->opt.gravity);
	return pair;
}

static void forget(struct pair *pair)
{
	vehicle_destroy(pair->vehicles);
	scene_destroy(pair->scene);
}

static double *velocity_of(const struct pair *pair, int v)
{
	return pair->vehicles->data->qvel + pair->vehicles->list[v].own.dof.first;
}

static void put(struct pair *pair, int v, const double place[3], const double velocity[6])
{
	static const double upright[4] = {1, 0, 0, 0};
	double *to = pair->vehicles->data->qpos + pair->vehicles->list[v].own.qpos.first;
	mju_copy3(to, place);
	mju_copy4(to + 3, upright);
	mju_copy(velocity_of(pair, v), velocity, 6);
	vehicle_find_places(pair->vehicles);
}

/* One time step. Returns true if they touch. */
static bool step(struct pair *pair)
{
	vehicle_advance(pair->vehicles, 0, pair->scene->time_step, 0, true);
	return pair->vehicles->data->ncon > 0;
}

static double energy(const struct pair *pair)
{
	return vehicle_kinetic(&pair->vehicles->list[0]) + vehicle_kinetic(&pair->vehicles->list[1]);
}

/* Linear momentum, and the angular one about MuJoCo's origin. */
static void find_momentum(const struct pair *pair, double momentum[6])
{
	const mjModel *model = pair->vehicles->model;
	mjData *data = pair->vehicles->data;
	mju_zero(momentum, 6);
	mj_subtreeVel(model, data);
	for (int v = 0; v < 2; v++) {
		const int body = pair->vehicles->list[v].root;
		double linear[3], lever[3];
		mju_scl3(linear, data->subtree_linvel + 3 * body, vehicle_mass(&pair->vehicles->list[v]));
		mju_cross(lever, data->subtree_com + 3 * body, linear);
		mju_addTo3(momentum, linear);
		mju_addTo3(momentum + 3, lever);
		mju_addTo3(momentum + 3, data->subtree_angmom + 3 * body);
	}
}

/* --- the law of a contact on its own --- */

/* Speed at which two bodies part that met head on with speed 1: default solref and solimp, steps of a microsecond. */
static double parting(double constant)
{
	const double stiffness = 1 / (0.95 * 0.95 * constant * constant), damping = 2 / (0.95 * constant), h = 1e-6;
	double gap = 0, rate = -1;
	for (int i = 0; i < 1000000; i++) {
		const double x = fmin(fabs(gap) / 0.001, 1), y = x <= 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x), d = 0.9 + 0.05 * y;
		const double wanted = d * (-damping * rate - stiffness * d * gap);
		if (wanted <= 0)
			break;
		rate += h * wanted;
		gap += h * rate;
	}
	return rate;
}

static void head_on_they_part_as_the_law_says(void **state)
{
	static const double masses[][2] = {{1000, 1000}, {1000, 100}, {70, 4000}}, steps[] = {0.002, 0.001, 0.0005};
	const double wanted = parting(0.02);
	(void)state;
	print_message("by the law they part with %.4f of the speed\n", wanted);
	assert_true(wanted > 0.1 && wanted < 0.2);
	for (int m = 0; m < 3; m++)
		for (int s = 0; s < 3; s++) {
			const struct thing a = {"type=\"sphere\" size=\"0.5\"", masses[m][0]}, b = {"type=\"sphere\" size=\"0.5\"", masses[m][1]};
			struct pair pair = make(&a, &b, steps[s], 1);
			const double *const va = velocity_of(&pair, 0), *const vb = velocity_of(&pair, 1);
			put(&pair, 0, (const double[]){0, 0, 0}, (const double[]){1, 0, 0, 0, 0, 0});
			put(&pair, 1, (const double[]){1.0001, 0, 0}, (const double[]){0, 0, 0, 0, 0, 0});
			for (double t = 0; t < 0.3; t += steps[s])
				step(&pair);
			const double apart = vb[0] - va[0], together = a.mass / (a.mass + b.mass);
			print_message("%g kg on %g kg, %g s: %.4f and %.4f m/s, part with %.4f\n", a.mass, b.mass, steps[s], va[0], vb[0], apart);
			assert_true(fabs(apart - wanted) < 2 * steps[s]);
			/* Momentum gives both velocities from the one. */
			assert_true(fabs(va[0] - (together - apart * b.mass / (a.mass + b.mass))) < 1e-12);
			assert_true(fabs(vb[0] - (together + apart * a.mass / (a.mass + b.mass))) < 1e-12);
			forget(&pair);
		}
}

/* A time constant that the time step cannot follow is made longer. */
static void stiff_bodies_do_not_spring_back(void **state)
{
	static const char *const stiff[] = {"0.0005 1", "1e-5 1"};
	(void)state;
	for (int i = 0; i < 2; i++) {
		char geom[100];
		snprintf(geom, sizeof geom, "type=\"sphere\" size=\"0.5\" solref=\"%s\"", stiff[i]);
		const struct thing sphere = {geom, 100};
		struct pair pair = make(&sphere, &sphere, 0.002, 1);
		put(&pair, 0, (const double[]){0, 0, 0}, (const double[]){1, 0, 0, 0, 0, 0});
		put(&pair, 1, (const double[]){1.0001, 0, 0}, (const double[]){0, 0, 0, 0, 0, 0});
		for (double t = 0; t < 0.3; t += 0.002)
			step(&pair);
		const double apart = velocity_of(&pair, 1)[0] - velocity_of(&pair, 0)[0];
		print_message("solref %s: part with %.3f\n", stiff[i], apart);
		assert_true(apart >= 0 && apart < 0.3);
		forget(&pair);
	}
}

static void what_one_gets_the_other_loses(void **state)
{
	static const char *const shapes[] = {"type=\"sphere\" size=\"0.3\"", "type=\"box\" size=\"0.4 0.3 0.2\"", "type=\"capsule\" size=\"0.2 0.3\"",
					     "type=\"cylinder\" size=\"0.3 0.2\"", "type=\"ellipsoid\" size=\"0.4 0.3 0.2\"", "type=\"mesh\" mesh=\"wedge\""};
	static const double speeds[] = {0.1, 1, 10}, angles[] = {0, 30, 55}, masses[] = {10, 100, 1};
	int met = 0;
	double worst_energy = 0, worst_linear = 0, worst_angular = 0;
	(void)state;
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			const struct thing a = {shapes[i], 10}, b = {shapes[j], masses[(i + j) % 3]};
			struct pair pair = make(&a, &b, 0.002, 0.5);
			for (int k = 0; k < 9; k++) {
				const double angle = angles[k % 3] * M_PI / 180, speed = speeds[k / 3], scale = (a.mass + b.mass) * speed;
				double most = 0, first[6], momentum[6];
				bool touched = false;
				/* The second one comes from above, off the middle, and turns. */
				put(&pair, 0, (const double[]){0, 0, 0}, (const double[]){0, 0, 0, 0.1, 0.2, 0.3});
				put(&pair, 1, (const double[]){0.05 - 1.15 * tan(angle), 0.03, 1.15},
				    (const double[]){speed * sin(angle), 0, -speed * cos(angle), 0.5, -0.3, 0.2});
				const double start = energy(&pair);
				find_momentum(&pair, first);
				for (double t = 0; t < 2.5 / speed && t < 6; t += 0.002) {
					touched = step(&pair) || touched;
					most = support_most(most, energy(&pair));
				}
				met += touched;
				find_momentum(&pair, momentum);
				worst_energy = support_most(worst_energy, most / start - 1);
				worst_linear = support_most(worst_linear, mju_dist3(momentum, first) / scale);
				worst_angular = support_most(worst_angular, mju_dist3(momentum + 3, first + 3) / scale);
			}
			forget(&pair);
		}
	print_message("%d of %d met; energy at most %.3g above the start, momentum off by %.3g, angular momentum by %.3g m\n", met, 6 * 6 * 9, worst_energy, worst_linear,
		      worst_angular);
	assert_true(met > 200);
	assert_true(worst_linear < 1e-12);
	assert_true(worst_energy < 1e-9 && worst_angular < 1e-5);
}

static void each_allocation_that_fails_is_told(void **state)
{
	const struct thing wedges = {"type=\"mesh\" mesh=\"wedge\"", 10};
	struct pair pair = make(&wedges, &wedges, 0.002, 1);
	enum status status;
	uint64_t nth = 0;
	(void)state;
	vehicle_destroy(pair.vehicles);
	do {
		mem_fail_nth(++nth, 0);
		status = vehicle_load(pair.scene, &pair.vehicles);
		mem_fail_nth(0, 0);
		if (status != STATUS_OK) {
			assert_int_equal(status, STATUS_FAILED);
			assert_non_null(strstr(failure_message(), "out of memory"));
			assert_null(pair.vehicles);
		}
	} while (status != STATUS_OK && nth < 1000);
	assert_true(status == STATUS_OK && nth > 20);
	forget(&pair);
}

TEST_PROGRAM(between)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(head_on_they_part_as_the_law_says),
		cmocka_unit_test(stiff_bodies_do_not_spring_back),
		cmocka_unit_test(what_one_gets_the_other_loses),
		cmocka_unit_test(each_allocation_that_fails_is_told),
	};
	return cmocka_run_group_tests_name("vehicles that meet", tests, support_enter, support_leave);
}
