/*
 * Grey PNGs in, through libpng. A PNG is stored from the north and cannot be read from the south,
 * so all of it is held, two bytes a post, up to a limit; larger ones are to be GeoTIFFs.
 */
#include "dem_internal.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>

#define PNG_POSTS_MAX ((int64_t)1 << 28) /* half a gigabyte */

struct png {
	struct dem_grid grid;
	struct dem_meaning meaning;
	double *nodata;
	uint16_t *posts; /* the northernmost row first */
};

struct png_problem {
	jmp_buf escape;
	char text[160];
};

static void png_destroy(struct dem_grid *grid)
{
	struct png *png = (struct png *)grid;
	mem_free(png->nodata);
	mem_free(png->posts);
	mem_free(png);
}

static enum status png_read(struct dem_grid *grid, int64_t y0, int64_t rows, double *heights)
{
	struct png *png = (struct png *)grid;
	for (int64_t row = 0; row < rows; row++) {
		const uint16_t *from = png->posts + (grid->height - 1 - (y0 + row)) * grid->width;
		for (int64_t x = 0; x < grid->width; x++)
			heights[row * grid->width + x] = dem_metres(&png->meaning, from[x]);
	}
	return STATUS_OK;
}

static void on_error(png_structp reader, png_const_charp text)
{
	struct png_problem *problem = png_get_error_ptr(reader);
	snprintf(problem->text, sizeof problem->text, "%s", text);
	longjmp(problem->escape, 1);
}

static void on_warning(png_structp reader, png_const_charp text)
{
	(void)reader;
	(void)text;
}

/* Rows as uint16; 8-bit ones are widened after reading, from the back. False: see problem->text. */
static bool decode(png_structp reader, png_infop header, FILE *file, struct png *png, int *full,
		   struct png_problem *problem)
{
	if (setjmp(problem->escape) != 0)
		return false;
	png_init_io(reader, file);
	png_set_user_limits(reader, 1 << 24, 1 << 24);
	png_read_info(reader, header);
	png_uint_32 width = png_get_image_width(reader, header), height = png_get_image_height(reader, header);
	int bits = png_get_bit_depth(reader, header), colour = png_get_color_type(reader, header);
	if (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_GRAY_ALPHA)
		png_error(reader, "it is in colour, and a heightmap is grey");
	if ((int64_t)width * height > PNG_POSTS_MAX)
		png_error(reader, "more than 268 million posts are too many for a PNG");
	if (bits < 8)
		png_set_expand_gray_1_2_4_to_8(reader);
	if (colour == PNG_COLOR_TYPE_GRAY_ALPHA)
		png_set_strip_alpha(reader);
	if (bits == 16)
		png_set_swap(reader);
	int passes = png_set_interlace_handling(reader);
	png_read_update_info(reader, header);
	*full = bits == 16 ? 65535 : 255;
	png->grid.width = width;
	png->grid.height = height;
	png->posts = mem_calloc((size_t)width * height, sizeof *png->posts);
	if (png->posts == NULL)
		png_error(reader, "out of memory");
	for (int pass = 0; pass < passes; pass++)
		for (png_uint_32 y = 0; y < height; y++)
			png_read_row(reader, (png_bytep)(png->posts + (size_t)y * width), NULL);
	png_read_end(reader, NULL);
	for (png_uint_32 y = 0; bits < 16 && y < height; y++) {
		uint16_t *row = png->posts + (size_t)y * width;
		for (png_uint_32 x = width; x-- > 0;)
			row[x] = ((const uint8_t *)row)[x];
	}
	return true;
}

static enum status load(const char *path, struct png *png, int *full)
{
	FILE *file = fopen(path, "rb");
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be opened: %s; check its permissions", path,
				 strerror(errno));
	struct png_problem problem = {.text = "out of memory"};
	png_infop header = NULL;
	png_structp reader = png_create_read_struct(PNG_LIBPNG_VER_STRING, &problem, on_error, on_warning);
	if (reader != NULL)
		header = png_create_info_struct(reader);
	bool done = header != NULL && decode(reader, header, file, png, full, &problem);
	png_destroy_read_struct(&reader, &header, NULL);
	fclose(file);
	if (!done)
		return fail_with(STATUS_INPUT, "%s: cannot be read as a PNG: %s; give a whole grey PNG or "
				 "a GeoTIFF", path, problem.text);
	return STATUS_OK;
}

enum status dem_png_open(const struct dem_params *params, const char *path, struct dem_grid **out)
{
	struct png *png = mem_calloc(1, sizeof *png);
	if (png == NULL)
		return fail_memory(path);
	png->grid.destroy = png_destroy;
	int full = 0;
	enum status status = load(path, png, &full);
	if (status != STATUS_OK)
		goto error;
	png->nodata = mem_alloc(params->nodata_count, sizeof *png->nodata);
	if (png->nodata == NULL) {
		status = fail_memory(path);
		goto error;
	}
	for (size_t i = 0; i < params->nodata_count; i++)
		png->nodata[i] = params->nodata[i];
	double span = params->has_height_range ? params->height_max - params->height_min : full;
	png->meaning = (struct dem_meaning){
		.scale = span / full,
		.offset = params->has_height_range ? params->height_min : 0,
		.nodata = png->nodata,
		.nodata_count = params->nodata_count,
		.single = true,
	};
	png->grid.read = png_read;
	png->grid.spacing = params->spacing > 0 ? params->spacing : 1;
	png->grid.unit = png->meaning.scale;
	*out = &png->grid;
	return STATUS_OK;
error:
	dem_grid_destroy(&png->grid);
	return status;
}
