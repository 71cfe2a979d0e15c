/* Thrown soil: how it leaves a rim that slips, how it flies, and that what lands is what was thrown, to the unit. */
#include "ground.h"
#include "../support/program.h"

#define KAPPA 1.1
#define GRAVITY 9.81

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.25, .width = 0.2};

static void init(struct ground *ground, int32_t (*height)(int64_t x, int64_t y), bool thrown)
{
	ground_init(ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 2, .spacing = 0.03125, .height = height, .bulldozing = 0.5, .slip_sinkage = KAPPA, .iterations = 1,
						    .thrown = thrown});
}

/* A wheel whose rim goes at `rim` m/s below, over an axle at 1 m/s heading `yaw`. */
static struct soil_motion motion_of(double rim, double yaw, double seconds)
{
	struct soil_motion motion = {.shape = &wheel, .seconds = seconds, .turned = rim * seconds / wheel.radius};
	motion.from.yaw = motion.to.yaw = yaw;
	motion.to.x = lattice_offset(seconds * cos(yaw));
	motion.to.y = lattice_offset(seconds * sin(yaw));
	return motion;
}

/* Grains over level ground come down at v^2 sin(2a) / g, on the Earth and on the Moon. */
static void a_grain_flies_as_far_as_the_closed_form(void **state)
{
	static const double gravities[] = {9.81, 1.62, 1000};
	for (int k = 0; k < 3; k++)
		for (double speed = 0.5; speed < 20; speed *= 2)
			for (double degrees = 10; degrees <= 80; degrees += 10) {
				const double angle = degrees * M_PI / 180, wanted = speed * speed * sin(2 * angle) / gravities[k];
				const int32_t gravity = (int32_t)lround(gravities[k] * 0x1p20);
				const struct bearing_grain grain = {.from = {5, 7, 11}, .volume = 1, .velocity = {(int32_t)lround(speed * cos(angle) * 0x1p20), 0, (int32_t)lround(speed * sin(angle) * 0x1p20)}};
				int64_t low = 1, high = GRAIN_LONGEST, place[3];
				while (high - low > 1) {
					const int64_t middle = (low + high) / 2;
					bearing_grain_at(&grain, gravity, middle, place);
					*(place[2] > grain.from[2] ? &low : &high) = middle;
				}
				bearing_grain_at(&grain, gravity, low, place);
				const double range = lattice_offset_metres(place[0] - grain.from[0]);
				if (!(fabs(range / wanted - 1) < 0.005))
					fail_msg("%g m/s at %g degrees: %.5g m, not %.5g", speed, degrees, range, wanted);
			}
}

/* At slip s the rim's lowest part goes backwards by s of its speed. It leaves along the tangent where it comes out of the ground, with its velocity over the ground. */
static void grains_leave_along_the_tangent_at_the_rear(void **state)
{
	const double rim = 5, sinkage = 0.05, angle = acos(1 - sinkage / wheel.radius);
	for (double yaw = 0; yaw < 6; yaw += 0.7) {
		const struct soil_motion motion = motion_of(rim, yaw, 0.02);
		struct bearing_grain grains[THROWN_GRAINS];
		struct bearing_throw how;
		bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
		const double froude = 16 / (GRAVITY * wheel.radius);
		assert_true(fabs(how.share - froude / (froude + 1)) < 1e-3);
		const int64_t centre[3] = {motion.to.x, motion.to.y, lattice_offset(wheel.radius - sinkage)};
		const int count = bearing_throw_grains(&how, centre, sinkage, 1 << 21, 1000, grains);
		assert_int_equal(count, THROWN_GRAINS);
		int64_t volume = 0;
		for (int i = 0; i < count; i++) {
			const double forward = (grains[i].velocity[0] * cos(yaw) + grains[i].velocity[1] * sin(yaw)) / 0x1p20, up = grains[i].velocity[2] / 0x1p20;
			const double aside = (grains[i].velocity[1] * cos(yaw) - grains[i].velocity[0] * sin(yaw)) / 0x1p20;
			const double leaves = atan2(up, 1 - forward) * 180 / M_PI, wanted = angle * 180 / M_PI; /* beside the axle */
			assert_true(fabs(leaves - wanted) <= THROWN_SPREAD + 0.3);
			assert_true(fabs(hypot(hypot(1 - forward, up), aside) - rim) < 1e-3 * rim);
			assert_true(fabs(aside) <= rim * sin(THROWN_SPREAD * M_PI / 180));
			assert_true(llabs(grains[i].from[2]) < lattice_offset(0.001)); /* at the height of the ground */
			assert_true(grains[i].since <= 1 << 21 && grains[i].since >= (1 << 21) - (int64_t)(0.02 * 0x1p20) - 1);
			volume += grains[i].volume;
		}
		assert_true(volume == 1000);
	}
}

/* No slip, a braked wheel, a wheel that was set down, one that turns about the vertical, no gravity: nothing. */
static void what_does_not_slip_backwards_throws_nothing(void **state)
{
	struct bearing_throw how;
	struct soil_motion motion = motion_of(1, 0.3, 0.02);
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share == 0);
	motion = motion_of(0.6, 0.3, 0.02);
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share == 0);
	motion = motion_of(5, 0.3, 0.02);
	motion.jumped = true;
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share == 0);
	const struct soil_shape box = {.kind = SOIL_BOX, .size = {1, 0.5, 0.5}};
	motion = (struct soil_motion){.shape = &box, .seconds = 0.02, .rotated = {0, 0, 0.3}};
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share == 0);
	motion.rotated[1] = 0.3;
	motion.rotated[2] = 0;
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share > 0 && how.back[0] < -0.99);
}

/* A belt that slips throws backwards, too. */
static void a_belt_throws(void **state)
{
	const struct soil_shape track = {.kind = SOIL_BOX, .size = {2, 0.4, 0.6}, .belt = true};
	struct soil_motion motion = {.shape = &track, .seconds = 0.02, .turned = 0.1, .to = {.x = lattice_offset(0.02)}};
	struct bearing_throw how;
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share > 0.5 && how.back[0] < -0.999 && fabs(how.run - 5) < 1e-9);
	motion.turned = 0.02;
	bearing_throw_of(&motion, motion.seconds, GRAVITY, &how);
	assert_true(how.share == 0);
}

/* A contact takes what it throws off what it lays. That counts as compacted until it lands. */
static void what_lands_is_what_was_thrown(void **state)
{
	struct ground ground;
	int64_t thrown = 0;
	init(&ground, NULL, true);
	struct deform_contact contact = ground_stand(&ground, &wheel, 40, 64.4, wheel.radius - 0.02);
	for (int i = 0; i < 40; i++) {
		contact.from = contact.to;
		contact.to.x += lattice_offset(0.03125);
		contact.turned = 0.03125 * 5 / wheel.radius;
		contact.seconds = 0.03125;
		ground_forces(&ground, &contact);
		ground_lost_nothing(&ground);
		assert_true(ground.done.thrown >= 0);
		thrown += ground.done.thrown;
	}
	assert_true(thrown > 10000);
	const int64_t laid = ground_sum(&ground, PLANE_OFFSET);
	const struct bearing_landing landings[] = {{lattice_offset(((double)ground.x0 + 20.3) * 0.03125), lattice_offset(((double)ground.x0 + 64) * 0.03125), thrown / 3},
						   {lattice_offset(((double)ground.x0 + 64.0) * 0.03125), lattice_offset(((double)ground.x0 + 63.9) * 0.03125), thrown - thrown / 3}};
	struct post_rect changed;
	int64_t lost;
	assert_ok(bearing_thrown_land(ground.bearing, landings, 2, NULL, 0, ground.tiles, ground.tile_count, &changed, &lost));
	assert_true(lost == 0 && !post_rect_empty(changed));
	assert_true(ground_sum(&ground, PLANE_OFFSET) - laid == thrown);
	ground_lost_nothing(&ground);
	/* By its shares of the cell: 0.7 and 0.3 of the first. */
	const double west = ground_post(&ground, PLANE_OFFSET, 20, 64), east = ground_post(&ground, PLANE_OFFSET, 21, 64);
	assert_true(fabs(west / (west + east) - 0.7) < 0.01);
	ground_finish(&ground);
}

static int32_t holed(int64_t x, int64_t y)
{
	return x >= 30 && x < 60 && y >= 30 && y < 60 ? BASE_NODATA : 0;
}

/* Beside a body and a hole soil goes to the nearest free post; where there is none it is lost, and told. */
static void what_finds_no_post_is_told(void **state)
{
	struct ground ground;
	struct post_rect changed;
	int64_t lost;
	init(&ground, holed, true);
	struct bearing_landing landing = {lattice_offset(((double)ground.x0 + 31) * 0.03125), lattice_offset(((double)ground.x0 + 45.5) * 0.03125), 1001};
	assert_ok(bearing_thrown_land(ground.bearing, &landing, 1, NULL, 0, ground.tiles, ground.tile_count, &changed, &lost));
	assert_true(lost == 0);
	assert_int_equal(ground_post(&ground, PLANE_OFFSET, 29, 45) + ground_post(&ground, PLANE_OFFSET, 29, 46) + ground_post(&ground, PLANE_OFFSET, 29, 44), 1001);
	landing.x = lattice_offset(((double)ground.x0 + 45) * 0.03125);
	assert_ok(bearing_thrown_land(ground.bearing, &landing, 1, NULL, 0, ground.tiles, ground.tile_count, &changed, &lost));
	assert_true(lost == 1001 && post_rect_empty(changed));
	/* Below a plate nothing lands. */
	const struct soil_shape plate = {.kind = SOIL_BOX, .size = {0.2, 0.2, 0.1}};
	const struct deform_rest rest = {&plate, ground_pose(&ground, 100, 100, 0.05), 0, false};
	landing.x = lattice_offset(((double)ground.x0 + 100) * 0.03125);
	landing.y = lattice_offset(((double)ground.x0 + 100) * 0.03125);
	assert_ok(bearing_thrown_land(ground.bearing, &landing, 1, &rest, 1, ground.tiles, ground.tile_count, &changed, &lost));
	assert_true(lost == 0);
	for (int64_t y = 98; y <= 102; y++)
		for (int64_t x = 98; x <= 102; x++)
			assert_int_equal(ground_post(&ground, PLANE_OFFSET, x, y), 0);
	assert_int_equal(ground_sum(&ground, PLANE_OFFSET), 2002);
	ground_finish(&ground);
}

/* A record keeps every number of a grain, and takes no nonsense. */
/* What falls off a body is divided to the unit, leaves near its place with the body's velocity, and none in a time before the start. */
static void a_fall_is_divided_into_grains(void **state)
{
	static const int64_t volumes[] = {0, 1, 999, 1000, 1001, 123457, 1000000007};
	const int64_t second = 1 << THROWN_BITS;
	for (size_t v = 0; v < sizeof volumes / sizeof *volumes; v++) {
		struct bearing_fall fall = {.from = {5 * second, 7 * second, 3 * second}, .speed = {1.5, -2, 0.25}, .spread = 0.05, .seconds = 0.1, .volume = volumes[v], .most = 1000};
		struct bearing_grain grains[FALL_GRAINS];
		const int64_t since = v % 2 == 0 ? 40 * second : second / 64;
		const int count = bearing_fall_grains(&fall, since, grains);
		int64_t sum = 0;
		assert_true(count <= FALL_GRAINS && count == (volumes[v] + 999) / 1000 + (volumes[v] > 1000 * FALL_GRAINS ? FALL_GRAINS - (volumes[v] + 999) / 1000 : 0));
		for (int i = 0; i < count; i++) {
			const double before = (double)(since - grains[i].since) / (double)second;
			sum += grains[i].volume;
			assert_true(grains[i].volume > 0 && grains[i].since >= 0 && before >= 0 && before <= 0.1);
			for (int k = 0; k < 3; k++) {
				assert_true(grains[i].velocity[k] == (int32_t)(fall.speed[k] * (double)second));
				const double beside = lattice_offset_metres(grains[i].from[k] - fall.from[k]) + before * fall.speed[k];
				assert_true(fabs(beside) <= (k < 2 ? 0.05 : 0) + 1e-5);
			}
		}
		assert_int_equal(sum, volumes[v]);
	}
}

static void a_grain_survives_the_record(void **state)
{
	const struct bearing_grain grain = {{-5, INT64_C(1) << 50, 77}, 1 << 22, 12345, {-(1 << 24), 1 << 20, 3}, 999};
	struct bearing_grain back;
	int64_t numbers[GRAIN_NUMBERS];
	bearing_grain_save(&grain, numbers);
	assert_true(bearing_grain_load(numbers, &back));
	assert_memory_equal(back.from, grain.from, sizeof grain.from);
	assert_memory_equal(back.velocity, grain.velocity, sizeof grain.velocity);
	assert_true(back.since == grain.since && back.volume == grain.volume && back.flown == grain.flown);
	static const struct {
		int at;
		int64_t value;
	} wrong[] = {{0, INT64_MAX}, {3, INT64_C(1) << 40}, {6, -1}, {7, -1}, {7, GRAIN_LONGEST + 1}, {8, 0}};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		bearing_grain_save(&grain, numbers);
		numbers[wrong[i].at] = wrong[i].value;
		assert_false(bearing_grain_load(numbers, &back));
	}
}

TEST_PROGRAM(throws)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_grain_flies_as_far_as_the_closed_form),
		cmocka_unit_test(grains_leave_along_the_tangent_at_the_rear),
		cmocka_unit_test(what_does_not_slip_backwards_throws_nothing),
		cmocka_unit_test(a_belt_throws),
		cmocka_unit_test(what_lands_is_what_was_thrown),
		cmocka_unit_test(what_finds_no_post_is_told),
		cmocka_unit_test(a_fall_is_divided_into_grains),
		cmocka_unit_test(a_grain_survives_the_record),
	};
	return cmocka_run_group_tests_name("bearing/throws", tests, NULL, NULL);
}
