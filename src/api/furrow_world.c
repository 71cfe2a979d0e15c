/* furrow.h: a world is opened, closed, and tells what it is. */
#include "api/library.h"

#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

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

#define SETTINGS_MOST 64
#define OPEN_FIRST offsetof(struct furrow_open, reserved) /* bytes of the first version, which ended with unused bytes behind its last flag */

/* Takes the lines of `text` apart, which it changes. STATUS_USAGE: one is not KEY=VALUE. */
static enum status take_settings(char *text, struct scene_setting *list, size_t *count)
{
	*count = 0;
	for (char *line = text, *next; *line != '\0'; line = next) {
		next = line + strcspn(line, "\n");
		if (*next != '\0')
			*next++ = '\0';
		char *equals = strchr(line, '=');
		if (equals == NULL || equals == line)
			return fail_with(STATUS_USAGE, "settings: %s: not KEY=VALUE; give one a line, as in cache.slots=16", line);
		if (*count == SETTINGS_MOST)
			return fail_with(STATUS_USAGE, "settings: are too many; give at most %d", SETTINGS_MOST);
		*equals = '\0';
		list[(*count)++] = (struct scene_setting){line, equals + 1};
	}
	return STATUS_OK;
}

static enum status load_scene(const struct furrow_open *open, struct scene **out)
{
	struct scene_setting list[SETTINGS_MOST];
	size_t count = 0;
	if ((open->scene != NULL) == (open->scene_file != NULL))
		return fail_with(STATUS_USAGE, "open: scene and scene_file are both given, or neither; give one of them");
	char *settings = mem_strdup(open->settings != NULL ? open->settings : "");
	TRY_MEM(settings, "settings");
	enum status status;
	TRY_OR(done, take_settings(settings, list, &count));
	TRY_OR(done, open->scene != NULL ? scene_load_text(open->scene, NULL, list, count, SCENE_HOST, out)
					 : scene_load_file(open->scene_file, list, count, SCENE_HOST, out));
done:
	mem_free(settings);
	return status;
}

static enum status open_drive(struct furrow_world *host, const struct furrow_open *open)
{
	const struct drive_params params = {
		.scene = host->scene,
		.store = open->store,
		.overlay = open->overlay,
		.directory = host->output,
		.hosted = true,
		.advise = open->advise,
		.resume = open->resume,
		.durable_full = open->durable,
		.keep_history = open->keep_history,
		.readonly = open->readonly,
	};
	TRY(drive_open(&params, &host->drive));
	host->world = drive_world(host->drive);
	host->vehicles = drive_vehicles(host->drive);
	return STATUS_OK;
}

static void destroy(struct furrow_world *host, enum status status)
{
	api_library_let_go_soils(host);
	drive_finish(host->drive, status);
	scene_destroy(host->scene);
	mem_free(host->output);
	mem_free(host);
}

static enum status start(struct furrow_world *host, const struct furrow_open *open)
{
	TRY(load_scene(open, &host->scene));
	if (open->output != NULL) {
		host->output = mem_strdup(open->output);
		TRY_MEM(host->output, "a world");
	}
	TRY(open_drive(host, open));
	TRY(need_own_gl());
	TRY(drive_start(host->drive));
	TRY(drive_begin(host->drive));
	const struct world *world = host->world;
	const bool whole = world_time(world) == world_step_time(world_scene(world), world_steps_done(world)); /* steps from the scene's start */
	host->origin = whole ? 0 : world_time(world);
	host->steps = whole ? world_steps_done(world) : 0;
	return api_library_checkpoint(host);
}

static enum status create(const struct furrow_open *open, struct furrow_world **out)
{
	struct furrow_world *host = mem_calloc(1, sizeof *host);
	TRY_MEM(host, "a world");
	enum status status;
	TRY_OR(failed, start(host, open));
	host->process = getpid();
	*out = host;
	return STATUS_OK;
failed:;
	struct failure failure;
	failure_capture(&failure, status);
	destroy(host, status);
	return failure_restore(&failure);
}

/* Copies what this version knows of the host's struct. */
static enum status take_open(const struct furrow_open *open, struct furrow_open *known)
{
	TRY(api_library_need_size(open->size, OPEN_FIRST, sizeof *open, "open"));
	*known = (struct furrow_open){.size = 0};
	/* What the first version has behind its last flag was never set. */
	memcpy(known, open, open->size == OPEN_FIRST ? offsetof(struct furrow_open, readonly) : sizeof *known < open->size ? sizeof *known : open->size);
	if (known->readonly && known->output != NULL)
		return fail_with(STATUS_USAGE, "open: output %s is a folder to write to, and readonly writes nothing; leave one of them out", known->output);
	return STATUS_OK;
}

static enum status open_world(const struct furrow_open *open, struct furrow_world **world)
{
	struct gpu_kept kept;
	struct furrow_open known;
	TRY(open == NULL ? api_library_need(open, "open") : api_library_need(world, "world"));
	TRY(take_open(open, &known));
	gpu_keep(NULL, &kept);
	const enum status status = create(&known, world);
	gpu_give(&kept);
	return status;
}

furrow_status furrow_world_open(const struct furrow_open *open, struct furrow_world **world)
{
	enum status status;
	if (world != NULL)
		*world = NULL;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, open_world(open, world));
done:
	return api_library_end(status);
}

/* --- closing --- */

/* Makes the text of run.json, as the command writes it. `what`: its name in a message. */
static enum status describe(struct furrow_world *host, const char *ended, const char *what, char **json)
{
	drive_report(host->drive)->seconds = host->busy;
	*json = drive_describe(host->drive, ended);
	return *json != NULL ? STATUS_OK : fail_memory(what);
}

static enum status write_report(struct furrow_world *host, const char *ended)
{
	char *json;
	TRY(describe(host, ended, "run.json", &json));
	const enum status status = report_write(host->output, json);
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
	TRY(page_cache_await_commit(world_resident(world)->cache));
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
	TRY(world_hosts_commit(world));
	TRY(world_lay_down(world));
	return drive_end(host->drive, is_complete(host));
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
	const char *how = ended(world, status); /* a world that is stopped does not tell whether it was torn */
	drive_stop(world->drive);
	struct failure failure;
	failure_capture(&failure, status);
	if (world->output != NULL) {
		enum status written = write_report(world, how);
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

static enum status get_info(struct furrow_world *world, struct furrow_info *info)
{
	TRY(api_library_need_world(world));
	TRY(api_library_need(info, "info"));
	TRY(api_library_need_size(info->size, sizeof info->size, sizeof *info, "info"));
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
	return STATUS_OK;
}

furrow_status furrow_info(struct furrow_world *world, struct furrow_info *info)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, get_info(world, info));
done:
	return api_library_end(status);
}

furrow_status furrow_stats(struct furrow_world *world, char **json)
{
	struct library_call call;
	enum status status;
	if (json != NULL)
		*json = NULL;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, api_library_need(json, "json"));
	drive_report(world->drive)->threads = thread_running();
	TRY_OR(done, describe(world, "running", "the statistics", json));
done:
	return api_library_leave(&call, status);
}
