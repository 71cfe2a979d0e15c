/* The planet that the ground is on: pictures show it, and vehicles weigh as on it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "world/internal.h"

#define SAME_GRAVITY 0.02 /* people write 3.7, 3.71 or 3.72 for Mars */

static const struct {
	const char *name, *word;
	double radius, gravity; /* m, m/s2 */
} bodies[] = {
	[SCENE_EARTH] = {"the Earth", "earth", 6.375e6, 9.81},
	[SCENE_MARS] = {"Mars", "mars", 3.39e6, 3.71},
	[SCENE_MOON] = {"the Moon", "moon", 1.7374e6, 1.62},
};

/* Finds the body whose radius the WKT of an SRS has. GDAL is not asked: it takes long to load. Returns false if it is none of these. */
static bool body_of(const char *wkt, enum scene_body *body)
{
	const char *found = strstr(wkt, "ELLIPSOID[\"");
	const char *name = found != NULL ? strchr(found, '"') : NULL, *end = name != NULL ? strchr(name + 1, '"') : NULL;
	const double radius = end != NULL && end[1] == ',' ? strtod(end + 2, NULL) : 0;
	for (int i = SCENE_EARTH; i <= SCENE_MOON; i++)
		if (fabs(radius / bodies[i].radius - 1) < 0.01) {
			*body = (enum scene_body)i;
			return true;
		}
	return false;
}

/* Returns true if the scene gives this key, or a key in it. */
static bool gives(const struct scene *scene, const char *key)
{
	for (size_t i = 0; i < scene->value_count; i++)
		if (strncmp(scene->values[i].key, key, strlen(key)) == 0)
			return true;
	return false;
}

void world_settle_light(struct world *world)
{
	world->facts.light = world->scene->view.present || world->scene->view.light.on_body ? world->scene->view.light : scene_light_default(); /* a host may ask for a picture later */
	if (!world->facts.light.on_body)
		(void)body_of(world->resident.meta->srs, &world->facts.light.body);
}

static bool knows_body(const struct world *world)
{
	enum scene_body ground;
	return world->scene->view.light.on_body || (world->resident.store != NULL && body_of(world->resident.meta->srs, &ground));
}

bool world_assumes_gravity(const struct world *world)
{
	return !gives(world->scene, "gravity") && !(knows_body(world) && world->facts.light.body != SCENE_EARTH);
}

/* Tells if vehicles do not weigh as on their planet. Gravity of the Earth, if it is given, is that of a test on the Earth. */
static void advise_gravity(const struct world *world, enum scene_body body, bool given, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const char *whose = given ? "the scene's body is" : "the store is on";
	char text[240];
	if (!gives(scene, "gravity")) {
		snprintf(text, sizeof text, "gravity: it is not given, so vehicles weigh as on the Earth, and %s %s; give gravity: %g", whose,
			 bodies[body].name, bodies[body].gravity);
		if (body != SCENE_EARTH)
			tell(user, text);
		return;
	}
	for (int other = SCENE_MARS; other <= SCENE_MOON; other++)
		if (other != (int)body && fabs(scene->gravity / bodies[other].gravity - 1) < SAME_GRAVITY) {
			snprintf(text, sizeof text, "gravity: %g is that of %s, and %s %s; give gravity: %g%s%s", scene->gravity, bodies[other].name, whose,
				 bodies[body].name, bodies[body].gravity, given ? ", or view.body: " : "", given ? bodies[other].word : "");
			tell(user, text);
		}
}

/* Pictures of ground of the Earth may show another body: such ground is often used in its place. */
void world_advise_planet(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const bool given = scene->view.light.on_body;
	enum scene_body body = world->facts.light.body, ground = SCENE_EARTH;
	if (world->resident.store != NULL)
		(void)body_of(world->resident.meta->srs, &ground);
	char text[240];
	if (given && ground != SCENE_EARTH && ground != body) {
		snprintf(text, sizeof text, "view.body: the store is on %s, and pictures have the colours, the sky and the sun of %s; give view.body: %s, or leave it out",
			 bodies[ground].name, bodies[body].name, bodies[ground].word);
		tell(user, text);
	}
	if (scene->vehicle_count > 0 && knows_body(world))
		advise_gravity(world, body, given, tell, user);
}
