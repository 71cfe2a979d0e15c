/* Rows of posts into a store: cut, coded, written aside, renamed when whole. */
#include "intake.h"

#include <stdio.h>
#include <sys/stat.h>

#include "command.h"
#include "conveyor.h"

double intake_default_error(double unit)
{
	return unit > 0 ? unit / 2 : 0.001;
}

static enum status put_tile(void *user, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

/* Cuts and stores in turn, or at once in two threads. */
static enum status cut_and_store(const struct intake *intake, struct store *store, struct progress *progress)
{
	const struct world *world = &intake->meta.world;
	struct conveyor *conveyor = NULL;
	if (intake->jobs < 2)
		return dem_cut(world, intake->meta.step, intake->rows, intake->rows_user, put_tile, store, progress_step,
			       progress);
	enum status status = conveyor_create(store, world->cells, &conveyor);
	if (status != STATUS_OK)
		return status;
	status = dem_cut(world, intake->meta.step, intake->rows, intake->rows_user, conveyor_put, conveyor, progress_step,
			 progress);
	struct failure failure;
	failure_capture(&failure, status);
	enum status stored = conveyor_finish(conveyor);
	return status == STATUS_OK ? stored : failure_restore(&failure);
}

enum status intake_run(struct intake *intake)
{
	struct store *store = NULL;
	double started = clock_seconds();
	interrupt_catch();
	enum status status = store_create(intake->path, &intake->meta, intake->overwrite, &store);
	if (status != STATUS_OK)
		return status;
	struct progress progress;
	progress_start(&progress, intake->path, "rows");
	const struct world *world = &intake->meta.world;
	status = cut_and_store(intake, store, &progress);
	progress_end(&progress);
	if (status == STATUS_OK)
		status = store_publish(store);
	if (status == STATUS_OK)
		intake->low = store_meta(store)->low;
	store_close(store);
	if (status != STATUS_OK)
		return status;
	struct stat file;
	double bytes = stat(intake->path, &file) == 0 ? (double)file.st_size : 0;
	double posts = (double)world->width * (double)world->height, seconds = clock_seconds() - started;
	printf("%s: %lld x %lld posts, %g m apart, levels 0 to %d, %.1f MB (%.2f bytes a post), %.1f s "
	       "(%.1f million posts a second)\n",
	       intake->path, (long long)world->width, (long long)world->height, world->spacing,
	       world_coarsest(world), bytes / 1e6, bytes / posts, seconds, posts / seconds / 1e6);
	return STATUS_OK;
}
