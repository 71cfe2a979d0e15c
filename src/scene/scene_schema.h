/*
 * What a scene may say: the typed values as cyaml loads them, the tables it loads them by, the
 * ranges of the numbers. The tables are also what scene_match checks the tree against, so that each
 * key is described once.
 */
#ifndef FURROW_SCENE_SCHEMA_H
#define FURROW_SCENE_SCHEMA_H

#include <cyaml/cyaml.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "deform/deform.h"

/* Optional values are pointers, NULL when absent. */
struct raw_wheel {
	double radius, width;
	int64_t *grousers;
	double *grouser_height, *grouser_thickness;
};
struct raw_sphere {
	double radius;
};
struct raw_box {
	double size[3];
};
struct raw_mesh {
	char *file;
	double *scale;
};
struct raw_shape {
	struct raw_wheel *wheel;
	struct raw_sphere *sphere;
	struct raw_box *box;
	struct raw_mesh *mesh;
};
struct raw_path {
	double (*points)[2];
	uint32_t points_count;
	double *speed;
	bool *loop;
	char *file;
};
struct raw_object {
	char *name;
	struct raw_shape shape;
	struct raw_path *path;
	double *sink, *load, *slip;
};
/* One class of soil, angles in degrees. */
struct raw_class {
	int64_t value; /* in a table: the raster's */
	char *name;
	double *bekker_kc, *bekker_kphi, *bekker_n, *cohesion, *friction_angle, *janosi_shear;
	double *elastic_stiffness, *damping, *unit_weight, *repose;
	double *theta_in, *theta_out, *theta_stop, *roughness, *compression;
};
struct raw_soil {
	struct raw_class all; /* of the only soil there is */
	char *map;
	struct raw_class *classes;
	uint32_t classes_count;
	struct raw_class *elsewhere;
};
struct raw_redistribute {
	int model; /* enum deform_model */
	int64_t *radius, *repetitions, *iterations;
	double *interval, *depth, *tolerance, *bulldozing;
	int *undisturbed; /* enum scene_undisturbed */
};
struct raw_output {
	double *forces;
	int64_t *delay;
};
struct raw_overhead {
	char *over;
	double height;
};
struct raw_fixed {
	double eye[3], target[3];
};
struct raw_camera {
	char *chase;
	double *back, *up;
	struct raw_overhead *overhead;
	struct raw_fixed *fixed;
};
struct raw_sun {
	double *azimuth, *height; /* degrees */
	double *colour;
	uint32_t colour_count;
};
struct raw_view {
	int64_t *size;
	uint32_t size_count;
	struct raw_camera camera;
	char **effects;
	uint32_t effects_count;
	int64_t *images, *samples;
	double *pixel_error;
	int *body; /* enum scene_body */
	struct raw_sun *sun;
};
struct raw_cache {
	int64_t *slots, *loaders;
	double *prefetch;
};
struct raw_scene {
	int64_t *scene;
	char *store;
	double *time_step, *end_time;
	double *gravity, *spacing;
	char *coordinates;
	struct raw_soil *soil;
	struct raw_redistribute *redistribute;
	char **attributes;
	uint32_t attributes_count;
	int *outside; /* enum scene_outside */
	struct raw_object *objects;
	uint32_t objects_count;
	struct raw_output *output;
	struct raw_view *view;
	struct raw_cache *cache;
};

extern const cyaml_schema_value_t scene_schema;

/* Returns true when the schema calls this key optional and the command demands it all the same. A host
 * may leave it out. `where`: a path with anonymous indices. */
bool scene_needed_by_command(const char *where);

/* The range of the number at `where`, a path with anonymous indices: low .. high, without `low`
 * itself if `above`. A soil's are those of `soil.`, wherever it is written. */
struct scene_limit {
	const char *where;
	double low, high;
	bool above;
	const char *why; /* said in place of "is out of range", or NULL */
	const char *unit; /* NULL: a number, or a share of 1 */
	double absent;    /* what it is where the scene does not say; NAN: what `otherwise` says, */
	const char *otherwise; /* or (NULL) it must be given where its mapping is */
};
const struct scene_limit *scene_limit_of(const char *where); /* NULL: any finite number */
double scene_absent(const char *where); /* of a number that has one */

#endif
