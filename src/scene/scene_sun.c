/*
 * Where the sun is in the sky of a place on the Earth, the Moon or Mars. Angles are in degrees here.
 *
 * Earth: J. Meeus, Astronomical Algorithms (2nd ed.), chapters 12, 22, 25 (lower accuracy: 0.01 degrees) and 16 (refraction).
 * Moon: the same, chapters 47 (the largest terms alone, since the sun is 389 times as far) and 53, without physical libration: within
 * 0.1 degrees.
 * Mars: M. Allison and M. McEwen, Planetary and Space Science 48 (2000), as Mars24 of NASA GISS has it: within 0.02 degrees.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_sun.h"

#define RADIANS (M_PI / 180)
#define CENTURY 36525.0
/* Terrestrial time less UTC in days. It is that of 2017 and later; in 1972 it was 27 s less, which is 0.0003 degrees of the sun's
 * longitude. */
#define TERRESTRIAL (69.184 / 86400)

static double sine(double degrees)
{
	return sin(degrees * RADIANS);
}

static double cosine(double degrees)
{
	return cos(degrees * RADIANS);
}

static double arc(double y, double x)
{
	return atan2(y, x) / RADIANS;
}

/* The sun's ecliptic longitude, of date, seen from the Earth. T: centuries since J2000. `apparent`: with aberration and nutation. */
static double sun_longitude(double T, bool apparent, double *distance)
{
	const double mean = 280.46646 + T * (36000.76983 + T * 0.0003032), M = 357.52911 + T * (35999.05029 - T * 0.0001537);
	const double e = 0.016708634 - T * (0.000042037 + T * 0.0000001267);
	const double centre = (1.914602 - T * (0.004817 + T * 0.000014)) * sine(M) + (0.019993 - T * 0.000101) * sine(2 * M) + 0.000289 * sine(3 * M);
	const double node = 125.04 - 1934.136 * T;
	*distance = 1.000001018 * (1 - e * e) / (1 + e * cosine(M + centre)); /* AU */
	return mean + centre - (apparent ? 0.00569 + 0.00478 * sine(node) : 0);
}

/* The point at which the sun is overhead: longitude east, and latitude. `days` since J2000, UTC. */
static void below_sun_earth(double days, double *longitude, double *latitude)
{
	const double T = (days + TERRESTRIAL) / CENTURY, U = days / CENTURY;
	double distance;
	const double lambda = sun_longitude(T, true, &distance), node = 125.04 - 1934.136 * T;
	const double tilt = 23.4392911 - T * (0.0130042 + T * (1.64e-7 - T * 5.04e-7)) + 0.00256 * cosine(node);
	const double ascension = arc(cosine(tilt) * sine(lambda), cosine(lambda));
	const double nutation = -0.00478 * sine(node) * cosine(tilt); /* of sidereal time */
	const double sidereal = 280.46061837 + 360.98564736629 * days + U * U * (0.000387933 - U / 38710000) + nutation;
	*latitude = asin(sine(tilt) * sine(lambda)) / RADIANS;
	*longitude = ascension - sidereal;
}

static void below_sun_moon(double days, double *longitude, double *latitude)
{
	const double T = (days + TERRESTRIAL) / CENTURY, inclination = 1.54242;
	const double mean = 218.3164477 + 481267.88123421 * T, D = 297.8501921 + 445267.1114034 * T, M = 357.5291092 + 35999.0502909 * T;
	const double m = 134.9633964 + 477198.8675055 * T, F = 93.2720950 + 483202.0175233 * T, node = 125.0445479 - 1934.1362891 * T;
	double au;
	const double sun = sun_longitude(T, true, &au);
	const double moon = mean + 6.288774 * sine(m) + 1.274027 * sine(2 * D - m) + 0.658314 * sine(2 * D) + 0.213618 * sine(2 * m) -
			    0.185116 * sine(M) - 0.114332 * sine(2 * F);
	const double beta = 5.128122 * sine(F) + 0.280602 * sine(m + F) + 0.277693 * sine(m - F) + 0.173237 * sine(2 * D - F);
	const double kilometres = 385000.56 - 20905.355 * cosine(m) - 3699.111 * cosine(2 * D - m) - 2955.968 * cosine(2 * D);
	/* the sun seen from the Moon */
	const double part = kilometres / (au * 149597870.7);
	const double lambda = sun + 180 + part / RADIANS * cosine(beta) * sine(sun - moon), height = part * beta;
	const double W = lambda - node;
	const double A = arc(sine(W) * cosine(height) * cosine(inclination) - sine(height) * sine(inclination), cosine(W) * cosine(height));
	*longitude = A - F;
	*latitude = asin(-sine(W) * cosine(height) * sine(inclination) - sine(height) * cosine(inclination)) / RADIANS;
}

/* Returns the mean solar time at the prime meridian, sols. */
static double mars_sols(double days)
{
	return (days + TERRESTRIAL - 4.5) / 1.0274912517 + 44796.0 - 0.0009626;
}

static void below_sun_mars(double days, double *longitude, double *latitude)
{
	static const struct {
		double size, years, phase;
	} pulls[] = {{0.0071, 2.2353, 49.409},   {0.0057, 2.7543, 168.173}, {0.0039, 1.1177, 191.837}, {0.0037, 15.7866, 21.736},
		     {0.0021, 2.1354, 15.704},   {0.0020, 2.4694, 95.528},  {0.0018, 32.8493, 49.095}};
	const double t = days + TERRESTRIAL, M = 19.3871 + 0.52402073 * t, fictitious = 270.3871 + 0.524038496 * t;
	double centre = (10.691 + 3e-7 * t) * sine(M) + 0.623 * sine(2 * M) + 0.050 * sine(3 * M) + 0.005 * sine(4 * M) + 0.0005 * sine(5 * M);
	for (size_t i = 0; i < sizeof pulls / sizeof pulls[0]; i++)
		centre += pulls[i].size * cosine(0.985626 * t / pulls[i].years + pulls[i].phase);
	const double Ls = fictitious + centre;
	const double equation = 2.861 * sine(2 * Ls) - 0.071 * sine(4 * Ls) + 0.002 * sine(6 * Ls) - centre;
	const double sols = mars_sols(days);
	*longitude = -(360 * (sols - floor(sols)) + equation + 180);
	*latitude = asin(0.42565 * sine(Ls)) / RADIANS + 0.25 * sine(Ls);
}

static double hours_of(double turns)
{
	const double hours = 24 * (turns - floor(turns));
	return hours < 24 ? hours : 0;
}

void scene_mars_hours(double days, double longitude, double *mean, double *apparent)
{
	const double east = longitude / RADIANS / 360;
	double overhead, latitude;
	below_sun_mars(days, &overhead, &latitude);
	*mean = hours_of(mars_sols(days) + east);
	*apparent = hours_of(0.5 + east - overhead / 360);
}

/* How much the Earth's air raises the sun that is at this height (Saemundsson, in Meeus 16.4). Below the horizon it fades out. */
static double refraction(double height)
{
	if (height < -2)
		return 0;
	const double raised = 1.02 / tan((fmax(height, -1) + 10.3 / (fmax(height, -1) + 5.11)) * RADIANS) / 60;
	return height < -1 ? raised * (height + 2) : fmax(raised, 0);
}

void scene_sun_at(enum scene_body body, double days, double longitude, double latitude, double *azimuth, double *height)
{
	double east, north;
	if (body == SCENE_MARS)
		below_sun_mars(days, &east, &north);
	else if (body == SCENE_MOON)
		below_sun_moon(days, &east, &north);
	else
		below_sun_earth(days, &east, &north);
	const double apart = east - longitude / RADIANS, here = latitude / RADIANS;
	const double up = sine(here) * sine(north) + cosine(here) * cosine(north) * cosine(apart);
	const double to_north = cosine(here) * sine(north) - sine(here) * cosine(north) * cosine(apart), to_east = cosine(north) * sine(apart);
	const double bearing = arc(to_east, to_north), raw = asin(fmin(fmax(up, -1), 1)) / RADIANS;
	*azimuth = (bearing < 0 ? bearing + 360 : bearing) * RADIANS;
	*height = (raw + (body == SCENE_EARTH ? refraction(raw) : 0)) * RADIANS;
}

/* Days from 2000-01-01 to a day of the Gregorian calendar (E. G. Richards, in the Explanatory Supplement, 2013). */
static double day_number(int year, int month, int day)
{
	const int before = (14 - month) / 12, y = year + 4800 - before, m = month + 12 * before - 3;
	return day + (153 * m + 2) / 5 + 365.0 * y + y / 4 - y / 100 + y / 400 - 32045 - 2451545;
}

bool scene_sun_time(const char *text, double *days)
{
	static const int lengths[] = {31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
	int year, month, day, hour, minute, end = 0;
	double second;
	if (strspn(text, "0123456789-T:.Z") != strlen(text) ||
	    sscanf(text, "%4d-%2d-%2dT%2d:%2d:%lfZ%n", &year, &month, &day, &hour, &minute, &second, &end) != 6 || text[end] != '\0' || end == 0)
		return false;
	const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
	if (year < 1900 || year > 2100 || month < 1 || month > 12 || day < 1 || day > lengths[month - 1] || (month == 2 && day == 29 && !leap) ||
	    hour < 0 || hour > 23 || minute < 0 || minute > 59 || !(second >= 0 && second < 61))
		return false;
	*days = day_number(year, month, day) - 0.5 + (hour + (minute + second / 60) / 60) / 24;
	return true;
}
