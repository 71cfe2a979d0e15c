/* Imports imagery: reads the sources at the posts of one level, a few rows at a time, and gives the rows to the pyramid. */
#include "intake/internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FINEST (-3)          /* at most 8 pixels a post along a side */
#define PIXEL_MARGIN 1.1     /* a level's pixel may be larger than the source's by this factor */
#define READ_BYTES (24 << 20) /* about what is read at once */

/* Returns the coarsest level that keeps the source's detail. */
static int level_for(const struct extent *extent, double pixel)
{
	int level = extent_coarsest(extent);
	while (level > FINEST && extent_spacing(extent, level) > pixel * PIXEL_MARGIN)
		level--;
	return level;
}

static enum status read_all(struct intake_imagery *imagery, struct dem_imagery *opened, const struct extent *extent, struct imagery_rows *rows)
{
	const int64_t width = extent_posts(extent->width, imagery->finest), height = extent_posts(extent->height, imagery->finest);
	const int64_t least = READ_BYTES / (4 * width), most = least > height ? height : least < 32 ? 32 : least;
	uint8_t *pixels = mem_alloc((size_t)(width * most), 4);
	TRY_MEM(pixels, "imagery");
	enum status status = STATUS_OK;
	for (int64_t y = 0; y < height; y += most) {
		const struct post_rect rect = {0, y, width, y + most < height ? y + most : height};
		TRY_OR(done, dem_imagery_read(opened, imagery->finest, rect, pixels));
		for (int64_t row = 0; row < rect.y1 - rect.y0; row++) {
			if (imagery->progress != NULL)
				TRY_OR(done, imagery->progress(imagery->progress_user, y + row, height));
			TRY_OR(done, intake_imagery_rows_put(rows, pixels + 4 * row * width));
		}
	}
	if (imagery->progress != NULL)
		TRY_OR(done, imagery->progress(imagery->progress_user, height, height));
done:
	mem_free(pixels);
	return status;
}

/* Describes what decides the tiles: sources, level and quality. Free both texts with free(). */
static enum status describe(const struct intake_imagery *imagery, const struct dem_imagery_info *info, char **sources, char **request)
{
	size_t size;
	FILE *lines = open_memstream(sources, &size);
	TRY_MEM(lines, "imagery");
	for (size_t i = 0; i < info->source_count; i++)
		fprintf(lines, "%s\n", info->paths[i]);
	const bool listed = fclose(lines) == 0;
	FILE *all = listed ? open_memstream(request, &size) : NULL;
	TRY_MEM(all, "imagery");
	fprintf(all, "level %d quality %d\n%s", imagery->finest, imagery->quality, *sources);
	return fclose(all) == 0 ? STATUS_OK : fail_memory("imagery");
}

/* Ends an import that was begun, by how it went. */
static enum status end(const struct intake_imagery *imagery, struct store *store, enum status status)
{
	struct failure failure;
	if (status == STATUS_OK)
		status = store_imagery_finish(store);
	if (status == STATUS_OK)
		return STATUS_OK;
	failure_capture(&failure, status);
	if (status == STATUS_INTERRUPTED) {
		TRY(store_imagery_suspend(store));
		return fail_with(STATUS_INTERRUPTED, "%s: interrupted; furrow import --imagery ORTHO... -o %s --resume goes on with its imagery", imagery->store,
				 shell_path(imagery->store).text);
	}
	TRY(store_imagery_drop(store));
	return failure_restore(&failure);
}

/* Of all tiles, those of an import that was broken off among them. */
static enum status tell(struct intake_imagery *imagery, const struct store *store, const struct imagery_rows *rows)
{
	struct store_imagery has;
	TRY(store_imagery_info(store, &has));
	imagery->tiles = has.tiles;
	imagery->bytes = has.bytes;
	imagery->kept = intake_imagery_rows_kept(rows);
	return STATUS_OK;
}

static enum status import_opened(struct intake_imagery *imagery, struct store *store, struct dem_imagery *opened)
{
	const struct dem_imagery_info *info = dem_imagery_info(opened);
	const struct extent *extent = &store_meta(store)->extent;
	struct imagery_rows *rows = NULL;
	char *sources = NULL, *request = NULL;
	int64_t known = 0;
	enum status status;
	TRY_OR(done, describe(imagery, info, &sources, &request));
	const struct store_imagery_making making = {.finest = imagery->finest, .quality = imagery->quality, .sources = sources, .request = request,
						    .resume = imagery->resume, .overwrite = imagery->overwrite};
	TRY_OR(done, store_imagery_begin(store, &making, &known));
	status = intake_imagery_rows_create(store, imagery->finest, imagery->quality, imagery->jobs, &rows);
	if (status == STATUS_OK)
		status = read_all(imagery, opened, extent, rows);
	status = end(imagery, store, status);
	if (status == STATUS_OK)
		status = tell(imagery, store, rows);
done:
	intake_imagery_rows_destroy(rows);
	free(sources);
	free(request);
	return status;
}

static void choose_level(struct intake_imagery *imagery, const struct extent *extent, const struct dem_imagery_info *info)
{
	imagery->source_pixel = info->pixel;
	imagery->source_count = info->source_count;
	imagery->finest = level_for(extent, info->pixel);
	imagery->pixel = extent_spacing(extent, imagery->finest);
}

static struct dem_imagery_params params_of(const struct intake_imagery *imagery, const struct store_meta *meta)
{
	return (struct dem_imagery_params){.sources = imagery->sources, .count = imagery->count, .vrt_folder = imagery->vrt_folder, .extent = &meta->extent,
					   .srs = meta->srs, .origin = {meta->origin[0], meta->origin[1]}, .jobs = imagery->jobs};
}

enum status intake_imagery_run(struct intake_imagery *imagery)
{
	struct store *store = NULL;
	struct dem_imagery *opened = NULL;
	const double began = clock_seconds();
	enum status status;
	TRY(store_imagery_check(imagery->store));
	TRY_OR(done, store_open(imagery->store, &(struct store_options){.mode = imagery->dry ? STORE_READ : STORE_WRITE}, &store));
	const struct dem_imagery_params params = params_of(imagery, store_meta(store));
	TRY_OR(done, dem_imagery_open(&params, &opened));
	choose_level(imagery, params.extent, dem_imagery_info(opened));
	if (!imagery->dry)
		TRY_OR(done, import_opened(imagery, store, opened));
done:
	dem_imagery_close(opened);
	store_close(store);
	imagery->seconds = clock_seconds() - began;
	return status;
}

/* --- of an import's options --- */

static struct intake_imagery of_options(const struct import *import)
{
	return (struct intake_imagery){.sources = (const char *const *)import->imagery_sources, .count = import->imagery_count, .vrt_folder = import->dem.vrt_folder,
				       .quality = import->lossless ? 0 : import->quality, .jobs = import->jobs};
}

enum status intake_imagery_check(const struct import *import)
{
	struct dem_imagery *opened = NULL;
	const struct intake_imagery imagery = of_options(import);
	const struct dem_imagery_params params = params_of(&imagery, &import->meta);
	TRY(store_imagery_check("imagery"));
	const enum status status = dem_imagery_open(&params, &opened);
	dem_imagery_close(opened);
	return status;
}

enum status intake_imagery_add(const struct import *import, const char *store, bool dry, dem_progress_fn progress, void *user, struct intake_imagery *out)
{
	*out = of_options(import);
	out->store = store;
	out->resume = import->resume;
	out->overwrite = import->overwrite;
	out->dry = dry;
	out->progress = progress;
	out->progress_user = user;
	return intake_imagery_run(out);
}

enum status intake_import_imagery(const struct import *import, const char *store, bool dry, dem_progress_fn progress, void *user, struct intake_imagery *out)
{
	TRY(intake_import_check_options(import, true));
	return intake_imagery_add(import, store, dry, progress, user, out);
}
