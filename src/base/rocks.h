/*
 * Rocks on the ground: seeded, by a size-frequency law, and pure functions over them.
 *
 * The law is that of M. Golombek and D. Rapp (J. Geophys. Res. 102, 1997): rocks of diameter D and larger cover the share
 * F(D) = cover exp(-q D) of the ground, with q = 1.79 + 0.152 / k per metre. Rocks are made from `smallest` to `largest`. They lie
 * independently of each other, so some overlap. Their own areas are therefore summed to -ln(1 - F) for each diameter, so that what is
 * seen from above is F.
 *
 * Diameters are divided into octaves. Each octave has a grid of square cells, whose edge is a power of two of level 0's spacing. A cell's
 * number of rocks, and each rock's place, diameter, height and shape come from a hash of the cell alone. A diameter is at most 3/4 of
 * the edge, so a post needs the four nearest cells only.
 *
 * A rock's outline is an ellipse of the area of a circle of its diameter. Its top is round, and cut by three facets. Rocks raise posts: by the
 * highest rock at the post, at every level. So each level is the decimation of the finer ones.
 *
 * A post is counted from the world's first one. All is exact integer arithmetic once rocks_make() has made the tables. There is no copy in GLSL: base heights
 * of tiles in slots come from here, too (pages_gpu.c).
 */
#ifndef FURROW_BASE_ROCKS_H
#define FURROW_BASE_ROCKS_H

#include "base/relief.h"

#define ROCKS_OCTAVES 10
#define ROCKS_COUNTS 32 /* rocks of a cell at most */
#define ROCKS_KNOTS 64  /* pieces of the table of diameters */
#define ROCKS_COVER_MOST 0.9 /* the schema of scenes says so, too */
#define ROCKS_SMALLEST_LEAST 1e-3 /* m; the same */
#define ROCKS_LARGEST_MOST 20.0 /* m; the same */
#define ROCKS_HEIGHT_MOST (39 / 64.0)  /* of the diameter; the least is 24 / 64, and at most a quarter less by facets */
#define ROCKS_RANGE (1 << (ROCKS_OCTAVES - 2)) /* largest / smallest at most */

/* What is asked for. cover 0: no rocks. */
struct rocks_spec {
	double cover, k;          /* of the law; above 0 */
	double smallest, largest; /* diameters, m */
	uint32_t seed;
};

struct rocks_octave {
	uint32_t key;
	int32_t edge;                     /* a cell's edge is 2^edge of level 0's spacing */
	uint32_t scale;                   /* 2^-26 m in 1/8192 of a cell's edge */
	uint32_t counts[ROCKS_COUNTS];    /* 2^32 times the chance that a cell has at most so many rocks */
	uint32_t knots[ROCKS_KNOTS + 1];  /* diameters in 1/8192 of the edge, of equally many rocks from one to the next */
};

/* What computes them. All zeros: none. */
struct rocks {
	int count; /* of octaves, the largest rocks first */
	int finest;     /* at most 0: whoever asks for posts asks for none of finer levels. rocks_make() leaves it 0 */
	double spacing; /* m, of level 0 */
	double highest; /* m: no rock is higher */
	struct rocks_octave octaves[ROCKS_OCTAVES];
};

/* Makes the rocks of a terrain with `spacing` metres between posts of level 0. Needs 0 < smallest < largest <= ROCKS_RANGE smallest, unless cover is 0. */
void rocks_make(const struct rocks_spec *spec, double spacing, struct rocks *rocks);
/* Returns true if there are any. rocks may be NULL. */
bool rocks_any(const struct rocks *rocks);
/* Computes by how much posts of a level are raised, in 2^-18 m, row by row; 0 beside rocks. rocks may be NULL: zeros. */
void rocks_heights(const struct rocks *rocks, int level, struct post_rect rect, int32_t *heights);
/* Adds them to posts, in 2^-18 m, which may be BASE_NODATA. Fails only without memory. rocks may be NULL: nothing. */
enum status rocks_add(const struct rocks *rocks, int level, struct post_rect rect, int32_t *posts) FURROW_CHECKED;
/* Returns a height, in metres, by which no post is raised more. rocks may be NULL: 0. */
double rocks_bound(const struct rocks *rocks);
/* Returns how far triangles between posts of a level may be off the rocks, in metres. At the finest level: 0. rocks may be NULL: 0. */
double rocks_error(const struct rocks *rocks, int level);

/* Returns the share of the ground that rocks of at least this diameter (m) cover. */
double rocks_cover(const struct rocks_spec *spec, double diameter);
/* Returns how many rocks there are on a square metre in the mean. */
double rocks_density(const struct rocks_spec *spec);

/* A rock; metres from the south-west post. */
struct rock {
	double x, y, diameter, height;
};
/* Gives each rock whose middle is in the rectangle, metres. Stops if `fn` returns false. */
void rocks_each(const struct rocks *rocks, double x0, double y0, double x1, double y1, bool (*fn)(void *user, const struct rock *rock),
		void *user);

/* --- their text --- */

/* Returns true if rocks_make() can make them. */
bool rocks_good(const struct rocks_spec *rocks);
/* Returns the text of a specification of relief and rocks, JSON, which the caller frees with mem_free; equal ones have equal text. Each may be NULL: none.
 * NULL: out of memory. */
char *rocks_print(const struct relief_spec *relief, const struct rocks_spec *rocks);
/* Reads such a text, or one of relief alone, which may come from anybody. What it does not name is zeros. Returns false if it is none. */
bool rocks_parse(const char *text, struct relief_spec *relief, struct rocks_spec *rocks);

#endif
