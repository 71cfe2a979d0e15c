/* A GPU that draws, for the tests of one program. They are skipped where there is no GL. */
#ifndef FURROW_TESTS_GPU_RIG_H
#define FURROW_TESTS_GPU_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../gpu/staged.h"
#include "../support/skip.h"

static struct gpu *gpu; /* NULL: no GL */

#define need_gpu()                                                                                 \
	do {                                                                                       \
		if (gpu == NULL)                                                                   \
			skip_since("no GL");                                                       \
	} while (0)

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static inline int open_gpu(void **state)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = true}, &gpu);
	if (status == STATUS_NO_GL) {
		print_message("%s\n", failure_message());
		gpu = NULL;
		return 0;
	}
	return status == STATUS_OK ? 0 : -1;
}

static inline int close_gpu(void **state)
{
	gpu_destroy(gpu);
	return 0;
}

#endif
