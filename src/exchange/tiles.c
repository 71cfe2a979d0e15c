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
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

struct work {
	const struct exchange_tiles_params *params;
	struct exchange_tiles_result *result;
	struct exchange_frame frame;
	struct exchange_cover cover;
	struct exchange_zooms zooms;
	struct exchange_stamp stamp;
	struct exchange_journal journal;
	struct exchange_steps *steps;
	struct store_reader *reader;
	struct exchange_mbtiles *file; /* the tiles of `only`; NULL: all, in a folder */
	enum exchange_set only;

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

/* Keeps the first failure of all threads, and stops them. Under the mutex. */
static void fail_locked(struct work *all, enum status status)
{
	if (status == STATUS_OK || all->stop)
		return;
	failure_capture(&all->failure, status);
	all->stop = true;
}

static void end_unit(struct work *all, int64_t number, size_t tiles, enum status status)
{
	mutex_lock(&all->mutex);
	if (status == STATUS_OK && all->file == NULL)
		status = exchange_journal_add(&all->journal, number);
	fail_locked(all, status);
	all->running--;
	all->done += (int64_t)tiles;
	condition_wake_all(&all->changed);
	mutex_unlock(&all->mutex);
}

static enum status make_unit(struct exchange_maker *maker, const struct exchange_zoom *zoom, int64_t unit, size_t *count)
{
	struct tile tiles[EXCHANGE_UNIT];
	*count = exchange_zoom_unit(zoom, unit, tiles);
	for (size_t i = 0; i < *count; i++)
		TRY(zoom->globe ? exchange_mesh_tile(maker, zoom, tiles[i]) : exchange_map_tile(maker, zoom, tiles[i]));
	return STATUS_OK;
}

/* Makes units until there are none, and adds up what was made. */
static enum status make_units(struct work *all)
{
	struct exchange_maker maker;
	TRY(exchange_maker_init(&maker, all->params, &all->zooms, all->steps, all->stamp.range));
	maker.cover = &all->cover;
	maker.file = all->file;
	maker.only = all->only;
	const struct exchange_zoom *zoom;
	int64_t unit, number;
	while (take_unit(all, &zoom, &unit, &number)) {
		size_t tiles;
		enum status status = make_unit(&maker, zoom, unit, &tiles);
		end_unit(all, number, tiles, status); /* if it failed, take_unit has no more */
	}
	mutex_lock(&all->mutex);
	for (int set = 0; set < EXCHANGE_SETS; set++) {
		all->result->made[set] += maker.made[set];
		all->result->written[set] += maker.written[set];
	}
	all->result->removed += maker.removed;
	mutex_unlock(&all->mutex);
	exchange_maker_finish(&maker);
	return STATUS_OK;
}

static void *make_tiles(void *argument)
{
	struct work *all = argument;
	dem_quiet_begin();
	enum status status = make_units(all);
	dem_quiet_end();
	mutex_lock(&all->mutex);
	fail_locked(all, status);
	all->threads--;
	condition_wake_all(&all->changed);
	mutex_unlock(&all->mutex);
	return NULL;
}

/* Waits until all threads have ended, and tells the progress. `status`: a failure stops them. Returns it, or that of the progress. */
static enum status wait_for_threads(struct work *all, enum status status)
{
	mutex_lock(&all->mutex);
	all->stop = all->stop || status != STATUS_OK;
	while (all->threads > 0) {
		condition_wait_for(&all->changed, &all->mutex, 0.1);
		int64_t done = all->done;
		if (all->stop || all->params->progress == NULL)
			continue;
		mutex_unlock(&all->mutex);
		status = all->params->progress(all->params->progress_user, done, all->total);
		mutex_lock(&all->mutex);
		all->stop = all->stop || status != STATUS_OK;
	}
	mutex_unlock(&all->mutex);
	return status;
}

static enum status start_thread(struct work *all, struct thread *thread)
{
	mutex_lock(&all->mutex);
	all->threads++;
	mutex_unlock(&all->mutex);
	enum status status = thread_start(thread, make_tiles, all, "furrow-tiles");
	mutex_lock(&all->mutex);
	all->threads -= status != STATUS_OK;
	mutex_unlock(&all->mutex);
	return status;
}

static enum status run_threads(struct work *all)
{
	enum { MOST = 64 };
	struct thread threads[MOST];
	int64_t wanted = all->params->jobs > 0 ? all->params->jobs : thread_cores();
	int count = (int)(wanted < MOST ? wanted : MOST), started = 0;
	enum status status = STATUS_OK;
	for (; started < count; started++)
		TRY_OR(wait, start_thread(all, &threads[started]));
wait:
	status = wait_for_threads(all, status);
	for (int i = 0; i < started; i++)
		thread_join(&threads[i]);
	all->result->threads = started;
	TRY(status);
	return all->failure.status != STATUS_OK ? failure_restore(&all->failure) : STATUS_OK;
}

/* --- before and after --- */

static enum status check_heights(const struct exchange_tiles_params *params, const struct store_meta *meta)
{
	const struct exchange_coding coding = exchange_coding_of(params, meta);
	const double highest = coding.zero + EXCHANGE_CODE_MOST / coding.parts, spare = 256; /* heaps may rise above the base */
	if (params->step > 0 && meta->high + spare > highest)
		return fail_with(STATUS_INPUT, "export: --height-step %g: heights from %g to %g m need more steps than a tile has; give at least %s", params->step, meta->low,
				 meta->high, number_at_least((meta->high + spare - coding.zero) / EXCHANGE_CODE_MOST, 3).text);
	if (meta->high > highest)
		return fail_with(STATUS_INPUT, "heights from %g to %g m: tiles of this encoding hold at most %g m; write a .tif", meta->low, meta->high, highest);
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
	if (all->zooms.deformed)
		TRY(store_read_offset_range(all->reader, (struct tile){extent_coarsest(extent), 0, 0}, &low, &high, &found));
	range[0] = -(found && low < 0 ? chart_round_range(-low) : 0.1);
	range[1] = found && high > 0 ? chart_round_range(high) : 0.1;
	for (int i = 0; i < 2; i++) { /* as JSON gives it back: the next export compares looks */
		char text[32];
		snprintf(text, sizeof text, "%.6g", range[i]);
		range[i] = strtod(text, NULL);
	}
	return STATUS_OK;
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
		return fail_with(STATUS_INPUT, "%s: its tiles have another sun, exaggeration, encoding, size, window or range of colours; give the same, or leave --since "
				 "out", directory);
	if (old->resets != all->stamp.resets || (old->version[0] != '\0' && old->revision == all->stamp.revision && strcmp(old->version, all->result->version) != 0))
		return fail_with(STATUS_INPUT, "%s: its tiles are of another drive: the store was reset since; leave --since out", directory);
	return STATUS_OK;
}

static uint64_t look_of(const struct exchange_tiles_params *params, const double range[2])
{
	double look[3 + 3 * CHART_SUNS] = {range[0], range[1], params->terrarium ? -params->exaggerate : params->exaggerate};
	for (int i = 0; i < 3 * CHART_SUNS; i++)
		look[3 + i] = params->sun.toward[i / 3][i % 3];
	/* Other imagery, other tiles; without imagery, folders of earlier versions have this hash. */
	const uint64_t hash = XXH3_64bits(look, sizeof look) ^ store_imagery_hash(params->store);
	/* Folders of earlier versions have a hash without these. */
	if (params->step == 0 && params->pixels <= 256 && !params->fine_globe && !params->gzip && !params->has_window)
		return hash;
	double more[11] = {params->step, (double)params->pixels, params->fine_globe + 2 * params->gzip};
	for (int i = 0; i < 4; i++) {
		more[3 + i] = params->has_window ? params->window[i] : 0;
		more[7 + i] = params->has_clip ? params->clip[i] : 0;
	}
	return XXH3_64bits_withSeed(more, sizeof more, hash);
}

/* After a reset revisions begin anew, so the version also has a hash of the look and of the last run. */
static enum status find_version(struct work *all)
{
	struct store_run run;
	TRY(store_last_run(all->params->store, &run));
	uint64_t hash = all->stamp.look + (uint64_t)all->stamp.resets;
	if (run.scene_hash != NULL)
		hash = XXH3_64bits_withSeed(run.scene_hash, strlen(run.scene_hash), hash);
	if (run.scene_hash != NULL && run.state != NULL)
		hash = XXH3_64bits_withSeed(run.state, strlen(run.state), hash);
	snprintf(all->result->version, sizeof all->result->version, "%lld-%08x", (long long)all->zooms.revision, (unsigned)hash);
	return STATUS_OK;
}

/* Counts units and tiles. Returns the units. */
static int64_t count_units(struct work *all)
{
	int64_t units = 0;
	for (size_t k = 0; k < all->zooms.count; k++) {
		units += all->zooms.zooms[k].units;
		all->total += tile_count(&all->zooms.zooms[k]);
	}
	return units;
}

static enum status begin(struct work *all)
{
	const struct exchange_tiles_params *params = all->params;
	struct exchange_stamp old;
	bool found = false;
	char request[256];
	TRY(exchange_stamp_read(params->directory, &old, &found));
	snprintf(all->stamp.terrain, sizeof all->stamp.terrain, "%016llx", (unsigned long long)store_base_hash(params->store));
	TRY(choose_range(all, &old, found));
	all->stamp.look = look_of(params, all->stamp.range);
	all->stamp.revision = all->zooms.revision;
	TRY(store_resets(params->store, &all->stamp.resets));
	TRY(find_version(all));
	TRY(check_stamp(all, &old, found));
	snprintf(all->stamp.version, sizeof all->stamp.version, "%s", all->result->version);
	const int64_t units = count_units(all);
	snprintf(request, sizeof request, "furrow tiles 1, terrain %s, revision %lld, since %lld, look %016llx, units %lld", all->stamp.terrain,
		 (long long)all->stamp.revision, (long long)params->since, (unsigned long long)all->stamp.look, (long long)units);
	TRY(exchange_journal_begin(&all->journal, params->directory, request, units));
	all->result->kept = all->journal.kept;
	/* While tiles of another look are written, the folder is not one that --since could go on with. */
	return found && old.look != all->stamp.look ? exchange_stamp_remove(params->directory) : STATUS_OK;
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
	for (size_t k = 0; k < zooms->count && (tidying->set != EXCHANGE_IMAGERY || zooms->imagery >= 0); k++) {
		const struct exchange_zoom *zoom = &zooms->zooms[k];
		if (zoom->z == tile.level && zoom->globe == (tidying->set == EXCHANGE_MESH) && (!zoom->imagery || tidying->set == EXCHANGE_IMAGERY) && exchange_zoom_has(zoom, tile.x, tile.y))
			return STATUS_OK;
	}
	char path[EXCHANGE_PATH];
	bool removed;
	TRY(exchange_tile_path(tidying->all->params->directory, tidying->set, tile, path));
	TRY(exchange_file_remove(path, &removed));
	tidying->all->result->removed += removed;
	return STATUS_OK;
}

static enum status tidy(struct work *all)
{
	for (int set = 0; set < EXCHANGE_SETS; set++) {
		struct tidying tidying = {all, (enum exchange_set)set};
		TRY(exchange_folder_each(all->params->directory, (enum exchange_set)set, tidy_tile, &tidying));
	}
	return STATUS_OK;
}

static void tell(struct work *all)
{
	struct exchange_tiles_result *result = all->result;
	result->revision = all->zooms.revision;
	result->imagery_zoom = all->zooms.imagery;
	result->local = all->frame.globe == NULL;
	result->earth = all->frame.earth;
	result->coding_zero = exchange_coding_of(all->params, all->frame.meta).zero;
	if (!result->local && strncmp(dem_globe_info(all->frame.globe)->name, "unknown", 7) != 0)
		snprintf(result->system, sizeof result->system, "%s", dem_globe_info(all->frame.globe)->name);
	else if (!result->local)
		snprintf(result->system, sizeof result->system, "a body of %.10g m radius", all->frame.semi_major);
	result->finer_left_out = all->frame.whole_only && all->zooms.finest < 0;
	for (int i = 0; i < 2; i++) {
		result->zoom[i] = all->zooms.map[i];
		result->mesh_zoom[i] = all->zooms.mesh[i];
		result->range[i] = all->stamp.range[i];
	}
	for (size_t k = 0; k < all->zooms.count; k++)
		if (all->zooms.zooms[k].globe && !all->zooms.zooms[k].sparse) { /* the finest of these comes first */
			const struct exchange_zoom *zoom = &all->zooms.zooms[k];
			exchange_place_steps(&all->frame, zoom, (double)(zoom->y0 + zoom->y1) / 2 * EXCHANGE_CELLS, &result->mesh_step[0], &result->mesh_step[1]);
			break;
		}
}

static void start(struct work *all)
{
	*all->result = (struct exchange_tiles_result){.revision = 0};
	all->result->seconds = clock_seconds();
	mutex_init(&all->mutex);
	condition_init(&all->changed);
	dem_quiet_begin();
}

/* Lets go of all but what was written. Returns `status`. */
static enum status finish(struct work *all, enum status status)
{
	all->result->seconds = clock_seconds() - all->result->seconds;
	exchange_journal_finish(&all->journal);
	exchange_mbtiles_destroy(all->file);
	exchange_steps_destroy(all->steps);
	exchange_zooms_finish(&all->zooms);
	exchange_cover_finish(&all->cover);
	exchange_frame_finish(&all->frame);
	store_reader_destroy(all->reader);
	dem_quiet_end();
	condition_finish(&all->changed);
	mutex_finish(&all->mutex);
	return status;
}

enum status exchange_tiles(const struct exchange_tiles_params *params, struct exchange_tiles_result *result)
{
	struct work all = {.params = params, .result = result};
	start(&all);
	enum status status;
	TRY_OR(done, exchange_page_check(params));
	TRY_OR(done, check_heights(params, store_meta(params->store)));
	TRY_OR(done, check_folder(params->directory));
	TRY_OR(done, exchange_file_folder(params->directory));
	TRY_OR(done, store_reader_create(params->store, &all.reader));
	TRY_OR(done, exchange_frame_init(&all.frame, params));
	TRY_OR(done, exchange_cover_init(&all.cover, &all.frame, all.reader));
	TRY_OR(done, exchange_zooms_init(&all.zooms, &all.frame, all.reader, params->store, params->since));
	TRY_OR(done, exchange_steps_create(&all.steps));
	TRY_OR(done, begin(&all));
	tell(&all);
	TRY_OR(done, tidy(&all)); /* before tiles of coarser levels are made of those that are there */
	TRY_OR(done, run_threads(&all));
	TRY_OR(done, exchange_page_write(params, &all.frame, &all.zooms, result));
	TRY_OR(done, exchange_stamp_write(params->directory, &all.stamp));
	TRY_OR(done, exchange_journal_end(&all.journal));
done:
	return finish(&all, status);
}

/* --- one file --- */

/* What MBTiles 1.3 asks for, and of heights how they are coded. */
static enum status say_all(struct work *all)
{
	static const char *const names[] = {[EXCHANGE_TERRAIN] = "heights", [EXCHANGE_HILLSHADE] = "hillshade", [EXCHANGE_RUTS] = "ruts", [EXCHANGE_IMAGERY] = "imagery"};
	const struct exchange_coding coding = exchange_coding_of(all->params, all->frame.meta);
	const double *b = all->frame.bounds;
	const int least = all->zooms.map[0], most = all->only == EXCHANGE_IMAGERY ? all->zooms.imagery : all->zooms.map[1];
	char text[8][160];
	snprintf(text[0], sizeof text[0], "%s", all->params->title);
	snprintf(text[1], sizeof text[1], "%.9f,%.9f,%.9f,%.9f", b[0], b[1], b[2], b[3]);
	snprintf(text[2], sizeof text[2], "%.9f,%.9f,%d", (b[0] + b[2]) / 2, (b[1] + b[3]) / 2, least);
	snprintf(text[3], sizeof text[3], "%d", least);
	snprintf(text[4], sizeof text[4], "%d", most);
	snprintf(text[5], sizeof text[5], "%s, revision %lld", names[all->only], (long long)all->zooms.revision);
	snprintf(text[6], sizeof text[6], "%d", all->frame.pixels);
	const char *const rows[][2] = {
		{"name", text[0]}, {"format", all->only == EXCHANGE_IMAGERY ? "webp" : "png"}, {"bounds", text[1]}, {"center", text[2]}, {"minzoom", text[3]}, {"maxzoom", text[4]},
		{"type", all->only == EXCHANGE_RUTS ? "overlay" : "baselayer"}, {"version", "1"}, {"description", text[5]}, {"tileSize", text[6]},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		TRY(exchange_mbtiles_say(all->file, rows[i][0], rows[i][1]));
	if (all->only != EXCHANGE_TERRAIN)
		return STATUS_OK;
	TRY(exchange_mbtiles_say(all->file, "encoding", exchange_coding_name(all->params)));
	const double factors[] = {65536 / coding.parts, 256 / coding.parts, 1 / coding.parts, -coding.zero};
	static const char *const keys[] = {"redFactor", "greenFactor", "blueFactor", "baseShift"};
	for (int i = 0; i < 4; i++)
		TRY(exchange_mbtiles_say(all->file, keys[i], number_exact(factors[i]).text));
	return STATUS_OK;
}

static enum status check_place(const struct work *all)
{
	return all->frame.globe != NULL ? STATUS_OK
					: fail_with(STATUS_INPUT, "%s: the store is local metres, and MBTiles lie on the world's map; write --tiles, whose page shows it", all->params->directory);
}

enum status exchange_mbtiles(const struct exchange_tiles_params *params, enum exchange_set set, struct exchange_tiles_result *result)
{
	struct work all = {.params = params, .result = result, .only = set};
	struct exchange_stamp none = {.revision = 0};
	start(&all);
	enum status status;
	TRY_OR(done, check_heights(params, store_meta(params->store)));
	TRY_OR(done, store_reader_create(params->store, &all.reader));
	TRY_OR(done, exchange_frame_init(&all.frame, params));
	TRY_OR(done, check_place(&all));
	/* Programs that read one file, such as GDAL, show nothing where the finest zoom level has no tile. Ruts are nothing there. */
	all.frame.maps_only = true;
	all.frame.whole_only = set != EXCHANGE_RUTS;
	TRY_OR(done, exchange_zooms_init(&all.zooms, &all.frame, all.reader, params->store, -1));
	TRY_OR(done, choose_range(&all, &none, false));
	TRY_OR(done, mem_zeroed(&all.journal.done, (size_t)count_units(&all) + 1, 1, "the tiles of a file"));
	TRY_OR(done, exchange_mbtiles_create(params->directory, &all.file));
	tell(&all);
	TRY_OR(done, run_threads(&all));
	if (result->made[set] == 0)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: nothing would be in it: %s; %s", params->directory, set == EXCHANGE_RUTS ? "no ruts are there" : set == EXCHANGE_IMAGERY ? "no imagery is there" : "no ground is there",
				       set == EXCHANGE_RUTS ? "give the overlay or the store that was driven on" : set == EXCHANGE_IMAGERY ? "give another window, or import some with furrow import --imagery" : "give another window"));
	TRY_OR(done, say_all(&all));
	TRY_OR(done, exchange_mbtiles_publish(all.file));
done:
	return finish(&all, status);
}
