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

/* Rolls a wheel under a load, without friction, until what was below it is behind. Gives means of the last posts. */
static struct soil_forces towed(struct bed *bed, const struct soil_shape *shape, double load, double slip_radius, double speed)
{
	enum { LAST = 16 };
	const double spacing = bed->law.spacing, y = bed->planes.rect.y1 / 2 * spacing;
	const int steps = (int)(1.0 / spacing);
	struct bed_state at = bed_state(0.8, y, bed->height + shape->radius, 0, 0, 0);
	struct soil_forces mean = {.z = 0};
	for (int i = 0; i < steps; i++) {
		struct bed_state to = at;
		to.at[0] += i == 0 ? 0 : 0.875 * spacing;
		const double turned[3] = {0, i == 0 ? 0 : 0.875 * spacing / slip_radius, 0};
		struct soil_motion motion = bed_motion(shape, &at, &to, turned);
		motion.interface = (struct soil_interface){.has_friction = true, .has_adhesion = true};
		motion.load = load;
		motion.linear[0] = speed;
		motion.angular[1] = speed / slip_radius;
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

static void try_tyre(void **state)
{
	(void)state;
	struct soil_tyre_patch patch;
	for (double spacing = 0.04; spacing > 0.009; spacing /= 2) {
		struct bed bed;
		const struct soil_numbers soil = hard();
		bed_init(&bed, &soil, spacing, (int)(2.6 / spacing), 0, 0);
		const struct soil_shape shape = tyre_of(250e3, 5000, NAN, NAN, &patch);
		for (double load = 1250; load < 20001; load *= 2) {
			bed_reset(&bed);
			struct bed_state at = bed_state(1.3, 1.3, bed.height + 0.5, 0, 0, 0);
			struct soil_motion motion = bed_motion(&shape, &at, &at, nowhere);
			motion.load = load;
			const struct soil_forces f = bed_press(&bed, &motion, 0).forces;
			const double pressed = bed.height + 0.5 - lattice_offset_metres(f.z);
			print_message("%g m, %g N: %.2f mm (patch %.2f mm, %.1f kPa) k %.1f kN/m, area %.4f (%.4f) sunk %.4f mm\n", spacing, load, pressed * 1000, patch.deflection * 1000, patch.pressure / 1000,
				      load / pressed / 1000, f.area, 0.3 * 2 * sqrt(pressed * (1 - pressed)), f.sinkage * 1000);
		}
		bed_reset(&bed);
		const struct soil_forces r = towed(&bed, &shape, 5000, 0.48, 0);
		print_message("rolled: %.2f N, %.2f N, My %.2f, area %.4f, %.3f mm\n", r.force[0], r.force[2], r.moment[1], r.area, (bed.height + 0.5 - lattice_offset_metres(r.z)) * 1000);
		bed_finish(&bed);
	}
	static const char *const names[] = {"dry_sand", "lete_sand", "upland_loam_51", "clayey_38", "lunar"};
	for (int n = 0; n < 5; n++)
	for (double spacing = 0.03125; spacing > 0.015; spacing /= 2) {
		const struct soil_numbers soil = plain(names[n]);
		for (double pressure = 0.5; pressure < 1; pressure += 0.4) {
			struct bed bed;
			bed_init(&bed, &soil, spacing, (int)(2.6 / spacing), 0, 0);
			tyre_of(250e3, 5000, NAN, NAN, &patch);
			const struct soil_shape shape = tyre_of(250e3, 5000, pressure * patch.pressure, NAN, &patch);
			const double k = soil.bekker_kc / 0.3 + soil.bekker_kphi, z = pow(patch.pressure / k, 1 / soil.bekker_n), zr = pow(3 * 5000 / (0.3 * k * (3 - soil.bekker_n)), 2 / (2 * soil.bekker_n + 1));
			const double R = 0.3 * k * pow(z, soil.bekker_n + 1) / (soil.bekker_n + 1), Rr = 0.3 * k * pow(zr, soil.bekker_n + 1) / (soil.bekker_n + 1);
			const struct soil_forces r = towed(&bed, &shape, 5000, 0.48, 0);
			bed_reset(&bed);
			const struct soil_forces q = towed(&bed, &rigid, 5000, 0.5, 0);
			print_message("%s %g p %.2f: %.2f mm, %.1f N, area %.4f, pressed %.2f mm My %.2f; rigid %.2f mm %.1f N, area %.4f; Wong elastic %.2f mm %.1f N area %.4f, towed rigid %.2f mm %.1f N\n", names[n], spacing, pressure,
				      r.sinkage * 1e3, -r.force[0], r.area, (bed.height + 0.5 - lattice_offset_metres(r.z)) * 1000 - r.sinkage * 1e3, r.moment[1], q.sinkage * 1e3, -q.force[0], q.area, z * 1e3, R, patch.length * 0.3, zr * 1e3, Rr);
			bed_finish(&bed);
		}
	}
}

TEST_PROGRAM(tyre)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(try_tyre),
	};
	return cmocka_run_group_tests_name("soil/tyre", tests, NULL, NULL);
}
