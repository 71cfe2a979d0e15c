/* Which tiles of the working level changed, and when: for who keeps a copy of the ground. */
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
	struct mutex mutex; /* of all but the list of what is pending, which is the writer's */
	struct changes_entry *entries; /* open addressing, at most half full */
	size_t room, count;
	int64_t from, now; /* every change after `from` is here, up to `now` */
	uint64_t *pending; /* keys that the transaction under way changes, some more than once */
	size_t pending_room, pending_count;
};

void store_changes_begin(struct changes *changes);
void store_changes_finish(struct changes *changes);
/* Forgets all: what there is now is of `revision` or before. */
void store_changes_restart(struct changes *changes, int64_t revision);
/* The transaction that is under way changes this tile of the working level. */
enum status store_changes_note(struct changes *changes, uint64_t key) FURROW_CHECKED;
/* Before it commits: room for what it changes, so that nothing can fail once it did. */
enum status store_changes_reserve(struct changes *changes) FURROW_CHECKED;
/* It committed as this revision. */
void store_changes_commit(struct changes *changes, int64_t revision);
/* It did not. */
void store_changes_drop(struct changes *changes);

#endif
