/* furrow explain: the sun of pictures, what each camera writes, and what it costs. */
#include <math.h>
#include <stdio.h>

#include "base/json.h"
#include "explain.h"
#include "explain_layout.h"

/* The frames until the drive ends, with that of its beginning. */
static int64_t frames_of(const struct scene *scene, const struct report_plan *plan, const struct scene_camera *camera)
{
	int64_t frames = (int64_t)floor((double)plan->steps * camera->rate * scene->time_step + 1e-9) + 1;
	while (scene_camera_step(camera, scene->time_step, frames - 1) > plan->steps)
		frames--;
	return frames;
}

static void list_images(const struct scene_camera *camera, char *text, size_t size)
{
	size_t used = 0;
	text[0] = '\0';
	for (int image = 0; image < SCENE_IMAGES; image++)
		if (camera->images >> image & 1)
			used += (size_t)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", scene_image_name((enum scene_image)image));
}

/* The bytes that a frame has on its way from the GPU. */
static uint64_t frame_bytes(const struct scene_camera *camera)
{
	const int plain = __builtin_popcount(camera->images & ~SCENE_IMAGES_MEASURED), measured = camera->images & SCENE_IMAGES_MEASURED ? 4 : 0;
	return 4 * (uint64_t)camera->width * (uint64_t)camera->height * (uint64_t)(plain + measured);
}

void explain_sun_text(const struct report_plan *plan)
{
	const struct report_sun *sun = &plan->sun;
	if (!sun->drawn)
		return;
	printf("\nsun: azimuth %.1f degrees, clockwise from the store's north; %.1f degrees above the horizon\n", sun->begins.azimuth, sun->begins.height);
	if (sun->sun.light.timed)
		printf("  it moves: when the drive ends, azimuth %.1f, height %.1f degrees\n", sun->ends.azimuth, sun->ends.height);
}

void explain_cameras_text(const struct scene *scene, const struct report_plan *plan)
{
	if (scene->camera_count > 0)
		puts("\ncameras: each frame draws what it sees once, and for normals, height, class and instance once more");
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		char what[320], images[120];
		list_images(camera, images, sizeof images);
		snprintf(what, sizeof what, "  %-12s %d x %d, %g a second: %s frames of %s, %s each", camera->name, camera->width, camera->height, camera->rate,
			 layout_number((uint64_t)frames_of(scene, plan, camera)).text, images, layout_bytes(frame_bytes(camera)).text);
		puts(what);
	}
}

void explain_cameras_json(cJSON *root, const struct scene *scene, const struct report_plan *plan)
{
	cJSON *cameras = cJSON_AddObjectToObject(root, "cameras");
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		cJSON *object = cJSON_AddObjectToObject(cameras, camera->name);
		cJSON *images = cJSON_AddArrayToObject(object, "images");
		for (int image = 0; image < SCENE_IMAGES; image++)
			if (camera->images >> image & 1)
				cJSON_AddItemToArray(images, cJSON_CreateString(scene_image_name((enum scene_image)image)));
		json_integer(object, "frames", frames_of(scene, plan, camera));
		json_integer(object, "frame_bytes", (int64_t)frame_bytes(camera));
	}
}
