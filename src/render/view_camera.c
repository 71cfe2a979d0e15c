/* Computes the position and direction of cameras at any time, from their tracks and the ground. */
#include <math.h>
#include <string.h>

#include "render/view.h"

/* Returns about how high the ground is there, from the range of the finest tile whose range is known. */
static double about(struct view *view, struct tile tile, double otherwise)
{
	struct key_pair range;
	return render_view_base_range(view, tile, &range) == STATUS_OK && !isnan(range.a) ? (range.a + range.b) / 2 : otherwise;
}

double render_view_ground_at(struct view *view, double x, double y, double otherwise)
{
	const struct extent *extent = &world_resident(view->world)->meta->extent;
	double px = x / extent->spacing, py = y / extent->spacing;
	int64_t height;
	bool any, inside = px >= 0 && py >= 0 && px <= (double)(extent->width - 1) && py <= (double)(extent->height - 1);
	if (!inside)
		return otherwise;
	if (!view->exact && !resident_ground_touch(world_resident(view->world)->ground, resident_ground_tile(extent, px, py)))
		return about(view, resident_ground_tile(extent, px, py), otherwise);
	if (resident_ground_height(world_resident(view->world)->ground, lattice_offset(x), lattice_offset(y), &height, &any) != STATUS_OK || !any)
		return otherwise;
	return lattice_offset_metres(height);
}

/* Returns the body that the camera follows; NULL: it does not move. */
static const struct body *target_of(const struct world *world, const struct scene_aim *aim)
{
	return aim->kind != SCENE_FIXED && aim->vehicle == 0 ? world_body(world, aim->object) : NULL;
}

/* Places of a camera that follows a vehicle: where that is now. Before it was set down, where it starts. */
static size_t vehicle_places(const struct world *world, const struct scene_aim *aim, double places[2][2])
{
	const struct world_place *place = world_frame_of(world, (size_t)aim->vehicle - 1, NULL);
	const struct scene_vehicle *vehicle = &world_scene(world)->vehicles[aim->vehicle - 1];
	const double yaw = place != NULL ? atan2(place->axes[0][1], place->axes[0][0]) : vehicle->yaw;
	memcpy(places[0], place != NULL ? place->at : vehicle->at, sizeof places[0]);
	places[1][0] = places[0][0] - aim->back * cos(yaw);
	places[1][1] = places[0][1] - aim->back * sin(yaw);
	return 2;
}

void render_view_place_camera(struct view *view, double time, struct render_camera *camera)
{
	if (view->free)
		*camera = view->camera;
	else
		render_view_aim(view, &world_scene(view->world)->view.aim, time, camera);
}

void render_view_aim(struct view *view, const struct scene_aim *given, double time, struct render_camera *camera)
{
	const struct world *world = view->world;
	double places[2][2];
	*camera = (struct render_camera){.fov = 0.9};
	const struct body *target = target_of(world, given);
	const bool vehicle = given->kind != SCENE_FIXED && given->vehicle > 0;
	size_t count = 0;
	if (vehicle)
		count = vehicle_places(world, given, places);
	else if (target != NULL && target->kind == BODY_PATH) /* a host moves the others, and gives the camera, too */
		count = motion_track_camera_places(given, &target->object->path, target->track, time, places);
	if (count == 0) {
		memcpy(camera->eye, given->eye, sizeof camera->eye);
		memcpy(camera->target, given->target, sizeof camera->target);
		return;
	}
	double middle = (world_resident(world)->meta->low + world_resident(world)->meta->high) / 2;
	double ground = render_view_ground_at(view, places[0][0], places[0][1], isnan(middle) ? 0 : middle);
	camera->target[0] = places[0][0];
	camera->target[1] = places[0][1];
	camera->target[2] = ground;
	if (given->kind == SCENE_OVERHEAD) {
		/* A hair off the vertical, so that north is up. */
		camera->eye[0] = places[0][0];
		camera->eye[1] = places[0][1] - 0.02 * given->over_height;
		camera->eye[2] = ground + given->over_height;
		return;
	}
	camera->eye[0] = places[1][0];
	camera->eye[1] = places[1][1];
	double below = render_view_ground_at(view, camera->eye[0], camera->eye[1], ground);
	camera->eye[2] = fmax(ground, below) + given->up;
}

void render_view_scene_camera(struct view *view, struct render_camera *camera)
{
	bool free = view->free;
	view->free = false;
	render_view_place_camera(view, world_time(view->world), camera);
	view->free = free;
}
