/*
 * Reading: the codec alone, from memory to memory; a tile through the store (SQLite, hash, codec);
 * its bytes alone through SQLite and through LMDB; GDAL's block of the same posts from memory and
 * from a file. All of it hot, in one random order.
 */
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "store/codec.h"
#include "store/store.h"
#include "store_bench.h"

#define TILES_MOST 512
#define COGS_MOST 8
#define SECONDS 0.15 /* of a row, each run */
#define HOLE (-32767.0f) /* metres */

struct blob {
	int64_t codec;
	size_t size;
	uint8_t *bytes;
};

struct bench {
	const char *path;
	struct store *store;
	struct store_reader *reader;
	double step;
	struct tile *tiles;
	size_t count, posts; /* tiles; posts of a tile */
	struct codec codec;
	int32_t **planes; /* of each tile */
	struct blob *blobs;
	int32_t *out;
	float *heights;
	sqlite3 *db;
	sqlite3_stmt *find;
	uint8_t *copy;
	struct bench_lmdb *lmdb;
};

struct cog {
	struct bench *bench;
	struct bench_gdal *memory, *file;
};

static void must_sql(struct bench *bench, int code, int want)
{
	if (code != want)
		bench_must(fail_with(STATUS_FAILED, "%s: %s; is it a store?", bench->path, sqlite3_errmsg(bench->db)));
}

static void *must_alloc(size_t count, size_t size)
{
	void *memory = mem_alloc(count, size);
	if (memory == NULL)
		bench_must(fail_memory("the bench"));
	return memory;
}

/* --- what is measured --- */

static void encode(void *user, size_t i)
{
	struct bench *bench = user;
	const void *bytes;
	size_t size;
	store_codec_encode(&bench->codec, bench->planes[i], &bytes, &size);
}

static void decode(void *user, size_t i)
{
	struct bench *bench = user;
	const struct blob *blob = &bench->blobs[i];
	if (!store_codec_decode(&bench->codec, blob->codec, blob->bytes, blob->size, bench->out))
		bench_must(fail_with(STATUS_FAILED, "%s: a blob does not decode; verify it", bench->path));
}

/* As GDAL's blocks end: metres in float32. What a hole becomes is chosen among the codes, which the
 * compiler makes vectors of. */
static void decode_metres(void *user, size_t i)
{
	struct bench *bench = user;
	const int32_t *codes = bench->out;
	float *heights = bench->heights, step = (float)bench->step;
	const int32_t hole = (int32_t)((double)HOLE / bench->step);
	decode(user, i);
	for (size_t p = 0, count = bench->posts; p < count; p++) {
		int32_t code = codes[p] == CODEC_NODATA ? hole : codes[p];
		heights[p] = (float)code * step;
	}
}

/* A lossless store's. */
static void decode_floats(void *user, size_t i)
{
	struct bench *bench = user;
	decode(user, i);
	for (size_t p = 0, count = bench->posts; p < count; p++) {
		int32_t code = bench->out[p];
		bench->heights[p] = code == CODEC_NODATA ? HOLE : height_code_to_float(code);
	}
}

static void read_base(void *user, size_t i)
{
	struct bench *bench = user;
	bench_must(store_read_base(bench->reader, bench->tiles[i], bench->out, NULL));
}

static void read_blob(void *user, size_t i)
{
	struct bench *bench = user;
	sqlite3_bind_int64(bench->find, 1, (sqlite3_int64)tile_key(bench->tiles[i]));
	must_sql(bench, sqlite3_step(bench->find), SQLITE_ROW);
	size_t size = (size_t)sqlite3_column_bytes(bench->find, 1);
	memcpy(bench->copy, sqlite3_column_blob(bench->find, 1), size);
	sqlite3_reset(bench->find);
}

static void read_lmdb(void *user, size_t i)
{
	struct bench *bench = user;
	bench_lmdb_get(bench->lmdb, tile_key(bench->tiles[i]), bench->copy, bench->blobs[i].size);
}

static void cog_encode(void *user, size_t i)
{
	struct cog *cog = user;
	bench_gdal_encode(cog->memory, cog->bench->tiles[i]);
}

static void cog_decode(void *user, size_t i)
{
	struct cog *cog = user;
	bench_gdal_read(cog->memory, cog->bench->tiles[i]);
}

static void cog_decode_native(void *user, size_t i)
{
	struct cog *cog = user;
	bench_gdal_read_native(cog->memory, cog->bench->tiles[i]);
}

static void cog_read(void *user, size_t i)
{
	struct cog *cog = user;
	bench_gdal_read(cog->file, cog->bench->tiles[i]);
}

/* --- what it is measured on --- */

static void open_rows(struct bench *bench)
{
	must_sql(bench, sqlite3_open_v2(bench->path, &bench->db, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, NULL),
		 SQLITE_OK);
	must_sql(bench, sqlite3_prepare_v2(bench->db, "SELECT codec, blob FROM base WHERE key = ?1", -1, &bench->find,
					   NULL), SQLITE_OK);
	bench->copy = must_alloc(store_codec_bound(&bench->codec), 1);
	for (size_t i = 0; i < bench->count; i++) {
		struct blob *blob = &bench->blobs[i];
		sqlite3_bind_int64(bench->find, 1, (sqlite3_int64)tile_key(bench->tiles[i]));
		must_sql(bench, sqlite3_step(bench->find), SQLITE_ROW);
		blob->codec = sqlite3_column_int64(bench->find, 0);
		blob->size = (size_t)sqlite3_column_bytes(bench->find, 1);
		blob->bytes = must_alloc(blob->size, 1);
		memcpy(blob->bytes, sqlite3_column_blob(bench->find, 1), blob->size);
		sqlite3_reset(bench->find);
		bench->planes[i] = must_alloc(bench->posts, sizeof **bench->planes);
		bench_must(store_read_base(bench->reader, bench->tiles[i], bench->planes[i], NULL));
	}
}

/* The whole table, so that both trees are as tall as they are. */
static void fill_lmdb(struct bench *bench)
{
	struct store_numbers numbers;
	sqlite3_stmt *all;
	bench_must(store_count(bench->store, &numbers));
	if (!bench_lmdb_create(bench_path("lmdb"), (size_t)(3 * numbers.base_bytes) + (256u << 20), &bench->lmdb))
		return;
	must_sql(bench, sqlite3_prepare_v2(bench->db, "SELECT key, blob FROM base", -1, &all, NULL), SQLITE_OK);
	while (sqlite3_step(all) == SQLITE_ROW)
		bench_lmdb_put(bench->lmdb, (uint64_t)sqlite3_column_int64(all, 0), sqlite3_column_blob(all, 1),
			       (size_t)sqlite3_column_bytes(all, 1));
	sqlite3_finalize(all);
	bench_lmdb_commit(bench->lmdb);
}

static void begin(struct bench *bench, const char *path)
{
	*bench = (struct bench){.path = path};
	bench_must(store_open(path, &(struct store_options){.mode = STORE_READ}, &bench->store));
	bench_must(store_reader_create(bench->store, &bench->reader));
	const struct store_meta *meta = store_meta(bench->store);
	bench->step = meta->step;
	bench->posts = (size_t)tile_posts(&meta->extent) * tile_posts(&meta->extent);
	bench->tiles = bench_tiles(&meta->extent, TILES_MOST, &bench->count);
	bench_must(store_codec_init(&bench->codec, tile_posts(&meta->extent),
			      meta->pack == STORE_PACK_SMALL ? CODEC_SMALL : CODEC_GROUND));
	bench->planes = must_alloc(bench->count, sizeof *bench->planes);
	bench->blobs = must_alloc(bench->count, sizeof *bench->blobs);
	bench->out = must_alloc(bench->posts, sizeof *bench->out);
	bench->heights = must_alloc(bench->posts, sizeof *bench->heights);
	open_rows(bench);
	fill_lmdb(bench);
}

static void end(struct bench *bench)
{
	bench_lmdb_destroy(bench->lmdb);
	sqlite3_finalize(bench->find);
	sqlite3_close(bench->db);
	for (size_t i = 0; i < bench->count; i++) {
		mem_free(bench->planes[i]);
		mem_free(bench->blobs[i].bytes);
	}
	mem_free(bench->planes);
	mem_free(bench->blobs);
	mem_free(bench->out);
	mem_free(bench->heights);
	mem_free(bench->copy);
	mem_free(bench->tiles);
	store_codec_finish(&bench->codec);
	store_reader_destroy(bench->reader);
	store_close(bench->store);
}

/* That both decode the same tiles: each is within the bound of the same posts. Where a terrain has no
 * whole tile the rasters' blocks lie otherwise, and there is nothing to hold one against. */
static void check(struct bench *bench, struct cog *cog, const char *path)
{
	const struct store_meta *meta = store_meta(bench->store);
	if (meta->extent.width < BENCH_BLOCK || meta->extent.height < BENCH_BLOCK)
		return;
	for (size_t i = 0; i < bench->count; i++) {
		(bench->step > 0 ? decode_metres : decode_floats)(bench, i);
		cog_decode(cog, i);
		const float *theirs = bench_gdal_heights(cog->memory);
		for (size_t p = 0; p < (size_t)BENCH_BLOCK * BENCH_BLOCK; p++) {
			size_t x = p % BENCH_BLOCK, y = BENCH_BLOCK - 1 - p / BENCH_BLOCK;
			float ours = bench->heights[y * (BENCH_BLOCK + 1) + x];
			/* A hole is any number to them. The last term is what float32 rounds. */
			double most = 2 * meta->max_error + 4e-7 * fabs((double)ours);
			if (ours > HOLE + 1 && fabs((double)ours - (double)theirs[p]) > most)
				bench_must(fail_with(STATUS_INPUT, "%s: its blocks are not the store's tiles; cut it "
						     "from the same posts, as store.py does", path));
		}
	}
}

static void print(const struct bench *bench, struct bench_row *row, int runs)
{
	double rate = bench_median(row->rates, (size_t)runs);
	printf("{\"bench\": \"store\", \"row\": \"%s\", \"subject\": \"%s\", \"tiles\": %zu, \"tiles_s\": %.1f, "
	       "\"mb_s\": %.1f}\n",
	       row->name, row->subject, bench->count, rate, rate * row->bytes * 1e-6);
}

static size_t add(struct bench_row *rows, size_t count, const char *name, const char *subject,
		  void (*once)(void *user, size_t i), void *user, double bytes)
{
	rows[count] = (struct bench_row){name, subject, once, user, bytes, {0}};
	return count + 1;
}

int bench_read(const char *path, char **cogs, int cog_count, int runs)
{
	static struct bench_row rows[6 + 4 * COGS_MOST];
	struct bench bench;
	struct cog opened[COGS_MOST];
	size_t open_count = 0, count = 0;
	if (cog_count > COGS_MOST)
		bench_must(fail_with(STATUS_USAGE, "bench: %d rasters; give at most %d", cog_count, COGS_MOST));
	begin(&bench, path);
	const double plane = 4.0 * (double)bench.posts, block = 4.0 * BENCH_BLOCK * BENCH_BLOCK;
	double blob = 0;
	for (size_t i = 0; i < bench.count; i++)
		blob += (double)bench.blobs[i].size / (double)bench.count;
	count = add(rows, count, "encode", "", encode, &bench, plane);
	count = add(rows, count, "decode", "", bench.step > 0 ? decode_metres : decode_floats, &bench, plane);
	count = add(rows, count, "decode native", "", decode, &bench, plane);
	count = add(rows, count, "read", "", read_base, &bench, plane);
	count = add(rows, count, "raw read", "", read_blob, &bench, blob);
	if (bench.lmdb != NULL)
		count = add(rows, count, "raw read", "lmdb", read_lmdb, &bench, blob);
	for (int i = 0; i < cog_count; i++) {
		struct cog *cog = &opened[i];
		cog->bench = &bench;
		if (!bench_gdal_open(cogs[i], true, &cog->memory) || !bench_gdal_open(cogs[i], false, &cog->file))
			break;
		open_count++;
		check(&bench, cog, cogs[i]);
		count = add(rows, count, "encode", cogs[i], cog_encode, cog, block);
		count = add(rows, count, "decode", cogs[i], cog_decode, cog, block);
		count = add(rows, count, "decode native", cogs[i], cog_decode_native, cog, block);
		count = add(rows, count, "read", cogs[i], cog_read, cog, block);
	}
	bench_rows(rows, count, bench.count, runs, SECONDS);
	for (size_t i = 0; i < count; i++)
		print(&bench, &rows[i], runs);
	for (size_t i = 0; i < open_count; i++) {
		bench_gdal_close(opened[i].memory);
		bench_gdal_close(opened[i].file);
	}
	end(&bench);
	return 0;
}
