/*
 * run: turns the crank. A checked scene and a store become steps, epochs, pictures and run.json.
 */
#ifndef FURROW_RUN_H
#define FURROW_RUN_H

#include <signal.h>
#include <stdint.h>

#include "base/base.h"
#include "scene/scene.h"

struct run_params {
	const struct scene *scene;
	const char *store;     /* path; overrides the scene's; may be NULL if that names one */
	const char *overlay;   /* path of what keeps the deformation instead of the store; made if absent. May be NULL */
	const char *directory; /* made if absent: run.json, epochs.log, frame-*.png */
	const char *trace;     /* path: every access to the page cache goes there, as page/page.h says. May be NULL */
	int64_t steps;         /* 0: until end_time */
	bool durable_full;
	bool progress;         /* a line on stderr */
	const volatile sig_atomic_t *stop; /* becomes non-zero: end cleanly, STATUS_INTERRUPTED. May be NULL */
};

struct run_object {
	double distance, sinkage; /* m travelled; m under the base at the end */
	uint64_t skipped;         /* stations without contact: outside, or nodata */
};

struct run_result {
	const char *ended; /* "complete", "interrupted", "failed" */
	int64_t steps;
	double seconds, rtf;
	char *json; /* what run.json holds; free with mem_free */
};

/* run.json and the trace are written however it ends, once it began: a drive that cannot begin leaves nothing. */
enum status run_drive(const struct run_params *params, struct run_result *result) FURROW_CHECKED;

#endif
