/* What the benches share: a folder, a synthetic store, a drive from a scene's text, one figure of it. */
#ifndef FURROW_BENCH_H
#define FURROW_BENCH_H

#include <stdint.h>

#include "base/base.h"
#include "dem/dem.h"
#include "scene/scene.h"

/* Ends the program with the message if the status is not STATUS_OK. */
void bench_must(enum status status);
/* A folder of this run's own, removed at exit; `name` within it (static storage, a few at a time). */
const char *bench_path(const char *name);
void bench_store(const char *path, const struct dem_synth *synth, uint32_t cells);
/* run.json of driving `scene` (YAML text) over a store. Freed with mem_free. */
char *bench_drive(const char *scene, const char *store);
/* The same with somebody who looks at a picture after each step. */
char *bench_watch(const char *scene, const char *store);
/* The number at a path of names parted by dots, as in "fps.mean". NaN if it is null. */
double bench_figure(const char *json, const char *path);
/* The renderer's name of that run. Static storage. */
const char *bench_renderer(const char *json);
double bench_median(double *values, size_t count); /* sorts them */

#endif
