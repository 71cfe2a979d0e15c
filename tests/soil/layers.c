/*
 * A layer of soil over another, or over rigid ground: plates beside the two-layer formula, wheels that stop above rigid ground, what a layer of no
 * thickness and an endless one are, energy, probes, headings, laid soil, slip, loose soil.
 *
 * The formula is computed here in doubles, in another way than in the law: what is left of the layer is searched by halving.
 */
#include "bed.h"

#include "deform/reference/reference.h"
#include "../support/program.h"

/* What lies over what. "": rigid ground. */
struct pair {
	const char *upper, *below;
	double thickness;
};

static const struct pair pairs[] = {
	{"snow_us", "", 0.1}, {"snow_us", "heavy_clay_25", 0.1}, {"snow_us", "dry_sand", 0.05}, {"sandy_loam_15", "lean_clay_22", 0.06}, {"lunar", "", 0.03},
	{"heavy_clay_25", "snow_us", 0.05}, {"lean_clay_22", "heavy_clay_40", 0.1}, {"clayey_38", "", 0.05}, {"dry_sand", "lunar", 0.02},
};

static void lay(struct bed *bed, const struct pair *pair, double spacing, int side, double east, double north, struct soil_numbers *below)
{
	struct soil_numbers soil = bed_soil(pair->upper);
	if (pair->below[0] == '\0')
		soil_set_rigid(below);
	else
		*below = bed_soil(pair->below);
	soil.over = below;
	soil.thickness = pair->thickness;
	bed_init(bed, &soil, spacing, side, east, north);
	soil_law_set_layers(&bed->law);
}

static double bekker(const struct soil_numbers *soil, double width, double z)
{
	return fmin(reference_bekker(soil, width, z), soil->elastic_stiffness * z);
}

/* Returns what is left of a layer, m. */
static double left_of(double ratio, double z, double thickness, double bulb)
{
	double low = 0, high = thickness;
	for (int i = 0; i < 200 && ratio < 1; i++) {
		const double h = (low + high) / 2, share = h / (h + bulb), rest = ratio * bulb / (h + bulb), squeezed = z * (1 - ratio) * share / (share + rest);
		*(h + squeezed < thickness ? &low : &high) = h;
	}
	return ratio < 1 ? low : thickness;
}

/* 1 / p = F / p_1 + (1 - F) / p_2 with F = h / (h + B); the layer is squeezed by its part of z, times 1 - p_1 / p_2. own, base: Pa at z. */
static double formula(double own, double base, double z, double thickness, double bulb)
{
	const double left = left_of(own / base, z, thickness, bulb);
	return 1 / (left / (left + bulb) / own + bulb / (left + bulb) / base);
}

static double layered(const struct soil_numbers *soil, double width, double bulb, double z)
{
	const bool rigid = soil_is_rigid(soil->over);
	return formula(bekker(soil, width, z), rigid ? 1e40 : bekker(soil->over, width, z), z, soil->thickness, bulb);
}

static struct soil_motion stand(const struct bed *bed, const struct soil_shape *shape, double x, double y, double sinkage, double yaw)
{
	const double z = bed_ground(bed, x, y) + soil_shape_reach(shape, 0, 0) - sinkage;
	const struct soil_pose pose = {lattice_offset(x), lattice_offset(y), lattice_offset(z), yaw, 0, 0, 0};
	return (struct soil_motion){.shape = shape, .from = pose, .to = pose};
}

static void move(struct soil_motion *motion, double dx, double dy, double dz)
{
	motion->from = motion->to;
	motion->to.x += lattice_offset(dx);
	motion->to.y += lattice_offset(dy);
	motion->to.z += lattice_offset(dz);
}

/* --- plates --- */

static void plates_bear_what_the_formula_says(void **state)
{
	static const double widths[] = {0.1, 0.2, 0.3}, spacings[] = {0.04, 0.02, 0.01};
	double worst = 0;
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (size_t s = 0; s < COUNT(spacings); s++) {
			struct soil_numbers below;
			struct bed bed;
			lay(&bed, &pairs[n], spacings[s], (int)(1 / spacings[s]), 0, 0, &below);
			for (size_t w = 0; w < COUNT(widths); w++)
				for (double depth = 0.1; depth < 1.5; depth += 0.17) {
					const struct soil_shape plate = {.kind = SOIL_BOX, .size = {widths[w], widths[w], 1}};
					const double z = depth * pairs[n].thickness;
					if (pairs[n].below[0] == '\0' && depth > 0.98)
						continue;
					bed_reset(&bed);
					struct soil_motion motion = stand(&bed, &plate, 0.503, 0.491, z, 0.3);
					const struct soil_forces forces = bed_press(&bed, &motion, 0).forces;
					const double got = forces.force[2] / forces.area, wanted = layered(&bed.law.soils[0], widths[w], widths[w], forces.sinkage);
					worst = support_most(worst, fabs(got / wanted - 1));
					assert_near(got, wanted, 0.002 * wanted);
					assert_near(forces.force[2], wanted * widths[w] * widths[w], 0.05 * forces.force[2]);
				}
			bed_finish(&bed);
		}
	print_message("plates of 10, 20, 30 cm at 4, 2, 1 cm: off by at most %.3f %%\n", 100 * worst);
}

/* Under a load it sinks as the formula says. */
static void loads_sink_plates_as_the_formula_says(void **state)
{
	static const double pressures[] = {5e3, 20e3, 80e3, 300e3};
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (size_t i = 0; i < COUNT(pressures); i++) {
			struct soil_numbers below;
			struct bed bed;
			lay(&bed, &pairs[n], 0.02, 50, 0, 0, &below);
			struct soil_motion motion = stand(&bed, &plate, 0.503, 0.491, 0, 0.3);
			motion.load = pressures[i] * 0.04;
			const struct soil_imprint found = bed_press(&bed, &motion, -1000);
			if (found.forces.state != SOIL_SUNK)
				assert_near(layered(&bed.law.soils[0], 0.2, 0.2, found.forces.sinkage), pressures[i], 0.01 * pressures[i] + 2e-6 * SOIL_USUAL_STIFFNESS);
			assert_true(pairs[n].below[0] != '\0' || found.forces.sinkage < pairs[n].thickness);
			assert_true(found.tries < 40);
			bed_finish(&bed);
		}
}

/* The pressure grows with the sinkage, without a step, and never beyond the stiffness of either soil as it springs back. */
static void pressure_grows_evenly(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	for (size_t n = 0; n < COUNT(pairs); n++) {
		struct soil_numbers below;
		struct bed bed;
		double before = 0, rose = 0;
		lay(&bed, &pairs[n], 0.02, 50, 0, 0, &below);
		const double deepest = pairs[n].thickness * (pairs[n].below[0] == '\0' ? 0.97 : 2);
		for (int i = 1; i < 400; i++) {
			struct soil_motion motion = stand(&bed, &plate, 0.503, 0.491, deepest * i / 400, 0);
			const double force = bed_feel(&bed, &motion, 0).force[2], rises = force - before;
			assert_true(rises > -1e-6 * force);
			assert_true(i < 20 || rises < 2 * rose + 0.01 * force);
			before = force;
			rose = rises;
		}
		bed_finish(&bed);
	}
}

/* --- wheels --- */

static void no_wheel_comes_through_a_layer_to_rigid_ground(void **state)
{
	static const double loads[] = {10, 600, 5e3, 2e4}, spacings[] = {0.04, 0.02, 0.01};
	static const char *const soils[] = {"snow_us", "snow_sweden", "dry_sand", "heavy_clay_25"};
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, ball = {.kind = SOIL_SPHERE, .radius = 0.3};
	for (size_t n = 0; n < COUNT(soils); n++)
		for (size_t s = 0; s < COUNT(spacings); s++)
			for (size_t i = 0; i < COUNT(loads); i++)
				for (int b = 0; b < 2; b++) {
					const struct pair pair = {soils[n], "", 0.1};
					struct soil_numbers below;
					struct bed bed;
					double deepest = 0;
					lay(&bed, &pair, spacings[s], (int)(1.6 / spacings[s]), 0, 0, &below);
					struct soil_motion motion = stand(&bed, b == 0 ? &wheel : &ball, 0.5, 0.8, 0, 0);
					motion.load = loads[i];
					int32_t start = -1000;
					for (int k = 0; k < 20; k++) {
						const struct soil_imprint out = bed_press(&bed, &motion, start);
						motion.to.z = out.forces.z;
						start = 0;
						deepest = fmax(deepest, out.forces.sinkage);
						assert_true(out.forces.state == SOIL_TOUCHING || out.forces.state == SOIL_SLIDES);
						assert_near(out.forces.force[2], loads[i], 1e-3 * loads[i]);
						assert_true(out.tries < 30);
						move(&motion, 0.02, 0, 0);
						motion.turned = 0.02 / 0.3;
					}
					/* The stresses of a cell are those of two places in it. Under a very large load the post between them is lower by what the body
					 * bends there. */
					const double bends = loads[i] > 1e4 ? 1e-5 + spacings[s] * spacings[s] / (12 * 0.3) : 0;
					for (size_t k = 0; k < bed.posts; k++)
						assert_true(lattice_offset_metres(bed.planes.offset[k]) > -0.1 - bends);
					assert_true(deepest < 0.1 + bends);
					if (loads[i] == 600 && b == 0)
						print_message("%s, %g m: 600 N sinks %.1f mm\n", soils[n], spacings[s], 1e3 * deepest);
					bed_finish(&bed);
				}
}

/* A wheel's force is the integral of the formula along its rim. Set down, and turned to any heading. */
static void a_wheel_bears_the_integral_of_the_formula(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
	for (size_t n = 0; n < COUNT(pairs); n++) {
		struct soil_numbers below;
		struct bed bed;
		double worst = 0;
		lay(&bed, &pairs[n], 0.01, 100, 0, 0, &below);
		const double z0 = 0.6 * pairs[n].thickness, half = sqrt(z0 * (0.6 - z0));
		double wanted = 0;
		for (int i = 0; i < 20000; i++) {
			const double x = half * (2 * (i + 0.5) / 20000 - 1), z = z0 - 0.3 + sqrt(0.09 - x * x);
			wanted += z > 0 ? layered(&bed.law.soils[0], 0.2, 0.2, z) * 0.2 * 2 * half / 20000 : 0;
		}
		for (int i = 0; i < 10; i++) {
			bed_reset(&bed);
			struct soil_motion motion = stand(&bed, &wheel, 0.5 + 0.0013 * i, 0.5 - 0.0021 * i, z0, 0.35 * i);
			worst = support_most(worst, fabs(bed_press(&bed, &motion, 0).forces.force[2] / wanted - 1));
		}
		print_message("%s over %s: ten headings off by at most %.2f %%\n", pairs[n].upper, pairs[n].below, 100 * worst);
		assert_true(worst < 0.02);
		bed_finish(&bed);
	}
}

/* --- bounds --- */

/* A layer of no thickness is the soil below, an endless one is itself: to the bit, whether the law knows so at once, or finds it at each post. */
static void no_thickness_and_an_endless_one_are_the_two_soils(void **state)
{
	const struct soil_shape shapes[] = {{.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.2}}, {.kind = SOIL_SPHERE, .radius = 0.2}};
	const struct soil_numbers upper = bed_soil("snow_us"), below = bed_soil("clayey_38");
	for (size_t shape = 0; shape < COUNT(shapes); shape++)
		for (int endless = 0; endless < 2; endless++) {
			struct bed beds[3];
			double told[3][12][2];
			struct soil_numbers soil = upper;
			soil.over = &below;
			soil.thickness = endless ? SOIL_ENDLESS : 0;
			for (int b = 0; b < 3; b++) {
				bed_init(&beds[b], b == 0 ? (endless ? &upper : &below) : &soil, 0.02, 64, 0.1, 0.02);
				beds[b].law.slip_sinkage = 1.35;
				beds[b].law.bulldozing = 0.5;
				if (b == 1) {
					soil_law_set_layers(&beds[b].law);
					assert_false(beds[b].law.layered);
				}
				beds[b].law.layered = b == 2;
			}
			for (int b = 0; b < 3; b++) {
				struct soil_motion motion = stand(&beds[b], &shapes[shape], 0.5, 0.6, 0.02, 0.4);
				for (int i = 0; i < 12; i++) {
					const struct soil_probed probed = bed_probe(&beds[b], &motion);
					const struct soil_forces forces = bed_press(&beds[b], &motion, 0).forces;
					told[b][i][0] = probed.force[2];
					told[b][i][1] = forces.force[2];
					move(&motion, 0.012, 0.004, i % 3 == 0 ? 0.002 : -0.001);
					motion.turned = 0.05;
				}
			}
			for (int b = 1; b < 3; b++) {
				assert_memory_equal(told[b], told[0], sizeof told[0]);
				const int32_t *const got[] = {beds[b].planes.offset, beds[b].planes.deposited, beds[b].planes.sinkage, beds[b].planes.shear, beds[b].planes.dug};
				const int32_t *const wanted[] = {beds[0].planes.offset, beds[0].planes.deposited, beds[0].planes.sinkage, beds[0].planes.shear, beds[0].planes.dug};
				for (size_t k = 0; k < COUNT(got); k++)
					assert_memory_equal(got[k], wanted[k], beds[0].posts * sizeof(int32_t));
			}
			for (int b = 0; b < 3; b++)
				bed_finish(&beds[b]);
		}
}

/* Thin and thick layers come near the two soils. */
static void thin_and_thick_layers_come_near_them(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	for (int i = 0; i < 2; i++) {
		struct soil_numbers below;
		struct bed bed, alone;
		const struct pair pair = {"snow_us", "dry_sand", i == 0 ? 1e-5 : 500};
		const struct soil_numbers soil = bed_soil(i == 0 ? "dry_sand" : "snow_us");
		lay(&bed, &pair, 0.02, 50, 0, 0, &below);
		bed_init(&alone, &soil, 0.02, 50, 0, 0);
		assert_true(bed.law.layered);
		struct soil_motion motion = stand(&bed, &plate, 0.5, 0.5, 0.04, 0);
		const double got = bed_feel(&bed, &motion, 0).force[2], wanted = bed_feel(&alone, &motion, 0).force[2];
		assert_near(got, wanted, 2e-3 * wanted);
		bed_finish(&bed);
		bed_finish(&alone);
	}
}

/* Rigid ground without a layer springs, and nothing stays. */
static void bare_rigid_ground_keeps_no_rut(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
	const struct pair pair = {"snow_us", "", 0};
	struct soil_numbers below;
	struct bed bed;
	lay(&bed, &pair, 0.02, 64, 0, 0, &below);
	bed.law.slip_sinkage = 1.35;
	struct soil_motion motion = stand(&bed, &wheel, 0.5, 0.6, 0, 0);
	motion.load = 600;
	for (int i = 0; i < 20; i++) {
		const struct soil_imprint out = bed_press(&bed, &motion, i == 0 ? -100 : 0);
		assert_near(out.forces.force[2], 600, 1);
		assert_true(out.forces.sinkage < 6e-4);
		motion.to.z = out.forces.z;
		if (i < 19)
			move(&motion, 0.02, 0, 0);
		motion.turned = 0.1;
	}
	move(&motion, 0, 0, 0.2);
	motion.load = 0;
	bed_press(&bed, &motion, 0);
	for (size_t k = 0; k < bed.posts; k++)
		assert_true(abs(bed.planes.offset[k]) <= 2 && bed.planes.dug[k] == 0);
	bed_finish(&bed);
}

/* --- energy --- */

/* Work, J. */
struct worked {
	double taken, given;
};

/* Moves a body so many steps down, and up again. before: the force at the last step, N. most_force: the largest so far. */
static struct worked go_down_and_up(struct bed *bed, struct soil_motion *motion, double step, int down, double *before, double *most_force)
{
	struct worked worked = {0, 0};
	for (int k = 0; k < 2 * down; k++) {
		const double way = k < down ? step : -step;
		move(motion, 0, 0, -way);
		const double force = bed_press(bed, motion, 0).forces.force[2];
		*(k < down ? &worked.taken : &worked.given) += 0.5 * (force + *before) * fabs(way);
		*before = force;
		*most_force = support_most(*most_force, force);
	}
	return worked;
}

/* A body that is pressed down and raised takes at least what it gets back, at each of three depths in turn. A plate gets back what the elastic curve says. */
static void layers_give_back_no_more_than_they_take(void **state)
{
	static const struct soil_shape shapes[] = {{.kind = SOIL_BOX, .size = {0.3, 0.3, 0.3}}, {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, {.kind = SOIL_SPHERE, .radius = 0.2}};
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (size_t i = 0; i < COUNT(shapes); i++) {
			struct soil_numbers below;
			struct bed bed;
			double before = 0, most_force = 0, gain = 0;
			lay(&bed, &pairs[n], 0.03125, 64, 0, 0, &below);
			const double step = pairs[n].thickness / 400;
			struct soil_motion motion = stand(&bed, &shapes[i], 0.98, 0.97, -step, 0);
			motion.hosted = true;
			motion.stamped = 1;
			/* Down to a third, two thirds, and nearly through; each time up, down to the same depth again, and up. The second time it gets back what it took. */
			for (int round = 1; round <= 3; round++)
				for (int again = 0; again < 2; again++) {
					const struct worked w = go_down_and_up(&bed, &motion, step, round * 125 + 1, &before, &most_force);
					gain = support_most(gain, (w.given - w.taken) / w.taken);
					if (again == 1 && i == 0)
						assert_near(w.given, w.taken, 0.01 * w.taken);
				}
			print_message("%s over %s, shape %zu: gains at most %.4f %%\n", pairs[n].upper, pairs[n].below, i, 100 * gain);
			assert_true(before < 2e-3 * most_force);
			assert_true(gain < 1e-3);
			bed_finish(&bed);
		}
}

/* --- probes --- */

static void a_probe_is_what_a_contact_tells_and_its_stiffness_the_slope_of_that(void **state)
{
	const struct soil_shape shapes[] = {{.kind = SOIL_BOX, .size = {0.3, 0.2, 0.3}}, {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, {.kind = SOIL_CAPSULE, .radius = 0.15, .length = 0.2}};
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (size_t i = 0; i < COUNT(shapes); i++) {
			struct soil_numbers below;
			struct bed bed;
			lay(&bed, &pairs[n], 0.02, 64, 0.05, -0.03, &below);
			for (double depth = 0.2; depth < 0.8; depth += 0.23) {
				double forces[3];
				const double step = 8 * 0x1p-20;
				struct soil_motion motion = stand(&bed, &shapes[i], 0.6, 0.63, depth * pairs[n].thickness, 0.4);
				motion.hosted = true;
				motion.linear[2] = -1e-7; /* it goes down */
				motion.interface = (struct soil_interface){.has_friction = true, .has_adhesion = true}; /* shear is stiff, too */
				const struct soil_probed probed = bed_probe(&bed, &motion);
				for (int k = -1; k < 2; k++) {
					struct soil_motion other = motion;
					other.to.z -= k * 8;
					other.from = other.to;
					forces[k + 1] = bed_probe(&bed, &other).force[2];
				}
				assert_near(probed.force[2], bed_feel(&bed, &motion, 0).force[2], 1e-5 * probed.force[2]);
				const double slope = (forces[2] - forces[0]) / (2 * step);
				/* Where the pressure of the last millimetres of depth counts much, two places of a cell are few. */
				const double within = i == 0 ? 0.01 : bed.law.soils[0].bekker_n < 0.3 && pairs[n].below[0] == 'h' ? 0.3 : 0.08;
				assert_near(-probed.stiffness[2][2], slope, within * slope);
			}
			bed_finish(&bed);
		}
}

/* --- laid soil, and slip --- */

/* Soil that was laid on a post is of the layer: the rigid ground below stays where it is. */
static void laid_soil_makes_the_layer_thicker(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	const struct pair pair = {"snow_us", "", 0.1};
	struct soil_numbers below;
	struct bed bed;
	lay(&bed, &pair, 0.02, 50, 0, 0, &below);
	for (size_t k = 0; k < bed.posts; k++)
		bed.planes.offset[k] = bed.planes.deposited[k] = lattice_offset(0.05);
	for (int i = 0; i < 2; i++) {
		struct soil_motion motion = stand(&bed, &plate, 0.5, 0.5, i == 0 ? 0.04 : 0.09, 0);
		struct soil_numbers soil = bed.law.soils[0];
		soil.thickness = 0.15;
		const double wanted = layered(&soil, 0.2, 0.2, i == 0 ? 0.09 : 0.14) * 0.04;
		assert_near(bed_feel(&bed, &motion, 0).force[2], wanted, 2e-3 * wanted);
	}
	bed_finish(&bed);
}

static void slip_digs_no_deeper_than_rigid_ground(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
	static const double thick[] = {0.005, 0.02, 0.05};
	for (size_t i = 0; i < COUNT(thick); i++) {
		const struct pair pair = {"dry_sand", "", thick[i]};
		struct soil_numbers below;
		struct bed bed;
		int32_t lowest = 0;
		lay(&bed, &pair, 0.02, 64, 0, 0, &below);
		bed.law.slip_sinkage = 4; /* 8 cm in all */
		struct soil_motion motion = stand(&bed, &wheel, 0.6, 0.63, 0, 0);
		motion.load = 800;
		for (int k = 0; k < 200; k++) { /* it spins nearly in its place */
			const struct soil_imprint out = bed_press(&bed, &motion, k == 0 ? -1000 : 0);
			motion.to.z = out.forces.z;
			assert_true(out.forces.sinkage < thick[i] + 5e-5);
			move(&motion, 0.0005, 0, 0);
			motion.turned = 0.05;
		}
		for (size_t k = 0; k < bed.posts; k++)
			lowest = bed.planes.offset[k] < lowest ? bed.planes.offset[k] : lowest;
		print_message("%g mm over rigid ground: dug to %.3f mm\n", 1e3 * thick[i], -1e3 * lattice_offset_metres(lowest));
		assert_true(lattice_offset_metres(lowest) > -thick[i] - 5e-5);
		bed_finish(&bed);
	}
}

/* A layer shears as itself as long as more of it is left than its own shear modulus. Then the soil below counts more and more: c and tan phi as of two
 * in line, of which the weaker one gives way. Over rigid ground nothing changes. */
static void shear_goes_over_to_the_soil_below_as_the_layer_is_used_up(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	for (int rigid = 0; rigid < 2; rigid++) {
		const struct pair pair = {"snow_us", rigid ? "" : "clayey_38", 0.1};
		struct soil_numbers below;
		struct bed bed;
		double least_share = 1;
		lay(&bed, &pair, 0.02, 100, 0, 0, &below);
		const struct soil_numbers *snow = &bed.law.soils[0], *base = rigid ? snow : &below;
		for (int i = 1; i < 14; i++) {
			const double z = (rigid ? 0.0075 : 0.06) * i;
			struct soil_motion motion = stand(&bed, &plate, 0.6, 1, z, 0);
			const struct soil_probed probed = bed_probe(&bed, &motion);
			const double pressure = probed.normal_force / 0.04, own = bekker(snow, 0.2, z), left = left_of(own / (rigid ? 1e40 : bekker(base, 0.2, z)), z, 0.1, 0.2);
			const double share = fmin(left / snow->janosi_shear, 1), cohesion = 1 / (share / snow->cohesion + (1 - share) / base->cohesion);
			const double friction = 1 / (share / tan(snow->friction_angle) + (1 - share) / tan(base->friction_angle)), wanted = fmin(cohesion, pressure) + pressure * friction;
			assert_near(probed.shear_limit / 0.04, wanted, 0.005 * wanted);
			least_share = fmin(least_share, share);
		}
		print_message("the share of the layer falls to %.2f\n", least_share);
		assert_true(least_share < 0.9);
		bed_finish(&bed);
	}
}

/* --- loose soil on a layer --- */

#define LOOSENING 0.67

/* Presses a body to a depth in steps, and raises it to the ground. */
static void press_and_raise(struct bed *bed, struct soil_motion *motion, double depth, double step)
{
	for (double at = 0; at < depth; at += step) {
		move(motion, 0, 0, -step);
		bed_press(bed, motion, 0);
	}
	move(motion, 0, 0, ceil(depth / step) * step);
	bed_press(bed, motion, 0);
}

/* A plate leaves a rut in a layer, and soil comes into it. That bears (1 - loosening) times what its soil does, or what the layer
 * does if it goes down with it. Below it the layer is what it was: at the
 * same height it bears as one on which no soil came, and over rigid ground no body comes through. Volumes stay. */
static void below_loose_soil_a_layer_is_what_it_was(void **state)
{
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 1}};
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (int kind = 0; kind < 2; kind++) {
			struct soil_numbers below[2];
			struct bed beds[2];
			const double thick = pairs[n].thickness, step = thick / 200, rut = (kind == 0 ? 0.5 : 0.8) * thick, came = 0.3 * thick;
			struct soil_motion motions[2];
			double worst = 0;
			for (int b = 0; b < 2; b++) {
				lay(&beds[b], &pairs[n], 0.02, 50, 0, 0, &below[b]);
				bed_loosen(&beds[b], LOOSENING, 0);
				motions[b] = stand(&beds[b], &plate, 0.503, 0.491, 0, 0.3);
				press_and_raise(&beds[b], &motions[b], rut, step);
			}
			int32_t lowest = 0;
			for (size_t k = 0; k < beds[0].posts; k++)
				lowest = beds[0].planes.offset[k] < lowest ? beds[0].planes.offset[k] : lowest;
			const double floor = -lattice_offset_metres(lowest), surface = floor - came;
			bed_fill(&beds[1], came);
			for (int i = 1; i < 20; i++) {
				/* In the loose soil, then in the floor. From the second step on the post remembers both. */
				const double z = i < 10 ? surface + came * 0.09 * i : floor + (0.98 * thick - floor) * 0.1 * (i - 9);
				double forces[2];
				for (int b = 0; b < 2; b++) {
					motions[b] = stand(&beds[b], &plate, 0.503, 0.491, z, 0.3);
					forces[b] = bed_press(&beds[b], &motions[b], 0).forces.force[2];
				}
				const struct soil_numbers *soil = &beds[1].law.soils[0];
				const double own = fmin((1 - LOOSENING) * reference_bekker(soil, 0.2, z - surface), soil->elastic_stiffness * (z - surface));
				const double firm = fmin(own, layered(soil, 0.2, 0.2, floor + z - surface)) * 0.04;
				if (i < 10)
					assert_near(forces[1], firm, 0.005 * firm + 0.2);
				else if (forces[0] > 1.01 * firm)
					worst = support_most(worst, fabs(forces[1] / forces[0] - 1));
			}
			print_message("%s over %s: the floor below loose soil is off by at most %.3f %%\n", pairs[n].upper, pairs[n].below, 100 * worst);
			assert_true(worst < 0.003);
			for (size_t k = 0; k < beds[1].posts; k++)
				assert_true(pairs[n].below[0] != '\0' || beds[1].planes.offset[k] >= -lattice_offset(thick));
			bed_finish(&beds[0]);
			bed_finish(&beds[1]);
		}
}

/* As layers_give_back_no_more_than_they_take, on a layer with a rut into which soil came. */
static void loose_soil_on_a_layer_gives_back_no_more_than_it_takes(void **state)
{
	static const struct soil_shape shapes[] = {{.kind = SOIL_BOX, .size = {0.3, 0.3, 0.3}}, {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, {.kind = SOIL_SPHERE, .radius = 0.2}};
	for (size_t n = 0; n < COUNT(pairs); n++)
		for (size_t i = 0; i < COUNT(shapes); i++) {
			struct soil_numbers below;
			struct bed bed;
			double before = 0, most_force = 0, gain = 0;
			lay(&bed, &pairs[n], 0.03125, 64, 0, 0, &below);
			bed_loosen(&bed, LOOSENING, 0);
			const double step = pairs[n].thickness / 160;
			struct soil_motion motion = stand(&bed, &shapes[i], 0.98, 0.97, 0, 0);
			motion.hosted = true;
			motion.stamped = 1;
			press_and_raise(&bed, &motion, 0.45 * pairs[n].thickness, step);
			bed_fill(&bed, 0.3 * pairs[n].thickness);
			for (int round = 1; round <= 6; round++)
				for (int again = 0; again < 2; again++) {
					const struct worked w = go_down_and_up(&bed, &motion, step, 38 + round * 19, &before, &most_force);
					gain = support_most(gain, (w.given - w.taken) / w.taken);
					if (again == 1 && i == 0)
						assert_near(w.given, w.taken, 0.02 * w.taken);
				}
			print_message("loose on %s over %s, shape %zu: gains at most %.4f %%\n", pairs[n].upper, pairs[n].below, i, 100 * gain);
			assert_true(before < 2e-3 * most_force);
			assert_true(gain < 1e-3);
			bed_finish(&bed);
		}
}

TEST_PROGRAM(layers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_bear_what_the_formula_says),
		cmocka_unit_test(loads_sink_plates_as_the_formula_says),
		cmocka_unit_test(pressure_grows_evenly),
		cmocka_unit_test(no_wheel_comes_through_a_layer_to_rigid_ground),
		cmocka_unit_test(a_wheel_bears_the_integral_of_the_formula),
		cmocka_unit_test(no_thickness_and_an_endless_one_are_the_two_soils),
		cmocka_unit_test(thin_and_thick_layers_come_near_them),
		cmocka_unit_test(bare_rigid_ground_keeps_no_rut),
		cmocka_unit_test(layers_give_back_no_more_than_they_take),
		cmocka_unit_test(a_probe_is_what_a_contact_tells_and_its_stiffness_the_slope_of_that),
		cmocka_unit_test(laid_soil_makes_the_layer_thicker),
		cmocka_unit_test(slip_digs_no_deeper_than_rigid_ground),
		cmocka_unit_test(shear_goes_over_to_the_soil_below_as_the_layer_is_used_up),
		cmocka_unit_test(below_loose_soil_a_layer_is_what_it_was),
		cmocka_unit_test(loose_soil_on_a_layer_gives_back_no_more_than_it_takes),
	};
	return cmocka_run_group_tests_name("soil/layers", tests, NULL, NULL);
}
