/* furrow.h: bodies. Handles are the world's numbers. */
#include "api/library.h"

#include <stddef.h>

#include <math.h>
#include <string.h>

_Static_assert((int)FURROW_AIR == (int)WORLD_AIR && (int)FURROW_UNKNOWN == (int)WORLD_UNKNOWN, "the same states in the same order");

/* Both structs have the same numbers in the same order; only the names are furrow.h's. */
static struct world_pose pose_of(const struct furrow_pose *from)
{
	struct world_pose pose;
	memcpy(pose.position, from->position, sizeof pose.position);
	memcpy(pose.orientation, from->orientation, sizeof pose.orientation);
	return pose;
}

static struct world_state state_of(const struct furrow_state *from)
{
	struct world_state state = {.pose = pose_of(&from->pose)};
	memcpy(state.linear, from->linear, sizeof state.linear);
	memcpy(state.angular, from->angular, sizeof state.angular);
	return state;
}

void api_library_tell_state(const struct world_state *from, struct furrow_state *state)
{
	memcpy(state->pose.position, from->pose.position, sizeof state->pose.position);
	memcpy(state->pose.orientation, from->pose.orientation, sizeof state->pose.orientation);
	memcpy(state->linear, from->linear, sizeof state->linear);
	memcpy(state->angular, from->angular, sizeof state->angular);
}

#define CONTACT_FIRST offsetof(struct furrow_contact, pull) /* bytes of the first version */

/* Fills entry `index` of the host's list, whose entries have `size` bytes. */
static void tell_contact(const struct world_contact *from, struct furrow_contact *contacts, size_t index, size_t size)
{
	struct furrow_contact known, *contact = &known;
	known = (struct furrow_contact){
		.time = from->time,
		.sinkage = from->sinkage,
		.area = from->area,
		.slip = from->slip,
		.normal_force = from->normal_force,
		.shear_limit = from->shear_limit,
		.pull = from->pull,
		.state = (enum furrow_contact_state)from->state,
	};
	memcpy(contact->force, from->force, sizeof contact->force);
	memcpy(contact->moment, from->moment, sizeof contact->moment);
	memcpy(contact->point, from->point, sizeof contact->point);
	memcpy(contact->normal, from->normal, sizeof contact->normal);
	memcpy(contact->stiffness, from->stiffness, sizeof contact->stiffness);
	memcpy(contact->damping, from->damping, sizeof contact->damping);
	memcpy((char *)contacts + index * size, contact, size);
}

/* Checks lists of bodies, and of the data of each: `bytes` a body. */
static enum status need_lists(const struct furrow_world *world, size_t count, const void *bodies, const void *items, size_t bytes,
			      const char *name)
{
	enum status status = api_library_need_world(world);
	if (status == STATUS_OK)
		status = api_library_need_count(count, bytes);
	if (status == STATUS_OK && count > 0)
		status = api_library_need(bodies, "bodies");
	if (status == STATUS_OK && count > 0)
		status = api_library_need(items, name);
	return status;
}

/* Checks that all bodies exist. Call it before telling about the first of them, so that a call tells everything or nothing. */
static enum status need_bodies(const struct furrow_world *world, size_t count, const furrow_body *bodies)
{
	struct world_state state;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = world_body_state(world->world, bodies[i], &state);
	return status;
}

/* Checks that no vehicle moves a body. */
static enum status need_free(const struct furrow_world *world, size_t count, const furrow_body *bodies)
{
	for (size_t i = 0; i < count; i++) {
		const char *name = vehicle_body_name(world->vehicles, bodies[i]);
		if (name != NULL)
			return fail_with(STATUS_USAGE, "%s: it is a part of a vehicle, which moves it; set the vehicle's controls (furrow_set_controls)", name);
	}
	return STATUS_OK;
}

/* Where a body is. */
static enum status state_at(const struct furrow_world *world, furrow_body body, struct world_state *state)
{
	struct world_contact contact;
	return vehicle_body(world->vehicles, body, state, &contact) ? STATUS_OK : world_body_state(world->world, body, state);
}

static enum status contact_of(struct furrow_world *world, furrow_body body, struct world_contact *contact)
{
	struct world_state state;
	return vehicle_body(world->vehicles, body, &state, contact) ? STATUS_OK : world_body_contact(world->world, body, contact);
}

/* Checks lists of bodies and of their contacts, and the caller's size of a contact. */
static enum status need_contacts(const struct furrow_world *world, size_t count, const furrow_body *bodies,
				 const struct furrow_contact *contacts, size_t size)
{
	enum status status = need_lists(world, count, bodies, contacts, sizeof *contacts, "contacts");
	if (status != STATUS_OK || size == sizeof *contacts || size == CONTACT_FIRST)
		return status;
	return fail_with(STATUS_USAGE, "contact_size: it is %zu, and a contact has %zu bytes; give sizeof(struct furrow_contact)", size,
			 sizeof *contacts);
}

furrow_status furrow_body_add(struct furrow_world *world, const char *object, furrow_body *body)
{
	struct library_call call;
	struct scene_object parsed;
	enum status status = api_library_enter(&call, world);
	if (body != NULL)
		*body = -1;
	if (status == STATUS_OK)
		status = api_library_need(object, "object");
	if (status == STATUS_OK)
		status = api_library_need(body, "body");
	if (status == STATUS_OK)
		status = scene_object_parse(world_scene(world->world), object, &parsed);
	if (status != STATUS_OK)
		return api_library_leave(&call, status);
	status = world_body_add(world->world, &parsed, body);
	if (status != STATUS_OK)
		scene_object_finish(&parsed);
	return api_library_leave(&call, status);
}

static enum status measure(const char *object, struct furrow_shape *shape)
{
	struct scene *scene;
	struct scene_object parsed;
	TRY(api_library_need(object, "object"));
	TRY(api_library_need(shape, "shape"));
	TRY(api_library_need_size(shape->size, sizeof *shape, sizeof *shape, "shape"));
	TRY(scene_load_text("{}", NULL, NULL, 0, SCENE_HOST, &scene));
	const enum status status = scene_object_parse(scene, object, &parsed);
	scene_destroy(scene);
	if (status != STATUS_OK)
		return status;
	const struct soil_shape *of = &parsed.shape;
	const bool wheel = of->kind == SOIL_WHEEL;
	*shape = (struct furrow_shape){
		.size = shape->size,
		.radius = wheel ? of->radius : (double)NAN,
		.width = wheel ? of->width : (double)NAN,
		.bound = soil_shape_bound(of),
		.belt = of->belt,
	};
	scene_object_finish(&parsed);
	return STATUS_OK;
}

furrow_status furrow_measure(const char *object, struct furrow_shape *shape)
{
	const enum status status = api_library_begin();
	return api_library_end(status == STATUS_OK ? measure(object, shape) : status);
}

furrow_status furrow_body_find(struct furrow_world *world, const char *name, furrow_body *body)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = api_library_need_world(world);
	if (body != NULL)
		*body = -1;
	if (status == STATUS_OK)
		status = api_library_need(name, "name");
	if (status == STATUS_OK)
		status = api_library_need(body, "body");
	if (status == STATUS_OK)
		status = world_body_find(world->world, name, body);
	return api_library_end(status);
}

furrow_status furrow_body_remove(struct furrow_world *world, furrow_body body)
{
	struct library_call call;
	enum status status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = need_free(world, 1, &body);
	if (status == STATUS_OK)
		status = world_body_remove(world->world, body);
	return api_library_leave(&call, status);
}

furrow_status furrow_place(struct furrow_world *world, furrow_body body, const struct furrow_pose *pose)
{
	struct library_call call;
	enum status status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = api_library_need(pose, "pose");
	if (status == STATUS_OK)
		status = api_library_need_writable(world, "place");
	if (status == STATUS_OK)
		status = need_free(world, 1, &body);
	if (status == STATUS_OK) {
		const struct world_pose at = pose_of(pose);
		status = world_body_place(world->world, body, &at);
	}
	return api_library_leave(&call, status);
}

furrow_status furrow_set_states(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_state *states)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = need_lists(world, count, bodies, states, sizeof *states, "states");
	struct world_state *list = NULL;
	if (status == STATUS_OK && count > 0) {
		list = mem_alloc(count, sizeof *list);
		status = list != NULL ? STATUS_OK : fail_memory("states");
	}
	if (status == STATUS_OK)
		status = api_library_need_writable(world, "states");
	if (status == STATUS_OK)
		status = need_free(world, count, bodies);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		list[i] = state_of(&states[i]);
	if (status == STATUS_OK && count > 0)
		status = world_bodies_set(world->world, count, bodies, list);
	mem_free(list);
	return api_library_end(status);
}

furrow_status furrow_set_belts(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_belt *belts)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = need_lists(world, count, bodies, belts, sizeof *belts, "belts");
	struct world_belt *list = NULL;
	if (status == STATUS_OK && count > 0) {
		list = mem_alloc(count, sizeof *list);
		status = list != NULL ? STATUS_OK : fail_memory("belts");
	}
	if (status == STATUS_OK)
		status = need_free(world, count, bodies);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		list[i] = (struct world_belt){belts[i].travel, belts[i].speed};
	if (status == STATUS_OK && count > 0)
		status = world_belts_set(world->world, count, bodies, list);
	mem_free(list);
	return api_library_end(status);
}

furrow_status furrow_get_states(struct furrow_world *world, size_t count, const furrow_body *bodies, struct furrow_state *states)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = need_lists(world, count, bodies, states, sizeof *states, "states");
	if (status == STATUS_OK)
		status = need_bodies(world, count, bodies);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct world_state state;
		status = state_at(world, bodies[i], &state);
		if (status == STATUS_OK)
			api_library_tell_state(&state, &states[i]);
	}
	return api_library_end(status);
}

furrow_status furrow_get_contacts(struct furrow_world *world, size_t count, const furrow_body *bodies, struct furrow_contact *contacts,
				  size_t contact_size)
{
	struct library_call call;
	enum status status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = need_contacts(world, count, bodies, contacts, contact_size);
	if (status == STATUS_OK)
		status = need_bodies(world, count, bodies);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct world_contact contact;
		status = contact_of(world, bodies[i], &contact);
		if (status == STATUS_OK)
			tell_contact(&contact, contacts, i, contact_size);
	}
	return api_library_leave(&call, status);
}

/* Probes, with the lists that the world takes. */
static enum status probe(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_state *states,
			 struct furrow_contact *contacts, size_t contact_size)
{
	struct world_state *asked = mem_alloc(count, sizeof *asked);
	struct world_contact *told = mem_alloc(count, sizeof *told);
	enum status status = asked != NULL && told != NULL ? STATUS_OK : fail_memory("states");
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		asked[i] = state_of(&states[i]);
	if (status == STATUS_OK)
		status = world_probe(world->world, count, bodies, asked, told);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		tell_contact(&told[i], contacts, i, contact_size);
	mem_free(asked);
	mem_free(told);
	return status;
}

furrow_status furrow_probe(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_state *states,
			   struct furrow_contact *contacts, size_t contact_size)
{
	struct library_call call;
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = need_lists(world, count, bodies, states, sizeof *states, "states");
	if (status == STATUS_OK)
		status = need_contacts(world, count, bodies, contacts, contact_size);
	if (status == STATUS_OK)
		status = need_bodies(world, count, bodies);
	if (status != STATUS_OK || count == 0)
		return api_library_end(status);
	/* Only the first probe of a body needs the GL context. */
	if (!world_probe_reads(world->world, count, bodies))
		return api_library_end(probe(world, count, bodies, states, contacts, contact_size));
	(void)api_library_end(STATUS_OK);
	status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = probe(world, count, bodies, states, contacts, contact_size);
	return api_library_leave(&call, status);
}
