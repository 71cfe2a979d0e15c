/*
 * Fixed regions against windows and dynamic regions (dissertation 4.5, figures 22 and 23): passes, copies, bytes copied and time of a contact, by
 * footprint, by the share of bodies on a corner of four tiles, and by the number of bodies. regions_ways.c describes the ways. In each job all ways
 * take turns, and the ground that they leave must have the same bits. Then the dissertation's displacement by a depth buffer (regions_below.c).
 *
 *     bench_regions [quick]
 *
 * Prints JSON lines; bench/regions.py makes the page. us, passes, copies and bytes are of one contact. `low` and `high`: of the runs.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "regions.h"

enum { RUNS = 5 };

static const char *const names[REGIONS_WAYS] = {[WAY_WINDOW] = "window", [WAY_BATCH] = "batch", [WAY_FIXED] = "fixed", [WAY_DYNAMIC] = "dynamic"};

static uint64_t passes(const struct gpu_stats *stats)
{
	return gpu_group_passes(stats, GPU_DISPLACE) + gpu_group_passes(stats, GPU_REDISTRIBUTE) + gpu_group_passes(stats, GPU_ATTRIBUTES);
}

static void tell(const char *set, const struct regions_job *job, enum regions_way way, const struct gpu_stats stats[2], uint64_t scratch, double *seconds,
		 int runs)
{
	const double contacts = (double)job->bodies * REGIONS_STEPS;
	const double us = bench_median(seconds, (size_t)runs) * 1e6 / contacts;
	printf("{\"bench\": \"regions\", \"set\": \"%s\", \"model\": \"%s\", \"repetitions\": %d, \"footprint\": %d, \"bodies\": %d, \"crossing\": %g, \"margin\": %d, "
	       "\"way\": \"%s\", \"us\": %.4f, \"low\": %.4f, \"high\": %.4f, \"passes\": %.6g, \"copies\": %.6g, \"copied\": %.8g, \"scratch\": %llu}\n",
	       set, deform_model_row(job->model)->name, job->repetitions, job->footprint, job->bodies, job->crossing, job->margin, names[way], us,
	       seconds[0] * 1e6 / contacts, seconds[runs - 1] * 1e6 / contacts, (double)(passes(&stats[1]) - passes(&stats[0])) / contacts,
	       (double)(stats[1].copies - stats[0].copies) / contacts, (double)(stats[1].copy_bytes - stats[0].copy_bytes) / contacts,
	       (unsigned long long)scratch);
	fflush(stdout);
}

static void measure(struct gpu *gpu, const char *set, const struct regions_job *job, int runs)
{
	struct field *fields[REGIONS_WAYS] = {NULL};
	struct gpu_stats stats[REGIONS_WAYS][2];
	double seconds[REGIONS_WAYS][RUNS];
	uint64_t hash = 0;
	for (int way = 0; way < REGIONS_WAYS; way++)
		if (way != WAY_BATCH || job->bodies > 1)
			fields[way] = regions_open(gpu, job, (enum regions_way)way);
	/* The first run warms. */
	for (int run = -1; run < runs; run++)
		for (int way = 0; way < REGIONS_WAYS; way++) {
			if (fields[way] == NULL)
				continue;
			gpu_stats(gpu, &stats[way][0]);
			const double took = regions_run(fields[way]);
			gpu_stats(gpu, &stats[way][1]);
			if (run >= 0)
				seconds[way][run] = took;
		}
	for (int way = 0; way < REGIONS_WAYS; way++) {
		if (fields[way] == NULL)
			continue;
		const uint64_t found = regions_hash(fields[way]);
		if (way == 0)
			hash = found;
		if (found != hash)
			bench_must(fail_with(STATUS_FAILED, "bench: %s leaves other ground than windows (%s, %d posts, %d bodies, %g on corners); mend it", names[way],
					     deform_model_row(job->model)->name, job->footprint, job->bodies, job->crossing));
		tell(set, job, (enum regions_way)way, stats[way], regions_bytes(fields[way]), seconds[way], runs);
	}
	for (int way = 0; way < REGIONS_WAYS; way++)
		if (fields[way] != NULL)
			regions_close(fields[way]);
}

int main(int argc, char **argv)
{
	static const int footprints[] = {2, 4, 8, 16, 32, 64, 128, 200}, bodies[] = {1, 4, 16, 64, 200}, margins[] = {2, 4, 8, 16, 32};
	static const double shares[] = {0, 0.25, 0.5, 0.75, 1};
	static const struct {
		enum deform_model model;
		int repetitions;
	} models[] = {{DEFORM_NONE, 1}, {DEFORM_BOX_FILTER, 1}, {DEFORM_BOX_FILTER, 2}};
	const bool quick = argc > 1 && strcmp(argv[1], "quick") == 0;
	const int runs = quick ? 3 : RUNS;
	struct gpu *gpu;
	if (argc > 1 + quick) {
		fprintf(stderr, "usage: bench_regions [quick]\n");
		return 2;
	}
	bench_must(gpu_create(&(struct gpu_params){.draws = false}, &gpu));
	printf("{\"bench\": \"gl\", \"renderer\": \"%s\", \"steps\": %d, \"runs\": %d}\n", gpu_info(gpu)->renderer, REGIONS_STEPS, runs);
	fflush(stdout);
	for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
		struct regions_job job = {.model = models[m].model, .repetitions = models[m].repetitions, .footprint = 16, .bodies = 1, .margin = 16};
		for (size_t i = 0; i < sizeof footprints / sizeof *footprints; i++)
			for (int corner = 0; corner < 2; corner++) {
				struct regions_job of = job;
				of.footprint = footprints[i];
				of.crossing = corner;
				measure(gpu, "footprint", &of, runs);
			}
		if (job.repetitions > 1)
			continue;
		for (size_t i = 0; i < sizeof bodies / sizeof *bodies; i++)
			for (int corner = 0; corner < 2; corner++) {
				struct regions_job of = job;
				of.bodies = bodies[i];
				of.crossing = corner;
				measure(gpu, "bodies", &of, runs);
			}
		for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
			struct regions_job of = job;
			of.bodies = 16;
			of.crossing = shares[i];
			measure(gpu, "crossing", &of, runs);
		}
	}
	for (size_t i = 0; i < sizeof margins / sizeof *margins; i++)
		for (int wide = 0; wide < 2; wide++)
			measure(gpu, "margin", &(struct regions_job){.model = DEFORM_BOX_FILTER, .repetitions = 1, .footprint = wide ? 64 : 16, .bodies = 1,
								    .crossing = 1, .margin = margins[i]}, runs);
	regions_below(gpu, footprints, sizeof footprints / sizeof *footprints, runs);
	gpu_destroy(gpu);
	return 0;
}
