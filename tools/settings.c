#include "settings.h"

#include <string.h>

#include "soil_given.h"

/* Adds a setting. */
static enum status add(struct settings *settings, const char *key, size_t length, const char *value)
{
	const size_t room = strlen(value) + 1;
	char *copy = mem_alloc(length + 1 + room, 1);
	TRY_MEM(copy, "settings");
	memcpy(copy, key, length);
	copy[length] = '\0';
	memcpy(copy + length + 1, value, room);
	settings->texts[settings->count] = copy;
	settings->list[settings->count++] = (struct scene_setting){copy, copy + length + 1};
	return STATUS_OK;
}

/* What is given in place of a soil, and looks like a path. */
static bool looks_like_file(const char *value)
{
	return value[0] != '\0' && strpbrk(value, "{}[]:,") == NULL && strpbrk(value, "./") != NULL;
}

/* A soil may be a file that has one. */
static enum status add_soil(struct settings *settings, const char *path)
{
	char *value = NULL;
	enum status status;
	TRY_OR(done, soil_given_value(path, &value));
	TRY_OR(done, add(settings, "soil", strlen("soil"), value));
done:
	mem_free(value);
	return status;
}

enum status settings_take(const struct arguments *arguments, struct settings *settings)
{
	const char *text;
	while ((text = arguments_nth(arguments, "set", settings->count)) != NULL) {
		const char *equals = strchr(text, '=');
		if (equals == NULL || equals == text)
			return fail_with(STATUS_USAGE, "--set %s: not KEY=VALUE; give one as in --set cache.slots=16", text);
		if (settings->count == SETTINGS_MAX)
			return fail_with(STATUS_USAGE, "--set: is given too often; %d times at most", SETTINGS_MAX);
		const size_t length = (size_t)(equals - text);
		const bool soil = length == strlen("soil") && strncmp(text, "soil", length) == 0, file = soil && soil_given_is_file(equals + 1);
		if (soil && !file && looks_like_file(equals + 1))
			return fail_with(STATUS_USAGE, "--set %s: not a soil file; give one that ends in .yaml, as furrow fit-soil -o writes it, a name as in "
						       "--set soil.name=dry_sand, or numbers in braces", text);
		TRY(file ? add_soil(settings, equals + 1) : add(settings, text, length, equals + 1));
	}
	return STATUS_OK;
}

void settings_finish(struct settings *settings)
{
	for (size_t i = 0; i < settings->count; i++)
		mem_free(settings->texts[i]);
}
