/*
 * Goes on from the store's last drive of the same scene.
 *
 * Nearly all of a record follows from the time of its step. That is, which path samples are done, and where the last one set
 * the object down. A record that says otherwise was not written by a drive of this scene.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define EQUILIBRIUM_MOST (INT64_C(1) << 31) /* 2^-20 m from the guessed height of a loaded body */

/* Equal within a few fixed-point units, far less than a post. A contact swept from there must fit the budget too. */
static bool near(int64_t a, int64_t b)
{
	return a > b - 16 && a < b + 16;
}

static enum status check_object(struct world *world, struct body *body, const struct record_object *object)
{
	const struct record *record = world->record;
	const char *store = world->facts.path;
	struct event event = {.time = 0};
	if (body->kind != BODY_PATH) /* a host's: it begins anew */
		return object->next == 0 && !object->has_last ? STATUS_OK : world_record_damaged(store, "a path of a body that has none");
	if (record->step == 0 && object->next == 0)
		return object->has_last ? world_record_damaged(store, "contact before the first step") : STATUS_OK;
	int64_t samples = motion_track_samples(body->track);
	if (object->next > samples || (object->next > 0 && motion_track_sample_time(body->track, object->next - 1) > record->time) ||
	    (object->next < samples && motion_track_sample_time(body->track, object->next) <= record->time))
		return world_record_damaged(store, "path samples that are not those of its time");
	if (object->next == 0)
		return object->has_last ? world_record_damaged(store, "contact before the first path sample") : STATUS_OK;
	TRY(world_set_down(world, body, object->next - 1, &event));
	/* Not compared bit for bit: another machine's mathematics may have made it. */
	const struct soil_pose *pose = &event.pose, *last = &object->last;
	if (object->has_last != event.contact || (event.contact && !(near(last->x, pose->x) && near(last->y, pose->y) && near(last->z, pose->z))))
		return world_record_damaged(store, "an object is not where its path was");
	if (body->loaded_body > 0 && event.contact && (object->force.z <= last->z - EQUILIBRIUM_MOST ||
						       object->force.z >= last->z + EQUILIBRIUM_MOST))
		return world_record_damaged(store, "an object stands where it cannot");
	return STATUS_OK;
}

static enum status check(struct world *world)
{
	const struct record *record = world->record;
	const char *store = world->facts.path;
	/* An earlier end_time may have cut the last step short. */
	double whole = (double)record->step * world->scene->time_step;
	if (!world->scene->hosted && world_steps_until(world->scene, record->time) != (double)record->step &&
	    fabs(record->time - whole) > 1e-12 * whole)
		return world_record_damaged(store, "its step and its time do not agree");
	if (record->level != world->resident.level)
		return world_record_damaged(store, "its level is not the store's");
	const struct extent *extent = &world->resident.meta->extent;
	int64_t width = extent_posts(extent->width, world->resident.level), height = extent_posts(extent->height, world->resident.level);
	for (size_t i = 0; i < record->active_count; i++)
		if (record->active[i].x >= (width + SOIL_BLOCK - 1) / SOIL_BLOCK || record->active[i].y >= (height + SOIL_BLOCK - 1) / SOIL_BLOCK)
			return world_record_damaged(store, "what was awake lies beyond the ground");
	if (record->active_count > 0 && (!world_deforms(world) || !deform_conserves(world->scene->model)))
		return world_record_damaged(store, "something is awake that cannot be");
	for (size_t i = 0; i < world->scene->object_count; i++)
		TRY(check_object(world, world->bodies[i], &record->objects[i]));
	return STATUS_OK;
}

static void restore(struct world *world)
{
	const struct record *record = world->record;
	world->facts.resumed.is = true;
	world->step = record->step;
	world->time = record->time;
	/* The scene ends later now: its last step is done to its full length. */
	if (!world->scene->hosted && record->step > 0 && record->time < world_step_time(world->scene, record->step) * (1 - 1e-12))
		world->step--;
	world->facts.resumed.from = world->step;
	world->facts.resumed.time = world->time;
	const int64_t total = world->scene->hosted ? INT64_MAX : world_step_count(world); /* a host decides how far it goes */
	world->facts.resumed.nothing_left = world->step > total || (world->step == total && record->ended);
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct record_object *object = &record->objects[i];
		struct body *body = world->bodies[i];
		if (body->kind != BODY_PATH)
			continue;
		body->next = object->next;
		body->has_last = object->has_last;
		body->last = object->last;
		body->trend = object->trend;
		body->distance = object->distance;
		body->sinkage = object->sinkage;
		body->equilibrium = object->force.z;
		body->raised = body->loaded_body > 0 && object->has_last ? object->force.z - object->last.z : 0;
		body->skipped = object->skipped;
	}
}

int world_law(const struct world *world)
{
	return deform_tells_forces(world->scene->model) ? SOIL_LAW : 0;
}

/* Returns true if `run` is of this scene and its record can be read. *ended: whether it came to its end. */
static bool is_of_this_scene(const struct world *world, const struct store_run *run, bool *ended)
{
	const size_t attached = world->params.attached;
	struct record *record = mem_calloc(1, world_record_bytes_of(world->record, world->scene->object_count));
	for (size_t i = 0; record != NULL && i < world->scene->object_count; i++)
		record->objects[i].carried = world->record->objects[i].carried;
	if (record != NULL) {
		record->attached_count = attached;
		record->carried_count = world->record->carried_count;
		record->thrown.room = world->record->thrown.room;
	}
	const bool is = record != NULL && run->scene_hash != NULL && strcmp(run->scene_hash, world->scene->hash) == 0 &&
			world_record_parse(run, world->facts.path, world->scene, record) == STATUS_OK &&
			record->law == world_law(world);
	*ended = is && record->ended;
	mem_free(record);
	return is;
}

void world_tell_unfinished(const struct world *world)
{
	struct store_run run;
	bool ended;
	if (store_last_run(world->resident.store, &run) == STATUS_OK && run.step > 0 && is_of_this_scene(world, &run, &ended) && !ended)
		note("%s: this scene was driven to step %lld there and not to its end; it begins anew, over those ruts "
		     "(--resume would go on)", world->facts.path, (long long)run.step);
}

/* Returns true if nothing was driven in an overlay, and its parent's drive cannot go on there. That drive is of another scene, or has no step
 * left. */
static bool begins_anew(struct world *world, const struct store_run *run)
{
	bool ended;
	if (!store_run_inherited(world->resident.store))
		return false;
	if (strcmp(run->scene_hash, world->scene->hash) != 0)
		return true;
	return !world->scene->hosted && run->step >= world_step_count(world) && is_of_this_scene(world, run, &ended) && ended;
}

enum status world_resume(struct world *world)
{
	int64_t revision;
	const char *store = world->facts.path, *over = store_parent(world->resident.store, &revision);
	struct store_run run;
	if (world->params.ranks != NULL && over != NULL) /* a rank's part lies over the run's overlay, which the user knows */
		store = over;
	TRY(store_last_run(world->resident.store, &run));
	if (run.scene_hash == NULL) {
		note("%s: nothing was driven there; begins at step 0", store);
		return STATUS_OK;
	}
	if (begins_anew(world, &run)) {
		note("%s: nothing was driven there: the drive that it begins with is of another scene, or has ended; begins at step 0, over its ruts", store);
		return STATUS_OK;
	}
	if (strcmp(run.scene_hash, world->scene->hash) != 0)
		return fail_with(STATUS_INPUT, "%s: its last drive, to step %lld, was of another scene, or of this one with other values "
				 "(%.8s, not %.8s); resume with the same scene and the same --set, or drive without --resume: it then goes "
				 "over those ruts", store, (long long)run.step, run.scene_hash, world->scene->hash);
	TRY(world_record_parse(&run, store, world->scene, world->record));
	if (world->record->law != world_law(world))
		return fail_with(STATUS_INPUT, "%s: its last drive was made by a furrow whose soil bears otherwise, so it would not go on as it began; resume "
				 "it with that, or drive without --resume: it then goes over those ruts", store);
	TRY(check(world));
	TRY(world_carried_resume(world));
	TRY(world_thrown_resume(world));
	restore(world);
	if (world->facts.resumed.nothing_left)
		note("%s: this scene was driven to step %lld, %g s, already; nothing is left to do", store,
		     (long long)run.step, run.time);
	return STATUS_OK;
}
