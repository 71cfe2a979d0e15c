/* Where carried soil goes: to free posts of the bands beside the patch alone, every quantum of it, wherever the window lies. */
#include "ground.h"
#include "../support/program.h"

#define N 40 /* posts a side of what is written */
#define AT 3 /* the first of them, in a window that is read farther */
#define NEAR 16 /* a bit of contacts: the object was near; such a post is free */
#define MIDDLE 300 /* post of the world that the middle of what is written is */

struct field {
	int32_t carried[N * N], deposits[N * N], offsets[N * N];
	uint8_t contacts[N * N], classes[N * N];
	int64_t compacted, confined, refused;
};
static struct field field, again;

static bool is_free(const struct field *of, int i)
{
	return of->contacts[i] % NEAR == 0;
}

static int64_t sum(const int32_t *amounts)
{
	int64_t all = 0;
	for (int i = 0; i < N * N; i++)
		all += amounts[i];
	return all;
}

/* The window begins `at` posts before what is written. */
static void spread_on_gpu(struct ground *ground, const struct deform_contact *sweep, struct field *of, uint32_t at)
{
	struct deform *deform = ground->deform;
	struct deform_tally before, after;
	struct gpu_rect rect = rect_of(at, at, N, N), around = rect_of(0, 0, N + 2 * at, N + 2 * at);
	int64_t first = MIDDLE - N / 2;
	struct deform_window window = {.write = {first, first, first + N, first + N}};
	window.read = (struct post_rect){first - at, first - at, first + N + at, first + N + at};
	/* Around it all is free, and carries: another window's. */
	gpu_texture_clear(deform->contacts, 0, around, 0);
	gpu_texture_clear(deform->carried, 0, around, 1000);
	gpu_texture_clear(deform->deposits, 0, around, -7);
	gpu_texture_upload(deform->contacts, 0, rect, of->contacts);
	gpu_texture_upload(deform->carried, 0, rect, of->carried);
	gpu_texture_upload(deform->planes_of[1][PLANE_OFFSET], 0, rect, of->offsets);
	if (deform->classes != NULL)
		gpu_texture_upload(deform->classes, 0, rect, of->classes);
	assert_ok(deform_tally(deform, &before));
	const struct spread_params params = deform_spread_params(deform, sweep, &window, 0);
	assert_ok(deform_spread(deform, sweep, &params, &window, 0));
	gpu_texture_read(deform->deposits, 0, rect, of->deposits);
	assert_ok(deform_tally(deform, &after));
	of->compacted = after.compacted - before.compacted;
	of->confined = (int64_t)(after.confined - before.confined);
	of->refused = (int64_t)(after.refused - before.refused);
}

static void open_ground(struct ground *ground)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 10, .spacing = 0.125, .model = DEFORM_SLIPPAGE});
}

static struct deform_contact any_sweep(const struct ground *ground, const struct soil_shape *shape)
{
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(ground, MIDDLE + any_share(), MIDDLE + any_share(), 0)};
	sweep.to = ground_pose(ground, MIDDLE + any_share(), MIDDLE + any_share(), 0);
	sweep.to.yaw = 4 * any_share();
	sweep.turned = 0.125 * any_share() / shape->radius;
	if (any_word() % 3 == 0)
		sweep.from = sweep.to;
	return sweep;
}

static void every_quantum_goes_where_it_may(void **state)
{
	struct ground ground;
	int64_t confined = 0, laid = 0;
	(void)state;
	need_gpu();
	open_ground(&ground);
	for (int round = 0; round < 90; round++) {
		const struct soil_shape shapes[] = {{.kind = SOIL_WHEEL, .radius = 1.2 + fabs(any_share()), .width = 2.4},
						    {.kind = SOIL_SPHERE, .radius = 1.2},
						    {.kind = SOIL_BOX, .radius = 1, .size = {2.2, 2.4, 0.7}}};
		struct deform_contact sweep = any_sweep(&ground, &shapes[round % 3]);
		/* From few free posts to many; holes; up to what a press may carry. */
		uint32_t blocked = (uint32_t)(round / 3) * 4294967295u / 30;
		memset(&field, 0, sizeof field);
		for (int i = 0; i < N * N; i++) {
			bool under = abs(i % N - N / 2) < 6 && abs(i / N - N / 2) < 5, hole = any_word() % 16 == 0;
			field.contacts[i] = hole ? 2 : under ? 1 + any_word() % 3 : round % 10 == 9 || any_word() < blocked ? 2 : any_word() % 2 * NEAR;
			field.carried[i] = field.contacts[i] % 2 == 0 ? 0
					   : round % 5 == 0 ? 1 << 23 : (int32_t)(any_word() % (1u << (round % 24)));
			field.offsets[i] = -(int32_t)(any_word() % (1u << (round % 24)));
		}
		again = field;
		spread_on_gpu(&ground, &sweep, &field, 0);
		for (int i = 0; i < N * N; i++)
			assert_true(is_free(&field, i) ? field.deposits[i] >= 0 : field.deposits[i] == 0);
		assert_true(field.confined == 0 || (sum(field.deposits) == 0 && field.compacted == sum(field.carried)));
		assert_true(sum(field.deposits) + field.compacted == sum(field.carried));
		/* The window's own place does not matter. */
		spread_on_gpu(&ground, &sweep, &again, AT);
		assert_memory_equal(field.deposits, again.deposits, sizeof field.deposits);
		assert_true(field.compacted == again.compacted && field.confined == again.confined);
		confined += field.confined;
		laid += sum(field.deposits) > 0;
	}
	assert_true(confined > 100 && laid > 40);
	ground_finish(&ground);
}

/* A post that would get more than 512 m gets less; what it does not get is compacted, and told. */
static void a_post_gets_no_more_than_it_can_hold(void **state)
{
	struct ground ground;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1};
	(void)state;
	need_gpu();
	open_ground(&ground);
	struct deform_contact sweep = {.shape = &ball, .from = ground_pose(&ground, MIDDLE, MIDDLE, 0)};
	sweep.to = sweep.from;
	for (int free = 1; free < 30; free += 28) {
		memset(&field, 0, sizeof field);
		for (int i = 0; i < N * N; i++) {
			bool under = abs(i % N - N / 2) < 5 && abs(i / N - N / 2) < 5;
			field.contacts[i] = under ? 1 : abs(i % N - N / 2) < free && i / N == N / 2 + 6 ? NEAR : 2;
			field.carried[i] = under ? 1 << 23 : 0;
		}
		spread_on_gpu(&ground, &sweep, &field, AT);
		assert_true(sum(field.deposits) + field.compacted == sum(field.carried));
		assert_true((field.refused == 1) == (free == 1) && (field.compacted == 0) == (free > 1));
		for (int i = 0; i < N * N; i++)
			assert_true(field.deposits[i] <= 1 << 29);
	}
	ground_finish(&ground);
}

/* --- maps of soils --- */

/* Returns a soil that is laid at this angle, degrees, under each model; sumner compacts a part of it. */
static struct soil_numbers laid_at(double degrees, double compression)
{
	struct soil_numbers soil;
	assert_ok(soil_named("dry_sand", &soil));
	soil.cohesion = 0;
	soil.friction_angle = soil.repose = soil.theta_in = soil.theta_out = soil.theta_stop = degrees * M_PI / 180;
	soil.compression = compression;
	return soil;
}

/* A ball that is set down in a hollow, all of whose posts have this class. Around it lies `around`, and `one` at one post in it. */
static void press(enum deform_model model, const struct soil_numbers *soils, int count, uint8_t class, uint8_t around, uint8_t one)
{
	struct ground ground;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1.5};
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 10, .spacing = 0.125, .model = model, .soils = soils,
						     .soil_count = count});
	const struct deform_contact sweep = ground_stand(&ground, &ball, MIDDLE, MIDDLE, 0);
	memset(&field, 0, sizeof field);
	for (int i = 0; i < N * N; i++) {
		bool under = abs(i % N - N / 2) < 5 && abs(i / N - N / 2) < 5;
		field.contacts[i] = under;
		field.carried[i] = under ? 1 << 16 : 0;
		field.offsets[i] = under ? -(1 << 18) : 0;
		field.classes[i] = !under ? around : i == N / 2 * N + N / 2 ? one : class;
	}
	spread_on_gpu(&ground, &sweep, &field, 0);
	assert_true(sum(field.deposits) == sum(field.carried));
	ground_finish(&ground);
}

static int posts_laid_on(void)
{
	int posts = 0;
	for (int i = 0; i < N * N; i++)
		posts += field.deposits[i] > 0;
	return posts;
}

static void only_soils_that_are_carried_set_the_width_of_bands(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	const struct soil_numbers steep = laid_at(40, 0.5), flat = laid_at(12, 0.1);
	const struct soil_numbers map[] = {flat, steep, laid_at(6, 0), flat};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		press(models[m], &steep, 1, 0, 0, 0);
		again = field;
		int few = posts_laid_on();
		for (uint8_t around = 0; around < 4; around++) {
			press(models[m], map, 4, 1, around, 1);
			assert_memory_equal(field.deposits, again.deposits, sizeof field.deposits);
		}
		press(models[m], &flat, 1, 0, 0, 0);
		again = field;
		assert_true(posts_laid_on() > few + 40);
		press(models[m], map, 4, 0, 1, 0);
		assert_memory_equal(field.deposits, again.deposits, sizeof field.deposits);
		/* Of two soils that are carried, the less steep one counts, however little of it there is. */
		press(models[m], map, 4, 1, 1, 0);
		assert_true(posts_laid_on() > few + 20);
		press(models[m], map, 4, 0, 1, 1);
		assert_memory_equal(field.deposits, again.deposits, sizeof field.deposits);
	}
}

/* Whole contacts. */
static void a_contact_on_one_soil_is_that_of_a_ground_of_this_soil(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	const struct soil_numbers steep = laid_at(40, 0.5), flat = laid_at(12, 0.1);
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1.5};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		int32_t *offsets[3];
		size_t bytes = 0;
		for (int k = 0; k < 3; k++) {
			/* No map was loaded, so all posts have the first class. */
			const struct soil_numbers map[] = {k < 2 ? steep : flat, flat};
			struct ground ground;
			ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 1, .spacing = 0.125, .model = models[m], .soils = map,
								     .soil_count = k == 1 ? 2 : 1});
			const struct deform_contact sweep = ground_stand(&ground, &ball, 32.3, 31.8, 1.2);
			offsets[k] = ground_swept(&ground, &sweep);
			bytes = (size_t)(ground.posts * ground.posts) * sizeof *offsets[k];
			ground_finish(&ground);
		}
		assert_memory_equal(offsets[0], offsets[1], bytes);
		assert_true(memcmp(offsets[0], offsets[2], bytes) != 0);
		for (int k = 0; k < 3; k++)
			mem_free(offsets[k]);
	}
}

TEST_PROGRAM(spread)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_goes_where_it_may),
		cmocka_unit_test(a_post_gets_no_more_than_it_can_hold),
		cmocka_unit_test(only_soils_that_are_carried_set_the_width_of_bands),
		cmocka_unit_test(a_contact_on_one_soil_is_that_of_a_ground_of_this_soil),
	};
	return cmocka_run_group_tests_name("deform/spread", tests, open_gpu, close_gpu);
}
