/*
 * A trace's file, and what its writer and its reader share.
 *
 *     header   8 bytes "furrowPT", uint32 version, little-endian
 *     records  each begins with a number in LEB128 (7 bits a byte, low bits first):
 *       tile << 3 | resident << 2 | kind << 1     an access. Tiles are numbered from 0 in the order in
 *                                                 which they first come; the first of a tile is followed
 *                                                 by its key, a uint64
 *       steps << 1 | 1, steps > 0                 the accesses that follow are so many steps later
 *       1                                         the end, followed by three uint64: how many accesses,
 *                                                 how many tiles, and the XXH3 of all bytes before itself
 *
 * A drive comes back to the tiles it lately had, and has few in all: of a million accesses most name
 * one of a few hundred tiles, which is two bytes, where key, step and flags in full would be 16.
 */
#ifndef FURROW_PAGE_TRACE_FORMAT_H
#define FURROW_PAGE_TRACE_FORMAT_H

#include "page/page.h"

#define TRACE_MAGIC "furrowPT"
#define TRACE_VERSION 1
#define TRACE_HEADER 12   /* bytes */
#define TRACE_KEY_BITS 62 /* tile_key's */
#define TRACE_NUMBER_MOST 10 /* bytes of a LEB128 of 64 bits */
#define TRACE_ACCESSES_MOST ((1u << 30) - 2) /* that are read: sums over twice as many fit 31 bits */

/* Keys to their numbers: an open-addressed table, at most half full. */
struct page_trace_index {
	uint64_t *keys; /* key + 1; 0: free */
	uint32_t *numbers;
	size_t room;
	uint32_t count;
};

/* The number of `key`: an earlier one, or (*fresh) the next. */
enum status page_trace_index_put(struct page_trace_index *index, uint64_t key, uint32_t *number,
				 bool *fresh) FURROW_CHECKED;
void page_trace_index_finish(struct page_trace_index *index);

/* page_accesses_read, of a file's bytes; `path` is for messages. */
enum status page_accesses_parse(const char *path, const uint8_t *bytes, size_t size,
				struct page_accesses *out) FURROW_CHECKED;

static inline void page_trace_store(uint8_t *bytes, uint64_t value, int count)
{
	for (int i = 0; i < count; i++)
		bytes[i] = (uint8_t)(value >> (8 * i));
}

static inline uint64_t page_trace_fetch(const uint8_t *bytes, int count)
{
	uint64_t value = 0;
	for (int i = 0; i < count; i++)
		value |= (uint64_t)bytes[i] << (8 * i);
	return value;
}

#endif
