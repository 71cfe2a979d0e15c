/* Grids of a plane in levels, for its encoder and its decoder. */
#include "store/codec_levels.h"

void store_level_pad(struct level_grid grid, uint32_t n)
{
	for (uint32_t y = 0; y <= n; y++) {
		int32_t *row = grid.posts + y * grid.stride;
		row[-1] = level_beyond(row[0], row[1], row[2]);
		row[n + 1] = level_beyond(row[n], row[n - 1], row[n - 2]);
	}
}

void store_level_edge(const int32_t *first, ptrdiff_t next, uint32_t n, int32_t *edge)
{
	for (uint32_t x = 0; x <= n; x++)
		edge[x] = level_beyond(first[x], first[next + x], first[2 * next + x]);
}

void store_level_around(struct level_grid grid, uint32_t n, uint32_t y, const int32_t *edges,
                        const int32_t *rows[4])
{
	rows[1] = grid.posts + 2 * y * grid.stride;
	rows[2] = rows[1] + 2 * grid.stride;
	rows[0] = y > 0 ? rows[1] - 2 * grid.stride : edges;
	rows[3] = y + 1 < n / 2 ? rows[2] + 2 * grid.stride : edges + n + 1;
}
