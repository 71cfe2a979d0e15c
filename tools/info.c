/* furrow info: what a store holds. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chart/chart.h"
#include "command.h"
#include "errors.h"
#include "json.h"
#include "ruts.h"
#include "screen.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"json", .help = "one JSON object"},
	{.name = NULL},
};

static void geotransform(const struct store_meta *meta, double out[6])
{
	const struct extent *extent = &meta->extent;
	double half = extent->spacing / 2; /* a pixel's centre is its post */
	out[0] = meta->origin[0] - half;
	out[1] = extent->spacing;
	out[2] = 0;
	out[3] = meta->origin[1] + (double)(extent->height - 1) * extent->spacing + half;
	out[4] = 0;
	out[5] = -extent->spacing;
}

static cJSON *sources_json(const char *lines)
{
	cJSON *array = cJSON_CreateArray();
	while (*lines != '\0') {
		size_t length = strcspn(lines, "\n");
		char line[4096];
		snprintf(line, sizeof line, "%.*s", (int)length, lines);
		cJSON_AddItemToArray(array, cJSON_CreateString(line));
		lines += length + (lines[length] == '\n');
	}
	return array;
}

/* West, south, east and north of an inset's outermost posts, in the store's coordinates. */
static void inset_bounds(const struct store_meta *meta, const struct store_inset *inset, double bounds[4])
{
	const double spacing = extent_spacing(&meta->extent, inset->level);
	bounds[0] = meta->origin[0] + (double)inset->x * spacing;
	bounds[1] = meta->origin[1] + (double)inset->y * spacing;
	bounds[2] = bounds[0] + (double)(inset->width - 1) * spacing;
	bounds[3] = bounds[1] + (double)(inset->height - 1) * spacing;
}

/* Tiles of its level that an inset's rectangle touches. */
static int64_t inset_tiles(const struct store_meta *meta, const struct store_inset *inset)
{
	struct tile first, last;
	const struct post_rect rect = {inset->x, inset->y, inset->x + inset->width, inset->y + inset->height};
	if (!tile_range_of(&meta->extent, inset->level, rect, &first, &last))
		return 0;
	return ((int64_t)last.x - first.x + 1) * ((int64_t)last.y - first.y + 1);
}

static cJSON *insets_json(const struct store_meta *meta)
{
	cJSON *array = cJSON_CreateArray();
	struct store_inset inset;
	for (const char *text = meta->insets; store_inset_next(&text, &meta->extent, &inset);) {
		cJSON *object = cJSON_CreateObject();
		char source[4097];
		double bounds[4];
		snprintf(source, sizeof source, "%.*s", (int)inset.source_length, inset.source);
		inset_bounds(meta, &inset, bounds);
		cJSON_AddStringToObject(object, "source", source);
		json_integer(object, "level", inset.level);
		json_number(object, "spacing", extent_spacing(&meta->extent, inset.level));
		json_pair(object, "posts", (double)inset.width, (double)inset.height);
		cJSON_AddItemToObject(object, "bounds", cJSON_CreateDoubleArray(bounds, 4));
		for (int i = 0; i < 4; i++)
			bounds[i] -= meta->origin[i % 2];
		cJSON_AddItemToObject(object, "window", cJSON_CreateDoubleArray(bounds, 4));
		json_integer(object, "tiles", inset_tiles(meta, &inset));
		cJSON_AddItemToArray(array, object);
	}
	return array;
}

static void print_insets(const struct store_meta *meta)
{
	struct store_inset inset;
	for (const char *text = meta->insets; store_inset_next(&text, &meta->extent, &inset);) {
		double bounds[4];
		inset_bounds(meta, &inset, bounds);
		printf("inset      %.*s: %lld x %lld posts, %g m apart, level %d, %lld tiles; %.3f, %.3f to %.3f, %.3f; --window %s\n", (int)inset.source_length,
		       inset.source, (long long)inset.width, (long long)inset.height, extent_spacing(&meta->extent, inset.level), inset.level,
		       (long long)inset_tiles(meta, &inset), bounds[0], bounds[1], bounds[2], bounds[3],
		       number_window(bounds[0] - meta->origin[0], bounds[1] - meta->origin[1], bounds[2] - meta->origin[0],
				     bounds[3] - meta->origin[1]).text);
	}
}

/* Of all planes but the offset. */
static int64_t soil_sum(const int64_t numbers[PLANES])
{
	int64_t sum = 0;
	for (int plane = PLANE_DISTURBANCE; plane < PLANES; plane++)
		sum += numbers[plane];
	return sum;
}

/* Soil that is lost for good. The store counts what the last drive had aboard and in flight as compacted, too. */
static int64_t lost_of(const struct store_numbers *numbers)
{
	return numbers->compacted - numbers->carried - numbers->in_flight;
}

static cJSON *last_run_json(const struct store_numbers *numbers)
{
	if (numbers->last_run.scene_hash == NULL)
		return cJSON_CreateNull();
	cJSON *run = cJSON_CreateObject();
	cJSON_AddStringToObject(run, "scene_hash", numbers->last_run.scene_hash);
	json_integer(run, "step", numbers->last_run.step);
	json_number(run, "time", numbers->last_run.time);
	json_integer(run, "epochs", numbers->commits);
	return run;
}

static void add_parent(cJSON *object, const struct store *store)
{
	int64_t revision;
	const char *path = store_parent(store, &revision);
	json_integer(object, "overlays", store_depth(store));
	if (path == NULL) {
		cJSON_AddNullToObject(object, "parent");
		return;
	}
	cJSON *parent = cJSON_AddObjectToObject(object, "parent");
	cJSON_AddStringToObject(parent, "path", path);
	json_integer(parent, "revision", revision);
}

static const char imagery_codec[] = "WebP";

static cJSON *store_imagery_json(const struct store_meta *meta, const struct store_imagery *imagery)
{
	if (!imagery->found)
		return cJSON_CreateNull();
	cJSON *object = cJSON_CreateObject();
	json_integer(object, "level", imagery->finest);
	json_number(object, "pixel", extent_spacing(&meta->extent, imagery->finest));
	cJSON_AddStringToObject(object, "codec", imagery_codec);
	json_integer(object, "quality", imagery->quality);
	json_integer(object, "tiles", imagery->tiles);
	json_integer(object, "bytes", imagery->bytes);
	cJSON_AddItemToObject(object, "sources", sources_json(imagery->sources));
	return object;
}

static void print_store_imagery(const struct store_meta *meta, const struct store_imagery *imagery)
{
	if (imagery->broken_off)
		puts("imagery    an import of it was broken off; furrow import --imagery with --resume goes on");
	if (!imagery->found)
		return;
	printf("imagery    pixels of %s m, levels %d to %d, %lld tiles, %lld bytes, %s ", number_exact(extent_spacing(&meta->extent, imagery->finest)).text,
	       imagery->finest, extent_coarsest(&meta->extent), (long long)imagery->tiles, (long long)imagery->bytes, imagery_codec);
	if (imagery->quality == 0)
		puts("without loss");
	else
		printf("of quality %d\n", imagery->quality);
	for (const char *line = imagery->sources; *line != '\0';) {
		int length = (int)strcspn(line, "\n");
		printf("           %.*s\n", length, line);
		line += length + (line[length] == '\n');
	}
}

static enum status print_json(struct store *store, const struct store_numbers *numbers, const struct store_imagery *imagery, const double *ruts)
{
	const struct store_meta *meta = store_meta(store);
	const struct extent *extent = &meta->extent;
	double transform[6];
	geotransform(meta, transform);
	int working;
	cJSON *object = cJSON_CreateObject();
	json_integer(object, "tile", extent->cells);
	json_number(object, "spacing", extent->spacing);
	json_pair(object, "posts", (double)extent->width, (double)extent->height);
	json_pair(object, "levels", store_finest(store), extent_coarsest(extent));
	if (store_has_working_level(store, &working))
		json_integer(object, "working_level", working);
	else
		cJSON_AddNullToObject(object, "working_level");
	if (ruts != NULL)
		cJSON_AddItemToObject(object, "ruts", cJSON_CreateDoubleArray(ruts, 4));
	if (store_relief_text(store) != NULL)
		cJSON_AddRawToObject(object, "relief", store_relief_text(store));
	else
		cJSON_AddNullToObject(object, "relief");
	char hash[17];
	snprintf(hash, sizeof hash, "%016llx", (unsigned long long)store_base_hash(store));
	cJSON_AddStringToObject(object, "base_hash", hash);
	json_string(object, "base", store_base_path(store));
	add_parent(object, store);
	cJSON_AddStringToObject(object, "srs", meta->srs);
	cJSON_AddItemToObject(object, "geotransform", cJSON_CreateDoubleArray(transform, 6));
	cJSON_AddStringToObject(object, "vertical", meta->vertical);
	json_pair(object, "origin", meta->origin[0], meta->origin[1]);
	double bounds[4] = {meta->origin[0], meta->origin[1],
			    meta->origin[0] + (double)(extent->width - 1) * extent->spacing,
			    meta->origin[1] + (double)(extent->height - 1) * extent->spacing};
	cJSON_AddItemToObject(object, "bounds", cJSON_CreateDoubleArray(bounds, 4));
	cJSON_AddStringToObject(object, "nodata", "NaN");
	errors_json(object, meta);
	json_pair(object, "height", meta->low, meta->high);
	cJSON *tiles = cJSON_AddObjectToObject(object, "tiles");
	json_integer(tiles, "base", numbers->base_tiles);
	json_integer(tiles, "offset", numbers->plane_tiles[PLANE_OFFSET]);
	json_integer(tiles, "soil", soil_sum(numbers->plane_tiles));
	cJSON *bytes = cJSON_AddObjectToObject(object, "bytes");
	json_integer(bytes, "file", numbers->file_bytes);
	json_integer(bytes, "base", numbers->base_bytes);
	json_integer(bytes, "offset", numbers->plane_bytes[PLANE_OFFSET]);
	json_integer(bytes, "soil", soil_sum(numbers->plane_bytes));
	cJSON *soil = cJSON_AddObjectToObject(object, "soil");
	for (int plane = PLANE_DISTURBANCE; plane < PLANES; plane++) {
		cJSON *one = cJSON_AddObjectToObject(soil, plane_layer((enum plane)plane));
		json_integer(one, "tiles", numbers->plane_tiles[plane]);
		json_integer(one, "bytes", numbers->plane_bytes[plane]);
	}
	json_integer(object, "compacted", lost_of(numbers));
	json_integer(object, "added", numbers->added);
	json_integer(object, "carried", numbers->carried);
	json_integer(object, "in_flight", numbers->in_flight);
	cJSON *history = cJSON_AddObjectToObject(object, "history");
	json_integer(history, "revisions", numbers->revisions);
	json_integer(history, "snapshots", numbers->snapshots);
	json_integer(history, "rows", numbers->history_rows);
	json_integer(history, "bytes", numbers->history_bytes);
	cJSON_AddItemToObject(object, "sources", sources_json(meta->sources));
	cJSON_AddItemToObject(object, "insets", insets_json(meta));
	cJSON_AddItemToObject(object, "imagery", store_imagery_json(meta, imagery));
	cJSON_AddItemToObject(object, "last_run", last_run_json(numbers));
	return json_print(object);
}

/* What a store says is one line each, whatever it has in it. */
static void put_part(const char *before, const char *text)
{
	fputs(before, stdout);
	screen_put(text);
}

static void put_line(const char *before, const char *text, const char *after)
{
	put_part(before, text);
	puts(after);
}

static void print_srs(const char *wkt)
{
	char name[160];
	chart_system_name(wkt, name, sizeof name);
	if (wkt[0] == '\0')
		puts("srs        none: local metres");
	else if (name[0] != '\0')
		put_line("srs        ", name, "; --json has all of it");
	else
		put_line("srs        ", wkt, "");
}

#define PLACE_OFF 1e-6 /* m, inwards: furrow query finds the printed place on the terrain */

/* Prints a coordinate of the south-west post with three digits or more: as few as lie on the terrain and no further than PLACE_OFF in it. */
static void print_place(double value)
{
	char text[400]; /* a store may say 1e308 */
	int digits = 3;
	for (; snprintf(text, sizeof text, "%.*f", digits, value) < 30 && digits < 17; digits++) {
		const double printed = strtod(text, NULL);
		if (printed >= value && printed - value < PLACE_OFF)
			break;
	}
	fputs(text, stdout);
}

/* Converts an amount, 2^-20 m summed over posts, to m3, as run.json has it. Ruts are at the working level. */
static double volume_of(const struct store *store, int64_t amount)
{
	const struct extent *extent = &store_meta(store)->extent;
	int working;
	const double spacing = store_has_working_level(store, &working) ? extent_spacing(extent, working) : extent->spacing;
	return (double)amount * lattice_offset_metres(1) * spacing * spacing;
}

static void print_text(struct store *store, const struct store_numbers *numbers, const struct store_imagery *imagery, const double *ruts)
{
	const struct store_meta *meta = store_meta(store);
	const struct extent *extent = &meta->extent;
	int working;
	int64_t revision;
	const char *parent = store_parent(store, &revision);
	printf("posts      %lld x %lld, %s m apart: %.3f x %.3f km\n", (long long)extent->width,
	       (long long)extent->height, number_exact(extent->spacing).text, (double)(extent->width - 1) * extent->spacing / 1e3,
	       (double)(extent->height - 1) * extent->spacing / 1e3);
	printf("tiles      %u x %u posts; %lld base, %lld offset, %lld soil\n", extent->cells + 1, extent->cells + 1,
	       (long long)numbers->base_tiles, (long long)numbers->plane_tiles[PLANE_OFFSET],
	       (long long)soil_sum(numbers->plane_tiles));
	printf("levels     %d to %d", store_finest(store), extent_coarsest(extent));
	if (store_has_working_level(store, &working))
		printf("; deformed at level %d, %s m", working, number_exact(extent_spacing(extent, working)).text);
	if (ruts != NULL)
		printf("\nruts       within %s (west, south, east, north of the tiles with ruts, m; for --window)",
		       number_window(ruts[0], ruts[1], ruts[2], ruts[3]).text);
	if (store_relief_text(store) != NULL)
		put_part("\nrelief     ", store_relief_text(store));
	printf("\nheight     %.2f to %.2f m\n", meta->low, meta->high);
	print_holes(meta, "no data    ");
	print_errors(meta, "errors     ", "           ");
	printf("bytes      %lld file, %lld base (%.3f a post of level 0), %lld offset, %lld soil\n",
	       (long long)numbers->file_bytes, (long long)numbers->base_bytes,
	       (double)numbers->base_bytes / ((double)extent->width * (double)extent->height),
	       (long long)numbers->plane_bytes[PLANE_OFFSET], (long long)soil_sum(numbers->plane_bytes));
	if (lost_of(numbers) != 0)
		printf("compacted  %.6g m3\n", volume_of(store, lost_of(numbers)));
	if (numbers->carried != 0)
		printf("carried    %.6g m3, aboard bodies of the last run\n", volume_of(store, numbers->carried));
	if (numbers->in_flight != 0)
		printf("in flight  %.6g m3, of the last run\n", volume_of(store, numbers->in_flight));
	if (numbers->added != 0)
		printf("added      %.6g m3\n", volume_of(store, numbers->added));
	if (numbers->revisions != 0)
		printf("history    %lld revisions, %lld names, %lld rows of %lld bytes\n", (long long)numbers->revisions,
		       (long long)numbers->snapshots, (long long)numbers->history_rows, (long long)numbers->history_bytes);
	printf("base       %016llx", (unsigned long long)store_base_hash(store));
	if (store_base_path(store) != NULL) {
		put_part(" in ", store_base_path(store));
		fputs("; this is an overlay", stdout);
	}
	putchar('\n');
	if (store_depth(store) > 1 || (parent != NULL && revision > 0))
		printf("parent     %s at revision %lld; %d files under this one\n", parent, (long long)revision, store_depth(store));
	fputs("origin     ", stdout);
	print_place(meta->origin[0]);
	fputs(", ", stdout);
	print_place(meta->origin[1]);
	puts(" (south-west post)");
	if (meta->vertical[0] != '\0' || meta->srs[0] != '\0')
		put_line("vertical   ", meta->vertical[0] != '\0' ? meta->vertical : "not said", "");
	print_srs(meta->srs);
	for (const char *line = meta->sources; *line != '\0';) {
		int length = (int)strcspn(line, "\n");
		printf("source     %.*s\n", length, line);
		line += length + (line[length] == '\n');
	}
	print_insets(meta);
	print_store_imagery(meta, imagery);
	if (numbers->last_run.scene_hash != NULL)
		printf("last run   scene %s, step %lld (%.3f s), %lld epochs\n", numbers->last_run.scene_hash,
		       (long long)numbers->last_run.step, numbers->last_run.time, (long long)numbers->commits);
}

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	struct store_numbers numbers;
	struct store_imagery imagery;
	double ruts[4];
	bool any = false;
	enum status status;
	TRY_OR(done, store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store));
	TRY_OR(done, store_count(store, &numbers));
	TRY_OR(done, store_imagery_info(store, &imagery));
	TRY_OR(done, ruts_window(store, ruts, &any));
	if (arguments_flag(arguments, "json"))
		TRY_OR(done, print_json(store, &numbers, &imagery, any ? ruts : NULL));
	else
		print_text(store, &numbers, &imagery, any ? ruts : NULL);
done:
	store_close(store);
	return status;
}

const struct command command_info = {
	.name = "info",
	.summary = "what a store holds",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "Tells tiles, posts, levels, reference systems, heights, sizes and sources; of an overlay also its parent.\n"
		   "compacted is soil that is lost for good. carried is aboard bodies, and in_flight flies, where the last drive ended. added was brought by furrow edit or "
		   "furrow_pour. With --json all are in 2^-20 m, summed over posts.\n",
	.see = "furrow-verify(1), store(5)",
	.run = run,
};
