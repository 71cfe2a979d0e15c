/* furrow synth: synthetic terrain, as a raster or as a store. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "intake.h"

static const struct command_option options[] = {
	{"o", "OUT", "what to make: .tif, .png (one unit a metre) or .furrow"},
	{"posts", "WxH", "posts east and north"},
	{"spacing", "M", "metres between posts"},
	{"kind", "KIND", "ridged (default), dunes or plain"},
	{"relief", "M", "metres from the lowest to the highest it may reach (300; dunes 40; plain 20)"},
	{"seed", "S", "another number, another terrain (1)"},
	{"overwrite", NULL, "replace a store; rasters are replaced in any case"},
	{NULL, NULL, NULL},
};

static enum status synth_posts(void *user, struct post_rect rect, double *heights)
{
	dem_synth_posts(user, rect, heights);
	return STATUS_OK;
}

static enum status write_raster(struct dem_synth *synth, const char *path, bool png)
{
	const int64_t most = ((int64_t)1 << 20) / synth->width, band = most < 1 ? 1 : most > 64 ? 64 : most; /* rows */
	struct dem_raster raster = {
		.path = path,
		.width = synth->width,
		.height = synth->height,
		.type = png ? DEM_UINT16 : DEM_FLOAT32,
		.srs = "",
		.spacing = synth->spacing,
	};
	struct dem_writer *writer = NULL;
	double *heights = NULL;
	interrupt_catch();
	enum status status = dem_writer_create(&raster, &writer);
	if (status != STATUS_OK)
		return status;
	struct progress progress;
	progress_start(&progress, path, "rows");
	heights = mem_alloc((size_t)synth->width * (size_t)band, sizeof *heights);
	if (heights == NULL)
		status = fail_memory("synthetic rows");
	for (int64_t y = 0; y < synth->height && status == STATUS_OK; y += band) {
		int64_t rows = synth->height - y < band ? synth->height - y : band;
		dem_synth_posts(synth, (struct post_rect){0, y, synth->width, y + rows}, heights);
		status = dem_writer_rows(writer, rows, heights);
		if (status == STATUS_OK)
			status = progress_step(&progress, y + rows, synth->height);
	}
	progress_end(&progress);
	if (status == STATUS_OK)
		status = dem_writer_publish(writer);
	dem_writer_destroy(writer);
	mem_free(heights);
	if (status == STATUS_OK)
		printf("%s: %lld x %lld posts, %g m apart\n", path, (long long)synth->width,
		       (long long)synth->height, synth->spacing);
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
	static const char *const kinds[] = {"ridged", "dunes", "plain", NULL};
	static const double reliefs[] = {300, 40, 20};
	const char *path = arguments_text(arguments, "o");
	struct dem_synth synth = {.spacing = 0, .relief = 0};
	int kind = 0;
	int64_t seed = 1;
	enum status status = arguments_expect(arguments, 0, 0);
	if (status == STATUS_OK && path == NULL)
		status = fail_with(STATUS_USAGE, "synth: -o is missing; give a file ending in .tif, .png or .furrow");
	if (status == STATUS_OK)
		status = parse_posts(arguments_text(arguments, "posts"), &synth);
	if (status == STATUS_OK)
		status = arguments_number(arguments, "spacing", 1e-4, 1e5, &synth.spacing);
	if (status == STATUS_OK && synth.spacing == 0)
		status = fail_with(STATUS_USAGE, "synth: --spacing is missing; give metres between posts");
	if (status == STATUS_OK)
		status = arguments_choice(arguments, "kind", kinds, &kind);
	synth.relief = reliefs[kind];
	if (status == STATUS_OK)
		status = arguments_number(arguments, "relief", 0, 15000, &synth.relief);
	if (status == STATUS_OK)
		status = arguments_integer(arguments, "seed", 0, INT64_MAX, &seed);
	if (status != STATUS_OK)
		return status;
	synth.kind = (enum dem_synth_kind)kind;
	synth.seed = (uint64_t)seed;
	bool png = dem_path_ends(path, ".png");
	if (!dem_path_ends(path, ".furrow")) {
		if (!png && !dem_path_ends(path, ".tif") && !dem_path_ends(path, ".tiff"))
			return fail_with(STATUS_USAGE, "synth: %s: no format goes by that ending; use .tif, .png or .furrow",
					 path);
		return write_raster(&synth, path, png);
	}
	char sources[96];
	snprintf(sources, sizeof sources, "synthetic %s, relief %g m, seed %lld", kinds[kind], synth.relief,
		 (long long)seed);
	struct intake intake = {
		.path = path,
		.overwrite = arguments_flag(arguments, "overwrite"),
		.jobs = thread_cores(),
		.posts = synth_posts,
		.posts_user = &synth,
		.meta = {
			.world = {synth.width, synth.height, synth.spacing, 256},
			.max_error = intake_default_error(0),
			.step = intake_step(intake_default_error(0), 0, false),
			.srs = "",
			.vertical = "",
			.sources = sources,
		},
	};
	return intake_run(&intake);
}

const struct command command_synth = {
	.name = "synth",
	.usage = "synth -o OUT.tif|OUT.png|OUT.furrow --posts WxH --spacing M [--kind ridged|dunes|plain] "
		 "[--relief M] [--seed S]",
	.summary = "make a synthetic terrain of any size",
	.options = options,
	.run = run,
};
