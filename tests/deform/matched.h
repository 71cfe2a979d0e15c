/* One ground on the GPU and in the reference: the same planes before each contact, and lower envelopes that are compared and then shared. */
#ifndef FURROW_TESTS_DEFORM_MATCHED_H
#define FURROW_TESTS_DEFORM_MATCHED_H

#include "ground.h"

#define QUANTUM 0x1p-20
#define NEAR 4e-6 /* m: of undersides, as tests/deform/envelope.c has it */

enum { CELLS = 32, TILES = 3, POSTS = CELLS * TILES + 1, COUNT = POSTS * POSTS };

struct match {
	struct ground ground;
	struct reference_ground reference;
	struct deform_params params; /* the reference's */
	double under[COUNT], rest[COUNT];
	uint8_t contacts[COUNT];     /* the GPU's */
	bool loose[COUNT];           /* what a tie decided may have come here */
	int32_t plane[PLANES][COUNT];
};
static struct match match;

static struct {
	int sweeps, loads, pressed, edges, ties, loosened, slid, undecided;
	double share, quanta, force; /* the worst: of what was allowed, and what it was then */
} seen;

/* --- the GPU's planes, and the reference as they are --- */

static inline void read_planes(void)
{
	struct ground *ground = &match.ground;
	unsigned planes = deform_planes(ground->params.model, false, ground->params.slip_sinkage > 0);
	int32_t words[(CELLS + 1) * (CELLS + 1)];
	memset(match.plane[PLANE_DUG], 0, sizeof match.plane[PLANE_DUG]); /* where slip does not dig, it is not kept */
	for (int plane = 0; plane < PLANES; plane++)
		for (uint32_t k = 0; k < ground->tile_count && (planes & PLANE_BIT(plane)); k++) {
			void *into[PLANES] = {NULL};
			into[plane] = words;
			assert_ok(staged_read_planes(test_gpu, ground->slots, CELLS, k, into));
			for (uint32_t i = 0; i < (CELLS + 1) * (CELLS + 1); i++) {
				uint32_t x = k % TILES * CELLS + i % (CELLS + 1), y = k / TILES * CELLS + i / (CELLS + 1);
				match.plane[plane][y * POSTS + x] = words[i];
			}
		}
}

/* From `plane`, which is what the GPU began with. */
static inline void begin_reference(void)
{
	struct reference_ground *reference = &match.reference;
	for (int i = 0; i < COUNT; i++) {
		reference->offset[i] = lattice_offset_metres(match.plane[PLANE_OFFSET][i]);
		reference->heaped[i] = lattice_offset_metres(match.plane[PLANE_DEPOSITED][i]);
		reference->pressed[i] = lattice_offset_metres(match.plane[PLANE_PLASTIC_SINKAGE][i]);
		reference->dug[i] = lattice_offset_metres(match.plane[PLANE_DUG][i]);
		for (int part = PLANE_SHEAR_EAST; part <= PLANE_SHEAR_NORTH; part++)
			reference->shear[part][i] = ldexp(plane_shear(match.plane[PLANE_SHEAR][i], part), -PLANE_SHEAR_BITS);
	}
	reference->compacted = reference->confined = 0;
	reference->written = match.ground.windows[0].write;
}

/* --- undersides --- */

/* Whether the underside within a hair's breadth of the post is all that, where it is upright or ends. */
static inline bool on_edge(const struct deform_contact *sweep, int at, double z)
{
	long double low = 1e30L, high = -1e30L, beside;
	int covered = 0;
	for (int i = 0; i < 9; i++) {
		long double far = i == 8 ? 0 : NEAR, angle = (long double)i * 0.78539816L;
		long double x = ground_from(&match.ground, at % POSTS, sweep->from.x) + far * cosl(angle);
		long double y = ground_from(&match.ground, at / POSTS, sweep->from.y) + far * sinl(angle);
		if (!reference_underside(sweep, x, y, &beside))
			continue;
		beside += ldexpl((long double)sweep->from.z, -OFFSET_BITS);
		covered++;
		low = fminl(low, beside);
		high = fmaxl(high, beside);
	}
	if (z == (double)INFINITY)
		return covered < 9;
	return covered > 0 && z > low - NEAR && z < high + NEAR;
}

static inline void share_underside(const struct deform_contact *sweep, struct gpu_texture *texture, double *under)
{
	static int32_t window[SIDE * SIDE];
	struct post_rect read = match.ground.windows[0].read, shadow = deform_shadow(match.ground.deform, sweep);
	int width = (int)(read.x1 - read.x0), height = (int)(read.y1 - read.y0);
	gpu_texture_read(texture, 0, rect_of(0, 0, (uint32_t)width, (uint32_t)height), window);
	for (int i = 0; i < width * height; i++) {
		int64_t x = read.x0 + i % width, y = read.y0 + i / width;
		if (x < 0 || y < 0 || x >= POSTS || y >= POSTS)
			continue;
		int at = (int)(y * POSTS + x);
		/* Beyond its shadow nothing was drawn. */
		bool above = x >= shadow.x0 && y >= shadow.y0 && x < shadow.x1 && y < shadow.y1 && window[i] != UNDER_NONE;
		double z = !above ? (double)INFINITY : lattice_offset_metres(sweep->to.z + window[i]);
		if (z != under[at] && !(fabs(z - under[at]) <= NEAR)) {
			if (!on_edge(sweep, at, z))
				fail_msg("post %d, %d: its underside is %.9g, by the reference %.9g", at % POSTS, at / POSTS, z, under[at]);
			seen.edges++;
		}
		under[at] = z;
	}
}

static inline void share_undersides(const struct deform_contact *sweep)
{
	struct deform_contact end = *sweep;
	end.from = end.to;
	reference_undersides(&match.reference, sweep, match.under, match.rest);
	share_underside(sweep, match.ground.deform->under, match.under);
	share_underside(&end, match.ground.deform->rest, match.rest);
}

/* --- where soil slides --- */

static inline bool written(int x, int y)
{
	struct post_rect write = match.reference.written;
	return x >= write.x0 && y >= write.y0 && x < write.x1 && y < write.y1;
}

/* Tells whether soil may slide around the post: the contact touched it, laid soil on it, or the object was less than two spacings above it.
 * laid: m; within: m by which that and heights may be off. */
static inline bool reaches(int at, double laid, double lower, double within)
{
	const struct reference_ground *r = &match.reference;
	double surface = r->base[at] + lattice_offset_metres(match.plane[PLANE_OFFSET][at]);
	bool near = !r->hole[at] && match.under[at] - fmax(lower, 0) - surface < 2 * r->spacing + within;
	return match.contacts[at] % 4 != 0 || laid > -within || near;
}

/* Checks the posts in which soil slides, and shares them. `before`: offsets before soil was laid, m. */
static inline void share_slides(const double *before, double lower, double error)
{
	const int64_t by = match.ground.deform->reach;
	const struct post_rect write = match.reference.written, slides = ground_slides(&match.ground);
	const struct post_rect inner = {slides.x0 + by * (slides.x0 > write.x0), slides.y0 + by * (slides.y0 > write.y0),
					slides.x1 - by * (slides.x1 < write.x1), slides.y1 - by * (slides.y1 < write.y1)};
	const int slack = match.params.model == DEFORM_SCM ? 3 : 1;
	bool sides[4] = {false, false, false, false}; /* a post that was reached is the cause of this side */
	for (int i = 0; i < COUNT && match.ground.deform->scratch[0].near; i++) {
		int x = i % POSTS, y = i / POSTS;
		if (!written(x, y))
			continue;
		double laid = match.reference.offset[i] - before[i];
		bool inside = x >= inner.x0 && x < inner.x1 && y >= inner.y0 && y < inner.y1;
		if (!inside && reaches(i, laid, lower, -error - NEAR))
			fail_msg("post %d, %d was reached, and lies outside %lld, %lld to %lld, %lld", x, y, (long long)inner.x0,
				 (long long)inner.y0, (long long)inner.x1, (long long)inner.y1);
		/* By rounding, a band may be one post wider. Under scm an object may also touch cells of posts beside it. */
		bool may = inside && reaches(i, laid > 0 ? 1 : -1, lower, error + NEAR);
		sides[0] |= may && x - by - slack <= slides.x0;
		sides[1] |= may && y - by - slack <= slides.y0;
		sides[2] |= may && x + by + slack >= slides.x1 - 1;
		sides[3] |= may && y + by + slack >= slides.y1 - 1;
	}
	bool none = post_rect_empty(slides);
	assert_true(none || !match.ground.deform->scratch[0].near || (sides[0] && sides[1] && sides[2] && sides[3]));
	match.reference.written = slides;
}

/* --- comparing --- */

static inline void near_enough(const char *what, int at, double got, double wanted, double error)
{
	double off = fabs(got - wanted), share = off / error;
	if (!(off <= error))
		fail_msg("%s at post %d, %d: %.9g, by the reference %.9g: %.1f quanta off, %.1f allowed", what, at % POSTS, at / POSTS,
			 got, wanted, off / QUANTUM, error / QUANTUM);
	if (share > seen.share) {
		seen.share = share;
		seen.quanta = off / QUANTUM;
	}
}

#endif
