/*
 * The truth of the model sheet: the same obstacle problem in doubles, taken to rest. Its ruts follow from what SOIL.md says, "The elastic sheet".
 */
#include <math.h>

#include "accuracy.h"
#include "bench.h"

#define STILL 1e-9   /* m: rounds end where no deflection changes by more */
#define ROUNDS 4000

/* Solves T lap(w) = k w over a window, at least as deep as `least`. w: 0 beyond the window, which has one post more on each side. */
static void solve(double *w, const double *least, int64_t width, int64_t height)
{
	const double length = sqrt(ACCURACY_TENSION / ACCURACY_STIFFNESS), spring = ACCURACY_FINE * ACCURACY_FINE / (length * length);
	const double jacobi = 4 / (4 + spring), over = 2 / (1 + sqrt(1 - jacobi * jacobi));
	double most = 1;
	for (int round = 0; most > STILL; round++) {
		if (round == ROUNDS)
			bench_must(fail_with(STATUS_FAILED, "bench: the truth of the sheet does not come to rest; give more rounds"));
		most = 0;
		for (int64_t y = 1; y < height - 1; y++)
			for (int64_t x = 1; x < width - 1; x++) {
				const int64_t at = y * width + x;
				const double given = (w[at - 1] + w[at + 1] + w[at - width] + w[at + width]) / (4 + spring);
				const double next = fmax(least[at], w[at] + over * (given - w[at]));
				most = fmax(most, fabs(next - w[at]));
				w[at] = next;
			}
	}
}

void accuracy_sheet(double *surface, const double *base, const struct accuracy_press *press, bool last)
{
	const int64_t reach = (int64_t)ceil(8 * sqrt(ACCURACY_TENSION / ACCURACY_STIFFNESS) / ACCURACY_FINE);
	const struct post_rect window = post_rect_intersect(post_rect_grown(press->rect, reach), accuracy_field);
	const int64_t width = window.x1 - window.x0, height = window.y1 - window.y0, columns = accuracy_field.x1 - accuracy_field.x0;
	double *w = mem_calloc((size_t)(width * height), sizeof *w), *least = mem_calloc((size_t)(width * height), sizeof *least);
	if (w == NULL || least == NULL)
		bench_must(fail_memory("bench"));
	for (int64_t y = press->rect.y0; y < press->rect.y1; y++)
		for (int64_t x = press->rect.x0; x < press->rect.x1; x++) {
			const double envelope = press->heights[(y - press->rect.y0) * (press->rect.x1 - press->rect.x0) + x - press->rect.x0];
			const double own = surface[(y - accuracy_field.y0) * columns + x - accuracy_field.x0];
			least[(y - window.y0) * width + x - window.x0] = isfinite(envelope) ? fmax(own - envelope, 0) : 0;
		}
	if (last)
		solve(w, least, width, height);
	for (int64_t y = window.y0; y < window.y1; y++)
		for (int64_t x = window.x0; x < window.x1; x++) {
			const int64_t at = (y - window.y0) * width + x - window.x0, in = (y - accuracy_field.y0) * columns + x - accuracy_field.x0;
			const double rut = base[in] - surface[in];
			if (last)
				surface[in] -= w[at];
			else if (least[at] > ACCURACY_YIELD)
				surface[in] = base[in] - (rut + least[at] - ACCURACY_YIELD);
		}
	mem_free(w);
	mem_free(least);
}
