/* furrow explain: the sun of pictures, what each camera writes, and what it costs. */
#include <math.h>
#include <stdio.h>

#include "base/json.h"
#include "explain.h"
#include "explain_layout.h"

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
	const unsigned wide = camera->images >> SCENE_IMAGE_LINEAR & 1; /* four floats a pixel */
	const int plain = __builtin_popcount(camera->images & ~SCENE_IMAGES_MEASURED) + (wide != 0 ? 3 : 0), measured = camera->images & SCENE_IMAGES_MEASURED ? 4 : 0;
	return 4 * (uint64_t)camera->width * (uint64_t)camera->height * (uint64_t)(plain + measured);
}

/* Times of a Martian clock, whole minutes. */
static void print_hours(const struct report_sun_place *place)
{
	const int mean = (int)(place->mean_hours * 60), apparent = (int)(place->solar_hours * 60);
	printf("  local time on Mars when the drive begins: mean (LMST) %02d:%02d, true (LTST) %02d:%02d\n", mean / 60, mean % 60, apparent / 60, apparent % 60);
}

void explain_sun_text(const struct report_plan *plan)
{
	const struct report_sun *sun = &plan->sun;
	if (!sun->drawn)
		return;
	printf("\nsun: azimuth %.1f degrees, clockwise from the store's north; %.1f degrees above the horizon\n", sun->begins.azimuth, sun->begins.height);
	if (!isnan(sun->begins.solar_hours))
		print_hours(&sun->begins);
	if (sun->sun.light.timed)
		printf("  it moves: when the drive ends, azimuth %.1f, height %.1f degrees\n", sun->ends.azimuth, sun->ends.height);
}

/* What all pictures cost. */
static void tell_cost(const struct scene *scene, const struct report_plan *plan)
{
	int64_t count;
	char all[32], one[32];
	const double seconds = report_pictures_seconds(scene, plan->steps, &count), view = report_view_seconds(scene);
	if (count == 0)
		return;
	report_seconds_text(seconds, all);
	report_seconds_text(view, one);
	printf("\npictures: about %s of one processor with software GL", all);
	printf(" (within a factor of three)%s%s\n", view > 0 ? "\n  of the view: each about " : "", view > 0 ? one : "");
}

void explain_cameras_text(const struct scene *scene, const struct report_plan *plan)
{
	if (scene->camera_count > 0)
		puts("\ncameras: each frame draws what it sees once, and for normals, height, class and instance once more");
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		char what[320], images[120], one[32];
		list_images(camera, images, sizeof images);
		report_seconds_text(report_camera_seconds(scene, camera), one);
		snprintf(what, sizeof what, "  %-12s %d x %d, %g a second: %s frames of %s, %s and about %s each", camera->name, camera->width, camera->height, camera->rate,
			 layout_number((uint64_t)report_camera_frames(scene, camera, plan->steps)).text, images, layout_bytes(frame_bytes(camera)).text, one);
		puts(what);
	}
	tell_cost(scene, plan);
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
		json_integer(object, "frames", report_camera_frames(scene, camera, plan->steps));
		json_integer(object, "frame_bytes", (int64_t)frame_bytes(camera));
		json_number(object, "frame_seconds", report_camera_seconds(scene, camera));
	}
	int64_t count;
	json_number(root, "pictures_seconds", report_pictures_seconds(scene, plan->steps, &count));
}
