/* What the pictures of a drive will cost, before it draws any: by figures that a bench has measured. */
#include <math.h>
#include <stdio.h>

#include "report/report.h"

struct frame_costs {
	double pixel, frame;                /* s */
	double sample;                      /* what each sample above one adds, of a picture without */
	double terrain_shadow;              /* times */
	double error, error_power;          /* what a pixel error adds, of a picture without: error / e^power */
	double error_shaded;                /* times that, where the ground is drawn for its shadows, too */
	double relief, relief_power;        /* as error, over relief */
};
#include "report/frame_costs.h"

#define SLOW_TIMES 3.0 /* from so many times as long as without these keys on, a note tells it, */
#define SLOW_S 30.0    /* if all pictures take as long as this */

/* How many times as long as without samples, a pixel error and the terrain's shadow. */
static double times_of(const struct scene *scene)
{
	const struct frame_costs *costs = &llvmpipe;
	const struct scene_view *view = &scene->view;
	const bool shadow = view->effects >> EFFECT_TERRAIN_SHADOW & 1, rough = scene->relief.classes > 0;
	double times = view->samples > 1 ? 1 + costs->sample * (view->samples - 1) : 1;
	if (shadow)
		times *= costs->terrain_shadow;
	if (view->pixel_error <= 0)
		return times;
	const double more = fmax(rough ? costs->relief * pow(view->pixel_error, -costs->relief_power) : 0,
				 costs->error * pow(view->pixel_error, -costs->error_power));
	return times * (1 + more * (shadow ? costs->error_shaded : 1));
}

static double seconds_of(const struct scene *scene, int width, int height)
{
	return (llvmpipe.frame + llvmpipe.pixel * width * height) * times_of(scene);
}

double report_camera_seconds(const struct scene *scene, const struct scene_camera *camera)
{
	return seconds_of(scene, camera->width, camera->height) * (scene_camera_measures(scene, camera) ? 2 : 1);
}

double report_view_seconds(const struct scene *scene)
{
	return scene->view.present && scene->view.images > 0 ? seconds_of(scene, scene->view.width, scene->view.height) : 0;
}

int64_t report_camera_frames(const struct scene *scene, const struct scene_camera *camera, int64_t steps)
{
	int64_t frames = (int64_t)floor((double)steps * camera->rate * scene->time_step + 1e-9) + 1;
	while (scene_camera_step(camera, scene->time_step, frames - 1) > steps)
		frames--;
	return frames;
}

double report_pictures_seconds(const struct scene *scene, int64_t steps, int64_t *count)
{
	const int64_t images = scene->view.present ? scene->view.images : 0;
	double seconds = images > 0 ? report_view_seconds(scene) * (double)(steps / images) : 0;
	*count = images > 0 ? steps / images : 0;
	for (size_t i = 0; i < scene->camera_count; i++) {
		const int64_t frames = report_camera_frames(scene, &scene->cameras[i], steps);
		seconds += report_camera_seconds(scene, &scene->cameras[i]) * (double)frames;
		*count += frames;
	}
	return seconds;
}

void report_seconds_text(double seconds, char text[32])
{
	if (seconds < 120)
		snprintf(text, 32, seconds < 10 ? "%.2g s" : "%.0f s", seconds);
	else if (seconds < 7200)
		snprintf(text, 32, "%.0f min", seconds / 60);
	else
		snprintf(text, 32, "%.3g h", seconds / 3600);
}

void report_pictures_advise(const struct scene *scene, int64_t steps, scene_advice_fn tell, void *user)
{
	const struct scene_view *view = &scene->view;
	int64_t count;
	const double times = times_of(scene), seconds = report_pictures_seconds(scene, steps, &count);
	char text[480], keys[120], one[32], all[32];
	int used = 0;
	if (times < SLOW_TIMES || seconds < SLOW_S || count == 0)
		return;
	keys[0] = '\0';
	if (view->pixel_error > 0)
		used = snprintf(keys, sizeof keys, "pixel_error: %g%s", view->pixel_error, scene->relief.classes > 0 ? " over relief" : "");
	if (view->samples > 1)
		used += snprintf(keys + used, sizeof keys - (size_t)used, "%ssamples: %d", used > 0 ? ", " : "", view->samples);
	if (view->effects >> EFFECT_TERRAIN_SHADOW & 1)
		snprintf(keys + used, sizeof keys - (size_t)used, "%sterrain_shadow", used > 0 ? ", " : "");
	report_seconds_text(seconds / (double)count, one);
	report_seconds_text(seconds, all);
	snprintf(text, sizeof text, "view: %s: a picture takes about %.0f times as long as without: with software GL %s of one processor each, %s for all %lld; on a GPU less. "
				    "A larger pixel_error, fewer samples or smaller pictures take less", keys, times, one, all, (long long)count);
	tell(user, text);
}
