/*
 * A study: one scene that is driven many times, each time with other values of some of its keys.
 *
 *     study file -> study_read -> study_expand -> study_prepare -> study_work or study_write ->
 * study_collect
 *
 * All texts that a struct study points to live as long as the study does. One thread uses a study.
 */
#ifndef FURROW_TOOLS_STUDY_H
#define FURROW_TOOLS_STUDY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "scene/scene_tree.h"
#include "settings.h"

#define STUDY_RUNS 10000
#define STUDY_PARAMETERS 32
#define STUDY_VALUES 1000 /* of a parameter */
#define STUDY_RESULTS 64
#define STUDY_PLOTS 32

enum study_design { STUDY_GRID, STUDY_LIST, STUDY_HYPERCUBE };

/* What a study varies. */
struct study_parameter {
	const char *name;		/* as the study file and the columns of the CSV have it */
	const char *keys[SETTINGS_MAX]; /* of the scene, as --set takes them; "store": the terrain */
	size_t key_count;
	const struct scene_node *node; /* where its values are written; of a list: its first */
	const char **values;	       /* YAML; NULL if a hypercube takes them from a range */
	size_t value_count;
	double from, to; /* a hypercube's range */
	bool logarithmic, whole;
};

enum study_source { STUDY_RUN_JSON, STUDY_OBJECTS, STUDY_VEHICLES };
enum study_take { STUDY_MEAN, STUDY_MAX, STUDY_MIN, STUDY_LAST };

/* What is read from each run that is complete. */
struct study_result {
	const char *name;
	enum study_source source;
	const char *what; /* a dotted path of run.json, or a column */
	const char *of;	  /* the name of the object or vehicle */
	enum study_take take;
	double after; /* s: rows from this time on */
	const struct scene_node *node;
};

/* What the scenes of the runs have of a result; the most that one of them has. */
enum study_found {
	STUDY_NOTHING,
	STUDY_NAME, /* its object or vehicle */
	STUDY_ROWS, /* and it writes rows of it */
};

#define STUDY_NAMED 3
/* Runs that cannot begin. The first ones are named, with their values. */
struct study_refused {
	size_t count;
	char named[STUDY_NAMED][280];
	char why[1024]; /* of the first */
};

struct study_plot {
	size_t x, by; /* parameters; by: SIZE_MAX if the plot has one series */
	size_t y;     /* a result */
};

enum study_state { STUDY_WAITING, STUDY_BEGUN, STUDY_INTERRUPTED, STUDY_FAILED, STUDY_COMPLETE };

struct study_run {
	char name[40]; /* of its folder in DIR/runs: its number and the hash of its settings */
	enum study_state state;
	const char *error; /* the last line of a failed run; NULL: not known */
	double seconds;	   /* of its last drive; 0: not known */
};

struct study {
	const char *file; /* as given */
	char *folder;	  /* of the file; absolute, ends in '/' */
	char *text;	  /* of the file */
	size_t length;
	struct scene_node *root;
	const char *scene, *store; /* paths; store: NULL if the scene names it */
	enum study_design design;
	uint64_t seed;
	struct scene_setting set[SETTINGS_MAX]; /* of every run */
	size_t set_count;
	struct study_parameter *parameters;
	size_t parameter_count;
	const char **values; /* run x parameter: YAML */
	struct study_run *runs;
	size_t run_count;
	struct study_result *results;
	size_t result_count;
	struct study_plot *plots;
	size_t plot_count;
	char *directory; /* DIR, absolute; NULL before study_prepare and study_reopen */
	char *program;	 /* path of this program */
	char **texts;	 /* all that study_keep has taken */
	size_t text_count;
};

/* --- study_read.c, study_values.c, study_results.c, study_design.c --- */
/* Reads a study file of at most 1 MiB. STATUS_INPUT with the line of what is wrong. `beside`: the
 * file whose folder the paths are relative to; NULL: `path`. Destroy the study, also after a
 * failure. */
enum status study_read(const char *path, const char *beside, struct study *study) FURROW_CHECKED;
/* Reads `results` and `plots`, which name the parameters. Part of study_read. */
enum status study_read_results(struct study *study) FURROW_CHECKED;
/* Makes the values of all runs. Part of study_read. STATUS_INPUT if there are more than STUDY_RUNS.
 */
enum status study_expand(struct study *study) FURROW_CHECKED;
void study_destroy(struct study *study);
/* Takes a text that malloc made, and frees it with the study. Returns NULL if `text` is NULL or
 * memory runs out. */
const char *study_keep(struct study *study, char *text);
/* Returns a text that is the study's. NULL: memory runs out. */
const char *study_print(struct study *study, const char *format, ...) FURROW_PRINTF(2, 3);
/* Returns a parameter's value in a run. */
const char *study_value(const struct study *study, size_t run, size_t parameter);
/* STATUS_INPUT unless the node is a mapping with no other keys than `allowed`, which NULL ends. */
enum status study_only(const struct study *study, const struct scene_node *node, const char *const *allowed) FURROW_CHECKED;
/* Reads a number from low to high; leaves *value alone if `parent` has no such key. */
enum status study_number(const struct study *study, const struct scene_node *parent, const char *key, double low, double high,
			 double *value) FURROW_CHECKED;
/* Reads a text of one line that is not empty; *out is NULL if `parent` has no such key. */
enum status study_text(const struct study *study, const struct scene_node *parent, const char *key,
		       const char **out) FURROW_CHECKED;
/* Writes a node as YAML on one line. The text is the study's. */
enum status study_yaml(struct study *study, const struct scene_node *node, const char **out) FURROW_CHECKED;
/* Reads one of `names`, which NULL ends; leaves *value alone if `parent` has no such key. */
enum status study_choice(const struct study *study, const struct scene_node *parent, const char *key, const char *const *names,
			 int *value) FURROW_CHECKED;

/* --- study_runs.c, study_state.c --- */
/* Checks that each run can begin; names the runs; makes DIR and a folder with run.sh for each.
 * Finds what is complete. `collects`: nothing is to run, so what is there is not checked. */
enum status study_prepare(struct study *study, const char *directory, bool collects) FURROW_CHECKED;
/* Reads the study that DIR was last prepared for, and the names of its runs. */
enum status study_reopen(struct study *study, const char *directory) FURROW_CHECKED;
/* Fills the list of `settings`: those of every run, then the values of this one. *store: the
 * terrain; NULL: the scene names it. */
enum status study_settings(struct study *study, size_t run, struct settings *settings, const char **store) FURROW_CHECKED;
/* Makes the arguments of `furrow drive` for a run, ended by NULL. Free them with mem_free; the
 * texts are the study's. */
enum status study_arguments(struct study *study, size_t run, const char ***out) FURROW_CHECKED;
const char *study_state_name(enum study_state state);
/* Looks into a run's folder, and sets its state and seconds. */
void study_look(struct study *study, size_t run);
/* Returns the text of study.json; cJSON_free it. NULL: out of memory. */
char *study_manifest_text(const struct study *study);
/* Writes DIR/study.json: the runs, their settings and states. */
enum status study_manifest(const struct study *study) FURROW_CHECKED;
/* Writes DIR/runs/NAME/FILE into a buffer of PATH_MAX bytes, and returns it. "": the folder itself.
 */
const char *study_path(const struct study *study, size_t run, const char *file, char *path);
/* Writes a text as one word of a shell. */
void study_quote(const char *text, FILE *file);

/* --- study_check.c --- */
/* Notes that a run cannot begin, with this thread's message. */
void study_refuse(const struct study *study, struct study_refused *refused, size_t run);
/* STATUS_INPUT, with a few of the runs and how many they are, if any was refused. */
enum status study_tell_refused(const struct study *study, const struct study_refused *refused) FURROW_CHECKED;
/* Checks all that is known of a run before it begins: over its store, with its vehicles, all but what only the drive finds. Not of
 * runs that are complete. STATUS_INPUT: some cannot begin. STATUS_INTERRUPTED after Ctrl-C. */
enum status study_check_runs(struct study *study) FURROW_CHECKED;
/* Looks for what the results are read from in the scene of a run. `found`: one for each result. */
void study_seek_results(const struct study *study, const struct scene *scene, enum study_found *found);
/* STATUS_INPUT, with the line, for a result that no run can have. */
enum status study_check_sought(const struct study *study, const enum study_found *found) FURROW_CHECKED;

/* --- study_work.c, study_write.c --- */
/* Runs all that is not complete, `jobs` at once. STATUS_FAILED if a run failed, STATUS_INTERRUPTED
 * after Ctrl-C. */
enum status study_work(struct study *study, int jobs) FURROW_CHECKED;
/* Writes what a scheduler runs: 0 a Slurm array script, 1 a list for GNU parallel, 2 a Snakefile.
 * `jobs`: the most at once; 0: the scheduler's choice. */
enum status study_write(struct study *study, int kind, int jobs) FURROW_CHECKED;

/* --- study_collect.c --- */
/* Writes DIR/study.csv and the plots, and prints how many runs are complete. STATUS_INPUT if a complete run lacks a result. STATUS_FAILED without Python. */
enum status study_collect(struct study *study) FURROW_CHECKED;
/* STATUS_INPUT if a result cannot be read from a run that is complete. Checks nothing without Python. */
enum status study_check_run(struct study *study, size_t run) FURROW_CHECKED;
/* Adds to study.json what is collected: parameters, results, plots. */
struct cJSON;
void study_add_results(const struct study *study, struct cJSON *json);

/* --- study_results.c --- */
/* STATUS_INPUT if a parameter of the plot has too many values that are no numbers. `node`: where
 * the study file has the plot. */
enum status study_plot_check(const struct study *study, const struct study_plot *plot, const struct scene_node *node) FURROW_CHECKED;

#endif
