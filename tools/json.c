#include "json.h"

#include <math.h>
#include <stdio.h>

void json_pair(cJSON *object, const char *name, double a, double b)
{
	double values[2] = {a, b};
	cJSON *array = cJSON_AddArrayToObject(object, name);
	for (int i = 0; i < 2; i++)
		cJSON_AddItemToArray(array, isfinite(values[i]) ? cJSON_CreateNumber(values[i]) : cJSON_CreateNull());
}

enum status json_print(cJSON *object)
{
	char *text = object != NULL ? json_text(object) : NULL;
	cJSON_Delete(object);
	TRY_MEM(text, "JSON");
	puts(text);
	cJSON_free(text);
	return STATUS_OK;
}
