/* furrow.h: a world is opened, closed, and tells what it is. */
#include "api/library.h"

#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#include "api/internal.h"

/* --- opening --- */

static _Atomic int64_t gl_process; /* the process that made GL contexts, or a parent of it; 0: none did */

/* A driver's threads and locks do not come along with a fork, so GL would wait for ever. */
static enum status need_own_gl(void)
{
	const int64_t process = getpid();
	int64_t before = 0;
	if (atomic_compare_exchange_strong(&gl_process, &before, process) || before == process)
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "open: this process is a child, by fork, of process %lld, which had opened worlds, and GL waits for ever here; start the "
				       "child as a program of its own (exec, or spawn in Python)", (long long)before);
}

#define OPEN_FIRST offsetof(struct furrow_open, reserved) /* bytes of the first version, which ended with unused bytes behind its last flag */

static enum status load_scene(const struct furrow_open *open, struct scene **out)
{
	if ((open->scene != NULL) == (open->scene_file != NULL))
		return fail_with(STATUS_USAGE, "open: scene and scene_file are both given, or neither; give one of them");
	return open->scene != NULL ? scene_load_text(open->scene, NULL, NULL, 0, SCENE_HOST, out)
				   : scene_load_file(open->scene_file, NULL, 0, SCENE_HOST, out);
}

static enum status start_pages(struct furrow_world *host)
{
	FILE *commit_log = NULL;
	enum status status = host->output != NULL ? api_folder_make(host->output) : STATUS_OK;
	if (status == STATUS_OK && host->output != NULL)
		status = api_folder_commits(host->output, &commit_log);
	return status == STATUS_OK ? world_start_pages(host->world, commit_log, NULL) : status;
}

static enum status start_output(struct furrow_world *host)
{
	if (host->output == NULL)
		return STATUS_OK;
	enum status status = api_folder_clear(host->world, host->output);
	if (status == STATUS_OK)
		status = report_rows_open(host->world, host->output, &host->rows);
	if (status == STATUS_OK)
		status = report_vehicles_open(host->world, host->vehicles, host->output, &host->vehicle_rows);
	return status;
}

static void tell_advice(void *user, const char *text)
{
	note("%s", text);
}

static enum status before_record(void *user)
{
	return api_library_take(user);
}

static enum status start(struct furrow_world *host)
{
	struct world *world = host->world;
	enum status status = world_start(world);
	if (status == STATUS_OK)
		status = start_pages(host);
	const struct world_figures figures = vehicle_figures(host->vehicles);
	world_set_figures(world, &figures);
	host->commits = (struct world_commits){host, before_record, NULL};
	world_set_commits(world, &host->commits);
	if (status == STATUS_OK && host->scene->view.present)
		status = api_library_start_view(host);
	if (status == STATUS_OK)
		status = world_warm(world);
	if (status == STATUS_OK && host->view != NULL)
		status = render_view_warm(host->view);
	if (status == STATUS_OK && host->vehicles != NULL)
		status = vehicle_join(host->vehicles, world);
	if (status == STATUS_OK)
		status = start_output(host);
	if (status != STATUS_OK)
		return status;
	world_seal(world);
	status = world_begin(world);
	if (status == STATUS_OK && host->vehicles != NULL) {
		vehicle_advise(host->vehicles, world, tell_advice, NULL);
		status = vehicle_begin(host->vehicles);
	}
	if (status == STATUS_OK)
		status = report_vehicles_write(host->vehicle_rows);
	if (status == STATUS_OK)
		status = api_library_take(host);
	return status == STATUS_OK ? api_library_checkpoint(host) : status;
}

static void destroy(struct furrow_world *host, enum status status)
{
	world_stop(host->world);
	render_view_destroy(host->view);
	world_finish(host->world, status);
	report_rows_close(host->rows);
	report_vehicles_close(host->vehicle_rows);
	vehicle_destroy(host->vehicles);
	scene_destroy(host->scene);
	mem_free(host->output);
	mem_free(host);
}

static enum status create(const struct furrow_open *open, struct furrow_world **out)
{
	struct furrow_world *host = mem_calloc(1, sizeof *host);
	if (host == NULL)
		return fail_memory("a world");
	enum status status = load_scene(open, &host->scene);
	if (status == STATUS_OK && open->output != NULL) {
		host->output = mem_alloc(strlen(open->output) + 1, 1);
		status = host->output != NULL ? STATUS_OK : fail_memory("a world");
		if (status == STATUS_OK)
			strcpy(host->output, open->output);
	}
	if (status == STATUS_OK)
		status = vehicle_load(host->scene, &host->vehicles);
	if (status == STATUS_OK) {
		const struct world_params params = {
			.scene = host->scene,
			.attached = vehicle_attached(host->vehicles),
			.store = open->store,
			.overlay = open->overlay,
			.resume = open->resume,
			.durable_full = open->durable,
			.keep_history = open->keep_history,
			.readonly = open->readonly,
			.draws = host->scene->view.present,
			.rows = open->output != NULL,
		};
		status = world_open(&params, &host->world);
	}
	if (status == STATUS_OK)
		status = need_own_gl();
	if (status == STATUS_OK)
		status = start(host);
	if (status != STATUS_OK) {
		struct failure failure;
		failure_capture(&failure, status);
		destroy(host, status);
		return failure_restore(&failure);
	}
	host->process = getpid();
	host->origin = world_time(host->world);
	if (world_time(host->world) == world_step_time(host->scene, world_steps_done(host->world))) { /* whole steps from the scene's start */
		host->origin = 0;
		host->steps = world_steps_done(host->world);
	}
	host->mark.origin = host->origin;
	host->mark.steps = host->steps;
	host->began = clock_seconds();
	*out = host;
	return STATUS_OK;
}

furrow_status furrow_world_open(const struct furrow_open *open, struct furrow_world **world)
{
	struct gpu_kept kept;
	struct furrow_open known = {.size = 0};
	enum status status = api_library_begin();
	if (world != NULL)
		*world = NULL;
	if (status == STATUS_OK)
		status = api_library_need(open, "open");
	if (status == STATUS_OK)
		status = api_library_need(world, "world");
	if (status == STATUS_OK)
		status = api_library_need_size(open->size, OPEN_FIRST, sizeof *open, "open");
	if (status != STATUS_OK)
		return api_library_end(status);
	/* What the first version has behind its last flag was never set. */
	memcpy(&known, open, open->size == OPEN_FIRST ? offsetof(struct furrow_open, readonly) : sizeof known < open->size ? sizeof known : open->size);
	if (known.readonly && known.output != NULL) {
		status = fail_with(STATUS_USAGE, "open: output %s is a folder to write to, and readonly writes nothing; leave one of them out", known.output);
		return api_library_end(status);
	}
	gpu_keep(NULL, &kept);
	status = create(&known, world);
	gpu_give(&kept);
	return api_library_end(status);
}

/* --- closing --- */

/* run.json, as the command writes it. */
static enum status write_report(struct furrow_world *host, const char *ended)
{
	host->report.world = host->world;
	host->report.view = host->view;
	host->report.vehicles = host->vehicles;
	host->report.seconds = host->busy;
	char *json = report_json(&host->report, ended);
	if (json == NULL)
		return fail_memory("run.json");
	enum status status = report_write(host->output, json);
	mem_free(json);
	return status;
}

/* Tells whether it went as far as the scene says. */
static bool is_complete(const struct furrow_world *host)
{
	return isfinite(host->scene->end_time) && world_time(host->world) >= host->scene->end_time * (1 - 1e-12);
}

/* A step that failed half-way cannot be committed. The commit that is in flight may have all steps before it. */
static enum status end_torn(struct world *world)
{
	struct resident_pages_io io;
	enum status status = page_cache_await_commit(world_resident(world)->cache);
	if (status != STATUS_OK)
		return status;
	resident_pages_io(world_resident(world)->pages, &io);
	if (io.step >= world_steps_done(world))
		return STATUS_OK;
	return fail_with(STATUS_FAILED, "close: a step failed half-way, and %lld whole steps before it are lost with it; go on from step %lld, which is in the store",
			 (long long)(world_steps_done(world) - io.step), (long long)io.step);
}

static enum status end(struct furrow_world *host)
{
	struct world *world = host->world;
	if (world_is_torn(world))
		return end_torn(world);
	enum status status = world_hosts_commit(world);
	return status == STATUS_OK ? world_end(world, is_complete(host)) : status;
}

static const char *ended(const struct furrow_world *host, enum status status)
{
	return status != STATUS_OK || host->failed || world_is_torn(host->world) ? "failed" : is_complete(host) ? "complete" : "interrupted";
}

furrow_status furrow_world_close(struct furrow_world *world)
{
	struct library_call call;
	if (world == NULL)
		return FURROW_OK;
	enum status status = api_library_enter(&call, world);
	if (status != STATUS_OK) /* without its own context, the world would delete what is in the host's */
		return api_library_leave(&call, status);
	status = end(world);
	world->report.threads = thread_running();
	world_stop(world->world);
	struct failure failure;
	failure_capture(&failure, status);
	if (world->output != NULL) {
		enum status written = write_report(world, ended(world, status));
		if (status == STATUS_OK && written != STATUS_OK) {
			status = written;
			failure_capture(&failure, status);
		}
	}
	destroy(world, status);
	if (status != STATUS_OK)
		status = failure_restore(&failure);
	return api_library_leave(&call, status);
}

/* --- what it is --- */

furrow_status furrow_info(struct furrow_world *world, struct furrow_info *info)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = api_library_need_world(world);
	if (status == STATUS_OK)
		status = api_library_need(info, "info");
	if (status == STATUS_OK)
		status = api_library_need_size(info->size, sizeof info->size, sizeof *info, "info");
	if (status != STATUS_OK)
		return api_library_end(status);
	const struct world *of = world->world;
	const struct resident *resident = world_resident(of);
	const struct store_meta *meta = resident->meta;
	const struct extent *extent = &meta->extent;
	const size_t size = info->size < sizeof *info ? info->size : sizeof *info;
	const struct furrow_info all = {
		.size = info->size,
		.level = resident->level,
		.coarsest = extent_coarsest(extent),
		.cells = extent->cells,
		.spacing = resident->spacing,
		.columns = extent_posts(extent->width, resident->level),
		.rows = extent_posts(extent->height, resident->level),
		.levels = extent_coarsest(extent) - resident->level + 1,
		.extent = {(double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing},
		.low = meta->low,
		.high = meta->high,
		.gravity = world_scene(of)->gravity,
		.time_step = world_scene(of)->time_step,
		.srs = meta->srs,
		.origin = {meta->origin[0], meta->origin[1]},
		.revision = world_revision(of),
	};
	memcpy(info, &all, size);
	return api_library_end(STATUS_OK);
}

furrow_status furrow_stats(struct furrow_world *world, char **json)
{
	struct library_call call;
	enum status status = api_library_enter(&call, world);
	if (json != NULL)
		*json = NULL;
	if (status == STATUS_OK)
		status = api_library_need(json, "json");
	if (status == STATUS_OK) {
		world->report.world = world->world;
		world->report.view = world->view;
		world->report.vehicles = world->vehicles;
		world->report.seconds = world->busy;
		world->report.threads = thread_running();
		*json = report_json(&world->report, "running");
		status = *json != NULL ? STATUS_OK : fail_memory("the statistics");
	}
	return api_library_leave(&call, status);
}
