/*
 * Writes a folder of tiles.
 *
 * Threads take units of work, up to 16 neighbouring tiles each, in the order of the zoom levels.
 *
 *  1. A map zoom level begins when the finer one is complete, since ruts are made of finer ones.
 *  2. A unit is in the journal after all its files are in place.
 *  3. The stamp is written when all tiles and the page are in place; only then the journal is removed.
 */
#include "exchange/internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

struct work {
	const struct exchange_tiles_params *params;
	struct exchange_tiles_result *result;
	struct exchange_frame frame;
	struct exchange_zooms zooms;
	struct exchange_stamp stamp;
	struct exchange_journal journal;
	struct exchange_steps *steps;
	struct store_reader *reader;

	struct mutex mutex;
	struct condition changed;
	/* from here on under the mutex while threads run */
	size_t zoom;          /* whose units are given out */
	int64_t next, first;  /* its next unit; the number of its first unit in the journal */
	int running;          /* units that are being made */
	int64_t done, total;  /* tiles */
	int threads;          /* that have not ended */
	bool stop;
	struct failure failure;
};

/* --- units --- */

static int64_t tile_count(const struct exchange_zoom *zoom)
{
	return zoom->order != NULL ? (int64_t)zoom->count : (zoom->x1 - zoom->x0) * (zoom->y1 - zoom->y0);
}

/* Gives out the next unit that is not done. Returns false if there is none. */
static bool take_unit(struct work *all, const struct exchange_zoom **zoom, int64_t *unit, int64_t *number)
{
	bool found = false;
	mutex_lock(&all->mutex);
	while (!found && !all->stop && all->zoom < all->zooms.count) {
		*zoom = &all->zooms.zooms[all->zoom];
		if (all->next < (*zoom)->units) {
			*unit = all->next++;
			*number = all->first + *unit;
			found = !all->journal.done[*number];
			struct tile tiles[EXCHANGE_UNIT];
			all->done += found ? 0 : (int64_t)exchange_zoom_unit(*zoom, *unit, tiles);
		} else if ((*zoom)->globe || all->running == 0) {
			all->first += (*zoom)->units;
			all->next = 0;
			all->zoom++;
		} else {
			condition_wait(&all->changed, &all->mutex);
		}
	}
	all->running += found;
	mutex_unlock(&all->mutex);
	return found;
}

static void end_unit(struct work *all, int64_t number, size_t tiles, enum status status)
{
	mutex_lock(&all->mutex);
	if (status == STATUS_OK)
		status = exchange_journal_add(&all->journal, number);
	if (status != STATUS_OK && !all->stop) {
		failure_capture(&all->failure, status);
		all->stop = true;
	}
	all->running--;
	all->done += (int64_t)tiles;
	condition_wake_all(&all->changed);
	mutex_unlock(&all->mutex);
}

static enum status make_unit(struct exchange_maker *maker, const struct exchange_zoom *zoom, int64_t unit, size_t *count)
{
	struct tile tiles[EXCHANGE_UNIT];
	enum status status = STATUS_OK;
	*count = exchange_zoom_unit(zoom, unit, tiles);
	for (size_t i = 0; i < *count && status == STATUS_OK; i++)
		status = zoom->globe ? exchange_mesh_tile(maker, zoom, tiles[i]) : exchange_map_tile(maker, zoom, tiles[i]);
	return status;
}

static void *make_tiles(void *argument)
{
	struct work *all = argument;
	struct exchange_maker maker;
	dem_quiet_begin();
	enum status status = exchange_maker_init(&maker, all->params, &all->zooms, all->steps, all->stamp.range);
	const struct exchange_zoom *zoom;
	int64_t unit, number;
	while (status == STATUS_OK && take_unit(all, &zoom, &unit, &number)) {
		size_t tiles;
		status = make_unit(&maker, zoom, unit, &tiles);
		end_unit(all, number, tiles, status);
		status = STATUS_OK; /* if it failed, take_unit has no more */
	}
	dem_quiet_end();
	mutex_lock(&all->mutex);
	if (status != STATUS_OK && !all->stop) {
		failure_capture(&all->failure, status);
		all->stop = true;
	}
	for (int set = 0; set < EXCHANGE_SETS && status == STATUS_OK; set++) {
		all->result->made[set] += maker.made[set];
		all->result->written[set] += maker.written[set];
	}
	all->result->removed += status == STATUS_OK ? maker.removed : 0;
	all->threads--;
	condition_wake_all(&all->changed);
	mutex_unlock(&all->mutex);
	if (status == STATUS_OK)
		exchange_maker_finish(&maker);
	return NULL;
}

static enum status run_threads(struct work *all)
{
	enum { MOST = 64 };
	struct thread threads[MOST];
	int64_t wanted = all->params->jobs > 0 ? all->params->jobs : thread_cores();
	int count = (int)(wanted < MOST ? wanted : MOST), started = 0;
	enum status status = STATUS_OK;
	for (; started < count && status == STATUS_OK; started++) {
		threads[started].started = false;
		mutex_lock(&all->mutex);
		all->threads++;
		mutex_unlock(&all->mutex);
		status = thread_start(&threads[started], make_tiles, all, "furrow-tiles");
	}
	mutex_lock(&all->mutex);
	if (status != STATUS_OK) {
		all->threads--;
		all->stop = true;
	}
	while (all->threads > 0) {
		condition_wait_for(&all->changed, &all->mutex, 0.1);
		int64_t done = all->done;
		if (status != STATUS_OK || all->stop || all->params->progress == NULL)
			continue;
		mutex_unlock(&all->mutex);
		status = all->params->progress(all->params->progress_user, done, all->total);
		mutex_lock(&all->mutex);
		all->stop = all->stop || status != STATUS_OK;
	}
	mutex_unlock(&all->mutex);
	for (int i = 0; i < started; i++)
		thread_join(&threads[i]);
	all->result->threads = started;
	if (status == STATUS_OK && all->failure.status != STATUS_OK)
		status = failure_restore(&all->failure);
	return status;
}

/* --- before and after --- */

static enum status check_heights(const struct store_meta *meta)
{
	const double deepest = -9990, highest = 1667700;
	if (meta->low < deepest || meta->high > highest)
		return fail_with(STATUS_INPUT, "heights from %g to %g m: terrain-RGB holds %g to %g m; write a .tif", meta->low, meta->high,
				 deepest, highest);
	return STATUS_OK;
}

/* A folder that has something else is not touched. */
static enum status check_folder(const char *directory)
{
	DIR *folder = opendir(directory);
	if (folder == NULL)
		return errno == ENOENT ? STATUS_OK
				       : fail_with(STATUS_INPUT, "%s: cannot be used: %s; give a folder, or one that is not there", directory,
						   strerror(errno));
	bool empty = true, ours = false;
	for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
		bool dots = strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
		empty = empty && dots;
		ours = ours || strncmp(entry->d_name, "furrow-tiles.", 13) == 0;
	}
	closedir(folder);
	return empty || ours ? STATUS_OK
			     : fail_with(STATUS_INPUT, "%s: holds something else than tiles; give a folder that is empty or not there", directory);
}

/* The ends of the colours: those asked for, the folder's, or round numbers beyond all offsets. */
static enum status choose_range(struct work *all, const struct exchange_stamp *old, bool has_old)
{
	const struct exchange_tiles_params *params = all->params;
	double *range = all->stamp.range, low, high;
	const struct extent *extent = &all->frame.meta->extent;
	bool found = false;
	range[0] = params->has_range ? params->range[0] : old->range[0];
	range[1] = params->has_range ? params->range[1] : old->range[1];
	if (params->has_range || (has_old && params->since >= 0))
		return STATUS_OK;
	enum status status = STATUS_OK;
	if (all->zooms.deformed)
		status = store_read_offset_range(all->reader, (struct tile){extent_coarsest(extent), 0, 0}, &low, &high, &found);
	range[0] = -(found && low < 0 ? chart_round_range(-low) : 0.1);
	range[1] = found && high > 0 ? chart_round_range(high) : 0.1;
	return status;
}

static enum status check_stamp(struct work *all, const struct exchange_stamp *old, bool found)
{
	const char *directory = all->params->directory;
	long long since = (long long)all->params->since;
	if (found && strcmp(old->terrain, all->stamp.terrain) != 0)
		return fail_with(STATUS_INPUT, "%s: holds tiles of another terrain; give another folder, or remove it", directory);
	if (all->params->since < 0)
		return STATUS_OK;
	if (!found)
		return fail_with(STATUS_INPUT, "%s: has no complete tiles, and --since would write a part of them; leave --since out", directory);
	if (old->revision < all->params->since)
		return fail_with(STATUS_INPUT, "%s: its tiles are of revision %lld, and --since %lld would leave out what changed between; give "
				 "--since %lld", directory, (long long)old->revision, since, (long long)old->revision);
	if (old->look != all->stamp.look)
		return fail_with(STATUS_INPUT, "%s: its tiles have another sun, exaggeration or range of colours; give the same, or leave --since "
				 "out", directory);
	return STATUS_OK;
}

static uint64_t look_of(const struct exchange_tiles_params *params, const double range[2])
{
	double look[3 + 3 * CHART_SUNS] = {range[0], range[1], params->exaggerate};
	for (int i = 0; i < 3 * CHART_SUNS; i++)
		look[3 + i] = params->sun.toward[i / 3][i % 3];
	return XXH3_64bits(look, sizeof look);
}

static enum status begin(struct work *all)
{
	const struct exchange_tiles_params *params = all->params;
	struct exchange_stamp old;
	bool found = false;
	char request[256];
	int64_t units = 0;
	enum status status = exchange_stamp_read(params->directory, &old, &found);
	snprintf(all->stamp.terrain, sizeof all->stamp.terrain, "%016llx", (unsigned long long)store_base_hash(params->store));
	if (status == STATUS_OK)
		status = choose_range(all, &old, found);
	if (status != STATUS_OK)
		return status;
	all->stamp.look = look_of(params, all->stamp.range);
	all->stamp.revision = all->zooms.revision;
	status = check_stamp(all, &old, found);
	if (status != STATUS_OK)
		return status;
	for (size_t k = 0; k < all->zooms.count; k++) {
		units += all->zooms.zooms[k].units;
		all->total += tile_count(&all->zooms.zooms[k]);
	}
	snprintf(request, sizeof request, "furrow tiles 1, terrain %s, revision %lld, since %lld, look %016llx, units %lld", all->stamp.terrain,
		 (long long)all->stamp.revision, (long long)params->since, (unsigned long long)all->stamp.look, (long long)units);
	status = exchange_journal_begin(&all->journal, params->directory, request, units);
	/* While tiles of another look are written, the folder is not one that --since could go on with. */
	if (status == STATUS_OK && found && old.look != all->stamp.look)
		status = exchange_stamp_remove(params->directory);
	all->result->kept = all->journal.kept;
	return status;
}

struct tidying {
	struct work *all;
	enum exchange_set set;
};

/* Removes a file whose tile is no more: its zoom level or the deformation under it is gone. */
static enum status tidy_tile(void *user, struct tile tile)
{
	const struct tidying *tidying = user;
	const struct exchange_zooms *zooms = &tidying->all->zooms;
	for (size_t k = 0; k < zooms->count; k++) {
		const struct exchange_zoom *zoom = &zooms->zooms[k];
		if (zoom->z == tile.level && zoom->globe == (tidying->set == EXCHANGE_MESH) && exchange_zoom_has(zoom, tile.x, tile.y))
			return STATUS_OK;
	}
	char path[EXCHANGE_PATH];
	bool removed;
	enum status status = exchange_tile_path(tidying->all->params->directory, tidying->set, tile, path);
	if (status == STATUS_OK)
		status = exchange_file_remove(path, &removed);
	tidying->all->result->removed += status == STATUS_OK && removed;
	return status;
}

static enum status tidy(struct work *all)
{
	enum status status = STATUS_OK;
	for (int set = 0; set < EXCHANGE_SETS && status == STATUS_OK; set++) {
		struct tidying tidying = {all, (enum exchange_set)set};
		status = exchange_folder_each(all->params->directory, (enum exchange_set)set, tidy_tile, &tidying);
	}
	return status;
}

static void tell(struct work *all)
{
	struct exchange_tiles_result *result = all->result;
	result->revision = all->zooms.revision;
	result->local = all->frame.globe == NULL;
	result->earth = all->frame.earth;
	if (!result->local)
		snprintf(result->system, sizeof result->system, "%s", dem_globe_info(all->frame.globe)->name);
	for (int i = 0; i < 2; i++) {
		result->zoom[i] = all->zooms.map[i];
		result->mesh_zoom[i] = all->zooms.mesh[i];
		result->range[i] = all->stamp.range[i];
	}
}

enum status exchange_tiles(const struct exchange_tiles_params *params, struct exchange_tiles_result *result)
{
	struct work all = {.params = params, .result = result};
	const struct store_meta *meta = store_meta(params->store);
	double started = clock_seconds();
	*result = (struct exchange_tiles_result){.revision = 0};
	mutex_init(&all.mutex);
	condition_init(&all.changed);
	dem_quiet_begin();
	enum status status = exchange_page_check(params);
	if (status == STATUS_OK)
		status = check_heights(meta);
	if (status == STATUS_OK)
		status = check_folder(params->directory);
	if (status == STATUS_OK)
		status = exchange_file_folder(params->directory);
	if (status == STATUS_OK)
		status = store_reader_create(params->store, &all.reader);
	if (status == STATUS_OK)
		status = exchange_frame_init(&all.frame, meta);
	if (status == STATUS_OK)
		status = exchange_zooms_init(&all.zooms, &all.frame, all.reader, params->store, params->since);
	if (status == STATUS_OK)
		status = exchange_steps_create(&all.steps);
	if (status == STATUS_OK)
		status = begin(&all);
	if (status == STATUS_OK)
		tell(&all);
	if (status == STATUS_OK)
		status = run_threads(&all);
	if (status == STATUS_OK)
		status = tidy(&all);
	if (status == STATUS_OK)
		status = exchange_page_write(params, &all.frame, &all.zooms, result);
	if (status == STATUS_OK)
		status = exchange_stamp_write(params->directory, &all.stamp);
	if (status == STATUS_OK)
		status = exchange_journal_end(&all.journal);
	result->seconds = clock_seconds() - started;
	exchange_journal_finish(&all.journal);
	exchange_steps_destroy(all.steps);
	exchange_zooms_finish(&all.zooms);
	exchange_frame_finish(&all.frame);
	store_reader_destroy(all.reader);
	dem_quiet_end();
	condition_finish(&all.changed);
	mutex_finish(&all.mutex);
	return status;
}
