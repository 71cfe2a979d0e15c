/*
 * What tests of planes share: pages over a small store, without a drive, whose home is the GPU or host memory; and what the planes of the working
 * level should be.
 */
#ifndef FURROW_TESTS_RESIDENT_PLANES_RIG_H
#define FURROW_TESTS_RESIDENT_PLANES_RIG_H

#include "../gpu/staged.h"
#include "../support.h"
#include "../support/skip.h"

#include "resident/resident.h"
#include "world/record.h"

enum { CELLS = 32, LEVEL = -1, SIDE = 8, POSTS = (CELLS + 1) * (CELLS + 1), SLOTS = 12 };
#define ALL ((1u << PLANES) - 1)
static const struct extent extent = {129, 129, 1, CELLS};
static const struct scene scene = {.slots = SLOTS, .hash = "0"};

struct rig {
	struct store *store;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct gpu_buffer *tally; /* NULL: none */
	struct host_slots *host;  /* NULL: the home is the GPU */
	int64_t tallies[3];       /* with a home in host memory */
	struct pages *pages;
	struct resident_pages_budget most;
	struct page_cache *cache;
	struct record *record;
	FILE *commit_log;
	int64_t tallied;
};

static int32_t truth[SIDE][SIDE][PLANES][POSTS]; /* texels of any size */

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	return STATUS_OK;
}

static enum status snapshot(void *user, struct gpu_staging *staging)
{
	const struct rig *rig = user;
	gpu_buffer_read_into(rig->tally, 0, PAGES_TALLY_BYTES, staging, 0);
	return gpu_check(rig->gpu, "the tally");
}

static enum status tally(void *user, uint8_t *bytes)
{
	const struct rig *rig = user;
	memset(bytes, 0, PAGES_TALLY_BYTES);
	memcpy(bytes, rig->tallies, sizeof rig->tallies);
	return STATUS_OK;
}

static uint8_t class_of(struct tile tile, int post)
{
	return (uint8_t)((tile.x * 5 + tile.y * 3 + (unsigned)post) & 15);
}

static enum status classes_of(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	assert_int_equal(tile.level, LEVEL);
	for (int i = 0; i < POSTS; i++)
		classes[i] = class_of(tile, i);
	return STATUS_OK;
}

static uint8_t number_of(struct tile tile, int byte)
{
	return (uint8_t)(tile.x * 11 + tile.y * 13 + (unsigned)byte * 7);
}

static enum status numbers_of(void *user, unsigned loader, struct tile tile, uint8_t *numbers)
{
	assert_int_equal(tile.level, LEVEL);
	for (int i = 0; i < PAGES_NUMBER_BYTES * POSTS; i++)
		numbers[i] = number_of(tile, i);
	return STATUS_OK;
}

static void open_gpu(struct rig *rig, unsigned planes, bool soil)
{
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &rig->gpu);
	if (status == STATUS_NO_GL) {
		store_close(rig->store);
		skip_since("no GL");
	}
	must(status);
	must(gpu_slots_create(rig->gpu, CELLS, SLOTS, planes, &rig->slots));
	if (soil)
		must(gpu_buffer_create(rig->gpu, GPU_STORAGE, PAGES_TALLY_BYTES, NULL, &rig->tally));
}

static void rig_open(struct rig *rig, const char *path, unsigned planes, bool soil, bool host)
{
	*rig = (struct rig){.commit_log = tmpfile(), .record = calloc(1, world_record_bytes(0))};
	assert_true(rig->commit_log != NULL && rig->record != NULL);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &rig->store));
	must(store_set_working_level(rig->store, LEVEL));
	if (host)
		must(resident_host_create(CELLS, SLOTS, planes, &rig->host));
	else
		open_gpu(rig, planes, soil);
	const struct pages_params params = {
		.store = rig->store,
		.gpu = rig->gpu,
		.slots = rig->slots,
		.host = rig->host,
		.planes = planes | PLANE_BIT(PLANE_OFFSET),
		.level = LEVEL,
		.count = SLOTS,
		.loaders = 2,
		.step_pages = 16,
		.record = world_record_pages(&scene),
		.commit_log = rig->commit_log,
		.commit_age = 0.01,
		.before_read_back = before_read_back,
		.snapshot = soil ? snapshot : NULL,
		.tally = soil ? tally : NULL,
		.classes = soil ? classes_of : NULL,
		.numbers = soil && host ? numbers_of : NULL,
		.user = rig,
	};
	must(resident_pages_create(&params, &rig->pages));
	resident_pages_budget(&params, CELLS, &rig->most);
	rig->cache = resident_pages_cache(rig->pages);
}

static void rig_close(struct rig *rig)
{
	resident_pages_destroy(rig->pages);
	resident_host_destroy(rig->host);
	gpu_buffer_destroy(rig->tally);
	gpu_slots_destroy(rig->slots);
	gpu_destroy(rig->gpu);
	store_close(rig->store);
	fclose(rig->commit_log);
	free(rig->record);
}

/* Reads what the slot has. A plane that it lacks is zeros. *soil: it has classes, and in host memory numbers. */
static void read_slot(struct rig *rig, uint32_t slot, int32_t texels[PLANES][POSTS], uint8_t *classes, uint8_t *numbers, bool *soil)
{
	const struct gpu_rect whole = {0, 0, CELLS + 1, CELLS + 1};
	void *into[PLANES];
	if (rig->host != NULL) {
		struct host_slot held;
		resident_host_get(rig->host, slot, &held);
		for (int plane = 0; plane < PLANES; plane++) {
			const size_t bytes = POSTS * plane_bytes((enum plane)plane);
			if (held.planes[plane] != NULL)
				memcpy(texels[plane], held.planes[plane], bytes);
			else
				memset(texels[plane], 0, bytes);
		}
		*soil = held.classes != NULL;
		assert_true(*soil == (held.levels != NULL));
		if (*soil) {
			memcpy(classes, held.classes, POSTS);
			memcpy(numbers, held.levels, PAGES_NUMBER_BYTES * POSTS);
		}
		return;
	}
	const struct gpu_slot *held = gpu_slots_get(rig->slots, slot);
	for (int plane = 0; plane < PLANES; plane++)
		into[plane] = texels[plane];
	must(staged_read_planes(rig->gpu, rig->slots, CELLS, slot, into));
	*soil = held->classes != NULL;
	if (*soil)
		gpu_texture_read(held->classes, 0, whole, classes);
}

/* The page as it is now is what `truth` says, of these planes. */
static inline void check_page(struct rig *rig, uint32_t slot, uint32_t x, uint32_t y, unsigned planes, bool soil)
{
	static int32_t texels[PLANES][POSTS];
	static uint8_t classes[POSTS], numbers[PAGES_NUMBER_BYTES * POSTS];
	bool has_soil;
	read_slot(rig, slot, texels, classes, numbers, &has_soil);
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			assert_memory_equal(texels[plane], truth[y][x][plane], POSTS * plane_bytes((enum plane)plane));
	assert_true(has_soil == soil);
	if (!soil)
		return;
	for (int i = 0; rig->host != NULL && i < PAGES_NUMBER_BYTES * POSTS; i++)
		assert_int_equal(numbers[i], number_of((struct tile){LEVEL, x, y}, i));
	for (int i = 0; i < POSTS; i++)
		assert_int_equal(classes[i], class_of((struct tile){LEVEL, x, y}, i));
}

static uint64_t luck = 88172645463325252;

static uint32_t random_word(void)
{
	luck = luck * 6364136223846793005 + 1442695040888963407;
	return (uint32_t)(luck >> 33);
}

/* New bits inside the tile: its edges stay zero, as its neighbours have them. */
static inline void change_page(struct rig *rig, uint32_t slot, uint32_t x, uint32_t y)
{
	struct gpu_rect all = {0, 0, CELLS + 1, CELLS + 1};
	must(rig->host != NULL ? resident_host_write(rig->host, slot, ALL) : gpu_slots_deform(rig->slots, slot));
	for (int plane = 0; plane < PLANES; plane++)
		for (int i = 0; i < POSTS; i++) {
			int px = i % (CELLS + 1), py = i / (CELLS + 1);
			bool inside = px > 0 && py > 0 && px < CELLS && py < CELLS;
			uint32_t value = inside ? random_word() & (plane == PLANE_SHEAR ? 0x7fff7fff : 0x7fffffff) : 0;
			if (plane_bytes((enum plane)plane) == 1)
				((uint8_t *)truth[y][x][plane])[i] = (uint8_t)value;
			else
				truth[y][x][plane][i] = (int32_t)value;
		}
	for (int plane = 0; plane < PLANES; plane++)
		if (rig->host != NULL)
			memcpy(resident_host_plane(rig->host, slot, (enum plane)plane), truth[y][x][plane], POSTS * plane_bytes((enum plane)plane));
		else
			gpu_texture_upload(gpu_slots_get(rig->slots, slot)->planes[plane], 0, all, truth[y][x][plane]);
	page_cache_dirty(rig->cache, tile_key((struct tile){LEVEL, x, y}));
}

#endif
