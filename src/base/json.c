#include "base/json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/plain.h"

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

void json_numbers(cJSON *object, const char *name, const double *numbers, size_t count)
{
	cJSON *list = cJSON_CreateDoubleArray(numbers, (int)count);
	if (!cJSON_AddItemToObject(object, name, list))
		cJSON_Delete(list);
}

void json_string(cJSON *object, const char *name, const char *text)
{
	if (text != NULL)
		cJSON_AddStringToObject(object, name, text);
	else
		cJSON_AddNullToObject(object, name);
}

/* cJSON escapes what JSON must, which is C0. The text of JSON has the other odd characters in strings alone. */
char *json_text(const cJSON *root)
{
	char *printed = cJSON_Print(root), *text = printed != NULL ? cJSON_malloc(6 * strlen(printed) + 1) : NULL, *to = text;
	const char *end = printed != NULL ? printed + strlen(printed) : NULL;
	for (const char *at = printed; text != NULL && at < end;) {
		bool odd;
		const size_t length = plain_next(at, (size_t)(end - at), &odd, NULL);
		const unsigned char *b = (const unsigned char *)at;
		if (odd)
			to += sprintf(to, "\\u%04x", length == 1 ? b[0] : length == 2 ? (b[0] & 0x1f) << 6 | (b[1] & 0x3f) : (b[0] & 0x0f) << 12 | (b[1] & 0x3f) << 6 | (b[2] & 0x3f));
		else
			to = (char *)memcpy(to, at, length) + length;
		at += length;
	}
	if (text != NULL)
		*to = '\0';
	cJSON_free(printed);
	return text;
}
