/*
 * A body on the ground: its form, its motion, and the posts that it may touch. Contacts, searches for the equilibrium height and probes evaluate the
 * law of the soil by these functions alone. So they tell the same forces to the bit. Inside of src/soil.
 */
#ifndef FURROW_SOIL_CONTACT_H
#define FURROW_SOIL_CONTACT_H

#include "soil/faces/faces.h"
#include "soil/law/bear.h"
#include "soil/law/fine.h"
#include "soil/law/grousers.h"
#include "soil/law/meet.h"

/* Heights are fixed-point units above motion->to.z. */
struct soil_contact {
	const struct soil_law *law;
	const struct soil_planes *planes;
	const struct soil_motion *motion;
	struct soil_body body;
	struct soil_form form;
	struct post_rect below;   /* posts that may be below the body during its motion */
	struct soil_posts *posts; /* of the scratch memory */
	struct soil_faces *faces; /* the same */
	double by_width;   /* 1 / width of the contact patch, 1/m; 0: it follows from the area that the body touches */
	double bulb;       /* of layers: its width, in widths of the contact patch: 2 where that is the radius of a round plate */
	bool round;        /* it is a mesh of a drum, */
	double across[2];  /* whose axis is across this direction in plan, or it is 0 */
	double wider;      /* than its own, the patch that it has together with bodies that abut it */
	double above;      /* m: posts count too above whose ground the body is by at most this */
	int32_t gathered;  /* the least height for which the posts were gathered */
	/* Others that may be over the same ground. */
	const struct soil_seen *seen;
	size_t seen_count;
	bool shares;       /* one of them bore a part of a post */
};

struct soil_work {
	struct soil_posts posts;
	struct soil_faces faces;
	struct soil_kept kept;
	size_t kept_room;
	struct soil_fine_work fine;
	struct soil_grousers_work grousers;
	struct soil_contact contact; /* of soil_sink_begin */
	int32_t raised;              /* its height, and whether there is ground below it */
	bool touches;
	struct soil_met *met;
	struct soil_seen *seen;
	bool *abuts;                 /* of those: they abut it */
	size_t met_room;
};

/* Prepares a body; does not read the planes. above: as in soil_posts_gather. Keeps pointers to all arguments. The struct points to itself, so it is not
 * copied. STATUS_MEMORY: no room for its posts. */
enum status soil_contact_begin(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
			       double above, struct soil_contact *b) FURROW_CHECKED;
/* Prepares what others bear of its posts: bodies that were begun, at their height now. raised: the height at which this one is taken to stand. Call it
 * before posts are gathered. STATUS_MEMORY. */
enum status soil_contact_meet(struct soil_contact *b, struct soil_work *work, const struct soil_work *const *others, size_t count, int32_t raised) FURROW_CHECKED;
/* Gathers the posts for heights from `lowest` on, if that is not done. */
void soil_contact_gather(struct soil_contact *b, int32_t lowest);
/* Evaluates the law at a height for which the posts were gathered. share, kept, changes: as in soil_bear. */
void soil_contact_evaluate(struct soil_contact *b, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept, struct soil_changes *changes);
/* Turns a vector from the body's frame to east, north, up. */
void soil_contact_turn(const struct soil_contact *b, const double v[3], double out[3]);
/* Tells the forces of an evaluation. state: SOIL_AIR takes its place where no post bears. */
void soil_contact_tell(const struct soil_contact *b, const struct soil_sums *sums, int32_t raised, enum soil_state state, struct soil_forces *forces);

/* The height of a body with a load. */
struct soil_height {
	int32_t raised;
	float share;          /* of the load that the soil carries there; not quite 1, since heights are whole units */
	enum soil_state state; /* SOIL_AIR: there is no ground below the body */
	int tries;            /* evaluations */
};
/* Finds the equilibrium height: height.c. start: where the search begins. */
void soil_height_find(struct soil_contact *b, int32_t start, struct soil_height *height);

#endif
