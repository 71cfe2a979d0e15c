/*
 * Contacts of soil that bears (src/bearing). A wheel of radius 0.5 m and width 0.4 m with 5 kN rolls straight over level ground at slip 0.2: Project
 * Chrono's soft soil, rim on, one relaxation iteration a path sample, path samples one post apart. Every tile is resident. Wall clock of a path sample:
 * search of the equilibrium height, contact, laying, sliding, and the tiles put back; medians of RUNS runs. "wheels": one wheel, or four, the rear ones in
 * the ruts of the front ones.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bearing/bearing.h"
#include "bench.h"
#include "record.h"
#include "resident/host_slots.h"

enum { RUNS = 5, SIDE = 5, CELLS = 256, MOST = 4 };
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};

struct ground {
	double spacing;
	int wheels, steps;
	struct extent extent;
	struct host_slots *host;
	struct bearing *bearing;
	double sinkage; /* m, of the last sample of wheel 0 */
};

static struct deform_params params_of(const struct ground *ground)
{
	struct deform_params params = {
		.extent = &ground->extent, .model = DEFORM_SCM, .box_radius = 1, .box_repetitions = 1, .soil_count = 1, .iterations = 1, .depth = INFINITY,
		.bulldozing = 0.5, .slip_sinkage = 0, .along_lines = true, .undisturbed_stable = true, .loaded_bodies = MOST,
	};
	soil_clear(&params.soils[0]);
	params.soils[0].bekker_kc = params.soils[0].cohesion = 0;
	params.soils[0].bekker_kphi = 0.2e6;
	params.soils[0].bekker_n = 1.1;
	params.soils[0].friction_angle = params.soils[0].repose = 30 * M_PI / 180;
	params.soils[0].janosi_shear = 0.01;
	params.soils[0].elastic_stiffness = 4e7;
	params.soils[0].damping = 3e4;
	params.soils[0].unit_weight = 16e3;
	return params;
}

static size_t tiles_of(const struct ground *ground, struct post_rect rect, struct tile_slot tiles[SIDE * SIDE])
{
	size_t count = 0;
	struct tile first, last;
	if (!tile_range_of(&ground->extent, 0, rect, &first, &last))
		bench_must(fail_with(STATUS_FAILED, "bench: the path leaves the terrain; mend it"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			tiles[count++] = (struct tile_slot){{0, x, y}, y * SIDE + x};
	return count;
}

static void open_ground(struct ground *ground)
{
	const size_t posts = (size_t)(CELLS + 1) * (CELLS + 1);
	ground->extent = (struct extent){SIDE * CELLS + 1, SIDE * CELLS + 1, ground->spacing, CELLS};
	struct deform_params params = params_of(ground);
	const unsigned planes = deform_planes(DEFORM_SCM, false, false);
	bench_must(resident_host_create(CELLS, SIDE * SIDE, planes, &ground->host));
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		int32_t *base;
		bench_must(resident_host_tile_base(ground->host, &host_entry(ground->host, i)->tile, &base));
		memset(base, 0, posts * sizeof *base);
		bench_must(resident_host_write(ground->host, i, planes));
	}
	bench_must(bearing_create(&params, ground->host, &ground->bearing));
}

static void close_ground(struct ground *ground)
{
	bearing_destroy(ground->bearing);
	resident_host_destroy(ground->host);
}

static struct deform_contact contact_of(const struct ground *ground, int step, int number)
{
	/* Two axles 3 m apart, a track of 1.6 m. */
	const double x = (CELLS - 40) * ground->spacing + (number < 2 ? 3 : 0), y = CELLS * ground->spacing + 1.6 * (number % 2), d = ground->spacing;
	struct deform_contact contact = {
		.shape = &wheel, .load = 5000, .loaded_body = (uint32_t)number + 1, .turned = step > 0 ? d / (wheel.radius * 0.8) : 0,
		.to = {.x = lattice_offset(x + d * step), .y = lattice_offset(y), .z = lattice_offset(0.5)},
	};
	contact.from = contact.to;
	if (step > 0)
		contact.from.x = lattice_offset(x + d * (step - 1));
	return contact;
}

static double run(struct ground *ground)
{
	struct tile_slot tiles[SIDE * SIDE];
	struct bearing_area area;
	struct bearing_contact done = {.forces = {.sinkage = 0}};
	const double began = clock_seconds();
	for (int step = 0; step < ground->steps; step++)
		for (int number = 0; number < ground->wheels; number++) {
			const struct deform_contact contact = contact_of(ground, step, number);
			bench_must(bearing_area(ground->bearing, &contact, &area));
			done = (struct bearing_contact){.contact = &contact, .area = area};
			const size_t count = tiles_of(ground, area.read, tiles);
			bench_must(bearing_contact_alone(ground->bearing, &done, tiles, count));
		}
	ground->sinkage = done.forces.sinkage;
	return clock_seconds() - began;
}

static void measure(double spacing, int wheels)
{
	double us[RUNS], sunk = 0;
	for (int i = 0; i < RUNS; i++) {
		struct ground ground = {.spacing = spacing, .wheels = wheels, .steps = spacing < 0.03 ? 150 : 200};
		open_ground(&ground);
		us[i] = run(&ground) / (ground.steps * wheels) * 1e6;
		sunk = ground.sinkage;
		close_ground(&ground);
	}
	const double sample = bench_median(us, RUNS);
	char key[64];
	double a_metre[RUNS];
	for (int i = 0; i < RUNS; i++)
		a_metre[i] = us[i] * wheels / spacing * 1e-3;
	snprintf(key, sizeof key, "wheels%d.posts_%gcm.ms_a_metre", wheels, spacing * 100);
	bench_record_add(key, "ms", a_metre, RUNS);
	printf("{\"bench\": \"bearing\", \"posts_m\": %g, \"wheels\": %d, \"us\": %.1f, \"ms_a_metre\": %.2f, \"sinkage_mm\": %.2f}\n", spacing, wheels, sample,
	       sample * wheels / spacing * 1e-3, sunk * 1e3);
	fflush(stdout);
}

int main(int argc, char **argv)
{
	static const double spacings[] = {0.25, 0.125, 0.04, 0.02, 0.01};
	bench_record_begin("bearing", &argc, argv);
	for (size_t s = 0; s < sizeof spacings / sizeof *spacings; s++)
		for (int wheels = 1; wheels <= MOST; wheels *= 4)
			measure(spacings[s], wheels);
	bench_record_end(NULL);
	return 0;
}
