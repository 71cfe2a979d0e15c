/* Checks of a source before and after it is opened. See dem_outside.h. */
#include "dem_outside.h"

#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <strings.h>
#include <sys/stat.h>

#define FOLDERS_MOST 16 /* folders in folders of a raster that is a folder */

static enum status refuse_network(const char *name)
{
	return fail_with(STATUS_INPUT, "%s: that is on a network, which is not used; give --allow-network, or fetch it first", name);
}

/* A folder in which all are files and folders; looked at again when it was changed. */
static _Thread_local struct stat plain_folder;

static bool is_known(const struct stat *folder)
{
	return plain_folder.st_ino == folder->st_ino && plain_folder.st_dev == folder->st_dev && folder->st_ino != 0 &&
	       plain_folder.st_mtim.tv_sec == folder->st_mtim.tv_sec && plain_folder.st_mtim.tv_nsec == folder->st_mtim.tv_nsec;
}

/* Files beside a raster that GDAL opens by themselves: they have its name, and another ending. */
static enum status check_beside(const char *path)
{
	const char *slash = strrchr(path, '/'), *last = slash != NULL ? slash + 1 : path, *dot = strrchr(last, '.');
	const size_t stem = dot != NULL ? (size_t)(dot - last) : strlen(last);
	char folder[PATH_MAX], full[2 * PATH_MAX];
	struct stat found;
	snprintf(folder, sizeof folder, "%.*s", slash != NULL ? (int)(slash - path) + 1 : 2, slash != NULL ? path : "./");
	DIR *directory = opendir(folder);
	const bool there = directory != NULL && stat(folder, &found) == 0, known = there && is_known(&found);
	bool plain = there;
	enum status status = STATUS_OK;
	for (struct dirent *entry; there && !known && (entry = readdir(directory)) != NULL;) {
		if (entry->d_type == DT_REG || entry->d_type == DT_DIR)
			continue;
		plain = false;
		snprintf(full, sizeof full, "%s%s", folder, entry->d_name);
		if (strncasecmp(entry->d_name, last, stem) == 0 && dem_outside_is_special(full))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s: %s lies beside it and is not a file; remove that", path, full));
	}
done:
	if (plain)
		plain_folder = found;
	if (directory != NULL)
		closedir(directory);
	return status;
}

/* Refuses a driver that would use a network, by what the file has. */
static enum status check_driver(const char *name)
{
	GDALDriverH driver = dem_network_is_open() ? NULL : GDALIdentifyDriverEx(name, GDAL_OF_RASTER, NULL, NULL);
	if (driver == NULL || !dem_gdal_is_networked(driver))
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "%s: GDAL reads it with %s, which uses a network or names other files; give --allow-network, or make one raster of "
				       "it with gdal_translate", name, GDALGetDriverShortName(driver));
}

enum status dem_outside_packed(const char *name)
{
	GDALDriverH driver = GDALIdentifyDriverEx(name, GDAL_OF_RASTER, NULL, NULL);
	const char *called = driver != NULL ? GDALGetDriverShortName(driver) : "";
	if (strcmp(called, "VRT") == 0 || strcmp(called, "MRF") == 0)
		return fail_with(STATUS_INPUT, "%s: is a packed %s, and what it names is not followed; unpack it first", name, called);
	return check_driver(name);
}

/* Returns true if a file may be text: what uses a network is XML or JSON. */
static bool may_be_text(const char *path)
{
	char head[1024];
	FILE *file = input_open(path);
	const size_t got = file != NULL ? fread(head, 1, sizeof head, file) : 0;
	if (file != NULL)
		fclose(file);
	return memchr(head, '<', got) != NULL || memchr(head, '{', got) != NULL;
}

enum status dem_outside_file(const char *path, const char *vrt_folder, int depth)
{
	char aux[PATH_MAX + 16];
	if (may_be_text(path))
		TRY(check_driver(path));
	TRY(check_beside(path));
	snprintf(aux, sizeof aux, "%s.aux.xml", path); /* it may name another raster as the overview of this one */
	TRY(dem_outside_xml(aux, vrt_folder, depth));
	return dem_outside_xml(path, vrt_folder, depth);
}

/* Checks all that a folder has that is a raster itself, as a Zarr: regular files, and none outside of it. */
static enum status check_folder(const char *path, const char *whole, const char *vrt_folder, int depth)
{
	char full[PATH_MAX];
	struct stat found;
	DIR *directory = depth < FOLDERS_MOST ? opendir(path) : NULL;
	if (directory == NULL)
		return fail_with(STATUS_INPUT, "%s: cannot be read, or lies too deep in a raster that is a folder; copy it with gdal_translate", path);
	enum status status = STATUS_OK;
	for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
		if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
			continue;
		const bool whole_name = snprintf(full, sizeof full, "%s/%s", path, entry->d_name) < (int)sizeof full;
		const bool there = whole_name && lstat(full, &found) == 0;
		if (there && S_ISDIR(found.st_mode))
			TRY_OR(done, check_folder(full, whole, vrt_folder, depth + 1));
		else if (!there || dem_outside_is_special(full) || (S_ISLNK(found.st_mode) && !dem_outside_is_within(full, whole, vrt_folder)))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s: its %s is no regular file of it; remove that", whole, entry->d_name));
	}
done:
	closedir(directory);
	return status;
}

enum status dem_outside_check(const char *name, const char *vrt_folder)
{
	char file[PATH_MAX];
	struct stat found;
	if (name[0] == '<' || strncasecmp(name, "vrt://", 6) == 0)
		return fail_with(STATUS_INPUT, "%.80s: is no name of a file; name the raster itself, or write the VRT to a file", name);
	if (dem_network_is_open() && dem_outside_is_address(name))
		return STATUS_OK;
	if (dem_outside_is_address(name))
		return refuse_network(name);
	if (strncmp(name, "/vsisparse//vsimem/furrow/", 26) == 0) /* made by dem_unpack */
		return dem_outside_packed(name);
	if (!dem_outside_file_of(name, file, sizeof file))
		snprintf(file, sizeof file, "%s", name);
	if (dem_outside_is_special(file))
		return fail_with(STATUS_INPUT, "%s: not a file; give a raster", name);
	if (strncmp(name, "/vsi", 4) == 0)
		TRY(dem_outside_packed(name));
	if (input_is_file(file))
		return dem_outside_file(file, vrt_folder, 1);
	if (stat(file, &found) == 0 && S_ISDIR(found.st_mode))
		TRY(check_folder(file, file, vrt_folder, 0));
	return check_driver(name); /* a folder, or nothing: GDAL tells */
}

enum status dem_outside_opened(const char *name, const char *vrt_folder, GDALDatasetH dataset)
{
	static const char base[] = ":::BASE:::";
	char file[PATH_MAX], part[PATH_MAX];
	if (dem_network_is_open() || strncmp(name, "/vsisparse//vsimem/furrow/", 26) == 0 || !dem_outside_file_of(name, file, sizeof file))
		return STATUS_OK;
	const char *overview = GDALGetMetadataItem(dataset, "OVERVIEW_FILE", "OVERVIEWS");
	if (overview != NULL && strncmp(overview, base, strlen(base)) == 0)
		overview += strlen(base);
	if (overview != NULL && (strchr(overview, '/') != NULL || strchr(overview, ':') != NULL))
		return fail_with(STATUS_INPUT, "%s: it names \"%.120s\" as its overview: that is not in its own folder; make one raster of it with gdal_translate",
				 name, overview);
	char **names = GDALGetFileList(dataset);
	enum status status = STATUS_OK;
	for (char **other = names; other != NULL && *other != NULL; other++)
		if (!dem_outside_file_of(*other, part, sizeof part) || !dem_outside_is_within(part, file, vrt_folder))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s: it names \"%.120s\": that is not in its own folder; name the folder with --vrt-folder, "
					       "or make one raster of it with gdal_translate", name, *other));
done:
	CSLDestroy(names);
	return status;
}
