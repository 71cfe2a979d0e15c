/* Map rasters: the values and the shade that a map finds in a store, pixel by pixel. No GL. */
#include "dug.h"
#include "../support/program.h"

/* Ruts before heaps, then the larger one. */
static double shown_of(double value, double other)
{
	if ((value <= -0.001) != (other <= -0.001))
		return value < other ? value : other;
	return fabs(value) > fabs(other) ? value : other;
}

/* From the function alone: what is shown of the posts that are nearer to the pixel's own than to others'; what is beyond the
 * last pixel's is that one's. */
static double largest_within(const struct chart_raster_params *params, int64_t px, int64_t py, int from)
{
	int shift = params->level - from;
	int64_t half = shift > 0 ? (int64_t)1 << (shift - 1) : 0, size = (int64_t)1 << shift, fine = (int64_t)1 << (from - LEVEL);
	int64_t width = extent_posts(extent.width, from), height = extent_posts(extent.height, from);
	bool last_x = px + 1 == extent_posts(extent.width, params->level), last_y = py + 1 == extent_posts(extent.height, params->level);
	double largest = 0;
	for (int64_t y = py * size - half; y < (last_y ? height : py * size - half + size); y++)
		for (int64_t x = px * size - half; x < (last_x ? width : px * size - half + size); x++) {
			double value = x < 0 || y < 0 ? 0 : lattice_offset_metres(quanta(x * fine, y * fine));
			largest = shown_of(value, largest);
		}
	return largest;
}

static void check_values(const struct chart_raster_params *params, int from)
{
	struct chart_raster raster;
	must(chart_raster_create(params, &raster));
	assert_int_equal(raster.width, params->rect.x1 - params->rect.x0);
	assert_true(raster.spacing == extent_spacing(&extent, params->level));
	for (uint32_t y = 0; y < raster.height; y++)
		for (uint32_t x = 0; x < raster.width; x++) {
			double wanted = largest_within(params, params->rect.x0 + x, params->rect.y0 + y, from);
			assert_true(raster.values[y * raster.width + x] == (float)wanted);
		}
	chart_raster_finish(&raster);
}

static void a_pixel_has_the_largest_value_within_it(void **state)
{
	for (int level = LEVEL; level <= extent_coarsest(&extent); level++) {
		struct chart_raster_params params = asked(level, STORE_OFFSET);
		check_values(&params, LEVEL);
	}
	/* Of any window. */
	uint32_t seed = 1;
	for (int i = 0; i < 40; i++) {
		struct chart_raster_params params = asked(LEVEL + i % 5, STORE_OFFSET);
		for (int k = 0; k < 2; k++) {
			seed = seed * 1664525 + 1013904223;
			int64_t *low = k == 0 ? &params.rect.x0 : &params.rect.y0, *high = k == 0 ? &params.rect.x1 : &params.rect.y1;
			*low = (seed >> 8) % *high;
			*high = *low + 1 + (seed >> 20) % (*high - *low);
		}
		check_values(&params, LEVEL);
	}
}

static void with_fewer_tiles_a_coarser_level_is_looked_at(void **state)
{
	struct chart_raster_params params = asked(2, STORE_OFFSET);
	/* Of level -1 there are this many; it is the finest that has no more. */
	size_t tiles[3] = {0, 0, 0};
	for (int level = -2; level <= 0; level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				double low, high;
				bool found;
				must(store_read_offset_range(reader, (struct tile){level, x, y}, &low, &high, &found));
				tiles[level + 2] += found;
			}
	assert_true(tiles[0] > tiles[1] && tiles[1] > tiles[2] && tiles[2] > 1);
	for (int level = -2; level <= 0; level++) {
		params.tiles_most = tiles[level + 2];
		check_values(&params, level);
		if (level > -2) {
			params.tiles_most = tiles[level + 1] - 1;
			check_values(&params, level);
		}
	}
}

static void a_map_finer_than_what_is_stored_is_interpolated(void **state)
{
	struct chart_raster_params params = asked(LEVEL - 2, STORE_OFFSET);
	params.rect = (struct post_rect){390, 370, 650, 500};
	struct chart_raster raster;
	must(chart_raster_create(&params, &raster));
	double *values = calloc((size_t)raster.width * raster.height, sizeof *values);
	must(store_read_posts(reader, STORE_OFFSET, params.level, params.rect, values));
	bool between = false;
	for (size_t i = 0; i < (size_t)raster.width * raster.height; i++) {
		assert_true(raster.values[i] == (isnan(values[i]) ? 0 : (float)values[i]));
		between |= values[i] < -0.01 && values[i] > -0.12;
	}
	assert_true(between);
	free(values);
	chart_raster_finish(&raster);
}

/* Also where no offset is; and nowhere else. */
static void the_soils_state_is_found_wherever_it_is(void **state)
{
	for (int level = LEVEL; level <= LEVEL + 3; level++) {
		struct chart_raster_params params = asked(level, STORE_PLASTIC_SINKAGE);
		struct chart_raster raster;
		must(chart_raster_create(&params, &raster));
		int64_t at_x = 20 * CELLS + 200 % (CELLS + 1), at_y = 2 * CELLS + 200 / (CELLS + 1);
		int shift = level - LEVEL;
		int64_t half = shift > 0 ? 1 << (shift - 1) : 0;
		int64_t pixel = ((at_y + half) >> shift) * raster.width + ((at_x + half) >> shift);
		assert_true(raster.values[pixel] == 0.25f);
		double size, low, high;
		must(chart_raster_spread(&raster, 1, &size, &low, &high));
		assert_true(low == 0 && high == 1 && size == 1);
		chart_raster_finish(&raster);
	}
}

static void holes_are_holes_and_the_rest_is_lit(void **state)
{
	for (int level = LEVEL; level <= 1; level++) {
		struct chart_raster_params params = asked(level, STORE_OFFSET);
		struct chart_raster raster;
		must(chart_raster_create(&params, &raster));
		double *base = calloc((size_t)raster.width * raster.height, sizeof *base);
		must(store_read_posts(reader, STORE_BASE, level, params.rect, base));
		for (size_t i = 0; i < (size_t)raster.width * raster.height; i++) {
			assert_int_equal(isnan(raster.shade[i]), isnan(base[i]));
			/* The ground is level: what is not beside an offset has that shade. */
			if (!isnan(base[i]) && level > LEVEL)
				assert_true(raster.shade[i] == (float)raster.flat);
		}
		free(base);
		chart_raster_finish(&raster);
	}
}

static void slopes_of_ruts_are_added_to_the_grounds(void **state)
{
	struct chart_raster_params params = asked(LEVEL, STORE_OFFSET);
	struct chart_raster raster;
	must(chart_raster_create(&params, &raster));
	/* The broad rut's floor is level, its west wall falls to the east, its east wall rises. */
	assert_true(raster.shade[150 * raster.width + 130] == (float)raster.flat);
	assert_true(raster.shade[150 * raster.width + 100] < raster.flat - 0.01);
	assert_true(raster.shade[150 * raster.width + 159] > raster.flat + 0.01);
	float west = raster.shade[150 * raster.width + 100];
	chart_raster_finish(&raster);
	params.exaggerate = 2;
	must(chart_raster_create(&params, &raster));
	assert_true(raster.shade[150 * raster.width + 100] < west - 0.01f);
	chart_raster_finish(&raster);
}

static void most_values_are_no_larger_than_the_spread(void **state)
{
	enum { SIDE = 100 };
	static float values[SIDE * SIDE];
	struct chart_raster raster = {.width = SIDE, .height = SIDE, .values = values};
	double size, low, high;
	must(chart_raster_spread(&raster, 0.9, &size, &low, &high));
	assert_true(size == 0 && low == 0 && high == 0);
	for (int i = 0; i < SIDE * SIDE / 2; i++)
		values[2 * i] = (float)(i + 1) * (i % 3 == 0 ? -0.001f : 0.001f);
	must(chart_raster_spread(&raster, 0.9, &size, &low, &high));
	assert_true(fabs(size - 4.5) < 0.03 && fabs(low + 4.999) < 1e-5 && fabs(high - 5) < 1e-5);
	must(chart_raster_spread(&raster, 1, &size, &low, &high));
	assert_true(fabs(size - 5) < 1e-5);
}

static void lines_are_widened_by_a_pixel(void **state)
{
	struct chart_raster_params params = asked(2, STORE_OFFSET);
	struct chart_raster raster;
	must(chart_raster_create(&params, &raster));
	float *was = malloc((size_t)raster.width * raster.height * sizeof *was);
	memcpy(was, raster.values, (size_t)raster.width * raster.height * sizeof *was);
	assert_true(raster.rut == raster.spacing);
	must(chart_raster_widen(&raster));
	assert_true(raster.rut == 3 * raster.spacing);
	for (int64_t y = 0; y < raster.height; y++)
		for (int64_t x = 0; x < raster.width; x++) {
			float largest = 0;
			for (int i = 0; i < 9; i++) {
				int64_t px = x + i % 3 - 1, py = y + i / 3 - 1;
				if (px >= 0 && py >= 0 && px < raster.width && py < raster.height)
					largest = (float)shown_of(was[py * raster.width + px], largest);
			}
			assert_true(raster.values[y * raster.width + x] == largest);
		}
	free(was);
	chart_raster_finish(&raster);
}

TEST_PROGRAM(raster)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_pixel_has_the_largest_value_within_it),
		cmocka_unit_test(with_fewer_tiles_a_coarser_level_is_looked_at),
		cmocka_unit_test(a_map_finer_than_what_is_stored_is_interpolated),
		cmocka_unit_test(the_soils_state_is_found_wherever_it_is),
		cmocka_unit_test(holes_are_holes_and_the_rest_is_lit),
		cmocka_unit_test(slopes_of_ruts_are_added_to_the_grounds),
		cmocka_unit_test(most_values_are_no_larger_than_the_spread),
		cmocka_unit_test(lines_are_widened_by_a_pixel),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
