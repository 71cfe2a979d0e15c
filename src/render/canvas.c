/*
 * Draws boxes, discs and lines on pixels, on the CPU. Each is blended over what is there.
 *
 * A place is in pixels from the canvas's lower left corner: pixel (x, y) covers [x, x + 1) x [y, y + 1). A shape may be partly or
 * wholly outside the canvas. Edges are smooth: the distance of a pixel's centre from the edge says how much the shape covers of it.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

enum status render_canvas_create(uint32_t width, uint32_t height, struct render_colour fill, struct render_canvas *out)
{
	*out = (struct render_canvas){mem_alloc((size_t)width * height, 4), width, height};
	if (out->pixels == NULL)
		return fail_memory("a picture");
	for (size_t i = 0; i < (size_t)width * height; i++)
		memcpy(out->pixels + 4 * i, &fill, 4);
	return STATUS_OK;
}

void render_canvas_finish(struct render_canvas *canvas)
{
	mem_free(canvas->pixels);
	*canvas = (struct render_canvas){NULL, 0, 0};
}

enum status render_canvas_write(const struct render_canvas *canvas, const char *path)
{
	return render_png_write(path, canvas->pixels, canvas->width, canvas->height);
}

/* `cover`: 0 to 255, a factor of the colour's own opacity. */
static void blend(uint8_t *to, struct render_colour colour, unsigned cover)
{
	unsigned alpha = (colour.a * cover + 127) / 255, under = (to[3] * (255 - alpha) + 127) / 255, all = alpha + under;
	if (alpha == 0)
		return;
	to[0] = (uint8_t)((colour.r * alpha + to[0] * under + all / 2) / all);
	to[1] = (uint8_t)((colour.g * alpha + to[1] * under + all / 2) / all);
	to[2] = (uint8_t)((colour.b * alpha + to[2] * under + all / 2) / all);
	to[3] = (uint8_t)all;
}

/* Finds the whole pixels of the canvas that [low, high) touches. */
static void clip(double low, double high, uint32_t size, int64_t *first, int64_t *end)
{
	*first = (int64_t)floor(fmin(fmax(low, 0), size));
	*end = (int64_t)ceil(fmin(fmax(high, 0), size));
}

void render_canvas_box(const struct render_canvas *canvas, int x0, int y0, int x1, int y1, struct render_colour colour)
{
	int64_t left, right, low, high;
	clip(x0, x1, canvas->width, &left, &right);
	clip(y0, y1, canvas->height, &low, &high);
	for (int64_t y = low; y < high; y++)
		for (int64_t x = left; x < right; x++)
			blend(canvas->pixels + 4 * ((size_t)y * canvas->width + (size_t)x), colour, 255);
}

/* Returns 0 to 255: how much of a pixel is covered whose centre is `inside` pixels within an edge. */
static unsigned coverage(double inside)
{
	return (unsigned)(255 * fmin(fmax(inside + 0.5, 0), 1) + 0.5);
}

void render_canvas_disc(const struct render_canvas *canvas, double x, double y, double radius, struct render_colour colour)
{
	int64_t left, right, low, high;
	clip(x - radius - 1, x + radius + 1, canvas->width, &left, &right);
	clip(y - radius - 1, y + radius + 1, canvas->height, &low, &high);
	for (int64_t py = low; py < high; py++)
		for (int64_t px = left; px < right; px++) {
			double away = hypot((double)px + 0.5 - x, (double)py + 0.5 - y);
			blend(canvas->pixels + 4 * ((size_t)py * canvas->width + (size_t)px), colour, coverage(radius - away));
		}
}

/* For each pixel, the share of it that a line covers. Where the line crosses itself it is counted once, so a crossing is not
 * darker. */
struct mask {
	uint8_t *cover;
	int64_t left, low, width, height; /* on the canvas */
};

static double distance_to(const double a[2], const double b[2], double x, double y)
{
	double dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
	double t = length > 0 ? fmin(fmax(((x - a[0]) * dx + (y - a[1]) * dy) / length, 0), 1) : 0;
	return hypot(a[0] + t * dx - x, a[1] + t * dy - y);
}

static void mask_stretch(const struct mask *mask, const double a[2], const double b[2], double half)
{
	double reach = half + 1, dy = b[1] - a[1];
	double low = fmax(fmin(a[1], b[1]) - reach, (double)mask->low);
	double high = fmin(fmax(a[1], b[1]) + reach, (double)(mask->low + mask->height));
	for (int64_t y = (int64_t)floor(low); y < (int64_t)ceil(high); y++) {
		/* s .. e is the part of the line from a to b that can cover pixels of this row; 0 is a, 1 is b. */
		double s = 0, e = 1, row = (double)y + 0.5;
		if (dy != 0) {
			double p = (row - reach - a[1]) / dy, q = (row + reach - a[1]) / dy;
			s = fmax(fmin(p, q), 0);
			e = fmin(fmax(p, q), 1);
		}
		double from = a[0] + s * (b[0] - a[0]), to = a[0] + e * (b[0] - a[0]);
		double left = fmax(fmin(from, to) - reach, (double)mask->left);
		double right = fmin(fmax(from, to) + reach, (double)(mask->left + mask->width));
		uint8_t *cover = mask->cover + (y - mask->low) * mask->width - mask->left;
		for (int64_t x = (int64_t)floor(left); x < (int64_t)ceil(right); x++) {
			unsigned covered = coverage(half - distance_to(a, b, (double)x + 0.5, row));
			if (covered > cover[x])
				cover[x] = (uint8_t)covered;
		}
	}
}

enum status render_canvas_path(const struct render_canvas *canvas, const double (*points)[2], size_t count, double width,
			       struct render_colour colour)
{
	double half = width / 2, reach = half + 1, x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
	for (size_t i = 0; i < count; i++) {
		x0 = fmin(x0, points[i][0] - reach);
		y0 = fmin(y0, points[i][1] - reach);
		x1 = fmax(x1, points[i][0] + reach);
		y1 = fmax(y1, points[i][1] + reach);
	}
	struct mask mask;
	int64_t right, high;
	clip(x0, x1, canvas->width, &mask.left, &right);
	clip(y0, y1, canvas->height, &mask.low, &high);
	mask.width = right - mask.left;
	mask.height = high - mask.low;
	if (count == 0 || mask.width <= 0 || mask.height <= 0)
		return STATUS_OK;
	mask.cover = mem_calloc((size_t)mask.width, (size_t)mask.height);
	if (mask.cover == NULL)
		return fail_memory("a line");
	/* Skip points closer than a quarter of a pixel to the one before: nobody can see them apart. */
	const double *from = points[0];
	for (size_t i = count > 1; i < count; i++) {
		if (i + 1 < count && hypot(points[i][0] - from[0], points[i][1] - from[1]) < 0.25)
			continue;
		mask_stretch(&mask, from, points[i], half);
		from = points[i];
	}
	for (int64_t y = 0; y < mask.height; y++)
		for (int64_t x = 0; x < mask.width; x++)
			blend(canvas->pixels + 4 * ((size_t)(mask.low + y) * canvas->width + (size_t)(mask.left + x)), colour,
			      mask.cover[y * mask.width + x]);
	mem_free(mask.cover);
	return STATUS_OK;
}
