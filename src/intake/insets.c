/* Opens the insets of an import and chooses the step of heights that suits all of them. */
#include "intake/internal.h"

#include <math.h>

/* Gives the error and step of an inset's heights by themselves. */
static void step_of(const struct import *import, const struct dem_inset_info *info, double *max_error, double *step)
{
	*max_error = import->max_error >= 0 ? import->max_error : intake_default_error(info->unit);
	*step = intake_step(*max_error, info->unit, false);
}

/* A store has one step: the smallest, or a smaller one of which the terrain's own is a multiple. The terrain keeps its own, so that
 * it takes no more bytes. */
static void choose_step(struct import *import)
{
	struct store_meta *meta = &import->meta;
	const double coarse = meta->step;
	for (size_t i = 0; i < dem_insets_count(import->insets); i++) {
		double max_error, step;
		step_of(import, dem_insets_info(import->insets, i), &max_error, &step);
		meta->max_error = fmax(meta->max_error, max_error); /* it holds everywhere */
		meta->step = fmin(meta->step, step);
	}
	meta->step = intake_common_step(coarse, meta->step);
	import->coarse_step = meta->step > 0 && coarse > meta->step && fmod(coarse, meta->step) == 0 ? coarse : 0;
}

/* Lists the insets: those that were named, then the finer sources by their sets. Returns how many there are. */
static size_t list_insets(struct import *import)
{
	const struct dem_info *info = dem_info(import->opened);
	size_t insets = 0, paths = 0;
	for (size_t i = 0; i < import->inset_count; i++) {
		import->inset_from[insets++] = (struct dem_inset_source){&import->inset_paths[paths], 1, false};
		import->inset_paths[paths++] = import->inset_sources[i];
	}
	for (size_t i = 0; i < info->finer_count; i++) {
		bool begins = true;
		for (size_t j = 0; j < i && begins; j++)
			begins = info->finer_sets[j] != info->finer_sets[i];
		if (!begins)
			continue;
		const size_t first = paths;
		for (size_t j = i; j < info->finer_count; j++)
			if (info->finer_sets[j] == info->finer_sets[i])
				import->inset_paths[paths++] = info->finer[j];
		import->inset_from[insets++] = (struct dem_inset_source){&import->inset_paths[first], paths - first, true};
	}
	return insets;
}

enum status intake_import_open_insets(struct import *import)
{
	const size_t most = import->inset_count + dem_info(import->opened)->finer_count;
	import->inset_paths = mem_alloc(most, sizeof *import->inset_paths);
	import->inset_from = mem_alloc(most, sizeof *import->inset_from);
	TRY_MEM(import->inset_paths != NULL && import->inset_from != NULL, "insets");
	TRY(dem_insets_open(&(struct dem_insets_params){
		.country = import->opened,
		.extent = &import->meta.extent,
		.dem = &import->dem,
		.sources = import->inset_from,
		.count = list_insets(import),
		.feather = import->feather,
		.match = import->match_heights,
	}, &import->insets));
	choose_step(import);
	return STATUS_OK;
}
