/* Maps of classes: opening them over a world, reading them whole and in parts. */
#ifndef FURROW_TESTS_DEM_CLASSES_H
#define FURROW_TESTS_DEM_CLASSES_H

#include "files.h"

#define ABSENT 222

static inline struct dem_classes_params classes_of(const char *name, const struct extent *extent, const char *srs, double x,
						   double y)
{
	return (struct dem_classes_params){.path = in_folder(name), .extent = extent, .srs = srs, .origin = {x, y}};
}

static inline struct dem_classes *open_classes(const struct dem_classes_params *params)
{
	struct dem_classes *classes;
	if (dem_classes_open(params, &classes) != STATUS_OK)
		fail_msg("%s", failure_message());
	return classes;
}

/* Values as they are; whoever asks frees them. */
static inline uint8_t *read_classes(struct dem_classes *classes, int level, struct post_rect rect)
{
	uint8_t table[256];
	for (int i = 0; i < 256; i++)
		table[i] = (uint8_t)i;
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	uint8_t *values = malloc(count + 1);
	assert_non_null(values);
	values[count] = 77;
	if (dem_classes_read(classes, level, rect, table, ABSENT, values) != STATUS_OK)
		fail_msg("%s", failure_message());
	assert_int_equal(values[count], 77);
	return values;
}

static inline void assert_open_refused(const struct dem_classes_params *params, const char *says)
{
	struct dem_classes *classes;
	assert_int_equal(dem_classes_open(params, &classes), STATUS_INPUT);
	assert_null(classes);
	if (strstr(failure_message(), says) == NULL || strstr(failure_message(), params->path) == NULL)
		fail_msg("\"%s\" does not say \"%s\"", failure_message(), says);
	assert_null(strchr(failure_message(), '\n'));
	assert_non_null(strchr(failure_message(), ';'));
}

static inline void assert_read_refused(const struct dem_classes_params *params, struct post_rect rect, const char *says)
{
	struct dem_classes *classes = open_classes(params);
	static const uint8_t table[256];
	uint8_t *values = malloc((size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0)));
	assert_int_equal(dem_classes_read(classes, 0, rect, table, 0, values), STATUS_INPUT);
	if (strstr(failure_message(), says) == NULL || strstr(failure_message(), params->path) == NULL)
		fail_msg("\"%s\" does not say \"%s\"", failure_message(), says);
	assert_non_null(strchr(failure_message(), ';'));
	free(values);
	dem_classes_close(classes);
}

#endif
