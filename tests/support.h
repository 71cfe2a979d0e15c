/* What tests of whole drives share: a folder, a store from a function of posts, a scene, a drive. */
#ifndef FURROW_TESTS_SUPPORT_H
#define FURROW_TESTS_SUPPORT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include "dem/dem.h"
#include "drive/drive.h"
#include "store/store.h"
#include "support/skip.h"

/* A folder of its own for the test program, removed by support_leave. */
static char support_folder[64];

static inline int support_enter(void **state)
{
	strcpy(support_folder, "/tmp/furrow-test-XXXXXX");
	return mkdtemp(support_folder) == NULL;
}

static inline int support_leave(void **state)
{
	char command[96];
	snprintf(command, sizeof command, "rm -rf '%s'", support_folder);
	return system(command);
}

static inline const char *support_path(const char *name)
{
	static char paths[64][128];
	static int next;
	char *path = paths[next++ % 64];
	snprintf(path, sizeof paths[0], "%s/%.60s", support_folder, name);
	return path;
}

#define must(call)                                                                                 \
	do {                                                                                       \
		if ((call) != STATUS_OK) {                                                         \
			print_error("%s: %s\n", #call, failure_message());                        \
			assert_true(!"" #call);                                                    \
		}                                                                                  \
	} while (0)

/* Heights: a function of the post. */
typedef double (*support_height)(int64_t x, int64_t y);

struct support_ground {
	const struct extent *extent;
	support_height height;
};

static inline enum status support_posts(void *user, struct post_rect rect, double *heights)
{
	const struct support_ground *ground = user;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			*heights++ = ground->height(x, y);
	return STATUS_OK;
}

static inline enum status support_put(void *user, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

/* Its south-west post at these coordinates of its SRS. */
static inline void support_store_at(const char *path, struct extent extent, support_height height, double x, double y)
{
	struct support_ground ground = {&extent, height};
	struct store_meta meta = {.extent = extent, .step = 1.0 / 1024, .max_error = 1.0 / 2048, .srs = "",
				  .vertical = "", .sources = "a function", .origin = {x, y}};
	struct store *store;
	must(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
	must(dem_cut(&(struct dem_cut){.extent = &extent, .step = meta.step, .posts = support_posts, .posts_user = &ground,
				       .emit = support_put, .emit_user = store}));
	must(store_publish(store));
	store_close(store);
}

static inline void support_store(const char *path, struct extent extent, support_height height)
{
	support_store_at(path, extent, height, 0, 0);
}

/* Gives a store imagery of this colour, of the spacing of its posts. Returns false if this build has none. */
static inline bool support_imagery(const char *path, uint8_t red, uint8_t green, uint8_t blue)
{
	struct store *store;
	int64_t tiles;
	if (!store_imagery_possible())
		return false;
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	must(store_imagery_begin(store, &(struct store_imagery_making){.finest = 0, .sources = "a colour\n", .request = "a colour"}, &tiles));
	const struct extent *extent = &store_meta(store)->extent;
	const uint32_t side = extent->cells + 1;
	uint8_t *pixels = mem_alloc((size_t)side * side, 4);
	assert_non_null(pixels);
	for (size_t i = 0; i < (size_t)side * side; i++)
		memcpy(pixels + 4 * i, (const uint8_t[]){red, green, blue, 255}, 4);
	void *packed;
	size_t size;
	must(store_imagery_pack(pixels, side, 0, &packed, &size));
	for (int level = 0; level <= extent_coarsest(extent); level++)
		for (struct tile tile = {level, 0, 0}; extent_has(extent, tile); tile.x = 0, tile.y++)
			for (; extent_has(extent, tile); tile.x++)
				must(store_imagery_put(store, tile, packed, size));
	mem_free(packed);
	mem_free(pixels);
	must(store_imagery_finish(store));
	store_close(store);
	return true;
}

static inline void support_write(const char *path, const char *text)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	assert_true(fputs(text, file) >= 0);
	assert_int_equal(fclose(file), 0);
}

/* The text of a file of at most 4 MB. Freed by the caller. */
static inline char *support_text(const char *path)
{
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	char *text = calloc(1, 1 << 22);
	assert_non_null(text);
	assert_true(fread(text, 1, (1 << 22) - 1, file) > 0);
	fclose(file);
	return text;
}

/* An integer of run.json by name, wherever it first stands after `after`. */
static inline long long support_figure(const char *json, const char *after, const char *name)
{
	const char *at = strstr(json, after);
	char quoted[64];
	snprintf(quoted, sizeof quoted, "\"%s\":", name);
	at = at != NULL ? strstr(at, quoted) : NULL;
	assert_non_null(at);
	return atoll(at + strlen(quoted));
}

/* How often blocks are visited depends on when their flags come from the GPU; on a software driver they come at once. The soil is the
 * same. */
static inline bool support_counts_repeat(const char *json)
{
	return strstr(json, "llvmpipe") != NULL;
}

/* Loads a scene; settings end with NULL: "key=value". */
static inline struct scene *support_scene(const char *path, const char *const *settings)
{
	struct scene_setting split[16] = {{NULL, NULL}};
	char texts[16][256];
	size_t count = 0;
	for (; settings != NULL && settings[count] != NULL; count++) {
		snprintf(texts[count], sizeof texts[count], "%s", settings[count]);
		char *equals = strchr(texts[count], '=');
		*equals = '\0';
		split[count] = (struct scene_setting){texts[count], equals + 1};
	}
	struct scene *scene;
	must(scene_load(path, split, count, &scene));
	return scene;
}

/* Drives; settings end with NULL: "key=value". Skips the test on a machine without GL. */
static inline char *support_drive(const char *scene_path, const char *store, const char *const *settings)
{
	struct scene *scene = support_scene(scene_path, settings);
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path("out")};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	must(status);
	assert_int_equal(support_figure(result.json, "\"counts\"", "unplanned"), 0);
	return result.json;
}

static inline void support_print_problem(void *user, const char *text)
{
	print_error("%s\n", text);
}

static inline uint64_t support_hash(const char *path)
{
	struct store *store;
	uint64_t hash;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_content_hash(store, &hash));
	store_close(store);
	return hash;
}

/* Verifies; returns the check. */
static inline struct store_check support_verify(const char *path)
{
	struct store *store;
	struct store_check check;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_verify(store, support_print_problem, NULL, NULL, &check));
	store_close(store);
	assert_int_equal(check.problems, 0);
	return check;
}

/* Offsets of `rect` at `level`, in quanta. Freed by the caller. */
static inline double *support_quanta(const char *path, int level, struct post_rect rect)
{
	struct store *store;
	struct store_reader *reader;
	double *values = malloc((size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0)) * sizeof *values);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_reader_create(store, &reader));
	must(store_read_posts(reader, STORE_UNITS, level, rect, values));
	store_reader_destroy(reader);
	store_close(store);
	return values;
}

/* Hills of a few metres with a hole in them; posts of `support_hills` are its arguments. */
static inline double support_hills(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	return 100 + 3 * sin((double)x * 0.31) * cos((double)y * 0.23) + (double)(h >> 22) / 1024;
}

#endif
