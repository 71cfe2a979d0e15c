/*
 * Makes the checked scene from its typed values, as scene_check.h describes. Objects, soil and view are checked in files of their
 * own.
 */
#include "scene/scene_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_file.h"

static int64_t whole(const int64_t *value, const char *where)
{
	return value != NULL ? *value : (int64_t)scene_absent(where);
}

static enum status copy(char **out, const char *text)
{
	*out = mem_strdup(text);
	return *out == NULL ? fail_memory("reading the scene") : STATUS_OK;
}

/* Checks the keys of `redistribute`. Each key except the model is for some models only. Keys that are for other models are not
 * ignored silently. */
static enum status check_parameters(const struct scene_tree *tree, const struct raw_redistribute *raw)
{
	const enum deform_model chosen = (enum deform_model)raw->model;
	const struct {
		const char *key;
		const void *value;
	} parameters[] = {
		{"radius", raw->radius},	   {"repetitions", raw->repetitions}, {"iterations", raw->iterations},
		{"interval", raw->interval},	   {"depth", raw->depth},	      {"undisturbed", raw->undisturbed},
		{"tolerance", raw->tolerance}, {"bulldozing", raw->bulldozing},
		{"slip_sinkage", raw->slip_sinkage},
		{"loosening", raw->loosening},
		{"hardening", raw->hardening},
		{"normals", raw->normals}, {"faces", raw->faces}, {"inertia", raw->inertia}, {"thrown", raw->thrown},
		{"tension", raw->tension}, {"stiffness", raw->stiffness}, {"yield", raw->yield}, {"rut", raw->rut},
		{"regions", raw->regions},
	};
	for (size_t i = 0; i < sizeof parameters / sizeof parameters[0]; i++) {
		struct scene_list models = {.length = 0};
		if (parameters[i].value == NULL || deform_model_takes(chosen, parameters[i].key))
			continue;
		for (int model = 0; model < DEFORM_MODELS; model++)
			if (deform_model_takes((enum deform_model)model, parameters[i].key))
				scene_list_add(&models, deform_model_row((enum deform_model)model)->name);
		return scene_error(tree->file, scene_tree_find(tree, "redistribute.%s", parameters[i].key),
				   "is no parameter of model %s; allowed with: %s", deform_model_row(chosen)->name, models.text);
	}
	return STATUS_OK;
}

/* carries: an object may carry soil. */
static enum status check_redistribute(const struct scene_tree *tree, const struct raw_redistribute *raw, bool carries, struct scene *scene)
{
	const struct raw_redistribute none = {.model = DEFORM_MODEL_DEFAULT};
	if (raw == NULL)
		raw = &none;
	scene->model = (enum deform_model)raw->model;
	scene->box_radius = (int)whole(raw->radius, "redistribute.radius");
	scene->box_repetitions = (int)whole(raw->repetitions, "redistribute.repetitions");
	if (deform_conserves(scene->model)) {
		scene->iterations = (int)whole(raw->iterations, "redistribute.iterations");
		scene->interval = scene_number(raw->interval, "redistribute.interval");
		scene->depth = raw->depth != NULL ? *raw->depth : deform_model_row(scene->model)->depth;
		scene->tolerance = scene_number(raw->tolerance, "redistribute.tolerance");
		scene->undisturbed = raw->undisturbed != NULL ? (enum scene_undisturbed)*raw->undisturbed : SCENE_STABLE;
	}
	if (deform_model_takes(scene->model, "bulldozing"))
		scene->bulldozing = scene_number(raw->bulldozing, "redistribute.bulldozing");
	if (deform_model_takes(scene->model, "slip_sinkage"))
		scene->slip_sinkage = scene_number(raw->slip_sinkage, "redistribute.slip_sinkage");
	scene->faces = raw->faces != NULL ? (enum scene_faces)*raw->faces : SCENE_FACES_ON;
	if (deform_model_takes(scene->model, "inertia"))
		scene->inertia = scene_number(raw->inertia, "redistribute.inertia");
	if (deform_model_takes(scene->model, "loosening"))
		scene->loosening = scene_number(raw->loosening, "redistribute.loosening");
	if (deform_model_takes(scene->model, "hardening"))
		scene->hardening = scene_number(raw->hardening, "redistribute.hardening");
	if (deform_is_elastic(scene->model)) {
		scene->tension = scene_number(raw->tension, "redistribute.tension");
		scene->stiffness = scene_number(raw->stiffness, "redistribute.stiffness");
		scene->yield = raw->yield != NULL ? *raw->yield : (double)INFINITY;
		scene->rut = scene_number(raw->rut, "redistribute.rut");
	}
	scene->thrown = raw->thrown != NULL ? (enum scene_thrown)*raw->thrown : SCENE_THROWN_OFF;
	if (scene->thrown == SCENE_THROWN_ON && !(scene->slip_sinkage > 0) && !carries && deform_model_takes(scene->model, "thrown"))
		return scene_error(tree->file, scene_tree_find(tree, "redistribute.thrown"), "what is thrown is what slip digs and what falls off bodies with carry, and slip_sinkage: 0 digs nothing; give slip_sinkage or carry, or take thrown away");
	scene->normals = raw->normals != NULL ? (enum scene_normals)*raw->normals : SCENE_BODY;
	scene->regions = raw->regions != NULL ? (enum scene_regions)*raw->regions : SCENE_WINDOWS;
	return check_parameters(tree, raw);
}

struct scene_list scene_models_with_forces(void)
{
	struct scene_list models = {.length = 0};
	for (int model = 0; model < DEFORM_MODELS; model++)
		if (deform_tells_forces((enum deform_model)model))
			scene_list_add(&models, deform_model_row((enum deform_model)model)->name);
	return models;
}

struct scene_list scene_models_with_loads(void)
{
	struct scene_list models = {.length = 0};
	for (int model = 0; model < DEFORM_MODELS; model++)
		if (deform_tells_forces((enum deform_model)model) || deform_is_elastic((enum deform_model)model))
			scene_list_add(&models, deform_model_row((enum deform_model)model)->name);
	return models;
}

static enum status check_compute(const struct scene_tree *tree, const int *compute, struct scene *scene)
{
	scene->compute = compute != NULL ? (enum scene_compute)*compute : SCENE_ANYWHERE;
	if (scene->compute == SCENE_CPU && scene->regions == SCENE_FIXED_REGIONS)
		return scene_error(tree->file, scene_tree_find(tree, "redistribute.regions"),
				   "fixed regions are of the GPU, and compute: cpu asks for the CPU; take one of them away");
	if (scene->compute != SCENE_GPU || !deform_on_cpu(scene->model))
		return STATUS_OK;
	return scene_error(tree->file, scene_tree_find(tree, "compute"), "model %s is computed by the CPU alone; allowed with it: cpu",
			   deform_model_row(scene->model)->name);
}

static enum status check_output(const struct scene_tree *tree, const struct raw_output *output,
				struct scene *scene)
{
	if (output == NULL)
		return STATUS_OK;
	scene->vehicle_rows = output->vehicles != NULL ? *output->vehicles : 0;
	scene->sensor_rows = output->sensors != NULL ? *output->sensors : 0;
	scene->noise_seeded = output->noise_seed != NULL;
	scene->noise_seed = scene->noise_seeded ? (uint32_t)*output->noise_seed : 0;
	scene->map = output->map != NULL && *output->map;
	scene->forces = output->forces != NULL ? *output->forces : 0;
	if (output->delay == NULL)
		return STATUS_OK;
	return scene_tell_unused(scene, "output.delay: forces are known at the end of their step; take it away");
}

static enum status check_coordinates(const struct raw_scene *raw, struct scene *scene)
{
	if (raw->coordinates == NULL || strcmp(raw->coordinates, "local") == 0)
		return STATUS_OK;
	if (strcmp(raw->coordinates, "store") == 0) {
		scene->coordinates = SCENE_STORE;
		return STATUS_OK;
	}
	scene->coordinates = SCENE_SRS;
	return copy(&scene->srs, raw->coordinates);
}

enum status scene_check_name(const struct scene_tree *tree, const struct scene_node *node, const char *name)
{
	if (strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != strlen(name))
		return scene_error(tree->file, node, "%s is not a name; allowed: A-Z a-z 0-9 _ -", scene_quote(name).text);
	return STATUS_OK;
}

/* Reads bytes such as "512 MB". */
static enum status check_memory(const struct scene_tree *tree, const struct raw_cache *cache, struct scene *scene)
{
	static const struct {
		const char *name;
		double bytes;
	} units[] = {{"MB", 1e6}, {"GB", 1e9}, {"MiB", 1048576}, {"GiB", 1073741824}};
	const double most = 1e15;
	const struct scene_node *node = scene_tree_find(tree, "cache.memory");
	const char *text = cache->memory;
	double bytes = NAN;
	if (text == NULL)
		return STATUS_OK;
	if (cache->slots != NULL)
		return scene_error(tree->file, node, "it cannot be given beside cache.slots, which it decides; remove one of the two");
	const size_t digits = strspn(text, "0123456789.");
	char *end;
	const double number = strtod(text, &end);
	for (size_t i = 0; digits > 0 && end == text + digits && i < sizeof units / sizeof units[0]; i++)
		if (strcmp(end + strspn(end, " "), units[i].name) == 0)
			bytes = number * units[i].bytes;
	if (isnan(bytes))
		return scene_error(tree->file, node, "%s is no number of bytes; give a number and one of MB, GB, MiB, GiB, as in 512 MB",
				   scene_quote(text).text);
	if (!(bytes >= 1 && bytes <= most))
		return scene_error(tree->file, node, "%s is out of range; allowed: above 0 to 1e6 GB", scene_quote(text).text);
	scene->memory = (uint64_t)bytes;
	return STATUS_OK;
}

enum status scene_check(const struct scene_tree *tree, const struct raw_scene *raw,
			struct scene *scene)
{
	const struct raw_cache none = {.slots = NULL};
	const struct raw_cache *cache = raw->cache != NULL ? raw->cache : &none;
	if (raw->store != NULL) {
		scene->store = scene_file_beside(tree->folder, raw->store);
		TRY_MEM(scene->store, "reading the scene");
	}
	scene->time_step = scene_number(raw->time_step, "time_step");
	scene->end_time = raw->end_time != NULL ? *raw->end_time : (double)INFINITY;
	scene->gravity = scene_number(raw->gravity, "gravity");
	scene->gravity_given = raw->gravity != NULL;
	scene->spacing = raw->spacing != NULL ? *raw->spacing : 0;
	scene->outside = raw->outside != NULL ? (enum scene_outside)*raw->outside : SCENE_STOP;
	scene->slots = (uint32_t)whole(cache->slots, "cache.slots");
	scene->loaders = (uint32_t)whole(cache->loaders, "cache.loaders");
	scene->prefetch = scene_number(cache->prefetch, "cache.prefetch");

	TRY(check_memory(tree, cache, scene));
	TRY(check_coordinates(raw, scene));
	bool carries = false;
	for (uint32_t i = 0; i < raw->objects_count; i++)
		carries |= raw->objects[i].carry != NULL && *raw->objects[i].carry;
	TRY(check_redistribute(tree, raw->redistribute, carries, scene));
	TRY(check_compute(tree, raw->compute, scene));
	TRY(check_output(tree, raw->output, scene));
	scene->vegetation.present = raw->attributes != NULL && raw->attributes->vegetation != NULL; /* the rest later, by class of soil */
	TRY(scene_check_objects(tree, raw, scene));
	TRY(scene_check_vehicles(tree, raw, scene));
	TRY(scene_check_view(tree, raw, scene));
	TRY(scene_check_cameras(tree, raw, scene));
	TRY(scene_check_lidars(tree, raw, scene));
	TRY(scene_check_soil(tree, raw, scene));
	TRY(scene_check_relief(tree, raw, scene));
	TRY(scene_check_attributes(tree, raw, scene));
	TRY(scene_check_units(tree, raw, scene));
	return scene_hash(scene);
}
