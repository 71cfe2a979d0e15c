/*
 * The powertrain beside closed forms: on a stand with wheels in the air, where only inertia resists, and with wheels that a brake or the ground holds.
 */
#include "train.h"
#include "../support/program.h"

#define TORQUE 200.0
#define ENGINE 0.3 /* kg m2 */
#define FLAT "engine: [[500, 200], [6000, 200]], inertia: 0.3, "

/* All four wheels in the air: T i / (4 I_w + i2 I_e) in each gear. */
static void wheels_in_the_air_take_the_engine_s_torque(void **state)
{
	(void)state;
	static const double ratios[] = {14, 7, 3.5};
	slope = 0;
	write_model(0.3, 1000, "");
	for (int step = 0; step < 2; step++) {
		struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [4, 2, 1], final: 3.5, shift_time: 0}", step == 0 ? STEP : 0.005, 0, "dry_sand");
		for (int gear = 1; gear <= 3; gear++) {
			control(world, 0, 0, gear);
			go(world, 2);
			control(world, 1, 0, gear);
			go(world, 0.3);
			const double ratio = ratios[gear - 1], from = turns(world, 0), engine = train_of(world)->speed;
			go(world, 0.1);
			const double is = (turns(world, 0) - from) / 0.1, should = TORQUE * ratio / (4 * WHEEL_INERTIA + ratio * ratio * ENGINE);
			print_message("gear %d: %.4f rad/s2, closed form %.4f; engine %.1f to %.1f rad/s; torque %.2f\n", gear, is, should, engine, train_of(world)->speed, train_of(world)->torque);
			assert_near(is, should, 0.0001 * should);
			assert_near(train_of(world)->speed, ratio * turns(world, 0), 1e-6 * train_of(world)->speed);
			for (size_t i = 1; i < 4; i++)
				assert_near(turns(world, i), turns(world, 0), 1e-9);
		}
		done(furrow_world_close(world));
	}
}

static void damp(double fl, double fr, double rl, double rr)
{
	const double all[4] = {fl, fr, rl, rr};
	memcpy(damping, all, sizeof damping);
	write_model(0.3, 1000, "");
	memset(damping, 0, sizeof damping);
}

/* What the parts have taken: the engine's work is its own kinetic energy, the wheels' work and losses. `idle`: J of its kinetic energy at the start. */
static void assert_work(struct furrow_world *world)
{
	const struct powertrain *train = train_of(world);
	const double idle = train->scene->inertia * pow(train->scene->idle * RPM, 2) / 2, kinetic = train->scene->inertia * train->speed * train->speed / 2;
	const double wheels = vehicle_of(world)->work;
	print_message("engine %.6g J: %.6g in its own turn, %.6g at the wheels, %.6g lost, %.6g in brakes\n", train->engine_work, kinetic - idle, wheels, train->loss, train->brake_work);
	assert_near(train->engine_work, kinetic - idle + wheels + train->loss, 1e-6 * (fabs(train->engine_work) + 1));
	assert_true(train->loss >= -1e-6 && train->brake_work >= -1e-6);
}

#define DRIVES "gears: [4], final: 3, shift_time: 0, "

/* Steady turns against dampers: the engine runs at its limit, where its torque is what the wheels take. */
static void differentials_share_the_torque(void **state)
{
	(void)state;
	slope = 0;
	damp(20, 1, 8, 8);
	/* open: each wheel has the same torque, so that on both sides which the free one takes */
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "drag: 1}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	for (size_t i = 0; i < 4; i++) {
		static const double dampers[] = {20, 1, 8, 8};
		assert_near(pulls(world, i), pulls(world, 1), 1e-9 * pulls(world, 1));
		assert_near(pulls(world, i), dampers[i] * turns(world, i), 2e-3 * pulls(world, 1));
	}
	assert_near(12 * (turns(world, 0) + turns(world, 1) + turns(world, 2) + turns(world, 3)) / 4, train_of(world)->speed, 1e-6 * train_of(world)->speed);
	assert_work(world);
	done(furrow_world_close(world));
	/* locked: all turn alike, and each gets what it takes */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {centre: locked, front: locked, rear: locked}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	for (size_t i = 0; i < 4; i++)
		assert_near(turns(world, i), turns(world, 0), 1e-6 * turns(world, 0));
	assert_near(pulls(world, 0) / pulls(world, 1), 20, 0.01);
	assert_work(world);
	done(furrow_world_close(world));
	/* limited: the torques of the front wheels are in the ratio of its bias */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {front: limited, bias: 3}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	print_message("bias: %.5f and %.5f N m, %.4f and %.4f rad/s\n", pulls(world, 0), pulls(world, 1), turns(world, 0), turns(world, 1));
	assert_near(pulls(world, 0), 3 * pulls(world, 1), 0.001 * pulls(world, 0));
	assert_near(pulls(world, 0) + pulls(world, 1), pulls(world, 2) + pulls(world, 3), 1e-6 * pulls(world, 0));
	assert_true(turns(world, 1) > 1.1 * turns(world, 0));
	assert_work(world);
	done(furrow_world_close(world));
	/* a lock's own torque: the difference is twice of it */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {front: limited, bias: 1, lock: 30}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	assert_near(pulls(world, 0) - pulls(world, 1), 60, 0.001);
	done(furrow_world_close(world));
}

/* A map that falls with speed meets dampers: both are lines. */
static void top_speed_is_where_both_torques_meet(void **state)
{
	(void)state;
	slope = 0;
	damp(2, 2, 2, 2);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], engine: [[500, 220], [6000, 0]], inertia: 0.3, gears: [10], shift_time: 0}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	/* 220 (6000 - n) / 5500 10 = 8 w, n = 10 w / RPM */
	const double fall = 220.0 / 5500 * 10, should = fall * 6000 / (8 + fall * 10 / RPM);
	print_message("%.5f rad/s, closed form %.5f\n", turns(world, 0), should);
	assert_near(turns(world, 0), should, 0.0001 * should);
	/* Half of the throttle: half of the torque, without drag. */
	control(world, 0.5, 0, 1);
	go(world, 10);
	const double half = fall / 2 * 6000 / (8 + fall / 2 * 10 / RPM);
	assert_near(turns(world, 0), half, 0.0001 * half);
	assert_work(world);
	done(furrow_world_close(world));
}

/* With closed throttle the engine's drag slows the wheels by drag i / (4 I_w + i2 I_e), until it idles. */
static void the_engine_brakes_and_idles(void **state)
{
	(void)state;
	slope = 0;
	damp(0, 0, 0, 0);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [10], drag: 40, shift_time: 0}", STEP, 0, "dry_sand");
	go(world, 1);
	assert_near(train_of(world)->speed / RPM, 500, 0.01);
	control(world, 1, 0, 1);
	go(world, 1.5);
	control(world, 0, 0, 1);
	go(world, 0.02);
	const double from = turns(world, 0);
	go(world, 0.2);
	const double is = (turns(world, 0) - from) / 0.2, should = -40 * 10 / (4 * WHEEL_INERTIA + 100 * ENGINE);
	print_message("engine brakes by %.4f rad/s2, closed form %.4f\n", is, should);
	assert_near(is, should, 0.0001 * -should);
	go(world, 10);
	assert_near(train_of(world)->speed / RPM, 500, 0.5);
	assert_work(world);
	/* Neutral and full throttle: it stays at its limit. */
	control(world, 1, 0, 0);
	go(world, 3);
	assert_true(train_of(world)->speed / RPM > 6000 && train_of(world)->speed / RPM < 6120);
	assert_int_equal((int)train_of(world)->gear, 0);
	/* Reverse: the wheels turn backward. */
	control(world, 0.3, 0, -1);
	go(world, 3);
	assert_true(turns(world, 0) < -5);
	assert_near(turns(world, 0) * -10, train_of(world)->speed, 1e-6 * train_of(world)->speed);
	done(furrow_world_close(world));
}

/* Gears come in at the speeds that the scene gives, up and down. */
static void it_shifts_at_its_speeds(void **state)
{
	(void)state;
	static const double ratios[] = {4, 2, 1};
	slope = 0;
	damp(0.1, 0.1, 0.1, 0.1);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [4, 2, 1], final: 3, shift: [1500, 3500], shift_time: 0.2}", STEP, 0, "dry_sand");
	int last = 1;
	double began = -1;
	for (int phase = 0; phase < 2; phase++) {
		control(world, 1 - phase, phase == 0 ? 0 : (double)NAN, 3);
		for (int i = 0; i < 40000 && (phase == 0 ? last < 3 || began >= 0 : last > 1 || began >= 0); i++) {
			const double rpm = 3 * ratios[last - 1] * turns(world, 0) / RPM;
			done(furrow_step(world, 0));
			const struct powertrain *train = train_of(world);
			if ((int)train->gear != last) {
				print_message("from gear %d to %d at %.1f rpm\n", last, (int)train->gear, rpm);
				assert_int_equal((int)train->gear, last + (phase == 0 ? 1 : -1));
				assert_true(phase == 0 ? rpm > 3500 && rpm < 3530 : rpm < 1500 && rpm > 1470);
				last = (int)train->gear;
				began = furrow_time(world);
			}
			if (began >= 0 && train->shifting == 0) {
				assert_near(furrow_time(world) - began, 0.2, 2 * STEP);
				began = -1;
			} else if (began >= 0) {
				assert_true(pulls(world, 0) == 0); /* the clutch is open */
			}
		}
		assert_int_equal(last, phase == 0 ? 3 : 1);
	}
	assert_work(world);
	done(furrow_world_close(world));
}

/* Brakes hold the wheels: the engine turns where its torque is C w2, and the wheels get that, times the ratios of the converter and the gear. */
static void a_converter_multiplies_at_stall(void **state)
{
	(void)state;
	slope = 0;
	damp(0, 0, 0, 0);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [10], shift_time: 0, converter: {capacity: 0.005, ratio: 2.2, coupling: 0.8}}, brakes: 5000", STEP, 0,
						"dry_sand");
	control(world, 1, 1, 1);
	go(world, 3);
	double sum = 0;
	for (size_t i = 0; i < 4; i++) {
		assert_near(turns(world, i), 0, 1e-9);
		sum += pulls(world, i);
		assert_near(train_of(world)->wheels[i].brake, -pulls(world, i), 1e-6 * pulls(world, i));
	}
	assert_near(train_of(world)->speed, sqrt(TORQUE / 0.005), 0.0001 * train_of(world)->speed);
	assert_near(sum, 10 * 2.2 * TORQUE, 0.0001 * sum);
	/* All is heat: what the engine gives, and the brakes take nothing. */
	const double work = train_of(world)->engine_work, loss = train_of(world)->loss;
	go(world, 1);
	assert_near(train_of(world)->loss - loss, train_of(world)->engine_work - work, 1e-6 * work);
	assert_near(train_of(world)->brake_work, 0, 0.001);
	assert_work(world);
	done(furrow_world_close(world));
}

#define TRUCK "powertrain: {wheels: [turn_*], engine: [[800, 120], [4000, 120]], inertia: 0.3, drag: 10, gears: [4, 2, 1], reverse: 4, final: 4, shift: [1200, 3000], shift_time: 0.1, " \
	"differentials: {centre: locked, front: limited, rear: locked}}, brakes: 1000"

/* What a vehicle does after a checkpoint, and again after the way back to it, is the same to the bit. */
static void it_goes_back_to_a_checkpoint(void **state)
{
	(void)state;
	double ends[2][5];
	slope = 0;
	damp(0, 0, 0, 0);
	write_model(0, 1000, "");
	struct furrow_world *world = open_train(TRUCK, 0.004, 20, "dry_sand");
	control(world, 1, 0, 3);
	go(world, 0.6);
	control(world, 0.2, 0.3, 3);
	go(world, 0.1);
	done(furrow_checkpoint(world));
	for (int turn = 0; turn < 2; turn++) {
		control(world, 0, 1, 3); /* they come to rest, and are held */
		go(world, 1);
		control(world, 1, 0, 3);
		go(world, 0.4);
		const struct powertrain *train = train_of(world);
		const double end[5] = {train->speed, train->engine_work, train->loss, train->brake_work, vehicle_of(world)->data->qvel[0]};
		memcpy(ends[turn], end, sizeof end);
		print_message("%.17g rad/s, %.17g J, %.17g J, %.17g J, %.17g m/s\n", end[0], end[1], end[2], end[3], end[4]);
		if (turn == 0)
			done(furrow_rollback(world));
	}
	assert_memory_equal(ends[0], ends[1], sizeof ends[0]);
	assert_true(train_of(world)->brake_work > 100 && train_of(world)->engine_work > 100);
	assert_work(world);
	done(furrow_world_close(world));
}

/* Locks, brakes and low gears with a light wheel are stiff; a step of 5 ms is stable with all of them. */
static void stiff_drivelines_are_stable(void **state)
{
	(void)state;
	slope = 0.1;
	write_model(0, 1000, "");
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], engine: [[800, 60], [4000, 60]], inertia: 1, gears: [12, 1], reverse: 12, final: 5, shift_time: 0, "
						"differentials: {centre: locked, front: locked, rear: locked}}, brakes: 3000", 0.005, 0, "dry_sand");
	double fastest = 0;
	static const double controls[][3] = {{1, 0, 1}, {1, 1, 1}, {0, 0, 1}, {1, 0, -1}, {1, 0.5, 2}, {0, 1, 0}};
	for (size_t i = 0; i < sizeof controls / sizeof controls[0]; i++) {
		control(world, controls[i][0], controls[i][1], controls[i][2]);
		for (int step = 0; step < 120; step++) {
			done(furrow_step(world, 0));
			for (size_t k = 0; k < 4; k++)
				fastest = support_most(fastest, fabs(turns(world, k)));
			if (controls[i][2] != 0)
				for (size_t k = 1; k < 4; k++)
					assert_near(turns(world, k), turns(world, 0), 0.001);
		}
	}
	print_message("no wheel turned faster than %.3f rad/s\n", fastest);
	assert_true(fastest < 4000 * RPM / 5 * 1.05);
	assert_work(world);
	done(furrow_world_close(world));
}

/* The weight's share along the slope, with as much again for rolling in sand and more, is what it climbs with; half of it does not do. */
static void it_climbs_as_steep_as_its_torque(void **state)
{
	(void)state;
	slope = tan(8 * M_PI / 180);
	write_model(0, 1000, "");
	const double needs = (1000 + 4 * WHEEL_MASS) * 9.81 * sin(atan(slope)) * RADIUS;
	for (int climbs = 0; climbs < 2; climbs++) {
		char keys[512];
		snprintf(keys, sizeof keys, "powertrain: {wheels: [turn_*], engine: [[500, %g], [5000, %g]], inertia: 0.1, gears: [10], shift_time: 0, "
					    "differentials: {centre: locked}}", needs / 10 * (climbs ? 3.2 : 0.6), needs / 10 * (climbs ? 3.2 : 0.6));
		struct furrow_world *world = open_train(keys, STEP, 0, "dry_sand");
		const double from = vehicle_of(world)->data->qpos[0];
		control(world, 1, 0, 1);
		go(world, 2.5);
		const double way = vehicle_of(world)->data->qpos[0] - from;
		print_message("%.1f of the torque of the weight: %.3f m up\n", climbs ? 3.2 : 0.6, way);
		assert_true(climbs ? way > 0.3 : way < 0);
		assert_work(world);
		done(furrow_world_close(world));
	}
}

/* On a path with a speed below 0 the lever is in reverse. */
static void it_drives_backward_along_a_path(void **state)
{
	(void)state;
	slope = 0;
	write_model(0, 1000, "");
	struct furrow_world *world = open_train(TRUCK ", driver: {path: {points: [[12, 12], [9, 12]], speed: -1}, drive: [turn_*]}", 0.004, 0, "dry_sand");
	const double from = vehicle_of(world)->data->qpos[0];
	go(world, 2);
	assert_int_equal((int)train_of(world)->gear, -1);
	go(world, 4);
	const double way = vehicle_of(world)->data->qpos[0] - from;
	print_message("%.3f m, %.4f m/s\n", way, vehicle_of(world)->data->qvel[0]);
	assert_near(way, -3, 0.2);
	assert_work(world);
	done(furrow_world_close(world));
}

/* A keyframe has numbers for the actuators that the powertrain takes away; those behind them keep their own. */
static void a_keyframe_keeps_the_other_actuators(void **state)
{
	static const char more[] = "<actuator><intvelocity name=\"fl\" joint=\"turn_fl\" kp=\"10\"/><pid name=\"fr\" joint=\"turn_fr\" input=\"pos vel\" kp=\"1\" kv=\"1\"/>"
				   "<intvelocity name=\"lift\" joint=\"lift\" kp=\"10\"/></actuator>"
				   "<keyframe><key name=\"up\" qpos=\"0 0 0.3 1 0 0 0 0 0 0 0 0.2\" act=\"1 0.25\" ctrl=\"3 4 5 0.5\"/></keyframe>";
	char text[4096], *hinge;
	(void)state;
	slope = 0;
	write_model(0, 1000, more);
	char *model = support_text(support_path("model.xml"));
	hinge = strstr(model, "</worldbody>") - strlen("</body>");
	snprintf(text, sizeof text, "%.*s<body pos=\"0 0 0.5\"><joint name=\"lift\" type=\"slide\" axis=\"0 0 1\"/><geom type=\"box\" size=\"0.1 0.1 0.1\" mass=\"1\"/></body>%s", (int)(hinge - model),
		 model, hinge);
	free(model);
	support_write(support_path("model.xml"), text);
	support_write(support_path("scene.yaml"), "scene: 1\nend_time: 1\ntime_step: 0.002\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
						  "  - {name: v, model: model.xml, start: {at: [12, 12], keyframe: up}, powertrain: {wheels: [turn_*], " FLAT "gears: [4]}}\n");
	struct scene *scene;
	struct vehicles *vehicles;
	must(scene_load(support_path("scene.yaml"), NULL, 0, &scene));
	must(vehicle_load(scene, &vehicles));
	const struct vehicle *car = &vehicles->list[0];
	const int lift = vehicle_find_part(car, mjOBJ_ACTUATOR, "lift");
	assert_int_equal(range_count(car->own.actuator), 5);
	assert_true(car->model->key_ctrl[car->keyframe * car->model->nu + car->model->actuator_ctrladr[lift]] == 0.5);
	assert_true(car->data->act[car->model->actuator_actadr[lift]] == 0.25);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

/* The same vehicle, whichever way its model looks: full throttle goes forward, and the lock of the front axle holds its wheels alike, while the open rear one has a damper on its left. */
static void other_axes_drive_alike(void **state)
{
	static const char *const forwards[] = {"+x", "+y", "-x", "-y"};
	double first[2] = {0, 0};
	(void)state;
	slope = 0;
	for (int i = 0; i < 4; i++) {
		char keys[256];
		looks = 90 * i;
		damping[2] = 4;
		write_model(0, 1000, "");
		damping[2] = 0;
		snprintf(keys, sizeof keys, "forward: %s, powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {front: locked}}", forwards[i]);
		struct furrow_world *world = open_train(keys, STEP, 0, "clayey_38");
		const double *at = vehicle_of(world)->data->xpos + 3 * vehicle_of(world)->root, from[2] = {at[0], at[1]};
		control(world, 1, 0, 1);
		go(world, 2);
		const double way[2] = {at[0] - from[0], at[1] - from[1]};
		print_message("forward: %s: %.5f m east, %.5f m north; wheels %.4f, %.4f, %.4f, %.4f rad/s\n", forwards[i], way[0], way[1], turns(world, 0), turns(world, 1), turns(world, 2), turns(world, 3));
		if (i == 0)
			memcpy(first, way, sizeof first);
		assert_true(way[0] > 2);
		assert_near(way[0], first[0], 0.01 * first[0]);
		assert_near(way[1], first[1], 0.01 * first[0]);
		assert_near(turns(world, 0), turns(world, 1), 1e-6 * turns(world, 0));
		assert_true(fabs(turns(world, 2) - turns(world, 3)) > 5);
		done(furrow_world_close(world));
	}
	looks = 0;
}

TEST_PROGRAM(powertrain)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wheels_in_the_air_take_the_engine_s_torque),
		cmocka_unit_test(differentials_share_the_torque),
		cmocka_unit_test(top_speed_is_where_both_torques_meet),
		cmocka_unit_test(the_engine_brakes_and_idles),
		cmocka_unit_test(it_shifts_at_its_speeds),
		cmocka_unit_test(a_converter_multiplies_at_stall),
		cmocka_unit_test(it_goes_back_to_a_checkpoint),
		cmocka_unit_test(stiff_drivelines_are_stable),
		cmocka_unit_test(it_climbs_as_steep_as_its_torque),
		cmocka_unit_test(it_drives_backward_along_a_path),
		cmocka_unit_test(a_keyframe_keeps_the_other_actuators),
		cmocka_unit_test(other_axes_drive_alike),
	};
	return cmocka_run_group_tests_name("the powertrain beside closed forms", tests, support_enter, support_leave);
}
