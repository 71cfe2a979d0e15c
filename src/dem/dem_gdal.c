/*
 * Makes one grid of all sources that GDAL can read. It opens the sources, chooses the lattice of the result, and resamples each
 * source to it unless its posts are there already. The rest of dem reads the grid row by row.
 *
 * A post is that of the first source that has data all around it. If there is none, it is that of the first source with any data.
 */
#include "dem_grid.h"

#include <stdio.h>

#define LEAST_COVERED 0.05 /* of the posts, by sources that lie apart */
#define MOST_EMPTY 1e9     /* posts of a terrain that sources cover less: minutes, for nothing */

static void gdal_destroy(struct dem_grid *grid)
{
	struct gdal_grid *gdal = (struct gdal_grid *)grid;
	crew_destroy(gdal->crew);
	for (size_t i = 0; gdal->readers != NULL && i < gdal->reader_count; i++)
		dem_reader_finish(&gdal->readers[i], i > 0);
	mem_free(gdal->readers);
	dem_groups_finish(&gdal->groups);
	dem_target_finish(&gdal->target);
	for (size_t i = 0; i < gdal->source_count; i++)
		dem_source_finish(&gdal->sources[i]);
	mem_free_all(gdal->sources, gdal->name, gdal->sampled, gdal);
}

/* Tells what users may not expect. An inset is opened several times, and told the first time. */
static void note_remarks(const struct gdal_grid *gdal, const struct dem_params *params)
{
	for (int remark = 0; remark < SOURCE_REMARKS && (params->anchor == NULL || params->spacing == 0); remark++) {
		const struct gdal_source *first = NULL;
		size_t count = 0;
		for (size_t i = gdal->source_count; i-- > 0;)
			if (gdal->sources[i].remarks[remark] != NULL) {
				first = &gdal->sources[i];
				count++;
			}
		char more[32] = "";
		if (count > 1)
			snprintf(more, sizeof more, " and %zu more", count - 1);
		if (first != NULL)
			note("%s%s: %s", first->path, more, first->remarks[remark]);
	}
}

static enum status open_sources(struct gdal_grid *gdal, const struct dem_params *params,
				const struct dem_list *list)
{
	OGRSpatialReferenceH override = NULL;
	if (params->s_srs != NULL) {
		override = dem_srs_parse_given(params->s_srs);
		if (override == NULL)
			return STATUS_INPUT;
	}
	enum status status = STATUS_OK;
	for (size_t i = 0; i < list->count; i++) {
		gdal->source_count = i + 1;
		TRY_OR(done, dem_source_init(&gdal->sources[i], params, list->paths[i], override, (int)i, &gdal->grid.files));
		dem_grid_find_system(gdal->sources, i);
	}
	note_remarks(gdal, params);
done:
	if (override != NULL)
		OSRDestroySpatialReference(override);
	return status;
}

/* Returns the unit of heights for all sources, metres: the finest of their units. */
static double common_unit(const struct gdal_source *sources, size_t count)
{
	double unit = sources[0].unit;
	for (size_t i = 1; i < count; i++)
		unit = sources[i].unit < unit ? sources[i].unit : unit;
	return unit;
}

/* Returns true if heights stay whole numbers of the unit: all sources have it, and none is resampled. */
static bool all_whole(const struct gdal_grid *gdal)
{
	bool whole = true;
	for (size_t i = 0; i < gdal->source_count; i++)
		whole = whole && gdal->sources[i].whole && gdal->sources[i].unit == gdal->grid.unit;
	for (size_t i = 0; i < gdal->groups.count; i++)
		whole = whole && dem_sampler_copies(gdal->groups.groups[i].sampler);
	return whole;
}

/* Returns the smallest panel of the sources, in posts of the target. Where these are resampled it is half as wide, since they may
 * lie slanted over the source's rows. */
static int64_t common_panel(const struct gdal_grid *gdal)
{
	double least = 0;
	for (size_t i = 0; i < gdal->groups.count; i++) {
		const struct dem_group *group = &gdal->groups.groups[i];
		double scale = dem_sampler_copies(group->sampler) ? 1 : group->step[0] / gdal->target.spacing / 2;
		for (size_t j = 0; j < group->count; j++) {
			double panel = (double)group->sources[j]->panel_posts * scale;
			if (panel > 0 && (least == 0 || panel < least))
				least = panel;
		}
	}
	return (int64_t)fmin(ceil(least), 1e9);
}

static enum status several_agree(const struct gdal_grid *gdal)
{
	if (gdal->source_count > UINT16_MAX)
		return fail_with(STATUS_INPUT, "%s and others: %zu sources are too many; import fewer at once, or join them with "
				 "gdalbuildvrt", gdal->name, gdal->source_count);
	for (size_t i = 0; gdal->source_count > 1 && i < gdal->source_count; i++)
		if (!gdal->sources[i].placed)
			return fail_with(STATUS_INPUT, "%s: has no place among other sources; import it alone, or give it a place "
					 "with gdal_translate", gdal->sources[i].path);
	return STATUS_OK;
}

/* Tells if a metre of the target differs much from a metre on the ground. There, ruts and wheels have a wrong size. */
static void note_scale(const struct gdal_grid *gdal)
{
	if (gdal->grid.ground_off != 0)
		note("%s: in its target SRS distances are up to %.2g %% off those on the ground; import less at once, or choose "
		     "a --t-srs that is true there", gdal->name, 100 * fabs(gdal->grid.ground_off));
}

/* Tells what becomes of posts that are resampled only because they are not square or not in metres. */
static void note_resampled(struct gdal_grid *gdal, const struct dem_params *params)
{
	size_t resampled = 0;
	const struct dem_group *first = NULL;
	for (size_t i = 0; i < gdal->groups.count; i++) {
		const struct dem_group *group = &gdal->groups.groups[i];
		if (dem_sampler_copies(group->sampler))
			continue;
		first = resampled == 0 ? group : first;
		resampled += group->count;
	}
	if (first == NULL)
		return;
	if (params->spacing > 0 || params->anchor != NULL)
		return;
	char more[64] = "";
	if (resampled > first->count)
		snprintf(more, sizeof more, ", and those of %zu more,", resampled - first->count);
	note("%s: posts of %.6g x %.6g m%s are resampled to square posts of %g m", first->sources[0]->path, first->step[0], first->step[1], more,
	     gdal->target.spacing);
}

/* Tells if heights of two sources are not above the same. */
static void note_vertical(const struct gdal_grid *gdal)
{
	const struct gdal_source *first = &gdal->sources[0];
	bool told = false;
	for (size_t i = 1; i < gdal->source_count && !told; i++)
		told = dem_vertical_note(first->path, first->vertical, gdal->sources[i].path, gdal->sources[i].vertical);
}

static double apart(const struct gdal_source *a, const struct gdal_source *b)
{
	double gap[2];
	for (int i = 0; i < 2; i++)
		gap[i] = fmax(0, fmax(a->low[i] - b->high[i], b->low[i] - a->high[i]));
	return hypot(gap[0], gap[1]);
}

static double longest_side(const struct gdal_source *source)
{
	return fmax(source->high[0] - source->low[0], source->high[1] - source->low[1]);
}

/* Finds a source to which no chain of neighbours leads from the first one. Neighbours are at most a side apart. */
static enum status find_lone(const struct gdal_grid *gdal, const struct gdal_source **lone)
{
	const size_t count = gdal->source_count;
	size_t *chain = mem_alloc(count, sizeof *chain), known = 1; /* numbers of sources: first those that are reached */
	*lone = NULL;
	TRY_MEM(chain, "opening the sources");
	for (size_t i = 0; i < count; i++)
		chain[i] = i;
	for (size_t i = 0; i < known; i++)
		for (size_t j = known; j < count; j++) {
			const struct gdal_source *one = &gdal->sources[chain[i]], *other = &gdal->sources[chain[j]];
			if (apart(one, other) > fmax(longest_side(one), longest_side(other)))
				continue;
			const size_t reached = chain[j];
			chain[j] = chain[known];
			chain[known++] = reached;
		}
	if (known < count)
		*lone = &gdal->sources[chain[known]];
	mem_free(chain);
	return STATUS_OK;
}

/* Finds what share of the posts the sources cover. Sources that lie apart in a nearly empty terrain are refused if it is large, or else told. */
static enum status check_cover(struct gdal_grid *gdal)
{
	const struct dem_target *target = &gdal->target;
	const double posts = (double)target->width * (double)target->height;
	double covered = 0;
	for (size_t i = 0; i < gdal->source_count; i++) {
		double area = 1;
		for (int axis = 0; axis < 2; axis++) {
			const double side = (double)((axis == 0 ? target->width : target->height) - 1) * target->spacing, from = target->origin[axis];
			area *= fmax(0, fmin(gdal->sources[i].high[axis], from + side) - fmax(gdal->sources[i].low[axis], from)) / side;
		}
		covered += area;
	}
	gdal->grid.covered = fmin(covered, 1);
	const struct gdal_source *one = &gdal->sources[0], *other = NULL;
	if (covered < LEAST_COVERED)
		TRY(find_lone(gdal, &other));
	if (other == NULL)
		return STATUS_OK;
	char told[512];
	snprintf(told, sizeof told, "%.160s: lies %.4g km from %.160s, and the sources cover %.2g %% of %.3g posts", one->path,
		 apart(one, other) / 1000, other->path, 100 * covered, posts);
	if (posts >= MOST_EMPTY)
		return fail_with(STATUS_INPUT, "%s; if one has a wrong SRS, name the right one with --s-srs, else import them apart or with a coarser --spacing",
				 told);
	note("%s; the rest is empty", told);
	return STATUS_OK;
}

static enum status describe(struct gdal_grid *gdal, const struct dem_params *params)
{
	struct dem_grid *grid = &gdal->grid;
	const struct dem_target *target = &gdal->target;
	grid->width = target->width;
	grid->height = target->height;
	grid->spacing = target->spacing;
	grid->origin[0] = target->origin[0];
	grid->origin[1] = target->origin[1];
	grid->placed = gdal->sources[0].placed;
	grid->unit = common_unit(gdal->sources, gdal->source_count);
	grid->panel_posts = common_panel(gdal);
	grid->whole = all_whole(gdal);
	for (size_t i = 0; i < gdal->source_count; i++)
		grid->shifted = grid->shifted || gdal->sources[i].from != NULL;
	for (size_t i = 0; i < gdal->groups.count; i++)
		if (!dem_sampler_copies(gdal->groups.groups[i].sampler))
			grid->misfit = dem_grid_misfit;
	const struct dem_group *projected = NULL;
	size_t others = 0;
	for (size_t i = gdal->groups.count; i-- > 0;)
		if (gdal->groups.groups[i].projected) {
			others += projected != NULL && projected->sources[0]->system != gdal->groups.groups[i].sources[0]->system;
			projected = &gdal->groups.groups[i];
		}
	if (projected != NULL) {
		const char *name = OSRGetName(projected->sources[0]->srs);
		char text[256];
		int length = snprintf(text, sizeof text, "%.150s, posts of about %.4g x %.4g m", name != NULL ? name : "unnamed",
				      projected->step[0], projected->step[1]);
		if (others > 0)
			snprintf(text + length, sizeof text - (size_t)length, ", and from %zu other SRS", others);
		grid->projected = mem_strdup(text);
	}
	grid->keepable = dem_target_keepable(params, &gdal->groups);
	if (target->srs != NULL) {
		grid->srs = dem_srs_wkt(target->srs);
		grid->ground_off = dem_target_ground_off(target);
	}
	grid->vertical = mem_strdup(gdal->sources[0].vertical);
	bool whole = grid->vertical != NULL && (projected == NULL || grid->projected != NULL) && (target->srs == NULL || grid->srs != NULL);
	return whole ? STATUS_OK : fail_memory("opening the sources");
}

/* Drops files that were found in a directory and have no place, as previews, unless none has. */
static void skip_placeless(const struct dem_params *params, struct dem_list *list)
{
	size_t placeless = 0;
	for (size_t i = 0; list->count > 1 && i < list->count; i++)
		placeless += list->found[i] && !dem_source_is_placed(params, list->paths[i]);
	for (size_t i = list->count; placeless > 0 && placeless < list->count && i-- > 0;)
		if (list->found[i] && !dem_source_is_placed(params, list->paths[i])) {
			dem_list_skip(list, i);
			placeless--;
		}
}

static enum status open_grid(struct gdal_grid *gdal, const struct dem_params *params, struct dem_list *list)
{
	skip_placeless(params, list);
	gdal->sources = mem_calloc(list->count, sizeof *gdal->sources);
	gdal->name = mem_strdup(list->paths[0]);
	TRY_MEM(gdal->sources != NULL && gdal->name != NULL, "opening the sources");
	TRY(open_sources(gdal, params, list));
	TRY(several_agree(gdal));
	TRY(dem_turn_join(gdal->sources, gdal->source_count));
	TRY(dem_groups_init(&gdal->groups, gdal->sources, gdal->source_count));
	if (params->apart)
		TRY(dem_split(gdal, params, list));
	TRY(dem_target_choose(params, &gdal->groups, &gdal->target));
	for (size_t i = 0; i < gdal->groups.count; i++)
		TRY(dem_grid_sampler(gdal, &gdal->groups.groups[i]));
	struct dem_lattice lattice;
	dem_target_lattice(&gdal->target, &lattice);
	if (gdal->source_count > 1) {
		TRY(dem_overlap(gdal->sources, gdal->source_count, &lattice, &gdal->grid));
		TRY(check_cover(gdal));
	}
	TRY(describe(gdal, params));
	note_scale(gdal);
	note_resampled(gdal, params);
	note_vertical(gdal);
	return STATUS_OK;
}

enum status dem_gdal_open(const struct dem_params *params, struct dem_list *list, struct dem_grid **out)
{
	TRY(dem_gdal_init(list->paths[0]));
	struct gdal_grid *gdal = mem_calloc(1, sizeof *gdal);
	TRY_MEM(gdal, "opening the sources");
	gdal->grid.destroy = gdal_destroy;
	gdal->grid.read = dem_grid_read;
	gdal->method = params->resample;
	gdal->jobs = params->jobs;
	const enum status status = open_grid(gdal, params, list);
	if (status != STATUS_OK) {
		dem_grid_destroy(&gdal->grid);
		return status;
	}
	*out = &gdal->grid;
	return STATUS_OK;
}

bool dem_gdal_places(const struct dem_params *params, const char *path)
{
	return dem_gdal_init(path) == STATUS_OK && dem_source_is_placed(params, path);
}

bool dem_gdal_knows(const char *path)
{
	/* Without GDAL opening it will say so. */
	return dem_gdal_init(path) != STATUS_OK || GDALIdentifyDriverEx(path, GDAL_OF_RASTER, NULL, NULL) != NULL;
}

const char *dem_gdal_because(void)
{
	static _Thread_local char text[320];
	const bool cut = snprintf(text, sizeof text, ": %s", CPLGetLastErrorMsg()) >= (int)sizeof text;
	if (cut)
		memcpy(text + sizeof text - 5, " ...", 5);
	size_t length = strlen(text);
	if (cut)
		return text;
	while (length > 0 && strchr(":. \n", text[length - 1]) != NULL)
		text[--length] = '\0';
	return text;
}

/* Makes one value of red, green and blue; the first one's rows get it. */
static void join_colours(void **colours, size_t count)
{
	double *red = colours[0];
	const double *green = colours[1], *blue = colours[2];
	for (size_t i = 0; i < count; i++)
		red[i] = 65536 * red[i] + 256 * green[i] + blue[i];
}

/* Gives bytes with a sign, which are read as 0 to 255, their values. */
static void give_sign(double *values, size_t count)
{
	for (size_t i = 0; i < count; i++)
		values[i] -= values[i] > 127 ? 256 : 0;
}

/* The pixel function of a source's vrt: values to metres. The meaning comes as text: scale, offset,
 * whether single, enum dem_stored, how many nodata values, and these. A further source is a mask. */
static CPLErr pixels_to_metres(void **sources, int source_count, void *data, int width, int height,
			       GDALDataType from, GDALDataType to, int pixel_space, int line_space,
			       CSLConstList arguments)
{
	const char *text = CSLFetchNameValue(arguments, "meaning");
	if (text == NULL || from != GDT_Float64 || source_count < 1)
		return CE_Failure;
	char *end;
	struct dem_meaning meaning = {.scale = CPLStrtod(text, &end)};
	meaning.offset = CPLStrtod(end, &end);
	meaning.single = CPLStrtod(end, &end) != 0;
	const int stored = (int)CPLStrtod(end, &end), bands = stored == DEM_STORED_COLOURS ? 3 : 1;
	if (source_count < bands)
		return CE_Failure;
	meaning.nodata_count = (size_t)CPLStrtod(end, &end);
	double *nodata = mem_alloc(meaning.nodata_count, sizeof *nodata);
	double *row = mem_alloc((size_t)width, sizeof *row);
	if (nodata == NULL || row == NULL) {
		mem_free_all(nodata, row);
		CPLError(CE_Failure, CPLE_OutOfMemory, "out of memory");
		return CE_Failure;
	}
	for (size_t i = 0; i < meaning.nodata_count; i++)
		nodata[i] = CPLStrtod(end, &end);
	meaning.nodata = nodata;
	if (bands > 1)
		join_colours(sources, (size_t)width * (size_t)height);
	else if (stored == DEM_STORED_SIGNED_BYTE)
		give_sign(sources[0], (size_t)width * (size_t)height);
	for (int y = 0; y < height; y++) {
		const double *values = (const double *)sources[0] + (size_t)y * (size_t)width;
		const double *mask = source_count > bands ?
			(const double *)sources[bands] + (size_t)y * (size_t)width : NULL;
		dem_metres(&meaning, values, width, row);
		for (int x = 0; mask != NULL && x < width; x++)
			row[x] = mask[x] == 0 ? (double)NAN : row[x];
		GDALCopyWords(row, GDT_Float64, sizeof *row, (char *)data + (ptrdiff_t)y * line_space, to,
			      pixel_space, width);
	}
	mem_free_all(nodata, row);
	return CE_None;
}

void dem_gdal_register(void)
{
	GDALAllRegister();
	GDALSetCacheMax64(DEM_CACHE_BYTES);
	GDALAddDerivedBandPixelFuncWithArgs("furrow_metres", pixels_to_metres, NULL);
}
