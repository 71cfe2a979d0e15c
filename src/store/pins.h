/*
 * Pins: which overlays depend on a store, and what it keeps for them.
 *
 *   overlay is made -> a line in the list PATH-pins -> the next commit of the store keeps the revision -> furrow prune drops it
 *
 * The list is a file beside the store, so that the store itself stays as it is when an overlay of it is made (store_pins.c). The rows that
 * are kept are in the store, and are written in the transaction that replaces them (store_pinned.c).
 */
#ifndef FURROW_STORE_PINS_H
#define FURROW_STORE_PINS_H

#include <sqlite3.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plane.h"

#define PINS_TABLES (1 + PLANES) /* as enum row_table; the base's is unused */
#define PINS_SUFFIX "-pins"

/* Of a store that is open. */
struct pins {
	int64_t newest; /* the newest pinned revision in the file; -1: none */
	int64_t label;  /* in a transaction: the revision for which rows are kept; -1: none */
	bool told;      /* the parent knows of this overlay */
	sqlite3_stmt *keep[PINS_TABLES], *none[PINS_TABLES];
};

/* A line of the list. */
struct pin {
	char *path;       /* of the overlay, from the folder of the store; owned by who made this */
	int64_t revision; /* that it depends on */
	uint64_t hash;    /* of the store's state then (store_lineage_hash), or of its base */
	bool base;        /* only the base counts: the overlay does not show the ruts of the store */
	int64_t made;     /* seconds since 1970 */
};

struct store;

/* --- store_pins_tell.c: an overlay is noted in it --- */

/* Notes in the list of `parent` that the overlay at `real_path` depends on it. `parent` is open for reading, and shows what the overlay
 * depends on. Nobody can change the parent between this check and the note. The list is synced. A folder that cannot be written gets no list; that is told
 * once, where the overlay depends on it. STATUS_FAILED: the parent has changed since it was opened. */
enum status store_pins_add(struct store *parent, const char *real_path, const struct pin *pin) FURROW_CHECKED;
/* The same for an open overlay, unless the list names it already. */
enum status store_pins_tell_parent(struct store *store) FURROW_CHECKED;
/* Takes the note back: the overlay was not made, or is removed. Says nothing if that fails. */
void store_pins_withdraw_from(const struct store *store, const struct store *parent);
void store_pins_withdraw(const struct store *store);
/* --- store_pins.c: the list --- */

/* Calls `fn` for each line, by path. */
typedef enum status (*pin_fn)(void *user, const struct pin *pin);
enum status store_pins_each(const char *real_path, pin_fn fn, void *user) FURROW_CHECKED;
/* Removes a line, and with the last one the list. Writes a line, in place of that with the same path. */
enum status store_pins_drop(const char *real_path, const char *path) FURROW_CHECKED;
enum status store_pins_put(const char *real_path, const struct pin *pin) FURROW_CHECKED;
/* Removes the lines of overlays that show ruts of the store. */
enum status store_pins_clear(const char *real_path) FURROW_CHECKED;

/* --- store_losses.c: what would be lost with the store --- */

/* STATUS_INPUT, with what would be lost, if overlays or snapshots need what a reset drops; `whole`: what a new store in its place would drop. */
enum status store_losses_refuse(struct store *store, bool whole) FURROW_CHECKED;

/* --- store_pinned.c: what is kept, in the store's file --- */

/* Reads what the file has. */
enum status store_pinned_open(struct store *store) FURROW_CHECKED;
void store_pinned_finish(struct store *store);
/* Call this when a transaction that changes rows has begun. Keeps the present revision if the list has it. */
enum status store_pinned_begin(struct store *store) FURROW_CHECKED;
void store_pinned_end(struct store *store, bool committed);
/* Call this before a row of any level is changed: keeps the file's own row as it is. `table`: enum row_table. */
enum status store_pinned_keep(struct store *store, int table, uint64_t key) FURROW_CHECKED;
/* Finds the pinned revision with a state's hash. *revision -1: none. */
enum status store_pinned_find(const struct store *store, uint64_t hash, int64_t *revision) FURROW_CHECKED;
/* Shows this connection a pinned revision in place of the present one. The file stays as it is. */
enum status store_pinned_show(sqlite3 *db, const char *path, int64_t revision) FURROW_CHECKED;
/* Drops the pinned revisions for which `wanted` returns false, and the rows that only they need. In a transaction. *dropped: how many. */
enum status store_pinned_drop(struct store *store, bool (*wanted)(void *user, int64_t revision, uint64_t hash), void *user, int64_t *dropped)
	FURROW_CHECKED;
/* Drops all. In a transaction. */
enum status store_pinned_clear(struct store *store) FURROW_CHECKED;

#endif
