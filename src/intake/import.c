/* Imports elevation data into a store: opens the sources and makes the store. */
#include "intake/internal.h"

#include <math.h>
#include <stddef.h>

static enum status read_posts(void *user, struct post_rect rect, double *heights)
{
	const struct import *import = user;
	return dem_read(import->opened, rect, heights);
}

static enum status misfit(void *user, const struct extent *extent, const struct dem_tile *tile, double step, struct misfit *sum)
{
	const struct import *import = user;
	return dem_misfit(import->opened, extent, tile, step, sum);
}

/* Notes a height that is probably an undeclared hole. Such a value mixed with others may become any height. */
static void note_sentinel(const struct intake *intake)
{
	static const double usual[] = {-9999, -32767, -32768, -99999, 32767, 99999};
	/* Coarser heights may differ from a sentinel by rounding, or reach one by chance. */
	for (size_t i = 0; i < sizeof usual / sizeof usual[0] && intake->meta.max_error < 1; i++)
		if (intake->low == usual[i] || intake->high == usual[i]) {
			note("the %s height is %g m; if that means nodata, import again with --nodata %g",
			     usual[i] < 0 ? "lowest" : "highest", usual[i], usual[i]);
			return;
		}
	if (intake->low <= -12000)
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

enum status intake_import_run(struct import *import, const char *store, dem_progress_fn progress, void *user, struct intake *made)
{
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
	note_sentinel(made);
	return STATUS_OK;
}
