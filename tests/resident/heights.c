/* Heights and normals at points, against every face of the ground. */
#include "query_rig.h"
#include "../support/program.h"

static const struct rig rough = {.extent = {61, 45, 2, 8}, .finest = -2, .fine = 30, .relief = 9, .rut = 0.7};

static void check(const struct rig *rig, const struct rig_face *all, size_t count, struct resident_point point,
		  const struct resident_height *height)
{
	double east = (double)(rig->extent.width - 1) * rig->extent.spacing, north = (double)(rig->extent.height - 1) * rig->extent.spacing;
	bool outside = !(point.x >= 0 && point.y >= 0 && point.x <= east && point.y <= north);
	assert_int_equal(height->outside, outside);
	double there = NAN, normal[3];
	const struct rig_face *face = outside ? NULL : rig_over(all, count, point, 1e-9, &there, normal);
	if (face == NULL) {
		double edge;
		/* On an edge, which no face has for itself; or in a hole. */
		assert_true(height->nodata || rig_over(all, count, point, -1e-9, &edge, normal) != NULL);
		assert_true(height->nodata == (bool)isnan(height->height));
		return;
	}
	assert_false(height->nodata);
	assert_int_equal(height->level, face->level);
	assert_true(fabs(height->height - there) < 1e-10);
	assert_true(!face->cell || height->bilinear == height->height);
	double length = 0;
	for (int i = 0; i < 3; i++) {
		assert_true(fabs(height->normal[i] - normal[i]) < 1e-9);
		length += height->normal[i] * height->normal[i];
	}
	assert_true(fabs(length - 1) < 1e-12 && height->normal[2] > 0);
}

static void every_face_agrees(void **unused)
{
	enum { COUNT = 3000 };
	static struct resident_point points[COUNT];
	static struct resident_height heights[COUNT];
	for (uint64_t seed = 1; seed <= 4; seed++) {
		struct rig rig = rough;
		struct rig_face *all;
		uint64_t state = seed;
		rig.seed = seed;
		rig.holes = seed % 2 ? 0 : 30;
		rig.extent.cells = seed % 3 ? 8 : 32;
		rig.fine = (unsigned)(seed % 4 * 30);
		rig_open(&rig);
		size_t count = rig_faces(&rig, &all), holes = 0, fine = 0;
		for (int i = 0; i < COUNT; i++)
			points[i] = (struct resident_point){rig_between(&state, -3, 125), rig_between(&state, -3, 93)};
		assert_int_equal(resident_heights(&rig.ground, points, COUNT, heights), STATUS_OK);
		for (int i = 0; i < COUNT; i++) {
			check(&rig, all, count, points[i], &heights[i]);
			holes += heights[i].nodata && !heights[i].outside;
			fine += !heights[i].nodata && heights[i].level < 0;
		}
		assert_int_equal(holes > 0, rig.holes > 0);
		assert_int_equal(fine > 0, rig.fine > 0);
		free(all);
	}
}

/* At the posts all agree: the ground, the four posts, the post itself; beside a hole too. */
static void posts_are_posts(void **unused)
{
	struct rig rig = rough;
	size_t lone = 0;
	rig.seed = 5;
	rig.holes = 300;
	rig.fine = 0;
	rig_open(&rig);
	for (int64_t y = 0; y < rig.extent.height; y++)
		for (int64_t x = 0; x < rig.extent.width; x++) {
			struct resident_height height;
			struct resident_point point = {(double)x * rig.extent.spacing, (double)y * rig.extent.spacing};
			double post = rig_post(&rig, x, y);
			assert_int_equal(resident_heights(&rig.ground, &point, 1, &height), STATUS_OK);
			assert_int_equal(height.nodata, isnan(post));
			assert_false(height.outside);
			assert_true(isnan(post) ? isnan(height.height) && isnan(height.bilinear)
						: height.height == post && height.bilinear == post);
			lone += !height.nodata && isnan(height.normal[2]);
		}
	assert_true(lone > 0);
}

static void many_are_as_one(void **unused)
{
	enum { COUNT = 4000 };
	static struct resident_point points[COUNT];
	static struct resident_height together[COUNT];
	struct rig rig = rough;
	uint64_t state = 9;
	rig.holes = 20;
	rig_open(&rig);
	for (int i = 0; i < COUNT; i++)
		points[i] = (struct resident_point){rig_between(&state, -3, 125), rig_between(&state, -3, 93)};
	points[7].x = NAN;
	points[8].y = INFINITY;
	assert_int_equal(resident_heights(&rig.ground, points, COUNT, together), STATUS_OK);
	assert_true(together[7].outside && together[8].outside);
	/* Each tile once, but for those parted by finer ones. */
	uint64_t tiles = 15 * 11;
	assert_true(rig.reads < 3 * tiles);
	for (int i = 0; i < COUNT; i++) {
		struct resident_height alone;
		assert_int_equal(resident_heights(&rig.ground, &points[i], 1, &alone), STATUS_OK);
		assert_memory_equal(&alone, &together[i], offsetof(struct resident_height, nodata) + sizeof alone.nodata); /* what follows is padding */
	}
	rig.fails_at = rig.reads + 3;
	assert_int_equal(resident_heights(&rig.ground, points, COUNT, together), STATUS_INPUT);
	assert_int_equal(resident_heights(&rig.ground, points, 0, together), STATUS_OK);
}

TEST_PROGRAM(heights)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_face_agrees),
		cmocka_unit_test(posts_are_posts),
		cmocka_unit_test(many_are_as_one),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
