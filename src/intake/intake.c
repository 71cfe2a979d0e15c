/* Writes rows of posts into a store: cuts and codes them, writes under another name, and renames when complete. */
#include "intake/intake.h"

#include <math.h>
#include <sys/stat.h>

#include "intake/conveyor.h"

/* Metres. A float32 holds each multiple that is below 16,384 m exactly, and the lattice of heights does. */
#define FLOAT_STEP (1.0 / 1024)

double intake_default_error(double unit)
{
	return unit > 0 ? unit / 2 : 0.001;
}

double intake_step(double max_error, double unit, bool whole)
{
	if (whole && max_error <= unit / 2)
		return unit;
	const double most = 2 * max_error;
	if (max_error == 0 || max_error == unit / 2)
		return most;
	if (most >= FLOAT_STEP)
		return floor(most / FLOAT_STEP) * FLOAT_STEP;
	int exponent;
	(void)frexp(most, &exponent);
	return ldexp(1, exponent - 1);
}

double intake_common_step(double coarse, double step)
{
	if (coarse <= step || step == 0 || fmod(coarse, step) == 0)
		return step;
	int exponent;
	const double parts = frexp(coarse / step, &exponent);
	return ldexp(coarse, parts == 0.5 ? 1 - exponent : -exponent);
}

static enum status get_tile(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error, bool *found)
{
	struct store_range range = {0};
	enum status status = intake_conveyor_get(user, tile, codes, &range, found);
	*low = range.low;
	*high = range.high;
	*error = range.error;
	return status;
}

static enum status settle(void *user)
{
	return intake_conveyor_settle(user);
}

struct measuring {
	const struct intake *intake;
	struct conveyor *conveyor;
	int64_t holes; /* posts of level 0 without a height */
};

/* A post that tiles share counts once: in the tile of which it is not in the last row or column. */
static int64_t count_holes(const struct extent *extent, const struct dem_tile *tile)
{
	const struct post_rect all = tile_post_rect(extent, tile->tile);
	int64_t holes = 0;
	for (int64_t y = all.y0; y < all.y1 && y < extent->height; y++)
		for (int64_t x = all.x0; x < all.x1 && x < extent->width; x++) {
			const bool own = (x + 1 < all.x1 || x + 1 == extent->width) && (y + 1 < all.y1 || y + 1 == extent->height);
			holes += own && tile->codes[(y - all.y0) * (all.x1 - all.x0) + x - all.x0] == HEIGHT_CODE_NODATA;
		}
	return holes;
}

static enum status put_tile(void *user, const struct dem_tile *tile)
{
	struct measuring *measuring = user;
	if (tile->tile.level == 0)
		measuring->holes += count_holes(&measuring->intake->meta.extent, tile);
	return intake_conveyor_put(measuring->conveyor, tile);
}

/* What is stored already was measured, too. */
static enum status measure_tile(void *user, const struct dem_tile *tile, struct misfit *source)
{
	const struct measuring *measuring = user;
	const struct intake *intake = measuring->intake;
	if (intake_conveyor_has(measuring->conveyor))
		return STATUS_OK;
	return intake->misfit(intake->posts_user, &intake->meta.extent, tile, intake->meta.step, source);
}

static enum status cut_and_store(const struct intake *intake, struct store *store, int64_t stored)
{
	struct conveyor *conveyor = NULL;
	TRY(intake_conveyor_create(store, intake->jobs, stored, &conveyor));
	struct measuring measuring = {intake, conveyor, 0};
	struct dem_insets_cut insets = {
		.insets = intake->insets,
		.step = intake->meta.step,
		.emit = intake_conveyor_put,
		.emit_user = conveyor,
		.get = get_tile,
		.get_user = conveyor,
		.settle = settle,
		.progress = intake->progress,
		.progress_user = intake->progress_user,
	};
	enum status status = intake->insets != NULL ? dem_insets_cut(&insets) : STATUS_OK;
	status = status != STATUS_OK ? status : dem_cut(&(struct dem_cut){
		.extent = &intake->meta.extent,
		.step = intake->meta.step,
		.posts = intake->posts,
		.posts_user = intake->posts_user,
		.emit = put_tile,
		.emit_user = &measuring,
		.measure = intake->misfit != NULL ? measure_tile : NULL,
		.measure_user = &measuring,
		.rounded = intake->rounded,
		.finer = intake->insets != NULL ? dem_insets_finer : NULL,
		.finer_user = &insets,
		.known = stored > 0 ? intake_conveyor_known : NULL,
		.known_user = conveyor,
		.panel_posts = intake->panel_posts,
		.progress = intake->progress,
		.progress_user = intake->progress_user,
	});
	struct failure failure;
	failure_capture(&failure, status);
	enum status done = intake_conveyor_finish(conveyor);
	const struct extent *extent = &intake->meta.extent;
	const double posts = (double)extent->width * (double)extent->height;
	store_put_holes(store, (double)measuring.holes / posts);
	if (status == STATUS_OK && done == STATUS_OK && intake->none != NULL && intake->insets == NULL && (double)measuring.holes == posts)
		return fail_with(STATUS_INPUT, "%s: none of its %.0f posts has a height; %s", intake->path, posts, intake->none);
	/* If something failed besides an interruption, the failure is told. */
	bool other = status == STATUS_OK || (status == STATUS_INTERRUPTED && done != STATUS_OK);
	return other ? done : failure_restore(&failure);
}

/* Broken off: the stored part is kept for a later call. */
static enum status suspend(const struct intake *intake, struct store *store)
{
	TRY(store_suspend(store));
	return fail_with(STATUS_INTERRUPTED, "%s: interrupted; run the same import with --resume to go on", intake->path);
}

enum status intake_run(struct intake *intake)
{
	struct store *store = NULL;
	const double started = clock_seconds();
	int64_t stored = 0;
	const enum store_overwrite overwrite = !intake->overwrite ? STORE_OVERWRITE_NOT : intake->force ? STORE_OVERWRITE_FORCE : STORE_OVERWRITE;
	TRY(intake->resume ? store_resume(intake->path, &intake->meta, overwrite, &store, &stored)
			   : store_create(intake->path, &intake->meta, overwrite, &store));
	enum status status = cut_and_store(intake, store, stored);
	if (status == STATUS_INTERRUPTED && intake->meta.request != NULL)
		return suspend(intake, store);
	TRY_OR(done, status);
	TRY_OR(done, store_publish(store));
	const struct store_meta *made = store_meta(store);
	intake->low = made->low;
	intake->high = made->high;
	intake->meta.holes = made->holes;
	intake->meta.off_resampled = made->off_resampled;
	intake->meta.off_source = made->off_source;
done:
	store_close(store);
	TRY(status);
	struct stat file;
	intake->stored = stored;
	intake->bytes = stat(intake->path, &file) == 0 ? (int64_t)file.st_size : 0;
	intake->seconds = clock_seconds() - started;
	return STATUS_OK;
}
