/* Small dense systems of linear equations. */
#ifndef FURROW_VEHICLE_LINEAR_H
#define FURROW_VEHICLE_LINEAR_H

#include <stdbool.h>
#include <stddef.h>

/* Solves a x = b by elimination with pivots. `a`: n x n, row by row; changed. `b` becomes x. Returns false if a pivot is 0 or no
 * finite number. */
bool vehicle_solve(double *a, double *b, size_t n);

/* Factors a symmetric positive matrix in place, L L^T; `a`: n x n, row by row, its lower triangle. Returns false if it is not
 * positive. */
bool vehicle_factor(double *a, size_t n);
/* Solves L L^T x = b. `b` becomes x. */
void vehicle_solve_factored(const double *a, double *b, size_t n);

#define VEHICLE_ABREAST 12 /* matrices that are made negative together */
/* Makes 6 x 6 matrices symmetric, each as the mean of it and its transpose, and takes away what is not negative of it. Eigenvalues above 0
 * become 0. count: at most VEHICLE_ABREAST. Each becomes the same as it would alone. */
void vehicle_make_negative(double (*const list[])[6], size_t count);

#endif
