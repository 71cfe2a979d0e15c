/* Wavefront OBJ: text. A vertex, its place in a picture and its normal have the same number, from 1. The format does not say which axis is up; most
 * programs take y. */
#include "exchange/mesh.h"

#include <errno.h>
#include <string.h>

/* Lines of a vertex have at most 45 bytes, 33 for its normal and 25 for its place in a picture. Those of a triangle have three times three numbers. */
static double bytes_of(double vertices, double triangles)
{
	double digits = floor(log10(fmax(vertices, 1))) + 1;
	return 1024 + 103 * vertices + (2 + 3 * (3 * digits + 3)) * triangles;
}

static enum status told(const struct exchange_surface *surface, int written)
{
	return written > 0 ? STATUS_OK
			   : fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", surface->params->path, strerror(errno));
}

static enum status put_vertices(void *user, const struct exchange_row *row)
{
	struct exchange_surface *surface = user;
	for (int64_t x = 0; x < row->width; x++) {
		if (!exchange_row_used(row, x, 0))
			continue;
		double place[3], slope[3], at[3], normal[3];
		exchange_surface_position(surface, row, x, place);
		exchange_row_normal(row, x, surface->spacing, slope);
		exchange_surface_turn(surface, place, at);
		exchange_surface_turn(surface, slope, normal);
		/* In a picture with a pixel for each post of the window, as `furrow export -o` makes them. */
		const double u = ((double)x + 0.5) / (double)surface->width, v = ((double)row->y + 0.5) / (double)surface->rows;
		TRY(told(surface, fprintf(surface->file, "v %.9g %.9g %.9g\nvt %.8f %.8f\nvn %.6f %.6f %.6f\n", at[0], at[1], at[2], u, v, normal[0], normal[1],
					  normal[2])));
	}
	return STATUS_OK;
}

static enum status put_triangle(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3])
{
	struct exchange_surface *surface = user;
	unsigned long long a = vertices[0] + 1, b = vertices[1] + 1, c = vertices[2] + 1;
	(void)row, (void)x, (void)corners;
	return told(surface, fprintf(surface->file, "f %llu/%llu/%llu %llu/%llu/%llu %llu/%llu/%llu\n", a, a, a, b, b, b, c, c, c));
}

static enum status write_obj(struct exchange_surface *surface)
{
	const double *o = surface->origin;
	TRY(told(surface, fprintf(surface->file, "# furrow: metres, x east, %s\n# origin: %.17g m east and %.17g m north of the terrain's "
				  "south-west post, height %.17g m\no %s\n", surface->y_up ? "y up, z south" : "y north, z up", o[0], o[1], o[2], surface->name)));
	TRY(exchange_surface_each(surface, put_vertices, surface));
	return exchange_surface_triangles(surface, put_triangle, surface);
}

const struct exchange_mesh_format exchange_obj = {".obj", true, 2, bytes_of, write_obj};
