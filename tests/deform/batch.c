/* Contacts of a batch leave the same bits as contacts that are computed one after another. */
#include "ground.h"
#include "../support/program.h"

#define CONTACTS 9

static const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.9}, crate = {.kind = SOIL_BOX, .size = {1.2, 0.8, 0.6}};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.8, .width = 0.5}, egg = {.kind = SOIL_ELLIPSOID, .size = {0.9, 0.6, 0.5}};
static const struct soil_shape barrel = {.kind = SOIL_CYLINDER, .radius = 0.5, .length = 0.8}, pill = {.kind = SOIL_CAPSULE, .radius = 0.4, .length = 0.5};
static const struct soil_shape *const shapes[] = {&wheel, &ball, &wheel, &crate, &barrel, &wheel, &pill, &egg};

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
	if (way == 2 && any_word() % 4 == 0)
		contact.to.roll = 0.2 * any_share();
	if (way > 0)
		contact.to.x += lattice_offset(ground->params.spacing * (way == 1 ? 1 : any_share()));
	if (way == 2) {
		contact.to.y += lattice_offset(ground->params.spacing * any_share());
		contact.to.z += lattice_offset(0.02 * any_share());
	}
	contact.turned = way > 0 ? 0.3 * any_share() : 0;
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

/* Three rounds over the same ground: what one leaves, the next one finds. */
static void check(const struct ground_params *params, int way)
{
	struct ground alone, together;
	ground_init(&alone, params);
	ground_init(&together, params);
	for (int round = 0; round < 3; round++) {
		struct deform_contact contacts[CONTACTS];
		for (int i = 0; i < CONTACTS; i++) {
			/* Squares are as wide as two tiles, so that contacts share none. */
			double wide = 2 * params->cells, x = (i % 3 + 0.5) * wide, y = (i / 3 + 0.5) * wide;
			contacts[i] = any_contact(&alone, shapes[any_word() % 8], x, y, way);
			ground_sweep(&alone, &contacts[i]);
		}
		assert_true(run_batches(&together, contacts, CONTACTS) > 0);
		assert_true(assert_alike(&alone, &together) > 40);
	}
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
	};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof grounds / sizeof *grounds; i++) {
		struct ground_params params = grounds[i];
		params.tiles = 6;
		params.first = (int64_t)(i % 2) * 5000;
		params.height = holed;
		params.batches = true;
		for (int way = params.model == DEFORM_BOX_FILTER; way < 3; way++)
			check(&params, way);
	}
}

/* 600 windows of some 20 posts do not fit one batch. The layer grows on the way to that. */
static void what_does_not_fit_a_batch_goes_into_the_next(void **state)
{
	enum { COUNT = 600, ACROSS = 25 };
	const struct ground_params params = {.cells = 32, .tiles = ACROSS, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .height = holed, .batches = true};
	struct ground alone, together;
	(void)state;
	need_gpu();
	struct deform_contact *contacts = ground_room(COUNT, sizeof *contacts);
	ground_init(&alone, &params);
	ground_init(&together, &params);
	for (int k = 0; k < COUNT; k++) {
		contacts[k] = any_contact(&alone, k % 50 == 0 ? &crate : &wheel, k % ACROSS * 32 + 16, k / ACROSS * 32 + 16, 2);
		ground_sweep(&alone, &contacts[k]);
	}
	assert_true(run_batches(&together, contacts, COUNT) > 1);
	assert_true(assert_alike(&alone, &together) > 4000);
	mem_free(contacts);
	ground_finish(&alone);
	ground_finish(&together);
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
