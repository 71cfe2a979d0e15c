/* Tells the overlays that depend on a store. */
#include "pins.h"

#include <inttypes.h>
#include <stdio.h>

#include "json.h"

void pin_of(const struct store_pin *pin, char *text, size_t room)
{
	if (pin->base)
		snprintf(text, room, "the base");
	else
		snprintf(text, room, "revision %lld", (long long)pin->revision);
}

cJSON *pin_json(const struct store_pin *pin)
{
	static const char *const states[] = {
		[STORE_PIN_THERE] = "there", [STORE_PIN_MOVED] = "moved", [STORE_PIN_GONE] = "gone", [STORE_PIN_FOUND] = "unlisted",
	};
	char hash[20];
	cJSON *object = cJSON_CreateObject();
	snprintf(hash, sizeof hash, "%016" PRIx64, pin->hash);
	json_string(object, "file", pin->path);
	json_integer(object, "revision", pin->revision);
	cJSON_AddStringToObject(object, "hash", hash);
	cJSON_AddBoolToObject(object, "base", pin->base);
	cJSON_AddStringToObject(object, "state", states[pin->state]);
	if (pin->found != NULL)
		cJSON_AddStringToObject(object, "found", pin->found);
	return object;
}
