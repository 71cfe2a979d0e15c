#include "html_picture.h"

#include <png.h>

#include "html_run.h"
#include "scene/scene_file.h"

#define BYTES (64u << 20)
#define PIXELS (64u << 20)

static enum status no_picture(const char *path, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: is no picture that can be shown: %s; give a folder that furrow drive left", path, why);
}

/* Each pixel is the mean of those that it covers: whole ones, so that it costs little. */
static void shrink(const uint8_t *from, uint32_t width, uint32_t height, uint32_t times, uint8_t *to)
{
	for (uint32_t y = 0; y < height / times; y++)
		for (uint32_t x = 0; x < width / times; x++)
			for (uint32_t c = 0; c < 3; c++) {
				uint64_t sum = 0;
				for (uint32_t v = 0; v < times; v++)
					for (uint32_t u = 0; u < times; u++)
						sum += from[3 * ((size_t)(y * times + v) * width + x * times + u) + c];
				to[3 * ((size_t)y * (width / times) + x) + c] = (uint8_t)((sum + (uint64_t)times * times / 2) / ((uint64_t)times * times));
			}
}

static enum status write_png(const uint8_t *pixels, const char *path, struct html_picture *out)
{
	png_image image = {.version = PNG_IMAGE_VERSION, .width = out->width, .height = out->height, .format = PNG_FORMAT_RGB};
	png_alloc_size_t size = 0;
	if (!png_image_write_to_memory(&image, NULL, &size, 0, pixels, 0, NULL))
		return no_picture(path, image.message);
	TRY(mem_make(&out->png, size, 1, "a picture"));
	if (!png_image_write_to_memory(&image, out->png, &size, 0, pixels, 0, NULL))
		return no_picture(path, image.message);
	out->length = size;
	return STATUS_OK;
}

static enum status decode(png_image *image, const char *path, uint32_t most, struct html_picture *out)
{
	if (image->width < 1 || image->height < 1 || (uint64_t)image->width * image->height > PIXELS)
		return no_picture(path, "it is too large");
	image->format = PNG_FORMAT_RGB;
	const uint32_t longest = image->width > image->height ? image->width : image->height, shortest = image->width + image->height - longest;
	uint32_t times = (longest + most - 1) / most;
	times = times > shortest ? shortest : times;
	out->width = image->width / times;
	out->height = image->height / times;
	uint8_t *pixels = mem_alloc((size_t)image->width * image->height, 3), *small = mem_alloc((size_t)out->width * out->height, 3);
	enum status status;
	TRY_OR(done, pixels != NULL && small != NULL ? STATUS_OK : fail_memory("a picture"));
	if (!png_image_finish_read(image, NULL, pixels, 0, NULL))
		TRY_OR(done, no_picture(path, image->message));
	shrink(pixels, image->width, image->height, times, small);
	TRY_OR(done, write_png(small, path, out));
done:
	mem_free_all(pixels, small);
	return status;
}

enum status html_picture_read(const char *path, uint32_t most, struct html_picture *out)
{
	char *bytes;
	size_t length;
	*out = (struct html_picture){.png = NULL};
	if (!html_is_file(path))
		return fail_with(STATUS_INPUT, "%s: is not there; give a folder that furrow drive left", path);
	TRY(scene_file_read(path, path, BYTES, &bytes, &length));
	png_image image = {.version = PNG_IMAGE_VERSION};
	const bool begun = png_image_begin_read_from_memory(&image, bytes, length);
	enum status status = begun ? decode(&image, path, most, out) : no_picture(path, image.message);
	png_image_free(&image);
	mem_free(bytes);
	if (status != STATUS_OK)
		html_picture_finish(out);
	return status;
}

void html_picture_finish(struct html_picture *picture)
{
	mem_free(picture->png);
	*picture = (struct html_picture){.png = NULL};
}
