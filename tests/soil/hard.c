/*
 * Hard ground: rock, asphalt, concrete, ice. A plate presses it as a spring does, and slides on it by Coulomb's law. A wheel that slips pulls its load
 * times the tangent, and nothing changes the ground. At three spacings, on the level and on slopes, to all sides.
 */
#include "bed.h"
#include "soil/soil.h"

#include "../support/program.h"

static const char *const hard[] = {"rock", "asphalt", "concrete", "ice"};
static const double tangents[] = {0.65, 0.65, 0.75, 0.1};
static const double spacings[] = {0.08, 0.04, 0.02};

static struct soil_motion stand(const struct bed *bed, const struct soil_shape *shape, double x, double y, double sinkage, double yaw)
{
	const double z = bed_ground(bed, x, y) + soil_shape_reach(shape, 0, 0) - sinkage;
	const struct soil_pose pose = {lattice_offset(x), lattice_offset(y), lattice_offset(z), yaw, 0, 0, 0};
	return (struct soil_motion){.shape = shape, .from = pose, .to = pose};
}

/* The body is taken away, and nothing is left of it. */
static void assert_springs_back(struct bed *bed, struct soil_motion motion)
{
	motion.from = motion.to;
	motion.to.z += lattice_offset(0.5);
	motion.load = 0;
	bed_press(bed, &motion, 0);
	for (size_t k = 0; k < bed->posts; k++)
		assert_true(abs(bed->planes.offset[k]) <= 2 && bed->planes.dug[k] == 0);
}

static void a_plate_is_carried_as_by_a_spring(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.4, 0.2}};
	for (size_t n = 0; n < COUNT(hard); n++)
		for (size_t s = 0; s < COUNT(spacings); s++) {
			const struct soil_numbers soil = bed_soil(hard[n]);
			struct bed bed;
			assert_true(soil_is_hard(&soil));
			bed_init(&bed, &soil, spacings[s], (int)(2 / spacings[s]), 0, 0);
			soil_law_set_layers(&bed.law);
			for (double load = 1e3; load < 1.1e5; load *= 10) {
				bed_reset(&bed);
				struct soil_motion motion = stand(&bed, &plate, 1.003, 0.991, 0, 0);
				motion.load = load;
				const struct soil_forces forces = bed_press(&bed, &motion, -1000).forces;
				motion.to.z = forces.z;
				assert_near(forces.force[2], load, 1e-3 * load);
				assert_near(forces.sinkage, load / (0.16 * 2e8), 0.02 * load / (0.16 * 2e8) + 2e-6);
				assert_springs_back(&bed, motion);
			}
			bed_finish(&bed);
		}
}

/* It is pressed down and drawn by 2 cm in steps of 1 mm. */
static void a_plate_slides_by_coulombs_law(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.4, 0.2}};
	for (size_t n = 0; n < COUNT(hard); n++)
		for (size_t s = 0; s < COUNT(spacings); s++)
			for (double way = 0; way < 6; way += 1.3) {
				const struct soil_numbers soil = bed_soil(hard[n]);
				struct bed bed;
				bed_init(&bed, &soil, spacings[s], (int)(2 / spacings[s]), 0, 0);
				soil_law_set_layers(&bed.law);
				struct soil_motion motion = stand(&bed, &plate, 1.003, 0.991, 2e-5, 0);
				struct soil_forces forces = {.area = 0};
				for (int i = 0; i < 20; i++) {
					motion.from = motion.to;
					motion.to.x += lattice_offset(1e-3 * cos(way));
					motion.to.y += lattice_offset(1e-3 * sin(way));
					forces = bed_press(&bed, &motion, 0).forces;
				}
				const double grip = -(forces.force[0] * cos(way) + forces.force[1] * sin(way));
				assert_true(forces.force[2] > 500);
				/* Soil that the plate has just come onto has not sheared yet: a part of a post's width. */
				assert_near(grip / forces.force[2], tangents[n], (0.004 + 0.3 * spacings[s]) * tangents[n]);
				assert_springs_back(&bed, motion);
				bed_finish(&bed);
			}
}

TEST_PROGRAM(hard)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_is_carried_as_by_a_spring),
		cmocka_unit_test(a_plate_slides_by_coulombs_law),
	};
	return cmocka_run_group_tests_name("hard ground", tests, NULL, NULL);
}
