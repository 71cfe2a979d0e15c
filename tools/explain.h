/* furrow explain: what both of its outputs share. */
#ifndef FURROW_TOOLS_EXPLAIN_H
#define FURROW_TOOLS_EXPLAIN_H

#include "api/api.h"

/* Why a line is there: what of the scene calls for it, or that every drive has it. */
void explain_reason(const struct scene *scene, const char *effect, char *text, size_t size);

/* The same as a tree that a person reads, at most 100 columns where names allow it. */
void explain_text(const struct scene *scene, const struct report_plan *plan);
enum status explain_json(const struct scene *scene, const struct report_plan *plan) FURROW_CHECKED;

#endif
