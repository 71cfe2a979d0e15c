/*
 * How the frames of a camera were exposed: frames.csv, a row a frame, for scenes that draw light. A resumed drive goes on with the
 * rows that it finds; a frame that is drawn again replaces its row and all that follow.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/aside.h"
#include "base/limits.h"
#include "report/poses.h"

#define HEADER "frame,time,exposure,triangles\n"

static enum status failed(const char *path)
{
	return fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written"));
}

/* Copies the whole rows of frames before this one. A kill may have torn the last line. */
static void copy_rows(const char *path, int64_t before, FILE *to)
{
	FILE *from = input_open(path);
	char *line = NULL;
	size_t room = 0;
	ssize_t length;
	long long frame;
	while (from != NULL && (length = getline(&line, &room, from)) > 0 && line[length - 1] == '\n')
		if (sscanf(line, "%lld,", &frame) == 1 && frame < before)
			(void)fputs(line, to); /* a failure returns when the file is completed */
	free(line);
	if (from != NULL)
		fclose(from);
}

static enum status begin_file(const struct report_poses *poses, const char *path, int64_t frame, FILE **out)
{
	struct aside aside;
	TRY(aside_begin(&aside, path));
	(void)fputs(HEADER, aside.file); /* as above */
	if (world_facts(poses->world)->resumed.is)
		copy_rows(path, frame, aside.file);
	TRY(aside_end(&aside, false, STATUS_OK));
	*out = output_open(path, "a");
	return *out != NULL ? STATUS_OK : failed(path);
}

enum status report_frames_add(struct report_poses *poses, size_t camera, int64_t frame, const struct render_pose *pose)
{
	FILE **file = &poses->cameras[camera].frames;
	char path[POSES_PATH];
	if (!scene_draws_light(world_scene(poses->world)))
		return STATUS_OK;
	report_poses_path(poses, camera, "frames.csv", path);
	if (*file == NULL)
		TRY(begin_file(poses, path, frame, file));
	const int written = fprintf(*file, "%lld,%.9g,%.9g,%llu\n", (long long)frame, world_time(poses->world), pose->exposure, (unsigned long long)pose->triangles);
	return written > 0 && fflush(*file) == 0 ? STATUS_OK : failed(path);
}
