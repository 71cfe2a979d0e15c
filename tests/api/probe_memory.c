/* furrow_probe and memory: it writes to the host's own array, allocates nothing, and takes the shorter contacts of hosts that were built earlier. */
#include <stddef.h>

#include "../support/program.h"
#include "base/base.h"
#include "probing.h"

#define BODIES 24 /* so many that the bodies beside each other are found by a grid */
#define CALLS 40

static const struct probing_ground ground = {"probe_memory.furrow", "dry_sand", 0.0625, 0, 100, 0, 0, false};
static const char belt[] = "{shape: {box: {size: [0.4, 0.2, 0.2], belt: true}}}";

static double reach_of(int i)
{
	return i % 4 < 2 ? 0.25 : 0.1;
}

/* Bodies in rows, so close that soil is laid between them. `way`: m that each has gone on, and sunk by a tenth of it. */
static struct furrow_state state_at(int i, double way)
{
	return (struct furrow_state){
		.pose = {{20 + 0.6 * (i % 6) + way, 20 + 0.6 * (i / 6), 100 + reach_of(i) - 0.005 - 0.1 * way}, {1, 0, 0, 0}},
		.linear = {0.1, 0, -0.01},
	};
}

static struct furrow_world *world_of_bodies(furrow_body bodies[BODIES])
{
	const char *const shapes[] = {probing_wheel, probing_ball, probing_box, belt};
	struct furrow_world *world = probing_world(&ground);
	for (int i = 0; i < BODIES; i++) {
		const struct furrow_state at = state_at(i, 0);
		done(furrow_body_add(world, shapes[i % 4], &bodies[i]));
		done(furrow_place(world, bodies[i], &at.pose));
	}
	for (int step = 1; step <= 3; step++)
		for (int i = 0; i < BODIES; i++) {
			const struct furrow_state at = state_at(i, 0.02 * step);
			done(furrow_set_states(world, 1, &bodies[i], &at));
			if (i == BODIES - 1)
				done(furrow_step(world, 0));
		}
	return world;
}

static void states_at(double way, struct furrow_state states[BODIES])
{
	for (int i = 0; i < BODIES; i++)
		states[i] = state_at(i, way);
}

static void a_probe_allocates_nothing(void **state)
{
	furrow_body bodies[BODIES];
	struct furrow_world *world = world_of_bodies(bodies);
	struct furrow_state states[BODIES];
	struct furrow_contact contacts[BODIES];
	states_at(0.07, states);
	done(furrow_probe(world, BODIES, bodies, states, contacts, sizeof *contacts)); /* makes the room that later ones use */
	for (size_t i = 0; i < BODIES; i++)
		done(furrow_probe(world, 1, &bodies[i], &states[i], &contacts[i], sizeof *contacts));
	mem_fail_nth(1, true); /* from now on every allocation fails, and is counted */
	furrow_status status = FURROW_OK;
	for (int k = 0; k < CALLS && status == FURROW_OK; k++) {
		states_at(0.06 + 0.0005 * k, states);
		status = furrow_probe(world, BODIES, bodies, states, contacts, sizeof *contacts);
		for (size_t i = 0; i < BODIES && status == FURROW_OK; i++)
			status = furrow_probe(world, 1, &bodies[i], &states[i], &contacts[i], sizeof *contacts);
	}
	const uint64_t made = mem_fail_nth(0, false);
	assert_int_equal(status, FURROW_OK);
	assert_int_equal(made, 0);
	for (size_t i = 0; i < BODIES; i++) { /* they were probes that read the ground */
		assert_int_not_equal(contacts[i].state, FURROW_UNKNOWN);
		assert_true(contacts[i].force[2] > 0);
		assert_int_equal(isnan(contacts[i].pull), i % 4 != 3);
	}
	done(furrow_world_close(world));
}

static void shorter_contacts_have_the_same_numbers(void **state)
{
	enum { OLD = offsetof(struct furrow_contact, pull) };
	furrow_body bodies[BODIES];
	struct furrow_world *world = world_of_bodies(bodies);
	struct furrow_state states[BODIES];
	static struct furrow_contact contacts[BODIES];
	static unsigned char old[BODIES * OLD + 1];
	states_at(0.07, states);
	done(furrow_probe(world, BODIES, bodies, states, contacts, sizeof *contacts));
	memset(old, 0x5a, sizeof old);
	done(furrow_probe(world, BODIES, bodies, states, (struct furrow_contact *)(void *)old, OLD));
	for (size_t i = 0; i < BODIES; i++)
		assert_memory_equal(old + i * OLD, &contacts[i], offsetof(struct furrow_contact, state) + sizeof contacts[i].state);
	assert_int_equal(old[BODIES * OLD], 0x5a);
	done(furrow_get_contacts(world, BODIES, bodies, contacts, sizeof *contacts));
	done(furrow_get_contacts(world, BODIES, bodies, (struct furrow_contact *)(void *)old, OLD));
	for (size_t i = 0; i < BODIES; i++)
		assert_memory_equal(old + i * OLD, &contacts[i], offsetof(struct furrow_contact, state) + sizeof contacts[i].state);
	assert_int_equal(old[BODIES * OLD], 0x5a);
	misused(furrow_probe(world, 1, bodies, states, contacts, OLD - 8));
	misused(furrow_probe(world, 1, bodies, states, contacts, sizeof *contacts + 8));
	done(furrow_world_close(world));
}

static void a_wrong_state_leaves_all_contacts_as_they_were(void **state)
{
	furrow_body bodies[BODIES];
	struct furrow_world *world = world_of_bodies(bodies);
	struct furrow_state states[BODIES];
	static struct furrow_contact contacts[BODIES], before[BODIES];
	states_at(0.07, states);
	states[BODIES - 1].linear[0] = INFINITY;
	memset(contacts, 0x5a, sizeof contacts);
	memcpy(before, contacts, sizeof before);
	misused(furrow_probe(world, BODIES, bodies, states, contacts, sizeof *contacts));
	assert_memory_equal(contacts, before, sizeof before);
	done(furrow_world_close(world));
}

TEST_PROGRAM(probe_memory)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_probe_allocates_nothing),
		cmocka_unit_test(shorter_contacts_have_the_same_numbers),
		cmocka_unit_test(a_wrong_state_leaves_all_contacts_as_they_were),
	};
	return cmocka_run_group_tests_name("api/probe_memory", tests, support_enter, support_leave);
}
