/*
 * A tile's lowest and highest offset do not go stale: after every commit they are those of the working
 * level's posts below it, whether an edit widened them, narrowed them or undid them.
 */
#include "fixture.h"
#include "../support/program.h"

/* Of the field's posts that the tile shows; the ground beyond the field is as it was. */
static bool true_range(const struct field *field, struct tile tile, int32_t *low, int32_t *high)
{
	int64_t side = (int64_t)extent.cells << (tile.level - field->level);
	bool deformed = false;
	*low = INT32_MAX;
	*high = INT32_MIN;
	for (int64_t y = tile.y * side; y <= (tile.y + 1) * side; y++)
		for (int64_t x = tile.x * side; x <= (tile.x + 1) * side; x++) {
			bool inside = x < field->width && y < field->height;
			int32_t offset = inside ? field->offset[y * field->width + x] : 0;
			*low = offset < *low ? offset : *low;
			*high = offset > *high ? offset : *high;
			deformed |= offset != 0;
		}
	return deformed;
}

/* Returns the rows there are. */
static int check_ranges(struct store_reader *reader, const struct field *field)
{
	int rows = 0;
	for (int level = field->level; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				struct tile tile = {level, x, y};
				int32_t lowest, highest;
				double low, high;
				bool found;
				assert_ok(store_read_offset_range(reader, tile, &low, &high, &found));
				assert_int_equal(found, true_range(field, tile, &lowest, &highest));
				if (!found)
					continue;
				assert_true(low == lattice_offset_metres(lowest));
				assert_true(high == lattice_offset_metres(highest));
				rows++;
			}
	return rows;
}

/* Every post around the place to value / divisor, which 0 undoes. */
static void scale(struct field *field, int64_t cx, int64_t cy, int64_t radius, int32_t value, int32_t divisor)
{
	for (int64_t y = cy - radius; y <= cy + radius; y++)
		for (int64_t x = cx - radius; x <= cx + radius; x++) {
			int32_t *offset = &field->offset[y * field->width + x];
			*offset = (int32_t)((int64_t)*offset * value / divisor);
		}
}

static void ranges_follow_every_edit(void **state)
{
	const char *path = in_folder("ranges.furrow");
	for (int level = -2; level <= 0; level++) {
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, level));
		struct field field = field_make(level);
		struct store_reader *reader;
		assert_ok(store_reader_create(store, &reader));
		/* On a corner of four tiles, and away from it. */
		const int64_t places[][2] = {{32, 32}, {24, 40}, {43, 20}};
		struct store_commit_result result;
		int rows = 0, step = 0;
		for (int i = 0; i < 3; i++) {
			int64_t x = places[i][0], y = places[i][1];
			field_dig(&field, x, y, 5, (uint32_t)i);
			assert_ok(field_commit(&field, around(x, y, 5), store, step++, &result));
			rows = check_ranges(reader, &field);
			assert_true(rows > 2);
			/* Deeper, then back to a third of it, then partly filled. */
			const int32_t factors[][2] = {{3, 1}, {1, 9}, {-1, 1}};
			for (int k = 0; k < 3; k++) {
				scale(&field, x, y, 5, factors[k][0], factors[k][1]);
				assert_ok(field_commit(&field, around(x, y, 5), store, step++, &result));
				assert_true(check_ranges(reader, &field) > 2);
			}
			scale(&field, x, y, 2, 0, 1);
			assert_ok(field_commit(&field, around(x, y, 5), store, step++, &result));
			check_ranges(reader, &field);
		}
		rows = check_ranges(reader, &field);
		for (int i = 0; i < 3; i++) {
			int64_t x = places[i][0], y = places[i][1];
			scale(&field, x, y, 5, 0, 1);
			assert_ok(field_commit(&field, around(x, y, 5), store, step++, &result));
			int left = check_ranges(reader, &field);
			assert_true(left <= rows);
			rows = left;
		}
		assert_int_equal(rows, 0);
		verified(store);
		field_free(&field);
		store_reader_destroy(reader);
		store_close(store);
	}
}

TEST_PROGRAM(ranges)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ranges_follow_every_edit),
	};
	return cmocka_run_group_tests_name("ranges", tests, folder_make, folder_remove);
}
