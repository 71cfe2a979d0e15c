/*
 * Rays, against every face of the ground in long doubles; and rays that could slip through where faces meet.
 */
#include "query_rig.h"
#include "../support/program.h"

#define FAR 1e-9 /* metres a hit may be off */

static void check(const struct resident_ray *ray, const struct resident_hit *hit, const struct rig_face *all, size_t count)
{
	/* Where a ray just touches an edge, or a hole's, either is right. */
	struct rig_strike loose = rig_strike(all, count, ray, 1e-12L), strict = rig_strike(all, count, ray, -1e-12L);
	if (!hit->hit) {
		if (!isinf(strict.first))
			print_error("missed: %.17g of %.17g %.17g %.17g to %.17g %.17g %.17g\n", (double)strict.first, ray->origin[0],
				    ray->origin[1], ray->origin[2], ray->direction[0], ray->direction[1], ray->direction[2]);
		assert_true(isinf(strict.first));
		return;
	}
	assert_false(isinf(loose.first));
	if (!(hit->distance >= loose.first - FAR && hit->distance <= strict.first + FAR))
		print_error("at %.17g, between %.17g and %.17g\n", hit->distance, (double)loose.first, (double)strict.first);
	assert_true(hit->distance >= loose.first - FAR && hit->distance <= strict.first + FAR);
	double length = sqrt(ray->direction[0] * ray->direction[0] + ray->direction[1] * ray->direction[1] +
			     ray->direction[2] * ray->direction[2]);
	for (int i = 0; i < 3; i++)
		assert_true(fabs(hit->point[i] - (ray->origin[i] + ray->direction[i] / length * hit->distance)) < FAR);
	if (strict.face != loose.face)
		return;
	assert_int_equal(hit->tile.level, strict.face->level);
	double along = 0, up = 0, normal[3];
	rig_normal(strict.face, hit->point[0], hit->point[1], normal);
	for (int i = 0; i < 3; i++) {
		assert_true(fabs(normal[i] - hit->normal[i]) < 1e-8);
		along += hit->normal[i] * ray->direction[i] / length;
		up += hit->normal[i] * hit->normal[i];
	}
	assert_true(fabs(up - 1) < 1e-12 && hit->normal[2] > 0);
	assert_true(hit->below == (along > 0) || fabs(along) < 1e-9);
}

static const struct rig rough = {.extent = {61, 45, 2, 8}, .finest = -2, .fine = 30, .relief = 9, .rut = 0.7};

static struct resident_ray random_ray(const struct rig *rig, uint64_t *state)
{
	double east = (double)(rig->extent.width - 1) * rig->extent.spacing, north = (double)(rig->extent.height - 1) * rig->extent.spacing;
	struct resident_ray ray = {.length = rig_unit(state) < 0.3 ? (double)INFINITY : rig_between(state, 0, 200)};
	double from[3] = {rig_between(state, -20, east + 20), rig_between(state, -20, north + 20), rig_between(state, -15, 25)};
	double to[3] = {rig_between(state, 0, east), rig_between(state, 0, north), rig_between(state, -10, 12)};
	bool grazes = rig_unit(state) < 0.4;
	for (int i = 0; i < 3; i++) {
		ray.origin[i] = from[i];
		ray.direction[i] = to[i] - from[i];
	}
	if (grazes)
		ray.direction[2] *= 0.02;
	if (rig_unit(state) < 0.1)
		ray.direction[0] = ray.direction[1] = 0;
	if (rig_unit(state) < 0.1)
		ray.direction[rig_unit(state) < 0.5] = 0;
	return ray;
}

static void against_all(struct rig rig, size_t rays)
{
	struct rig_face *all;
	rig_open(&rig);
	size_t count = rig_faces(&rig, &all), hits = 0, below = 0;
	uint64_t state = rig.seed;
	for (size_t i = 0; i < rays; i++) {
		struct resident_ray ray = random_ray(&rig, &state);
		struct resident_hit hit;
		assert_int_equal(resident_rays(&rig.ground, &ray, 1, &hit), STATUS_OK);
		check(&ray, &hit, all, count);
		hits += hit.hit;
		below += hit.hit && hit.below;
	}
	assert_true(hits > rays / 10 && below > rays / 100 && hits < rays);
	free(all);
}

static void every_face_agrees(void **state)
{
	for (uint64_t seed = 1; seed <= 6; seed++) {
		struct rig rig = rough;
		rig.seed = seed;
		rig.holes = seed % 2 ? 0 : 30;
		rig.extent.cells = seed % 3 ? 8 : 32;
		rig.fine = (unsigned)(seed % 4 * 30);
		against_all(rig, 400);
	}
}

/* From above everything to below everything, through posts, along edges and diagonals, or a little beside. */
static void slips_through(struct rig rig, size_t rays)
{
	rig_open(&rig);
	uint64_t state = rig.seed + 99;
	double spacing = extent_spacing(&rig.extent, rig.finest);
	for (size_t i = 0; i < rays; i++) {
		struct resident_ray ray = {.length = INFINITY};
		struct resident_hit hit;
		double step = rig_unit(&state) < 0.5 ? spacing : rig.extent.spacing;
		double post[3] = {(double)rig.far * rig.extent.spacing + step * floor(rig_between(&state, 80, 90)),
				  (double)rig.far * rig.extent.spacing + step * floor(rig_between(&state, 80, 90)), 0};
		static const double ways[8][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, -1}, {-1, 0}, {0, -1}, {1, -1}, {2, 1}};
		const double *way = ways[(size_t)rig_between(&state, 0, 8)];
		double beside = rig_unit(&state) < 0.5 ? 0 : ldexp(rig_between(&state, -1, 1), -(int)rig_between(&state, 10, 52));
		double slope = rig_between(&state, 0.3, 3), up = rig.relief * 3 + 2;
		ray.direction[0] = way[0] + beside;
		ray.direction[1] = way[1];
		ray.direction[2] = -slope;
		for (int k = 0; k < 3; k++)
			ray.origin[k] = post[k] - (k < 2 ? ray.direction[k] * up / slope : -up);
		if (rig_unit(&state) < 0.3) {
			ray.origin[2] -= 2 * up;
			ray.direction[2] = slope;
		}
		assert_int_equal(resident_rays(&rig.ground, &ray, 1, &hit), STATUS_OK);
		if (!hit.hit)
			print_error("slipped: %.17g %.17g %.17g to %.17g %.17g %.17g\n", ray.origin[0], ray.origin[1], ray.origin[2],
				    ray.direction[0], ray.direction[1], ray.direction[2]);
		assert_true(hit.hit);
		assert_int_equal(hit.below, ray.direction[2] > 0);
	}
}

static void nothing_slips_through(void **state)
{
	for (uint64_t seed = 1; seed <= 4; seed++) {
		struct rig rig = {.extent = {201, 201, 1, 16}, .seed = seed, .finest = seed % 2 ? -2 : 0, .fine = 50, .relief = 2, .rut = 0.3};
		slips_through(rig, 1500);
		rig.extent.width = rig.extent.height = 10000300;
		rig.far = 10000000;
		slips_through(rig, 1500);
	}
}

/* Finer posts are rounded: along an edge their tile may stand some micrometres higher or lower than the coarser one beside it.
 * What would pass through that crack hits there, and is not under the ground from then on. */
static void no_crack_lets_through(void **unused)
{
	uint64_t state = 5;
	for (int i = 0; i < 1000; i++) {
		struct rig rig = {.extent = {129, 129, 1, 8}, .seed = 8, .finest = -2, .fine = 20, .crack = ldexp(1, -(int)(12 + i % 20))};
		bool east = rig_unit(&state) < 0.5;
		double x = 0.5, y = floor(rig_between(&state, 1, 500)) * 0.25 + 0.1, side = 2, end = 128;
		struct resident_ray ray = {{east ? x : y, east ? y : x, rig.crack / 2}, {east, !east, 0}, INFINITY};
		struct resident_hit hit;
		rig_open(&rig);
		/* The first tile on its way that stands higher; it may begin over one. */
		for (; x < end; x = (floor(x / side) + 1) * side) {
			struct tile tile = {-2, (uint32_t)((east ? x : y) / side), (uint32_t)((east ? y : x) / side)};
			if (rig_present(&rig, tile))
				break;
		}
		assert_int_equal(resident_rays(&rig.ground, &ray, 1, &hit), STATUS_OK);
		if (x == 0.5) {
			assert_true(hit.hit && hit.below);
			continue;
		}
		assert_int_equal(hit.hit, x < end);
		if (hit.hit)
			assert_true(fabs(hit.distance - (x - 0.5)) < 1e-9 && !hit.below);
	}
}

/* More than 10,000 km off all is as it is here. */
static void far_is_as_near(void **unused)
{
	uint64_t state = 7;
	int hits = 0;
	struct rig near = {.extent = {201, 201, 1, 16}, .seed = 3, .relief = 2}, far = near;
	far.extent.width = far.extent.height = 16777216 + 201;
	far.far = 16777216;
	rig_open(&near);
	rig_open(&far);
	for (int i = 0; i < 2000; i++) {
		struct resident_ray ray = {.length = 60}, away;
		struct resident_hit hit, there;
		for (int k = 0; k < 3; k++) {
			ray.origin[k] = floor(rig_between(&state, 0, 200) * 0x1p20) * 0x1p-20;
			ray.direction[k] = rig_between(&state, -1, 1);
		}
		ray.origin[2] /= 16;
		/* Beyond the near one's edge the far one goes on. */
		double reach = 60 / sqrt(ray.direction[0] * ray.direction[0] + ray.direction[1] * ray.direction[1] +
					 ray.direction[2] * ray.direction[2]);
		double x = ray.origin[0] + reach * ray.direction[0], y = ray.origin[1] + reach * ray.direction[1];
		if (!(x > 0 && y > 0 && x < 200 && y < 200))
			continue;
		away = ray;
		away.origin[0] += 16777216;
		away.origin[1] += 16777216;
		assert_int_equal(resident_rays(&near.ground, &ray, 1, &hit), STATUS_OK);
		assert_int_equal(resident_rays(&far.ground, &away, 1, &there), STATUS_OK);
		assert_int_equal(there.hit, hit.hit);
		assert_true(fabs(there.distance - hit.distance) < 1e-7);
		hits += hit.hit;
	}
	assert_true(hits > 200 && hits < 1500);
}

static void what_is_no_ray(void **unused)
{
	struct rig rig = rough;
	rig_open(&rig);
	struct resident_hit hits[2];
	struct resident_ray good = {{50, 40, 100}, {0, 0, -1}, 1000}, bad;
	assert_int_equal(resident_rays(&rig.ground, &good, 1, hits), STATUS_OK);
	assert_true(hits[0].hit && !hits[0].below && hits[0].normal[2] > 0);
	const struct resident_ray refused[] = {
		{{NAN, 0, 0}, {0, 0, -1}, 10},      {{0, INFINITY, 0}, {0, 0, -1}, 10}, {{50, 40, 100}, {0, NAN, -1}, 10},
		{{50, 40, 100}, {0, 0, 0}, 10},     {{50, 40, 100}, {0, 0, -1}, NAN},   {{50, 40, 100}, {0, 0, -1}, -1},
		{{50, 40, 100}, {0, INFINITY, 0}, 10},
	};
	for (size_t i = 0; i < sizeof refused / sizeof *refused; i++)
		assert_int_equal(resident_rays(&rig.ground, &refused[i], 1, hits), STATUS_INPUT);
	/* The second of two, by its number. */
	const struct resident_ray two[2] = {good, refused[0]};
	assert_int_equal(resident_rays(&rig.ground, two, 2, hits), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "ray 1"));
	/* Tiny, huge, too short, of no length. */
	bad = good;
	bad.direction[2] = -1e-300;
	assert_int_equal(resident_rays(&rig.ground, &bad, 1, &hits[1]), STATUS_OK);
	assert_true(hits[1].hit && hits[1].distance == hits[0].distance);
	bad.direction[2] = -1e300;
	assert_int_equal(resident_rays(&rig.ground, &bad, 1, &hits[1]), STATUS_OK);
	assert_true(hits[1].hit && hits[1].distance == hits[0].distance);
	bad.length = hits[0].distance - 1e-6;
	assert_int_equal(resident_rays(&rig.ground, &bad, 1, &hits[1]), STATUS_OK);
	assert_false(hits[1].hit);
	bad.length = 0;
	assert_int_equal(resident_rays(&rig.ground, &bad, 1, &hits[1]), STATUS_OK);
	assert_false(hits[1].hit);
	bad.origin[2] = hits[0].point[2];
	assert_int_equal(resident_rays(&rig.ground, &bad, 1, &hits[1]), STATUS_OK);
	rig.fails_at = rig.reads + 1;
	assert_int_equal(resident_rays(&rig.ground, &good, 1, hits), STATUS_INPUT);
}

/* On the ground, at its edge, in it. */
static void where_it_begins(void **unused)
{
	struct rig rig = {.extent = {33, 33, 1, 8}};
	struct resident_hit hit;
	rig_open(&rig); /* level, at 0 */
	const struct {
		struct resident_ray ray;
		bool hit, below;
		double distance;
	} cases[] = {
		{{{5.5, 5.5, 0}, {1, 0, 0}, 10}, true, false, 0},
		{{{5.5, 5.5, 0}, {1, 0, 0}, 0}, true, false, 0},
		{{{5, 5, -1}, {0, 0, 1}, 10}, true, true, 1},
		{{{5, 5, -1}, {0, 0, -1}, INFINITY}, false, false, 0},
		{{{5, 5, 1}, {0, 0, 1}, INFINITY}, false, false, 0},
		{{{32, 32, 1}, {0, 0, -1}, 10}, true, false, 1},
		{{{0, 0, 1}, {0, 0, -1}, 10}, true, false, 1},
		{{{32, 5, 1}, {0, 1, -1}, 10}, true, false, sqrt(2)},
		{{{5, 32, 3}, {4, 0, -3}, 10}, true, false, 5},
		{{{32.001, 5, 1}, {0, 0, -1}, 10}, false, false, 0},
		{{{-3, 16, 4}, {3, 0, -4}, INFINITY}, true, false, 5},
		{{{-3, 16, -4}, {3, 0, 4}, INFINITY}, true, true, 5},
		{{{-1, 16, 0}, {1, 0, 0}, INFINITY}, true, false, 1},
		{{{40, 16, 1}, {1, 0, 0}, INFINITY}, false, false, 0},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		assert_int_equal(resident_rays(&rig.ground, &cases[i].ray, 1, &hit), STATUS_OK);
		assert_int_equal(hit.hit, cases[i].hit);
		assert_true(!hit.hit || fabs(hit.distance - cases[i].distance) < 1e-12);
		assert_int_equal(hit.below, cases[i].below);
	}
}

/* The world's edge is in a tile's midst, at a block's side, or at a tile's; rays down on it, along it, and on its corners. */
static void the_edge_is_ground(void **unused)
{
	for (int64_t side = 18; side < 36; side++)
		for (int level = 0; level >= -2; level--)
			for (uint32_t cells = 8; cells <= 32; cells *= 2) {
				struct rig rig = {.extent = {side, side + 3, 1, cells}, .finest = level, .fine = 50, .relief = 1};
				double east = (double)side - 1, north = (double)side + 2;
				const struct resident_ray rays[] = {
					{{east, 7.25, 9}, {0, 0, -1}, INFINITY}, {{7.25, north, 9}, {0, 0, -1}, INFINITY},
					{{east, north, 9}, {0, 0, -1}, INFINITY}, {{east, -9, 9}, {0, 1, -0.9}, INFINITY},
					{{-9, north, 9}, {1, 0, -0.9}, INFINITY}, {{0, -9, 9}, {0, 1, -0.9}, INFINITY},
					{{east + 4, 9, 4}, {-1, 0, -1}, INFINITY}, {{east - 4, north - 4, 4}, {1, 1, -1}, INFINITY},
					{{9, north + 4, -4}, {0, -1, 1}, INFINITY},
				};
				enum { COUNT = sizeof rays / sizeof *rays };
				struct resident_hit hits[COUNT];
				rig_open(&rig);
				assert_int_equal(resident_rays(&rig.ground, rays, COUNT, hits), STATUS_OK);
				for (int i = 0; i < COUNT; i++) {
					struct resident_height height;
					struct resident_point at = {hits[i].point[0], hits[i].point[1]};
					if (i >= 6 && !hits[i].hit)
						continue; /* may pass beside */
					assert_true(hits[i].hit);
					assert_int_equal(resident_heights(&rig.ground, &at, 1, &height), STATUS_OK);
					assert_true(fabs(height.height - hits[i].point[2]) < 1e-9 && !isnan(height.normal[2]));
				}
			}
}

static void many_are_as_one(void **unused)
{
	enum { COUNT = 500 };
	static struct resident_ray rays[COUNT];
	static struct resident_hit together[COUNT];
	struct rig rig = rough;
	uint64_t state = 4;
	rig.holes = 20;
	rig_open(&rig);
	for (int i = 0; i < COUNT; i++)
		rays[i] = random_ray(&rig, &state);
	assert_int_equal(resident_rays(&rig.ground, rays, COUNT, together), STATUS_OK);
	for (int i = 0; i < COUNT; i++) {
		struct resident_hit alone;
		assert_int_equal(resident_rays(&rig.ground, &rays[i], 1, &alone), STATUS_OK);
		assert_int_equal(alone.hit, together[i].hit);
		assert_true(alone.distance == together[i].distance && tile_equal(alone.tile, together[i].tile));
	}
}

TEST_PROGRAM(rays)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_face_agrees), cmocka_unit_test(nothing_slips_through), cmocka_unit_test(far_is_as_near),
		cmocka_unit_test(what_is_no_ray),        cmocka_unit_test(where_it_begins),       cmocka_unit_test(many_are_as_one),
		cmocka_unit_test(the_edge_is_ground),     cmocka_unit_test(no_crack_lets_through),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
