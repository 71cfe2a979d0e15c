/*
 * Encodes a plane of (cells + 1)^2 int32 posts into bytes, and decodes it, without any neighbouring tile.
 *
 * INT32_MIN means nodata. It is kept exactly and does not make the posts around it larger. The same posts always give the same
 * bytes. A struct codec is scratch memory for one thread.
 */
#ifndef FURROW_STORE_CODEC_H
#define FURROW_STORE_CODEC_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

#define CODEC_NODATA INT32_MIN

/* These numbers are written to the store. A number never changes its meaning. */
enum codec_id {
	CODEC_CONSTANT = 0, /* one int32, the value of all posts */
	CODEC_PACKED = 1,   /* residuals packed in blocks of 16, each block with its own bit width */
	CODEC_LZ4 = 2,      /* as CODEC_PACKED, then compressed with LZ4 */
	CODEC_ZSTD = 3,     /* residuals split into byte planes, then compressed with zstd */
	CODEC_LEVELS = 4,   /* a coarse grid, then the posts between, in blocks of 8, each block with its own bit width */
	CODEC_BELOW = 5,    /* of a base tile: every second post of the tiles below it, which have the bytes; store_rows_read() */
	CODEC_COUNT
};

/* How much time is spent on packing. store_codec_decode() reads the results of all. */
enum codec_effort {
	CODEC_FAST,    /* CODEC_PACKED or CODEC_LZ4 */
	CODEC_SMALL,   /* CODEC_ZSTD where that is shorter */
	CODEC_GROUND,  /* CODEC_LEVELS: for heights of ground. Takes about 1.5 times as long as CODEC_FAST */
	CODEC_EFFORTS
};

struct codec_kernels;

struct codec {
	uint32_t side;  /* posts along a side: a multiple of 8, plus 1 */
	enum codec_effort effort;
	const struct codec_kernels *kernels;
	size_t room;    /* bytes of the longest body */
	uint32_t *orders[2];    /* side^2, rounded up to a block: residuals of first order [0] and second order [1] */
	uint8_t *widths[2];     /* bit widths of the blocks of these residuals */
	int32_t *grids;         /* coarser grids of a plane in levels */
	int32_t *edges;         /* 3 rows of a plane and a block: rows beyond a grid, and its last column */
	int32_t *filled;        /* side^2: posts with holes filled, while encoding */
	uint8_t *mask;          /* (side^2 + 7) / 8 */
	uint8_t *body;          /* room */
	uint8_t *squeezed;      /* the body after LZ4 or zstd */
	size_t squeezed_room;
	void *zstd_out, *zstd_in; /* contexts of zstd; zstd_out only with CODEC_SMALL */
};

enum status store_codec_init(struct codec *codec, uint32_t side, enum codec_effort effort) FURROW_CHECKED;
void store_codec_finish(struct codec *codec);

/* Returns the largest size of a plane's blob. */
size_t store_codec_bound(const struct codec *codec);

/* Encodes posts. The bytes belong to the codec and stay valid until its next use. Cannot fail. */
enum codec_id store_codec_encode(struct codec *codec, const int32_t *posts, const void **bytes, size_t *size);

/* Decodes bytes into posts. Returns false if the bytes are not a blob of a plane of this size (FORMAT.md); then posts are
 * undefined. Never reads or writes out of bounds, whatever the bytes are. */
bool store_codec_decode(struct codec *codec, int64_t id, const void *bytes, size_t size,
		  int32_t *posts) FURROW_CHECKED;
/* Decodes every second post of every second row, (side + 1) / 2 squared, into rows of `stride`. `whole`: scratch for side^2 posts. Takes
 * a third of the time, if the plane is in levels. */
bool store_codec_decode_half(struct codec *codec, int64_t id, const void *bytes, size_t size, int32_t *posts, size_t stride,
			     int32_t *whole) FURROW_CHECKED;

#endif
