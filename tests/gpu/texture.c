/* Textures: what goes in comes out, for every format, layer and rectangle; targets clear. */
#include "gpu_test.h"
#include "../support/program.h"

enum { WIDTH = 21, HEIGHT = 13, LAYERS = 3 };

static uint32_t format_bytes(enum gpu_format format)
{
	switch (format) {
	case GPU_R8UI:
	case GPU_R8:
		return 1;
	case GPU_R16:
	case GPU_R16F:
		return 2;
	case GPU_RGBA32I:
	case GPU_RGBA32F:
		return 16;
	default:
		return 4;
	}
}

/* What a texture should hold, moved by the same calls. */
struct model {
	uint8_t bytes[LAYERS][HEIGHT][WIDTH][16];
};

static void model_check(const struct model *model, struct gpu_texture *texture, uint32_t layers)
{
	uint8_t read[HEIGHT * WIDTH * 16];
	uint32_t size = format_bytes(texture->format);
	for (uint32_t layer = 0; layer < layers; layer++) {
		gpu_texture_read(texture, layer, rect_of(0, 0, WIDTH, HEIGHT), read);
		for (size_t i = 0; i < (size_t)HEIGHT * WIDTH; i++)
			assert_memory_equal(read + i * size, model->bytes[layer][i / WIDTH][i % WIDTH], size);
	}
}

static struct gpu_rect any_rect(void)
{
	uint32_t x = any_word() % WIDTH, y = any_word() % HEIGHT;
	return rect_of(x, y, any_word() % (WIDTH - x + 1), any_word() % (HEIGHT - y + 1));
}

/* Texel bits that are a number in every format, and one that a lesser format would not hold. */
static uint32_t any_texel(enum gpu_format format)
{
	switch (format) {
	case GPU_DEPTH32F: /* 1/2 .. 1 */
		return 0x3f000000u + any_word() % 0x800000u;
	case GPU_R32F: /* -2 .. -1 */
	case GPU_RGBA32F:
		return 0xbf800000u + any_word() % 0x800000u;
	case GPU_R16F:
		return 0xbc00u + any_word() % 0x400u;
	default:
		return any_word();
	}
}

static void upload(struct model *model, struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect)
{
	uint8_t data[HEIGHT * WIDTH * 16];
	uint32_t size = format_bytes(texture->format);
	size_t count = 0;
	for (uint32_t y = rect.y; y < rect.y + rect.height; y++) {
		for (uint32_t x = rect.x; x < rect.x + rect.width; x++) {
			uint32_t texel[4] = {any_texel(texture->format), any_word(), any_word(), any_word()};
			memcpy(data + count++ * size, texel, size);
			memcpy(model->bytes[layer][y][x], texel, size);
		}
	}
	gpu_texture_upload(texture, layer, rect, data);
}

static void clear(struct model *model, struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect)
{
	uint32_t one = any_texel(texture->format), texel[4] = {one, one, one, one};
	for (uint32_t y = rect.y; y < rect.y + rect.height; y++)
		for (uint32_t x = rect.x; x < rect.x + rect.width; x++)
			memcpy(model->bytes[layer][y][x], texel, format_bytes(texture->format));
	gpu_texture_clear(texture, layer, rect, (int32_t)one);
}

static void uploads_clears_and_copies_are_read_back_exactly(void **state)
{
	(void)state;
	need_gpu();
	for (int format = GPU_R32I; format <= GPU_DEPTH32F; format++) {
		for (uint32_t layers = 0; layers <= LAYERS; layers += LAYERS) {
			uint32_t count = layers > 0 ? layers : 1;
			struct gpu_texture *texture, *other;
			static struct model model, other_model;
			assert_ok(gpu_texture_create(test_gpu, (enum gpu_format)format, WIDTH, HEIGHT, layers, &texture));
			assert_ok(gpu_texture_create(test_gpu, (enum gpu_format)format, WIDTH, HEIGHT, 0, &other));
			assert_int_equal(gpu_texel_bytes(other), format_bytes((enum gpu_format)format));
			for (uint32_t layer = 0; layer < count; layer++)
				upload(&model, texture, layer, rect_of(0, 0, WIDTH, HEIGHT));
			clear(&other_model, other, 0, rect_of(0, 0, WIDTH, HEIGHT));
			for (int i = 0; i < 20; i++) {
				uint32_t layer = any_word() % count;
				struct gpu_rect rect = any_rect();
				upload(&model, texture, layer, any_rect());
				clear(&model, texture, layer, any_rect());
				uint32_t x = any_word() % (WIDTH - rect.width + 1), y = any_word() % (HEIGHT - rect.height + 1);
				gpu_texture_copy(texture, layer, x, y, other, 0, rect);
				for (uint32_t row = 0; row < rect.height; row++)
					memcpy(other_model.bytes[0][rect.y + row][rect.x], model.bytes[layer][y + row][x],
					       rect.width * sizeof model.bytes[0][0][0]);
			}
			model_check(&model, texture, count);
			model_check(&other_model, other, 1);
			assert_ok(gpu_check(test_gpu, "textures"));
			gpu_texture_destroy(texture);
			gpu_texture_destroy(other);
		}
	}
}

static void a_part_is_read_tightly(void **state)
{
	int32_t values[6 * 5], read[2 * 3];
	(void)state;
	need_gpu();
	for (int i = 0; i < 30; i++)
		values[i] = i;
	struct gpu_texture *texture = ints_texture(values, 6, 5);
	gpu_texture_read(texture, 0, rect_of(3, 1, 2, 3), read);
	const int32_t expected[] = {9, 10, 15, 16, 21, 22};
	assert_memory_equal(read, expected, sizeof read);
	gpu_texture_destroy(texture);
}

static void a_target_clears_its_colours_and_its_depth(void **state)
{
	struct gpu_texture *linear, *srgb, *depth;
	struct gpu_target *target, *srgb_target;
	const float half[4] = {0.5f, 0, 1, 1};
	uint8_t texel[4];
	float near = 5;
	(void)state;
	need_gpu();
	assert_ok(gpu_texture_create(test_gpu, GPU_RGBA8, 4, 4, 0, &linear));
	assert_ok(gpu_texture_create(test_gpu, GPU_SRGB8_ALPHA8, 4, 4, 0, &srgb));
	assert_ok(gpu_texture_create(test_gpu, GPU_DEPTH32F, 4, 4, 0, &depth));
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){linear, 0}, 1, (struct gpu_attachment){depth, 0}, &target));
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){srgb, 0}, 1, (struct gpu_attachment){NULL, 0}, &srgb_target));
	gpu_texture_upload(depth, 0, rect_of(3, 3, 1, 1), &near);
	gpu_target_clear(srgb_target, half);
	gpu_target_clear(target, half);
	gpu_texture_read(linear, 0, rect_of(3, 3, 1, 1), texel);
	assert_in_range(texel[0], 127, 128);
	assert_int_equal(texel[2], 255);
	gpu_texture_read(srgb, 0, rect_of(3, 3, 1, 1), texel);
	assert_in_range(texel[0], 187, 188); /* 0.5 linear, encoded */
	gpu_texture_read(depth, 0, rect_of(3, 3, 1, 1), &near);
	assert_true(near == 0);
	assert_ok(gpu_check(test_gpu, "clears"));
	gpu_target_destroy(target);
	gpu_target_destroy(srgb_target);
	gpu_texture_destroy(linear);
	gpu_texture_destroy(srgb);
	gpu_texture_destroy(depth);
}

static void all_levels_are_counted_and_each_is_its_own(void **state)
{
	enum { SIDE = 8, LAYERS_OF = 3 };
	uint8_t texels[4 * LAYERS_OF * SIDE * SIDE], read[4 * SIDE * SIDE];
	struct gpu_stats before, alive, after;
	struct gpu_texture *texture;
	(void)state;
	need_gpu();
	gpu_stats(test_gpu, &before);
	assert_ok(gpu_texture_create_mipmapped(test_gpu, GPU_RGBA8, SIDE, LAYERS_OF, &texture));
	gpu_stats(test_gpu, &alive);
	assert_int_equal(gpu_mipmap_levels(SIDE), 4);
	assert_int_equal(alive.bytes - before.bytes, 4 * LAYERS_OF * (64 + 16 + 4 + 1));
	assert_int_equal(alive.bytes - before.bytes, gpu_texture_bytes(GPU_RGBA8, SIDE, SIDE, LAYERS_OF, 4));
	for (size_t i = 0; i < sizeof texels; i++)
		texels[i] = (uint8_t)(7 * i);
	gpu_texture_upload_level(texture, 0, texels);
	memset(texels, 200, sizeof texels);
	for (uint32_t level = 1; level < 4; level++)
		gpu_texture_upload_level(texture, level, texels);
	gpu_texture_read(texture, 2, rect_of(0, 0, SIDE, SIDE), read);
	for (size_t i = 0; i < sizeof read; i++)
		assert_int_equal(read[i], (uint8_t)(7 * (i + 2 * sizeof read)));
	assert_ok(gpu_check(test_gpu, "levels"));
	gpu_texture_destroy(texture);
	gpu_stats(test_gpu, &after);
	assert_int_equal(after.bytes, before.bytes);
	assert_int_equal(after.textures, before.textures);
}

static void a_view_has_the_texels_of_its_layer(void **state)
{
	enum { SIDE = 9, LAYERS_OF = 4, ALL = SIDE * SIDE };
	int32_t texels[ALL], read[ALL];
	struct gpu_texture *array, *views[2];
	struct gpu_stats before, alive, after;
	struct gpu_target *target;
	(void)state;
	need_gpu();
	const struct gpu_rect all = rect_of(0, 0, SIDE, SIDE), part = rect_of(2, 3, 4, 5);
	gpu_stats(test_gpu, &before);
	assert_ok(gpu_texture_create(test_gpu, GPU_R32I, SIDE, SIDE, LAYERS_OF, &array));
	for (uint32_t i = 0; i < 2; i++)
		assert_ok(gpu_texture_create_view(array, 1 + 2 * i, &views[i]));
	gpu_stats(test_gpu, &alive);
	assert_int_equal(alive.bytes - before.bytes, 4 * LAYERS_OF * ALL);
	for (uint32_t layer = 0; layer < LAYERS_OF; layer++)
		gpu_texture_clear(array, layer, all, (int32_t)layer);
	for (int i = 0; i < ALL; i++)
		texels[i] = 1000 + 7 * i;
	gpu_texture_upload(views[1], 0, all, texels);
	gpu_texture_copy(views[1], 0, 2, 3, views[0], 0, part);
	gpu_texture_clear(views[1], 0, part, -5);
	for (uint32_t layer = 0; layer < LAYERS_OF; layer++) {
		gpu_texture_read(array, layer, all, read);
		for (uint32_t i = 0; i < ALL; i++) {
			const uint32_t x = i % SIDE, y = i / SIDE;
			const bool inside = x >= 2 && x < 6 && y >= 3 && y < 8;
			const int32_t is[LAYERS_OF] = {0, inside ? texels[i] : 1, 2, inside ? -5 : texels[i]};
			assert_int_equal(read[i], is[layer]);
		}
	}
	gpu_texture_upload(array, 3, all, texels);
	gpu_texture_read(views[1], 0, all, read);
	assert_memory_equal(read, texels, sizeof texels);
	gpu_texture_read(views[1], 0, part, read);
	for (uint32_t i = 0; i < part.width * part.height; i++)
		assert_int_equal(read[i], texels[(part.y + i / part.width) * SIDE + part.x + i % part.width]);
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){views[0], 0}, 1, (struct gpu_attachment){NULL, 0}, &target));
	assert_ok(gpu_check(test_gpu, "views"));
	gpu_target_destroy(target);
	for (int i = 0; i < 2; i++)
		gpu_texture_destroy(views[i]);
	gpu_texture_destroy(array);
	gpu_stats(test_gpu, &after);
	assert_int_equal(after.bytes, before.bytes);
	assert_int_equal(after.textures, before.textures);
}

TEST_PROGRAM(texture)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(uploads_clears_and_copies_are_read_back_exactly),
		cmocka_unit_test(a_part_is_read_tightly),
		cmocka_unit_test(a_target_clears_its_colours_and_its_depth),
		cmocka_unit_test(all_levels_are_counted_and_each_is_its_own),
		cmocka_unit_test(a_view_has_the_texels_of_its_layer),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
