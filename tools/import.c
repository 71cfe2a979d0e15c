/* furrow import: elevation data to a store. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "command.h"
#include "intake.h"

static const struct command_option options[] = {
	{"o", "STORE", "the store to make, usually NAME.furrow"},
	{"tile", "N", "cells along a tile's side, a power of two from 8 to 1024 (256)"},
	{"max-error", "M", "most a stored height may be off its source; 0: lossless (half the source's unit)"},
	{"s-srs", "SRS", "the sources' reference system, if they do not say or say it wrong"},
	{"t-srs", "SRS", "the store's, in metres; auto (default): UTM, or true at its latitude off Earth"},
	{"spacing", "M", "metres between posts: resamples; for sources without a place, their own (1)"},
	{"r", "METHOD", "resampling: bilinear (default), cubic or near"},
	{"nodata", "V", "a value that means nodata though no tag says so; may be repeated"},
	{"fill", NULL, "fill holes from their rims"},
	{"height-range", "MIN,MAX", "metres that a PNG's 0 and full scale mean (one metre a unit)"},
	{"pack", "KIND", "fast (default) or small"},
	{"jobs", "N", "threads that pack tiles beside the one that reads; 1: one for everything (the machine's cores)"},
	{"resume", NULL, "go on with an import that was broken off or killed; the same store, whatever --jobs"},
	{"overwrite", NULL, "replace STORE"},
	{"dry-run", NULL, "say what would be made, and make nothing"},
	{NULL, NULL, NULL},
};

struct request {
	const char *path;
	struct dem_params dem;
	int64_t tile, jobs;
	double max_error; /* below 0: the default */
	int pack;
	double nodata[32];
};

static enum status read_request(const struct arguments *arguments, const char **sources, struct request *request)
{
	static const char *const methods[] = {"bilinear", "cubic", "near", NULL};
	static const char *const packs[] = {"fast", "small", NULL};
	int method = 0;
	double range[2] = {0, 0};
	request->path = arguments_text(arguments, "o");
	if (request->path == NULL)
		return fail_with(STATUS_USAGE, "import: -o is missing; give the store to make, as in -o world.furrow");
	enum status status = arguments_expect(arguments, 1, SIZE_MAX);
	for (size_t i = 0; i < arguments_count(arguments); i++)
		sources[i] = arguments_at(arguments, i);
	request->dem.sources = sources;
	request->dem.source_count = arguments_count(arguments);
	request->dem.s_srs = arguments_text(arguments, "s-srs");
	request->dem.t_srs = arguments_text(arguments, "t-srs");
	request->dem.fill = arguments_flag(arguments, "fill");
	request->dem.nodata = request->nodata;
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "tile", TILE_CELLS_MIN, TILE_CELLS_MAX, &request->tile);
	if (status == STATUS_OK && (request->tile & (request->tile - 1)) != 0)
		status = fail_with(STATUS_USAGE, "import: --tile %lld: not a power of two; give 8, 16, ... 256 (default), 512 or 1024",
				   (long long)request->tile);
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "jobs", 1, 256, &request->jobs);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "max-error", 0, 1e4, &request->max_error);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "spacing", 1e-4, 1e6, &request->dem.spacing);
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "r", methods, &method);
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "pack", packs, &request->pack);
	if (status == STATUS_OK)
		status = arguments_numbers(arguments, "height-range", 2, range, &request->dem.has_height_range);
	request->dem.resample = (enum dem_resample)method;
	request->dem.jobs = request->jobs;
	request->dem.height_min = range[0];
	request->dem.height_max = range[1];
	const char *text;
	for (size_t i = 0; status == STATUS_OK && (text = arguments_nth(arguments, "nodata", i)) != NULL; i++) {
		if (i == sizeof request->nodata / sizeof *request->nodata)
			return fail_with(STATUS_USAGE, "import: --nodata is given too often; 32 values at most");
		if (!parse_number_or_infinity(text, &request->nodata[i]))
			return fail_with(STATUS_USAGE, "import: --nodata %s: not a number; give one as in --nodata -32767",
					 text);
		request->dem.nodata_count = i + 1;
	}
	return status;
}

static void print_plan(const struct dem_info *info, const struct store_meta *meta)
{
	const struct extent *extent = &meta->extent;
	printf("%zu source%s%s%s\n", info->source_count, info->source_count == 1 ? "" : "s",
	       info->projected[0] != '\0' ? ", projected from " : "", info->projected);
	printf("%lld x %lld posts, %g m apart (%.3f x %.3f km), tiles of %u x %u posts, levels 0 to %d\n",
	       (long long)info->width, (long long)info->height, info->spacing,
	       (double)(info->width - 1) * info->spacing / 1e3, (double)(info->height - 1) * info->spacing / 1e3,
	       extent->cells + 1, extent->cells + 1, extent_coarsest(extent));
	if (meta->max_error > 0)
		printf("stored heights off their source by at most %g m\n", meta->max_error);
	else
		puts("stored heights are their source's, lossless");
	if (info->overlap_posts > 0)
		printf("sources overlap at %lld posts and differ at %lld of them, by %g m at most; the first named "
		       "wins\n",
		       (long long)info->overlap_posts, (long long)info->overlap_differing,
		       info->overlap_difference);
}

/* A hole that nobody declared shows as a height no ground has; mixed with others it may be any. */
static void note_sentinel(const struct intake *intake)
{
	static const double usual[] = {-9999, -32767, -32768, -99999, 32767, 99999};
	/* Coarser heights may be off a sentinel that they come from, or be on one that they do not. */
	for (size_t i = 0; i < sizeof usual / sizeof usual[0] && intake->meta.max_error < 1; i++)
		if (intake->low == usual[i] || intake->high == usual[i]) {
			note("the %s height is %g m; if that means nodata, import again with --nodata %g",
			     usual[i] < 0 ? "lowest" : "highest", usual[i], usual[i]);
			return;
		}
	if (intake->low <= -12000)
		note("the lowest height is %g m; if a value of the sources means nodata, as -32767 often does, import "
		     "again with --nodata and that value", intake->low);
}

/* What a run that makes something would refuse. */
static void note_output(const struct intake *intake)
{
	struct stat file;
	if (!intake->overwrite && stat(intake->path, &file) == 0)
		note("%s: it exists; without --overwrite it is not replaced", intake->path);
}

static char *join_lines(const char *const *lines, size_t count)
{
	size_t bytes = 1;
	for (size_t i = 0; i < count; i++)
		bytes += strlen(lines[i]) + 1;
	char *text = mem_alloc(bytes, 1), *at = text;
	for (size_t i = 0; text != NULL && i < count; i++)
		at += sprintf(at, "%s%s", i > 0 ? "\n" : "", lines[i]);
	if (text != NULL)
		*at = '\0';
	return text;
}

static enum status read_posts(void *user, struct post_rect rect, double *heights)
{
	return dem_read(user, rect, heights);
}

static void describe_file(FILE *out, const char *path)
{
	struct stat file = {0};
	(void)stat(path, &file); /* what GDAL reads need not be a file */
	fprintf(out, "%lld bytes of %lld.%09ld %s\n", (long long)file.st_size, (long long)file.st_mtim.tv_sec,
		(long)file.st_mtim.tv_nsec, path);
}

/*
 * All that decides what the store will hold, a line each: what was asked for and, for each source and what
 * it is made of, its size and when it was last changed; and by which program, for the order of the tiles and
 * their bytes are its own. NULL without memory.
 */
static char *describe_request(const struct request *request, const struct dem_info *info, double step)
{
	char *text = NULL;
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	if (out == NULL)
		return NULL;
	const struct dem_params *dem = &request->dem;
	fputs("furrow " FURROW_VERSION "\n", out);
	fprintf(out, "posts %lld %lld tile %lld step %.17g pack %d spacing %.17g origin %.17g %.17g\n",
		(long long)info->width, (long long)info->height, (long long)request->tile, step, request->pack,
		info->spacing, info->origin[0], info->origin[1]);
	fprintf(out, "panel %lld resample %d fill %d range %d %.17g %.17g nodata", (long long)info->panel_posts,
		(int)dem->resample, dem->fill, dem->has_height_range, dem->height_min, dem->height_max);
	for (size_t i = 0; i < dem->nodata_count; i++)
		fprintf(out, " %.17g", dem->nodata[i]);
	fprintf(out, "\nsrs %s\nfrom %s\n", info->srs, dem->s_srs != NULL ? dem->s_srs : "");
	for (size_t i = 0; i < info->source_count; i++)
		describe_file(out, info->sources[i]);
	for (size_t i = 0; i < info->file_count; i++)
		describe_file(out, info->files[i]);
	bool whole = ferror(out) == 0;
	if (fclose(out) == 0 && whole)
		return text;
	free(text);
	return NULL;
}

static enum status run(const struct arguments *arguments)
{
	struct request request = {.tile = 256, .jobs = thread_cores(), .max_error = -1};
	struct dem *dem = NULL;
	char *lines = NULL, *description = NULL;
	const char **sources = mem_calloc(arguments_count(arguments) + 1, sizeof *sources);
	enum status status = sources != NULL ? STATUS_OK : fail_memory("sources");
	if (status == STATUS_OK)
		status = read_request(arguments, sources, &request);
	if (status == STATUS_OK)
		status = dem_open(&request.dem, &dem);
	if (status != STATUS_OK)
		goto done;

	const struct dem_info *info = dem_info(dem);
	double max_error = request.max_error >= 0 ? request.max_error : intake_default_error(info->unit);
	double step = intake_step(max_error, info->unit, info->whole);
	lines = join_lines(info->sources, info->source_count);
	description = describe_request(&request, info, step);
	if (lines == NULL || description == NULL) {
		status = fail_memory("sources");
		goto done;
	}
	struct intake intake = {
		.path = request.path,
		.overwrite = arguments_flag(arguments, "overwrite"),
		.resume = arguments_flag(arguments, "resume"),
		.jobs = request.jobs,
		.posts = read_posts,
		.posts_user = dem,
		.panel_posts = info->panel_posts,
		.meta = {
			.extent = {info->width, info->height, info->spacing, (uint32_t)request.tile},
			.step = step,
			.max_error = max_error,
			.srs = info->srs,
			.origin = {info->origin[0], info->origin[1]},
			.vertical = info->vertical,
			.sources = lines,
			.request = description,
			.pack = (enum store_pack)request.pack,
		},
	};
	const char *problem = extent_problem(&intake.meta.extent);
	if (problem != NULL) {
		status = fail_with(STATUS_INPUT, "import: %s; change --tile, --spacing or the sources", problem);
		goto done;
	}
	if (arguments_flag(arguments, "dry-run"))
		note_output(&intake);
	else
		status = intake_run(&intake);
	if (status == STATUS_OK) {
		print_plan(info, &intake.meta);
		note_sentinel(&intake);
	}
done:
	dem_close(dem);
	mem_free(lines);
	free(description);
	mem_free(sources);
	return status;
}

const struct command command_import = {
	.name = "import",
	.usage = "import SOURCE... -o STORE [options]",
	.summary = "elevation data to a terrain store",
	.details = "A SOURCE is a raster, a directory of them, or @list.txt. Several become one terrain; where they\n"
		   "overlap the first named wins. The store is in metres: sources in degrees or feet are projected.\n",
	.options = options,
	.run = run,
};
