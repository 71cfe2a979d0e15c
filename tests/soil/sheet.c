/*
 * The elastic sheet: a point load against Bessel's closed form, the equation and the obstacle post by post, whole rebound, ruts by the yield, bodies
 * beside each other, and that posts farther away change no bit.
 */
#include "../../src/soil/kinematic/sheet.h"
#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"

/* Ground of width x width posts. Its first post is at (first, first) of the world. */
struct bed {
	int64_t first, width;
	struct soil_planes planes;
	int32_t *base, *offset, *floor;
	uint8_t *contact;
	struct soil_kinematic kinematic;
	struct soil_sheet sheet;
	double length; /* m */
	struct soil_kinematic_tally tally;
	struct post_rect changed;
};

static int32_t level(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 0;
}

static int32_t holed(int64_t x, int64_t y)
{
	const uint32_t noise = (uint32_t)(x * 7919 + y * 104729) * 2654435761u;
	return x % 7 == 0 && y % 5 == 0 ? BASE_NODATA : (int32_t)(noise >> 20);
}

static void make(struct bed *bed, int64_t first, int64_t width, int32_t (*height)(int64_t x, int64_t y), double spacing, double length, double yield, double share)
{
	const size_t posts = (size_t)(width * width);
	*bed = (struct bed){.first = first, .width = width, .length = length, .kinematic = {.spacing = spacing}};
	bed->base = mem_alloc(posts, sizeof *bed->base);
	bed->offset = mem_calloc(posts, sizeof *bed->offset);
	bed->floor = mem_calloc(posts, sizeof *bed->floor);
	bed->contact = mem_calloc(posts, 1);
	assert_true(bed->base != NULL && bed->offset != NULL && bed->floor != NULL && bed->contact != NULL);
	for (int64_t y = 0; y < width; y++)
		for (int64_t x = 0; x < width; x++)
			bed->base[y * width + x] = height(first + x, first + y);
	bed->planes = (struct soil_planes){.rect = {first, first, first + width, first + width}, .width = (size_t)width, .base = bed->base, .offset = bed->offset,
					   .floor = bed->floor, .contact = bed->contact};
	soil_sheet_prepare(&bed->sheet, length, yield, share, spacing);
}

static void drop(struct bed *bed)
{
	mem_free_all(bed->base, bed->offset, bed->floor, bed->contact);
}

/* The contact of a body that goes from one pose to another; leaves: it is taken away from the first one. */
static void meet(struct bed *bed, const struct soil_shape *shape, struct soil_pose from, struct soil_pose to, bool leaves)
{
	const struct soil_sheet_contact contact = {.body = {.shape = shape, .from = from, .to = to}, .leaves = leaves};
	void *scratch = mem_alloc(1, soil_sheet_room(shape, (size_t)bed->width, (size_t)bed->width, false));
	assert_non_null(scratch);
	soil_sheet_run(&bed->sheet, &bed->kinematic, &contact, &bed->planes, scratch, &bed->tally, &bed->changed);
	mem_free(scratch);
}

static size_t at(const struct bed *bed, int64_t x, int64_t y)
{
	return (size_t)((y - bed->first) * bed->width + x - bed->first);
}

static double deflection(const struct bed *bed, int64_t x, int64_t y)
{
	return ldexp(soil_sheet_deflection(bed->floor[at(bed, x, y)]), -OFFSET_BITS);
}

/* Pa: what presses on a post, by the equation of the sheet with k = 1 Pa/m and T = l^2. */
static double pressure(const struct bed *bed, int64_t x, int64_t y)
{
	const double d = bed->kinematic.spacing, own = deflection(bed, x, y);
	const double bend = deflection(bed, x - 1, y) + deflection(bed, x + 1, y) + deflection(bed, x, y - 1) + deflection(bed, x, y + 1) - 4 * own;
	return own - bed->length * bed->length * bend / (d * d);
}

/* A pose over post (x, y), so that a ball's lowest point is `depth` metres below 0. */
static struct soil_pose over(const struct bed *bed, double x, double y, double radius, double depth)
{
	const double d = bed->kinematic.spacing;
	return (struct soil_pose){.x = lattice_offset(x * d), .y = lattice_offset(y * d), .z = lattice_offset(radius - depth)};
}

/* The modified Bessel function K0, by its integral over cosh. */
static double k0(double x)
{
	const double step = 1e-3;
	double sum = 0;
	for (double t = step / 2; x * cosh(t) < 700; t += step)
		sum += exp(-x * cosh(t)) * step;
	return sum;
}

static void a_point_load_bends_the_sheet_as_bessels_function(void **state)
{
	(void)state;
	assert_near(k0(1), 0.42102443824, 1e-6); /* Abramowitz and Stegun, table 9.8 */
	assert_near(k0(0.1), 2.4270690247, 1e-5);
	for (int posts = 4; posts <= 16; posts *= 2) {
		struct bed bed;
		const double length = 0.5, d = length / posts;
		const int64_t middle = 1000, reach = soil_sheet_reach(length, d), around = 2 * reach + 4;
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.4 * d};
		make(&bed, middle - around, 2 * around + 1, level, d, length, INFINITY, 1);
		const struct soil_pose pose = over(&bed, (double)middle, (double)middle, ball.radius, 0.05);
		meet(&bed, &ball, pose, pose, false);
		assert_near(deflection(&bed, middle, middle), 0.05, 4 * 0x1p-20);
		/* Of k = 1 Pa/m: the force is the post's pressure on its cell. */
		const double force = pressure(&bed, middle, middle) * d * d, tension = length * length;
		double worst = 0;
		for (int64_t y = -3 * posts; y <= 3 * posts; y++)
			for (int64_t x = -3 * posts; x <= 3 * posts; x++) {
				const double r = hypot((double)x, (double)y) * d;
				if (r < fmax(length / 2, 3 * d) || r > 3 * length)
					continue;
				const double closed = force * k0(r / length) / (2 * M_PI * tension);
				const double error = fabs(deflection(&bed, middle + x, middle + y) / closed - 1);
				worst = error > worst || isnan(error) ? error : worst;
			}
		print_message("l = %d posts: K0 is off by %.2f %% at most, from l / 2 and three posts to 3 l; %d rounds\n", posts, 100 * worst, bed.sheet.rounds);
		assert_near(worst, 0, 0.02);
		drop(&bed);
	}
}

/* Finds where a body with a load stands, and presses it there. tension: N/m. */
static struct soil_sheet_rest stand(struct bed *bed, const struct soil_shape *shape, struct soil_pose pose, double load, double tension)
{
	const struct soil_sheet_contact contact = {.body = {.shape = shape, .from = pose, .to = pose}};
	void *scratch = mem_alloc(1, soil_sheet_room(shape, (size_t)bed->width, (size_t)bed->width, true));
	assert_non_null(scratch);
	const struct soil_sheet_rest standing = soil_sheet_rest(&bed->sheet, &bed->kinematic, &contact, load, tension, &bed->planes, scratch);
	mem_free(scratch);
	const struct soil_pose from = pose;
	pose.z = standing.z;
	meet(bed, shape, from, pose, false);
	return standing;
}

static void a_load_on_a_post_bends_the_sheet_as_bessels_function(void **state)
{
	(void)state;
	for (int posts = 4; posts <= 16; posts *= 2) {
		struct bed bed;
		const double length = 0.5, d = length / posts, tension = 3000, load = 250;
		const int64_t middle = 1000, around = 2 * soil_sheet_reach(length, d) + 4;
		const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.4 * d};
		make(&bed, middle - around, 2 * around + 1, level, d, length, INFINITY, 1);
		const struct soil_sheet_rest standing = stand(&bed, &ball, over(&bed, (double)middle, (double)middle, ball.radius, 0), load, tension);
		assert_true(standing.posts == 1 && !standing.sunk);
		assert_near(ldexp((double)standing.sinkage, -OFFSET_BITS), deflection(&bed, middle, middle), 4 * 0x1p-20);
		assert_near(lattice_offset_metres(standing.z), ball.radius - deflection(&bed, middle, middle), 4 * 0x1p-20);
		double worst = 0;
		for (int64_t y = -3 * posts; y <= 3 * posts; y++)
			for (int64_t x = -3 * posts; x <= 3 * posts; x++) {
				const double r = hypot((double)x, (double)y) * d;
				if (r < fmax(length / 2, 3 * d) || r > 3 * length)
					continue;
				const double error = fabs(deflection(&bed, middle + x, middle + y) / (load * k0(r / length) / (2 * M_PI * tension)) - 1);
				worst = error > worst || isnan(error) ? error : worst;
			}
		print_message("l = %d posts: %g N on %g N/m: P K0(r / l) / (2 pi T) is off by %.2f %% at most\n", posts, load, tension, 100 * worst);
		assert_near(worst, 0, 0.02);
		drop(&bed);
	}
}

/* What presses on all posts below a body is its load, also where the sheet yields, and where another body stands beside it. */
static void a_body_stands_where_the_sheet_bears_its_load(void **state)
{
	(void)state;
	static const struct {
		double load, yield;
		bool beside;
	} cases[] = {{300, INFINITY, false}, {3000, INFINITY, false}, {30, INFINITY, true}, {3000, 0.01, false}};
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.8}, other = {.kind = SOIL_BOX, .size = {0.5, 0.5, 0.5}};
	double last = 0;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct bed bed;
		const double d = 0.1, length = 0.3, stiffness = 20000;
		make(&bed, 0, 120, level, d, length, cases[i].yield, 0.5);
		const struct soil_pose aside = over(&bed, 70, 60, 0.25, 0.02);
		if (cases[i].beside)
			meet(&bed, &other, aside, aside, false);
		const struct soil_sheet_rest standing = stand(&bed, &ball, over(&bed, 60.3, 60.2, 0.8, 0), cases[i].load, stiffness * length * length);
		double push = 0;
		for (int64_t y = 50; y < 70; y++)
			for (int64_t x = 50; x < (cases[i].beside ? 65 : 70); x++)
				push += pressure(&bed, x, y) * stiffness * d * d;
		/* A deflection is known to a micrometre. */
		assert_near(push / cases[i].load, 1, 0.002 + (cases[i].beside ? 0.05 : 0));
		assert_true(standing.posts > 0 && !standing.sunk);
		const double sinks = ldexp((double)standing.sinkage, -OFFSET_BITS);
		if (i == 1)
			assert_true(sinks > 2 * last);
		if (i == 3)
			assert_true(sinks > last); /* a rut is deeper */
		last = sinks;
		drop(&bed);
	}
}

static void no_sheet_bears_what_is_too_heavy(void **state)
{
	(void)state;
	struct bed bed;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.3}, grain = {.kind = SOIL_SPHERE, .radius = 0.02};
	make(&bed, 0, 60, level, 0.1, 0.1, INFINITY, 1);
	assert_true(stand(&bed, &ball, over(&bed, 30, 30, 0.3, 0), 1e9, 500).sunk);
	/* No post is below it. */
	const struct soil_pose beside = over(&bed, 10.5, 10.5, 0.02, 0);
	const struct soil_sheet_rest standing = stand(&bed, &grain, beside, 10, 500);
	assert_true(standing.posts == 0 && standing.z == beside.z && !standing.sunk);
	drop(&bed);
}

static void the_sheet_lies_on_the_body_or_hangs_free(void **state)
{
	(void)state;
	struct bed bed;
	const double d = 0.1;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1.5};
	int pressed = 0, free = 0;
	make(&bed, 0, 140, level, d, 0.4, INFINITY, 1);
	const struct soil_pose pose = over(&bed, 70.3, 69.6, ball.radius, 0.2);
	meet(&bed, &ball, pose, pose, false);
	for (int64_t y = 50; y < 90; y++) /* less far than the sheet is cut off */
		for (int64_t x = 50; x < 90; x++) {
			const double beside = hypot((double)x - 70.3, (double)y - 69.6) * d, down = deflection(&bed, x, y), push = pressure(&bed, x, y);
			const double envelope = beside < 1.5 ? 0.2 - 1.5 + sqrt(1.5 * 1.5 - beside * beside) : -1;
			/* Nowhere above the body. It never pulls, and where it does not touch it does not press. */
			assert_true(down >= envelope - 8 * 0x1p-20);
			assert_true(push > -1e-4);
			if (down > envelope + 8 * 0x1p-20)
				assert_near(push, 0, 1e-4);
			pressed += push > 0.01;
			free += down > envelope + 8 * 0x1p-20 && down > 0.01;
		}
	assert_true(pressed > 20 && free > 100);
	drop(&bed);
}

/* The body goes over holes and rough ground, then it is gone. */
static void below_the_yield_the_rebound_is_whole(void **state)
{
	(void)state;
	const struct soil_shape shapes[] = {{.kind = SOIL_SPHERE, .radius = 0.6}, {.kind = SOIL_BOX, .size = {0.9, 0.5, 0.4}}, {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.3}};
	static const double below[] = {0.6, 0.2, 0.5}; /* m: from the centre to the lowest point */
	for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
		struct bed bed;
		const size_t posts = (size_t)(130 * 130);
		int64_t lowered = 0;
		make(&bed, -20, 130, holed, 0.1, 0.23, 1, 1);
		for (size_t i = 0; i < posts; i++)
			bed.offset[i] = bed.base[i] != BASE_NODATA ? (int32_t)(i * 7919 % 3000) - 1500 : 0;
		int32_t *before = mem_alloc(posts, sizeof *before);
		assert_non_null(before);
		memcpy(before, bed.offset, posts * sizeof *before);
		struct soil_pose last = over(&bed, 30, 40, below[s], 0.1);
		for (int i = 0; i < 25; i++) {
			struct soil_pose next = over(&bed, 30 + i, 40 + 0.3 * i, below[s], 0.1 + 0.002 * i);
			next.yaw = 0.03 * i;
			meet(&bed, &shapes[s], last, next, false);
			last = next;
			int64_t sum = 0;
			for (size_t k = 0; k < posts; k++)
				sum += bed.offset[k] - before[k];
			assert_true(sum + bed.tally.compacted == 0);
			lowered += sum < 0;
		}
		assert_true(lowered == 25 && bed.tally.refused == 0);
		meet(&bed, &shapes[s], last, last, true);
		assert_memory_equal(bed.offset, before, posts * sizeof *before);
		for (size_t i = 0; i < posts; i++)
			assert_int_equal(bed.floor[i], 0);
		assert_true(bed.tally.compacted == 0);
		mem_free(before);
		drop(&bed);
	}
}

/* Returns the deepest rut, m. */
static double deepest(const struct bed *bed)
{
	int32_t least = 0;
	for (int64_t i = 0; i < bed->width * bed->width; i++)
		least = bed->offset[i] < least ? bed->offset[i] : least;
	return -ldexp(least, -OFFSET_BITS);
}

static void beyond_the_yield_a_share_stays_however_often_it_is_pressed(void **state)
{
	(void)state;
	for (int share = 1; share <= 2; share++) {
		double ruts[2];
		for (int often = 0; often < 2; often++) {
			struct bed bed;
			const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.6};
			make(&bed, 0, 120, level, 0.1, 0.2, 0.05, share / 2.0);
			const struct soil_pose pose = over(&bed, 60, 60, 0.6, 0.15);
			for (int i = 0; i < 1 + 5 * often; i++)
				meet(&bed, &ball, pose, pose, false);
			assert_near(deepest(&bed), 0.15, 4 * 0x1p-20);
			meet(&bed, &ball, pose, pose, true);
			ruts[often] = deepest(&bed);
			int64_t sum = 0;
			for (int64_t i = 0; i < bed.width * bed.width; i++) {
				sum += bed.offset[i];
				assert_int_equal(bed.floor[i], 0);
			}
			assert_true(sum < 0 && sum + bed.tally.compacted == 0);
			drop(&bed);
		}
		assert_near(ruts[0], share / 2.0 * (0.15 - 0.05), 4 * 0x1p-20);
		assert_true(ruts[1] == ruts[0]);
	}
}

/* A rut deeper than a deflection can be: what is left beyond it is no deflection. */
static void a_body_far_below_leaves_a_rut_and_no_more(void **state)
{
	(void)state;
	struct bed bed;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.5};
	make(&bed, 0, 60, level, 0.1, 0.05, 0.05, 1);
	const struct soil_pose pose = over(&bed, 30, 30, 0.5, 40);
	meet(&bed, &ball, pose, pose, false);
	assert_near(deflection(&bed, 30, 30), 0.05, 4 * 0x1p-20);
	assert_near(deepest(&bed), 40, 4 * 0x1p-20);
	meet(&bed, &ball, pose, pose, true);
	assert_near(deepest(&bed), 40 - 0.05, 4 * 0x1p-20);
	for (int64_t i = 0; i < bed.width * bed.width; i++)
		assert_int_equal(bed.floor[i], 0);
	assert_true(bed.tally.refused == 0);
	drop(&bed);
}

/* One stands, the other passes close by and goes. What stands is never below the sheet, and all comes back. */
static void bodies_beside_each_other_keep_what_they_press(void **state)
{
	(void)state;
	struct bed bed;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.5};
	make(&bed, 0, 160, level, 0.1, 0.5, INFINITY, 1);
	const struct soil_pose stands = over(&bed, 80, 80, 0.5, 0.1);
	meet(&bed, &ball, stands, stands, false);
	const double alone = deflection(&bed, 80, 87);
	struct soil_pose last = over(&bed, 70, 88, 0.5, 0.08);
	meet(&bed, &ball, last, last, false);
	for (int i = 1; i <= 20; i++) {
		const struct soil_pose next = over(&bed, 70 + i, 88, 0.5, 0.08);
		meet(&bed, &ball, last, next, false);
		last = next;
		assert_true(deflection(&bed, 80, 80) >= 0.1 - 4 * 0x1p-20);
		assert_true(deflection(&bed, 70 + i, 88) >= 0.08 - 4 * 0x1p-20);
	}
	assert_true(deflection(&bed, 80, 87) > alone);
	meet(&bed, &ball, last, last, true);
	assert_near(deflection(&bed, 80, 87), alone, 0.002);
	assert_near(deflection(&bed, 80, 80), 0.1, 4 * 0x1p-20);
	meet(&bed, &ball, stands, stands, true);
	assert_true(deepest(&bed) == 0 && bed.tally.compacted == 0);
	drop(&bed);
}

/* The same way over a window that has just what is read, and over one that has far more. */
static void posts_farther_away_change_nothing(void **state)
{
	(void)state;
	struct bed wide, tight;
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.4};
	make(&wide, -10, 170, holed, 0.1, 0.25, 0.03, 0.7);
	const struct soil_pose a = over(&wide, 70, 70, 0.4, 0.1), b = over(&wide, 71, 70, 0.4, 0.12);
	const struct soil_sheet_contact contact = {.body = {.shape = &ball, .from = a, .to = b}};
	const struct post_rect read = soil_sheet_posts(&contact, wide.sheet.reach, 0.1);
	make(&tight, read.x0, read.x1 - read.x0 > read.y1 - read.y0 ? read.x1 - read.x0 : read.y1 - read.y0, holed, 0.1, 0.25, 0.03, 0.7);
	assert_true(read.x0 == read.y0); /* make() places a square */
	meet(&wide, &ball, a, a, false);
	for (int64_t y = 0; y < tight.width; y++)
		for (int64_t x = 0; x < tight.width; x++) {
			tight.offset[y * tight.width + x] = wide.offset[at(&wide, tight.first + x, tight.first + y)];
			tight.floor[y * tight.width + x] = wide.floor[at(&wide, tight.first + x, tight.first + y)];
		}
	meet(&wide, &ball, a, b, false);
	meet(&tight, &ball, a, b, false);
	for (int64_t y = 0; y < tight.width; y++)
		for (int64_t x = 0; x < tight.width; x++) {
			const size_t in = at(&wide, tight.first + x, tight.first + y);
			assert_int_equal(tight.offset[y * tight.width + x], wide.offset[in]);
			assert_int_equal(tight.floor[y * tight.width + x], wide.floor[in]);
		}
	assert_true(!post_rect_empty(wide.changed) && memcmp(&wide.changed, &tight.changed, sizeof wide.changed) == 0);
	drop(&wide);
	drop(&tight);
}

TEST_PROGRAM(sheet)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_point_load_bends_the_sheet_as_bessels_function),
		cmocka_unit_test(a_load_on_a_post_bends_the_sheet_as_bessels_function),
		cmocka_unit_test(a_body_stands_where_the_sheet_bears_its_load),
		cmocka_unit_test(no_sheet_bears_what_is_too_heavy),
		cmocka_unit_test(the_sheet_lies_on_the_body_or_hangs_free),
		cmocka_unit_test(below_the_yield_the_rebound_is_whole),
		cmocka_unit_test(beyond_the_yield_a_share_stays_however_often_it_is_pressed),
		cmocka_unit_test(a_body_far_below_leaves_a_rut_and_no_more),
		cmocka_unit_test(bodies_beside_each_other_keep_what_they_press),
		cmocka_unit_test(posts_farther_away_change_nothing),
	};
	return cmocka_run_group_tests_name("soil/sheet", tests, NULL, NULL);
}
