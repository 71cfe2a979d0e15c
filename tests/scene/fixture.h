/* A folder of its own for each test program, files in it, and the manual's scene. */
#ifndef TESTS_SCENE_FIXTURE_H
#define TESTS_SCENE_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/scene.h"

/* What the cache's defaults call for, where there are objects. */
#define CACHE_EFFECTS (EFFECT_BIT(EFFECT_LOADERS) | EFFECT_BIT(EFFECT_PREFETCH))

static char folder[64];

static const char example[] =
	"scene: 1                     # version of this format\n"
	"store: world.furrow          # relative to the scene's file\n"
	"time_step: 0.02              # s\n"
	"end_time: 30                 # s\n"
	"gravity: 9.81                # m/s2\n"
	"spacing: 0.125               # m\n"
	"coordinates: local           # local, store, or an SRS\n"
	"soil: {name: dry_sand}\n"
	"redistribute: {model: box}   # none, box\n"
	"attributes: [disturbance]           # planes kept\n"
	"outside: stop                # stop or skip\n"
	"objects:                     # they act in the order written\n"
	"  - name: front_left\n"
	"    shape: {wheel: {radius: 0.5, width: 0.4, grousers: 0}}\n"
	"    path: {points: [[10, 10], [90, 40]], speed: 5, loop: false}\n"
	"    sink: 0.1                # under the base\n"
	"    # load: 4000             # N instead of sink\n"
	"view:                        # absent: no colour buffer\n"
	"  size: [1280, 720]\n"
	"  camera: {chase: front_left, back: 12, up: 5}\n"
	"  effects: [texture, detail, fog, sky, geomorph, skirts]\n"
	"  images: 100                # a PNG every so many steps\n"
	"cache: {slots: 256, loaders: 2, prefetch: 1.5}   # LRU\n";

static const char minimal[] = "scene: 1\n"
			      "end_time: 1\n"
			      "objects:\n"
			      "  - name: a\n"
			      "    shape: {sphere: {radius: 1}}\n"
			      "    path: {points: [[1, 2]], speed: 3}\n";

static inline int make_folder(void **state)
{
	strcpy(folder, "/tmp/furrow-scene-XXXXXX");
	return mkdtemp(folder) == NULL ? -1 : 0;
}

static inline int drop_folder(void **state)
{
	return rmdir(folder);
}

static inline const char *in_folder(const char *name)
{
	static char path[128];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	return path;
}

static inline void write_bytes(const char *name, const void *bytes, size_t length)
{
	FILE *file = fopen(in_folder(name), "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, length, file), length);
	assert_int_equal(fclose(file), 0);
}

static inline void write_text(const char *name, const char *text)
{
	write_bytes(name, text, strlen(text));
}

/* Loads `text` as scene.yaml of the folder. */
static inline enum status load_text(const char *text, const struct scene_setting *settings,
				    size_t count, struct scene **scene)
{
	write_text("scene.yaml", text);
	enum status status = scene_load(in_folder("scene.yaml"), settings, count, scene);
	unlink(in_folder("scene.yaml"));
	return status;
}

static inline char *room_for(size_t bytes)
{
	char *room = malloc(bytes);
	if (room == NULL)
		abort();
	return room;
}

/* `text` with its first `from` turned into `to`. */
static inline char *edited(const char *text, const char *from, const char *to)
{
	const char *at = strstr(text, from);
	assert_non_null(at);
	if (at == NULL)
		abort();
	char *out = room_for(strlen(text) + strlen(to) + 1);
	sprintf(out, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
	return out;
}

/* A message without columns, "FILE:LINE: KEY: ...": most tests know the lines of their scenes alone. */
static inline const char *without_columns(const char *message)
{
	static char text[4096];
	size_t used = 0;
	for (const char *c = message; *c != '\0' && used + 1 < sizeof text; c++) {
		const size_t line = *c == ':' ? strspn(c + 1, "0123456789") : 0, column = line > 0 && c[1 + line] == ':' ? strspn(c + 2 + line, "0123456789") : 0;
		text[used++] = *c;
		if (column == 0 || strncmp(c + 2 + line + column, ": ", 2) != 0 || used + line >= sizeof text)
			continue;
		memcpy(text + used, c + 1, line);
		used += line;
		c += 1 + line + column;
	}
	text[used] = '\0';
	return text;
}

static inline void assert_says(const char *part)
{
	if (strstr(without_columns(failure_message()), part) == NULL)
		fail_msg("\"%s\" does not say \"%s\"", failure_message(), part);
	assert_null(strchr(failure_message(), '\n'));
}

/* Fails each allocation of loading scene.yaml in turn, or it and all behind it: told, and nothing is left behind. */
static inline void assert_memory_is_told(const struct scene_setting *settings, size_t count, bool forever)
{
	struct scene *scene;
	uint64_t nth = 0;
	enum status status;
	do {
		mem_fail_nth(++nth, forever);
		status = scene_load(in_folder("scene.yaml"), settings, count, &scene);
		mem_fail_nth(0, 0);
		if (status != STATUS_OK) {
			assert_int_equal(status, STATUS_FAILED);
			assert_null(scene);
			assert_says("out of memory");
		}
	} while (status != STATUS_OK && nth < 10000);
	assert_int_equal(status, STATUS_OK);
	assert_true(nth > 100);
	scene_destroy(scene);
}

#endif
