/* By how much heights are off others, summed up over posts. Pure functions. */
#ifndef FURROW_BASE_MISFIT_H
#define FURROW_BASE_MISFIT_H

#include <math.h>
#include <stdint.h>

struct misfit {
	int64_t posts;   /* compared so far; holes are not */
	double greatest; /* metres; 0 without posts */
	double squares;  /* sum of squares, m2 */
};

static inline void misfit_add_post(struct misfit *misfit, double off)
{
	misfit->posts++;
	misfit->greatest = fabs(off) > misfit->greatest ? fabs(off) : misfit->greatest;
	misfit->squares += off * off;
}

static inline void misfit_add(struct misfit *misfit, const struct misfit *more)
{
	misfit->posts += more->posts;
	misfit->greatest = more->greatest > misfit->greatest ? more->greatest : misfit->greatest;
	misfit->squares += more->squares;
}

/* Returns the root of the mean square, metres; 0 without posts. */
static inline double misfit_rms(const struct misfit *misfit)
{
	return misfit->posts > 0 ? sqrt(misfit->squares / (double)misfit->posts) : 0;
}

#endif
