/* Contacts of a batch leave the same bits as contacts that are computed one after another. */
#include "ground.h"

#define CONTACTS 9

static const struct deform_shape ball = {.kind = DEFORM_SPHERE, .radius = 0.9}, crate = {.kind = DEFORM_BOX, .size = {1.2, 0.8, 0.6}};
static const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.8, .width = 0.5}, egg = {.kind = DEFORM_ELLIPSOID, .size = {0.9, 0.6, 0.5}};
static const struct deform_shape barrel = {.kind = DEFORM_CYLINDER, .radius = 0.5, .length = 0.8}, pill = {.kind = DEFORM_CAPSULE, .radius = 0.4, .length = 0.5};
static const struct deform_shape *const shapes[] = {&wheel, &ball, &wheel, &crate, &barrel, &wheel, &pill, &egg};

static int32_t holed(int64_t x, int64_t y)
{
	return (x * 5 + y * 3) % 61 == 0 ? BASE_NODATA : (int32_t)(20000 * sin((double)x * 0.2) * cos((double)y * 0.3));
}

/* A contact somewhere around the middle of square (x, y) of posts: on a tile's side or a corner, too. `way`: 0: it does not move; 1: along x;
 * 2: anywhere. */
static struct deform_contact any_contact(const struct ground *ground, const struct deform_shape *shape, double x, double y, int way)
{
	double z = deform_shape_reach(shape, 0, 0) - 0.25 + 0.1 * any_share();
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

struct planes {
	int32_t *offset;
	uint8_t *dirt;
	struct deform_tally tally;
};

static struct planes planes_of(struct ground *ground)
{
	const size_t posts = (size_t)(ground->posts * ground->posts);
	struct planes planes = {ground_room((int64_t)posts, sizeof(int32_t)), ground_room((int64_t)posts, 1), {0}};
	ground_read(ground);
	memcpy(planes.offset, ground->offset, posts * sizeof(int32_t));
	memcpy(planes.dirt, ground->dirt, posts);
	assert_ok(deform_tally(ground->deform, &planes.tally));
	return planes;
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
		struct planes first = planes_of(&alone), second = planes_of(&together);
		const size_t posts = (size_t)(alone.posts * alone.posts);
		assert_memory_equal(first.offset, second.offset, posts * sizeof(int32_t));
		assert_memory_equal(first.dirt, second.dirt, posts);
		assert_memory_equal(&first.tally, &second.tally, sizeof first.tally);
		size_t changed = 0;
		for (size_t i = 0; i < posts; i++)
			changed += first.offset[i] != 0;
		assert_true(changed > 40);
		mem_free(first.offset);
		mem_free(first.dirt);
		mem_free(second.offset);
		mem_free(second.dirt);
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
	struct ground_params params = {.cells = 32, .tiles = 25, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .height = holed, .batches = true};
	struct ground alone, together;
	struct deform_contact *contacts = ground_room(600, sizeof *contacts);
	(void)state;
	need_gpu();
	ground_init(&alone, &params);
	ground_init(&together, &params);
	for (int i = 0; i < 600; i++) {
		contacts[i] = any_contact(&alone, i % 50 == 0 ? &crate : &wheel, 8 + i % 25 * 32 + 8, 8 + i / 25 * 32 + 8, 2);
		ground_sweep(&alone, &contacts[i]);
	}
	assert_true(run_batches(&together, contacts, 600) > 1);
	struct planes first = planes_of(&alone), second = planes_of(&together);
	assert_memory_equal(first.offset, second.offset, (size_t)(alone.posts * alone.posts) * sizeof(int32_t));
	mem_free(first.offset);
	mem_free(first.dirt);
	mem_free(second.offset);
	mem_free(second.dirt);
	mem_free(contacts);
	ground_finish(&alone);
	ground_finish(&together);
}

static void only_small_contacts_that_are_alike_are_batched(void **state)
{
	struct ground_params params = {.cells = 64, .tiles = 6, .spacing = 0.25, .model = DEFORM_BOX_FILTER, .batches = true};
	static const struct deform_shape hall = {.kind = DEFORM_BOX, .size = {80, 70, 1}};
	static const struct deform_shape lugged = {.kind = DEFORM_WHEEL, .radius = 0.5, .width = 0.4, .grousers = 9, .grouser_height = 0.06,
						   .grouser_thickness = 0.05};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &params);
	const struct {
		const struct deform_shape *shape;
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_batch_leaves_the_bits_of_contacts_that_are_alone),
		cmocka_unit_test(what_does_not_fit_a_batch_goes_into_the_next),
		cmocka_unit_test(only_small_contacts_that_are_alike_are_batched),
	};
	return cmocka_run_group_tests_name("batch", tests, open_gpu, close_gpu);
}
