/* Adds up the terms of a probe's matrices, several at a time. */
#include "deform/probe/terms.h"

void deform_terms_add_up(struct terms *terms)
{
	for (; terms->count % TERMS_LANES != 0; terms->count++)
		for (int k = 0; k < 6; k++)
			terms->columns[k][terms->count] = terms->rows[k][terms->count] = 0;
	for (int i = 0; i < 6; i++) {
		double sums[6][TERMS_LANES] = {{0}};
		for (int n = 0; n < terms->count; n += TERMS_LANES)
			for (int k = 0; k < 6; k++)
				for (int lane = 0; lane < TERMS_LANES; lane++)
					sums[k][lane] += terms->columns[i][n + lane] * terms->rows[k][n + lane];
		for (int k = 0; k < 6; k++)
			terms->matrix[i][k] += (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]);
	}
	terms->count = 0;
}
