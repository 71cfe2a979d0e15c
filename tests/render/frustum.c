/* Boxes against cameras. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "render/select.h"
#include "../support/program.h"

static const double forward[3] = {1, 0, 0}, right[3] = {0, -1, 0}, up[3] = {0, 0, 1};

static bool visible(const struct render_view *view, double x, double y, double z)
{
	double low[3] = {x - 0.5, y - 0.5, z - 0.5}, high[3] = {x + 0.5, y + 0.5, z + 0.5};
	return render_box_visible(view->planes, low, high);
}

static void a_box_is_seen_where_the_camera_looks_and_nowhere_else(void **state)
{
	const double eyes[2][3] = {{0, 0, 0}, {1e7, -1e7, 8000}};
	for (int i = 0; i < 2; i++) {
		const double *e = eyes[i];
		struct render_view view;
		double wide = tan(0.5) * 2;
		render_frustum(e, forward, right, up, 1.0, 2.0, 1000, view.planes);
		assert_true(visible(&view, e[0] + 100, e[1], e[2]));
		assert_false(visible(&view, e[0] - 100, e[1], e[2]));
		assert_true(visible(&view, e[0] + 100, e[1] + 100 * wide - 1, e[2]));
		assert_false(visible(&view, e[0] + 100, e[1] + 100 * wide + 3, e[2]));
		assert_false(visible(&view, e[0] + 100, e[1] - 100 * wide - 3, e[2]));
		assert_false(visible(&view, e[0] + 100, e[1], e[2] + 100 * tan(0.5) + 3));
		assert_false(visible(&view, e[0] + 100, e[1], e[2] - 100 * tan(0.5) - 3));
		assert_true(visible(&view, e[0] + 999, e[1], e[2]));
		assert_false(visible(&view, e[0] + 1001, e[1], e[2]));
		assert_true(visible(&view, e[0], e[1], e[2])); /* the box around the eye */
	}
}

static void a_distance_is_to_the_nearest_point_of_the_box(void **state)
{
	const double low[3] = {0, 0, 0}, high[3] = {10, 10, 10};
	const double inside[3] = {5, 5, 5}, above[3] = {5, 5, 17}, corner[3] = {-3, 14, 5};
	assert_true(render_box_distance(inside, low, high) == 0);
	assert_true(render_box_distance(above, low, high) == 7);
	assert_true(render_box_distance(corner, low, high) == 5);
}

static void a_tile_ends_at_the_worlds_edge(void **state)
{
	const struct extent extent = {301, 203, 2, 64};
	double low[2], high[2];
	render_box(&extent, (struct tile){2, 1, 0}, low, high);
	assert_true(low[0] == 512 && low[1] == 0 && high[0] == 600 && high[1] == 404);
	render_box(&extent, (struct tile){-1, 1, 2}, low, high);
	assert_true(low[0] == 64 && low[1] == 128 && high[0] == 128 && high[1] == 192);
}

TEST_PROGRAM(frustum)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_box_is_seen_where_the_camera_looks_and_nowhere_else),
		cmocka_unit_test(a_distance_is_to_the_nearest_point_of_the_box),
		cmocka_unit_test(a_tile_ends_at_the_worlds_edge),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
