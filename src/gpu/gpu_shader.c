/*
 * One shader's text from its files: `#include "lib/x.glsl"` is replaced by that file, once a
 * shader; defines follow the #version line. #line directives make every line of the joined text
 * say where it is from: its number is FILE_LINES x the file's number + its line. (GLSL has source
 * numbers for that, but Mesa forgets them and always says 0.)
 */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/internal.h"

#define FILE_LINES 10000
#define ADVICE "this is a fault of the program, report it"

static enum status append(struct gpu_shader *shader, const char *text, size_t length)
{
	TRY(mem_grow(&shader->text, &shader->capacity, shader->length + length + 1, 1, "shader"));
	memcpy(shader->text + shader->length, text, length);
	shader->length += length;
	shader->text[shader->length] = '\0';
	return STATUS_OK;
}

/* Appends a #line: the next line is line `line` of file number `file`. */
static enum status append_line_number(struct gpu_shader *shader, int line, uint32_t file)
{
	char text[24];
	assert(line < FILE_LINES);
	int length = snprintf(text, sizeof text, "#line %u\n", file * FILE_LINES + (uint32_t)line);
	return append(shader, text, (size_t)length);
}

static const struct shader_text *find(const struct shader_text *table, const char *path, size_t length)
{
	for (; table->path != NULL; table++)
		if (strlen(table->path) == length && memcmp(table->path, path, length) == 0)
			return table;
	return NULL;
}

static const char *line_end(const char *line)
{
	const char *end = strchr(line, '\n');
	return end != NULL ? end + 1 : line + strlen(line);
}

/* True if the line is an #include; the path between its quotes. */
static bool parse_include(const char *line, const char *end, const char **path, size_t *length)
{
	static const char word[] = "#include \"";
	if (strncmp(line, word, sizeof word - 1) != 0)
		return false;
	*path = line + sizeof word - 1;
	const char *quote = memchr(*path, '"', (size_t)(end - *path));
	*length = (size_t)((quote != NULL ? quote : end) - *path);
	return true;
}

static bool included(const struct gpu_shader *shader, const char *path)
{
	for (uint32_t i = 0; i < shader->file_count; i++)
		if (strcmp(shader->files[i], path) == 0)
			return true;
	return false;
}

/* Appends `file` from `text` on, which is its line `line`. Recursion ends: a file is added once. */
static enum status append_file(const struct shader_text *table, const struct shader_text *file, const char *text,
			       int line, struct gpu_shader *shader)
{
	uint32_t number = shader->file_count;
	if (number == GPU_SHADER_FILES)
		return fail_with(STATUS_FAILED, "shader %s: it includes too many files; " ADVICE, file->path);
	shader->files[shader->file_count++] = file->path;
	TRY(append_line_number(shader, line, number));
	for (const char *end; *text != '\0'; text = end, line++) {
		const char *path;
		size_t length;
		end = line_end(text);
		if (!parse_include(text, end, &path, &length)) {
			TRY(append(shader, text, (size_t)(end - text)));
			if (end[-1] != '\n')
				TRY(append(shader, "\n", 1));
			continue;
		}
		const struct shader_text *other = find(table, path, length);
		if (other == NULL)
			return fail_with(STATUS_FAILED, "shader %s:%d: there is no file \"%.*s\"; " ADVICE, file->path, line,
					 (int)length, path);
		if (!included(shader, other->path))
			TRY(append_file(table, other, other->text, 1, shader));
		TRY(append_line_number(shader, line + 1, number));
	}
	return STATUS_OK;
}

enum status gpu_shader_assemble(const struct shader_text *table, const char *path,
				const char *const *defines, struct gpu_shader *shader)
{
	*shader = (struct gpu_shader){0};
	const struct shader_text *file = find(table, path, strlen(path));
	if (file == NULL)
		return fail_with(STATUS_FAILED, "shader %s: there is no such file; " ADVICE, path);
	if (strncmp(file->text, "#version ", 9) != 0)
		return fail_with(STATUS_FAILED, "shader %s:1: it does not begin with #version; " ADVICE, path);
	const char *rest = line_end(file->text);
	TRY(append(shader, file->text, (size_t)(rest - file->text)));
	for (size_t i = 0; i < GPU_DEFINES_MAX && defines[i] != NULL; i++) {
		char line[128];
		int length = snprintf(line, sizeof line, "#define %s\n", defines[i]);
		assert(length > 0 && (size_t)length < sizeof line);
		TRY(append(shader, line, (size_t)length));
	}
	return append_file(table, file, rest, 2, shader);
}

void gpu_shader_finish(struct gpu_shader *shader)
{
	mem_free(shader->text);
	*shader = (struct gpu_shader){0};
}

/* Returns where a line of the log has the word "error", or NULL. */
static const char *error_word(const char *line, const char *end)
{
	for (const char *c = line; end - c >= 5; c++)
		if (strncmp(c, "error", 5) == 0 || strncmp(c, "ERROR", 5) == 0)
			return c;
	return NULL;
}

/*
 * Mesa says "SOURCE:LINE(COLUMN): error: ...", NVIDIA "SOURCE(LINE) : error ...", others
 * "ERROR: SOURCE:LINE: ...". The joined text's numbers mean nothing to a reader and are cut off
 * where they come first.
 */
void gpu_shader_locate(const struct gpu_shader *shader, const char *log, const char **file, int *line,
		       char *text, size_t text_bytes)
{
	const char *at = log, *word = NULL;
	for (const char *next = log; word == NULL && *next != '\0'; next = line_end(next))
		if ((word = error_word(next, line_end(next))) != NULL)
			at = next;
	*file = shader->file_count > 0 ? shader->files[0] : "";
	*line = 0;
	const char *number = strncmp(at, "ERROR: ", 7) == 0 ? at + 7 : at;
	if (isdigit((unsigned char)*number)) {
		char *after;
		(void)strtoul(number, &after, 10);
		unsigned long joined = *after == ':' || *after == '(' ? strtoul(after + 1, NULL, 10) : 0;
		if (joined % FILE_LINES != 0 && joined / FILE_LINES < shader->file_count) {
			*file = shader->files[joined / FILE_LINES];
			*line = (int)(joined % FILE_LINES);
			at = word != NULL ? word : at;
		}
	}
	snprintf(text, text_bytes, "%.*s", (int)strcspn(at, "\r\n"), at);
}
