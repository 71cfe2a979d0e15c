/*
 * The files that a model names: meshes, images, height fields, further XML. MuJoCo opens them by name, so each is looked at first.
 *
 * 1. A name is relative, and what it leads to lies in the model's folder, in the folder above, or below these.
 * 2. It is a regular file: a pipe would hold the program for ever.
 *
 * MuJoCo looks for a file in the model's folder or in one that `compiler` names, with or without the folders of the name. All of
 * these are looked at.
 */
#include "vehicle/check.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const char beside[] = "put the file beside the model, and name it from there";
static const char package[] = "package://"; /* MuJoCo takes it off in a URDF */

char *vehicle_check_path(const struct vehicle_check *check, const char *folder, const char *name)
{
	const char *slash = strrchr(check->path, '/');
	const size_t length = slash != NULL ? (size_t)(slash - check->path) + 1 : 0, room = length + strlen(name) + (folder != NULL ? strlen(folder) : 0) + 2;
	char *path = mem_alloc(room, 1);
	if (path != NULL)
		snprintf(path, room, "%.*s%s%s%s", (int)length, check->path, folder != NULL ? folder : "", folder != NULL ? "/" : "", name);
	return path;
}

enum status vehicle_check_read(struct vehicle_check *check, const char *path, char **text, size_t *length)
{
	struct stat found;
	FILE *file = input_open(path);
	if (file == NULL || fstat(fileno(file), &found) != 0) {
		enum status status = fail_with(STATUS_INPUT, "%s: %s: %s; name a file that can be read", check->where, path, input_problem());
		if (file != NULL)
			fclose(file);
		return status;
	}
	if (found.st_size > (off_t)(VEHICLE_CHECK_TEXTS - check->texts)) {
		fclose(file);
		return fail_with(STATUS_INPUT, "%s: %s: it is too large; allowed: %zu bytes with all that it includes; make it smaller", check->where, path,
				 VEHICLE_CHECK_TEXTS);
	}
	*text = mem_alloc((size_t)found.st_size + 1, 1);
	*length = *text != NULL ? fread(*text, 1, (size_t)found.st_size, file) : 0;
	if (*text != NULL)
		(*text)[*length] = '\0';
	check->texts += *length;
	fclose(file);
	return *text != NULL ? STATUS_OK : fail_memory("a vehicle");
}

static enum status refuse(const struct vehicle_check *check, const char *name, const char *why, const char *what_to_do)
{
	return fail_with(STATUS_INPUT, "%s: %s: it names the file \"%.100s\": %s; %s", check->where, check->path, name, why, what_to_do);
}

static char *text_of(const char *text, size_t length)
{
	char *copy = mem_alloc(length + 1, 1);
	if (copy != NULL)
		snprintf(copy, length + 1, "%.*s", (int)length, text);
	return copy;
}

static const char *without_package(const char *name)
{
	return strncmp(name, package, strlen(package)) == 0 ? name + strlen(package) : name;
}

static enum status check_written(const struct vehicle_check *check, const char *name)
{
	const char *rest = without_package(name);
	if (strchr(name, '&') != NULL)
		return refuse(check, name, "it has an &", "give it another name");
	return rest[0] == '/' || rest[0] == '\\' || strchr(rest, ':') != NULL ? refuse(check, name, "only names that are relative are followed", beside) : STATUS_OK;
}

enum status vehicle_check_name_add(struct vehicle_check *check, const char *text, size_t length, bool include)
{
	if (length >= PATH_MAX)
		return fail_with(STATUS_INPUT, "%s: %s: the name of a file has %zu characters; give a shorter one", check->where, check->path, length);
	TRY(mem_grow(&check->names, &check->name_room, check->name_count + 1, sizeof *check->names, "a vehicle"));
	char *copy = text_of(text, length);
	TRY_MEM(copy, "a vehicle");
	check->names[check->name_count++] = (struct vehicle_check_name){copy, include};
	return check_written(check, copy);
}

enum status vehicle_check_folder_add(struct vehicle_check *check, const char *text, size_t length)
{
	const size_t most = sizeof check->folders / sizeof check->folders[0];
	if (check->folder_count == most || length >= PATH_MAX)
		return fail_with(STATUS_INPUT, "%s: %s: it names more than %zu folders of files, or a long one; name them once", check->where, check->path,
				 most);
	char *copy = text_of(text, length);
	TRY_MEM(copy, "a vehicle");
	check->folders[check->folder_count++] = copy;
	return check_written(check, copy);
}

/* --- where a name leads --- */

bool vehicle_check_is_below(const char *path, const char *folder)
{
	const size_t length = strlen(folder);
	return strncmp(path, folder, length) == 0 && (path[length] == '/' || (length > 0 && folder[length - 1] == '/'));
}

void vehicle_check_cut(char *path)
{
	char *slash = strrchr(path, '/');
	if (slash != NULL)
		*(slash == path ? slash + 1 : slash) = '\0';
}

/* The width and height of a PNG; 0: it is none. Unpacked, each pixel takes up to 8 bytes. */
static double png_bytes(const char *path)
{
	unsigned char head[24];
	FILE *file = input_open(path);
	const bool read = file != NULL && fread(head, sizeof head, 1, file) == 1;
	if (file != NULL)
		fclose(file);
	if (!read || memcmp(head, "\x89PNG", 4) != 0)
		return 0;
	double side[2] = {0, 0};
	for (int i = 0; i < 8; i++)
		side[i / 4] = side[i / 4] * 256 + head[16 + i];
	return 8 * side[0] * side[1];
}

static enum status check_mesh(const char *path, bool obj, size_t bytes, const char **problem)
{
	FILE *file = input_open(path);
	char *text = mem_calloc(bytes + 1, 1);
	if (file != NULL && text != NULL) {
		const size_t length = fread(text, 1, bytes, file);
		*problem = obj ? vehicle_check_obj(text, length) : vehicle_check_msh(text, length);
	}
	if (file != NULL)
		fclose(file);
	enum status status = text != NULL ? STATUS_OK : fail_memory("a vehicle");
	mem_free(text);
	return status;
}

/* Looks at what a name leads to; a folder may be the first part of a name. */
static enum status check_regular(struct vehicle_check *check, const char *path, const char *name)
{
	struct stat found;
	if (stat(path, &found) != 0 || S_ISDIR(found.st_mode))
		return STATUS_OK;
	if (!S_ISREG(found.st_mode))
		return refuse(check, name, "not a file", "name a file");
	if (found.st_size > VEHICLE_CHECK_FILE)
		return refuse(check, name, "it has more than 64 MiB", "give a smaller one");
	check->bytes += png_bytes(path);
	const char *dot = strrchr(path, '.'), *problem = NULL;
	if (dot != NULL && (strcasecmp(dot, ".obj") == 0 || strcasecmp(dot, ".msh") == 0))
		TRY(check_mesh(path, strcasecmp(dot, ".obj") == 0, (size_t)found.st_size, &problem));
	return problem != NULL ? refuse(check, name, problem, "export it again") : STATUS_OK;
}

enum status vehicle_check_mesh_file(const char *where, const char *model, const char *path, const char *name)
{
	struct vehicle_check check = {.where = where, .path = model, .reach = ""};
	return check_regular(&check, path, name);
}

static enum status check_place(struct vehicle_check *check, const char *path, const char *name)
{
	char real[PATH_MAX];
	struct stat found;
	if (stat(path, &found) != 0)
		return STATUS_OK; /* MuJoCo does not find it there */
	if (realpath(path, real) == NULL)
		return refuse(check, name, strerror(errno), beside);
	if (!vehicle_check_is_below(real, check->reach))
		return refuse(check, name, "it lies neither in the model's folder nor in the one above", beside);
	return check_regular(check, path, name);
}

/* Checks where one form of a name leads. `folder`: where the file is looked for; NULL: the model's folder. */
static enum status check_form(struct vehicle_check *check, const char *folder, const char *form, const char *name)
{
	char *path = vehicle_check_path(check, folder, form);
	TRY_MEM(path, "a vehicle");
	enum status status = check_place(check, path, name);
	mem_free(path);
	return status;
}

enum status vehicle_check_name(struct vehicle_check *check, const char *name)
{
	const char *slash = strrchr(name, '/'), *forms[] = {name, without_package(name), slash != NULL ? slash + 1 : name};
	for (size_t folder = 0; folder <= check->folder_count; folder++)
		for (size_t i = 0; i < 3; i++)
			if (i == 0 || strcmp(forms[i], forms[i - 1]) != 0)
				TRY(check_form(check, folder > 0 ? check->folders[folder - 1] : NULL, forms[i], name));
	return STATUS_OK;
}

enum status vehicle_check_reach(struct vehicle_check *check)
{
	char real[PATH_MAX], *folder = vehicle_check_path(check, NULL, ".");
	TRY_MEM(folder, "a vehicle");
	const bool found = realpath(folder, real) != NULL;
	mem_free(folder);
	if (!found)
		return fail_with(STATUS_INPUT, "%s: %s: %s; name a file that can be read", check->where, check->path, strerror(errno));
	vehicle_check_cut(real);
	return mem_text(&check->reach, real, "a vehicle");
}
