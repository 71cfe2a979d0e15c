/* The end of a drive: run.json, maps, and notes on how it ended. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "drive/internal.h"

/* --- files --- */

/* Also for a drive that failed or was interrupted, once it began. The drive's own failure is returned before the trace's. */
static enum status publish_trace(const struct drive *drive, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	enum status published = page_trace_publish(world_resident(drive->world)->trace);
	if (published != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return published;
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}

/* Makes the text of run.json. */
static enum status describe(struct drive *drive, struct drive_result *result)
{
	const struct world *world = drive->world;
	const double seconds = drive->report.seconds;
	result->steps = world_steps_done(world);
	result->level = world_resident(world)->level;
	result->spacing = world_resident(world)->spacing;
	result->seconds = seconds;
	result->rtf = seconds > 0 ? (world_time(world) - world_facts(world)->resumed.time) / seconds : 0;
	result->json = drive_describe(drive, result->ended);
	return result->json != NULL ? STATUS_OK : fail_memory("run.json");
}

/* Writes run.json, unless `keep` and it exists. */
static enum status report(struct drive *drive, bool keep, struct drive_result *result)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/run.json", drive->params.directory);
	TRY(describe(drive, result));
	if (!keep || access(path, F_OK) != 0)
		TRY(report_write(drive->params.directory, result->json));
	result->reported = true;
	return STATUS_OK;
}

static bool asks_for_a_map(const struct drive_params *params)
{
	return params->map || params->map_also != NULL;
}

/* Draws the maps that are asked for. `keep`: only those that do not exist. */
static enum status write_maps(const struct drive *drive, const struct world *world, bool keep, struct drive_result *result)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/map.png", drive->params.directory);
	const char *const paths[] = {drive->params.map ? path : NULL, drive->params.map_also};
	bool *const written[] = {&result->map, &result->map_also};
	for (size_t i = 0; i < 2; i++) {
		if (paths[i] == NULL || (keep && access(paths[i], F_OK) == 0))
			continue;
		TRY(report_map(world, drive->vehicles, paths[i], result->ended));
		*written[i] = true;
	}
	return STATUS_OK;
}

/* Draws the maps that are asked for, unless the drive failed in its first step. `keep` is as in write_maps. Returns `status` if that is a failure,
 * otherwise the status of the maps. */
static enum status draw_map(const struct drive *drive, bool keep, struct drive_result *result, enum status status)
{
	struct failure failure;
	const bool empty = status != STATUS_OK && status != STATUS_INTERRUPTED && world_steps_done(drive->world) == 0;
	if (!asks_for_a_map(&drive->params) || empty)
		return status;
	failure_capture(&failure, status);
	enum status drawn = write_maps(drive, drive->world, keep, result);
	if (status == STATUS_OK)
		return drawn;
	if (drawn != STATUS_OK)
		note("%s", failure_message());
	return failure_restore(&failure);
}

/* --- notes --- */

#define DRIVES_STILL 0.25 /* of its commanded speed: from there on nothing holds a vehicle up */

struct slip_text {
	char text[48];
};

static struct slip_text slip_text(double slip)
{
	struct slip_text out = {""};
	if (isfinite(slip))
		snprintf(out.text, sizeof out.text, ", and its wheels slip %.2f", slip);
	return out;
}

/* A drive may end before a vehicle has come to the end of its path. */
static void tell_on_the_way(const struct drive *drive)
{
	for (size_t i = 0; drive->vehicles != NULL && i < drive->scene->vehicle_count; i++) {
		struct vehicle_info info;
		vehicle_info(drive->vehicles, i, &info);
		if (drive->scene->vehicles[i].driver != SCENE_FOLLOW || info.arrived)
			continue;
		if (info.speed >= DRIVES_STILL * drive->scene->vehicles[i].way.speed)
			note("vehicles.%s: is not at the end of its path, but still drives at %.2g m/s: it has come %.4g m, and %.4g m are left; give an end_time of "
			     "%.0f s or more", info.name, info.speed, info.distance, info.left, ceil(world_time(drive->world) + info.left / info.speed + 1));
		else
			note("vehicles.%s: is not at the end of its path: it has come %.4g m%s; drive longer, or look at what holds it up (vehicles.csv)",
			     info.name, info.distance, slip_text(info.slip).text);
	}
}

static void tell_stuck(const struct drive *drive)
{
	for (size_t i = 0; i < vehicle_count(drive->vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(drive->vehicles, i, &info);
		if (info.stuck && info.deepest != NULL)
			note("vehicles.%s: is stuck since %.2f s: it has come %.4g m%s, and %s is deepest in the soil, by %.3g m; look at its rows in objects.csv "
			     "(output.forces)", info.name, fmax(info.stuck_at, 0), info.distance, slip_text(info.slip).text, info.deepest, info.depth);
	}
}

static void tell_note(void *user, const char *text)
{
	(void)user;
	note("%s", text);
}

/* --- the end --- */

static const char *ending(const struct drive *drive, enum status status)
{
	const char *stopped = vehicle_stopped(drive->vehicles);
	if (status == STATUS_OK)
		return stopped != NULL ? stopped : "complete";
	return status == STATUS_INTERRUPTED ? "interrupted" : "failed";
}

/* Tells soil that bodies have aboard at the end. */
static void tell_carried(const struct world *world)
{
	for (size_t i = 0; i < world_body_count(world); i++) {
		const struct world_aboard aboard = world_aboard(world, i);
		if (aboard.units > 0)
			note("%s.%s: has %.4g l of soil aboard, %.4g N; it is not on the ground, and counts as compacted for a drive that does not resume this one",
			     world_body(world, i)->kind == BODY_VEHICLE ? "vehicles" : "objects", world_body(world, i)->object->name, 1e3 * aboard.volume, aboard.weight);
	}
}

static void tell_end(struct drive *drive, const char *ended)
{
	if (drive_writes(drive) && world_carries(drive->world))
		tell_carried(drive->world);
	if (strcmp(ended, "complete") == 0 && drive_writes(drive)) {
		tell_on_the_way(drive);
		report_end_notes(&drive->report, tell_note, NULL);
	}
	if (strcmp(ended, "stuck") == 0 && drive_writes(drive))
		tell_stuck(drive);
}

/* Returns the step of the last commit: of this drive, or of the one that it resumes. */
static int64_t last_committed(const struct world *world)
{
	struct resident_pages_io io;
	resident_pages_io(world_resident(world)->pages, &io);
	return io.commits > 0 ? io.step : world_facts(world)->resumed.is ? world_facts(world)->resumed.from : 0;
}

static enum status write_all(struct drive *drive, bool videos, struct drive_result *result)
{
	TRY(report_cameras(drive->poses));
	if (videos)
		report_videos(drive->poses);
	return report(drive, false, result);
}

enum status drive_conclude(struct drive *drive, struct drive_result *result, enum status status)
{
	if (!drive->unbegun)
		status = publish_trace(drive, status);
	drive_stop(drive);
	if (drive->unbegun)
		return status;
	result->ended = ending(drive, status);
	drive_fill_report(drive);
	tell_end(drive, result->ended);
	struct failure failure;
	failure_capture(&failure, status);
	if (drive->params.ranks != NULL) { /* drive_conclude_ranks() writes it */
		const enum status made = describe(drive, result);
		return status == STATUS_OK ? made : failure_restore(&failure);
	}
	result->committed = last_committed(drive->world);
	const enum status written = write_all(drive, status == STATUS_OK, result);
	bool tell_written = written != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED);
	if (!tell_written && status != STATUS_OK)
		status = failure_restore(&failure);
	return draw_map(drive, false, result, tell_written ? written : status);
}

enum status drive_conclude_again(struct drive *drive, struct drive_result *result)
{
	result->ended = "complete";
	if (drive->params.trace != NULL)
		note("%s: no trace is written, since nothing is left to drive", drive->params.trace);
	if (!drive_writes(drive))
		return STATUS_OK;
	TRY(drive_folder_make(drive->params.directory));
	return draw_map(drive, true, result, report(drive, true, result));
}

/* Draws the map from the run's overlay, after what the ranks committed was gathered into it. */
static enum status map_gathered(const struct drive *drive, int64_t step, double time, struct drive_result *result)
{
	struct world *world = NULL;
	enum status status;
	TRY_OR(done, world_open_ended(drive->scene, drive->params.ranks->over, step, time, &world));
	TRY_OR(done, write_maps(drive, world, false, result));
done:
	world_finish(world, STATUS_OK);
	return status;
}

/* The first rank's: run.json and the maps of the drive that all made together. */
static enum status write_ranked(const struct drive *drive, int64_t step, double time, const struct world_ranked *ranked, struct drive_result *result)
{
	TRY(report_gathered(&result->json, ranked, drive->params.ranks->ranks));
	TRY(report_write(drive->params.directory, result->json));
	result->reported = true;
	return asks_for_a_map(&drive->params) ? map_gathered(drive, step, time, result) : STATUS_OK;
}

enum status drive_conclude_ranks(const struct drive *drive, int64_t step, double time, struct drive_result *result, enum status status)
{
	const struct world_ranks *ranks = drive->params.ranks;
	struct world_ranked ranked;
	struct failure failure;
	failure_capture(&failure, status);
	enum status gathered = ranks->gather(ranks->user, &ranked);
	if (gathered == STATUS_OK && drive_writes(drive) && result->json != NULL)
		gathered = write_ranked(drive, step, time, &ranked, result);
	if (status == STATUS_OK || (status == STATUS_INTERRUPTED && gathered != STATUS_OK))
		return gathered;
	return failure_restore(&failure);
}

void drive_remove_made(const struct drive *drive)
{
	static const char *const endings[] = {"", "-wal", "-shm"};
	char path[4096];
	if (drive->new_folder)
		drive_folder_remove(drive->params.directory);
	for (size_t i = 0; drive->new_overlay && i < sizeof endings / sizeof *endings; i++)
		if (snprintf(path, sizeof path, "%s%s", drive->params.overlay, endings[i]) < (int)sizeof path)
			(void)unlink(path);
}
