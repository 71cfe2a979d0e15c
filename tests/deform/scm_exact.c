/* The soil contact model: no soil is lost, paging and places change no bit, and any soil gives finite numbers. */
#include "scm_rig.h"
#include "../support/program.h"

static int32_t rough(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	return (x * 5 + y * 3) % 211 == 0 ? BASE_NODATA : (int32_t)(h >> 19); /* 0 .. 0.03 m, and holes */
}

/* A random drive of a random object; deep and shallow, rates and none. */
static void drive_about(struct ground *ground, int sweeps)
{
	static const struct soil_shape shapes[] = {
		{.kind = SOIL_WHEEL, .radius = 0.8, .width = 0.5}, {.kind = SOIL_SPHERE, .radius = 0.6}, {.kind = SOIL_BOX, .size = {1, 0.6, 0.4}}};
	const struct soil_shape *shape = &shapes[any_word() % 3];
	double heading = any_share() * M_PI, reach = soil_shape_reach(shape, 0, 0);
	struct deform_contact sweep = ground_stand(ground, shape, 64 + 40 * any_share(), 64 + 40 * any_share(), reach - 0.1 + 0.15 * any_share());
	for (int i = 0; i < sweeps; i++) {
		ground_sweep(ground, &sweep);
		heading += 0.3 * any_share();
		double step = ground->params.spacing;
		sweep = move(&sweep, step * cos(heading), step * sin(heading), 0.02 * any_share());
		sweep.to.yaw = heading;
		sweep.seconds = any_word() % 2 ? 0.01 : 0;
		sweep.turned = step * (1 + any_share());
		sweep.load = any_word() % 4 == 0 ? exp2(10 + 6 * any_share()) : 0;
		sweep.tag = any_word() % 2;
		if (sweep.load > 0)
			sweep.from.z = sweep.to.z;
	}
	struct deform_forces forces;
	bool taken = true;
	assert_ok(deform_forces_begin(ground->deform));
	while (taken)
		assert_ok(deform_forces_take(ground->deform, true, &forces, &taken));
}

static void what_is_not_compacted_is_somewhere(void **state)
{
	struct soil_numbers soil = soft();
	(void)state;
	need_gpu();
	for (int round = 0; round < 4; round++) {
		struct ground ground;
		struct deform_tally tally;
		const double bulldozing[] = {0, 0.5, 1, 0.3};
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.125, .model = DEFORM_SCM, .height = rough,
							     .soils = &soil, .bulldozing = bulldozing[round]});
		for (int i = 0; i < 6; i++) {
			int64_t sum = 0, heaped = 0;
			drive_about(&ground, 25);
			assert_ok(deform_tally(ground.deform, &tally));
			int32_t *offsets = ground_plane(&ground, PLANE_OFFSET), *heaps = ground_plane(&ground, PLANE_DEPOSITED);
			int32_t *pressed = ground_plane(&ground, PLANE_PLASTIC_SINKAGE);
			for (int64_t k = 0; k < ground.posts * ground.posts; k++) {
				sum += offsets[k];
				heaped += heaps[k];
				assert_true(pressed[k] >= 0);
				assert_true(ground.base[k] != BASE_NODATA || (offsets[k] == 0 && heaps[k] == 0 && pressed[k] == 0));
			}
			assert_int_equal(sum + tally.compacted, 0);
			assert_true(tally.compacted != 0 && (heaped > 0) == (bulldozing[round] > 0));
			mem_free(offsets);
			mem_free(heaps);
			mem_free(pressed);
		}
		ground_finish(&ground);
	}
}

/* What of a slot leaves it and comes back. */
static void page_out_and_in(struct ground *ground)
{
	size_t posts = staged_posts(ground->params.cells);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		void *planes[PLANES] = {NULL};
		for (size_t i = 0; i < KEPT; i++)
			planes[kept[i]] = ground_room((int64_t)posts, 4);
		assert_ok(staged_read_planes(test_gpu, ground->slots, ground->params.cells, k, planes));
		gpu_slots_undeform(ground->slots, k);
		assert_ok(staged_upload_planes(test_gpu, ground->slots, ground->params.cells, k, (const void *const *)planes));
		for (size_t i = 0; i < KEPT; i++)
			mem_free(planes[kept[i]]);
	}
}

static void a_rut_that_was_paged_is_the_same_to_the_next_wheel(void **state)
{
	struct soil_numbers soil = soft();
	struct planes results[2];
	struct ground ground;
	(void)state;
	need_gpu();
	for (int paged = 0; paged < 2; paged++) {
		init(&ground, &soil, 0.0625, 0.5);
		test_seed = 17;
		for (int i = 0; i < 5; i++) {
			drive_about(&ground, 12);
			if (paged)
				page_out_and_in(&ground);
		}
		results[paged] = planes_of(&ground);
		if (paged == 0)
			ground_finish(&ground);
	}
	assert_same_and_free(&ground, &results[0], &results[1]);
	ground_finish(&ground);
}

static int32_t slope(int64_t x, int64_t y)
{
	return (int32_t)(x * 1500 + y * y * 11 + ((x * 7 + y * 13) % 17) * 90);
}

static int32_t raised(int64_t x, int64_t y)
{
	return slope(x, y) + (976 << BASE_BITS); /* 8,144 m */
}

static int32_t lowered(int64_t x, int64_t y)
{
	return slope(x, y) - (760 << BASE_BITS); /* 11,000 m down */
}

/* Law 9. */
static void height_and_distance_do_not_matter(void **state)
{
	static const struct {
		resident_ground_height height;
		int32_t reference;
		int64_t first;
		double z;
	} places[] = {{slope, 0, 2, 0}, {raised, 7168, 2, 8144}, {lowered, -10240, 2, -11000}, {slope, 0, 5000000, 0}};
	struct soil_numbers soil = soft();
	struct planes first = {{NULL}};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = places[i].first, .spacing = 0.03125,
							     .model = DEFORM_SCM, .soils = &soil, .bulldozing = 0.5,
							     .height = places[i].height, .reference = places[i].reference});
		struct deform_contact sweep = ground_stand(&ground, &wheel, 40, 64, places[i].z + 0.75);
		for (int k = 0; k < 30; k++) {
			ground_sweep(&ground, &sweep);
			sweep = move(&sweep, 0.03, 0.005, 0.0003);
			sweep.load = k % 2 ? 700 : 0;
			sweep.from.z = k % 2 ? sweep.to.z : sweep.from.z;
			sweep.seconds = 0.01;
			sweep.turned = 0.12;
		}
		struct planes planes = planes_of(&ground);
		assert_true(i > 0 || planes.all[2][64 * ground.posts + 50] != 0);
		if (i == 0)
			first = planes;
		for (size_t k = 0; k < KEPT; k++) {
			assert_memory_equal(first.all[k], planes.all[k], (size_t)(ground.posts * ground.posts) * 4);
			if (i > 0)
				mem_free(planes.all[k]);
		}
		ground_finish(&ground);
	}
	for (size_t k = 0; k < KEPT; k++)
		mem_free(first.all[k]);
}

/* Parameters at the ends of what a scene may say: everything stays a number, and in its range. */
static void no_soil_makes_anything_but_numbers(void **state)
{
	(void)state;
	need_gpu();
	for (int round = 0; round < 40; round++) {
		const struct soil_numbers low = {0, 1, 0.01, 0, 0, 1e-6, 1, 0, 1, 0, 0, 0, 0, 0, 0};
		const struct soil_numbers high = {1e12, 1e12, 3, 1e9, 89 * M_PI / 180, 100, 1e12, 1e9, 1e6, 1.5, 1.5, 1.5, 0.2, 1, 1.5};
		struct soil_numbers soil;
		struct ground ground;
		struct deform_tally tally;
		for (size_t k = 0; k < sizeof soil / sizeof(double); k++)
			((double *)&soil)[k] = any_word() % 2 ? ((const double *)&low)[k] : ((const double *)&high)[k];
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 1, .first = 2, .spacing = 0.125, .model = DEFORM_SCM, .height = rough,
							     .soils = &soil, .bulldozing = round % 2});
		struct deform_contact sweep = ground_stand(&ground, &wheel, 30, 32, 0.3 - 0.1);
		int64_t sum = 0;
		for (int k = 0; k < 6; k++) {
			sweep.load = k % 2 == 0 ? 0 : k == 1 ? 1 : 1e9;
			sweep.seconds = k % 3 == 0 ? 0 : 1e-9;
			sweep.turned = k % 3 == 1 ? 1e9 : 0.1;
			struct deform_forces forces = ground_forces(&ground, &sweep);
			for (int c = 0; c < 3; c++)
				assert_true(isfinite(forces.force[c]) && isfinite(forces.moment[c]) && fabs(forces.force[c]) < 1e12);
			assert_true(forces.force[2] >= 0 || soil.friction_angle > 0 || soil.cohesion > 0);
			assert_true(forces.sinkage >= 0 && forces.sinkage < 602);
			assert_true(llabs(forces.z - sweep.to.z) <= lattice_offset(604));
			sweep = move(&sweep, 0.1, 0.02, k == 3 ? -600 : 0);
			if (k % 2 == 0)
				sweep.from.z = sweep.to.z;
		}
		assert_ok(deform_tally(ground.deform, &tally));
		struct planes planes = planes_of(&ground);
		for (int64_t k = 0; k < ground.posts * ground.posts; k++) {
			sum += planes.all[0][k];
			assert_true(abs(planes.all[0][k]) <= 1 << 30 && planes.all[2][k] >= 0);
		}
		assert_int_equal(sum + tally.compacted, 0);
		for (size_t k = 0; k < KEPT; k++)
			mem_free(planes.all[k]);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(scm_exact)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_not_compacted_is_somewhere),
		cmocka_unit_test(a_rut_that_was_paged_is_the_same_to_the_next_wheel),
		cmocka_unit_test(height_and_distance_do_not_matter),
		cmocka_unit_test(no_soil_makes_anything_but_numbers),
	};
	return cmocka_run_group_tests_name("deform/scm_exact", tests, open_gpu, close_gpu);
}
