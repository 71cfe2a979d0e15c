/*
 * Probes: what the soil would do to bodies of the host, by a mirror of the ground under each of them.
 *
 * A body has a mirror from its first probe on. At the end of a step it is read again where a contact or sliding soil changed it, or the
 * body moved on. So a probe between two steps computes on the CPU alone.
 *
 * Invariant: a mirror that is not stale holds the ground as the last step left it. It reaches MARGIN posts beyond the body's last pose.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define MARGIN 2 /* working posts by which a probed state may lie beside the last pose */
#define SPARE 2  /* posts that are read beyond these, so that not every contact needs other posts */

void world_probes_changed(struct world *world, struct post_rect rect)
{
	if (world->hosts.mirrors > 0)
		world_touched_note(&world->hosts.touched, rect);
}

static void find_stale(struct world *world)
{
	struct world_touched *touched = &world->hosts.touched;
	if (touched->count == 0 && !touched->all)
		return;
	world_touched_sort(touched);
	for (size_t i = 0; i < world->hosts.count; i++) {
		struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->mirror.patch != NULL && world_touched_meets(touched, deform_patch_rect(host->mirror.patch)))
			host->mirror.stale = true;
	}
	world_touched_clear(touched);
}

static bool has(struct post_rect outer, struct post_rect inner)
{
	return inner.x0 >= outer.x0 && inner.y0 >= outer.y0 && inner.x1 <= outer.x1 && inner.y1 <= outer.y1;
}

/* Gives the pose around which the ground is mirrored. Returns false if the body has none, or is gone. */
static bool place_of(const struct host_body *host, struct soil_pose *pose)
{
	if (!host->placed || host->removed ||
	    world_attitude(&host->body.object->shape, host->body.object->name, &host->now.pose, pose) != STATUS_OK)
		return false;
	return true;
}

static bool fits(const struct world *world, struct post_rect rect)
{
	struct tile first, last;
	if (rect.x1 - rect.x0 > DEFORM_WINDOW_POSTS || rect.y1 - rect.y0 > DEFORM_WINDOW_POSTS)
		return false;
	if (!tile_range_of(&world->meta->extent, world->level, rect, &first, &last))
		return true;
	const size_t tiles = (size_t)(last.x - first.x + 1) * (last.y - first.y + 1);
	return tiles <= world->windows.tiles;
}

/* Begins to read the ground under a body, if what the mirror has is not it. */
static enum status begin(struct world *world, struct host_body *host)
{
	struct host_mirror *mirror = &host->mirror;
	struct soil_pose pose;
	struct held_tiles held = {.count = 0};
	if (!place_of(host, &pose)) {
		deform_patch_forget(mirror->patch);
		return STATUS_OK;
	}
	const struct soil_shape *shape = &host->body.object->shape;
	const struct post_rect needed = deform_probe_posts(world->deform, shape, &pose, MARGIN), had = deform_patch_rect(mirror->patch);
	const struct post_rect more = deform_probe_posts(world->deform, shape, &pose, MARGIN + SPARE);
	const bool holds = !post_rect_empty(had) && has(had, needed);
	if (holds && !mirror->stale)
		return STATUS_OK;
	const struct post_rect rect = holds ? had : more;
	if (!fits(world, rect)) {
		deform_patch_forget(mirror->patch);
		return STATUS_OK;
	}
	enum status status = world_hold(world, rect, &held);
	if (status == STATUS_OK)
		status = deform_patch_begin(mirror->patch, rect, held.tiles, held.count);
	world_release(world, &held);
	return status;
}

static enum status land(struct host_body *host)
{
	enum status status = deform_patch_land(host->mirror.patch, host->mirror.anew);
	host->mirror.stale = status != STATUS_OK;
	host->mirror.anew = host->mirror.anew && status != STATUS_OK;
	return status;
}

enum status world_probes_refresh(struct world *world)
{
	enum status status = STATUS_OK;
	find_stale(world);
	for (size_t i = 0; i < world->hosts.count && status == STATUS_OK; i++) {
		struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->mirror.patch != NULL && !host->body.elsewhere)
			status = begin(world, host);
	}
	for (size_t i = 0; i < world->hosts.count && status == STATUS_OK; i++) {
		struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->mirror.patch != NULL && !host->body.elsewhere)
			status = land(host);
	}
	return status;
}

void world_probes_free(struct world *world)
{
	for (size_t i = 0; i < world->hosts.count; i++) {
		struct host_body *host = world->hosts.list[i];
		if (host == NULL)
			continue;
		deform_patch_destroy(host->mirror.patch);
		host->mirror.patch = NULL;
	}
}

/* --- probing --- */

void world_rotation_between(const double from[4], const double to[4], double rotated[3])
{
	/* to * conjugate(from) */
	double w = to[0] * from[0] + to[1] * from[1] + to[2] * from[2] + to[3] * from[3];
	double v[3] = {-to[0] * from[1] + to[1] * from[0] - to[2] * from[3] + to[3] * from[2],
		       -to[0] * from[2] + to[2] * from[0] - to[3] * from[1] + to[1] * from[3],
		       -to[0] * from[3] + to[3] * from[0] - to[1] * from[2] + to[2] * from[1]};
	const double sine = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), sign = w < 0 ? -1 : 1;
	const double by = sine > 0 ? 2 * atan2(sine, sign * w) / sine * sign : 0;
	for (int k = 0; k < 3; k++)
		rotated[k] = by * v[k];
}

/* Poses are rounded; a probe is of the very place, to 2^-40 m. So its height above any post is exact, whatever else the mirror holds. */
static void put_beyond(const struct world_pose *pose, struct deform_probe *probe)
{
	const int64_t place[3] = {probe->to.x, probe->to.y, probe->to.z};
	for (int k = 0; k < 3; k++)
		probe->beyond[k] = rint((pose->position[k] - lattice_offset_metres(place[k])) * 0x1p40) * 0x1p-40;
}

static void motion_of(const struct host_body *host, const struct world_state *state, const struct soil_pose *now,
		      const struct soil_pose *to, struct deform_probe *probe)
{
	const struct scene_object *object = host->body.object;
	*probe = (struct deform_probe){
		.shape = &object->shape,
		.interface = object->interface,
		.from = host->body.in_contact && !host->fresh ? host->body.last : *to,
		.to = *to,
		.stamped = host->stamped,
		.turned = host->turned + remainder(to->turn - now->turn, 2 * M_PI),
	};
	if (object->shape.belt) {
		const struct world_belt *belt = world_belt_of(host, state);
		probe->turned = host->body.in_contact && !host->fresh ? belt->travel - host->body.last.turn : 0;
		probe->runs = belt->speed;
	}
	world_rotation_between(host->now.pose.orientation, state->pose.orientation, probe->rotated);
	for (int k = 0; k < 3; k++)
		probe->rotated[k] += host->rotated[k];
	put_beyond(&state->pose, probe);
	memcpy(probe->linear, state->linear, sizeof probe->linear);
	memcpy(probe->angular, state->angular, sizeof probe->angular);
}

static enum status probe_host(const struct world *world, const struct host_body *host, const struct world_state *state,
			      struct deform_probed *probed)
{
	const struct scene_object *object = host->body.object;
	struct soil_pose to, now;
	struct deform_probe probe;
	probed->known = false;
	enum status status = world_state_check(&object->shape, object->name, state, &to);
	if (status != STATUS_OK || host->mirror.patch == NULL || host->mirror.stale || world->torn || !place_of(host, &now))
		return status;
	motion_of(host, state, &now, &to, &probe);
	deform_probe(host->mirror.patch, &probe, probed);
	return STATUS_OK;
}

void world_probes_reach(struct host_body *host, const struct soil_pose *to)
{
	struct deform_probe probe = {.shape = &host->body.object->shape, .from = *to, .to = *to};
	put_beyond(&host->now.pose, &probe);
	if (host->mirror.patch != NULL)
		deform_patch_reach(host->mirror.patch, &probe);
}

bool world_probes_now(const struct world *world, const struct host_body *host, struct deform_probed *probed)
{
	probed->known = false;
	return host->placed && probe_host(world, host, &host->now, probed) == STATUS_OK && probed->known;
}

static struct host_body *probed_host(const struct world *world, int32_t number)
{
	struct host_body *host = world_feels(world) ? world_host_body(world, number) : NULL;
	return host != NULL && !host->removed ? host : NULL;
}

bool world_probe_reads(const struct world *world, size_t count, const int32_t *numbers)
{
	for (size_t i = 0; i < count; i++) {
		const struct host_body *host = probed_host(world, numbers[i]);
		if (host != NULL && host->placed && !world->torn && (host->mirror.patch == NULL || host->mirror.stale))
			return true;
	}
	return false;
}

/* Mirrors the ground under a body that was not probed before, or was placed or rolled back since. */
static enum status need_mirror(struct world *world, struct host_body *host)
{
	struct host_mirror *mirror = &host->mirror;
	enum status status = STATUS_OK;
	if (!host->placed || world->torn || (mirror->patch != NULL && !mirror->stale))
		return STATUS_OK;
	if (mirror->patch == NULL) {
		status = deform_patch_create(world->deform, &mirror->patch);
		world->hosts.mirrors += status == STATUS_OK;
	}
	mirror->stale = true;
	if (status == STATUS_OK)
		status = begin(world, host);
	return status == STATUS_OK ? land(host) : status;
}

/* Checks a state whose contact is unknown. */
static enum status check(const struct world *world, int32_t number, const struct world_state *state)
{
	const struct host_body *host = world_host_body(world, number);
	const struct scene_object *object = host != NULL ? host->body.object : world->bodies[number].object;
	struct soil_pose pose;
	return world_state_check(&object->shape, object->name, state, &pose);
}

enum status world_probe(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states,
			struct world_contact *contacts)
{
	const struct world_ranks *ranks = world->ranks;
	enum status status = STATUS_OK;
	if (ranks != NULL && world->unplaced)
		status = ranks->step(ranks->user, world->time, status);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct host_body *host = probed_host(world, numbers[i]);
		struct deform_probed probed = {.known = false};
		contacts[i] = world_contact_unknown();
		if (host == NULL || host->body.elsewhere) {
			status = check(world, numbers[i], &states[i]);
			continue;
		}
		status = need_mirror(world, host);
		struct world_state state = states[i];
		if (status == STATUS_OK)
			status = check(world, numbers[i], &state);
		if (status == STATUS_OK && host->placed)
			world_rates_fill(&host->now.pose, world->scene->time_step, &state);
		if (status == STATUS_OK)
			status = probe_host(world, host, &state, &probed);
		if (probed.known)
			world_tell_probed(host, &state, &probed, world->time, &contacts[i]);
	}
	return ranks != NULL ? ranks->probed(ranks->user, count, numbers, contacts, status) : status;
}
