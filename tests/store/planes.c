/* The planes of a commit: offsets, disturbance and the state of the soil, with and without some of them, and what was compacted. */
#include "fixture.h"
#include "../support/program.h"

static void pages_without_dirt_leave_the_soil_alone(void **state)
{
	const char *path = in_folder("plane.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, 0));
	int32_t offset[POSTS] = {[100] = -5}, got[POSTS];
	uint8_t dirt[POSTS] = {[100] = 200}, soil[POSTS];
	unsigned present;
	struct store_page page = {{0, 1, 1}, {[PLANE_OFFSET] = offset, [PLANE_DISTURBANCE] = dirt}};
	struct store_run run = {.scene_hash = "abc", .step = 1, .time = 0.5, .state = "{}"};
	struct store_commit_result result;
	assert_ok(store_commit(store, &page, 1, &run, &result));
	page.planes[PLANE_DISTURBANCE] = NULL;
	offset[100] = -6;
	assert_ok(store_commit(store, &page, 1, &run, &result));
	assert_int_equal(result.below, -1);
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	void *const planes[PLANES] = {[PLANE_OFFSET] = got, [PLANE_DISTURBANCE] = soil};
	unsigned both = PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE);
	assert_ok(store_read_deformed(reader, page.tile, both, planes, &present));
	assert_int_equal(present, both);
	assert_int_equal(got[100], -6);
	assert_int_equal(soil[100], 200);
	double low, high;
	bool found;
	assert_ok(store_read_offset_range(reader, (struct tile){2, 0, 0}, &low, &high, &found));
	assert_true(found && low == lattice_offset_metres(-6) && high == 0);
	assert_ok(store_read_offset_range(reader, (struct tile){0, 0, 0}, &low, &high, &found));
	assert_false(found);
	store_reader_destroy(reader);
	store_close(store);
}

/* Every plane of the working level comes back, as the field has it; coarser ones have no state. */
static void assert_planes(struct store *store, const struct field *field)
{
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	for (int level = field->level; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				static int32_t texels[PLANES][POSTS], want[POSTS];
				void *planes[PLANES];
				unsigned present, all = (1u << PLANES) - 1;
				for (int plane = 0; plane < PLANES; plane++)
					memset(planes[plane] = texels[plane], 0xa5, sizeof texels[plane]);
				assert_ok(store_read_deformed(reader, (struct tile){level, x, y}, all, planes, &present));
				for (int plane = 0; plane < PLANES; plane++) {
					size_t bytes = POSTS * plane_bytes((enum plane)plane);
					memset(want, 0, sizeof want);
					if (level == field->level)
						field_tile_plane(field, (struct tile){level, x, y}, (enum plane)plane, want);
					else if (plane < PLANE_DEPOSITED)
						continue;
					assert_memory_equal(texels[plane], want, bytes);
					bool zero = true;
					for (size_t i = 0; i < bytes; i++)
						zero &= ((char *)want)[i] == 0;
					assert_int_equal((present >> plane & 1) == 0, zero);
				}
			}
	store_reader_destroy(reader);
}

static void every_plane_comes_back_the_same_bits(void **state)
{
	const char *path = in_folder("bits.furrow");
	for (int level = -2; level <= 1; level++) {
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, level));
		struct field field = field_make(level);
		struct store_commit_result result;
		for (int i = 0; i < 4; i++) {
			int64_t cx = mix((uint32_t)i, 1, 5) % extent_posts(extent.width, level);
			int64_t cy = mix((uint32_t)i, 2, 5) % extent_posts(extent.height, level);
			field_dig(&field, cx, cy, 9, (uint32_t)i);
			assert_ok(field_commit(&field, around(cx, cy, 9), store, i, &result));
		}
		assert_planes(store, &field);
		store_close(store);
		store = open_store(path, STORE_READ);
		assert_planes(store, &field);
		verified(store);
		store_close(store);
		field_free(&field);
	}
}

/* A model without state digs where one with it did: what was known of that ground is forgotten, in those tiles
 * and on the edges that others share with them, and nowhere else; the dirt stays. */
static void a_drive_without_state_forgets_it_where_it_digs(void **state)
{
	const char *path = in_folder("forget.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 64, 48, 40, 1); /* 25 tiles */
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));

	struct post_rect dug = {66, 50, 70, 80}; /* tiles 4,3 and 4,4; up to the middle of the second: both are written */
	for (int64_t y = dug.y0; y < dug.y1; y++)
		for (int64_t x = dug.x0; x < dug.x1; x++)
			field.offset[y * field.width + x] = -7;
	field.carried = PLANE_BIT(PLANE_OFFSET);
	assert_ok(field_commit(&field, dug, store, 2, &result));
	for (int plane = PLANE_DEPOSITED; plane < PLANES; plane++)
		for (int64_t y = 48; y <= 80; y++)
			for (int64_t x = 64; x <= 80; x++) {
				size_t size = plane_bytes((enum plane)plane);
				memset((char *)field.planes[plane] + (size_t)(y * field.width + x) * size, 0, size);
			}
	verified(store);
	assert_planes(store, &field);

	/* The same pages again: nothing is left to forget. */
	assert_ok(field_commit(&field, dug, store, 3, &result));
	assert_int_equal(result.tiles_written, 0);
	/* And with state once more. */
	field.carried = (1u << PLANES) - 1;
	field_dig(&field, 70, 60, 12, 2);
	assert_ok(field_commit(&field, around(70, 60, 12), store, 4, &result));
	verified(store);
	assert_planes(store, &field);
	/* All at once, where nothing beside keeps any. */
	field.carried = PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE);
	assert_ok(field_commit(&field, field_all(&field), store, 5, &result));
	struct store_numbers numbers;
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.plane_tiles[PLANE_DEPOSITED] + numbers.plane_tiles[PLANE_PLASTIC_SINKAGE], 0);
	assert_int_equal(numbers.plane_tiles[PLANE_SHEAR], 0);
	assert_true(numbers.plane_tiles[PLANE_DISTURBANCE] > 0);
	verified(store);
	store_close(store);
	field_free(&field);
}

static void what_was_compacted_is_counted(void **state)
{
	const char *path = in_folder("compacted.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	uint64_t fresh = content(store);
	assert_ok(store_set_working_level(store, 0));
	struct store_run run = {.scene_hash = "abc", .step = 1, .time = 0.5, .state = "{}"};
	struct store_commit_result result;
	struct store_numbers numbers;
	int64_t sum = 0;
	static const int64_t more[] = {5, 0, -7, INT64_C(1) << 60, -(INT64_C(1) << 50)};
	for (size_t i = 0; i < sizeof more / sizeof *more; i++) {
		run.compacted = more[i];
		assert_ok(store_commit(store, NULL, 0, &run, &result));
		sum += more[i];
		assert_int_equal(verified(store).compacted, sum);
		store_close(store);
		store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, 0));
		assert_ok(store_count(store, &numbers));
		assert_int_equal(numbers.compacted, sum);
	}
	/* More than it counts is told, and nothing of that epoch is there. */
	static const int64_t most[] = {INT64_MAX, (INT64_C(1) << 60) + (INT64_C(1) << 51)};
	for (size_t i = 0; i < 2; i++) {
		uint64_t before = content(store);
		run.compacted = most[i];
		assert_status(store_commit(store, NULL, 0, &run, &result), STATUS_FAILED);
		assert_true(content(store) == before);
	}
	run.compacted = 1;
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	assert_int_equal(verified(store).compacted, sum + 1);
	assert_ok(store_reset(store, true));
	assert_int_equal(verified(store).compacted, 0);
	assert_true(content(store) == fresh);
	store_close(store);
}

TEST_PROGRAM(planes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pages_without_dirt_leave_the_soil_alone),
		cmocka_unit_test(every_plane_comes_back_the_same_bits),
		cmocka_unit_test(a_drive_without_state_forgets_it_where_it_digs),
		cmocka_unit_test(what_was_compacted_is_counted),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
