/* The options of an import, by their long names. */
#include "intake/internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum kind { FLAG, WHOLE, NUMBER, TEXT, WORD, RANGE, WINDOW, LIST, SOURCES };

struct option {
	const char *name;
	enum kind kind;
	double low, high;         /* of numbers */
	const char *const *words; /* of a word, ended by NULL */
};

const char *const intake_import_methods[] = {"bilinear", "cubic", "near", "average", "lanczos", NULL};
const char *const intake_import_radii[] = {"auto", "yes", "no", NULL};
const char *const intake_import_packs[] = {"fast", "small", NULL};
const char *const intake_import_encodings[] = {"terrarium", "mapbox", NULL}; /* from DEM_TERRARIUM on */
const char *const intake_import_units[] = {"m", "ft", "us-ft", NULL};
static const struct option options[] = {
	{"tile", WHOLE, TILE_CELLS_MIN, TILE_CELLS_MAX, NULL},
	{"jobs", WHOLE, 1, 256, NULL},
	{"max-error", NUMBER, 0, 1e4, NULL},
	{"spacing", NUMBER, 1e-4, 1e6, NULL},
	{"feather", NUMBER, 0, 1e6, NULL},
	{"inset", SOURCES, 0, 0, NULL},
	{"imagery", SOURCES, 0, 0, NULL},
	{"imagery-quality", WHOLE, 1, 100, NULL},
	{"lossless", FLAG, 0, 0, NULL},
	{"s-srs", TEXT, 0, 0, NULL},
	{"t-srs", TEXT, 0, 0, NULL},
	{"s-vertical", TEXT, 0, 0, NULL},
	{"t-vertical", TEXT, 0, 0, NULL},
	{"s-unit", WORD, 0, 0, intake_import_units},
	{"r", WORD, 0, 0, intake_import_methods},
	{"radii", WORD, 0, 0, intake_import_radii},
	{"band", WHOLE, 1, 1e6, NULL},
	{"encoding", WORD, 0, 0, intake_import_encodings},
	{"pack", WORD, 0, 0, intake_import_packs},
	{"nodata", LIST, 0, 0, NULL},
	{"height-range", RANGE, 0, 0, NULL},
	{"window", WINDOW, 0, 0, NULL},
	{"window-srs", TEXT, 0, 0, NULL},
	{"vrt-folder", TEXT, 0, 0, NULL},
	{"match-heights", FLAG, 0, 0, NULL},
	{"allow-network", FLAG, 0, 0, NULL},
	{"fill", FLAG, 0, 0, NULL},
	{"resume", FLAG, 0, 0, NULL},
	{"overwrite", FLAG, 0, 0, NULL},
	{"force", FLAG, 0, 0, NULL},
};

/* What an import of imagery alone takes, and what only imagery takes. */
static const char *const of_imagery[] = {"imagery", "imagery-quality", "lossless", "vrt-folder", "allow-network", "jobs", "resume", "overwrite", NULL};
static const char *const imagery_only[] = {"imagery-quality", "lossless", NULL};

static enum status refuse(const char *name, const char *text, const char *allowed)
{
	return fail_with(STATUS_USAGE, "import: %s%s %s: not a value it takes; give %s", name[1] == '\0' ? "-" : "--", name, text, allowed);
}

static enum status take_number(const struct option *option, const char *text, double *number)
{
	char *end, allowed[96];
	*number = strtod(text, &end);
	const bool whole = option->kind != WHOLE || (*number == floor(*number) && strpbrk(text, ".eExX") == NULL);
	if (end != text && *end == '\0' && *number >= option->low && *number <= option->high && whole)
		return STATUS_OK;
	snprintf(allowed, sizeof allowed, "a %snumber from %g to %g", option->kind == WHOLE ? "whole " : "", option->low, option->high);
	return refuse(option->name, text, allowed);
}

static enum status take_word(const struct option *option, const char *text, int *word)
{
	char allowed[160] = "one of";
	if (option->words == intake_import_units && (strcmp(text, "feet") == 0 || strcmp(text, "foot") == 0))
		return refuse(option->name, text, "ft (0.3048 m), or us-ft (the US survey foot)");
	for (int i = 0; option->words[i] != NULL; i++) {
		if (strcmp(option->words[i], text) == 0) {
			*word = i;
			return STATUS_OK;
		}
		const size_t used = strlen(allowed);
		snprintf(allowed + used, sizeof allowed - used, " %s", option->words[i]);
	}
	return refuse(option->name, text, allowed);
}

/* Reads `count` finite numbers that are parted by commas. */
static bool take_numbers(const char *text, size_t count, double *numbers)
{
	for (size_t i = 0; i < count; i++) {
		char *end;
		numbers[i] = strtod(text, &end);
		if (end == text || !isfinite(numbers[i]) || *end != (i + 1 < count ? ',' : '\0'))
			return false;
		text = end + 1;
	}
	return true;
}

static enum status take_range(struct import *import, const char *text)
{
	double range[2];
	if (!take_numbers(text, 2, range))
		return refuse("height-range", text, "2 numbers parted by commas");
	import->dem.has_height_range = true;
	import->dem.height_min = range[0];
	import->dem.height_max = range[1];
	return STATUS_OK;
}

static enum status take_window(struct import *import, const char *text)
{
	import->dem.has_window = true;
	return take_numbers(text, 4, import->dem.window) ? STATUS_OK : refuse("window", text, "W,S,E,N: 4 numbers parted by commas");
}

static enum status take_nodata(struct import *import, const char *text)
{
	char *end;
	if (import->dem.nodata_count == sizeof import->nodata / sizeof *import->nodata)
		return fail_with(STATUS_USAGE, "import: --nodata is given too often; %zu values at most",
				 sizeof import->nodata / sizeof *import->nodata);
	const double value = strtod(text, &end);
	if (end == text || *end != '\0' || isnan(value))
		return fail_with(STATUS_USAGE, "import: --nodata %s: not a number; give one as in --nodata -32767", text);
	import->nodata[import->dem.nodata_count++] = value;
	return STATUS_OK;
}

static enum status take_tile(struct import *import, int64_t tile)
{
	import->tile = tile;
	if ((tile & (tile - 1)) == 0)
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "import: --tile %lld: not a power of two; give 8, 16, ... 256 (default), 512 or 1024", (long long)tile);
}

static enum status take_text(const char *text, const char **to, char **kept)
{
	char *copy = mem_alloc(strlen(text) + 1, 1);
	TRY_MEM(copy, "an option");
	strcpy(copy, text);
	mem_free(*kept);
	*to = *kept = copy;
	return STATUS_OK;
}

static enum status take_named_text(struct import *import, const char *name, const char *text)
{
	struct dem_params *dem = &import->dem;
	const struct {
		const char *name, **to;
	} texts[] = {{"s-srs", &dem->s_srs}, {"t-srs", &dem->t_srs}, {"window-srs", &dem->window_srs}, {"s-vertical", &dem->s_vertical},
		     {"t-vertical", &dem->t_vertical}, {"vrt-folder", &dem->vrt_folder}};
	size_t i = 0;
	while (strcmp(texts[i].name, name) != 0)
		i++;
	return take_text(text, texts[i].to, &import->texts[i]);
}

static enum status take_source(const char *text, char ***list, size_t *count)
{
	TRY(mem_resize(list, *count + 1, sizeof **list, "an option"));
	TRY(mem_text(&(*list)[*count], text, "an option"));
	++*count;
	return STATUS_OK;
}

static void allow_network(struct import *import, bool on)
{
	if (on && !import->allow_network)
		dem_network_begin();
	if (!on && import->allow_network)
		dem_network_end();
	import->allow_network = on;
}

static enum status take_flag(struct import *import, const char *name, bool on)
{
	if (strcmp(name, "allow-network") == 0)
		allow_network(import, on);
	else if (strcmp(name, "fill") == 0)
		import->dem.fill = on;
	else if (strcmp(name, "match-heights") == 0)
		import->match_heights = on;
	else if (strcmp(name, "resume") == 0)
		import->resume = on;
	else if (strcmp(name, "lossless") == 0)
		import->lossless = on;
	else if (strcmp(name, "force") == 0)
		import->force = on;
	else
		import->overwrite = on;
	return STATUS_OK;
}

static enum status take(struct import *import, const struct option *option, const char *text)
{
	double number = 0;
	int word = 0;
	switch (option->kind) {
	case FLAG:
		if (strcmp(text, "true") != 0 && strcmp(text, "false") != 0 && text[0] != '\0')
			return refuse(option->name, text, "true or false");
		return take_flag(import, option->name, text[0] != 'f');
	case WHOLE:
		TRY(take_number(option, text, &number));
		if (strcmp(option->name, "tile") == 0)
			return take_tile(import, (int64_t)number);
		if (strcmp(option->name, "imagery-quality") == 0)
			import->quality = (int)number;
		else
			*(strcmp(option->name, "band") == 0 ? &import->dem.band : &import->jobs) = (int64_t)number;
		break;
	case NUMBER:
		TRY(take_number(option, text, &number));
		if (strcmp(option->name, "spacing") == 0)
			import->dem.spacing = number;
		else if (strcmp(option->name, "feather") == 0)
			import->feather = number;
		else
			import->max_error = number;
		break;
	case TEXT:
		return take_named_text(import, option->name, text);
	case WORD:
		TRY(take_word(option, text, &word));
		if (option->words == intake_import_methods)
			import->dem.resample = (enum dem_resample)word;
		else if (option->words == intake_import_radii)
			import->dem.radii = (enum dem_radii)word;
		else if (option->words == intake_import_encodings)
			import->dem.encoding = (enum dem_encoding)(DEM_TERRARIUM + word);
		else if (option->words == intake_import_units)
			import->dem.s_unit = intake_import_units[word];
		else
			import->pack = (enum store_pack)word;
		break;
	case RANGE:
		return take_range(import, text);
	case WINDOW:
		return take_window(import, text);
	case LIST:
		return take_nodata(import, text);
	case SOURCES:
		return strcmp(option->name, "imagery") == 0 ? take_source(text, &import->imagery_sources, &import->imagery_count)
							    : take_source(text, &import->inset_sources, &import->inset_count);
	}
	return STATUS_OK;
}

/* "max_error" is the same as "max-error", for mappings. */
static bool is_name(const char *name, const char *given)
{
	for (; *name != '\0' && (*name == *given || (*name == '-' && *given == '_')); name++, given++)
		;
	return *name == '\0' && *given == '\0';
}

static const struct option *find(const char *name)
{
	for (size_t i = 0; i < sizeof options / sizeof *options; i++)
		if (is_name(options[i].name, name))
			return &options[i];
	return NULL;
}

bool intake_import_has_option(const char *name)
{
	return find(name) != NULL;
}

enum import_list intake_import_list(const char *name)
{
	const struct option *option = find(name);
	if (option != NULL && (option->kind == LIST || option->kind == SOURCES))
		return IMPORT_EACH;
	return option != NULL && (option->kind == RANGE || option->kind == WINDOW) ? IMPORT_JOINED : IMPORT_NO_LIST;
}

enum status intake_import_option(struct import *import, const char *name, const char *value)
{
	const struct option *option = find(name);
	if (option == NULL)
		return fail_with(STATUS_USAGE, "import: %s is not an option; furrow import --help lists them", name);
	TRY(take(import, option, value));
	const uint64_t bit = UINT64_C(1) << (option - options);
	import->given = option->kind == FLAG && value[0] == 'f' ? import->given & ~bit : import->given | bit;
	return STATUS_OK;
}

static bool is_listed(const char *const *names, const char *name)
{
	while (*names != NULL && strcmp(*names, name) != 0)
		names++;
	return *names != NULL;
}

static bool is_given(const struct import *import, size_t index)
{
	_Static_assert(sizeof options / sizeof *options <= 64, "a bit for each option");
	return (import->given >> index & 1) != 0;
}

enum status intake_import_check_options(const struct import *import, bool alone)
{
	bool both = true;
	for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
		const char *name = options[i].name;
		if (is_given(import, i) && alone && !is_listed(of_imagery, name))
			return fail_with(STATUS_USAGE, "import: --%s: imagery that goes into a store has the store's place, and needs no such option; leave it out (what a picture says of "
					 "itself, its SRS or its nodata, gdal_translate changes)", name);
		if (is_given(import, i) && import->imagery_count == 0 && is_listed(imagery_only, name))
			return fail_with(STATUS_USAGE, "import: --%s is of imagery, and none is named; leave it out (heights are stored without loss with --max-error 0)", name);
		both = both && (is_given(import, i) || !is_listed(imagery_only, name));
	}
	return both ? fail_with(STATUS_USAGE, "import: --imagery-quality does not count with --lossless; leave one of both out") : STATUS_OK;
}

void intake_import_init(struct import *import)
{
	*import = (struct import){.tile = 256, .jobs = thread_cores(), .max_error = -1, .feather = -1, .quality = INTAKE_QUALITY};
}

void intake_import_finish(struct import *import)
{
	for (size_t i = 0; i < sizeof import->texts / sizeof *import->texts; i++)
		mem_free(import->texts[i]);
	mem_free_list(import->inset_sources, import->inset_count);
	mem_free_list(import->imagery_sources, import->imagery_count);
	dem_insets_close(import->insets);
	mem_free_all(import->inset_paths, import->inset_from, import->census);
	free(import->lines);
	free(import->inset_lines);
	free(import->description);
	dem_close(import->opened);
	allow_network(import, false);
}
