/* Functions that report errors in a scene. Each message is one line: "FILE:LINE:COLUMN: KEY: WHY; WHAT IS ALLOWED". */
#ifndef FURROW_SCENE_ERROR_H
#define FURROW_SCENE_ERROR_H

#include "scene/scene_tree.h"

/* Sets the error message for `node` and returns STATUS_INPUT. The format gives "WHY; WHAT IS ALLOWED". */
enum status scene_error(const char *file, const struct scene_node *node, const char *format, ...)
	FURROW_PRINTF(3, 4);

/* A value of a scene as a message shows it: in quotes, on one line, cut after 40 bytes. */
struct scene_quote {
	char text[64];
};
struct scene_quote scene_quote(const char *text);

/* The text "FILE:LINE:COLUMN: KEY: "VALUE"". It begins messages about a file that the scene names at `node`. */
struct scene_told {
	char text[300];
};
struct scene_told scene_told(const char *file, const struct scene_node *node, const char *value);

/* A list "a, b, c" to which words are added one by one. Words that do not fit are left out. */
struct scene_list {
	char text[320];
	size_t length;
};
void scene_list_add(struct scene_list *list, const char *word);

#endif
