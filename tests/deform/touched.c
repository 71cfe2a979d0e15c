/* The set of touched posts is what a plain field of bits would be. */
#include "ground.h"

#include "deform/schedule/touched.h"
#include "../support/program.h"

#define SIDE_BLOCKS 7
#define FIELD (SIDE_BLOCKS * SOIL_BLOCK)

/* A square of posts somewhere in the world, the set of which is compared. */
struct field {
	struct touched touched;
	int64_t x0, y0; /* of its first post: of a block */
	bool bits[FIELD][FIELD];
};

static struct field fields[2];

static int64_t below(int64_t n)
{
	return (int64_t)(any_word() % (uint32_t)n);
}

static void begin(struct field *field, int64_t block_x, int64_t block_y)
{
	memset(field->bits, 0, sizeof field->bits);
	field->x0 = block_x * SOIL_BLOCK;
	field->y0 = block_y * SOIL_BLOCK;
}

/* Around the field too; whole blocks, single posts and rows now and then. */
static struct post_rect any_rect(const struct field *field)
{
	int64_t x = below(FIELD + 40) - 20, y = below(FIELD + 40) - 20, width = 1 + below(50), height = 1 + below(50);
	switch (any_word() % 6) {
	case 0:
		x = below(SIDE_BLOCKS) * SOIL_BLOCK;
		y = below(SIDE_BLOCKS) * SOIL_BLOCK;
		width = height = SOIL_BLOCK << below(2);
		break;
	case 1:
		width = 1;
		break;
	case 2:
		width = height = 1;
		break;
	case 3:
		height = below(2); /* or nothing */
		break;
	default:
		break;
	}
	x += field->x0;
	y += field->y0;
	return (struct post_rect){x, y, x + width, y + height};
}

static bool inside(const struct field *field, int64_t x, int64_t y)
{
	return x >= field->x0 && y >= field->y0 && x < field->x0 + FIELD && y < field->y0 + FIELD && x >= 0 && y >= 0;
}

static void put(struct field *field, struct post_rect rect)
{
	assert_ok(deform_touched_add(&field->touched, rect));
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			if (inside(field, x, y))
				field->bits[y - field->y0][x - field->x0] = true;
}

static bool any(const struct field *field, struct post_rect rect)
{
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			if (inside(field, x, y) && field->bits[y - field->y0][x - field->x0])
				return true;
	return false;
}

static void assert_as_the_bits(const struct field *field)
{
	for (int64_t y = 0; y < FIELD; y++)
		for (int64_t x = 0; x < FIELD; x++) {
			int64_t at_x = field->x0 + x, at_y = field->y0 + y;
			bool is = deform_touched_any(&field->touched, (struct post_rect){at_x, at_y, at_x + 1, at_y + 1});
			if (is != field->bits[y][x])
				fail_msg("post %lld, %lld: %d", (long long)at_x, (long long)at_y, is);
		}
	for (int k = 0; k < 200; k++) {
		struct post_rect rect = any_rect(field);
		/* The field does not know what lies beyond it. */
		const struct post_rect all = {field->x0, field->y0, field->x0 + FIELD, field->y0 + FIELD};
		assert_int_equal(deform_touched_any(&field->touched, post_rect_intersect(rect, all)), any(field, rect));
	}
}

/* A block inside the field whose neighbours are in it, too, or lie beyond the world. */
static struct soil_block any_block(const struct field *field)
{
	int64_t x = field->x0 == 0 ? below(SIDE_BLOCKS - 1) : 1 + below(SIDE_BLOCKS - 2);
	int64_t y = field->y0 == 0 ? below(SIDE_BLOCKS - 1) : 1 + below(SIDE_BLOCKS - 2);
	return (struct soil_block){field->x0 / SOIL_BLOCK + x, field->y0 / SOIL_BLOCK + y};
}

static bool of_parts(uint32_t parts, int64_t x, int64_t y)
{
	return parts >> (y / TOUCHED_PART * (SOIL_BLOCK / TOUCHED_PART) + x / TOUCHED_PART) & 1;
}

static void grow(struct field *field, const struct field *from)
{
	static bool grown[SOIL_BLOCK][SOIL_BLOCK];
	struct soil_block block = any_block(field);
	int64_t by = any_word() % 8 == 0 ? below(SOIL_BLOCK) : below(9);
	uint32_t parts = any_word() % 4 == 0 ? TOUCHED_PARTS : 1u << below(16) | 1u << below(16);
	for (int64_t y = 0; y < SOIL_BLOCK; y++)
		for (int64_t x = 0; x < SOIL_BLOCK; x++) {
			int64_t at_x = block.x * SOIL_BLOCK + x, at_y = block.y * SOIL_BLOCK + y;
			struct post_rect near = {at_x - by, at_y - by, at_x + by + 1, at_y + by + 1};
			grown[y][x] = of_parts(parts, x, y) && any(from, near);
		}
	assert_ok(deform_touched_grow(&field->touched, &from->touched, block, by, parts));
	for (int64_t y = 0; y < SOIL_BLOCK; y++)
		for (int64_t x = 0; x < SOIL_BLOCK; x++)
			field->bits[block.y * SOIL_BLOCK + y - field->y0][block.x * SOIL_BLOCK + x - field->x0] |= grown[y][x];
}

/* At the world's corner, along its edge, inside, and as far out as posts go. */
static void it_is_what_a_field_of_bits_is(void **state)
{
	static const int64_t firsts[][2] = {{0, 0}, {0, 5}, {900, 0}, {31, 77}, {INT64_C(1) << 34, (INT64_C(1) << 40) + 3}};
	(void)state;
	test_seed = 11;
	for (size_t i = 0; i < sizeof firsts / sizeof *firsts; i++) {
		for (int round = 0; round < 4; round++) {
			for (int k = 0; k < 2; k++)
				begin(&fields[k], firsts[i][0], firsts[i][1]);
			for (int n = 0; n < 40; n++) {
				struct field *field = &fields[any_word() % 2];
				if (any_word() % 3 == 0)
					put(field, any_rect(field));
				else
					grow(field, &fields[any_word() % 2]);
				if (n % 10 == 9)
					assert_as_the_bits(field);
			}
			for (int k = 0; k < 2; k++) {
				assert_as_the_bits(&fields[k]);
				deform_touched_clear(&fields[k].touched);
			}
		}
		for (int k = 0; k < 2; k++) {
			begin(&fields[k], firsts[i][0], firsts[i][1]);
			assert_as_the_bits(&fields[k]);
			deform_touched_finish(&fields[k].touched);
		}
	}
}

/* A part is where its bit says. */
static void parts_are_numbered_from_the_south_west(void **state)
{
	(void)state;
	for (int part = 0; part < 16; part++) {
		struct post_rect rect = deform_touched_part((struct soil_block){3, 5}, part);
		assert_int_equal(rect.x0, 96 + part % 4 * 8);
		assert_int_equal(rect.y0, 160 + part / 4 * 8);
		assert_true(rect.x1 == rect.x0 + 8 && rect.y1 == rect.y0 + 8);
		begin(&fields[0], 0, 0);
		put(&fields[0], (struct post_rect){0, 0, FIELD, FIELD});
		assert_ok(deform_touched_grow(&fields[1].touched, &fields[0].touched, (struct soil_block){3, 5}, 1, 1u << part));
		begin(&fields[1], 0, 0);
		for (int64_t y = rect.y0; y < rect.y1; y++)
			for (int64_t x = rect.x0; x < rect.x1; x++)
				fields[1].bits[y][x] = true;
		assert_as_the_bits(&fields[1]);
		deform_touched_finish(&fields[0].touched);
		deform_touched_finish(&fields[1].touched);
	}
}

/* Blocks that are whole from the start share their rows, and never give them to one that is not. */
static void whole_blocks_take_no_rows(void **state)
{
	struct touched touched = {.count = 0};
	(void)state;
	for (int64_t k = 0; k < 300; k++)
		assert_ok(deform_touched_add(&touched, (struct post_rect){k * 64, 32, k * 64 + 32, 64}));
	assert_true(touched.blocks.count == 300 && touched.count == 1);
	assert_ok(deform_touched_add(&touched, (struct post_rect){32, 32, 33, 33}));
	assert_ok(deform_touched_add(&touched, (struct post_rect){64, 32, 65, 33}));
	assert_true(touched.blocks.count == 301 && touched.count == 2);
	assert_true(deform_touched_any(&touched, (struct post_rect){32, 32, 33, 33}));
	assert_true(!deform_touched_any(&touched, (struct post_rect){33, 32, 64, 64}));
	assert_true(deform_touched_any(&touched, (struct post_rect){33, 32, 65, 64}));
	assert_true(!deform_touched_any(&touched, (struct post_rect){0, 0, 64 * 300, 32}));
	deform_touched_finish(&touched);
}

TEST_PROGRAM(touched)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_is_what_a_field_of_bits_is),
		cmocka_unit_test(parts_are_numbered_from_the_south_west),
		cmocka_unit_test(whole_blocks_take_no_rows),
	};
	return cmocka_run_group_tests_name("deform/touched", tests, NULL, NULL);
}
