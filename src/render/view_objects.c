/*
 * Finds the poses of objects for a picture. The time of a picture may be between two path samples. An object is shown as deep below
 * the undisturbed ground as at its last path sample. A loaded body is shown at the depth where the soil was last found to carry it.
 * A wheel and a ball have rolled on since the last path sample.
 */
#include <math.h>
#include <string.h>

#include "render/view.h"

/* Returns how far the body has turned about its axis, radians, including the way since its last path sample. Returns 0 if it does not
 * roll: another shape, or a ball whose path gives its attitude. */
static double turned_at(const struct body *body, const struct track_point *point)
{
	const struct soil_shape *shape = &body->object->shape;
	double dx = lattice_offset_metres(point->qx - body->last.x), dy = lattice_offset_metres(point->qy - body->last.y);
	if (shape->kind == SOIL_WHEEL) {
		double along = body->has_last ? scene_slip_way(body->object, dx, dy, point->yaw) : 0;
		return body->last.turn + along / (shape->radius * (1 - body->object->slip));
	}
	if (shape->kind != SOIL_SPHERE || body->object->path.has_attitude)
		return 0;
	return remainder((body->distance + (body->has_last ? hypot(dx, dy) : 0)) / shape->radius, 2 * M_PI);
}

enum status render_object_height(struct world *world, const struct body *body, const struct track_point *point, int64_t *height, bool *known)
{
	const struct scene_object *object = body->object;
	int64_t ground;
	*known = true;
	*height = lattice_offset(point->z);
	if (object->path.has_z)
		return STATUS_OK;
	TRY(resident_ground_height(world_resident(world)->ground, point->qx, point->qy, &ground, known));
	double depth = scene_sinkage_guess(world_scene(world), object);
	*height = *known ? ground + lattice_offset(soil_shape_reach(&object->shape, point->pitch, point->roll) - depth) + body->raised :
			   body->last.z + body->raised;
	*known = *known || body->has_last || body->distance > 0;
	return STATUS_OK;
}

enum status render_view_object(struct view *view, size_t index, struct render_object *object, bool *known)
{
	struct world *world = view->world;
	const struct body *body = world_body(world, index);
	struct track_point point;
	int64_t height;
	motion_track_at(body->track, world_time(world), &point);
	TRY(render_object_height(world, body, &point, &height, known));
	const bool attitude = body->object->shape.kind != SOIL_WHEEL; /* the pitch of a wheel only turns it */
	*object = (struct render_object){
		.object = index,
		.at = {point.x, point.y, lattice_offset_metres(height)},
		.yaw = point.yaw,
		.pitch = attitude ? point.pitch : 0,
		.roll = point.roll,
		.turned = turned_at(body, &point),
	};
	return STATUS_OK;
}

static enum status set_grains(struct view *view)
{
	const size_t count = world_grains(view->world, 0, NULL);
	struct world_grain *from = NULL;
	struct render_grain *grains = NULL;
	enum status status;
	if (count == 0) {
		render_set_grains(view->render, NULL, 0);
		return STATUS_OK;
	}
	TRY_OR(done, mem_make(&from, count, sizeof *from, "the picture's grains"));
	TRY_OR(done, mem_make(&grains, count, sizeof *grains, "the picture's grains"));
	world_grains(view->world, count, from);
	for (size_t i = 0; i < count; i++)
		grains[i] = (struct render_grain){{from[i].at[0], from[i].at[1], from[i].at[2]}, from[i].radius, from[i].number};
	render_set_grains(view->render, grains, count);
done:
	mem_free_all(from, grains);
	return status;
}

/* Gives the soil aboard a body, where the body is shown. */
static enum status heap_of(struct view *view, size_t number, struct render_heap *heap, bool *there)
{
	const struct body *body = world_body(view->world, number);
	struct world_heap from;
	struct render_object shown;
	*there = world_heap(view->world, number, &from);
	if (!*there)
		return STATUS_OK;
	*heap = (struct render_heap){.heading = from.heading, .spacing = from.spacing, .side = from.side, .class = from.class, .amounts = from.amounts, .tops = from.tops, .shares = from.shares};
	memcpy(heap->at, from.at, sizeof heap->at);
	if (body->kind == BODY_PATH) {
		TRY(render_view_object(view, number, &shown, there));
		memcpy(heap->at, shown.at, sizeof heap->at);
		heap->heading += remainder(shown.yaw - body->last.yaw, M_PI);
	}
	int64_t ground;
	bool known;
	TRY(resident_ground_height(world_resident(view->world)->ground, lattice_offset(heap->at[0]), lattice_offset(heap->at[1]), &ground, &known));
	heap->ground = known ? lattice_offset_metres(ground) : heap->at[2];
	return STATUS_OK;
}

static enum status set_heaps(struct view *view)
{
	const size_t bodies = world_carried_total(view->world) > 0 ? world_body_count(view->world) : 0;
	struct render_heap *heaps = NULL;
	size_t count = 0;
	enum status status = STATUS_OK;
	if (bodies == 0)
		return render_set_heaps(view->render, NULL, 0);
	TRY(mem_make(&heaps, bodies, sizeof *heaps, "the picture's soil aboard bodies"));
	for (size_t i = 0; i < bodies; i++) {
		bool there;
		TRY_OR(done, heap_of(view, i, &heaps[count], &there));
		count += there;
	}
	TRY_OR(done, render_set_heaps(view->render, heaps, count));
done:
	mem_free(heaps);
	return status;
}

enum status render_view_set_objects(struct view *view)
{
	struct world *world = view->world;
	const struct scene *scene = world_scene(world);
	TRY(set_grains(view));
	TRY(set_heaps(view));
	if (!render_shows_objects(view->render))
		return STATUS_OK;
	const struct world_figures *figures = world_figures(world);
	struct render_object *objects = mem_alloc(scene->object_count + figures->count + view->added_count, sizeof *objects);
	TRY_MEM(objects, "the picture's objects");
	size_t count = 0;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < scene->object_count; i++) {
		bool known;
		if (world_body(world, i)->kind != BODY_PATH) { /* a host moves it */
			if (render_view_body(view, i, &objects[count])) {
				objects[count].number = (uint32_t)i + 1;
				objects[count++].object = i;
			}
			continue;
		}
		if (world_time(world) < motion_track_sample_time(world_body(world, i)->track, 0))
			continue; /* its path has not begun */
		TRY_OR(done, render_view_object(view, i, &objects[count], &known));
		objects[count].number = (uint32_t)i + 1;
		count += known;
	}
	for (size_t i = 0; i < figures->count; i++) {
		const struct world_look *look = &figures->looks[i];
		struct render_object figure = {.object = scene->object_count + i, .posed = true, .painted = look->painted, .number = world_instance_of_figured(world, look->body)};
		if (!figures->places[i].there)
			continue;
		memcpy(figure.at, figures->places[i].at, sizeof figure.at);
		memcpy(figure.axes, figures->places[i].axes, sizeof figure.axes);
		memcpy(figure.colour, look->colour, sizeof figure.colour);
		objects[count++] = figure;
	}
	for (size_t i = 0; i < view->added_count; i++)
		if (render_view_body(view, (size_t)view->added[i], &objects[count])) {
			objects[count].number = world_instance_of_added(world, (size_t)view->added[i]);
			objects[count++].object = scene->object_count + figures->count + i;
		}
	render_set_objects(view->render, objects, count);
done:
	mem_free(objects);
	return status;
}
