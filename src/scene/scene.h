/*
 * scene: reads a YAML file into a checked scene. It also holds the one table that describes every effect.
 *
 * A scene is untrusted input. Unknown keys, wrong types and values out of range are STATUS_INPUT, with "FILE:LINE: KEY: WHY;
 * what is allowed". All values are SI; angles are radians once checked. A struct scene does not change after scene_load. The
 * caller owns it.
 */
#ifndef FURROW_SCENE_H
#define FURROW_SCENE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/effect.h"
#include "deform/deform.h"

enum scene_coordinates { SCENE_LOCAL, SCENE_STORE, SCENE_SRS };
enum scene_outside { SCENE_STOP, SCENE_SKIP };
enum scene_undisturbed { SCENE_STABLE, SCENE_SLIDES };
enum scene_body { SCENE_EARTH, SCENE_MARS, SCENE_MOON };
enum scene_camera_kind { SCENE_CHASE, SCENE_OVERHEAD, SCENE_FIXED };

/* Every effect that a scene can use: the models' own, and those of the table in src/scene/effects.c in its order. */
enum scene_effect {
	EFFECT_MODEL, /* of the first model; each model has one */
	EFFECT_SPREAD = EFFECT_MODEL + DEFORM_MODELS,
	EFFECT_SHED,
	EFFECT_SLIDE,
	EFFECT_SOIL_MAP,
	EFFECT_MESH,
	EFFECT_GROUSERS,
	EFFECT_LOAD,
	EFFECT_FORCES,
	EFFECT_DISTURBANCE,
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
#define EFFECT_OF(model) ((enum scene_effect)(EFFECT_MODEL + (int)(model))) /* a model's own effect */
#define EFFECT_BIT(effect) ((uint64_t)1 << (effect)) /* in a set of effects */

const struct effect_row *scene_effect_row(enum scene_effect effect);
bool scene_effect_named(const char *name, enum scene_effect *effect);

/* Returns the present name of a key, word or layer that was renamed: "disturbance" for "dirt". Other names are returned
 * unchanged. Effects and planes keep their old names in code and in files. */
const char *scene_name_now(const char *name);

/* What a scene may give for a key. In a list: "objects[].sink". Of a soil: "soil.cohesion". */
struct scene_parameter {
	const char *kind;      /* "number", "whole number", "word", "switch", "text", "list" or "mapping" */
	const char *unit;      /* NULL: none */
	double low, high;      /* range of a number; NaN both: any finite number */
	bool above;            /* `low` itself is not allowed */
	double absent;         /* default of a number; NaN: `otherwise` says it, or, if NULL, */
	const char *otherwise; /* the key is required there */
	char words[96];        /* of a word: "stands, slides" */
};
bool scene_parameter(const char *key, struct scene_parameter *parameter); /* returns false if there is no such key */

/* A pose at a time. A path of points gives no t, z or attitude. They follow from its speed and the ground. */
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
	struct deform_mesh *mesh; /* owned: shape.mesh, or NULL */
	double sink; /* metres below the base at the path's point; 0 with a load */
	double load; /* N that the soil carries, instead of `sink`, of a model that tells forces; 0: none */
	double slip; /* of a wheel, of a model that tells forces: 1 - distance / (radius x angle turned), or below 0 if it is dragged */
};

/* The light of pictures. */
struct scene_light {
	enum scene_body body;
	double azimuth, height; /* of the sun: rad clockwise from north; rad above the horizon */
	bool coloured;          /* false: the colour of the sun on this planet, at this height */
	double colour[3];       /* linear */
};
#define SCENE_SUN_AZIMUTH (135 * M_PI / 180)
#define SCENE_SUN_HEIGHT (35 * M_PI / 180)
struct scene_light scene_light_default(void); /* the light of a view that names none */

struct scene_view {
	bool present;
	bool left_out;         /* left out by scene_unwatched */
	int width, height;
	enum scene_camera_kind camera;
	int target_object;     /* chase, overhead: index of the object */
	double back, up;       /* chase, metres */
	double over_height;    /* overhead, metres */
	double eye[3], target[3]; /* fixed: local metres */
	uint64_t effects;      /* EFFECT_BIT of each */
	int64_t images;        /* steps from one PNG to the next; 0: none */
	int samples;           /* samples a pixel: 1, 2, 4 or 8 */
	double pixel_error;    /* pixels by which drawn ground may be off; 0: radii decide its detail */
	struct scene_light light;
};

struct scene {
	char *file;   /* path as given; for a text: "scene text" */
	char *folder; /* folder of the files that it names: "" or ends in '/'; absolute if hosted */
	bool hosted;  /* read for a host, which may add objects */
	char *store; /* resolved relative to the scene's file; NULL if none was named */
	double time_step, gravity;
	double end_time; /* s; INFINITY if hosted and not given */
	double spacing; /* 0: the store's own */
	enum scene_coordinates coordinates;
	char *srs; /* SCENE_SRS */
	enum deform_model model;
	int box_radius, box_repetitions;
	/* For models that move soil; 0 for others: */
	int iterations;    /* relaxation iterations */
	double interval;   /* s of simulated time between relaxation intervals of the whole ground */
	double depth;      /* metres of soil below the base that can relax; INFINITY: no bottom */
	double tolerance;  /* metres by which a height difference may exceed the critical one without sliding */
	double bulldozing; /* share */
	enum scene_undisturbed undisturbed; /* what undisturbed ground does where it is steeper than soil is stable */
	struct deform_soil soils[DEFORM_SOILS]; /* with a map, the first is used where the map gives no other */
	int soil_count;
	char soil_names[DEFORM_SOILS][64]; /* "unnamed" if given by numbers alone; for a class of the map then "unnamed_VALUE" */
	char *soil_map;          /* path of a raster, resolved relative to the scene's file; NULL: soils[0] everywhere */
	uint8_t soil_class[256]; /* index of the soil for each value of the map */
	uint64_t soil_map_hash[2]; /* hash of the raster's bytes */
	bool disturbance;
	enum scene_outside outside;
	struct scene_object *objects;
	size_t object_count;
	double forces;      /* rows of objects.csv for a second of simulated time; 0: none */
	int forces_delay;   /* steps after which forces are read back; 0: at once, waiting */
	struct scene_view view;
	uint32_t slots, loaders;
	double prefetch; /* s */
	char **unused;   /* settings without effect that the checker found: "KEY: WHY; WHAT TO DO" */
	size_t unused_count;
	char **doubts;   /* numbers that are probably in another unit: "FILE:LINE: KEY: WHY; WHAT TO DO" */
	size_t doubt_count;
	char hash[33];   /* hex: hash of everything that decides the ground; without cache, view, output, store, end_time */
};

struct scene_setting {
	const char *key, *value; /* key with dots, objects by name */
};

/* Who uses the scene. A host steps the world itself and moves bodies. For a host `scene`, `end_time` and `objects` may be left
 * out, and `name` and `path` of an object. Its scene may have neither objects nor a view. */
enum scene_reader { SCENE_COMMAND, SCENE_HOST };

/* Reads a scene from a file of at most 1 MiB. Applies the settings in order; their values are YAML, and `null` removes a key.
 * Then reads the files that it names: poses (256 MiB each), meshes, the map of soils (1 GiB). STATUS_INPUT: the message says
 * what is wrong, and where. */
enum status scene_load(const char *path, const struct scene_setting *settings, size_t count,
		       struct scene **out) FURROW_CHECKED;
enum status scene_load_file(const char *path, const struct scene_setting *settings, size_t count,
			    enum scene_reader reader, struct scene **out) FURROW_CHECKED;
/* The same from a text: YAML in UTF-8 (JSON is YAML). Messages begin with "scene text:LINE". Files that it names are looked for
 * in `folder`; NULL: the process's current folder. Several threads may call all three at once. They change nothing of the
 * process, not even the locale. */
enum status scene_load_text(const char *text, const char *folder, const struct scene_setting *settings,
			    size_t count, enum scene_reader reader, struct scene **out) FURROW_CHECKED;
void scene_destroy(struct scene *scene);

/*
 * Tells one number of a soil, index 0, 1, ..., in the order of the docs. `key`: its key in a scene, "cohesion". `value`: in the
 * scene's unit, so angles are in degrees; NAN: the soil has none. Returns false beyond the last number.
 */
bool scene_soil_number(const struct deform_soil *soil, size_t index, const char **key, double *value);
/* Returns the map's value for soils[soil]; -1: it is the default soil, or there is no map. */
int scene_soil_value(const struct scene *scene, int soil);

/*
 * Fills `object` from the YAML of one entry of `objects`, with the checks of scene_load for this scene. Messages begin with
 * "object text:LINE: objects[0]". Without `path` it is a body of the host, and has no sink, load or slip. With a path it
 * follows the path.
 *
 * Its name must differ from the names of the scene's objects. Without a name it becomes body-N, the first that is free. Files
 * are looked for in the scene's folder. Free it with scene_object_finish; the scene may be gone by then. On failure there is
 * nothing to free.
 */
enum status scene_object_parse(const struct scene *scene, const char *text, struct scene_object *object)
	FURROW_CHECKED;
void scene_object_finish(struct scene_object *object);

/* Returns the effects that a scene uses at a working level (0: the store's own posts), as EFFECT_BIT of each. For a hosted
 * scene it adds the effects that every body uses, whether it has a body or not. Effects of some bodies only are not added. */
uint64_t scene_effects(const struct scene *scene, int level);
/* Returns effects that this object uses and others may not: of EFFECT_MESH, EFFECT_GROUSERS, EFFECT_LOAD. */
uint64_t scene_object_effects(const struct scene_object *object);
/* Copies the scene as a drive without a window runs it. A view is left out if no picture of it is written. `out` points to what
 * `scene` owns. Do not destroy it. */
void scene_unwatched(const struct scene *scene, struct scene *out);
/* Returns true if pictures show the map of soils. Then all drawn tiles need their classes. */
bool scene_draws_classes(const struct scene *scene);
/* Tells which setting of the scene turns on an effect that it uses: "redistribute.model: box", "objects.front_left.load". */
void scene_effect_reason(const struct scene *scene, enum scene_effect effect, char *text, size_t size);

/* Tells the settings without effect, or without an effect that anybody sees. One line each, "KEY: WHY; WHAT TO DO", in the
 * scene's order. Each is certain for ground of any shape, except those of scene_advise_units. `spacing`: metres between posts
 * of the working level; 0: not known. */
typedef void (*scene_advice_fn)(void *user, const char *text);
void scene_advise(const struct scene *scene, double spacing, scene_advice_fn tell, void *user);
/* Tells the numbers that are probably in another unit. One line each, "FILE:LINE: KEY: WHY; WHAT TO DO". scene_advise tells
 * them first. */
void scene_advise_units(const struct scene *scene, scene_advice_fn tell, void *user);

#endif
