/* What the files of world share. Only the world's thread touches it. */
#ifndef FURROW_WORLD_INTERNAL_H
#define FURROW_WORLD_INTERNAL_H

#include "world/record.h"
#include "world/world.h"

/* --- resume.c --- */

/* Sets the world to the state of the store's last run of this scene. The bodies must have been made. */
enum status world_resume(struct world *world) FURROW_CHECKED;
void world_tell_unfinished(const struct world *world); /* says that an unfinished run could be resumed, and is not */

/* --- ruts.c --- */

/* Reads the depth of the ruts in the store or overlay and prints a note about them, unless the drive is resumed. */
enum status world_tell_ruts(const struct world *world) FURROW_CHECKED;

/* --- drop.c: links the programs that a window's drops can run, before the first step --- */
enum status world_warm_drops(struct world *world) FURROW_CHECKED;

/* --- bodies.c: makes the bodies and the record, for the scene's objects; one more body is for drops --- */
enum status world_make_bodies(struct world *world) FURROW_CHECKED;
void world_free_bodies(struct world *world); /* also of a world without bodies */

/* --- attitude.c --- */

/* Converts a host's pose to deform's, for this shape. STATUS_USAGE: a number is wrong, or the quaternion's length.
 * STATUS_INPUT: a wheel leans. `name` is for messages. */
enum status world_attitude(const struct deform_shape *shape, const char *name, const struct world_pose *from, struct deform_pose *pose)
	FURROW_CHECKED;
/* Computes the quaternion of a pose: w, x, y, z. */
void world_orientation(const struct deform_pose *pose, double q[4]);

/* --- hosts.c: bodies of a host --- */

#define WORLD_HOST_PAGES 4096 /* tiles that a host's bodies may change in one step */
#define WORLD_HOST_WAY 4096   /* posts that one of them may travel in one step */
enum status world_make_hosts(struct world *world) FURROW_CHECKED;
void world_free_hosts(struct world *world);
void world_host_free(struct host_body *host); /* takes NULL */
/* Returns NULL for a body with a path, or if there is none. */
struct host_body *world_host_body(const struct world *world, int32_t number);
/* Returns the body for event.body: first the scene's objects, then the window's drop, then the host's bodies by number. */
struct body *world_body_at(const struct world *world, size_t index);
bool world_is_hosts(const struct world *world, size_t index);
/* --- host_steps.c --- */

/* Moves the bodies to where the host said, in `seconds` that end at `until`. */
enum status world_hosts_step(struct world *world, double seconds, double until) FURROW_CHECKED;
/* Adds the bodies that rest on the ground; returns how many. */
size_t world_host_rests(const struct world *world, struct deform_rest *rests);
/* Notes that forces were asked for under this tag; 0: the model tells none. */
void world_host_asked(struct world *world, size_t index, uint64_t tag, const struct event *event);
void world_host_absent(struct world *world, size_t index); /* it touches nothing */
void world_host_arrived(struct world *world, uint64_t tag, const struct world_force *force);
/* told.c: tells where a body with a path is. */
enum status world_path_state(const struct world *world, size_t body, struct world_state *state) FURROW_CHECKED;

/* --- changes.c --- */

/* Says that these posts of a tile of the working level changed. */
enum status world_changed(struct world *world, struct tile tile, struct post_rect rect) FURROW_CHECKED;
void world_changes_end(struct world *world); /* ends a step: its changes get its revision */
/* Marks everything that changed after that revision as changed again. */
void world_changes_rollback(struct world *world, uint64_t revision);
void world_changes_finish(struct world *world);

/* --- checkpoint.c --- */
void world_checkpoint_free(struct checkpoint *saved); /* takes NULL */

/* --- plan.c: what follows from the scene and the store --- */

/* Sets the working level. The store refuses a level other than its own. STATUS_INPUT: it cannot be deformed at this level. */
enum status world_settle_level(struct world *world) FURROW_CHECKED;
/* Opens the map of soils, if the scene needs it. */
enum status world_open_soil_map(struct world *world) FURROW_CHECKED;
uint32_t world_ground_tiles(const struct world *world);
/* Fills the parameters, except gpu, slots and reference. */
void world_deform_params(const struct world *world, struct deform_params *params);
struct deform_planned world_planned(const struct scene_object *object);
/* Fills the parameters, except store, gpu, slots, and the sums so far. */
void world_pages_params(const struct world *world, struct pages_params *params);

bool world_deforms(const struct world *world); /* bodies change the ground, or a host's may */
/* STATUS_INPUT: one window of this shape touches more tiles than there are slots, or than can be pinned together. */
enum status world_shape_budget(struct world *world, const char *name, const struct deform_shape *shape) FURROW_CHECKED;
/* --- budget.c: returns the most pages that one step can touch, which bounds the queue --- */
uint32_t world_step_pages(const struct world *world);

/* --- events.c --- */

/* Collects the events that are due, in the order of time, then of the scene. */
enum status world_collect_events(struct world *world, double until) FURROW_CHECKED;
/* Sets the body upon the ground at a path sample. Fills pose, contact, distance and sinkage. */
enum status world_set_down(struct world *world, struct body *body, int64_t sample, struct event *event) FURROW_CHECKED;

/* --- relaxation.c: the ground at large --- */

/* For undisturbed ground that relaxes: makes all of its blocks active at the start. world_budget_check bounds their number. */
enum status world_wake_all(struct world *world) FURROW_CHECKED;
/* Counts the relaxation intervals until `time` as done, at the scene's start or on resume. */
void world_intervals_from(struct world *world, double time);
/* Runs all intervals before `time`, and with `at_it` also the one at `time`. */
enum status world_intervals(struct world *world, double time, bool at_it) FURROW_CHECKED;
/* Frees the ground that the body rested on. */
enum status world_let_go(struct world *world, const struct body *body) FURROW_CHECKED;

/* --- contact.c: one contact's deformation --- */

#define WORLD_TILES_MOST 64 /* tiles that are pinned together */
struct held_tiles {
	struct deform_tile tiles[WORLD_TILES_MOST];
	uint64_t keys[WORLD_TILES_MOST];
	size_t count;
};
/* Pins all tiles that hold a post of the rectangle. After a failure none is pinned. */
enum status world_hold(struct world *world, struct post_rect rect, struct held_tiles *held) FURROW_CHECKED;
void world_release(struct world *world, struct held_tiles *held);
/* Says that the posts of the rectangle have changed in the held tiles, and tells all who must know. */
enum status world_mark(struct world *world, struct post_rect rect, const struct held_tiles *held) FURROW_CHECKED;
/* Makes one contact. `last`: no other contact of this body follows in this step. */
enum status world_contact(struct world *world, const struct event *event, bool last) FURROW_CHECKED;

/* Asks for the forces on a host's body. The ground does not change. */
enum status world_feel(struct world *world, const struct event *event) FURROW_CHECKED;

/* --- aloft.c --- */

/* Tells whether touched posts must be known: soil moves, and a body may be above it. */
bool world_asks_touched(const struct world *world);
/* Returns a height that no part of the body is below during the contact, 2^-20 m. */
int64_t world_lowest(const struct deform_contact *contact);
/* Looks at a held tile before anything changes it. */
enum status world_see(struct world *world, const struct deform_tile *held) FURROW_CHECKED;
/* Tells whether computing the windows would change nothing. Sets the contact's `above`. May pin tiles for a while. */
enum status world_is_aloft(struct world *world, const struct event *event, struct deform_contact *contact,
			   const struct deform_window *windows, size_t count, bool *aloft) FURROW_CHECKED;

/* --- forces.c; NULL instead of a struct forces is allowed: no forces --- */

enum status world_forces_create(struct world *world, struct forces **out) FURROW_CHECKED; /* NULL: nothing asks for any */
void world_forces_destroy(struct forces *forces);
/* Makes the rows until then, before an event, with what is known so far. */
enum status world_forces_rows(struct forces *forces, double until, bool inclusive) FURROW_CHECKED;
/* Returns the tag for the contact of an event; 0: its forces are not needed. */
uint64_t world_forces_ask(struct forces *forces, size_t body, const struct event *event, bool last_in_step);
/* Tells whether the scene's model computes forces. */
bool world_feels(const struct world *world);
/* Tells whether forces of every body's contacts may be asked for. */
bool world_asks_forces(const struct world *world);
/* Copies the state of the forces, for checkpoints. No forces may be in flight. *out NULL for NULL. */
struct forces_saved;
enum status world_forces_save(const struct forces *forces, struct forces_saved **out) FURROW_CHECKED;
void world_forces_restore(struct forces *forces, const struct forces_saved *saved);
void world_forces_saved_free(struct forces_saved *saved); /* takes NULL */
/* Waits for all forces that are being computed. */
enum status world_forces_wait(struct forces *forces) FURROW_CHECKED;
/* Tells the last known force on a body with a path; false: nobody asked for it. */
bool world_forces_known(const struct forces *forces, size_t body, struct world_force *force);
/* Says that the body touches nothing there. */
void world_forces_absent(struct forces *forces, size_t body, const struct event *event);
/* Waits for all forces that were asked for, and uses them, also in the record. */
enum status world_forces_settle(struct forces *forces, struct record *record) FURROW_CHECKED;
/* Uses the forces that are due at the end of a step. `until`: that time, s. */
enum status world_forces_end_step(struct forces *forces, double until) FURROW_CHECKED;

#endif
