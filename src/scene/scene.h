/*
 * scene: reads a YAML file into a checked scene. It also holds the one table that describes every effect.
 *
 * A scene is untrusted input. Unknown keys, wrong types and values out of range are STATUS_INPUT. The message is
 * "FILE:LINE:COLUMN: KEY: WHY; what is allowed". All values of a struct scene are SI units; angles are in radians. A struct scene does not change
 * after scene_load. The caller owns it.
 */
#ifndef FURROW_SCENE_H
#define FURROW_SCENE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/rocks.h"
#include "base/effect.h"
#include "deform/deform.h"

enum scene_coordinates { SCENE_LOCAL, SCENE_STORE, SCENE_SRS };
enum scene_outside { SCENE_STOP, SCENE_SKIP };
enum scene_compute { SCENE_ANYWHERE, SCENE_GPU, SCENE_CPU };
enum scene_undisturbed { SCENE_STABLE, SCENE_SLIDES };
enum scene_regions { SCENE_WINDOWS, SCENE_FIXED_REGIONS };
enum scene_normals { SCENE_BODY, SCENE_GROUND };
enum scene_faces { SCENE_FACES_ON, SCENE_FACES_OFF };
enum scene_thrown { SCENE_THROWN_OFF, SCENE_THROWN_ON };
enum scene_body { SCENE_EARTH, SCENE_MARS, SCENE_MOON };
enum scene_camera_kind { SCENE_CHASE, SCENE_OVERHEAD, SCENE_FIXED, SCENE_MOUNTED, SCENE_BY_POSES };

/* Every effect that a scene can use: first one for each soil model, then those of the table in src/scene/effects.c, in its
 * order. */
enum scene_effect {
	EFFECT_MODEL, /* the effect of the first model; each model has one */
	EFFECT_SPREAD = EFFECT_MODEL + DEFORM_MODELS,
	EFFECT_SHED,
	EFFECT_SLIDE,
	EFFECT_SLIP,
	EFFECT_LOOSE,
	EFFECT_DENSE,
	EFFECT_THROWN,
	EFFECT_CARRIED,
	EFFECT_SOIL_MAP,
	EFFECT_SOIL_RASTERS,
	EFFECT_MESH,
	EFFECT_GROUSERS,
	EFFECT_TYRES,
	EFFECT_LOAD,
	EFFECT_FORCES,
	EFFECT_DISTURBANCE,
	EFFECT_VEGETATION,
	EFFECT_SUBDIVIDE,
	EFFECT_RELIEF,
	EFFECT_ROCKS,
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
	EFFECT_CAMERAS,
	EFFECT_TERRAIN_SHADOW,
	EFFECT_IMAGERY,
	EFFECT_LIGHT,
	EFFECT_COUNT
};
#define EFFECT_OF(model) ((enum scene_effect)(EFFECT_MODEL + (int)(model))) /* the effect of using a model */
#define EFFECT_BIT(effect) ((uint64_t)1 << (effect)) /* the bit of an effect in a set of effects */

const struct effect_row *scene_effect_row(enum scene_effect effect);
bool scene_effect_named(const char *name, enum scene_effect *effect);

/* Returns the present name of a key, word or layer that was renamed: "disturbance" for "dirt". Other names are returned
 * unchanged. Effects and planes keep their old names in code and in files. */
const char *scene_name_now(const char *name);

/* Describes what a scene may give for a key. `key` is written without indices: "objects[].sink". Keys of any soil are written
 * "soil.": "soil.cohesion". */
struct scene_parameter {
	const char *kind;      /* "number", "whole number", "word", "switch", "text", "list" or "mapping" */
	const char *unit;      /* NULL: none */
	double low, high;      /* range of a number; NaN both: any finite number */
	bool above;            /* true: the value must be above `low`; `low` itself is not allowed */
	double absent;         /* default of a number; NaN: `otherwise` describes the default */
	const char *otherwise; /* the default in words; NULL while `absent` is NaN: the key is required in its mapping */
	char words[96];        /* the allowed words of a "word": "stands, slides" */
};
bool scene_parameter(const char *key, struct scene_parameter *parameter); /* returns false if there is no such key */

/* A pose at a time. Waypoints of a path of points have x and y only. Time, height and attitude follow from the speed and the
 * ground. */
struct scene_waypoint {
	double t, x, y, z, yaw, pitch, roll; /* t in s; x, y in the unit of `coordinates`; z in m; angles in rad */
};

struct scene_path {
	struct scene_waypoint *points;
	size_t count; /* 0: the path has no points, and the host moves the object */
	double speed; /* m/s; only for a path of points */
	bool loop;
	bool degrees; /* x and y are degrees east and north on the store's body, whatever the scene's coordinates are */
	bool smooth;  /* it is a curve through its points, not straight lines */
	/* The path in metres of the store's axes is turned about its first point, in rad from east to north, and then moved, in m. Yaws of the
	 * waypoints are turned already; x and y are not. */
	double rotate, offset[2];
	/* The path is that of another object. This one is so many metres ahead of it, and to its left. Ahead is along the way; with attitudes
	 * it is along that object's own axis. */
	double beside[2];
	double delay;          /* s by which all of it is later */
	int line;              /* where the scene's file gives its points; 0: --set does */
	bool timed;            /* the path is from a file with times, so each waypoint has its t */
	bool cornered;         /* only of motion_route: timed, and yet it turns at its waypoints alone, not between them */
	bool has_z, has_attitude;
	/* How the object is turned against its way: yaw to the left, then pitch, then roll, rad. Zeros where the waypoints have the attitude. */
	double attitude[3];
};

/* A road, or a net of roads: every line of a file, or one through points. Posts within half the width of a line have its soil. */
struct scene_road {
	struct scene_path *lines; /* points in the scene's coordinates, or degrees; smooth or not */
	size_t line_count;
	double width; /* m */
	uint8_t soil; /* index of scene.soils */
};

struct scene_object {
	char *name;
	bool name_is_made; /* the scene gave none: it is body-N */
	struct soil_shape shape;
	struct scene_path path;
	struct soil_mesh *mesh; /* owned by the object; it is also shape.mesh. NULL: no mesh */
	double sink; /* metres that the object sinks below the base at the path's point; 0 if it has a load */
	bool carry;  /* soil that comes onto it stays on it */
	double load; /* N that the soil carries; given instead of `sink`, for models that compute forces. 0: no load */
	/* of a wheel, for models that compute forces: 1 - distance / (radius x angle turned); below 0 if the wheel is dragged. Of a belt:
	 * 1 - distance / what the belt ran */
	double slip;
	struct soil_interface interface; /* for models that compute forces */
};

/* What sets the controls of a vehicle's actuators. SCENE_IDLE: nothing; all controls are 0. */
enum scene_driver { SCENE_IDLE, SCENE_FOLLOW, SCENE_CONTROLS, SCENE_HOLD };

/* A list of texts. */
struct scene_texts {
	char **list;
	size_t count;
};

/* Whether a root without a joint is held: the model says it; a URDF says no. */
enum scene_fixed { SCENE_FIXED_BY_MODEL, SCENE_FIXED_NO, SCENE_FIXED_YES };
/* What may end a drive of vehicles. */
enum scene_stop { SCENE_STOP_OVERTURNED, SCENE_STOP_BURIED, SCENE_STOP_STUCK, SCENE_STOPS };
const char *scene_stop_name(enum scene_stop stop);

/* 0: by the joint and the vehicle's weight. */
struct scene_servo {
	double kv, torque; /* N m s; N m. N s/m and N for slides */
	struct scene_texts free, lock; /* patterns of joints that move freely, and that do not move */
};

/* How a differential shares the torque. open: alike, at any speeds. limited: up to a difference. locked: speeds are alike. */
enum scene_differential { SCENE_OPEN, SCENE_LIMITED, SCENE_LOCKED };
#define SCENE_GEARS_MOST 24
/* From the engine to the wheels: src/vehicle/powertrain.h. Speeds are rpm, as people have them. */
struct scene_powertrain {
	bool present;
	struct scene_texts wheels;       /* patterns of joints or actuators; none: those of driver.drive */
	double (*engine)[2];             /* rpm and N m at full throttle, by growing speed */
	size_t engine_count;
	double inertia, idle, drag;      /* kg m2; rpm; N m with closed throttle */
	double gears[SCENE_GEARS_MOST], reverse, final;
	size_t gear_count;
	bool shifts;                     /* it shifts itself: */
	double down, up, shift_time;     /* rpm of the gearbox's input; s */
	double clutch, engage;           /* N m; rpm at which it holds that much. 0: there is a converter */
	double capacity, stall_ratio, coupling; /* N m s2; torque of its turbine over that of its pump at rest; speed ratio from which on it is 1 */
	enum scene_differential centre, front, rear;
	double bias, lock;               /* of limited ones: the greater torque over the smaller one; N m that they take between both sides besides */
};

/* Numbers by name. */
struct scene_named {
	struct scene_texts names;
	double *values;
};

/* How a vehicle begins, besides its place. All 0: as its model's first pose is, set down and settled. */
struct scene_start {
	double pitch, roll;          /* rad: nose up, right side down */
	double height;               /* m: of its lowest soil geom above the ground. Above 0: it falls, and does not settle */
	double speed;                /* m/s at t = 0, forward */
	bool unsettled;              /* begins as it is placed */
	struct scene_named joints;   /* patterns of joints: rad, m */
	struct scene_named controls; /* names of actuators: what they have until a driver sets them */
};

enum scene_forward { SCENE_PLUS_X, SCENE_MINUS_X, SCENE_PLUS_Y, SCENE_MINUS_Y };
/* rubber is rough: the soil's own strength counts. steel: in clean sand, NAVFAC DM-7.02 (docs/SOILS.md). */
enum scene_material { SCENE_RUBBER, SCENE_STEEL, SCENE_CONCRETE };
/* The surface of geoms. */
struct scene_surface {
	char *geoms;            /* a pattern */
	struct soil_interface interface;
};

/* A tyre of the wheels of a vehicle that a pattern names. NAN: not given. */
struct scene_tyre {
	char *geom;
	double width; /* m */
	struct soil_tyre_told told;
};

/* An IMU that a scene adds to a model: an accelerometer, a gyro and an attitude at one place. */
struct scene_imu {
	bool present;
	char *body;             /* of the model; NULL: its root body */
	double at[3];           /* m, forward, left, up from that body's origin */
	double noise[2];        /* standard deviations: m/s2, rad/s */
};

/* A vehicle: a model whose motion MuJoCo computes. Names of geoms and actuators are known only when the model is read. */
struct scene_vehicle {
	char *name;
	char *model;            /* path, resolved relative to the scene's file */
	uint64_t model_hash[2]; /* hash of the model's bytes; files that the model names are not in it */
	enum scene_forward forward; /* where the model looks, */
	bool y_up;              /* and whether its y axis looks up, not z */
	double at[2], yaw;      /* where it starts: in the unit of `coordinates`; rad from east to north */
	int line;               /* where the scene's file gives that place; 0: --set does */
	char *keyframe;         /* of the model, for its first pose and its controls; NULL: none */
	enum scene_fixed fixed; /* whether its root is held where it is set */
	struct scene_start start;
	struct scene_texts model_path;   /* folders of packages, resolved relative to the scene's file */
	struct scene_powertrain powertrain;
	double brakes;                   /* N m: that each wheel's brake gives at most; 0: it has none */
	struct scene_servo servo;        /* of joints that the driver names and that have no actuator */
	struct scene_texts soil;         /* patterns of the geoms that touch the ground; none: all that collide */
	struct scene_texts no_soil;      /* patterns of geoms that never touch it */
	struct scene_texts carry;        /* patterns of those that carry soil; none: no geom */
	struct scene_surface *surfaces;  /* what geoms are of; the last that names one counts */
	size_t surface_count;
	char *pushes;           /* path of a table of forces on its bodies in time; NULL: none */
	uint64_t pushes_hash[2];
	struct scene_imu imu;
	struct scene_tyre *tyres;        /* the first that names a wheel counts; none: wheels are rigid */
	size_t tyre_count;
	enum scene_driver driver;
	struct scene_path way;  /* SCENE_FOLLOW: points and a speed */
	struct scene_texts steer, drive; /* SCENE_FOLLOW: patterns of actuators */
	bool follows_origin;    /* its origin follows the way; false: the middle of its axle that does not steer */
	double *speeds;         /* m/s, one for each point of the way, all above 0 or all below; NULL: way.speed everywhere */
	double (*stops)[2];     /* s: from, to: it shall not move then */
	size_t stop_count;
	char *controls;         /* SCENE_CONTROLS: path of a table in time */
	uint64_t controls_hash[2];
	struct scene_named held; /* SCENE_HOLD: names of actuators, and their controls */
};

/* The light of pictures. */
struct scene_light {
	enum scene_body body;
	bool on_body;           /* the scene names the body; false: it is that of the store, if that is known, otherwise the Earth */
	double azimuth, height; /* of the sun, in rad: azimuth clockwise from north, height above the horizon */
	bool timed;             /* these follow from a time and a place: */
	double days;            /* when the drive begins: days since 2000-01-01 12:00, UTC */
	bool placed;            /* false: the place is the middle of the store's terrain */
	double longitude, latitude; /* rad, east and north */
	/* sun: level ground is as bright whatever its height; auto: the frame's mean light is as bright */
	enum scene_exposure { SCENE_EXPOSURE_FIXED, SCENE_EXPOSURE_SUN, SCENE_EXPOSURE_AUTO } exposure;
	double ev;              /* stops: pictures are 2^ev times as bright as by `exposure` alone */
	bool coloured;          /* `colour` is given; false: the colour is computed for this planet and this height of the sun */
	double colour[3];       /* linear */
};
#define SCENE_SUN_AZIMUTH (135 * M_PI / 180)
#define SCENE_SUN_HEIGHT (35 * M_PI / 180)
/* Gives where the sun is in the sky of a place: azimuth clockwise from true north and height above the horizon, rad. On the Earth the
 * air raises it. `days`: since 2000-01-01 12:00, UTC. `longitude` (east) and `latitude`: rad. Sources and accuracy: scene_sun.c. */
void scene_sun_at(enum scene_body body, double days, double longitude, double latitude, double *azimuth, double *height);
/* Gives the local solar times of a place on Mars, in hours of 1/24 sol, 0 to below 24. *mean: LMST. *apparent: LTST, which is 12 when the sun is highest. */
void scene_mars_hours(double days, double longitude, double *mean, double *apparent);
struct scene_light scene_light_default(void); /* returns the light of a view that gives no light */

/* What a camera follows, or where it is. */
struct scene_aim {
	enum scene_camera_kind kind;
	int object;            /* chase, overhead, mounted: index of the object, */
	int vehicle;           /* or of the vehicle, from 1; 0: it is an object */
	double back, up;       /* of a chase camera, in metres */
	double over_height;    /* of an overhead camera, in metres */
	double eye[3], target[3]; /* of a fixed camera, in local metres. The eye of a mounted one, in metres along the body's axes */
};

/* What a camera writes of each frame. */
enum scene_image { SCENE_IMAGE_COLOUR, SCENE_IMAGE_DEPTH, SCENE_IMAGE_NORMALS, SCENE_IMAGE_HEIGHT, SCENE_IMAGE_CLASS, SCENE_IMAGE_INSTANCE, SCENE_IMAGE_LINEAR, SCENE_IMAGES };
/* drawn a second time */
#define SCENE_IMAGES_MEASURED (1u << SCENE_IMAGE_NORMALS | 1u << SCENE_IMAGE_HEIGHT | 1u << SCENE_IMAGE_CLASS | 1u << SCENE_IMAGE_INSTANCE)

#define SCENE_CAMERAS 128 /* most cameras of a scene: 64 pairs */
/* A camera that writes pictures of a drive. A stereo pair is two cameras. */
struct scene_camera {
	char *name;            /* also of its folder */
	struct scene_aim aim;
	char *body;            /* mounted on a vehicle: a body of its model; NULL: the root body */
	bool turned;           /* fixed: yaw, pitch and roll count, and not aim.target. Of a mounted camera they always count */
	double yaw, pitch, roll; /* radians, as a pose's; of a mounted camera against the body's axes */
	struct scene_path poses; /* of SCENE_BY_POSES, in local metres */
	double fov;            /* horizontal, radians */
	int width, height;     /* pixels */
	double rate;           /* frames for each second of simulated time */
	unsigned images;       /* bit 1 << enum scene_image of each */
	enum scene_exposure exposure; /* as scene_light has it for the view */
	double ev;
	double depth_unit;     /* metres of 1 in a 16-bit picture of depth */
	bool video;            /* ffmpeg makes one of its colours at the end */
	int pair;              /* the other camera of a stereo pair; -1: none */
	double baseline;       /* of the right camera of a pair: metres to the right of the left one; else 0 */
};

#define SCENE_LIDARS 64 /* the most that a scene may have */
/* A sensor that measures ranges along rays, all at the same time. */
struct scene_lidar {
	char *name;            /* also of its folder */
	int vehicle;           /* that it is mounted on, from 1; 0: none, it does not move */
	char *body;            /* a body of the vehicle's model; NULL: the root body */
	double at[3];          /* m: along the axes of what it is on; local, if it does not move */
	double yaw, pitch, roll; /* radians, as a pose's */
	int columns, rows;     /* rays around and rays up */
	double fov[2];         /* radians: around, and up from the lowest row to the highest */
	double nearest, farthest; /* m: nothing is measured outside */
	double rate;           /* frames for each second of simulated time */
	double noise;          /* m: standard deviation */
	double dropout;        /* share of rays that give nothing */
};

struct scene_view {
	bool present;
	bool left_out;         /* scene_unwatched left this view out */
	bool implied;          /* the scene has no view, but cameras, which need its effects */
	int width, height;
	struct scene_aim aim;
	uint64_t effects;      /* EFFECT_BIT of each */
	int64_t images;        /* steps from one PNG to the next; 0: none */
	int samples;           /* samples for each pixel: 1, 2, 4 or 8 */
	/* pixels by which drawn ground may be wrong; 0: distance alone decides its detail */
	double pixel_error;
	/* Which pictures have the light of the drawn surface alone, so that colour agrees with depth. By kind: those of all cameras but chase. */
	enum scene_truth { SCENE_TRUTH_BY_KIND, SCENE_TRUTH_ALL, SCENE_TRUTH_NONE } truth;
	double imagery_budget; /* MB of the GPU's memory for tiles of imagery */
	struct scene_light light;
};

const char *scene_image_name(enum scene_image image); /* as a scene names it, and its folder */
/* Returns the number of the frame that a camera writes after this step, from 0; -1: none. Frame n is written after the first step
 * that ends at n / rate seconds or later. So the number depends on the step alone. Frame 0 shows the scene before the first step. */
int64_t scene_camera_frame(const struct scene_camera *camera, double time_step, int64_t step);
int64_t scene_camera_step(const struct scene_camera *camera, double time_step, int64_t frame); /* returns that step of a frame */

/* Return the same of a sensor with `rate` frames a second. */
int64_t scene_frame_at(double rate, double time_step, int64_t step);

/* A setting of the scene. `key`: with dots, as --set takes it. `text`: YAML on one line; a long one is cut, and then has a hash. */
struct scene_value {
	char *key, *text;
};

/* A raster that gives a number of the soil at each post. Where it has no value, the number is that of the post's soil. */
struct scene_raster {
	enum soil_number number;
	char *path;       /* resolved relative to the scene's file */
	uint64_t hash[2]; /* of the file's bytes */
};

/* Plants on the ground. A body bends them, and tears them where it slips. */
struct scene_vegetation {
	bool present;
	double cover[SOIL_CLASSES]; /* share of the ground that they cover, 0 to 1, by class of soil */
	double height;              /* m */
	double tears;               /* the slip at which nothing is left */
	double rises, grows;        /* s: until bent stems stand again, and until torn cover has grown back */
};

struct scene {
	char *file;   /* path as the caller gave it; "scene text" if the scene was read from a text */
	char *folder; /* folder where the files named in the scene are looked for: "" or ends in '/'; absolute if hosted */
	bool hosted;  /* the scene was read for a host, which may add objects */
	char *store; /* path of the store, resolved relative to the scene's file; NULL if the scene names none */
	double time_step, gravity;
	bool gravity_given;
	double end_time; /* s; INFINITY if the scene is hosted and does not give it */
	double spacing; /* metres between posts of the working level; 0: the spacing of the store */
	enum scene_coordinates coordinates;
	char *srs; /* used with SCENE_SRS only */
	enum deform_model model;
	int box_radius, box_repetitions;
	/* The next values are for models that move soil. For other models they are 0. */
	int iterations;    /* relaxation iterations */
	double interval;   /* s of simulated time between relaxation intervals of the whole ground */
	double depth;      /* metres of soil below the base that can relax; INFINITY: no bottom */
	double tolerance;  /* metres by which a height difference may exceed the critical one without sliding */
	double bulldozing; /* share of the displaced soil, 0 to 1 */
	double loosening, hardening; /* by which share deposited soil bears less; by which passes make soil stronger in the end. 0: not */
	double slip_sinkage; /* how deep slip digs, in units of the soil's shear modulus; 0: not */
	double inertia;      /* of soil that faces push away, a share of rho v^2; 0: none */
	/* Of an elastic sheet: its tension, N/m, and the stiffness of what it lies on, Pa/m. The deflection up to which it comes back whole, m; INFINITY: it
	 * always does. Of what is beyond, the share that stays. For other models they are 0 */
	double tension, stiffness, yield, rut;
	enum scene_faces faces; /* whether stress acts on a body's faces from every side as it slides, or on its lower envelope alone */
	enum scene_thrown thrown; /* whether soil that slip digs flies off */
	enum scene_normals normals; /* along which stresses act: those of a body itself, or of the ground */
	enum scene_undisturbed undisturbed; /* what undisturbed ground does where it is steeper than the soil's critical slope */
	struct soil_numbers bases[SOIL_CLASSES]; /* what the soils of the same index lie over, if they do */
	char base_names[SOIL_CLASSES][64];
	struct soil_numbers soils[SOIL_CLASSES]; /* with a map, soils[0] is used where the map names no other soil */
	unsigned soil_given[SOIL_CLASSES]; /* for scene_soil_given */
	int soil_count;
	/* "unnamed" if the scene gives numbers without a name; such a class of the map is "unnamed_VALUE" */
	char soil_names[SOIL_CLASSES][64];
	bool soil_default;       /* false: the scene has a map and says no soil for ground without a class; soils[0] is that of the first class */
	char *soil_map;          /* path of a raster, resolved relative to the scene's file; NULL: soils[0] everywhere */
	uint8_t soil_class[256]; /* index of the soil for each value of the map */
	uint64_t soil_map_hash[2]; /* hash of the raster's bytes */
	struct scene_road *roads; /* over the map. Of two at one post the later one counts */
	size_t road_count;
	struct rocks_spec rocks; /* over all; cover 0: none. smallest 0: three working posts */
	uint8_t rocks_soil;      /* index of their soil; 0: they have that of the ground */
	struct scene_raster rasters[SOIL_RASTERS]; /* in the order of their numbers */
	int raster_count;        /* 0: every number is that of a post's soil */
	struct relief_spec relief; /* below the source's level; its classes are indices of soils;
				      classes 0: none */
	bool disturbance;
	double heals;            /* s: what the darkest disturbance takes to heal; 0: it stays */
	struct scene_vegetation vegetation;
	double elapsed;          /* s of the store's time that pass before the drive begins */
	enum scene_outside outside;
	/* What computes the ground; it changes no bit. SCENE_ANYWHERE: scm and sheet the CPU, other models the GPU, and the CPU where there is no GL. scm takes no SCENE_GPU. */
	enum scene_compute compute;
	/* Where the GPU computes contacts: in windows, which are gathered from tiles and scattered; or in the tiles. It changes no bit. */
	enum scene_regions regions;
	struct scene_object *objects;
	size_t object_count;
	struct scene_vehicle *vehicles;
	size_t vehicle_count;
	struct scene_vehicle *things; /* what `world` names: things of MuJoCo that are no vehicles; NULL: none */
	unsigned stop;       /* bits of enum scene_stop: what ends the drive, once each vehicle has it or is at the end of its path */
	double stuck_after, stuck_below; /* s, m/s: a vehicle that is slower for so long is stuck; 0: nobody asks */
	double vehicle_rows; /* rows of vehicles.csv for each second of simulated time; 0: none */
	double sensor_rows; /* rows of sensors.csv for each second of simulated time; 0: none */
	bool noise_seeded;  /* sensors of models have the noise that they say */
	uint32_t noise_seed;
	bool map;           /* a drive writes map.png at its end */
	double forces;      /* rows of objects.csv for each second of simulated time; 0: none */
	struct scene_view view;
	struct scene_camera *cameras;
	size_t camera_count;
	struct scene_lidar *lidars;
	size_t lidar_count;
	uint32_t slots, loaders;
	uint64_t memory; /* bytes that tiles may take; 0: not given, `slots` counts */
	double prefetch; /* s of driving that the prefetcher looks ahead */
	char **unused;   /* settings of the scene that have no effect: "KEY: WHY; WHAT TO DO" */
	size_t unused_count;
	char **doubts;   /* numbers that seem to be given in a wrong unit: "FILE:LINE:COLUMN: KEY: WHY; WHAT TO DO" */
	size_t doubt_count;
	struct scene_value *values; /* all settings as text, with those of --set, in the order of the file */
	size_t value_count;
	/* hex: hash of all settings that decide the ground. The cache, view, output, store and end_time do not count. */
	char hash[33];
};

struct scene_setting {
	const char *key, *value; /* the key with dots; an object is named by its name: "objects.front_left.load" */
};

/* Who reads the scene: the furrow command, or a host (a program that calls the library, steps the world and moves bodies
 * itself). A host's scene may leave out the keys scene, end_time, objects, and each object's name and path. It may have neither
 * objects nor a view. */
enum scene_reader { SCENE_COMMAND, SCENE_HOST };

/* Reads a scene from a file of at most 1 MiB. Applies the settings in their order. Values of settings are YAML; the value
 * `null` removes a key. Then reads the files that the scene names: poses (at most 256 MiB each) and meshes. A map and
 * rasters of the soil (at most 1 GiB each) are hashed. STATUS_INPUT: the message tells what is wrong, and where. */
enum status scene_load(const char *path, const struct scene_setting *settings, size_t count,
		       struct scene **out) FURROW_CHECKED;
enum status scene_load_file(const char *path, const struct scene_setting *settings, size_t count,
			    enum scene_reader reader, struct scene **out) FURROW_CHECKED;
/* The same from a text: YAML in UTF-8 (JSON is YAML). Messages begin with "scene text:LINE:COLUMN". Files that the scene names are
 * looked for in `folder`; NULL: the current folder of the process. Several threads may call these three functions at once. The
 * locale of each must be "C" (base/c_locale.h), as in all of the library. */
enum status scene_load_text(const char *text, const char *folder, const struct scene_setting *settings,
			    size_t count, enum scene_reader reader, struct scene **out) FURROW_CHECKED;
/* Returns a message of scene_load_text without "scene text:LINE:COLUMN: " at its begin: nobody knows the lines of a text that a program wrote. */
const char *scene_text_reason(const char *message);
/*
 * Reads the triangles of a mesh of a vehicle's model: OBJ, STL, DAE (COLLADA) or glTF 2. Its unit times `scale` is metres; a DAE has a unit of its own.
 * Axes are as the file has them, as programs that read URDF take them. STATUS_INPUT, with a message that begins with `told`: as for the mesh of an
 * object. Any thread. Free *out with scene_mesh_destroy.
 */
enum status scene_mesh_read(const char *path, const char *told, double scale, struct soil_mesh **out) FURROW_CHECKED;
void scene_mesh_destroy(struct soil_mesh *mesh); /* takes NULL */
void scene_destroy(struct scene *scene);

/*
 * Gives one number of a soil. `index`: 0, 1, ..., in the order of the docs. `key`: the number's key in a scene, such as
 * "cohesion". `value`: in the unit that a scene uses, so angles are in degrees; NAN: the soil has no such number. Returns false
 * if `index` is beyond the last number.
 */
bool scene_soil_number(const struct soil_numbers *soil, size_t index, const char **key, double *value);
/* Makes a scene that has this soil and nothing else: its soils[0] has the numbers that scm reads. `soil`: its name, or YAML of a scene's `soil` in
 * braces. STATUS_INPUT: there is no such soil, or the text is wrong. */
enum status scene_soil_alone(const char *soil, struct scene **out) FURROW_CHECKED;
/* Writes a soil as YAML in braces, with those of its numbers that the model reads. NULL: out of memory. Free it with mem_free. */
char *scene_soil_text(const struct soil_numbers *soil, enum deform_model model) FURROW_CHECKED;
/* Gives YAML of a soil whose strength and stiffness are multiplied: `factor` of cohesion, friction (its tangent), k_c and k_phi. Free it with
 * mem_free. NULL: out of memory, or there is no such soil; the message tells. */
char *scene_soil_varied(const char *soil, const double factor[3]);
/* Returns true if the scene gives the number itself. Returns false if the number is that of a named soil, or a default. */
bool scene_soil_given(const struct scene *scene, int soil, const char *key);
/* Soils have more than these, but for the last. A smaller number is probably in a wrong unit. */
#define SCENE_LEAST_ANGLE 1.6     /* degrees. The largest angle in radians, pi / 2, is less, so it is noticed */
#define SCENE_RIGID "rigid"        /* the name of rigid ground in soil.over: it bears any load */
#define SCENE_LEAST_COHESION 50.0 /* Pa: of the soils in the tables the least has 170 */
#define SCENE_LEAST_KPHI 10000.0  /* N/m^(n+2): of the soils in the tables the least has 43120, and the largest 5301 in kN */
#define SCENE_MOST_SHEAR 0.15     /* m: of the soils in the tables the largest has 0.03. A larger number is probably in cm or mm */
/* Returns the SI value of 1 in the unit that a scene and a raster use for the number. */
double scene_raster_unit(enum soil_number number);
/* Returns k_c / b + k_phi of a soil under an object. *width: b, metres; 0: it depends on the contact. Then the larger of k_c and
 * k_phi is returned. Above 0: the soil bears the object. */
double scene_soil_modulus(const struct soil_numbers *soil, const struct soil_shape *shape, double *width);
/* Returns the value of the map of soils that means soils[soil]. Returns -1 for the default soil, or if there is no map. */
int scene_soil_value(const struct scene *scene, int soil);
/* Returns true if soils differ from place to place: by a map, by roads, or by rocks. */
bool scene_has_classes(const struct scene *scene);

/*
 * Fills `object` from the YAML text of one entry of `objects`. Checks it as scene_load would for this scene. Messages begin
 * with "object text:LINE:COLUMN: objects[0]". If the text has a `path`, the object follows it. Otherwise the host moves the object,
 * and it has no sink, load or slip.
 *
 * The object's name must differ from the names of the scene's objects. An object without a name is named body-N, with the first
 * N that is free. Files are looked for in the scene's folder. The caller frees the object with scene_object_finish, also after
 * the scene was destroyed. On failure there is nothing to free.
 */
enum status scene_object_parse(const struct scene *scene, const char *text, struct scene_object *object)
	FURROW_CHECKED;
void scene_object_finish(struct scene_object *object);

/* Returns the effects that a scene uses at a working level, as a set of EFFECT_BIT. Level 0 means the store's own posts. A
 * hosted scene may get bodies later. So the result includes the effects that every body uses, but not the effects of some
 * bodies only. */
uint64_t scene_effects(const struct scene *scene, int level);
/* Returns those of EFFECT_MESH, EFFECT_GROUSERS, EFFECT_TYRES and EFFECT_LOAD that this object uses. */
uint64_t scene_object_effects(const struct scene_object *object);
/* Returns false if no body of the scene can slip. Such a body never moves, or it is a wheel of slip 0 that rolls straight ahead. */
bool scene_slips(const struct scene *scene);
/* Returns true if soil may fly: where redistribute.thrown is on, and something slips or carries. */
bool scene_throws(const struct scene *scene);
/* Returns true if an object's path or the scene turns it otherwise than along its way. */
bool scene_is_turned(const struct scene_object *object);
/* By which law the soil acts on a part of a body: Bekker's and Janosi's below it, or 3D-RFT where it slides. That is 3D resistive force theory. */
struct scene_law_part {
	const char *part;   /* "rim", "sides", "bars", "underside", "front and sides" */
	double faces;       /* share that 3D-RFT has, 0 to 1; NAN: it depends on the motion, which is not known here */
};
enum { SCENE_LAW_PARTS = 3 };
struct scene_laws {
	struct scene_law_part parts[SCENE_LAW_PARTS];
	size_t count;
	double slides;      /* share of its way that it slides; NAN: not known here */
	/* What the spacing costs, as bench/faces_error.py measured it. */
	double posts;       /* over the wheel's radius, or over the depth of another body; NAN: the depth is not known here, and so no error */
	bool wheel;         /* which of both it is, and so what the errors are percent of: its load; of another body its own force */
	int error;          /* percent: no body of the bench was further off; at posts coarser than those of the bench it may be more */
	bool beyond;        /* posts are coarser than those of the bench */
	double finer;       /* m: the first halving of the spacing that halves the error; 0: none of the bench does */
	int finer_error;
};
/* Tells by which law the soil acts on the parts of an object, and what a spacing, m, costs. Returns false if the scene's model computes no force. */
bool scene_laws_of(const struct scene *scene, const struct scene_object *object, double spacing, struct scene_laws *out);
/* The same of a shape that a host or a vehicle moves. */
bool scene_laws_of_shape(const struct scene *scene, const struct soil_shape *shape, double spacing, struct scene_laws *out);
/* Returns how much of a level way counts for the slip of a wheel or a belt, m. That is what leads along its heading `yaw`, rad. Where the scene turns it
 * against its way, all of the way counts. */
double scene_slip_way(const struct scene_object *object, double x, double y, double yaw);
/* Returns about how deep the object rests in the ground, m: its sink, or a guess by its load. Pure. */
double scene_sinkage_guess(const struct scene *scene, const struct scene_object *object);
/* Returns true if bodies without a path may come: those of a host, or geoms of vehicles. */
bool scene_moves_bodies(const struct scene *scene);
/* Tell whether geoms of vehicles may carry soil; and whether those or objects may. */
bool scene_vehicles_carry(const struct scene *scene);
/* Returns the damping of a tyre of which none is given, N s/m. It is a twentieth of what is critical for its stiffness and the mass of its load. */
double scene_tyre_damping(const struct soil_tyre_told *told, double gravity);
bool scene_carries(const struct scene *scene);
/* Copies the scene as it is run without a window: the view is left out unless pictures are written. `out` shares the memory of
 * `scene`, so do not destroy `out`. */
void scene_unwatched(const struct scene *scene, struct scene *out);
/* Returns how many pixels of pictures a step draws, as a mean over the drive. A window is not counted. */
double scene_pixels_a_step(const struct scene *scene);
/* Returns true if pictures are drawn as light first, which is exposed then: for images of linear light, and exposures by the frame. */
bool scene_draws_light(const struct scene *scene);
/* Returns true if the camera's frames are drawn a second time: for SCENE_IMAGES_MEASURED, and with view.samples for depth, of one sample. */
bool scene_camera_measures(const struct scene *scene, const struct scene_camera *camera);
bool scene_measures(const struct scene *scene); /* some camera does */
/* Returns true if the colours of this camera agree with its depth (view.truth). `camera` NULL: the view's own pictures. */
bool scene_camera_truth(const struct scene *scene, const struct scene_camera *camera);
/* Returns true if pictures show which soil is where, by the map of soils. Then the soil class of each post must be loaded for
 * all drawn tiles. */
bool scene_draws_classes(const struct scene *scene);
/* Returns true if pictures show the ground as its one soil looks: the soil has a name, and there is no map. */
bool scene_draws_one_soil(const struct scene *scene);
bool scene_covers_by_class(const struct scene *scene); /* returns true if pictures show vegetation that differs between classes of soil */
/* Writes into `text` which setting turns on an effect that the scene uses: "redistribute.model: box",
 * "objects.front_left.load". */
void scene_effect_reason(const struct scene *scene, enum scene_effect effect, char *text, size_t size);

/* Calls `tell` for each setting that has no effect, or no effect that anybody can see. The text is one line, "KEY: WHY; WHAT TO
 * DO". The order is that of the scene. All are certain for ground of any shape, except those of scene_advise_units, which come
 * first. `spacing`: metres between posts of the working level; 0: not known. */
typedef void (*scene_advice_fn)(void *user, const char *text);
void scene_advise(const struct scene *scene, double spacing, scene_advice_fn tell, void *user);
/* Tells that a body is narrower than posts are apart. `across`: m; the rest as in scene_advise_posts_below. */
void scene_advise_narrow(const char *key, double across, size_t others, double spacing, scene_advice_fn tell, void *user);
/* Tells that posts cannot tell the prints of a wheel's bars apart. */
void scene_advise_grousers(const char *key, const struct soil_shape *shape, double slip, size_t others, double spacing, scene_advice_fn tell,
			   void *user);
/* Returns over how many metres the soil bears a wheel or a sphere. `load`: N; 0: `sink` is how deep it is, m. The result is its width or,
 * if less, twice the sinkage over the slope of its rim where it enters the soil. A wheel that hardly sinks enters it so far ahead of its
 * axle. */
double scene_bears_over(const struct scene *scene, const struct soil_shape *shape, double load, double sink);
/* The same of any object of the scene. Returns 0 if it is not known: without load and sink, and for a shape whose attitude changes. */
double scene_object_bears_over(const struct scene *scene, const struct scene_object *object);
/* Tells how far off forces are where `over` metres hold few posts. Tells nothing where they are hardly off. scene_advise does this for
 * the scene's objects. `key`: of the body; `others`: how many are alike. */
void scene_advise_posts_below(const char *key, const struct soil_shape *shape, double over, size_t others, double spacing, scene_advice_fn tell,
			      void *user);
/* Returns by how much at most (a standard deviation) the slip of a vehicle's wheels goes up and down with their place between posts: scene_posts.c.
 * radius: m; speed: m/s, above 0; gravity: m/s2. */
double scene_slip_scatter(double radius, double spacing, double speed, double gravity);
/* Tells of it where it is more than SCENE_SCATTER_TOLD. The rest as in scene_advise_posts_below. */
#define SCENE_SCATTER_TOLD 0.03
void scene_advise_scatter(const char *key, double radius, size_t others, double spacing, double speed, double gravity, scene_advice_fn tell, void *user);
/* What a soil's rebound does to a wheel: scene_rebound.c. */
struct scene_rebound {
	char key[200];           /* of the body */
	int soil;                /* its number in the scene */
	double sinkage, rebound; /* m: below the axle, and what of it springs back behind it */
	double less;             /* 1 - resistance / that in a soil that does not spring back; 0: nothing found */
};
#define SCENE_REBOUND_TOLD 0.2 /* smaller shares are not told */
/* Estimates the rebound below a wheel under `load` N, in each soil whose elastic_stiffness the scene does not give. Replaces *worst where the
 * wheel's resistance is less by more. `key`: of the body. A body that is no wheel changes nothing. */
void scene_rebound_look(const struct scene *scene, const char *key, const struct soil_shape *shape, double load, struct scene_rebound *worst);
/* Tells of *worst, if its share is large enough. scene_advise does it for the scene's objects. */
void scene_rebound_advise(const struct scene *scene, const struct scene_rebound *worst, scene_advice_fn tell, void *user);
/* Calls `tell` for each number that seems to be given in a wrong unit. The text is one line, "FILE:LINE:COLUMN: KEY: WHY; WHAT TO DO".
 * scene_advise calls this first. */
void scene_advise_units(const struct scene *scene, scene_advice_fn tell, void *user);

/* --- scene_mesh_parts.c: meshes that are only looked at --- */

/* The triangles of a mesh file that have one colour. */
struct scene_mesh_part {
	struct soil_mesh *mesh;
	float colour[3]; /* sRGB, 0 .. 1: the diffuse colour of the material */
	bool coloured;   /* false: the file gives it none */
};
#define SCENE_MESH_PARTS 64 /* most parts; triangles of further colours are in the part of the nearest one */
/*
 * Reads a mesh file to be looked at: OBJ with its .mtl, STL, COLLADA (.dae). Axes are the file's own: a COLLADA's up axis is not turned, its unit counts.
 * `scale`: along each axis; if it mirrors, triangles are turned round. The caller frees the parts with
 * scene_mesh_parts_destroy, also after a failure. STATUS_INPUT, with a message that begins with `told`: it cannot be read as a mesh, or has more than a
 * million triangles. Any thread; files are read one at a time.
 */
enum status scene_mesh_parts_load(const char *path, const char *told, const double scale[3], struct scene_mesh_part **parts, size_t *count) FURROW_CHECKED;
void scene_mesh_parts_destroy(struct scene_mesh_part *parts, size_t count); /* parts may be NULL */

#endif
