/* A mesh bears as the shape that it is a mesh of: in soil that bears, motion decides, not the type of the shape. */
#include "soil_test.h"

#include "../support/program.h"
#include "meshes.h"
#include "soil/sink.h"

#define SIDE 512

/* A body that goes straight on over level ground. */
struct trial {
	const char *soil;
	bool any_width; /* the soil is as stiff below a patch of any width */
	const struct soil_shape *shape;
	double spacing, course, yaw, pitch, roll; /* m; rad */
	double load, length;                      /* N; m */
	double turns, reach;                      /* rad for each m; m: its centre above its lowest place */
};

/* Means over the second half of the way: m, N, N m along the course. */
struct told {
	double sinkage, pull, aside, moment;
};

static const char sand[] = "dry_sand";

static void *zeros(size_t size)
{
	void *memory = calloc((size_t)SIDE * SIDE, size);
	assert_non_null(memory);
	return memory;
}

static struct soil_planes planes_of(void)
{
	return (struct soil_planes){.rect = {0, 0, SIDE, SIDE}, .width = SIDE, .base = zeros(4), .offset = zeros(4), .deposited = zeros(4), .sinkage = zeros(4), .shear = zeros(4), .contact = zeros(1)};
}

static void free_planes(struct soil_planes *p)
{
	void *all[] = {p->base, p->offset, p->deposited, p->sinkage, p->shear, p->contact};
	for (size_t i = 0; i < sizeof all / sizeof *all; i++)
		free(all[i]);
}

static struct soil_motion motion_of(const struct trial *t, int sample, const struct soil_pose *last)
{
	const double way = sample * t->spacing, turn = 0.1 + t->turns * way, turned = sample > 0 ? t->turns * t->spacing : 0;
	const enum soil_shape_kind kind = t->shape->kind;
	struct soil_motion m = {.shape = t->shape, .load = t->load, .jumped = sample == 0};
	m.to = (struct soil_pose){lattice_offset(1.3 + 0.37 * t->spacing + way * cos(t->course)), lattice_offset(1.3 + 0.2 * t->spacing + way * sin(t->course)), lattice_offset(t->reach),
				  t->yaw, t->pitch, t->roll, kind == SOIL_WHEEL ? turn : 0};
	if (kind == SOIL_MESH && t->turns > 0)
		m.to.pitch = -remainder(turn, 2 * M_PI);
	m.from = sample > 0 ? *last : m.to;
	if (kind == SOIL_WHEEL) {
		m.turned = turned;
	} else {
		m.hosted = true;
		m.rotated[0] = -sin(t->yaw) * turned;
		m.rotated[1] = cos(t->yaw) * turned;
	}
	return m;
}

static struct told drive(const struct trial *t)
{
	struct soil_law law = {.spacing = t->spacing, .soil_count = 1};
	struct soil_planes planes = planes_of();
	struct soil_laid laid[SOIL_CLASSES];
	struct soil_work *work;
	struct soil_pose last = {0};
	struct told told = {0};
	const int samples = (int)(t->length / t->spacing);
	int32_t start = -(int32_t)lattice_offset(0.02);
	int count = 0;
	assert_ok(soil_named(t->soil, &law.soils[0]));
	if (t->any_width)
		law.soils[0].bekker_kc = 0;
	assert_ok(soil_work_create(&work));
	for (int i = 0; i < SOIL_CLASSES; i++)
		laid[i] = soil_laid_of(0.5, 0, t->spacing);
	for (int i = 0; i <= samples; i++) {
		const struct soil_motion m = motion_of(t, i, &last);
		const struct soil_laying laying = soil_laying_of(t->shape, &m.from, &m.to, m.turned, m.rotated, t->spacing);
		const struct soil_sink sink = {.laying = &laying, .soils = laid, .start = start};
		struct soil_imprint out;
		assert_ok(soil_sink_body(&law, &planes, &m, &sink, work, &out));
		start = out.raised;
		last = m.to;
		if (2 * i < samples)
			continue;
		const double c = cos(t->course), s = sin(t->course), *f = out.forces.force, *moment = out.forces.moment;
		count++;
		told.sinkage -= lattice_offset_metres(out.raised);
		told.pull += c * f[0] + s * f[1];
		told.aside += c * f[1] - s * f[0];
		told.moment += c * moment[1] - s * moment[0];
	}
	soil_work_destroy(work);
	free_planes(&planes);
	return (struct told){told.sinkage / count, told.pull / count, told.aside / count, told.moment / count};
}

/* What differs most: sinkage and forces, as shares of the sinkage and of the load; the moment as a share of load times radius. */
static struct told difference(const struct told *a, const struct told *b, double load, double radius)
{
	return (struct told){fabs(b->sinkage / a->sinkage - 1), fabs(b->pull - a->pull) / load, fabs(b->aside - a->aside) / load, fabs(b->moment - a->moment) / (load * radius)};
}

static void worse(struct told *most, const struct told *d)
{
	most->sinkage = support_most(most->sinkage, d->sinkage);
	most->pull = support_most(most->pull, d->pull);
	most->aside = support_most(most->aside, d->aside);
	most->moment = support_most(most->moment, d->moment);
}

static void say(const char *name, const struct told *d)
{
	print_message("%s: sinkage %.2f %%, pull %.2f %%, aside %.2f %%, moment %.2f %%\n", name, 100 * d->sinkage, 100 * d->pull, 100 * d->aside, 100 * d->moment);
}

static bool within(const struct told *d, double limit)
{
	return d->sinkage < limit && d->pull < limit && d->aside < limit && d->moment < limit;
}

/* Which trials: soils, spacings, slips. */
struct trials {
	const char *const *soils;
	const double *spacings, *slips;
	int soil_count, spacing_count, slip_count;
	bool any_width;
};

/* Drives a wheel and another shape that turns as it does, on three headings. */
static struct told beside_wheel(const struct soil_shape *shape, double roll, const struct trials *trials)
{
	static const double headings[] = {0, 17 * M_PI / 180, M_PI / 4};
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};
	const int sands = 3 * trials->spacing_count, all = sands * trials->slip_count;
	struct told most = {0};
	for (int i = 0; i < all * trials->soil_count; i++) {
		const double heading = headings[i % 3], slip = trials->slips[i % all / sands];
		struct trial t = {.soil = trials->soils[i / all], .any_width = trials->any_width, .shape = &wheel, .spacing = trials->spacings[i % sands / 3], .course = heading, .yaw = heading, .load = 500,
				  .length = 2, .turns = 1 / 0.3 / (1 - slip), .reach = 0.3};
		const struct told told = drive(&t);
		t.shape = shape;
		t.roll = roll;
		const struct told other = drive(&t), d = difference(&told, &other, 500, 0.3);
		worse(&most, &d);
	}
	return most;
}

static const char *const sands[] = {sand}, *const soils[] = {sand, "lunar"}, *const clays[] = {"clayey_38"};
static const double slips[] = {0, 0.2, 0.5, -0.3}, spacings[] = {0.0625, 0.03125, 0.015625}, places[] = {0.05, 0.025};
static const struct trials in_sand = {sands, spacings, slips, 1, 3, 4, false}, in_soils = {soils, places, slips + 1, 2, 2, 1, false};
static const struct trials in_clay = {clays, places, slips + 1, 1, 2, 1, false}, in_even_clay = {clays, places, slips + 1, 1, 2, 1, true};

static void a_cylinder_that_rolls_is_a_wheel(void **state)
{
	const struct soil_shape cylinder = {.kind = SOIL_CYLINDER, .radius = 0.3, .length = 0.2};
	(void)state;
	for (int i = 0; i < 3; i++) {
		const struct told d = beside_wheel(&cylinder, M_PI / 2, i == 0 ? &in_sand : i == 1 ? &in_soils : &in_clay);
		say(i == 0 ? "cylinder, slips" : i == 1 ? "cylinder, soils" : "cylinder, clay", &d);
		assert_true(within(&d, 1e-3));
	}
}

static void a_mesh_that_rolls_is_a_wheel(void **state)
{
	(void)state;
	for (uint32_t facets = 96; facets <= 768; facets *= 8) {
		struct soil_mesh mesh = mesh_drum(facets, 0.3, 0.2);
		const struct soil_shape drum = {.kind = SOIL_MESH, .mesh = &mesh};
		for (int i = 0; i < 2; i++) {
			char name[40];
			const struct told d = beside_wheel(&drum, 0, i ? &in_soils : &in_sand);
			snprintf(name, sizeof name, "%u facets, %s", facets, i ? "soils" : "slips");
			say(name, &d);
			assert_true(within(&d, 0.02));
		}
		mesh_free(&mesh);
	}
}

/* In clay the width of the patch counts. That of a mesh of a wheel is the wheel's. */
static void in_clay_a_mesh_of_a_wheel_is_a_wheel(void **state)
{
	struct soil_mesh mesh = mesh_drum(768, 0.3, 0.2);
	const struct soil_shape drum = {.kind = SOIL_MESH, .mesh = &mesh};
	(void)state;
	const struct told d = beside_wheel(&drum, 0, &in_clay), even = beside_wheel(&drum, 0, &in_even_clay);
	say("768 facets, clay", &d);
	say("768 facets, clay that is as stiff below any width", &even);
	assert_true(within(&even, 0.02) && within(&d, 0.02));
	mesh_free(&mesh);
}

/* The corners of a drum of 24 facets are 2.6 mm farther out than the middles of its facets: a tenth of the sinkage. Where it rolls without slip it
 * prints its facets; where it slips its corners plough. */
static void a_drum_of_24_facets_is_a_wheel_but_for_its_corners(void **state)
{
	struct soil_mesh mesh = mesh_drum(24, 0.3, 0.2);
	const struct soil_shape drum = {.kind = SOIL_MESH, .mesh = &mesh};
	(void)state;
	const struct trials roll = {sands, spacings, slips, 1, 3, 1, false}, slip = {sands, spacings, slips + 1, 1, 3, 3, false};
	struct told d = beside_wheel(&drum, 0, &roll);
	say("24 facets that roll", &d);
	assert_true(within(&d, 0.03));
	d = beside_wheel(&drum, 0, &slip);
	say("24 facets that slip", &d);
	assert_true(d.sinkage < 2.6 / 24 && d.pull < 0.05 && d.moment < 0.02);
	d = beside_wheel(&drum, 0, &in_soils);
	say("24 facets, soils", &d);
	mesh_free(&mesh);
}

/* Drags a shape and its mesh, straight on and aside. */
static struct told beside_mesh(const struct soil_shape *shape, const struct soil_mesh *mesh, double roll, double reach)
{
	static const double headings[] = {0, 17 * M_PI / 180, M_PI / 4}, fine[] = {0.03125, 0.015625};
	const struct soil_shape meshed = {.kind = SOIL_MESH, .mesh = mesh};
	struct told most = {0};
	for (int i = 0; i < 12; i++) {
		const double yaw = headings[i / 2 % 3];
		struct trial t = {.soil = sand, .shape = shape, .spacing = fine[i % 2], .yaw = yaw, .course = yaw + (i < 6 ? 0 : M_PI / 6), .roll = roll, .load = 400, .length = 1, .reach = reach};
		const struct told told = drive(&t);
		t.shape = &meshed;
		const struct told other = drive(&t), d = difference(&told, &other, 400, reach);
		worse(&most, &d);
	}
	return most;
}

static void meshes_that_are_dragged_are_their_shapes(void **state)
{
	struct soil_mesh ball = mesh_pill(96, 24, 0.25, 0), block = mesh_block(0.3, 0.15, 0.1), pill = mesh_pill(96, 24, 0.1, 0.3);
	const struct soil_shape sphere = {.kind = SOIL_SPHERE, .radius = 0.25}, box = {.kind = SOIL_BOX, .size = {0.3, 0.15, 0.1}};
	const struct soil_shape capsule = {.kind = SOIL_CAPSULE, .radius = 0.1, .length = 0.3};
	(void)state;
	const struct told of_ball = beside_mesh(&sphere, &ball, 0, 0.25), of_block = beside_mesh(&box, &block, 0, 0.05), of_pill = beside_mesh(&capsule, &pill, M_PI / 2, 0.1);
	say("sphere", &of_ball);
	say("box", &of_block);
	say("capsule", &of_pill);
	assert_true(within(&of_ball, 0.02) && within(&of_block, 0.02) && within(&of_pill, 0.04));
	mesh_free(&ball);
	mesh_free(&block);
	mesh_free(&pill);
}

/* Triangles may look inwards, and vertices of triangles that touch may be apart. Without its two sides a drum is no closed mesh. */
static void a_mesh_may_be_turned_over_or_open(void **state)
{
	struct soil_mesh drum = mesh_drum(96, 0.3, 0.2), loose = mesh_with(3 * drum.triangle_count, drum.triangle_count), open = mesh_with(drum.vertex_count, 2 * 96);
	(void)state;
	for (uint32_t i = 0; i < drum.triangle_count; i++) {
		const bool over = any_share() < 0;
		for (uint32_t k = 0; k < 3; k++) {
			memcpy(loose.vertices[3 * i + k], drum.vertices[drum.triangles[i][k]], sizeof *loose.vertices);
			loose.triangles[i][k] = 3 * i + (over ? 2 - k : k);
		}
	}
	for (uint32_t i = 0; i < 96; i++)
		memcpy(open.triangles[2 * i], drum.triangles[4 * i], 2 * sizeof *open.triangles);
	memcpy(open.vertices, drum.vertices, drum.vertex_count * sizeof *open.vertices);
	mesh_bounds(&loose);
	mesh_bounds(&open);
	struct soil_shape shape = {.kind = SOIL_MESH, .mesh = &drum};
	struct trial t = {.soil = sand, .shape = &shape, .spacing = 0.03125, .course = 0.3, .yaw = 0.3, .load = 500, .length = 1, .turns = 1 / 0.3 / 0.8, .reach = 0.3};
	const struct told told = drive(&t);
	shape.mesh = &loose;
	const struct told of_loose = drive(&t), loose_differs = difference(&told, &of_loose, 500, 0.3);
	shape.mesh = &open;
	const struct told of_open = drive(&t), open_differs = difference(&told, &of_open, 500, 0.3);
	say("loose", &loose_differs);
	say("open", &open_differs);
	assert_true(within(&loose_differs, 0.002) && within(&open_differs, 0.04));
	mesh_free(&drum);
	mesh_free(&loose);
	mesh_free(&open);
}

TEST_PROGRAM(mesh)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_cylinder_that_rolls_is_a_wheel),
		cmocka_unit_test(a_mesh_that_rolls_is_a_wheel),
		cmocka_unit_test(in_clay_a_mesh_of_a_wheel_is_a_wheel),
		cmocka_unit_test(a_drum_of_24_facets_is_a_wheel_but_for_its_corners),
		cmocka_unit_test(meshes_that_are_dragged_are_their_shapes),
		cmocka_unit_test(a_mesh_may_be_turned_over_or_open),
	};
	return cmocka_run_group_tests_name("soil/mesh", tests, NULL, NULL);
}
