/*
 * What accuracy costs in time: one scene (accuracy_scene.c), each knob turned alone, then pairs. A JSON line a row on
 * stdout, what is being done on stderr.
 *
 *   bench_accuracy [STUDY...] [--quick] [--truth FILE]
 *
 * Studies, all of them if none is named: spacing, sheet, divided, settled, base_format, offset_format, iterations, tolerance,
 * interval, time_step, import_error, durability, pairs. --quick: two timed runs of each, without the longest
 * and without box and sumner. --truth:
 * where the truth is kept from one run of the bench to the next; it takes a minute or two to make. Beside what a line is about
 * all is at its default; the store, and so the work, has posts of 1/16 m, the model is slippage.
 *
 *   error    to the truth (accuracy_truth.c): max and rms in m; volume, volume_abs in m3
 *   ms_step  mean over the steps of the drive, wall clock; of several runs, in turn with the study's other rows, the median.
 *            A step is knobs.time_step or 0.02 s; ms_second is for a second of simulated time. p99, worst: of single steps
 *   awake    blocks that still slide when the error is taken: ground that has not come to rest in ACCURACY_REST intervals
 *   drift    m3 by which offsets and what was compacted do not add up (models that conserve: law 5); `laws` says it in words
 *   beside   of formats: how far the ground is from what the lattice makes of it. post_bytes: base and offset together
 *
 * max is the depth of the rut wherever its wall, which is upright beside the wheel, is a post off: it says little; rms and
 * volume_abs are what a spacing is chosen by.
 *
 * It ends with 1, and says why, if its own figures cannot be true: see accuracy_rows.h.
 */
#include "accuracy.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "accuracy_rows.h"
#include "bench.h"

enum { LAPS = 100 };

static void spacing(struct study *study)
{
	static const enum deform_model models[] = {DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SUMNER, DEFORM_SLIPPAGE};
	const int each = study->quick ? 5 : 7;
	size_t first[sizeof models / sizeof models[0]];
	for (size_t m = 0; m < sizeof models / sizeof models[0]; m++) {
		first[m] = study->count;
		for (int k = 0; k < each && study->truth->surfaces[models[m]] != NULL; k++) {
			double apart_m = ldexp(1, -k);
			bool own = apart_m == ACCURACY_OWN && models[m] == DEFORM_SLIPPAGE;
			struct row *row = row_add(study, "spacing", own, "\"spacing\": %.9g, \"model\": \"%s\"", apart_m,
					      accuracy_model_name(models[m]));
			row->drive.model = models[m];
			row->drive.spacing = apart_m;
		}
	}
	rows_measure(study);
	/* Not sumner: soil slides a post an iteration, so with as many iterations it comes less far. */
	for (size_t m = 0; m < sizeof models / sizeof models[0]; m++)
		if (models[m] != DEFORM_SUMNER && study->truth->surfaces[models[m]] != NULL)
			judge_finest(study, first[m], (size_t)each);
	judge_volume(study);
}

/* An elastic sheet alone, whose truth is made in seconds. Its length is a post and less from 1/8 m on. */
static void sheet(struct study *study)
{
	for (int k = 0; k < (study->quick ? 5 : 7); k++) {
		double apart_m = ldexp(1, -k);
		struct row *row = row_add(study, "sheet", apart_m == ACCURACY_OWN, "\"spacing\": %.9g", apart_m);
		row->drive.model = DEFORM_SHEET;
		row->drive.spacing = apart_m;
		row_set(row, "redistribute.tension", ACCURACY_TENSION);
		row_set(row, "redistribute.stiffness", ACCURACY_STIFFNESS);
		row_set(row, "redistribute.yield", ACCURACY_YIELD);
	}
	rows_measure(study);
	judge_finest(study, 0, study->count);
	judge_volume(study);
}

/* The same posts to work with, divided out of a store of 1 m: the rut is as fine, the ground it lies in is not. */
static void divided(struct study *study)
{
	for (int k = 0; k < (study->quick ? 5 : 7); k++) {
		double apart_m = ldexp(1, -k);
		struct row *row = row_add(study, "divided", k == 0, "\"spacing\": %.9g, \"store_spacing\": 1", apart_m);
		row->drive.spacing = 1;
		row->drive.divided = k;
		row_set(row, "spacing", apart_m);
	}
	rows_measure(study);
	judge_volume(study);
}

/* As much sliding as the spacing asks for: so many times the iterations as its square falls. */
static void settled(struct study *study)
{
	for (int k = 3; k <= (study->quick ? 4 : 6); k++) {
		double apart_m = ldexp(1, -k), every = 0.032 * ldexp(1, -2 * (k - 3));
		struct row *row = row_add(study, "settled", false, "\"spacing\": %.9g, \"iterations\": 8, \"interval\": %.9g",
					  apart_m, every);
		row->drive.spacing = apart_m;
		row->drive.interval = every;
		row_set(row, "redistribute.iterations", 8);
		row_set(row, "redistribute.interval", every);
	}
	rows_measure(study);
	judge_finest(study, 0, study->count);
}

static void base_format(struct study *study)
{
	for (int format = 0; format < KEPT_FORMATS; format++) {
		struct row *row = row_add(study, "base_format", format == KEPT_R32I, "\"base_format\": \"%s\"",
				      accuracy_format_name((enum accuracy_format)format));
		row_keep(row, (enum accuracy_format)format, KEPT_R32I);
	}
	rows_measure(study);
	judge_lattice(study);
}

static void offset_format(struct study *study)
{
	for (int format = 0; format < KEPT_FORMATS; format++) {
		struct row *row = row_add(study, "offset_format", format == KEPT_R32I, "\"offset_format\": \"%s\"",
				      accuracy_format_name((enum accuracy_format)format));
		row_keep(row, KEPT_R32I, (enum accuracy_format)format);
	}
	rows_measure(study);
	judge_lattice(study);
}

static void iterations(struct study *study)
{
	for (int count = 1; count <= 8; count *= 2)
		row_set(row_add(study, "iterations", count == 1, "\"iterations\": %d", count), "redistribute.iterations", count);
	rows_measure(study);
}

static void tolerance(struct study *study)
{
	static const double values[] = {0, 0.001, 0.01, 0.05};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
		row_set(row_add(study, "tolerance", values[i] == 0, "\"tolerance\": %g", values[i]), "redistribute.tolerance", values[i]);
	rows_measure(study);
}

static void interval(struct study *study)
{
	static const double values[] = {0.01, 0.02, 0.05, 0.1, 0.2};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = row_add(study, "interval", values[i] == 0.05, "\"interval\": %g", values[i]);
		row->drive.interval = values[i];
		row_set(row, "redistribute.interval", values[i]);
	}
	rows_measure(study);
}

static void time_step(struct study *study)
{
	static const double values[] = {0.1, 0.02, 0.005, 0.001};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = row_add(study, "time_step", values[i] == 0.02, "\"time_step\": %g", values[i]);
		row->drive.time_step = values[i];
		row_set(row, "time_step", values[i]);
	}
	rows_measure(study);
	judge_same(study, "law 10");
}

static void import_error(struct study *study)
{
	static const double values[] = {0, 0.001, 0.01, 0.1, 0.5, 1};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = row_add(study, "import_error", values[i] == ACCURACY_IMPORT_ERROR, "\"import_error\": %g", values[i]);
		row->drive.max_error = values[i];
		row->of_base = true;
	}
	rows_measure(study);
}

static void durability(struct study *study)
{
	int laps = study->quick ? LAPS / 5 : LAPS;
	for (int full = 0; full < 2; full++) {
		struct row *row = row_add(study, "durability", full == 0, "\"durable\": \"%s\", \"laps\": %d",
					  full ? "full" : "normal", laps);
		row->drive.durable_full = full == 1;
		row->timed_laps = laps;
	}
	rows_measure(study);
	judge_same(study, "durability being no part of the ground");
}

static void pairs(struct study *study)
{
	static const double errors[] = {0.001, 0.01, 0.1};
	static const enum accuracy_format kept[] = {KEPT_R8, KEPT_R16F, KEPT_R32I};
	for (int k = 3; k <= (study->quick ? 4 : 5); k++)
		for (int i = 0; i < 9; i++) {
			double apart_m = ldexp(1, -k);
			bool own = apart_m == ACCURACY_OWN;
			struct row *row;
			if (i < 3) {
				int count = i == 0 ? 1 : i == 1 ? 4 : 8;
				row = row_add(study, "pairs", own && count == 1, "\"spacing\": %.9g, \"iterations\": %d", apart_m, count);
				row_set(row, "redistribute.iterations", count);
			} else if (i < 6) {
				row = row_add(study, "pairs", own && kept[i - 3] == KEPT_R32I, "\"spacing\": %.9g, \"offset_format\": \"%s\"",
					  apart_m, accuracy_format_name(kept[i - 3]));
			} else {
				row = row_add(study, "pairs", own && i == 6, "\"spacing\": %.9g, \"import_error\": %g", apart_m, errors[i - 6]);
				row->drive.max_error = errors[i - 6];
				row->of_base = true;
			}
			row->drive.spacing = apart_m;
			if (i >= 3 && i < 6)
				row_keep(row, KEPT_R32I, kept[i - 3]);
		}
	rows_measure(study);
}

static const struct {
	const char *name;
	void (*run)(struct study *study);
} studies[] = {
	{"spacing", spacing},
	{"sheet", sheet},
	{"divided", divided},
	{"settled", settled},
	{"base_format", base_format},
	{"offset_format", offset_format},
	{"iterations", iterations},
	{"tolerance", tolerance},
	{"interval", interval},
	{"time_step", time_step},
	{"import_error", import_error},
	{"durability", durability},
	{"pairs", pairs},
};
#define STUDIES (sizeof studies / sizeof studies[0])

int main(int argc, char **argv)
{
	const char *path = NULL;
	bool asked[STUDIES] = {false}, any = false, quick = false;
	for (int i = 1; i < argc; i++) {
		size_t at = 0;
		while (at < STUDIES && strcmp(argv[i], studies[at].name) != 0)
			at++;
		if (at < STUDIES)
			asked[at] = any = true;
		else if (strcmp(argv[i], "--quick") == 0)
			quick = true;
		else if (strcmp(argv[i], "--truth") == 0 && i + 1 < argc)
			path = argv[++i];
		else
			bench_must(fail_with(STATUS_USAGE, "bench_accuracy: %s: no study goes by that name; see the file's opening", argv[i]));
	}
	struct accuracy_truth truth;
	bool alone = any;
	for (size_t i = 0; i < STUDIES; i++)
		alone = alone && (!asked[i] || studies[i].run == sheet);
	/* The truths of sumner and box take most of the time. */
	const unsigned wanted = alone ? 1U << DEFORM_SHEET : quick ? 1U << DEFORM_SHEET | 1U << DEFORM_NONE | 1U << DEFORM_SLIPPAGE : ACCURACY_EVERY;
	accuracy_truth_open(&truth, path, wanted);
	struct study study = {.truth = &truth, .quick = quick, .runs = quick ? 2 : ACCURACY_RUNS};
	study.rows = mem_calloc(ACCURACY_ROWS, sizeof *study.rows);
	if (study.rows == NULL)
		bench_must(fail_memory("bench"));
	for (size_t i = 0; i < STUDIES; i++)
		if (!any || asked[i]) {
			study.count = 0;
			studies[i].run(&study);
		}
	mem_free(study.rows);
	accuracy_truth_close(&truth);
	return study.doubtful ? 1 : 0;
}
