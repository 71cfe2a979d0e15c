/* Ground for the tests of bearing soil: a block of tiles in host memory over a function of posts, without store, cache or GL; and what contacts make of it. */
#ifndef FURROW_TESTS_BEARING_GROUND_H
#define FURROW_TESTS_BEARING_GROUND_H

#include <math.h>
#include <string.h>

#include "../soil/soil_test.h"
#include "bearing/bearing.h"
#include "deform/reference/reference.h"
#include "resident/host_slots.h"

struct ground_params {
	uint32_t cells, tiles;            /* tiles a side */
	int64_t first;                    /* the block's first tile, in x and y */
	double spacing;                   /* m */
	int32_t (*height)(int64_t x, int64_t y); /* of a post of the block, 2^-18 m above the reference; NULL: flat, at 0 */
	int32_t reference;                /* m */
	enum deform_model model;          /* 0: scm; DEFORM_SLIPPAGE: soil that only slides */
	const struct soil_numbers *soils; /* NULL: dry_sand */
	int iterations;                   /* 0: 4 */
	bool lines;                       /* soil slides along lines too */
	double depth;                     /* m; 0: under scm none below what is laid, otherwise no bottom */
	bool stands;                      /* undisturbed ground is stable */
	double bulldozing, slip_sinkage, loosening, hardening;
	bool ground_normals, thrown;
	uint32_t loaded_bodies;
};

struct ground {
	struct ground_params params;
	struct extent extent;
	struct host_slots *slots;
	struct bearing *bearing;
	struct tile_slot *tiles;
	size_t tile_count;
	int64_t x0;    /* the block's first post, in x and y */
	int64_t posts; /* a side of the block */
	struct bearing_area area;    /* of the last contact */
	struct bearing_contact done; /* what it did */
};

static inline void *ground_room(int64_t count, size_t size)
{
	void *room = mem_calloc((size_t)count, size);
	assert_non_null(room);
	return room;
}

static inline void ground_fill(struct ground *ground, uint32_t slot)
{
	const struct ground_params *params = &ground->params;
	const int64_t cells = params->cells, x0 = slot % params->tiles * cells, y0 = slot / params->tiles * cells;
	int32_t *base;
	assert_ok(resident_host_tile_base(ground->slots, &host_entry(ground->slots, slot)->tile, &base));
	for (int64_t i = 0; i < (cells + 1) * (cells + 1); i++)
		base[i] = params->height != NULL ? params->height(x0 + i % (cells + 1), y0 + i / (cells + 1)) : 0;
}

/* What posts remember. Without soils there is dry_sand, which is cohesive. */
static inline unsigned ground_memory(const struct ground_params *params, enum deform_model model)
{
	struct soil_numbers sand;
	assert_ok(soil_named("dry_sand", &sand));
	return (params->slip_sinkage > 0 ? DEFORM_DIGS : 0) | (params->loosening > 0 ? DEFORM_LOOSENS : 0) | (params->hardening > 0 ? DEFORM_HARDENS : 0) |
	        (deform_slopes_count(model, params->soils != NULL ? params->soils : &sand, 1) ? DEFORM_SLOPES : 0);
}

static inline void ground_init(struct ground *ground, const struct ground_params *params)
{
	*ground = (struct ground){.params = *params};
	const enum deform_model model = params->model == 0 ? DEFORM_SCM : params->model;
	const int64_t cells = params->cells, side = (params->first + params->tiles) * cells + 1;
	ground->extent = (struct extent){side, side, params->spacing, params->cells};
	ground->x0 = params->first * cells;
	ground->posts = (int64_t)params->tiles * cells + 1;
	ground->tile_count = (size_t)params->tiles * params->tiles;
	ground->tiles = ground_room((int64_t)ground->tile_count, sizeof *ground->tiles);
	assert_ok(resident_host_create(params->cells, (uint32_t)ground->tile_count, deform_planes(model, false, ground_memory(params, model)), &ground->slots));
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		ground->tiles[k] = (struct tile_slot){{0, (uint32_t)params->first + k % params->tiles, (uint32_t)params->first + k / params->tiles}, k};
		ground_fill(ground, k);
	}
	struct deform_params deform = {
		.extent = &ground->extent, .reference = params->reference, .model = model, .box_radius = 1, .box_repetitions = 1, .soil_count = 1,
		.iterations = params->iterations != 0 ? params->iterations : 4, .along_lines = params->lines, .relief = (double)INFINITY,
		.depth = params->depth != 0 ? params->depth : model == DEFORM_SCM ? 0 : (double)INFINITY, .undisturbed_stable = params->stands,
		.bulldozing = params->bulldozing, .slip_sinkage = params->slip_sinkage, .loosening = params->loosening, .hardening = params->hardening,
		.ground_normals = params->ground_normals,
		.thrown = params->thrown, .gravity = 9.81, .loaded_bodies = params->loaded_bodies,
	};
	assert_ok(soil_named("dry_sand", &deform.soils[0]));
	if (params->soils != NULL)
		deform.soils[0] = *params->soils;
	assert_ok(bearing_create(&deform, ground->slots, &ground->bearing));
}

static inline void ground_finish(struct ground *ground)
{
	bearing_destroy(ground->bearing);
	resident_host_destroy(ground->slots);
	mem_free(ground->tiles);
}

/* As it was before anything drove on it. */
static inline void ground_reset(struct ground *ground)
{
	for (uint32_t k = 0; k < ground->tile_count; k++)
		resident_host_tile_drop(ground->slots, &host_entry(ground->slots, k)->tile, ~0u);
	bearing_forget_active(ground->bearing);
}

/* A contact. Returns its forces; those of a body over no post of the world are 0, at the height of its pose. */
static inline struct deform_forces ground_forces(struct ground *ground, const struct deform_contact *contact)
{
	assert_ok(bearing_area(ground->bearing, contact, &ground->area));
	ground->done = (struct bearing_contact){.contact = contact, .area = ground->area, .forces = {.z = contact->to.z, .state = DEFORM_AIR}};
	if (post_rect_empty(ground->area.write))
		return ground->done.forces;
	assert_ok(bearing_contact_alone(ground->bearing, &ground->done, ground->tiles, ground->tile_count));
	return ground->done.forces;
}

/* An interval of relaxation with these bodies at rest on the ground. Returns how many blocks were active. */
static inline size_t ground_interval(struct ground *ground, const struct deform_rest *bodies, size_t count)
{
	struct bearing *bearing = ground->bearing;
	struct bearing_interval interval;
	assert_ok(bearing_interval_begin(bearing, bodies, count, &interval));
	for (size_t i = 0; i < interval.regions; i++) {
		assert_ok(bearing_interval_start(bearing, i));
		bearing_interval_gather(bearing, ground->tiles, ground->tile_count);
		assert_ok(bearing_interval_slide(bearing, i));
	}
	for (size_t i = 0; i < interval.regions; i++)
		assert_ok(bearing_interval_scatter(bearing, i, ground->tiles, ground->tile_count));
	if (interval.blocks > 0)
		assert_ok(bearing_interval_end(bearing));
	return interval.blocks;
}

/* Returns one plane of the block as int32; posts that tiles share must be the same in all of them. Freed by the caller. */
static inline int32_t *ground_plane(struct ground *ground, enum plane plane)
{
	const int64_t cells = ground->params.cells, side = cells + 1;
	int32_t *all = ground_room(ground->posts * ground->posts, sizeof *all);
	bool *known = ground_room(ground->posts * ground->posts, sizeof *known);
	for (uint32_t k = 0; k < ground->tile_count; k++) {
		const int32_t *posts = host_tile_plane(ground->slots, &host_entry(ground->slots, k)->tile, plane);
		for (int64_t i = 0; i < side * side; i++) {
			const int64_t at = (k / ground->params.tiles * cells + i / side) * ground->posts + k % ground->params.tiles * cells + i % side;
			const int32_t value = posts != NULL ? posts[i] : 0;
			assert_true(!known[at] || all[at] == value);
			known[at] = true;
			all[at] = value;
		}
	}
	mem_free(known);
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

/* Law 5: what left the offsets was compacted, to the unit. */
static inline void ground_lost_nothing(struct ground *ground)
{
	struct deform_tally tally;
	bearing_tally(ground->bearing, &tally);
	assert_true(ground_sum(ground, PLANE_OFFSET) + tally.compacted == 0);
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

/* A body that is set down there and does not move. */
static inline struct deform_contact ground_stand(const struct ground *ground, const struct soil_shape *shape, double x, double y, double z)
{
	struct soil_pose pose = ground_pose(ground, x, y, z);
	return (struct deform_contact){.shape = shape, .from = pose, .to = pose};
}

/* Goes on by a way, m. */
static inline void ground_go(struct deform_contact *contact, double east, double north, double up)
{
	contact->from = contact->to;
	contact->to.x += lattice_offset(east);
	contact->to.y += lattice_offset(north);
	contact->to.z += lattice_offset(up);
}

/* Turns a vector into the frame of a body that looks along `yaw`. */
static inline void ground_into(double yaw, double v[3])
{
	const double east = v[0], north = v[1];
	v[0] = cos(yaw) * east + sin(yaw) * north;
	v[1] = cos(yaw) * north - sin(yaw) * east;
}

#endif
