/* The whole-number arithmetic under the undersides is exact on this driver, as it must be on every one. */
#include "ground.h"

#include "soil/shape/affine.h"
#include "../support/program.h"

enum { EDGE = 256, COUNT = EDGE * EDGE };

static const char shader[] = "#version 450 core\n"
			     "#include \"lib/envelope.glsl\"\n"
			     "layout(binding = 0) uniform isampler2D inputs[3];\n"
			     "layout(location = 0) out int result;\n"
			     "int at(int i) { return texelFetch(inputs[i], ivec2(gl_FragCoord.xy), 0).r; }\n"
			     "void main() { result = EXPRESSION; }\n";

static int32_t inputs[3][COUNT], results[COUNT];

static void compute(const char *expression, const void *params, size_t bytes)
{
	struct shader_text table[TEST_SHADERS_MAX];
	struct gpu_pass pass = {.stage = GPU_TERRAIN, .viewport = {0, 0, EDGE, EDGE}, .params = params, .params_bytes = bytes};
	struct gpu_texture *out = ints_texture(NULL, EDGE, EDGE);
	for (int k = 0; k < 3; k++)
		pass.textures[k] = ints_texture(inputs[k], EDGE, EDGE);
	struct gpu_attachment colour = {out, 0};
	assert_ok(gpu_target_create(test_gpu, &colour, 1, (struct gpu_attachment){NULL, 0}, &pass.target));
	assert_ok(gpu_program_get_from(test_gpu, shaders_with(table, "test.frag", shader),
		&(struct gpu_program_request){.vertex = "full.vert", .fragment = "test.frag", .defines = {expression}}, &pass.program));
	gpu_pass_run(test_gpu, &pass);
	gpu_texture_read(out, 0, rect_of(0, 0, EDGE, EDGE), results);
	assert_ok(gpu_check(test_gpu, "arithmetic"));
	gpu_target_destroy(pass.target);
	gpu_texture_destroy(out);
	for (int k = 0; k < 3; k++)
		gpu_texture_destroy(pass.textures[k]);
}

static const uint32_t uniforms[1024]; /* for what envelope.glsl declares and this does not use */

static void roots_are_the_largest_whole_ones(void **state)
{
	(void)state;
	need_gpu();
	for (int round = 0; round < 24; round++) {
		for (int i = 0; i < COUNT; i++) {
			/* Squares and their neighbours of every size; then anything below 2^62. */
			uint64_t root = (any_word() & 0x7fffffff) >> i % 31, d = root * root;
			if (round == 0)
				d = (uint64_t)i;
			else if (round % 4 == 3)
				d = ((uint64_t)any_word() << 32 | any_word()) >> (2 + i % 50);
			else
				d += (uint64_t)(round % 4 == 0 ? 0 : round % 4 == 1 || d == 0 ? 2 * root : UINT64_MAX);
			d = d < 1ull << 62 ? d : (1ull << 62) - 1 - (uint64_t)i;
			inputs[0][i] = (int32_t)(d >> 32);
			inputs[1][i] = (int32_t)d;
		}
		compute("EXPRESSION square_root(i64(at(0), uint(at(1))))", uniforms, sizeof uniforms);
		for (int i = 0; i < COUNT; i++) {
			uint64_t d = (uint64_t)(uint32_t)inputs[0][i] << 32 | (uint32_t)inputs[1][i];
			uint64_t q = (uint64_t)(uint32_t)results[i];
			if (q * q > d || (q + 1) * (q + 1) <= d)
				fail_msg("the root of %llu is not %llu", (unsigned long long)d, (unsigned long long)q);
		}
	}
}

static void fractions_are_rounded_to_nearest(void **state)
{
	(void)state;
	need_gpu();
	for (int i = 0; i < COUNT; i++) {
		inputs[0][i] = any_int() >> 1;
		inputs[1][i] = any_int() >> (2 + i % 29);
		inputs[2][i] = 29 + i % 30;
	}
	compute("EXPRESSION scaled(at(0), at(1), at(2))", uniforms, sizeof uniforms);
	for (int i = 0; i < COUNT; i++) {
		int64_t product = (int64_t)inputs[0][i] * inputs[1][i];
		assert_int_equal(results[i], (int32_t)((product + (1ll << (inputs[2][i] - 1))) >> inputs[2][i]));
	}
}

static int64_t clamped(int64_t value)
{
	int64_t most = (1 << 30) - 1;
	return value > most ? most : value < -most ? -most : value;
}

static void functionals_are_their_integers_at_every_post(void **state)
{
	(void)state;
	need_gpu();
	for (int round = 0; round < 200; round++) {
		struct {
			struct functional f[32]; /* as large as the block the shader declares */
		} block = {0};
		long double size = ldexpl(1, round % 40 - 20);
		struct affine value = {any_share() * size * 200, any_share() * size, any_share() * size};
		int64_t x0 = (int64_t)(any_share() * 700), y0 = (int64_t)(any_share() * 700);
		block.f[0] = soil_functional_of(value, 20, 12, x0, y0);
		compute("EXPRESSION AT(0, 0, ivec2(gl_FragCoord.xy))", &block, sizeof block);
		const uint32_t *a = block.f[0].at_di, *b = block.f[0].dj_shift;
		int64_t at = (int64_t)((uint64_t)a[1] << 32 | a[0]), di = (int64_t)((uint64_t)a[3] << 32 | a[2]);
		int64_t dj = (int64_t)((uint64_t)b[1] << 32 | b[0]);
		for (int i = 0; i < COUNT; i++) {
			int64_t sum = 0, x = 0, y = 0;
			assert_false(__builtin_mul_overflow(di, i % EDGE, &x) || __builtin_mul_overflow(dj, i / EDGE, &y));
			assert_false(__builtin_add_overflow(x, y, &sum) || __builtin_add_overflow(sum, at, &sum));
			if (results[i] != clamped(sum >> b[2]))
				fail_msg("post %d, %d: %d", i % EDGE, i / EDGE, results[i]);
			if (b[2] < 12)
				continue;
			long double real = ldexpl(value.at + (x0 + i % EDGE) * value.dx + (y0 + i / EDGE) * value.dy, 20);
			if (fabsl(real) < 1 << 29)
				assert_true(fabsl(real - results[i]) < 0.9L);
		}
	}
}

static void windows_see_the_same_functional(void **state)
{
	(void)state;
	for (int round = 0; round < 1000; round++) {
		struct affine value = {any_share() * 33, any_share() / 3, any_share() / 3};
		int64_t x0 = (int64_t)(any_share() * 700), y0 = (int64_t)(any_share() * 700);
		struct functional a = soil_functional_of(value, 25, 12, x0, y0), b = soil_functional_of(value, 25, 12, x0 + 37, y0 - 11);
		int64_t at_a = (int64_t)((uint64_t)a.at_di[1] << 32 | a.at_di[0]);
		int64_t at_b = (int64_t)((uint64_t)b.at_di[1] << 32 | b.at_di[0]);
		int64_t di = (int64_t)((uint64_t)a.at_di[3] << 32 | a.at_di[2]);
		int64_t dj = (int64_t)((uint64_t)a.dj_shift[1] << 32 | a.dj_shift[0]);
		assert_memory_equal(a.at_di + 2, b.at_di + 2, 8);
		assert_memory_equal(a.dj_shift, b.dj_shift, 16);
		assert_int_equal(at_a + 37 * di - 11 * dj, at_b);
	}
}

TEST_PROGRAM(arithmetic)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(roots_are_the_largest_whole_ones),
		cmocka_unit_test(fractions_are_rounded_to_nearest),
		cmocka_unit_test(functionals_are_their_integers_at_every_post),
		cmocka_unit_test(windows_see_the_same_functional),
	};
	return cmocka_run_group_tests_name("deform/arithmetic", tests, open_gpu, close_gpu);
}
