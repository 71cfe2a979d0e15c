/*
 * Parts finer sources from the others, so that they become insets. Otherwise a scan of 5 cm would make a country of 30 m one of 5 cm.
 *
 * The coarsest source, and all that are less than twice as fine, make the terrain. Each other source is parted from them if it lies within
 * their area, and is at least twice as fine as the finest of them. Otherwise it joins them.
 * Parted sources of about the same spacing that lie side by side make one set, so that no rim is seen between them.
 */
#include "dem_grid.h"

#define TWICE (1 - 1e-6)

/* What is known of a group. */
struct part {
	double spacing; /* metres */
	struct dem_area area;
	bool finer;
	size_t set;
};

void dem_grid_find_system(struct gdal_source *sources, size_t i)
{
	sources[i].system = (int)i;
	for (size_t j = 0; j < i && sources[i].system == (int)i; j++) {
		if (sources[j].system != (int)j)
			continue;
		bool same = sources[i].srs == NULL || sources[j].srs == NULL ? sources[i].srs == sources[j].srs
									      : OSRIsSame(sources[i].srs, sources[j].srs) != 0;
		sources[i].system = same ? (int)j : (int)i;
	}
}


static bool lies_within(const struct dem_area *inner, const struct dem_area *outer, double margin)
{
	for (int i = 0; i < 2; i++)
		if (!(inner->low[i] >= outer->low[i] - margin && inner->high[i] <= outer->high[i] + margin))
			return false;
	return true;
}

static void widen(struct dem_area *area, const struct dem_area *more)
{
	for (int i = 0; i < 2; i++) {
		area->low[i] = fmin(area->low[i], more->low[i]);
		area->high[i] = fmax(area->high[i], more->high[i]);
	}
}

static enum status measure(struct gdal_grid *gdal, const struct dem_params *params, struct part *parts)
{
	TRY(dem_target_measure(params, &gdal->groups, &gdal->target));
	for (size_t i = 0; i < gdal->groups.count; i++) {
		parts[i].spacing = dem_target_own_spacing(&gdal->groups.groups[i]);
		TRY(dem_target_area(&gdal->target, &gdal->groups.groups[i], &parts[i].area));
	}
	return STATUS_OK;
}

static bool side_by_side(const struct part *a, const struct part *b, double margin)
{
	struct dem_area wide = a->area;
	for (int i = 0; i < 2; i++) {
		wide.low[i] -= margin;
		wide.high[i] += margin;
		if (!(wide.low[i] <= b->area.high[i] && b->area.low[i] <= wide.high[i]))
			return false;
	}
	return true;
}

/* Decides which parts are finer. Returns the spacing of the terrain. */
static double decide(const struct gdal_grid *gdal, struct part *parts)
{
	const size_t count = gdal->groups.count;
	double coarsest = 0, finest = (double)INFINITY;
	for (size_t i = 0; i < count; i++)
		coarsest = fmax(coarsest, parts[i].spacing);
	for (size_t i = 0; i < count; i++)
		parts[i].finer = 2 * parts[i].spacing * TWICE <= coarsest;
	for (bool changed = true; changed;) {
		struct dem_area area = {{(double)INFINITY, (double)INFINITY}, {-(double)INFINITY, -(double)INFINITY}};
		for (size_t i = 0; i < count; i++)
			if (!parts[i].finer) {
				widen(&area, &parts[i].area);
				finest = fmin(finest, parts[i].spacing);
			}
		const struct part whole = {.area = area};
		changed = false;
		for (size_t i = 0; i < count; i++) {
			const bool stays = lies_within(&parts[i].area, &area, coarsest) && 2 * parts[i].spacing * TWICE <= finest;
			if (!parts[i].finer || stays)
				continue;
			parts[i].finer = false;
			changed = true;
			note("%s: its posts of %g m are finer than those of %g m beside it, but it does not lie within them; so all is stored every %g m. "
			     "%s, or give --spacing", gdal->groups.groups[i].sources[0]->path, parts[i].spacing, coarsest,
			     fmin(finest, parts[i].spacing), side_by_side(&parts[i], &whole, 0) ? "Name it with --inset" : "Import it apart");
		}
	}
	return finest;
}

static int level_of(double spacing, double finest)
{
	return (int)ceil(log2(finest / spacing) - 1e-6);
}

/* Numbers the sets. */
static void join(struct part *parts, size_t count, double finest)
{
	for (size_t i = 0; i < count; i++)
		parts[i].set = i;
	for (bool changed = true; changed;) {
		changed = false;
		for (size_t i = 0; i < count; i++)
			for (size_t j = 0; j < i; j++)
				if (parts[i].finer && parts[j].finer && parts[i].set != parts[j].set &&
				    level_of(parts[i].spacing, finest) == level_of(parts[j].spacing, finest) &&
				    side_by_side(&parts[i], &parts[j], parts[i].spacing + parts[j].spacing)) {
					const size_t least = parts[i].set < parts[j].set ? parts[i].set : parts[j].set;
					parts[i].set = parts[j].set = least;
					changed = true;
				}
	}
}

static const struct part *part_of(const struct gdal_grid *gdal, const struct part *parts, const struct gdal_source *source)
{
	for (size_t i = 0; i < gdal->groups.count; i++)
		for (size_t j = 0; j < gdal->groups.groups[i].count; j++)
			if (gdal->groups.groups[i].sources[j] == source)
				return &parts[i];
	return NULL;
}

/* Moves the names of finer sources to grid.finer. `gone`: for each source, whether it is finer. */
static enum status name_finer(struct gdal_grid *gdal, const struct part *parts, bool *gone)
{
	struct dem_grid *grid = &gdal->grid;
	TRY(mem_make(&grid->finer_sets, gdal->source_count, sizeof *grid->finer_sets, "opening the sources"));
	for (size_t i = 0; i < gdal->source_count; i++) {
		const struct part *part = part_of(gdal, parts, &gdal->sources[i]);
		gone[i] = part->finer;
		if (!gone[i])
			continue;
		grid->finer_sets[grid->finer.count] = part->set;
		TRY(dem_list_add(&grid->finer, gdal->sources[i].path));
	}
	return STATUS_OK;
}

static enum status take_out(struct gdal_grid *gdal, struct dem_list *list, const bool *gone)
{
	dem_groups_finish(&gdal->groups);
	size_t left = 0;
	for (size_t i = 0; i < gdal->source_count; i++) {
		if (gone[i]) {
			dem_source_finish(&gdal->sources[i]);
			continue;
		}
		gdal->sources[left] = gdal->sources[i];
		dem_grid_find_system(gdal->sources, left++);
	}
	for (size_t i = gdal->source_count; i-- > 0;)
		if (gone[i])
			dem_list_drop(list, i);
	gdal->source_count = left;
	return dem_groups_init(&gdal->groups, gdal->sources, left);
}

enum status dem_split(struct gdal_grid *gdal, const struct dem_params *params, struct dem_list *list)
{
	const size_t count = gdal->groups.count;
	if (count < 2 || params->spacing > 0 || params->anchor != NULL)
		return STATUS_OK;
	struct part *parts = mem_calloc(count, sizeof *parts);
	bool *gone = mem_calloc(gdal->source_count, sizeof *gone);
	enum status status;
	TRY_OR(done, parts != NULL && gone != NULL ? measure(gdal, params, parts) : fail_memory("opening the sources"));
	join(parts, count, decide(gdal, parts));
	/* `source` keeps the posts of the first source. */
	bool any = false;
	for (size_t i = 0; i < count; i++)
		any = any || parts[i].finer;
	if (any && !(gdal->target.keep && parts[0].finer)) {
		TRY_OR(done, name_finer(gdal, parts, gone));
		TRY_OR(done, take_out(gdal, list, gone));
	}
done:
	mem_free_all(parts, gone);
	return status;
}
