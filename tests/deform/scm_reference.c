/*
 * scm against the reference, sweep by sweep over ground of every kind: sloping, heaped, with holes, pressed before. Each
 * sweep starts from the same state; what it makes of it may differ by what floats round.
 */
#include <stdio.h>

#include "../support/near.h"
#include "ground.h"
#include "../support/program.h"

#define METRES 3e-6 /* a wheel a metre high, in floats */
/* m: where an arc of 0.9 m hardly touches, a height's quantum moves the place of its first touch by sqrt(2 r q). Of that the slip
 * slides a part. */
#define SHEAR 5e-3 /* of its strength: a fixed-point unit of height moves the place of first touch */
#define MOUND 0.25  /* m of heaped soil at most */

static int32_t uneven(int64_t x, int64_t y)
{
	uint32_t h = (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u;
	h = (h ^ h >> 15) * 2654435761u;
	if (h % 23 == 0)
		return BASE_NODATA;
	/* It rises to the north-east, differently. */
	return (int32_t)(x * 9000 + y * 4000) + (int32_t)(h >> 19);
}

static struct soil_numbers soil_of(int round)
{
	static const char *const names[] = {"dry_sand", "lete_sand", "snow_us", "heavy_clay_40"};
	struct soil_numbers soil;
	assert_ok(soil_named(names[round % 4], &soil));
	soil.repose = 89.95 * M_PI / 180; /* nothing slides: what is pressed is seen as it is */
	return soil;
}

/* Heaped soil, and shallow ruts in it, over all tiles. */
static void heap(struct ground *ground)
{
	uint32_t cells = ground->params.cells;
	int64_t side = cells + 1;
	int32_t *heaped = ground_room(side * side, 4), *pressed = ground_room(side * side, 4);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		for (int64_t i = 0; i < side * side; i++) {
			int64_t x = (int64_t)(k % ground->params.tiles) * cells + i % side, y = (int64_t)(k / ground->params.tiles) * cells + i / side;
			bool hole = ground->base[y * ground->posts + x] == BASE_NODATA;
			heaped[i] = hole ? 0 : (int32_t)ldexp(MOUND * sin((double)x * 0.31) * sin((double)y * 0.23), OFFSET_BITS);
			pressed[i] = 0;
		}
		const void *planes[PLANES] = {[PLANE_OFFSET] = heaped, [PLANE_DEPOSITED] = heaped, [PLANE_PLASTIC_SINKAGE] = pressed};
		assert_ok(staged_upload_planes(test_gpu, ground->slots, cells, k, planes));
	}
	mem_free(heaped);
	mem_free(pressed);
}

struct state {
	int32_t *offset, *heaped, *pressed, *shear;
};

static struct state state_of(struct ground *ground)
{
	return (struct state){ground_plane(ground, PLANE_OFFSET), ground_plane(ground, PLANE_DEPOSITED),
			      ground_plane(ground, PLANE_PLASTIC_SINKAGE), ground_plane(ground, PLANE_SHEAR)};
}

static void state_free(struct state *state)
{
	mem_free(state->offset);
	mem_free(state->heaped);
	mem_free(state->pressed);
	mem_free(state->shear);
}

static void take(struct reference_ground *reference, const struct ground *ground, const struct state *state)
{
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		reference->hole[i] = ground->base[i] == BASE_NODATA;
		reference->base[i] = reference->hole[i] ? 0 : ldexp(ground->base[i], -BASE_BITS);
		reference->offset[i] = lattice_offset_metres(state->offset[i]);
		reference->heaped[i] = lattice_offset_metres(state->heaped[i]);
		reference->pressed[i] = lattice_offset_metres(state->pressed[i]);
		for (int part = PLANE_SHEAR_EAST; part <= PLANE_SHEAR_NORTH; part++)
			reference->shear[part][i] = ldexp(plane_shear(state->shear[i], part), -PLANE_SHEAR_BITS);
	}
	reference->compacted = 0;
}

static void near_reference(const char *what, double got, double wanted, double within)
{
	if (!(fabs(got - wanted) <= within))
		fail_msg("%s: %.9g, not %.9g", what, got, wanted);
}

struct seen {
	int pressed, again, heaped, slid, ended;
};

static void compare(const struct ground *ground, const struct state *before, const struct state *after,
		    const struct reference_ground *reference, struct seen *seen)
{
	for (int64_t i = 0; i < ground->posts * ground->posts; i++) {
		char where[64];
		snprintf(where, sizeof where, "post %lld, %lld", (long long)(i % ground->posts), (long long)(i / ground->posts));
		near_reference(where, lattice_offset_metres(after->offset[i]), reference->offset[i], METRES);
		near_reference(where, lattice_offset_metres(after->pressed[i]), reference->pressed[i], METRES);
		for (int part = PLANE_SHEAR_EAST; part <= PLANE_SHEAR_NORTH; part++)
			near_reference(where, ldexp(plane_shear(after->shear[i], part), -PLANE_SHEAR_BITS), reference->shear[part][i], SHEAR);
		assert_int_equal(after->heaped[i], before->heaped[i]);
		bool touched = after->offset[i] != before->offset[i];
		seen->pressed += touched;
		seen->again += touched && before->pressed[i] > 0;
		seen->heaped += touched && before->heaped[i] > 1 << 16;
		seen->slid += after->shear[i] != before->shear[i] && after->shear[i] != 0;
		seen->ended += after->shear[i] == 0 && before->shear[i] != 0;
	}
}

static void every_sweep_is_that_of_the_reference(void **state)
{
	struct seen seen = {0};
	(void)state;
	need_gpu();
	for (int round = 0; round < 8; round++) {
		struct ground ground;
		struct reference_ground reference;
		struct soil_numbers soil = soil_of(round);
		ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .first = 3, .spacing = 0.125, .model = DEFORM_SCM,
							     .height = uneven, .soils = &soil, .iterations = 1});
		int side = (int)ground.posts;
		assert_ok(reference_ground_init(&reference, side, side, ground.params.spacing));
		reference.left = reference.bottom = ground.x0;
		double *under = ground_room(side * side, sizeof *under), *rest = ground_room(side * side, sizeof *rest);
		heap(&ground);
		for (int k = 0; k < 12; k++) {
			struct soil_shape shape = {.kind = k % 3 ? SOIL_WHEEL : SOIL_BOX, .radius = 0.9, .width = 0.7, .size = {1, 1.5, 1.8}, .belt = k % 6 == 0};
			double x = 32 + 12 * any_share(), y = 32 + 12 * any_share();
			double z = ldexp(x * 9000 + y * 4000, -BASE_BITS) + 0.9 - 0.12 * (1 + any_share());
			struct deform_contact sweep = {.shape = &shape, .from = ground_pose(&ground, x, y, z)};
			sweep.to = ground_pose(&ground, x + any_share(), y + any_share(), z - 0.01 * any_share());
			sweep.to.yaw = sweep.from.yaw = 3 * any_share();
			sweep.seconds = k % 4 ? 0.05 : 0;
			sweep.turned = soil_shape_runs(&shape) ? 0.2 * any_share() : 0;
			sweep.to.pitch = sweep.from.pitch = shape.belt && k < 6 ? 0.2 * any_share() : 0;
			struct state before = state_of(&ground), after;
			struct reference_forces forces;
			take(&reference, &ground, &before);
			reference_undersides(&reference, &sweep, under, rest);
			reference_scm(&reference, &soil, 0, &sweep, under, rest, 0, &forces);
			struct deform_forces got = ground_forces(&ground, &sweep);
			after = state_of(&ground);
			compare(&ground, &before, &after, &reference, &seen);
			double most = 0;
			for (int i = 0; i < 3; i++)
				most = support_most(most, fabs(forces.force[i]));
			for (int i = 0; i < 3; i++) {
				near_reference("force", got.force[i], forces.force[i], 1e-3 * most + 1);
				near_reference("moment", got.moment[i], forces.moment[i], 1e-3 * most + 1);
			}
			near_reference("area", got.area, forces.area, 1e-4 * forces.area + 1e-5);
			state_free(&before);
			state_free(&after);
		}
		mem_free(under);
		mem_free(rest);
		reference_ground_finish(&reference);
		ground_finish(&ground);
	}
	print_message("posts pressed %d, again %d, heaped %d, sheared %d, left %d\n", seen.pressed, seen.again, seen.heaped, seen.slid, seen.ended);
	assert_true(seen.pressed > 2000 && seen.again > 200 && seen.heaped > 200 && seen.slid > 1000 && seen.ended > 100);
}

/* Of the plastic flow a share is laid aside: once. */
static void pressed_again_as_deep_it_lays_nothing_more_aside(void **state)
{
	struct soil_numbers soil = soil_of(0);
	struct soil_shape plate = {.kind = SOIL_BOX, .size = {1, 1.5, 1}};
	struct ground ground;
	int64_t sums[3] = {0};
	(void)state;
	need_gpu();
	ground_init(&ground, &(struct ground_params){.cells = 32, .tiles = 2, .spacing = 0.125, .model = DEFORM_SCM, .soils = &soil,
						     .iterations = 1, .bulldozing = 0.5});
	for (int k = 0; k < 3; k++) {
		struct deform_contact sweep = {.shape = &plate, .from = ground_pose(&ground, 30.4, 32.3, k < 2 ? 0.4 : 0.35)};
		sweep.to = sweep.from;
		ground_sweep(&ground, &sweep);
		int32_t *heaped = ground_plane(&ground, PLANE_DEPOSITED);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++)
			sums[k] += heaped[i];
		mem_free(heaped);
	}
	assert_true(sums[0] > 0 && sums[1] == sums[0] && sums[2] > sums[1] && sums[2] < 2 * sums[0]);
	ground_finish(&ground);
}

TEST_PROGRAM(scm_reference)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_sweep_is_that_of_the_reference),
		cmocka_unit_test(pressed_again_as_deep_it_lays_nothing_more_aside),
	};
	return cmocka_run_group_tests_name("deform/scm_reference", tests, open_gpu, close_gpu);
}
