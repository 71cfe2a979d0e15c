/* Measures. */
#include <stdio.h>
#include <stdlib.h>
#include "bed.h"
#include "meshes.h"
#include "../support/program.h"

#define SIDE 64

struct foot { struct soil_shape shape; double pitch, roll, yaw, depth; };

static struct soil_mesh box_mesh(double a, double b, double c)
{
	struct soil_mesh mesh = mesh_with(8, 12);
	for (int i = 0; i < 8; i++) {
		mesh.vertices[i][0] = (float)((i & 1 ? 1 : -1) * a / 2);
		mesh.vertices[i][1] = (float)((i & 2 ? 1 : -1) * b / 2);
		mesh.vertices[i][2] = (float)((i & 4 ? 1 : -1) * c / 2);
	}
	static const int t[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
	for (int i = 0; i < 12; i++)
		mesh_put(&mesh, (uint32_t)i, (uint32_t)t[i][0], (uint32_t)t[i][1], (uint32_t)t[i][2]);
	mesh_bounds(&mesh);
	return mesh;
}

/* force in own heading frame, moment about the centre */
static void measure(const struct foot *f, const double size[3], const char *name, double spacing, bool friction, int steps)
{
	struct bed bed;
	struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, spacing, SIDE, 0, 0);
	bed.law.bulldozing = 0;
	double axes[3][3], low = 0;
	soil_axes(f->yaw, f->pitch, f->roll, 0, axes);
	for (int k = 0; k < 3; k++)
		low -= fabs(axes[k][2]) * size[k] / 2;
	double worst = 0, mean[6] = {0}, sq[6] = {0}, lo[6], hi[6];
	for (int i = 0; i < 64; i++) {
		const double x = SIDE / 2 * spacing + spacing * ((i % 8) / 8.0 + 0.013), y = SIDE / 2 * spacing + spacing * ((i / 8) / 8.0 + 0.017);
		bed_reset(&bed);
		struct soil_motion motion;
		double last = -0.001;
		for (int s = 1; s <= steps; s++) {
			const double now = f->depth * s / steps;
			const struct bed_state a = bed_state(x, y, bed.height - low - last, f->yaw, f->pitch, f->roll), b = bed_state(x, y, bed.height - low - now, f->yaw, f->pitch, f->roll);
			motion = bed_motion(&f->shape, &a, &b, NULL);
			motion.interface.has_friction = !friction;
			motion.interface.has_adhesion = !friction;
			if (s < steps)
				bed_press(&bed, &motion, 0);
			last = now;
		}
		const struct soil_forces t = bed_feel(&bed, &motion, 0);
		const double c = cos(f->yaw), q = sin(f->yaw), v[6] = {c * t.force[0] + q * t.force[1], c * t.force[1] - q * t.force[0], t.force[2], c * t.moment[0] + q * t.moment[1], c * t.moment[1] - q * t.moment[0], t.moment[2]};
		for (int k = 0; k < 6; k++) {
			mean[k] += v[k] / 64;
			sq[k] += v[k] * v[k] / 64;
			lo[k] = i == 0 ? v[k] : fmin(lo[k], v[k]);
			hi[k] = i == 0 ? v[k] : fmax(hi[k], v[k]);
		}
		if (getenv("FOOT_EACH")) printf("%d area %.6f fz %.2f\n", i, t.area, t.force[2]);
		worst = fmax(worst, fabs(v[0]) / v[2]);
	}
	/* exact: without friction */
	double e[6] = {0};
	const double k = soil.bekker_kc / fmin(size[0], size[1]) + soil.bekker_kphi, h = 0.00025, reach = 0.5 * sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]);
	double sides[3][3];
	soil_axes(0, f->pitch, f->roll, 0, sides);
	for (double x = -reach + h / 2; x < reach; x += h)
		for (double y = -reach + h / 2; y < reach; y += h) {
			/* lowest z on the line: intersect slab */
			double z0 = -1e9, z1 = 1e9;
			int face = -1;
			for (int a = 0; a < 3; a++) {
				const double d = sides[a][0] * x + sides[a][1] * y, n = sides[a][2], r = size[a] / 2;
				if (fabs(n) < 1e-12) {
					if (fabs(d) > r) z0 = 1e9;
					continue;
				}
				const double p = (-r - d) / n, q = (r - d) / n;
				if (fmin(p, q) > z0) { z0 = fmin(p, q); face = a; }
				z1 = fmin(z1, fmax(p, q));
			}
			if (z0 > z1 || face < 0) continue;
			const double ground = low + f->depth, deep = ground - z0;
			if (deep <= 0) continue;
			const double sg = sides[face][2] > 0 ? -1 : 1, n[3] = {sg * sides[face][0], sg * sides[face][1], sg * sides[face][2]}; /* outward, down */
			const double p = k * pow(deep, soil.bekker_n) * h * h, fx[3] = {p * n[0] / n[2], p * n[1] / n[2], p};
			for (int a = 0; a < 3; a++) e[a] += fx[a];
			e[3] += y * fx[2] - z0 * fx[1];
			e[4] += z0 * fx[0] - x * fx[2];
			e[5] += x * fx[1] - y * fx[0];
		}
	printf("%-6s p %4.0f r %3.0f yaw %3.0f %4.1f cm %s%d: fz %7.1f (exact %7.1f) [%6.2f %6.2f]%% fx %6.2f [%6.2f %6.2f]%% (%6.2f) fy [%6.2f %6.2f]%% (%6.2f) my %6.2f [%6.2f %6.2f] (%6.2f) mx [%6.2f %6.2f] (%6.2f)\n", name, f->pitch / DEGREES, f->roll / DEGREES, f->yaw / DEGREES,
	       spacing * 100, friction ? "fr" : "  ", steps, mean[2], e[2], 100 * (lo[2] / mean[2] - 1), 100 * (hi[2] / mean[2] - 1), 100 * mean[0] / mean[2], 100 * lo[0] / mean[2], 100 * hi[0] / mean[2], 100 * e[0] / e[2],
	       100 * lo[1] / mean[2], 100 * hi[1] / mean[2], 100 * e[1] / e[2], mean[4], lo[4], hi[4], e[4], lo[3], hi[3], e[3]);
	bed_finish(&bed);
}

static void feet(void **state)
{
	static const double pitches[] = {2, 5, 10, 20, 30}, spacings[] = {0.031, 0.016, 0.008};
	const char *what = getenv("FOOT_WHAT") ? getenv("FOOT_WHAT") : "box";
	const double size0 = getenv("FOOT_SIZE") ? atof(getenv("FOOT_SIZE")) : 0.2, roll = getenv("FOOT_ROLL") ? atof(getenv("FOOT_ROLL")) : 0, yaw = getenv("FOOT_YAW") ? atof(getenv("FOOT_YAW")) : 0;
	const int steps = getenv("FOOT_STEPS") ? atoi(getenv("FOOT_STEPS")) : 1;
	const double size[3] = {size0, 0.1, 0.1};
	struct soil_mesh mesh = box_mesh(size[0], size[1], size[2]);
	for (int p = 0; p < 5; p++)
		for (int s = 0; s < 3; s++)
			for (int fr = 0; fr < 2; fr++) {
				struct foot f = {.pitch = -pitches[p] * DEGREES, .roll = roll * DEGREES, .yaw = yaw * DEGREES, .depth = 0.03};
				f.shape = strcmp(what, "mesh") == 0 ? (struct soil_shape){.kind = SOIL_MESH, .mesh = &mesh} : (struct soil_shape){.kind = SOIL_BOX, .size = {size[0], size[1], size[2]}};
				measure(&f, size, what, spacings[s], fr == 1, steps);
			}
	mesh_free(&mesh);
}

TEST_PROGRAM(foot)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(feet)};
	return cmocka_run_group_tests_name("soil/foot", tests, NULL, NULL);
}
