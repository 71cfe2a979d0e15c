/* shaders/lib/slope.glsl gives the gradient of the quadratic B-spline, at any place of a tile; tiles agree along their edges. */
#include <math.h>

#include "gpu_test.h"
#include "../support/program.h"

enum { CELLS = 24, POSTS = CELLS + 1, SIDE = 128, COUNT = SIDE * SIDE, OUTPUTS = 5 };

static const char shader[] =
	"#version 450 core\n"
	"#include \"lib/slope.glsl\"\n"
	"#ifdef TEXTURES\n"
	"layout(binding = 0) uniform isampler2D base;\n"
	"layout(binding = 1) uniform isampler2D offset;\n"
	"#define BASE(at) texelFetch(base, at, 0).r\n"
	"#define OFFSET(at) texelFetch(offset, at, 0).r\n"
	"#else\n"
	"layout(binding = 0, r32i) readonly uniform iimage2D base;\n"
	"layout(binding = 1, r32i) readonly uniform iimage2D offset;\n"
	"#define BASE(at) imageLoad(base, at).r\n"
	"#define OFFSET(at) imageLoad(offset, at).r\n"
	"#endif\n"
	"layout(binding = 2) uniform sampler2D place_x;\n"
	"layout(binding = 3) uniform sampler2D place_y;\n"
	"layout(location = 0) out float outputs[5];\n"
	"void main() {\n"
	"	ivec2 at = ivec2(gl_FragCoord.xy);\n"
	"	vec2 place = vec2(texelFetch(place_x, at, 0).r, texelFetch(place_y, at, 0).r);\n"
	"	vec2 gradient = slope_of_base(SLOPE_POSTS(BASE, place, CELLS), place, CELLS);\n"
	"	slope_of_map moved = slope_of_offset(SLOPE_POSTS(OFFSET, place, CELLS), place, CELLS);\n"
	"	outputs[0] = gradient.x;\n"
	"	outputs[1] = gradient.y;\n"
	"	outputs[2] = moved.gradient.x;\n"
	"	outputs[3] = moved.gradient.y;\n"
	"	outputs[4] = moved.value;\n"
	"}\n";

static float places[2][COUNT], results[OUTPUTS][COUNT];
static int32_t posts[2][POSTS * POSTS];

static double any_share(void)
{
	return any_word() / 4294967296.0;
}

/* A post by its place from post (i, j), relative to that; what is nodata is level with it, what is beyond the edge goes on. */
static double post_at(const int32_t *map, int i, int j, int u, int v)
{
	if (i + u < 0 || i + u > CELLS)
		return 2 * post_at(map, i, j, 0, v) - post_at(map, i, j, -u, v);
	if (j + v < 0 || j + v > CELLS)
		return 2 * post_at(map, i, j, u, 0) - post_at(map, i, j, u, -v);
	int32_t post = map[(j + v) * POSTS + i + u];
	return post == BASE_NODATA ? 0 : (double)post - map[j * POSTS + i];
}

static void slope_in_c(const int32_t *map, double x, double y, double slope[3])
{
	int i = (int)floor(x + 0.5), j = (int)floor(y + 0.5);
	double f[2] = {x - i, y - j}, weights[2][3], steps[2][3];
	for (int axis = 0; axis < 2; axis++) {
		double before = 0.5 - f[axis], after = 0.5 + f[axis];
		weights[axis][0] = before * before / 2;
		weights[axis][1] = 0.75 - f[axis] * f[axis];
		weights[axis][2] = after * after / 2;
		steps[axis][0] = -before;
		steps[axis][1] = -2 * f[axis];
		steps[axis][2] = after;
	}
	slope[0] = slope[1] = 0;
	slope[2] = map[j * POSTS + i];
	for (int v = 0; v < 3; v++)
		for (int u = 0; u < 3 && map[j * POSTS + i] != BASE_NODATA; u++) {
			double post = post_at(map, i, j, u - 1, v - 1);
			slope[0] += steps[0][u] * weights[1][v] * post;
			slope[1] += weights[0][u] * steps[1][v] * post;
			slope[2] += weights[0][u] * weights[1][v] * post;
		}
}

/* Posts about a height far from 0, with holes in the base; places of all kinds: on posts, half-way, on the edges, anywhere. */
static void fill(void)
{
	for (int i = 0; i < POSTS * POSTS; i++) {
		posts[0][i] = any_word() % 9 == 0 ? BASE_NODATA : (int32_t)(any_word() >> 12) + 0x3ff00000;
		posts[1][i] = (int32_t)(any_word() >> 10) - 0x3f000000;
	}
	for (int i = 0; i < COUNT; i++)
		for (int axis = 0; axis < 2; axis++) {
			unsigned kind = any_word() % 8;
			double place = any_share() * CELLS;
			place = kind == 0 ? 0 : kind == 1 ? CELLS : kind == 2 ? floor(place) : kind == 3 ? floor(place) + 0.5 : place;
			place = kind == 4 ? place / CELLS : kind == 5 ? CELLS - place / CELLS : place;
			places[axis][i] = (float)place;
		}
}

static struct gpu_texture *floats_texture(const float *values)
{
	struct gpu_texture *texture;
	assert_ok(gpu_texture_create(test_gpu, GPU_R32F, SIDE, SIDE, 0, &texture));
	if (values != NULL)
		gpu_texture_upload(texture, 0, rect_of(0, 0, SIDE, SIDE), values);
	return texture;
}

/* The slopes of posts at places, as pixels find them or as vertices do. */
static void find(const char *vertices)
{
	struct shader_text table[TEST_SHADERS_MAX];
	struct gpu_program *program;
	struct gpu_target *target;
	struct gpu_texture *in[2] = {ints_texture(posts[0], POSTS, POSTS), ints_texture(posts[1], POSTS, POSTS)};
	struct gpu_attachment out[OUTPUTS];
	struct gpu_pass pass = {.stage = GPU_TERRAIN, .viewport = {0, 0, SIDE, SIDE}, .only_reads = true,
				.textures = {in[0], in[1], floats_texture(places[0]), floats_texture(places[1])}};
	for (int i = 0; i < 2 && vertices == NULL; i++)
		pass.images[i] = in[i];
	for (int i = 0; i < OUTPUTS; i++)
		out[i] = (struct gpu_attachment){floats_texture(NULL), 0};
	assert_ok(gpu_target_create(test_gpu, out, OUTPUTS, (struct gpu_attachment){NULL, 0}, &target));
	assert_ok(gpu_program_get_from(test_gpu, shaders_with(table, "test.frag", shader),
		&(struct gpu_program_request){.vertex = "full.vert", .fragment = "test.frag", .defines = {"CELLS 24", vertices}}, &program));
	pass.program = program;
	pass.target = target;
	gpu_pass_run(test_gpu, &pass);
	for (int i = 0; i < OUTPUTS; i++)
		gpu_texture_read(out[i].texture, 0, rect_of(0, 0, SIDE, SIDE), results[i]);
	assert_ok(gpu_check(test_gpu, "slopes"));
	gpu_target_destroy(target);
	for (int i = 0; i < 4; i++)
		gpu_texture_destroy(pass.textures[i]);
	for (int i = 0; i < OUTPUTS; i++)
		gpu_texture_destroy(out[i].texture);
}

/* Heights span 2^20 and 2^22: of a few products of them a float keeps this much. */
#define NEAR(a, b, span) assert_true(fabs((double)(a) - (b)) <= 4e-6 * (span))

static void slopes_in_glsl_are_slopes_in_c(void **state)
{
	static const char *const kinds[] = {NULL, "TEXTURES"};
	int holes = 0;
	(void)state;
	need_gpu();
	fill();
	for (int kind = 0; kind < 2; kind++) {
		find(kinds[kind]);
		for (int i = 0; i < COUNT; i++) {
			double base[3], offset[3];
			slope_in_c(posts[0], places[0][i], places[1][i], base);
			slope_in_c(posts[1], places[0][i], places[1][i], offset);
			holes += base[2] == BASE_NODATA;
			for (int k = 0; k < 2; k++) {
				NEAR(results[k][i], base[k], 0x1p20);
				NEAR(results[2 + k][i], offset[k], 0x1p22);
			}
			NEAR(results[4][i], offset[2], 0x1p30 / 16);
		}
	}
	assert_in_range(holes, 100, COUNT);
}

/* The slope along an edge that two tiles share is that of its posts alone: the same in both, whatever else they hold. */
static void tiles_agree_along_an_edge(void **state)
{
	static float west[COUNT], kept[COUNT];
	int32_t shared[POSTS];
	(void)state;
	need_gpu();
	fill();
	memcpy(kept, places[1], sizeof kept);
	for (int j = 0; j < POSTS; j++)
		shared[j] = (int32_t)(any_word() >> 12) + 0x3ff00000;
	for (int tile = 0; tile < 2; tile++) {
		int column = tile == 0 ? CELLS : 0;
		for (int i = 0; i < POSTS * POSTS; i++)
			posts[0][i] = i % POSTS == column ? shared[i / POSTS] : (int32_t)(any_word() >> 12) + 0x3ff00000;
		for (int i = 0; i < COUNT; i++)
			places[0][i] = (float)column;
		memcpy(places[1], kept, sizeof kept);
		find(NULL);
		for (int i = 0; i < COUNT && tile == 1; i++)
			NEAR(results[1][i], west[i], 0x1p20);
		memcpy(west, results[1], sizeof west);
	}
}

TEST_PROGRAM(slope)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(slopes_in_glsl_are_slopes_in_c),
		cmocka_unit_test(tiles_agree_along_an_edge),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
