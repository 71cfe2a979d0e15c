/*
 * deform: changes the ground under an object, on the GPU. It runs the dissertation's four stages over one window: gather,
 * displace, redistribute, scatter (with attributes). SOIL.md describes each stage.
 *
 * Results are integers and the same on every driver. The lower envelope of an object is evaluated at each post in 64-bit fixed
 * point. It comes from affine functionals of the post's place in the window (shape/affine.h). Results do not depend on tiles, since a
 * window knows only global posts. For the GPU's thread.
 */
#ifndef FURROW_DEFORM_H
#define FURROW_DEFORM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/effect.h"
#include "gpu/gpu.h"

enum deform_shape_kind { DEFORM_WHEEL, DEFORM_SPHERE, DEFORM_BOX, DEFORM_MESH, DEFORM_SHAPES };

/* Triangles in the object's own axes, metres. Its maker owns it. It must outlive every use. */
struct deform_mesh {
	float (*vertices)[3];
	uint32_t (*triangles)[3]; /* indices into vertices; clockwise or not */
	uint32_t vertex_count, triangle_count;
	double low[3], high[3];   /* bounds of the vertices */
};

struct deform_shape {
	enum deform_shape_kind kind;
	double radius;  /* wheel, sphere: metres */
	double width;   /* wheel: metres along its axis */
	double size[3]; /* box: metres along its own x (forward), y (left), z (up) */
	int grousers;       /* wheel: grousers, evenly spaced bars across the rim that turn with it; 0: a smooth wheel */
	double grouser_height, grouser_thickness; /* of a grouser, metres: beyond the radius, and along the rim */
	const struct deform_mesh *mesh;
};

/* The object's centre and attitude, in radians: yaw about z from east to north, then pitch (nose up), then roll (right side
 * down). A wheel's axis is its own y; it rolls along its own x. `turn`: how far a wheel has turned forwards about its axis,
 * radians. It decides where the grousers are. */
struct deform_pose {
	int64_t x, y, z; /* 2^-20 m from the south-west post; z absolute */
	double yaw, pitch, roll, turn;
};

/* A contact: the object moves straight from `from` to `to` with the attitude of `to`. A first contact has from == to. */
struct deform_contact {
	const struct deform_shape *shape;
	struct deform_pose from, to;
	double seconds; /* s of the motion; 0: no rates are used */
	double turned;  /* wheel: radians turned about its axis during the motion (slip 0: distance / radius) */
	double load;    /* N, downwards; 0: to.z is given. Otherwise to.z is near the equilibrium height, which is searched */
	uint32_t loaded_body; /* with a load: number of the loaded body, 1 to params.carriers; 0: its equilibrium height is not kept */
	/* the object is above all ground in its windows before the contact, by more than the rounding of its lower envelope */
	bool above;
	uint64_t tag;    /* not 0: its forces are summed, and deform_forces_take tells them under this tag */
};

/*
 * The soil models. A model is one C file in src/deform/soil, which defines its row, and one line of DEFORM_MODELS_EACH. Code
 * outside of that folder asks the row what the model does, and names no model.
 *
 * Every model: its number, and its name in a scene. Its row is `deform_model_NAME`. Numbers are in the hashes of scenes, so a
 * new model comes last.
 */
#define DEFORM_MODELS_EACH(MODEL) \
	MODEL(DEFORM_NONE, none) \
	MODEL(DEFORM_BOX_FILTER, box) \
	MODEL(DEFORM_SUMNER, sumner) \
	MODEL(DEFORM_SLIPPAGE, slippage) \
	MODEL(DEFORM_SCM, scm)

#define DEFORM_MODEL_NUMBER(number, word) number,
enum deform_model { DEFORM_MODELS_EACH(DEFORM_MODEL_NUMBER) DEFORM_MODELS };
#undef DEFORM_MODEL_NUMBER
#define DEFORM_MODEL_DEFAULT ((enum deform_model)0) /* of a scene without `redistribute` */

struct deform;
struct deform_soil;
struct deform_window;
struct soil_slide; /* in which way soil slides: src/deform/internal.h */

/* Runs a model over one window whose lower envelope is known. */
typedef enum status (*soil_contact_fn)(struct deform *deform, const struct deform_contact *contact,
				       const struct deform_window *window, uint32_t layer);

/* One soil model. Members that are left out are false, 0 or NULL. */
struct soil_model {
	const char *name; /* in a scene */
	/* For the pages: what the ground does under it, and what becomes of the volume. */
	const char *use, *volume;
	struct effect_row effect; /* its own effect, as `furrow explain` tells it */
	const char *contact_effect; /* name of the effect of its contact; NULL: its own. A name that is not its own is of another
				     * model, whose contact it shares */
	const char *touched_effect; /* name of the effect that asks which posts were touched; NULL: its own */

	/* What a scene says. Both lists are NULL-terminated; a list that is NULL is empty. */
	const char *const *keys;    /* keys of `redistribute` that it takes, beside `model` */
	const char *const *numbers; /* numbers of a soil that it reads, by their keys; without any it needs no soil */
	double depth;               /* the default of `depth`, metres */

	/* What it does. */
	soil_contact_fn contact; /* changes the ground */
	soil_contact_fn feel;    /* computes the forces on the object alone; NULL: it tells none, and takes no load and no slip */
	const char *shader;      /* of its contact */
	unsigned planes;         /* that it keeps beside the offset: a mask of PLANE_BIT */
	bool blind;              /* it needs not know which posts were touched */
	bool in_place;           /* its contact changes the planes where they are, and looks only at posts below the object */
	bool contact_soils;      /* the shader of its contact reads the soils' numbers: it gets the define SOILS */
	bool smooths;            /* it smooths the trail of an object that moves, by the keys `radius` and `repetitions` */
	const struct soil_slide *slide; /* how its soil slides; NULL: it does not, and soil is lost. Otherwise it moves soil, and loses
					 * only what is compacted */
	/* Computes the critical height difference of a soil between two posts `apart` metres apart, fixed-point units. For sliding by
	 * excess. */
	int32_t (*critical)(const struct deform_soil *soil, double apart);
};

/* Returns the row of a model. */
const struct soil_model *deform_model_row(enum deform_model model);

/* Returns true if the model takes this key of `redistribute`. */
bool deform_model_takes(enum deform_model model, const char *key);
/* Returns true if the model reads this number of a soil. */
bool deform_model_reads(enum deform_model model, const char *number);
/* Returns true for a model that moves soil and loses only what is compacted. */
bool deform_conserves(enum deform_model model);
/* Returns true for a model that tells the forces on an object. Only such a model can carry a load. */
bool deform_tells_forces(enum deform_model model);
/* Each returns the name of an effect, which calls for what all objects need under the model. The first is of contacts, the second
 * of soil that slides (NULL: none does). The third is of the textures that tell what an object touched. */
const char *deform_displace_effect(enum deform_model model);
const char *deform_slide_effect(enum deform_model model);
const char *deform_contact_effect(enum deform_model model);

/* The numbers of one soil, SI, angles in radians. The scene checks ranges. NAN: the soil has no such number, and no model may
 * read it. */
struct deform_soil {
	double bekker_kc, bekker_kphi, bekker_n; /* N/m^(n+1), N/m^(n+2), 1 */
	double cohesion, friction_angle;         /* Pa, rad */
	double janosi_shear;                     /* K, m */
	double elastic_stiffness, damping;       /* Pa/m, Pa s/m */
	double unit_weight;                      /* N/m3 */
	/* Sumner's model: angles in rad; shares of 1. */
	double theta_in, theta_out, theta_stop, roughness, compression;
	double repose; /* rad: model scm: angle of repose of deposited soil */
};
#define DEFORM_SOILS 16

/* Sets every number to NAN. */
void deform_soil_clear(struct deform_soil *soil);
/* Returns the name of a named soil, index 0, 1, ...; NULL beyond the last. */
const char *deform_soil_name(size_t index);
/* Fills the numbers of a named soil: Wong's, Sumner's, or both. STATUS_INPUT, with all names: there is no such soil. */
enum status deform_soil_named(const char *name, struct deform_soil *soil) FURROW_CHECKED;

struct deform_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent; /* must outlive the deform */
	int level;                 /* the working level */
	int32_t reference;         /* metres: reference of the bases in the slots */
	enum deform_model model;
	int box_radius;      /* posts, 1 .. 4 */
	int box_repetitions; /* 1 .. 8 */
	/* For models that conserve soil: */
	struct deform_soil soils[DEFORM_SOILS];
	int soil_count;      /* 1, or the number of classes in the slots' class planes */
	int iterations;      /* relaxation iterations of a contact and of an interval; 1 .. 8 */
	double relief;       /* metres between the world's lowest and highest post; INFINITY: not known */
	double depth;        /* metres of soil below the base that can relax; INFINITY: no bottom */
	/* metres, 0 .. 1: soil slides between two posts only if their difference exceeds the critical one by more than this */
	double tolerance;
	/* undisturbed ground is stable: soil slides only from a post that has risen above its neighbour, or to one that has
	 * sunk. Otherwise the caller must have activated all steep ground */
	bool undisturbed_stable;
	double bulldozing;   /* scm: share of the plastic flow that is deposited on the ring, 0 .. 1 */
	bool touched;        /* deform_is_touched will be called; needs `undisturbed_stable` and a model that conserves soil */
	uint32_t loaded_bodies;   /* scm: number of objects that carry a load and rest on the ground between contacts */
	bool disturbance;    /* keep the disturbance plane */
};

/* Returns the planes that a model keeps, a mask of PLANE_BIT. */
unsigned deform_planes(enum deform_model model, bool disturbance);

struct deform;

/* Checks a shape. STATUS_INPUT, with the limit: it cannot be simulated at this spacing. */
enum status deform_shape_check(const struct deform_shape *shape, double spacing) FURROW_CHECKED;
/* Returns a distance from the object's centre that holds the whole object in any attitude, metres. */
double deform_shape_bound(const struct deform_shape *shape);
/* Computes the object's own axes in a pose: forward, left and up, unit vectors, with `turn` about its own left. */
void deform_axes(double yaw, double pitch, double roll, double turn, double axes[3][3]);
/* Returns the height of the centre above the object's lowest point in this attitude, metres, positive. */
double deform_shape_reach(const struct deform_shape *shape, double pitch, double roll);

/* Returns about how deep the object sinks under a load, m, as the start of a search. A wheel: Bekker's formula for a towed
 * wheel. Other shapes: as plates. */
double deform_sinkage_guess(const struct deform_shape *shape, const struct deform_soil *soil, double load);

enum status deform_create(const struct deform_params *params, struct deform **out) FURROW_CHECKED;
void deform_destroy(struct deform *deform);

/* The posts that one contact changes (`write`), and those it reads for this (`read`). At most DEFORM_WINDOW_POSTS a side. A
 * larger object gets several windows, cut at fixed global posts. */
#define DEFORM_WINDOW_POSTS 256
#define DEFORM_WINDOWS_MAX 16
struct deform_window {
	struct post_rect read, write;
};
/* Returns true if the contact has no motion. Then only its end pose acts on the ground. */
bool deform_is_contact_only(const struct deform_contact *contact);
/* Finds the windows of a contact. *count 0: it lies outside the world. STATUS_INPUT: it needs more than DEFORM_WINDOWS_MAX, or
 * a wheel's axis is not level (roll). */
enum status deform_windows(struct deform *deform, const struct deform_contact *contact,
			   struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* Finds the same windows from parameters alone, and makes no memory for them. gpu and slots may be NULL. Pure. */
enum status deform_cut(const struct deform_params *params, const struct deform_contact *contact,
		       struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* A resident, pinned tile of the working level. */
struct deform_tile {
	struct tile tile;
	uint32_t slot;
};

/* Gathers, displaces and redistributes, into the window's own layer. `tiles`: all that hold a post of `read`. They do not
 * change. */
enum status deform_compute(struct deform *deform, const struct deform_contact *contact,
			   const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;
/* For a model that tells forces: computes only the forces of a contact with a tag, over one window, as deform_compute would.
 * Changes nothing, not even the tally. Do not scatter after it. */
enum status deform_feel(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer,
			const struct deform_tile *tiles, size_t count) FURROW_CHECKED;
/* The facts about an object that decide its resources and passes. */
struct deform_planned {
	const struct deform_shape *shape;
	double load; /* N; not 0, and the model tells forces: its forces are computed too, since they tell its equilibrium height */
	bool moves;  /* it moves after it was set down */
};
/* Links the programs that contacts of this object, and its rest, can need, and no others. Runs each over a window outside the
 * world, since a driver's first draw of a program can take a tenth of a second. Changes nothing. `forces`: contacts of every
 * object may have tags; otherwise only those with loads; the same at each call. A program that was warmed is not warmed again. */
enum status deform_warm(struct deform *deform, const struct deform_planned *object, bool forces) FURROW_CHECKED;
/* Copies `write` to every tile that holds a post of it, and gives these tiles deform slots. */
enum status deform_scatter(struct deform *deform, const struct deform_window *window, uint32_t layer,
			   const struct deform_tile *tiles, size_t count) FURROW_CHECKED;

/*
 * Active blocks: blocks where soil may still relax. In intervals (SOIL.md) the whole lattice makes `iterations` iterations of
 * the relaxation rule. Only active blocks of DEFORM_BLOCK x DEFORM_BLOCK posts are computed. They include all blocks that
 * change. So the result does not depend on which blocks are active. Only models that conserve soil have active blocks.
 */
#define DEFORM_BLOCK 32
#define DEFORM_BLOCKS_MAX 16384
struct deform_block {
	int64_t x, y; /* posts / DEFORM_BLOCK */
};
/* Makes blocks active: these posts changed, or the object that held them has gone. */
enum status deform_wake(struct deform *deform, struct post_rect changed) FURROW_CHECKED;
/* Returns the posts of all blocks that deform_wake makes active for this change. */
struct post_rect deform_wakes(const struct deform *deform, struct post_rect changed);
/* Call after the last computed window was scattered. Only blocks where soil still moves stay active. A contact of several
 * windows makes blocks active as deform_wake does. The window must cover what the object rested on before (deform_covers). */
enum status deform_wake_swept(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* Returns true if the contact reads everything that the object rests on in a pose, and around it. Then nothing need be made
 * active when the object leaves that pose. */
bool deform_covers(const struct deform *deform, const struct deform_contact *contact, const struct deform_pose *rest);
/*
 * Touched posts: posts whose planes may have changed since the deform was made, and posts named with deform_touch. Only if the
 * parameters ask for it. They include posts that contacts wrote, and posts that sliding soil can have reached. After a contact
 * of one window, and after sliding, only parts of blocks that changed are included, once the GPU has reported them.
 */
enum status deform_touch(struct deform *deform, struct post_rect rect) FURROW_CHECKED;
enum status deform_is_touched(struct deform *deform, struct post_rect rect, bool *is) FURROW_CHECKED;
enum status deform_wake_block(struct deform *deform, struct deform_block block) FURROW_CHECKED; /* the block must lie inside the world */
/* Tells all active blocks, in an order that depends on these blocks alone. Valid until the next call. STATUS_FAILED: more than
 * DEFORM_BLOCKS_MAX. Rarely waits. */
enum status deform_active_blocks(struct deform *deform, const struct deform_block **blocks, size_t *count) FURROW_CHECKED;

/* An object at rest, where its last path sample put it. */
struct deform_rest {
	const struct deform_shape *shape;
	struct deform_pose pose;
	/* not 0: it is at the equilibrium height that the last contact of this loaded body found, relative to this pose */
	uint32_t loaded_body;
};
/* Sets the equilibrium height of a loaded body that had no contact yet. `raised`: above its pose, 2^-20 m. */
void deform_set_equilibrium(struct deform *deform, uint32_t loaded_body, int32_t raised);
/* One interval: begin; gather each of `count` blocks; then scatter each; end. Does nothing without blocks. The objects stay the
 * caller's, and must live until the end. The ground that they rest on is held. */
enum status deform_interval_begin(struct deform *deform, const struct deform_rest *objects, size_t object_count,
				  size_t *count) FURROW_CHECKED;
struct post_rect deform_interval_reads(const struct deform *deform, size_t block);
struct post_rect deform_interval_writes(const struct deform *deform, size_t block);
/* `tiles`: all that hold a post that the block reads, or writes. Call in the order of blocks. */
enum status deform_interval_gather(struct deform *deform, size_t block, const struct deform_tile *tiles,
				   size_t count) FURROW_CHECKED;
enum status deform_interval_scatter(struct deform *deform, size_t block, const struct deform_tile *tiles,
				    size_t count) FURROW_CHECKED;
enum status deform_interval_end(struct deform *deform) FURROW_CHECKED;
/* Returns the most posts that a block reads along a side, for these parameters. Pure. */
int64_t deform_interval_side(const struct deform_params *params);

/*
 * Adds the plan's lines (base/plan.h) of a deform of these parameters, warmed with each of the objects. `params`: gpu and slots
 * may be NULL; the extent too, and then every object fits one window. Pure.
 *
 * Passes are by object for PLAN_WINDOW and PLAN_MOVED. For PLAN_FACETS, PLAN_HELD, PLAN_RESTING and PLAN_ATLAS they are for all
 * objects together (-1), as deform_figures counts them.
 */
void deform_plan(const struct deform_params *params, const struct deform_planned *objects, size_t count, bool forces,
		 struct plan *plan);
/* The units that deform counts. Layers: the most that existed at once, without the atlas'. Draws: since the start, without
 * those of warming. */
struct deform_figures {
	uint64_t window_layers, result_layers;
	uint64_t facets;   /* draws of an object's triangles */
	uint64_t held;     /* blocks on which an object at rest was drawn */
	uint64_t resting;  /* windows drawn for that, of closed forms; triangles are counted in `facets` */
	uint64_t atlases;
};
void deform_figures(const struct deform *deform, struct deform_figures *figures);

/* Counts made on the GPU since the start. */
struct deform_tally {
	int64_t compacted; /* soil that conserving models compacted: 2^-20 m, summed over posts */
	uint64_t refused;  /* posts where the change would have left the range of an offset */
	uint64_t confined; /* posts whose soil found no free post around, and was compacted */
};
/* Reads the tally. Waits for the GPU. For the end of a drive. */
enum status deform_tally(struct deform *deform, struct deform_tally *tally) FURROW_CHECKED;
/* Sets the tally back, and makes every block inactive. Waits for the work in flight. Touched posts stay touched. */
enum status deform_restore(struct deform *deform, const struct deform_tally *tally) FURROW_CHECKED;
/* Begins to read the tally as bytes, as gpu_buffer_read_into does: sizeof(struct deform_tally). Does not wait. */
void deform_tally_read_into(struct deform *deform, struct gpu_staging *staging, size_t offset);

/* The forces of the soil on an object, for a contact with a tag, under a model that tells forces. They are sums of whole numbers
 * over the posts that carry it at the contact's end. Each share is rounded to 1/16 Pa times the post's area. */
struct deform_forces {
	uint64_t tag;
	double force[3];      /* N on the object: east, north, up */
	double moment[3];     /* N m about its centre */
	double sinkage;       /* m: its greatest depth below the undisturbed surface */
	double area;          /* m2: area of the posts that carry it */
	int64_t z;            /* 2^-20 m: height of its centre; with a load, the equilibrium height */
	uint32_t saturated;   /* posts whose share exceeded 2^31 sixteenths of a pascal, and was cut to that */
	bool sunk;            /* the soil does not carry the load: it sank as deep as its height (a mesh: as its size) */
};
/* Begins to read the forces summed since the last call. Does not wait. */
enum status deform_forces_begin(struct deform *deform) FURROW_CHECKED;
/* Takes the next forces, in the order of the contacts. *taken false: there are none. Without `wait` also: they have not arrived
 * yet. */
enum status deform_forces_take(struct deform *deform, bool wait, struct deform_forces *forces,
			       bool *taken) FURROW_CHECKED;

#endif
