/* Drives of vehicles: what they leave in vehicles.csv. */
#ifndef TESTS_VEHICLE_DRIVE_H
#define TESTS_VEHICLE_DRIVE_H

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../support.h"
#include "../support/skip.h"

struct drive_row {
	double t, x, y, z, roll, pitch, yaw, vx, vy, vz, kinetic, work;
};

/* The rows of one vehicle. Returns their number. */
static inline size_t drive_rows(const char *path, const char *name, struct drive_row *rows, size_t most)
{
	char *text = support_text(path), called[64];
	size_t count = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0' && count < most; line = strchr(line + 1, '\n')) {
		struct drive_row *r = &rows[count];
		assert_int_equal(sscanf(line + 1, "%lf,%63[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &r->t, called, &r->x, &r->y, &r->z, &r->roll,
					&r->pitch, &r->yaw, &r->vx, &r->vy, &r->vz, &r->kinetic, &r->work), 13);
		count += strcmp(called, name) == 0;
	}
	free(text);
	return count;
}

/* One more cut of a drive: an overlay and a folder of its own. `ended` may be NULL. */
struct drive_cut {
	const char *overlay, *out;
	bool resume;
	int64_t steps;
};

static inline enum status make_drive(const char *scene_path, const char *store, const char *const *settings, const struct drive_cut *cut, char **json)
{
	struct scene *scene = support_scene(scene_path, settings);
	struct drive_params params = {.scene = scene, .store = store, .overlay = cut->overlay, .directory = cut->out, .resume = cut->resume,
				    .steps = cut->steps};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	if (json != NULL)
		*json = result.json;
	else
		mem_free(result.json);
	return status;
}

/* Kills a drive `later` microseconds after it committed something, or lets it end before. Returns true if it was killed. */
static inline bool drive_killed(pid_t child, const char *out, useconds_t later)
{
	char path[256];
	struct stat file;
	snprintf(path, sizeof path, "%s/epochs.log", out);
	const off_t before = stat(path, &file) == 0 ? file.st_size : 0;
	int ended = 0;
	while (waitpid(child, &ended, WNOHANG) == 0) {
		if (stat(path, &file) == 0 && file.st_size > before) {
			usleep(later);
			kill(child, SIGKILL);
			assert_int_equal(waitpid(child, &ended, 0), child);
			break;
		}
		usleep(2000);
	}
	return WIFSIGNALED(ended);
}

/* Both have the same rows, of more than so many bytes. */
static inline void assert_same_rows(const char *a, const char *b, size_t least)
{
	static const char *const files[] = {"vehicles.csv", "objects.csv"};
	for (int i = 0; i < 2; i++) {
		char path_a[256], path_b[256];
		snprintf(path_a, sizeof path_a, "%s/%s", a, files[i]);
		snprintf(path_b, sizeof path_b, "%s/%s", b, files[i]);
		char *text_a = support_text(path_a), *text_b = support_text(path_b);
		assert_true(strlen(text_a) > least);
		assert_string_equal(text_a, text_b);
		free(text_a);
		free(text_b);
	}
}

#endif
