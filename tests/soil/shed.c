/* Sumner's rule on the CPU has the same bits as its passes on the GPU: what each post sheds, and the heights after an iteration. */
#include "../deform/slab.h"
#include "../long.h"
#include "../support/program.h"
#include "soil/kinematic/shed.h"

#define SIDE_POSTS (N + 2 * RIM)
#define ALL (SIDE_POSTS * SIDE_POSTS)

/* Steep ground with holes and posts that a body holds. */
static void any_slab(double steep)
{
	for (int i = 0; i < N * N; i++) {
		slab.base[i] = any_word() % 29 == 0 ? BASE_NODATA : (40 << 18) + (int32_t)(any_share() * steep * 0x1p18);
		slab.offset[i] = slab.base[i] == BASE_NODATA ? 0 : (int32_t)(any_share() * steep * 0x1p20);
		slab.deposit[i] = any_word() % 9 == 0 && slab.base[i] != BASE_NODATA ? (int32_t)(any_word() % 100000) : 0;
		slab.contacts[i] = (uint8_t)((any_word() % 11 == 0 ? HELD : 0) | (any_word() % 17 == 0));
		slab.classes[i] = (uint8_t)(any_word() % 23 == 0 ? any_word() % 256 : any_word() % 3);
	}
	for (int i = 0; i < 30; i++) /* equal neighbours, and cliffs */
		slab.offset[any_word() % (N * N)] = i % 3 == 0 ? 0 : (int32_t)(any_share() * 0x1p29);
	for (int i = 0; i < N * N; i++)
		slab.offset[i] = slab.base[i] == BASE_NODATA ? 0 : slab.offset[i];
}

struct field {
	int32_t heights[2][ALL], grounds[ALL], shed[ALL], of_gpu[ALL];
	uint8_t contacts[ALL], classes[ALL];
};
static struct field field;

static void read_field(const struct deform *deform)
{
	const struct gpu_rect all = rect_of(0, 0, SIDE_POSTS, SIDE_POSTS);
	for (int k = 0; k < 2; k++)
		gpu_texture_read(deform->heights[k], 0, all, field.heights[k]);
	gpu_texture_read(deform->bases, 0, all, field.grounds);
	gpu_texture_read(deform->contacts, 0, all, field.contacts);
	gpu_texture_read(deform->carried, 0, all, field.of_gpu);
	if (deform->classes != NULL)
		gpu_texture_read(deform->classes, 0, all, field.classes);
	for (int i = 0; i < ALL; i++)
		field.grounds[i] = (int32_t)((uint32_t)field.grounds[i] * 4);
}

/* What the written posts shed with these heights. The posts around are still, and shed nothing. */
static void shed(const struct soil_shed *rule, const int32_t *heights, bool classes)
{
	memset(field.shed, 0, sizeof field.shed);
	for (int y = RIM; y < RIM + N; y++) {
		struct soil_shed_rows rows = {.count = N, .classes = classes ? &field.classes[y * SIDE_POSTS + RIM] : NULL};
		for (int k = 0; k < 3; k++) {
			const int at = (y + k - 1) * SIDE_POSTS + RIM;
			rows.heights[k] = heights + at;
			rows.contacts[k] = field.contacts + at;
			rows.grounds[k] = rule->undisturbed_stable ? field.grounds + at : NULL;
		}
		soil_shed_row(rule, &rows, field.shed + y * SIDE_POSTS + RIM);
	}
}

/* Compares the heights after the first iteration with those of the CPU. Returns how many posts changed. */
static int take(void)
{
	int changed = 0;
	for (int y = RIM; y < RIM + N; y++) {
		int32_t change[N], other[N];
		uint8_t moves[N], of_blocks[N];
		const int32_t *sheds[3];
		for (int k = 0; k < 3; k++)
			sheds[k] = field.shed + (y + k - 1) * SIDE_POSTS + RIM;
		soil_shed_take_row(N, sheds, NULL, true, change, moves);
		soil_shed_take_row(N, sheds, NULL, false, other, of_blocks);
		for (int x = 0; x < N; x++) {
			const int at = y * SIDE_POSTS + RIM + x;
			const int32_t height = field.heights[0][at];
			assert_int_equal(field.heights[1][at], height == SHED_STILL ? height : (int32_t)((uint32_t)height + (uint32_t)change[x]));
			assert_int_equal(other[x], change[x]);
			assert_true(moves[x] >= of_blocks[x] && (change[x] == 0 || of_blocks[x]));
			changed += change[x] != 0;
		}
	}
	return changed;
}

static void it_is_that_of_the_gpu(void **state)
{
	struct soil_numbers soils[3];
	int changed = 0, shedding = 0;
	(void)state;
	need_gpu();
	assert_ok(soil_named("sand", &soils[0]));
	assert_ok(soil_named("mud", &soils[1]));
	assert_ok(soil_named("snow", &soils[2]));
	for (int round = 0; round < (long_run() ? 64 : 16); round++) {
		const int count = round % 2 ? 3 : 1;
		const double spacing = 0.05 * (1 + round % 5);
		struct ground ground;
		stands = round / 2 % 2;
		tolerance = round / 4 % 2 ? 0.01 : 0;
		start(&ground, DEFORM_SUMNER, spacing, 2, 0, soils, count);
		any_slab(spacing * (1 + round % 3));
		before = slab;
		slide_on_gpu(&ground);
		assert_true(sum_of(&slab) == sum_of(&before));
		read_field(ground.deform);
		struct soil_shed rule = {.undisturbed_stable = stands, .tolerance = (int32_t)floor(ldexp(tolerance, OFFSET_BITS))};
		for (int i = 0; i < count; i++)
			soil_shed_prepare(&soils[i], spacing, rule.tolerance, &rule.classes[i]);
		shed(&rule, field.heights[0], count > 1);
		changed += take();
		shed(&rule, field.heights[1], count > 1);
		for (int i = 0; i < N * N; i++) {
			const int at = (i / N + RIM) * SIDE_POSTS + i % N + RIM;
			assert_int_equal(field.shed[at], field.of_gpu[at]);
			shedding += field.shed[at] != 0;
		}
		ground_finish(&ground);
	}
	stands = false;
	tolerance = 0;
	assert_true(changed > 1000 && shedding > 1000);
}

TEST_PROGRAM(shed)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_is_that_of_the_gpu),
	};
	return cmocka_run_group_tests_name("soil/shed", tests, open_gpu, close_gpu);
}
