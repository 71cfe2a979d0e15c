/* The raster of furrow edit: changes of heights at posts. A pixel's centre is a post, as in rasters that furrow export writes. */
#include "edit.h"

#include <math.h>
#include <stdio.h>

#include "dem/dem.h"

#define UNITS 0x1p20       /* of a metre */
#define OFF_MOST 0.01      /* of the spacing: a post that is farther off a pixel's centre is another place */
#define ROWS_AT_ONCE 64
#define POSTS_MOST (1e9)

struct edit_raster {
	const char *path;
	struct dem *dem;
	double west, south; /* m from the store's south-west post: of its own */
};

/* Converts a corner by the raster's system to the store's. Returns how far that moves it, m; infinity: there is no way. */
static double moves(const struct dem_info *info, const struct store_meta *meta, double x, double y)
{
	double to[2] = {x, y};
	if (dem_transform(info->srs, meta->srs, 1, &to[0], &to[1]) != STATUS_OK)
		return (double)INFINITY;
	return hypot(to[0] - x, to[1] - y);
}

static enum status check_system(struct edit_raster *raster, const struct store_meta *meta)
{
	const struct dem_info *info = dem_info(raster->dem);
	raster->west = info->origin[0];
	raster->south = info->origin[1];
	if (info->srs[0] == '\0') /* metres from the south-west post, as a map of soils without a system is */
		return STATUS_OK;
	if (meta->srs[0] == '\0')
		return fail_with(STATUS_INPUT, "%s: it has a reference system and the store has none; take it off (gdal_translate -a_srs \"\"), and give metres from the "
				       "store's south-west post", raster->path);
	const double far[2] = {info->origin[0] + (double)(info->width - 1) * info->spacing, info->origin[1] + (double)(info->height - 1) * info->spacing};
	const double off = fmax(moves(info, meta, info->origin[0], info->origin[1]), moves(info, meta, far[0], far[1]));
	if (!(off <= OFF_MOST * info->spacing))
		return fail_with(STATUS_INPUT, "%s: it is of another reference system than the store; warp it to that of the store, with pixels on its posts "
				       "(furrow export writes such a raster; gdalwarp -t_srs -te -tr)", raster->path);
	raster->west -= meta->origin[0];
	raster->south -= meta->origin[1];
	return STATUS_OK;
}

enum status edit_raster_open(const char *path, const struct store_meta *meta, struct edit_raster **out, double *spacing)
{
	const struct dem_params params = {.sources = &path, .source_count = 1, .t_srs = "source", .radii = DEM_RADII_NO};
	struct edit_raster *raster = mem_calloc(1, sizeof *raster);
	enum status status;
	TRY_MEM(raster, path);
	raster->path = path;
	if (!dem_path_ends(path, ".tif") && !dem_path_ends(path, ".tiff"))
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: it is no GeoTIFF; give a .tif of changes in metres, with a place", path));
	TRY_OR(failed, dem_open(&params, &raster->dem));
	if (dem_info(raster->dem)->resampled)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: its pixels are no squares of metres; warp it onto the store's posts (gdalwarp -t_srs -te -tr)", path));
	TRY_OR(failed, check_system(raster, meta));
	*spacing = dem_info(raster->dem)->spacing;
	*out = raster;
	return STATUS_OK;
failed:
	edit_raster_close(raster);
	return status;
}

void edit_raster_close(struct edit_raster *raster)
{
	if (raster == NULL)
		return;
	dem_close(raster->dem);
	mem_free(raster);
}

/* --- posts --- */

/* Finds the post on which the raster's south-western pixel lies. */
static enum status find_first(const struct edit_raster *raster, double spacing, int64_t first[2])
{
	const struct dem_info *info = dem_info(raster->dem);
	const double at[2] = {raster->west / spacing, raster->south / spacing};
	if (!(fabs(info->spacing / spacing - 1) * (double)(info->width > info->height ? info->width : info->height) <= OFF_MOST))
		return fail_with(STATUS_INPUT, "%s: its pixels are %.10g m apart, and the posts of this store %.10g m: they must be the same; give --spacing %.10g if "
				       "nothing was driven there yet, or warp it (gdalwarp -tr %.10g %.10g -tap)", raster->path, info->spacing, spacing, info->spacing,
				 spacing, spacing);
	for (int i = 0; i < 2; i++) {
		first[i] = (int64_t)llround(at[i]);
		if (!(fabs(at[i] - (double)first[i]) <= OFF_MOST))
			return fail_with(STATUS_INPUT, "%s: the centres of its pixels are not on posts: that of its south-west pixel is %.10g, %.10g m from the store's south-west "
					       "post; warp it with pixels on posts, as furrow export writes them", raster->path, raster->west, raster->south);
	}
	return STATUS_OK;
}

/* Widens the rectangle by the pixels of these rows that change something. */
static void widen(const double *heights, struct post_rect rows, struct post_rect *around)
{
	for (int64_t y = rows.y0; y < rows.y1; y++)
		for (int64_t x = rows.x0; x < rows.x1; x++) {
			const double height = heights[(size_t)(y - rows.y0) * (size_t)(rows.x1 - rows.x0) + (size_t)(x - rows.x0)];
			if (isnan(height) || lround(height * UNITS) == 0)
				continue;
			*around = post_rect_empty(*around) ? (struct post_rect){x, y, x + 1, y + 1} : post_rect_around(*around, (struct post_rect){x, y, x + 1, y + 1});
		}
}

/* Calls for all rows, some at a time. `amounts` NULL: finds the rectangle; else fills it. */
static enum status scan(const struct edit_raster *raster, struct post_rect *rect, int32_t *amounts)
{
	const struct dem_info *info = dem_info(raster->dem);
	const struct post_rect all = amounts != NULL ? *rect : (struct post_rect){0, 0, info->width, info->height};
	const size_t width = (size_t)(all.x1 - all.x0);
	double *heights = mem_alloc(ROWS_AT_ONCE * width, sizeof *heights);
	enum status status = STATUS_OK;
	TRY_MEM(heights, raster->path);
	for (int64_t y = all.y0; y < all.y1; y += ROWS_AT_ONCE) {
		const struct post_rect rows = {all.x0, y, all.x1, y + ROWS_AT_ONCE < all.y1 ? y + ROWS_AT_ONCE : all.y1};
		TRY_OR(done, dem_read(raster->dem, rows, heights));
		if (amounts == NULL)
			widen(heights, rows, rect);
		for (size_t i = 0; amounts != NULL && i < (size_t)(rows.y1 - y) * width; i++) {
			if (fabs(heights[i]) * UNITS >= INT32_MAX)
				TRY_OR(done, fail_with(STATUS_INPUT, "%s: it has a change of %g m, and a post takes less than 2048 m; check the unit", raster->path, heights[i]));
			amounts[(size_t)(y - all.y0) * width + i] = isnan(heights[i]) ? 0 : (int32_t)lround(heights[i] * UNITS);
		}
	}
done:
	mem_free(heights);
	return status;
}

enum status edit_raster_read(struct edit_raster *raster, const struct store_meta *meta, int level, struct post_rect *rect, int32_t **amounts)
{
	const struct extent *extent = &meta->extent;
	const double spacing = extent_spacing(extent, level);
	const int64_t columns = extent_posts(extent->width, level), rows = extent_posts(extent->height, level);
	int64_t first[2] = {0, 0};
	struct post_rect own = {0, 0, 0, 0};
	*amounts = NULL;
	*rect = own;
	TRY(find_first(raster, spacing, first));
	TRY(scan(raster, &own, NULL));
	if (post_rect_empty(own))
		return STATUS_OK;
	*rect = (struct post_rect){own.x0 + first[0], own.y0 + first[1], own.x1 + first[0], own.y1 + first[1]};
	if (rect->x0 < 0 || rect->y0 < 0 || rect->x1 > columns || rect->y1 > rows)
		return fail_with(STATUS_INPUT, "%s: it changes ground from %.10g, %.10g to %.10g, %.10g m, and the terrain goes from 0, 0 to %.10g, %.10g m; cut it to the terrain",
				 raster->path, (double)rect->x0 * spacing, (double)rect->y0 * spacing, (double)(rect->x1 - 1) * spacing, (double)(rect->y1 - 1) * spacing,
				 (double)(columns - 1) * spacing, (double)(rows - 1) * spacing);
	const double posts = (double)(own.x1 - own.x0) * (double)(own.y1 - own.y0);
	if (posts > POSTS_MOST)
		return fail_with(STATUS_INPUT, "%s: it changes %.3g posts, and %g is the most at once; cut it into parts", raster->path, posts, POSTS_MOST);
	*amounts = mem_calloc((size_t)posts, sizeof **amounts);
	TRY_MEM(*amounts, raster->path);
	return scan(raster, &own, *amounts);
}
