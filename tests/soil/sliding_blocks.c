/* Sliding over active blocks: intervals of the CPU and of the GPU leave the same bits and the same blocks active, in any order of regions. */
#include "blocks.h"
#include "../support/program.h"
#include "deform/schedule/active.h"
#include "soil/kinematic/kinematic.h"

static void upload_classes(struct ground *ground, struct field *field)
{
	const int64_t cells = ground->params.cells, side = cells + 1;
	struct gpu_staging *staging;
	assert_ok(gpu_staging_create(test_gpu, (size_t)(side * side), &staging));
	field->classes = ground_room(field->posts * field->posts, 1);
	for (int64_t i = 0; i < field->posts * field->posts; i++)
		field->classes[i] = (uint8_t)((i % field->posts / 9 + i / field->posts / 7) % ground->params.soil_count);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		uint8_t *bytes = gpu_staging_bytes(staging);
		for (int64_t i = 0; i < side * side; i++)
			bytes[i] = field->classes[(k / ground->params.tiles * cells + i / side) * field->posts + k % ground->params.tiles * cells + i % side];
		assert_ok(gpu_slots_upload_classes(ground->slots, k, staging, 0));
		gpu_finish(test_gpu);
	}
	gpu_staging_destroy(staging);
}

static void start(struct ground *ground, struct field *field, int round)
{
	static const double spacings[] = {0.25, 1.0 / 16, 1.0 / 64, 0.125};
	static const char *const sumner_names[] = {"sand", "mud", "snow"};
	struct soil_numbers soils[3];
	/* bounded: soil that was laid slides, down to a depth that is 0 when it is rounded. */
	const bool sumner = round % 10 >= 8, bounded = round % 3 == 2 && !sumner, cohesive = !bounded && round % 3 == 1, classes = round % 4 == 3;
	const double spacing = spacings[round / 2 % 4];
	for (int i = 0; i < 3; i++) {
		assert_ok(soil_named(sumner ? sumner_names[i] : i == 1 ? "lete_sand" : "dry_sand", &soils[i]));
		soils[i].theta_in *= i == 0 && round % 20 >= 10 ? 0.5 : 1;
		soils[i].cohesion *= cohesive ? spacing / 0.25 : 0;
		soils[i].friction_angle *= i == 2 ? 0.7 : 1;
		soils[i].repose *= i == 2 ? 0.7 : 1;
	}
	scale = spacing / 0.25;
	is_cliffed = round % 5 == 4;
	const bool stood = round % 5 >= 3;
	ground_init(ground, &(struct ground_params){.cells = round % 2 ? 32 : 64, .tiles = round % 2 ? 5 : 2, .spacing = spacing, .height = hills,
						    .model = sumner ? DEFORM_SUMNER : DEFORM_SLIPPAGE, .soils = soils, .soil_count = classes ? 3 : 1,
						    .iterations = round % 7 == 0 ? 1 : 1 + round % 8, .depth = sumner ? 0 : bounded ? 1e-9 : round % 4 == 2 ? 0.2 : 0,
						    .relief = is_cliffed || round % 3 == 0 ? 0 : 100, .tolerance = round % 6 == 5 ? 0.004 : 0, .stands = stood, .lines = true});
	*field = (struct field){.posts = ground->posts, .world = {0, 0, ground->posts, ground->posts}};
	field->base = ground_room(field->posts * field->posts, 4);
	field->offset = ground_room(field->posts * field->posts, 4);
	field->deposited = bounded ? ground_room(field->posts * field->posts, 4) : NULL;
	field->slope = cohesive ? ground_room(field->posts * field->posts, 4) : NULL;
	field->contact = ground_room(field->posts * field->posts, 1);
	memcpy(field->base, ground->base, (size_t)(field->posts * field->posts) * 4);
	if (classes)
		upload_classes(ground, field);
}

static void end(struct ground *ground, struct field *field)
{
	mem_free(field->base);
	mem_free(field->offset);
	mem_free(field->deposited);
	mem_free(field->slope);
	mem_free(field->classes);
	mem_free(field->contact);
	soil_block_set_finish(&field->active);
	ground_finish(ground);
}

/* The CPU's ground becomes what the GPU's is. */
static void take_over(struct ground *ground, struct field *field)
{
	const size_t bytes = (size_t)(field->posts * field->posts) * 4;
	int32_t *offset = ground_plane(ground, PLANE_OFFSET);
	memcpy(field->offset, offset, bytes);
	if (field->deposited != NULL)
		memcpy(field->deposited, offset, bytes);
	mem_free(offset);
}

static size_t slopes_kept; /* posts, over all intervals */

static void assert_same_ground(struct ground *ground, const struct field *field, int round, int n)
{
	int32_t *gpu = ground_plane(ground, PLANE_OFFSET);
	for (int plane = 0; plane < 2; plane++) {
		const int32_t *own = plane == 0 ? field->offset : field->deposited;
		for (int64_t i = 0; i < field->posts * field->posts && own != NULL; i++)
			if (own[i] != gpu[i])
				fail_msg("round %d, interval %d, plane %d, post %lld, %lld: %d, the GPU's is %d", round, n, plane,
					 (long long)(i % field->posts), (long long)(i / field->posts), own[i], gpu[i]);
	}
	mem_free(gpu);
	if (field->slope == NULL)
		return;
	gpu = ground_plane(ground, PLANE_SLOPE);
	for (int64_t i = 0; i < field->posts * field->posts; i++) {
		slopes_kept += gpu[i] != 0;
		if (field->slope[i] != gpu[i])
			fail_msg("round %d, interval %d, post %lld, %lld: slope %x, the GPU's is %x", round, n, (long long)(i % field->posts),
				 (long long)(i / field->posts), (unsigned)field->slope[i], (unsigned)gpu[i]);
	}
	mem_free(gpu);
}

static void assert_same_blocks(struct ground *ground, const struct field *field, int round, int n)
{
	const struct soil_block *blocks;
	size_t count;
	assert_ok(deform_active_wait(ground->deform));
	assert_ok(deform_active_blocks(ground->deform, &blocks, &count));
	if (count != field->active.count || (count > 0 && memcmp(blocks, field->active.blocks, count * sizeof *blocks) != 0))
		fail_msg("round %d, interval %d: %zu blocks are active, on the GPU %zu", round, n, field->active.count, count);
}

/* A box or a ball comes down. Then the same blocks are active. Returns how the object rests. */
static struct deform_contact disturb(struct ground *ground, struct field *field, const struct soil_shape *shape)
{
	const double at = (double)ground->posts * fabs(any_share()), beside = (double)ground->posts * fabs(any_share());
	const int64_t x = (int64_t)fmin(at, (double)ground->posts - 1), y = (int64_t)fmin(beside, (double)ground->posts - 1);
	int32_t base = ground->base[y * ground->posts + x];
	double height = ldexp(base != BASE_NODATA ? base : hills(x + 1, y + 3), -BASE_BITS);
	struct deform_contact contact = ground_stand(ground, shape, at, beside, height + soil_shape_reach(shape, 0, 0) - 0.5 * scale);
	contact.from.yaw = contact.to.yaw = 0.5;
	ground_sweep(ground, &contact);
	for (size_t i = 0; i < ground->window_count; i++) {
		assert_ok(deform_wake(ground->deform, ground->windows[i].write));
		assert_ok(soil_active_add_near(&field->active, field->world, soil_sliding_rim(&ground->deform->sliding), ground->windows[i].write));
	}
	soil_block_set_sort(&field->active);
	take_over(ground, field);
	return contact;
}

/* Marks what the body at rest holds, as the ground lies now: under Sumner's rule soil slides away below a body. */
static void hold(const struct ground *ground, struct field *field, const struct deform_rest *rest)
{
	const struct soil_kinematic kinematic = {.spacing = ground->params.spacing, .reference = ground->params.reference};
	const struct soil_kinematic_contact contact = {.shape = rest->shape};
	struct soil_planes planes = {.rect = field->world, .width = (size_t)field->posts, .base = field->base, .offset = field->offset, .contact = field->contact};
	void *scratch = ground_room((int64_t)soil_kinematic_room(&kinematic, &contact, planes.width, planes.width), 1);
	memset(field->contact, 0, (size_t)(field->posts * field->posts));
	soil_kinematic_hold(&kinematic, rest->shape, &rest->pose, &planes, scratch);
	mem_free(scratch);
}

static void an_interval_is_the_gpus_bit_for_bit(void **state)
{
	size_t visited = 0, rests = 0, moved = 0;
	(void)state;
	need_gpu();
	for (int round = 0; round < 60; round++) {
		struct ground ground;
		struct field field;
		start(&ground, &field, round);
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1.5 * scale}, box = {.kind = SOIL_BOX, .size = {4 * scale, 3 * scale, 9 * scale}};
		const struct soil_sliding *rule = &ground.deform->sliding;
		struct deform_rest rest = {.shape = &box};
		const bool rested = round % 2;
		for (int k = 0; k < 3; k++)
			disturb(&ground, &field, &ball);
		if (rested)
			rest.pose = disturb(&ground, &field, &box).to;
		for (int n = 0; n < 24 && field.active.count > 0; n++) {
			int32_t *before = ground_room(field.posts * field.posts, 4);
			memcpy(before, field.offset, (size_t)(field.posts * field.posts) * 4);
			assert_same_blocks(&ground, &field, round, n);
			visited += field.active.count;
			if (rested)
				hold(&ground, &field, &rest);
			ground_interval(&ground, &rest, rested);
			interval_on_cpu(rule, &field, (enum cut)(any_word() % CUTS));
			assert_same_ground(&ground, &field, round, n);
			assert_same_blocks(&ground, &field, round, n + 1);
			for (int64_t i = 0; i < field.posts * field.posts; i++)
				moved += before[i] != field.offset[i];
			mem_free(before);
		}
		rests += field.active.count == 0;
		end(&ground, &field);
	}
	assert_true(visited > 2000 && moved > 100000 && rests > 5 && slopes_kept > 10000);
}

TEST_PROGRAM(sliding_blocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_interval_is_the_gpus_bit_for_bit),
	};
	return cmocka_run_group_tests_name("soil/sliding_blocks", tests, open_gpu, close_gpu);
}
