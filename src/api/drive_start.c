/* The start of a drive: pages, the view, and the files of rows. */
#include "api/internal.h"

bool api_writes(const struct drive *drive)
{
	return drive->params->ranks == NULL || drive->params->ranks->rank == 0;
}

enum status api_agree(struct drive *drive, enum status status)
{
	const struct world_ranks *ranks = drive->params->ranks;
	return ranks != NULL ? ranks->agree(ranks->user, drive->world, status) : status;
}

/* --- the view --- */

/* What the store has after the commit is newer than what the view was told, so it is told first. Rows of the commit are written before it. */
static enum status before_record(void *user)
{
	struct drive *drive = user;
	if (drive->pictures != NULL)
		render_pictures_mark(drive->pictures);
	return api_take(drive);
}

/* A run resumed from this commit draws the picture of its step again, and none before it. */
static enum status before_commit(void *user)
{
	const struct drive *drive = user;
	return drive->pictures != NULL ? render_pictures_await(drive->pictures) : STATUS_OK;
}

static enum status start_view(struct drive *drive)
{
	const bool watched = drive->params->host != NULL;
	if (!world_scene(drive->world)->view.present)
		return STATUS_OK;
	enum status status = render_view_create(drive->world, watched, &drive->view);
	const size_t bytes = watched ? 0 : render_pictures_bytes(world_scene(drive->world));
	if (status == STATUS_OK && bytes > 0)
		status = render_pictures_create(world_resident(drive->world)->gpu, drive->params->directory, bytes, &drive->pictures);
	if (status != STATUS_OK)
		return status;
	return STATUS_OK;
}

/* --- files --- */

static enum status start_pages(struct drive *drive)
{
	const struct api_params *params = drive->params;
	FILE *commit_log = NULL;
	struct page_trace *trace = NULL;
	enum status status = api_writes(drive) ? api_folder_commits(params->directory, &commit_log) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	if (params->trace != NULL)
		status = page_trace_create(params->trace, &trace);
	if (status == STATUS_OK)
		return world_start_pages(drive->world, commit_log, trace);
	if (commit_log != NULL)
		fclose(commit_log);
	return status;
}

/* Opens the files of rows, and says who takes the rows. */
static enum status start_rows(struct drive *drive)
{
	const struct api_params *params = drive->params;
	struct world *world = drive->world;
	enum status status = STATUS_OK;
	if (api_writes(drive)) {
		status = api_folder_clear(world, params->directory);
		if (status == STATUS_OK && drive->pictures != NULL)
			status = render_cameras_folders(world_scene(world), params->directory);
		if (status == STATUS_OK)
			status = report_rows_open(world, params->directory, &drive->rows);
		if (status == STATUS_OK)
			status = report_vehicles_open(world, drive->vehicles, params->directory, &drive->vehicle_rows);
		if (status == STATUS_OK)
			status = report_volume_open(world, params->directory, &drive->volume);
	}
	if (status == STATUS_OK && drive->view != NULL && params->host == NULL)
		status = report_poses_open(world, params->directory, &drive->poses);
	if (status == STATUS_OK && params->ranks != NULL)
		params->share_rows(params->ranks->user, drive->rows);
	return status;
}

enum status api_start(struct drive *drive)
{
	struct world *world = drive->world;
	const struct scene *scene = world_scene(world);
	enum status status = world_start(world);
	if (status == STATUS_OK && scene->view.present)
		status = render_check_samples(world_resident(world)->gpu, scene->view.samples);
	if (status == STATUS_OK && drive->params->host == NULL)
		status = render_cameras_fit(scene, mem_usable().bytes);
	/* A drive that could not begin leaves nothing behind. */
	if (status == STATUS_OK && api_writes(drive))
		status = api_folder_make(drive->params->directory);
	if (status == STATUS_OK)
		status = start_pages(drive);
	const struct world_figures figures = vehicle_figures(drive->vehicles);
	world_set_figures(world, &figures);
	drive->commits = (struct world_commits){drive, before_record, before_commit};
	world_set_commits(world, &drive->commits);
	if (status == STATUS_OK)
		status = start_view(drive);
	if (status == STATUS_OK)
		status = world_warm(world);
	if (status == STATUS_OK && drive->view != NULL)
		status = render_view_warm(drive->view);
	if (status == STATUS_OK && drive->vehicles != NULL)
		status = vehicle_join(drive->vehicles, world);
	if (status != STATUS_OK)
		return status;
	world_seal(world);
	return start_rows(drive);
}
