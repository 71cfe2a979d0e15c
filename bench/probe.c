/*
 * Measures furrow_probe: microseconds for one state of a body that carries 1 kN on dry_sand, at rest and rolling, and a step that commits
 * with the ground read for the next probes. Prints a JSON line for each.
 *
 *     bench_probe [PROBES] [--figures FILE]      default 20000 probes
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/library.h"
#include "bench.h"
#include "record.h"

enum { CELLS = 256 };
#define SPACING 0.02 /* m, of the working level, which is that of the store */
#define LOAD 1000.0  /* N */

static const char scene[] =
	"{\"scene\": 1, \"time_step\": 0.002, \"soil\": {\"name\": \"dry_sand\"}, \"redistribute\": {\"model\": \"scm\"}, \"cache\": {\"slots\": 32}}";

static void must(furrow_status status)
{
	if (status == FURROW_OK)
		return;
	fprintf(stderr, "bench_probe: %s\n", furrow_last_error());
	exit(1);
}

static double force_at(struct furrow_world *world, furrow_body body, const struct furrow_state *state, struct furrow_contact *contact)
{
	must(furrow_probe(world, 1, &body, state, contact, sizeof *contact));
	return contact->force[2];
}

static int compare(const void *a, const void *b)
{
	const double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* Probes a state in groups of ten, and prints the median of a probe and the best. */
static void measure(struct furrow_world *world, furrow_body body, const struct furrow_state *state, const char *name, const char *how, int probes)
{
	const int groups = probes / 10 > 0 ? probes / 10 : 1;
	double *us = calloc((size_t)groups, sizeof *us);
	struct furrow_contact contact = {.time = 0};
	if (us == NULL)
		exit(1);
	for (int i = 0; i < groups; i++) {
		const double began = clock_seconds();
		for (int k = 0; k < 10; k++)
			force_at(world, body, state, &contact);
		us[i] = (clock_seconds() - began) * 1e5;
	}
	qsort(us, (size_t)groups, sizeof *us, compare);
	char key[64];
	snprintf(key, sizeof key, "%s.%s", name, how);
	bench_record_add(key, "us", us, (size_t)groups);
	printf("{\"bench\": \"probe\", \"body\": \"%s\", \"motion\": \"%s\", \"us\": %.2f, \"best_us\": %.2f, \"force_z\": %.1f, \"posts\": %.0f}\n", name,
	       how, us[groups / 2], us[0], contact.force[2], contact.area / (SPACING * SPACING));
	free(us);
}

static void of_body(struct furrow_world *world, const char *name, const char *shape, double reach, double x, int probes)
{
	const double xy[2] = {x, 2.5};
	struct furrow_point ground;
	struct furrow_contact contact;
	furrow_body body;
	char object[160];
	snprintf(object, sizeof object, "{name: %s, shape: %s}", name, shape);
	must(furrow_body_add(world, object, &body));
	must(furrow_points(world, 1, xy, &ground));
	struct furrow_state state = {.pose = {{x, 2.5, ground.height + reach}, {1, 0, 0, 0}}};
	must(furrow_place(world, body, &state.pose));
	while (force_at(world, body, &state, &contact) < LOAD)
		state.pose.position[2] -= 1e-4;
	must(furrow_set_states(world, 1, &body, &state));
	must(furrow_step(world, 0));
	measure(world, body, &state, name, "rests", probes);
	/* It rolls on, half a post each step. */
	double ms = 0;
	int steps = 0;
	for (; steps < 100; steps++) {
		state.linear[0] = 5;
		state.angular[1] = reach > 0.2 ? 6 / reach : 0;
		state.pose.position[0] += 0.01;
		while (force_at(world, body, &state, &contact) < LOAD)
			state.pose.position[2] -= 1e-4;
		must(furrow_set_states(world, 1, &body, &state));
		const double began = clock_seconds();
		must(furrow_step(world, 0));
		must(furrow_get_contacts(world, 1, &body, &contact, sizeof contact));
		ms += (clock_seconds() - began) * 1e3;
	}
	state.pose.position[0] += 0.006;
	measure(world, body, &state, name, "moves", probes);
	printf("{\"bench\": \"probe\", \"body\": \"%s\", \"step_ms\": %.3f, \"way_a_step\": 0.01, \"gl\": \"%s\"}\n", name, ms / steps,
	       gpu_info(world_resident(world->world)->gpu)->renderer);
	must(furrow_body_remove(world, body));
}

int main(int argc, char **argv)
{
	bench_record_begin("probe", &argc, argv);
	const int probes = argc > 1 ? atoi(argv[1]) : 20000;
	const struct dem_synth synth = {.kind = DEM_SYNTH_PLAIN, .width = 2 * CELLS + 1, .height = CELLS + 1, .spacing = SPACING, .relief = 0.01, .seed = 1};
	const char *store = bench_path("probe.furrow");
	struct furrow_world *world;
	if (probes < 1)
		return 2;
	bench_store(store, &synth, CELLS);
	const struct furrow_open open = {.size = sizeof open, .scene = scene, .store = store};
	must(furrow_world_open(&open, &world));
	of_body(world, "wheel", "{wheel: {radius: 0.25, width: 0.2}}", 0.25, 1, probes);
	of_body(world, "sphere", "{sphere: {radius: 0.25}}", 0.25, 4, probes);
	of_body(world, "box", "{box: {size: [0.3, 0.2, 0.2]}}", 0.1, 7, probes);
	bench_record_end(gpu_info(world_resident(world->world)->gpu)->renderer);
	must(furrow_world_close(world));
	return 0;
}
