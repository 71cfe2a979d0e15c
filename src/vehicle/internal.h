/* What the files of vehicle share. Only the world's thread touches it. */
#ifndef FURROW_VEHICLE_INTERNAL_H
#define FURROW_VEHICLE_INTERNAL_H

#include "vehicle_mujoco.h"

#include "vehicle/guard.h"
#include "vehicle/settle.h"
#include "vehicle/vehicle.h"

/* How high the undisturbed ground is below a place, fixed-point units of local metres. It never changes. */
struct vehicle_ground {
	bool known;                 /* it was looked up */
	bool any;                   /* there is ground */
	int64_t x, y, height;
};

/* A geom that touches the ground. */
struct soil_geom {
	int geom;                   /* of the model */
	int dof;                    /* of a wheel: the freedom in which it turns; of a belt that of its sprocket; -1: neither */
	int roll_dof;               /* of a round geom that is no cylinder: the freedom in which it turns as a wheel; -1: it does not (rolls.c) */
	double roll_radius;         /* m */
	bool is_standing;                /* on the ground in the first pose, or rolls, or the scene names it; false: it is a hull (hulls.c) */
	bool aloft;                 /* a hull so high that it can touch nothing: the world has no place of it */
	double sprocket;            /* m: how far its belt runs for each radian of that; below 0: the hinge looks to the right. 0: no belt */
	char *name;                 /* VEHICLE.GEOM, the name of its body in the world */
	struct soil_shape shape;
	struct soil_mesh *mesh;   /* of the shape; owned, until the world's body has it; NULL: none, or the body has it */
	double axes[9];             /* the body's axes forward, left, up as columns, in the geom's axes */
	int32_t number;             /* its body in the world */
	bool carries;               /* soil that comes onto it stays on it */
	double load, load_at[3];    /* of that soil at the step's start: N; m from the body's origin, along local axes */
	struct furrow_state now;     /* where the coupling step ends if the velocity stays as it is at its start */
	struct furrow_state touched; /* up to which its motion has changed the ground */
	struct furrow_belt now_belt, touched_belt; /* its belt then; 0: it has none */
	bool is_touched;
	struct furrow_state from;    /* at the time step's start, as it asked for `contact`, and its belt */
	struct furrow_belt from_belt;
	struct vehicle_ground grounds[2]; /* step.c: below where it last changed the ground, and where its last step ended */
	double mean[3];             /* m/s: slow part of the velocity at the contact; its change is damped (coupling.c) */
	struct furrow_contact contact;  /* linearised at `now` */
	int *chain;                 /* freedoms that move it, from the root on; a belt's hinge too. Owned */
	int chain_count;
	int *places;                /* of their pairs in MuJoCo's inertia M: of the second row two, of the third three ...; -1: none. Owned */
	int hinge_at;               /* place of a belt's hinge in the chain; -1: no belt */
	bool apart;                 /* the belt's hinge is not below or above the geom's body: coupling.c */
	bool lone;                  /* M has no room for pairs of its freedoms: coupling.c */
	double force[6];            /* N, N m about the body's origin: what was applied last */
	double pulled;              /* N m: torque of a belt on its hinge besides that force (coupling.c) */
	double work;                /* J: what it has done on the soil since the start; in the record */
	double share;               /* of the weight, on level ground; NaN: not known (shares.c) */
	double sunk;                /* s: for how long it has been sunk in the drive, without a break */
};

/* Return the freedom in which a geom turns as a wheel does, or that of its belt's sprocket; -1: neither. And how far it rolls for each radian, m. */
static inline int vehicle_turning_dof(const struct soil_geom *geom)
{
	return geom->dof >= 0 ? geom->dof : geom->roll_dof;
}

static inline double vehicle_turning_radius(const struct soil_geom *geom)
{
	return geom->shape.belt ? geom->sprocket : geom->dof >= 0 ? geom->shape.radius : geom->roll_radius;
}

/* Something that is wrong with how a vehicle lies: lies.c. */
struct lie {
	char *geom;                 /* VEHICLE.GEOM; NULL: it is of the whole vehicle, or of the soil geom `of` */
	int number;                 /* of that geom in the model; -1 */
	const struct soil_geom *of; /* the geom that it is about; NULL: none */
	bool printed;               /* in this process */
	/* State, in the record: */
	double since;               /* s: from when on it is so without a break; below 0: it is not so now */
	double time, at[2], depth;  /* s, m, m: from when on it was so when it was told, where; how deep it was at most */
	bool told;
	double bears;               /* N, of LIE_HIGH_CENTRED: what the hull bore lately */
};
enum { LIE_OVERTURNED, LIE_HIGH_CENTRED, LIE_BURIED, LIE_OWN }; /* those of a vehicle itself; then one for each geom that is watched: lies.c */
/* What a path driver's actuators do to the wheels, found when the model is read: steering.c. */
struct steering {
	bool plain;                 /* each steering actuator turns its own wheel, each driving one turns its own: there is no table */
	double middle, base;        /* m: the line about which it turns, ahead of its origin; its wheelbase */
	size_t first, end;          /* rows of the table: */
	double *curvatures;         /* 1/m: of the way, to the left */
	double *lengths;            /* steer_count each: what steering actuators are at then, as MuJoCo has their length */
	double *rates;              /* drive_count each: of driving actuators, for each m/s forward */
	bool *idle;                 /* drive_count: it turns no wheel */
};

/* target.c: a way to a place that a window's host chose. */
#define SENT_POINTS 40
struct sent {
	bool is;
	bool fresh;                 /* the driver has not followed it yet */
	bool turns;                 /* and before it went backward, on its path */
	double points[SENT_POINTS][2]; /* m, local */
	size_t count;
	double speed;               /* m/s, forward */
};

/* What sets the controls: driver.c. */
struct driver {
	int *steer, *drive;         /* actuators that steer, and that drive */
	size_t steer_count, drive_count;
	struct steering steering;
	double (*route)[2];         /* m, local: the scene's path */
	size_t route_count;
	double (*points)[2];        /* what it follows: that, or `sent` */
	size_t point_count;
	struct sent sent, marked;   /* marked: as it was at the checkpoint */
	int *held;                  /* actuators with a constant control, or columns of a table */
	size_t held_count;
	const double *values;       /* SCENE_HOLD: their controls. The scene owns them */
	double *table;              /* SCENE_CONTROLS: rows of t and held_count controls */
	size_t row_count;
	/* State: */
	double at;                  /* segment of the path that it is on */
	double left;                /* m of the path ahead; found anew whenever controls are set */
	double speed;               /* m/s: what it wants now; below 0 backward */
	double sum;                 /* m/s: what its rims go faster than that, so that the vehicle has it */
	double turn;                /* rad/s: the same of its yaw, without steering */
	bool arrived;
};

/* trail.c: points of a vehicle's way, at least `apart` metres from each other. */
struct trail {
	double places[VEHICLE_TRAIL][2], apart; /* m, local */
	size_t count;
};

/* Numbers first .. end - 1. */
struct range {
	int first, end;
};

/* What of a model is one vehicle's own. */
struct owned {
	struct range body, joint, geom, actuator, equality, tendon, text, numeric, sensor; /* without the model's own world */
	struct range qpos, dof, act, ctrl; /* of MuJoCo's arrays of the state and of controls */
	struct range fixed;         /* geoms of the model's own world */
	int geom_number;            /* of its first geom in its own file */
};

static inline size_t range_count(struct range range)
{
	return (size_t)(range.end - range.first);
}

struct contact; /* coupling.h */
struct powertrain; /* powertrain.h */
struct drive; /* drives.h */

struct vehicle {
	const struct scene_vehicle *scene;
	mjModel *model;             /* of all vehicles, and of what `world` has */
	mjData *data;
	struct owned own;           /* what of both is this vehicle's */
	char prefix[24];            /* of names in `model`: names.c */
	bool is_world;              /* no vehicle, but the things of the scene's `world` */
	bool is_urdf;
	mjModel *single;            /* of this vehicle alone: shares.c */
	mjSpec *spec;               /* of this vehicle, until all are put together; NULL after that */
	mjData *posed;              /* the same: in its first pose */
	double checksum[2];         /* of the compiled model, as two whole numbers */
	double gravity[3];          /* m/s2: of the model's own option, in place of which the scene's counts */
	double origin[3];           /* m, local: where MuJoCo's origin is; that of all */
	double shift[3];            /* m: from there to where it starts, in plan */
	int root;                   /* the body whose place is the vehicle's */
	double axes[9];             /* forward, left, up as columns, in the axes of that body */
	int keyframe;               /* of the model: the pose and the controls of the start; -1: the first pose, and no controls */
	struct soil_geom *geoms;
	size_t geom_count, carrying_count, standing_count; /* of them carry soil; stand on the ground */
	struct driver driver;
	int *joints;                /* joints with one number: columns q */
	size_t joint_count;
	double *row_joints;         /* room for a row */
	double *row_actuators;      /* room for a row: controls, forces */
	double largest_step, largest_mass, largest_area; /* bound.c */
	size_t largest_geom;
	/* State between steps; state.c keeps it in the record. */
	double begun;               /* settle.h: how far it is in settling */
	double settle_seconds, calm; /* s: in settling so far; for how long it has been at rest */
	double lift;                /* m: by which it was lifted when it was set down */
	double work, distance;      /* J, m */
	double was[2];              /* m: where it was at the step's start, in MuJoCo's axes */
	double slow;                /* s: for how long it has been slower than `stuck.below`; in settling: when the stage began */
	struct trail trail;         /* of the whole drive; in the record */
	int up;                     /* axis of the root body that looks up in the model's own pose: 0, 1, 2 */
	struct lie *lies;           /* LIE_OWN, and one for each other geom that is watched; in the record */
	size_t lie_count;
	char told_sunk[500];        /* the note that the soil does not carry it, as it was printed; empty: it was not printed */
	const struct soil_geom *cut; /* whose force was cut to what can be summed; NULL: none was */
	double cut_share;           /* the whole force of that by its damping alone */
	double *room;               /* VEHICLE_ROOM nv + 64 numbers; all vehicles share them */
	struct contact *contacts;   /* geom_count + carrying_count: of coupling.c */
	double *columns;            /* of the contacts */
	size_t contact_count, touching; /* in this step of the engine; touching: of them, the first ones, that are no loads */
	double *start_controls;     /* nactuator: what an actuator has until a driver sets it; NaN: as without `start`. NULL: all are NaN */
	double *kept;               /* room for its qpos and qvel, if it does not settle; else NULL: start.c */
	double placed[2], half_length; /* m: where its root body was set down, from `origin`; half its length in plan */
	double *host_controls;      /* what a host has set, of its actuators and then of its powertrain; NaN: the driver sets it */
	struct drive *drives;       /* electric ones */
	size_t drive_count;
	struct powertrain *train;   /* powertrain and brakes; NULL: none */
	struct pushes *pushes;      /* pushes.c; NULL: none */
	double *host_forces;        /* 6 for each body: what a host has set, N, N m */
	bool host_pushes;           /* it has set some */
};

/* A geom that pictures show. */
struct figure {
	size_t vehicle;
	int body, geom;             /* of the model; geom -1: it has none, and its place is on the body */
	double at[3];               /* m, in the body's axes; with a geom it is the geom's */
	double axes[9];             /* the shape's axes forward, left, up as columns, in the axes of the geom or the body */
	struct soil_mesh *mesh;   /* owned; NULL: none, or another's */
};

struct seen_mesh; /* figures.h */
struct senses; /* sensors.c */

struct vehicles {
	const struct scene *scene;  /* the file's, or `divided` */
	struct scene divided;       /* a copy with a shorter time_step */
	struct world *world;        /* NULL: not joined yet */
	mjModel *model;             /* of all, and of what `world` of the scene has */
	mjData *data;
	double origin[3];           /* m, local: where MuJoCo's origin is */
	int engine_steps;           /* in a time step */
	struct vehicle *list;       /* the vehicles as the scene has them; then the things of `world` */
	size_t count, all;          /* vehicles; all: with the things of `world` */
	size_t *order;              /* `all`: by name, and `world` at the end. So the order in the scene changes no bit */
	size_t geom_count;          /* soil geoms of all */
	double *room;               /* merge.c: of all vehicles */
	double *mass;               /* nC: coupling.c */
	bool as_asked;              /* all geoms still are where the time step began: soil_geom.from */
	double *kept;               /* a state of MuJoCo, VEHICLE_KEPT: advance.c */
	int32_t *numbers;           /* room for all soil geoms */
	struct furrow_state *states;
	struct furrow_belt *belts;
	struct furrow_contact *contacts;
	const struct soil_shape **aboard_shapes; /* shapes of the soil geoms that carry */
	size_t carrying_count;
	struct scene_object *drawn; /* what pictures show, in the order of `figures` */
	struct figure *figures;
	struct world_look *looks;   /* of the figures */
	size_t drawn_room, figure_room, look_room;
	char **body_names;          /* VEHICLE.BODY of all bodies of all vehicles, in their order */
	size_t body_count;
	struct seen_mesh *seen;     /* visuals.c: meshes that only pictures show */
	size_t seen_count, seen_room;
	struct world_place *places; /* of the figures */
	struct world_frame *frames; /* the bodies of all models */
	size_t figure_count, frame_count;
	size_t attached;            /* numbers in the record */
	double *record;             /* room for them */
	double row;                 /* number of the next row of vehicles.csv */
	double sensor_row;          /* of sensors.csv */
	struct senses *senses;      /* NULL: nobody reads sensors */
	double stuck_at;
	double settling_begun, settling_told; /* s, by the clock: when settling began, and when it was last told how far it is; 0: not begun */
	double settling_processor;  /* s, of the processor: when settling began */
	struct unrest unrest;       /* settle.c */
};

/* --- load.c --- */
/* Returns a control of the powertrain: powertrain.h. */
double *vehicle_train_control(const struct vehicle *vehicle, size_t control);
/* Return the first control of an actuator or, from the number of actuators on, a control of the powertrain, and its first gear. An actuator may have several of both: a motor by its voltage, a PID by its place and rate. */
static inline double *vehicle_ctrl(const struct vehicle *vehicle, int actuator)
{
	if (actuator >= vehicle->model->nactuator)
		return vehicle_train_control(vehicle, (size_t)(actuator - vehicle->model->nactuator));
	return vehicle->data->ctrl + vehicle->model->actuator_ctrladr[actuator];
}

static inline const double *vehicle_gear(const mjModel *model, int actuator)
{
	return model->actuator_gear + 6 * model->actuator_outadr[actuator];
}

/* Finds where the vehicle's forward, left and up look, as columns, in MuJoCo's axes. */
static inline void vehicle_root_axes(const struct vehicle *vehicle, const mjData *data, double axes[9])
{
	mju_mulMatMat(axes, data->xmat + 9 * vehicle->root, vehicle->axes, 3, 3, 3);
}

#define VEHICLE_WHERE 300
/* Writes where the scene names the vehicle, for a message. */
void vehicle_where(const struct vehicle *vehicle, const struct scene *scene, char where[VEHICLE_WHERE]);

/* --- hangs.c --- */

/* Notes once which joints of limbs nothing holds. Comes after vehicle_find_parts. */
void vehicle_tell_hanging(const struct vehicle *vehicle);

/* --- geoms.c --- */

/* Finds the soil geoms of a model, makes their shapes, and finds those that carry soil. STATUS_INPUT: there is none, one has a shape that cannot
 * touch the ground, or one carries that cannot. */
enum status vehicle_find_geoms(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
void vehicle_free_geoms(struct vehicle *vehicle);
/* Returns true if `name` matches one of the patterns. `none`: the answer if there are no patterns. */
bool vehicle_matches(const struct scene_texts *patterns, const char *name, bool none);
/* Finds the state of a soil geom, and of its belt, as MuJoCo has it now. `belt` may be NULL. */
void vehicle_geom_state(const struct vehicle *vehicle, const struct soil_geom *geom, struct furrow_state *state, struct furrow_belt *belt);
/* Returns the wheel that a hinge turns, or the body whose belt it drives; NULL: it does neither. */
const struct soil_geom *vehicle_driven(const struct vehicle *vehicle, int joint);
/* Finds the place of a geom that is farthest along `direction`. MuJoCo's axes. */
void vehicle_geom_support(const mjModel *model, const mjData *data, int geom, const double direction[3], double place[3]);
/* Returns the height of its lowest place, m, in MuJoCo's axes. */
double vehicle_geom_lowest(const struct vehicle *vehicle, int geom);
/* Makes the shape of a geom that is a sphere, a box, an ellipsoid, a cylinder or a capsule, in its own axes. Returns false if it is none of these. */
bool vehicle_plain_shape(const mjModel *model, int geom, struct soil_shape *out);
/* Returns the soil geom that a geom of the model is; NULL: it is none. */
struct soil_geom *vehicle_soil_geom_of(const struct vehicle *vehicle, int geom);
/* Returns true if the geom belongs to the model's own world, which a scene leaves out. */
bool vehicle_is_fixed(const mjModel *model, int geom);
static inline bool vehicle_is_free(const mjModel *model, int body) /* it has a free joint */
{
	return model->body_jntnum[body] > 0 && model->jnt_type[model->body_jntadr[body]] == mjJNT_FREE;
}

/* --- names.c: names in the model of all vehicles are "N/NAME", where NAME is that of the vehicle's own file --- */
#define VEHICLE_PREFIX 24
void vehicle_prefix(const struct vehicles *vehicles, size_t index, char prefix[VEHICLE_PREFIX]);
/* Finds a part of the vehicle by the name in its file; -1: it has none. */
int vehicle_find_part(const struct vehicle *vehicle, mjtObj kind, const char *name);
/* Returns the name that a part of the model of all vehicles has in the file of its vehicle; NULL: none. */
const char *vehicle_part_name(const mjModel *model, mjtObj kind, int part);
/* Writes the geom's name into `text`: its own, that of its body, or its number. */
void vehicle_geom_name(const struct vehicle *vehicle, int geom, char *text, size_t size);
#define VEHICLE_NAMES 208
/* Lists the names of a kind of parts of the model, from `first` on until before `end`, for a message. "..." at the end means that there are more. */
void vehicle_list_names(const mjModel *model, mjtObj kind, int first, int end, char text[VEHICLE_NAMES]);
/* The same for a model of one vehicle alone, whose names have no prefix. */
void vehicle_list_own_names(const mjModel *model, mjtObj kind, char text[VEHICLE_NAMES]);
/* These functions of MuJoCo take or give names with prefixes, or sum over all vehicles. Using one of them by mistake does not compile: the name in its
 * place says what to use. A file that needs them defines VEHICLE_NAMES_HERE first. */
#ifndef VEHICLE_NAMES_HERE
#undef mj_name2id
#define mj_name2id use_vehicle_find_part
#undef mj_id2name
#define mj_id2name use_vehicle_part_name
#undef mj_getTotalmass
#define mj_getTotalmass use_vehicle_mass
#endif

/* --- merge.c --- */
#define VEHICLE_ROOM 20
#define VEHICLE_KEPT (mjSTATE_FULLPHYSICS | mjSTATE_WARMSTART) /* of MuJoCo's state: what a repeated step begins with */
/* Puts all vehicles into one model, and finds what of it is whose. STATUS_INPUT: MuJoCo cannot put them together. */
enum status vehicle_merge(struct vehicles *vehicles) FURROW_CHECKED;
double vehicle_mass(const struct vehicle *vehicle); /* kg */
/* Returns the vehicle that a body of the model belongs to; NULL: it is the world. */
const struct vehicle *vehicle_of_body(const struct vehicles *vehicles, int body);
/* Finds which vehicle a geom belongs to, also one that its file has in its own world. */
const struct vehicle *vehicle_of_geom(const struct vehicles *vehicles, int geom);

/* --- wheels.c --- */
/* Gives a geom's shape its axes, in the geom's own. */
void vehicle_set_axes(struct soil_geom *out, const double forward[3], const double left[3], const double up[3]);
/* Finds the freedom of the hinge that turns a cylinder about its own axis; -1: there is none. */
int vehicle_cylinder_turns(const struct vehicle *vehicle, int geom);
/* Takes a mesh that is round about a level hinge as a wheel: it rolls without corners, and costs a fraction. Returns false if it is none. */
bool vehicle_make_mesh_wheel(const struct vehicle *vehicle, struct soil_geom *out);

/* --- hulls.c --- */
/* Finds which soil geoms stand on the ground in the first pose; the others are hulls, and aloft at first. */
void vehicle_find_standing(struct vehicle *vehicle);
/* Takes a hull out of the world, or puts it into the world. Its height above the ground decides, at the end of the time step (geom->now). */
enum status vehicle_lift_hull(const struct vehicles *vehicles, const struct vehicle *vehicle, struct soil_geom *geom) FURROW_CHECKED;
/* Gives the space above the lower side of a geom's box at a place of MuJoCo's axes or local ones, lowered by `margin`, m. `mat`: the geom's axes as columns. */
void vehicle_space_of(const struct vehicle *vehicle, int geom, const double place[3], const double mat[9], double margin, struct world_space *space);
struct furrow_contact vehicle_no_contact(const struct vehicles *vehicles); /* of a geom in the air */

/* --- lies.c --- */
/* Lists the geoms that are watched, after vehicle_find_standing. */
enum status vehicle_make_lies(struct vehicle *vehicle) FURROW_CHECKED;
void vehicle_free_lies(struct vehicle *vehicle);
/* Looks how a vehicle lies after its motion in a time step, and tells once what is wrong. */
enum status vehicle_watch_lies(const struct vehicles *vehicles, struct vehicle *vehicle) FURROW_CHECKED;
size_t vehicle_lies_numbers(const struct vehicle *vehicle); /* in the record */
double *vehicle_save_lies(const struct vehicle *vehicle, double *to); /* returns what is behind them */
const double *vehicle_restore_lies(struct vehicle *vehicle, const double *from);
/* Returns true if the vehicle is so now, and was told. `lie`: LIE_OVERTURNED .. LIE_BURIED. */
bool vehicle_lies_so(const struct vehicle *vehicle, int lie);

/* --- rolls.c --- */
/* Finds the freedom in which a round geom that is no cylinder turns as a wheel, and its radius. */
void vehicle_find_roll(const struct vehicle *vehicle, struct soil_geom *geom);
/* Sets slip and slip_velocity of such a geom's contact. */
void vehicle_tell_roll(const struct vehicle *vehicle, struct soil_geom *geom);

/* --- trail.c --- */

/* Adds the vehicle's place, if it is far enough from the last one. */
void vehicle_trail_add(struct vehicle *vehicle);

/* --- meshes.c: triangles in the axes of a geom --- */

/* Makes the triangles of a geom that is a mesh. Free them with vehicle_free_mesh, even after a failure. */
enum status vehicle_make_mesh(const mjModel *model, int geom, struct soil_mesh **out) FURROW_CHECKED;
void vehicle_free_mesh(struct soil_mesh *mesh); /* takes NULL */

/* --- figures.c --- */
enum status vehicle_make_figures(struct vehicles *vehicles, uint64_t effects) FURROW_CHECKED; /* without EFFECT_OBJECTS none: only frames */
/* STATUS_INPUT: a camera is mounted on a body that its vehicle does not have. */
enum status vehicle_check_cameras(const struct vehicles *vehicles) FURROW_CHECKED;
void vehicle_free_figures(struct vehicles *vehicles);
enum status vehicle_record(struct vehicles *vehicles) FURROW_CHECKED; /* ends a step of the world, whose record gets the state of the vehicles */
void vehicle_show(struct vehicles *vehicles); /* brings the places of figures up to date */

/* --- sensors.c --- */
/* Makes what rows of sensors need. STATUS_INPUT: a body that the scene names is not there. Without rows it checks the names alone. */
enum status vehicle_make_senses(struct vehicles *vehicles) FURROW_CHECKED;
void vehicle_free_senses(struct senses *senses); /* takes NULL */
/* Keeps the accelerations of an engine step of `h` seconds. `before`: nv, the velocities at its start. */
void vehicle_feel(const struct vehicles *vehicles, double h, const double *before);

/* --- bound.c --- */

/* Finds the longest step that is stable with the soils of the scene. */
void vehicle_find_bound(struct vehicle *vehicle, const struct scene *scene);
/* Divides the scene's time_step into steps that are stable for all vehicles, told once. STATUS_INPUT: into more than makes sense. */
enum status vehicle_divide_step(struct vehicles *vehicles) FURROW_CHECKED;

/* --- driver.c --- */

/* Finds the driver's actuators, and reads its table. `where`: for messages. */
enum status vehicle_make_driver(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
/* Converts the path to local metres. */
enum status vehicle_place_driver(struct vehicle *vehicle, const struct world *world) FURROW_CHECKED;
void vehicle_free_driver(struct driver *driver);
/* Returns true if the actuator pulls its joint to a place, as legs and arms have it. */
bool vehicle_holds_place(const struct vehicle *vehicle, int actuator);
/* Sets the controls for a time, s. `drives` false: it settles, and wheels get none. */
void vehicle_control(struct vehicle *vehicle, double time, bool drives);

/* --- controls.c --- */
/* Reads the table of controls. */
enum status vehicle_read_controls(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
/* Sets the controls of the table at a time. */
void vehicle_table_control(struct vehicle *vehicle, double time);

/* --- surfaces.c --- */
/* Returns what a geom's surface is of: the last pattern that names it counts. Without one it is rough. */
struct soil_interface vehicle_surface(const struct vehicle *vehicle, const struct soil_geom *geom);
/* STATUS_INPUT: a pattern names no soil geom. */
enum status vehicle_check_surfaces(const struct vehicle *vehicle, const char *where) FURROW_CHECKED;

/* --- axes.c --- */
/* Finds the model's forward, left and up as columns. Returns false if they are x, y and z. */
bool vehicle_scene_axes(const struct scene_vehicle *scene, double axes[9]);
/* Turns the first pose, so that the model looks along x and is upright, as the scene says. */
void vehicle_turn_single(struct vehicle *vehicle); /* the same of its own model, before all are put together */
void vehicle_turn_fixed(struct vehicle *vehicle);
/* Finds forward, left and up in the axes of the root body, which is known by now. */
void vehicle_set_root_axes(struct vehicle *vehicle);
#define IMU_SITE "imu.site" /* of the scene's imu: spec_imu.c */
/* Puts the site of the scene's imu where the scene says: on its body, or on the root body. */
void vehicle_place_imu(struct vehicle *vehicle);

/* --- pushes.c --- */
/* Reads the table of pushes. Free it with vehicle_free_pushes, even after a failure. */
enum status vehicle_make_pushes(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
void vehicle_free_pushes(struct vehicle *vehicle);
/* Sets the forces on bodies for an engine step of `seconds`. drives false: none. */
void vehicle_push_bodies(struct vehicle *vehicle, double time, double seconds, bool drives);
int vehicle_body_by_name(const struct vehicle *vehicle, const char *name); /* -1: it has none */

/* --- steering.c --- */
/* Finds what the driver's actuators do to the wheels. `tell`: a note of each that has no effect. `where`: for messages. Free it with vehicle_free_steering, even after a failure. */
enum status vehicle_measure(struct vehicle *vehicle, const char *where, bool tell) FURROW_CHECKED;
void vehicle_free_steering(struct steering *steering);

/* --- actuators.c --- */
/* Tell what an actuator keeps by itself: a rate, or a place of its length. Neither: it gives a force. */
bool vehicle_keeps_rate(const mjModel *model, int actuator);
bool vehicle_keeps_place(const mjModel *model, int actuator);
/* Set the controls of an actuator. Its length changes at a rate, or goes to a place; or it gives a force, N or N m before gear. */
void vehicle_ask_rate(const struct vehicle *vehicle, int actuator, double rate);
void vehicle_ask_force(const struct vehicle *vehicle, int actuator, double force);
void vehicle_ask_place(const struct vehicle *vehicle, int actuator, double length);

/* --- pursuit.c --- */
/* Sets the controls so that the vehicle follows its path. Once in an engine step. */
void vehicle_pursue(struct vehicle *vehicle, double time);
double vehicle_wheelbase(const struct vehicle *vehicle); /* m, of what its driver steers and drives */

/* --- vehicle.c --- */
/* Adds the soil geoms of a vehicle to the world, as its bodies. Large meshes are thinned to the ground's posts. */
enum status vehicle_add_bodies(struct vehicle *vehicle, struct world *world) FURROW_CHECKED;
/* Tells the world the forces that its rows of objects.csv have. */
enum status vehicle_tell_forces(struct vehicles *vehicles) FURROW_CHECKED;
/* Takes the rows of the time that has gone as told. */
void vehicle_skip_rows(struct vehicles *vehicles);

/* --- coupling.c; coupling_chain.c makes room, coupling_gain.c has the damping --- */

/* Makes room for all soil geoms to touch at once, and finds what moves them. */
enum status vehicle_make_room(struct vehicle *vehicle) FURROW_CHECKED;
/* Begins a step of the engine of `h` seconds, after mj_step1. Sets qfrc_applied to the forces that the soil has if the velocities stay. Adds to
 * the inertia, data->M, how these forces answer a change of the velocities. later: s of the time step after the step. drives false: wheels do
 * not turn. vehicles->mass keeps the inertia as it was. */
void vehicle_couple(struct vehicles *vehicles, double h, double later, bool drives);
/* Damping of a freedom, which the engine's steps take at their end. With the implicit integrators that of motors is, too. */
double vehicle_damping_of(const struct vehicle *vehicle, int dof);
/* Finds the soil's forces at the end of the step. `before`: nv, the velocities at its start. Returns true if some of them cannot be: the soil
 * does not pull, and its shear has a limit. Then qfrc_applied and data->M have these contacts with the forces at that limit, and the step is to be
 * made once more. */
bool vehicle_couple_end(struct vehicles *vehicles, double h, const double *before, bool drives);
/* Finds the soil's forces anew, where the step has ended with other velocities than were foreseen. None gets a limit any more. */
void vehicle_couple_tell(struct vehicles *vehicles, const double *before);
/* Takes the forces of the step as they are: adds what each geom did on the soil to its work, and puts the inertia back. tells false: without
 * the work. */
void vehicle_couple_done(struct vehicles *vehicles, double h, const double *before, bool tells);
/* STATUS_FAILED: since vehicle_ask the force of some geom was cut to what can be summed. */
enum status vehicle_check_summed(const struct vehicles *vehicles) FURROW_CHECKED;

/* Fills `forces`, nv: what the contacts do on the joints in the step that has changed the velocities from `before`. */
void vehicle_couple_forces(const struct vehicles *vehicles, const double *before, double *forces);

/* --- hosted.c --- */
/* Tells what the soil did to a geom in the last step. */
void vehicle_geom_contact(const struct vehicles *vehicles, const struct soil_geom *geom, struct furrow_contact *contact);

/* --- shares.c, tyres.c --- */

/* Finds the shares of one vehicle's soil geoms, as vehicle_find_shares does. */
enum status vehicle_find_own_shares(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
/* Gives its wheels the tyres of the scene. STATUS_INPUT: a pattern names no wheel, or soil_tyre_set refuses a tyre. Without tyres it does nothing. */
enum status vehicle_make_tyres(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
/* lent_tyres.c: gives its wheels the tyres that a line tells. It is changed. NULL: none. STATUS_INPUT: it is not understood, or as above. */
enum status vehicle_lent_tyres(struct vehicle *vehicle, const char *where, char *text, double gravity) FURROW_CHECKED;

/* --- advance.c --- */

/* Makes the steps of the engine of one time step for all vehicles, with the forces linearised at the contacts of their geoms. `rate`: 1/s, slows
 * all motion, and holds it over one place, for settling; 0: not. drives false: wheels do not turn. Runs within a guard. */
void vehicle_advance(struct vehicles *vehicles, double time, double seconds, double rate, bool drives);
/* Finds places and velocities of all bodies from the joints'. The next step of the engine computes the same again. */
void vehicle_find_places(struct vehicles *vehicles);
/* The same, with the inertia: what bound.c and outline.c need of the first pose. */
void vehicle_find_inertia(struct vehicles *vehicles);

/* --- step.c --- */

/* Asks for the contacts of all vehicles, moves them, and sets the bodies that are to change the ground. */
enum status vehicle_move(struct vehicles *vehicles, double rate, bool drives) FURROW_CHECKED;
/* The first part of it: finds what the soil does where the geoms will be at the step's end. STATUS_FAILED: one leaves the terrain. */
enum status vehicle_ask(struct vehicles *vehicles) FURROW_CHECKED;
/* The last part: sets the bodies of the world whose geoms, where they are now, are to change the ground in its next step. */
enum status vehicle_touch(struct vehicles *vehicles) FURROW_CHECKED;
double vehicle_kinetic(const struct vehicle *vehicle); /* J */

/* --- state.c --- */
size_t vehicle_state_numbers(const struct vehicle *vehicle);
void vehicle_save(const struct vehicles *vehicles, double *numbers);
enum status vehicle_restore(struct vehicles *vehicles, const double *numbers) FURROW_CHECKED;

#endif
