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

/* The bounds of a grid of points; its lines are as curved as the terrain's edges. */
static enum status find_bounds(struct exchange_frame *frame)
{
	const struct extent *extent = &frame->meta->extent;
	double width = (double)(extent->width - 1) * extent->spacing, height = (double)(extent->height - 1) * extent->spacing;
	double *low = frame->bounds, *high = frame->bounds + 2;
	low[0] = low[1] = INFINITY;
	high[0] = high[1] = -INFINITY;
	for (int row = 0; row <= EDGE; row++) {
		double x[EDGE + 1], y[EDGE + 1];
		for (int i = 0; i <= EDGE; i++) {
			x[i] = width * i / EDGE;
			y[i] = height * row / EDGE;
		}
		exchange_frame_to_degrees(frame, EDGE + 1, x, y);
		for (int i = 0; i <= EDGE; i++) {
			/* Between two points, not more than a tenth of the way round: else the line crosses the antimeridian or a pole. */
			if (isnan(x[i]) || (i > 0 && fabs(x[i] - x[i - 1]) > 36))
				return fail_with(STATUS_INPUT, "the store: it crosses the antimeridian or a pole, where tiles would be torn apart; "
						 "import a part of it that does not, with furrow import --window");
			low[0] = fmin(low[0], x[i]);
			high[0] = fmax(high[0], x[i]);
			low[1] = fmin(low[1], y[i]);
			high[1] = fmax(high[1], y[i]);
		}
	}
	if (high[0] - low[0] > 180)
		return fail_with(STATUS_INPUT, "the store: it crosses the antimeridian or a pole, where tiles would be torn apart; import a part "
				 "of it that does not, with furrow import --window");
	for (int i = 0; i < 2; i++) {
		double more = 1e-4 * (high[i] - low[i]);
		low[i] -= more;
		high[i] += more;
	}
	if (frame->globe != NULL && (low[1] > 85.05 || high[1] < -85.05))
		return fail_with(STATUS_INPUT, "the store: it lies beyond 85 degrees of latitude, where Web Mercator ends; write a .tif");
	return STATUS_OK;
}

enum status exchange_frame_init(struct exchange_frame *frame, const struct store_meta *meta)
{
	*frame = (struct exchange_frame){
		.meta = meta,
		.semi_major = WGS84_RADIUS,
		.flattening = WGS84_FLATTENING,
		.earth = true,
	};
	const struct extent *extent = &meta->extent;
	int64_t posts = (extent->width > extent->height ? extent->width : extent->height) - 1;
	frame->side = EXCHANGE_PIXELS * extent->spacing;
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
