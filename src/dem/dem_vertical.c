/* Finds out what heights of a source are above: an ellipsoid, a geoid, or another vertical reference of PROJ. */
#include "dem_vertical.h"

#include <stdio.h>
#include <strings.h>

#define P dem_proj_calls

PJ_CONTEXT *dem_vertical_context(void)
{
	PJ_CONTEXT *context = P.proj_context_create != NULL ? P.proj_context_create() : NULL;
	if (P.proj_context_create == NULL)
		(void)fail_with(STATUS_FAILED, "vertical reference: this GDAL hides its PROJ, which converts heights; leave --t-vertical and "
				"--s-vertical out, or convert with gdalwarp first");
	else if (context == NULL)
		(void)fail_memory("a vertical reference");
	else
		P.proj_log_level(context, PJ_LOG_NONE);
	if (context != NULL)
		(void)P.proj_context_set_enable_network(context, dem_network_is_open());
	return context;
}

static const char *text_of(const char *text)
{
	static const char *const names[][2] = {{"egm96", "EPSG:5773"}, {"egm2008", "EPSG:3855"}};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		if (strcasecmp(text, names[i][0]) == 0)
			return names[i][1];
	return text;
}

static enum status refuse(const char *text, const char *why)
{
	return fail_with(STATUS_INPUT, "vertical reference \"%.80s\": %s; give ellipsoid, egm96, egm2008, or a vertical SRS as EPSG:5703", text, why);
}

/* Reads the unit and the direction of a vertical SRS. */
static bool read_axis(PJ_CONTEXT *context, struct dem_vertical *vertical)
{
	PJ *system = P.proj_crs_get_coordinate_system(context, vertical->crs);
	const char *direction = NULL;
	bool up = system != NULL && P.proj_cs_get_axis_info(context, system, 0, NULL, NULL, &direction, &vertical->metres, NULL, NULL, NULL) &&
		  direction != NULL && strcmp(direction, "up") == 0 && vertical->metres > 0;
	P.proj_destroy(system);
	return up;
}

enum status dem_vertical_init(PJ_CONTEXT *context, const char *text, struct dem_vertical *vertical)
{
	*vertical = (struct dem_vertical){NULL, 1};
	if (strcmp(text, DEM_ELLIPSOID) == 0)
		return STATUS_OK;
	const char *problem = dem_srs_text_problem(text);
	if (problem != NULL)
		return refuse(text, problem);
	PJ *crs = P.proj_create(context, text_of(text));
	if (crs != NULL && P.proj_get_type(crs) == PJ_TYPE_COMPOUND_CRS) {
		vertical->crs = P.proj_crs_get_sub_crs(context, crs, 1);
		P.proj_destroy(crs);
	} else {
		vertical->crs = crs;
	}
	if (vertical->crs != NULL && P.proj_get_type(vertical->crs) == PJ_TYPE_VERTICAL_CRS && read_axis(context, vertical))
		return STATUS_OK;
	enum status status = refuse(text, vertical->crs == NULL ? "PROJ does not know it" : "is not one of heights");
	dem_vertical_finish(vertical);
	return status;
}

void dem_vertical_finish(struct dem_vertical *vertical)
{
	P.proj_destroy(vertical->crs);
	vertical->crs = NULL;
}

enum status dem_vertical_unit(const char *text, double *metres)
{
	struct dem_vertical vertical;
	PJ_CONTEXT *context = dem_vertical_context();
	if (context == NULL)
		return STATUS_FAILED;
	enum status status;
	TRY_OR(done, dem_vertical_init(context, text, &vertical));
	*metres = vertical.metres;
	dem_vertical_finish(&vertical);
done:
	P.proj_context_destroy(context);
	return status;
}

enum status dem_vertical_part(struct gdal_source *source)
{
	OGRSpatialReferenceH srs = source->srs;
	if (srs == NULL || OSRGetAxesCount(srs) < 3)
		return STATUS_OK;
	if (OSRIsCompound(srs)) {
		const char *name = OSRGetAttrValue(srs, "COMPD_CS|VERT_CS", 0);
		snprintf(source->vertical, sizeof source->vertical, "%s", name != NULL ? name : "");
		source->own = dem_srs_wkt(srs);
		OSRStripVertical(srs);
	} else {
		const char *name = OSRGetAttrValue(srs, "SPHEROID", 0);
		snprintf(source->vertical, sizeof source->vertical, "ellipsoid %s", name != NULL ? name : "of the SRS");
		source->own = mem_strdup(DEM_ELLIPSOID);
		if (OSRDemoteTo2D(srs, NULL) != OGRERR_NONE)
			return fail_with(STATUS_INPUT, "%s: its SRS has three axes and cannot do with two%s; name another with --s-srs", source->path,
					 dem_gdal_because());
	}
	return source->own != NULL ? STATUS_OK : fail_memory(source->path);
}

enum status dem_vertical_metadata(struct gdal_source *source, const char *text)
{
	struct dem_vertical vertical;
	const bool round = strncmp(text, "ellipsoid ", 10) == 0 || strncmp(text, "sphere of ", 10) == 0;
	snprintf(source->vertical, sizeof source->vertical, "%.*s", (int)dem_vertical_length(text), text);
	PJ_CONTEXT *context = round ? NULL : dem_vertical_context();
	const bool known = context != NULL && dem_vertical_init(context, source->vertical, &vertical) == STATUS_OK;
	if (known)
		dem_vertical_finish(&vertical);
	if (context != NULL)
		P.proj_context_destroy(context);
	if (!round && !known)
		return STATUS_OK;
	return mem_text(&source->own, round ? DEM_ELLIPSOID : source->vertical, source->path);
}

/* Describes a reference in source->vertical. */
static void describe(struct gdal_source *source, const struct dem_vertical *vertical)
{
	const char *name = vertical->crs != NULL ? P.proj_get_name(vertical->crs) : OSRGetAttrValue(source->srs, "SPHEROID", 0);
	snprintf(source->vertical, sizeof source->vertical, "%s%.140s", vertical->crs != NULL ? "" : "ellipsoid ", name != NULL ? name : "of the SRS");
}

static bool same(PJ_CONTEXT *context, const struct dem_vertical *a, const struct dem_vertical *b)
{
	(void)context;
	if (a->crs == NULL || b->crs == NULL)
		return a->crs == b->crs;
	return P.proj_is_equivalent_to(a->crs, b->crs, PJ_COMP_EQUIVALENT) != 0;
}

static enum status plan(struct gdal_source *source, const struct dem_params *params, PJ_CONTEXT *context, const char *said)
{
	struct dem_vertical from, to, own;
	TRY(dem_vertical_init(context, said, &from));
	if (said != source->own && source->own != NULL && dem_vertical_init(context, source->own, &own) == STATUS_OK) {
		if (!same(context, &from, &own))
			dem_source_remark(source, SOURCE_VERTICAL, "the file says heights above %s; --s-vertical %.80s is used", source->vertical, said);
		dem_vertical_finish(&own);
	}
	if (params->t_vertical == NULL) {
		describe(source, &from);
		dem_vertical_finish(&from);
		return STATUS_OK;
	}
	enum status status;
	TRY_OR(done, dem_vertical_init(context, params->t_vertical, &to));
	if (!same(context, &from, &to)) {
		source->from = mem_strdup(said);
		source->to = mem_strdup(params->t_vertical);
		source->whole = false;
		TRY_OR(done, source->from != NULL && source->to != NULL ? STATUS_OK : fail_memory(source->path));
	}
	describe(source, &to);
done:
	dem_vertical_finish(&from);
	dem_vertical_finish(&to);
	return status;
}

enum status dem_vertical_plan(struct gdal_source *source, const struct dem_params *params)
{
	const char *said = params->s_vertical != NULL ? params->s_vertical : source->own;
	if (params->t_vertical == NULL && params->s_vertical == NULL)
		return STATUS_OK;
	if (source->srs == NULL)
		return fail_with(STATUS_INPUT, "%s: says no SRS, so its heights lie above no ellipsoid or geoid; name it with --s-srs", source->path);
	if (said == NULL)
		return fail_with(STATUS_INPUT, "%s: does not say above what its heights are; name it with --s-vertical, as egm96 for SRTM", source->path);
	PJ_CONTEXT *context = dem_vertical_context();
	if (context == NULL)
		return STATUS_FAILED;
	enum status status = plan(source, params, context, said);
	P.proj_context_destroy(context);
	return status;
}
