/* furrow import: elevation data to a store. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "command.h"
#include "intake/intake.h"
#include "chart/chart.h"
#include "errors.h"
#include "made.h"

#define SOURCES "tif tiff png asc img lbl hgt gz zip xz jp2 vrt nc txt"

static const struct command_option options[] = {
	{"o", "STORE", .help = "the store to make, usually NAME.furrow", .files = "furrow", .needed = true},
	{"tile", "N", .help = "cells along a tile's side, a power of two from 8 to 1024", .preset = "256"},
	{"max-error", "M", .help = "most that a stored height may be off its source; 0: lossless", .unit = "m",
	 .preset = "half the source's unit"},
	{"s-srs", "SRS", .help = "the sources' reference system, if they do not say or say it wrong; also a file with its WKT"},
	{"t-srs", "SRS", .help = "the store's reference system, in metres, or auto, or source: see below", .preset = "auto"},
	{"s-vertical", "REF", .help = "above what the sources' heights are, if they do not say or say it wrong: see below"},
	{"s-unit", "UNIT", .help = "unit of the sources' heights; otherwise what they say, or the vertical reference, or m",
	 .choices = intake_import_units},
	{"t-vertical", "REF", .help = "convert heights to this vertical reference: ellipsoid, egm96, egm2008 or a vertical SRS"},
	{"spacing", "M", .help = "distance between posts: resamples; for sources without a place, their own", .unit = "m",
	 .preset = "1 without a place"},
	{"window", "W,S,E,N", .help = "import only what lies in this area, in the store's coordinates"},
	{"window-srs", "SRS", .help = "the SRS in which the window is given; degrees: longitude and latitude on the sources' body"},
	{"r", "METHOD", .help = "how to resample", .choices = intake_import_methods, .preset = "bilinear"},
	{"band", "N", .help = "the band of the sources that has the heights", .preset = "1"},
	{"encoding", "KIND", .help = "heights are coded in red, green and blue, as in terrain tiles: terrarium or mapbox",
	 .choices = intake_import_encodings},
	{"nodata", "V", .help = "a value that means nodata though no tag says so", .repeats = true},
	{"radii", "KIND", .help = "values are distances from the body's middle; auto finds that by their size",
	 .choices = intake_import_radii, .preset = "auto"},
	{"fill", .help = "fill holes from their rims"},
	{"inset", "SOURCE", .help = "finer ground in a part of the terrain, stored at its own spacing there alone",
	 .files = SOURCES, .repeats = true},
	{"imagery", "ORTHO", .help = "colours over the terrain: rasters of 8 bits a band; alone, they go into a STORE that exists", .files = SOURCES, .repeats = true},
	{"imagery-quality", "Q", .help = "quality of the imagery's tiles, which are WebP, 1 to 100", .preset = "85"},
	{"lossless", .help = "store the imagery's tiles without loss"},
	{"feather", "M", .help = "width over which an inset's rim blends into what surrounds it", .unit = "m",
	 .preset = "10 posts of what surrounds it, at most a quarter of the inset"},
	{"vrt-folder", "FOLDER", .help = "where else a VRT's rasters may lie; otherwise in its own folder and below it", .files = "/"},
	{"allow-network", .help = "let GDAL read sources from networks, as /vsicurl/URL, and PROJ fetch grids"},
	{"match-heights", .help = "raise or lower each inset by its median difference from what surrounds it"},
	{"height-range", "MIN,MAX", .help = "heights that 0 and full scale of a heightmap mean, which is a PNG, raw, or a raster of 8 or 16 bits", .unit = "m",
	 .preset = "one metre a unit; raw posts of 8 bits need it"},
	{"pack", "KIND", .help = "how tiles are packed: fast to read, or small", .choices = intake_import_packs, .preset = "fast"},
	{"jobs", "N", .help = "threads that pack tiles beside the one that reads; 1: one for everything", .preset = "all cores"},
	{"resume", .help = "go on with an import that was broken off or killed; the same store, whatever --jobs"},
	{"overwrite", .help = "replace STORE"},
	{"force", .help = "with --overwrite: also if its snapshots, or overlays that depend on it, are lost; says which"},
	{"json", .help = "one JSON object: what was made, off_resampled and off_source"},
	{"dry-run", .help = "say what would be made, and make nothing"},
	{.name = NULL},
};

static void print_insets(const struct dem_insets *insets)
{
	for (size_t i = 0; insets != NULL && i < dem_insets_count(insets); i++) {
		const struct dem_inset_info *info = dem_insets_info(insets, i);
		char more[48] = "";
		if (info->paths > 1)
			snprintf(more, sizeof more, " and %zu more", info->paths - 1);
		printf("inset %s%s: %lld x %lld posts, %g m apart, level %d, feathered over %g m%s\n", info->source, more, (long long)info->width,
		       (long long)info->height, info->spacing, info->level, info->feather,
		       info->found ? " (finer than the others; --spacing stores all at one spacing)" : "");
		if (info->rim_posts > 0)
			printf("  %.3f m %s than what surrounds it (median of %lld posts of its rim)%s\n", fabs(info->offset),
			       info->offset < 0 ? "lower" : "higher", (long long)info->rim_posts,
			       info->matched ? ", taken off" : "; --match-heights takes that off");
	}
}

static void print_plan(const struct dem_info *info, const struct dem_insets *insets, const struct store_meta *meta)
{
	const struct extent *extent = &meta->extent;
	printf("%zu source%s%s%s\n", info->source_count, info->source_count == 1 ? "" : "s",
	       info->projected[0] != '\0' ? ", projected from " : "", info->projected);
	char system[160];
	chart_system_name(meta->srs, system, sizeof system);
	if (info->projected[0] != '\0' && system[0] != '\0')
		printf("projected to %s%s%s\n", system, info->ground_off != 0 ? "" : ", where a metre is a metre on the ground",
		       info->keepable ? "; --t-srs source keeps the source's own system" : "");
	else if (system[0] != '\0')
		printf("srs: %s\n", system);
	printf("%lld x %lld posts, %g m apart (%.3f x %.3f km), tiles of %u x %u posts, levels 0 to %d\n",
	       (long long)info->width, (long long)info->height, info->spacing,
	       (double)(info->width - 1) * info->spacing / 1e3, (double)(info->height - 1) * info->spacing / 1e3,
	       extent->cells + 1, extent->cells + 1, extent_coarsest(extent));
	printf("vertical: %s\n", info->vertical[0] != '\0' ? info->vertical : "not said");
	print_insets(insets);
	if (info->overlap_posts > 0)
		printf("sources overlap at %lld posts and differ at %lld of them, by %g m at most; the first named "
		       "wins\n",
		       (long long)info->overlap_posts, (long long)info->overlap_differing,
		       info->overlap_difference);
}

/* What a run that makes something would refuse. */
static void note_output(const struct import *import, const char *path)
{
	struct stat file;
	struct store *store = NULL;
	char text[1400];
	int64_t count = 0;
	snprintf(text, sizeof text, "%.1300s.part", path);
	if (stat(text, &file) == 0 && file.st_size > 0 && !import->resume)
		note("%s: an earlier import was broken off with %.3g MB done; with --resume the same import goes on there, without it that is thrown away", path,
		     (double)file.st_size / 1e6);
	if (stat(path, &file) != 0)
		return;
	if (!import->overwrite)
		note("%s: it exists; without --overwrite it is not replaced", path);
	else if (import->imagery_count > 0 && !import->force)
		note("%s: it exists; with --imagery it is not replaced without --force, too", path);
	if (!import->force && store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK &&
	    store_losses(store, true, text, sizeof text, &count) == STATUS_OK && count > 0)
		note("%s: %s, which would be lost; without --force it is not replaced", path, text);
	store_close(store);
}

static enum status read_options(const struct arguments *arguments, struct import *import)
{
	const char *value;
	for (const struct command_option *option = options; option->name != NULL; option++)
		for (size_t nth = 0; intake_import_has_option(option->name) && (value = arguments_nth(arguments, option->name, nth)) != NULL; nth++)
			TRY(intake_import_option(import, option->name, value));
	return STATUS_OK;
}

/* Also where nothing was made: then errors were not measured. */
static void print_planned(const struct import *import)
{
	const struct dem_info *info = dem_info(import->opened);
	const double posts = (double)info->width * (double)info->height;
	const char *what = info->resampled ? "resampled source" : "source";
	if (import->meta.max_error > 0)
		printf("stored heights off the %s by at most %g m\n", what, import->meta.max_error);
	else
		printf("stored heights are those of the %s, lossless\n", what);
	/* Bytes of a post depend on the ground and on the error that is allowed. */
	printf("the sources cover %.3g %% of %.4g posts: about %.2f to %.2f MB\n", 100 * info->covered, posts, posts * info->covered * 0.2 / 1e6,
	       posts * info->covered * 2 / 1e6);
}

/* Where errors that resampling makes come from, and what lessens them. */
static void print_resampling(const struct import *import, const struct store_meta *meta)
{
	const struct dem_info *info = dem_info(import->opened);
	const bool near = import->dem.resample == DEM_NEAR, sharp = import->dem.resample == DEM_CUBIC || import->dem.resample == DEM_LANCZOS;
	if (!info->resampled)
		return;
	if (meta->off_source.posts > 0)
		printf("  these come from resampling to posts %g m apart, the largest at single peaks, edges and rims of holes; a finer --spacing%s lessens them\n",
		       info->spacing, sharp ? "" : near ? " or -r bilinear" : " or -r cubic");
	if (!near && info->unit > 0 && meta->max_error >= info->unit / 2 && !info->shifted)
		printf("  resampled heights are rounded to the source's unit of %g m; --max-error %g keeps them smooth, in about half as many bytes again\n",
		       info->unit, info->unit / 20);
}

static enum status print_json(const struct import *import, const struct intake *made, const struct intake_imagery *coloured)
{
	const struct dem_info *info = dem_info(import->opened);
	cJSON *object = cJSON_CreateObject();
	json_pair(object, "posts", (double)info->width, (double)info->height);
	json_number(object, "spacing", info->spacing);
	json_pair(object, "origin", info->origin[0], info->origin[1]);
	cJSON_AddStringToObject(object, "srs", info->srs);
	cJSON_AddStringToObject(object, "projected", info->projected);
	cJSON_AddStringToObject(object, "vertical", info->vertical);
	json_integer(object, "sources", (int64_t)info->source_count);
	cJSON *overlap = cJSON_AddObjectToObject(object, "overlap");
	json_integer(overlap, "posts", info->overlap_posts);
	json_integer(overlap, "differing", info->overlap_differing);
	json_number(overlap, "greatest", info->overlap_difference);
	errors_json(object, &made->meta);
	json_number(object, "covered", info->covered);
	json_pair(object, "height", made->low, made->high);
	json_integer(object, "bytes", made->bytes);
	json_number(object, "seconds", made->seconds);
	if (coloured != NULL)
		imagery_json(cJSON_AddObjectToObject(object, "imagery"), coloured);
	return json_print(object);
}

static enum status make(struct import *import, const char *path, struct intake *made, struct intake_imagery *coloured)
{
	struct progress progress;
	interrupt_catch();
	progress_start(&progress, path, "rows");
	enum status status = intake_import_run(import, path, progress_step, &progress, made, coloured);
	progress_end(&progress);
	return status;
}

static void print_text(const struct import *import, const struct intake *made, bool dry)
{
	if (!dry)
		print_made(made);
	print_plan(dem_info(import->opened), import->insets, &import->meta);
	if (dry)
		print_planned(import);
	else
		print_errors(&made->meta, "stored heights ", "stored heights ");
	print_resampling(import, &made->meta);
	print_holes(&made->meta, "no data: ");
}

/* Makes the store of sources that are open, unless it is a dry run, and prints what it is. */
static enum status make_and_print(const struct arguments *arguments, struct import *import, const char *path)
{
	const bool dry = arguments_flag(arguments, "dry-run");
	struct intake_imagery coloured = {.tiles = 0};
	struct intake made = {.meta = import->meta, .low = (double)NAN, .high = (double)NAN};
	if (dry && import->imagery_count > 0)
		TRY(intake_imagery_check(import));
	if (dry)
		note_output(import, path);
	else
		TRY(make(import, path, &made, &coloured));
	if (arguments_flag(arguments, "json"))
		return print_json(import, &made, coloured.store != NULL ? &coloured : NULL);
	print_text(import, &made, dry);
	if (coloured.store != NULL)
		print_imagery(&coloured);
	return STATUS_OK;
}

/* SOURCEs beside imagery make a new store. Where a shell made several names of --imagery *.tif they are pictures, and their user wants the store kept. */
static enum status check_replaced(const struct arguments *arguments, const struct import *import, const char *path)
{
	struct stat file;
	if (import->imagery_count == 0 || (import->overwrite && import->force) || arguments_flag(arguments, "dry-run") || stat(path, &file) != 0)
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "import: %s exists, and %s would be the heights of a new store in its place; to put pictures into the store as it is name no SOURCE, and "
			 "each picture, or their folder, by --imagery; to replace the store give --overwrite --force, too", path, arguments_at(arguments, 0));
}

/* Of a store that exists. */
static enum status run_imagery(const struct arguments *arguments, const struct import *import, const char *path)
{
	struct intake_imagery coloured;
	struct progress progress;
	interrupt_catch();
	progress_start(&progress, path, "rows");
	const enum status status = intake_import_imagery(import, path, arguments_flag(arguments, "dry-run"), progress_step, &progress, &coloured);
	progress_end(&progress);
	TRY(status);
	if (arguments_flag(arguments, "json")) {
		cJSON *object = cJSON_CreateObject();
		imagery_json(cJSON_AddObjectToObject(object, "imagery"), &coloured);
		return json_print(object);
	}
	print_imagery(&coloured);
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct import import;
	const char *path = arguments_text(arguments, "o");
	if (path == NULL)
		return fail_with(STATUS_USAGE, "import: -o is missing; give the store to make, as in -o world.furrow");
	const char **sources = mem_calloc(arguments_count(arguments) + 1, sizeof *sources);
	TRY_MEM(sources, "sources");
	for (size_t i = 0; i < arguments_count(arguments); i++)
		sources[i] = arguments_at(arguments, i);
	intake_import_init(&import);
	enum status status;
	TRY_OR(done, read_options(arguments, &import));
	if (import.imagery_count > 0 && arguments_count(arguments) == 0) {
		TRY_OR(done, run_imagery(arguments, &import, path));
		goto done;
	}
	if (arguments_count(arguments) == 0)
		TRY_OR(done, fail_with(STATUS_USAGE, "import: something is missing; usage: furrow import SOURCE... -o STORE [options], or furrow import --imagery ORTHO... -o STORE"));
	TRY_OR(done, check_replaced(arguments, &import, path));
	TRY_OR(done, intake_import_open(&import, sources, arguments_count(arguments)));
	TRY_OR(done, make_and_print(arguments, &import, path));
done:
	intake_import_finish(&import);
	mem_free(sources);
	return status;
}

const struct command command_import = {
	.name = "import",
	.summary = "elevation data to a terrain store",
	.arguments = COMMAND_ARGUMENTS({"SOURCE", .help = "a raster, a folder or a .zip of rasters, or @list.txt", .files = SOURCES,
	 .repeats = true}),
	.options = options,
	.details = "Several sources become one terrain; each may have its own SRS, spacing and unit. Where they overlap the first "
		   "named wins. Without --spacing, a source that is at least twice as fine as the others, and lies within them, is "
		   "stored as an inset.\n\n"
		   "In a folder, files without a place (as PNG) are skipped if others have one. Tiles as .hgt.gz, .hgt.zip and "
		   ".hgt.xz, and a PDS .img with its .lbl, are read as they are. A .zip stands for the rasters in it, and so do the "
		   "archives of a folder that has nothing else. A folder that is a Zarr, or a grid of Arc/Info, is one raster.\n\n"
		   "Heights of terrain tiles are coded in colours. terrarium: red * 256 + green + blue / 256 - 32768 m. mapbox: "
		   "(red * 65536 + green * 256 + blue) / 10 - 10000 m. --nodata is in metres then. An inset with one band has "
		   "plain heights.\n\n"
		   "-r average takes the mean of what a post covers, and lanczos a sharp kernel, as gdalwarp does.\n\n"
		   "The store is in metres. --t-srs auto takes the SRS of the first source if that is in metres that are true to "
		   "0.1 % there; otherwise UTM, or off Earth a projection that is true at the data's latitude. --t-srs source "
		   "keeps SRS and posts of the first source as they are, true or not. Degrees and feet cannot be kept: give "
		   "--t-srs auto or an SRS in metres for such a source.\n\n"
		   "Off Earth, values may be radii: distances from the body's middle. They become heights over the sphere of their "
		   "SRS. --radii auto finds them by their size, and tells.\n\n"
		   "Heights are above an ellipsoid, a geoid or a sea level. Import tells what a source says, and keeps it. "
		   "--t-vertical converts, by PROJ and its grids: ellipsoid (of the source's SRS), egm96, egm2008, or any vertical "
		   "SRS as EPSG:5703. If a source does not say, --s-vertical must: SRTM is above egm96.\n\n"
		   "Sources may come from strangers. Without --allow-network nothing that a source names is fetched. A VRT names files of its own "
		   "folder and those below it, or of --vrt-folder.\n\n"
		   "--imagery lays pictures over the terrain, each in its own SRS and resolution. Where several overlap the first named wins. A pixel is a post, "
		   "or 2, 4 or 8 pixels a post along a side: the coarsest that keeps the finest picture. Tiles and their coarser levels are WebP. Without "
		   "SOURCE the pictures go into STORE as it is, ruts and overlays stay, and --overwrite replaces the pictures it has. A folder or @list.txt stands for several. --resume goes on with an import of pictures that was broken off.\n",
	.examples = "furrow import N46E007.hgt -o alps.furrow\n"
		    "furrow import tiles/ -o site.furrow --t-srs EPSG:25832 --spacing 1\n"
		    "furrow import wide.tif --inset site.tif -o site.furrow --match-heights\n"
		    "furrow import --imagery ortho.tif -o site.furrow\n",
	.see = "furrow-info(1), furrow-verify(1), store(5)",
	.run = run,
};
