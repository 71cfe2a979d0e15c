/* Ground for the tests of deform: a block of resident tiles over a function of posts, without store or
 * cache; and what a sweep makes of it, read back as one field of posts. */
#ifndef FURROW_TESTS_DEFORM_GROUND_H
#define FURROW_TESTS_DEFORM_GROUND_H

#include <math.h>

#include "../gpu/gpu_test.h"
#include "../gpu/staged.h"
#include "deform/internal.h"
#include "deform/reference/reference.h"

typedef int32_t (*resident_ground_height)(int64_t x, int64_t y); /* of a post of the block, base lattice */

struct ground_params {
	uint32_t cells, tiles; /* tiles a side */
	int64_t first;         /* the block's first tile, in x and y */
	double spacing;
	resident_ground_height height; /* NULL: flat, at 0 */
	int32_t reference;
	enum deform_model model;
	int radius, repetitions; /* 0: 1 */
	bool dirt;
	const struct soil_numbers *soils; /* NULL: dry_sand */
	int soil_count;                  /* 0: 1 */
	int iterations;                  /* 0: 4 */
	bool lines;                      /* soil slides along lines too */
	double depth;                    /* m; 0: no bottom */
	double relief;                   /* m; 0: not known */
	double tolerance;                /* m */
	bool stands;                     /* undisturbed ground does */
	bool touched;                    /* deform_is_touched is asked */
	bool batches;                    /* contacts may be computed together */
	bool fixed;                      /* contacts are computed in fixed regions */
};

struct ground {
	struct ground_params params;
	struct extent extent;
	struct gpu_slots *slots;
	struct deform *deform;
	struct tile_slot *tiles;
	size_t tile_count;
	int64_t x0;    /* the block's first post, in x and y */
	int64_t posts; /* a side of the block */
	int32_t *base, *offset;
	uint8_t *dirt;
	struct deform_window windows[DEFORM_WINDOWS_MAX]; /* of the last sweep */
	size_t window_count;
};

static inline void *ground_room(int64_t count, size_t size)
{
	void *room = mem_calloc((size_t)count, size);
	assert_non_null(room);
	return room;
}

/* What posts remember. Without soils there is dry_sand, which is cohesive. */
static inline unsigned ground_memory(const struct ground_params *params)
{
	struct soil_numbers sand;
	assert_ok(soil_named("dry_sand", &sand));
	return deform_slopes_count(params->model, params->soils != NULL ? params->soils : &sand, params->soil_count > 1 ? params->soil_count : 1) ? DEFORM_SLOPES : 0;
}

static inline void ground_init(struct ground *ground, const struct ground_params *params)
{
	memset(ground, 0, sizeof *ground);
	ground->params = *params;
	int64_t cells = params->cells, side = (params->first + params->tiles) * cells + 1;
	ground->extent = (struct extent){side, side, params->spacing, params->cells};
	ground->x0 = params->first * cells;
	ground->posts = (int64_t)params->tiles * cells + 1;
	ground->tile_count = (size_t)params->tiles * params->tiles;
	ground->tiles = ground_room((int64_t)ground->tile_count, sizeof *ground->tiles);
	ground->base = ground_room(ground->posts * ground->posts, sizeof *ground->base);
	ground->offset = ground_room(ground->posts * ground->posts, sizeof *ground->offset);
	ground->dirt = ground_room(ground->posts * ground->posts, 1);
	for (int64_t i = 0; i < ground->posts * ground->posts && params->height != NULL; i++)
		ground->base[i] = params->height(i % ground->posts, i / ground->posts);
	assert_ok(gpu_slots_create(test_gpu, params->cells, (uint32_t)ground->tile_count,
				   deform_planes(params->model, params->dirt, ground_memory(params)), &ground->slots));
	if (params->batches)
		assert_ok(gpu_slots_in_arrays(ground->slots));
	int32_t *posts = ground_room((cells + 1) * (cells + 1), sizeof *posts);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		uint32_t tx = k % params->tiles, ty = k / params->tiles;
		for (int64_t y = 0; y <= cells; y++)
			memcpy(posts + y * (cells + 1), ground->base + (ty * cells + y) * ground->posts + tx * cells,
			       (size_t)(cells + 1) * sizeof *posts);
		ground->tiles[k] = (struct tile_slot){
			{0, (uint32_t)params->first + tx, (uint32_t)params->first + ty}, k};
		assert_ok(staged_upload_base(test_gpu, ground->slots, params->cells, k, posts));
	}
	mem_free(posts);
	struct deform_params deform = {
		.gpu = test_gpu,
		.slots = ground->slots,
		.extent = &ground->extent,
		.reference = params->reference,
		.model = params->model,
		.box_radius = params->radius + (params->radius == 0),
		.box_repetitions = params->repetitions + (params->repetitions == 0),
		.disturbance = params->dirt,
		.soil_count = params->soil_count + (params->soil_count == 0),
		.iterations = params->iterations != 0 ? params->iterations : 4,
		.along_lines = params->lines,
		.relief = params->relief != 0 ? params->relief : (double)INFINITY,
		.depth = params->depth != 0 ? params->depth : (double)INFINITY,
		.tolerance = params->tolerance,
		.undisturbed_stable = params->stands,
		.touched = params->touched,
		.batches = params->batches,
		.fixed = params->fixed,
		.tension = 2000, .stiffness = 50000, .yield = 0.05, .rut = 0.5,
	};
	assert_ok(soil_named("dry_sand", &deform.soils[0]));
	for (int i = 0; i < deform.soil_count && params->soils != NULL; i++)
		deform.soils[i] = params->soils[i];
	assert_ok(deform_create(&deform, &ground->deform));
}

static inline void ground_finish(struct ground *ground)
{
	deform_destroy(ground->deform);
	gpu_slots_destroy(ground->slots);
	mem_free(ground->tiles);
	mem_free(ground->base);
	mem_free(ground->offset);
	mem_free(ground->dirt);
}

/* As it was before anything drove on it. */
static inline void ground_reset(struct ground *ground)
{
	for (uint32_t k = 0; k < ground->tile_count; k++)
		gpu_slots_undeform(ground->slots, k);
}

static inline void ground_sweep(struct ground *ground, const struct deform_contact *sweep)
{
	assert_ok(deform_windows(ground->deform, sweep, ground->windows, &ground->window_count));
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(deform_compute(ground->deform, sweep, &ground->windows[i], (uint32_t)i, ground->tiles,
					 ground->tile_count));
	for (size_t i = 0; i < ground->window_count; i++)
		assert_ok(deform_scatter(ground->deform, &ground->windows[i], (uint32_t)i, ground->tiles,
					 ground->tile_count));
}

/* An interval with these objects at rest on the ground. */
static inline struct deform_interval ground_interval(struct ground *ground, const struct deform_rest *objects, size_t count)
{
	struct deform_interval size;
	assert_ok(deform_interval_begin(ground->deform, objects, count, &size));
	for (size_t i = 0; i < size.regions; i++)
		assert_ok(deform_interval_gather(ground->deform, i, ground->tiles, ground->tile_count));
	for (size_t i = 0; i < size.runs; i++)
		assert_ok(deform_interval_scatter(ground->deform, i, ground->tiles, ground->tile_count));
	if (size.blocks > 0)
		assert_ok(deform_interval_end(ground->deform));
	return size;
}

/* Whether a post of the block lies in what the last sweep was to write. */
static inline bool ground_written(const struct ground *ground, int64_t at)
{
	int64_t x = at % ground->posts + ground->x0, y = at / ground->posts + ground->x0;
	for (size_t i = 0; i < ground->window_count; i++) {
		struct post_rect write = ground->windows[i].write;
		if (x >= write.x0 && x < write.x1 && y >= write.y0 && y < write.y1)
			return true;
	}
	return false;
}

/* Reads offset and dirt of the whole block; posts that tiles share must be the same in all of them. */
static inline void ground_read(struct ground *ground)
{
	int64_t cells = ground->params.cells, side = cells + 1;
	int32_t *offset = ground_room(side * side, sizeof *offset);
	uint8_t *dirt = ground_room(side * side, 1);
	bool *known = ground_room(ground->posts * ground->posts, sizeof *known);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		assert_ok(staged_read_deform(test_gpu, ground->slots, ground->params.cells, k, offset,
					     ground->params.dirt ? dirt : NULL));
		for (int64_t i = 0; i < side * side; i++) {
			int64_t x = k % ground->params.tiles * cells + i % side, y = k / ground->params.tiles * cells + i / side;
			int64_t at = y * ground->posts + x;
			if (known[at] && (ground->offset[at] != offset[i] || ground->dirt[at] != dirt[i]))
				fail_msg("post %lld, %lld differs between the tiles that share it", (long long)x, (long long)y);
			known[at] = true;
			ground->offset[at] = offset[i];
			ground->dirt[at] = dirt[i];
		}
	}
	mem_free(offset);
	mem_free(dirt);
	mem_free(known);
}

/* What a sweep leaves of ground where nothing was before: its offsets. Freed by the caller. */
static inline int32_t *ground_swept(struct ground *ground, const struct deform_contact *sweep)
{
	ground_reset(ground);
	ground_sweep(ground, sweep);
	ground_read(ground);
	int32_t *copy = ground_room(ground->posts * ground->posts, sizeof *copy);
	memcpy(copy, ground->offset, (size_t)(ground->posts * ground->posts) * sizeof *copy);
	return copy;
}

/* The contact of every post of the block, of the last sweep's only window. */
static inline uint8_t *ground_contacts(struct ground *ground)
{
	uint8_t *contacts = ground_room(ground->posts * ground->posts, 1);
	uint8_t *window = ground_room(SIDE * SIDE, 1);
	assert_int_equal(ground->window_count, 1);
	struct post_rect read = ground->windows[0].read;
	int64_t width = read.x1 - read.x0, height = read.y1 - read.y0;
	gpu_texture_read(ground->deform->contacts, 0, rect_of(0, 0, (uint32_t)width, (uint32_t)height), window);
	for (int64_t i = 0; i < width * height; i++) {
		int64_t x = read.x0 + i % width - ground->x0, y = read.y0 + i / width - ground->x0;
		if (x >= 0 && y >= 0 && x < ground->posts && y < ground->posts)
			contacts[y * ground->posts + x] = window[i];
	}
	mem_free(window);
	return contacts;
}

/* Posts in which the soil of the last contact could slide: lib/reached.glsl does the same. */
static inline struct post_rect ground_slides(struct ground *ground)
{
	const struct deform *deform = ground->deform;
	struct post_rect read = ground->windows[0].read, write = ground->windows[0].write;
	uint32_t ends[4];
	gpu_buffer_read(deform->laying, 0, sizeof ends, ends);
	if (!deform->scratch[0].near)
		return write;
	if (ends[0] == 0)
		return (struct post_rect){write.x0, write.y0, write.x0, write.y0};
	int64_t bias = 1 << 30, by = deform->reach;
	struct post_rect posts = {read.x0 + bias - ends[1] - by, read.y0 + bias - ends[3] - by, read.x0 + ends[0] - bias + 1 + by,
				  read.y0 + ends[2] - bias + 1 + by};
	return post_rect_intersect(posts, write);
}

/* What rests at a sweep's end is what an object is above that only stands there. */
static inline void assert_rests_where_it_ends(struct ground *ground, const struct deform_contact *sweep)
{
	struct gpu_rect all = rect_of(0, 0, SIDE, SIDE);
	int32_t *rest = ground_room(SIDE * SIDE, sizeof *rest), *under = ground_room(SIDE * SIDE, sizeof *under);
	assert_ok(deform_windows(ground->deform, sweep, ground->windows, &ground->window_count));
	const struct deform_window *window = &ground->windows[0];
	assert_ok(deform_envelope(ground->deform, sweep, window, 0));
	gpu_texture_read(ground->deform->rest, 0, all, rest);
	struct deform_contact standing = *sweep;
	standing.from = standing.to;
	standing.turned = 0;
	assert_ok(deform_envelope(ground->deform, &standing, window, 0));
	gpu_texture_read(ground->deform->under, 0, all, under);
	int above = 0;
	for (int64_t y = 0; y < window->read.y1 - window->read.y0; y++)
		for (int64_t x = 0; x < window->read.x1 - window->read.x0; x++) {
			assert_int_equal(rest[y * SIDE + x], under[y * SIDE + x]);
			above += under[y * SIDE + x] != UNDER_NONE;
		}
	assert_true(above > 20);
	mem_free(rest);
	mem_free(under);
}

/* One plane of the block, int32 whatever it is kept in; posts that tiles share must be the same in all of them. */
static inline int32_t *ground_plane(struct ground *ground, enum plane plane)
{
	int64_t cells = ground->params.cells, side = cells + 1;
	int32_t *all = ground_room(ground->posts * ground->posts, sizeof *all);
	bool *known = ground_room(ground->posts * ground->posts, sizeof *known);
	char *posts = ground_room(side * side, 4);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		void *planes[PLANES] = {NULL};
		planes[plane] = posts;
		assert_ok(staged_read_planes(test_gpu, ground->slots, ground->params.cells, k, planes));
		for (int64_t i = 0; i < side * side; i++) {
			int64_t at = (k / ground->params.tiles * cells + i / side) * ground->posts + k % ground->params.tiles * cells + i % side;
			int32_t value = plane_bytes(plane) == 4 ? ((int32_t *)posts)[i] : ((uint8_t *)posts)[i];
			assert_true(!known[at] || all[at] == value);
			known[at] = true;
			all[at] = value;
		}
	}
	mem_free(known);
	mem_free(posts);
	return all;
}

/* One post of a plane; x and y counted from the block's first post. */
static inline int32_t ground_post(struct ground *ground, enum plane plane, int64_t x, int64_t y)
{
	int32_t *all = ground_plane(ground, plane), post = all[y * ground->posts + x];
	mem_free(all);
	return post;
}

static inline int64_t ground_sum(struct ground *ground, enum plane plane)
{
	int32_t *all = ground_plane(ground, plane);
	int64_t sum = 0;
	for (int64_t i = 0; i < ground->posts * ground->posts; i++)
		sum += all[i];
	mem_free(all);
	return sum;
}

/* Metres from a place on the lattice to a post of the block. */
static inline long double ground_from(const struct ground *ground, int64_t post, int64_t place)
{
	return (long double)(ground->x0 + post) * ground->params.spacing - ldexpl((long double)place, -OFFSET_BITS);
}

/* -1 .. 1 */
static inline double any_share(void)
{
	return (double)any_word() / 2147483648.0 - 1;
}

/* A place of the block on the lattice. x, y: in posts from the block's first post; z: metres. */
static inline struct soil_pose ground_pose(const struct ground *ground, double x, double y, double z)
{
	return (struct soil_pose){
		.x = lattice_offset(((double)ground->x0 + x) * ground->params.spacing),
		.y = lattice_offset(((double)ground->x0 + y) * ground->params.spacing),
		.z = lattice_offset(z),
	};
}

/* An object that is set down there and does not move. */
static inline struct deform_contact ground_stand(const struct ground *ground, const struct soil_shape *shape, double x, double y, double z)
{
	struct soil_pose pose = ground_pose(ground, x, y, z);
	return (struct deform_contact){.shape = shape, .from = pose, .to = pose};
}

#endif
