/* Soil that is brought and taken by furrow.h: the account holds to the unit, through bodies, sliding, rollback and resume; and what is refused. */
#include "../support/near.h"
#include "rut.h"

#include <cJSON.h>

#include "api/library.h"
#include "dem/dem.h"
#include "../support/program.h"

#define UNITS 0x1p20
#define SCENE_OF(tail) "{\"scene\": 1, \"time_step\": 0.05, \"spacing\": 0.125, \"soil\": {\"name\": \"dry_sand\"}, " tail "}"
#define SCM SCENE_OF("\"redistribute\": {\"model\": \"scm\"}")
#define LOOSENING SCENE_OF("\"redistribute\": {\"model\": \"scm\", \"loosening\": 0.67, \"hardening\": 0.5}")
#define ON_CPU(model) SCENE_OF("\"compute\": \"cpu\", \"redistribute\": {\"model\": \"" model "\"}")
#define ON_GPU(model) SCENE_OF("\"compute\": \"gpu\", \"redistribute\": {\"model\": \"" model "\"}")

/* 60 x 50 posts from (160, 165) on: over the borders of tiles of 32 cells, between which posts 160, 192 and 224 are shared. */
enum { COLUMN = 160, ROW = 165, COLUMNS = 60, ROWS = 50 };

/* A heap in the middle, and a pit at its side. m */
static void heap(double heights[ROWS][COLUMNS])
{
	for (int r = 0; r < ROWS; r++)
		for (int c = 0; c < COLUMNS; c++)
			heights[r][c] = (r - 25) * (r - 25) + (c - 20) * (c - 20) < 200 ? 1.1 + 0.001 * (r * 7 + c * 13 % 11) : c > 45 && r > 10 && r < 30 ? -0.61 - 0.0003 * c : 0;
}

static int64_t units_of(double heights[ROWS][COLUMNS])
{
	int64_t sum = 0;
	for (int r = 0; r < ROWS; r++)
		for (int c = 0; c < COLUMNS; c++)
			sum += lround(heights[r][c] * UNITS);
	return sum;
}

static void pour_heap(struct furrow_world *world, bool loose)
{
	double heights[ROWS][COLUMNS];
	heap(heights);
	done(furrow_pour(world, COLUMN, ROW, COLUMNS, ROWS, &heights[0][0], COLUMNS, -1, loose));
}

static int64_t offsets_of(struct furrow_world *world)
{
	struct furrow_info info;
	double *offsets = hosted_read(world, FURROW_OFFSET, &info);
	int64_t sum = 0;
	for (int64_t i = 0; i < info.columns * info.rows; i++)
		sum += isnan(offsets[i]) ? 0 : llround(offsets[i] * UNITS);
	free(offsets);
	return sum;
}

/* The number of run.json's volume.quanta, as the world tells it after a checkpoint. */
static int64_t told(struct furrow_world *world, const char *name)
{
	char *json;
	done(furrow_stats(world, &json));
	cJSON *root = cJSON_Parse(json), *volume = cJSON_GetObjectItem(root, "volume");
	const cJSON *value = cJSON_GetObjectItem(cJSON_GetObjectItem(volume, "quanta"), name);
	assert_non_null(value);
	const int64_t number = (int64_t)value->valuedouble;
	assert_near(cJSON_GetObjectItem(volume, name)->valuedouble, (double)number / UNITS * 0.125 * 0.125, 1e-9 * fabs((double)number));
	cJSON_Delete(root);
	furrow_free(json);
	return number;
}

static void assert_balanced(struct furrow_world *world, int64_t added)
{
	done(furrow_checkpoint(world));
	assert_int_equal(told(world, "added"), added);
	assert_int_equal(offsets_of(world) + told(world, "compacted"), added);
	assert_int_equal(told(world, "net") + told(world, "compacted"), added);
}

static void fail_on_problem(void *user, const char *text)
{
	(void)user;
	fail_msg("%s", text);
}

/* The closed store is whole, and its own account holds. */
static void assert_stored(const char *name, int64_t added)
{
	struct store *store;
	struct store_check check;
	assert_int_equal(store_open(support_path(name), &(struct store_options){.mode = STORE_READ}, &store), STATUS_OK);
	assert_int_equal(store_verify(store, fail_on_problem, NULL, NULL, &check), STATUS_OK);
	assert_int_equal(check.problems, 0);
	assert_int_equal(check.added, added);
	assert_int_equal(check.offset_sum[-1 - TILE_LEVEL_MIN] + check.compacted, added);
	store_close(store);
}

static void what_is_poured_is_on_the_ground_and_in_the_account(void **state)
{
	static const char *const scenes[] = {SCM, LOOSENING, ON_CPU("slippage"), ON_CPU("sumner"), ON_CPU("none"), ON_GPU("slippage"), ON_GPU("box")};
	double heights[ROWS][COLUMNS];
	heap(heights);
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct furrow_world *world = hosted_world_over("poured.furrow", scenes[i], hosted_flat);
		struct furrow_info info;
		const int64_t added = units_of(heights);
		pour_heap(world, true);
		double *offsets = hosted_read(world, FURROW_OFFSET, &info);
		for (int r = 0; r < ROWS; r++)
			for (int c = 0; c < COLUMNS; c++)
				assert_true(offsets[(ROW + r) * info.columns + COLUMN + c] * UNITS == (double)lround(heights[r][c] * UNITS));
		free(offsets);
		assert_near(point_at(world, (COLUMN + 20) * 0.125, (ROW + 25) * 0.125).height, 100 + heights[25][20], 1e-5);
		assert_balanced(world, added);
		for (int k = 0; k < 20; k++)
			done(furrow_step(world, 0));
		assert_balanced(world, added);
		done(furrow_world_close(world));
		assert_stored("poured.furrow", added);
	}
}

static void the_account_holds_when_bodies_come(void **state)
{
	static const char *const scenes[] = {SCM, LOOSENING};
	double heights[ROWS][COLUMNS];
	heap(heights);
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct furrow_world *world = hosted_world_over("driven.furrow", scenes[i], hosted_flat);
		furrow_body ball = -1;
		pour_heap(world, true);
		done(furrow_body_add(world, HOSTED_BALL, &ball));
		const struct furrow_pose pose = hosted_pose(22, 23.75, 101.7);
		done(furrow_place(world, ball, &pose));
		for (int k = 0; k < 60; k++)
			hosted_move(world, ball, 22 + 0.015 * k, 23.75, 101.7 - 0.0117 * k);
		assert_true(contact_of(world, ball).force[2] > 0);
		assert_balanced(world, units_of(heights));
		assert_true(told(world, "compacted") > 0);
		done(furrow_world_close(world));
		assert_stored("driven.furrow", units_of(heights));
	}
}

static bool is_pit(int64_t column)
{
	return column > COLUMN + 44;
}

static double *after_sliding(const char *name, uint32_t cells, const char *scene, bool loose, struct furrow_info *info)
{
	struct extent extent = hosted_extent;
	struct furrow_world *world = NULL;
	extent.cells = cells;
	support_store(support_path(name), extent, hosted_flat);
	const struct furrow_open open = hosted_open(scene, support_path(name));
	done(furrow_world_open(&open, &world));
	pour_heap(world, loose);
	for (int k = 0; k < 400; k++)
		done(furrow_step(world, 0));
	double *offsets = hosted_read(world, FURROW_OFFSET, info);
	done(furrow_world_close(world));
	return offsets;
}

/* The steepest slope between posts beside each other, in degrees, but for the pit: ground that nothing has moved stands at its walls. */
static double steepest(const double *offsets, const struct furrow_info *info)
{
	double most = 0;
	for (int64_t r = 1; r < info->rows; r++)
		for (int64_t c = 1; c < info->columns && !is_pit(c); c++) {
			const double here = offsets[r * info->columns + c];
			most = support_most(most, fabs(here - offsets[r * info->columns + c - 1]));
			most = support_most(most, fabs(here - offsets[(r - 1) * info->columns + c]));
		}
	return atan(most / info->spacing) * 180 / M_PI;
}

static void loose_soil_slides_to_its_repose_and_dense_soil_stands(void **state)
{
	struct furrow_info info;
	double *loose = after_sliding("slid.furrow", 32, SCM, true, &info), *coarse = after_sliding("slid-64.furrow", 64, SCM, true, &info);
	double *dense = after_sliding("stood.furrow", 32, SCM, false, &info);
	double heights[ROWS][COLUMNS];
	heap(heights);
	assert_memory_equal(loose, coarse, (size_t)(info.columns * info.rows) * sizeof *loose); /* tiles do not show */
	assert_true(steepest(loose, &info) < 37 && steepest(loose, &info) > 25); /* dry sand rests at 35 degrees */
	assert_true(steepest(dense, &info) > 75);
	for (int r = 0; r < ROWS; r++)
		for (int c = 0; c < COLUMNS; c++)
			assert_true(dense[(ROW + r) * info.columns + COLUMN + c] * UNITS == (double)lround(heights[r][c] * UNITS));
	free(loose);
	free(coarse);
	free(dense);
}

/* How deep a ball of this load sinks below the poured surface, by the force that a probe of 20 mm tells: loose soil bears less. */
static double force_on(bool loose)
{
	struct furrow_world *world = hosted_world_over("bears.furrow", LOOSENING, hosted_flat);
	static double layer[81][81];
	furrow_body ball = -1;
	struct furrow_contact contact;
	for (int r = 0; r < 81; r++)
		for (int c = 0; c < 81; c++)
			layer[r][c] = 0.4;
	done(furrow_pour(world, 80, 80, 81, 81, &layer[0][0], 81, 0, loose));
	done(furrow_body_add(world, HOSTED_BALL, &ball));
	const struct furrow_pose pose = hosted_pose(15, 15, 100.9 + 0.001);
	done(furrow_place(world, ball, &pose));
	const struct furrow_state at = hosted_state(15, 15, 100.88);
	done(furrow_probe(world, 1, &ball, &at, &contact, sizeof contact));
	done(furrow_world_close(world));
	return contact.force[2];
}

static void loose_soil_bears_less_than_dense(void **state)
{
	const double loose = force_on(true), dense = force_on(false);
	assert_near(loose / dense, 0.33, 0.02); /* loosening 0.67 */
}

static void a_rollback_takes_it_back(void **state)
{
	struct furrow_world *world = hosted_world_over("back.furrow", LOOSENING, hosted_flat);
	struct furrow_info info;
	double heights[ROWS][COLUMNS];
	heap(heights);
	pour_heap(world, true);
	done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	double *before = hosted_read(world, FURROW_OFFSET, &info);
	for (int way = 0; way < 2; way++) {
		pour_heap(world, way == 0);
		for (int k = 0; k < 5; k++)
			done(furrow_step(world, 0));
		if (way == 1) { /* what is to be taken back is committed */
			assert_int_equal(world_begin_commit(world->world), STATUS_OK);
			assert_int_equal(page_cache_await_commit(world_resident(world->world)->cache), STATUS_OK);
		}
		done(furrow_rollback(world));
		double *after = hosted_read(world, FURROW_OFFSET, &info);
		assert_memory_equal(before, after, (size_t)(info.columns * info.rows) * sizeof *before);
		free(after);
		assert_balanced(world, units_of(heights));
	}
	free(before);
	done(furrow_pour(world, 8, 8, 1, 1, (const double[]){0.5}, 1, -1, true));
	assert_balanced(world, units_of(heights) + (1 << 19));
	done(furrow_world_close(world));
	assert_stored("back.furrow", units_of(heights) + (1 << 19));
}

/* Steps after it was opened again, or in one run. The posts at its end; freed by the caller. */
static double *resumed(const char *name, bool again, struct furrow_info *info, int64_t *added)
{
	struct furrow_world *world = hosted_world_over(name, LOOSENING, hosted_flat);
	pour_heap(world, true);
	for (int k = 0; k < 7; k++)
		done(furrow_step(world, 0));
	if (again) {
		struct furrow_open open = hosted_open(LOOSENING, support_path(name));
		open.resume = true;
		done(furrow_world_close(world));
		done(furrow_world_open(&open, &world));
		assert_near(furrow_time(world), 0.35, 1e-12);
	}
	pour_heap(world, false);
	for (int k = 0; k < 30; k++)
		done(furrow_step(world, 0));
	done(furrow_checkpoint(world));
	*added = told(world, "added");
	assert_int_equal(told(world, "net") + told(world, "compacted"), *added);
	double *offsets = hosted_read(world, FURROW_OFFSET, info);
	done(furrow_world_close(world));
	assert_stored(name, *added);
	return offsets;
}

static void a_world_that_goes_on_has_the_same_ground_and_account(void **state)
{
	struct furrow_info info;
	int64_t one_added, two_added;
	double *one = resumed("one.furrow", false, &info, &one_added), *two = resumed("two.furrow", true, &info, &two_added);
	assert_int_equal(one_added, two_added);
	assert_memory_equal(one, two, (size_t)(info.columns * info.rows) * sizeof *one);
	free(one);
	free(two);
}

static void the_gpu_and_the_cpu_have_the_same_ground(void **state)
{
	struct furrow_info info;
	double *cpu = after_sliding("cpu.furrow", 32, ON_CPU("slippage"), true, &info), *gpu = after_sliding("gpu.furrow", 32, ON_GPU("slippage"), true, &info);
	assert_memory_equal(cpu, gpu, (size_t)(info.columns * info.rows) * sizeof *cpu);
	if (!(steepest(cpu, &info) < 70)) /* it was 84 */
		fail_msg("%g degrees", steepest(cpu, &info));
	free(cpu);
	free(gpu);
}

static void a_volume_over_a_polygon_is_exact(void **state)
{
	static const double corners[][2] = {{5, 5}, {12, 6}, {14.5, 15}, {8, 9.5}}; /* with a notch */
	struct furrow_world *world = hosted_world_over("polygon.furrow", SCM, hosted_flat);
	struct furrow_info info;
	const int64_t units = llround(7.123456 / (0.125 * 0.125) * UNITS);
	done(furrow_pour_polygon(world, 4, &corners[0][0], 7.123456, -1, false));
	double *offsets = hosted_read(world, FURROW_OFFSET, &info), low = INFINITY, high = 0;
	int64_t sum = 0, posts = 0;
	for (int64_t i = 0; i < info.columns * info.rows; i++) {
		sum += llround(offsets[i] * UNITS);
		posts += offsets[i] > 0;
		if (offsets[i] > 0)
			low = support_least(low, offsets[i]);
		high = support_most(high, offsets[i]);
	}
	assert_int_equal(sum, units);
	assert_true((high - low) * UNITS <= 1); /* even, but for what is left */
	double area = 0; /* of the polygon */
	for (int i = 0; i < 4; i++)
		area += (corners[i][0] * corners[(i + 1) % 4][1] - corners[(i + 1) % 4][0] * corners[i][1]) / 2;
	assert_near((double)posts * 0.125 * 0.125 / area, 1, 0.02);
	assert_true(offsets[(int64_t)(13 / 0.125) * info.columns + (int64_t)(9 / 0.125)] == 0); /* in the notch */
	assert_true(offsets[(int64_t)(8 / 0.125) * info.columns + (int64_t)(9 / 0.125)] > 0);
	free(offsets);
	done(furrow_pour_polygon(world, 4, &corners[0][0], -7.123456, -1, false));
	assert_balanced(world, 0);
	assert_int_equal(offsets_of(world), 0);
	done(furrow_world_close(world));
}

static double holed(int64_t x, int64_t y)
{
	return x > 60 && x < 64 && y > 60 && y < 64 ? (double)NAN : 100;
}

static void what_cannot_be_is_refused_and_nothing_changes(void **state)
{
	struct furrow_world *world = hosted_world_over("refused.furrow", SCM, holed);
	const double one[] = {1, 1}, none[] = {0, 0}, wrong[] = {1, NAN}, much[] = {701, 0}, huge[] = {3000, 0};
	const double line[] = {1, 1, 2, 2}, beyond[] = {1, 1, 2, 2, 1, 99}, thin[] = {1.01, 1.01, 1.02, 1.01, 1.02, 1.02}, triangle[] = {1, 1, 3, 1, 1, 3};
	const int64_t far[] = {INT64_MAX, INT64_MIN, -1, 256};
	const furrow_body ball = hosted_ball(world, 10, 16);
	(void)ball;
	misused(furrow_pour(NULL, 0, 0, 2, 1, one, 2, -1, true));
	misused(furrow_pour(world, 0, 0, 2, 1, NULL, 2, -1, true));
	misused(furrow_pour(world, 0, 0, 2, 1, one, 1, -1, true));
	misused(furrow_pour(world, 0, 0, 2, 2, one, SIZE_MAX / 2, -1, true));
	misused(furrow_pour(world, 0, 0, 2, 1, one, 2, 1, true));
	misused(furrow_pour(world, 0, 0, 2, 1, one, 2, -2, true));
	misused(furrow_pour(world, 0, 0, 2, 1, wrong, 2, -1, true));
	for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
		refused(FURROW_INPUT, furrow_pour(world, far[i], 0, 2, 1, one, 2, -1, true));
		refused(FURROW_INPUT, furrow_pour(world, 0, far[i], 1, 2, one, 1, -1, true));
	}
	refused(FURROW_INPUT, furrow_pour(world, 8, 8, 2, 1, much, 2, -1, true));
	refused(FURROW_INPUT, furrow_pour(world, 8, 8, 2, 1, huge, 2, -1, true));
	refused(FURROW_INPUT, furrow_pour(world, 124, 124, 2, 1, one, 2, -1, true)); /* a hole */
	assert_non_null(strstr(furrow_last_error(), "hole"));
	refused(FURROW_INPUT, furrow_pour(world, 80, 128, 2, 1, one, 2, -1, true)); /* below the ball */
	assert_non_null(strstr(furrow_last_error(), "in the ground"));
	misused(furrow_pour_polygon(world, 2, line, 1, -1, true));
	misused(furrow_pour_polygon(world, 3, NULL, 1, -1, true));
	misused(furrow_pour_polygon(world, 3, triangle, NAN, -1, true));
	misused(furrow_pour_polygon(world, SIZE_MAX, triangle, 1, -1, true));
	refused(FURROW_INPUT, furrow_pour_polygon(world, 3, beyond, 1, -1, true));
	refused(FURROW_INPUT, furrow_pour_polygon(world, 3, thin, 1, -1, true));
	refused(FURROW_INPUT, furrow_pour_polygon(world, 3, triangle, 1e9, -1, true));
	done(furrow_pour(world, 124, 124, 2, 1, none, 2, -1, true)); /* nothing is to change there */
	done(furrow_pour(world, 0, 0, 0, 1, one, 2, -1, true));
	assert_int_equal(offsets_of(world), 0);
	assert_int_equal(told(world, "added"), 0);
	done(furrow_pour(world, 8, 8, 2, 1, one, 2, -1, true));
	assert_balanced(world, 2 << 20);
	done(furrow_world_close(world));
	struct furrow_open open = hosted_open(SCM, support_path("refused.furrow"));
	open.readonly = true;
	done(furrow_world_open(&open, &world));
	misused(furrow_pour(world, 8, 8, 2, 1, one, 2, -1, true));
	done(furrow_world_close(world));
}

/* A body above all ground of before is in the poured soil all the same. */
static void a_body_presses_what_was_poured(void **state)
{
	static const char *const scenes[] = {ON_CPU("none"), ON_GPU("none"), ON_CPU("slippage"), ON_GPU("slippage"), SCM};
	static double slab[21][21];
	for (int i = 0; i < 21 * 21; i++)
		slab[i / 21][i % 21] = 1;
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct furrow_world *world = hosted_world_over("pressed.furrow", scenes[i], hosted_flat);
		furrow_body ball = -1;
		const struct furrow_pose pose = hosted_pose(22.5, 23.75, 101.7);
		done(furrow_body_add(world, HOSTED_BALL, &ball));
		done(furrow_place(world, ball, &pose));
		hosted_move(world, ball, 22.5, 23.75, 101.6); /* above: nothing is there */
		done(furrow_pour(world, 170, 180, 21, 21, &slab[0][0], 21, -1, false));
		hosted_move(world, ball, 22.5, 23.75, 101.4);
		assert_near(point_at(world, 22.5, 23.75).offset, 0.9, 0.01);
		done(furrow_world_close(world));
	}
}

/* How far the ground in the middle of a picture is. m */
static double looked(struct furrow_world *world, struct furrow_pose from)
{
	static float depth[33 * 33];
	const struct furrow_camera camera = {.size = sizeof camera, .pose = from, .fovy = 0.2, .width = 33, .height = 33};
	done(furrow_render(world, &camera, NULL, depth));
	return depth[16 * 33 + 16];
}

/* From 20 m above the plain straight down. */
static double seen(struct furrow_world *world)
{
	return looked(world, (struct furrow_pose){{22.5, 23.75, 120}, {M_SQRT1_2, 0, M_SQRT1_2, 0}});
}

static void pictures_show_what_was_poured(void **state)
{
	static const char *const scenes[] = {SCM, ON_CPU("none"), ON_GPU("slippage"), ON_GPU("box")};
	static double tower[21][21], pit[21][21];
	for (int i = 0; i < 21 * 21; i++) {
		tower[i / 21][i % 21] = 15;
		pit[i / 21][i % 21] = -17;
	}
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
		for (int before = 0; before < 2; before++) { /* a picture was drawn before the pour, or none */
			struct furrow_world *world = hosted_world_over("seen.furrow", scenes[i], hosted_flat);
			if (before)
				assert_near(seen(world), 20, 0.01);
			done(furrow_pour(world, 170, 180, 21, 21, &tower[0][0], 21, -1, false));
			assert_near(seen(world), 5, 0.01);
			/* To the east, where no ground of before is in the picture. */
			assert_near(looked(world, hosted_pose(12.5, 23.75, 110)), 8.7, 0.13);
			done(furrow_pour(world, 170, 180, 21, 21, &pit[0][0], 21, -1, false));
			assert_near(seen(world), 22, 0.01);
			done(furrow_rollback(world));
			assert_near(seen(world), 20, 0.01);
			done(furrow_world_close(world));
		}
}

/* The western half is of soil 0, the eastern of soil 1. */
static void a_place_keeps_the_class_of_its_soil_map(void **state)
{
	const char *map = support_path("classes.png");
	struct dem_raster raster = {.path = map, .width = 129, .height = 129, .type = DEM_UINT8, .spacing = 0.25};
	struct dem_writer *writer;
	double classes[129];
	char text[600];
	for (int i = 0; i < 129; i++)
		classes[i] = i < 64 ? 1 : 2;
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
	for (int i = 0; i < 129; i++)
		assert_int_equal(dem_writer_rows(writer, 1, classes), STATUS_OK);
	assert_int_equal(dem_writer_publish(writer), STATUS_OK);
	dem_writer_destroy(writer);
	snprintf(text, sizeof text, "{scene: 1, time_step: 0.05, spacing: 0.125, soil: {map: \"%s\", classes: {1: {name: dry_sand}, 2: {name: sandy_loam_15}}, "
		 "default: {name: dry_sand}}, redistribute: {model: scm}}", map);
	struct furrow_world *world = hosted_world_over("classes.furrow", text, hosted_flat);
	const double one[] = {1, 1};
	const int32_t west = point_at(world, 5, 5).soil, east = point_at(world, 25, 5).soil;
	assert_int_not_equal(west, east);
	refused(FURROW_INPUT, furrow_pour(world, 40, 40, 2, 1, one, 2, east, true));
	assert_non_null(strstr(furrow_last_error(), "soil map"));
	refused(FURROW_INPUT, furrow_pour(world, 200, 40, 2, 1, one, 2, west, true));
	done(furrow_pour(world, 40, 40, 2, 1, one, 2, west, true));
	done(furrow_pour(world, 200, 40, 2, 1, one, 2, east, true));
	done(furrow_pour(world, 100, 40, 2, 1, one, 2, -1, true));
	assert_balanced(world, 6 << 20);
	done(furrow_world_close(world));
}

/* Above a body that hangs in the air there is no soil; below it there may be some. */
static void soil_may_be_poured_below_what_hangs_above(void **state)
{
	struct furrow_world *world = hosted_world_over("hangs.furrow", SCM, hosted_flat);
	const double one[] = {0.5, 0.5}, more[] = {0.6, 0};
	furrow_body ball = -1;
	const struct furrow_pose pose = hosted_pose(10, 16, 101.55);
	done(furrow_body_add(world, HOSTED_BALL, &ball));
	done(furrow_place(world, ball, &pose));
	done(furrow_pour(world, 80, 128, 2, 1, one, 2, -1, false));
	refused(FURROW_INPUT, furrow_pour(world, 80, 128, 2, 1, more, 2, -1, false));
	done(furrow_body_remove(world, ball));
	done(furrow_pour(world, 80, 128, 2, 1, more, 2, -1, false));
	assert_balanced(world, 2 * lround(0.5 * UNITS) + lround(0.6 * UNITS));
	done(furrow_world_close(world));
}

TEST_PROGRAM(pour)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_poured_is_on_the_ground_and_in_the_account),
		cmocka_unit_test(the_account_holds_when_bodies_come),
		cmocka_unit_test(loose_soil_slides_to_its_repose_and_dense_soil_stands),
		cmocka_unit_test(loose_soil_bears_less_than_dense),
		cmocka_unit_test(a_rollback_takes_it_back),
		cmocka_unit_test(a_world_that_goes_on_has_the_same_ground_and_account),
		cmocka_unit_test(the_gpu_and_the_cpu_have_the_same_ground),
		cmocka_unit_test(a_volume_over_a_polygon_is_exact),
		cmocka_unit_test(what_cannot_be_is_refused_and_nothing_changes),
		cmocka_unit_test(a_body_presses_what_was_poured),
		cmocka_unit_test(pictures_show_what_was_poured),
		cmocka_unit_test(a_place_keeps_the_class_of_its_soil_map),
		cmocka_unit_test(soil_may_be_poured_below_what_hangs_above),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
