/* A wheel that rolls at a prescribed depth, beside the closed forms of the same law: wherever its axle lies between posts. */
#include <stdio.h>

#include "bed_gpu.h"

struct told {
	double drawbar, side, vertical, moment, area;
};

/* Rolls `way` metres from fresh ground at an angle to the posts. shift: posts. The told forces are of the last path sample. */
static struct told roll(const struct deform_soil *soil, const struct reference_rolling *wheel, double sinkage, double spacing,
			double degrees, double shift, double way)
{
	struct ground ground;
	double heading = degrees * RADIANS, c = cos(heading), s = sin(heading);
	int stations = (int)ceil(way / spacing);
	int tiles = (int)ceil(((2.6 * wheel->radius + way) / spacing + 12) / 64);
	ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = (uint32_t)tiles, .spacing = spacing, .model = DEFORM_SCM, .soils = soil,
						     .iterations = 1, .ground_normals = wheel->normals == REFERENCE_NORMALS_GROUND});
	struct deform_shape shape = {.kind = DEFORM_WHEEL, .radius = wheel->radius, .width = wheel->width};
	double x = 1.3 * wheel->radius / spacing + 4 + shift, y = 1.3 * wheel->radius / spacing + 4 + 0.7 * shift;
	struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, x, y, wheel->radius - sinkage)};
	sweep.from.yaw = heading;
	sweep.to = sweep.from;
	struct deform_forces forces = ground_forces(&ground, &sweep);
	for (int i = 1; i <= stations; i++) {
		sweep.from = sweep.to;
		sweep.to = ground_pose(&ground, x + i * c, y + i * s, wheel->radius - sinkage);
		sweep.to.yaw = heading;
		sweep.turned = wheel->turned * spacing / wheel->radius;
		forces = ground_forces(&ground, &sweep);
	}
	ground_finish(&ground);
	return (struct told){forces.force[0] * c + forces.force[1] * s, forces.force[1] * c - forces.force[0] * s, forces.force[2],
			     forces.moment[1] * c - forces.moment[0] * s, forces.area};
}

static const char *const soils[] = {"dry_sand", "lunar", "lete_sand", "snow_us", "sandy_loam_15"};

static void a_wheel_tells_what_the_closed_form_does(void **state)
{
	(void)state;
	need_gpu();
	for (size_t k = 0; k < sizeof soils / sizeof *soils; k++) {
		struct deform_soil soil = bed_soil(soils[k]);
		struct reference_rolling wheel = {.radius = 0.32, .width = 0.24, .turned = reference_turned(0.2), .rebound = true,
						  .normals = REFERENCE_NORMALS_SURFACE, .follows = REFERENCE_FOLLOWS_RIM};
		double sinkage = reference_rolling_sinkage(&soil, &wheel, 1000);
		struct reference_rolling_force wanted = reference_rolling(&soil, &wheel, sinkage);
		print_message("%s %.2f mm: %.1f N, %.1f N, %.2f N m\n", soils[k], sinkage * 1e3, wanted.drawbar, wanted.vertical, wanted.moment);
		for (double spacing = 0.08; spacing > (k == 0 ? 0.006 : 0.015); spacing /= 2)
			for (int turn = 0; turn < 3; turn++)
				for (int shift = 0; shift < 3; shift++) {
					struct told got = roll(&soil, &wheel, sinkage, spacing, 22.5 * turn, shift * 0.31, 0.5);
					print_message("  %.3f %4.1f %d  Fz %+6.2f%% Fx %+6.2f%% My %+6.2f%% side %+5.2f%%  area %.4f\n", spacing, 22.5 * turn, shift,
						      (got.vertical / wanted.vertical - 1) * 100, (got.drawbar / wanted.drawbar - 1) * 100,
						      (got.moment / wanted.moment - 1) * 100, got.side / wanted.vertical * 100, got.area);
				}
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_tells_what_the_closed_form_does),
	};
	return cmocka_run_group_tests_name("validation/rolling", tests, open_gpu, close_gpu);
}
