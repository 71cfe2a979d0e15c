/* Opens a struct dem: finds the files of the sources, makes one grid from them, and collects what is known about that grid. */
#include "dem_internal.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/wide.h"

#define READ_POSTS (1 << 20) /* asked of a grid at once, about */

struct dem {
	struct dem_info info;
	struct dem_list list;
	struct dem_grid *grid;
	double *surface; /* heights of a tile, for dem_misfit */
	size_t room;     /* posts */
};

void dem_grid_destroy(struct dem_grid *grid)
{
	if (grid == NULL)
		return;
	mem_free_all(grid->srs, grid->vertical, grid->projected);
	dem_list_finish(&grid->files);
	dem_list_finish(&grid->finer);
	mem_free(grid->finer_sets);
	grid->destroy(grid);
}

size_t dem_vertical_length(const char *vertical)
{
	const char *unit = strstr(vertical, "converted from units of");
	const size_t length = unit != NULL ? (size_t)(unit - vertical) : strlen(vertical);
	return unit != NULL && length >= 2 ? length - 2 : length; /* ", " */
}

bool dem_vertical_note(const char *path, const char *vertical, const char *other, const char *other_vertical)
{
	const size_t length = dem_vertical_length(vertical), other_length = dem_vertical_length(other_vertical);
	if (length == other_length && strncmp(vertical, other_vertical, length) == 0)
		return false;
	if (length > 0 && other_length > 0)
		note("%s: its heights are above %.*s, and those of %s above %.*s; --t-vertical makes them the same", path, (int)length, vertical, other,
		     (int)other_length, other_vertical);
	else
		note("%s: does not say above what its heights are, and %s says %.*s; both are taken as they are. --s-vertical says it for all",
		     length == 0 ? path : other, length == 0 ? other : path, (int)(length + other_length), length == 0 ? other_vertical : vertical);
	return true;
}

static bool is_raw(const char *path)
{
	return dem_path_ends(path, ".raw") || dem_path_ends(path, ".r16") || dem_path_ends(path, ".r8");
}

static enum status params_check(const struct dem_params *params)
{
	if (params->source_count == 0)
		return fail_with(STATUS_USAGE, "no source: nothing to open; name a raster, a directory or "
				 "@list.txt");
	if (!(params->spacing >= 0) || params->spacing > 1e6)
		return fail_with(STATUS_USAGE, "spacing %g: not a distance between posts; give metres above 0",
				 params->spacing);
	const double *window = params->window;
	if (params->has_window && !(window[0] < window[2] && window[1] < window[3] && isfinite(window[2] - window[0]) &&
				    isfinite(window[3] - window[1])))
		return fail_with(STATUS_USAGE, "window %g,%g,%g,%g: not an area; give W,S,E,N with W below E and S below N", window[0],
				 window[1], window[2], window[3]);
	if (!params->has_window && params->window_srs != NULL)
		return fail_with(STATUS_USAGE, "window SRS \"%.80s\": there is no window; give it as W,S,E,N, or leave its SRS out",
				 params->window_srs);
	if (params->has_height_range && !(params->height_min < params->height_max &&
					  isfinite(params->height_max - params->height_min)))
		return fail_with(STATUS_USAGE, "height range %g, %g: the first is not below the second; give MIN,MAX in metres",
				 params->height_min, params->height_max);
	if (params->encoding != DEM_PLAIN && params->band > 0)
		return fail_with(STATUS_USAGE, "encoding: takes red, green and blue from the first three bands; leave --band out");
	return STATUS_OK;
}

/* Finds the file beside a picture that may say its place: a world file, or GDAL's own. Returns false if there is none. */
static bool has_beside(const char *path, char beside[4096])
{
	static const char *const endings[] = {".pgw", ".pngw", ".wld"};
	const char *name = strrchr(path, '/') != NULL ? strrchr(path, '/') + 1 : path, *dot = strrchr(name, '.');
	const int stem = dot != NULL ? (int)(dot - path) : (int)strlen(path);
	for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
		snprintf(beside, 4096, "%.*s%s", stem, path, endings[i]);
		if (access(beside, F_OK) == 0)
			return true;
	}
	snprintf(beside, 4096, "%s.aux.xml", path);
	return access(beside, F_OK) == 0;
}

/* A PNG with a place is a raster as others are. */
static bool is_placeless(const struct dem_params *params, const char *path)
{
	char beside[4096];
	return is_raw(path) || (dem_path_ends(path, ".png") && !(has_beside(path, beside) && dem_gdal_places(params, path)));
}

/* Drops heightmaps that were found in a directory, if there are sources that have a place. */
static void skip_placeless(const struct dem_params *params, struct dem_list *list)
{
	bool placed = false;
	for (size_t i = 0; i < list->count && !placed; i++)
		placed = !is_placeless(params, list->paths[i]);
	for (size_t i = list->count; placed && i-- > 0;)
		if (list->found[i] && is_placeless(params, list->paths[i]))
			dem_list_skip(list, i);
}

static enum status crop(const struct dem_params *params, struct dem_grid **grid)
{
	struct dem_grid *whole = *grid;
	*grid = NULL;
	return dem_crop_create(params, whole, grid);
}

static enum status grid_open(const struct dem_params *params, struct dem_list *list, struct dem_grid **out)
{
	skip_placeless(params, list);
	const char *placeless = NULL;
	for (size_t i = 0; i < list->count && placeless == NULL; i++)
		if (is_placeless(params, list->paths[i]))
			placeless = list->paths[i];
	bool plain = placeless != NULL;
	if (plain && list->count > 1)
		return fail_with(STATUS_INPUT, "%s: a heightmap has no place among other sources; import it "
				 "alone, or give it a place with gdal_translate", placeless);
	if (plain && params->s_unit != NULL)
		return fail_with(STATUS_USAGE, "unit %s: %s is a PNG or a raw heightmap; say what its values mean in metres with --height-range",
				 params->s_unit, list->paths[0]);
	if (plain && params->t_srs != NULL && strcmp(params->t_srs, "auto") != 0)
		return fail_with(STATUS_INPUT, "%s: has no place on a planet, so it cannot be projected; leave "
				 "the target SRS out", list->paths[0]);
	if (plain && params->s_srs != NULL)
		return fail_with(STATUS_INPUT, "%s: has no place, so --s-srs says nothing of it; give it one with gdal_translate -a_ullr or a world file (.pgw), or leave "
				 "--s-srs out", list->paths[0]);
	const bool chosen = params->encoding != DEM_PLAIN || params->band > 1;
	if (plain && chosen && is_raw(list->paths[0]))
		return fail_with(STATUS_USAGE, "%s: a raw heightmap has one band and no colours; leave --band and --encoding out", list->paths[0]);
	if (!plain || chosen)
		return dem_gdal_open(params, list, out);
	TRY(is_raw(list->paths[0]) ? dem_raw_open(params, list->paths[0], out) : dem_png_open(params, list->paths[0], out));
	return params->has_window ? crop(params, out) : STATUS_OK;
}

/* Tells that a heightmap's spacing is taken as 1 m, also where a file beside it may say another one. */
static void tell_spacing(const char *path)
{
	char beside[4096];
	if (!is_raw(path) && has_beside(path, beside) && strstr(beside, ".aux.xml") == NULL)
		note("%s: the world file %s is not read, since GDAL finds no place in it or is not there, and posts are taken as 1 m apart; give the first number of "
		     "that file as --spacing", path, beside);
	else
		note("%s: says no distance between posts; taken as 1 m. --spacing names another", path);
}

enum status dem_open(const struct dem_params *params, struct dem **out)
{
	TRY(params_check(params));
	struct dem *dem = mem_calloc(1, sizeof *dem);
	TRY_MEM(dem, "opening the sources");
	enum status status;
	TRY_OR(failed, dem_list_init(&dem->list, params->sources, params->source_count));
	TRY_OR(failed, grid_open(params, &dem->list, &dem->grid));
	if (!dem->grid->placed && params->spacing == 0 && params->anchor == NULL)
		tell_spacing(dem->list.paths[0]);
	if (dem->grid->width < 2 || dem->grid->height < 2)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: %lld x %lld posts are no terrain; it needs at least 2 x 2",
					 dem->list.paths[0], (long long)dem->grid->width, (long long)dem->grid->height));
	if (params->fill) {
		struct dem_grid *holed = dem->grid;
		dem->grid = NULL;
		TRY_OR(failed, dem_fill_create(holed, &dem->grid));
	}
	const struct dem_grid *grid = dem->grid;
	dem->info = (struct dem_info){
		.width = grid->width,
		.height = grid->height,
		.spacing = grid->spacing,
		.unit = grid->unit,
		.panel_posts = grid->panel_posts,
		.resampled = grid->misfit != NULL,
		.whole = grid->whole && !params->fill,
		.shifted = grid->shifted,
		.srs = grid->srs != NULL ? grid->srs : "",
		.origin = {grid->origin[0], grid->origin[1]},
		.vertical = grid->vertical != NULL ? grid->vertical : "",
		.projected = grid->projected != NULL ? grid->projected : "",
		.keepable = grid->keepable,
		.ground_off = grid->ground_off,
		.source_count = dem->list.count,
		.sources = (const char *const *)dem->list.paths,
		.file_count = grid->files.count,
		.files = (const char *const *)grid->files.paths,
		.finer_count = grid->finer.count,
		.finer = (const char *const *)grid->finer.paths,
		.finer_sets = grid->finer_sets,
		.covered = grid->covered > 0 ? grid->covered : 1,
		.overlap_posts = grid->overlap_posts,
		.overlap_differing = grid->overlap_differing,
		.overlap_difference = grid->overlap_difference,
	};
	*out = dem;
	return STATUS_OK;
failed:
	dem_close(dem);
	return status;
}

void dem_close(struct dem *dem)
{
	if (dem == NULL)
		return;
	dem_grid_destroy(dem->grid);
	dem_list_finish(&dem->list);
	mem_free_all(dem->surface, dem);
}

const struct dem_info *dem_info(const struct dem *dem)
{
	return &dem->info;
}

FURROW_WIDE static bool all_within(const double *heights, int64_t count)
{
	int64_t beyond = 0;
	for (int64_t i = 0; i < count; i++)
		beyond |= fabs(heights[i]) > HEIGHT_MAX;
	return beyond == 0;
}

/* Refuses heights that no ground can have. The message gives their place. */
static enum status check_heights(struct post_rect rect, const double *heights)
{
	int64_t width = rect.x1 - rect.x0, count = width * (rect.y1 - rect.y0), i = 0;
	if (all_within(heights, count))
		return STATUS_OK;
	while (!(fabs(heights[i]) > HEIGHT_MAX))
		i++;
	long long x = rect.x0 + i % width, y = rect.y0 + i / width;
	if (isinf(heights[i]))
		return fail_with(STATUS_INPUT, "post %lld, %lld: its height is infinite; name that value with --nodata or "
				 "repair the source", x, y);
	return fail_with(STATUS_INPUT, "post %lld, %lld: no ground is at %.9g m; if that value means nodata, give "
			 "--nodata %s", x, y, heights[i], number_exact(heights[i]).text);
}

enum status dem_read(struct dem *dem, struct post_rect rect, double *heights)
{
	struct dem_grid *grid = dem->grid;
	int64_t width = rect.x1 - rect.x0;
	if (rect.x0 < 0 || rect.y0 < 0 || width < 0 || rect.x1 > grid->width || rect.y1 > grid->height)
		return fail_with(STATUS_FAILED, "posts %lld, %lld to %lld, %lld: beyond the %lld x %lld posts of the source; "
				 "this is a bug", (long long)rect.x0, (long long)rect.y0, (long long)rect.x1 - 1,
				 (long long)rect.y1 - 1, (long long)grid->width, (long long)grid->height);
	int64_t strip = width > 0 && width < READ_POSTS ? READ_POSTS / width : 1;
	for (int64_t y = rect.y0; width > 0 && y < rect.y1; y += strip, heights += strip * width) {
		int64_t end = rect.y1 - y < strip ? rect.y1 : y + strip;
		struct post_rect part = {rect.x0, y, rect.x1, end};
		TRY(grid->read(grid, part, heights));
		TRY(check_heights(part, heights));
	}
	return STATUS_OK;
}

enum status dem_misfit(struct dem *dem, const struct extent *extent, const struct dem_tile *tile, double step, struct misfit *misfit)
{
	struct post_rect whole = tile_post_rect(extent, tile->tile);
	struct post_rect rect = post_rect_intersect(whole, (struct post_rect){0, 0, dem->grid->width, dem->grid->height});
	int64_t width = rect.x1 - rect.x0, rows = rect.y1 - rect.y0, stride = whole.x1 - whole.x0;
	size_t posts = (size_t)(stride * stride);
	if (posts > dem->room) {
		mem_free(dem->surface);
		dem->surface = mem_alloc(posts, sizeof *dem->surface);
		dem->room = dem->surface != NULL ? posts : 0;
		TRY_MEM(dem->surface, "comparing with the sources");
	}
	for (int64_t y = 0; y < rows; y++)
		for (int64_t x = 0; x < width; x++)
			dem->surface[y * width + x] = height_code_metres(tile->codes[y * stride + x], step);
	/* A tile's last row and column are measured only if no other tile has them. */
	return dem_misfit_heights(dem, rect, dem->surface, (int64_t[]){rect.x0 + extent->cells, rect.y0 + extent->cells}, misfit);
}

enum status dem_misfit_heights(struct dem *dem, struct post_rect rect, const double *heights, const int64_t ends[2], struct misfit *misfit)
{
	const struct dem_part surface = {heights, rect};
	return dem->grid->misfit(dem->grid, &surface, ends, misfit);
}
