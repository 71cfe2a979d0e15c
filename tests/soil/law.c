/* The law of bearing soil beside closed forms and integrals: plates, wheels that roll, slip and lean, reloading, energy; and where and how a body is set. */
#include "bed.h"

#include "deform/reference/reference.h"
#include "../support/program.h"

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.4, 0.1, 0.5}}, wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};

/* Sets a body down, its lowest place `sinkage` below the ground. */
static struct soil_motion stand(const struct bed *bed, const struct soil_shape *shape, double x, double y, double sinkage, double yaw, double roll)
{
	const double z = bed_ground(bed, x, y) + soil_shape_reach(shape, 0, roll) - sinkage;
	const struct soil_pose pose = {lattice_offset(x), lattice_offset(y), lattice_offset(z), yaw, 0, roll, 0};
	return (struct soil_motion){.shape = shape, .from = pose, .to = pose};
}

/* Goes on by a way. */
static void move(struct soil_motion *motion, double dx, double dy, double dz)
{
	motion->from = motion->to;
	motion->to.x += lattice_offset(dx);
	motion->to.y += lattice_offset(dy);
	motion->to.z += lattice_offset(dz);
}

/* Into the frame of a body that looks along `yaw`. */
static void into(double yaw, double v[3])
{
	const double east = v[0], north = v[1];
	v[0] = cos(yaw) * east + sin(yaw) * north;
	v[1] = cos(yaw) * north - sin(yaw) * east;
}

/* --- plates --- */

/* The numbers are rounded to 0.01 mm. */
static void plates_sink_as_bekker_says(void **state)
{
	static const struct {
		const char *soil;
		double sinkage; /* mm, under 20 kPa and 0.1 m wide */
	} plates[] = {{"dry_sand", 19.29}, {"sandy_loam_15", 1.97}, {"lete_sand", 0.69}, {"lunar", 23.98}, {"snow_us", 211.4}};
	for (size_t i = 0; i < COUNT(plates); i++) {
		struct bed bed;
		const struct soil_numbers soil = bed_soil(plates[i].soil);
		bed_init(&bed, &soil, 0.015625, 96, 0, 0);
		struct soil_motion motion = stand(&bed, &plate, 0.743, 0.756, plates[i].sinkage / 1000, 0, 0);
		const struct soil_forces forces = bed_press(&bed, &motion, 0).forces;
		const double pressure = forces.force[2] / forces.area, rounding = plates[i].sinkage > 100 ? 0.055 : 0.0055;
		assert_true(fabs(pressure / 20e3 - 1) < soil.bekker_n * rounding / plates[i].sinkage);
		assert_near(pressure, reference_bekker(&soil, 0.1, forces.sinkage), 1e-4 * pressure);
		assert_near(forces.area, 0.04, 1e-6);
		assert_true(forces.force[0] == 0 && forces.force[1] == 0 && fabs(forces.moment[2]) < 1e-9);
		bed_reset(&bed);
		motion.load = 20e3 * 0.04;
		const struct soil_imprint loaded = bed_press(&bed, &motion, -4000);
		assert_near(loaded.forces.force[2], motion.load, 1e-3);
		assert_near(loaded.forces.sinkage, plates[i].sinkage / 1000, rounding / 1000);
		bed_finish(&bed);
	}
}

/* Returns the mean shear below the plate after a straight way. At each place the plate has slid since it came over it. */
static double mean_shear(const struct soil_numbers *soil, double pressure, double x, double y)
{
	enum { PIECES = 400 };
	double sum = 0;
	for (int i = 0; i < PIECES; i++)
		for (int k = 0; k < PIECES; k++) {
			const double share = fmin(1, fmin(plate.size[0] * (i + 0.5) / PIECES / x, plate.size[1] * (k + 0.5) / PIECES / y));
			sum += reference_janosi(soil, pressure, share * hypot(x, y));
		}
	return sum / PIECES / PIECES;
}

/* Of the whole way at once. The plate is 6.4 posts wide. */
static void plates_shear_as_janosi_says(void **state)
{
	static const struct {
		double way, within; /* of the last, a post slides by K more than the one before it */
	} cases[] = {{0.025, 0.01}, {0.1, 0.005}, {0.9, 0.03}};
	struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	soil.janosi_shear = 0.025;
	bed_init(&bed, &soil, 0.015625, 160, 0, 0);
	for (size_t i = 0; i < COUNT(cases); i++) {
		bed_reset(&bed);
		const double x = cases[i].way * 0.8, y = cases[i].way * 0.6;
		struct soil_motion motion = stand(&bed, &plate, 0.625, 1, 0.0192946, 0, 0);
		bed_press(&bed, &motion, 0);
		move(&motion, x, y, 0);
		const struct soil_forces forces = bed_press(&bed, &motion, 0).forces;
		const double wanted = mean_shear(&soil, 20e3, x, y), ahead = -forces.force[0] / forces.area / 0.8, aside = -forces.force[1] / forces.area / 0.6;
		print_message("%g m: %.1f and %.1f Pa, wanted %.1f\n", cases[i].way, ahead, aside, wanted);
		assert_near(forces.force[2] / forces.area, 20e3, 4);
		assert_near(ahead, wanted, cases[i].within * wanted);
		assert_near(aside, wanted, cases[i].within * wanted);
	}
	bed_finish(&bed);
}

/* Damping adds R v to the pressure where the body moves down, and nothing where its velocity is not known. */
static void soil_that_is_pressed_fast_bears_more(void **state)
{
	static const double rates[] = {0, 0.1, 1};
	const struct soil_numbers soil = bed_soft();
	struct bed bed;
	double still = 0;
	bed_init(&bed, &soil, 0.015625, 96, 0, 0);
	for (int i = 0; i < 3; i++) {
		bed_reset(&bed);
		struct soil_motion motion = stand(&bed, &plate, 0.75, 0.75, 0.05, 0, 0);
		motion.linear[2] = -rates[i];
		const struct soil_forces forces = bed_press(&bed, &motion, 0).forces;
		const double pressure = forces.force[2] / forces.area, slow = 1 / (1 + rates[i] * rates[i] / 4e-6);
		still = i == 0 ? pressure : still;
		assert_near(pressure - still, soil.damping * rates[i] * (1 + 10 * slow), 0.5 + 1e-4 * soil.damping * rates[i]);
	}
	bed_finish(&bed);
}

/* It rebounds by 0.5 mm, and bears the same again without sinking deeper. */
static void a_load_rebounds_and_presses_no_deeper_again(void **state)
{
	const struct soil_numbers soil = bed_soft();
	struct bed bed;
	bed_init(&bed, &soil, 0.015625, 96, 0, 0);
	const size_t post = 48 * 96 + 48;
	struct soil_motion load = stand(&bed, &plate, 0.75, 0.75, 0, 0, 0);
	load.load = 20e3 * 0.04;
	const struct soil_imprint first = bed_press(&bed, &load, -100000);
	assert_near(first.forces.sinkage, 0.12328, 6e-6);
	struct soil_motion lift = stand(&bed, &plate, 0.75, 0.75, first.forces.sinkage, 0, 0);
	lift.to.z = lattice_offset(bed.height + 1);
	bed_press(&bed, &lift, 0);
	const int32_t rut = bed.planes.offset[post], pressed = bed.planes.sinkage[post];
	assert_near(lattice_offset_metres(rut) + first.forces.sinkage, 0.0005, 2e-6);
	for (int i = 0; i < 3; i++) {
		const struct soil_imprint again = bed_press(&bed, &load, -100000);
		assert_near(again.forces.sinkage, first.forces.sinkage, 0x1p-20);
		assert_true(abs(bed.planes.sinkage[post] - pressed) <= 1);
		lift.from.z = again.forces.z;
		bed_press(&bed, &lift, 0);
		assert_true(abs(bed.planes.offset[post] - rut) <= 1);
	}
	bed_finish(&bed);
}

/* --- energy --- */

/* A body that is pressed down and raised again gets back at most the elastic energy, whatever its steps are: of a plate F z_e / 2, z_e its rebound. */
static void soil_gives_back_its_elastic_energy_and_no_more(void **state)
{
	static const struct soil_shape shapes[] = {{.kind = SOIL_BOX, .size = {0.3, 0.3, 0.3}}, {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, {.kind = SOIL_SPHERE, .radius = 0.2}};
	static const double spacings[] = {0.0625, 0.03125, 0.015625};
	const struct soil_numbers soil = bed_soil("dry_sand");
	for (size_t i = 0; i < COUNT(shapes); i++)
		for (size_t s = 0; s < COUNT(spacings); s++) {
			struct bed bed;
			bed_init(&bed, &soil, spacings[s], 96, 0, 0);
			double taken = 0, given = 0, before = 0, most_force = 0;
			const double x = 47.6 * spacings[s];
			struct soil_motion motion = stand(&bed, &shapes[i], x, x, -0.001, 0, 0);
			motion.hosted = true;
			motion.stamped = 1; /* it moves straight up and down */
			for (int step = 0; step < 102 + 4000; step++) {
				const double down = step < 102 ? 512 * 0x1p-20 : -4 * 0x1p-20; /* whole units */
				move(&motion, 0, 0, -down);
				const double force = bed_press(&bed, &motion, 0).forces.force[2], work = 0.5 * (force + before) * down;
				*(work > 0 ? &taken : &given) += fabs(work);
				most_force = fmax(most_force, force);
				before = force;
			}
			const double elastic = 0.5 * most_force * reference_bekker(&soil, 0.3, 102 * 512 * 0x1p-20 - 0.001) / soil.elastic_stiffness;
			print_message("shape %zu, %g m: took %.3f J, gave back %.4f (plate %.4f)\n", i, spacings[s], taken, given, elastic);
			/* The width of a sphere's patch follows from the posts that it touches, so as it leaves, the soil seems to spring back a little more. */
			assert_near(before, 0, 2e-3 * most_force);
			assert_true(given > 0 && given < 1.1 * elastic);
			if (i == 0)
				assert_near(given, elastic, 0.01 * elastic);
			bed_finish(&bed);
		}
}

/* --- wheels --- */

/* Sets a wheel down at fixed height, and rolls it until nothing is left below of where it stood. Returns the last forces in its frame: means over the
 * last posts, since where the axle is between two posts counts. turned: of a metre of way. */
static struct soil_forces rolled(struct bed *bed, const struct soil_shape *shape, double sinkage, double yaw, double roll, double turned, const double shift[2])
{
	enum { LAST = 8 };
	const double spacing = bed->law.spacing, middle = bed->planes.rect.x1 / 2 * spacing, way = 0.5;
	bed_reset(bed);
	struct soil_motion motion = stand(bed, shape, middle + (shift[0] - 0.5 * way / spacing * cos(yaw)) * spacing, middle + (shift[1] - 0.5 * way / spacing * sin(yaw)) * spacing,
					  sinkage, yaw, roll);
	bed_press(bed, &motion, 0);
	struct soil_forces mean = {.z = 0};
	const int steps = (int)(way / spacing) + LAST;
	for (int i = 0; i < steps; i++) {
		const double step = 0.875 * spacing, rise = step * (cos(yaw) * bed->slope[0] + sin(yaw) * bed->slope[1]);
		move(&motion, step * cos(yaw), step * sin(yaw), rise);
		motion.turned = step * turned / shape->radius;
		const struct soil_forces forces = bed_press(bed, &motion, 0).forces;
		for (int k = 0; k < 3 && i >= steps - LAST; k++) {
			mean.force[k] += forces.force[k] / LAST;
			mean.moment[k] += forces.moment[k] / LAST;
		}
	}
	into(yaw, mean.force);
	into(yaw, mean.moment);
	return mean;
}

static const double nowhere[2] = {0, 0};

/* At 1 cm within 1.5 % of the vertical force; and the error falls with the spacing. */
static void a_wheel_that_slips_is_the_closed_form_at_ever_finer_spacings(void **state)
{
	static const double turned[] = {1, 1 / 0.8, 0.7, 2}, spacings[] = {0.04, 0.02, 0.01};
	static const char *const soils[] = {"dry_sand", "lunar", "clayey_38"};
	for (size_t n = 0; n < COUNT(soils); n++) {
		const struct soil_numbers soil = bed_soil(soils[n]);
		for (size_t t = 0; t < COUNT(turned); t++) {
			const struct reference_rolling rolling = {.radius = wheel.radius, .width = wheel.width, .turned = turned[t], .rebound = true,
								  .normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM};
			const struct reference_rolling_force wanted = reference_rolling(&soil, &rolling, 0.03);
			double worst[COUNT(spacings)];
			for (size_t s = 0; s < COUNT(spacings); s++) {
				struct bed bed;
				bed_init(&bed, &soil, spacings[s], 128, 0, 0);
				const struct soil_forces got = rolled(&bed, &wheel, 0.03, 0, 0, turned[t], nowhere);
				worst[s] = fmax(fabs(got.force[0] - wanted.drawbar), fabs(got.force[2] - wanted.vertical));
				worst[s] = support_most(worst[s], fabs(got.moment[1] - wanted.moment) / wheel.radius) / wanted.vertical;
				bed_finish(&bed);
			}
			print_message("%s, turned %g: off by %.3f, %.3f, %.3f %% of %.1f N at 4, 2, 1 cm\n", soils[n], turned[t], worst[0] * 100, worst[1] * 100, worst[2] * 100,
				      wanted.vertical);
			assert_true(worst[0] < 0.06 && worst[1] < 0.03 && worst[2] < 0.015);
		}
	}
}

static void a_wheel_that_slips_more_pulls_more(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	double before = -INFINITY;
	bed_init(&bed, &soil, 0.03125, 96, 0, 0);
	for (int i = -2; i < 9; i++) {
		const struct soil_forces forces = rolled(&bed, &wheel, 0.03, 0, 0, 1 / (1 - i * 0.1), nowhere);
		assert_true(forces.force[0] > before);
		before = forces.force[0];
		assert_true((i < 2 || before > 0) && (i > -1 || before < 0));
	}
	bed_finish(&bed);
}

/* Forces and moments of a wheel with camber are those of an integral over its surface. */
static void camber_is_the_integral_over_the_surface(void **state)
{
	static const double cambers[] = {0, 0.2, 1, 3, 9, 23}, yaws[] = {0, 0.7, 2.1}, turned[] = {1, 1.25};
	static const char *const soils[] = {"dry_sand", "clayey_38"};
	for (size_t n = 0; n < COUNT(soils); n++) {
		const struct soil_numbers soil = bed_soil(soils[n]);
		struct bed bed;
		bed_init(&bed, &soil, 0.01, 128, 0, 0);
		for (size_t i = 0; i < COUNT(cambers); i++)
			for (size_t t = 0; t < COUNT(turned); t++) {
				const double camber = cambers[i] * DEGREES, yaw = yaws[(i + t) % 3];
				const struct reference_leaning leans = {.radius = wheel.radius, .width = wheel.width, .camber = camber, .sinkage = 0.03, .rolls = true, .turned = turned[t]};
				const struct reference_wrench wanted = reference_leaning(&soil, &leans);
				const struct soil_forces got = rolled(&bed, &wheel, 0.03, yaw, camber, turned[t], nowhere);
				double worst = 0;
				for (int k = 0; k < 3; k++)
					worst = support_most(worst, support_most(fabs(got.force[k] - wanted.force[k]), fabs(got.moment[k] - wanted.moment[k]) / wheel.radius));
				print_message("%s, camber %g, turned %g: off by %.2f %%\n", soils[n], cambers[i], turned[t], 100 * worst / wanted.force[2]);
				assert_true(worst < 0.01 * wanted.force[2]);
			}
		bed_finish(&bed);
	}
}

/* --- where and how a body is set --- */

static void neither_direction_nor_place_changes_a_force(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	bed_init(&bed, &soil, 0.02, 128, 0, 0);
	const struct soil_forces wanted = rolled(&bed, &wheel, 0.03, 0, 0, 1.25, nowhere);
	double worst = 0;
	for (int i = 0; i < 12; i++) {
		const double yaw = i * M_PI / 6 + 0.1 * (i % 3), shift[2] = {0.31 * (i % 4), 0.23 * (i % 5)};
		const struct soil_forces got = rolled(&bed, &wheel, 0.03, yaw, 0, 1.25, shift);
		for (int k = 0; k < 3; k++)
			worst = support_most(worst, support_most(fabs(got.force[k] - wanted.force[k]), fabs(got.moment[k] - wanted.moment[k]) / wheel.radius) / wanted.force[2]);
	}
	print_message("12 directions and places: off by at most %.2f %%\n", 100 * worst);
	assert_true(worst < 0.02);
	bed_finish(&bed);
}

/* Heights are whole numbers: 976 m higher, and 3,000,000 m farther, nothing changes. */
static void neither_height_nor_distance_changes_a_bit(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	int32_t *kept[2];
	struct soil_forces forces[2];
	for (int i = 0; i < 2; i++) {
		bed_init(&bed, &soil, 0.015625, 96, 0, 0);
		struct soil_motion motion = stand(&bed, &wheel, 0.55, 0.7, 0.03, 0.3, 0);
		if (i == 1) {
			const int64_t far = (int64_t)192000000; /* posts of 2^-6 m */
			bed.planes.rect = (struct post_rect){far, -far, far + 96, -far + 96};
			motion.to.x += far * (1 << 14);
			motion.to.y -= far * (1 << 14);
			motion.to.z += (int64_t)976 << OFFSET_BITS;
			motion.from = motion.to;
			for (size_t k = 0; k < bed.posts; k++)
				bed.planes.base[k] += 976 << BASE_BITS;
		}
		for (int k = 0; k < 10; k++) {
			forces[i] = bed_press(&bed, &motion, 0).forces;
			move(&motion, 0.015625, 0.005, -0.0005);
			motion.turned = 0.07;
		}
		kept[i] = mem_alloc(bed.posts, 3 * sizeof(int32_t));
		assert_non_null(kept[i]);
		memcpy(kept[i], bed.planes.offset, bed.posts * sizeof(int32_t));
		memcpy(kept[i] + bed.posts, bed.planes.sinkage, bed.posts * sizeof(int32_t));
		memcpy(kept[i] + 2 * bed.posts, bed.planes.shear, bed.posts * sizeof(int32_t));
		bed_finish(&bed);
	}
	assert_memory_equal(forces[0].force, forces[1].force, sizeof forces[0].force);
	assert_memory_equal(forces[0].moment, forces[1].moment, sizeof forces[0].moment);
	assert_memory_equal(kept[0], kept[1], 3 * bed.posts * sizeof(int32_t));
	assert_true(forces[0].force[2] > 100);
	mem_free(kept[0]);
	mem_free(kept[1]);
}

static void left_and_right_are_the_same(void **state)
{
	const struct soil_numbers soil = bed_soft();
	struct bed bed;
	struct soil_forces forces = {.z = 0};
	bed_init(&bed, &soil, 0.03125, 97, 0, 0);
	struct soil_motion motion = stand(&bed, &wheel, 32 * 0.03125, 48 * 0.03125, 0.06, 0, 0);
	for (int i = 0; i < 30; i++) {
		forces = bed_press(&bed, &motion, 0).forces;
		move(&motion, 0.03125, 0, 0);
		motion.turned = 0.03125 / 0.3 / 0.8;
	}
	const int32_t *const planes[] = {bed.planes.offset, bed.planes.sinkage};
	for (size_t k = 0; k < COUNT(planes); k++)
		for (int y = 1; y <= 48; y++)
			assert_memory_equal(planes[k] + (48 - y) * 97, planes[k] + (48 + y) * 97, 97 * sizeof(int32_t));
	assert_true(forces.force[0] != 0 && forces.force[2] > 0);
	assert_true(fabs(forces.force[1]) < 1e-2 && fabs(forces.moment[0]) < 1e-2 && fabs(forces.moment[2]) < 1e-2);
	bed_finish(&bed);
}

/* A wheel that rolls on a slope has the forces of a level one, turned with the slope. */
static void a_slope_turns_the_forces(void **state)
{
	static const double slopes[] = {5, 10, 20};
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	bed_init(&bed, &soil, 0.01, 128, 0, 0);
	const struct soil_forces level = rolled(&bed, &wheel, 0.03, 0, 0, 1.25, nowhere);
	bed_finish(&bed);
	for (size_t i = 0; i < COUNT(slopes); i++) {
		const double c = cos(slopes[i] * DEGREES), s = sin(slopes[i] * DEGREES);
		bed_init(&bed, &soil, 0.01 * c, 128, s / c, 0);
		/* So deep along the slope's normal. */
		const struct soil_forces got = rolled(&bed, &wheel, wheel.radius - (wheel.radius - 0.03) / c, 0, 0, 1.25 / c, nowhere);
		const double along = c * got.force[0] + s * got.force[2], across = c * got.force[2] - s * got.force[0];
		print_message("slope %g: along %.1f N (level %.1f), across %.1f (%.1f), moment %.2f (%.2f)\n", slopes[i], along, level.force[0], across, level.force[2],
			      got.moment[1], level.moment[1]);
		assert_near(across, level.force[2], 0.02 * level.force[2]);
		assert_near(along, level.force[0], 0.02 * level.force[2]);
		assert_near(got.moment[1], level.moment[1], 0.02 * level.force[2] * wheel.radius);
		bed_finish(&bed);
	}
}

TEST_PROGRAM(law)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_sink_as_bekker_says),
		cmocka_unit_test(plates_shear_as_janosi_says),
		cmocka_unit_test(soil_that_is_pressed_fast_bears_more),
		cmocka_unit_test(a_load_rebounds_and_presses_no_deeper_again),
		cmocka_unit_test(soil_gives_back_its_elastic_energy_and_no_more),
		cmocka_unit_test(a_wheel_that_slips_is_the_closed_form_at_ever_finer_spacings),
		cmocka_unit_test(a_wheel_that_slips_more_pulls_more),
		cmocka_unit_test(camber_is_the_integral_over_the_surface),
		cmocka_unit_test(neither_direction_nor_place_changes_a_force),
		cmocka_unit_test(neither_height_nor_distance_changes_a_bit),
		cmocka_unit_test(left_and_right_are_the_same),
		cmocka_unit_test(a_slope_turns_the_forces),
	};
	return cmocka_run_group_tests_name("soil/law", tests, NULL, NULL);
}
