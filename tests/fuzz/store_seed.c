/* Small stores, made by this version: each kind of base, untouched and deformed. */
#include "store_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct kind {
	struct extent extent;
	double step;
	int working;
	bool deformed;
	bool holes, flat;
	int page_size; /* of the file: small ones leave more of an input to what matters; 0: as made */
};

static const struct kind kinds[] = {
	{{20, 13, 2, 8}, 0.125, 0, false, false, false, 1024},
	{{20, 13, 2, 8}, 0.5, -1, true, true, false, 1024},
	{{30, 17, 0.5, 8}, 0, 0, true, true, false, 512},
	{{40, 33, 1, 16}, 0.0625, 1, true, false, false, 2048},
	{{9, 9, 1, 8}, 0.5, -3, true, false, true, 512},
	{{17, 17, 30, 8}, 0.125, 0, false, true, true, 512},
	{{12, 9, 2, 8}, 0.125, -1, true, true, false, 0},
};

static int32_t code_at(const struct kind *kind, int64_t x, int64_t y)
{
	const struct extent *extent = &kind->extent;
	if (x >= extent->width || y >= extent->height || (kind->holes && (kind->flat || (x / 3 + y) % 7 == 0)))
		return HEIGHT_CODE_NODATA;
	int32_t code;
	/* Rough enough that some tiles are packed, not squeezed. */
	uint64_t any = (uint64_t)(x * 1000 + y);
	double metres = kind->flat ? 100 : 100 + (double)(fuzz_below(&any, 64) + (uint64_t)y) * 0.5;
	fuzz_check(height_code_encode(metres, kind->step, &code));
	return code;
}

/* Some as an import puts tiles: in levels, and odd levels' without bytes. `packer`: NULL for the others. */
static void put_tile(const struct kind *kind, struct tile tile, struct store_packer *packer, struct store *store)
{
	static int32_t codes[17 * 17];
	const struct extent *extent = &kind->extent;
	int64_t side = tile_posts(extent), scale = (int64_t)1 << tile.level;
	struct store_range range = {(double)NAN, (double)NAN, 0.5 * tile.level};
	for (int64_t i = 0; i < side * side; i++)
		codes[i] = code_at(kind, ((int64_t)tile.x * extent->cells + i % side) * scale,
				   ((int64_t)tile.y * extent->cells + i / side) * scale);
	/* Over the whole subtree. */
	for (int64_t y = (int64_t)tile.y * extent->cells * scale; y <= (int64_t)(tile.y + 1) * extent->cells * scale; y++)
		for (int64_t x = (int64_t)tile.x * extent->cells * scale; x <= (int64_t)(tile.x + 1) * extent->cells * scale;
		     x++) {
			double metres = height_code_metres(code_at(kind, x, y), kind->step);
			range.low = isnan(range.low) || metres < range.low ? metres : range.low;
			range.high = isnan(range.high) || metres > range.high ? metres : range.high;
		}
	if (packer == NULL) {
		fuzz_check(store_put_base(store, tile, codes, &range) == STATUS_OK);
		return;
	}
	struct store_packed packed = store_pack(packer, tile, codes);
	fuzz_check(store_put_packed(store, tile, &packed, &range) == STATUS_OK);
}

static void make_base(const struct kind *kind, const char *path)
{
	const struct extent *extent = &kind->extent;
	struct store_meta meta = {.extent = *extent, .step = kind->step, .max_error = 0.5, .srs = "LOCAL_CS[\"a\"]",
				  .vertical = "", .sources = "a.tif\nb.tif"};
	struct store *store;
	struct store_packer *packer = NULL;
	fuzz_check(store_create(path, &meta, true, &store) == STATUS_OK);
	if (extent->width % 2 == 0)
		fuzz_check(store_packer_create(&meta, &packer) == STATUS_OK);
	for (int level = 0; level <= extent_coarsest(extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(extent, level); x++)
				put_tile(kind, (struct tile){level, x, y}, packer, store);
	store_packer_destroy(packer);
	fuzz_check(store_publish(store) == STATUS_OK);
	store_close(store);
}

static void deform(const struct kind *kind, const char *path)
{
	static int32_t offset[17 * 17];
	static uint8_t dirt[17 * 17];
	static int32_t heaped[17 * 17], pressed[17 * 17], shear[17 * 17], dug[17 * 17];
	uint32_t side = tile_posts(&kind->extent);
	struct store *store;
	fuzz_check(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store) == STATUS_OK);
	fuzz_check(store_set_working_level(store, kind->working) == STATUS_OK);
	/* Nothing on the edges: neighbours need no row. */
	for (uint32_t y = 1; y + 1 < side; y++)
		for (uint32_t x = 1; x + 1 < side; x++) {
			uint64_t any = x * 100 + y;
			offset[y * side + x] = -(int32_t)fuzz_below(&any, 1 << 20);
			dirt[y * side + x] = (uint8_t)(x * 30);
			heaped[y * side + x] = (int32_t)fuzz_below(&any, 1 << 16) - (1 << 15);
			pressed[y * side + x] = -offset[y * side + x];
			dug[y * side + x] = (int32_t)fuzz_below(&any, 1 << 14);
			shear[y * side + x] = (int32_t)fuzz_below(&any, 1 << 15) | (int32_t)fuzz_below(&any, 1 << 15) << 16;
		}
	struct store_page page = {{kind->working, 0, 0}, {offset, dirt, heaped, pressed, shear, dug}};
	struct store_run run = {.scene_hash = "0123abcd", .step = 12, .time = 0.25, .compacted = 12345,
				.state = "{\"poses\":[],\"ended\":false}"};
	struct store_commit_result result;
	fuzz_check(store_commit(store, &page, 1, &run, &result) == STATUS_OK);
	store_close(store);
}

static void repage(const char *path, int page_size)
{
	char sql[64];
	sqlite3 *db;
	fuzz_check(sqlite3_open(path, &db) == SQLITE_OK);
	/* The same bytes at any time, of any user. */
	fuzz_check(sqlite3_exec(db, "UPDATE run SET made = 1000000000, who = 'a'", NULL, NULL, NULL) == SQLITE_OK);
	snprintf(sql, sizeof sql, "PRAGMA page_size=%d; VACUUM", page_size);
	fuzz_check(page_size == 0 || sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK);
	sqlite3_close(db);
}

size_t fuzz_seed(size_t index, uint8_t *data, size_t room)
{
	if (index >= sizeof kinds / sizeof *kinds)
		return 0;
	const struct kind *kind = &kinds[index];
	const char *path = store_file_fresh();
	make_base(kind, path);
	if (kind->deformed)
		deform(kind, path);
	repage(path, kind->page_size);
	size_t size = fuzz_read(path, data, room);
	fuzz_check(size > 0 && size <= room);
	return size;
}
