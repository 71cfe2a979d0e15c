/* What the files of world share. Only the world's thread touches it. */
#ifndef FURROW_WORLD_INTERNAL_H
#define FURROW_WORLD_INTERNAL_H

#include "world/record.h"
#include "base/crew.h"
#include "world/model.h"

/* world.c: makes a world with nothing in it but its parameters. */
enum status world_make(const struct world_params *params, struct world **world) FURROW_CHECKED;

/* --- phase.c --- */
/* Enters a phase. The arrow from the present one must be in the table. */
void world_enter(struct world *world, enum world_phase to);
/* Returns the function that may lead from one phase to another; NULL: none may. */
const char *world_phase_arrow(enum world_phase from, enum world_phase to);
bool world_has_begun(const struct world *world); /* this run has changed the store, or is about to */
void world_return_to(struct world *world, bool begun); /* for world_rollback: to WORLD_STEPPING if the run had begun then, or WORLD_READY */

/* --- happened.c: what a watched world keeps of a step --- */
enum status world_happened_touch(struct world *world, const struct event *event, const struct contact_area *area) FURROW_CHECKED; /* a contact begins; only if somebody watches */
void world_happened_relaxes(struct world *world);                       /* it has ended; what changes now is relaxation */
enum status world_happened_change(struct world *world, struct tile tile) FURROW_CHECKED;
void world_happened_reach(struct world *world, double metres);
void world_happened_finish(struct world *world);

/* --- steps.c --- */
/* Ends a change of the ground. From now on it may be committed with the present record, and the numbers that were attached last. */
enum status world_end_change(struct world *world) FURROW_CHECKED;

enum status world_end_or_wait(struct world *world) FURROW_CHECKED; /* the same, unless numbers are attached: those come first */

/* --- stages.c --- */
/* The step that is made. */
struct step {
	double until; /* s: its end */
};
/* From now on time counts as that of this stage. Returns the stage before. */
enum world_stage world_stage_enter(struct world *world, enum world_stage stage);

/* --- resume.c --- */

/* Sets the world to the state of the store's last run of this scene. Call it after the bodies were made. */
enum status world_resume(struct world *world) FURROW_CHECKED;
void world_tell_unfinished(const struct world *world); /* prints a note that an unfinished run could be resumed, but is not */

/* age.c */
bool world_keeps_marks(const struct scene *scene); /* marks that fade */
/* Sets the store's time, in world->record. Call it after world_resume or world_tell_unfinished, which read the last record. STATUS_INPUT: the store is too old for such marks. */
enum status world_begin_age(struct world *world) FURROW_CHECKED;
enum status world_check_age(const struct world *world, double time) FURROW_CHECKED; /* the same, `time` s after the scene's start */
/* Returns how much of the cover below it a contact tears, 0 to PLANE_MARK_MOST; 0: the scene has no vegetation. */
int32_t world_torn(const struct world *world, const struct deform_contact *contact);
enum status world_fill_record(struct world *world) FURROW_CHECKED; /* steps.c */

/* --- ruts.c --- */

/* Finds world->facts.began: how deep the ruts in the store or overlay are, and prints a note about it. Does nothing if the drive is resumed. */
enum status world_find_ruts(struct world *world) FURROW_CHECKED;

/* --- drop.c: links the programs for bodies that a window drops, before the first step --- */
enum status world_warm_drops(struct world *world) FURROW_CHECKED;

/* --- bodies.c: the list of bodies --- */
/* Makes a body for each of the scene's objects, and the record. */
enum status world_make_bodies(struct world *world) FURROW_CHECKED;
void world_free_bodies(struct world *world); /* the world may have no bodies */
/* Adds a body that moves as `kind` says, and gives it the next number. `owned`: the object, if the body owns it, or NULL. On failure there is no body. */
enum status world_list_body(struct world *world, enum body_kind kind, const struct scene_object *object, struct scene_object *owned) FURROW_CHECKED;
void world_body_free(struct body *body); /* body may be NULL */
/* As world_body, for who changes the body. */
struct body *world_body_at(const struct world *world, size_t number);
/* Returns the body with this number if a host or a vehicle moves it; NULL: none does. */
struct body *world_body_hosted(const struct world *world, size_t number);
bool world_is_hosted(const struct body *body); /* a host or a vehicle moves it. NULL: false */
bool world_is_set_down(const struct body *body); /* a host or a vehicle has placed it, and has not removed it. NULL: false */
bool world_follows_path(const struct world *world, size_t number);

/* --- attitude.c --- */

/* Converts a pose that a host gave into a pose for deform, for this shape. STATUS_USAGE: a number is wrong, or the quaternion's
 * length is. `name`: the body's name, for messages. */
enum status world_attitude(const struct soil_shape *shape, const char *name, const struct furrow_pose *from, struct soil_pose *pose)
	FURROW_CHECKED;
/* Checks a state that a host gave, and finds its pose. STATUS_USAGE as world_attitude, or a velocity is neither finite nor all NaN. */
enum status world_state_check(const struct soil_shape *shape, const char *name, const struct furrow_state *state, struct soil_pose *pose)
	FURROW_CHECKED;
/* Returns how fast a wheel in this pose turns forwards about its axle, rad/s. angular: its angular velocity, rad/s. */
double world_spin(const struct soil_pose *pose, const double angular[3]);
/* Returns the number of the law by which soil bears in this world; 0: it does not. */
int world_law(const struct world *world);

/* --- rates.c --- */
/* Returns false if a velocity is all NaN, in place of that of the poses. */
bool world_rates_given(const double rate[3]);
/* Replaces velocities of `state` that were not given by those of the straight motion from a pose to that state. 0 s: they are 0. */
void world_rates_fill(const struct furrow_pose *from, double seconds, struct furrow_state *state);
/* For a round body whose host leaves its turns out of its poses. Returns how long its way to a state takes at the state's velocity, s. For others: 0.
 * Such a body turns as its angular velocity says, as in a step. */
double world_rates_unposed(const struct body *body, const struct furrow_state *state);
/* Moves a body to where its host set it for the step that begins, which takes `seconds`. Velocities are known afterwards. */
void world_rates_take(struct body *body, double seconds);

/* Computes the quaternion w, x, y, z of a pose. */
void world_orientation(const struct soil_pose *pose, double q[4]);

/* --- hosts.c: bodies of a host (a program that calls the library and moves bodies itself) --- */

#define WORLD_HOST_PAGES 4096 /* tiles that a host's bodies may change in one step */
#define WORLD_HOST_WAY 4096   /* posts that one such body may travel in one step */
/* --- names.c --- */
/* Returns the number of the body with this name; -1: there is none. */
int32_t world_names_find(struct world *world, const char *name);
/* Gives the first name body-N that is free. */
void world_names_next(struct world *world, char *name, size_t room);
void world_names_freed(struct world *world, const char *name); /* no body has this name any more */
void world_names_forget(struct world *world); /* bodies came and went in another way, as in a rollback */
void world_names_free(struct world *world);
/* --- host_steps.c --- */

/* Moves the host's bodies to the places that the host gave. The motion takes `seconds` and ends at time `until`. */
enum status world_hosts_step(struct world *world, double seconds, double until) FURROW_CHECKED;
/* Tells whether a contact ends at the pose of the last step. There the body leaves a dip, goes or slides back, or sinks after it slid. to, turned,
 * rotated: of the next step. */
bool world_turns_back(const struct world *world, const struct body *body, const struct soil_pose *to, double turned, const double rotated[3]);
/* Returns the shape of the hollow that a contact leaves. 1: an impression of the body, where it sank. 0: a flat rut, where it moved on. */
double world_stamp_after(const struct world *world, const struct body *body, const struct soil_pose *to);
void world_host_felt(struct world *world, size_t index, double time, const struct world_force *force); /* notes the force at a time, s */
void world_host_absent(struct world *world, size_t index); /* notes that the body touches nothing */
/* In told.c: gives the state of a body with a path. */
enum status world_path_state(const struct world *world, size_t body, struct furrow_state *state) FURROW_CHECKED;

/* --- probes.c --- */

/* Gives the rotation from one attitude to another as a vector, rad. */
void world_rotation_between(const double from[4], const double to[4], double rotated[3]);
/* Computes the contact at the body's present state. probed->known false: it is not known. */
enum status world_probes_now(struct world *world, int32_t number, struct soil_probed *probed) FURROW_CHECKED;
/* told.c: fills a contact from what a probe computed. */
void world_tell_probed(const struct world *world, const struct body *body, const struct furrow_state *state, const struct furrow_belt *belt, const struct soil_probed *probed,
		       double time, struct furrow_contact *contact);

/* --- changes.c --- */

void world_changes_begin(struct world *world);
/* Notes that these posts of a tile of the working level changed. */
enum status world_changed(struct world *world, struct tile tile, struct post_rect rect) FURROW_CHECKED;
void world_changes_end(struct world *world); /* ends a step: its changes get the next revision */
/* After a rollback: marks everything that changed after that revision as changed once more. */
void world_changes_rollback(struct world *world, uint64_t revision);
void world_changes_finish(struct world *world);

/* --- checkpoint.c --- */
/* The run's start was committed. If ground of it is what the opening has made (vehicles that were set down), a rollback to the opening returns to
 * that. Otherwise it returns to the store as it was before. */
enum status world_checkpoint_begun(struct world *world) FURROW_CHECKED;
void world_checkpoint_free(struct checkpoint *saved); /* saved may be NULL */

/* --- plan.c: facts that follow from the scene and the store --- */

/* Sets the working level in the store. STATUS_INPUT: the store has another working level, or cannot be deformed at this level. */
enum status world_settle_level(struct world *world) FURROW_CHECKED;
/* relief.c: sets the store's relief. STATUS_INPUT: the store was deformed over another, or the
 * ground becomes too high with it. */
enum status world_settle_relief(struct world *world) FURROW_CHECKED;
void world_relief_close(struct world_relief *relief); /* relief may be NULL */
/* Tells why the scene's relief raises nothing, if so. */
void world_advise_relief(const struct world *world, scene_advice_fn tell, void *user);
/* planet.c: sets world->facts.light; tells if pictures or vehicles are of another planet than the store. */
void world_settle_light(struct world *world);
void world_advise_planet(const struct world *world, scene_advice_fn tell, void *user);
/* Opens the map of soils, if the scene needs it. */
enum status world_open_soil_map(struct world *world) FURROW_CHECKED;
/* Gives the scene's roads as parts, in their order. The caller frees the list, even on failure. */
enum status world_road_parts(const struct world *world, struct road_part **list, size_t *count) FURROW_CHECKED;
/* --- numbers.c --- */
/* Opens the rasters of soil numbers, if the scene needs them, and checks what they hold. */
enum status world_open_rasters(struct world *world) FURROW_CHECKED;
/* STATUS_INPUT: with the least numbers of the rasters some soil does not bear this shape. */
enum status world_check_bearing(const struct world *world, const char *name, const struct soil_shape *shape) FURROW_CHECKED;
/* Tells the rasters whose values seem to be in a wrong unit. */
void world_advise_rasters(const struct world *world, scene_advice_fn tell, void *user);
/* --- soils_met.c --- */
/* Finds world->facts.met. Call it after world_make_bodies, before a thread reads the map. What cannot be read is left to the drive. */
enum status world_find_soils_met(struct world *world) FURROW_CHECKED;
void world_soils_met_free(struct world_soils_met *met); /* takes NULL */
/* Tells maps and rasters that cover nothing, values in no class, classes under no path, and loads that a soil does not carry. */
void world_advise_soils_met(const struct world *world, scene_advice_fn tell, void *user);
/* --- numbers.c --- */
/* Fills the rasters as deform takes them. Returns their number. Ranges are 0 while the rasters are not open. */
int world_rasters(const struct world *world, struct soil_raster *rasters);
/* Gives the numbers of the soil at the nearest post, as contacts read them there. *found false: outside of the terrain. */
enum status world_soil_numbers_at(struct world *world, double x, double y, struct soil_numbers *soil, bool *found) FURROW_CHECKED;

/* --- plan.c --- */
/* Fills the parameters of deform, except gpu, slots and reference. */
void world_deform_params(const struct world *world, struct deform_params *params);
struct deform_planned world_planned(const struct scene_object *object);
/* Returns how many bodies with a path make contacts that can be computed together. */
size_t world_batched_bodies(const struct world *world, const struct deform_params *params);
struct deform_planned world_planned_host(const struct soil_shape *shape); /* a body that a host moves */
/* Fills the parameters of pages, except store, gpu, slots, and the sums so far. */
void world_pages_params(const struct world *world, struct pages_params *params);

bool world_deforms(const struct world *world); /* true if bodies change the ground, or bodies of a host may */
/* STATUS_INPUT: one window of this shape touches more tiles than there are slots, or more than can be pinned together. */
enum status world_shape_budget(struct world *world, const char *name, const struct soil_shape *shape) FURROW_CHECKED;
/* --- budget.c: most pages that one step can touch; bounds the queue --- */
uint32_t world_step_pages(const struct world *world);
/* Returns the slots that the scene's objects need at least. */
size_t world_least_slots(const struct world *world);

/* --- limits.c: how many tiles the world keeps in memory --- */

/* Sets world->facts.limits. Call it after world_make_bodies. STATUS_INPUT: cache.memory is too little; the message has the least. */
enum status world_settle_limits(struct world *world) FURROW_CHECKED;
/* plan.c: returns the metres along the ground that the object has come at `time`; NAN: out of memory. */
double world_way_at(const struct track *track, double time);
void world_advise_samples(const struct world *world, scene_advice_fn tell, void *user); /* samples.c */
/* budget.c: returns how many bytes images of changed pages may take: half of the usable memory that all other tiles leave. 0: it is not known. */
uint64_t world_queue_bytes(const struct world *world, const struct pages_params *params);
/* Pages that bodies lie on at one time, in the mean over where tiles begin. */
uint32_t world_work_pages(const struct world *world);
/* Returns the number of all tiles of the working level and of coarser ones. In plan.c. */
double world_all_tiles(const struct world *world);
/* Tells if bodies lie on more tiles than there are slots. */
void world_advise_limits(const struct world *world, scene_advice_fn tell, void *user);
/* Raises the limits for one more body of a host. */
enum status world_limits_add(struct world *world, const struct soil_shape *shape) FURROW_CHECKED;

/* --- events.c --- */

/* Collects the events of the step that ends at `until`, of bodies here. They are sorted by time; at equal times, by the order in the scene.
 * agreed: all ranks make this step, also if the drive is to end; false: then it gives STATUS_INTERRUPTED. */
enum status world_collect_events(struct world *world, double until, bool agreed) FURROW_CHECKED;
/* Places the body on the ground at a path sample. Fills pose, contact, distance and sinkage of `event`. */
enum status world_set_down(struct world *world, struct body *body, int64_t sample, struct event *event) FURROW_CHECKED;

/* --- surface.c: what the GPU computes (deform) and what the CPU computes (bearing) behind one face --- */

/* Makes world->deform or world->bearing, if bodies change the ground. */
enum status world_surface_create(struct world *world, const struct deform_params *params) FURROW_CHECKED;
void world_surface_destroy(struct world *world);
/* The same as the functions of deform.h and bearing.h. */
enum status world_wake(struct world *world, struct post_rect changed) FURROW_CHECKED;
struct post_rect world_wakes(const struct world *world, struct post_rect changed);
enum status world_forget_active(struct world *world) FURROW_CHECKED;
int64_t world_interval_rim(const struct world *world);
int64_t world_contact_reach(const struct world *world, const struct soil_shape *shape);
/* Sets where a loaded body that is in contact rests, fixed-point units above its pose. Does nothing for others. */
void world_set_equilibrium(struct world *world, const struct body *body, int64_t raised);
enum status world_restore_tally(struct world *world, const struct deform_tally *tally) FURROW_CHECKED;

/* --- relaxation.c: relaxation of the whole ground --- */

int64_t world_intervals_by(const struct world *world, double time); /* number of intervals that are over then */
/* If undisturbed ground may slide: makes all blocks of the ground active, so that relaxation looks at all of it. Called at the
 * start. world_budget_check bounds their number. */
enum status world_wake_all(struct world *world) FURROW_CHECKED;
/* Sets the count of relaxation intervals to those until `time`. Called at the scene's start and on resume. */
void world_intervals_from(struct world *world, double time);
/* Runs all relaxation intervals before `time`. If `at_it`, also the one that is due exactly at `time`. */
enum status world_intervals(struct world *world, double time, bool at_it) FURROW_CHECKED;
size_t world_rests(const struct world *world); /* lists the bodies on the ground in world->relaxation.rests; returns how many there are */
/* The body no longer rests there: the ground under it may relax again. */
enum status world_let_go(struct world *world, struct body *body) FURROW_CHECKED;

/* --- carried.c: soil aboard bodies --- */

/* Lets a body carry soil if its object has `carry`. */
enum status world_carried_make(struct world *world, struct body *body) FURROW_CHECKED;
bool world_carried_unsettled(const struct world *world); /* soil aboard may go on sliding, or is to be put down */
/* Lets soil aboard all bodies settle. rests: how many bodies world->relaxation.rests lists. */
enum status world_carried_settle(struct world *world, double time, size_t rests) FURROW_CHECKED;
/* Adds the weight of what a body carries to a force, N, and a moment about its centre, N m. world_carried_load: the weight alone, N. */
void world_carried_force(const struct world *world, const struct body *body, double force[3], double moment[3]);
double world_carried_load(const struct world *world, const struct body *body);
struct world_aboard world_aboard_of(const struct world *world, const struct body *body); /* as world_aboard; body may be NULL */
/* Adds the plan's line of the memory for soil aboard; none where no object carries. */
void world_carried_plan(const struct world *world, struct plan *plan);
/* Numbers of a record: how many there are, to it, and from it after bodies have theirs. */
size_t world_carried_numbers(const struct world *world);
void world_carried_record(const struct world *world, struct record *record);
enum status world_carried_resume(struct world *world) FURROW_CHECKED;
/* Gives all ranks the soil aboard bodies of vehicles, at the end of a step. */
enum status world_carried_tell(const struct world *world) FURROW_CHECKED;
/* For a checkpoint. */
struct carried_saved;
enum status world_carried_save(const struct world *world, struct carried_saved ***out, size_t *count) FURROW_CHECKED;
void world_carried_restore(struct world *world, struct carried_saved *const *saved, size_t count);
void world_carried_saved_free(struct carried_saved **saved, size_t count);
/* --- thrown.c: soil in flight. Where the scene throws none, world->thrown is NULL, and these do nothing --- */

#define WORLD_THROWN_TICKS 64   /* in a second: then grains are looked at */
/* Makes world->thrown if the scene throws soil. */
enum status world_thrown_make(struct world *world) FURROW_CHECKED;
void world_thrown_plan(const struct world *world, struct plan *plan);
void world_thrown_free(struct thrown *thrown);
bool world_thrown_flies(const struct world *world); /* soil is in flight */
/* Adds grains that left by now, the time until which grains have flown. What has no room flies with the last one. Needs world->thrown. */
void world_thrown_add(struct world *world, const struct bearing_grain *grains, size_t count);
/* Lets fly what a contact at this time, s, threw. */
void world_thrown_take(struct world *world, double time, const struct bearing_contact *contact);
/* Lets grains fly, and those land that meet the ground, until before `time`, or with `at_it` until then. Needs world->thrown. */
enum status world_thrown_until(struct world *world, double time, bool at_it) FURROW_CHECKED;
void world_thrown_from(struct world *world, double time); /* all before this time, s, is over: at the start, and when resumed */
void world_thrown_record(const struct world *world, struct record *record);
enum status world_thrown_resume(struct world *world) FURROW_CHECKED; /* from world->record */
/* For a checkpoint. *out is freed by mem_free; NULL: nothing is thrown. */
struct thrown_saved;
enum status world_thrown_save(const struct world *world, struct thrown_saved **out) FURROW_CHECKED;
void world_thrown_restore(struct world *world, const struct thrown_saved *saved);

/* Counts soil as thrown, by class. Needs world->thrown. */
void world_thrown_count(struct world *world, const int64_t classes[SOIL_CLASSES]);

/* --- falls.c: soil that falls off bodies, or onto them --- */
/* Lets what left a body fly. pose, time: of the body then, s. body may be NULL. */
void world_falls_take(struct world *world, struct body *body, const struct soil_pose *pose, double time);
/* Tells whether a grain comes down on a body that carries, on its way between two places, 2^-20 m. Then it is aboard after world_falls_aboard. */
bool world_falls_caught(struct world *world, const int64_t before[3], const int64_t now[3], int64_t volume);
void world_falls_aboard(struct world *world, int class);

/* --- ranks.c --- */
/* Returns the posts that so many intervals may read or change because these changed. */
struct post_rect world_slides_from(const struct world *world, struct post_rect changed, int64_t intervals);

/* --- near.c: bodies near each other --- */

/* Lists the bodies, with all places of this step's events. Call it when a step has its events. */
enum status world_near_make(struct world *world) FURROW_CHECKED;
/* Lists them for probes, these hosts' bodies in these states. After the probes call world_near_end. */
enum status world_near_begin(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states) FURROW_CHECKED;
void world_near_end(struct world *world);
/* Puts the bodies that are over these posts now into world->near.found, in their order. */
void world_near_find(struct world *world, struct post_rect rect);
/* Tells whether a body is at rest at a time, so that no soil may be laid or slide into it (kinematic models). One that moves lowers the ground below it again.
 * It follows from a body's path alone, or of a host's body from its last contact. So it is the same for any time step, in a drive that goes on, and on all
 * ranks. A body that was at rest is no longer so from a contact of its own on. */
bool world_is_at_rest(const struct body *body, double time);
/* Tells whether a body may be so in this drive. */
bool world_has_rests(const struct world *world);
/* Tells a contact of a kinematic model which other bodies at rest lie over these posts. STATUS_MEMORY. */
enum status world_near_beside(struct world *world, const struct event *event, struct post_rect rect, struct deform_contact *contact) FURROW_CHECKED;
void world_near_free(struct near_table *near);

/* --- contact.c: the deformation by one contact --- */

#define WORLD_TILES_MOST PAGE_PIN_MOST /* most tiles that are pinned together */
struct held_tiles {
	struct tile_slot tiles[WORLD_TILES_MOST];
	uint64_t keys[WORLD_TILES_MOST];
	size_t count;
};
size_t world_tiles_in(const struct world *world, struct post_rect rect); /* returns how many tiles have a post in the rectangle */
/* Pins all tiles that have a post in the rectangle. After a failure none is pinned. */
enum status world_hold(struct world *world, struct post_rect rect, struct held_tiles *held) FURROW_CHECKED;
/* The same of tiles as this rank has them, which another rank may have changed. */
enum status world_hold_own(struct world *world, struct post_rect rect, struct held_tiles *held) FURROW_CHECKED;
enum status world_hold_tile(struct world *world, struct tile tile, struct held_tiles *held) FURROW_CHECKED;
void world_release(struct world *world, struct held_tiles *held);
/* Marks the posts of the rectangle as changed in the held tiles: pages, coarser levels, queries and pictures learn of it. */
enum status world_mark(struct world *world, struct post_rect rect, const struct held_tiles *held) FURROW_CHECKED;
/* Computes one contact. world_contact_or_wait: it may wait until world_batches_flush; the event must stay valid until then. */
enum status world_contact(struct world *world, const struct event *event) FURROW_CHECKED;
enum status world_contact_or_wait(struct world *world, const struct event *event) FURROW_CHECKED;
/* Note, if somebody watches, that a contact begins to change the ground, and that it has ended. */
enum status world_tell_contact(struct world *world, const struct event *event, const struct deform_contact *contact,
			       const struct deform_window *windows, size_t count) FURROW_CHECKED;
/* Counts windows of a contact that were computed alone. */
void world_count_windows(struct body *body, const struct deform_contact *contact, size_t computed);

/* kinematic.c: computes one contact of a kinematic model on the CPU. `last`: as in world_contact. */
enum status world_kinematic_contact(struct world *world, const struct event *event, struct deform_contact *contact) FURROW_CHECKED;
/* A body leaves its pose, rest->from, over an elastic sheet, which comes back. Changes the ground. world_kinematic_leave: computed on the CPU.
 * world_contact_leave: on the GPU. */
enum status world_kinematic_leave(struct world *world, const struct deform_contact *rest) FURROW_CHECKED;
enum status world_contact_leave(struct world *world, struct body *body, const struct deform_contact *rest) FURROW_CHECKED;

/* Computes the forces on a host's body without changing the ground. */
enum status world_feel(struct world *world, const struct event *event) FURROW_CHECKED;

/* Returns the blocks on which posts of a window lie that may begin beyond the world. Contacts that share no block share no post. */
static inline struct post_rect world_blocks_of(struct post_rect rect)
{
	rect.x0 = rect.x0 > 0 ? rect.x0 : 0;
	rect.y0 = rect.y0 > 0 ? rect.y0 : 0;
	return soil_slide_blocks(rect);
}

static inline uint64_t world_block_key(int64_t x, int64_t y)
{
	return (uint64_t)y << 32 | (uint64_t)x;
}

/* --- batch.c: contacts that wait, to be computed together --- */

enum status world_batches_create(struct world *world) FURROW_CHECKED; /* makes none if the scene's contacts are computed alone */
void world_batches_free(struct world *world);
/* *taken: the contact waits. If it cannot wait, all that may share a post with it are computed first. Needs world->batches. */
enum status world_batches_take(struct world *world, const struct event *event, const struct deform_contact *contact,
			       const struct deform_window *windows, size_t count, bool *taken) FURROW_CHECKED;
/* Computes all contacts that wait. world_batches_flush_near: if one of them may share a post with these windows. */
enum status world_batches_flush(struct world *world) FURROW_CHECKED;
enum status world_batches_flush_near(struct world *world, const struct deform_window *windows, size_t count) FURROW_CHECKED;
void world_batches_forget(struct world *world); /* drops what a step that failed left */

/* --- crew.c: threads that compute contacts and regions of soil that bears --- */

#define WORLD_CREW_THREAD "furrow-soil"
size_t world_crew_members(const struct world *world); /* threads, with the one that steps. Does not need world->bearing */
enum status world_crew_create(struct world *world) FURROW_CHECKED; /* call it when world->bearing is known; makes none where one thread is enough */
void world_crew_plan(const struct world *world, struct plan *plan);
/* Returns how many groups or regions are to be computed at once, if so many posts are read. */
size_t world_hands_for(const struct world *world, double posts);
enum status world_crew_run(struct world *world, size_t count, crew_task_fn task, void *user) FURROW_CHECKED;

/* --- meet.c: contacts with soil that bears, which meet the ground together --- */

enum status world_meetings_create(struct world *world) FURROW_CHECKED; /* call it when world->bearing is known */
void world_meetings_free(struct world *world);
/* Notes a contact, or, with `feels`, a contact whose forces alone are asked. It waits for world_meetings_flush. */
enum status world_meetings_add(struct world *world, const struct event *event, const struct deform_contact *contact, const struct bearing_area *area,
			       bool feels) FURROW_CHECKED;
/* Computes all contacts that wait. */
enum status world_meetings_flush(struct world *world) FURROW_CHECKED;
void world_meetings_forget(struct world *world); /* drops what a step that failed left */

/* --- aloft.c: finds contacts where the body is above the ground --- */

/* Returns true if the GPU must tell which posts a contact touched: the model moves soil, and a body may be above it. */
bool world_asks_touched(const struct world *world);
/* Returns a height in 2^-20 m. No part of the body is below it during the contact. */
int64_t world_lowest(const struct deform_contact *contact);
/* Notes if a held tile has planes from before this world. Call this before the tile is changed. */
enum status world_see(struct world *world, const struct tile_slot *held) FURROW_CHECKED;
/* Sets *aloft to true if the contact would change nothing, so its windows need not be computed. Sets the contact's `above`. May
 * pin tiles for a while. */
enum status world_is_aloft(struct world *world, const struct event *event, struct deform_contact *contact,
			   const struct deform_window *windows, size_t count, bool *aloft) FURROW_CHECKED;

/* --- forces.c; `forces` may be NULL: no forces are computed --- */

enum status world_forces_create(struct world *world, struct forces **out) FURROW_CHECKED; /* *out is NULL if nothing needs forces */
void world_forces_destroy(struct forces *forces);
/* Writes the rows of objects.csv that are due before `until` (with `inclusive`, also at `until`). The rows have the forces that
 * are known so far. Call it before an event. */
enum status world_forces_rows(struct forces *forces, double until, bool inclusive) FURROW_CHECKED;
/* Takes the rows of bodies on paths that are due before `until`, and leaves those of vehicles. Call it before soil aboard changes between events: a row has the
 * weight of what is aboard at its time. */
enum status world_forces_early(struct forces *forces, double until) FURROW_CHECKED;
/* Takes the forces that bearing soil told at this event. world_forces_met: of a model that tells none. */
void world_forces_felt(struct forces *forces, size_t body, const struct event *event, const struct deform_forces *from);
void world_forces_met(struct forces *forces, size_t body, const struct event *event);
/* Returns true if the scene's model computes forces. */
bool world_feels(const struct world *world);
/* told.c: the force on a body at this height that touches nothing. */
struct world_force world_no_force(int64_t z);
enum furrow_contact_state world_contact_state_of(enum deform_state state);
/* Copies the state of the forces, for a checkpoint. If `forces` is NULL, *out is NULL. */
struct forces_saved;
enum status world_forces_save(const struct forces *forces, struct forces_saved **out) FURROW_CHECKED;
void world_forces_restore(struct forces *forces, const struct forces_saved *saved);
void world_forces_saved_free(struct forces_saved *saved); /* saved may be NULL */
/* work.c: returns the work that a body does on the soil on its way between two poses, J, by the means of force and moment. Any thread. */
double world_work_between(const struct soil_pose *from, const struct world_force *before, const struct soil_pose *to, const struct world_force *after);
/* For world_body_pack and world_body_unpack. A body that is packed has no rows here until it is unpacked. */
void world_forces_pack(const struct forces *forces, size_t body, struct world_moved *moved);
void world_forces_unpack(struct forces *forces, size_t body, const struct world_moved *moved);
/* Gives the last known force on a body with a path. Returns false if its forces were never computed. */
bool world_forces_known(const struct forces *forces, size_t body, struct world_force *force);
/* Gives what the record has to keep. Leaves it as it is for a body that another rank has. */
void world_forces_record(const struct forces *forces, size_t body, struct world_force *force);
/* Notes that the body touches nothing in this event. */
void world_forces_absent(struct forces *forces, size_t body, const struct event *event);
/* Gives the rows of a step, and applies its forces. `until`: time of its end, s. */
enum status world_forces_end_step(struct forces *forces, double until) FURROW_CHECKED;

#endif
