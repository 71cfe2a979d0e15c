/* The runs of a study: their settings, the names of their folders, and what each runs. */
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drive/drive.h"
#include "base/aside.h"
#include "scene/scene_file.h"
#include "study.h"

#define HASH_DIGITS 12
#define HASH_START 0xcbf29ce484222325u

const char *study_path(const struct study *study, size_t run, const char *file, char *path)
{
	/* study_prepare has refused a folder that is too long */
	snprintf(path, PATH_MAX, "%s/runs/%s%s%s", study->directory, study->runs[run].name, file[0] != '\0' ? "/" : "", file);
	return path;
}

/* The path that a value of the parameter `store` means. */
static enum status store_of(struct study *study, const char *value, const char **store)
{
	struct scene_node *node;
	TRY(scene_tree_parse(study->file, "store", value, strlen(value), &node));
	enum status status = STATUS_OK;
	if (node->kind != SCENE_SCALAR)
		status = fail_with(STATUS_INPUT, "%s: store: %s is no path; allowed: the name of a file", study->file, value);
	else if ((*store = study_keep(study, scene_file_beside(study->folder, node->text))) == NULL)
		status = fail_memory("paths of the study");
	scene_node_destroy(node);
	return status;
}

enum status study_settings(struct study *study, size_t run, struct settings *settings, const char **store)
{
	*store = study->store;
	settings->count = 0;
	for (size_t i = 0; i < study->set_count; i++)
		settings->list[settings->count++] = study->set[i];
	for (size_t i = 0; i < study->parameter_count; i++)
		for (size_t k = 0; k < study->parameters[i].key_count; k++) {
			const char *key = study->parameters[i].keys[k], *value = study_value(study, run, i);
			if (strcmp(key, "store") == 0)
				TRY(store_of(study, value, store));
			else
				settings->list[settings->count++] = (struct scene_setting){key, value};
		}
	return STATUS_OK;
}

enum status study_arguments(struct study *study, size_t run, const char ***out)
{
	struct settings settings = {.count = 0};
	const char *store;
	char folder[PATH_MAX], overlay[PATH_MAX];
	TRY(study_settings(study, run, &settings, &store));
	const char **list = mem_calloc(12 + 2 * settings.count, sizeof *list);
	TRY_MEM(list, "arguments of a run");
	size_t count = 0;
	const char *first[] = {study->program,
			       "drive",
			       study->scene,
			       "-o",
			       study_print(study, "%s", study_path(study, run, "", folder)),
			       "--overlay",
			       study_print(study, "%s", study_path(study, run, "overlay.furrow", overlay)),
			       "--resume"};
	enum status status;
	for (size_t i = 0; i < sizeof first / sizeof *first; i++) {
		list[count++] = first[i];
		TRY_OR(failed, first[i] != NULL ? STATUS_OK : fail_memory("arguments of a run"));
	}
	if (store != NULL) {
		list[count++] = "--store";
		list[count++] = store;
	}
	for (size_t i = 0; i < settings.count; i++) {
		list[count++] = "--set";
		list[count++] = study_print(study, "%s=%s", settings.list[i].key, settings.list[i].value);
		TRY_OR(failed, list[count - 1] != NULL ? STATUS_OK : fail_memory("arguments of a run"));
	}
	*out = list;
	return STATUS_OK;
failed:
	mem_free(list);
	return status;
}

/* --- names --- */

static uint64_t add_text(uint64_t hash, const char *text)
{
	do
		hash = (hash ^ (unsigned char)*text) * 0x100000001b3u; /* FNV-1a; the NUL parts the texts */
	while (*text++ != '\0');
	return hash;
}

/* Checks a run's scene and hashes all that decides its results. `hash`: of the scene's file. `found`: of results. */
static enum status name_run(struct study *study, size_t run, uint64_t hash, enum study_found *found)
{
	struct settings settings = {.count = 0};
	struct scene *scene = NULL;
	const char *store;
	enum status status;
	TRY_OR(done, study_settings(study, run, &settings, &store));
	TRY_OR(done, scene_load(study->scene, settings.list, settings.count, &scene));
	const char *terrain = store != NULL ? store : scene->store;
	if (terrain == NULL)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: no terrain; name it with store", study->file));
	if (access(terrain, R_OK) != 0)
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: %s; give a store that can be read", terrain, strerror(errno)));
	study_seek_results(study, scene, found);
	const struct scene_node *named = scene_node_child(study->root, "store");
	hash = add_text(add_text(hash, scene->hash), named != NULL ? named->text : "");
	for (size_t i = 0; i < study->parameter_count; i++)
		hash = add_text(add_text(hash, study->parameters[i].name), study_value(study, run, i));
	for (size_t i = 0; i < settings.count; i++)
		hash = add_text(add_text(hash, settings.list[i].key), settings.list[i].value);
	snprintf(study->runs[run].name, sizeof study->runs[run].name, "%04zu-%0*llx", run + 1, HASH_DIGITS,
		 (unsigned long long)(hash >> (64 - 4 * HASH_DIGITS)));
done:
	scene_destroy(scene);
	return status;
}

static const char *hash_of(const char *name)
{
	const char *dash = strchr(name, '-');
	return dash != NULL && strlen(dash + 1) == HASH_DIGITS ? dash + 1 : NULL;
}

static int by_hash(const void *a, const void *b)
{
	const struct study_run *const *first = a, *const *second = b;
	return strcmp(hash_of((*first)->name), hash_of((*second)->name));
}

/* A run that has a folder keeps it, also when a changed study file numbers it otherwise. */
/* `sorted`: the runs in the order of their hashes. */
static enum status check_differ(const struct study *study, struct study_run *const *sorted)
{
	for (size_t i = 1; i < study->run_count; i++)
		if (by_hash(&sorted[i - 1], &sorted[i]) == 0) {
			const size_t a = (size_t)(sorted[i - 1] - study->runs), b = (size_t)(sorted[i] - study->runs);
			return fail_with(STATUS_INPUT, "%s: runs %zu and %zu have the same settings; write each once", study->file,
					 (a < b ? a : b) + 1, (a < b ? b : a) + 1);
		}
	return STATUS_OK;
}

static enum status keep_folders(const struct study *study, const char *runs)
{
	struct study_run **sorted = mem_calloc(study->run_count, sizeof *sorted);
	TRY_MEM(sorted, "names of runs");
	for (size_t i = 0; i < study->run_count; i++)
		sorted[i] = &study->runs[i];
	qsort(sorted, study->run_count, sizeof *sorted, by_hash);
	enum status status;
	TRY_OR(done, check_differ(study, sorted));
	DIR *folder = opendir(runs);
	if (folder == NULL)
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: %s; give a folder that can be read", runs, strerror(errno)));
	for (struct dirent *entry; (entry = readdir(folder)) != NULL;) {
		struct study_run key, *wanted = &key;
		if (hash_of(entry->d_name) == NULL || strlen(entry->d_name) >= sizeof key.name)
			continue;
		snprintf(key.name, sizeof key.name, "%.39s", entry->d_name);
		struct study_run **found = bsearch(&wanted, sorted, study->run_count, sizeof *sorted, by_hash);
		if (found != NULL)
			memcpy((*found)->name, key.name, sizeof key.name);
	}
	closedir(folder);
done:
	mem_free(sorted);
	return status;
}

static enum status name_runs(struct study *study, const char *runs, bool collects)
{
	struct study_refused refused = {.count = 0};
	enum study_found found[STUDY_RESULTS] = {STUDY_NOTHING};
	char *text;
	size_t length;
	TRY(scene_file_read(study->scene, study->scene, SCENE_BYTES, &text, &length));
	const uint64_t hash = add_text(HASH_START, text);
	mem_free(text);
	for (size_t run = 0; run < study->run_count; run++) {
		enum status status = name_run(study, run, hash, found);
		if (status == STATUS_INPUT)
			study_refuse(study, &refused, run);
		else
			TRY(status);
	}
	TRY(study_tell_refused(study, &refused));
	if (!collects)
		TRY(study_check_sought(study, found));
	return keep_folders(study, runs);
}

/* --- folders --- */

void study_quote(const char *text, FILE *file)
{
	fputc('\'', file);
	for (const char *c = text; *c != '\0'; c++)
		if (*c == '\'')
			fputs("'\\''", file);
		else
			fputc(*c, file);
	fputc('\'', file);
}

/* run.sh: the same drive for a scheduler, or by hand. */
static enum status write_script(struct study *study, size_t run)
{
	char path[PATH_MAX], log[PATH_MAX], json[PATH_MAX];
	const char **list = NULL;
	struct aside aside = {.path = NULL};
	enum status status;
	TRY_OR(done, study_arguments(study, run, &list));
	TRY_OR(done, aside_begin(&aside, study_path(study, run, "run.sh", path)));
	fputs("#!/bin/sh\n# One run of a study. It is not run again when it is complete; "
	      "it goes on when it was killed.\n"
	      "grep -q '\"ended\":[[:space:]]*\"complete\"' ",
	      aside.file);
	study_quote(study_path(study, run, "run.json", json), aside.file);
	fputs(" 2>/dev/null && exit 0\nfurrow=${FURROW:-", aside.file);
	study_quote(list[0], aside.file);
	fputs("}\nexec \"$furrow\"", aside.file);
	for (const char **argument = list + 1; *argument != NULL; argument++) {
		fputc(' ', aside.file);
		study_quote(*argument, aside.file);
	}
	fputs(" >>", aside.file);
	study_quote(study_path(study, run, "log.txt", log), aside.file);
	fputs(" 2>&1\n", aside.file);
done:
	status = aside_end(&aside, false, status);
	mem_free(list);
	return status;
}

/* DIR/study.yaml: what `furrow study collect DIR` reads again. */
static enum status write_copy(const struct study *study)
{
	char path[PATH_MAX];
	struct aside aside = {.path = NULL};
	snprintf(path, sizeof path, "%.4000s/study.yaml", study->directory);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	fwrite(study->text, 1, study->length, aside.file);
done:
	return aside_end(&aside, false, status);
}

static enum status find_paths(struct study *study, const char *directory)
{
	char whole[PATH_MAX];
	ssize_t length = readlink("/proc/self/exe", whole, sizeof whole - 1);
	if (length <= 0)
		return fail_with(STATUS_FAILED, "/proc/self/exe: %s; mount /proc", strerror(errno));
	whole[length] = '\0';
	study->program = mem_strdup(whole);
	if (realpath(directory, whole) == NULL)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be read", directory, strerror(errno));
	if (strlen(whole) > PATH_MAX - 200)
		return fail_with(STATUS_FAILED, "%s: its path is too long; give a shorter one", directory);
	study->directory = mem_strdup(whole);
	return study->program != NULL && study->directory != NULL ? STATUS_OK : fail_memory("paths of the study");
}

/* Makes the folder of runs, names them and looks which are there. */
static enum status find_runs(struct study *study, const char *directory, bool collects)
{
	char path[PATH_MAX];
	TRY(drive_folder_make(directory));
	TRY(find_paths(study, directory));
	snprintf(path, sizeof path, "%.4000s/runs", study->directory);
	TRY(drive_folder_make(path));
	TRY(name_runs(study, path, collects));
	for (size_t run = 0; run < study->run_count; run++)
		study_look(study, run);
	return collects ? STATUS_OK : study_check_runs(study);
}

enum status study_prepare(struct study *study, const char *directory, bool collects)
{
	char path[PATH_MAX];
	struct stat found;
	const bool there = stat(directory, &found) == 0;
	enum status status = find_runs(study, directory, collects);
	if (status != STATUS_OK && !there && study->directory != NULL) { /* a refused study leaves nothing */
		snprintf(path, sizeof path, "%.4000s/runs", study->directory);
		(void)rmdir(path);
		(void)rmdir(study->directory);
	}
	TRY(status);
	for (size_t run = 0; run < study->run_count; run++) {
		TRY(drive_folder_make(study_path(study, run, "", path)));
		TRY(write_script(study, run));
	}
	TRY(write_copy(study));
	return study_manifest(study);
}
