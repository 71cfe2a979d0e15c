/*
 * world/body.h, a part of world.h: the bodies of a world, what the soil does to them, and how a host moves its own. A host is a program that calls the
 * library, or a vehicle.
 */
#ifndef FURROW_WORLD_BODY_H
#define FURROW_WORLD_BODY_H

#include "api/furrow.h"
#include "deform/deform.h"
#include "motion/motion.h"
#include "scene/scene.h"

struct event;
struct world;

/* The force of the soil on a body, when it was last computed. world_no_force: no force. */
struct world_force {
	double force[3], moment[3]; /* N, N m */
	double sinkage, area;       /* m below the base; m2 */
	double residual, pull;      /* N: struct deform_forces */
	double work;                /* J: work on the soil since the start, of a vehicle's body or of one that carries soil along its path; else 0 */
	double slip_velocity;       /* m/s, of a vehicle's body: speed of its rim or belt less that along the ground; else 0 */
	int64_t z;                  /* 2^-20 m */
	enum deform_state state;
};

enum body_kind {
	BODY_PATH,    /* it follows its path */
	BODY_HOST,    /* a host sets its states */
	BODY_VEHICLE, /* a soil geom of a vehicle, which sets its states and computes its forces with world_probe (world_body_of_vehicle) */
	BODY_DROPPED  /* a window sets it down once */
};

/* What only a body of a host or a vehicle has: hosts.c. */
struct body_hosted {
	struct scene_object *owned;   /* NULL: the scene owns the object */
	bool placed, removed;
	bool fresh;                   /* placed since the last step, so there is no motion from an earlier pose */
	bool has_next;
	struct furrow_state now, next; /* now: after the last step. next: after the next step, if has_next */
	struct furrow_belt belt;      /* as world_belts_set told it; of a vehicle's body that of `now` */
	struct furrow_belt next_belt; /* of a vehicle's body: that of `next` */
	bool belt_told;               /* world_belts_set was called for this body */
	bool posed_linear, posed_angular; /* rates.c: the velocities in `now` are those of the poses */
	bool unposed;                 /* rates.c: the host leaves the turns of a round body out of its poses */
	bool rates_told;              /* a note told what is wrong with its velocities */
	int rates_far;                /* for so many steps on end, velocities and poses differed by far */
	double since;                 /* s: time of its motion since `last`; of a vehicle's body the time of the last contact */
	double turned;                /* rad about a wheel's axle, m that its belt ran, since `last` */
	double rotated[3];            /* other shapes: rad about local axes since `last` */
	double stamped;               /* 1: the hollow below `last` is an impression of the body; 0: it is a flat rut */
	struct soil_pose felt;        /* the pose for which forces were last computed, */
	double felt_turned;           /* the value of `turned` then, */
	bool felt_moving;             /* and true if it moved then */
	double told;                  /* s: time of `force` and `state` */
	struct world_force force;
	enum furrow_contact_state state;
	bool moving;                  /* it moved to `last`, */
	double touched;               /* s: at this time. A body that a host puts down does not move */
	uint64_t turn;                /* number of the last call of world_bodies_set that named this body */
	double slip;                  /* of a vehicle's body: what the vehicle told for rows, */
	struct soil_pose shown;       /* and where */
};

/*
 * One body. Its shape, sink, load and slip are in the scene object. It has one number everywhere, and stays where it is in memory. The scene's objects
 * have 0 .. object_count - 1 in its order. Bodies that are added get the next numbers. A number is never used twice.
 */
struct body {
	enum body_kind kind;      /* who moves it */
	const struct scene_object *object;
	struct track *track;      /* its path; NULL: it has none */
	int64_t next;             /* number of its next path sample */
	bool has_last;          /* there was ground below `last`, so the next contact is swept from it. The body may be in the air there */
	struct soil_pose last;    /* the pose up to which its motion has changed the ground */
	struct soil_trend trend;  /* for soil that bears: its recent motion, up to `last` */
	double distance, sinkage; /* m */
	int64_t equilibrium;           /* 2^-20 m, for a body with a load: its equilibrium height, at which the soil carries it */
	int64_t raised;           /* 2^-20 m: height of `equilibrium` above the height where the search for it began */
	uint32_t loaded_body;         /* for a body with a load: its number among the loaded bodies, from 1 */
	int64_t skipped;          /* number of path samples without ground */
	int64_t near;             /* path samples of this run in which it was near the ground. With a load: steps at whose end the soil bore it */
	uint64_t met_turn;        /* meet.c: when its contacts waited last, and how many */
	size_t met;
	uint64_t windows, windows_moved; /* windows computed; of these, the windows in which the body moved */
	struct soil_carried *carried; /* carried.c: soil aboard; NULL: it carries none */
	uint64_t regions, regions_moved; /* the same of fixed regions, in which contacts are computed in the place of windows */
	_Atomic bool elsewhere;   /* another rank computes its contacts. Threads that load ahead read it */
	/* Of a body with a load, since this run began: the soil did not carry it, or did not hold it on its slope */
	struct body_failed {
		int64_t steps;      /* at whose end it was so */
		double time, x, y;  /* the first time, s, and the place then, local metres */
	} sunk, slid;
	struct body_hosted host;  /* of BODY_HOST and BODY_VEHICLE; of others all 0 */
};

/* The number of the body that a window drops. It is there while it is dropped. */
#define WORLD_DROPPED ((size_t)INT32_MAX)
/* Returns the body with this number: one of the scene's objects, an added one, or the one that a window drops. NULL: there is none, or a rollback
 * removed it. A negative number, as a size_t, has no body. */
const struct body *world_body(const struct world *world, size_t number);
/* Returns how many numbers were given out: those of the scene's objects, of added bodies, and of removed ones. */
size_t world_body_count(const struct world *world);
/* What a body carries: units are 2^-20 m, summed over posts; m3; N. All 0: nothing, or there is no such body. */
struct world_aboard {
	int64_t units;
	double volume, weight;
};
struct world_aboard world_aboard(const struct world *world, size_t number);
bool world_carries(const struct world *world);          /* a body may carry soil */
int64_t world_carried_total(const struct world *world); /* units that all bodies carry */
uint64_t world_carried_bytes(const struct world *world); /* memory that is kept for it */
/* Soil aboard a body, for pictures: cells as struct soil_carried has them. It is valid until the next step. */
struct world_heap {
	double at[3];       /* m: the body's centre */
	double heading;     /* rad: of the cells */
	double spacing;     /* m */
	int side, class;    /* cells; the class of most of the soil */
	const int32_t *amounts, *tops;
	const uint8_t *shares; /* how much of each cell is above the body, of 64 */
};
/* Returns false if there is none. */
bool world_heap(const struct world *world, size_t number, struct world_heap *heap);
/* Gives the present place of a body on its path. `place`: local metres, on the base. `yaw`: radians from east to north. */
void world_place(const struct world *world, size_t body, double place[3], double *yaw);

/*
 * --- bodies of a host: bodies without a path, in a scene that was read for a host ---
 *
 * STATUS_USAGE: there is no body with this number, or it follows a path.
 */

/* Adds a body and gives its number. `object` was made by scene_object_parse; the world owns it from now on, unless the call
 * fails. STATUS_INPUT: the name is used already, or the shape is too large for the spacing or the slots. */
enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number) FURROW_CHECKED;
/* Finds a body by name. STATUS_INPUT: no body has that name; then *number is -1. */
enum status world_body_find(struct world *world, const char *name, int32_t *number) FURROW_CHECKED;
/* Removes a body. Its weight no longer acts on the soil. */
enum status world_body_remove(struct world *world, int32_t number) FURROW_CHECKED;
/* Takes a placed body off the ground, as before it was placed. */
enum status world_body_lift(struct world *world, int32_t number) FURROW_CHECKED;
/* Puts a body at a pose, at rest. It touches nothing on the way from the old pose to the new one. */
enum status world_body_place(struct world *world, int32_t number, const struct furrow_pose *pose) FURROW_CHECKED;
/* Sets where bodies will be after the next step, and the belts of bodies of vehicles then (`belts` NULL: there is no such body). The list names each
 * body at most once. On failure no body is set. */
enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, const struct furrow_belt *belts)
	FURROW_CHECKED;
/* Sets where the belts of bodies are at the end of the next step, and in probes from now on. The first call for a body says where its
 * belt is now. On failure no belt is set. */
enum status world_belts_set(struct world *world, size_t count, const int32_t *numbers, const struct furrow_belt *belts)
	FURROW_CHECKED;
/* A space above a rectangle: all that is above `lowest` and above a plane through `at`. */
struct world_space {
	double low[2], high[2]; /* m, local: the rectangle */
	double lowest;          /* m */
	double at[3], slope[2]; /* m; its rise for each metre east and north */
};
/* Finds how far the present ground reaches into the space, m. It is the most by which a post of the working level is higher than the space's lower limit.
 * Below 0: it reaches nowhere. -INFINITY: no post there has data. INFINITY: the rectangle has more tiles than can be held at once.
 * Where several processes step the world, all of them call this with the same space, and get the same. */
enum status world_reach_into(struct world *world, const struct world_space *space, double *depth) FURROW_CHECKED;
/* From now on a vehicle moves this body, and computes its forces with world_probe. The world computes none for it, and each state that is set
 * changes the ground in the next step, however small the motion is. */
void world_body_of_vehicle(struct world *world, int32_t number);
#define WORLD_SINKAGE_SHARE 0.1 /* of a post: a body that moved up or down by so much since its last contact changes the ground */
/* How a body sank and went in plan since its last contact, and how it does in the step that follows; m. turned, turns: rad about local x and y. */
struct world_sinking {
	double sank, went, turned[2];
	double sinks, goes, turns[2];
	double reach;                 /* world_turning_reach */
};
/* Returns true if some place of the body has been deeper than a straight motion since its last contact will be. Such a body rises after it sank by
 * `least` metres. Or it sank steeply and goes on along the ground. A contact is taken as straight, so one must end there. Pure. */
bool world_leaves_dip(const struct world_sinking *sinking, double least);
/* Returns how far from its middle the lower side of a body lies that rises and sinks as it turns, m. 0: it does not. */
double world_turning_reach(const struct soil_shape *shape);
/* Tells the force on a body of a vehicle for the next rows of objects.csv. `force->z` is ignored. `slip`: of a wheel. */
enum status world_body_tell(struct world *world, int32_t number, const struct furrow_state *state, const struct world_force *force,
			    double slip) FURROW_CHECKED;
/* Moves the host's bodies to the states that were set, without a time step. */
enum status world_move_hosts(struct world *world) FURROW_CHECKED;
/* The state of a body of a vehicle as numbers, for a record, and back. STATUS_INPUT: they contradict each other. */
#define WORLD_BODY_NUMBERS (26 + SOIL_TREND_NUMBERS)
void world_body_save(const struct world *world, int32_t number, double numbers[WORLD_BODY_NUMBERS]);
enum status world_body_restore(struct world *world, int32_t number, const double numbers[WORLD_BODY_NUMBERS]) FURROW_CHECKED;
/* Puts soil back aboard the bodies of vehicles, as the record of a resumed run has it. Call it when all were added and restored, before
 * world_begin. STATUS_INPUT: the record contradicts itself. */
enum status world_carried_rejoin(struct world *world) FURROW_CHECKED;
/* Gives the load of soil that a body has aboard: its weight, N, and its centre, m from the body's origin along local axes. Returns false if it has
 * none; then both are 0. */
bool world_body_load(const struct world *world, int32_t number, double *weight, double centre[3]);
/* Gives the state of any body, also of a body with a path. NaN: it was never placed. */
enum status world_body_state(const struct world *world, int32_t number, struct furrow_state *state) FURROW_CHECKED;
/*
 * Tells what the soil would do to `count` bodies of the host in these states, as linear functions around them. Changes nothing. It reads the ground
 * on the host, and may load tiles.
 * world_probe_reads: returns true if a probe of these bodies would read the ground.
 * The contact is `unknown` off the terrain and for a body with a path. It is so, too, where a state is hundreds of working posts from the body's last
 * contact. So it is for a soil model that probes do not know. No memory is allocated, unless there are more bodies or larger windows than ever before.
 * belts: of bodies of vehicles; NULL: as world_belts_set told them. contact_size: bytes of an entry of `contacts`; an older host's are shorter.
 * STATUS_USAGE, STATUS_INPUT: a state is not one that the body can have; no contact is written then. After another failure some may be.
 */
bool world_probe_reads(const struct world *world, size_t count, const int32_t *numbers);
enum status world_probe(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, const struct furrow_belt *belts,
			struct furrow_contact *contacts, size_t contact_size) FURROW_CHECKED;
/* Returns a contact whose numbers are all NaN (not known). Pure. */
struct furrow_contact world_contact_unknown(void);
/* Gives the contact of any body with the soil. Waits for forces that are being computed. */
enum status world_body_contact(struct world *world, int32_t number, struct furrow_contact *contact) FURROW_CHECKED;
/* Computes the axes of a body (forward, left, up) in local axes. `q`: unit quaternion w, x, y, z. Pure. */
void world_axes(const double q[4], double axes[3][3]);
/* Changes the ground up to the present places of the host's bodies. Does nothing if that was already done. */
enum status world_hosts_commit(struct world *world) FURROW_CHECKED;

/* --- bodies that a window drops ---
 *
 * Each is placed once and then removed. Its lowest point goes `sink` below the surface. With a load, the soil decides how deep
 * it sinks. */
enum world_drop_shape {
	WORLD_DROP_FIRST, /* shape and sink or load of the scene's first object */
	WORLD_DROP_BALL,
	WORLD_DROP_SHAPES
};
/* Drops a body at (x, y), in local metres. `*landed` is false if there is no ground, or the scene has no object. Then nothing
 * changed. */
enum status world_drop(struct world *world, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
	FURROW_CHECKED;

#endif
