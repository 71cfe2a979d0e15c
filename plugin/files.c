/* Which overlay a mjData writes: the one that the model names, or one of its own that goes away with it. */
#include <dirent.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "plugin.h"

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct taken {
	char *path;
	struct taken *next;
} *all_taken; /* overlays that a mjData of this process writes */

static bool take(const char *path)
{
	struct taken *one = calloc(1, sizeof *one);
	bool free_now = one != NULL;
	pthread_mutex_lock(&lock);
	for (struct taken *t = all_taken; t != NULL; t = t->next)
		free_now = free_now && strcmp(t->path, path) != 0;
	if (free_now && (one->path = strdup(path)) != NULL) {
		one->next = all_taken;
		all_taken = one;
	} else {
		free(one);
		free_now = false;
	}
	pthread_mutex_unlock(&lock);
	return free_now;
}

static void give(const char *path)
{
	pthread_mutex_lock(&lock);
	for (struct taken **at = &all_taken; *at != NULL; at = &(*at)->next)
		if (strcmp((*at)->path, path) == 0) {
			struct taken *gone = *at;
			*at = gone->next;
			free(gone->path);
			free(gone);
			break;
		}
	pthread_mutex_unlock(&lock);
}

static bool make_own(struct plugin_soil *soil)
{
	const char *place = getenv("TMPDIR");
	char path[4096];
	if (snprintf(path, sizeof path, "%s/furrow-XXXXXX", place != NULL && place[0] != '\0' ? place : "/tmp") >= (int)sizeof path - 20 || mkdtemp(path) == NULL)
		return false;
	soil->folder = strdup(path);
	if (soil->folder == NULL) {
		rmdir(path);
		return false;
	}
	strcat(path, "/overlay.furrow");
	soil->overlay = strdup(path);
	return soil->overlay != NULL;
}

bool plugin_take_overlay(struct plugin_soil *soil, const char *asked)
{
	if (asked == NULL || asked[0] == '\0')
		return make_own(soil);
	soil->overlay = strdup(asked);
	if (soil->overlay == NULL || take(asked))
		return soil->overlay != NULL;
	free(soil->overlay);
	soil->overlay = NULL;
	return make_own(soil);
}

static void remove_folder(const char *folder)
{
	char path[4400];
	DIR *open = opendir(folder);
	for (const struct dirent *entry; open != NULL && (entry = readdir(open)) != NULL;)
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
		    snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) < (int)sizeof path)
			unlink(path);
	if (open != NULL)
		closedir(open);
	rmdir(folder);
}

void plugin_give_overlay(struct plugin_soil *soil)
{
	if (soil->folder != NULL)
		remove_folder(soil->folder);
	else if (soil->overlay != NULL)
		give(soil->overlay);
	free(soil->folder);
	free(soil->overlay);
	soil->folder = soil->overlay = NULL;
}
