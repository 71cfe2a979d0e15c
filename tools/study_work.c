/*
 * Runs the drives of a study on this machine, each a process of its own with its log.
 *
 * Each child has a process group of its own, so that Ctrl-C reaches it once, through this process.
 * A child ends cleanly when this process is killed.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/limits.h"
#include "study.h"

#define TAIL_BYTES 4096
#define MANIFEST_SECONDS 2.0 /* study.json is written this often at most, and at the end */

struct job {
	pid_t pid; /* 0: none */
	size_t run;
};

struct work {
	struct study *study;
	struct job *jobs;
	int job_count;
	size_t next; /* the first run that was not looked at */
	size_t done, total, failed;
	size_t first_failed;
	bool checked;         /* a complete run was looked at: whether it has the results */
	struct failure wrong; /* what it lacks; STATUS_OK: nothing */
	double written; /* when study.json was */
	struct progress progress;
};

/* In the child: never returns. */
static void become_drive(const char *const *arguments, int log, pid_t parent)
{
	setpgid(0, 0);
	prctl(PR_SET_PDEATHSIG, SIGTERM);
	if (getppid() != parent)
		_exit(1);
	const int nothing = open("/dev/null", O_RDONLY);
	if (nothing >= 0)
		dup2(nothing, STDIN_FILENO);
	dup2(log, STDOUT_FILENO);
	dup2(log, STDERR_FILENO);
	execv("/proc/self/exe", (char *const *)arguments);
	dprintf(STDERR_FILENO, "furrow: %s: %s; give a program that can be run\n", arguments[0], strerror(errno));
	_exit(1);
}

static enum status fork_drive(struct job *job, size_t run, const char **arguments, int log)
{
	const pid_t parent = getpid();
	fflush(NULL);
	const pid_t pid = fork();
	if (pid == 0)
		become_drive(arguments, log, parent);
	if (pid < 0)
		return fail_with(STATUS_FAILED, "fork: %s; use fewer --jobs", strerror(errno));
	*job = (struct job){.pid = pid, .run = run};
	return STATUS_OK;
}

static enum status start(struct work *work, struct job *job, size_t run)
{
	char path[PATH_MAX];
	const char **arguments = NULL;
	TRY(study_arguments(work->study, run, &arguments));
	enum status status;
	const int log = output_create(study_path(work->study, run, "log.txt", path), O_WRONLY | O_APPEND);
	if (log < 0)
		TRY_OR(done, fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written")));
	status = fork_drive(job, run, arguments, log);
	close(log);
	TRY_OR(done, status);
	work->study->runs[run].state = STUDY_BEGUN;
done:
	mem_free(arguments);
	return status;
}

/* The last line of a log that tells an error, else its last line. NULL: there is none. */
static const char *last_error(struct study *study, size_t run)
{
	char path[PATH_MAX], tail[TAIL_BYTES + 1];
	FILE *file = input_open(study_path(study, run, "log.txt", path));
	if (file == NULL)
		return NULL;
	if (fseek(file, -TAIL_BYTES, SEEK_END) != 0)
		rewind(file);
	tail[fread(tail, 1, TAIL_BYTES, file)] = '\0';
	fclose(file);
	const char *found = NULL;
	bool error = false;
	char *rest = NULL;
	for (char *line = strtok_r(tail, "\n", &rest); line != NULL; line = strtok_r(NULL, "\n", &rest)) {
		const bool tells = strncmp(line, "furrow: ", 8) == 0 && strncmp(line, "furrow: note: ", 14) != 0;
		if (tells || !error)
			found = tells ? line + 8 : line;
		error = error || tells;
	}
	return found != NULL ? study_print(study, "%s", found) : NULL;
}

/* Takes what a child left. */
static void take_end(struct work *work, const struct job *job, int ended)
{
	struct study_run *run = &work->study->runs[job->run];
	study_look(work->study, job->run);
	work->done++;
	if (run->state == STUDY_COMPLETE && !work->checked)
		failure_capture(&work->wrong, study_check_run(work->study, job->run));
	work->checked = work->checked || run->state == STUDY_COMPLETE;
	if (run->state == STUDY_COMPLETE)
		return;
	if (run->state == STUDY_INTERRUPTED || (interrupted && WIFEXITED(ended) && WEXITSTATUS(ended) == 130))
		return;
	run->state = STUDY_FAILED;
	run->error = WIFSIGNALED(ended) ? study_print(work->study, "was ended by signal %d", WTERMSIG(ended))
					: last_error(work->study, job->run);
	if (work->failed++ == 0)
		work->first_failed = job->run;
	progress_end(&work->progress);
	note("run %s failed: %s", run->name, run->error != NULL ? run->error : "its log.txt says nothing");
}

/* Returns the number of children that are still running. */
static int look_at_children(struct work *work)
{
	int running = 0;
	for (struct job *job = work->jobs; job < work->jobs + work->job_count; job++) {
		int ended;
		if (job->pid == 0)
			continue;
		const pid_t found = waitpid(job->pid, &ended, WNOHANG);
		if (found == job->pid) {
			take_end(work, job, ended);
			job->pid = 0;
		} else {
			running++;
		}
	}
	return running;
}

static void end_children(const struct work *work)
{
	for (const struct job *job = work->jobs; job < work->jobs + work->job_count; job++)
		if (job->pid != 0)
			(void)kill(job->pid, SIGTERM); /* a drive that gets one ends with everything committed */
}

static enum status start_some(struct work *work)
{
	for (struct job *job = work->jobs; job < work->jobs + work->job_count; job++) {
		if (job->pid != 0)
			continue;
		while (work->next < work->study->run_count && work->study->runs[work->next].state == STUDY_COMPLETE)
			work->next++;
		if (work->next == work->study->run_count)
			return STATUS_OK;
		TRY(start(work, job, work->next++));
	}
	return STATUS_OK;
}

static enum status run_all(struct work *work)
{
	static const struct timespec pause = {.tv_nsec = 20000000};
	enum status status = STATUS_OK;
	bool ending = false;
	for (;;) {
		if (status == STATUS_OK && !interrupted)
			status = start_some(work);
		const int running = look_at_children(work);
		if (status == STATUS_OK && work->wrong.status != STATUS_OK) /* all others would end without that result, too */
			status = failure_restore(&work->wrong);
		if ((interrupted || status != STATUS_OK) && !ending) {
			end_children(work);
			ending = true;
		}
		if (running == 0 && (ending || work->done == work->total))
			break;
		if (!ending)
			(void)!progress_step(&work->progress, (int64_t)work->done, (int64_t)work->total);
		if (clock_seconds() - work->written > MANIFEST_SECONDS && status == STATUS_OK) {
			status = study_manifest(work->study);
			work->written = clock_seconds();
		}
		nanosleep(&pause, NULL);
	}
	progress_end(&work->progress);
	return status;
}

static enum status tell(const struct work *work)
{
	const struct study *study = work->study;
	size_t complete = 0;
	for (size_t run = 0; run < study->run_count; run++)
		complete += study->runs[run].state == STUDY_COMPLETE;
	if (interrupted)
		return fail_with(STATUS_INTERRUPTED, "study: interrupted, %zu of %zu runs are complete; run it again to go on",
				 complete, study->run_count);
	if (work->failed == 0)
		return STATUS_OK;
	const struct study_run *run = &study->runs[work->first_failed];
	return fail_with(STATUS_FAILED, "study: %zu of %zu runs failed, first %s: %.300s; see its log.txt", work->failed,
			 work->total, run->name, run->error != NULL ? run->error : "no error is in its log");
}

static enum status check_and_run(struct work *work, int jobs)
{
	struct study *study = work->study;
	TRY(mem_zeroed(&work->jobs, (size_t)jobs, sizeof *work->jobs, "jobs of the study"));
	interrupt_catch();
	progress_start(&work->progress, "study", "runs");
	for (size_t run = 0; run < study->run_count && !work->checked; run++)
		if (study->runs[run].state == STUDY_COMPLETE) {
			TRY(study_check_run(study, run));
			work->checked = true;
		}
	return run_all(work);
}

enum status study_work(struct study *study, int jobs)
{
	struct work work = {.study = study, .job_count = jobs, .written = clock_seconds()};
	const int folder = open(study->directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	if (folder < 0 || flock(folder, LOCK_EX | LOCK_NB) != 0) {
		if (folder >= 0)
			close(folder);
		return fail_with(STATUS_FAILED,
				 "%s: another study runs in this folder; give another, or wait for "
				 "it to end",
				 study->directory);
	}
	for (size_t run = 0; run < study->run_count; run++)
		work.total += study->runs[run].state != STUDY_COMPLETE;
	enum status status = check_and_run(&work, jobs);
	const enum status written = study_manifest(study);
	TRY_OR(done, status);
	TRY_OR(done, written);
	TRY_OR(done, tell(&work));
done:
	mem_free(work.jobs);
	close(folder);
	return status;
}
