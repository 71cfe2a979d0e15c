/* All ways to the ground's height at a place: that of bodies, of a host's queries, and of the store's readers. And places over the insets of insets.h. */
#ifndef FURROW_TESTS_RESIDENT_WAYS_H
#define FURROW_TESTS_RESIDENT_WAYS_H

#include "../support.h"
#include "../support/program.h"

struct ways {
	struct ground *ground;
	struct newest *newest;
	struct store_reader *reader;
};

struct ways_heights {
	int64_t height;
	struct resident_height told;
	struct store_sample sample;
};

static void ways_open(struct store *store, struct ways *ways)
{
	must(resident_ground_create(store, 3, &ways->ground));
	must(resident_newest_create(store, NULL, &ways->newest));
	must(store_reader_create(store, &ways->reader));
}

static void ways_close(struct ways *ways)
{
	store_reader_destroy(ways->reader);
	resident_newest_destroy(ways->newest);
	resident_ground_destroy(ways->ground);
}

/* Returns false if there is no ground. All ways agree on that. */
static bool ways_at(struct ways *ways, double x, double y, struct ways_heights *out)
{
	bool any;
	must(resident_ground_height(ways->ground, lattice_offset(x), lattice_offset(y), &out->height, &any));
	must(resident_newest_heights(ways->newest, &(struct resident_point){x, y}, 1, &out->told));
	must(store_sample(ways->reader, x, y, &out->sample));
	assert_true(any == !out->sample.nodata && any == !out->told.nodata);
	return any;
}

/* The k-th tile of a level: every other one lies about the insets. */
static struct tile ways_tile(const struct extent *extent, int level, uint32_t k)
{
	const bool inside = k % 2 == 0;
	const double share = inside ? 0.25 + 0.25 * (k * 37 % 101) / 101.0 : (k * 53 % 101) / 101.0;
	return (struct tile){level, (uint32_t)(share * extent_tiles_x(extent, level)),
			     (uint32_t)((inside ? share + 0.1 : 1 - share) * (extent_tiles_y(extent, level) - 1))};
}

#endif
