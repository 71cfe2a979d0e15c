/* shaders/lib/lattice.glsl gives what src/base/lattice.c gives, bit for bit. */
#include "gpu_test.h"
#include "../support/program.h"

enum { SIDE = 128, COUNT = SIDE * SIDE };

static const char shader[] =
	"#version 450 core\n"
	"#include \"lib/lattice.glsl\"\n"
	"layout(binding = 0) uniform isampler2D inputs[7];\n"
	"layout(location = 0) out int result;\n"
	"int at(int i) { return texelFetch(inputs[i], ivec2(gl_FragCoord.xy), 0).r; }\n"
	"void main() {\n"
	"	result = lattice_interpolate(at(0), at(1), at(2), at(3), uvec2(at(4), at(5)), at(6));\n"
	"}\n";

static void interpolation_in_glsl_is_interpolation_in_c(void **state)
{
	static int32_t inputs[7][COUNT], results[COUNT];
	struct shader_text table[TEST_SHADERS_MAX];
	struct gpu_program *program;
	struct gpu_target *target;
	struct gpu_texture *out;
	struct gpu_pass pass = {.stage = GPU_TERRAIN, .viewport = {0, 0, SIDE, SIDE}};
	int holes = 0;
	(void)state;
	need_gpu();
	for (int i = 0; i < COUNT; i++) {
		int shift = i % 15;
		uint32_t side = 1u << shift;
		for (int k = 0; k < 4; k++) /* holes in a few, or all would be holes */
			do
				inputs[k][i] = any_int();
			while (inputs[k][i] == BASE_NODATA && any_word() % 4 != 0);
		for (int k = 4; k < 6; k++) /* edges often: there corners have no weight */
			inputs[k][i] = (int32_t)(any_word() % 4 == 0 ? (any_word() & 1) * side : any_word() % (side + 1));
		inputs[6][i] = shift;
	}
	for (int k = 0; k < 7; k++)
		pass.textures[k] = ints_texture(inputs[k], SIDE, SIDE);
	out = ints_texture(NULL, SIDE, SIDE);
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){out, 0}, 1, (struct gpu_attachment){NULL, 0}, &target));
	assert_ok(gpu_program_get_from(test_gpu, shaders_with(table, "test.frag", shader),
		&(struct gpu_program_request){.vertex = "full.vert", .fragment = "test.frag"}, &program));
	pass.program = program;
	pass.target = target;
	gpu_pass_run(test_gpu, &pass);
	gpu_texture_read(out, 0, rect_of(0, 0, SIDE, SIDE), results);
	assert_ok(gpu_check(test_gpu, "interpolation"));
	for (int i = 0; i < COUNT; i++) {
		int32_t expected = lattice_interpolate(inputs[0][i], inputs[1][i], inputs[2][i], inputs[3][i],
			(uint32_t)inputs[4][i], (uint32_t)inputs[5][i], inputs[6][i]);
		holes += expected == BASE_NODATA;
		assert_int_equal(results[i], expected);
	}
	assert_in_range(holes, 100, COUNT / 2);
	for (int k = 0; k < 7; k++)
		gpu_texture_destroy(pass.textures[k]);
	gpu_target_destroy(target);
	gpu_texture_destroy(out);
}

TEST_PROGRAM(lattice)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(interpolation_in_glsl_is_interpolation_in_c),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
