/* Map layouts: where a map, its legend and its scale bar stand on the canvas, and in which colours. No GL. */
#include "dug.h"

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
		cmocka_unit_test(a_rut_has_its_place_and_its_depths_colour),
		cmocka_unit_test(the_scale_bar_is_as_long_as_it_says),
		cmocka_unit_test(the_legend_says_what_the_colours_mean),
		cmocka_unit_test(the_smallest_maps_have_all_of_it),
		cmocka_unit_test(running_out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
