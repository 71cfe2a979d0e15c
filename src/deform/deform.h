/*
 * deform: what an object does to the ground, on the GPU, in the dissertation's four stages over one
 * window: gather, displace, redistribute, scatter (with attributes). SOIL.md says what happens in which.
 *
 * Results are integers and the same on every driver: an object's underside is evaluated at each
 * post from affine functionals of the post's place in the window (shape/affine.h), in 64-bit
 * fixed point. They do not depend on tiles: a window knows only global posts. For the GPU's thread.
 */
#ifndef FURROW_DEFORM_H
#define FURROW_DEFORM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "gpu/gpu.h"

enum deform_shape_kind { DEFORM_WHEEL, DEFORM_SPHERE, DEFORM_BOX, DEFORM_MESH, DEFORM_SHAPES };

/* Triangles in the object's own axes, metres. Owned by whoever made it; outlives every use. */
struct deform_mesh {
	float (*vertices)[3];
	uint32_t (*triangles)[3]; /* indices into vertices; either way round */
	uint32_t vertex_count, triangle_count;
	double low[3], high[3];   /* of the vertices */
};

struct deform_shape {
	enum deform_shape_kind kind;
	double radius;  /* wheel, sphere: metres */
	double width;   /* wheel: metres along its axis */
	double size[3]; /* box: metres along its own x (forward), y (left), z (up) */
	int lugs;       /* wheel: bars across its rim, evenly spaced, that turn with it; 0: smooth */
	double lug_height, lug_thickness; /* metres beyond the radius, and along the rim */
	const struct deform_mesh *mesh;
};

/* The object's centre, and its attitude: yaw about z from east to north, then pitch (nose up), then
 * roll (right side down), radians. A wheel's axis is its own y; it rolls along its own x. `turn`: how
 * far a wheel has turned about it, forwards, radians: where its lugs are. */
struct deform_pose {
	int64_t x, y, z; /* 2^-20 m from the south-west post; z absolute */
	double yaw, pitch, roll, turn;
};

/* A translation with the attitude of `to`. A first contact has from == to. */
struct deform_sweep {
	const struct deform_shape *shape;
	struct deform_pose from, to;
	double seconds; /* that it took; 0: none, no rate counts */
	double turned;  /* wheel: radians about its axis meanwhile (slip 0: way / radius) */
	double load;    /* N, downwards; 0: to.z is prescribed. Otherwise to.z is about where it will stand */
	uint32_t carrier; /* with a load: which of params.carriers it is, from 1; 0: nobody asks where it stands afterwards */
	bool above;      /* of all ground in its windows as it was, by more than its underside is rounded by */
	uint64_t tag;    /* not 0: its forces are summed, and told by deform_forces_take under this tag */
};

enum deform_model { DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SUMNER, DEFORM_SLIPPAGE, DEFORM_SCM, DEFORM_MODELS };

/* One class of soil, SI, angles in radians. Ranges: scene. NAN: the soil has no such number; no model may read it. */
struct deform_soil {
	double bekker_kc, bekker_kphi, bekker_n; /* N/m^(n+1), N/m^(n+2), 1 */
	double cohesion, friction_angle;         /* Pa, rad */
	double janosi_shear;                     /* K, m */
	double elastic_stiffness, damping;       /* Pa/m, Pa s/m */
	double unit_weight;                      /* N/m3 */
	/* Sumner's: angles in rad; shares of 1. */
	double theta_in, theta_out, theta_stop, roughness, compression;
	double repose; /* rad: scm's heaped soil stands at this */
};
#define DEFORM_SOILS 16

/* A soil that has no number at all. */
void deform_soil_clear(struct deform_soil *soil);
/* The name of a named soil, index 0, 1, ...; NULL beyond the last. */
const char *deform_soil_name(size_t index);
/* The numbers of a named soil: Wong's, Sumner's, or both. STATUS_INPUT, with all names, if there is no such soil. */
enum status deform_soil_named(const char *name, struct deform_soil *soil) FURROW_CHECKED;

struct deform_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent; /* must outlive the deform */
	int level;                 /* the working level */
	int32_t reference;         /* metres: of the bases in the slots */
	enum deform_model model;
	int box_radius;      /* posts, 1 .. 4 */
	int box_repetitions; /* 1 .. 8 */
	/* Conserving models: */
	struct deform_soil soils[DEFORM_SOILS];
	int soil_count;      /* 1, or as many as the slots' class planes tell apart */
	int iterations;      /* of sliding: a sweep's, and an interval's; 1 .. 8 */
	double relief;       /* metres between the world's lowest and highest post; INFINITY: not known */
	double depth;        /* metres of loose soil below the base; INFINITY: no bottom */
	double tolerance;    /* metres, 0 .. 1: nothing slides between two posts that are steeper than stands by this or less */
	bool stands;         /* nothing slides off ground that is as it was: only where a post has risen over its neighbour,
			      * or that has sunk. Otherwise the caller must have woken all that is steep */
	double bulldozing;   /* scm: share of the plastic flow that is laid on the ring, 0 .. 1 */
	bool touched;        /* deform_is_touched will be asked; with `stands`, of models that conserve */
	uint32_t carriers;   /* scm: objects that carry a load and rest on the ground meanwhile */
	bool dirt;
};

/* The planes that a model keeps: a mask of PLANE_BIT. */
unsigned deform_planes(enum deform_model model, bool dirt);

/* Whether it moves soil, and loses none but what is compacted. */
bool deform_conserves(enum deform_model model);

struct deform;

/* STATUS_INPUT, with the limit, if the shape cannot be simulated at this spacing. */
enum status deform_shape_check(const struct deform_shape *shape, double spacing) FURROW_CHECKED;
/* However it is turned, the object lies within this of its centre, metres. */
double deform_shape_bound(const struct deform_shape *shape);
/* The object's own axes in a pose, forward, left and up, of length 1: with `turn` about its own left. */
void deform_axes(double yaw, double pitch, double roll, double turn, double axes[3][3]);
/* Height of the lowest point below the centre for this attitude, metres (positive). */
double deform_shape_reach(const struct deform_shape *shape, double pitch, double roll);

/* About how deep the object sinks under a load, m: a wheel by Bekker's formula for one that is towed, others as plates.
 * For where to begin looking. */
double deform_sinkage_guess(const struct deform_shape *shape, const struct deform_soil *soil, double load);

enum status deform_create(const struct deform_params *params, struct deform **out) FURROW_CHECKED;
void deform_destroy(struct deform *deform);

/* The posts one sweep changes (`write`) and those it reads to do so. At most DEFORM_WINDOW_POSTS a
 * side; a larger object takes several windows, cut on a rule of global posts. */
#define DEFORM_WINDOW_POSTS 256
#define DEFORM_WINDOWS_MAX 16
struct deform_window {
	struct post_rect read, write;
};
/* Whether it is no motion: its end pose alone presses then. */
bool deform_is_contact_only(const struct deform_sweep *sweep);
/* 0 windows: the sweep lies outside the world. STATUS_INPUT: more than DEFORM_WINDOWS_MAX needed, or a
 * wheel whose axis is not level (roll). */
enum status deform_windows(struct deform *deform, const struct deform_sweep *sweep,
			   struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* The same for a deform of these parameters (gpu and slots may be NULL), but that no room is made for the windows. Pure. */
enum status deform_cut(const struct deform_params *params, const struct deform_sweep *sweep,
		       struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* A resident, pinned tile of the working level. */
struct deform_tile {
	struct tile tile;
	uint32_t slot;
};

/* Gather, displace, redistribute: into the window's own layer. `tiles`: all that hold a post of
 * `read`. Nothing is changed in them. */
enum status deform_compute(struct deform *deform, const struct deform_sweep *sweep,
			   const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;
/* DEFORM_SCM: only the forces of a sweep with a tag, over one of its windows, as deform_compute would find them. Changes nothing, the
 * tally neither; there is nothing to scatter. */
enum status deform_feel(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window, uint32_t layer,
			const struct deform_tile *tiles, size_t count) FURROW_CHECKED;
/* An object as far as what it makes and runs depends on it. */
struct deform_planned {
	const struct deform_shape *shape;
	double load; /* N; of DEFORM_SCM: not 0: it asks for its forces too, which tell where it stands */
	bool moves;  /* it is ever elsewhere than where it was set down */
};
/* Links all that sweeps of this object, and its rest, can ask for, and nothing else, and runs it over a window beyond
 * the world: a driver's first draw of a program can take a tenth of a second. Changes nothing. `forces`: of every object
 * some sweeps have tags; otherwise of those with loads alone; the same at each call. What was warmed is not again. */
enum status deform_warm(struct deform *deform, const struct deform_planned *object, bool forces) FURROW_CHECKED;
/* Scatter `write` to every tile that holds a post of it; gives them deform slots. */
enum status deform_scatter(struct deform *deform, const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;

/*
 * Awake blocks: where the ground may slide on. Time and again (SOIL.md) the whole lattice makes `iterations`
 * iterations of the sliding rule; only blocks of DEFORM_BLOCK x DEFORM_BLOCK posts that are awake are worked on. They are a
 * superset of those that change, so what the ground becomes does not depend on which they are. Of models that
 * conserve; for others nothing is ever awake.
 */
#define DEFORM_BLOCK 32
#define DEFORM_BLOCKS_MAX 16384
struct deform_block {
	int64_t x, y; /* posts / DEFORM_BLOCK */
};
/* Those posts have changed, or what held them has gone. */
enum status deform_wake(struct deform *deform, struct post_rect changed) FURROW_CHECKED;
/* The posts of all blocks that are woken then. */
struct post_rect deform_wakes(const struct deform *deform, struct post_rect changed);
/* A window was computed and scattered, the last one that was computed: only where it left soil moving stays awake. Of a
 * sweep of several windows: as deform_wake. What the object rested on before must be covered (below). */
enum status deform_wake_swept(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* Whether the sweep looks at all that an object rests on in a pose, and around it: then nothing need be woken for its being
 * there no more. */
bool deform_covers(const struct deform *deform, const struct deform_sweep *sweep, const struct deform_pose *rest);
/*
 * Touched posts: those whose planes may be other than they were when the deform was made, and those that somebody named. A
 * superset, of deforms whose parameters ask for it: what scattered sweeps wrote, and what soil can have come to by sliding.
 * Where a sweep is one window, and of what slid, only parts of blocks that were changed, once the GPU has said so.
 */
enum status deform_touch(struct deform *deform, struct post_rect rect) FURROW_CHECKED;
enum status deform_is_touched(struct deform *deform, struct post_rect rect, bool *is) FURROW_CHECKED;
enum status deform_wake_block(struct deform *deform, struct deform_block block) FURROW_CHECKED; /* inside the world */
/* All that are awake, in an order that they alone decide; valid until the next call. STATUS_FAILED: more than
 * DEFORM_BLOCKS_MAX. Hardly ever waits. */
enum status deform_awake(struct deform *deform, const struct deform_block **blocks, size_t *count) FURROW_CHECKED;

/* An object where its last station put it. */
struct deform_rest {
	const struct deform_shape *shape;
	struct deform_pose pose;
	uint32_t carrier; /* not 0: it stands where the last sweep of this carrier found it to, about this pose */
};
/* Of a carrier of which there was no sweep yet: it stands so many quanta above its pose. */
void deform_stands(struct deform *deform, uint32_t carrier, int32_t raised);
/* One interval: begin; gather each of `count` blocks; only then scatter each; end. Nothing to do if there are none. The
 * objects stay the caller's until the end; what they rest on is held. */
enum status deform_interval_begin(struct deform *deform, const struct deform_rest *objects, size_t object_count,
				  size_t *count) FURROW_CHECKED;
struct post_rect deform_interval_reads(const struct deform *deform, size_t block);
struct post_rect deform_interval_writes(const struct deform *deform, size_t block);
/* `tiles`: all that hold a post of what it reads, or writes. In the order of blocks. */
enum status deform_interval_gather(struct deform *deform, size_t block, const struct deform_tile *tiles,
				   size_t count) FURROW_CHECKED;
enum status deform_interval_scatter(struct deform *deform, size_t block, const struct deform_tile *tiles,
				    size_t count) FURROW_CHECKED;
enum status deform_interval_end(struct deform *deform) FURROW_CHECKED;
/* Posts along a side of what a block reads, at most, for a deform of these parameters. Pure. */
int64_t deform_interval_side(const struct deform_params *params);

/*
 * What deformation makes and runs, before it does: lines (base/plan.h) for a deform of these parameters, once it was warmed
 * with each of the objects. `params`: gpu and slots may be NULL; world too: then every object fits one window. Pure.
 *
 * Passes are per object and PLAN_WINDOW or PLAN_MOVED; of PLAN_FACETS, PLAN_HELD, PLAN_RESTING and PLAN_ATLAS of all
 * objects at once (-1), as deform_figures counts them.
 */
void deform_plan(const struct deform_params *params, const struct deform_planned *objects, size_t count, bool forces,
		 struct plan *plan);
/* The units that deform counts: layers there ever were at once (without the atlas'); draws, since the start but for what
 * warming ran. */
struct deform_figures {
	uint64_t window_layers, result_layers;
	uint64_t facets;   /* draws of triangles */
	uint64_t held;     /* blocks over which an object at rest was laid */
	uint64_t resting;  /* windows drawn for that, of closed forms: triangles are in `facets` */
	uint64_t atlases;
};
void deform_figures(const struct deform *deform, struct deform_figures *figures);

/* What is counted on the GPU since the start. */
struct deform_tally {
	int64_t compacted; /* quanta summed over posts: what conserving models lost for good */
	uint64_t refused;  /* posts that would have gone beyond an offset's range */
	uint64_t confined; /* posts whose soil found no free post, and was compacted */
};
/* Blocks: at the end. */
enum status deform_tally(struct deform *deform, struct deform_tally *tally) FURROW_CHECKED;
/* The same as bytes, without waiting: sizeof(struct deform_tally), as gpu_buffer_read_into. */
/* Goes back to a tally, and to no awake block; waits for what is under way. Touched posts stay touched. */
enum status deform_restore(struct deform *deform, const struct deform_tally *tally) FURROW_CHECKED;
void deform_tally_read_into(struct deform *deform, struct gpu_staging *staging, size_t offset);

/* What the soil does to an object: of a sweep with a tag, under DEFORM_SCM. Summed in whole numbers over the posts it
 * rests on at the sweep's end, each rounded to 1/16 Pa times its area. */
struct deform_forces {
	uint64_t tag;
	double force[3];      /* N on the object: east, north, up */
	double moment[3];     /* N m about its centre */
	double sinkage;       /* m: the deepest it rests below the undisturbed surface */
	double area;          /* m2 of posts it rests on */
	int64_t z;            /* 2^-20 m: of its centre; with a load, where it was found to stand */
	uint32_t saturated;   /* posts whose share exceeded 2^31 sixteenths of a pascal, and count as that */
	bool sunk;            /* the soil does not carry the load: it is as deep as it is high (a mesh: as large) */
};
/* Begins to bring what was summed since the last call; does not wait. */
enum status deform_forces_begin(struct deform *deform) FURROW_CHECKED;
/* The next of what was begun, in the order of the sweeps. *taken false: there is none, or (unless `wait`) it is not there
 * yet. */
enum status deform_forces_take(struct deform *deform, bool wait, struct deform_forces *forces,
			       bool *taken) FURROW_CHECKED;

#endif
