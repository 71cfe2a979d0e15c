/*
 * Measures a contact of a kinematic model on the CPU, one thread: microseconds for a path sample, over the window that a contact of one post
 * needs. The ground is rough and in memory, and nothing is copied. Prints a JSON line for each model, shape and spacing. The shape `shed` is an
 * iteration of Sumner's rule over 128 x 128 posts: nanoseconds for a post.
 *
 *     bench_kinematic [SAMPLES [SHAPE]] [--figures FILE]      default 20000 path samples, all shapes
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "record.h"
#include "soil/kinematic/kinematic.h"
#include "soil/kinematic/shed.h"

enum { SIDE = 1024, GROUPS = 200 };

static int32_t base[SIDE * SIDE], offset[SIDE * SIDE], carried[SIDE * SIDE];
static uint8_t contact[SIDE * SIDE];
static double scratch[1 << 18];

#define AROUND 24
#define RINGS 12
static float vertices[AROUND * RINGS][3];
static uint32_t triangles[2 * AROUND * (RINGS - 1)][3];
static const struct soil_mesh ball = {.vertices = vertices, .triangles = triangles, .vertex_count = AROUND * RINGS,
				      .triangle_count = 2 * AROUND * (RINGS - 1), .low = {-0.4, -0.4, -0.4}, .high = {0.4, 0.4, 0.4}};

static void make_ball(void)
{
	for (uint32_t i = 0; i < AROUND * RINGS; i++) {
		const double angle = 2 * M_PI * (i % AROUND) / AROUND, tilt = M_PI * (i / AROUND) / (RINGS - 1);
		vertices[i][0] = (float)(0.4 * sin(tilt) * cos(angle));
		vertices[i][1] = (float)(0.4 * sin(tilt) * sin(angle));
		vertices[i][2] = (float)(0.4 * cos(tilt));
	}
	for (uint32_t i = 0; i < AROUND * (RINGS - 1); i++) {
		const uint32_t next = i / AROUND * AROUND + (i + 1) % AROUND;
		const uint32_t both[2][3] = {{i, next, i + AROUND}, {next, next + AROUND, i + AROUND}};
		memcpy(triangles[2 * i], both, sizeof both);
	}
}

static void level(void)
{
	for (int i = 0; i < SIDE * SIDE; i++) {
		base[i] = (int32_t)((uint32_t)i * 2654435761u >> 20) - 2048; /* 2 cm */
		offset[i] = 0;
	}
}

static struct post_rect grown(struct post_rect rect, int64_t by)
{
	return (struct post_rect){rect.x0 - by, rect.y0 - by, rect.x1 + by, rect.y1 + by};
}

/* Runs a path along a heading. Returns the posts of the windows. */
static double run(const struct soil_kinematic *kinematic, const struct soil_shape *shape, double heading, int samples, struct soil_kinematic_tally *tally)
{
	const double spacing = kinematic->spacing, reach = soil_shape_reach(shape, 0, 0), way = SIDE * 0.6;
	const int64_t around = kinematic->radius * (1 + kinematic->repetitions);
	struct soil_kinematic_contact at = {.shape = shape};
	double posts = 0;
	for (int i = 0; i < samples; i++) {
		const double along = fmod(i, way), x = SIDE * 0.2 + along * cos(heading), y = SIDE * 0.2 + along * sin(heading);
		at.from = at.to;
		at.to = (struct soil_pose){.x = lattice_offset(x * spacing), .y = lattice_offset(y * spacing), .z = lattice_offset(reach - 0.03), .yaw = heading,
					   .turn = along * spacing / reach};
		at.turned = spacing / reach;
		if (along < 1)
			at.from = at.to;
		const struct post_rect shadow = soil_shadow(shape, &at.from, &at.to, spacing);
		const struct post_rect written = grown(shadow, kinematic->radius), read = grown(shadow, around);
		const size_t first = (size_t)read.y0 * SIDE + (size_t)read.x0;
		struct soil_planes planes = {.rect = read, .width = SIDE, .base = base + first, .offset = offset + first, .contact = contact + first};
		soil_kinematic_run(kinematic, &at, &planes, written, kinematic->carries ? carried + first : NULL, scratch, tally);
		posts += (double)((read.x1 - read.x0) * (read.y1 - read.y0));
	}
	return posts / samples;
}

static const char *only; /* the one shape that is measured; NULL: all */

static void measure(const char *model, const struct soil_kinematic *kinematic, const char *name, const struct soil_shape *shape, double heading,
		    int samples)
{
	double us[GROUPS], posts = 0;
	if (only != NULL && strcmp(only, name) != 0)
		return;
	struct soil_kinematic_tally tally = {0, 0};
	char key[64];
	level();
	run(kinematic, shape, heading, samples / GROUPS, &tally);
	for (int i = 0; i < GROUPS; i++) {
		const double began = clock_seconds();
		posts = run(kinematic, shape, heading, samples / GROUPS, &tally);
		us[i] = (clock_seconds() - began) * 1e6 / (samples / GROUPS);
	}
	snprintf(key, sizeof key, "%s.%s.%g.%g", model, name, kinematic->spacing, heading);
	bench_record_add(key, "us", us, GROUPS);
	const double median = bench_median(us, GROUPS);
	printf("{\"bench\": \"kinematic\", \"model\": \"%s\", \"shape\": \"%s\", \"spacing\": %g, \"heading\": %g, \"us\": %.2f, "
	       "\"best_us\": %.2f, \"posts\": %.0f}\n", model, name, kinematic->spacing, heading, median, us[0], posts);
	fflush(stdout);
}

/* Steep ground, of which each post sheds soil. */
static void measure_shed(int samples)
{
	enum { WIDE = 128, POSTS = WIDE * WIDE, STRIDE = WIDE + 2 };
	double ns[GROUPS];
	struct soil_shed rule = {.tolerance = 0};
	struct soil_numbers sand;
	int32_t *heights = offset, *sheds = carried, change[WIDE];
	if (only != NULL && strcmp(only, "shed") != 0)
		return;
	bench_must(soil_named("sand", &sand));
	soil_shed_prepare(&sand, 0.125, 0, &rule.classes[0]);
	memset(contact, 0, sizeof contact);
	memset(carried, 0, sizeof carried);
	for (int i = 0; i < STRIDE * STRIDE; i++)
		heights[i] = (int32_t)((uint32_t)i * 2654435761u >> 12);
	const int rounds = samples / GROUPS / 100 + 1;
	for (int i = 0; i < GROUPS; i++) {
		const double began = clock_seconds();
		for (int n = 0; n < rounds; n++) {
			for (int y = 1; y <= WIDE; y++) {
				struct soil_shed_rows rows = {.count = WIDE};
				for (int k = 0; k < 3; k++) {
					rows.heights[k] = heights + (y + k - 1) * STRIDE + 1;
					rows.contacts[k] = contact + (y + k - 1) * STRIDE + 1;
				}
				soil_shed_row(&rule, &rows, sheds + y * STRIDE + 1);
			}
			for (int y = 1; y <= WIDE; y++) {
				const int32_t *own = sheds + y * STRIDE + 1, *const rows[3] = {own - STRIDE, own, own + STRIDE};
				soil_shed_take_row(WIDE, rows, NULL, false, change, NULL);
			}
		}
		ns[i] = (clock_seconds() - began) * 1e9 / rounds / POSTS;
	}
	bench_record_add("shed", "ns", ns, GROUPS);
	const double median = bench_median(ns, GROUPS);
	printf("{\"bench\": \"kinematic\", \"shape\": \"shed\", \"ns_a_post\": %.2f, \"best_ns\": %.2f}\n", median, ns[0]);
}

int main(int argc, char **argv)
{
	bench_record_begin("kinematic", &argc, argv);
	const int samples = argc > 1 ? atoi(argv[1]) : 20000;
	static const double spacings[] = {0.125, 0.04, 0.02};
	const struct {
		const char *name;
		struct soil_shape shape;
	} shapes[] = {
		{"wheel", {.kind = SOIL_WHEEL, .radius = 0.4, .width = 0.3}},
		{"grousers", {.kind = SOIL_WHEEL, .radius = 0.4, .width = 0.3, .grousers = 18, .grouser_height = 0.02, .grouser_thickness = 0.01}},
		{"sphere", {.kind = SOIL_SPHERE, .radius = 0.4}},
		{"box", {.kind = SOIL_BOX, .size = {0.8, 0.3, 0.3}}},
		{"cylinder", {.kind = SOIL_CYLINDER, .radius = 0.4, .length = 0.3}},
		{"capsule", {.kind = SOIL_CAPSULE, .radius = 0.2, .length = 0.4}},
		{"ellipsoid", {.kind = SOIL_ELLIPSOID, .size = {0.4, 0.3, 0.2}}},
		{"mesh", {.kind = SOIL_MESH, .mesh = &ball}},
	};
	only = argc > 2 ? argv[2] : NULL;
	if (samples < GROUPS)
		return 2;
	make_ball();
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++) {
		const struct soil_kinematic none = {.spacing = spacings[s]};
		struct soil_kinematic box = none, slippage = none;
		box.radius = box.repetitions = 1;
		soil_kinematic_slippage(&slippage);
		for (int heading = 0; heading < 2; heading++) {
			measure("none", &none, "wheel", &shapes[0].shape, 0.5 * heading, samples);
			measure("box", &box, "wheel", &shapes[0].shape, 0.5 * heading, samples);
			measure("slippage", &slippage, "wheel", &shapes[0].shape, 0.5 * heading, samples);
		}
		for (size_t i = 1; i < sizeof shapes / sizeof *shapes; i++)
			measure("none", &none, shapes[i].name, &shapes[i].shape, 0.5, shapes[i].shape.kind == SOIL_MESH ? samples / 10 : samples);
	}
	measure_shed(samples);
	bench_record_end("none");
	return 0;
}
