/* furrow explain: what both of its outputs share. */
#ifndef FURROW_TOOLS_EXPLAIN_H
#define FURROW_TOOLS_EXPLAIN_H

#include <cJSON.h>

#include "api/api.h"

/* Why a line is there: what of the scene calls for it, or that every drive has it. */
void explain_reason(const struct scene *scene, const char *effect, char *text, size_t size);

/* explain_cameras.c: what each camera writes, and what it costs. */
void explain_sun_text(const struct report_plan *plan); /* where the sun of pictures is */
void explain_cameras_text(const struct scene *scene, const struct report_plan *plan);
void explain_cameras_json(cJSON *root, const struct scene *scene, const struct report_plan *plan);

/* The same as a tree that a person reads, at most 100 columns where names allow it. */
void explain_text(const struct scene *scene, const struct report_plan *plan);
enum status explain_json(const struct scene *scene, const struct report_plan *plan) FURROW_CHECKED;

#endif
