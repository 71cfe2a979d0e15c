/*
 * The table of effects: the name of each effect, the settings that call for it, and its cost. Only this file decides which effects
 * a scene calls for. The schema of the scene (scene_schema.c) has the ranges and defaults of the effects' parameters.
 */
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_schema.h"

#define STATE "base, offset, heaped, pressed, shear"
#define LIST EFFECT_LIST
#define NONE EFFECT_LIST_NONE
#define SLIDING "redistribute.iterations", "redistribute.interval", "redistribute.tolerance", "redistribute.undisturbed"

/* Without the models' own: those are in the models' rows. */
static const struct effect_row rows[EFFECT_COUNT] = {
	[EFFECT_SPREAD] = {
		"spread", "redistribute.model", "", LIST("deform/spread_measure.frag", "deform/spread_weigh.frag", "deform/spread_lay.frag"), "offset", "offset", SOIL_BAND_POSTS, NONE,
		"a band is at least 2 and at most 95 posts wide; soil that finds no free post there is compacted, and counted",
		"lays moved soil in bands beside what was touched"},
	[EFFECT_SHED] = {
		"shed", "redistribute.model", "", LIST("deform/slide_begin.frag", "deform/slide_shed.frag", "deform/slide_take.frag", "deform/held.frag", "deform/roof.frag", "deform/roof_limit.frag"),
		"base, offset, heaped", "offset, heaped", 2,
		LIST(SLIDING, "soil.theta_in", "soil.theta_out", "soil.theta_stop", "soil.roughness"),
		"a difference counts as at most 64 m, what slides from a post as at most 4 m an iteration; at most 16,384 "
		"blocks of 32 x 32 posts awake at once",
		"slides soil from steep posts by their roughness"},
	[EFFECT_SLIDE] = {
		"slide", "redistribute.model", "", LIST("deform/slide_begin.frag", "deform/slide_excess.frag", "deform/slide_lines.frag", "deform/slope.frag", "deform/steep.frag", "deform/held.frag", "deform/roof.frag", "deform/roof_limit.frag", "deform/roof_lines.frag"),
		"base, offset, heaped", "offset, heaped", 1,
		LIST(SLIDING, "redistribute.depth", "soil.repose", "soil.cohesion", "soil.friction_angle", "soil.density", "soil.unit_weight"),
		"at most an eighth of a difference, and 4 m, an iteration; at most 16,384 blocks of 32 x 32 posts awake at once",
		"slides soil down what is too steep to stand"},
	[EFFECT_SLIP] = {
		"slip", "redistribute.slip_sinkage", "", NONE, "heaped, dug", "heaped, dug", 0,
		LIST("redistribute.slip_sinkage", "soil.janosi_shear", "objects[].slip"),
		"at most slip_sinkage x janosi_shear in all contacts with a post; nothing without slip",
		"digs where a body slips, and lays that around"},
	[EFFECT_LOOSE] = {
		"loose", "redistribute.loosening", "", NONE, "heaped, settled, loose, floor", "heaped, settled, loose, floor", 0, LIST("redistribute.loosening"),
		"a post has one loose layer; what is deposited on a pressed one makes that its floor",
		"keeps how thick what came into a rut lies there, and lets it yield as loose"},
	[EFFECT_DENSE] = {
		"dense", "redistribute.hardening", "", NONE, "density", "density", 0, LIST("redistribute.hardening", "soil.compaction"),
		"each pass over a post adds half of what is left; hardening is what passes add in the end",
		"makes soil stronger with each pass"},
	[EFFECT_THROWN] = {
		"thrown", "redistribute.thrown", "", LIST("object.vert", "object.frag"), "base, offset, dug", "offset, heaped", 0, LIST("redistribute.thrown", "gravity"),
		"at most 16,384 grains at once; what is thrown beyond that flies with the grain that left last",
		"lets rims that slip throw soil, which flies and lands"},
	[EFFECT_CARRIED] = {
		"carried", "objects.carry", "", LIST("heap.vert", "heap.frag", "measure_heap.frag"), "base, offset, heaped", "offset, heaped, colour, depth", 0, LIST("objects[].carry", "vehicles[].carry"),
		"at most 512 m of soil above a place of the body; in pictures from 1 mm on, without a shadow on the ground",
		"keeps soil that comes onto a body, and draws it"},
	[EFFECT_SOIL_MAP] = {
		"soil_map", "soil.map", "", NONE, "class", "class", 0, LIST("soil.map", "soil.classes", "soil.default", "ground.roads", "ground.roads[].lines", "ground.roads[].points",
		     "ground.roads[].smooth", "ground.roads[].width", "ground.roads[].soil"),
		"at most 16 soils, the default among them; the raster's file at most 1 GiB",
		"reads which soil each post is of"},
	[EFFECT_SOIL_RASTERS] = {
		"soil_rasters", "soil.rasters", "", NONE, "numbers", "numbers", 0, LIST("soil.rasters"),
		"at most 4 rasters of 1 GiB each, with 255 levels between a raster's least and greatest value; slides go by the class",
		"reads numbers of the soil at each post"},
	[EFFECT_MESH] = {
		"mesh", "objects.shape.mesh", "", LIST("deform/facet.vert", "deform/facet.frag"), "", "underside", 0,
		LIST("objects[].shape.mesh.file", "objects[].shape.mesh.scale"),
		"at most 1,000,000 triangles; its longest side from 1 mm to 1000 m",
		"finds the lower envelope of triangles"},
	[EFFECT_GROUSERS] = {
		"lugs", "objects.shape.wheel.grousers", "", LIST("deform/facet.vert", "deform/facet.frag"), "", "underside", 0,
		LIST("objects[].shape.wheel.grousers", "objects[].shape.wheel.grouser_height", "objects[].shape.wheel.grouser_thickness"),
		"at most 128 grousers, as high as the wheel's radius",
		"finds the lower envelope of a wheel's grousers"},
	[EFFECT_TYRES] = {
		"tyres", "objects.shape.wheel.tyre", "", NONE, STATE, "height", 0,
		LIST("objects[].shape.wheel.tyre.stiffness", "objects[].shape.wheel.tyre.load", "objects[].shape.wheel.tyre.pressure", "vehicles[].tyres",
		     "vehicles[].tyres[].geom", "vehicles[].tyres[].stiffness", "vehicles[].tyres[].width", "vehicles[].tyres[].load", "vehicles[].tyres[].pressure", "vehicles[].tyres[].damping"),
		"its load presses a tyre by at most half of its radius; a wheel that leans by more than 27 degrees is rigid",
		"lets wheels flatten where the ground is harder than their tyres"},
	[EFFECT_LOAD] = {
		"load", "objects.load", "", NONE, STATE, "height", 1, LIST("objects[].load"),
		"the object sinks no deeper than it is high, and deflects a sheet by less than 8 m",
		"finds how deep the soil carries a load"},
	[EFFECT_FORCES] = {
		"forces", "output.forces", "", NONE, STATE, "forces", 1,
		LIST("output.forces"),
		"a post bears at most 134 MPa, in steps of a sixteenth of a pascal",
		"sums the soil's forces on each object"},
	[EFFECT_DISTURBANCE] = {
		"dirt", "attributes", "", LIST("deform/disturbance.frag", "deform/marks.frag"), "offset, dirt", "dirt", 0, LIST("attributes.disturbance.heals"),
		"256 shades: 255 is the dirtiest", "keeps where the ground was disturbed"},
	[EFFECT_VEGETATION] = {
		"vegetation", "attributes", "", LIST("deform/marks.frag"), "risen, grown", "risen, grown", 0,
		LIST("attributes.vegetation.cover", "attributes.vegetation.classes", "attributes.vegetation.classes[].value", "attributes.vegetation.classes[].cover",
		     "attributes.vegetation.height", "attributes.vegetation.tears", "attributes.vegetation.rises", "attributes.vegetation.grows", "objects[].slip"),
		"times in quarter seconds, up to 8.5 years", "keeps where plants are pressed and torn"},
	[EFFECT_SUBDIVIDE] = {
		"subdivide", "spacing", "", LIST("subdivide.frag"), "base", "base", 1, LIST("spacing"),
		"at most 14 levels below the source's", "interpolates between the source's posts"},
	[EFFECT_RELIEF] = {
		"relief", "relief", "RELIEF", LIST("subdivide.frag"), "base", "base", 0,
		LIST("relief.roughness", "relief.wavelength", "relief.seed", "relief.classes", "relief.classes[].value", "relief.classes[].roughness",
		     "relief.classes[].wavelength"),
		"at levels below the source's whose spacing is at most half a wavelength; by class it is computed without the GPU",
		"raises and lowers posts between the source's"},
	[EFFECT_ROCKS] = {
		"rocks", "ground.rocks", "", NONE, "base", "base", 0,
		LIST("ground.rocks", "ground.rocks.cover", "ground.rocks.k", "ground.rocks.smallest", "ground.rocks.largest", "ground.rocks.seed"),
		"at most 31 rocks a cell of their grid, whose edge is at most 2.7 times the largest diameter there; tiles below the source's level are computed without the GPU",
		"raises posts where rocks lie, and gives these the soil rock"},
	[EFFECT_PYRAMID] = {
		"pyramid", "view", "", LIST("decimate.frag"), "offset, dirt", "offset, dirt", 0, NONE,
		"resident tiles alone: the store's follow at each commit", "keeps coarser tiles up to date with changes"},
	[EFFECT_PICTURE] = {
		"picture", "view", "", LIST("terrain.vert", "terrain.frag"), "base, offset, dirt", "colour, depth", 0,
		LIST("view.size[]", "view.camera", "view.truth"), "at most 1024 tiles a picture, of 8192 x 8192 pixels at most",
		"draws the ground that the camera sees"},
	[EFFECT_NORMALS] = {
		"normals", "view", "", LIST("lib/slope.glsl"), "base, offset", "colour", 1, NONE,
		"found from the posts around a pixel, and kept nowhere", "slopes, at each pixel: no plane, and no pass"},
	[EFFECT_PIXEL_ERROR] = {
		"pixel_error", "view.pixel_error", "REACHES", LIST("terrain.vert"), "base, offset", "depth", 0, LIST("view.pixel_error"),
		"shape alone counts, not colour; with too few slots a picture is coarser", "levels by how far off they look"},
	[EFFECT_TEXTURE] = {
		"texture", "view.effects", "TEXTURE", LIST("terrain.frag", "terrain.vert"), "base, offset", "colour", 0,
		LIST("view.body"), "of 3.6 m near the eye and 162 m far off, which repeat", "grass, soil, rock, sand, snow by slope and height"},
	[EFFECT_DETAIL] = {
		"detail", "view.effects", "DETAIL", LIST("terrain.frag"), "base, offset", "colour", 0, NONE,
		"of the texture's own grain", "tilts the ground by the texture's grain"},
	[EFFECT_FOG] = {
		"fog", "view.effects", "FOG", LIST("terrain.frag", "terrain.vert"), "", "colour", 0, NONE,
		"as clear as the terrain is large; there is none on the Moon", "fades what is far into the air"},
	[EFFECT_SKY] = {
		"sky", "view.effects", "", LIST("sky.vert", "sky.frag", "apron.vert", "apron.frag"), "", "colour", 0, NONE,
		"beyond the terrain, ground that goes on from its edges; it has no depth", "draws the sky, and the ground beyond the terrain"},
	[EFFECT_GEOMORPH] = {
		"geomorph", "view.effects", "GEOMORPH", LIST("terrain.vert"), "base, offset", "depth", 1, NONE,
		"with a pixel_error tiles of different levels may meet unevenly; skirts hide it", "slides each level into the next"},
	[EFFECT_SKIRTS] = {
		"skirts", "view.effects", "SKIRTS", LIST("terrain.vert"), "base, offset", "depth", 0, NONE,
		"two pixels deep, or twice the pixel_error; where tiles stand in for others a cell, and their relief at most",
		"hides cracks between levels"},
	[EFFECT_SPLAT] = {
		"splat", "view.effects", "SPLAT", LIST("lib/ground.glsl"), "class", "colour", 1, NONE,
		"of a map of soils, with the texture", "shows each soil of the map as what it is"},
	[EFFECT_ANTIALIAS] = {
		"antialias", "view.samples", "SAMPLES", LIST("shadow.frag", "umbra.frag"), "colour", "colour", 0, LIST("view.samples"),
		"edges alone: within a triangle a pixel has one colour; as many samples as the driver has", "smooths the edges of what is drawn"},
	[EFFECT_IMAGES] = {
		"images", "view.images", "", NONE, "colour", "", 0, LIST("view.images"),
		"the step waits until the picture has all its tiles; at most 3 on their way to their files", "writes pictures to files"},
	[EFFECT_LOADERS] = {
		"loaders", "cache.loaders", "", NONE, "base, offset", "", 0, LIST("cache.loaders", "cache.slots", "cache.memory"),
		"at most 16 threads; without any the step reads, and nothing is read ahead", "reads tiles while the step goes on"},
	[EFFECT_PREFETCH] = {
		"prefetch", "cache.prefetch", "", NONE, "base", "", 0, LIST("cache.prefetch"),
		"as far as there are slots", "reads ahead of the objects and the camera"},
	[EFFECT_OBJECTS] = {
		"objects", "view.effects", "", LIST("object.vert", "object.frag"), "", "colour, depth", 0, NONE,
		"one light and no shadow upon them; what a path has not begun is not there",
		"draws the objects, wheels as they turn"},
	[EFFECT_SHADOW] = {
		"shadow", "view.effects", "SHADOW", LIST("terrain.frag", "shadow.vert", "shadow.frag", "umbra.frag"), "depth", "colour", 0, NONE,
		"of a simple form round each object, on the ground alone; as long as with the sun 1 degree high, at most; where two lie, the darker one counts",
		"shades the ground beside the objects"},
	[EFFECT_TERRAIN_SHADOW] = {
		"terrain_shadow", "view.effects", "TERRAIN_SHADOW", LIST("terrain.frag", "object.frag", "depth.frag"), "base, offset", "colour", 0, NONE,
		"four maps of 1024 x 1024 texels, the first at least 24 m wide, each 8 times wider; the ground is drawn once for each of them",
		"shades the ground that the terrain hides from the sun"},
	[EFFECT_IMAGERY] = {
		"imagery", "view.effects", "IMAGERY", LIST("terrain.frag", "lib/imagery.glsl"), "base, offset", "colour", 0, LIST("view.imagery_budget"),
		"as finely as the store has it; a picture that needs more than the budget reads tiles again while it is drawn",
		"shows the imagery of the store where the ground is undisturbed"},
	[EFFECT_CAMERAS] = {
		"cameras", "cameras", "", LIST("measure.frag", "measure_object.frag"), "colour, depth", "", 0,
		LIST("cameras[].size[]", "cameras[].rate", "cameras[].fov", "cameras[].images", "cameras[].depth_unit"),
		"at most 64; a step waits until each picture has all its tiles; at most 3 pictures on their way to their files",
		"writes the frames of cameras to files"},
	[EFFECT_LIGHT] = {
		"light", "view.exposure", "LINEAR", LIST("lib/tone.glsl", "meter.frag", "expose.frag"), "colour", "colour", 0,
		LIST("view.exposure", "view.ev", "cameras[].exposure", "cameras[].ev", "cameras[].images"),
		"2^-10 to 2^16 times as bright, for auto; by the frame alone, never by those before", "exposes each frame by its own light"},
};

const struct effect_row *scene_effect_row(enum scene_effect effect)
{
	assert((unsigned)effect < EFFECT_COUNT);
	return effect < EFFECT_SPREAD ? &deform_model_row((enum deform_model)(effect - EFFECT_MODEL))->effect : &rows[effect];
}

bool scene_effect_named(const char *name, enum scene_effect *effect)
{
	for (int e = 0; e < EFFECT_COUNT; e++)
		if (strcmp(scene_effect_row((enum scene_effect)e)->name, name) == 0) {
			*effect = (enum scene_effect)e;
			return true;
		}
	return false;
}

static uint64_t bit_of(const char *name)
{
	enum scene_effect effect;
	return name != NULL && scene_effect_named(name, &effect) ? EFFECT_BIT(effect) : 0;
}

/* Returns the effects of a model: its own, that of a contact shared with another model, and those of models that move soil. */
static uint64_t model_effects(enum deform_model model)
{
	return EFFECT_BIT(EFFECT_OF(model)) | bit_of(deform_model_row(model)->contact_effect) | bit_of(deform_slide_effect(model)) |
	       (deform_conserves(model) ? EFFECT_BIT(EFFECT_SPREAD) : 0);
}

uint64_t scene_object_effects(const struct scene_object *object)
{
	return (object->shape.kind == SOIL_MESH ? EFFECT_BIT(EFFECT_MESH) : 0) |
	       (object->shape.grousers > 0 ? EFFECT_BIT(EFFECT_GROUSERS) : 0) | (object->shape.tyre.stiffness > 0 ? EFFECT_BIT(EFFECT_TYRES) : 0) | (object->load > 0 ? EFFECT_BIT(EFFECT_LOAD) : 0);
}

static const struct scene_object *first_loaded(const struct scene *scene)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].load > 0)
			return &scene->objects[i];
	return NULL;
}

/* Forces are summed for rows, for loads, and for soil geoms of vehicles. A host asks for them as it likes. */
static bool feels(const struct scene *scene)
{
	return deform_tells_forces(scene->model) && (scene->forces > 0 || scene->vehicle_count > 0 || first_loaded(scene) != NULL);
}

static uint64_t object_effects(const struct scene *scene)
{
	uint64_t effects = model_effects(scene->model);
	if (scene->disturbance)
		effects |= EFFECT_BIT(EFFECT_DISTURBANCE);
	if (scene->vegetation.present)
		effects |= EFFECT_BIT(EFFECT_VEGETATION);
	if (scene_has_classes(scene) && deform_model_row(scene->model)->numbers != NULL)
		effects |= EFFECT_BIT(EFFECT_SOIL_MAP);
	if (scene->slip_sinkage > 0 && scene_slips(scene))
		effects |= EFFECT_BIT(EFFECT_SLIP);
	if (scene->loosening > 0)
		effects |= EFFECT_BIT(EFFECT_LOOSE);
	if (scene->hardening > 0)
		effects |= EFFECT_BIT(EFFECT_DENSE);
	if (scene_throws(scene))
		effects |= EFFECT_BIT(EFFECT_THROWN);
	if (scene->raster_count > 0)
		effects |= EFFECT_BIT(EFFECT_SOIL_RASTERS);
	if (feels(scene))
		effects |= EFFECT_BIT(EFFECT_FORCES);
	if (scene->prefetch > 0)
		effects |= EFFECT_BIT(EFFECT_PREFETCH);
	for (size_t i = 0; i < scene->object_count; i++)
		effects |= scene_object_effects(&scene->objects[i]);
	for (size_t i = 0; i < scene->vehicle_count; i++)
		effects |= scene->vehicles[i].tyre_count > 0 ? EFFECT_BIT(EFFECT_TYRES) : 0;
	if (scene_carries(scene))
		effects |= EFFECT_BIT(EFFECT_CARRIED);
	return effects;
}

bool scene_draws_light(const struct scene *scene)
{
	bool draws = scene->view.light.exposure == SCENE_EXPOSURE_AUTO;
	for (size_t i = 0; i < scene->camera_count; i++)
		draws |= scene->cameras[i].exposure == SCENE_EXPOSURE_AUTO || (scene->cameras[i].images >> SCENE_IMAGE_LINEAR & 1);
	return scene->view.present && draws;
}

static uint64_t view_effects(const struct scene *scene)
{
	uint64_t always = EFFECT_BIT(EFFECT_PICTURE) | EFFECT_BIT(EFFECT_NORMALS) | EFFECT_BIT(EFFECT_PYRAMID);
	uint64_t named = scene->view.effects;
	if ((scene->object_count == 0 && !scene_moves_bodies(scene)) || !(named & EFFECT_BIT(EFFECT_OBJECTS)))
		named &= ~(EFFECT_BIT(EFFECT_OBJECTS) | EFFECT_BIT(EFFECT_SHADOW)); /* of nothing */
	return named | always | (scene->camera_count > 0 ? EFFECT_BIT(EFFECT_CAMERAS) : 0) | (scene->view.images > 0 ? EFFECT_BIT(EFFECT_IMAGES) : 0) |
	       (scene->view.pixel_error > 0 ? EFFECT_BIT(EFFECT_PIXEL_ERROR) : 0) |
	       (scene->view.samples > 1 ? EFFECT_BIT(EFFECT_ANTIALIAS) : 0) | (scene_draws_light(scene) ? EFFECT_BIT(EFFECT_LIGHT) : 0);
}

static unsigned images_of(const struct scene *scene)
{
	unsigned images = 0;
	for (size_t i = 0; i < scene->camera_count; i++)
		images |= scene->cameras[i].images;
	return images;
}

bool scene_camera_measures(const struct scene *scene, const struct scene_camera *camera)
{
	return (camera->images & (SCENE_IMAGES_MEASURED | (scene->view.samples > 1 ? 1u << SCENE_IMAGE_DEPTH : 0))) != 0;
}

bool scene_camera_truth(const struct scene *scene, const struct scene_camera *camera)
{
	if (scene->view.truth != SCENE_TRUTH_BY_KIND)
		return scene->view.truth == SCENE_TRUTH_ALL;
	return camera != NULL && camera->aim.kind != SCENE_CHASE;
}

bool scene_measures(const struct scene *scene)
{
	bool measures = false;
	for (size_t i = 0; i < scene->camera_count; i++)
		measures = measures || scene_camera_measures(scene, &scene->cameras[i]);
	return measures;
}

double scene_pixels_a_step(const struct scene *scene)
{
	const struct scene_view *view = &scene->view;
	double pixels = view->images > 0 ? (double)view->width * view->height / (double)view->images : 0;
	for (size_t i = 0; i < scene->camera_count; i++) {
		const struct scene_camera *camera = &scene->cameras[i];
		const int draws = scene_camera_measures(scene, camera) ? 2 : 1;
		pixels += draws * camera->rate * scene->time_step * camera->width * camera->height;
	}
	return pixels;
}

bool scene_draws_classes(const struct scene *scene)
{
	const uint64_t both = EFFECT_BIT(EFFECT_SPLAT) | EFFECT_BIT(EFFECT_TEXTURE);
	const bool shown = (scene->view.effects & both) == both || (images_of(scene) >> SCENE_IMAGE_CLASS & 1);
	return scene->view.present && shown && scene_has_classes(scene);
}

bool scene_draws_one_soil(const struct scene *scene)
{
	const bool split = (scene->view.effects >> EFFECT_SPLAT & 1) && scene_has_classes(scene);
	struct soil_numbers numbers;
	if (!scene->view.present || !(scene->view.effects >> EFFECT_TEXTURE & 1) || scene->soil_map != NULL || split)
		return false;
	return soil_named(scene->soil_names[0], &numbers) == STATUS_OK;
}

bool scene_covers_by_class(const struct scene *scene)
{
	bool differs = false;
	for (int i = 1; i < SOIL_CLASSES; i++)
		differs |= scene->vegetation.cover[i] != scene->vegetation.cover[0];
	return scene->view.present && scene->vegetation.present && differs;
}

bool scene_vehicles_carry(const struct scene *scene)
{
	for (size_t i = 0; i < scene->vehicle_count; i++)
		if (scene->vehicles[i].carry.count > 0)
			return true;
	return false;
}

bool scene_carries(const struct scene *scene)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].carry)
			return true;
	return scene_vehicles_carry(scene);
}

bool scene_moves_bodies(const struct scene *scene)
{
	return scene->hosted || scene->vehicle_count > 0;
}

uint64_t scene_effects(const struct scene *scene, int level)
{
	uint64_t effects = 0;
	if (scene->object_count > 0 || scene_moves_bodies(scene))
		effects |= object_effects(scene);
	if (scene->view.present)
		effects |= view_effects(scene);
	if (scene_draws_classes(scene))
		effects |= EFFECT_BIT(EFFECT_SOIL_MAP);
	if (level < 0)
		effects |= EFFECT_BIT(EFFECT_SUBDIVIDE);
	if (level < 0 && scene->relief.classes > 0)
		effects |= EFFECT_BIT(EFFECT_RELIEF);
	if (scene->rocks.cover > 0)
		effects |= EFFECT_BIT(EFFECT_ROCKS);
	if (scene->loaders > 0)
		effects |= EFFECT_BIT(EFFECT_LOADERS);
	return effects;
}

void scene_unwatched(const struct scene *scene, struct scene *out)
{
	*out = *scene;
	if (!scene->view.present || scene->view.images > 0 || scene->camera_count > 0)
		return;
	out->view = (struct scene_view){.left_out = true, .light = scene->view.light};
}

/* --- why --- */

/* Returns the first object that uses the effect. */
static const struct scene_object *caller(const struct scene *scene, enum scene_effect effect)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (effect == EFFECT_CARRIED ? scene->objects[i].carry : scene_object_effects(&scene->objects[i]) >> effect & 1)
			return &scene->objects[i];
	return NULL;
}

void scene_effect_reason(const struct scene *scene, enum scene_effect effect, char *text, size_t size)
{
	const struct effect_row *row = scene_effect_row(effect);
	const struct scene_object *object = caller(scene, effect);
	const char *key = object != NULL ? row->key : effect == EFFECT_CARRIED ? "vehicles.carry" : effect == EFFECT_TYRES ? "vehicles.tyres" : row->key;
	if (object != NULL) /* objects.NAME.load */
		snprintf(text, size, "objects.%s%s", object->name, key + strlen("objects"));
	else if (strcmp(key, "redistribute.model") == 0)
		snprintf(text, size, "%s: %s", key, deform_model_row(scene->model)->name);
	else if (strcmp(key, "view.effects") == 0 || strcmp(key, "attributes") == 0)
		snprintf(text, size, "%s.%s", key, scene_name_now(row->name));
	else if (effect == EFFECT_FORCES && scene->forces > 0)
		snprintf(text, size, "%s: %g", key, scene->forces);
	else if (effect == EFFECT_FORCES && first_loaded(scene) != NULL)
		snprintf(text, size, "objects.%s.load", first_loaded(scene)->name);
	else if (effect == EFFECT_FORCES)
		snprintf(text, size, "vehicles");
	else if (effect == EFFECT_SLIP)
		snprintf(text, size, "%s: %g", key, scene->slip_sinkage);
	else if (effect == EFFECT_LOOSE || effect == EFFECT_DENSE)
		snprintf(text, size, "%s: %g", key, effect == EFFECT_LOOSE ? scene->loosening : scene->hardening);
	else if (effect == EFFECT_THROWN)
		snprintf(text, size, "%s: on", key);
	else if (effect == EFFECT_PREFETCH)
		snprintf(text, size, "%s: %g", key, scene->prefetch);
	else if (effect == EFFECT_LOADERS)
		snprintf(text, size, "%s: %u", key, scene->loaders);
	else if (effect == EFFECT_IMAGES)
		snprintf(text, size, "%s: %lld", key, (long long)scene->view.images);
	else if (effect == EFFECT_ANTIALIAS)
		snprintf(text, size, "%s: %d", key, scene->view.samples);
	else if (effect == EFFECT_PIXEL_ERROR)
		snprintf(text, size, "%s: %g", key, scene->view.pixel_error);
	else if (effect == EFFECT_SUBDIVIDE && scene->spacing > 0)
		snprintf(text, size, "%s: %g", key, scene->spacing);
	else
		snprintf(text, size, "%s", effect == EFFECT_SUBDIVIDE ? "the store's working level" : key);
}
