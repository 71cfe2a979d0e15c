/* Rows of posts into a store: cut, coded, written aside, renamed when whole. */
#include "intake.h"

#include <math.h>
#include <stdio.h>
#include <sys/stat.h>

#include "command.h"
#include "conveyor.h"

double intake_default_error(double unit)
{
	return unit > 0 ? unit / 2 : 0.001;
}

double intake_step(double max_error, double unit, bool whole)
{
	if (whole && max_error <= unit / 2)
		return unit;
	if (max_error == 0 || max_error == unit / 2)
		return 2 * max_error;
	int exponent;
	(void)frexp(2 * max_error, &exponent);
	return ldexp(1, exponent - 1);
}

static enum status cut_and_store(const struct intake *intake, struct store *store, int64_t stored,
				 struct progress *progress)
{
	struct conveyor *conveyor = NULL;
	enum status status = conveyor_create(store, intake->jobs, stored, &conveyor);
	if (status != STATUS_OK)
		return status;
	status = dem_cut(&(struct dem_cut){
		.extent = &intake->meta.extent,
		.step = intake->meta.step,
		.posts = intake->posts,
		.posts_user = intake->posts_user,
		.emit = conveyor_put,
		.emit_user = conveyor,
		.known = stored > 0 ? conveyor_known : NULL,
		.known_user = conveyor,
		.panel_posts = intake->panel_posts,
		.progress = progress_step,
		.progress_user = progress,
	});
	struct failure failure;
	failure_capture(&failure, status);
	enum status done = conveyor_finish(conveyor);
	/* Beside an interruption, what failed is what is told. */
	bool other = status == STATUS_OK || (status == STATUS_INTERRUPTED && done != STATUS_OK);
	return other ? done : failure_restore(&failure);
}

/* Ctrl-C: what is stored is kept for --resume. */
static enum status suspend(const struct intake *intake, struct store *store)
{
	enum status status = store_suspend(store);
	return status != STATUS_OK ? status
				   : fail_with(STATUS_INTERRUPTED, "%s: interrupted; the same command with --resume goes on",
					       intake->path);
}

enum status intake_run(struct intake *intake)
{
	struct store *store = NULL;
	double started = clock_seconds();
	int64_t stored = 0;
	interrupt_catch();
	enum status status = intake->resume
				     ? store_resume(intake->path, &intake->meta, intake->overwrite, &store, &stored)
				     : store_create(intake->path, &intake->meta, intake->overwrite, &store);
	if (status != STATUS_OK)
		return status;
	struct progress progress;
	progress_start(&progress, intake->path, "rows");
	const struct extent *extent = &intake->meta.extent;
	status = cut_and_store(intake, store, stored, &progress);
	progress_end(&progress);
	if (status == STATUS_INTERRUPTED && intake->meta.request != NULL)
		return suspend(intake, store);
	if (status == STATUS_OK)
		status = store_publish(store);
	if (status == STATUS_OK) {
		intake->low = store_meta(store)->low;
		intake->high = store_meta(store)->high;
	}
	store_close(store);
	if (status != STATUS_OK)
		return status;
	if (stored > 0)
		printf("%s: %lld tiles were there from before\n", intake->path, (long long)stored);
	struct stat file;
	double bytes = stat(intake->path, &file) == 0 ? (double)file.st_size : 0;
	double posts = (double)extent->width * (double)extent->height, seconds = clock_seconds() - started;
	printf("%s: %lld x %lld posts, %g m apart, levels 0 to %d, %.1f MB (%.2f bytes a post), %.1f s "
	       "(%.1f million posts a second)\n",
	       intake->path, (long long)extent->width, (long long)extent->height, extent->spacing,
	       extent_coarsest(extent), bytes / 1e6, bytes / posts, seconds, posts / seconds / 1e6);
	return STATUS_OK;
}
