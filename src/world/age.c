/* The time of the store, in which marks fade: it goes on from drive to drive. And what a contact marks. */
#include <math.h>

#include "world/internal.h"

bool world_keeps_marks(const struct scene *scene)
{
	return scene->heals > 0 || scene->vegetation.present;
}

/* Gives the store the scene's numbers. What the scene does not name stays as earlier drives had it. */
static void name_numbers(const struct scene *scene, struct store_marks *marks)
{
	marks->any = marks->any || world_keeps_marks(scene);
	if (scene->heals > 0)
		marks->heals = scene->heals;
	if (scene->vegetation.present) {
		marks->rises = scene->vegetation.rises;
		marks->grows = scene->vegetation.grows;
	}
}

enum status world_begin_age(struct world *world)
{
	const struct scene *scene = world->scene;
	struct store_marks *marks = &world->record->marks;
	if (world->params.readonly && !world_keeps_marks(scene))
		return STATUS_OK;
	TRY(world->params.readonly ? store_marks(world->resident.store, marks) : store_last_marks(world->resident.store, marks));
	if (!world->facts.resumed.is)
		marks->since += marks->time + scene->elapsed;
	name_numbers(scene, marks);
	return world_check_age(world, scene->hosted ? 0 : scene->end_time);
}

enum status world_check_age(const struct world *world, double time)
{
	const double age = world->record->marks.since + time, most = ldexp(PLANE_TIME_MOST, -PLANE_TIME_BITS);
	if (!world_keeps_marks(world->scene) || age <= most)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "attributes: all drives of %s take %.0f s together, and marks that fade know %.0f s; furrow reset %s, or drive without them",
			 world->facts.path, age, most, shell_path(world->facts.path).text);
}

struct plane_marks world_marks_at(const struct world *world, double time)
{
	if (world->record == NULL) /* it was made and not opened */
		return (struct plane_marks){.now = 0};
	return store_marks_at(&world->record->marks, time);
}

/* Returns how far the lowest point of the body slides over the ground, m. `way`: of its centre. */
static double slide_of(const struct deform_contact *contact, const double way[3], double *rim)
{
	const struct soil_shape *shape = contact->shape;
	const struct soil_pose *to = &contact->to;
	double axes[3][3], turned[3] = {0, 0, 0};
	*rim = 0;
	if (shape->kind == SOIL_WHEEL || shape->belt) {
		const double plan = way[0] * cos(to->yaw) + way[1] * sin(to->yaw), across = way[1] * cos(to->yaw) - way[0] * sin(to->yaw);
		*rim = shape->belt ? contact->turned : contact->turned * shape->radius;
		return hypot(*rim - copysign(hypot(plan, way[2]), plan), across);
	}
	soil_axes(to->yaw, to->pitch, to->roll, 0, axes);
	for (int k = 0; k < 3; k++)
		for (int i = 0; i < 3; i++)
			turned[i] += contact->rotated[k] * axes[k][i];
	const double below = soil_shape_reach(shape, to->pitch, to->roll), east = -turned[1] * below, north = turned[0] * below;
	*rim = hypot(east, north);
	return hypot(way[0] + east, way[1] + north);
}

int32_t world_torn(const struct world *world, const struct deform_contact *contact)
{
	const struct soil_pose *from = &contact->from, *to = &contact->to;
	const double way[3] = {lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y), lattice_offset_metres(to->z - from->z)};
	double rim;
	if (!world->scene->vegetation.present)
		return 0;
	const double slide = slide_of(contact, way, &rim), most = fmax(fabs(rim), sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]));
	const double share = most > 0 ? slide / most / world->scene->vegetation.tears : 0;
	return share < 1 ? (int32_t)lround(PLANE_MARK_MOST * share) : PLANE_MARK_MOST;
}
