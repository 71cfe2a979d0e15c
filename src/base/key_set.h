/*
 * A hash table of 64-bit keys (mostly of tiles). It numbers the keys in the order in which they were added. Open addressing, at
 * most three quarters full, 12 bytes for each place. It only grows. To keep data for each key, use an array indexed by the
 * key's number. One thread. Initialise it with {0}.
 */
#ifndef FURROW_BASE_KEY_SET_H
#define FURROW_BASE_KEY_SET_H

#include "base/base.h"

struct key_set {
	uint64_t *keys;     /* UINT64_MAX means empty; it is never a key */
	uint32_t *numbers;
	size_t count, room; /* room: a power of two, or 0 */
};

/* Returns a hash whose low bits are well spread. */
static inline size_t key_hash(uint64_t key)
{
	return (size_t)((key * 0x9e3779b97f4a7c15ull) >> 20);
}

void key_set_finish(struct key_set *set);
bool key_set_has(const struct key_set *set, uint64_t key);
/* Finds the key's number, from 0. Returns false if it is absent; then the number is undefined. */
bool key_set_find(const struct key_set *set, uint64_t key, uint32_t *number);
enum status key_set_add(struct key_set *set, uint64_t key) FURROW_CHECKED;
/* Adds the key. Gives its number and if it is new. */
enum status key_set_number(struct key_set *set, uint64_t key, uint32_t *number, bool *fresh) FURROW_CHECKED;
/* Makes room for `more` keys, so that key_set_put cannot fail for them. */
enum status key_set_reserve(struct key_set *set, size_t more) FURROW_CHECKED;
void key_set_put(struct key_set *set, uint64_t key);
/* Removes all keys and keeps the memory. */
void key_set_clear(struct key_set *set);

#endif
