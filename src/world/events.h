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

 * A watcher of a world, which draws it. All calls come from the world's thread. Any function may be NULL. If a function does
 * not return STATUS_OK, the step fails with that status.
 */
struct world_watcher {
	void *user;
	/* The next calls of `changed` belong to this contact. Both arguments NULL: they belong to relaxation. */
	enum status (*contact)(void *user, const struct event *event, const struct contact_area *area);
	/* Posts of this tile of the working level have changed. */
	enum status (*changed)(void *user, struct tile tile);
	/* Adds prefetch requests: the tiles that the watcher will need, and when. */
	enum status (*requests)(void *user, struct requests *requests);
	/* From now on the ground may differ from its base by up to this many metres. */
	void (*reach)(void *user, double metres);
};

/* Functions that are called around a commit. Both may be NULL. */
struct world_commits {
	void *user;
	void (*before_record)(void *user);         /* on the world's thread, before a commit takes the record */
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
	struct world_force force;
};
/* Receives the rows in their order. `flush` is called after some rows. */
struct world_rows {
	void *user;
	enum status (*row)(void *user, const struct world_row *row);
	enum status (*flush)(void *user);
	/* mark: tells where the rows so far end, when all are written. rollback: drops the rows after such an end. NULL: there are no
	 * checkpoints. */
	enum status (*mark)(void *user, int64_t *end);
	enum status (*rollback)(void *user, int64_t end);
};

/* Numbers that another part of the run adds to each record, such as the state of vehicles. */
struct world_attached {
	size_t count;
	void *user;
	void (*save)(void *user, double *numbers); /* on the world's thread; `count` finite numbers */
};

/* What pictures show beside the scene's objects: the parts of vehicles. */
struct world_figures {
	const struct scene_object *list; /* their shapes and names; must stay valid longer than the world */
	size_t count;
	void *user;
	/* Gives the middle of a figure, m, and its axes forward, left, up. Returns false: it is not there yet. */
	bool (*place)(void *user, size_t figure, double middle[3], double axes[3][3]);
	/* Gives the place of a vehicle, m, and its axes forward, left, up. `body`: those of this body of its model; NULL: of its root body.
	 * Returns false: it is not there yet. */
	bool (*vehicle)(void *user, size_t vehicle, const char *body, double place[3], double axes[3][3]);
};

#endif
