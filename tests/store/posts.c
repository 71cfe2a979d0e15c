/* Posts and points out of a store, against the same computed post by post from the terrain. */
#include "fixture.h"
#include "../support/program.h"

static int32_t reference;

/* Level-0 base on the lattice. */
static int32_t base_post(int64_t x, int64_t y)
{
	return lattice_base_relative(height_code_metres(terrain(x, y), STEP), reference);
}

static int32_t field_post(const struct field *field, enum plane plane, int64_t x, int64_t y)
{
	if (x >= field->width || y >= field->height)
		return 0;
	int64_t i = y * field->width + x;
	return plane == PLANE_DISTURBANCE    ? field->dirt[i]
				      : ((int32_t *)field->planes[plane])[i];
}

/* What a layer shows of a post. Shear is two halves of 16 bits; what is between posts is between what is shown of them. */
static int32_t shown_post(const struct field *field, enum store_layer layer, enum plane plane, int64_t x, int64_t y)
{
	int32_t post = field_post(field, plane, x, y);
	if (plane != PLANE_SHEAR)
		return post;
	int16_t east = (int16_t)(post & 0xffff), north = (int16_t)(post >> 16);
	return layer == STORE_SHEAR_EAST ? east : layer == STORE_SHEAR_NORTH ? north : (int32_t)lround(sqrt((double)east * east + (double)north * north));
}

/* A post of `level` from what deformation left, by the definition. */
static int32_t deformed_post(const struct field *field, enum store_layer layer, enum plane plane, int level, int64_t x, int64_t y)
{
	if (level >= field->level) {
		int up = level - field->level;
		return shown_post(field, layer, plane, x << up, y << up);
	}
	int shift = field->level - level;
	int64_t cx = x >> shift, cy = y >> shift, mask = ((int64_t)1 << shift) - 1;
	return lattice_interpolate(shown_post(field, layer, plane, cx, cy), shown_post(field, layer, plane, cx + 1, cy),
				   shown_post(field, layer, plane, cx, cy + 1), shown_post(field, layer, plane, cx + 1, cy + 1),
				   (uint32_t)(x & mask), (uint32_t)(y & mask), shift);
}

static double base_metres(int level, int64_t x, int64_t y)
{
	if (x < 0 || y < 0 || x >= extent_posts(extent.width, level) || y >= extent_posts(extent.height, level))
		return (double)NAN;
	if (level >= 0)
		return height_code_metres(terrain(x << level, y << level), STEP);
	int64_t cx = x >> -level, cy = y >> -level, mask = ((int64_t)1 << -level) - 1;
	int32_t post = lattice_interpolate(base_post(cx, cy), base_post(cx + 1, cy), base_post(cx, cy + 1),
					   base_post(cx + 1, cy + 1), (uint32_t)(x & mask), (uint32_t)(y & mask),
					   -level);
	return post == BASE_NODATA ? (double)NAN : reference + lattice_base_metres(post);
}

static double post_of(const struct field *field, enum store_layer layer, int level, int64_t x, int64_t y)
{
	double base = base_metres(level, x, y);
	if (isnan(base) || layer == STORE_BASE)
		return base;
	static const enum plane planes[STORE_LAYERS] = {[STORE_SOIL] = PLANE_DISTURBANCE, [STORE_DEPOSITED] = PLANE_DEPOSITED,
							[STORE_PLASTIC_SINKAGE] = PLANE_PLASTIC_SINKAGE, [STORE_SHEAR] = PLANE_SHEAR, [STORE_SHEAR_EAST] = PLANE_SHEAR,
							[STORE_SHEAR_NORTH] = PLANE_SHEAR, [STORE_SETTLED] = PLANE_SETTLED, [STORE_LOOSE] = PLANE_LOOSE, [STORE_DENSITY] = PLANE_DENSITY,
							[STORE_HEALED] = PLANE_HEALED, [STORE_RISEN] = PLANE_RISEN, [STORE_GROWN] = PLANE_GROWN};
	int32_t value = deformed_post(field, layer, planes[layer], level, x, y);
	return layer == STORE_SURFACE				      ? base + lattice_offset_metres(value)
	       : layer == STORE_UNITS || planes[layer] == PLANE_DISTURBANCE ? value
	       : planes[layer] == PLANE_SHEAR			      ? value / 32768.0
	       : PLANE_MARKS & PLANE_BIT(planes[layer])		      ? value / 4.0
								      : lattice_offset_metres(value);
}

static void assert_rect(struct store_reader *reader, const struct field *field, enum store_layer layer,
			int level, struct post_rect rect)
{
	int64_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
	double *values = malloc((size_t)(width * height) * sizeof *values);
	assert_ok(store_read_posts(reader, layer, level, rect, values));
	for (int64_t y = 0; y < height; y++)
		for (int64_t x = 0; x < width; x++) {
			double want = post_of(field, layer, level, rect.x0 + x, rect.y0 + y);
			double got = values[y * width + x];
			if (!(want == got || (isnan(want) && isnan(got))))
				fail_msg("layer %d level %d working %d post %lld %lld: %.9g, not %.9g", layer, level,
					 field->level, (long long)(rect.x0 + x), (long long)(rect.y0 + y), got, want);
		}
	free(values);
}

static void posts_are_those_of_the_definition(void **state)
{
	const char *path = in_folder("posts.furrow");
	for (int working = -2; working <= 1; working++) {
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		reference = lattice_reference(store_meta(store)->low, store_meta(store)->high);
		assert_ok(store_set_working_level(store, working));
		struct field field = field_make(working);
		struct store_commit_result result;
		int64_t width = extent_posts(extent.width, working), height = extent_posts(extent.height, working);
		field_dig(&field, width / 3, height / 2, width / 6, 5);
		field_dig(&field, width - 3, height - 3, 4, 6);
		assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
		struct store_reader *reader;
		assert_ok(store_reader_create(store, &reader));
		for (int level = -3; level <= extent_coarsest(&extent); level++)
			for (int layer = STORE_SURFACE; layer < STORE_LAYERS; layer++) {
				double value;
				if (layer >= STORE_DEPOSITED && level > working) { /* it is of the working level alone */
					assert_status(store_read_posts(reader, (enum store_layer)layer, level,
								       (struct post_rect){0, 0, 1, 1}, &value), STATUS_INPUT);
					assert_non_null(strstr(failure_message(), "has no state of the soil"));
					continue;
				}
				int64_t w = extent_posts(extent.width, level), h = extent_posts(extent.height, level);
				struct post_rect rects[] = {
					{-3, -2, w + 5, h + 4},       {w / 3, h / 4, w / 3 + 7, h / 4 + 3},
					{w - 1, h - 1, w, h},         {w, h, w + 3, h + 3},
					{15, 16, 18, 17},             {-9, 3, -1, 4},
				};
				for (size_t i = 0; i < sizeof rects / sizeof *rects; i++)
					assert_rect(reader, &field, (enum store_layer)layer, level, rects[i]);
			}
		double value;
		struct post_rect one = {0, 0, 1, 1};
		assert_status(store_read_posts(reader, STORE_BASE, extent_coarsest(&extent) + 1, one, &value), STATUS_INPUT);
		assert_status(store_read_posts(reader, STORE_BASE, TILE_LEVEL_MIN - 1, one, &value), STATUS_INPUT);
		store_reader_destroy(reader);
		store_close(store);
		field_free(&field);
	}
}

/* The terrain's last posts are also a tile's last: no tile begins there. */
static void a_terrain_that_ends_with_its_tiles_ends_with_posts(void **state)
{
	const char *path = in_folder("whole.furrow");
	struct store_meta meta = terrain_meta();
	struct store *store;
	int32_t codes[POSTS];
	double values[9];
	meta.extent = (struct extent){17, 17, 1, 16};
	for (int i = 0; i < POSTS; i++)
		codes[i] = i;
	struct store_range range = {0, (POSTS - 1) * STEP, 0};
	assert_ok(store_create(path, &meta, false, &store));
	assert_ok(store_put_base(store, (struct tile){0, 0, 0}, codes, &range));
	assert_ok(store_publish(store));
	store_close(store);
	store = open_store(path, STORE_READ);
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	assert_ok(store_read_posts(reader, STORE_SURFACE, 0, (struct post_rect){16, 16, 17, 17}, values));
	assert_true(values[0] == (POSTS - 1) * STEP);
	assert_ok(store_read_posts(reader, STORE_SURFACE, -1, (struct post_rect){32, 32, 33, 33}, values));
	assert_true(values[0] == (POSTS - 1) * STEP);
	struct store_sample sample;
	assert_ok(store_sample(reader, 16, 16, &sample));
	assert_true(!sample.nodata && sample.height == (POSTS - 1) * STEP && sample.offset == 0);
	store_reader_destroy(reader);
	store_close(store);
}

static double between(const struct field *field, enum store_layer layer, int level, double x, double y)
{
	double px = x / extent_spacing(&extent, level), py = y / extent_spacing(&extent, level);
	int64_t cx = (int64_t)px, cy = (int64_t)py;
	double u = px - (double)cx, v = py - (double)cy, sum = 0;
	for (int i = 0; i < 4; i++) {
		double weight = (i & 1 ? u : 1 - u) * (i & 2 ? v : 1 - v);
		if (weight != 0)
			sum += weight * post_of(field, layer, level, cx + (i & 1), cy + (i >> 1));
	}
	return sum;
}

static void a_point_lies_between_the_finest_posts_stored_there(void **state)
{
	const char *path = in_folder("point.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	reference = lattice_reference(store_meta(store)->low, store_meta(store)->high);
	assert_ok(store_set_working_level(store, -2));
	struct field field = field_make(-2);
	struct store_commit_result result;
	field_dig(&field, 100, 80, 20, 5);
	assert_ok(field_commit(&field, around(100, 80, 20), store, 1, &result));
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	struct store_sample sample;
	int fine = 0, coarse = 0, holes = 0;
	for (uint32_t i = 0; i < 400; i++) {
		double x = mix(i, 1, 7) % 14800 / 100.0, y = mix(i, 2, 7) % 9800 / 100.0;
		assert_ok(store_sample(reader, x, y, &sample));
		struct tile tile = {-2, (uint32_t)(x / 0.5) / 16, (uint32_t)(y / 0.5) / 16};
		int32_t offset[POSTS];
		unsigned present;
		assert_ok(store_read_deformed(reader, tile, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present));
		int level = present ? -2 : 0;
		double want = between(&field, STORE_BASE, level, x, y);
		assert_false(sample.outside);
		assert_int_equal(sample.nodata, isnan(want));
		if (sample.nodata) {
			assert_true(isnan(sample.height) && isnan(sample.base) && isnan(sample.offset));
			holes++;
			continue;
		}
		*(present ? &fine : &coarse) += 1;
		assert_true(fabs(sample.base - want) < 1e-9);
		assert_true(fabs(sample.offset - between(&field, STORE_OFFSET, level, x, y)) < 1e-9);
		assert_true(sample.height == sample.base + sample.offset);
	}
	assert_true(fine > 10 && coarse > 10 && holes > 0);
	/* On a post beside a hole, and at the corners. */
	assert_ok(store_sample(reader, 38, 60, &sample));
	assert_true(!sample.nodata && sample.base == terrain(19, 30) * STEP);
	assert_ok(store_sample(reader, 148, 98, &sample));
	assert_true(!sample.nodata && sample.base == terrain(74, 49) * STEP);
	assert_ok(store_sample(reader, 50, 40, &sample));
	assert_int_equal(sample.disturbance, field.dirt[80 * field.width + 100]);
	assert_int_equal(sample.planes, (1u << PLANES) - 1);
	assert_true(sample.deposited == lattice_offset_metres(field_post(&field, PLANE_DEPOSITED, 100, 80)) && sample.deposited != 0);
	assert_true(sample.plastic_sinkage == lattice_offset_metres(field_post(&field, PLANE_PLASTIC_SINKAGE, 100, 80)) && sample.plastic_sinkage > 0);
	const double settled = lattice_offset_metres(field_post(&field, PLANE_SETTLED, 100, 80)), loose = lattice_offset_metres(field_post(&field, PLANE_LOOSE, 100, 80));
	assert_true(sample.loose == (loose > 0 || sample.deposited > settled ? fmax(loose + sample.deposited - settled, 0) : 0));
	assert_true(sample.density == lattice_offset_metres(field_post(&field, PLANE_DENSITY, 100, 80)));
	assert_true(sample.shear[0] == shown_post(&field, STORE_SHEAR_EAST, PLANE_SHEAR, 100, 80) / 32768.0 && sample.shear[0] != 0);
	assert_true(sample.shear[1] == shown_post(&field, STORE_SHEAR_NORTH, PLANE_SHEAR, 100, 80) / 32768.0 && sample.shear[1] != 0);
	assert_ok(store_sample(reader, 5, 5, &sample));
	assert_true(sample.planes == 0 && sample.deposited == 0 && sample.plastic_sinkage == 0 && sample.shear[0] == 0 && sample.shear[1] == 0);
	static const double outside[][2] = {{-0.001, 5}, {148.001, 5}, {5, -1}, {5, 98.001}, {NAN, 5}};
	for (size_t i = 0; i < 5; i++) {
		assert_ok(store_sample(reader, outside[i][0], outside[i][1], &sample));
		assert_true(sample.outside && isnan(sample.height));
	}
	store_reader_destroy(reader);
	store_close(store);
	field_free(&field);
}

struct keys {
	uint64_t last;
	int count;
};

static enum status take_key(void *user, uint64_t key)
{
	struct keys *keys = user;
	assert_true(keys->count == 0 || key > keys->last);
	keys->last = key;
	return ++keys->count == 3 ? STATUS_INTERRUPTED : STATUS_OK;
}

static void keys_of_a_level_come_in_order_until_told_to_stop(void **state)
{
	const char *path = in_folder("keys.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 20, 20, 18, 5);
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	struct keys keys = {0};
	assert_status(store_each_offset(reader, -1, take_key, &keys), STATUS_INTERRUPTED);
	keys = (struct keys){0};
	assert_ok(store_each_offset(reader, extent_coarsest(&extent), take_key, &keys));
	assert_int_equal(keys.count, 1);
	keys = (struct keys){0};
	assert_ok(store_each_offset(reader, -2, take_key, &keys));
	assert_int_equal(keys.count, 0);
	store_reader_destroy(reader);
	store_close(store);
	field_free(&field);
}

TEST_PROGRAM(posts)
{
	field_marks = true;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(posts_are_those_of_the_definition),
		cmocka_unit_test(a_terrain_that_ends_with_its_tiles_ends_with_posts),
		cmocka_unit_test(a_point_lies_between_the_finest_posts_stored_there),
		cmocka_unit_test(keys_of_a_level_come_in_order_until_told_to_stop),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
