/*
 * Measures sliding on the CPU, on one thread: nanoseconds of its processor for each post and iteration, over a window after a contact and over
 * a block in an interval. All work counts: laid soil, heights, iterations, lines, flags. Prints a JSON line for each.
 *
 *     bench_sliding [RUNS] [--figures FILE]      default 200 runs
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"
#include "record.h"
#include "soil/soil.h"
#include "soil/stability.h"

enum { SIDE = 128, RIM = 32, ACROSS = SIDE + 2 * RIM, COUNT = ACROSS * ACROSS, WORDS = 64, MOST_RUNS = 10000 };
#define SPACING 0.04 /* m */

static int32_t base[COUNT], offset[COUNT], deposited[COUNT], deposits[COUNT], slid_offset[COUNT], slid_deposited[COUNT], slope[COUNT];
static uint8_t contact[COUNT], classes[COUNT];

/* What a ground has. */
enum ground { AT_REST, HEAP, RUT, EVERYWHERE };

struct kind {
	const char *name;
	enum ground ground;
	int iterations, directions;
	bool scm, stood, classes;
	int block;       /* blocks along a side of a region; 0: a window */
	double cohesion; /* share of the soil's */
};

static const struct kind kinds[] = {
	{"at_rest", AT_REST, .iterations = 1},
	{"at_rest.lines", AT_REST, .iterations = 1, .directions = 4},
	{"at_rest.8_iterations", AT_REST, .iterations = 8},
	{"heap", HEAP, .iterations = 1},
	{"heap.lines", HEAP, .iterations = 1, .directions = 4},
	{"heap.8_iterations", HEAP, .iterations = 8},
	{"rut", RUT, .iterations = 1},
	{"rut.lines", RUT, .iterations = 1, .directions = 4},
	{"rut.scm.lines", RUT, .iterations = 1, .directions = 2, .scm = true},
	{"moves", EVERYWHERE, .iterations = 1},
	{"moves.4_iterations", EVERYWHERE, .iterations = 4},
	{"moves.8_iterations", EVERYWHERE, .iterations = 8},
	{"moves.lines", EVERYWHERE, .iterations = 1, .directions = 4},
	{"moves.stood", EVERYWHERE, .iterations = 4, .stood = true},
	{"moves.classes", EVERYWHERE, .iterations = 4, .classes = true},
	{"moves.scm", EVERYWHERE, .iterations = 4, .scm = true},
	{"moves.scm.lines", EVERYWHERE, .iterations = 1, .directions = 2, .scm = true},
	{"rut.cohesive.lines", RUT, .iterations = 1, .directions = 4, .cohesion = 0.01},
	{"blocks.rut.cohesive", RUT, .iterations = 1, .block = 4, .cohesion = 0.01},
	{"blocks.at_rest.cohesive", AT_REST, .iterations = 1, .block = 4, .cohesion = 0.01},
	{"block.at_rest", AT_REST, .iterations = 1, .block = 1},
	{"block.moves", EVERYWHERE, .iterations = 1, .block = 1},
	{"blocks.moves", EVERYWHERE, .iterations = 4, .block = 4},
};

static double share(void)
{
	static uint32_t seed = 1;
	seed = seed * 1664525u + 1013904223u;
	return (double)(seed >> 8) / (1 << 23) - 1;
}

static void make(enum ground ground)
{
	for (int i = 0; i < COUNT; i++) {
		const double x = i % ACROSS - ACROSS / 2, y = i / ACROSS - ACROSS / 2, away = hypot(x, y);
		double height = 0.002 * share();
		if (ground == HEAP)
			height += fmax(0, 0.4 - 0.05 * away); /* over 8 posts */
		if (ground == RUT && fabs(y) < 8)
			height += fabs(y) < 4 ? -0.1 : 0.06;
		if (ground == EVERYWHERE)
			height = 0.5 * share();
		base[i] = (40 << 18) + (int32_t)(1000 * share());
		offset[i] = deposited[i] = (int32_t)ldexp(height, OFFSET_BITS);
		deposits[i] = i % 16 == 0 ? 500 : 0;
		classes[i] = (uint8_t)(i / 24 % 3);
	}
}

static int32_t critical(const struct soil_numbers *soil, double apart)
{
	return soil_critical_difference_cohesive(soil, apart);
}

static void prepare(const struct kind *kind, struct soil_sliding *rule)
{
	static const char *const names[] = {"dry_sand", "lete_sand", "sandy_loam_22"};
	struct soil_numbers soils[3];
	for (int i = 0; i < 3; i++) {
		bench_must(soil_named(names[i], &soils[i]));
		soils[i].cohesion *= kind->cohesion;
	}
	soil_sliding_prepare(&(struct soil_sliding_params){
		.soils = soils,
		.soil_count = kind->classes ? 3 : 1,
		.spacing = SPACING,
		.critical = critical,
		.cotangent = kind->cohesion > 0 ? soil_critical_cotangent : NULL,
		.iterations = kind->iterations,
		.directions = kind->directions,
		.depth = kind->scm ? 0 : (double)INFINITY,
		.relief = INFINITY,
		.undisturbed_stable = kind->stood,
	}, rule);
}

static double processor_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void measure(const struct kind *kind, int runs)
{
	static double ns[MOST_RUNS];
	static uint32_t words[WORDS];
	struct soil_sliding rule;
	struct soil_slid slid = {.compacted = 0};
	prepare(kind, &rule);
	make(kind->ground);
	/* A block begins at post 64, where the window begins. Planes that are too wide do no harm. */
	const int64_t first = 64, side = kind->block > 0 ? SOIL_BLOCK * kind->block : SIDE;
	const struct soil_planes planes = {
		.rect = {first - RIM, first - RIM, first - RIM + ACROSS, first - RIM + ACROSS},
		.width = ACROSS, .base = base, .offset = slid_offset, .deposited = kind->scm ? slid_deposited : NULL,
		.classes = kind->classes ? classes : NULL, .contact = contact, .slope = slope,
	};
	const struct soil_slide_window window = {
		.written = {first, first, first + side, first + side}, .posts = {first, first, first + side, first + side},
		.world = {0, 0, 1000, 1000}, .deposits = deposits,
	};
	void *scratch = malloc(soil_sliding_scratch(&rule, &planes));
	if (scratch == NULL)
		exit(1);
	for (int run = 0; run < runs; run++) {
		memcpy(slid_offset, offset, sizeof offset);
		memcpy(slid_deposited, deposited, sizeof deposited);
		const double began = processor_seconds();
		if (kind->block > 0)
			soil_slide_region(&rule, &planes, (struct post_rect){2, 2, 2 + kind->block, 2 + kind->block}, scratch, words);
		else
			soil_slide_window(&rule, &planes, &window, scratch, words, &slid);
		ns[run] = 1e9 * (processor_seconds() - began) / ((double)(side * side) * kind->iterations);
	}
	free(scratch);
	size_t moved = 0;
	for (int i = 0; i < COUNT; i++)
		moved += slid_offset[i] != offset[i];
	char key[64];
	snprintf(key, sizeof key, "window.%s", kind->name);
	bench_record_add(key, "ns", ns, (size_t)runs); /* sorts them */
	printf("{\"sliding\": \"%s\", \"posts\": %lld, \"iterations\": %d, \"directions\": %d, \"changed\": %zu, \"ns\": %.3f, \"least_ns\": %.3f}\n", kind->name,
	       (long long)(side * side), kind->iterations, kind->directions, moved, ns[runs / 2], ns[0]);
}

int main(int count, char **words)
{
	bench_record_begin("sliding", &count, words);
	long runs = count > 1 ? strtol(words[1], NULL, 10) : 200;
	if (runs < 1 || runs > MOST_RUNS) {
		fprintf(stderr, "bench_sliding: RUNS is 1 to %d\n", MOST_RUNS);
		return 2;
	}
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
		measure(&kinds[i], (int)runs);
	bench_record_end(NULL);
	return 0;
}
