/* Defines the tables that describe every key of a scene. See scene_schema.h. */
#include "scene/scene_schema.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_template.h"

#define OPTIONAL CYAML_FLAG_OPTIONAL
#define OPTIONAL_POINTER (CYAML_FLAG_OPTIONAL | CYAML_FLAG_POINTER)
#define NEEDED CYAML_FLAG_DEFAULT

static const cyaml_schema_value_t float_entry = {CYAML_VALUE_FLOAT(CYAML_FLAG_DEFAULT, double)};
static const cyaml_schema_value_t int_entry = {CYAML_VALUE_INT(CYAML_FLAG_DEFAULT, int64_t)};
static const cyaml_schema_value_t word_entry = {
	CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char *, 1, 64)};
static const cyaml_schema_value_t point_entry = {
	CYAML_VALUE_SEQUENCE_FIXED(CYAML_FLAG_DEFAULT, double, &float_entry, 2)};

static const cyaml_schema_field_t tyre_fields[] = {
	CYAML_FIELD_FLOAT("stiffness", NEEDED, struct raw_tyre, stiffness),
	CYAML_FIELD_FLOAT_PTR("load", OPTIONAL, struct raw_tyre, load),
	CYAML_FIELD_FLOAT_PTR("pressure", OPTIONAL, struct raw_tyre, pressure),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t geom_tyre_fields[] = {
	CYAML_FIELD_STRING_PTR("geom", NEEDED, struct raw_tyre, geom, 1, 256),
	CYAML_FIELD_FLOAT("stiffness", NEEDED, struct raw_tyre, stiffness),
	CYAML_FIELD_FLOAT_PTR("width", OPTIONAL, struct raw_tyre, width),
	CYAML_FIELD_FLOAT_PTR("load", OPTIONAL, struct raw_tyre, load),
	CYAML_FIELD_FLOAT_PTR("pressure", OPTIONAL, struct raw_tyre, pressure),
	CYAML_FIELD_FLOAT_PTR("damping", OPTIONAL, struct raw_tyre, damping),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t geom_tyre_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_tyre, geom_tyre_fields)};
static const cyaml_schema_field_t wheel_fields[] = {
	CYAML_FIELD_FLOAT("radius", NEEDED, struct raw_wheel, radius),
	CYAML_FIELD_FLOAT("width", NEEDED, struct raw_wheel, width),
	CYAML_FIELD_INT_PTR("grousers", OPTIONAL, struct raw_wheel, grousers),
	CYAML_FIELD_FLOAT_PTR("grouser_height", OPTIONAL, struct raw_wheel, grouser_height),
	CYAML_FIELD_FLOAT_PTR("grouser_thickness", OPTIONAL, struct raw_wheel, grouser_thickness),
	CYAML_FIELD_MAPPING_PTR("tyre", OPTIONAL, struct raw_wheel, tyre, tyre_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t sphere_fields[] = {
	CYAML_FIELD_FLOAT("radius", NEEDED, struct raw_sphere, radius),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t box_fields[] = {
	CYAML_FIELD_SEQUENCE_FIXED("size", NEEDED, struct raw_box, size, &float_entry, 3),
	CYAML_FIELD_BOOL_PTR("belt", OPTIONAL, struct raw_box, belt),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t rod_fields[] = {
	CYAML_FIELD_FLOAT("radius", NEEDED, struct raw_rod, radius),
	CYAML_FIELD_FLOAT("length", NEEDED, struct raw_rod, length),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t ellipsoid_fields[] = {
	CYAML_FIELD_SEQUENCE_FIXED("radii", NEEDED, struct raw_ellipsoid, radii, &float_entry, 3),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t mesh_fields[] = {
	CYAML_FIELD_STRING_PTR("file", NEEDED, struct raw_mesh, file, 1, 4096),
	CYAML_FIELD_FLOAT_PTR("scale", OPTIONAL, struct raw_mesh, scale),
	CYAML_FIELD_BOOL_PTR("belt", OPTIONAL, struct raw_mesh, belt),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t shape_fields[] = {
	CYAML_FIELD_MAPPING_PTR("wheel", OPTIONAL, struct raw_shape, wheel, wheel_fields),
	CYAML_FIELD_MAPPING_PTR("sphere", OPTIONAL, struct raw_shape, sphere, sphere_fields),
	CYAML_FIELD_MAPPING_PTR("box", OPTIONAL, struct raw_shape, box, box_fields),
	CYAML_FIELD_MAPPING_PTR("mesh", OPTIONAL, struct raw_shape, mesh, mesh_fields),
	CYAML_FIELD_MAPPING_PTR("cylinder", OPTIONAL, struct raw_shape, cylinder, rod_fields),
	CYAML_FIELD_MAPPING_PTR("capsule", OPTIONAL, struct raw_shape, capsule, rod_fields),
	CYAML_FIELD_MAPPING_PTR("ellipsoid", OPTIONAL, struct raw_shape, ellipsoid, ellipsoid_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t path_fields[] = {
	CYAML_FIELD_SEQUENCE("points", OPTIONAL_POINTER, struct raw_path, points, &point_entry, 1,
			     CYAML_UNLIMITED),
	CYAML_FIELD_FLOAT_PTR("speed", OPTIONAL, struct raw_path, speed),
	CYAML_FIELD_BOOL_PTR("loop", OPTIONAL, struct raw_path, loop),
	CYAML_FIELD_STRING_PTR("file", OPTIONAL, struct raw_path, file, 1, 4096),
	CYAML_FIELD_INT_PTR("line", OPTIONAL, struct raw_path, line),
	CYAML_FIELD_BOOL_PTR("smooth", OPTIONAL, struct raw_path, smooth),
	CYAML_FIELD_FLOAT_PTR("rotate", OPTIONAL, struct raw_path, rotate),
	CYAML_FIELD_SEQUENCE("offset", OPTIONAL_POINTER, struct raw_path, offset, &float_entry, 2, 2),
	CYAML_FIELD_STRING_PTR("relative_to", OPTIONAL, struct raw_path, relative_to, 1, 64),
	CYAML_FIELD_FLOAT_PTR("delay", OPTIONAL, struct raw_path, delay),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t interface_fields[] = {
	CYAML_FIELD_FLOAT_PTR("friction_angle", OPTIONAL, struct raw_interface, friction_angle),
	CYAML_FIELD_FLOAT_PTR("adhesion", OPTIONAL, struct raw_interface, adhesion),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t object_fields[] = {
	CYAML_FIELD_STRING_PTR("name", OPTIONAL, struct raw_object, name, 1, 64),
	CYAML_FIELD_MAPPING("shape", NEEDED, struct raw_object, shape, shape_fields),
	CYAML_FIELD_MAPPING_PTR("path", OPTIONAL, struct raw_object, path, path_fields),
	CYAML_FIELD_FLOAT_PTR("sink", OPTIONAL, struct raw_object, sink),
	CYAML_FIELD_FLOAT_PTR("load", OPTIONAL, struct raw_object, load),
	CYAML_FIELD_FLOAT_PTR("slip", OPTIONAL, struct raw_object, slip),
	CYAML_FIELD_BOOL_PTR("carry", OPTIONAL, struct raw_object, carry),
	CYAML_FIELD_SEQUENCE("attitude", OPTIONAL_POINTER, struct raw_object, attitude, &float_entry, 3, 3),
	CYAML_FIELD_MAPPING_PTR("interface", OPTIONAL, struct raw_object, interface, interface_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t object_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_object, object_fields)};

/* A soil's keys: of `type`, whose struct raw_class is at `own`, which ends in a point or is nothing. */
#define SOIL_FIELDS(type, own) \
	CYAML_FIELD_STRING_PTR("name", OPTIONAL, type, own name, 1, 64), \
	CYAML_FIELD_FLOAT_PTR("bekker_kc", OPTIONAL, type, own bekker_kc), \
	CYAML_FIELD_FLOAT_PTR("bekker_kphi", OPTIONAL, type, own bekker_kphi), \
	CYAML_FIELD_FLOAT_PTR("bekker_n", OPTIONAL, type, own bekker_n), \
	CYAML_FIELD_FLOAT_PTR("cohesion", OPTIONAL, type, own cohesion), \
	CYAML_FIELD_FLOAT_PTR("friction_angle", OPTIONAL, type, own friction_angle), \
	CYAML_FIELD_FLOAT_PTR("janosi_shear", OPTIONAL, type, own janosi_shear), \
	CYAML_FIELD_FLOAT_PTR("elastic_stiffness", OPTIONAL, type, own elastic_stiffness), \
	CYAML_FIELD_FLOAT_PTR("damping", OPTIONAL, type, own damping), \
	CYAML_FIELD_FLOAT_PTR("density", OPTIONAL, type, own density), \
	CYAML_FIELD_FLOAT_PTR("unit_weight", OPTIONAL, type, own unit_weight), \
	CYAML_FIELD_FLOAT_PTR("face_strength", OPTIONAL, type, own face_strength), \
	CYAML_FIELD_FLOAT_PTR("face_cohesion", OPTIONAL, type, own face_cohesion), \
	CYAML_FIELD_FLOAT_PTR("repose", OPTIONAL, type, own repose), \
	CYAML_FIELD_FLOAT_PTR("theta_in", OPTIONAL, type, own theta_in), \
	CYAML_FIELD_FLOAT_PTR("theta_out", OPTIONAL, type, own theta_out), \
	CYAML_FIELD_FLOAT_PTR("theta_stop", OPTIONAL, type, own theta_stop), \
	CYAML_FIELD_FLOAT_PTR("roughness", OPTIONAL, type, own roughness), \
	CYAML_FIELD_FLOAT_PTR("compression", OPTIONAL, type, own compression)

static const cyaml_schema_field_t over_fields[] = {
	SOIL_FIELDS(struct raw_class, ),
	CYAML_FIELD_END,
};
/* The same keys, and those of a layer. */
#define LAYER_FIELDS(type, own) \
	SOIL_FIELDS(type, own), \
	CYAML_FIELD_FLOAT_PTR("thickness", OPTIONAL, type, own thickness), \
	CYAML_FIELD_FLOAT_PTR("compaction", OPTIONAL, type, own compaction), \
	CYAML_FIELD_MAPPING_PTR("over", OPTIONAL, type, own over, over_fields)

static const cyaml_schema_field_t class_fields[] = {
	CYAML_FIELD_INT("value", NEEDED, struct raw_class, value),
	LAYER_FIELDS(struct raw_class, ),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t elsewhere_fields[] = {
	LAYER_FIELDS(struct raw_class, ),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t class_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_class, class_fields)};
static const cyaml_schema_field_t raster_fields[] = {
	CYAML_FIELD_STRING_PTR("bekker_kc", OPTIONAL, struct raw_rasters, bekker_kc, 1, 4096),
	CYAML_FIELD_STRING_PTR("bekker_kphi", OPTIONAL, struct raw_rasters, bekker_kphi, 1, 4096),
	CYAML_FIELD_STRING_PTR("bekker_n", OPTIONAL, struct raw_rasters, bekker_n, 1, 4096),
	CYAML_FIELD_STRING_PTR("cohesion", OPTIONAL, struct raw_rasters, cohesion, 1, 4096),
	CYAML_FIELD_STRING_PTR("friction_angle", OPTIONAL, struct raw_rasters, friction_angle, 1, 4096),
	CYAML_FIELD_STRING_PTR("janosi_shear", OPTIONAL, struct raw_rasters, janosi_shear, 1, 4096),
	CYAML_FIELD_STRING_PTR("elastic_stiffness", OPTIONAL, struct raw_rasters, elastic_stiffness, 1, 4096),
	CYAML_FIELD_STRING_PTR("thickness", OPTIONAL, struct raw_rasters, thickness, 1, 4096),
	CYAML_FIELD_STRING_PTR("compaction", OPTIONAL, struct raw_rasters, compaction, 1, 4096),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t soil_fields[] = {
	LAYER_FIELDS(struct raw_soil, all.),
	CYAML_FIELD_STRING_PTR("map", OPTIONAL, struct raw_soil, map, 1, 4096),
	CYAML_FIELD_SEQUENCE("classes", OPTIONAL_POINTER, struct raw_soil, classes, &class_entry, 1,
			     SOIL_CLASSES - 1),
	CYAML_FIELD_MAPPING_PTR("default", OPTIONAL, struct raw_soil, elsewhere, elsewhere_fields),
	CYAML_FIELD_MAPPING_PTR("rasters", OPTIONAL, struct raw_soil, rasters, raster_fields),
	CYAML_FIELD_END,
};

static const cyaml_schema_field_t road_fields[] = {
	CYAML_FIELD_STRING_PTR("lines", OPTIONAL, struct raw_road, lines, 1, 4096),
	CYAML_FIELD_SEQUENCE("points", OPTIONAL_POINTER, struct raw_road, points, &point_entry, 2, CYAML_UNLIMITED),
	CYAML_FIELD_BOOL_PTR("smooth", OPTIONAL, struct raw_road, smooth),
	CYAML_FIELD_FLOAT("width", NEEDED, struct raw_road, width),
	CYAML_FIELD_MAPPING("soil", NEEDED, struct raw_road, soil, elsewhere_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t road_entry = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_road, road_fields)};
static const cyaml_schema_field_t rocks_fields[] = {
	CYAML_FIELD_FLOAT("cover", NEEDED, struct raw_rocks, cover),
	CYAML_FIELD_FLOAT_PTR("k", OPTIONAL, struct raw_rocks, k),
	CYAML_FIELD_FLOAT("largest", NEEDED, struct raw_rocks, largest),
	CYAML_FIELD_FLOAT_PTR("smallest", OPTIONAL, struct raw_rocks, smallest),
	CYAML_FIELD_INT_PTR("seed", OPTIONAL, struct raw_rocks, seed),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t ground_fields[] = {
	CYAML_FIELD_SEQUENCE("roads", OPTIONAL_POINTER, struct raw_ground, roads, &road_entry, 1, SOIL_CLASSES - 1),
	CYAML_FIELD_MAPPING_PTR("rocks", OPTIONAL, struct raw_ground, rocks, rocks_fields),
	CYAML_FIELD_END,
};

static const cyaml_schema_field_t relief_class_fields[] = {
	CYAML_FIELD_INT("value", NEEDED, struct raw_relief_class, value),
	CYAML_FIELD_FLOAT("roughness", NEEDED, struct raw_relief_class, roughness),
	CYAML_FIELD_FLOAT_PTR("wavelength", OPTIONAL, struct raw_relief_class, wavelength),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t relief_class_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_relief_class, relief_class_fields)};
static const cyaml_schema_field_t relief_fields[] = {
	CYAML_FIELD_FLOAT("roughness", NEEDED, struct raw_relief, roughness),
	CYAML_FIELD_FLOAT("wavelength", NEEDED, struct raw_relief, wavelength),
	CYAML_FIELD_INT_PTR("seed", OPTIONAL, struct raw_relief, seed),
	CYAML_FIELD_SEQUENCE("classes", OPTIONAL_POINTER, struct raw_relief, classes, &relief_class_entry, 1, RELIEF_CLASSES - 1),
	CYAML_FIELD_END,
};

#define MODEL_WORD(number, word) {#word, number},
static const cyaml_strval_t model_words[] = {DEFORM_MODELS_EACH(MODEL_WORD)};
static const cyaml_strval_t undisturbed_words[] = {{"stable", SCENE_STABLE}, {"slides", SCENE_SLIDES}};
static const cyaml_strval_t faces_words[] = {{"on", SCENE_FACES_ON}, {"off", SCENE_FACES_OFF}};
static const cyaml_strval_t thrown_words[] = {{"off", SCENE_THROWN_OFF}, {"on", SCENE_THROWN_ON}};
static const cyaml_strval_t normals_words[] = {{"body", SCENE_BODY}, {"ground", SCENE_GROUND}};
static const cyaml_strval_t regions_words[] = {{"window", SCENE_WINDOWS}, {"fixed", SCENE_FIXED_REGIONS}};
static const cyaml_strval_t body_words[] = {{"earth", SCENE_EARTH}, {"mars", SCENE_MARS}, {"moon", SCENE_MOON}};
static const cyaml_strval_t camera_words[] = {{"mounted", SCENE_MOUNTED}, {"fixed", SCENE_FIXED}, {"chase", SCENE_CHASE},
					      {"overhead", SCENE_OVERHEAD}, {"poses", SCENE_BY_POSES}};
static const cyaml_strval_t exposure_words[] = {{"fixed", SCENE_EXPOSURE_FIXED}, {"sun", SCENE_EXPOSURE_SUN}};
static const cyaml_strval_t compute_words[] = {{"gpu", SCENE_GPU}, {"cpu", SCENE_CPU}};
static const cyaml_strval_t outside_words[] = {{"stop", SCENE_STOP}, {"skip", SCENE_SKIP}};

static const cyaml_schema_field_t redistribute_fields[] = {
	CYAML_FIELD_ENUM("model", NEEDED, struct raw_redistribute, model, model_words,
			 DEFORM_MODELS),
	CYAML_FIELD_INT_PTR("radius", OPTIONAL, struct raw_redistribute, radius),
	CYAML_FIELD_INT_PTR("repetitions", OPTIONAL, struct raw_redistribute, repetitions),
	CYAML_FIELD_INT_PTR("iterations", OPTIONAL, struct raw_redistribute, iterations),
	CYAML_FIELD_FLOAT_PTR("interval", OPTIONAL, struct raw_redistribute, interval),
	CYAML_FIELD_FLOAT_PTR("depth", OPTIONAL, struct raw_redistribute, depth),
	CYAML_FIELD_FLOAT_PTR("tolerance", OPTIONAL, struct raw_redistribute, tolerance),
	CYAML_FIELD_FLOAT_PTR("bulldozing", OPTIONAL, struct raw_redistribute, bulldozing),
	CYAML_FIELD_FLOAT_PTR("slip_sinkage", OPTIONAL, struct raw_redistribute, slip_sinkage),
	CYAML_FIELD_FLOAT_PTR("loosening", OPTIONAL, struct raw_redistribute, loosening),
	CYAML_FIELD_FLOAT_PTR("hardening", OPTIONAL, struct raw_redistribute, hardening),
	CYAML_FIELD_ENUM_PTR("undisturbed", OPTIONAL, struct raw_redistribute, undisturbed,
			     undisturbed_words, 2),
	CYAML_FIELD_ENUM_PTR("normals", OPTIONAL, struct raw_redistribute, normals, normals_words, 2),
	CYAML_FIELD_ENUM_PTR("faces", OPTIONAL, struct raw_redistribute, faces, faces_words, 2),
	CYAML_FIELD_FLOAT_PTR("inertia", OPTIONAL, struct raw_redistribute, inertia),
	CYAML_FIELD_FLOAT_PTR("tension", OPTIONAL, struct raw_redistribute, tension),
	CYAML_FIELD_FLOAT_PTR("stiffness", OPTIONAL, struct raw_redistribute, stiffness),
	CYAML_FIELD_FLOAT_PTR("yield", OPTIONAL, struct raw_redistribute, yield),
	CYAML_FIELD_FLOAT_PTR("rut", OPTIONAL, struct raw_redistribute, rut),
	CYAML_FIELD_ENUM_PTR("regions", OPTIONAL, struct raw_redistribute, regions, regions_words, 2),
	CYAML_FIELD_ENUM_PTR("thrown", OPTIONAL, struct raw_redistribute, thrown, thrown_words, 2),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t output_fields[] = {
	CYAML_FIELD_FLOAT_PTR("forces", OPTIONAL, struct raw_output, forces),
	CYAML_FIELD_INT_PTR("delay", OPTIONAL, struct raw_output, delay),
	CYAML_FIELD_FLOAT_PTR("vehicles", OPTIONAL, struct raw_output, vehicles),
	CYAML_FIELD_FLOAT_PTR("sensors", OPTIONAL, struct raw_output, sensors),
	CYAML_FIELD_INT_PTR("noise_seed", OPTIONAL, struct raw_output, noise_seed),
	CYAML_FIELD_BOOL_PTR("map", OPTIONAL, struct raw_output, map),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t overhead_fields[] = {
	CYAML_FIELD_STRING_PTR("over", NEEDED, struct raw_overhead, over, 1, 64),
	CYAML_FIELD_FLOAT("height", NEEDED, struct raw_overhead, height),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t fixed_fields[] = {
	CYAML_FIELD_SEQUENCE_FIXED("eye", NEEDED, struct raw_fixed, eye, &float_entry, 3),
	CYAML_FIELD_SEQUENCE_FIXED("target", NEEDED, struct raw_fixed, target, &float_entry, 3),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t camera_fields[] = {
	CYAML_FIELD_STRING_PTR("chase", OPTIONAL, struct raw_camera, chase, 1, 64),
	CYAML_FIELD_FLOAT_PTR("back", OPTIONAL, struct raw_camera, back),
	CYAML_FIELD_FLOAT_PTR("up", OPTIONAL, struct raw_camera, up),
	CYAML_FIELD_MAPPING_PTR("overhead", OPTIONAL, struct raw_camera, overhead, overhead_fields),
	CYAML_FIELD_MAPPING_PTR("fixed", OPTIONAL, struct raw_camera, fixed, fixed_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t sun_fields[] = {
	CYAML_FIELD_FLOAT_PTR("azimuth", OPTIONAL, struct raw_sun, azimuth),
	CYAML_FIELD_FLOAT_PTR("height", OPTIONAL, struct raw_sun, height),
	CYAML_FIELD_STRING_PTR("time", OPTIONAL, struct raw_sun, time, 1, 64),
	CYAML_FIELD_SEQUENCE("at", OPTIONAL_POINTER, struct raw_sun, at, &float_entry, 2, 2),
	CYAML_FIELD_SEQUENCE("colour", OPTIONAL_POINTER, struct raw_sun, colour, &float_entry, 3, 3),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t view_fields[] = {
	CYAML_FIELD_SEQUENCE("size", OPTIONAL_POINTER, struct raw_view, size, &int_entry, 2, 2),
	CYAML_FIELD_MAPPING_PTR("camera", OPTIONAL, struct raw_view, camera, camera_fields),
	CYAML_FIELD_SEQUENCE("effects", OPTIONAL_POINTER, struct raw_view, effects, &word_entry, 0,
			     CYAML_UNLIMITED),
	CYAML_FIELD_INT_PTR("images", OPTIONAL, struct raw_view, images),
	CYAML_FIELD_INT_PTR("samples", OPTIONAL, struct raw_view, samples),
	CYAML_FIELD_FLOAT_PTR("pixel_error", OPTIONAL, struct raw_view, pixel_error),
	CYAML_FIELD_FLOAT_PTR("imagery_budget", OPTIONAL, struct raw_view, imagery_budget),
	CYAML_FIELD_ENUM_PTR("exposure", OPTIONAL, struct raw_view, exposure, exposure_words, 2),
	CYAML_FIELD_ENUM_PTR("body", OPTIONAL, struct raw_view, body, body_words, 3),
	CYAML_FIELD_MAPPING_PTR("sun", OPTIONAL, struct raw_view, sun, sun_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t camera_pose_fields[] = {
	CYAML_FIELD_SEQUENCE_FIXED("at", NEEDED, struct raw_camera_pose, at, &float_entry, 3),
	CYAML_FIELD_SEQUENCE("target", OPTIONAL_POINTER, struct raw_camera_pose, target, &float_entry, 3, 3),
	CYAML_FIELD_FLOAT_PTR("yaw", OPTIONAL, struct raw_camera_pose, yaw),
	CYAML_FIELD_FLOAT_PTR("pitch", OPTIONAL, struct raw_camera_pose, pitch),
	CYAML_FIELD_FLOAT_PTR("roll", OPTIONAL, struct raw_camera_pose, roll),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t listed_camera_fields[] = {
	CYAML_FIELD_STRING_PTR("name", NEEDED, struct raw_listed_camera, name, 1, 48),
	CYAML_FIELD_ENUM("kind", NEEDED, struct raw_listed_camera, kind, camera_words, 5),
	CYAML_FIELD_STRING_PTR("on", OPTIONAL, struct raw_listed_camera, on, 1, 64),
	CYAML_FIELD_STRING_PTR("body", OPTIONAL, struct raw_listed_camera, body, 1, 64),
	CYAML_FIELD_MAPPING_PTR("pose", OPTIONAL, struct raw_listed_camera, pose, camera_pose_fields),
	CYAML_FIELD_FLOAT_PTR("back", OPTIONAL, struct raw_listed_camera, back),
	CYAML_FIELD_FLOAT_PTR("up", OPTIONAL, struct raw_listed_camera, up),
	CYAML_FIELD_FLOAT_PTR("height", OPTIONAL, struct raw_listed_camera, height),
	CYAML_FIELD_STRING_PTR("file", OPTIONAL, struct raw_listed_camera, file, 1, 4096),
	CYAML_FIELD_FLOAT_PTR("fov", OPTIONAL, struct raw_listed_camera, fov),
	CYAML_FIELD_SEQUENCE("size", OPTIONAL_POINTER, struct raw_listed_camera, size, &int_entry, 2, 2),
	CYAML_FIELD_FLOAT("rate", NEEDED, struct raw_listed_camera, rate),
	CYAML_FIELD_SEQUENCE("images", OPTIONAL_POINTER, struct raw_listed_camera, images, &word_entry, 1, CYAML_UNLIMITED),
	CYAML_FIELD_FLOAT_PTR("depth_unit", OPTIONAL, struct raw_listed_camera, depth_unit),
	CYAML_FIELD_FLOAT_PTR("stereo", OPTIONAL, struct raw_listed_camera, stereo),
	CYAML_FIELD_BOOL_PTR("video", OPTIONAL, struct raw_listed_camera, video),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t listed_camera_entry = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_listed_camera, listed_camera_fields)};
static const cyaml_schema_field_t lidar_fields[] = {
	CYAML_FIELD_STRING_PTR("name", NEEDED, struct raw_lidar, name, 1, 48),
	CYAML_FIELD_STRING_PTR("on", OPTIONAL, struct raw_lidar, on, 1, 64),
	CYAML_FIELD_STRING_PTR("body", OPTIONAL, struct raw_lidar, body, 1, 64),
	CYAML_FIELD_MAPPING_PTR("pose", OPTIONAL, struct raw_lidar, pose, camera_pose_fields),
	CYAML_FIELD_SEQUENCE("rays", OPTIONAL_POINTER, struct raw_lidar, rays, &int_entry, 2, 2),
	CYAML_FIELD_SEQUENCE("fov", OPTIONAL_POINTER, struct raw_lidar, fov, &float_entry, 2, 2),
	CYAML_FIELD_SEQUENCE("range", OPTIONAL_POINTER, struct raw_lidar, range, &float_entry, 2, 2),
	CYAML_FIELD_FLOAT("rate", NEEDED, struct raw_lidar, rate),
	CYAML_FIELD_FLOAT_PTR("noise", OPTIONAL, struct raw_lidar, noise),
	CYAML_FIELD_FLOAT_PTR("dropout", OPTIONAL, struct raw_lidar, dropout),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t lidar_entry = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_lidar, lidar_fields)};
static const cyaml_schema_field_t cache_fields[] = {
	CYAML_FIELD_INT_PTR("slots", OPTIONAL, struct raw_cache, slots),
	CYAML_FIELD_STRING_PTR("memory", OPTIONAL, struct raw_cache, memory, 1, 64),
	CYAML_FIELD_INT_PTR("loaders", OPTIONAL, struct raw_cache, loaders),
	CYAML_FIELD_FLOAT_PTR("prefetch", OPTIONAL, struct raw_cache, prefetch),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t way_fields[] = {
	CYAML_FIELD_SEQUENCE("points", OPTIONAL_POINTER, struct raw_path, points, &point_entry, 1, CYAML_UNLIMITED),
	CYAML_FIELD_FLOAT_PTR("speed", OPTIONAL, struct raw_path, speed),
	CYAML_FIELD_SEQUENCE("speeds", OPTIONAL_POINTER, struct raw_path, speeds, &float_entry, 1, CYAML_UNLIMITED),
	CYAML_FIELD_SEQUENCE("stop", OPTIONAL_POINTER, struct raw_path, stop, &point_entry, 1, 1000),
	CYAML_FIELD_STRING_PTR("file", OPTIONAL, struct raw_path, file, 1, 4096),
	CYAML_FIELD_INT_PTR("line", OPTIONAL, struct raw_path, line),
	CYAML_FIELD_BOOL_PTR("smooth", OPTIONAL, struct raw_path, smooth),
	CYAML_FIELD_FLOAT_PTR("rotate", OPTIONAL, struct raw_path, rotate),
	CYAML_FIELD_SEQUENCE("offset", OPTIONAL_POINTER, struct raw_path, offset, &float_entry, 2, 2),
	CYAML_FIELD_END,
};
static const cyaml_strval_t follow_words[] = {{"axle", 0}, {"origin", 1}};
static const cyaml_strval_t forward_words[] = {{"+x", SCENE_PLUS_X}, {"-x", SCENE_MINUS_X}, {"+y", SCENE_PLUS_Y}, {"-y", SCENE_MINUS_Y}};
static const cyaml_strval_t up_words[] = {{"z", 0}, {"y", 1}};
static const cyaml_strval_t material_words[] = {{"rubber", SCENE_RUBBER}, {"steel", SCENE_STEEL}, {"concrete", SCENE_CONCRETE}};
static const cyaml_schema_field_t surface_fields[] = {
	CYAML_FIELD_STRING_PTR("geoms", NEEDED, struct raw_surface, geoms, 1, 256),
	CYAML_FIELD_ENUM_PTR("material", OPTIONAL, struct raw_surface, material, material_words, 3),
	CYAML_FIELD_FLOAT_PTR("friction_angle", OPTIONAL, struct raw_surface, friction_angle),
	CYAML_FIELD_FLOAT_PTR("adhesion", OPTIONAL, struct raw_surface, adhesion),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t surface_entry = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_surface, surface_fields)};
static const cyaml_schema_field_t control_fields[] = {
	CYAML_FIELD_STRING_PTR("actuator", NEEDED, struct raw_control, name, 1, 256),
	CYAML_FIELD_FLOAT("value", NEEDED, struct raw_control, value),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t control_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_control, control_fields)};
static const cyaml_schema_field_t joint_fields[] = {
	CYAML_FIELD_STRING_PTR("joint", NEEDED, struct raw_control, name, 1, 256),
	CYAML_FIELD_FLOAT("value", NEEDED, struct raw_control, value),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t joint_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_control, joint_fields)};
static const cyaml_schema_field_t start_fields[] = {
	CYAML_FIELD_SEQUENCE_FIXED("at", NEEDED, struct raw_start, at, &float_entry, 2),
	CYAML_FIELD_FLOAT_PTR("yaw", OPTIONAL, struct raw_start, yaw),
	CYAML_FIELD_FLOAT_PTR("pitch", OPTIONAL, struct raw_start, pitch),
	CYAML_FIELD_FLOAT_PTR("roll", OPTIONAL, struct raw_start, roll),
	CYAML_FIELD_FLOAT_PTR("height", OPTIONAL, struct raw_start, height),
	CYAML_FIELD_FLOAT_PTR("speed", OPTIONAL, struct raw_start, speed),
	CYAML_FIELD_SEQUENCE("joints", OPTIONAL_POINTER, struct raw_start, joints, &joint_entry, 1, 256),
	CYAML_FIELD_SEQUENCE("controls", OPTIONAL_POINTER, struct raw_start, controls, &control_entry, 1, 256),
	CYAML_FIELD_BOOL_PTR("settle", OPTIONAL, struct raw_start, settle),
	CYAML_FIELD_BOOL_PTR("fixed", OPTIONAL, struct raw_start, fixed),
	CYAML_FIELD_STRING_PTR("keyframe", OPTIONAL, struct raw_start, keyframe, 1, 256),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t pattern_entry = {CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char *, 1, 256)};
static const cyaml_schema_field_t driver_fields[] = {
	CYAML_FIELD_MAPPING_PTR("path", OPTIONAL, struct raw_driver, path, way_fields),
	CYAML_FIELD_SEQUENCE("steer", OPTIONAL_POINTER, struct raw_driver, steer, &pattern_entry, 0, 256),
	CYAML_FIELD_SEQUENCE("drive", OPTIONAL_POINTER, struct raw_driver, drive, &pattern_entry, 1, 256),
	CYAML_FIELD_STRING_PTR("controls", OPTIONAL, struct raw_driver, controls, 1, 4096),
	CYAML_FIELD_SEQUENCE("hold", OPTIONAL_POINTER, struct raw_driver, hold, &control_entry, 1, 256),
	CYAML_FIELD_ENUM_PTR("follow", OPTIONAL, struct raw_driver, follow, follow_words, 2),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t servo_fields[] = {
	CYAML_FIELD_FLOAT_PTR("kv", OPTIONAL, struct raw_servo, kv),
	CYAML_FIELD_FLOAT_PTR("torque", OPTIONAL, struct raw_servo, torque),
	CYAML_FIELD_SEQUENCE("free", OPTIONAL_POINTER, struct raw_servo, free, &pattern_entry, 1, 256),
	CYAML_FIELD_SEQUENCE("lock", OPTIONAL_POINTER, struct raw_servo, lock, &pattern_entry, 1, 256),
	CYAML_FIELD_END,
};
static const cyaml_strval_t differential_words[] = {{"open", SCENE_OPEN}, {"limited", SCENE_LIMITED}, {"locked", SCENE_LOCKED}};
static const cyaml_schema_field_t clutch_fields[] = {
	CYAML_FIELD_FLOAT_PTR("torque", OPTIONAL, struct raw_clutch, torque),
	CYAML_FIELD_FLOAT_PTR("engage", OPTIONAL, struct raw_clutch, engage),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t converter_fields[] = {
	CYAML_FIELD_FLOAT("capacity", NEEDED, struct raw_converter, capacity),
	CYAML_FIELD_FLOAT_PTR("ratio", OPTIONAL, struct raw_converter, ratio),
	CYAML_FIELD_FLOAT_PTR("coupling", OPTIONAL, struct raw_converter, coupling),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t differentials_fields[] = {
	CYAML_FIELD_ENUM_PTR("centre", OPTIONAL, struct raw_differentials, centre, differential_words, 3),
	CYAML_FIELD_ENUM_PTR("front", OPTIONAL, struct raw_differentials, front, differential_words, 3),
	CYAML_FIELD_ENUM_PTR("rear", OPTIONAL, struct raw_differentials, rear, differential_words, 3),
	CYAML_FIELD_FLOAT_PTR("bias", OPTIONAL, struct raw_differentials, bias),
	CYAML_FIELD_FLOAT_PTR("lock", OPTIONAL, struct raw_differentials, lock),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t powertrain_fields[] = {
	CYAML_FIELD_SEQUENCE("wheels", OPTIONAL_POINTER, struct raw_powertrain, wheels, &pattern_entry, 1, 256),
	CYAML_FIELD_STRING_PTR("engine", OPTIONAL, struct raw_powertrain, engine, 1, 4096),
	CYAML_FIELD_SEQUENCE("torque", OPTIONAL_POINTER, struct raw_powertrain, torque, &point_entry, 1, 1000),
	CYAML_FIELD_FLOAT_PTR("inertia", OPTIONAL, struct raw_powertrain, inertia),
	CYAML_FIELD_FLOAT_PTR("idle", OPTIONAL, struct raw_powertrain, idle),
	CYAML_FIELD_FLOAT_PTR("drag", OPTIONAL, struct raw_powertrain, drag),
	CYAML_FIELD_SEQUENCE("gears", OPTIONAL_POINTER, struct raw_powertrain, gears, &float_entry, 1, SCENE_GEARS_MOST),
	CYAML_FIELD_FLOAT_PTR("reverse", OPTIONAL, struct raw_powertrain, reverse),
	CYAML_FIELD_FLOAT_PTR("final", OPTIONAL, struct raw_powertrain, final),
	CYAML_FIELD_SEQUENCE("shift", OPTIONAL_POINTER, struct raw_powertrain, shift, &float_entry, 2, 2),
	CYAML_FIELD_FLOAT_PTR("shift_time", OPTIONAL, struct raw_powertrain, shift_time),
	CYAML_FIELD_MAPPING_PTR("clutch", OPTIONAL, struct raw_powertrain, clutch, clutch_fields),
	CYAML_FIELD_MAPPING_PTR("converter", OPTIONAL, struct raw_powertrain, converter, converter_fields),
	CYAML_FIELD_MAPPING_PTR("differentials", OPTIONAL, struct raw_powertrain, differentials, differentials_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t folder_entry = {CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char *, 1, 4096)};
static const cyaml_schema_field_t imu_fields[] = {
	CYAML_FIELD_STRING_PTR("body", OPTIONAL, struct raw_imu, body, 1, 256),
	CYAML_FIELD_SEQUENCE("at", OPTIONAL_POINTER, struct raw_imu, at, &float_entry, 3, 3),
	CYAML_FIELD_SEQUENCE("noise", OPTIONAL_POINTER, struct raw_imu, noise, &float_entry, 2, 2),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t vehicle_fields[] = {
	CYAML_FIELD_STRING_PTR("name", NEEDED, struct raw_vehicle, name, 1, 64),
	CYAML_FIELD_STRING_PTR("model", NEEDED, struct raw_vehicle, model, 1, 4096),
	CYAML_FIELD_MAPPING("start", NEEDED, struct raw_vehicle, start, start_fields),
	CYAML_FIELD_SEQUENCE("soil", OPTIONAL_POINTER, struct raw_vehicle, soil, &pattern_entry, 1, 256),
	CYAML_FIELD_SEQUENCE("no_soil", OPTIONAL_POINTER, struct raw_vehicle, no_soil, &pattern_entry, 1, 256),
	CYAML_FIELD_SEQUENCE("model_path", OPTIONAL_POINTER, struct raw_vehicle, model_path, &folder_entry, 1, 64),
	CYAML_FIELD_MAPPING_PTR("servo", OPTIONAL, struct raw_vehicle, servo, servo_fields),
	CYAML_FIELD_MAPPING_PTR("powertrain", OPTIONAL, struct raw_vehicle, powertrain, powertrain_fields),
	CYAML_FIELD_FLOAT_PTR("brakes", OPTIONAL, struct raw_vehicle, brakes),
	CYAML_FIELD_SEQUENCE("carry", OPTIONAL_POINTER, struct raw_vehicle, carry, &pattern_entry, 1, 256),
	CYAML_FIELD_SEQUENCE("tyres", OPTIONAL_POINTER, struct raw_vehicle, tyres, &geom_tyre_entry, 1, 64),
	CYAML_FIELD_MAPPING_PTR("driver", OPTIONAL, struct raw_vehicle, driver, driver_fields),
	CYAML_FIELD_ENUM_PTR("forward", OPTIONAL, struct raw_vehicle, forward, forward_words, 4),
	CYAML_FIELD_ENUM_PTR("up", OPTIONAL, struct raw_vehicle, up, up_words, 2),
	CYAML_FIELD_SEQUENCE("interface", OPTIONAL_POINTER, struct raw_vehicle, interface, &surface_entry, 1, 64),
	CYAML_FIELD_STRING_PTR("pushes", OPTIONAL, struct raw_vehicle, pushes, 1, 4096),
	CYAML_FIELD_MAPPING_PTR("imu", OPTIONAL, struct raw_vehicle, imu, imu_fields),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t vehicle_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_vehicle, vehicle_fields)};
static const cyaml_schema_field_t stuck_fields[] = {
	CYAML_FIELD_FLOAT("after", NEEDED, struct raw_stuck, after),
	CYAML_FIELD_FLOAT("below", NEEDED, struct raw_stuck, below),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t disturbance_fields[] = {
	CYAML_FIELD_FLOAT_PTR("heals", OPTIONAL, struct raw_disturbance, heals),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t cover_fields[] = {
	CYAML_FIELD_INT("value", NEEDED, struct raw_cover, value),
	CYAML_FIELD_FLOAT("cover", NEEDED, struct raw_cover, cover),
	CYAML_FIELD_END,
};
static const cyaml_schema_value_t cover_entry = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, struct raw_cover, cover_fields)};
static const cyaml_schema_field_t vegetation_fields[] = {
	CYAML_FIELD_FLOAT_PTR("cover", OPTIONAL, struct raw_vegetation, cover),
	CYAML_FIELD_FLOAT_PTR("height", OPTIONAL, struct raw_vegetation, height),
	CYAML_FIELD_FLOAT_PTR("tears", OPTIONAL, struct raw_vegetation, tears),
	CYAML_FIELD_FLOAT_PTR("rises", OPTIONAL, struct raw_vegetation, rises),
	CYAML_FIELD_FLOAT_PTR("grows", OPTIONAL, struct raw_vegetation, grows),
	CYAML_FIELD_SEQUENCE("classes", OPTIONAL_POINTER, struct raw_vegetation, classes, &cover_entry, 1, SOIL_CLASSES - 1),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t attributes_fields[] = {
	CYAML_FIELD_MAPPING_PTR("disturbance", OPTIONAL, struct raw_attributes, disturbance, disturbance_fields),
	CYAML_FIELD_MAPPING_PTR("vegetation", OPTIONAL, struct raw_attributes, vegetation, vegetation_fields),
	CYAML_FIELD_FLOAT_PTR("elapsed", OPTIONAL, struct raw_attributes, elapsed),
	CYAML_FIELD_END,
};
static const cyaml_schema_field_t scene_fields[] = {
	CYAML_FIELD_INT_PTR("scene", OPTIONAL, struct raw_scene, scene),
	CYAML_FIELD_STRING_PTR("store", OPTIONAL, struct raw_scene, store, 1, 4096),
	CYAML_FIELD_FLOAT_PTR("time_step", OPTIONAL, struct raw_scene, time_step),
	CYAML_FIELD_FLOAT_PTR("end_time", OPTIONAL, struct raw_scene, end_time),
	CYAML_FIELD_FLOAT_PTR("gravity", OPTIONAL, struct raw_scene, gravity),
	CYAML_FIELD_FLOAT_PTR("spacing", OPTIONAL, struct raw_scene, spacing),
	CYAML_FIELD_STRING_PTR("coordinates", OPTIONAL, struct raw_scene, coordinates, 1, 65536),
	CYAML_FIELD_MAPPING_PTR("soil", OPTIONAL, struct raw_scene, soil, soil_fields),
	CYAML_FIELD_MAPPING_PTR("ground", OPTIONAL, struct raw_scene, ground, ground_fields),
	CYAML_FIELD_MAPPING_PTR("relief", OPTIONAL, struct raw_scene, relief, relief_fields),
	CYAML_FIELD_MAPPING_PTR("redistribute", OPTIONAL, struct raw_scene, redistribute,
				redistribute_fields),
	CYAML_FIELD_ENUM_PTR("compute", OPTIONAL, struct raw_scene, compute, compute_words, 2),
	CYAML_FIELD_MAPPING_PTR("attributes", OPTIONAL, struct raw_scene, attributes, attributes_fields),
	CYAML_FIELD_ENUM_PTR("outside", OPTIONAL, struct raw_scene, outside, outside_words, 2),
	CYAML_FIELD_SEQUENCE("objects", OPTIONAL_POINTER, struct raw_scene, objects, &object_entry,
			     0, SCENE_OBJECTS),
	CYAML_FIELD_SEQUENCE("vehicles", OPTIONAL_POINTER, struct raw_scene, vehicles, &vehicle_entry, 0, 64),
	CYAML_FIELD_STRING_PTR("world", OPTIONAL, struct raw_scene, world, 1, 4096),
	CYAML_FIELD_MAPPING_PTR("stuck", OPTIONAL, struct raw_scene, stuck, stuck_fields),
	CYAML_FIELD_SEQUENCE("stop", OPTIONAL_POINTER, struct raw_scene, stop, &word_entry, 1, 3),
	CYAML_FIELD_MAPPING_PTR("output", OPTIONAL, struct raw_scene, output, output_fields),
	CYAML_FIELD_MAPPING_PTR("view", OPTIONAL, struct raw_scene, view, view_fields),
	CYAML_FIELD_SEQUENCE("cameras", OPTIONAL_POINTER, struct raw_scene, cameras, &listed_camera_entry, 0, 64),
	CYAML_FIELD_SEQUENCE("lidars", OPTIONAL_POINTER, struct raw_scene, lidars, &lidar_entry, 0, SCENE_LIDARS),
	CYAML_FIELD_MAPPING_PTR("cache", OPTIONAL, struct raw_scene, cache, cache_fields),
	CYAML_FIELD_END,
};
const cyaml_schema_value_t scene_schema = {
	CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, struct raw_scene, scene_fields)};

bool scene_needed_by_command(const char *where)
{
	static const char *const needed[] = {"scene", "end_time", "objects[].name", "objects[].path", "view.camera"};
	for (size_t i = 0; i < sizeof needed / sizeof needed[0]; i++)
		if (strcmp(needed[i], where) == 0)
			return true;
	return false;
}

static const struct scene_limit limits[] = {
	{"scene", 1, 1, false, "is no version of the format that is known", NULL, NAN, NULL},
	{"time_step", 1e-6, 3600, false, NULL, "s", 0.02, NULL},
	{"end_time", 0, 1e9, true, NULL, "s", NAN, NULL},
	{"gravity", 0, 1000, true, NULL, "m/s2", 9.81, NULL},
	{"spacing", 0, 1e6, true, NULL, "m", NAN, "the store's own"},
	{"soil.bekker_kc", -1e12, 1e12, false, NULL, "N/m^(n+1)", NAN, "the named soil's"},
	{"soil.bekker_kphi", 0, 1e12, false, NULL, "N/m^(n+2)", NAN, "the named soil's"},
	{"soil.bekker_n", 0, 3, true, NULL, NULL, NAN, "the named soil's"},
	{"soil.cohesion", 0, 1e9, false, NULL, "Pa", NAN, "the named soil's"},
	{"soil.friction_angle", 0, 89, false, NULL, "degrees", NAN, "the named soil's"},
	{"soil.janosi_shear", 0, 10, true, "is out of range, and the unit is m, not cm or mm", "m", NAN, "the named soil's"},
	{"soil.elastic_stiffness", 0, 1e12, true, NULL, "Pa/m", NAN, "the named soil's, or 4e7"},
	{"soil.damping", 0, 1e12, false, NULL, "Pa s/m", NAN, "the named soil's, or 30000"},
	{"soil.density", 0, 1e5, true, "is out of range, and the unit is kg/m3", "kg/m3", NAN, "unit_weight / gravity, or the named soil's"},
	{"soil.unit_weight", 0, 1e6, true, NULL, "N/m3", NAN, "density x gravity, or the named soil's"},
	{"soil.face_strength", 0, 1e12, true, NULL, "N/m3", NAN, "by unit_weight and friction_angle"},
	{"soil.face_cohesion", 0, 1e9, false, NULL, "Pa", NAN, "cohesion, of which sand has none"},
	{"soil.repose", 0, 89, true, NULL, "degrees", NAN, "the named soil's, or its friction_angle"},
	{"soil.theta_in", 0, 90, true, NULL, "degrees", NAN, "the named soil's"},
	{"soil.theta_out", 0, 90, true, NULL, "degrees", NAN, "the named soil's"},
	{"soil.theta_stop", 0, 90, true, NULL, "degrees", NAN, "the named soil's"},
	{"soil.roughness", 0, 0.2, true, "is out of the range in which slides come to rest", NULL, NAN, "the named soil's"},
	{"soil.compression", 0, 1, false, NULL, NULL, NAN, "the named soil's"},
	{"soil.thickness", 0, 1000, false, NULL, "m", NAN, "endless; needed with over"},
	{"soil.compaction", 0, 1, false, NULL, NULL, 0, NULL},
	{"soil.value", 0, 255, false, NULL, NULL, NAN, NULL},
	{"ground.roads[].points[][]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"ground.roads[].width", 0, 1000, true, NULL, "m", NAN, NULL},
	{"ground.rocks.cover", 0, 0.9, false, "is out of range, since cover is a share (0.05 for 5 %)", NULL, NAN, NULL},
	{"ground.rocks.k", 0, 1, true, NULL, NULL, NAN, "ground.rocks.cover"},
	{"ground.rocks.largest", 0, 20, true, NULL, "m", NAN, NULL},
	{"ground.rocks.smallest", 1e-3, 20, false, NULL, "m", NAN, "3 spacings"},
	{"ground.rocks.seed", 0, 4294967295, false, NULL, NULL, 0, NULL},
	{"relief.roughness", 0, 10, false, NULL, "m", NAN, NULL},
	{"relief.wavelength", 0, 1e6, true, NULL, "m", NAN, NULL},
	{"relief.seed", 0, 4294967295, false, NULL, NULL, 0, NULL},
	{"relief.classes[].value", 0, 255, false, NULL, NULL, NAN, NULL},
	{"relief.classes[].roughness", 0, 10, false, NULL, "m", NAN, NULL},
	{"relief.classes[].wavelength", 0, 1e6, true, NULL, "m", NAN, "relief.wavelength"},
	{"attributes.disturbance.heals", 64, 134217728, false, "is out of range, and the unit is s (86400 is a day)", "s", NAN, "never"},
	{"attributes.vegetation.cover", 0, 1, false, "is out of range, since cover is a share (0.8 for 80 %)", NULL, 1, NULL},
	{"attributes.vegetation.height", 0, 2, true, NULL, "m", 0.15, NULL},
	{"attributes.vegetation.tears", 0, 1, true, NULL, NULL, 0.5, NULL},
	{"attributes.vegetation.rises", 64, 134217728, false, "is out of range, and the unit is s (86400 is a day)", "s", 259200, NULL},
	{"attributes.vegetation.grows", 64, 134217728, false, "is out of range, and the unit is s (86400 is a day)", "s", 7776000, NULL},
	{"attributes.vegetation.classes[].value", 0, 255, false, NULL, NULL, NAN, NULL},
	{"attributes.vegetation.classes[].cover", 0, 1, false, NULL, NULL, NAN, NULL},
	{"attributes.elapsed", 0, 134217728, false, NULL, "s", 0, NULL},
	{"redistribute.radius", 1, 4, false, NULL, "posts", 1, NULL},
	{"redistribute.repetitions", 1, 8, false, NULL, NULL, 1, NULL},
	{"redistribute.iterations", 1, 8, false, NULL, NULL, 1, NULL},
	{"redistribute.interval", 0, 3600, true, NULL, "s", 0.05, NULL},
	{"redistribute.depth", 0, 1024, false, NULL, "m", NAN, "no bottom; 0 with scm"},
	{"redistribute.tolerance", 0, 1, false, NULL, "m", 0, NULL},
	{"redistribute.bulldozing", 0, 1, false, NULL, NULL, 0.5, NULL},
	{"redistribute.slip_sinkage", 0, 10, false, NULL, NULL, 1.35, NULL},
	{"redistribute.loosening", 0, 0.99, false, NULL, NULL, 0, NULL},
	{"redistribute.hardening", 0, 10, false, NULL, NULL, 0, NULL},
	{"redistribute.inertia", 0, 10, false, NULL, NULL, 1, NULL},
	{"redistribute.tension", 0, 1e9, true, NULL, "N/m", 2000, NULL},
	{"redistribute.stiffness", 0, 1e12, true, NULL, "Pa/m", 50000, NULL},
	{"redistribute.yield", 0, 8, false, NULL, "m", NAN, "it never yields"},
	{"redistribute.rut", 0, 1, false, NULL, NULL, 1, NULL},
	{"objects[].shape.wheel.radius", 0.001, 1000, false, "is out of range, and the unit is m, not mm", "m", NAN, NULL},
	{"objects[].shape.wheel.width", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.wheel.grousers", 0, 128, false, NULL, NULL, 0, NULL},
	{"objects[].shape.wheel.grouser_height", 0, 1000, true, NULL, "m", NAN, "0.05 of the radius"},
	{"objects[].shape.wheel.grouser_thickness", 0, 1000, true, NULL, "m", NAN, "0.1 of the radius"},
	{"objects[].shape.wheel.tyre.stiffness", 0, 1e12, true, NULL, "N/m", NAN, NULL},
	{"objects[].shape.wheel.tyre.load", 0, 1e12, true, NULL, "N", NAN, "the object's load"},
	{"objects[].shape.wheel.tyre.pressure", 0, 1e9, false, NULL, "Pa", NAN, "half of the mean on rigid ground"},
	{"objects[].shape.sphere.radius", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.box.size[]", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.cylinder.radius", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.cylinder.length", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.capsule.radius", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.capsule.length", 0, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.ellipsoid.radii[]", 0.001, 1000, false, NULL, "m", NAN, NULL},
	{"objects[].shape.mesh.scale", 0, 1000, true, NULL, NULL, 1, NULL},
	{"objects[].path.points[][]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"objects[].path.speed", 0, 10000, true, NULL, "m/s", NAN, NULL},
	{"objects[].path.line", 1, 1e6, false, NULL, NULL, NAN, "the only line"},
	{"objects[].path.rotate", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"objects[].path.offset[]", -1e9, 1e9, false, NULL, "m", NAN, "0, 0"},
	{"objects[].path.delay", 0, 1e9, false, NULL, "s", 0, NULL},
	{"objects[].sink", 0, 1000, false, NULL, "m", 0, NULL},
	{"objects[].load", 0, 1e9, true, NULL, "N", NAN, "none: sink"},
	{"objects[].slip", -1000, 0.99, false, "is out of range, since slip is a share (0.2 for 20 %)", NULL, 0, NULL},
	{"objects[].attitude[]", -360, 360, false, NULL, "degrees", NAN, "0, 0, 0"},
	{"objects[].interface.friction_angle", 0, 89, false, NULL, "degrees", NAN, "the soil's"},
	{"objects[].interface.adhesion", 0, 1e9, false, NULL, "Pa", NAN, "by the soil's cohesion"},
	{"output.forces", 0, 1e6, false, NULL, "1/s", 0, NULL},
	{"output.delay", 0, 64, false, NULL, "steps", NAN, "none"},
	{"output.vehicles", 0, 1e6, false, NULL, "1/s", 0, NULL},
	{"output.sensors", 0, 1e6, false, NULL, "1/s", 0, NULL},
	{"output.noise_seed", 0, 4294967295, false, NULL, NULL, NAN, "0, and none for sensors of a model"},
	{"vehicles[].start.at[]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"vehicles[].start.yaw", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"vehicles[].start.pitch", -360, 360, false, NULL, "degrees", 0, NULL},
	{"vehicles[].start.roll", -360, 360, false, NULL, "degrees", 0, NULL},
	{"vehicles[].start.height", 0, 10000, false, NULL, "m", 0, NULL},
	{"vehicles[].start.speed", -1000, 1000, false, NULL, "m/s", 0, NULL},
	{"vehicles[].start.joints[].value", -1e6, 1e6, false, NULL, "rad, m", NAN, NULL},
	{"vehicles[].start.controls[].value", -1e12, 1e12, false, NULL, NULL, NAN, NULL},
	{"vehicles[].servo.kv", 0, 1e12, true, NULL, "N m s", NAN, "torque / 0.1 rad/s"},
	{"vehicles[].servo.torque", 0, 1e12, true, NULL, "N m", NAN, "the joint's limit, or by the weight"},
	{"vehicles[].powertrain.torque[][]", 0, 1e6, false, NULL, "rpm, N m", NAN, NULL},
	{"vehicles[].powertrain.inertia", 0, 1e6, true, NULL, "kg m2", 0.2, NULL},
	{"vehicles[].powertrain.idle", 0, 1e6, true, NULL, "rpm", NAN, "the first speed of the engine"},
	{"vehicles[].powertrain.drag", 0, 1e6, false, NULL, "N m", 0, NULL},
	{"vehicles[].powertrain.gears[]", 0, 1e4, true, NULL, NULL, NAN, "one gear of 1"},
	{"vehicles[].powertrain.reverse", 0, 1e4, true, NULL, NULL, NAN, "the first gear's"},
	{"vehicles[].powertrain.final", 0, 1e4, true, NULL, NULL, 1, NULL},
	{"vehicles[].powertrain.shift[]", 0, 1e6, true, NULL, "rpm", NAN, "it does not shift itself"},
	{"vehicles[].powertrain.shift_time", 0, 10, false, NULL, "s", 0.3, NULL},
	{"vehicles[].powertrain.clutch.torque", 0, 1e6, true, NULL, "N m", NAN, "1.5 of the engine's most"},
	{"vehicles[].powertrain.clutch.engage", 0, 1e6, true, NULL, "rpm", NAN, "1.5 idle"},
	{"vehicles[].powertrain.converter.capacity", 0, 1e3, true, NULL, "N m s2", NAN, NULL},
	{"vehicles[].powertrain.converter.ratio", 1, 10, false, NULL, NULL, 2, NULL},
	{"vehicles[].powertrain.converter.coupling", 0.1, 0.99, false, NULL, NULL, 0.85, NULL},
	{"vehicles[].powertrain.differentials.bias", 1, 100, false, NULL, NULL, 2, NULL},
	{"vehicles[].powertrain.differentials.lock", 0, 1e7, false, NULL, "N m", 0, NULL},
	{"vehicles[].imu.at[]", -1000, 1000, false, NULL, "m", NAN, "0, 0, 0"},
	{"vehicles[].imu.noise[]", 0, 1000, false, NULL, "m/s2, rad/s", NAN, "0, 0"},
	{"vehicles[].brakes", 0, 1e7, true, NULL, "N m", NAN, "none"},
	{"vehicles[].tyres[].stiffness", 0, 1e12, true, NULL, "N/m", NAN, NULL},
	{"vehicles[].tyres[].width", 0.001, 1000, false, NULL, "m", NAN, "the geom's"},
	{"vehicles[].tyres[].load", 0, 1e12, true, NULL, "N", NAN, "the wheel's share of the weight"},
	{"vehicles[].tyres[].pressure", 0, 1e9, false, NULL, "Pa", NAN, "half of the mean on rigid ground"},
	{"vehicles[].tyres[].damping", 0, 1e12, false, NULL, "N s/m", NAN, "a twentieth of what is critical"},
	{"vehicles[].driver.path.points[][]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"vehicles[].driver.path.speed", -1000, 1000, false, NULL, "m/s", NAN, "needed, or speeds"},
	{"vehicles[].driver.path.speeds[]", -1000, 1000, false, NULL, "m/s", NAN, "speed"},
	{"vehicles[].driver.path.stop[][]", 0, 1e12, false, NULL, "s", NAN, "none"},
	{"vehicles[].interface[].friction_angle", 0, 89, false, NULL, "degrees", NAN, "the soil's"},
	{"vehicles[].interface[].adhesion", 0, 1e9, false, NULL, "Pa", NAN, "by the soil's cohesion"},
	{"vehicles[].driver.path.line", 1, 1e6, false, NULL, NULL, NAN, "the only line"},
	{"vehicles[].driver.path.rotate", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"vehicles[].driver.path.offset[]", -1e9, 1e9, false, NULL, "m", NAN, "0, 0"},
	{"vehicles[].driver.hold[].value", -1e12, 1e12, false, NULL, NULL, NAN, NULL},
	{"stuck.after", 0, 1e9, true, NULL, "s", NAN, NULL},
	{"stuck.below", 0, 1000, true, NULL, "m/s", NAN, NULL},
	{"view.size[]", 1, 8192, false, NULL, "pixels", NAN, "1280, 720"},
	{"view.camera.back", 0, 1e6, false, NULL, "m", 12, NULL},
	{"view.camera.up", 0, 1e6, false, NULL, "m", 5, NULL},
	{"view.camera.overhead.height", 0, 1e6, true, NULL, "m", NAN, NULL},
	{"view.camera.fixed.eye[]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"view.camera.fixed.target[]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"view.images", 0, 1e9, false, NULL, "steps", 0, NULL},
	{"view.samples", 1, 8, false, NULL, NULL, 1, NULL},
	{"view.pixel_error", 0, 64, true, NULL, "pixels", NAN, "by distance alone"},
	{"view.imagery_budget", 0, 65536, true, NULL, "MB", 128, NULL},
	{"view.sun.azimuth", 0, 360, false, NULL, "degrees", 135, NULL},
	{"view.sun.height", 0, 90, false, NULL, "degrees", 35, NULL},
	{"view.sun.at[]", -360, 360, false, NULL, "degrees", NAN, "the middle of the store's terrain"},
	{"view.sun.colour[]", 0, 10, false, NULL, NULL, NAN, "the body's sun at its height"},
	{"cameras[].pose.at[]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"cameras[].pose.target[]", -1e9, 1e9, false, NULL, "m", NAN, "yaw, pitch and roll"},
	{"cameras[].pose.yaw", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"cameras[].pose.pitch", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"cameras[].pose.roll", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"cameras[].back", 0, 1e6, false, NULL, "m", 12, NULL},
	{"cameras[].up", 0, 1e6, false, NULL, "m", 5, NULL},
	{"cameras[].height", 0, 1e6, true, NULL, "m", NAN, "needed with overhead"},
	{"cameras[].fov", 1, 170, false, NULL, "degrees", 60, NULL},
	{"cameras[].size[]", 1, 8192, false, NULL, "pixels", NAN, "640, 480"},
	{"cameras[].rate", 0, 1e6, true, NULL, "1/s", NAN, NULL},
	{"cameras[].stereo", 0, 1000, true, NULL, "m", NAN, "none"},
	{"cameras[].depth_unit", 1e-6, 1000, false, NULL, "m", 0.001, NULL},
	{"lidars[].pose.at[]", -1e9, 1e9, false, NULL, "m", NAN, NULL},
	{"lidars[].pose.target[]", -1e9, 1e9, false, NULL, "m", NAN, "yaw, pitch and roll"},
	{"lidars[].pose.yaw", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"lidars[].pose.pitch", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"lidars[].pose.roll", -36000, 36000, false, NULL, "degrees", 0, NULL},
	{"lidars[].rays[]", 1, 4096, false, NULL, NULL, NAN, "360, 16"},
	{"lidars[].fov[]", 0, 360, false, NULL, "degrees", NAN, "360, 30"},
	{"lidars[].range[]", 0, 1e5, false, NULL, "m", NAN, "0, 100"},
	{"lidars[].rate", 0, 1e6, true, NULL, "1/s", NAN, NULL},
	{"lidars[].noise", 0, 100, false, NULL, "m", 0, NULL},
	{"lidars[].dropout", 0, 1, false, NULL, NULL, 0, NULL},
	{"cache.slots", 4, 65536, false, NULL, NULL, 256, NULL},
	{"cache.loaders", 0, 16, false, NULL, NULL, 2, NULL},
	{"cache.prefetch", 0, 3600, false, NULL, "s", 1.5, NULL},
};

const struct scene_limit *scene_limit_of(const char *where)
{
	static const char *const soils[] = {"soil.default.over.", "soil.classes[].over.", "soil.over.", "soil.default.", "soil.classes[].",
					     "ground.roads[].soil.over.", "ground.roads[].soil."};
	char place[160];
	for (size_t i = 0; i < sizeof soils / sizeof soils[0]; i++)
		if (strncmp(where, soils[i], strlen(soils[i])) == 0) {
			snprintf(place, sizeof place, "soil.%s", where + strlen(soils[i]));
			where = place;
			break;
		}
	for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++)
		if (strcmp(limits[i].where, where) == 0)
			return &limits[i];
	return NULL;
}

double scene_absent(const char *where)
{
	const struct scene_limit *limit = scene_limit_of(where);
	assert(limit != NULL && !isnan(limit->absent));
	return limit->absent;
}
