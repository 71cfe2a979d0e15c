/* Shared posts have the same bits in every tile that holds them, though each is packed alone. */
#include "fixture.h"

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

static void ground_store(const struct ground *ground, enum store_pack pack, const char *path)
{
	struct store_meta meta = terrain_meta();
	meta.extent = ground->extent;
	meta.step = ground->step;
	meta.max_error = ground->step / 2;
	meta.pack = pack;
	struct store *store;
	size_t side = ground->extent.cells + 1;
	int32_t *codes = mem_alloc(side * side, sizeof *codes);
	assert_ok(store_create(path, &meta, true, &store));
	for (int level = 0; level <= extent_coarsest(&meta.extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&meta.extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&meta.extent, level); x++) {
				struct store_range range;
				ground_tile(ground, (struct tile){level, x, y}, codes, &range);
				assert_ok(store_put_base(store, (struct tile){level, x, y}, codes, &range));
			}
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
	for (uint32_t trial = 0; trial < 8; trial++) {
		struct ground ground = {.extent = {.width = 150 + 13 * trial, .height = 111 + 5 * trial, .spacing = 2,
						  .cells = cells[trial & 1]},
					.step = trial & 2 ? 0 : 0.125, .seed = 100 + trial};
		const char *path = in_folder("edges.furrow");
		ground_store(&ground, trial & 4 ? STORE_PACK_SMALL : STORE_PACK_FAST, path);
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(shared_posts_decode_to_the_same_bits_at_every_level),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
