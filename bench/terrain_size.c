/* A step costs the same whether the terrain has about 10 or 10,000 tiles: the same drive over both. */
#include <stdio.h>

#include "bench.h"
#include "record.h"

#define RUNS 5

static const char scene[] =
	"scene: 1\ntime_step: 0.02\nend_time: 20\nspacing: 0.125\nredistribute: {model: box}\nobjects:\n"
	"  - {name: a, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[20, 20], [120, 100]], speed: 6}}\n"
	"  - {name: b, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[21, 19], [121, 99]], speed: 6}}\n"
	"  - {name: c, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[22, 21], [122, 101]], speed: 6}}\n"
	"  - {name: d, shape: {wheel: {radius: 0.5, width: 0.4}}, sink: 0.1, path: {points: [[23, 20], [123, 100]], speed: 6}}\n"
	"cache: {slots: 64}\n";

int main(int count, char **words)
{
	bench_record_begin("terrain_size", &count, words);
	const int64_t sides[] = {193, 6401};
	double means[2][RUNS], p99s[2][RUNS], ratios[RUNS], tiles[2];
	char *json = NULL;
	for (int i = 0; i < 2; i++) {
		struct dem_synth synth = {DEM_SYNTH_RIDGED, sides[i], sides[i], 1, 60, 1};
		bench_store(bench_path(i == 0 ? "small.furrow" : "large.furrow"), &synth, 64);
		tiles[i] = (double)((sides[i] - 1) / 64 * ((sides[i] - 1) / 64));
	}
	/* In turn, so that a machine that drifts drifts for both. */
	for (int run = 0; run < RUNS; run++)
		for (int i = 0; i < 2; i++) {
			mem_free(json);
			json = bench_drive(scene, bench_path(i == 0 ? "small.furrow" : "large.furrow"));
			means[i][run] = bench_figure(json, "step_ms.p50");
			p99s[i][run] = bench_figure(json, "step_ms.p99");
			ratios[run] = means[1][run] / means[0][run]; /* of the second, both are there */
		}
	double small = bench_median(means[0], RUNS), large = bench_median(means[1], RUNS);
	printf("{\"bench\": \"terrain_size\", \"tiles\": [%g, %g], \"step_ms_p50\": [%.4f, %.4f], \"ratio\": %.3f, "
	       "\"step_ms_p99\": [%.3f, %.3f], \"gl\": \"%s\"}\n",
	       tiles[0], tiles[1], small, large, large / small, bench_median(p99s[0], RUNS), bench_median(p99s[1], RUNS),
	       bench_renderer(json));
	bench_record_add("ratio", "times", ratios, RUNS);
	bench_record_end(bench_renderer(json));
	mem_free(json);
	return 0;
}
