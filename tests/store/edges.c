/* Shared posts have the same bits in every tile that holds them, though each is packed alone. */
#include "fixture.h"
#include "../support/program.h"

/* Heights of any kind with holes, by post of level 0: so that no tile packs as its neighbour does. */
struct ground {
	struct extent extent;
	double step;
	uint32_t seed;
};

static int32_t ground_code(const struct ground *ground, int64_t x, int64_t y)
{
	if (x >= ground->extent.width || y >= ground->extent.height)
		return HEIGHT_CODE_NODATA;
	uint32_t h = mix((uint32_t)x, (uint32_t)y, ground->seed);
	uint32_t kind = mix((uint32_t)(x / 23), (uint32_t)(y / 19), ground->seed + 1) % 6;
	if (kind == 0 || (kind == 1 && h % 5 == 0))
		return HEIGHT_CODE_NODATA;
	int32_t code = kind == 2   ? 77
		       : kind == 3 ? (int32_t)(x * 3 - y * 5)
		       : kind == 4 ? (int32_t)(h >> 12) - (1 << 19)
				   : (int32_t)(1000 * sin((double)x / 30)) + (int32_t)(h % 7);
	if (ground->step > 0)
		return code;
	assert_true(height_code_encode((double)((float)code / 3), 0, &code)); /* lossless: any float */
	return code;
}

/* Codes of a tile, and the range of its subtree. */
static void ground_tile(const struct ground *ground, struct tile tile, int32_t *codes, struct store_range *range)
{
	int64_t scale = (int64_t)1 << tile.level, n = ground->extent.cells;
	int32_t low = INT32_MAX, high = INT32_MIN;
	for (int64_t y = 0; y <= n; y++)
		for (int64_t x = 0; x <= n; x++)
			codes[y * (n + 1) + x] = ground_code(ground, (tile.x * n + x) * scale, (tile.y * n + y) * scale);
	for (int64_t y = tile.y * n * scale; y <= (tile.y + 1) * n * scale; y++)
		for (int64_t x = tile.x * n * scale; x <= (tile.x + 1) * n * scale; x++) {
			int32_t code = ground_code(ground, x, y);
			if (code == HEIGHT_CODE_NODATA)
				continue;
			low = code < low ? code : low;
			high = code > high ? code : high;
		}
	*range = (struct store_range){(double)NAN, (double)NAN, 0};
	if (low <= high) {
		range->low = height_code_metres(low, ground->step);
		range->high = height_code_metres(high, ground->step);
	}
}

/* `packed`: as an import puts tiles, so that those of odd levels have no bytes. */
static void ground_store(const struct ground *ground, enum store_pack pack, bool packed, const char *path)
{
	struct store_meta meta = terrain_meta();
	meta.extent = ground->extent;
	meta.step = ground->step;
	meta.max_error = ground->step / 2;
	meta.pack = pack;
	struct store *store;
	size_t side = ground->extent.cells + 1;
	int32_t *codes = mem_alloc(side * side, sizeof *codes);
	struct store_packer *packer;
	assert_ok(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
	assert_ok(store_packer_create(&meta, &packer));
	for (int level = 0; level <= extent_coarsest(&meta.extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&meta.extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&meta.extent, level); x++) {
				struct store_range range;
				ground_tile(ground, (struct tile){level, x, y}, codes, &range);
				struct store_packed blob = store_pack(packer, (struct tile){level, x, y}, codes);
				assert_true(blob.size <= store_packed_most(packer));
				assert_int_equal(blob.codec == CODEC_BELOW, level % 2 != 0);
				if (packed)
					assert_ok(store_put_packed(store, (struct tile){level, x, y}, &blob, &range));
				else
					assert_ok(store_put_base(store, (struct tile){level, x, y}, codes, &range));
			}
	store_packer_destroy(packer);
	assert_ok(store_publish(store));
	store_close(store);
	mem_free(codes);
}

/* `count` posts from `a` and `b` on, each with its own stride. */
static void assert_same(const int32_t *a, const int32_t *b, size_t stride, size_t count)
{
	for (size_t i = 0; i < count; i++)
		assert_int_equal(a[i * stride], b[i * stride]);
}

static void assert_edges(const struct ground *ground, struct store_reader *reader, struct tile tile,
			 int32_t *here, int32_t *there)
{
	const struct extent *whole = &ground->extent;
	size_t side = whole->cells + 1, n = whole->cells;
	struct tile east = {tile.level, tile.x + 1, tile.y}, north = {tile.level, tile.x, tile.y + 1};
	struct tile corner = {tile.level, tile.x + 1, tile.y + 1};
	struct store_range range;
	assert_ok(store_read_base(reader, tile, here, NULL));
	ground_tile(ground, tile, there, &range);
	assert_memory_equal(here, there, side * side * sizeof *here); /* as they were put */
	if (extent_has(whole, east)) {
		assert_ok(store_read_base(reader, east, there, NULL));
		assert_same(here + n, there, side, side);
	}
	if (extent_has(whole, north)) {
		assert_ok(store_read_base(reader, north, there, NULL));
		assert_same(here + n * side, there, 1, side);
	}
	if (extent_has(whole, corner)) {
		assert_ok(store_read_base(reader, corner, there, NULL));
		assert_int_equal(here[side * side - 1], there[0]);
	}
	/* A coarser tile's posts are every second of this one's. */
	struct tile above = tile_ancestor(tile, tile.level + 1);
	if (!extent_has(whole, above))
		return;
	assert_ok(store_read_base(reader, above, there, NULL));
	const int32_t *quarter = there + (tile.y & 1) * n / 2 * side + (tile.x & 1) * n / 2;
	for (size_t y = 0; y <= n; y += 2)
		for (size_t x = 0; x <= n; x += 2)
			assert_int_equal(here[y * side + x], quarter[y / 2 * side + x / 2]);
}

static void shared_posts_decode_to_the_same_bits_at_every_level(void **state)
{
	static const uint32_t cells[] = {8, 32};
	static const double steps[] = {0.125, 0, 204.0 / 1024, 0.3048};
	for (uint32_t trial = 0; trial < 32; trial++) {
		struct ground ground = {.extent = {.width = 150 + 13 * (trial % 8), .height = 111 + 5 * (trial % 8), .spacing = 2,
						  .cells = cells[trial & 1]},
					.step = steps[trial >> 1 & 3], .seed = 100 + trial};
		const char *path = in_folder("edges.furrow");
		ground_store(&ground, trial & 8 ? STORE_PACK_SMALL : STORE_PACK_FAST, (trial & 16) != 0, path);
		struct store *store = open_store(path, STORE_READ);
		struct store_reader *reader;
		assert_ok(store_reader_create(store, &reader));
		size_t posts = (size_t)(ground.extent.cells + 1) * (ground.extent.cells + 1);
		int32_t *here = mem_alloc(posts, sizeof *here), *there = mem_alloc(posts, sizeof *there);
		for (int level = 0; level <= extent_coarsest(&ground.extent); level++)
			for (uint32_t y = 0; y < extent_tiles_y(&ground.extent, level); y++)
				for (uint32_t x = 0; x < extent_tiles_x(&ground.extent, level); x++)
					assert_edges(&ground, reader, (struct tile){level, x, y}, here, there);
		mem_free(here);
		mem_free(there);
		store_reader_destroy(reader);
		verified(store);
		store_close(store);
	}
}

/* Writes a base row of a given codec and blob, with its right hash. */
static void put_row(const char *path, struct tile tile, int64_t codec, const void *bytes, size_t size)
{
	struct store *store = open_store(path, STORE_WRITE);
	struct row row = {.tile = tile, .low = -1, .high = 1, .codec = codec, .bytes = bytes, .size = size};
	row.hash = store_rows_hash(ROW_BASE, &row);
	assert_ok(store_rows_put(&store->rows, ROW_BASE, &row));
	store_close(store);
}

/* The message for reading a tile of a store that is damaged. */
static void assert_refused(const char *path, struct tile tile, const char *why)
{
	struct store *store = open_store(path, STORE_READ);
	struct store_reader *reader;
	int32_t *codes = mem_alloc(33 * 33, sizeof *codes);
	assert_ok(store_reader_create(store, &reader));
	assert_status(store_read_base(reader, tile, codes, NULL), STATUS_INPUT);
	if (strstr(failure_message(), why) == NULL)
		fail_msg("not '%s': %s", why, failure_message());
	mem_free(codes);
	store_reader_destroy(reader);
	store_close(store);
}

static void a_tile_that_the_tiles_below_do_not_make_is_refused(void **state)
{
	const struct ground ground = {.extent = {.width = 150, .height = 40, .spacing = 2, .cells = 32}, .step = 0.125, .seed = 3};
	const char *path = in_folder("damaged.furrow");
	const struct tile odd = {1, 2, 0}, even = {2, 1, 0}, below = {0, 4, 1};
	const uint8_t right = store_below_children(&ground.extent, odd), wrong = (uint8_t)(right ^ 2), rough[3] = {1, 2, 3};
	char drop[96];
	assert_int_equal(right, 5); /* the last column of two rows */
	ground_store(&ground, STORE_PACK_FAST, true, path);
	put_row(path, odd, CODEC_BELOW, &wrong, 1);
	assert_refused(path, odd, "cannot be decoded");
	put_row(path, odd, CODEC_BELOW, rough, 3);
	assert_refused(path, odd, "cannot be decoded");
	put_row(path, even, CODEC_BELOW, &right, 1); /* of an even level, and without a level below */
	assert_refused(path, even, "cannot be decoded");
	put_row(path, below, CODEC_BELOW, &right, 1);
	assert_refused(path, below, "cannot be decoded");
	put_row(path, odd, CODEC_BELOW, &right, 1);
	assert_refused(path, odd, "level 0 x 4 y 1: it cannot be decoded");
	put_row(path, below, CODEC_LEVELS, rough, 3);
	assert_refused(path, odd, "level 0 x 4 y 1: it cannot be decoded");
	snprintf(drop, sizeof drop, "UPDATE base SET low = -2 WHERE key = %lld", (long long)tile_key(below));
	raw_sql(path, drop);
	assert_refused(path, odd, "level 0 x 4 y 1: its hash is wrong");
	snprintf(drop, sizeof drop, "DELETE FROM base WHERE key = %lld", (long long)tile_key(below));
	raw_sql(path, drop);
	assert_refused(path, odd, "a tile below it is missing");
	snprintf(drop, sizeof drop, "DELETE FROM base WHERE key = %lld", (long long)tile_key(odd));
	raw_sql(path, drop);
	assert_refused(path, odd, "it is missing");
}

TEST_PROGRAM(edges)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(shared_posts_decode_to_the_same_bits_at_every_level),
		cmocka_unit_test(a_tile_that_the_tiles_below_do_not_make_is_refused),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
