/* The two ways to change the ground behind one face. On the GPU (deform) kinematic models are computed. On the CPU (bearing) soil that bears is, and
 * kinematic models where the scene asks for it, or where there is no GL. An elastic sheet is computed there unless the scene asks for the GPU. */

#include "world/internal.h"

bool world_is_bearing(const struct world *world)
{
	const enum scene_compute asked = world->scene->compute;
	const enum deform_model model = world->scene->model;
	return world_deforms(world) && (deform_on_cpu(model) || (asked != SCENE_GPU && deform_for_cpu(model)) || asked == SCENE_CPU || world->facts.without_gl);
}

bool world_changes_ground(const struct world *world)
{
	return world->deform != NULL || world->bearing != NULL;
}

enum status world_surface_create(struct world *world, const struct deform_params *params)
{
	world->surface = *params;
	if (world_is_bearing(world))
		return bearing_create(params, world->resident.host, &world->bearing);
	return world_deforms(world) ? deform_create(params, &world->deform) : STATUS_OK;
}

void world_surface_destroy(struct world *world)
{
	deform_destroy(world->deform);
	bearing_destroy(world->bearing);
	world->deform = NULL;
	world->bearing = NULL;
}

enum status world_wake(struct world *world, struct post_rect changed)
{
	return world->bearing != NULL ? bearing_wake(world->bearing, changed) : deform_wake(world->deform, changed);
}

struct post_rect world_wakes(const struct world *world, struct post_rect changed)
{
	return world->bearing != NULL ? bearing_wakes(world->bearing, changed) : deform_wakes(world->deform, changed);
}

enum status world_wake_block(struct world *world, struct soil_block block)
{
	return world->bearing != NULL ? bearing_wake_block(world->bearing, block) : deform_wake_block(world->deform, block);
}

enum status world_active_blocks(const struct world *world, const struct soil_block **blocks, size_t *count)
{
	*blocks = NULL;
	*count = 0;
	if (world->bearing != NULL)
		return bearing_active_blocks(world->bearing, blocks, count);
	return world->deform != NULL ? deform_active_blocks(world->deform, blocks, count) : STATUS_OK;
}

enum status world_forget_active(struct world *world)
{
	if (world->bearing == NULL)
		return deform_forget_active(world->deform);
	bearing_forget_active(world->bearing);
	return STATUS_OK;
}

int64_t world_interval_rim(const struct world *world)
{
	return world->bearing != NULL ? bearing_interval_rim(world->bearing) : deform_interval_rim(world->deform);
}

int64_t world_contact_reach(const struct world *world, const struct soil_shape *shape)
{
	return world->bearing != NULL ? bearing_contact_reach(world->bearing, shape) : deform_contact_reach(world->deform, shape);
}

void world_set_equilibrium(struct world *world, const struct body *body, int64_t raised)
{
	if (body->loaded_body > 0 && body->has_last && world->bearing != NULL)
		bearing_set_equilibrium(world->bearing, body->loaded_body, (int32_t)raised);
}

enum status world_tally(const struct world *world, struct deform_tally *tally)
{
	*tally = (struct deform_tally){.refused = 0};
	if (world->bearing == NULL)
		return world->deform != NULL ? deform_tally(world->deform, tally) : STATUS_OK;
	bearing_tally(world->bearing, tally);
	return STATUS_OK;
}

enum status world_restore_tally(struct world *world, const struct deform_tally *tally)
{
	if (world->bearing == NULL)
		return deform_restore(world->deform, tally);
	bearing_restore(world->bearing, tally);
	return STATUS_OK;
}
