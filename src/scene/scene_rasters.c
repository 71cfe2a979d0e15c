/* Checks soil.rasters: numbers of the soil that differ from post to post. What the rasters hold is checked when a world opens them. */

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"

static const char *path_of(const struct raw_rasters *raw, enum soil_number number)
{
	const char *const paths[SOIL_NUMBERS] = {
		[SOIL_BEKKER_KC] = raw->bekker_kc,
		[SOIL_BEKKER_KPHI] = raw->bekker_kphi,
		[SOIL_BEKKER_N] = raw->bekker_n,
		[SOIL_COHESION] = raw->cohesion,
		[SOIL_FRICTION_ANGLE] = raw->friction_angle,
		[SOIL_JANOSI_SHEAR] = raw->janosi_shear,
		[SOIL_ELASTIC_STIFFNESS] = raw->elastic_stiffness,
		[SOIL_THICKNESS] = raw->thickness,
		[SOIL_COMPACTION] = raw->compaction,
	};
	return paths[number];
}

static struct scene_list models_with_rasters(void)
{
	struct scene_list models = {.length = 0};
	for (int model = 0; model < DEFORM_MODELS; model++)
		if (deform_model_row((enum deform_model)model)->bears)
			scene_list_add(&models, deform_model_row((enum deform_model)model)->name);
	return models;
}

static bool has_layer(const struct scene *scene)
{
	bool has = false;
	for (int i = 0; i < scene->soil_count; i++)
		has = has || scene->soils[i].over != NULL;
	return has;
}

static enum status take(const struct scene_tree *tree, const char *path, enum soil_number number, struct scene *scene)
{
	const char *key = soil_number_key(number);
	const struct scene_node *node = scene_tree_find(tree, "soil.rasters.%s", key);
	if (number == SOIL_THICKNESS && !has_layer(scene))
		return scene_error(tree->file, node, "is of a layer, and no soil lies over another; give soil.over too");
	if (number == SOIL_COMPACTION && !(scene->hardening > 0))
		return scene_error(tree->file, node, "is how dense the soil is, which counts with redistribute.hardening alone; give that too");
	if (scene->raster_count == SOIL_RASTERS)
		return scene_error(tree->file, node, "is one raster too many; allowed: at most %d", SOIL_RASTERS);
	struct scene_raster *raster = &scene->rasters[scene->raster_count];
	raster->number = number;
	raster->path = scene_file_beside(tree->folder, path);
	TRY_MEM(raster->path, "reading a raster of the soil");
	scene->raster_count++;
	return scene_file_hash(raster->path, scene_told(tree->file, node, path).text, SCENE_RASTER_BYTES, raster->hash);
}

enum status scene_check_rasters(const struct scene_tree *tree, const struct raw_rasters *raw, struct scene *scene)
{
	const struct soil_model *model = deform_model_row(scene->model);
	if (raw == NULL)
		return STATUS_OK;
	if (!model->bears && model->numbers != NULL)
		return scene_error(tree->file, scene_tree_find(tree, "soil.rasters"),
				   "model %s reads a soil's numbers by class alone; allowed with: %s; or give soil.map", model->name,
				   models_with_rasters().text);
	for (int number = 0; model->bears && number < SOIL_NUMBERS; number++) {
		const char *path = path_of(raw, (enum soil_number)number);
		if (path != NULL)
			TRY(take(tree, path, (enum soil_number)number, scene));
	}
	return STATUS_OK;
}

double scene_raster_unit(enum soil_number number)
{
	return number == SOIL_FRICTION_ANGLE ? 3.14159265358979323846 / 180 : 1;
}
