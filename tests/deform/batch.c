/* Contacts of a batch leave the same bits as contacts that are computed one after another. */
#include "ground.h"
#include "../support/program.h"

#define CONTACTS 9

static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.9}, crate = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.6}};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.8, .width = 0.5}, egg = {.kind = SOIL_ELLIPSOID, .size = {0.9, 0.6, 0.5}};
static const struct soil_shape barrel = {.kind = SOIL_CYLINDER, .radius = 0.5, .length = 0.8}, pill = {.kind = SOIL_CAPSULE, .radius = 0.4, .length = 0.5};
static const struct soil_shape *const shapes[] = {&wheel, &ball, &wheel, &crate, &barrel, &wheel, &pill, &egg};
/* Under scm: few on each ground, since each kind has programs of its own. The posts that a ball touches are counted first. */
static const struct soil_shape track = {.kind = SOIL_BOX, .size = {1.4, 0.5, 0.6}, .belt = true};
static const struct soil_shape *const of_scm[3][4] = {{&wheel, &ball, &wheel, &ball}, {&wheel, &barrel, &wheel, &barrel}, {&wheel, &track, &wheel, &track}};

static int32_t holed(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 61 == 0 ? BASE_NODATA : (int32_t)(20000 * sin((double)x * 0.2) * cos((double)y * 0.3));
}

/* A contact somewhere around the middle of square (x, y) of posts: on a tile's side or a corner, too. `way`: 0: it does not move; 1: along x;
 * 2: anywhere. */
static struct deform_contact any_contact(const struct ground *ground, const struct soil_shape *shape, double x, double y, int way)
{
	double z = soil_shape_reach(shape, 0, 0) - 0.25 + 0.1 * any_share();
	struct deform_contact contact = {.shape = shape, .from = ground_pose(ground, x + 3 * any_share(), y + 3 * any_share(), z)};
	contact.to = contact.from;
	if (way == 2)
		contact.from.yaw = contact.to.yaw = 4 * any_share();
	if (way == 2 && any_word() % 4 == 0 && (ground->params.model != DEFORM_SCM || shape == &barrel))
		contact.to.roll = 0.2 * any_share();
	if (way > 0)
		contact.to.x += lattice_offset(ground->params.spacing * (way == 1 ? 1 : any_share()));
	if (way == 2) {
		contact.to.y += lattice_offset(ground->params.spacing * any_share());
		contact.to.z += lattice_offset(0.02 * any_share());
	}
	/* Under scm: slip. */
	contact.turned = way > 0 ? 0.3 * any_share() : 0;
	contact.rotated[2] = way > 0 && shape->kind != SOIL_WHEEL ? 0.01 * any_share() : 0;
	return contact;
}

/* Computes all in batches; how many batches there were. */
static uint64_t run_batches(struct ground *ground, const struct deform_contact *contacts, size_t count)
{
	struct deform *deform = ground->deform;
	struct deform_figures before, after;
	size_t first = 0;
	deform_figures(deform, &before);
	while (first < count) {
		size_t at = first;
		deform_batch_begin(deform);
		for (; at < count; at++) {
			assert_ok(deform_windows(deform, &contacts[at], ground->windows, &ground->window_count));
			assert_true(deform_is_batched(deform, &contacts[at], ground->windows, ground->window_count));
			bool added;
			assert_ok(deform_batch_add(deform, &contacts[at], &ground->windows[0], ground->tiles, ground->tile_count, &added));
			if (!added)
				break;
		}
		assert_true(at > first);
		assert_ok(deform_batch_compute(deform));
		first = at;
	}
	deform_figures(deform, &after);
	return after.batches - before.batches;
}

/* Both have the same in all planes, and counted the same. Returns how many posts are not as they were. */
static size_t assert_alike(struct ground *alone, struct ground *together)
{
	const size_t posts = (size_t)(alone->posts * alone->posts);
	struct deform_tally tallies[2];
	size_t changed = 0;
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(alone->deform->planes & PLANE_BIT(plane)))
			continue;
		int32_t *first = ground_plane(alone, (enum plane)plane), *second = ground_plane(together, (enum plane)plane);
		for (size_t i = 0; i < posts; i++) {
			if (first[i] != second[i])
				fail_msg("%s differs at post %zu, %zu: %d alone, %d in a batch", plane_name((enum plane)plane), i % (size_t)alone->posts,
					 i / (size_t)alone->posts, first[i], second[i]);
			changed += plane == PLANE_OFFSET && first[i] != 0;
		}
		mem_free(first);
		mem_free(second);
	}
	assert_ok(deform_tally(alone->deform, &tallies[0]));
	assert_ok(deform_tally(together->deform, &tallies[1]));
	assert_memory_equal(&tallies[0], &tallies[1], sizeof tallies[0]);
	return changed;
}

static void sweep_alone(struct ground *ground, const struct deform_contact *contact)
{
	ground_sweep(ground, contact);
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(deform_wake_swept(ground->deform, &ground->windows[i], (uint32_t)i));
}

/* Both tell the same forces, in the same order. Returns of how many contacts. */
static size_t assert_forces_alike(struct ground *alone, struct ground *together)
{
	size_t count = 0;
	bool taken[2] = {true, true};
	assert_ok(deform_forces_begin(alone->deform));
	assert_ok(deform_forces_begin(together->deform));
	while (taken[0]) {
		struct deform_forces forces[2];
		assert_ok(deform_forces_take(alone->deform, true, &forces[0], &taken[0]));
		assert_ok(deform_forces_take(together->deform, true, &forces[1], &taken[1]));
		assert_int_equal(taken[0], taken[1]);
		if (taken[0])
			assert_memory_equal(&forces[0], &forces[1], sizeof forces[0]);
		count += taken[0] && forces[0].force[2] > 0;
	}
	return count;
}

/* The same blocks are active in both. Then soil slides in these. */
static void assert_slide_alike(struct ground *alone, struct ground *together)
{
	const struct soil_block *blocks[2];
	size_t counts[2];
	if (alone->deform->active == NULL)
		return;
	gpu_finish(test_gpu);
	assert_ok(deform_active_blocks(alone->deform, &blocks[0], &counts[0]));
	assert_ok(deform_active_blocks(together->deform, &blocks[1], &counts[1]));
	assert_int_equal(counts[0], counts[1]);
	if (counts[0] > 0)
		assert_memory_equal(blocks[0], blocks[1], counts[0] * sizeof *blocks[0]);
	assert_int_equal(ground_interval(alone, NULL, 0).blocks, ground_interval(together, NULL, 0).blocks);
	assert_alike(alone, together);
}

/* Three soils, in patches that cross tiles. */
static void upload_classes(struct ground *ground)
{
	const int64_t cells = ground->params.cells, side = cells + 1;
	struct gpu_staging *staging;
	assert_ok(gpu_staging_create(test_gpu, (size_t)(side * side), &staging));
	for (size_t k = 0; k < ground->tile_count; k++) {
		uint8_t *classes = gpu_staging_bytes(staging);
		for (int64_t i = 0; i < side * side; i++) {
			const int64_t x = (int64_t)ground->tiles[k].tile.x * cells + i % side, y = (int64_t)ground->tiles[k].tile.y * cells + i / side;
			classes[i] = (uint8_t)((x / 7 + y / 5) % 3);
		}
		assert_ok(gpu_slots_upload_classes(ground->slots, ground->tiles[k].slot, staging, 0));
		gpu_finish(test_gpu);
	}
	gpu_staging_destroy(staging);
}

/* Three rounds over the same ground: what one leaves, the next one finds. */
static void check(const struct ground_params *params, size_t number, int way)
{
	const bool scm = params->model == DEFORM_SCM;
	struct ground alone, together;
	size_t told = 0;
	ground_init(&alone, params);
	ground_init(&together, params);
	if (params->soil_count > 1) {
		upload_classes(&alone);
		upload_classes(&together);
	}
	for (int round = 0; round < 3; round++) {
		struct deform_contact contacts[CONTACTS];
		for (int i = 0; i < CONTACTS; i++) {
			/* Squares are as wide as two tiles, so that contacts share none. */
			double wide = 2 * params->cells, x = (i % 3 + 0.5) * wide, y = (i / 3 + 0.5) * wide;
			contacts[i] = any_contact(&alone, scm ? of_scm[number % 3][any_word() % 4] : shapes[any_word() % 8], x, y, way);
			/* Forces of some, of all, of none. */
			contacts[i].tag = scm && number % 3 != 2 && (number % 3 == 1 || i % 2 == 0) ? 1 + any_word() % 1000 : 0;
			if (contacts[i].tag != 0 && number % 3 == 0 && i % 4 == 0) {
				contacts[i].load = 500 + 300 * any_share();
				contacts[i].loaded_body = i < 8 ? (uint32_t)i + 1 : 0;
			}
			sweep_alone(&alone, &contacts[i]);
		}
		assert_true(run_batches(&together, contacts, CONTACTS) > 0);
		assert_true(assert_alike(&alone, &together) > 40);
		told += assert_forces_alike(&alone, &together);
		assert_slide_alike(&alone, &together);
	}
	assert_true(!scm || number % 3 == 2 ? told == 0 : told > 0);
	ground_finish(&alone);
	ground_finish(&together);
}

static void a_batch_leaves_the_bits_of_contacts_that_are_alone(void **state)
{
	static const struct ground_params grounds[] = {
		{.cells = 32, .spacing = 0.25, .model = DEFORM_NONE},
		{.cells = 64, .spacing = 0.1, .model = DEFORM_NONE, .dirt = true},
		{.cells = 32, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .dirt = true},
		{.cells = 64, .spacing = 0.125, .model = DEFORM_BOX_FILTER, .radius = 2, .repetitions = 3},
		{.cells = 64, .spacing = 0.09, .model = DEFORM_BOX_FILTER, .radius = 4, .repetitions = 2, .dirt = true},
		{.cells = 32, .spacing = 0.25, .model = DEFORM_SCM, .bulldozing = 0.5, .iterations = 3, .lines = true, .relief = 100},
		{.cells = 64, .spacing = 0.125, .model = DEFORM_SCM, .bulldozing = 1, .iterations = 1, .lines = true, .depth = 0.3, .stands = true,
		 .touched = true, .slip_sinkage = 1, .dirt = true},
		{.cells = 64, .spacing = 0.09, .model = DEFORM_SCM, .bulldozing = 0.7, .iterations = 2, .soil_count = 3, .lines = true,
		 .ground_normals = true, .relief = 100},
	};
	struct soil_numbers soils[3];
	(void)state;
	need_gpu();
	assert_ok(soil_named("dry_sand", &soils[0]));
	assert_ok(soil_named("sandy_loam_15", &soils[1]));
	assert_ok(soil_named("lunar", &soils[2]));
	for (size_t i = 0; i < sizeof grounds / sizeof *grounds; i++) {
		struct ground_params params = grounds[i];
		params.tiles = 6;
		params.soils = params.soil_count > 1 ? soils : NULL;
		params.first = (int64_t)(i % 2) * 5000;
		params.height = holed;
		params.batches = true;
		params.loaded_bodies = params.model == DEFORM_SCM ? CONTACTS : 0;
		for (int way = params.model == DEFORM_BOX_FILTER; way < 3; way += 1 + (params.model == DEFORM_SCM))
			check(&params, i, way);
	}
}

/* 600 windows of some 20 posts do not fit one batch, nor do 300 whose forces are asked for. The layer grows on the way to that. */
static void what_does_not_fit_a_batch_goes_into_the_next(void **state)
{
	static const struct ground_params grounds[] = {
		{.cells = 32, .tiles = 25, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .height = holed, .batches = true},
		{.cells = 64, .tiles = 18, .spacing = 0.25, .model = DEFORM_SCM, .bulldozing = 0.5, .relief = 100, .height = holed, .batches = true},
	};
	(void)state;
	need_gpu();
	for (int i = 0; i < 2; i++) {
		struct ground alone, together;
		const bool scm = grounds[i].model == DEFORM_SCM;
		const int count = scm ? 300 : 600, across = scm ? 18 : 25, apart = (int)grounds[i].cells;
		struct deform_contact *contacts = ground_room(count, sizeof *contacts);
		ground_init(&alone, &grounds[i]);
		ground_init(&together, &grounds[i]);
		for (int k = 0; k < count; k++) {
			contacts[k] = any_contact(&alone, k % 50 == 0 && !scm ? &crate : &wheel, k % across * apart + apart / 2, k / across * apart + apart / 2, 2);
			contacts[k].tag = scm ? 1 + (uint64_t)k : 0;
			sweep_alone(&alone, &contacts[k]);
			if (k == 255 && scm)
				assert_ok(deform_forces_begin(alone.deform));
		}
		assert_true(run_batches(&together, contacts, (size_t)count) > 1);
		assert_true(assert_alike(&alone, &together) > 4000);
		assert_true(assert_forces_alike(&alone, &together) >= (scm ? 250 : 0));
		mem_free(contacts);
		ground_finish(&alone);
		ground_finish(&together);
	}
}

static void only_small_contacts_that_are_alike_are_batched(void **state)
{
	struct ground_params params = {.cells = 64, .tiles = 6, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .batches = true};
	static const struct soil_shape hall = {.kind = SOIL_BOX, .size = {80, 70, 1}};
	static const struct soil_shape lugged = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 9, .grouser_height = 0.06,
						 .grouser_thickness = 0.05};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &params);
	const struct {
		const struct soil_shape *shape;
		int way;
		bool batched;
	} cases[] = {{&wheel, 1, true}, {&wheel, 0, false}, {&crate, 2, true}, {&hall, 2, false}, {&lugged, 1, false}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct deform_contact contact = any_contact(&ground, cases[i].shape, 190, 190, cases[i].way);
		assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
		assert_int_equal(deform_is_batched(ground.deform, &contact, ground.windows, ground.window_count), cases[i].batched);
	}
	ground_finish(&ground);
	/* Under scm a contact without motion is batched, too, and one with a load. */
	params.model = DEFORM_SCM;
	ground_init(&ground, &params);
	for (int i = 0; i < 5; i++) {
		struct deform_contact contact = any_contact(&ground, i == 4 ? &lugged : i == 3 ? &ball : &wheel, 190, 190, i % 2);
		contact.load = i == 2 ? 900 : 0;
		assert_ok(deform_windows(ground.deform, &contact, ground.windows, &ground.window_count));
		assert_int_equal(deform_is_batched(ground.deform, &contact, ground.windows, ground.window_count), i < 4);
	}
	ground_finish(&ground);
}

TEST_PROGRAM(batch)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_batch_leaves_the_bits_of_contacts_that_are_alone),
		cmocka_unit_test(what_does_not_fit_a_batch_goes_into_the_next),
		cmocka_unit_test(only_small_contacts_that_are_alike_are_batched),
	};
	return cmocka_run_group_tests_name("batch", tests, open_gpu, close_gpu);
}
