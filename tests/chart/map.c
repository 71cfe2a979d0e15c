/* Maps: where the ground, the grid, the words and the marks stand. Places are checked, not the shapes of letters. No GL. */
#include "drawn.h"
#include "../support/program.h"

#define NAMES 300

static void a_rut_has_its_place_and_its_depths_colour(void **state)
{
	static const uint32_t pixels[] = {201, 1005, 2100};
	for (size_t i = 0; i < 3; i++)
		for (int level = LEVEL; level <= 0; level++) {
			struct chart_raster_params params = asked(level, STORE_OFFSET);
			struct chart_map map = plain(pixels[i]);
			map.range = (struct chart_range){-0.25, 0.25};
			map.grid = CHART_GRID_NONE;
			struct drawn drawn = draw_map(map, &params, "map.png");
			struct picture picture = write_and_read(&drawn);
			double flat = drawn.raster.flat;
			const char *notes = drawn.page.said[drawn.page.said_count - 1].text;
			assert_true((strstr(notes, "Ruts are drawn at least") != NULL) == (level > LEVEL));
			/* The middles of the broad rut and the heap; the ground beside. */
			assert_colour(at_place(&drawn, &picture, 65, 75),
				      chart_ground_colour(flat, flat, chart_ramp(CHART_RAMP_SIGNED, -0.5)));
			assert_colour(at_place(&drawn, &picture, 260, 180),
				      chart_ground_colour(flat, flat, chart_ramp(CHART_RAMP_SIGNED, 0.25)));
			assert_colour(at_place(&drawn, &picture, 200, 250),
				      chart_ground_colour(flat, flat, chart_ramp(CHART_RAMP_SIGNED, 0)));
			/* The narrow rut, and the hole: both are bluish. */
			bool found = false;
			for (double x = 164; x < 169; x += 0.25)
				found |= at_place(&drawn, &picture, x, 250)[2] > at_place(&drawn, &picture, x, 250)[0] + 30;
			assert_true(found || pixels[i] < drawn.raster.width / 2);
			assert_true(at_place(&drawn, &picture, 130, 50)[2] >= at_place(&drawn, &picture, 130, 50)[0] + 10);
			free(picture.pixels);
			drawn_finish(&drawn);
		}
}

/* --- the grid --- */

/* A number as chart_number writes it: narrow spaces, and a true minus sign. */
static double read_number(const char *text)
{
	char plain[64];
	size_t used = 0;
	for (; *text != '\0' && used + 1 < sizeof plain; text++) {
		if (strncmp(text, "\xe2\x88\x92", 3) == 0)
			plain[used++] = '-';
		else if ((*text >= '0' && *text <= '9') || *text == '.')
			plain[used++] = *text;
		else if (*text == ' ')
			break;
	}
	plain[used] = '\0';
	return strtod(plain, NULL);
}

/* What the coordinates say of the frame's corners: a straight line through the first and the last of each direction. */
static void corners(const struct drawn *drawn, double low[2], double high[2])
{
	for (int axis = 0; axis < 2; axis++) {
		double at[2] = {NAN, NAN}, value[2] = {NAN, NAN};
		const struct chart_rect *frame = &drawn->frame.rect;
		const double near = axis == 0 ? frame->x0 + 1 : frame->y0 + 1, far = axis == 0 ? frame->x1 - 1 : frame->y1 - 1;
		for (size_t i = 0; i < drawn->page.said_count; i++) {
			const struct chart_said *one = &drawn->page.said[i];
			if (one->kind != CHART_COORDINATE || (one->rect.y0 >= frame->y1) != (axis == 0))
				continue;
			/* One that was moved off a corner is not in its line's middle. */
			const double middle = axis == 0 ? (one->rect.x0 + one->rect.x1) / 2 : (one->rect.y0 + one->rect.y1) / 2;
			if (axis == 1 && (one->rect.y0 < near || one->rect.y1 > far))
				continue;
			const int end = isnan(at[0]) ? 0 : 1;
			at[end] = middle;
			value[end] = read_number(one->text);
		}
		assert_false(isnan(at[1]));
		const double slope = (value[1] - value[0]) / (at[1] - at[0]);
		low[axis] = value[0] + slope * ((axis == 0 ? frame->x0 : frame->y1) - at[0]);
		high[axis] = value[0] + slope * ((axis == 0 ? frame->x1 : frame->y0) - at[0]);
	}
}

static void coordinates_at_the_corners_are_the_store_s(void **state)
{
	static const double origins[][2] = {{0, 0}, {500000, 4649776.25}, {-1234567.5, 98765432}, {500000, 4649776.25}};
	static const int levels[] = {LEVEL, 0, 2};
	for (size_t i = 0; i < 4; i++)
		for (size_t k = 0; k < (i == 3 ? 1 : 3); k++) {
			struct chart_raster_params params = asked(levels[k], STORE_OFFSET);
			struct store_meta meta = *params.meta;
			memcpy(meta.origin, origins[i], sizeof meta.origin);
			meta.srs = i == 0 ? ""
					  : "PROJCS[\"Here\",GEOGCS[\"There\",AUTHORITY[\"EPSG\",\"1\"]],AUTHORITY[\"EPSG\","
					    "\"32633\"]]";
			struct chart_map map = plain(900);
			map.meta = &meta;
			map.grid = i == 3 ? CHART_GRID_LOCAL : CHART_GRID_METRES; /* metres of scenes, whatever the store's system */
			struct drawn drawn = draw_map(map, &params, "map.png");
			double low[2], high[2];
			corners(&drawn, low, high);
			const double spacing = drawn.raster.spacing,
				     sides[2] = {drawn.raster.width * spacing, drawn.raster.height * spacing};
			for (int axis = 0; axis < 2; axis++) {
				const double first = (i == 3 ? 0 : origins[i][axis]) - spacing / 2; /* a pixel's centre is its post */
				assert_true(fabs(low[axis] - first) < 0.004 * sides[axis]);
				assert_true(fabs(high[axis] - first - sides[axis]) < 0.004 * sides[axis]);
			}
			assert_in_order(&drawn);
			const char *notes = drawn.page.said[drawn.page.said_count - 1].text;
			assert_non_null(strstr(notes, i == 0 || i == 3 ? "south-west post" : "Coordinates in metres: Here (EPSG:32633)"));
			drawn_finish(&drawn);
		}
}

/* A store is not trusted: its origin may be any number. */
static void an_origin_beyond_all_numbers_has_no_grid(void **state)
{
	static const double origins[][2] = {{1e300, 0}, {0, -1e25}, {INFINITY, 0}, {0, NAN}};
	for (size_t i = 0; i < 4; i++) {
		struct chart_raster_params params = asked(0, STORE_OFFSET);
		struct store_meta meta = *params.meta;
		memcpy(meta.origin, origins[i], sizeof meta.origin);
		struct chart_map map = plain(300);
		map.meta = &meta;
		struct drawn drawn = draw_map(map, &params, "map.png");
		for (size_t k = 0; k < drawn.page.said_count; k++)
			assert_true(drawn.page.said[k].kind != CHART_COORDINATE);
		assert_in_order(&drawn);
		drawn_finish(&drawn);
	}
}

/* --- the scale bar --- */

/* The longest run of dark pixels in one row outside the frame, in a part of the page that is right of the legend. */
static int longest_run(const struct drawn *drawn, const struct picture *picture)
{
	int longest = 0;
	const bool tall = drawn->page.width > drawn->frame.rect.x1 + 100;
	const int from = (int)((tall ? drawn->frame.rect.x1 + 4 : 0.45 * drawn->page.width) * drawn->page.dots);
	const int top = tall ? (int)(0.4 * picture->height) : (int)((drawn->frame.rect.y1 + 8) * drawn->page.dots);
	for (int y = top; y < picture->height; y++)
		for (int x = from, run = 0; x < picture->width; x++) {
			const uint8_t *p = picture->pixels + 3 * ((size_t)y * (size_t)picture->width + (size_t)x);
			run = p[0] < 150 && p[2] < 150 ? run + 1 : 0;
			longest = run > longest ? run : longest;
		}
	return longest;
}

static void the_scale_bar_is_as_long_as_it_says(void **state)
{
	static const struct {
		int level;
		struct post_rect rect;
		uint32_t pixels;
		double length;
		const char *text;
	} cases[] = {{0, {0, 0, 201, 150}, 900, 100, "100 m"},
		     {0, {0, 0, 201, 150}, 2700, 100, "100 m"},
		     {-2, {0, 0, 80, 60}, 900, 10, "10 m"},
		     {2, {0, 0, 51, 38}, 900, 100, "100 m"},
		     {-2, {0, 0, 3, 3}, 1200, 0.2, "20 cm"}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct chart_raster_params params = asked(cases[i].level, STORE_OFFSET);
		params.rect = cases[i].rect;
		struct drawn drawn = draw_map(plain(cases[i].pixels), &params, "map.png");
		assert_non_null(said(&drawn, cases[i].text));
		struct picture picture = write_and_read(&drawn);
		const double pixels = cases[i].length / drawn.raster.spacing * drawn.frame.width / drawn.raster.width;
		/* The line around it is drawn half outside. */
		assert_true(fabs(longest_run(&drawn, &picture) - pixels) <= 0.6 * drawn.page.dots + 1.5);
		free(picture.pixels);
		drawn_finish(&drawn);
	}
}

/* --- the legend --- */

static void the_legend_says_what_the_colours_mean(void **state)
{
	struct chart_raster_params params = asked(0, STORE_OFFSET);
	struct chart_map map = plain(600);
	map.range = (struct chart_range){-0.1, 0.05};
	struct drawn drawn = draw_map(map, &params, "map.png");
	for (size_t i = 0; i < 7; i++) {
		static const char *const texts[] = {"a title",
						    "a subtitle",
						    "Offset, cm",
						    "\xe2\x88\x92"
						    "100 to \xe2\x88\x92"
						    "10",
						    "0",
						    "5 to 50",
						    "no data"};
		assert_non_null(said(&drawn, texts[i]));
	}
	assert_in_order(&drawn);
	drawn_finish(&drawn);
	/* By itself: one post of a metre is beyond what a thousandth is; with all of it nothing is beyond. */
	params = asked(LEVEL, STORE_OFFSET);
	drawn = draw_map(plain(600), &params, "map.png");
	assert_true(said(&drawn, "\xe2\x88\x92"
				 "100 to \xe2\x88\x92"
				 "30") != NULL &&
		    said(&drawn, "30 to 50") != NULL);
	const char *notes = drawn.page.said[drawn.page.said_count - 1].text;
	assert_non_null(strstr(notes, "Drawn at 50 cm; the terrain's own posts are 2 m apart."));
	drawn_finish(&drawn);
	/* Of lowered ground alone: from 0 to the deepest. */
	params.rect = (struct post_rect){90, 90, 200, 210};
	drawn = draw_map(plain(600), &params, "map.png");
	assert_true(said(&drawn, "\xe2\x88\x92"
				 "12.5") != NULL &&
		    said(&drawn, "0") != NULL && said(&drawn, "12.5") == NULL);
	drawn_finish(&drawn);
	params = asked(LEVEL, STORE_OFFSET);
	map.range = (struct chart_range){-1, 1};
	drawn = draw_map(map, &params, "map.png");
	assert_true(said(&drawn, "Offset, m") != NULL && said(&drawn, "1.0") != NULL);
	drawn_finish(&drawn);
	/* Thousandths; and nothing at all. */
	map.range = (struct chart_range){-0.004, 0.004};
	drawn = draw_map(map, &params, "map.png");
	assert_true(said(&drawn, "Offset, mm") != NULL && said(&drawn, "4 to 500") != NULL);
	drawn_finish(&drawn);
	params.rect = (struct post_rect){200, 20, 300, 40};
	drawn = draw_map(plain(600), &params, "map.png");
	assert_non_null(said(&drawn, "Offset: no change"));
	drawn_finish(&drawn);
}

/* Of level ground, heights have one number; of any other, both ends and round numbers between them. */
static void the_legend_of_heights_has_their_ends(void **state)
{
	struct chart_raster_params params = asked(0, STORE_BASE);
	struct chart_map map = plain(600);
	map.ramp = CHART_RAMP_HEIGHTS;
	map.layer = "Height";
	struct drawn drawn = draw_map(map, &params, "map.png");
	assert_non_null(said(&drawn, "Height: 500.00 m everywhere"));
	drawn_finish(&drawn);
	must(chart_raster_create(&params, &drawn.raster));
	for (size_t i = 0; i < (size_t)drawn.raster.width * drawn.raster.height; i++)
		drawn.raster.values[i] = -12.25f + 1000 * (float)(i % 7);
	map.raster = &drawn.raster;
	map.meta = params.meta;
	must(chart_map_page(&map, "map.png", &drawn.page, &drawn.frame, &drawn.written));
	static const char *const texts[] = {"Height, m",
					    "\xe2\x88\x92"
					    "12",
					    "2000", "4000", "5988"};
	for (size_t i = 0; i < 5; i++)
		if (said(&drawn, texts[i]) == NULL)
			fail_msg("no %s", texts[i]);
	assert_in_order(&drawn);
	drawn_finish(&drawn);
}

static void classes_have_their_colours_and_shares(void **state)
{
	static const struct chart_key keys[] = {{"go", {0, 158, 115, 255}, 0.25}, {"no-go", {213, 94, 0, 255}, 0.75}};
	struct chart_raster_params params = asked(0, STORE_OFFSET);
	struct chart_raster raster;
	must(chart_raster_create(&params, &raster));
	uint8_t *classes = calloc((size_t)raster.width, raster.height);
	for (size_t i = 0; i < (size_t)raster.width * raster.height; i++)
		classes[i] = i % raster.width < 50 ? 0 : i % raster.width < 180 ? 1 : CHART_NO_CLASS;
	struct chart_map map = plain(603);
	map.raster = &raster;
	map.meta = params.meta;
	map.classes = classes;
	map.keys = keys;
	map.key_count = 2;
	map.layer = "Classes";
	map.grid = CHART_GRID_NONE;
	struct drawn drawn = {.raster = raster};
	must(chart_map_page(&map, "map.png", &drawn.page, &drawn.frame, &drawn.written));
	assert_true(said(&drawn, "go: 25.0 %") != NULL && said(&drawn, "no-go: 75.0 %") != NULL);
	assert_in_order(&drawn);
	struct picture picture = write_and_read(&drawn);
	const uint8_t *go = at_place(&drawn, &picture, 40, 250), *no_go = at_place(&drawn, &picture, 220, 250),
		      *none = at_place(&drawn, &picture, 390, 250);
	assert_true(go[1] > go[0] + 50 && no_go[0] > no_go[1] + 50 && none[2] >= none[0]);
	free(picture.pixels);
	chart_page_finish(&drawn.page);
	/* Right of a tall map too, with names that are longer than there is room. */
	static const struct chart_key longer[] = {
		{"unknown: too steep or too coarse to say, or whatever else it may be", {150, 150, 158, 255}, 1},
		{"go", {0, 158, 115, 255}, 0}};
	drawn.raster.width = 50;
	map.raster = &drawn.raster;
	map.keys = longer;
	must(chart_map_page(&map, "map.png", &drawn.page, &drawn.frame, &drawn.written));
	assert_in_order(&drawn);
	free(classes);
	drawn_finish(&drawn);
}

/* --- names --- */

static uint32_t seed;
static double random_share(void)
{
	seed = seed * 1664525u + 1013904223u;
	return (seed >> 8) / 16777216.0;
}

/* Ways in a part of the terrain; every eighth name is as long as a name may be, every third way is a vehicle's. */
static size_t make_ways(struct chart_way *ways, char (*names)[160], double (*places)[3][2], size_t count, const double low[2],
			const double size[2])
{
	static const char *const words[] = {"rover",
					    "\xd0\x9b\xd1\x83\xd0\xbd\xd0\xbe\xd1\x85\xd1\x96\xd0\xb4",
					    "e\xcc\x8a",
					    "\xd8\xb9\xd8\xb1\xd8\xa8\xd8\xa9",
					    "\xe7\x81\xab\xe6\x98\x9f",
					    "a<b>&\"c\"",
					    "\xff\xfe",
					    "x"};
	for (size_t i = 0; i < count; i++) {
		snprintf(names[i], sizeof names[i],
			 i % 8 == 7 ? "%s %zu with a name that goes on and on until nobody reads it, and then on" : "%s %zu",
			 words[i % 8], i);
		places[i][0][0] = low[0] + random_share() * size[0];
		places[i][0][1] = low[1] + random_share() * size[1];
		for (int k = 1; k < 3; k++)
			for (int axis = 0; axis < 2; axis++)
				places[i][k][axis] = places[i][k - 1][axis] + (random_share() - 0.5) * 0.2 * size[axis];
		ways[i] = (struct chart_way){names[i], (const double(*)[2])places[i], 3, i % 3 == 0};
	}
	return count;
}

static void names_do_not_meet(void **state)
{
	static const struct post_rect rects[] = {{0, 0, 201, 150}, {20, 30, 60, 140}, {100, 100, 103, 103}};
	static const size_t counts[] = {5, 40, NAMES};
	static struct chart_way ways[NAMES];
	static char names[NAMES][160];
	static double places[NAMES][3][2];
	for (size_t i = 0; i < 3; i++)
		for (size_t k = 0; k < 3; k++) {
			struct chart_raster_params params = asked(0, STORE_OFFSET);
			params.rect = rects[i];
			const double low[2] = {2.0 * (double)rects[i].x0, 2.0 * (double)rects[i].y0};
			const double size[2] = {2.0 * (double)(rects[i].x1 - rects[i].x0 - 1),
						2.0 * (double)(rects[i].y1 - rects[i].y0 - 1)};
			struct chart_map map = plain(700);
			seed = (uint32_t)(10 * i + k);
			map.ways = ways;
			map.way_count = make_ways(ways, names, places, counts[k], low, size);
			struct drawn drawn = draw_map(map, &params, "map.png");
			size_t shown = 0;
			for (size_t n = 0; n < drawn.page.said_count; n++)
				shown += drawn.page.said[n].kind == CHART_NAME;
			assert_in_order(&drawn);
			assert_int_equal(drawn.written.names, counts[k]);
			assert_int_equal(drawn.written.names - drawn.written.unlabelled, shown);
			assert_true(counts[k] > 5 || shown == counts[k]);
			assert_true(shown >= 5 && (counts[k] < NAMES || (shown > 15 && shown < NAMES)));
			/* How many are left out is said. */
			char told[64];
			snprintf(told, sizeof told, "%zu of %zu names have no room", drawn.written.unlabelled, counts[k]);
			const char *notes = drawn.page.said[drawn.page.said_count - 1].text;
			assert_true((strstr(notes, told) != NULL) == (drawn.written.unlabelled > 0));
			drawn_finish(&drawn);
		}
}

/* Copies of a template pass over one way, the last of them not to its end. */
static void copies_on_one_way_have_one_name(void **state)
{
	static char names[20][24];
	static const double left[3][2] = {{20, 20}, {200, 100}, {350, 120}}, right[3][2] = {{20, 60}, {200, 140}, {350, 160}}, part[2][2] = {{20, 60}, {110, 100}};
	struct chart_raster_params params = asked(0, STORE_OFFSET);
	struct chart_map map = plain(700);
	struct chart_way ways[24];
	for (size_t i = 0; i < 20; i++) {
		snprintf(names[i], sizeof names[i], "%s-%zu", i % 2 == 0 ? "left" : "right", i / 2 + 1);
		ways[i] = (struct chart_way){names[i], i % 2 == 0 ? left : right, 3, false};
	}
	ways[19] = (struct chart_way){names[19], part, 2, false};
	ways[20] = (struct chart_way){"left-11", right, 3, false}; /* other ways, and other names */
	ways[21] = (struct chart_way){"leftover-1", left, 3, false};
	ways[22] = (struct chart_way){"left", left, 3, false};
	ways[23] = (struct chart_way){"right-12", right, 3, true};
	map.ways = ways;
	map.way_count = 24;
	struct drawn drawn = draw_map(map, &params, "map.png");
	assert_int_equal(drawn.written.names, 6);
	assert_non_null(said(&drawn, "left-1 ... left-10"));
	assert_non_null(said(&drawn, "right-1 ... right-10"));
	assert_true(said(&drawn, "left-11") != NULL && said(&drawn, "leftover-1") != NULL && said(&drawn, "left") != NULL && said(&drawn, "right-12") != NULL);
	assert_in_order(&drawn);
	drawn_finish(&drawn);
}

/* --- odd maps --- */

static void the_smallest_and_the_narrowest_maps_have_all_of_it(void **state)
{
	static const struct post_rect rects[] = {{0, 0, 1, 1}, {3, 3, 5, 5}, {7, 0, 8, 150}, {0, 9, 201, 10}, {65, 25, 66, 26}};
	static const double sizes[] = {CHART_SIZE_LEAST, 160, 400};
	for (size_t i = 0; i < sizeof rects / sizeof *rects; i++)
		for (size_t k = 0; k < 3; k++) {
			struct chart_raster_params params = asked(0, STORE_OFFSET);
			params.rect = rects[i];
			struct chart_map map = plain(500);
			map.size = sizes[k];
			map.title = "A title that is far longer than the page is wide, and so is cut in its middle, where it "
				    "matters least of all to anybody who reads it";
			struct drawn drawn = draw_map(map, &params, "map.png");
			assert_in_order(&drawn);
			assert_non_null(said(&drawn, "N"));
			assert_int_equal(drawn.frame.width > drawn.frame.height ? drawn.frame.width : drawn.frame.height, 500);
			drawn_finish(&drawn);
		}
}

TEST_PROGRAM(map)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rut_has_its_place_and_its_depths_colour),
		cmocka_unit_test(coordinates_at_the_corners_are_the_store_s),
		cmocka_unit_test(an_origin_beyond_all_numbers_has_no_grid),
		cmocka_unit_test(the_scale_bar_is_as_long_as_it_says),
		cmocka_unit_test(the_legend_says_what_the_colours_mean),
		cmocka_unit_test(the_legend_of_heights_has_their_ends),
		cmocka_unit_test(classes_have_their_colours_and_shares),
		cmocka_unit_test(names_do_not_meet),
		cmocka_unit_test(copies_on_one_way_have_one_name),
		cmocka_unit_test(the_smallest_and_the_narrowest_maps_have_all_of_it),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
