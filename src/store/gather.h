/* What the two files that gather parts share: what is known of the parts, and where each tile's last page is. */
#ifndef FURROW_STORE_GATHER_H
#define FURROW_STORE_GATHER_H

#include "store/internal.h"

/* What is known of a part. */
struct head {
	const char *path; /* NULL: it is missing */
	struct store_part part;
	uint64_t parent_hash;
	int64_t parent_revision, commit;
	struct store_run_copy run; /* of the commit that is gathered, as is the next */
	struct store_run_header header;
};

struct claim {
	uint64_t key;
	int64_t commit;
	uint32_t part; /* index of its head */
};

struct gather {
	struct store *store; /* what the parts are over */
	const struct store_gathering *gathering;
	struct head *heads; /* by index of the part */
	uint32_t count;     /* of them */
	const struct head *first; /* the first one that is not missing */
	int64_t commit;     /* which is gathered */
	struct claim *claims; /* sorted by key, each key once, when all are read */
	size_t claim_count, claim_room;
	uint32_t reading;   /* index of the part that is read */
	struct store *part; /* which is open */
	enum row_table table;
	struct climb_item *items;
	int32_t *posts, *scratch; /* a tile each */
	bool has_level;
	int level;
	char *relief; /* of the level; NULL: none */
	struct store_commit_result *result;
};

/* --- store_gather_parts.c: what the parts have. It changes no file --- */

/* Reads the heads of the parts in these files. */
enum status store_gather_heads(struct gather *gather, const char *const *paths, size_t count) FURROW_CHECKED;
/* Finds gather->commit, the last commit that all parts have. A part that is missing has none. */
enum status store_gather_settle(struct gather *gather) FURROW_CHECKED;
/* Reads the records of the run, the level, and the claims of all parts. Keeps the last claim of each tile. */
enum status store_gather_read(struct gather *gather) FURROW_CHECKED;
/* Opens a part again, as gather->part. It must be as it was when its head was taken. */
enum status store_gather_open(struct gather *gather, uint32_t index) FURROW_CHECKED;
void store_gather_close(struct gather *gather); /* gather->part may be NULL */
/* Returns true if any part has committed the tile. After store_gather_read(). */
bool store_gather_claimed(const struct gather *gather, uint64_t key);

#endif
