/*
 * The files that a VRT names, or a .aux.xml beside a raster. GDAL opens some of them when it reads the XML, so they are looked at
 * before. GDAL's own reader makes the tree, so that both see the same.
 *
 * Any text is taken for a name that has a slash or a colon, unless its element is known to hold other text.
 */
#include "dem_outside.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <strings.h>
#include <sys/stat.h>

#define DEPTH_MOST 64 /* of elements */
#define VRTS_MOST 8   /* VRTs in each other */
#define XML_MOST ((int64_t)64 << 20)

struct reading {
	const char *path, *vrt_folder;
	int depth; /* of VRTs */
};

static enum status refuse(const struct reading *reading, const char *name, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: it names \"%.120s\": %s", reading->path, name, why);
}

/* Returns true for elements and attributes that hold text about a raster, and no name of a file. */
static bool is_text(const char *name)
{
	static const char *const names[] = {"Description", "UnitType", "Category", "F", "Name", "MDI", "Histograms", "key", "domain", "format", "ColorInterp",
					    "GeoTransform", "SrcRect", "DstRect", "dataAxisToSRSAxisMapping"};
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
		if (strcasecmp(name, names[i]) == 0)
			return true;
	return strncasecmp(name, "xmlns", 5) == 0 || strncasecmp(name, "xsi:", 4) == 0;
}

static bool is_srs(const char *name)
{
	return strcasecmp(name, "SRS") == 0 || strcasecmp(name, "Projection") == 0 || strcasecmp(name, "SourceSRS") == 0 ||
	       strcasecmp(name, "TargetSRS") == 0;
}

/* Metadata of these domains name files, or say where other data are. */
static bool leads_on(const char *domain)
{
	return strcasecmp(domain, "OVERVIEWS") == 0 || strcasecmp(domain, "GEOLOCATION") == 0 || strcasecmp(domain, "RPC") == 0 ||
	       strcasecmp(domain, "vrt_sources") == 0 || strcasecmp(domain, "new_vrt_sources") == 0 || strncasecmp(domain, "xml:", 4) == 0;
}

static enum status check_name(const struct reading *reading, const char *name, bool beside)
{
	static const char base[] = ":::BASE:::";
	char file[PATH_MAX], joined[2 * PATH_MAX];
	if (strncmp(name, base, strlen(base)) == 0) {
		name += strlen(base);
		beside = true;
	}
	if (dem_outside_is_address(name))
		return dem_network_is_open() ? STATUS_OK
					     : refuse(reading, name, "that is on a network, which is not used; give --allow-network, or fetch it first");
	if (!dem_outside_file_of(name, file, sizeof file))
		return refuse(reading, name, "it is no plain name of a file; make one raster of it with gdal_translate");
	const char *slash = strrchr(reading->path, '/');
	snprintf(joined, sizeof joined, "%.*s%s", beside && file[0] != '/' && slash != NULL ? (int)(slash - reading->path) + 1 : 0, reading->path, file);
	if (!dem_outside_is_within(joined, reading->path, reading->vrt_folder))
		return refuse(reading, name, "that is not in its own folder; name the folder with --vrt-folder, or move the VRT there");
	if (dem_outside_is_special(joined))
		return refuse(reading, name, "that is not a file; give one");
	if (strncmp(name, "/vsi", 4) == 0)
		return dem_outside_packed(name);
	struct stat found;
	if (stat(joined, &found) != 0 || !S_ISREG(found.st_mode))
		return STATUS_OK; /* within an archive, or GDAL does not find it */
	return dem_outside_file(joined, reading->vrt_folder, reading->depth + 1);
}

static const char *value_of(const CPLXMLNode *node)
{
	return node->psChild != NULL && node->psChild->eType == CXT_Text ? node->psChild->pszValue : "";
}

static enum status check_text(const struct reading *reading, const CPLXMLNode *parent, const char *text)
{
	const char *name = parent->pszValue;
	const bool source = strcasecmp(name, "SourceFilename") == 0 || strcasecmp(name, "SourceDataset") == 0;
	bool beside = false;
	if (text[0] == '\0')
		return STATUS_OK;
	if (is_srs(name)) {
		const char *problem = dem_srs_text_problem(text);
		return problem == NULL ? STATUS_OK
				       : fail_with(STATUS_INPUT, "%s: its SRS is \"%.120s\": %s; write the SRS itself", reading->path, text, problem);
	}
	for (const CPLXMLNode *at = parent->psChild; at != NULL; at = at->psNext)
		if (at->eType == CXT_Attribute && strcasecmp(at->pszValue, "relativeToVRT") == 0)
			beside = atoi(value_of(at)) != 0;
	if (!source && (is_text(name) || strpbrk(text, "/:\\") == NULL))
		return STATUS_OK;
	TRY(check_name(reading, text, beside));
	return source ? STATUS_OK : check_name(reading, text, !beside);
}

static enum status check_number_or_name(const struct reading *reading, const char *text)
{
	const bool names = strpbrk(text, "/:\\.") != NULL && strspn(text, "0123456789.+-eE ") != strlen(text);
	return names ? check_name(reading, text, true) : STATUS_OK;
}

static enum status check_node(const struct reading *reading, const CPLXMLNode *node, const CPLXMLNode *parent, bool leading, int depth)
{
	if (depth > DEPTH_MOST)
		return refuse(reading, "elements", "they lie more than 64 deep in each other; make one raster of it with gdal_translate");
	for (; node != NULL; node = node->psNext) {
		bool leads = leading;
		if (node->eType == CXT_Text && parent != NULL)
			TRY(leading && strcasecmp(parent->pszValue, "MDI") == 0 ? check_number_or_name(reading, node->pszValue)
									       : check_text(reading, parent, node->pszValue));
		if (node->eType == CXT_Element && strcasecmp(node->pszValue, "Metadata") == 0)
			for (const CPLXMLNode *at = node->psChild; at != NULL; at = at->psNext)
				if (at->eType == CXT_Attribute && strcasecmp(at->pszValue, "domain") == 0)
					leads = leads_on(value_of(at));
		if (node->eType == CXT_Element || node->eType == CXT_Attribute)
			TRY(check_node(reading, node->psChild, node, leads, depth + 1));
	}
	return STATUS_OK;
}

/* Returns true if a file begins as XML that names files. */
static bool is_vrt(const char *path)
{
	char head[1024] = "";
	FILE *file = input_open(path);
	if (file == NULL)
		return false;
	const size_t got = fread(head, 1, sizeof head - 1, file);
	fclose(file);
	for (size_t i = 0; i < got; i++)
		if (head[i] == '<' && (strncasecmp(head + i, "<VRTDataset", 11) == 0 || strncasecmp(head + i, "<MRF_META", 9) == 0 ||
				       strncasecmp(head + i, "<PAMDataset", 11) == 0 || strncasecmp(head + i, "<GDALTileIndexDataset", 21) == 0))
			return true;
	return false;
}

enum status dem_outside_xml(const char *path, const char *vrt_folder, int depth)
{
	const struct reading reading = {path, vrt_folder, depth};
	struct stat found;
	if (!is_vrt(path))
		return STATUS_OK;
	if (depth > VRTS_MOST)
		return refuse(&reading, path, "VRTs lie more than 8 deep in each other; make one raster of it with gdal_translate");
	if (stat(path, &found) != 0 || found.st_size > XML_MOST)
		return refuse(&reading, path, "it has more than 64 MiB of XML; make one raster of it with gdal_translate");
	CPLXMLNode *root = CPLParseXMLFile(path);
	if (root == NULL)
		return STATUS_OK; /* GDAL refuses it */
	enum status status = check_node(&reading, root, NULL, false, 0);
	CPLDestroyXMLNode(root);
	return status;
}
