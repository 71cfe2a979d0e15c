/* The folder of a run: makes it, locks it, and removes the files of an earlier run. */
#define _GNU_SOURCE /* nftw */
#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/limits.h"
#include "drive/internal.h"

enum status drive_folder_make(const char *path)
{
	struct stat found;
	if (mkdir(path, 0777) != 0 && errno != EEXIST)
		return fail_with(STATUS_FAILED, "%s: %s; %s", path, errno == ENOENT ? "the folder that it is to be in is not there" : strerror(errno),
				 limits_advice(errno, "give a folder that can be made"));
	if (stat(path, &found) != 0 || !S_ISDIR(found.st_mode))
		return fail_with(STATUS_FAILED, "%s: is not a folder; give another", path);
	return STATUS_OK;
}

/* The log also shows that a run writes into this folder. Its lock ends with the process. */
enum status drive_folder_commits(const char *directory, FILE **out)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/epochs.log", directory);
	*out = output_open(path, "a+");
	if (*out == NULL)
		return fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written"));
	if (flock(fileno(*out), LOCK_EX | LOCK_NB) == 0)
		return STATUS_OK;
	fclose(*out);
	*out = NULL;
	return fail_with(STATUS_FAILED, "%s: another drive writes into this folder; give another, or wait for it to end", directory);
}

/* Returns whether a name is `begin`, six digits or more, and `ending`, or that with .part. */
static bool is_numbered(const char *name, const char *begin, const char *ending)
{
	const size_t length = strlen(begin), digits = strncmp(name, begin, length) == 0 ? strspn(name + length, "0123456789") : 0;
	const char *rest = name + length + digits;
	return digits >= 6 && strncmp(rest, ending, strlen(ending)) == 0 && (rest[strlen(ending)] == '\0' || strcmp(rest + strlen(ending), ".part") == 0);
}

static bool is_image(const char *name)
{
	for (int image = 0; image < SCENE_IMAGES; image++)
		if (strcmp(name, scene_image_name((enum scene_image)image)) == 0)
			return true;
	return false;
}

static bool is_of_camera(const char *name)
{
	static const char *const files[] = {"camera.json", "cameras.txt", "images.txt", "points3D.txt", "poses.tum", "colour.mp4", "lidar.json"};
	for (size_t i = 0; i < sizeof files / sizeof *files; i++)
		if (strcmp(name, files[i]) == 0)
			return true;
	return false;
}

/* Removes pictures, and files and folders of cameras and lidars, by their names alone. Others stay. `level`: 0 the run's folder, 1 cameras, 2 one of a camera,
 * 3 one of its images. */
static void clear_pictures(const char *path, int level)
{
	const struct dirent *entry;
	DIR *folder = opendir(path);
	while (folder != NULL && (entry = readdir(folder)) != NULL) {
		const char *name = entry->d_name;
		char inner[4096];
		if (name[0] == '.' || snprintf(inner, sizeof inner, "%s/%s", path, name) >= (int)sizeof inner)
			continue;
		if ((level == 0 && is_numbered(name, "frame-", ".png")) || (level == 2 && (is_of_camera(name) || is_numbered(name, "", ".npy"))) ||
		    (level == 3 && (is_numbered(name, "", ".png") || is_numbered(name, "", ".npy")))) {
			unlink(inner);
		} else if (level == 0 ? strcmp(name, RENDER_CAMERAS) == 0 || strcmp(name, REPORT_LIDARS) == 0 : level == 1 || (level == 2 && is_image(name))) {
			clear_pictures(inner, level + 1);
			rmdir(inner); /* where it is empty */
		}
	}
	if (folder != NULL)
		closedir(folder);
}

enum status drive_folder_clear(const struct world *world, const char *directory)
{
	char path[4096];
	FILE *commit_log = world_commit_log(world);
	const bool logged = fseek(commit_log, 0, SEEK_END) == 0 && ftell(commit_log) > 0;
	rewind(commit_log);
	long whole = 0;
	for (int c; world_facts(world)->resumed.is && (c = getc(commit_log)) != EOF;) /* a kill may have torn the last line */
		if (c == '\n')
			whole = ftell(commit_log);
	if (whole < 0 || ferror(commit_log) || ftruncate(fileno(commit_log), whole) != 0)
		return fail_with(STATUS_FAILED, "%s/epochs.log: %s; %s", directory, strerror(errno),
				 limits_advice(errno, "give a folder that can be written"));
	rewind(commit_log);
	snprintf(path, sizeof path, "%s/run.json", directory);
	const bool driven = unlink(path) == 0 || logged;
	if (driven && !world_facts(world)->resumed.is)
		clear_pictures(directory, 0);
	snprintf(path, sizeof path, "%s/map.png", directory);
	if (driven) /* the map of an earlier drive, or of this one's part before the resume */
		unlink(path);
	return STATUS_OK;
}

static int remove_entry(const char *path, const struct stat *stats, int kind, struct FTW *where)
{
	(void)stats, (void)kind, (void)where;
	(void)remove(path);
	return 0;
}

void drive_folder_remove(const char *directory)
{
	(void)nftw(directory, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
}
