/* What tests of effects share: parts of scenes, and drives whose counts are held to their plan. */
#ifndef FURROW_TESTS_LAWS_EFFECTS_H
#define FURROW_TESTS_LAWS_EFFECTS_H

#include "../counts.h"
#include "../planned.h"
#include "../support/skip.h"

static const struct extent extent = {129, 129, 1, 32};

static inline double gentle(int64_t x, int64_t y)
{
	return 100 + (double)(x * y % 7) / 1024;
}

/* --- scenes --- */

/* Nothing is loaded ahead, so that what is loaded when does not go by the clock. */
#define READ(how) "scene: 1\ntime_step: 0.1\nend_time: 0.6\ncache: {slots: 48, " how "}\n"
#define HEAD READ("loaders: 0, prefetch: 0")
/* The store has more tiles than these slots. Where they all have one, none is loaded ahead. */
#define SCARCE(how) "scene: 1\ntime_step: 0.1\nend_time: 0.6\ncache: {slots: 16, " how "}\n"
#define SCARCE_HEAD SCARCE("loaders: 0, prefetch: 0")
#define PATH "path: {points: [[30, 30], [60, 50]], speed: 10}"
#define OBJECT(shape) "objects:\n  - {name: a, shape: {" shape "}, sink: 0.3, " PATH "}\n"
#define SPHERE OBJECT("sphere: {radius: 1.5}")
#define WHEEL "wheel: {radius: 1.5, width: 1"
#define SOIL "soil: {name: dry_sand}\n"
#define SCM SOIL "redistribute: {model: scm}\n"
#define LOOSE_SCM SOIL "redistribute: {model: scm, loosening: 0.67}\n"
#define DENSE_SCM SOIL "redistribute: {model: scm, hardening: 0.5}\n"
#define THROWN_SCM SOIL "redistribute: {model: scm, thrown: on}\n"
#define STILL_SCM SOIL "redistribute: {model: scm, slip_sinkage: 0}\n" /* slip does not dig */

#define CAMERA "size: [160, 90], camera: {fixed: {eye: [20, 10, 120], target: [50, 45, 100]}}, images: 2"
#define VIEW(effects) "view: {" CAMERA ", effects: [" effects "]}\n"

/* Nothing is written. */
#define UNSEEN "view: {size: [160, 90], camera: {fixed: {eye: [20, 10, 120], target: [50, 45, 100]}}, effects: [texture, sky]}\n"

#define MAP "soil: {map: classes.png, classes: {1: dry_sand}, default: dry_sand}\nredistribute: {model: scm}\n"

#define RASTERS "soil: {name: dry_sand, rasters: {cohesion: classes.png}}\nredistribute: {model: scm}\n"

/* Neither objects nor a view: no file may say that. */
#define NOTHING ""

/* --- drives --- */

struct outcome {
	bool repeats; /* counts of visits */
	struct scene *scene;
	size_t taken; /* objects that were taken out of it */
	struct plan plan;
	uint64_t effects; /* called for */
	cJSON *json;
	const cJSON *counts;
};

static inline void finish(struct outcome *outcome)
{
	outcome->scene->object_count += outcome->taken;
	scene_destroy(outcome->scene);
	plan_finish(&outcome->plan);
	cJSON_Delete(outcome->json);
}

static inline struct scene *load(const char *text)
{
	const char *path = support_path("effects.yaml");
	struct scene *scene;
	support_write(path, text);
	must(scene_load(path, NULL, 0, &scene));
	return scene;
}

/* Whether this build reads meshes. */
static inline bool has_meshes(void)
{
	struct scene *scene;
	const char *path = support_path("mesh.yaml");
	support_write(support_path("plane.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 3 2 1\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
	support_write(path, HEAD OBJECT("mesh: {file: plane.obj}"));
	enum status status = scene_load(path, NULL, 0, &scene);
	if (status == STATUS_OK)
		scene_destroy(scene);
	return status == STATUS_OK;
}

/* Every drive: what it counted is what was planned, and its threads are gone. */
static inline struct outcome drive_on(const char *text, const char *store)
{
	bool nothing = strcmp(text, NOTHING) == 0;
	struct outcome outcome = {.scene = load(nothing ? HEAD SPHERE : text)};
	outcome.taken = nothing ? outcome.scene->object_count : 0;
	outcome.scene->object_count -= outcome.taken;
	outcome.effects = planned(outcome.scene, store, &outcome.plan);
	struct drive_params params = {.scene = outcome.scene, .store = store, .directory = support_path("out"),
				    .keep_history = planned_history};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	must(status);
	outcome.repeats = support_counts_repeat(result.json);
	outcome.json = cJSON_Parse(result.json);
	mem_free(result.json);
	assert_non_null(outcome.json);
	outcome.counts = counts_get(outcome.json, "counts");
	if (counts_check(&outcome.plan, outcome.counts, outcome.scene) != 0) {
		print_error("in this scene:\n%s", text);
		fail();
	}
	assert_int_equal(thread_running(), 0);
	return outcome;
}

static inline struct outcome drive(const char *text)
{
	const char *store = support_path("effects.furrow");
	support_store(store, extent, gentle);
	if (strstr(text, "imagery") != NULL)
		assert_true(support_imagery(store, 150, 120, 90));
	return drive_on(text, store);
}

/* --- what may differ --- */

static inline void write_files(void)
{
	support_write(support_path("block.obj"),
		      "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 2\nv 1 -1 2\nv 1 1 2\nv -1 1 2\n"
		      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
	struct dem_raster raster = {.path = support_path("classes.png"), .width = 129, .height = 129, .type = DEM_UINT8, .spacing = 1};
	struct dem_writer *writer;
	double row[129];
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 129; y++) {
		for (int x = 0; x < 129; x++)
			row[x] = x / 7 % 2;
		must(dem_writer_rows(writer, 1, row));
	}
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
}

#endif
