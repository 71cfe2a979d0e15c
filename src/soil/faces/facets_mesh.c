/* Facets of a mesh: its triangles, cut where they are large, that look outwards. Those of an open mesh look in both directions. */
#include "soil/faces/facets_making.h"

#include <string.h>

#include "soil/law/surface.h"

#define UPRIGHT 0.052335956242943835 /* sin 3 degrees: a triangle whose normal has a smaller z is a side */
#define FINE 2000                    /* triangles: so many that are not much larger than facets are gathered */
#define OPEN 1e-4                    /* share of the surface: an open border around less does not matter */

struct facets_mesh {
	struct soil_surfaces surfaces;
	const struct soil_surface *surface; /* closed; or NULL: the triangles are the mesh's own */
	const struct soil_mesh *mesh;
	uint32_t count;
	int side;                           /* 1: triangles look outwards as they are; -1: turned over; 0: they look both ways */
};

struct triangle {
	double at[3][3];
};

static struct triangle triangle_at(const struct facets_mesh *of, uint32_t t)
{
	struct triangle triangle;
	for (int k = 0; k < 3; k++)
		for (int i = 0; i < 3; i++) {
			const struct soil_surface *s = of->surface;
			if (s != NULL)
				triangle.at[k][i] = (double)(i == 0 ? s->x : i == 1 ? s->y : s->z)[s->corners[t][k]];
			else
				triangle.at[k][i] = (double)of->mesh->vertices[of->mesh->triangles[t][k]][i];
		}
	return triangle;
}

/* Computes the normal times the area. */
static void vector_of(const struct triangle *t, double vector[3])
{
	double p[3], q[3];
	for (int k = 0; k < 3; k++) {
		p[k] = t->at[1][k] - t->at[0][k];
		q[k] = t->at[2][k] - t->at[0][k];
	}
	for (int k = 0; k < 3; k++)
		vector[k] = (p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3]) / 2;
}

static double length_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/*
 * Sums over the triangles: area, volume from the centre, and the circulation of some fields around all of them. Where two triangles have an edge in
 * common and agree, its two circulations cancel, also where the edge of one is divided among several others. So what is left is that of the open
 * border. The fields: (a . p)^2 b for some vectors a and b. On a straight edge the mean of (a . p)^2 is exact by Simpson's rule.
 */
#define FIELDS 6
struct sums {
	double area, volume, vector[3], around[FIELDS];
};

static void add_edges(const struct triangle *t, double scale, struct sums *sums)
{
	static const double a[FIELDS][3] = {{1, 0.3, -0.2}, {-0.4, 1, 0.7}, {0.6, -0.5, 1}, {1, -0.8, 0.9}, {0.2, 0.9, -1}, {0.7, 0.6, 0.5}};
	static const double b[FIELDS][3] = {{-0.3, 1, 0.5}, {0.8, 0.2, 1}, {1, 0.7, -0.4}, {0.4, 1, -0.6}, {1, -0.3, 0.8}, {-0.5, 0.9, 1}};
	for (int k = 0; k < 3; k++) {
		const double *p = t->at[k], *q = t->at[(k + 1) % 3];
		for (int f = 0; f < FIELDS; f++) {
			double u = 0, v = 0, along = 0;
			for (int i = 0; i < 3; i++) {
				u += a[f][i] * p[i] / scale;
				v += a[f][i] * q[i] / scale;
				along += b[f][i] * (q[i] - p[i]);
			}
			sums->around[f] += (u * u + u * v + v * v) / 3 * along;
		}
	}
}

static struct sums sums_of(const struct facets_mesh *of, double scale)
{
	struct sums sums = {0};
	for (uint32_t t = 0; t < of->count; t++) {
		const struct triangle triangle = triangle_at(of, t);
		double vector[3];
		vector_of(&triangle, vector);
		sums.area += length_of(vector);
		for (int k = 0; k < 3; k++) {
			sums.volume += triangle.at[0][k] * vector[k] / 3;
			sums.vector[k] += vector[k];
		}
		add_edges(&triangle, scale, &sums);
	}
	return sums;
}

/* Finds out by the triangles as they are wound where outside is. */
static int side_of(const struct facets_mesh *of)
{
	double scale = 0;
	for (int k = 0; k < 3; k++)
		scale = fmax(scale, of->mesh->high[k] - of->mesh->low[k]);
	if (!(scale > 0))
		return 0;
	const struct sums sums = sums_of(of, scale);
	bool open = length_of(sums.vector) > OPEN * sums.area;
	for (int f = 0; f < FIELDS; f++)
		open |= fabs(sums.around[f]) > OPEN * sums.area / scale;
	if (open)
		return 0;
	return sums.volume < 0 ? -1 : 1;
}

/* Returns true if the triangles are so many, or so many and small, that their facets should be gathered. */
static bool too_fine(const struct facets_mesh *of, double size)
{
	double area = 0;
	for (uint32_t t = 0; t < of->count; t++) {
		const struct triangle triangle = triangle_at(of, t);
		double vector[3];
		vector_of(&triangle, vector);
		area += length_of(vector);
	}
	const uint64_t facets = (of->side == 0 ? 2 : 1) * (uint64_t)of->count;
	return facets > SOIL_FACETS_MOST || (of->count > FINE && of->count > area / size / size / 2);
}

enum status soil_facets_mesh_begin(const struct soil_mesh *mesh, double size, struct facets_mesh **out, bool *both, bool *many)
{
	enum status status;
	TRY(mem_zeroed(out, 1, sizeof **out, "a body's facets"));
	struct facets_mesh *of = *out;
	of->mesh = mesh;
	of->count = mesh->triangle_count;
	of->side = 1;
	TRY_OR(failed, soil_surface_of(&of->surfaces, mesh, &of->surface));
	if (of->surface->closed) {
		of->count = of->surface->triangle_count;
	} else {
		of->surface = NULL;
		of->side = side_of(of);
	}
	*both = of->side == 0;
	*many = too_fine(of, size);
	return STATUS_OK;
failed:
	soil_facets_mesh_end(of);
	*out = NULL;
	return status;
}

void soil_facets_mesh_end(struct facets_mesh *mesh)
{
	if (mesh == NULL)
		return;
	soil_surfaces_finish(&mesh->surfaces);
	mem_free(mesh);
}

/* A flat part of a triangle, in its plane: corners, m. A triangle that is cut four times has at most seven. */
struct part {
	double at[8][2];
	int corners;
};

/* A triangle in its own plane. `from`: the start of its longest edge, which goes along axes[0]; axes[1] points from there to the corner across. */
struct facets_plane {
	double from[3], axes[2][3], vector[3];
	enum soil_facet_kind kind;
};

/* Keeps of a part what lies above a line across an axis, or below it. */
static void cut(const struct part *whole, int axis, double line, double sign, struct part *kept)
{
	kept->corners = 0;
	for (int i = 0; i < whole->corners; i++) {
		const double *p = whole->at[i], *q = whole->at[(i + 1) % whole->corners];
		const double u = sign * (p[axis] - line), v = sign * (q[axis] - line);
		if (u >= 0)
			memcpy(kept->at[kept->corners++], p, sizeof kept->at[0]);
		if ((u < 0 && v > 0) || (u > 0 && v < 0)) {
			double *at = kept->at[kept->corners++];
			at[axis] = line;
			at[1 - axis] = p[1 - axis] + (q[1 - axis] - p[1 - axis]) * (u / (u - v));
		}
	}
}

/* Keeps what lies in strip `index` of `count` between `low` and `high`. */
static void keep_strip(const struct part *whole, int axis, const double range[2], int index, int count, struct part *kept)
{
	struct part above;
	const double step = (range[1] - range[0]) / count;
	cut(whole, axis, range[0] + index * step, 1, &above);
	cut(&above, axis, range[0] + (index + 1) * step, -1, kept);
}

/* Finds the area and the middle of a part. Returns false if it has no area. */
static bool middle_of(const struct part *part, double *area, double middle[2])
{
	*area = middle[0] = middle[1] = 0;
	for (int i = 1; i + 1 < part->corners; i++) {
		const double *o = part->at[0], *p = part->at[i], *q = part->at[i + 1];
		const double twice = (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
		*area += twice / 2;
		for (int k = 0; k < 2; k++)
			middle[k] += twice / 6 * (p[k] + q[k] - 2 * o[k]);
	}
	if (!(*area > 0))
		return false;
	for (int k = 0; k < 2; k++)
		middle[k] = part->at[0][k] + middle[k] / *area;
	return true;
}

static void put_part(struct facets_making *m, const struct facets_plane *plane, const struct part *part)
{
	double area, middle[2], at[3], vector[3], other[3];
	if (!middle_of(part, &area, middle))
		return;
	for (int k = 0; k < 3; k++) {
		at[k] = plane->from[k] + middle[0] * plane->axes[0][k] + middle[1] * plane->axes[1][k];
		vector[k] = area * plane->vector[k];
		other[k] = -vector[k];
	}
	soil_facets_put(m, at, vector, plane->kind);
	if (m->mesh->side == 0)
		soil_facets_put(m, at, other, plane->kind);
}

/* Cuts a triangle along its longest edge and across it, so that no part is longer than the size in either direction. */
static void put_triangle(struct facets_making *m, const struct triangle *t, const double vector[3])
{
	double edges[3][3], lengths[3];
	int first = 0;
	for (int k = 0; k < 3; k++) {
		for (int i = 0; i < 3; i++)
			edges[k][i] = t->at[(k + 1) % 3][i] - t->at[k][i];
		lengths[k] = length_of(edges[k]);
		first = lengths[k] > lengths[first] ? k : first;
	}
	struct facets_plane plane;
	const double area = length_of(vector), *last = edges[(first + 2) % 3];
	const double across[2] = {0, 2 * area / lengths[first]}, length[2] = {0, lengths[first]};
	struct part whole = {.at = {{0, 0}, {length[1], 0}, {0, across[1]}}, .corners = 3};
	for (int k = 0; k < 3; k++) {
		plane.from[k] = t->at[first][k];
		plane.axes[0][k] = edges[first][k] / lengths[first];
		plane.vector[k] = (m->mesh->side < 0 ? -1 : 1) * vector[k] / area;
		whole.at[2][0] -= last[k] * plane.axes[0][k];
	}
	for (int k = 0; k < 3; k++)
		plane.axes[1][k] = (-last[k] - whole.at[2][0] * plane.axes[0][k]) / across[1];
	plane.kind = fabs(plane.vector[2]) < UPRIGHT ? FACET_SIDE : FACET_UNDER;
	const int rows = facets_parts(across[1], m->size), columns = facets_parts(length[1], m->size);
	if (rows == 1 && columns == 1) {
		put_part(m, &plane, &whole);
		return;
	}
	for (int row = 0; row < rows && !facets_full(m); row++) {
		struct part strip, part;
		keep_strip(&whole, 1, across, row, rows, &strip);
		for (int column = 0; column < columns && !facets_full(m); column++) {
			keep_strip(&strip, 0, length, column, columns, &part);
			put_part(m, &plane, &part);
		}
	}
}

void soil_facets_put_mesh(struct facets_making *m)
{
	for (uint32_t t = 0; t < m->mesh->count && !facets_full(m); t++) {
		const struct triangle triangle = triangle_at(m->mesh, t);
		double vector[3];
		vector_of(&triangle, vector);
		if (length_of(vector) > 0)
			put_triangle(m, &triangle, vector);
	}
}
