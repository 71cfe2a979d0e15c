/*
 * The cameras of a drive. Each writes a frame after some steps, and is drawn only then. All share one render, and one screen for each
 * size of picture.
 *
 * A camera that is mounted on an object is in the object's pose as pictures show the object. Before a body is there, the camera is
 * where the body will begin.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/limits.h"
#include "render/internal.h"
#include "render/view.h"

/* --- where they are --- */

/* A place, and axes forward, left and up. */
struct stand {
	double at[3], axes[3][3];
};

/* The pose between two rows, angles the shorter way round. */
static void stand_at(const struct scene_path *poses, double time, struct stand *stand)
{
	const struct scene_waypoint *points = poses->points;
	size_t low = 0, high = poses->count - 1;
	while (high - low > 1) {
		const size_t middle = (low + high) / 2;
		if (points[middle].t <= time)
			low = middle;
		else
			high = middle;
	}
	const struct scene_waypoint *a = &points[low], *b = &points[high];
	const double part = b->t > a->t ? fmin(fmax((time - a->t) / (b->t - a->t), 0), 1) : 0;
	const double from[6] = {a->x, a->y, a->z, a->yaw, a->pitch, a->roll}, to[6] = {b->x, b->y, b->z, b->yaw, b->pitch, b->roll};
	double now[6];
	for (int i = 0; i < 6; i++)
		now[i] = from[i] + part * (i < 3 ? to[i] - from[i] : remainder(to[i] - from[i], 2 * M_PI));
	memcpy(stand->at, now, sizeof stand->at);
	soil_axes(now[3], now[4], now[5], 0, stand->axes);
}

static double middle_height(const struct world *world)
{
	const double middle = (world_resident(world)->meta->low + world_resident(world)->meta->high) / 2;
	return isnan(middle) ? 0 : middle;
}

/* Where a body will be. Its height is about right. */
static void stand_later(struct view *view, const struct body *body, double time, struct stand *stand)
{
	const struct scene_object *object = body->object;
	struct track_point point;
	motion_track_at(body->track, time, &point);
	const bool attitude = object->shape.kind != SOIL_WHEEL;
	stand->at[0] = point.x;
	stand->at[1] = point.y;
	stand->at[2] = object->path.has_z ? point.z : render_view_ground_at(view, point.x, point.y, middle_height(view->world)) +
						      soil_shape_reach(&object->shape, point.pitch, point.roll) - object->sink;
	soil_axes(point.yaw, attitude ? point.pitch : 0, point.roll, 0, stand->axes);
}

/* Where a vehicle, or a body of its model, is. Before the vehicle was set down, where it starts. */
static void stand_on_vehicle(struct view *view, size_t index, const char *body, struct stand *stand)
{
	const struct world_place *place = world_frame_of(view->world, index, body);
	const struct scene_vehicle *vehicle = &world_scene(view->world)->vehicles[index];
	if (place != NULL) {
		memcpy(stand->at, place->at, sizeof stand->at);
		memcpy(stand->axes, place->axes, sizeof stand->axes);
		return;
	}
	memcpy(stand->at, vehicle->at, sizeof vehicle->at);
	stand->at[2] = render_view_ground_at(view, vehicle->at[0], vehicle->at[1], middle_height(view->world));
	soil_axes(vehicle->yaw, 0, 0, 0, stand->axes);
}

/* `now`: exactly as pictures show the body. */
static enum status stand_on(struct view *view, const struct scene_camera *given, double time, bool now, struct stand *stand)
{
	const struct scene_aim *aim = &given->aim;
	struct render_object object;
	bool known = false;
	if (aim->vehicle > 0) {
		stand_on_vehicle(view, (size_t)aim->vehicle - 1, given->body, stand);
		return STATUS_OK;
	}
	if (now)
		TRY(render_view_object(view, (size_t)aim->object, &object, &known));
	stand_later(view, world_body(view->world, aim->object), time, stand);
	if (!known)
		return STATUS_OK;
	memcpy(stand->at, object.at, sizeof object.at);
	soil_axes(object.yaw, object.pitch, object.roll, 0, stand->axes);
	return STATUS_OK;
}

/* Moves and turns a camera against what it is mounted on. */
static void mount(const struct scene_camera *given, const struct stand *on, struct stand *stand)
{
	double own[3][3];
	soil_axes(given->yaw, given->pitch, given->roll, 0, own);
	for (int i = 0; i < 3; i++) {
		stand->at[i] = on->at[i];
		for (int k = 0; k < 3; k++)
			stand->at[i] += given->aim.eye[k] * on->axes[k][i];
		for (int a = 0; a < 3; a++)
			stand->axes[a][i] = own[a][0] * on->axes[0][i] + own[a][1] * on->axes[1][i] + own[a][2] * on->axes[2][i];
	}
}

/* The angle of view from the lowest row to the highest. */
static double upright_fov(const struct scene_camera *camera)
{
	return 2 * atan(tan(camera->fov / 2) * camera->height / camera->width);
}

static enum status place_left(struct view *view, const struct view_camera *this, double time, bool now, struct render_camera *camera)
{
	static const struct stand world = {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
	const struct scene_camera *given = this->camera;
	struct stand on, stand;
	switch (given->aim.kind) {
	case SCENE_CHASE:
	case SCENE_OVERHEAD:
		render_view_aim(view, &given->aim, time, camera);
		camera->fov = upright_fov(given);
		return STATUS_OK;
	case SCENE_FIXED:
		mount(given, &world, &stand);
		break;
	case SCENE_MOUNTED:
		TRY(stand_on(view, given, time, now, &on));
		mount(given, &on, &stand);
		break;
	case SCENE_BY_POSES:
		stand_at(&given->poses, time, &stand);
		break;
	}
	*camera = (struct render_camera){.fov = upright_fov(given)};
	for (int i = 0; i < 3; i++) {
		camera->eye[i] = stand.at[i];
		camera->target[i] = stand.at[i] + stand.axes[0][i];
		camera->up[i] = stand.axes[2][i];
	}
	return STATUS_OK;
}

/* The render's screen is the camera's. */
static enum status place(struct view *view, const struct view_camera *this, double time, bool now, struct render_camera *camera)
{
	struct render_axes axes;
	TRY(place_left(view, this, time, now, camera));
	if (this->camera->baseline == 0)
		return STATUS_OK;
	render_axes(view->render, camera, &axes);
	for (int i = 0; i < 3; i++) {
		camera->eye[i] += this->camera->baseline * axes.right[i];
		camera->target[i] += this->camera->baseline * axes.right[i];
	}
	return STATUS_OK;
}

/* --- what they will need --- */

/* Returns when the camera's next frame comes, s; INFINITY: the drive ends before. */
static double next_time(const struct world *world, const struct scene_camera *camera)
{
	const double step = world_scene(world)->time_step;
	int64_t frame = (int64_t)floor((double)world_steps_done(world) * camera->rate * step + 1e-9);
	while (scene_camera_step(camera, step, frame) <= world_steps_done(world))
		frame++;
	const int64_t at = scene_camera_step(camera, step, frame);
	return at <= world_step_count(world) ? world_step_time(world_scene(world), at) : INFINITY;
}

enum status render_view_look_camera(struct view *view)
{
	const struct world *world = view->world;
	struct view_camera *this = &view->cameras[view->camera_turn++ % view->camera_count];
	struct view_look *look = &this->ahead;
	const double time = next_time(world, this->camera);
	const bool come = look->guessed && look->done != resident_look_ahead_ranges_done(world_look_ahead(world));
	struct render_camera camera;
	if (time > world_time(world) + resident_look_ahead_reach(world_look_ahead(world), world_time(world)))
		return STATUS_OK;
	if (look->time == time && !come && time - world_time(world) > (time - look->made) / 2)
		return STATUS_OK;
	view->exact = !resident_look_ahead_brings_ranges(world_look_ahead(world));
	view->render->screen = this->screen;
	enum status status;
	TRY_OR(done, place(view, this, time, false, &camera));
	TRY_OR(done, render_view_look(view, &camera, time, look));
done:
	view->render->screen = &view->render->own;
	view->exact = true;
	return status;
}

/* --- their frames --- */

/* Begins to write one read-back of the frame that was drawn. */
static enum status write(struct view *view, const struct view_camera *this, const struct render_camera *at, struct pictures *pictures, int64_t frame,
			 enum scene_image image)
{
	const struct scene_camera *camera = this->camera;
	struct render_picture picture = {image, (uint32_t)camera->width, (uint32_t)camera->height, .unit = camera->depth_unit, .frame = frame};
	snprintf(picture.name, sizeof picture.name, RENDER_CAMERAS "/%s", camera->name);
	if (image == SCENE_IMAGE_NORMALS) {
		picture.images = camera->images & SCENE_IMAGES_MEASURED;
		picture.eye = at->eye[2];
		picture.vehicles[0] = world_instance_of_figured(view->world, 0);
		picture.vehicles[1] = world_instance_of_figured(view->world, world_figures(view->world)->body_count);
		render_height_scale(view->render->low, view->render->high, &picture.unit, &picture.low);
	}
	picture.exposure = render_exposed(view->render);
	picture.triangles = render_triangles(view->render);
	return render_pictures_add(pictures, view->render, &picture);
}

static enum status write_all(struct view *view, const struct view_camera *this, const struct render_camera *at, struct pictures *pictures,
			     int64_t frame)
{
	const unsigned images = this->camera->images;
	const bool measures = scene_camera_measures(world_scene(view->world), this->camera);
	if (images >> SCENE_IMAGE_COLOUR & 1)
		TRY(write(view, this, at, pictures, frame, SCENE_IMAGE_COLOUR));
	if (images >> SCENE_IMAGE_LINEAR & 1)
		TRY(write(view, this, at, pictures, frame, SCENE_IMAGE_LINEAR));
	if (measures) {
		TRY(render_measure(view->render, at, view->selection));
		render_view_count_tiles(view);
	}
	if (images >> SCENE_IMAGE_DEPTH & 1)
		TRY(write(view, this, at, pictures, frame, SCENE_IMAGE_DEPTH));
	return images & SCENE_IMAGES_MEASURED ? write(view, this, at, pictures, frame, SCENE_IMAGE_NORMALS) : STATUS_OK;
}

static enum status tell_pose(struct view *view, const struct view_camera *this, const struct render_camera *camera, const struct render_poses *poses,
			     int64_t frame)
{
	struct render_axes axes;
	struct render_pose pose;
	if (poses == NULL)
		return STATUS_OK;
	render_axes(view->render, camera, &axes);
	memcpy(pose.eye, camera->eye, sizeof pose.eye);
	memcpy(pose.right, axes.right, sizeof pose.right);
	memcpy(pose.up, axes.up, sizeof pose.up);
	memcpy(pose.forward, axes.forward, sizeof pose.forward);
	pose.exposure = render_exposed(view->render);
	pose.triangles = render_triangles(view->render);
	return poses->take(poses->user, (size_t)(this - view->cameras), frame, &pose);
}

/* Tells if a camera begins below the ground. report_cameras_advise tells more of those whose place is known before a drive. */
static void tell_below(struct view *view, const struct scene_camera *camera, const double eye[3])
{
	const bool mounted = camera->aim.kind == SCENE_MOUNTED;
	const double ground = render_view_ground_at(view, eye[0], eye[1], -INFINITY);
	if ((mounted || camera->aim.kind == SCENE_FIXED) && camera->baseline == 0 && eye[2] < ground)
		note("cameras.%s.pose.at: the camera is %.3f m below the ground when the drive begins; %s", camera->name, ground - eye[2],
		     mounted ? "the place is forward, left and up from the origin of what it is on, in metres" : "heights are as the store has them");
}

static enum status draw(struct view *view, struct view_camera *this, struct pictures *pictures, const struct render_poses *poses, int64_t frame)
{
	struct render_camera camera;
	TRY(place(view, this, world_time(view->world), true, &camera));
	const struct plane_marks marks = world_marks_at(view->world, world_time(view->world));
	render_set_marks(view->render, &marks);
	if (frame == 0)
		tell_below(view, this->camera, camera.eye);
	render_set_truth(view->render, scene_camera_truth(world_scene(view->world), this->camera));
	TRY(render_view_shade(view, &camera, true));
	TRY(render_view_find_tiles(view, &camera, true));
	if (view->imagery != NULL)
		view->imagery->complete = true;
	TRY(render_frame(view->render, &camera, view->selection));
	TRY(tell_pose(view, this, &camera, poses, frame));
	render_view_count(view);
	view->starved += view->coarse;
	this->frames++;
	return write_all(view, this, &camera, pictures, frame);
}

enum status render_view_cameras(struct view *view, struct pictures *pictures, const struct render_poses *poses)
{
	const struct world *world = view->world;
	bool set = false;
	for (size_t i = 0; i < view->camera_count; i++) {
		const int64_t frame = scene_camera_frame(view->cameras[i].camera, world_scene(world)->time_step, world_steps_done(world));
		if (frame < 0)
			continue;
		if (!set)
			TRY(render_view_set_objects(view));
		set = true;
		view->render->screen = view->cameras[i].screen;
		const struct scene_light *light = &world_scene(world)->view.light;
		render_expose_by(view->render, view->cameras[i].camera->exposure, view->cameras[i].camera->ev);
		enum status status = draw(view, &view->cameras[i], pictures, poses, frame);
		render_expose_by(view->render, light->exposure, light->ev);
		view->render->screen = &view->render->own;
		TRY(status);
	}
	return STATUS_OK;
}

/* --- life --- */

static bool has_size(const struct render_screen *screen, const struct scene_camera *camera)
{
	return screen->width == (uint32_t)camera->width && screen->height == (uint32_t)camera->height;
}

static enum status find_screen(struct view *view, struct view_camera *this)
{
	const struct scene_camera *camera = this->camera;
	struct render *render = view->render;
	this->screen = has_size(&render->own, camera) ? &render->own : NULL;
	for (size_t i = 0; i < view->screen_count && this->screen == NULL; i++)
		if (has_size(&view->screens[i], camera))
			this->screen = &view->screens[i];
	if (this->screen != NULL)
		return STATUS_OK;
	this->screen = &view->screens[view->screen_count++];
	return render_screen_init(render, (uint32_t)camera->width, (uint32_t)camera->height, render->own.samples, this->screen);
}

enum status render_view_make_cameras(struct view *view)
{
	const struct scene *scene = world_scene(view->world);
	const size_t count = scene->camera_count;
	if (count == 0)
		return STATUS_OK;
	view->cameras = mem_calloc(count, sizeof *view->cameras);
	view->screens = mem_calloc(count, sizeof *view->screens);
	TRY_MEM(view->cameras != NULL && view->screens != NULL, "the cameras");
	for (size_t i = 0; i < count; i++) {
		view->cameras[i] = (struct view_camera){.camera = &scene->cameras[i], .ahead = {.time = -INFINITY}};
		TRY(find_screen(view, &view->cameras[i]));
		if (scene_camera_measures(scene, &scene->cameras[i]))
			TRY(render_screen_measures(view->render, view->cameras[i].screen));
	}
	view->camera_count = count;
	return STATUS_OK;
}

void render_view_free_cameras(struct view *view)
{
	for (size_t i = 0; i < view->screen_count; i++)
		render_screen_finish(&view->screens[i]);
	mem_free_all(view->screens, view->cameras);
}

/* --- their folders --- */

static enum status make_folder(const char *path)
{
	if (mkdir(path, 0777) != 0 && errno != EEXIST)
		return fail_with(STATUS_FAILED, "%s: %s; %s", path, strerror(errno), limits_advice(errno, "give a folder that can be written"));
	return STATUS_OK;
}

enum status render_cameras_folders(const struct scene *scene, const char *directory)
{
	char path[RENDER_PATH];
	snprintf(path, sizeof path, "%s/" RENDER_CAMERAS, directory);
	if (scene->camera_count > 0)
		TRY(make_folder(path));
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		snprintf(path, sizeof path, "%s/" RENDER_CAMERAS "/%s", directory, camera->name);
		TRY(make_folder(path));
		for (int image = 0; image < SCENE_IMAGES; image++) {
			if (!(camera->images >> image & 1))
				continue;
			snprintf(path, sizeof path, "%s/" RENDER_CAMERAS "/%s/%s", directory, camera->name, scene_image_name((enum scene_image)image));
			TRY(make_folder(path));
		}
	}
	return STATUS_OK;
}

/* --- the plan --- */

/* Returns whether an earlier camera, or the view, has a screen of this size. */
static bool is_shared(const struct scene *scene, size_t index)
{
	const struct scene_camera *camera = &scene->cameras[index];
	bool shared = scene->view.width == camera->width && scene->view.height == camera->height;
	for (size_t i = 0; i < index && !shared; i++)
		shared = scene->cameras[i].width == camera->width && scene->cameras[i].height == camera->height;
	return shared;
}

/* Returns whether the camera is the first of its size that is drawn as numbers, too. */
static bool is_first_measured(const struct scene *scene, size_t index)
{
	const struct scene_camera *camera = &scene->cameras[index];
	bool first = scene_camera_measures(scene, camera);
	for (size_t i = 0; i < index && first; i++)
		first = !scene_camera_measures(scene, &scene->cameras[i]) || scene->cameras[i].width != camera->width ||
			scene->cameras[i].height != camera->height;
	return first;
}

static void add_texture(struct plan *plan, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = scene_effect_row(EFFECT_CAMERAS)->name, .object = -1,
					   .amount = 1, .bytes = bytes}, name);
}

/* Returns the bytes of what the scene's cameras are drawn into, and of pictures on their way. */
static uint64_t bytes_of(const struct scene *scene)
{
	struct plan plan = {.count = 0};
	uint64_t bytes = PICTURES_ROOM * (uint64_t)render_pictures_bytes(scene);
	render_cameras_plan(scene, &plan);
	for (size_t i = 0; i < plan.count; i++)
		bytes += plan.lines[i].bytes;
	plan_finish(&plan);
	return bytes;
}

enum status render_cameras_fit(const struct scene *scene, uint64_t memory)
{
	const struct scene_camera *largest = NULL;
	const double needed = (double)bytes_of(scene);
	for (size_t i = 0; i < scene->camera_count; i++)
		if (largest == NULL || (int64_t)scene->cameras[i].width * scene->cameras[i].height > (int64_t)largest->width * largest->height)
			largest = &scene->cameras[i];
	if (largest == NULL || memory == 0 || needed <= (double)memory)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "cameras: their pictures take %.3g GB, and this machine has %.3g GB; give smaller sizes (the largest is %d x %d, of %s), or "
				       "the same size to several", needed / 1e9, (double)memory / 1e9, largest->width, largest->height, largest->name);
}

void render_cameras_plan(const struct scene *scene, struct plan *plan)
{
	const uint64_t samples = scene->view.samples > 1 ? (uint64_t)scene->view.samples : 1;
	const bool light = scene_draws_light(scene);
	const uint64_t shown = gpu_format_bytes(render_light_format(light ? EFFECT_BIT(EFFECT_LIGHT) : 0));
	for (size_t i = 0; i < scene->camera_count; i++) {
		const uint64_t pixels = (uint64_t)scene->cameras[i].width * (uint64_t)scene->cameras[i].height;
		if (is_first_measured(scene, i))
			add_texture(plan, 16 * pixels, "camera numbers");
		if (is_first_measured(scene, i) && samples > 1)
			add_texture(plan, 4 * pixels, "camera depth of one sample");
		if (is_shared(scene, i))
			continue;
		add_texture(plan, 4 * pixels, "camera colour");
		if (light)
			add_texture(plan, shown * pixels, "camera light");
		if (light)
			add_texture(plan, RENDER_METER_BYTES, "camera light meter");
		add_texture(plan, 4 * pixels * samples, "camera depth");
		if (samples > 1)
			add_texture(plan, shown * pixels * samples, "camera samples");
		if (scene_effects(scene, 0) >> EFFECT_SHADOW & 1)
			add_texture(plan, shown * pixels * samples, "camera ground without sun");
	}
}
