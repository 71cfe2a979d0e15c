/* --set KEY=VALUE, of the commands that read a scene. */
#ifndef FURROW_TOOLS_SETTINGS_H
#define FURROW_TOOLS_SETTINGS_H

#include "command.h"
#include "scene/scene.h"

#define SETTINGS_MAX 64
struct settings {
	struct scene_setting list[SETTINGS_MAX]; /* they point into texts */
	char *texts[SETTINGS_MAX];
	size_t count;
};

/* Those given, in order. `soil=FILE.yaml` is the soil that the file has. STATUS_USAGE if one is not KEY=VALUE. `settings` is zeroed before, and finished after, also
 * when it fails. */
enum status settings_take(const struct arguments *arguments, struct settings *settings) FURROW_CHECKED;
void settings_finish(struct settings *settings);

#endif
