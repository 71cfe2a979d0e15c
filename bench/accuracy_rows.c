/*
 * Rows of bench_accuracy. A row's first run is with the truth: to rest, and compared; it warms too. The timed runs come
 * after it, those of all rows of the study in turn, so that what else the machine does falls on all alike.
 */
#include "accuracy_rows.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"

struct row *row_add(struct study *study, const char *name, bool is_default, const char *knobs, ...)
{
	va_list arguments;
	if (study->count == ACCURACY_ROWS)
		bench_must(fail_with(STATUS_FAILED, "bench: a study has more rows than expected; raise ACCURACY_ROWS"));
	struct row *row = &study->rows[study->count++];
	*row = (struct row){
		.study = name,
		.is_default = is_default,
		.timed_laps = 1,
		.drive = {.model = DEFORM_SLIPPAGE, .spacing = ACCURACY_OWN, .max_error = ACCURACY_IMPORT_ERROR, .time_step = 0.02,
			  .interval = 0.05, .laps = 1},
	};
	va_start(arguments, knobs);
	vsnprintf(row->knobs, sizeof row->knobs, knobs, arguments);
	va_end(arguments);
	return row;
}

void row_set(struct row *row, const char *key, double value)
{
	size_t at = row->drive.setting_count++;
	snprintf(row->values[at], sizeof row->values[at], "%.9g", value);
	row->settings[at] = (struct scene_setting){key, row->values[at]};
}

void row_keep(struct row *row, enum accuracy_format base, enum accuracy_format offset)
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

static void measure_beside(const struct study *study, struct row *row)
{
	struct accuracy_variant lattice = row->variant;
	struct accuracy_figures plain, repeated;
	lattice.base = lattice.offset = KEPT_R32I;
	accuracy_variant(&lattice, study->truth, &plain);
	row->beside = apart(&row->figures.surface, &plain.surface);
	mem_free(plain.surface.heights);
	mem_free(row->figures.surface.heights);
	row->figures.surface.heights = NULL;
	struct accuracy_variant often = row->variant;
	often.passes = ACCURACY_PASSES;
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
				   row->figures.drift, ACCURACY_PASSES, row->drift_after);
	const char *precision = base == KEPT_R8 || base == KEPT_R16 ? "precision depends on the terrain's relief"
				: base == KEPT_R16F || base == KEPT_R32F ? "precision depends on the height above the reference"
				: offset == KEPT_R8 || offset == KEPT_R16 ? "offsets beyond 0.5 m are cut off"
				: offset == KEPT_R16F || offset == KEPT_R32F ? "precision depends on the depth"
									     : "precision ok";
	snprintf(text + length, sizeof text - (size_t)length, ", %s", precision);
	return text;
}

static double median(const double *values, int count)
{
	double sorted[ACCURACY_RUNS];
	memcpy(sorted, values, (size_t)count * sizeof *sorted);
	return bench_median(sorted, (size_t)count);
}

static void print(const struct row *row, int runs)
{
	const struct accuracy_figures *figures = &row->figures;
	double ms = median(row->ms, runs);
	int64_t bytes = row->of_base ? figures->base_bytes : figures->slot_bytes;
	printf("{\"bench\": \"accuracy\", \"study\": \"%s\", \"knobs\": {%s}, \"default\": %s, \"truth\": \"%s in doubles, posts of 1/64 m\", \"ms_runs\": [",
	       row->study, row->knobs, row->is_default ? "true" : "false", accuracy_model_name(row->drive.model));
	for (int run = 0; run < runs; run++)
		printf("%s%.5g", run > 0 ? ", " : "", row->ms[run]);
	printf("], "
	       "\"error\": {\"max\": %.7g, \"rms\": %.7g, \"volume\": %.7g, \"volume_abs\": %.7g}, \"ms_step\": %.5g, \"ms_second\": %.5g, ",
	       figures->error.max, figures->error.rms,
	       figures->error.volume, figures->error.volume_abs, ms, ms / figures->time_step);
	if (!row->is_variant)
		printf("\"p99\": %.5g, \"worst\": %.5g, \"store_bytes\": %lld, ", median(row->p99, runs),
		       median(row->worst, runs), (long long)(figures->base_bytes + figures->plane_bytes));
	else
		printf("\"post_bytes\": %zu, \"beside\": {\"max\": %.7g, \"rms\": %.7g, \"volume\": %.7g}, \"drift_after_%d\": %.4g, "
		       "\"laws\": \"%s\", ",
		       accuracy_format_bytes(row->variant.base) + accuracy_format_bytes(row->variant.offset), row->beside.max,
		       row->beside.rms, row->beside.volume, ACCURACY_PASSES, row->drift_after, laws(row));
	if (deform_conserves(row->drive.model))
		printf("\"drift\": %.4g, ", figures->drift);
	printf("\"awake\": %lld, \"bytes\": %lld, \"bytes_of\": \"%s\", \"steps\": %lld, \"gl\": \"%s\"}\n",
	       (long long)figures->awake, (long long)bytes,
	       row->of_base ? "base tiles in the store, all levels" : "slot planes of the tiles touched",
	       (long long)figures->steps, figures->gl);
	fflush(stdout);
}

/* The first round warms, and its ground is what is compared; then all take turns. */
void rows_measure(struct study *study)
{
	for (size_t i = 0; i < study->count; i++) {
		struct row *row = &study->rows[i];
		fprintf(stderr, "%s {%s}\n", row->study, row->knobs);
		run_row(row, study->truth, &row->figures);
		if (row->is_variant)
			measure_beside(study, row);
	}
	for (int run = 0; run < study->runs; run++)
		for (size_t i = 0; i < study->count; i++) {
			struct accuracy_figures figures;
			run_row(&study->rows[i], NULL, &figures);
			study->rows[i].ms[run] = figures.ms_step;
			study->rows[i].p99[run] = figures.p99;
			study->rows[i].worst[run] = figures.worst;
			if (study->rows[i].timed_laps > 1)
				study->rows[i].figures.steps = figures.steps;
		}
	for (size_t i = 0; i < study->count; i++)
		print(&study->rows[i], study->runs);
}

/* --- whether the figures can be true --- */

void judge_doubt(struct study *study, const char *what, ...)
{
	va_list arguments;
	va_start(arguments, what);
	fputs("bench_accuracy: the figures cannot be true: ", stderr);
	vfprintf(stderr, what, arguments);
	fputc('\n', stderr);
	va_end(arguments);
	study->doubtful = true;
}

void judge_finest(struct study *study, size_t first, size_t count)
{
	const struct row *rows = study->rows + first;
	const struct row *finest = rows + count - 1;
	for (const struct row *row = rows; row < finest; row++)
		if (!(finest->figures.error.rms < row->figures.error.rms))
			judge_doubt(study, "%s: the error of {%s} is not below that of {%s}", row->study, finest->knobs, row->knobs);
}

void judge_same(struct study *study, const char *law)
{
	const struct row *first = study->rows;
	for (const struct row *row = first + 1; row < first + study->count; row++)
		if (row->figures.hash != first->figures.hash || row->figures.rows != first->figures.rows)
			judge_doubt(study, "%s: {%s} and {%s} differ, against %s", row->study, row->knobs, first->knobs, law);
}

/*
 * Rounding moves the ground, mostly by turning which of two equal slopes slides first, and may bring it nearer to the truth by
 * chance: by a small part of what it moved (here at most 0.16 of it), since it knows nothing of what the spacing lost.
 */
void judge_lattice(struct study *study)
{
	const struct row *lattice = &study->rows[study->count - 1];
	for (size_t i = 0; i + 1 < study->count; i++)
		if (lattice->figures.error.rms > study->rows[i].figures.error.rms + ACCURACY_IMPORT_ERROR / 10 + study->rows[i].beside.rms / 4)
			judge_doubt(study, "%s: {%s} is nearer to the truth than the lattice", lattice->study, study->rows[i].knobs);
	for (size_t i = 0; i + 1 < study->count; i++) {
		const struct accuracy_variant *of = &study->rows[i].variant;
		bool exact = (of->base == KEPT_R32F || of->base == KEPT_R32I) && (of->offset == KEPT_R32F || of->offset == KEPT_R32I);
		if (!exact && study->rows[i].beside.max == 0)
			judge_doubt(study, "%s: {%s} lost nothing", lattice->study, study->rows[i].knobs);
	}
	if (lattice->figures.drift != 0 || lattice->drift_after != 0)
		judge_doubt(study, "%s: on the lattice the volume drifts", lattice->study);
	struct row product = *lattice;
	product.is_variant = false;
	run_row(&product, study->truth, &product.figures);
	if (product.figures.hash != lattice->figures.hash)
		judge_doubt(study, "%s: what the variants drive is not what the product drives", lattice->study);
}

void judge_volume(struct study *study)
{
	for (size_t i = 0; i < study->count; i++)
		if (deform_conserves(study->rows[i].drive.model) && study->rows[i].figures.drift != 0)
			judge_doubt(study, "%s: {%s}: the volume drifts", study->rows[i].study, study->rows[i].knobs);
}
