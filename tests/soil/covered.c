/* What the law of bearing soil sees of bodies at posts, beside the lower envelopes in whole numbers of the kinematic models. */
#include "soil_test.h"

#include "../support/program.h"
#include "meshes.h"
#include "soil/contact.h"
#include "soil/kinematic/rows.h"
#include "soil/kinematic/under.h"

#define SIDE 256
#define SPACING 0.03125

struct ground {
	struct soil_planes planes;
	struct soil_law law;
	struct soil_work *work;
	int32_t *under, *rest;
};

static void begin(struct ground *g)
{
	*g = (struct ground){.planes = {.rect = {0, 0, SIDE, SIDE}, .width = SIDE}, .law = {.spacing = SPACING, .soil_count = 1}};
	assert_ok(soil_named("dry_sand", &g->law.soils[0]));
	assert_ok(soil_work_create(&g->work));
	g->planes.base = calloc((size_t)SIDE * SIDE, sizeof *g->planes.base);
	g->under = calloc((size_t)SIDE * SIDE, sizeof *g->under);
	g->rest = calloc((size_t)SIDE * SIDE, sizeof *g->rest);
	assert_true(g->planes.base != NULL && g->under != NULL && g->rest != NULL);
}

static void end(struct ground *g)
{
	soil_work_destroy(g->work);
	free(g->planes.base);
	free(g->under);
	free(g->rest);
}

/* How posts of a body differ from whole numbers. */
struct differences {
	int posts;         /* in the lower half of the body, where both see it */
	int rest, lowest;  /* of these: that differ by more than the tolerance, at rest and in motion */
	int over, passed;  /* posts that only one of them has below the lower half, at rest and in motion */
};

static void compare(struct ground *g, const struct soil_motion *motion, double tolerance, struct differences *d)
{
	static struct facet_corner corners[4096];
	struct soil_contact b;
	assert_ok(soil_contact_begin(&g->law, &g->planes, motion, g->work, 10, &b));
	soil_contact_gather(&b, -(1 << 30));
	const struct under_motion under = {.shape = motion->shape, .from = &motion->from, .to = &motion->to, .turned = motion->turned, .spacing = SPACING, .posts = g->planes.rect};
	assert_true(motion->shape->kind != SOIL_MESH || motion->shape->mesh->vertex_count <= 4096);
	soil_under(&under, corners, g->under, g->rest);
	for (size_t i = 0; i < b.posts->count; i++) {
		const size_t at = (size_t)b.posts->index[i];
		const int32_t half = -(int32_t)ldexp(0.5 * soil_shape_reach(motion->shape, motion->to.pitch, motion->to.roll), 20);
		const bool over = g->rest[at] < half, passed = g->under[at] < half;
		const double height = (double)(b.posts->height[i] + b.posts->above[i]), lowest = height - (double)b.posts->lowered[i];
		d->over += (over && !(b.posts->over[i] > 0)) || (g->rest[at] == UNDER_NONE && b.posts->over[i] > 0);
		d->passed += (passed && !(b.posts->swept[i] > 0)) || (g->under[at] == UNDER_NONE && b.posts->swept[i] > 0);
		if (over && b.posts->over[i] > 0) {
			d->rest += fabs(height - ldexp(g->rest[at], -20)) > 2e-5;
			d->posts++;
		}
		if (passed && b.posts->swept[i] > 0)
			d->lowest += fabs(lowest - ldexp(g->under[at], -20)) > tolerance;
	}
}

/* Compares a shape in many poses and motions. */
static struct differences of_shape(const struct soil_shape *shape, double leans, double tolerance)
{
	struct ground g;
	struct differences d = {.posts = 0};
	begin(&g);
	for (int i = 0; i < 40; i++) {
		const bool wheel = shape->kind == SOIL_WHEEL;
		const double course = M_PI * any_share(), way = SPACING * (0.5 + 0.5 * any_share());
		struct soil_motion m = {.shape = shape, .turned = wheel ? 0.1 * any_share() : 0};
		m.to = (struct soil_pose){lattice_offset(4 + 0.1 * any_share()), lattice_offset(4 + 0.1 * any_share()), lattice_offset(1), M_PI * any_share(),
					  wheel ? 0 : leans * any_share(), leans * any_share(), wheel ? any_share() : 0};
		m.from = m.to;
		if (i % 4 != 0) {
			m.from.x -= lattice_offset(way * cos(course));
			m.from.y -= lattice_offset(way * sin(course));
			m.from.z += lattice_offset(0.2 * way * any_share());
		}
		compare(&g, &m, tolerance, &d);
	}
	end(&g);
	assert_true(d.posts > 1000);
	return d;
}

static void forms_have_the_heights_of_whole_numbers(void **state)
{
	static const struct {
		struct soil_shape shape;
		double leans;
		double edges; /* the share of posts near edges that may differ: a rim's end is left out, and a motion aside is near */
	} all[] = {
		{{.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, 0, 0.001}, {{.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2}, 0.3, 0.1},
		{{.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2, .grousers = 18, .grouser_height = 0.02, .grouser_thickness = 0.012}, 0, 0.001},
		{{.kind = SOIL_SPHERE, .radius = 0.25}, 1, 0.001}, {{.kind = SOIL_ELLIPSOID, .size = {0.3, 0.2, 0.15}}, 1, 0.001},
		{{.kind = SOIL_CAPSULE, .radius = 0.12, .length = 0.4}, 1.5, 0.001}, {{.kind = SOIL_BOX, .size = {0.5, 0.3, 0.2}}, 0.4, 0.001},
		{{.kind = SOIL_CYLINDER, .radius = 0.15, .length = 0.4}, 0.3, 0.001},
	};
	(void)state;
	for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
		const struct differences d = of_shape(&all[i].shape, all[i].leans, 2e-5);
		assert_int_equal(d.rest, 0);
		assert_true(d.lowest <= 0.05 * d.posts);
		assert_true(d.over <= all[i].edges * d.posts && d.passed <= all[i].edges * d.posts);
	}
}

static void a_mesh_has_the_heights_of_whole_numbers(void **state)
{
	/* A drum of 96 facets counts as round. One of 60 has facets. */
	struct soil_mesh all[] = {mesh_drum(60, 0.3, 0.2), mesh_block(0.5, 0.3, 0.2), mesh_pill(48, 12, 0.2, 0.2)};
	(void)state;
	for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
		const struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &all[i]};
		const struct differences d = of_shape(&shape, 0.4, 2e-3);
		assert_int_equal(d.rest, 0);
		assert_int_equal(d.over, 0);
		assert_true(d.lowest <= 0.05 * d.posts && d.passed <= 0.05 * d.posts);
		mesh_free(&all[i]);
	}
}

TEST_PROGRAM(covered)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(forms_have_the_heights_of_whole_numbers),
		cmocka_unit_test(a_mesh_has_the_heights_of_whole_numbers),
	};
	return cmocka_run_group_tests_name("soil/covered", tests, NULL, NULL);
}
