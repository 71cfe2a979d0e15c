/* The progress line of long work, and Ctrl-C. */
#include "command.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define TERMINAL_SECONDS 0.1
#define LOG_SECONDS 10.0

volatile sig_atomic_t interrupted;

#define AGAIN_NS 1000000000LL /* signals that come within this time are one request: a terminal and a parent process may both send it */

static int64_t now_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* The first signal asks for an end. A second one within a second changes nothing: what runs is still ended cleanly. A third one, or a
 * second one later, ends the process at once. */
static void on_signal(int number)
{
	static volatile sig_atomic_t count;
	static volatile int64_t first;
	interrupted = 1;
	if (++count == 1) {
		first = now_ns();
	} else if (count > 2 || now_ns() - first > AGAIN_NS) {
		signal(number, SIG_DFL);
		(void)raise(number); /* comes when this function returns */
	}
}

void interrupt_catch(void)
{
	struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
	sigemptyset(&action.sa_mask);
	sigaddset(&action.sa_mask, SIGINT);
	sigaddset(&action.sa_mask, SIGTERM);
	sigaddset(&action.sa_mask, SIGHUP);
	sigaction(SIGINT, &action, NULL);
	sigaction(SIGTERM, &action, NULL);
	sigaction(SIGHUP, &action, NULL);
}

void progress_start(struct progress *progress, const char *what, const char *unit)
{
	*progress = (struct progress){
		.what = what,
		.unit = unit,
		.started = clock_seconds(),
		.terminal = isatty(STDERR_FILENO) != 0,
	};
	progress->shown = progress->terminal ? 0 : progress->started;
}

enum status progress_step(void *user, int64_t done, int64_t total)
{
	struct progress *progress = user;
	double now = clock_seconds();
	if (now - progress->shown > (progress->terminal ? TERMINAL_SECONDS : LOG_SECONDS)) {
		double elapsed = now - progress->started, rate = elapsed > 0 ? (double)done / elapsed : 0;
		double left = rate > 0 ? (double)(total - done) / rate : 0;
		fprintf(stderr, "%s%s: %lld of %lld %s (%.0f %%), %.*f a second, %.0f s left%s", progress->terminal ? "\r" : "furrow: note: ",
			progress->what, (long long)done, (long long)total, progress->unit,
			total > 0 ? 100.0 * (double)done / (double)total : 100.0, rate < 10 ? 2 : 0, rate, left, progress->terminal ? "\033[K" : "\n");
		fflush(stderr);
		progress->shown = now;
	}
	if (interrupted)
		return fail_with(STATUS_INTERRUPTED, "%s: interrupted; run it again to start over",
				 progress->what);
	return STATUS_OK;
}

void progress_end(struct progress *progress)
{
	if (progress->terminal && progress->shown > 0)
		fprintf(stderr, "\r\033[K");
	progress->shown = 0;
}
