/* furrow.h: soil that is brought and taken between two steps. */
#include "api/library.h"

#include <math.h>

#define UNITS 0x1p20 /* of a metre */

/* A rectangle of posts with an amount for each. */
struct poured {
	struct world_pour pour;
	int32_t *amounts;
};

static enum status run(struct furrow_world *world, struct poured *poured, int32_t soil, bool loose)
{
	poured->pour.amounts = poured->amounts;
	poured->pour.soil = soil;
	poured->pour.loose = loose;
	return world_pour(world->world, &poured->pour);
}

/* Sets the rectangle, and makes its amounts, which are 0. STATUS_INPUT: it is not all on the terrain. */
static enum status make(const struct furrow_world *world, struct post_rect rect, struct poured *poured)
{
	TRY(world_pour_rect(world->world, rect));
	poured->pour.rect = rect;
	poured->amounts = mem_calloc((size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0), sizeof *poured->amounts);
	return poured->amounts != NULL ? STATUS_OK : fail_memory("posts");
}

static enum status need(struct furrow_world *world, const void *numbers, const char *name, int32_t soil)
{
	TRY(api_library_need_writable(world, "pour"));
	TRY(api_library_need(numbers, name));
	if (soil < -1)
		return fail_with(STATUS_USAGE, "soil: %d is none; give the index of one of the scene's soils, or -1: the soil of each post", (int)soil);
	return STATUS_OK;
}

/* --- heights of posts --- */

static enum status amount_of(double height, size_t column, size_t row, int32_t *amount)
{
	if (!isfinite(height))
		return fail_with(STATUS_USAGE, "heights: that of column %zu, row %zu is %g; give finite numbers, m, and 0 where nothing is to change", column, row,
				 height);
	if (!(fabs(height) * UNITS < INT32_MAX))
		return fail_with(STATUS_INPUT, "heights: that of column %zu, row %zu is %g m, and a post takes less than 2048 m at once; give less", column, row, height);
	*amount = (int32_t)lround(height * UNITS);
	return STATUS_OK;
}

static enum status pour_heights(struct furrow_world *world, int64_t column, int64_t row, uint32_t columns, uint32_t rows, const double *heights,
				size_t row_stride, int32_t soil, bool loose)
{
	struct poured poured = {.amounts = NULL};
	TRY(need(world, heights, "heights", soil));
	if (columns == 0 || rows == 0)
		return STATUS_OK;
	if (row_stride < columns)
		return fail_with(STATUS_USAGE, "row_stride: %zu posts are less than the %u of a row; give at least as many", row_stride, columns);
	if (row_stride > PTRDIFF_MAX / sizeof *heights / rows)
		return fail_with(STATUS_USAGE, "row_stride: %zu posts in each of %u rows are more than memory has; give those of your array", row_stride, rows);
	const int64_t far = INT64_MAX / 2;
	struct post_rect rect = {-1, -1, 0, 0}; /* beyond any terrain */
	if (column > -far && column < far && row > -far && row < far)
		rect = (struct post_rect){column, row, column + columns, row + rows};
	enum status status;
	TRY_OR(done, make(world, rect, &poured));
	for (size_t r = 0; r < rows; r++)
		for (size_t c = 0; c < columns; c++)
			TRY_OR(done, amount_of(heights[r * row_stride + c], c, r, &poured.amounts[r * columns + c]));
	TRY_OR(done, run(world, &poured, soil, loose));
done:
	mem_free(poured.amounts);
	return status;
}

furrow_status furrow_pour(struct furrow_world *world, int64_t column, int64_t row, uint32_t columns, uint32_t rows, const double *heights,
			  size_t row_stride, int32_t soil, bool loose)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, pour_heights(world, column, row, columns, rows, heights, row_stride, soil, loose));
done:
	return api_library_leave(&call, status);
}

/* --- a volume over a polygon --- */

static enum status pour_polygon(struct furrow_world *world, size_t count, const double *xy, double volume, int32_t soil, bool loose)
{
	struct poured poured = {.amounts = NULL};
	TRY(need(world, xy, "xy", soil));
	TRY(api_library_need_count(count, 2 * sizeof *xy));
	TRY(world_pour_polygon(world->world, count, xy, volume, &poured.pour.rect, &poured.amounts));
	const enum status status = run(world, &poured, soil, loose);
	mem_free(poured.amounts);
	return status;
}

furrow_status furrow_pour_polygon(struct furrow_world *world, size_t count, const double *xy, double volume, int32_t soil, bool loose)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, pour_polygon(world, count, xy, volume, soil, loose));
done:
	return api_library_leave(&call, status);
}
