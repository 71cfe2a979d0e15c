/* furrow explain: what both of its outputs share. */
#ifndef FURROW_TOOLS_EXPLAIN_H
#define FURROW_TOOLS_EXPLAIN_H

#include <cJSON.h>

#include "drive/drive.h"

/* Why a line is there: what of the scene calls for it, or that every drive has it. */
void explain_reason(const struct scene *scene, const char *effect, char *text, size_t size);

/* explain_cameras.c: what each camera writes, and what it costs. */
void explain_sun_text(const struct report_plan *plan); /* where the sun of pictures is */
void explain_cameras_text(const struct scene *scene, const struct report_plan *plan);
void explain_cameras_json(cJSON *root, const struct scene *scene, const struct report_plan *plan);

/* explain_vehicles.c */
void explain_soils_text(const struct scene *scene, const struct report_plan *plan);
void explain_vehicles_text(const struct report_plan *plan);
void explain_geom(const struct soil_shape *shape, char *text, size_t size); /* "wheel, radius 0.4 m, width 0.2 m" */
/* As scene_soil_number; NAN also for a number that the scene's model does not read. */
bool explain_number(const struct scene *scene, int soil, size_t index, const char **key, double *value);
const char *explain_number_from(const struct scene *scene, int soil, const char *key); /* "scene", "name" or "default", also of what comes of other numbers */

/* explain_laws.c: by which law the soil presses on the parts of each body, and what the spacing costs there */
void explain_laws_text(const struct scene *scene, const struct report_plan *plan);
void explain_laws_json(cJSON *root, const struct scene *scene, const struct report_plan *plan);

/* explain_beside.c: soil aboard bodies and in the air, marks on the ground, and what they cost */
void explain_beside_text(const struct scene *scene, const struct report_plan *plan);

/* explain_passes.c */
bool explain_same_effect(const struct plan_line *a, const struct plan_line *b);
size_t explain_count(const struct plan *plan, enum plan_kind kind); /* lines of that kind */
const char *explain_each_of(enum plan_unit unit);        /* what stands after an amount: "a window" */
void explain_bodies_text(const struct scene *scene, const struct report_plan *plan); /* bodies, and the sums of passes */
void explain_passes_text(const struct scene *scene, const struct report_plan *plan);

/* explain_all.c: what only --all shows */
void explain_effects_text(const struct scene *scene, const struct report_plan *plan);
void explain_planes_text(const struct scene *scene, const struct report_plan *plan);
void explain_programs_text(const struct scene *scene, const struct plan *plan);
void explain_threads_text(const struct scene *scene, const struct plan *plan);
void explain_tables_text(const struct scene *scene, const struct plan *plan);
bool explain_is_memory(const struct plan_line *line); /* a texture or a buffer */
void explain_bytes_text(const struct scene *scene, const struct plan *plan); /* of textures and buffers */
void explain_not_run_text(const struct report_plan *plan);

/* The same for a person, at most 100 columns where names allow it. `all`: with all that explain_all.c shows. */
void explain_text(const struct scene *scene, const struct report_plan *plan, bool all);
enum status explain_json(const struct scene *scene, const struct report_plan *plan) FURROW_CHECKED;

#endif
