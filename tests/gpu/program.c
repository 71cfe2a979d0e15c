/* Programs: variants, includes, what an error says, and that every shader of the program compiles. */
#include "gpu_test.h"
#include "../support/program.h"

static void the_same_request_is_the_same_program(void **state)
{
	struct gpu_program *first, *second, *variant, *other;
	struct gpu_stats before, after;
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "decimate.frag"};
	(void)state;
	need_gpu();
	gpu_stats(test_gpu, &before);
	assert_ok(gpu_program_get(test_gpu, &request, &first));
	assert_ok(gpu_program_get(test_gpu, &request, &second));
	request.defines[0] = "DISTURBANCE";
	assert_ok(gpu_program_get(test_gpu, &request, &variant));
	request.defines[1] = "DEPTH 2";
	assert_ok(gpu_program_get(test_gpu, &request, &other));
	gpu_stats(test_gpu, &after);
	assert_ptr_equal(first, second);
	assert_ptr_not_equal(first, variant);
	assert_ptr_not_equal(variant, other);
	assert_int_equal(after.programs - before.programs, 3);
}

/* What gpu_program_get says of a program whose fragment shader is `fragment`. */
static const char *error_of(const char *fragment, const char *include, const char *define)
{
	struct shader_text table[] = {
		{"bad.frag", fragment},
		{"lib/part.glsl", include},
		{"lib/good.glsl", "int good() { return 1; }\n"},
		{"plain.vert", "#version 450 core\nvoid main() { gl_Position = vec4(0.0); }\n"},
		{NULL, NULL},
	};
	struct gpu_program *program;
	struct gpu_program_request request = {.vertex = "plain.vert", .fragment = "bad.frag", .defines = {define}};
	assert_int_equal(gpu_program_get_from(test_gpu, table, &request, &program), STATUS_FAILED);
	assert_ok(gpu_check(test_gpu, "a bad shader")); /* the gpu itself is well */
	return failure_message();
}

#define assert_says(message, part)                                                                 \
	do {                                                                                       \
		if (strstr(message, part) == NULL)                                                 \
			fail_msg("\"%s\" does not say \"%s\"", message, part);                     \
	} while (0)

static void a_compile_error_names_the_file_and_the_line(void **state)
{
	(void)state;
	need_gpu();
	const char *message = error_of("#version 450 core\n"
				       "#include \"lib/good.glsl\"\n"
				       "out int x;\n"
				       "\n"
				       "void main() { x = undeclared_name; }\n", "", "SOME 1");
	assert_says(message, "shader bad.frag:5 with SOME 1: ");
	assert_says(message, "undeclared_name");
	assert_says(message, "; ");
}

static void an_error_in_an_included_file_names_that_file(void **state)
{
	(void)state;
	need_gpu();
	const char *message = error_of("#version 450 core\n"
				       "#include \"lib/part.glsl\"\n"
				       "out int x;\n"
				       "void main() { x = part(); }\n",
				       "#include \"lib/good.glsl\"\n"
				       "\n"
				       "int part() { return another_name; }\n", NULL);
	assert_says(message, "shader lib/part.glsl:3: ");
	assert_says(message, "another_name");
}

static void a_missing_file_is_told_with_its_place(void **state)
{
	struct gpu_program *program;
	(void)state;
	need_gpu();
	const char *message = error_of("#version 450 core\n"
				       "out int x;\n"
				       "#include \"lib/absent.glsl\"\n", "", NULL);
	assert_says(message, "shader bad.frag:3: there is no file \"lib/absent.glsl\"");
	message = error_of("void main() {}\n", "", NULL);
	assert_says(message, "shader bad.frag:1: ");
	assert_int_equal(gpu_program_get(test_gpu, &(struct gpu_program_request){.vertex = "full.vert", .fragment = "absent.frag"}, &program),
			 STATUS_FAILED);
	assert_says(failure_message(), "absent.frag");
}

static void a_link_error_is_told(void **state)
{
	(void)state;
	need_gpu();
	const char *message = error_of("#version 450 core\n"
				       "in vec4 never_written;\n"
				       "out vec4 x;\n"
				       "vec4 nowhere();\n"
				       "void main() { x = never_written + nowhere(); }\n", "", NULL);
	assert_says(message, "shader bad.frag");
	assert_says(message, "nowhere");
}

static void every_drivers_way_to_name_a_line_is_understood(void **state)
{
	static const struct gpu_shader shader = {.files = {"a.frag", "lib/b.glsl"}, .file_count = 2};
	static const struct {
		const char *log, *file;
		int line;
		const char *text;
	} cases[] = {
		{"0:10012(7): error: undeclared\n", "lib/b.glsl", 12, "error: undeclared"},
		{"0:3(1): warning: unused\n0:10009(2): error: no\n", "lib/b.glsl", 9, "error: no"},
		{"0(10034) : error C1503: undefined\n", "lib/b.glsl", 34, "error C1503: undefined"},
		{"ERROR: 0:8: undeclared\n", "a.frag", 8, "ERROR: 0:8: undeclared"},
		{"error: not compiled\n", "a.frag", 0, "error: not compiled"},
		{"0:70012(7): error: no such file\n", "a.frag", 0, "0:70012(7): error: no such file"},
		{"", "a.frag", 0, ""},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		const char *file;
		char text[64];
		int line;
		gpu_shader_locate(&shader, cases[i].log, &file, &line, text, sizeof text);
		assert_string_equal(file, cases[i].file);
		assert_int_equal(line, cases[i].line);
		assert_string_equal(text, cases[i].text);
	}
}

static void an_include_is_joined_once_and_lines_stay_right(void **state)
{
	static const struct shader_text table[] = {
		{"main.frag", "#version 450 core\n#include \"a.glsl\"\n#include \"b.glsl\"\nmain\n"},
		{"a.glsl", "#include \"b.glsl\"\na\n"},
		{"b.glsl", "b"},
		{NULL, NULL},
	};
	const char *defines[GPU_DEFINES_MAX] = {"X", "Y 2"};
	struct gpu_shader shader;
	(void)state;
	assert_ok(gpu_shader_assemble(table, "main.frag", defines, &shader));
	assert_string_equal(shader.text, "#version 450 core\n#define X\n#define Y 2\n#line 2\n#line 10001\n#line 20001\nb\n"
					 "#line 10002\na\n#line 3\n#line 4\nmain\n");
	assert_int_equal(shader.file_count, 3);
	gpu_shader_finish(&shader);
}

static void a_failed_allocation_is_told(void **state)
{
	struct gpu_program *program;
	struct gpu_program_request request = {.vertex = "full.vert", .fragment = "decimate.frag", .defines = {"UNUSED"}};
	(void)state;
	need_gpu();
	uint64_t nth = 1;
	for (;; nth++) {
		mem_fail_nth(nth, 0);
		enum status status = gpu_program_get(test_gpu, &request, &program);
		if (mem_fail_nth(0, 0) < nth)
			break;
		assert_int_equal(status, STATUS_FAILED);
		assert_says(failure_message(), "out of memory");
	}
	assert_true(nth > 4);
}

TEST_PROGRAM(program)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_same_request_is_the_same_program),
		cmocka_unit_test(a_compile_error_names_the_file_and_the_line),
		cmocka_unit_test(an_error_in_an_included_file_names_that_file),
		cmocka_unit_test(a_missing_file_is_told_with_its_place),
		cmocka_unit_test(a_link_error_is_told),
		cmocka_unit_test(every_drivers_way_to_name_a_line_is_understood),
		cmocka_unit_test(an_include_is_joined_once_and_lines_stay_right),
		cmocka_unit_test(a_failed_allocation_is_told),
	};
	return cmocka_run_group_tests(tests, open_gpu, close_gpu);
}
