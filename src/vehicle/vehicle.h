/*
 * vehicle: vehicles of a scene. MuJoCo computes their motion, the world computes the soil.
 *
 * A vehicle is a model (MJCF or URDF). Some of its geoms touch the ground: the soil geoms. Each becomes a body of the world that
 * a host moves. Every time step asks the world what the soil does to the soil geoms (world_probe), gives these forces to MuJoCo,
 * and moves the bodies. VEHICLES.md has all of it.
 *
 *     vehicle_load -> (world_prepare, world_start, world_start_pages) -> vehicle_join -> (world_begin) -> vehicle_begin -> vehicle_step ...
 *
 * Calls are for the world's thread. A build without MuJoCo refuses every scene that has vehicles.
 */
#ifndef FURROW_VEHICLE_H
#define FURROW_VEHICLE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"
#include "scene/scene.h"
#include "world/world.h"

struct vehicles; /* all vehicles of a scene */

/* Returns what moves vehicles, with its version, "MuJoCo 4.0.0"; NULL: this build has none. Any thread. */
const char *vehicle_engine(void);
int vehicle_engine_number(void); /* the same version as MuJoCo counts it; 0: this build has none */
const void *vehicle_engine_place(void); /* of its mj_version; NULL: it is not loaded */

/* Reads the models of a scene. Changes nothing. *out is NULL if the scene has no vehicles. STATUS_INPUT: a model cannot be read or
 * does not fit the scene, its time_step is far too long, or this build has no MuJoCo. The scene must outlive the vehicles. */
enum status vehicle_load(const struct scene *scene, struct vehicles **out) FURROW_CHECKED;
/* Returns the scene as it is to be driven: `scene`, or a copy with a shorter time_step that is stable for the vehicles. That divides the scene's own.
 * It lives as long as the vehicles. NULL: there are none. */
const struct scene *vehicle_scene(const struct vehicles *vehicles, const struct scene *scene);
void vehicle_destroy(struct vehicles *vehicles); /* takes NULL */
/* Returns how many numbers the vehicles add to the run's record (world_attach). For NULL: 0. */
size_t vehicle_attached(const struct vehicles *vehicles);

/* Returns the shapes of the soil geoms that carry soil, in the order in which vehicle_join adds them; valid as long as the vehicles. *count: how many.
 * `vehicles` may be NULL. */
const struct soil_shape *const *vehicle_aboard_shapes(const struct vehicles *vehicles, size_t *count);

/* Finds the longest stable step again, with the highest elastic stiffness of the scene's rasters. Needs a world that is prepared, or prepared for
 * a plan; without a store no raster is known. STATUS_INPUT: the scene's time_step is longer. NULL: there are no vehicles. */
enum status vehicle_check_rasters(struct vehicles *vehicles, const struct world *world) FURROW_CHECKED;
/* Adds the soil geoms to the world. Call it after world_warm. STATUS_INPUT: as vehicle_check_rasters. */
enum status vehicle_join(struct vehicles *vehicles, struct world *world) FURROW_CHECKED;
/* Sets the vehicles down and lets them settle, or goes on where the resumed run stopped. STATUS_INPUT: one starts outside the
 * terrain or under ground. STATUS_FAILED: its motion diverged. */
enum status vehicle_begin(struct vehicles *vehicles) FURROW_CHECKED;
/* Makes one time step of the vehicles and of the world. STATUS_FAILED: a motion diverged, or a vehicle left the terrain. Then
 * the world is as the last step left it, unless it is torn. The vehicles may have moved on: vehicle_step_back. */
enum status vehicle_step(struct vehicles *vehicles) FURROW_CHECKED;
/* Returns why the drive ends, if the scene asks for it (scene->stop): "overturned", "buried" or "stuck". Each vehicle is so, or at its path's end. NULL: it
 * goes on. */
const char *vehicle_stopped(const struct vehicles *vehicles);

/* Something that is wrong with how a vehicle lies, and was told. */
struct vehicle_lie {
	const char *what;      /* "under_ground", "overturned", "high_centred", "buried" */
	const char *geom;      /* VEHICLE.GEOM; NULL: of no geom. Valid as long as the vehicles */
	double time, at[2];    /* s; m, local: since when, where the geom or the vehicle was */
	double depth;          /* m: the most so far: below the ground, of what is buried or hangs up in it; NaN: of what is overturned */
};
/* Gives the nth of them. Returns false if there are fewer. */
bool vehicle_lie(const struct vehicles *vehicles, size_t vehicle, size_t nth, struct vehicle_lie *lie);

/* Makes what pictures with these effects show of the vehicles, and reads the files of meshes that only pictures need, unless that was done. A scene with a view has it
 * from the start; a host may ask for a picture later. Give the world vehicle_figures again after it. NULL: does nothing. STATUS_MEMORY. */
enum status vehicle_draw(struct vehicles *vehicles, uint64_t effects) FURROW_CHECKED;
/* Returns what pictures show of the vehicles: their models' geoms and bodies. For NULL: nothing. The places in it follow each step. */
struct world_figures vehicle_figures(const struct vehicles *vehicles);

/* What a vehicle's powertrain and brakes do. */
struct vehicle_train {
	bool has_engine, has_brakes;
	double engine_speed;   /* rpm */
	double engine_torque;  /* N m, in the last step of the engine (MuJoCo's) */
	int gear;              /* -1: reverse; 0: none, or it shifts */
	double engine_work, loss, brake_work; /* J since the start: of the engine; what clutch, converter and differentials took; what brakes took */
	double engine_kinetic; /* J */
};

/* An electric drive: a dcmotor of the model. */
struct vehicle_drive {
	const char *name;      /* of the actuator; "" if it has none */
	double torque, speed;  /* N m and rad/s of the motor, before its gear: in the last step of the engine, and now */
	double current, voltage; /* A, V: R i + K speed */
	double taken, recovered; /* J of its battery since the start: electric power above 0, and what came back, both positive */
	double mechanical, heat; /* J: torque times speed; what its resistance took */
};
size_t vehicle_drive_count(const struct vehicles *vehicles, size_t vehicle);
void vehicle_drive(const struct vehicles *vehicles, size_t vehicle, size_t drive, struct vehicle_drive *out);

/* A row of vehicles.csv. */
struct vehicle_row {
	double time;           /* s */
	size_t vehicle;        /* its number */
	double position[3];    /* m, of the origin of its root body */
	double roll, pitch, yaw; /* degrees, as in a path file */
	double velocity[3];    /* m/s */
	double kinetic, work;  /* J: kinetic energy; what its actuators have done since the start */
	struct world_aboard aboard; /* soil that its geoms carry */
	struct vehicle_train train;
	const double *joints;  /* joint_count numbers */
	const double *controls, *forces; /* actuator_count numbers; N or N m before `gear`, in the last step of the engine */
};
/* Returns true if rows of the present time are due. Ask after vehicle_begin and after each step; once it said so, they count as read. */
bool vehicle_rows_due(struct vehicles *vehicles);
/* Gives the row of a vehicle now. Its arrays are valid until the next call. */
void vehicle_row(struct vehicles *vehicles, size_t vehicle, struct vehicle_row *row);

/* Returns the soil aboard a soil geom, 0 .. geom_count - 1. *carries: whether it may have any. */
struct world_aboard vehicle_geom_aboard(const struct vehicles *vehicles, size_t vehicle, size_t geom, bool *carries);
/* Computes the struck capacity of the bucket of a soil geom, m3: of all geoms that carry on its body of the model. That body's z axis is up.
 * STATUS_MEMORY. */
enum status vehicle_geom_capacity(const struct vehicles *vehicles, size_t vehicle, size_t geom, double *capacity) FURROW_CHECKED;

/* Facts about a vehicle. Those above `settled` are known once it is loaded. */
struct vehicle_info {
	const char *name;
	double mass;           /* kg */
	double gravity;        /* m/s2, downward: the scene's */
	double own_gravity[3]; /* m/s2: in its model's file; not used */
	size_t geom_count;     /* soil geoms, */
	size_t standing_count; /* of them those that stand on the ground in the first pose */
	size_t joint_count, actuator_count;  /* columns of its rows; joints with one number each */
	double largest_step;   /* s: the longest time_step that is allowed */
	const char *largest_geom; /* soil geom that allows no more, */
	double largest_mass, largest_area; /* kg, m2: its effective mass, and the area by which its stiffness was estimated */
	int engine_steps;      /* steps of the engine in a time step */
	bool settled;
	double settle_seconds; /* s of simulated time before the start */
	double distance;       /* m in plan */
	double reach;          /* m in plan, from its place to the farthest part of a soil geom; 0 before it is joined to a world */
	double kinetic, work;  /* J */
	struct vehicle_train train;
	bool arrived;          /* at the end of its path */
	double speed, left;    /* m/s in plan, now; m of its path ahead, when its controls were last set */
	const char *told_sunk; /* the note that the soil does not carry it; NULL: none was printed */
	bool stuck;
	double stuck_at;       /* s; while stuck */
	const char *deepest;   /* its soil geom that is deepest in the soil now, */
	double depth;          /* m: below the undisturbed surface; 0: none touches */
	double slip;           /* mean of its wheels and belts now; NaN: none turns */
};
size_t vehicle_count(const struct vehicles *vehicles); /* 0 for NULL */
void vehicle_info(const struct vehicles *vehicles, size_t vehicle, struct vehicle_info *info);

/* Fills `places` with points of the vehicle's way in the whole drive, and with where it is now, in local metres. Returns their number,
 * at most VEHICLE_TRAIL + 1; 0 before its first step. */
#define VEHICLE_TRAIL 128
size_t vehicle_trail(const struct vehicles *vehicles, size_t vehicle, double (*places)[2]);

/* --- of a host's world: hosted.c --- */

/* Where its root body is, and how it moves. */
void vehicle_state(const struct vehicles *vehicles, size_t vehicle, struct furrow_state *state);
/* joint_count values in rad or m, and rates in rad/s or m/s. Either may be NULL. */
void vehicle_joints(const struct vehicles *vehicles, size_t vehicle, double *values, double *rates);
/* actuator_count controls, and forces as in a row. Either may be NULL. */
void vehicle_actuators(const struct vehicles *vehicles, size_t vehicle, double *controls, double *forces);
/* Sets the controls of the steps from now on, actuator_count numbers. NaN: the scene's driver sets it. */
void vehicle_set_controls(struct vehicles *vehicles, size_t vehicle, const double *controls);
/* Sends a vehicle that follows a path to a place instead, m, local. From the next step its driver goes there, forward, at the path's speed. Returns false if it
 * has no path. A drive cannot be resumed after it. */
bool vehicle_send(struct vehicles *vehicles, size_t vehicle, double x, double y);
/* Gives the place to which it was sent. Returns false if it was not. */
bool vehicle_target(const struct vehicles *vehicles, size_t vehicle, double place[2]);
/* Keeps these places with a checkpoint of the world; and takes them back, before vehicle_rollback. `vehicles` may be NULL. */
void vehicle_mark_ways(struct vehicles *vehicles);
void vehicle_mark_ways_back(struct vehicles *vehicles);
/* Gives slip (NaN: it does not turn) and sinkage, m, of a soil geom now. Returns false if it is no wheel, belt or round foot that rolls. */
bool vehicle_wheel(const struct vehicles *vehicles, size_t vehicle, size_t geom, const char **name, double *slip, double *sinkage);
/* Returns how many bodies its model has, and the name of one, "" if it has none. */
size_t vehicle_bodies(const struct vehicles *vehicles, size_t vehicle);
const char *vehicle_model_body_name(const struct vehicles *vehicles, size_t vehicle, size_t body);
/* Sets the force from outside on a body at its centre of mass, for the steps from now on. N, N m along east, north, up. */
void vehicle_set_force(struct vehicles *vehicles, size_t vehicle, size_t body, const double force[3], const double torque[3]);
/* Returns the name of the soil geom that is this body of the world; NULL: the body is no vehicle's. `vehicles` may be NULL. */
const char *vehicle_body_name(const struct vehicles *vehicles, int32_t number);
/* Tells where such a body is, and what the soil did to it in the last step. The contact is unknown after a rollback and in a resumed run, until
 * a step. Returns false if the body is no vehicle's. `vehicles` may be NULL. */
bool vehicle_body(const struct vehicles *vehicles, int32_t number, struct furrow_state *state, struct furrow_contact *contact);
/* Goes back to the world's last whole step, after vehicle_step failed and left world_is_torn(world) false. Contacts are unknown until the next step. */
enum status vehicle_step_back(struct vehicles *vehicles) FURROW_CHECKED;
/* Goes back to the checkpoint, after world_rollback. Controls that the host set stay. */
enum status vehicle_rollback(struct vehicles *vehicles) FURROW_CHECKED;

/* A soil geom, 0 .. geom_count - 1. */
struct vehicle_geom {
	const char *name;          /* VEHICLE.GEOM, the name of its body in the world */
	const struct soil_shape *shape;
	double share;              /* of the weight that it bears on level ground, in the first pose: see vehicle_find_shares */
	bool hull;                 /* it does not touch level ground in the first pose, and does not roll */
	double contacts;           /* that change the ground, for each metre on level ground: a wheel rolls without slip, others slide */
};
/* `spacing`: m between posts. */
void vehicle_geom(const struct vehicles *vehicles, size_t vehicle, size_t geom, double spacing, struct vehicle_geom *out);

/* Finds the share of each soil geom; before this call all are 0. All shares of a model that does not stand are NaN. NULL: there are no vehicles. */
enum status vehicle_find_shares(struct vehicles *vehicles) FURROW_CHECKED;
/* Returns over how many metres the soil bears a soil geom, if each bears the same share of the weight. 0: it is neither a wheel nor a sphere. */
double vehicle_bears_over(const struct vehicles *vehicles, size_t vehicle, size_t number, const struct scene *scene);
/* Calls `tell` for a model's gravity that does not count since the scene gives none. It also calls it for grousers, and for a damping of the
 * soil that the scene does not give. It tells a rebound that does much to a wheel's resistance. As scene_advise does for objects, it
 * tells wheels and round feet with so few posts below them that forces are off. Each soil geom is taken to bear the same share of the weight.
 * The world is prepared, or prepared for a plan. NULL: there are no vehicles. */
void vehicle_advise(const struct vehicles *vehicles, const struct world *world, scene_advice_fn tell, void *user);

const char *vehicle_joint_name(const struct vehicles *vehicles, size_t vehicle, size_t joint);
const char *vehicle_actuator_name(const struct vehicles *vehicles, size_t vehicle, size_t actuator);
/* Returns which key of `driver` sets the actuator: "steer", "drive", "controls" or "hold"; NULL: none, its control is 0. */
const char *vehicle_actuator_key(const struct vehicles *vehicles, size_t vehicle, size_t actuator);

/* --- what a model has: parts.c. Valid as long as the vehicles, in the model's first pose --- */

/* What a joint is for, as far as its place and its name tell. */
enum vehicle_role {
	VEHICLE_ROLE_HOLDS,   /* neither of these: of a leg, an arm, a suspension */
	VEHICLE_ROLE_DRIVES,  /* turns a wheel, or the sprocket of a belt */
	VEHICLE_ROLE_STEERS,  /* upright, above wheels */
	VEHICLE_ROLE_FOLLOWS, /* of a castor, or of a wheel that nothing drives */
};
struct vehicle_joint {
	const char *name;
	bool slides;             /* false: a hinge */
	bool limited;
	double low, high;        /* rad, m; infinite: no limit */
	double value;            /* rad, m */
	double axis[3], at[3];   /* in the model's axes; m */
	const char *actuator;    /* NULL: none moves it alone */
	const char *wheel;       /* its geom on the ground that turns with it as a wheel; NULL: none */
	double radius;           /* m, of that */
	enum vehicle_role role;
};
/* `joint`: 0 .. joint_count - 1. */
void vehicle_part_joint(const struct vehicles *vehicles, size_t vehicle, size_t joint, struct vehicle_joint *out);
struct vehicle_actuator {
	const char *name, *joint; /* joint: the one that it moves; NULL: it moves something else */
	const char *keeps;        /* "place", "rate", "force": what its control asks for */
	bool limited;
	double low, high;         /* of its control; infinite: no limit */
};
/* `actuator`: 0 .. actuator_count - 1. */
void vehicle_part_actuator(const struct vehicles *vehicles, size_t vehicle, size_t actuator, struct vehicle_actuator *out);
/* Returns the name of a keyframe, "" for one without; NULL: there are not so many. */
const char *vehicle_part_keyframe(const struct vehicles *vehicles, size_t vehicle, size_t keyframe);
struct vehicle_size {
	double low[3], high[3];   /* m: what its soil geoms reach, in the model's axes */
	double timestep;          /* s: of the model, after the scene's time_step has divided it */
	size_t bodies;
	bool free;                /* its root moves freely */
	const char *root;         /* name of that body */
};
void vehicle_part_size(const struct vehicles *vehicles, size_t vehicle, struct vehicle_size *out);

/* A wheel of a vehicle. x and y: m from the centre of gravity, forward and to the left, in the model's first pose. */
struct vehicle_wheel {
	double x, y, radius, width;
	bool driven;
	double torque_most;    /* N m that its actuators give; INFINITY: not limited */
};
#define VEHICLE_WHEELS_MOST 32
/* What of a vehicle decides where it can drive. */
struct vehicle_outline {
	char name[64];
	double mass;           /* kg */
	double height;         /* m: of the centre of gravity above the lowest part that touches the ground */
	double clearance;      /* m: of the lowest part that does not touch the ground; INFINITY: there is none */
	struct vehicle_wheel wheels[VEHICLE_WHEELS_MOST];
	size_t wheel_count;
};
/* Loads the scene's models and finds the outline of one. STATUS_INPUT: as vehicle_load, or it has no such vehicle, or that touches the
 * ground with more than wheels. */
enum status vehicle_outline(const struct scene *scene, size_t vehicle, struct vehicle_outline *out) FURROW_CHECKED;

/*
 * --- a model that a host lends: lent.c ---
 *
 * A host has a model and a loop of its own, and MuJoCo's functions of its own version. It gives the world's forces to its own step:
 *
 *     vehicle_lent_begin -> (its step -> vehicle_lent_limit) ... -> vehicle_lent_end -> vehicle_lent_touch -> (the world's step)
 */
struct vehicle_lent;

/* An array of a host's model or data, by the name of its member: "model.geom_type", "data.qvel". It stays where it is as long as the lent model. */
struct vehicle_array {
	const char *name;
	void *at;
};

struct vehicle_lending {
	const char *name;       /* for messages, and for names of bodies: NAME.GEOM */
	/* The host's mjModel and mjData, of the version that vehicle_engine names, in a pose whose places and inertia are computed. NULL: `arrays` have what is
	 * needed of them, of a host with another version. */
	const void *model, *data;
	const struct vehicle_array *arrays;
	size_t array_count;
	const char *geoms;      /* patterns of the geoms that touch the ground, between spaces; NULL: all that collide */
	double origin[3];       /* m, local: where the host's origin is */
	const char *carry;      /* patterns of those that carry soil; NULL: none */
	const char *tyres;      /* as furrow_mujoco_open has them; NULL: wheels are rigid */
};

/* Finds the soil geoms of the model and adds them to the world as bodies. Free *out with vehicle_lent_destroy; the bodies stay. STATUS_INPUT: no geom touches the
 * ground, or an array is missing. */
enum status vehicle_lend(const struct vehicle_lending *lending, struct world *world, struct vehicle_lent **out) FURROW_CHECKED;
void vehicle_lent_destroy(struct vehicle_lent *lent); /* takes NULL */
/* Takes its bodies out of the world, which must not be torn. A rollback may bring them back. */
enum status vehicle_lent_remove(struct vehicle_lent *lent) FURROW_CHECKED;
bool vehicle_lent_takes(const struct vehicle_lent *lent, const void *data); /* `data` is given, or the arrays are there */
bool vehicle_lent_begun(const struct vehicle_lent *lent); /* a step has begun, and has not ended */
/* Begins the host's step of `seconds`: asks the world what the soil does. Fills `forces`, nv: of the soil on the joints, if the velocities stay. Adds to
 * the inertia data->M how these forces answer a change. `data`: as in vehicle_lending; NULL: the arrays. The place where each geom is must be computed.
 * again: the same step once more, from another state in it, as RK4 has. */
enum status vehicle_lent_begin(struct vehicle_lent *lent, const void *data, double seconds, bool again, double *forces) FURROW_CHECKED;
/* Finds the forces at the step's end, with the velocities qvel, nv. Returns true if some reach a limit: then `forces` and the inertia are new, and the step
 * is to be made once more. */
bool vehicle_lent_limit(struct vehicle_lent *lent, const double *qvel, double *forces);
/* Fills `forces`, nv: what the soil does in the step that ends with qvel. With them alone, and its own inertia, the host's step ends so, too. */
void vehicle_lent_forces(struct vehicle_lent *lent, const double *qvel, double *forces);
/* Ends the host's step: what it did, and the inertia as it was. qvel: nv, at its end. */
void vehicle_lent_end(struct vehicle_lent *lent, const double *qvel);
/* Sets the world's bodies to where the geoms are now, for the world's step. Does nothing unless a step has ended since. A geom that the host put elsewhere
 * touches nothing on its way. *moved: the world is to make its step. */
enum status vehicle_lent_touch(struct vehicle_lent *lent, const void *data, bool *moved) FURROW_CHECKED;
/* After a rollback of the world: nothing is known of steps before. */
void vehicle_lent_forget(struct vehicle_lent *lent);
bool vehicle_lent_ended(const struct vehicle_lent *lent); /* a step has ended that the ground does not know yet */
double vehicle_lent_seconds(const struct vehicle_lent *lent); /* of the last step */
size_t vehicle_lent_count(const struct vehicle_lent *lent);
/* Tells of a soil geom, 0 .. count - 1, in the last step. Any of the pointers may be NULL. Returns its number in the host's model. */
int vehicle_lent_geom(const struct vehicle_lent *lent, size_t index, const char **name, struct furrow_state *state, struct furrow_contact *contact);
/* --- sensors.c: the <sensor>s of the models, and the scene's `imu` --- */

/* A sensor. Texts are valid as long as the vehicles. */
struct vehicle_sensor {
	char name[160];        /* as its model has it; without one TYPE_N */
	const char *type;      /* as MJCF names it: "accelerometer" */
	const char *unit;      /* of its numbers; "": none, or it depends on the model */
	size_t size;           /* numbers of a row */
	bool turns;            /* they are a quaternion w, x, y, z */
	bool later;            /* of forces and accelerations: means of MuJoCo's last step before the row. Other numbers are of the row's time */
	bool known;            /* false: it has no numbers, since it does not know the terrain */
	const char *kind;      /* "site", "body", "joint", ...: what it is on; "": nothing */
	char on[160];          /* name of that */
	char reference[160];   /* name of the frame along whose axes its vectors are; "": its own, "map": the world's, "-": it has no vector */
	const char *body;      /* whose motion its place has; NULL: it has no place */
	bool is_fixed;         /* to the root body */
	double at[3], axes[9]; /* its place and axes forward, left, up as columns: in the axes of the vehicle if it is fixed; otherwise in those of `body` */
	double noise, cutoff;  /* standard deviation that was added, and MJCF's cutoff; 0: none */
};
size_t vehicle_sensor_count(const struct vehicles *vehicles, size_t vehicle);
void vehicle_sensor(const struct vehicles *vehicles, size_t vehicle, size_t sensor, struct vehicle_sensor *out);
/* As vehicle_rows_due, for rows of sensors. */
bool vehicle_sensors_due(struct vehicles *vehicles);
/* Computes what all sensors of all vehicles measure now. It changes no result. STATUS_FAILED: MuJoCo reports an error. */
enum status vehicle_sense(struct vehicles *vehicles) FURROW_CHECKED;
/* Returns the numbers of a sensor that the last vehicle_sense found. NaN: it is not known yet. */
const double *vehicle_sensed(const struct vehicles *vehicles, size_t vehicle, size_t sensor);

/* A ray over bodies. Lengths in m, places local, directions of length 1. */
struct vehicle_ray {
	double origin[3], way[3];
	double distance;       /* to the first geom of a vehicle or of the scene's `world`; INFINITY: it meets none */
	double normal[3];      /* of that geom's surface there */
};
/* Finds where rays meet geoms. Those of one body do not count, on which the rays begin: `body` of `vehicle`; NULL: its root
 * body. vehicle SIZE_MAX: all count. Taken-away floors never do. `vehicles` may be NULL. */
enum status vehicle_rays(struct vehicles *vehicles, size_t vehicle, const char *body, struct vehicle_ray *rays, size_t count) FURROW_CHECKED;
/* Gives the place and the axes (as columns) of a body of a vehicle. NULL: its root body, and forward, left, up. Of another body the axes are the model's. */
void vehicle_frame(const struct vehicles *vehicles, size_t vehicle, const char *body, double at[3], double axes[9]);

#endif
