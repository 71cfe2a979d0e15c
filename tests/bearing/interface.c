/* Friction and adhesion of an object's surface: they change forces where they are weaker than the soil, and nothing elsewhere. */
#include "ground.h"
#include "../support/program.h"

#define SPACING 0.0125

static const struct soil_shape block = {.kind = SOIL_BOX, .size = {1, 0.3, 0.5}};
static const struct soil_shape bodies[] = {
	{.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2},
	{.kind = SOIL_SPHERE, .radius = 0.3},
	{.kind = SOIL_BOX, .size = {0.5, 0.3, 0.4}},
};

static void init(struct ground *ground, const struct soil_numbers *soil, double slip_sinkage)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 3, .first = 1, .spacing = SPACING, .soils = soil,
						    .slip_sinkage = slip_sinkage, .bulldozing = slip_sinkage > 0 ? 0.5 : 0});
}

/*
 * A block is dragged lengthwise at a steady speed, so far that its shear is whole. A place of its track was first touched when the
 * block's front came there. So its shear is the mean of 1 - exp(-j / K) over its length.
 */
static void a_dragged_block_is_held_back_by_adhesion_and_friction(void **state)
{
	static const struct soil_interface surfaces[] = {
		{true, true, 15 * DEGREES, 500}, {true, true, 0, 800}, {.has_friction = true, .friction_angle = 20 * DEGREES},
		{.has_adhesion = true, .adhesion = 0}, {true, true, 60 * DEGREES, 1e5}, {.has_friction = false},
	};
	for (size_t i = 0; i < 3 * sizeof surfaces / sizeof *surfaces; i++) {
		static const char *const names[] = {"dry_sand", "lete_sand", "upland_loam_51"};
		static const double loads[] = {2000, 4000, 3000};
		const struct soil_numbers soil = bed_soil(names[i % 3]);
		const struct soil_interface *surface = &surfaces[i / 3];
		const double load = loads[i % 3], length = block.size[0], area = length * block.size[1], modulus = soil.janosi_shear;
		struct ground ground;
		struct deform_forces forces = {.z = 0};
		init(&ground, &soil, 0);
		struct deform_contact sweep = {.shape = &block, .interface = *surface, .load = load};
		for (int step = 0; step <= (int)(length / SPACING) + 20; step++) {
			struct soil_pose pose = ground_pose(&ground, 46.5 + step, 96.5, 0.25);
			sweep.from = step == 0 ? pose : sweep.to;
			sweep.to = pose;
			forces = ground_forces(&ground, &sweep);
		}
		ground_finish(&ground);
		double adhesion = surface->has_adhesion ? fmin(surface->adhesion, 1e4) : soil.cohesion; /* it is below 24 kPa, and below the pressure */
		double angle = surface->has_friction ? surface->friction_angle : soil.friction_angle;
		/* Where the surface's two lines and the soil's do not cross, one of them counts for every stress. */
		double strength = fmin(adhesion * area + load * tan(angle), soil.cohesion * area + load * tan(soil.friction_angle));
		double wanted = strength * (1 - modulus / length * (1 - exp(-length / modulus)));
		print_message("%s, %g Pa, %g degrees: drag %.2f N, wanted %.2f\n", names[i % 3], adhesion, angle / DEGREES, -forces.force[0], wanted);
		assert_true(fabs(forces.force[2] / load - 1) < 0.005);
		if (!(fabs(-forces.force[0] / wanted - 1) < 0.01))
			fail_msg("%s, surface %zu: %g N, wanted %g", names[i % 3], i / 3, -forces.force[0], wanted);
	}
}

struct left {
	struct deform_forces forces[8];
	int32_t *planes[PLANES];
};

static void drive(const struct soil_shape *shape, const struct soil_numbers *soil, const struct soil_interface *surface, struct left *out)
{
	struct ground ground;
	init(&ground, soil, 0.55);
	struct deform_contact sweep = {.shape = shape, .interface = *surface};
	for (int step = 0; step < 8; step++) {
		struct soil_pose pose = ground_pose(&ground, 90 + 1.3 * step, 95 + 0.4 * step, soil_shape_reach(shape, 0, 0) - 0.02);
		pose.yaw = 0.3;
		sweep.load = step % 4 == 3 ? 0 : 600; /* under its load; and at a height */
		sweep.from = step == 0 ? pose : sweep.to;
		sweep.to = pose;
		sweep.turned = step > 0 && shape->kind == SOIL_WHEEL ? 1.25 * 1.36 * SPACING / shape->radius : 0;
		out->forces[step] = ground_forces(&ground, &sweep);
	}
	for (int plane = 0; plane < PLANES; plane++)
		out->planes[plane] = deform_planes(DEFORM_SCM, false, DEFORM_DIGS) & PLANE_BIT(plane) ? ground_plane(&ground, plane) : NULL;
	ground_finish(&ground);
}

static void finish(struct left *left)
{
	for (int plane = 0; plane < PLANES; plane++)
		mem_free(left->planes[plane]);
}

/* Tells whether forces, and what is left of the ground, are the same to the bit. */
static bool is_same(const struct left *a, const struct left *b)
{
	bool same = memcmp(a->forces, b->forces, sizeof a->forces) == 0;
	for (int plane = 0; plane < PLANES; plane++)
		same = same && (a->planes[plane] == NULL || memcmp(a->planes[plane], b->planes[plane], 193 * 193 * sizeof(int32_t)) == 0);
	return same;
}

static void a_surface_no_weaker_than_the_soil_changes_no_bit(void **state)
{
	const struct soil_numbers soil = bed_soil("sandy_loam_15");
	const struct soil_interface none = {.has_friction = false};
	const struct {
		struct soil_interface surface;
		bool same;
	} rows[] = {
		{{true, true, soil.friction_angle, soil.cohesion}, true},
		{{true, true, 89 * DEGREES, 1e9}, true},
		{{.has_friction = true, .friction_angle = 60 * DEGREES}, true},
		{{.has_adhesion = true, .adhesion = 2 * soil.cohesion}, true},
		{{.has_friction = true, .friction_angle = 25 * DEGREES}, false},
		{{.has_adhesion = true, .adhesion = soil.cohesion / 2}, false},
	};
	for (size_t b = 0; b < sizeof bodies / sizeof *bodies; b++) {
		struct left plain, other;
		drive(&bodies[b], &soil, &none, &plain);
		for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
			drive(&bodies[b], &soil, &rows[i].surface, &other);
			if (is_same(&plain, &other) != rows[i].same)
				fail_msg("body %zu, surface %zu", b, i);
			finish(&other);
		}
		finish(&plain);
	}
}

static void the_shear_limit_is_the_weaker_line(void **state)
{
	const struct soil_numbers soil = {.cohesion = 1000, .friction_angle = M_PI / 4};
	assert_near(soil_shear_limit(&soil, &(struct soil_interface){.has_friction = false}, 2, 3000), 5000, 1e-9);
	assert_near(soil_shear_limit(&soil, &(struct soil_interface){.has_friction = true}, 2, 3000), 2000, 1e-9);
	assert_near(soil_shear_limit(&soil, &(struct soil_interface){.has_adhesion = true, .adhesion = 10}, 2, 3000), 3020, 1e-9);
	assert_near(soil_shear_limit(&soil, &(struct soil_interface){true, true, 0, 2600}, 2, 3000), 5000, 1e-9);
	assert_near(soil_shear_limit(&soil, &(struct soil_interface){true, true, 0, 2400}, 2, 3000), 4800, 1e-9);
}

/* Below a pressure as large as the cohesion a surface touches with a part of its area. */
static void what_is_barely_pressed_on_does_not_stick(void **state)
{
	const struct soil_interface none = {.has_friction = false}, sticky = {.has_adhesion = true, .adhesion = 1e6};
	const struct soil_numbers clay = {.cohesion = 68950, .friction_angle = 34 * DEGREES}, sand = {.friction_angle = 30 * DEGREES};
	assert_near(soil_shear_limit(&clay, &none, 0.01, 1), 1 * (40124.0 / 68950 + tan(34 * DEGREES)), 1e-4);
	assert_near(soil_shear_limit(&clay, &sticky, 0.01, 1), 1 + tan(34 * DEGREES), 1e-9);
	assert_near(soil_shear_limit(&clay, &none, 0.01, 0), 0, 0);
	assert_near(soil_shear_limit(&clay, &none, 0, 0), 0, 0);
	assert_near(soil_shear_limit(&sand, &none, 0.01, 1), tan(30 * DEGREES), 1e-9);
	for (double c = 100; c < 3e5; c *= 1.07)
		assert_near(soil_own_adhesion(c), reference_adhesion(c), 2e-4 * c);
}

TEST_PROGRAM(interface)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_dragged_block_is_held_back_by_adhesion_and_friction),
		cmocka_unit_test(a_surface_no_weaker_than_the_soil_changes_no_bit),
		cmocka_unit_test(the_shear_limit_is_the_weaker_line),
		cmocka_unit_test(what_is_barely_pressed_on_does_not_stick),
	};
	return cmocka_run_group_tests_name("bearing/interface", tests, NULL, NULL);
}
