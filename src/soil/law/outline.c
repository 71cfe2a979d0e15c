/* The outline of a mesh: the exact part of each cell that the mesh covers, and how far it reaches along its motion. See fine.h. */
#include "soil/law/fine.h"

#define ONWARD_NONE UINT32_MAX
#define STRAIGHT 2e-3f /* places: an edge that leaves the line of the one before by less goes on along it */

/* Sums over the outline, of cells. An edge that goes north has the mesh to its east. It adds what lies east of it in its own cell: the area, and that times
 * the place to the east and to the north. `rise` and `level` are the same for all cells further east. An edge that goes south takes them away. Places
 * are in cells, from the cell's south-west corner. */
enum { AREA, ACROSS, UPWARDS, RISE, LEVEL };

/* Adds a piece of an edge within a cell. */
SOIL_INLINED void add_piece(float *const sums[5], size_t cell, float x0, float y0, float x1, float y1)
{
	const float rise = y1 - y0, x = 0.5f * (x0 + x1), y = 0.5f * (y0 + y1);
	const float squares = (x0 * x0 + x0 * x1 + x1 * x1) * (1 / 3.0f), both = (2 * x0 * y0 + x0 * y1 + x1 * y0 + 2 * x1 * y1) * (1 / 6.0f);
	sums[AREA][cell] += rise * (1 - x);
	sums[ACROSS][cell] += rise * 0.5f * (1 - squares);
	sums[UPWARDS][cell] += rise * (y - both);
	sums[RISE][cell + 1] += rise;
	sums[LEVEL][cell + 1] += rise * y;
}

/* Adds a piece of an edge within a row of cells. */
static void add_row(float *const sums[5], size_t row, float x0, float y0, float x1, float y1)
{
	const int32_t first = (int32_t)x0, last = (int32_t)x1, way = last < first ? -1 : 1;
	if (!(y1 > y0) && !(y1 < y0))
		return;
	float x = x0, y = y0;
	for (int32_t cell = first; cell != last; cell += way) {
		const float side = (float)(way > 0 ? cell + 1 : cell), at = y0 + (side - x0) * (y1 - y0) / (x1 - x0);
		add_piece(sums, row + (size_t)cell, x - (float)cell, y, side - (float)cell, at);
		x = side;
		y = at;
	}
	add_piece(sums, row + (size_t)last, x - (float)last, y, x1 - (float)last, y1);
}

static void add_edge(float *const sums[5], size_t columns, float x0, float y0, float x1, float y1)
{
	const int32_t first = (int32_t)y0, last = (int32_t)y1, way = last < first ? -1 : 1;
	float x = x0, y = y0;
	for (int32_t row = first; row != last; row += way) {
		const float side = (float)(way > 0 ? row + 1 : row), at = x0 + (side - y0) * (x1 - x0) / (y1 - y0);
		add_row(sums, (size_t)row * columns, x, y - (float)row, at, side - (float)row);
		x = at;
		y = side;
	}
	add_row(sums, (size_t)last * columns, x, y - (float)last, x1, y1 - (float)last);
}

/* Sets the cells' parts from the sums. */
static void put_areas(const struct soil_fine_work *work, const struct soil_fine *fine)
{
	const size_t columns = (size_t)fine->cells[0] + 1;
	for (size_t row = 0; row < (size_t)fine->cells[1]; row++) {
		float rise = 0, level = 0;
		for (size_t i = 0; i < (size_t)fine->cells[0]; i++) {
			const size_t at = row * columns + i, cell = row * (size_t)fine->cells[0] + i;
			rise += work->sums[RISE][at];
			level += work->sums[LEVEL][at];
			const float area = rise + work->sums[AREA][at], across = 0.5f * rise + work->sums[ACROSS][at], upwards = level + work->sums[UPWARDS][at];
			const bool any = area > 1e-5f;
			work->areas[cell] = either(any, least(area, 1), 0);
			work->middles[0][cell] = either(any, clamped(across / most(area, 1e-5f), 0, 1) - 0.5f, 0);
			work->middles[1][cell] = either(any, clamped(upwards / most(area, 1e-5f), 0, 1) - 0.5f, 0);
		}
	}
}

/* The same by counting the places that the mesh is above. */
static void count_areas(const struct soil_fine_work *work, const struct soil_fine *fine)
{
	const float by = 1 / (float)fine->parts;
	for (int32_t y = 0; y < fine->cells[1]; y++)
		for (int32_t x = 0; x < fine->cells[0]; x++) {
			const float *cell = work->drawn + (size_t)(y * fine->parts) * (size_t)fine->stride + (size_t)(x * fine->parts);
			const size_t at = (size_t)(y * fine->cells[0] + x);
			float count = 0, across = 0, upwards = 0;
			for (int32_t j = 0; j < fine->parts; j++)
				for (int32_t i = 0; i < fine->parts; i++)
					if (cell[(size_t)j * (size_t)fine->stride + (size_t)i] < 0.5f * FINE_NONE) {
						count++;
						across += (float)(2 * i + 1 - fine->parts);
						upwards += (float)(2 * j + 1 - fine->parts);
					}
			work->areas[at] = count * by * by;
			work->middles[0][at] = 0.5f * by * across / most(count, 1);
			work->middles[1][at] = 0.5f * by * upwards / most(count, 1);
		}
}

/* Puts an edge, m along the motion and to its left, into the strips that it crosses. */
static void reach(const struct soil_fine_work *work, struct soil_fine *fine, const float a[2], const float b[2])
{
	const bool up = a[1] <= b[1];
	const float *low = up ? a : b, *high = up ? b : a, by = 1 / most(high[1] - low[1], 1e-9f), slope = (high[0] - low[0]) * by;
	const float origin = fine->aside;
	const int32_t first = (int32_t)((low[1] - origin) * fine->by_step), last = (int32_t)((high[1] - origin) * fine->by_step) + 1;
	for (int32_t i = first; i <= last && i < fine->strips; i++) {
		const float y = clamped(origin + (float)i * fine->step, low[1], high[1]), x = low[0] + (y - low[1]) * slope;
		work->front[i] = most(work->front[i], x);
		work->rear[i] = least(work->rear[i], x);
	}
}

/* Gives the parts of cells whose post is not covered to the nearest covered post beside. Where there is none, the cell keeps it. */
static void share_out(const struct soil_fine_work *work, const struct soil_fine *fine)
{
	const int32_t columns = fine->cells[0], rows = fine->cells[1], middle = fine->parts / 2;
	float *shares = work->sums[0], *moments[2] = {work->sums[1], work->sums[2]}, *covered = work->sums[3];
	const size_t count = (size_t)columns * (size_t)rows;
	for (int32_t y = 0; y < rows; y++)
		for (int32_t x = 0; x < columns; x++)
			covered[y * columns + x] = work->drawn[(y * fine->parts + middle) * fine->stride + x * fine->parts + middle] < 0.5f * FINE_NONE ? 1 : 0;
	for (int k = 0; k < 3; k++)
		memset(work->sums[k], 0, count * sizeof(float));
	for (int32_t y = 0; y < rows; y++)
		for (int32_t x = 0; x < columns; x++) {
			const int32_t cell = y * columns + x;
			const float area = work->areas[cell], at[2] = {work->middles[0][cell], work->middles[1][cell]};
			int32_t to[2] = {0, 0};
			float nearest = FINE_NONE;
			for (int32_t j = y > 0 ? -1 : 0; area > 0 && !(covered[cell] > 0) && j <= 1 && y + j < rows; j++)
				for (int32_t i = x > 0 ? -1 : 0; i <= 1 && x + i < columns; i++) {
					const float away = (at[0] - (float)i) * (at[0] - (float)i) + (at[1] - (float)j) * (at[1] - (float)j);
					if (covered[cell + j * columns + i] > 0 && away < nearest) {
						nearest = away;
						to[0] = i;
						to[1] = j;
					}
				}
			const int32_t other = cell + to[1] * columns + to[0];
			shares[other] += area;
			for (int k = 0; k < 2; k++)
				moments[k][other] += area * (at[k] - (float)to[k]);
		}
	for (size_t i = 0; i < count; i++) {
		work->areas[i] = shares[i];
		for (int k = 0; k < 2; k++)
			work->middles[k][i] = moments[k][i] / most(shares[i], 1e-9f);
	}
}

/* Adds how far an edge reaches, between places of the raster. */
static void add_reach(const struct soil_fine_work *work, struct soil_fine *fine, const float from[2], const float to[2])
{
	const float c = fine->axis[0], q = fine->axis[1];
	const float ends[2][2] = {{fine->x + from[0] * fine->step, fine->y + from[1] * fine->step}, {fine->x + to[0] * fine->step, fine->y + to[1] * fine->step}};
	const float a[2] = {c * ends[0][0] + q * ends[0][1], c * ends[0][1] - q * ends[0][0]}, b[2] = {c * ends[1][0] + q * ends[1][1], c * ends[1][1] - q * ends[1][0]};
	reach(work, fine, a, b);
	fine->sides[0] = least(fine->sides[0], least(a[1], b[1]));
	fine->sides[1] = most(fine->sides[1], most(a[1], b[1]));
}

/* Adds an edge of the outline. */
static void add_outline(const struct soil_fine_work *work, struct soil_fine *fine, const float from[2], const float to[2])
{
	const float by = 1 / (float)fine->parts;
	if (work->surface->closed)
		add_edge(work->sums, (size_t)fine->cells[0] + 1, (from[0] + 0.5f) * by, (from[1] + 0.5f) * by, (to[0] + 0.5f) * by, (to[1] + 0.5f) * by);
	add_reach(work, fine, from, to);
}

/* Adds how far a triangle of a wall reaches. */
static void add_wall(const struct soil_fine_work *work, struct soil_fine *fine, size_t t)
{
	const struct soil_surface *s = work->surface;
	for (size_t k = 0; k < 3; k++) {
		const uint32_t from = s->corners[t][k], to = s->corners[t][k == 2 ? 0 : k + 1];
		if (work->looks[s->across[t][k]] == FINE_UP)
			add_reach(work, fine, (const float[2]){work->u[from], work->v[from]}, (const float[2]){work->u[to], work->v[to]});
	}
}

/* Goes on along the outline from a vertex. Edges on one line are added as one. */
static void follow(const struct soil_fine_work *work, struct soil_fine *fine, uint32_t first)
{
	const float *u = work->u, *v = work->v;
	uint32_t from = first, to = work->onward[first];
	while (to != ONWARD_NONE) {
		const float x = u[to] - u[from], y = v[to] - v[from], near = STRAIGHT * sqrtf(x * x + y * y);
		uint32_t next = work->onward[to];
		work->onward[from] = ONWARD_NONE;
		while (next != ONWARD_NONE) {
			const float far_x = u[next] - u[from], far_y = v[next] - v[from], on_x = u[next] - u[to], on_y = v[next] - v[to];
			if (!(fabsf(x * far_y - y * far_x) <= near) || !(x * on_x + y * on_y >= 0))
				break;
			work->onward[to] = ONWARD_NONE;
			to = next;
			next = work->onward[to];
		}
		add_outline(work, fine, (const float[2]){u[from], v[from]}, (const float[2]){u[to], v[to]});
		from = to;
		to = next;
	}
}

/* Goes along each edge of the outline. Of a mesh that is not closed all edges count. */
void soil_fine_outline(const struct soil_fine_work *work, struct soil_fine *fine)
{
	const struct soil_surface *s = work->surface;
	const float *u = work->u, *v = work->v;
	const uint8_t *looks = work->looks;
	for (int k = 0; k < 5; k++)
		memset(work->sums[k], 0, ((size_t)fine->cells[0] + 1) * (size_t)fine->cells[1] * sizeof(float));
	for (int32_t i = 0; i < fine->strips; i++) {
		work->front[i] = -FINE_NONE;
		work->rear[i] = FINE_NONE;
	}
	memset(work->onward, 0xff, s->vertex_count * sizeof *work->onward);
	for (size_t t = 0; t < s->triangle_count; t++) {
		if (s->closed && looks[t] == FINE_SIDE)
			add_wall(work, fine, t);
		if (s->closed && looks[t] != FINE_SOLE)
			continue;
		for (size_t k = 0; k < 3; k++) {
			if (s->closed && looks[s->across[t][k]] == FINE_SOLE)
				continue;
			const uint32_t from = s->corners[t][k], to = s->corners[t][k == 2 ? 0 : k + 1];
			if (s->closed && work->onward[from] == ONWARD_NONE)
				work->onward[from] = to;
			else
				add_outline(work, fine, (const float[2]){u[from], v[from]}, (const float[2]){u[to], v[to]});
		}
	}
	for (uint32_t i = 0; i < s->vertex_count && s->closed; i++)
		follow(work, fine, i);
	if (s->closed)
		put_areas(work, fine);
	else
		count_areas(work, fine);
	share_out(work, fine);
}
