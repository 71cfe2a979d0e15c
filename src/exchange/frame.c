/* Where a terrain lies: degrees of its points, on an ellipsoid. */
#include "exchange/internal.h"

#define RADIANS (M_PI / 180)
#define WGS84_RADIUS 6378137.0
#define WGS84_FLATTENING (1 / 298.257223563)
#define EDGE 64 /* points along an edge, of which the bounds are taken */

static double squared_eccentricity(const struct exchange_frame *frame)
{
	return frame->flattening * (2 - frame->flattening);
}

void exchange_frame_degree(const struct exchange_frame *frame, double latitude, double *east, double *north)
{
	/* Radii of curvature of an ellipsoid: N = a / w along the parallel's normal, M = a (1 - e2) / w^3 along the meridian. */
	double e2 = squared_eccentricity(frame), sine = sin(latitude * RADIANS), w = sqrt(1 - e2 * sine * sine);
	*east = RADIANS * frame->semi_major / w * cos(latitude * RADIANS);
	*north = RADIANS * frame->semi_major * (1 - e2) / (w * w * w);
}

void exchange_frame_earth_centred(const struct exchange_frame *frame, double longitude, double latitude, double height, double out[3])
{
	double e2 = squared_eccentricity(frame), sine = sin(latitude * RADIANS), cosine = cos(latitude * RADIANS);
	double radius = frame->semi_major / sqrt(1 - e2 * sine * sine);
	out[0] = (radius + height) * cosine * cos(longitude * RADIANS);
	out[1] = (radius + height) * cosine * sin(longitude * RADIANS);
	out[2] = (radius * (1 - e2) + height) * sine;
}

void exchange_frame_to_degrees(const struct exchange_frame *frame, size_t count, double *x, double *y)
{
	if (frame->globe != NULL) {
		for (size_t i = 0; i < count; i++) {
			x[i] += frame->meta->origin[0];
			y[i] += frame->meta->origin[1];
		}
		dem_globe_to_degrees(frame->globe, count, x, y);
		return;
	}
	double east, north;
	exchange_frame_degree(frame, 0, &east, &north);
	for (size_t i = 0; i < count; i++) {
		x[i] /= east;
		y[i] /= north;
	}
}

void exchange_frame_from_degrees(const struct exchange_frame *frame, size_t count, double *x, double *y)
{
	if (frame->globe != NULL) {
		dem_globe_from_degrees(frame->globe, count, x, y);
		for (size_t i = 0; i < count; i++) {
			x[i] -= frame->meta->origin[0];
			y[i] -= frame->meta->origin[1];
		}
		return;
	}
	double east, north;
	exchange_frame_degree(frame, 0, &east, &north);
	for (size_t i = 0; i < count; i++) {
		x[i] *= east;
		y[i] *= north;
	}
}

/* `ends`: the least positive and the greatest negative longitude. Where a pole is inside, they are near 0. */
static enum status fail_torn(const double ends[2], double south, double north)
{
	if (!(ends[0] > 90 && ends[1] < -90))
		return fail_with(STATUS_INPUT, "the store: a pole is in it or near it, where tiles would be torn apart; give a --window that leaves it out, or write a .tif");
	/* Outward, to a millionth of a degree. */
	const double low = floor((south - 1e-4) * 1e6) / 1e6, high = ceil((north + 1e-4) * 1e6) / 1e6;
	return fail_with(STATUS_INPUT, "the store: it crosses the antimeridian, where tiles would be torn apart; write two folders: --window-srs degrees --window "
			 "%.10g,%.10g,180,%.10g, and --window-srs degrees --window -180,%.10g,%.10g,%.10g", floor((ends[0] - 1e-4) * 1e6) / 1e6, low, high, low,
			 ceil((ends[1] + 1e-4) * 1e6) / 1e6, high);
}

struct bounding {
	double low[2], high[2]; /* degrees: of all points that the frame shows */
	double step[2];         /* the greatest difference of two neighbours */
	double ends[2];         /* the least positive and the greatest negative longitude */
	bool torn;              /* between two neighbours is more than a tenth of the way round: a pole or the antimeridian */
};

/* Takes a row of points. `before`: the row before, or NULL. */
static void bound_row(const struct exchange_frame *frame, struct bounding *bounding, const double (*row)[EDGE + 1], const double (*before)[EDGE + 1])
{
	for (int i = 0; i <= EDGE; i++) {
		const double at[2] = {row[0][i], row[1][i]};
		const bool clips = exchange_frame_clips(frame, at[0], at[1]);
		for (int k = 0; k < 2; k++) {
			const double step = fmax(i > 0 ? fabs(at[k] - row[k][i - 1]) : 0, before != NULL ? fabs(at[k] - before[k][i]) : 0);
			bounding->step[k] = step <= 36 ? fmax(bounding->step[k], step) : bounding->step[k];
			bounding->low[k] = clips ? bounding->low[k] : fmin(bounding->low[k], at[k]);
			bounding->high[k] = clips ? bounding->high[k] : fmax(bounding->high[k], at[k]);
		}
		bounding->torn = bounding->torn || isnan(at[0]) || (i > 0 && fabs(at[0] - row[0][i - 1]) > 36);
		bounding->ends[0] = at[0] > 0 ? fmin(bounding->ends[0], at[0]) : bounding->ends[0];
		bounding->ends[1] = at[0] < 0 ? fmax(bounding->ends[1], at[0]) : bounding->ends[1];
	}
}

/* The bounds of a grid of points; its lines are as curved as the terrain's edges. */
static enum status find_bounds(struct exchange_frame *frame)
{
	const double *metres = frame->metres;
	struct bounding bounding = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, {0, 0}, {180, -180}, false};
	double rows[2][2][EDGE + 1], *low = frame->bounds, *high = frame->bounds + 2;
	for (int row = 0; row <= EDGE; row++) {
		double(*to)[EDGE + 1] = rows[row % 2];
		for (int i = 0; i <= EDGE; i++) {
			to[0][i] = metres[0] + (metres[2] - metres[0]) * i / EDGE;
			to[1][i] = metres[1] + (metres[3] - metres[1]) * row / EDGE;
		}
		exchange_frame_to_degrees(frame, EDGE + 1, to[0], to[1]);
		bound_row(frame, &bounding, (const double(*)[EDGE + 1])to, row > 0 ? (const double(*)[EDGE + 1])rows[(row + 1) % 2] : NULL);
	}
	for (int i = 0; i < 2; i++) {
		/* What is clipped may reach further than the points of the grid do. Where the clip is between them, it is all of it. */
		const bool any = bounding.low[i] <= bounding.high[i];
		low[i] = !frame->clipped ? bounding.low[i] : fmax(any ? bounding.low[i] - bounding.step[i] : -INFINITY, frame->clip[i]);
		high[i] = !frame->clipped ? bounding.high[i] : fmin(any ? bounding.high[i] + bounding.step[i] : INFINITY, frame->clip[2 + i]);
	}
	if (!frame->clipped && (bounding.torn || high[0] - low[0] > 180))
		return fail_torn(bounding.ends, low[1], high[1]);
	for (int i = 0; i < 2; i++) {
		double more = 1e-4 * (high[i] - low[i]);
		low[i] = fmax(low[i] - more, i == 0 ? -180 : -90);
		high[i] = fmin(high[i] + more, i == 0 ? 180 : 90);
	}
	if (frame->globe != NULL && (low[1] > 85.05 || high[1] < -85.05))
		return fail_with(STATUS_INPUT, "the store: it lies beyond 85 degrees of latitude, where Web Mercator ends; write a .tif");
	return STATUS_OK;
}

/* What is exported, in metres: the window, as far as it lies in the terrain. */
static enum status take_window(struct exchange_frame *frame, const struct exchange_tiles_params *params)
{
	const struct extent *extent = &frame->meta->extent;
	for (int i = 0; i < 2; i++) {
		frame->metres[i] = 0;
		frame->metres[2 + i] = extent_side(extent, i);
		if (!params->has_window)
			continue;
		frame->metres[i] = fmax(params->window[i], 0);
		frame->metres[2 + i] = fmin(params->window[2 + i], frame->metres[2 + i]);
		if (!(frame->metres[i] < frame->metres[2 + i]))
			return fail_with(STATUS_INPUT, "export: --window: nothing of the terrain has a width and a height in it; give X0,Y0,X1,Y1 inside %s",
					 number_window(0, 0, extent_side(extent, 0), extent_side(extent, 1)).text);
	}
	return STATUS_OK;
}

enum status exchange_frame_init(struct exchange_frame *frame, const struct exchange_tiles_params *params)
{
	const struct store_meta *meta = store_meta(params->store);
	*frame = (struct exchange_frame){
		.meta = meta,
		.semi_major = WGS84_RADIUS,
		.flattening = WGS84_FLATTENING,
		.earth = true,
		.clipped = params->has_clip,
		.pixels = params->pixels > 0 ? (int)params->pixels : 256,
		.fine_globe = params->fine_globe,
	};
	for (int i = 0; i < 4; i++)
		frame->clip[i] = params->clip[i];
	TRY(take_window(frame, params));
	const struct extent *extent = &meta->extent;
	int64_t posts = (extent->width > extent->height ? extent->width : extent->height) - 1;
	frame->side = frame->pixels * extent->spacing;
	while (frame->side < (double)posts * extent->spacing)
		frame->side *= 2;
	if (meta->srs[0] != '\0')
		TRY(dem_globe_create(meta->srs, &frame->globe));
	if (frame->globe != NULL) {
		const struct dem_globe_info *info = dem_globe_info(frame->globe);
		frame->semi_major = info->semi_major;
		frame->flattening = info->flattening;
		frame->earth = info->earth;
	}
	enum status status = find_bounds(frame);
	if (status != STATUS_OK)
		exchange_frame_finish(frame);
	return status;
}

void exchange_frame_finish(struct exchange_frame *frame)
{
	dem_globe_destroy(frame->globe);
	frame->globe = NULL;
}
