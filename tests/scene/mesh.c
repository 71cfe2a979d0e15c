/* Meshes: what three formats become, and what is refused of a file that nobody trusts. */
#include <math.h>

#include "fixture.h"
#include "scene/scene_mesh.h"
#include "../support/program.h"
#include "../support/skip.h"

/* A wedge, 2 forward, 1 left, 3 up. */
static const float wedge[6][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {0, 0, 3}, {0, 1, 3}};
static const int sides[8][3] = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {3, 5, 2}, {0, 4, 5}, {0, 5, 3}, {1, 2, 5}, {1, 5, 4}};

struct bytes {
	unsigned char *at;
	size_t length, room;
};

static void add(struct bytes *bytes, const void *more, size_t length)
{
	if (bytes->length + length + 1 > bytes->room) {
		bytes->room = 2 * (bytes->length + length + 1);
		bytes->at = realloc(bytes->at, bytes->room);
		if (bytes->at == NULL)
			abort();
	}
	memcpy(bytes->at + bytes->length, more, length);
	bytes->length += length;
	bytes->at[bytes->length] = '\0';
}

#define ADD(bytes, ...)                                                                            \
	do {                                                                                       \
		char text_[4096];                                                                  \
		add(bytes, text_, (size_t)snprintf(text_, sizeof text_, __VA_ARGS__));             \
	} while (0)

static struct bytes obj_wedge(void)
{
	struct bytes obj = {NULL, 0, 0};
	ADD(&obj, "# a wedge\nmtllib none.mtl\no wedge\n");
	for (int v = 0; v < 6; v++)
		ADD(&obj, "v %g %g %g\n", (double)wedge[v][0], (double)wedge[v][1], (double)wedge[v][2]);
	ADD(&obj, "f 1 4 3 2\nf 1 2 5\nf 4 6 3\nf 1 5 6 4\nf 2 3 6 5\n"); /* quads among them */
	return obj;
}

static struct bytes ascii_wedge(void)
{
	struct bytes stl = {NULL, 0, 0};
	ADD(&stl, "solid wedge\n");
	for (int t = 0; t < 8; t++) {
		ADD(&stl, "facet normal 0 0 0\nouter loop\n");
		for (int c = 0; c < 3; c++)
			ADD(&stl, "vertex %g %g %g\n", (double)wedge[sides[t][c]][0], (double)wedge[sides[t][c]][1],
			    (double)wedge[sides[t][c]][2]);
		ADD(&stl, "endloop\nendfacet\n");
	}
	ADD(&stl, "endsolid wedge\n");
	return stl;
}

static struct bytes binary_stl(const float (*corners)[3], uint32_t triangles)
{
	struct bytes stl = {NULL, 0, 0};
	char head[80] = "wedge";
	const float normal[3] = {0, 0, 0};
	const uint16_t rest = 0;
	add(&stl, head, sizeof head);
	add(&stl, &triangles, sizeof triangles);
	for (uint32_t i = 0; i < triangles; i++) {
		add(&stl, normal, sizeof normal);
		add(&stl, corners[3 * i], 3 * sizeof *corners);
		add(&stl, &rest, sizeof rest);
	}
	return stl;
}

static struct bytes binary_wedge(void)
{
	float corners[24][3];
	for (int i = 0; i < 24; i++)
		memcpy(corners[i], wedge[sides[i / 3][i % 3]], sizeof corners[i]);
	return binary_stl((const float(*)[3])corners, 8);
}

/* The wedge as a glTF has it: left, up, front. */
static struct bytes gltf_buffer(void)
{
	struct bytes buffer = {NULL, 0, 0};
	for (int v = 0; v < 6; v++)
		add(&buffer, (const float[3]){wedge[v][1], wedge[v][2], wedge[v][0]}, 3 * sizeof(float));
	for (int i = 0; i < 24; i++)
		add(&buffer, &(const uint16_t){(uint16_t)sides[i / 3][i % 3]}, sizeof(uint16_t));
	return buffer; /* 72 + 48 bytes */
}

#define ACCESSORS                                                                                                  \
	"\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":72},{\"buffer\":0,\"byteOffset\":72,"      \
	"\"byteLength\":48}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":6,\"type\":\"VEC3\"," \
	"\"min\":[0,0,0],\"max\":[1,3,2]},{\"bufferView\":1,\"componentType\":5123,\"count\":24,\"type\":\"SCALAR\"}],"
#define GLTF                                                                                                       \
	"{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"      \
	"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]," ACCESSORS               \
	"\"buffers\":[{\"byteLength\":120,\"uri\":\"wedge.bin\"}]}"

static struct bytes text_of(const char *text)
{
	struct bytes bytes = {NULL, 0, 0};
	add(&bytes, text, strlen(text));
	return bytes;
}

static struct bytes glb(const char *json, struct bytes buffer)
{
	struct bytes all = {NULL, 0, 0}, text = text_of(json);
	while (text.length % 4 != 0)
		add(&text, " ", 1);
	const uint32_t head[] = {0x46546c67, 2, (uint32_t)(12 + 8 + text.length + 8 + buffer.length), (uint32_t)text.length,
				 0x4e4f534a};
	const uint32_t second[] = {(uint32_t)buffer.length, 0x004e4942};
	add(&all, head, sizeof head);
	add(&all, text.at, text.length);
	add(&all, second, sizeof second);
	add(&all, buffer.at, buffer.length);
	free(text.at);
	return all;
}

static enum status load_scaled(const char *name, struct bytes bytes, double scale, struct soil_mesh **mesh)
{
	if (bytes.length > 0)
		write_bytes(name, bytes.at, bytes.length);
	else
		write_text(name, "");
	enum status status = scene_mesh_load(in_folder(name), "scene.yaml:5: objects[0].shape.mesh.file", scale, mesh);
	unlink(in_folder(name));
	if (status != STATUS_OK && strstr(failure_message(), "this build reads no meshes") != NULL)
		skip_since("this build reads no meshes");
	return status;
}

static struct soil_mesh *loaded(const char *name, struct bytes bytes)
{
	struct soil_mesh *mesh;
	if (load_scaled(name, bytes, 1, &mesh) != STATUS_OK)
		fail_msg("%s: %s", name, failure_message());
	free(bytes.at);
	return mesh;
}

/* Every triangle of the wedge, as often as it is there, whatever the order and the first corner. */
static void assert_wedge(const struct soil_mesh *mesh)
{
	bool seen[6] = {false};
	double volume = 0;
	assert_int_equal(mesh->vertex_count, 6);
	assert_int_equal(mesh->triangle_count, 8);
	for (uint32_t v = 0; v < 6; v++)
		for (int w = 0; w < 6; w++)
			seen[w] = seen[w] || memcmp(mesh->vertices[v], wedge[w], sizeof wedge[w]) == 0;
	for (int w = 0; w < 6; w++)
		assert_true(seen[w]);
	for (uint32_t t = 0; t < 8; t++) {
		const float *a = mesh->vertices[mesh->triangles[t][0]], *b = mesh->vertices[mesh->triangles[t][1]],
			    *c = mesh->vertices[mesh->triangles[t][2]];
		for (int k = 0; k < 3; k++)
			volume += (double)a[k] * ((double)b[(k + 1) % 3] * c[(k + 2) % 3] - (double)b[(k + 2) % 3] * c[(k + 1) % 3]) / 6;
	}
	assert_true(fabs(volume - 3) < 1e-6); /* its axes are turned, not mirrored */
	assert_true(mesh->low[0] == 0 && mesh->low[1] == 0 && mesh->low[2] == 0);
	assert_true(mesh->high[0] == 2 && mesh->high[1] == 1 && mesh->high[2] == 3);
}

static void every_format_is_the_same_wedge(void **state)
{
	struct bytes buffer = gltf_buffer();
	char embedded[] = GLTF;
	char *inside = edited(embedded, ",\"uri\":\"wedge.bin\"", "");
	struct bytes files[] = {obj_wedge(), ascii_wedge(), binary_wedge(), glb(inside, buffer), text_of(GLTF)};
	const char *const names[] = {"a.obj", "a.stl", "B.STL", "a.glb", "a.gltf"};
	free(inside);
	write_bytes("wedge.bin", buffer.at, buffer.length);
	free(buffer.at);
	for (size_t i = 0; i < 5; i++) {
		struct soil_mesh *mesh = loaded(names[i], files[i]);
		assert_wedge(mesh);
		scene_mesh_destroy(mesh);
	}
	unlink(in_folder("wedge.bin"));
}

static void nodes_place_what_they_show(void **state)
{
	/* Twice, once moved: up by 10 in the glTF is up by 10. */
	struct bytes buffer = gltf_buffer();
	char *json = edited(GLTF, "\"nodes\":[{\"mesh\":0}]",
			    "\"nodes\":[{\"children\":[1,2],\"translation\":[0,5,0]},{\"mesh\":0},{\"mesh\":0,\"translation\":[0,5,0]}]");
	char *inside = edited(json, ",\"uri\":\"wedge.bin\"", "");
	struct soil_mesh *mesh = loaded("a.glb", glb(inside, buffer));
	assert_int_equal(mesh->triangle_count, 16);
	assert_int_equal(mesh->vertex_count, 12);
	assert_true(mesh->low[2] == 5 && mesh->high[2] == 13);
	scene_mesh_destroy(mesh);
	free(inside);
	free(json);
	free(buffer.at);
}

static void a_scale_makes_metres(void **state)
{
	struct bytes obj = obj_wedge();
	struct soil_mesh *mesh;
	assert_int_equal(load_scaled("a.obj", obj, 0.001, &mesh), STATUS_OK);
	assert_true(fabs(mesh->high[2] - 0.003) < 1e-9);
	scene_mesh_destroy(mesh);
	assert_int_equal(load_scaled("a.obj", obj, 0.0001, &mesh), STATUS_INPUT);
	assert_says("allowed: 0.001 to 1000 m");
	assert_int_equal(load_scaled("a.obj", obj, 1000, &mesh), STATUS_INPUT);
	assert_says("too far out");
	assert_int_equal(load_scaled("a.obj", obj, 330, &mesh), STATUS_OK);
	scene_mesh_destroy(mesh);
	free(obj.at);
}

static void points_lines_and_slivers_are_left_out(void **state)
{
	struct bytes obj = obj_wedge();
	ADD(&obj, "v 9 9 9\np 7\nl 1 7\nf 1 1 2\nf 1 2 2\n");
	ADD(&obj, "v 1 0 0\nf 1 8 2\n"); /* three in a row */
	struct soil_mesh *mesh = loaded("a.obj", obj);
	assert_wedge(mesh);
	scene_mesh_destroy(mesh);
}

static void the_order_is_the_files(void **state)
{
	struct soil_mesh *a = loaded("a.stl", binary_wedge()), *b = loaded("a.stl", binary_wedge());
	for (int t = 0; t < 8; t++)
		for (int c = 0; c < 3; c++)
			assert_memory_equal(a->vertices[a->triangles[t][c]], wedge[sides[t][c]], sizeof wedge[0]);
	assert_memory_equal(a->vertices, b->vertices, 6 * sizeof *a->vertices);
	assert_memory_equal(a->triangles, b->triangles, 8 * sizeof *a->triangles);
	scene_mesh_destroy(a);
	scene_mesh_destroy(b);
}

static void refused(const char *name, struct bytes bytes, const char *why)
{
	struct soil_mesh *mesh;
	if (load_scaled(name, bytes, 1, &mesh) != STATUS_INPUT)
		fail_msg("%s, %zu bytes, was taken, or failed otherwise", name, bytes.length);
	assert_says("scene.yaml:5: objects[0].shape.mesh.file: ");
	assert_says(why);
	free(bytes.at);
}

static void what_is_no_surface_is_refused(void **state)
{
	struct soil_mesh *mesh;
	enum status status = scene_mesh_load(in_folder("none.stl"), "file", 1, &mesh);
	assert_int_equal(status, STATUS_INPUT);
	if (strstr(failure_message(), "this build reads no meshes") != NULL)
		skip_since("this build reads no meshes");
	assert_says("file: No such file");
	refused("a.ply", obj_wedge(), "allowed: .obj, .stl, .dae, .gltf, .glb");
	refused("obj", obj_wedge(), "allowed: .obj, .stl, .dae, .gltf, .glb");
	refused("a.obj", text_of(""), "cannot be read as a mesh");
	refused("a.stl", text_of(""), "cannot be read as a mesh");
	refused("a.gltf", text_of("{}"), "cannot be read as a mesh");
	refused("a.glb", text_of("glTF"), "cannot be read as a mesh");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), "");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n"), "");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n"), "");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "none of its triangles has an area");
	refused("a.obj", text_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 3\n"), "no triangle");
	refused("a.stl", text_of("solid \xff\n\x01 bad"), "");
}

static void numbers_that_are_none_are_refused(void **state)
{
	static const float odd[] = {NAN, INFINITY, -INFINITY, 1e38f, 3e3f};
	for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
		float corners[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
		corners[i % 3][(i + 1) % 3] = odd[i];
		refused("a.stl", binary_stl((const float(*)[3])corners, 1), "has a corner that is ");
	}
	refused("a.obj", text_of("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n"), "");
}

static void what_is_cut_short_is_refused(void **state)
{
	struct bytes whole = binary_wedge();
	struct bytes buffer = gltf_buffer();
	char *inside = edited(GLTF, ",\"uri\":\"wedge.bin\"", "");
	struct bytes packed = glb(inside, buffer);
	for (size_t length = 1; length < whole.length; length += length < 90 ? 7 : 31) {
		struct bytes cut = {NULL, 0, 0};
		add(&cut, whole.at, length);
		refused("a.stl", cut, "");
	}
	for (size_t length = 1; length < packed.length; length += length < 40 ? 3 : 37) {
		struct bytes cut = {NULL, 0, 0};
		add(&cut, packed.at, length);
		refused("a.glb", cut, "");
	}
	uint32_t many = 0x7fffffff; /* triangles that are not there */
	memcpy(whole.at + 80, &many, sizeof many);
	refused("a.stl", whole, "");
	free(inside);
	free(buffer.at);
	free(packed.at);
}

static void a_gltf_that_lies_is_refused(void **state)
{
	static const char *const lies[][2] = {
		{"\"count\":24", "\"count\":25"},
		{"\"count\":24", "\"count\":4000000000"},
		{"\"count\":6", "\"count\":7"},
		{"\"byteLength\":72", "\"byteLength\":7200000"},
		{"\"byteOffset\":72", "\"byteOffset\":4000000000"},
		{"\"version\":\"2.0\"", "\"version\":\"9.0\""},
		{"\"indices\":1", "\"indices\":0"},
		{"\"nodes\":[{\"mesh\":0}]", "\"nodes\":[{\"mesh\":7}]"},
		{"\"nodes\":[{\"mesh\":0}]", "\"nodes\":[{\"matrix\":[1e38,0,0,0,0,1e38,0,0,0,0,1e38,0,0,0,0,1],\"mesh\":0}]"},
	};
	struct bytes buffer = gltf_buffer();
	char *inside = edited(GLTF, ",\"uri\":\"wedge.bin\"", "");
	for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++) {
		char *json = edited(inside, lies[i][0], lies[i][1]);
		refused("a.glb", glb(json, buffer), "");
		free(json);
	}
	free(inside);
	free(buffer.at);
}

/* What a glTF names elsewhere stays closed, even where it is. */
static void nothing_but_the_meshs_own_folder_is_opened(void **state)
{
	static const char *const ways[] = {"../%s/wedge.bin", "%s/wedge.bin", "./../%s/wedge.bin", "file:///tmp/%s/wedge.bin"};
	struct bytes buffer = gltf_buffer();
	write_bytes("wedge.bin", buffer.at, buffer.length);
	for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
		char way[128], uri[160];
		snprintf(way, sizeof way, ways[i], i == 1 ? folder : strrchr(folder, '/') + 1);
		snprintf(uri, sizeof uri, "\"uri\":\"%s\"", way);
		char *json = edited(GLTF, "\"uri\":\"wedge.bin\"", uri);
		refused("a.gltf", text_of(json), "");
		free(json);
	}
	unlink(in_folder("wedge.bin"));
	refused("a.gltf", text_of(GLTF), "");
	free(buffer.at);
}

static void a_million_triangles_and_no_more(void **state)
{
	/* A mesh of 8 shown by 125,001 nodes. */
	struct bytes json = {NULL, 0, 0}, buffer = gltf_buffer();
	ADD(&json, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1");
	for (int i = 2; i <= 125001; i++)
		ADD(&json, ",%d", i);
	ADD(&json, "]}");
	for (int i = 1; i <= 125001; i++)
		ADD(&json, ",{\"mesh\":0}");
	ADD(&json, "],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]," ACCESSORS
		   "\"buffers\":[{\"byteLength\":120}]}");
	refused("a.glb", glb((const char *)json.at, buffer), "more than 1000000 triangles");
	free(json.at);
	free(buffer.at);
}

static void a_file_too_large_is_refused(void **state)
{
	struct soil_mesh *mesh;
	write_text("a.obj", "v 0 0 0\n");
	assert_int_equal(truncate(in_folder("a.obj"), (64 << 20) + 1), 0);
	enum status status = scene_mesh_load(in_folder("a.obj"), "file", 1, &mesh);
	unlink(in_folder("a.obj"));
	assert_int_equal(status, STATUS_INPUT);
	if (strstr(failure_message(), "this build reads no meshes") != NULL)
		skip_since("this build reads no meshes");
	assert_says("allowed: 67108864 bytes");
}

static void every_allocation_may_fail(void **state)
{
	struct bytes obj = obj_wedge();
	for (uint64_t nth = 1;; nth++) {
		struct soil_mesh *mesh;
		write_bytes("a.obj", obj.at, obj.length);
		mem_fail_nth(nth, 0);
		enum status status = scene_mesh_load(in_folder("a.obj"), "file", 1, &mesh);
		uint64_t made = mem_fail_nth(0, 0);
		unlink(in_folder("a.obj"));
		if (status == STATUS_OK) {
			scene_mesh_destroy(mesh);
			if (made < nth)
				break;
		}
		if (status != STATUS_OK && strstr(failure_message(), "this build reads no meshes") != NULL)
			skip_since("this build reads no meshes");
		assert_true(nth < 100);
	}
	free(obj.at);
}

TEST_PROGRAM(mesh)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_format_is_the_same_wedge),
		cmocka_unit_test(nodes_place_what_they_show),
		cmocka_unit_test(a_scale_makes_metres),
		cmocka_unit_test(points_lines_and_slivers_are_left_out),
		cmocka_unit_test(the_order_is_the_files),
		cmocka_unit_test(what_is_no_surface_is_refused),
		cmocka_unit_test(numbers_that_are_none_are_refused),
		cmocka_unit_test(what_is_cut_short_is_refused),
		cmocka_unit_test(a_gltf_that_lies_is_refused),
		cmocka_unit_test(nothing_but_the_meshs_own_folder_is_opened),
		cmocka_unit_test(a_million_triangles_and_no_more),
		cmocka_unit_test(a_file_too_large_is_refused),
		cmocka_unit_test(every_allocation_may_fail),
	};
	return cmocka_run_group_tests_name("scene/mesh", tests, make_folder, drop_folder);
}
