/* The one line that says what is wrong with a scene: "FILE:LINE: KEY: WHY; WHAT IS ALLOWED". */
#ifndef FURROW_SCENE_ERROR_H
#define FURROW_SCENE_ERROR_H

#include "scene/scene_tree.h"

/* STATUS_INPUT at `node`; the format gives "WHY; WHAT IS ALLOWED". */
enum status scene_error(const char *file, const struct scene_node *node, const char *format, ...)
	FURROW_PRINTF(3, 4);

/* A value as it may stand in a message: quoted, on one line, cut to its first 40 bytes. */
struct scene_quote {
	char text[64];
};
struct scene_quote scene_quote(const char *text);

/* "FILE:LINE: KEY: "VALUE"", for messages about a file that the scene names at `node`. */
struct scene_told {
	char text[300];
};
struct scene_told scene_told(const char *file, const struct scene_node *node, const char *value);

/* A list "a, b, c" under construction; what does not fit is cut. */
struct scene_list {
	char text[320];
	size_t length;
};
void scene_list_add(struct scene_list *list, const char *word);

#endif
