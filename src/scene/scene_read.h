/*
 * Reads the tree into typed values by the table of keys (scene_row.h), and checks it on the way: keys, types, ranges and words. It
 * goes in the order of the text, so the error names the first mistake in the file.
 */
#ifndef FURROW_SCENE_READ_H
#define FURROW_SCENE_READ_H

#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

/* Free *out with scene_raw_destroy. NULL on failure. */
enum status scene_read(const struct scene_tree *tree, struct raw_scene **out) FURROW_CHECKED;
void scene_raw_destroy(struct raw_scene *raw); /* takes NULL */

/* Reads a decimal number; if `whole`, one without a point. Hexadecimal, infinity by name, and a leading zero as in an octal
 * number are not allowed. Returns false if the text is not such a number. A number beyond a double's range becomes infinite or
 * zero. */
bool scene_number_read(const char *text, bool whole, double *value);

#endif
