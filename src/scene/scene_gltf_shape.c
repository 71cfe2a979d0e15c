/* The triangles that a glTF shows: accessors, the surfaces of meshes, and nodes. See scene_gltf.h. */
#include <string.h>

#include "scene/scene_gltf.h"

#define DEPTH_MAX 256 /* of nodes */

enum component { BYTE = 5120, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT = 5125, FLOAT };

struct accessor {
	const uint8_t *at; /* NULL: all are zero */
	size_t count, stride;
	int type; /* enum component */
	bool normalized;
	size_t changed_count; /* elements that have another value than at `at`; their numbers grow */
	const uint8_t *changed, *values;
	int changed_type;
};

/* A part of a mesh that has triangles. */
struct surface {
	struct accessor corners, numbers; /* numbers: of corners; count 0: corners follow each other */
	size_t mode, triangles;
};

struct part {
	const cJSON *children;
	size_t mesh; /* the number of meshes: it shows none */
	double place[3][4];
};

struct shapes {
	struct scene_gltf *gltf;
	struct surface *surfaces;
	size_t surface_count;
	size_t *firsts; /* of each mesh: its first surface; one more at the end */
	struct part *parts;
	size_t visited, triangles;
	struct mesh_corners *corners; /* NULL: triangles are only counted */
};

/* --- accessors --- */

static size_t component_bytes(size_t type)
{
	return type == BYTE || type == UNSIGNED_BYTE ? 1 : type == SHORT || type == UNSIGNED_SHORT ? 2 : type == UNSIGNED_INT || type == FLOAT ? 4 : 0;
}

static double component_at(const uint8_t *at, int type, bool normalized)
{
	int8_t i8;
	int16_t i16;
	uint16_t u16;
	uint32_t u32;
	float f;
	switch (type) {
	case BYTE:
		memcpy(&i8, at, sizeof i8);
		return normalized ? i8 / 127.0 : i8;
	case UNSIGNED_BYTE:
		return normalized ? *at / 255.0 : *at;
	case SHORT:
		memcpy(&i16, at, sizeof i16);
		return normalized ? i16 / 32767.0 : i16;
	case UNSIGNED_SHORT:
		memcpy(&u16, at, sizeof u16);
		return normalized ? u16 / 65535.0 : u16;
	case UNSIGNED_INT:
		memcpy(&u32, at, sizeof u32);
		return u32;
	default:
		memcpy(&f, at, sizeof f);
		return (double)f;
	}
}

static enum status take_changes(struct scene_gltf *gltf, const cJSON *sparse, size_t element, struct accessor *out)
{
	const cJSON *indices = cJSON_GetObjectItemCaseSensitive(sparse, "indices"), *values = cJSON_GetObjectItemCaseSensitive(sparse, "values");
	const size_t views = gltf->counts[SCENE_GLTF_VIEWS];
	size_t view[2], offset[2], type, stride;
	TRY(scene_gltf_whole(gltf, sparse, "count", 0, out->count + 1, &out->changed_count));
	for (int i = 0; i < 2; i++) {
		TRY(scene_gltf_whole(gltf, i == 0 ? indices : values, "bufferView", views, views, &view[i]));
		TRY(scene_gltf_whole(gltf, i == 0 ? indices : values, "byteOffset", 0, SCENE_MESH_BYTES, &offset[i]));
		if (view[i] == views)
			return scene_gltf_bad(gltf, "a sparse accessor names no buffer view");
	}
	TRY(scene_gltf_whole(gltf, indices, "componentType", 0, FLOAT, &type));
	if (component_bytes(type) == 0 || type == BYTE || type == SHORT)
		return scene_gltf_bad(gltf, "a sparse accessor counts in no whole numbers");
	out->changed_type = (int)type;
	TRY(scene_gltf_view(gltf, view[0], offset[0], out->changed_count, component_bytes(type), &out->changed, &stride));
	if (stride != component_bytes(type))
		return scene_gltf_bad(gltf, "a sparse accessor has a stride");
	TRY(scene_gltf_view(gltf, view[1], offset[1], out->changed_count, element, &out->values, &stride));
	return stride == element ? STATUS_OK : scene_gltf_bad(gltf, "a sparse accessor has a stride");
}

static enum status take_accessor(struct scene_gltf *gltf, size_t number, const char *wanted, struct accessor *out)
{
	const cJSON *object = gltf->lists[SCENE_GLTF_ACCESSORS][number], *type = cJSON_GetObjectItemCaseSensitive(object, "type"),
		    *sparse = cJSON_GetObjectItemCaseSensitive(object, "sparse");
	const size_t views = gltf->counts[SCENE_GLTF_VIEWS];
	size_t component, view, offset;
	*out = (struct accessor){.normalized = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, "normalized"))};
	if (!cJSON_IsString(type) || strcmp(type->valuestring, wanted) != 0)
		return scene_gltf_bad(gltf, "an accessor is no %s", wanted);
	TRY(scene_gltf_whole(gltf, object, "componentType", 0, FLOAT + 1, &component));
	TRY(scene_gltf_whole(gltf, object, "count", 0, SCENE_MESH_BYTES, &out->count));
	TRY(scene_gltf_whole(gltf, object, "bufferView", views, views, &view));
	TRY(scene_gltf_whole(gltf, object, "byteOffset", 0, SCENE_MESH_BYTES, &offset));
	if (component_bytes(component) == 0)
		return scene_gltf_bad(gltf, "an accessor has numbers of no known kind");
	out->type = (int)component;
	const size_t element = component_bytes(component) * (strcmp(wanted, "VEC3") == 0 ? 3 : 1);
	if (view < views)
		TRY(scene_gltf_view(gltf, view, offset, out->count, element, &out->at, &out->stride));
	return sparse != NULL ? take_changes(gltf, sparse, element, out) : STATUS_OK;
}

/* Gives an element of `parts` numbers. */
static void element_at(const struct accessor *accessor, size_t number, int parts, double *out)
{
	const size_t bytes = component_bytes((size_t)accessor->type), wide = component_bytes((size_t)accessor->changed_type);
	const uint8_t *at = accessor->at != NULL ? accessor->at + number * accessor->stride : NULL;
	size_t low = 0, high = accessor->changed_count;
	while (low < high) {
		const size_t middle = low + (high - low) / 2;
		const double found = component_at(accessor->changed + middle * wide, accessor->changed_type, false);
		if (found == (double)number)
			at = accessor->values + middle * bytes * (size_t)parts;
		low = found < (double)number ? middle + 1 : low;
		high = found < (double)number ? high : middle;
	}
	for (int i = 0; i < parts; i++)
		out[i] = at != NULL ? component_at(at + (size_t)i * bytes, accessor->type, accessor->normalized) : 0;
}

/* --- surfaces --- */

static enum status take_surface(struct scene_gltf *gltf, const cJSON *primitive, struct surface *out)
{
	const size_t accessors = gltf->counts[SCENE_GLTF_ACCESSORS];
	size_t position, numbers;
	TRY(scene_gltf_whole(gltf, cJSON_GetObjectItemCaseSensitive(primitive, "attributes"), "POSITION", accessors, accessors, &position));
	TRY(scene_gltf_whole(gltf, primitive, "indices", accessors, accessors, &numbers));
	TRY(scene_gltf_whole(gltf, primitive, "mode", 4, 7, &out->mode));
	if (position == accessors || out->mode < 4) /* points and lines */
		return STATUS_OK;
	TRY(take_accessor(gltf, position, "VEC3", &out->corners));
	if (numbers < accessors)
		TRY(take_accessor(gltf, numbers, "SCALAR", &out->numbers));
	if (out->corners.type == UNSIGNED_INT)
		return scene_gltf_bad(gltf, "its corners are whole numbers");
	if (numbers < accessors &&
	    (out->numbers.normalized || (out->numbers.type != UNSIGNED_BYTE && out->numbers.type != UNSIGNED_SHORT && out->numbers.type != UNSIGNED_INT)))
		return scene_gltf_bad(gltf, "its corners are not counted in whole numbers");
	const size_t count = numbers < accessors ? out->numbers.count : out->corners.count;
	out->triangles = out->mode == 4 ? count / 3 : count > 2 ? count - 2 : 0;
	if (numbers < accessors && out->numbers.count == 0)
		out->triangles = 0;
	return STATUS_OK;
}

static enum status take_surfaces(struct shapes *shapes)
{
	struct scene_gltf *gltf = shapes->gltf;
	const size_t meshes = gltf->counts[SCENE_GLTF_MESHES];
	size_t room = 0;
	shapes->firsts = mem_calloc(meshes + 1, sizeof *shapes->firsts);
	for (size_t i = 0; i < meshes; i++)
		room += (size_t)cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(gltf->lists[SCENE_GLTF_MESHES][i], "primitives"));
	shapes->surfaces = mem_calloc(room + 1, sizeof *shapes->surfaces);
	TRY_MEM(shapes->firsts != NULL && shapes->surfaces != NULL, "a mesh");
	for (size_t i = 0; i < meshes; i++) {
		const cJSON *primitive;
		cJSON_ArrayForEach(primitive, cJSON_GetObjectItemCaseSensitive(gltf->lists[SCENE_GLTF_MESHES][i], "primitives")) {
			struct surface *surface = &shapes->surfaces[shapes->surface_count];
			*surface = (struct surface){.triangles = 0};
			TRY(take_surface(gltf, primitive, surface));
			shapes->surface_count += surface->triangles > 0;
		}
		shapes->firsts[i + 1] = shapes->surface_count;
	}
	return STATUS_OK;
}

/* --- nodes --- */

/* Reads a list of numbers. Returns false if it is not there; STATUS_INPUT if it is no such list. */
static enum status take_numbers(const struct scene_gltf *gltf, const cJSON *node, const char *key, int count, double *out, bool *there)
{
	const cJSON *list = cJSON_GetObjectItemCaseSensitive(node, key), *item;
	int i = 0;
	*there = list != NULL;
	if (list == NULL)
		return STATUS_OK;
	if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != count)
		return scene_gltf_bad(gltf, "the %s of a node has not %d numbers", key, count);
	cJSON_ArrayForEach(item, list) {
		if (!cJSON_IsNumber(item))
			return scene_gltf_bad(gltf, "the %s of a node has not %d numbers", key, count);
		out[i++] = item->valuedouble;
	}
	return STATUS_OK;
}

static enum status take_place(const struct scene_gltf *gltf, const cJSON *node, double place[3][4])
{
	double matrix[16], move[3] = {0, 0, 0}, scale[3] = {1, 1, 1}, q[4] = {0, 0, 0, 1};
	bool whole, some;
	TRY(take_numbers(gltf, node, "matrix", 16, matrix, &whole));
	TRY(take_numbers(gltf, node, "translation", 3, move, &some));
	TRY(take_numbers(gltf, node, "scale", 3, scale, &some));
	TRY(take_numbers(gltf, node, "rotation", 4, q, &some));
	const double x = q[0], y = q[1], z = q[2], w = q[3];
	const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
				   {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
				   {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 4; k++)
			place[i][k] = whole ? matrix[4 * k + i] : k < 3 ? turn[i][k] * scale[k] : move[i];
	return STATUS_OK;
}

static enum status take_parts(struct shapes *shapes)
{
	struct scene_gltf *gltf = shapes->gltf;
	const size_t nodes = gltf->counts[SCENE_GLTF_NODES], meshes = gltf->counts[SCENE_GLTF_MESHES];
	TRY(mem_zeroed(&shapes->parts, nodes + 1, sizeof *shapes->parts, "a mesh"));
	for (size_t i = 0; i < nodes; i++) {
		const cJSON *node = gltf->lists[SCENE_GLTF_NODES][i];
		shapes->parts[i].children = cJSON_GetObjectItemCaseSensitive(node, "children");
		TRY(scene_gltf_whole(gltf, node, "mesh", meshes, meshes, &shapes->parts[i].mesh));
		TRY(take_place(gltf, node, shapes->parts[i].place));
	}
	return STATUS_OK;
}

static enum status take_corner(const struct shapes *shapes, const struct surface *surface, size_t number, const double place[3][4], double out[3])
{
	double corner = (double)number, v[3];
	if (surface->numbers.count > 0)
		element_at(&surface->numbers, number, 1, &corner);
	if (!(corner < (double)surface->corners.count))
		return fail_with(STATUS_INPUT, "%s: a triangle names vertex %.0f, and there are %zu; export the mesh again", shapes->gltf->told, corner,
				 surface->corners.count);
	element_at(&surface->corners, (size_t)corner, 3, v);
	for (int k = 0; k < 3; k++)
		out[k] = place[k][0] * v[0] + place[k][1] * v[1] + place[k][2] * v[2] + place[k][3];
	return STATUS_OK;
}

/* Which of a surface's corners are those of its triangle `t`. */
static void corners_of(size_t mode, size_t t, size_t corners[3])
{
	const size_t lists[] = {3 * t, 3 * t + 1, 3 * t + 2}, strip[] = {t % 2 == 0 ? t : t + 1, t % 2 == 0 ? t + 1 : t, t + 2}, fan[] = {0, t + 1, t + 2};
	memcpy(corners, mode == 4 ? lists : mode == 5 ? strip : fan, 3 * sizeof *corners);
}

static enum status take_triangles(struct shapes *shapes, const struct surface *surface, const double place[3][4])
{
	for (size_t t = 0; t < surface->triangles; t++) {
		size_t corners[3];
		corners_of(surface->mode, t, corners);
		for (int c = 0; c < 3; c++)
			TRY(take_corner(shapes, surface, corners[c], place, shapes->corners->at[3 * shapes->corners->triangles + (size_t)c]));
		shapes->corners->triangles++;
	}
	return STATUS_OK;
}

static enum status visit(struct shapes *shapes, const cJSON *number, const double above[3][4], int depth)
{
	const size_t nodes = shapes->gltf->counts[SCENE_GLTF_NODES];
	const double value = cJSON_IsNumber(number) ? number->valuedouble : -1;
	if (!(value >= 0 && value < (double)nodes && value == (double)(size_t)value))
		return scene_gltf_bad(shapes->gltf, "a node is named that is not there");
	if (depth == DEPTH_MAX || ++shapes->visited > SCENE_MESH_TRIANGLES)
		return fail_with(STATUS_INPUT, "%s: its nodes are too many or too deep; allowed: %u, %d deep", shapes->gltf->told, SCENE_MESH_TRIANGLES,
				 DEPTH_MAX);
	const struct part *part = &shapes->parts[(size_t)value];
	double place[3][4];
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 4; k++)
			place[i][k] = above[i][0] * part->place[0][k] + above[i][1] * part->place[1][k] + above[i][2] * part->place[2][k] +
				      (k == 3 ? above[i][3] : 0);
	if (part->mesh < shapes->gltf->counts[SCENE_GLTF_MESHES])
		for (size_t i = shapes->firsts[part->mesh]; i < shapes->firsts[part->mesh + 1]; i++) {
			shapes->triangles += shapes->surfaces[i].triangles;
			if (shapes->triangles > SCENE_MESH_TRIANGLES)
				return fail_with(STATUS_INPUT, "%s: it has more than %u triangles; give a coarser mesh", shapes->gltf->told,
						 SCENE_MESH_TRIANGLES);
			if (shapes->corners != NULL)
				TRY(take_triangles(shapes, &shapes->surfaces[i], (const double(*)[4])place));
		}
	const cJSON *child;
	cJSON_ArrayForEach(child, part->children)
		TRY(visit(shapes, child, (const double(*)[4])place, depth + 1));
	return STATUS_OK;
}

static enum status visit_all(struct shapes *shapes, struct mesh_corners *corners)
{
	static const double as_it_is[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
	struct scene_gltf *gltf = shapes->gltf;
	const size_t scenes = gltf->counts[SCENE_GLTF_SCENES];
	size_t scene;
	if (scenes == 0)
		return scene_gltf_bad(gltf, "it has no scene");
	TRY(scene_gltf_whole(gltf, gltf->root, "scene", 0, scenes, &scene));
	shapes->visited = shapes->triangles = 0;
	shapes->corners = corners;
	const cJSON *node;
	cJSON_ArrayForEach(node, cJSON_GetObjectItemCaseSensitive(gltf->lists[SCENE_GLTF_SCENES][scene], "nodes"))
		TRY(visit(shapes, node, as_it_is, 0));
	return STATUS_OK;
}

enum status scene_gltf_triangles(struct scene_gltf *gltf, struct mesh_corners *corners)
{
	struct shapes shapes = {.gltf = gltf};
	enum status status;
	TRY_OR(done, take_surfaces(&shapes));
	TRY_OR(done, take_parts(&shapes));
	TRY_OR(done, visit_all(&shapes, NULL));
	corners->at = mem_alloc(3 * shapes.triangles + 1, sizeof *corners->at);
	TRY_OR(done, corners->at != NULL ? visit_all(&shapes, corners) : fail_memory("a mesh"));
	if (corners->triangles == 0)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: it has no triangle; needed: a surface of triangles", gltf->told));
done:
	mem_free_all(shapes.surfaces, shapes.firsts, shapes.parts);
	return status;
}
