/* Rasters that lie over a world: PNGs of chosen values, opening them, and what is refused. */
#ifndef FURROW_TESTS_DEM_PLACED_H
#define FURROW_TESTS_DEM_PLACED_H

#include "files.h"

static inline struct dem_placed_params placed(const char *name, const struct extent *extent, const char *srs, double x, double y)
{
	return (struct dem_placed_params){.path = in_folder(name), .extent = extent, .srs = srs, .origin = {x, y}};
}

static inline struct dem_pixels *open_placed(const struct dem_placed_params *params, enum dem_placed_kind kind)
{
	struct dem_pixels *pixels;
	if (dem_pixels_open(params, kind, &pixels) != STATUS_OK)
		fail_msg("%s", failure_message());
	return pixels;
}

/* value_of: of a pixel, rows counted from the north. */
static inline void write_placed_png(const char *name, enum dem_raster_type type, int width, int height,
				    double (*value_of)(int column, int row))
{
	struct dem_raster raster = {.path = in_folder(name), .width = width, .height = height, .type = type, .spacing = 1};
	struct dem_writer *writer;
	double row[1200];
	assert_true(width <= 1200);
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
	for (int y = height - 1; y >= 0; y--) {
		for (int x = 0; x < width; x++)
			row[x] = value_of(x, y);
		assert_int_equal(dem_writer_rows(writer, 1, row), STATUS_OK);
	}
	assert_int_equal(dem_writer_publish(writer), STATUS_OK);
	dem_writer_destroy(writer);
}

static inline void assert_placed_refused(const struct dem_placed_params *params, enum dem_placed_kind kind, const char *says)
{
	struct dem_pixels *pixels;
	assert_int_equal(dem_pixels_open(params, kind, &pixels), STATUS_INPUT);
	assert_null(pixels);
	assert_told(says, params->path);
}

/* Every allocation of an open fails in turn. */
static inline void assert_placed_tells_memory(const struct dem_placed_params *params, enum dem_placed_kind kind)
{
	struct dem_pixels *pixels;
	enum status status;
	uint64_t nth = 0;
	do {
		mem_fail_nth(++nth, 0);
		status = dem_pixels_open(params, kind, &pixels);
		mem_fail_nth(0, 0);
		assert_true(status == STATUS_OK || pixels == NULL);
		assert_true(status == STATUS_OK || strstr(failure_message(), "memory") != NULL);
	} while (status != STATUS_OK && nth < 100);
	assert_true(status == STATUS_OK && nth > 6);
	dem_pixels_close(pixels);
}

#endif
