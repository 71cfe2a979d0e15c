/* What the commands share over cJSON: whole 64-bit numbers, NaN as null, one object on stdout. */
#ifndef FURROW_TOOLS_JSON_H
#define FURROW_TOOLS_JSON_H

#include <cJSON.h>

#include "base/base.h"

/* A failed allocation inside any of these shows as NULL and is caught by json_print. */
void json_integer(cJSON *object, const char *name, int64_t value);
void json_metres(cJSON *object, const char *name, double value); /* null if not finite */
void json_pair(cJSON *object, const char *name, double a, double b);
/* Prints and deletes; `object` may be NULL (out of memory). */
enum status json_print(cJSON *object) FURROW_CHECKED;

#endif
