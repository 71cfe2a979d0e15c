/* Numbers of the soil from rasters: opened, checked, told. */
#include <math.h>

#include "world/internal.h"

bool world_needs_rasters(const struct scene *scene)
{
	return scene->raster_count > 0 && (scene->object_count > 0 || scene_moves_bodies(scene));
}

static struct scene_parameter parameter_of(enum soil_number number)
{
	char key[64];
	struct scene_parameter parameter = {.low = -INFINITY, .high = INFINITY};
	snprintf(key, sizeof key, "soil.%s", soil_number_key(number));
	scene_parameter(key, &parameter);
	return parameter;
}

/* Sets the numbers on which bearing depends to the least that a post of this soil may have. */
static void take_least(const struct world *world, struct soil_numbers *soil)
{
	struct soil_raster rasters[SOIL_RASTERS];
	int count = world_rasters(world, rasters);
	for (int i = 0; i < count; i++) {
		double *number = soil_number_in(soil, rasters[i].number);
		if (rasters[i].number == SOIL_BEKKER_KC || rasters[i].number == SOIL_BEKKER_KPHI)
			*number = fmin(*number, rasters[i].low);
	}
}

enum status world_check_bearing(const struct world *world, const char *name, const struct soil_shape *shape)
{
	for (int i = 0; world->resident.soil_rasters != NULL && i < world->scene->soil_count; i++) {
		struct soil_numbers soil = world->scene->soils[i];
		take_least(world, &soil);
		double width, modulus = scene_soil_modulus(&soil, shape, &width);
		if (!(modulus > 0))
			return fail_with(STATUS_INPUT, "soil.rasters: bekker_kc / b + bekker_kphi is as low as %.4g under %s; it must be above "
						       "0; raise the least values of the rasters", modulus, name);
	}
	return STATUS_OK;
}

/* Rigid ground does not slide, where a layer over it is thinnest either. */
static enum status check_depth(const struct world *world)
{
	const struct scene *scene = world->scene;
	bool rigid = false;
	for (int i = 0; i < scene->soil_count; i++)
		rigid = rigid || (scene->soils[i].over != NULL && soil_is_rigid(scene->soils[i].over));
	for (int i = 0; rigid && i < scene->raster_count; i++) {
		double low, high;
		resident_soil_rasters_range(world->resident.soil_rasters, i, &low, &high);
		if (scene->rasters[i].number == SOIL_THICKNESS && scene->depth > low)
			return fail_with(STATUS_INPUT, "redistribute.depth: %g m is how deep soil slides, and rigid ground begins at %g m where %.200s has the least "
						       "thickness; give at most that", scene->depth, low, scene->rasters[i].path);
	}
	return STATUS_OK;
}

enum status world_open_rasters(struct world *world)
{
	const struct scene *scene = world->scene;
	struct soil_rasters_params params = {
		.count = scene->raster_count,
		.loaders = world->facts.limits.loaders,
		.places = scene_moves_bodies(scene),
		.meta = world->resident.meta,
	};
	if (!world_needs_rasters(scene))
		return STATUS_OK;
	for (int i = 0; i < scene->raster_count; i++) {
		const struct scene_parameter parameter = parameter_of(scene->rasters[i].number);
		params.rasters[i] = (struct soil_raster_params){
			.path = scene->rasters[i].path,
			.name = soil_number_key(scene->rasters[i].number),
			.unit = parameter.unit,
			.low = parameter.low,
			.high = parameter.high,
			.above = parameter.above,
		};
	}
	TRY(resident_soil_rasters_open(&params, &world->resident.soil_rasters));
	TRY(check_depth(world));
	for (size_t i = 0; i < scene->object_count; i++)
		TRY(world_check_bearing(world, scene->objects[i].name, &scene->objects[i].shape));
	return STATUS_OK;
}

int world_rasters(const struct world *world, struct soil_raster *rasters)
{
	const struct scene *scene = world->scene;
	for (int i = 0; i < scene->raster_count; i++) {
		double low = 0, high = 0, unit = scene_raster_unit(scene->rasters[i].number);
		if (world->resident.soil_rasters != NULL)
			resident_soil_rasters_range(world->resident.soil_rasters, i, &low, &high);
		rasters[i] = (struct soil_raster){scene->rasters[i].number, low * unit, high * unit};
	}
	return scene->raster_count;
}

struct world_raster world_raster(const struct world *world, int raster)
{
	const struct scene_raster *of = &world->scene->rasters[raster];
	struct world_raster told = {.key = soil_number_key(of->number), .unit = parameter_of(of->number).unit, .path = of->path};
	resident_soil_rasters_range(world->resident.soil_rasters, raster, &told.low, &told.high);
	told.step = (told.high - told.low) / (SOIL_LEVELS - 1);
	return told;
}

void world_advise_rasters(const struct world *world, scene_advice_fn tell, void *user)
{
	static const struct {
		double least;
		const char *probably;
	} doubts[SOIL_NUMBERS] = {
		[SOIL_FRICTION_ANGLE] = {SCENE_LEAST_ANGLE, "radians"},
		[SOIL_COHESION] = {SCENE_LEAST_COHESION, "kPa"},
		[SOIL_BEKKER_KPHI] = {SCENE_LEAST_KPHI, "kN/m^(n+2)"},
	};
	for (int i = 0; world->resident.soil_rasters != NULL && i < world->scene->raster_count; i++) {
		const struct world_raster told = world_raster(world, i);
		const enum soil_number number = world->scene->rasters[i].number;
		const bool long_shear = number == SOIL_JANOSI_SHEAR && told.low > SCENE_MOST_SHEAR;
		char text[400];
		if (!long_shear && (told.high <= 0 || told.high >= doubts[number].least))
			continue;
		snprintf(text, sizeof text, "soil.rasters.%s: %.200s has at %s %g %s, which is %s than soils have, and probably in %s; give %s", told.key,
			 told.path, long_shear ? "least" : "most", long_shear ? told.low : told.high, told.unit, long_shear ? "more" : "less",
			 long_shear ? "cm or mm" : doubts[number].probably, told.unit);
		tell(user, text);
	}
}

enum status world_soil_numbers_at(struct world *world, double x, double y, struct soil_numbers *soil, bool *found)
{
	int index;
	uint8_t levels[PAGES_NUMBER_BYTES];
	struct soil_raster rasters[SOIL_RASTERS];
	enum status status = world_soil_at(world, x, y, &index);
	*found = status == STATUS_OK && index >= 0;
	if (!*found)
		return status;
	*soil = world->scene->soils[index];
	if (world->resident.soil_rasters == NULL)
		return STATUS_OK;
	int count = world_rasters(world, rasters);
	status = resident_soil_rasters_at(world->resident.soil_rasters, world->resident.level, (int64_t)floor(x / world->resident.spacing + 0.5),
					  (int64_t)floor(y / world->resident.spacing + 0.5), levels);
	for (int i = 0; i < count && status == STATUS_OK; i++)
		if (levels[i] != 0)
			*soil_number_in(soil, rasters[i].number) = soil_raster_value(&rasters[i], levels[i]);
	return status;
}
