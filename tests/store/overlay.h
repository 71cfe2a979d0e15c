/* A base and an overlay of it, for the tests of overlays. */
#ifndef FURROW_TEST_STORE_OVERLAY_H
#define FURROW_TEST_STORE_OVERLAY_H

#include "fixture.h"

static UNUSED const struct store_options reading = {.mode = STORE_READ}, writing = {.mode = STORE_WRITE};

static UNUSED void make_both(const char *base, const char *overlay)
{
	make_store(base);
	unlink(overlay);
	assert_ok(store_create_overlay(overlay, base));
}

static UNUSED char *bytes_of(const char *path, size_t *size)
{
	struct stat file;
	FILE *in = fopen(path, "rb");
	assert_true(in != NULL && fstat(fileno(in), &file) == 0);
	char *bytes = malloc((size_t)file.st_size);
	assert_non_null(bytes);
	*size = fread(bytes, 1, (size_t)file.st_size, in);
	assert_int_equal(*size, file.st_size);
	fclose(in);
	return bytes;
}

static UNUSED void dig(struct store *store, uint32_t seed, int epochs)
{
	struct field field = field_make(-1);
	struct store_commit_result result;
	assert_ok(store_set_working_level(store, -1));
	for (int i = 0; i < epochs; i++) {
		int64_t x = 30 + 25 * i, y = 60 - 10 * i;
		field_dig(&field, x, y, 12, seed + (uint32_t)i);
		assert_ok(field_commit(&field, around(x, y, 12), store, i + 1, &result));
		assert_int_equal(result.commit, i + 1);
	}
	field_free(&field);
}

static UNUSED void assert_refused(const char *path, const char *why)
{
	for (int mode = 0; mode < 2; mode++) {
		struct store *store;
		assert_status(store_open(path, mode ? &writing : &reading, &store), STATUS_INPUT);
		if (strstr(failure_message(), why) == NULL || strstr(failure_message(), path) == NULL)
			fail_msg("does not say '%s': %s", why, failure_message());
		assert_non_null(strstr(failure_message(), "; "));
	}
}

#endif
