/*
 * A coarser level goes stale after an edit: never. Law 4 where it can be seen before a commit: a coarser tile in a slot is the decimation of the
 * working level, whether it was there when the ground changed or came later, and whatever of the
 * change is in a slot, in the queue or in the store by then.
 */
#include "../gpu/staged.h"
#include "../support.h"

#include "world/internal.h"

enum { CELLS = 32, LEVEL = -1, SIDE = 8 * CELLS + 1 };
static const struct extent extent = {129, 129, 1, CELLS};
static const struct deform_shape sphere = {.kind = DEFORM_SPHERE, .radius = 2.5};
static const struct scene_object object = {.name = "ball", .shape = {.kind = DEFORM_SPHERE, .radius = 2.5}};

struct rig {
	struct world world;
	struct scene scene;
	struct body body;
};

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct world *world = user;
	return resident_pyramid_flush_tile(world->pyramid, world->cache, tile, slot);
}

static void rig_open(struct rig *rig, const char *path, uint32_t slots)
{
	struct world *world = &rig->world;
	*rig = (struct rig){.scene = {.slots = slots, .hash = "0"}, .body = {.object = &object}};
	support_store(path, extent, support_hills);
	must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &world->store));
	must(store_set_working_level(world->store, LEVEL));
	world->scene = &rig->scene;
	world->bodies = &rig->body;
	world->meta = store_meta(world->store);
	world->level = LEVEL;
	world->spacing = extent_spacing(&extent, LEVEL);
	world->commit_log = tmpfile();
	assert_non_null(world->commit_log);
	enum status status = gpu_create(&(struct gpu_params){.draws = false}, &world->gpu);
	if (status == STATUS_NO_GL) {
		store_close(world->store);
		skip();
	}
	must(status);
	must(gpu_slots_create(world->gpu, CELLS, slots, PLANE_BIT(PLANE_DISTURBANCE), &world->slots));
	must(resident_ground_create(world->store, 4, &world->ground));
	must(resident_pyramid_create(&world->meta->extent, LEVEL, world->slots, &world->pyramid));
	must(deform_create(&(struct deform_params){.gpu = world->gpu,
						   .slots = world->slots,
						   .extent = &world->meta->extent,
						   .level = LEVEL,
						   .reference = resident_ground_reference(world->store),
						   .model = DEFORM_BOX_FILTER,
						   .box_radius = 1,
						   .box_repetitions = 1,
						   .dirt = true},
			   &world->deform));
	must(resident_pages_create(&(struct pages_params){.store = world->store,
						 .gpu = world->gpu,
						 .slots = world->slots,
						 .planes = gpu_slots_planes(world->slots),
						 .level = LEVEL,
						 .count = slots,
						 .loaders = 2,
						 .step_pages = 64,
						 .record = world_record_pages(&rig->scene),
						 .epochs = world->commit_log,
						 .epoch_age = 0.01,
						 .before_read_back = before_read_back,
						 .user = world},
			  &world->pages));
	world->cache = resident_pages_cache(world->pages);
	world->record = calloc(1, world_record_bytes(0));
}

static void rig_close(struct rig *rig)
{
	struct world *world = &rig->world;
	resident_pages_destroy(world->pages);
	deform_destroy(world->deform);
	resident_pyramid_destroy(world->pyramid);
	resident_ground_destroy(world->ground);
	gpu_slots_destroy(world->slots);
	gpu_destroy(world->gpu);
	store_close(world->store);
	fclose(world->commit_log);
	free(world->record);
}

static void roll(struct rig *rig, int step)
{
	double angle = step * 0.05, x = 64 + 50 * sin(angle), y = 64 + 45 * sin(2.1 * angle);
	struct event event = {.contact = true, .pose = {.x = lattice_offset(x), .y = lattice_offset(y)}};
	int64_t ground;
	bool any;
	must(resident_ground_height(rig->world.ground, event.pose.x, event.pose.y, &ground, &any));
	assert_true(any);
	event.pose.z = ground + lattice_offset(sphere.radius - 0.4);
	must(world_contact(&rig->world, &event, true));
}

static void end_step(struct rig *rig)
{
	must(resident_pyramid_flush(rig->world.pyramid, rig->world.cache));
	rig->world.record->step++;
	must(page_cache_end_step(rig->world.cache, rig->world.record));
}

static void read_tile(struct rig *rig, struct tile tile, int32_t *offset, uint8_t *dirt)
{
	uint32_t slot;
	size_t posts = (CELLS + 1) * (CELLS + 1);
	must(page_cache_pin(rig->world.cache, tile_key(tile), &slot));
	memset(offset, 0, posts * sizeof *offset);
	memset(dirt, 0, posts);
	if (gpu_slots_get(rig->world.slots, slot)->target != NULL)
		must(staged_read_deform(rig->world.gpu, rig->world.slots, CELLS, slot, offset, dirt));
	page_cache_unpin(rig->world.cache, tile_key(tile));
}

/* The whole working level, as it can be read now. */
static void read_working(struct rig *rig, int32_t *offsets, uint8_t *dirts)
{
	int32_t offset[(CELLS + 1) * (CELLS + 1)];
	uint8_t dirt[(CELLS + 1) * (CELLS + 1)];
	for (uint32_t ty = 0; ty < 8; ty++)
		for (uint32_t tx = 0; tx < 8; tx++) {
			read_tile(rig, (struct tile){LEVEL, tx, ty}, offset, dirt);
			for (int y = 0; y <= CELLS; y++)
				for (int x = 0; x <= CELLS; x++) {
					size_t at = (ty * CELLS + (size_t)y) * SIDE + tx * CELLS + (size_t)x;
					offsets[at] = offset[y * (CELLS + 1) + x];
					dirts[at] = dirt[y * (CELLS + 1) + x];
				}
		}
}

static size_t check_coarser(struct rig *rig, const int32_t *offsets, const uint8_t *dirts)
{
	int32_t offset[(CELLS + 1) * (CELLS + 1)];
	uint8_t dirt[(CELLS + 1) * (CELLS + 1)];
	size_t deformed = 0;
	for (int level = 0; level <= 2; level++)
		for (uint32_t ty = 0; ty < extent_tiles_y(&extent, level); ty++)
			for (uint32_t tx = 0; tx < extent_tiles_x(&extent, level); tx++) {
				read_tile(rig, (struct tile){level, tx, ty}, offset, dirt);
				for (uint32_t y = 0; y <= CELLS; y++)
					for (uint32_t x = 0; x <= CELLS; x++) {
						size_t at = ((size_t)(ty * CELLS + y) << (level - LEVEL)) * SIDE +
							    ((size_t)(tx * CELLS + x) << (level - LEVEL));
						assert_int_equal(offset[y * (CELLS + 1) + x], offsets[at]);
						assert_int_equal(dirt[y * (CELLS + 1) + x], dirts[at]);
						deformed += offsets[at] != 0;
					}
			}
	return deformed;
}

static void world_and_compare(uint32_t slots)
{
	static int32_t offsets[SIDE * SIDE], untouched[SIDE * SIDE];
	static uint8_t dirts[SIDE * SIDE], clean[SIDE * SIDE];
	const char *path = support_path("coarser.furrow");
	struct rig rig;
	rig_open(&rig, path, slots);
	/* Coarser tiles first: with slots for all they stay, and follow every change. */
	check_coarser(&rig, untouched, clean);
	for (int step = 0; step < 240; step++) {
		roll(&rig, step);
		end_step(&rig);
		if (step % 40 == 39) {
			read_working(&rig, offsets, dirts);
			assert_true(check_coarser(&rig, offsets, dirts) > 10);
		}
	}
	must(page_cache_flush(rig.world.cache, rig.world.record));
	read_working(&rig, offsets, dirts);
	check_coarser(&rig, offsets, dirts);
	rig_close(&rig);
	support_verify(path);
	double *stored = support_quanta(path, LEVEL, (struct post_rect){0, 0, SIDE, SIDE});
	for (size_t i = 0; i < SIDE * SIDE; i++)
		assert_true(stored[i] == offsets[i]);
	free(stored);
}

static void coarser_tiles_that_stay_follow_every_change(void **state)
{
	world_and_compare(96);
}

static void coarser_tiles_that_come_late_have_every_change(void **state)
{
	world_and_compare(6);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(coarser_tiles_that_stay_follow_every_change),
		cmocka_unit_test(coarser_tiles_that_come_late_have_every_change),
	};
	return cmocka_run_group_tests_name("coarser", tests, support_enter, support_leave);
}
