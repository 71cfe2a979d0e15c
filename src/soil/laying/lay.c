/*
 * Lays the soil of a contact: each post of a face gets soil by its weight.
 *
 * A face's soil is divided by the sum of its weights to a rate. A post gets the rate times the sum of weights of its row up to it. The same
 * up to the post before it is taken off. Both are rounded down. What is left goes to the heaviest post of the face; of several to the last
 * one, in rows from south to north. So the sum is exact.
 */
#include <math.h>

#include "soil/laying/strips.h"

#define RATE_BITS 20
#define AMOUNT_MOST (1 << 29) /* fixed-point units: the most soil that a post gets by its weight */
#define REST_MOST (1 << 20)   /* fixed-point units: a larger remainder is refused */

/* What a face gets. */
struct face {
	uint64_t sum;      /* of the weights of its posts */
	uint32_t heaviest; /* of them; 0: the face has no free post */
	int row, column;   /* of the heaviest post */
	int64_t part;      /* its soil */
	int64_t rate;      /* for each unit of weight, 2^-RATE_BITS units */
};

static int64_t amount(int64_t rate, uint64_t weight)
{
	return (int64_t)((uint64_t)rate * weight) >> RATE_BITS;
}

static void find_heaviest(const struct laying_field *field, const struct strip *strip, struct face *face)
{
	const struct strip_run run = strip->runs[strip->heaviest_row - strip->first_row];
	const uint16_t *row = field->weights + (size_t)strip->heaviest_row * (size_t)field->width;
	int column = run.first + run.count - 1;
	while (row[column] != strip->heaviest)
		column--;
	const bool later = strip->heaviest_row > face->row || (strip->heaviest_row == face->row && column > face->column);
	if (strip->heaviest < face->heaviest || (strip->heaviest == face->heaviest && !later))
		return;
	face->heaviest = strip->heaviest;
	face->row = strip->heaviest_row;
	face->column = column;
}

/* Divides the soil between the faces that have free posts. Returns false if there are none. */
static bool divide(const struct soil_laying *laying, int64_t carried, struct face faces[SOIL_FACES])
{
	int64_t rest = carried;
	int most = -1;
	for (int i = 0; i < SOIL_FACES; i++) {
		const bool takes = faces[i].sum > 0;
		faces[i].part = takes ? (carried * laying->shares[i]) >> 16 : 0;
		rest -= faces[i].part;
		most = takes && (most < 0 || laying->shares[i] > laying->shares[most]) ? i : most;
	}
	if (most < 0)
		return false;
	/* A face without a free post leaves its soil to the face with the largest share. */
	faces[most].part += rest;
	for (int i = 0; i < SOIL_FACES; i++) {
		if (faces[i].sum == 0)
			continue;
		const int64_t rate = (int64_t)(((uint64_t)faces[i].part << RATE_BITS) / faces[i].sum);
		const int64_t limit = ((int64_t)AMOUNT_MOST << RATE_BITS) / faces[i].heaviest;
		faces[i].rate = rate < limit ? rate : limit;
	}
	return true;
}

/* Lays a run. sum: of the weights of the row before it, of the same face; returned with those of the run. */
static uint64_t lay_run(const uint16_t *weights, int count, int64_t rate, uint64_t sum, int32_t *deposits)
{
	uint32_t sent = (uint32_t)amount(rate, sum);
	for (int i = 0; i < count; i++) {
		sum += weights[i];
		const uint32_t sends = (uint32_t)amount(rate, sum);
		deposits[i] = (int32_t)((uint32_t)deposits[i] + (sends - sent));
		sent = sends;
	}
	return sum;
}

/* Widens `posts` by the posts of a run that have a weight. */
static void reach(const uint16_t *weights, int first, int count, int row, struct post_rect *posts)
{
	int last = first + count - 1;
	while (first <= last && weights[first] == 0)
		first++;
	while (last >= first && weights[last] == 0)
		last--;
	if (first <= last)
		*posts = post_rect_around(*posts, (struct post_rect){first, row, last + 1, row + 1});
}

/* Lays the soil of a face in its strips, of which there are one or two, west of each other in each row. */
static void lay_face(const struct laying_field *field, const struct strip *const strips[2], const struct face *face, int32_t *deposits,
		     struct soil_lay_result *result)
{
	int first = strips[0]->first_row, end = first + strips[0]->rows;
	if (strips[1] != NULL) {
		const int other = strips[1]->first_row, other_end = other + strips[1]->rows;
		first = other < first ? other : first;
		end = other_end > end ? other_end : end;
	}
	int64_t laid = 0;
	for (int row = first; row < end; row++) {
		const uint16_t *weights = field->weights + (size_t)row * (size_t)field->width;
		uint64_t sum = 0;
		for (int k = 0; k < 2 && strips[k] != NULL; k++) {
			const int at = row - strips[k]->first_row;
			const struct strip_run run = at >= 0 && at < strips[k]->rows ? strips[k]->runs[at] : (struct strip_run){0, 0};
			if (run.count == 0)
				continue;
			sum = lay_run(weights + run.first, run.count, face->rate, sum, deposits + (size_t)row * field->stride + run.first);
			reach(weights, run.first, run.count, row, &result->posts);
		}
		laid += amount(face->rate, sum);
	}
	const int64_t rest = face->part - laid;
	if (rest < REST_MOST) {
		deposits[(size_t)face->row * field->stride + (size_t)face->column] += (int32_t)rest;
	} else {
		result->compacted += rest;
		result->refused++;
	}
}

/* The weights; the distances around a patch, with the rows that finding them takes; the runs of all strips. */
static size_t weights_bytes(size_t width, size_t height)
{
	return (width * height * sizeof(uint16_t) + 7) / 8 * 8;
}

static size_t apart_bytes(size_t width, size_t height)
{
	return (width * (height + 3) + 2 * STRIP_FAR_MOST + 3) * sizeof(int16_t) / 8 * 8;
}

/* Lays an amount of soil around the patch, or beside its faces. */
static void lay_beside(struct laying_field *field, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES], int64_t amount,
		       struct strip_run *runs, int32_t *deposits, struct soil_lay_result *result)
{
	const struct soil_laying *laying = field->laying;
	struct strip strips[STRIPS_MOST];
	struct face faces[SOIL_FACES] = {{0}};
	soil_strip_band(field, measured, soils);
	int count = 1;
	if (laying->around)
		soil_strip_around(field, measured, &strips[0], runs);
	else
		count = soil_strips(field, strips);
	for (int i = 0; i < count; i++) {
		if (!laying->around)
			soil_strip_beside(field, &strips[i], runs + (size_t)i * (size_t)field->height);
		faces[strips[i].face].sum += strips[i].sum;
		if (strips[i].heaviest > 0)
			find_heaviest(field, &strips[i], &faces[strips[i].face]);
	}
	if (!divide(laying, amount, faces)) {
		result->compacted += amount;
		result->confined = measured->givers;
		return;
	}
	for (int face = 0; face < SOIL_FACES; face++) {
		const struct strip *own[2] = {NULL, NULL};
		for (int i = 0, to = 0; i < count; i++)
			if (strips[i].face == face && strips[i].sum > 0)
				own[to++] = &strips[i];
		if (own[0] != NULL)
			lay_face(field, own, &faces[face], deposits, result);
	}
}

size_t soil_lay_scratch(size_t width, size_t height)
{
	const size_t strips = weights_bytes(width, height) + apart_bytes(width, height) + STRIPS_MOST * height * sizeof(struct strip_run);
	const size_t front = soil_front_scratch(width, height);
	return strips > front ? strips : front;
}

void soil_lay(const struct soil_laying *laying, const struct soil_measured *measured, const struct soil_laid soils[SOIL_CLASSES],
	      const struct soil_planes *planes, const uint8_t *patch, const int32_t *carried, struct post_rect written, void *scratch, int32_t *deposits,
	      struct soil_lay_result *result)
{
	*result = (struct soil_lay_result){.posts = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN}};
	if (measured->carried == 0 || post_rect_empty(written))
		return;
	const size_t at = (size_t)(written.y0 - planes->rect.y0) * planes->width + (size_t)(written.x0 - planes->rect.x0);
	struct laying_field field = {
		.laying = laying, .contact = planes->contact + at, .patch = patch + at, .base = planes->base + at, .stride = planes->width,
		.x0 = written.x0, .y0 = written.y0, .width = (int)(written.x1 - written.x0), .height = (int)(written.y1 - written.y0),
		.weights = scratch,
	};
	const size_t width = (size_t)field.width, height = (size_t)field.height;
	field.apart = (int16_t *)((char *)scratch + weights_bytes(width, height));
	struct soil_laying aside = *laying;
	int64_t rest = measured->carried;
	if (laying->front) {
		double left;
		rest -= soil_lay_front(&field, measured, soils, planes->offset + at, carried + at, scratch, deposits + at, result, &left);
		const int64_t rolled = (measured->carried * (65536 - laying->pushed)) >> 16;
		const double part = rest > rolled ? (double)(rest - rolled) / (double)rest : 0;
		aside.shares[SOIL_LEFT] = (int32_t)lround(65536 * (0.5 * (1 - part) + left * part));
		aside.shares[SOIL_RIGHT] = 65536 - aside.shares[SOIL_LEFT];
		field.laying = &aside;
	}
	if (rest > 0)
		lay_beside(&field, measured, soils, rest, (struct strip_run *)((char *)field.apart + apart_bytes(width, height)), deposits + at, result);
	if (post_rect_empty(result->posts))
		return;
	result->posts.x0 += field.x0;
	result->posts.x1 += field.x0;
	result->posts.y0 += field.y0;
	result->posts.y1 += field.y0;
}
