/* The picture itself: holes, ruts, repeatability, pairs of effects, lack of memory. Skipped without GL. */
#include "../pairs.h"
#include "../support/program.h"
#include "picture_rig.h"

#define ALL (EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) | EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS))

/* --- a world: hills with a grain, and what each test adds --- */

static const uint8_t *pixel(const uint8_t *pixels, int x, int y)
{
	return pixels + 4 * (WIDTH * y + x);
}

/* What is drawn before the first frame leaves no trace in it. */
static void what_is_drawn_unseen_is_not_seen(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	begin(ALL);
	uint8_t *before = draw(60, 60, 20, 300, 300, 0);
	uint64_t triangles = render_triangles(render);
	assert_ok(render_draw_unseen(render, true, true, true));
	uint8_t *after = draw(60, 60, 20, 300, 300, 0);
	assert_memory_equal(before, after, 4 * WIDTH * HEIGHT);
	assert_true(render_triangles(render) == triangles);
	test_free(before);
	test_free(after);
	end();
}

static int luminance(const uint8_t *p)
{
	return 2 * p[0] + 5 * p[1] + p[2];
}

static void nodata_shows_what_is_behind_and_nothing_else_does(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.hole[0] = 190;
	ground.hole[1] = 190;
	ground.hole[2] = 210;
	ground.hole[3] = 210;
	begin(0);
	uint8_t background[4];
	find_background(background);
	uint8_t *pixels = draw(200, 200, 100, 200, 200.001, 0);
	/* Triangles from 188 to 212 touch a hole; a metre is this many pixels from 100 m above. */
	double scale = HEIGHT / 2.0 / tan(0.45) / 100;
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++) {
			double dx = fabs(x + 0.5 - WIDTH / 2.0) / scale, dy = fabs(y + 0.5 - HEIGHT / 2.0) / scale;
			double far = fmax(dx, dy);
			bool corner = dx > 7 && dx < 13 && dy > 7 && dy < 13; /* half of it may be drawn */
			if (fabs(far - 12) < 1 || corner)
				continue;
			assert_int_equal(memcmp(pixel(pixels, x, y), background, 4) == 0, far < 12);
		}
	test_free(pixels);
	end();
}

static void a_rut_is_darker_than_the_ground_beside_it(void **state)
{
	need_gpu();
	const uint64_t effects[] = {0, EFFECT_BIT(EFFECT_TEXTURE), ALL};
	memset(&ground, 0, sizeof ground);
	ground.rut[0] = 194;
	ground.rut[1] = 0;
	ground.rut[2] = 206;
	ground.rut[3] = 512;
	ground.deep = 0.2;
	for (size_t e = 0; e < 3; e++) {
		begin(effects[e]);
		uint8_t *pixels = draw(200, 200, 60, 200, 200.001, 0);
		long in = 0, beside = 0;
		for (int y = 0; y < HEIGHT; y++) {
			in += luminance(pixel(pixels, WIDTH / 2, y));
			beside += luminance(pixel(pixels, WIDTH / 2 + 30, y));
		}
		assert_true(in * 10 < beside * 9);
		test_free(pixels);
		end();
	}
}

static void an_untouched_tile_has_a_program_without_offsets(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	begin(EFFECT_BIT(EFFECT_FOG));
	struct gpu_stats before, after;
	gpu_stats(gpu, &before);
	test_free(draw(200, 200, 60, 200, 200.001, 0));
	gpu_stats(gpu, &after);
	assert_int_equal(after.programs - before.programs, 1);
	assert_int_equal(after.passes[GPU_TERRAIN] - before.passes[GPU_TERRAIN], selection.draw_count);
	end();
}

static void the_same_view_gives_the_same_bits(void **state)
{
	need_gpu();
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	begin(ALL);
	uint8_t *first = draw(100, 90, 25, 250, 260, -10), *other = draw(300, 90, 25, 250, 260, -10);
	uint8_t *again = draw(100, 90, 25, 250, 260, -10);
	assert_memory_equal(first, again, 4 * WIDTH * HEIGHT);
	assert_memory_not_equal(first, other, 4 * WIDTH * HEIGHT);
	test_free(first);
	test_free(other);
	test_free(again);
	end();
}

static void a_tile_looks_the_same_ten_thousand_kilometres_away(void **state)
{
	need_gpu();
	static const struct extent wide = {40000001, 40000001, 0.25, CELLS};
	static int32_t base[POSTS * POSTS];
	uint8_t *pixels[2];
	for (int j = 0; j < POSTS; j++)
		for (int i = 0; i < POSTS; i++)
			base[j * POSTS + i] = lattice_base_relative(8000 + sin(i * 0.4) * cos(j * 0.3), 8192);
	for (int far = 0; far < 2; far++) {
		/* Moved by a whole number of the ground pattern's periods. */
		uint32_t shift = far ? 600 * 16384 / 16 : 0;
		struct render_params params = {
			.gpu = gpu, .extent = &wide, .reference = 8192, .low = 7999, .high = 8001, .width = WIDTH,
			.height = HEIGHT, .effects = ALL & ~(EFFECT_BIT(EFFECT_SKY)),
		};
		struct render_camera camera = {{shift * 16.0 + 18, shift * 16.0 + 17, 8006}, {shift * 16.0 + 25, shift * 16.0 + 25, 8000}, 0.9, {0}};
		assert_ok(gpu_slots_create(gpu, CELLS, 1, 0, &slots));
		params.slots = slots;
		assert_ok(render_create(&params, &render));
		assert_ok(staged_upload_base(gpu, slots, CELLS, 0, base));
		selection.draw_count = 1;
		selection.draws[0] = (struct render_draw){
			.tile = {0, shift + 1, shift + 1}, .quadrants = 15, .finest = true, .low = 7999, .high = 8001,
		};
		assert_ok(render_frame(render, &camera, &selection));
		pixels[far] = test_malloc(4 * WIDTH * HEIGHT);
		gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels[far]);
		end();
	}
	assert_true(difference(pixels[0], pixels[1]) < 0.02);
	test_free(pixels[0]);
	test_free(pixels[1]);
}

/* Of texture, detail, fog, sky, geomorphing and skirts: none, all, and any two in all four ways. */
static void any_two_effects_draw_together(void **state)
{
	enum { EFFECTS = EFFECT_SKIRTS - EFFECT_TEXTURE + 1 };
	need_gpu();
	for (int one = 0; one < EFFECTS; one++)
		for (int other = 0; other < one; other++)
			assert_int_equal(pairs_met(one, other), 15);
	memset(&ground, 0, sizeof ground);
	ground.roughness = 1;
	static int32_t posts[POSTS * POSTS];
	static uint8_t dirt[POSTS * POSTS];
	for (int i = 0; i < PAIRS_CHOICES; i++) {
		uint64_t chosen = pairs_choices[i] & ((1u << EFFECTS) - 1); /* the first: all */
		struct render_params params = {
			.gpu = gpu, .extent = &extent, .low = -1, .high = 1, .width = 32, .height = 16,
			.effects = chosen << EFFECT_TEXTURE, .disturbance = true,
		};
		assert_ok(gpu_slots_create(gpu, CELLS, 3, PLANE_BIT(PLANE_DISTURBANCE), &slots));
		params.slots = slots;
		assert_ok(render_create(&params, &render));
		for (uint32_t k = 0; k < 3; k++)
			assert_ok(staged_upload_base(gpu, slots, CELLS, k, posts));
		assert_ok(staged_upload_deform(gpu, slots, CELLS, 1, posts, dirt));
		assert_ok(staged_upload_deform(gpu, slots, CELLS, 2, posts, dirt));
		selection.draw_count = 3;
		for (uint32_t k = 0; k < 3; k++)
			selection.draws[k] = (struct render_draw){
				.tile = {k == 2 ? -1 : 0, k, 0}, .slot = k, .ground = k == 2 ? 0 : k, .quadrants = 15,
				.low = -1, .high = 1,
			};
		struct render_camera camera = {{100, -30, 60}, {100, 64, 0}, 0.9, {0}};
		assert_ok(render_frame(render, &camera, &selection));
		assert_true(render_triangles(render) > 0);
		end();
	}
}

static void what_cannot_be_allocated_is_told(void **state)
{
	need_gpu();
	struct render_params params = {
		.gpu = gpu, .extent = &extent, .low = 0, .high = 1, .width = 32, .height = 16, .effects = ALL,
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
	assert_true(failed >= 5);
	end();
}

TEST_PROGRAM(picture)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nodata_shows_what_is_behind_and_nothing_else_does),
		cmocka_unit_test(a_rut_is_darker_than_the_ground_beside_it),
		cmocka_unit_test(an_untouched_tile_has_a_program_without_offsets),
		cmocka_unit_test(what_is_drawn_unseen_is_not_seen),
		cmocka_unit_test(the_same_view_gives_the_same_bits),
		cmocka_unit_test(a_tile_looks_the_same_ten_thousand_kilometres_away),
		cmocka_unit_test(any_two_effects_draw_together),
		cmocka_unit_test(what_cannot_be_allocated_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
