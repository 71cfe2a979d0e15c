/*
 * A plane of (cells + 1)^2 int32 posts to bytes and back, alone: no neighbour is needed.
 *
 * INT32_MIN is nodata: it is kept exactly and costs the posts around it nothing. The same posts
 * always give the same bytes. A struct codec is scratch memory for one thread.
 */
#ifndef FURROW_STORE_CODEC_H
#define FURROW_STORE_CODEC_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

#define CODEC_NODATA INT32_MIN

/* Written to the store: a number never changes its meaning. */
enum codec_id {
	CODEC_CONSTANT = 0, /* one int32: all posts */
	CODEC_PACKED = 1,   /* residuals, bit widths by 16 */
	CODEC_LZ4 = 2,      /* the same, then LZ4 */
	CODEC_ZSTD = 3,     /* residuals, byte planes, then zstd */
	CODEC_COUNT
};

/* How hard a plane is packed; all of it reads back through the same store_codec_decode(). */
enum codec_effort { CODEC_FAST, CODEC_SMALL };

struct codec_kernels;

struct codec {
	uint32_t side;  /* posts along a side: a multiple of 8, and 1 */
	enum codec_effort effort;
	const struct codec_kernels *kernels;
	size_t room;    /* bytes the longest body takes */
	uint32_t *orders[2];    /* side^2, rounded up to a block: residuals without and with slopes */
	uint8_t *widths[2];     /* of their blocks */
	int32_t *filled;        /* side^2: posts with holes filled, while encoding */
	uint8_t *mask;          /* (side^2 + 7) / 8 */
	uint8_t *body;          /* room */
	uint8_t *squeezed;      /* what LZ4 or zstd makes of it */
	size_t squeezed_room;
	void *zstd_out, *zstd_in; /* contexts; out: only with CODEC_SMALL */
};

enum status store_codec_init(struct codec *codec, uint32_t side, enum codec_effort effort) FURROW_CHECKED;
void store_codec_finish(struct codec *codec);

/* No blob of a plane is longer than this. */
size_t store_codec_bound(const struct codec *codec);

/* Bytes are the codec's own and valid until its next use. Cannot fail. */
enum codec_id store_codec_encode(struct codec *codec, const int32_t *posts, const void **bytes, size_t *size);

/* False if the bytes are no blob of a plane of this size (FORMAT.md); posts are then undefined. Reads
 * and writes nothing out of bounds whatever the bytes. */
bool store_codec_decode(struct codec *codec, int64_t id, const void *bytes, size_t size,
		  int32_t *posts) FURROW_CHECKED;

#endif
