/* Shadows of objects: they lie on the ground alone, away from the sun, with samples too. Skipped without GL. */
#include "objects_rig.h"
#include "../support/program.h"
#include "../support/skip.h"

/* --- pictures of one tile, or of nothing, with objects --- */

/* Where a place is in the picture; pixels. */
static void project(const struct render_camera *camera, const double place[3], double at[2])
{
	struct render_axes axes;
	double v[3], part[3] = {0, 0, 0};
	render_axes(render, camera, &axes);
	for (int k = 0; k < 3; k++) {
		v[k] = place[k] - camera->eye[k];
		part[0] += v[k] * axes.right[k];
		part[1] += v[k] * axes.up[k];
		part[2] += v[k] * axes.forward[k];
	}
	at[0] = WIDTH / 2.0 + part[0] / part[2] * axes.focal;
	at[1] = HEIGHT / 2.0 + part[1] / part[2] * axes.focal;
}

/* --- shadows --- */

/* The way the light goes along the ground: the sun is in the south-east. */
static void shadow_way(double way[2])
{
	way[0] = -sin(2.35);
	way[1] = -cos(2.35);
}

static void a_shadow_lies_beside_its_object_away_from_the_sun(void **state)
{
	need_gpu();
	const struct soil_shape shapes[3] = {wheel, ball, box};
	const double heights[3] = {0.5, 0.6, 0.15};
	double way[2];
	shadow_way(way);
	for (size_t i = 0; i < 3; i++) {
		uint8_t *pixels[2];
		struct render_object object = posed(i, 8, 8, heights[i]);
		struct render_camera camera = camera_at((double[3]){8, 7.9, 9}, (double[3]){8, 8, 0});
		double at[2], radius = heights[i];
		object.yaw = 0.5;
		for (int k = 0; k < 2; k++) {
			begin(OBJECTS | (k > 0 ? SHADOW : 0), flat, shapes, 3);
			pixels[k] = draw(&camera, &object, 1);
			if (k == 0)
				end();
		}
		int darker = 0;
		for (int y = 0; y < HEIGHT; y++)
			for (int x = 0; x < WIDTH; x++) {
				assert_true(luminance(pixels[1], x, y) <= luminance(pixels[0], x, y) + 1);
				darker += luminance(pixels[1], x, y) < 0.8 * luminance(pixels[0], x, y);
			}
		assert_true(darker > 20 && darker < WIDTH * HEIGHT / 8);
		/* In the shadow, beyond its end, toward the sun, and the object itself. */
		const struct {
			double along, least, most;
		} places[] = {{1.9 * radius, 0.42, 0.7}, {5 * radius, 0.97, 1.03}, {-3 * radius, 0.97, 1.03}, {0, 0.97, 1.03}};
		for (size_t k = 0; k < 4; k++) {
			/* The box is wider than it is high. */
			double along = places[k].along + (i == 2 && places[k].along != 0 ? copysign(0.28, places[k].along) : 0);
			double place[3] = {object.at[0] + way[0] * along, object.at[1] + way[1] * along, GROUND};
			project(&camera, place, at);
			double ratio = (double)luminance(pixels[1], (int)at[0], (int)at[1]) / luminance(pixels[0], (int)at[0], (int)at[1]);
			if (!(ratio >= places[k].least && ratio <= places[k].most))
				fail_msg("shape %zu, %g m along its shadow: %g of the light", i, along, ratio);
		}
		end();
		test_free(pixels[0]);
		test_free(pixels[1]);
	}
}

/* Without the object's shadow the picture is the same. */
static void assert_no_shadow(const struct render_camera *camera, const struct render_object *object)
{
	uint8_t *pixels[2];
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		pixels[k] = draw(camera, object, 1);
	}
	assert_memory_equal(pixels[0], pixels[1], 4 * WIDTH * HEIGHT);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

/* The sky, and what is far behind or before the volume, is left alone. */
static void a_shadow_is_on_the_ground_alone(void **state)
{
	need_gpu();
	begin(OBJECTS | SHADOW, NULL, &ball, 1);
	struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 0.5});
	struct render_object object = posed(0, 8, 8, 0.6);
	assert_no_shadow(&camera, &object);
	end();
	/* High above the ground its shadow has faded. */
	begin(OBJECTS | SHADOW, flat, &ball, 1);
	object = posed(0, 8, 8, 9);
	camera = camera_at((double[3]){8, 7.9, 14}, (double[3]){8, 8, 0});
	assert_no_shadow(&camera, &object);
	end();
}

#define DEGREES (M_PI / 180)
#define WEST 270.0
#define FROM_ABOVE camera_at((const double[3]){8, 7.99, 20}, (const double[3]){8, 8, 0})

/* Draws with and without the shadow, the sun in the west. ratios[i]: how much light is left at each pixel of the row through y = 8,
 * from west to east. */
static void measure_row(const struct render_object *object, double sun, double ratios[WIDTH])
{
	uint8_t *pixels[2];
	const struct render_camera camera = FROM_ABOVE;
	struct render_view view;
	render_move_sun(render, WEST * DEGREES, sun * DEGREES);
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		render_shade_begin(render);
		for (int map = 0; map < RENDER_SHADE_MAPS; map++)
			if (render_shade_view(render, &camera, GROUND, map, &view))
				assert_ok(render_shade_draw(render, &camera, map, &view, &selection));
		pixels[k] = draw(&camera, object, 1);
	}
	for (int x = 0; x < WIDTH; x++)
		ratios[x] = (double)luminance(pixels[1], x, HEIGHT / 2) / luminance(pixels[0], x, HEIGHT / 2);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

/* The pixel of a place east of the tile's corner, at a height. */
static int column(double x, double z)
{
	const struct render_camera camera = FROM_ABOVE;
	const double east = (double)away * 16, place[3] = {east + x, east + 8, GROUND + z};
	double at[2];
	project(&camera, place, at);
	return (int)at[0];
}

/* By trigonometry: height / tan(sun). Down to where the sun is 2 degrees high, that is 29 heights. */
static void a_shadow_is_as_long_as_the_sun_is_low(void **state)
{
	need_gpu();
	static const double cases[][2] = {{60, 1.6}, {40, 1.6}, {20, 1}, {10, 0.8}, {5, 0.8}, {2, 0.4}}; /* degrees; metres along a side */
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const double sun = cases[i][0], side = cases[i][1], east = 2 + side / 2;
		const struct soil_shape cube = {.kind = SOIL_BOX, .size = {side, side, side}};
		const struct render_object object = posed(0, 2, 8, side / 2);
		double ratios[WIDTH];
		begin(OBJECTS | SHADOW, flat, &cube, 1);
		const int first = column(east, 0) + 1, last = column(15.9, 0);
		const double pixels = (column(15, 0) - column(1, 0)) / 14.0; /* a metre */
		measure_row(&object, sun, ratios);
		end();
		/* The light that is left in the shadow; nearer to the object the sky's is less, too. */
		const double wanted = side / tan(sun * DEGREES), least = ratios[first + (int)(0.75 * wanted * pixels)];
		int end = first;
		while (end < last && ratios[end] < (1 + least) / 2)
			end++;
		const double found = (end - first + 1) / pixels;
		if (!(least < 0.95) || !(fabs(found - wanted) <= 0.2 + 0.05 * wanted))
			fail_msg("sun %g degrees high: a shadow of %g m, not %g; %g of the light", sun, found, wanted, least);
		/* beyond the penumbra, and the sky's shade beside the object */
		for (int x = first + (int)(pixels * fmax(1.3 * wanted + 0.4, side)); x < last; x++)
			assert_true(ratios[x] > 0.97);
	}
}

static double falling(double x, double y)
{
	return GROUND + 0.1 * (16 - x);
}

static double rising(double x, double y)
{
	return GROUND + 0.1 * x;
}

/* It falls 3 m at x = 4, eastward. */
static double stepped(double x, double y)
{
	return GROUND + (x < 4 ? 3 : 0);
}

/* An object takes the sun's light, and none where there is none: on ground that is turned away from the sun, or in the shadow of
 * other ground. */
static void where_no_sun_falls_a_shadow_is_not_dark_twice(void **state)
{
	need_gpu();
	double ratios[WIDTH];
	begin(OBJECTS | SHADOW, falling, &ball, 1);
	struct render_object object = posed(0, 6, 8, falling(6, 8) - GROUND + 0.3);
	measure_row(&object, 5, ratios);
	for (int x = column(7.5, 0.85); x < column(12, 0.4); x++)
		assert_true(ratios[x] > 0.99);
	end();
	begin(OBJECTS | SHADOW, rising, &ball, 1);
	object = posed(0, 6, 8, 0.6 + 0.5);
	measure_row(&object, 5, ratios);
	for (int x = column(7.5, 0.75); x < column(9.5, 0.95); x++)
		assert_true(ratios[x] < 0.95);
	end();
	/* The step's shadow reaches 8.2 m, to x = 12.2. */
	begin(OBJECTS | SHADOW | EFFECT_BIT(EFFECT_TERRAIN_SHADOW), stepped, &ball, 1);
	object = posed(0, 6, 8, 0.5);
	measure_row(&object, 20, ratios);
	for (int x = column(7.3, 0); x < column(11.5, 0); x++)
		assert_true(ratios[x] > 0.99);
	object = posed(0, 13, 8, 0.5);
	measure_row(&object, 20, ratios);
	for (int x = column(14.2, 0); x < column(15, 0); x++)
		assert_true(ratios[x] < 0.8);
	end();
}

static double rough(double x, double y)
{
	return GROUND + 0.12 * sin(5 * x) * cos(4 * y);
}

/* There is one sun: in a shadow, or in two, ground is as without it. So is ground that is turned from it, in the shadow and outside. */
static void in_a_shadow_ground_is_as_without_the_sun(void **state)
{
	need_gpu();
	const struct soil_shape cube = {.kind = SOIL_BOX, .size = {1.6, 1.6, 1.6}}, cubes[2] = {cube, cube};
	const struct render_object both[2] = {posed(0, 2, 8, 0.8), posed(1, 4.5, 8, 0.8)};
	const struct render_camera camera = FROM_ABOVE;
	uint8_t *pixels[4]; /* by 0, 1 and 2 objects; without the sun */
	begin(OBJECTS | SHADOW, rough, cubes, 2);
	render_move_sun(render, WEST * DEGREES, 10 * DEGREES);
	for (size_t k = 0; k < 4; k++) {
		if (k == 3) {
			render->light.coloured = true;
			memset(render->light.colour, 0, sizeof render->light.colour);
		}
		pixels[k] = draw(&camera, both, k % 3);
	}
	/* Both shadows reach this far, to 10 m at least, and past the sky's shade beside the objects. */
	int lit = 0, turned = 0;
	for (int y = HEIGHT / 2 - 2; y <= HEIGHT / 2 + 2; y++)
		for (int x = column(6.6, 0); x < column(9, 0); x++) {
			const int sunless = luminance(pixels[3], x, y), sunny = luminance(pixels[0], x, y);
			lit += sunny > 1.5 * sunless;
			turned += sunny == sunless;
			for (int k = 1; k < 3; k++)
				if (abs(luminance(pixels[k], x, y) - sunless) > 8)
					fail_msg("%d objects, pixel %d, %d: %d, without the sun %d", k, x, y, luminance(pixels[k], x, y), sunless);
		}
	assert_true(lit > 10 && turned > 10);
	end();
	for (int k = 0; k < 4; k++)
		test_free(pixels[k]);
}

static void with_samples_a_shadow_lies_there_too(void **state)
{
	need_gpu();
	if (gpu_info(gpu)->samples_most < 4)
		skip_since(SKIP_ELSEWHERE "the driver has no pictures with so many samples");
	samples = 4;
	a_shadow_lies_beside_its_object_away_from_the_sun(state);
	a_shadow_is_on_the_ground_alone(state);
	where_no_sun_falls_a_shadow_is_not_dark_twice(state);
	in_a_shadow_ground_is_as_without_the_sun(state);
	samples = 1;
}

/* Wherever the eye is, in the volume too. */
/* Larger and back: the very picture it was, shadow and all, in as many bytes. */
static void resized_it_is_as_if_it_had_been_so(void **state)
{
	need_gpu();
	const struct render_camera camera = camera_at((const double[3]){8, 2, 2.5}, (const double[3]){8, 8, 0});
	const struct render_object shown = posed(0, 8, 8, 0.5);
	for (samples = 1; samples <= 4 && samples <= (int)gpu_info(gpu)->samples_most; samples += 3) {
		struct gpu_stats before, after;
		begin(OBJECTS | SHADOW, flat, &wheel, 1);
		uint8_t *first = draw(&camera, &shown, 1);
		gpu_stats(gpu, &before);
		assert_ok(render_resize(render, 2 * WIDTH, HEIGHT - 4));
		render_set_objects(render, &shown, 1);
		assert_ok(render_frame(render, &camera, &selection));
		assert_ok(render_resize(render, WIDTH, HEIGHT));
		gpu_stats(gpu, &after);
		assert_true(after.bytes == before.bytes);
		uint8_t *second = draw(&camera, &shown, 1);
		assert_memory_equal(first, second, 4 * WIDTH * HEIGHT);
		render_set_objects(render, NULL, 0);
		uint8_t *without = draw(&camera, NULL, 0);
		assert_memory_not_equal(without, second, 4 * WIDTH * HEIGHT);
		test_free(first);
		test_free(second);
		test_free(without);
		mem_fail_nth(2, 0);
		enum status status = render_resize(render, 2 * WIDTH, HEIGHT);
		mem_fail_nth(0, 0);
		assert_int_equal(status, STATUS_FAILED);
		end();
	}
	samples = 1;
}

static void an_eye_within_the_volume_sees_the_shadow(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	double way[2];
	shadow_way(way);
	const struct soil_shape large = {.kind = SOIL_SPHERE, .radius = 3};
	struct render_camera camera = camera_at((double[3]){8 + 4 * way[0], 8 + 4 * way[1], 0.4}, (double[3]){8 + 5 * way[0], 8 + 5 * way[1], 0});
	struct render_object object = posed(0, 8, 8, 3);
	begin(OBJECTS | SHADOW, flat, &large, 1);
	for (int k = 0; k < 2; k++) {
		render->objects->casts = k > 0;
		pixels[k] = draw(&camera, &object, 1);
	}
	assert_true(luminance(pixels[1], WIDTH / 2, HEIGHT / 2) < 0.7 * luminance(pixels[0], WIDTH / 2, HEIGHT / 2));
	end();
	test_free(pixels[0]);
	test_free(pixels[1]);
}

TEST_PROGRAM(object_shadows)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_shadow_lies_beside_its_object_away_from_the_sun),
		cmocka_unit_test(a_shadow_is_on_the_ground_alone),
		cmocka_unit_test(a_shadow_is_as_long_as_the_sun_is_low),
		cmocka_unit_test(where_no_sun_falls_a_shadow_is_not_dark_twice),
		cmocka_unit_test(in_a_shadow_ground_is_as_without_the_sun),
		cmocka_unit_test(with_samples_a_shadow_lies_there_too),
		cmocka_unit_test(resized_it_is_as_if_it_had_been_so),
		cmocka_unit_test(an_eye_within_the_volume_sees_the_shadow),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
