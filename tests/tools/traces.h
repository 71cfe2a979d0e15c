/* What tests of page traces share: a folder for each test, random numbers, files, and traces put together byte by byte. */
#ifndef FURROW_TESTS_TRACES_H
#define FURROW_TESTS_TRACES_H

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "../page/fake.h"
#include "sim/sim.h"

static char folder[64];

static inline int enter(void **state)
{
	(void)state;
	(void)signal(SIGXFSZ, SIG_IGN);
	strcpy(folder, "/tmp/furrow-trace-XXXXXX");
	return mkdtemp(folder) == NULL;
}

static inline int leave(void **state)
{
	char command[96];
	(void)state;
	snprintf(command, sizeof command, "rm -rf '%s'", folder);
	return system(command);
}

static inline const char *in_folder(const char *name)
{
	static char paths[8][128];
	static int next;
	char *path = paths[next++ % 8];
	snprintf(path, sizeof paths[0], "%s/%s", folder, name);
	return path;
}

static uint64_t chance = 88172645463325252u;

static inline uint64_t draw(uint64_t below)
{
	chance ^= chance << 13;
	chance ^= chance >> 7;
	chance ^= chance << 17;
	return chance % below;
}

/* --- bytes by hand --- */

struct bytes {
	uint8_t at[1 << 16];
	size_t size;
};

static inline void write_file(const char *path, const void *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	fclose(file);
}

static inline struct bytes read_file(const char *path)
{
	struct bytes bytes;
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	bytes.size = fread(bytes.at, 1, sizeof bytes.at, file);
	fclose(file);
	return bytes;
}

static inline struct bytes small_trace(void)
{
	struct page_trace *trace;
	assert_int_equal(page_trace_create(in_folder("small"), &trace), STATUS_OK);
	for (uint64_t i = 0; i < 60; i++)
		page_trace_access(trace, i / 7 * 40, draw(20) << 40, i % 5 == 0 ? PAGE_ACCESS_DRAW : PAGE_ACCESS_PIN,
				  i % 3 == 0);
	assert_int_equal(page_trace_publish(trace), STATUS_OK);
	page_trace_destroy(trace);
	return read_file(in_folder("small"));
}

#endif
