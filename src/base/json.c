#include "base/json.h"

#include <math.h>
#include <stdio.h>

void json_integer(cJSON *object, const char *name, int64_t value)
{
	char text[32];
	snprintf(text, sizeof text, "%lld", (long long)value);
	cJSON_AddRawToObject(object, name, text);
}

void json_number(cJSON *object, const char *name, double value)
{
	if (isfinite(value))
		cJSON_AddNumberToObject(object, name, value);
	else
		cJSON_AddNullToObject(object, name);
}
