/*
 * What bounds bearing soil on the CPU, on one thread: the time of the law's evaluation, of a probe, of laying and of sliding for each post, beside what the
 * machine can do at most: multiplications and additions that stay in registers, and bytes read from a cache. A wheel of radius 0.5 m and width 0.4 m over level
 * ground, posts 2 cm apart. Prints a JSON line for the machine, and one for each part.
 *
 *     bench_roofline [ROUNDS] [--figures FILE]      default 200 rounds
 *
 * Operations and instructions a post were counted once in the machine code for 512-bit vectors, by stepping through one call (README.md). Here they are
 * constants, and so are bytes: of the arrays that a part reads and writes, each once.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"
#include "record.h"
#include "soil/contact.h"
#include "soil/lanes.h"
#include "soil/laying/laying.h"
#include "soil/probe.h"
#include "soil/sink.h"
#include "soil/stability.h"

enum { SIDE = 192, COUNT = SIDE * SIDE, MOST_ROUNDS = 10000, CALLS = 10 };
#define SPACING 0.02 /* m */

static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
static int32_t base[COUNT], offset[COUNT], deposited[COUNT], sinkage[COUNT], shear[COUNT], deposits[COUNT];
static uint8_t contact[COUNT];
static double ns[MOST_ROUNDS];
static int rounds = 200;

static double processor_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* --- the machine --- */

typedef float vector __attribute__((vector_size(64)));
typedef int32_t whole_vector __attribute__((vector_size(64)));
enum { CHAINS = 12, TURNS = 200000, LANES = 16 };

/* Multiplies and adds in as many chains as keep the units busy. */
SOIL_CLONED static float multiply_and_add(float by, float more)
{
	vector chains[CHAINS], factor, term, sum;
	for (int i = 0; i < LANES; i++) {
		factor[i] = by;
		term[i] = more;
	}
	for (int c = 0; c < CHAINS; c++)
		chains[c] = term * (float)c;
	for (int turn = 0; turn < TURNS; turn++)
		for (int c = 0; c < CHAINS; c++)
			chains[c] = chains[c] * factor + term;
	sum = chains[0];
	for (int c = 1; c < CHAINS; c++)
		sum += chains[c];
	return sum[0] + sum[LANES - 1];
}

SOIL_CLONED static int32_t read_all(const int32_t *memory, size_t count)
{
	whole_vector sums[4];
	memset(sums, 0, sizeof sums);
	for (size_t i = 0; i + 4 * LANES <= count; i += 4 * LANES)
		for (size_t k = 0; k < 4; k++) {
			whole_vector next;
			memcpy(&next, memory + i + k * LANES, sizeof next);
			sums[k] += next;
		}
	sums[0] += sums[1] + sums[2] + sums[3];
	return sums[0][0] + sums[0][LANES - 1];
}

static volatile float kept_real;
static volatile int32_t kept_whole;

/* Returns 1e9 operations a second: the median. */
static double peak_operations(void)
{
	for (int i = 0; i < rounds; i++) {
		const double began = processor_seconds();
		kept_real = multiply_and_add(0.5f, 1 + (float)i);
		ns[i] = 2.0 * CHAINS * TURNS * LANES / (processor_seconds() - began) * 1e-9;
	}
	return bench_median(ns, (size_t)rounds);
}

/* Returns 1e9 bytes a second, read from a buffer that was read before: the median. */
static double peak_bytes(size_t bytes)
{
	const size_t count = bytes / sizeof(int32_t), times = ((size_t)1 << 24) / bytes + 1;
	int32_t *memory = malloc(bytes);
	if (memory == NULL)
		exit(1);
	memset(memory, 1, bytes);
	for (int i = 0; i < rounds; i++) {
		const double began = processor_seconds();
		for (size_t k = 0; k < times; k++)
			kept_whole = read_all(memory, count);
		ns[i] = (double)(bytes * times) / (processor_seconds() - began) * 1e-9;
	}
	free(memory);
	return bench_median(ns, (size_t)rounds);
}

/* --- the parts --- */

struct part {
	const char *name;
	double operations, instructions, bytes; /* a post; operations: of real numbers, or of whole ones where the part has no others */
};

#define EACH(name) +4.0
#define LAW_BYTES (0 POSTS_LAW_WHOLES_EACH(EACH) POSTS_LAW_REALS_EACH(EACH))
static const struct part law_part = {"law", 1695, 271, LAW_BYTES}, probe_part = {"probe", 2553, 371, LAW_BYTES}, laying_part = {"laying", 27, 49, 13},
			 sliding_part = {"sliding", 152, 33, 25};
#undef EACH

struct machine {
	double operations, first, second; /* 1e9 a second: operations; bytes of the first and of the second cache */
};

static void add(const char *part, const char *key, const char *unit, double value)
{
	char name[64];
	snprintf(name, sizeof name, "%s.%s", part, key);
	bench_record_add(name, unit, &value, 1);
}

/* Tells a part by the times of its rounds, in `ns`. */
static void tell(const struct machine *machine, const struct part *part, size_t posts)
{
	char name[64];
	snprintf(name, sizeof name, "%s.ns", part->name);
	bench_record_add(name, "ns", ns, (size_t)rounds); /* sorts them */
	const double each = ns[rounds / 2], computed = part->operations / each / machine->operations, read = part->bytes / each / machine->second;
	add(part->name, "operations", "", part->operations);
	add(part->name, "instructions", "", part->instructions);
	add(part->name, "bytes", "", part->bytes);
	add(part->name, "of_operations", "%", 100 * computed);
	add(part->name, "of_bytes", "%", 100 * read);
	printf("{\"roofline\": \"%s\", \"posts\": %zu, \"ns\": %.2f, \"operations\": %.0f, \"instructions\": %.0f, \"bytes\": %.0f, \"share_of_operations\": %.3f, "
	       "\"share_of_bytes\": %.3f}\n", part->name, posts, each, part->operations, part->instructions, part->bytes, computed, read);
}

static struct soil_planes planes_of(void)
{
	return (struct soil_planes){.rect = {0, 0, SIDE, SIDE}, .width = SIDE, .base = base, .offset = offset, .deposited = deposited, .sinkage = sinkage,
				    .shear = shear, .contact = contact};
}

static struct soil_law law_of(void)
{
	struct soil_law law = {.spacing = SPACING, .soil_count = 1, .bulldozing = 0.5};
	bench_must(soil_named("dry_sand", &law.soils[0]));
	return law;
}

/* Evaluates the law for a wheel that rolls on in its rut. */
static void of_law(const struct machine *machine)
{
	const struct soil_law law = law_of();
	const struct soil_planes planes = planes_of();
	const struct soil_laid laid[SOIL_CLASSES] = {soil_laid_of(0.5, 0.5, SPACING)};
	struct soil_work *work;
	struct soil_imprint imprint = {.raised = -(int32_t)lattice_offset(0.03)};
	struct soil_sums sums;
	struct soil_changes changes;
	bench_must(soil_work_create(&work));
	struct soil_pose last = {lattice_offset(1.003), lattice_offset(1.9), lattice_offset(wheel.radius), 0, 0, 0, 0};
	struct soil_motion motion = {.shape = &wheel};
	for (int i = 0; i < 20; i++) {
		motion = (struct soil_motion){.shape = &wheel, .from = last, .to = last, .load = 5000, .jumped = i == 0, .turned = i > 0 ? 1.25 * SPACING / wheel.radius : 0};
		motion.to.x += i > 0 ? lattice_offset(SPACING) : 0;
		const struct soil_laying laying = soil_laying_of(&wheel, &motion.from, &motion.to, motion.turned, NULL, SPACING);
		const struct soil_sink sink = {.laying = &laying, .soils = laid, .start = imprint.raised};
		bench_must(soil_sink_body(&law, &planes, &motion, &sink, work, &imprint));
		last = motion.to;
		last.z += imprint.raised;
		imprint.raised = 0;
	}
	motion.from = motion.to = last;
	motion.to.x += lattice_offset(SPACING);
	bench_must(soil_contact_begin(&law, &planes, &motion, work, 0, &work->contact));
	soil_contact_gather(&work->contact, 0);
	const size_t posts = work->posts.count;
	for (int asks = 0; asks < 2; asks++) {
		for (int i = 0; i < rounds; i++) {
			const double began = processor_seconds();
			for (int k = 0; k < CALLS; k++)
				soil_contact_evaluate(&work->contact, 0, 1, &sums, NULL, asks > 0 ? &changes : NULL);
			ns[i] = (processor_seconds() - began) * 1e9 / (double)posts / CALLS;
		}
		tell(machine, asks > 0 ? &probe_part : &law_part, posts);
	}
	soil_work_destroy(work);
}

/* Lays what a wheel displaced. A post is one that the wheel touched. */
static void of_laying(const struct machine *machine)
{
	const struct soil_pose from = {.x = lattice_offset(1.9), .y = lattice_offset(1.9)};
	const struct soil_laid soils[SOIL_CLASSES] = {soil_laid_of(0.5, 0.5, SPACING)};
	const struct soil_planes planes = planes_of();
	struct soil_pose to = from;
	to.x += lattice_offset(SPACING);
	const struct soil_laying laying = soil_laying_of(&wheel, &from, &to, SPACING / wheel.radius, NULL, SPACING);
	const struct post_rect patch = {84, 85, 106, 105}, around = soil_laying_posts(&laying, &wheel, &to, SPACING, patch);
	struct soil_measured measured;
	struct soil_lay_result result;
	void *scratch = malloc(soil_lay_scratch(SIDE, SIDE));
	const size_t posts = (size_t)(patch.x1 - patch.x0) * (size_t)(patch.y1 - patch.y0);
	static int32_t carried[SIDE];
	if (scratch == NULL)
		exit(1);
	for (int i = 0; i < SIDE; i++)
		carried[i] = lattice_offset(0.002);
	memset(contact, 0, sizeof contact);
	for (int64_t y = patch.y0; y < patch.y1; y++)
		memset(contact + y * SIDE + patch.x0, SOIL_LOWERED | SOIL_HELD, (size_t)(patch.x1 - patch.x0));
	for (int i = 0; i < rounds; i++) {
		const double began = processor_seconds();
		for (int k = 0; k < CALLS; k++) {
			soil_measured_begin(&measured);
			for (int64_t y = patch.y0; y < patch.y1; y++) {
				const size_t at = (size_t)y * SIDE + (size_t)patch.x0;
				const struct soil_row row = {.x = patch.x0, .y = y, .count = (int)(patch.x1 - patch.x0), .contact = contact + at, .carried = carried, .offset = offset + at};
				soil_measure_row(&measured, &laying, soils, &row);
			}
			soil_lay(&laying, &measured, soils, &planes, contact, NULL, around, scratch, deposits, &result);
		}
		ns[i] = (processor_seconds() - began) * 1e9 / (double)posts / CALLS;
	}
	free(scratch);
	tell(machine, &laying_part, posts);
}

static int32_t critical(const struct soil_numbers *soil, double apart)
{
	return soil_critical_difference_cohesive(soil, apart);
}

/* Soil that lies so steep that it slides everywhere: an iteration for each post, as after a contact. */
static void of_sliding(const struct machine *machine)
{
	static int32_t slid_offset[COUNT], slid_deposited[COUNT];
	static uint32_t words[64];
	const struct soil_law law = law_of();
	struct soil_sliding rule;
	struct soil_slid slid = {.compacted = 0};
	uint32_t seed = 1;
	soil_sliding_prepare(&(struct soil_sliding_params){.soils = law.soils, .soil_count = 1, .spacing = SPACING, .critical = critical, .iterations = 1, .depth = 0,
							   .relief = INFINITY}, &rule);
	memset(contact, 0, sizeof contact);
	for (int i = 0; i < COUNT; i++) {
		seed = seed * 1664525u + 1013904223u;
		offset[i] = deposited[i] = (int32_t)(seed >> 12);
		deposits[i] = i % 16 == 0 ? 500 : 0;
	}
	struct soil_planes planes = planes_of();
	planes.rect = (struct post_rect){64, 64, 64 + SIDE, 64 + SIDE};
	planes.offset = slid_offset;
	planes.deposited = slid_deposited;
	const struct post_rect posts = {96, 96, 224, 224};
	const struct soil_slide_window window = {.written = posts, .posts = posts, .world = {0, 0, 1000, 1000}, .deposits = deposits};
	const size_t count = (size_t)(posts.x1 - posts.x0) * (size_t)(posts.y1 - posts.y0);
	void *scratch = malloc(soil_sliding_scratch(&rule, &planes));
	if (scratch == NULL)
		exit(1);
	for (int i = 0; i < rounds; i++) {
		memcpy(slid_offset, offset, sizeof offset);
		memcpy(slid_deposited, deposited, sizeof deposited);
		const double began = processor_seconds();
		soil_slide_window(&rule, &planes, &window, scratch, words, &slid);
		ns[i] = (processor_seconds() - began) * 1e9 / (double)count;
	}
	free(scratch);
	tell(machine, &sliding_part, count);
}

int main(int count, char **words)
{
	bench_record_begin("roofline", &count, words);
	rounds = count > 1 ? atoi(words[1]) : rounds;
	if (rounds < 1 || rounds > MOST_ROUNDS) {
		fprintf(stderr, "bench_roofline: ROUNDS is 1 to %d\n", MOST_ROUNDS);
		return 2;
	}
	struct machine machine = {peak_operations(), peak_bytes((size_t)1 << 14), peak_bytes((size_t)1 << 18)};
	add("machine", "operations", "1e9/s", machine.operations);
	add("machine", "second_cache", "GB/s", machine.second);
	printf("{\"roofline\": \"machine\", \"gigaops\": %.1f, \"first_cache_gigabytes\": %.1f, \"second_cache_gigabytes\": %.1f}\n", machine.operations,
	       machine.first, machine.second);
	of_law(&machine);
	of_laying(&machine);
	of_sliding(&machine);
	bench_record_end(NULL);
	return 0;
}
