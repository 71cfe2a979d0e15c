/* What the parts of bench_store share: rows measured in turn, and GDAL and LMDB on the same tiles. */
#ifndef FURROW_STORE_BENCH_H
#define FURROW_STORE_BENCH_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

#define BENCH_RUNS_MAX 32
#define BENCH_BLOCK 256 /* posts of a GDAL block's side */

/* One thing measured: `once(user, i)` does item i. */
struct bench_row {
	const char *name, *subject; /* `subject`: a file or a codec, "" for the store itself */
	void (*once)(void *user, size_t i);
	void *user;
	double bytes; /* of an item: posts, or as stored */
	double rates[BENCH_RUNS_MAX]; /* items a second, one a run */
};

/* Every row once a run, one after the other, so that all share the machine's mood; each goes over
 * its `count` items as often as fills `seconds`. */
void bench_rows(struct bench_row *rows, size_t row_count, size_t count, int runs, double seconds);
/* Tiles of level 0 that GDAL's blocks of 256 posts cover whole, in an order without a pattern, at
 * most `most`; all tiles if there are none. Freed with mem_free. */
struct tile *bench_tiles(const struct extent *extent, size_t most, size_t *count);

/* Writes a store of dunes: posts 1 m apart, `blocks` tiles of 256 posts a side at level 0. At level -3 a tile is 32 m wide. */
void bench_dunes(const char *path, uint32_t blocks);

/* bench_store read STORE [COG...] */
int bench_read(const char *path, char **cogs, int cog_count, int runs);
/* bench_store write; leaves figures (record.h) */
void bench_write(int runs);
/* bench_store rollback */
int bench_rollback(void);
/* bench_store chain */
int bench_chain(int runs);

/* --- GDAL; without it, nothing is opened and `false` comes back --- */
struct bench_gdal;
/* `in_memory`: a copy in memory is opened, so that reading it is decoding alone. */
bool bench_gdal_open(const char *path, bool in_memory, struct bench_gdal **out);
void bench_gdal_close(struct bench_gdal *gdal);
/* The block of a tile of level 0, past GDAL's cache: in its own type, or as float32 metres. */
void bench_gdal_read_native(struct bench_gdal *gdal, struct tile tile);
void bench_gdal_read(struct bench_gdal *gdal, struct tile tile);
/* What that read: 256 x 256, row 0 north. */
const float *bench_gdal_heights(const struct bench_gdal *gdal);
/* Writes that block, read before, to a raster in memory of the same type, compression and error. */
void bench_gdal_encode(struct bench_gdal *gdal, struct tile tile);
/* A new tiled GeoTIFF of Int32, `blocks` of 256 a side, open for updates. */
bool bench_gdal_create(const char *path, uint32_t blocks, const char *compression, struct bench_gdal **out);
/* `posts`: a tile's (256 + 1)^2; and whether that is what the file has. */
void bench_gdal_write(struct bench_gdal *gdal, struct tile tile, const int32_t *posts);
bool bench_gdal_holds(struct bench_gdal *gdal, struct tile tile, const int32_t *posts);
void bench_gdal_flush(struct bench_gdal *gdal, bool sync);
/* bench_store error EXACT OTHER: the most that a raster is off another. */
int bench_error(const char *exact, const char *other);
/* bench_store blocks RASTER: bytes of its blocks alone. */
int bench_blocks(const char *path);

/* --- LMDB; without it, `false` --- */
struct bench_lmdb;
bool bench_lmdb_create(const char *folder, size_t room, struct bench_lmdb **out);
void bench_lmdb_put(struct bench_lmdb *lmdb, uint64_t key, const void *bytes, size_t size);
void bench_lmdb_commit(struct bench_lmdb *lmdb);
size_t bench_lmdb_get(struct bench_lmdb *lmdb, uint64_t key, void *bytes, size_t room);
void bench_lmdb_destroy(struct bench_lmdb *lmdb);

#endif
