/*
 * Relief below the source: seeded fractal detail of the base at levels below zero, and pure functions over it.
 *
 * A level with detail raises and lowers its new posts: those that the next coarser level has not. Finer levels interpolate between
 * them. So posts of the source stay as they are, and each level is the decimation of the finer ones. The midpoint of an edge of a
 * coarser cell gets a random height, of the edge alone: both cells beside it have the same. The middle of the cell gets minus half the
 * sum of its four midpoints. So the mean over each cell of each level is zero, before the one rounding of each post to 2^-18 m.
 *
 * The longest waves have the level whose spacing is at most half a wavelength. From level to level the heights' variance halves (Hurst
 * exponent 0.5). So the spectrum of a profile falls with the square of the wave number, as that of most ground does. The root mean
 * square over an area, of all levels together, is the roughness.
 *
 * A post is counted from the world's first one, modulo 2^32. All is exact integer arithmetic. shaders/lib/relief.glsl holds the same
 * formulas; tests/gpu compares them bit for bit.
 */
#ifndef FURROW_BASE_RELIEF_H
#define FURROW_BASE_RELIEF_H

#include "base/status.h"
#include "base/tile.h"

#define RELIEF_CLASSES 16
#define RELIEF_BANDS (-TILE_LEVEL_MIN) /* of level -1, -2, ... */
#define RELIEF_ROUGHNESS_MOST 10.0     /* metres; the schema of scenes says so, too */

/* What is asked for, by class of soil. Metres. A class without roughness has no relief. */
struct relief_waves {
	double roughness;  /* root mean square of the height over an area */
	double wavelength; /* the longest; above 0 */
};
struct relief_spec {
	uint32_t seed;
	int classes;      /* 0: no relief; 1: the same everywhere */
	uint64_t map[2];  /* hash of the raster of classes, and of which class a value is; 0 without classes */
	struct relief_waves waves[RELIEF_CLASSES];
};

/* Tells which class each post of a rectangle has, row by row. Posts outside the terrain: any class. */
struct relief_map {
	enum status (*read)(void *user, int level, struct post_rect rect, uint8_t *classes);
	void *user;
};

/* What computes it. A band is the detail of one level. */
struct relief {
	int coarsest, finest; /* levels with detail; coarsest < finest: there is none. All zeros: none, too */
	int classes;
	uint32_t keys[RELIEF_BANDS];                      /* by -1 - level: what the level's random heights are made from */
	int32_t amplitudes[RELIEF_CLASSES][RELIEF_BANDS]; /* half the greatest height of a midpoint, 2^-24 m */
	const struct relief_map *map;                     /* used if there are classes */
};

/* Makes the relief of a terrain with `spacing` metres between posts of level 0, down to level `finest`, which counts. */
void relief_make(const struct relief_spec *spec, double spacing, int finest, struct relief *relief);
/* Returns true if it raises any post. relief may be NULL. */
bool relief_any(const struct relief *relief);
/* Returns true if it raises posts of this level. relief may be NULL. */
bool relief_has_level(const struct relief *relief, int level);

/* Computes by how much posts of a level are raised, in 2^-18 m, row by row. `from`: the coarser level from which the base is interpolated. Fails only where there are classes, without memory or with the map. relief may be NULL: zeros. */
enum status relief_heights(const struct relief *relief, int level, int from, struct post_rect rect, int32_t *heights) FURROW_CHECKED;
/* What a shader needs to compute the same for a tile, level by level; laid out as std140. For relief without classes. */
struct relief_part {
	uint32_t key;
	int32_t amplitude;
	int32_t depth;         /* a cell of the next coarser level has 2 << depth posts of the tile along a side */
	int32_t unused;
	uint32_t cell[2], rest[2]; /* of the tile's first post: the cell it lies in, and at which of its posts */
};
/* Finds them for a tile whose first post is (x, y). *down: the sum is to be shifted down by so many bits, rounded half up. The last
 * part is the finest level, and each part before it counts a quarter of the next. Returns
 * how many there are. */
int relief_parts(const struct relief *relief, int level, int from, int64_t x, int64_t y, struct relief_part parts[RELIEF_BANDS], int *down);
/* Returns a height, in metres, that no post of any level is raised or lowered by more, where the base is of level `from`. relief may be NULL: 0. */
double relief_bound(const struct relief *relief, int from);
/* Returns the root mean square over an area, in metres, of the detail of the levels below `from`, in the roughest class. */
double relief_rms(const struct relief *relief, int from);

/* Returns the root mean square slope between neighbouring posts of the finest level, along an axis. Of the relief of a class alone. It is about 2.7 times the roughness, divided by the root of the longest band's spacing times the finest one's.
 * `spacing`: metres between posts of level 0. relief may be NULL: 0. */
double relief_slope(const struct relief *relief, int class, double spacing);

/* --- its text --- */

/* Returns the text of a specification, JSON, which the caller frees with mem_free; equal relief has equal text. NULL: out of memory. */
char *relief_print(const struct relief_spec *spec);
/* Reads such a text, which may come from anybody. Returns false if it is none. */
bool relief_parse(const char *text, struct relief_spec *spec);

#endif
