/*
 * Faces: soil that presses on a body from every side as it slides. The oracle is 3D-RFT in doubles, by angles (faces_oracle.h), over the body's facets in level
 * ground; what of them presses, and from where depth counts, is written down here once more.
 */
#include "bed.h"
#include "faces_oracle.h"
#include "../support/near.h"
#include "soil/faces/wedge.h"
#include "../support/program.h"

#define SIDE 192
#define XI_SHARE 3.0  /* a body is narrow if it is less wide than so many times its depth */

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.1};
static const struct soil_shape bars = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.1, .grousers = 24, .grouser_height = 0.02, .grouser_thickness = 0.003};
static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.03, 0.06, 0.6}};

static struct bed bed_of(double spacing, bool faces)
{
	struct bed bed;
	struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, spacing, SIDE, 0, 0);
	bed.law.faces = faces;
	return bed;
}

/* A straight drive at a depth. heading, yaw: of the way, and of the body; rad. turn: rad about a wheel's axle for each metre. */
struct drive {
	const struct soil_shape *shape;
	double heading, yaw, reach, depth, turn, x, y;
};

/* Goes `way` in steps of half a post, and returns the motion of the last one, whose contact was not made. */
static struct soil_motion driven(struct bed *bed, const struct drive *d, double way)
{
	const double step = 0.5 * bed->law.spacing, middle = SIDE / 2 * bed->law.spacing, c = cos(d->heading), s = sin(d->heading);
	const int steps = (int)ceil(way / step);
	struct soil_trend trend = {.whole = {.ran = 0}};
	struct soil_motion motion = {.shape = d->shape};
	for (int i = 0; i <= steps; i++) {
		const double from = (fmax(i - 1, 0) - steps) * step, to = (i - steps) * step, z = bed->height + d->reach - d->depth;
		const struct bed_state a = bed_state(middle + d->x + from * c, middle + d->y + from * s, z, d->yaw, 0, 0);
		const struct bed_state b = bed_state(middle + d->x + to * c, middle + d->y + to * s, z, d->yaw, 0, 0);
		motion = bed_motion(d->shape, &a, &b, NULL);
		motion.turned = i > 0 ? d->turn * step : 0;
		motion.trend = trend;
		if (i < steps) {
			bed_press(bed, &motion, 0);
			trend = soil_trend_after(&bed->law, &motion);
		}
	}
	return motion;
}

static struct soil_forces forces_of(double spacing, bool faces, const struct drive *d, double way)
{
	struct bed bed = bed_of(spacing, faces);
	const struct soil_motion motion = driven(&bed, d, way);
	const struct soil_forces forces = bed_feel(&bed, &motion, 0);
	bed_finish(&bed);
	return forces;
}

static double ramp(double value)
{
	return fmin(fmax(value, 0), 1);
}

/* The reference: a body that slides whole, along its way, in level ground of dry sand. Its sole is level ground's from its front half alone. */
static void reference(const struct drive *d, double size, double force[3])
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	const struct faces_oracle_law law = {.xi = soil_face_strength(&soil), .mu = tan(2 * soil.friction_angle / 3), .lift = 0.55, .helps = 0.02};
	const double c = cos(d->heading), s = sin(d->heading);
	struct soil_facets facets = {0};
	double axes[3][3], low = 1e9, high = -1e9;
	soil_axes(d->yaw, 0, 0, 0, axes);
	assert_ok(soil_facets_of(d->shape, size, &facets));
	struct faces_oracle_facet *placed = mem_calloc(facets.count, sizeof *placed);
	assert_non_null(placed);
	const double centre[3] = {0, 0, d->reach - d->depth};
	faces_oracle_place(&facets, (const double(*)[3])axes, centre, placed);
	for (size_t i = 0; i < facets.count; i++)
		if (placed[i].at[2] < 0 && facets.area[i] > 0) {
			const double aside = c * placed[i].at[1] - s * placed[i].at[0];
			low = fmin(low, aside);
			high = fmax(high, aside);
		}
	const double share = (high - low) / (XI_SHARE * d->depth), narrow = 1 / (1 + pow(share, 4));
	struct soil_wedge wedge = {0};
	soil_wedge_of(soil.friction_angle, 2 * soil.friction_angle / 3, &wedge);
	const double by_weight = soil.unit_weight * (double)wedge.weight[WEDGE_RAKES - 1] / 0.19185;
	force[0] = force[1] = force[2] = 0;
	for (size_t i = 0; i < facets.count; i++) {
		const struct faces_oracle_facet *f = &placed[i];
		const double into = f->normal[0] * c + f->normal[1] * s, along = f->at[0] * c + f->at[1] * s, depth = -f->at[2], sole = fmax(-f->normal[2], 0);
		const bool under = facets.kind[i] == FACET_UNDER;
		const double presses = under ? ramp(1 + into / 0.1) * (along > 0 || into > 0.1 ? 1 : 0) : ramp(into / 0.1);
		double alpha[3];
		if (depth <= 0 || presses <= 0 || !(f->area > 0) || f->normal[2] > 1e-6)
			continue;
		/* The oracle has no force where a facet does not move into the soil. */
		const double least = fmax(1e-6 - into, 0), moves[3] = {c + least * f->normal[0], s + least * f->normal[1], least * f->normal[2]};
		faces_oracle_alpha(&law, f->normal, moves, alpha);
		const double wall = fmax(narrow * law.xi + (1 - narrow) * by_weight, by_weight) * depth, pressure = sole * law.xi * depth + (1 - sole) * wall;
		for (int k = 0; k < 3; k++)
			force[k] += presses * pressure * f->area * alpha[k];
	}
	mem_free(placed);
	soil_facets_finish(&facets);
}

static void a_plate_that_is_pushed_sideways_feels_the_theory(void **state)
{
	static const double yaws[] = {0, 30, 60};
	for (int k = 0; k < 3; k++)
		for (double spacing = 0.016; spacing > 0.005; spacing /= 2) {
			const struct drive d = {&plate, 0.2, 0.2 + yaws[k] * DEGREES, 0.3, 0.15, 0, 0.003, 0.001};
			const struct soil_forces forces = forces_of(spacing, true, &d, 0.15);
			double wanted[3];
			reference(&d, 0.004, wanted);
			print_message("plate yawed by %g degrees, posts of %g mm: %.2f %.2f %.2f N, reference %.2f %.2f %.2f N\n", yaws[k], spacing * 1e3, forces.force[0], forces.force[1],
				      forces.force[2], wanted[0], wanted[1], wanted[2]);
			assert_near(forces.force[0], wanted[0], 0.05 * hypot(wanted[0], wanted[1]));
			assert_near(forces.force[1], wanted[1], 0.05 * hypot(wanted[0], wanted[1]));
		}
}

static void a_locked_wheel_feels_the_theory(void **state)
{
	static const double spacings[] = {0.016, 0.008, 0.004}, angles[] = {0, 35, 90};
	for (int k = 0; k < 3; k++)
		for (int n = 0; n < 3; n++) {
			const struct drive d = {&wheel, 0.3, 0.3 - angles[k] * DEGREES, 0.25, 0.06, 0, 0.001, 0.002};
			const struct soil_forces forces = forces_of(spacings[n], true, &d, 0.2);
			double wanted[3];
			reference(&d, 0.004, wanted);
			print_message("locked wheel at %g degrees, posts of %g mm: %.2f %.2f %.2f N, reference %.2f %.2f %.2f N\n", angles[k], spacings[n] * 1e3, forces.force[0],
				      forces.force[1], forces.force[2], wanted[0], wanted[1], wanted[2]);
			for (int i = 0; i < 3; i++)
				assert_near(forces.force[i], wanted[i], (n == 0 ? 0.06 : 0.03) * hypot(hypot(wanted[0], wanted[1]), wanted[2]));
		}
}

static void headings_and_places_do_not_show(void **state)
{
	double first[3] = {0}, most = 0;
	for (int k = 0; k < 10; k++) {
		const double heading = 0.628 * k + 0.05;
		const struct drive d = {&wheel, heading, heading - 0.4, 0.25, 0.05, 1.5, 0.0007 * k, 0.0011 * k};
		const struct soil_forces f = forces_of(0.008, true, &d, 0.15);
		const double c = cos(heading), s = sin(heading), own[3] = {c * f.force[0] + s * f.force[1], c * f.force[1] - s * f.force[0], f.force[2]};
		for (int i = 0; i < 3; i++) {
			first[i] = k == 0 ? own[i] : first[i];
			most = support_most(most, fabs(own[i] - first[i]) / hypot(hypot(first[0], first[1]), first[2]));
		}
	}
	print_message("ten headings and places: within %.2f %% of the force\n", most * 100);
	assert_true(most < 0.02);
}

static void a_wheel_that_rolls_straight_keeps_its_forces(void **state)
{
	static const double slips[] = {0, 0.2, 0.6};
	for (int k = 0; k < 3; k++) {
		const struct drive d = {&wheel, 0.3, 0.3, 0.25, 0.04, 4 / (1 - slips[k]), 0, 0};
		const struct soil_forces with = forces_of(0.01, true, &d, 0.2), without = forces_of(0.01, false, &d, 0.2);
		for (int i = 0; i < 3; i++)
			assert_near(with.force[i], without.force[i], 0.002 * without.force[2]);
	}
}

static void a_body_that_sinks_straight_keeps_its_bits(void **state)
{
	struct bed on = bed_of(0.01, true), off = bed_of(0.01, false);
	const double middle = SIDE / 2 * 0.01;
	struct bed_state last = bed_state(middle, middle, on.height + 0.3, 0.3, 0.05, 0);
	struct soil_trend trend = {.whole = {.ran = 0}};
	for (int i = 1; i <= 20; i++) {
		const struct bed_state now = bed_state(middle, middle, on.height + 0.3 - 0.002 * i, 0.3, 0.05, 0);
		struct soil_motion motion = bed_motion(&plate, &last, &now, NULL);
		motion.trend = trend;
		const struct soil_forces a = bed_press(&on, &motion, 0).forces, b = bed_press(&off, &motion, 0).forces;
		trend = soil_trend_after(&on.law, &motion);
		assert_memory_equal(a.force, b.force, sizeof a.force);
		last = now;
	}
	bed_finish(&on);
	bed_finish(&off);
}

static void a_probe_tells_what_a_contact_tells(void **state)
{
	const struct drive drives[] = {{&wheel, 0.3, 0.9, 0.25, 0.05, 2, 0, 0}, {&plate, 1, 1.2, 0.3, 0.1, 0, 0, 0}, {&bars, 0.3, 0.3, 0.27, 0.08, 12, 0, 0}, {&bars, 0.3, 0.9, 0.27, 0.08, 12, 0, 0}};
	for (size_t k = 0; k < COUNT(drives); k++) {
		struct bed bed = bed_of(0.01, true);
		bed.law.slip_sinkage = drives[k].shape == &bars ? 1.35 : 0;
		const struct soil_motion motion = driven(&bed, &drives[k], 0.1);
		const struct soil_probed probed = bed_probe(&bed, &motion);
		const struct soil_forces forces = bed_feel(&bed, &motion, 0);
		assert_memory_equal(probed.force, forces.force, sizeof forces.force);
		assert_memory_equal(probed.moment, forces.moment, sizeof forces.moment);
		bed_finish(&bed);
	}
}

/* A force that soil presses from aside is against the motion, and that of one that turns back goes. */
static void a_plate_that_turns_back_is_let_go(void **state)
{
	struct bed bed = bed_of(0.008, true);
	const struct drive d = {&plate, 0, 0, 0.3, 0.15, 0, 0, 0};
	struct soil_motion motion = driven(&bed, &d, 0.1);
	const double pushed = -bed_press(&bed, &motion, 0).forces.force[0];
	struct soil_trend trend = soil_trend_after(&bed.law, &motion);
	double gives = 0;
	struct soil_pose at = motion.to;
	for (int i = 0; i < 40; i++) {
		struct soil_motion back = motion;
		back.from = at;
		back.to.x = at.x - lattice_offset(0.0005);
		back.beyond[0] = back.beyond[1] = back.beyond[2] = 0;
		back.trend = trend;
		const double force = bed_press(&bed, &back, 0).forces.force[0];
		trend = soil_trend_after(&bed.law, &back);
		gives -= fmin(force, 0) * 0.0005;
		at = back.to;
	}
	print_message("pushed with %.1f N; on the way back it gives %.4f J, the way in of K costs %.2f J\n", pushed, gives, pushed * 0.02);
	assert_true(pushed > 20);
	assert_true(gives < 0.05 * pushed * 0.02);
	bed_finish(&bed);
}

static void straight_motions_add_up(void **state)
{
	struct bed bed = bed_of(0.01, true);
	const struct bed_state a = bed_state(0.5, 0.5, bed.height + 0.2, 0.3, 0, 0), b = bed_state(0.53, 0.51, bed.height + 0.199, 0.3, 0, 0);
	struct soil_motion whole = bed_motion(&wheel, &a, &b, (const double[3]){-0.03, 0.09, 0.0});
	struct soil_trend parts = {.whole = {.ran = 0}};
	const struct soil_trend once = soil_trend_after(&bed.law, &whole);
	for (int i = 0; i < 10; i++) {
		struct soil_motion part = whole;
		for (int k = 0; k < 3; k++)
			part.beyond[k] = 0;
		part.from = whole.from;
		part.to = whole.to;
		part.to.x = whole.from.x + (whole.to.x - whole.from.x) / 10;
		part.to.y = whole.from.y + (whole.to.y - whole.from.y) / 10;
		part.to.z = whole.from.z + (whole.to.z - whole.from.z) / 10;
		part.turned = whole.turned / 10;
		part.trend = parts;
		parts = soil_trend_after(&bed.law, &part);
	}
	for (int k = 0; k < 3; k++) {
		assert_near(parts.whole.way[k], once.whole.way[k], 1e-3);
		assert_near(parts.whole.turn[k], once.whole.turn[k], 1e-3);
	}
	bed_finish(&bed);
}

/* What bars scoop: on a steady way, and on the spot, where a turn takes 2 pi times half of the bars' height. However it is cut into motions. */
static void bars_scoop_what_they_carry(void **state)
{
	struct bed bed = bed_of(0.01, true);
	bed.law.slip_sinkage = 1.35;
	const double reach = 0.27, spins = 4 * reach;
	for (int spot = 0; spot < 2; spot++)
		for (int parts = 1; parts <= 100; parts *= 10) {
			struct soil_trend trend = {.whole = {.ran = 0}};
			const double way = spot != 0 ? 0 : 5, wanted = spot != 0 ? 2 * M_PI * 0.01 : 0.01 * (spins - 1);
			for (int i = 0; i < parts; i++) {
				const struct bed_state a = bed_state(0.5 + way * i / parts, 0.5, bed.height + 0.2, 0, 0, 0), b = bed_state(0.5 + way * (i + 1) / parts, 0.5, bed.height + 0.2, 0, 0, 0);
				struct soil_motion motion = bed_motion(&bars, &a, &b, NULL);
				motion.turned = (spot != 0 ? 2 * M_PI : 20) / parts;
				motion.trend = trend;
				trend = soil_trend_after(&bed.law, &motion);
			}
			print_message("%s in %d motions: %.3f mm scooped, reference %.3f mm\n", spot != 0 ? "on the spot" : "5 m", parts, trend.scooped * 1e3, wanted * 1e3);
			assert_near(trend.scooped, wanted, 1e-4 * wanted);
		}
	bed_finish(&bed);
}

TEST_PROGRAM(faces)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_that_is_pushed_sideways_feels_the_theory),
		cmocka_unit_test(a_locked_wheel_feels_the_theory),
		cmocka_unit_test(headings_and_places_do_not_show),
		cmocka_unit_test(a_wheel_that_rolls_straight_keeps_its_forces),
		cmocka_unit_test(a_body_that_sinks_straight_keeps_its_bits),
		cmocka_unit_test(a_probe_tells_what_a_contact_tells),
		cmocka_unit_test(a_plate_that_turns_back_is_let_go),
		cmocka_unit_test(straight_motions_add_up),
		cmocka_unit_test(bars_scoop_what_they_carry),
	};
	return cmocka_run_group_tests_name("soil/faces", tests, NULL, NULL);
}
