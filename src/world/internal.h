/* What the files of world share. Only the world's thread touches it. */
#ifndef FURROW_WORLD_INTERNAL_H
#define FURROW_WORLD_INTERNAL_H

#include "world/record.h"
#include "world/world.h"

/* --- resume.c --- */

/* Sets the world to where the store's last run of this scene is. The bodies are made. */
enum status world_resume(struct world *world) FURROW_CHECKED;
void world_tell_unfinished(const struct world *world); /* that it could be resumed, and is not */

/* --- ruts.c --- */

/* Reads how deep the ruts are that the store or overlay has already, and notes it, unless its drive is resumed. */
enum status world_tell_ruts(const struct world *world) FURROW_CHECKED;

/* --- drop.c: links what a window's drops can run, before the first step --- */
enum status world_warm_drops(struct world *world) FURROW_CHECKED;

/* --- bodies.c: the bodies and the record, both of the scene's objects; one body more is for drops --- */
enum status world_make_bodies(struct world *world) FURROW_CHECKED;
void world_free_bodies(struct world *world); /* of a world that has none, too */

/* --- attitude.c --- */

/* A host's pose as deformation takes it, for this shape. STATUS_USAGE: a number is off, or the quaternion's length; STATUS_INPUT: a
 * wheel leans. `name` is for messages. */
enum status world_attitude(const struct deform_shape *shape, const char *name, const struct world_pose *from, struct deform_pose *pose)
	FURROW_CHECKED;
/* The quaternion of a pose, w, x, y, z. */
void world_orientation(const struct deform_pose *pose, double q[4]);

/* --- hosts.c: bodies of a host --- */

#define WORLD_HOST_PAGES 4096 /* tiles that a host's bodies may change in one step */
#define WORLD_HOST_WAY 4096   /* posts that one of them may travel in one step */
enum status world_make_hosts(struct world *world) FURROW_CHECKED;
void world_free_hosts(struct world *world);
void world_host_free(struct host_body *host); /* takes NULL */
/* NULL: a body with a path, or none. */
struct host_body *world_host_body(const struct world *world, int32_t number);
/* Of event.body: the scene's objects, then the one that a window drops, then a host's by number. */
struct body *world_body_at(const struct world *world, size_t index);
bool world_is_hosts(const struct world *world, size_t index);
/* --- host_steps.c --- */

/* Moves them to where the host said, over `seconds` that end at `until`. */
enum status world_hosts_step(struct world *world, double seconds, double until) FURROW_CHECKED;
/* Adds those that rest on the ground; returns how many. */
size_t world_host_rests(const struct world *world, struct deform_rest *rests);
/* Forces were asked for under this tag; 0: the model tells none. */
void world_host_asked(struct world *world, size_t index, uint64_t tag, const struct event *event);
void world_host_absent(struct world *world, size_t index); /* it touches nothing */
void world_host_arrived(struct world *world, uint64_t tag, const struct world_force *force);
/* told.c: where a body with a path is. */
enum status world_path_state(const struct world *world, size_t body, struct world_state *state) FURROW_CHECKED;

/* --- changes.c --- */

/* These posts of a tile of the working level changed. */
enum status world_changed(struct world *world, struct tile tile, struct post_rect rect) FURROW_CHECKED;
void world_changes_end(struct world *world); /* of a step: what it changed has its revision */
/* All that changed after that revision changes again. */
void world_changes_rollback(struct world *world, uint64_t revision);
void world_changes_finish(struct world *world);

/* --- checkpoint.c --- */
void world_checkpoint_free(struct checkpoint *saved); /* takes NULL */

/* --- plan.c: what follows from the scene and the store --- */

/* Settles the working level; the store refuses another than it has. STATUS_INPUT: it cannot be deformed so. */
enum status world_settle_level(struct world *world) FURROW_CHECKED;
/* Opens the map of soils, if the scene needs it. */
enum status world_open_soil_map(struct world *world) FURROW_CHECKED;
uint32_t world_ground_tiles(const struct world *world);
/* Without gpu, slots and reference. */
void world_deform_params(const struct world *world, struct deform_params *params);
struct deform_planned world_planned(const struct scene_object *object);
/* Without store, gpu, slots, and what the world has so far. */
void world_pages_params(const struct world *world, struct pages_params *params);

bool world_deforms(const struct world *world); /* bodies change the ground, or a host's may */
/* STATUS_INPUT: one window of this shape touches more tiles than there are slots, or than can be pinned together. */
enum status world_shape_budget(struct world *world, const char *name, const struct deform_shape *shape) FURROW_CHECKED;
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

/* The forces of a host's body alone; the ground stays as it is. */
enum status world_feel(struct world *world, const struct event *event) FURROW_CHECKED;

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

enum status world_forces_create(struct world *world, struct forces **out) FURROW_CHECKED; /* NULL: nothing asks for any */
void world_forces_destroy(struct forces *forces);
/* The rows until then: before an event, with what is known so far. */
enum status world_forces_rows(struct forces *forces, double until, bool inclusive) FURROW_CHECKED;
/* The tag for the contact of an event; 0: its forces are not asked for. */
uint64_t world_forces_ask(struct forces *forces, size_t body, const struct event *event, bool last_in_step);
/* Whether the scene's model tells forces. */
bool world_feels(const struct world *world);
/* Whether contacts of every body may be asked for their forces. */
bool world_asks_forces(const struct world *world);
/* What is known and asked, for checkpoints; nothing waits then. *out NULL: of NULL. */
struct forces_saved;
enum status world_forces_save(const struct forces *forces, struct forces_saved **out) FURROW_CHECKED;
void world_forces_restore(struct forces *forces, const struct forces_saved *saved);
void world_forces_saved_free(struct forces_saved *saved); /* takes NULL */
/* Waits for all forces that are on their way. */
enum status world_forces_wait(struct forces *forces) FURROW_CHECKED;
/* What is known of a body with a path now; false: nobody asked. */
bool world_forces_known(const struct forces *forces, size_t body, struct world_force *force);
/* It touches nothing there. */
void world_forces_absent(struct forces *forces, size_t body, const struct event *event);
/* Uses everything that was asked for, waiting for it; into the record too. */
enum status world_forces_settle(struct forces *forces, struct record *record) FURROW_CHECKED;
/* Uses what is due after so many steps. `until`: the step's end, s. */
enum status world_forces_end_step(struct forces *forces, double until) FURROW_CHECKED;

#endif
