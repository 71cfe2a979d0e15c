/* Heights at the samples of a tile, bilinear between the posts of one level. */
#include "exchange/internal.h"

#define BESIDE 1e-6 /* of a cell: a position no further outside the terrain is on its edge */

enum status exchange_sampler_init(struct exchange_sampler *sampler, const struct exchange_tiles_params *params)
{
	*sampler = (struct exchange_sampler){.extent = &store_meta(params->store)->extent, .windowed = params->has_window};
	enum status status;
	TRY_OR(failed, store_reader_create(params->store, &sampler->reader));
	TRY_OR(failed, exchange_frame_init(&sampler->frame, params));
	return STATUS_OK;
failed:
	exchange_sampler_finish(sampler);
	return status;
}

void exchange_sampler_finish(struct exchange_sampler *sampler)
{
	exchange_frame_finish(&sampler->frame);
	store_reader_destroy(sampler->reader);
	mem_free_all(sampler->x, sampler->y);
	for (int i = 0; i < 4; i++)
		mem_free(sampler->control[i]);
	mem_free(sampler->posts);
	*sampler = (struct exchange_sampler){.reader = NULL};
}

static bool grow(double **array, size_t room)
{
	mem_free(*array);
	*array = mem_alloc(room, sizeof **array);
	return *array != NULL;
}

static enum status reserve(struct exchange_sampler *sampler, size_t samples, size_t controls)
{
	if (samples > sampler->room) {
		sampler->room = 0;
		if (!grow(&sampler->x, samples) || !grow(&sampler->y, samples))
			return fail_memory("positions of a tile");
		sampler->room = samples;
	}
	if (controls > sampler->control_room) {
		sampler->control_room = 0;
		for (int i = 0; i < 4; i++)
			if (!grow(&sampler->control[i], controls))
				return fail_memory("positions of a tile");
		sampler->control_room = controls;
	}
	return STATUS_OK;
}

static int64_t floor_div(int64_t a, int64_t b)
{
	return a >= 0 ? a / b : -((-a + b - 1) / b);
}

static double between(double a, double b, double share)
{
	return share == 0 ? a : a + share * (b - a);
}

/* Samples outside the window or the clip have no position, as if the terrain ended there. The first is sample (i0, j0). */
static void cut_window(struct exchange_sampler *sampler, int64_t i0, int64_t j0)
{
	const struct exchange_frame *frame = &sampler->frame;
	const double spacing = extent_spacing(sampler->extent, sampler->zoom->level);
	if (!sampler->windowed)
		return;
	for (int64_t j = 0; j < sampler->ny; j++)
		for (int64_t i = 0; i < sampler->nx; i++) {
			const size_t at = (size_t)(j * sampler->nx + i);
			double x = 0, y = 0;
			bool shown = exchange_frame_shows(frame, sampler->x[at] * spacing, sampler->y[at] * spacing);
			if (shown && frame->clipped) {
				exchange_place_degrees(frame, sampler->zoom, (double)(i0 + i), (double)(j0 + j), &x, &y);
				shown = !exchange_frame_clips(frame, x, y);
			}
			if (!shown)
				sampler->x[at] = sampler->y[at] = (double)NAN;
		}
}

/* The posts around all positions, within the terrain. */
static void find_rect(struct exchange_sampler *sampler)
{
	const struct extent *extent = sampler->extent;
	int level = sampler->zoom->level;
	double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
	size_t count = (size_t)(sampler->nx * sampler->ny);
	for (size_t k = 0; k < count; k++) {
		/* NaN fails each comparison. */
		low[0] = sampler->x[k] < low[0] ? sampler->x[k] : low[0];
		low[1] = sampler->y[k] < low[1] ? sampler->y[k] : low[1];
		high[0] = sampler->x[k] > high[0] ? sampler->x[k] : high[0];
		high[1] = sampler->y[k] > high[1] ? sampler->y[k] : high[1];
	}
	double most_x = (double)extent_posts(extent->width, level), most_y = (double)extent_posts(extent->height, level);
	sampler->rect = (struct post_rect){0, 0, 0, 0};
	if (low[0] > high[0] || high[0] < -1 || high[1] < -1 || low[0] > most_x || low[1] > most_y)
		return;
	sampler->rect = (struct post_rect){(int64_t)fmax(floor(low[0]), 0), (int64_t)fmax(floor(low[1]), 0),
					   (int64_t)fmin(floor(high[0]) + 2, most_x), (int64_t)fmin(floor(high[1]) + 2, most_y)};
}

enum status exchange_sampler_place(struct exchange_sampler *sampler, const struct exchange_zoom *zoom, int64_t i0, int64_t j0, int64_t nx,
				   int64_t ny)
{
	int64_t control = zoom->control;
	int64_t ci0 = floor_div(i0, control), cj0 = floor_div(j0, control);
	int64_t cnx = floor_div(i0 + nx - 1, control) - ci0 + 2, cny = floor_div(j0 + ny - 1, control) - cj0 + 2;
	TRY(reserve(sampler, (size_t)(nx * ny), (size_t)(cnx * cny)));
	sampler->zoom = zoom;
	sampler->nx = nx;
	sampler->ny = ny;
	double *const *c = sampler->control;
	for (int64_t j = 0; j < cny; j++)
		for (int64_t i = 0; i < cnx; i++) {
			c[0][j * cnx + i] = (double)((ci0 + i) * control);
			c[1][j * cnx + i] = (double)((cj0 + j) * control);
		}
	exchange_place_exact(&sampler->frame, zoom, (size_t)(cnx * cny), c[0], c[1], c[2], c[3]);
	double scale = 1 / extent_spacing(sampler->extent, zoom->level);
	for (int64_t j = 0; j < ny; j++) {
		int64_t cj = floor_div(j0 + j, control);
		double v = (double)(j0 + j - cj * control) / (double)control;
		for (int64_t i = 0; i < nx; i++) {
			int64_t ci = floor_div(i0 + i, control), at = (cj - cj0) * cnx + (ci - ci0);
			double u = (double)(i0 + i - ci * control) / (double)control;
			size_t to = (size_t)(j * nx + i);
			if (u == 0 && v == 0) {
				sampler->x[to] = scale * c[2][at];
				sampler->y[to] = scale * c[3][at];
				continue;
			}
			/* Where u or v is 0, the far points do not count: tiles share their edges. */
			const double *px = c[2] + at, *py = c[3] + at;
			double south_x = between(px[0], u == 0 ? 0 : px[1], u), south_y = between(py[0], u == 0 ? 0 : py[1], u);
			double north_x = v == 0 ? 0 : between(px[cnx], u == 0 ? 0 : px[cnx + 1], u);
			double north_y = v == 0 ? 0 : between(py[cnx], u == 0 ? 0 : py[cnx + 1], u);
			sampler->x[to] = scale * between(south_x, north_x, v);
			sampler->y[to] = scale * between(south_y, north_y, v);
		}
	}
	cut_window(sampler, i0, j0);
	find_rect(sampler);
	return STATUS_OK;
}

enum status exchange_sampler_read(struct exchange_sampler *sampler, enum store_layer layer, double *values)
{
	struct post_rect rect = sampler->rect;
	size_t count = (size_t)(sampler->nx * sampler->ny);
	if (post_rect_empty(rect)) {
		for (size_t k = 0; k < count; k++)
			values[k] = (double)NAN;
		return STATUS_OK;
	}
	int64_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
	size_t posts = (size_t)width * (size_t)height;
	if (posts > sampler->posts_room) {
		sampler->posts_room = 0;
		if (!grow(&sampler->posts, posts))
			return fail_memory("posts of a tile");
		sampler->posts_room = posts;
	}
	TRY(store_read_posts(sampler->reader, layer, sampler->zoom->level, rect, sampler->posts));
	for (size_t k = 0; k < count; k++) {
		double x = sampler->x[k] - (double)rect.x0, y = sampler->y[k] - (double)rect.y0;
		values[k] = (double)NAN;
		if (!(x >= -BESIDE && y >= -BESIDE && x <= (double)(width - 1) + BESIDE && y <= (double)(height - 1) + BESIDE))
			continue;
		int64_t px = x > 0 ? (int64_t)x : 0, py = y > 0 ? (int64_t)y : 0;
		/* In the last row and column a cell has no far posts. */
		int64_t right = px + 1 < width, up = py + 1 < height ? width : 0;
		const double *p = sampler->posts + py * width + px;
		const double corners[4] = {p[0], p[right], p[up], p[up + right]};
		double u = x - (double)px, v = y - (double)py;
		double south = corners[0] + u * (corners[1] - corners[0]), north = corners[2] + u * (corners[3] - corners[2]);
		values[k] = south + v * (north - south);
		if (isnan(values[k]))
			values[k] = lattice_bilinear(corners, u, v, BESIDE);
	}
	return STATUS_OK;
}
