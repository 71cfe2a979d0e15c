/* What import and synth say of the store that they made. */
#ifndef FURROW_TOOLS_MADE_H
#define FURROW_TOOLS_MADE_H

#include "intake/intake.h"
#include "json.h"

/* What an import of imagery made, or would make. */
void print_imagery(const struct intake_imagery *made);
void imagery_json(cJSON *object, const struct intake_imagery *made);
void print_made(const struct intake *made); /* on stdout: posts, spacing, bytes, speed */

#endif
