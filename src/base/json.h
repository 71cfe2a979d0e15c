/*
 * Functions that cJSON lacks: whole 64-bit numbers, and null for numbers that are not finite and for texts that are not there. A failed allocation leaves the
 * key out, as with cJSON's own functions. Not part of base.h.
 */
#ifndef FURROW_BASE_JSON_H
#define FURROW_BASE_JSON_H

#include <cJSON.h>
#include <stddef.h>
#include <stdint.h>

void json_integer(cJSON *object, const char *name, int64_t value);
/* Prints JSON without characters that move a terminal's cursor: each is written as \\u and its number. Returns a text to be freed with cJSON_free; NULL:
 * out of memory. */
char *json_text(const cJSON *root);
void json_number(cJSON *object, const char *name, double value); /* null if not finite */
void json_numbers(cJSON *object, const char *name, const double *numbers, size_t count); /* null for one that is not finite */
void json_string(cJSON *object, const char *name, const char *text); /* null if NULL */

#endif
