/* Soils of the command line; see soil_given.h. */
#include "soil_given.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dem/dem.h"

bool soil_given_is_file(const char *given)
{
	static const char *const endings[] = {".yaml", ".yml", ".json"};
	for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
		if (dem_path_ends(given, endings[i]))
			return true;
	return false;
}

void soil_given_finish(struct soil_given *soil)
{
	mem_free_all(soil->text, soil->label);
	*soil = (struct soil_given){.text = NULL};
}

/* The file's name without its folder and its ending. */
static char *label_of(const char *path)
{
	const char *slash = strrchr(path, '/');
	char *label = mem_strdup(slash != NULL ? slash + 1 : path);
	if (label != NULL)
		*strrchr(label, '.') = '\0';
	return label;
}

/* Refuses a scene whose soil is not one everywhere. */
static enum status check_one(const struct scene *scene, const char *path)
{
	if (scene_has_classes(scene) || scene->raster_count > 0)
		return fail_with(STATUS_INPUT, "%s: its soil is a map; give a file with one soil, as furrow fit-soil -o writes it", path);
	return STATUS_OK;
}

/* Loads a file with one soil. The caller destroys the scene, also on failure. */
static enum status load_file(const char *path, struct scene **scene)
{
	/* The soil is read for the rig's model, whatever the file says of its own. */
	const struct scene_setting model = {.key = "redistribute", .value = "{model: scm}"};
	TRY(scene_load_file(path, &model, 1, SCENE_HOST, scene));
	return check_one(*scene, path);
}

/* Writes "{name: dry_sand, cohesion: 500}": what the scene gives of its soil. */
static enum status write_value(const struct scene *scene, char **out)
{
	static const char key[] = "soil.";
	char *text = NULL;
	size_t size = 0, count = 0;
	FILE *stream = open_memstream(&text, &size);
	TRY_MEM(stream, "a soil");
	for (size_t i = 0; i < scene->value_count; i++)
		if (strncmp(scene->values[i].key, key, strlen(key)) == 0)
			fprintf(stream, "%s%s: %s", count++ > 0 ? ", " : "{", scene->values[i].key + strlen(key), scene->values[i].text);
	fputs(count > 0 ? "}" : "{}", stream);
	const bool written = fclose(stream) == 0;
	*out = written ? mem_strdup(text) : NULL;
	free(text);
	return *out != NULL ? STATUS_OK : fail_memory("a soil");
}

enum status soil_given_value(const char *path, char **out)
{
	struct scene *scene = NULL;
	enum status status;
	TRY_OR(done, load_file(path, &scene));
	TRY_OR(done, write_value(scene, out));
done:
	scene_destroy(scene);
	return status;
}

static enum status take_file(const char *path, struct soil_given *soil)
{
	struct scene *scene = NULL;
	enum status status;
	TRY_OR(done, load_file(path, &scene));
	soil->text = scene_soil_text(&scene->soils[0], scene->model);
	soil->label = label_of(path);
	if (soil->text == NULL || soil->label == NULL)
		TRY_OR(done, fail_memory("a soil"));
done:
	scene_destroy(scene);
	return status;
}

enum status soil_given_take(const char *given, struct soil_given *soil)
{
	if (soil_given_is_file(given))
		return take_file(given, soil);
	soil->text = mem_strdup(given);
	soil->label = mem_strdup(given);
	return soil->text != NULL && soil->label != NULL ? STATUS_OK : fail_memory("a soil");
}

enum status soil_given_of_scene(const struct scene *scene, const char *path, struct soil_given *soil)
{
	const char *name = scene->soil_names[0];
	if (scene->soil_count == 0)
		return fail_with(STATUS_INPUT, "%s: its model reads no soil; give --soil", path);
	struct soil_numbers named;
	soil->text = scene_soil_text(&scene->soils[0], scene->model);
	char *plain = soil_named(name, &named) == STATUS_OK ? scene_soil_text(&named, scene->model) : NULL;
	/* A named soil with numbers of the scene's own is another one. */
	const bool own = soil->text != NULL && (plain == NULL || strcmp(plain, soil->text) != 0);
	const size_t room = strlen(name) + strlen(path) + 8;
	mem_free(plain);
	soil->label = mem_alloc(room, 1);
	TRY_MEM(soil->text != NULL && soil->label != NULL, "a soil");
	snprintf(soil->label, room, own ? "%s of %s" : "%s", name, path);
	return STATUS_OK;
}
