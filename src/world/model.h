/* What a world holds. Only files of this folder know it; all others call the functions of world.h. */
#ifndef FURROW_WORLD_MODEL_H
#define FURROW_WORLD_MODEL_H

#include "base/key_map.h"
#include "base/key_set.h"
#include "bearing/bearing.h"
#include "world/world.h"

struct forces; /* forces.c */
struct record; /* record.c */

/* A changed tile of the working level: changes.c. */
struct changed_tile {
	struct tile tile;
	uint64_t last;         /* revision of the last change */
	uint64_t from;         /* `rect` contains all changes after this revision; 0: it is the whole tile */
	struct post_rect rect;
};

struct world {
	struct world_params params;
	const struct scene *scene;
	const struct world_commits *commits; /* NULL: no functions */
	const struct world_ranks *ranks;     /* NULL: this process alone steps the world */
	bool unplaced;    /* ranks: a body was placed since the last call of ranks->step */
	struct world_figures figures; /* count 0: none. Set it before a view is made */
	int64_t step;     /* steps done since the scene's start */
	double time;      /* s of simulated time since the scene's start */
	double stop_seen; /* s of the clock: when a step first saw that the drive is to end; 0: not yet */
	enum world_phase phase, torn_from; /* phase.c; torn_from: the phase before WORLD_TORN */
	struct record *record; /* as the last whole step left it, or as it was resumed */

	struct resident resident; /* the ground in memory */
	struct world_facts facts;
	struct world_counts counts;
	struct store_reader *follower; /* readonly.c; NULL: nothing is followed yet */
	struct world_relief *relief;       /* what relief by class reads; NULL: it has none */
	FILE *commit_log;         /* a line for each commit; NULL: none */

	struct deform *deform;    /* what the GPU computes; NULL: there is no body, or the CPU computes */
	struct bearing *bearing;  /* what the CPU computes; NULL: nothing */
	struct deform_params surface; /* of deform or bearing */
	struct forces *forces;    /* forces.c; NULL: forces are not needed */
	struct look_ahead *ahead; /* motion: loads tiles before they are needed */
	struct body **bodies;     /* bodies.c: by number. NULL: a rollback removed it; of the scene's objects none is NULL */
	size_t body_count, body_room;
	struct body *dropping;    /* drop.c: the body that a window drops now; NULL: none */
	struct world_names {      /* names.c: in a scene whose bodies a host moves */
		struct key_set keys; /* hashes of names */
		int32_t *numbers;    /* by a key's number: the body that had the name last */
		size_t room, known;  /* known: bodies with lower numbers are in the table */
		unsigned taken;      /* names body-1 .. body-TAKEN are taken */
	} names;
	uint64_t set_turn;        /* hosts.c: number of calls of world_bodies_set so far */
	double until;             /* s: the end of the current step */
	struct scene_object dropped; /* the last body that a window dropped */

	struct {                  /* happened.c */
		struct world_happened told;
		size_t touch_room, change_room;
		size_t touch;     /* the contact that changes the ground now; SIZE_MAX: none */
		bool watched;
	} happened;
	struct {                  /* stages.c */
		enum world_stage now;
		double since;     /* s, by the clock */
	} stage;
	struct requests prefetch;   /* world_prefetch */
	struct {                  /* forces.c: rows that nobody has read yet */
		struct world_row *list;
		size_t count, room;
	} rows;
	struct world_events {     /* events.c: events of the current step */
		struct event *list;
		size_t count, room;
		/* events of later steps that world_check_events() has placed. runs: by body; NULL: none */
		struct event *ahead;
		size_t ahead_count, ahead_room;
		struct event_run *runs;
	} events;
	struct near_table {       /* near.c */
		struct near_entry {
			size_t body;
			struct deform_rest rest; /* where it is; of a body on a path, when it was looked at last */
			struct post_rect rect;   /* it is over these posts until the table is made anew; empty: nowhere */
			bool everywhere;         /* over too many cells */
			uint64_t turn;           /* of the search that looked at it last */
		} *entries, *found;      /* in the order of bodies; found: by the last search */
		struct near_kept {
			size_t at;
			struct near_entry entry;
		} *kept;                 /* those that a probe moved, as they were */
		struct deform_rest *rests;
		struct deform_rest *beside; /* bodies beside a contact of a kinematic model */
		size_t beside_count, beside_room;
		size_t count, room, found_count, moved, everywhere;
		struct near_cell *cells; /* sorted */
		size_t cell_count, cell_room;
		int64_t side;            /* posts */
		uint64_t turn;
		bool stale;              /* bodies may have moved */
	} near;
	struct world_relaxation { /* relaxation.c */
		struct deform_rest *rests; /* room for all bodies */
		int64_t intervals;         /* relaxation intervals that were run or skipped since the scene's start */
	} relaxation;
	struct world_aloft {      /* aloft.c */
		struct key_set seen, old; /* seen: tiles that were looked at; old: those that have planes from before this world */
		bool asks_touched;
		int64_t poured;           /* 2^-20 m: by so much pours have raised or lowered a post at most */
	} aloft;
	struct thrown *thrown;    /* thrown.c; NULL: the scene throws no soil */
	struct crew *crew;        /* crew.c; NULL: one thread computes soil that bears */
	size_t hands;             /* of world->bearing, with a crew */
	struct meetings *meetings; /* meet.c; NULL: no soil bears */
	struct batches *batches;  /* batch.c; NULL: every contact is computed alone */
	struct checkpoint *checkpoint; /* checkpoint.c; NULL: none yet */
	struct world_changes {    /* changes.c: for a host's world */
		struct key_map places;  /* a tile's index in list */
		struct changed_tile *list;
		size_t count, room;
		uint64_t revision;      /* present revision of the ground */
		uint64_t asked;         /* revision that was last returned to the host */
		bool pending;           /* the ground changed after `revision` */
	} changes;
};

#endif
