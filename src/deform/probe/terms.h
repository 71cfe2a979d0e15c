/* Sums of products of six numbers by six: how a matrix of a probe is put together. Sums are of four lanes, so their order is fixed. */
#ifndef FURROW_DEFORM_PROBE_TERMS_H
#define FURROW_DEFORM_PROBE_TERMS_H

#define TERMS_MOST 128
#define TERMS_LANES 4

struct terms {
	double columns[6][TERMS_MOST], rows[6][TERMS_MOST];
	int count;
	double matrix[6][6]; /* of the terms that were added up */
};

void deform_terms_add_up(struct terms *terms);

/* Adds a column times a row. */
static inline void terms_put(struct terms *terms, const double column[6], const double row[6])
{
	if (terms->count == TERMS_MOST)
		deform_terms_add_up(terms);
	for (int k = 0; k < 6; k++) {
		terms->columns[k][terms->count] = column[k];
		terms->rows[k][terms->count] = row[k];
	}
	terms->count++;
}

#endif
