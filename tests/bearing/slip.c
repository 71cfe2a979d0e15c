/* Slip sinkage of scm: a body that slips digs, what it digs is laid around, and one that rolls or stands digs nothing. */
#include "ground.h"
#include "../support/program.h"

#define KAPPA 1.1

static const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.5, 0.5, 0.5}};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.058, .width = 0.05};
/* As wide as its radius, so that the bands that it lays are as wide as a wheel's. */
static const struct soil_shape broad = {.kind = SOIL_WHEEL, .radius = 0.058, .width = 0.058}, roller = {.kind = SOIL_CYLINDER, .radius = 0.058, .length = 0.058};

static void init(struct ground *ground, const struct soil_numbers *soil, double spacing, double slip_sinkage, double bulldozing)
{
	ground_init(ground, &(struct ground_params){.cells = 128, .tiles = spacing < 0.003 ? 3 : 1, .first = 2, .spacing = spacing, .soils = soil, .bulldozing = bulldozing, .slip_sinkage = slip_sinkage, .iterations = 1});
}

/* rim: speed of the wheel's rim / speed of its axle. */
static void go(struct deform_contact *contact, double east, double rim)
{
	contact->from = contact->to;
	contact->to.x += lattice_offset(east);
	if (contact->shape->kind == SOIL_WHEEL)
		contact->turned = lattice_offset_metres(contact->to.x - contact->from.x) * rim / contact->shape->radius;
}

/* A plate under a load slips by less than a post, so that the same posts bear it. With u = j / K its shear mobilises e = 1 - exp(-u), of which the
 * integral is u - e: it sinks by kappa K (1 - exp(e - u)). */
static void a_plate_that_slips_sinks_by_the_formula(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	struct ground ground;
	soil.janosi_shear = 0.004;
	for (int pieces = 1; pieces <= 8; pieces *= 8) {
		init(&ground, &soil, 0.015625, KAPPA, 0);
		struct deform_contact contact = ground_stand(&ground, &plate, 64.1, 64.5, 0.25);
		contact.load = 5000;
		double stood = lattice_offset_metres(ground_forces(&ground, &contact).z), way = 0;
		for (int i = 0; i < pieces; i++) {
			go(&contact, 0.008 / pieces, 0);
			struct deform_forces forces = ground_forces(&ground, &contact);
			way += lattice_offset_metres(contact.to.x - contact.from.x);
			const double slid = way / soil.janosi_shear, wanted = KAPPA * soil.janosi_shear * (1 - exp(1 - exp(-slid) - slid));
			if (!(fabs(stood - lattice_offset_metres(forces.z) - wanted) < 1e-5))
				fail_msg("%d pieces, %g m: it sank by %.7g m, not %.7g", pieces, way, stood - lattice_offset_metres(forces.z), wanted);
		}
		ground_finish(&ground);
	}
}

/* A wheel that rolls without slip leaves the same bits with slip sinkage as without it. */
static void what_rolls_digs_nothing(void **state)
{
	static const enum plane planes[] = {PLANE_OFFSET, PLANE_DEPOSITED, PLANE_PLASTIC_SINKAGE, PLANE_SHEAR};
	const struct soil_numbers soil = bed_soil("dry_sand");
	int32_t *seen[2][4];
	for (int digs = 0; digs < 2; digs++) {
		struct ground ground;
		init(&ground, &soil, 0.004, digs * KAPPA, 0.5);
		struct deform_contact contact = ground_stand(&ground, &wheel, 30.3, 64.4, 0.058);
		contact.load = 20;
		for (int pass = 0; pass < 2; pass++) {
			ground_forces(&ground, &contact);
			for (int i = 0; i < 60; i++) {
				go(&contact, pass == 0 ? 0.004 : -0.004, 1);
				ground_forces(&ground, &contact);
			}
		}
		for (int i = 0; i < 4; i++)
			seen[digs][i] = ground_plane(&ground, planes[i]);
		if (digs)
			assert_int_equal(ground_sum(&ground, PLANE_DUG), 0);
		for (int i = 0; i < 4 && digs; i++)
			assert_memory_equal(seen[0][i], seen[1][i], (size_t)(ground.posts * ground.posts) * 4);
		ground_finish(&ground);
	}
	for (int i = 0; i < 8; i++)
		mem_free(seen[i / 4][i % 4]);
}

struct rut {
	double depth, drawbar; /* m, N */
};

/* A wheel of 20 N, or another body that lies as it does, after 0.2 m. */
static struct rut rut(const struct soil_shape *shape, double spacing, double rim, double slip_sinkage)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	const double way = 0.2;
	struct deform_forces forces = {0};
	struct ground ground;
	init(&ground, &soil, spacing, slip_sinkage, 0);
	struct deform_contact contact = ground_stand(&ground, shape, 0.12 / spacing + 0.3, (double)ground.posts / 2 + 0.2, 0.058);
	contact.from.roll = contact.to.roll = shape->kind == SOIL_CYLINDER ? M_PI / 2 : 0;
	contact.load = 20;
	ground_forces(&ground, &contact);
	for (int i = 0; i < (int)lround(way / spacing); i++) {
		go(&contact, spacing, rim);
		forces = ground_forces(&ground, &contact);
	}
	/* It digs below itself alone. */
	int32_t *dug = ground_plane(&ground, PLANE_DUG);
	int64_t count = 0;
	for (int64_t i = 0; i < ground.posts * ground.posts; i++)
		count += dug[i] != 0;
	const double under = (way + 2 * sqrt(2 * wheel.radius * (wheel.radius - lattice_offset_metres(forces.z)))) * wheel.width;
	if (!((double)count * spacing * spacing < 1.2 * under))
		fail_msg("%lld posts %g m apart are dug, of %g m2 under the wheel", (long long)count, spacing, under);
	mem_free(dug);
	ground_finish(&ground);
	return (struct rut){0.058 - lattice_offset_metres(forces.z), forces.force[0]};
}

/* Bars reach below the rim, and press posts that the rim does not touch. */
static void a_wheel_with_grousers_carries_its_load_while_it_slips(void **state)
{
	struct soil_shape lugged = wheel;
	lugged.grousers = 16;
	lugged.grouser_height = 0.007;
	lugged.grouser_thickness = 0.003;
	for (int k = 0; k < 6; k++) {
		const struct soil_numbers soil = bed_soil("dry_sand");
		double spacing = 0.008 / (1 << k % 3), rim = k < 3 ? 1.25 : 2;
		struct ground ground;
		init(&ground, &soil, spacing, KAPPA, 0);
		struct deform_contact contact = ground_stand(&ground, &lugged, 0.12 / spacing + 0.3, (double)ground.posts / 2 + 0.2, 0.058);
		contact.load = 20;
		ground_forces(&ground, &contact);
		for (int i = 0; i < (int)lround(0.1 / spacing); i++) {
			go(&contact, spacing, rim);
			const struct deform_forces forces = ground_forces(&ground, &contact);
			if (!(fabs(forces.force[2] - 20) < 0.005 * 20))
				fail_msg("posts %g m, rim %g, contact %d: %g N of 20 N", spacing, rim, i, forces.force[2]);
		}
		ground_finish(&ground);
	}
}

static void the_more_it_slips_the_deeper_it_digs_at_any_spacing(void **state)
{
	static const double rims[] = {0, 0.5, 1, 1.25, 2};
	/* Closed forms of the last two, which lay nothing ahead of themselves: bench/soil_forms.py, Law(kappa=1.1). */
	static const struct rut forms[] = {{0.0144042, -0.5093}, {0.0174935, 0.8299}};
	double depths[5][3], drawbars[5][3];
	for (int r = 0; r < 5; r++)
		for (int s = 0; s < 3; s++) {
			const struct rut found = rut(&wheel, 0.008 / (1 << s), rims[r], KAPPA);
			depths[r][s] = found.depth;
			drawbars[r][s] = found.drawbar;
		}
	for (int r = 0; r < 5; r++)
		print_message("rim %.2f of the axle: %.2f, %.2f, %.2f mm; %.3f, %.3f, %.3f N at 8, 4, 2 mm\n", rims[r], depths[r][0] * 1e3,
			      depths[r][1] * 1e3, depths[r][2] * 1e3, drawbars[r][0], drawbars[r][1], drawbars[r][2]);
	for (int s = 0; s < 3; s++) {
		/* A locked wheel is a cylinder that is dragged across its axis. What is dug is not laid quite alike. */
		for (int digs = 0; digs < 2; digs++) {
			const struct rut dragged = rut(&roller, 0.008 / (1 << s), 0, digs * KAPPA), locked = rut(&broad, 0.008 / (1 << s), 0, digs * KAPPA);
			print_message("slip_sinkage %g: a cylinder that is dragged %.3f mm, %.3f N; a locked wheel %.3f mm, %.3f N\n", digs * KAPPA, dragged.depth * 1e3, dragged.drawbar,
				      locked.depth * 1e3, locked.drawbar);
			assert_near(locked.depth, dragged.depth, (digs ? 5e-3 : 1e-5) * dragged.depth);
			assert_near(locked.drawbar, dragged.drawbar, (digs ? 5e-3 : 1e-5) * 20);
		}
		for (int r = 0; r < 2; r++)
			assert_true(depths[r][s] > 1.5 * depths[2][s]);
		assert_true(depths[0][s] > depths[1][s]);
		for (int r = 3; r < 5; r++)
			assert_true(depths[r][s] > depths[r - 1][s]);
	}
	for (int r = 0; r < 5; r++)
		assert_true(fabs(depths[r][1] / depths[r][2] - 1) < 0.02);
	for (int r = 3; r < 5; r++)
		for (int s = 0; s < 3; s++) {
			assert_true(fabs(depths[r][s] / forms[r - 3].depth - 1) < 0.01);
			assert_true(fabs(drawbars[r][s] - forms[r - 3].drawbar) < 0.01 * 20);
		}
	assert_true(fabs(rut(&wheel, 0.004, 1, 0).depth / depths[2][1] - 1) < 1e-6);
}

/* With stresses along the ground's normals a place of the ground counts, not one of the rim: its slip digs for as long as it lies below the wheel. Closed
 * forms: bench/soil_forms.py, Law("ground", "ground", 1.35), 1 kN on dry_sand. */
static void with_normals_of_the_ground_slip_digs_for_the_soils_time(void **state)
{
	static const struct soil_shape large = {.kind = SOIL_WHEEL, .radius = 0.32, .width = 0.24};
	static const struct {
		double slip;
		struct rut form;
	} rows[] = {{0.2, {0.04242, 311.83}}, {0.5, {0.05885, 554.99}}};
	const struct soil_numbers soil = bed_soil("dry_sand");
	for (size_t k = 0; k < COUNT(rows); k++) {
		struct ground ground;
		struct deform_forces forces = {.z = 0};
		ground_init(&ground, &(struct ground_params){.cells = 128, .tiles = 1, .spacing = 0.02, .soils = &soil, .slip_sinkage = 1.35, .ground_normals = true});
		struct deform_contact contact = ground_stand(&ground, &large, 24.3, 64.2, 0.32);
		contact.load = 1000;
		ground_forces(&ground, &contact);
		for (int i = 0; i < 60; i++) {
			go(&contact, 0.02, 1 / (1 - rows[k].slip));
			forces = ground_forces(&ground, &contact);
		}
		const double depth = 0.32 - lattice_offset_metres(forces.z);
		print_message("normals of the ground, slip %g: %.2f mm of %.2f, %.2f N of %.2f\n", rows[k].slip, depth * 1e3, rows[k].form.depth * 1e3, forces.force[0],
			      rows[k].form.drawbar);
		assert_near(depth, rows[k].form.depth, 0.005 * depth);
		assert_near(forces.force[0], rows[k].form.drawbar, 0.005 * 1000);
		ground_finish(&ground);
	}
}

/* Pass after pass in one rut slip digs less, and in all no more than kappa K. */
static void each_pass_digs_less(void **state)
{
	const struct soil_numbers soil = bed_soil("dry_sand");
	const int32_t most = (int32_t)lround(ldexp(KAPPA * soil.janosi_shear, OFFSET_BITS));
	struct ground ground;
	int32_t before = 0, gained = most;
	init(&ground, &soil, 0.004, KAPPA, 0.5);
	for (int pass = 0; pass < 5; pass++) {
		struct deform_contact contact = ground_stand(&ground, &wheel, 30.3, 64.4, 0.058);
		contact.load = 20;
		ground_forces(&ground, &contact);
		for (int i = 0; i < 60; i++) {
			go(&contact, 0.004, 2);
			ground_forces(&ground, &contact);
		}
		int32_t *dug = ground_plane(&ground, PLANE_DUG), now = dug[64 * ground.posts + 60];
		mem_free(dug);
		assert_true(now > before && now <= most && now - before < gained);
		gained = now - before;
		before = now;
	}
	ground_finish(&ground);
}

/* What is dug is laid somewhere: without bulldozing too. */
static void every_unit_that_is_dug_is_laid(void **state)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	for (int round = 0; round < 6; round++) {
		struct ground ground;
		int64_t dug = 0;
		init(&ground, &soil, 0.004, round < 3 ? KAPPA : 5, 0.5 * (round % 3));
		for (int k = 0; k < 3; k++) {
			struct deform_contact contact = ground_stand(&ground, &wheel, 40 + 9 * k, 60 + 3 * k, 0.058 - 0.015);
			contact.load = k % 2 ? 25 : 0;
			for (int i = 0; i < 20; i++) {
				contact.to.yaw = contact.from.yaw = 0.4 * k;
				ground_forces(&ground, &contact);
				ground_lost_nothing(&ground);
				dug += ground_sum(&ground, PLANE_DUG) > 0;
				go(&contact, 0.004, 3);
			}
		}
		assert_true(dug > 10);
		ground_finish(&ground);
	}
}

TEST_PROGRAM(slip)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_that_slips_sinks_by_the_formula),
		cmocka_unit_test(what_rolls_digs_nothing),
		cmocka_unit_test(a_wheel_with_grousers_carries_its_load_while_it_slips),
		cmocka_unit_test(the_more_it_slips_the_deeper_it_digs_at_any_spacing),
		cmocka_unit_test(with_normals_of_the_ground_slip_digs_for_the_soils_time),
		cmocka_unit_test(each_pass_digs_less),
		cmocka_unit_test(every_unit_that_is_dug_is_laid),
	};
	return cmocka_run_group_tests_name("bearing/slip", tests, NULL, NULL);
}
