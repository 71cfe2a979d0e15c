/*
 * Two bodies that meet in free flight: what one gets, the other loses, and they never have more energy than before. Head on they part as the
 * law of a contact says, which is integrated here on its own.
 */
#include <math.h>

#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"
#include "vehicle/between.h"

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
	for (int v = 0; v < 2; v++) {
		struct vehicle *vehicle = &pair.vehicles->list[v];
		vehicle->geoms[0].contact.state = FURROW_AIR;
		mju_zero3(vehicle->model->opt.gravity);
	}
	return pair;
}

static void forget(struct pair *pair)
{
	vehicle_destroy(pair->vehicles);
	scene_destroy(pair->scene);
}

static void put(struct pair *pair, int v, const double place[3], const double velocity[6])
{
	struct vehicle *vehicle = &pair->vehicles->list[v];
	mju_copy3(vehicle->data->qpos, place);
	mju_copy(vehicle->data->qvel, velocity, 6);
	vehicle_find_places(vehicle);
}

/* The forces and moments on both bodies about MuJoCo's origin, and the sum of their sizes. */
static double wrench(const struct pair *pair, double sum[6])
{
	double size = 0;
	mju_zero(sum, 6);
	for (int v = 0; v < 2; v++) {
		const struct vehicle *vehicle = &pair->vehicles->list[v];
		const double *force = vehicle->pushed, *at = vehicle->data->qpos;
		double moment[3], lever[3];
		mju_rotVecQuat(moment, force + 3, at + 3);
		mju_cross(lever, at, force);
		mju_addTo3(sum, force);
		mju_addTo3(sum + 3, moment);
		mju_addTo3(sum + 3, lever);
		size += mju_norm3(force) + mju_norm3(moment) + mju_norm3(lever);
	}
	return size;
}

/* No contact pulls, friction stays in its cone, and only takes energy. The velocities are those at the step's end. */
static void check_friction(const struct pair *pair, double friction)
{
	const struct between *between = pair->vehicles->between;
	for (size_t i = 0; i < between->count; i++) {
		const struct meeting *meeting = &between->meetings[i];
		double power = 0;
		for (int axis = 1; axis < 3; axis++)
			for (int k = 0; k < 2; k++)
				power += (k == 0 ? -1 : 1) * meeting->force[axis] *
					 mju_dot(meeting->rows[k] + 6 * axis, pair->vehicles->list[meeting->vehicle[k]].data->qvel, 6);
		const double shear = hypot(meeting->force[1], meeting->force[2]);
		assert_true(meeting->force[0] >= 0 && shear <= friction * meeting->force[0] * (1 + 1e-12));
		assert_true(power <= 1e-6 * shear);
	}
}

/* One time step. Returns the share of the force that has no counterforce; below 0: they do not touch. */
static double step(struct pair *pair)
{
	const double seconds = pair->scene->time_step;
	double sum[6];
	for (int v = 0; v < 2; v++)
		vehicle_prepare(&pair->vehicles->list[v], 0, true);
	must(vehicle_between_push(pair->vehicles));
	const double size = wrench(pair, sum);
	for (int v = 0; v < 2; v++)
		vehicle_advance(&pair->vehicles->list[v], 0, seconds, 0, true);
	return size > 0 ? mju_norm(sum, 6) / size : -1;
}

static double energy(const struct pair *pair)
{
	return vehicle_kinetic(&pair->vehicles->list[0]) + vehicle_kinetic(&pair->vehicles->list[1]);
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
			double *const va = pair.vehicles->list[0].data->qvel, *const vb = pair.vehicles->list[1].data->qvel;
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

static void find_momentum(const struct pair *pair, const struct thing *a, const struct thing *b, double momentum[3])
{
	mju_zero3(momentum);
	for (int v = 0; v < 2; v++) {
		const struct vehicle *vehicle = &pair->vehicles->list[v];
		mj_subtreeVel(vehicle->model, vehicle->data);
		mju_addToScl3(momentum, vehicle->data->subtree_linvel, v == 0 ? a->mass : b->mass);
	}
}

/* A time constant that the time step cannot follow is made longer. */
static void stiff_bodies_do_not_spring_back(void **state)
{
	static const char *const stiff[] = {"0.0005 1", "1e-5 1", "-1e9 -1e3"};
	(void)state;
	for (int i = 0; i < 3; i++) {
		char geom[100];
		snprintf(geom, sizeof geom, "type=\"sphere\" size=\"0.5\" solref=\"%s\"", stiff[i]);
		const struct thing sphere = {geom, 100};
		struct pair pair = make(&sphere, &sphere, 0.002, 1);
		put(&pair, 0, (const double[]){0, 0, 0}, (const double[]){1, 0, 0, 0, 0, 0});
		put(&pair, 1, (const double[]){1.0001, 0, 0}, (const double[]){0, 0, 0, 0, 0, 0});
		for (double t = 0; t < 0.3; t += 0.002)
			step(&pair);
		const double apart = pair.vehicles->list[1].data->qvel[0] - pair.vehicles->list[0].data->qvel[0];
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
	(void)state;
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			const struct thing a = {shapes[i], 10}, b = {shapes[j], masses[(i + j) % 3]};
			struct pair pair = make(&a, &b, 0.002, 0.5);
			for (int k = 0; k < 9; k++) {
				const double angle = angles[k % 3] * M_PI / 180, speed = speeds[k / 3];
				double worst = 0, most = 0;
				bool touched = false;
				/* The second one comes from above, off the middle, and turns. */
				put(&pair, 0, (const double[]){0, 0, 0}, (const double[]){0, 0, 0, 0.1, 0.2, 0.3});
				put(&pair, 1, (const double[]){0.05 - 1.15 * tan(angle), 0.03, 1.15},
				    (const double[]){speed * sin(angle), 0, -speed * cos(angle), 0.5, -0.3, 0.2});
				const double start = energy(&pair);
				double first[3], momentum[3];
				find_momentum(&pair, &a, &b, first);
				for (double t = 0; t < 2.5 / speed && t < 6; t += 0.002) {
					const double share = step(&pair);
					check_friction(&pair, 0.5);
					touched = touched || share >= 0;
					worst = support_most(worst, share);
					most = support_most(most, energy(&pair));
				}
				met += touched;
				if (!(worst <= 1e-13))
					fail_msg("%s on %s: %g of the force has no counterforce", shapes[j], shapes[i], worst);
				if (!(most <= start * (1 + 1e-9)))
					fail_msg("%s on %s, %g m/s: %g J, and %g J before", shapes[j], shapes[i], speed, most, start);
				find_momentum(&pair, &a, &b, momentum);
				if (!(mju_dist3(momentum, first) <= 1e-12 * (a.mass + b.mass) * speed))
					fail_msg("%s on %s, %g m/s: %g N s of %g came or went", shapes[j], shapes[i], speed, mju_dist3(momentum, first),
						 mju_norm3(first));
			}
			forget(&pair);
		}
	print_message("%d of %d met\n", met, 6 * 6 * 9);
	assert_true(met > 200);
}

/* --- boxes --- */

static int boxes(const double way[3], const double turn_a[4], const double turn_b[4], struct touch *touches)
{
	static const double nowhere[3] = {0, 0, 0}, size[3] = {0.3, 0.3, 0.3};
	double mat[2][9];
	mju_quat2Mat(mat[0], turn_a);
	mju_quat2Mat(mat[1], turn_b);
	return vehicle_boxes_touch((const double *const[]){nowhere, way}, (const double *const[]){mat[0], mat[1]}, (const double *const[]){size, size}, 0,
				   touches);
}

static void boxes_touch_as_deep_as_they_are(void **state)
{
	static const double gaps[] = {-0.1, -1e-4, -1e-9}, none[4] = {1, 0, 0, 0};
	const double c = cos(M_PI / 8), s = sin(M_PI / 8), about_x[4] = {c, s, 0, 0}, about_y[4] = {c, 0, s, 0}, about_z[4] = {c, 0, 0, s};
	struct touch touches[TOUCHES_MOST];
	(void)state;
	for (int i = 0; i < 3; i++) {
		const double gap = gaps[i];
		/* Side by side, a little aside: four corners of what they share. */
		assert_int_equal(boxes((const double[]){0.6 + gap, 0.2, 0.1}, none, none, touches), 4);
		for (int k = 0; k < 4; k++) {
			assert_true(fabs(touches[k].gap - gap) < 1e-15 && fabs(touches[k].normal[0] - 1) < 1e-15);
			assert_true(fabs(touches[k].place[0] - 0.3 - gap / 2) < 1e-15);
			assert_true(fabs(fabs(touches[k].place[1] - 0.1) - 0.2) < 1e-15 && fabs(fabs(touches[k].place[2] - 0.05) - 0.25) < 1e-15);
		}
		/* An upright edge against a side: the edge's two ends. */
		assert_int_equal(boxes((const double[]){0.3 + 0.3 * M_SQRT2 + gap, 0, 0}, none, about_z, touches), 2);
		double deepest = 0;
		for (int k = 0; k < 2; k++)
			deepest = support_least(deepest, touches[k].gap);
		assert_true(fabs(touches[0].normal[0] - 1) < 1e-12);
		assert_true(fabs(deepest - gap) < 1e-12);
		/* Two edges across each other: one place. */
		assert_int_equal(boxes((const double[]){0.02, 0.03, 0.6 * M_SQRT2 + gap}, about_x, about_y, touches), 1);
		assert_true(fabs(touches[0].gap - gap) < 1e-12 && fabs(touches[0].normal[2] - 1) < 1e-12);
		assert_true(fabs(touches[0].place[0] - 0.02) < 1e-12 && fabs(touches[0].place[1]) < 1e-12);
		assert_true(fabs(touches[0].place[2] - 0.3 * M_SQRT2 - gap / 2) < 1e-12);
	}
	assert_int_equal(boxes((const double[]){0.6 + 1e-9, 0, 0}, none, none, touches), 0);
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
	/* A step needs room for the first contacts that it finds. */
	for (int v = 0; v < 2; v++)
		put(&pair, v, (const double[]){0.3 * v, 0, 0}, (const double[]){0, 0, 0, 0, 0, 0});
	for (uint64_t n = 1; n <= 2; n++) {
		mem_fail_nth(n, 0);
		assert_int_equal(vehicle_between_push(pair.vehicles), STATUS_FAILED);
		mem_fail_nth(0, 0);
	}
	must(vehicle_between_push(pair.vehicles));
	forget(&pair);
}

TEST_PROGRAM(between)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(head_on_they_part_as_the_law_says),
		cmocka_unit_test(stiff_bodies_do_not_spring_back),
		cmocka_unit_test(what_one_gets_the_other_loses),
		cmocka_unit_test(boxes_touch_as_deep_as_they_are),
		cmocka_unit_test(each_allocation_that_fails_is_told),
	};
	return cmocka_run_group_tests_name("vehicles that meet", tests, support_enter, support_leave);
}
