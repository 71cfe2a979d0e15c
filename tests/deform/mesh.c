/* A mesh presses the ground as the reference says, whatever its form and attitude, and the same wherever it is. */
#include "ground.h"
#include "../support/program.h"

#define NEAR 4e-6L    /* metres */
#define SNAPPED 2e-5L /* posts: a vertex and the motion, each snapped to 2^-16 posts */
#define BELOW 250     /* how deep in the ground the objects run */

/* --- meshes --- */

#define VERTICES 4096

struct made {
	struct soil_mesh mesh;
	float vertices[VERTICES][3];
	uint32_t triangles[2 * VERTICES][3];
};

static void start(struct made *made)
{
	made->mesh = (struct soil_mesh){.vertices = made->vertices, .triangles = made->triangles};
}

static uint32_t vertex(struct made *made, double x, double y, double z)
{
	float *v = made->vertices[made->mesh.vertex_count];
	assert_true(made->mesh.vertex_count < VERTICES);
	v[0] = (float)x;
	v[1] = (float)y;
	v[2] = (float)z;
	for (int k = 0; k < 3; k++) {
		made->mesh.low[k] = made->mesh.vertex_count == 0 ? v[k] : fmin(made->mesh.low[k], v[k]);
		made->mesh.high[k] = made->mesh.vertex_count == 0 ? v[k] : fmax(made->mesh.high[k], v[k]);
	}
	return made->mesh.vertex_count++;
}

static void triangle(struct made *made, uint32_t a, uint32_t b, uint32_t c)
{
	uint32_t *t = made->triangles[made->mesh.triangle_count++];
	assert_true(made->mesh.triangle_count <= 2 * VERTICES);
	t[0] = a;
	t[1] = b;
	t[2] = c;
}

static void quad(struct made *made, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
	triangle(made, a, b, c);
	triangle(made, a, c, d);
}

/* An outline of x, z from -0.5 to 0.5, extruded along y; its ends are fans around none: open, since they are upright. */
static void extrude(struct made *made, const double (*outline)[2], int count, double size)
{
	start(made);
	for (int i = 0; i < count; i++)
		for (int side = 0; side < 2; side++)
			vertex(made, outline[i][0] * size, (side - 0.5) * size, outline[i][1] * size);
	for (int i = 0; i < count; i++) {
		uint32_t a = 2 * (uint32_t)i, b = 2 * (uint32_t)((i + 1) % count);
		quad(made, a, b, b + 1, a + 1);
	}
}

static void arch(struct made *made, double size)
{
	static const double outline[][2] = {{-0.5, -0.5}, {-0.3, -0.5}, {-0.2, 0}, {0, 0.2}, {0.2, 0}, {0.3, -0.5},
					    {0.5, -0.5}, {0.45, 0.3}, {0, 0.5}, {-0.45, 0.3}};
	extrude(made, outline, 10, size);
}

static void angle_piece(struct made *made, double size)
{
	static const double outline[][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, -0.2}, {-0.2, -0.2}, {-0.2, 0.5}, {-0.5, 0.5}};
	extrude(made, outline, 6, size);
}

static void brick(struct made *made, double x, double y, double z)
{
	start(made);
	for (int i = 0; i < 8; i++)
		vertex(made, (i & 1 ? x : -x) / 2, (i & 2 ? y : -y) / 2, (i & 4 ? z : -z) / 2);
	quad(made, 0, 1, 3, 2);
	quad(made, 4, 6, 7, 5);
	quad(made, 0, 4, 5, 1);
	quad(made, 2, 3, 7, 6);
	quad(made, 0, 2, 6, 4);
	quad(made, 1, 5, 7, 3);
}

/* `rings` from pole to pole, twice as many around. */
static void ball(struct made *made, double radius, int rings)
{
	start(made);
	for (int i = 0; i <= rings; i++)
		for (int k = 0; k < 2 * rings; k++)
			vertex(made, radius * sin(M_PI * i / rings) * cos(M_PI * k / rings),
			       radius * sin(M_PI * i / rings) * sin(M_PI * k / rings), -radius * cos(M_PI * i / rings));
	for (int i = 0; i < rings; i++)
		for (int k = 0; k < 2 * rings; k++) {
			uint32_t a = (uint32_t)(2 * rings * i + k), b = (uint32_t)(2 * rings * i + (k + 1) % (2 * rings));
			quad(made, a, b, b + 2 * (uint32_t)rings, a + 2 * (uint32_t)rings);
		}
}

/* Loose triangles, through each other, this way and that. */
static void shards(struct made *made, double size, int count)
{
	start(made);
	for (int i = 0; i < count; i++) {
		uint32_t first = made->mesh.vertex_count;
		double x = any_share(), y = any_share(), z = any_share(), s = i % 4 == 0 ? 1 : 0.2;
		for (int k = 0; k < 3; k++)
			vertex(made, size * (x + s * any_share()) / 2, size * (y + s * any_share()) / 2, size * (z + s * any_share()) / 2);
		triangle(made, first, first + 1, first + 2);
	}
}

/* --- against the reference --- */

struct tally {
	int posts, edges;
	long double worst;
};

static void around(const struct deform_contact *sweep, long double x, long double y, long double radius, long double *low,
		   long double *high, int *covered)
{
	*low = 1e30L;
	*high = -1e30L;
	*covered = 0;
	for (int i = 0; i < 8; i++) {
		long double z, angle = (long double)i * 0.78539816L;
		if (!reference_underside(sweep, x + radius * cosl(angle), y + radius * sinl(angle), &z))
			continue;
		*low = fminl(*low, z);
		*high = fmaxl(*high, z);
		(*covered)++;
	}
}

static void compare(struct ground *ground, const struct deform_contact *sweep, int64_t stride, struct tally *tally)
{
	long double radius = SNAPPED * ground->params.spacing;
	ground_reset(ground);
	ground_sweep(ground, sweep);
	ground_read(ground);
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		int64_t px = i % ground->posts, py = i / ground->posts;
		if (!ground_written(ground, i)) {
			assert_int_equal(ground->offset[i], 0);
			continue;
		}
		if ((px + py * 3) % stride != 0)
			continue;
		long double x = ground_from(ground, px, sweep->from.x), y = ground_from(ground, py, sweep->from.y), z = 0, low, high;
		int near;
		bool covered = reference_underside(sweep, x, y, &z);
		long double pressed = ldexpl((int64_t)ground->offset[i] - sweep->from.z, -OFFSET_BITS);
		if (covered && ground->offset[i] != 0 && fabsl(pressed - z) <= NEAR) {
			tally->posts++;
			tally->worst = fmaxl(tally->worst, fabsl(pressed - z));
			continue;
		}
		if (!covered && ground->offset[i] == 0)
			continue;
		around(sweep, x, y, radius, &low, &high, &near);
		if (covered != (ground->offset[i] != 0)) {
			if (near == 0 || near == 8)
				fail_msg("post %lld, %lld is %s the object, by the reference", (long long)px, (long long)py,
					 covered ? "under" : "beside");
		} else if (near == 8 && (pressed < low - NEAR || pressed > high + NEAR)) {
			fail_msg("post %lld, %lld: %.2Lf um from the reference, spacing %g", (long long)px, (long long)py,
				 (pressed - z) * 1e6L, ground->params.spacing);
		} else if (near < 8 && pressed < low - NEAR) {
			fail_msg("post %lld, %lld, on an edge: too low", (long long)px, (long long)py);
		}
		tally->edges++;
	}
}

static const double spacings[] = {1, 0.25, 0.0903, 0.015625};

static struct deform_contact any_sweep(const struct ground *ground, const struct soil_shape *shape, int number)
{
	double middle = (double)ground->posts / 2, far = number % 5 == 0 ? 12 : 1.2, spacing = ground->params.spacing;
	double dx = number % 4 == 1 ? 0 : any_share() * far, dy = number % 4 == 1 ? 0 : any_share() * far;
	double dz = number % 4 == 2 ? 0 : any_share() * far * spacing * (number % 3 == 0 ? 3 : 0.5);
	double x = middle + any_share(), y = middle + any_share();
	struct deform_contact sweep = {.shape = shape, .from = ground_pose(ground, x, y, -BELOW), .to = ground_pose(ground, x + dx, y + dy, dz - BELOW)};
	sweep.to.yaw = number % 7 == 3 ? M_PI / 2 * (number % 4) : any_share() * 4;
	if (number % 7 == 5 && number % 4 != 1)
		sweep.to.yaw = atan2(dy, dx) + (number % 2 ? M_PI / 2 : 0);
	if (number % 3 != 0) {
		sweep.to.pitch = any_share() * 4;
		sweep.to.roll = number % 6 == 2 ? 0 : any_share() * 4;
	}
	if (number % 6 == 4)
		sweep.from = sweep.to;
	return sweep;
}

static void make_any(struct made *made, int kind, double size)
{
	if (kind == 0)
		arch(made, size);
	else if (kind == 1)
		angle_piece(made, size);
	else if (kind == 2)
		brick(made, size, size * 0.6, size * 0.3);
	else if (kind == 3)
		ball(made, size / 2, 5);
	else
		shards(made, size, 40);
}

static void every_mesh_is_that_of_the_reference(void **state)
{
	static struct made made;
	struct tally tally = {0, 0, 0};
	(void)state;
	need_gpu();
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++) {
		struct ground ground;
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 3, .spacing = spacings[s]});
		for (int i = 0; i < 60; i++) {
			make_any(&made, i % 5, spacings[s] * exp2(2.6 + 1.6 * any_share()));
			struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
			assert_ok(soil_shape_check(&shape, spacings[s]));
			struct deform_contact sweep = any_sweep(&ground, &shape, i);
			compare(&ground, &sweep, 1, &tally);
		}
		ground_finish(&ground);
	}
	print_message("%d posts, the worst %.2Lf um off; %d more within what snapping moves\n", tally.posts,
		      tally.worst * 1e6L, tally.edges);
	assert_true(tally.posts > 5000);
	assert_true(tally.edges * 5 < tally.posts);
}

static void a_mesh_larger_than_a_window_is_that_of_the_reference(void **state)
{
	static struct made made;
	struct tally tally = {0, 0, 0};
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 512, .tiles = 1, .spacing = 0.25});
	arch(&made, 80);
	struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
	struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, 255.3, 256.1, -BELOW), .to = ground_pose(&ground, 256.1, 255.9, -BELOW - 0.1)};
	sweep.to.yaw = 0.4;
	sweep.to.pitch = 0.1;
	compare(&ground, &sweep, 13, &tally);
	assert_true(ground.window_count >= 4);
	assert_true(tally.posts > 5000);
	ground_finish(&ground);
}

/* Its edges run along posts: those count, on every side, as of the box itself. */
static void a_brick_is_the_box(void **state)
{
	static struct made made;
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.25});
	brick(&made, 2, 1.5, 1);
	struct soil_shape mesh = {.kind = SOIL_MESH, .mesh = &made.mesh}, box = {.kind = SOIL_BOX, .size = {2, 1.5, 1}};
	static const double ways[][3] = {{0, 0, 0}, {1, 0, 0}, {0, -2, 0}, {2, 1, 0}, {0, 0, -0.5}, {1, 1, 0.25}};
	for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++)
		for (int turned = 0; turned < 2; turned++) {
			struct deform_contact sweep = {.shape = &mesh, .from = ground_pose(&ground, 30, 31, -2),
						     .to = ground_pose(&ground, 30 + ways[i][0], 31 + ways[i][1], -2 + ways[i][2])};
			sweep.to.yaw = turned * M_PI / 2;
			int32_t *a = ground_swept(&ground, &sweep);
			sweep.shape = &box;
			int32_t *b = ground_swept(&ground, &sweep);
			int pressed = 0;
			for (int64_t k = 0; k < ground.posts * ground.posts; k++) {
				if ((a[k] != 0) != (b[k] != 0) || abs(a[k] - b[k]) > 1)
					fail_msg("way %zu, post %lld: %d and %d", i, (long long)k, a[k], b[k]);
				pressed += a[k] != 0;
			}
			assert_true(pressed >= 9 * 7);
			mem_free(a);
			mem_free(b);
		}
	ground_finish(&ground);
}

static void a_fine_ball_is_the_sphere(void **state)
{
	static struct made made;
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.0625});
	ball(&made, 1, 40);
	struct soil_shape mesh = {.kind = SOIL_MESH, .mesh = &made.mesh}, sphere = {.kind = SOIL_SPHERE, .radius = 1};
	struct deform_contact sweep = {.shape = &mesh, .from = ground_pose(&ground, 30.3, 31.8, -2), .to = ground_pose(&ground, 31.1, 32.2, -2.01)};
	sweep.to.pitch = 0.7;
	int32_t *a = ground_swept(&ground, &sweep);
	sweep.shape = &sphere;
	int32_t *b = ground_swept(&ground, &sweep);
	int compared = 0;
	for (int64_t k = 0; k < ground.posts * ground.posts; k++) {
		double x = (double)ground_from(&ground, k % ground.posts, sweep.to.x), y = (double)ground_from(&ground, k / ground.posts, sweep.to.y);
		if (hypot(x, y) > 0.7)
			continue;
		/* A chord of 4.5 degrees lies at most 0.8 mm inside; nothing lies outside. */
		double inside = lattice_offset_metres(a[k] - b[k]);
		if (!(inside > -1e-5 && inside < 3e-3))
			fail_msg("%g mm inside the sphere", inside * 1e3);
		compared++;
	}
	assert_true(compared > 300);
	mem_free(a);
	mem_free(b);
	ground_finish(&ground);
}

/* Under an arch the ground stays as high as the arch is. */
static void what_stands_under_an_arch_is_left_standing(void **state)
{
	static struct made made;
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.125});
	arch(&made, 2);
	struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
	/* Its feet 0.2 deep, its crown 1.2 above the ground. */
	struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, 32, 32, 0.8), .to = ground_pose(&ground, 32, 32, 0.8)};
	int32_t *a = ground_swept(&ground, &sweep);
	for (int x = -9; x <= 9; x++) {
		int32_t at = a[32 * ground.posts + 32 + x];
		if (abs(x) <= 4)
			assert_int_equal(at, 0);
		else if (abs(x) <= 8 && x * 0.125 <= 1 && abs(x) >= 5)
			assert_int_equal(at, lattice_offset(-0.2));
		else
			assert_int_equal(at, 0);
	}
	mem_free(a);
	ground_finish(&ground);
}

static void it_rests_where_it_ends(void **state)
{
	static struct made made;
	struct ground ground;
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.0625, .model = DEFORM_BOX_FILTER, .radius = 1});
	for (int k = 0; k < 20; k++) {
		make_any(&made, k % 5, 1);
		struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
		struct deform_contact sweep = any_sweep(&ground, &shape, k);
		assert_rests_where_it_ends(&ground, &sweep);
	}
	ground_finish(&ground);
}

static void ten_thousand_kilometres_away_are_the_same_bits(void **state)
{
	static const double fine[] = {0.25, 0.140625, 0.0009765625 * 93};
	static struct made made;
	(void)state;
	need_gpu();
	for (size_t i = 0; i < 3; i++) {
		struct ground near, far;
		struct ground_params params = {.cells = 32, .tiles = 2, .spacing = fine[i]};
		ground_init(&near, &params);
		params.first = (int64_t)(1e7 / fine[i] / 32);
		ground_init(&far, &params);
		for (int k = 0; k < 10; k++) {
			make_any(&made, k % 5, fine[i] * 12);
			struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
			uint32_t seed = test_seed;
			struct deform_contact here = any_sweep(&near, &shape, k);
			test_seed = seed;
			struct deform_contact there = any_sweep(&far, &shape, k);
			int32_t *a = ground_swept(&near, &here), *b = ground_swept(&far, &there);
			assert_memory_equal(a, b, (size_t)(near.posts * near.posts) * sizeof *a);
			mem_free(a);
			mem_free(b);
		}
		ground_finish(&near);
		ground_finish(&far);
	}
}

static void shapes_know_their_size(void **state)
{
	static struct made made;
	double extent[2];
	(void)state;
	brick(&made, 2, 1, 0.5);
	struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh}, box = {.kind = SOIL_BOX, .size = {2, 1, 0.5}};
	for (int i = 0; i < 100; i++) {
		double pitch = any_share() * 4, roll = any_share() * 4;
		assert_true(fabs(soil_shape_reach(&shape, pitch, roll) - soil_shape_reach(&box, pitch, roll)) < 1e-6);
	}
	(void)extent;
	assert_true(fabs(soil_shape_bound(&shape) - soil_shape_bound(&box)) < 1e-6);
	brick(&made, 900, 1, 1);
	assert_int_equal(soil_shape_check(&shape, 1), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "too large"));
}

/* More triangles than one draw takes, and none at all over the window. */
static void any_number_of_triangles(void **state)
{
	static struct made made;
	struct ground ground;
	struct tally tally = {0, 0, 0};
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.0625});
	ball(&made, 1.5, 44); /* 7,744 */
	struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &made.mesh};
	struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, 31.4, 31.5, -BELOW), .to = ground_pose(&ground, 32.2, 32.6, -BELOW)};
	sweep.to.roll = 1;
	compare(&ground, &sweep, 17, &tally);
	assert_true(tally.posts > 50);
	brick(&made, 0.01, 0.01, 0.01);
	sweep.from = sweep.to = ground_pose(&ground, 31.5, 31.5, -BELOW);
	int32_t *a = ground_swept(&ground, &sweep);
	for (int64_t k = 0; k < ground.posts * ground.posts; k++)
		assert_int_equal(a[k], 0);
	mem_free(a);
	ground_finish(&ground);
}

TEST_PROGRAM(mesh)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_mesh_is_that_of_the_reference),
		cmocka_unit_test(a_mesh_larger_than_a_window_is_that_of_the_reference),
		cmocka_unit_test(a_brick_is_the_box),
		cmocka_unit_test(a_fine_ball_is_the_sphere),
		cmocka_unit_test(what_stands_under_an_arch_is_left_standing),
		cmocka_unit_test(it_rests_where_it_ends),
		cmocka_unit_test(ten_thousand_kilometres_away_are_the_same_bits),
		cmocka_unit_test(shapes_know_their_size),
		cmocka_unit_test(any_number_of_triangles),
	};
	return cmocka_run_group_tests_name("deform/mesh", tests, open_gpu, close_gpu);
}
