/* volume.csv: what a drive removed, raised and compacted until each of its commits, which are some seconds of wall clock apart. Of several commits
 * of one step the last has the row. RESULTS.md has the columns. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "report/rows_file.h"

static const char header[] = "t,step,removed,raised,compacted\n";

/* Finds the last row of a file whose lines are whole. Opens the file once more, since what a stream has read of a file that was cut is stale. */
static bool find_last(const char *path, struct resident_volume *volume)
{
	char *line = NULL;
	size_t room = 0;
	FILE *file = input_open(path);
	if (file == NULL)
		return false;
	for (long at = 0; getline(&line, &room, file) > 0; at = ftell(file)) {
		long long step;
		if (sscanf(line, "%*[^,],%lld,", &step) == 1) {
			volume->step = step;
			volume->row = at;
		}
	}
	free(line);
	const bool whole = !ferror(file);
	fclose(file);
	return whole;
}

enum status report_volume_open(const struct world *world, const char *directory, FILE **out)
{
	char path[4096];
	bool begins = false;
	*out = NULL;
	snprintf(path, sizeof path, "%s/volume.csv", directory);
	if (world_resident(world)->pages == NULL || world_scene(world)->object_count + world_scene(world)->vehicle_count == 0 || world_params(world)->ranks != NULL) { /* of ranks each has a part of the ground */
		unlink(path); /* that another run left */
		return STATUS_OK;
	}
	TRY(report_rows_file_open(world, path, header, false, out, &begins));
	if (begins && fflush(*out) != 0)
		return report_rows_file_failed(path);
	struct resident_volume volume = {
		.file = *out,
		.unit = lattice_offset_metres(1) * world_resident(world)->spacing * world_resident(world)->spacing,
		.step = -1,
	};
	if (!begins && !find_last(path, &volume))
		return report_rows_file_failed(path);
	resident_pages_volume(world_resident(world)->pages, &volume);
	return STATUS_OK;
}
