/* Every function of furrow.h with what it must refuse: a status and a whole message, never a crash, and nothing changed. */
#include "hosted.h"
#include "../support/program.h"

#define SCENE_WITH_PATH \
	"scene: 1\ntime_step: 0.01\nspacing: 0.125\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nobjects:\n" \
	"  - {name: driven, shape: {sphere: {radius: 0.5}}, sink: 0.05, path: {points: [[5, 5], [25, 5]], speed: 1}}\n" \
	"  - {name: free, shape: {sphere: {radius: 0.5}}}\n"

/* One world for all tests: none of them may change it. */
static struct furrow_world *world;
static furrow_body ball;
static struct furrow_info before;

static int enter(void **state)
{
	return support_enter(state);
}

static int leave(void **state)
{
	const int failed = furrow_world_close(world) != FURROW_OK;
	return support_leave(state) != 0 || failed;
}

static void need_world(void)
{
	if (world != NULL)
		return;
	world = hosted_world_over("arguments.furrow", SCENE_WITH_PATH, hosted_flat);
	ball = hosted_ball(world, 16, 16);
	before.size = sizeof before;
	done(furrow_info(world, &before));
}

static void functions_without_a_world(void **state)
{
	assert_string_equal(furrow_version(), FURROW_VERSION);
	assert_non_null(furrow_last_error());
	furrow_set_log(NULL, NULL);
	furrow_free(NULL);
	assert_int_equal(furrow_world_close(NULL), FURROW_OK);
}

static void an_import_that_is_wrong(void **state)
{
	const char *out = support_path("import.furrow");
	const char *missing[] = {"/nonexistent/dem.tif"}, *none[] = {NULL};
	misused(furrow_import(NULL, 1, out, NULL, NULL, NULL));
	misused(furrow_import(missing, 0, out, NULL, NULL, NULL));
	misused(furrow_import(none, 1, out, NULL, NULL, NULL));
	misused(furrow_import(missing, 1, NULL, NULL, NULL, NULL));
	refused(FURROW_INPUT, furrow_import(missing, 1, out, NULL, NULL, NULL));
	misused(furrow_import(missing, 1, out, "{no_such_option: 1}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{max_error: -1}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{max_error: much}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{tile: 100}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{spacing: [1, 2]}", NULL, NULL));
	assert_non_null(strstr(furrow_last_error(), "options: line 1: spacing is a list; give one value"));
	misused(furrow_import(missing, 1, out, "{spacing: []}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{no_such_option: []}", NULL, NULL));
	misused(furrow_import(missing, 1, out, "{window: [1, 2]}", NULL, NULL));
	refused(FURROW_INPUT, furrow_import(missing, 1, out, "{nodata: [1, 2], window: [0, 0, 1, 1]}", NULL, NULL)); /* the source is not there */
	misused(furrow_import(missing, 1, out, "{", NULL, NULL));
	misused(furrow_import(missing, 1, out, "[1, 2]", NULL, NULL));
	assert_int_equal(access(out, F_OK), -1);
}

static void an_opening_that_is_wrong(void **state)
{
	const char *store = support_path("open.furrow");
	struct furrow_world *none = (struct furrow_world *)&before;
	support_store(store, hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	misused(furrow_world_open(NULL, &none));
	assert_null(none);
	misused(furrow_world_open(&open, NULL));
	open.size = 0;
	misused(furrow_world_open(&open, &none));
	open.size = sizeof(size_t); /* none of its members */
	misused(furrow_world_open(&open, &none));
	open = hosted_open(NULL, store);
	misused(furrow_world_open(&open, &none));
	open = hosted_open(HOSTED_SCENE, store);
	open.scene_file = "scene.yaml";
	misused(furrow_world_open(&open, &none));

	open = hosted_open("scene: 1\nno_such_key: 2\n", store);
	none = (struct furrow_world *)&before;
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	assert_null(none);
	assert_non_null(strstr(furrow_last_error(), "2")); /* the line */
	open = hosted_open("{", store);
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	open = hosted_open("", store);
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	open = hosted_open(HOSTED_SCENE, support_path("missing.furrow"));
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	open = hosted_open(HOSTED_SCENE, NULL);
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	open = hosted_open(NULL, store);
	open.scene_file = support_path("missing.yaml");
	refused(FURROW_INPUT, furrow_world_open(&open, &none));
	open = hosted_open(HOSTED_SCENE, store);
	open.output = "/nonexistent/folder";
	assert_true(furrow_world_open(&open, &none) != FURROW_OK);
	assert_null(none);
}

static void no_world(void **state)
{
	struct furrow_info info = {.size = sizeof info};
	struct furrow_pose pose = hosted_pose(0, 0, 0);
	struct furrow_state body_state = hosted_state(0, 0, 0);
	struct furrow_contact contact;
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rect;
	struct furrow_camera camera = {sizeof camera, pose, 1, 8, 8};
	const double numbers[3] = {1, 2, 3}, pair[2] = {1, 2};
	double post;
	uint8_t rgb[3 * 64];
	float depth[64];
	char *json = NULL;
	furrow_body body = 0;
	const struct furrow_belt belt = {0, 1};
	size_t count = 1;
	uint64_t now;
	misused(furrow_step(NULL, 0));
	assert_true(isnan(furrow_time(NULL)));
	misused(furrow_checkpoint(NULL));
	misused(furrow_rollback(NULL));
	misused(furrow_info(NULL, &info));
	misused(furrow_stats(NULL, &json));
	misused(furrow_body_add(NULL, HOSTED_BALL, &body));
	misused(furrow_body_find(NULL, "a", &body));
	misused(furrow_body_remove(NULL, 0));
	body = 0;
	misused(furrow_probe(NULL, 1, &body, &body_state, &contact, sizeof contact));
	misused(furrow_set_states(NULL, 1, &body, &body_state));
	misused(furrow_set_belts(NULL, 1, &body, &belt));
	misused(furrow_place(NULL, 0, &pose));
	misused(furrow_get_states(NULL, 1, &body, &body_state));
	misused(furrow_get_contacts(NULL, 1, &body, &contact, sizeof contact));
	misused(furrow_points(NULL, 1, pair, &point));
	misused(furrow_rays(NULL, 1, numbers, numbers, &hit));
	misused(furrow_read(NULL, FURROW_SURFACE, 0, 0, 0, 1, 1, &post, 1));
	misused(furrow_changes(NULL, 0, &rect, &count, &now));
	misused(furrow_render(NULL, &camera, rgb, depth));
}

static void pointers_that_are_null(void **state)
{
	need_world();
	const struct furrow_state body_state = hosted_state(16, 16, 100.5);
	struct furrow_state got;
	struct furrow_contact contact;
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_camera camera = {sizeof camera, hosted_pose(16, 16, 110), 1, 8, 8};
	const double up[3] = {0, 0, 1}, pair[2] = {1, 2};
	furrow_body body;
	size_t count = 4;
	misused(furrow_info(world, NULL));
	misused(furrow_stats(world, NULL));
	misused(furrow_body_add(world, NULL, &body));
	misused(furrow_body_add(world, HOSTED_BALL, NULL));
	misused(furrow_body_find(world, NULL, &body));
	misused(furrow_body_find(world, "free", NULL));
	misused(furrow_probe(world, 1, NULL, &body_state, &contact, sizeof contact));
	misused(furrow_probe(world, 1, &ball, NULL, &contact, sizeof contact));
	misused(furrow_probe(world, 1, &ball, &body_state, NULL, sizeof contact));
	misused(furrow_set_states(world, 1, NULL, &body_state));
	misused(furrow_set_states(world, 1, &ball, NULL));
	misused(furrow_set_belts(world, 1, NULL, &(const struct furrow_belt){0, 1}));
	misused(furrow_set_belts(world, 1, &ball, NULL));
	misused(furrow_place(world, ball, NULL));
	misused(furrow_get_states(world, 1, NULL, &got));
	misused(furrow_get_states(world, 1, &ball, NULL));
	misused(furrow_get_contacts(world, 1, NULL, &contact, sizeof contact));
	misused(furrow_get_contacts(world, 1, &ball, NULL, sizeof contact));
	misused(furrow_points(world, 1, NULL, &point));
	misused(furrow_points(world, 1, pair, NULL));
	misused(furrow_rays(world, 1, NULL, up, &hit));
	misused(furrow_rays(world, 1, up, NULL, &hit));
	misused(furrow_rays(world, 1, up, up, NULL));
	misused(furrow_read(world, FURROW_SURFACE, before.level, 0, 0, 1, 1, NULL, 1));
	misused(furrow_changes(world, 0, NULL, &count, NULL));
	misused(furrow_changes(world, 0, NULL, NULL, NULL));
	misused(furrow_render(world, NULL, NULL, NULL));
}

static void numbers_that_are_none(void **state)
{
	need_world();
	static const double wrong[] = {NAN, INFINITY, -INFINITY};
	struct furrow_point point;
	struct furrow_hit hit;
	misused(furrow_step(world, -0.01));
	for (int i = 0; i < 3; i++) {
		misused(furrow_step(world, wrong[i]));
		/* Each number of a state by turns: 3 + 4 + 3 + 3. */
		for (size_t at = 0; at < sizeof(struct furrow_state) / sizeof(double); at++) {
			struct furrow_state body_state = hosted_state(16, 16, 100.5);
			((double *)&body_state)[at] = wrong[i];
			misused(furrow_set_states(world, 1, &ball, &body_state));
			if (at < 7)
				misused(furrow_place(world, ball, &body_state.pose));
		}
		const double at[3] = {16, 16, 110}, down[3] = {0, 0, -1};
		for (int k = 0; k < 3; k++) {
			double bad[3] = {16, 16, 110}, pair[2] = {16, 16};
			bad[k] = wrong[i];
			pair[k % 2] = wrong[i];
			misused(furrow_rays(world, 1, bad, down, &hit));
			misused(furrow_rays(world, 1, at, bad, &hit));
			if (isnan(wrong[i]))
				misused(furrow_points(world, 1, pair, &point));
		}
		struct furrow_camera camera = {sizeof camera, hosted_pose(16, 16, 110), wrong[i], 8, 8};
		uint8_t rgb[3 * 64];
		misused(furrow_render(world, &camera, rgb, NULL));
		camera.fovy = 1;
		camera.pose.position[1] = wrong[i];
		misused(furrow_render(world, &camera, rgb, NULL));
		camera.pose = hosted_pose(16, 16, 110);
		camera.pose.orientation[2] = wrong[i];
		misused(furrow_render(world, &camera, rgb, NULL));
	}
	const double at[3] = {16, 16, 110}, nowhere[3] = {0, 0, 0};
	misused(furrow_rays(world, 1, at, nowhere, &hit));
	struct furrow_pose pose = hosted_pose(16, 16, 101);
	pose.orientation[0] = 0;
	misused(furrow_place(world, ball, &pose));
	pose.orientation[0] = 2;
	misused(furrow_place(world, ball, &pose));
}

static void sizes_that_are_off(void **state)
{
	need_world();
	const struct furrow_state body_state = hosted_state(16, 16, 100.5);
	struct furrow_info info = {.size = 0};
	struct furrow_contact contact;
	uint8_t rgb[3 * 64];
	double posts[64];
	misused(furrow_info(world, &info));
	info.size = sizeof(size_t) - 1;
	misused(furrow_info(world, &info));
	misused(furrow_get_contacts(world, 1, &ball, &contact, 0));
	misused(furrow_get_contacts(world, 1, &ball, &contact, sizeof contact / 2));
	misused(furrow_probe(world, 1, &ball, &body_state, &contact, 0));
	const struct furrow_camera good = {sizeof good, hosted_pose(16, 16, 110), 1, 8, 8};
	struct furrow_camera camera = good;
	camera.size = 0;
	misused(furrow_render(world, &camera, rgb, NULL));
	camera = good;
	camera.width = 0;
	misused(furrow_render(world, &camera, rgb, NULL));
	camera = good;
	camera.height = UINT32_MAX;
	misused(furrow_render(world, &camera, rgb, NULL));
	for (int i = 0; i < 3; i++) {
		camera = good;
		camera.fovy = (const double[]){0, -1, 3.2}[i];
		misused(furrow_render(world, &camera, rgb, NULL));
	}
	misused(furrow_read(world, FURROW_SURFACE, before.level, 0, 0, 8, 8, posts, 7));
	misused(furrow_read(world, (enum furrow_layer)99, before.level, 0, 0, 8, 8, posts, 8));
	misused(furrow_read(world, (enum furrow_layer)-1, before.level, 0, 0, 8, 8, posts, 8));
	misused(furrow_read(world, FURROW_SURFACE, before.level - 1, 0, 0, 8, 8, posts, 8));
	misused(furrow_read(world, FURROW_SURFACE, before.coarsest + 1, 0, 0, 8, 8, posts, 8));
	misused(furrow_changes(world, before.revision + 1000, NULL, &(size_t){0}, NULL));
}

/* A struct's size is that of an earlier version of it, of this one, or of a later one. */
static void sizes_that_no_struct_has(void **state)
{
	need_world();
	static const size_t wrong[] = {0, 7, 9, sizeof before - 1, sizeof before + 1, 4096 + sizeof(size_t), PTRDIFF_MAX, SIZE_MAX};
	struct furrow_open open = hosted_open(HOSTED_SCENE, support_path("arguments.furrow"));
	struct furrow_camera camera = {.pose = hosted_pose(16, 16, 110), .fovy = 1, .width = 8, .height = 8};
	struct furrow_world *none;
	uint8_t rgb[3 * 64];
	union {
		struct furrow_info info;
		unsigned char bytes[4096];
	} later;
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		open.size = camera.size = later.info.size = wrong[i];
		misused(furrow_world_open(&open, &none));
		misused(furrow_render(world, &camera, rgb, NULL));
		misused(furrow_info(world, &later.info));
	}
	memset(&later, 0x55, sizeof later);
	later.info.size = sizeof later;
	done(furrow_info(world, &later.info));
	assert_int_equal(later.info.cells, before.cells);
	assert_int_equal(later.bytes[sizeof later.info], 0x55);
	camera.size = sizeof camera + sizeof(size_t);
	done(furrow_render(world, &camera, rgb, NULL));
}

/* Nothing of the lists may be read before: they have one entry. */
static void counts_that_memory_cannot_have(void **state)
{
	need_world();
	static const size_t wrong[] = {SIZE_MAX, SIZE_MAX / 2, SIZE_MAX / 8};
	const struct furrow_state body_state = hosted_state(16, 16, 100.5);
	const struct furrow_belt belt = {0, 1};
	const double up[3] = {0, 0, 1}, pair[2] = {1, 2};
	const char *source[] = {"/nonexistent/dem.tif"};
	struct furrow_state got;
	struct furrow_contact contact;
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rect;
	double post;
	for (int i = 0; i < 3; i++) {
		const size_t count = wrong[i];
		size_t room = count;
		misused(furrow_set_states(world, count, &ball, &body_state));
		misused(furrow_get_states(world, count, &ball, &got));
		misused(furrow_set_belts(world, count, &ball, &belt));
		misused(furrow_get_contacts(world, count, &ball, &contact, sizeof contact));
		misused(furrow_probe(world, count, &ball, &body_state, &contact, sizeof contact));
		misused(furrow_points(world, count, pair, &point));
		misused(furrow_rays(world, count, up, up, &hit));
		misused(furrow_changes(world, 0, &rect, &room, NULL));
		misused(furrow_read(world, FURROW_SURFACE, before.level, 0, 0, 1, 16, &post, count));
		misused(furrow_import(source, count, support_path("import.furrow"), NULL, NULL, NULL));
	}
}

/* Nothing is asked for: NULL is fine then. Beyond the terrain there are no posts. */
static void nothing_of_everything(void **state)
{
	need_world();
	struct furrow_contact contact;
	double posts[4] = {0, 0, 0, 0};
	done(furrow_set_states(world, 0, NULL, NULL));
	done(furrow_get_states(world, 0, NULL, NULL));
	done(furrow_get_contacts(world, 0, NULL, NULL, sizeof contact));
	done(furrow_probe(world, 0, NULL, NULL, NULL, sizeof contact));
	done(furrow_points(world, 0, NULL, NULL));
	done(furrow_rays(world, 0, NULL, NULL, NULL));
	done(furrow_read(world, FURROW_SURFACE, before.level, 0, 0, 0, 0, NULL, 0));
	static const int64_t beyond[] = {-2, INT64_MIN, INT64_MAX, 1LL << 40};
	for (int i = 0; i < 4; i++) {
		done(furrow_read(world, FURROW_SURFACE, before.level, beyond[i], beyond[i], 2, 2, posts, 2));
		for (int k = 0; k < 4; k++)
			assert_true(isnan(posts[k]));
	}
}

static void bodies_that_are_not_there(void **state)
{
	need_world();
	const struct furrow_state states[2] = {hosted_state(16, 16, 100.5), hosted_state(16, 16, 100.5)};
	const struct furrow_pose pose = states[0].pose;
	struct furrow_state got;
	struct furrow_contact contact;
	furrow_body body = 7, gone = -1, fresh = -1, driven = -1, track = -1;
	const struct furrow_belt belt = {0, 1};
	done(furrow_body_add(world, "{name: brief, shape: {box: {size: [1, 1, 1]}}}", &gone));
	done(furrow_body_remove(world, gone));
	const furrow_body wrong[] = {-1, INT32_MIN, INT32_MAX, 1000, gone};
	for (int i = 0; i < 5; i++) {
		misused(furrow_body_remove(world, wrong[i]));
		misused(furrow_place(world, wrong[i], &pose));
		misused(furrow_set_states(world, 1, &wrong[i], states));
		misused(furrow_set_belts(world, 1, &wrong[i], &belt));
		misused(furrow_get_states(world, 1, &wrong[i], &got));
		misused(furrow_get_contacts(world, 1, &wrong[i], &contact, sizeof contact));
		misused(furrow_probe(world, 1, &wrong[i], states, &contact, sizeof contact));
	}
	refused(FURROW_INPUT, furrow_body_find(world, "brief", &body));
	assert_int_equal(body, -1);
	refused(FURROW_INPUT, furrow_body_find(world, "", &body));
	/* Never placed, or twice in a list, or one that follows its path. */
	done(furrow_body_add(world, HOSTED_BALL, &fresh));
	assert_true(fresh > gone);
	misused(furrow_set_states(world, 1, &fresh, states));
	done(furrow_get_states(world, 1, &fresh, &got));
	assert_true(isnan(got.pose.position[0]));
	misused(furrow_set_states(world, 2, (const furrow_body[]){ball, ball}, states));
	done(furrow_body_remove(world, fresh));
	done(furrow_body_find(world, "driven", &driven));
	misused(furrow_set_states(world, 1, &driven, states));
	misused(furrow_place(world, driven, &pose));
	misused(furrow_set_belts(world, 1, &driven, &belt));
	/* Without a belt; and a speed that is none. */
	misused(furrow_set_belts(world, 1, &ball, &belt));
	done(furrow_body_add(world, "{shape: {box: {size: [1, 1, 1], belt: true}}}", &track));
	misused(furrow_set_belts(world, 1, &track, &(const struct furrow_belt){NAN, 1}));
	misused(furrow_set_belts(world, 1, &track, &(const struct furrow_belt){0, INFINITY}));
	misused(furrow_set_belts(world, 2, (const furrow_body[]){track, ball}, (const struct furrow_belt[]){belt, belt}));
	done(furrow_set_belts(world, 1, &track, &belt));
	done(furrow_set_belts(world, 0, NULL, NULL));
	done(furrow_body_remove(world, track));
	/* What is no entry. */
	refused(FURROW_INPUT, furrow_body_add(world, "", &body));
	assert_int_equal(body, -1);
	refused(FURROW_INPUT, furrow_body_add(world, "{", &body));
	refused(FURROW_INPUT, furrow_body_add(world, "[]", &body));
	refused(FURROW_INPUT, furrow_body_add(world, "{shape: {sphere: {radius: -1}}}", &body));
	refused(FURROW_INPUT, furrow_body_add(world, "{shape: {sphere: {radius: 1, height: 2}}}", &body));
	refused(FURROW_INPUT, furrow_body_add(world, "{name: driven, shape: {sphere: {radius: 1}}}", &body));
}

/* A body without a name gets the first number that is free, also after others were removed. */
static void bodies_without_a_name_get_the_first_that_is_free(void **state)
{
	enum { COUNT = 5 }; /* the world has a body-1 */
	need_world();
	furrow_body bodies[COUNT], again, found;
	char name[32];
	for (int i = 0; i < COUNT; i++)
		done(furrow_body_add(world, "{shape: {sphere: {radius: 0.5}}}", &bodies[i]));
	for (int i = 0; i < COUNT; i++) {
		snprintf(name, sizeof name, "body-%d", i + 2);
		done(furrow_body_find(world, name, &found));
		assert_int_equal(found, bodies[i]);
	}
	done(furrow_body_remove(world, bodies[1]));
	done(furrow_body_remove(world, bodies[3]));
	for (int i = 1; i < 6; i += 2) {
		done(furrow_body_add(world, "{shape: {sphere: {radius: 0.5}}}", &again));
		snprintf(name, sizeof name, "body-%d", i < 5 ? i + 2 : 7);
		done(furrow_body_find(world, name, &found));
		assert_int_equal(found, again);
		done(furrow_body_remove(world, again));
		if (i == 1) /* the next is another then */
			done(furrow_body_add(world, "{name: body-3, shape: {sphere: {radius: 0.5}}}", &bodies[1]));
		if (i == 3)
			done(furrow_body_add(world, "{name: body-5, shape: {sphere: {radius: 0.5}}}", &bodies[3]));
	}
	for (int i = 0; i < COUNT; i++)
		done(furrow_body_remove(world, bodies[i]));
}

/* A name of that kind, too. */
static void a_name_that_is_given_and_taken_is_refused(void **state)
{
	static const char *const objects[] = {"{name: body-7, shape: {sphere: {radius: 0.5}}}", "{name: body-of-mine, shape: {sphere: {radius: 0.5}}}"};
	need_world();
	for (int i = 0; i < 2; i++) {
		furrow_body first, second;
		done(furrow_body_add(world, objects[i], &first));
		refused(FURROW_INPUT, furrow_body_add(world, objects[i], &second));
		assert_int_equal(second, -1);
		done(furrow_body_remove(world, first));
		done(furrow_body_add(world, objects[i], &second));
		done(furrow_body_remove(world, second));
	}
}

static void all_of_that_changed_nothing(void **state)
{
	need_world();
	struct furrow_info after = {.size = sizeof after};
	done(furrow_info(world, &after));
	assert_true(after.revision == before.revision);
	assert_true(furrow_time(world) == 0);
	done(furrow_step(world, 0));
	assert_true(furrow_time(world) == 0.01);
}

TEST_PROGRAM(arguments)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(functions_without_a_world), cmocka_unit_test(an_import_that_is_wrong),
		cmocka_unit_test(an_opening_that_is_wrong),  cmocka_unit_test(no_world),
		cmocka_unit_test(pointers_that_are_null),    cmocka_unit_test(numbers_that_are_none),
		cmocka_unit_test(sizes_that_are_off),        cmocka_unit_test(nothing_of_everything),
		cmocka_unit_test(sizes_that_no_struct_has),  cmocka_unit_test(counts_that_memory_cannot_have),
		cmocka_unit_test(bodies_that_are_not_there), cmocka_unit_test(bodies_without_a_name_get_the_first_that_is_free),
		cmocka_unit_test(a_name_that_is_given_and_taken_is_refused),
		cmocka_unit_test(all_of_that_changed_nothing),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
