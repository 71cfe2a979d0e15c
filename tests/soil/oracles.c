/* The oracles of faces hold to what is known of them: 3D-RFT (faces_oracle.c) and the earthmoving equation (mckyes.c). */
#include "soil_test.h"

#include "../support/program.h"
#include "faces_oracle.h"
#include "mckyes.h"

static void any_unit(double v[3])
{
	double squares = 0;
	while (squares < 0.01 || squares > 1) {
		squares = 0;
		for (int k = 0; k < 3; k++) {
			v[k] = any_share();
			squares += v[k] * v[k];
		}
	}
	for (int k = 0; k < 3; k++)
		v[k] /= sqrt(squares);
}

/* A normal that does not look up and a velocity that presses. */
static void any_pressing(double n[3], double v[3])
{
	do {
		any_unit(n);
		any_unit(v);
		n[2] = -fabs(n[2]);
	} while (n[0] * v[0] + n[1] * v[1] + n[2] * v[2] < 0.02);
}

static double apart(const double a[3], const double b[3])
{
	return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static struct faces_oracle_law plain_law(double mu)
{
	return (struct faces_oracle_law){.xi = 1e6, .mu = mu, .lift = 1};
}

static void stresses_are_those_of_the_fit(void **state)
{
	/* Normal, which is not yet of length 1, velocity, mu, stress: from another program of the same law. */
	static const struct {
		double n[3], v[3], mu, stress[3];
	} known[] = {
		{{0.003, 0.737, -0.676}, {-0.632, -0.323, -0.704}, 0.1, {0.017728384, -0.219497888, 0.236877065}},
		{{0.861, -0.316, -0.399}, {0.796, 0.58, 0.171}, 0.5, {-0.278785595, -0.022876091, 0.067263851}},
		{{-0.019, 0.459, -0.888}, {-0.195, -0.812, -0.551}, 0.29, {0.019338664, -0.055584518, 0.275745611}},
		{{-0.178, -0.962, -0.206}, {0.062, -0.074, -0.995}, 0.93, {0.014986745, 0.179932439, 0.253833675}},
		{{-0.032, 0.074, -0.997}, {-0.352, -0.721, -0.596}, 0.28, {0.089272572, 0.119283623, 0.654188922}},
		{{-0.674, -0.027, -0.738}, {-0.966, -0.185, 0.183}, 0.56, {0.325737227, 0.035453817, 0.217302077}},
		{{-0.669, 0.042, -0.742}, {-0.872, 0.484, 0.067}, 0.88, {0.340611467, -0.100634336, 0.255287590}},
		{{0.815, 0.311, -0.489}, {0.122, 0.943, -0.309}, 0.83, {-0.216541025, -0.327171448, 0.265296476}},
		{{-0.042, 0.42, -0.906}, {-0.8, 0.241, -0.549}, 0.24, {0.183273976, -0.240859418, 0.618920013}},
		{{-0.315, 0.828, -0.464}, {-0.032, 0.891, -0.453}, 0.39, {0.044242032, -0.355112618, 0.318389914}},
	};
	static const double down[3] = {0, 0, -1}, forwards[3] = {1, 0, 0};
	struct faces_oracle_law law = plain_law(1);
	double alpha[3];
	(void)state;
	faces_oracle_alpha(&law, down, down, alpha);
	assert_near(alpha[2], 0.87574, 1e-9);
	assert_near(hypot(alpha[0], alpha[1]), 0, 1e-12);
	faces_oracle_alpha(&law, down, (const double[3]){0, 0, 1}, alpha);
	assert_near(alpha[2], 0, 0);
	faces_oracle_alpha(&law, forwards, forwards, alpha);
	assert_true(alpha[0] < -0.1 && fabs(alpha[1]) < 1e-12);
	for (size_t i = 0; i < COUNT(known); i++) {
		const double *n = known[i].n, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		law.mu = known[i].mu;
		faces_oracle_alpha(&law, (const double[3]){n[0] / length, n[1] / length, n[2] / length}, known[i].v, alpha);
		assert_near(apart(alpha, known[i].stress), 0, 2e-9);
	}
	/* The sand of a published rig: 1330 kg/m3, 29 degrees. */
	assert_near(faces_oracle_xi(1330 * 9.81, tan(29 * DEGREES)), 1.083e6, 1e3);
}

static void turned_and_mirrored(const double from[3], double angle, bool mirror, double to[3])
{
	const double c = cos(angle), s = sin(angle), y = mirror ? -from[1] : from[1];
	to[0] = c * from[0] - s * y;
	to[1] = s * from[0] + c * y;
	to[2] = from[2];
}

static void no_direction_and_no_hand_is_preferred(void **state)
{
	(void)state;
	for (int i = 0; i < 4000; i++) {
		const struct faces_oracle_law law = {.xi = 1, .mu = 0.5 + 0.5 * any_share(), .lift = i % 2 == 0 ? 1 : 0.55, .upright_part = i % 3 == 0,
						     .helps = i % 5 == 0 ? 0.02 : 0};
		const double angle = M_PI * any_share();
		double n[3], v[3], alpha[3], other_n[3], other_v[3], other[3], expected[3];
		any_pressing(n, v);
		n[2] *= i % 4 == 0 ? -1 : 1;
		faces_oracle_alpha(&law, n, v, alpha);
		turned_and_mirrored(n, angle, i % 2 != 0, other_n);
		turned_and_mirrored(v, angle, i % 2 != 0, other_v);
		for (int k = 0; k < 3; k++)
			other_v[k] *= 0.01;
		turned_and_mirrored(alpha, angle, i % 2 != 0, expected);
		faces_oracle_alpha(&law, other_n, other_v, other);
		assert_near(apart(other, expected), 0, 1e-9);
	}
}

/* A little change of normal or velocity changes the stress little: also about the upright, where the frame turns. */
static void stress_has_no_jumps_while_a_facet_presses(void **state)
{
	double most = 0;
	(void)state;
	for (int i = 0; i < 20000; i++) {
		const struct faces_oracle_law law = {.xi = 1, .mu = 0.6, .lift = 1, .upright_part = true, .helps = i % 2 == 0 ? 0.02 : 0};
		double n[3], v[3], other_n[3], other_v[3], alpha[3], other[3];
		any_pressing(n, v);
		if (i % 4 == 0) { /* a velocity that is almost straight down */
			v[0] *= 1e-7;
			v[1] *= 1e-7;
			v[2] = -1;
		}
		if (i % 4 == 1) /* a facet that is almost upright */
			n[2] = 1e-7 * any_share();
		if (i % 4 == 2 && v[2] < -0.1) { /* a facet that is almost level */
			n[0] *= 1e-7;
			n[1] *= 1e-7;
			n[2] = -1;
		}
		const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		for (int k = 0; k < 3; k++) {
			n[k] /= length;
			other_n[k] = n[k] + 1e-6 * any_share();
			if (i / 8 % 8 == 7) /* a facet that moves along its normal */
				v[k] = n[k] + 1e-7 * any_share();
			other_v[k] = v[k] + 1e-6 * any_share();
		}
		const double other_length = sqrt(other_n[0] * other_n[0] + other_n[1] * other_n[1] + other_n[2] * other_n[2]);
		for (int k = 0; k < 3; k++)
			other_n[k] /= other_length;
		if (!(n[0] * v[0] + n[1] * v[1] + n[2] * v[2] > 1e-3))
			continue;
		faces_oracle_alpha(&law, n, v, alpha);
		faces_oracle_alpha(&law, other_n, other_v, other);
		most = support_most(most, apart(alpha, other));
	}
	print_message("most for a change of 1e-6: %.2e\n", most);
	assert_true(most < 5e-5);
}

/* The stress along a facet is limited by friction, and does not help the sliding if that is asked for. */
static void friction_is_limited(void **state)
{
	int helped = 0, pulled = 0, count = 20000;
	double jump = 0, worst = 0;
	(void)state;
	for (int i = 0; i < count; i++) {
		struct faces_oracle_law law = plain_law(0.3);
		double n[3], v[3], alpha[3];
		any_pressing(n, v);
		for (int j = 0; j < 2; j++) {
			double across = 0, through = 0, along = 0, helps = 0;
			law.helps = j == 1 ? 1e-12 : 0;
			faces_oracle_alpha(&law, n, v, alpha);
			for (int k = 0; k < 3; k++) {
				across += alpha[k] * n[k];
				through += v[k] * n[k];
			}
			for (int k = 0; k < 3; k++) {
				const double part = alpha[k] - across * n[k];
				along += part * part;
				helps += part * (v[k] - through * n[k]);
			}
			assert_true(sqrt(along) <= 0.3 * fabs(across) + 1e-12);
			if (j == 0) {
				helped += helps > 0 ? 1 : 0;
				pulled += across > 0 ? 1 : 0;
				worst = support_most(worst, across);
				jump = through < 0.03 ? support_most(jump, sqrt(along) - across) : jump;
			} else {
				assert_true(helps < 1e-9);
			}
		}
	}
	print_message("stress helps the sliding: %.2f %% of all; draws the facet on: %.3f %%, at most %.4f; where it begins to press: up to %.3f\n",
		      100.0 * helped / count, 100.0 * pulled / count, worst, jump);
	assert_true(helped > 0 && helped < 0.04 * count && pulled < 0.001 * count && worst < 0.01);
}

#define ROOM 60000
static struct faces_oracle_facet placed[ROOM];

static size_t place(const struct soil_shape *shape, double size, double yaw, double height)
{
	struct soil_facets facets = {0};
	double axes[3][3];
	assert_ok(soil_facets_of(shape, size, &facets));
	assert_true(facets.count <= ROOM);
	soil_axes(yaw, 0, 0, 0, axes);
	faces_oracle_place(&facets, (const double(*)[3])axes, (const double[3]){0, 0, height}, placed);
	const size_t count = facets.count;
	soil_facets_finish(&facets);
	return count;
}

/* What is known in closed form of a box in level ground: its wall, its sole. */
static void a_box_presses_with_its_wall_and_its_sole(void **state)
{
	const struct soil_shape box = {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.4}};
	const struct faces_oracle_law law = plain_law(0.5);
	const double depth = 0.1;
	struct faces_oracle_twist twist = {.centre = {0, 0, 0.2 - depth}};
	double alpha[3], force[3], moment[3];
	(void)state;
	const size_t count = place(&box, 0.005, 0, 0.2 - depth);
	twist.velocity[2] = -1;
	faces_oracle_force(&law, placed, count, 0, &twist, force, moment);
	assert_near(force[2], law.xi * 0.87574 * depth * 0.06, 1);
	assert_near(hypot(force[0], force[1]), 0, 0.01);
	assert_near(hypot(moment[0], moment[1]), 0, 0.01);
	twist.velocity[2] = 0;
	twist.velocity[0] = 0.3;
	faces_oracle_alpha(&law, twist.velocity, twist.velocity, alpha);
	faces_oracle_alpha(&law, (const double[3]){1, 0, 0}, twist.velocity, alpha);
	faces_oracle_force(&law, placed, count, 0, &twist, force, moment);
	const double wall = law.xi * depth * depth / 2 * 0.2, lever = 0.2 - depth + 2.0 / 3 * depth; /* the pressure's middle is two thirds down */
	assert_near(force[0], wall * alpha[0], 1e-3 * fabs(wall * alpha[0]));
	assert_near(moment[1], -lever * wall * alpha[0] - 0.15 * wall * alpha[2], 2e-3 * wall);
	assert_near(force[1], 0, 0.01);
	assert_near(moment[2], 0, 0.01);
}

/* A rolling wheel with bars that heads elsewhere: the same force, turned. Its size of facets matters little. */
static void a_wheel_is_the_same_on_every_heading(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.12, .grousers = 18, .grouser_height = 0.02,
					 .grouser_thickness = 0.004};
	const struct faces_oracle_law law = plain_law(0.55);
	double first[3] = {0}, force[3], moment[3];
	(void)state;
	for (int i = 0; i < 10; i++) {
		const double yaw = 0.63 * i, c = cos(yaw), s = sin(yaw);
		const struct faces_oracle_twist twist = {.centre = {0, 0, 0.22}, .velocity = {c * 0.05 - s * 0.02, s * 0.05 + c * 0.02, 0},
							 .rate = {-s * 0.4, c * 0.4, 0}};
		const size_t count = place(&wheel, i == 9 ? 0.005 : 0.01, yaw, 0.22);
		faces_oracle_force(&law, placed, count, 0, &twist, force, moment);
		const double along[3] = {c * force[0] + s * force[1], c * force[1] - s * force[0], force[2]};
		if (i == 0)
			memcpy(first, along, sizeof first);
		print_message("%.0f degrees: %.3f %.3f %.3f N\n", yaw / DEGREES, along[0], along[1], along[2]);
		assert_near(apart(first, along), 0, (i == 9 ? 0.03 : 1e-4) * first[2]);
	}
	assert_true(first[2] > 50 && first[1] < -5);
}

/* --- the earthmoving equation --- */

static struct mckyes_blade any_blade(void)
{
	struct mckyes_blade b = {.depth = 0.11 + 0.09 * any_share(), .width = 1, .rake = (60 + 30 * any_share()) * DEGREES, .friction = (32 + 12 * any_share()) * DEGREES};
	b.tool = b.friction * (0.4 + 0.4 * any_share());
	b.unit_weight = 16e3 + 4e3 * any_share();
	b.cohesion = 3e3 + 3e3 * any_share();
	b.adhesion = b.cohesion * (0.5 + 0.5 * any_share());
	b.surcharge = 2e3 + 2e3 * any_share();
	return b;
}

/* Solves the two sums of forces on a wedge for P and R, straight from the list in mckyes.c. */
static double by_equilibrium(const struct mckyes_blade *m, double b)
{
	const double a = m->rake, d = m->depth, top = d / tan(a) + d / tan(b);
	const double down = (m->unit_weight * d * top / 2 + m->surcharge * top) * m->width;
	const double sticks = m->adhesion * d / sin(a) * m->width, holds = m->cohesion * d / sin(b) * m->width;
	const double x = -sticks * cos(a) + holds * cos(b), z = sticks * sin(a) + holds * sin(b) + down;
	const double px = sin(a + m->tool), pz = cos(a + m->tool), rx = -sin(b + m->friction), rz = cos(b + m->friction);
	return (x * rz - z * rx) / (px * rz - pz * rx);
}

static void the_force_is_the_least_of_all_wedges_in_equilibrium(void **state)
{
	(void)state;
	for (int i = 0; i < 400; i++) {
		const struct mckyes_blade blade = any_blade();
		const struct mckyes_force force = mckyes_force_of(&blade);
		const double most = M_PI - blade.rake - blade.tool - blade.friction;
		double least = INFINITY;
		for (int k = 1; k < 20000; k++)
			least = support_least(least, by_equilibrium(&blade, most * k / 20000));
		assert_near(force.total, least, 1e-5 * least);
		assert_true(force.total <= least * (1 + 1e-12) && force.failure > 0 && force.failure < most);
		assert_near(by_equilibrium(&blade, force.failure), force.total, 1e-9 * force.total);
		assert_near(force.ahead, blade.depth / tan(force.failure), 1e-9);
	}
}

/* An upright smooth blade is Rankine's wall. */
static void an_upright_smooth_blade_is_rankines_wall(void **state)
{
	(void)state;
	for (int degrees = 0; degrees <= 45; degrees += 5) {
		const double phi = degrees * DEGREES, kp = pow(tan(45 * DEGREES + phi / 2), 2);
		const struct mckyes_blade blade = {.depth = 0.2, .width = 2, .rake = M_PI / 2, .friction = phi, .unit_weight = 15e3, .cohesion = 2e3, .surcharge = 1e3};
		const struct mckyes_force force = mckyes_force_of(&blade);
		assert_near(force.failure, 45 * DEGREES - phi / 2, 1e-6);
		assert_near(force.factors.weight, kp / 2, 1e-6 * kp);
		assert_near(force.factors.surcharge, kp, 1e-6 * kp);
		assert_near(force.factors.cohesion, 2 * sqrt(kp), 1e-6 * kp);
		assert_near(force.draft, (15e3 * 0.02 * kp + 2e3 * 0.2 * 2 * sqrt(kp) + 1e3 * 0.2 * kp) * 2, 0.01);
		assert_near(force.lift, 0, 1e-6);
	}
}

/* Coulomb's passive coefficient for level ground, as textbooks have it. wall: of the wall's back above the level, on the side away from the soil. */
static double coulomb(double wall, double phi, double delta)
{
	const double root = sqrt(sin(phi + delta) * sin(phi) / (sin(wall + delta) * sin(wall)));
	return pow(sin(wall - phi) / (sin(wall) * (1 - root)), 2) / sin(wall + delta);
}

static void rough_and_raked_blades_are_coulombs_walls(void **state)
{
	(void)state;
	for (int rake = 30; rake <= 90; rake += 10)
		for (int phi = 20; phi <= 45; phi += 5)
			for (int delta = 0; delta < phi; delta += 5) {
				if (rake == phi)
					continue; /* there the formula is 0 / 0 */
				const struct mckyes_blade blade = {.depth = 0.1, .width = 1, .rake = rake * DEGREES, .friction = phi * DEGREES,
								   .tool = delta * DEGREES, .unit_weight = 15e3};
				const double kp = coulomb(rake * DEGREES, phi * DEGREES, delta * DEGREES);
				assert_near(2 * mckyes_force_of(&blade).factors.weight, kp, 1e-6 * kp);
			}
}

/* Passive coefficients of A. Caquot and J. Kerisel (1948) for curved planes of failure, level ground and upright walls, as handbooks round them. Plane
 * wedges never give less, and at most a tenth more up to a friction of phi / 3. */
static void curved_planes_of_failure_give_much_the_same_for_little_friction(void **state)
{
	static const struct {
		double phi, kp[2]; /* for tool friction 0 and phi / 3 */
	} known[] = {{20, {2.0, 2.3}}, {25, {2.5, 3.0}}, {30, {3.0, 4.0}}, {35, {3.7, 5.4}}, {40, {4.6, 7.5}}};
	(void)state;
	for (size_t i = 0; i < COUNT(known); i++)
		for (int k = 0; k < 2; k++) {
			struct mckyes_blade blade = {.depth = 0.1, .width = 1, .rake = M_PI / 2, .friction = known[i].phi * DEGREES, .unit_weight = 15e3};
			blade.tool = k == 0 ? 0 : blade.friction / 3;
			const double kp = 2 * mckyes_force_of(&blade).factors.weight;
			print_message("phi %.0f, delta %.1f: %.2f (%.1f)\n", known[i].phi, blade.tool / DEGREES, kp, known[i].kp[k]);
			assert_true(kp > known[i].kp[k] - 0.051 && kp < (k == 0 ? 1 : 1.1) * known[i].kp[k] + 0.051); /* the last digit is worth 0.05 */
		}
}

/* Caquot's theorem: cohesion is a pressure of c / tan phi from all sides that nobody sees. The adhesion that goes with it is c tan delta / tan phi. Then
 * cohesion and adhesion follow from the surcharge. It holds for each wedge. */
static void cohesion_follows_from_surcharge(void **state)
{
	(void)state;
	for (int i = 0; i < 1000; i++) {
		const struct mckyes_blade b = any_blade();
		const double most = M_PI - b.rake - b.tool - b.friction;
		const struct mckyes_factors n = mckyes_factors_at(&b, most * (0.5 + 0.4 * any_share()));
		const double expected = (n.surcharge - 1 / (sin(b.rake) * cos(b.tool))) / tan(b.friction);
		assert_near(n.cohesion + n.adhesion * tan(b.tool) / tan(b.friction), expected, 1e-9 * fabs(expected) + 1e-9);
		assert_near(n.surcharge, 2 * n.weight, 1e-12 * n.surcharge);
	}
}

/* A blade is drawn in where it lies flat, and lifted by its adhesion. Force grows with the square of the depth, and with rake and friction. */
static void blades_behave(void **state)
{
	double last = 0;
	(void)state;
	for (int rake = 30; rake <= 90; rake += 5) {
		struct mckyes_blade blade = {.depth = 0.05, .width = 1, .rake = rake * DEGREES, .friction = 35 * DEGREES, .tool = 20 * DEGREES, .unit_weight = 16e3};
		const struct mckyes_force force = mckyes_force_of(&blade);
		print_message("rake %d: draft %.1f N, lift %.1f N, failure %.1f degrees, weight factor %.3f\n", rake, force.draft, force.lift,
			      force.failure / DEGREES, force.factors.weight);
		assert_true(rake < 70 ? force.lift < 0 : rake > 70 ? force.lift > 0 : fabs(force.lift) < 1e-9);
		assert_true(force.draft > last || rake < 45);
		last = force.draft;
		blade.depth *= 4;
		assert_near(mckyes_force_of(&blade).draft, 16 * force.draft, 1e-6 * force.draft);
		blade.adhesion = 1e3;
		assert_true(mckyes_force_of(&blade).lift > 16 * force.lift);
		blade.depth /= 4;
		blade.adhesion = 0;
		blade.tool *= 1.2;
		assert_true(mckyes_force_of(&blade).draft > force.draft);
		blade.surcharge = blade.unit_weight * 0.15;
		blade.tool /= 1.2;
		assert_near(mckyes_force_of(&blade).draft, 7 * force.draft, 1e-6 * force.draft);
	}
}

TEST_PROGRAM(oracles)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(stresses_are_those_of_the_fit),
		cmocka_unit_test(no_direction_and_no_hand_is_preferred),
		cmocka_unit_test(stress_has_no_jumps_while_a_facet_presses),
		cmocka_unit_test(friction_is_limited),
		cmocka_unit_test(a_box_presses_with_its_wall_and_its_sole),
		cmocka_unit_test(a_wheel_is_the_same_on_every_heading),
		cmocka_unit_test(the_force_is_the_least_of_all_wedges_in_equilibrium),
		cmocka_unit_test(an_upright_smooth_blade_is_rankines_wall),
		cmocka_unit_test(rough_and_raked_blades_are_coulombs_walls),
		cmocka_unit_test(curved_planes_of_failure_give_much_the_same_for_little_friction),
		cmocka_unit_test(cohesion_follows_from_surcharge),
		cmocka_unit_test(blades_behave),
	};
	return cmocka_run_group_tests_name("soil/oracles", tests, NULL, NULL);
}
