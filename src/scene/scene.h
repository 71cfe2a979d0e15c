/*
 * scene: a YAML file to a checked scene, and the one table that describes every effect.
 *
 * A scene is untrusted input: unknown keys, wrong types and out-of-range values are STATUS_INPUT
 * with "FILE:LINE: KEY: WHY; what is allowed". All values are SI; angles in radians once checked.
 * A struct scene is immutable after scene_load and owned by the caller.
 */
#ifndef FURROW_SCENE_H
#define FURROW_SCENE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "deform/deform.h"

enum scene_coordinates { SCENE_LOCAL, SCENE_STORE, SCENE_SRS };
enum scene_outside { SCENE_STOP, SCENE_SKIP };
enum scene_undisturbed { SCENE_STANDS, SCENE_SLIDES };
enum scene_body { SCENE_EARTH, SCENE_MARS, SCENE_MOON };
enum scene_camera_kind { SCENE_CHASE, SCENE_OVERHEAD, SCENE_FIXED };

/* Every effect a scene can call for, in the order of src/scene/effects.c's table. */
enum scene_effect {
	EFFECT_DISPLACE,
	EFFECT_BOX,
	EFFECT_SUMNER,
	EFFECT_SLIPPAGE,
	EFFECT_SCM,
	EFFECT_SPREAD,
	EFFECT_SHED,
	EFFECT_SLIDE,
	EFFECT_SOIL_MAP,
	EFFECT_MESH,
	EFFECT_LUGS,
	EFFECT_LOAD,
	EFFECT_FORCES,
	EFFECT_DIRT,
	EFFECT_SUBDIVIDE,
	EFFECT_PYRAMID,
	EFFECT_PICTURE,
	EFFECT_NORMALS,
	EFFECT_PIXEL_ERROR,
	EFFECT_TEXTURE,
	EFFECT_DETAIL,
	EFFECT_FOG,
	EFFECT_SKY,
	EFFECT_GEOMORPH,
	EFFECT_SKIRTS,
	EFFECT_SPLAT,
	EFFECT_ANTIALIAS,
	EFFECT_IMAGES,
	EFFECT_LOADERS,
	EFFECT_PREFETCH,
	EFFECT_OBJECTS,
	EFFECT_SHADOW,
	EFFECT_COUNT
};
#define EFFECT_BIT(effect) ((uint64_t)1 << (effect)) /* in a set of effects */

struct scene_effect_row {
	const char *name;    /* as the scene writes it, where it does */
	const char *key;     /* the scene's key that calls for it: "redistribute.model" */
	const char *define;  /* of the shader variant, "" if it has its own program */
	const char *const *shaders; /* files, NULL-terminated; the define is in the first */
	const char *reads, *writes; /* planes, or what else a person calls it */
	int stencil;         /* posts read around a post it writes, at most */
	const char *const *parameters; /* keys of the scene, NULL-terminated, as scene_parameter takes them */
	const char *limits;  /* in words, with numbers */
	const char *what;    /* one line for a person */
};
const struct scene_effect_row *scene_effect_row(enum scene_effect effect);
bool scene_effect_named(const char *name, enum scene_effect *effect);

/* The present name of a key, a word or a layer that had another: "disturbance" of "dirt". Other names are what they are.
 * Effects and planes keep their names in code and in files. */
const char *scene_name_now(const char *name);

/* What the scene may say at a key: of a list's entries "objects[].sink", of a soil "soil.cohesion". */
struct scene_parameter {
	const char *kind;      /* "number", "whole number", "word", "switch", "text", "list" or "mapping" */
	const char *unit;      /* NULL: none */
	double low, high;      /* of a number; NaN both: any finite one */
	bool above;            /* low itself is out of range */
	double absent;         /* of a number: where the scene does not say; NaN: as `otherwise` says, or, NULL, */
	const char *otherwise; /* that it must be given where what holds it is */
	char words[96];        /* of a word: "stands, slides" */
};
bool scene_parameter(const char *key, struct scene_parameter *parameter); /* false: the scene has no such key */

/* A pose in time. A path of points has no t, z or attitude: they follow from speed and ground. */
struct scene_waypoint {
	double t, x, y, z, yaw, pitch, roll; /* s, coordinates' unit, m, rad */
};

struct scene_path {
	struct scene_waypoint *points;
	size_t count; /* 0: the host moves the object */
	double speed; /* m/s; points only */
	bool loop;
	bool timed;            /* from a poses file: t is given */
	bool has_z, has_attitude;
};

struct scene_object {
	char *name;
	struct deform_shape shape;
	struct scene_path path;
	struct deform_mesh *mesh; /* owned: what shape.mesh is, or NULL */
	double sink; /* metres below the base at the path point; 0 with a load */
	double load; /* N that the soil carries instead, model scm; 0: none */
	double slip; /* of a wheel, model scm: 1 - way / (radius x angle turned), or less than 0 as it is dragged */
};

/* What pictures are lit by. */
struct scene_light {
	enum scene_body body;
	double azimuth, height; /* of the sun: rad clockwise from north, rad above the horizon */
	bool coloured;          /* false: the sun's colour is as it is there, at that height */
	double colour[3];       /* linear */
};
#define SCENE_SUN_AZIMUTH (135 * M_PI / 180)
#define SCENE_SUN_HEIGHT (35 * M_PI / 180)
struct scene_light scene_light_default(void); /* of a view that says nothing */

struct scene_view {
	bool present;
	bool left_out;         /* by scene_unwatched */
	int width, height;
	enum scene_camera_kind camera;
	int target_object;     /* chase, overhead: index of the object */
	double back, up;       /* chase, metres */
	double over_height;    /* overhead, metres */
	double eye[3], target[3]; /* fixed: local metres */
	uint64_t effects;      /* EFFECT_BIT of each */
	int64_t images;        /* a PNG every so many steps; 0 none */
	int samples;           /* a pixel: 1, 2, 4 or 8 */
	double pixel_error;    /* pixels the ground may be drawn off by; 0: its detail goes by the radii */
	struct scene_light light;
};

struct scene {
	char *file;   /* as given; of a text: "scene text" */
	char *folder; /* where the files that it names are: "" or ends in '/'; whole if hosted */
	bool hosted;  /* read for a host, which may add objects */
	char *store; /* resolved relative to the scene's file; NULL if none was named */
	double time_step, gravity;
	double end_time; /* s; INFINITY if hosted and not given */
	double spacing; /* 0: the store's own */
	enum scene_coordinates coordinates;
	char *srs; /* SCENE_SRS */
	enum deform_model model;
	int box_radius, box_repetitions;
	/* Models that move soil, and 0 for the others: */
	int iterations;    /* of sliding */
	double interval;   /* s of simulated time between those of the ground at large */
	double depth;      /* metres of loose soil below the base; INFINITY: no bottom */
	double tolerance;  /* metres more than what stands that are left as they are */
	double bulldozing; /* share */
	enum scene_undisturbed undisturbed; /* ground that is steeper than soil stands, where nothing has been */
	struct deform_soil soils[DEFORM_SOILS]; /* with a map the first is for where it says nothing else */
	int soil_count;
	char soil_names[DEFORM_SOILS][64]; /* "unnamed", or for a class of the map "unnamed_VALUE": given by numbers alone */
	char *soil_map;          /* a raster, resolved relative to the scene's file; NULL: soils[0] everywhere */
	uint8_t soil_class[256]; /* a value of the map: index of its soil */
	uint64_t soil_map_hash[2]; /* of the raster's bytes */
	bool dirt;
	enum scene_outside outside;
	struct scene_object *objects;
	size_t object_count;
	double forces;      /* rows of objects.csv a second of simulated time; 0: none */
	int forces_delay;   /* steps later that they may be read back; 0: at once, waiting */
	struct scene_view view;
	uint32_t slots, loaders;
	double prefetch; /* s */
	char **unused;   /* what the checker found to be of no use: "KEY: WHY; WHAT TO DO" */
	size_t unused_count;
	char **doubts;   /* numbers that are probably in another unit: "FILE:LINE: KEY: WHY; WHAT TO DO" */
	size_t doubt_count;
	char hash[33];   /* hex, of what decides the ground: not cache, view, output, store, end_time */
};

/* "none", "box", ..: as the scene writes it. */
const char *scene_model_word(enum deform_model model);

struct scene_setting {
	const char *key, *value; /* dotted, objects by name */
};

/* For whom a scene is read. A host steps the world itself and moves bodies: for it `scene`, `end_time`, `objects`,
 * and of an object `name` and `path` may be left out, and a scene may have neither objects nor a view. */
enum scene_reader { SCENE_COMMAND, SCENE_HOST };

/* The file (at most 1 MiB), the settings over it in order (values are YAML; `null` takes a key
 * away) and the files it names: poses (256 MiB each), meshes, the map of soils (1 GiB). STATUS_INPUT: what is wrong, and where. */
enum status scene_load(const char *path, const struct scene_setting *settings, size_t count,
		       struct scene **out) FURROW_CHECKED;
enum status scene_load_file(const char *path, const struct scene_setting *settings, size_t count,
			    enum scene_reader reader, struct scene **out) FURROW_CHECKED;
/* The same from YAML in UTF-8 (JSON is YAML); messages begin with "scene text:LINE". Files that it names are looked
 * for in `folder`; NULL: the process's current folder. All three may be called by several threads at once; they change
 * neither the locale nor anything else of the process. */
enum status scene_load_text(const char *text, const char *folder, const struct scene_setting *settings,
			    size_t count, enum scene_reader reader, struct scene **out) FURROW_CHECKED;
void scene_destroy(struct scene *scene);

/*
 * A number of a soil, index 0, 1, ..., in the order of the docs. `key`: as a scene writes it, "cohesion". `value`: in the
 * scene's unit, so angles are in degrees; NAN: the soil has none. Returns false beyond the last number.
 */
bool scene_soil_number(const struct deform_soil *soil, size_t index, const char **key, double *value);
/* The map's value for soils[soil]; -1: it is the default, or there is no map. */
int scene_soil_value(const struct scene *scene, int soil);

/*
 * Fills `object` from YAML of one entry of `objects`, checked as scene_load checks it with this scene; messages begin
 * with "object text:LINE: objects[0]". Without `path` it is the host's body, and has no sink, load or slip. With a path it
 * follows that. Its name is unlike those of the scene's objects; not given, it is body-N, the first that is free.
 * Files are looked for in the scene's folder. Freed with scene_object_finish, also where the scene is gone. On failure there is
 * nothing to free.
 */
enum status scene_object_parse(const struct scene *scene, const char *text, struct scene_object *object)
	FURROW_CHECKED;
void scene_object_finish(struct scene_object *object);

/* The effects a scene calls for at a working level (0: the store's own posts), as EFFECT_BIT of each. Of a hosted scene
 * also those that any body calls for, whether it has one or not; not what only some bodies do. */
uint64_t scene_effects(const struct scene *scene, int level);
/* What this object calls for and others do not: of EFFECT_MESH, EFFECT_LUGS, EFFECT_LOAD. */
uint64_t scene_object_effects(const struct scene_object *object);
/* The scene as a drive without a window runs it: a view of which no picture is written is left out. `out` refers to what
 * `scene` owns, and is not destroyed. */
void scene_unwatched(const struct scene *scene, struct scene *out);
/* Whether pictures show its map of soils, so that all tiles that are drawn need their classes. */
bool scene_draws_classes(const struct scene *scene);
/* What of the scene calls for it, of one that it calls for: "redistribute.model: box", "objects.front_left.load". */
void scene_effect_reason(const struct scene *scene, enum scene_effect effect, char *text, size_t size);

/* Tells what of the scene has no effect, or none that anybody sees: "KEY: WHY; WHAT TO DO", one line each, in the
 * scene's order. Each is certain, for ground of any shape; those of scene_advise_units are not. `spacing`: metres between
 * posts of the working level; 0: not known. */
typedef void (*scene_advice_fn)(void *user, const char *text);
void scene_advise(const struct scene *scene, double spacing, scene_advice_fn tell, void *user);
/* Tells the numbers that are probably in another unit: "FILE:LINE: KEY: WHY; WHAT TO DO", one line each. scene_advise
 * tells them first. */
void scene_advise_units(const struct scene *scene, scene_advice_fn tell, void *user);

#endif
