/*
 * furrow synth: synthetic terrain, as a raster or as a store. A post is a pure function of where it is,
 * so that rows are worked out by several threads at once and their number changes no bit.
 */
#include <stdio.h>
#include <stdlib.h>

#include "command.h"
#include "intake/intake.h"
#include "made.h"

static const char *const kinds[] = {"ridged", "dunes", "plain", NULL};

static const struct command_option options[] = {
	{"o", "OUT", .help = "what to make; a .png has one unit a metre", .files = "tif tiff png furrow", .needed = true},
	{"posts", "WxH", .help = "posts east and north", .needed = true},
	{"spacing", "M", .help = "distance between posts", .unit = "m", .needed = true},
	{"kind", "KIND", .help = "landscape", .choices = kinds, .preset = "ridged"},
	{"relief", "M", .help = "height from the lowest to the highest that it may reach", .unit = "m",
	 .preset = "300; dunes 40, plain 20"},
	{"seed", "S", .help = "another number, another terrain", .preset = "1"},
	{"jobs", "N", .help = "threads that work posts out, and as many that pack tiles; 1: one for everything",
	 .preset = "all cores"},
	{"overwrite", .help = "replace a store; rasters are replaced in any case"},
	{"force", .help = "with --overwrite: also if its snapshots, or overlays that depend on it, are lost; says which"},
	{.name = NULL},
};

#define JOBS_MOST 64

struct making {
	struct dem_synth synth;
	int64_t jobs; /* 1 to JOBS_MOST */
};

struct job {
	const struct dem_synth *synth;
	struct post_rect rect;
	double *heights;
	struct thread thread;
};

static void *job_run(void *argument)
{
	struct job *job = argument;
	dem_synth_posts(job->synth, job->rect, job->heights);
	return NULL;
}

/* A dem_posts_fn: some rows a job; this thread's own are the first. */
static enum status make_posts(void *user, struct post_rect rect, double *heights)
{
	const struct making *making = user;
	struct job jobs[JOBS_MOST] = {{0}};
	int64_t rows = rect.y1 - rect.y0, width = rect.x1 - rect.x0;
	int64_t count = rows < making->jobs ? rows : making->jobs;
	enum status status = STATUS_OK;
	for (int64_t i = count - 1; i >= 0; i--) {
		int64_t first = rows * i / count, end = rows * (i + 1) / count;
		jobs[i].synth = &making->synth;
		jobs[i].rect = (struct post_rect){rect.x0, rect.y0 + first, rect.x1, rect.y0 + end};
		jobs[i].heights = heights + first * width;
		if (i > 0)
			TRY_OR(done, thread_start(&jobs[i].thread, job_run, &jobs[i], "furrow-synth"));
		else
			job_run(&jobs[i]);
	}
done:
	for (int64_t i = 1; i < count; i++)
		thread_join(&jobs[i].thread);
	return status;
}

static enum status write_rows(struct making *making, const char *path, struct dem_writer *writer)
{
	const struct dem_synth *synth = &making->synth;
	const int64_t most = ((int64_t)1 << 20) / synth->width, band = most < 1 ? 1 : most > 64 ? 64 : most; /* rows */
	double *heights = mem_alloc((size_t)synth->width * (size_t)band, sizeof *heights);
	TRY_MEM(heights, "synthetic rows");
	struct progress progress;
	progress_start(&progress, path, "rows");
	enum status status = STATUS_OK;
	for (int64_t y = 0; y < synth->height; y += band) {
		int64_t rows = synth->height - y < band ? synth->height - y : band;
		TRY_OR(done, make_posts(making, (struct post_rect){0, y, synth->width, y + rows}, heights));
		TRY_OR(done, dem_writer_rows(writer, rows, heights));
		TRY_OR(done, progress_step(&progress, y + rows, synth->height));
	}
done:
	progress_end(&progress);
	mem_free(heights);
	return status;
}

static enum status write_raster(struct making *making, const char *path, bool png)
{
	const struct dem_synth *synth = &making->synth;
	struct dem_raster raster = {
		.path = path,
		.width = synth->width,
		.height = synth->height,
		.type = png ? DEM_UINT16 : DEM_FLOAT32,
		.srs = "",
		.spacing = synth->spacing,
	};
	struct dem_writer *writer = NULL;
	interrupt_catch();
	enum status status;
	TRY_OR(done, dem_writer_create(&raster, &writer));
	TRY_OR(done, write_rows(making, path, writer));
	TRY_OR(done, dem_writer_publish(writer));
	printf("%s: %lld x %lld posts, %g m apart\n", path, (long long)synth->width, (long long)synth->height, synth->spacing);
done:
	dem_writer_destroy(writer);
	return status;
}

static enum status parse_posts(const char *text, struct dem_synth *synth)
{
	char *end = NULL;
	long long width = text != NULL ? strtoll(text, &end, 10) : 0, height = 0;
	if (end != NULL && *end == 'x')
		height = strtoll(end + 1, &end, 10);
	if (end == NULL || *end != '\0' || width < 2 || height < 2 || width > 1 << 24 || height > 1 << 24)
		return fail_with(STATUS_USAGE, "synth: --posts %s: not WIDTHxHEIGHT; give two whole numbers from 2 to 16777216, as in --posts 2049x2049",
				 text != NULL ? text : "is missing");
	synth->width = width;
	synth->height = height;
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	static const double reliefs[] = {300, 40, 20};
	const char *path = arguments_text(arguments, "o");
	struct making making = {.jobs = thread_cores() < JOBS_MOST ? thread_cores() : JOBS_MOST};
	struct dem_synth *synth = &making.synth;
	int kind = 0;
	int64_t seed = 1;
	if (path == NULL)
		return fail_with(STATUS_USAGE, "synth: -o is missing; give a file ending in .tif, .png or .furrow");
	TRY(parse_posts(arguments_text(arguments, "posts"), synth));
	TRY(arguments_number(arguments, "spacing", 1e-4, 1e5, &synth->spacing));
	if (synth->spacing == 0)
		return fail_with(STATUS_USAGE, "synth: --spacing is missing; give metres between posts");
	TRY(arguments_choice(arguments, "kind", &kind));
	synth->relief = reliefs[kind];
	TRY(arguments_number(arguments, "relief", 0, 15000, &synth->relief));
	TRY(arguments_integer(arguments, "seed", 0, INT64_MAX, &seed));
	TRY(arguments_integer(arguments, "jobs", 1, JOBS_MOST, &making.jobs));
	synth->kind = (enum dem_synth_kind)kind;
	synth->seed = (uint64_t)seed;
	bool png = dem_path_ends(path, ".png");
	if (!dem_path_ends(path, ".furrow")) {
		if (!png && !dem_path_ends(path, ".tif") && !dem_path_ends(path, ".tiff"))
			return fail_with(STATUS_USAGE, "synth: %s: no format goes by that ending; use .tif, .png or .furrow",
					 path);
		return write_raster(&making, path, png);
	}
	char sources[96];
	snprintf(sources, sizeof sources, "synthetic %s, relief %g m, seed %lld", kinds[kind], synth->relief,
		 (long long)seed);
	struct intake intake = {
		.path = path,
		.overwrite = arguments_flag(arguments, "overwrite"),
		.force = arguments_flag(arguments, "force"),
		.jobs = making.jobs,
		.posts = make_posts,
		.posts_user = &making,
		.meta = {
			.extent = {synth->width, synth->height, synth->spacing, 256},
			.max_error = intake_default_error(0),
			.step = intake_step(intake_default_error(0), 0, false),
			.srs = "",
			.vertical = "",
			.sources = sources,
		},
	};
	struct progress progress;
	interrupt_catch();
	progress_start(&progress, path, "rows");
	intake.progress = progress_step;
	intake.progress_user = &progress;
	enum status status = intake_run(&intake);
	progress_end(&progress);
	TRY(status);
	print_made(&intake);
	return STATUS_OK;
}

const struct command command_synth = {
	.name = "synth",
	.summary = "make a synthetic terrain of any size",
	.options = options,
	.details = "The terrain is computed as it is written, so that it may be larger than memory. The same options give the "
		   "same terrain.\n",
	.examples = "furrow synth -o world.furrow --posts 2049x2049 --spacing 1\n"
		    "furrow synth -o dunes.tif --posts 513x513 --spacing 0.5 --kind dunes\n",
	.see = "furrow-import(1)",
	.run = run,
};
