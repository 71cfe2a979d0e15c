/*
 * Write-backs: pages of offsets with two ruts across each, committed in batches by store_commit (one
 * transaction: the pages, every coarser level above, the run's record), beside GDAL updating the
 * same blocks of one level of a tiled GeoTIFF (no transaction, no pyramid). Subject "history": a store whose commits keep what they
 * replace; "last": one that keeps only what the last commit replaced.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "record.h"
#include "store/store.h"
#include "store_bench.h"

#define LEVEL (-3)
#define SIDE 16 /* pages a side at LEVEL */
#define PAGES (SIDE * SIDE)
#define POSTS (BENCH_BLOCK + 1)
#define CHECKPOINT_BYTES (64 << 20)

struct pages {
	struct store_page page[PAGES]; /* in the order they are written: along tracks */
	int32_t *posts;
};

struct target {
	struct store *store; /* one of the two */
	struct bench_gdal *gdal;
	bool sync;
	int64_t step, uncheckpointed;
};

/* Metres a vehicle's two wheels press and raise at (x, y), on its `lap`th way along a row of pages. */
static double rut(double x, double y, int lap)
{
	double middle = 16 + 4 * sin(x / 11) + 0.3 * sin(lap + x / 5), depth = 0;
	double across = fmod(y, 32) - middle;
	for (int wheel = -1; wheel <= 1; wheel += 2) {
		double d = fabs(across - 0.9 * wheel);
		double bottom = -0.08 - 0.02 * sin(x * 1.7 + lap) - 0.015 * cos(x / 2.3 + 2 * y);
		if (d < 0.2)
			depth += bottom;
		else if (d < 0.45)
			depth += (0.03 + 0.01 * sin(x * 3.1 + lap)) * sin((d - 0.2) / 0.25 * M_PI);
	}
	return depth;
}

static void fill(struct pages *pages, int lap)
{
	for (size_t i = 0; i < PAGES; i++) {
		struct tile tile = {LEVEL, (uint32_t)(i % SIDE), (uint32_t)(i / SIDE)};
		int32_t *posts = pages->posts + i * POSTS * POSTS;
		for (uint32_t y = 0; y < POSTS; y++)
			for (uint32_t x = 0; x < POSTS; x++)
				posts[y * POSTS + x] = (int32_t)lround(
					ldexp(rut((tile.x * 256.0 + x) * 0.125, (tile.y * 256.0 + y) * 0.125, lap), 20));
		pages->page[i] = (struct store_page){.tile = tile, .planes = {[PLANE_OFFSET] = posts}};
	}
}

static void commit(struct target *target, const struct store_page *pages, size_t count)
{
	if (target->gdal != NULL) {
		for (size_t i = 0; i < count; i++)
			bench_gdal_write(target->gdal, pages[i].tile, pages[i].planes[PLANE_OFFSET]);
		bench_gdal_flush(target->gdal, target->sync);
		return;
	}
	struct store_run run = {.scene_hash = "00", .step = target->step, .time = 0.02 * (double)target->step, .state = "{}"};
	struct store_commit_result result;
	bench_must(store_commit(target->store, pages, count, &run, &result));
	target->step++;
	target->uncheckpointed += result.bytes_written;
	if (target->uncheckpointed > CHECKPOINT_BYTES) { /* as a drive does */
		bench_must(store_checkpoint(target->store));
		target->uncheckpointed = 0;
	}
}

/* All pages once, in batches; pages a second. */
static double lap_of(struct target *target, const struct pages *pages, size_t batch)
{
	double began = clock_seconds();
	for (size_t i = 0; i < PAGES; i += batch)
		commit(target, pages->page + i, batch);
	return PAGES / (clock_seconds() - began);
}

/* That what was measured was done. */
static void check(struct target *target, const struct pages *pages)
{
	struct store_reader *reader = NULL;
	unsigned present;
	bool good = true;
	int32_t *found = mem_alloc(POSTS * POSTS, sizeof *found);
	if (found == NULL)
		bench_must(fail_memory("a page"));
	if (target->gdal == NULL)
		bench_must(store_reader_create(target->store, &reader));
	for (size_t i = 0; i < PAGES; i += PAGES - 1) {
		const struct store_page *page = &pages->page[i];
		if (target->gdal != NULL) {
			good &= bench_gdal_holds(target->gdal, page->tile, page->planes[PLANE_OFFSET]);
			continue;
		}
		bench_must(store_read_deformed(reader, page->tile, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){found}, &present));
		good &= memcmp(found, page->planes[PLANE_OFFSET], POSTS * POSTS * sizeof *found) == 0;
	}
	if (!good)
		bench_must(fail_with(STATUS_FAILED, "bench: a page that was written reads otherwise; this is a bug"));
	store_reader_destroy(reader);
	mem_free(found);
}

static enum status count_revision(void *user, const struct store_revision *revision)
{
	(void)revision;
	++*(int64_t *)user;
	return STATUS_OK;
}

/* So many revisions are there to be returned to, with the present one. */
static void check_history(struct store *store, int64_t wanted)
{
	int64_t kept = 0;
	bench_must(store_log(store, count_revision, &kept));
	if (kept != wanted)
		bench_must(fail_with(STATUS_FAILED, "bench: a history lacks revisions; this is a bug"));
}

/* The figures of one durability and batch. `base`: those without history, run by run, or NULL: these are they. */
static void print(const char *subject, bool sync, size_t batch, double *rates, const double *base, int runs)
{
	char key[64];
	double times[BENCH_RUNS_MAX];
	const char *durability = sync ? "full" : "normal", *name = *subject ? subject : "furrow";
	for (int i = 0; base != NULL && i < runs; i++)
		times[i] = base[i] / rates[i];
	if (base != NULL) {
		snprintf(key, sizeof key, "%s.%zu.%s.times_longer", durability, batch, name);
		bench_record_add(key, "times", times, (size_t)runs);
	}
	snprintf(key, sizeof key, "%s.%zu.%s.pages_s", durability, batch, name);
	bench_record_add(key, "", rates, (size_t)runs);
	double rate = bench_median(rates, (size_t)runs);
	printf("{\"bench\": \"store\", \"row\": \"write-back\", \"subject\": \"%s\", \"durability\": \"%s\", "
	       "\"batch\": %zu, \"pages_s\": %.1f, \"commits_s\": %.1f}\n",
	       subject, durability, batch, rate, rate / (double)batch);
	fflush(stdout);
}

/* One durability and batch, all targets in turn: the store, those that keep what commits replace, and two GeoTIFFs. */
static void measure(struct pages *pages, bool sync, size_t batch, int runs)
{
	enum { STORES = 3, TARGETS = 5 };
	static const char *const subjects[TARGETS] = {"", "history", "last", "LERC", "ZSTD"};
	static const char *const names[TARGETS] = {"write.furrow", "history.furrow", "last.furrow", "lerc.tif", "zstd.tif"};
	struct target targets[TARGETS] = {{.sync = sync}, {.sync = sync}, {.sync = sync}, {.sync = sync}, {.sync = sync}};
	static double rates[TARGETS][BENCH_RUNS_MAX];
	size_t count = 0;
	for (; count < STORES; count++) {
		const char *path = bench_path(names[count]);
		bench_dunes(path, SIDE / 8);
		const struct store_options options = {
			.mode = STORE_WRITE, .durable_full = sync, .keep_history = count == 1, .keep_last = count == 2,
		};
		bench_must(store_open(path, &options, &targets[count].store));
		bench_must(store_set_working_level(targets[count].store, LEVEL));
	}
	for (; count < TARGETS; count++)
		if (!bench_gdal_create(bench_path(names[count]), SIDE, subjects[count],
				       &targets[count].gdal))
			break;
	for (int run = -1; run < runs; run++) { /* the first lap warms, on rows that are not there yet */
		fill(pages, run + 1);
		for (size_t i = 0; i < count; i++) {
			double rate = lap_of(&targets[i], pages, batch);
			if (run >= 0)
				rates[i][run] = rate;
		}
	}
	for (size_t i = 0; i < count; i++)
		check(&targets[i], pages);
	check_history(targets[1].store, (runs + 1) * (int64_t)(PAGES / batch) + 1);
	check_history(targets[2].store, 2);
	for (size_t i = count; i-- > 0;) /* the store last: the median sorts its runs, and others are taken beside them */
		print(subjects[i], sync, batch, rates[i], i == 0 ? NULL : rates[0], runs);
	for (size_t i = STORES; i < count; i++)
		bench_gdal_close(targets[i].gdal);
	for (size_t i = 0; i < STORES; i++)
		store_close(targets[i].store);
}

void bench_write(int runs)
{
	static const size_t batches[] = {1, 32, 256};
	static struct pages pages;
	pages.posts = mem_alloc((size_t)PAGES * POSTS * POSTS, sizeof *pages.posts);
	if (pages.posts == NULL)
		bench_must(fail_memory("pages"));
	for (int sync = 0; sync < 2; sync++)
		for (size_t i = 0; i < sizeof batches / sizeof *batches; i++)
			measure(&pages, sync, batches[i], runs);
	mem_free(pages.posts);
}
