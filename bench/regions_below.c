/*
 * The dissertation's own displacement (4.4.1, 5.5): the object is drawn from below, as triangles, into a depth buffer over its region. Then a
 * pass takes the depth difference to the terrain into an offset map of few bits. It stands beside the lower envelope and contact of
 * deform.h, over the same flat posts: a sphere that goes a post a step along x.
 *
 * Errors are to the closed form of the swept sphere, in double. They have three parts: triangles for a sphere, no ground between two
 * places of the object, and the bits of the offset map.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "gpu/internal.h"
#include "regions.h"

#define DEEPEST 0.2 /* m: of all spheres */
#define RANGE 0.25f /* m: deepest offset that the normalised map holds */
enum { STEPS = 32, RINGS = 16, SECTORS = 48, TIMED = 60 };

extern const struct shader_text regions_shaders[];

static const struct {
	const char *name;
	enum gpu_format format;
	bool normalised;
} maps[] = {{"R8", GPU_R8, true}, {"R16F", GPU_R16F, false}, {"R32F", GPU_R32F, false}};
enum { MAPS = sizeof maps / sizeof *maps };

struct below {
	struct gpu *gpu;
	uint32_t side; /* posts of the region */
	int travel;    /* posts that the sphere goes */
	double radius, sink, start; /* m, m, posts */
	struct gpu_texture *depth, *base, *offset[2];
	struct gpu_target *deep, *pressed[2];
	struct gpu_buffer *indices;
	struct gpu_program *draw, *press;
	int now;
	bool normalised;
};

static struct gpu_program *program(struct gpu *gpu, const char *vertex, const char *fragment, bool normalised)
{
	static struct shader_text table[8];
	struct gpu_program_request request = {.vertex = vertex, .fragment = fragment, .defines = {normalised ? "NORMALISED" : NULL}};
	struct gpu_program *found;
	size_t count = 0;
	for (const struct shader_text *file = regions_shaders; file->path != NULL && count < 6; file++)
		table[count++] = *file;
	for (const struct shader_text *file = gpu_shader_table; file->path != NULL; file++)
		if (strcmp(file->path, "full.vert") == 0)
			table[count] = *file;
	bench_must(gpu_program_get_from(gpu, table, &request, &found));
	return found;
}

/* A region in which the sphere can go over `travel` posts. */
static void open_below(struct gpu *gpu, int footprint, int map, int travel, struct below *below)
{
	const uint32_t side = (uint32_t)(footprint + travel) + 8;
	const struct gpu_rect all = {0, 0, side, side};
	static uint32_t indices[RINGS * SECTORS * 6];
	*below = (struct below){.gpu = gpu, .side = side, .travel = travel, .radius = footprint * REGIONS_SPACING / 2, .normalised = maps[map].normalised};
	below->sink = fmin(0.2 * below->radius, DEEPEST);
	below->start = 4 + footprint / 2.0;
	for (uint32_t i = 0; i < RINGS * SECTORS * 6; i++)
		indices[i] = i;
	bench_must(gpu_buffer_create(gpu, GPU_INDICES, sizeof indices, indices, &below->indices));
	bench_must(gpu_texture_create(gpu, GPU_DEPTH32F, side, side, 0, &below->depth));
	bench_must(gpu_target_create(gpu, NULL, 0, (struct gpu_attachment){below->depth, 0}, &below->deep));
	bench_must(gpu_texture_create(gpu, GPU_R32I, side, side, 0, &below->base));
	gpu_texture_clear(below->base, 0, all, 0);
	for (int i = 0; i < 2; i++) {
		bench_must(gpu_texture_create(gpu, maps[map].format, side, side, 0, &below->offset[i]));
		gpu_texture_clear(below->offset[i], 0, all, 0);
		bench_must(gpu_target_create(gpu, &(struct gpu_attachment){below->offset[i], 0}, 1, (struct gpu_attachment){NULL, 0}, &below->pressed[i]));
	}
	below->draw = program(gpu, "below.vert", "below.frag", false);
	below->press = program(gpu, "full.vert", "pressed.frag", maps[map].normalised);
}

static void close_below(struct below *below)
{
	gpu_target_destroy(below->deep);
	gpu_texture_destroy(below->depth);
	gpu_texture_destroy(below->base);
	for (int i = 0; i < 2; i++) {
		gpu_target_destroy(below->pressed[i]);
		gpu_texture_destroy(below->offset[i]);
	}
	gpu_buffer_destroy(below->indices);
}

/* The object at one place, x posts from the start. */
static void press_below(struct below *below, double x)
{
	const float low = (float)(-below->sink - 0.01), range = (float)(below->radius + 0.02), side = (float)below->side;
	const struct {
		float centre[4], scale[4];
		int32_t parts[4];
		float spacing[4];
	} drawn = {
		{(float)(below->start + x), side / 2, (float)(below->radius - below->sink), (float)below->radius},
		{side, side, low, range},
		{RINGS, SECTORS},
		{(float)REGIONS_SPACING},
	};
	const float pressed[4] = {low, range, RANGE};
	const struct gpu_rect all = {0, 0, below->side, below->side};
	gpu_target_clear(below->deep, (const float[4]){0});
	gpu_pass_run(below->gpu, &(struct gpu_pass){
		.stage = GPU_FACETS, .program = below->draw, .target = below->deep, .viewport = all, .params = &drawn, .params_bytes = sizeof drawn,
		.indices = below->indices, .index_count = RINGS * SECTORS * 6, .instances = 1, .wide_indices = true, .depth_test = true,
	});
	gpu_pass_run(below->gpu, &(struct gpu_pass){
		.stage = GPU_CONTACT, .program = below->press, .target = below->pressed[1 - below->now], .viewport = all,
		.textures = {below->depth, below->offset[below->now], below->base}, .params = pressed, .params_bytes = sizeof pressed,
	});
	below->now = 1 - below->now;
}

/* The offset that the sphere leaves at a post, m, after it went straight from the start over `length` posts. */
static double truth(const struct below *below, double x, double y, double length)
{
	const double along = fmin(fmax(x - below->start, 0), length), dx = (x - below->start - along) * REGIONS_SPACING;
	const double dy = (y - below->side / 2.0) * REGIONS_SPACING, left = below->radius * below->radius - dx * dx - dy * dy;
	return left < 0 ? 0 : fmin(0, below->radius - below->sink - sqrt(left));
}

struct error {
	double rms, most; /* m, over posts that are pressed */
};

static struct error error_of(const struct below *below, const double *metres, double length)
{
	struct error error = {0, 0};
	double count = 0;
	for (uint32_t i = 0; i < below->side * below->side; i++) {
		const double right = truth(below, i % below->side, i / below->side, length), off = fabs(metres[i] - right);
		if (right == 0 && metres[i] == 0)
			continue;
		error.rms += off * off;
		error.most = fmax(error.most, off);
		count++;
	}
	error.rms = sqrt(error.rms / count);
	return error;
}

static void read_map(struct below *below, int map, double *metres)
{
	const struct gpu_rect all = {0, 0, below->side, below->side};
	const size_t posts = (size_t)below->side * below->side;
	uint32_t *raw = malloc(posts * 4);
	if (raw == NULL)
		bench_must(fail_memory("bench"));
	gpu_texture_read(below->offset[below->now], 0, all, raw);
	for (size_t i = 0; i < posts; i++) {
		if (maps[map].format == GPU_R8) {
			metres[i] = -((const uint8_t *)raw)[i] / 255.0 * (double)RANGE;
		} else if (maps[map].format == GPU_R16F) {
			const uint16_t half = ((const uint16_t *)raw)[i];
			const int exponent = half >> 10 & 31, mantissa = half & 1023;
			const double size = exponent == 0 ? ldexp(mantissa, -24) : ldexp(1024 + mantissa, exponent - 25);
			metres[i] = half >> 15 ? -size : size;
		} else {
			float value;
			memcpy(&value, &raw[i], sizeof value);
			metres[i] = (double)value;
		}
	}
	free(raw);
}

/* The same by deform.h: one tile, one fixed region, no copies. */
struct envelope {
	struct extent extent;
	struct gpu_slots *slots;
	struct deform *deform;
	struct soil_shape shape;
};

static void open_envelope(struct gpu *gpu, const struct below *of, struct envelope *envelope)
{
	const uint32_t cells = of->side - 1;
	struct gpu_staging *staging;
	*envelope = (struct envelope){.extent = {of->side, of->side, REGIONS_SPACING, cells}, .shape = {.kind = SOIL_SPHERE, .radius = of->radius}};
	bench_must(gpu_slots_create(gpu, cells, 1, deform_planes(DEFORM_NONE, false, 0), &envelope->slots));
	bench_must(gpu_staging_create(gpu, (size_t)of->side * of->side * 4, &staging));
	memset(gpu_staging_bytes(staging), 0, (size_t)of->side * of->side * 4);
	bench_must(gpu_slots_upload_base(envelope->slots, 0, staging, 0));
	gpu_finish(gpu);
	gpu_staging_destroy(staging);
	bench_must(gpu_slots_deform(envelope->slots, 0));
	const struct deform_params params = {.gpu = gpu, .slots = envelope->slots, .extent = &envelope->extent, .model = DEFORM_NONE, .box_radius = 1,
					     .box_repetitions = 1, .soil_count = 1, .iterations = 1, .depth = INFINITY, .fixed = true};
	bench_must(deform_create(&params, &envelope->deform));
	bench_must(deform_warm(envelope->deform, &(struct deform_planned){&envelope->shape, true, false}));
}

static void close_envelope(struct envelope *envelope)
{
	deform_destroy(envelope->deform);
	gpu_slots_destroy(envelope->slots);
}

static void press_envelope(struct envelope *envelope, const struct below *of, double x)
{
	const struct tile_slot tile = {{0, 0, 0}, 0};
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	struct deform_contact contact = {.shape = &envelope->shape};
	size_t count, written;
	contact.to = (struct soil_pose){.x = lattice_offset((of->start + x) * REGIONS_SPACING), .y = lattice_offset(of->side / 2.0 * REGIONS_SPACING),
					.z = lattice_offset(of->radius - of->sink)};
	contact.from = contact.to;
	contact.from.x -= x > 0 ? lattice_offset(REGIONS_SPACING) : 0;
	bench_must(deform_windows(envelope->deform, &contact, windows, &count));
	bench_must(deform_fixed(envelope->deform, &contact, windows, &tile, 1, &written));
}

static double microseconds(struct gpu *gpu, struct below *below, struct envelope *envelope)
{
	gpu_finish(gpu);
	const double began = regions_seconds(gpu);
	for (int i = 0; i < TIMED; i++) {
		if (envelope != NULL)
			press_envelope(envelope, below, i % (below->travel + 1));
		else
			press_below(below, i % (below->travel + 1));
	}
	gpu_finish(gpu);
	return (regions_seconds(gpu) - began) * 1e6 / TIMED;
}

static void tell(const char *way, int footprint, const double *metres, const struct below *below, double *us, int runs)
{
	const struct error error = error_of(below, metres, STEPS);
	const double us_median = bench_median(us, (size_t)runs);
	printf("{\"bench\": \"below\", \"footprint\": %d, \"way\": \"%s\", \"us\": %.3f, \"rms_mm\": %.7f, \"most_mm\": %.7f, \"depth_mm\": %.3f}\n", footprint, way,
	       us_median, error.rms * 1e3, error.most * 1e3, below->sink * 1e3);
	fflush(stdout);
}

/* Errors are of a sphere that went over STEPS posts; times of one that goes to and fro by a post, in a region that just holds it. */
static void one(struct gpu *gpu, int footprint, int runs)
{
	struct below below[MAPS], timed[MAPS];
	struct envelope envelope, timed_envelope;
	double us[MAPS + 1][16];
	for (int map = 0; map < MAPS; map++) {
		open_below(gpu, footprint, map, STEPS, &below[map]);
		open_below(gpu, footprint, map, 1, &timed[map]);
	}
	open_envelope(gpu, &below[0], &envelope);
	open_envelope(gpu, &timed[0], &timed_envelope);
	for (int i = -1; i < runs; i++)
		for (int map = 0; map <= MAPS; map++)
			us[map][i < 0 ? 0 : i] = microseconds(gpu, &timed[map % MAPS], map < MAPS ? NULL : &timed_envelope);
	const size_t posts = (size_t)below[0].side * below[0].side;
	double *metres = malloc(posts * sizeof *metres);
	int32_t *offsets = malloc(posts * sizeof *offsets);
	if (metres == NULL || offsets == NULL)
		bench_must(fail_memory("bench"));
	for (int i = 0; i <= STEPS; i++) {
		for (int map = 0; map < MAPS; map++)
			press_below(&below[map], i);
		press_envelope(&envelope, &below[0], i);
	}
	for (int map = 0; map < MAPS; map++) {
		read_map(&below[map], map, metres);
		tell(maps[map].name, footprint, metres, &below[map], us[map], runs);
	}
	gpu_texture_read(gpu_slots_get(envelope.slots, 0)->planes[PLANE_OFFSET], 0, (struct gpu_rect){0, 0, below[0].side, below[0].side}, offsets);
	for (size_t i = 0; i < posts; i++)
		metres[i] = lattice_offset_metres(offsets[i]);
	tell("envelope", footprint, metres, &below[0], us[MAPS], runs);
	free(metres);
	free(offsets);
	close_envelope(&envelope);
	close_envelope(&timed_envelope);
	for (int map = 0; map < MAPS; map++) {
		close_below(&below[map]);
		close_below(&timed[map]);
	}
}

void regions_below(struct gpu *gpu, const int *footprints, int count, int runs)
{
	for (int i = 0; i < count; i++)
		one(gpu, footprints[i], runs);
}
