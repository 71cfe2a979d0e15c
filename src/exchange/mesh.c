/*
 * A window of the surface as triangles.
 *
 * The window is read row by row, once to count and to find its bounds, then once for vertices and once for triangles. So memory
 * follows a row's length, and the file's counts are known before it begins.
 *
 *  1. A cell has two triangles, divided from south-east to north-west. One where a post is a hole, none where more are.
 *  2. A post is a vertex if a triangle has it. Vertices are numbered in the order of rows.
 */
#include "exchange/mesh.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#include "base/aside.h"
#include "dem/dem.h"

#define STRIP 64
#define BYTES_MOST 4294967295.0 /* glb counts its bytes in 32 bits */

/* --- rows --- */

/* Bits of the posts of a cell that are no holes; 0 beyond the window. `above`: 0 for the cell to the north of this row, -1 and 1. */
static unsigned cell(const struct exchange_row *row, int64_t x, int above)
{
	int64_t y = row->y + above;
	if (x < 0 || y < 0 || x + 1 >= row->width || y + 1 >= row->rows)
		return 0;
	const double *south = row->heights[1 + above] + x + 1, *north = row->heights[2 + above] + x + 1;
	return (unsigned)!isnan(south[0]) | (unsigned)!isnan(south[1]) << 1 | (unsigned)!isnan(north[0]) << 2 | (unsigned)!isnan(north[1]) << 3;
}

static bool has_triangle(unsigned mask)
{
	return mask == 15 || mask == 14 || mask == 13 || mask == 11 || mask == 7;
}

bool exchange_row_used(const struct exchange_row *row, int64_t x, int above)
{
	for (int dy = 0; dy < 2; dy++)
		for (int dx = 0; dx < 2; dx++) {
			unsigned mask = cell(row, x - dx, above - dy);
			if (has_triangle(mask) && (mask >> (2 * dy + dx) & 1))
				return true;
		}
	return false;
}

int exchange_row_triangles(const struct exchange_row *row, int64_t x, int triangles[2][3])
{
	static const int whole[2][3] = {{0, 1, 2}, {2, 1, 3}};
	static const int without[4][3] = {{2, 1, 3}, {0, 3, 2}, {0, 1, 3}, {0, 1, 2}};
	unsigned mask = cell(row, x, 0);
	if (!has_triangle(mask))
		return 0;
	memcpy(triangles, whole, sizeof whole);
	for (int missing = 0; missing < 4; missing++)
		if (!(mask >> missing & 1)) {
			memcpy(triangles[0], without[missing], sizeof without[missing]);
			return 1;
		}
	return 2;
}

void exchange_row_normal(const struct exchange_row *row, int64_t x, double spacing, double normal[3])
{
	double posts[9], east, north;
	for (int k = 0; k < 9; k++)
		posts[k] = row->heights[k / 3][x + k % 3];
	chart_slopes(posts, 1, 1, spacing, &east, &north);
	double size = sqrt(1 + east * east + north * north);
	normal[0] = -east / size;
	normal[1] = -north / size;
	normal[2] = 1 / size;
}

enum status exchange_surface_each(struct exchange_surface *surface, exchange_row_fn fn, void *user)
{
	const struct exchange_mesh_params *params = surface->params;
	int64_t stride = surface->width + 2;
	double *posts = mem_alloc((size_t)stride * (STRIP + 3), sizeof *posts);
	enum status status;
	TRY_OR(done, posts != NULL ? STATUS_OK : fail_memory("rows of a mesh"));
	for (int64_t y = 0; y < surface->rows; y += STRIP) {
		int64_t rows = surface->rows - y < STRIP ? surface->rows - y : STRIP;
		struct post_rect rect = {params->rect.x0 - 1, params->rect.y0 + y - 1, params->rect.x1 + 1, params->rect.y0 + y + rows + 2};
		TRY_OR(done, store_read_posts(params->reader, STORE_SURFACE, params->level, rect, posts));
		for (int64_t i = 0; i < rows; i++) {
			struct exchange_row row = {.y = y + i, .width = surface->width, .rows = surface->rows};
			for (int k = 0; k < 4; k++)
				row.heights[k] = posts + (i + k) * stride;
			TRY_OR(done, fn(user, &row));
		}
		surface->done += rows;
		if (params->progress != NULL)
			TRY_OR(done, params->progress(params->progress_user, surface->done, surface->total));
	}
done:
	mem_free(posts);
	return status;
}

void exchange_surface_position(const struct exchange_surface *surface, const struct exchange_row *row, int64_t x, double out[3])
{
	out[0] = (float)((double)x * surface->spacing);
	out[1] = (float)((double)row->y * surface->spacing);
	out[2] = (float)(row->heights[1][x + 1] - surface->origin[2]);
}

enum status exchange_surface_put(struct exchange_surface *surface, const void *bytes, size_t size)
{
	return fwrite(bytes, 1, size, surface->file) == size
		       ? STATUS_OK
		       : fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", surface->params->path, strerror(errno));
}

void exchange_surface_turn(const struct exchange_surface *surface, const double from[3], double to[3])
{
	to[0] = from[0];
	to[1] = from[surface->y_up ? 2 : 1];
	to[2] = surface->y_up ? 0 - from[1] : from[2]; /* never -0 */
}

/* --- counting --- */

static enum status count_row(void *user, const struct exchange_row *row)
{
	struct exchange_surface *surface = user;
	uint64_t used = 0;
	for (int64_t x = 0; x < row->width; x++) {
		int triangles[2][3];
		surface->triangles += (uint64_t)exchange_row_triangles(row, x, triangles);
		if (!exchange_row_used(row, x, 0))
			continue;
		used++;
		const double at[] = {(double)x * surface->spacing, (double)row->y * surface->spacing, row->heights[1][x + 1]};
		for (int c = 0; c < 3; c++) {
			surface->low[c] = fmin(surface->low[c], at[c]);
			surface->high[c] = fmax(surface->high[c], at[c]);
		}
	}
	surface->first[row->y + 1] = surface->first[row->y] + used;
	return STATUS_OK;
}

/* --- triangles --- */

struct triangles {
	struct exchange_surface *surface;
	exchange_triangle_fn fn;
	void *user;
};

static enum status row_triangles(void *user, const struct exchange_row *row)
{
	const struct triangles *all = user;
	uint64_t here = all->surface->first[row->y], above = all->surface->first[row->y + 1];
	for (int64_t x = 0; x + 1 < row->width && row->y + 1 < row->rows; x++) {
		int corners[2][3], count = exchange_row_triangles(row, x, corners);
		bool here_used = exchange_row_used(row, x, 0), above_used = exchange_row_used(row, x, 1);
		const uint64_t numbers[] = {here, here + here_used, above, above + above_used};
		for (int k = 0; k < count; k++) {
			const uint64_t vertices[] = {numbers[corners[k][0]], numbers[corners[k][1]], numbers[corners[k][2]]};
			TRY(all->fn(all->user, row, x, corners[k], vertices));
		}
		here += here_used;
		above += above_used;
	}
	return STATUS_OK;
}

enum status exchange_surface_triangles(struct exchange_surface *surface, exchange_triangle_fn fn, void *user)
{
	struct triangles all = {surface, fn, user};
	return exchange_surface_each(surface, row_triangles, &all);
}

/* --- a mesh --- */

/* As if there were no holes, so that the answer comes at once. */
static enum status check_size(const struct exchange_surface *surface, const struct exchange_mesh_format *format)
{
	const struct exchange_mesh_params *params = surface->params;
	double width = (double)surface->width, rows = (double)surface->rows, triangles = 2 * (width - 1) * (rows - 1);
	double bytes = format->bytes(width * rows, triangles);
	if (bytes <= BYTES_MOST)
		return STATUS_OK;
	int coarser = 0;
	double least;
	do { /* a coarser level has at most two posts more than its share, one at each end */
		const double share = exp2(-++coarser), posts = (width * share + 2) * (rows * share + 2);
		least = format->bytes(posts, 2 * posts);
	} while (least > BYTES_MOST);
	return fail_with(STATUS_INPUT, "%s: %lld x %lld posts make %.0f triangles in %.1f GB, and 4.2 GB is the most; give a smaller --window, or "
			 "--level %d", params->path, (long long)surface->width, (long long)surface->rows, triangles, bytes / 1e9,
			 params->level + coarser);
}

static enum status write_file(struct exchange_surface *surface, const struct exchange_mesh_format *format)
{
	struct aside aside;
	enum status status;
	TRY_OR(done, aside_begin(&aside, surface->params->path));
	surface->file = aside.file;
	TRY_OR(done, format->write(surface));
done:
	return aside_end(&aside, true, status);
}

static enum status count_and_write(struct exchange_surface *surface, const struct exchange_mesh_format *format)
{
	const struct exchange_mesh_params *params = surface->params;
	TRY(exchange_surface_each(surface, count_row, surface));
	if (surface->triangles == 0)
		return fail_with(STATUS_INPUT, "%s: no cell of the window has three posts with a height; give another --window", params->path);
	surface->origin[0] = (double)params->rect.x0 * surface->spacing;
	surface->origin[1] = (double)params->rect.y0 * surface->spacing;
	surface->origin[2] = floor(surface->low[2]);
	surface->low[2] -= surface->origin[2];
	surface->high[2] -= surface->origin[2];
	return write_file(surface, format);
}

/* Length of the UTF-8 character at `at`, 1 to 4; 0: there is none, or it is a control character. */
static size_t character(const unsigned char *at)
{
	static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
	const size_t length = at[0] < 0x80 ? 1 : at[0] >> 5 == 6 ? 2 : at[0] >> 4 == 14 ? 3 : at[0] >> 3 == 30 ? 4 : 0;
	unsigned code = length > 1 ? at[0] & (0x7fu >> length) : at[0];
	for (size_t i = 1; i < length; i++) {
		if (at[i] >> 6 != 2)
			return 0;
		code = code << 6 | (at[i] & 0x3f);
	}
	const bool surrogate = code >= 0xd800 && code < 0xe000;
	return length > 0 && code >= 32 && (code < 127 || code >= 160) && code >= least[length] && code < 0x110000 && !surrogate ? length : 0;
}

/* Copies a name; what is no character, or none that is seen, becomes _. */
static void copy_name(const char *from, char *to, size_t room)
{
	size_t used = 0;
	for (const char *at = from; *at != '\0' && used + 5 < room;) {
		const size_t length = character((const unsigned char *)at);
		memcpy(to + used, length > 0 ? at : "_", length > 0 ? length : 1);
		used += length > 0 ? length : 1;
		at += length > 0 ? length : 1;
	}
	to[used] = '\0';
}

static void tell(const struct exchange_surface *surface, struct exchange_mesh_result *result)
{
	*result = (struct exchange_mesh_result){.triangles = surface->triangles, .vertices = surface->first[surface->rows], .y_up = surface->y_up};
	for (int c = 0; c < 3; c++) {
		result->origin[c] = surface->origin[c];
		result->low[c] = (float)surface->low[c];
		result->high[c] = (float)surface->high[c];
	}
}

enum status exchange_mesh(const struct exchange_mesh_params *params, struct exchange_mesh_result *result)
{
	static const struct exchange_mesh_format *const formats[] = {&exchange_obj, &exchange_glb, &exchange_stl};
	const struct exchange_mesh_format *format = NULL;
	for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
		format = dem_path_ends(params->path, formats[i]->ending) ? formats[i] : format;
	if (format == NULL)
		return fail_with(STATUS_USAGE, "%s: no mesh that can be written has this ending; name a .obj, .glb or .stl", params->path);
	if (format == &exchange_glb && params->up == EXCHANGE_UP_Z)
		return fail_with(STATUS_USAGE, "%s: glTF's y is up, by its specification; leave --up out, or write a .obj or .stl", params->path);
	struct exchange_surface surface = {
		.params = params,
		.y_up = params->up == EXCHANGE_UP_FORMAT ? format->y_up : params->up == EXCHANGE_UP_Y,
		.width = params->rect.x1 - params->rect.x0,
		.rows = params->rect.y1 - params->rect.y0,
		.spacing = extent_spacing(&params->meta->extent, params->level),
		.low = {INFINITY, INFINITY, INFINITY},
		.high = {-INFINITY, -INFINITY, -INFINITY},
	};
	copy_name(params->name != NULL && params->name[0] != '\0' ? params->name : "terrain", surface.name, sizeof surface.name);
	TRY(check_size(&surface, format));
	surface.total = surface.rows * (1 + format->passes);
	TRY(mem_zeroed(&surface.first, (size_t)surface.rows + 1, sizeof *surface.first, "rows of a mesh"));
	enum status status = count_and_write(&surface, format);
	if (status == STATUS_OK)
		tell(&surface, result);
	mem_free(surface.first);
	return status;
}
