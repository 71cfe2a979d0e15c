/*
 * Runs a fuzz target where there is no libFuzzer:
 *
 *   fuzz_X FILE...                     each input once: a finding again
 *   fuzz_X --seconds S [--seed N] [--keep DIR] DIR...
 *                                      the seeds, the folders' files, then changes of them
 *   fuzz_X --seeds DIR                 writes the seeds, for libFuzzer
 *
 * A child process runs the target; the input it is at lies in memory shared with its parent, which
 * needs nothing of a child that crashed or hangs to say which input it was and leave it in a file.
 *
 * An input that reaches code no other reached (the targets' code is compiled with
 * -fsanitize-coverage=trace-pc) joins the corpus. Number i of a run is made of the seed, i and the
 * corpus by then: a run with the same seed makes the same inputs.
 */
#include "driver.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/personality.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define CPU_SECONDS_MAX 5   /* of one input */
#define WALL_SECONDS_MAX 30 /* waiting counts too, but so does a machine that is busy */

struct options {
	double seconds;
	uint64_t seed, runs;
	const char *keep, *seeds;
	char **paths;
};

/* What the parent sees of the child. */
struct shared {
	volatile uint64_t runs, corpus, places;
	volatile double began, cpu_began; /* the input it is at */
	volatile size_t size;
	uint8_t data[];
};

static struct shared *shared;
static struct options options = {.seed = 1};
static const char *name; /* the program's */
static struct input *corpus;
static size_t corpus_count, corpus_room;

/* Blocks freed are kept back from use for a while: the more, the more memory is touched anew. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
	return "quarantine_size_mb=8:thread_local_quarantine_size_kb=256";
}

/* --- what was reached --- */

#define PLACES (1u << 16)
static uint8_t reached_now[PLACES] __attribute__((aligned(8))), reached_ever[PLACES];
static uintptr_t reached_last;
static _Thread_local bool is_traced; /* the thread that runs the target: libraries' own threads come at any time */

/* The linker's: where the program begins, which is another place in each process. */
extern const char __executable_start[];

void __sanitizer_cov_trace_pc(void);
__attribute__((no_sanitize("address", "undefined"))) void __sanitizer_cov_trace_pc(void)
{
	if (!is_traced)
		return;
	uintptr_t at = (uintptr_t)__builtin_return_address(0) - (uintptr_t)__executable_start;
	at = at ^ at >> 16;
	uint8_t *count = &reached_now[(at ^ reached_last) & (PLACES - 1)];
	*count = (uint8_t)(*count + (*count < 255));
	reached_last = at >> 1;
}

/* True if the last input went a way, or as often a way, as none before. */
__attribute__((no_sanitize("address", "undefined"))) static bool reached_more(void)
{
	bool more = false;
	for (size_t i = 0; i < PLACES; i++) {
		uint64_t eight;
		if (i % 8 == 0 && (memcpy(&eight, &reached_now[i], 8), eight == 0)) {
			i += 7;
			continue;
		}
		if (reached_now[i] == 0)
			continue;
		uint8_t often = (uint8_t)(1u << (31 - (unsigned)__builtin_clz(reached_now[i])));
		if (reached_ever[i] == 0)
			shared->places++;
		more |= (reached_ever[i] & often) == 0;
		reached_ever[i] |= often;
	}
	return more;
}

/* --- the child --- */

__attribute__((weak)) size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
__attribute__((weak)) int __lsan_do_recoverable_leak_check(void);

static double clock_read(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void *room_for(size_t bytes)
{
	void *room = malloc(bytes > 0 ? bytes : 1);
	if (room == NULL) {
		fprintf(stderr, "out of memory\n");
		exit(1);
	}
	return room;
}

const struct input *driver_any_input(void)
{
	return &corpus[fuzz_below(&driver_random_state, corpus_count)];
}

static void corpus_add(const uint8_t *data, size_t size)
{
	if (size == 0)
		return;
	if (corpus_count == corpus_room) {
		corpus_room = corpus_room * 2 + 64;
		struct input *grown = realloc(corpus, corpus_room * sizeof *corpus);
		if (grown == NULL)
			exit(1);
		corpus = grown;
	}
	struct input *input = &corpus[corpus_count++];
	*input = (struct input){room_for(size), size};
	memcpy(input->data, data, size);
	shared->corpus = corpus_count;
}

/* The input in shared->data, in a block of just its size: beyond it nothing may be read. */
static void run_once(void)
{
	size_t size = shared->size;
	uint8_t *exact = room_for(size);
	memcpy(exact, shared->data, size);
	memset(reached_now, 0, sizeof reached_now);
	reached_last = 0;
	shared->cpu_began = clock_read(CLOCK_PROCESS_CPUTIME_ID);
	shared->began = clock_read(CLOCK_MONOTONIC);
	int64_t blocks = fuzz_memory_blocks();
	is_traced = true;
	LLVMFuzzerTestOneInput(exact, size);
	is_traced = false;
	bool more = fuzz_memory_blocks() > blocks;
	free(exact);
	/* More blocks than before may be a library's cache, or lost. */
	if (more && __lsan_do_recoverable_leak_check != NULL && __lsan_do_recoverable_leak_check() != 0)
		abort();
	shared->runs++;
}

static void keep_input(void)
{
	char path[4096];
	uint64_t hash = shared->size;
	for (size_t i = 0; i < shared->size; i++)
		hash = (hash ^ shared->data[i]) * 0x100000001b3u;
	snprintf(path, sizeof path, "%s/%016llx", options.keep, (unsigned long long)hash);
	fuzz_write(path, shared->data, shared->size);
}

static void try_input(bool keep)
{
	run_once();
	if (!reached_more())
		return;
	corpus_add(shared->data, shared->size);
	if (keep && options.keep != NULL)
		keep_input();
}

static int name_compare(const void *a, const void *b)
{
	return strcmp(*(char *const *)a, *(char *const *)b);
}

static void try_file(const char *path)
{
	size_t size = fuzz_read(path, shared->data, fuzz_size_max);
	if (size == 0 || size > fuzz_size_max) {
		fprintf(stderr, "%s: %s\n", path, size == 0 ? "empty, or cannot be read" : "too large");
		exit(2);
	}
	shared->size = size;
	try_input(false);
}

/* A file, or the files of a folder in the order of their names. */
static void try_path(const char *path)
{
	char *names[4096], child[4096];
	size_t count = 0;
	DIR *dir = opendir(path);
	if (dir == NULL) {
		try_file(path);
		return;
	}
	for (struct dirent *entry; (entry = readdir(dir)) != NULL && count < 4096;)
		if (entry->d_name[0] != '.')
			names[count++] = strdup(entry->d_name);
	closedir(dir);
	qsort(names, count, sizeof *names, name_compare);
	for (size_t i = 0; i < count; i++) {
		snprintf(child, sizeof child, "%s/%s", path, names[i]);
		try_file(child);
		free(names[i]);
	}
}

static void change_input(uint64_t number)
{
	driver_random_state = options.seed * 0x9e3779b97f4a7c15u ^ number;
	/* Half of the time one of the newest: what is beyond them is not known yet. */
	size_t recent = corpus_count < 16 ? corpus_count : 16;
	const struct input *input = fuzz_below(&driver_random_state, 2)
					    ? &corpus[corpus_count - 1 - fuzz_below(&driver_random_state, recent)]
					    : driver_any_input();
	memcpy(shared->data, input->data, input->size);
	if (LLVMFuzzerCustomMutator != NULL)
		shared->size = LLVMFuzzerCustomMutator(shared->data, input->size, fuzz_size_max,
						       (unsigned)fuzz_random(&driver_random_state));
	else
		shared->size = LLVMFuzzerMutate(shared->data, input->size, fuzz_size_max);
}

static int child_run(void)
{
	double end = clock_read(CLOCK_MONOTONIC) + options.seconds;
	bool fuzzing = options.seconds > 0 || options.runs > 0;
	for (size_t i = 0; fuzzing; i++) {
		shared->size = fuzz_seed(i, shared->data, fuzz_size_max);
		if (shared->size == 0)
			break;
		try_input(false);
	}
	for (char **path = options.paths; *path != NULL; path++)
		try_path(*path);
	if (!fuzzing)
		return 0;
	for (uint64_t i = 0; options.runs > 0 ? i < options.runs : clock_read(CLOCK_MONOTONIC) < end; i++) {
		change_input(i);
		try_input(true);
	}
	return 0;
}

/* --- the parent --- */

static bool hangs(pid_t child)
{
	clockid_t clock;
	double began = shared->began;
	if (began == 0 || clock_getcpuclockid(child, &clock) != 0)
		return false;
	double cpu = clock_read(clock) - shared->cpu_began;
	return shared->began == began && (cpu > CPU_SECONDS_MAX ||
					  clock_read(CLOCK_MONOTONIC) - began > WALL_SECONDS_MAX);
}

/* The input that did it, in a file of this folder. */
static int leave_input(const char *what)
{
	char path[256];
	snprintf(path, sizeof path, "%s-%s-%llu", name, what, (unsigned long long)shared->runs);
	fuzz_write(path, shared->data, shared->size);
	fprintf(stderr, "%s: %s at input %llu of seed %llu; it is in %s: give that as the argument to see it "
		"again\n", name, what, (unsigned long long)shared->runs, (unsigned long long)options.seed, path);
	return 1;
}

static int parent_run(pid_t child)
{
	int state;
	for (;;) {
		pid_t ended = waitpid(child, &state, WNOHANG);
		if (ended == child)
			break;
		if (hangs(child)) {
			kill(child, SIGKILL);
			waitpid(child, &state, 0);
			return leave_input("hang");
		}
		nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
	}
	if (WIFEXITED(state) && WEXITSTATUS(state) == 2)
		return 2;
	return WIFEXITED(state) && WEXITSTATUS(state) == 0 ? 0 : leave_input("crash");
}

static int write_seeds(void)
{
	for (size_t i = 0; (shared->size = fuzz_seed(i, shared->data, fuzz_size_max)) > 0; i++) {
		char path[4096];
		snprintf(path, sizeof path, "%s/seed%zu", options.seeds, i);
		fuzz_write(path, shared->data, shared->size);
	}
	return 0;
}

static bool take_arguments(char **argv)
{
	for (argv++; *argv != NULL && strncmp(*argv, "--", 2) == 0; argv += 2) {
		if (argv[1] == NULL)
			return false;
		if (strcmp(*argv, "--seconds") == 0)
			options.seconds = atof(argv[1]);
		else if (strcmp(*argv, "--seed") == 0)
			options.seed = strtoull(argv[1], NULL, 10);
		else if (strcmp(*argv, "--runs") == 0)
			options.runs = strtoull(argv[1], NULL, 10);
		else if (strcmp(*argv, "--keep") == 0)
			options.keep = argv[1];
		else if (strcmp(*argv, "--seeds") == 0)
			options.seeds = argv[1];
		else
			return false;
	}
	options.paths = argv;
	return true;
}

/* Libraries that a target calls may go other ways for other addresses. So a run has the same addresses each time, where the machine allows it. */
static void same_addresses(char **argv)
{
	const int now = personality(0xffffffff);
	if (now >= 0 && (now & ADDR_NO_RANDOMIZE) == 0 && personality((unsigned long)now | ADDR_NO_RANDOMIZE) >= 0)
		execv("/proc/self/exe", argv);
}

int main(int argc, char **argv)
{
	same_addresses(argv);
	/* For a longer run of the test command, or another one. */
	const char *seed = getenv("FUZZ_SEED"), *seconds = getenv("FUZZ_SECONDS");
	if (!take_arguments(argv)) {
		fprintf(stderr, "usage: %s [--seconds S | --runs N] [--seed N] [--keep DIR] [--seeds DIR] "
			"FILE_OR_DIR...\n", argv[0]);
		return 2;
	}
	if (options.seconds > 0 && seconds != NULL)
		options.seconds = atof(seconds);
	if (seed != NULL)
		options.seed = strtoull(seed, NULL, 10);
	shared = mmap(NULL, sizeof *shared + fuzz_size_max, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
	if (shared == MAP_FAILED) {
		perror("mmap");
		return 1;
	}
	if (options.seeds != NULL)
		return write_seeds();
	name = strrchr(argv[0], '/') != NULL ? strrchr(argv[0], '/') + 1 : argv[0];
	fuzz_path(""); /* made, and so removed, by the parent: the child may not live to */
	double began = clock_read(CLOCK_MONOTONIC);
	pid_t child = fork();
	if (child < 0) {
		perror("fork");
		return 1;
	}
	if (child == 0)
		exit(child_run());
	int result = parent_run(child);
	double took = clock_read(CLOCK_MONOTONIC) - began;
	printf("%llu inputs in %.1f s, %.0f a second; seed %llu, corpus %llu, places %llu\n",
	       (unsigned long long)shared->runs, took, (double)shared->runs / took,
	       (unsigned long long)options.seed, (unsigned long long)shared->corpus,
	       (unsigned long long)shared->places);
	return result;
}
