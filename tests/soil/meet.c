/* Bodies that meet the ground together: parts of a body bear as the whole, the lowest bears, and their order does not show. */
#include "bed.h"
#include "../support/program.h"

#define MOST 8

/* Bodies that move together. */
struct party {
	struct soil_shape shapes[MOST];
	double at[MOST][3]; /* m from the place of the party */
	double load[MOST];
	int count;
};

/* What bears them: of all together. */
struct borne {
	double force[3], moment[3], z, area;
};

static const double places[3] = {0.05, 0.025, 0.0125};
static const char *const soils[] = {"dry_sand", "clayey_38", "lean_clay_22"};

static struct soil_pose pose_of(const struct party *party, int i, const double at[3], double yaw)
{
	const double x = party->at[i][0], y = party->at[i][1];
	return (struct soil_pose){lattice_offset(at[0] + cos(yaw) * x - sin(yaw) * y), lattice_offset(at[1] + sin(yaw) * x + cos(yaw) * y),
				  lattice_offset(at[2] + party->at[i][2]), yaw, 0, 0, 0};
}

/* Moves the party from one place to another. order: of its bodies. */
static struct borne move(struct bed *bed, const struct party *party, const int *order, const double from[3], const double to[3], double yaw, double turned)
{
	struct soil_work *works[MOST];
	struct soil_motion motions[MOST];
	struct soil_imprint imprints[MOST];
	uint8_t *owners = mem_calloc(bed->posts, 1);
	struct soil_claim *claims = mem_calloc(bed->posts, sizeof *claims);
	struct borne all = {.area = 0};
	assert_true(owners != NULL && claims != NULL);
	for (int k = 0; k < party->count; k++) {
		const int i = order != NULL ? order[k] : k;
		assert_ok(soil_work_create(&works[k]));
		motions[k] = (struct soil_motion){.shape = &party->shapes[i], .from = pose_of(party, i, from, yaw), .to = pose_of(party, i, to, yaw), .load = party->load[i],
						  .turned = party->shapes[i].kind == SOIL_WHEEL ? turned : 0};
		motions[k].jumped = soil_only_set_down(&motions[k].from, &motions[k].to);
		assert_ok(soil_sink_begin(&bed->law, &bed->planes, &motions[k], 0, works[k]));
	}
	for (int round = 0; round < 4; round++) {
		for (int k = 0; k < party->count; k++) {
			const struct soil_work *others[MOST];
			int count = 0;
			for (int n = 0; n < party->count; n++)
				if (n != k)
					others[count++] = works[n];
			assert_ok(soil_sink_meet(works[k], others, (size_t)count));
		}
		for (int k = 0; k < party->count; k++)
			soil_sink_find(works[k], &imprints[k]);
	}
	for (int k = 0; k < party->count; k++)
		soil_sink_claim(works[k], (uint8_t)(k + 1), claims);
	for (int k = 0; k < party->count; k++) {
		const struct soil_laying laying = soil_laying_of(motions[k].shape, &motions[k].from, &motions[k].to, motions[k].turned, motions[k].rotated, bed->law.spacing);
		const struct soil_sink sink = {.laying = &laying, .soils = bed->laid};
		const struct soil_sink_shared shared = {claims, owners, (uint8_t)(k + 1)};
		const double *force = imprints[k].forces.force, *moment = imprints[k].forces.moment;
		soil_sink_commit(works[k], &sink, &shared, &imprints[k]);
		const double arm[3] = {lattice_offset_metres(motions[k].to.x) - to[0], lattice_offset_metres(motions[k].to.y) - to[1], lattice_offset_metres(imprints[k].forces.z) - to[2]};
		for (int n = 0; n < 3; n++) {
			const int a = (n + 1) % 3, b = (n + 2) % 3;
			all.force[n] += force[n];
			all.moment[n] += moment[n] + arm[a] * force[b] - arm[b] * force[a];
		}
		all.area += imprints[k].forces.area;
		all.z += (lattice_offset_metres(imprints[k].forces.z) - party->at[order != NULL ? order[k] : k][2]) / party->count;
		soil_work_destroy(works[k]);
	}
	mem_free(owners);
	mem_free(claims);
	return all;
}

/* Rolls or drags a party over the bed. Without loads it is `sunk` metres deep. */
static struct borne run(struct bed *bed, const struct party *party, const int *order, double reach, double sunk, double yaw, double slip)
{
	const double step = bed->law.spacing, ground = bed_ground(bed, 0, 0), way = 0.35;
	double from[3] = {1.013, 1.007, ground + reach - sunk};
	struct borne last = {.area = 0};
	bed_reset(bed);
	move(bed, party, order, from, from, yaw, 0);
	for (double gone = 0; gone < way; gone += step) {
		const double to[3] = {from[0] + step * cos(yaw), from[1] + step * sin(yaw), from[2]};
		last = move(bed, party, order, from, to, yaw, step / (reach * (1 - slip)));
		memcpy(from, to, sizeof from);
	}
	return last;
}

static void assert_alike(const struct borne *one, const struct borne *parts, double within, const char *what)
{
	const double size = sqrt(one->force[0] * one->force[0] + one->force[1] * one->force[1] + one->force[2] * one->force[2]);
	for (int k = 0; k < 3; k++)
		if (!(fabs(parts->force[k] - one->force[k]) <= within * size) || !(fabs(parts->moment[k] - one->moment[k]) <= within * size * 0.3))
			fail_msg("%s: force %g %g %g and moment %g %g %g, of one body %g %g %g and %g %g %g", what, parts->force[0], parts->force[1], parts->force[2],
				 parts->moment[0], parts->moment[1], parts->moment[2], one->force[0], one->force[1], one->force[2], one->moment[0], one->moment[1], one->moment[2]);
	if (!(fabs(parts->area - one->area) <= within * one->area))
		fail_msg("%s: area %g, of one body %g", what, parts->area, one->area);
}

static struct soil_shape wheel(double width)
{
	return (struct soil_shape){.kind = SOIL_WHEEL, .radius = 0.3, .width = width};
}

static struct soil_shape plate(double length, double width)
{
	return (struct soil_shape){.kind = SOIL_BOX, .size = {length, width, 0.1}};
}

static void two_halves_of_a_wheel_are_a_wheel(void **state)
{
	for (size_t s = 0; s < COUNT(soils); s++)
		for (int p = 0; p < 3; p++)
			for (int heading = 0; heading < 2; heading++)
				for (int loaded = 0; loaded < 2; loaded++) {
					struct bed bed;
					const struct soil_numbers soil = bed_soil(soils[s]);
					const double load = loaded ? 900 : 0, yaw = heading ? 0.41 : 0;
					const struct party one = {.shapes = {wheel(0.24)}, .load = {load}, .count = 1};
					const struct party halves = {.shapes = {wheel(0.12), wheel(0.12)}, .at = {{0, 0.06, 0}, {0, -0.06, 0}}, .load = {load / 2, load / 2}, .count = 2};
					char what[100];
					snprintf(what, sizeof what, "%s, %g m, heading %g, load %g", soils[s], places[p], yaw, load);
					bed_init(&bed, &soil, places[p], (int)(2.6 / places[p]), 0, 0);
					const struct borne whole = run(&bed, &one, NULL, 0.3, 0.02, yaw, 0.2), parts = run(&bed, &halves, NULL, 0.3, 0.02, yaw, 0.2);
					assert_alike(&whole, &parts, 0.02, what);
					if (loaded && !(fabs(whole.z - parts.z) <= 0.02 * fabs(whole.z - bed_ground(&bed, 0, 0) - 0.3)))
						fail_msg("%s: sinks to %g and %g", what, parts.z, whole.z);
					bed_finish(&bed);
				}
}

static void four_parts_of_a_plate_are_a_plate_also_if_they_overlap(void **state)
{
	for (size_t s = 0; s < COUNT(soils); s++)
		for (int p = 0; p < 3; p++)
			for (int more = 0; more < 2; more++)
				for (int heading = 0; heading < 2; heading++) {
					struct bed bed;
					const struct soil_numbers soil = bed_soil(soils[s]);
					const double yaw = heading ? 0.3 : 0, over = more ? 0.037 : 0;
					const struct party one = {.shapes = {plate(0.6, 0.4)}, .count = 1};
					struct party four = {.count = 4};
					char what[100];
					snprintf(what, sizeof what, "%s, %g m, heading %g, over each other by %g", soils[s], places[p], yaw, over);
					for (int i = 0; i < 4; i++) {
						const int ahead = i & 1 ? 1 : -1, aside = i & 2 ? 1 : -1;
						four.shapes[i] = plate(0.3 + over, 0.2 + over);
						four.at[i][0] = ahead * (0.15 - over / 2);
						four.at[i][1] = aside * (0.1 - over / 2);
					}
					bed_init(&bed, &soil, places[p], (int)(2.6 / places[p]), 0, 0);
					const struct borne whole = run(&bed, &one, NULL, 0.05, 0.01, yaw, 0), parts = run(&bed, &four, NULL, 0.05, 0.01, yaw, 0);
					assert_alike(&whole, &parts, 0.02, what);
					bed_finish(&bed);
				}
}

static void two_bodies_in_one_place_are_one(void **state)
{
	const struct soil_shape shapes[] = {
		wheel(0.2), plate(0.4, 0.3), {.kind = SOIL_SPHERE, .radius = 0.25}, {.kind = SOIL_CYLINDER, .radius = 0.2, .length = 0.4},
		{.kind = SOIL_CAPSULE, .radius = 0.15, .length = 0.3}, {.kind = SOIL_ELLIPSOID, .size = {0.3, 0.2, 0.15}},
	};
	for (size_t i = 0; i < COUNT(shapes); i++)
		for (int p = 0; p < 3; p++)
			for (int loaded = 0; loaded < 2; loaded++) {
				struct bed bed;
				const struct soil_numbers soil = bed_soil("lean_clay_22");
				const double reach = soil_shape_reach(&shapes[i], 0, 0), load = loaded ? 1500 : 0;
				const struct party one = {.shapes = {shapes[i]}, .load = {load}, .count = 1}, two = {.shapes = {shapes[i], shapes[i]}, .load = {load / 2, load / 2}, .count = 2};
				char what[100];
				snprintf(what, sizeof what, "shape %d, %g m, load %g", (int)shapes[i].kind, places[p], load);
				bed_init(&bed, &soil, places[p], (int)(2.6 / places[p]), 0, 0);
				const struct borne whole = run(&bed, &one, NULL, reach, 0.02, 0.2, 0.1), both = run(&bed, &two, NULL, reach, 0.02, 0.2, 0.1);
				assert_alike(&whole, &both, 0.002, what);
				bed_finish(&bed);
			}
}

static void their_order_does_not_show(void **state)
{
	static const int orders[3][4] = {{0, 1, 2, 3}, {3, 1, 0, 2}, {2, 3, 1, 0}};
	const struct party party = {.shapes = {wheel(0.2), plate(0.5, 0.3), {.kind = SOIL_SPHERE, .radius = 0.2}, wheel(0.2)},
				    .at = {{0, 0, 0}, {0.2, 0.1, -0.24}, {-0.1, -0.15, -0.1}, {0, 0, 0}}, .count = 4};
	struct bed bed;
	const struct soil_numbers soil = bed_soil("lean_clay_22");
	bed_init(&bed, &soil, 0.025, 110, 0.1, -0.05);
	bed.law.bulldozing = 0.5;
	bed.law.slip_sinkage = 1;
	int32_t *const planes[] = {bed.planes.offset, bed.planes.deposited, bed.planes.sinkage, bed.planes.shear, bed.planes.dug};
	int32_t *first[COUNT(planes)];
	struct borne found[3];
	for (int i = 0; i < 3; i++) {
		found[i] = run(&bed, &party, orders[i], 0.3, 0.03, 0.3, 0.3);
		for (size_t k = 0; k < COUNT(planes); k++) {
			if (i > 0) {
				assert_memory_equal(planes[k], first[k], bed.posts * sizeof(int32_t));
				continue;
			}
			assert_non_null(first[k] = mem_alloc(bed.posts, sizeof(int32_t)));
			memcpy(first[k], planes[k], bed.posts * sizeof(int32_t));
		}
	}
	assert_true(found[0].area > 0.05);
	assert_alike(&found[0], &found[1], 1e-9, "another order");
	for (size_t k = 0; k < COUNT(planes); k++)
		mem_free(first[k]);
	bed_finish(&bed);
}

/* A hull above the ground, and a plate that lies deeper. */
static void what_does_not_reach_the_ground_bears_nothing_and_the_lowest_bears(void **state)
{
	struct bed bed;
	const struct soil_numbers soil = bed_soil("dry_sand");
	bed_init(&bed, &soil, 0.02, 130, 0, 0);
	const struct party alone = {.shapes = {wheel(0.2)}, .count = 1};
	const struct party below = {.shapes = {wheel(0.2), plate(0.9, 0.9)}, .at = {{0, 0, 0}, {0, 0, -0.15}}, .count = 2};
	const struct borne one = run(&bed, &alone, NULL, 0.3, 0.03, 0, 0.2), both = run(&bed, &below, NULL, 0.3, 0.03, 0, 0.2);
	assert_memory_equal(&one.force, &both.force, sizeof one.force);
	/* The wheel under a plate that is higher by 1 cm: together they bear what the plate bears, and what the wheel bears more within its patch. */
	const struct party deep = {.shapes = {plate(0.8, 0.6)}, .at = {{0, 0, -0.23}}, .count = 1};
	const struct party small = {.shapes = {plate(0.3, 0.2)}, .at = {{0, 0, -0.25}}, .count = 1};
	const struct party hole = {.shapes = {plate(0.3, 0.2)}, .at = {{0, 0, -0.23}}, .count = 1};
	const struct party two = {.shapes = {plate(0.8, 0.6), plate(0.3, 0.2)}, .at = {{0, 0, -0.23}, {0, 0, -0.25}}, .count = 2};
	bed.law.soils[0].bekker_kc = 0; /* so that the width of a patch does not count */
	const double at[3] = {1.3, 1.3, bed.height + 0.27};
	double up[4];
	const struct party *const parties[] = {&deep, &small, &hole, &two};
	for (int i = 0; i < 4; i++) {
		bed_reset(&bed);
		up[i] = move(&bed, parties[i], NULL, at, at, 0, 0).force[2];
	}
	assert_true(up[0] > 0 && up[1] > up[2]);
	assert_true(fabs(up[3] - (up[0] - up[2] + up[1])) < 0.01 * up[3]);
	bed_finish(&bed);
}

TEST_PROGRAM(meet)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(two_halves_of_a_wheel_are_a_wheel),
		cmocka_unit_test(four_parts_of_a_plate_are_a_plate_also_if_they_overlap),
		cmocka_unit_test(two_bodies_in_one_place_are_one),
		cmocka_unit_test(their_order_does_not_show),
		cmocka_unit_test(what_does_not_reach_the_ground_bears_nothing_and_the_lowest_bears),
	};
	return cmocka_run_group_tests_name("soil/meet", tests, NULL, NULL);
}
