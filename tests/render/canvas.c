/* What is drawn upon pixels: each pixel by what covers it, letters told apart. No GL. */
#include "../support.h"

#include "render/internal.h"

#define WHITE (struct render_colour){255, 255, 255, 255}
#define BLACK (struct render_colour){0, 0, 0, 255}
#define NONE (struct render_colour){0, 0, 0, 0}

static struct render_canvas blank(uint32_t width, uint32_t height)
{
	struct render_canvas canvas;
	must(render_canvas_create(width, height, WHITE, &canvas));
	return canvas;
}

static const uint8_t *at(const struct render_canvas *canvas, int x, int y)
{
	return canvas->pixels + 4 * ((size_t)y * canvas->width + (size_t)x);
}

/* How dark a black drawing on white is there, 0 to 255. */
static int dark(const struct render_canvas *canvas, int x, int y)
{
	return 255 - at(canvas, x, y)[0];
}

static int darkness(const struct render_canvas *canvas)
{
	int sum = 0;
	for (int y = 0; y < (int)canvas->height; y++)
		for (int x = 0; x < (int)canvas->width; x++)
			sum += dark(canvas, x, y);
	return sum;
}

static void a_box_fills_its_pixels_and_no_other(void **state)
{
	struct render_canvas canvas = blank(9, 7);
	render_canvas_box(&canvas, 2, 1, 5, 3, BLACK);
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 9; x++)
			assert_int_equal(dark(&canvas, x, y), x >= 2 && x < 5 && y >= 1 && y < 3 ? 255 : 0);
	/* Half a colour is half of it, and the pixel stays opaque. */
	render_canvas_box(&canvas, 8, 6, 9, 7, (struct render_colour){0, 0, 0, 128});
	assert_in_range(dark(&canvas, 8, 6), 127, 129);
	assert_int_equal(at(&canvas, 8, 6)[3], 255);
	render_canvas_finish(&canvas);
}

static void over_nothing_a_colour_is_itself(void **state)
{
	struct render_canvas canvas;
	must(render_canvas_create(2, 1, NONE, &canvas));
	const struct render_colour half = {10, 200, 30, 128};
	render_canvas_box(&canvas, 0, 0, 1, 1, half);
	assert_memory_equal(at(&canvas, 0, 0), &half, 4);
	assert_int_equal(at(&canvas, 1, 0)[3], 0);
	render_canvas_finish(&canvas);
}

static void what_lies_beyond_is_not_drawn(void **state)
{
	struct render_canvas canvas = blank(8, 8);
	const double far[3][2] = {{-1e12, 4}, {1e12, 4}, {1e300, -1e300}};
	render_canvas_box(&canvas, INT32_MIN, INT32_MIN, 0, INT32_MAX, BLACK);
	render_canvas_disc(&canvas, -20, 3, 10, BLACK);
	render_canvas_text(&canvas, 200, 200, 3, "far", BLACK, BLACK);
	render_canvas_text(&canvas, -5000, -60, 3, "away", BLACK, BLACK);
	assert_int_equal(darkness(&canvas), 0);
	must(render_canvas_path(&canvas, far, 2, 2, BLACK));
	for (int x = 0; x < 8; x++) {
		assert_int_equal(dark(&canvas, x, 3), 255);
		assert_int_equal(dark(&canvas, x, 4), 255);
		assert_int_equal(dark(&canvas, x, 6), 0);
	}
	must(render_canvas_path(&canvas, far, 3, 2, BLACK));
	must(render_canvas_path(&canvas, far, 0, 2, BLACK));
	render_canvas_box(&canvas, INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX, BLACK);
	assert_int_equal(darkness(&canvas), 64 * 255);
	render_canvas_finish(&canvas);
}

/* Whatever its direction and place, a line covers its length times its width. */
static void a_line_is_as_wide_as_it_says(void **state)
{
	for (double turn = 0; turn < 3.2; turn += 0.17)
		for (double width = 1; width < 6; width += 1.5) {
			struct render_canvas canvas = blank(80, 80);
			double x = 40.3 + turn, y = 39.6, dx = 25 * cos(turn), dy = 25 * sin(turn);
			const double points[2][2] = {{x - dx, y - dy}, {x + dx, y + dy}};
			must(render_canvas_path(&canvas, points, 2, width, BLACK));
			double covered = darkness(&canvas) / 255.0, wanted = 50 * width + M_PI * width * width / 4;
			assert_true(fabs(covered - wanted) < 0.03 * wanted + 0.5);
			/* It passes through its points. */
			assert_true(dark(&canvas, (int)points[0][0], (int)points[0][1]) > 60);
			assert_true(dark(&canvas, (int)points[1][0], (int)points[1][1]) > 60);
			render_canvas_finish(&canvas);
		}
}

/* However often a line passes, and however many points it has, it is no darker. */
static void a_line_of_many_points_is_that_of_few(void **state)
{
	struct render_colour half = {0, 0, 0, 128};
	struct render_canvas few = blank(64, 64), many = blank(64, 64);
	double points[2001][2];
	for (int i = 0; i <= 2000; i++) {
		double t = fabs((double)i - 1000) / 1000;
		points[i][0] = 60 - 55 * t;
		points[i][1] = 50 - 40 * t;
	}
	must(render_canvas_path(&many, (const double(*)[2])points, 2001, 3, half));
	const double ends[2][2] = {{5, 10}, {60, 50}};
	must(render_canvas_path(&few, ends, 2, 3, half));
	for (int y = 0; y < 64; y++)
		for (int x = 0; x < 64; x++)
			assert_in_range(dark(&many, x, y) + 3 - dark(&few, x, y), 0, 6);
	render_canvas_finish(&few);
	render_canvas_finish(&many);
}

static void a_disc_has_its_area(void **state)
{
	struct render_canvas canvas = blank(40, 40);
	render_canvas_disc(&canvas, 19.7, 20.4, 9.5, BLACK);
	assert_true(fabs(darkness(&canvas) / 255.0 - M_PI * 9.5 * 9.5) < 2);
	assert_int_equal(dark(&canvas, 19, 20), 255);
	render_canvas_finish(&canvas);
}

/* The letter's pixels as a set of bits, 60 of them. */
static uint64_t letter(char c, struct render_colour outline)
{
	struct render_canvas canvas = blank(6, 10);
	const char text[2] = {c, '\0'};
	render_canvas_text(&canvas, 0, 0, 1, text, BLACK, outline);
	uint64_t bits = 0;
	for (int i = 0; i < 60; i++)
		bits |= (uint64_t)(at(&canvas, i % 6, i / 6)[0] == 0) << i;
	render_canvas_finish(&canvas);
	return bits;
}

static void every_letter_is_another(void **state)
{
	assert_int_equal(letter(' ', NONE), 0);
	for (int a = 33; a < 127; a++) {
		assert_true(letter((char)a, NONE) != 0);
		for (int b = 32; b < a; b++) {
			uint64_t differ = letter((char)a, NONE) ^ letter((char)b, NONE);
			assert_true(__builtin_popcountll(differ) >= 2);
		}
		/* Letters do not touch: the sixth column is free, and the tenth row. */
		for (int i = 0; i < 60; i++)
			assert_false((i % 6 == 5 || i / 6 == 9) && (letter((char)a, NONE) >> i & 1));
	}
}

static void letters_stand_upright_in_their_cells(void **state)
{
	struct render_canvas canvas = blank(40, 30);
	render_canvas_text(&canvas, 4, 5, 2, "L", BLACK, NONE);
	/* Its foot is on the baseline, two rows of letters above the cell's lower edge; its stem at the left. */
	for (int x = 4; x < 14; x++)
		assert_int_equal(dark(&canvas, x, 5 + 2 * 2), 255);
	for (int y = 9; y < 9 + 14; y++)
		assert_int_equal(dark(&canvas, 4, y), 255);
	assert_int_equal(dark(&canvas, 12, 15), 0);
	assert_int_equal(darkness(&canvas), 255 * 4 * 11);
	render_canvas_finish(&canvas);
}

static void an_outline_parts_letters_from_what_is_behind(void **state)
{
	struct render_canvas canvas = blank(40, 14);
	const struct render_colour red = {255, 0, 0, 255};
	render_canvas_text(&canvas, 2, 2, 1, "Hi8", red, BLACK);
	for (int y = 0; y < 14; y++)
		for (int x = 0; x < 40; x++) {
			const uint8_t *p = at(&canvas, x, y);
			bool inked = p[0] == 255 && p[1] == 0;
			for (int i = 0; inked && i < 9; i++)
				assert_int_equal(at(&canvas, x + i % 3 - 1, y + i / 3 - 1)[1], 0);
		}
	render_canvas_finish(&canvas);
}

static void what_is_not_ascii_is_one_question_mark_each(void **state)
{
	assert_int_equal(render_text_width("r\xc3\xa4" "der", 1), 5 * 6);
	assert_int_equal(render_text_width("", 3), 0);
	struct render_canvas a = blank(60, 10), b = blank(60, 10);
	render_canvas_text(&a, 0, 0, 1, "r\xc3\xa4" "d\xe2\x82\xac\n", BLACK, NONE);
	render_canvas_text(&b, 0, 0, 1, "r?d??", BLACK, NONE);
	assert_memory_equal(a.pixels, b.pixels, 4 * 60 * 10);
	render_canvas_finish(&a);
	render_canvas_finish(&b);
}

static void running_out_of_memory_is_told(void **state)
{
	struct render_canvas canvas;
	mem_fail_nth(1, 0);
	assert_int_equal(render_canvas_create(10, 10, WHITE, &canvas), STATUS_FAILED);
	canvas = blank(10, 10);
	const double points[2][2] = {{1, 1}, {8, 8}};
	mem_fail_nth(1, 0);
	assert_int_equal(render_canvas_path(&canvas, points, 2, 1, BLACK), STATUS_FAILED);
	mem_fail_nth(0, 0);
	assert_int_equal(darkness(&canvas), 0);
	render_canvas_finish(&canvas);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_box_fills_its_pixels_and_no_other),
		cmocka_unit_test(over_nothing_a_colour_is_itself),
		cmocka_unit_test(what_lies_beyond_is_not_drawn),
		cmocka_unit_test(a_line_is_as_wide_as_it_says),
		cmocka_unit_test(a_line_of_many_points_is_that_of_few),
		cmocka_unit_test(a_disc_has_its_area),
		cmocka_unit_test(every_letter_is_another),
		cmocka_unit_test(letters_stand_upright_in_their_cells),
		cmocka_unit_test(an_outline_parts_letters_from_what_is_behind),
		cmocka_unit_test(what_is_not_ascii_is_one_question_mark_each),
		cmocka_unit_test(running_out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
