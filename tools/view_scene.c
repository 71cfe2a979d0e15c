/* The scene as furrow view takes it: one that names no view gets one. */
#include <math.h>
#include <stdio.h>

#include "view.h"

/* What a scene without a view is seen with: from behind its first object. It has one, or it is no scene. */
#define DEFAULT_SIZE "[1280, 720]"
#define DEFAULT_EFFECTS "[texture, detail, fog, sky, geomorph, skirts]"
#define DEFAULT_BACK 8.0 /* times the object's radius, and */
#define DEFAULT_BACK_LEAST 12.0 /* metres */
#define DEFAULT_UP 0.4 /* times that */

static void default_view(const struct scene *scene, char *text, size_t size)
{
	if (scene->object_count == 0) { /* it has vehicles */
		snprintf(text, size, "{size: " DEFAULT_SIZE ", camera: {chase: \"%.100s\", back: 8, up: 3}, effects: " DEFAULT_EFFECTS "}",
			 scene->vehicles[0].name);
		return;
	}
	double back = fmax(DEFAULT_BACK * soil_shape_bound(&scene->objects[0].shape), DEFAULT_BACK_LEAST);
	snprintf(text, size, "{size: " DEFAULT_SIZE ", camera: {chase: \"%.100s\", back: %g, up: %g}, effects: " DEFAULT_EFFECTS "}",
		 scene->objects[0].name, back, DEFAULT_UP * back);
}

/* Before those that were given, which may change it. */
static enum status put_first(struct settings *settings, const char *key, const char *value)
{
	char *copy = mem_strdup(value);
	TRY_MEM(copy, "settings");
	if (settings->count == SETTINGS_MAX) {
		mem_free(copy);
		return fail_with(STATUS_USAGE, "--set: is given too often; %d times at most", SETTINGS_MAX - 1);
	}
	for (size_t i = settings->count++; i > 0; i--) {
		settings->list[i] = settings->list[i - 1];
		settings->texts[i] = settings->texts[i - 1];
	}
	settings->texts[0] = copy;
	settings->list[0] = (struct scene_setting){key, copy};
	return STATUS_OK;
}

enum status view_scene_load(const char *path, struct settings *settings, struct scene **out)
{
	struct scene *plain;
	char view[400];
	/* As the file has it: what is set may be of a view that it does not have. If that is wrong, it is told below. */
	if (scene_load(path, NULL, 0, &plain) == STATUS_OK) {
		enum status status = STATUS_OK;
		if (!plain->view.present || plain->view.implied) {
			default_view(plain, view, sizeof view);
			status = put_first(settings, "view", view);
		}
		scene_destroy(plain);
		if (status != STATUS_OK)
			return status;
	}
	return scene_load(path, settings->list, settings->count, out);
}
