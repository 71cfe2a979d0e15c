/* Looking changes nothing (law 16): a world that is not stepped leaves each file as it was, and a readonly one needs none that can be written. */
#include <dirent.h>
#include <stdlib.h>
#include <xxhash.h>

#include "hosted.h"
#include "../support/program.h"

#define FEW 0.01 /* s */

static uint64_t hash_of(const char *path)
{
	static char bytes[1 << 22];
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return 0;
	const size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	return XXH3_64bits(bytes, size);
}

/* All files of the test's folder: names and bytes. */
static uint64_t folder_now(void)
{
	uint64_t sum = 0;
	DIR *folder = opendir(support_folder);
	assert_non_null(folder);
	for (struct dirent *entry; (entry = readdir(folder)) != NULL;)
		if (entry->d_name[0] != '.')
			sum += XXH3_64bits(entry->d_name, strlen(entry->d_name)) * (1 + 2 * hash_of(support_path(entry->d_name)));
	closedir(folder);
	return sum;
}

static struct furrow_world *opened(struct furrow_open open)
{
	struct furrow_world *world = NULL;
	done(furrow_world_open(&open, &world));
	return world;
}

/* A ball that rolls, for a record and a rut in store or overlay. */
static void drive(const char *store, const char *overlay, int steps)
{
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.overlay = overlay;
	struct furrow_world *world = opened(open);
	const furrow_body ball = hosted_ball(world, 10, 10);
	for (int i = 1; i <= steps; i++) {
		const struct furrow_state state = hosted_state(10 + 0.05 * i, 10, 100.4);
		done(furrow_set_states(world, 1, &ball, &state));
		done(furrow_step(world, 0));
	}
	done(furrow_world_close(world));
}

/* Each call of furrow.h that only looks. `bodies`: adds one, and places it unless the world is readonly. */
static void look(struct furrow_world *world, bool bodies, bool readonly)
{
	static const double up[2][3] = {{10, 10, 200}, {0, 0, -1}}, xy[2] = {10, 10};
	struct furrow_info info = {.size = sizeof info};
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rects[64];
	struct furrow_camera camera = {sizeof camera, {{10, 2, 103}, {0.7071067811865476, 0, 0, 0.7071067811865476}}, 1, 64, 48};
	static uint8_t rgb[64 * 48 * 3];
	double posts[16];
	size_t count = 64;
	uint64_t now;
	char *json;
	if (bodies) {
		furrow_body ball, same;
		const struct furrow_pose pose = hosted_pose(12, 12, 100.4);
		struct furrow_state state = hosted_state(12, 12, 100.3);
		struct furrow_contact contact;
		done(furrow_body_add(world, "{name: looked, shape: {sphere: {radius: 0.5}}}", &ball));
		done(furrow_body_find(world, "looked", &same));
		assert_int_equal(ball, same);
		if (!readonly) {
			done(furrow_place(world, ball, &pose));
			done(furrow_probe(world, 1, &ball, &state, &contact, sizeof contact));
			assert_true(contact.force[2] > 0);
			done(furrow_set_states(world, 1, &ball, &state));
			done(furrow_checkpoint(world));
			done(furrow_rollback(world));
		}
		done(furrow_get_states(world, 1, &ball, &state));
		done(furrow_get_contacts(world, 1, &ball, &contact, sizeof contact));
		done(furrow_body_remove(world, ball));
	}
	done(furrow_info(world, &info));
	done(furrow_points(world, 1, xy, &point));
	done(furrow_rays(world, 1, up[0], up[1], &hit));
	assert_true(hit.hit);
	done(furrow_read(world, FURROW_OFFSET, info.level, 80, 80, 4, 4, posts, 4));
	done(furrow_changes(world, 0, rects, &count, &now));
	done(furrow_render(world, &camera, rgb, NULL));
	done(furrow_stats(world, &json));
	furrow_free(json);
	done(furrow_rollback(world));
}

static void a_world_that_does_not_step_leaves_each_byte(void **state)
{
	char paths[4][128];
	static const char *const names[] = {"plain.furrow", "over.furrow", "branch.furrow", "new.furrow"};
	for (int i = 0; i < 4; i++)
		strcpy(paths[i], support_path(names[i])); /* support_path() has few places, and folder_now() uses them */
	const char *store = paths[0], *over = paths[1], *branch = paths[2];
	support_store(store, hosted_extent, hosted_flat);
	drive(store, over, 3);
	must(store_create_overlay(branch, over));
	const uint64_t before = folder_now();
	const struct {
		const char *store, *overlay;
	} cases[] = {{store, NULL}, {over, NULL}, {store, over}, {branch, NULL}, {store, paths[3]}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		for (int readonly = 0; readonly < 2; readonly++) {
			struct furrow_open open = hosted_open(HOSTED_SCENE, cases[i].store);
			open.overlay = cases[i].overlay;
			open.readonly = readonly != 0;
			if (i == 4 && readonly) {
				struct furrow_world *none = NULL;
				refused(FURROW_INPUT, furrow_world_open(&open, &none));
				continue;
			}
			struct furrow_world *world = opened(open);
			look(world, (i + (size_t)readonly) % 2 == 0, readonly != 0);
			done(furrow_world_close(world));
			if (folder_now() != before)
				print_error("case %zu, readonly %d\n", i, readonly);
			assert_true(folder_now() == before);
		}
	/* A scene with a path, and one whose undisturbed ground slides. */
	static const char *const scenes[] = {
		"{scene: 1, spacing: 0.125, redistribute: {model: box}, objects: [{name: w, shape: {sphere: {radius: 0.5}}, sink: 0.1,"
		" path: {points: [[4, 4], [28, 28]], speed: 5}}]}",
		"{scene: 1, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: slippage, undisturbed: slides}}",
	};
	for (int i = 0; i < 2; i++) {
		struct furrow_world *world = opened(hosted_open(scenes[i], over));
		look(world, false, false);
		done(furrow_world_close(world));
		assert_true(folder_now() == before);
	}
	/* The record of the drive is there still. */
	struct furrow_open open = hosted_open(HOSTED_SCENE, over);
	open.resume = open.readonly = true;
	struct furrow_world *world = opened(open);
	assert_true(fabs(furrow_time(world) - 3 * FEW) < 1e-9);
	done(furrow_world_close(world));
	assert_true(folder_now() == before);
}

static void what_steps_and_goes_back_to_the_opening_leaves_the_record(void **state)
{
	const char *store = support_path("back.furrow");
	struct store *file;
	uint64_t before, after;
	support_store(store, hosted_extent, hosted_flat);
	drive(store, NULL, 3);
	must(store_open(store, &(struct store_options){.mode = STORE_READ}, &file));
	must(store_content_hash(file, &before));
	store_close(file);
	struct furrow_world *world = opened(hosted_open(HOSTED_SCENE, store));
	for (int turn = 0; turn < 2; turn++) {
		const furrow_body ball = hosted_ball(world, 20, 20);
		const struct furrow_state lower = hosted_state(20, 20, 100.4);
		done(furrow_set_states(world, 1, &ball, &lower));
		done(furrow_step(world, 0));
		done(furrow_rollback(world));
		assert_true(furrow_time(world) == 0);
	}
	done(furrow_world_close(world));
	must(store_open(store, &(struct store_options){.mode = STORE_READ}, &file));
	must(store_content_hash(file, &after));
	store_close(file);
	assert_true(before == after);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.resume = true;
	world = opened(open);
	assert_true(fabs(furrow_time(world) - 3 * FEW) < 1e-9);
	done(furrow_world_close(world));
}

static int told;

static void listen(int level, const char *message, void *user)
{
	print_error("%s\n", message);
	told++;
}

/* What a drive is told of ruts that are there is nothing to who looks. */
static void a_readonly_world_is_told_nothing_of_a_run(void **state)
{
	const char *store = support_path("quiet.furrow");
	support_store(store, hosted_extent, hosted_flat);
	drive(store, NULL, 3);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.readonly = true;
	furrow_set_log(listen, NULL);
	struct furrow_world *world = opened(open);
	done(furrow_world_close(world));
	furrow_set_log(NULL, NULL);
	assert_int_equal(told, 0);
}

static void a_readonly_world_is_not_changed(void **state)
{
	const char *store = support_path("still.furrow");
	support_store(store, hosted_extent, hosted_flat);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	open.readonly = true;
	struct furrow_world *world = opened(open), *other = NULL;
	furrow_body ball;
	const struct furrow_pose pose = hosted_pose(12, 12, 101);
	const struct furrow_state to = hosted_state(12, 12, 101);
	done(furrow_body_add(world, HOSTED_BALL, &ball));
	misused(furrow_step(world, 0));
	assert_non_null(strstr(furrow_last_error(), "readonly"));
	misused(furrow_checkpoint(world));
	misused(furrow_place(world, ball, &pose));
	misused(furrow_set_states(world, 1, &ball, &to));
	/* It keeps nobody from writing, and sees what is written when it is opened again. */
	drive(store, NULL, 3);
	done(furrow_world_close(world));
	open.output = support_path("folder");
	misused(furrow_world_open(&open, &other));
	assert_null(other);
	assert_int_equal(access(open.output, F_OK), -1);
}

static double height_of(struct furrow_world *world, double x, double y)
{
	const double xy[2] = {x, y};
	struct furrow_point point;
	done(furrow_points(world, 1, xy, &point));
	return point.height;
}

/* A readonly world tells the last commit of whoever writes: heights, posts, rays, and what changed. */
static void a_readonly_world_follows_who_writes(void **state)
{
	const char *store = support_path("follow.furrow");
	static const double down[2][3] = {{20, 20, 200}, {0, 0, -1}};
	struct furrow_hit hit;
	struct furrow_rect rects[64];
	struct furrow_info info = {.size = sizeof info};
	double posts[9];
	size_t count = 64;
	support_store(store, hosted_extent, hosted_flat);
	drive(store, NULL, 2);
	struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	struct furrow_world *writing = opened(open);
	open.readonly = true;
	struct furrow_world *looking = opened(open);
	assert_true(height_of(looking, 20, 20) == 100);
	done(furrow_info(looking, &info));
	const furrow_body ball = hosted_ball(writing, 20, 20);
	for (int turn = 1; turn <= 2; turn++) {
		hosted_move(writing, ball, 20, 20, 100.5 - 0.1 * turn);
		done(furrow_checkpoint(writing));
		const double height = height_of(writing, 20, 20);
		assert_true(height < 100 - 0.05 * turn);
		assert_true(height_of(looking, 20, 20) == height);
		done(furrow_rays(looking, 1, down[0], down[1], &hit));
		assert_true(fabs(hit.position[2] - height) < 1e-3);
		done(furrow_read(looking, FURROW_SURFACE, info.level, 159, 159, 3, 3, posts, 3));
		assert_true(fabs(posts[4] - height) < 1e-5);
		count = 64;
		done(furrow_changes(looking, info.revision, rects, &count, &info.revision));
		bool changed = false;
		for (size_t i = 0; i < count; i++)
			changed = changed || (rects[i].column <= 160 && rects[i].row <= 160 && rects[i].column + rects[i].columns > 160 && rects[i].row + rects[i].rows > 160);
		assert_true(changed);
	}
	done(furrow_rollback(writing)); /* to the checkpoint */
	assert_true(height_of(looking, 20, 20) == height_of(writing, 20, 20));
	done(furrow_world_close(writing));
	assert_true(height_of(looking, 20, 20) < 99.9);
	done(furrow_world_close(looking));
}

/* It sees the first ruts of a store, too. What it cannot follow it says: other posts. */
static void a_first_drive_is_seen_or_told(void **state)
{
	static const char *const scenes[] = {HOSTED_SCENE, "{\"scene\": 1, \"spacing\": 0.25}", "{\"scene\": 1, \"spacing\": 0.125}"};
	const double xy[2] = {10, 10};
	struct furrow_point point;
	for (int i = 0; i < 3; i++) {
		const char *store = support_path("first.furrow");
		support_store(store, hosted_extent, hosted_flat);
		struct furrow_open open = hosted_open(scenes[i], store);
		open.readonly = true;
		struct furrow_world *looking = opened(open);
		assert_true(height_of(looking, 10, 10) == 100);
		drive(store, NULL, 2);
		if (i != 1) {
			assert_true(height_of(looking, 10.05, 10) < 99.95);
		} else {
			refused(FURROW_INPUT, furrow_points(looking, 1, xy, &point));
			assert_non_null(strstr(furrow_last_error(), "open it again"));
		}
		done(furrow_world_close(looking));
	}
}

/* A host of an earlier version: its struct ends with bytes that nobody sets. */
static void an_older_host_is_not_readonly(void **state)
{
	const char *store = support_path("older.furrow");
	struct furrow_open open;
	struct furrow_world *world = NULL;
	support_store(store, hosted_extent, hosted_flat);
	memset(&open, 0xff, sizeof open);
	open.size = offsetof(struct furrow_open, reserved);
	open.scene = HOSTED_SCENE;
	open.scene_file = open.overlay = open.output = NULL;
	open.store = store;
	open.resume = open.durable = open.keep_history = false;
	done(furrow_world_open(&open, &world));
	done(furrow_step(world, 0));
	done(furrow_world_close(world));
	open.size = 8;
	misused(furrow_world_open(&open, &world));
}

TEST_PROGRAM(looking)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_world_that_does_not_step_leaves_each_byte),
		cmocka_unit_test(what_steps_and_goes_back_to_the_opening_leaves_the_record),
		cmocka_unit_test(a_readonly_world_is_told_nothing_of_a_run),
		cmocka_unit_test(a_readonly_world_is_not_changed),
		cmocka_unit_test(a_readonly_world_follows_who_writes),
		cmocka_unit_test(a_first_drive_is_seen_or_told),
		cmocka_unit_test(an_older_host_is_not_readonly),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
