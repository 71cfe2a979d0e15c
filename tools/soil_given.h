/* A soil of --soil: a name, a scene's soil in braces, or a file that has a scene's soil. */
#ifndef FURROW_TOOLS_SOIL_GIVEN_H
#define FURROW_TOOLS_SOIL_GIVEN_H

#include "base/base.h"
#include "scene/scene.h"

struct soil_given {
	char *text;  /* a name, or YAML in braces, as the rig takes it */
	char *label; /* for tables and plots: the name, the text in braces, or the name of the file without its ending */
};

/* Returns true if the text is the path of a file of a soil: if it ends in .yaml, .yml or .json. */
bool soil_given_is_file(const char *given);
/* Reads the soil of such a file as a value of --set: what it gives, in braces. The caller frees *out by mem_free. STATUS_INPUT as below. */
enum status soil_given_value(const char *path, char **out) FURROW_CHECKED;
/* STATUS_INPUT: the file cannot be read, or has no soil, or several. `soil` is to be finished also then. */
enum status soil_given_take(const char *given, struct soil_given *soil) FURROW_CHECKED;
/* Takes the soil of a scene that was read from `path`; of a map of soils its default. STATUS_INPUT: its model reads none. */
enum status soil_given_of_scene(const struct scene *scene, const char *path, struct soil_given *soil) FURROW_CHECKED;
void soil_given_finish(struct soil_given *soil);

#endif
