/* shaders/lib/int64.glsl computes what C's int64_t does, wrapping. */
#include "gpu_test.h"
#include "../support/program.h"

enum { SIDE = 96, COUNT = SIDE * SIDE };

enum operation { ADD, SUB, NEG, MUL, MUL_INT, LESS, SAR, SHL, CLAMP, MIN, MAX, FROM, TO_INT, OPERATIONS };

static const char *const expressions[] = {
	[ADD] = "EXPRESSION i64_add(a, b)",
	[SUB] = "EXPRESSION i64_sub(a, b)",
	[NEG] = "EXPRESSION i64_neg(a)",
	[MUL] = "EXPRESSION i64_mul(a.hi, b.hi)",
	[MUL_INT] = "EXPRESSION i64_mul_int(a, b.hi)",
	[LESS] = "EXPRESSION i64_from(int(i64_less(a, b)))",
	[SAR] = "EXPRESSION i64_sar(a, n)",
	[SHL] = "EXPRESSION i64_shl(a, n)",
	[CLAMP] = "EXPRESSION i64_clamp(a, i64_min(b, i64_from(n)), i64_max(b, i64_from(n)))",
	[MIN] = "EXPRESSION i64_min(a, b)",
	[MAX] = "EXPRESSION i64_max(a, b)",
	[FROM] = "EXPRESSION i64_from(a.hi)",
	[TO_INT] = "EXPRESSION i64_from(i64_to_int(a))",
};

static const char shader[] =
	"#version 450 core\n"
	"#include \"lib/int64.glsl\"\n"
	"layout(binding = 0) uniform isampler2D inputs[5];\n"
	"layout(location = 0) out int high;\n"
	"layout(location = 1) out int low;\n"
	"int at(int i) { return texelFetch(inputs[i], ivec2(gl_FragCoord.xy), 0).r; }\n"
	"void main() {\n"
	"	i64 a = i64(at(0), uint(at(1))), b = i64(at(2), uint(at(3)));\n"
	"	int n = at(4);\n"
	"	i64 result = EXPRESSION;\n"
	"#ifdef TO_FLOAT\n"
	"	result = i64(floatBitsToInt(i64_to_float(a)), a.hi < 0 ? 1u : 0u);\n"
	"#endif\n"
	"	high = result.hi;\n"
	"	low = int(result.lo);\n"
	"}\n";

static int32_t inputs[5][COUNT], results[2][COUNT];

static int64_t join(int32_t high, int32_t low)
{
	return (int64_t)((uint64_t)(uint32_t)high << 32 | (uint32_t)low);
}

static int64_t expected(enum operation operation, int i)
{
	int64_t a = join(inputs[0][i], inputs[1][i]), b = join(inputs[2][i], inputs[3][i]);
	int n = inputs[4][i];
	int64_t low = b < n ? b : n, high = b < n ? n : b;
	switch (operation) {
	case ADD:
		return (int64_t)((uint64_t)a + (uint64_t)b);
	case SUB:
		return (int64_t)((uint64_t)a - (uint64_t)b);
	case NEG:
		return (int64_t)(0 - (uint64_t)a);
	case MUL:
		return (int64_t)inputs[0][i] * inputs[2][i];
	case MUL_INT:
		return (int64_t)((uint64_t)a * (uint64_t)(int64_t)inputs[2][i]);
	case LESS:
		return a < b;
	case SAR:
		return a >> n;
	case SHL:
		return (int64_t)((uint64_t)a << n);
	case CLAMP:
		return a < low ? low : a > high ? high : a;
	case MIN:
		return a < b ? a : b;
	case MAX:
		return a < b ? b : a;
	case FROM:
		return inputs[0][i];
	case TO_INT:
		return inputs[1][i];
	default:
		return 0;
	}
}

/* Runs one variant over all inputs, into results. */
static void compute(const char *expression, const char *also)
{
	struct shader_text table[TEST_SHADERS_MAX];
	struct gpu_pass pass = {.stage = GPU_TERRAIN, .viewport = {0, 0, SIDE, SIDE}};
	struct gpu_texture *out[2];
	struct gpu *own = test_gpu;
	for (int k = 0; k < 5; k++)
		pass.textures[k] = ints_texture(inputs[k], SIDE, SIDE);
	for (int k = 0; k < 2; k++)
		out[k] = ints_texture(NULL, SIDE, SIDE);
	struct gpu_attachment colours[2] = {{out[0], 0}, {out[1], 0}};
	assert_ok(gpu_target_create(own, colours, 2, (struct gpu_attachment){NULL, 0}, &pass.target));
	assert_ok(gpu_program_get_from(own, shaders_with(table, "test.frag", shader),
		&(struct gpu_program_request){.vertex = "full.vert", .fragment = "test.frag", .defines = {expression, also}}, &pass.program));
	gpu_pass_run(own, &pass);
	for (int k = 0; k < 2; k++)
		gpu_texture_read(out[k], 0, rect_of(0, 0, SIDE, SIDE), results[k]);
	assert_ok(gpu_check(own, "64-bit integers"));
	gpu_target_destroy(pass.target);
	for (int k = 0; k < 5; k++)
		gpu_texture_destroy(pass.textures[k]);
	for (int k = 0; k < 2; k++)
		gpu_texture_destroy(out[k]);
}

static void make_inputs(void)
{
	for (int i = 0; i < COUNT; i++) {
		for (int k = 0; k < 4; k++)
			inputs[k][i] = any_int();
		if (any_word() % 4 == 0)
			inputs[2][i] = inputs[0][i];
		if (any_word() % 4 == 0)
			inputs[3][i] = inputs[1][i];
		inputs[4][i] = i % 64;
	}
}

static void every_operation_is_that_of_int64(void **state)
{
	(void)state;
	need_gpu();
	make_inputs();
	for (int operation = 0; operation < OPERATIONS; operation++) {
		compute(expressions[operation], NULL);
		for (int i = 0; i < COUNT; i++)
			if (join(results[0][i], results[1][i]) != expected((enum operation)operation, i))
				fail_msg("%s of %lld, %lld, %d", expressions[operation],
					 (long long)join(inputs[0][i], inputs[1][i]), (long long)join(inputs[2][i], inputs[3][i]),
					 inputs[4][i]);
	}
}

static void a_float_is_near_and_has_the_sign(void **state)
{
	(void)state;
	need_gpu();
	make_inputs();
	compute("EXPRESSION a", "TO_FLOAT");
	for (int i = 0; i < COUNT; i++) {
		int64_t a = join(inputs[0][i], inputs[1][i]);
		double exact = (double)a;
		float value;
		memcpy(&value, &results[0][i], sizeof value);
		assert_int_equal(results[1][i], a < 0);
		assert_true((a < 0) == (value < 0) && (a == 0) == (value == 0));
		assert_true((value - exact) <= 2.4e-7 * (exact < 0 ? -exact : exact));
		assert_true((value - exact) >= -2.4e-7 * (exact < 0 ? -exact : exact));
	}
}

TEST_PROGRAM(int64)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_operation_is_that_of_int64),
		cmocka_unit_test(a_float_is_near_and_has_the_sign),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
