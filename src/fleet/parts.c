/*
 * The files of a run by many: its overlay O, and beside it the folder O.parts with an overlay over O for each rank. What all parts have is
 * gathered into O in one transaction; then they are removed. While the folder is there, O is as before the run.
 */
#include "fleet/internal.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/limits.h"

#define PATH_MOST 4096
#define PREFIX "part-"
#define SUFFIX ".furrow"
#define RESUMED "resumed" /* a file of the folder: the run went on from O's record, and its sums go on from there */

/* --- paths --- */

static char *joined_path(const char *a, const char *b)
{
	const size_t size = strlen(a) + strlen(b) + 1;
	char *text = mem_alloc(size, 1);
	if (text != NULL)
		snprintf(text, size, "%s%s", a, b);
	return text;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
	return strcmp((*a)->d_name, (*b)->d_name);
}

static bool begins_as_part(const struct dirent *entry)
{
	return strncmp(entry->d_name, PREFIX, strlen(PREFIX)) == 0;
}

static int is_part(const struct dirent *entry)
{
	const size_t length = strlen(entry->d_name), suffix = strlen(SUFFIX);
	return begins_as_part(entry) && length > suffix && strcmp(entry->d_name + length - suffix, SUFFIX) == 0;
}

struct part_list {
	char **paths;
	size_t count;
};

static void finish_list(struct part_list *list)
{
	mem_free_list(list->paths, list->count);
}

/* Lists the parts in a folder, by name. */
static enum status list_parts(const char *folder, struct part_list *list)
{
	struct dirent **entries = NULL;
	const int count = scandir(folder, &entries, is_part, by_name);
	if (count < 0)
		return fail_with(STATUS_FAILED, "%s: %s; remove it, if it is no folder of a drive, or make it readable", folder, strerror(errno));
	enum status status;
	list->paths = mem_calloc((size_t)count + 1, sizeof *list->paths);
	TRY_OR(done, list->paths != NULL ? STATUS_OK : fail_memory("parts"));
	for (int i = 0; i < count; i++) {
		char path[PATH_MOST];
		snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
		list->paths[i] = mem_strdup(path);
		TRY_OR(done, list->paths[i] != NULL ? STATUS_OK : fail_memory("parts"));
		list->count++;
	}
done:
	for (int i = 0; i < count; i++)
		free(entries[i]);
	free(entries);
	return status;
}

static void remove_store(const char *path)
{
	static const char *const ends[] = {"", "-wal", "-shm"};
	char file[PATH_MOST];
	for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
		snprintf(file, sizeof file, "%s%s", path, ends[i]);
		unlink(file);
	}
}

/* --- the record of all --- */

/* Sums of a drive, as the record has them: struct pages_sums. below and above: from what the gathering changed. */
static const char *const sums[] = {"below", "above", "compacted", "sunk", "slid", "added", "carried", "in_flight"};
enum {
	SUMS = 8,
	SUMMED = 2, /* the first that ranks have a share of each */
	ADDED = 5,  /* from here on a record without it means 0 */
	WHOLE = 6,  /* from here on each rank's record has the whole */
};

struct gathering {
	int64_t before[SUMS];
	int64_t all[SUMS];
	char *text;
	bool damaged;
};

static bool read_sums(const char *state, int64_t values[SUMS], cJSON **out)
{
	cJSON *root = state != NULL ? cJSON_Parse(state) : NULL;
	bool whole = root != NULL;
	for (int i = 0; i < SUMS && whole; i++) {
		const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(root, sums[i]));
		char *end = NULL;
		errno = 0;
		values[i] = text != NULL ? strtoll(text, &end, 10) : 0;
		whole = text != NULL ? end != text && *end == '\0' && errno == 0 : i >= ADDED && !cJSON_HasObjectItem(root, sums[i]);
	}
	if (out != NULL && whole)
		*out = root;
	else
		cJSON_Delete(root);
	return whole;
}

static const char *describe(void *user, const struct store_run *runs, size_t count, const struct store_commit_result *result)
{
	struct gathering *gathering = user;
	cJSON *root = NULL;
	memcpy(gathering->all, gathering->before, sizeof gathering->all);
	gathering->all[0] += result->below;
	gathering->all[1] += result->above;
	for (size_t i = 0; i < count; i++) {
		int64_t values[SUMS];
		if (!read_sums(runs[i].state, values, i == 0 ? &root : NULL)) {
			gathering->damaged = true;
			cJSON_Delete(root);
			return NULL;
		}
		for (int k = SUMMED; k < WHOLE; k++)
			gathering->all[k] += values[k] - gathering->before[k];
		for (int k = WHOLE; k < SUMS; k++)
			gathering->all[k] = values[k];
	}
	for (int k = 0; k < SUMS && root != NULL; k++) {
		char text[32];
		if (k >= ADDED && !cJSON_HasObjectItem(root, sums[k]))
			continue; /* ranks add no soil, and each has the whole of what comes after that */
		snprintf(text, sizeof text, "%lld", (long long)gathering->all[k]);
		cJSON *value = cJSON_CreateString(text);
		if (value == NULL || !cJSON_ReplaceItemInObjectCaseSensitive(root, sums[k], value)) {
			cJSON_Delete(value);
			cJSON_Delete(root);
			return NULL;
		}
	}
	gathering->text = root != NULL ? cJSON_PrintUnformatted(root) : NULL;
	cJSON_Delete(root);
	return gathering->text;
}

/* The sums that the run began with. */
static enum status read_before(const char *over, const char *folder, struct gathering *gathering)
{
	char path[PATH_MOST];
	struct store *store;
	struct store_run run;
	snprintf(path, sizeof path, "%s/" RESUMED, folder);
	if (access(path, F_OK) != 0)
		return STATUS_OK;
	TRY(store_open(over, &(struct store_options){.mode = STORE_READ}, &store));
	enum status status;
	TRY_OR(done, store_last_run(store, &run));
	if (run.scene_hash != NULL && !read_sums(run.state, gathering->before, NULL))
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: what its last drive left to go on from is damaged; drive without --resume, or furrow "
						     "reset %s", over, shell_path(over).text));
done:
	store_close(store);
	return status;
}

/* Gathers the parts in a folder. *any: there was a commit. */
static enum status gather_folder(const char *over, const char *folder, struct gathering *gathering, bool *any)
{
	struct part_list list = {NULL, 0};
	struct store_commit_result result = {0};
	const struct store_gathering calls = {.user = gathering, .describe = describe};
	*any = false;
	enum status status;
	TRY_OR(done, list_parts(folder, &list));
	if (list.count > 0) {
		TRY_OR(done, read_before(over, folder, gathering));
		TRY_OR(done, store_gather(over, (const char *const *)list.paths, list.count, &calls, &result));
	}
	*any = result.commit > 0;
done:
	if (status != STATUS_OK && gathering->damaged)
		status = fail_with(STATUS_INPUT, "%s: the record of a part is damaged; remove the folder, and drive anew", folder);
	cJSON_free(gathering->text);
	gathering->text = NULL;
	finish_list(&list);
	return status;
}

/* Removes the parts, and files that a killed process left beside them. */
static void remove_folder(const char *folder)
{
	char path[PATH_MOST];
	DIR *directory = opendir(folder);
	const struct dirent *entry;
	while (directory != NULL && (entry = readdir(directory)) != NULL) {
		if (!begins_as_part(entry))
			continue;
		snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
		unlink(path);
	}
	if (directory != NULL)
		closedir(directory);
	snprintf(path, sizeof path, "%s/" RESUMED, folder);
	unlink(path);
	rmdir(folder);
}

/* A part is damaged, or is none: what to do about a store is not what to do about a part. Returns STATUS_INPUT. */
static enum status advise_to_give_up(const char *folder)
{
	struct failure failure;
	failure_capture(&failure, STATUS_INPUT);
	char *advice = strstr(failure.message, "; ");
	if (advice != NULL)
		*advice = '\0';
	return fail_with(STATUS_INPUT, "%s; put the part back, or remove %s, which gives up what that drive did", failure.message, folder);
}

/* Gathers what an earlier run left. */
static enum status gather_left(const char *over, const char *folder, bool resume)
{
	struct gathering gathering = {.damaged = false};
	bool any;
	if (access(folder, F_OK) != 0)
		return STATUS_OK;
	if (!resume)
		return fail_with(STATUS_INPUT, "%s: a drive by several processes was cut off, and left this; add --resume to go on, or remove "
					       "the folder to give up what it did", folder);
	enum status status = gather_folder(over, folder, &gathering, &any);
	if (status == STATUS_INPUT && strncmp(failure_message(), folder, strlen(folder)) == 0)
		return advise_to_give_up(folder);
	TRY(status);
	if (any)
		note("%s: gathered what an earlier drive by several processes had committed", over);
	remove_folder(folder);
	return STATUS_OK;
}

enum status fleet_gather_left(const char *overlay, bool resume)
{
	if (overlay == NULL)
		return STATUS_OK;
	char *folder = joined_path(overlay, ".parts");
	TRY_MEM(folder, "a path");
	enum status status = gather_left(overlay, folder, resume);
	mem_free(folder);
	return status;
}

/* --- the files of this run --- */

/* On rank 0. */
static enum status make_files(struct fleet *fleet)
{
	const struct fleet_params *params = &fleet->params;
	const char *base = params->store != NULL ? params->store : params->scene->store;
	const struct store_options options = {.mode = STORE_WRITE, .durable_full = params->durable_full, .scene = params->scene->file};
	struct store *store;
	if (base == NULL)
		return fail_with(STATUS_INPUT, "%s: names no store; add store:, or give --store", params->scene->file);
	TRY(gather_left(fleet->over, fleet->parts, params->resume));
	const bool makes = access(fleet->over, F_OK) != 0;
	TRY(store_open_overlay(fleet->over, base, &options, &store));
	fleet->made = makes;
	store_close(store);
	fleet->founded = mkdir(fleet->parts, 0777) == 0;
	if (!fleet->founded && errno == EEXIST)
		return fail_with(STATUS_FAILED, "%s: the folder has files that are not of a drive; remove it", fleet->parts);
	if (!fleet->founded)
		return fail_with(STATUS_FAILED, "%s: %s; %s", fleet->parts, strerror(errno),
				 limits_advice(errno, "give an --overlay in a folder that can be written"));
	return STATUS_OK;
}

static enum status name_files(struct fleet *fleet)
{
	static const char head[1024];
	char name[64];
	snprintf(name, sizeof name, "/" PREFIX "%05d" SUFFIX, fleet->rank);
	fleet->over = mem_strdup(fleet->params.overlay);
	fleet->parts = joined_path(fleet->params.overlay, ".parts");
	fleet->part = fleet->parts != NULL ? joined_path(fleet->parts, name) : NULL;
	TRY_MEM(fleet->over != NULL && fleet->part != NULL, "ranks");
	return fleet_put(&fleet->sent, head, sizeof head); /* a head always has room */
}

/* On rank 0: makes the files of the run, and its number. */
static enum status begin_run(struct fleet *fleet, uint64_t *run)
{
	if (fleet->rank != 0)
		return STATUS_OK;
	TRY(make_files(fleet));
	return store_part_run(run);
}

/* Compares what names the run's files on each rank, before anything is made. All ranks return the same. */
static enum status same_files(const struct fleet *fleet)
{
	const struct fleet_params *params = &fleet->params;
	char mine[3 * PATH_MOST];
	const char *base = params->store != NULL ? params->store : params->scene->store;
	snprintf(mine, sizeof mine, "%s\n%s\n%s", params->overlay, base != NULL ? base : "", params->resume ? "resumes" : "begins");
	const void *const *all;
	const size_t *sizes;
	fleet_comm_exchange(mine, strlen(mine) + 1, &all, &sizes);
	for (int i = 1; i < fleet->ranks; i++)
		if (sizes[i] != sizes[0] || memcmp(all[i], all[0], sizes[0]) != 0)
			return fail_with(STATUS_INPUT, "rank %d: its --store, --overlay or --resume is not that of rank 0; give all ranks the same", i);
	return STATUS_OK;
}

enum status fleet_open(const struct fleet_params *params, struct fleet **out)
{
	uint64_t run = 0;
	struct fleet *fleet = mem_calloc(1, sizeof *fleet);
	if (fleet == NULL)
		fleet_comm_give_up("out of memory");
	*out = fleet;
	fleet->params = *params;
	fleet->ranks = fleet_joined(&fleet->rank);
	TRY(fleet_agree(name_files(fleet)));
	TRY(same_files(fleet));
	TRY(fleet_agree(begin_run(fleet, &run)));
	TRY(fleet_stage(params, &fleet->staged));
	const void *const *all;
	const size_t *sizes;
	fleet_comm_exchange(&run, sizeof run, &all, &sizes);
	memcpy(&run, all[0], sizeof run);
	return fleet_agree(store_create_part(fleet->part, fleet->over, &(struct store_part){run, (uint32_t)fleet->rank, (uint32_t)fleet->ranks}));
}

enum status fleet_note_resumed(struct fleet *fleet)
{
	char path[PATH_MOST];
	snprintf(path, sizeof path, "%s/" RESUMED, fleet->parts);
	const int file = output_create(path, O_WRONLY | O_TRUNC);
	if (file < 0 || close(file) != 0)
		return fail_with(STATUS_FAILED, "%s: %s; free some disk space", path, strerror(errno));
	return STATUS_OK;
}

struct summing {
	struct world_ranked *figures;
	int ranks;
};

static enum status add_figures(void *user, int rank, struct fleet_bytes *bytes)
{
	struct summing *summing = user;
	struct world_ranked other;
	TRY(fleet_get(bytes, &other, sizeof other));
	struct world_ranked *all = summing->figures;
	if (rank == 0) {
		all->sums = other.sums;
		all->balance = other.balance;
		all->exchanges = other.exchanges;
	}
	all->tiles_moved += other.tiles_moved;
	all->bodies_moved += other.bodies_moved;
	all->blocks_moved += other.blocks_moved;
	all->bytes_moved += other.bytes_moved;
	all->waiting += other.waiting;
	all->busy += other.busy;
	all->planning += other.planning;
	all->moving += other.moving;
	return STATUS_OK;
}

enum status fleet_gather(void *user, struct world_ranked *figures)
{
	struct fleet *fleet = user;
	struct gathering gathering = {.damaged = false};
	struct world_ranked mine;
	struct fleet_told told;
	bool any = false;
	fleet->ran = true;
	fleet->world = NULL; /* it is freed */
	memset(figures, 0, sizeof *figures);
	fleet_meet(); /* nobody has the ground open any more */
	enum status status = fleet->rank == 0 ? gather_folder(fleet->over, fleet->parts, &gathering, &any) : STATUS_OK;
	memset(&mine, 0, sizeof mine);
	mine.sums = (struct pages_sums){gathering.all[0], gathering.all[1], gathering.all[2], gathering.all[3], gathering.all[4], gathering.all[5], gathering.all[6], gathering.all[7]};
	mine.tiles_moved = fleet->tiles_moved;
	mine.bodies_moved = fleet->bodies_moved;
	mine.blocks_moved = fleet->blocks_moved;
	mine.bytes_moved = fleet->bytes_moved;
	mine.exchanges = fleet->exchanges;
	mine.waiting = fleet->waited;
	mine.busy = fleet->busy;
	mine.planning = fleet->planning;
	mine.moving = fleet->moving;
	mine.balance = fleet->steps > 0 ? fleet->balance / (double)fleet->steps : 1;
	struct summing summing = {figures, fleet->ranks};
	TRY_OR(tell, status);
	TRY_OR(tell, fleet_begin(fleet, FLEET_FIGURES, STATUS_OK));
	TRY_OR(tell, fleet_put(&fleet->sent, &mine, sizeof mine));
tell: /* the others wait for it, also after a failure */
	TRY(fleet_tell(fleet, FLEET_FIGURES, status, &told, add_figures, &summing));
	fleet->gathered = true;
	return STATUS_OK;
}

void fleet_close(struct fleet *fleet)
{
	if (fleet == NULL)
		return;
	fleet_meet(); /* nobody has the files open any more */
	const bool useless = fleet->gathered || !fleet->ran;
	if (fleet->founded && useless)
		remove_folder(fleet->parts);
	if (fleet->made && useless && !fleet->gathered)
		remove_store(fleet->over);
	fleet_groups_finish(&fleet->groups);
	key_set_finish(&fleet->changed);
	fleet_rows_finish(fleet);
	store_staged_finish(&fleet->staged);
	mem_free_all(fleet->mine, fleet->owners, fleet->next, fleet->planned_bodies, fleet->aboard, fleet->grain_links);
	fleet_together_finish(&fleet->together);
	mem_free_all(fleet->sent.bytes, fleet->over, fleet->parts, fleet->part, fleet);
}
