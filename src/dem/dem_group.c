/*
 * Parts the sources into groups. The sources of a group have one lattice and are read as one raster, so that no seam is seen
 * between them. Groups are resampled one by one. An earlier group lies over later ones.
 *
 * Invariant: where two sources overlap, the first named one is in an earlier group, or is earlier in the same group.
 */
#include "dem_gdal.h"

/* The ground of a source, in its own SRS. */
struct area {
	double low[2], high[2];
};

static struct area area_of(const struct gdal_source *source)
{
	const double *p = source->place;
	struct area area = {{(double)INFINITY, (double)INFINITY}, {-(double)INFINITY, -(double)INFINITY}};
	for (int corner = 0; corner < 4; corner++) {
		double column = (corner & 1) != 0 ? source->width : 0, row = (corner & 2) != 0 ? source->height : 0;
		double at[2] = {p[0] + column * p[1] + row * p[2], p[3] + column * p[4] + row * p[5]};
		for (int i = 0; i < 2; i++) {
			area.low[i] = fmin(area.low[i], at[i]);
			area.high[i] = fmax(area.high[i], at[i]);
		}
	}
	return area;
}

/* Returns true also if it is not known, since the sources have two SRS. */
static bool may_overlap(const struct gdal_source *a, const struct gdal_source *b)
{
	if (a->system != b->system)
		return true;
	struct area one = area_of(a), other = area_of(b);
	return one.low[0] < other.high[0] && other.low[0] < one.high[0] && one.low[1] < other.high[1] && other.low[1] < one.high[1];
}

static bool group_overlaps(const struct dem_group *group, const struct gdal_source *source)
{
	for (size_t i = 0; i < group->count; i++)
		if (may_overlap(group->sources[i], source))
			return true;
	return false;
}

/* Returns the group that a source may join; NULL: none. It must not come to lie over an earlier source. */
static struct dem_group *group_for(struct dem_groups *groups, const struct gdal_source *source)
{
	for (size_t i = groups->count; i-- > 0;) {
		if (dem_layers_fit(groups->groups[i].sources[0], source))
			return &groups->groups[i];
		if (group_overlaps(&groups->groups[i], source))
			break;
	}
	return NULL;
}

enum status dem_groups_init(struct dem_groups *groups, const struct gdal_source *sources, size_t count)
{
	*groups = (struct dem_groups){.groups = mem_calloc(count, sizeof *groups->groups)};
	TRY_MEM(groups->groups, "opening the sources");
	for (size_t i = 0; i < count; i++) {
		struct dem_group *group = group_for(groups, &sources[i]);
		if (group == NULL)
			group = &groups->groups[groups->count++];
		size_t room = group->count + 1;
		if ((room & (room - 1)) == 0 || group->sources == NULL) /* grows by doubling */
			TRY(mem_resize(&group->sources, 2 * room, sizeof *group->sources, "opening the sources"));
		group->sources[group->count++] = &sources[i];
	}
	for (size_t i = 0; i < groups->count; i++)
		TRY(dem_layers_create(groups->groups[i].sources, groups->groups[i].count, &groups->groups[i].layers));
	return STATUS_OK;
}

void dem_groups_finish(struct dem_groups *groups)
{
	for (size_t i = 0; i < groups->count; i++) {
		dem_sampler_destroy(groups->groups[i].sampler);
		dem_map_destroy(groups->groups[i].back);
		dem_layers_destroy(groups->groups[i].layers);
		mem_free(groups->groups[i].sources);
	}
	mem_free(groups->groups);
	*groups = (struct dem_groups){0};
}
