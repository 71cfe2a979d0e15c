/*
 * What the hard cases share: each model as a scene asks for it, and what must hold after any drive.
 *
 * Whatever happens to the ground: the store verifies (shared posts, pyramid, ranges, hashes: laws 1 and
 * 4), nothing that is printed is NaN or infinite, and under a conserving model what the offsets sum up to and what
 * was compacted cancel exactly (law 5).
 */
#ifndef FURROW_TESTS_HARD_H
#define FURROW_TESTS_HARD_H

#include "../support.h"

struct hard_model {
	const char *name, *text;
	bool conserves;
};

static const struct hard_model hard_models[] = {
	{"none", "redistribute: {model: none}\n", false},
	{"box", "redistribute: {model: box}\n", false},
	{"sumner", "redistribute: {model: sumner, iterations: 2, interval: 0.02}\nsoil: {name: sand}\n", true},
	{"slippage", "redistribute: {model: slippage, iterations: 2, interval: 0.02}\nsoil: {name: dry_sand}\n", true},
	{"none", "compute: cpu\nredistribute: {model: none}\n", false},
	{"box", "compute: cpu\nredistribute: {model: box}\n", false},
	{"sumner", "compute: cpu\nredistribute: {model: sumner, iterations: 2, interval: 0.02}\nsoil: {name: sand}\n", true},
	{"slippage", "compute: cpu\nredistribute: {model: slippage, iterations: 2, interval: 0.02}\nsoil: {name: dry_sand}\n", true},
	{"sheet", "redistribute: {model: sheet, yield: 0.1}\n", true},
	{"scm", "redistribute: {model: scm}\nsoil: {name: dry_sand}\noutput: {forces: 20}\n", true},
};
#define HARD_MODELS (sizeof hard_models / sizeof hard_models[0])

/* A scene of this model; `rest`: everything but version, model, soil and output. */
static inline const char *hard_scene(const struct hard_model *model, const char *rest)
{
	static char text[8192];
	const char *path = support_path("hard.yaml");
	snprintf(text, sizeof text, "scene: 1\n%s%s", model->text, rest);
	support_write(path, text);
	return path;
}

static inline void hard_finite(const char *text, const char *what)
{
	static const char *const words[] = {"nan", "NaN", "inf", "Infinity"};
	for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
		if (strstr(text, words[i]) != NULL)
			fail_msg("%s holds %s", what, words[i]);
}

/* Drives and holds the result to what must hold; returns run.json (mem_free). */
static inline char *hard_drive(const struct hard_model *model, const char *rest, const char *store,
			       const char *const *settings)
{
	char *json = support_drive(hard_scene(model, rest), store, settings);
	/* Names are the tests' own; all else in it is numbers. */
	hard_finite(json, "run.json");
	char path[160];
	snprintf(path, sizeof path, "%s/objects.csv", support_path("out"));
	FILE *rows = model->conserves && strcmp(model->name, "scm") == 0 ? fopen(path, "r") : NULL;
	char line[1024];
	size_t count = 0;
	while (rows != NULL && fgets(line, sizeof line, rows) != NULL) {
		hard_finite(line, "objects.csv");
		count++;
	}
	if (rows != NULL)
		fclose(rows);
	assert_true(strcmp(model->name, "scm") != 0 || count > 0);
	struct store_check check = support_verify(store);
	if (model->conserves) {
		long long level = support_figure(json, "{", "working_level");
		long long compacted = support_figure(json, "\"quanta\"", "compacted");
		if (check.offset_sum[level - TILE_LEVEL_MIN] + compacted != 0)
			fail_msg("%s: offsets and what was compacted sum up to %lld", model->name, (long long)check.offset_sum[level - TILE_LEVEL_MIN] + compacted);
	}
	return json;
}

/* 129 x 129 posts 1 m apart, rough by a few decimetres. */
static const struct extent hard_world = {129, 129, 1, 64};

static inline double hard_rough(int64_t x, int64_t y)
{
	return 20 + 0.5 * sin((double)x * 0.21) * cos((double)y * 0.17) + support_hills(x, y) / 400;
}

static inline const char *hard_store(const char *name)
{
	const char *path = support_path(name);
	support_store(path, hard_world, hard_rough);
	return path;
}

#endif
