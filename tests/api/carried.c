/* What furrow.h promises of a body that carries soil: its weight is in the contact, a rollback leaves it as it was, and what is aboard of a body that is removed lands. */
#include "../support/near.h"
#include "rut.h"

#include "../support/program.h"

#define SCENE "{time_step: 0.01, spacing: 0.125, soil: {name: dry_sand, unit_weight: 16000}, redistribute: {model: scm, interval: 0.05}}"
#define PLATE "{name: plate, shape: {box: {size: [1, 2, 0.25]}}, carry: true}"
#define UNIT (16000.0 * 0.125 * 0.125) /* N for each metre of soil at a post */

static furrow_body plate_in(struct furrow_world *world)
{
	furrow_body plate = -1;
	const struct furrow_pose pose = hosted_pose(10, 16, 99.8);
	done(furrow_body_add(world, PLATE, &plate));
	done(furrow_place(world, plate, &pose));
	done(furrow_step(world, 0.05));
	return plate;
}

/* Digs for 1.5 m, and is lifted. */
static void dig(struct furrow_world *world, furrow_body plate)
{
	for (int i = 1; i <= 30; i++)
		hosted_move(world, plate, 10 + 0.05 * i, 16, 99.8);
	for (int i = 1; i <= 20; i++)
		hosted_move(world, plate, 11.5, 16, 99.8 + 0.05 * i);
}

/* Goes on, and tilts by 45 degrees. */
static void tip(struct furrow_world *world, furrow_body plate)
{
	for (int i = 1; i <= 30; i++) {
		struct furrow_state state = hosted_state(11.5 + 0.05 * i, 16 + 0.03 * i, 100.8);
		const double half = 0.5 * M_PI / 4 * i / 30;
		state.pose.orientation[0] = cos(half);
		state.pose.orientation[2] = sin(half);
		done(furrow_set_states(world, 1, &plate, &state));
		done(furrow_step(world, 0.02));
	}
}

/* Returns the sum of all offsets, m. */
static double sum_of(struct furrow_world *world)
{
	struct furrow_info info;
	double *offsets = hosted_read(world, FURROW_OFFSET, &info), sum = 0;
	for (size_t i = 0; i < (size_t)(info.columns * info.rows); i++)
		sum += offsets[i];
	free(offsets);
	return sum;
}

static void what_a_body_carries_weighs_on_it(void **state)
{
	struct furrow_world *world = hosted_world_over("carried.furrow", SCENE, hosted_flat);
	const furrow_body plate = plate_in(world);
	dig(world, plate);
	for (int i = 0; i < 20; i++)
		done(furrow_step(world, 0.05));
	const struct furrow_contact contact = contact_of(world, plate);
	struct furrow_contact probed;
	struct furrow_state at;
	done(furrow_get_states(world, 1, &plate, &at));
	done(furrow_probe(world, 1, &plate, &at, &probed, sizeof probed));
	print_message("the load presses by %g N, with a moment of %g N m about y\n", contact.force[2], contact.moment[1]);
	assert_true(contact.force[2] < -500 && contact.force[2] > -16000 * 2);
	assert_true(contact.force[0] == 0 && contact.force[1] == 0);
	for (int k = 0; k < 3; k++)
		assert_true(probed.force[k] == contact.force[k] && probed.moment[k] == contact.moment[k]);
	assert_true(fabs(contact.carried * 16000 + contact.force[2]) < 1e-9 * -contact.force[2] && probed.carried == contact.carried);
	_Alignas(double) char older[offsetof(struct furrow_contact, carried)];
	done(furrow_get_contacts(world, 1, &plate, (struct furrow_contact *)(void *)older, sizeof older));
	assert_memory_equal(older + offsetof(struct furrow_contact, force), contact.force, sizeof contact.force);
	/* All of it lands when the body is removed. */
	const double before = sum_of(world);
	done(furrow_body_remove(world, plate));
	for (int i = 0; i < 20; i++)
		done(furrow_step(world, 0.05));
	assert_true(fabs((sum_of(world) - before) * UNIT + contact.force[2]) < 1e-6 * -contact.force[2]);
	done(furrow_world_close(world));
}

#define FALLS "{time_step: 0.01, spacing: 0.125, soil: {name: dry_sand, unit_weight: 16000}, redistribute: {model: scm, interval: 0.05, thrown: on}}"

/* Rolls back to where the plate is full, or to where its soil falls. */
static void rolls_back(const char *scene, bool falls)
{
	struct furrow_world *world = hosted_world_over("carried.furrow", scene, hosted_flat);
	const furrow_body plate = plate_in(world);
	dig(world, plate);
	for (int i = 1; i <= 12 && falls; i++) {
		struct furrow_state state = hosted_state(11.5, 16, 100.8);
		const double half = 0.5 * M_PI / 3 * i / 12;
		state.pose.orientation[0] = cos(half);
		state.pose.orientation[2] = sin(half);
		done(furrow_set_states(world, 1, &plate, &state));
		done(furrow_step(world, 0.02));
	}
	done(furrow_checkpoint(world));
	const struct furrow_contact kept = contact_of(world, plate);
	const double landed = sum_of(world);
	struct furrow_contact ends[2];
	double *offsets[2];
	struct furrow_info info;
	for (int i = 0; i < 2; i++) {
		tip(world, plate);
		ends[i] = contact_of(world, plate);
		offsets[i] = hosted_read(world, FURROW_OFFSET, &info);
		done(furrow_rollback(world));
		const struct furrow_contact back = contact_of(world, plate);
		for (int k = 0; k < 3; k++)
			assert_true(back.force[k] == kept.force[k] && back.moment[k] == kept.moment[k]);
	}
	print_message("%g N before, %g N after it was tipped\n", kept.force[2], ends[0].force[2]);
	assert_true(!falls || sum_of(world) == landed);
	tip(world, plate);
	assert_true(!falls || sum_of(world) > landed + 0.01); /* some was in the air */
	assert_true(falls || ends[0].force[2] > 0.5 * kept.force[2]);
	for (int k = 0; k < 3; k++)
		assert_true(ends[0].force[k] == ends[1].force[k] && ends[0].moment[k] == ends[1].moment[k]);
	assert_memory_equal(offsets[0], offsets[1], (size_t)(info.columns * info.rows) * sizeof **offsets);
	free(offsets[0]);
	free(offsets[1]);
	done(furrow_world_close(world));
}

static void a_rollback_puts_it_back_aboard(void **state)
{
	rolls_back(SCENE, false);
}

static void a_rollback_puts_it_back_into_the_air(void **state)
{
	rolls_back(FALLS, false);
	rolls_back(FALLS, true);
}

static void only_boxes_and_meshes_under_scm_carry(void **state)
{
	struct furrow_world *world = hosted_world("carried.furrow");
	furrow_body body = -1;
	refused(FURROW_INPUT, furrow_body_add(world, "{shape: {sphere: {radius: 0.5}}, carry: true}", &body));
	refused(FURROW_INPUT, furrow_body_add(world, "{shape: {box: {size: [1, 0.4, 0.3], belt: true}}, carry: true}", &body));
	done(furrow_world_close(world));
	world = hosted_world_over("carried.furrow", "{time_step: 0.01, spacing: 0.125, redistribute: {model: box}}", hosted_flat);
	refused(FURROW_INPUT, furrow_body_add(world, PLATE, &body));
	done(furrow_world_close(world));
}

/* What no record keeps is laid down to the unit when the world is closed, where the plate is. removed: the plate was taken out, and no step came after it. */
static void lands_at_the_end(const char *scene, bool removed)
{
	struct furrow_world *world = hosted_world_over("carried.furrow", scene, hosted_flat);
	const furrow_body plate = plate_in(world);
	dig(world, plate);
	for (int i = 0; i < 40; i++) /* nothing is in flight */
		done(furrow_step(world, 0.05));
	const double before = sum_of(world), below = point_at(world, 11.5, 16).offset, aboard = contact_of(world, plate).carried / (0.125 * 0.125);
	assert_true(aboard > 1);
	if (removed)
		done(furrow_body_remove(world, plate));
	done(furrow_world_close(world));
	const struct furrow_open open = hosted_open(scene, support_path("carried.furrow"));
	done(furrow_world_open(&open, &world));
	print_message("%.6f m of %.6f m landed\n", sum_of(world) - before, aboard);
	assert_near(sum_of(world) - before, aboard, 0x1p-22); /* a unit is 2^-20 m, and sums of whole units are exact */
	assert_true(point_at(world, 11.5, 16).offset > below + 0.05);
	assert_true(point_at(world, 14, 16).offset == 0);
	done(furrow_world_close(world));
}

static void it_lands_when_the_world_is_closed(void **state)
{
	for (int i = 0; i < 4; i++)
		lands_at_the_end(i % 2 == 0 ? SCENE : FALLS, i >= 2);
}

TEST_PROGRAM(carried)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_a_body_carries_weighs_on_it),
		cmocka_unit_test(a_rollback_puts_it_back_aboard),
		cmocka_unit_test(a_rollback_puts_it_back_into_the_air),
		cmocka_unit_test(it_lands_when_the_world_is_closed),
		cmocka_unit_test(only_boxes_and_meshes_under_scm_carry),
	};
	return cmocka_run_group_tests_name("carried", tests, support_enter, support_leave);
}
