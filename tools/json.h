/* What the commands share over base/json.h: pairs of numbers, one object on stdout. */
#ifndef FURROW_TOOLS_JSON_H
#define FURROW_TOOLS_JSON_H

#include "base/base.h"
#include "base/json.h"

void json_pair(cJSON *object, const char *name, double a, double b);
/* Prints and deletes; `object` may be NULL (out of memory). */
enum status json_print(cJSON *object) FURROW_CHECKED;

#endif
