/* Mobilised shear of scm: a vector that grows after Janosi, turns, reverses, and ends with the contact. */
#include "ground.h"
#include "../support/program.h"

#define UNIT 0x1p-15

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.5, 0.5, 0.5}};

static struct soil_numbers soil_with(double modulus)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.janosi_shear = modulus;
	return soil;
}

static void init(struct ground *ground, const struct soil_numbers *soil)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.015625, .soils = soil});
}

static void go(struct deform_contact *contact, int64_t east, int64_t north, int64_t up)
{
	contact->from = contact->to;
	contact->to.x += east;
	contact->to.y += north;
	contact->to.z += up;
}

/* At the block's middle. */
static void read_shear(struct ground *ground, double shear[2])
{
	int32_t post = ground_post(ground, PLANE_SHEAR, 64, 64);
	for (int part = 0; part < 2; part++)
		shear[part] = plane_shear(post, (enum plane_shear_part)part) * UNIT;
}

/* For K from 1 mm to 10 cm, in four directions: the shear is 1 - exp(-j / K), whatever number of contacts the way is cut into. */
static void a_way_shears_the_same_however_it_is_cut(void **state)
{
	static const double moduli[] = {0.001, 0.02, 0.1}, ways[] = {0.25, 1, 4};
	static const double directions[] = {0, 22.5, 45, 200};
	for (size_t k = 0; k < 3 * 3 * 4; k++) {
		const double modulus = moduli[k % 3], way = ways[k / 3 % 3] * modulus, angle = directions[k / 9] * M_PI / 180;
		const struct soil_numbers soil = soil_with(modulus);
		struct ground ground;
		init(&ground, &soil);
		for (int pieces = 1; pieces <= 16; pieces *= 4) {
			double shear[2];
			ground_reset(&ground);
			/* The plate is over the post from the beginning to the end. */
			struct deform_contact contact = ground_stand(&ground, &plate, 64.3 - 32 * way * cos(angle), 64.2 - 32 * way * sin(angle), 0.25 - 0.02);
			ground_forces(&ground, &contact);
			const int64_t east = lattice_offset(way * cos(angle) / pieces), north = lattice_offset(way * sin(angle) / pieces);
			for (int i = 0; i < pieces; i++) {
				go(&contact, east, north, 0);
				ground_forces(&ground, &contact);
			}
			read_shear(&ground, shear);
			const double gone = pieces * hypot(lattice_offset_metres(east), lattice_offset_metres(north));
			const double wanted = 1 - exp(-gone / modulus), turned = atan2((double)north, (double)east);
			for (int part = 0; part < 2; part++) {
				const double parts = wanted * (part == 0 ? cos(turned) : sin(turned));
				if (!(fabs(shear[part] - parts) < (1 + 0.5 * pieces) * UNIT))
					fail_msg("K %g m, %g K in %d pieces at %g rad: %.9g, not %.9g", modulus, gone / modulus, pieces, angle,
						 shear[part], parts);
			}
		}
		ground_finish(&ground);
	}
}

/* On the way back the force falls from the first step on. It is 0 after K ln 2, and near its limit after 3 K. */
static void on_the_way_back_the_shear_turns_over_about_3_k(void **state)
{
	const double modulus = 0.02;
	const struct soil_numbers soil = soil_with(modulus);
	struct ground ground;
	double shear[2], last;
	init(&ground, &soil);
	struct deform_contact contact = ground_stand(&ground, &plate, 60, 64, 0.25 - 0.02);
	ground_forces(&ground, &contact);
	go(&contact, lattice_offset(5 * modulus), 0, 0);
	struct deform_forces before = ground_forces(&ground, &contact);
	read_shear(&ground, shear);
	assert_true(shear[0] > 0.99 && before.force[0] < 0);
	last = before.force[0];
	const double most = -before.force[0] / shear[0];
	for (int step = 1; step <= 30; step++) {
		go(&contact, -lattice_offset(modulus / 10), 0, 0);
		struct deform_forces forces = ground_forces(&ground, &contact);
		const double back = step * lattice_offset_metres(lattice_offset(modulus / 10)) / modulus;
		read_shear(&ground, shear);
		assert_true(fabs(shear[0] - (-1 + (2 - exp(-5)) * exp(-back))) < 16 * UNIT && shear[1] == 0);
		/* There is no jump. From one limit to the other is twice the strength, and a step of K / 10 changes the force by less than a
		 * tenth of it. One of the plate's 32 columns of posts may come or go besides. */
		assert_true(forces.force[0] - last > -2.0 / 32 * most && forces.force[0] - last < (0.2 + 2.0 / 32) * most);
		last = forces.force[0];
	}
	assert_true(shear[0] < -0.89);
	ground_finish(&ground);
}

/* After a turn the old shear decays exponentially, and shear in the new direction replaces it. */
static void shear_turns_with_the_way(void **state)
{
	const double modulus = 0.02;
	const struct soil_numbers soil = soil_with(modulus);
	struct ground ground;
	double shear[2];
	init(&ground, &soil);
	struct deform_contact contact = ground_stand(&ground, &plate, 64, 64, 0.25 - 0.02);
	ground_forces(&ground, &contact);
	go(&contact, lattice_offset(2 * modulus), 0, 0);
	ground_forces(&ground, &contact);
	go(&contact, 0, lattice_offset(modulus), 0);
	struct deform_forces forces = ground_forces(&ground, &contact);
	read_shear(&ground, shear);
	assert_true(fabs(shear[0] - (1 - exp(-2)) * exp(-1)) < 4 * UNIT && fabs(shear[1] - (1 - exp(-1))) < 4 * UNIT);
	assert_true(forces.force[0] < 0 && forces.force[1] < forces.force[0]);
	/* Without motion the shear holds. The force may differ a little: a moving contact computes shear at places between posts, and what
	 * is stored at a post counts for its whole cell. */
	go(&contact, 0, 0, 0);
	struct deform_forces held = ground_forces(&ground, &contact);
	for (int k = 0; k < 2; k++)
		if (!(fabs(held.force[k] - forces.force[k]) < 0.02 * hypot(forces.force[0], forces.force[1])))
			fail_msg("force %d: %g N, and %g N when it stands", k, forces.force[k], held.force[k]);
	ground_finish(&ground);
}

static int sheared(struct ground *ground, int64_t before, int64_t *count)
{
	int32_t *all = ground_plane(ground, PLANE_SHEAR);
	int left = 0;
	*count = 0;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		*count += all[i] != 0;
		left += all[i] != 0 && i % ground->posts < before;
	}
	mem_free(all);
	return left;
}

static void shear_ends_with_the_contact(void **state)
{
	const struct soil_numbers soil = soil_with(0.02);
	struct ground ground;
	int64_t count;
	init(&ground, &soil);
	/* The plate is 32 posts long. What it leaves is behind its west side. */
	struct deform_contact contact = ground_stand(&ground, &plate, 50.5, 64.5, 0.25 - 0.02);
	ground_forces(&ground, &contact);
	for (int i = 1; i <= 20; i++) {
		go(&contact, lattice_offset(0.015625), 0, 0);
		ground_forces(&ground, &contact);
		assert_int_equal(sheared(&ground, 50 + i - 15, &count), 0);
		assert_int_equal(count, 32 * 32);
	}
	/* Raised a little, the plate is out of contact, though it is still below the undisturbed ground. */
	go(&contact, 0, 0, lattice_offset(0.005));
	ground_forces(&ground, &contact);
	sheared(&ground, 0, &count);
	assert_int_equal(count, 0);
	ground_finish(&ground);
}

/* Passes of a wheel at one height in one rut: each has the same pull, wherever the passes before ended. */
static void passes_at_one_height_pull_the_same(void **state)
{
	static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
	const struct soil_numbers soil = soil_with(0.02);
	struct ground ground;
	double pulls[4][40];
	init(&ground, &soil);
	for (int pass = 0; pass < 4; pass++) {
		struct deform_contact contact = ground_stand(&ground, &wheel, 35.3, 64, 0.3 - 0.05);
		contact.turned = 0.015625 / 0.3 / 0.8;
		ground_forces(&ground, &contact);
		for (int i = 0; i < 40 - 9 * pass; i++) { /* each pass is shorter than the one before it */
			go(&contact, lattice_offset(0.015625), 0, 0);
			pulls[pass][i] = ground_forces(&ground, &contact).force[0];
		}
	}
	for (int pass = 2; pass < 4; pass++)
		for (int i = 2; i < 40 - 9 * pass; i++)
			if (pulls[pass][i] != pulls[1][i])
				fail_msg("pass %d, station %d: %.9g N, not %.9g", pass + 1, i, pulls[pass][i], pulls[1][i]);
	print_message("first pass %.1f N, those after it %.1f N\n", pulls[0][20], pulls[1][20]);
	ground_finish(&ground);
}

TEST_PROGRAM(shear)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_way_shears_the_same_however_it_is_cut),
		cmocka_unit_test(on_the_way_back_the_shear_turns_over_about_3_k),
		cmocka_unit_test(shear_turns_with_the_way),
		cmocka_unit_test(shear_ends_with_the_contact),
		cmocka_unit_test(passes_at_one_height_pull_the_same),
	};
	return cmocka_run_group_tests_name("bearing/shear", tests, NULL, NULL);
}
