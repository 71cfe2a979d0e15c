/*
 * Used inside dem only, in a build with GDAL. What a raster may lead to.
 *
 * 1. Nothing is fetched from a network, unless dem_network_begin was called (--allow-network).
 * 2. A raster leads to no file outside of its own folder and those below it, and params->vrt_folder.
 * 3. What it leads to is a regular file.
 */
#ifndef FURROW_DEM_OUTSIDE_H
#define FURROW_DEM_OUTSIDE_H

#include "dem_gdal.h"

/* Checks a source before it is opened. `name`: under which GDAL opens it. `vrt_folder` may be NULL. STATUS_INPUT: it breaks a rule. */
enum status dem_outside_check(const char *name, const char *vrt_folder) FURROW_CHECKED;
/* Checks the files that an open raster has. */
enum status dem_outside_opened(const char *name, const char *vrt_folder, GDALDatasetH dataset) FURROW_CHECKED;

/* --- dem_outside_names.c --- */
/* Returns true if GDAL would use a network for this name. */
bool dem_outside_is_address(const char *name);
/* Finds the file in a name of GDAL, as /vsizip/a.zip/b.tif or NETCDF:"a.nc":z. Returns false for a name that has none. */
bool dem_outside_file_of(const char *name, char *file, size_t room);
/* Returns true if `path`, or the part of it that is there, lies in the folder of the file `of`, or in `vrt_folder`. */
bool dem_outside_is_within(const char *path, const char *of, const char *vrt_folder);
/* Returns true if there is a file at `path`, or at a part of it, and it is no regular file and no folder. */
bool dem_outside_is_special(const char *path);
/* Checks a regular file, what lies beside it, and what both name. `depth`: of VRTs that named it. */
enum status dem_outside_file(const char *path, const char *vrt_folder, int depth) FURROW_CHECKED;
/* Checks a file within an archive, or one that dem_unpack made. */
enum status dem_outside_packed(const char *name) FURROW_CHECKED;
/* --- dem_outside_xml.c --- */
/* Checks the files that an XML file names: a VRT, or what GDAL keeps beside a raster. Looks into VRTs that it names. */
enum status dem_outside_xml(const char *path, const char *vrt_folder, int depth) FURROW_CHECKED;

#endif
