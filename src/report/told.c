/* Notes at the end of a drive: bodies that touched nothing, black pictures, and pictures that took most of the time. */
#include <math.h>

#include "report/report.h"

#define DEGREES (180 / M_PI)
#define SLOW_TIMES 20.0 /* pictures that take so many times as long as the steps are told, */
#define SLOW_MS 5000.0  /* from this time on */

/* --- bodies --- */

/* Path samples of an object that had ground, in this run. */
static int64_t samples_on_ground(const struct body *body)
{
	return body->next - body->skipped;
}

/* A body with a load is moved until the soil bears it, so it has contacts, but perhaps no post below it. */
static bool is_untouched(const struct body *body)
{
	return body->kind == BODY_PATH && samples_on_ground(body) > 0 && (body->near == 0 || body->windows + body->regions == 0);
}

static void tell_untouched(const struct world *world, scene_advice_fn tell, void *user)
{
	char text[480];
	for (size_t i = 0; i < world_scene(world)->object_count; i++) {
		const struct body *body = world_body(world, i);
		const struct scene_object *object = body->object;
		const double across = 2 * soil_shape_bound(&object->shape);
		if (!is_untouched(body))
			continue;
		if (object->load > 0)
			snprintf(text, sizeof text, "objects.%.200s: no post was below it in any of its %lld path samples, so nothing bore its load, and it left nothing: it is %.3g m "
						    "large, and posts are %.3g m apart; give a finer spacing%s", object->name, (long long)samples_on_ground(body), across, world_resident(world)->spacing,
				 object->mesh != NULL ? ", or another shape.mesh.scale if the mesh is not in metres" : "");
		else
			snprintf(text, sizeof text, "objects.%.200s: it touched the ground in none of its %lld path samples, and left nothing; %s", object->name,
				 (long long)samples_on_ground(body), object->path.has_z ? "lower the z of its path: it is a height as the store has it" : "give a sink above 0");
		tell(user, text);
	}
}

/* --- pictures --- */

static void say_why_black(const struct report *report, bool groundless, char *text, size_t size)
{
	struct report_sun sun;
	const struct world *world = report->world;
	if (groundless) {
		snprintf(text, size, "no ground is in view, so it shows the sky alone; turn the camera to the ground, or give view.effects: [sky]");
		return;
	}
	if (report_sun_find(world, &sun) != STATUS_OK || !sun.drawn) {
		snprintf(text, size, "look at view.sun and at where the camera is");
		return;
	}
	const struct report_sun_place now = report_sun_at(&sun, world_time(world));
	const double height = fmin(sun.begins.height, now.height);
	struct scene_light light = sun.sun.light;
	light.height = height / DEGREES;
	const double brighter = light.exposure == SCENE_EXPOSURE_FIXED ? render_sun_brightens(&light) : 1;
	if (height <= 0)
		snprintf(text, size, "the sun is %.1f degrees below the horizon, so nothing is lit, and no exposure helps; give %s", -height,
			 sun.sun.light.timed ? "another time in view.sun.time" : "a view.sun.height above 0");
	else if (brighter > 1.5)
		snprintf(text, size, "the sun is only %.1f degrees high, and lights little; view.exposure: sun makes pictures %.0f times as bright", height, brighter);
	else
		snprintf(text, size, "the sun is %.1f degrees high, so the camera sees only shadow, or it is inside the ground; move the camera, or give another view.sun",
			 height);
}

static void tell_black(const struct report *report, scene_advice_fn tell, void *user)
{
	struct render_pictures_figures figures;
	char text[640], why[280], others[60] = "";
	if (report->pictures == NULL)
		return;
	render_pictures_figures(report->pictures, &figures);
	if (figures.black == 0)
		return;
	if (figures.black > 1)
		snprintf(others, sizeof others, ", and %llu more", (unsigned long long)figures.black - 1);
	say_why_black(report, figures.groundless_black, why, sizeof why);
	snprintf(text, sizeof text, "%s: is black%s: %.3g %% of its pixels are darker than %u of 255: %s", figures.first_black, others, 100 * figures.dark, RENDER_BLACK + 1,
		 why);
	tell(user, text);
}

static void tell_white(const struct report *report, scene_advice_fn tell, void *user)
{
	struct render_pictures_figures figures;
	char text[640], why[280], others[60] = "";
	if (report->pictures == NULL)
		return;
	render_pictures_figures(report->pictures, &figures);
	if (figures.white == 0)
		return;
	if (figures.white > 1)
		snprintf(others, sizeof others, ", and %llu more", (unsigned long long)figures.white - 1);
	if (figures.groundless_white)
		snprintf(why, sizeof why, "no ground is in view, so it shows the sky alone; turn the camera to the ground");
	else if (figures.exposed_white > 1)
		snprintf(why, sizeof why, "it is exposed %.3g times as bright as fixed; give a lower ev, or exposure: auto", figures.exposed_white);
	else
		snprintf(why, sizeof why, "the sun is too bright for what is in view; give a lower ev, exposure: auto, or a darker view.sun.colour");
	snprintf(text, sizeof text, "%s: is white%s: %.3g %% of its pixels are brighter than %u of 255: %s", figures.first_white, others, 100 * figures.bright, RENDER_WHITE - 1,
		 why);
	tell(user, text);
}

/* Writes what draws most pixels a second, and what draws fewer. */
static void say_what_draws(const struct scene *scene, char *text, size_t size)
{
	const struct scene_view *view = &scene->view;
	double most = view->images > 0 ? (double)view->width * view->height / ((double)view->images * scene->time_step) : 0;
	snprintf(text, size, "view (%d x %d pixels every %lld steps); give larger view.images, or a smaller view.size", view->width, view->height,
		 (long long)view->images);
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		const double pixels = (scene_camera_measures(scene, camera) ? 2 : 1) * camera->rate * camera->width * camera->height;
		if (pixels <= most)
			continue;
		most = pixels;
		snprintf(text, size, "cameras.%s (%d x %d pixels, %.4g frames for each simulated second); give a lower rate or a smaller size", camera->name, camera->width,
			 camera->height, camera->rate);
	}
}

void report_slow_pictures(const struct scene *scene, const struct times *steps, const struct times *pictures, scene_advice_fn tell, void *user)
{
	char text[400], what[200];
	if (pictures->count == 0 || pictures->sum < SLOW_MS || pictures->sum < SLOW_TIMES * steps->sum)
		return;
	say_what_draws(scene, what, sizeof what);
	snprintf(text, sizeof text, "pictures took %.0f times as long as the steps: %.2g s each, %.3g s for all %llu; most of their pixels are of %s", pictures->sum / fmax(steps->sum, 1e-3),
		 times_mean(pictures) / 1e3, pictures->sum / 1e3, (unsigned long long)pictures->count, what);
	tell(user, text);
}

void report_end_notes(const struct report *report, scene_advice_fn tell, void *user)
{
	const struct world *world = report->world;
	report_groundless(world, tell, user);
	if (world_params(world)->ranks == NULL && !world_facts(world)->resumed.is)
		tell_untouched(world, tell, user);
	tell_black(report, tell, user);
	tell_white(report, tell, user);
	if (report->advised)
		report_slow_pictures(world_scene(world), &report->step_ms, &report->picture_ms, tell, user);
}
