/* A small terrain with holes, and stores of it, for the tests of this folder. */
#ifndef FURROW_TEST_STORE_FIXTURE_H
#define FURROW_TEST_STORE_FIXTURE_H

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "store/internal.h"

#define UNUSED __attribute__((unused))

#define assert_status(expression, wanted)                                                          \
	do {                                                                                       \
		enum status status_ = (expression);                                                \
		if (status_ != (wanted))                                                           \
			fail_msg("%s: status %d, not %d: %s", #expression, status_, wanted,        \
				 failure_message());                                               \
	} while (0)
#define assert_ok(expression) assert_status(expression, STATUS_OK)

static char folder[64];

static UNUSED int folder_make(void **state)
{
	snprintf(folder, sizeof folder, "/tmp/furrow-store-XXXXXX");
	return mkdtemp(folder) != NULL ? 0 : -1;
}

static UNUSED int folder_remove(void **state)
{
	DIR *dir = opendir(folder);
	for (struct dirent *entry; dir != NULL && (entry = readdir(dir)) != NULL;) {
		char path[512];
		snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
		unlink(path);
	}
	if (dir != NULL)
		closedir(dir);
	return rmdir(folder);
}

static UNUSED bool is_list(const char *name)
{
	size_t length = strlen(name);
	return length > strlen(PINS_SUFFIX) && strcmp(name + length - strlen(PINS_SUFFIX), PINS_SUFFIX) == 0;
}

/* Files in the folder whose name begins with `name`, without lists of pins. */
static UNUSED int files_of(const char *name)
{
	int count = 0;
	DIR *dir = opendir(folder);
	for (struct dirent *entry; dir != NULL && (entry = readdir(dir)) != NULL;)
		count += strncmp(entry->d_name, name, strlen(name)) == 0 && !is_list(entry->d_name);
	if (dir != NULL)
		closedir(dir);
	return count;
}

static UNUSED const char *in_folder(const char *name)
{
	static char paths[4][256];
	static unsigned next;
	char *path = paths[next++ % 4];
	snprintf(path, sizeof paths[0], "%s/%s", folder, name);
	return path;
}

static inline uint32_t mix(uint32_t x, uint32_t y, uint32_t seed)
{
	uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
	h = (h ^ h >> 15) * 0x2c1b3c6du;
	h = (h ^ h >> 12) * 0x297a2d39u;
	return h ^ h >> 15;
}

static const struct extent extent = {.width = 75, .height = 50, .spacing = 2, .cells = 16};
#define STEP 0.0078125
#define SIDE 17
#define POSTS (SIDE * SIDE)

/* The code of a level-0 post. */
static UNUSED int32_t terrain(int64_t x, int64_t y)
{
	if (x < 0 || y < 0 || x >= extent.width || y >= extent.height)
		return HEIGHT_CODE_NODATA;
	if ((x >= 20 && x < 26 && y >= 30 && y < 33) || (x == 60 && y == 16))
		return HEIGHT_CODE_NODATA;
	return 128000 + (int32_t)(4000 * sin((double)x / 9) + 3000 * cos((double)y / 7)) +
	       (int32_t)(mix((uint32_t)x, (uint32_t)y, 1) % 200);
}

static UNUSED void terrain_tile(struct tile tile, int32_t *codes, struct store_range *range)
{
	int32_t low = INT32_MAX, high = INT32_MIN;
	int64_t scale = (int64_t)1 << tile.level, n = extent.cells;
	for (int64_t y = 0; y <= n; y++)
		for (int64_t x = 0; x <= n; x++)
			codes[y * (n + 1) + x] = terrain((tile.x * n + x) * scale, (tile.y * n + y) * scale);
	for (int64_t y = tile.y * n * scale; y <= (tile.y + 1) * n * scale; y++)
		for (int64_t x = tile.x * n * scale; x <= (tile.x + 1) * n * scale; x++) {
			int32_t code = terrain(x, y);
			if (code == HEIGHT_CODE_NODATA)
				continue;
			low = code < low ? code : low;
			high = code > high ? code : high;
		}
	*range = (struct store_range){(double)NAN, (double)NAN, 0.25 * tile.level};
	if (low <= high) {
		range->low = low * STEP;
		range->high = high * STEP;
	}
}

static UNUSED struct store_meta terrain_meta(void)
{
	return (struct store_meta){
		.extent = extent,
		.step = STEP,
		.max_error = STEP / 2,
		.srs = "LOCAL_CS[\"here\"]",
		.origin = {1000, -2000},
		.vertical = "",
		.sources = "a.tif\nb.tif",
		.insets = "-1 2 3 9 8 b.tif\n",
	};
}

static UNUSED void terrain_put(struct store *store)
{
	int32_t codes[POSTS];
	struct store_range range;
	for (int level = 0; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				struct tile tile = {level, x, y};
				terrain_tile(tile, codes, &range);
				assert_ok(store_put_base(store, tile, codes, &range));
			}
}

static UNUSED void make_store(const char *path)
{
	struct store *store;
	struct store_meta meta = terrain_meta();
	assert_ok(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
	terrain_put(store);
	assert_ok(store_publish(store));
	store_close(store);
}

static UNUSED struct store *open_store(const char *path, enum store_mode mode)
{
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = mode}, &store));
	return store;
}

/* --- a deformation: a field of offsets over the working level's posts --- */

struct field {
	int level;
	int64_t width, height; /* posts of whole tiles */
	unsigned carried;      /* planes that are committed: at first all */
	void *planes[PLANES];
	int32_t *offset;       /* of planes, and */
	uint8_t *dirt;
};

static UNUSED void field_clear(struct field *field)
{
	for (int plane = 0; plane < PLANES; plane++)
		memset(field->planes[plane], 0, (size_t)(field->width * field->height) * plane_bytes((enum plane)plane));
}

static UNUSED struct field field_make(int level)
{
	struct field field = {
		.level = level,
		.width = (int64_t)extent_tiles_x(&extent, level) * extent.cells + 1,
		.height = (int64_t)extent_tiles_y(&extent, level) * extent.cells + 1,
	};
	field.carried = (1u << PLANES) - 1;
	for (int plane = 0; plane < PLANES; plane++) {
		field.planes[plane] = calloc((size_t)(field.width * field.height), plane_bytes((enum plane)plane));
		assert_non_null(field.planes[plane]);
	}
	field.offset = field.planes[PLANE_OFFSET];
	field.dirt = field.planes[PLANE_DISTURBANCE];
	return field;
}

static UNUSED void field_free(struct field *field)
{
	for (int plane = 0; plane < PLANES; plane++)
		free(field->planes[plane]);
}

static UNUSED bool field_marks; /* field_dig makes marks that fade, too */

/* A rut of random posts around (cx, cy). */
static UNUSED void field_dig(struct field *field, int64_t cx, int64_t cy, int64_t radius, uint32_t seed)
{
	int64_t width = extent_posts(extent.width, field->level), height = extent_posts(extent.height, field->level);
	for (int64_t y = cy - radius; y <= cy + radius; y++)
		for (int64_t x = cx - radius; x <= cx + radius; x++) {
			if (x < 0 || y < 0 || x >= width || y >= height)
				continue;
			uint32_t h = mix((uint32_t)x, (uint32_t)y, seed);
			int64_t i = y * field->width + x;
			field->offset[i] = (int32_t)(h % 400000) - 300000;
			field->dirt[i] = (uint8_t)(h >> 24);
			((int32_t *)field->planes[PLANE_DEPOSITED])[i] = (int32_t)(h >> 3 & 0xffff) - 0x4000;
			((int32_t *)field->planes[PLANE_PLASTIC_SINKAGE])[i] = (int32_t)(h >> 7 & 0x7ffff);
			((int32_t *)field->planes[PLANE_SHEAR])[i] = (int32_t)(h >> 4 & 0x7fff7fff) - 0x3fff;
			((int32_t *)field->planes[PLANE_DUG])[i] = (int32_t)(h >> 9 & 0xffff);
			((int32_t *)field->planes[PLANE_SETTLED])[i] = (int32_t)(h >> 5 & 0xffff) - 0x2000;
			((int32_t *)field->planes[PLANE_LOOSE])[i] = (int32_t)(h >> 6 & 0xffff);
			((int32_t *)field->planes[PLANE_FLOOR])[i] = (int32_t)(h >> 8 & 0x3ffff);
			((int32_t *)field->planes[PLANE_DENSITY])[i] = (int32_t)(h >> 10 & 0xfffff);
			((int32_t *)field->planes[PLANE_SLOPE])[i] = (int32_t)(h * 2654435761u);
			if (!field_marks)
				continue;
			((int32_t *)field->planes[PLANE_HEALED])[i] = (int32_t)(h >> 2 & 0x3ffff);
			((int32_t *)field->planes[PLANE_RISEN])[i] = (int32_t)(h >> 11 & 0xffff);
			((int32_t *)field->planes[PLANE_GROWN])[i] = (int32_t)(h >> 1);
		}
}

static UNUSED void field_tile_plane(const struct field *field, struct tile tile, enum plane plane, void *texels)
{
	size_t size = plane_bytes(plane);
	for (int64_t y = 0; y < SIDE; y++) {
		int64_t i = (tile.y * 16 + y) * field->width + tile.x * 16;
		memcpy((char *)texels + (size_t)y * SIDE * size, (char *)field->planes[plane] + (size_t)i * size, SIDE * size);
	}
}

/* The tile's posts out of the field. */
static UNUSED void field_tile(const struct field *field, struct tile tile, int32_t *offset, uint8_t *dirt)
{
	field_tile_plane(field, tile, PLANE_OFFSET, offset);
	field_tile_plane(field, tile, PLANE_DISTURBANCE, dirt);
}

/* Commits the tiles that `rect` (posts of the field's level) touches. */
static UNUSED enum status field_commit(const struct field *field, struct post_rect rect, struct store *store,
				       int64_t step, struct store_commit_result *result)
{
	struct tile first, last;
	assert_true(tile_range_of(&extent, field->level, rect, &first, &last));
	size_t count = (size_t)(last.x - first.x + 1) * (last.y - first.y + 1), i = 0;
	struct store_page *pages = calloc(count, sizeof *pages);
	int32_t(*texels)[PLANES][POSTS] = calloc(count, sizeof *texels);
	assert_true(pages != NULL && texels != NULL);
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++, i++) {
			struct tile tile = {field->level, x, y};
			pages[i].tile = tile;
			for (int plane = 0; plane < PLANES; plane++) {
				if (!(field->carried & PLANE_BIT(plane)))
					continue;
				field_tile_plane(field, tile, (enum plane)plane, texels[i][plane]);
				pages[i].planes[plane] = texels[i][plane];
			}
		}
	struct store_run run = {.scene_hash = "abc", .step = step, .time = (double)step / 10, .state = "{\"poses\":[]}"};
	enum status status = store_commit(store, pages, count, &run, result);
	free(pages);
	free(texels);
	return status;
}

static UNUSED struct post_rect field_all(const struct field *field)
{
	return (struct post_rect){0, 0, field->width, field->height};
}

static UNUSED struct post_rect around(int64_t cx, int64_t cy, int64_t radius)
{
	return (struct post_rect){cx - radius, cy - radius, cx + radius + 1, cy + radius + 1};
}

static UNUSED void print_problem(void *user, const char *text)
{
	if (user == NULL)
		printf("problem: %s\n", text);
}

static UNUSED struct store_check verified(struct store *store)
{
	struct store_check check;
	assert_ok(store_verify(store, print_problem, NULL, NULL, &check));
	assert_int_equal(check.problems, 0);
	return check;
}

static UNUSED uint64_t content(struct store *store)
{
	uint64_t hash;
	assert_ok(store_content_hash(store, &hash));
	return hash;
}

/* SQL on a closed store's file, as somebody else might run it. */
static UNUSED void raw_sql(const char *path, const char *sql)
{
	sqlite3 *db;
	assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
	char *message = NULL;
	if (sqlite3_exec(db, sql, NULL, NULL, &message) != SQLITE_OK)
		fail_msg("%s: %s", sql, message);
	sqlite3_close(db);
}

static UNUSED void copy_file(const char *from, const char *to)
{
	FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
	assert_true(in != NULL && out != NULL);
	char buffer[65536];
	for (size_t size; (size = fread(buffer, 1, sizeof buffer, in)) > 0;)
		assert_int_equal(fwrite(buffer, 1, size, out), size);
	fclose(in);
	assert_int_equal(fclose(out), 0);
}

#endif
