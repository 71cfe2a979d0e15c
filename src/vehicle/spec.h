/*
 * Reads a model as MuJoCo's spec, mends what files of strangers lack, and compiles it.
 *
 * A URDF says nothing of how its root moves, and has no actuators. Links may have no mass, or an inertia that no body can have. Meshes lie in packages.
 * What is done about it is told, one line for each kind.
 */
#ifndef FURROW_VEHICLE_SPEC_H
#define FURROW_VEHICLE_SPEC_H

#include "vehicle/internal.h"

struct spec {
	const char *where, *path;   /* the vehicle, for messages; the model's file */
	const struct scene_vehicle *scene;
	double gravity;             /* m/s2, of the scene */
	bool urdf;
	bool welded;                /* a link named world holds it */
	mjSpec *spec;               /* NULL: only names are looked up */
	const char *meshdir;        /* without a spec; NULL: none */
	mjModel *model;
	mjData *data;
	int keyframe;               /* -1: none */
	char error[400];
	enum status status;         /* of what is not MuJoCo's */
};

/* Makes vehicle->model and vehicle->data. STATUS_INPUT: MuJoCo refuses the model; a joint that the driver names is not there. */
enum status vehicle_compile(struct vehicle *vehicle, const struct scene *scene, const char *where) FURROW_CHECKED;

/* Notes "vehicles.NAME: " and the rest. */
void vehicle_spec_tell(const struct spec *spec, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Names for a message: the first ones, and how many more there are. */
struct spec_names {
	char text[160];
	size_t count;
};
void vehicle_spec_name(struct spec_names *names, const char *name);

/* Finds the file of a mesh of a URDF, in the model's folder or in `model_path`. Returns false if it is nowhere, or where the model may not read. */
bool vehicle_spec_find(const struct spec *spec, const char *name, char path[]); /* PATH_MAX bytes */

/* The parts of mending. Each runs within a guard. */
void vehicle_spec_inertias(struct spec *spec);                        /* spec_inertia.c */
enum status vehicle_spec_meshes(struct spec *spec) FURROW_CHECKED;    /* spec_meshes.c */
enum status vehicle_spec_servos(struct spec *spec) FURROW_CHECKED;    /* spec_servos.c */

#endif
