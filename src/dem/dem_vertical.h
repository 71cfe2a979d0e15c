/* Used inside dem only, in a build with GDAL. What heights are above, and how to convert them to another vertical reference. */
#ifndef FURROW_DEM_VERTICAL_H
#define FURROW_DEM_VERTICAL_H

#include "dem_gdal.h"
#include "dem_proj.h"

#define DEM_ELLIPSOID "ellipsoid" /* names the ellipsoid of the SRS itself as vertical reference */

/* --- dem_vertical.c: vertical references --- */

/* A vertical reference. `text`: DEM_ELLIPSOID, egm96, egm2008, or anything of which PROJ makes a vertical SRS, or one with a vertical
 * part. */
struct dem_vertical {
	PJ *crs;       /* NULL: the ellipsoid */
	double metres; /* of its unit */
};
/* Returns a PROJ context; NULL: none, and the failure says why. To be destroyed. */
PJ_CONTEXT *dem_vertical_context(void);
/* STATUS_INPUT: it is no vertical reference of heights. dem_vertical_finish is due only after a success. */
enum status dem_vertical_init(PJ_CONTEXT *context, const char *text, struct dem_vertical *vertical) FURROW_CHECKED;
void dem_vertical_finish(struct dem_vertical *vertical);
/* Gives the metres of its unit. */
enum status dem_vertical_unit(const char *text, double *metres) FURROW_CHECKED;
/* Takes the vertical part off a source's SRS. Keeps it in `own`, and describes it in `vertical`; leaves both if there is none. */
enum status dem_vertical_part(struct gdal_source *source) FURROW_CHECKED;
/* Takes `text`, which furrow export wrote into the metadata, for what heights are above. */
enum status dem_vertical_metadata(struct gdal_source *source, const char *text) FURROW_CHECKED;
/* Decides from what to what the source's heights are converted, and describes the result. Does nothing if `params` ask for nothing.
 * STATUS_INPUT: the source does not say what its heights are above; a name is not known. */
enum status dem_vertical_plan(struct gdal_source *source, const struct dem_params *params) FURROW_CHECKED;

/* --- dem_lift.c: by how much heights change, at the posts of a lattice --- */
struct dem_lift;
struct dem_lift_params {
	const char *from, *to;             /* as in struct gdal_source */
	const struct dem_lattice *lattice; /* with an SRS */
	const char *name;                  /* of the source, for messages */
};
/* STATUS_INPUT: PROJ has no way, or lacks a grid, which the message names. One thread at a time uses a lift. */
enum status dem_lift_create(const struct dem_lift_params *params, struct dem_lift **out) FURROW_CHECKED;
void dem_lift_destroy(struct dem_lift *lift); /* lift may be NULL */
/* Converts heights of the posts of `rect`, row by row from the south; `single`: and rounds them to floats. They are off PROJ's by at most a
 * millimetre. STATUS_INPUT: a height lies where PROJ knows no difference. */
enum status dem_lift_run(struct dem_lift *lift, struct post_rect rect, bool single, double *heights) FURROW_CHECKED;

#endif
