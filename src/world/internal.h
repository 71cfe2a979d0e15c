/* What the files of world share. Only the world's thread touches it. */
#ifndef FURROW_WORLD_INTERNAL_H
#define FURROW_WORLD_INTERNAL_H

#include "world/world.h"

/* --- resume.c --- */

/* Sets the world to where the store's last run of this scene is. The bodies are made. */
enum status world_resume(struct world *world) FURROW_CHECKED;
void world_tell_unfinished(const struct world *world); /* that it could be resumed, and is not */

/* --- drop.c: links what a window's drops can run, before the first step --- */
enum status world_warm_drops(struct world *world) FURROW_CHECKED;

/* --- bodies.c: the bodies and the record, both of the scene's objects; one body more is for drops --- */
enum status world_make_bodies(struct world *world) FURROW_CHECKED;
void world_free_bodies(struct world *world); /* of a world that has none, too */

/* --- plan.c: what follows from the scene and the store --- */

/* Settles the working level; the store refuses another than it has. STATUS_INPUT: it cannot be deformed so. */
enum status world_settle_level(struct world *world) FURROW_CHECKED;
uint32_t world_ground_tiles(const struct world *world);
/* Without gpu, slots and reference. */
void world_deform_params(const struct world *world, struct deform_params *params);
struct deform_planned world_planned(const struct scene_object *object);
/* Without store, gpu, slots, and what the world has so far. */
void world_pages_params(const struct world *world, struct pages_params *params);

/* --- budget.c: most pages one step can touch, for the queue's bound --- */
uint32_t world_step_pages(const struct world *world);

/* --- events.c --- */

/* What is due, in the order of time, then of the scene. */
enum status world_collect_events(struct world *world, double until) FURROW_CHECKED;
/* The body upon the ground at a path sample: pose, contact, distance and sinkage are filled. */
enum status world_set_down(struct world *world, struct body *body, int64_t sample, struct event *event) FURROW_CHECKED;

/* --- relaxation.c: the ground at large --- */

/* For undisturbed ground that relaxes: all of it may, from the first. Not more than world_budget_check lets pass. */
enum status world_wake_all(struct world *world) FURROW_CHECKED;
/* Relaxation intervals until `time` are over: of the scene's start, or of what was resumed. */
void world_intervals_from(struct world *world, double time);
/* All intervals before `time`, or also the one at it. */
enum status world_intervals(struct world *world, double time, bool at_it) FURROW_CHECKED;
/* What the body rested on is free. */
enum status world_let_go(struct world *world, const struct body *body) FURROW_CHECKED;

/* --- contact.c: one contact's deformation --- */

#define WORLD_TILES_MOST 64 /* that are pinned together */
struct held_tiles {
	struct deform_tile tiles[WORLD_TILES_MOST];
	uint64_t keys[WORLD_TILES_MOST];
	size_t count;
};
/* Pins all tiles that hold a post of the rectangle; none after a failure. */
enum status world_hold(struct world *world, struct post_rect rect, struct held_tiles *held) FURROW_CHECKED;
void world_release(struct world *world, struct held_tiles *held);
/* The posts of the rectangle have changed in the held tiles: all who must know are told. */
enum status world_mark(struct world *world, struct post_rect rect, const struct held_tiles *held) FURROW_CHECKED;
/* `last`: no other contact of this body follows in this step. */
enum status world_contact(struct world *world, const struct event *event, bool last) FURROW_CHECKED;

/* --- aloft.c --- */

/* Whether soil must be known by what was touched: it moves, and a body may be above it. */
bool world_asks_touched(const struct world *world);
/* No part of the body is below this anywhere in the swept contact, 2^-20 m. */
int64_t world_lowest(const struct deform_sweep *sweep);
/* A tile is held: before anything changes it. */
enum status world_see(struct world *world, const struct deform_tile *held) FURROW_CHECKED;
/* Whether nothing would change, were the windows computed; sets the sweep's `above`. May pin tiles for a while. */
enum status world_is_aloft(struct world *world, const struct event *event, struct deform_sweep *sweep,
			   const struct deform_window *windows, size_t count, bool *aloft) FURROW_CHECKED;

/* --- forces.c; a NULL forces is none --- */

enum status forces_create(struct world *world, struct forces **out) FURROW_CHECKED; /* NULL: nothing asks for any */
void forces_destroy(struct forces *forces);
/* The rows until then: before an event, with what is known so far. */
enum status forces_rows(struct forces *forces, double until, bool inclusive) FURROW_CHECKED;
/* The tag for the contact of an event; 0: its forces are not asked for. */
uint64_t forces_ask(struct forces *forces, size_t body, const struct event *event, bool last_in_step);
/* It touches nothing there. */
void forces_absent(struct forces *forces, size_t body, const struct event *event);
/* Uses what is due after so many steps. `until`: the step's end, s. */
enum status forces_end_step(struct forces *forces, double until) FURROW_CHECKED;

#endif
