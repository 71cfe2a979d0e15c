/* Numbers, files and failures for the targets. */
#include "fuzz.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/base.h"

_Noreturn void fuzz_fail(const char *file, int line, const char *what)
{
	fprintf(stderr, "%s:%d: not so: %s\nlast failure: %s\n", file, line, what, failure_message());
	abort();
}

/* --- numbers --- */

uint64_t fuzz_random(uint64_t *state)
{
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
	z = (z ^ z >> 27) * 0x94d049bb133111ebu;
	return z ^ z >> 31;
}

uint64_t fuzz_below(uint64_t *state, uint64_t bound)
{
	return fuzz_random(state) % bound;
}

int64_t fuzz_integer(uint64_t *state)
{
	static const int64_t ends[] = {0, INT64_MIN, INT64_MAX, INT32_MIN, INT32_MAX, UINT32_MAX, 1, -1};
	uint64_t near = fuzz_below(state, 5), bit = fuzz_below(state, 64);
	switch (fuzz_below(state, 5)) {
	case 4:
		return ends[fuzz_below(state, sizeof ends / sizeof *ends)];
	case 0:
		return (int64_t)fuzz_below(state, 40) - 20;
	case 1: /* about a power of two */
		return (int64_t)(((uint64_t)1 << bit) + near - 2);
	case 2:
		return (int64_t)(0 - ((uint64_t)1 << bit) + near - 2);
	default:
		return (int64_t)(fuzz_random(state) >> bit);
	}
}

double fuzz_real(uint64_t *state)
{
	static const double edges[] = {0, 1, 0.5, 2, 1e-3, 1e3, 1e6, 1e8, 1e9, 2147483648.0, 3.4e38, 1e300,
				       1.7976931348623157e308, 5e-324, 2.2250738585072014e-308};
	double value = edges[fuzz_below(state, sizeof edges / sizeof *edges)];
	switch (fuzz_below(state, 8)) {
	case 0:
		return (double)fuzz_integer(state);
	case 1:
		return (double)INFINITY * (fuzz_below(state, 2) ? 1 : -1);
	case 2:
		return ldexp((double)fuzz_below(state, 1000) - 500, (int)fuzz_below(state, 40) - 30);
	case 3:
	case 4:
		return -value;
	default:
		return value;
	}
}

/* --- files --- */

static char folder[64];
static pid_t owner;

static void remove_folder(void)
{
	if (folder[0] == '\0' || owner != getpid())
		return;
	DIR *dir = opendir(folder);
	for (struct dirent *entry; dir != NULL && (entry = readdir(dir)) != NULL;)
		if (entry->d_name[0] != '.')
			unlinkat(dirfd(dir), entry->d_name, 0);
	if (dir != NULL)
		closedir(dir);
	rmdir(folder);
}

const char *fuzz_path(const char *name)
{
	static char paths[8][128];
	static unsigned next;
	char *path = paths[next++ % 8];
	if (folder[0] == '\0') {
		owner = getpid();
		snprintf(folder, sizeof folder, "%s/furrow-fuzz-XXXXXX",
			 access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
		if (mkdtemp(folder) == NULL) {
			perror(folder);
			exit(1);
		}
		atexit(remove_folder);
	}
	snprintf(path, sizeof paths[0], "%s/%s", folder, name);
	return path;
}

void fuzz_write(const char *path, const void *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	if (file == NULL || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) {
		perror(path);
		exit(1);
	}
}

size_t fuzz_read(const char *path, uint8_t *data, size_t room)
{
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return 0;
	size_t size = fread(data, 1, room, file);
	if (size == room && fgetc(file) != EOF)
		size++;
	fclose(file);
	return size;
}
