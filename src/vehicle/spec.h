/*
 * Reads a model as MuJoCo's spec, mends what files of strangers lack, and compiles it.
 *
 * A URDF says nothing of how its root moves, and has no actuators. Links may have no mass, or an inertia that no body can have. Meshes lie in packages.
 * What is done about it is told, one line for each kind.
 */
#ifndef FURROW_VEHICLE_SPEC_H
#define FURROW_VEHICLE_SPEC_H

#include <limits.h>
#include <math.h>
#include <string.h>

#include "vehicle/internal.h"

/* Names for a message: the first ones, and how many more there are. */
struct spec_names {
	char text[160];
	size_t count;
};

struct spec {
	const char *where, *path;   /* the vehicle, for messages; the model's file */
	const struct scene_vehicle *scene;
	double gravity;             /* m/s2, of the scene */
	bool urdf;
	bool things;                /* no vehicle, but the things of the scene's `world` */
	bool welded;                /* a link named world holds it */
	mjSpec *spec;               /* NULL: only names are looked up */
	const char *meshdir;        /* without a spec; NULL: none */
	mjModel *model;
	mjData *data;
	int keyframe;               /* -1: none */
	char **files;               /* of a URDF: mesh files as it names them; MuJoCo gets SPEC_FILE and the number */
	size_t file_count, file_room;
	struct spec_mimic *mimics;  /* of a URDF */
	size_t mimic_count, mimic_room;
	uint64_t *told;             /* hashes of the notes that were told */
	size_t told_count, told_room;
	struct spec_names lost;     /* meshes whose shapes are left out, since their files are not there or cannot be read */
	char flat[160];             /* the mesh without a volume that MuJoCo refused last; empty: none */
	bool bounded;               /* MuJoCo refused a link as too light: all get a least mass */
	size_t tries;               /* how often it was made */
	char package[200], package_folder[PATH_MAX]; /* the package that was looked for last by its package.xml, and its folder; "": none was found */
	char error[400];
	enum status status;         /* of what is not MuJoCo's */
};

/* Returns true if a joint has limits: an arm has them, a wheel turns without an end. */
static inline bool vehicle_spec_limited(const mjsJoint *joint)
{
	return joint->limited == mjLIMITED_TRUE || (joint->limited == mjLIMITED_AUTO && joint->range[0] < joint->range[1]);
}

/* Returns where a joint is in the first pose, rad or m: at `value`, or at the limit next to it. */
static inline double vehicle_spec_first(bool limited, const double range[2], double value)
{
	return limited ? fmin(fmax(value, range[0]), range[1]) : value;
}

#define SPEC_LOCK "locked: "   /* begins the name of an equality that locks a joint of a URDF */
#define SPEC_FILE "furrow-" /* begins the name of a mesh file of a URDF in MuJoCo */

/* A joint of a URDF that follows another one: its place is plus + times * that of the other. */
struct spec_mimic {
	char joint[200], of[200];
	double times, plus;
};

/* Makes vehicle->model and vehicle->data. STATUS_INPUT: MuJoCo refuses the model; a joint that the driver names is not there. */
enum status vehicle_compile(struct vehicle *vehicle, const struct scene *scene, const char *where) FURROW_CHECKED;

/* Notes "vehicles.NAME: " and the rest, once. */
void vehicle_spec_tell(struct spec *spec, const char *format, ...) __attribute__((format(printf, 2, 3)));

void vehicle_spec_name(struct spec_names *names, const char *name);

/* Finds the file of a mesh of a URDF, in the model's folder or in `model_path`. Returns false if it is nowhere, or where the model may not read. */
bool vehicle_spec_find(struct spec *spec, const char *name, char path[]); /* PATH_MAX bytes */
static inline const char *vehicle_spec_base(const char *path) /* returns what is behind its last slash */
{
	const char *slash = strrchr(path, '/');
	return slash != NULL ? slash + 1 : path;
}

/* Returns the mass of all inertials of the file, kg. */
double vehicle_spec_mass(const struct spec *spec);

/* --- spec_text.c --- */
/* Reads a URDF, and changes what MuJoCo refuses or mixes up. Free *out with mem_free. STATUS_INPUT: it cannot be read. */
enum status vehicle_spec_text(struct spec *spec, char **out) FURROW_CHECKED;
/* Returns a mesh file's name as the model has it. */
const char *vehicle_spec_file(const struct spec *spec, const char *name);
void vehicle_spec_free(struct spec *spec); /* all but its spec, model and data */

/* The parts of mending. Each runs within a guard. */
void vehicle_spec_parts(struct spec *spec);                           /* spec_parts.c: shapes, skins, names, mimics */
bool vehicle_spec_flat(struct spec *spec);                            /* whether what spec->error is about can be mended: then it is made again */
void vehicle_spec_shells(struct spec *spec);
bool vehicle_spec_weighs(mjsElement *geom, const char *mesh);         /* whether the geom is of this mesh, and its body gets its mass from it */
void vehicle_spec_inertias(struct spec *spec);                        /* spec_inertia.c */
enum status vehicle_spec_meshes(struct spec *spec) FURROW_CHECKED;    /* spec_meshes.c: files of meshes and images */
enum status vehicle_spec_servos(struct spec *spec) FURROW_CHECKED;    /* spec_servos.c */
enum status vehicle_spec_locks(struct spec *spec) FURROW_CHECKED;     /* spec_locks.c; after servos */
enum status vehicle_spec_powertrain(struct spec *spec) FURROW_CHECKED; /* spec_powertrain.c; before servos */
enum status vehicle_spec_imu(struct spec *spec) FURROW_CHECKED;       /* spec_imu.c: the scene's imu. STATUS_INPUT: the model has no such body */

#endif
