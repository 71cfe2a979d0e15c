/* Passes: parameters, viewports, indexed draws, depth, storage. */
#include "gpu_test.h"
#include "../support/program.h"

static struct gpu_target *target_over(struct gpu_texture *colour, struct gpu_texture *depth)
{
	struct gpu_target *target;
	assert_ok(gpu_target_create(test_gpu, &(struct gpu_attachment){colour, 0}, 1, (struct gpu_attachment){depth, 0}, &target));
	return target;
}

static struct gpu_program *program_of(const char *vertex, const char *fragment)
{
	static struct shader_text tables[12][3]; /* a place is part of a request: each has its own */
	static size_t used;
	struct gpu_program *program;
	assert_true(used < sizeof tables / sizeof tables[0]);
	tables[used][0] = (struct shader_text){"test.frag", fragment};
	tables[used][1] = (struct shader_text){"test.vert", vertex};
	assert_ok(gpu_program_get_from(test_gpu, tables[used++],
		&(struct gpu_program_request){.vertex = "test.vert", .fragment = "test.frag"}, &program));
	return program;
}

static const char full[] =
	"#version 450 core\n"
	"void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }\n";

static const char paint[] =
	"#version 450 core\n"
	"layout(std140, binding = 0) uniform params { int value; };\n"
	"layout(location = 0) out int result;\n"
	"void main() { result = value; }\n";

/* More passes than the ring's first segments hold, with nothing waited for: each sees its own. */
static void every_pass_sees_its_own_parameters(void **state)
{
	enum { SIDE = 64, ROUNDS = 2 };
	static int32_t read[SIDE * SIDE];
	(void)state;
	need_gpu();
	struct gpu_texture *texture = ints_texture(NULL, SIDE, SIDE);
	struct gpu_target *target = target_over(texture, NULL);
	struct gpu_program *program = program_of(full, paint);
	for (int32_t i = 0; i < SIDE * SIDE * ROUNDS; i++) {
		uint32_t at = (uint32_t)i % (SIDE * SIDE);
		struct {
			int32_t value[5]; /* longer than the block */
		} params = {{i * 7}};
		gpu_pass_run(test_gpu, &(struct gpu_pass){
			.stage = GPU_DISTURBANCE,
			.program = program,
			.target = target,
			.viewport = {at % SIDE, at / SIDE, 1, 1},
			.params = &params,
			.params_bytes = sizeof params,
		});
	}
	gpu_texture_read(texture, 0, rect_of(0, 0, SIDE, SIDE), read);
	assert_ok(gpu_check(test_gpu, "passes"));
	for (int32_t i = 0; i < SIDE * SIDE; i++)
		assert_int_equal(read[i], (i + SIDE * SIDE * (ROUNDS - 1)) * 7);
	struct gpu_stats stats;
	gpu_stats(test_gpu, &stats);
	assert_int_equal(stats.passes[GPU_DISTURBANCE], SIDE * SIDE * ROUNDS);
	gpu_target_destroy(target);
	gpu_texture_destroy(texture);
}

static const char share[] =
	"#version 450 core\n"
	"layout(binding = 0) uniform sampler2D before;\n"
	"layout(location = 0) out float result;\n"
	"void main() { result = texelFetch(before, ivec2(gl_FragCoord.xy), 0).r * 0.5 + 0.25; }\n";

/* What is drawn into one of them is sampled from it, as near as it holds it: a quarter from zeros, three eighths from that. */
static void normalised_and_float_textures_are_drawn_and_sampled(void **state)
{
	static const struct {
		enum gpu_format format;
		uint32_t quarter, eighths; /* texels of those; normalised ones may be rounded either way */
		uint32_t slack;
	} of[] = {
		{GPU_R8, 64, 96, 1}, {GPU_R16, 16384, 24576, 1}, {GPU_R16F, 0x3400, 0x3600, 0}, {GPU_R32F, 0x3e800000, 0x3ec00000, 0},
	};
	(void)state;
	need_gpu();
	struct gpu_program *program = program_of(full, share);
	for (size_t i = 0; i < sizeof of / sizeof of[0]; i++) {
		struct gpu_texture *textures[2];
		struct gpu_target *targets[2];
		uint32_t read[2] = {0, 0};
		for (int k = 0; k < 2; k++) {
			assert_ok(gpu_texture_create(test_gpu, of[i].format, 3, 2, 0, &textures[k]));
			targets[k] = target_over(textures[k], NULL);
			gpu_texture_clear(textures[k], 0, rect_of(0, 0, 3, 2), 0);
		}
		for (int k = 0; k < 2; k++)
			gpu_pass_run(test_gpu, &(struct gpu_pass){
				.stage = GPU_DISTURBANCE,
				.program = program,
				.target = targets[1 - k],
				.viewport = {0, 0, 3, 2},
				.textures = {textures[k]},
			});
		for (int k = 0; k < 2; k++)
			gpu_texture_read(textures[1 - k], 0, rect_of(2, 1, 1, 1), &read[k]);
		assert_ok(gpu_check(test_gpu, "floats"));
		assert_in_range(read[0], of[i].quarter - of[i].slack, of[i].quarter + of[i].slack);
		assert_in_range(read[1], of[i].eighths - of[i].slack, of[i].eighths + of[i].slack);
		for (int k = 0; k < 2; k++) {
			gpu_target_destroy(targets[k]);
			gpu_texture_destroy(textures[k]);
		}
	}
}

/* Both ways, whatever the renderer, with more passes than there are queries. */
static void the_time_of_passes_is_counted_by_stage(void **state)
{
	struct gpu_stats stats;
	int32_t value = 1;
	(void)state;
	need_gpu();
	bool software = test_gpu->info.software;
	struct gpu_texture *texture = ints_texture(NULL, 64, 64);
	struct gpu_target *target = target_over(texture, NULL);
	struct gpu_program *program = program_of(full, paint);
	for (int way = 0; way < 2; way++) {
		enum gpu_stage stage = way == 0 ? GPU_CONTACT : GPU_PYRAMID;
		test_gpu->info.software = way == 0;
		for (int i = 0; i < GPU_TIMER_QUERIES + 100; i++)
			gpu_pass_run(test_gpu, &(struct gpu_pass){
				.stage = stage,
				.program = program,
				.target = target,
				.viewport = {0, 0, 64, 64},
				.params = &value,
				.params_bytes = sizeof value,
			});
		gpu_finish(test_gpu);
		gpu_stats(test_gpu, &stats);
		assert_true(stats.stage_ms[stage] > 0);
		assert_true(stats.stage_ms[GPU_SPREAD] == 0);
		assert_int_equal(stats.passes[stage], GPU_TIMER_QUERIES + 100);
	}
	assert_ok(gpu_check(test_gpu, "timers"));
	assert_int_equal(test_gpu->timer.count, 0);
	test_gpu->info.software = software;
	gpu_target_destroy(target);
	gpu_texture_destroy(texture);
}

static void nothing_outside_the_viewport_is_written(void **state)
{
	enum { SIDE = 20 };
	int32_t read[SIDE * SIDE], value = 3;
	(void)state;
	need_gpu();
	struct gpu_texture *texture = ints_texture(NULL, SIDE, SIDE);
	struct gpu_target *target = target_over(texture, NULL);
	gpu_texture_clear(texture, 0, rect_of(0, 0, SIDE, SIDE), -1);
	gpu_pass_run(test_gpu, &(struct gpu_pass){
		.program = program_of(full, paint),
		.target = target,
		.viewport = {3, 5, 7, 2},
		.params = &value,
		.params_bytes = sizeof value,
	});
	gpu_texture_read(texture, 0, rect_of(0, 0, SIDE, SIDE), read);
	for (int i = 0; i < SIDE * SIDE; i++) {
		int x = i % SIDE, y = i / SIDE;
		assert_int_equal(read[i], x >= 3 && x < 10 && y >= 5 && y < 7 ? 3 : -1);
	}
	gpu_target_destroy(target);
	gpu_texture_destroy(texture);
}

/* Chains of passes that read what the one before wrote: the order of the passes is kept. */
static void a_pass_reads_what_the_one_before_wrote(void **state)
{
	static const char blur[] =
		"#version 450 core\n"
		"layout(binding = 0) uniform isampler2D from;\n"
		"layout(location = 0) out int result;\n"
		"int at(ivec2 p) { return texelFetch(from, clamp(p, ivec2(0), textureSize(from, 0) - 1), 0).r; }\n"
		"void main() {\n"
		"	ivec2 p = ivec2(gl_FragCoord.xy);\n"
		"	result = at(p) + at(p + ivec2(1, 0)) - at(p - ivec2(0, 1));\n"
		"}\n";
	enum { SIDE = 70, ROUNDS = 40 };
	static int32_t now[SIDE * SIDE], next[SIDE * SIDE];
	(void)state;
	need_gpu();
	for (int i = 0; i < SIDE * SIDE; i++)
		now[i] = (int32_t)(any_word() % 1000);
	struct gpu_texture *textures[2] = {ints_texture(now, SIDE, SIDE), ints_texture(NULL, SIDE, SIDE)};
	struct gpu_target *targets[2] = {target_over(textures[0], NULL), target_over(textures[1], NULL)};
	struct gpu_program *program = program_of(full, blur);
	for (int i = 0; i < ROUNDS; i++) {
		gpu_pass_run(test_gpu, &(struct gpu_pass){
			.program = program,
			.target = targets[(i + 1) % 2],
			.viewport = {0, 0, SIDE, SIDE},
			.textures = {textures[i % 2]},
		});
		for (int k = 0; k < SIDE * SIDE; k++) {
			int x = k % SIDE, y = k / SIDE;
			next[k] = (int32_t)((uint32_t)now[k] + (uint32_t)now[x < SIDE - 1 ? k + 1 : k] - (uint32_t)now[y > 0 ? k - SIDE : k]);
		}
		memcpy(now, next, sizeof now);
	}
	gpu_texture_read(textures[ROUNDS % 2], 0, rect_of(0, 0, SIDE, SIDE), next);
	assert_memory_equal(next, now, sizeof now);
	for (int i = 0; i < 2; i++) {
		gpu_target_destroy(targets[i]);
		gpu_texture_destroy(textures[i]);
	}
}

/* Instance i is a square of the right half (front-facing) or the left (back-facing), at depth i. */
static void depth_is_reversed_and_sides_are_culled_when_asked(void **state)
{
	static const char squares[] =
		"#version 450 core\n"
		"layout(location = 0) flat out int number;\n"
		"void main() {\n"
		"	vec2 p = vec2(gl_VertexID & 1, (gl_VertexID >> 1 & 1) * 2 - 1);\n"
		"	if (gl_VertexID >= 4)\n"
		"		p.x = -p.x;\n"
		"	number = gl_InstanceID + 1;\n"
		"	gl_Position = vec4(p, gl_InstanceID == 1 ? 0.9 : 0.5, 1.0);\n"
		"}\n";
	static const char number_out[] =
		"#version 450 core\n"
		"layout(location = 0) flat in int number;\n"
		"layout(location = 0) out vec4 result;\n"
		"void main() { result = vec4(float(number) / 255.0); }\n";
	static const uint16_t indices[12] = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6};
	const float none[4] = {0};
	uint8_t texel[2][4];
	struct gpu_texture *colour, *depth;
	struct gpu_buffer *buffer;
	(void)state;
	need_gpu();
	assert_ok(gpu_texture_create(test_gpu, GPU_RGBA8, 32, 32, 0, &colour));
	assert_ok(gpu_texture_create(test_gpu, GPU_DEPTH32F, 32, 32, 0, &depth));
	assert_ok(gpu_buffer_create(test_gpu, GPU_INDICES, sizeof indices, indices, &buffer));
	struct gpu_target *target = target_over(colour, depth);
	struct gpu_pass pass = {
		.stage = GPU_TERRAIN,
		.program = program_of(squares, number_out),
		.target = target,
		.viewport = {0, 0, 32, 32},
		.indices = buffer,
		.index_count = 12,
		.instances = 3,
	};
	for (int depth_test = 0; depth_test < 2; depth_test++) {
		for (int cull = 0; cull < 2; cull++) {
			pass.depth_test = depth_test != 0;
			pass.cull_back = cull != 0;
			gpu_target_clear(target, none);
			gpu_pass_run(test_gpu, &pass);
			gpu_texture_read(colour, 0, rect_of(24, 16, 1, 1), texel[0]);
			gpu_texture_read(colour, 0, rect_of(8, 16, 1, 1), texel[1]);
			int seen = depth_test != 0 ? 2 : 3; /* the nearest has the greatest depth; or the last */
			assert_int_equal(texel[0][0], seen);
			assert_int_equal(texel[1][0], cull != 0 ? 0 : seen);
		}
	}
	/* Fronts culled instead; the back one alone, by indices of 32 bits from the seventh on. */
	static const uint32_t wide[12] = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6};
	struct gpu_buffer *wide_buffer;
	assert_ok(gpu_buffer_create(test_gpu, GPU_INDICES, sizeof wide, wide, &wide_buffer));
	for (int i = 0; i < 2; i++) {
		pass.cull_back = false;
		pass.cull_front = i == 0;
		if (i == 1) {
			pass.indices = wide_buffer;
			pass.wide_indices = true;
			pass.first_index = pass.index_count = 6;
		}
		gpu_target_clear(target, none);
		gpu_pass_run(test_gpu, &pass);
		gpu_texture_read(colour, 0, rect_of(24, 16, 1, 1), texel[0]);
		gpu_texture_read(colour, 0, rect_of(8, 16, 1, 1), texel[1]);
		assert_int_equal(texel[0][0], 0);
		assert_int_equal(texel[1][0], 2);
	}
	/* Multiplied; and the next pass is not. */
	const float grey[4] = {100 / 255.0f, 1, 0, 1};
	pass.multiply = true;
	pass.instances = 2;
	gpu_target_clear(target, grey);
	gpu_pass_run(test_gpu, &pass);
	gpu_texture_read(colour, 0, rect_of(8, 16, 1, 1), texel[1]);
	assert_int_equal(texel[1][0], 0); /* by 1 / 255, and that by 2 / 255 */
	pass.instances = 1;
	const float white[4] = {1, 1, 1, 1};
	gpu_target_clear(target, white);
	gpu_pass_run(test_gpu, &pass);
	gpu_texture_read(colour, 0, rect_of(8, 16, 1, 1), texel[1]);
	assert_int_equal(texel[1][0], 1);
	pass.multiply = false;
	gpu_target_clear(target, grey);
	gpu_pass_run(test_gpu, &pass);
	gpu_texture_read(colour, 0, rect_of(8, 16, 1, 1), texel[1]);
	assert_int_equal(texel[1][0], 1);
	gpu_buffer_destroy(wide_buffer);
	assert_ok(gpu_check(test_gpu, "squares"));
	gpu_target_destroy(target);
	gpu_texture_destroy(colour);
	gpu_texture_destroy(depth);
	gpu_buffer_destroy(buffer);
}

/* A list is written many times while the GPU is still at the first pass: each pass reads what was there when it was run. */
static void a_pass_reads_the_list_as_it_was_when_it_was_run(void **state)
{
	enum { WRITINGS = 64, WORDS = 20000 };
	static const char text[] =
		"#version 450 core\n"
		"layout(std430, binding = 2) readonly buffer list { int words[]; };\n"
		"layout(std140, binding = 0) uniform params { int turns; };\n"
		"layout(location = 0) out int result;\n"
		"void main() {\n"
		"	int x = int(gl_FragCoord.x), spun = 0;\n"
		"	for (int i = 0; i < turns; i++)\n"
		"		spun = (spun * 5 + words[(spun & 1023) + i % 1000]) & 1023;\n"
		"	result = words[x * 300] + (spun > 1023 ? 1 : 0);\n"
		"}\n";
	static int32_t words[WORDS], values[WRITINGS * 64];
	struct gpu_list *list;
	(void)state;
	need_gpu();
	struct gpu_texture *texture = ints_texture(NULL, 64, WRITINGS);
	struct gpu_target *target = target_over(texture, NULL);
	struct gpu_program *program = program_of(full, text);
	assert_ok(gpu_list_create(test_gpu, sizeof words, &list));
	for (uint32_t n = 0; n < WRITINGS; n++) {
		const int32_t turns = n == 0 ? 100000 : 0;
		for (int i = 0; i < WORDS; i++)
			words[i] = (int32_t)n * WORDS + i;
		gpu_list_write(list, sizeof words, words);
		gpu_pass_run(test_gpu, &(struct gpu_pass){
			.target = target,
			.viewport = {0, n, 64, 1},
			.program = program,
			.lists = {[2] = list},
			.params = &turns,
			.params_bytes = sizeof turns,
		});
	}
	gpu_texture_read(texture, 0, rect_of(0, 0, 64, WRITINGS), values);
	assert_ok(gpu_check(test_gpu, "a list"));
	for (int n = 0; n < WRITINGS; n++)
		for (int x = 0; x < 64; x++)
			assert_int_equal(values[64 * n + x], n * WORDS + 300 * x);
	gpu_list_destroy(list);
	gpu_target_destroy(target);
	gpu_texture_destroy(texture);
}

/* A later draw over the whole target must not undo what an earlier one stored. */
static void storage_is_kept_and_ordered(void **state)
{
	static const char count[] =
		"#version 450 core\n"
		"layout(std430, binding = 0) buffer counts { uint count[]; };\n"
		"layout(location = 0) out int result;\n"
		"void main() { atomicAdd(count[uint(gl_FragCoord.x) % 4u], 1u); result = 0; }\n";
	uint32_t read[4], first = 100;
	int32_t value = 1;
	struct gpu_buffer *buffer;
	(void)state;
	need_gpu();
	struct gpu_texture *texture = ints_texture(NULL, 64, 64);
	struct gpu_target *target = target_over(texture, NULL);
	struct gpu_program *counting = program_of(full, count), *painting = program_of(full, paint);
	assert_ok(gpu_buffer_create(test_gpu, GPU_STORAGE, sizeof read, NULL, &buffer));
	gpu_buffer_write(buffer, 0, sizeof first, &first);
	struct gpu_pass pass = {.target = target, .viewport = {0, 0, 64, 64}, .storage = {buffer}, .program = counting};
	gpu_pass_run(test_gpu, &pass);
	gpu_pass_run(test_gpu, &pass);
	gpu_pass_run(test_gpu, &(struct gpu_pass){
		.target = target,
		.viewport = {0, 0, 64, 64},
		.program = painting,
		.params = &value,
		.params_bytes = sizeof value,
	});
	gpu_buffer_read(buffer, 0, sizeof read, read);
	assert_ok(gpu_check(test_gpu, "storage"));
	for (int i = 0; i < 4; i++)
		assert_int_equal(read[i], 2 * 1024 + (i == 0 ? 100 : 0));
	gpu_target_destroy(target);
	gpu_texture_destroy(texture);
	gpu_buffer_destroy(buffer);
}

TEST_PROGRAM(pass)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_pass_sees_its_own_parameters),
		cmocka_unit_test(normalised_and_float_textures_are_drawn_and_sampled),
		cmocka_unit_test(the_time_of_passes_is_counted_by_stage),
		cmocka_unit_test(nothing_outside_the_viewport_is_written),
		cmocka_unit_test(a_pass_reads_what_the_one_before_wrote),
		cmocka_unit_test(depth_is_reversed_and_sides_are_culled_when_asked),
		cmocka_unit_test(a_pass_reads_the_list_as_it_was_when_it_was_run),
		cmocka_unit_test(storage_is_kept_and_ordered),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
