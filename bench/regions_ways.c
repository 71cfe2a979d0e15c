/*
 * Four ways to compute contacts of bodies that touch one tile or four:
 *
 *   window   each contact is gathered from its tiles into a window, computed there, and scattered
 *   batch    the windows of all bodies of a step are computed together: each pass draws all of them, and reads and writes the tiles
 *   fixed    each stage is drawn in each tile that the body touches
 *   dynamic  each body has a texture that follows it. It is computed in there, without copies, until the body comes to its edge. Then the
 *            offsets are copied out to the tiles, and the ground around the body is copied in. Tiles are old in between
 *
 * A body goes to and fro by one post over its place, and a little deeper each step. So it stays on its corner, and each step changes ground.
 * A dynamic region is moved after as many steps as its margin has posts, as that of a body which goes straight on.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "bench.h"
#include "regions.h"

#define AROUND 4 /* posts of a dynamic region around a body and its margin: what smoothing reads, and the motion */
enum { TILES_MOST = 4 };

/* The texture that follows a body, as one tile of a world of its own. */
struct follower {
	int64_t x0, y0; /* its first post */
};

struct field {
	struct regions_job job;
	enum regions_way way;
	struct gpu *gpu;
	uint32_t side;          /* tiles of a side */
	struct extent extent;
	struct gpu_slots *slots;
	struct deform *deform;
	struct soil_shape shape;
	uint64_t scratch;       /* bytes beside the tiles */
	/* dynamic */
	uint32_t cells;         /* of a region */
	struct extent own;      /* of all regions, one after another */
	struct gpu_slots *regions;
	struct deform *follows;
	struct follower *followers;
};

static void *room(size_t count, size_t size)
{
	void *memory = mem_calloc(count, size);
	if (memory == NULL)
		bench_must(fail_memory("bench"));
	return memory;
}

/* Rough by 4 mm. */
static int32_t height(int64_t x, int64_t y)
{
	const uint32_t word = ((uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u) * 3266489917u;
	return (int32_t)(word >> 21) - 1024;
}

static void fill(struct gpu *gpu, struct gpu_slots *slots, const struct extent *extent, uint32_t wide, uint32_t high)
{
	const size_t posts = extent->cells + 1;
	struct gpu_staging *staging;
	bench_must(gpu_staging_create(gpu, posts * posts * sizeof(int32_t), &staging));
	for (uint32_t slot = 0; slot < wide * high; slot++) {
		const struct post_rect own = tile_post_rect(extent, (struct tile){0, slot % wide, slot / wide});
		int32_t *to = gpu_staging_bytes(staging);
		gpu_finish(gpu);
		while (!gpu_staging_idle(staging))
			;
		for (size_t i = 0; i < posts * posts; i++)
			to[i] = height(own.x0 + (int64_t)(i % posts), own.y0 + (int64_t)(i / posts));
		bench_must(gpu_slots_upload_base(slots, slot, staging, 0));
	}
	gpu_finish(gpu);
	gpu_staging_destroy(staging);
}

static struct deform_params params_of(const struct field *field, struct gpu_slots *slots, const struct extent *extent)
{
	return (struct deform_params){
		.gpu = field->gpu, .slots = slots, .extent = extent, .model = field->job.model, .box_radius = 1, .box_repetitions = field->job.repetitions,
		.soil_count = 1, .iterations = 1, .depth = INFINITY, .batches = field->way == WAY_BATCH,
		.fixed = field->way == WAY_FIXED || field->way == WAY_DYNAMIC,
	};
}

static uint64_t bytes_now(struct gpu *gpu)
{
	struct gpu_stats stats;
	gpu_stats(gpu, &stats);
	return stats.bytes;
}

static void open_followers(struct field *field)
{
	const uint32_t bodies = (uint32_t)field->job.bodies;
	field->cells = (uint32_t)(field->job.footprint + 2 * (field->job.margin + AROUND + field->job.repetitions));
	field->own = (struct extent){bodies * (int64_t)field->cells + 1, field->cells + 1, REGIONS_SPACING, field->cells};
	bench_must(gpu_slots_create(field->gpu, field->cells, bodies, deform_planes(field->job.model, false, 0), &field->regions));
	fill(field->gpu, field->regions, &field->own, bodies, 1);
	const struct deform_params params = params_of(field, field->regions, &field->own);
	bench_must(deform_create(&params, &field->follows));
	bench_must(deform_warm(field->follows, &(struct deform_planned){&field->shape, true, false}));
	field->followers = room(bodies, sizeof *field->followers);
	for (uint32_t i = 0; i < bodies; i++)
		bench_must(gpu_slots_deform(field->regions, i));
}

struct field *regions_open(struct gpu *gpu, const struct regions_job *job, enum regions_way way)
{
	struct field *field = room(1, sizeof *field);
	const uint32_t side = (uint32_t)ceil(sqrt(job->bodies)) + 1;
	*field = (struct field){.job = *job, .way = way, .gpu = gpu, .side = side < 3 ? 3 : side,
				.shape = {.kind = SOIL_SPHERE, .radius = job->footprint * REGIONS_SPACING / 2}};
	const int64_t posts = field->side * (int64_t)REGIONS_CELLS + 1;
	field->extent = (struct extent){posts, posts, REGIONS_SPACING, REGIONS_CELLS};
	bench_must(gpu_slots_create(gpu, REGIONS_CELLS, field->side * field->side, deform_planes(job->model, false, 0), &field->slots));
	if (way == WAY_BATCH)
		bench_must(gpu_slots_in_arrays(field->slots));
	fill(gpu, field->slots, &field->extent, field->side, field->side);
	const uint64_t before = bytes_now(gpu);
	if (way == WAY_DYNAMIC) {
		open_followers(field);
	} else {
		const struct deform_params params = params_of(field, field->slots, &field->extent);
		bench_must(deform_create(&params, &field->deform));
		bench_must(deform_warm(field->deform, &(struct deform_planned){&field->shape, true, false}));
	}
	field->scratch = bytes_now(gpu) - before;
	return field;
}

void regions_close(struct field *field)
{
	deform_destroy(field->deform);
	deform_destroy(field->follows);
	gpu_slots_destroy(field->regions);
	gpu_slots_destroy(field->slots);
	mem_free_all(field->followers, field);
}

uint64_t regions_bytes(const struct field *field)
{
	return field->scratch;
}

/* The post over which a body goes: the first ones stay on corners. */
static void place_of(const struct field *field, int body, int64_t place[2])
{
	const int corners = (int)lround(field->job.bodies * field->job.crossing), side = (int)field->side;
	if (body < corners) {
		place[0] = (1 + body % (side - 1)) * (int64_t)REGIONS_CELLS;
		place[1] = (1 + body / (side - 1)) * (int64_t)REGIONS_CELLS;
		return;
	}
	body -= corners;
	place[0] = (body % side) * (int64_t)REGIONS_CELLS + REGIONS_CELLS / 2;
	place[1] = (body / side) * (int64_t)REGIONS_CELLS + REGIONS_CELLS / 2;
}

static struct soil_pose pose_of(const struct field *field, const int64_t place[2], int step)
{
	const double radius = field->shape.radius, sink = 0.2 * radius + 0.0005 * step;
	return (struct soil_pose){
		.x = lattice_offset(((double)place[0] + (step % 2 == 0 ? -0.5 : 0.5)) * REGIONS_SPACING),
		.y = lattice_offset((double)place[1] * REGIONS_SPACING),
		.z = lattice_offset(radius - sink),
	};
}

static struct deform_contact contact_of(const struct field *field, const int64_t place[2], int step)
{
	return (struct deform_contact){.shape = &field->shape, .from = pose_of(field, place, step), .to = pose_of(field, place, step + 1)};
}

static size_t tiles_of(const struct extent *extent, uint32_t side, struct post_rect rect, struct tile_slot tiles[TILES_MOST])
{
	struct tile first, last;
	size_t count = 0;
	if (!tile_range_of(extent, 0, rect, &first, &last) || last.x - first.x > 1 || last.y - first.y > 1)
		bench_must(fail_with(STATUS_FAILED, "bench: a body leaves its tiles; mend it"));
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++)
			tiles[count++] = (struct tile_slot){{0, x, y}, y * side + x};
	return count;
}

/* --- the ways --- */

static struct deform_window window_of(struct deform *deform, const struct deform_contact *contact)
{
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	bench_must(deform_windows(deform, contact, windows, &count));
	if (count != 1)
		bench_must(fail_with(STATUS_FAILED, "bench: a body needs %zu windows; mend it", count));
	return windows[0];
}

static void by_window(struct field *field, const struct deform_contact *contact)
{
	const struct deform_window window = window_of(field->deform, contact);
	struct tile_slot tiles[TILES_MOST];
	const size_t count = tiles_of(&field->extent, field->side, window.read, tiles);
	bench_must(deform_compute(field->deform, contact, &window, 0, tiles, count));
	bench_must(deform_scatter(field->deform, &window, 0, tiles, count));
}

static void add_to_batch(struct field *field, const struct deform_contact *contact)
{
	const struct deform_window window = window_of(field->deform, contact);
	struct tile_slot tiles[TILES_MOST];
	const size_t count = tiles_of(&field->extent, field->side, window.read, tiles);
	bool added = false;
	for (int i = 0; i < 2 && !added; i++) {
		bench_must(deform_batch_add(field->deform, contact, &window, tiles, count, &added));
		if (added)
			break;
		bench_must(deform_batch_compute(field->deform));
		deform_batch_begin(field->deform);
	}
	assert(added);
}

static void in_regions(struct deform *deform, const struct extent *extent, uint32_t side, const struct deform_contact *contact)
{
	const struct deform_window window = window_of(deform, contact);
	struct tile_slot tiles[TILES_MOST];
	size_t written;
	bench_must(deform_fixed(deform, contact, &window, tiles, tiles_of(extent, side, window.read, tiles), &written));
}

/* Copies the planes between a region and the tiles below it: base heights and offsets in, or offsets out. */
static void move_planes(struct field *field, uint32_t body, bool in)
{
	const struct follower *at = &field->followers[body];
	const struct post_rect rect = {at->x0, at->y0, at->x0 + field->cells + 1, at->y0 + field->cells + 1};
	const struct gpu_slot *region = gpu_slots_get(field->regions, body);
	struct tile_slot tiles[TILES_MOST];
	const size_t count = tiles_of(&field->extent, field->side, rect, tiles);
	for (size_t i = 0; i < count; i++) {
		const struct gpu_slot *slot = gpu_slots_get(field->slots, tiles[i].slot);
		const struct post_rect own = tile_post_rect(&field->extent, tiles[i].tile), both = post_rect_intersect(own, rect);
		const struct gpu_rect here = {(uint32_t)(both.x0 - rect.x0), (uint32_t)(both.y0 - rect.y0), (uint32_t)(both.x1 - both.x0), (uint32_t)(both.y1 - both.y0)};
		const struct gpu_rect there = {(uint32_t)(both.x0 - own.x0), (uint32_t)(both.y0 - own.y0), here.width, here.height};
		if (in) {
			gpu_texture_copy(slot->base, 0, there.x, there.y, region->base, 0, here);
			gpu_texture_copy(slot->planes[PLANE_OFFSET], 0, there.x, there.y, region->planes[PLANE_OFFSET], 0, here);
		} else {
			gpu_texture_copy(region->planes[PLANE_OFFSET], 0, here.x, here.y, slot->planes[PLANE_OFFSET], 0, there);
		}
	}
}

static void follow(struct field *field, int body, const int64_t place[2], int step)
{
	struct follower *at = &field->followers[body];
	if (step % field->job.margin == 0) {
		if (step > 0)
			move_planes(field, (uint32_t)body, false);
		at->x0 = place[0] - field->cells / 2;
		at->y0 = place[1] - field->cells / 2;
		move_planes(field, (uint32_t)body, true);
	}
	/* The same contact in the region's own world. */
	const int64_t local[2] = {place[0] - at->x0 + body * (int64_t)field->cells, place[1] - at->y0};
	const struct deform_contact contact = contact_of(field, local, step);
	in_regions(field->follows, &field->own, (uint32_t)field->job.bodies, &contact);
}

static void one_step(struct field *field, int step)
{
	if (field->way == WAY_BATCH)
		deform_batch_begin(field->deform);
	for (int body = 0; body < field->job.bodies; body++) {
		int64_t place[2];
		place_of(field, body, place);
		const struct deform_contact contact = contact_of(field, place, step);
		switch (field->way) {
		case WAY_WINDOW:
			by_window(field, &contact);
			break;
		case WAY_BATCH:
			add_to_batch(field, &contact);
			break;
		case WAY_FIXED:
			in_regions(field->deform, &field->extent, field->side, &contact);
			break;
		default:
			follow(field, body, place, step);
		}
	}
	if (field->way == WAY_BATCH)
		bench_must(deform_batch_compute(field->deform));
}

double regions_seconds(struct gpu *gpu)
{
	return gpu_info(gpu)->software ? clock_process_seconds() : clock_seconds();
}

double regions_run(struct field *field)
{
	for (uint32_t i = 0; i < field->side * field->side; i++) {
		gpu_slots_undeform(field->slots, i);
		bench_must(gpu_slots_deform(field->slots, i));
	}
	gpu_finish(field->gpu);
	const double began = regions_seconds(field->gpu);
	for (int step = 0; step < REGIONS_STEPS; step++)
		one_step(field, step);
	for (int body = 0; body < field->job.bodies && field->way == WAY_DYNAMIC; body++)
		move_planes(field, (uint32_t)body, false);
	gpu_finish(field->gpu);
	return regions_seconds(field->gpu) - began;
}

uint64_t regions_hash(struct field *field)
{
	const uint32_t posts = REGIONS_CELLS + 1;
	int32_t *offsets = room((size_t)posts * posts, sizeof *offsets);
	uint64_t hash = 0;
	for (uint32_t i = 0; i < field->side * field->side; i++) {
		gpu_texture_read(gpu_slots_get(field->slots, i)->planes[PLANE_OFFSET], 0, (struct gpu_rect){0, 0, posts, posts}, offsets);
		hash = XXH3_64bits_withSeed(offsets, (size_t)posts * posts * sizeof *offsets, hash);
	}
	mem_free(offsets);
	return hash;
}
