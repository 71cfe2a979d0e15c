/*
 * glTF 2.0 binary: a header, a chunk of JSON, and a chunk of numbers: positions and normals of each vertex, then indices.
 *
 * glTF is y up: x is east, y up, z south. `extras` has the origin in doubles, so that positions are small floats.
 */
#include "exchange/mesh.h"

#include <cJSON.h>
#include <string.h>

#define VERTEX_BYTES 24
#define FLOATS 5126
#define WHOLE_32 5125
#define VERTEX_BUFFER 34962
#define INDEX_BUFFER 34963

static double body_bytes(const struct exchange_surface *surface)
{
	return VERTEX_BYTES * (double)surface->first[surface->rows] + 12 * (double)surface->triangles;
}

/* The JSON has at most 16 kB. */
static double bytes_of(double vertices, double triangles)
{
	return 16384 + VERTEX_BYTES * vertices + 12 * triangles;
}

/* East, north, up as glTF has them. */
static void y_up(const double from[3], double to[3])
{
	to[0] = from[0];
	to[1] = from[2];
	to[2] = 0 - from[1]; /* never -0 */
}

static cJSON *add_object(cJSON *array)
{
	cJSON *object = cJSON_CreateObject();
	cJSON_AddItemToArray(array, object);
	return object;
}

static void add_view(cJSON *views, double offset, double length, int stride, int target)
{
	cJSON *view = add_object(views);
	cJSON_AddNumberToObject(view, "buffer", 0);
	cJSON_AddNumberToObject(view, "byteOffset", offset);
	cJSON_AddNumberToObject(view, "byteLength", length);
	if (stride > 0)
		cJSON_AddNumberToObject(view, "byteStride", stride);
	cJSON_AddNumberToObject(view, "target", target);
}

static cJSON *add_accessor(cJSON *accessors, int view, double offset, int type, double count, const char *shape)
{
	cJSON *accessor = add_object(accessors);
	cJSON_AddNumberToObject(accessor, "bufferView", view);
	cJSON_AddNumberToObject(accessor, "byteOffset", offset);
	cJSON_AddNumberToObject(accessor, "componentType", type);
	cJSON_AddNumberToObject(accessor, "count", count);
	cJSON_AddStringToObject(accessor, "type", shape);
	return accessor;
}

static void add_mesh(cJSON *root)
{
	cJSON *primitive = add_object(cJSON_AddArrayToObject(add_object(cJSON_AddArrayToObject(root, "meshes")), "primitives"));
	cJSON *attributes = cJSON_AddObjectToObject(primitive, "attributes");
	cJSON_AddNumberToObject(attributes, "POSITION", 0);
	cJSON_AddNumberToObject(attributes, "NORMAL", 1);
	cJSON_AddNumberToObject(primitive, "indices", 2);
	cJSON_AddNumberToObject(primitive, "mode", 4);
}

/* Floats as the file has them, so that the bounds are those of the positions. */
static void add_bounds(cJSON *accessor, const struct exchange_surface *surface)
{
	double low[3], high[3], corner[2][3];
	for (int c = 0; c < 3; c++) {
		corner[0][c] = (float)surface->low[c];
		corner[1][c] = (float)surface->high[c];
	}
	y_up(corner[0], low);
	y_up(corner[1], high);
	for (int c = 0; c < 3; c++)
		if (low[c] > high[c]) {
			double greater = low[c];
			low[c] = high[c];
			high[c] = greater;
		}
	cJSON_AddItemToObject(accessor, "min", cJSON_CreateDoubleArray(low, 3));
	cJSON_AddItemToObject(accessor, "max", cJSON_CreateDoubleArray(high, 3));
}

static char *describe(const struct exchange_surface *surface)
{
	const struct store_meta *meta = surface->params->meta;
	double vertices = (double)surface->first[surface->rows], vertex_bytes = VERTEX_BYTES * vertices, zero = 0;
	cJSON *root = cJSON_CreateObject(), *asset = cJSON_AddObjectToObject(root, "asset");
	cJSON_AddStringToObject(asset, "version", "2.0");
	cJSON_AddStringToObject(asset, "generator", "furrow " FURROW_VERSION);
	cJSON_AddNumberToObject(root, "scene", 0);
	cJSON_AddItemToObject(add_object(cJSON_AddArrayToObject(root, "scenes")), "nodes", cJSON_CreateDoubleArray(&zero, 1));
	cJSON_AddNumberToObject(add_object(cJSON_AddArrayToObject(root, "nodes")), "mesh", 0);
	add_mesh(root);
	cJSON *accessors = cJSON_AddArrayToObject(root, "accessors");
	add_bounds(add_accessor(accessors, 0, 0, FLOATS, vertices, "VEC3"), surface);
	add_accessor(accessors, 0, 12, FLOATS, vertices, "VEC3");
	add_accessor(accessors, 1, 0, WHOLE_32, 3 * (double)surface->triangles, "SCALAR");
	cJSON *views = cJSON_AddArrayToObject(root, "bufferViews");
	add_view(views, 0, vertex_bytes, VERTEX_BYTES, VERTEX_BUFFER);
	add_view(views, vertex_bytes, 12 * (double)surface->triangles, 0, INDEX_BUFFER);
	cJSON_AddNumberToObject(add_object(cJSON_AddArrayToObject(root, "buffers")), "byteLength", body_bytes(surface));
	cJSON *extras = cJSON_AddObjectToObject(root, "extras");
	/* In the SRS, or in metres from the south-west post; then the height. */
	double origin[3] = {surface->origin[0] + meta->origin[0], surface->origin[1] + meta->origin[1], surface->origin[2]};
	cJSON_AddItemToObject(extras, "origin", cJSON_CreateDoubleArray(origin, 3));
	cJSON_AddStringToObject(extras, "axes", "x east, y up, z south; metres from origin [east, north, height]");
	cJSON_AddStringToObject(extras, "srs", strlen(meta->srs) < 8192 ? meta->srs : "");
	cJSON_AddNumberToObject(extras, "spacing", surface->spacing);
	cJSON_AddNumberToObject(extras, "level", surface->params->level);
	char *text = cJSON_PrintUnformatted(root);
	cJSON_Delete(root);
	return text;
}

static enum status put_vertices(void *user, const struct exchange_row *row)
{
	struct exchange_surface *surface = user;
	for (int64_t x = 0; x < row->width; x++) {
		if (!exchange_row_used(row, x, 0))
			continue;
		double at[3], normal[3], turned[2][3];
		float numbers[6];
		exchange_surface_position(surface, row, x, at);
		exchange_row_normal(row, x, surface->spacing, normal);
		y_up(at, turned[0]);
		y_up(normal, turned[1]);
		for (int c = 0; c < 6; c++)
			numbers[c] = (float)turned[c / 3][c % 3];
		TRY(exchange_surface_put(surface, numbers, sizeof numbers));
	}
	return STATUS_OK;
}

static enum status put_triangle(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3])
{
	const uint32_t numbers[] = {(uint32_t)vertices[0], (uint32_t)vertices[1], (uint32_t)vertices[2]};
	(void)row, (void)x, (void)corners;
	return exchange_surface_put(user, numbers, sizeof numbers);
}

static enum status write_json(struct exchange_surface *surface, const char *json)
{
	uint32_t text = (uint32_t)strlen(json), padded = (text + 3) / 4 * 4, body = (uint32_t)body_bytes(surface);
	const uint32_t header[] = {0x46546c67 /* glTF */, 2, 12 + 8 + padded + 8 + body, padded, 0x4e4f534a /* JSON */};
	const uint32_t second[] = {body, 0x004e4942 /* BIN */};
	TRY(exchange_surface_put(surface, header, sizeof header));
	TRY(exchange_surface_put(surface, json, text));
	TRY(exchange_surface_put(surface, "   ", padded - text));
	return exchange_surface_put(surface, second, sizeof second);
}

static enum status write_glb(struct exchange_surface *surface)
{
	char *json = describe(surface);
	TRY_MEM(json, surface->params->path);
	enum status status = write_json(surface, json);
	cJSON_free(json);
	TRY(status);
	TRY(exchange_surface_each(surface, put_vertices, surface));
	return exchange_surface_triangles(surface, put_triangle, surface);
}

const struct exchange_mesh_format exchange_glb = {".glb", 2, bytes_of, write_glb};
