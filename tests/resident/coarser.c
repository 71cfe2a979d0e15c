/*
 * A coarser level goes stale after an edit: never. Law 4 where it can be seen before a commit: a coarser tile in
 * a slot is the decimation of the working level, whether it was there when the ground changed or came later, and
 * whatever of the change is in a slot, in the queue or in the store by then.
 */
#include "rig.h"
#include "../support/program.h"

enum { LEVEL = -1, SIDE = 8 * CELLS + 1 };

static void read_tile(struct rig *rig, struct tile tile, int32_t *offset, uint8_t *dirt)
{
	uint32_t slot;
	size_t posts = (CELLS + 1) * (CELLS + 1);
	must(page_cache_pin(rig->ground.cache, tile_key(tile), &slot));
	memset(offset, 0, posts * sizeof *offset);
	memset(dirt, 0, posts);
	if (rig->ground.host != NULL) {
		struct host_slot held;
		resident_host_get(rig->ground.host, slot, &held);
		if (held.planes[PLANE_OFFSET] != NULL)
			memcpy(offset, held.planes[PLANE_OFFSET], posts * sizeof *offset);
		if (held.planes[PLANE_DISTURBANCE] != NULL)
			memcpy(dirt, held.planes[PLANE_DISTURBANCE], posts);
	} else if (gpu_slots_get(rig->ground.slots, slot)->target != NULL)
		must(staged_read_deform(rig->ground.gpu, rig->ground.slots, CELLS, slot, offset, dirt));
	page_cache_unpin(rig->ground.cache, tile_key(tile));
}

/* The whole working level, as it can be read now. */
static void read_working(struct rig *rig, int32_t *offsets, uint8_t *dirts)
{
	int32_t offset[(CELLS + 1) * (CELLS + 1)];
	uint8_t dirt[(CELLS + 1) * (CELLS + 1)];
	for (uint32_t ty = 0; ty < 8; ty++)
		for (uint32_t tx = 0; tx < 8; tx++) {
			read_tile(rig, (struct tile){LEVEL, tx, ty}, offset, dirt);
			for (int y = 0; y <= CELLS; y++)
				for (int x = 0; x <= CELLS; x++) {
					size_t at = (ty * CELLS + (size_t)y) * SIDE + tx * CELLS + (size_t)x;
					offsets[at] = offset[y * (CELLS + 1) + x];
					dirts[at] = dirt[y * (CELLS + 1) + x];
				}
		}
}

static size_t check_coarser(struct rig *rig, const int32_t *offsets, const uint8_t *dirts)
{
	int32_t offset[(CELLS + 1) * (CELLS + 1)];
	uint8_t dirt[(CELLS + 1) * (CELLS + 1)];
	size_t deformed = 0;
	for (int level = 0; level <= 2; level++)
		for (uint32_t ty = 0; ty < extent_tiles_y(&extent, level); ty++)
			for (uint32_t tx = 0; tx < extent_tiles_x(&extent, level); tx++) {
				read_tile(rig, (struct tile){level, tx, ty}, offset, dirt);
				for (uint32_t y = 0; y <= CELLS; y++)
					for (uint32_t x = 0; x <= CELLS; x++) {
						size_t at = ((size_t)(ty * CELLS + y) << (level - LEVEL)) * SIDE +
							    ((size_t)(tx * CELLS + x) << (level - LEVEL));
						assert_int_equal(offset[y * (CELLS + 1) + x], offsets[at]);
						assert_int_equal(dirt[y * (CELLS + 1) + x], dirts[at]);
						deformed += offsets[at] != 0;
					}
			}
	return deformed;
}

static void in_this_home(uint32_t slots, bool host)
{
	static int32_t offsets[SIDE * SIDE], untouched[SIDE * SIDE];
	static uint8_t dirts[SIDE * SIDE], clean[SIDE * SIDE];
	const char *path = support_path("coarser.furrow");
	struct rig rig;
	rig_open(&rig, path, &(struct rig_params){
		.ground = support_hills, .level = LEVEL, .slots = slots, .commit_age = 0.01, .pyramid = true, .host = host,
	});
	/* Coarser tiles first: with slots for all they stay, and follow every change. */
	check_coarser(&rig, untouched, clean);
	for (int step = 0; step < 240; step++) {
		assert_true(roll(&rig, step));
		end_step(&rig);
		if (step % 40 == 39) {
			read_working(&rig, offsets, dirts);
			assert_true(check_coarser(&rig, offsets, dirts) > 10);
		}
	}
	must(page_cache_flush(rig.ground.cache, rig.record));
	read_working(&rig, offsets, dirts);
	check_coarser(&rig, offsets, dirts);
	rig_close(&rig);
	support_verify(path);
	double *stored = support_quanta(path, LEVEL, (struct post_rect){0, 0, SIDE, SIDE});
	for (size_t i = 0; i < SIDE * SIDE; i++)
		assert_true(stored[i] == offsets[i]);
	free(stored);
}

/* Host memory first: without GL the other one skips the test. */
static void world_and_compare(uint32_t slots)
{
	in_this_home(slots, true);
	in_this_home(slots, false);
}

static void coarser_tiles_that_stay_follow_every_change(void **state)
{
	world_and_compare(96);
}

static void coarser_tiles_that_come_late_have_every_change(void **state)
{
	world_and_compare(6);
}

TEST_PROGRAM(coarser)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(coarser_tiles_that_stay_follow_every_change),
		cmocka_unit_test(coarser_tiles_that_come_late_have_every_change),
	};
	return cmocka_run_group_tests_name("coarser", tests, support_enter, support_leave);
}
