/* Opens files of rows, and cuts those of a resumed run. */
#include "base/limits.h"
#include "report/rows_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Finds where the rows at or before `time` end. A kill may have torn the last line. */
static long whole_until(FILE *file, const char *header, double time)
{
	char *line = NULL;
	size_t room = 0;
	long end = 0;
	ssize_t length;
	while ((length = getline(&line, &room, file)) > 0 && line[length - 1] == '\n') {
		if (end == 0 ? strncmp(line, header, strlen(header)) != 0 : strtod(line, NULL) > time * (1 + 1e-8))
			break;
		end = ftell(file);
	}
	free(line);
	return end;
}

enum status report_rows_file_failed(const char *path)
{
	return fail_with(STATUS_FAILED, "%s: %s; %s", path, input_problem(), limits_advice(errno, "give a folder that can be written"));
}

enum status report_rows_file_open(const struct world *world, const char *path, const char *header, bool again, FILE **file, bool *begins)
{
	long end = 0;
	struct world_recorded recorded = {.step = 0};
	*file = output_open(path, world_facts(world)->resumed.is ? "a+" : "w+");
	if (*file != NULL && world_facts(world)->resumed.is) {
		world_recorded(world, &recorded);
		rewind(*file);
		end = whole_until(*file, header, recorded.step > 0 || !again ? recorded.time : -1);
	}
	const bool empty = end == 0;
	if (begins != NULL)
		*begins = empty;
	if (*file == NULL || end < 0 || ftruncate(fileno(*file), end) != 0 || fseek(*file, 0, SEEK_END) != 0)
		return report_rows_file_failed(path);
	if (empty && recorded.step > 0)
		note("%s: has no rows of the steps up to %lld: the file was not there, or was damaged; give the -o of the drive that is resumed",
		     path, (long long)recorded.step);
	return empty && fputs(header, *file) < 0 ? report_rows_file_failed(path) : STATUS_OK;
}

bool report_rows_file_end(FILE *file, int64_t *end)
{
	if (fflush(file) != 0 || fseek(file, 0, SEEK_END) != 0)
		return false;
	*end = ftell(file);
	return *end >= 0;
}

bool report_rows_file_cut(FILE *file, int64_t end)
{
	return fflush(file) == 0 && ftruncate(fileno(file), end) == 0 && fseek(file, 0, SEEK_END) == 0;
}
