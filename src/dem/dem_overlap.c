/* Measures by how much sources disagree where they overlap: at each post of the later one, beside the earlier one's surface. */
#include "dem_gdal.h"

#define STRIP_POSTS (1 << 18)
#define AREA_PROBES 9 /* points along each side of a source that are projected to find its area */
#define PROBES 17 /* points along each side of a source that are projected to find where it lies on another */

/* Two sources, each as a raster of its own. */
struct pair {
	const struct gdal_source *first, *second;
	struct dem_layers *one, *other;
	struct dem_sampler *sampler; /* samples `one` at posts of `other` */
	double *own, *heights;       /* of a strip of `other`: its heights, and those of `one` */
	uint8_t *sampled;
};

static void pair_finish(struct pair *pair)
{
	dem_sampler_destroy(pair->sampler);
	dem_layers_destroy(pair->one);
	dem_layers_destroy(pair->other);
	mem_free_all(pair->own, pair->heights, pair->sampled);
}

static enum status pair_init(struct pair *pair)
{
	TRY(dem_layers_create(&pair->first, 1, &pair->one));
	TRY(dem_layers_create(&pair->second, 1, &pair->other));
	size_t posts = (size_t)dem_layers_lattice(pair->other)->width + STRIP_POSTS;
	pair->own = mem_alloc(posts, sizeof *pair->own);
	pair->heights = mem_alloc(posts, sizeof *pair->heights);
	pair->sampled = mem_alloc(posts, 1);
	TRY_MEM(pair->own != NULL && pair->heights != NULL && pair->sampled != NULL, "comparing overlaps");
	const struct dem_sampling sampling = {
		.layers = pair->one,
		.raster = dem_layers_lattice(pair->one),
		.posts = dem_layers_lattice(pair->other),
		.method = DEM_BILINEAR,
		.span = {1, 1},
		.name = pair->second->path,
	};
	return dem_sampler_create(&sampling, &pair->sampler);
}

/* Cuts `rect`, posts of `raster`, to those that may lie in the area of `area`. */
static enum status cut_to(const struct dem_lattice *area, const struct dem_lattice *raster, const char *name, struct post_rect *rect)
{
	struct dem_map *map;
	TRY(dem_map_create(area, raster, name, &map));
	double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {-(double)INFINITY, -(double)INFINITY};
	for (int i = 0; i < PROBES * PROBES; i++) {
		int64_t x = (area->width - 1) * (i % PROBES) / (PROBES - 1), y = (area->height - 1) * (i / PROBES) / (PROBES - 1);
		double at[2];
		dem_map_rect(map, (struct post_rect){x, y, x + 1, y + 1}, &at[0], &at[1]);
		for (int axis = 0; axis < 2; axis++) {
			low[axis] = fmin(low[axis], at[axis]); /* fmin ignores NaN */
			high[axis] = fmax(high[axis], at[axis]);
		}
	}
	dem_map_destroy(map);
	if (!(low[0] <= high[0])) {
		*rect = (struct post_rect){0, 0, 0, 0};
		return STATUS_OK;
	}
	double room[2]; /* edges may be curved between probes */
	for (int axis = 0; axis < 2; axis++)
		room[axis] = 1 + 0.01 * (high[axis] - low[axis]);
	*rect = post_rect_intersect(*rect, (struct post_rect){
		(int64_t)fmax(0, floor(low[0] - room[0])),
		(int64_t)fmax(0, floor(low[1] - room[1])),
		(int64_t)fmax(0, fmin((double)raster->width, ceil(high[0] + room[0]) + 1)),
		(int64_t)fmax(0, fmin((double)raster->height, ceil(high[1] + room[1]) + 1)),
	});
	return STATUS_OK;
}

static void count_strip(const struct pair *pair, size_t posts, struct dem_grid *grid)
{
	for (size_t i = 0; i < posts; i++) {
		if (isnan(pair->own[i]) || pair->sampled[i] != DEM_SAMPLED_WHOLE)
			continue;
		double off = fabs(pair->own[i] - pair->heights[i]);
		grid->overlap_posts++;
		grid->overlap_differing += off > 0 ? 1 : 0;
		grid->overlap_difference = off > grid->overlap_difference ? off : grid->overlap_difference;
	}
}

static enum status compare_rows(struct pair *pair, struct post_rect strip, struct dem_grid *grid)
{
	size_t posts = (size_t)((strip.x1 - strip.x0) * (strip.y1 - strip.y0));
	bool done;
	memset(pair->sampled, DEM_SAMPLED_NONE, posts);
	struct dem_samples samples = {.rect = strip, .heights = pair->heights, .sampled = pair->sampled};
	TRY(dem_layers_read(pair->other, strip, pair->own, &done));
	if (done)
		TRY(dem_sampler_read(pair->sampler, &samples, strip, &done));
	if (!done)
		return fail_with(STATUS_INPUT, "%s: reading where it overlaps %s failed%s; check that both are whole",
				 pair->second->path, pair->first->path, dem_gdal_because());
	count_strip(pair, posts, grid);
	return STATUS_OK;
}

static enum status compare(const struct gdal_source *first, const struct gdal_source *second, const struct dem_lattice *target,
			   struct dem_grid *grid)
{
	struct pair pair = {.first = first, .second = second};
	struct post_rect rect = {0, 0, second->width, second->height};
	enum status status;
	TRY_OR(done, pair_init(&pair));
	TRY_OR(done, cut_to(dem_layers_lattice(pair.one), dem_layers_lattice(pair.other), first->path, &rect));
	TRY_OR(done, cut_to(target, dem_layers_lattice(pair.other), first->path, &rect));
	int64_t width = rect.x1 - rect.x0, rows = width > 0 && STRIP_POSTS / width > 0 ? STRIP_POSTS / width : 1;
	for (int64_t y = rect.y0; !post_rect_empty(rect) && y < rect.y1; y += rows)
		TRY_OR(done, compare_rows(&pair, (struct post_rect){rect.x0, y, rect.x1, y + rows < rect.y1 ? y + rows : rect.y1}, grid));
done:
	pair_finish(&pair);
	return status;
}

/* Finds the area of a source in the SRS of the target. */
static enum status find_area(struct gdal_source *source, OGRSpatialReferenceH target)
{
	OGRCoordinateTransformationH move = NULL;
	if (source->srs != NULL && !OSRIsSame(source->srs, target)) {
		move = OCTNewCoordinateTransformation(source->srs, target);
		if (move == NULL)
			return fail_with(STATUS_INPUT, "%s: no way to project it%s; name another target with --t-srs", source->path,
					 dem_gdal_because());
	}
	source->low[0] = source->low[1] = (double)INFINITY;
	source->high[0] = source->high[1] = -(double)INFINITY;
	for (int i = 0; i < AREA_PROBES * AREA_PROBES; i++) {
		const double *p = source->place, column = (double)source->width * (i % AREA_PROBES) / (AREA_PROBES - 1),
			     row = (double)source->height * (i / AREA_PROBES) / (AREA_PROBES - 1);
		double at[2] = {p[0] + column * p[1] + row * p[2], p[3] + column * p[4] + row * p[5]};
		if ((move != NULL && !OCTTransform(move, 1, &at[0], &at[1], NULL)) || !isfinite(at[0]) || !isfinite(at[1]))
			continue;
		for (int axis = 0; axis < 2; axis++) {
			source->low[axis] = fmin(source->low[axis], at[axis]);
			source->high[axis] = fmax(source->high[axis], at[axis]);
		}
	}
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	return STATUS_OK;
}

static bool areas_meet(const struct gdal_source *a, const struct gdal_source *b)
{
	return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] && b->low[1] <= a->high[1];
}

enum status dem_overlap(struct gdal_source *sources, size_t count, const struct dem_lattice *target, struct dem_grid *grid)
{
	for (size_t i = 0; i < count; i++)
		TRY(find_area(&sources[i], target->srs));
	for (size_t j = 1; j < count; j++)
		for (size_t i = 0; i < j; i++)
			if (areas_meet(&sources[i], &sources[j]))
				TRY(compare(&sources[i], &sources[j], target, grid));
	return STATUS_OK;
}
