#include "settings.h"

#include <string.h>

enum status settings_take(const struct arguments *arguments, struct settings *settings)
{
	const char *text;
	while ((text = arguments_nth(arguments, "set", settings->count)) != NULL) {
		const char *equals = strchr(text, '=');
		if (equals == NULL || equals == text)
			return fail_with(STATUS_USAGE, "--set %s: not KEY=VALUE; give one as in --set cache.slots=16", text);
		if (settings->count == SETTINGS_MAX)
			return fail_with(STATUS_USAGE, "--set: is given too often; %d times at most", SETTINGS_MAX);
		char *copy = mem_strdup(text);
		if (copy == NULL)
			return fail_memory("settings");
		copy[equals - text] = '\0';
		settings->texts[settings->count] = copy;
		settings->list[settings->count++] = (struct scene_setting){copy, copy + (equals - text) + 1};
	}
	return STATUS_OK;
}

void settings_finish(struct settings *settings)
{
	for (size_t i = 0; i < settings->count; i++)
		mem_free(settings->texts[i]);
}
