/* At every post under an object, the ground is lowered to within 4 micrometres of the reference. */
#include "../long.h"
#include "../support/program.h"
#include "ground.h"

#define NEAR 4e-6L /* metres */
#define BELOW 250    /* how deep in the ground the objects run */

static const double spacings[] = {1, 0.5, 0.25, 0.0903, 0.0625, 0.1 / 3, 0.015625};

struct tally {
	int posts, edges;
	long double worst;
};

/* Where the underside is all but upright, what lies within a tenth of a micrometre beside the post. */
static bool on_flank(const struct deform_contact *sweep, long double x, long double y, long double z)
{
	long double low = 1e30L, high = -1e30L;
	for (int i = 0; i < 8; i++) {
		long double beside, angle = (long double)i * 0.78539816L;
		if (!reference_underside(sweep, x + 1e-7L * cosl(angle), y + 1e-7L * sinl(angle), &beside))
			return true;
		low = fminl(low, beside);
		high = fmaxl(high, beside);
	}
	return z > low - NEAR && z < high + NEAR;
}

/* The reference says otherwise within a hair's breadth: the post lies on the silhouette. */
static bool on_silhouette(const struct deform_contact *sweep, long double x, long double y)
{
	int covered = 0;
	for (int i = 0; i < 8; i++) {
		long double z, angle = (long double)i * 0.78539816L;
		covered += reference_underside(sweep, x + NEAR * cosl(angle), y + NEAR * sinl(angle), &z);
	}
	return covered > 0 && covered < 8;
}

static void compare(struct ground *ground, const struct deform_contact *sweep, struct tally *tally)
{
	ground_reset(ground);
	ground_sweep(ground, sweep);
	ground_read(ground);
	struct post_rect write = ground->windows[0].write;
	for (size_t i = 1; i < ground->window_count; i++) {
		write.x1 = ground->windows[i].write.x1;
		write.y1 = ground->windows[i].write.y1;
	}
	int64_t stride = ground->window_count > 1 ? 7 : 1;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		int64_t px = i % ground->posts, py = i / ground->posts;
		bool in = px + ground->x0 >= write.x0 && px + ground->x0 < write.x1 && py + ground->x0 >= write.y0 &&
			  py + ground->x0 < write.y1;
		if (!in) {
			if (ground->offset[i] != 0)
				fail_msg("a post beyond the window was pressed");
			continue;
		}
		if ((px + py * 3) % stride != 0)
			continue;
		long double x = ground_from(ground, px, sweep->from.x), y = ground_from(ground, py, sweep->from.y), z;
		bool covered = reference_underside(sweep, x, y, &z);
		if (covered != (ground->offset[i] != 0)) {
			if (!on_silhouette(sweep, x, y))
				fail_msg("post %lld, %lld is %s the object, by the reference", (long long)px, (long long)py,
					 covered ? "under" : "beside");
			tally->edges++;
			continue;
		}
		if (!covered)
			continue;
		int64_t start = sweep->from.z - ((int64_t)ground->params.reference << OFFSET_BITS);
		long double pressed = ldexpl((int64_t)ground->offset[i] + 4 * (int64_t)ground->base[i] - start, -OFFSET_BITS);
		long double error = fabsl(pressed - z);
		tally->posts++;
		if (!(error <= NEAR) && !on_flank(sweep, x, y, pressed))
			fail_msg("post %lld, %lld: %.2Lf um from the reference; spacing %g, size %g %g, yaw %.17g, motion %lld %lld %lld",
				 (long long)px, (long long)py, (pressed - z) * 1e6L, ground->params.spacing,
				 sweep->shape->radius, sweep->shape->width, sweep->to.yaw,
				 (long long)(sweep->to.x - sweep->from.x), (long long)(sweep->to.y - sweep->from.y),
				 (long long)(sweep->to.z - sweep->from.z));
		if (error > NEAR)
			tally->edges++;
		else
			tally->worst = fmaxl(tally->worst, error);
	}
}

/* Every fourth motion goes straight up or down, every fourth is level. */
static struct deform_contact any_sweep(const struct ground *ground, const struct soil_shape *shape, int number)
{
	double middle = (double)ground->posts / 2, far = number % 5 == 0 ? 20 : 1.5, spacing = ground->params.spacing;
	double dx = number % 4 == 1 ? 0 : any_share() * far, dy = number % 4 == 1 ? 0 : any_share() * far;
	double dz = number % 4 == 2 ? 0 : any_share() * far * spacing * (number % 3 == 0 ? 3 : 0.5);
	double x = middle + any_share(), y = middle + any_share();
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(ground, x, y, -BELOW), .to = ground_pose(ground, x + dx, y + dy, dz - BELOW)};
	static const double straight[] = {0, 1.5707963267948966, 3.141592653589793, 0.7853981633974483};
	sweep.to.yaw = number % 7 == 3 ? straight[number % 4] : any_share() * 4;
	if (number % 7 == 5 && number % 4 != 1) /* along its heading, or exactly across it */
		sweep.to.yaw = atan2(dy, dx) + (number % 2 ? 1.5707963267948966 : 0);
	return sweep;
}

/* `leans`: wheels have camber. */
static void many(enum soil_shape_kind kind, bool leans, int count)
{
	struct tally tally = {0};
	count /= long_run() ? 1 : 3;
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 64, .tiles = 2, .first = 3, .spacing = spacings[s]});
		for (int i = 0; i < count; i++) {
			/* From smaller than a cell to some thirty posts. */
			double size = spacings[s] * exp2(3 + 2 * any_share());
			struct soil_shape shape = {.kind = kind};
			if (kind == SOIL_BOX || kind == SOIL_ELLIPSOID) {
				for (int k = 0; k < 3; k++)
					shape.size[k] = size * exp2(any_share()) / (kind == SOIL_BOX ? 1 : 2);
			} else {
				shape.radius = size / 2;
				shape.width = kind == SOIL_WHEEL ? size * exp2(any_share() - 1) : 0;
				shape.length = kind == SOIL_CYLINDER || kind == SOIL_CAPSULE ? size * exp2(2 * any_share() - 1) : 0;
			}
			struct deform_contact sweep = any_sweep(&ground, &shape, i);
			if (kind != SOIL_SPHERE && (kind != SOIL_WHEEL || leans) && i % 3 != 0) {
				sweep.to.pitch = i % 6 == 1 ? 1.5707963267948966 : any_share() * 4;
				sweep.to.roll = i % 6 == 2 ? 0 : any_share() * 4;
			}
			if (leans) /* as little as it may be, as of wheels, and any */
				sweep.to.roll = (i % 2 ? -1 : 1) * (i % 4 == 0 ? exp2(-30 + 28 * fabs(any_share())) : i % 4 == 1 ? any_share() * 4 : any_share() * 0.4);
			compare(&ground, &sweep, &tally);
		}
		ground_finish(&ground);
	}
	print_message("%d posts, %d on an edge; the worst of the others %.2Lf um off\n", tally.posts, tally.edges,
		      tally.worst * 1e6L);
	assert_true(tally.posts > 5000);
	assert_true(tally.edges * 2000 < tally.posts);
}

static void a_wheel_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_WHEEL, false, 40);
}

static void a_sphere_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_SPHERE, false, 40);
}

static void a_box_of_any_attitude_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_BOX, false, 60);
}

static void a_wheel_with_camber_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_WHEEL, true, 60);
}

static void a_cylinder_of_any_attitude_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_CYLINDER, false, 60);
}

static void a_capsule_of_any_attitude_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_CAPSULE, false, 60);
}

static void an_ellipsoid_of_any_attitude_is_that_of_the_reference(void **state)
{
	(void)state;
	need_gpu();
	many(SOIL_ELLIPSOID, false, 60);
}

TEST_PROGRAM(envelope)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_is_that_of_the_reference),
		cmocka_unit_test(a_sphere_is_that_of_the_reference),
		cmocka_unit_test(a_box_of_any_attitude_is_that_of_the_reference),
		cmocka_unit_test(a_wheel_with_camber_is_that_of_the_reference),
		cmocka_unit_test(a_cylinder_of_any_attitude_is_that_of_the_reference),
		cmocka_unit_test(a_capsule_of_any_attitude_is_that_of_the_reference),
		cmocka_unit_test(an_ellipsoid_of_any_attitude_is_that_of_the_reference),
	};
	return cmocka_run_group_tests_name("deform/envelope", tests, open_gpu, close_gpu);
}
