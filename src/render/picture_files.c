/* Turns what was read back of a frame into files: colours, depths, and the numbers of render_measure. */
#include <math.h>
#include <stdio.h>

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

/* Fills the path of an image of a frame, without its ending. */
static void path_of(const char *directory, const struct render_picture *picture, enum scene_image image, char path[RENDER_PATH])
{
	if (picture->frame < 0)
		snprintf(path, RENDER_PATH, "%.4096s/%s", directory, picture->name);
	else
		snprintf(path, RENDER_PATH, "%.4096s/%s/%s/%06lld", directory, picture->name, scene_image_name(image), (long long)picture->frame);
}

static enum status write_png(const char *path, const struct render_picture *picture, unsigned bits, unsigned channels,
			     void (*put)(const void *user, uint32_t y, uint8_t *row), const void *user)
{
	char file[RENDER_PATH + 8];
	snprintf(file, sizeof file, "%s.png", path);
	return chart_png_rows(file, &(struct chart_png){picture->width, picture->height, bits, channels, put, user, .srgb = false});
}

static enum status write_npy(const char *path, const struct render_picture *picture, const void *values, unsigned channels, unsigned bytes)
{
	char file[RENDER_PATH + 8];
	snprintf(file, sizeof file, "%s.npy", path);
	return render_npy_write(file, &(struct render_array){values, picture->width, picture->height, channels, 'f', bytes});
}

static enum status write_depth(const char *path, const struct render_picture *picture, float *depth)
{
	render_depths(depth, (size_t)picture->width * picture->height);
	const struct greys greys = {depth, picture->width, picture->unit};
	TRY(write_png(path, picture, 16, 1, put_greys, &greys));
	return write_npy(path, picture, depth, 1, sizeof *depth);
}

/* --- linear light --- */

static void put_light(const void *user, uint32_t y, uint8_t *row)
{
	const struct greys *light = user;
	const float *from = light->values + (size_t)4 * light->width * y;
	for (uint32_t i = 0; i < 3 * light->width; i++) {
		const double value = (double)from[4 * (i / 3) + i % 3] * light->unit + 0.5;
		const unsigned number = value >= 65535 ? 65535 : value > 0 ? (unsigned)value : 0;
		row[2 * i] = (uint8_t)(number >> 8);
		row[2 * i + 1] = (uint8_t)number;
	}
}

static enum status write_linear(const char *path, const struct render_picture *picture, const float *light)
{
	const struct greys rows = {light, picture->width, picture->exposure * 65535 / RENDER_LINEAR_FULL};
	return write_png(path, picture, 16, 3, put_light, &rows);
}

/* --- numbers of render_measure --- */

#define CODE 3 /* the number of a pixel that says what is there: render_measure */

/* What pictures of classes have beside numbers of soils, which are below. */
enum { CLASS_GRAIN = 252, CLASS_OBJECT, CLASS_VEHICLE, CLASS_SKY };

static uint32_t body_of(float code)
{
	return code < 0 ? ((uint32_t)-code - 1) / 2 : 0;
}

static bool points_down(float code)
{
	return code < 0 && (uint32_t)-code % 2 == 0;
}

static void put_normals(const void *user, uint32_t y, uint8_t *row)
{
	const struct greys *normals = user;
	for (uint32_t x = 0; x < 3 * normals->width; x++) {
		const float value = normals->values[(size_t)3 * normals->width * y + x];
		row[x] = isnan(value) ? 0 : (uint8_t)lround(127.5 + 127.5 * value);
	}
}

static enum status write_normals(const char *path, const struct render_picture *picture, const float *numbers)
{
	const size_t count = (size_t)picture->width * picture->height;
	float *normals = mem_alloc(count, 3 * sizeof *normals);
	TRY_MEM(normals, "a picture of normals");
	for (size_t i = 0; i < count; i++) {
		const float *from = &numbers[4 * i];
		const float up = sqrtf(fmaxf(1 - from[0] * from[0] - from[1] * from[1], 0));
		const float normal[3] = {from[0], from[1], points_down(from[CODE]) ? -up : up};
		for (int k = 0; k < 3; k++)
			normals[3 * i + k] = from[CODE] == 0 ? NAN : normal[k];
	}
	const struct greys rows = {normals, picture->width, 1};
	enum status status;
	TRY_OR(done, write_png(path, picture, 8, 3, put_normals, &rows));
	TRY_OR(done, write_npy(path, picture, normals, 3, sizeof *normals));
done:
	mem_free(normals);
	return status;
}

void render_height_scale(double low, double high, double *unit, double *zero)
{
	*zero = floor(low) - 100; /* ruts are less deep */
	*unit = 0.001;
	while ((high + 100 - *zero) / *unit > 65535)
		*unit *= 10;
}

/* Heights as 16-bit numbers, 0 where there are none. */
struct heights {
	const double *values;
	const struct render_picture *picture;
};

static void put_heights(const void *user, uint32_t y, uint8_t *row)
{
	const struct heights *heights = user;
	const struct render_picture *picture = heights->picture;
	for (uint32_t x = 0; x < picture->width; x++) {
		const double value = (heights->values[(size_t)picture->width * y + x] - picture->low) / picture->unit + 0.5;
		const unsigned grey = value >= 0 && value < 65536 ? (unsigned)value : 0;
		row[2 * x] = (uint8_t)(grey >> 8);
		row[2 * x + 1] = (uint8_t)grey;
	}
}

static enum status write_heights(const char *path, const struct render_picture *picture, const float *numbers)
{
	const size_t count = (size_t)picture->width * picture->height;
	double *values = mem_alloc(count, sizeof *values);
	TRY_MEM(values, "a picture of heights");
	for (size_t i = 0; i < count; i++)
		values[i] = numbers[4 * i + CODE] == 0 ? (double)NAN : picture->eye + (double)numbers[4 * i + 2];
	const struct heights heights = {values, picture};
	enum status status;
	TRY_OR(done, write_png(path, picture, 16, 1, put_heights, &heights));
	TRY_OR(done, write_npy(path, picture, values, 1, sizeof *values));
done:
	mem_free(values);
	return status;
}

/* Pixels of render_measure. */
struct numbers {
	const float *values;
	const struct render_picture *picture;
};

static uint8_t class_of(const struct render_picture *picture, float code)
{
	const uint32_t body = body_of(code);
	if (code >= 0)
		return code > 0 ? (uint8_t)(code - 1) : CLASS_SKY;
	if (body == 0)
		return CLASS_GRAIN;
	return body >= picture->vehicles[0] && body < picture->vehicles[1] ? CLASS_VEHICLE : CLASS_OBJECT;
}

static void put_classes(const void *user, uint32_t y, uint8_t *row)
{
	const struct numbers *numbers = user;
	const float *from = numbers->values + (size_t)4 * numbers->picture->width * y;
	for (uint32_t x = 0; x < numbers->picture->width; x++)
		row[x] = class_of(numbers->picture, from[4 * x + CODE]);
}

static void put_instances(const void *user, uint32_t y, uint8_t *row)
{
	const struct numbers *numbers = user;
	const float *from = numbers->values + (size_t)4 * numbers->picture->width * y;
	for (uint32_t x = 0; x < numbers->picture->width; x++) {
		const uint32_t body = body_of(from[4 * x + CODE]), shown = body < 65535 ? body : 65535;
		row[2 * x] = (uint8_t)(shown >> 8);
		row[2 * x + 1] = (uint8_t)shown;
	}
}

static enum status write_numbers(const char *directory, const struct render_picture *picture, const float *numbers)
{
	char path[RENDER_PATH];
	if (picture->images >> SCENE_IMAGE_NORMALS & 1) {
		path_of(directory, picture, SCENE_IMAGE_NORMALS, path);
		TRY(write_normals(path, picture, numbers));
	}
	if (picture->images >> SCENE_IMAGE_HEIGHT & 1) {
		path_of(directory, picture, SCENE_IMAGE_HEIGHT, path);
		TRY(write_heights(path, picture, numbers));
	}
	const struct numbers rows = {numbers, picture};
	if (picture->images >> SCENE_IMAGE_CLASS & 1) {
		path_of(directory, picture, SCENE_IMAGE_CLASS, path);
		TRY(write_png(path, picture, 8, 1, put_classes, &rows));
	}
	if (!(picture->images >> SCENE_IMAGE_INSTANCE & 1))
		return STATUS_OK;
	path_of(directory, picture, SCENE_IMAGE_INSTANCE, path);
	return write_png(path, picture, 16, 1, put_instances, &rows);
}

enum status render_picture_write(const char *directory, const struct render_picture *picture, void *bytes)
{
	char path[RENDER_PATH], file[RENDER_PATH + 8];
	path_of(directory, picture, picture->image, path);
	switch (picture->image) {
	case SCENE_IMAGE_COLOUR:
		snprintf(file, sizeof file, "%s.png", path);
		return chart_png_write(file, bytes, picture->width, picture->height);
	case SCENE_IMAGE_LINEAR:
		return write_linear(path, picture, bytes);
	case SCENE_IMAGE_DEPTH:
		return write_depth(path, picture, bytes);
	case SCENE_IMAGE_NORMALS:
	case SCENE_IMAGE_HEIGHT:
	case SCENE_IMAGE_CLASS:
	case SCENE_IMAGE_INSTANCE:
	case SCENE_IMAGES:
		break;
	}
	return write_numbers(directory, picture, bytes);
}
