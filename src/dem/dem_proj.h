/*
 * Used inside dem only, in a build with GDAL. The functions of PROJ that are called. GDAL loads PROJ; dem_gdal_init finds these
 * functions in it. A GDAL that hides its PROJ has none of them: then dem_proj_calls is all NULL.
 */
#ifndef FURROW_DEM_PROJ_H
#define FURROW_DEM_PROJ_H

#include <proj.h>

#define DEM_PROJ_EACH(CALL) \
	CALL(proj_context_create) CALL(proj_context_destroy) CALL(proj_context_set_enable_network) CALL(proj_context_get_user_writable_directory) CALL(proj_log_level) \
	CALL(proj_create) CALL(proj_destroy) CALL(proj_get_type) CALL(proj_get_name) CALL(proj_crs_get_sub_crs) \
	CALL(proj_crs_get_coordinate_system) CALL(proj_cs_get_axis_info) CALL(proj_as_wkt) CALL(proj_is_equivalent_to) \
	CALL(proj_create_operation_factory_context) CALL(proj_operation_factory_context_destroy) \
	CALL(proj_operation_factory_context_set_allow_ballpark_transformations) \
	CALL(proj_operation_factory_context_set_area_of_interest) CALL(proj_operation_factory_context_set_spatial_criterion) \
	CALL(proj_operation_factory_context_set_grid_availability_use) CALL(proj_create_operations) CALL(proj_list_get_count) \
	CALL(proj_list_get) CALL(proj_list_destroy) CALL(proj_coordoperation_get_grid_used_count) \
	CALL(proj_coordoperation_get_grid_used) CALL(proj_normalize_for_visualization) CALL(proj_trans)

struct dem_proj_calls {
#define DEM_PROJ_MEMBER(name) __typeof__(&name) name;
	DEM_PROJ_EACH(DEM_PROJ_MEMBER)
#undef DEM_PROJ_MEMBER
};
extern struct dem_proj_calls dem_proj_calls; /* constant after dem_gdal_init */

#endif
