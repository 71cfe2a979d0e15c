/* Random planes for the tests of slots. The caller frees them with mem_free. */
#ifndef FURROW_TESTS_GPU_SLOTS_H
#define FURROW_TESTS_GPU_SLOTS_H

#include "gpu_test.h"
#include "staged.h"

static inline int32_t *random_ints(size_t count)
{
	int32_t *values = mem_alloc(count, sizeof *values);
	assert_non_null(values);
	for (size_t i = 0; i < count; i++)
		values[i] = any_int();
	return values;
}

static inline uint8_t *random_bytes(size_t count)
{
	uint8_t *values = mem_alloc(count, 1);
	assert_non_null(values);
	for (size_t i = 0; i < count; i++)
		values[i] = (uint8_t)any_word();
	return values;
}

#endif
