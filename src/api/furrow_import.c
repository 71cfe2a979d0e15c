/* furrow.h: elevation data to a store. */
#include "api/library.h"

#include <string.h>
#include <yaml.h>

#include "intake/intake.h"

struct telling {
	bool (*progress)(double share, void *user);
	void *user;
	const char *store;
};

static enum status tell(void *user, int64_t done, int64_t total)
{
	const struct telling *telling = user;
	if (telling->progress == NULL)
		return STATUS_OK;
	const locale_t locale = api_library_to_host();
	const bool goes_on = telling->progress(total > 0 ? (double)done / (double)total : 1, telling->user);
	api_library_from_host(locale);
	if (goes_on)
		return STATUS_OK;
	return fail_with(STATUS_INTERRUPTED, "%s: stopped; the same call with {resume: true} goes on", telling->store);
}

/* --- options: a mapping of scalars, or of lists of them --- */

static enum status off(const yaml_node_t *node, const char *why)
{
	return fail_with(STATUS_USAGE, "options: line %zu: %s; give a mapping of the command's long names, as in {max_error: 0.01}",
			 node != NULL ? node->start_mark.line + 1 : 1, why);
}

static enum status take(struct import *import, const char *name, const yaml_node_t *value)
{
	if (value == NULL || value->type != YAML_SCALAR_NODE)
		return off(value, "a value is no number, word or text");
	return intake_import_option(import, name, (const char *)value->data.scalar.value);
}

static enum status take_list(struct import *import, yaml_document_t *document, const char *name, const yaml_node_t *list)
{
	const enum import_list kind = intake_import_list(name);
	char joined[128] = "";
	if (kind == IMPORT_NO_LIST && intake_import_has_option(name))
		return fail_with(STATUS_USAGE, "options: line %zu: %s is a list; give one value", list->start_mark.line + 1, name);
	for (const yaml_node_item_t *item = list->data.sequence.items.start; item < list->data.sequence.items.top; item++) {
		const yaml_node_t *one = yaml_document_get_node(document, *item);
		const size_t used = strlen(joined);
		if (kind == IMPORT_EACH)
			TRY(take(import, name, one));
		else if (one == NULL || one->type != YAML_SCALAR_NODE)
			return off(one, "a value is no number");
		else
			snprintf(joined + used, sizeof joined - used, "%s%s", used > 0 ? "," : "", (const char *)one->data.scalar.value);
	}
	return kind != IMPORT_EACH ? intake_import_option(import, name, joined) : STATUS_OK;
}

static enum status take_pair(struct import *import, yaml_document_t *document, const yaml_node_pair_t *pair)
{
	const yaml_node_t *key = yaml_document_get_node(document, pair->key), *value = yaml_document_get_node(document, pair->value);
	if (key == NULL || key->type != YAML_SCALAR_NODE)
		return off(key, "a name is no text");
	const char *name = (const char *)key->data.scalar.value;
	if (value != NULL && value->type == YAML_SEQUENCE_NODE)
		return take_list(import, document, name, value);
	return take(import, name, value);
}

static enum status take_document(struct import *import, yaml_document_t *document)
{
	const yaml_node_t *root = yaml_document_get_root_node(document);
	if (root == NULL)
		return STATUS_OK;
	if (root->type != YAML_MAPPING_NODE)
		return off(root, "it is no mapping");
	for (const yaml_node_pair_t *pair = root->data.mapping.pairs.start; pair < root->data.mapping.pairs.top; pair++)
		TRY(take_pair(import, document, pair));
	return STATUS_OK;
}

static enum status read_options(struct import *import, const char *text)
{
	yaml_parser_t parser;
	yaml_document_t document;
	if (text == NULL)
		return STATUS_OK;
	if (!yaml_parser_initialize(&parser))
		return fail_memory("options");
	yaml_parser_set_input_string(&parser, (const unsigned char *)text, strlen(text));
	enum status status = STATUS_OK;
	if (!yaml_parser_load(&parser, &document)) {
		status = fail_with(STATUS_USAGE, "options: line %zu: %s; give YAML, as in {max_error: 0.01}", parser.problem_mark.line + 1,
				   parser.problem != NULL ? parser.problem : "not YAML");
	} else {
		status = take_document(import, &document);
		yaml_document_delete(&document);
	}
	yaml_parser_delete(&parser);
	return status;
}

static enum status check(const char *const *sources, size_t count, const char *store, bool coloured)
{
	if (count > 0 || !coloured)
		TRY(api_library_need(sources, "sources"));
	if (count == 0 && !coloured)
		return fail_with(STATUS_USAGE, "sources: there are none; give at least one path");
	TRY(api_library_need_count(count, sizeof *sources));
	for (size_t i = 0; i < count; i++)
		TRY(api_library_need(sources[i], "a source"));
	TRY(api_library_need(store, "store"));
	return store[0] != '\0' ? STATUS_OK : fail_with(STATUS_USAGE, "store: its path is empty; give the file to make, as in world.furrow");
}

furrow_status furrow_import(const char *const *sources, size_t count, const char *store, const char *options,
			    bool (*progress)(double share, void *user), void *user)
{
	struct import import;
	struct intake made;
	struct intake_imagery coloured;
	struct telling telling = {progress, user, store};
	enum status status = api_library_begin();
	intake_import_init(&import);
	TRY_OR(done, status);
	TRY_OR(done, read_options(&import, options));
	TRY_OR(done, check(sources, count, store, import.imagery_count > 0));
	if (count == 0) {
		TRY_OR(done, intake_import_imagery(&import, store, false, tell, &telling, &coloured));
		goto done;
	}
	TRY_OR(done, intake_import_open(&import, sources, count));
	TRY_OR(done, intake_import_run(&import, store, tell, &telling, &made, &coloured));
done:
	intake_import_finish(&import);
	return api_library_end(status);
}
