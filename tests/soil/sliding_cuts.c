/* Sliding over active blocks on the CPU alone: any cut of the blocks into regions gives the same, no soil is lost, and the potential energy falls. */
#include "blocks.h"
#include "../support/program.h"
#include "soil/stability.h"

enum { SIDE_POSTS = 150 };

static int32_t repose(const struct soil_numbers *numbers, double apart)
{
	return soil_critical_difference(numbers->repose, apart);
}

/* Hills with a steep bank and heaps. All blocks are active. */
static void make_field(struct field *field, int round)
{
	const int64_t count = SIDE_POSTS * SIDE_POSTS;
	*field = (struct field){.posts = SIDE_POSTS, .world = {0, 0, SIDE_POSTS, SIDE_POSTS}};
	field->base = ground_room(count, 4);
	field->offset = ground_room(count, 4);
	field->deposited = round % 2 ? ground_room(count, 4) : NULL;
	field->slope = ground_room(count, 4);
	field->contact = ground_room(count, 1);
	for (int64_t i = 0; i < count; i++) {
		const int64_t x = i % SIDE_POSTS, y = i / SIDE_POSTS;
		bool heap = (x * x + y * (y + round)) % 31 < 3;
		field->base[i] = hills(x, y);
		field->offset[i] = heap && field->base[i] != BASE_NODATA ? (int32_t)(any_word() % (1u << 20)) : 0;
		field->contact[i] = any_word() % 200 == 0 ? SOIL_HELD : 0;
		if (field->deposited != NULL)
			field->deposited[i] = field->offset[i];
	}
	assert_ok(soil_active_add_near(&field->active, field->world, 0, field->world));
}

static struct field twin_of(const struct field *field)
{
	struct field twin = *field;
	const size_t bytes = (size_t)(field->posts * field->posts) * 4;
	twin.base = ground_room((int64_t)bytes, 1);
	twin.offset = ground_room((int64_t)bytes, 1);
	twin.deposited = field->deposited != NULL ? ground_room((int64_t)bytes, 1) : NULL;
	twin.slope = ground_room((int64_t)bytes, 1);
	twin.contact = ground_room((int64_t)bytes / 4, 1);
	memcpy(twin.base, field->base, bytes);
	memcpy(twin.offset, field->offset, bytes);
	memcpy(twin.contact, field->contact, bytes / 4);
	if (twin.deposited != NULL)
		memcpy(twin.deposited, field->deposited, bytes);
	twin.active = (struct soil_block_set){.count = 0};
	assert_ok(soil_active_add_near(&twin.active, twin.world, 0, twin.world));
	return twin;
}

static void drop(struct field *field)
{
	mem_free(field->base);
	mem_free(field->offset);
	mem_free(field->deposited);
	mem_free(field->slope);
	mem_free(field->contact);
	soil_block_set_finish(&field->active);
}

/* Returns the sum of offsets. *energy: the sum of squared heights, which falls as the potential energy does. */
static int64_t sums_of(const struct field *field, long double *energy)
{
	int64_t sum = 0;
	*energy = 0;
	for (int64_t i = 0; i < field->posts * field->posts; i++) {
		const long double height = 4.0L * field->base[i] + field->offset[i];
		sum += field->offset[i];
		*energy += field->base[i] != BASE_NODATA ? height * height : 0;
	}
	return sum;
}

static void any_cut_is_the_same_and_loses_no_soil(void **state)
{
	size_t rests = 0;
	(void)state;
	for (int round = 0; round < 12; round++) {
		struct soil_numbers soil;
		struct soil_sliding rule;
		struct field fields[CUTS];
		scale = 1;
		is_cliffed = false;
		assert_ok(soil_named("dry_sand", &soil));
		soil_sliding_prepare(&(struct soil_sliding_params){
			.soils = &soil, .soil_count = 1, .spacing = 0.25, .critical = round % 3 ? soil_critical_difference_cohesive : repose,
			.cotangent = round % 3 ? soil_critical_cotangent : NULL, .iterations = 1 + round % 4, .depth = round % 2 ? 0 : (double)INFINITY, .relief = 100,
			.undisturbed_stable = round % 4 > 1}, &rule);
		make_field(&fields[0], round);
		for (int cut = 1; cut < CUTS; cut++)
			fields[cut] = twin_of(&fields[0]);
		long double energy, before;
		const int64_t sum = sums_of(&fields[0], &before);
		for (int n = 0; n < 20 && fields[0].active.count > 0; n++) {
			for (int cut = 0; cut < CUTS; cut++)
				interval_on_cpu(&rule, &fields[cut], (enum cut)cut);
			for (int cut = 1; cut < CUTS; cut++) {
				assert_memory_equal(fields[0].offset, fields[cut].offset, (size_t)(SIDE_POSTS * SIDE_POSTS) * 4);
				assert_memory_equal(fields[0].slope, fields[cut].slope, (size_t)(SIDE_POSTS * SIDE_POSTS) * 4);
				assert_int_equal(fields[0].active.count, fields[cut].active.count);
				assert_memory_equal(fields[0].active.blocks, fields[cut].active.blocks, fields[0].active.count * sizeof(struct soil_block));
			}
			assert_int_equal(sums_of(&fields[0], &energy), sum);
			assert_true(energy <= before);
			before = energy;
		}
		rests += fields[0].active.count < 25;
		for (int cut = 0; cut < CUTS; cut++)
			drop(&fields[cut]);
	}
	assert_true(rests > 2);
}

TEST_PROGRAM(sliding_cuts)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(any_cut_is_the_same_and_loses_no_soil),
	};
	return cmocka_run_group_tests_name("soil/sliding_cuts", tests, NULL, NULL);
}
