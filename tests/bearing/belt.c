/*
 * A body whose belt runs over it draws as a rigid track does (Wong, Theory of Ground Vehicles). At a distance x behind the place where the belt
 * first touches, the shear displacement is i x, i the slip. So under a uniform pressure the tractive effort of a track of length l is
 * F = (A c + W tan phi) (1 - K / (i l) (1 - exp(-i l / K))).
 */
#include <stdio.h>

#include "../long.h"
#include "../support/program.h"
#include "ground.h"

#define CELLS 64

/* A belted body that goes straight over level, undisturbed ground. */
struct drive {
	const struct soil_shape *shape;
	const struct soil_numbers *soil;
	double spacing, heading; /* m, rad */
	double rim;              /* what the belt runs, for each metre of the way */
	double height;           /* m: of its centre above the undisturbed ground */
	double load;             /* N; or 0, and it is at that height */
	double way;              /* m, at least */
	double slip_sinkage, bulldozing;
	double roll;             /* rad */
};

struct drawn {
	double drawbar, side, vertical, pull, sinkage; /* N forwards, to the left, up, of the belt; m below `height` */
	int64_t dug;                                   /* units, over all posts */
};

static struct drawn drive(const struct drive *how)
{
	struct ground ground;
	const double c = cos(how->heading), s = sin(how->heading), spacing = how->spacing, reach = soil_shape_bound(how->shape) / spacing;
	const int steps = (int)ceil(how->way / spacing);
	const double from = 1.05 * reach + 3.3;
	ground_init(&ground, &(struct ground_params){.cells = CELLS, .tiles = (uint32_t)ceil((2 * from + steps + 4) / CELLS), .spacing = spacing,
						     .soils = how->soil, .iterations = 1,
						     .slip_sinkage = how->slip_sinkage, .bulldozing = how->bulldozing});
	struct deform_contact sweep = {.shape = how->shape, .load = how->load};
	struct deform_forces forces = {.z = 0};
	for (int i = 0; i <= steps; i++) {
		sweep.from = sweep.to;
		sweep.to = ground_pose(&ground, from + i * c, from + i * s, how->height);
		sweep.to.yaw = how->heading;
		sweep.to.roll = how->roll;
		sweep.turned = i > 0 ? how->rim * spacing : 0;
		sweep.from = i > 0 ? sweep.from : sweep.to;
		sweep.to.turn = sweep.from.turn + sweep.turned;
		forces = ground_forces(&ground, &sweep);
	}
	assert_int_equal(forces.state, DEFORM_TOUCHING);
	const struct drawn drawn = {forces.force[0] * c + forces.force[1] * s, forces.force[1] * c - forces.force[0] * s, forces.force[2], forces.pull,
				    how->height - lattice_offset_metres(forces.z), how->slip_sinkage > 0 ? ground_sum(&ground, PLANE_DUG) : 0};
	ground_finish(&ground);
	return drawn;
}

static const char *const soils[] = {"dry_sand", "lete_sand", "upland_loam_51"};
static const double spacings[] = {0.04, 0.02, 0.01}, slips[] = {0.05, 0.2, 0.5}, headings[] = {0, 22.5 * DEGREES, 45 * DEGREES};

/* All slips at all headings; on the finest posts, which take longest, each of both once. */
static int step_at(int spacing)
{
	return spacing == 2 ? 4 : 1;
}

static void near(const char *what, const struct drive *how, double got, double wanted, double within)
{
	if (!(fabs(got - wanted) <= within))
		fail_msg("%s, posts of %g m, rim %g, %g degrees: %.9g, wanted %.9g", what, how->spacing, how->rim, how->heading / DEGREES, got, wanted);
}

/* --- level tracks --- */

static const struct soil_shape track = {.kind = SOIL_BOX, .size = {1.2, 0.3, 0.5}, .belt = true};

static double effort(const struct soil_numbers *soil, const struct soil_shape *shape, double load, double slip)
{
	const double length = shape->size[0], strength = length * shape->size[1] * soil->cohesion + load * tan(soil->friction_angle);
	return strength * (1 - soil->janosi_shear / (slip * length) * (1 - exp(-slip * length / soil->janosi_shear)));
}

/* Under a load: a box has no resistance, since its front is upright. */
static void a_track_draws_what_the_closed_form_says(void **state)
{
	static const double allowed[] = {0.004, 0.002, 0.001};
	for (int k = 0; k < 3; k++)
		for (int n = 0; n < 3; n++) {
			if (!long_or_part((size_t)k, (size_t)n, 3))
				continue;
			const struct soil_numbers soil = bed_soil(soils[k]);
			const double area = track.size[0] * track.size[1], load = 12e3 * area, sinkage = reference_plate(&soil, track.size[1], 12e3);
			double most = 0, deep = 0;
			for (int m = 0; m < 9; m += step_at(n)) {
				const double slip = slips[m % 3], wanted = effort(&soil, &track, load, slip);
				const struct drive how = {.shape = &track, .soil = &soil, .spacing = spacings[n], .heading = headings[m / 3],
							  .rim = 1 / (1 - slip), .height = 0.25, .load = load, .way = 1.3};
				const struct drawn got = drive(&how);
				near("vertical force", &how, got.vertical, load, 0.002 * load);
				near("side force", &how, got.side, 0, 1e-3 * load);
				near("pull of the belt", &how, got.pull, got.drawbar, 1e-4 * load);
				most = support_most(most, fabs(got.drawbar / wanted - 1));
				deep = support_most(deep, fabs(got.sinkage / sinkage - 1));
				near("drawbar", &how, got.drawbar, wanted, allowed[n] * wanted);
				near("sinkage", &how, got.sinkage, sinkage, 0.005 * sinkage);
			}
			print_message("%s, posts of %g m: drawbar off by %.3f %%, sinkage by %.3f %%\n", soils[k], spacings[n], most * 100, deep * 100);
		}
}

/* A belt that runs slower than the body goes, or backwards, brakes; at the body's own speed it does nothing. */
static void a_belt_brakes_as_it_draws(void **state)
{
	static const double rims[] = {1, 0.8, 0.5, 0, -1};
	const struct soil_numbers soil = bed_soil("dry_sand");
	const double load = 4000, modulus = soil.janosi_shear, length = track.size[0];
	for (int m = 0; m < 15; m++) {
		/* Of the time in which a place of the soil passes below, the belt's is way / run, 10 at most. */
		const double rim = rims[m / 3], slid = (1 - rim) * length * fmin(1 / fmax(fabs(rim), 1e-9), 10);
		const double strength = length * track.size[1] * soil.cohesion + load * tan(soil.friction_angle);
		const double wanted = slid > 0 ? -strength * (1 - modulus / slid * (1 - exp(-slid / modulus))) : 0;
		const struct drive how = {.shape = &track, .soil = &soil, .spacing = 0.02, .heading = headings[m % 3], .rim = rim, .height = 0.25,
					  .load = load, .way = 1.3};
		const struct drawn got = drive(&how);
		near("drawbar", &how, got.drawbar, wanted, 0.01 * fabs(wanted) + 1e-3 * load);
		near("pull of the belt", &how, got.pull, got.drawbar, 1e-3 * load);
	}
}

/* Where the belt has slid by u shear moduli, slip has dug kappa K (1 - exp(1 - exp(-u) - u)) from below it. So much less deep is the rear of a level
 * track in its soil than the front. It never digs itself free. Returns the load that it carries where its front is at a sinkage. */
static double carries(const struct soil_numbers *soil, double slip, double kappa, double sinkage, double *drawbar)
{
	const int parts = 20000;
	double load = 0;
	*drawbar = 0;
	for (int k = 0; k < parts; k++) {
		const double slid = slip * (k + 0.5) / parts * track.size[0] / soil->janosi_shear, mobilised = 1 - exp(-slid);
		const double dug = kappa * soil->janosi_shear * (1 - exp(mobilised - slid)), area = track.size[0] * track.size[1] / parts;
		const double pressure = sinkage > dug ? reference_bekker(soil, track.size[1], sinkage - dug) : 0;
		load += pressure * area;
		*drawbar += reference_strength(soil, &(struct soil_interface){.has_friction = false}, pressure) * mobilised * area;
	}
	return load;
}

static void a_belt_that_slips_digs_by_the_formula(void **state)
{
	/* They sink by more than slip can dig, so the whole belt bears. */
	static const char *const soft[] = {"dry_sand", "snow_us", "lunar"};
	const double load = 4000, kappa = 1.35;
	for (int k = 0; k < 3; k++)
		for (int n = 0; n < 2; n++) {
			const struct soil_numbers soil = bed_soil(soft[k]);
			for (int m = 0; m < 9; m += 4) {
				const double slip = slips[m % 3];
				double low = 0, high = 0.2, drawbar;
				for (int i = 0; i < 50; i++) {
					const double middle = (low + high) / 2;
					*(carries(&soil, slip, kappa, middle, &drawbar) < load ? &low : &high) = middle;
				}
				const struct drive how = {.shape = &track, .soil = &soil, .spacing = spacings[n], .heading = headings[m / 3],
							  .rim = 1 / (1 - slip), .height = 0.25, .load = load, .way = 1.3, .slip_sinkage = kappa};
				const struct drawn got = drive(&how);
				print_message("%s, posts of %g m, slip %g: sinkage %.2f mm for %.2f, drawbar %.1f N for %.1f\n", soft[k], spacings[n],
					      slip, got.sinkage * 1e3, low * 1e3, got.drawbar, drawbar);
				assert_true(got.dug > 0);
				near("sinkage", &how, got.sinkage, low, 0.02 * low);
				near("drawbar", &how, got.drawbar, drawbar, 0.02 * drawbar);
			}
		}
}

static void what_does_not_slip_digs_nothing(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	for (int m = 0; m < 3; m++) {
		const struct drive how = {.shape = &track, .soil = &soil, .spacing = 0.02, .heading = headings[m], .rim = 1, .height = 0.25, .load = 4000,
					  .way = 1.3, .slip_sinkage = 1.35, .bulldozing = 0.5};
		const struct drawn got = drive(&how);
		assert_true(got.dug == 0);
		near("drawbar", &how, got.drawbar, 0, 1e-3 * 4000);
	}
}

/* --- a track whose front rises --- */

#define RAMP (35 * DEGREES)
static const double flat = 0.5, rise = 0.2, half_width = 0.15; /* m: half its level length, height and half width */

/* Its rear is upright, its front rises; its centre is at its bottom. */
static void make_ramp(struct soil_mesh *mesh, float (*vertices)[3], uint32_t (*triangles)[3])
{
	const double nose = flat + rise / tan(RAMP), outline[4][2] = {{-flat, 0}, {flat, 0}, {nose, rise}, {-flat, rise}};
	*mesh = (struct soil_mesh){.vertices = vertices, .triangles = triangles, .vertex_count = 8, .triangle_count = 8,
				   .low = {-flat, -half_width, 0}, .high = {nose, half_width, rise}};
	for (uint32_t i = 0; i < 4; i++)
		for (uint32_t side = 0; side < 2; side++) {
			const uint32_t a = 2 * i, b = 2 * ((i + 1) % 4);
			float *v = vertices[2 * i + side];
			v[0] = (float)outline[i][0];
			v[1] = (float)(side == 0 ? -half_width : half_width);
			v[2] = (float)outline[i][1];
			memcpy(triangles[2 * i + side], side == 0 ? (uint32_t[]){a, b, b + 1} : (uint32_t[]){a, b + 1, a + 1}, sizeof *triangles);
		}
}

/* Integrates along the belt, from the place where its front first touches. A metre of a face that rises by `angle` slips by 1 - (1 - i) cos(angle)
 * metres of the belt. */
static struct drawn integrate(const struct soil_numbers *soil, double width, double slip, double sinkage)
{
	struct drawn sum = {0};
	const int parts = 200000;
	const double ramp = sinkage / sin(RAMP), length = ramp + 2 * flat, part = length / parts;
	double slid = 0;
	for (int k = 0; k < parts; k++) {
		const double at = (k + 0.5) * part, angle = at < ramp ? RAMP : 0, z = at < ramp ? at * sin(RAMP) : sinkage;
		const double more = (1 - (1 - slip) * cos(angle)) * part;
		const double pressure = reference_bekker(soil, width, z), area = 2 * half_width * part;
		const double shear = (soil->cohesion + pressure * tan(soil->friction_angle)) * (1 - exp(-(slid + more / 2) / soil->janosi_shear));
		slid += more;
		sum.drawbar += (shear * cos(angle) - pressure * sin(angle)) * area;
		sum.vertical += (pressure * cos(angle) + shear * sin(angle)) * area;
		sum.pull += shear * area;
	}
	return sum;
}

static void a_front_that_rises_resists_as_the_integral_says(void **state)
{
	static const double allowed[] = {0.01, 0.005, 0.002};
	float vertices[8][3];
	uint32_t triangles[8][3];
	struct soil_mesh mesh;
	make_ramp(&mesh, vertices, triangles);
	const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &mesh, .belt = true};
	for (int k = 0; k < 3; k++)
		for (int n = 0; n < 3; n++) {
			if (!long_or_part((size_t)k, (size_t)(n + 1), 3))
				continue;
			struct soil_numbers soil = bed_soil(soils[k]);
			const double sinkage = 0.06;
			double most = 0;
			soil.bekker_kc = 0; /* so that b does not count: it is of the posts that are touched */
			for (int m = 0; m < 9; m += step_at(n)) {
				const double slip = slips[m % 3];
				const struct drawn wanted = integrate(&soil, 1, slip, sinkage);
				const struct drive how = {.shape = &shape, .soil = &soil, .spacing = spacings[n], .heading = headings[m / 3],
							  .rim = 1 / (1 - slip), .height = -sinkage, .way = 1.5};
				const struct drawn got = drive(&how);
				most = support_most(most, fabs(got.drawbar / got.vertical - wanted.drawbar / wanted.vertical));
				near("drawbar over vertical force", &how, got.drawbar / got.vertical, wanted.drawbar / wanted.vertical, allowed[n]);
				near("pull over vertical force", &how, got.pull / got.vertical, wanted.pull / wanted.vertical, allowed[n]);
				assert_true(wanted.pull > wanted.drawbar + 0.01 * wanted.vertical);
			}
			print_message("%s, posts of %g m: drawbar off by %.2f %% of the vertical force\n", soils[k], spacings[n], most * 100);
		}
}

/* --- bits --- */

/* Drives one body over tiles of a size, and gives a plane of what it left. */
static int32_t *left_by(const struct soil_shape *shape, uint32_t cells, uint32_t tiles, double rim, enum plane plane)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	struct ground ground;
	ground_init(&ground, &(struct ground_params){.cells = cells, .tiles = tiles, .spacing = 0.05, .soils = &soil,
						     .slip_sinkage = 1.35, .bulldozing = 0.5, .stands = true});
	struct deform_contact sweep = {.shape = shape, .load = 3000};
	for (int i = 0; i < 30; i++) {
		sweep.from = sweep.to;
		sweep.to = ground_pose(&ground, 40 + 0.9 * i, 50 + 0.4 * i, 0.25);
		sweep.to.yaw = 0.42;
		sweep.turned = i > 0 ? rim * 0.05 * hypot(0.9, 0.4) : 0;
		sweep.from = i > 0 ? sweep.from : sweep.to;
		ground_forces(&ground, &sweep);
	}
	int32_t *all = ground_plane(&ground, plane);
	ground_finish(&ground);
	return all;
}

static void tiles_show_in_no_bit(void **state)
{
	static const enum plane planes[] = {PLANE_OFFSET, PLANE_SHEAR, PLANE_DUG};
	for (int i = 0; i < 3; i++) {
		int32_t *large = left_by(&track, 128, 1, 1.25, planes[i]), *small = left_by(&track, 32, 4, 1.25, planes[i]);
		assert_memory_equal(large, small, 129 * 129 * sizeof *large);
		mem_free(large);
		mem_free(small);
	}
}

TEST_PROGRAM(belt)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_track_draws_what_the_closed_form_says),
		cmocka_unit_test(a_belt_brakes_as_it_draws),
		cmocka_unit_test(a_belt_that_slips_digs_by_the_formula),
		cmocka_unit_test(what_does_not_slip_digs_nothing),
		cmocka_unit_test(a_front_that_rises_resists_as_the_integral_says),
		cmocka_unit_test(tiles_show_in_no_bit),
	};
	return cmocka_run_group_tests_name("bearing/belt", tests, NULL, NULL);
}
