/* Shared by poses.c and cameras.c: where the cameras of a drive were. */
#ifndef FURROW_REPORT_POSES_H
#define FURROW_REPORT_POSES_H

#include "report/report.h"

#define POSES_PATH 4400 /* bytes */

struct poses_row {
	int64_t frame;
	double time, at[3]; /* s; m, local */
	double q[4];        /* x, y, z, w: turns the camera's axes (right, down, ahead) into east, north, up */
};

struct poses_of {
	FILE *file; /* NULL: no frame was drawn yet */
	FILE *frames; /* frames.csv; NULL: none */
	struct poses_row *rows;
	size_t count, room;
};

struct report_poses {
	const struct world *world;
	const char *directory;
	struct poses_of *cameras; /* of the scene's cameras */
	size_t count;
	struct render_poses sink;
};

/* Fills the path of a file in a camera's folder. */
void report_poses_path(const struct report_poses *poses, size_t camera, const char *name, char path[POSES_PATH]);

/* frames.c: writes a row of frames.csv, if the scene draws light: how each frame was exposed. */
enum status report_frames_add(struct report_poses *poses, size_t camera, int64_t frame, const struct render_pose *pose) FURROW_CHECKED;

/* Fills the quaternion x, y, z, w of a rotation, given by its columns. `w` is not negative. */
void report_quaternion(double columns[3][3], double q[4]);

#endif
