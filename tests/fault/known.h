/* What was found of a store before: of the same bytes the same is found again, and many trials leave the same. */
#ifndef FURROW_TEST_FAULT_KNOWN_H
#define FURROW_TEST_FAULT_KNOWN_H

#include <errno.h>
#include <xxhash.h>

#include "sweep.h"

#define KNOWN_MOST 32768

static struct known {
	uint64_t key;
	int found; /* -1: nothing yet */
} known_all[KNOWN_MOST];
static size_t known_count, known_asked;

/* All bytes of a store and of the files that may lie beside it. */
static uint64_t known_bytes(const char *path)
{
	static const char *const suffixes[] = {"", "-wal", "-journal", ".part", ".part-wal", ".part-journal"};
	uint64_t hash = 0;
	for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; i++) {
		char name[512], bytes[4096];
		snprintf(name, sizeof name, "%s%s", path, suffixes[i]);
		FILE *file = fopen(name, "rb");
		if (file == NULL) {
			assert_int_equal(errno, ENOENT);
			continue;
		}
		hash = XXH3_64bits_withSeed(suffixes[i], strlen(suffixes[i]), hash);
		for (size_t size; (size = fread(bytes, 1, sizeof bytes, file)) > 0;)
			hash = XXH3_64bits_withSeed(bytes, size, hash + size);
		assert_int_equal(ferror(file), 0);
		fclose(file);
	}
	return hash;
}

/* What was found of such bytes when the same was asked of them; who asks first stores it there. */
static int *known_of(uint64_t bytes, uint64_t one, uint64_t other)
{
	const uint64_t parts[3] = {bytes, one, other};
	uint64_t key = XXH3_64bits(parts, sizeof parts);
	known_asked++;
	for (size_t i = 0; i < known_count; i++)
		if (known_all[i].key == key)
			return &known_all[i].found;
	assert_true(known_count < KNOWN_MOST);
	known_all[known_count] = (struct known){key, -1};
	return &known_all[known_count++].found;
}

#endif
