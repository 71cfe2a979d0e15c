/*
 * world/facts.h, a part of world.h: what is known before a step is made, plans of it, and what a run has counted.
 */
#ifndef FURROW_WORLD_FACTS_H
#define FURROW_WORLD_FACTS_H

#include "world/body.h"

struct forces; /* forces.c */

/* Waits of the step's thread: for a page, for a commit, or for the ground on which a body is placed. */
struct stalls {
	uint64_t count;
	double ms;
};

/* What a world found out when it was opened and started. It does not change afterwards. */
struct world_facts {
	const char *path;         /* of the file that is written: the store or the overlay */
	struct scene_light light; /* the scene's; on the store's body, if the scene names none */
	double slip_sinkage;      /* the scene's; 0 where no body slips and no earlier drive may have dug */
	bool without_gl;          /* no GL context could be made, so the CPU computes what the GPU would */
	struct world_resumed {
		bool is;
		int64_t from;     /* step */
		double time;      /* s */
		bool nothing_left;
	} resumed;
	struct world_began {
		double low, high; /* m: the deepest rut, at most 0, and the highest heap that earlier runs left. Of a run that is resumed both are 0 */
	} began;
	struct world_limits {     /* limits.c: most tiles in memory */
		uint32_t slots;   /* of the GPU */
		uint32_t images;  /* of changed pages, as in pages_params */
		uint32_t ground;  /* base heights that `ground` keeps */
		uint32_t queries; /* that `newest` keeps; 0: nobody asks */
		bool all;         /* every tile that the drive may come to has a slot, so nothing is read ahead */
		uint32_t loaders; /* threads that load tiles: the scene's, or 0 with `all` */
		double prefetch;  /* s of travel that is looked ahead: the scene's, or 0 with `all` */
		struct mem_usable usable; /* by this process: bounds the queue of changed pages */
		double hosts_need, hosts_work; /* tiles of base heights, and pages, under bodies that a host added */
	} limits;
	struct world_soils_met *met; /* NULL: not known, or nobody asks */
};
const struct world_facts *world_facts(const struct world *world);

/* The stages of a step, in their order: stages.c. */
enum world_stage {
	WORLD_COLLECT, /* the events that are due, and the ground for them. Nothing changes */
	WORLD_CONTACT, /* bodies on paths change the ground */
	WORLD_HOSTS,   /* bodies that a host moves do */
	WORLD_RELAX,   /* soil slides */
	WORLD_FORCES,  /* rows, and what loads found */
	WORLD_RECORD,  /* the record, and a commit that is due begins */
	WORLD_STAGES
};
const char *world_stage_name(enum world_stage stage);

/* What a world has counted so far. */
struct world_counts {
	struct world_windows {          /* windows of contacts */
		uint64_t computed, due; /* due: how many there would be if every contact on the ground were computed */
		size_t tiles;           /* most tiles that one window may touch, by the budget */
		uint64_t tiles_most;    /* most tiles that one window has touched */
		bool told;
	} windows;
	/* Blocks in which relaxation looked. possible: how many there would be if it looked at all blocks of each touched tile. */
	uint64_t visited, possible;
	uint64_t drops;                 /* bodies that a window dropped */
	double stage_seconds[WORLD_STAGES]; /* s, by the clock, of all steps so far: what each stage took */
	struct world_warmed {           /* figures of warming up, which do not count as figures of steps */
		struct gpu_stats gpu;
		struct gpu_slots_figures slots;
		struct stalls stalls, range_waits;
		double load_ms;         /* time that world_warm waited for tiles */
	} warmed;
};
const struct world_counts *world_counts(const struct world *world);
void world_stalls(const struct world *world, struct stalls *stalls); /* waits since world_begin */
/* waits for ranges of tiles since world_begin; they do not count as stalls */
void world_range_waits(const struct world *world, struct stalls *waits);
struct world_forces_figures {
	uint64_t saturated; /* posts whose pressure was too large to count */
};
/* Returns false if the world computes no forces. */
bool world_forces_figures(const struct world *world, struct world_forces_figures *figures);

/* --- facts that follow from scene and store, before anything is made: plan.c --- */

/* Returns the planes that are read and committed. With bodies: the planes of the scene's model, disturbance if the scene asks for it, and what
 * slip dug if a body may slip. Without bodies: the drawn planes if the store was deformed before, otherwise none. */
unsigned world_planes(const struct world *world);
/* Returns the effects that run over this store, as scene_effects does. Where all tiles have a slot, nothing is loaded ahead. Where earlier drives
 * deformed the ground, slip may have dug there. */
uint64_t world_effects(const struct world *world);
/* Returns true if the CPU computes the ground: soil that bears always, kinematic models if the scene says so or there is no GL. Pages then have their
 * home in host memory. */
bool world_is_bearing(const struct world *world);
bool world_computes_together(const struct world *world); /* contacts of several bodies, whose passes read and write tiles, so the slots lie in arrays */
const struct relief *world_relief(const struct world *world); /* returns what raises the ground below level 0; NULL: nothing */
struct rocks_spec world_rocks_asked(const struct world *world); /* returns the scene's rocks as far as posts show them; cover 0: none */
const struct rocks *world_rocks(const struct world *world);   /* returns the rocks that raise the ground at every level; NULL: none */
enum gpu_division world_division(const struct world *world);  /* returns how tiles below level 0 get their base */
bool world_needs_soil_map(const struct scene *scene); /* true if there is a map of soils and something uses it */
bool world_needs_rasters(const struct scene *scene);  /* true if there are rasters of soil numbers and something uses them */
/* Which soils lie along the paths of objects and drivers until the drive's end. Found at some places of each path, before the drive. Amounts are
 * counted in path samples. */
struct world_soils_met {
	size_t places;              /* that were looked at, on the terrain */
	bool partly;                /* some body comes elsewhere: a vehicle without a path, or a host's */
	double all, soils[SOIL_CLASSES];
	double values[256], none, roads, rocks; /* by the value of the map of soils; none: the map has no value there; roads, rocks: one is there */
	double numbers[SOIL_RASTERS]; /* by raster of soil numbers: where it has a number */
	/* Of object i and soil k, at i * SOIL_CLASSES + k: about what load the soil bears that is weakest there, N, and that soil. NAN: the object has no
	 * load, or does not come to it. INFINITY: not known for its shape */
	double *least;
	struct soil_numbers *weakest;
};
/* One of the scene's rasters, in the unit of its key. Only if world->resident.soil_rasters is not NULL. `step`: from one level to the next. */
struct world_raster {
	const char *key, *unit, *path; /* unit NULL: none */
	double low, high, step;
};
struct world_raster world_raster(const struct world *world, int raster);
/* Shapes of bodies that vehicles will add and that carry soil. */
struct world_aboard_shapes {
	const struct soil_shape *const *list;
	size_t count;
};
/* Opens the store for reading and makes the bodies; only for plans. `aboard`: what vehicles add; NULL: nothing. If `store` is NULL, it assumes a terrain and describes it
 * in `assumed`. End with world_finish, also after a failure. */
enum status world_open_plan(const struct scene *scene, const char *store, bool keep_history, const struct world_aboard_shapes *aboard, struct store_meta *assumed,
			    struct world **world)
	FURROW_CHECKED;
/* Opens the store of a run that has ended at this step and time, s, for its maps. End with world_finish, also after a failure. */
enum status world_open_ended(const struct scene *scene, const char *store, int64_t step, double time, struct world **world) FURROW_CHECKED;
/* Prints a note if this run is the first to write ruts into a store that was imported, and keeps no history. For runs of a command. */
void world_tell_written(const struct world *world);
/* Returns true if vehicles weigh as on the Earth only because the scene gives no gravity, and no note of world_advise says so. */
bool world_assumes_gravity(const struct world *world);
/* Calls `tell` for each setting of the scene that has no effect on this store. */
void world_advise(const struct world *world, scene_advice_fn tell, void *user);
/* Add lines to a plan: the first for the passes and resources of contacts, the second for pages and the look-ahead. `added`: shapes of
 * bodies that will be added (world_body_add). Lines count them as objects, after those of the scene. */
enum status world_plan_deform(const struct world *world, const struct soil_shape *const *added, size_t count, struct plan *plan)
	FURROW_CHECKED;
void world_plan_pages(const struct world *world, struct plan *plan);
uint64_t world_samples_until(const struct track *track, double end); /* number of path samples that are due until `end`, s */

/* --- resources that a world needs at least, and uses at most: budget.c --- */

/* STATUS_INPUT, with the number needed: one window touches more tiles than there are slots, or more ground relaxes than can
 * relax at once. */
enum status world_budget_check(struct world *world) FURROW_CHECKED;
void world_budget(const struct world *world, struct resident_pages_budget *budget); /* bytes of everything that holds tiles */

#endif
