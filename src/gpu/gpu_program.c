/*
 * Programs, linked when first asked for and kept until the gpu ends. The key of a request is its
 * files and its defines in their order.
 */
#include <stdio.h>
#include <string.h>

#include "gpu/internal.h"

#define LOG_BYTES 4096

/* Appends to `text`, which holds `used` of its `size`; how long all of it would be. */
static size_t append(char *text, size_t size, size_t used, const char *word, char behind)
{
	int length = snprintf(used < size ? text + used : NULL, used < size ? size - used : 0, "%s%c", word, behind);
	return used + (size_t)length;
}

/* Each part and `behind` it. */
static size_t write_request(const struct gpu_program_request *request, char behind, char *text, size_t size)
{
	const char *const files[] = {request->vertex, request->fragment};
	size_t used = 0;
	for (int i = 0; i < 2; i++)
		used = append(text, size, used, files[i], behind);
	for (size_t i = 0; i < GPU_DEFINES_MAX && request->defines[i] != NULL; i++)
		used = append(text, size, used, request->defines[i], behind);
	return used;
}

void gpu_program_name(const struct gpu_program_request *request, char *name, size_t size)
{
	size_t length = write_request(request, ' ', name, size);
	if (length < size)
		name[length - 1] = '\0';
}

static char *request_key(const struct gpu_program_request *request)
{
	size_t bytes = write_request(request, '\n', NULL, 0) + 1;
	char *key = mem_alloc(bytes, 1);
	if (key != NULL)
		write_request(request, '\n', key, bytes);
	return key;
}

/* "shader FILE:LINE (DEFINES): what the driver says; what to do" */
static enum status fail_compile(struct gpu *gpu, const struct gpu_shader *shader, const char *log,
				const struct gpu_program_request *request)
{
	const char *file;
	char text[256], place[16] = "", variant[128] = "";
	size_t used = 0;
	int line;
	gpu_shader_locate(shader, log, &file, &line, text, sizeof text);
	if (line > 0)
		snprintf(place, sizeof place, ":%d", line);
	for (size_t i = 0; i < GPU_DEFINES_MAX && request->defines[i] != NULL && used < sizeof variant; i++)
		used += (size_t)snprintf(variant + used, sizeof variant - used, "%s%s", i == 0 ? " with " : ", ",
					 request->defines[i]);
	return fail_with(STATUS_FAILED, "shader %s%s%s: %s; report this, or try another GL driver than %.60s", file, place,
			 variant, text, gpu->info.renderer);
}

static enum status compile(struct gpu *gpu, const struct shader_text *table, GLenum kind, const char *path,
			   const struct gpu_program_request *request, GLuint *out)
{
	struct gpu_shader shader;
	GLint ok = GL_FALSE;
	GLuint name = 0;
	enum status status;
	TRY_OR(done, gpu_shader_assemble(table, path, request->defines, &shader));
	name = glCreateShader(kind);
	const char *text = shader.text;
	GLint length = (GLint)shader.length;
	glShaderSource(name, 1, &text, &length);
	glCompileShader(name);
	glGetShaderiv(name, GL_COMPILE_STATUS, &ok);
	if (ok) {
		*out = name;
	} else {
		char log[LOG_BYTES] = "";
		glGetShaderInfoLog(name, sizeof log, NULL, log);
		status = fail_compile(gpu, &shader, log, request);
		glDeleteShader(name);
	}
done:
	gpu_shader_finish(&shader);
	return status;
}

static enum status link_program(struct gpu *gpu, const struct shader_text *table,
				const struct gpu_program_request *request, GLuint *out)
{
	const struct {
		GLenum kind;
		const char *path;
	} parts[] = {{GL_VERTEX_SHADER, request->vertex}, {GL_FRAGMENT_SHADER, request->fragment}};
	enum { PARTS = sizeof parts / sizeof *parts };
	GLuint shaders[PARTS] = {0}, name = 0;
	GLint ok = GL_FALSE;
	enum status status = STATUS_OK;
	for (int i = 0; i < PARTS; i++)
		TRY_OR(done, compile(gpu, table, parts[i].kind, parts[i].path, request, &shaders[i]));
	name = glCreateProgram();
	for (int i = 0; i < PARTS; i++)
		glAttachShader(name, shaders[i]);
	glLinkProgram(name);
	glGetProgramiv(name, GL_LINK_STATUS, &ok);
	if (!ok) {
		char log[LOG_BYTES] = "";
		struct gpu_shader none = {.files = {request->fragment}, .file_count = 1};
		glGetProgramInfoLog(name, sizeof log, NULL, log);
		status = fail_compile(gpu, &none, log, request);
	} else {
		status = gpu_check(gpu, request->fragment);
	}
	if (status != STATUS_OK)
		glDeleteProgram(name);
	else
		*out = name;
done:
	for (int i = 0; i < PARTS; i++)
		glDeleteShader(shaders[i]); /* 0 is ignored; an attached one lives on in the program */
	return status;
}

static void tell_unplanned(struct gpu *gpu, const struct gpu_program_request *request)
{
	char name[GPU_PROGRAM_NAME];
	if (gpu->stats.unplanned++ > 0)
		return;
	gpu_program_name(request, name, sizeof name);
	note("program %s: it was linked during the drive, and nothing planned it; report this", name);
}

void gpu_seal(struct gpu *gpu)
{
	gpu->sealed = true;
}

void gpu_programs_each(const struct gpu *gpu, void (*each)(void *user, const char *name, uint64_t passes), void *user)
{
	for (const struct gpu_program *program = gpu != NULL ? gpu->programs : NULL; program != NULL; program = program->next) {
		char name[GPU_PROGRAM_NAME];
		snprintf(name, sizeof name, "%s", program->key);
		for (char *at = strchr(name, '\n'); at != NULL; at = strchr(at, '\n'))
			*at = at[1] != '\0' ? ' ' : '\0';
		each(user, name, program->passes);
	}
}

enum status gpu_program_get_from(struct gpu *gpu, const struct shader_text *table,
				 const struct gpu_program_request *request, struct gpu_program **out)
{
	assert(request->vertex != NULL && request->fragment != NULL);
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	char *key = request_key(request);
	TRY_MEM(key, "GL program");
	for (struct gpu_program *program = gpu->programs; program != NULL; program = program->next) {
		if (program->table == table && strcmp(program->key, key) == 0) {
			mem_free(key);
			*out = program;
			return STATUS_OK;
		}
	}
	struct gpu_program *program = mem_calloc(1, sizeof *program);
	enum status status = program != NULL ? link_program(gpu, table, request, &program->name) : fail_memory("GL program");
	if (status != STATUS_OK) {
		mem_free_all(program, key);
		return status;
	}
	program->key = key;
	program->table = table;
	program->next = gpu->programs;
	gpu->programs = program;
	gpu->stats.programs++;
	if (gpu->sealed)
		tell_unplanned(gpu, request);
	*out = program;
	return STATUS_OK;
}

enum status gpu_program_get(struct gpu *gpu, const struct gpu_program_request *request, struct gpu_program **out)
{
	return gpu_program_get_from(gpu, gpu_shader_table, request, out);
}

void gpu_programs_finish(struct gpu *gpu)
{
	while (gpu->programs != NULL) {
		struct gpu_program *program = gpu->programs;
		gpu->programs = program->next;
		glDeleteProgram(program->name);
		mem_free_all(program->key, program);
		gpu->stats.programs--;
	}
	gpu->program = NULL;
}
