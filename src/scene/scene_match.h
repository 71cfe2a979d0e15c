/*
 * Checks that the tree has only what the schema knows: keys, types, ranges and the words of enumerations. It checks in the order
 * of the text, so the error names the first mistake in the file.
 */
#ifndef FURROW_SCENE_MATCH_H
#define FURROW_SCENE_MATCH_H

#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

enum status scene_match(const struct scene_tree *tree) FURROW_CHECKED;

/* A decimal number, `whole` without a point: no hexadecimal, no infinity by name, no leading zero
 * of an octal. False if the text is none. Out of a double's range it is infinite, or zero. */
bool scene_number_read(const char *text, bool whole, double *value);

#endif
