/* The text of a relief: {"roughness":0.02,"wavelength":2,"seed":7}. With classes: {"seed":7,"map":"HEX","classes":[{...}, ...]}. */
#include <cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/relief.h"

enum { HEX = 32, TEXT_MOST = 4096 };

static bool print_waves(cJSON *object, const struct relief_waves *waves)
{
	return cJSON_AddNumberToObject(object, "roughness", waves->roughness) != NULL &&
	       cJSON_AddNumberToObject(object, "wavelength", waves->wavelength) != NULL;
}

static bool print_classes(cJSON *root, const struct relief_spec *spec)
{
	char hex[HEX + 1];
	snprintf(hex, sizeof hex, "%016llx%016llx", (unsigned long long)spec->map[0], (unsigned long long)spec->map[1]);
	cJSON *list = NULL;
	bool good = cJSON_AddStringToObject(root, "map", hex) != NULL && (list = cJSON_AddArrayToObject(root, "classes")) != NULL;
	for (int i = 0; i < spec->classes && good; i++) {
		cJSON *one = cJSON_CreateObject();
		good = one != NULL && cJSON_AddItemToArray(list, one) && print_waves(one, &spec->waves[i]);
	}
	return good;
}

char *relief_print(const struct relief_spec *spec)
{
	cJSON *root = cJSON_CreateObject();
	bool good = root != NULL && (spec->classes > 1 || print_waves(root, &spec->waves[0])) &&
		    cJSON_AddNumberToObject(root, "seed", spec->seed) != NULL && (spec->classes <= 1 || print_classes(root, spec));
	char *text = good ? cJSON_PrintUnformatted(root) : NULL, *copy = text != NULL ? mem_strdup(text) : NULL;
	cJSON_free(text);
	cJSON_Delete(root);
	return copy;
}

static bool number(const cJSON *object, const char *key, double low, double high, double *value)
{
	const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
	*value = cJSON_IsNumber(item) ? item->valuedouble : NAN;
	return *value >= low && *value <= high;
}

static bool parse_waves(const cJSON *object, struct relief_waves *waves)
{
	return number(object, "roughness", 0, RELIEF_ROUGHNESS_MOST, &waves->roughness) &&
	       number(object, "wavelength", 0, 1e9, &waves->wavelength) && waves->wavelength > 0;
}

static bool parse_classes(const cJSON *root, struct relief_spec *spec)
{
	const cJSON *map = cJSON_GetObjectItemCaseSensitive(root, "map"), *list = cJSON_GetObjectItemCaseSensitive(root, "classes"), *one;
	unsigned long long words[2];
	int end = 0;
	if (!cJSON_IsString(map) || strlen(map->valuestring) != HEX ||
	    sscanf(map->valuestring, "%16llx%16llx%n", &words[0], &words[1], &end) != 2 || end != HEX)
		return false;
	spec->map[0] = words[0];
	spec->map[1] = words[1];
	bool good = cJSON_IsArray(list);
	cJSON_ArrayForEach(one, list) {
		good = good && spec->classes < RELIEF_CLASSES && parse_waves(one, &spec->waves[spec->classes]);
		spec->classes += good;
	}
	return good && spec->classes > 1;
}

bool relief_parse(const char *text, struct relief_spec *spec)
{
	double seed = 0;
	*spec = (struct relief_spec){0};
	cJSON *root = strlen(text) <= TEXT_MOST ? cJSON_Parse(text) : NULL;
	bool good = cJSON_IsObject(root) && number(root, "seed", 0, UINT32_MAX, &seed) && seed == floor(seed);
	spec->seed = good ? (uint32_t)seed : 0;
	if (good && cJSON_GetObjectItemCaseSensitive(root, "classes") == NULL) {
		good = parse_waves(root, &spec->waves[0]);
		spec->classes = 1;
	} else if (good) {
		good = parse_classes(root, spec);
	}
	cJSON_Delete(root);
	return good;
}
