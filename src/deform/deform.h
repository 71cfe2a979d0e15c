/*
 * deform: changes the ground under an object, on the GPU. Its work is on windows: rectangles of posts around the object. It runs
 * the dissertation's four stages over each window: gather, displace, redistribute, scatter (with attributes). SOIL.md describes
 * each stage.
 *
 * Results are integers and the same on every driver. The lower envelope of an object is its lowest height above each post during
 * the motion. It is computed from affine functions of the post's position, in 64-bit fixed point (src/soil/shape/affine.h). Results do not
 * depend on tiles, since a window knows only global posts. Functions on a struct deform are for the GPU's thread.
 */
#ifndef FURROW_DEFORM_H
#define FURROW_DEFORM_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/effect.h"
#include "gpu/gpu.h"
#include "soil/soil.h"

struct soil_carried; /* soil/carried.h */
struct deform_rest;

/* A contact: the object moves straight from `from` to `to` with the attitude of `to`. A first contact has from == to. */
struct deform_contact {
	const struct soil_shape *shape;
	struct soil_interface interface; /* for soil that bears */
	struct soil_pose from, to;
	double seconds; /* duration of the motion, s; 0: not known */
	/* wheel: radians turned about its axis during the motion (slip 0: distance / radius); body with a belt: metres that the belt ran
	 * (slip 0: distance) */
	double turned;
	double rotated[3]; /* other shapes: radians turned about local axes during the motion; for soil that bears */
	double linear[3], angular[3]; /* hosted: how the body moves at `to`, m/s, rad/s, local axes: soil that bears damps it */
	double runs;    /* m/s of its belt */
	struct soil_trend trend; /* for soil that bears: the object's recent motion, up to `from` */
	double load;    /* N, downwards. 0: the height is to.z. Otherwise the equilibrium height is searched, starting near to.z */
	/* with a load: number of the loaded body, 1 to params.loaded_bodies; 0: its equilibrium height is not kept */
	uint32_t loaded_body;
	bool leaves;    /* sheet: the object is taken away from `from`; `to` must be the same */
	bool hosted;    /* a host moves the object, so the motion may be much shorter than a post */
	double stamped; /* hosted: 1: the hollow below `from` has the shape of the object; 0: it is a flat rut, along which the object came */
	/* The object is above all ground of its windows before the contact. The distance exceeds the rounding of its lower
	 * envelope. */
	bool above;
	struct soil_carried *carried; /* for soil that bears: what the object carries (soil/carried.h), and may take along; NULL: nothing */
	int32_t now;  /* the store's time at `to`, quarter seconds; for marks that fade */
	int32_t torn; /* how much of the cover below it the body tears, 0 to PLANE_MARK_MOST */
	/* Kinematic models that conserve soil: other bodies, at rest, that may be above posts of its windows. Each has `roofs` set. Soil is not laid and does not slide
	 * into them. The caller's, until the contact was computed. */
	const struct deform_rest *rests;
	size_t rest_count;
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
	MODEL(DEFORM_SCM, scm) \
	MODEL(DEFORM_SHEET, sheet)

#define DEFORM_MODEL_NUMBER(number, word) number,
enum deform_model { DEFORM_MODELS_EACH(DEFORM_MODEL_NUMBER) DEFORM_MODELS };
#undef DEFORM_MODEL_NUMBER
#define DEFORM_MODEL_DEFAULT ((enum deform_model)0) /* of a scene without `redistribute` */

struct deform;
struct deform_params;
struct deform_window;
struct soil_slide; /* how soil slides: src/deform/internal.h */

/* Runs a model over one window whose lower envelope is known. */
typedef enum status (*soil_contact_fn)(struct deform *deform, const struct deform_contact *contact,
				       const struct deform_window *window, uint32_t layer);

/* Runs a model over a batch of windows (batch.c). */
typedef enum status (*soil_batch_fn)(struct deform *deform);

/* One soil model. Members that are left out are false, 0 or NULL. */
struct soil_model {
	const char *name; /* in a scene */
	/* For the documentation: what the ground does under this model, and what becomes of the displaced volume. */
	const char *use, *volume;
	struct effect_row effect; /* the model's effect, as `furrow explain` prints it */
	/* name of the effect that computes the model's contacts; NULL: the model's own effect. Another model's name means that
	 * both share one contact pass */
	const char *contact_effect;
	/* name of the effect that needs to know which posts were touched; NULL: the model's own effect */
	const char *touched_effect;

	/* Keys that a scene may give for this model. Both lists are NULL-terminated; a list that is NULL is empty. */
	const char *const *keys;    /* keys of `redistribute` that the model accepts, apart from `model` */
	/* keys of the soil's numbers that the model reads; with an empty list the model needs no soil */
	const char *const *numbers;
	double depth;               /* the default of `depth`, metres */

	/* Functions and properties of the model. */
	/* The soil bears: src/bearing computes its contacts, on the CPU, and tells forces. A model that does not bear accepts no load and no slip. */
	bool bears;
	/* An elastic sheet: soil/kinematic/sheet.h. A body deflects it far around, and lets go of it when it leaves */
	bool elastic;
	soil_contact_fn contact; /* computes one contact over a window and changes the ground; NULL: the CPU alone computes the model */
	soil_batch_fn batch;     /* computes the contacts of a batch; NULL: the model's contacts are computed alone */
	const char *shader;      /* file of the shader that computes the contact */
	unsigned planes;         /* planes that the model stores apart from the offset: a mask of PLANE_BIT */
	bool blind;              /* the model does not need to know which posts were touched */
	bool contact_soils;      /* the contact's shader reads the soils' numbers, so it is compiled with the define SOILS */
	bool smooths;            /* the model smooths the track of a moving object, by the keys `radius` and `repetitions` */
	/* how soil slides; NULL: it does not slide, and displaced soil is lost. With sliding, only compacted soil is lost */
	const struct soil_slide *slide;
	int directions; /* of the lines along which soil slides in a contact: 4, or 2 of them in turn, or 0 */
	/* Computes the largest height difference, fixed-point units, at which two posts of a soil are stable. `apart`: their
	 * distance, metres. Used if soil slides by excess (deform_slide_excess). */
	int32_t (*critical)(const struct soil_numbers *soil, double apart);
	/* Returns the cotangent of the steepest angle at which a slope of `height` metres is stable; NULL: it does not depend on the
	 * height. */
	double (*cotangent)(const struct soil_numbers *soil, double height);
	/* For a model that conserves soil: the angle at which displaced soil is laid, rad, and its share of the displaced soil. */
	double (*laid_at)(const struct soil_numbers *soil);
	double (*laid_share)(const struct deform_params *params, const struct soil_numbers *soil);
};

/* Returns the struct that describes a model. It is constant. */
const struct soil_model *deform_model_row(enum deform_model model);

/* Returns true if the model accepts this key of `redistribute`. */
bool deform_model_takes(enum deform_model model, const char *key);
/* Returns true if the model reads this number of a soil. */
bool deform_model_reads(enum deform_model model, const char *number);
/* Returns true for a model that moves soil and loses only what is compacted. */
bool deform_conserves(enum deform_model model);
/* Returns true for a model whose soil slides by Sumner's rule: a steep post sheds soil to its lower neighbours (soil/kinematic/shed.h). */
bool deform_sheds(enum deform_model model);
/* Returns in how many directions soil slides along lines in a contact, a pass each. */
int deform_line_passes(const struct deform_params *params);
/* Returns true if the soil bears (bearing.h), so that forces are told. Only then an object can have a load. No deform is made for such a model. */
bool deform_tells_forces(enum deform_model model);
/* Returns true if the ground is an elastic sheet, which comes back when an object leaves it. */
bool deform_is_elastic(enum deform_model model);
/* Returns true if the ground may rise again: the model moves soil, or is elastic. Then offsets + compacted stays the same. */
bool deform_raises(enum deform_model model);
/* Returns true if the CPU alone computes the model: its soil bears. No deform is made for such a model. */
bool deform_on_cpu(enum deform_model model);
/* Returns true if the CPU computes the model unless the GPU is asked for: also an elastic sheet, which takes many passes over small windows. */
bool deform_for_cpu(enum deform_model model);
/* Each returns the name of an effect that is needed for every object under the model. deform_displace_effect: the effect that
 * computes contacts. deform_slide_effect: the effect that lets soil slide; NULL: soil does not slide. deform_contact_effect: the
 * effect of the textures that tell what an object touched. */
const char *deform_displace_effect(enum deform_model model);
/* Returns the effect that needs a plane. */
const char *deform_plane_effect(enum deform_model model, enum plane plane);
const char *deform_slide_effect(enum deform_model model);
const char *deform_contact_effect(enum deform_model model);

struct deform_params {
	struct gpu *gpu;
	struct gpu_slots *slots;
	const struct extent *extent; /* must outlive the deform */
	int level;                 /* the working level */
	int32_t reference;         /* metres: base heights in the slots are relative to this height */
	enum deform_model model;
	int box_radius;      /* posts, 1 .. 4 */
	int box_repetitions; /* 1 .. 8 */
	/* For models that conserve soil: */
	struct soil_numbers soils[SOIL_CLASSES];
	int soil_count;      /* number of soils: 1, or one for each class in the slots' class planes */
	struct soil_raster rasters[SOIL_RASTERS]; /* of the bytes in the slots' numbers, in their order */
	int raster_count;    /* 0: the slots have no numbers */
	int iterations;      /* relaxation iterations of a contact and of an interval; 1 .. 8 */
	bool along_lines;    /* in a contact soil also slides along lines (soil/lines.c); false: from post to post only */
	double relief;       /* metres between the world's lowest and highest post; INFINITY: not known */
	double depth;        /* metres of soil below the base that can relax; INFINITY: no bottom */
	/* metres, 0 .. 1: soil slides between two posts only if their difference exceeds the critical one by more than this */
	double tolerance;
	/* undisturbed ground is stable: soil slides only from a post that has risen above its neighbour, or to one that has
	 * sunk. Otherwise the caller must have activated all steep ground */
	bool undisturbed_stable;
	/* ground that nobody activated may be too steep for this soil, as a drive with another soil left it. A block that an interval
	 * visits needlessly would then change, so an interval waits for all flags from the GPU */
	bool unsettled;
	double bulldozing;   /* scm: share of the plastic flow that is laid around the object, 0 .. 1 */
	double loosening, hardening; /* scm: as in struct soil_law */
	double slip_sinkage; /* scm: how deep slip digs, in units of the soil's shear modulus; 0: not */
	bool faces;          /* scm: the soil's stress acts on an object's faces from every side as it slides; false: on its lower envelope alone */
	double inertia;      /* scm: of soil that faces push away, a share of rho v^2; 0: none */
	/* sheet: its tension T, N/m, and the stiffness k of what is below, Pa/m. The deflection up to which it comes back whole, m; INFINITY: it always does.
	 * Of what is beyond that, the share that stays, 0 .. 1 */
	double tension, stiffness, yield, rut;
	bool thrown;         /* scm: a part of what slip digs flies off; what contacts throw is told, and the caller lets it land */
	double gravity;      /* m/s2; read if `thrown` */
	bool ground_normals; /* scm: stresses act along the normal of the ground; false: along that of the object's lower envelope */
	bool touched;        /* the caller will ask deform_is_touched. Needs `undisturbed_stable` and a model that conserves soil */
	uint32_t loaded_bodies;   /* scm: number of objects that carry a load and rest on the ground between contacts */
	bool disturbance;    /* keep the disturbance plane */
	int32_t heals, rises, grows; /* what the darkest marks that fade take, as in struct plane_marks; 0: no such plane */
	bool batches;        /* contacts of several bodies may be computed together, if the model can */
	bool roofs;          /* a body will be at rest near moved soil; of models that conserve soil. What that needs is made at once; otherwise when one is */
	bool fixed;          /* contacts are computed in fixed regions, where they can be; only if deform_takes_regions, and without batches */
};

/* What else a post remembers, a mask: what slip has dug; loose layers; how dense passes have made it; how high its slope is. Then marks that fade:
 * disturbance, and those of plants. */
enum { DEFORM_DIGS = 1, DEFORM_LOOSENS = 2, DEFORM_HARDENS = 4, DEFORM_SLOPES = 8, DEFORM_HEALS = 16, DEFORM_GROWS = 32 };
unsigned deform_memory(const struct deform_params *params);
/* Returns those that are marks. A contact of every model writes them. */
unsigned deform_marks(const struct deform_params *params);
/* Returns the marks of a contact: soil/kinematic/kinematic.h. Pure. */
struct soil_mark;
struct soil_mark deform_mark_of(const struct deform_params *params, const struct deform_contact *contact);
/* Tells whether a soil's limit depends on the height of the slope. */
bool deform_slopes_count(enum deform_model model, const struct soil_numbers *soils, int count);
/* Returns the planes that a model keeps, a mask of PLANE_BIT. */
unsigned deform_planes(enum deform_model model, bool disturbance, unsigned memory);

enum status deform_create(const struct deform_params *params, struct deform **out) FURROW_CHECKED;
void deform_destroy(struct deform *deform);

/* A window: the posts that a contact changes (`write`), and the posts that it reads to compute them (`read`). `read` has at most
 * DEFORM_WINDOW_POSTS on each side. A larger contact has several windows, whose `write` parts meet. Under a model that conserves
 * soil they are parts of one window, which is computed when its last part was gathered. */
#define DEFORM_WINDOW_POSTS 256
#define DEFORM_WINDOWS_MAX 16
#define DEFORM_WHOLE_POSTS 1024 /* the most posts on a side of a window in parts */
struct deform_window {
	struct post_rect read, write;
	struct post_rect whole; /* all posts that the parts write */
	uint32_t part, parts;   /* its number; how many there are, 0: the window is computed alone */
};
/* Returns how many windows are computed: all of them, or one if they are parts of one. */
size_t deform_windows_computed(const struct deform_window *windows, size_t count);
/* Returns true if the contact has no motion. Then only its end pose acts on the ground. */
bool deform_is_contact_only(const struct deform_contact *contact);
/* Returns true if soil can slide only near what the contact reached: the object turned by less than a post. spacing: m between posts. Pure. */
bool deform_slides_near(const struct deform_contact *contact, double spacing);
/* Returns a number of posts. A contact of this shape reads and changes no post that lies farther from the rectangle around its origins. */
int64_t deform_contact_reach(const struct deform *deform, const struct soil_shape *shape);
/* Finds the windows of a contact. *count 0: it lies outside the world. STATUS_INPUT: it needs more than DEFORM_WINDOWS_MAX. */
enum status deform_windows(struct deform *deform, const struct deform_contact *contact,
			   struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* STATUS_INPUT: the model is an elastic sheet, and it bends over too many posts. deform_windows and deform_cut find that too. Pure. */
enum status deform_check_sheet(const struct deform_params *params) FURROW_CHECKED;
/* Finds the same windows as deform_windows, but needs only the parameters and allocates no memory. gpu and slots may be NULL.
 * Pure. */
enum status deform_cut(const struct deform_params *params, const struct deform_contact *contact,
		       struct deform_window *windows, size_t *count) FURROW_CHECKED;

/* Makes what bodies at rest need (struct deform_contact's rests). Call it before deform_compute and deform_interval_begin of such bodies. What layers
 * have is lost. */
enum status deform_need_roofs(struct deform *deform) FURROW_CHECKED;

/* Computes one window of a contact: gathers it from tiles, displaces and redistributes soil. The result stays in the window's
 * layer, a part of deform's textures. `tiles`: all tiles that hold a post of `read`, pinned; they do not change. deform_scatter writes the
 * result. */
enum status deform_compute(struct deform *deform, const struct deform_contact *contact,
			   const struct deform_window *window, uint32_t layer,
			   const struct tile_slot *tiles, size_t count) FURROW_CHECKED;
/* The facts about an object that decide its resources and passes. */
struct deform_planned {
	const struct soil_shape *shape;
	bool moves;  /* the object moves after it was set down */
	bool leans;  /* a wheel that may have camber at times */
};
/* Prepares ("warms") the programs that this object needs in contacts and at rest, so that no later step links one. It runs each
 * program once over a window outside the world, since a driver's first draw may take a tenth of a second. Changes no ground. A program
 * is prepared only once. */
enum status deform_warm(struct deform *deform, const struct deform_planned *object) FURROW_CHECKED;
/* Writes the result of deform_compute to the tiles: copies the posts of `write` to every tile that holds them. Gives these tiles
 * deform slots, if they have none. */
enum status deform_scatter(struct deform *deform, const struct deform_window *window, uint32_t layer,
			   const struct tile_slot *tiles, size_t count) FURROW_CHECKED;

/*
 * Fixed regions: each tile is a region, and each stage is drawn once in each region that the contact reads, at most four (fixed.c). Passes
 * read and write the tiles themselves, so nothing is gathered or scattered. The result has the same bits as a window's.
 *
 * deform_takes_regions: returns true if a model can be computed so: no stage of it reads all posts of a contact. Pure.
 * deform_is_fixed: returns true if the parameters ask for it, and these windows can: there is one, on two by two tiles at most.
 * deform_fixed: computes such a contact, in the place of deform_compute and deform_scatter. `tiles`: all tiles that hold a post of `read`,
 * pinned, and maybe others. *drawn: how many regions it was drawn in, 1 to 4.
 */
bool deform_takes_regions(enum deform_model model);
bool deform_is_fixed(const struct deform *deform, const struct deform_window *windows, size_t count);
enum status deform_fixed(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			 const struct tile_slot *tiles, size_t count, size_t *drawn) FURROW_CHECKED;

/*
 * A batch: contacts of one window each that share no post, computed together (batch.c). Call deform_batch_begin; deform_batch_add for each
 * window; deform_batch_compute, which also writes the results to the tiles, as deform_scatter does, and then calls deform_wake_swept. The result
 * has the same bits as contacts that are computed one after another. Only if the parameters ask for batches. The slots must lie in
 * arrays then.
 */
#define DEFORM_BATCH_MOST 512 /* windows */
#define DEFORM_BATCH_TILES 4  /* that hold posts of one window, at most */
#define DEFORM_BATCH_BUFFER "batch" /* name of the plan's line of the only memory that batches need */
/* Returns true if some contacts of this object can be in a batch. */
bool deform_batches(const struct deform_params *params, const struct deform_planned *object);
/* Returns true if a contact with these windows can be in a batch. */
bool deform_is_batched(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *windows, size_t count);
void deform_batch_begin(struct deform *deform);
/* Adds a window. `tiles`: all tiles that hold a post of `read`, at most DEFORM_BATCH_TILES, and maybe others. They keep their slots until the
 * batch is computed. *added is false if there is no room; there is room for a first window. */
enum status deform_batch_add(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			     const struct tile_slot *tiles, size_t count, bool *added) FURROW_CHECKED;
enum status deform_batch_compute(struct deform *deform) FURROW_CHECKED;

/*
 * Active blocks: blocks where soil may still relax. In intervals (SOIL.md) the whole lattice makes `iterations` iterations of
 * the relaxation rule. Only active blocks of SOIL_BLOCK x SOIL_BLOCK posts are computed. They include all blocks that
 * change. So the result does not depend on which blocks are active. Only models that conserve soil have active blocks.
 */
#define DEFORM_BLOCKS_MAX 16384
/* Makes the blocks near these posts active. Call it when the posts were changed, or when an object that rested on them has gone. */
enum status deform_wake(struct deform *deform, struct post_rect changed) FURROW_CHECKED;
/* Returns the posts of all blocks that deform_wake makes active for this change. */
struct post_rect deform_wakes(const struct deform *deform, struct post_rect changed);
/* Returns how many posts around its blocks an interval reads; less than a block. Only for a model that conserves soil. */
int64_t deform_interval_rim(const struct deform *deform);
/* Makes blocks active after a contact. Call it after the last computed window was scattered. Only blocks where soil still moves
 * stay active. For a contact of several windows it does the same as deform_wake. The window must cover what the object rested on
 * before (deform_covers). */
enum status deform_wake_swept(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* Returns true if the contact reads everything that the object rests on in a pose, and around it. Then nothing need be made
 * active when the object leaves that pose. */
bool deform_covers(const struct deform *deform, const struct deform_contact *contact, const struct soil_pose *rest);
/* The same over an elastic sheet: what an object left far away must come back first. Pure. */
bool deform_covers_sheet(const struct deform_contact *contact);
/*
 * Touched posts: posts whose planes may have changed since the deform was made, and posts named with deform_touch. Only if the
 * parameters ask for it. They include posts that contacts wrote, and posts that sliding soil can have reached. After a contact
 * of one window, and after sliding, only parts of blocks that changed are included, once the GPU has reported them.
 */
enum status deform_touch(struct deform *deform, struct post_rect rect) FURROW_CHECKED;
enum status deform_is_touched(struct deform *deform, struct post_rect rect, bool *is) FURROW_CHECKED;
enum status deform_wake_block(struct deform *deform, struct soil_block block) FURROW_CHECKED; /* the block must lie inside the world */
/* Waits until it is known which blocks are active. Then it makes all of them inactive, so that the caller can make some of them active again. */
enum status deform_forget_active(struct deform *deform) FURROW_CHECKED;
/* Gives the list of all active blocks. Its order depends only on which blocks are active. The list is valid until the next call.
 * STATUS_FAILED: there are more than DEFORM_BLOCKS_MAX. Rarely waits for the GPU. */
enum status deform_active_blocks(struct deform *deform, const struct soil_block **blocks, size_t *count) FURROW_CHECKED;

/* An object at rest, in the pose of its last path sample. */
struct deform_rest {
	const struct soil_shape *shape;
	struct soil_pose pose;
	/* Soil that bears. Not 0: it is at the equilibrium height that the last contact of this loaded body found, relative to this pose */
	uint32_t loaded_body;
	bool roofs; /* kinematic models: no soil rises above its lower envelope (soil/sliding/roofs.h). Under soil that bears all bodies do so */
};
/* One interval of relaxation (SOIL.md). Call deform_interval_begin, which gives the numbers of regions and runs. Then call
 * deform_interval_gather for each region, then deform_interval_scatter for each run, then deform_interval_end. Without blocks
 * nothing is done. The caller keeps the objects, which must live until the end. Soil under an object does not move. */
struct deform_interval {
	size_t blocks;  /* active blocks */
	size_t regions; /* rectangles of blocks; each is gathered as one */
	size_t runs;    /* rows of active blocks; each is scattered as one */
	size_t atlases; /* batches of regions that are computed together */
};
enum status deform_interval_begin(struct deform *deform, const struct deform_rest *objects, size_t object_count,
				  struct deform_interval *interval) FURROW_CHECKED;
/* Returns the posts of a region that are read, at most DEFORM_WINDOW_POSTS along each side. */
struct post_rect deform_interval_reads(const struct deform *deform, size_t region);
/* Returns the posts of a run. It lies on as many tiles as one block, at most. */
struct post_rect deform_interval_writes(const struct deform *deform, size_t run);
/* `tiles`: tiles that hold posts that this region reads: all, but for those given to deform_interval_gather_part before. Call with
 * region 0, 1, ... in turn. So not all tiles need a slot at the same time. */
void deform_interval_gather_part(struct deform *deform, size_t region, const struct tile_slot *tiles, size_t count);
enum status deform_interval_gather(struct deform *deform, size_t region, const struct tile_slot *tiles,
				   size_t count) FURROW_CHECKED;
/* `tiles`: all tiles that hold a post of this run. */
enum status deform_interval_scatter(struct deform *deform, size_t run, const struct tile_slot *tiles,
				    size_t count) FURROW_CHECKED;
enum status deform_interval_end(struct deform *deform) FURROW_CHECKED;

/*
 * Adds to the plan what a deform with these parameters will allocate and run (base/plan.h). Each of the objects is prepared with
 * deform_warm. `params`: gpu and slots may be NULL. The extent may be NULL too; then every object fits one window. Pure.
 *
 * Passes are listed by object for PLAN_WINDOW, PLAN_MOVED, PLAN_REGION and PLAN_REGION_MOVED. For PLAN_FACETS, PLAN_HELD, PLAN_RESTING and PLAN_ATLAS they are for
 * all objects together (-1), as deform_figures counts them.
 */
void deform_plan(const struct deform_params *params, const struct deform_planned *objects, size_t count, struct plan *plan);
/* Adds the lines of the planes alone, each with the effect that needs it. deform_plan calls it. Pure. */
void deform_plan_planes(const struct deform_params *params, struct plan *plan);
/* Counts of deform's work. Layers: the largest number that existed at once, without the layers of atlases. The others: draws since
 * the start, without those of deform_warm. */
struct deform_figures {
	uint64_t window_layers, result_layers;
	uint64_t facets;   /* draws of an object's triangles */
	uint64_t held;     /* regions on which an object at rest was drawn */
	uint64_t resting;  /* windows drawn for that, of closed forms; triangles are counted in `facets` */
	uint64_t atlases;
	uint64_t batches;  /* of two windows or more */
	uint64_t batch_draws;     /* draws in batches of the ground, one for each pair of arrays, and of contacts, for each kind of body too */
	uint64_t batch_stores;    /* draws that wrote tiles: one for each array */
	uint64_t batch_envelopes; /* draws of lower envelopes in batches */
};
void deform_figures(const struct deform *deform, struct deform_figures *figures);

/* The tally: counts that the GPU adds up since the start. */
struct deform_tally {
	int64_t compacted; /* soil that conserving models compacted: 2^-20 m, summed over posts */
	uint64_t refused;  /* posts where the change would have left the range of an offset */
	uint64_t confined; /* posts whose soil found no free post around, and was compacted */
	uint64_t sunk;     /* contacts of loaded objects that the soil did not carry */
	uint64_t slid;     /* contacts of loaded objects that the soil carried, on a slope too steep to hold them */
};
/* Reads the tally. Waits for the GPU. For the end of a drive. */
enum status deform_tally(struct deform *deform, struct deform_tally *tally) FURROW_CHECKED;
/* Goes back to an earlier tally, and makes every block inactive. Waits for the work in flight. Touched posts stay touched. */
enum status deform_restore(struct deform *deform, const struct deform_tally *tally) FURROW_CHECKED;
/* Begins to read the tally as bytes, as gpu_buffer_read_into does: sizeof(struct deform_tally). Does not wait. */
void deform_tally_read_into(struct deform *deform, struct gpu_staging *staging, size_t offset);

/* How the soil bears an object. */
enum deform_state {
	DEFORM_TOUCHING,
	/* Loaded, and on a slope where W sin a > c A + W cos a tan phi, of the soil or of its surface. Without the vertical guide of
	 * its path it would slide. */
	DEFORM_SLIDES,
	DEFORM_SUNK,     /* loaded, and the soil does not carry it: it sank as deep as its height (a mesh: as its size) */
	DEFORM_AIR,      /* no post bears it */
	DEFORM_STATES
};

/* The forces of soil that bears, on an object in one contact. They are sums of whole numbers over the posts that carry the
 * object at the end of the contact. The share of each post is rounded to 1/16 Pa times the post's area. */
struct deform_forces {
	double force[3];      /* N on the object: east, north, up */
	double moment[3];     /* N m about its centre */
	double sinkage;       /* m: its greatest depth below the base, where the soil bears it; 0 if it is above the base */
	double area;          /* m2: area of the ground that carries it */
	double slope[2];      /* mean slope of the base under it: its rise for each metre to the east, and to the north */
	/* N, along the heading and the ground: the force that the path must add to the soil's, so that the body keeps its motion. Below
	 * 0 the path holds it back. Its weight is the load, or without a load the soil's vertical force. */
	double residual;
	/* N: what pulls its belt over it, along the belt, against the soil's shear; below 0 the belt brakes. Times the belt's speed it is the power
	 * of what drives the belt. 0: it has no belt */
	double pull;
	int64_t z;            /* 2^-20 m: height of its centre; with a load, the equilibrium height */
	uint32_t saturated;   /* posts whose share exceeded 2^31 sixteenths of a pascal, and was cut to that */
	enum deform_state state;
};
#endif
