/* furrow.h: bodies. Handles are the world's numbers. */
#include "api/library.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define CONTACT_FIRST offsetof(struct furrow_contact, pull) /* bytes of the first version */
#define CONTACT_SECOND offsetof(struct furrow_contact, carried) /* of the second, */
#define CONTACT_THIRD offsetof(struct furrow_contact, slip_velocity) /* and of the third */

/* Checks lists of bodies, and of the data of each: `bytes` a body. */
static enum status need_lists(const struct furrow_world *world, size_t count, const void *bodies, const void *items, size_t bytes,
			      const char *name)
{
	TRY(api_library_need_world(world));
	TRY(api_library_need_count(count, bytes));
	if (count > 0)
		TRY(api_library_need(bodies, "bodies"));
	if (count > 0)
		TRY(api_library_need(items, name));
	return STATUS_OK;
}

/* Checks that all bodies exist. Call it before telling about the first of them, so that a call tells everything or nothing. */
static enum status need_bodies(const struct furrow_world *world, size_t count, const furrow_body *bodies)
{
	struct furrow_state state;
	for (size_t i = 0; i < count; i++)
		TRY(world_body_state(world->world, bodies[i], &state));
	return STATUS_OK;
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
static enum status state_at(const struct furrow_world *world, furrow_body body, struct furrow_state *state)
{
	return vehicle_body(world->vehicles, body, state, NULL) ? STATUS_OK : world_body_state(world->world, body, state);
}

static enum status contact_of(struct furrow_world *world, furrow_body body, struct furrow_contact *contact)
{
	return vehicle_body(world->vehicles, body, NULL, contact) ? STATUS_OK : world_body_contact(world->world, body, contact);
}

/* Checks lists of bodies and of their contacts, and the caller's size of a contact. */
static enum status need_contacts(const struct furrow_world *world, size_t count, const furrow_body *bodies,
				 const struct furrow_contact *contacts, size_t size)
{
	enum status status = need_lists(world, count, bodies, contacts, sizeof *contacts, "contacts");
	if (status != STATUS_OK || size == sizeof *contacts || size == CONTACT_FIRST || size == CONTACT_SECOND || size == CONTACT_THIRD)
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
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, need_free(world, 1, &body));
	TRY_OR(done, world_body_remove(world->world, body));
done:
	return api_library_leave(&call, status);
}

furrow_status furrow_place(struct furrow_world *world, furrow_body body, const struct furrow_pose *pose)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, api_library_need(pose, "pose"));
	TRY_OR(done, api_library_need_writable(world, "place"));
	TRY_OR(done, need_free(world, 1, &body));
	TRY_OR(done, world_body_place(world->world, body, pose));
done:
	return api_library_leave(&call, status);
}

furrow_status furrow_set_states(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_state *states)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need_lists(world, count, bodies, states, sizeof *states, "states"));
	TRY_OR(done, api_library_need_writable(world, "states"));
	TRY_OR(done, need_free(world, count, bodies));
	if (count > 0)
		TRY_OR(done, world_bodies_set(world->world, count, bodies, states, NULL));
done:
	return api_library_end(status);
}

furrow_status furrow_set_belts(struct furrow_world *world, size_t count, const furrow_body *bodies, const struct furrow_belt *belts)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need_lists(world, count, bodies, belts, sizeof *belts, "belts"));
	TRY_OR(done, need_free(world, count, bodies));
	if (count > 0)
		TRY_OR(done, world_belts_set(world->world, count, bodies, belts));
done:
	return api_library_end(status);
}

furrow_status furrow_get_states(struct furrow_world *world, size_t count, const furrow_body *bodies, struct furrow_state *states)
{
	enum status status = api_library_begin();
	if (status == STATUS_OK)
		status = need_lists(world, count, bodies, states, sizeof *states, "states");
	if (status == STATUS_OK)
		status = need_bodies(world, count, bodies);
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = state_at(world, bodies[i], &states[i]);
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
		struct furrow_contact contact;
		status = contact_of(world, bodies[i], &contact);
		if (status == STATUS_OK)
			memcpy((char *)contacts + i * contact_size, &contact, contact_size);
	}
	return api_library_leave(&call, status);
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
		return api_library_end(world_probe(world->world, count, bodies, states, NULL, contacts, contact_size));
	(void)api_library_end(STATUS_OK);
	status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = world_probe(world->world, count, bodies, states, NULL, contacts, contact_size);
	return api_library_leave(&call, status);
}
