/*
 * furrow_mujoco.h: the soil of a world under a model of MuJoCo that the host owns and steps itself.
 *
 * libfurrow_mujoco.so, the engine plugin furrow.soil, and Python's furrow.mujoco are made of these functions. Use one of them, unless you write C and have
 * a loop of your own. A step of the host:
 *
 *     furrow_mujoco_begin -> (MuJoCo's step -> furrow_mujoco_limit) ... -> furrow_mujoco_end -> furrow_mujoco_touch
 *
 * The soil's forces answer a change of the velocities within the step. So the step is implicit in them, and stable at the model's own timestep. For that
 * they are added to the inertia M between MuJoCo's mj_step1 and mj_step2. Calls in another order are FURROW_USAGE.
 *
 * Units, errors, threads and ownership are as in furrow.h. One thread at a time uses a struct furrow_mujoco and its world.
 */
#ifndef FURROW_MUJOCO_H
#define FURROW_MUJOCO_H

#include "furrow.h"

#ifdef __cplusplus
extern "C" {
#endif

struct furrow_mujoco; /* owned by whoever opened it. Once its world is closed, only furrow_mujoco_close takes it */

/* An array of the host's mjModel or mjData, by the name of its member, such as "model.geom_type" or "data.qvel". It stays where it is. */
struct furrow_array {
	const char *name;
	void *at;
};

/* How a model is given. */
struct furrow_mujoco_open {
	size_t size;        /* sizeof(struct furrow_mujoco_open) */
	struct furrow_world *world;
	const char *name;   /* for messages, and for names of bodies: NAME.GEOM. NULL: "mujoco" */
	const void *model;  /* const mjModel *, const mjData *, of the version that furrow_mujoco_version tells, with places and inertia computed. Both NULL: */
	const void *data;   /* `arrays` have all that is needed of them */
	const struct furrow_array *arrays;
	size_t array_count;
	const char *geoms;  /* patterns of the geoms that touch the ground, between spaces, as in "wheel_* chassis"; NULL: all that collide */
	double origin[3];   /* m, local axes: where MuJoCo's origin is */
	const char *carry;  /* patterns of those of them on which soil lies, boxes and meshes such as buckets; its weight is theirs. NULL: none */
	/* Tyres: "wheel_* stiffness 50000 load 981; ...". Each has a pattern of wheels, N/m, and N. There may be a pressure, Pa, a damping, N s/m, and a width, m. They are as
	 * in the `tyres` of a scene's vehicle. The first that names a wheel counts. NULL: wheels are rigid. */
	const char *tyres;
};

/* Returns the version of MuJoCo whose structs are known, as mj_version has it; 0: this build has none. Any thread. */
FURROW_API int furrow_mujoco_version(void);
/* Returns where mj_version is in the library of MuJoCo that this library has loaded; NULL: it has loaded none yet. The engine plugin tells the host's
 * MuJoCo from this one by it. Any thread. */
FURROW_API const void *furrow_mujoco_own(void);

/*
 * Makes bodies of the world of a model's geoms, and a checkpoint: furrow_mujoco_reset returns to it. *out gets the soil, or NULL when the call fails.
 * Close it with furrow_mujoco_close. FURROW_INPUT: no geom touches the ground, a shape cannot, an array is missing. FURROW_FAILED: MuJoCo cannot be loaded.
 */
FURROW_API furrow_status furrow_mujoco_open(const struct furrow_mujoco_open *open, struct furrow_mujoco **out);
/*
 * Frees it, and takes its bodies out of the world, unless the world is closed already. A rollback to a checkpoint that had them brings the bodies back, and so
 * their names. Takes NULL.
 */
FURROW_API void furrow_mujoco_close(struct furrow_mujoco *soil);

/*
 * Begins a step of `seconds`. The places and velocities of bodies, and the inertia, are computed, as mj_step1 does. `data`: const mjData *, which
 * furrow_mujoco_open got, or NULL with arrays. `forces`, nv numbers, get what the soil does to the joints if the velocities stay. The inertia in
 * data.M gets how that answers a change: factor it, and project constraints anew where the solver is PGS. again: the same step from another state in
 * it, as RK4 has; what the soil does is then linear about what was found first.
 * FURROW_FAILED: a geom has left the terrain. FURROW_USAGE: `data` is NULL and there are no arrays, or `again` without a step that has begun.
 */
FURROW_API furrow_status furrow_mujoco_begin(struct furrow_mujoco *soil, const void *data, double seconds, bool again, double *forces);
/* With the velocities at the step's end, nv: *again tells that a contact would pull, or shear too much. Then `forces` and the inertia are new, and
 * the step is to be made once more. Three times are enough. */
FURROW_API furrow_status furrow_mujoco_limit(struct furrow_mujoco *soil, const double *qvel, bool *again, double *forces);
/* Fills `forces`, nv: what the soil does to the joints in the step that ends with the velocities qvel. The same step with these as constant forces, and with
 * MuJoCo's own inertia, ends with qvel, too. */
FURROW_API furrow_status furrow_mujoco_forces(struct furrow_mujoco *soil, const double *qvel, double *forces);
/* Ends the step with the velocities qvel, nv. The inertia is again as it was. */
FURROW_API furrow_status furrow_mujoco_end(struct furrow_mujoco *soil, const double *qvel);
/* Changes the ground by the step that has ended: the places of bodies are computed from its end. Without one it does nothing. A geom that the host has put
 * elsewhere touches nothing on its way. */
FURROW_API furrow_status furrow_mujoco_touch(struct furrow_mujoco *soil, const void *data);
/* Goes back to the ground at furrow_mujoco_open. FURROW_USAGE: the world got another checkpoint since, and it keeps the last one alone. */
FURROW_API furrow_status furrow_mujoco_reset(struct furrow_mujoco *soil);

/* Returns how many soil geoms there are; 0 for NULL. */
FURROW_API size_t furrow_mujoco_count(const struct furrow_mujoco *soil);
/* Tells of one: its number in the host's model, its name, what the soil did to it in the last step. Any pointer but `soil` may be NULL. *name is valid as
 * long as `soil`. `contact_size`: sizeof(struct furrow_contact). */
FURROW_API furrow_status furrow_mujoco_geom(const struct furrow_mujoco *soil, size_t index, int *geom, const char **name, struct furrow_contact *contact, size_t contact_size);

#ifdef __cplusplus
}
#endif

#endif
