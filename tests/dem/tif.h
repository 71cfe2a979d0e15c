/* An empty GeoTIFF in the folder of a test. */
#ifndef FURROW_TESTS_DEM_TIF_H
#define FURROW_TESTS_DEM_TIF_H

#include <gdal.h>
#include <ogr_srs_api.h>

#include "files.h"

/* place: geotransform; NULL: none. srs: anything that GDAL takes; NULL: none. The caller closes the dataset. */
static inline GDALDatasetH tif_create(const char *name, int width, int height, int bands, GDALDataType type, const double *place,
				      const char *srs)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(name), width, height, bands, type, NULL);
	assert_non_null(dataset);
	if (place != NULL)
		assert_int_equal(GDALSetGeoTransform(dataset, (double *)place), CE_None);
	if (srs != NULL) {
		OGRSpatialReferenceH reference = OSRNewSpatialReference(NULL);
		assert_int_equal(OSRSetFromUserInput(reference, srs), OGRERR_NONE);
		OSRSetAxisMappingStrategy(reference, OAMS_TRADITIONAL_GIS_ORDER);
		assert_int_equal(GDALSetSpatialRef(dataset, reference), CE_None);
		OSRDestroySpatialReference(reference);
	}
	return dataset;
}

#endif
