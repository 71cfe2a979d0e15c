/*
 * The typed values of a scene, as its text gives them, and the arrays of rows that describe its keys (scene_row.h).
 *
 * A new key is a member here and a row in scene_schema*.c. The reader, the reference page, the editors' schema and the completions have it
 * then.
 */
#ifndef FURROW_SCENE_SCHEMA_H
#define FURROW_SCENE_SCHEMA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "deform/deform.h"
#include "scene/scene_row.h"

/* Optional values are pointers. They are NULL if the scene does not give them. */
struct raw_tyre {
	char *geom; /* of vehicles: a pattern */
	double stiffness;
	double *width, *load, *pressure, *damping;
};
struct raw_wheel {
	double radius, width;
	struct raw_tyre *tyre;
	int64_t *grousers;
	double *grouser_height, *grouser_thickness;
};
struct raw_sphere {
	double radius;
};
struct raw_box {
	double size[3];
	bool *belt;
};
/* Of a cylinder or a capsule. */
struct raw_rod {
	double radius, length;
};
struct raw_ellipsoid {
	double radii[3];
};
struct raw_mesh {
	char *file;
	double *scale;
	bool *belt;
};
struct raw_shape {
	struct raw_wheel *wheel;
	struct raw_sphere *sphere;
	struct raw_box *box;
	struct raw_mesh *mesh;
	struct raw_rod *cylinder, *capsule;
	struct raw_ellipsoid *ellipsoid;
};
struct raw_path {
	double (*points)[2];
	uint32_t points_count;
	double *speed;
	bool *loop;
	char *file;
	int64_t *line;
	double *rotate; /* degrees */
	double *offset;
	uint32_t offset_count;
	char *relative_to;
	double *delay;
	bool *smooth;
	double *speeds; /* of a vehicle's path */
	uint32_t speeds_count;
	double (*stop)[2];
	uint32_t stop_count;
};
struct raw_interface {
	double *friction_angle, *adhesion; /* degrees, Pa */
};
struct raw_object {
	char *name;
	struct raw_shape shape;
	struct raw_path *path;
	double *sink, *load, *slip;
	bool *carry;
	double *attitude; /* 3: yaw, pitch, roll */
	uint32_t attitude_count;
	struct raw_interface *interface;
};
/* One class of soil. Angles are in degrees. */
struct raw_class {
	int64_t value; /* in a table of classes: the raster's value of this class */
	char *name;
	double *bekker_kc, *bekker_kphi, *bekker_n, *cohesion, *friction_angle, *janosi_shear;
	double *elastic_stiffness, *damping, *density, *unit_weight, *face_strength, *face_cohesion, *repose;
	double *theta_in, *theta_out, *theta_stop, *roughness, *compression;
	double *thickness, *compaction;
	struct raw_class *over; /* it has no thickness and no soil below */
};
/* Paths of rasters. */
struct raw_rasters {
	char *bekker_kc, *bekker_kphi, *bekker_n, *cohesion, *friction_angle, *janosi_shear, *elastic_stiffness, *thickness, *compaction;
};
struct raw_soil {
	struct raw_class all; /* if the scene has one soil, it is this one */
	char *map;
	struct raw_class *classes;
	uint32_t classes_count;
	struct raw_class *elsewhere;
	struct raw_rasters *rasters;
};
struct raw_road {
	char *lines;
	double (*points)[2];
	uint32_t points_count;
	bool *smooth;
	double width;
	struct raw_class soil;
};
struct raw_rocks {
	double cover, largest, *k, *smallest;
	int64_t *seed;
};
struct raw_ground {
	struct raw_road *roads;
	uint32_t roads_count;
	struct raw_rocks *rocks;
};
struct raw_relief_class {
	int64_t value; /* the raster's value of this class */
	double roughness, *wavelength;
};
struct raw_relief {
	double roughness, wavelength;
	int64_t *seed;
	struct raw_relief_class *classes;
	uint32_t classes_count;
};
struct raw_disturbance {
	double *heals;
};
struct raw_cover {
	int64_t value; /* the raster's value of this class */
	double cover;
};
struct raw_vegetation {
	double *cover, *height, *tears, *rises, *grows;
	struct raw_cover *classes;
	uint32_t classes_count;
};
struct raw_attributes {
	struct raw_disturbance *disturbance;
	struct raw_vegetation *vegetation;
	double *elapsed;
};
#define SCENE_LOOSENING 0 /* of scenes that do not give it */
#define SCENE_INERTIA 1   /* the same */
struct raw_redistribute {
	int model; /* enum deform_model */
	int64_t *radius, *repetitions, *iterations;
	double *interval, *depth, *tolerance, *bulldozing, *slip_sinkage, *loosening, *hardening, *inertia, *tension, *stiffness, *yield, *rut;
	int *undisturbed; /* enum scene_undisturbed */
	int *normals;     /* enum scene_normals */
	int *faces;       /* enum scene_faces */
	int *regions;     /* enum scene_regions */
	int *thrown;      /* enum scene_thrown */
};
struct raw_output {
	double *forces;
	int64_t *delay;
	double *vehicles, *sensors;
	int64_t *noise_seed;
	bool *map;
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
	char *time;
	double *at; /* degrees */
	uint32_t at_count;
	double *colour;
	uint32_t colour_count;
};
struct raw_view {
	int64_t *size;
	uint32_t size_count;
	struct raw_camera *camera; /* NULL: of a host, which has its own */
	char **effects;
	uint32_t effects_count;
	int64_t *images, *samples;
	double *pixel_error, *imagery_budget;
	bool *truth;
	int *exposure; /* enum scene_exposure */
	double *ev;
	int *body; /* enum scene_body */
	struct raw_sun *sun;
};
/* An entry of `cameras`. Angles are in degrees. */
struct raw_camera_pose {
	double at[3];
	double *target;
	uint32_t target_count;
	double *yaw, *pitch, *roll;
};
struct raw_listed_camera {
	char *name;
	int kind; /* enum scene_camera_kind */
	char *on, *body;
	struct raw_camera_pose *pose;
	double *back, *up, *height;
	char *file;
	double *fov;
	int64_t *size;
	uint32_t size_count;
	double rate;
	char **images;
	uint32_t images_count;
	double *depth_unit, *stereo;
	int *exposure; /* enum scene_exposure */
	double *ev;
	bool *video;
};
struct raw_lidar {
	char *name, *on, *body;
	struct raw_camera_pose *pose;
	int64_t *rays;
	uint32_t rays_count;
	double *fov, *range;
	uint32_t fov_count, range_count;
	double rate;
	double *noise, *dropout;
};
struct raw_imu {
	char *body;
	double *at, *noise;
	uint32_t at_count, noise_count;
};
struct raw_cache {
	int64_t *slots, *loaders;
	char *memory;
	double *prefetch;
};
struct raw_servo {
	double *kv, *torque;
	char **free, **lock;
	uint32_t free_count, lock_count;
};
struct raw_clutch {
	double *torque, *engage;
};
struct raw_converter {
	double capacity;
	double *ratio, *coupling;
};
struct raw_differentials {
	int *centre, *front, *rear; /* enum scene_differential */
	double *bias, *lock;
};
struct raw_powertrain {
	char **wheels;
	uint32_t wheels_count;
	char *engine;
	double (*torque)[2];
	uint32_t torque_count;
	double *inertia, *idle, *drag;
	double *gears;
	uint32_t gears_count;
	double *reverse, *final;
	double *shift;
	uint32_t shift_count;
	double *shift_time;
	struct raw_clutch *clutch;
	struct raw_converter *converter;
	struct raw_differentials *differentials;
};
struct raw_control {
	char *name; /* of an actuator or a joint */
	double value;
};
struct raw_start {
	double at[2];
	double *yaw, *pitch, *roll; /* degrees */
	double *height, *speed;
	struct raw_control *joints;
	uint32_t joints_count;
	struct raw_control *controls;
	uint32_t controls_count;
	bool *settle, *fixed;
	char *keyframe;
};
struct raw_driver {
	struct raw_path *path;
	char **steer, **drive; /* patterns of actuators' names */
	uint32_t steer_count, drive_count;
	char *controls;
	struct raw_control *hold;
	uint32_t hold_count;
	int *follow; /* 0: axle, 1: origin */
};
struct raw_surface {
	char *geoms;
	int *material; /* enum scene_material */
	double *friction_angle, *adhesion; /* degrees, Pa */
};
struct raw_vehicle {
	char *name, *model;
	struct raw_start start;
	char **soil, **no_soil, **carry; /* patterns of geoms' names */
	uint32_t soil_count, no_soil_count, carry_count;
	char **model_path;
	uint32_t model_path_count;
	struct raw_servo *servo;
	struct raw_powertrain *powertrain;
	double *brakes;
	struct raw_tyre *tyres;
	uint32_t tyres_count;
	struct raw_driver *driver;
	int *forward; /* enum scene_forward */
	int *up;      /* 0: z, 1: y */
	struct raw_surface *interface;
	uint32_t interface_count;
	char *pushes;
	struct raw_imu *imu;
};
struct raw_stuck {
	double after, below;
};
struct raw_scene {
	int64_t *scene;
	char *store;
	double *time_step, *end_time;
	double *gravity, *spacing;
	char *coordinates;
	struct raw_soil *soil;
	struct raw_ground *ground;
	struct raw_relief *relief;
	struct raw_redistribute *redistribute;
	struct raw_attributes *attributes;
	int *outside; /* enum scene_outside */
	int *compute; /* enum scene_compute */
	struct raw_object *objects;
	uint32_t objects_count;
	struct raw_vehicle *vehicles;
	uint32_t vehicles_count;
	char *world;
	struct raw_stuck *stuck;
	char **stop;
	uint32_t stop_count;
	struct raw_output *output;
	struct raw_view *view;
	struct raw_listed_camera *cameras;
	uint32_t cameras_count;
	struct raw_lidar *lidars;
	uint32_t lidars_count;
	struct raw_cache *cache;
};

/* The rows of mappings that have a file of their own. */
extern const struct scene_row scene_soil_rows[], scene_ground_rows[], scene_redistribute_rows[]; /* scene_schema_soil.c */
extern const struct scene_row scene_object_rows[];                                             /* scene_schema_objects.c */
extern const struct scene_row scene_vehicle_rows[];                                            /* scene_schema_vehicles.c */
extern const struct scene_row scene_view_rows[], scene_camera_rows[], scene_lidar_rows[];       /* scene_schema_view.c */

#endif
