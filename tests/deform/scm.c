/* The soil contact model: what plates, wheels and ruts do, against its formulas, and that nothing is lost of it. */
#include "ground.h"

static struct deform_soil named(const char *name)
{
	struct deform_soil soil;
	assert_ok(deform_soil_named(name, &soil));
	return soil;
}

static struct deform_forces forces_of(struct ground *ground, const struct deform_sweep *sweep)
{
	struct deform_sweep asked = *sweep;
	struct deform_forces forces;
	bool taken;
	asked.tag = asked.tag != 0 ? asked.tag : 1;
	ground_sweep(ground, &asked);
	assert_ok(deform_forces_begin(ground->deform));
	assert_ok(deform_forces_take(ground->deform, true, &forces, &taken));
	assert_true(taken);
	assert_int_equal(forces.tag, asked.tag);
	return forces;
}

static struct deform_sweep stand(const struct ground *ground, const struct deform_shape *shape, double x, double y, double z)
{
	struct deform_pose pose = ground_pose(ground, x, y, z);
	return (struct deform_sweep){.shape = shape, .from = pose, .to = pose};
}

/* soil-models.md 4.1: plate of 0.1 m, 20 kPa. */
static void plates_sink_as_bekker_says(void **state)
{
	static const struct {
		const char *soil;
		double sinkage; /* mm */
	} plates[] = {{"dry_sand", 19.29}, {"sandy_loam_15", 1.97}, {"lete_sand", 0.69}, {"lunar", 23.98}, {"snow_us", 211.4}};
	const struct deform_shape plate = {.kind = DEFORM_BOX, .size = {0.4, 0.1, 0.5}};
	(void)state;
	need_gpu();
	for (size_t i = 0; i < sizeof plates / sizeof *plates; i++) {
		struct ground ground;
		struct deform_soil soil = named(plates[i].soil);
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.015625,
							     .model = DEFORM_SCM, .soils = &soil});
		struct deform_sweep sweep = stand(&ground, &plate, 64.3, 64.4, 0.25 - plates[i].sinkage / 1000);
		struct deform_forces forces = forces_of(&ground, &sweep);
		double k = soil.bekker_kc / 0.1 + soil.bekker_kphi;
		print_message("%s %g Pa, posts %g; %g\n", plates[i].soil, forces.force[2] / forces.area, forces.area * 4096, forces.sinkage);
		double expected = k * pow(forces.sinkage, soil.bekker_n);
		assert_true(fabs(forces.force[2] / forces.area / expected - 1) < 1e-5);
		assert_true(fabs(forces.force[2] / forces.area - 20e3) < 150);
		ground_reset(&ground);
		sweep = stand(&ground, &plate, 64.3, 64.4, 0.25);
		sweep.load = 20e3 * forces.area;
		forces = forces_of(&ground, &sweep);
		double exact = pow(20e3 / k, 1 / soil.bekker_n);
		print_message("%s sunk %g mm, %g N of %g N; should be %g mm\n", plates[i].soil, forces.sinkage * 1e3, forces.force[2], sweep.load, exact * 1e3);
		ground_finish(&ground);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(plates_sink_as_bekker_says),
	};
	return cmocka_run_group_tests_name("deform/scm", tests, open_gpu, close_gpu);
}
