/*
 * The bands of one contact as strips of posts, and the weights of these posts. Inside of src/soil/laying.
 *
 * A strip is a part of a band that gives its soil to one face. In the body's frame it is a rectangle, so its posts in a row are one run. Around
 * the patch there is one strip, whose runs are all posts of a row. Strips share no post. All numbers are whole.
 */
#ifndef FURROW_SOIL_STRIPS_H
#define FURROW_SOIL_STRIPS_H

#include "soil/laying/laying.h"

#define STRIPS_MOST 8
#define STRIP_FAR_MOST 100 /* posts: more than the widest band reaches, and a multiple of 4 */

/* Where soil may be laid, and where its weights are kept. Rows and columns count from the first post of `written`. */
struct laying_field {
	const struct soil_laying *laying;
	const uint8_t *contact, *patch; /* of the first post of `written` */
	const int32_t *base;
	size_t stride;           /* posts in a row of the planes */
	int64_t x0, y0;          /* the first post of `written` */
	int width, height;       /* of `written` */
	int32_t rectangle[4];    /* around the patch, in the frame: most and least x, most and least y */
	int32_t band;            /* its width, 2^-6 post */
	uint16_t *weights;       /* width x height; only runs are ever written or read */
	int16_t *apart;          /* distances around a patch, and rows that finding them takes: soil_lay_scratch */
};

/* The posts of a strip in a row: from `first` on; count 0: none. */
struct strip_run {
	int32_t first, count;
};

struct strip {
	int face;
	int axis;                /* of the frame, across the strip: 0: x, 1: y */
	int sign;                /* 1: the distance from the patch grows with it; -1: it falls */
	int32_t edge;            /* where the patch's rectangle ends */
	int32_t low[2], high[2]; /* of the strip in the frame, both included */
	int first_row, rows;
	struct strip_run *runs;  /* of each of these rows */
	uint64_t sum;            /* of all weights */
	uint32_t heaviest;       /* weight, 0: no post has one */
	int heaviest_row;        /* the last row that has such a post */
};

/* Finds the rectangle around the patch and the width of the band. */
void soil_strip_band(struct laying_field *field, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES]);
/* Finds the strips beside the faces, at most STRIPS_MOST. Strips of one face come in the order of their posts in a row. Returns how many. */
int soil_strips(const struct laying_field *field, struct strip strips[STRIPS_MOST]);
/* Weighs a strip beside a face: fills its runs, weights and sums. runs: room for field->height of them. */
void soil_strip_beside(const struct laying_field *field, struct strip *strip, struct strip_run *runs);
/* Lays what the body pushes ahead of the front that pushes. offset, carried: of the first post of `written`. Returns how much it laid: the
 * rest finds no room there. left: which share of that flows off to the left. result: its `posts` in rows and columns of the field. */
int64_t soil_lay_front(const struct laying_field *field, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES],
		       const int32_t *offset, const int32_t *carried, void *scratch, int32_t *deposits, struct soil_lay_result *result, double *left);
size_t soil_front_scratch(size_t width, size_t height);
/* Makes and weighs the strip around the patch. */
void soil_strip_around(const struct laying_field *field, const struct soil_measured *measured, struct strip *strip, struct strip_run *runs);

/* Takes the sum and the largest weight of the next row of a strip. Rows come from south to north. */
static inline void strip_add_row(struct strip *strip, int row, uint32_t sum, uint32_t heaviest)
{
	strip->sum += sum;
	if (heaviest > 0 && heaviest >= strip->heaviest) {
		strip->heaviest = heaviest;
		strip->heaviest_row = row;
	}
}

#endif
