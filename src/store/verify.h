/* Shared by verify_tile.c, verify_own.c and store_verify.c, which verify a store. */
#ifndef FURROW_STORE_VERIFY_H
#define FURROW_STORE_VERIFY_H

#include <math.h>

#include "store/internal.h"

#define VERIFY_CACHE 128

enum held { HELD_NOTHING, HELD_MISSING, HELD_BROKEN, HELD_POSTS };

/* A decoded tile in a cache, for comparison with its neighbours and with coarser tiles. */
struct entry {
	uint64_t key;
	enum row_table table;
	enum held held;
	struct row row;
	int32_t *posts;
};

struct verifying {
	struct store *store;
	store_problem_fn problem;
	store_progress_fn progress;
	void *user;
	struct store_check *check;
	int64_t total; /* rows */
	int64_t base_found; /* number of base rows at level 0 and coarser within the terrain */
	enum row_table table;
	size_t side;
	int32_t *posts, *expected; /* posts: the tile being checked; expected: what it should be by the finer tiles below it */
	struct entry entries[VERIFY_CACHE];
	uint32_t entry_count;
};

static inline bool verify_same(double a, double b)
{
	return (isnan(a) && isnan(b)) || a == b;
}

void store_verify_tell(struct verifying *verifying, const char *format, ...) FURROW_PRINTF(2, 3);
void store_verify_tell_tile(struct verifying *verifying, struct tile tile, const char *what);
/* Checks the rows of an overlay's own file, if it inherits: those that undo an inherited row, and those that repeat one. */
enum status store_verify_own(struct verifying *verifying) FURROW_CHECKED;
enum status store_verify_history(struct verifying *verifying) FURROW_CHECKED;
/* Checks what the store keeps for overlays. */
enum status store_verify_pins(struct verifying *verifying) FURROW_CHECKED;
/* Checks one row of verifying->table. The tile is within the terrain. */
enum status store_verify_tile(struct verifying *verifying, struct tile tile) FURROW_CHECKED;

#endif
