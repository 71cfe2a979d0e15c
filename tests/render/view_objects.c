/* Where objects are drawn: as they pressed at a station, and evenly on from there to the next. */
#include "../support/near.h"
#include "view_rig.h"

#include "render/objects.h"
#include "../support/program.h"

/* The rig's object is of another shape, and its way another, or one in time; the picture shows it. */
static void show(struct rig *rig, struct soil_shape shape, struct scene_path path)
{
	rig->object.shape = shape;
	rig->object.path = path;
	motion_track_destroy(rig->body.track);
	must(motion_track_create(&rig->object.path, extent.spacing, shape.radius, &rig->body.track));
	rig->scene.view.effects = EFFECT_BIT(EFFECT_OBJECTS);
	render_view_destroy(rig->view);
	rig->view = NULL;
	must(render_view_create(rig->world, false, &rig->view));
}

static size_t shown(struct rig *rig, double time, struct render_object *out)
{
	const struct render_objects *objects = rig->view->render->objects;
	rig_at(rig, time);
	must(render_view_set_objects(rig->view));
	if (objects->shown_count > 0)
		*out = objects->shown[0];
	return objects->shown_count;
}

/* As the station's sweep leaves it. */
static void press(struct rig *rig, int64_t sample, double turn)
{
	struct event event = {.body = 0};
	must(world_made_set_down(rig->world, &rig->body, sample, &event));
	assert_true(event.contact);
	rig->body.last = event.pose;
	rig->body.last.turn = turn;
	rig->body.has_last = true;
	rig->body.next = sample + 1;
	rig->body.distance += event.distance;
}

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 11, .grouser_height = 0.05, .grouser_thickness = 0.05};

static void a_wheel_rolls_on_from_its_last_station_to_the_next(void **state)
{
	struct rig rig;
	struct render_object now = {0}, then = {0};
	rig_open(&rig, 64, 2, 0);
	rig.object.slip = 0.2;
	rig.object.sink = 0.1;
	show(&rig, wheel, (struct scene_path){.points = rig.points, .count = 2, .speed = 2});
	for (int64_t k = 3; k < 40; k += 7) {
		double time = motion_track_sample_time(rig.body.track, k), next = motion_track_sample_time(rig.body.track, k + 1);
		double step = 1 / (0.5 * (1 - 0.2)); /* a post's way */
		press(&rig, k, 0.7);
		struct soil_pose last = rig.body.last;
		assert_int_equal(shown(&rig, time, &now), 1);
		assert_near(now.at[0], lattice_offset_metres(last.x), 1e-5);
		assert_near(now.at[1], lattice_offset_metres(last.y), 1e-5);
		assert_near(now.at[2], lattice_offset_metres(last.z), 1e-5);
		assert_near(now.yaw, last.yaw, 1e-9);
		assert_near(now.turned, 0.7, 1e-5);
		assert_int_equal(shown(&rig, time + 0.25 * (next - time), &then), 1);
		assert_near(then.turned, 0.7 + 0.25 * step, 1e-5);
		assert_near(hypot(then.at[0] - now.at[0], then.at[1] - now.at[1]), 0.25, 1e-5);
		/* Just before the next station it is where that will press. */
		assert_int_equal(shown(&rig, next - 1e-9, &then), 1);
		press(&rig, k + 1, 0.7 + step);
		assert_int_equal(shown(&rig, next, &now), 1);
		for (int i = 0; i < 3; i++)
			assert_near(then.at[i], now.at[i], 1e-5);
		assert_near(then.turned, now.turned, 1e-5);
	}
	/* A load stands as much higher than it was looked for as it was found to. */
	rig.body.raised = lattice_offset(0.05);
	then = now;
	shown(&rig, rig.made.time, &now);
	assert_near(now.at[2], then.at[2] + 0.05, 1e-5);
	rig_close(&rig);
}

static void a_ball_rolls_by_its_way(void **state)
{
	struct rig rig;
	struct render_object now = {0};
	rig_open(&rig, 64, 2, 0);
	show(&rig, (struct soil_shape){.kind = SOIL_SPHERE, .radius = 2}, (struct scene_path){.points = rig.points, .count = 2, .speed = 2});
	press(&rig, 0, 0);
	for (int64_t k = 1; k < 4; k++)
		press(&rig, k, 0);
	assert_int_equal(shown(&rig, motion_track_sample_time(rig.body.track, 3) + 0.2, &now), 1);
	assert_near(now.turned, (3 + 0.4) / 2, 1e-5);
	rig_close(&rig);
}

static void where_there_is_no_ground_it_is_drawn_if_that_is_known(void **state)
{
	struct rig rig;
	struct render_object now = {0}, last = {0};
	/* Off the terrain's east side after 5 s. */
	struct scene_waypoint out[2] = {{.x = 502, .y = 100}, {.x = 552, .y = 100}};
	rig_open(&rig, 64, 2, 0);
	show(&rig, wheel, (struct scene_path){.points = out, .count = 2, .speed = 2});
	assert_int_equal(shown(&rig, 6, &now), 0); /* it never was on any */
	press(&rig, 10, 0);
	assert_int_equal(shown(&rig, 5, &last), 1);
	rig.body.has_last = false;
	rig.body.distance = 10;
	assert_int_equal(shown(&rig, 6, &now), 1);
	assert_near(now.at[0], 514, 1e-5);
	assert_near(now.at[2], last.at[2], 1e-5);
	/* A path that says where it is in time, and how it lies; before it begins it is nowhere. */
	struct scene_waypoint timed[2] = {{.t = 2, .x = 520, .y = 100, .z = 7, .roll = 0.5}, {.t = 4, .x = 530, .y = 100, .z = 9, .roll = 0.7}};
	rig.body.has_last = false;
	show(&rig, (struct soil_shape){.kind = SOIL_BOX, .size = {1, 1, 1}},
	     (struct scene_path){.points = timed, .count = 2, .timed = true, .has_z = true, .has_attitude = true});
	assert_int_equal(shown(&rig, 1.9, &now), 0);
	assert_int_equal(shown(&rig, 3, &now), 1);
	assert_near(now.at[0], 525, 1e-5);
	assert_near(now.at[2], 8, 1e-5);
	assert_near(now.roll, 0.6, 1e-9);
	rig_close(&rig);
}

TEST_PROGRAM(view_objects)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_rolls_on_from_its_last_station_to_the_next),
		cmocka_unit_test(a_ball_rolls_by_its_way),
		cmocka_unit_test(where_there_is_no_ground_it_is_drawn_if_that_is_known),
	};
	return cmocka_run_group_tests_name("view_objects", tests, support_enter, support_leave);
}
