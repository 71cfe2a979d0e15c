/*
 * Random small grounds, objects and sweeps: what the GPU makes of each is what the reference makes of it, post by post.
 *
 * Each sweep begins from what the GPU has, so that what it may be off by is what one sweep may. Two things are compared, each as
 * closely as it can be: the undersides, to the micrometres that they are rounded to; and, from one and the same
 * underside, all that follows, to the quanta that are rounded on the way. Where doubles and whole quanta must decide between
 * two ways they may differ at a tie: such posts are found, counted, and must be few.
 */
#include "../support/near.h"
#include "matched.h"
#include "../support/program.h"

/* --- pressing --- */

/* Where it rests, alone: the sinkage there and the largest are rounded apart, and what is elastic may be less than either. */
static void shift_rest(double by)
{
	for (int i = 0; i < COUNT; i++)
		match.rest[i] += by;
}

static struct reference_forces press(double lower, const struct deform_contact *sweep)
{
	struct reference_ground *reference = &match.reference;
	const struct soil_numbers *soil = &match.params.soils[0];
	struct reference_forces forces = {.area = 0};
	begin_reference();
	if (match.params.model == DEFORM_NONE)
		reference_none(reference, match.under, match.rest);
	else if (match.params.model == DEFORM_SUMNER)
		reference_sumner(reference, soil, match.under, match.rest);
	else if (match.params.model == DEFORM_SLIPPAGE)
		reference_slippage(reference, match.under, match.rest);
	else
		reference_scm(reference, soil, match.params.bulldozing, sweep, match.under, match.rest, lower, &forces);
	return forces;
}

/*
 * Contacts are the same. Of scm sinkages are whole quanta and the stress's power is of single precision: a quantum or two higher or lower
 * may be another contact. Of the others nothing is rounded: no tie.
 */
static int compare_contacts(double lower, const struct deform_contact *sweep, double slant)
{
	static uint8_t above[COUNT], below[COUNT];
	int ties = 0;
	if (match.params.model == DEFORM_SCM) {
		double within = (1 + slant) * QUANTUM;
		shift_rest(within);
		press(lower - within, sweep);
		memcpy(above, match.reference.contact, COUNT);
		shift_rest(-2 * within);
		press(lower + within, sweep);
		memcpy(below, match.reference.contact, COUNT);
		shift_rest(within);
	}
	press(lower, sweep);
	for (int i = 0; i < COUNT; i++) {
		uint8_t got = match.contacts[i] & 3, wanted = match.reference.contact[i];
		match.loose[i] = got != wanted;
		if (got == wanted)
			continue;
		if (match.params.model != DEFORM_SCM || (got != above[i] && got != below[i]))
			fail_msg("post %d, %d: contact %d, by the reference %d", i % POSTS, i / POSTS, got, wanted);
		match.reference.contact[i] = got;
		ties++;
	}
	seen.ties += ties;
	return ties;
}

/* How much steeper than level: one over the z of the normal, at most, under the object. */
static double aslant(void)
{
	double steepest = 0;
	for (int i = 0; i < COUNT; i++)
		for (int k = 0; k < 4 && match.contacts[i] % 4 != 0; k++) {
			int x = i % POSTS + (k - 1) % 2, y = i / POSTS + (k - 2) % 2, j = y * POSTS + x;
			if (x < 0 || y < 0 || x >= POSTS || y >= POSTS || match.reference.hole[j])
				continue;
			double rise = match.reference.base[i] - match.reference.base[j];
			steepest = support_most(steepest, fabs(rise) / match.reference.spacing);
		}
	return fmin(20, sqrt(1 + 2 * steepest * steepest));
}

/* Posts that soil is carried from. */
static int givers(void)
{
	int count = 0;
	for (int i = 0; i < COUNT; i++)
		count += match.reference.carried[i] != 0;
	return count;
}

/* --- sliding --- */

static void loosen(int at, int by)
{
	for (int y = at / POSTS - by; y <= at / POSTS + by; y++)
		for (int x = at % POSTS - by; x <= at % POSTS + by; x++)
			if (x >= 0 && y >= 0 && x < POSTS && y < POSTS)
				match.loose[y * POSTS + x] = true;
}

/* Sumner's soil goes or does not: a post that is nearly at an angle does one thing or the other, and those around get what they
 * get. `error`: metres that heights may be off by. */
static void loosen_undecided(double error)
{
	const struct soil_numbers *soil = &match.params.soils[0];
	const double angles[] = {soil->theta_in, soil->theta_out, soil->theta_stop};
	const struct reference_ground *r = &match.reference;
	static bool undecided[COUNT];
	memset(undecided, 0, sizeof undecided);
	for (int i = 0; i < COUNT; i++)
		for (int k = 0; k < 9 && written(i % POSTS, i / POSTS) && !r->hole[i]; k++) {
			int x = i % POSTS + k % 3 - 1, y = i / POSTS + k / 3 - 1, j = y * POSTS + x;
			if (k == 4 || !written(x, y) || r->hole[j])
				continue;
			double drop = r->base[i] + r->offset[i] - r->base[j] - r->offset[j];
			for (int a = 0; a < 3; a++)
				undecided[i] |= fabs(drop - tan(angles[a]) * r->spacing * (k % 2 == 0 ? sqrt(2) : 1)) <= 2 * error;
		}
	for (int i = 0; i < COUNT; i++)
		if (undecided[i])
			loosen(i, 1);
}

static void spread(int by)
{
	static bool was[COUNT];
	memcpy(was, match.loose, sizeof was);
	for (int i = 0; i < COUNT; i++)
		if (was[i])
			loosen(i, by);
}

/* Iteration by iteration; heights begin within `error`, which is returned as it is at the end. */
static double slide(double error)
{
	bool sumner = match.params.model == DEFORM_SUMNER;
	for (int n = 0; n < match.params.iterations; n++) {
		double moved;
		if (sumner)
			loosen_undecided(error);
		spread(sumner ? 2 : 1);
		assert_int_equal(reference_slide(&match.reference, &match.params, 1, 0, &moved), STATUS_OK);
		seen.slid += moved > 0;
		/* To each of eight and from each of eight a quantum is rounded. By the excess's rule no error grows: what each gives
		 * rises by an eighth of what it is higher by. By Sumner's a share, at most, of two differences. */
		error = (sumner ? error * (1 + 4 * match.params.soils[0].roughness) : error) + 9 * QUANTUM;
	}
	return error;
}

/* --- comparing --- */

static void compare_posts(double error, double pressed)
{
	for (int i = 0; i < COUNT; i++) {
		seen.loosened += match.loose[i];
		seen.pressed += match.contacts[i] % 4 != 0;
		if (match.reference.hole[i])
			assert_int_equal(match.plane[PLANE_OFFSET][i], 0);
		if (match.loose[i])
			continue;
		near_enough("offset", i, lattice_offset_metres(match.plane[PLANE_OFFSET][i]), match.reference.offset[i], error);
		if (match.params.model != DEFORM_SCM)
			continue;
		near_enough("heaped", i, lattice_offset_metres(match.plane[PLANE_DEPOSITED][i]), match.reference.heaped[i], error);
		near_enough("pressed", i, lattice_offset_metres(match.plane[PLANE_PLASTIC_SINKAGE][i]), match.reference.pressed[i], pressed);
		near_enough("dug", i, lattice_offset_metres(match.plane[PLANE_DUG][i]), match.reference.dug[i], 4 * QUANTUM);
		/* To steps of 2^-15; from single precision of a way of up to a metre; and a quantum of height moves the place of first touch. */
		for (int part = PLANE_SHEAR_EAST; part <= PLANE_SHEAR_NORTH; part++) {
			double shear = ldexp(plane_shear(match.plane[PLANE_SHEAR][i], part), -PLANE_SHEAR_BITS), wanted = match.reference.shear[part][i];
			if (!(fabs(shear - wanted) <= 0x1p-15 + 2e-4 / match.params.soils[0].janosi_shear))
				fail_msg("shear at post %d, %d: %.9g, by the reference %.9g", i % POSTS, i / POSTS, shear, wanted);
		}
	}
}

/* Pa: what the soil bears a quantum below its surface; no object is narrower. */
static double brush(void)
{
	return reference_bekker(&match.params.soils[0], match.reference.spacing / 2, QUANTUM);
}

static void compare_forces(const struct deform_forces *got, const struct reference_forces *wanted, int ties,
			   const struct soil_shape *shape)
{
	const struct soil_numbers *soil = &match.params.soils[0];
	double post = match.reference.spacing * match.reference.spacing, arm = soil_shape_bound(shape) * 1.5, size = 0;
	for (int k = 0; k < 3; k++)
		size = hypot(size, wanted->force[k]);
	/* A tie moves a part's border by a post each way. Each part is rounded. */
	assert_true(fabs(got->area - wanted->area) <= (2.25 * ties + 1e-3) * post + 1e-4 * wanted->area);
	/* A quantum of sinkage is K_e quanta of stress, or near the surface what the soil bears there. What is in contact or not brings
	 * cohesion and damping besides. */
	double error = 1e-3 * size + wanted->area * (soil->elastic_stiffness * QUANTUM + brush()) + 0x1p-10;
	for (int k = 0; k < 3 && ties == 0; k++) {
		if (!(fabs(got->force[k] - wanted->force[k]) <= error) || !(fabs(got->moment[k] - wanted->moment[k]) <= error * arm))
			fail_msg("force %d: %.9g N, %.9g N m, by the reference %.9g, %.9g; allowed %.3g N", k, got->force[k], got->moment[k],
				 wanted->force[k], wanted->moment[k], error);
		seen.force = support_most(seen.force, fabs(got->force[k] - wanted->force[k]) / error);
	}
}

static void scale(struct reference_forces *forces, double by)
{
	for (int k = 0; k < 3; k++) {
		forces->force[k] *= by;
		forces->moment[k] *= by;
	}
}

/* At the height found the reference carries the load, and a little above it does not. */
static void compare_load(const struct deform_contact *sweep, const struct deform_forces *got, double slant)
{
	double lower = lattice_offset_metres(sweep->to.z - got->z), wanted, within = (1 + slant) * QUANTUM;
	const struct soil_numbers *soil = &match.params.soils[0];
	begin_reference();
	assert_int_equal(reference_load(&match.reference, soil, sweep, match.under, match.rest, &wanted), STATUS_OK);
	shift_rest(-within);
	double deeper = reference_scm_vertical(&match.reference, soil, sweep, match.under, match.rest, lower + within);
	shift_rest(2 * within);
	double higher = reference_scm_vertical(&match.reference, soil, sweep, match.under, match.rest, lower - within);
	shift_rest(-within);
	/* Heights are whole quanta, and sinkages along the normal. Of a post's own half a quantum is rounded: K_e quanta of stress. */
	double error = 2e-5 * sweep->load + got->area * (soil->elastic_stiffness * QUANTUM / 2 + brush());
	if (!(deeper >= sweep->load - error) || !(higher <= sweep->load + error))
		fail_msg("%g N: it stands %.9g m lower, where the reference bears %.9g to %.9g N; by the reference %.9g m lower",
			 sweep->load, lower, higher, deeper, wanted);
	seen.loads++;
}

/* What a load is borne by may jump: a cell bears as a whole, or not. Where the load lies between, a quantum decides. */
static int at_a_jump(double lower, const struct deform_contact *sweep, double slant)
{
	const struct soil_numbers *soil = &match.params.soils[0];
	double within = (1 + slant) * QUANTUM;
	shift_rest(-within);
	struct reference_forces deeper = press(lower + within, sweep);
	shift_rest(2 * within);
	struct reference_forces higher = press(lower - within, sweep);
	shift_rest(-within);
	return deeper.force[2] - higher.force[2] > 0.01 * sweep->load + deeper.area * soil->elastic_stiffness * 4 * within;
}

static void run(const struct deform_contact *sweep)
{
	struct ground *ground = &match.ground;
	struct deform_tally before, after;
	struct deform_forces forces = {.z = sweep->to.z};
	bool taken = false, scm = match.params.model == DEFORM_SCM;
	int64_t sum = 0;
	read_planes();
	assert_ok(deform_tally(ground->deform, &before));
	ground_sweep(ground, sweep);
	if (ground->window_count == 0)
		return;
	assert_int_equal(ground->window_count, 1);
	assert_ok(deform_forces_begin(ground->deform));
	assert_ok(deform_forces_take(ground->deform, true, &forces, &taken));
	assert_true(taken == scm);
	assert_ok(deform_tally(ground->deform, &after));
	begin_reference();
	uint8_t *contacts = ground_contacts(ground);
	for (int i = 0; i < COUNT; i++) /* those of the rim mean nothing */
		match.contacts[i] = written(i % POSTS, i / POSTS) ? contacts[i] : 0;
	mem_free(contacts);
	share_undersides(sweep);
	double lower = lattice_offset_metres(sweep->to.z - forces.z), slant = scm ? aslant() : 1;
	if (sweep->load > 0 && forces.state != DEFORM_SUNK && forces.area > 0)
		compare_load(sweep, &forces, slant);
	int ties = compare_contacts(lower, sweep, slant) + (sweep->load > 0 ? at_a_jump(lower, sweep, slant) : 0);
	struct reference_forces wanted = press(lower, sweep);
	for (int i = 0; i < COUNT; i++)
		match.reference.contact[i] = match.contacts[i] & 3;
	/* Within the unit of height that carries the load, forces are scaled to it. */
	if (sweep->load > 0 && forces.state != DEFORM_SUNK && forces.area > 0)
		scale(&wanted, sweep->load / wanted.force[2]);
	if (scm)
		compare_forces(&forces, &wanted, ties, sweep->shape);
	/* A sinkage is whole quanta, half a one off; what stays of it, upright, is rounded again; single precision of its
	 * stress, 1e-5 of 2 MPa over K_e. */
	double released = scm ? (2 * slant + 1) * QUANTUM : 0;
	double error = released;
	bool undecided = false;
	if (match.params.model != DEFORM_NONE) {
		/* What is carried is rounded down; of scm's it is the difference of two that were released. Lengths are whole 64ths of a
		 * post, and places are rounded too: a tie is one of them off, and a width off by one shifts a whole side of a band. What
		 * is left of rounding, less than a quantum a row, is on one post. */
		struct reference_laying laying;
		static double before_laying[COUNT];
		double lost = givers() * (QUANTUM + 2 * released);
		memcpy(before_laying, match.reference.offset, sizeof before_laying);
		assert_int_equal(reference_spread(&match.reference, &match.params, sweep, &laying), STATUS_OK);
		undecided = laying.undecided;
		error += laying.rate * (2 * match.reference.spacing / 64 + 0.005 * laying.width / 3) + lost * laying.share * laying.width / 3;
		error += (double)(match.reference.written.y1 - match.reference.written.y0) * QUANTUM;
		if (!undecided)
			share_slides(before_laying, lower, error);
		error = slide(error);
	}
	for (int i = 0; i < COUNT; i++)
		sum -= match.plane[PLANE_OFFSET][i];
	read_planes();
	for (int i = 0; i < COUNT; i++)
		sum += match.plane[PLANE_OFFSET][i];
	if (match.params.model != DEFORM_NONE)
		assert_int_equal(sum, before.compacted - after.compacted);
	assert_int_equal(after.refused, before.refused);
	if (undecided) {
		seen.undecided++;
		seen.sweeps++;
		return;
	}
	compare_posts(error, scm ? 2 * QUANTUM : 0);
	if (ties == 0 && match.params.model != DEFORM_NONE) {
		double post = match.reference.spacing * match.reference.spacing;
		int pressed = 0;
		for (int i = 0; i < COUNT; i++)
			pressed += match.contacts[i] & 1;
		near_enough("compacted", 0, lattice_offset_metres(after.compacted - before.compacted),
			    match.reference.compacted / post, pressed * 2 * (QUANTUM + released) + QUANTUM);
	}
	seen.sweeps++;
}

/* --- what is swept --- */

static uint32_t rough_seed;
static double rough_height, slope_east, slope_north;

static int32_t any_ground(int64_t x, int64_t y)
{
	uint32_t h = ((uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u) + rough_seed;
	h ^= h >> 15;
	h *= 2654435761u;
	bool hole = (h >> 8) % 200 == 0 || (llabs(x - 40) < 3 && llabs(y - 52) < 2);
	double height = rough_height * ldexp(h, -32) + slope_east * (double)(x - POSTS / 2) + slope_north * (double)(y - POSTS / 2);
	return hole ? BASE_NODATA : (int32_t)lattice_base(height);
}

static double any_between(double low, double high)
{
	return low + (high - low) * (any_share() + 1) / 2;
}

static struct soil_shape any_shape(double spacing)
{
	struct soil_shape shape = {.kind = (enum soil_shape_kind)(any_word() % 3)};
	shape.radius = any_between(3, 14) * spacing;
	shape.width = any_between(1.5, 12) * spacing;
	for (int k = 0; k < 3; k++)
		shape.size[k] = any_between(2, 18) * spacing;
	return shape;
}

static struct deform_contact any_sweep(const struct soil_shape *shape, int k, double x, double y)
{
	double spacing = match.reference.spacing;
	struct soil_pose pose = {.yaw = 4 * any_share()};
	if (shape->kind == SOIL_BOX && any_word() % 2) {
		pose.pitch = 0.3 * any_share();
		pose.roll = 0.3 * any_share();
	}
	/* As deep in the ground there as some posts. */
	int at = (int)fmin(fmax(y, 0), POSTS - 1) * POSTS + (int)fmin(fmax(x, 0), POSTS - 1);
	double ground = match.ground.base[at] == BASE_NODATA ? 0 : lattice_base_metres(match.ground.base[at]);
	double z = ground + soil_shape_reach(shape, pose.pitch, pose.roll) - any_between(-0.2, 3) * spacing;
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(&match.ground, x, y, z), .to = pose};
	struct soil_pose to = ground_pose(&match.ground, x + 2 * any_share(), y + 2 * any_share(), z - 0.5 * spacing * any_share());
	sweep.to.x = to.x;
	sweep.to.y = to.y;
	sweep.to.z = to.z;
	if (k % 4 == 3) {
		sweep.from = sweep.to;
	} else if (match.params.model == DEFORM_SCM) {
		sweep.seconds = any_word() % 2 ? any_between(0.01, 1) : 0;
		sweep.turned = shape->kind == SOIL_WHEEL ? any_between(-1, 3) * spacing / shape->radius : shape->belt ? (k - 0.6) * spacing : 0;
	}
	return sweep;
}

#define DEGREES (M_PI / 180)

/* The soil's own strength; and surfaces that are smooth, sticky, both, and no weaker than any soil. */
static const struct soil_interface interfaces[] = {
	{.has_friction = false},
	{.has_friction = true, .friction_angle = 10 * DEGREES},
	{.has_adhesion = true, .adhesion = 300},
	{true, true, 16 * DEGREES, 100},
	{true, true, 5 * DEGREES, 2000},
	{true, true, 45 * DEGREES, 1e5},
};

static const char *const soils[] = {"dry_sand", "sandy_loam_15", "lete_sand", "clayey_38", "upland_loam_51", "snow_us", "lunar"};

static void rounds(enum deform_model model, int count)
{
	memset(&seen, 0, sizeof seen);
	for (int round = 0; round < count; round++) {
		static const double spacings[] = {0.0625, 0.05, 0.125};
		double spacing = spacings[round % 3];
		struct soil_numbers soil;
		assert_ok(soil_named(model == DEFORM_SUMNER ? "sand" : soils[round % 7], &soil));
		soil.cohesion *= model == DEFORM_SCM || round % 4 == 0;
		rough_seed = any_word();
		rough_height = (round % 4) * 0.1 * spacing;
		slope_east = any_between(-0.3, 0.3) * spacing * (round % 2);
		slope_north = any_between(-0.3, 0.3) * spacing * (round % 2);
		struct ground_params params = {
			.cells = CELLS, .tiles = TILES, .spacing = spacing, .height = any_ground, .model = model, .soils = &soil, .soil_count = 1,
			.iterations = model == DEFORM_SUMNER ? 1 + round % 2 : 1 + round % 8,
			.depth = round % 3 == 1 ? 0.03 : 0, .relief = round % 2 ? 100 : 0,
			.bulldozing = model == DEFORM_SCM ? 0.4 * (round % 3) : 0, .slip_sinkage = model == DEFORM_SCM ? 0.8 * (round % 2) : 0, .dirt = model == DEFORM_NONE, /* for its contacts */
		};
		test_seed = 1000u * (uint32_t)model + (uint32_t)round;
		ground_init(&match.ground, &params);
		match.params = match.ground.deform->params;
		assert_int_equal(reference_ground_init(&match.reference, POSTS, POSTS, spacing), STATUS_OK);
		match.reference.slip_sinkage = params.slip_sinkage;
		for (int i = 0; i < COUNT; i++) {
			match.reference.hole[i] = match.ground.base[i] == BASE_NODATA;
			match.reference.base[i] = match.reference.hole[i] ? 0 : lattice_base_metres(match.ground.base[i]);
		}
		struct soil_shape shape = any_shape(spacing);
		/* Near a corner of four tiles, the hole, or the edge of the world; several sweeps about one place. */
		double x = round % 5 == 4 ? 1 : 32 + 8 * any_share(), y = round % 5 == 3 ? POSTS - 3 : 50 + 16 * any_share();
		for (int k = 0; k < 5; k++) {
			shape.belt = model == DEFORM_SCM && shape.kind == SOIL_BOX && round % 3 == 0;
			struct deform_contact sweep = any_sweep(&shape, k, x + 3 * any_share(), y + 3 * any_share());
			if (model == DEFORM_SCM) {
				sweep.tag = 1;
				sweep.interface = interfaces[(round + k) % 6];
				sweep.load = k % 2 == 1 ? exp2(any_between(2, 12)) : 0;
				if (sweep.load > 0)
					sweep.from.z = sweep.to.z;
			}
			run(&sweep);
			if (k % 2 == 1)
				shape = any_shape(spacing);
		}
		reference_ground_finish(&match.reference);
		ground_finish(&match.ground);
	}
	print_message("%d sweeps, %d loads, %d posts pressed; %d undersides on an edge, %d ties, %d posts loose, %d sweeps undecided, sliding %d times; at "
		      "most %.0f %% of what is allowed (%.1f quanta), of forces %.0f %%\n", seen.sweeps, seen.loads, seen.pressed, seen.edges,
		      seen.ties, seen.loosened, seen.undecided, seen.slid, seen.share * 100, seen.quanta, seen.force * 100);
	assert_true(seen.sweeps > 3 * count && seen.pressed > 100 * count);
	assert_true(seen.undecided * 4 < seen.sweeps);
	assert_true(seen.edges * 50 < seen.pressed && seen.ties * 100 < seen.pressed);
	assert_true(seen.loosened * 10 < seen.pressed || model == DEFORM_SUMNER);
}

static void none_presses_as_the_reference(void **state)
{
	(void)state;
	need_gpu();
	rounds(DEFORM_NONE, 6);
}

static void sumner_is_as_the_reference(void **state)
{
	(void)state;
	need_gpu();
	rounds(DEFORM_SUMNER, 16);
}

static void slippage_is_as_the_reference(void **state)
{
	(void)state;
	need_gpu();
	rounds(DEFORM_SLIPPAGE, 16);
}

static void scm_is_as_the_reference(void **state)
{
	(void)state;
	need_gpu();
	rounds(DEFORM_SCM, 28);
}

TEST_PROGRAM(against_reference)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(none_presses_as_the_reference),
		cmocka_unit_test(slippage_is_as_the_reference),
		cmocka_unit_test(sumner_is_as_the_reference),
		cmocka_unit_test(scm_is_as_the_reference),
	};
	return cmocka_run_group_tests_name("deform/against_reference", tests, open_gpu, close_gpu);
}
