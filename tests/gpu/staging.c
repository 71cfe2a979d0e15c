/* Staging: the same bits arrive by either way of transfer, in the order they were begun; and what
 * fails is told. */
#include "gpu_test.h"
#include "../support/program.h"

/* How a driver's kind is served; the other way must work on it too. */
static const bool ways[] = {false, true};
#define EACH_WAY(direct_way) for (size_t direct_way = 0; direct_way < 2; direct_way++)

static struct gpu_staging *staging_of(size_t bytes, size_t way)
{
	struct gpu_staging *staging;
	assert_ok(gpu_staging_create(test_gpu, bytes, &staging));
	assert_true(gpu_staging_idle(staging));
	assert_int_equal((uintptr_t)gpu_staging_bytes(staging) % 16, 0);
	staging->direct = ways[way];
	return staging;
}

static void await(struct gpu_staging *staging)
{
	while (!gpu_staging_idle(staging))
		;
	assert_null(staging->fence);
	assert_ok(gpu_check(test_gpu, "staging"));
}

static uint8_t *noise(size_t bytes)
{
	uint8_t *values = mem_alloc(bytes, 1);
	assert_non_null(values);
	for (size_t i = 0; i < bytes; i++)
		values[i] = (uint8_t)any_word();
	return values;
}

/* Up and down again through one staging, into the middle of a larger texture, and beside it nothing. */
static void carry(enum gpu_format format, size_t texel, uint32_t layers, struct gpu_rect rect, size_t way)
{
	uint32_t width = rect.x + rect.width + 2, height = rect.y + rect.height + 1, layer = layers > 0 ? layers - 1 : 0;
	size_t bytes = rect.width * rect.height * texel, gap = 3 * texel;
	uint8_t *data = noise(bytes), *seen = mem_alloc(width * height, texel);
	struct gpu_texture *texture;
	assert_non_null(seen);
	assert_ok(gpu_texture_create(test_gpu, format, width, height, layers, &texture));
	gpu_texture_clear(texture, layer, rect_of(0, 0, width, height), 0);
	struct gpu_staging *staging = staging_of(2 * bytes + 3 * gap, way);
	uint8_t *map = gpu_staging_bytes(staging);
	memset(map, 0xa5, 2 * bytes + 3 * gap);
	memcpy(map + gap, data, bytes);
	gpu_texture_upload_from(texture, layer, rect, staging, gap);
	assert_int_equal(staging->fence != NULL, !ways[way]);
	gpu_texture_read_into(texture, layer, rect, staging, 2 * gap + bytes);
	await(staging);
	assert_memory_equal(map + gap, data, bytes);
	assert_memory_equal(map + 2 * gap + bytes, data, bytes);
	for (size_t i = 0; i < gap; i++)
		assert_true(map[i] == 0xa5 && map[gap + bytes + i] == 0xa5 && map[2 * (gap + bytes) + i] == 0xa5);
	gpu_texture_read(texture, layer, rect_of(0, 0, width, height), seen);
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width * texel; x++) {
			bool in = y >= rect.y && y < rect.y + rect.height && x >= rect.x * texel && x < (rect.x + rect.width) * texel;
			assert_int_equal(seen[y * width * texel + x],
					 in ? data[(y - rect.y) * rect.width * texel + x - rect.x * texel] : 0);
		}
	gpu_staging_destroy(staging);
	gpu_texture_destroy(texture);
	mem_free(data);
	mem_free(seen);
}

static void bits_come_back_whatever_the_size(void **state)
{
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		carry(GPU_R32I, 4, 0, rect_of(0, 0, 257, 257), way);
		carry(GPU_R32I, 4, 3, rect_of(5, 1, 1, 33), way);
		carry(GPU_R8UI, 1, 0, rect_of(0, 0, 257, 257), way);
		carry(GPU_R8UI, 1, 0, rect_of(3, 7, 5, 3), way);
		carry(GPU_R8UI, 1, 2, rect_of(1, 0, 7, 1), way);
		carry(GPU_RGBA8, 4, 0, rect_of(2, 2, 19, 13), way);
	}
}

static void one_staging_carries_several_planes_at_once(void **state)
{
	enum { SIDE = 65, POSTS = SIDE * SIDE };
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		struct gpu_texture *offset = ints_texture(NULL, SIDE, SIDE), *dirt;
		assert_ok(gpu_texture_create(test_gpu, GPU_R8UI, SIDE, SIDE, 0, &dirt));
		struct gpu_staging *up = staging_of(POSTS * 5, way), *down = staging_of(POSTS * 5, way);
		uint8_t *data = noise(POSTS * 5);
		memcpy(gpu_staging_bytes(up), data, POSTS * 5);
		gpu_texture_upload_from(offset, 0, rect_of(0, 0, SIDE, SIDE), up, 0);
		gpu_texture_upload_from(dirt, 0, rect_of(0, 0, SIDE, SIDE), up, POSTS * 4);
		gpu_texture_read_into(dirt, 0, rect_of(0, 0, SIDE, SIDE), down, POSTS * 4);
		gpu_texture_read_into(offset, 0, rect_of(0, 0, SIDE, SIDE), down, 0);
		await(down);
		assert_memory_equal(gpu_staging_bytes(down), data, POSTS * 5);
		await(up);
		gpu_staging_destroy(up);
		gpu_staging_destroy(down);
		gpu_texture_destroy(offset);
		gpu_texture_destroy(dirt);
		mem_free(data);
	}
}

/* A pass that makes `to` the texture's every post. */
static void draw_over(struct gpu_texture *from, struct gpu_texture *to)
{
	static const struct gpu_program_request request = {.vertex = "full.vert", .fragment = "decimate.frag"};
	struct {
		int32_t from[2], to[2], steps, unused[3];
	} params = {.steps = 0};
	struct gpu_program *program;
	struct gpu_target *target;
	assert_ok(gpu_program_get(test_gpu, &request, &program));
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){to, 0}, 1, (struct gpu_attachment){NULL, 0}, &target));
	gpu_pass_run(test_gpu, &(struct gpu_pass){
		.stage = GPU_PYRAMID,
		.program = program,
		.target = target,
		.viewport = {0, 0, to->width, to->height},
		.textures = {from},
		.params = &params,
		.params_bytes = sizeof params,
	});
	gpu_target_destroy(target);
}

static void a_read_has_what_was_there_when_it_was_begun(void **state)
{
	enum { SIDE = 257, POSTS = SIDE * SIDE, BYTES = POSTS * 4 };
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		uint8_t *first = noise(BYTES), *second = noise(BYTES);
		struct gpu_rect whole = rect_of(0, 0, SIDE, SIDE);
		struct gpu_texture *tile = ints_texture(NULL, SIDE, SIDE), *other = ints_texture((int32_t *)first, SIDE, SIDE);
		struct gpu_staging *down[4], *up = staging_of(BYTES, way);
		for (int i = 0; i < 4; i++)
			down[i] = staging_of(BYTES, way);
		draw_over(other, tile); /* a queued pass writes it; then it is read, cleared, uploaded, drawn over */
		gpu_texture_read_into(tile, 0, whole, down[0], 0);
		gpu_texture_clear(tile, 0, whole, 7);
		gpu_texture_read_into(tile, 0, whole, down[1], 0);
		memcpy(gpu_staging_bytes(up), second, BYTES);
		gpu_texture_upload_from(tile, 0, whole, up, 0);
		gpu_texture_read_into(tile, 0, whole, down[2], 0);
		draw_over(other, tile);
		gpu_texture_read_into(tile, 0, whole, down[3], 0);
		for (int i = 3; i >= 0; i--)
			await(down[i]);
		assert_memory_equal(gpu_staging_bytes(down[0]), first, BYTES);
		for (size_t i = 0; i < POSTS; i++)
			assert_int_equal(((int32_t *)gpu_staging_bytes(down[1]))[i], 7);
		assert_memory_equal(gpu_staging_bytes(down[2]), second, BYTES);
		assert_memory_equal(gpu_staging_bytes(down[3]), first, BYTES);
		for (int i = 0; i < 4; i++)
			gpu_staging_destroy(down[i]);
		gpu_staging_destroy(up);
		gpu_texture_destroy(tile);
		gpu_texture_destroy(other);
		mem_free(first);
		mem_free(second);
	}
}

static void memory_that_is_idle_again_is_ones_own(void **state)
{
	enum { SIDE = 129, BYTES = SIDE * SIDE * 4 };
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		uint8_t *data = noise(BYTES), *seen = mem_alloc(BYTES, 1);
		struct gpu_rect whole = rect_of(0, 0, SIDE, SIDE);
		struct gpu_texture *tile = ints_texture(NULL, SIDE, SIDE);
		struct gpu_staging *staging = staging_of(BYTES, way);
		assert_non_null(seen);
		for (int round = 0; round < 5; round++) {
			data[round] ^= 0xff;
			memcpy(gpu_staging_bytes(staging), data, BYTES);
			gpu_texture_upload_from(tile, 0, whole, staging, 0);
			await(staging);
			memset(gpu_staging_bytes(staging), round, BYTES);
			gpu_texture_read(tile, 0, whole, seen);
			assert_memory_equal(seen, data, BYTES);
			gpu_texture_upload(tile, 0, rect_of(0, 0, SIDE, 1), seen + BYTES / 2); /* a pointer still is one */
			gpu_texture_read(tile, 0, rect_of(0, 0, SIDE, 1), seen);
			assert_memory_equal(seen, seen + BYTES / 2, SIDE * 4);
		}
		gpu_staging_destroy(staging);
		gpu_texture_destroy(tile);
		mem_free(data);
		mem_free(seen);
	}
}

static void a_busy_one_may_be_destroyed(void **state)
{
	enum { SIDE = 257, BYTES = SIDE * SIDE * 4 };
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		uint8_t *data = noise(BYTES), *seen = mem_alloc(BYTES, 1);
		struct gpu_rect whole = rect_of(0, 0, SIDE, SIDE);
		struct gpu_texture *tile = ints_texture(NULL, SIDE, SIDE);
		struct gpu_staging *up = staging_of(BYTES, way), *down = staging_of(BYTES, way);
		assert_non_null(seen);
		memcpy(gpu_staging_bytes(up), data, BYTES);
		gpu_texture_upload_from(tile, 0, whole, up, 0);
		gpu_texture_read_into(tile, 0, whole, down, 0);
		gpu_staging_destroy(down);
		gpu_staging_destroy(up);
		gpu_texture_read(tile, 0, whole, seen);
		assert_memory_equal(seen, data, BYTES);
		assert_ok(gpu_check(test_gpu, "staging"));
		gpu_texture_destroy(tile);
		mem_free(data);
		mem_free(seen);
	}
	gpu_staging_destroy(NULL);
}

static void transfers_and_memory_are_counted(void **state)
{
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		struct gpu_texture *tile = ints_texture(NULL, 5, 3);
		struct gpu_stats before, after;
		gpu_stats(test_gpu, &before);
		struct gpu_staging *staging = staging_of(1000, way);
		gpu_stats(test_gpu, &after);
		assert_int_equal(after.bytes - before.bytes, 1000);
		gpu_texture_upload_from(tile, 0, rect_of(0, 0, 5, 3), staging, 0);
		gpu_texture_upload_from(tile, 0, rect_of(1, 1, 2, 1), staging, 996 - 4);
		gpu_texture_read_into(tile, 0, rect_of(0, 0, 4, 3), staging, 100);
		gpu_stats(test_gpu, &after);
		assert_int_equal(after.uploads - before.uploads, 2);
		assert_int_equal(after.upload_bytes - before.upload_bytes, 68);
		assert_int_equal(after.read_backs - before.read_backs, 1);
		assert_int_equal(after.read_back_bytes - before.read_back_bytes, 48);
		gpu_staging_destroy(staging);
		gpu_stats(test_gpu, &after);
		assert_int_equal(after.bytes, before.bytes);
		gpu_texture_destroy(tile);
	}
}

static void a_software_driver_is_done_at_once(void **state)
{
	(void)state;
	need_gpu();
	struct gpu_staging *staging;
	struct gpu_texture *tile = ints_texture(NULL, 3, 3);
	assert_ok(gpu_staging_create(test_gpu, 36, &staging));
	gpu_texture_read_into(tile, 0, rect_of(0, 0, 3, 3), staging, 0);
	assert_int_equal(gpu_staging_idle(staging) && staging->direct, gpu_info(test_gpu)->software);
	gpu_staging_destroy(staging);
	gpu_texture_destroy(tile);
}

static void without_memory_there_is_none(void **state)
{
	struct gpu_staging *staging;
	(void)state;
	need_gpu();
	mem_fail_nth(1, 0);
	enum status status = gpu_staging_create(test_gpu, 64, &staging);
	mem_fail_nth(0, 0);
	assert_int_equal(status, STATUS_FAILED);
	assert_ok(gpu_check(test_gpu, "staging"));
}

/* What is left of a gpu that failed can be used for nothing, but destroyed; then a new one is made. */
static void failed(struct gpu_staging *staging, struct gpu_texture *tile, const char *what)
{
	struct gpu_staging *another;
	int32_t *map = gpu_staging_bytes(staging);
	GLsync fence = staging->fence;
	assert_true(gpu_staging_idle(staging));
	assert_int_equal(gpu_check(test_gpu, "later"), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), what));
	assert_int_equal(gpu_staging_create(test_gpu, 64, &another), STATUS_FAILED);
	map[0] = map[1] = 5;
	gpu_texture_upload_from(tile, 0, rect_of(0, 0, 1, 1), staging, 0);
	gpu_texture_read_into(tile, 0, rect_of(0, 0, 1, 1), staging, 4);
	assert_true(gpu_staging_idle(staging));
	assert_int_equal(map[0], 5);
	assert_int_equal(map[1], 0);
	assert_ptr_equal(staging->fence, fence); /* GL was not called */
	gpu_staging_destroy(staging);
	gpu_texture_destroy(tile);
	close_gpu(NULL);
	assert_ok(gpu_create(&(struct gpu_params){.draws = false}, &test_gpu));
}

static void a_wait_that_fails_is_told_and_stays(void **state)
{
	(void)state;
	need_gpu();
	struct gpu_texture *tile = ints_texture(NULL, 1, 1);
	struct gpu_staging *staging = staging_of(64, 0);
	gpu_texture_read_into(tile, 0, rect_of(0, 0, 1, 1), staging, 0);
	glDeleteSync(staging->fence); /* GL forgets it: waits for it fail */
	assert_true(gpu_staging_idle(staging));
	assert_null(staging->fence);
	failed(staging, tile, "transfer of a tile: GL says invalid value");
}

static void a_transfer_that_fails_is_told_by_the_next_check(void **state)
{
	(void)state;
	need_gpu();
	EACH_WAY(way)
	{
		struct gpu_texture *tile = ints_texture(NULL, 1, 1);
		struct gpu_staging *staging = staging_of(64, way);
		glDeleteTextures(1, &tile->name);
		gpu_texture_upload_from(tile, 0, rect_of(0, 0, 1, 1), staging, 0);
		assert_int_equal(gpu_check(test_gpu, "the test"), STATUS_FAILED);
		failed(staging, tile, "the test: GL says invalid");
	}
}

TEST_PROGRAM(staging)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(bits_come_back_whatever_the_size),
		cmocka_unit_test(one_staging_carries_several_planes_at_once),
		cmocka_unit_test(a_read_has_what_was_there_when_it_was_begun),
		cmocka_unit_test(memory_that_is_idle_again_is_ones_own),
		cmocka_unit_test(a_busy_one_may_be_destroyed),
		cmocka_unit_test(transfers_and_memory_are_counted),
		cmocka_unit_test(a_software_driver_is_done_at_once),
		cmocka_unit_test(without_memory_there_is_none),
		cmocka_unit_test(a_wait_that_fails_is_told_and_stays),
		cmocka_unit_test(a_transfer_that_fails_is_told_by_the_next_check),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
