/* Objects in the picture: they cover what they must, whatever their number and distance. Skipped without GL. */
#include "objects_rig.h"
#include "../support/program.h"

#define FAR (600ll * 16384 / 16) /* tiles: about 10,000 km, and whole periods of the ground's pattern */

/* --- pictures of one tile, or of nothing, with objects --- */

/* A wall between y = 4 and y = 6. */
static double wall(double x, double y)
{
	return GROUND + (y > 4 && y < 6 ? 3 : 0);
}

static bool differs(const uint8_t *a, const uint8_t *b, int x, int y)
{
	return memcmp(a + 4 * (WIDTH * y + x), b + 4 * (WIDTH * y + x), 4) != 0;
}

/* --- silhouettes, by rays on the CPU --- */

/* The part of a ray within a slab, a cylinder about y, or a ball: narrows it. */
static void within_slab(double from, double step, double half, double part[2])
{
	double a = (-half - from) / step, b = (half - from) / step;
	part[0] = fmax(part[0], fmin(a, b));
	part[1] = fmin(part[1], fmax(a, b));
}

static void within_round(double a, double b, double c, double part[2])
{
	double root = b * b - a * c;
	if (root < 0)
		part[1] = -INFINITY;
	part[0] = fmax(part[0], (-b - sqrt(fmax(root, 0))) / a);
	part[1] = fmin(part[1], (-b + sqrt(fmax(root, 0))) / a);
}

/* Whether the ray meets the shape, cut by so much on all sides. */
static bool meets(const struct soil_shape *shape, const double from[3], const double step[3], double less)
{
	double part[2] = {0, INFINITY};
	if (shape->kind == SOIL_BOX) {
		for (int k = 0; k < 3; k++)
			within_slab(from[k], step[k], shape->size[k] / 2 - less, part);
		return part[0] < part[1];
	}
	double r = shape->radius - less, y = shape->kind == SOIL_SPHERE;
	within_round(step[0] * step[0] + step[2] * step[2] + y * step[1] * step[1], from[0] * step[0] + from[2] * step[2] + y * from[1] * step[1],
		     from[0] * from[0] + from[2] * from[2] + y * from[1] * from[1] - r * r, part);
	if (shape->kind == SOIL_WHEEL)
		within_slab(from[1], step[1], shape->width / 2 - less, part);
	return part[0] < part[1];
}

/* By pixel: whether the shape, cut by `less`, is there; at its middle, or anywhere within `reach` pixels of that. */
static bool covers(const struct render_camera *camera, const struct render_object *object, const struct soil_shape *shape, double less,
		   double x, double y)
{
	struct render_axes axes;
	double own[3][3], from[3] = {0, 0, 0}, step[3] = {0, 0, 0};
	render_axes(render, camera, &axes);
	soil_axes(object->yaw, object->pitch, object->roll, object->turned, own);
	for (int k = 0; k < 3; k++) {
		double ray = axes.forward[k] + (x - WIDTH / 2.0) / axes.focal * axes.right[k] + (y - HEIGHT / 2.0) / axes.focal * axes.up[k];
		for (int i = 0; i < 3; i++) {
			from[i] += own[i][k] * (camera->eye[k] - object->at[k]);
			step[i] += own[i][k] * ray;
		}
	}
	return meets(shape, from, step, less);
}

/* Over nothing: what is drawn is the shape, but for a pixel at its edge and what its rounding takes. */
static void check_silhouette(const struct soil_shape *shape, const struct render_camera *camera, const struct render_object *object,
			     double rounding)
{
	uint8_t *without = draw(camera, object, 0), *with = draw(camera, object, 1);
	int covered = 0, wrong = 0;
	for (int y = 1; y < HEIGHT - 1; y++)
		for (int x = 1; x < WIDTH - 1; x++) {
			bool all = true, any = false, is = differs(without, with, x, y);
			for (int k = 0; k < 9; k++) {
				double px = x + 0.5 + k % 3 - 1, py = y + 0.5 + k / 3 - 1;
				all = all && covers(camera, object, shape, rounding, px, py);
				any = any || covers(camera, object, shape, 0, px, py);
			}
			covered += is;
			wrong += (all && !is) || (!any && is);
		}
	assert_int_equal(wrong, 0);
	assert_true(covered > 10);
	test_free(without);
	test_free(with);
}

static void objects_cover_what_they_must(void **state)
{
	need_gpu();
	const struct soil_shape shapes[3] = {wheel, ball, box};
	/* The wheel's shoulders, and that corners alone lie on a circle: less than half a pixel. */
	const double roundings[3] = {0.12 * 0.5, 0.002, 0};
	begin(OBJECTS, NULL, shapes, 3);
	for (size_t i = 0; i < 3; i++)
		for (int k = 0; k < 12; k++) {
			/* As large as the picture, smaller, and a few pixels. */
			double far = k % 3 == 0 ? 1.9 : k % 3 == 1 ? 7 : 20, turn = 0.7 * k;
			struct render_object object = posed(i, 8, 8, 1);
			object.yaw = 0.4 * k;
			object.turned = shapes[i].kind != SOIL_BOX ? 1.1 * k : 0;
			object.pitch = shapes[i].kind == SOIL_BOX ? 0.3 * k : 0;
			object.roll = shapes[i].kind == SOIL_BOX ? -0.2 * k : 0;
			struct render_camera camera = camera_at((double[3]){8 + far * cos(turn), 8 + far * sin(turn), 1 + 0.3 * far},
								(double[3]){8.1, 8, 1.05});
			check_silhouette(&shapes[i], &camera, &object, roundings[i]);
		}
	end();
}

/* However they are put together into draws: what all of them cover is what each covers alone. */
static void each_is_drawn_where_it_is(void **state)
{
	need_gpu();
	const struct soil_shape shapes[4] = {box, wheel, box, ball};
	struct render_object shown[4];
	struct render_camera camera = camera_at((double[3]){8, 2, 2}, (double[3]){8, 8, 1});
	begin(OBJECTS, NULL, shapes, 4);
	for (size_t i = 0; i < 4; i++)
		shown[i] = posed(i, 5.3 + 1.8 * (double)i, 8, 1);
	uint8_t *none = draw(&camera, shown, 0), *all = draw(&camera, shown, 4);
	int covered[2] = {0, 0};
	for (size_t i = 0; i < 4; i++) {
		uint8_t *one = draw(&camera, &shown[i], 1);
		for (int k = 0; k < WIDTH * HEIGHT; k++)
			if (differs(none, one, k % WIDTH, k / WIDTH)) {
				assert_false(differs(one, all, k % WIDTH, k / WIDTH));
				covered[0]++;
			}
		test_free(one);
	}
	for (int k = 0; k < WIDTH * HEIGHT; k++)
		covered[1] += differs(none, all, k % WIDTH, k / WIDTH);
	assert_true(covered[0] > 1000 && covered[0] == covered[1]);
	test_free(none);
	test_free(all);
	end();
}

static void a_hill_hides_an_object(void **state)
{
	need_gpu();
	begin(OBJECTS, wall, &wheel, 1);
	struct render_object object = posed(0, 8, 9, 0.5);
	struct render_camera behind = camera_at((double[3]){8, 1, 1}, (double[3]){8, 9, 0.5});
	struct render_camera above = camera_at((double[3]){8, 1, 9}, (double[3]){8, 9, 0.5});
	for (int seen = 0; seen < 2; seen++) {
		const struct render_camera *camera = seen ? &above : &behind;
		uint8_t *without = draw(camera, &object, 0), *with = draw(camera, &object, 1);
		assert_int_equal(memcmp(without, with, 4 * WIDTH * HEIGHT) != 0, seen);
		test_free(without);
		test_free(with);
	}
	end();
}

/* --- everywhere, as many, and as few --- */

static void ten_thousand_kilometres_away_it_is_the_same(void **state)
{
	need_gpu();
	uint8_t *pixels[2];
	for (int far = 0; far < 2; far++) {
		away = far * FAR;
		begin(OBJECTS | SHADOW | EFFECT_BIT(EFFECT_FOG), flat, &lugged, 1);
		struct render_object object = posed(0, 8.123, 8.456, 0.49);
		object.yaw = 1;
		object.turned = 0.3;
		struct render_camera camera = camera_at((double[3]){6, 5, 2}, (double[3]){8, 8, 0.3});
		pixels[far] = draw(&camera, &object, 1);
		end();
	}
	away = 0;
	assert_true(difference(pixels[0], pixels[1]) < 0.02);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

static void what_is_small_or_out_of_sight_costs_less(void **state)
{
	need_gpu();
	const struct soil_shape shapes[4] = {lugged, lugged, lugged, box};
	struct gpu_stats before, after;
	begin(OBJECTS | SHADOW, NULL, shapes, 4);
	assert_ptr_equal(render->objects->shapes[2].corners, NULL); /* two shapes */
	struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 1});
	/* Near, farther, far, behind: three draws, of ever fewer triangles; then two that are alike. */
	uint64_t triangles[5];
	const double places[5] = {5.2, 10, 60, 2, 10};
	struct render_object shown[2];
	for (int k = 0; k < 5; k++) {
		shown[0] = posed(0, 8, places[k], 1);
		shown[1] = posed(1, 8.2, places[k] + 0.1, 1);
		gpu_stats(gpu, &before);
		test_free(draw(&camera, shown, k < 4 ? 1 : 2));
		gpu_stats(gpu, &after);
		assert_int_equal(after.passes[GPU_OBJECTS] - before.passes[GPU_OBJECTS], k != 3);
		triangles[k] = render_triangles(render);
		struct render_tiles tiles;
		render_tiles(render, &tiles);
		assert_int_equal(tiles.objects, k != 3);
		assert_int_equal(2 * tiles.shadowed, after.passes[GPU_SHADOW] - before.passes[GPU_SHADOW]);
	}
	assert_true(triangles[0] > 1.5 * triangles[1] && triangles[1] > triangles[2] && triangles[2] > 0);
	assert_int_equal(triangles[3], 0);
	assert_int_equal(triangles[4], 2 * triangles[1]);
	/* A box has one detail, which is drawn however small it is. */
	shown[0] = posed(3, 8, 60, 1);
	test_free(draw(&camera, shown, 1));
	assert_int_equal(render_triangles(render), 12);
	end();
}

static void a_million_triangles_draw(void **state)
{
	need_gpu();
	enum { ROUND = 1000, RINGS = 501 };
	static float vertices[ROUND * RINGS][3];
	static uint32_t triangles[2 * ROUND * (RINGS - 1)][3];
	struct soil_mesh mesh = {vertices, triangles, ROUND * RINGS, 2 * ROUND * (RINGS - 1), {-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}};
	for (uint32_t i = 0; i < ROUND * RINGS; i++) {
		double turn = 2 * M_PI * (i % ROUND) / ROUND, down = M_PI * (0.0005 + 0.999 * (i / ROUND) / (RINGS - 1));
		vertices[i][0] = (float)(0.6 * sin(down) * cos(turn));
		vertices[i][1] = (float)(0.6 * sin(down) * sin(turn));
		vertices[i][2] = (float)(0.6 * cos(down));
	}
	for (uint32_t i = 0, k = 0; i < ROUND * (RINGS - 1); i++) {
		uint32_t next = i % ROUND == ROUND - 1 ? i + 1 - ROUND : i + 1;
		const uint32_t two[2][3] = {{i, i + ROUND, next + ROUND}, {i, next + ROUND, next}};
		memcpy(triangles[k], two[i % 2], sizeof two[0]); /* in an order of its own, either way round */
		triangles[k + 1][0] = two[1 - i % 2][2];
		triangles[k + 1][1] = two[1 - i % 2][1];
		triangles[k + 1][2] = two[1 - i % 2][0];
		k += 2;
	}
	const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh};
	begin(OBJECTS, NULL, &shape, 1);
	struct render_object object = posed(0, 8, 8, 1);
	for (int k = 0; k < 2; k++) {
		struct render_camera camera = camera_at((double[3]){8, k > 0 ? 1 : 6, 1.2}, (double[3]){8, 8, 1});
		check_silhouette(&ball, &camera, &object, 0.01);
		assert_int_equal(render_triangles(render), 1000000);
	}
	/* Lit from outside, whichever way round its triangles are: the top is, the bottom is not. */
	struct render_camera camera = camera_at((double[3]){8, 6, 1}, (double[3]){8, 8, 1});
	uint8_t *pixels = draw(&camera, &object, 1);
	int top = luminance(pixels, WIDTH / 2, HEIGHT / 2 + 30), bottom = luminance(pixels, WIDTH / 2, HEIGHT / 2 - 35);
	assert_true(top > 1.5 * bottom && bottom > 0);
	for (int x = WIDTH / 2 - 20; x < WIDTH / 2 + 20; x++)
		assert_true(abs(luminance(pixels, x, HEIGHT / 2 + 30) - luminance(pixels, x + 1, HEIGHT / 2 + 30)) < 80);
	test_free(pixels);
	end();
}

static void none_is_there_that_was_not_named(void **state)
{
	need_gpu();
	struct gpu_stats before, after[2];
	gpu_stats(gpu, &before);
	for (int k = 0; k < 2; k++) {
		begin(SHADOW, flat, &wheel, (size_t)k); /* no objects are named; no object is there */
		assert_false(render_shows_objects(render));
		struct render_object object = posed(0, 8, 8, 0.5);
		struct render_camera camera = camera_at((double[3]){8, 4, 1}, (double[3]){8, 8, 1});
		test_free(draw(&camera, &object, (size_t)k));
		gpu_stats(gpu, &after[k]);
		end();
	}
	assert_int_equal(after[0].bytes, after[1].bytes);
	assert_int_equal(after[1].passes[GPU_OBJECTS], before.passes[GPU_OBJECTS]);
	assert_int_equal(after[1].passes[GPU_SHADOW], before.passes[GPU_SHADOW]);
}

static void what_cannot_be_allocated_is_told(void **state)
{
	need_gpu();
	objects[0] = (struct scene_object){.name = "it", .shape = wheel};
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .low = 0, .high = 1, .width = 32, .height = 16, .effects = OBJECTS | SHADOW,
		.objects = objects, .object_count = 1,
	};
	assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
	params.slots = slots;
	enum status status = STATUS_FAILED;
	int failed = 0;
	for (uint64_t nth = 1; status != STATUS_OK; nth++) {
		mem_fail_nth(nth, 0);
		status = render_create(&params, &render);
		mem_fail_nth(0, 0);
		failed += status != STATUS_OK;
		assert_true(nth < 100);
	}
	assert_true(failed >= 15);
	end();
}

TEST_PROGRAM(objects)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(objects_cover_what_they_must),
		cmocka_unit_test(each_is_drawn_where_it_is),
		cmocka_unit_test(a_hill_hides_an_object),
		cmocka_unit_test(ten_thousand_kilometres_away_it_is_the_same),
		cmocka_unit_test(what_is_small_or_out_of_sight_costs_less),
		cmocka_unit_test(a_million_triangles_draw),
		cmocka_unit_test(none_is_there_that_was_not_named),
		cmocka_unit_test(what_cannot_be_allocated_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
