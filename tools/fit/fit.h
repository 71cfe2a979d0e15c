/*
 * fit: a soil's numbers from its tests in the field or the laboratory, by least squares. Part of the command, not of the library.
 *
 *   plates of several widths, pressed into the soil     p = (kc / b + kphi) z^n                              Bekker 1969
 *   a shear ring or plate under several normal stresses tau = (c + sigma tan phi) (1 - exp(-j / K))          Janosi and Hanamoto 1961
 *   a level plate pushed straight down, slowly          p = 0.87574 xi_n z                                   Agarwal, Goldman and Kamrin 2023
 *
 * All functions may be called on any thread. SI units: m, Pa, radians.
 */
#ifndef FURROW_TOOLS_FIT_H
#define FURROW_TOOLS_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"

/* --- table.c: rows of a test from a CSV file --- */

enum { FIT_ROWS_MOST = 1000000, FIT_GROUPS_MOST = 64 };
enum fit_test { FIT_PLATE, FIT_SHEAR, FIT_PENETRATION };

struct fit_row {
	double group; /* width b of a plate, m; normal stress sigma of a shear test, Pa; area of a penetrating plate, m2, 0 where it has no column */
	double x;     /* sinkage z, m, displacement j, m, or depth, m; above 0 */
	double y;     /* pressure p, Pa, or shear stress tau, Pa; at least 0. Of a penetration: pressure, Pa, or force, N */
	int line;     /* of the file */
};

struct fit_table {
	const char *path; /* owned by the caller */
	bool is_force;    /* y of a penetration is a force */
	struct fit_row *rows;
	size_t count;
	size_t skipped; /* rows where x is 0: they say nothing about the curve */
	double groups[FIT_GROUPS_MOST]; /* the different values of `group`, rising */
	size_t group_count;
};

/*
 * Reads a CSV file. Its first line names the columns with their units, as `plate width b mm, sinkage z mm, pressure p kPa`. A line that begins
 * with # and an empty line are passed over. STATUS_INPUT names file and line: no such column, no unit, no number, a number below 0.
 */
enum status fit_table_read(const char *path, enum fit_test test, struct fit_table *out) FURROW_CHECKED;
void fit_table_finish(struct fit_table *table); /* all zero is allowed */
/* Returns the index of a row's group. */
size_t fit_table_group(const struct fit_table *table, const struct fit_row *row);
/* What the columns are called, for messages and --help: "plate width b m, sinkage z m, pressure p Pa". */
const char *fit_table_columns(enum fit_test test);

/* --- least_squares.c --- */

enum { FIT_NUMBERS = 3 };

struct fit_problem {
	size_t count;  /* of residuals */
	bool fixed[FIT_NUMBERS]; /* these keep the value that they begin with */
	void *user;
	/* Gives residual i at the numbers x, and its derivatives by them. Returns false if the model has no value there. */
	bool (*residual)(void *user, size_t i, const double x[FIT_NUMBERS], double *r, double d[FIT_NUMBERS]);
};

struct fit_solution {
	double x[FIT_NUMBERS];
	double sum;                                 /* of squared residuals */
	double covariance[FIT_NUMBERS][FIT_NUMBERS]; /* of x: sum / (count - free numbers) times the inverse of J'J. 0 for fixed ones */
	int iterations;
	bool determined; /* false: the residuals do not tell the numbers apart, and there is no covariance */
};

/* Levenberg's and Marquardt's method from solution->x on. Returns false if the model has no value at the beginning. */
bool fit_least_squares(const struct fit_problem *problem, struct fit_solution *solution);
/* Solves A x = b for a symmetric positive A. Returns false if it is singular to 13 digits. */
bool fit_solve(double a[FIT_NUMBERS][FIT_NUMBERS], const double b[FIT_NUMBERS], double x[FIT_NUMBERS]);

/* --- plates.c, shear.c --- */

struct fit_number {
	double value, error; /* standard error; NaN: it was not fitted */
};

/* How well a curve goes through its rows. */
struct fit_quality {
	size_t rows;
	double rms, largest; /* of measured - fitted, Pa */
	int largest_line;
	double goodness;     /* 1 - rms / mean, with count - 2 in the place of the count: Wong 1980. 1: through every row */
};

enum fit_method { FIT_PLAIN, FIT_WONG, FIT_METHODS };

struct fit_curve { /* of one plate alone, by Wong's formulas */
	double k, n;
	struct fit_quality quality;
};

struct fit_plates {
	bool one_width; /* kc is 0 then, and kphi is k of that width */
	bool no_kphi;   /* it would be below 0, so it is 0 */
	struct fit_number kc[FIT_METHODS], kphi[FIT_METHODS], n[FIT_METHODS]; /* N/m^(n+1), N/m^(n+2), 1 */
	struct fit_quality quality[FIT_METHODS];
	struct fit_curve curves[FIT_GROUPS_MOST];
};
/* STATUS_INPUT: too few rows, or they do not tell the numbers apart. */
enum status fit_plates(const struct fit_table *table, struct fit_plates *out) FURROW_CHECKED;
double fit_pressure(const struct fit_plates *fit, enum fit_method method, double b, double z);

struct fit_shear {
	bool one_stress;        /* there is one normal stress: c is taken for 0, or if the stress is 0, phi */
	bool no_cohesion, no_friction; /* it would be below 0, so it is 0 */
	struct fit_number cohesion, friction, shear; /* Pa, radians, m */
	struct fit_quality quality;
};
enum status fit_shear(const struct fit_table *table, struct fit_shear *out) FURROW_CHECKED;
double fit_shear_stress(const struct fit_shear *fit, double sigma, double j);

/* penetration.c: how strongly a soil presses on faces. The fit of 3D-RFT for dry soil without cohesion has pressure in proportion to depth. */
#define FIT_LEVEL_PLATE 0.87574 /* pressure / (xi_n x depth) of a level plate that moves straight down: S. Agarwal, D. I. Goldman, K. Kamrin, PNAS 120 (2023), SI */

struct fit_penetration {
	struct fit_number strength;       /* xi_n, N/m3: the least squares of pressure through the origin */
	struct fit_number slope, offset;  /* the same with an offset, N/m3 and Pa, as of soil with cohesion: a check of the model */
	struct fit_quality quality;       /* of the first */
	struct fit_number alone[FIT_GROUPS_MOST]; /* xi_n of each area alone, N/m3; the error is NaN where it has one row */
};
/* Divides forces by the area of their row or, where that is 0, by `area`, m2; 0: none was given. The table has pressures then, and areas. STATUS_INPUT: there is
 * no area, or both are given. */
enum status fit_penetration_pressures(struct fit_table *table, double area) FURROW_CHECKED;
/* table: pressures. STATUS_INPUT: there are fewer than 3 rows, or they are of one depth, or they grow not with it. */
enum status fit_penetration(const struct fit_table *table, struct fit_penetration *out) FURROW_CHECKED;

/* quality.c: adds up how well a curve goes through its rows. Begin with all zero, then each row, then the end. */
struct fit_sums {
	double squares, sum;
	struct fit_quality quality;
};
void fit_sums_add(struct fit_sums *sums, const struct fit_row *row, double model);
struct fit_quality fit_sums_end(const struct fit_sums *sums);

#endif
