/*
 * Measures by how much a surface is off the sources at their own posts. Each source post is put on the surface. There the height
 * of the surface is compared with that of the post.
 */
#include "dem_gdal.h"

#define CHUNK_ROWS 128
#define PROBES 3 /* points along each side of a surface, to find the source posts below it */

/* Gives the posts of a raster that may lie under a rectangle of the target. */
static struct post_rect posts_under(const struct dem_group *group, struct post_rect rect)
{
	const struct dem_lattice *raster = dem_layers_lattice(group->layers);
	double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {-(double)INFINITY, -(double)INFINITY};
	for (int i = 0; i < PROBES * PROBES; i++) {
		int64_t x = rect.x0 + (rect.x1 - 1 - rect.x0) * (i % PROBES) / (PROBES - 1);
		int64_t y = rect.y0 + (rect.y1 - 1 - rect.y0) * (i / PROBES) / (PROBES - 1);
		double at[2];
		dem_sampler_place(group->sampler, x, y, &at[0], &at[1]);
		for (int axis = 0; axis < 2; axis++) {
			low[axis] = fmin(low[axis], at[axis]); /* fmin ignores NaN */
			high[axis] = fmax(high[axis], at[axis]);
		}
	}
	if (!(low[0] <= high[0]))
		return (struct post_rect){0, 0, 0, 0};
	double room[2]; /* edges may be curved between probes */
	for (int axis = 0; axis < 2; axis++)
		room[axis] = 2 + 0.05 * (high[axis] - low[axis]);
	return (struct post_rect){
		(int64_t)fmax(0, floor(low[0] - room[0])),
		(int64_t)fmax(0, floor(low[1] - room[1])),
		(int64_t)fmax(0, fmin((double)raster->width, ceil(high[0] + room[0]) + 1)),
		(int64_t)fmax(0, fmin((double)raster->height, ceil(high[1] + room[1]) + 1)),
	};
}

/* True if the surface around (column, row) is made from this group alone. */
static bool all_owned(const struct dem_surface *surface, uint16_t group, double column, double row)
{
	const struct post_rect *rect = &surface->part.rect;
	if (surface->owners == NULL)
		return true;
	int64_t x0 = (int64_t)floor(column), y0 = (int64_t)floor(row), x1 = (int64_t)ceil(column), y1 = (int64_t)ceil(row);
	for (int64_t y = y0; y <= y1; y++)
		for (int64_t x = x0; x <= x1; x++)
			if (!(x >= rect->x0 && x < rect->x1 && y >= rect->y0 && y < rect->y1) ||
			    surface->owners[(y - rect->y0) * (rect->x1 - rect->x0) + x - rect->x0] != group)
				return false;
	return true;
}

static void compare_chunk(const struct dem_surface *surface, uint16_t group, const double *posts, const double *columns,
			  const double *rows, int64_t count, struct misfit *misfit)
{
	static const struct dem_kernel bilinear = {DEM_BILINEAR, {1, 1}};
	for (int64_t i = 0; i < count; i++) {
		double column = columns[i], row = rows[i], height;
		bool inside = column >= surface->low[0] && column < surface->high[0] && row >= surface->low[1] && row < surface->high[1];
		if (inside && !isnan(posts[i]) && all_owned(surface, group, column, row) &&
		    dem_kernel_sample(&bilinear, &surface->part, column, row, &height) == DEM_SAMPLED_WHOLE)
			misfit_add_post(misfit, height - posts[i]);
	}
}

struct dem_misfit_room {
	/* of a part's posts: their heights, and where they lie on the target */
	double posts[DEM_BLOCK_SIDE * CHUNK_ROWS], columns[DEM_BLOCK_SIDE * CHUNK_ROWS], rows[DEM_BLOCK_SIDE * CHUNK_ROWS];
};

struct dem_misfit_room *dem_misfit_room_create(void)
{
	return mem_alloc(1, sizeof(struct dem_misfit_room));
}

/* Adds the parts of a rectangle of posts, or counts them if `parts` is NULL. */
static size_t add_parts(size_t group, struct post_rect under, struct dem_misfit_part *parts)
{
	size_t count = 0;
	for (int64_t y = under.y0; !post_rect_empty(under) && y < under.y1; y += CHUNK_ROWS)
		for (int64_t x = under.x0; x < under.x1; x += DEM_BLOCK_SIDE, count++)
			if (parts != NULL)
				parts[count] = (struct dem_misfit_part){
					group, post_rect_intersect(under, (struct post_rect){x, y, x + DEM_BLOCK_SIDE, y + CHUNK_ROWS})};
	return count;
}

enum status dem_misfit_parts(const struct dem_groups *groups, const struct dem_surface *surface, struct dem_misfit_part **parts,
			     size_t *count)
{
	*count = 0;
	for (size_t i = 0; i < groups->count; i++)
		*count += add_parts(i, posts_under(&groups->groups[i], surface->part.rect), NULL);
	*parts = mem_alloc(*count + 1, sizeof **parts);
	if (*parts == NULL)
		return fail_memory("comparing with the sources");
	size_t filled = 0;
	for (size_t i = 0; i < groups->count; i++)
		filled += add_parts(i, posts_under(&groups->groups[i], surface->part.rect), *parts + filled);
	return STATUS_OK;
}

enum status dem_misfit_part(const struct dem_groups *groups, const struct dem_misfit_part *part, const struct dem_surface *surface,
			    struct dem_misfit_room *room, struct misfit *misfit, bool *done)
{
	const struct dem_group *group = &groups->groups[part->group];
	const struct post_rect *rect = &part->posts;
	TRY(dem_layers_read(group->layers, *rect, room->posts, done));
	if (!*done)
		return STATUS_OK;
	dem_map_rect(group->back, *rect, room->columns, room->rows);
	compare_chunk(surface, (uint16_t)part->group, room->posts, room->columns, room->rows, (rect->x1 - rect->x0) * (rect->y1 - rect->y0),
		      misfit);
	return STATUS_OK;
}
