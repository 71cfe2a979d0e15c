/* What the files of vehicle share. Only the world's thread touches it. */
#ifndef FURROW_VEHICLE_INTERNAL_H
#define FURROW_VEHICLE_INTERNAL_H

#include "vehicle_mujoco.h"

#include "vehicle/guard.h"
#include "vehicle/vehicle.h"

/* A geom that touches the ground. */
struct soil_geom {
	int geom;                   /* of the model */
	int dof;                    /* of a wheel: the freedom in which it turns; of a belt that of its sprocket; -1: neither */
	int roll_dof;               /* of a round geom that is no cylinder: the freedom in which it turns as a wheel; -1: it does not (rolls.c) */
	double roll_radius;         /* m */
	bool stands;                /* on the ground in the first pose, or rolls, or the scene names it; false: it is a hull (hulls.c) */
	bool aloft;                 /* a hull so high that it can touch nothing: the world has no place of it */
	double sprocket;            /* m: how far its belt runs for each radian of that; below 0: the hinge looks to the right. 0: no belt */
	char *name;                 /* VEHICLE.GEOM, the name of its body in the world */
	struct soil_shape shape;
	struct soil_mesh *mesh;   /* of the shape; owned; NULL: none */
	double axes[9];             /* the body's axes forward, left, up as columns, in the geom's axes */
	int32_t number;             /* its body in the world */
	bool carries;               /* soil that comes onto it stays on it */
	double load, load_at[3];    /* of that soil at the step's start: N; m from the body's origin, along local axes */
	struct furrow_state now;     /* where the coupling step ends if the velocity stays as it is at its start */
	struct furrow_state touched; /* up to which its motion has changed the ground */
	struct furrow_belt now_belt, touched_belt; /* its belt then; 0: it has none */
	bool is_touched;
	double mean[3];             /* m/s: slow part of the velocity at the contact; its change is damped (coupling.c) */
	struct furrow_contact contact;  /* linearised at `now` */
	double armature;            /* kg m2: what the model gives the dof, which several geoms may share; its brake puts another number there */
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
};
enum { LIE_OVERTURNED, LIE_HIGH_CENTRED, LIE_BURIED, LIE_OWN }; /* those of a vehicle itself; then one for each geom that does not press */

/* What sets the controls: driver.c. */
struct driver {
	int *steer, *drive;         /* actuators that steer, and that drive */
	size_t steer_count, drive_count;
	struct steering steering;
	double (*points)[2];        /* m, local: the path */
	size_t point_count;
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
	struct range body, joint, geom, actuator; /* without the model's world, but with geoms of it */
	struct range qpos, dof, act, ctrl; /* of MuJoCo's arrays of the state and of controls */
};

static inline size_t range_count(struct range range)
{
	return (size_t)(range.end - range.first);
}

struct contact; /* coupling.c */

struct vehicle {
	const struct scene_vehicle *scene;
	mjModel *model;
	mjData *data;
	struct owned own;
	double checksum[2];         /* of the compiled model, as two whole numbers */
	double gravity[3];          /* m/s2: of the model's own option, in place of which the scene's counts */
	double origin[3];           /* m, local: where MuJoCo's origin is */
	int root;                   /* the body whose place is the vehicle's */
	double axes[9];             /* forward, left, up as columns, in the axes of that body */
	int keyframe;               /* of the model: the pose and the controls of the start; -1: the first pose, and no controls */
	int engine_steps;           /* in a time step */
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
	double slow;                /* s: for how long it has been slower than `stuck.below`; in settling: when the stage began */
	struct trail trail;         /* of the whole drive; in the record */
	int up;                     /* axis of the root body that looks up in the model's own pose: 0, 1, 2 */
	struct lie *lies;           /* LIE_OWN, and one for each geom that does not press; in the record */
	size_t lie_count;
	char told_sunk[500];        /* the note that the soil does not carry it, as it was printed; empty: it was not printed */
	double *room;               /* numbers for coupling.c */
	struct contact *contacts;   /* geom_count + carrying_count: room for coupling.c */
	double *pushed;             /* nv: forces of other vehicles in this time step */
	double *start_controls;     /* nactuator: what an actuator has until a driver sets it; NaN: as without `start`. NULL: all are NaN */
	double *kept;               /* room for its qpos and qvel, if it does not settle; else NULL: start.c */
	double placed[2], half_length; /* m: where its root body was set down, from `origin`; half its length in plan */
	double *host_controls;      /* nactuator: what a host has set; NaN: the driver sets it */
};

/* A geom that pictures show. */
struct figure {
	size_t vehicle;
	int body, geom;             /* of the model; geom -1: it has none, and its place is on the body */
	double at[3];               /* m, in the body's axes; with a geom it is the geom's */
	double axes[9];             /* the shape's axes forward, left, up as columns, in the axes of the geom or the body */
	struct soil_mesh *mesh;   /* owned; NULL: none, or another's */
};

struct between;
struct seen_mesh; /* figures.h */

struct vehicles {
	const struct scene *scene;  /* the file's, or `divided` */
	struct scene divided;       /* a copy with a shorter time_step */
	struct world *world;        /* NULL: not joined yet */
	struct vehicle *list;
	size_t count, geom_count;   /* geom_count: soil geoms of all vehicles */
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
	struct between *between;    /* between.h; NULL: one vehicle only */
	double stuck_at;
	double settling_told;       /* s, by the clock: when it was last told how far settling is; 0: not begun */
};

/* --- load.c --- */
/* Return the first control of an actuator, and its first gear. An actuator may have several of both: a motor by its voltage, a PID by its place and rate. */
static inline double *vehicle_ctrl(const struct vehicle *vehicle, int actuator)
{
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
/* Returns true if the geom belongs to the model's own world, which a scene leaves out. */
bool vehicle_is_fixed(const mjModel *model, int geom);
/* Writes the geom's name into `text`: its own, that of its body, or its number. */
void vehicle_geom_name(const mjModel *model, int geom, char *text, size_t size);
#define VEHICLE_NAMES 208
/* Lists the names of a kind of parts of the model, from `first` on until before `end`, for a message. "..." at the end means that there are more. */
void vehicle_list_names(const mjModel *model, mjtObj kind, int first, int end, char text[VEHICLE_NAMES]);

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
/* Takes a hull out of the world, or puts it into it, by how high it will be above the ground at the end of the time step: geom->now. */
enum status vehicle_lift_hull(const struct vehicles *vehicles, const struct vehicle *vehicle, struct soil_geom *geom) FURROW_CHECKED;
/* Gives the space above the lower side of a geom's box at a place of MuJoCo's axes or local ones, lowered by `margin`, m. `mat`: the geom's axes as columns. */
void vehicle_space_of(const struct vehicle *vehicle, int geom, const double place[3], const double mat[9], double margin, struct world_space *space);
struct furrow_contact vehicle_no_contact(const struct vehicles *vehicles); /* of a geom in the air */

/* --- lies.c --- */
/* Lists the geoms that do not press the ground and are to lie above it, after vehicle_find_standing. */
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

/* Makes triangles of a geom of the model: its mesh, or a cylinder, a capsule or an ellipsoid. Free it with vehicle_free_mesh, even after
 * a failure. */
enum status vehicle_make_mesh(const mjModel *model, int geom, struct soil_mesh **out) FURROW_CHECKED;
void vehicle_free_mesh(struct soil_mesh *mesh); /* takes NULL */

/* --- figures.c --- */
enum status vehicle_make_figures(struct vehicles *vehicles, uint64_t effects) FURROW_CHECKED; /* without EFFECT_OBJECTS none: only frames */
/* STATUS_INPUT: a camera is mounted on a body that its vehicle does not have. */
enum status vehicle_check_cameras(const struct vehicles *vehicles) FURROW_CHECKED;
void vehicle_free_figures(struct vehicles *vehicles);
enum status vehicle_record(struct vehicles *vehicles) FURROW_CHECKED; /* ends a step of the world, whose record gets the state of the vehicles */
void vehicle_show(struct vehicles *vehicles); /* brings the places of figures up to date */

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

/* --- steering.c --- */
/* Finds what the driver's actuators do to the wheels. `tell`: a note of each that has no effect. `where`: for messages. Free it with vehicle_free_steering, even after a failure. */
enum status vehicle_measure(struct vehicle *vehicle, const char *where, bool tell) FURROW_CHECKED;
void vehicle_free_steering(struct steering *steering);

/* --- actuators.c --- */
/* Tell what an actuator keeps by itself: a rate, or a place of its length. Neither: it gives a force. */
bool vehicle_keeps_rate(const mjModel *model, int actuator);
bool vehicle_keeps_place(const mjModel *model, int actuator);
/* Set the controls of an actuator, so that its length changes at a rate, gives a force (N, N m before gear), or goes to a place. */
void vehicle_ask_rate(const struct vehicle *vehicle, int actuator, double rate);
void vehicle_ask_force(const struct vehicle *vehicle, int actuator, double force);
void vehicle_ask_place(const struct vehicle *vehicle, int actuator, double length);

/* --- pursuit.c --- */
/* Sets the controls so that the vehicle follows its path. Once in an engine step. */
void vehicle_pursue(struct vehicle *vehicle, double time);

/* --- vehicle.c --- */
/* Takes the rows of the time that has gone as told. */
void vehicle_skip_rows(struct vehicles *vehicles);

/* --- coupling.c --- */

/* Makes room for all soil geoms to touch at once. */
enum status vehicle_make_room(struct vehicle *vehicle) FURROW_CHECKED;
/* Adds the soil's forces to qfrc_applied, for a step of the engine of `h` seconds. later: s of the time step after it. */
void vehicle_couple(struct vehicle *vehicle, double h, double later);
size_t vehicle_coupling_room(const struct vehicle *vehicle); /* numbers in vehicle->room */

/* Adds to each geom's work what it did on the soil in the engine's step of `h` seconds that has just ended. `before`: nv, the velocities at
 * that step's start. The Jacobians are those of its start, as the forces are. */
void vehicle_couple_work(struct vehicle *vehicle, double h, const double *before);

/* Finds how a prepared vehicle would move until `seconds` from now, without other vehicles. `inertia`: nv x nv, with what joints and soil
 * resist in that time, factored. `velocity`: nv, at the end. Returns false if the inertia has no inverse. Runs within a guard. */
bool vehicle_find_response(struct vehicle *vehicle, double seconds, double *inertia, double *velocity);

/* --- advance.c --- */

/* Begins the first step of the engine of one time step: finds places, velocities and all forces but the soil's and those of other
 * vehicles. drives false: wheels do not turn. Runs within a guard. */
void vehicle_prepare(struct vehicle *vehicle, double time, bool drives);
/* Makes the steps of the engine of one time step, after vehicle_prepare, with the forces linearised at the contacts of its geoms.
 * `rate`: 1/s, slows all motion, and holds it over one place, for settling; 0: not. drives false: wheels do not turn. Runs within a
 * guard. */
void vehicle_advance(struct vehicle *vehicle, double time, double seconds, double rate, bool drives);
/* Finds places and velocities of all bodies from the joints'. The next step of the engine computes the same again. */
void vehicle_find_places(struct vehicle *vehicle);

/* --- step.c --- */

/* Asks for the contacts of all vehicles, moves them, and sets the bodies that are to change the ground. */
enum status vehicle_move(struct vehicles *vehicles, double rate, bool drives) FURROW_CHECKED;
double vehicle_kinetic(const struct vehicle *vehicle); /* J */

/* --- state.c --- */
size_t vehicle_state_numbers(const struct vehicle *vehicle);
void vehicle_save(const struct vehicles *vehicles, double *numbers);
enum status vehicle_restore(struct vehicles *vehicles, const double *numbers) FURROW_CHECKED;

#endif
