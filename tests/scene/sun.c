/* The sun of a time and a place, beside published values. */
#include <math.h>

#include "../support/near.h"
#include "fixture.h"
#include "scene/scene_sun.h"
#include "../support/program.h"

#define DEGREES (180 / M_PI)

static void look(enum scene_body body, const char *time, double longitude, double latitude, double *azimuth, double *height)
{
	double days;
	assert_true(scene_sun_time(time, &days));
	scene_sun_at(body, days, longitude / DEGREES, latitude / DEGREES, azimuth, height);
	*azimuth *= DEGREES;
	*height *= DEGREES;
}

/* NREL/TP-560-34302 (SPA), appendix A.5: zenith 50.11162, azimuth 194.34024; sunrise 13:12:43 and sunset 00:20:19 of that
 * day of UTC. */
static void the_example_of_spa_is_met(void **state)
{
	double azimuth, height;
	look(SCENE_EARTH, "2003-10-17T19:30:30Z", -105.1786, 39.742476, &azimuth, &height);
	assert_near(azimuth, 194.34024, 0.02);
	assert_near(90 - height, 50.11162, 0.02);
	/* At its rise the upper edge is seen: the middle is 0.8333 degrees below the horizon, of which the air takes 0.57. */
	look(SCENE_EARTH, "2003-10-17T13:12:43Z", -105.1786, 39.742476, &azimuth, &height);
	assert_near(height, -0.8333 + 0.57, 0.1);
	assert_true(azimuth > 90 && azimuth < 110);
	look(SCENE_EARTH, "2003-10-17T00:20:19Z", -105.1786, 39.742476, &azimuth, &height);
	assert_near(height, -0.8333 + 0.57, 0.1);
	assert_true(azimuth > 250 && azimuth < 270);
}

/* Equinox and solstices of 2026 (U.S. Naval Observatory): 20 March 14:46, 21 June 08:25, 21 December 20:50. At a pole the sun's height is its
 * declination, and what the air adds. */
static void it_is_as_far_north_as_the_season_has_it(void **state)
{
	double azimuth, height;
	look(SCENE_EARTH, "2026-03-20T14:46:00Z", 0, 90, &azimuth, &height);
	assert_near(height, 0.48, 0.02);
	look(SCENE_EARTH, "2026-06-21T08:25:00Z", 40, 90, &azimuth, &height);
	assert_near(height, 23.436 + 0.04, 0.02);
	look(SCENE_EARTH, "2026-12-21T20:50:00Z", 0, -90, &azimuth, &height);
	assert_near(height, 23.436 + 0.04, 0.02);
}

/* Meeus, example 53.a: 1992 April 12 at 0 h TD the sun is overhead at 67.89 east, 1.46 north. That is 58.8 s before 0 h UTC. */
static void the_example_of_meeus_is_met_on_the_moon(void **state)
{
	double azimuth, height;
	look(SCENE_MOON, "1992-04-11T23:59:01Z", 67.89, 1.46, &azimuth, &height);
	assert_near(height, 90, 0.1);
	look(SCENE_MOON, "1992-04-11T23:59:01Z", 0, 90, &azimuth, &height);
	assert_near(height, 1.46, 0.05);
	/* It rises where the colongitude says, and in the east. */
	look(SCENE_MOON, "1992-04-11T23:59:01Z", -22.11, 0, &azimuth, &height);
	assert_near(height, 0, 0.1);
	assert_near(azimuth, 90, 2);
}

/* The same example: 23:59:39 of mean time at the prime meridian, and 23:38:54 of true time. Then landings, whose local mean times NASA has published to
 * a minute: Curiosity 15:03, Perseverance 15:53. */
static void local_times_on_mars_are_the_published_ones(void **state)
{
	static const struct {
		const char *utc;
		double longitude, mean, within, apparent;
	} rows[] = {{"2000-01-06T00:00:00Z", 0, 23.99425, 2e-3, 23.64847},
		    {"2012-08-06T05:17:57Z", 137.4417, 15 + 3 / 60.0, 0.04, -1},
		    {"2021-02-18T20:43:49Z", 77.4508, 15 + 53 / 60.0, 0.04, -1}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		double days, mean, apparent;
		assert_true(scene_sun_time(rows[i].utc, &days));
		scene_mars_hours(days, rows[i].longitude * M_PI / 180, &mean, &apparent);
		assert_near(mean, rows[i].mean, rows[i].within);
		if (rows[i].apparent >= 0)
			assert_near(apparent, rows[i].apparent, rows[i].within);
	}
}

/* The worked example of Mars24: 2000-01-06 00:00:00 UTC: overhead at 174.72600 west, declination -25.22838. */
static void the_example_of_mars24_is_met(void **state)
{
	double azimuth, height;
	look(SCENE_MARS, "2000-01-06T00:00:00Z", -174.726, -25.22838, &azimuth, &height);
	assert_near(height, 90, 0.05);
	look(SCENE_MARS, "2000-01-06T00:00:00Z", 0, 90, &azimuth, &height);
	assert_near(height, -25.22838, 0.002);
}

static void what_is_no_time_is_refused(void **state)
{
	static const char *const none[] = {"", "now", "2026-11-27", "2026-11-27 16:00:00Z", "2026-11-27T16:00:00", "2026-13-27T16:00:00Z", "2026-02-29T00:00:00Z",
					   "2026-11-31T00:00:00Z", "2026-11-27T24:00:00Z", "2026-11-27T16:60:00Z", "2026-11-27T16:00:61Z", "1899-12-31T00:00:00Z",
					   "2101-01-01T00:00:00Z", "2026-11-27T16:00:00Z ", "2026-11-27T16:00:00Zx", "2026-11-27T16:00:nanZ"};
	double days;
	for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
		assert_false(scene_sun_time(none[i], &days));
	assert_true(scene_sun_time("2000-01-01T12:00:00Z", &days) && days == 0);
	assert_true(scene_sun_time("2024-02-29T12:00:00.5Z", &days));
	assert_near(days, 8825 + 0.5 / 86400, 1e-9);
}

TEST_PROGRAM(sun)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_example_of_spa_is_met),
		cmocka_unit_test(it_is_as_far_north_as_the_season_has_it),
		cmocka_unit_test(the_example_of_meeus_is_met_on_the_moon),
		cmocka_unit_test(the_example_of_mars24_is_met),
		cmocka_unit_test(local_times_on_mars_are_the_published_ones),
		cmocka_unit_test(what_is_no_time_is_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
