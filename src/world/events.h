/*
 * world/events.h, a part of world.h: what happens in a step, and who is told.
 */
#ifndef FURROW_WORLD_EVENTS_H
#define FURROW_WORLD_EVENTS_H

#include "motion/motion.h"
#include "world/body.h"

/* One path sample that is due in a step, or one pose that a host gave. The body is already placed on the ground. */
struct event {
	size_t body;      /* number of the body */
	double time;      /* s since the scene's start */
	bool contact;     /* false: outside the terrain or over nodata; the sample is skipped */
	double distance;  /* m along the ground since the last sample */
	double sinkage;   /* m below the base */
	double seconds;   /* s since the last sample */
	double next_time; /* s: when the next sample is due; INFINITY: there is no next sample */
	double turned;    /* rad that a wheel has turned, m that a belt has run, since the last sample; only for a host's bodies */
	double stamped;   /* as in struct deform_contact; only for a host's bodies */
	double rotated[3]; /* rad about local axes that another body of a host has turned since the last sample */
	struct soil_pose pose;
};

/* The area in which a body is about to change the ground. */
struct contact_area {
	int64_t lowest;         /* 2^-20 m: no part of the body is below this height. INT64_MIN: not known */
	/* changed: posts of the working level that may change. read: posts whose values they may take. */
	struct post_rect changed, read;
};

/*
 * What happened to the ground, for who draws it. A world keeps it from world_watch on, until world_happened_clear. Who draws reads it before the next
 * commit takes the record (struct world_commits), since what the store has then is newer.
 */
struct world_happened {
	struct world_touch {              /* a contact, in the order of contacts */
		const struct soil_shape *shape; /* of the body; valid until the next step */
		struct soil_pose pose;
		double depth;             /* m: about how deep the body is in the soil */
		struct contact_area area;
	} *touches;
	struct world_change {             /* posts of a tile of the working level have changed, in the order of changes */
		struct tile tile;
		size_t touch;             /* by that contact; SIZE_MAX: by relaxation */
	} *changes;
	size_t touch_count, change_count;
	double reach;                     /* m: the ground may differ from its base by up to this; 0: as before */
};
void world_watch(struct world *world); /* call it before world_warm, or when a view is made */
const struct world_happened *world_happened(const struct world *world);
void world_happened_clear(struct world *world);
/* Who draws puts here, before a step, the tiles that it will need, and when. The step loads them ahead, and clears the list. */
struct requests *world_prefetch(struct world *world);

/* Functions that are called around a commit. Both may be NULL. */
struct world_commits {
	void *user;
	enum status (*before_record)(void *user);  /* on the world's thread, before a commit takes the record */
	enum status (*before_commit)(void *user);  /* on the writer thread, before it commits */
};

/* A row of objects.csv: the force of the soil on a body at one time. */
struct world_row {
	double time;         /* s */
	size_t body;
	const struct scene_object *object; /* of the body */
	double slip;         /* of a wheel or a belt */
	double position[3];  /* m, of the body's origin */
	/* index of the soil at the post nearest to the origin, in the scene's soils; -1: outside the terrain */
	int soil;
	struct world_force force; /* with the load of what it carries */
	struct world_aboard aboard;
};
/* Gives the rows of the steps since world_rows_clear, in order. A step adds its rows at its end; one that fails adds none. */
const struct world_row *world_rows(const struct world *world, size_t *count);
void world_rows_clear(struct world *world);

/* What pictures show beside the scene's objects: the parts of vehicles. Their owner keeps the places up to date between steps. */
struct world_place {
	bool there;                       /* false: it is not there yet */
	double at[3], axes[3][3];         /* m; axes forward, left, up */
};
/* How a figure looks, and to which body it belongs. */
struct world_look {
	float colour[3];                  /* albedo, linear */
	bool painted;                     /* false: it has the colours that pictures give its shape */
	size_t body;                      /* index into world_figures.bodies */
};
struct world_figures {
	const struct scene_object *list;  /* shapes and names; must stay valid longer than the world */
	const struct world_place *places; /* of their middles */
	const struct world_look *looks;
	size_t count;
	const char *const *bodies;        /* names VEHICLE.BODY of what figures belong to: pictures number them in this order */
	size_t body_count;
	const struct world_frame {        /* bodies of the models of vehicles */
		size_t vehicle;
		const char *body;         /* name; NULL: the root body, also if it has a name */
		struct world_place place;
	} *frames;
	size_t frame_count;
};
/* Finds the place of a body of a vehicle's model. NULL: it is not there yet. `body` NULL: the root body. */
const struct world_place *world_frame_of(const struct world *world, size_t vehicle, const char *body);
/*
 * Bodies by their numbers in pictures, from 1. The scene's objects come first, in its order, then the bodies of world_figures. Those that a host has
 * added come last, in the order of their numbers in the world. A number stays the same through a drive, and is the same in each drive of a scene.
 */
/* Returns the name of the body that has a number, valid until the next body is added. NULL: nothing has it, as 0. */
const char *world_instance_of(const struct world *world, uint32_t number);
uint32_t world_instance_of_figured(const struct world *world, size_t body); /* returns the number of a body of world_figures */
uint32_t world_instance_of_added(const struct world *world, size_t body); /* returns the number of a body that a host has added */

#endif
