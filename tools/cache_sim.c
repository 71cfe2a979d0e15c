/* furrow cache-sim: how often caches of other policies and sizes would have missed in a traced drive. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/aside.h"
#include "cache_curves.h"
#include "command.h"
#include "dem/dem.h"
#include "json.h"
#include "python.h"

#define SLOTS_MOST 1000000000 /* no cache has more */
#define SIZES_FEW 6           /* fewer powers of two than this are filled up by their square roots of two */

const char *const cache_policy_labels[SIM_POLICIES] = {"LRU", "CLOCK", "ARC", "S3-FIFO", "OPT"};
static const char *const policy_names[SIM_POLICIES + 1] = {"lru", "clock", "arc", "s3fifo", "opt"};

static const struct command_option options[] = {
	{"policy", "LIST", .help = "what to simulate", .choices = policy_names, .list = true, .preset = "all"},
	{"slots", "LIST", .help = "sizes, as in 16,32,64", .preset = "powers of two from 4 to the number of tiles"},
	{"json", .help = "one JSON object: accesses, tiles, slots, policies {NAME: {misses, miss_ratio}}"},
	{"csv", "FILE", .help = "write the trace as text for other simulators", .files = "csv"},
	{"plot", "FILE.svg", .help = "write the miss curves as an SVG, by the Python package matplotlib", .files = "svg"},
	{.name = NULL},
};

/* --- what is asked --- */

/* The next item of a list parted by commas, or NULL after the last. */
static const char *next_item(const char **at, size_t *length)
{
	const char *item = *at;
	if (item == NULL)
		return NULL;
	*length = strcspn(item, ",");
	*at = item[*length] == ',' ? item + *length + 1 : NULL;
	return item;
}

static enum status read_policies(const struct arguments *arguments, bool wanted[SIM_POLICIES])
{
	const char *at = arguments_text(arguments, "policy"), *item;
	size_t length;
	for (int i = 0; i < SIM_POLICIES; i++)
		wanted[i] = at == NULL;
	while ((item = next_item(&at, &length)) != NULL) {
		int found = -1;
		for (int i = 0; i < SIM_POLICIES; i++)
			if (strlen(policy_names[i]) == length && strncmp(policy_names[i], item, length) == 0)
				found = i;
		if (found < 0)
			return fail_with(STATUS_USAGE, "cache-sim: --policy %.*s: is no policy it knows; give some of "
						       "lru,clock,arc,s3fifo,opt",
					 (int)length, item);
		wanted[found] = true;
	}
	return STATUS_OK;
}

/* Sorted, each once. */
static void add_size(struct cache_curves *curves, uint32_t slots)
{
	size_t at = curves->count;
	while (at > 0 && curves->slots[at - 1] >= slots)
		at--;
	if (at < curves->count && curves->slots[at] == slots)
		return;
	memmove(&curves->slots[at + 1], &curves->slots[at], (curves->count - at) * sizeof *curves->slots);
	curves->slots[at] = slots;
	curves->count++;
}

static enum status read_sizes(const struct arguments *arguments, struct cache_curves *curves)
{
	const char *at = arguments_text(arguments, "slots"), *item;
	size_t length;
	while ((item = next_item(&at, &length)) != NULL) {
		char *end;
		long long slots = strtoll(item, &end, 10);
		if (end != item + length || length == 0 || slots < 1 || slots > SLOTS_MOST)
			return fail_with(STATUS_USAGE, "cache-sim: --slots %.*s: is no number of slots; give whole numbers "
						       "from 1 to %d, as in 16,32,64",
					 (int)length, item, SLOTS_MOST);
		if (curves->count == CACHE_SIZES_MAX)
			return fail_with(STATUS_USAGE, "cache-sim: --slots: are too many sizes; give at most %d",
					 CACHE_SIZES_MAX);
		add_size(curves, (uint32_t)slots);
	}
	return STATUS_OK;
}

void cache_sizes(struct cache_curves *curves)
{
	uint32_t tiles = curves->accesses->tile_count;
	bool few = tiles < 4u << (SIZES_FEW - 1);
	for (double slots = 4; slots < tiles; slots *= few ? sqrt(2) : 2)
		add_size(curves, (uint32_t)lround(slots));
	add_size(curves, tiles > 0 ? tiles : 1);
}

/* An output that would take the trace's place, or another output's. */
static enum status check_outputs(const char *trace, const char *const outputs[2])
{
	struct stat in, out;
	for (int i = 0; i < 2; i++)
		if (outputs[i] != NULL && stat(trace, &in) == 0 && stat(outputs[i], &out) == 0 &&
		    in.st_dev == out.st_dev && in.st_ino == out.st_ino)
			return fail_with(STATUS_USAGE, "cache-sim: %s: is the trace itself; give another file", outputs[i]);
	if (outputs[1] != NULL && !dem_path_ends(outputs[1], ".svg"))
		return fail_with(STATUS_USAGE, "cache-sim: %s: a plot is an SVG; name a file ending in .svg", outputs[1]);
	if (outputs[0] != NULL && outputs[1] != NULL && strcmp(outputs[0], outputs[1]) == 0)
		return fail_with(STATUS_USAGE, "cache-sim: %s: cannot be both table and plot; give two files", outputs[0]);
	return STATUS_OK;
}

/* --- what comes out --- */

static enum status simulate(struct cache_curves *curves)
{
	for (int policy = 0; policy < SIM_POLICIES; policy++) {
		if (!curves->wanted[policy])
			continue;
		struct progress progress;
		progress_start(&progress, curves->title, "accesses");
		enum status status = sim_misses(curves->accesses, (enum sim_policy)policy, curves->slots, curves->count, progress_step, &progress,
						curves->misses[policy]);
		progress_end(&progress);
		TRY(status);
	}
	return STATUS_OK;
}

static double ratio(uint64_t part, uint64_t whole)
{
	return whole > 0 ? (double)part / (double)whole : (double)NAN;
}

static void print_table(const struct cache_curves *curves)
{
	const struct sim_accesses *accesses = curves->accesses;
	const uint64_t *hits = accesses->hits, *misses = accesses->misses;
	bool both = curves->wanted[SIM_LRU] && curves->wanted[SIM_OPT];
	printf("%s: %zu accesses to %u tiles (so many misses at least)\n", curves->title, accesses->count,
	       accesses->tile_count);
	printf("traced: %llu pinned (%llu missed), %llu drawn (%llu missed)\n\n%10s",
	       (unsigned long long)(hits[PAGE_ACCESS_PIN] + misses[PAGE_ACCESS_PIN]),
	       (unsigned long long)misses[PAGE_ACCESS_PIN],
	       (unsigned long long)(hits[PAGE_ACCESS_DRAW] + misses[PAGE_ACCESS_DRAW]),
	       (unsigned long long)misses[PAGE_ACCESS_DRAW], "slots");
	for (int policy = 0; policy < SIM_POLICIES; policy++)
		if (curves->wanted[policy])
			printf("%22s", cache_policy_labels[policy]);
	printf("%s\n", both ? "   LRU/OPT" : "");
	for (size_t i = 0; i < curves->count; i++) {
		printf("%10u", curves->slots[i]);
		for (int policy = 0; policy < SIM_POLICIES; policy++)
			if (curves->wanted[policy])
				printf("%12llu %8.4f%%", (unsigned long long)curves->misses[policy][i],
				       100 * ratio(curves->misses[policy][i], accesses->count));
		if (both)
			printf("%10.3f", ratio(curves->misses[SIM_LRU][i], curves->misses[SIM_OPT][i]));
		putchar('\n');
	}
}

static void add_kind(cJSON *object, const char *name, const struct sim_accesses *accesses, enum page_access kind)
{
	cJSON *traced = cJSON_AddObjectToObject(object, name);
	json_integer(traced, "hits", (int64_t)accesses->hits[kind]);
	json_integer(traced, "misses", (int64_t)accesses->misses[kind]);
}

static void add_number(cJSON *array, double value)
{
	cJSON_AddItemToArray(array, isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull());
}

static cJSON *told_curves(const struct cache_curves *curves)
{
	const struct sim_accesses *accesses = curves->accesses;
	cJSON *object = cJSON_CreateObject();
	json_integer(object, "accesses", (int64_t)accesses->count);
	json_integer(object, "tiles", accesses->tile_count);
	cJSON *traced = cJSON_AddObjectToObject(object, "traced");
	add_kind(traced, "pin", accesses, PAGE_ACCESS_PIN);
	add_kind(traced, "draw", accesses, PAGE_ACCESS_DRAW);
	cJSON *slots = cJSON_AddArrayToObject(object, "slots");
	for (size_t i = 0; i < curves->count; i++)
		add_number(slots, curves->slots[i]);
	cJSON *policies = cJSON_AddObjectToObject(object, "policies");
	for (int policy = 0; policy < SIM_POLICIES; policy++) {
		if (!curves->wanted[policy])
			continue;
		cJSON *one = cJSON_AddObjectToObject(policies, policy_names[policy]);
		cJSON *misses = cJSON_AddArrayToObject(one, "misses");
		cJSON *ratios = cJSON_AddArrayToObject(one, "miss_ratio");
		for (size_t i = 0; i < curves->count; i++) {
			add_number(misses, (double)curves->misses[policy][i]);
			add_number(ratios, ratio(curves->misses[policy][i], accesses->count));
		}
	}
	return object;
}

/* Python draws: python/furrow/plot.py. */
static enum status draw_curves(const struct cache_curves *curves, FILE *file)
{
	cJSON *plan = told_curves(curves);
	bool missing;
	cJSON_AddStringToObject(plan, "title", curves->title);
	const enum status status = python_draw("cache", plan, file, &missing);
	cJSON_Delete(plan);
	return status;
}

static enum status write_csv(const struct sim_accesses *accesses, FILE *file)
{
	fputs("time,obj_id,obj_size\n", file);
	for (size_t i = 0; i < accesses->count && !ferror(file); i++) {
		fprintf(file, "%llu,%llu,1\n", (unsigned long long)accesses->steps[i],
			(unsigned long long)accesses->keys[accesses->tiles[i]]);
		if (interrupted)
			return fail_with(STATUS_INTERRUPTED, "cache-sim: interrupted; run it again to start over");
	}
	return STATUS_OK;
}

static enum status write_output(const struct cache_curves *curves, bool csv, const char *path, struct aside *aside)
{
	if (path == NULL)
		return STATUS_OK;
	TRY(aside_begin(aside, path));
	if (csv)
		TRY(write_csv(curves->accesses, aside->file));
	else
		TRY(draw_curves(curves, aside->file));
	return aside_whole(aside, true);
}

static enum status write_outputs(const struct cache_curves *curves, const char *const outputs[2])
{
	struct aside asides[2] = {{.path = NULL}, {.path = NULL}};
	enum status status;
	TRY_OR(done, write_output(curves, true, outputs[0], &asides[0]));
	TRY_OR(done, write_output(curves, false, outputs[1], &asides[1]));
	for (int i = 0; i < 2; i++)
		if (outputs[i] != NULL)
			TRY_OR(done, aside_publish(&asides[i]));
done:
	aside_finish(&asides[0]);
	aside_finish(&asides[1]);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct sim_accesses accesses = {.count = 0};
	struct cache_curves curves = {.title = arguments_at(arguments, 0), .accesses = &accesses};
	const char *const outputs[2] = {arguments_text(arguments, "csv"), arguments_text(arguments, "plot")};
	TRY(read_policies(arguments, curves.wanted));
	TRY(read_sizes(arguments, &curves));
	TRY(check_outputs(curves.title, outputs));
	enum status status;
	TRY_OR(done, sim_accesses_read(curves.title, &accesses));
	interrupt_catch();
	if (curves.count == 0)
		cache_sizes(&curves);
	TRY_OR(done, simulate(&curves));
	TRY_OR(done, write_outputs(&curves, outputs));
	if (curves.wanted[SIM_S3FIFO] && curves.slots[0] < SIM_S3FIFO_SLOTS_MIN)
		note("S3-FIFO keeps nothing with fewer than %d slots: a tenth of them, its small queue, must be two",
		     SIM_S3FIFO_SLOTS_MIN);
	if (arguments_flag(arguments, "json"))
		TRY_OR(done, json_print(told_curves(&curves)));
	else
		print_table(&curves);
done:
	sim_accesses_finish(&accesses);
	return status;
}

const struct command command_cache_sim = {
	.name = "cache-sim",
	.summary = "replay a drive's trace: how often would other caches have missed",
	.arguments = COMMAND_ARGUMENTS({"TRACE", .help = "what furrow drive --trace left", .files = "*", .needed = true}),
	.options = options,
	.details = "Each simulated cache starts empty, pins nothing and fetches nothing ahead of time, so its misses are not quite "
		   "those that run.json counts. OPT knows the future: no cache that fetches on demand misses less. The rules are "
		   "libCacheSim's (of 2024 to 2026), every object of size 1.\n\n"
		   "--csv: a line an access, of step, tile key and size 1, under a header line. libCacheSim reads it with\n\n"
		   "  columns=time-col=1,obj-id-col=2,obj-size-col=3,obj-id-is-num=true\n"
		   "  cachesim FILE csv lru,clock,arc,s3fifo 16,32,64 --ignore-obj-size 1 \\\n"
		   "      -t \"$columns,has-header=true,delimiter=,\"\n\n"
		   "and its belady from the same lines once its traceConv made them an oracleGeneral trace.\n\n"
		   "A trace is binary: 8 bytes \"furrowPT\", uint32 version (1), then records. Each begins with a number in "
		   "LEB128; whole numbers are little-endian.\n\n"
		   "  tile << 3 | hit << 2 | drawn << 1\n"
		   "      an access: tiles are numbered from 0 as they first come, and the\n"
		   "      first of each is followed by its key (uint64). drawn: looked at\n"
		   "      for a picture; else pinned to be deformed, or looked up\n"
		   "  steps << 1 | 1\n"
		   "      the accesses that follow are so many steps later\n"
		   "  1\n"
		   "      the end: accesses, tiles and the XXH3 of all before (uint64 each)\n\n"
		   "That is one to three bytes an access, since a drive names few tiles over and over.\n",
	.examples = "furrow cache-sim trace --slots 16,32,64 --plot misses.svg\n",
	.see = "furrow-drive(1)",
	.run = run,
};
