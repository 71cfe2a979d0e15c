/*
 * JSON Schema (draft 2020-12) of a scene for editors of YAML, from the table of its keys. It takes what the reader takes: short forms and former names
 * too, which are marked as deprecated. It knows no rule that concerns several keys together.
 */
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_alias.h"
#include "scene_cells.h"

static cJSON *schema_of(const struct scene_row *row, const char *path);

static cJSON *of_type(const char *type)
{
	cJSON *schema = cJSON_CreateObject();
	cJSON_AddStringToObject(schema, "type", type);
	return schema;
}

static cJSON *either(cJSON *one, cJSON *other)
{
	cJSON *schema = cJSON_CreateObject(), *of = cJSON_AddArrayToObject(schema, "anyOf");
	cJSON_AddItemToArray(of, one);
	cJSON_AddItemToArray(of, other);
	return schema;
}

static cJSON *list_of(cJSON *items, uint32_t least, uint32_t most)
{
	cJSON *schema = of_type("array");
	cJSON_AddItemToObject(schema, "items", items);
	cJSON_AddNumberToObject(schema, "minItems", least);
	if (most != ENDLESS)
		cJSON_AddNumberToObject(schema, "maxItems", most);
	return schema;
}

/* What the key does, its unit, default and version. */
static void describe(cJSON *schema, const struct scene_row *row)
{
	const char *does = row->text != NULL ? row->text : "", *unit = row->unit;
	char told[2000];
	snprintf(told, sizeof told, "%s%s%s%s%s%s%s. Since %s.", scene_cell_plain(does).text, does[0] != '\0' ? ". " : "", unit != NULL ? "Unit: " : "",
		 unit != NULL ? unit : "", unit != NULL ? ". " : "", row->has_default || row->otherwise != NULL ? "Default: " : "", scene_cell_default(row).text, row->since);
	cJSON_AddStringToObject(schema, "description", told);
	if (row->has_default)
		cJSON_AddNumberToObject(schema, "default", row->absent);
}

/* --- single values --- */

static cJSON *number(const struct scene_row *row)
{
	cJSON *schema = of_type(row->type == ROW_WHOLE ? "integer" : "number");
	cJSON_AddNumberToObject(schema, row->above ? "exclusiveMinimum" : "minimum", row->low);
	cJSON_AddNumberToObject(schema, "maximum", row->high);
	return schema;
}

/* A number or a date is a text as well, where a text is due. */
static cJSON *text(const struct scene_row *row)
{
	cJSON *words = of_type("string");
	cJSON_AddNumberToObject(words, "minLength", 1);
	cJSON_AddNumberToObject(words, "maxLength", row->longest);
	return either(words, of_type("number"));
}

static cJSON *words(const struct scene_row *row, const char *path)
{
	struct scene_former former;
	cJSON *schema = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(schema, "enum");
	for (const struct scene_word *word = row->words; word->word != NULL; word++)
		cJSON_AddItemToArray(list, cJSON_CreateString(word->word));
	for (size_t i = 0; scene_alias_at(i, &former); i++)
		if (former.where != NULL && strcmp(former.where, path) == 0)
			cJSON_AddItemToArray(list, cJSON_CreateString(former.former));
	return schema;
}

/* Words that a list of texts takes are checked beyond the table. */
static cJSON *listed_words(const char *path)
{
	cJSON *schema = cJSON_CreateObject(), *list = cJSON_CreateArray();
	for (int e = 0; e < EFFECT_COUNT && strcmp(path, "view.effects") == 0; e++)
		if (strcmp(scene_effect_row((enum scene_effect)e)->key, path) == 0)
			cJSON_AddItemToArray(list, cJSON_CreateString(scene_effect_row((enum scene_effect)e)->name));
	for (int i = 0; i < SCENE_IMAGES && strcmp(path, "cameras[].images") == 0; i++)
		cJSON_AddItemToArray(list, cJSON_CreateString(scene_image_name((enum scene_image)i)));
	for (int i = 0; i < SCENE_STOPS && strcmp(path, "stop") == 0; i++)
		cJSON_AddItemToArray(list, cJSON_CreateString(scene_stop_name((enum scene_stop)i)));
	cJSON_AddItemToObject(schema, "enum", list);
	if (cJSON_GetArraySize(list) > 0)
		return schema;
	cJSON_Delete(schema);
	return NULL;
}

/* --- mappings --- */

/* A key of `rows` that stands in another mapping, too. */
static void add_key(cJSON *properties, const char *path, const char *name)
{
	struct scene_cell place;
	const struct scene_row *row = scene_cell_find(path, &place);
	if (row != NULL)
		cJSON_AddItemToObject(properties, name, schema_of(row, place.text));
}

/* Keys that the reader moves to their place. */
static void add_moved_keys(cJSON *properties, const char *path)
{
	static const char *const camera[] = {"overhead.over", "overhead.height", "fixed.eye", "fixed.target"};
	char place[80];
	for (size_t i = 0; strcmp(path, "view.camera") == 0 && i < sizeof camera / sizeof *camera; i++) {
		snprintf(place, sizeof place, "view.camera.%s", camera[i]);
		add_key(properties, place, strchr(camera[i], '.') + 1);
	}
	if (strcmp(path, "vehicles[].powertrain") == 0) {
		add_key(properties, "vehicles[].brakes", "brakes");
		cJSON *engine = cJSON_DetachItemFromObject(properties, "engine");
		cJSON *table = cJSON_Duplicate(cJSON_GetObjectItem(properties, "torque"), true);
		cJSON_AddItemToObject(properties, "engine", either(engine, table));
	}
}

static void add_former_keys(cJSON *properties, const char *path)
{
	struct scene_former former;
	for (size_t i = 0; scene_alias_at(i, &former); i++) {
		const cJSON *now = former.where != NULL && strcmp(former.where, path) == 0 ? cJSON_GetObjectItem(properties, former.name) : NULL;
		cJSON *copy = now != NULL ? cJSON_Duplicate(now, true) : NULL;
		if (copy == NULL)
			continue;
		cJSON_AddTrueToObject(copy, "deprecated");
		cJSON_AddItemToObject(properties, former.former, copy);
	}
}

/* `path`: of the mapping, with [] behind lists. `without`: a key that is not needed; NULL: none. */
static cJSON *mapping(const struct scene_row *rows, const char *path, const char *without)
{
	cJSON *schema = of_type("object"), *properties = cJSON_AddObjectToObject(schema, "properties"), *required = cJSON_CreateArray();
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	char place[160];
	while ((row = scene_rows_next(&walk)) != NULL) {
		snprintf(place, sizeof place, "%s%s%s", path, path[0] != '\0' ? "." : "", row->key);
		cJSON_AddItemToObject(properties, row->key, schema_of(row, place));
		if ((row->needed || row->command) && (without == NULL || strcmp(without, row->key) != 0))
			cJSON_AddItemToArray(required, cJSON_CreateString(row->key));
	}
	add_moved_keys(properties, path);
	add_former_keys(properties, path);
	if (cJSON_GetArraySize(required) > 0)
		cJSON_AddItemToObject(schema, "required", required);
	else
		cJSON_Delete(required);
	cJSON_AddFalseToObject(schema, "additionalProperties");
	return schema;
}

/* The rows of a soil stand in four places: they are one definition each. */
static cJSON *soil(const char *name)
{
	cJSON *schema = cJSON_CreateObject();
	cJSON_AddStringToObject(schema, "$ref", name);
	return schema;
}

static cJSON *one_mapping(const struct scene_row *row, const char *path, const char *without)
{
	bool entry;
	if (row->rows == scene_row_at("soil.default", &entry)->rows)
		return soil("#/$defs/soil");
	return row->rows == scene_row_at("soil.over", &entry)->rows ? soil("#/$defs/lower_soil") : mapping(row->rows, path, without);
}

/* Objects that are given once for many places. */
static cJSON *template_of(const char *path)
{
	static const char at[] = "{\"anyOf\": [{\"type\": \"array\", \"minItems\": 1, \"items\": {\"type\": \"array\", \"items\": {\"type\": \"number\"}, \"minItems\": 2, \"maxItems\": 3}},"
				 " {\"type\": \"object\", \"required\": [\"step\"], \"additionalProperties\": false, \"properties\": {\"rows\": {\"type\": \"integer\", \"minimum\": 1},"
				 " \"columns\": {\"type\": \"integer\", \"minimum\": 1}, \"step\": {\"type\": \"array\", \"items\": {\"type\": \"number\"}, \"minItems\": 2, \"maxItems\": 2},"
				 " \"from\": {\"type\": \"array\", \"items\": {\"type\": \"number\"}, \"minItems\": 2, \"maxItems\": 2}}}]}";
	bool entry;
	const struct scene_row *row = scene_row_at("objects", &entry);
	cJSON *schema = of_type("object"), *properties = cJSON_AddObjectToObject(schema, "properties"), *every = of_type("number");
	cJSON_AddNumberToObject(every, "minimum", 0);
	cJSON_AddNumberToObject(every, "maximum", 1e6);
	cJSON_AddStringToObject(schema, "description", "an object, or a list of them, that is given once for many places");
	cJSON_AddItemToObject(properties, "template", either(mapping(row->rows, path, NULL), list_of(mapping(row->rows, path, NULL), 1, ENDLESS)));
	cJSON_AddItemToObject(properties, "at", cJSON_Parse(at));
	cJSON_AddItemToObject(properties, "every", every);
	cJSON_AddItemToArray(cJSON_AddArrayToObject(schema, "required"), cJSON_CreateString("template"));
	cJSON_AddItemToArray(cJSON_GetObjectItem(schema, "required"), cJSON_CreateString("at"));
	cJSON_AddFalseToObject(schema, "additionalProperties");
	return schema;
}

/* A list of mappings, or a mapping whose keys stand for one key of these. */
static cJSON *mappings(const struct scene_row *row, const char *path)
{
	char items[160];
	snprintf(items, sizeof items, "%s[]", path);
	cJSON *entry = one_mapping(row, items, NULL), *alone = NULL;
	if (strcmp(path, "objects") == 0)
		entry = either(entry, template_of(items));
	cJSON *list = list_of(entry, row->least, row->most);
	if (strcmp(path, "objects") == 0)
		return either(list, template_of(items));
	if (row->named == NULL)
		return list;
	if (row->alone != NULL) {
		const struct scene_row *value = scene_row_find(row->rows, row->alone, strlen(row->alone));
		alone = schema_of(value, items);
	}
	cJSON *named = of_type("object"), *value = one_mapping(row, items, row->named);
	cJSON_AddItemToObject(named, "additionalProperties", alone != NULL ? either(value, alone) : value);
	return either(list, named);
}

static cJSON *attribute_names(const struct scene_row *row)
{
	struct scene_former former;
	cJSON *names = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(names, "enum");
	struct scene_rows walk = scene_rows_begin(row->rows);
	while ((row = scene_rows_next(&walk)) != NULL)
		if (row->type == ROW_MAPPING)
			cJSON_AddItemToArray(list, cJSON_CreateString(row->key));
	for (size_t i = 0; scene_alias_at(i, &former); i++)
		if (former.where != NULL && strcmp(former.where, "attributes[]") == 0)
			cJSON_AddItemToArray(list, cJSON_CreateString(former.former));
	return list_of(names, 0, ENDLESS);
}

/* --- a row --- */

static cJSON *value_of(const struct scene_row *row, const char *path)
{
	if (row->type == ROW_MAPPING && row->form == ROW_LIST)
		return mappings(row, path);
	if (row->type == ROW_MAPPING) {
		cJSON *schema = one_mapping(row, path, NULL);
		if (strcmp(path, "attributes") == 0)
			schema = either(schema, attribute_names(row));
		return row->alone != NULL ? either(schema, of_type("string")) : schema;
	}
	cJSON *one = row->type == ROW_TEXT ? NULL : row->type == ROW_WORD ? words(row, path) : row->type == ROW_SWITCH ? of_type("boolean") : number(row);
	if (row->type == ROW_TEXT && (one = listed_words(path)) == NULL)
		one = text(row);
	if (row->each > 0)
		one = list_of(one, row->each, row->each);
	return scene_row_lists(row) > 0 ? list_of(one, row->least, row->most) : one;
}

static cJSON *schema_of(const struct scene_row *row, const char *path)
{
	cJSON *schema = value_of(row, path);
	describe(schema, row);
	return schema;
}

cJSON *scene_editor_schema(void)
{
	bool entry;
	cJSON *schema = mapping(scene_schema, "", NULL), *defs = cJSON_AddObjectToObject(schema, "$defs");
	cJSON_AddItemToObject(defs, "soil", mapping(scene_row_at("soil.default", &entry)->rows, "soil", NULL));
	cJSON_AddItemToObject(defs, "lower_soil", mapping(scene_row_at("soil.over", &entry)->rows, "soil", NULL));
	cJSON_AddStringToObject(schema, "title", "A scene of Furrow");
	cJSON_AddStringToObject(schema, "$schema", "https://json-schema.org/draft/2020-12/schema");
	return schema;
}
