/* furrow log: the revisions that a store keeps, those of the files under it, and its branches. */
#include <dirent.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "command.h"
#include "json.h"
#include "pins.h"
#include "screen.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"json", .help = "one JSON object"},
	{.name = NULL},
};

static void print_time(int64_t made, const char *format, char *text, size_t room)
{
	struct tm parts;
	time_t seconds = (time_t)made;
	if (made == 0 || gmtime_r(&seconds, &parts) == NULL || strftime(text, room, format, &parts) == 0)
		snprintf(text, room, "-");
}

/* --- revisions --- */

struct listing {
	char file[PATH_MAX]; /* of the last revision */
	int64_t count;
	cJSON *revisions;
};

static enum status print_revision(void *user, const struct store_revision *revision)
{
	struct listing *listing = user;
	char made[32];
	if (strcmp(listing->file, revision->file) != 0) {
		fputs(listing->count > 0 ? "over " : "", stdout);
		screen_put(revision->file);
		putchar('\n');
	}
	snprintf(listing->file, sizeof listing->file, "%s", revision->file);
	listing->count++;
	print_time(revision->made, "%Y-%m-%d %H:%M:%S", made, sizeof made);
	printf("%c %6lld  %-19s  ", revision->present ? '*' : ' ', (long long)revision->revision, made);
	screen_put(revision->who[0] != '\0' ? revision->who : "-");
	printf("%*s", strlen(revision->who) < 8 ? 10 - (int)(revision->who[0] != '\0' ? strlen(revision->who) : 1) : 2, "");
	if (revision->scene_hash[0] != '\0')
		printf("step %lld (%.3f s)  ", (long long)revision->step, revision->time);
	screen_put(revision->what[0] != '\0' ? revision->what : revision->revision == 0 ? "as imported" : "-");
	if (revision->names[0] != '\0') {
		fputs("  [", stdout);
		screen_put(revision->names);
		putchar(']');
	}
	putchar('\n');
	return STATUS_OK;
}

static cJSON *names_json(const char *names)
{
	cJSON *array = cJSON_CreateArray();
	while (*names != '\0') {
		char name[80];
		size_t length = strcspn(names, ",");
		snprintf(name, sizeof name, "%.*s", (int)length, names);
		cJSON_AddItemToArray(array, cJSON_CreateString(name));
		names += length + (names[length] == ',');
	}
	return array;
}

static enum status add_revision(void *user, const struct store_revision *revision)
{
	struct listing *listing = user;
	char made[32];
	cJSON *object = cJSON_CreateObject();
	json_integer(object, "revision", revision->revision);
	cJSON_AddStringToObject(object, "file", revision->file);
	cJSON_AddBoolToObject(object, "present", revision->present);
	print_time(revision->made, "%Y-%m-%dT%H:%M:%SZ", made, sizeof made);
	json_string(object, "when", revision->made != 0 ? made : NULL);
	cJSON_AddStringToObject(object, "who", revision->who);
	cJSON_AddStringToObject(object, "what", revision->what);
	cJSON_AddStringToObject(object, "scene_hash", revision->scene_hash);
	json_integer(object, "step", revision->step);
	json_number(object, "time", revision->time);
	cJSON_AddItemToObject(object, "names", names_json(revision->names));
	cJSON_AddItemToArray(listing->revisions, object);
	return STATUS_OK;
}

/* --- branches: overlays in the store's folder that name it as their parent --- */

typedef void (*branch_fn)(void *user, const char *path, int64_t revision);

/* A store begins with SQLite's header: other files are not opened. */
static bool may_be_a_store(const char *path)
{
	char head[16] = "";
	struct stat file;
	if (stat(path, &file) != 0 || !S_ISREG(file.st_mode))
		return false;
	FILE *in = input_open(path);
	bool read = in != NULL && fread(head, 1, sizeof head, in) == sizeof head;
	if (in != NULL)
		fclose(in);
	return read && memcmp(head, "SQLite format 3", sizeof head) == 0;
}

static void look_at(const char *path, const char *parent, branch_fn fn, void *user)
{
	struct store *store;
	int64_t revision;
	if (!may_be_a_store(path) || store_open(path, &(struct store_options){.mode = STORE_READ}, &store) != STATUS_OK)
		return;
	const char *found = store_parent(store, &revision);
	if (found != NULL && strcmp(found, parent) == 0)
		fn(user, path, revision);
	store_close(store);
}

static int by_name(const void *a, const void *b)
{
	return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Calls `fn` for each branch in the folder of the store, by name. What cannot be read is no branch. */
static enum status list_folder(const char *folder, char ***names, size_t *count)
{
	enum status status = STATUS_OK;
	DIR *directory = opendir(folder);
	if (directory == NULL)
		return STATUS_OK;
	for (struct dirent *entry; (entry = readdir(directory)) != NULL; ++*count) {
		TRY_OR(done, mem_resize(names, *count + 1, sizeof **names, "the branches"));
		(*names)[*count] = mem_strdup(entry->d_name);
		TRY_OR(done, (*names)[*count] != NULL ? STATUS_OK : fail_memory("the branches"));
	}
done:
	closedir(directory);
	return status;
}

static enum status each_branch(const char *store, branch_fn fn, void *user)
{
	char real[PATH_MAX], folder[PATH_MAX], path[2 * PATH_MAX];
	char **names = NULL;
	size_t count = 0;
	if (realpath(store, real) == NULL)
		return STATUS_OK;
	snprintf(folder, sizeof folder, "%s", real);
	const char *in = dirname(folder);
	enum status status;
	TRY_OR(done, list_folder(in, &names, &count));
	if (count > 0)
		qsort(names, count, sizeof *names, by_name);
	for (size_t i = 0; i < count; i++) {
		snprintf(path, sizeof path, "%s/%s", in, names[i]);
		if (strcmp(path, real) != 0)
			look_at(path, real, fn, user);
	}
done:
	mem_free_list(names, count);
	return status;
}

static void print_branch(void *user, const char *path, int64_t revision)
{
	printf("branch %s of revision %lld\n", path, (long long)revision);
}

static void add_branch(void *user, const char *path, int64_t revision)
{
	cJSON *branch = cJSON_CreateObject();
	cJSON_AddStringToObject(branch, "file", path);
	json_integer(branch, "revision", revision);
	cJSON_AddItemToArray(user, branch);
}

/* --- pins: overlays that the store keeps its ground for, wherever they are --- */

static enum status print_pin(void *user, const struct store_pin *pin)
{
	char of[64];
	const char *path = user;
	pin_of(pin, of, sizeof of);
	if (pin->state == STORE_PIN_FOUND)
		printf("not listed: %s depends on %s; furrow prune %s lists it\n", pin->path, of, path);
	else if (pin->state == STORE_PIN_MOVED)
		printf("pinned %s for %s, which is at %s\n", of, pin->path, pin->found);
	else
		printf("pinned %s for %s%s\n", of, pin->path != NULL ? pin->path : "an overlay that is not known",
		       pin->state == STORE_PIN_GONE ? ", which is gone; furrow prune drops that" : "");
	return STATUS_OK;
}

static enum status add_pin(void *user, const struct store_pin *pin)
{
	cJSON_AddItemToArray(user, pin_json(pin));
	return STATUS_OK;
}

static enum status print_text(struct store *store, const char *path)
{
	struct listing listing = {.file = ""};
	TRY(store_log(store, print_revision, &listing));
	if (listing.count == 0)
		printf("%s\n* never driven\n", path);
	TRY(each_branch(path, print_branch, NULL));
	return store_each_pin(store, print_pin, (void *)(uintptr_t)path);
}

static enum status print_json(struct store *store, const char *path)
{
	struct listing listing = {.file = ""};
	cJSON *object = cJSON_CreateObject();
	listing.revisions = cJSON_AddArrayToObject(object, "revisions");
	enum status status;
	TRY_OR(failed, store_log(store, add_revision, &listing));
	TRY_OR(failed, each_branch(path, add_branch, cJSON_AddArrayToObject(object, "branches")));
	TRY_OR(failed, store_each_pin(store, add_pin, cJSON_AddArrayToObject(object, "pins")));
	return json_print(object);
failed:
	cJSON_Delete(object);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	struct store *store = NULL;
	enum status status;
	TRY_OR(done, store_open(arguments_at(arguments, 0), &(struct store_options){.mode = STORE_READ}, &store));
	if (arguments_flag(arguments, "json"))
		TRY_OR(done, print_json(store, arguments_at(arguments, 0)));
	else
		TRY_OR(done, print_text(store, arguments_at(arguments, 0)));
done:
	store_close(store);
	return status;
}

const struct command command_log = {
	.name = "log",
	.summary = "the revisions that a store keeps: who, when, which scene and step",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "The newest first; * is what the store holds. [NAME] is a snapshot. Of an overlay the revisions of the files "
		   "under it follow. Branches are the overlays in the store's folder that begin at it. Pins are the overlays, wherever they are, "
		   "for which the store keeps what they depend on. Times are UTC.\n",
	.see = "furrow-branch(1), furrow-prune(1), furrow-restore(1)",
	.run = run,
};
