/* What schedulers run: a Slurm array script, a list for GNU parallel, a Snakefile. Each runs run.sh
 * of every run. */
#include <limits.h>

#include "base/aside.h"
#include "study.h"

static void write_slurm(const struct study *study, int jobs, FILE *file)
{
	fprintf(file,
		"#!/bin/sh\n#SBATCH --job-name=furrow-study\n#SBATCH --output=/dev/null\n#SBATCH "
		"--array=1-%zu",
		study->run_count);
	if (jobs > 0)
		fprintf(file, "%%%d", jobs);
	fputs("\n# A task runs one run; its log is log.txt in the folder of the run. Add what your "
	      "cluster asks for: --time, --partition, --gres.\n"
	      "set -eu\ncase $SLURM_ARRAY_TASK_ID in\n",
	      file);
	for (size_t run = 0; run < study->run_count; run++)
		fprintf(file, "%zu) run=%s ;;\n", run + 1, study->runs[run].name);
	fputs("*) echo \"task $SLURM_ARRAY_TASK_ID: no such run\" >&2; exit 2 ;;\nesac\nexec sh ", file);
	study_quote(study->directory, file);
	fputs("/runs/$run/run.sh\n", file);
}

static void write_parallel(const struct study *study, FILE *file)
{
	char path[PATH_MAX];
	for (size_t run = 0; run < study->run_count; run++) {
		fputs("sh ", file);
		study_quote(study_path(study, run, "run.sh", path), file);
		fputc('\n', file);
	}
}

/* A text as Python has it. */
static void write_python(const char *text, FILE *file)
{
	fputc('"', file);
	for (const char *c = text; *c != '\0'; c++)
		fprintf(file, "%s%c", *c == '"' || *c == '\\' ? "\\" : "", *c);
	fputc('"', file);
}

static void write_snakemake(const struct study *study, FILE *file)
{
	fputs("# snakemake --snakefile THIS --cores N. done.txt in the folder of a run says that "
	      "it is complete.\nDIRECTORY = ",
	      file);
	write_python(study->directory, file);
	fputs("\nFURROW = ", file);
	write_python(study->program, file);
	fputs("\nRUNS = [\n", file);
	for (size_t run = 0; run < study->run_count; run++)
		fprintf(file, "    \"%s\",\n", study->runs[run].name);
	fputs("]\n\nrule all:\n    input: DIRECTORY + \"/study.csv\"\n\n"
	      "rule drive:\n    output: DIRECTORY + \"/runs/{run}/done.txt\"\n    params: "
	      "script=lambda wildcards: DIRECTORY + \"/runs/\" + wildcards.run + \"/run.sh\"\n"
	      "    shell: \"sh {params.script:q} && touch {output:q}\"\n\n"
	      "rule collect:\n    input: [DIRECTORY + \"/runs/\" + run + \"/done.txt\" for run in "
	      "RUNS]\n    output: DIRECTORY + \"/study.csv\"\n"
	      "    params: program=FURROW, directory=DIRECTORY\n    shell: \"{params.program:q} "
	      "study collect {params.directory:q}\"\n",
	      file);
}

enum status study_write(struct study *study, int kind, int jobs)
{
	static const char *const names[] = {"slurm.sh", "parallel.txt", "Snakefile"};
	char path[PATH_MAX];
	struct aside aside = {.path = NULL};
	snprintf(path, sizeof path, "%.4000s/%s", study->directory, names[kind]);
	enum status status;
	TRY_OR(done, aside_begin(&aside, path));
	if (kind == 0)
		write_slurm(study, jobs, aside.file);
	else if (kind == 1)
		write_parallel(study, aside.file);
	else
		write_snakemake(study, aside.file);
	TRY_OR(done, aside_whole(&aside, false));
	TRY_OR(done, aside_publish(&aside));
	printf("%zu runs: %s\n", study->run_count, path);
done:
	aside_finish(&aside);
	return status;
}
