/* volume.csv: what a drive removed, raised and compacted until each of its commits, which are some seconds of wall clock apart. RESULTS.md has
 * the columns. */
#include <stdio.h>
#include <unistd.h>

#include "report/rows_file.h"

static const char header[] = "t,step,removed,raised,compacted\n";

enum status report_volume_open(const struct world *world, const char *directory, FILE **out)
{
	char path[4096];
	bool begins = false;
	*out = NULL;
	snprintf(path, sizeof path, "%s/volume.csv", directory);
	if (world_resident(world)->pages == NULL || world_scene(world)->object_count + world_scene(world)->vehicle_count == 0 || world_params(world)->ranks != NULL) { /* of ranks each has a part of the ground */
		unlink(path); /* another run's */
		return STATUS_OK;
	}
	TRY(report_rows_file_open(world, path, header, out, &begins));
	if (begins && (fputs(header, *out) < 0 || fflush(*out) != 0))
		return report_rows_file_failed(path);
	resident_pages_volume(world_resident(world)->pages, *out, lattice_offset_metres(1) * world_resident(world)->spacing * world_resident(world)->spacing);
	return STATUS_OK;
}
