/* Wavefront OBJ: text, z up. A vertex and its normal have the same number, from 1. */
#include "exchange/mesh.h"

#include <errno.h>
#include <string.h>

/* Lines of a vertex have at most 45 bytes and 33 for its normal, those of a triangle three times two numbers. */
static double bytes_of(double vertices, double triangles)
{
	double digits = floor(log10(fmax(vertices, 1))) + 1;
	return 512 + 78 * vertices + (2 + 3 * (2 * digits + 3)) * triangles;
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
		double at[3], normal[3];
		exchange_surface_position(surface, row, x, at);
		exchange_row_normal(row, x, surface->spacing, normal);
		TRY(told(surface, fprintf(surface->file, "v %.9g %.9g %.9g\nvn %.6f %.6f %.6f\n", at[0], at[1], at[2], normal[0], normal[1],
					  normal[2])));
	}
	return STATUS_OK;
}

static enum status put_triangle(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3])
{
	struct exchange_surface *surface = user;
	unsigned long long a = vertices[0] + 1, b = vertices[1] + 1, c = vertices[2] + 1;
	(void)row, (void)x, (void)corners;
	return told(surface, fprintf(surface->file, "f %llu//%llu %llu//%llu %llu//%llu\n", a, a, b, b, c, c));
}

static enum status write_obj(struct exchange_surface *surface)
{
	const double *o = surface->origin;
	TRY(told(surface, fprintf(surface->file, "# furrow: metres, x east, y north, z up\n# origin: %.17g m east and %.17g m north of the terrain's "
				  "south-west post, height %.17g m\n", o[0], o[1], o[2])));
	TRY(exchange_surface_each(surface, put_vertices, surface));
	return exchange_surface_triangles(surface, put_triangle, surface);
}

const struct exchange_mesh_format exchange_obj = {".obj", 2, bytes_of, write_obj};
