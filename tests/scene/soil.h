/* What tests of soils in scenes share: a scene under scm, and edits of it that load or are refused. */
#ifndef FURROW_TESTS_SCENE_SOIL_H
#define FURROW_TESTS_SCENE_SOIL_H

#include <math.h>
#include <sys/stat.h>

#include "fixture.h"

static const char base[] = "scene: 1\n"
			   "end_time: 1\n"
			   "soil: {name: dry_sand}\n"
			   "redistribute: {model: scm}\n"
			   "objects:\n"
			   "  - name: a\n"
			   "    shape: {wheel: {radius: 0.5, width: 0.4}}\n"
			   "    path: {points: [[1, 2]], speed: 3}\n";

static inline struct scene *load_edited(const char *text, const char *from, const char *to)
{
	char *changed = edited(text, from, to);
	struct scene *scene;
	if (load_text(changed, NULL, 0, &scene) != STATUS_OK)
		fail_msg("%s: %s", to, failure_message());
	free(changed);
	return scene;
}

static inline void refuse(const char *from, const char *to, const char *says)
{
	char *text = edited(base, from, to);
	struct scene *scene;
	enum status status = load_text(text, NULL, 0, &scene);
	free(text);
	if (status != STATUS_INPUT)
		fail_msg("\"%s\" gives %d: %s", to, status, failure_message());
	assert_null(scene);
	assert_says("scene.yaml:");
	assert_says(says);
	assert_says("; ");
}

#endif
