/* Maps of classes: reading them. */
#ifndef FURROW_TESTS_DEM_CLASSES_H
#define FURROW_TESTS_DEM_CLASSES_H

#include "placed.h"

#define ABSENT 222

/* Values as they are; whoever asks frees them. */
static inline uint8_t *read_classes(struct dem_pixels *classes, int level, struct post_rect rect)
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

static inline void assert_read_refused(const struct dem_placed_params *params, struct post_rect rect, const char *says)
{
	struct dem_pixels *classes = open_placed(params, DEM_PLACED_CLASSES);
	static const uint8_t table[256];
	uint8_t *values = malloc((size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0)));
	assert_int_equal(dem_classes_read(classes, 0, rect, table, 0, values), STATUS_INPUT);
	assert_told(says, params->path);
	free(values);
	dem_pixels_close(classes);
}

#endif
