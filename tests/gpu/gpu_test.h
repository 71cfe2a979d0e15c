/* A gpu for the tests of a program; they skip where there is no GL. */
#ifndef FURROW_TESTS_GPU_TEST_H
#define FURROW_TESTS_GPU_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "gpu/internal.h"
#include "../support/skip.h"

static struct gpu *test_gpu; /* NULL: no GL */

static inline int open_gpu(void **state)
{
	(void)state;
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &test_gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		return 0;
	}
	return status == STATUS_OK ? 0 : -1;
}

static inline int close_gpu(void **state)
{
	(void)state;
	gpu_destroy(test_gpu);
	test_gpu = NULL;
	return 0;
}

#define need_gpu()                                                                                 \
	do {                                                                                       \
		if (test_gpu == NULL)                                                              \
			skip_since("no GL");                                                       \
	} while (0)

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static inline struct gpu_rect rect_of(uint32_t x, uint32_t y, uint32_t width, uint32_t height)
{
	return (struct gpu_rect){x, y, width, height};
}

/* Deterministic noise, and values that break arithmetic. */
static uint32_t test_seed = 1;
static inline uint32_t any_word(void)
{
	test_seed = test_seed * 1664525u + 1013904223u;
	uint32_t high = test_seed >> 16;
	test_seed = test_seed * 1664525u + 1013904223u;
	return high << 16 | test_seed >> 16;
}

static inline int32_t any_int(void)
{
	static const int32_t extremes[] = {INT32_MIN, INT32_MIN + 1, INT32_MAX, INT32_MAX - 1, 0, 1, -1, 65536, -65536};
	uint32_t word = any_word();
	if (word % 4 == 0)
		return extremes[word / 4 % (sizeof extremes / sizeof extremes[0])];
	return (int32_t)(word % 4 == 1 ? any_word() % 2001 - 1000 : any_word());
}

/* `path` with `text` in front of the program's own shaders, so that it can include them. */
#define TEST_SHADERS_MAX 128
static inline const struct shader_text *shaders_with(struct shader_text table[TEST_SHADERS_MAX], const char *path,
						     const char *text)
{
	size_t count = 0;
	table[count++] = (struct shader_text){path, text};
	for (const struct shader_text *file = gpu_shader_table; file->path != NULL; file++) {
		assert_true(count < TEST_SHADERS_MAX - 1);
		table[count++] = *file;
	}
	table[count] = (struct shader_text){NULL, NULL};
	return table;
}

/* A texture of integers, and one to draw into. */
static inline struct gpu_texture *ints_texture(const int32_t *values, uint32_t width, uint32_t height)
{
	struct gpu_texture *texture;
	assert_ok(gpu_texture_create(test_gpu, GPU_R32I, width, height, 0, &texture));
	if (values != NULL)
		gpu_texture_upload(texture, 0, rect_of(0, 0, width, height), values);
	return texture;
}

#endif
