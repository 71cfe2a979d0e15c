/*
 * Where the meshes of a model lie: beside it, in a package (package://NAME/FILE), or in a folder of `model_path`.
 *
 * A package is a folder NAME in `model_path`, or one that the model's own folder lies in. Files that are not found are told, and what has their shape is
 * left out; their links keep their masses.
 */
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "vehicle/check.h"
#include "vehicle/spec.h"

#define ABOVE 4 /* folders above the model's in which a package is looked for */

static const char package[] = "package://", local[] = "file://";

static bool is_file(const char *folder, const char *name, char path[PATH_MAX])
{
	char joined[PATH_MAX];
	return snprintf(joined, sizeof joined, "%s%s%s", folder, folder[0] != '\0' ? "/" : "", name) < (int)sizeof joined && access(joined, R_OK) == 0 &&
	       realpath(joined, path) != NULL;
}

static const char *base_of(const char *folder)
{
	const char *slash = strrchr(folder, '/');
	return slash != NULL ? slash + 1 : folder;
}

/* Looks for a package's file in a folder: the package itself, or one that holds it. */
static bool in_package(const char *folder, const char *name, char path[PATH_MAX])
{
	const char *rest = strchr(name, '/');
	const size_t length = rest != NULL ? (size_t)(rest - name) : 0;
	const char *base = base_of(folder);
	if (length == 0)
		return false;
	/* The folder of a package often has another name than the package. */
	return (strlen(base) == length && strncmp(base, name, length) == 0 && is_file(folder, rest + 1, path)) || is_file(folder, name, path) ||
	       (strchr(rest + 1, '/') != NULL && is_file(folder, rest + 1, path));
}

/* The model's own folder, whole. */
static bool folder_of(const struct spec *spec, char folder[PATH_MAX])
{
	if (realpath(spec->path, folder) == NULL)
		return false;
	vehicle_check_cut(folder);
	return true;
}

/* Finds a mesh. Returns false if it is nowhere. */
static bool find(const struct spec *spec, const char *name, char path[PATH_MAX])
{
	const struct scene_texts *places = &spec->scene->model_path;
	char folder[PATH_MAX];
	if (!folder_of(spec, folder))
		return false;
	if (strncmp(name, package, strlen(package)) == 0) {
		name += strlen(package);
		for (size_t i = 0; i < places->count; i++)
			if (in_package(places->list[i], name, path))
				return true;
		for (int i = 0; i <= ABOVE && folder[1] != '\0'; i++, vehicle_check_cut(folder))
			if (in_package(folder, name, path))
				return true;
		return false;
	}
	if (strncmp(name, local, strlen(local)) == 0)
		name += strlen(local);
	if (name[0] == '/')
		return is_file("", name, path);
	char within[PATH_MAX];
	const char *meshdir = spec->spec != NULL ? mjs_getString(spec->spec->compiler.meshdir) : spec->meshdir;
	snprintf(within, sizeof within, "%.2000s/%.2000s", folder, meshdir != NULL ? meshdir : "");
	if (is_file(within, name, path) || is_file(folder, name, path))
		return true;
	for (size_t i = 0; i < places->count; i++)
		if (is_file(places->list[i], name, path))
			return true;
	return false;
}

/* Returns true if a file may be read: it lies in the model's folder, in one above, or in a folder of model_path. */
static bool may_read(const struct spec *spec, const char *name, const char *path)
{
	char folder[PATH_MAX];
	if (!folder_of(spec, folder))
		return false;
	const int above = strncmp(name, package, strlen(package)) == 0 ? ABOVE : 1;
	for (int i = 0; i < above; i++) {
		char up[PATH_MAX];
		snprintf(up, sizeof up, "%s", folder);
		vehicle_check_cut(up);
		if (up[1] == '\0')
			break; /* not the whole machine */
		memcpy(folder, up, sizeof up);
	}
	if (vehicle_check_is_below(path, folder))
		return true;
	for (size_t i = 0; i < spec->scene->model_path.count; i++)
		if (realpath(spec->scene->model_path.list[i], folder) != NULL && vehicle_check_is_below(path, folder))
			return true;
	return false;
}

bool vehicle_spec_find(const struct spec *spec, const char *name, char path[])
{
	return find(spec, name, path) && may_read(spec, name, path);
}

/* Takes the geoms of a mesh out of the model. */
static void leave_out(struct spec *spec, mjsMesh *mesh)
{
	const char *name = mjs_getString(mjs_getName(mesh->element));
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM), *next; each != NULL; each = next) {
		next = mjs_nextElement(spec->spec, each);
		const char *of = mjs_getString(mjs_asGeom(each)->meshname);
		if (of != NULL && strcmp(of, name) == 0)
			(void)mjs_delete(spec->spec, each);
	}
	(void)mjs_delete(spec->spec, mesh->element);
}

static bool reads(const char *path)
{
	static const char *const known[] = {".stl", ".obj", ".msh"};
	const char *dot = strrchr(path, '.');
	for (size_t i = 0; i < sizeof known / sizeof known[0] && dot != NULL; i++)
		if (strcasecmp(dot, known[i]) == 0)
			return true;
	return false;
}

/* Finds the file of one mesh, or takes the mesh out. */
static enum status place(struct spec *spec, mjsMesh *mesh, struct spec_names *missing, struct spec_names *strange)
{
	char path[PATH_MAX];
	const char *name = mjs_getString(mesh->file);
	if (name == NULL || name[0] == '\0')
		return STATUS_OK;
	if (!find(spec, name, path)) {
		vehicle_spec_name(missing, base_of(name));
		leave_out(spec, mesh);
		return STATUS_OK;
	}
	if (!may_read(spec, name, path))
		return fail_with(STATUS_INPUT, "%s: %s: it names the file \"%.100s\": it lies neither in the model's folder nor in the one above; name its folder in model_path", spec->where,
				 spec->path, name);
	if (!reads(path)) {
		vehicle_spec_name(strange, base_of(name));
		leave_out(spec, mesh);
		return STATUS_OK;
	}
	TRY(vehicle_check_mesh_file(spec->where, spec->path, path, name));
	mjs_setString(mesh->file, path);
	return STATUS_OK;
}

enum status vehicle_spec_meshes(struct spec *spec)
{
	struct spec_names missing = {.count = 0}, strange = {.count = 0};
	if (!spec->urdf)
		return STATUS_OK; /* names in an MJCF are looked at before it is read: check_files.c */
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_MESH), *next; each != NULL; each = next) {
		next = mjs_nextElement(spec->spec, each);
		TRY(place(spec, mjs_asMesh(each), &missing, &strange));
	}
	mjs_setString(spec->spec->compiler.meshdir, "");
	if (missing.count > 0)
		vehicle_spec_tell(spec, "%zu mesh%s not found (%s): without %s its shape is left out, its mass stays; name the folder of its packages in model_path", missing.count,
				  missing.count > 1 ? "es are" : " is", missing.text, missing.count > 1 ? "them" : "it");
	if (strange.count > 0)
		vehicle_spec_tell(spec, "%zu mesh%s neither STL nor OBJ (%s): the shape is left out, its mass stays; export it as STL", strange.count, strange.count > 1 ? "es are" : " is",
				  strange.text);
	return STATUS_OK;
}
