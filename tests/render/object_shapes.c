/* The meshes that are drawn for shapes: closed, and as deform presses them; a wheel is seen to turn. Skipped without GL. */
#include "../support/near.h"
#include "deform/reference/reference.h"
#include "objects_rig.h"
#include "../support/program.h"

/* --- silhouettes, by rays on the CPU --- */

/* A wheel of five spokes looks the same after a fifth of a turn, and not before; one with bars only by those too. */
static void a_wheel_is_seen_to_turn(void **state)
{
	need_gpu();
	const struct soil_shape shapes[2] = {wheel, lugged};
	begin(OBJECTS, NULL, shapes, 2);
	struct render_camera camera = camera_at((double[3]){8, 6.6, 1}, (double[3]){8, 8, 1});
	for (size_t i = 0; i < 2; i++) {
		uint8_t *pixels[3];
		const double turns[3] = {0, 2 * M_PI / 10, 2 * M_PI / 5};
		for (int k = 0; k < 3; k++) {
			struct render_object object = posed(i, 8, 8, 1);
			object.turned = turns[k];
			pixels[k] = draw(&camera, &object, 1);
		}
		double half = difference(pixels[0], pixels[1]), fifth = difference(pixels[0], pixels[2]);
		assert_true(half > 2);
		assert_true(i == 0 ? fifth < 0.15 * half : fifth > 0.2 * half);
		for (int k = 0; k < 3; k++)
			test_free(pixels[k]);
	}
	end();
}

/* --- what is drawn is what presses --- */

/* The lowest of the mesh's first detail above a place, by its triangles; INFINITY: it is not above it. */
static double lowest(const struct object_mesh *mesh, double axes[3][3], double x, double y)
{
	double low = INFINITY;
	for (uint32_t i = mesh->first[0]; i < mesh->first[1]; i += 3) {
		double p[3][3];
		for (int k = 0; k < 3; k++)
			for (int c = 0; c < 3; c++) {
				const float *at = mesh->corners[mesh->indices[i + (uint32_t)k]].at;
				p[k][c] = axes[0][c] * at[0] + axes[1][c] * at[1] + axes[2][c] * at[2];
			}
		double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
		double u = ((x - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (y - p[0][1])) / area;
		double v = ((p[1][0] - p[0][0]) * (y - p[0][1]) - (x - p[0][0]) * (p[1][1] - p[0][1])) / area;
		if (fabs(area) > 1e-12 && u >= 0 && v >= 0 && u + v <= 1)
			low = support_least(low, p[0][2] + u * (p[1][2] - p[0][2]) + v * (p[2][2] - p[0][2]));
	}
	return low;
}

static void lugs_are_drawn_where_they_press(void **state)
{
	struct object_mesh mesh;
	assert_ok(render_object_mesh_make(&lugged, &mesh));
	double shoulder = 0.35 * lugged.width / 2, steepest = 0;
	size_t bars = 0, compared = 0;
	for (int k = 0; k < 5; k++) {
		struct deform_contact sweep = {.shape = &lugged, .from = {.yaw = 0.6 * k, .turn = 0.37 * k}};
		double axes[3][3], yaw = 0.6 * k;
		sweep.to = sweep.from;
		soil_axes(yaw, 0, 0, sweep.to.turn, axes);
		for (int i = -60; i <= 60; i++) {
			double u = 0.0091 * i, side = (i % 3) * 0.4 * (lugged.width / 2 - shoulder);
			double x = u * cos(yaw) - side * sin(yaw), y = u * sin(yaw) + side * cos(yaw);
			long double z;
			bool is = reference_underside(&sweep, x, y, &z);
			double drawn = lowest(&mesh, axes, x, y);
			/* A bar's flank is steep: there a little aside is much higher. */
			long double left, right;
			bool beside = reference_underside(&sweep, x - 0.002 * cos(yaw), y - 0.002 * sin(yaw), &left) &&
				      reference_underside(&sweep, x + 0.002 * cos(yaw), y + 0.002 * sin(yaw), &right);
			if (!is || !beside)
				continue;
			double slack = 0.0015 + fabs((double)(left - right));
			steepest = support_most(steepest, fabs((double)(left - right)));
			if (!(fabs(drawn - (double)z) <= slack))
				fail_msg("at %g of turn %g: %g drawn, %g presses", u, sweep.to.turn, drawn, (double)z);
			bars += drawn < -0.5 - 0.03;
			compared++;
		}
	}
	assert_true(bars > 30 && compared > 500 && steepest > 0.03);
	render_object_mesh_finish(&mesh);
}

static const struct soil_shape barrel = {.kind = SOIL_CYLINDER, .radius = 0.4, .length = 0.9}, pill = {.kind = SOIL_CAPSULE, .radius = 0.3, .length = 0.8};
static const struct soil_shape egg = {.kind = SOIL_ELLIPSOID, .size = {0.6, 0.4, 0.2}};

/* Round shapes are drawn within, and nearly as, the shape that presses, in any attitude. */
static void round_shapes_are_drawn_as_they_press(void **state)
{
	const struct soil_shape *shapes[] = {&barrel, &pill, &egg, &wheel};
	(void)state;
	for (int i = 0; i < 4; i++)
		for (int k = 0; k < 4; k++) {
			struct object_mesh mesh;
			struct deform_contact sweep = {.shape = shapes[i], .from = {.yaw = 0.8 * k, .pitch = i < 3 ? 0.5 * k : 0, .roll = 0.3 + 0.6 * k}};
			double axes[3][3], bound = soil_shape_bound(shapes[i]);
			int compared = 0;
			sweep.to = sweep.from;
			assert_ok(render_object_mesh_make(shapes[i], &mesh));
			soil_axes(sweep.to.yaw, sweep.to.pitch, sweep.to.roll, 0, axes);
			for (int n = 0; n < 900; n++) {
				double x = bound * (n % 30 - 15) / 15, y = bound * (n / 30 - 15) / 15, drawn = lowest(&mesh, axes, x, y);
				long double z;
				bool is = reference_underside(&sweep, x, y, &z);
				assert_true(is || drawn == INFINITY);
				compared += is && drawn < INFINITY && (i == 3 || drawn - (double)z < 0.08);
				assert_true(!is || drawn > (double)z - 1e-5);
			}
			assert_true(compared > 60);
			render_object_mesh_finish(&mesh);
		}
}

/* Turned outward, closed, and of the volume that the shape has. */
static void meshes_are_closed_and_turned_outward(void **state)
{
	static const struct {
		const struct soil_shape *shape;
		double least, most; /* m3 */
	} shapes[] = {
		{&ball, 0.98 * 4 / 3 * M_PI * 0.6 * 0.6 * 0.6, 4.0 / 3 * M_PI * 0.6 * 0.6 * 0.6},
		{&box, 1.2 * 0.5 * 0.3 * 0.9999, 1.2 * 0.5 * 0.3 * 1.0001},
		{&wheel, 0.6 * M_PI * 0.25 * 0.4, M_PI * 0.25 * 0.4},
		{&barrel, 0.98 * M_PI * 0.16 * 0.9, M_PI * 0.16 * 0.9},
		{&pill, 0.98 * M_PI * (0.09 * 0.8 + 4.0 / 3 * 0.027), M_PI * (0.09 * 0.8 + 4.0 / 3 * 0.027)},
		{&egg, 0.98 * 4 / 3 * M_PI * 0.6 * 0.4 * 0.2, 4.0 / 3 * M_PI * 0.6 * 0.4 * 0.2},
	};
	for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
		struct object_mesh mesh;
		double volume = 0;
		assert_ok(render_object_mesh_make(shapes[i].shape, &mesh));
		assert_true(mesh.closed);
		for (uint32_t t = mesh.first[0]; t < mesh.first[1]; t += 3) {
			const float *a = mesh.corners[mesh.indices[t]].at, *b = mesh.corners[mesh.indices[t + 1]].at, *c = mesh.corners[mesh.indices[t + 2]].at;
			for (int k = 0; k < 3; k++)
				volume += (double)a[k] * ((double)b[(k + 1) % 3] * c[(k + 2) % 3] - (double)b[(k + 2) % 3] * c[(k + 1) % 3]) / 6;
		}
		if (!(volume >= shapes[i].least && volume <= shapes[i].most))
			fail_msg("shape %zu: %g m3, not %g to %g", i, volume, shapes[i].least, shapes[i].most);
		assert_in_range((mesh.first[1] - mesh.first[0]) / 3, 12, 3200);
		render_object_mesh_finish(&mesh);
	}
}

TEST_PROGRAM(object_shapes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_wheel_is_seen_to_turn),
		cmocka_unit_test(lugs_are_drawn_where_they_press),
		cmocka_unit_test(round_shapes_are_drawn_as_they_press),
		cmocka_unit_test(meshes_are_closed_and_turned_outward),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
