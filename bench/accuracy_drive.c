/*
 * The scene driven by the product: drive_run over a store made from the function, deformation in an overlay of its own.
 *
 * The drive is timed alone, to the step in which the wheel comes to its end; then it is resumed, to the same bits as if
 * it had not been broken off, until the ground has come to rest: that is not in the times.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cJSON.h>
#include <xxhash.h>

#include "accuracy.h"
#include "bench.h"
#include "drive/drive.h"
#include "store/store.h"

static struct scene *scene_until(const struct accuracy_drive *drive, double end)
{
	struct scene_setting settings[16];
	char text[32];
	size_t count = 0;
	snprintf(text, sizeof text, "%.9g", end);
	for (; count < drive->setting_count; count++)
		settings[count] = drive->settings[count];
	settings[count++] = (struct scene_setting){"end_time", text};
	return accuracy_scene(drive->model, drive->laps, settings, count);
}

static char *run(const struct accuracy_drive *drive, const char *overlay, double end, bool resume)
{
	struct scene *scene = scene_until(drive, end);
	struct drive_params params = {
		.scene = scene,
		.store = accuracy_store(drive->spacing, drive->max_error),
		.overlay = overlay,
		.directory = bench_path("out"),
		.resume = resume,
		.durable_full = drive->durable_full,
	};
	struct drive_result result;
	bench_must(drive_run(&params, &result));
	scene_destroy(scene);
	return result.json;
}

static double spacing_of(const struct accuracy_drive *drive)
{
	return ldexp(drive->spacing, -drive->divided);
}

static double seconds_of(const struct accuracy_drive *drive)
{
	struct scene *scene = accuracy_scene(drive->model, drive->laps, NULL, 0);
	struct track *track = accuracy_track(scene, spacing_of(drive));
	double seconds = accuracy_ends(track);
	motion_track_destroy(track);
	scene_destroy(scene);
	return seconds;
}

static void read_surface(const char *overlay, const char *base, int level, double spacing,
			 struct accuracy_surface *surface)
{
	struct store *store;
	struct store_reader *reader;
	*surface = (struct accuracy_surface){.rect = accuracy_rect(spacing), .spacing = spacing};
	size_t count = (size_t)((surface->rect.x1 - surface->rect.x0) * (surface->rect.y1 - surface->rect.y0));
	surface->heights = mem_alloc(count, sizeof(double));
	if (surface->heights == NULL)
		bench_must(fail_memory("bench"));
	bench_must(store_open_overlay(overlay, base, &(struct store_options){.mode = STORE_WRITE}, &store));
	bench_must(store_reader_create(store, &reader));
	bench_must(store_read_posts(reader, STORE_SURFACE, level, surface->rect, surface->heights));
	store_reader_destroy(reader);
	store_close(store);
}

/* Of a store's rows, and of its overlay's. */
static void stored_bytes(const char *path, bool overlay, struct accuracy_figures *figures)
{
	struct store *store;
	struct store_numbers numbers;
	bench_must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	bench_must(store_count(store, &numbers));
	if (!overlay)
		figures->base_bytes = numbers.base_bytes;
	for (int plane = 0; plane < PLANES && overlay; plane++)
		figures->plane_bytes += numbers.plane_bytes[plane];
	store_close(store);
}

/* Of the rows that the drive wrote of forces. */
static uint64_t rows_hash(void)
{
	char path[160], text[4096];
	snprintf(path, sizeof path, "%s/objects.csv", bench_path("out"));
	FILE *file = fopen(path, "rb");
	uint64_t hash = 0;
	size_t count;
	while (file != NULL && (count = fread(text, 1, sizeof text, file)) > 0)
		hash = XXH3_64bits_withSeed(text, count, hash);
	if (file != NULL) {
		fclose(file);
		unlink(path);
	}
	return hash;
}

static int64_t slot_bytes(const char *json)
{
	cJSON *root = cJSON_Parse(json);
	const cJSON *memory = cJSON_GetObjectItemCaseSensitive(root, "memory"), *plane;
	double bytes = 0;
	cJSON_ArrayForEach(plane, cJSON_GetObjectItemCaseSensitive(memory, "plane_bytes"))
		bytes += plane->valuedouble;
	cJSON_Delete(root);
	return (int64_t)bytes;
}

static void rest(const struct accuracy_drive *drive, const char *overlay, double end, const double *truth,
		 struct accuracy_figures *figures)
{
	double still = deform_conserves(drive->model) ? ACCURACY_REST * drive->interval : drive->time_step;
	double quantum = lattice_offset_metres(1) * spacing_of(drive) * spacing_of(drive);
	char *json = run(drive, overlay, end + still, true);
	double awake = bench_figure(json, "slide.awake");
	figures->awake = isnan(awake) ? 0 : (int64_t)awake;
	figures->drift = (bench_figure(json, "volume.quanta.net") + bench_figure(json, "volume.quanta.compacted")) * quantum;
	mem_free(json);
	const char *base = accuracy_store(drive->spacing, drive->max_error);
	stored_bytes(base, false, figures);
	stored_bytes(overlay, true, figures);
	struct accuracy_surface surface;
	read_surface(overlay, base, -drive->divided, spacing_of(drive), &surface);
	figures->error = accuracy_compare(truth, &surface);
	size_t count = (size_t)((surface.rect.x1 - surface.rect.x0) * (surface.rect.y1 - surface.rect.y0));
	figures->hash = XXH3_64bits(surface.heights, count * sizeof(double));
	mem_free(surface.heights);
}

void accuracy_drive(const struct accuracy_drive *drive, const struct accuracy_truth *truth, struct accuracy_figures *figures)
{
	char overlay[128], aside[160];
	static const char *const sides[] = {"", "-wal", "-shm"};
	snprintf(overlay, sizeof overlay, "%s", bench_path("overlay.furrow"));
	for (size_t i = 0; i < sizeof sides / sizeof sides[0]; i++) {
		snprintf(aside, sizeof aside, "%s%s", overlay, sides[i]);
		unlink(aside);
	}
	*figures = (struct accuracy_figures){.time_step = drive->time_step};
	double end = seconds_of(drive);
	char *json = run(drive, overlay, end, false);
	figures->steps = (int64_t)bench_figure(json, "steps");
	figures->ms_step = 1e3 / bench_figure(json, "steps_per_second.mean");
	figures->p99 = bench_figure(json, "step_ms.p99");
	figures->worst = bench_figure(json, "step_ms.max");
	figures->slot_bytes = slot_bytes(json);
	snprintf(figures->gl, sizeof figures->gl, "%s", bench_renderer(json));
	mem_free(json);
	figures->rows = rows_hash();
	if (truth != NULL)
		rest(drive, overlay, end, truth->surfaces[drive->model], figures);
}
