/*
 * Chooses the lattice of the result: square posts in metres.
 *
 * The SRS is that of the first source if that is in metres and its scale is true to 0.1 %. Otherwise a metric one is chosen. The
 * spacing is the finest source's. Posts of a source that has this SRS and spacing are kept as they are. Of other sources posts are
 * resampled. Then they lie at whole multiples of the spacing, or, if there is one SRS, start at the south-west post.
 */
#include "dem_gdal.h"

#include <stdio.h>
#include <stdlib.h>

#define SCALE_TOLERANCE 1e-3
#define SAME_SPACING 1e-6
#define PROBES 33 /* points along each side of a raster that are projected to find its extent */

static double round_to_3_digits(double v)
{
	char text[32];
	snprintf(text, sizeof text, "%.3g", v);
	return strtod(text, NULL);
}

/* --- places --- */

struct bounds {
	double low[2], high[2];
	size_t probes, lost; /* points of rasters that were projected, and those of them that are nowhere in the SRS */
};

static const struct bounds nowhere = {.low = {(double)INFINITY, (double)INFINITY}, .high = {-(double)INFINITY, -(double)INFINITY}};

static void bounds_add(struct bounds *bounds, double x, double y)
{
	if (!isfinite(x) || !isfinite(y))
		return;
	bounds->low[0] = fmin(bounds->low[0], x);
	bounds->low[1] = fmin(bounds->low[1], y);
	bounds->high[0] = fmax(bounds->high[0], x);
	bounds->high[1] = fmax(bounds->high[1], y);
}

static bool differ(OGRSpatialReferenceH a, OGRSpatialReferenceH b)
{
	return a != NULL && b != NULL && !OSRIsSame(a, b);
}

/* Adds the area of a raster's posts in `srs`; NULL: in its own. x that counts around the planet is brought within half a turn of `near`. */
static enum status bounds_add_raster(struct bounds *bounds, const struct dem_lattice *raster, OGRSpatialReferenceH srs, double near, const char *name)
{
	OGRCoordinateTransformationH move = NULL;
	double middle;
	const double turn = differ(raster->srs, srs) ? dem_srs_turn(srs, &middle) : 0;
	if (differ(raster->srs, srs)) {
		CPLErrorReset();
		move = OCTNewCoordinateTransformation(raster->srs, srs);
		if (move == NULL)
			return fail_with(STATUS_INPUT, "%s: no way to project it%s; name another target with --t-srs", name,
					 dem_gdal_because());
	}
	for (int i = 0; i < PROBES * PROBES; i++) {
		double x, y;
		dem_lattice_point(raster, (double)(raster->width - 1) * (i % PROBES) / (PROBES - 1),
				  (double)(raster->height - 1) * (i / PROBES) / (PROBES - 1), &x, &y);
		bounds->probes++;
		if (move != NULL && (!OCTTransform(move, 1, &x, &y, NULL) || !isfinite(x) || !isfinite(y))) {
			bounds->lost++;
			continue;
		}
		bounds_add(bounds, turn > 0 ? near + remainder(x - near, turn) : x, y);
	}
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	return STATUS_OK;
}

/* Returns x in `srs` of the first raster's middle; 0: it is nowhere there. */
static double middle_of(const struct dem_groups *groups, OGRSpatialReferenceH srs)
{
	const struct dem_lattice *raster = dem_layers_lattice(groups->groups[0].layers);
	double x, y;
	dem_lattice_point(raster, (double)(raster->width - 1) / 2, (double)(raster->height - 1) / 2, &x, &y);
	if (!differ(raster->srs, srs))
		return x;
	OGRCoordinateTransformationH move = OCTNewCoordinateTransformation(raster->srs, srs);
	const bool there = move != NULL && OCTTransform(move, 1, &x, &y, NULL) && isfinite(x);
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	return there ? x : 0;
}

static enum status bounds_of(const struct dem_groups *groups, OGRSpatialReferenceH srs, struct bounds *bounds)
{
	double middle;
	const double near = dem_srs_turn(srs, &middle) > 0 ? middle_of(groups, srs) : 0;
	*bounds = nowhere;
	for (size_t i = 0; i < groups->count; i++)
		TRY(bounds_add_raster(bounds, dem_layers_lattice(groups->groups[i].layers), srs, near, groups->groups[i].sources[0]->path));
	return STATUS_OK;
}

#define WINDOW_PROBES 33 /* points along each side of the window that are projected */

/* Cuts the bounds, which are in `srs`, to the window. */
static enum status bounds_cut(struct bounds *bounds, const struct dem_params *params, OGRSpatialReferenceH srs)
{
	const double *w = params->window;
	struct bounds window = nowhere;
	OGRSpatialReferenceH given = NULL;
	OGRCoordinateTransformationH move = NULL;
	if (params->window_srs != NULL && srs == NULL)
		return fail_with(STATUS_INPUT, "window SRS \"%.80s\": the sources say no SRS; name theirs with --s-srs, or give the window "
				 "in their coordinates", params->window_srs);
	if (params->window_srs != NULL) {
		char told[120];
		snprintf(told, sizeof told, "window SRS \"%.80s\"", params->window_srs);
		given = dem_srs_parse_beside(params->window_srs, srs);
		if (given == NULL)
			return STATUS_INPUT;
		enum status status = dem_srs_move(told, given, srs, "the terrain's", &move);
		if (status != STATUS_OK) {
			OSRDestroySpatialReference(given);
			return status;
		}
	}
	for (int i = 0; i < WINDOW_PROBES * WINDOW_PROBES; i++) {
		double x = w[0] + (w[2] - w[0]) * (i % WINDOW_PROBES) / (WINDOW_PROBES - 1);
		double y = w[1] + (w[3] - w[1]) * (i / WINDOW_PROBES) / (WINDOW_PROBES - 1);
		if (move == NULL || OCTTransform(move, 1, &x, &y, NULL))
			bounds_add(&window, x, y);
	}
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	if (given != NULL)
		OSRDestroySpatialReference(given);
	const struct bounds whole = *bounds;
	double middle;
	const double turn = dem_srs_turn(srs, &middle); /* -180.1 is 179.9 */
	const double turns = turn > 0 ? rint((whole.low[0] + whole.high[0] - window.low[0] - window.high[0]) / 2 / turn) : 0;
	window.low[0] += turns * turn;
	window.high[0] += turns * turn;
	for (int i = 0; i < 2; i++) {
		bounds->low[i] = fmax(whole.low[i], window.low[i]);
		bounds->high[i] = fmin(whole.high[i], window.high[i]);
	}
	if (bounds->low[0] < bounds->high[0] && bounds->low[1] < bounds->high[1])
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "window %.10g,%.10g,%.10g,%.10g: no source lies there; in the %s SRS they go from %.10g,%.10g to "
			 "%.10g,%.10g", w[0], w[1], w[2], w[3], params->window_srs != NULL ? "target's" : "store's", whole.low[0],
			 whole.low[1], whole.high[0], whole.high[1]);
}

/* --- distances --- */

/* Measures the distance of posts along a row and a column in the middle of a raster, metres. */
static enum status measure(const struct dem_lattice *raster, const struct gdal_source *source, double step[2])
{
	const double *at = raster->at;
	double x, y;
	step[0] = hypot(at[1], at[4]);
	step[1] = hypot(at[2], at[5]);
	if (raster->srs == NULL)
		return STATUS_OK;
	dem_lattice_point(raster, (double)(raster->width - 1) / 2, (double)(raster->height - 1) / 2, &x, &y);
	CPLErrorReset();
	double ground[2] = {dem_srs_ground(raster->srs, x, y, at[1], at[4]), dem_srs_ground(raster->srs, x, y, at[2], at[5])};
	if (!(ground[0] > 0) || !(ground[1] > 0)) {
		const char *said = source->replaced, *why = OSRIsGeographic(raster->srs) ? ": these are no degrees" : dem_gdal_because();
		char told[80];
		dem_srs_told(raster->srs, told, sizeof told);
		return fail_with(STATUS_INPUT, "%s: its middle at %.10g, %.10g is nowhere in %s%s; %s%s%sname the right one with --s-srs",
				 source->path, x, y, told, why, said[0] != '\0' ? "the file says " : "", said, said[0] != '\0' ? ": leave --s-srs out, or " : "");
	}
	double unit = OSRIsGeographic(raster->srs) ? 0 : OSRGetLinearUnits(raster->srs, NULL);
	bool fit = fabs(unit - 1) <= 1e-12 && fabs(ground[0] / step[0] - 1) <= SCALE_TOLERANCE &&
		   fabs(ground[1] / step[1] - 1) <= SCALE_TOLERANCE;
	for (int i = 0; i < 2 && !fit; i++)
		step[i] = ground[i];
	return STATUS_OK;
}

/* Returns true if `srs` is in metres that are true around (x, y). */
static bool is_true_at(OGRSpatialReferenceH srs, double x, double y, double step)
{
	return !OSRIsGeographic(srs) && fabs(OSRGetLinearUnits(srs, NULL) - 1) <= 1e-12 &&
	       fabs(dem_srs_ground(srs, x, y, step, 0) / step - 1) <= SCALE_TOLERANCE &&
	       fabs(dem_srs_ground(srs, x, y, 0, step) / step - 1) <= SCALE_TOLERANCE;
}

/* --- the SRS --- */

static enum status systems_agree(const struct dem_groups *groups)
{
	const struct gdal_source *first = groups->groups[0].sources[0];
	for (size_t i = 1; i < groups->count; i++) {
		const struct gdal_source *other = groups->groups[i].sources[0], *without = first->srs == NULL ? first : other;
		if ((first->srs == NULL) != (other->srs == NULL))
			return fail_with(STATUS_INPUT, "%s: says no SRS, and %s does; give it the one that it is in with gdal_translate "
					 "-a_srs, or name that of all with --s-srs", without->path,
					 (without == first ? other : first)->path);
	}
	return STATUS_OK;
}

static bool is_metric(OGRSpatialReferenceH srs)
{
	return !OSRIsGeographic(srs) && fabs(OSRGetLinearUnits(srs, NULL) - 1) <= 1e-12;
}

static bool is_automatic(const struct dem_params *params)
{
	return params->t_srs == NULL || strcmp(params->t_srs, "auto") == 0;
}

static enum status parse_target(const char *text, OGRSpatialReferenceH *out)
{
	*out = dem_srs_parse_given(text);
	if (*out == NULL)
		return STATUS_INPUT;
	if (!OSRIsProjected(*out) || !is_metric(*out))
		return fail_with(STATUS_INPUT, "target SRS \"%.80s\": is not in metres, and a store is; choose a metric projection "
				 "or auto", text);
	if (OSRIsCompound(*out))
		OSRStripVertical(*out);
	return STATUS_OK;
}

/*
 * Returns true if x is more than half a turn from the SRS's central meridian. A point in degrees converts to an x within half a turn,
 * so it would not be found in a store there.
 */
static bool lies_a_turn_away(OGRSpatialReferenceH srs, double x)
{
	double middle;
	const double turn = dem_srs_turn(srs, &middle);
	return turn > 0 && !OSRIsGeographic(srs) && fabs(x - middle) > turn / 2;
}

/* The same of a source's middle. */
static bool source_lies_a_turn_away(const struct gdal_source *source)
{
	return lies_a_turn_away(source->srs, source->place[0] + source->place[1] * source->width / 2);
}

bool dem_target_keepable(const struct dem_params *params, const struct dem_groups *groups)
{
	const struct dem_group *first = &groups->groups[0];
	const struct gdal_source *source = first->sources[0];
	return is_automatic(params) && first->projected && is_metric(source->srs) && !source_lies_a_turn_away(source);
}

static enum status keep_own(OGRSpatialReferenceH own, const char *name, OGRSpatialReferenceH *out)
{
	if (own != NULL && !is_metric(own))
		return fail_with(STATUS_INPUT, "%s: its SRS is in %s, and a store is in metres; leave --t-srs source out, or name a "
				 "metric SRS", name, OSRIsGeographic(own) ? "degrees" : "other units");
	*out = own != NULL ? OSRClone(own) : NULL;
	return own == NULL || *out != NULL ? STATUS_OK : fail_memory(name);
}

/* Chooses target->srs. It stays NULL if the sources are local metres. */
static enum status choose_srs(struct dem_target *target, const struct dem_params *params, const struct dem_groups *groups)
{
	const struct gdal_source *first = groups->groups[0].sources[0];
	if (target->srs != NULL)
		return STATUS_OK;
	bool chosen = is_automatic(params);
	if (!chosen && strcmp(params->t_srs, "source") == 0) {
		if (first->srs != NULL && source_lies_a_turn_away(first))
			note("%s: its x is beyond 180 degrees from the central meridian of its SRS, so points in degrees are not found in the store; leave "
			     "--t-srs source out", first->path);
		return keep_own(first->srs, first->path, &target->srs);
	}
	if (!chosen && first->srs == NULL)
		return fail_with(STATUS_INPUT, "%s: says no SRS to project from; name it with --s-srs", first->path);
	if (!chosen)
		return parse_target(params->t_srs, &target->srs);
	if (first->srs == NULL)
		return STATUS_OK;
	struct bounds bounds;
	TRY(bounds_of(groups, first->srs, &bounds));
	/* Without an SRS of its own the window is in the target's, which is not known yet. */
	if (params->has_window && params->window_srs != NULL)
		TRY(bounds_cut(&bounds, params, first->srs));
	double x = (bounds.low[0] + bounds.high[0]) / 2, y = (bounds.low[1] + bounds.high[1]) / 2;
	const bool fits = is_true_at(first->srs, x, y, fabs(first->place[1])) && !lies_a_turn_away(first->srs, x);
	target->srs = fits ? OSRClone(first->srs) : dem_srs_metric(first->srs, x, y);
	if (target->srs == NULL)
		return fail_with(STATUS_INPUT, "%s: found no metric projection for it%s; name one with --t-srs", first->path,
				 dem_gdal_because());
	OSRSetAxisMappingStrategy(target->srs, OAMS_TRADITIONAL_GIS_ORDER);
	return STATUS_OK;
}

/* --- the posts --- */

/* Returns the spacing that a group's posts have in the target, if they are kept, or would have by themselves. */
static double own_spacing(const struct dem_group *group, bool *square)
{
	const double *at = dem_layers_lattice(group->layers)->at;
	*square = at[2] == 0 && at[4] == 0 && at[1] > 0 && at[5] > 0 && fabs(group->step[0] / group->step[1] - 1) < SAME_SPACING &&
		  !group->projected;
	return *square ? at[1] : round_to_3_digits(sqrt(group->step[0] * group->step[1]));
}

static void measure_groups(struct dem_target *target, const struct dem_params *params, struct dem_groups *groups)
{
	target->spacing = params->spacing;
	for (size_t i = 0; i < groups->count; i++) {
		struct dem_group *group = &groups->groups[i];
		const struct dem_lattice *lattice = dem_layers_lattice(group->layers);
		bool square;
		group->projected = differ(lattice->srs, target->srs);
		/* `source` keeps the metres of its SRS, true or not. */
		if (!group->projected && target->keep)
			for (int axis = 0; axis < 2; axis++)
				group->step[axis] = hypot(lattice->at[1 + axis], lattice->at[4 + axis]);
		double own = own_spacing(group, &square);
		bool finer = params->spacing == 0 && (i == 0 || own < target->spacing);
		if (finer || (square && fabs(own / target->spacing - 1) <= SAME_SPACING))
			target->spacing = own;
	}
}

/* Chooses the posts: as many as lie within the area of the sources' posts. */
static enum status lay_out(struct dem_target *target, const struct dem_params *params, const struct dem_groups *groups)
{
	const char *name = groups->groups[0].sources[0]->path;
	struct bounds bounds;
	TRY(bounds_of(groups, target->srs, &bounds));
	struct bounds whole = bounds;
	if (!params->has_window && bounds.lost > 0)
		note("%s: %.2g %% of the area of its posts is nowhere in the target SRS, and is left out; import less at once, or choose a --t-srs that holds all of it", name,
		     100.0 * (double)bounds.lost / (double)bounds.probes);
	if (params->has_window)
		TRY(bounds_cut(&bounds, params, target->srs));
	double s = target->spacing, start[2] = {0, 0}, count[2];
	bool anchored = false, projected = false;
	for (int i = 0; i < 2 && params->anchor != NULL; i++) {
		start[i] = params->anchor[i];
		anchored = true;
	}
	for (size_t i = 0; i < groups->count && !anchored; i++) {
		const struct dem_group *group = &groups->groups[i];
		const double *at = dem_layers_lattice(group->layers)->at;
		bool square;
		anchored = fabs(own_spacing(group, &square) / s - 1) <= SAME_SPACING && square;
		projected = projected || group->projected;
		start[0] = anchored ? at[0] : whole.low[0];
		start[1] = anchored ? at[3] : whole.low[1];
	}
	if (projected && !anchored)
		start[0] = start[1] = 0;
	for (int i = 0; i < 2; i++) {
		target->origin[i] = start[i] + ceil((bounds.low[i] - start[i]) / s - 1e-6) * s;
		count[i] = floor((bounds.high[i] - target->origin[i]) / s + 1e-6) + 1;
		if (!(count[i] >= 2) || count[i] > 2e9)
			return fail_with(STATUS_INPUT, "%s: with posts every %g m it has %.0f post%s along a side, %s; choose another --spacing or --t-srs", name, s, fmax(count[i], 0),
					 count[i] == 1 ? "" : "s", count[i] < 2 ? "and a terrain needs at least 2 x 2" : "which are too many");
	}
	target->width = (int64_t)count[0];
	target->height = (int64_t)count[1];
	return STATUS_OK;
}

void dem_target_lattice(const struct dem_target *target, struct dem_lattice *lattice)
{
	*lattice = (struct dem_lattice){
		.at = {target->origin[0], target->spacing, 0, target->origin[1], 0, target->spacing},
		.width = target->width,
		.height = target->height,
		.srs = target->srs,
	};
}

enum status dem_target_measure(const struct dem_params *params, struct dem_groups *groups, struct dem_target *target)
{
	target->keep = params->t_srs != NULL && strcmp(params->t_srs, "source") == 0;
	TRY(systems_agree(groups));
	for (size_t i = 0; i < groups->count; i++)
		TRY(measure(dem_layers_lattice(groups->groups[i].layers), groups->groups[i].sources[0], groups->groups[i].step));
	TRY(choose_srs(target, params, groups));
	measure_groups(target, params, groups);
	return STATUS_OK;
}

enum status dem_target_choose(const struct dem_params *params, struct dem_groups *groups, struct dem_target *target)
{
	TRY(dem_target_measure(params, groups, target));
	return lay_out(target, params, groups);
}

double dem_target_own_spacing(const struct dem_group *group)
{
	bool square;
	return own_spacing(group, &square);
}

enum status dem_target_area(const struct dem_target *target, const struct dem_group *group, struct dem_area *area)
{
	struct bounds bounds = nowhere;
	enum status status = bounds_add_raster(&bounds, dem_layers_lattice(group->layers), target->srs, target->origin[0], group->sources[0]->path);
	memcpy(area->low, bounds.low, sizeof area->low);
	memcpy(area->high, bounds.high, sizeof area->high);
	return status;
}

void dem_target_finish(struct dem_target *target)
{
	if (target->srs != NULL)
		OSRDestroySpatialReference(target->srs);
	target->srs = NULL;
}

double dem_target_ground_off(const struct dem_target *target)
{
	double high[2];
	for (int i = 0; i < 2; i++)
		high[i] = target->origin[i] + (double)((i == 0 ? target->width : target->height) - 1) * target->spacing;
	return dem_srs_ground_off(target->srs, target->origin, high);
}
