/*
 * Positions of samples.
 *
 * Sample (i, j) of a zoom level has a position that depends on i, j and the level alone, not on a tile. Positions at multiples of
 * `control` are exact, the others are bilinear between them. So tiles that share samples have the same positions there, bit for
 * bit.
 */
#include "exchange/internal.h"

static double mercator_latitude(double share)
{
	return atan(sinh(M_PI * (1 - 2 * share))) * 180 / M_PI;
}

static double samples_around(const struct exchange_frame *frame, const struct exchange_zoom *zoom)
{
	return ldexp(zoom->globe ? 2 * EXCHANGE_CELLS : frame->pixels, zoom->z);
}

void exchange_place_degrees(const struct exchange_frame *frame, const struct exchange_zoom *zoom, double i, double j, double *x, double *y)
{
	double around = samples_around(frame, zoom);
	if (zoom->globe) {
		*x = i * (360 / around) - 180;
		*y = j * (360 / around) - 90;
	} else if (frame->globe != NULL) {
		*x = (i + 0.5) * (360 / around) - 180;
		*y = mercator_latitude((j + 0.5) / around);
	} else {
		*x = (i + 0.5) * (frame->side / around);
		*y = frame->side - (j + 0.5) * (frame->side / around);
	}
}

void exchange_place_steps(const struct exchange_frame *frame, const struct exchange_zoom *zoom, double j, double *east, double *north)
{
	double around = samples_around(frame, zoom), x, y;
	if (!zoom->globe && frame->globe == NULL) {
		*east = *north = frame->side / around;
		return;
	}
	exchange_place_degrees(frame, zoom, 0, j, &x, &y);
	exchange_frame_degree(frame, y, east, north);
	*east *= 360 / around;
	if (zoom->globe)
		*north *= 360 / around;
	else
		*north *= 360 / around * cos(y * M_PI / 180); /* Web Mercator stretches both ways alike */
}

void exchange_place_exact(const struct exchange_frame *frame, const struct exchange_zoom *zoom, size_t count, const double *i,
			  const double *j, double *x, double *y)
{
	for (size_t k = 0; k < count; k++)
		exchange_place_degrees(frame, zoom, i[k], j[k], &x[k], &y[k]);
	if (!zoom->globe && frame->globe == NULL)
		return;
	/* Far from the terrain some projections return points that lie inside it. Where all positions are exact, leave those out. */
	const double *bounds = frame->bounds;
	for (size_t k = 0; k < count; k++)
		if (fabs(y[k]) > 90 || (zoom->control == 1 && !(x[k] >= bounds[0] && x[k] <= bounds[2] && y[k] >= bounds[1] && y[k] <= bounds[3])))
			x[k] = y[k] = (double)NAN;
	exchange_frame_from_degrees(frame, count, x, y);
}

/* Metres by which the middle of a cell of control points is off, at samples (i, j) to (i + step, j + step). */
static double middle_error(const struct exchange_frame *frame, const struct exchange_zoom *zoom, double i, double j, double step)
{
	const double at_i[] = {i, i + step, i, i + step, i + step / 2, i + step / 2, i}, at_j[] = {j, j, j + step, j + step, j + step / 2, j, j + step / 2};
	double x[7], y[7];
	exchange_place_exact(frame, zoom, 7, at_i, at_j, x, y);
	double error = hypot((x[0] + x[1] + x[2] + x[3]) / 4 - x[4], (y[0] + y[1] + y[2] + y[3]) / 4 - y[4]);
	error = fmax(error, hypot((x[0] + x[1]) / 2 - x[5], (y[0] + y[1]) / 2 - y[5]));
	error = fmax(error, hypot((x[0] + x[2]) / 2 - x[6], (y[0] + y[2]) / 2 - y[6]));
	return isnan(error + x[0] + x[1] + x[2] + x[3] + x[4]) ? INFINITY : error;
}

int exchange_place_control(const struct exchange_frame *frame, const struct exchange_zoom *zoom)
{
	int64_t samples = zoom->globe ? EXCHANGE_CELLS : frame->pixels;
	double i[] = {(double)(zoom->x0 * samples), (double)(zoom->x0 + zoom->x1) * (double)samples / 2, (double)(zoom->x1 * samples)};
	double j[] = {(double)(zoom->y0 * samples), (double)(zoom->y0 + zoom->y1) * (double)samples / 2, (double)(zoom->y1 * samples)};
	for (int control = 64; control > 1; control /= 2) {
		double worst = 0;
		for (int k = 0; k < 9; k++)
			worst = fmax(worst, middle_error(frame, zoom, fmax(i[k % 3] - (k % 3) * 0.5 * control, 0), fmax(j[k / 3] - (k / 3) * 0.5 * control, 0), control));
		if (worst <= zoom->step / 32)
			return control;
	}
	return 1;
}
