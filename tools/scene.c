/* furrow scene: the reference of a scene's keys, from the table by which scenes are read. */
#include <string.h>

#include "base/nearest.h"
#include "command.h"
#include "scene_cells.h"

static const struct command_option options[] = {
	{"schema", .help = "print a JSON Schema of scenes, by which editors complete and check them"},
	{"tables", .help = "print the tables of src/scene/SCENE.md", .instead = true},
	{"json", .help = "one JSON object: every key, or those that are named", .instead = true},
	{.name = NULL},
};

/* "N/m, above 0 .. 1000; default: none; since 0.2.0" */
static void print_facts(const char *path, const struct scene_row *row)
{
	const char *unit = row->unit != NULL ? row->unit : "";
	const struct scene_cell range = scene_cell_plain(scene_cell_range(row).text), effects = scene_cell_plain(scene_cell_effects(path).text);
	printf("    %s%s%s%s%s", scene_cell_type(row).text, range.text[0] != '\0' ? ", " : "", range.text, unit[0] != '\0' ? " " : "", unit);
	printf("; %s%s; since %s\n", row->has_default || row->otherwise != NULL ? "default: " : "", scene_cell_default(row).text, row->since);
	if (row->text != NULL)
		printf("    %s\n", scene_cell_plain(row->text).text);
	if (effects.text[0] != '\0')
		printf("    effects: %s\n", effects.text);
}

/* What is asked for: a key and those below it, or each key of that name, wherever it stands. */
struct asked {
	const char *path; /* "": all */
	const char *name; /* NULL: by the path */
	cJSON *array;     /* NULL: as text */
	size_t found;
};

static bool is_asked(const struct asked *asked, const char *path, const struct scene_row *row)
{
	const size_t length = asked->name == NULL ? strlen(asked->path) : 0;
	if (asked->name != NULL)
		return strcmp(asked->name, row->key) == 0;
	return strncmp(path, asked->path, length) == 0 && (length == 0 || strchr(".[", path[length]) != NULL); /* '\0' ends both */
}

static void add_row(cJSON *array, const char *path, const struct scene_row *row)
{
	const bool number = row->type == ROW_NUMBER || row->type == ROW_WHOLE;
	cJSON *object = cJSON_CreateObject();
	cJSON_AddItemToArray(array, object);
	cJSON_AddStringToObject(object, "key", path);
	cJSON_AddStringToObject(object, "type", scene_cell_type(row).text);
	json_string(object, "unit", row->unit);
	if (number) {
		json_pair(object, "range", row->low, row->high);
		cJSON_AddBoolToObject(object, "above", row->above);
	}
	cJSON *words = row->words != NULL ? cJSON_AddArrayToObject(object, "words") : NULL;
	for (const struct scene_word *word = row->words; word != NULL && word->word != NULL; word++)
		cJSON_AddItemToArray(words, cJSON_CreateString(word->word));
	cJSON_AddBoolToObject(object, "needed", row->needed || row->command);
	if (row->has_default)
		cJSON_AddNumberToObject(object, "default", row->absent);
	else
		json_string(object, "default", row->otherwise);
	json_string(object, "needs", row->needs);
	json_string(object, "text", row->text);
	cJSON_AddStringToObject(object, "since", row->since);
}

static enum status tell_row(void *user, const char *path, const struct scene_row *row)
{
	struct asked *asked = user;
	if (!is_asked(asked, path, row))
		return STATUS_OK;
	asked->found++;
	if (asked->array != NULL) {
		add_row(asked->array, path, row);
		return STATUS_OK;
	}
	printf("%s\n", path);
	print_facts(path, row);
	return STATUS_OK;
}

/* --- keys that are named --- */

struct search {
	struct nearest nearest;
	char paths[512][160]; /* nearest keeps what it is offered */
	size_t count;
};

static enum status offer(void *user, const char *path, const struct scene_row *row)
{
	struct search *search = user;
	if (search->count == sizeof search->paths / sizeof *search->paths)
		return STATUS_OK;
	char *kept = search->paths[search->count++];
	snprintf(kept, sizeof *search->paths, "%s", path);
	nearest_offer(&search->nearest, kept);
	nearest_offer(&search->nearest, row->key);
	return STATUS_OK;
}

static enum status unknown(const char *key)
{
	static struct search search;
	search.count = 0;
	search.nearest = nearest_begin(key);
	TRY(scene_row_visit(offer, &search));
	return fail_with(STATUS_USAGE, "scene: %.100s: is no key of a scene; furrow scene lists all%s", key, nearest_ask(&search.nearest).text);
}

/* Tells a key and those below it, or the keys of that name. */
static enum status tell_key(const char *key, cJSON *array)
{
	struct scene_cell path = {""};
	struct asked asked = {.path = "", .array = array};
	const struct scene_row *row = key != NULL ? scene_cell_find(key, &path) : NULL;
	asked.name = row == NULL ? key : NULL;
	asked.path = path.text;
	TRY(scene_row_visit(tell_row, &asked));
	if (asked.found == 0 && row != NULL) /* rows of a soil are visited below the first */
		TRY(tell_row(&asked, path.text, row));
	return asked.found > 0 ? STATUS_OK : unknown(key);
}

static enum status tell_keys(const struct arguments *arguments, bool json)
{
	const size_t count = arguments_count(arguments);
	cJSON *root = json ? cJSON_CreateObject() : NULL, *array = json ? cJSON_AddArrayToObject(root, "keys") : NULL;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < (count > 0 ? count : 1); i++)
		TRY_OR(failed, tell_key(count > 0 ? arguments_at(arguments, i) : NULL, array));
	return json ? json_print(root) : STATUS_OK;
failed:
	cJSON_Delete(root);
	return status;
}

static enum status run(const struct arguments *arguments)
{
	if (arguments_flag(arguments, "schema"))
		return json_print(scene_editor_schema());
	if (arguments_flag(arguments, "tables"))
		return scene_tables_print(stdout);
	return tell_keys(arguments, arguments_flag(arguments, "json"));
}

const struct command command_scene = {
	.name = "scene",
	.summary = "what a scene may say: its keys, their ranges, units and defaults",
	.arguments = COMMAND_ARGUMENTS({"KEY", .help = "a key, as in soil.cohesion or objects.sink, with all below it; or the last part of keys, as in friction_angle", .repeats = true}),
	.options = options,
	.details = "Prints the reference of a scene's keys, from the table by which scenes are read and checked. Without KEY it prints all.\n"
		   "\n"
		   "An editor that knows JSON Schema completes keys, shows what they do, and marks mistakes: write the schema to a file, and name it in the scene's first line.\n"
		   "\n"
		   "    # yaml-language-server: $schema=scene.schema.json\n"
		   "\n"
		   "The schema knows keys, types, ranges and words. What concerns several keys together is checked by furrow explain alone.\n",
	.examples = "furrow scene soil.cohesion\n"
		    "furrow scene objects.shape.wheel\n"
		    "furrow scene --schema > scene.schema.json\n",
	.see = "furrow-explain(1), scene(5)",
	.run = run,
};
