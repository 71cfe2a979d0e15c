/* A set of tile keys: open addressing, 8 bytes a place. One thread. Starts as {0}. */
#ifndef FURROW_RUN_KEY_SET_H
#define FURROW_RUN_KEY_SET_H

#include "base/base.h"

struct key_set {
	uint64_t *keys;     /* UINT64_MAX: empty */
	size_t count, room; /* room: a power of two, or 0; at most 3/4 of it is taken */
};

void key_set_finish(struct key_set *set);
bool key_set_has(const struct key_set *set, uint64_t key);
enum status key_set_add(struct key_set *set, uint64_t key) FURROW_CHECKED;
/* Empties it and keeps the memory. */
void key_set_clear(struct key_set *set);

#endif
