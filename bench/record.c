/* See record.h. The fields are those of bench/record.py, which checks both. */
#define _GNU_SOURCE
#include "record.h"

#include <cJSON.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/aside.h"
#include "bench.h"
#include "bench_commit.h"

static struct {
	const char *bench, *path;
	char command[1024];
	double load;
	cJSON *figures;
} record;

static double load_now(void)
{
	double load = 0;
	(void)getloadavg(&load, 1);
	return load;
}

/* Writes the command line down. Of a path that begins at the root it keeps the file name alone, since the folders are of this machine. */
static void describe(int count, char **words)
{
	size_t used = 0;
	for (int i = 0; i < count && used < sizeof record.command; i++) {
		const char *name = strrchr(words[i], '/');
		const char *prefix = i == 0 ? "build/bench/" : words[i][0] == '/' ? ".../" : "";
		const char *word = name != NULL && prefix[0] != '\0' ? name + 1 : words[i];
		used += (size_t)snprintf(record.command + used, sizeof record.command - used, "%s%s%s", i > 0 ? " " : "", prefix, word);
	}
}

void bench_record_begin(const char *bench, int *count, char **words)
{
	record.bench = bench;
	record.load = load_now();
	describe(*count, words);
	for (int i = 1; i + 1 < *count; i++) {
		if (strcmp(words[i], "--figures") != 0)
			continue;
		record.path = words[i + 1];
		memmove(words + i, words + i + 2, (size_t)(*count - i - 1) * sizeof *words); /* with the NULL at the end */
		*count -= 2;
		break;
	}
	record.figures = cJSON_CreateObject();
}

void bench_record_add(const char *key, const char *unit, double *runs, size_t count)
{
	cJSON *figure = cJSON_AddObjectToObject(record.figures, key);
	cJSON_AddNumberToObject(figure, "value", bench_median(runs, count));
	cJSON_AddStringToObject(figure, "unit", unit);
	cJSON_AddNumberToObject(figure, "runs", (double)count);
	if (count > 1) {
		cJSON_AddNumberToObject(figure, "low", runs[0]);
		cJSON_AddNumberToObject(figure, "high", runs[count - 1]);
	}
}

static void add_machine(cJSON *to, const char *renderer)
{
	char line[256], cpu[256] = "unknown";
	FILE *file = fopen("/proc/cpuinfo", "r");
	while (file != NULL && fgets(line, sizeof line, file) != NULL)
		if (sscanf(line, "model name : %255[^\n]", cpu) == 1)
			break;
	if (file != NULL)
		fclose(file);
	cpu_set_t may;
	const int cores = sched_getaffinity(0, sizeof may, &may) == 0 ? CPU_COUNT(&may) : (int)sysconf(_SC_NPROCESSORS_ONLN);
	cJSON *machine = cJSON_AddObjectToObject(to, "machine");
	cJSON_AddStringToObject(machine, "cpu", cpu);
	cJSON_AddNumberToObject(machine, "cores", cores);
	cJSON_AddNumberToObject(machine, "memory", (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGE_SIZE));
	if (renderer != NULL)
		cJSON_AddStringToObject(machine, "renderer", renderer);
	else
		cJSON_AddNullToObject(machine, "renderer");
}

static void add_build(cJSON *to)
{
	cJSON *build = cJSON_AddObjectToObject(to, "build");
	cJSON_AddStringToObject(build, "type", FURROW_BUILD_TYPE);
#ifdef NDEBUG
	cJSON_AddFalseToObject(build, "asserts");
#else
	cJSON_AddTrueToObject(build, "asserts");
#endif
	cJSON_AddStringToObject(build, "sanitizers", FURROW_SANITIZERS);
}

/* The figures a line each, so that a change of one is a line of a patch. */
static enum status put(FILE *file, cJSON *head)
{
	char *text = cJSON_Print(head);
	if (text == NULL)
		return fail_memory("the figures");
	text[strlen(text) - 2] = '\0'; /* the line with the last brace */
	fprintf(file, "%s,\n\t\"figures\": {\n", text);
	cJSON_free(text);
	for (const cJSON *figure = record.figures->child; figure != NULL; figure = figure->next) {
		text = cJSON_PrintUnformatted(figure);
		if (text == NULL)
			return fail_memory("the figures");
		fprintf(file, "\t\t\"%s\": %s%s\n", figure->string, text, figure->next != NULL ? "," : "");
		cJSON_free(text);
	}
	fprintf(file, "\t}\n}\n");
	return STATUS_OK;
}

void bench_record_end(const char *renderer)
{
	if (record.path == NULL) {
		cJSON_Delete(record.figures);
		return;
	}
	char commit[] = BENCH_COMMIT, date[32];
	char *dirty = strchr(commit, '-');
	if (dirty != NULL)
		*dirty = '\0';
	const time_t now = time(NULL);
	strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", gmtime(&now));
	cJSON *head = cJSON_CreateObject();
	cJSON_AddStringToObject(head, "bench", record.bench);
	cJSON_AddStringToObject(head, "command", record.command);
	cJSON_AddStringToObject(head, "commit", commit);
	cJSON_AddBoolToObject(head, "dirty", dirty != NULL);
	cJSON_AddStringToObject(head, "date", date);
	add_machine(head, renderer);
	add_build(head);
	cJSON_AddItemToObject(head, "load", cJSON_CreateDoubleArray((const double[]){record.load, load_now()}, 2));
	struct aside aside;
	enum status status = aside_begin(&aside, record.path);
	if (status == STATUS_OK)
		status = put(aside.file, head);
	bench_must(aside_end(&aside, false, status));
	cJSON_Delete(head);
	cJSON_Delete(record.figures);
}
