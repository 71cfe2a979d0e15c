/* Probes of bearing soil: to the bit the contact, and how they say that the force changes beside differences of the force. */
#include "bed.h"
#include "../support/program.h"

#define SIDE 160
#define DEPTH 0.015 /* m */
#define STEPS 24

/* A block that grows wider upwards. */
static float foot_vertices[8][3] = {{0.12f, 0.1f, -0.1f}, {-0.1f, 0.1f, -0.1f}, {-0.1f, -0.1f, -0.1f}, {0.12f, -0.1f, -0.1f},
				    {0.2f, 0.15f, 0.1f}, {-0.2f, 0.15f, 0.1f}, {-0.2f, -0.15f, 0.1f}, {0.2f, -0.15f, 0.1f}};
static uint32_t foot_triangles[12][3] = {{0, 3, 2}, {0, 2, 1}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
static const struct soil_mesh foot = {foot_vertices, foot_triangles, 8, 12, {-0.2, -0.15, -0.1}, {0.2, 0.15, 0.1}};

static const struct kind {
	const char *name;
	struct soil_shape shape;
	double pitch, roll; /* degrees */
	bool rolls;
} kinds[] = {
	{"wheel", {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2}, 0, 0, true},
	{"leaning wheel", {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2}, 0, 9, true},
	{"sphere", {.kind = SOIL_SPHERE, .radius = 0.25}, 0, 0, true},
	{"ellipsoid", {.kind = SOIL_ELLIPSOID, .size = {0.3, 0.2, 0.15}}, 0, 0, true},
	{"leaning ellipsoid", {.kind = SOIL_ELLIPSOID, .size = {0.3, 0.2, 0.15}}, 20, 30, false},
	{"capsule", {.kind = SOIL_CAPSULE, .radius = 0.15, .length = 0.3}, 90, 0, true},
	{"leaning capsule", {.kind = SOIL_CAPSULE, .radius = 0.15, .length = 0.3}, 50, 10, false},
	{"box", {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.2}}, 0, 0, false},
	{"tilted box", {.kind = SOIL_BOX, .size = {0.3, 0.2, 0.2}}, 3, 0, false},
	{"cylinder that lies", {.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.3}, 0, 90, true},
	{"steep cylinder", {.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.3}, 0, 25, false},
	{"upright cylinder", {.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.3}, 0, 0, false},
	{"mesh", {.kind = SOIL_MESH, .mesh = &foot}, 0, 0, false},
	{"leaning mesh", {.kind = SOIL_MESH, .mesh = &foot}, -11, 7, false},
};

/* A body that sinks and then rolls on. slip: of a body that turns; 1: it does not turn. */
struct drive {
	struct bed *bed;
	const struct kind *kind;
	struct bed_state now;
	struct soil_motion motion;
	double heading, radius, slip;
};

/* Presses the body after a way along its heading, along the slope, and down. */
static void drive_on(struct drive *d, double along, double down, bool commit)
{
	struct bed *bed = d->bed;
	const double c = cos(d->heading), s = sin(d->heading), turned = d->slip < 1 ? along / (1 - d->slip) / d->radius : 0;
	const double rotated[3] = {-s * turned, c * turned, 0};
	const struct bed_state before = d->now;
	d->now.at[0] += along * c;
	d->now.at[1] += along * s;
	d->now.at[2] += along * (bed->slope[0] * c + bed->slope[1] * s) - down;
	for (int k = 0; k < 3 && d->kind->shape.kind != SOIL_WHEEL; k++)
		bed_turn(&d->now, k, 0);
	d->motion = bed_motion(&d->kind->shape, &before, &d->now, rotated);
	if (commit)
		bed_press(bed, &d->motion, 0);
}

/* The body has sunk, and rolled on over `posts` posts. Then it is about to move on. */
static struct drive driven(struct bed *bed, const struct kind *kind, double heading, double slip, int posts)
{
	struct drive d = {bed, kind, .heading = heading, .slip = slip};
	const double spacing = bed->law.spacing, middle = SIDE / 2 * spacing;
	d.now = bed_state(middle + 0.0173 - posts * spacing / 2, middle + 0.0071, 0, heading, kind->pitch * DEGREES, kind->roll * DEGREES);
	d.radius = soil_shape_reach(&kind->shape, kind->pitch * DEGREES, kind->roll * DEGREES);
	const double steep = hypot(bed->slope[0], bed->slope[1]), beside = kind->shape.kind == SOIL_BOX ? 0.15 * steep : 0;
	const double round = kind->shape.kind == SOIL_BOX || kind->shape.kind == SOIL_CYLINDER ? 1 : sqrt(1 + steep * steep);
	d.now.at[2] = bed_ground(bed, d.now.at[0], d.now.at[1]) + d.radius * round + beside + 0.002;
	for (int i = 0; i < STEPS; i++)
		drive_on(&d, 0, (DEPTH + 0.002) / STEPS, true);
	for (int i = 0; i < posts; i++)
		drive_on(&d, spacing, 0, true);
	return d;
}

/* --- the contact --- */

static void a_probe_is_the_contact_to_the_bit(void **state)
{
	static const double slopes[] = {0, 12}, slips[] = {0, 0.2, -0.3, 1};
	int touches = 0, all = 0;
	for (size_t i = 0; i < COUNT(kinds); i++)
		for (int k = 0; k < 8; k++) {
			struct bed bed;
			const struct soil_numbers soil = bed_soil("dry_sand");
			bed_init(&bed, &soil, k % 3 == 0 ? 0.015625 : 0.03125, SIDE, tan(slopes[k % 2] * DEGREES), 0);
			bed.law.slip_sinkage = k == 5 ? 0.5 : 0;
			bed.law.bulldozing = 0.5;
			struct drive d = driven(&bed, &kinds[i], 0.3 * k, slips[k / 2], 4);
			for (int step = 0; step < 6; step++) {
				drive_on(&d, 0.4 * bed.law.spacing, step % 3 == 2 ? -1e-4 : 3e-4, false);
				d.motion.linear[0] = 0.01 * k;
				d.motion.linear[2] = step % 3 == 2 ? 0.01 : -0.03;
				const struct soil_probed probed = bed_probe(&bed, &d.motion), again = bed_probe(&bed, &d.motion);
				const struct soil_forces felt = bed_feel(&bed, &d.motion, 0);
				const struct soil_forces told = bed_press(&bed, &d.motion, 0).forces;
				touches += told.force[2] > 0;
				all++;
				assert_true(probed.known);
				assert_memory_equal(&probed, &again, sizeof probed);
				assert_memory_equal(&felt, &told, sizeof felt);
				assert_memory_equal(probed.force, told.force, sizeof told.force);
				assert_memory_equal(probed.moment, told.moment, sizeof told.moment);
				assert_true(probed.pull == told.pull && probed.area == told.area && probed.sinkage == told.sinkage);
			}
			bed_finish(&bed);
		}
	assert_true(touches > 0.9 * all);
}

/* With a load: the forces that a search ends with are those of a contact. */
static void feeling_with_a_load_is_the_contact(void **state)
{
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.02, SIDE, 0.05, 0);
	for (size_t i = 0; i < COUNT(kinds); i++) {
		bed_reset(&bed);
		struct drive d = driven(&bed, &kinds[i], 0.7, 0.2, 2);
		drive_on(&d, 0.02, 0, false);
		d.motion.load = 900;
		int32_t *before = mem_alloc(bed.posts, sizeof *before);
		assert_non_null(before);
		memcpy(before, bed.planes.sinkage, bed.posts * sizeof *before);
		const struct soil_forces felt = bed_feel(&bed, &d.motion, -3000);
		assert_memory_equal(before, bed.planes.sinkage, bed.posts * sizeof *before);
		const struct soil_forces told = bed_press(&bed, &d.motion, -3000).forces;
		assert_memory_equal(&felt, &told, sizeof felt);
		assert_near(told.force[2], 900, 1e-3);
		mem_free(before);
	}
	bed_finish(&bed);
}

static void a_probe_beside_the_planes_is_not_known(void **state)
{
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.02, SIDE, 0, 0);
	struct drive d = driven(&bed, &kinds[0], 0, 1, 0);
	assert_true(bed_probe(&bed, &d.motion).known);
	d.now.at[0] = 0.26; /* the wheel's edge is less than a post from the edge of the planes */
	d.motion = bed_motion(&kinds[0].shape, &d.now, &d.now, NULL);
	assert_false(bed_probe(&bed, &d.motion).known);
	d.now.at[0] = 1;
	d.now.at[2] += 0.5;
	d.motion = bed_motion(&kinds[0].shape, &d.now, &d.now, NULL);
	const struct soil_probed air = bed_probe(&bed, &d.motion);
	assert_true(air.known && air.state == SOIL_AIR && air.force[2] == 0 && isnan(air.normal[0]));
	bed_finish(&bed);
}

/* --- how the force changes --- */

/* The motion with one of six freedoms moved, or its velocity changed. */
static struct soil_motion moved(const struct drive *d, const struct bed_state *from, const double rotated[3], int freedom, double by, bool rate)
{
	struct bed_state to = d->now;
	double turned[3] = {rotated[0], rotated[1], rotated[2]};
	if (!rate && freedom < 3)
		to.at[freedom] += by;
	if (!rate && freedom >= 3) {
		bed_turn(&to, freedom - 3, by);
		turned[freedom - 3] += by;
	}
	struct soil_motion motion = bed_motion(&d->kind->shape, from, &to, turned);
	memcpy(motion.linear, d->motion.linear, sizeof motion.linear);
	memcpy(motion.angular, d->motion.angular, sizeof motion.angular);
	if (rate)
		*(freedom < 3 ? &motion.linear[freedom] : &motion.angular[freedom - 3]) += by;
	return motion;
}

static double part(const struct soil_probed *probed, int i)
{
	return i < 3 ? probed->force[i] : probed->moment[i - 3];
}

struct off {
	double worst, least, most; /* as a share of the diagonal; quotients of diagonals */
};

/* Returns the root of a diagonal of a matrix, or of a tenth of the greatest of its kind: a body whose shear is at its limit has almost no stiffness along. */
static double scale_of(const double matrix[6][6], int i)
{
	double greatest = 0;
	for (int k = i / 3 * 3; k < i / 3 * 3 + 3; k++)
		greatest = support_most(greatest, fabs(matrix[k][k]));
	return sqrt(fmax(fabs(matrix[i][i]), 0.1 * greatest));
}

/* Compares a matrix with quotients of differences. freedoms: a bit for each. */
static struct off off_by(const struct drive *d, const struct bed_state *from, const double rotated[3], unsigned freedoms, bool rate)
{
	struct soil_motion here = moved(d, from, rotated, 0, 0, false);
	const struct soil_probed probed = bed_probe(d->bed, &here);
	const double (*matrix)[6] = rate ? probed.damping : probed.stiffness;
	struct off off = {0, INFINITY, 0};
	for (int k = 0; k < 6; k++) {
		if (!(freedoms & 1u << k))
			continue;
		const double by = rate ? 1e-5 : k < 3 ? 4e-6 : 3e-5;
		const struct soil_motion more = moved(d, from, rotated, k, by, rate), less = moved(d, from, rotated, k, -by, rate);
		const struct soil_probed high = bed_probe(d->bed, &more), low = bed_probe(d->bed, &less);
		for (int i = 0; i < 6; i++) {
			const double slope = (part(&high, i) - part(&low, i)) / (2 * by);
			const double off_here = fabs(matrix[i][k] - slope) / (scale_of(matrix, i) * scale_of(matrix, k));
			if (getenv("PROBE_TRACE") != NULL)
				print_message("    [%d][%d] %12.5g, by differences %12.5g\n", i, k, matrix[i][k], slope);
			if (freedoms & 1u << i)
				off.worst = support_most(off.worst, off_here);
			if (i == k && 0.999 * scale_of(matrix, i) * scale_of(matrix, i) <= fabs(matrix[i][i])) {
				if (slope < 0)
					off.least = support_least(off.least, matrix[i][i] / slope);
				off.most = support_most(off.most, matrix[i][i] / slope);
			}
		}
	}
	return off;
}

static void stiffness_and_damping_are_how_the_force_changes(void **state)
{
	static const struct {
		double slope, slip;
		int posts;
	} rows[] = {{0, 1, 0}, {12, 1, 0}, {0, 1, 12}, {0, 0, 12}, {0, 0.2, 12}, {0, -0.3, 12}, {6, 0.2, 12}};
	for (size_t i = 0; i < COUNT(kinds); i++)
		for (size_t r = 0; r < (kinds[i].rolls ? COUNT(rows) : 3); r++) {
			struct bed bed;
			const struct soil_numbers soil = bed_soil("dry_sand");
			bed_init(&bed, &soil, 0.015625, SIDE, tan(rows[r].slope * DEGREES), 0);
			struct drive d = driven(&bed, &kinds[i], rows[r].posts > 0 ? 0.3 : 0.35, rows[r].slip, rows[r].posts);
			const struct bed_state from = d.now;
			const double way = rows[r].posts > 0 ? 0.5 * bed.law.spacing : 2e-4;
			drive_on(&d, way, 6e-4, false);
			d.motion.linear[0] = 0.0005;
			d.motion.linear[2] = -0.02;
			const double turned = d.slip < 1 ? way / (1 - d.slip) / d.radius : 0, rotated[3] = {-sin(d.heading) * turned, cos(d.heading) * turned, 0};
			const bool wheel = kinds[i].shape.kind == SOIL_WHEEL;
			/* A wheel's shear does not know that it turns about other axes than its axle. */
			const unsigned freedoms = !wheel ? 0x3f : kinds[i].roll > 0 ? 0x07 : 0x17;
			const struct off stiff = off_by(&d, &from, rotated, freedoms, false), slow = off_by(&d, &from, rotated, 0x07, true);
			const struct off ways = off_by(&d, &from, rotated, 0x07, false);
			print_message("%s, slope %g, slip %g: stiffness %.3f (%.2f .. %.2f), ways alone %.3f, damping %.3f (%.2f .. %.2f)\n", kinds[i].name, rows[r].slope,
				      rows[r].slip, stiff.worst, stiff.least, stiff.most, ways.worst, slow.worst, slow.least, slow.most);
			/* Most forms bear by whole posts, so their forces jump as they turn. */
			const bool set_down = rows[r].posts == 0;
			/* A mesh that is few posts wide: how the edges between its facets move over the posts is left out. Known to be wrong: on a slope, or after a
			 * way, some cells below edges jump. */
			const bool mesh = kinds[i].shape.kind == SOIL_MESH;
			assert_true(!mesh || r > 0 || kinds[i].roll != 0 || (ways.worst < 0.8 && ways.least > 0.85 && ways.most < 2.8));
			assert_true(mesh || ways.worst < 0.4);
			assert_true(mesh || (!set_down || (stiff.worst < 0.4 && stiff.least > 0.75 && stiff.most < 1.3)));
			/* How cohesion fades with the pressure is in both, but not how it bends within a cell. */
			assert_true(!kinds[i].rolls || (stiff.worst < 0.65 && stiff.least > 0.63 && stiff.most < 1.9));
			/* Where the damping of what settles falls with the speed, it is told as constant. */
			assert_true(slow.least > 0.85); /* and how cohesion fades with it */
			const struct soil_probed probed = bed_probe(&bed, &d.motion);
			for (int k = 0; k < 6; k++)
				assert_true(mesh || (probed.stiffness[k][k] < 0 && probed.damping[k][k] <= 0));
			bed_finish(&bed);
		}
}

/* --- hosts --- */

/* Returns how deep a ball goes that falls into the soil: the host integrates every step by a probe, then commits. implicit: by stiffness and damping. */
static double stops_at(const struct soil_shape *ball, double mass, double speed, double step, bool implicit, double *rebound)
{
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.015625, 96, 0, 0);
	struct bed_state now = bed_state(0.7503, 0.7411, bed.height + ball->radius, 0, 0, 0);
	double v = -speed, deepest = 0;
	*rebound = 0;
	for (double t = 0; t < 0.5; t += step) {
		struct soil_motion motion = bed_motion(ball, &now, &now, NULL);
		motion.linear[2] = v;
		const struct soil_probed probed = bed_probe(&bed, &motion);
		const double force = probed.force[2] - mass * 9.81, stiff = probed.stiffness[2][2], slow = probed.damping[2][2];
		v += implicit ? (step * force + step * step * stiff * v) / (mass - step * slow - step * step * stiff) : step * force / mass;
		const struct bed_state before = now;
		now.at[2] += step * v;
		motion = bed_motion(ball, &before, &now, NULL);
		motion.linear[2] = v;
		bed_press(&bed, &motion, 0);
		deepest = fmax(deepest, bed.height + ball->radius - now.at[2]);
		*rebound = fmax(*rebound, v);
	}
	bed_finish(&bed);
	return deepest;
}

/* While the ball sinks, its stiffness is that of yielding soil. At rest or on its way up the soil springs back. */
static void a_ball_that_falls_stops_at_one_depth_for_every_host(void **state)
{
	static const struct soil_shape balls[] = {{.kind = SOIL_SPHERE, .radius = 0.15}, {.kind = SOIL_SPHERE, .radius = 0.1}};
	for (size_t i = 0; i < COUNT(balls); i++)
		for (int k = 0; k < 2; k++) {
			double up[3];
			const double speed = 1 + 2 * k, fine = stops_at(&balls[i], 20, speed, 1e-4, false, &up[0]), wanted = stops_at(&balls[i], 20, speed, 2.5e-4, false, &up[1]);
			const double got = stops_at(&balls[i], 20, speed, 2.5e-4, true, &up[2]);
			print_message("radius %g m, %g m/s: explicit %.3f mm (at a shorter step %.3f), implicit %.3f mm\n", balls[i].radius, speed, wanted * 1e3,
				      fine * 1e3, got * 1e3);
			assert_near(got, fine, 0.01 * fine);
			assert_near(wanted, fine, 0.01 * fine);
			/* Soil gives no energy. */
			assert_true(up[0] < 0.3 * speed && up[2] < 0.3 * speed);
		}
}

static void stiffness_follows_the_way_that_the_body_goes(void **state)
{
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.015625, SIDE, 0, 0);
	for (size_t i = 0; i < COUNT(kinds); i++) {
		bed_reset(&bed);
		const struct drive d = driven(&bed, &kinds[i], 0.2, 1, 0);
		double stiff[3];
		for (int k = 0; k < 3; k++) {
			struct soil_motion motion = bed_motion(&kinds[i].shape, &d.now, &d.now, NULL);
			motion.linear[2] = 0.02 * (k - 1);
			stiff[k] = -bed_probe(&bed, &motion).stiffness[2][2];
		}
		print_message("%s: %.4g N/m as it sinks, %.4g at rest, %.4g as it rises\n", kinds[i].name, stiff[0], stiff[1], stiff[2]);
		assert_true(stiff[0] < 0.2 * stiff[2] && stiff[1] > 0.99 * stiff[2]);
	}
	bed_finish(&bed);
}

/* What moves slowly sticks and settles: damping is greatest at rest. Of a plate it is the soil's, ten times as much down, and none up once it leaves. */
static void what_moves_slowly_sticks_and_settles(void **state)
{
	static const struct kind plate = {"plate", {.kind = SOIL_BOX, .size = {0.32, 0.2, 0.2}}, 0, 0, false};
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.01, SIDE, 0, 0);
	const struct drive d = driven(&bed, &plate, 0, 1, 0);
	const double area = 0.32 * 0.2, whole = soil.damping * area * fmin(4 * DEPTH / soil.janosi_shear, 1);
	static const double speeds[] = {0, 0.001, 0.01, 0.1};
	double before[2] = {INFINITY, INFINITY};
	for (size_t i = 0; i < COUNT(speeds); i++) {
		struct soil_motion motion = bed_motion(&plate.shape, &d.now, &d.now, NULL);
		motion.linear[2] = -speeds[i];
		motion.linear[0] = speeds[i];
		const struct soil_probed probed = bed_probe(&bed, &motion);
		const double down = -probed.damping[2][2], along = -probed.damping[1][1], slow = 1 / (1 + speeds[i] * speeds[i] / (0.002 * 0.002));
		assert_near(down, whole * (1 + 10 * slow * fmax(2 * slow - 1, 0)), 0.01 * whole);
		assert_near(along, whole / (1 + speeds[i] * speeds[i] / (0.003 * 0.003)), 0.01 * whole);
		assert_true(down <= before[0] && along < before[1]);
		before[0] = down;
		before[1] = along;
	}
	bed_finish(&bed);
}

TEST_PROGRAM(probe)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_probe_is_the_contact_to_the_bit),
		cmocka_unit_test(feeling_with_a_load_is_the_contact),
		cmocka_unit_test(a_probe_beside_the_planes_is_not_known),
		cmocka_unit_test(stiffness_and_damping_are_how_the_force_changes),
		cmocka_unit_test(a_ball_that_falls_stops_at_one_depth_for_every_host),
		cmocka_unit_test(stiffness_follows_the_way_that_the_body_goes),
		cmocka_unit_test(what_moves_slowly_sticks_and_settles),
	};
	return cmocka_run_group_tests_name("soil/probe", tests, NULL, NULL);
}
