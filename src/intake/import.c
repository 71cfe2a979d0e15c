/* Imports elevation data into a store: opens the sources and makes the store. */
#include "intake/internal.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static enum status read_posts(void *user, struct post_rect rect, double *heights)
{
	struct import *import = user;
	TRY(dem_read(import->opened, rect, heights));
	intake_census_add(import->census, heights, (rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	return STATUS_OK;
}

static enum status misfit(void *user, const struct extent *extent, const struct dem_tile *tile, double step, struct misfit *sum)
{
	const struct import *import = user;
	return dem_misfit(import->opened, extent, tile, step, sum);
}

/* Notes heights that are probably undeclared holes. Such a value mixed with others may become any height. */
static void note_sentinel(const struct import *import, const struct intake *intake)
{
	const bool plain = strstr(import->meta.vertical, "converted from units") == NULL;
	bool told = false;
	for (int low = 1; low >= 0; low--) {
		double height;
		if (!intake_census_find(import->census, low, &height))
			continue;
		char value[64] = " and the value that the source has there";
		if (plain)
			snprintf(value, sizeof value, " %s", number_exact(height).text);
		const int64_t posts = low ? import->census->low.posts : import->census->high.posts;
		note("the %s height is %s m, at %lld post%s, far from the others; if that means nodata, import again with --nodata%s", low ? "lowest" : "highest",
		     number_exact(height).text, (long long)posts, posts == 1 ? "" : "s", value);
		told = true;
	}
	if (intake->low <= -12000 && !told)
		note("the lowest height is %s m; if a value of the sources means nodata, as -32767 often does, import "
		     "again with --nodata and that value", number_exact(intake->low).text);
}

/* Heights that were whole numbers of a unit are none when they were converted, and are rounded to the unit again. */
static void note_rounding(const struct import *import)
{
	const struct dem_info *info = dem_info(import->opened);
	if (!info->shifted || !(info->unit > 0) || import->max_error >= 0)
		return;
	note("%s: its heights are multiples of %g m, and so they are again after the conversion to %s: up to %g m off, with steps where the conversion "
	     "changes; give --max-error %g to keep it smooth", info->sources[0], info->unit, info->vertical, info->unit / 2, info->unit / 20);
}

enum status intake_import_open(struct import *import, const char *const *sources, size_t count)
{
	TRY(intake_import_check_options(import, false));
	import->dem.sources = sources;
	import->dem.source_count = count;
	import->dem.nodata = import->nodata;
	import->dem.jobs = import->jobs;
	import->dem.apart = true;
	TRY(dem_open(&import->dem, &import->opened));
	const struct dem_info *info = dem_info(import->opened);
	const double max_error = import->max_error >= 0 ? import->max_error : intake_default_error(info->unit);
	import->meta = (struct store_meta){
		.extent = {info->width, info->height, info->spacing, (uint32_t)import->tile},
		.step = intake_step(max_error, info->unit, info->whole),
		.max_error = max_error,
		.srs = info->srs,
		.origin = {info->origin[0], info->origin[1]},
		.ground_off = info->ground_off,
		.holes = (double)NAN,
		.vertical = info->vertical,
		.pack = import->pack,
	};
	note_rounding(import);
	const char *problem = extent_problem(&import->meta.extent);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "import: %s; change --tile, --spacing or the sources", problem);
	if (import->inset_count > 0 || info->finer_count > 0)
		TRY(intake_import_open_insets(import));
	return intake_import_describe(import);
}

/* What to look at if no post has a height. */
static const char *why_none(const struct import *import)
{
	if (dem_info(import->opened)->projected[0] != '\0')
		return "the sources say other places than their SRS has (a longitude beyond 180 degrees, the radius of another body), or all their "
		       "values are nodata; name the right SRS with --s-srs, or keep the sources' with --t-srs source";
	return "all values of the sources are nodata; look at --nodata, at --window and at what gdalinfo says of nodata";
}

enum status intake_import_run(struct import *import, const char *store, dem_progress_fn progress, void *user, struct intake *made,
			      struct intake_imagery *coloured)
{
	if (import->imagery_count > 0)
		TRY(intake_imagery_check(import));
	if (import->census == NULL)
		TRY(mem_zeroed(&import->census, 1, sizeof *import->census, "counting heights"));
	*made = (struct intake){
		.path = store,
		.overwrite = import->overwrite,
		.force = import->force,
		.resume = import->resume,
		.jobs = import->jobs,
		.posts = read_posts,
		.posts_user = import,
		.insets = import->insets,
		.none = why_none(import),
		.rounded = import->coarse_step,
		.misfit = dem_info(import->opened)->resampled ? misfit : NULL,
		.panel_posts = dem_info(import->opened)->panel_posts,
		.meta = import->meta,
		.progress = progress,
		.progress_user = user,
	};
	TRY(intake_run(made));
	note_sentinel(import, made);
	if (import->imagery_count == 0)
		return STATUS_OK;
	const enum status status = intake_imagery_add(import, store, false, progress, user, coloured);
	if (status == STATUS_OK || status == STATUS_INTERRUPTED)
		return status;
	struct failure failure;
	failure_capture(&failure, status);
	return fail_with(status, "%s: it is made, without its imagery: %s", store, failure.message);
}
