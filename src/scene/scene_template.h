/*
 * Writes out objects that are given once for many places:
 *
 *     objects:
 *       - template: {name: wheel, shape: ..., path: ...}      # or a list of objects, such as the wheels of a car
 *         at: [[0, 0], [0, 5], [12, 0, 90]]                   # east, north in m; degrees from east to north
 *         every: 4                                            # s: each copy starts this much later than the one before
 *
 * `at` may be a grid: {rows: 10, columns: 100, step: [3, 5], from: [10, 10]}. `objects` may be such a mapping alone, without a list.
 * Copies take the template's place in the tree. They are named NAME-1, NAME-2, ... with path.offset, path.rotate and path.delay
 * changed. A path that follows another object of its template (relative_to) follows the copy of it, and is not moved itself.
 */
#ifndef FURROW_SCENE_TEMPLATE_H
#define FURROW_SCENE_TEMPLATE_H

#include "scene/scene_tree.h"

#define SCENE_OBJECTS 4096 /* the most objects of a scene */

/* Replaces each template in `objects` by its copies. STATUS_INPUT: a template is wrong; the message says where. */
enum status scene_template(const struct scene_tree *tree) FURROW_CHECKED;

#endif
