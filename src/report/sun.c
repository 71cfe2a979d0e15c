/* Where the sun of a drive's pictures is, for people who look at them and for programs that read camera.json. */
#include <math.h>
#include <stdio.h>

#include "base/json.h"
#include "report/report.h"

#define DEGREES (180 / M_PI)
#define STEPS 200 /* of the drive's time, in which the note looks for a sun below the horizon */

struct report_sun_place report_sun_at(const struct report_sun *sun, double time)
{
	struct report_sun_place place;
	render_sun_at(&sun->sun, time, &place.azimuth, &place.height);
	place.azimuth = fmod(fmod(place.azimuth * DEGREES, 360) + 360, 360);
	place.height *= DEGREES;
	place.mean_hours = place.solar_hours = NAN;
	const struct scene_light *light = &sun->sun.light;
	if (light->timed && light->body == SCENE_MARS)
		scene_mars_hours(light->days + time / 86400, light->longitude, &place.mean_hours, &place.solar_hours);
	return place;
}

enum status report_sun_find(const struct world *world, struct report_sun *out)
{
	const struct scene *scene = world_scene(world);
	*out = (struct report_sun){.drawn = scene->view.present};
	if (!out->drawn)
		return STATUS_OK;
	TRY(render_sun_find(&world_facts(world)->light, world_resident(world)->meta, &out->sun));
	out->begins = report_sun_at(out, 0);
	out->ends = report_sun_at(out, scene->end_time);
	return STATUS_OK;
}

void report_sun_add(cJSON *root, const struct report_sun *sun)
{
	if (!sun->drawn)
		return;
	cJSON *object = cJSON_AddObjectToObject(root, "sun");
	json_number(object, "azimuth", sun->begins.azimuth);
	json_number(object, "height", sun->begins.height);
	cJSON_AddBoolToObject(object, "moves", sun->sun.light.timed);
	if (!sun->sun.light.timed)
		return;
	json_number(object, "azimuth_at_end", sun->ends.azimuth);
	json_number(object, "height_at_end", sun->ends.height);
	if (!isnan(sun->begins.solar_hours)) {
		json_numbers(object, "local_mean_solar_time", (const double[2]){sun->begins.mean_hours, sun->ends.mean_hours}, 2);
		json_numbers(object, "local_true_solar_time", (const double[2]){sun->begins.solar_hours, sun->ends.solar_hours}, 2);
	}
	json_number(object, "longitude", sun->sun.light.longitude * DEGREES);
	json_number(object, "latitude", sun->sun.light.latitude * DEGREES);
}

/* Writes when the sun rises, if that is within a month: on the Moon a night takes two weeks. Otherwise an empty text. */
static void say_when_it_rises(const struct report_sun *sun, char *text, size_t size)
{
	const double minute = 60, day = 86400;
	double after = 0;
	text[0] = '\0';
	while (after < 31 * day && report_sun_at(sun, after).height <= 0)
		after += minute;
	if (after > 0 && after < 31 * day)
		snprintf(text, size, after < 2 * day ? "; it rises %.1f h after the drive begins" : "; it rises %.1f days after the drive begins",
			 after / (after < 2 * day ? 3600 : day));
}

void report_sun_advise(const struct world *world, scene_advice_fn tell, void *user)
{
	struct report_sun sun;
	char text[400], rises[80];
	int below = 0;
	if (report_sun_find(world, &sun) != STATUS_OK || !sun.drawn || !sun.sun.light.timed)
		return; /* where the place is not known, the view refuses the scene */
	for (int i = 0; i <= STEPS; i++)
		below += report_sun_at(&sun, world_scene(world)->end_time * i / STEPS).height <= 0;
	if (below == 0)
		return;
	say_when_it_rises(&sun, rises, sizeof rises);
	snprintf(text, sizeof text, "view.sun.time: the sun is below the horizon for %s of the drive (%.1f degrees high when it begins, %.1f when it ends), and pictures are "
				    "dark then%s; give a time of day, or view.sun.azimuth and height",
		 below > STEPS ? "all" : "a part", sun.begins.height, sun.ends.height, rises);
	tell(user, text);
}
