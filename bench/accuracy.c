/*
 * What accuracy costs in time: one scene (accuracy_scene.c), each knob turned alone, then pairs. A JSON line a row on
 * stdout, what is being done on stderr.
 *
 *   bench_accuracy [STUDY...] [--quick] [--truth FILE]
 *
 * Studies: spacing, settled, base_format, offset_format, iterations, interval, time_step, import_error, forces,
 * durability, pairs; all of them if none is named. --quick: one timed run of each. --truth: where the truth is kept from one
 * run of the bench to the next; it takes a minute or two to make. Beside what a line is about all is at its default, with
 * posts of 1/16 m, model slippage.
 *
 *   error    to the truth (accuracy_truth.c): max and rms in m; volume, volume_abs in m3
 *   ms_step  mean over the steps of the drive, wall clock; of several runs, in turn with the study's other rows, the median.
 *            A step is knobs.time_step or 0.02 s; ms_second is for a second of simulated time
 *   awake    blocks that still slide when the error is taken: ground that has not come to rest in ACCURACY_REST intervals
 *   drift    m3 by which offsets and what was compacted do not add up (models that conserve: law 5); `laws` says it in words
 *   beside   of formats: how far the ground is from what the lattice makes of it
 *
 * max is the depth of the rut wherever its wall, which is upright beside the wheel, is a post off: it says little; rms and
 * volume_abs are what a spacing is chosen by.
 *
 * It ends with 1, and says why, if its own figures cannot be true: see `judge`.
 */
#include "accuracy.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

enum { RUNS = 7, QUICK_RUNS = 1, ROWS_MOST = 64, SETTINGS_MOST = 4, PASSES = 5, LAPS = 100 };

struct row {
	const char *study;
	char knobs[128];           /* JSON, without its braces */
	bool is_default;
	const char *bytes_of;
	char values[SETTINGS_MOST][32];
	struct scene_setting settings[SETTINGS_MOST];
	struct accuracy_drive drive;
	bool is_variant;
	struct accuracy_variant variant;
	int timed_laps;            /* of a drive that has to be long to show something */
	struct accuracy_figures figures;
	double drift_after;        /* a variant: PASSES passes */
	struct accuracy_error beside;
	double ms[RUNS], p99[RUNS];
};

struct study {
	struct row *rows;
	size_t count;
};

static struct accuracy_truth truth;
static int runs = RUNS;
static bool doubtful;

static struct row *add(struct study *study, const char *name, bool is_default, const char *knobs, ...)
{
	va_list arguments;
	if (study->count == ROWS_MOST)
		bench_must(fail_with(STATUS_FAILED, "bench: a study has more rows than expected; raise ROWS_MOST"));
	struct row *row = &study->rows[study->count++];
	*row = (struct row){
		.study = name,
		.is_default = is_default,
		.bytes_of = "slot planes of the tiles touched",
		.timed_laps = 1,
		.drive = {.model = DEFORM_SLIPPAGE, .spacing = ACCURACY_OWN, .max_error = ACCURACY_IMPORT_ERROR, .time_step = 0.02,
			  .interval = 0.05, .laps = 1},
	};
	va_start(arguments, knobs);
	vsnprintf(row->knobs, sizeof row->knobs, knobs, arguments);
	va_end(arguments);
	return row;
}

static void set(struct row *row, const char *key, double value)
{
	size_t at = row->drive.setting_count++;
	snprintf(row->values[at], sizeof row->values[at], "%.9g", value);
	row->settings[at] = (struct scene_setting){key, row->values[at]};
}

static void keep_in(struct row *row, enum accuracy_format base, enum accuracy_format offset)
{
	row->is_variant = true;
	row->variant = (struct accuracy_variant){row->drive.model, row->drive.spacing, row->drive.max_error, base, offset, 1};
}

/* --- measuring --- */

static void run_row(struct row *row, const struct accuracy_truth *with, struct accuracy_figures *figures)
{
	row->drive.settings = row->settings;
	if (row->is_variant) {
		accuracy_variant(&row->variant, with, figures);
		return;
	}
	row->drive.laps = with != NULL ? 1 : row->timed_laps;
	accuracy_drive(&row->drive, with, figures);
}

/* Beside the lattice, over the same posts. */
static struct accuracy_error apart(const struct accuracy_surface *a, const struct accuracy_surface *lattice)
{
	struct accuracy_error error = {0};
	size_t count = (size_t)((a->rect.x1 - a->rect.x0) * (a->rect.y1 - a->rect.y0));
	double area = a->spacing * a->spacing;
	for (size_t i = 0; i < count; i++) {
		double off = a->heights[i] - lattice->heights[i];
		error.max = fmax(error.max, fabs(off));
		error.rms += off * off / (double)count;
		error.volume += off * area;
		error.volume_abs += fabs(off) * area;
	}
	error.rms = sqrt(error.rms);
	return error;
}

static void measure_beside(struct row *row)
{
	struct accuracy_variant lattice = row->variant;
	struct accuracy_figures plain, repeated;
	lattice.base = lattice.offset = KEPT_R32I;
	accuracy_variant(&lattice, &truth, &plain);
	row->beside = apart(&row->figures.surface, &plain.surface);
	mem_free(plain.surface.heights);
	mem_free(row->figures.surface.heights);
	row->figures.surface.heights = NULL;
	struct accuracy_variant often = row->variant;
	often.passes = PASSES;
	accuracy_variant(&often, NULL, &repeated);
	row->drift_after = repeated.drift;
}

/* What a format breaks, in words. */
static const char *laws(const struct row *row)
{
	static char text[256];
	enum accuracy_format base = row->variant.base, offset = row->variant.offset;
	int length = snprintf(text, sizeof text, "edges ok, ");
	if (row->figures.drift == 0 && row->drift_after == 0)
		length += snprintf(text + length, sizeof text - (size_t)length, "volume ok");
	else
		length += snprintf(text + length, sizeof text - (size_t)length, "volume drifts by %.3g m3, after %d passes by %.3g",
				   row->figures.drift, PASSES, row->drift_after);
	const char *precision = base == KEPT_R8 || base == KEPT_R16 ? "precision depends on the terrain's relief"
				: base == KEPT_R16F || base == KEPT_R32F ? "precision depends on the height above the reference"
				: offset == KEPT_R8 || offset == KEPT_R16 ? "offsets beyond 0.5 m are cut off"
				: offset == KEPT_R16F || offset == KEPT_R32F ? "precision depends on the depth"
									     : "precision ok";
	snprintf(text + length, sizeof text - (size_t)length, ", %s", precision);
	return text;
}

static void print(const struct row *row)
{
	const struct accuracy_figures *figures = &row->figures;
	double sorted[RUNS], p99[RUNS];
	memcpy(sorted, row->ms, sizeof sorted);
	memcpy(p99, row->p99, sizeof p99);
	double ms = bench_median(sorted, (size_t)runs);
	int64_t bytes = strncmp(row->bytes_of, "base", 4) == 0 ? figures->base_bytes : figures->slot_bytes;
	printf("{\"bench\": \"accuracy\", \"study\": \"%s\", \"knobs\": {%s}, \"default\": %s, \"error\": {\"max\": %.7g, \"rms\": %.7g, "
	       "\"volume\": %.7g, \"volume_abs\": %.7g}, \"ms_step\": %.5g, \"ms_second\": %.5g, ",
	       row->study, row->knobs, row->is_default ? "true" : "false", figures->error.max, figures->error.rms,
	       figures->error.volume, figures->error.volume_abs, ms, ms / figures->time_step);
	if (!row->is_variant)
		printf("\"p99\": %.5g, \"store_bytes\": %lld, ", bench_median(p99, (size_t)runs),
		       (long long)(figures->base_bytes + figures->plane_bytes));
	else
		printf("\"post_bytes\": %zu, \"beside\": {\"max\": %.7g, \"rms\": %.7g, \"volume\": %.7g}, \"drift_after_%d\": %.4g, "
		       "\"laws\": \"%s\", ",
		       accuracy_format_bytes(row->variant.base) + accuracy_format_bytes(row->variant.offset), row->beside.max,
		       row->beside.rms, row->beside.volume, PASSES, row->drift_after, laws(row));
	if (deform_conserves(row->drive.model))
		printf("\"drift\": %.4g, ", figures->drift);
	printf("\"awake\": %lld, \"bytes\": %lld, \"bytes_of\": \"%s\", \"steps\": %lld, \"gl\": \"%s\"}\n",
	       (long long)figures->awake, (long long)bytes, row->bytes_of, (long long)figures->steps, figures->gl);
	fflush(stdout);
}

/* The first round warms, and its ground is what is compared; then all take turns. */
static void measure(struct study *study)
{
	for (size_t i = 0; i < study->count; i++) {
		struct row *row = &study->rows[i];
		fprintf(stderr, "%s {%s}\n", row->study, row->knobs);
		run_row(row, &truth, &row->figures);
		if (row->is_variant)
			measure_beside(row);
	}
	for (int run = 0; run < runs; run++)
		for (size_t i = 0; i < study->count; i++) {
			struct accuracy_figures figures;
			run_row(&study->rows[i], NULL, &figures);
			study->rows[i].ms[run] = figures.ms_step;
			study->rows[i].p99[run] = figures.p99;
			if (study->rows[i].timed_laps > 1)
				study->rows[i].figures.steps = figures.steps;
		}
	for (size_t i = 0; i < study->count; i++)
		print(&study->rows[i]);
}

/* --- whether the figures can be true --- */

static void doubt(const char *what, ...)
{
	va_list arguments;
	va_start(arguments, what);
	fputs("bench_accuracy: the figures cannot be true: ", stderr);
	vfprintf(stderr, what, arguments);
	fputc('\n', stderr);
	va_end(arguments);
	doubtful = true;
}

/* Of rows that go from coarse to fine, the last is the nearest to the truth. */
static void judge_finest(const struct row *rows, size_t count)
{
	for (size_t i = 0; i + 1 < count; i++)
		if (!(rows[count - 1].figures.error.rms < rows[i].figures.error.rms))
			doubt("%s: the error of {%s} is not below that of {%s}", rows[i].study, rows[count - 1].knobs, rows[i].knobs);
}

/* Rows that must leave the same ground, bit for bit. */
static void judge_same(const struct study *study, const char *law)
{
	for (size_t i = 1; i < study->count; i++)
		if (study->rows[i].figures.hash != study->rows[0].figures.hash || study->rows[i].figures.rows != study->rows[0].figures.rows)
			doubt("%s: {%s} and {%s} differ, against %s", study->rows[i].study, study->rows[i].knobs, study->rows[0].knobs, law);
}

/* The lattice, which comes last, loses nothing that another format keeps. Rounding may help another by chance, by less than
 * the heights of the store are off themselves. */
static void judge_lattice(const struct study *study)
{
	const struct row *lattice = &study->rows[study->count - 1];
	for (size_t i = 0; i + 1 < study->count; i++)
		if (lattice->figures.error.rms > study->rows[i].figures.error.rms + ACCURACY_IMPORT_ERROR / 10)
			doubt("%s: {%s} is nearer to the truth than the lattice", lattice->study, study->rows[i].knobs);
	if (lattice->figures.drift != 0 || lattice->drift_after != 0)
		doubt("%s: on the lattice the volume drifts", lattice->study);
	struct row product = *lattice;
	product.is_variant = false;
	run_row(&product, &truth, &product.figures);
	if (product.figures.hash != lattice->figures.hash)
		doubt("%s: what the variants drive is not what the product drives", lattice->study);
}

/* --- the studies --- */

static void spacing(struct study *study)
{
	static const enum deform_model models[] = {DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SLIPPAGE, DEFORM_SCM};
	enum { EACH = 7 };
	for (size_t m = 0; m < sizeof models / sizeof models[0]; m++)
		for (int k = 0; k < EACH; k++) {
			double apart_m = ldexp(1, -k);
			bool own = apart_m == ACCURACY_OWN && models[m] == DEFORM_SLIPPAGE;
			struct row *row = add(study, "spacing", own, "\"spacing\": %.9g, \"model\": \"%s\"", apart_m,
					      accuracy_model_name(models[m]));
			row->drive.model = models[m];
			row->drive.spacing = apart_m;
		}
	measure(study);
	/* Not slippage: soil slides a post an iteration, so with as many iterations it comes less far. See `settled`. */
	for (size_t m = 0; m < sizeof models / sizeof models[0]; m++)
		if (models[m] != DEFORM_SLIPPAGE)
			judge_finest(&study->rows[m * EACH], EACH);
	for (size_t i = 0; i < study->count; i++)
		if (deform_conserves(study->rows[i].drive.model) && study->rows[i].figures.drift != 0)
			doubt("spacing: {%s}: the volume drifts", study->rows[i].knobs);
}

/* As much sliding as the spacing asks for: so many times the iterations as its square falls. */
static void settled(struct study *study)
{
	for (int k = 3; k <= 6; k++) {
		double apart_m = ldexp(1, -k), every = 0.032 * ldexp(1, -2 * (k - 3));
		struct row *row = add(study, "settled", false, "\"spacing\": %.9g, \"iterations\": 8, \"interval\": %.9g", apart_m, every);
		row->drive.spacing = apart_m;
		row->drive.interval = every;
		set(row, "redistribute.iterations", 8);
		set(row, "redistribute.interval", every);
	}
	int all = runs;
	runs = 1; /* the longest there are */
	measure(study);
	runs = all;
	judge_finest(study->rows, study->count);
}

static void base_format(struct study *study)
{
	for (int format = 0; format < KEPT_FORMATS; format++) {
		struct row *row = add(study, "base_format", format == KEPT_R32I, "\"base_format\": \"%s\"",
				      accuracy_format_name((enum accuracy_format)format));
		keep_in(row, (enum accuracy_format)format, KEPT_R32I);
	}
	measure(study);
	judge_lattice(study);
}

static void offset_format(struct study *study)
{
	for (int format = 0; format < KEPT_FORMATS; format++) {
		struct row *row = add(study, "offset_format", format == KEPT_R32I, "\"offset_format\": \"%s\"",
				      accuracy_format_name((enum accuracy_format)format));
		keep_in(row, KEPT_R32I, (enum accuracy_format)format);
	}
	measure(study);
	judge_lattice(study);
}

static void iterations(struct study *study)
{
	for (int count = 1; count <= 8; count *= 2)
		set(add(study, "iterations", count == 1, "\"iterations\": %d", count), "redistribute.iterations", count);
	measure(study);
}

static void interval(struct study *study)
{
	static const double values[] = {0.01, 0.02, 0.05, 0.1, 0.2};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = add(study, "interval", values[i] == 0.05, "\"interval\": %g", values[i]);
		row->drive.interval = values[i];
		set(row, "redistribute.interval", values[i]);
	}
	measure(study);
}

static void time_step(struct study *study)
{
	static const double values[] = {0.1, 0.02, 0.005, 0.001};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = add(study, "time_step", values[i] == 0.02, "\"time_step\": %g", values[i]);
		row->drive.time_step = values[i];
		set(row, "time_step", values[i]);
	}
	measure(study);
	judge_same(study, "law 10");
}

static void import_error(struct study *study)
{
	static const double values[] = {0, 0.001, 0.01, 0.1, 0.5, 1};
	for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
		struct row *row = add(study, "import_error", values[i] == ACCURACY_IMPORT_ERROR, "\"import_error\": %g", values[i]);
		row->drive.max_error = values[i];
		row->bytes_of = "base tiles in the store, all levels";
	}
	measure(study);
}

static void forces(struct study *study)
{
	for (int delay = 0; delay <= 2; delay += 2) {
		struct row *row = add(study, "forces", delay == 2, "\"model\": \"scm\", \"forces\": 50, \"delay\": %d", delay);
		row->drive.model = DEFORM_SCM;
		set(row, "output.forces", 50);
		set(row, "output.delay", delay);
	}
	measure(study);
	judge_same(study, "rows being the same however late");
	if (study->rows[0].figures.rows == 0)
		doubt("forces: no rows were written");
}

static void durability(struct study *study)
{
	for (int full = 0; full < 2; full++) {
		struct row *row = add(study, "durability", full == 0, "\"durable\": \"%s\", \"laps\": %d", full ? "full" : "normal", LAPS);
		row->drive.durable_full = full == 1;
		row->drive.spacing = ACCURACY_OWN;
		row->timed_laps = LAPS;
	}
	measure(study);
	judge_same(study, "durability being no part of the ground");
}

static void pairs(struct study *study)
{
	static const double errors[] = {0.001, 0.01, 0.1};
	static const enum accuracy_format kept[] = {KEPT_R8, KEPT_R16F, KEPT_R32I};
	for (int k = 3; k <= 5; k++)
		for (int i = 0; i < 9; i++) {
			double apart_m = ldexp(1, -k);
			bool own = apart_m == ACCURACY_OWN;
			struct row *row;
			if (i < 3) {
				int count = i == 0 ? 1 : i == 1 ? 4 : 8;
				row = add(study, "pairs", own && count == 1, "\"spacing\": %.9g, \"iterations\": %d", apart_m, count);
				set(row, "redistribute.iterations", count);
			} else if (i < 6) {
				row = add(study, "pairs", own && kept[i - 3] == KEPT_R32I, "\"spacing\": %.9g, \"offset_format\": \"%s\"",
					  apart_m, accuracy_format_name(kept[i - 3]));
			} else {
				row = add(study, "pairs", own && i == 6, "\"spacing\": %.9g, \"import_error\": %g", apart_m, errors[i - 6]);
				row->drive.max_error = errors[i - 6];
				row->bytes_of = "base tiles in the store, all levels";
			}
			row->drive.spacing = apart_m;
			if (i >= 3 && i < 6)
				keep_in(row, KEPT_R32I, kept[i - 3]);
		}
	measure(study);
}

static const struct {
	const char *name;
	void (*run)(struct study *study);
} studies[] = {
	{"spacing", spacing},       {"settled", settled},           {"base_format", base_format}, {"offset_format", offset_format},
	{"iterations", iterations}, {"interval", interval},         {"time_step", time_step},     {"import_error", import_error},
	{"forces", forces},         {"durability", durability},     {"pairs", pairs},
};
#define STUDIES (sizeof studies / sizeof studies[0])

int main(int argc, char **argv)
{
	const char *path = NULL;
	bool asked[STUDIES] = {false}, any = false;
	for (int i = 1; i < argc; i++) {
		size_t at = 0;
		while (at < STUDIES && strcmp(argv[i], studies[at].name) != 0)
			at++;
		if (at < STUDIES)
			asked[at] = any = true;
		else if (strcmp(argv[i], "--quick") == 0)
			runs = QUICK_RUNS;
		else if (strcmp(argv[i], "--truth") == 0 && i + 1 < argc)
			path = argv[++i];
		else
			bench_must(fail_with(STATUS_USAGE, "bench_accuracy: %s: no study goes by that name; see the file's opening", argv[i]));
	}
	accuracy_truth_open(&truth, path);
	struct study study = {.rows = mem_calloc(ROWS_MOST, sizeof *study.rows)};
	if (study.rows == NULL)
		bench_must(fail_memory("bench"));
	for (size_t i = 0; i < STUDIES; i++)
		if (!any || asked[i]) {
			study.count = 0;
			studies[i].run(&study);
		}
	mem_free(study.rows);
	accuracy_truth_close(&truth);
	return doubtful ? 1 : 0;
}
