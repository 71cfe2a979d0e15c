/* Thinned meshes stay where they were, within the distance that was asked for. */
#include <math.h>

#include "../support.h"
#include "../support/program.h"

#include "vehicle/thin.h"

/* A lumpy ball with a flat floor: rows of corners from its lower to its upper end. `lumps`: m. */
static struct soil_mesh ball(uint32_t rows, uint32_t around, double lumps)
{
	struct soil_mesh mesh = {calloc((size_t)rows * around, sizeof *mesh.vertices), calloc(2 * (size_t)rows * around, sizeof *mesh.triangles), rows * around, 0,
				 {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	assert_true(mesh.vertices != NULL && mesh.triangles != NULL);
	for (uint32_t r = 0; r < rows; r++)
		for (uint32_t i = 0; i < around; i++) {
			const double up = M_PI * (r + 0.5) / rows - M_PI / 2, turn = 2 * M_PI * i / around;
			const double reach = 1 + lumps * sin(9 * turn) * sin(7 * up);
			const double at[3] = {reach * cos(up) * cos(turn), reach * cos(up) * sin(turn), fmax(reach * sin(up), -0.6)};
			for (int k = 0; k < 3; k++) {
				mesh.vertices[r * around + i][k] = (float)at[k];
				mesh.low[k] = fmin(mesh.low[k], at[k]);
				mesh.high[k] = fmax(mesh.high[k], at[k]);
			}
		}
	for (uint32_t r = 0; r + 1 < rows; r++)
		for (uint32_t i = 0; i < around; i++) {
			const uint32_t a = r * around + i, b = r * around + (i + 1) % around;
			memcpy(mesh.triangles[mesh.triangle_count++], (const uint32_t[]){a, b, b + around}, sizeof *mesh.triangles);
			memcpy(mesh.triangles[mesh.triangle_count++], (const uint32_t[]){a, b + around, a + around}, sizeof *mesh.triangles);
		}
	return mesh;
}

static void release(struct soil_mesh *mesh)
{
	free(mesh->vertices);
	free(mesh->triangles);
}

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The distance of a point from a triangle: least squares for the two shares of its sides, then those of its edges. */
static double distance(const double p[3], const double a[3], const double b[3], const double c[3])
{
	const double *corners[3] = {a, b, c};
	double ab[3], ac[3], ap[3], least = INFINITY;
	for (int k = 0; k < 3; k++) {
		ab[k] = b[k] - a[k];
		ac[k] = c[k] - a[k];
		ap[k] = p[k] - a[k];
	}
	const double bb = dot(ab, ab), cc = dot(ac, ac), bc = dot(ab, ac), pb = dot(ap, ab), pc = dot(ap, ac), all = bb * cc - bc * bc;
	const double v = (cc * pb - bc * pc) / all, w = (bb * pc - bc * pb) / all;
	if (all > 0 && v >= 0 && w >= 0 && v + w <= 1)
		least = sqrt(fmax(dot(ap, ap) - 2 * (v * pb + w * pc) + v * v * bb + 2 * v * w * bc + w * w * cc, 0));
	for (int i = 0; i < 3; i++) {
		const double *from = corners[i], *to = corners[(i + 1) % 3];
		double along = 0, length = 0, apart = 0;
		for (int k = 0; k < 3; k++) {
			along += (p[k] - from[k]) * (to[k] - from[k]);
			length += (to[k] - from[k]) * (to[k] - from[k]);
		}
		const double share = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
		for (int k = 0; k < 3; k++)
			apart += pow(p[k] - from[k] - share * (to[k] - from[k]), 2);
		least = fmin(least, sqrt(apart));
	}
	return least;
}

static double from_mesh(const double p[3], const struct soil_mesh *mesh)
{
	double least = INFINITY;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		least = fmin(least, hypot(hypot(p[0] - (double)mesh->vertices[v][0], p[1] - (double)mesh->vertices[v][1]), p[2] - (double)mesh->vertices[v][2]));
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		double corners[3][3], low = 0;
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				corners[i][k] = (double)mesh->vertices[mesh->triangles[t][i]][k];
		for (int k = 0; k < 3; k++) { /* the box around it */
			const double most = fmax(corners[0][k], fmax(corners[1][k], corners[2][k])), less = fmin(corners[0][k], fmin(corners[1][k], corners[2][k]));
			low = fmax(low, fmax(p[k] - most, less - p[k]));
		}
		if (low < least)
			least = fmin(least, distance(p, corners[0], corners[1], corners[2]));
	}
	return least;
}

/* The farthest of some places of `from`, from the other mesh. */
static double farthest(const struct soil_mesh *from, const struct soil_mesh *to)
{
	double most = 0;
	for (uint32_t t = 0; t < from->triangle_count; t += 1 + from->triangle_count / 200) {
		double place[3] = {0, 0, 0};
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				place[k] += (double)from->vertices[from->triangles[t][i]][k] / 3;
		most = fmax(most, from_mesh(place, to));
	}
	return most;
}

static void a_thinned_mesh_stays_within_the_distance(void **state)
{
	static const double mosts[] = {0.02, 0.005};
	(void)state;
	for (size_t i = 0; i < 2; i++) {
		const struct soil_mesh whole = ball(150, 200, 0.03);
		struct soil_mesh mesh = ball(150, 200, 0.03);
		bool thinned = false;
		assert_int_equal(vehicle_thin(&mesh, mosts[i], &thinned), STATUS_OK);
		assert_true(thinned);
		const double there = farthest(&whole, &mesh), back = farthest(&mesh, &whole);
		print_message("%g m: %u of %u triangles, there and back %.4f, %.4f m\n", mosts[i], mesh.triangle_count, whole.triangle_count, there, back);
		assert_true(mesh.triangle_count < whole.triangle_count / (i == 0 ? 15 : 4) && mesh.triangle_count > 100);
		assert_true(there < mosts[i] + 1e-6);
		assert_true(back < mosts[i] + 1e-6);
		for (int k = 0; k < 3; k++)
			assert_true(mesh.low[k] >= whole.low[k] - 1e-6 && mesh.low[k] < whole.low[k] + mosts[i] && mesh.high[k] <= whole.high[k] + 1e-6 && mesh.high[k] > whole.high[k] - mosts[i]);
		for (uint32_t t = 0; t < mesh.triangle_count; t++)
			for (int k = 0; k < 3; k++)
				assert_true(mesh.triangles[t][k] < mesh.vertex_count);
		struct soil_mesh copy = whole;
		release(&copy);
		release(&mesh);
	}
}

/* Where nothing can go, nothing does. */
static void a_mesh_of_few_triangles_stays(void **state)
{
	float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	uint32_t faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
	struct soil_mesh mesh = {corners, faces, 4, 4, {0, 0, 0}, {1, 1, 1}};
	bool thinned = true;
	(void)state;
	assert_int_equal(vehicle_thin(&mesh, 0.01, &thinned), STATUS_OK);
	assert_false(thinned);
	assert_int_equal(mesh.triangle_count, 4);
}

/* Two plates that are farther apart than the distance stay two, though their corners are the same ones seen from above. */
static void thin_walls_stay_apart(void **state)
{
	const uint32_t side = 40;
	struct soil_mesh mesh = {calloc(2 * side * side, sizeof *mesh.vertices), calloc(4 * side * side, sizeof *mesh.triangles), 2 * side * side, 0, {0, 0, 0}, {1, 1, 0.05}};
	double low = INFINITY, high = -INFINITY;
	bool thinned;
	(void)state;
	for (uint32_t plate = 0; plate < 2; plate++)
		for (uint32_t y = 0; y < side; y++)
			for (uint32_t x = 0; x < side; x++) {
				const uint32_t at = (plate * side + y) * side + x;
				memcpy(mesh.vertices[at], (const float[]){(float)x / (float)(side - 1), (float)y / (float)(side - 1), plate == 0 ? 0 : 0.05f}, sizeof *mesh.vertices);
				if (x + 1 == side || y + 1 == side)
					continue;
				memcpy(mesh.triangles[mesh.triangle_count++], (const uint32_t[]){at, at + 1, at + side}, sizeof *mesh.triangles);
				memcpy(mesh.triangles[mesh.triangle_count++], (const uint32_t[]){at + 1, at + side + 1, at + side}, sizeof *mesh.triangles);
			}
	assert_int_equal(vehicle_thin(&mesh, 0.01, &thinned), STATUS_OK);
	assert_true(thinned && mesh.triangle_count < 200 && mesh.triangle_count >= 4);
	for (uint32_t t = 0; t < mesh.triangle_count; t++) {
		double sum = 0;
		for (int k = 0; k < 3; k++)
			sum += (double)mesh.vertices[mesh.triangles[t][k]][2];
		low = fmin(low, sum);
		high = fmax(high, sum);
		assert_true(sum < 1e-6 || sum > 0.149);
	}
	assert_true(low < 1e-6 && high > 0.149);
	release(&mesh);
}

TEST_PROGRAM(thin)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_thinned_mesh_stays_within_the_distance),
		cmocka_unit_test(a_mesh_of_few_triangles_stays),
		cmocka_unit_test(thin_walls_stay_apart),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
