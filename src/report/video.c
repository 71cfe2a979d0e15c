/* Videos of cameras' colours, made by ffmpeg when a drive has ended. A video that cannot be made is told, and the drive has not failed. */
#define _GNU_SOURCE /* posix_spawn_file_actions_addchdir_np */
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report/poses.h"

#define VIDEO "colour.mp4"
#define PART "colour.part.mp4"

extern char **environ;

/* Runs ffmpeg in the camera's folder, so that no name of a folder is taken for a pattern or an option. Returns its exit status, or -1 with
 * errno. */
static int run(const char *folder, double rate)
{
	char each[32];
	snprintf(each, sizeof each, "%.9g", rate);
	const char *const words[] = {"ffmpeg", "-nostdin", "-y", "-loglevel", "error", "-framerate", each, "-i", "colour/%06d.png", "-vf",
				     "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", PART, NULL};
	posix_spawn_file_actions_t actions;
	pid_t process;
	int result = posix_spawn_file_actions_init(&actions), ended = 0;
	if (result == 0)
		result = posix_spawn_file_actions_addchdir_np(&actions, folder);
	for (int stream = STDIN_FILENO; stream <= STDERR_FILENO && result == 0; stream++)
		result = posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
	if (result == 0)
		result = posix_spawnp(&process, "ffmpeg", &actions, NULL, (char *const *)words, environ);
	posix_spawn_file_actions_destroy(&actions);
	errno = result;
	if (result != 0)
		return -1;
	while (waitpid(process, &ended, 0) < 0)
		if (errno != EINTR)
			return -1;
	return WIFEXITED(ended) ? WEXITSTATUS(ended) : 128;
}

static void make(const struct report_poses *poses, size_t index)
{
	const struct scene_camera *camera = &world_scene(poses->world)->cameras[index];
	char folder[POSES_PATH], part[POSES_PATH], whole[POSES_PATH];
	report_poses_path(poses, index, ".", folder);
	report_poses_path(poses, index, PART, part);
	report_poses_path(poses, index, VIDEO, whole);
	const int ended = run(folder, camera->rate);
	if (ended == 0 && rename(part, whole) == 0)
		return;
	if (ended < 0 && errno == ENOENT)
		note("cameras.%s.video: there is no ffmpeg, so no video is made of its pictures; install ffmpeg, or take video away", camera->name);
	else if (ended < 0)
		note("cameras.%s.video: ffmpeg cannot be run (%s), so no video is made", camera->name, strerror(errno));
	else
		note("cameras.%s.video: ffmpeg ended with %d, so no video is made; try it by hand on %s/colour", camera->name, ended, folder);
	unlink(part);
}

void report_videos(const struct report_poses *poses)
{
	for (size_t i = 0; poses != NULL && i < poses->count; i++)
		if (world_scene(poses->world)->cameras[i].video && poses->cameras[i].count > 0)
			make(poses, i);
}
