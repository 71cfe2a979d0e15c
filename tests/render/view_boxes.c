/*
 * The boxes pictures are culled by: they hold what is there, in the step in which it is pressed; what lies beyond the base's
 * box is drawn; and what was there before a drive is known exactly.
 */
#include "../support/near.h"
#include "view_rig.h"

#include "drive/internal.h"
#include "../support/program.h"
#include "../support/skip.h"

enum { WIDTH = 160, HEIGHT = 90 };

/* A valley in the west; a plateau 5 m above it. */
static const struct extent ground = {129, 129, 1, 32};
static double shelf(int64_t x, int64_t y)
{
	return x < 40 ? 95 : x > 44 ? 100 : 95 + 1.25 * (double)(x - 40);
}

/* With heights of its own it digs a trench into the shelf; without, it leaves ruts. */
static const char scene_text[] =
	"scene: 1\ntime_step: 0.1\nend_time: 2.2\n%s"
	"objects:\n  - {name: a, shape: {sphere: {radius: 2}}, %s}\n"
	"view: {size: [160, 90], camera: {fixed: {eye: [34, 50, 97.5], target: [100, 50, 97.5]}}, effects: []}\n"
	"cache: {slots: 128}\n";
static const char trench[] = "path: {file: trench.csv}", ruts[] = "sink: 0.4, path: {points: [[20, 20], [100, 100]], speed: 50}";
static const char slides[] = "soil: {name: dry_sand}\nredistribute: {model: slippage}\n";

struct guest {
	void (*look)(struct drive *drive);
	size_t posts, tiles, steps; /* looked at */
	double deepest, highest;
};
static struct guest guest;

/* --- */

static void wait_for_tiles(struct drive *drive, const struct render_camera *camera)
{
	for (int tries = 0; tries < 100000; tries++) {
		must(render_view_select(drive->view, camera, false));
		const struct render_selection *selection = drive->view->selection;
		if (selection->wanted_count == 0)
			return;
		page_cache_want(world_resident(drive->world)->cache, selection->wanted, selection->wanted_count);
		usleep(500);
		must(page_cache_poll(world_resident(drive->world)->cache));
	}
	fail();
}

static void draw(struct drive *drive, const struct render_camera *camera, uint8_t *pixels)
{
	struct gpu_staging *staging;
	const size_t bytes = 4 * WIDTH * HEIGHT;
	wait_for_tiles(drive, camera);
	must(render_frame(drive->view->render, camera, drive->view->selection));
	must(gpu_staging_create(world_resident(drive->world)->gpu, bytes, &staging));
	render_read_into(drive->view->render, SCENE_IMAGE_COLOUR, staging);
	while (!gpu_staging_idle(staging))
		usleep(100);
	memcpy(pixels, gpu_staging_bytes(staging), bytes);
	gpu_staging_destroy(staging);
}

/* The chain of all boxes over a resident tile holds its posts. */
static void check_tile(struct drive *drive, struct tile tile, uint32_t slot)
{
	struct view *view = drive->view;
	const struct extent *of = &world_resident(drive->world)->meta->extent;
	struct gpu_texture *offsets = gpu_slots_get(world_resident(drive->world)->slots, slot)->planes[PLANE_OFFSET];
	uint32_t side = tile_posts(of);
	int32_t posts[33 * 33];
	if (offsets == NULL)
		return;
	assert_true(side * side <= sizeof posts / sizeof *posts);
	gpu_texture_read(offsets, 0, (struct gpu_rect){0, 0, side, side}, posts);
	double low = 0, high = 0;
	for (uint32_t i = 0; i < side * side; i++) {
		low = support_least(low, lattice_offset_metres(posts[i]));
		high = support_most(high, lattice_offset_metres(posts[i]));
	}
	guest.posts += side * side;
	guest.tiles++;
	guest.deepest = support_least(guest.deepest, low);
	guest.highest = support_most(guest.highest, high);
	for (int level = tile.level; level <= extent_coarsest(of); level++) {
		double lowest, highest;
		must(render_view_offsets(view, tile_ancestor(tile, level), false, &lowest, &highest));
		if (!(low >= lowest && high <= highest))
			fail_msg("tile %d/%u/%u: %g to %g, level %d says %g to %g", tile.level, tile.x, tile.y, low, high, level, lowest,
				 highest);
	}
}

static void check_boxes(struct drive *drive)
{
	const struct resident *parts = world_resident(drive->world);
	const struct extent *of = &parts->meta->extent;
	for (uint32_t y = 0; y < extent_tiles_y(of, parts->level); y++)
		for (uint32_t x = 0; x < extent_tiles_x(of, parts->level); x++) {
			const struct tile tile = {parts->level, x, y};
			uint32_t slot;
			if (page_cache_peek(parts->cache, tile_key(tile), false, &slot))
				check_tile(drive, tile, slot);
		}
}

static enum status on_turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct drive_figures figures;
	drive_figures(drive, &figures);
	wish->pace = INFINITY;
	wish->go = figures.over ? DRIVE_STOP : DRIVE_ONE;
	guest.steps = (size_t)figures.step;
	guest.look(drive);
	return STATUS_OK;
}

static enum status on_picture(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	return STATUS_OK;
}

static void world_and_look(const char *model, const char *object, const char *store, const char *spacing, void (*look)(struct drive *))
{
	const char *path = support_path("boxes.yaml");
	char text[1024];
	snprintf(text, sizeof text, scene_text, model, object);
	support_write(support_path("trench.csv"), "0,30,50,98\n1.75,100,50,98\n");
	const struct scene_setting setting = {"spacing", spacing};
	struct scene *scene;
	support_write(path, text);
	must(scene_load(path, &setting, 1, &scene));
	guest = (struct guest){.look = look};
	const struct drive_host host = {NULL, on_turn, on_picture};
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path("out"), .host = &host};
	struct drive_result result = {.json = NULL};
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	mem_free(result.json);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	must(status);
}

/* --- */

static void boxes_hold_what_is_pressed_in_every_step(void **state)
{
	const char *const models[] = {"", "redistribute: {model: box}\n", slides, "soil: {name: dry_sand}\nredistribute: {model: sumner}\n"};
	char store[128]; /* others are asked for meanwhile */
	snprintf(store, sizeof store, "%s", support_path("hold.furrow"));
	for (int i = 0; i < 16; i++) {
		bool digs = i & 1, fine = i & 2;
		support_store(store, ground, digs ? shelf : support_hills);
		/* And once more over what that left. */
		for (int turn = 0; turn < 2; turn++) {
			world_and_look(models[i / 4], digs ? trench : ruts, store, fine ? "0.5" : "1", check_boxes);
			assert_true(guest.tiles > 20 && guest.deepest < (digs ? -3.5 : -0.3));
			assert_true(i / 4 < 2 ? guest.highest == 0 : guest.highest > 0.05);
		}
	}
}

/* --- */

static uint8_t by_base[4 * WIDTH * HEIGHT], by_boxes[4 * WIDTH * HEIGHT], by_none[4 * WIDTH * HEIGHT];

static size_t different(const uint8_t *a, const uint8_t *b)
{
	size_t count = 0;
	for (size_t i = 0; i < WIDTH * HEIGHT; i++)
		count += memcmp(a + 4 * i, b + 4 * i, 4) != 0;
	return count;
}

/* With true boxes; with those of the base alone; and with boxes so large that nothing is culled. */
static void draw_three(struct drive *drive, const struct render_camera *camera)
{
	struct view *view = drive->view;
	struct offset_bounds kept = view->bounds;
	draw(drive, camera, by_boxes);
	view->bounds.added = (struct key_map){.room = 0};
	draw(drive, camera, by_base);
	for (uint32_t y = 0; y < extent_tiles_y(&ground, 0); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&ground, 0); x++)
			must(resident_bounds_add(&view->bounds, (struct tile){0, x, y}, -1e4, 1e4));
	draw(drive, camera, by_none);
	resident_bounds_finish(&view->bounds);
	view->bounds = kept;
}

static void look_into_the_trench(struct drive *drive)
{
	const struct render_camera camera = {{34, 50, 97.5}, {100, 50, 97.5}, 0.05, {0}};
	if (guest.steps < 10)
		return;
	draw_three(drive, &camera);
	assert_int_equal(different(by_boxes, by_none), 0);
	guest.posts += different(by_base, by_none) > WIDTH * HEIGHT / 20;
}

static void look_at_the_heap(struct drive *drive)
{
	const struct render_camera camera = {{34, 50, 100.1}, {100, 50, 101.8}, 0.05, {0}};
	if (guest.steps < 10)
		return;
	draw_three(drive, &camera);
	assert_int_equal(different(by_boxes, by_none), 0);
	guest.posts += different(by_base, by_none) > 20;
}

static void a_pit_below_and_a_heap_above_the_bases_box_are_drawn_in_their_step(void **state)
{
	const char *store = support_path("seen.furrow");
	support_store(store, ground, shelf);
	world_and_look("", trench, store, "1", look_into_the_trench);
	assert_true(guest.posts >= 10); /* steps in which the base's boxes were not enough */
	support_store(store, ground, shelf);
	world_and_look(slides, trench, store, "1", look_at_the_heap);
	assert_true(guest.posts >= 10);
}

/* --- */

/* Digs a hole in the store, over whatever was dug before; 0 m fills it. */
static void dig(uint32_t x, uint32_t y, double metres)
{
	int32_t offset[(CELLS + 1) * (CELLS + 1)] = {0};
	struct store *store;
	struct store_commit_result result;
	must(store_open(support_path("view.furrow"), &(struct store_options){.mode = STORE_WRITE}, &store));
	must(store_set_working_level(store, 0));
	offset[5 * (CELLS + 1) + 7] = (int32_t)lattice_offset(-metres);
	const struct store_page page = {.tile = {0, x, y}, .planes = {[PLANE_OFFSET] = offset}};
	const struct store_run run = {.scene_hash = "0", .step = 1, .state = "{}"};
	must(store_commit(store, &page, 1, &run, &result));
	store_close(store);
}

static bool boxes_of_base(void *user, struct tile tile, double *low, double *high)
{
	struct rig *rig = user;
	bool any = false;
	if (!extent_has(&extent, tile) || tile.level < 0)
		return false;
	must(resident_ground_range(rig->made.resident.ground, tile, low, high, &any));
	return any;
}

/* As if every deformed tile were as wide as the widest. */
static double widest;
static bool boxes_all_wide(void *user, struct tile tile, double *low, double *high)
{
	struct rig *rig = user;
	bool any = boxes_of_base(user, tile, low, high);
	double slack = render_view_is_deformed(rig->view, tile) ? widest : 0;
	*low -= slack;
	*high += slack;
	return any;
}

static bool never_resident(void *user, struct tile tile, uint32_t *slot)
{
	return false;
}

static bool down_to_zero(void *user, struct tile tile)
{
	return tile.level > 0;
}

/* A deep pit in one corner, and shallow ruts everywhere else. */
static void what_was_dug_before_is_known_exactly_and_the_rest_is_as_the_base(void **state)
{
	struct rig rig;
	double low, high;
	rig_open(&rig, 400, 0, 0);
	rig_close(&rig); /* it made the store */
	const uint32_t across = extent_tiles_x(&extent, 0);
	for (uint32_t y = 0; y < across; y++)
		for (uint32_t x = y % 2; x < across; x += 2)
			dig(x, y, 0.125);
	dig(0, across - 2, 40);
	dig(2, 2, 0); /* and back */
	rig_open(&rig, 400, 0, 0);
	struct view *view = rig.view;
	for (int level = 0; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				const struct tile tile = {level, x, y};
				double lowest = 0, highest = 0;
				bool found;
				must(store_read_offset_range(resident_ground_reader(rig.made.resident.ground), tile, &lowest, &highest, &found));
				must(render_view_offsets(view, tile, false, &low, &high));
				assert_true(found == render_view_is_deformed(view, tile));
				assert_true(low == lowest && high == highest && high == 0);
				assert_true(level > 0 || found == ((x + y) % 2 == 0 && (x != 2 || y != 2)));
				assert_true(!found || low == -0.125 || low == -40);
			}
	/* From above the hills at what is higher than they are: pits are no reason to look at ground. */
	struct render_camera camera = {{20, 20, 140}, {480, 480, 160}, 0.3, {0}};
	must(render_view_select(view, &camera, true));
	size_t needed = view->selection->needed, culled = view->selection->culled;
	struct render_view looking;
	render_view(view->render, &camera, &looking);
	static struct render_selection wide, base;
	widest = 40; /* as all were taken to be */
	render_select(&extent, &looking, &(struct render_source){&rig, boxes_all_wide, never_resident, down_to_zero, NULL, NULL}, &wide);
	render_select(&extent, &looking, &(struct render_source){&rig, boxes_of_base, never_resident, down_to_zero, NULL, NULL}, &base);
	print_message("tiles of a picture: %zu by true boxes (%zu culled), %zu by the widest (%zu), %zu undeformed (%zu)\n", needed, culled,
		      wide.needed, wide.culled, base.needed, base.culled);
	assert_true(needed >= base.needed && 3 * needed < 2 * wide.needed);
	rig_close(&rig);
}

/* Others asked the ground for its range before: a view that comes later knows what was committed since. */
static void a_late_view_knows_what_is_there(void **state)
{
	struct rig rig;
	rig_mode = STORE_WRITE;
	rig_open(&rig, 400, 0, 0);
	const struct tile top = {extent_coarsest(&extent), 0, 0};
	int32_t offset[(CELLS + 1) * (CELLS + 1)] = {0};
	struct store_commit_result result;
	double low, high;
	bool found;
	must(resident_ground_offset_range(rig.made.resident.ground, top, &low, &high, &found));
	offset[5 * (CELLS + 1) + 7] = (int32_t)lattice_offset(-77);
	const struct store_page page = {.tile = {rig.made.resident.level, 2, 2}, .planes = {[PLANE_OFFSET] = offset}};
	const struct store_run run = {.scene_hash = "0", .step = 1, .state = "{}"};
	must(store_set_working_level(rig.made.resident.store, rig.made.resident.level));
	must(store_commit(rig.made.resident.store, &page, 1, &run, &result));
	render_view_destroy(rig.view);
	rig.made.resident.was_deformed = true;
	rig_set(&rig);
	must(render_view_create(rig.world, false, &rig.view));
	must(render_view_offsets(rig.view, top, false, &low, &high));
	assert_true(low == -77 && high == 0);
	rig_close(&rig);
}

TEST_PROGRAM(view_boxes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(boxes_hold_what_is_pressed_in_every_step),
		cmocka_unit_test(a_pit_below_and_a_heap_above_the_bases_box_are_drawn_in_their_step),
		cmocka_unit_test(what_was_dug_before_is_known_exactly_and_the_rest_is_as_the_base),
		cmocka_unit_test(a_late_view_knows_what_is_there),
	};
	return cmocka_run_group_tests_name("view_boxes", tests, support_enter, support_leave);
}
