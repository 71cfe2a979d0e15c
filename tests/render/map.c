/* Maps: what a survey finds in a store, and where a sheet puts it. No GL. */
#include "../support.h"

#include "render/internal.h"

#define LEVEL (-2)
#define CELLS 32

static const struct extent extent = {201, 150, 2, CELLS};
static struct store *store;
static struct store_reader *reader;

/* Metres at a post of the working level, half a metre apart: a rut one post wide, a broad one, a heap, one deep post. */
static double dug(int64_t x, int64_t y)
{
	if (x == 333 && y > 40)
		return -0.25;
	if (y == 596 && x < 4) /* beyond the last pixel's own half, at coarse levels */
		return 0.5;
	if (y == 0 || x == 800) /* at the terrain's edges */
		return 0.03125;
	if (x >= 100 && x < 160 && y >= 100 && y < 200)
		return -0.125;
	if (x >= 500 && x < 540 && y >= 300 && y < 420)
		return 0.0625;
	return x == 700 && y == 77 ? -1 : 0;
}

static double level_ground(int64_t x, int64_t y)
{
	return x >= 60 && x < 70 && y >= 20 && y < 30 ? (double)NAN : 500;
}

static bool is_hole(int64_t x, int64_t y) /* of level 0 */
{
	return isnan(level_ground(x, y));
}

/* No offset lies in holes. */
static int32_t quanta(int64_t x, int64_t y)
{
	bool near_hole = is_hole((x + 3) / 4, (y + 3) / 4) || is_hole(x / 4, y / 4) || is_hole((x + 3) / 4, y / 4) ||
			 is_hole(x / 4, (y + 3) / 4);
	int64_t width = extent_posts(extent.width, LEVEL), height = extent_posts(extent.height, LEVEL);
	return near_hole || x >= width || y >= height ? 0 : (int32_t)lattice_offset(dug(x, y));
}

static void commit(void)
{
	static int32_t posts[16][(CELLS + 1) * (CELLS + 1)];
	static int32_t pressed[(CELLS + 1) * (CELLS + 1)];
	struct store_run run = {.scene_hash = "00", .state = "{}"};
	struct store_commit_result result;
	must(store_set_working_level(store, LEVEL));
	for (uint32_t y = 0; y < extent_tiles_y(&extent, LEVEL); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, LEVEL); x++) {
			struct store_page page = {.tile = {LEVEL, x, y}};
			int32_t *to = posts[0];
			for (int64_t i = 0; i < (CELLS + 1) * (CELLS + 1); i++) {
				to[i] = quanta(x * CELLS + i % (CELLS + 1), y * CELLS + i / (CELLS + 1));
				pressed[i] = to[i] < 0 ? -to[i] : 0;
			}
			page.planes[PLANE_OFFSET] = to;
			/* The state of the soil is also where no offset is. */
			if (x == 20 && y == 2) {
				for (int64_t i = 0; i < (CELLS + 1) * (CELLS + 1); i++)
					pressed[i] = i == 40 * 5 ? 1 << 18 : 0;
			}
			page.planes[PLANE_PLASTIC_SINKAGE] = pressed;
			must(store_commit(store, &page, 1, &run, &result));
		}
}

static int enter(void **state)
{
	if (support_enter(state) != 0)
		return -1;
	support_store(support_path("map.furrow"), extent, level_ground);
	must(store_open(support_path("map.furrow"), &(struct store_options){.mode = STORE_WRITE}, &store));
	commit();
	must(store_reader_create(store, &reader));
	return 0;
}

static int leave(void **state)
{
	store_reader_destroy(reader);
	store_close(store);
	return support_leave(state);
}

static struct render_map_raster_params asked(int level, enum store_layer layer)
{
	struct render_map_raster_params params = {
		.reader = reader,
		.meta = store_meta(store),
		.deformed = true,
		.working = LEVEL,
		.layer = layer,
		.level = level,
		.rect = {0, 0, extent_posts(extent.width, level), extent_posts(extent.height, level)},
		.exaggerate = 1,
	};
	render_sun_of(RENDER_AZIMUTH, RENDER_ALTITUDE, &params.sun);
	return params;
}

/* From the function alone: the largest of the posts that are nearer to the pixel's own than to others'; what is beyond the
 * last pixel's is that one's. */
static double largest_within(const struct render_map_raster_params *params, int64_t px, int64_t py, int from)
{
	int shift = params->level - from;
	int64_t half = shift > 0 ? (int64_t)1 << (shift - 1) : 0, size = (int64_t)1 << shift, fine = (int64_t)1 << (from - LEVEL);
	int64_t width = extent_posts(extent.width, from), height = extent_posts(extent.height, from);
	bool last_x = px + 1 == extent_posts(extent.width, params->level), last_y = py + 1 == extent_posts(extent.height, params->level);
	double largest = 0;
	for (int64_t y = py * size - half; y < (last_y ? height : py * size - half + size); y++)
		for (int64_t x = px * size - half; x < (last_x ? width : px * size - half + size); x++) {
			double value = x < 0 || y < 0 ? 0 : lattice_offset_metres(quanta(x * fine, y * fine));
			largest = fabs(value) > fabs(largest) ? value : largest;
		}
	return largest;
}

static void check_values(const struct render_map_raster_params *params, int from)
{
	struct render_map_raster raster;
	must(render_map_raster_create(params, &raster));
	assert_int_equal(raster.width, params->rect.x1 - params->rect.x0);
	assert_true(raster.spacing == extent_spacing(&extent, params->level));
	for (uint32_t y = 0; y < raster.height; y++)
		for (uint32_t x = 0; x < raster.width; x++) {
			double wanted = largest_within(params, params->rect.x0 + x, params->rect.y0 + y, from);
			assert_true(raster.values[y * raster.width + x] == (float)wanted);
		}
	render_map_raster_finish(&raster);
}

static void a_pixel_has_the_largest_value_within_it(void **state)
{
	for (int level = LEVEL; level <= extent_coarsest(&extent); level++) {
		struct render_map_raster_params params = asked(level, STORE_OFFSET);
		check_values(&params, LEVEL);
	}
	/* Of any window. */
	uint32_t seed = 1;
	for (int i = 0; i < 40; i++) {
		struct render_map_raster_params params = asked(LEVEL + i % 5, STORE_OFFSET);
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
	struct render_map_raster_params params = asked(2, STORE_OFFSET);
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
	struct render_map_raster_params params = asked(LEVEL - 2, STORE_OFFSET);
	params.rect = (struct post_rect){390, 370, 650, 500};
	struct render_map_raster raster;
	must(render_map_raster_create(&params, &raster));
	double *values = calloc((size_t)raster.width * raster.height, sizeof *values);
	must(store_read_posts(reader, STORE_OFFSET, params.level, params.rect, values));
	bool between = false;
	for (size_t i = 0; i < (size_t)raster.width * raster.height; i++) {
		assert_true(raster.values[i] == (isnan(values[i]) ? 0 : (float)values[i]));
		between |= values[i] < -0.01 && values[i] > -0.12;
	}
	assert_true(between);
	free(values);
	render_map_raster_finish(&raster);
}

/* Also where no offset is; and nowhere else. */
static void the_soils_state_is_found_wherever_it_is(void **state)
{
	for (int level = LEVEL; level <= LEVEL + 3; level++) {
		struct render_map_raster_params params = asked(level, STORE_PLASTIC_SINKAGE);
		struct render_map_raster raster;
		must(render_map_raster_create(&params, &raster));
		int64_t at_x = 20 * CELLS + 200 % (CELLS + 1), at_y = 2 * CELLS + 200 / (CELLS + 1);
		int shift = level - LEVEL;
		int64_t half = shift > 0 ? 1 << (shift - 1) : 0;
		int64_t pixel = ((at_y + half) >> shift) * raster.width + ((at_x + half) >> shift);
		assert_true(raster.values[pixel] == 0.25f);
		double size, low, high;
		must(render_map_raster_spread(&raster, 1, &size, &low, &high));
		assert_true(low == 0 && high == 1 && size == 1);
		render_map_raster_finish(&raster);
	}
}

static void holes_are_holes_and_the_rest_is_lit(void **state)
{
	for (int level = LEVEL; level <= 1; level++) {
		struct render_map_raster_params params = asked(level, STORE_OFFSET);
		struct render_map_raster raster;
		must(render_map_raster_create(&params, &raster));
		double *base = calloc((size_t)raster.width * raster.height, sizeof *base);
		must(store_read_posts(reader, STORE_BASE, level, params.rect, base));
		for (size_t i = 0; i < (size_t)raster.width * raster.height; i++) {
			assert_int_equal(isnan(raster.shade[i]), isnan(base[i]));
			/* The ground is level: what is not beside an offset has that shade. */
			if (!isnan(base[i]) && level > LEVEL)
				assert_true(raster.shade[i] == (float)raster.flat);
		}
		free(base);
		render_map_raster_finish(&raster);
	}
}

static void slopes_of_ruts_are_added_to_the_grounds(void **state)
{
	struct render_map_raster_params params = asked(LEVEL, STORE_OFFSET);
	struct render_map_raster raster;
	must(render_map_raster_create(&params, &raster));
	/* The broad rut's floor is level, its west wall falls to the east, its east wall rises. */
	assert_true(raster.shade[150 * raster.width + 130] == (float)raster.flat);
	assert_true(raster.shade[150 * raster.width + 100] < raster.flat - 0.01);
	assert_true(raster.shade[150 * raster.width + 159] > raster.flat + 0.01);
	float west = raster.shade[150 * raster.width + 100];
	render_map_raster_finish(&raster);
	params.exaggerate = 2;
	must(render_map_raster_create(&params, &raster));
	assert_true(raster.shade[150 * raster.width + 100] < west - 0.01f);
	render_map_raster_finish(&raster);
}

static void most_values_are_no_larger_than_the_spread(void **state)
{
	enum { SIDE = 100 };
	static float values[SIDE * SIDE];
	struct render_map_raster raster = {.width = SIDE, .height = SIDE, .values = values};
	double size, low, high;
	must(render_map_raster_spread(&raster, 0.9, &size, &low, &high));
	assert_true(size == 0 && low == 0 && high == 0);
	for (int i = 0; i < SIDE * SIDE / 2; i++)
		values[2 * i] = (float)(i + 1) * (i % 3 == 0 ? -0.001f : 0.001f);
	must(render_map_raster_spread(&raster, 0.9, &size, &low, &high));
	assert_true(fabs(size - 4.5) < 0.03 && fabs(low + 4.999) < 1e-5 && fabs(high - 5) < 1e-5);
	must(render_map_raster_spread(&raster, 1, &size, &low, &high));
	assert_true(fabs(size - 5) < 1e-5);
}

static void lines_are_widened_by_a_pixel(void **state)
{
	struct render_map_raster_params params = asked(2, STORE_OFFSET);
	struct render_map_raster raster;
	must(render_map_raster_create(&params, &raster));
	float *was = malloc((size_t)raster.width * raster.height * sizeof *was);
	memcpy(was, raster.values, (size_t)raster.width * raster.height * sizeof *was);
	must(render_map_raster_widen(&raster));
	for (int64_t y = 0; y < raster.height; y++)
		for (int64_t x = 0; x < raster.width; x++) {
			float largest = 0;
			for (int i = 0; i < 9; i++) {
				int64_t px = x + i % 3 - 1, py = y + i / 3 - 1;
				if (px >= 0 && py >= 0 && px < raster.width && py < raster.height &&
				    fabsf(was[py * raster.width + px]) > fabsf(largest))
					largest = was[py * raster.width + px];
			}
			assert_true(raster.values[y * raster.width + x] == largest);
		}
	free(was);
	render_map_raster_finish(&raster);
}

/* --- sheets --- */

static const uint8_t *at(const struct render_canvas *canvas, int64_t x, int64_t y)
{
	return canvas->pixels + 4 * ((size_t)y * canvas->width + (size_t)x);
}

static bool is_dark(const struct render_canvas *canvas, int64_t x, int64_t y)
{
	return at(canvas, x, y)[0] < 130 && at(canvas, x, y)[2] < 130;
}

/* Whether these letters stand somewhere below the map, or above it. */
static bool says(const struct render_canvas *canvas, const struct render_placed *placed, const char *text)
{
	int unit = placed->unit, width = render_text_width(text, unit), high = RENDER_LETTER_HEIGHT * unit;
	struct render_canvas alone;
	must(render_canvas_create((uint32_t)width, (uint32_t)high, (struct render_colour){255, 255, 255, 255}, &alone));
	render_canvas_text(&alone, 0, 0, unit, text, (struct render_colour){0, 0, 0, 255}, (struct render_colour){0, 0, 0, 0});
	bool found = false;
	for (int64_t y = 0; y + high <= canvas->height && !found; y++) {
		if (y + high > placed->low && y < placed->high)
			continue;
		for (int64_t x = 0; x + width <= canvas->width && !found; x++) {
			found = true;
			for (int64_t i = 0; i < (int64_t)width * high && found; i++)
				found = is_dark(&alone, i % width, i / width) == is_dark(canvas, x + i % width, y + i / width);
		}
	}
	render_canvas_finish(&alone);
	return found;
}

struct drawn {
	struct render_map_raster raster;
	struct render_canvas canvas;
	struct render_placed placed;
};

static struct drawn draw(const struct render_map_raster_params *params, struct render_range range, uint32_t side)
{
	struct drawn drawn;
	must(render_map_raster_create(params, &drawn.raster));
	struct render_map_layout layout = {.raster = &drawn.raster, .title = "a title", .subtitle = "2 m a post", .layer = "offset",
				     .ramp = RENDER_RAMP_SIGNED, .range = range, .side = side};
	must(render_map_layout_create(&layout, &drawn.canvas, &drawn.placed));
	must(render_map_layout_frame(&layout, &drawn.canvas, &drawn.placed));
	return drawn;
}

static void drawn_finish(struct drawn *drawn)
{
	render_map_raster_finish(&drawn->raster);
	render_canvas_finish(&drawn->canvas);
}

/* The canvas's pixel at a place, metres. */
static const uint8_t *at_place(const struct drawn *drawn, double x, double y)
{
	const struct render_placed *placed = &drawn->placed;
	return at(&drawn->canvas, (int64_t)floor(placed->x + x * placed->scale), (int64_t)floor(placed->y + y * placed->scale));
}

static void assert_colour(const uint8_t *pixel, struct render_colour colour)
{
	const uint8_t wanted[4] = {colour.r, colour.g, colour.b, 255};
	assert_memory_equal(pixel, wanted, 4);
}

static void a_rut_has_its_place_and_its_depths_colour(void **state)
{
	for (uint32_t side = 100; side <= 2000; side += 1900)
		for (int level = LEVEL; level <= 0; level++) {
			struct render_map_raster_params params = asked(level, STORE_OFFSET);
			struct drawn drawn = draw(&params, (struct render_range){-0.25, 0.25}, side);
			double flat = drawn.raster.flat;
			/* The middles of the broad rut and the heap, the narrow rut; the ground beside; the hole. */
			assert_colour(at_place(&drawn, 65, 75), render_ground_colour(flat, flat, render_ramp(RENDER_RAMP_SIGNED, -0.5)));
			assert_colour(at_place(&drawn, 260, 180), render_ground_colour(flat, flat, render_ramp(RENDER_RAMP_SIGNED, 0.25)));
			assert_colour(at_place(&drawn, 200, 250), render_ground_colour(flat, flat, render_ramp(RENDER_RAMP_SIGNED, 0)));
			assert_true(at_place(&drawn, 166.5, 250)[2] > at_place(&drawn, 166.5, 250)[0] + 30);
			assert_true(at_place(&drawn, 130, 50)[2] >= at_place(&drawn, 130, 50)[0] + 10);
			/* Enlarged by a whole factor. */
			double factor = drawn.placed.scale * drawn.raster.spacing;
			assert_true(factor == floor(factor) && factor >= 1);
			assert_true(side < 1000 ? factor == 1 : factor > 1);
			drawn_finish(&drawn);
		}
}

/* Its row of pixels: below the map, right of the legend, dark for longest. */
static int64_t scale_bar(const struct drawn *drawn, int64_t *longest)
{
	int64_t at_y = 0;
	*longest = 0;
	for (int64_t y = 0; y < drawn->placed.low - 2 * drawn->placed.unit; y++)
		for (int64_t x = 190 * drawn->placed.unit, run = 0; x < drawn->canvas.width; x++) {
			run = is_dark(&drawn->canvas, x, y) ? run + 1 : 0;
			if (run > *longest) {
				*longest = run;
				at_y = y;
			}
		}
	return at_y;
}

static void the_scale_bar_is_as_long_as_it_says(void **state)
{
	static const struct {
		int level;
		uint32_t side;
		double length;
		const char *text;
	} cases[] = {{0, 100, 200, "200 m"}, {0, 1200, 200, "200 m"}, {-2, 100, 100, "100 m"}, {2, 60, 500, "500 m"}, {-2, 3000, 200, "200 m"}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct render_map_raster_params params = asked(cases[i].level, STORE_OFFSET);
		struct drawn drawn = draw(&params, (struct render_range){0, 0}, cases[i].side);
		int64_t pixels;
		scale_bar(&drawn, &pixels);
		assert_true(fabs((double)pixels - cases[i].length * drawn.placed.scale) <= 1);
		assert_true(says(&drawn.canvas, &drawn.placed, cases[i].text));
		drawn_finish(&drawn);
	}
}

static void the_legend_says_what_the_colours_mean(void **state)
{
	struct render_map_raster_params params = asked(0, STORE_OFFSET);
	struct drawn drawn = draw(&params, (struct render_range){-0.1, 0.05}, 0);
	for (size_t i = 0; i < 6; i++) {
		static const char *const texts[] = {"a title", "offset, cm", "<-10", "-5", "0", ">5"};
		assert_true(says(&drawn.canvas, &drawn.placed, texts[i]));
	}
	assert_false(says(&drawn.canvas, &drawn.placed, ">10"));
	assert_true(says(&drawn.canvas, &drawn.placed, "N"));
	drawn_finish(&drawn);
	/* By itself: one post of a metre is beyond what a thousandth is; with all of it nothing is beyond. */
	params = asked(LEVEL, STORE_OFFSET);
	drawn = draw(&params, (struct render_range){0, 0}, 0);
	assert_true(says(&drawn.canvas, &drawn.placed, "<-30") && says(&drawn.canvas, &drawn.placed, ">30"));
	drawn_finish(&drawn);
	drawn = draw(&params, (struct render_range){-1, 1}, 0);
	assert_true(says(&drawn.canvas, &drawn.placed, "offset, m") && !says(&drawn.canvas, &drawn.placed, "<"));
	drawn_finish(&drawn);
	/* Thousandths; and nothing at all. */
	drawn = draw(&params, (struct render_range){-0.004, 0.004}, 0);
	assert_true(says(&drawn.canvas, &drawn.placed, "offset, mm") && says(&drawn.canvas, &drawn.placed, ">4"));
	drawn_finish(&drawn);
	params.rect = (struct post_rect){200, 20, 300, 40};
	drawn = draw(&params, (struct render_range){0, 0}, 0);
	assert_true(says(&drawn.canvas, &drawn.placed, "offset: none"));
	drawn_finish(&drawn);
}

static void the_smallest_maps_have_all_of_it(void **state)
{
	static const struct post_rect rects[] = {{0, 0, 1, 1}, {3, 3, 5, 5}, {7, 0, 8, 150}, {0, 9, 201, 10}, {65, 25, 66, 26}};
	for (size_t i = 0; i < sizeof rects / sizeof *rects; i++)
		for (uint32_t side = 0; side < 1000; side += 800) {
			struct render_map_raster_params params = asked(0, STORE_OFFSET);
			params.rect = rects[i];
			struct drawn drawn = draw(&params, (struct render_range){0, 0}, side);
			int64_t pixels;
			scale_bar(&drawn, &pixels);
			assert_true(pixels > 0 && drawn.placed.right > drawn.placed.left && drawn.placed.high > drawn.placed.low);
			assert_true(says(&drawn.canvas, &drawn.placed, "a title") && says(&drawn.canvas, &drawn.placed, "N"));
			drawn_finish(&drawn);
		}
}

static void running_out_of_memory_is_told(void **state)
{
	struct render_map_raster_params params = asked(1, STORE_PLASTIC_SINKAGE);
	enum status status = STATUS_FAILED;
	for (uint64_t nth = 1; status != STATUS_OK; nth++) {
		struct drawn drawn = {.raster = {.width = 0}};
		struct render_map_layout layout = {.raster = &drawn.raster, .title = "", .subtitle = "", .layer = "pressed",
					     .ramp = RENDER_RAMP_GREEN};
		mem_fail_nth(nth, 0);
		status = render_map_raster_create(&params, &drawn.raster);
		if (status == STATUS_OK)
			status = render_map_raster_widen(&drawn.raster);
		if (status == STATUS_OK)
			status = render_map_layout_create(&layout, &drawn.canvas, &drawn.placed);
		if (status == STATUS_OK)
			status = render_map_layout_frame(&layout, &drawn.canvas, &drawn.placed);
		mem_fail_nth(0, 0);
		assert_true(status == STATUS_OK ? nth > 8 : status == STATUS_FAILED);
		drawn_finish(&drawn);
	}
}

int main(void)
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
		cmocka_unit_test(a_rut_has_its_place_and_its_depths_colour),
		cmocka_unit_test(the_scale_bar_is_as_long_as_it_says),
		cmocka_unit_test(the_legend_says_what_the_colours_mean),
		cmocka_unit_test(the_smallest_maps_have_all_of_it),
		cmocka_unit_test(running_out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
