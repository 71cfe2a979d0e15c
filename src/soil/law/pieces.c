/* Smooth pieces of a closed mesh, and whether it is a drum or a block: see pieces.h. */
#include "soil/law/pieces.h"

#include <string.h>

#define NONE UINT32_MAX
#define SMOOTH 0.8f      /* cosine of the angle at an edge: two triangles that turn less belong to one piece */
#define ALIKE 0.02       /* moments of a body that is round about an axis differ by less, as a share */
#define SECTORS 12       /* around an axis: */
#define SECTORS_LEAST 10 /* in so many of them a drum reaches */
#define RIM 0.98         /* of its radius, */
#define TREAD 0.9        /* and its width is that of what reaches this part */
#define FLAT 0.95        /* cosine: a triangle lies across the axis */
#define ENDS_LEAST 0.4   /* flat ends have at least this share of the area of two discs */
#define EVEN 1e-3        /* of its radius: how far the middles of an even drum's facets lie below its corners, at most */
#define BLOCK 0.99       /* a block fills this share of its bounds */

static void put_normals(struct soil_surface *s)
{
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		const uint32_t *c = s->corners[t];
		const float a[3] = {s->x[c[1]] - s->x[c[0]], s->y[c[1]] - s->y[c[0]], s->z[c[1]] - s->z[c[0]]};
		const float b[3] = {s->x[c[2]] - s->x[c[0]], s->y[c[2]] - s->y[c[0]], s->z[c[2]] - s->z[c[0]]};
		const float n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
		const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), by = length > 0 ? 1 / length : 0;
		for (int k = 0; k < 3; k++)
			s->normals[t][k] = n[k] * by;
	}
}

static float turn_at(const struct soil_surface *s, uint32_t a, uint32_t b)
{
	const float *m = s->normals[a], *n = s->normals[b];
	return m[0] * n[0] + m[1] * n[1] + m[2] * n[2];
}

static void put_pieces(struct soil_surface *s, uint32_t *stack)
{
	s->piece_count = 0;
	for (uint32_t t = 0; t < s->triangle_count; t++)
		s->pieces[t] = NONE;
	for (uint32_t first = 0; first < s->triangle_count; first++) {
		if (s->pieces[first] != NONE)
			continue;
		uint32_t count = 0, done = 0;
		stack[count++] = first;
		s->pieces[first] = s->piece_count;
		while (done < count) {
			const uint32_t t = stack[done++];
			for (int k = 0; k < 3; k++) {
				const uint32_t other = (uint32_t)s->across[t][k];
				if (s->pieces[other] != NONE || turn_at(s, t, other) < SMOOTH)
					continue;
				s->pieces[other] = s->piece_count;
				stack[count++] = other;
			}
		}
		s->piece_count++;
	}
}

static void put_corner(const struct soil_surface *s, uint32_t vertex, double at[3])
{
	at[0] = (double)s->x[vertex];
	at[1] = (double)s->y[vertex];
	at[2] = (double)s->z[vertex];
}

/* Returns twice the area of a triangle. */
static double area_of(const double at[3][3])
{
	double n[3];
	for (int k = 0; k < 3; k++) {
		const int i = (k + 1) % 3, j = (k + 2) % 3;
		n[k] = (at[1][i] - at[0][i]) * (at[2][j] - at[0][j]) - (at[1][j] - at[0][j]) * (at[2][i] - at[0][i]);
	}
	return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Gives the second moments of the surface about the object's centre. */
static void put_moments(const struct soil_surface *s, double moments[3][3])
{
	memset(moments, 0, 9 * sizeof **moments);
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		double at[3][3], sum[3];
		for (int i = 0; i < 3; i++)
			put_corner(s, s->corners[t][i], at[i]);
		const double part = area_of((const double(*)[3])at) / 24;
		for (int k = 0; k < 3; k++)
			sum[k] = at[0][k] + at[1][k] + at[2][k];
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++)
				moments[i][k] += part * (sum[i] * sum[k] + at[0][i] * at[0][k] + at[1][i] * at[1][k] + at[2][i] * at[2][k]);
	}
}

/* Turns a symmetric matrix to its own axes by Jacobi's rotations. axes: these, in rows. */
static void put_axes(double m[3][3], double axes[3][3])
{
	memset(axes, 0, 9 * sizeof **axes);
	axes[0][0] = axes[1][1] = axes[2][2] = 1;
	for (int round = 0; round < 24; round++) {
		const int i = round % 3, k = (i + 1) % 3;
		if (fabs(m[i][k]) <= 1e-9 * (m[0][0] + m[1][1] + m[2][2]))
			continue;
		const double angle = 0.5 * atan2(2 * m[i][k], m[i][i] - m[k][k]), c = cos(angle), q = sin(angle);
		for (int j = 0; j < 3; j++) {
			const double a = m[i][j], b = m[k][j], u = axes[i][j], v = axes[k][j];
			m[i][j] = c * a + q * b;
			m[k][j] = c * b - q * a;
			axes[i][j] = c * u + q * v;
			axes[k][j] = c * v - q * u;
		}
		for (int j = 0; j < 3; j++) {
			const double a = m[j][i], b = m[j][k];
			m[j][i] = c * a + q * b;
			m[j][k] = c * b - q * a;
		}
	}
}

static double along(const double axis[3], const double at[3])
{
	return axis[0] * at[0] + axis[1] * at[1] + axis[2] * at[2];
}

/* Returns true if the surface reaches about as far all around the axis. one, other: axes across it. */
static bool is_round(const struct soil_surface *s, const double one[3], const double other[3], double *radius)
{
	unsigned sectors = 0;
	double at[3];
	*radius = 0;
	for (uint32_t i = 0; i < s->vertex_count; i++) {
		put_corner(s, i, at);
		*radius = fmax(*radius, hypot(along(one, at), along(other, at)));
	}
	for (uint32_t i = 0; i < s->vertex_count; i++) {
		put_corner(s, i, at);
		const double u = along(one, at), v = along(other, at);
		if (hypot(u, v) >= RIM * *radius)
			sectors |= 1u << (int)fmin((atan2(v, u) / M_PI + 1) * SECTORS / 2, SECTORS - 1);
	}
	return __builtin_popcount(sectors) >= SECTORS_LEAST;
}

/* Returns the area of the surface that lies across an axis, and how far the surface reaches along the axis where it is the tread. */
static double ends_of(const struct soil_surface *s, const double axis[3], double radius, double *width)
{
	double area = 0, low = 0, high = 0;
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		const double n[3] = {(double)s->normals[t][0], (double)s->normals[t][1], (double)s->normals[t][2]};
		double at[3][3];
		for (int i = 0; i < 3; i++) {
			put_corner(s, s->corners[t][i], at[i]);
			const double on = along(axis, at[i]), squares = at[i][0] * at[i][0] + at[i][1] * at[i][1] + at[i][2] * at[i][2] - on * on;
			if (squares < TREAD * TREAD * radius * radius)
				continue;
			low = fmin(low, on);
			high = fmax(high, on);
		}
		area += fabs(along(axis, n)) >= FLAT ? 0.5 * area_of((const double(*)[3])at) : 0;
	}
	*width = high - low;
	return area;
}

/* Returns by how much edges on the rim come nearer to the axis than its corners, at most, as a share of the radius. */
static double sag_of(const struct soil_surface *s, const double axis[3], double radius)
{
	double lowest = radius * radius;
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		const double n[3] = {(double)s->normals[t][0], (double)s->normals[t][1], (double)s->normals[t][2]};
		double at[3][3], squares[3];
		if (fabs(along(axis, n)) > 0.5) /* edges of its ends go across */
			continue;
		for (int i = 0; i < 3; i++) {
			put_corner(s, s->corners[t][i], at[i]);
			const double on = along(axis, at[i]);
			squares[i] = at[i][0] * at[i][0] + at[i][1] * at[i][1] + at[i][2] * at[i][2] - on * on;
		}
		for (int i = 0; i < 3; i++) {
			const int k = (i + 1) % 3;
			const double middle[3] = {0.5 * (at[i][0] + at[k][0]), 0.5 * (at[i][1] + at[k][1]), 0.5 * (at[i][2] + at[k][2])}, on = along(axis, middle);
			if (fmin(squares[i], squares[k]) >= (1 - 2 * EVEN) * radius * radius)
				lowest = fmin(lowest, middle[0] * middle[0] + middle[1] * middle[1] + middle[2] * middle[2] - on * on);
		}
	}
	return 1 - sqrt(lowest) / radius;
}

/* Finds out whether the mesh is a drum: round about an axis through the object's centre, with flat ends. Its radius is that of the circle with the
 * area of its outline, about: corners and middles of facets are as far from it. */
static void find_drum(struct soil_surface *s)
{
	double moments[3][3], axes[3][3], radius, width;
	put_moments(s, moments);
	put_axes(moments, axes);
	for (int k = 0; k < 3 && !s->drum; k++) {
		const int i = (k + 1) % 3, j = (k + 2) % 3;
		if (fabs(moments[i][i] - moments[j][j]) > ALIKE * (moments[i][i] + moments[j][j]) || !is_round(s, axes[i], axes[j], &radius))
			continue;
		s->drum = ends_of(s, axes[k], radius, &width) >= ENDS_LEAST * 2 * M_PI * radius * radius && width > 0;
		for (int d = 0; d < 3; d++)
			s->axis[d] = axes[k][d];
		s->radius = radius;
		const double sag = sag_of(s, axes[k], radius);
		s->even = s->drum && sag < EVEN;
		s->mean = radius * (1 - sag * 2 / 3);
		s->width = width;
	}
}

static void find_block(struct soil_surface *s)
{
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, volume = 0;
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		double at[3][3];
		for (int i = 0; i < 3; i++) {
			put_corner(s, s->corners[t][i], at[i]);
			for (int k = 0; k < 3; k++) {
				low[k] = fmin(low[k], at[i][k]);
				high[k] = fmax(high[k], at[i][k]);
			}
		}
		for (int k = 0; k < 3; k++)
			volume += at[0][k] * (at[1][(k + 1) % 3] * at[2][(k + 2) % 3] - at[1][(k + 2) % 3] * at[2][(k + 1) % 3]) / 6;
	}
	for (int k = 0; k < 3; k++)
		s->sides[k] = high[k] - low[k];
	s->block = volume >= BLOCK * s->sides[0] * s->sides[1] * s->sides[2];
}

void soil_surface_pieces(struct soil_surface *s, uint32_t *stack)
{
	s->drum = s->even = s->block = false;
	s->piece_count = 0;
	if (!s->closed)
		return;
	put_normals(s);
	put_pieces(s, stack);
	find_drum(s);
	find_block(s);
}
