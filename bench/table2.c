/*
 * The dissertation's Table 2 again: one vehicle of four wheels on square terrains of 65 and 129 m with
 * posts 1, 0.25 and 0.125 m apart, in frames a second, with deformation and without. Its own figures
 * (GeForce 7800 GT, 2006; window size not stated) stand beside ours.
 *
 * Its terrain was divided to the finer posts everywhere and drawn so; ours is divided where wheels went.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench.h"
#include "record.h"

#define RUNS 3

static const double spacings[] = {1, 0.25, 0.125};
static const int sizes[] = {65, 129};
static const int dissertation[2][3] = {{480, 230, 75}, {470, 220, 68}};

static int wheel(char *text, size_t room, const char *name, double side, double lag, double size)
{
	/* Two laps of a circle, as fast on the inside as outside in angle; a point every 5 degrees. */
	int used = snprintf(text, room,
			    "  - {name: %s, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1,\n"
			    "     path: {loop: true, speed: %.3f, points: [",
			    name, 8 * (0.3 * size + side) / (0.3 * size));
	for (int i = 0; i < 72; i++) {
		double angle = (i * 5 - lag) * M_PI / 180, radius = 0.3 * size + side;
		used += snprintf(text + used, room - (size_t)used, "%s[%.4f, %.4f]", i > 0 ? ", " : "",
				 size / 2 + radius * cos(angle), size / 2 + radius * sin(angle));
	}
	return used + snprintf(text + used, room - (size_t)used, "]}}\n");
}

/* Fills fps with RUNS runs and returns their median. */
static double frames(int size, double spacing, bool deform, char *renderer, double fps[RUNS])
{
	char text[32768];
	double metres = size - 1, axle = 2.6 / (0.3 * metres) * 180 / M_PI;
	int used = snprintf(text, sizeof text,
			    "scene: 1\ntime_step: 0.016666667\nend_time: 5\nspacing: %g\n"
			    "redistribute: {model: %s}\n"
			    "view: {size: [640, 480], effects: [texture, fog, skirts],\n"
			    "  camera: {fixed: {eye: [%g, %g, %g], target: [%g, %g, 0]}}}\nobjects:%s\n",
			    spacing, deform ? "box" : "none", metres / 2, -0.15 * metres, 0.45 * metres, metres / 2,
			    metres / 2, deform ? "" : " []");
	if (deform) {
		used += wheel(text + used, sizeof text - (size_t)used, "front_left", -0.9, 0, metres);
		used += wheel(text + used, sizeof text - (size_t)used, "front_right", 0.9, 0, metres);
		used += wheel(text + used, sizeof text - (size_t)used, "rear_left", -0.9, axle, metres);
		wheel(text + used, sizeof text - (size_t)used, "rear_right", 0.9, axle, metres);
	}
	for (int run = 0; run < RUNS; run++) {
		struct dem_synth synth = {DEM_SYNTH_PLAIN, size, size, 1, 2, 1};
		const char *store = bench_path("table2.furrow");
		bench_store(store, &synth, 64);
		char *json = bench_watch(text, store);
		/* A frame is a step and its picture. */
		fps[run] = 1e3 / (bench_figure(json, "step_ms.p50") + 1e3 / bench_figure(json, "fps.p50"));
		snprintf(renderer, 256, "%s", bench_renderer(json));
		mem_free(json);
	}
	return bench_median(fps, RUNS);
}

static void keep(int size, double spacing, const char *what, double *runs, size_t count)
{
	char key[64];
	snprintf(key, sizeof key, "%s.m%d_%gcm", what, size, spacing * 100);
	bench_record_add(key, "", runs, count);
}

int main(int count, char **words)
{
	char renderer[256] = "";
	bench_record_begin("table2", &count, words);
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 3; k++) {
			double fps[RUNS];
			double without = frames(sizes[i], spacings[k], false, renderer, fps);
			keep(sizes[i], spacings[k], "without_deformation", fps, RUNS);
			double with = frames(sizes[i], spacings[k], true, renderer, fps);
			keep(sizes[i], spacings[k], "furrow", fps, RUNS);
			keep(sizes[i], spacings[k], "dissertation", &(double){dissertation[i][k]}, 1);
			printf("{\"bench\": \"table2\", \"terrain_m\": %d, \"posts_m\": %g, \"fps\": %.1f, "
			       "\"fps_without_deformation\": %.1f, \"dissertation_fps\": %d, \"size\": [640, 480], \"gl\": "
			       "\"%s\"}\n",
			       sizes[i], spacings[k], with, without, dissertation[i][k], renderer);
			fflush(stdout);
		}
	bench_record_end(renderer);
	return 0;
}
