/* Edges, light and depth: samples a pixel, their mean, sRGB, and how near two surfaces may be. Skipped without GL. */
#include <stdio.h>

#include "gpu_rig.h"
#include "render/internal.h"
#include "../support/program.h"
#include "../support/skip.h"

#define WIDTH 192
#define HEIGHT 108
#define PIXELS (WIDTH * HEIGHT)
#define CELLS 64
#define POSTS (CELLS + 1)

#define LOW -100.0 /* metres, of flat ground: it has the colour of what is low */

static struct gpu_slots *slots;
static struct render *render;
static struct render_selection selection;

#define need_samples(samples)                                                                      \
	do {                                                                                       \
		if (gpu == NULL)                                                                   \
			skip_since("no GL");                                                       \
		if (gpu_info(gpu)->samples_most < (samples))                                       \
			skip_since(SKIP_ELSEWHERE "the driver has no pictures with so many samples"); \
	} while (0)

static struct render_params params_of(const struct extent *extent, int samples)
{
	return (struct render_params){.gpu = gpu, .slots = slots, .extent = extent, .low = -1, .high = 1, .width = WIDTH,
				      .height = HEIGHT, .disturbance = true, .samples = samples};
}

/* Slot 0 is ground that rises by so much a post to the south-east, slot 1 the same `higher` by so many metres, and dirty. */
static void begin(const struct extent *extent, int samples, double rise, double higher)
{
	static int32_t base[POSTS * POSTS], raised[POSTS * POSTS];
	static uint8_t dirt[POSTS * POSTS];
	for (int i = 0; i < POSTS * POSTS; i++) {
		base[i] = lattice_base_relative(LOW + rise * (i % POSTS - i / POSTS), 0);
		raised[i] = (int32_t)lattice_offset(higher);
	}
	memset(dirt, 255, sizeof dirt);
	assert_ok(gpu_slots_create(gpu, CELLS, 2, PLANE_BIT(PLANE_DISTURBANCE), &slots));
	const struct render_params params = params_of(extent, samples);
	assert_ok(render_create(&params, &render));
	for (uint32_t slot = 0; slot < 2; slot++)
		assert_ok(staged_upload_base(gpu, slots, CELLS, slot, base));
	assert_ok(staged_upload_deform(gpu, slots, CELLS, 1, raised, dirt));
}

static void end(void)
{
	render_destroy(render);
	gpu_slots_destroy(slots);
	render = NULL;
	slots = NULL;
}

/* The world's only tile, from these slots in turn. */
static void draw(const struct render_camera *camera, const uint32_t *from, size_t count, uint8_t *pixels)
{
	selection.draw_count = count;
	for (size_t i = 0; i < count; i++)
		selection.draws[i] = (struct render_draw){
			.tile = {0, 0, 0}, .slot = from[i], .ground = from[i], .quadrants = 15, .finest = true, .low = LOW - 60, .high = LOW + 60,
		};
	assert_ok(render_frame(render, camera, &selection));
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
	assert_ok(gpu_check(gpu, "reading the picture back"));
}

static size_t pixels_that_differ(const uint8_t *a, const uint8_t *b)
{
	size_t differ = 0;
	for (size_t i = 0; i < PIXELS; i++)
		differ += memcmp(a + 4 * i, b + 4 * i, 3) != 0;
	return differ;
}

/* --- edges --- */

static const struct extent meadow = {POSTS, POSTS, 1, CELLS};
/* Over ground that lies in the dark, turned from the sun, to what is beyond it. */
#define DARK 0.6
static const struct render_camera along = {{20, -12, LOW + 30}, {36, 60, LOW - 10}, 0.9, {0}};

static uint8_t behind[3]; /* what a frame begins with, found by the first test */

static void what_is_behind_has_the_byte_of_its_light(void **state)
{
	static const uint8_t known[3] = {197, 214, 231}; /* 0.56, 0.67, 0.80 in sRGB */
	static uint8_t pixels[4 * PIXELS];
	for (int samples = 1; samples <= 4; samples += 3) {
		need_samples((uint32_t)samples);
		begin(&meadow, samples, DARK, 0);
		draw(&along, NULL, 0, pixels);
		if (samples == 1)
			memcpy(behind, pixels, sizeof behind);
		for (size_t p = 0; p < PIXELS; p++)
			assert_memory_equal(pixels + 4 * p, behind, sizeof behind);
		for (int c = 0; c < 3; c++)
			assert_in_range(behind[c], known[c] - 1, known[c] + 1); /* GL allows 0.6 */
		end();
	}
}

static double light_of(uint8_t byte)
{
	double c = byte / 255.0;
	return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static double byte_of(double light)
{
	return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055);
}

/* The light of so many of four samples on the ground, the others behind it. */
static bool is_between(const uint8_t *pixel, const uint8_t *ground, int samples_on)
{
	for (int c = 0; c < 3; c++) {
		double light = (samples_on * light_of(ground[c]) + (4 - samples_on) * light_of(behind[c])) / 4;
		if (!(fabs(byte_of(light) - pixel[c]) <= 2))
			return false;
	}
	return true;
}

static void an_edge_of_four_samples_is_between_in_light(void **state)
{
	static uint8_t pixels[2][4 * PIXELS];
	need_samples(4);
	size_t on[5] = {0};
	double mean[2] = {0, 0};
	const uint8_t *ground = NULL;
	for (int i = 0; i < 2; i++) {
		begin(&meadow, i == 0 ? 1 : 4, DARK, 0);
		draw(&along, (const uint32_t[]){0}, 1, pixels[i]);
		end();
	}
	/* Such ground has one colour, but for rounding. */
	for (size_t p = 0; p < PIXELS; p++) {
		const uint8_t *pixel = pixels[0] + 4 * p;
		if (memcmp(pixel, behind, 3) == 0)
			continue;
		ground = ground != NULL ? ground : pixel;
		for (int c = 0; c < 3; c++)
			assert_in_range(pixel[c] + 1, ground[c], ground[c] + 2);
	}
	assert_non_null(ground);
	assert_true(ground[1] < 100); /* or it would not matter what the mean is of */
	for (size_t p = 0; p < PIXELS; p++) {
		const uint8_t *pixel = pixels[1] + 4 * p;
		int which = 0;
		while (which < 5 && !is_between(pixel, ground, which))
			which++;
		assert_true(which < 5);
		on[which]++;
		for (int i = 0; i < 2; i++)
			mean[i] += light_of(pixels[i][4 * p + 1]) / PIXELS;
	}
	assert_true(on[0] > PIXELS / 10 && on[4] > PIXELS / 10);
	for (int which = 1; which < 4; which++)
		assert_in_range(on[which], 10, PIXELS / 20);
	assert_true(fabs(mean[0] - mean[1]) < 0.002);
}

static void one_sample_has_no_more_than_it_had(void **state)
{
	struct gpu_stats before, one, four;
	need_samples(4);
	const uint64_t pair = 2 * 4 * PIXELS;
	uint8_t *pixels = test_malloc(4 * PIXELS);
	gpu_stats(gpu, &before);
	begin(&meadow, 1, DARK, 0);
	assert_null(render->screen->drawn);
	assert_null(render->screen->resolved);
	draw(&along, (const uint32_t[]){0}, 1, pixels);
	gpu_stats(gpu, &one);
	assert_int_equal(one.passes[GPU_RESOLVE], before.passes[GPU_RESOLVE]);
	end();
	begin(&meadow, 4, DARK, 0);
	draw(&along, (const uint32_t[]){0}, 1, pixels);
	gpu_stats(gpu, &four);
	assert_int_equal(four.passes[GPU_RESOLVE], one.passes[GPU_RESOLVE] + 1);
	assert_int_equal(four.textures, one.textures + 1);
	/* Colour and depth of four, and the colour of one. */
	assert_int_equal(four.bytes - one.bytes, 4 * pair - pair / 2);
	end();
	test_free(pixels);
}

/* --- depth --- */

/* Seen together, in either order, the upper of two surfaces hides the lower everywhere. */
static void stand_apart(const struct extent *extent, const struct render_camera *camera, double apart, int samples)
{
	static uint8_t lower[4 * PIXELS], upper[4 * PIXELS], both[4 * PIXELS];
	begin(extent, samples, 0, apart);
	draw(camera, (const uint32_t[]){0}, 1, lower);
	draw(camera, (const uint32_t[]){1}, 1, upper);
	assert_true(pixels_that_differ(lower, upper) > PIXELS / 3);
	draw(camera, (const uint32_t[]){0, 1}, 2, both);
	assert_int_equal(pixels_that_differ(both, upper), 0);
	draw(camera, (const uint32_t[]){1, 0}, 2, both);
	/* At the ground's edge the lower one may stand out. */
	assert_in_range(pixels_that_differ(both, upper), 0, samples > 1 ? 10 : 0);
	end();
}

static void near_surfaces_do_not_fight(void **state)
{
	static const struct extent land = {POSTS, POSTS, 256, CELLS};
	const struct render_camera at_100_m = {{32, -28, LOW + 80}, {32, 32, LOW}, 0.4, {0}};
	const struct render_camera at_50_km = {{8192, -31808, 30000}, {8192, 8192, 0}, 0.25, {0}};
	need_samples(1);
	stand_apart(&meadow, &at_100_m, 0.001, 1);
	stand_apart(&land, &at_50_km, 1, 1);
	need_samples(4);
	stand_apart(&meadow, &at_100_m, 0.001, 4);
	stand_apart(&land, &at_50_km, 1, 4);
}

/* --- failures --- */

static void more_than_the_driver_has_is_refused(void **state)
{
	need_samples(1);
	uint32_t most = gpu_info(gpu)->samples_most;
	char words[64];
	struct render_params params = params_of(&meadow, 2 * (int)most);
	assert_int_equal(render_create(&params, &render), STATUS_INPUT);
	snprintf(words, sizeof words, "view.samples: %u: ", 2 * most);
	assert_non_null(strstr(failure_message(), words));
	snprintf(words, sizeof words, "at most %u a pixel; ", most);
	assert_non_null(strstr(failure_message(), words));
	assert_ok(render_check_samples(gpu, (int)most));
}

static void what_cannot_be_allocated_is_told(void **state)
{
	need_samples(2);
	struct render_params params = params_of(&meadow, 2);
	enum status status = STATUS_FAILED;
	int failed = 0;
	for (uint64_t nth = 1; status != STATUS_OK; nth++) {
		mem_fail_nth(nth, 0);
		status = render_create(&params, &render);
		mem_fail_nth(0, 0);
		failed += status != STATUS_OK;
		assert_true(nth < 100);
	}
	assert_true(failed >= 8);
	render_destroy(render);
}

/* --- overdraw --- */

/* Of the frames since it was last asked. */
static double overdraw(uint64_t frames)
{
	double sum;
	gpu_finish(gpu);
	assert_int_equal(render_take_overdraw(render, &sum), frames);
	return sum / (double)frames;
}

/* From straight above, so that ground fills the picture: once; by another over it twice; by one under it no more. */
static void what_passes_the_depth_test_is_counted(void **state)
{
	static const struct render_camera above = {{32, 32, LOW + 20}, {32, 32.01, LOW}, 0.9, {0}}, half = {{0, 32, LOW + 20}, {0, 32.01, LOW}, 0.9, {0}};
	static const uint32_t far_to_near[2] = {0, 1}, near_to_far[2] = {1, 0};
	static uint8_t pixels[4 * PIXELS];
	for (int samples = 1; samples <= 4; samples += 3) {
		double sum;
		need_samples((uint32_t)samples);
		begin(&meadow, samples, 0, 2);
		draw(&above, far_to_near, 1, pixels);
		assert_true(overdraw(1) == 1);
		draw(&above, far_to_near, 2, pixels);
		assert_true(overdraw(1) == 2);
		draw(&above, near_to_far, 2, pixels);
		assert_true(overdraw(1) == 1);
		draw(&half, far_to_near, 1, pixels);
		assert_true(fabs(overdraw(1) - 0.5) < 0.01);
		draw(&above, NULL, 0, pixels);
		assert_true(overdraw(1) == 0);
		/* More frames than the counter has queries: what is known is whole, however late it is asked for. */
		for (int i = 0; i < 40; i++)
			assert_ok(render_frame(render, &above, &selection));
		gpu_finish(gpu);
		selection.draw_count = 1;
		selection.draws[0].slot = 0;
		for (int i = 0; i < 40; i++)
			assert_ok(render_frame(render, &above, &selection));
		gpu_finish(gpu);
		uint64_t known = render_take_overdraw(render, &sum);
		assert_true(known >= 16 && known <= 80 && sum == floor(sum) && sum <= 40);
		assert_int_equal(render_take_overdraw(render, &sum), 0);
		end();
	}
}

TEST_PROGRAM(samples)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_behind_has_the_byte_of_its_light),
		cmocka_unit_test(an_edge_of_four_samples_is_between_in_light),
		cmocka_unit_test(one_sample_has_no_more_than_it_had),
		cmocka_unit_test(near_surfaces_do_not_fight),
		cmocka_unit_test(more_than_the_driver_has_is_refused),
		cmocka_unit_test(what_passes_the_depth_test_is_counted),
		cmocka_unit_test(what_cannot_be_allocated_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
