/* Binary STL: 80 bytes of text, the number of triangles, then 50 bytes each: normal, three corners, and 2 bytes that are 0. z is up if nothing else
 * is asked for. */
#include "exchange/mesh.h"

#include <string.h>

static double bytes_of(double vertices, double triangles)
{
	(void)vertices;
	return 84 + 50 * triangles;
}

static enum status put_triangle(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3])
{
	struct exchange_surface *surface = user;
	float numbers[12];
	double at[3][3], one[3], two[3], normal[3];
	uint8_t bytes[50] = {0};
	(void)vertices;
	for (int k = 0; k < 3; k++) {
		/* The row to the north, seen as this one. */
		struct exchange_row from = *row;
		from.y += corners[k] / 2;
		from.heights[1] = row->heights[1 + corners[k] / 2];
		double place[3];
		exchange_surface_position(surface, &from, x + corners[k] % 2, place);
		exchange_surface_turn(surface, place, at[k]);
	}
	for (int c = 0; c < 3; c++) {
		one[c] = at[1][c] - at[0][c];
		two[c] = at[2][c] - at[0][c];
	}
	for (int c = 0; c < 3; c++)
		normal[c] = one[(c + 1) % 3] * two[(c + 2) % 3] - one[(c + 2) % 3] * two[(c + 1) % 3];
	double size = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
	for (int c = 0; c < 3; c++) {
		numbers[c] = (float)(normal[c] / size);
		for (int k = 0; k < 3; k++)
			numbers[3 + 3 * k + c] = (float)at[k][c];
	}
	memcpy(bytes, numbers, sizeof numbers);
	return exchange_surface_put(surface, bytes, sizeof bytes);
}

static enum status write_stl(struct exchange_surface *surface)
{
	char text[81];
	uint32_t count = (uint32_t)surface->triangles;
	const double *o = surface->origin;
	int length = snprintf(text, sizeof text, "furrow, metres, %s up, origin %.10g %.10g %.10g", surface->y_up ? "y" : "z", o[0], o[1], o[2]);
	memset(text + length, ' ', sizeof text - (size_t)length); /* three numbers leave room */
	TRY(exchange_surface_put(surface, text, 80));
	TRY(exchange_surface_put(surface, &count, sizeof count));
	return exchange_surface_triangles(surface, put_triangle, surface);
}

const struct exchange_mesh_format exchange_stl = {".stl", false, 1, bytes_of, write_stl};
