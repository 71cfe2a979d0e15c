/*
 * Reads grey PNGs, through libpng. A PNG begins with its northern row and cannot be read from the south. So its rows go into a
 * temporary file first, two bytes a post. An interlaced PNG is complete only at its end. It is held in memory until then, up to
 * a limit.
 */
#include "dem_internal.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>

#include "dem_scratch.h"

#define INTERLACED_POSTS_MAX ((int64_t)1 << 26) /* 128 MB */
#define SIDE_MAX (1 << 24)

struct png {
	struct dem_grid grid;
	struct dem_meaning meaning;
	bool has_clear, alpha;
	uint16_t clear; /* the value that is transparent: nodata */
	double *nodata;
	uint16_t *posts; /* a row; while it is decoded, all of an interlaced image */
	struct dem_scratch scratch; /* the northernmost row first */
};

struct png_problem {
	jmp_buf escape;
	char text[160];
	enum status status; /* of the temporary file */
};

static void png_destroy(struct dem_grid *grid)
{
	struct png *png = (struct png *)grid;
	dem_scratch_close(&png->scratch);
	mem_free_all(png->nodata, png->posts, png);
}

static enum status png_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct png *png = (struct png *)grid;
	int64_t width = rect.x1 - rect.x0;
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += width) {
		int64_t from = (grid->height - 1 - y) * grid->width + rect.x0;
		TRY(dem_scratch_move(&png->scratch, false, png->posts, 2 * (size_t)width, 2 * from));
		for (int64_t x = 0; x < width; x++)
			heights[x] = png->posts[x];
		dem_metres(&png->meaning, heights, width, heights);
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

/* Converts a row of bytes to uint16 in place, starting at its end. */
static void widen_row(uint16_t *row, int64_t width)
{
	for (int64_t x = width; x-- > 0;)
		row[x] = ((const uint8_t *)row)[x];
}

static void keep_row(png_structp reader, struct png *png, int bits, int64_t y, uint16_t *row)
{
	struct png_problem *problem = png_get_error_ptr(reader);
	if (bits < 16)
		widen_row(row, png->grid.width);
	problem->status = dem_scratch_move(&png->scratch, true, row, 2 * (size_t)png->grid.width, 2 * y * png->grid.width);
	if (problem->status != STATUS_OK)
		png_error(reader, "its rows cannot be kept");
}

/* Decodes all rows into the temporary file. Returns false on failure; then `problem` is set. */
static bool decode(png_structp reader, png_infop header, FILE *file, struct png *png, int *full,
		   struct png_problem *problem)
{
	if (setjmp(problem->escape) != 0)
		return false;
	png_init_io(reader, file);
	png_set_user_limits(reader, SIDE_MAX, SIDE_MAX);
	png_read_info(reader, header);
	int64_t width = png_get_image_width(reader, header), height = png_get_image_height(reader, header);
	int bits = png_get_bit_depth(reader, header), colour = png_get_color_type(reader, header);
	if (colour == PNG_COLOR_TYPE_PALETTE)
		png_error(reader, "it has a palette of colours, and a heightmap is grey");
	if (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_GRAY_ALPHA)
		png_error(reader, "it is in colour, and a heightmap is grey");
	if (bits < 8)
		png_set_expand_gray_1_2_4_to_8(reader);
	if (colour == PNG_COLOR_TYPE_GRAY_ALPHA)
		png_set_strip_alpha(reader);
	png->alpha = colour == PNG_COLOR_TYPE_GRAY_ALPHA;
	png_color_16p clear = NULL;
	png->has_clear = bits >= 8 && png_get_tRNS(reader, header, NULL, NULL, &clear) != 0 && clear != NULL;
	if (png->has_clear)
		png->clear = clear->gray;
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
	if (bits == 16)
		png_set_swap(reader);
#endif
	int passes = png_set_interlace_handling(reader);
	if (passes > 1 && width * height > INTERLACED_POSTS_MAX)
		png_error(reader, "it is interlaced, and more than 67 million posts of that are too many");
	png_read_update_info(reader, header);
	*full = bits == 16 ? 65535 : 255;
	png->grid.width = width;
	png->grid.height = height;
	png->posts = mem_calloc((size_t)(passes > 1 ? width * height : width), sizeof *png->posts);
	if (png->posts == NULL)
		png_error(reader, "out of memory");
	for (int pass = 0; pass < passes; pass++)
		for (int64_t y = 0; y < height; y++) {
			uint16_t *row = png->posts + (passes > 1 ? y * width : 0);
			png_read_row(reader, (png_bytep)row, NULL);
			if (pass + 1 == passes)
				keep_row(reader, png, bits, y, row);
		}
	png_read_end(reader, NULL);
	return true;
}

static enum status load(const char *path, struct png *png, int *full)
{
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be opened: %s; check its permissions", path,
				 input_problem());
	struct png_problem problem = {.text = "out of memory"};
	enum status status = dem_scratch_open(&png->scratch, path);
	if (status != STATUS_OK) {
		fclose(file);
		return status;
	}
	png_infop header = NULL;
	png_structp reader = png_create_read_struct(PNG_LIBPNG_VER_STRING, &problem, on_error, on_warning);
	if (reader != NULL)
		header = png_create_info_struct(reader);
	bool done = header != NULL && decode(reader, header, file, png, full, &problem);
	png_destroy_read_struct(&reader, &header, NULL);
	fclose(file);
	if (!done && problem.status != STATUS_OK)
		return problem.status;
	if (!done)
		return fail_with(STATUS_INPUT, "%s: cannot be read as a PNG: %s; give a whole grey PNG or "
				 "a GeoTIFF", path, problem.text);
	mem_free(png->posts);
	return mem_make(&png->posts, (size_t)png->grid.width, sizeof *png->posts, path);
}

enum status dem_png_open(const struct dem_params *params, const char *path, struct dem_grid **out)
{
	struct png *png = mem_calloc(1, sizeof *png);
	TRY_MEM(png, path);
	png->grid.destroy = png_destroy;
	png->scratch.file = -1;
	int full = 0;
	enum status status;
	TRY_OR(failed, load(path, png, &full));
	png->nodata = mem_alloc(params->nodata_count + 1, sizeof *png->nodata);
	if (png->nodata == NULL)
		TRY_OR(failed, fail_memory(path));
	for (size_t i = 0; i < params->nodata_count; i++)
		png->nodata[i] = params->nodata[i];
	png->nodata[params->nodata_count] = png->clear;
	if (png->alpha)
		note("%s: its transparency is not read; name the value of its holes with --nodata", path);
	double span = params->has_height_range ? params->height_max - params->height_min : full;
	if (full == 255 && !params->has_height_range)
		note("%s: its heights have 8 bits, and are taken as 0 to 255 m; --height-range says what 0 and 255 mean", path);
	png->meaning = (struct dem_meaning){
		.scale = span / full,
		.offset = params->has_height_range ? params->height_min : 0,
		.nodata = png->nodata,
		.nodata_count = params->nodata_count + (png->has_clear ? 1 : 0),
		.single = true,
	};
	png->grid.read = png_read;
	png->grid.spacing = params->spacing > 0 ? params->spacing : 1;
	png->grid.unit = png->meaning.scale;
	png->grid.whole = dem_unit_exact(png->grid.unit) && fmod(png->meaning.offset, png->grid.unit) == 0;
	*out = &png->grid;
	return STATUS_OK;
failed:
	dem_grid_destroy(&png->grid);
	return status;
}
