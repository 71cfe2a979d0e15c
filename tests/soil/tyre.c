/* Tyres: a carcass in series with the soil, beside closed forms of its two modes; and what no carcass may change. */
#include "bed.h"

#include "../support/program.h"

static const struct soil_shape rigid = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3};
static const double nowhere[3] = {0, 0, 0};

static struct soil_shape tyre_of(double stiffness, double load, double pressure, double damping, struct soil_tyre_patch *patch)
{
	struct soil_shape shape = rigid;
	const struct soil_tyre_told told = {stiffness, load, pressure, damping};
	assert_ok(soil_tyre_set("tyre", &told, &shape, patch));
	return shape;
}

/* Rigid ground, and soil of closed forms: no cohesion, no damping, hardly elastic. */
static struct soil_numbers hard(void)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.bekker_kc = soil.damping = soil.cohesion = 0;
	soil.bekker_kphi = soil.elastic_stiffness = 1e9;
	soil.bekker_n = 1;
	return soil;
}

static struct soil_numbers plain(const char *name)
{
	struct soil_numbers soil = bed_soil(name);
	soil.damping = 0;
	soil.elastic_stiffness = 4e8;
	return soil;
}

/* Rolls a wheel under a load until what was below it is behind. turned: rad for each metre of way; speed: m/s, of what damps. Gives means of the last posts. */
static struct soil_forces rolled(struct bed *bed, const struct soil_shape *shape, double load, double turned, double speed, bool rubs)
{
	enum { LAST = 16 };
	const double spacing = bed->law.spacing, y = bed->planes.rect.y1 / 2 * spacing;
	const int steps = (int)(1.0 / spacing);
	struct bed_state at = bed_state(0.8, y, bed->height + shape->radius, 0, 0, 0);
	struct soil_forces mean = {.z = 0};
	for (int i = 0; i < steps; i++) {
		struct bed_state to = at;
		to.at[0] += i == 0 ? 0 : 0.875 * spacing;
		const double turn[3] = {0, i == 0 ? 0 : 0.875 * spacing * turned, 0};
		struct soil_motion motion = bed_motion(shape, &at, &to, turn);
		motion.interface = (struct soil_interface){.has_friction = !rubs, .has_adhesion = !rubs};
		motion.load = load;
		motion.linear[0] = speed;
		motion.angular[1] = speed * turned;
		const struct soil_forces forces = bed_press(bed, &motion, 0).forces;
		at = to;
		at.at[2] = lattice_offset_metres(forces.z);
		if (i < steps - LAST)
			continue;
		for (int k = 0; k < 3; k++) {
			mean.force[k] += forces.force[k] / LAST;
			mean.moment[k] += forces.moment[k] / LAST;
		}
		mean.sinkage += forces.sinkage / LAST;
		mean.area += forces.area / LAST;
		mean.z += forces.z / LAST;
	}
	return mean;
}

/* What presses a tyre by so much onto rigid level ground, N: over its chord and its circle's segment. */
static double flat_load(const struct soil_shape *shape, double pressed)
{
	const double r = shape->radius, half = sqrt(pressed * (2 * r - pressed)), segment = r * r * asin(half / r) - half * (r - pressed);
	return shape->width * (2 * half * shape->tyre.pressure + segment * shape->tyre.stiffness);
}

static void rigid_ground_presses_a_tyre_as_its_closed_form_says(void **state)
{
	static const double shares[] = {0.25, 0.5, 1, 2, 4}, spacings[] = {0.03, 0.013};
	struct soil_tyre_patch patch;
	const struct soil_numbers soil = hard();
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, &patch);
	assert_near(patch.deflection, 0.02, 1e-12);
	assert_near(flat_load(&shape, 0.02), 5000, 1e-6);
	assert_near((flat_load(&shape, 0.0201) - flat_load(&shape, 0.0199)) / 0.0002, 250e3, 0.02 * 250e3);
	for (size_t s = 0; s < COUNT(spacings); s++) {
		struct bed bed;
		bed_init(&bed, &soil, spacings[s], (int)(2.6 / spacings[s]), 0, 0);
		for (size_t i = 0; i < COUNT(shares); i++) {
			const struct bed_state at = bed_state(1.3, 1.3, bed.height + 0.5, 0, 0, 0);
			struct soil_motion motion = bed_motion(&shape, &at, &at, nowhere);
			bed_reset(&bed);
			motion.load = 5000 * shares[i];
			const struct soil_forces forces = bed_press(&bed, &motion, 0).forces;
			const double pressed = bed.height + 0.5 - lattice_offset_metres(forces.z) - forces.sinkage, load = flat_load(&shape, pressed);
			print_message("%g m, %g N: pressed by %.3f mm, closed form %.1f N, sinks %.4f mm\n", spacings[s], motion.load, pressed * 1e3, load, forces.sinkage * 1e3);
			assert_near(forces.force[2], motion.load, 1e-3 * motion.load);
			assert_near(load, motion.load, 0.015 * motion.load);
			assert_near(forces.area, shape.width * 2 * sqrt(pressed * (1 - pressed)), 0.01 * forces.area);
		}
		const struct soil_forces level = rolled(&bed, &shape, 5000, 1 / 0.48, 0, false);
		assert_near(level.force[0], 0, 1);
		assert_near(level.moment[1], 0, 1);
		bed_finish(&bed);
	}
}

/* With little stiffness beside its pressure it is Wong's: p = W / (b l) sinks it by (p / k)^(1/n), and b k z^(n+1) / (n+1) holds it. Where p sinks the ground
 * far, soil ahead of the patch bears, too. */
static void firm_ground_flattens_a_tyre_as_wong_says(void **state)
{
	static const char *const soils[] = {"dry_sand", "lete_sand", "upland_loam_51", "clayey_38"};
	for (size_t n = 0; n < COUNT(soils); n++) {
		struct soil_tyre_patch patch;
		const struct soil_numbers soil = plain(soils[n]);
		tyre_of(250e3, 5000, NAN, NAN, &patch);
		const struct soil_shape shape = tyre_of(250e3, 5000, SOIL_TYRE_PRESSURE * patch.pressure, NAN, NULL), usual = tyre_of(250e3, 5000, NAN, NAN, NULL);
		const double k = soil.bekker_kc / shape.width + soil.bekker_kphi, z = pow(patch.pressure / k, 1 / soil.bekker_n);
		const double resistance = shape.width * k * pow(z, soil.bekker_n + 1) / (soil.bekker_n + 1);
		struct bed bed;
		bed_init(&bed, &soil, 0.015625, 166, 0, 0);
		const struct soil_forces flat = rolled(&bed, &shape, 5000, 1 / 0.48, 0, false);
		bed_reset(&bed);
		const struct soil_forces half = rolled(&bed, &usual, 5000, 1 / 0.48, 0, false);
		bed_reset(&bed);
		const struct soil_forces stiff = rolled(&bed, &rigid, 5000, 1 / 0.5, 0, false);
		print_message("%s: %.2f mm, %.1f N, %.4f m2; Wong %.2f mm, %.1f N, %.4f m2; half the pressure %.2f mm, %.1f N; rigid %.2f mm, %.1f N, %.4f m2\n", soils[n], flat.sinkage * 1e3,
			      -flat.force[0], flat.area, z * 1e3, resistance, patch.length * shape.width, half.sinkage * 1e3, -half.force[0], stiff.sinkage * 1e3, -stiff.force[0], stiff.area);
		assert_near(flat.sinkage, z, 0.08 * z);
		assert_near(-flat.force[0], resistance, 0.1 * resistance);
		assert_true(half.sinkage < 0.8 * stiff.sinkage && half.force[0] > 0.8 * stiff.force[0] && half.area > stiff.area);
		bed_finish(&bed);
	}
}

/* A carcass that keeps its shape under all of the soil's stress has the bits of a rigid rim. Softer ones differ from it by less, the stiffer they are. */
static void a_stiff_tyre_is_a_rigid_wheel(void **state)
{
	static const double stiffnesses[] = {4e6, 16e6, 64e6};
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct bed bed;
	bed_init(&bed, &soil, 0.02, 130, 0, 0);
	const struct soil_forces wanted = rolled(&bed, &rigid, 5000, 2.4, 0.5, true);
	double before = INFINITY;
	for (size_t i = 0; i < COUNT(stiffnesses); i++) {
		struct soil_tyre_patch patch;
		tyre_of(stiffnesses[i], 5000, NAN, NAN, &patch);
		const struct soil_shape shape = tyre_of(stiffnesses[i], 5000, 0.1 * patch.pressure, NAN, NULL);
		bed_reset(&bed);
		const struct soil_forces got = rolled(&bed, &shape, 5000, 2.4, 0.5, true);
		const double off = fabs(got.sinkage - wanted.sinkage);
		print_message("%g N/m: sinkage %.3f mm (rigid %.3f), pull %.1f N (%.1f)\n", stiffnesses[i], got.sinkage * 1e3, wanted.sinkage * 1e3, got.force[0], wanted.force[0]);
		assert_true(off < 0.4 * before);
		before = off;
	}
	const struct soil_shape shape = tyre_of(100e6, 5000, NAN, NAN, NULL);
	bed_reset(&bed);
	const struct soil_forces got = rolled(&bed, &shape, 5000, 2.4, 0.5, true);
	assert_memory_equal(&got, &wanted, sizeof got);
	bed_finish(&bed);
}

/* Work of pressing a tyre down and raising it again, J: what was taken and given back. */
static void press_and_raise(struct bed *bed, const struct soil_shape *shape, int down, double *taken, double *given)
{
	const int step = 256;
	double before = 0, x = 1.31;
	*taken = *given = 0;
	struct bed_state at = bed_state(x, x, bed->height + shape->radius, 0, 0, 0);
	for (int i = 0; i < 2 * down + 40; i++) {
		struct bed_state to = at;
		const double by = (i < down ? step : -step) * 0x1p-20;
		to.at[2] -= by;
		struct soil_motion motion = bed_motion(shape, &at, &to, nowhere);
		motion.stamped = 1;
		const double force = bed_press(bed, &motion, 0).forces.force[2], work = 0.5 * (force + before) * by;
		*(work > 0 ? taken : given) += fabs(work);
		before = force;
		at = to;
	}
	assert_near(before, 0, 1e-9);
}

static void a_tyre_gives_back_what_bent_it_and_no_more(void **state)
{
	static const double spacings[] = {0.0625, 0.03125, 0.015625};
	const struct soil_numbers soils[] = {hard(), bed_soil("dry_sand"), bed_soil("clayey_38")};
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, NULL);
	for (size_t n = 0; n < COUNT(soils); n++)
		for (size_t s = 0; s < COUNT(spacings); s++) {
			struct bed bed;
			bed_init(&bed, &soils[n], spacings[s], (int)(2.62 / spacings[s]), 0, 0);
			double taken, given, again, back;
			press_and_raise(&bed, &shape, 80 + 80 * (n > 0), &taken, &given);
			press_and_raise(&bed, &shape, 80 + 80 * (n > 0), &again, &back);
			print_message("soil %zu, %g m: took %.3f J, gave back %.3f; again %.3f, %.3f\n", n, spacings[s], taken, given, again, back);
			assert_true(given < 1.001 * taken && back < 1.001 * again && given > 0);
			if (n == 0)
				assert_near(given, taken, 0.005 * taken);
			bed_finish(&bed);
		}
}

static void a_parked_tyre_keeps_its_bits(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, NULL);
	struct bed bed;
	bed_init(&bed, &soil, 0.02, 130, 0, 0);
	rolled(&bed, &shape, 5000, 2.2, 0, true);
	struct bed_state at = bed_state(1.3125, 1.3125, bed.height + 0.4375, 0.3, 0, 0); /* whole units */
	struct soil_motion motion = bed_motion(&shape, &at, &at, nowhere);
	bed_press(&bed, &motion, 0);
	const struct soil_forces first = bed_press(&bed, &motion, 0).forces;
	const size_t bytes = bed.posts * sizeof(int32_t);
	int32_t *offset = mem_calloc(bed.posts, sizeof *offset), *sinkage = mem_calloc(bed.posts, sizeof *sinkage);
	assert_true(offset != NULL && sinkage != NULL);
	memcpy(offset, bed.planes.offset, bytes);
	memcpy(sinkage, bed.planes.sinkage, bytes);
	for (int i = 0; i < 50; i++) {
		const struct soil_forces now = bed_press(&bed, &motion, 0).forces;
		assert_memory_equal(&now, &first, sizeof now);
	}
	assert_memory_equal(offset, bed.planes.offset, bytes);
	assert_memory_equal(sinkage, bed.planes.sinkage, bytes);
	mem_free_all(offset, sinkage);
	bed_finish(&bed);
}

/* What a probe tells of the stiffness is about how the force changes, or a little more where the patch grows less than on rigid ground. */
static void a_probe_of_a_tyre_knows_its_stiffness(void **state)
{
	const struct soil_numbers soils[] = {hard(), bed_soil("dry_sand")};
	static const double deep[] = {0.02, 0.05};
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, NULL);
	for (size_t n = 0; n < COUNT(soils); n++) {
		struct bed bed;
		bed_init(&bed, &soils[n], 0.02, 130, 0, 0);
		double forces[3], stiffness = 0;
		for (int i = 0; i < 3; i++) {
			const struct bed_state at = bed_state(1.3, 1.3, bed.height + 0.5 - deep[n] - (i - 1) * 1e-4, 0, 0, 0);
			struct soil_motion motion = bed_motion(&shape, &at, &at, nowhere);
			motion.linear[2] = -1e-6;
			const struct soil_probed probed = bed_probe(&bed, &motion);
			forces[i] = probed.force[2];
			stiffness = i == 1 ? -probed.stiffness[2][2] : stiffness;
		}
		const double wanted = (forces[2] - forces[0]) / 2e-4;
		print_message("soil %zu: %.1f kN/m, by differences %.1f\n", n, stiffness / 1e3, wanted / 1e3);
		assert_true(stiffness > 0.97 * wanted && stiffness < 1.25 * wanted);
		bed_finish(&bed);
	}
}

/* On rigid ground: by the damping alone, as the carcass is bent ahead and springs back behind. Its moment is that of c v x / R over the patch. */
static void damping_holds_a_tyre_that_rolls_on_rigid_ground(void **state)
{
	const struct soil_numbers soil = hard();
	const double c = 2e3, speed = 2;
	struct soil_tyre_patch patch;
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, c, &patch);
	struct bed bed;
	bed_init(&bed, &soil, 0.01, 260, 0, 0);
	const struct soil_forces got = rolled(&bed, &shape, 5000, 1 / 0.48, speed, false);
	const double half = patch.length / 2, wanted = shape.width * shape.tyre.damping * speed * 2 / 3 * half * half * half / shape.radius / shape.radius;
	print_message("%.2f N m about the axle and %.2f N, wanted %.2f N\n", got.moment[1], got.force[0], wanted);
	assert_near(-got.force[0] - got.moment[1] / 0.48, wanted, 0.1 * wanted);
	bed_finish(&bed);
}

/* It rolls freely about its loaded radius: there it neither pulls nor brakes on rigid ground. */
static void a_tyre_rolls_about_its_loaded_radius(void **state)
{
	const struct soil_numbers soil = hard();
	const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, NULL);
	struct bed bed;
	double before = -INFINITY;
	bed_init(&bed, &soil, 0.02, 130, 0, 0);
	for (int i = -2; i <= 2; i++) {
		bed_reset(&bed);
		const struct soil_forces got = rolled(&bed, &shape, 5000, (1 + 0.02 * i) / 0.48, 0, true);
		print_message("turned %.2f: pulls %.1f N\n", 1 + 0.02 * i, got.force[0]);
		assert_true(got.force[0] > before && (i == 0 ? fabs(got.force[0]) < 50 : i < 0 ? got.force[0] < -200 : got.force[0] > 200));
		before = got.force[0];
	}
	bed_finish(&bed);
}

static void a_tyre_that_cannot_be_is_refused(void **state)
{
	struct soil_shape shape = rigid;
	const struct soil_tyre_told flat = {1e4, 5000, NAN, NAN}, blown = {250e3, 5000, 59e3, NAN};
	assert_true(soil_tyre_set("a.wheel", &flat, &shape, NULL) == STATUS_INPUT);
	assert_string_equal(failure_message(), "a.wheel: a load of 5000 N presses its tyre by 0.5 m, more than half of its radius; give a higher stiffness");
	assert_true(soil_tyre_set("a.wheel", &blown, &shape, NULL) == STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "give at most 5.3"));
	assert_true(shape.tyre.stiffness == 0);
}

TEST_PROGRAM(tyre)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(rigid_ground_presses_a_tyre_as_its_closed_form_says),
		cmocka_unit_test(firm_ground_flattens_a_tyre_as_wong_says),
		cmocka_unit_test(a_stiff_tyre_is_a_rigid_wheel),
		cmocka_unit_test(a_tyre_gives_back_what_bent_it_and_no_more),
		cmocka_unit_test(a_parked_tyre_keeps_its_bits),
		cmocka_unit_test(a_probe_of_a_tyre_knows_its_stiffness),
		cmocka_unit_test(damping_holds_a_tyre_that_rolls_on_rigid_ground),
		cmocka_unit_test(a_tyre_rolls_about_its_loaded_radius),
		cmocka_unit_test(a_tyre_that_cannot_be_is_refused),
	};
	return cmocka_run_group_tests_name("soil/tyre", tests, NULL, NULL);
}
