/*
 * Finds settings of a scene that have no effect, or none that a user can see, and tells the user about each. One function checks
 * one rule. A rule never guesses: it holds for any ground. Impossible settings are not handled here; scene_check.c refuses them.
 * Values that are probably in a wrong unit: scene_units.c.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"

struct adviser {
	const struct scene *scene;
	double spacing; /* 0: not known, and what depends on it is not told */
	scene_advice_fn tell;
	void *user;
};

static void advise(const struct adviser *adviser, const char *format, ...) FURROW_PRINTF(2, 3);
static void advise(const struct adviser *adviser, const char *format, ...)
{
	char text[400];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	adviser->tell(adviser->user, text);
}

enum status scene_tell_unused(struct scene *scene, const char *format, ...)
{
	char text[400];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	TRY(mem_resize(&scene->unused, scene->unused_count + 1, sizeof *scene->unused, "reading the scene"));
	scene->unused[scene->unused_count] = mem_strdup(text);
	return scene->unused[scene->unused_count++] != NULL ? STATUS_OK : fail_memory("reading the scene");
}

/* --- ways --- */

static bool same_place(const struct scene_waypoint *a, const struct scene_waypoint *b)
{
	return a->x == b->x && a->y == b->y && a->z == b->z && a->yaw == b->yaw && a->pitch == b->pitch && a->roll == b->roll;
}

static bool is_fixed(const struct scene_path *path)
{
	if (path->count == 0)
		return false;
	for (size_t i = 1; i < path->count; i++)
		if (!same_place(&path->points[i], &path->points[0]))
			return false;
	return true;
}

static double length_between(const struct scene_waypoint *a, const struct scene_waypoint *b)
{
	return sqrt((b->x - a->x) * (b->x - a->x) + (b->y - a->y) * (b->y - a->y) + (b->z - a->z) * (b->z - a->z));
}

/* Tells whether the way between its waypoints is known here, in metres. */
static bool has_metres(const struct scene *scene, const struct scene_path *path)
{
	return scene->coordinates != SCENE_SRS && !path->degrees && !path->smooth && path->beside[0] == 0 && path->beside[1] == 0;
}

/* When it begins, s. */
static double path_begin(const struct scene_path *path)
{
	return (path->timed ? path->points[0].t : 0) + path->delay;
}

/* When its last path sample is due, s; INFINITY: never, or not known here. */
static double path_end(const struct scene *scene, const struct scene_path *path)
{
	double length = 0;
	if (path->count == 0)
		return INFINITY; /* the host moves it */
	if (path->timed)
		return path->points[path->count - 1].t + path->delay;
	if (is_fixed(path))
		return path->delay;
	if (path->loop || !has_metres(scene, path))
		return INFINITY;
	for (size_t i = 1; i < path->count; i++)
		length += length_between(&path->points[i - 1], &path->points[i]);
	return length / path->speed + path->delay;
}

/* Metres a second along its way, at most; INFINITY: not known here. */
static double path_fastest(const struct scene *scene, const struct scene_path *path)
{
	double fastest = 0;
	if (path->count == 0)
		return INFINITY;
	if (is_fixed(path))
		return 0;
	if (!path->timed && path->beside[1] == 0)
		return path->speed;
	if (path->has_attitude || !has_metres(scene, path))
		return INFINITY;
	for (size_t i = 1; i < path->count; i++)
		fastest = fmax(fastest, length_between(&path->points[i - 1], &path->points[i]) /
						(path->points[i].t - path->points[i - 1].t));
	return fastest;
}

static bool all_stand_still(const struct scene *scene)
{
	if (scene_moves_bodies(scene))
		return false; /* more may come */
	for (size_t i = 0; i < scene->object_count; i++)
		if (!is_fixed(&scene->objects[i].path))
			return false;
	return true;
}

/* Some are there only from a later time on. */
static bool all_are_there(const struct scene *scene)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].path.count > 0 && path_begin(&scene->objects[i].path) > 0)
			return false;
	return true;
}

static bool moves_soil(const struct scene *scene)
{
	return scene->interval > 0;
}

static double steps_of(const struct scene *scene)
{
	return ceil(scene->end_time / scene->time_step - 1e-9);
}

/* Returns true if gravity decides what a soil weighs. */
static bool weighs_soil(const struct scene *scene)
{
	for (int i = 0; i < scene->soil_count && deform_model_reads(scene->model, "density"); i++)
		if (!scene_soil_given(scene, i, "unit_weight"))
			return true;
	return false;
}

/* --- the drive --- */

static void advise_time(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (scene->time_step > scene->end_time)
		advise(adviser, "time_step: %g s is longer than the drive, %g s: it is one step; give less", scene->time_step,
		       scene->end_time);
	/* Soil may go on relaxing after the last path sample, and a fixed camera shows that. */
	double last = 0;
	for (size_t i = 0; i < scene->object_count; i++)
		last = fmax(last, path_end(scene, &scene->objects[i].path));
	if (scene->object_count > 0 && !scene_moves_bodies(scene) && !moves_soil(scene) && !all_stand_still(scene) && scene->end_time >= last + 2 * scene->time_step)
		advise(adviser, "end_time: the last object is at its path's end after %.6g s, and nothing changes until %g s; end "
				"then, or give a longer path",
		       last, scene->end_time);
	/* Vehicles have weight, and soil where the model reads it. Loads are newtons. */
	if (scene->vehicle_count == 0 && scene->gravity != scene_absent("gravity") && scene->thrown == SCENE_THROWN_OFF && !weighs_soil(scene))
		advise(adviser, "gravity: %g m/s2 changes nothing: a load is in N, and a soil has its unit_weight; give those for "
				"where it is, and take gravity away",
		       scene->gravity);
}

/* Tells the settings that are only for objects, if the scene has no objects. */
static void advise_without_objects(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (scene->object_count > 0 || scene_moves_bodies(scene))
		return;
	if (scene->coordinates != SCENE_LOCAL)
		advise(adviser, "coordinates: are of paths, and there is none; add an object, or take them away");
	if (scene->model != DEFORM_MODEL_DEFAULT)
		advise(adviser, "redistribute.model: %s moves the soil that objects press, and there is none; add one, or take it away",
		       deform_model_row(scene->model)->name);
	if (scene->outside == SCENE_SKIP)
		advise(adviser, "outside: is of objects, and there is none; add one, or take it away");
	if (scene->forces > 0)
		advise(adviser, "output.forces: are of objects, and there is none; add one, or take them away");
	if (scene->view.images > 0 && steps_of(scene) >= 2 * (double)scene->view.images)
		advise(adviser, "view.images: nothing moves: all of its %.0f pictures are the same; one is enough, with end_time %.6g",
		       floor(steps_of(scene) / (double)scene->view.images), (double)scene->view.images * scene->time_step);
}

/* --- the ground --- */

static bool is_one_soil(const struct scene *scene)
{
	for (int i = 1; i < scene->soil_count; i++)
		if (memcmp(&scene->soils[i], &scene->soils[0], sizeof scene->soils[0]) != 0)
			return false;
	return true;
}

static void advise_ground(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (scene->object_count == 0)
		return;
	if (scene->soil_map != NULL && scene->soil_default && is_one_soil(scene) && !scene_draws_classes(scene))
		advise(adviser, "soil.map: all its classes are the default's soil; give them others, or one soil and no map");
	if (deform_model_row(scene->model)->smooths && all_stand_still(scene))
		advise(adviser, "redistribute.model: %s smooths where an object leaves, and none moves; let one move, or take it away",
		       deform_model_row(scene->model)->name);
	if (!moves_soil(scene))
		return;
	bool lays_none = deform_model_takes(scene->model, "bulldozing") && scene->bulldozing == 0 && scene->depth == 0;
	if (lays_none && scene->iterations > scene_absent("redistribute.iterations"))
		advise(adviser, "redistribute.iterations: no soil is laid (bulldozing 0), and none is loose (depth 0): nothing slides "
				"but what earlier drives laid; give bulldozing or depth, or 1");
	if (scene->interval > scene->end_time)
		advise(adviser, "redistribute.interval: %g s is longer than the drive, %g s: between sweeps nothing slides; give less",
		       scene->interval, scene->end_time);
	if (scene->undisturbed == SCENE_SLIDES && scene->depth == 0)
		advise(adviser, "redistribute.undisturbed: slides, but none of it is loose (depth 0): it is stable; give a depth, or "
				"stable");
}

/* Depth is that of sliding. It is taken for the thickness of a layer, and nothing is firm below it. */
static void advise_depth(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (!deform_tells_forces(scene->model) || scene->depth <= 0)
		return;
	for (size_t i = 0; i < scene->object_count; i++)
		for (int k = 0; k < scene->soil_count; k++) {
			const struct scene_object *object = &scene->objects[i];
			const double sinks = object->load > 0 ? soil_sinkage_guess(&object->shape, &scene->soils[k], object->load) : 0;
			if (sinks <= scene->depth || scene->soils[k].over != NULL)
				continue;
			advise(adviser, "redistribute.depth: %g m is how deep soil slides, and no firm ground begins there: %s sinks by about %.2g m; for firm ground "
					"below give soil.thickness and soil.over, or take it away", scene->depth, object->name, sinks);
			return;
		}
}

static void advise_attributes(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (scene->disturbance && !scene->view.present && !scene->view.left_out)
		advise(adviser, "attributes.disturbance: no picture shows it: it is kept for query and for later drives that draw it, at %s a post; add a view, or take "
				"it away", scene->heals > 0 ? "4 bytes" : "1 byte");
}

/* --- objects --- */

/* Returns the width of an object's trail in metres. If posts are that far apart, the trail may miss them all. INFINITY: not
 * known here. */
static double narrowest(const struct scene_object *object)
{
	const struct soil_shape *shape = &object->shape;
	/* What goes straight ahead meets a post sooner or later, however short it is. */
	bool ahead = !scene_is_turned(object) && !is_fixed(&object->path);
	if (shape->kind == SOIL_WHEEL)
		return ahead ? shape->width : fmin(shape->width, 2 * shape->radius);
	if (shape->kind == SOIL_SPHERE)
		return 2 * shape->radius;
	if (shape->kind == SOIL_CYLINDER || shape->kind == SOIL_CAPSULE) /* a cylinder may lie */
		return scene_is_turned(object) && shape->kind == SOIL_CYLINDER ? fmin(shape->length, 2 * shape->radius) : 2 * shape->radius;
	if ((shape->kind != SOIL_BOX && shape->kind != SOIL_ELLIPSOID) || scene_is_turned(object))
		return INFINITY;
	if (shape->kind == SOIL_ELLIPSOID)
		return 2 * (ahead ? shape->size[1] : fmin(shape->size[0], shape->size[1]));
	return ahead ? shape->size[1] : fmin(shape->size[0], shape->size[1]);
}

/* Metres between the prints of bars, on the ground. */
static double pitch_of(const struct soil_shape *shape, double slip)
{
	return shape->grousers > 0 ? 2 * M_PI * shape->radius * (1 - slip) / shape->grousers : INFINITY;
}

static double grouser_pitch(const struct scene_object *object)
{
	return pitch_of(&object->shape, object->slip);
}

/* Objects that are alike are told of once. */
struct alike {
	size_t count;
	char others[48]; /* ", as of 3 others,", or "," */
};
static void say_alike(struct alike *alike)
{
	if (alike->count == 0)
		snprintf(alike->others, sizeof alike->others, ",");
	else
		snprintf(alike->others, sizeof alike->others, ", as of %zu other%s,", alike->count, alike->count > 1 ? "s" : "");
}

static bool is_first_alike(const struct scene *scene, const struct scene_object *object, struct alike *alike)
{
	*alike = (struct alike){.count = 0};
	for (const struct scene_object *other = scene->objects; other < scene->objects + scene->object_count; other++) {
		if (narrowest(other) != narrowest(object) || grouser_pitch(other) != grouser_pitch(object))
			continue;
		if (other < object)
			return false;
		alike->count += other > object;
	}
	say_alike(alike);
	return true;
}

void scene_advise_narrow(const char *key, double across, size_t others, double spacing, scene_advice_fn tell, void *user)
{
	const struct adviser adviser = {.tell = tell, .user = user};
	struct alike alike = {.count = others};
	say_alike(&alike);
	if (across < spacing * (1 - SPACING_PRINTED))
		advise(&adviser, "%s: is %g m across%s and posts are %g m apart: it can pass between them and leave nothing; give a spacing of at most %s",
		       key, across, alike.others, spacing, number_at_most(across, 6).text);
}

void scene_advise_grousers(const char *key, const struct soil_shape *shape, double slip, size_t others, double spacing, scene_advice_fn tell,
			   void *user)
{
	const struct adviser adviser = {.tell = tell, .user = user};
	struct alike alike = {.count = others};
	const double pitch = pitch_of(shape, slip);
	say_alike(&alike);
	if (pitch < 2 * spacing * (1 - SPACING_PRINTED))
		advise(&adviser, "%s: their prints are %.3g m apart%s less than two posts of %g m: the ground cannot tell them apart; give fewer, or a "
				 "spacing of at most %s", key, pitch, alike.others, spacing, number_at_most(pitch / 2, 3).text);
}

static void advise_shape(const struct adviser *adviser, const struct scene_object *object)
{
	struct alike alike;
	if (!is_first_alike(adviser->scene, object, &alike))
		return;
	double spacing = adviser->spacing;
	char key[160];
	snprintf(key, sizeof key, "objects.%s.shape", object->name);
	scene_advise_narrow(key, narrowest(object), alike.count, spacing, adviser->tell, adviser->user);
	snprintf(key, sizeof key, "objects.%s.shape.wheel.grousers", object->name);
	scene_advise_grousers(key, &object->shape, object->slip, alike.count, spacing, adviser->tell, adviser->user);
}

static void advise_path(const struct adviser *adviser, const struct scene_object *object)
{
	const struct scene *scene = adviser->scene;
	const struct scene_path *path = &object->path;
	if (path->count > 0 && path_begin(path) > scene->end_time)
		advise(adviser, "objects.%s.path: begins after %g s, and the drive ends after %g s: it never touches the ground; end later, or "
				"take it away",
		       object->name, path_begin(path), scene->end_time);
	if (path->loop && is_fixed(path))
		advise(adviser, "objects.%s.path.loop: its points are one place: there is no way round; give others, or take it away",
		       object->name);
	if (object->slip != 0 && is_fixed(path))
		advise(adviser, "objects.%s.slip: a wheel or a belt that stands does not turn; give it a way, or take it away", object->name);
}

/* Returns true if the surface is nowhere weaker than the soil, which sticks to it no better without its adhesion. */
static bool is_no_weaker(const struct scene *scene, const struct soil_interface *interface)
{
	bool differs = scene->raster_count > 0; /* not known here */
	for (int i = 0; i < scene->soil_count; i++) {
		const struct soil_numbers *soil = &scene->soils[i];
		const double sticks = soil_own_adhesion(soil->cohesion);
		const bool weaker = (interface->has_friction && interface->friction_angle < soil->friction_angle) || (interface->has_adhesion && interface->adhesion < sticks);
		const bool stronger = (interface->has_friction && interface->friction_angle > soil->friction_angle) || (interface->has_adhesion && interface->adhesion > sticks);
		differs = differs || weaker || (stronger && sticks < soil->cohesion);
	}
	return !differs;
}

static void advise_interface(const struct adviser *adviser, const struct scene_object *object)
{
	const struct scene *scene = adviser->scene;
	if (!object->interface.has_friction && !object->interface.has_adhesion)
		return;
	if (is_no_weaker(scene, &object->interface))
		advise(adviser, "objects.%s.interface: its surface is no weaker than the soil, which shears within itself: it changes nothing; "
				"give less, or take it away",
		       object->name);
	else if (object->load == 0 && scene->forces == 0 && !scene->hosted)
		advise(adviser, "objects.%s.interface: it changes forces alone, and none is computed; give a load or output.forces, or take it "
				"away",
		       object->name);
}

static void advise_forces(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	double fastest = 0;
	for (size_t i = 0; i < scene->object_count; i++)
		fastest = fmax(fastest, path_fastest(scene, &scene->objects[i].path));
	if (scene->object_count == 0 || scene->vehicle_count > 0 || scene->forces == 0)
		return;
	if (!deform_tells_forces(scene->model))
		advise(adviser, "output.forces: model %s computes no force: objects.csv has where the objects are and how deep, and nan as forces; "
				"redistribute: {model: %s} computes them", deform_model_row(scene->model)->name, scene_models_with_forces().text);
	double samples = adviser->spacing > 0 || fastest == 0 ? fastest / fmax(adviser->spacing, 1e-9) : INFINITY;
	if (scene->forces > samples && samples > 0)
		advise(adviser, "output.forces: %g rows a second, and no object comes to more than %s posts in one: rows between repeat the "
				"last; give at most that",
		       scene->forces, number_at_most(samples, 4).text);
	if (samples == 0 && all_are_there(scene) && scene->forces * scene->end_time >= 1)
		advise(adviser, "output.forces: no object moves: all rows of an object are the same; one is enough, with less than %s",
		       number_at_most(1 / scene->end_time, 4).text);
	if (scene->forces * scene->end_time < 1)
		advise(adviser, "output.forces: a row every %.4g s, and the drive ends after %g s: only that of its beginning is written; "
				"give more",
		       1 / scene->forces, scene->end_time);
}

/* --- the picture --- */

static void advise_view(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	const struct scene_view *view = &scene->view;
	if (view->left_out || (view->present && view->images == 0 && scene->camera_count == 0))
		advise(adviser, "view: no picture is written, so a drive draws none; give images, or look at it with furrow view");
	if (!view->present)
		return;
	if ((double)view->images > steps_of(scene))
		advise(adviser, "view.images: one every %lld steps, and the drive ends after %.0f: none is written; give at most that",
		       (long long)view->images, steps_of(scene));
	if ((view->effects >> EFFECT_DETAIL & 1) != 0 && (view->effects >> EFFECT_TEXTURE & 1) == 0)
		advise(adviser, "view.effects.detail: is the grain of the texture, which is not drawn; add texture, or take it away");
	bool objects = view->effects >> EFFECT_OBJECTS & 1, shadow = view->effects >> EFFECT_SHADOW & 1;
	bool none = scene->object_count == 0 && !scene_moves_bodies(scene);
	if (none && objects)
		advise(adviser, "view.effects.objects: draws objects, and there is none; add one, or take it away");
	if (none && shadow)
		advise(adviser, "view.effects.shadow: is that of objects, and there is none; add one, or take it away");
	if (scene->object_count > 0 && shadow && !objects)
		advise(adviser, "view.effects.shadow: is that of the objects, which are not drawn; add objects, or take it away");
	if ((view->effects >> EFFECT_SPLAT & 1) != 0 && (view->effects >> EFFECT_TEXTURE & 1) == 0)
		advise(adviser, "view.effects.splat: is of the texture, which is not drawn; add texture, or take it away");
	else if ((view->effects >> EFFECT_SPLAT & 1) != 0 && !scene_has_classes(scene))
		advise(adviser, "view.effects.splat: shows the classes of a map of soils, and there is none; give soil.map, or take it away");
	if ((view->effects >> EFFECT_FOG & 1) != 0 && view->light.body == SCENE_MOON)
		advise(adviser, "view.effects.fog: there is no air on the Moon: it changes nothing; take it away");
}

#define ERROR_TOLD 0.25 /* pixels: what numbers over relief and rocks may be off without a note */

/* With the distance the mesh of a picture gets coarser than the working posts. Ruts and relief are as fine as these posts. */
static void advise_cameras(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	const unsigned numbers = 1u << SCENE_IMAGE_DEPTH | 1u << SCENE_IMAGE_NORMALS | 1u << SCENE_IMAGE_HEIGHT;
	const bool ruts = (scene->object_count > 0 || scene_moves_bodies(scene)) && scene->view.pixel_error <= 0;
	const char *name = NULL;
	double rough = 0;
	for (int i = 0; i < scene->relief.classes; i++)
		rough = fmax(rough, scene->relief.waves[i].roughness);
	const bool rocks = rough <= 0 && scene->rocks.cover > 0;
	if (scene->rocks.cover > 0)
		rough = fmax(rough, scene->rocks.largest * ROCKS_HEIGHT_MOST / 2);
	for (size_t i = 0; i < scene->camera_count && name == NULL; i++)
		name = (scene->cameras[i].images & numbers) != 0 ? scene->cameras[i].name : NULL;
	if (name == NULL)
		return;
	if (rough > 0 && (scene->view.pixel_error <= 0 || scene->view.pixel_error > ERROR_TOLD))
		advise(adviser, "cameras.%s: over %s its numbers are those of a mesh that leaves out shorter %s, up to about %.2g m high%s; "
				"view.pixel_error: 0.25 bounds that by a quarter of a pixel, and a frame then takes several times as long",
		       name, rocks ? "rocks" : "relief", rocks ? "ones" : "waves", 2 * rough, ruts ? ", and narrow ruts" : "");
	else if (ruts)
		advise(adviser, "cameras.%s: with the distance its mesh gets coarser than the posts, and narrow ruts are blurred or missing in its numbers; "
				"view.pixel_error: 0.25 shows them, and a frame then takes several times as long", name);
}

static void advise_cache(const struct adviser *adviser)
{
	const struct scene *scene = adviser->scene;
	if (scene->loaders == 0 && scene->prefetch > 0)
		advise(adviser, "cache.prefetch: without loaders no tile is read ahead, only the ground that objects are set upon; give loaders, "
				"or prefetch 0");
	if (scene->loaders > 0 && scene->prefetch == 0 && !all_stand_still(scene))
		advise(adviser, "cache.prefetch: 0: a drive waits for each tile that it comes to; give seconds of travel, as %g",
		       scene_absent("cache.prefetch"));
}

void scene_advise(const struct scene *scene, double spacing, scene_advice_fn tell, void *user)
{
	const struct adviser adviser = {scene, spacing, tell, user};
	scene_advise_units(scene, tell, user);
	for (size_t i = 0; i < scene->unused_count; i++)
		tell(user, scene->unused[i]);
	advise_time(&adviser);
	advise_without_objects(&adviser);
	advise_ground(&adviser);
	advise_depth(&adviser);
	advise_attributes(&adviser);
	scene_advise_effects(scene, spacing, tell, user);
	for (size_t i = 0; i < scene->object_count; i++) {
		advise_shape(&adviser, &scene->objects[i]);
		advise_path(&adviser, &scene->objects[i]);
		advise_interface(&adviser, &scene->objects[i]);
	}
	scene_advise_posts(scene, spacing, tell, user);
	scene_advise_rebound(scene, tell, user);
	advise_forces(&adviser);
	advise_view(&adviser);
	advise_cameras(&adviser);
	advise_cache(&adviser);
}
