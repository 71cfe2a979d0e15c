/* What tests of hosts share: a host that does what a test says and notes what it saw, a scene, and a drive with that host. */
#ifndef FURROW_TESTS_GUEST_H
#define FURROW_TESTS_GUEST_H

#include "../support.h"
#include "../support/skip.h"

#include "drive/drive.h"
#include "drive/internal.h"

static const struct extent extent = {257, 257, 1, 32};

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.1\n"
	"end_time: 2\n"
	"redistribute: {model: box}\n"
	"attributes: [dirt]\n"
	"objects:\n"
	"  - {name: a, shape: {sphere: {radius: 2.5}}, sink: 0.5, path: {points: [[40, 60], [80, 90]], speed: 20}}\n"
	"view:\n"
	"  size: [160, 90]\n"
	"  camera: {chase: a, back: 14, up: 9}\n"
	"  effects: [texture, sky, geomorph, skirts, objects, shadow]\n"
	"cache: {slots: 128}\n";

static inline double flat(int64_t x, int64_t y)
{
	return 100;
}

/* What one test's host does, and saw. */
struct guest {
	enum status (*act)(struct guest *guest, struct drive *drive, struct drive_control *wish);
	int turns, pictures, stage;
	int64_t step;     /* when the host last looked */
	bool pressed;
	uint64_t hash;    /* of the last picture */
	uint32_t width, height;
	bool changed;     /* a pixel is not what its neighbour is */
	uint8_t middle[3]; /* of the last picture */
};

static inline enum status on_turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct guest *guest = user;
	struct drive_figures figures;
	drive_figures(drive, &figures);
	guest->step = figures.step;
	guest->turns++;
	return guest->act(guest, drive, wish);
}

static inline enum status on_picture(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	struct guest *guest = user;
	uint64_t hash = 14695981039346656037u;
	for (size_t i = 0; i < (size_t)4 * width * height; i++)
		hash = (hash ^ pixels[i]) * 1099511628211u;
	for (size_t i = 4; i < (size_t)4 * width * height; i++)
		guest->changed = guest->changed || pixels[i] != pixels[i - 4];
	memcpy(guest->middle, pixels + 4 * ((size_t)(height / 2) * width + width / 2), sizeof guest->middle);
	guest->hash = hash;
	guest->pictures++;
	guest->width = width;
	guest->height = height;
	return STATUS_OK;
}

/* Drives a scene with this host; NULL: without one. */
static inline enum status drive_with(const char *store, const char *text, const struct drive_host *host)
{
	const char *path = support_path("scene.yaml");
	struct scene *scene;
	support_write(path, text);
	must(scene_load(path, NULL, 0, &scene));
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path("out"), .host = host};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	if (result.json != NULL)
		assert_int_equal(support_figure(result.json, "\"counts\"", "unplanned"), 0);
	mem_free(result.json);
	return status;
}

static inline enum status watch_drive(const char *store, const char *text, struct guest *guest, bool hosted)
{
	const struct drive_host host = {guest, on_turn, on_picture};
	return drive_with(store, text, hosted ? &host : NULL);
}

#endif
