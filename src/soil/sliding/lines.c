/*
 * Sliding along the lines of a window, in one direction (SOIL.md, "Along lines"). A line is at rest when it was walked there and back (pools.c).
 *
 * All posts are first compared with the least difference that slides, row by row. Then only those parts of lines are walked in which some
 * soil may slide.
 *
 * Diagonal lines go on at the other side of the window. Line i begins at the west in row i, and has one post in each column. Where it is cut
 * no soil goes over. Its pieces share a limit (pools.c), as on the GPU.
 */
#include "soil/sliding/sliding.h"

/* --- the lines of a direction --- */

SOIL_INLINED int32_t least_of(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

SOIL_INLINED int32_t most_of(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

/* Where pairs of posts may slide there and back, of lines side by side. */
struct ends {
	int32_t *falls_first, *falls_last, *rises_first, *rises_last;
};

/* Compares a row of posts with the next post of each one's line. at: the number of the row. */
SOIL_LANES static void look_row(const int32_t *heights, const int32_t *next, size_t count, int32_t least, int32_t at, const struct ends *ends)
{
	int32_t *falls_first = ends->falls_first, *falls_last = ends->falls_last, *rises_first = ends->rises_first, *rises_last = ends->rises_last;
	SOIL_APART
	for (size_t x = 0; x < count; x++) {
		bool falls = sliding_may(heights[x], next[x], least), rises = sliding_may(next[x], heights[x], least);
		falls_first[x] = least_of(falls_first[x], falls ? at : INT32_MAX);
		falls_last[x] = most_of(falls_last[x], falls ? at : -1);
		rises_first[x] = least_of(rises_first[x], rises ? at : INT32_MAX);
		rises_last[x] = most_of(rises_last[x], rises ? at : -1);
	}
}

/* Returns whether any pair of a row may slide along it. */
SOIL_LANES static bool any_along(const int32_t *heights, size_t pairs, int32_t least)
{
	uint32_t any = 0;
	SOIL_APART
	for (size_t x = 0; x < pairs; x++)
		any |= (uint32_t)sliding_may(heights[x], heights[x + 1], least) | (uint32_t)sliding_may(heights[x + 1], heights[x], least);
	return any != 0;
}

/* Finds where pairs of a row fall and rise along it. */
static void look_along(const int32_t *heights, int32_t pairs, int32_t least, struct sliding_reach *falls, struct sliding_reach *rises)
{
	*falls = *rises = (struct sliding_reach){INT32_MAX, -1};
	for (int32_t x = 0; x < pairs; x++) {
		if (sliding_may(heights[x], heights[x + 1], least))
			*falls = (struct sliding_reach){least_of(falls->first, x), x};
		if (sliding_may(heights[x + 1], heights[x], least))
			*rises = (struct sliding_reach){least_of(rises->first, x), x};
	}
}

static struct sliding_reach around(struct sliding_reach a, struct sliding_reach b)
{
	return (struct sliding_reach){least_of(a.first, b.first), most_of(a.last, b.last)};
}

/* Returns where pairs may fall on the way back: `rises` of pairs on the way there, by the post that they begin with. */
static struct sliding_reach back_of(struct sliding_reach rises, int count)
{
	return (struct sliding_reach){most_of(count - 2 - rises.last, 0), least_of(count - 2 - rises.first, count - 2)};
}

/* A piece with `count` posts from (x, y) on. Directions go by (+1, 0), (0, +1), (+1, +1), (+1, -1). */
static struct sliding_line line_at(const struct sliding_field *field, int direction, size_t x, size_t y, int count, bool back)
{
	static const int ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
	const ptrdiff_t step = ways[direction][0] + ways[direction][1] * (ptrdiff_t)field->stride;
	const ptrdiff_t at = (ptrdiff_t)(y * field->stride + x) + (back ? (count - 1) * step : 0);
	const int diagonal = direction > 1;
	return (struct sliding_line){
		.heights = field->heights + at,
		.floors = field->floors != NULL ? field->floors + at : NULL,
		.critical = field->critical[0] != NULL ? field->critical[diagonal] + at : NULL,
		.grounds = field->grounds != NULL ? field->grounds + at : NULL,
		.step = back ? -step : step,
		.limit = field->limits[diagonal],
		.tolerance = field->rule->tolerance,
		.least = field->rule->least[diagonal],
		.count = count,
	};
}

/* Walks there. Returns where pairs may rise then. */
static struct sliding_reach walk_there(const struct sliding_field *field, int direction, size_t x, size_t y, int count, struct sliding_reach falls, struct sliding_reach rises,
			       int *pops)
{
	const struct sliding_line line = line_at(field, direction, x, y, count, false);
	return falls.first <= falls.last ? around(rises, soil_sliding_walk(&line, falls, pops)) : rises;
}

static void walk_back(const struct sliding_field *field, int direction, size_t x, size_t y, int count, struct sliding_reach rises, int *pops)
{
	const struct sliding_line line = line_at(field, direction, x, y, count, true);
	if (rises.first <= rises.last)
		soil_sliding_walk(&line, back_of(rises, count), pops);
}

static void along_rows(const struct sliding_field *field)
{
	const int count = (int)field->width;
	for (size_t y = 0; y < field->height; y++) {
		struct sliding_reach falls, rises;
		int pops = 0, pops_back = 0;
		if (!any_along(field->heights + y * field->stride, field->width - 1, field->rule->least[0]))
			continue;
		look_along(field->heights + y * field->stride, count - 1, field->rule->least[0], &falls, &rises);
		rises = walk_there(field, 0, 0, y, count, falls, rises, &pops);
		walk_back(field, 0, 0, y, count, rises, &pops_back);
	}
}

static struct ends ends_of(const struct sliding_field *field)
{
	const size_t count = field->width + field->height;
	const struct ends ends = {field->ends, field->ends + count, field->ends + 2 * count, field->ends + 3 * count};
	for (size_t i = 0; i < count; i++) {
		ends.falls_first[i] = ends.rises_first[i] = INT32_MAX;
		ends.falls_last[i] = ends.rises_last[i] = -1;
	}
	return ends;
}

static struct ends from(struct ends ends, size_t line)
{
	return (struct ends){ends.falls_first + line, ends.falls_last + line, ends.rises_first + line, ends.rises_last + line};
}

static void along_columns(const struct sliding_field *field)
{
	const struct ends ends = ends_of(field);
	const int count = (int)field->height;
	for (size_t y = 0; y + 1 < field->height; y++)
		look_row(field->heights + y * field->stride, field->heights + (y + 1) * field->stride, field->width, field->rule->least[0], (int32_t)y, &ends);
	for (size_t x = 0; x < field->width; x++) {
		int pops = 0, pops_back = 0;
		struct sliding_reach falls = {ends.falls_first[x], ends.falls_last[x]}, rises = {ends.rises_first[x], ends.rises_last[x]};
		rises = walk_there(field, 1, x, 0, count, falls, rises, &pops);
		walk_back(field, 1, x, 0, count, rises, &pops_back);
	}
}

/* A piece of a diagonal line. */
struct piece {
	size_t x, y;
	int count;
	size_t number; /* in `ends`; posts of one row have rising numbers */
};

/* Returns the piece of line `line` that begins in column x; of a line to the south-east if `down`. */
static struct piece piece_at(const struct sliding_field *field, size_t line, size_t x, bool down)
{
	size_t height = field->height, way = x % height, y = down ? (line + height - way) % height : (line + way) % height;
	size_t to_side = down ? y + 1 : height - y, left = field->width - x;
	return (struct piece){x, y, (int)(to_side < left ? to_side : left), down ? x + y : x + height - 1 - y};
}

/* Returns the piece of a line that ends before column `end`. */
static struct piece piece_before(const struct sliding_field *field, size_t line, size_t end, bool down)
{
	size_t x = end - 1, y = piece_at(field, line, x, down).y, before = down ? field->height - 1 - y : y;
	return piece_at(field, line, x - (before < x ? before : x), down);
}

/* Finds where pieces fall and rise. Rows become posts of the pieces later. */
static void look_diagonally(const struct sliding_field *field, bool down, struct ends ends)
{
	const int32_t least = field->rule->least[1];
	for (size_t y = 0; y + 1 < field->height; y++) {
		const int32_t *south = field->heights + y * field->stride, *north = south + field->stride;
		/* The line goes from the west: to the north-east from the row in the south, to the south-east from that in the north. */
		const struct ends row = from(ends, down ? y + 1 : field->height - 1 - y);
		look_row(down ? north : south, (down ? south : north) + 1, field->width - 1, least, (int32_t)y + down, &row);
	}
}

/* Returns posts of a piece from rows of the field. */
static struct sliding_reach posts_of(const struct piece *piece, int32_t first, int32_t last, bool down)
{
	const int32_t y = (int32_t)piece->y;
	if (first > last)
		return (struct sliding_reach){INT32_MAX, -1};
	return down ? (struct sliding_reach){y - last, y - first} : (struct sliding_reach){first - y, last - y};
}

static void along_diagonals(const struct sliding_field *field, bool down)
{
	const struct ends ends = ends_of(field);
	const int direction = down ? 3 : 2;
	look_diagonally(field, down, ends);
	for (size_t line = 0; line < field->height; line++) {
		int pops = 0, pops_back = 0;
		for (size_t x = 0; x < field->width;) {
			const struct piece piece = piece_at(field, line, x, down);
			const struct sliding_reach falls = posts_of(&piece, ends.falls_first[piece.number], ends.falls_last[piece.number], down);
			struct sliding_reach rises = posts_of(&piece, ends.rises_first[piece.number], ends.rises_last[piece.number], down);
			rises = walk_there(field, direction, piece.x, piece.y, piece.count, falls, rises, &pops);
			ends.rises_first[piece.number] = rises.first;
			ends.rises_last[piece.number] = rises.last;
			x += (size_t)piece.count;
		}
		for (size_t end = field->width; end > 0;) {
			const struct piece piece = piece_before(field, line, end, down);
			const struct sliding_reach rises = {ends.rises_first[piece.number], ends.rises_last[piece.number]};
			walk_back(field, direction, piece.x, piece.y, piece.count, rises, &pops_back);
			end = piece.x;
		}
	}
}

void soil_sliding_along(struct sliding_field *field, int direction)
{
	if (field->width == 0 || field->height == 0)
		return;
	if (direction == 0)
		along_rows(field);
	else if (direction == 1)
		along_columns(field);
	else
		along_diagonals(field, direction == 3);
}
