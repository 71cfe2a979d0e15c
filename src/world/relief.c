/* Relief of the ground below its source, and rocks. What the scene asks for is given to the store, and all readers take it from there. */
#include <math.h>

#include "world/internal.h"

#define ROCKS_POSTS 3   /* posts that the smallest rock is wide, unless the scene says it */
#define ROCKS_NARROW 2  /* posts: narrower rocks are told */
#define SHARE_TOLD 0.01 /* of slopes that are too steep: fewer are not told */

/* What relief by class reads. All threads share one handle of the raster. */
struct world_relief {
	struct relief_map map;
	struct soil_map *soils;
	struct mutex mutex;
};

static enum status read_classes(void *user, int level, struct post_rect rect, uint8_t *classes)
{
	struct world_relief *relief = user;
	mutex_lock(&relief->mutex);
	enum status status = resident_soil_map_rect(relief->soils, level, rect, classes);
	mutex_unlock(&relief->mutex);
	return status;
}

void world_relief_close(struct world_relief *relief)
{
	if (relief == NULL)
		return;
	resident_soil_map_close(relief->soils);
	mutex_finish(&relief->mutex);
	mem_free(relief);
}

static enum status open_map(struct world *world)
{
	const struct scene *scene = world->scene;
	struct world_relief *relief = mem_calloc(1, sizeof *relief);
	TRY_MEM(relief, "relief");
	mutex_init(&relief->mutex);
	relief->map = (struct relief_map){read_classes, relief};
	world->relief = relief;
	return resident_soil_map_open(&(struct soil_map_params){.path = scene->soil_map, .classes = scene->soil_class, .meta = world->resident.meta},
				      &relief->soils);
}

const struct relief *world_relief(const struct world *world)
{
	return world->resident.store != NULL ? store_relief(world->resident.store) : NULL;
}

const struct rocks *world_rocks(const struct world *world)
{
	return world->resident.store != NULL ? store_rocks(world->resident.store) : NULL;
}

enum gpu_division world_division(const struct world *world)
{
	const struct relief *relief = world_relief(world);
	if (world->resident.level >= 0 || world_is_bearing(world)) /* tiles in host memory get their base there */
		return GPU_UNDIVIDED;
	if (world_rocks(world) != NULL)
		return GPU_UNDIVIDED;
	if (relief == NULL)
		return GPU_DIVIDED;
	return relief->classes > 1 ? GPU_UNDIVIDED : GPU_DIVIDED_RELIEF;
}

struct rocks_spec world_rocks_asked(const struct world *world)
{
	struct rocks_spec spec = world->scene->rocks;
	if (spec.smallest <= 0)
		spec.smallest = fmax(fmax(ROCKS_POSTS * world->resident.spacing, spec.largest / ROCKS_RANGE), ROCKS_SMALLEST_LEAST);
	if (spec.cover > 0 && !rocks_good(&spec))
		spec.cover = 0;
	return spec;
}

enum status world_settle_relief(struct world *world)
{
	const struct rocks_spec rocks = world_rocks_asked(world);
	const struct relief_spec *spec = &world->scene->relief;
	enum status status = spec->classes > 1 && world->resident.level < 0 ? open_map(world) : STATUS_OK;
	if (status == STATUS_OK)
		status = store_set_ground(world->resident.store, spec->classes > 0 ? spec : NULL, rocks.cover > 0 ? &rocks : NULL, world->relief != NULL ? &world->relief->map : NULL);
	if (status != STATUS_OK || isnan(world->resident.meta->low))
		return status;
	/* The reference stays that of the source's heights. */
	const double bound = relief_bound(world_relief(world), 0) + rocks_bound(world_rocks(world)), reference = resident_ground_reference(world->resident.store);
	const double most = fmax(world->resident.meta->high - reference, reference - world->resident.meta->low) + bound;
	if (bound > 0 && most > ldexp(1, 31 - BASE_BITS) - 2)
		return fail_with(STATUS_INPUT, "%s: with it heights from %g to %g m are more than can be deformed; give less roughness or no rocks, or import a "
				 "smaller part", world_relief(world) != NULL ? "relief" : "ground.rocks", world->resident.meta->low, world->resident.meta->high);
	return STATUS_OK;
}

/* Returns the steepest slope between two posts at which a soil is stable, as a tangent; NAN: the model does not let it slide. */
static double stable_slope(const struct world *world, const struct soil_numbers *soil)
{
	const struct soil_model *row = deform_model_row(world->scene->model);
	if (row->slide == NULL)
		return (double)NAN;
	if (row->critical != NULL)
		return lattice_offset_metres(row->critical(soil, world->resident.spacing)) / world->resident.spacing;
	return row->laid_at != NULL ? tan(row->laid_at(soil)) : (double)NAN;
}

/* Tells of soils that relief makes steeper than they are stable. Slopes are taken as normally distributed. */
static void advise_slopes(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct relief *relief = world_relief(world);
	char text[320];
	for (int i = 0; i < scene->soil_count && relief_any(relief); i++) {
		const double slope = relief_slope(relief, relief->classes > 1 ? i : 0, world->resident.meta->extent.spacing);
		const double stable = stable_slope(world, &scene->soils[i]), share = slope > 0 && !isnan(stable) ? erfc(stable / slope / M_SQRT2) : 0;
		if (share < SHARE_TOLD)
			continue;
		snprintf(text, sizeof text, "relief: posts %g m apart slope by %.0f degrees (root mean square), and %s is stable up to %.0f: about %.2g %% of the slopes "
					    "are steeper, and slide where they are touched; give less roughness, a longer wavelength, or posts farther apart",
			 world->resident.spacing, atan(slope) * 180 / M_PI, scene->soil_names[i][0] != '\0' ? scene->soil_names[i] : "the soil", atan(stable) * 180 / M_PI,
			 100 * share);
		tell(user, text);
	}
}

static void advise_rocks(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct rocks_spec *rocks = &scene->rocks;
	const double spacing = world->resident.spacing;
	char text[320];
	if (!(rocks->cover > 0) || world->resident.store == NULL)
		return;
	if (world_rocks(world) == NULL)
		snprintf(text, sizeof text, "ground.rocks: posts %g m apart show no rocks of %g m: the smallest is %d posts wide; give a spacing below %.3g, or larger rocks", spacing,
			 rocks->largest, ROCKS_POSTS, rocks->largest / ROCKS_POSTS);
	else if (rocks->smallest > 0 && rocks->smallest < ROCKS_NARROW * spacing)
		snprintf(text, sizeof text, "ground.rocks.smallest: rocks of %g m are narrower than %d posts, which are %g m apart, and are spikes or not met; give %g m or more, or a "
					    "smaller spacing", rocks->smallest, ROCKS_NARROW, spacing, ROCKS_POSTS * spacing);
	else if (deform_model_row(scene->model)->numbers != NULL && scene->rocks_soil == 0)
		snprintf(text, sizeof text, "ground.rocks: model %s knows no hard ground, so what comes onto rocks sinks into them; name model scm", deform_model_row(scene->model)->name);
	else
		return;
	tell(user, text);
}

void world_advise_relief(const struct world *world, scene_advice_fn tell, void *user)
{
	advise_rocks(world, tell, user);
	const struct relief_spec *spec = &world->scene->relief;
	const double own = world->resident.meta->extent.spacing;
	double longest = 0;
	char text[200];
	for (int i = 0; i < spec->classes; i++)
		longest = spec->waves[i].roughness > 0 ? fmax(longest, spec->waves[i].wavelength) : longest;
	advise_slopes(world, tell, user);
	if (spec->classes == 0 || world->resident.store == NULL || world_relief(world) != NULL)
		return;
	double shows = longest / 2;
	const double level = extent_spacing(&world->resident.meta->extent, extent_level_for(&world->resident.meta->extent, shows));
	if (level > shows) /* by less than SPACING_PRINTED */
		shows = level / 2;
	if (world->resident.level >= 0)
		snprintf(text, sizeof text, "relief: it raises posts between the store's, which are %g m apart, and none are used; give a smaller spacing", own);
	else
		snprintf(text, sizeof text, "relief: posts %g m apart show no waves of %g m; give a spacing of at most %s", world->resident.spacing, longest,
			 number_at_most(shows, 6).text);
	tell(user, text);
}
