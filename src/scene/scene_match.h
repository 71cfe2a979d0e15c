/*
 * Checks that the tree has only what the schema knows: keys, types, ranges and the words of enumerations. It checks in the order
 * of the text, so the error names the first mistake in the file.
 */
#ifndef FURROW_SCENE_MATCH_H
#define FURROW_SCENE_MATCH_H

#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

enum status scene_match(const struct scene_tree *tree) FURROW_CHECKED;

/* Reads a decimal number; if `whole`, one without a point. Hexadecimal, infinity by name, and a leading zero as in an octal
 * number are not allowed. Returns false if the text is not such a number. A number beyond a double's range becomes infinite or
 * zero. */
bool scene_number_read(const char *text, bool whole, double *value);

#endif
