/* What a camera is, and where it was at each frame: camera.json, and the text files of COLMAP. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/aside.h"
#include "base/json.h"
#include "report/poses.h"

static const char *const kinds[] = {
	[SCENE_CHASE] = "chase", [SCENE_OVERHEAD] = "overhead", [SCENE_FIXED] = "fixed", [SCENE_MOUNTED] = "mounted", [SCENE_BY_POSES] = "poses",
};

/* The focal length in pixels, along both axes. */
static double focal_of(const struct scene_camera *camera)
{
	return camera->width / 2.0 / tan(camera->fov / 2);
}

/* Writes a file aside, then renames it. `print` writes what it holds. */
static enum status publish(const struct report_poses *poses, size_t index, const char *name,
			   void (*print)(const struct report_poses *poses, size_t index, FILE *file))
{
	char path[POSES_PATH];
	struct aside aside;
	report_poses_path(poses, index, name, path);
	TRY(aside_begin(&aside, path));
	print(poses, index, aside.file); /* a failure returns when the file is completed */
	return aside_end(&aside, false, STATUS_OK);
}

/* --- notes --- */

/* The eye of a camera on an object at the start of its path, where the ground is `ground` high. The soil carries a load at an unknown depth, here 0. */
static void eye_on(const struct body *body, const struct track_point *start, double ground, const double own[3], double eye[3])
{
	const struct scene_object *object = body->object;
	double axes[3][3];
	soil_axes(start->yaw, 0, 0, 0, axes);
	eye[0] = start->x;
	eye[1] = start->y;
	eye[2] = ground + soil_shape_reach(&object->shape, 0, 0) - object->sink;
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			eye[i] += own[k] * axes[k][i];
}

static enum status advise_camera(const struct world *world, struct store_reader *reader, const struct scene_camera *camera, scene_advice_fn tell,
				 void *user)
{
	const struct extent *extent = &world_resident(world)->meta->extent;
	const bool fixed = camera->aim.kind == SCENE_FIXED;
	const struct body *body = fixed ? NULL : world_body(world, camera->aim.object);
	struct store_sample at;
	struct track_point start;
	double eye[3];
	char text[400];
	memcpy(eye, camera->aim.eye, sizeof eye);
	if (!fixed) {
		motion_track_sample(body->track, 0, &start);
		TRY(store_sample(reader, start.x, start.y, &at));
		if (at.nodata || at.outside)
			return STATUS_OK; /* told of the path */
		eye_on(body, &start, at.base, camera->aim.eye, eye);
	}
	TRY(store_sample(reader, eye[0], eye[1], &at));
	if (fixed && at.outside)
		snprintf(text, sizeof text, "cameras.%s.pose.at: %.9g, %.9g m is off the terrain, which is 0 to %g, 0 to %g m: the place of a camera is in local "
					    "metres, and coordinates does not hold for it", camera->name, eye[0], eye[1],
			 extent_side(extent, 0), extent_side(extent, 1));
	else if (!at.outside && !at.nodata && eye[2] < at.base && fixed)
		snprintf(text, sizeof text, "cameras.%s.pose.at: its height is %.3f m, and the ground there is %.3f m high, so it is below the ground: give a height "
					    "above that (heights are as the store has them, places local metres)", camera->name, eye[2], at.base);
	else if (!at.outside && !at.nodata && eye[2] < at.base)
		snprintf(text, sizeof text, "cameras.%s.pose.at: the camera is %.3f m below the soil when the drive begins; the place is forward, left and up from the "
					    "centre of %s, in metres", camera->name, at.base - eye[2], body->object->name);
	else
		return STATUS_OK;
	tell(user, text);
	return STATUS_OK;
}

void report_cameras_advise(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world_scene(world);
	struct store_reader *reader = NULL;
	if (scene->camera_count == 0 || world_resident(world)->store == NULL || world_params(world)->ranks != NULL || store_reader_create(world_resident(world)->store, &reader) != STATUS_OK)
		return;
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		const bool on_object = camera->aim.kind == SCENE_MOUNTED && camera->aim.vehicle == 0 && world_body(world, camera->aim.object)->kind == BODY_PATH;
		const bool advised = camera->baseline == 0 && (camera->aim.kind == SCENE_FIXED || on_object);
		if (advised && advise_camera(world, reader, camera, tell, user) != STATUS_OK)
			break; /* a tile that cannot be read is told when it is drawn */
	}
	store_reader_destroy(reader);
}

/* --- COLMAP (colmap.github.io/format.html): pixel centres at halves, axes right, down, ahead; poses from the world to the camera --- */

static void print_model(const struct report_poses *poses, size_t index, FILE *file)
{
	const struct scene_camera *camera = &world_scene(poses->world)->cameras[index];
	const double focal = focal_of(camera);
	fprintf(file, "# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY\n1 PINHOLE %d %d %.9f %.9f %.9f %.9f\n", camera->width, camera->height, focal, focal,
		camera->width / 2.0, camera->height / 2.0);
}

static enum scene_image first_image(const struct scene_camera *camera)
{
	int image = 0;
	while (!(camera->images >> image & 1))
		image++;
	return (enum scene_image)image;
}

static void print_images(const struct report_poses *poses, size_t index, FILE *file)
{
	const struct scene_camera *camera = &world_scene(poses->world)->cameras[index];
	const struct poses_of *of = &poses->cameras[index];
	fputs("# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points, which is empty\n", file);
	for (size_t i = 0; i < of->count; i++) {
		const struct poses_row *row = &of->rows[i];
		const double x = -row->q[0], y = -row->q[1], z = -row->q[2], w = row->q[3], *a = row->at;
		/* t = -R a, R that of the turned-back quaternion */
		const double t[3] = {
			-((1 - 2 * (y * y + z * z)) * a[0] + 2 * (x * y - w * z) * a[1] + 2 * (x * z + w * y) * a[2]),
			-(2 * (x * y + w * z) * a[0] + (1 - 2 * (x * x + z * z)) * a[1] + 2 * (y * z - w * x) * a[2]),
			-(2 * (x * z - w * y) * a[0] + 2 * (y * z + w * x) * a[1] + (1 - 2 * (x * x + y * y)) * a[2]),
		};
		fprintf(file, "%zu %.12f %.12f %.12f %.12f %.9f %.9f %.9f 1 %s/%06lld.png\n\n", i + 1, w, x, y, z, t[0], t[1], t[2],
			scene_image_name(first_image(camera)), (long long)row->frame);
	}
}

static void print_points(const struct report_poses *poses, size_t index, FILE *file)
{
	fputs("# POINT3D_ID X Y Z R G B ERROR TRACK: none\n", file);
}

/* --- camera.json --- */

static void add_conventions(cJSON *root)
{
	cJSON *told = cJSON_AddObjectToObject(root, "conventions");
	cJSON_AddStringToObject(told, "world", "x east, y north, z up; m from the store's south-west post, heights as the store has them");
	cJSON_AddStringToObject(told, "camera", "x right, y down, z ahead");
	cJSON_AddStringToObject(told, "orientation", "quaternion x, y, z, w that turns the camera's axes into the world's");
	cJSON_AddStringToObject(told, "sun", "degrees: azimuth clockwise from the store's north, height above the horizon; with a time, of each frame too");
	cJSON_AddStringToObject(told, "pixels", "x right, y down from the upper left corner of the picture; the first pixel's centre is (0.5, 0.5)");
	cJSON_AddStringToObject(told, "projection", "pixel x = cx + fx X / Z, pixel y = cy + fy Y / Z, with X, Y, Z along the camera's axes");
}

/* The soils that a picture of classes has the numbers of. */
static void add_soils(cJSON *object, const struct scene *scene)
{
	cJSON *soils = cJSON_AddArrayToObject(object, "soils");
	for (int i = 0; i < scene->soil_count; i++) {
		cJSON *soil = cJSON_CreateObject();
		if (!cJSON_AddItemToArray(soils, soil)) {
			cJSON_Delete(soil);
			return;
		}
		json_integer(soil, "index", i);
		cJSON_AddStringToObject(soil, "name", scene->soil_names[i]);
		if (scene_soil_value(scene, i) >= 0)
			json_integer(soil, "map_value", scene_soil_value(scene, i));
		else
			cJSON_AddNullToObject(soil, "map_value");
	}
}

/* The bodies that a picture of instances has the numbers of: "number": "name". */
static void add_instances(cJSON *object, const struct world *world)
{
	cJSON *instances = cJSON_AddObjectToObject(object, "instances");
	const size_t end = world_figures(world)->body_count + world_body_count(world);
	for (uint32_t number = 1; number <= end; number++) {
		const char *name = world_instance_of(world, number);
		char key[16];
		if (name == NULL)
			continue;
		snprintf(key, sizeof key, "%u", number);
		cJSON_AddStringToObject(instances, key, name);
	}
}

static void add_measured(cJSON *images, const struct world *world, const struct scene_camera *camera)
{
	double unit, zero;
	if (camera->images >> SCENE_IMAGE_NORMALS & 1) {
		cJSON *normals = cJSON_AddObjectToObject(images, "normals");
		cJSON_AddStringToObject(normals, "png", "8-bit: 127.5 + 127.5 of each axis of the world; 0, 0, 0: sky");
		cJSON_AddStringToObject(normals, "npy", "float32, east, north, up; nan: sky");
	}
	if (camera->images >> SCENE_IMAGE_HEIGHT & 1) {
		cJSON *height = cJSON_AddObjectToObject(images, "height");
		render_height_scale(isnan(world_resident(world)->meta->low) ? 0 : world_resident(world)->meta->low, isnan(world_resident(world)->meta->high) ? 0 : world_resident(world)->meta->high, &unit, &zero);
		cJSON_AddStringToObject(height, "png", "16-bit: (height - png_zero) / png_unit; 0: sky");
		json_number(height, "png_unit", unit);
		json_number(height, "png_zero", zero);
		cJSON_AddStringToObject(height, "npy", "float64, m as the store has heights; nan: sky");
	}
	if (camera->images >> SCENE_IMAGE_CLASS & 1) {
		cJSON *class = cJSON_AddObjectToObject(images, "class");
		cJSON_AddStringToObject(class, "png", "8-bit: index of the soil; 252: a grain of soil in the air, 253: an object, 254: a vehicle, 255: sky");
		add_soils(class, world_scene(world));
	}
	if (camera->images >> SCENE_IMAGE_INSTANCE & 1) {
		cJSON *instance = cJSON_AddObjectToObject(images, "instance");
		cJSON_AddStringToObject(instance, "png", "16-bit: number of the body; 0: ground, soil in the air, sky");
		add_instances(instance, world);
	}
}

static void add_images(cJSON *root, const struct world *world, const struct scene_camera *camera)
{
	cJSON *images = cJSON_AddObjectToObject(root, "images");
	if (camera->images >> SCENE_IMAGE_COLOUR & 1)
		cJSON_AddStringToObject(cJSON_AddObjectToObject(images, "colour"), "png", "8-bit sRGB");
	if (camera->images >> SCENE_IMAGE_LINEAR & 1) {
		cJSON *linear = cJSON_AddObjectToObject(images, "linear");
		cJSON_AddStringToObject(linear, "png", "16-bit RGB, linear: light = png / 65535 * full_scale / exposure; the exposure of each frame is in frames.csv");
		json_number(linear, "full_scale", RENDER_LINEAR_FULL);
	}
	if (camera->images >> SCENE_IMAGE_DEPTH & 1) {
		cJSON *depth = cJSON_AddObjectToObject(images, "depth");
		cJSON_AddStringToObject(depth, "png", "16-bit; 0: sky, or beyond 65535 units");
		json_number(depth, "png_unit", camera->depth_unit);
		cJSON_AddStringToObject(depth, "npy", "float32, m along the camera's z axis; inf: sky");
	}
	add_measured(images, world, camera);
}

static void add_target(cJSON *root, const struct scene *scene, const struct scene_camera *camera)
{
	const struct scene_aim *aim = &camera->aim;
	if (aim->kind == SCENE_FIXED || aim->kind == SCENE_BY_POSES)
		return;
	cJSON_AddStringToObject(root, "on", aim->vehicle > 0 ? scene->vehicles[aim->vehicle - 1].name : scene->objects[aim->object].name);
	if (camera->body != NULL)
		cJSON_AddStringToObject(root, "body", camera->body);
}

static void add_stereo(cJSON *root, const struct scene *scene, const struct scene_camera *camera)
{
	if (camera->pair < 0)
		return;
	cJSON *stereo = cJSON_AddObjectToObject(root, "stereo");
	cJSON_AddStringToObject(stereo, camera->baseline > 0 ? "left" : "right", scene->cameras[camera->pair].name);
	json_number(stereo, "baseline", camera->baseline > 0 ? camera->baseline : scene->cameras[camera->pair].baseline);
}

/* The sun moves in the frames of a scene that gives a time. */
static void add_frames(cJSON *root, const struct poses_of *of, const struct report_sun *sun)
{
	cJSON *frames = cJSON_AddArrayToObject(root, "frames");
	for (size_t i = 0; i < of->count; i++) {
		cJSON *frame = cJSON_CreateObject();
		if (!cJSON_AddItemToArray(frames, frame)) {
			cJSON_Delete(frame);
			return;
		}
		json_integer(frame, "frame", of->rows[i].frame);
		json_number(frame, "time", of->rows[i].time);
		json_numbers(frame, "position", of->rows[i].at, 3);
		json_numbers(frame, "orientation", of->rows[i].q, 4);
		if (!sun->sun.light.timed)
			continue;
		const struct report_sun_place place = report_sun_at(sun, of->rows[i].time);
		json_numbers(frame, "sun", (const double[2]){place.azimuth, place.height}, 2);
	}
}

static void print_json(const struct report_poses *poses, size_t index, FILE *file)
{
	const struct scene *scene = world_scene(poses->world);
	const struct scene_camera *camera = &scene->cameras[index];
	const double focal = focal_of(camera);
	cJSON *root = cJSON_CreateObject();
	cJSON_AddStringToObject(root, "name", camera->name);
	cJSON_AddStringToObject(root, "kind", kinds[camera->aim.kind]);
	add_target(root, scene, camera);
	cJSON_AddStringToObject(root, "model", "pinhole");
	cJSON_AddStringToObject(root, "distortion", "none");
	json_integer(root, "width", camera->width);
	json_integer(root, "height", camera->height);
	json_number(root, "fx", focal);
	json_number(root, "fy", focal);
	json_number(root, "cx", camera->width / 2.0);
	json_number(root, "cy", camera->height / 2.0);
	json_number(root, "fov_horizontal", camera->fov * 180 / M_PI);
	json_number(root, "rate", camera->rate);
	add_images(root, poses->world, camera);
	add_stereo(root, scene, camera);
	add_conventions(root);
	struct report_sun sun;
	if (report_sun_find(poses->world, &sun) != STATUS_OK)
		sun = (struct report_sun){.drawn = false};
	report_sun_add(root, &sun);
	add_frames(root, &poses->cameras[index], &sun);
	char *text = json_text(root);
	cJSON_Delete(root);
	if (text != NULL)
		fprintf(file, "%s\n", text);
	cJSON_free(text);
}

/* --- run.json --- */

static void add_place(cJSON *camera, const char *name, const struct poses_row *row)
{
	cJSON *frame = cJSON_AddObjectToObject(camera, name);
	json_integer(frame, "frame", row->frame);
	json_number(frame, "time", row->time);
	json_numbers(frame, "position", row->at, 3);
	json_numbers(frame, "orientation", row->q, 4);
}

void report_cameras_add(cJSON *root, const struct scene *scene, const struct report_poses *poses)
{
	if (scene->camera_count == 0)
		return;
	cJSON *cameras = cJSON_AddObjectToObject(root, "cameras");
	bool numbered = false;
	for (size_t i = 0; i < scene->camera_count; i++)
		numbered |= scene->cameras[i].images >> SCENE_IMAGE_INSTANCE & 1;
	if (numbered && poses != NULL)
		add_instances(root, poses->world);
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		cJSON *object = cJSON_AddObjectToObject(cameras, camera->name), *images = NULL;
		cJSON_AddStringToObject(object, "kind", kinds[camera->aim.kind]);
		add_target(object, scene, camera);
		json_integer(object, "width", camera->width);
		json_integer(object, "height", camera->height);
		json_number(object, "fov_horizontal", camera->fov * 180 / M_PI);
		json_number(object, "rate", camera->rate);
		images = cJSON_AddArrayToObject(object, "images");
		for (int image = 0; image < SCENE_IMAGES; image++)
			if (camera->images >> image & 1)
				cJSON_AddItemToArray(images, cJSON_CreateString(scene_image_name((enum scene_image)image)));
		const struct poses_of *of = poses != NULL ? &poses->cameras[i] : NULL;
		json_number(object, "frames", of != NULL ? (double)of->count : (double)NAN);
		if (of == NULL || of->count == 0)
			continue;
		add_place(object, "first", &of->rows[0]);
		add_place(object, "last", &of->rows[of->count - 1]);
	}
}

enum status report_cameras(const struct report_poses *poses)
{
	for (size_t i = 0; poses != NULL && i < world_scene(poses->world)->camera_count; i++) {
		TRY(publish(poses, i, "camera.json", print_json));
		TRY(publish(poses, i, "cameras.txt", print_model));
		TRY(publish(poses, i, "images.txt", print_images));
		TRY(publish(poses, i, "points3D.txt", print_points));
	}
	return STATUS_OK;
}
