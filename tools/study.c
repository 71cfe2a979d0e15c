/* furrow study: drives one scene many times, each time with other values, and collects what came
 * out. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "study.h"

static const char *const kinds[] = {"slurm", "parallel", "snakemake", NULL};

static const struct command_option options[] = {
	{"o", "DIR", .help = "where the runs, study.json, study.csv and the plots go", .files = "/", .needed = true},
	{"jobs", "N", .help = "runs at once", .preset = "the processor's cores"},
	{"write", "KIND", .help = "run nothing, and write what a scheduler runs: DIR/slurm.sh, DIR/parallel.txt or DIR/Snakefile",
	 .choices = kinds},
	{"slurm", .help = "the same as --write slurm", .instead = true},
	{"parallel", .help = "the same as --write parallel", .instead = true},
	{"snakemake", .help = "the same as --write snakemake", .instead = true},
	{"collect", .help = "run nothing, and collect with the results and plots that STUDY.yaml names now", .instead = true},
	{.name = NULL},
};

/* Runs what is to do. What there is is collected also when some runs failed. */
static enum status work(struct study *study, int jobs)
{
	const enum status worked = study_work(study, jobs);
	if (worked != STATUS_OK && worked != STATUS_FAILED)
		return worked;
	struct failure failure = {.status = STATUS_OK};
	failure_capture(&failure, worked);
	const enum status collected = study_collect(study);
	return worked != STATUS_OK ? failure_restore(&failure) : collected;
}

/* What is to be written; -1: nothing. */
static enum status take_kind(const struct arguments *arguments, int *kind)
{
	int given = arguments_flag(arguments, "collect");
	*kind = -1;
	TRY(arguments_choice(arguments, "write", kind));
	given += *kind >= 0;
	for (int i = 0; kinds[i] != NULL; i++)
		if (arguments_flag(arguments, kinds[i])) {
			*kind = i;
			given++;
		}
	if (given > 1)
		return fail_with(STATUS_USAGE, "study: is to write or collect in two ways; give one of --write and --collect");
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct study study = {.file = NULL};
	int64_t jobs = 0;
	int kind = -1;
	const char *directory = arguments_text(arguments, "o"), *first = arguments_at(arguments, 0);
	const bool again = first != NULL && strcmp(first, "collect") == 0 && arguments_count(arguments) == 2;
	if (again != (directory == NULL))
		return fail_with(STATUS_USAGE, again ? "study collect: takes no -o; give the folder of the study alone"
						     : "study: -o is missing; give a folder for the runs");
	TRY(arguments_integer(arguments, "jobs", 1, 1024, &jobs));
	TRY(take_kind(arguments, &kind));
	enum status status;
	TRY_OR(done, again ? study_reopen(&study, arguments_at(arguments, 1)) : study_read(first, NULL, &study));
	if (!again)
		TRY_OR(done, study_prepare(&study, directory, arguments_flag(arguments, "collect")));
	if (again || arguments_flag(arguments, "collect")) {
		TRY_OR(done, study_collect(&study));
	} else if (kind >= 0) {
		TRY_OR(done, study_write(&study, kind, (int)jobs));
	} else {
		const long cores = sysconf(_SC_NPROCESSORS_ONLN);
		TRY_OR(done, work(&study, jobs > 0 ? (int)jobs : cores > 0 ? (int)cores : 1));
	}
done:
	study_destroy(&study);
	return status;
}

const struct command command_study = {
	.name = "study",
	.summary = "drive a scene with many values: a grid, a list or a Latin hypercube, its results in one CSV, plots",
	.arguments = COMMAND_ARGUMENTS({"STUDY.yaml", .help = "what to vary, and what to collect", .files = "yaml yml",
	 .needed = true}),
	.also = COMMAND_ARGUMENTS({"collect", .help = "this word", .needed = true},
				  {"DIR", .help = "the folder of a study", .files = "/", .needed = true}),
	.options = options,
	.details = "What a study file may say is in docs/STUDY.md. Each run has a folder in DIR/runs, named by its number and a "
		   "hash of its settings: run.json, objects.csv, vehicles.csv, log.txt, run.sh (the same drive by hand), and "
		   "overlay.furrow (its ruts). The store is shared and stays as it is.\n\n"
		   "A run that is complete is not run again; one that was stopped or killed goes on where it was. A run that fails "
		   "does not stop the others; its last error is told, and the exit status is 1. Ctrl-C ends all cleanly.\n\n"
		   "When the runs have ended, DIR/study.csv has a row for each run: its values and its results; and the plots are "
		   "drawn. furrow study collect DIR does that again, and after a scheduler has run them. DIR/study.json tells the "
		   "state of each. Python (numpy) reads the results, and its package matplotlib draws.\n",
	.examples = "furrow study loads.yaml -o loads --jobs 4\n"
		    "furrow study loads.yaml -o loads --write slurm\n",
	.see = "furrow-drive(1), furrow-report(1)",
	.run = run,
};
