#include "bench.h"

#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drive/drive.h"
#include "store/store.h"

static char folder[64];

static void leave(void)
{
	char command[96];
	snprintf(command, sizeof command, "rm -rf '%s'", folder);
	if (system(command) != 0)
		fprintf(stderr, "bench: %s is left behind\n", folder);
}

void bench_must(enum status status)
{
	if (status == STATUS_OK)
		return;
	fprintf(stderr, "bench: %s\n", failure_message());
	exit(status_exit_code(status));
}

const char *bench_path(const char *name)
{
	static char paths[8][128];
	static int next;
	if (folder[0] == '\0') {
		strcpy(folder, "/tmp/furrow-bench-XXXXXX");
		if (mkdtemp(folder) == NULL)
			bench_must(fail_with(STATUS_FAILED, "/tmp: no folder can be made; free some space"));
		atexit(leave);
	}
	char *path = paths[next++ % 8];
	snprintf(path, sizeof paths[0], "%s/%s", folder, name);
	return path;
}

static enum status posts(void *user, struct post_rect rect, double *heights)
{
	dem_synth_posts(user, rect, heights);
	return STATUS_OK;
}

static enum status put(void *user, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

void bench_store(const char *path, const struct dem_synth *synth, uint32_t cells)
{
	struct dem_synth copy = *synth;
	struct store_meta meta = {
		.extent = {synth->width, synth->height, synth->spacing, cells},
		.step = 0.002,
		.max_error = 0.001,
		.srs = "",
		.vertical = "",
		.sources = "synthetic",
	};
	struct store *store;
	bench_must(store_create(path, &meta, true, &store));
	bench_must(dem_cut(&(struct dem_cut){.extent = &meta.extent, .step = meta.step, .posts = posts, .posts_user = &copy,
					     .emit = put, .emit_user = store}));
	bench_must(store_publish(store));
	store_close(store);
}

static char *drive(const char *text, const char *store, const struct drive_host *host)
{
	const char *path = bench_path("scene.yaml");
	FILE *file = fopen(path, "w");
	if (file == NULL || fputs(text, file) < 0 || fclose(file) != 0)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be written; free some space", path));
	struct scene *scene;
	bench_must(scene_load(path, NULL, 0, &scene));
	struct drive_params params = {.scene = scene, .store = store, .directory = bench_path("out"), .host = host};
	struct drive_result result;
	bench_must(drive_run(&params, &result));
	scene_destroy(scene);
	return result.json;
}

char *bench_drive(const char *text, const char *store)
{
	return drive(text, store, NULL);
}

/* One step, one picture of it, and so on. */
struct watcher {
	int64_t pictures, steps;
};

static enum status turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct watcher *watcher = user;
	struct drive_figures figures;
	drive_figures(drive, &figures);
	bool seen = watcher->pictures > watcher->steps;
	wish->go = !seen ? DRIVE_HOLD : figures.over ? DRIVE_STOP : DRIVE_ONE;
	watcher->steps += seen;
	return STATUS_OK;
}

static enum status picture(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	struct watcher *watcher = user;
	watcher->pictures++;
	return STATUS_OK;
}

char *bench_watch(const char *text, const char *store)
{
	struct watcher watcher = {0, 0};
	const struct drive_host host = {&watcher, turn, picture};
	return drive(text, store, &host);
}

double bench_figure(const char *json, const char *path)
{
	cJSON *root = cJSON_Parse(json), *at = root;
	char names[128];
	snprintf(names, sizeof names, "%s", path);
	for (char *name = strtok(names, "."); name != NULL; name = strtok(NULL, "."))
		at = cJSON_GetObjectItemCaseSensitive(at, name);
	double value = cJSON_IsNumber(at) ? at->valuedouble : (double)NAN;
	cJSON_Delete(root);
	return value;
}

const char *bench_renderer(const char *json)
{
	static char name[256];
	cJSON *root = cJSON_Parse(json);
	const cJSON *gl = cJSON_GetObjectItemCaseSensitive(root, "gl");
	const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(gl, "renderer"));
	snprintf(name, sizeof name, "%s", text != NULL ? text : "");
	cJSON_Delete(root);
	return name;
}

static int by_size(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

double bench_median(double *values, size_t count)
{
	qsort(values, count, sizeof *values, by_size);
	return values[count / 2];
}
