/* The text of rocks, beside that of relief: {...relief, "rocks":{"cover":0.05,"k":0.05,"smallest":0.1,"largest":1,"seed":7}}, perhaps alone. */
#include <cJSON.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/relief.h"
#include "base/rocks.h"

enum { TEXT_MOST = 8192 };

static cJSON *object_of(const struct rocks_spec *rocks)
{
	cJSON *object = cJSON_CreateObject();
	if (object != NULL && cJSON_AddNumberToObject(object, "cover", rocks->cover) != NULL && cJSON_AddNumberToObject(object, "k", rocks->k) != NULL &&
	    cJSON_AddNumberToObject(object, "smallest", rocks->smallest) != NULL && cJSON_AddNumberToObject(object, "largest", rocks->largest) != NULL &&
	    cJSON_AddNumberToObject(object, "seed", rocks->seed) != NULL)
		return object;
	cJSON_Delete(object);
	return NULL;
}

char *rocks_print(const struct relief_spec *relief, const struct rocks_spec *rocks)
{
	char *text = relief != NULL ? relief_print(relief) : mem_strdup("{}"), *whole = NULL;
	if (rocks == NULL || text == NULL)
		return text;
	cJSON *root = cJSON_Parse(text), *object = object_of(rocks);
	if (root == NULL || object == NULL || !cJSON_AddItemToObject(root, "rocks", object))
		cJSON_Delete(object);
	else
		whole = cJSON_PrintUnformatted(root);
	mem_free(text);
	cJSON_Delete(root);
	text = whole != NULL ? mem_strdup(whole) : NULL;
	cJSON_free(whole);
	return text;
}

static bool number(const cJSON *object, const char *key, double most, double *value)
{
	const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
	*value = cJSON_IsNumber(item) ? item->valuedouble : (double)NAN;
	return *value >= 0 && *value <= most;
}

bool rocks_good(const struct rocks_spec *rocks)
{
	return rocks->cover > 0 && rocks->cover <= ROCKS_COVER_MOST && rocks->k > 0 && rocks->smallest >= ROCKS_SMALLEST_LEAST && rocks->smallest < rocks->largest &&
	       rocks->largest <= ROCKS_LARGEST_MOST && rocks->largest <= ROCKS_RANGE * rocks->smallest;
}

static bool parse(const cJSON *object, struct rocks_spec *rocks)
{
	double seed;
	const bool good = number(object, "cover", 1, &rocks->cover) && number(object, "k", 1, &rocks->k) && number(object, "smallest", ROCKS_LARGEST_MOST, &rocks->smallest) &&
			  number(object, "largest", ROCKS_LARGEST_MOST, &rocks->largest) && number(object, "seed", UINT32_MAX, &seed) && seed == floor(seed) && rocks_good(rocks);
	rocks->seed = good ? (uint32_t)seed : 0;
	return good;
}

bool rocks_parse(const char *text, struct relief_spec *relief, struct rocks_spec *rocks)
{
	*relief = (struct relief_spec){0};
	*rocks = (struct rocks_spec){0};
	cJSON *root = strlen(text) <= TEXT_MOST ? cJSON_Parse(text) : NULL;
	cJSON *object = cJSON_DetachItemFromObjectCaseSensitive(root, "rocks");
	bool good = cJSON_IsObject(root) && (object == NULL || parse(object, rocks));
	if (good && (object == NULL || root->child != NULL)) {
		char *rest = cJSON_PrintUnformatted(root);
		good = rest != NULL && relief_parse(rest, relief);
		cJSON_free(rest);
	}
	cJSON_Delete(object);
	cJSON_Delete(root);
	return good;
}
