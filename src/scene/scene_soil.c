/*
 * Checks the soils of a scene and fills their values. A soil has a name or its own numbers. The scene has one soil everywhere, or
 * a class of soil for each post by a map.
 */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"

#define PARAMETER(name, unit, optional) \
	{#name, offsetof(struct raw_class, name), offsetof(struct soil_numbers, name), unit, optional}
#define DEGREE (3.14159265358979323846 / 180)

static const struct parameter {
	const char *key;
	size_t from, to;
	double unit;
	bool optional; /* it has a default */
} parameters[] = {
	PARAMETER(bekker_kc, 1, false),
	PARAMETER(bekker_kphi, 1, false),
	PARAMETER(bekker_n, 1, false),
	PARAMETER(cohesion, 1, false),
	PARAMETER(friction_angle, DEGREE, false),
	PARAMETER(janosi_shear, 1, false),
	PARAMETER(elastic_stiffness, 1, true),
	PARAMETER(damping, 1, true),
	PARAMETER(density, 1, true),
	PARAMETER(unit_weight, 1, false),
	PARAMETER(face_strength, 1, true),
	PARAMETER(face_cohesion, 1, true),
	PARAMETER(repose, DEGREE, true),
	PARAMETER(theta_in, DEGREE, false),
	PARAMETER(theta_out, DEGREE, false),
	PARAMETER(theta_stop, DEGREE, false),
	PARAMETER(roughness, 1, false),
	PARAMETER(compression, 1, false),
	PARAMETER(compaction, 1, true),
};
#define PARAMETERS (sizeof parameters / sizeof parameters[0])

static const double *given(const struct raw_class *raw, const struct parameter *parameter)
{
	const double *value;
	memcpy(&value, (const char *)raw + parameter->from, sizeof value);
	return value;
}

/* Returns true if the scene gives a number of the soil. */
static bool has_numbers(const struct raw_class *raw)
{
	bool any = false;
	for (size_t i = 0; i < PARAMETERS; i++)
		any = any || given(raw, &parameters[i]) != NULL;
	return any;
}

static enum status take_name(const struct scene_tree *tree, const char *name, const char *where,
			     struct soil_numbers *soil)
{
	enum status status = soil_named(name, soil);
	if (status != STATUS_INPUT)
		return status;
	struct nearest nearest = nearest_begin(name);
	const char *known;
	for (size_t i = 0; (known = soil_name(i)) != NULL; i++)
		nearest_offer(&nearest, known);
	/* Its message ends in the names there are. */
	return scene_error(tree->file, scene_tree_find(tree, "%s.name", where), "%s is unknown; allowed:%s%s", scene_quote(name).text,
			   strrchr(failure_message(), ':') + 1, nearest_ask(&nearest).text);
}

/* `value`: of the map's class; below 0: of no class. */
static void keep_name(struct scene *scene, size_t index, const char *name, int value)
{
	char *to = scene->soil_names[index];
	size_t room = sizeof scene->soil_names[index];
	if (name != NULL)
		snprintf(to, room, "%s", name);
	else if (value >= 0)
		snprintf(to, room, "unnamed_%d", value);
	else
		snprintf(to, room, "unnamed");
}

static bool draws_soil(const struct raw_scene *raw)
{
	for (uint32_t i = 0; raw->view != NULL && i < raw->view->effects_count; i++)
		if (strcmp(raw->view->effects[i], scene_effect_row(EFFECT_SPLAT)->name) == 0)
			return true;
	for (uint32_t i = 0; i < raw->cameras_count; i++)
		for (uint32_t k = 0; k < raw->cameras[i].images_count; k++)
			if (strcmp(raw->cameras[i].images[k], scene_image_name(SCENE_IMAGE_CLASS)) == 0)
				return true;
	return false;
}

/* Without a view, cameras have textures. */
static bool draws_texture(const struct raw_scene *raw)
{
	if (raw->view == NULL)
		return raw->cameras_count > 0;
	for (uint32_t i = 0; i < raw->view->effects_count; i++)
		if (strcmp(raw->view->effects[i], scene_effect_row(EFFECT_TEXTURE)->name) == 0)
			return true;
	return false;
}

static bool raises_by_class(const struct raw_scene *raw)
{
	return raw->relief != NULL && raw->relief->classes_count > 0;
}

static bool reads_soil(const struct scene *scene)
{
	return deform_model_row(scene->model)->numbers != NULL;
}

/* Returns true for a number that a soil need not have under this model. scm has an estimate of the weight. */
static bool has_default(const struct parameter *parameter, enum deform_model model)
{
	return parameter->optional || (parameter->to == offsetof(struct soil_numbers, unit_weight) && deform_model_reads(model, "face_strength"));
}

static double *number_of(struct soil_numbers *soil, const struct parameter *parameter)
{
	return (double *)((char *)soil + parameter->to);
}

/* Returns the keys that the model needs and for which the soil has no number. */
static struct scene_list missing_keys(struct soil_numbers *soil, enum deform_model model)
{
	struct scene_list missing = {.length = 0};
	for (size_t i = 0; i < PARAMETERS; i++)
		if (deform_model_reads(model, parameters[i].key) && !has_default(&parameters[i], model) && isnan(*number_of(soil, &parameters[i])))
			scene_list_add(&missing, parameters[i].key);
	return missing;
}

/* Returns the names of soils that have every number that the model needs. */
static struct scene_list whole_soils(enum deform_model model)
{
	struct scene_list whole = {.length = 0};
	struct soil_numbers soil;
	const char *name;
	for (size_t i = 0; (name = soil_name(i)) != NULL; i++)
		if (soil_named(name, &soil) == STATUS_OK && missing_keys(&soil, model).length == 0)
			scene_list_add(&whole, name);
	return whole;
}

static enum status check_whole(const struct scene_tree *tree, const char *name, const char *where, enum deform_model model,
			       struct soil_numbers *soil)
{
	struct scene_list missing = missing_keys(soil, model);
	if (missing.length == 0)
		return STATUS_OK;
	if (name == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "%s", where),
				   "model %s needs %s too; allowed: a name, or all of these", deform_model_row(model)->name,
				   missing.text);
	return scene_error(tree->file, scene_tree_find(tree, "%s.name", where),
			   "%s has no %s, which model %s reads; give these beside the name, or name one of %s", name, missing.text,
			   deform_model_row(model)->name, whole_soils(model).text);
}

/*
 * Gives the soil its weight. What the scene says of it goes before what the name has: unit_weight, or density and gravity. A named soil weighs as it
 * does where it is, lunar soil on the Moon, until the scene gives a gravity.
 */
static void weigh(const struct raw_class *raw, const struct scene *scene, struct soil_numbers *soil)
{
	if (!deform_model_reads(scene->model, "density"))
		return;
	if (raw->unit_weight != NULL && raw->density == NULL)
		soil->density = deform_model_reads(scene->model, "face_strength") ? soil->unit_weight / scene->gravity : (double)NAN;
	const bool told = raw->density != NULL || scene->gravity_given || isnan(soil->unit_weight);
	if (raw->unit_weight == NULL && told && !isnan(soil->density))
		soil->unit_weight = soil->density * scene->gravity;
}

/* Gives the soil the numbers that neither the scene nor its name has, and that have a default. */
static void fill_in(const struct scene *scene, struct soil_numbers *soil)
{
	if (isnan(soil->repose))
		soil->repose = soil->friction_angle;
	if (deform_model_reads(scene->model, "elastic_stiffness") && isnan(soil->elastic_stiffness))
		soil->elastic_stiffness = SOIL_USUAL_STIFFNESS;
	if (deform_model_reads(scene->model, "damping") && isnan(soil->damping))
		soil->damping = SOIL_USUAL_DAMPING;
	if (scene->hardening > 0 && isnan(soil->compaction))
		soil->compaction = 0;
	if (deform_model_reads(scene->model, "face_strength") && isnan(soil->unit_weight)) {
		soil->density = SOIL_USUAL_DENSITY;
		soil->unit_weight = soil->density * scene->gravity;
	}
}

/* Checks the numbers of the soil written at `where`, and fills them. */
static enum status fill_class(const struct scene_tree *tree, const struct raw_class *raw, const char *where, const struct scene *scene, struct soil_numbers *soil)
{
	const enum deform_model model = scene->model;
	soil_clear(soil);
	if (raw->name != NULL)
		TRY(take_name(tree, raw->name, where, soil));
	for (size_t i = 0; i < PARAMETERS; i++) {
		const double *value = given(raw, &parameters[i]);
		if (value != NULL)
			*number_of(soil, &parameters[i]) = *value * parameters[i].unit;
	}
	weigh(raw, scene, soil);
	if (soil_is_hard(soil) && !deform_model_row(model)->bears && (scene->object_count > 0 || scene_moves_bodies(scene)))
		return scene_error(tree->file, scene_tree_find(tree, "%s.name", where), "%s is hard ground, into which nothing sinks, and model %s presses into all ground; "
				   "write redistribute: {model: scm}", raw->name, deform_model_row(model)->name);
	TRY(check_whole(tree, raw->name, where, model, soil));
	fill_in(scene, soil);
	if (deform_model_reads(model, "repose") && soil->repose <= 0)
		return scene_error(tree->file, scene_tree_find(tree, "%s", where),
				   "without friction it needs repose too; allowed: above 0 to 89");
	if (deform_model_reads(model, "theta_stop") && soil->theta_stop < soil->theta_out)
		return scene_error(tree->file,
				   scene_tree_find(tree, "%s.%s", where,
						   raw->theta_stop != NULL ? "theta_stop" : "theta_out"),
				   "theta_stop is below theta_out; allowed: %.4g to 90", soil->theta_out / DEGREE);
	return STATUS_OK;
}

/* A density that does not make the weight that is given beside it. */
static enum status check_weight(const struct raw_class *raw, const char *where, struct scene *scene)
{
	if (raw->density == NULL || raw->unit_weight == NULL || fabs(*raw->density * scene->gravity / *raw->unit_weight - 1) <= 0.02)
		return STATUS_OK;
	return scene_tell_unused(scene, "%s.density: the soil weighs its unit_weight, %g N/m3, not density x gravity, %g; take one of them away", where,
				 *raw->unit_weight, *raw->density * scene->gravity);
}

/* Numbers that the model does not read. */
static enum status check_unread(const struct raw_class *raw, const char *where, struct scene *scene)
{
	struct scene_list unread = {.length = 0};
	for (size_t i = 0; i < PARAMETERS; i++)
		if (given(raw, &parameters[i]) != NULL && !deform_model_reads(scene->model, parameters[i].key))
			scene_list_add(&unread, parameters[i].key);
	return unread.length == 0 ? STATUS_OK
				  : scene_tell_unused(scene, "%s: model %s does not read %s; take that away", where,
						      deform_model_row(scene->model)->name, unread.text);
}

/* Returns true for a density that the given unit_weight replaces, and for a unit_weight that comes of the given density. */
static bool is_weighed(const struct raw_class *raw, const struct parameter *parameter)
{
	return (parameter->to == offsetof(struct soil_numbers, density) && raw->unit_weight != NULL) ||
	       (parameter->to == offsetof(struct soil_numbers, unit_weight) && raw->density != NULL);
}

/* Checks what the soil at `where` lies over, and fills bases[index]. */
static enum status check_layer(const struct scene_tree *tree, const struct raw_class *raw, const char *where, struct scene *scene, size_t index)
{
	struct soil_numbers *soil = &scene->soils[index], *base = &scene->bases[index];
	char below[48];
	if (raw->over == NULL && raw->thickness == NULL)
		return STATUS_OK;
	if (!deform_model_row(scene->model)->bears)
		return deform_model_row(scene->model)->numbers == NULL ? STATUS_OK : scene_error(tree->file, scene_tree_find(tree, "%s.%s", where, raw->over != NULL ? "over" : "thickness"),
				   "model %s knows one soil from the surface down; allowed with: scm", deform_model_row(scene->model)->name);
	if (raw->over == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "%s.thickness", where), "is of a layer, and nothing lies below it; give over too: a soil, or rigid");
	if (raw->thickness == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "%s.over", where), "lies below a layer whose thickness is not given; give thickness too, in m");
	snprintf(below, sizeof below, "%s.over", where);
	snprintf(scene->base_names[index], sizeof scene->base_names[index], "%s", raw->over->name != NULL ? raw->over->name : "unnamed");
	if (raw->over->name != NULL && strcmp(raw->over->name, SCENE_RIGID) == 0) {
		for (size_t i = 0; i < PARAMETERS; i++)
			if (given(raw->over, &parameters[i]) != NULL)
				return scene_error(tree->file, scene_tree_find(tree, "%s.%s", below, parameters[i].key), "is of soil, and %s ground has no numbers; take it away", SCENE_RIGID);
		soil_set_rigid(base);
	} else {
		TRY(fill_class(tree, raw->over, below, scene, base));
		TRY(check_unread(raw->over, below, scene));
		TRY(check_weight(raw->over, below, scene));
	}
	soil->over = base;
	soil->thickness = *raw->thickness;
	if (scene->depth > 0 && soil_is_rigid(base) && scene->depth > soil->thickness)
		return scene_error(tree->file, scene_tree_find(tree, "redistribute.depth"), "is how deep soil slides, and rigid ground begins at %g m; allowed: 0 to %g",
				   soil->thickness, soil->thickness);
	return STATUS_OK;
}

enum status scene_check_class(const struct scene_tree *tree, const struct scene_node *node, int value, const struct scene *scene, bool given[SOIL_CLASSES], uint8_t *soil)
{
	*soil = scene->soil_class[value];
	if (*soil == 0)
		return scene_error(tree->file, node, "%d is no class of soil.classes; allowed: a value that it has", value);
	if (given[*soil])
		return scene_error(tree->file, node, "%d is another class; allowed: each value once", value);
	given[*soil] = true;
	return STATUS_OK;
}

/* Checks the soil written at `where`, and fills soils[index]. */
static enum status check_class(const struct scene_tree *tree, const struct raw_class *raw, const char *where, struct scene *scene, size_t index)
{
	for (size_t i = 0; i < PARAMETERS; i++)
		scene->soil_given[index] |= (unsigned)(given(raw, &parameters[i]) != NULL) << i;
	TRY(fill_class(tree, raw, where, scene, &scene->soils[index]));
	if (raw->compaction != NULL && *raw->compaction > 0 && deform_model_reads(scene->model, "compaction") && !(scene->hardening > 0))
		TRY(scene_tell_unused(scene, "%s.compaction: how dense soil is counts with redistribute.hardening alone; give that, or take it away", where));
	return check_layer(tree, raw, where, scene, index);
}

/*
 * Notes a name if the numbers beside it replace all of its numbers that the model reads. Numbers with a default may remain the name's. furrow fit-soil
 * writes such soils, so these are noted only if --set gave the name alone.
 */
static enum status check_replaced(const struct scene_tree *tree, const struct raw_class *raw, const char *where, struct scene *scene)
{
	struct scene_list remain = {.length = 0};
	struct soil_numbers named;
	bool differs = false;
	if (raw->name == NULL || soil_named(raw->name, &named) != STATUS_OK || missing_keys(&named, scene->model).length > 0)
		return STATUS_OK;
	for (size_t i = 0; i < PARAMETERS; i++) {
		const double *value = given(raw, &parameters[i]);
		if (!deform_model_reads(scene->model, parameters[i].key))
			continue;
		if (value == NULL && !has_default(&parameters[i], scene->model))
			return STATUS_OK;
		if (value != NULL)
			differs = differs || !(fabs(*value * parameters[i].unit / *number_of(&named, &parameters[i]) - 1) <= 1e-9);
		else if (!isnan(*number_of(&named, &parameters[i])) && !is_weighed(raw, &parameters[i]))
			scene_list_add(&remain, parameters[i].key);
	}
	const struct scene_node *name = scene_tree_find(tree, "%s.name", where);
	if (!differs || (remain.length > 0 && (name->setting == NULL || name->setting == name->parent->setting)))
		return STATUS_OK;
	return scene_tell_unused(scene, "%s.name: the scene's own numbers replace all that model %s reads of %s%s%s, but run.json names %s; give {name: %s} alone, "
					"or take the name away",
				 where, deform_model_row(scene->model)->name, raw->name, remain.length > 0 ? ", except " : "", remain.text, raw->name, raw->name);
}

/* Tells what counts for nothing of the soil written at `where`. */
static enum status tell_vain(const struct scene_tree *tree, const struct raw_class *raw, const char *where, struct scene *scene)
{
	TRY(check_unread(raw, where, scene));
	TRY(check_weight(raw, where, scene));
	return check_replaced(tree, raw, where, scene);
}

/* Metres: scm's b of an object whose shape says it; 0: it depends on the contact. */
static double contact_width(const struct soil_shape *shape)
{
	if (shape->kind == SOIL_WHEEL)
		return shape->width;
	if (shape->kind == SOIL_CYLINDER) /* the least: b depends on its attitude */
		return fmin(shape->length, shape->radius);
	return shape->kind == SOIL_BOX ? fmin(shape->size[0], shape->size[1]) : 0;
}

/* k_c / b + k_phi under an object that is `width` metres wide; 1 where the width depends on the contact. */
static double modulus_under(const struct soil_numbers *soil, double width)
{
	return width > 0 ? soil->bekker_kc / width + soil->bekker_kphi : 1;
}

/* A soil's resistance must grow with sinkage: checks that k_c / b + k_phi is above 0. */
static enum status check_bearing(const struct scene_tree *tree, const struct scene *scene, const char *where,
				 const struct soil_numbers *soil)
{
	const struct scene_node *node = scene_tree_find(tree, "%s.bekker_kc", where);
	if (soil->bekker_kc <= 0 && soil->bekker_kphi <= 0)
		return scene_error(tree->file, node, "bekker_kc and bekker_kphi bear nothing; allowed: one of them above 0");
	for (size_t i = 0; i < scene->object_count; i++) {
		double width = contact_width(&scene->objects[i].shape), modulus = modulus_under(soil, width);
		if (modulus <= 0)
			return scene_error(tree->file, node,
					   "bekker_kc / b + bekker_kphi is %.4g under %s, whose b is %.4g m; "
					   "allowed: above 0", modulus, scene->objects[i].name, width);
	}
	return STATUS_OK;
}

/* Checks the soil at `where`, and what lies below its layer. */
static enum status check_bearings_at(const struct scene_tree *tree, const struct scene *scene, const char *where, size_t index)
{
	const struct soil_numbers *over = scene->soils[index].over;
	char below[56];
	TRY(check_bearing(tree, scene, where, &scene->soils[index]));
	if (over == NULL || soil_is_rigid(over))
		return STATUS_OK;
	snprintf(below, sizeof below, "%s.over", where);
	return check_bearing(tree, scene, below, over);
}

enum status scene_check_bearing(const struct scene_tree *tree, const struct scene *scene,
				const struct scene_object *object)
{
	double width = contact_width(&object->shape);
	for (int i = 0; deform_model_reads(scene->model, "bekker_kc") && i < scene->soil_count; i++) {
		double modulus = modulus_under(&scene->soils[i], width);
		if (modulus > 0 && scene->soils[i].over != NULL)
			modulus = modulus_under(scene->soils[i].over, width);
		if (modulus <= 0)
			return scene_error(tree->file, scene_tree_find(tree, "objects[0].shape"),
					   "the soil does not bear it: bekker_kc / b + bekker_kphi is %.4g, and its b is "
					   "%.4g m; allowed: above 0", modulus, width);
	}
	return STATUS_OK;
}

/* `moved`: bodies go where no path of the scene says. */
static enum status check_map(const struct scene_tree *tree, const struct raw_soil *raw, bool read, bool moved, struct scene *scene)
{
	const struct scene_node *node = scene_tree_find(tree, "soil.map");
	if (raw->all.name != NULL || has_numbers(&raw->all))
		return scene_error(tree->file, node, "does not go with a soil beside it; allowed: map, classes, "
				   "default, rasters");
	if (raw->classes == NULL)
		return scene_error(tree->file, node, "has no classes; write {map: FILE, classes: {1: dry_sand, ...}, default: dry_sand}");
	if (raw->elsewhere == NULL && moved)
		return scene_error(tree->file, node, "has no default, and it is not known where %s go; write {map: FILE, classes: {1: dry_sand, ...}, default: dry_sand}",
				   scene->hosted ? "bodies" : "vehicles");
	if (!read)
		return STATUS_OK;
	scene->soil_map = scene_file_beside(tree->folder, raw->map);
	TRY_MEM(scene->soil_map, "reading the map of soils");
	return scene_file_hash(scene->soil_map, scene_told(tree->file, node, raw->map).text, SCENE_RASTER_BYTES,
			       scene->soil_map_hash);
}

static enum status check_classes(const struct scene_tree *tree, const struct raw_soil *raw, struct scene *scene)
{
	for (uint32_t i = 0; i < raw->classes_count; i++) {
		const struct raw_class *class = &raw->classes[i];
		char where[40];
		snprintf(where, sizeof where, "soil.classes[%u]", i);
		if (scene->soil_class[class->value] != 0)
			return scene_error(tree->file, scene_tree_find(tree, "%s.value", where),
					   "%d is another class; allowed: each value once", (int)class->value);
		TRY(check_class(tree, class, where, scene, i + 1));
		if (reads_soil(scene))
			TRY(tell_vain(tree, class, where, scene));
		scene->soil_class[class->value] = (uint8_t)(i + 1);
		keep_name(scene, i + 1, class->name, (int)class->value);
	}
	scene->soil_count = 1 + (int)raw->classes_count;
	return STATUS_OK;
}

static bool is_name_alone(const struct raw_class *raw)
{
	return raw->name != NULL && raw->over == NULL && raw->thickness == NULL && !has_numbers(raw);
}

/* The soils of roads come after those of the map. Roads whose soil is the same name alone share it. */
static enum status check_road_soils(const struct scene_tree *tree, const struct raw_ground *raw, bool read, struct scene *scene)
{
	for (uint32_t i = 0; i < raw->roads_count; i++) {
		const struct raw_class *soil = &raw->roads[i].soil;
		char where[48];
		uint32_t like = 0;
		snprintf(where, sizeof where, "ground.roads[%u].soil", i);
		while (like < i && !(is_name_alone(soil) && is_name_alone(&raw->roads[like].soil) && strcmp(soil->name, raw->roads[like].soil.name) == 0))
			like++;
		if (like < i) {
			scene->roads[i].soil = scene->roads[like].soil;
			continue;
		}
		if (scene->soil_count == SOIL_CLASSES)
			return scene_error(tree->file, scene_tree_find(tree, "%s", where), "is one soil too many; allowed: %d in all, of soil and of roads", SOIL_CLASSES);
		const size_t index = (size_t)scene->soil_count;
		TRY(check_class(tree, soil, where, scene, index));
		if (read) {
			TRY(tell_vain(tree, soil, where, scene));
			if (deform_model_reads(scene->model, "bekker_kc"))
				TRY(check_bearings_at(tree, scene, where, index));
		}
		keep_name(scene, index, soil->name, -1);
		scene->roads[i].soil = (uint8_t)index;
		scene->soil_count++;
	}
	return STATUS_OK;
}

/* Rocks are hard where the model knows hard ground. What comes onto them sinks in under other models. */
static enum status check_rocks_soil(const struct scene_tree *tree, bool read, bool drawn, struct scene *scene)
{
	const struct raw_class rock = {.name = (char *)(uintptr_t)"rock"};
	const char *const where = "ground.rocks";
	if (read && !deform_model_reads(scene->model, "bekker_kc"))
		return STATUS_OK;
	if (!read && !drawn)
		return STATUS_OK;
	if (scene->soil_count == SOIL_CLASSES)
		return scene_error(tree->file, scene_tree_find(tree, where), "are of one soil too many; allowed: %d in all, of soil, of roads and of rocks", SOIL_CLASSES);
	const size_t index = (size_t)scene->soil_count;
	TRY(check_class(tree, &rock, where, scene, index));
	if (read)
		TRY(check_bearings_at(tree, scene, where, index));
	keep_name(scene, index, rock.name, -1);
	scene->rocks_soil = (uint8_t)index;
	scene->soil_count++;
	return STATUS_OK;
}

static enum status check_bearings(const struct scene_tree *tree, const struct scene *scene, bool mapped)
{
	for (int i = 0; i < scene->soil_count; i++) {
		char where[48];
		snprintf(where, sizeof where, "soil.classes[%d]", i - 1);
		TRY(check_bearings_at(tree, scene, i > 0 ? where : mapped ? "soil.default" : "soil", (size_t)i));
	}
	return STATUS_OK;
}

/* Nothing reads the soils, and no picture shows them. */
static void forget_soils(struct scene *scene)
{
	scene_roads_finish(scene);
	scene->rocks_soil = 0;
	memset(scene->soil_class, 0, sizeof scene->soil_class);
	scene->soil_count = 0;
}

static enum status check_soils(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const struct raw_soil *soil = raw->soil;
	bool read = reads_soil(scene);
	if (soil == NULL && !read)
		return STATUS_OK;
	if (soil == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "redistribute.model"),
				   "%s needs a soil, and none is given; write soil: {name: dry_sand}, or another",
				   deform_model_row(scene->model)->name);
	bool mapped = soil->map != NULL;
	if (!mapped && (soil->classes != NULL || soil->elsewhere != NULL))
		return scene_error(tree->file,
				   scene_tree_find(tree, soil->classes != NULL ? "soil.classes" : "soil.default"),
				   "is of a map, and there is none; allowed with: map");
	const bool rocks = scene->rocks.cover > 0;
	const bool drawn = ((mapped || scene->road_count > 0 || rocks) && draws_soil(raw)) || (mapped && raises_by_class(raw));
	if (mapped)
		TRY(check_map(tree, soil, read || drawn, scene->hosted || raw->vehicles_count > 0, scene));
	const bool first = mapped && soil->elsewhere == NULL; /* the first class is the default, too */
	const struct raw_class *elsewhere = !mapped ? &soil->all : first ? &soil->classes[0] : soil->elsewhere;
	const char *where = !mapped ? "soil" : first ? "soil.classes[0]" : "soil.default";
	scene->soil_default = !first;
	TRY(check_class(tree, elsewhere, where, scene, 0));
	scene->soil_count = 1;
	keep_name(scene, 0, elsewhere->name, first ? (int)elsewhere->value : -1);
	if (read && !first)
		TRY(tell_vain(tree, elsewhere, where, scene));
	TRY(check_classes(tree, soil, scene));
	if (deform_model_reads(scene->model, "bekker_kc"))
		TRY(check_bearings(tree, scene, mapped));
	TRY(scene_check_rasters(tree, soil->rasters, scene));
	if (rocks && scene->raster_count > 0)
		return scene_error(tree->file, scene_tree_find(tree, "ground.rocks"), "do not go with soil.rasters, whose numbers would be the rocks' too; "
				   "take the rasters or the rocks away");
	if (scene->road_count > 0 && scene->raster_count > 0)
		return scene_error(tree->file, scene_tree_find(tree, "ground.roads"), "do not go with soil.rasters, whose numbers would be the roads' too; "
				   "draw the roads into the rasters, or take those away");
	if (scene->road_count > 0)
		TRY(check_road_soils(tree, raw->ground, read, scene));
	if (rocks)
		TRY(check_rocks_soil(tree, read, drawn, scene));
	if (read)
		return STATUS_OK;
	memset(scene->soils, 0, sizeof scene->soils);
	memset(scene->bases, 0, sizeof scene->bases);
	if (drawn && soil->rasters != NULL)
		return scene_tell_unused(scene, "soil.rasters: model %s does not depend on them; take them away, or name model scm",
					 deform_model_row(scene->model)->name);
	if (drawn)
		return STATUS_OK;
	forget_soils(scene);
	if (!mapped && elsewhere->name != NULL && draws_texture(raw))
		return STATUS_OK; /* pictures show it: scene_draws_one_soil */
	return scene_tell_unused(scene, "soil: model %s does not depend on it; take it away, or name a model that moves soil",
				 deform_model_row(scene->model)->name);
}

enum status scene_check_soil(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const bool roads = raw->ground != NULL && raw->ground->roads_count > 0;
	TRY(scene_rocks_take(tree, raw->ground, scene));
	if (roads && raw->soil == NULL && !reads_soil(scene))
		return scene_tell_unused(scene, "ground.roads: model %s does not depend on them; take them away, or name a model that moves soil",
					 deform_model_row(scene->model)->name);
	if (roads)
		TRY(scene_roads_take(tree, raw->ground, scene));
	return check_soils(tree, raw, scene);
}

double scene_soil_modulus(const struct soil_numbers *soil, const struct soil_shape *shape, double *width)
{
	*width = contact_width(shape);
	return *width > 0 ? modulus_under(soil, *width) : fmax(soil->bekker_kc, soil->bekker_kphi);
}

bool scene_soil_number(const struct soil_numbers *soil, size_t index, const char **key, double *value)
{
	if (index >= PARAMETERS)
		return false;
	double number;
	memcpy(&number, (const char *)soil + parameters[index].to, sizeof number);
	/* 15 digits: an angle of 29 degrees went through radians, and is told as 29. */
	char text[40];
	snprintf(text, sizeof text, "%.15g", number / parameters[index].unit);
	*key = parameters[index].key;
	*value = isnan(number) ? number : strtod(text, NULL);
	return true;
}

bool scene_soil_given(const struct scene *scene, int soil, const char *key)
{
	for (size_t i = 0; i < PARAMETERS; i++)
		if (strcmp(parameters[i].key, key) == 0)
			return scene->soil_given[soil] >> i & 1;
	return false;
}

bool scene_has_classes(const struct scene *scene)
{
	return scene->soil_map != NULL || scene->road_count > 0 || scene->rocks_soil > 0;
}

int scene_soil_value(const struct scene *scene, int soil)
{
	for (int value = 0; soil > 0 && value < 256; value++)
		if (scene->soil_class[value] == soil)
			return value;
	return -1;
}
