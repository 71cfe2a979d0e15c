/* furrow.h: pictures from a host's camera. */
#include "api/library.h"

#include <math.h>
#include <string.h>

/* The view of a scene without one: what `furrow view` and cameras of drives draw, too. */
static const char default_view[] = "view: {size: [640, 480], effects: [texture, detail, fog, sky, geomorph, skirts, objects, shadow]}\n";

/* Makes the view before the first picture of a scene without one. */
static enum status need_view(struct furrow_world *host)
{
	struct scene *defaults;
	enum status status;
	if (drive_view(host->drive) != NULL)
		return STATUS_OK;
	TRY(scene_load_text(default_view, NULL, NULL, 0, SCENE_HOST, &defaults));
	host->scene->view = defaults->view;
	scene_destroy(defaults);
	api_library_begin_gl(host);
	TRY_OR(failed, world_start_drawing(host->world));
	TRY_OR(failed, drive_start_view(host->drive));
	return STATUS_OK;
failed:
	host->scene->view.present = false;
	return status;
}

static enum status camera_of(const struct furrow_camera *from, struct render_camera *camera)
{
	double q[4], axes[3][3], length = 0, sum = 0;
	for (int i = 0; i < 3; i++)
		sum += fabs(from->pose.position[i]);
	for (int i = 0; i < 4; i++)
		length += from->pose.orientation[i] * from->pose.orientation[i];
	length = sqrt(length);
	if (!isfinite(sum) || !(fabs(length - 1) < 1e-3))
		return fail_with(STATUS_USAGE, "camera: its pose is none; give a place in m and a unit quaternion w, x, y, z");
	if (!(from->fovy > 0 && from->fovy < M_PI))
		return fail_with(STATUS_USAGE, "camera.fovy: %g is no angle of view; give radians above 0 and below pi", from->fovy);
	if (from->width < 1 || from->height < 1 || from->width > DRIVE_PICTURE_MOST || from->height > DRIVE_PICTURE_MOST)
		return fail_with(STATUS_USAGE, "camera: %u x %u pixels; give 1 to %u each", from->width, from->height, DRIVE_PICTURE_MOST);
	for (int i = 0; i < 4; i++)
		q[i] = from->pose.orientation[i] / length;
	world_axes(q, axes);
	*camera = (struct render_camera){.fov = from->fovy, .up = {axes[2][0], axes[2][1], axes[2][2]}};
	for (int i = 0; i < 3; i++) {
		camera->eye[i] = from->pose.position[i];
		camera->target[i] = from->pose.position[i] + axes[0][i];
	}
	return STATUS_OK;
}

/* Pictures come with the lowest row first. */
static void tell_colours(const uint8_t *pixels, uint32_t width, uint32_t height, uint8_t *rgb)
{
	for (uint32_t y = 0; y < height; y++) {
		const uint8_t *from = pixels + (size_t)(height - 1 - y) * width * 4;
		for (uint32_t x = 0; x < width; x++)
			memcpy(rgb + ((size_t)y * width + x) * 3, from + (size_t)x * 4, 3);
	}
}

static void turn_rows(float *values, uint32_t width, uint32_t height)
{
	for (uint32_t y = 0; y < height / 2; y++)
		for (uint32_t x = 0; x < width; x++) {
			float *a = &values[(size_t)y * width + x], *b = &values[(size_t)(height - 1 - y) * width + x], was = *a;
			*a = *b;
			*b = was;
		}
}

static enum status picture(struct furrow_world *host, const struct furrow_camera *from, uint8_t *rgb, float *depth)
{
	struct render_camera camera;
	const struct scene_view *asked = &host->scene->view;
	TRY(camera_of(from, &camera));
	if (depth != NULL && asked->present && asked->samples > 1)
		return fail_with(STATUS_INPUT, "depth: pictures of this scene have %d samples a pixel, and depth has one; set view.samples: 1", asked->samples);
	TRY(api_library_settle(host));
	TRY(need_view(host));
	struct view *view = drive_view(host->drive);
	TRY(render_view_follow_bodies(view));
	TRY(render_view_resize(view, from->width, from->height));
	uint8_t *pixels = rgb != NULL ? mem_alloc((size_t)from->width * from->height, 4) : NULL;
	if (rgb != NULL && pixels == NULL)
		return fail_memory("a picture");
	render_view_look_from(view, &camera);
	const double began = clock_seconds();
	const enum status status = render_view_picture(view, pixels, depth);
	if (status == STATUS_OK) {
		times_add(&drive_report(host->drive)->picture_ms, (clock_seconds() - began) * 1e3);
		if (rgb != NULL)
			tell_colours(pixels, from->width, from->height, rgb);
		if (depth != NULL)
			turn_rows(depth, from->width, from->height);
	}
	mem_free(pixels);
	return status;
}

static enum status check_camera(const struct furrow_camera *camera)
{
	TRY(api_library_need(camera, "camera"));
	return api_library_need_size(camera->size, sizeof *camera, sizeof *camera, "camera");
}

furrow_status furrow_render(struct furrow_world *world, const struct furrow_camera *camera, uint8_t *rgb, float *depth)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, check_camera(camera));
done:
	return api_library_leave(&call, status == STATUS_OK ? picture(world, camera, rgb, depth) : status);
}
