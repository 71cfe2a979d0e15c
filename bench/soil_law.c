/*
 * Measures the law of bearing soil on the CPU, on one thread: microseconds of its processor for a contact with its load, and for a probe. A wheel of
 * 1 kN rolls at a slip of 0.2 over dry_sand. Prints a JSON line for each heading and spacing.
 *
 *     bench_soil_law [ROUNDS] [--figures FILE]      default 400 rounds of 10 probes
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bench.h"
#include "record.h"
#include "soil/sink.h"
#include "soil/probe.h"

enum { SIDE = 512, MOST = 10000, EACH = 10 };
#define RADIUS 0.25 /* m */
#define SLIP 0.2
#define LOAD 1000.0 /* N */

static double processor_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void *zeros(size_t bytes)
{
	void *memory = calloc(SIDE * SIDE, bytes);
	if (memory == NULL)
		exit(1);
	return memory;
}

static void measure(double spacing, double heading, int rounds)
{
	static double us[MOST];
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = RADIUS, .width = 0.2};
	struct soil_law law = {.spacing = spacing, .soil_count = 1, .bulldozing = 0.5};
	struct soil_planes planes = {.rect = {0, 0, SIDE, SIDE}, .width = SIDE, .base = zeros(4), .offset = zeros(4), .deposited = zeros(4), .sinkage = zeros(4),
				     .shear = zeros(4), .contact = zeros(1)};
	struct soil_laid laid[SOIL_CLASSES] = {soil_laid_of(0.5, 0.5, spacing)};
	struct soil_work *work;
	struct soil_imprint pressed = {.raised = -(int32_t)lattice_offset(0.03)};
	struct soil_probed probed = {.known = false};
	char key[64];
	bench_must(soil_named("dry_sand", &law.soils[0]));
	bench_must(soil_work_create(&work));
	const double x = 1.2 + 0.37 * spacing, y = 1.2 + 0.2 * spacing, turned = spacing / RADIUS / (1 - SLIP);
	struct soil_pose last = {lattice_offset(x), lattice_offset(y), lattice_offset(RADIUS), heading, 0, 0, 0};
	const int steps = (int)(2 / spacing);
	int tries = 0;
	for (int i = 0; i < steps; i++) {
		struct soil_pose to = last;
		to.x = lattice_offset(x + i * spacing * cos(heading));
		to.y = lattice_offset(y + i * spacing * sin(heading));
		const struct soil_motion motion = {.shape = &wheel, .from = last, .to = to, .turned = i > 0 ? turned : 0, .load = LOAD, .jumped = i == 0};
		const struct soil_laying laying = soil_laying_of(&wheel, &motion.from, &motion.to, motion.turned, NULL, spacing);
		const struct soil_sink press = {.laying = &laying, .soils = laid, .start = pressed.raised};
		const double began = processor_seconds();
		bench_must(soil_sink_body(&law, &planes, &motion, &press, work, &pressed));
		us[i] = (processor_seconds() - began) * 1e6;
		tries += pressed.tries;
		last = to;
	}
	snprintf(key, sizeof key, "contact.%g.%g", heading, spacing);
	bench_record_add(key, "us", us, (size_t)steps); /* sorts them */
	const double contact = us[steps / 2];
	/* It rolls on by half a post. */
	last.z += pressed.raised;
	struct soil_pose to = last;
	to.x += lattice_offset(0.5 * spacing * cos(heading));
	to.y += lattice_offset(0.5 * spacing * sin(heading));
	const struct soil_motion motion = {.shape = &wheel, .from = last, .to = to, .turned = 0.5 * turned, .hosted = true, .linear = {cos(heading), sin(heading), 0},
					   .angular = {-sin(heading) / RADIUS / (1 - SLIP), cos(heading) / RADIUS / (1 - SLIP), 0}};
	for (int i = 0; i < rounds; i++) {
		const double began = processor_seconds();
		for (int k = 0; k < EACH; k++)
			bench_must(soil_probe(&law, &planes, &motion, work, &probed));
		us[i] = (processor_seconds() - began) * 1e6 / EACH;
	}
	snprintf(key, sizeof key, "probe.%g.%g", heading, spacing);
	bench_record_add(key, "us", us, (size_t)rounds);
	printf("{\"soil_law\": \"wheel\", \"heading\": %g, \"spacing\": %g, \"contact_us\": %.2f, \"tries\": %.2f, \"probe_us\": %.2f, \"probe_least_us\": %.2f, "
	       "\"force_z\": %.1f, \"area\": %.4f}\n",
	       heading, spacing, contact, (double)tries / steps, us[rounds / 2], us[0], probed.force[2], probed.area);
	soil_work_destroy(work);
	free(planes.base);
	free(planes.offset);
	free(planes.deposited);
	free(planes.sinkage);
	free(planes.shear);
	free(planes.contact);
}

int main(int count, char **words)
{
	static const double spacings[] = {0.125, 0.04, 0.02, 0.01};
	bench_record_begin("soil_law", &count, words);
	const int rounds = count > 1 ? atoi(words[1]) : 400;
	if (rounds < 1 || rounds > MOST) {
		fprintf(stderr, "bench_soil_law: ROUNDS is 1 to %d\n", MOST);
		return 2;
	}
	for (int h = 0; h < 2; h++)
		for (int k = 0; k < 4; k++)
			measure(spacings[k], 0.7 * h, rounds);
	bench_record_end(NULL);
	return 0;
}
