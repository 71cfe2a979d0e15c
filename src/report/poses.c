/*
 * Where the cameras of a drive were at each frame: poses.tum, a row a frame. camera.json and COLMAP's files are made of it when the
 * drive ends.
 *
 * A resumed drive goes on with the rows that it finds. A frame that is drawn again replaces its row and all that follow.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/aside.h"
#include "base/limits.h"
#include "report/poses.h"

#define HEADER "# timestamp tx ty tz qx qy qz qw\n"

static enum status failed(const char *path)
{
	return fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written"));
}

/* Shepperd 1978: the largest of the four is found first. */
void report_quaternion(double columns[3][3], double q[4])
{
	const double trace = columns[0][0] + columns[1][1] + columns[2][2];
	const double squares[4] = {columns[0][0], columns[1][1], columns[2][2], trace};
	int most = 3;
	for (int i = 0; i < 3; i++)
		most = squares[i] > squares[most] ? i : most;
	if (most == 3) {
		for (int i = 0; i < 3; i++)
			q[i] = columns[(i + 1) % 3][(i + 2) % 3] - columns[(i + 2) % 3][(i + 1) % 3];
		q[3] = 1 + trace;
	} else {
		const int next = (most + 1) % 3, last = (most + 2) % 3;
		q[most] = 1 + 2 * columns[most][most] - trace;
		q[next] = columns[most][next] + columns[next][most];
		q[last] = columns[most][last] + columns[last][most];
		q[3] = columns[next][last] - columns[last][next];
	}
	const double length = copysign(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), q[3] < 0 ? -1 : 1);
	for (int i = 0; i < 4; i++)
		q[i] /= length;
}

/* --- rows --- */

static enum status add(struct poses_of *poses, const struct poses_row *row)
{
	TRY(mem_grow(&poses->rows, &poses->room, poses->count + 1, sizeof *poses->rows, "the cameras' poses"));
	poses->rows[poses->count++] = *row;
	return STATUS_OK;
}

#define ROW 400 /* bytes of a row's text */

static void print_row(const struct poses_row *row, char text[ROW])
{
	snprintf(text, ROW, "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", row->time, row->at[0], row->at[1], row->at[2], row->q[0], row->q[1],
		 row->q[2], row->q[3]);
}

static bool parse_row(const char *text, struct poses_row *row)
{
	return sscanf(text, "%lf %lf %lf %lf %lf %lf %lf %lf", &row->time, &row->at[0], &row->at[1], &row->at[2], &row->q[0], &row->q[1], &row->q[2],
		      &row->q[3]) == 8;
}

/* Writes the rows so far anew, and opens the file for those that follow. */
static enum status begin_file(struct poses_of *poses, const char *path)
{
	struct aside aside;
	TRY(aside_begin(&aside, path));
	/* A failure here returns when the file is completed. */
	(void)fputs(HEADER, aside.file);
	for (size_t i = 0; i < poses->count; i++) {
		char text[ROW];
		print_row(&poses->rows[i], text);
		(void)fputs(text, aside.file);
	}
	TRY(aside_end(&aside, false, STATUS_OK));
	poses->file = output_open(path, "a");
	return poses->file != NULL ? STATUS_OK : failed(path);
}

/* Reads the rows until `time` of an earlier part of the drive. A kill may have torn the last line. */
static enum status read_rows(struct poses_of *poses, const struct scene_camera *camera, const char *path, double time)
{
	FILE *file = input_open(path);
	char *line = NULL;
	size_t room = 0;
	ssize_t length;
	enum status status = STATUS_OK;
	if (file == NULL)
		return STATUS_OK;
	while ((length = getline(&line, &room, file)) > 0 && line[length - 1] == '\n') {
		struct poses_row row;
		if (line[0] == '#')
			continue;
		if (!parse_row(line, &row) || row.time > time * (1 + 1e-8))
			break;
		row.frame = (int64_t)floor(row.time * camera->rate + 1e-6);
		TRY_OR(done, add(poses, &row));
	}
done:
	free(line);
	fclose(file);
	return status;
}

static enum status take(void *user, size_t index, int64_t frame, const struct render_pose *pose)
{
	struct report_poses *all = user;
	struct poses_of *poses = &all->cameras[index];
	struct poses_row row = {.frame = frame, .time = world_time(all->world), .at = {pose->eye[0], pose->eye[1], pose->eye[2]}};
	double columns[3][3];
	char path[POSES_PATH], text[ROW];
	for (int i = 0; i < 3; i++) {
		columns[0][i] = pose->right[i];
		columns[1][i] = -pose->up[i];
		columns[2][i] = pose->forward[i];
	}
	report_quaternion(columns, row.q);
	report_poses_path(all, index, "poses.tum", path);
	while (poses->count > 0 && poses->rows[poses->count - 1].frame >= frame)
		poses->count--;
	/* All files tell what this row tells, so that a resumed drive leaves the same. */
	print_row(&row, text);
	(void)parse_row(text, &row);
	if (poses->file == NULL)
		TRY(begin_file(poses, path));
	TRY(add(poses, &row));
	TRY(report_frames_add(all, index, frame, pose));
	return fputs(text, poses->file) >= 0 && fflush(poses->file) == 0 ? STATUS_OK : failed(path);
}

/* --- life --- */

void report_poses_path(const struct report_poses *poses, size_t camera, const char *name, char path[POSES_PATH])
{
	snprintf(path, POSES_PATH, "%s/" RENDER_CAMERAS "/%s/%s", poses->directory, world_scene(poses->world)->cameras[camera].name, name);
}

enum status report_poses_open(const struct world *world, const char *directory, struct report_poses **out)
{
	const struct scene *scene = world_scene(world);
	*out = NULL;
	if (scene->camera_count == 0)
		return STATUS_OK;
	struct report_poses *poses = mem_calloc(1, sizeof *poses);
	TRY_MEM(poses, "the cameras' poses");
	*poses = (struct report_poses){.world = world, .directory = directory, .count = scene->camera_count};
	poses->cameras = mem_calloc(scene->camera_count, sizeof *poses->cameras);
	enum status status;
	TRY_OR(failed, poses->cameras != NULL ? STATUS_OK : fail_memory("the cameras' poses"));
	for (size_t i = 0; i < scene->camera_count && world_facts(world)->resumed.is; i++) {
		char path[POSES_PATH];
		report_poses_path(poses, i, "poses.tum", path);
		TRY_OR(failed, read_rows(&poses->cameras[i], &scene->cameras[i], path, world_facts(world)->resumed.time));
	}
	poses->sink = (struct render_poses){poses, take};
	*out = poses;
	return STATUS_OK;
failed:
	report_poses_close(poses);
	return status;
}

const struct render_poses *report_poses_sink(const struct report_poses *poses)
{
	return poses != NULL ? &poses->sink : NULL;
}

void report_poses_close(struct report_poses *poses)
{
	if (poses == NULL)
		return;
	for (size_t i = 0; poses->cameras != NULL && i < poses->count; i++) {
		if (poses->cameras[i].file != NULL)
			fclose(poses->cameras[i].file);
		if (poses->cameras[i].frames != NULL)
			fclose(poses->cameras[i].frames);
		mem_free(poses->cameras[i].rows);
	}
	mem_free_all(poses->cameras, poses);
}
