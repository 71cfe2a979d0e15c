/*
 * world/made.h: for tests and benches that make the parts of a world themselves, and for those that change one part of a world that runs. No
 * program includes this file.
 *
 * A made world is in the phase WORLD_STEPPING. Its parts are its maker's, who keeps them longer than the world. Only its own thread uses a world.
 */
#ifndef FURROW_WORLD_MADE_H
#define FURROW_WORLD_MADE_H

#include "world/record.h"
#include "world/world.h"

struct bearing_grain; /* bearing/throws.h */

struct world_made {
	const struct scene *scene;
	struct resident resident;   /* store and meta must be set */
	struct body **bodies;       /* by number; they and the list stay the maker's */
	size_t body_count;
	struct deform *deform;      /* NULL: nothing computes contacts */
	struct look_ahead *ahead;   /* NULL: nothing is loaded before it is needed */
	double time;                /* s since the scene's start */
	int64_t step;               /* steps done since then */
	uint32_t slots, loaders;    /* the world's limits: tiles in slots, and threads that load tiles */
	double prefetch;            /* s of travel that is looked ahead */
};

/* Makes a world of these parts. NULL: there is no memory for it. */
struct world *world_made(const struct world_made *made);
/* Sets all parts of a world anew. The world may be a made one, or one that was opened and not started. The scene stays. */
void world_made_set(struct world *world, const struct world_made *made);
/* Gives the parts of any world as they are now. */
void world_made_get(const struct world *world, struct world_made *made);
/* Frees a made world and none of its parts. Takes NULL. */
void world_made_free(struct world *world);

/* Fills the parameters with which the world would make its deform, except gpu, slots and reference. */
void world_made_deform_params(const struct world *world, struct deform_params *params);
/* Places a body at one of its path samples, and fills `event`, as a step does. Fails where the ground cannot be read. */
enum status world_made_set_down(struct world *world, struct body *body, int64_t sample, struct event *event) FURROW_CHECKED;
/* Computes one contact. Nothing relaxes after it, and no commit begins. Fails where a page cannot be loaded. */
enum status world_made_contact(struct world *world, const struct event *event) FURROW_CHECKED;
/* Computes all contacts that are due until a time in s, and sets the world's time to it. Nothing relaxes after them, and no commit begins. */
enum status world_made_contacts(struct world *world, double until) FURROW_CHECKED;

/* Lets grains fly, which leave now, as soil of class 0 that was thrown. The scene throws soil. */
void world_made_throw(struct world *world, const struct bearing_grain *grains, size_t count);

/* Sets who steps the world with it; NULL: nobody. `ranks` stays the caller's. */
void world_made_set_ranks(struct world *world, const struct world_ranks *ranks);
/* Returns the record that the next commit writes. It stays the world's. */
struct record *world_made_record(struct world *world);

#endif
