/*
 * Where the meshes of a model lie: beside it, in a package (package://NAME/FILE), or in a folder of `model_path`.
 *
 * A package is a folder NAME in `model_path`, or one that the model's own folder lies in. A folder near it whose package.xml has that name is one, too. Files that are not
 * found are told, and what has their shape is left out; their links keep their masses. What MuJoCo does not read is read as the mesh of an object is.
 */
#include <dirent.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "vehicle/check.h"
#include "vehicle/spec.h"

#define ABOVE 4       /* folders above the model's in which a package is looked for */
#define BELOW 3       /* and how far below these */
#define FOLDERS_MOST 3000 /* that are looked into for one package */

static const char package[] = "package://", model_scheme[] = "model://", local[] = "file://";

/* What was done about meshes and images. */
struct files {
	struct spec_names missing, strange, massless, images;
};

static bool is_file(const char *folder, const char *name, char path[PATH_MAX])
{
	char joined[PATH_MAX];
	return snprintf(joined, sizeof joined, "%s%s%s", folder, folder[0] != '\0' ? "/" : "", name) < (int)sizeof joined && access(joined, R_OK) == 0 &&
	       realpath(joined, path) != NULL;
}

/* Looks for a package's file in a folder: the package itself, or one that holds it. */
static bool in_package(const char *folder, const char *name, char path[PATH_MAX])
{
	const char *rest = strchr(name, '/');
	const size_t length = rest != NULL ? (size_t)(rest - name) : 0;
	const char *base = vehicle_spec_base(folder);
	if (length == 0)
		return false;
	/* The folder of a package often has another name than the package. */
	return (strlen(base) == length && strncmp(base, name, length) == 0 && is_file(folder, rest + 1, path)) || is_file(folder, name, path) ||
	       (strchr(rest + 1, '/') != NULL && is_file(folder, rest + 1, path));
}

static bool reads_name(const char *folder, const char *name, size_t length)
{
	char path[PATH_MAX], text[4096];
	if (snprintf(path, sizeof path, "%s/package.xml", folder) >= (int)sizeof path)
		return false;
	FILE *file = input_open(path);
	const size_t read = file != NULL ? fread(text, 1, sizeof text - 1, file) : 0;
	if (file != NULL)
		fclose(file);
	text[read] = '\0';
	const char *at = strstr(text, "<name>");
	if (at == NULL)
		return false;
	at += strlen("<name>");
	at += strspn(at, " \t\r\n");
	return strncmp(at, name, length) == 0 && strchr(" \t\r\n<", at[length]) != NULL;
}

/* Looks for the folder of a package, by its package.xml, in a folder and below it. */
static bool find_package(const char *folder, const char *name, size_t length, int below, int *left, char out[PATH_MAX])
{
	if (*left <= 0)
		return false;
	(*left)--;
	if (reads_name(folder, name, length))
		return snprintf(out, PATH_MAX, "%s", folder) < PATH_MAX;
	DIR *list = below > 0 ? opendir(folder) : NULL;
	bool found = false;
	for (const struct dirent *each; list != NULL && !found && (each = readdir(list)) != NULL;) {
		char path[PATH_MAX];
		const bool is_folder = each->d_type == DT_DIR && each->d_name[0] != '.';
		if (is_folder && snprintf(path, sizeof path, "%s/%s", folder, each->d_name) < (int)sizeof path)
			found = find_package(path, name, length, below - 1, left, out);
	}
	if (list != NULL)
		closedir(list);
	return found;
}

/* The same by package.xml of folders around the model. */
static bool in_named_package(struct spec *spec, const char *folder, const char *name, char path[PATH_MAX])
{
	const char *rest = strchr(name, '/');
	const size_t length = rest != NULL ? (size_t)(rest - name) : 0;
	char from[PATH_MAX];
	int left = FOLDERS_MOST;
	if (length == 0 || length >= sizeof spec->package)
		return false;
	if (strncmp(spec->package, name, length) != 0 || spec->package[length] != '\0') {
		snprintf(spec->package, sizeof spec->package, "%.*s", (int)length, name);
		spec->package_folder[0] = '\0';
		snprintf(from, sizeof from, "%s", folder);
		bool found = false;
		for (int i = 0; i <= ABOVE && from[1] != '\0' && !found; i++, vehicle_check_cut(from))
			found = find_package(from, name, length, i == 0 ? 0 : BELOW, &left, spec->package_folder);
	}
	return spec->package_folder[0] != '\0' && is_file(spec->package_folder, rest + 1, path);
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
static bool find(struct spec *spec, const char *name, char path[PATH_MAX])
{
	const struct scene_texts *places = &spec->scene->model_path;
	char folder[PATH_MAX];
	if (!folder_of(spec, folder))
		return false;
	const char *scheme = strncmp(name, model_scheme, strlen(model_scheme)) == 0 ? model_scheme : package;
	if (strncmp(name, scheme, strlen(scheme)) == 0) {
		char beside[PATH_MAX];
		memcpy(beside, folder, sizeof beside);
		name += strlen(scheme);
		for (size_t i = 0; i < places->count; i++)
			if (in_package(places->list[i], name, path))
				return true;
		for (int i = 0; i <= ABOVE && folder[1] != '\0'; i++, vehicle_check_cut(folder))
			if (in_package(folder, name, path))
				return true;
		return in_named_package(spec, beside, name, path);
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
	const int above = strncmp(name, package, strlen(package)) == 0 || strncmp(name, model_scheme, strlen(model_scheme)) == 0 ? ABOVE : 1;
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

bool vehicle_spec_find(struct spec *spec, const char *name, char path[])
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

static bool ends_in(const char *path, const char *const endings[])
{
	const char *dot = strrchr(path, '.');
	for (size_t i = 0; endings[i] != NULL && dot != NULL; i++)
		if (strcasecmp(dot, endings[i]) == 0)
			return true;
	return false;
}

/* Reads what MuJoCo does not read, and gives it the triangles. *read: false: it cannot be read. */
static enum status convert(mjsMesh *mesh, const char *path, const char *name, bool *read)
{
	double scale = 0;
	for (int i = 0; i < 3; i++)
		scale = fmax(scale, fabs(mesh->scale[i]));
	struct soil_mesh *from = NULL;
	const enum status status = scale > 0 ? scene_mesh_read(path, name, scale, &from) : STATUS_INPUT;
	*read = status == STATUS_OK;
	if (!*read)
		return status == STATUS_INPUT ? STATUS_OK : status;
	mjs_setFloat(mesh->uservert, from->vertices[0], 3 * (int)from->vertex_count);
	mjs_setInt(mesh->userface, (const int *)from->triangles[0], 3 * (int)from->triangle_count);
	mjs_setString(mesh->file, "");
	for (int i = 0; i < 3; i++)
		mesh->scale[i] /= scale;
	scene_mesh_destroy(from);
	return STATUS_OK;
}

/* Finds the file of one mesh of a URDF, or takes the mesh out. */
static enum status place(struct spec *spec, mjsMesh *mesh, struct files *files)
{
	static const char *const known[] = {".stl", ".obj", ".msh", NULL}, *const converted[] = {".dae", ".gltf", ".glb", NULL};
	char path[PATH_MAX];
	const char *name = mjs_getString(mesh->file);
	bool read = false;
	if (name == NULL || name[0] == '\0')
		return STATUS_OK;
	name = vehicle_spec_file(spec, name);
	if (!find(spec, name, path)) {
		vehicle_spec_name(&files->missing, vehicle_spec_base(name));
		leave_out(spec, mesh);
		return STATUS_OK;
	}
	if (!may_read(spec, name, path))
		return fail_with(STATUS_INPUT, "%s: %s: it names the file \"%.100s\": it lies neither in the model's folder nor in the one above; name its folder in model_path", spec->where,
				 spec->path, name);
	if (ends_in(path, known)) {
		TRY(vehicle_check_mesh_file(spec->where, spec->path, path, name));
		mjs_setString(mesh->file, path);
		return STATUS_OK;
	}
	if (ends_in(path, converted))
		TRY(convert(mesh, path, name, &read));
	if (!read) {
		vehicle_spec_name(&files->strange, vehicle_spec_base(name));
		leave_out(spec, mesh);
	}
	return STATUS_OK;
}

/* --- files of an MJCF: MuJoCo finds them itself, in the model's folder and in those of its compiler --- */

static bool mujoco_finds(const struct spec *spec, const mjsElement *element, const char *folder, const char *name)
{
	const mjSpec *origin = mjs_getOriginSpec(element);
	const char *above = mjs_getString(origin->modelfiledir);
	char joined[2 * PATH_MAX], path[PATH_MAX];
	if (spec->spec->strippath)
		name = vehicle_spec_base(name);
	snprintf(joined, sizeof joined, "%.4000s%s%.2000s", above != NULL ? above : "", above != NULL && above[0] != '\0' && above[strlen(above) - 1] != '/' ? "/" : "",
		 folder != NULL ? folder : "");
	while (strlen(joined) > 1 && joined[strlen(joined) - 1] == '/')
		joined[strlen(joined) - 1] = '\0';
	return is_file(joined, name, path) || is_file("", name, path);
}

/* Looks for it in model_path. */
static bool finds_else(struct spec *spec, const char *name, char path[PATH_MAX])
{
	return (find(spec, name, path) || find(spec, vehicle_spec_base(name), path)) && may_read(spec, name, path);
}

static void note_massless(const struct spec *spec, const mjsMesh *mesh, struct files *files)
{
	const char *name = mjs_getString(mjs_getName(mesh->element));
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (vehicle_spec_weighs(each, name))
			vehicle_spec_name(&files->massless, mjs_getString(mjs_getName(mjs_getParent(each)->element)));
}

static void place_own(struct spec *spec, mjsMesh *mesh, struct files *files)
{
	char path[PATH_MAX];
	const char *name = mjs_getString(mesh->file);
	const mjSpec *origin = mjs_getOriginSpec(mesh->element);
	if (name == NULL || name[0] == '\0' || mujoco_finds(spec, mesh->element, mjs_getString(origin->compiler.meshdir), name))
		return;
	if (finds_else(spec, name, path)) {
		mjs_setString(mesh->file, path);
		return;
	}
	vehicle_spec_name(&files->missing, vehicle_spec_base(name));
	note_massless(spec, mesh, files);
	leave_out(spec, mesh);
}

/* An image that is not there becomes a plain one. */
static void place_image(struct spec *spec, mjsTexture *texture, struct files *files)
{
	const char *name = mjs_getString(texture->file);
	const mjSpec *origin = mjs_getOriginSpec(texture->element);
	if (name == NULL || name[0] == '\0' || mujoco_finds(spec, texture->element, mjs_getString(origin->compiler.texturedir), name))
		return;
	vehicle_spec_name(&files->images, vehicle_spec_base(name));
	mjs_setString(texture->file, "");
	texture->builtin = mjBUILTIN_FLAT;
	texture->width = texture->height = 1;
	for (int i = 0; i < 3; i++)
		texture->rgb1[i] = texture->rgb2[i] = 0.5;
}

static void tell_files(struct spec *spec, const struct files *files)
{
	const struct spec_names *missing = &files->missing, *strange = &files->strange, *images = &files->images;
	const bool loses = files->massless.count > 0;
	spec->lost = missing->count > 0 ? *missing : *strange;
	if (missing->count > 0)
		vehicle_spec_tell(spec, "%zu mesh%s not found (%s): without %s its shape is left out%s%s%s; name the folder of its packages in model_path", missing->count,
				  missing->count > 1 ? "es are" : " is", missing->text, missing->count > 1 ? "them" : "it", loses ? ", and the mass that it gives " : ", its mass stays",
				  loses ? files->massless.text : "", "");
	if (strange->count > 0)
		vehicle_spec_tell(spec, "%zu mesh%s not read (%s): the shape is left out, its mass stays; export it as STL", strange->count, strange->count > 1 ? "es are" : " is",
				  strange->text);
	if (images->count > 0)
		vehicle_spec_tell(spec, "%zu image%s not found (%s): plain grey is taken", images->count, images->count > 1 ? "s are" : " is", images->text);
}

enum status vehicle_spec_meshes(struct spec *spec)
{
	struct files files = {.missing = {.count = 0}};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_MESH), *next; each != NULL; each = next) {
		next = mjs_nextElement(spec->spec, each);
		if (spec->urdf)
			TRY(place(spec, mjs_asMesh(each), &files));
		else
			place_own(spec, mjs_asMesh(each), &files);
	}
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_TEXTURE); each != NULL && !spec->urdf; each = mjs_nextElement(spec->spec, each))
		place_image(spec, mjs_asTexture(each), &files);
	if (spec->urdf)
		mjs_setString(spec->spec->compiler.meshdir, "");
	tell_files(spec, &files);
	return STATUS_OK;
}
