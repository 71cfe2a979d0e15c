/*
 * Whole files: anything that is opened as a store, for reading or for writing, ends in a status and
 * one line, within the memory that its header allows. A store that verify finds no problem with is
 * then read to the last post, and still has none after an epoch.
 *
 * An input is the file's bytes. A hash of them decides whether it is opened for writing.
 */
#include "store_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#define VERIFY_BYTES (48u << 20) /* verify's cache of tiles, at most */
#define VERIFY_TILES 128
/* Of the store's own, a post: rows of the writer and of a reader (36 each), verify's and the hash's
 * planes, a window's; and an epoch's, a plane a level. */
#define BYTES_A_POST (36 * 2 + 24 + 4 * (TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1))
#define BYTES_MORE (1u << 20) /* paths, statements, LZ4's tables, stdio */
#define TEXTS 7               /* copies of a text that is as long as the file */
/* SQLite's own: two connections' caches, values as long as the file; and one that only says that it is as
 * long as the limit that the store sets (store_connect.c): SQLite makes room for it before it looks. */
#define SQLITE_BYTES (36u << 20)
#define SQLITE_FILES 8

#define WINDOW 24
#define EPOCH_POSTS (2u << 20)

const size_t fuzz_size_max = 256 << 10;
const char *const fuzz_words[] = {NULL};

static void check_line(const char *text)
{
	fuzz_check(text[0] != '\0');
	for (const char *c = text; *c != '\0'; c++)
		fuzz_check((unsigned char)*c >= 0x20 && *c != 0x7f);
}

/* The outcome of a call: fine, or told. */
static bool done(enum status status)
{
	if (status == STATUS_OK)
		return true;
	fuzz_check(status == STATUS_INPUT || status == STATUS_FAILED);
	check_line(failure_message());
	return false;
}

/* What a clean store may not answer. */
static void must(bool clean, enum status status)
{
	bool good = done(status);
	fuzz_check(good || !clean);
}

const char *store_file_fresh(void)
{
	static const char *const beside[] = {"store.furrow", "store.furrow-wal", "store.furrow-shm",
					     "store.furrow-journal", "store.furrow-lock", "store.furrow.part"};
	for (size_t i = 0; i < sizeof beside / sizeof *beside; i++)
		unlink(fuzz_path(beside[i]));
	return fuzz_path(beside[0]);
}

/* --- memory --- */

static size_t posts_of(uint32_t cells)
{
	return (size_t)(cells + 1) * (cells + 1);
}

static void allow(uint32_t cells, size_t size)
{
	size_t posts = posts_of(cells), verify = 4 * posts * VERIFY_TILES;
	fuzz_memory_allow(posts * BYTES_A_POST + (verify < VERIFY_BYTES ? verify : VERIFY_BYTES) + TEXTS * size +
			  BYTES_MORE);
}

/* --- reading --- */

static enum status take_key(void *user, uint64_t key)
{
	++*(uint64_t *)user;
	return STATUS_OK;
}

static void read_windows(struct store_reader *reader, const struct extent *extent, bool clean, uint64_t hash)
{
	static double values[WINDOW * WINDOW];
	int coarsest = extent_coarsest(extent);
	for (int i = 0; i < 6; i++) {
		/* The corners, the middle; levels from the finest there can be. */
		int level = i < 3 ? i : -(int)(hash >> i & 15);
		level = level > coarsest ? coarsest : level;
		int64_t width = extent_posts(extent->width, level), height = extent_posts(extent->height, level);
		int64_t x = i % 3 == 0 ? -4 : i % 3 == 1 ? width / 2 : width - WINDOW / 2;
		int64_t y = i % 2 == 0 ? -4 : height - WINDOW / 2;
		enum store_layer layer = (enum store_layer)((hash >> 8) + (unsigned)i) % STORE_LAYERS;
		/* Below level 0 more relief than the lattice holds is refused, and levels far from what is stored. */
		must(clean && level >= 0 && layer == STORE_BASE,
		     store_read_posts(reader, layer, level, (struct post_rect){x, y, x + WINDOW, y + WINDOW}, values));
	}
}

static void read_samples(struct store_reader *reader, const struct extent *extent)
{
	double east = (double)(extent->width - 1) * extent->spacing, north = (double)(extent->height - 1) * extent->spacing;
	const double points[][2] = {{0, 0}, {east, north}, {east / 2, north / 3}, {-1, 0}, {east * 1.0001, 0},
				    {(double)NAN, 0}, {9, 9}};
	for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
		struct store_sample sample;
		if (!done(store_sample(reader, points[i][0], points[i][1], &sample)))
			continue;
		fuzz_check(sample.disturbance <= UINT8_MAX);
		fuzz_check(sample.nodata || (isfinite(sample.height) && isfinite(sample.base)));
		fuzz_check(isfinite(sample.deposited) && sample.plastic_sinkage >= 0 && fabs(sample.shear[0]) < 1 && fabs(sample.shear[1]) < 1);
	}
}

#define ALL_PLANES ((1u << PLANES) - 1)

struct planes {
	void *of[PLANES];
};

static struct planes planes_make(size_t posts)
{
	struct planes planes;
	for (int plane = 0; plane < PLANES; plane++) {
		planes.of[plane] = malloc(posts * plane_bytes((enum plane)plane));
		fuzz_check(planes.of[plane] != NULL);
	}
	return planes;
}

static void planes_free(struct planes *planes)
{
	for (int plane = 0; plane < PLANES; plane++)
		free(planes->of[plane]);
}

static void read_tiles(struct store_reader *reader, const struct extent *extent, int finest, bool clean, uint64_t hash)
{
	size_t posts = posts_of(extent->cells);
	int32_t *codes = malloc(posts * sizeof *codes);
	struct planes planes = planes_make(posts);
	fuzz_check(codes != NULL);
	for (int level = finest; level <= extent_coarsest(extent); level++) {
		struct tile tile = {level, (uint32_t)(hash % extent_tiles_x(extent, level)),
				    (uint32_t)(hash >> 32) % extent_tiles_y(extent, level)};
		struct store_range range;
		double low, high;
		unsigned present;
		bool found;
		uint64_t keys = 0;
		if (level >= 0) {
			must(clean, store_read_base(reader, tile, codes, &range));
			must(clean, store_read_base_range(reader, tile, &range));
		}
		must(clean, store_read_offset_range(reader, tile, &low, &high, &found));
		must(clean, store_read_deformed(reader, tile, ALL_PLANES, planes.of, &present));
		must(clean, store_each_offset(reader, level, take_key, &keys));
	}
	free(codes);
	planes_free(&planes);
}

static void read_all(struct store *store, bool clean, uint64_t hash)
{
	struct store_reader *reader;
	const struct extent *extent = &store_meta(store)->extent;
	enum status status = store_reader_create(store, &reader);
	must(clean, status);
	if (status != STATUS_OK)
		return;
	read_windows(reader, extent, clean, hash);
	read_samples(reader, extent);
	read_tiles(reader, extent, store_finest(store), clean, hash);
	store_reader_destroy(reader);
}

/* --- looking --- */

static void see_problem(void *user, const char *text)
{
	check_line(text);
	if (getenv("FUZZ_TELL") != NULL)
		fprintf(stderr, "problem: %s\n", text);
}

static bool verify(struct store *store)
{
	struct store_check check;
	return done(store_verify(store, see_problem, NULL, NULL, &check)) && check.problems == 0;
}

/* True if nothing is wrong with it. */
static bool look(struct store *store)
{
	struct store_numbers numbers;
	uint64_t hash, again;
	bool clean = verify(store);
	must(clean, store_count(store, &numbers));
	enum status status = store_content_hash(store, &hash);
	must(clean, status);
	if (status == STATUS_OK)
		fuzz_check(store_content_hash(store, &again) == STATUS_OK && hash == again);
	return clean;
}

/* --- writing --- */

/* The tile as it is: its edges are its neighbours' too, and stay. */
static bool read_page(struct store *store, struct tile tile, const struct planes *planes)
{
	struct store_reader *reader;
	unsigned present;
	if (!done(store_reader_create(store, &reader)))
		return false;
	bool good = done(store_read_deformed(reader, tile, ALL_PLANES, planes->of, &present));
	store_reader_destroy(reader);
	return good;
}

static bool commit(struct store *store, bool clean, uint64_t hash)
{
	const struct extent *extent = &store_meta(store)->extent;
	int level, coarsest = extent_coarsest(extent);
	size_t side = tile_posts(extent), posts = side * side;
	if (!store_has_working_level(store, &level)) {
		level = coarsest - (int)((hash >> 8) % (uint64_t)(coarsest - TILE_LEVEL_MIN + 1));
		must(true, store_set_working_level(store, level));
	}
	/* An epoch of the largest tiles writes one a level, of 40 levels: slow, and no news. */
	if ((size_t)(coarsest - level + 1) * posts > EPOCH_POSTS)
		return true;
	struct tile tile = {level, (uint32_t)(hash % extent_tiles_x(extent, level)),
			    (uint32_t)(hash >> 40) % extent_tiles_y(extent, level)};
	struct planes planes = planes_make(posts);
	bool good = read_page(store, tile, &planes);
	fuzz_check(good || !clean);
	for (size_t y = 1; y + 1 < side; y++)
		for (size_t x = 1; x + 1 < side; x++) {
			size_t i = y * side + x;
			((int32_t *)planes.of[PLANE_OFFSET])[i] = (int32_t)(hash >> i % 32);
			((uint8_t *)planes.of[PLANE_DISTURBANCE])[i] = (uint8_t)(hash >> i % 48);
			((int32_t *)planes.of[PLANE_DEPOSITED])[i] = (int32_t)(hash >> i % 31);
			((int32_t *)planes.of[PLANE_PLASTIC_SINKAGE])[i] = (int32_t)(hash >> i % 30 & INT32_MAX);
			((int32_t *)planes.of[PLANE_DUG])[i] = (int32_t)(hash >> i % 29 & INT32_MAX);
			((int32_t *)planes.of[PLANE_SHEAR])[i] = (int32_t)(hash >> i % 32 & 0x7fff7fff);
		}
	if (good) {
		struct store_page page = {.tile = tile};
		/* Now and then a model that keeps no state. */
		for (int plane = 0; plane < ((hash >> 50 & 1) != 0 ? PLANES : PLANE_DEPOSITED); plane++)
			page.planes[plane] = planes.of[plane];
		struct store_run run = {.scene_hash = "00", .step = 1, .time = 0.5, .state = "{}"};
		struct store_commit_result result;
		enum status status = store_commit(store, &page, 1, &run, &result);
		good = status == STATUS_OK;
		must(clean, status);
		must(clean, store_checkpoint(store));
	}
	planes_free(&planes);
	return good;
}

static void write_all(struct store *store, bool clean, uint64_t hash)
{
	bool good = commit(store, clean, hash);
	if (hash >> 20 & 1)
		good &= commit(store, clean, hash * 31);
	bool still = look(store);
	fuzz_check(still || !clean || !good);
	if ((hash >> 21 & 3) == 0) {
		enum status status = store_reset(store, true);
		must(clean, status);
		still = look(store);
		fuzz_check(still || !clean);
	}
}

/* --- */

/* Before a seed is made. */
static __attribute__((constructor)) void begin(void)
{
	fuzz_memory_leave_out_sqlite();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct store *store;
	uint64_t hash = XXH3_64bits(data, size);
	bool writing = hash & 1;
	const char *path = store_file_fresh();
	fuzz_write(path, data, size);
	sqlite3_memory_highwater(1);
	allow(TILE_CELLS_MAX, size); /* what the header says is not known yet */
	struct store_options options = {.mode = writing ? STORE_WRITE : STORE_READ, .durable_full = hash & 2};
	if (done(store_open(path, &options, &store))) {
		fuzz_check(extent_problem(&store_meta(store)->extent) == NULL);
		allow(store_meta(store)->extent.cells, size);
		bool clean = look(store);
		read_all(store, clean, hash);
		if (writing)
			write_all(store, clean, hash);
		store_close(store);
	}
	fuzz_memory_allow_all();
	fuzz_check(sqlite3_memory_highwater(0) <= (sqlite3_int64)(SQLITE_BYTES + SQLITE_FILES * size));
	return 0;
}
