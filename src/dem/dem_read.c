/*
 * Reads posts of the grid of all sources. What is resampled is read in parts, by several threads.
 *
 * Invariants:
 * - A post's height does not depend on the part in which it is read.
 * - Sums over posts are added up part by part, in the order of the parts. So they do not depend on the number of threads.
 */
#include "dem_grid.h"

#include <stdio.h>

#define READERS_MOST 8 /* each may take some ten megabytes */

/* --- failures --- */

/* Reads all of one source to find out if it can be read. */
static bool reads(const struct gdal_source *source)
{
	GDALDatasetH dataset = GDALOpen(source->vrt, GA_ReadOnly);
	float *row = mem_alloc((size_t)source->width, sizeof *row);
	bool good = dataset != NULL && row != NULL;
	for (int y = 0; good && y < source->height; y++)
		good = GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Read, 0, y, source->width, 1, row, source->width,
				    1, GDT_Float32, 0, 0) == CE_None;
	mem_free(row);
	if (dataset != NULL)
		GDALClose(dataset);
	return good;
}

/* Returns the source that GDAL's message is about: the one it names, or the first one that cannot be read. */
static const char *culprit(const struct gdal_grid *gdal, const char *message)
{
	const char *found = NULL;
	for (size_t i = 0; i < gdal->source_count; i++) {
		const char *path = gdal->sources[i].path;
		if (strstr(message, path) != NULL && (found == NULL || strlen(path) > strlen(found)))
			found = path;
	}
	for (size_t i = 0; found == NULL && i < gdal->source_count; i++)
		if (gdal->source_count == 1 || !reads(&gdal->sources[i]))
			found = gdal->sources[i].path;
	return found != NULL ? found : gdal->name;
}

/* To be called by the thread to which GDAL gave its message. */
static enum status refuse_rows(const struct gdal_grid *gdal, struct post_rect rect)
{
	char message[320];
	snprintf(message, sizeof message, "%s", dem_gdal_because());
	return fail_with(STATUS_INPUT, "%s: reading it failed at row %d of the whole%s; fetch or make that file again",
			 culprit(gdal, message), (int)(gdal->grid.height - rect.y1), message);
}

/* --- readers --- */

/* Returns the span of a kernel (dem_kernel.h) for posts that are `times` as far apart as the source's. Those of GDAL's averages and of its
 * Lanczos kernels follow the spacing; the others widen only for a mean. */
static double span_of(enum dem_resample method, bool mean, double times)
{
	if (method == DEM_AVERAGE)
		return times;
	return mean || method == DEM_LANCZOS ? fmax(1, times) : 1;
}

enum status dem_grid_sampler(const struct gdal_grid *gdal, struct dem_group *group)
{
	struct dem_lattice posts;
	double s = gdal->target.spacing;
	bool mean = s > 2 * fmin(group->step[0], group->step[1]); /* otherwise a sample of the interpolated surface */
	bool doubles = false;
	for (size_t i = 0; i < group->count; i++)
		doubles = doubles || group->sources[i]->doubles;
	dem_target_lattice(&gdal->target, &posts);
	const struct dem_sampling sampling = {
		.layers = group->layers,
		.raster = dem_layers_lattice(group->layers),
		.posts = &posts,
		.method = gdal->method,
		.span = {span_of(gdal->method, mean, s / group->step[0]), span_of(gdal->method, mean, s / group->step[1])},
		.single = !doubles,
		.name = group->sources[0]->path,
	};
	TRY(dem_sampler_create(&sampling, &group->sampler));
	return dem_map_create(sampling.raster, &posts, sampling.name, &group->back);
}

void dem_reader_finish(struct dem_reader *reader, bool owns_groups)
{
	if (owns_groups)
		dem_groups_finish(&reader->groups);
	mem_free(reader->room);
}

/* Opens the sources once more, for another thread. */
static enum status open_again(const struct gdal_grid *gdal, struct dem_groups *groups)
{
	TRY(dem_groups_init(groups, gdal->sources, gdal->source_count));
	for (size_t i = 0; i < groups->count; i++) {
		const struct dem_group *first = &gdal->groups.groups[i];
		struct dem_group *group = &groups->groups[i];
		memcpy(group->step, first->step, sizeof group->step);
		group->projected = first->projected;
		TRY(dem_grid_sampler(gdal, group));
	}
	return STATUS_OK;
}

static enum status make_readers(struct gdal_grid *gdal)
{
	if (gdal->crew != NULL)
		return STATUS_OK;
	const size_t count = gdal->jobs < 1 ? 1 : gdal->jobs > READERS_MOST ? READERS_MOST : (size_t)gdal->jobs;
	if (gdal->readers == NULL) {
		TRY(mem_zeroed(&gdal->readers, count, sizeof *gdal->readers, "reading the sources"));
		gdal->readers[0].groups = gdal->groups;
		gdal->reader_count = 1;
	}
	while (gdal->reader_count < count)
		TRY(open_again(gdal, &gdal->readers[gdal->reader_count++].groups));
	return crew_create(count, "furrow-read", dem_quiet_begin, dem_quiet_end, &gdal->crew);
}

/* --- heights --- */

struct sampling {
	struct gdal_grid *gdal;
	struct dem_samples samples;
};

/* Returns columns as wide as a block of the samplers. */
static struct post_rect column_of(struct post_rect rect, size_t task)
{
	const int64_t first = rect.x0 / DEM_BLOCK_SIDE + (int64_t)task;
	return post_rect_intersect(rect, (struct post_rect){first * DEM_BLOCK_SIDE, rect.y0, (first + 1) * DEM_BLOCK_SIDE, rect.y1});
}

static enum status sample_part(void *user, size_t member, size_t task)
{
	const struct sampling *sampling = user;
	const struct dem_groups *groups = &sampling->gdal->readers[member].groups;
	struct dem_samples samples = sampling->samples;
	const struct post_rect all = samples.rect, part = column_of(all, task);
	const size_t width = (size_t)(part.x1 - part.x0);
	for (int64_t y = part.y0; y < part.y1; y++) {
		const int64_t at = (y - all.y0) * (all.x1 - all.x0) + part.x0 - all.x0;
		memset(samples.sampled + at, DEM_SAMPLED_NONE, width);
		for (size_t x = 0; x < width; x++)
			samples.heights[at + (int64_t)x] = (double)NAN;
	}
	bool done = true;
	CPLErrorReset();
	for (size_t i = 0; i < groups->count && done; i++, samples.owner++)
		TRY(dem_sampler_read(groups->groups[i].sampler, &samples, part, &done));
	return done ? STATUS_OK : refuse_rows(sampling->gdal, all);
}

/* owners: NULL, or for each post the number of the group that it was taken from. */
static enum status sample(struct gdal_grid *gdal, struct post_rect rect, double *heights, uint16_t *owners)
{
	size_t posts = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	if (posts > gdal->room) {
		mem_free(gdal->sampled);
		gdal->sampled = mem_alloc(posts, 1);
		gdal->room = gdal->sampled != NULL ? posts : 0;
		TRY_MEM(gdal->sampled, "reading the sources");
	}
	struct sampling sampling = {gdal, {rect, heights, gdal->sampled, owners, 0}};
	TRY(make_readers(gdal));
	const int64_t columns = (rect.x1 - 1) / DEM_BLOCK_SIDE - rect.x0 / DEM_BLOCK_SIDE + 1;
	return crew_run(gdal->crew, (size_t)columns, sample_part, &sampling);
}

enum status dem_grid_read(struct dem_grid *grid, struct post_rect rect, double *heights)
{
	struct gdal_grid *gdal = (struct gdal_grid *)grid;
	const struct dem_groups *groups = &gdal->groups;
	struct post_rect from;
	bool done = true;
	if (groups->count > 1 || !dem_sampler_copied(groups->groups[0].sampler, rect, &from))
		return sample(gdal, rect, heights, NULL);
	CPLErrorReset();
	TRY(dem_layers_read(groups->groups[0].layers, from, heights, &done));
	return done ? STATUS_OK : refuse_rows(gdal, rect);
}

/* --- misfits --- */

struct measuring {
	struct gdal_grid *gdal;
	struct dem_surface surface;
	const struct dem_misfit_part *parts;
	struct misfit *misfits; /* of each part */
};

static void limit_surface(const struct gdal_grid *gdal, const int64_t ends[2], struct dem_surface *surface)
{
	const struct post_rect *rect = &surface->part.rect;
	surface->low[0] = rect->x0 == 0 ? -0.5 : (double)rect->x0;
	surface->low[1] = rect->y0 == 0 ? -0.5 : (double)rect->y0;
	surface->high[0] = ends[0] >= gdal->grid.width - 1 ? (double)rect->x1 : (double)ends[0];
	surface->high[1] = ends[1] >= gdal->grid.height - 1 ? (double)rect->y1 : (double)ends[1];
}

static enum status measure_part(void *user, size_t member, size_t task)
{
	const struct measuring *measuring = user;
	struct dem_reader *reader = &measuring->gdal->readers[member];
	bool done = true;
	if (reader->room == NULL)
		reader->room = dem_misfit_room_create();
	TRY_MEM(reader->room, "comparing with the sources");
	CPLErrorReset();
	TRY(dem_misfit_part(&reader->groups, &measuring->parts[task], &measuring->surface, reader->room, &measuring->misfits[task], &done));
	return done ? STATUS_OK : refuse_rows(measuring->gdal, measuring->surface.part.rect);
}

static enum status measure(struct measuring *measuring, size_t count, struct misfit *misfit)
{
	TRY(mem_zeroed(&measuring->misfits, count + 1, sizeof *measuring->misfits, "comparing with the sources"));
	enum status status;
	TRY_OR(done, crew_run(measuring->gdal->crew, count, measure_part, measuring));
	for (size_t i = 0; i < count; i++)
		misfit_add(misfit, &measuring->misfits[i]);
done:
	mem_free(measuring->misfits);
	return status;
}

/* Finds out from which group each post was taken. */
static enum status find_owners(struct gdal_grid *gdal, struct post_rect rect, uint16_t **owners)
{
	const size_t posts = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	double *heights = mem_alloc(posts, sizeof *heights);
	*owners = mem_calloc(posts, sizeof **owners);
	enum status status = heights != NULL && *owners != NULL ? sample(gdal, rect, heights, *owners)
								: fail_memory("comparing with the sources");
	mem_free(heights);
	return status;
}

/* Parts come group by group. */
static bool of_one_group(const struct dem_misfit_part *parts, size_t count)
{
	return count == 0 || parts[0].group == parts[count - 1].group;
}

enum status dem_grid_misfit(struct dem_grid *grid, const struct dem_part *part, const int64_t ends[2], struct misfit *misfit)
{
	struct gdal_grid *gdal = (struct gdal_grid *)grid;
	struct measuring measuring = {.gdal = gdal, .surface = {.part = *part}};
	struct dem_misfit_part *parts = NULL;
	uint16_t *owners = NULL;
	size_t count = 0;
	limit_surface(gdal, ends, &measuring.surface);
	enum status status;
	TRY_OR(done, make_readers(gdal));
	TRY_OR(done, dem_misfit_parts(&gdal->groups, &measuring.surface, &parts, &count));
	if (!of_one_group(parts, count))
		TRY_OR(done, find_owners(gdal, part->rect, &owners));
	measuring.surface.owners = owners;
	measuring.parts = parts;
	TRY_OR(done, measure(&measuring, count, misfit));
done:
	mem_free_all(owners, parts);
	return status;
}
