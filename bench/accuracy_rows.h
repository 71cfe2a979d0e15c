/* Rows of bench_accuracy: made by the studies, measured in turn, printed, and doubted. */
#ifndef FURROW_ACCURACY_ROWS_H
#define FURROW_ACCURACY_ROWS_H

#include "accuracy.h"

enum { ACCURACY_RUNS = 5, ACCURACY_ROWS = 64, ACCURACY_SETTINGS = 4, ACCURACY_PASSES = 5 };

struct row {
	const char *study;
	char knobs[128];           /* JSON, without its braces */
	bool is_default;
	bool of_base;              /* its bytes are the base's in the store, not the slots' */
	char values[ACCURACY_SETTINGS][32];
	struct scene_setting settings[ACCURACY_SETTINGS];
	struct accuracy_drive drive;
	bool is_variant;
	struct accuracy_variant variant;
	int timed_laps;            /* of a drive that has to be long to show something */
	struct accuracy_figures figures;
	double drift_after;        /* a variant: ACCURACY_PASSES passes */
	struct accuracy_error beside;
	double ms[ACCURACY_RUNS], p99[ACCURACY_RUNS], worst[ACCURACY_RUNS];
};

struct study {
	const struct accuracy_truth *truth;
	struct row *rows; /* ACCURACY_ROWS of them */
	size_t count;
	int runs;         /* timed ones of each */
	bool quick;
	bool doubtful;    /* a figure cannot be true */
};

/* A row in which all is at its default but what the caller then changes. */
struct row *row_add(struct study *study, const char *name, bool is_default, const char *knobs, ...)
	__attribute__((format(printf, 4, 5)));
/* One of the scene's keys. */
void row_set(struct row *row, const char *key, double value);
/* Its slots are kept in these formats: a variant of what its drive is by now. */
void row_keep(struct row *row, enum accuracy_format base, enum accuracy_format offset);

/* Measures all rows and prints them. */
void rows_measure(struct study *study);

/* --- whether the figures can be true: says what cannot --- */
/* Of rows that go from coarse to fine, the last is the nearest to the truth. */
void judge_finest(struct study *study, size_t first, size_t count);
/* Rows that must leave the same ground, bit for bit, and say the same of forces. */
void judge_same(struct study *study, const char *law);
/* The lattice, which comes last, loses nothing that another format keeps, and drives what the product drives. */
void judge_lattice(struct study *study);
/* The volume is constant, to the last bit. */
void judge_volume(struct study *study);
void judge_doubt(struct study *study, const char *what, ...) __attribute__((format(printf, 2, 3)));

#endif
