/* Finds the rasters in a zip. GDAL reads them from there, by names as /vsizip/a.zip/b.tif. */
#include "dem_gdal.h"

#include <stdio.h>

#define FILES_MOST 100000 /* in an archive */

static enum status add_named(struct dem_list *list, const char *archive, const char *name)
{
	const size_t length = strlen(name), room = strlen(archive) + length + 2;
	const char *slash = strrchr(name, '/'), *last = slash != NULL ? slash + 1 : name;
	if (length == 0 || last[0] == '\0' || dem_list_is_sidecar(last)) /* a folder ends in a slash */
		return STATUS_OK;
	char *full = mem_alloc(room, 1);
	TRY_MEM(full, "the list of sources");
	snprintf(full, room, "%s/%s", archive, name);
	const enum status status = dem_list_has_raster_name(name) || dem_gdal_knows(full) ? dem_list_add(list, full) : STATUS_OK;
	mem_free(full);
	return status;
}

enum status dem_zip_add(struct dem_list *list, const char *path)
{
	const size_t room = strlen(path) + sizeof "/vsizip/";
	TRY(dem_gdal_init(path));
	char *archive = mem_alloc(room, 1);
	TRY_MEM(archive, "the list of sources");
	snprintf(archive, room, "/vsizip/%s", path);
	char **names = VSIReadDirRecursive(archive);
	enum status status = STATUS_OK;
	if (names == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: cannot be read as an archive%s; fetch it again", path, dem_gdal_because()));
	for (size_t i = 0; names[i] != NULL; i++)
		TRY_OR(done, i < FILES_MOST ? add_named(list, archive, names[i])
					    : fail_with(STATUS_INPUT, "%s: has more than %d files; unpack it", path, FILES_MOST));
done:
	CSLDestroy(names);
	mem_free(archive);
	return status;
}
