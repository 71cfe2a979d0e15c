/*
 * Writes grey PNGs. Pixels without a value are 0, which is declared transparent if no other pixel has it. A PNG begins with its northern row, but rows come from the south. So the whole picture is held in memory until
 * it is finished. A picture above the limit must be written as GeoTIFF.
 */
#include "dem_internal.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>

#define PNG_BYTES_MAX ((int64_t)1 << 30)

struct png_sink {
	struct dem_sink sink;
	const struct dem_raster *raster;
	FILE *file;
	size_t row_bytes;
	bool holes, zeros; /* pixels without a value, and others that are 0 */
	uint8_t *rows; /* the southernmost first, big-endian as PNG has them */
};

struct png_problem {
	jmp_buf escape;
	char text[160];
};

static enum status sink_row(struct dem_sink *sink, int64_t y, const double *values)
{
	struct png_sink *png = (struct png_sink *)sink;
	uint8_t *to = png->rows + (size_t)y * png->row_bytes;
	for (int64_t x = 0; x < png->raster->width; x++) {
		unsigned value = (unsigned)dem_raster_value(png->raster, values[x]);
		png->holes = png->holes || isnan(values[x]);
		png->zeros = png->zeros || (value == 0 && !isnan(values[x]));
		if (png->raster->type == DEM_UINT16)
			*to++ = (uint8_t)(value >> 8);
		*to++ = (uint8_t)value;
	}
	return STATUS_OK;
}

static void on_error(png_structp writer, png_const_charp text)
{
	struct png_problem *problem = png_get_error_ptr(writer);
	snprintf(problem->text, sizeof problem->text, "%s", text);
	longjmp(problem->escape, 1);
}

static void on_warning(png_structp writer, png_const_charp text)
{
	(void)writer;
	(void)text;
}

static bool encode(png_structp writer, png_infop header, const struct png_sink *png,
		   struct png_problem *problem)
{
	if (setjmp(problem->escape) != 0)
		return false;
	png_init_io(writer, png->file);
	png_set_user_limits(writer, 0x7fffffff, 0x7fffffff);
	png_set_IHDR(writer, header, (png_uint_32)png->raster->width, (png_uint_32)png->raster->height,
		     png->raster->type == DEM_UINT16 ? 16 : 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
		     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
	if (png->holes && !png->zeros) /* GDAL reads that as nodata; engines leave it out */
		png_set_tRNS(writer, header, NULL, 0, &(png_color_16){.gray = 0});
	png_write_info(writer, header);
	for (int64_t y = png->raster->height; y-- > 0;)
		png_write_row(writer, png->rows + (size_t)y * png->row_bytes);
	png_write_end(writer, NULL);
	return true;
}

static enum status sink_finish(struct dem_sink *sink)
{
	struct png_sink *png = (struct png_sink *)sink;
	struct png_problem problem = {.text = "out of memory"};
	png_infop header = NULL;
	png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, &problem, on_error, on_warning);
	if (writer != NULL)
		header = png_create_info_struct(writer);
	bool done = header != NULL && encode(writer, header, png, &problem);
	png_destroy_write_struct(&writer, &header);
	if (done && fclose(png->file) != 0) {
		snprintf(problem.text, sizeof problem.text, "%s", strerror(errno));
		done = false;
		png->file = NULL;
	}
	if (!done)
		return fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space",
				 png->raster->path, problem.text);
	png->file = NULL;
	return STATUS_OK;
}

static void sink_destroy(struct dem_sink *sink)
{
	struct png_sink *png = (struct png_sink *)sink;
	if (png->file != NULL)
		fclose(png->file);
	mem_free_all(png->rows, png);
}

enum status dem_png_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
{
	int64_t row_bytes = raster->width * (raster->type == DEM_UINT16 ? 2 : 1);
	if (raster->height > PNG_BYTES_MAX / row_bytes)
		return fail_with(STATUS_INPUT, "%s: %lld x %lld posts are too many for a PNG; name a .tif",
				 raster->path, (long long)raster->width, (long long)raster->height);
	struct png_sink *png = mem_calloc(1, sizeof *png);
	TRY_MEM(png, raster->path);
	png->sink = (struct dem_sink){sink_row, sink_finish, sink_destroy};
	png->raster = raster;
	png->row_bytes = (size_t)row_bytes;
	png->rows = mem_alloc((size_t)raster->height, png->row_bytes);
	enum status status;
	TRY_OR(failed, png->rows != NULL ? STATUS_OK : fail_memory(raster->path));
	if ((png->file = dem_part_open(part)) == NULL)
		TRY_OR(failed, fail_with(STATUS_FAILED, "%s: cannot be created: %s; check the folder and its permissions",
					 raster->path, input_problem()));
	*out = &png->sink;
	return STATUS_OK;
failed:
	sink_destroy(&png->sink);
	return status;
}
