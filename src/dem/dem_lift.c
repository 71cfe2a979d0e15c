/*
 * Converts heights between two vertical references: adds to each the difference that PROJ has at its place.
 *
 * Differences are smooth. So they are computed at the corners of square cells of posts, and are bilinear in a cell. The middle of
 * each cell is computed too. Where that is off, all posts of the cell are computed. Cells lie at whole multiples of their side, so a
 * height does not depend on the rectangle that is asked for.
 */
#include "dem_vertical.h"

#include <stdio.h>

#define P dem_proj_calls
#define SIDE 32        /* posts along a cell */
#define OFF_MOST 2e-4  /* metres: a cell whose middle is off by more is computed post by post */
#define AREA_PROBES 5  /* points along each side of the lattice, to find its area in degrees */

struct dem_lift {
	PJ_CONTEXT *context;
	PJ *operation;
	struct dem_lattice lattice; /* its SRS is not used */
	int64_t phase[2];           /* of column 0 and row 0 in their cells */
	double metres;              /* of the result's unit */
	char *name;
	double *nodes; /* of a row of cells: their south corners, north corners, and middles */
	size_t room;
};

void dem_lift_destroy(struct dem_lift *lift)
{
	if (lift == NULL)
		return;
	if (lift->context != NULL) {
		P.proj_destroy(lift->operation);
		P.proj_context_destroy(lift->context);
	}
	mem_free_all(lift->name, lift->nodes, lift);
}

/* --- the operation --- */

/* Returns an SRS with three axes; NULL: none can be made. */
static PJ *with_vertical(PJ_CONTEXT *context, OGRSpatialReferenceH flat, const struct dem_vertical *vertical)
{
	OGRSpatialReferenceH all = vertical->crs == NULL ? OSRClone(flat) : OSRNewSpatialReference(NULL), part = NULL;
	bool made = all != NULL;
	if (made && vertical->crs == NULL) {
		made = OSRPromoteTo3D(all, NULL) == OGRERR_NONE;
	} else if (made) {
		const char *wkt = P.proj_as_wkt(context, vertical->crs, PJ_WKT2_2019, NULL);
		part = wkt != NULL ? OSRNewSpatialReference(NULL) : NULL;
		made = part != NULL && OSRSetFromUserInput(part, wkt) == OGRERR_NONE && OSRSetCompoundCS(all, "heights", flat, part) == OGRERR_NONE;
	}
	char *wkt = made ? dem_srs_wkt(all) : NULL;
	PJ *crs = wkt != NULL ? P.proj_create(context, wkt) : NULL;
	mem_free(wkt);
	if (part != NULL)
		OSRDestroySpatialReference(part);
	if (all != NULL)
		OSRDestroySpatialReference(all);
	return crs;
}

/* Tells PROJ where the lattice lies, since what is best depends on it. */
static void set_area(const struct dem_lattice *lattice, PJ_CONTEXT *context, PJ_OPERATION_FACTORY_CONTEXT *factory)
{
	double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {-(double)INFINITY, -(double)INFINITY};
	OGRSpatialReferenceH degrees = OSRCloneGeogCS(lattice->srs);
	if (degrees != NULL)
		OSRSetAxisMappingStrategy(degrees, OAMS_TRADITIONAL_GIS_ORDER);
	OGRCoordinateTransformationH move = degrees != NULL ? OCTNewCoordinateTransformation(lattice->srs, degrees) : NULL;
	for (int i = 0; move != NULL && i < AREA_PROBES * AREA_PROBES; i++) {
		double at[2];
		dem_lattice_point(lattice, (double)(lattice->width - 1) * (i % AREA_PROBES) / (AREA_PROBES - 1),
				  (double)(lattice->height - 1) * (i / AREA_PROBES) / (AREA_PROBES - 1), &at[0], &at[1]);
		if (!OCTTransform(move, 1, &at[0], &at[1], NULL) || !isfinite(at[0]) || !isfinite(at[1]))
			continue;
		at[0] = remainder(at[0], 360);
		for (int axis = 0; axis < 2; axis++) {
			low[axis] = fmin(low[axis], at[axis]);
			high[axis] = fmax(high[axis], at[axis]);
		}
	}
	if (low[0] <= high[0] && high[0] - low[0] < 180)
		P.proj_operation_factory_context_set_area_of_interest(context, factory, low[0], low[1], high[0], high[1]);
	if (move != NULL)
		OCTDestroyCoordinateTransformation(move);
	if (degrees != NULL)
		OSRDestroySpatialReference(degrees);
}

/* Finds the first grid of an operation that is not there. Returns false if all are. */
static bool lacks(PJ_CONTEXT *context, const PJ *operation, char *grid, size_t room)
{
	const int count = P.proj_coordoperation_get_grid_used_count(context, operation);
	for (int i = 0; i < count; i++) {
		const char *name = NULL;
		int available = 0;
		if (P.proj_coordoperation_get_grid_used(context, operation, i, &name, NULL, NULL, NULL, NULL, NULL, &available) && !available) {
			snprintf(grid, room, "%s", name != NULL ? name : "");
			return true;
		}
	}
	return false;
}

static enum status refuse(PJ_CONTEXT *context, const struct dem_lift_params *params, const char *grid)
{
	const char *folder = P.proj_context_get_user_writable_directory(context, 0);
	if (grid[0] == '\0')
		return fail_with(STATUS_INPUT, "%s: PROJ knows no way from its vertical reference to %.60s; name another with --t-vertical", params->name,
				 params->to);
	return fail_with(STATUS_INPUT, "%s: to convert its heights to %.60s PROJ needs the grid %s, which is not there; put it into %s (projsync --file "
			 "%s), or leave --t-vertical out", params->name, params->to, grid, folder != NULL ? folder : "PROJ's data folder", grid);
}

/* Takes the first way all of whose grids are there. */
static enum status choose(struct dem_lift *lift, const struct dem_lift_params *params, const PJ *from, const PJ *to)
{
	PJ_CONTEXT *context = lift->context;
	PJ_OPERATION_FACTORY_CONTEXT *factory = P.proj_create_operation_factory_context(context, NULL);
	TRY_MEM(factory, params->name);
	P.proj_operation_factory_context_set_allow_ballpark_transformations(context, factory, 0); /* they leave heights as they are */
	P.proj_operation_factory_context_set_spatial_criterion(context, factory, PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
	P.proj_operation_factory_context_set_grid_availability_use(context, factory, PROJ_GRID_AVAILABILITY_IGNORED);
	set_area(params->lattice, context, factory);
	PJ_OBJ_LIST *ways = P.proj_create_operations(context, from, to, factory);
	const int count = ways != NULL ? P.proj_list_get_count(ways) : 0;
	char first[120] = "", grid[120];
	PJ *found = NULL;
	for (int i = 0; i < count && found == NULL; i++) {
		PJ *way = P.proj_list_get(context, ways, i);
		if (way != NULL && !lacks(context, way, grid, sizeof grid))
			found = P.proj_normalize_for_visualization(context, way);
		else if (first[0] == '\0')
			snprintf(first, sizeof first, "%s", grid);
		P.proj_destroy(way);
	}
	P.proj_list_destroy(ways);
	P.proj_operation_factory_context_destroy(factory);
	lift->operation = found;
	return found != NULL ? STATUS_OK : refuse(context, params, first);
}

static enum status find_operation(struct dem_lift *lift, const struct dem_lift_params *params)
{
	struct dem_vertical from, to;
	TRY(dem_vertical_init(lift->context, params->from, &from));
	enum status status = dem_vertical_init(lift->context, params->to, &to);
	if (status != STATUS_OK) {
		dem_vertical_finish(&from);
		return status;
	}
	PJ *before = with_vertical(lift->context, params->lattice->srs, &from), *after = with_vertical(lift->context, params->lattice->srs, &to);
	lift->metres = to.metres;
	status = before != NULL && after != NULL ? choose(lift, params, before, after) : refuse(lift->context, params, "");
	P.proj_destroy(before);
	P.proj_destroy(after);
	dem_vertical_finish(&from);
	dem_vertical_finish(&to);
	return status;
}

enum status dem_lift_create(const struct dem_lift_params *params, struct dem_lift **out)
{
	struct dem_lift *lift = mem_calloc(1, sizeof *lift);
	TRY_MEM(lift, params->name);
	const double *at = params->lattice->at;
	lift->lattice = *params->lattice;
	for (int i = 0; i < 2 && at[2] == 0 && at[4] == 0; i++) {
		/* The same cells for all rasters of one lattice. Posts often lie at halves of the spacing, so rounding is at quarters. */
		const double posts = floor(at[3 * i] / at[4 * i + 1] + 0.25);
		lift->phase[i] = fabs(posts) < 1e15 ? (((int64_t)posts % SIDE) + SIDE) % SIDE : 0;
	}
	lift->name = mem_strdup(params->name);
	lift->context = lift->name != NULL ? dem_vertical_context() : NULL;
	enum status status = lift->name == NULL	       ? fail_memory(params->name)
			     : lift->context == NULL ? STATUS_FAILED
						     : find_operation(lift, params);
	if (status != STATUS_OK) {
		dem_lift_destroy(lift);
		return status;
	}
	*out = lift;
	return STATUS_OK;
}

/* --- heights --- */

/* Returns the difference at a place of the lattice, metres; NaN: none is known. */
static double difference(const struct dem_lift *lift, double column, double row)
{
	PJ_COORD at = {{0, 0, 0, 0}};
	dem_lattice_point(&lift->lattice, column, row, &at.xyz.x, &at.xyz.y);
	at = P.proj_trans(lift->operation, PJ_FWD, at);
	return isfinite(at.xyz.z) ? at.xyz.z * lift->metres : (double)NAN;
}

static enum status add(const struct dem_lift *lift, int64_t column, int64_t row, double difference_here, bool single, double *height)
{
	if (isnan(*height))
		return STATUS_OK;
	if (isnan(difference_here)) {
		double x, y;
		dem_lattice_point(&lift->lattice, (double)column, (double)row, &x, &y);
		return fail_with(STATUS_INPUT, "%s: at %.10g, %.10g PROJ's grids do not say by how much heights differ; cut that part off with "
				 "--window, or leave --t-vertical out", lift->name, x, y);
	}
	*height = single ? (double)(float)(*height + difference_here) : *height + difference_here;
	return STATUS_OK;
}

/* The part of a row of cells that a rectangle has. Cells are counted from that of column 0 and row 0; `count` of them. */
struct cells {
	int64_t first, row, count;
	const double *south, *north, *middle;
};

static void fill_cells(struct dem_lift *lift, struct cells *cells)
{
	double *node = lift->nodes;
	const double west = (double)(cells->first * SIDE - lift->phase[0]), south = (double)(cells->row * SIDE - lift->phase[1]);
	cells->south = node;
	cells->north = node + cells->count + 1;
	cells->middle = cells->north + cells->count + 1;
	for (int line = 0; line < 2; line++)
		for (int64_t i = 0; i <= cells->count; i++)
			*node++ = difference(lift, west + (double)(i * SIDE), south + (double)(line * SIDE));
	for (int64_t i = 0; i < cells->count; i++)
		*node++ = difference(lift, west + ((double)i + 0.5) * SIDE, south + 0.5 * SIDE);
}

/* Converts the posts of `rect`, which lie in cell number i. */
static enum status run_cell(const struct dem_lift *lift, const struct cells *cells, int64_t i, struct post_rect rect, bool single, int64_t stride,
			    double *heights)
{
	const double corners[4] = {cells->south[i], cells->south[i + 1], cells->north[i], cells->north[i + 1]};
	const double middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
	const bool smooth = fabs(middle - cells->middle[i]) <= OFF_MOST; /* false for NaN */
	const int64_t x0 = (cells->first + i) * SIDE - lift->phase[0], y0 = cells->row * SIDE - lift->phase[1];
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += stride) {
		const double v = (double)(y - y0) / SIDE, west = corners[0] + (corners[2] - corners[0]) * v,
			     east = corners[1] + (corners[3] - corners[1]) * v;
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			const double here = smooth ? west + (east - west) * ((double)(x - x0) / SIDE)
						   : isnan(heights[x - rect.x0]) ? 0 : difference(lift, (double)x, (double)y);
			TRY(add(lift, x, y, here, single, &heights[x - rect.x0]));
		}
	}
	return STATUS_OK;
}

enum status dem_lift_run(struct dem_lift *lift, struct post_rect rect, bool single, double *heights)
{
	const int64_t first = (rect.x0 + lift->phase[0]) / SIDE, last = (rect.x1 - 1 + lift->phase[0]) / SIDE, width = rect.x1 - rect.x0;
	const size_t nodes = (size_t)(3 * (last - first + 1) + 2);
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (nodes > lift->room) {
		mem_free(lift->nodes);
		lift->nodes = mem_alloc(nodes, sizeof *lift->nodes);
		lift->room = lift->nodes != NULL ? nodes : 0;
		TRY_MEM(lift->nodes, lift->name);
	}
	for (int64_t row = (rect.y0 + lift->phase[1]) / SIDE; row <= (rect.y1 - 1 + lift->phase[1]) / SIDE; row++) {
		struct cells cells = {.first = first, .row = row, .count = last - first + 1};
		fill_cells(lift, &cells);
		for (int64_t i = 0; i < cells.count; i++) {
			const int64_t x = (first + i) * SIDE - lift->phase[0], y = row * SIDE - lift->phase[1];
			const struct post_rect part = post_rect_intersect(rect, (struct post_rect){x, y, x + SIDE, y + SIDE});
			TRY(run_cell(lift, &cells, i, part, single, width, heights + (part.y0 - rect.y0) * width + part.x0 - rect.x0));
		}
	}
	return STATUS_OK;
}
