/* What an overlay inherits: the rows of the files it is over, by tile. */
#ifndef FURROW_STORE_LINEAGE_H
#define FURROW_STORE_LINEAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plane.h"

#define LINEAGE_TABLES (1 + PLANES) /* as enum row_table; the base's is unused */

/* A row of the nearest file that has one. */
struct lineage_entry {
	uint64_t key, hash;
	int64_t revision;
	uint32_t size;  /* bytes of its blob */
	uint32_t layer; /* the file: 0 is the plain store, n the overlay with n files under it */
};

/* One array for each table, sorted by key. Never changes once the overlay is open, so any thread may read it. */
struct lineage {
	struct lineage_entry *entries[LINEAGE_TABLES];
	size_t count[LINEAGE_TABLES];
};

void store_lineage_finish(struct lineage *lineage);
/* Returns the entry of a key; NULL: no file under the overlay has that row. */
const struct lineage_entry *store_lineage_find(const struct lineage *lineage, int table, uint64_t key);
/* Returns the index of the first entry whose key is at least `key`. */
size_t store_lineage_from(const struct lineage *lineage, int table, uint64_t key);
/* Returns true if a row of this file counts. */
bool store_lineage_uses(const struct lineage *lineage, uint32_t layer);

#endif
