/* Moves pages from the store and back: loads on the loader threads, commits on the writer's. */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "resident/pages_internal.h"

/* --- loader threads --- */

static enum status load_planes(struct pages *pages, struct ground *ground, struct tile tile,
			       struct page_image *image, const struct page_image *queued)
{
	image->flags = 0;
	image->overlays = tile.level > pages->params.level;
	if (queued != NULL) {
		pages->home->copy(pages, image, queued);
		return STATUS_OK;
	}
	if (pages->planes == 0 || tile.level < pages->params.level)
		return STATUS_OK;
	unsigned wanted = tile.level == pages->params.level ? pages->planes : pages->planes & GPU_DRAWN_PLANES, present;
	void *into[PLANES] = {NULL};
	enum status status;
	TRY_OR(done, pages->home->planes(pages, image, wanted, false, into));
	TRY_OR(done, store_read_deformed(resident_ground_reader(ground), tile, wanted, into, &present));
	pages->home->keep(pages, image, present);
done:
	mutex_lock(&pages->mutex);
	pages->io.counts.loaded += tile.level == pages->params.level;
	pages->io.counts.loaded_coarser += tile.level > pages->params.level;
	mutex_unlock(&pages->mutex);
	return status;
}

static enum status load_soils(struct pages *pages, unsigned loader, struct tile tile, struct page_image *image)
{
	const struct pages_params *params = &pages->params;
	const bool classed = pages_have_classes(pages, tile), numbered = pages_have_numbers(pages, tile);
	uint8_t *classes, *numbers;
	TRY(pages->home->room(pages, image, classed ? &classes : NULL, numbered ? &numbers : NULL));
	if (classed)
		TRY(params->classes(params->user, loader, tile, classes));
	if (numbered)
		TRY(params->numbers(params->user, loader, tile, numbers));
	return STATUS_OK;
}

static enum status load(void *user, unsigned loader, struct page_image *image, const struct page_image *queued)
{
	struct pages *pages = user;
	struct ground *ground = pages->grounds[loader];
	struct tile tile = tile_from_key(image->key);
	double started = clock_seconds();
	enum status status = pages->home->base(pages, ground, image);
	if (status == STATUS_OK)
		status = load_planes(pages, ground, tile, image, queued);
	if (status == STATUS_OK)
		status = load_soils(pages, loader, tile, image);
	mutex_lock(&pages->mutex);
	if (status == STATUS_OK) {
		pages->io.tiles_read++;
		pages->io.bytes_read += (int64_t)pages->layout.loaded; /* as decoded */
	}
	pages->io.load_ms += (clock_seconds() - started) * 1e3;
	mutex_unlock(&pages->mutex);
	return status;
}

/* --- the writer thread --- */

/* The data for the record's text, on the writer thread. */
struct describing {
	struct pages *pages;
	const void *record;
	struct pages_sums more; /* in this commit; without below and above. carried and in_flight: after it */
	char *state;
};

static const char *describe(void *user, const struct store_commit_result *result)
{
	struct describing *describing = user;
	const struct pages_record *record = &describing->pages->params.record;
	const struct pages_sums *before = &describing->pages->io.sums; /* the writer's alone */
	const struct pages_sums sums = {
		.below = before->below + result->below,
		.above = before->above + result->above,
		.compacted = before->compacted + describing->more.compacted,
		.sunk = before->sunk + describing->more.sunk,
		.slid = before->slid + describing->more.slid,
		.added = before->added + describing->more.added,
		.carried = describing->more.carried,
		.in_flight = describing->more.in_flight,
	};
	describing->state = record->print(record->user, describing->record, &sums);
	return describing->state;
}

static bool given_up(void *user)
{
	const struct describing *describing = user;
	return page_cache_gives_up(describing->pages->cache);
}

static enum status acknowledge(struct pages *pages, int64_t commit, int64_t step)
{
	FILE *log = pages->params.commit_log;
	if (log == NULL)
		return STATUS_OK;
	if (fprintf(log, "epoch %lld step %lld\n", (long long)commit, (long long)step) < 0 || fflush(log) != 0)
		return fail_with(STATUS_FAILED, "epochs.log: %s; free some disk space", strerror(errno));
	return STATUS_OK;
}

/* Takes the last row away if it is of the step. */
static bool begin_row(struct resident_volume *volume, int64_t step)
{
	if (volume->step == step && ftruncate(fileno(volume->file), volume->row) != 0)
		return false;
	if (fseek(volume->file, 0, SEEK_END) != 0)
		return false;
	volume->step = step;
	volume->row = ftell(volume->file);
	return volume->row >= 0;
}

static enum status tell_volume(struct resident_volume *volume, const struct store_run *run, const struct pages_sums *sums)
{
	if (volume->file == NULL)
		return STATUS_OK;
	if (!begin_row(volume, run->step) || fprintf(volume->file, "%.9g,%lld,%.12g,%.12g,%.12g\n", run->time, (long long)run->step, (double)-sums->below * volume->unit, (double)sums->above * volume->unit,
		    (double)(sums->compacted - sums->carried - sums->in_flight) * volume->unit) < 0 || fflush(volume->file) != 0)
		return fail_with(STATUS_FAILED, "volume.csv: %s; free some disk space", strerror(errno));
	return STATUS_OK;
}

/* Returns a number of the tally; 0 if there is no tally. */
static int64_t tally_number(const struct page_image *snapshot, int index)
{
	uint64_t value = 0;
	for (int i = 0; i < 8 && snapshot != NULL; i++)
		value |= (uint64_t)((const uint8_t *)snapshot->bytes)[8 * index + i] << (8 * i);
	return (int64_t)value;
}

/* Returns what the tally gives. */
static struct pages_sums tally_of(const struct page_image *snapshot)
{
	return (struct pages_sums){
		.compacted = tally_number(snapshot, 0), .sunk = tally_number(snapshot, 3), .slid = tally_number(snapshot, 4),
	};
}

static struct store_page store_page_of(const struct pages *pages, const struct page_image *image)
{
	struct store_page page = {.tile = tile_from_key(image->key)};
	for (int plane = 0; plane < PLANES; plane++)
		if (image->flags & PLANE_BIT(plane))
			page.planes[plane] = pages->home->plane(pages, image, (enum plane)plane);
	return page;
}

static void count_commit_locked(struct pages *pages, size_t count, const struct store_commit_result *result)
{
	struct pages_counts *counts = &pages->io.counts;
	counts->committed += (int64_t)count;
	counts->committed_coarser += result->coarser;
	counts->header += result->header;
	for (int plane = 0; plane < PLANES; plane++) {
		counts->changed[plane] += result->changed[plane];
		counts->looked_up[plane] += result->looked_up[plane];
	}
}

static enum status commit(void *user, const struct page_image *const *images, size_t count, const void *record,
			  const struct page_image *snapshot)
{
	struct pages *pages = user;
	enum status status = pages->params.before_commit != NULL ? pages->params.before_commit(pages->params.user) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	double started = clock_seconds();
	TRY(mem_grow(&pages->commit_pages, &pages->commit_room, count, sizeof *pages->commit_pages, "a commit"));
	for (size_t i = 0; i < count; i++)
		pages->commit_pages[i] = store_page_of(pages, images[i]);
	struct pages_sums tally = tally_of(snapshot);
	const struct pages_sums *last = &pages->tallied;
	const struct pages_soil soil = pages->params.record.soil != NULL ? pages->params.record.soil(pages->params.record.user, record) : (struct pages_soil){0, 0, 0};
	tally.added = soil.added;
	struct describing describing = {
		.pages = pages,
		.record = record,
		.more = {.compacted = tally.compacted - last->compacted, .sunk = tally.sunk - last->sunk, .slid = tally.slid - last->slid,
			 .added = tally.added - last->added, .carried = soil.carried, .in_flight = soil.in_flight},
	};
	struct store_run run = {
		.scene_hash = pages->params.record.scene_hash,
		.compacted = describing.more.compacted,
		.added = describing.more.added,
		.describe = describe,
		.given_up = given_up,
		.user = &describing,
	};
	struct store_commit_result result;
	pages->params.record.when(record, &run.step, &run.time);
	status = store_commit(pages->params.store, pages->commit_pages, count, &run, &result);
	mem_free(describing.state);
	if (status != STATUS_OK)
		return status;
	pages->tallied = tally;
	status = acknowledge(pages, result.commit, run.step);
	if (status == STATUS_OK)
		status = store_bound_wal(pages->params.store);
	mutex_lock(&pages->mutex);
	pages->io.commits++;
	pages->io.step = run.step;
	pages->io.tiles_written += result.tiles_written;
	pages->io.bytes_written += result.bytes_written;
	pages->io.sums.below += result.below;
	pages->io.sums.above += result.above;
	pages->io.sums.compacted += run.compacted;
	pages->io.sums.sunk += describing.more.sunk;
	pages->io.sums.slid += describing.more.slid;
	pages->io.sums.added += run.added;
	pages->io.sums.carried = soil.carried;
	pages->io.sums.in_flight = soil.in_flight;
	count_commit_locked(pages, count, &result);
	pages->io.writeback_ms += (clock_seconds() - started) * 1e3;
	const struct pages_sums sums = pages->io.sums;
	struct resident_volume volume = pages->volume;
	mutex_unlock(&pages->mutex);
	TRY(status);
	status = tell_volume(&volume, &run, &sums);
	mutex_lock(&pages->mutex);
	pages->volume = volume;
	mutex_unlock(&pages->mutex);
	return status;
}

struct page_io resident_pages_io_of(struct pages *pages)
{
	return (struct page_io){pages, load, commit};
}
