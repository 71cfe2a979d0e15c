/* Names of GDAL: which of them lead to a network, and to which file the others. See dem_outside.h. */
#include "dem_outside.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <strings.h>
#include <sys/stat.h>

bool dem_outside_is_address(const char *name)
{
	static const char *const ways[] = {"/vsicurl", "/vsis3", "/vsigs", "/vsiaz", "/vsiadls", "/vsioss", "/vsiswift", "/vsihdfs", "/vsiwebhdfs"};
	for (const char *at = name; (at = strstr(at, "://")) != NULL; at += 3)
		if (at == name || at[-1] != '"') /* HDF5:"file"://group is a part of a file */
			return true;
	for (const char *at = name; *at != '\0'; at++)
		for (size_t i = 0; *at == '/' && i < sizeof ways / sizeof ways[0]; i++)
			if (strncasecmp(at, ways[i], strlen(ways[i])) == 0)
				return true;
	return false;
}

/* PREFIX:"file":rest, and PREFIX:file: a part of a file. */
static bool part_of_file(const char *name, char *file, size_t room)
{
	static const char *const prefixes[] = {"NETCDF:", "HDF5:", "HDF4_SDS:", "GTIFF_DIR:", "GTIFF_RAW:", "GPKG:", "NITF_IM:", "ZARR:"};
	for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++) {
		const size_t length = strlen(prefixes[i]);
		if (strncasecmp(name, prefixes[i], length) != 0)
			continue;
		const char *at = name + length, *quote = strchr(at, '"');
		if (quote != NULL && quote - at < 16) {
			snprintf(file, room, "%.*s", (int)strcspn(quote + 1, "\""), quote + 1);
			return true;
		}
		at += strspn(at, "0123456789off:"); /* the number of a directory */
		snprintf(file, room, "%.*s", (int)strcspn(at, ":"), at);
		return true;
	}
	return false;
}

bool dem_outside_file_of(const char *name, char *file, size_t room)
{
	static const char *const archives[] = {"/vsizip/", "/vsigzip/", "/vsitar/", "/vsi7z/", "/vsirar/"};
	for (bool again = true; again;) {
		again = false;
		for (size_t i = 0; i < sizeof archives / sizeof archives[0]; i++)
			if (strncmp(name, archives[i], strlen(archives[i])) == 0) {
				name += strlen(archives[i]);
				again = true;
			}
	}
	name += strspn(name, "{");
	if (part_of_file(name, file, room))
		return strncmp(file, "/vsi", 4) != 0;
	const size_t length = strcspn(name, "}");
	if (strncmp(name, "/vsi", 4) == 0 || name[0] == '<' || name[0] == '{' || length >= room || strchr(name, ':') != NULL)
		return false;
	snprintf(file, room, "%.*s", (int)length, name);
	return true;
}

/* Finds the whole path of the part of a path that is there. */
static bool real_of(const char *path, char real[PATH_MAX])
{
	char part[PATH_MAX];
	if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part)
		return false;
	while (realpath(part, real) == NULL) {
		char *slash = strrchr(part, '/');
		if (slash == NULL)
			return realpath(".", real) != NULL;
		slash[slash == part] = '\0';
	}
	return true;
}

static bool is_in(const char *real, const char *folder)
{
	char whole[PATH_MAX];
	if (folder == NULL || realpath(folder, whole) == NULL)
		return false;
	const size_t length = strlen(whole);
	return strncmp(real, whole, length) == 0 && (real[length] == '/' || real[length] == '\0' || (length > 0 && whole[length - 1] == '/'));
}

bool dem_outside_is_within(const char *path, const char *of, const char *vrt_folder)
{
	char real[PATH_MAX], folder[PATH_MAX], there[PATH_MAX];
	const char *slash = strrchr(of, '/');
	if (slash == NULL)
		snprintf(folder, sizeof folder, ".");
	else
		snprintf(folder, sizeof folder, "%.*s", slash == of ? 1 : (int)(slash - of), of);
	if (!real_of(folder, there)) /* a folder in an archive: the archive */
		return false;
	return real_of(path, real) && (is_in(real, there) || is_in(real, vrt_folder));
}

bool dem_outside_is_special(const char *path)
{
	char real[PATH_MAX];
	struct stat found;
	return real_of(path, real) && stat(real, &found) == 0 && !S_ISREG(found.st_mode) && !S_ISDIR(found.st_mode);
}
