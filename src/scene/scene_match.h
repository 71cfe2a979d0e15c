/*
 * Does the tree say only what the schema knows? Keys, types, ranges and the words of enumerations,
 * in the order of the text, so that the first mistake in the file is the one that is told.
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
