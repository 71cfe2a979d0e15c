/* Integrals of smooth functions, for the closed forms. No state: any thread. */
#ifndef FURROW_DEFORM_REFERENCE_QUADRATURE_H
#define FURROW_DEFORM_REFERENCE_QUADRATURE_H

#define QUADRATURE_MOST 8 /* values that are integrated at once */

/* Sets values[0 .. QUADRATURE_MOST - 1] to the function's at `at`; those it does not use must be 0. */
typedef void (*quadrature_function)(const void *user, double at, double *values);

/*
 * Adds to sums[i] the integral of values[i] from `from` to `to`. The function is never asked at an end.
 * tolerance: the absolute error that is allowed, in the units of values x at, for each value.
 * Method: Gauss and Kronrod's rule of 7 and 15 points (QUADPACK, Piessens et al. 1983), halved until the two agree.
 * A piece 2^-30 of the whole is taken as it is. A jump costs 1e-9 of its height x the way at most; a root at an end less.
 */
void quadrature_add(quadrature_function function, const void *user, double from, double to, double tolerance, double *sums);

#endif
