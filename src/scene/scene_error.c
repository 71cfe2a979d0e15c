/* Writes error messages about a scene: the place, the key and the reason. */
#include "scene/scene_error.h"

#include <stdio.h>
#include <string.h>

enum status scene_error(const char *file, const struct scene_node *node, const char *format, ...)
{
	char why[400], path[160];
	va_list args;
	va_start(args, format);
	vsnprintf(why, sizeof why, format, args);
	va_end(args);
	scene_node_path(node, false, path, sizeof path);
	const char *colon = path[0] == '\0' ? "" : ": ";
	if (node->setting != NULL)
		return fail_with(STATUS_INPUT, "%s: --set %s: %s%s%s", file, node->setting, path,
				 colon, why);
	return fail_with(STATUS_INPUT, "%s:%d:%d: %s%s%s", file, node->place.line, node->place.column, path, colon, why);
}

struct scene_quote scene_quote(const char *text)
{
	struct scene_quote quote;
	size_t length = 0;
	quote.text[length++] = '"';
	size_t taken = 0;
	for (; text[taken] != '\0' && taken < 40; taken++) {
		unsigned char c = (unsigned char)text[taken];
		quote.text[length++] = c < 0x20 || c == 0x7f ? ' ' : (char)c;
	}
	/* A cut within a UTF-8 character takes the whole character away. */
	if (text[taken] != '\0')
		while (length > 1 && ((unsigned char)text[taken] & 0xc0) == 0x80) {
			taken--;
			length--;
		}
	if (text[taken] != '\0') {
		memcpy(quote.text + length, "...", 3);
		length += 3;
	}
	quote.text[length++] = '"';
	quote.text[length] = '\0';
	return quote;
}

struct scene_told scene_told(const char *file, const struct scene_node *node, const char *value)
{
	struct scene_told told;
	char path[80];
	scene_node_path(node, false, path, sizeof path);
	if (node->setting != NULL)
		snprintf(told.text, sizeof told.text, "%.100s: --set %.40s: %s: %s", file, node->setting, path,
			 scene_quote(value).text);
	else
		snprintf(told.text, sizeof told.text, "%.120s:%d:%d: %s: %s", file, node->place.line, node->place.column, path,
			 scene_quote(value).text);
	return told;
}

void scene_list_add(struct scene_list *list, const char *word)
{
	int written = snprintf(list->text + list->length, sizeof list->text - list->length, "%s%s",
			       list->length == 0 ? "" : ", ", word);
	list->length += (size_t)written;
	if (list->length >= sizeof list->text)
		list->length = sizeof list->text - 1;
}
