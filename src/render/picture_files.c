/* Turns what was read back of a frame into files: colours, and depths. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "render/internal.h"

/* Rows of 16-bit numbers, the most significant byte first. */
struct greys {
	const float *values;
	uint32_t width;
	double unit;
};

static void put_greys(const void *user, uint32_t y, uint8_t *row)
{
	const struct greys *greys = user;
	const float *from = greys->values + (size_t)greys->width * y;
	for (uint32_t x = 0; x < greys->width; x++) {
		const double value = from[x] / greys->unit + 0.5;
		const unsigned grey = value >= 0 && value < 65536 ? (unsigned)value : 0;
		row[2 * x] = (uint8_t)(grey >> 8);
		row[2 * x + 1] = (uint8_t)grey;
	}
}

static enum status write_depth(const char *path, const struct render_picture *picture, float *depth)
{
	char file[RENDER_PATH];
	const size_t count = (size_t)picture->width * picture->height;
	render_depths(depth, count);
	const struct greys greys = {depth, picture->width, picture->unit};
	snprintf(file, sizeof file, "%s.png", path);
	enum status status = render_png_rows(file, &(struct render_png){picture->width, picture->height, 16, 1, put_greys, &greys, .srgb = false});
	if (status != STATUS_OK)
		return status;
	snprintf(file, sizeof file, "%s.npy", path);
	return render_npy_write(file, &(struct render_array){depth, picture->width, picture->height, 1, 'f', sizeof *depth});
}

enum status render_picture_write(const char *directory, const struct render_picture *picture, void *bytes)
{
	char path[RENDER_PATH - 8], file[RENDER_PATH];
	snprintf(path, sizeof path, "%s/%s", directory, picture->name);
	switch (picture->image) {
	case SCENE_IMAGE_DEPTH:
		return write_depth(path, picture, bytes);
	case SCENE_IMAGE_COLOUR:
	case SCENE_IMAGES:
		break;
	}
	snprintf(file, sizeof file, "%s.png", path);
	return render_png_write(file, bytes, picture->width, picture->height);
}
