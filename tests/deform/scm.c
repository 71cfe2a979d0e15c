/* The soil contact model: what plates, wheels and ruts do, against its formulas, and that nothing is lost of it. */
#include "ground.h"

static struct deform_soil named(const char *name)
{
	struct deform_soil soil;
	assert_ok(deform_soil_named(name, &soil));
	return soil;
}

/* Project Chrono's soft soil. */
static struct deform_soil soft(void)
{
	struct deform_soil soil = named("dry_sand");
	soil.bekker_kc = soil.cohesion = 0;
	soil.bekker_kphi = 0.2e6;
	soil.bekker_n = 1.1;
	soil.friction_angle = 30 * M_PI / 180;
	soil.janosi_shear = 0.01;
	soil.elastic_stiffness = 4e7;
	soil.damping = 3e4;
	return soil;
}

static const struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.4, 0.1, 0.5}};
static const struct deform_shape wheel = {.kind = DEFORM_WHEEL, .radius = 0.3, .width = 0.2};

static void init(struct ground *ground, const struct deform_soil *soil, double spacing, double bulldozing)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = spacing, .model = DEFORM_SCM,
						    .soils = soil, .bulldozing = bulldozing});
}

static struct deform_contact stand(const struct ground *ground, const struct deform_shape *shape, double x, double y, double z)
{
	struct deform_pose pose = ground_pose(ground, x, y, z);
	return (struct deform_contact){.shape = shape, .from = pose, .to = pose};
}

static struct deform_contact move(const struct deform_contact *before, double dx, double dy, double dz)
{
	struct deform_contact sweep = *before;
	sweep.from = before->to;
	sweep.to.x += lattice_offset(dx);
	sweep.to.y += lattice_offset(dy);
	sweep.to.z += lattice_offset(dz);
	return sweep;
}

/* soil-models.md 4.1. The rounding of the numbers there, in Pa, is what 5e-6 m of sinkage bear. */
static void plates_sink_as_bekker_says(void **state)
{
	static const struct {
		const char *soil;
		double sinkage; /* mm, under 20 kPa and 0.1 m wide */
	} plates[] = {{"dry_sand", 19.29}, {"sandy_loam_15", 1.97}, {"lete_sand", 0.69}, {"lunar", 23.98}, {"snow_us", 211.4}};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof plates / sizeof *plates; i++) {
		struct ground ground;
		struct deform_soil soil = named(plates[i].soil);
		init(&ground, &soil, 0.015625, 0);
		struct deform_contact sweep = stand(&ground, &plate, 64.3, 64.4, 0.25 - plates[i].sinkage / 1000);
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double pressure = forces.force[2] / forces.area, rounding = plates[i].sinkage > 100 ? 0.055 : 0.0055;
		assert_true(fabs(pressure / 20e3 - 1) < soil.bekker_n * rounding / plates[i].sinkage);
		double k = soil.bekker_kc / 0.1 + soil.bekker_kphi;
		assert_true(fabs(pressure / (k * pow(forces.sinkage, soil.bekker_n)) - 1) < 1e-5);
		assert_true(forces.force[0] == 0 && forces.force[1] == 0 && fabs(forces.moment[2]) == 0);
		ground_finish(&ground);
	}
}

/* The mean shear below the plate after a straight way of (x, y) metres: a place has slid since the plate came over it. */
static double mean_shear(const struct deform_soil *soil, double pressure, double x, double y)
{
	enum { PIECES = 400 };
	double sum = 0;
	for (int i = 0; i < PIECES; i++)
		for (int k = 0; k < PIECES; k++) {
			double share = fmin(1, fmin(plate.size[0] * (i + 0.5) / PIECES / x, plate.size[1] * (k + 0.5) / PIECES / y));
			sum += reference_janosi(soil, pressure, share * hypot(x, y));
		}
	return sum / PIECES / PIECES;
}

/* 4.2: of the whole way at once. What was below the plate from the start is sheared so far. The plate is 6.4 posts wide. */
static void plates_shear_as_janosi_says(void **state)
{
	struct deform_soil soil = named("dry_sand");
	struct ground ground;
	const struct {
		double way, tau, within; /* of the last, a post slides a K further than the one before it */
	} cases[] = {{0.025, 7380, 0.01}, {0.1, 11460, 0.005}, {0.9, 11674, 0.03}};
	(void)state;
	need_gpu();
	soil.janosi_shear = 0.025;
	init(&ground, &soil, 0.015625, 0);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		ground_reset(&ground);
		double x = cases[i].way * 0.8, y = cases[i].way * 0.6;
		struct deform_contact first = stand(&ground, &plate, 40, 64, 0.25 - 0.0192946), sweep = move(&first, x, y, 0);
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double wanted = mean_shear(&soil, 20e3, x, y);
		assert_true(fabs(forces.force[2] / forces.area - 20e3) < 2);
		assert_true(fabs(reference_janosi(&soil, 20e3, cases[i].way) - cases[i].tau) < 2);
		assert_true(wanted < cases[i].tau);
		print_message("%g m: %.1f and %.1f Pa, wanted %.1f\n", cases[i].way, -forces.force[0] / forces.area / 0.8, -forces.force[1] / forces.area / 0.6, wanted);
		assert_true(fabs(-forces.force[0] / forces.area / (0.8 * wanted) - 1) < cases[i].within);
		assert_true(fabs(-forces.force[1] / forces.area / (0.6 * wanted) - 1) < cases[i].within);
	}
	ground_finish(&ground);
}

/* R v more where it goes down, nothing where it comes up; without a time there is no rate. */
static void soil_that_is_pressed_fast_bears_more(void **state)
{
	struct deform_soil soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.015625, 0);
	const double seconds[] = {0, 0.1, 0.01};
	double still = 0;
	for (int i = 0; i < 3; i++) {
		ground_reset(&ground);
		struct deform_contact first = stand(&ground, &plate, 64, 64, 0.25 - 0.04), sweep = move(&first, 0, 0, -0.01);
		sweep.seconds = seconds[i];
		struct deform_forces forces = ground_forces(&ground, &sweep);
		double pressure = forces.force[2] / forces.area, rate = i > 0 ? 0.01 / seconds[i] : 0;
		still = i == 0 ? pressure : still;
		assert_true(fabs(pressure - still - soil.damping * rate) < 0.5 + 1e-4 * soil.damping * rate); /* places are whole quanta */
	}
	ground_finish(&ground);
}

static int32_t at_centre(struct ground *ground, enum plane plane)
{
	int32_t *all = ground_plane(ground, plane), value = all[64 * ground->posts + 64];
	mem_free(all);
	return value;
}

/* 4.3: it rebounds by 0.5 mm, and bears the same again without sinking deeper. */
static void a_load_rebounds_and_presses_no_deeper_again(void **state)
{
	struct deform_soil soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.015625, 0);
	struct deform_contact first = stand(&ground, &plate, 64, 64, 0.25);
	first.load = 1;
	struct deform_forces forces = ground_forces(&ground, &first);
	ground_reset(&ground);
	first.load = 20e3 * forces.area;
	forces = ground_forces(&ground, &first);
	assert_true(fabs(forces.sinkage - 0.12328) < 6e-6);
	struct deform_contact lift = stand(&ground, &plate, 64, 64, 0.25 - forces.sinkage);
	lift.to.z = lattice_offset(1);
	ground_sweep(&ground, &lift);
	int32_t rut = at_centre(&ground, PLANE_OFFSET), pressed = at_centre(&ground, PLANE_PLASTIC_SINKAGE);
	assert_true(fabs(lattice_offset_metres(rut) + forces.sinkage - 0.0005) < 2e-6);
	for (int i = 0; i < 3; i++) {
		struct deform_forces again = ground_forces(&ground, &first);
		assert_true(fabs(again.sinkage - forces.sinkage) <= 0x1p-20);
		assert_true(abs(at_centre(&ground, PLANE_OFFSET) + (int32_t)lattice_offset(forces.sinkage)) <= 1);
		lift.from.z = again.z;
		ground_sweep(&ground, &lift);
		assert_true(abs(at_centre(&ground, PLANE_OFFSET) - rut) <= 1);
		assert_true(abs(at_centre(&ground, PLANE_PLASTIC_SINKAGE) - pressed) <= 1);
	}
	ground_finish(&ground);
}

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
	static const struct deform_shape shapes[] = {
		{.kind = DEFORM_WHEEL, .radius = 0.8, .width = 0.5}, {.kind = DEFORM_SPHERE, .radius = 0.6}, {.kind = DEFORM_BOX, .size = {1, 0.6, 0.4}}};
	const struct deform_shape *shape = &shapes[any_word() % 3];
	double heading = any_share() * M_PI, reach = deform_shape_reach(shape, 0, 0);
	struct deform_contact sweep = stand(ground, shape, 64 + 40 * any_share(), 64 + 40 * any_share(), reach - 0.1 + 0.15 * any_share());
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
	struct deform_soil soil = soft();
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

struct planes {
	int32_t *all[PLANES];
};

static const enum plane kept[] = {PLANE_OFFSET, PLANE_DEPOSITED, PLANE_PLASTIC_SINKAGE, PLANE_SHEAR};
#define KEPT (sizeof kept / sizeof *kept)

static struct planes planes_of(struct ground *ground)
{
	struct planes planes;
	for (size_t i = 0; i < KEPT; i++)
		planes.all[i] = ground_plane(ground, kept[i]);
	return planes;
}

static void assert_same_and_free(const struct ground *ground, struct planes *a, struct planes *b)
{
	for (size_t i = 0; i < KEPT; i++) {
		assert_memory_equal(a->all[i], b->all[i], (size_t)(ground->posts * ground->posts) * 4);
		mem_free(a->all[i]);
		mem_free(b->all[i]);
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
	struct deform_soil soil = soft();
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

static void roll(struct ground *ground, const struct deform_contact *start, int sweeps, struct deform_forces *last)
{
	struct deform_contact sweep = *start;
	ground_sweep(ground, &sweep);
	for (int i = 0; i < sweeps; i++) {
		sweep = move(&sweep, ground->params.spacing, 0, 0);
		if (i + 1 < sweeps || last == NULL)
			ground_sweep(ground, &sweep);
		else
			*last = ground_forces(ground, &sweep);
	}
}

static void a_second_pass_sinks_no_deeper(void **state)
{
	struct deform_soil soil = soft();
	struct ground ground;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.03125, 0);
	struct deform_contact start = stand(&ground, &wheel, 40, 64, 0.3 - 0.05);
	roll(&ground, &start, 40, NULL);
	struct planes first = planes_of(&ground);
	roll(&ground, &start, 40, NULL);
	struct planes second = planes_of(&ground);
	for (int i = 0; i < 3; i++)
		assert_memory_equal(first.all[i], second.all[i], (size_t)(ground.posts * ground.posts) * 4);
	/* The rut's bottom alone is in contact now, so it is sheared less. Of a pass over another in that rut nothing is left. */
	assert_memory_not_equal(first.all[3], second.all[3], (size_t)(ground.posts * ground.posts) * 4);
	for (size_t i = 0; i < KEPT; i++)
		mem_free(first.all[i]);
	roll(&ground, &start, 40, NULL);
	struct planes third = planes_of(&ground);
	assert_same_and_free(&ground, &second, &third);
	ground_finish(&ground);
}

static void left_and_right_are_the_same(void **state)
{
	struct deform_soil soil = soft();
	struct deform_forces forces;
	struct ground ground;
	(void)state;
	need_gpu();
	/* What is carried away leaves its remainder to the south first. */
	init(&ground, &soil, 0.03125, 0);
	struct deform_contact start = stand(&ground, &wheel, 40, 64, 0.3 - 0.06);
	start.seconds = 0.01;
	start.turned = 0.03125 / 0.3 / 0.8;
	roll(&ground, &start, 30, &forces);
	struct planes planes = planes_of(&ground);
	for (size_t i = 0; i < KEPT; i++) {
		for (int64_t y = 1; y <= 64; y++)
			assert_memory_equal(planes.all[i] + (64 - y) * ground.posts, planes.all[i] + (64 + y) * ground.posts,
					    (size_t)ground.posts * 4);
		mem_free(planes.all[i]);
	}
	assert_true(forces.force[0] != 0 && forces.force[2] > 0);
	/* Rounded post by post. */
	assert_true(fabs(forces.force[1]) < 1e-2 && fabs(forces.moment[0]) < 1e-2 && fabs(forces.moment[2]) < 1e-2);
	ground_finish(&ground);
}

static void a_wheel_that_slips_more_pulls_more(void **state)
{
	struct deform_soil soil = named("dry_sand");
	struct ground ground;
	double before = -INFINITY;
	(void)state;
	need_gpu();
	init(&ground, &soil, 0.03125, 0);
	for (int i = -2; i < 9; i++) {
		struct deform_forces forces;
		ground_reset(&ground);
		struct deform_contact start = stand(&ground, &wheel, 40, 64, 0.3 - 0.03);
		start.turned = 0.03125 / (0.3 * (1 - i * 0.1));
		roll(&ground, &start, 30, &forces);
		assert_true(forces.force[0] > before);
		before = forces.force[0];
		assert_true(i < 2 || forces.force[0] > 0);
		assert_true(i > -1 || forces.force[0] < 0);
	}
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
	struct deform_soil soil = soft();
	struct planes first = {{NULL}};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = places[i].first, .spacing = 0.03125,
							     .model = DEFORM_SCM, .soils = &soil, .bulldozing = 0.5,
							     .height = places[i].height, .reference = places[i].reference});
		struct deform_contact sweep = stand(&ground, &wheel, 40, 64, places[i].z + 0.75);
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
		const struct deform_soil low = {0, 1, 0.01, 0, 0, 1e-6, 1, 0, 1, 0, 0, 0, 0, 0, 0};
		const struct deform_soil high = {1e12, 1e12, 3, 1e9, 89 * M_PI / 180, 100, 1e12, 1e9, 1e6, 1.5, 1.5, 1.5, 0.2, 1, 1.5};
		struct deform_soil soil;
		struct ground ground;
		struct deform_tally tally;
		for (size_t k = 0; k < sizeof soil / sizeof(double); k++)
			((double *)&soil)[k] = any_word() % 2 ? ((const double *)&low)[k] : ((const double *)&high)[k];
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 1, .first = 2, .spacing = 0.125, .model = DEFORM_SCM, .height = rough,
							     .soils = &soil, .bulldozing = round % 2});
		struct deform_contact sweep = stand(&ground, &wheel, 30, 32, 0.3 - 0.1);
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_sink_as_bekker_says),
		cmocka_unit_test(plates_shear_as_janosi_says),
		cmocka_unit_test(soil_that_is_pressed_fast_bears_more),
		cmocka_unit_test(a_load_rebounds_and_presses_no_deeper_again),
		cmocka_unit_test(what_is_not_compacted_is_somewhere),
		cmocka_unit_test(a_rut_that_was_paged_is_the_same_to_the_next_wheel),
		cmocka_unit_test(a_second_pass_sinks_no_deeper),
		cmocka_unit_test(left_and_right_are_the_same),
		cmocka_unit_test(a_wheel_that_slips_more_pulls_more),
		cmocka_unit_test(height_and_distance_do_not_matter),
		cmocka_unit_test(no_soil_makes_anything_but_numbers),
	};
	return cmocka_run_group_tests_name("deform/scm", tests, open_gpu, close_gpu);
}
