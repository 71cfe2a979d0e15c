/* By which law the soil presses on parts of a body: shares of its way that are slid, by hand, and what the spacing costs. */
#include <math.h>

#include "fixture.h"
#include "scene/scene_faces_errors.h"
#include "../support/near.h"
#include "../support/program.h"

static void tell(const char *object, double spacing, struct scene_laws *out)
{
	char text[700];
	struct scene *scene;
	snprintf(text, sizeof text, "scene: 1\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm, faces: on}\nobjects:\n  - {name: a, %s}\n", object);
	if (load_text(text, NULL, 0, &scene) != STATUS_OK)
		fail_msg("%s: %s", object, failure_message());
	assert_true(scene_laws_of(scene, &scene->objects[0], spacing, out));
	scene_destroy(scene);
}

static double share_of(const struct scene_laws *laws, const char *part)
{
	for (size_t i = 0; i < laws->count; i++)
		if (strcmp(laws->parts[i].part, part) == 0)
			return laws->parts[i].faces;
	return -1;
}

#define WAY "path: {points: [[10, 10], [20, 10]], speed: 1}"
#define WHEEL "shape: {wheel: {radius: 0.4, width: 0.2}}, load: 900, " WAY
#define BARS "shape: {wheel: {radius: 0.4, width: 0.2, grousers: 60}}, load: 900, " WAY /* so close that they carry the soil between them */

static void a_wheel_presses_by_the_share_of_its_way_that_it_slides(void **state)
{
	static const struct {
		const char *object;
		double slides, sides, bars; /* bars: -1: it has none; 1: as the rim, since both are one drum */
	} wheels[] = {
		{WHEEL, 0, 0, -1},
		{WHEEL ", slip: 0.6", 0, 0, -1},              /* a smooth rim that spins slides over soil that stays */
		{WHEEL ", slip: -1", 0.5, 0, -1},             /* it rolls off half of its way */
		{WHEEL ", slip: -1000", 1 - 1 / 1001.0, 0, -1},
		{WHEEL ", attitude: [30, 0, 0]", 0.5, 1, -1}, /* sine of 30 degrees */
		{WHEEL ", attitude: [-30, 0, 0]", 0.5, 1, -1},
		{WHEEL ", attitude: [90, 0, 0]", 1, 1, -1},
		{WHEEL ", attitude: [90, 0, 0], slip: 0.95", 0.5, 1, -1}, /* the rim runs 20 times as fast */
		{BARS, 0, 0, 0},
		{BARS ", slip: 0.5", 0, 0, 0},                /* as a smooth rim that runs twice as far as the axle goes */
		{BARS ", slip: -1", 0.5, 0, 1},
		{BARS ", attitude: [90, 0, 0]", 1, 1, 1},
	};
	double rim_most = 0;
	for (size_t i = 0; i < sizeof wheels / sizeof *wheels; i++) {
		struct scene_laws laws;
		tell(wheels[i].object, 0.05, &laws);
		const double slides = wheels[i].slides;
		assert_near(laws.slides, slides, 1e-5);
		const double rim = share_of(&laws, "rim");
		assert_true(rim == 0 ? slides == 0 : rim > slides - 0.01 && rim <= 1); /* the law's power is below 1 */
		rim_most = slides < 0.99 ? fmax(rim, rim_most) : rim_most;
		assert_near(share_of(&laws, "sides"), wheels[i].sides, 0);
		assert_near(share_of(&laws, "bars"), wheels[i].bars > 0 ? rim : wheels[i].bars, 0);
		assert_int_equal(laws.count, wheels[i].bars < 0 ? 2 : 3);
		assert_true(laws.wheel && fabs(laws.posts - 8) < 1e-12);
	}
	assert_true(rim_most > 0.5 && rim_most < 0.9); /* where half of the way is slid */
}

static void other_bodies_slide_all_of_their_way(void **state)
{
	struct scene_laws laws;
	tell("shape: {box: {size: [0.1, 1, 0.4]}}, sink: 0.1, " WAY, 0.02, &laws);
	assert_near(laws.slides, 1, 0);
	assert_near(share_of(&laws, "underside"), 1, 0);
	assert_near(share_of(&laws, "front and sides"), 1, 0);
	assert_true(!laws.wheel && fabs(laws.posts - 5) < 1e-12);
	tell("shape: {box: {size: [1, 1, 0.4], belt: true}}, load: 900, " WAY, 0.02, &laws); /* a belt rolls */
	assert_near(share_of(&laws, "underside"), 0, 0);
	tell("shape: {sphere: {radius: 1}}, load: 900, path: {points: [[10, 10]], speed: 1}", 0.02, &laws);
	assert_near(laws.slides, 0, 0);
	assert_true(isnan(laws.posts));
	struct scene *scene;
	assert_int_equal(load_text("scene: 1\nend_time: 1\nobjects:\n  - {name: a, shape: {sphere: {radius: 1}}, " WAY "}\n", NULL, 0, &scene), STATUS_OK);
	assert_true(!scene_laws_of(scene, &scene->objects[0], 0.02, &laws));
	scene_destroy(scene);
}

static void finer_posts_cost_no_more(void **state)
{
	static const char *const objects[] = {WHEEL, BARS, WHEEL ", slip: -1", WHEEL ", attitude: [20, 0, 0]", "shape: {box: {size: [0.1, 1, 0.4]}}, sink: 0.1, " WAY};
	for (size_t i = 0; i < sizeof objects / sizeof *objects; i++) {
		int before = 1000;
		for (double spacing = 0.3; spacing > 0.002; spacing *= 0.9) {
			struct scene_laws laws;
			tell(objects[i], spacing, &laws);
			assert_true(laws.error >= 0 && laws.error <= before);
			assert_true(laws.beyond == (laws.posts < (i < 4 ? 4 : 1.6)));
			if (laws.finer > 0)
				assert_true(2 * laws.finer_error <= laws.error && laws.finer < spacing);
			before = laws.error;
		}
	}
	/* At the bench's own posts it is the bench's own error. */
	for (size_t row = 0; row < SCENE_FACES_ROWS; row++) {
		struct scene_laws rolls, bars, locked, turned, blade;
		const double spacing = 0.4 / scene_faces_wheels[row].posts;
		const int *errors = scene_faces_wheels[row].errors;
		tell(WHEEL, spacing, &rolls);
		tell(BARS, spacing, &bars);
		tell(WHEEL ", slip: -1", spacing, &locked);
		tell(WHEEL ", attitude: [20, 0, 0]", spacing, &turned);
		tell("shape: {box: {size: [0.1, 1, 0.4]}}, sink: 0.1, " WAY, 0.1 / scene_faces_blades[row].posts, &blade);
		assert_true(rolls.error == errors[SCENE_FACES_ROLLS] && bars.error == errors[SCENE_FACES_BARS] && locked.error == errors[SCENE_FACES_LOCKED]);
		assert_true(turned.error == errors[SCENE_FACES_TURNED] && blade.error == scene_faces_blades[row].error);
	}
}

TEST_PROGRAM(laws)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_presses_by_the_share_of_its_way_that_it_slides),
		cmocka_unit_test(other_bodies_slide_all_of_their_way),
		cmocka_unit_test(finer_posts_cost_no_more),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
