/*
 * furrow.h: terrain that is larger than memory and that changes under what drives on it.
 *
 * A world is a terrain that is open for simulation. It is opened from a scene and a store. A scene is the YAML of SCENE.md, as
 * text or file. A store is a file that `furrow import` or furrow_import makes. The host places bodies, steps, and asks for forces,
 * heights and pictures. furrow(3) has a program that runs; the folder examples/ holds three.
 *
 *     furrow_world_open -> furrow_body_add -> furrow_place -> (furrow_set_states -> furrow_step -> furrow_get_contacts) ...
 *                       -> furrow_world_close
 *
 * Units and axes. SI units and radians. Local axes: x east, y north, z up; metres from the store's south-west post.
 * Heights are as the store has them. A body's own axes: x forward, y left, z up. Quaternions are w, x, y, z.
 *
 * Errors. A function that can fail returns a furrow_status. furrow_last_error() then says what failed, why, and what to do.
 * NULL, a size that is off, a NaN and a body that is gone are FURROW_USAGE, never a crash. A call that fails with
 * FURROW_USAGE changed nothing. Results are written only by a call that returns FURROW_OK, unless said otherwise.
 *
 * Processes. A world belongs to the process that opened it. In a child made by fork, its functions are FURROW_USAGE, furrow_world_close as
 * well, and none waits. The child then lets go of the world's locks; its memory goes with the child. Such a child cannot open worlds, since
 * GL does not come along with a fork: that is FURROW_USAGE, too. Fork before the first world is opened, or start a program of its own (exec).
 *
 * Functions of the host (`progress`, the log) return to the library: never leave them by longjmp or a C++ exception. What the library had
 * open then stays open and locked until the process ends. A store that was being made is then refused as one that this process writes.
 *
 * Threads. One thread at a time uses a world. Several threads may use several worlds at once. The functions without a world
 * may be called from any thread. On software GL, calls on several worlds take turns: llvmpipe is not safe to use from several
 * threads (seen with Mesa 22.3.6). A host that draws on llvmpipe itself does so on the thread that calls the library.
 *
 * Manners. No function prints, exits, sets a signal handler, or changes the environment or the locale. A function that needs
 * GL makes its own EGL context current, and gives back the one that was current before. Where a GLX context is current the
 * call can be refused with FURROW_NO_GL: release the context first, or use another thread.
 * Numbers in files, texts and messages have a decimal point, whatever the locale is. Functions of the host run in the host's locale.
 *
 * Ownership. Strings and arrays that a host gives are read during the call only. The library frees nothing of the host's.
 *
 * Growth. A struct that begins with `size_t size` may get members at its end. Set `size` to sizeof the struct before the
 * call, and all else that you do not use to 0.
 */
#ifndef FURROW_H
#define FURROW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef FURROW_API
#if defined(__GNUC__)
#define FURROW_API __attribute__((visibility("default")))
#else
#define FURROW_API
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* What a call comes to; the same numbers as the exit statuses of the `furrow` command. */
typedef enum {
	FURROW_OK = 0,
	FURROW_FAILED = 1,       /* failed while it ran: memory, the disk, a commit, a lost GL context */
	FURROW_USAGE = 2,        /* the call is wrong: NULL, NaN, a size, a body that is gone */
	FURROW_INPUT = 3,        /* a scene, a store or a source is missing, unreadable, corrupt or out of range */
	FURROW_NO_GL = 4,        /* there is no usable OpenGL 4.5 through EGL, or it cannot be made current here */
	FURROW_INTERRUPTED = 130 /* the host's `progress` stopped it */
} furrow_status;

/* --- the library --- */

/* Returns the library's version, such as "0.2.0". Any thread. The string is static. */
FURROW_API const char *furrow_version(void);

/*
 * Returns the message of this thread's last failed call, "WHAT: WHY; WHAT TO DO", or "" if none failed.
 * The string is the library's. It is valid until this thread's next call of the library.
 */
FURROW_API const char *furrow_last_error(void);

/*
 * Sets who gets the library's notes: what is worth knowing and is no failure. NULL, the default: nobody.
 * `level`: 0 is a note; greater numbers are kept for what is graver. `message`: one line without a newline, valid during the
 * call. `user` is handed on. One log serves all worlds. Any thread may call the log function, several at once; it must not
 * call the library. After furrow_set_log returns, the log function that was set before is not called any more.
 */
FURROW_API void furrow_set_log(void (*log)(int level, const char *message, void *user), void *user);

/* Frees what the library handed out to be freed. Takes NULL. Any thread. */
FURROW_API void furrow_free(void *memory);

/*
 * Makes a store of elevation data, as `furrow import` does.
 * `sources`: `count` paths of rasters, folders, or "@list.txt"; at least one. `store`: path of the file to make.
 * With {imagery: [ortho.tif]} colours are put over the terrain, too. With imagery and `count` 0 they are put into the store that exists;
 * then options of heights are FURROW_USAGE.
 * `options`: a YAML mapping of the command's long names, as in "{max_error: 0.01, spacing: 1}"; NULL: all defaults.
 * `nodata`, `inset` and `imagery` may be lists of values; `height_range` and `window` are lists of numbers. No other option is a list.
 * Without {allow_network: true} GDAL fetches nothing from a network. No other function fetches anything, either. A host's own settings of
 * GDAL come back when the call returns. PROJ may fetch its own grids where the host allows that.
 * `progress`: gets the share that is done, 0 to 1, and returns false to stop; NULL: nobody asks. It is called on this thread.
 * `user` is handed on to it.
 * FURROW_INTERRUPTED: `progress` stopped it; a call with {resume: true} goes on. FURROW_INPUT: a source cannot be read, or
 * the store exists and {overwrite: true} is not given. Where only its imagery fails the store is there, without. It is also FURROW_INPUT if overlays depend on that store or it has
 * snapshots, and {force: true} is not given, too. FURROW_USAGE: an option is unknown or out of its range.
 * Any thread. Needs no GL.
 */
FURROW_API furrow_status furrow_import(const char *const *sources, size_t count, const char *store, const char *options,
				       bool (*progress)(double share, void *user), void *user);

/* --- a world --- */

struct furrow_world; /* owned by whoever opened it */

/* How a world is opened. Strings that are not needed are NULL. */
struct furrow_open {
	size_t size;            /* sizeof(struct furrow_open) */
	const char *scene;      /* the scene's text, YAML or JSON. Either this or scene_file */
	const char *scene_file; /* path of the scene; paths inside it count from its folder */
	const char *store;      /* path of the store; NULL: the scene names it */
	const char *overlay;    /* path of a file that keeps the deformation, so that the store is only read. Made if absent, and removed
				   again if there is no step */
	const char *output;     /* folder for run.json and objects.csv, made if absent; NULL: neither is written */
	bool resume;            /* go on from the store's last drive of this scene; begin anew if there was none */
	bool durable;           /* a commit survives a power cut; slower */
	bool keep_history;      /* each commit keeps what it replaces in the store, so that furrow restore returns to any; slower, and
				   the store grows with each commit */
	bool readonly;          /* only to look: nothing is ever written, so files and folders without write permission will do. Another process
				   may write the store meanwhile: each query then tells the ground of its last commit. furrow_step,
				   furrow_checkpoint, furrow_place and furrow_set_states are FURROW_USAGE. It goes with no `output` */
	size_t reserved;        /* 0. Hosts that were built before `readonly` have a smaller struct */
	const char *settings;   /* KEY=VALUE, one a line: each sets a key of the scene before it is read, as the command's --set; NULL: none */
	bool advise;            /* the log gets what looks wrong with the scene on this store, or has no effect, as the command tells it */
};

/*
 * Opens a world. Of a scene, `end_time`, `objects` and `output` may be absent here. Looking changes nothing: until the first furrow_step
 * store and overlay stay as they are, byte for byte, whatever is added, placed, probed, asked or drawn. No other process can write them
 * meanwhile, unless the world is readonly.
 * *world gets the world, or NULL when the call fails. Close it with furrow_world_close.
 * FURROW_INPUT: the scene or the store is not usable; the message names the line. FURROW_NO_GL: there is no usable GL, and
 * the scene needs it: for pictures, or by `compute: gpu`.
 * FURROW_USAGE: not exactly one of scene and scene_file is given, or `size` is off.
 * Any thread. The world's later calls may come from other threads, one at a time.
 */
FURROW_API furrow_status furrow_world_open(const struct furrow_open *open, struct furrow_world **world);

/*
 * Commits the ground as the last whole step left it and frees the world. A world that was not stepped writes nothing. After a rollback the
 * ground is the rolled-back one. If the last step failed, run.json ends with "failed". NULL: does nothing, FURROW_OK.
 * FURROW_FAILED: the last changes could not be committed; the store has its last commit, and the world is freed. So it is after a step
 * that failed half-way, if whole steps before it had no commit. FURROW_NO_GL: the world's GL cannot be made current here. Then nothing
 * was done and the world is still open: close it again, as "Manners" says.
 */
FURROW_API furrow_status furrow_world_close(struct furrow_world *world);

/*
 * Moves time on by `seconds`. Bodies with paths follow them; the others get to where furrow_set_states said.
 * 0: the scene's time_step; n such steps end at n x time_step exactly. A step with bodies of the host ends when the ground
 * under them is on the host. The scene's `end_time` ends nothing: time goes on beyond it.
 * FURROW_USAGE, and nothing has changed: `seconds` is negative, NaN or infinite, or leads beyond 1e9 s, the longest end_time of a scene. Or more
 * than 1,000,000 path samples of one body are due in the step; make shorter steps. With vehicles also if it is no multiple of time_step.
 * FURROW_FAILED: the step could not be completed, and nothing of it is committed. Where a body leaves the terrain it fails before it
 * changes the ground. Then the world is as it was and may go on; contacts of vehicles are not known until the next step. A step that
 * fails later leaves a world that can only be rolled back or closed. Of several time_steps of vehicles those before the failure stay.
 */
FURROW_API furrow_status furrow_step(struct furrow_world *world, double seconds);

/* Returns the simulated seconds since the scene's start; NaN if `world` is NULL. */
FURROW_API double furrow_time(const struct furrow_world *world);

/*
 * Commits all so far. The store then holds it, and furrow_rollback returns to it. If the call fails, to the checkpoint before. Before the
 * first step there is nothing to commit, and no file changes.
 */
FURROW_API furrow_status furrow_checkpoint(struct furrow_world *world);

/*
 * Goes back to the last checkpoint, or to the opening if there was none: ground, bodies, vehicles, forces, time and files of rows.
 * Bodies that were removed since are back. Bodies that were added since are gone, and their handles stay invalid.
 */
FURROW_API furrow_status furrow_rollback(struct furrow_world *world);

/* What a world is. Filled by furrow_info. */
struct furrow_info {
	size_t size;           /* sizeof(struct furrow_info) */
	int32_t level;         /* the working level, where bodies change the ground: 0 or below */
	int32_t coarsest;      /* the coarsest level, of a single tile. Level k has a spacing of 2^k times that of level 0 */
	uint32_t cells;        /* along a tile's side */
	double spacing;        /* m between posts of the working level */
	int64_t columns, rows; /* posts of the working level, to the east and to the north */
	int32_t levels;        /* from the working level to the coarsest, both included */
	double extent[2];      /* m from the first post to the last, to the east and to the north */
	double low, high;      /* m: the range of heights of the base, as imported */
	double gravity;        /* m/s2, the scene's */
	double time_step;      /* s, the scene's: what furrow_step(world, 0) means */
	const char *srs;       /* WKT of the store's reference system; "": local metres. Valid until the world is closed */
	double origin[2];      /* coordinates of the south-west post in it, east and north */
	uint64_t revision;     /* number of the ground's last change, as furrow_changes tells it; 1 or more */
};

/* Fills *info, whose `size` the caller has set. Members beyond `size` are not written. FURROW_USAGE: `size` is off. */
FURROW_API furrow_status furrow_info(struct furrow_world *world, struct furrow_info *info);

/* Makes *json the text that run.json would hold now. Free it with furrow_free. After a failure *json is NULL. */
FURROW_API furrow_status furrow_stats(struct furrow_world *world, char **json);

/* --- bodies: what touches the ground. Those of the scene with a path follow it; all others are the host's --- */

/* A handle, 0 or more, valid in its world. A handle is never used again for another body. */
typedef int32_t furrow_body;

/* Where a body is. */
struct furrow_pose {
	double position[3];    /* m, local axes: of the body's origin */
	double orientation[4]; /* w, x, y, z: from the body's axes to the local ones; of length 1 within 0.001 */
};

/* Where a body is and how it moves. furrow_set_states and furrow_probe take three NaN as a velocity: it is then that of the poses. */
struct furrow_state {
	struct furrow_pose pose; /* where the body is */
	double linear[3];  /* m/s, local axes: of the body's origin */
	double angular[3]; /* rad/s, local axes */
};

enum furrow_contact_state {
	FURROW_AIR,      /* touches nothing; also off the terrain and over a hole, where there is no soil */
	FURROW_TOUCHING, /* the soil carries it */
	FURROW_SLIDES,   /* the shear stress is beyond friction */
	FURROW_SUNK,     /* the soil does not carry it */
	FURROW_UNKNOWN   /* nothing is known of it: furrow_probe */
};

/* What the soil does to a body. A figure that is not known is NaN. */
struct furrow_contact {
	double time;            /* s: of the ground and the state that it is of; on a path that of the latest path sample, a working post apart */
	double force[3];        /* N, on the body, local axes */
	double moment[3];       /* N m, about the body's origin, on the body, local axes */
	double point[3];        /* m: where the force's line passes nearest the body's lowest point */
	double normal[3];       /* unit: of the undisturbed surface under the body, upward */
	double sinkage;         /* m below the undisturbed surface */
	double area;            /* m2 that touch */
	double slip;            /* of a wheel: 1 - travel along the ground / (turn x radius); of a belt: 1 - travel / its own; NaN: has none, or does not move */
	double stiffness[6][6]; /* N/m, N, N, N m/rad: d(force, moment) / d(translation, rotation) */
	double damping[6][6];   /* the same of their rates: times s */
	double normal_force;    /* N: the part of `force` along `normal`; by furrow_probe the soil's pressure, summed over the patch */
	double shear_limit;     /* N: the most that its shear can hold */
	enum furrow_contact_state state; /* whether the soil carries the body */
	double pull;            /* N: that its belt needs; NaN: it has no belt. Hosts that were built without it have a smaller struct */
	double carried;         /* m3: soil that it carries (`carry` of a scene), whose weight is a part of force and moment. Hosts that were built without it have a smaller struct */
	double slip_velocity;   /* m/s: speed of a wheel's rim, or of a belt, less that along the ground. It is finite at standstill, too. 0: nothing turns. Hosts
				 * that were built without it have a smaller struct */
};

/* What a body's shape is like. Filled by furrow_measure. */
struct furrow_shape {
	size_t size;          /* sizeof(struct furrow_shape) */
	double radius, width; /* m: of a wheel; NaN: it is none */
	double bound;         /* m: no part of it is farther from its origin */
	bool belt;            /* a belt runs over it */
};

/*
 * Fills *shape, whose `size` the caller has set. `object`: as furrow_body_add takes it. Needs no world and no GL, so a host can choose spacing and
 * terrain by the size of its bodies. Paths of meshes count from the working folder. FURROW_INPUT: the text is no such entry.
 * FURROW_USAGE: `size` is off. Any thread.
 */
FURROW_API furrow_status furrow_measure(const char *object, struct furrow_shape *shape);

/*
 * Adds a body. `object`: YAML of one entry of the scene's `objects`, as in "{shape: {sphere: {radius: 0.2}}}". `name` may be
 * absent; the body is then body-N, the first such name that is free. The body is the host's: without a path, and it touches nothing
 * until it is placed. *body gets its handle, or -1 when the call fails. FURROW_INPUT: the text is no such entry, it has a path, or its name is taken.
 */
FURROW_API furrow_status furrow_body_add(struct furrow_world *world, const char *object, furrow_body *body);

/* Finds a body of the scene, or an added one, by its name. FURROW_INPUT: there is none; *body is -1 then. */
FURROW_API furrow_status furrow_body_find(struct furrow_world *world, const char *name, furrow_body *body);

/* Takes a body away. Its soil is unloaded. FURROW_USAGE: it is gone already. */
FURROW_API furrow_status furrow_body_remove(struct furrow_world *world, furrow_body body);

/*
 * Tells what the soil would do to `count` bodies in these states, and changes nothing. For hosts that integrate motion and ask
 * many times a step. The force is that of a straight motion from the body's last contact to the state; stiffness and damping
 * tell how it changes around that. It reads the ground as the last step left it, on the CPU. Where bodies are over the same ground the lowest bears.
 * Bodies of this call are in the states that are given, all others where they are.
 * `bodies`, `states`, `contacts`: `count` entries each. `contact_size`: sizeof(struct furrow_contact). `count` 0: does nothing.
 * contact.state is FURROW_UNKNOWN, and its numbers are NaN, off the terrain, for a body with a path, and for one that was not
 * placed. It is so under all soil models but scm, and where a state lies hundreds of working posts from the body's last contact.
 * A velocity of three NaN is that of the poses, as furrow_set_states has it, in a step of the scene's time_step.
 * A host may leave the turns of a wheel or a sphere out of its poses. If it did so in the last step, the body turns here by `angular`, for as long
 * as its way takes at `linear`.
 * FURROW_USAGE and FURROW_INPUT as furrow_set_states. FURROW_FAILED: ground could not be read; some contacts may be filled all the same.
 */
FURROW_API furrow_status furrow_probe(struct furrow_world *world, size_t count, const furrow_body *bodies,
				      const struct furrow_state *states, struct furrow_contact *contacts, size_t contact_size);

/*
 * Says where `count` bodies are at the end of the next step. `bodies`, `states`: `count` entries each; 0: does nothing.
 * The way comes from poses; slip and spin come from `linear` and `angular`. Motion accumulates. It changes the ground after a
 * working post of travel or turn, or a tenth of a post of sinkage. It also does so at a checkpoint, and before a query.
 * `linear` or `angular` of three NaN: that of the straight motion to this pose, in the time of the next step. It begins at the pose after the
 * last step, or where furrow_place put the body since. Of several calls before a step the last one counts. The body turns the shorter way:
 * if it turns by more than half a turn in a step, give `angular`. A body that is not set before a step does not move in it. Velocities that
 * were given then stay; those of the poses are 0. A velocity of 0 is given, too: a wheel with it is locked.
 * The log is told once of a body whose velocities and poses differ by more than half in three steps on end.
 * FURROW_USAGE: a body follows a path, is gone, was never placed, or is twice in the list. Or a number is NaN or infinite (but for the above), or
 * a quaternion is not of length 1. A body may have any attitude. The axle of a wheel is its own y axis, and may have camber.
 */
FURROW_API furrow_status furrow_set_states(struct furrow_world *world, size_t count, const furrow_body *bodies,
					   const struct furrow_state *states);

/* A belt that runs over a body: a track. */
struct furrow_belt {
	double travel; /* m that it has run over the body, counted from anywhere: a wheel's angle times its radius, so to say */
	double speed;  /* m/s */
};

/*
 * Says where the belts of `count` bodies are at the end of the next step, and in probes from now on. A body has a belt if its shape
 * is a box or a mesh with `belt: true`. The belt runs around the body's own y axis, as a wheel turns forward. While it travels as far
 * as the body it does not slip. The first call for a body says from where its travel is counted, and so moves nothing.
 * `bodies`, `belts`: `count` entries each; 0: does nothing. FURROW_USAGE: a body has no belt, follows a path, or is gone. Or a
 * number is NaN or infinite.
 */
FURROW_API furrow_status furrow_set_belts(struct furrow_world *world, size_t count, const furrow_body *bodies,
					  const struct furrow_belt *belts);

/*
 * Puts a body somewhere without touching what is between, at rest. It touches the ground from the next step on.
 * FURROW_USAGE and FURROW_INPUT as furrow_set_states.
 */
FURROW_API furrow_status furrow_place(struct furrow_world *world, furrow_body body, const struct furrow_pose *pose);

/* Fills `count` states: where bodies are now. Of a body that was never placed they are NaN. */
FURROW_API furrow_status furrow_get_states(struct furrow_world *world, size_t count, const furrow_body *bodies,
					   struct furrow_state *states);

/*
 * Fills `count` contacts: what the soil did to bodies in the last step. May wait for that step's work.
 * `contact_size`: sizeof(struct furrow_contact). stiffness and damping are NaN for bodies with a path, and under all soil
 * models but scm.
 */
FURROW_API furrow_status furrow_get_contacts(struct furrow_world *world, size_t count, const furrow_body *bodies,
					     struct furrow_contact *contacts, size_t contact_size);

/* --- vehicles of the scene: MuJoCo computes their motion, the soil carries them, furrow_step moves them --- */

/*
 * A handle: the vehicle's number among the scene's `vehicles`, from 0 on. A vehicle follows the scene's `driver`, if it has one. The host
 * may set its controls instead. Its soil geoms are bodies of the world with the name VEHICLE.GEOM: furrow_body_find finds them,
 * furrow_get_states and furrow_get_contacts tell of them. They cannot be placed, set or removed. When the world is opened the vehicles
 * are set down and come to rest. A step is then one time_step, or a multiple of it.
 */
typedef int32_t furrow_vehicle;

/* Finds a vehicle of the scene by its name. FURROW_INPUT: there is none; *vehicle is -1 then. */
FURROW_API furrow_status furrow_vehicle_find(struct furrow_world *world, const char *name, furrow_vehicle *vehicle);

enum furrow_part {
	FURROW_JOINT,    /* a hinge or a slide */
	FURROW_ACTUATOR, /* what a control sets */
	FURROW_SOIL_GEOM, /* what touches the ground; its name is that of its body in the world, VEHICLE.GEOM */
	FURROW_MODEL_BODY /* a body of its model, which furrow_set_force pushes */
};

/*
 * Returns the name of a part of a vehicle, "" if the model gives it none; NULL: the vehicle has no more than `index` of them.
 * The string is the world's, valid until it is closed.
 */
FURROW_API const char *furrow_vehicle_part(const struct furrow_world *world, furrow_vehicle vehicle, enum furrow_part part, size_t index);

/* Where a vehicle is, and what it has done. Filled by furrow_vehicle_get. */
struct furrow_vehicle_state {
	size_t size;               /* sizeof(struct furrow_vehicle_state) */
	struct furrow_state state; /* of its root body */
	double mass;               /* kg */
	double distance;           /* m in plan, since the start */
	double kinetic;            /* J */
	double work;               /* J that its actuators have done since the start */
	size_t joints, actuators, soil_geoms; /* how many of each part */
	bool arrived;              /* at the end of its driver's path */
};

/* Fills *state, whose `size` the caller has set. FURROW_USAGE: there is no such vehicle, or `size` is off. */
FURROW_API furrow_status furrow_vehicle_get(struct furrow_world *world, furrow_vehicle vehicle, struct furrow_vehicle_state *state);

/*
 * Fills what the joints of a vehicle have. `values`: rad of hinges and m of slides, from the model's first pose on. `rates`: rad/s and m/s.
 * `count`: the number of its joints. Either array may be NULL. FURROW_USAGE: `count` is off.
 */
FURROW_API furrow_status furrow_get_joints(struct furrow_world *world, furrow_vehicle vehicle, size_t count, double *values, double *rates);

/*
 * Fills what the actuators of a vehicle did in the last step: their `controls`, and their `forces` in N or N m before `gear`.
 * `count`: the number of its actuators. Either array may be NULL. FURROW_USAGE: `count` is off.
 */
FURROW_API furrow_status furrow_get_actuators(struct furrow_world *world, furrow_vehicle vehicle, size_t count, double *controls,
					      double *forces);

/*
 * Sets the controls of a vehicle for all steps from now on, in the order of its actuators. `controls`: `count` numbers, the number of
 * its actuators; NaN: the scene's driver sets that one, or 0 without a driver. The model's ctrlrange holds. A rollback keeps them.
 * FURROW_USAGE: `count` is off, or a number is infinite.
 */
FURROW_API furrow_status furrow_set_controls(struct furrow_world *world, furrow_vehicle vehicle, size_t count, const double *controls);

/*
 * Sets the force from outside on a body of a vehicle for all steps from now on, as a rope or the wind has it. It adds to the scene's `pushes`.
 * `body`: its number among the vehicle's parts FURROW_MODEL_BODY. `force`, `torque`: 3 numbers each, N and N m, along east, north and up,
 * at the body's centre of mass; NULL: 0. A rollback keeps them, and a store does not. FURROW_USAGE: there is no such body, or a number is not
 * finite.
 */
FURROW_API furrow_status furrow_set_force(struct furrow_world *world, furrow_vehicle vehicle, size_t body, const double *force,
					  const double *torque);

/* --- asking: the newest ground, wherever it is --- */

/* The ground at a point. */
struct furrow_point {
	double height;    /* m; NaN where nodata */
	double normal[3]; /* unit, upward; NaN where nodata */
	double offset;    /* m that deformation added to the base: negative in a rut; NaN where nodata */
	int32_t soil;     /* index among the scene's soils */
	bool nodata;      /* outside the terrain, or in a hole */
};

/*
 * Fills `count` points. `xy`: 2 x `count` numbers, m, local axes: x and y of each point in turn. A point outside the terrain or in a hole is nodata and no failure: its
 * height, offset and normal are NaN.
 * FURROW_USAGE: a NULL or a NaN.
 */
FURROW_API furrow_status furrow_points(struct furrow_world *world, size_t count, const double *xy, struct furrow_point *points);

/* Where a ray meets the ground. */
struct furrow_hit {
	double position[3]; /* m, local axes; NaN where nothing is hit */
	double normal[3];   /* unit, upward */
	double distance;    /* m from the ray's origin */
	bool hit;
};

/*
 * Fills `count` hits: the first place where each ray meets the ground. `origin`: m; `direction`: of any length but 0; local
 * axes, 3 x `count` numbers each: x, y, z of each ray in turn. FURROW_USAGE: a NULL, a NaN, or a direction of length 0.
 */
FURROW_API furrow_status furrow_rays(struct furrow_world *world, size_t count, const double *origin, const double *direction,
				     struct furrow_hit *hits);

/* Metres, but for SHEAR: -1 to 1, and DISTURBANCE, BENT, TORN: 0 to 1. */
enum furrow_layer {
	FURROW_SURFACE,     /* base + offset */
	FURROW_BASE,        /* as imported */
	FURROW_OFFSET,      /* what deformation added */
	FURROW_DEPOSITED,   /* deposited thickness: soil that was moved there */
	FURROW_SINKAGE,     /* plastic sinkage */
	FURROW_SHEAR_X,     /* mobilised shear to the east, a share of the soil's strength: how far it is sheared under a contact */
	FURROW_SHEAR_Y,     /* and to the north; both are 0 where nothing is in contact */
	FURROW_DISTURBANCE, /* as it is now, if it heals */
	FURROW_BENT,        /* share of plants that lie flat, and of plants that are gone */
	FURROW_TORN
};

/*
 * Reads a rectangle of posts of a level, from (column, row) on; row 0 is the southernmost.
 * `posts`: post (c, r) of the rectangle is posts[r * row_stride + c]; row_stride counts posts and is at least `columns`.
 * NaN where there is no post. Layers of the soil's state exist at the working level; elsewhere they are NaN.
 * FURROW_USAGE: a NULL, an unknown layer, a level below the working one or above the coarsest, a stride below `columns`.
 */
FURROW_API furrow_status furrow_read(struct furrow_world *world, enum furrow_layer layer, int level, int64_t column,
				     int64_t row, uint32_t columns, uint32_t rows, double *posts, size_t row_stride);

/* A rectangle of posts of the working level. */
struct furrow_rect {
	int64_t column, row, columns, rows;
};

/*
 * Tells which rectangles of the working level changed since a revision, and the revision now. For engines that keep a copy.
 * `since`: a revision of this world, by an earlier call or by furrow_info; the first is 1. 0: since the store was made.
 * `rects`: room for *count; may be NULL if *count is 0. *count gets the number. `now` may be NULL.
 * FURROW_USAGE: there is too little room; *count and *now are filled then, too. Or `since` has not been yet.
 */
FURROW_API furrow_status furrow_changes(struct furrow_world *world, uint64_t since, struct furrow_rect *rects, size_t *count,
					uint64_t *now);

/* --- soil that is brought and taken, by no body --- */

/*
 * Changes the heights of a rectangle of posts of the working level, from (column, row) on; row 0 is the southernmost. A heap is poured, or a pit dug.
 * Call it between two steps. furrow_rollback takes it back, and furrow_stats counts it as volume.added: offsets + compacted soil are added soil.
 * `heights`: m, below 0: soil is taken. Post (c, r) is heights[r * row_stride + c]; row_stride counts posts and is at least `columns`.
 * They are rounded to 2^-20 m. 0: the post stays.
 * `soil`: index among the scene's soils, or -1: that of each post. A place keeps the class that a soil map gives it, so another one is refused.
 * `loose`: what comes lies as soil that a body has moved, and it slides in later steps where it is steeper than repose. Otherwise it lies as ground
 * that nothing has touched, and stays until a body comes near. A pit's walls stay where nothing has moved the ground before, as cliffs of the
 * terrain do.
 * FURROW_USAGE: a NULL, a NaN, a stride below `columns`, no such soil, a readonly world.
 * FURROW_INPUT: the rectangle is not all on the terrain, or on too many tiles. Or a post that is to change is a hole, or lies below a body in the
 * ground. Or it would be more than 700 m off its base. Nothing has changed then.
 * A furrow_world is used by one thread at a time. `heights` stay the caller's.
 */
FURROW_API furrow_status furrow_pour(struct furrow_world *world, int64_t column, int64_t row, uint32_t columns, uint32_t rows,
				     const double *heights, size_t row_stride, int32_t soil, bool loose);

/*
 * The same for a volume that lies evenly on all posts in a polygon.
 * `xy`: 2 x `count` numbers, m, local axes: x and y of each corner in turn, at least 3. The last corner is joined to the first. Where outlines cross, a
 * place that lies inside twice is outside.
 * `volume`: m3, below 0: taken. It is rounded to units of spacing^2 x 2^-20 m, of which none is lost.
 * FURROW_INPUT: also a corner off the terrain, or a polygon without a post.
 */
FURROW_API furrow_status furrow_pour_polygon(struct furrow_world *world, size_t count, const double *xy, double volume, int32_t soil, bool loose);

/* --- looking --- */

/* What is looked at, and how large the picture is. */
struct furrow_camera {
	size_t size;             /* sizeof(struct furrow_camera) */
	struct furrow_pose pose; /* it looks along its own x; its z is up in the picture */
	double fovy;             /* rad: the vertical angle of view, above 0 and below pi */
	uint32_t width, height;  /* pixels, 1 to 8192 each */
};

/*
 * Draws a picture of the newest ground. Rows come from the top. The scene's `view` says what is drawn, and may be absent. Then the
 * effects are texture, detail, fog, sky, geomorph, skirts, objects and shadow. With `objects` the bodies are drawn that were placed or
 * follow a path, also those that were added. The first picture after a body was added takes longer.
 * `rgb`: 3 x width x height bytes, sRGB. `depth`: width x height metres along the view direction; INFINITY: sky. Either may
 * be NULL. What drawing needs is made at the first call. FURROW_USAGE: a NaN, a size that is off.
 */
FURROW_API furrow_status furrow_render(struct furrow_world *world, const struct furrow_camera *camera, uint8_t *rgb,
				       float *depth);

#ifdef __cplusplus
}
#endif

#endif
