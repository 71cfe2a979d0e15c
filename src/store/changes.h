/* Remembers which tiles of the working level changed, and when. Used by callers that keep a copy of the ground. */
#ifndef FURROW_STORE_CHANGES_H
#define FURROW_STORE_CHANGES_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/thread.h"

struct changes_entry {
	uint64_t key;
	int64_t revision; /* 0: the entry is free */
};

struct changes {
	struct mutex mutex; /* protects all members except the pending list, which only the writer uses */
	struct changes_entry *entries; /* open addressing, at most half full */
	size_t room, count;
	int64_t from, now; /* the table has every change after revision `from`, up to revision `now` */
	uint64_t *pending; /* keys of tiles that the current transaction changes; a key may occur twice */
	size_t pending_room, pending_count;
};

void store_changes_begin(struct changes *changes);
void store_changes_finish(struct changes *changes);
/* Forgets all changes. The present content counts as of `revision`. */
void store_changes_restart(struct changes *changes, int64_t revision);
/* Notes that the current transaction changes this tile of the working level. */
enum status store_changes_note(struct changes *changes, uint64_t key) FURROW_CHECKED;
/* Call this before a commit. Makes room for the noted tiles, so that nothing can fail after the commit. */
enum status store_changes_reserve(struct changes *changes) FURROW_CHECKED;
/* Call this after a commit. The noted tiles changed at this revision. */
void store_changes_commit(struct changes *changes, int64_t revision);
/* Call this if the transaction was undone. Forgets the noted tiles. */
void store_changes_drop(struct changes *changes);

#endif
