/* Writes a picture to a PNG file: as PATH.part, renamed when complete. */
#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include "base/aside.h"
#include "chart/internal.h"

/* zlib's level. For a picture of 1280 x 720, levels 1 to 4 take 28, 31, 51 and 69 ms of one core. The files have 1252, 1233, 1186 and 1212 kB.
 * Filters other than SUB are slower or larger. */
#define LEVEL 1
#define SMALL 9 /* with all filters, for a picture within a page */

struct encoder {
	png_structp png;
	png_infop info;
	const char *path;
	enum status status;
};

static void encode_failed(png_structp png, png_const_charp why)
{
	struct encoder *encoder = png_get_error_ptr(png);
	encoder->status = fail_with(STATUS_FAILED, "%s: cannot write the picture: %s; check space and permissions of its folder",
				    encoder->path, errno != 0 ? strerror(errno) : why);
	longjmp(png_jmpbuf(png), 1);
}

static void encode_warned(png_structp png, png_const_charp why)
{
	(void)png, (void)why;
}

/* Makes all calls from which libpng may jump back here. `row`: room for one row. */
static void encode(struct encoder *encoder, FILE *file, const struct chart_png *picture, uint8_t *row)
{
	if (setjmp(png_jmpbuf(encoder->png)) != 0)
		return;
	png_init_io(encoder->png, file);
	png_set_IHDR(encoder->png, encoder->info, picture->width, picture->height, (int)picture->bits,
		     picture->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : picture->channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
		     PNG_FILTER_TYPE_DEFAULT);
	if (picture->srgb)
		png_set_sRGB(encoder->png, encoder->info, PNG_sRGB_INTENT_PERCEPTUAL);
	if (picture->per_metre > 0)
		png_set_pHYs(encoder->png, encoder->info, picture->per_metre, picture->per_metre, PNG_RESOLUTION_METER);
	png_set_compression_level(encoder->png, picture->small ? SMALL : LEVEL);
	png_set_filter(encoder->png, 0, picture->small ? PNG_ALL_FILTERS : PNG_FILTER_SUB);
	png_write_info(encoder->png, encoder->info);
	for (uint32_t y = picture->height; y-- > 0;) {
		picture->put(picture->user, y, row);
		png_write_row(encoder->png, row);
	}
	png_write_end(encoder->png, NULL);
}

enum status chart_png_file(FILE *file, const char *path, const struct chart_png *picture)
{
	struct encoder encoder = {.path = path};
	uint8_t *row = mem_alloc(picture->width, picture->channels * picture->bits / 8);
	errno = 0;
	encoder.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoder, encode_failed, encode_warned);
	encoder.info = encoder.png != NULL ? png_create_info_struct(encoder.png) : NULL;
	if (row == NULL || encoder.info == NULL)
		encoder.status = fail_memory("a PNG");
	else
		encode(&encoder, file, picture, row);
	png_destroy_write_struct(&encoder.png, &encoder.info);
	mem_free(row);
	return encoder.status;
}

enum status chart_png_rows(const char *path, const struct chart_png *picture)
{
	struct aside aside;
	TRY(aside_begin(&aside, path));
	enum status status = chart_png_file(aside.file, path, picture);
	if (status == STATUS_OK && picture->ended != NULL)
		status = picture->ended(picture->user);
	return aside_end(&aside, false, status);
}

struct colours {
	const uint8_t *pixels;
	uint32_t width;
};

static void put_colours(const void *user, uint32_t y, uint8_t *row)
{
	const struct colours *colours = user;
	const uint8_t *from = colours->pixels + (size_t)4 * colours->width * y;
	for (uint32_t x = 0; x < colours->width; x++)
		memcpy(row + (size_t)3 * x, from + (size_t)4 * x, 3);
}

enum status chart_png_write_for_print(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height, uint32_t per_metre)
{
	const struct colours colours = {pixels, width};
	const struct chart_png picture = {width, height, 8, 3, put_colours, &colours, .srgb = true, .per_metre = per_metre};
	return chart_png_rows(path, &picture);
}

enum status chart_png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height)
{
	return chart_png_write_for_print(path, pixels, width, height, 0);
}
