/* Shared by the files of src/bearing. */
#ifndef FURROW_BEARING_INTERNAL_H
#define FURROW_BEARING_INTERNAL_H

#include "bearing/bearing.h"
#include "soil/kinematic/kinematic.h"
#include "soil/kinematic/shed.h"
#include "soil/kinematic/sheet.h"
#include "soil/law/posts.h"
#include "soil/laying/laying.h"
#include "soil/sink.h"
#include "soil/sliding/roofs.h"

#include <stdlib.h>
#include <string.h>

/* Memory of a window's planes. Made for the largest window so far. */
struct bearing_window {
	struct soil_planes planes;
	struct soil_marks marks; /* of the same posts */
	int32_t *deposits;
	int32_t *carried; /* what each post gives away; soil that bears: set at posts that a body touched which pushes */
	uint8_t *owners, *patch; /* soil that bears: which body touched a post last; the posts that one body touched, as soil_lay reads them */
	size_t posts;     /* for which there is room */
	void *memory;
	size_t bytes;     /* of memory */
	void *scratch;    /* for laying, for sliding, and for lower envelopes */
	size_t scratch_bytes;
	uint32_t *words;  /* flags of blocks */
	size_t word_count;
	/* Bodies at rest, below which soil does not rise. Made when the first of them is there. */
	int32_t *highest;
	uint8_t *touched; /* kinematic models: what the contact left at each post, before bodies at rest held some */
	size_t highest_posts;
	void *roof_scratch;
	size_t roof_bytes;
	bool roofed;      /* a body is near: read `highest` */
	int32_t *before;  /* offsets before the contacts; made when a body carries soil */
	size_t before_posts;
};

/* The result of a region that waits to be put back. */
struct bearing_region {
	struct post_rect blocks; /* columns and rows of blocks */
	struct post_rect reads, writes;
	size_t at;                   /* of its posts in bearing->memory */
	int32_t *offset, *deposited, *slope; /* of `writes`; offset NULL: not computed yet; another one NULL: it is not kept */
};

/* A body of a meeting. */
struct bearing_member {
	struct soil_work *work;
	struct soil_motion motion;
	struct soil_planes planes; /* its part of the window */
	size_t at;                 /* where that begins in the window */
	struct soil_laying laying;
	struct soil_imprint imprint;
	struct soil_lay_result laid;
	struct bearing_throw throws;  /* how it throws soil */
	struct post_rect slides;   /* where soil may slide */
	struct post_rect write;    /* posts that it, or its party, may change */
	bool widened;
	size_t party;              /* the first of the members that are parts of one body with it: they lay their soil together */
	size_t cluster;            /* members of one cluster slide together, */
	struct post_rect hull;     /* on these posts: around `slides` of them all */
	bool feels;                /* it changes nothing */
	bool crosses;              /* another one may touch its posts */
};

/* A body at rest. */
struct bearing_held {
	struct post_rect shadow;
	const struct deform_rest *rest;
};

/* The whole, or a hand of it (hands.c): a copy with a window, members, active blocks and sums of its own. */
struct bearing {
	struct bearing *main, **hands;
	size_t hand_count;
	struct deform_params params;
	struct host_slots *slots;
	struct post_rect world;
	unsigned planes;             /* that are kept */
	struct soil_law law;
	struct soil_sliding rule;
	struct soil_shed shed;       /* the rule's, if the model sheds */
	bool conserves;              /* the model moves soil */
	bool bears;                  /* it computes forces; false: it is kinematic */
	bool held_is_stable;         /* the words of a contact tell all blocks in which soil may slide */
	struct soil_kinematic kinematic;
	bool elastic;                /* the ground is the sheet; its plane is `floor` of struct soil_planes */
	struct soil_sheet sheet;
	struct soil_laid laid[SOIL_CLASSES];
	int64_t around;              /* posts around what a contact reached in which soil may slide */
	struct bearing_member *members;
	size_t member_room;
	const struct soil_work **others; /* room for all members */
	struct deform_rest *rests;       /* those beside them that may touch the ground */
	size_t rest_count;
	bool whole;                      /* one call gathers all posts of the meeting */
	struct post_rect under;  /* of a meeting: the posts that its bodies may touch. Of others the window has no state but offset and deposited */
	struct soil_claim *claims;
	size_t claim_room;
	struct bearing_window window;
	int32_t *standing;           /* for each loaded body (params.loaded_bodies of them): its equilibrium height above its pose */
	struct soil_block_set active;
	struct deform_tally tally;
	/* The interval that is under way. */
	struct bearing_held *held;   /* bodies at rest, from south to north */
	size_t held_count, held_room;
	int64_t held_tallest;        /* rows of posts of the tallest shadow */
	struct bearing_region *regions;
	size_t region_count, region_room;
	int32_t *memory;             /* for the results of its regions; used again for each interval */
	size_t memory_room;          /* numbers */
	struct soil_block_set next;  /* blocks that stay active */
	uint64_t contacts, feels, slid; /* computed: contacts, contacts whose forces alone were asked, and regions */
	uint64_t results, results_most; /* posts of regions that wait to be put back: now, and at most */
};

/* window.c */
/* Makes room for a window of these posts, with room for sliding and laying in it. */
enum status bearing_window_need(struct bearing *bearing, struct post_rect rect) FURROW_CHECKED;
/* Makes room for so many bytes of scratch memory. */
enum status bearing_scratch_need(struct bearing *bearing, size_t bytes) FURROW_CHECKED;
/* Copies posts of pinned tiles into the window. The tiles together make a rectangle. Posts of other tiles are not changed. slides: only the planes that
 * sliding reads. */
void bearing_window_gather(struct bearing *bearing, const struct tile_slot *held, size_t count, bool slides, bool whole);
/* Makes all posts of the window such that lie beyond the world. */
void bearing_window_clear(struct bearing *bearing);
void bearing_window_finish(struct bearing_window *window);

/* Gives the planes of a part of the window. Returns where it begins. */
size_t bearing_window_part(const struct bearing_window *window, struct post_rect part, struct soil_planes *planes);

/* window.c: puts marks that fade back into these tiles. */
void bearing_marks_scatter(struct bearing *bearing, const struct tile_slot *held, size_t count, struct post_rect changed);
/* kinematic.c: writes marks that fade, in the window, at these posts. Does nothing where none are kept. */
void bearing_mark(struct bearing *bearing, const struct deform_contact *contact, struct post_rect posts);

/* hands.c */
void bearing_hands_finish(struct bearing *bearing);

/* members.c */
/* Makes room for so many bodies. */
enum status bearing_members_need(struct bearing *bearing, size_t count) FURROW_CHECKED;
void bearing_members_finish(struct bearing *bearing);
/* Tells whether a body that stays as it is may touch ground of the window. Gives it as a motion. */
bool bearing_rest_is_near(const struct bearing *bearing, const struct deform_rest *rest, struct soil_motion *motion);
/* Tells whether two bodies may be over the same posts. */
bool bearing_members_overlap(const struct bearing *bearing, const struct soil_motion *a, const struct soil_motion *b);
/* Tells a member which of the `all` may be over the same ground. Of them the first `count` may be parts of one body with it. */
enum status bearing_member_meet(struct bearing *bearing, size_t number, size_t count, size_t all) FURROW_CHECKED;
struct soil_motion bearing_motion_of(const struct deform_contact *contact);

/* forces.c */
/* Tells the forces of a contact. */
void bearing_tell(const struct bearing *bearing, const struct deform_contact *contact, const struct soil_motion *motion, const struct soil_forces *from,
		  struct deform_forces *forces);

/* roofs.c */
/* Marks posts that a body at rest holds, and notes how high soil may rise below it. STATUS_MEMORY. */
enum status bearing_roof(struct bearing *bearing, const struct soil_shape *shape, const struct soil_pose *pose) FURROW_CHECKED;
/* Keeps what the contact left at the posts of the window, before bodies at rest hold some. *touched: the copy. Kinematic models. STATUS_MEMORY. */
enum status bearing_roofs_keep_touched(struct bearing *bearing, const uint8_t **touched) FURROW_CHECKED;
/* The window has no bodies at rest from now on. */
void bearing_roofs_clear(struct bearing *bearing);
/* Gives the roofs of the window for sliding. Returns NULL if there are none. */
const struct soil_roofs *bearing_roofs(const struct bearing *bearing, struct soil_roofs *roofs);
/* Lets no soil be laid where a body leaves little room, and ends that. */
void bearing_roofs_close(struct bearing *bearing);
void bearing_roofs_open(struct bearing *bearing);
/* Moves laid soil that has no room below a body to other posts on which soil was laid in `laid`. Returns what found none, fixed-point units. */
int64_t bearing_roofs_part(struct bearing *bearing, struct post_rect laid);
/* Takes laid soil away that has no room below a body. Returns how much, fixed-point units. Kinematic models: the GPU does the same. */
int64_t bearing_roofs_limit(struct bearing *bearing, struct post_rect laid);
void bearing_roofs_finish(struct bearing_window *window);

/* carried.c */
/* Notes the offsets of the window, before bodies that carry soil sink in. Does nothing if none of the contacts' does. STATUS_MEMORY. */
enum status bearing_carried_begin(struct bearing *bearing, const struct bearing_contact *contacts, size_t count) FURROW_CHECKED;
/* Takes soil aboard that lies above the body, of what a contact's member displaced. owner: its number in the window's owners; 0: all touched posts are its. */
void bearing_carried_take(struct bearing *bearing, struct bearing_member *member, const struct deform_contact *contact, uint8_t owner);
/* Lets soil aboard settle after a contact of one of `count` members, in the window. Widens what the member reached. STATUS_MEMORY. */
enum status bearing_carried_after(struct bearing *bearing, struct bearing_member *member, const struct deform_contact *contact, size_t count) FURROW_CHECKED;

/* hold.c */
/* Returns the pose of a body at rest. */
struct soil_pose bearing_rest_pose(const struct bearing *bearing, const struct deform_rest *rest);
/* Marks posts that bodies at rest hold, in the window. STATUS_MEMORY. */
enum status bearing_hold(struct bearing *bearing, const struct deform_rest *objects, size_t count) FURROW_CHECKED;
/* Notes where these bodies rest, which must live while bearing_hold_near is called. STATUS_MEMORY. */
enum status bearing_hold_begin(struct bearing *bearing, const struct deform_rest *objects, size_t count) FURROW_CHECKED;
/* Marks posts that they hold, in the window. It looks at those near the window alone. STATUS_MEMORY. */
enum status bearing_hold_near(struct bearing *bearing) FURROW_CHECKED;

#endif
