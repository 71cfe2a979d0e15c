/* Drives of vehicles: what they leave in vehicles.csv. */
#ifndef TESTS_VEHICLE_DRIVE_H
#define TESTS_VEHICLE_DRIVE_H

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

#endif
