/*
 * Finds the files of the sources that a user named. A directory means the rasters in it, in the order of their names, without
 * those in its subdirectories, unless it is a raster itself. So does a zip, with its subdirectories. "@list.txt" names one source in each line. A name in the list is looked for in the list's own
 * folder first.
 */
#include "dem_internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

bool dem_path_ends(const char *path, const char *extension)
{
	size_t length = strlen(path), tail = strlen(extension);
	return length > tail && strcasecmp(path + length - tail, extension) == 0;
}

enum status dem_list_add(struct dem_list *list, const char *path)
{
	if (list->count == list->room) {
		const size_t more = mem_room(list->room, list->count + 1);
		TRY(mem_resize(&list->paths, more, sizeof *list->paths, "the list of sources"));
		TRY(mem_resize(&list->found, more, sizeof *list->found, "the list of sources"));
		list->room = more;
	}
	char *copy = mem_strdup(path);
	TRY_MEM(copy, "the list of sources");
	list->found[list->count] = false;
	list->paths[list->count++] = copy;
	return STATUS_OK;
}

void dem_list_drop(struct dem_list *list, size_t number)
{
	mem_free(list->paths[number]);
	list->count--;
	for (size_t i = number; i < list->count; i++) {
		list->paths[i] = list->paths[i + 1];
		list->found[i] = list->found[i + 1];
	}
}

void dem_list_skip(struct dem_list *list, size_t number)
{
	note("%s: skipped, since it has no place among other sources", list->paths[number]);
	dem_list_drop(list, number);
}

static int by_name(const void *a, const void *b)
{
	return strcmp(*(char *const *)a, *(char *const *)b);
}

static bool is_packed_tile(const char *name)
{
	return dem_path_ends(name, ".hgt.gz") || dem_path_ends(name, ".hgt.zip") || dem_path_ends(name, ".hgt.xz");
}

bool dem_list_is_sidecar(const char *name)
{
	static const char *const endings[] = {".hdr", ".prj", ".xml", ".tfw", ".wld", ".pgw", ".txt",
		".md", ".csv", ".json", ".geojson", ".ovr", ".msk", ".html", ".pdf", ".part", ".qgz",
		".zip", ".gz", ".shp", ".shx", ".dbf", ".cpg", ".yaml", ".furrow", ".blw", ".stx"};
	if (name[0] == '.')
		return true;
	if (is_packed_tile(name))
		return false;
	for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++)
		if (dem_path_ends(name, endings[i]))
			return true;
	return false;
}

bool dem_list_is_zip(const char *path)
{
	return dem_path_ends(path, ".zip") && !is_packed_tile(path);
}

/* Returns true for a folder that is one raster: a Zarr, or a grid of Arc/Info. */
static bool is_grid_folder(const char *path)
{
	static const char *const marks[] = {".zarray", ".zgroup", ".zmetadata", "zarr.json", "hdr.adf"};
	char full[4200];
	struct stat file;
	for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++)
		if (snprintf(full, sizeof full, "%s/%s", path, marks[i]) < (int)sizeof full && stat(full, &file) == 0 && S_ISREG(file.st_mode))
			return true;
	return false;
}

bool dem_list_has_raster_name(const char *path)
{
	static const char *const endings[] = {".png", ".raw", ".r16", ".r8", ".tif", ".tiff", ".hgt", ".bil", ".flt",
		".asc", ".dem", ".img", ".vrt", ".dt0", ".dt1", ".dt2"};
	for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++)
		if (dem_path_ends(path, endings[i]))
			return true;
	return false;
}

/* Tells by its name whether a file is a raster. A broken, empty or unreadable file counts too: opening it later fails with its
 * name, so it is not left out without an error. */
static bool is_raster(const char *path)
{
	struct stat file;
	if (stat(path, &file) != 0)
		return true;
	if (S_ISDIR(file.st_mode))
		return is_grid_folder(path);
	if (!S_ISREG(file.st_mode))
		return false;
	return dem_list_has_raster_name(path) || is_packed_tile(path) || dem_gdal_knows(path);
}

/* GDAL reads a file through gzip if its name says so. */
static enum status add_gzip(struct dem_list *list, const char *path)
{
	size_t bytes = strlen(path) + sizeof "/vsigzip/";
	char *through = mem_alloc(bytes, 1);
	TRY_MEM(through, "the list of sources");
	snprintf(through, bytes, "/vsigzip/%s", path);
	enum status status = dem_list_add(list, through);
	mem_free(through);
	return status;
}

/* Finds the label of an image whose label is a file of its own (PDS): it has the same name, and ends in .lbl. Returns NULL if there is
 * none that GDAL can read. */
static char *label_of(const char *path)
{
	static const char *const endings[] = {".lbl", ".LBL", ".Lbl"};
	for (size_t i = 0; dem_path_ends(path, ".img") && i < sizeof endings / sizeof endings[0]; i++) {
		struct stat file;
		char *label = mem_strdup(path);
		if (label != NULL)
			memcpy(label + strlen(label) - 4, endings[i], 4);
		if (label != NULL && stat(label, &file) == 0 && S_ISREG(file.st_mode) && dem_gdal_knows(label))
			return label;
		mem_free(label);
	}
	return NULL;
}

static enum status add_file(struct dem_list *list, const char *path)
{
	char *label = label_of(path);
	if (label != NULL) {
		enum status status = dem_list_add(list, label);
		mem_free(label);
		return status;
	}
	return strncmp(path, "/vsi", 4) != 0 && dem_path_ends(path, ".gz") ? add_gzip(list, path) : dem_list_add(list, path);
}

/* Returns the length of a path without its ending. */
static size_t stem_of(const char *path)
{
	const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
	return dot != NULL && (slash == NULL || dot > slash) ? (size_t)(dot - path) : strlen(path);
}

/* An image and its label are one raster: drops from number `first` on what has the name of a label there, but for its ending. */
static void drop_labelled(struct dem_list *list, size_t first)
{
	for (size_t i = first; i < list->count; i++) {
		const size_t stem = stem_of(list->paths[i]);
		for (size_t j = list->count; dem_path_ends(list->paths[i], ".lbl") && j-- > first;)
			if (j != i && stem_of(list->paths[j]) == stem && strncmp(list->paths[i], list->paths[j], stem) == 0) {
				dem_list_drop(list, j);
				i -= j < i;
			}
	}
}

/* Adds what is in a folder. `zips`: the rasters of its archives, and nothing else. */
static enum status add_entries(struct dem_list *list, const char *path, DIR *directory, bool zips)
{
	for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
		if (zips ? !dem_list_is_zip(entry->d_name) : dem_list_is_sidecar(entry->d_name))
			continue;
		size_t bytes = strlen(path) + strlen(entry->d_name) + 2;
		char *full = mem_alloc(bytes, 1);
		TRY_MEM(full, "the list of sources");
		size_t length = strlen(path);
		snprintf(full, bytes, "%s%s%s", path, length > 0 && path[length - 1] == '/' ? "" : "/",
			 entry->d_name);
		const enum status status = zips ? dem_zip_add(list, full) : is_raster(full) ? add_file(list, full) : STATUS_OK;
		mem_free(full);
		TRY(status);
	}
	return STATUS_OK;
}

/* What was found, from number `first` on, comes in the order of names. */
static void sort_found(struct dem_list *list, size_t first)
{
	for (size_t i = first; i < list->count; i++)
		list->found[i] = true;
	qsort(list->paths + first, list->count - first, sizeof *list->paths, by_name);
	drop_labelled(list, first);
}

static enum status add_directory(struct dem_list *list, const char *path)
{
	DIR *directory = opendir(path);
	if (directory == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot read this directory: %s; check its permissions",
				 path, strerror(errno));
	size_t first = list->count;
	enum status status = add_entries(list, path, directory, false);
	if (status == STATUS_OK && list->count == first) { /* as it was fetched: nothing but archives */
		rewinddir(directory);
		status = add_entries(list, path, directory, true);
	}
	closedir(directory);
	TRY(status);
	if (list->count == first)
		return fail_with(STATUS_INPUT, "%s: no raster in this directory; name the files themselves",
				 path);
	sort_found(list, first);
	return STATUS_OK;
}

/* Adds the rasters of an archive that was named. */
static enum status add_zip(struct dem_list *list, const char *path)
{
	const size_t first = list->count;
	TRY(dem_zip_add(list, path));
	if (list->count == first)
		return fail_with(STATUS_INPUT, "%s: no raster in this archive; unpack it and name the files themselves", path);
	sort_found(list, first);
	return STATUS_OK;
}

static enum status add_one(struct dem_list *list, const char *path)
{
	struct stat file;
	if (stat(path, &file) == 0) {
		if (S_ISDIR(file.st_mode))
			return is_grid_folder(path) ? add_file(list, path) : add_directory(list, path);
		if (file.st_size == 0 && S_ISREG(file.st_mode))
			return fail_with(STATUS_INPUT, "%s: the file is empty; fetch it again", path);
		if (!S_ISREG(file.st_mode))
			return fail_with(STATUS_INPUT, "%s: not a file; give a raster, a directory or @list.txt", path);
		if (dem_list_is_zip(path))
			return add_zip(list, path);
	} else if (errno != ENOENT && errno != ENOTDIR) {
		return fail_with(STATUS_INPUT, "%s: cannot be read: %s; check its permissions", path,
				 strerror(errno));
	} else if (strncmp(path, "/vsi", 4) != 0 && strchr(path, ':') == NULL) {
		return fail_with(STATUS_INPUT, "%s: no such file; check the name", path);
	}
	return add_file(list, path);
}

/* Adds a line of the list at `list_path`: as a path in the list's folder if that exists, otherwise as it is written. */
static enum status add_line(struct dem_list *list, const char *list_path, const char *line)
{
	const char *slash = strrchr(list_path, '/');
	if (line[0] == '/' || slash == NULL)
		return add_one(list, line);
	size_t bytes = (size_t)(slash - list_path) + strlen(line) + 2;
	char *full = mem_alloc(bytes, 1);
	TRY_MEM(full, "the list of sources");
	snprintf(full, bytes, "%.*s/%s", (int)(slash - list_path), list_path, line);
	struct stat file;
	enum status status = add_one(list, stat(full, &file) == 0 ? full : line);
	mem_free(full);
	return status;
}

/* *line: room for a line, which the caller frees. */
static enum status add_lines(struct dem_list *list, const char *path, FILE *lines, char **line)
{
	size_t room = 0;
	while (getline(line, &room, lines) >= 0) {
		char *start = *line;
		if (strncmp(start, "\xef\xbb\xbf", 3) == 0)
			start += 3;
		start += strspn(start, " \t");
		size_t end = strlen(start);
		while (end > 0 && strchr(" \t\r\n", start[end - 1]) != NULL)
			start[--end] = '\0';
		if (end > 0 && start[0] != '#')
			TRY(add_line(list, path, start));
	}
	if (ferror(lines))
		return fail_with(STATUS_INPUT, "@%s: reading this list failed: %s; check the disk", path,
				 strerror(errno));
	return STATUS_OK;
}

static enum status add_list(struct dem_list *list, const char *path)
{
	struct stat file;
	if (stat(path, &file) == 0 && S_ISDIR(file.st_mode))
		return fail_with(STATUS_INPUT, "@%s: a directory, not a list; name it without the @", path);
	FILE *lines = input_open(path);
	if (lines == NULL)
		return fail_with(STATUS_INPUT, "@%s: cannot open this list: %s; check the name", path,
				 input_problem());
	char *line = NULL;
	size_t first = list->count;
	const enum status status = add_lines(list, path, lines, &line);
	free(line);
	fclose(lines);
	TRY(status);
	if (list->count == first)
		return fail_with(STATUS_INPUT, "@%s: this list names no source; put one on each line", path);
	return STATUS_OK;
}

enum status dem_list_init(struct dem_list *list, const char *const *sources, size_t count)
{
	*list = (struct dem_list){0};
	for (size_t i = 0; i < count; i++) {
		enum status status = sources[i][0] == '@' ? add_list(list, sources[i] + 1)
							   : add_one(list, sources[i]);
		if (status != STATUS_OK) {
			dem_list_finish(list);
			return status;
		}
	}
	return STATUS_OK;
}

void dem_list_finish(struct dem_list *list)
{
	mem_free_list(list->paths, list->count);
	mem_free(list->found);
	*list = (struct dem_list){0};
}
