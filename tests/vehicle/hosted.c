/* A vehicle in a host's world: it drives as the command drives it, goes back to a checkpoint, takes the host's controls, and stands in its pictures. */
#include <math.h>

#include "../api/hosted.h"
#include "../comma.h"
#include "../support/near.h"
#include "../support/program.h"
#include "../support/skip.h"
#include "drive.h"

#include "api/library.h"
#include "vehicle/internal.h"

#define SIDE 32.0 /* m of ground that is compared, from its south-west corner */

static const struct extent extent = {129, 129, 0.25, 32};

static double ground(int64_t x, int64_t y)
{
	return 5 + 0.02 * sin(0.9 * (double)x) + 0.01 * (double)y;
}

/* Of one_wheel.xml, which starts at x, 10.5. `driver`: the line of the scene, or "". */
static void prepare_at(double x, const char *driver)
{
	char text[1024], path[512];
	snprintf(path, sizeof path, "%s/one_wheel.xml", getenv("MODELS"));
	char *model = support_text(path);
	support_write(support_path("model.xml"), model);
	free(model);
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\ntime_step: 0.002\nsoil: {name: dry_sand}\nspacing: 0.0625\nredistribute: {model: scm}\n"
				    "vehicles:\n  - name: cart\n    model: model.xml\n    start: {at: [%g, 10.5], yaw: 20}\n    soil: [wheel]\n%s"
				    "output: {forces: 20, vehicles: 50}\n", x, driver);
	support_write(support_path("scene.yaml"), text);
	support_store(support_path("ground.furrow"), extent, ground);
}

static void prepare(const char *driver)
{
	prepare_at(10, driver);
}

static struct furrow_world *opened(const char *overlay, const char *output)
{
	struct furrow_world *world = NULL;
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("ground.furrow"),
					 .overlay = overlay, .output = output};
	done(furrow_world_open(&open, &world));
	return world;
}

/* What a drive left: offsets of the ground, and their number of bytes. */
static double *offsets(const char *overlay, size_t *bytes)
{
	const uint32_t side = (uint32_t)(SIDE / 0.0625);
	const struct furrow_open open = {.size = sizeof open, .scene = "{spacing: 0.0625}", .store = support_path("ground.furrow"), .overlay = overlay};
	double *posts = calloc((size_t)side * side, sizeof *posts);
	struct furrow_world *world = NULL;
	assert_non_null(posts);
	done(furrow_world_open(&open, &world));
	done(furrow_read(world, FURROW_OFFSET, -2, 0, 0, side, side, posts, side));
	done(furrow_world_close(world));
	*bytes = (size_t)side * side * sizeof *posts;
	return posts;
}

static struct furrow_vehicle_state state_of(struct furrow_world *world)
{
	struct furrow_vehicle_state state = {.size = sizeof state};
	done(furrow_vehicle_get(world, 0, &state));
	return state;
}

/* What the record has of a vehicle. Its kinetic energy is found anew, and may be off by a rounding. */
static void assert_same_state(const struct furrow_vehicle_state *a, const struct furrow_vehicle_state *b)
{
	assert_memory_equal(a, b, offsetof(struct furrow_vehicle_state, kinetic));
	assert_true(a->work == b->work && fabs(a->kinetic - b->kinetic) <= 1e-12 * a->kinetic);
}

/* A step in which only the vehicles move. */
static void step_and_go_back(struct furrow_world *world)
{
	const struct furrow_vehicle_state before = state_of(world);
	must(vehicle_move(world->vehicles, 0, true));
	const struct furrow_vehicle_state moved = state_of(world);
	assert_memory_not_equal(&before, &moved, sizeof before);
	must(vehicle_step_back(world->vehicles));
	const struct furrow_vehicle_state back = state_of(world);
	assert_same_state(&before, &back);
}

/* Steps of one and of five time_steps, through a checkpoint and back and through steps that failed, leave what the command leaves. */
static void it_drives_as_the_command_drives_it(void **unused)
{
	const struct drive_cut cut = {.overlay = support_path("a.furrow"), .out = support_path("a")};
	const char *overlay = support_path("b.furrow"), *output = support_path("b");
	size_t bytes;
	prepare("    driver: {hold: {drive: 2}}\n");
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &cut, NULL), STATUS_OK);
	struct furrow_world *world = opened(overlay, output);
	for (int i = 0; i < 150; i++) {
		done(furrow_step(world, 0));
		if (i % 10 == 0)
			step_and_go_back(world);
	}
	done(furrow_checkpoint(world));
	const struct furrow_vehicle_state before = state_of(world);
	assert_true(before.distance > 0.05 && before.work > 0);
	for (int i = 0; i < 20; i++)
		done(furrow_step(world, 0.01));
	done(furrow_rollback(world));
	const struct furrow_vehicle_state back = state_of(world);
	assert_same_state(&before, &back);
	assert_true(fabs(furrow_time(world) - 0.3) < 1e-12);
	for (int i = 0; i < 70; i++)
		done(furrow_step(world, 0.01));
	assert_true(fabs(furrow_time(world) - 1) < 1e-12);
	done(furrow_world_close(world));
	double *here = offsets(overlay, &bytes), *there = offsets(cut.overlay, &bytes), deepest = 0;
	for (size_t i = 0; i < bytes / sizeof *here; i++)
		deepest = support_least(deepest, here[i]);
	assert_true(deepest < -0.01);
	assert_memory_equal(here, there, bytes);
	free(here);
	free(there);
	assert_same_rows(cut.out, output, 500);
}

/* The wheel drives off the terrain. What failed is undone, and all whole steps are kept, as by the command. */
static void a_failed_step_loses_nothing(void **unused)
{
	const struct drive_cut cut = {.overlay = support_path("f.furrow"), .out = support_path("f")};
	const char *overlay = support_path("g.furrow"), *output = support_path("g");
	char *json, path[512];
	size_t bytes;
	int whole = 0;
	prepare_at(31.6, "    driver: {hold: {drive: 3}}\n");
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &cut, &json), STATUS_FAILED);
	const long long steps = support_figure(json, "{", "steps");
	mem_free(json);
	struct furrow_world *world = opened(overlay, output);
	struct furrow_vehicle_state before = state_of(world);
	while (whole < 400 && furrow_step(world, 0) == FURROW_OK) {
		whole++;
		before = state_of(world);
	}
	assert_true(whole > 50 && whole == steps);
	assert_non_null(strstr(furrow_last_error(), "cart.wheel"));
	const struct furrow_vehicle_state after = state_of(world);
	assert_same_state(&before, &after);
	refused(FURROW_FAILED, furrow_step(world, 0));
	assert_true(fabs(furrow_time(world) - 0.002 * whole) < 1e-12);
	done(furrow_world_close(world));
	snprintf(path, sizeof path, "%s/run.json", output);
	json = support_text(path);
	assert_non_null(strstr(json, "\"failed\""));
	free(json);
	double *here = offsets(overlay, &bytes), *there = offsets(cut.overlay, &bytes);
	assert_memory_equal(here, there, bytes);
	free(here);
	free(there);
	assert_same_rows(cut.out, output, 500);
}

/* The time goes on with the vehicle. */
static void a_scenes_end_ends_nothing(void **unused)
{
	prepare("    driver: {hold: {drive: 2}}\n");
	struct furrow_world *world = opened(support_path("h.furrow"), NULL);
	for (int i = 1; i <= 510; i++)
		done(furrow_step(world, 0));
	const double before = state_of(world).distance;
	assert_true(furrow_time(world) == 510 * 0.002);
	done(furrow_step(world, 0.01));
	assert_true(furrow_time(world) == 515 * 0.002 && state_of(world).distance > before);
	done(furrow_world_close(world));
}

/* A host whose locale has a decimal comma leaves what the command leaves, also when it goes on from the middle. */
static void a_decimal_comma_changes_nothing(void **state)
{
	const struct drive_cut cut = {.overlay = support_path("point.furrow"), .out = support_path("point")};
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("ground.furrow"),
					 .overlay = support_path("comma.furrow"), .output = support_path("comma"), .resume = true};
	prepare("    driver: {controls: controls.csv}\n");
	support_write(support_path("controls.csv"), "t,drive\n0,0.5\n0.75,2.25\n");
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("ground.furrow"), NULL, &cut, NULL), STATUS_OK);
	if (!comma_begin(support_folder))
		skip_since("no locale with a decimal comma");
	for (int part = 0; part < 2; part++) {
		struct furrow_world *world = NULL;
		done(furrow_world_open(&open, &world));
		for (int i = 0; i < 250; i++)
			done(furrow_step(world, 0));
		done(furrow_world_close(world));
	}
	comma_end(state);
	assert_same_rows(cut.out, open.output, 500);
}

static void the_host_sets_controls(void **unused)
{
	furrow_vehicle cart;
	furrow_body wheel;
	double value, rate, control, force;
	struct furrow_contact contact;
	struct furrow_state at;
	prepare("");
	struct furrow_world *world = opened(support_path("c.furrow"), NULL);
	done(furrow_vehicle_find(world, "cart", &cart));
	done(furrow_body_find(world, "cart.wheel", &wheel));
	assert_string_equal(furrow_vehicle_part(world, cart, FURROW_ACTUATOR, 0), "drive");
	assert_string_equal(furrow_vehicle_part(world, cart, FURROW_JOINT, 3), "turn");
	assert_string_equal(furrow_vehicle_part(world, cart, FURROW_SOIL_GEOM, 0), "cart.wheel");
	assert_null(furrow_vehicle_part(world, cart, FURROW_SOIL_GEOM, 1));
	const struct furrow_vehicle_state first = state_of(world);
	assert_true(first.joints == 4 && first.actuators == 1 && first.soil_geoms == 1 && fabs(first.mass - 100) < 1e-9);
	for (int i = 0; i < 100; i++)
		done(furrow_step(world, 0));
	assert_true(state_of(world).distance < 0.01); /* nothing drives it */
	control = 2.5;
	done(furrow_set_controls(world, cart, 1, &control));
	for (int i = 0; i < 500; i++)
		done(furrow_step(world, 0));
	done(furrow_get_actuators(world, cart, 1, &control, &force));
	double values[4], rates[4];
	done(furrow_get_joints(world, cart, 4, values, rates));
	value = values[3], rate = rates[3];
	done(furrow_get_contacts(world, 1, &wheel, &contact, sizeof contact));
	done(furrow_get_states(world, 1, &wheel, &at));
	const struct furrow_vehicle_state moved = state_of(world);
	const double speed = hypot(moved.state.linear[0], moved.state.linear[1]);
	assert_true(control == 2.5 && force > 0 && rate > 2 && rate < 2.6 && value > 1);
	assert_true(contact.state == FURROW_TOUCHING && contact.sinkage > 0.005 && contact.time == furrow_time(world));
	assert_true(fabs(contact.force[2] - 100 * 9.81) < 0.1 * 981); /* it carries the weight */
	assert_true(fabs(contact.slip - (1 - speed / (rate * 0.32))) < 0.02);
	assert_true(fabs(at.pose.position[0] - moved.state.pose.position[0]) < 1e-6); /* the axle's */
	control = (double)NAN; /* the driver's again, and there is none */
	done(furrow_set_controls(world, cart, 1, &control));
	done(furrow_step(world, 0));
	done(furrow_get_actuators(world, cart, 1, &control, NULL));
	assert_true(control == 0);
	done(furrow_world_close(world));
}

static void what_cannot_be_is_refused(void **unused)
{
	furrow_vehicle none;
	furrow_body wheel;
	double controls[2] = {INFINITY, 0};
	struct furrow_vehicle_state state = {.size = 0};
	prepare("");
	struct furrow_world *world = opened(support_path("d.furrow"), NULL);
	done(furrow_body_find(world, "cart.wheel", &wheel));
	const struct furrow_pose pose = {{5, 5, 6}, {1, 0, 0, 0}};
	const struct furrow_state to = {.pose = pose};
	const struct furrow_belt belt = {0, 0};
	misused(furrow_place(world, wheel, &pose));
	misused(furrow_set_states(world, 1, &wheel, &to));
	misused(furrow_set_belts(world, 1, &wheel, &belt));
	misused(furrow_body_remove(world, wheel));
	misused(furrow_step(world, 0.003));
	misused(furrow_step(world, 0.0005));
	misused(furrow_set_controls(world, 0, 2, controls));
	misused(furrow_set_controls(world, 0, 1, controls));
	misused(furrow_set_controls(world, 0, 1, NULL));
	misused(furrow_set_controls(world, 1, 1, controls + 1));
	misused(furrow_get_joints(world, 0, 3, controls, NULL));
	misused(furrow_vehicle_get(world, -1, &state));
	misused(furrow_vehicle_get(world, 0, &state));
	state.size = SIZE_MAX;
	misused(furrow_vehicle_get(world, 0, &state));
	refused(FURROW_INPUT, furrow_vehicle_find(world, "horse", &none));
	assert_int_equal(none, -1);
	assert_null(furrow_vehicle_part(world, 3, FURROW_JOINT, 0));
	done(furrow_step(world, 0)); /* and none of this changed anything */
	done(furrow_world_close(world));
}

static double deepest(struct furrow_world *world)
{
	static double posts[96 * 96];
	double least = 0;
	done(furrow_read(world, FURROW_OFFSET, -2, 100, 100, 96, 96, posts, 96));
	for (size_t i = 0; i < sizeof posts / sizeof *posts; i++)
		least = fmin(least, posts[i]);
	return least;
}

/* Where it was set down there is a print, in memory alone until the first step. A rollback to the opening returns to it, also after steps. */
static void a_vehicle_that_is_not_stepped_changes_no_file(void **unused)
{
	const char *store = support_path("ground.furrow");
	struct furrow_world *world = NULL;
	struct furrow_camera camera = {sizeof camera, {{10, 4, 8}, {0.7071067811865476, 0, 0, 0.7071067811865476}}, 1, 64, 48};
	uint8_t rgb[64 * 48 * 3];
	prepare("");
	char *before = support_text(store), *after;
	for (int readonly = 0; readonly < 2; readonly++) {
		const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = store, .readonly = readonly != 0};
		done(furrow_world_open(&open, &world));
		assert_true(deepest(world) < -0.005);
		done(furrow_render(world, &camera, rgb, NULL));
		done(furrow_rollback(world));
		assert_true(deepest(world) < -0.005);
		if (readonly)
			misused(furrow_step(world, 0));
		done(furrow_world_close(world));
		after = support_text(store);
		assert_memory_equal(before, after, 1 << 22);
		free(after);
	}
	free(before);
	world = opened(NULL, NULL);
	const double print = deepest(world);
	const struct furrow_vehicle_state began = state_of(world);
	for (int i = 0; i < 5; i++)
		done(furrow_step(world, 0));
	done(furrow_rollback(world));
	const struct furrow_vehicle_state back = state_of(world);
	assert_same_state(&began, &back);
	assert_true(deepest(world) == print);
	done(furrow_world_close(world));
	const struct furrow_open look = {.size = sizeof look, .scene = "{spacing: 0.0625}", .store = store, .readonly = true};
	done(furrow_world_open(&look, &world));
	assert_true(deepest(world) == print);
	done(furrow_world_close(world));
}

/* A camera 3 m beside the axle's middle sees the wheel's side, which is 0.12 m nearer but for what its hub lies back. */
static void it_stands_in_pictures(void **unused)
{
	float depth[15 * 15];
	prepare("");
	struct furrow_world *world = opened(support_path("e.furrow"), NULL);
	const struct furrow_vehicle_state state = state_of(world);
	const double *p = state.state.pose.position, yaw = 20 * M_PI / 180, toward = (yaw + M_PI / 2) / 2;
	const struct furrow_camera camera = {
		.size = sizeof camera,
		.pose = {{p[0] + 3 * sin(yaw), p[1] - 3 * cos(yaw), p[2] + 0.05}, {cos(toward), 0, 0, sin(toward)}},
		.fovy = 0.2, .width = 15, .height = 15};
	done(furrow_render(world, &camera, NULL, depth));
	assert_true(fabs(depth[7 * 15 + 7] - 2.9) < 0.05);
	done(furrow_world_close(world));
}

/* Soil is poured beside a vehicle, and not below its wheel. A rollback takes the later pour back, and the vehicle's way with it. */
static void soil_is_poured_beside_it(void **unused)
{
	static double slab[17][17];
	const double at[2] = {16.5, 4.5};
	struct furrow_point point;
	for (int i = 0; i < 17 * 17; i++)
		slab[i / 17][i % 17] = 0.1;
	prepare("");
	struct furrow_world *world = opened(support_path("poured.furrow"), NULL);
	const struct furrow_vehicle_state began = state_of(world);
	const double *p = began.state.pose.position;
	const int64_t column = lround(p[0] / 0.0625) - 8, row = lround(p[1] / 0.0625) - 8;
	refused(FURROW_INPUT, furrow_pour(world, column, row, 17, 17, &slab[0][0], 17, -1, false));
	assert_non_null(strstr(furrow_last_error(), "cart.wheel"));
	done(furrow_pour(world, 256, 64, 17, 17, &slab[0][0], 17, -1, false));
	for (int i = 0; i < 10; i++)
		done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	const struct furrow_vehicle_state before = state_of(world);
	for (int way = 0; way < 2; way++) {
		done(furrow_pour(world, 256, 64, 17, 17, &slab[0][0], 17, -1, true));
		for (int i = 0; i < 10; i++)
			done(furrow_step(world, 0));
		done(furrow_points(world, 1, at, &point));
		assert_near(point.offset, 0.2, 1e-4);
		done(furrow_rollback(world));
		const struct furrow_vehicle_state back = state_of(world);
		assert_same_state(&before, &back);
		done(furrow_points(world, 1, at, &point));
		assert_near(point.offset, 0.1, 1e-4);
	}
	done(furrow_world_close(world));
	struct store *store;
	struct store_check check;
	assert_int_equal(store_open(support_path("poured.furrow"), &(struct store_options){.mode = STORE_READ}, &store), STATUS_OK);
	assert_int_equal(store_verify(store, NULL, NULL, NULL, &check), STATUS_OK);
	assert_int_equal(check.added, 17 * 17 * lround(0.1 * 0x1p20));
	assert_int_equal(check.offset_sum[-2 - TILE_LEVEL_MIN] + check.compacted, check.added);
	store_close(store);
}

/* A time_step that is too long for the soil is divided: to a host and to the command it is still one step, with the bits of a scene that gives
 * the part. */
static void a_step_that_is_divided_is_one_step(void **state)
{
	double steps[2] = {0.014, 0};
	struct furrow_vehicle_state ends[2];
	(void)state;
	for (int i = 0; i < 2; i++) {
		char *text, overlay[32];
		prepare("");
		text = support_text(support_path("scene.yaml"));
		char *at = strstr(text, "time_step: 0.002"), changed[1200];
		assert_non_null(at);
		snprintf(changed, sizeof changed, "%.*stime_step: %.17g%s", (int)(at - text), text, steps[i], at + strlen("time_step: 0.002"));
		free(text);
		support_write(support_path("scene.yaml"), changed);
		snprintf(overlay, sizeof overlay, "divided%d.furrow", i);
		struct furrow_world *world = opened(support_path(overlay), NULL);
		const double part = world_scene(world->world)->time_step;
		steps[1] = part;
		assert_true(i == 1 || part < steps[0]);
		const double parts = round(steps[0] / part);
		for (int step = 0; step < 5; step++) {
			if (i == 0)
				done(furrow_step(world, step < 3 ? 0 : steps[0]));
			for (double k = 0; i == 1 && k < parts; k++)
				done(furrow_step(world, 0));
			assert_true(fabs(world_time(world->world) - (step + 1) * steps[0]) < 1e-12);
		}
		ends[i] = state_of(world);
		done(furrow_world_close(world));
	}
	assert_same_state(&ends[0], &ends[1]);
	assert_true(ends[0].distance > 0);
}

TEST_PROGRAM(hosted)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_step_that_is_divided_is_one_step),
		cmocka_unit_test(it_drives_as_the_command_drives_it),
		cmocka_unit_test(a_failed_step_loses_nothing),
		cmocka_unit_test(a_scenes_end_ends_nothing),
		cmocka_unit_test_teardown(a_decimal_comma_changes_nothing, comma_end),
		cmocka_unit_test(the_host_sets_controls),
		cmocka_unit_test(what_cannot_be_is_refused),
		cmocka_unit_test(a_vehicle_that_is_not_stepped_changes_no_file),
		cmocka_unit_test(it_stands_in_pictures),
		cmocka_unit_test(soil_is_poured_beside_it),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
