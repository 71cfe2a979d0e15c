/*
 * bearing: what the CPU computes, by src/soil, over pages in host memory: contacts of bodies, relaxation of active blocks, and what they add up. It
 * computes soil that bears (model scm), and kinematic models where the GPU does not.
 *
 * A contact takes posts from the pinned tiles into a window. There the body sinks in, what it displaced is laid, and soil slides. Then the changed
 * posts are put back. Forces are known when it returns. No function needs GL. Functions on a struct bearing are for the thread that owns the
 * page cache, unless they say otherwise.
 */
#ifndef FURROW_BEARING_H
#define FURROW_BEARING_H

#include "base/base.h"
#include "bearing/pour.h"
#include "bearing/throws.h"
#include "deform/deform.h"
#include "resident/resident.h"
#include "soil/soil.h"

struct bearing;

/* Makes it for a world with these parameters, of any model. Ignores gpu and slots of params; `slots` and params->extent must outlive it. */
enum status bearing_create(const struct deform_params *params, struct host_slots *slots, struct bearing **out) FURROW_CHECKED;
void bearing_destroy(struct bearing *bearing); /* takes NULL */

/* --- contacts of soil that bears --- */

/* What a contact reads and may change, posts. Both are empty if it lies outside the world. */
struct bearing_area {
	struct post_rect read, write;
};
/* STATUS_INPUT: the body is too large. Pure. */
enum status bearing_area(const struct bearing *bearing, const struct deform_contact *contact, struct bearing_area *area) FURROW_CHECKED;
/* Returns true if the contact reads all that the body rests on in a pose, and around it. Then nothing need be made active when it leaves that pose. */
bool bearing_covers(const struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, const struct soil_pose *rest);

/* One of the bodies that meet the ground together, and what it did. */
struct bearing_contact {
	const struct deform_contact *contact;
	struct bearing_area area;
	bool feels;               /* its forces alone are asked; it changes nothing */
	struct deform_forces forces;
	struct post_rect changed; /* posts whose planes it may have changed; empty: none */
	/* With params.thrown: what it threw, fixed-point units, and how. It is gone from the ground, and counts in the tally as compacted until bearing_thrown_land. */
	int64_t thrown;
	struct bearing_throw throws;
	uint8_t thrown_class;     /* of the soil at its centre */
	int64_t thrown_from[3];   /* its centre, 2^-20 m */
};
/*
 * Computes the contacts of bodies that meet the ground together. Each finds the ground as it was before. At each post the lowest body bears. Their order
 * does not show. Call bearing_meeting_begin, then bearing_meeting_gather until each tile that has posts of bearing_meeting_reads was held once. Then
 * bearing_meeting_compute, and bearing_meeting_scatter with the tiles that have posts of `changed`.
 */
/* One call that holds all tiles: `whole`. */
enum status bearing_meeting_begin(struct bearing *bearing, const struct bearing_contact *contacts, size_t count, bool whole) FURROW_CHECKED;
/* held: pinned tiles that together make a rectangle. */
void bearing_meeting_gather(struct bearing *bearing, const struct tile_slot *held, size_t count);
/* beside: others that may be over the same ground, and stay as they are; no soil is laid below them, nor slides there. Makes posts that changed
 * active. After a failure nothing was changed. */
enum status bearing_meeting_compute(struct bearing *bearing, struct bearing_contact *contacts, size_t count, const struct deform_rest *beside,
				    size_t beside_count) FURROW_CHECKED;
/* Puts back what these tiles, which are pinned, have of the contacts' changed posts. */
enum status bearing_meeting_scatter(struct bearing *bearing, const struct bearing_contact *contacts, size_t count, const struct tile_slot *held,
				    size_t held_count) FURROW_CHECKED;
/* All four calls for one contact, whose tiles are all held. */
enum status bearing_contact_alone(struct bearing *bearing, struct bearing_contact *contact, const struct tile_slot *held, size_t count) FURROW_CHECKED;
#define BEARING_TOGETHER 250 /* the most contacts of one call */
/* Returns the posts that bearing_meet reads. */
struct post_rect bearing_meeting_reads(const struct bearing_contact *contacts, size_t count);
/* Returns the posts that a probe of this motion reads. */
struct post_rect bearing_probe_posts(const struct bearing *bearing, const struct soil_motion *motion);
/* Computes what soil_probe tells, where others are `beside` it. before: a motion of the same body that comes first, up to the begin of `motion`; NULL: none.
 * reads: bearing_probe_posts of both, not empty. held: all tiles that have some of these posts, pinned. */
enum status bearing_probe(struct bearing *bearing, const struct soil_motion *before, const struct soil_motion *motion, struct post_rect reads, const struct deform_rest *beside,
			  size_t beside_count, const struct tile_slot *held, size_t count, struct soil_probed *out) FURROW_CHECKED;
/* Returns the recent motion of a body after a contact. Pure. */
struct soil_trend bearing_trend_after(const struct bearing *bearing, const struct deform_contact *contact);
struct soil_trend bearing_trend_of(const struct bearing *bearing, const struct soil_motion *motion); /* the same after a motion */
/* Sets the equilibrium height of a loaded body that has had no contact yet: how far it rests above its pose, 2^-20 m. */
void bearing_set_equilibrium(struct bearing *bearing, uint32_t loaded_body, int32_t raised);

/*
 * --- contacts of kinematic models: a body follows its path, whatever the soil does ---
 *
 * Call bearing_kinematic_begin. Call bearing_kinematic_gather until each tile that has posts of area->read was held once. Call bearing_kinematic_run. Then
 * call bearing_kinematic_scatter until each tile that has posts of `changed` was held once. One contact at a time, and nothing else in between. The
 * ground has the same bits as after the passes on the GPU.
 */
enum status bearing_kinematic_begin(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area) FURROW_CHECKED;
/* held: pinned tiles that together make a rectangle. */
void bearing_kinematic_gather(struct bearing *bearing, const struct tile_slot *held, size_t count);
/* alone: the contact is not so large that the GPU would cut it into parts. Makes blocks in which soil may slide active. *changed: posts whose planes it
 * may have changed; empty: none. *told: of a body with a load, over an elastic sheet: height, sinkage, area, state; else unchanged. */
enum status bearing_kinematic_run(struct bearing *bearing, const struct deform_contact *contact, const struct bearing_area *area, bool alone,
				  struct deform_forces *told, struct post_rect *changed) FURROW_CHECKED;
/* Instead of bearing_kinematic_run, of an elastic sheet: the body leaves the pose contact->from, and the sheet comes back. */
void bearing_kinematic_leave(struct bearing *bearing, const struct deform_contact *contact, struct post_rect *changed);
/* held: pinned tiles. Writes the changed posts that they have. */
enum status bearing_kinematic_scatter(struct bearing *bearing, struct post_rect changed, const struct tile_slot *held, size_t count) FURROW_CHECKED;

/* --- active blocks: those in which soil may still slide --- */

enum status bearing_wake(struct bearing *bearing, struct post_rect changed) FURROW_CHECKED; /* the blocks near these posts */
enum status bearing_wake_block(struct bearing *bearing, struct soil_block block) FURROW_CHECKED;
/* Gives the list of them, in the order of their keys. Valid until the next call. STATUS_FAILED: there are too many. */
enum status bearing_active_blocks(struct bearing *bearing, const struct soil_block **blocks, size_t *count) FURROW_CHECKED;
void bearing_forget_active(struct bearing *bearing);

/* Returns the posts of all blocks that bearing_wake makes active for this change. */
struct post_rect bearing_wakes(const struct bearing *bearing, struct post_rect changed);
/* Returns a number of posts. A contact of this shape reads and changes no post that lies farther from the rectangle around its origins. */
int64_t bearing_contact_reach(const struct bearing *bearing, const struct soil_shape *shape);

/*
 * One interval of relaxation. Call bearing_interval_begin. For each region call bearing_interval_start, bearing_interval_gather until each tile
 * that has posts of bearing_interval_reads was held once, and bearing_interval_slide. Then call bearing_interval_scatter for each region, and bearing_interval_end.
 * objects: bodies that hold the soil below them; they must live until the end.
 */
struct bearing_interval {
	size_t blocks, regions;
};
enum status bearing_interval_begin(struct bearing *bearing, const struct deform_rest *objects, size_t count, struct bearing_interval *interval) FURROW_CHECKED;
struct post_rect bearing_interval_reads(const struct bearing *bearing, size_t region);
struct post_rect bearing_interval_writes(const struct bearing *bearing, size_t region); /* lies on four tiles at most, if tiles have 32 cells or more */
enum status bearing_interval_start(struct bearing *bearing, size_t region) FURROW_CHECKED;
/* held: pinned tiles that together make a rectangle. */
void bearing_interval_gather(struct bearing *bearing, const struct tile_slot *held, size_t count);
enum status bearing_interval_slide(struct bearing *bearing, size_t region) FURROW_CHECKED;
/* held: all tiles that have posts of what the region writes. */
enum status bearing_interval_scatter(struct bearing *bearing, size_t region, const struct tile_slot *held, size_t count) FURROW_CHECKED;
enum status bearing_interval_end(struct bearing *bearing) FURROW_CHECKED;
/* Returns how many posts around its blocks an interval reads. */
int64_t bearing_interval_rim(const struct bearing *bearing);

/*
 * --- soil aboard bodies: soil/carried ---
 *
 * A contact of a body that carries takes soil along, and lets soil slide over the edges (deform_contact.carried). Between contacts an interval does. Soil aboard
 * counts in the tally as compacted: what is aboard of all bodies is a part of that.
 */
/* Returns the posts that it reads and may change, within the world. */
struct post_rect bearing_carried_posts(const struct bearing *bearing, const struct soil_carried *carried, const struct deform_rest *rest);
/* A body that carries, and where it is. */
struct bearing_laden {
	struct soil_carried *carried;
	struct deform_rest rest;
};
/* How soil aboard a body settles. */
struct bearing_aboard {
	struct bearing_laden body;
	bool drops;                           /* all of it falls: the body was removed */
	const struct bearing_laden *others; /* other bodies that carry: what falls there is theirs */
	size_t other_count;
	const struct deform_rest *rests;      /* bodies that hold soil */
	size_t rest_count;
};
/* Lets soil aboard slide, or drops it. STATUS_MEMORY. held: all tiles that have the posts of bearing_carried_posts, pinned. *changed: posts whose planes changed, which are active now;
 * empty: none. */
enum status bearing_carried_settle(struct bearing *bearing, const struct bearing_aboard *how, const struct tile_slot *held, size_t held_count,
				   struct post_rect *changed) FURROW_CHECKED;
/* --- thrown soil that lands --- */

/* Where soil comes down. */
struct bearing_landing {
	int64_t x, y;   /* 2^-20 m from the south-west post */
	int64_t volume; /* fixed-point units */
};
/* Returns the posts that landings may change, within the world. */
struct post_rect bearing_thrown_posts(const struct bearing *bearing, const struct bearing_landing *landings, size_t count);
/*
 * Puts soil on the ground: on the four posts around each place, by their shares of its cell. What a body holds, or has no data, gives its share to the nearest free post at
 * most BEARING_LANDS_NEAR posts away. What finds none stays compacted: *lost, fixed-point units. rests: bodies that hold soil. held: all tiles that have posts of
 * bearing_thrown_posts, pinned. *changed: posts whose planes changed, which are active now; empty: none. The order of landings does not show, unless a post
 * becomes too high.
 */
#define BEARING_LANDS_NEAR 8
enum status bearing_thrown_land(struct bearing *bearing, const struct bearing_landing *landings, size_t count, const struct deform_rest *rests, size_t rest_count,
				const struct tile_slot *held, size_t held_count, struct post_rect *changed, int64_t *lost) FURROW_CHECKED;

/* --- hands: several threads at once --- */

/* Makes hands, `count` with the bearing itself, which is hand 0. Each computes contacts and regions beside the others, as long as they share no post. A hand
 * may be given to bearing_meeting_* and to bearing_interval_start, gather and slide. bearing_meeting_scatter is for the owner of the page cache. */
enum status bearing_hands_need(struct bearing *bearing, size_t count) FURROW_CHECKED;
struct bearing *bearing_hand(struct bearing *bearing, size_t number);
/* Adds the sums and active blocks of all hands to the whole. Call it when none of them computes, before anything else is asked of the whole. */
enum status bearing_hands_join(struct bearing *bearing) FURROW_CHECKED;

/* --- what was added up --- */

void bearing_tally(const struct bearing *bearing, struct deform_tally *tally);
/* Goes back to an earlier tally, and makes every block inactive. */
void bearing_restore(struct bearing *bearing, const struct deform_tally *tally);

/* --- work and memory --- */

/* What was computed since bearing_create, and what was allocated so far: the most that existed at once. */
struct bearing_figures {
	uint64_t contacts, feels, regions; /* contacts that changed the ground, those whose forces alone were asked, and regions of relaxation */
	uint64_t window_posts;  /* posts for which the window has room */
	uint64_t scratch_bytes; /* beside it */
	uint64_t result_posts;  /* posts of regions that wait to be put back */
	uint64_t bytes;         /* of all three, and of what is made at the start. */
};
void bearing_figures(const struct bearing *bearing, struct bearing_figures *figures);
/* Adds the plan's lines of planes, and of the memory that bearing_figures tells. Ignores gpu, slots and extent. Pure. */
void bearing_plan(const struct deform_params *params, struct plan *plan);

#endif
