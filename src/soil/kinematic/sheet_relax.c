/*
 * Solves for an elastic sheet's deflection, by projected successive over-relaxation in two colours (Cryer 1971). A post takes the value that its
 * four neighbours give it, and goes on by the over-relaxation. It stays at least as deep as the body holds it. Posts of one colour have neighbours of the other
 * alone. So the order within a colour does not show.
 */
#include <math.h>
#include <string.h>

#include "soil/kinematic/rows.h"
#include "soil/kinematic/sheet_grid.h"

#define REACH 6.0         /* lengths. There K0 is 0.1 % of what it is at a tenth of a length */
#define ROUNDS 5.0        /* for each post of the length. Over-relaxation takes the error down by e^-1.4 each */
#define ROUNDS_LEAST 12
#define DEFLECTION_MOST ((SOIL_SHEET_MOST << SHEET_BITS) - 1)

int64_t soil_sheet_reach(double length, double spacing)
{
	return (int64_t)ceil(REACH * fmin(length / spacing, SOIL_SHEET_POSTS)) + 1;
}

void soil_sheet_prepare(struct soil_sheet *sheet, double length, double yield, double share, double spacing)
{
	const double posts = fmin(length / spacing, SOIL_SHEET_POSTS), spring = fmin(1 / (posts * posts), 0x1p20), jacobi = 4 / (4 + spring);
	const double relaxation = 2 / (1 + sqrt(1 - jacobi * jacobi));
	*sheet = (struct soil_sheet){
		.over = (uint32_t)floor(ldexp(relaxation - 1, 31)),
		.rounds = (int)ceil(ROUNDS * posts) + ROUNDS_LEAST,
		.reach = (int32_t)soil_sheet_reach(length, spacing),
		.yield = (int32_t)fmin(ldexp(yield, OFFSET_BITS), SOIL_SHEET_MOST),
		.share = (uint32_t)floor(ldexp(share, 31)),
	};
	int exponent;
	sheet->spring = (uint32_t)floor(ldexp(frexp(spring, &exponent), 31));
	sheet->spring_bits = 31 - exponent;
	for (int count = 0; count < 5; count++)
		sheet->relax[count] = (uint32_t)fmax(1, fmin(floor(ldexp(relaxation / (count + spring), 31)), UINT32_MAX));
}

/* --- which posts move --- */

/* Marks posts of a row that are at most `reach` beside a held one. */
static void mark_beside(const struct sheet_grid *grid, uint8_t *marks, int32_t reach)
{
	int32_t left = 0;
	for (int32_t x = 0; x < grid->width; x++) {
		left = marks[x] & (SHEET_OWN | SHEET_OTHER) ? reach + 1 : left - (left > 0);
		marks[x] = (uint8_t)((marks[x] & ~(SHEET_BESIDE | SHEET_NEAR)) | (left > 0 ? SHEET_BESIDE : 0));
	}
	left = 0;
	for (int32_t x = grid->width - 1; x >= 0; x--) {
		left = marks[x] & (SHEET_OWN | SHEET_OTHER) ? reach + 1 : left - (left > 0);
		marks[x] = (uint8_t)(marks[x] | (left > 0 ? SHEET_BESIDE : 0));
	}
}

/* Marks posts that are at most `reach` above or below a row, by what is marked there. left: of each column, how far it still reaches. */
static void mark_near(const struct sheet_grid *grid, uint8_t *marks, int32_t reach, int32_t *left)
{
	for (int32_t x = 0; x < grid->width; x++) {
		left[x] = marks[x] & SHEET_BESIDE ? reach + 1 : left[x] - (left[x] > 0);
		marks[x] = (uint8_t)(marks[x] | (left[x] > 0 ? SHEET_NEAR : 0));
	}
}

static uint8_t *marks_of(const struct sheet_grid *grid, int32_t y)
{
	return grid->marks + (ptrdiff_t)y * (ptrdiff_t)grid->stride;
}

static void mark(const struct sheet_grid *grid, int32_t reach)
{
	memset(grid->row, 0, (size_t)grid->width * sizeof *grid->row);
	for (int32_t y = 0; y < grid->height; y++) {
		mark_beside(grid, marks_of(grid, y), reach);
		mark_near(grid, marks_of(grid, y), reach, grid->row);
	}
	memset(grid->row, 0, (size_t)grid->width * sizeof *grid->row);
	for (int32_t y = grid->height - 1; y >= 0; y--)
		mark_near(grid, marks_of(grid, y), reach, grid->row);
}

void soil_sheet_begin(struct sheet_grid *grid, const struct soil_sheet *sheet)
{
	mark(grid, sheet->reach);
	grid->x[0] = grid->y[0] = INT32_MAX;
	grid->x[1] = grid->y[1] = 0;
	for (int32_t y = 0; y < grid->height; y++) {
		const size_t at = (size_t)y * grid->stride;
		const uint8_t *own = grid->marks + at, *below = own - grid->stride, *above = own + grid->stride;
		for (int32_t x = 0; x < grid->width; x++) {
			const bool may = (own[x] & (SHEET_GROUND | SHEET_INSIDE | SHEET_OTHER)) == (SHEET_GROUND | SHEET_INSIDE), moves = may && (own[x] & SHEET_NEAR);
			const int around = (own[x - 1] & 1) + (own[x + 1] & 1) + (below[x] & 1) + (above[x] & 1); /* SHEET_GROUND is 1 */
			grid->relax[at + (size_t)x] = moves ? sheet->relax[around] : 0;
			if (may && !moves)
				grid->deflection[at + (size_t)x] = 0;
			if (!moves)
				continue;
			grid->x[0] = lane_least(grid->x[0], x);
			grid->x[1] = lane_most(grid->x[1], x + 1);
			grid->y[0] = lane_least(grid->y[0], y);
			grid->y[1] = y + 1;
		}
	}
}

int64_t soil_sheet_force(const struct sheet_grid *grid, const struct soil_sheet *sheet, int64_t *posts)
{
	int64_t force = 0;
	*posts = 0;
	for (int32_t y = grid->y[0]; y < grid->y[1]; y++)
		for (int32_t x = grid->x[0]; x < grid->x[1]; x++) {
			const size_t at = (size_t)y * grid->stride + (size_t)x;
			const uint8_t *marks = grid->marks + at;
			const int32_t *own = grid->deflection + at;
			if (!(*marks & SHEET_OWN))
				continue;
			const int around = (marks[-1] & 1) + (marks[1] & 1) + (marks[-(ptrdiff_t)grid->stride] & 1) + (marks[grid->stride] & 1);
			const int64_t sum = (int64_t)own[-1] + own[1] + own[-(ptrdiff_t)grid->stride] + own[grid->stride];
			force += (int64_t)((uint64_t)sheet->spring * (uint32_t)*own >> sheet->spring_bits) + (int64_t)around * *own - sum;
			++*posts;
		}
	return force;
}

/* --- how far they move --- */

/* Moves every second post of a row. parity: 0: the first one moves. */
static SOIL_LANES void relax_row(int32_t count, const int32_t *restrict own, const int32_t *restrict below, const int32_t *restrict above,
				 const int32_t *restrict least, const uint32_t *restrict relax, int64_t over, int32_t parity, int32_t *restrict to)
{
	for (int32_t i = 0; i < count; i++) {
		const uint32_t sum = (uint32_t)own[i - 1] + (uint32_t)own[i + 1] + (uint32_t)below[i] + (uint32_t)above[i];
		const int64_t given = (int64_t)((uint64_t)relax[i] * sum) - over * own[i] + (1 << 30);
		const int64_t wanted = given >> 31;
		const int32_t bounded = (int32_t)(wanted < DEFLECTION_MOST ? wanted : DEFLECTION_MOST), deep = bounded > least[i] ? bounded : least[i];
		to[i] = (relax[i] != 0) & (((i + parity) & 1) == 0) ? deep : own[i];
	}
}

void soil_sheet_relax(const struct sheet_grid *grid, const struct soil_sheet *sheet)
{
	for (int half = 0; half < 2 * sheet->rounds; half++)
		for (int32_t y = grid->y[0]; y < grid->y[1]; y++) {
			const size_t at = (size_t)y * grid->stride + (size_t)grid->x[0];
			int32_t *own = grid->deflection + at;
			const int32_t count = grid->x[1] - grid->x[0];
			relax_row(count, own, own - grid->stride, own + grid->stride, grid->least + at, grid->relax + at, sheet->over,
				  (int32_t)((grid->x0 + grid->x[0] + grid->y0 + y + half) & 1), grid->row);
			memcpy(own, grid->row, (size_t)count * sizeof *own);
		}
}
