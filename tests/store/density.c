/*
 * What a rut takes in the file, in bytes a deformed post: no more than 8 for all that is kept of it.
 *
 * The rut is drawn, not driven: what a wheel leaves that presses along a winding path over hills, in posts of
 * 1 cm, with all that is rough about it: a scallop for each station, posts that do not lie along the path,
 * a rim at the angle of repose whose grains are whole quanta.
 */
#include "fixture.h"
#include "../support/program.h"

enum { CELLS = 256, TILES = 8, LEVEL = -2, SIDE_POSTS = CELLS + 1, TILE_POSTS = SIDE_POSTS * SIDE_POSTS };

static struct store *make(const char *path)
{
	const struct store_meta meta = {.extent = {513, 513, 0.04, CELLS}, .step = 0.01, .srs = "", .vertical = "", .sources = ""};
	const struct tile tiles[] = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 0}};
	int32_t *codes = calloc(TILE_POSTS, sizeof *codes);
	struct store *store;
	assert_ok(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
	for (size_t i = 0; i < sizeof tiles / sizeof *tiles; i++)
		assert_ok(store_put_base(store, tiles[i], codes, &(struct store_range){0, 0, 0}));
	assert_ok(store_publish(store));
	store_close(store);
	free(codes);
	store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, LEVEL));
	return store;
}

struct soil {
	double offset, heaped, pressed, shear;
	unsigned dirt;
};

/* -1 .. 1, of a post. */
static double rough(int64_t x, int64_t y, uint32_t seed)
{
	return mix((uint32_t)x, (uint32_t)y, seed) % 2001 / 1000.0 - 1;
}

/* At a post of 1 cm. */
static struct soil soil_at(int64_t px, int64_t py)
{
	const double half = 0.2, radius = 0.5, sample = 0.01, quantum = 0x1p-20;
	double x = px * 0.01, y = py * 0.01;
	double slope = 2 / 3.0 * cos(x / 3), across = (y - 10 - 2 * sin(x / 3)) / sqrt(1 + slope * slope);
	double along = x * sqrt(1 + slope * slope), hill = 0.04 * sin(x / 0.7) + 0.03 * cos(y / 0.5);
	struct soil soil = {0};
	if (fabs(across) < half) {
		double part = fmod(along, sample) - sample / 2, scallop = part * part / (2 * radius);
		/* The bottom is flat across the wheel where the ground is not. */
		double sinkage = 0.1 + 0.012 * sin(along / 0.9) + hill - scallop + 4 * quantum * rough(px, py, 1);
		soil.pressed = sinkage * 0.98;
		soil.offset = -0.97 * sinkage;
		/* Soil is sheared only while a wheel is on it: here one of 1 m at the way's end. */
		soil.shear = x > 9.5 && x < 10 ? 0.5 + 0.2 * sin(along / 1.7) + 2 * scallop : 0;
		soil.dirt = (unsigned)(96 + 900 * sinkage) & 255;
		if (half - fabs(across) < 0.04) /* slid back from the rim */
			soil.heaped = (0.04 - half + fabs(across)) * 0.5 + 40 * quantum * rough(px, py, 2);
	} else if (fabs(across) < half + 0.12) {
		double rim = fmin((fabs(across) - half) * 1.7, (half + 0.12 - fabs(across)) * 0.6);
		soil.heaped = rim + 0.002 * sin(along / 0.3) * rim / 0.05 + 20 * quantum * rough(px, py, 3);
	}
	soil.offset += soil.heaped;
	return soil;
}

static bool fill(struct tile tile, int32_t *planes[PLANES], int64_t *deformed)
{
	int64_t before = *deformed;
	for (int i = 0; i < TILE_POSTS; i++) {
		struct soil soil = soil_at(tile.x * CELLS + (unsigned)i % SIDE_POSTS, tile.y * CELLS + (unsigned)i / SIDE_POSTS);
		planes[PLANE_OFFSET][i] = (int32_t)lround(ldexp(soil.offset, 20));
		((uint8_t *)planes[PLANE_DISTURBANCE])[i] = (uint8_t)soil.dirt;
		planes[PLANE_DEPOSITED][i] = (int32_t)lround(ldexp(soil.heaped, 20));
		planes[PLANE_PLASTIC_SINKAGE][i] = (int32_t)lround(ldexp(soil.pressed, 20));
		planes[PLANE_DUG][i] = soil.shear > 0 ? (int32_t)lround(ldexp(0.01 * soil.shear, 20)) : 0;
		planes[PLANE_SHEAR][i] = (int32_t)lround(ldexp(soil.shear, 15)) | (int32_t)lround(ldexp(soil.shear / 9, 15)) << 16;
		*deformed += planes[PLANE_OFFSET][i] != 0 || planes[PLANE_PLASTIC_SINKAGE][i] != 0;
	}
	return *deformed > before;
}

static void a_rut_with_all_its_planes_takes_8_bytes_a_post(void **state)
{
	const char *path = in_folder("density.furrow");
	struct store *store = make(path);
	struct store_run run = {.scene_hash = "abc", .step = 1, .state = "{}"};
	struct store_commit_result result;
	struct store_numbers numbers;
	int32_t *planes[PLANES];
	int64_t deformed = 0, all = 0, bytes[PLANES] = {0};
	for (int plane = 0; plane < PLANES; plane++)
		planes[plane] = calloc(TILE_POSTS, sizeof *planes[plane]);
	for (uint32_t i = 0; i < TILES * TILES; i++) {
		struct store_page page = {.tile = {LEVEL, i % TILES, i / TILES}};
		if (!fill(page.tile, planes, &deformed))
			continue;
		for (int plane = 0; plane < PLANES; plane++)
			page.planes[plane] = planes[plane];
		assert_ok(store_commit(store, &page, 1, &run, &result));
	}
	assert_true(deformed > 100000);
	verified(store);
	assert_ok(store_count(store, &numbers));
	for (int plane = 0; plane < PLANES; plane++) {
		bytes[plane] = numbers.plane_bytes[plane];
		all += bytes[plane];
		print_message("%s: %.3f bytes a deformed post\n", plane_name((enum plane)plane),
			      (double)bytes[plane] / (double)deformed);
		free(planes[plane]);
	}
	print_message("all, coarser levels too: %.3f, of %lld posts\n", (double)all / (double)deformed, (long long)deformed);
	assert_true(all <= 8 * deformed);
	store_close(store);
}

/* A plane of one value is a number, however large the tile. */
static void a_plane_of_one_value_takes_4_bytes(void **state)
{
	const char *path = in_folder("constant.furrow");
	struct store *store = make(path);
	struct store_run run = {.scene_hash = "abc", .step = 1, .state = "{}"};
	struct store_commit_result result;
	struct store_numbers numbers;
	int32_t *posts = malloc(TILE_POSTS * sizeof *posts);
	memset(posts, 7, TILE_POSTS * sizeof *posts);
	struct store_page page = {{LEVEL, 3, 3}, {posts, posts, posts, posts, posts, posts, posts, posts, posts, posts, posts, posts, posts, posts}};
	assert_ok(store_commit(store, &page, 1, &run, &result));
	assert_ok(store_count(store, &numbers));
	for (int plane = PLANE_DEPOSITED; plane < PLANES; plane++) {
		if (PLANE_MARKS & PLANE_BIT(plane)) /* they have coarser levels, too */
			continue;
		assert_int_equal(numbers.plane_tiles[plane], 1);
		assert_int_equal(numbers.plane_bytes[plane], 4);
	}
	free(posts);
	store_close(store);
}

TEST_PROGRAM(density)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rut_with_all_its_planes_takes_8_bytes_a_post),
		cmocka_unit_test(a_plane_of_one_value_takes_4_bytes),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
