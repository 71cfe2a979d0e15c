/*
 * Pictures of pages whose home is host memory: the same pixels as with pages in slots of the GPU, while ground changes, tiles come and go, and the
 * GPU comes late. What is not drawn, and what did not change, is not uploaded.
 */
#include "../support.h"
#include "../support/program.h"
#include "gpu_rig.h"

#include "render/internal.h"
#include "world/record.h"

enum { CELLS = 32, POSTS = (CELLS + 1) * (CELLS + 1), LEVEL = -1, WIDTH = 160, HEIGHT = 96, RUT = 6 };
#define DRAWN (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE))
#define EFFECTS (EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) | EFFECT_BIT(EFFECT_SKIRTS))
static const struct extent extent = {129, 129, 1, CELLS};
static const struct scene scene = {.hash = "0"};

struct rig {
	struct store *store;
	struct gpu_slots *slots;
	struct host_slots *host; /* NULL: the home is the GPU */
	struct pages *pages;
	struct page_cache *cache;
	struct pyramid *pyramid;
	struct record *record;
	struct render *render;
	struct render_selection selection;
	uint32_t count; /* of slots */
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct rig *rig = user;
	return resident_pyramid_flush_tile(rig->pyramid, rig->cache, tile, slot);
}

static enum status classes_of(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	for (int i = 0; i < POSTS; i++)
		classes[i] = (uint8_t)((tile.x + tile.y + (uint32_t)i / 300) & 1);
	return STATUS_OK;
}

static enum status show(void *user, uint32_t slot, bool planes)
{
	const struct rig *rig = user;
	return resident_pages_show(rig->pages, slot, planes);
}

static void open_pictures(struct rig *rig, bool classes, uint32_t count)
{
	assert_ok(gpu_slots_create(gpu, CELLS, count, DRAWN, &rig->slots));
	if (rig->host != NULL)
		resident_pages_mirror(rig->pages, gpu, rig->slots);
	assert_ok(render_create(&(struct render_params){
		.gpu = gpu, .slots = rig->slots, .extent = &extent, .reference = resident_ground_reference(rig->store), .low = 80, .high = 120,
		.width = WIDTH, .height = HEIGHT, .effects = EFFECTS, .disturbance = true, .measures = classes, .classes = classes,
		.show = show, .user = rig,
	}, &rig->render));
}

static void rig_open(struct rig *rig, const char *path, uint32_t count, bool host, bool classes)
{
	memset(rig, 0, sizeof *rig);
	rig->count = count;
	support_store(path, extent, support_hills);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &rig->store));
	must(store_set_working_level(rig->store, LEVEL));
	rig->record = calloc(1, world_record_bytes(0));
	if (host)
		must(resident_host_create(CELLS, count, DRAWN, &rig->host));
	else
		open_pictures(rig, classes, count);
	must(resident_pyramid_create(&extent, LEVEL, rig->slots, rig->host, &rig->pyramid));
	must(resident_pages_create(&(struct pages_params){
		.store = rig->store, .gpu = rig->host != NULL ? NULL : gpu, .slots = rig->slots, .host = rig->host, .planes = DRAWN, .level = LEVEL,
		.count = count, .loaders = 2, .step_pages = 64, .record = world_record_pages(&scene), .commit_age = 0.01,
		.before_read_back = before_read_back, .classes = classes ? classes_of : NULL, .classes_drawn = classes, .user = rig,
	}, &rig->pages));
	rig->cache = resident_pages_cache(rig->pages);
}

static void rig_close(struct rig *rig)
{
	render_destroy(rig->render);
	resident_pages_destroy(rig->pages);
	resident_pyramid_destroy(rig->pyramid);
	resident_host_destroy(rig->host);
	gpu_slots_destroy(rig->slots);
	store_close(rig->store);
	free(rig->record);
}

/* --- ground that changes --- */

/* Of a post of the working level after so many steps: each step has a rut of its own. */
static int32_t offset_at(int64_t x, int64_t y, int steps)
{
	int32_t offset = 0;
	for (int step = 1; step <= steps; step++) {
		const int64_t cx = 20 + step * 23 % 210, cy = 30 + step * 41 % 200;
		if (x >= cx && x < cx + 2 * RUT && y >= cy && y < cy + RUT)
			offset -= (int32_t)lattice_offset(0.2 + 0.01 * (double)(x - cx));
	}
	return offset;
}

static void change_tile(struct rig *rig, struct tile tile, struct post_rect rect, int step)
{
	static int32_t offset[POSTS];
	static uint8_t disturbance[POSTS];
	uint32_t slot;
	must(page_cache_pin(rig->cache, tile_key(tile), &slot));
	for (int i = 0; i < POSTS; i++) {
		offset[i] = offset_at(tile.x * CELLS + i % (CELLS + 1), tile.y * CELLS + i / (CELLS + 1), step);
		disturbance[i] = offset[i] != 0 ? 200 : 0;
	}
	if (rig->host != NULL) {
		must(resident_host_write(rig->host, slot, DRAWN));
		memcpy(resident_host_plane(rig->host, slot, PLANE_OFFSET), offset, sizeof offset);
		memcpy(resident_host_plane(rig->host, slot, PLANE_DISTURBANCE), disturbance, sizeof disturbance);
	} else {
		const struct gpu_rect all = {0, 0, CELLS + 1, CELLS + 1};
		must(gpu_slots_deform(rig->slots, slot));
		gpu_texture_upload(gpu_slots_get(rig->slots, slot)->planes[PLANE_OFFSET], 0, all, offset);
		gpu_texture_upload(gpu_slots_get(rig->slots, slot)->planes[PLANE_DISTURBANCE], 0, all, disturbance);
	}
	page_cache_dirty(rig->cache, tile_key(tile));
	page_cache_unpin(rig->cache, tile_key(tile));
	must(resident_pyramid_changed(rig->pyramid, tile, rect));
}

static void one_step(struct rig *rig, int step)
{
	const int64_t x = 20 + step * 23 % 210, y = 30 + step * 41 % 200;
	const struct post_rect rect = {x, y, x + 2 * RUT, y + RUT};
	struct tile first, last;
	assert_true(tile_range_of(&extent, LEVEL, rect, &first, &last));
	for (uint32_t ty = first.y; ty <= last.y; ty++)
		for (uint32_t tx = first.x; tx <= last.x; tx++)
			change_tile(rig, (struct tile){LEVEL, tx, ty}, rect, step);
	must(resident_pyramid_flush(rig->pyramid, rig->cache));
	rig->record->step = step;
	must(page_cache_end_step(rig->cache, rig->record));
}

/* --- pictures --- */

static bool bounds(void *user, struct tile tile, double *low, double *high)
{
	*low = 80;
	*high = 130;
	return tile.level >= LEVEL && extent_has(&extent, tile);
}

static bool resident(void *user, struct tile tile, uint32_t *slot)
{
	const struct rig *rig = user;
	return page_cache_peek(rig->cache, tile_key(tile), true, slot);
}

static bool divisible(void *user, struct tile tile)
{
	return tile.level > LEVEL;
}

static double error_of(void *user, struct tile tile)
{
	return 0;
}

/* Loads what the picture needs, and draws it. *uploaded: bytes that went to the GPU while it was drawn. */
static void draw(struct rig *rig, double x, double y, double up, uint8_t *pixels, uint64_t *uploaded)
{
	struct gpu_stats before, after;
	const struct render_source source = {rig, bounds, resident, divisible, error_of, NULL};
	const struct render_camera camera = {{x, y, 100 + up}, {64, 64, 90}, 0.9, {0}};
	struct render_view view;
	render_view(rig->render, &camera, &view);
	view.by_error = false;
	view.radius = rig->count < 96 ? 0.7 : 1.5;
	for (;;) {
		render_select(&extent, &view, &source, &rig->selection);
		if (rig->selection.wanted_count == 0)
			break;
		assert_true(rig->selection.needed < rig->count);
		for (size_t i = 0; i < rig->selection.wanted_count; i++) {
			uint32_t slot;
			must(page_cache_pin(rig->cache, rig->selection.wanted[i], &slot));
			page_cache_unpin(rig->cache, rig->selection.wanted[i]);
		}
	}
	gpu_stats(gpu, &before);
	assert_ok(render_frame(rig->render, &camera, &rig->selection));
	gpu_stats(gpu, &after);
	*uploaded = after.upload_bytes - before.upload_bytes;
	gpu_texture_read(rig->render->screen->colour, 0, (struct gpu_rect){0, 0, WIDTH, HEIGHT}, pixels);
}

static uint8_t one[4 * WIDTH * HEIGHT], other[4 * WIDTH * HEIGHT];

/* Each drawn tile has its classes on the GPU. */
static void check_classes(const struct rig *rig)
{
	uint8_t wanted[POSTS], got[POSTS];
	for (size_t i = 0; i < rig->selection.draw_count; i++) {
		const struct render_draw *draw = &rig->selection.draws[i];
		must(classes_of(NULL, 0, draw->tile, wanted));
		gpu_texture_read(gpu_slots_get(rig->slots, draw->slot)->classes, 0, (struct gpu_rect){0, 0, CELLS + 1, CELLS + 1}, got);
		assert_memory_equal(got, wanted, POSTS);
	}
}

static void compare(uint32_t count, bool classes, int late)
{
	struct rig home, host;
	uint64_t lists, uploaded;
	size_t levels = 0;
	rig_open(&home, support_path("home.furrow"), count, false, classes);
	rig_open(&host, support_path("host.furrow"), count, true, classes);
	for (int step = 1; step <= 24; step++) {
		one_step(&home, step);
		one_step(&host, step);
		if (step == late)
			open_pictures(&host, classes, count);
		if (step < late || step % 3 != 0)
			continue;
		const double x = 64 + 50 * sin(step), y = 64 + 50 * cos(step);
		draw(&home, x, y, 12 + step, one, &lists); /* what is drawn of tiles, and no posts */
		draw(&host, x, y, 12 + step, other, &uploaded);
		assert_memory_equal(one, other, sizeof one);
		if (classes)
			check_classes(&host);
		struct render_tiles tiles[2];
		render_tiles(home.render, &tiles[0]);
		render_tiles(host.render, &tiles[1]);
		assert_true(tiles[0].drawn == tiles[1].drawn && tiles[0].deformed == tiles[1].deformed);
		for (size_t i = 0; i < host.selection.draw_count; i++)
			levels |= (size_t)1 << (host.selection.draws[i].tile.level - LEVEL);
		/* The same picture again uploads nothing. */
		draw(&host, x, y, 12 + step, one, &uploaded);
		assert_memory_equal(one, other, sizeof one);
		assert_int_equal(uploaded, lists);
	}
	assert_true((levels & 1) != 0 && (levels & (levels - 1)) != 0); /* tiles of the working level, and coarser ones */
	struct page_stats stats;
	page_cache_stats(host.cache, &stats);
	assert_true((stats.evictions > 20) == (count < 96));
	must(page_cache_flush(home.cache, home.record));
	must(page_cache_flush(host.cache, host.record));
	rig_close(&home);
	rig_close(&host);
	assert_true(support_hash(support_path("home.furrow")) == support_hash(support_path("host.furrow")));
}

static void pictures_are_the_same_pixels(void **state)
{
	need_gpu();
	compare(96, false, 1);
	compare(96, true, 1);
}

static void so_they_are_in_few_slots(void **state)
{
	need_gpu();
	compare(40, false, 1);
}

static void so_they_are_if_the_gpu_comes_late(void **state)
{
	need_gpu();
	compare(96, false, 12);
}

/* After a rut in one tile, its posts go to the GPU, of that tile and of a coarser one that is drawn; nothing else. */
static void what_changed_is_uploaded_and_nothing_else(void **state)
{
	need_gpu();
	struct rig rig;
	struct gpu_stats before, after;
	uint64_t lists, uploaded, changed = 0;
	struct resident_host_figures figures;
	rig_open(&rig, support_path("host.furrow"), 96, true, false);
	open_pictures(&rig, false, 96);
	for (int step = 1; step <= 24; step++) /* so that tiles have planes */
		one_step(&rig, step);
	draw(&rig, 64, 64, 60, one, &uploaded);
	draw(&rig, 64, 64, 60, other, &lists);
	assert_true(uploaded - lists >= rig.selection.draw_count * POSTS * sizeof(int32_t));
	for (int step = 1; step <= 24; step++) {
		const int64_t x = 20 + step * 23 % 210, y = 30 + step * 41 % 200;
		const struct post_rect rect = {x, y, x + 2 * RUT, y + RUT};
		uint64_t most = 0;
		one_step(&rig, step); /* the same ruts again: a step writes what is there */
		draw(&rig, 64, 64, 60, other, &uploaded);
		for (size_t i = 0; i < rig.selection.draw_count; i++) {
			const struct tile tile = rig.selection.draws[i].tile;
			const int finer = tile.level - LEVEL;
			struct post_rect own = tile_post_rect(&extent, tile);
			own = (struct post_rect){own.x0 << finer, own.y0 << finer, ((own.x1 - 1) << finer) + 1, ((own.y1 - 1) << finer) + 1};
			const struct post_rect in = post_rect_intersect(own, rect);
			most += post_rect_empty(in) ? 0 : (uint64_t)((in.x1 - in.x0) * (in.y1 - in.y0)) * 5;
		}
		if (uploaded - lists > most || most > 4 * 2 * RUT * RUT * 5)
			fail_msg("step %d: %d bytes, at most %d of %d", step, (int)(uploaded - lists), (int)most, 4 * 2 * RUT * RUT * 5);
		changed += uploaded > lists;
	}
	assert_true(changed > 10);
	gpu_stats(gpu, &before);
	one_step(&rig, 3);
	gpu_stats(gpu, &after);
	assert_int_equal(before.upload_bytes, after.upload_bytes); /* a step alone uploads nothing */
	assert_int_equal(before.read_back_bytes, after.read_back_bytes);
	resident_host_figures(rig.host, &figures);
	assert_true(figures.bytes > 0 && resident_pages_is_deformed(rig.pages, rig.selection.draws[0].slot));
	/* Without a GPU it goes on. */
	render_destroy(rig.render);
	rig.render = NULL;
	gpu_slots_destroy(rig.slots);
	rig.slots = NULL;
	resident_pages_mirror(rig.pages, NULL, NULL);
	one_step(&rig, 4);
	open_pictures(&rig, false, 96);
	draw(&rig, 64, 64, 60, one, &uploaded);
	assert_true(uploaded > 100 * lists);
	rig_close(&rig);
}

TEST_PROGRAM(host_pages)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pictures_are_the_same_pixels),
		cmocka_unit_test(so_they_are_in_few_slots),
		cmocka_unit_test(so_they_are_if_the_gpu_comes_late),
		cmocka_unit_test(what_changed_is_uploaded_and_nothing_else),
	};
	if (support_enter(NULL) != 0)
		return 1;
	const int failed = cmocka_run_group_tests_name("host_pages", tests, open_gpu, close_gpu);
	return support_leave(NULL) != 0 ? 1 : failed;
}
