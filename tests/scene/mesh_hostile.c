/* Mesh files that ask for a stack, for memory or for hours that a small file must not take. Each is refused at once, with its reason. */
#include <sys/resource.h>
#include <sys/stat.h>

#include "fixture.h"
#include "scene/scene_mesh.h"
#include "../support/program.h"
#include "../support/skip.h"

#define MEMORY_MOST (400 << 10) /* KiB by which all of these may grow the program */

static long peak_before; /* KiB */

static long peak(void)
{
	struct rusage used;
	getrusage(RUSAGE_SELF, &used);
	return used.ru_maxrss;
}

struct text {
	char *at;
	size_t length;
};

static struct text repeated(const char *before, const char *part, size_t times, const char *after)
{
	const size_t size = strlen(part);
	struct text text = {malloc(strlen(before) + times * size + strlen(after) + 1), 0};
	assert_non_null(text.at);
	text.length = (size_t)sprintf(text.at, "%s", before);
	for (size_t i = 0; i < times; i++, text.length += size)
		memcpy(text.at + text.length, part, size);
	text.length += (size_t)sprintf(text.at + text.length, "%s", after);
	return text;
}

static enum status load(const char *name, const char *bytes, size_t length, struct soil_mesh **mesh)
{
	write_bytes(name, bytes, length);
	enum status status = scene_mesh_load(in_folder(name), "file", 1, mesh);
	unlink(in_folder(name));
	if (status != STATUS_OK && strstr(failure_message(), "this build reads no meshes") != NULL)
		skip_since("this build reads no meshes");
	return status;
}

static void refused(const char *name, struct text text, const char *why)
{
	struct soil_mesh *mesh;
	if (load(name, text.at, text.length, &mesh) != STATUS_INPUT)
		fail_msg("%s, \"%.60s...\": was taken, or failed otherwise", name, text.at);
	assert_says(why);
	free(text.at);
}

#define REST                                                                                                                     \
	"\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"                     \
	"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"                               \
	"\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"                                                                    \
	"\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/\"}]"
/* Left, up, front: (0, 0, 0), (1, 0, 0), (0, 0, 1). */

static struct text of(const char *text)
{
	return repeated(text, "", 0, "");
}

static void a_gltf_takes_what_its_bytes_allow(void **state)
{
	peak_before = peak();
	refused("a.gltf", repeated("", "[", 1000000, ""), "its text is no JSON");
	refused("a.gltf", repeated("", "{\"a\":", 1000000, ""), "its text is no JSON");
	refused("a.gltf", repeated("[", "0,", 2000000, "0]"), "more than 2000000 values");
	refused("a.gltf", of("{" REST ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"children\":[0]}]}"), "too many or too deep");
	refused("a.gltf", repeated("{" REST ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[", "{\"children\":[1,1]},{\"children\":[0,0]},", 1, "{}]}"),
		"too many or too deep");
	refused("a.gltf", repeated("{" REST ",\"scenes\":[{\"nodes\":[0", ",0", 1500000, "]}],\"nodes\":[{\"mesh\":0}]}"), "too many or too deep");
	refused("a.gltf", of("{" REST ",\"scenes\":[{\"nodes\":[1e300]}],\"nodes\":[{}]}"), "a node is named that is not there");
	refused("a.gltf", of("{" REST ",\"scenes\":[{\"nodes\":[-1]}],\"nodes\":[{}]}"), "a node is named that is not there");
	refused("a.gltf", of("{" REST ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"matrix\":[1]}]}"), "has not 16 numbers");
	refused("a.gltf", of("{" REST ",\"scene\":4,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]}"), "its scene is no whole number");
	refused("a.gltf", of("{" REST ",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}"), "compressed with KHR_draco_mesh_compression");
}

/* A chain of nodes is flat in the text, and deep when it is followed. */
static void a_chain_of_nodes_is_not_followed_for_ever(void **state)
{
	struct text text = {malloc(4 << 20), 0};
	text.length = (size_t)sprintf(text.at, "{%s,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[", REST);
	for (int i = 1; i <= 100000; i++)
		text.length += (size_t)sprintf(text.at + text.length, "{\"children\":[%d]},", i);
	text.length += (size_t)sprintf(text.at + text.length, "{\"mesh\":0}]}");
	refused("a.gltf", text, "too many or too deep; allowed: 1000000, 256 deep");
}

static void a_buffer_that_is_not_there_is_not_believed(void **state)
{
	static const char *const lies[][3] = {
		{"\"count\":3", "\"count\":60000000", "longer than its buffer view"},
		{"\"count\":3", "\"count\":3e18", "its count is no whole number"},
		{"\"count\":3", "\"count\":2.5", "its count is no whole number"},
		{"\"byteLength\":36,\"uri\"", "\"byteLength\":37,\"uri\"", "has 36 bytes and says 37"},
		{"\"bufferView\":0", "\"bufferView\":0,\"byteOffset\":40", "longer than its buffer view"},
		{"\"buffer\":0,", "\"buffer\":0,\"byteStride\":200,", "longer than its buffer view"},
		{"\"buffer\":0,", "\"buffer\":0,\"byteStride\":0,", "longer than its buffer view"},
		{"\"buffer\":0,", "\"buffer\":1,", "its buffer is no whole number"},
		{"AAAA", "A!AA", "a wrong sign"},
		{"data:;base64,", "/dev/zero", "a buffer is not in its folder"},
		{"data:;base64,", "%2e%2e%2fx", "a buffer is not in its folder"},
		{"data:;base64,", "http://127.0.0.1/", "a buffer is not in its folder"},
		{"\"type\":\"VEC3\"", "\"type\":\"MAT4\"", "is no VEC3"},
		{"5126", "5127", "its componentType is no whole number"},
		{"\"bufferView\":0,\"componentType\":5126,\"count\":3", "\"componentType\":5126,\"count\":60000000,\"sparse\":{\"count\":60000000,"
		 "\"indices\":{\"bufferView\":0,\"componentType\":5125},\"values\":{\"bufferView\":0}}", "longer than its buffer view"},
	};
	static const char whole[] = "{" REST ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]}";
	static const char lying[] = "glTF\2\0\0\0\377\377\377\377\360\377\377\377JSON{}";
	struct soil_mesh *mesh;
	assert_int_equal(load("a.gltf", whole, strlen(whole), &mesh), STATUS_OK);
	assert_int_equal(mesh->triangle_count, 1);
	scene_mesh_destroy(mesh);
	for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++) {
		char *text = edited(whole, lies[i][0], lies[i][1]);
		refused("a.gltf", of(text), lies[i][2]);
		free(text);
	}
	assert_int_equal(load("b.glb", lying, sizeof lying - 1, &mesh), STATUS_INPUT);
	assert_says("its text has 4294967280 bytes, and the file 22");
	/* A mesh of 20 million triangles that no bytes stand for. */
	char *text = edited(whole, "\"bufferView\":0,\"componentType\":5126,\"count\":3", "\"componentType\":5126,\"count\":60000000");
	refused("a.gltf", of(text), "more than 1000000 triangles");
	free(text);
}

/* What assimp would take hundreds of bytes and more for. */
static void obj_and_stl_are_counted_first(void **state)
{
	static const char corners[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
	struct soil_mesh *mesh;
	refused("a.obj", repeated(corners, "f 1 2 3\n", 1000001, ""), "more than 1000000 triangles");
	refused("a.obj", repeated(corners, "g\n", 20001, "f 1 2 3\n"), "more than 20000 groups");
	refused("a.obj", repeated("v 0 0 0\nf", " 1", 1001, "\n"), "more than 1000 corners in one face");
	refused("a.obj", repeated("v 0 0 0\nf", " 1\\\n", 1001, "\n"), "more than 1000 corners in one face");
	refused("a.obj", repeated("v 0 0 0\nl", " 1", 1000001, "\n"), "more than 1000000 points and lines");
	refused("a.stl", repeated("", "solid\nendsolid\n", 10001, ""), "more than 20000 groups");
	refused("a.stl", repeated("solid a\n", "facet normal", 1000001, ""), "more than 1000000 triangles");
	struct text text = repeated("", "x", 134, "");
	memcpy(text.at + 80, "\xff\xff\xff\xff", 4);
	refused("a.stl", text, "cannot be read as a mesh");
	/* A file of materials is not opened, so a pipe in its place holds nothing up. */
	assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
	text = repeated("mtllib pipe\nmtllib /dev/zero\n", corners, 1, "f 1 2 3\n");
	assert_int_equal(load("a.obj", text.at, text.length, &mesh), STATUS_OK);
	scene_mesh_destroy(mesh);
	free(text.at);
	unlink(in_folder("pipe"));
}

static void a_dae_is_counted_first(void **state)
{
	const char *begin = "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>";
	(void)state;
	refused("a.dae", repeated(begin, "<node>", 300, "</COLLADA>"), "more than 256 elements in each other");
	refused("a.dae", repeated(begin, "<p/>", 200001, "</COLLADA>"), "more than 200000 elements");
	refused("a.dae", repeated(begin, "<triangles></triangles>", 20001, "</COLLADA>"), "more than 20000 groups");
	refused("a.dae", repeated("<COLLADA><library_nodes><node id=\"a\"></node></library_nodes>", "<node></node><instance_node url=\"#a\"/>", 1001, "</COLLADA>"), "more than 1000 instances of nodes");
	/* Nodes that have each other. */
	refused("a.dae", repeated(begin, "<library_nodes><node id=\"a\"><instance_node url=\"#a\"/></node></library_nodes>", 1,
				  "<library_visual_scenes><visual_scene id='s'><node><instance_node url=\"#a\"/></node></visual_scene></library_visual_scenes>"
				  "<scene><instance_visual_scene url='#s'/></scene></COLLADA>"), "have instances of nodes, which are not followed");
	refused("a.dae", repeated(begin, "<node/>", 1, ""), "cannot be read as a mesh");
	refused("a.dae", repeated("", "<", 100, ""), "");
}

static void a_mesh_that_is_a_pipe_is_refused(void **state)
{
	static const char *const names[] = {"a.obj", "a.stl", "a.dae", "a.gltf", "a.glb"};
	struct soil_mesh *mesh;
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
		assert_int_equal(mkfifo(in_folder(names[i]), 0600), 0);
		assert_int_equal(scene_mesh_load(in_folder(names[i]), "file", 1, &mesh), STATUS_INPUT);
		if (strstr(failure_message(), "this build reads no meshes") != NULL)
			skip_since("this build reads no meshes");
		assert_says("not a file");
		unlink(in_folder(names[i]));
	}
}

static void they_took_little_memory(void **state)
{
#ifdef __SANITIZE_ADDRESS__
	const int share = 2; /* of it are the sanitizer's own blocks */
#else
	const int share = 1;
#endif
	assert_in_range(peak() - peak_before, 0, MEMORY_MOST * share);
}

TEST_PROGRAM(mesh_hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_gltf_takes_what_its_bytes_allow),
		cmocka_unit_test(a_chain_of_nodes_is_not_followed_for_ever),
		cmocka_unit_test(a_buffer_that_is_not_there_is_not_believed),
		cmocka_unit_test(obj_and_stl_are_counted_first),
		cmocka_unit_test(a_dae_is_counted_first),
		cmocka_unit_test(a_mesh_that_is_a_pipe_is_refused),
		cmocka_unit_test(they_took_little_memory),
	};
	return cmocka_run_group_tests_name("scene/mesh_hostile", tests, make_folder, drop_folder);
}
