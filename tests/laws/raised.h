/* What tests of raised ground share: bodies on ground with relief or rocks, and laws that must hold there for every model of the soil. */
#ifndef FURROW_TESTS_LAWS_RAISED_H
#define FURROW_TESTS_LAWS_RAISED_H

#include "../support.h"

static const struct extent extent = {129, 129, 4, 64};

/* A scene. `ground`: the line that raises it. */
#define RAISED(ground) \
	"scene: 1\n" \
	"time_step: 0.05\n" \
	"end_time: 6\n" \
	"spacing: 0.25\n" ground "\n" \
	"redistribute: {model: box}\n" \
	"objects:\n" \
	/* Through corners of four tiles. */ \
	"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.1,\n" \
	"     path: {points: [[20, 20], [300, 300], [290, 40]], speed: 60}}\n" \
	"  - {name: b, shape: {sphere: {radius: 2.5}}, sink: 0.3,\n" \
	"     path: {points: [[64, 300], [64, 64], [200, 128]], speed: 40}}\n"

static const char *const models[] = {"none", "box", "slippage", "scm", "sheet"};
#define MODELS 5

static double level_ground(int64_t x, int64_t y)
{
	return 40 + (double)(x * 3 + y) / 1024;
}

static const char *fresh(const char *name, uint32_t cells)
{
	const char *path = support_path(name);
	struct extent shape = extent;
	shape.cells = cells;
	support_store(path, shape, level_ground);
	return path;
}

static const char *scene_file(const char *text)
{
	const char *path = support_path("raised.yaml");
	support_write(path, text);
	return path;
}

static const char *const *with(const char *model, const char *a, const char *b)
{
	static char text[48];
	static const char *told[6];
	snprintf(text, sizeof text, "redistribute.model=%s", model);
	const bool soil = strcmp(model, "none") != 0 && strcmp(model, "box") != 0 && strcmp(model, "sheet") != 0;
	int count = 0;
	told[count++] = text;
	if (soil) {
		told[count++] = "soil.name=dry_sand";
		told[count++] = "end_time=1.5";
	}
	if (strcmp(model, "sheet") == 0)
		told[count++] = "redistribute.yield=0.02";
	told[count++] = a;
	told[count++] = b;
	told[count] = NULL;
	return told;
}

/* The fewest slots leave the same rows as all resident. `told`: what run.json has of the ground. */
static void check_slots(const char *scene, const char *told)
{
	for (int m = 0; m < MODELS; m++) {
		const char *few = fresh("few.furrow", 64), *all = fresh("all.furrow", 64);
		char *json = support_drive(scene, few, with(models[m], "cache.slots=4", "cache.prefetch=0"));
		assert_true(support_figure(json, "\"cache\"", "evictions") > 10);
		mem_free(json);
		json = support_drive(scene, all, with(models[m], "cache.slots=256", "cache.loaders=3"));
		assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
		assert_non_null(strstr(json, told));
		mem_free(json);
		support_verify(few);
		assert_true(support_hash(few) == support_hash(all));
	}
}

/* Tiles of 64, 128 and 256 cells give the same posts. */
static void check_tiles(const char *scene)
{
	const struct post_rect rect = {0, 0, 1300, 1300};
	for (int m = 0; m < MODELS; m++) {
		double *first = NULL;
		for (uint32_t cells = 64; cells <= 256; cells *= 2) {
			const char *path = fresh("tiles.furrow", cells);
			mem_free(support_drive(scene, path, with(models[m], "cache.slots=64", NULL)));
			double *quanta = support_quanta(path, -4, rect);
			size_t touched = 0;
			for (int64_t k = 0; k < rect.x1 * rect.y1; k++)
				touched += quanta[k] != 0;
			assert_true(touched > 1000);
			if (first == NULL) {
				first = quanta;
				continue;
			}
			assert_memory_equal(quanta, first, (size_t)(rect.x1 * rect.y1) * sizeof *quanta);
			free(quanta);
		}
		free(first);
	}
}

#endif
