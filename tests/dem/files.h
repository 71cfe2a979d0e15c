/* Files for the dem tests: a folder of their own, bytes into it, and opening what lies there. */
#ifndef FURROW_TESTS_DEM_FILES_H
#define FURROW_TESTS_DEM_FILES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "dem/dem.h"

static char folder[256];

static inline int folder_make(void **state)
{
	const char *base = getenv("TMPDIR");
	snprintf(folder, sizeof folder, "%.200s/furrow-dem-XXXXXX", base != NULL ? base : "/tmp");
	return mkdtemp(folder) != NULL ? 0 : -1;
}

static inline int folder_remove(void **state)
{
	char command[300];
	snprintf(command, sizeof command, "rm -rf '%s'", folder);
	return system(command);
}

/* The path of `name` in the folder; one of eight buffers in turn. */
static inline const char *in_folder(const char *name)
{
	static char paths[8][400];
	static int turn;
	char *path = paths[turn++ % 8];
	snprintf(path, sizeof paths[0], "%s/%s", folder, name);
	return path;
}

static inline void write_file(const char *name, const void *bytes, size_t size)
{
	FILE *file = fopen(in_folder(name), "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static inline struct dem_params params_of(const char *const *sources, size_t count)
{
	return (struct dem_params){.sources = sources, .source_count = count};
}

static inline struct dem *open_with(const struct dem_params *params)
{
	struct dem *dem = NULL;
	if (dem_open(params, &dem) != STATUS_OK)
		fail_msg("%s", failure_message());
	return dem;
}

static inline struct dem *open_one(const char *path)
{
	struct dem_params params = params_of(&path, 1);
	return open_with(&params);
}

/* Whole rows. */
static inline enum status read_rows(struct dem *dem, int64_t y0, int64_t rows, double *heights)
{
	return dem_read(dem, (struct post_rect){0, y0, dem_info(dem)->width, y0 + rows}, heights);
}

static inline double height_at(struct dem *dem, int64_t x, int64_t y)
{
	double row[4096];
	assert_true(dem_info(dem)->width <= 4096);
	assert_int_equal(read_rows(dem, y, 1, row), STATUS_OK);
	return row[x];
}

/* The last failure is one line. It says this, names the file (NULL: any), and tells what to do. */
static inline void assert_told(const char *says, const char *path)
{
	if (strstr(failure_message(), says) == NULL || (path != NULL && strstr(failure_message(), path) == NULL))
		fail_msg("\"%s\" does not say \"%s\"", failure_message(), says);
	assert_null(strchr(failure_message(), '\n'));
	assert_non_null(strchr(failure_message(), ';'));
}

static inline void assert_refused(const struct dem_params *params, enum status status, const char *names)
{
	struct dem *dem = NULL;
	assert_int_equal(dem_open(params, &dem), status);
	assert_null(dem);
	assert_told(names, NULL);
}

#endif
