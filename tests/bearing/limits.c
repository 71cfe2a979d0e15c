/*
 * Soils, bodies and motions at the ends of what a scene may say (scene_schema.c's limits): what comes of them is numbers, whole ones within their
 * ranges, and no soil is lost.
 */
#include <float.h>

#include "ground.h"

#include "../support/program.h"

enum { CELLS = 32, TILES = 3, POSTS = CELLS * TILES + 1 };

#define MOST (1 << 30) /* beyond this no offset goes, fixed-point units */

static const struct range {
	double low, high; /* a low of 0 is not reached: the least number that there is */
	bool from_zero;   /* it is */
	size_t at;
} ranges[] = {
	{-1e12, 1e12, false, offsetof(struct soil_numbers, bekker_kc)},
	{0, 1e12, true, offsetof(struct soil_numbers, bekker_kphi)},
	{0, 3, false, offsetof(struct soil_numbers, bekker_n)},
	{0, 1e9, true, offsetof(struct soil_numbers, cohesion)},
	{0, 89 * DEGREES, true, offsetof(struct soil_numbers, friction_angle)},
	{0, 10, false, offsetof(struct soil_numbers, janosi_shear)},
	{0, 1e12, false, offsetof(struct soil_numbers, elastic_stiffness)},
	{0, 1e12, true, offsetof(struct soil_numbers, damping)},
	{0, 1e6, false, offsetof(struct soil_numbers, unit_weight)},
	{0, 89 * DEGREES, false, offsetof(struct soil_numbers, repose)},
};

static double any_of(double low, double high, bool from_zero)
{
	switch (any_word() % 4) {
	case 0:
		return low == 0 && !from_zero ? DBL_MIN : low;
	case 1:
		return high;
	case 2: /* of any size */
		return high * exp2(-60 * fabs(any_share()));
	default:
		return low + (high - low) * fabs(any_share());
	}
}

/* As a scene may have it under a body whose b is `width`. */
static struct soil_numbers any_soil(double width)
{
	struct soil_numbers soil;
	soil_clear(&soil);
	for (size_t i = 0; i < COUNT(ranges); i++)
		*(double *)((char *)&soil + ranges[i].at) = any_of(ranges[i].low, ranges[i].high, ranges[i].from_zero);
	if (!(soil.bekker_kc / width + soil.bekker_kphi > 0))
		soil.bekker_kc = fabs(soil.bekker_kc) + 1;
	return soil;
}

static int32_t rough(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h ^= h >> 15;
	h *= 2654435761u;
	const bool cliff = x > 60 && y > 40;
	return h % 97 == 0 ? BASE_NODATA : (int32_t)(h >> 16) + (cliff ? 300 << BASE_BITS : 0);
}

static struct deform_contact any_contact(const struct ground *ground, const struct soil_shape *shape)
{
	const double spacing = ground->params.spacing, x = 48 + 40 * any_share(), y = 48 + 40 * any_share();
	const double height = any_word() % 8 == 0 ? 600 * any_share() : x > 60 && y > 40 ? 300 : 0;
	const double z = height + soil_shape_reach(shape, 0, 0) - 4 * spacing * any_share();
	struct deform_contact contact = {.shape = shape};
	contact.from = ground_pose(ground, x, y, z);
	contact.to = ground_pose(ground, x + 2 * any_share(), y + 2 * any_share(), z + spacing * any_share());
	contact.to.yaw = 4 * any_share();
	const double way = hypot(lattice_offset_metres(contact.to.x - contact.from.x), lattice_offset_metres(contact.to.y - contact.from.y));
	if (shape->kind == SOIL_WHEEL)
		contact.turned = way / (shape->radius * (1 - 0.99 * any_share()));
	if (any_word() % 2) {
		contact.load = any_of(0, 1e9, false);
		contact.from.z = contact.to.z;
	} else {
		contact.hosted = any_word() % 2;
		contact.linear[2] = -any_of(0, 1e4, true);
	}
	return contact;
}

static void forces_are_numbers(const struct ground *ground, const struct deform_contact *contact, const struct deform_forces *forces)
{
	/* No post below the body bears more than 2^31 sixteenths of a pascal, however small the part of its cell is. */
	const double reach = soil_shape_reach(contact->shape, 0, 0), bound = soil_shape_bound(contact->shape), spacing = ground->params.spacing;
	const double across = 2 * bound + 2 * spacing, most = across * across * 0x1p27;
	for (int k = 0; k < 3; k++)
		if (!(fabs(forces->force[k]) <= most) || !(fabs(forces->moment[k]) <= most * 4 * (bound + spacing)))
			fail_msg("force %d of %g m2: %g N, %g N m", k, forces->area, forces->force[k], forces->moment[k]);
	assert_true(forces->area >= 0 && forces->sinkage >= 0 && forces->sinkage <= 1024);
	/* It sinks no deeper than it is high; and stands no higher than the ground reaches above where it was looked for. */
	const double raised = lattice_offset_metres(forces->z - contact->to.z);
	assert_true(contact->load > 0 ? raised < 2048 && raised > -2048 - 2 * reach : raised == 0);
}

/* Every plane in its range, holes as they were; the sum of offsets. Returns how many posts moved. */
static int64_t look(struct ground *ground)
{
	int32_t *offset = ground_plane(ground, PLANE_OFFSET), *laid = ground_plane(ground, PLANE_DEPOSITED), *sinkage = ground_plane(ground, PLANE_PLASTIC_SINKAGE);
	int64_t moved = 0;
	for (int64_t i = 0; i < POSTS * POSTS; i++) {
		assert_true(offset[i] >= -MOST && offset[i] <= MOST && laid[i] >= -MOST && laid[i] <= MOST);
		assert_true(sinkage[i] >= 0 && sinkage[i] <= 2 * (int64_t)MOST);
		assert_true(rough(i % POSTS, i / POSTS) != BASE_NODATA || (offset[i] == 0 && laid[i] == 0 && sinkage[i] == 0));
		moved += offset[i] != 0;
	}
	mem_free(offset);
	mem_free(laid);
	mem_free(sinkage);
	ground_lost_nothing(ground);
	return moved;
}

static void any_soil_makes_nothing_but_numbers(void **state)
{
	enum { ROUNDS = 120 };
	int64_t moved = 0;
	for (int round = 0; round < ROUNDS; round++) {
		struct ground ground;
		const double spacing = exp2(-(double)(round % 7));
		struct soil_shape shape = {.kind = (enum soil_shape_kind)(any_word() % 3)};
		shape.radius = fmax(0.001, spacing * exp2(4 * any_share()));
		shape.width = fmax(0.001, spacing * exp2(4 * any_share()));
		for (int k = 0; k < 3; k++)
			shape.size[k] = fmax(0.001, spacing * exp2(4 * any_share()));
		const double width = shape.kind == SOIL_WHEEL ? shape.width : shape.kind == SOIL_BOX ? fmin(shape.size[0], shape.size[1]) : spacing;
		const struct soil_numbers soil = any_soil(width);
		ground_init(&ground, &(struct ground_params){
			.cells = CELLS, .tiles = TILES, .spacing = spacing, .height = rough, .soils = &soil, .iterations = 1 + (int)(any_word() % 8),
			.depth = any_word() % 2 ? 0 : any_of(0, 1024, false), .bulldozing = any_of(0, 1, true),
			.slip_sinkage = any_word() % 2 ? any_of(0, 10, true) : 0,
		});
		/* Not all of it is stable: any of it may slide. */
		assert_ok(bearing_wake(ground.bearing, (struct post_rect){0, 0, POSTS, POSTS}));
		for (int k = 0; k < 6; k++) {
			const struct deform_contact contact = any_contact(&ground, &shape);
			const struct deform_forces forces = ground_forces(&ground, &contact);
			forces_are_numbers(&ground, &contact, &forces);
			ground_interval(&ground, &(struct deform_rest){.shape = &shape, .pose = contact.to}, 1);
		}
		moved += look(&ground);
		ground_finish(&ground);
	}
	assert_true(moved > 50 * ROUNDS);
}

/* Random drives, deep and shallow, with loads and without. */
static void what_is_not_compacted_is_somewhere(void **state)
{
	static const struct soil_shape shapes[] = {
		{.kind = SOIL_WHEEL, .radius = 0.8, .width = 0.5}, {.kind = SOIL_SPHERE, .radius = 0.6}, {.kind = SOIL_BOX, .size = {1, 0.6, 0.4}}};
	static const double bulldozing[] = {0, 0.5, 1, 0.3};
	const struct soil_numbers soil = bed_soft();
	for (int round = 0; round < 4; round++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = CELLS, .tiles = TILES, .spacing = 0.125, .soils = &soil, .height = rough, .bulldozing = bulldozing[round],
							     .slip_sinkage = round % 2});
		for (int i = 0; i < 6; i++) {
			const struct soil_shape *shape = &shapes[any_word() % 3];
			double heading = any_share() * M_PI;
			struct deform_contact contact = ground_stand(&ground, shape, 48 + 30 * any_share(), 48 + 30 * any_share(),
								     soil_shape_reach(shape, 0, 0) - 0.1 + 0.15 * any_share());
			for (int k = 0; k < 25; k++) {
				ground_forces(&ground, &contact);
				heading += 0.3 * any_share();
				ground_go(&contact, 0.125 * cos(heading), 0.125 * sin(heading), 0.02 * any_share());
				contact.to.yaw = heading;
				contact.turned = 0.125 * (1 + any_share());
				contact.load = any_word() % 4 == 0 ? exp2(10 + 6 * any_share()) : 0;
				if (contact.load > 0)
					contact.from.z = contact.to.z;
			}
			assert_true(look(&ground) > 0);
			assert_true((ground_sum(&ground, PLANE_DEPOSITED) > 0) == (bulldozing[round] > 0 || round % 2 == 1));
		}
		ground_finish(&ground);
	}
}

TEST_PROGRAM(limits)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(any_soil_makes_nothing_but_numbers),
		cmocka_unit_test(what_is_not_compacted_is_somewhere),
	};
	return cmocka_run_group_tests_name("bearing/limits", tests, NULL, NULL);
}
