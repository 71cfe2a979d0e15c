/*
 * glTF 2.0 binary: a header, a chunk of JSON, and a chunk of bytes. The bytes are position, normal and place in the picture of each
 * vertex, then indices, then the picture.
 *
 * glTF is y up: x is east, y up, z south. `extras` has the origin in doubles, so that positions are small floats. The node has the same, since Blender and
 * others keep what nodes have, and lose what the file has.
 */
#include "exchange/mesh.h"

#include <cJSON.h>
#include <string.h>

#define VERTEX_BYTES 32
#define VERTEX_FLOATS 8
#define FLOATS 5126
#define WHOLE_32 5125
#define VERTEX_BUFFER 34962
#define INDEX_BUFFER 34963
#define LINEAR 9729
#define LINEAR_MIPMAP_LINEAR 9987
#define CLAMP_TO_EDGE 33071
#define SRS_MOST 8192

static const char zeros[4];

struct glb {
	struct exchange_surface *surface;
	struct exchange_texture texture;
};

static double vertices_of(const struct glb *glb)
{
	return (double)glb->surface->first[glb->surface->rows];
}

static double index_bytes(const struct glb *glb)
{
	return 12 * (double)glb->surface->triangles;
}

static size_t texture_padding(const struct glb *glb)
{
	return (4 - glb->texture.bytes % 4) % 4;
}

static double body_bytes(const struct glb *glb)
{
	return VERTEX_BYTES * vertices_of(glb) + index_bytes(glb) + (double)(glb->texture.bytes + texture_padding(glb));
}

/* The JSON has at most 64 kB. A picture has a byte for each colour, if it does not shrink. */
static double bytes_of(double vertices, double triangles)
{
	return 65536 + 3.1 * EXCHANGE_TEXTURE_SIDE * EXCHANGE_TEXTURE_SIDE + VERTEX_BYTES * vertices + 12 * triangles;
}

static cJSON *add_object(cJSON *array)
{
	cJSON *object = cJSON_CreateObject();
	cJSON_AddItemToArray(array, object);
	return object;
}

/* Adds an array `name` with one object. */
static cJSON *add_only(cJSON *root, const char *name)
{
	return add_object(cJSON_AddArrayToObject(root, name));
}

static cJSON *add_view(cJSON *views, double offset, double length, int target)
{
	cJSON *view = add_object(views);
	cJSON_AddNumberToObject(view, "buffer", 0);
	cJSON_AddNumberToObject(view, "byteOffset", offset);
	cJSON_AddNumberToObject(view, "byteLength", length);
	if (target != 0)
		cJSON_AddNumberToObject(view, "target", target);
	return view;
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

static void add_mesh(cJSON *root, const char *name)
{
	cJSON *mesh = add_only(root, "meshes"), *primitive = add_only(mesh, "primitives");
	cJSON *attributes = cJSON_AddObjectToObject(primitive, "attributes");
	cJSON_AddStringToObject(mesh, "name", name);
	cJSON_AddNumberToObject(attributes, "POSITION", 0);
	cJSON_AddNumberToObject(attributes, "NORMAL", 1);
	cJSON_AddNumberToObject(attributes, "TEXCOORD_0", 2);
	cJSON_AddNumberToObject(primitive, "indices", 3);
	cJSON_AddNumberToObject(primitive, "mode", 4);
	cJSON_AddNumberToObject(primitive, "material", 0);
}

/* Rough ground in the picture's colours. The image is in bufferView 2. */
static void add_material(cJSON *root, const char *name)
{
	cJSON *material = add_only(root, "materials");
	cJSON_AddStringToObject(material, "name", name);
	cJSON *looks = cJSON_AddObjectToObject(material, "pbrMetallicRoughness");
	cJSON_AddNumberToObject(cJSON_AddObjectToObject(looks, "baseColorTexture"), "index", 0);
	cJSON_AddNumberToObject(looks, "metallicFactor", 0);
	cJSON_AddNumberToObject(looks, "roughnessFactor", 1);
	cJSON *texture = add_only(root, "textures"), *sampler = add_only(root, "samplers"), *image = add_only(root, "images");
	cJSON_AddNumberToObject(texture, "source", 0);
	cJSON_AddNumberToObject(texture, "sampler", 0);
	cJSON_AddNumberToObject(sampler, "magFilter", LINEAR);
	cJSON_AddNumberToObject(sampler, "minFilter", LINEAR_MIPMAP_LINEAR);
	cJSON_AddNumberToObject(sampler, "wrapS", CLAMP_TO_EDGE);
	cJSON_AddNumberToObject(sampler, "wrapT", CLAMP_TO_EDGE);
	cJSON_AddStringToObject(image, "name", name);
	cJSON_AddNumberToObject(image, "bufferView", 2);
	cJSON_AddStringToObject(image, "mimeType", "image/png");
}

/* Floats as the file has them, so that the bounds are those of the positions. */
static void add_bounds(cJSON *accessor, const struct exchange_surface *surface)
{
	double low[3], high[3], corner[2][3];
	for (int c = 0; c < 3; c++) {
		corner[0][c] = (float)surface->low[c];
		corner[1][c] = (float)surface->high[c];
	}
	exchange_surface_turn(surface, corner[0], low);
	exchange_surface_turn(surface, corner[1], high);
	for (int c = 0; c < 3; c++)
		if (low[c] > high[c]) {
			double greater = low[c];
			low[c] = high[c];
			high[c] = greater;
		}
	cJSON_AddItemToObject(accessor, "min", cJSON_CreateDoubleArray(low, 3));
	cJSON_AddItemToObject(accessor, "max", cJSON_CreateDoubleArray(high, 3));
}

static void add_extras(cJSON *object, const struct exchange_surface *surface)
{
	const struct store_meta *meta = surface->params->meta;
	const struct post_rect *rect = &surface->params->rect;
	cJSON *extras = cJSON_AddObjectToObject(object, "extras");
	/* In the SRS, or in metres from the south-west post; then the height. */
	double origin[3] = {surface->origin[0] + meta->origin[0], surface->origin[1] + meta->origin[1], surface->origin[2]};
	double window[4] = {(double)rect->x0 * surface->spacing, (double)rect->y0 * surface->spacing, (double)(rect->x1 - 1) * surface->spacing,
			    (double)(rect->y1 - 1) * surface->spacing};
	cJSON_AddItemToObject(extras, "origin", cJSON_CreateDoubleArray(origin, 3));
	cJSON_AddStringToObject(extras, "axes", "x east, y up, z south; metres from origin [east, north, height]");
	cJSON_AddStringToObject(extras, "srs", strlen(meta->srs) < SRS_MOST ? meta->srs : "");
	cJSON_AddStringToObject(extras, "vertical", meta->vertical);
	cJSON_AddNumberToObject(extras, "spacing", surface->spacing);
	cJSON_AddNumberToObject(extras, "level", surface->params->level);
	cJSON_AddItemToObject(extras, "window", cJSON_CreateDoubleArray(window, 4));
}

static void add_scene(cJSON *root, const struct exchange_surface *surface)
{
	const double zero = 0;
	cJSON_AddNumberToObject(root, "scene", 0);
	cJSON_AddItemToObject(add_only(root, "scenes"), "nodes", cJSON_CreateDoubleArray(&zero, 1));
	cJSON *node = add_only(root, "nodes");
	cJSON_AddStringToObject(node, "name", surface->name);
	cJSON_AddNumberToObject(node, "mesh", 0);
	add_extras(node, surface);
}

static char *describe(const struct glb *glb)
{
	const struct exchange_surface *surface = glb->surface;
	const double vertices = vertices_of(glb), vertex_bytes = VERTEX_BYTES * vertices;
	cJSON *root = cJSON_CreateObject(), *asset = cJSON_AddObjectToObject(root, "asset");
	cJSON_AddStringToObject(asset, "version", "2.0");
	cJSON_AddStringToObject(asset, "generator", "furrow " FURROW_VERSION);
	add_scene(root, surface);
	add_mesh(root, surface->name);
	add_material(root, surface->name);
	cJSON *accessors = cJSON_AddArrayToObject(root, "accessors");
	add_bounds(add_accessor(accessors, 0, 0, FLOATS, vertices, "VEC3"), surface);
	add_accessor(accessors, 0, 12, FLOATS, vertices, "VEC3");
	add_accessor(accessors, 0, 24, FLOATS, vertices, "VEC2");
	add_accessor(accessors, 1, 0, WHOLE_32, 3 * (double)surface->triangles, "SCALAR");
	cJSON *views = cJSON_AddArrayToObject(root, "bufferViews");
	cJSON_AddNumberToObject(add_view(views, 0, vertex_bytes, VERTEX_BUFFER), "byteStride", VERTEX_BYTES);
	add_view(views, vertex_bytes, index_bytes(glb), INDEX_BUFFER);
	add_view(views, vertex_bytes + index_bytes(glb), (double)glb->texture.bytes, 0);
	cJSON_AddNumberToObject(add_only(root, "buffers"), "byteLength", body_bytes(glb));
	add_extras(root, surface);
	char *text = cJSON_PrintUnformatted(root);
	cJSON_Delete(root);
	return text;
}

static enum status put_vertices(void *user, const struct exchange_row *row)
{
	const struct glb *glb = user;
	for (int64_t x = 0; x < row->width; x++) {
		if (!exchange_row_used(row, x, 0))
			continue;
		double at[3], normal[3], turned[2][3], place[2];
		float numbers[VERTEX_FLOATS];
		exchange_surface_position(glb->surface, row, x, at);
		exchange_row_normal(row, x, glb->surface->spacing, normal);
		exchange_surface_turn(glb->surface, at, turned[0]);
		exchange_surface_turn(glb->surface, normal, turned[1]);
		exchange_texture_place(&glb->texture, x, row->y, place);
		for (int c = 0; c < 6; c++)
			numbers[c] = (float)turned[c / 3][c % 3];
		numbers[6] = (float)place[0];
		numbers[7] = (float)(1 - place[1]); /* glTF counts from the upper edge */
		TRY(exchange_surface_put(glb->surface, numbers, sizeof numbers));
	}
	return STATUS_OK;
}

static enum status put_triangle(void *user, const struct exchange_row *row, int64_t x, const int corners[3], const uint64_t vertices[3])
{
	const uint32_t numbers[] = {(uint32_t)vertices[0], (uint32_t)vertices[1], (uint32_t)vertices[2]};
	(void)row, (void)x, (void)corners;
	return exchange_surface_put(user, numbers, sizeof numbers);
}

static enum status write_json(const struct glb *glb, const char *json)
{
	uint32_t text = (uint32_t)strlen(json), padded = (text + 3) / 4 * 4, body = (uint32_t)body_bytes(glb);
	const uint32_t header[] = {0x46546c67 /* glTF */, 2, 12 + 8 + padded + 8 + body, padded, 0x4e4f534a /* JSON */};
	const uint32_t second[] = {body, 0x004e4942 /* BIN */};
	TRY(exchange_surface_put(glb->surface, header, sizeof header));
	TRY(exchange_surface_put(glb->surface, json, text));
	TRY(exchange_surface_put(glb->surface, "   ", padded - text));
	return exchange_surface_put(glb->surface, second, sizeof second);
}

static enum status write_all(struct glb *glb)
{
	char *json = describe(glb);
	TRY_MEM(json, glb->surface->params->path);
	enum status status = write_json(glb, json);
	cJSON_free(json);
	TRY(status);
	TRY(exchange_surface_each(glb->surface, put_vertices, glb));
	TRY(exchange_surface_triangles(glb->surface, put_triangle, glb->surface));
	TRY(exchange_surface_put(glb->surface, glb->texture.png, glb->texture.bytes));
	return exchange_surface_put(glb->surface, zeros, texture_padding(glb));
}

static enum status write_glb(struct exchange_surface *surface)
{
	struct glb glb = {.surface = surface};
	TRY(exchange_texture_create(surface->params, &glb.texture));
	const enum status status = write_all(&glb);
	exchange_texture_finish(&glb.texture);
	return status;
}

const struct exchange_mesh_format exchange_glb = {".glb", true, 2, bytes_of, write_glb};
