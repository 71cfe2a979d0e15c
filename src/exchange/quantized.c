/*
 * The bytes of a quantized-mesh-1.0 tile, little-endian:
 *
 *     header     centre, least and greatest height, bounding sphere, horizon occlusion point: 88 bytes
 *     vertices   u, v, height: uint16 each, zig-zag of the difference to the vertex before
 *     triangles  uint16, each the distance from the next index that was never used
 *     edges      indices of the vertices in the west, south, east, north
 *     extension  1: oct-encoded normals, 2 bytes each
 *
 * The format is that of Cesium's specification of quantized-mesh. Indices are coded by their first use, so vertices are numbered in the
 * order in which triangles name them.
 */
#include "exchange/internal.h"

#define VERTICES (EXCHANGE_SIDE * EXCHANGE_SIDE)
#define TRIANGLES (2 * EXCHANGE_CELLS * EXCHANGE_CELLS)
#define NOT_THERE UINT16_MAX
#define NEVER_HIDDEN 1e6 /* radii: a horizon occlusion point that is always seen */

/* The tile's triangles, and the numbers of its grid's vertices. All tiles have the same. */
struct layout {
	uint16_t number[VERTICES]; /* of a place in the grid */
	uint16_t place[VERTICES];  /* of a vertex */
	uint16_t indices[3 * TRIANGLES];
};

static void make_layout(struct layout *layout)
{
	size_t count = 0, next = 0;
	for (size_t k = 0; k < VERTICES; k++)
		layout->number[k] = NOT_THERE;
	for (size_t j = 0; j < EXCHANGE_CELLS; j++)
		for (size_t i = 0; i < EXCHANGE_CELLS; i++) {
			size_t sw = j * EXCHANGE_SIDE + i, nw = sw + EXCHANGE_SIDE;
			const size_t places[] = {sw, sw + 1, nw, nw, sw + 1, nw + 1}; /* counter-clockwise from above */
			for (int k = 0; k < 6; k++) {
				if (layout->number[places[k]] == NOT_THERE) {
					layout->place[next] = (uint16_t)places[k];
					layout->number[places[k]] = (uint16_t)next++;
				}
				layout->indices[count++] = layout->number[places[k]];
			}
		}
	assert(count == 3 * TRIANGLES && next == VERTICES);
}

/* --- the header --- */

struct header {
	double centre[3];
	float minimum, maximum;
	double sphere[3], radius, horizon[3];
};

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double length(const double a[3])
{
	return sqrt(dot(a, a));
}

/* How far out along `toward` a point must lie that is hidden by the ellipsoid if `point` is. All in radii of the ellipsoid. A line of
 * sight touches the ellipsoid and ends in `point`; it meets the axis `toward` there. With a the angle between `point` and the axis,
 * and b the angle from `point` to its horizon, that is at 1 / cos(a + b). */
static double horizon_distance(const double point[3], const double toward[3])
{
	double size = length(point), along = dot(point, toward) / size;
	double a = acos(fmin(fmax(along, -1), 1)), b = size > 1 ? acos(1 / size) : 0;
	return a + b < M_PI / 2 - 1e-6 ? fmin(1 / cos(a + b), NEVER_HIDDEN) : NEVER_HIDDEN;
}

static double height_of(const struct exchange_quantized *tile, size_t k)
{
	return tile->minimum + tile->unit * tile->heights[k];
}

static double longitude_of(const struct exchange_quantized *tile, size_t k)
{
	return tile->bounds[0] + (tile->bounds[2] - tile->bounds[0]) * (double)(k % EXCHANGE_SIDE) / EXCHANGE_CELLS;
}

static double latitude_of(const struct exchange_quantized *tile, size_t k)
{
	return tile->bounds[1] + (tile->bounds[3] - tile->bounds[1]) * (double)(k / EXCHANGE_SIDE) / EXCHANGE_CELLS;
}

static void fill_header(const struct exchange_quantized *tile, const struct exchange_frame *frame, struct header *header)
{
	/* Every fourth vertex each way, at the least and at the greatest height. The ground lies between these points. */
	enum { STRIDE = 4 };
	double low = INFINITY, high = -INFINITY;
	for (size_t k = 0; k < VERTICES; k++) {
		low = fmin(low, height_of(tile, k));
		high = fmax(high, height_of(tile, k));
	}
	header->minimum = (float)tile->minimum;
	header->maximum = (float)(tile->minimum + 32767 * tile->unit);
	exchange_frame_earth_centred(frame, (tile->bounds[0] + tile->bounds[2]) / 2, (tile->bounds[1] + tile->bounds[3]) / 2, (low + high) / 2,
				     header->centre);
	const double radii[] = {frame->semi_major, frame->semi_major, frame->semi_major * (1 - frame->flattening)};
	double toward[3], distance = 1;
	for (int c = 0; c < 3; c++)
		toward[c] = header->centre[c] / radii[c];
	double size = length(toward);
	for (int c = 0; c < 3; c++)
		toward[c] /= size;
	header->radius = 0;
	for (size_t j = 0; j < EXCHANGE_SIDE; j += STRIDE)
		for (size_t i = 0; i < EXCHANGE_SIDE; i += STRIDE)
			for (int top = 0; top < 2; top++) {
				size_t k = j * EXCHANGE_SIDE + i;
				double point[3], from[3];
				exchange_frame_earth_centred(frame, longitude_of(tile, k), latitude_of(tile, k), top ? high : low, point);
				for (int c = 0; c < 3; c++) {
					from[c] = point[c] - header->centre[c];
					point[c] /= radii[c];
				}
				header->radius = fmax(header->radius, length(from));
				distance = fmax(distance, horizon_distance(point, toward));
			}
	for (int c = 0; c < 3; c++) {
		header->sphere[c] = header->centre[c];
		header->horizon[c] = toward[c] * distance;
	}
}

/* --- the parts --- */

static enum status add_header(const struct exchange_quantized *tile, const struct exchange_frame *frame, struct exchange_bytes *out)
{
	struct header header;
	fill_header(tile, frame, &header);
	TRY(exchange_bytes_add(out, header.centre, sizeof header.centre));
	TRY(exchange_bytes_add(out, &header.minimum, sizeof header.minimum));
	TRY(exchange_bytes_add(out, &header.maximum, sizeof header.maximum));
	TRY(exchange_bytes_add(out, header.sphere, sizeof header.sphere));
	TRY(exchange_bytes_add(out, &header.radius, sizeof header.radius));
	return exchange_bytes_add(out, header.horizon, sizeof header.horizon);
}

static enum status add_count(struct exchange_bytes *out, uint32_t count)
{
	return exchange_bytes_add(out, &count, sizeof count);
}

static uint16_t zig_zag(int value)
{
	return (uint16_t)(value < 0 ? -2 * value - 1 : 2 * value);
}

/* A place along an edge: 0 to 64 as 0 to 32767. */
static int along(size_t at)
{
	return (int)((at * 32767 * 2 + EXCHANGE_CELLS) / (2 * EXCHANGE_CELLS));
}

static enum status add_vertices(const struct exchange_quantized *tile, const struct layout *layout, struct exchange_bytes *out)
{
	uint16_t parts[3][VERTICES];
	int last[3] = {0, 0, 0};
	for (size_t n = 0; n < VERTICES; n++) {
		size_t place = layout->place[n];
		const int now[] = {along(place % EXCHANGE_SIDE), along(place / EXCHANGE_SIDE), tile->heights[place]};
		for (int c = 0; c < 3; c++) {
			parts[c][n] = zig_zag(now[c] - last[c]);
			last[c] = now[c];
		}
	}
	TRY(add_count(out, VERTICES));
	return exchange_bytes_add(out, parts, sizeof parts);
}

static enum status add_triangles(const struct layout *layout, struct exchange_bytes *out)
{
	uint16_t codes[3 * TRIANGLES], next = 0;
	for (size_t k = 0; k < 3 * TRIANGLES; k++) {
		codes[k] = (uint16_t)(next - layout->indices[k]);
		next += codes[k] == 0;
	}
	TRY(add_count(out, TRIANGLES));
	return exchange_bytes_add(out, codes, sizeof codes);
}

/* West and east from the south, south and north from the west. */
static enum status add_edges(const struct layout *layout, struct exchange_bytes *out)
{
	for (int edge = 0; edge < 4; edge++) {
		uint16_t vertices[EXCHANGE_SIDE];
		for (size_t k = 0; k < EXCHANGE_SIDE; k++) {
			const size_t places[] = {k * EXCHANGE_SIDE, k, k * EXCHANGE_SIDE + EXCHANGE_CELLS, EXCHANGE_CELLS * EXCHANGE_SIDE + k};
			vertices[k] = layout->number[places[edge]];
		}
		TRY(add_count(out, EXCHANGE_SIDE));
		TRY(exchange_bytes_add(out, vertices, sizeof vertices));
	}
	return STATUS_OK;
}

static uint8_t to_byte(double value)
{
	return (uint8_t)nearbyint((fmin(fmax(value, -1), 1) + 1) / 2 * 255);
}

/* A unit vector as two bytes. It is projected to an octahedron, whose lower half is folded over the upper one (Cigolle and others,
 * Journal of Computer Graphics Techniques 3(2), 2014). */
static void oct_encode(const double normal[3], uint8_t out[2])
{
	double sum = fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]), x = normal[0] / sum, y = normal[1] / sum;
	if (normal[2] < 0) {
		double folded = (1 - fabs(y)) * (x < 0 ? -1 : 1);
		y = (1 - fabs(x)) * (y < 0 ? -1 : 1);
		x = folded;
	}
	out[0] = to_byte(x);
	out[1] = to_byte(y);
}

static enum status add_normals(const struct exchange_quantized *tile, const struct layout *layout, struct exchange_bytes *out)
{
	uint8_t normals[VERTICES][2], id = 1;
	double sine[2][EXCHANGE_SIDE], cosine[2][EXCHANGE_SIDE]; /* of longitudes and of latitudes */
	for (size_t k = 0; k < EXCHANGE_SIDE; k++)
		for (int c = 0; c < 2; c++) {
			double angle = (tile->bounds[c] + (tile->bounds[2 + c] - tile->bounds[c]) * (double)k / EXCHANGE_CELLS) * M_PI / 180;
			sine[c][k] = sin(angle);
			cosine[c][k] = cos(angle);
		}
	for (size_t n = 0; n < VERTICES; n++) {
		size_t place = layout->place[n], i = place % EXCHANGE_SIDE, j = place / EXCHANGE_SIDE;
		double e = -tile->slopes[place][0], u = -tile->slopes[place][1], size = sqrt(1 + e * e + u * u);
		/* From east, north and up to coordinates from the body's centre. */
		double outward = (cosine[1][j] - u * sine[1][j]) / size;
		const double normal[] = {outward * cosine[0][i] - e * sine[0][i] / size, outward * sine[0][i] + e * cosine[0][i] / size,
					 (sine[1][j] + u * cosine[1][j]) / size};
		oct_encode(normal, normals[n]);
	}
	TRY(exchange_bytes_add(out, &id, 1));
	TRY(add_count(out, sizeof normals));
	return exchange_bytes_add(out, normals, sizeof normals);
}

enum status exchange_quantized_write(const struct exchange_quantized *tile, const struct exchange_frame *frame, struct exchange_bytes *out)
{
	struct layout layout;
	make_layout(&layout);
	TRY(add_header(tile, frame, out));
	TRY(add_vertices(tile, &layout, out));
	TRY(add_triangles(&layout, out));
	TRY(add_edges(&layout, out));
	return add_normals(tile, &layout, out);
}
