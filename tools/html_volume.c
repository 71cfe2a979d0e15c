/* The volume that a drive moved: volume.csv, and its plot over time. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "html_plot.h"
#include "html_report.h"

#define ROWS_MOST 1000000
#define HEADER "t,step,removed,raised,compacted\n"

/* --- the file --- */

static enum status make_room(struct html_volumes *volumes)
{
	if (volumes->count < volumes->room)
		return STATUS_OK;
	const size_t room = mem_room(volumes->room, volumes->count + 1);
	TRY(mem_resize(&volumes->time, room, sizeof *volumes->time, "the volumes of a drive"));
	for (int k = 0; k < HTML_VOLUMES; k++)
		TRY(mem_resize(&volumes->values[k], room, sizeof *volumes->values[k], "the volumes of a drive"));
	volumes->room = room;
	return STATUS_OK;
}

/* Returns false if the line is no row. */
static bool take(const char *line, struct html_volumes *volumes)
{
	double values[5];
	const char *at = line;
	for (int k = 0; k < 5; k++) {
		char *end;
		values[k] = strtod(at, &end);
		if (end == at || *end != (k < 4 ? ',' : '\n') || !isfinite(values[k]))
			return false;
		at = end + 1;
	}
	const size_t i = volumes->count;
	if (i > 0 && values[0] < volumes->time[i - 1])
		return false;
	volumes->time[i] = values[0];
	for (int k = 0; k < 3; k++)
		volumes->values[HTML_REMOVED + k][i] = values[2 + k];
	volumes->values[HTML_NET][i] = values[3] - values[2];
	volumes->count++;
	return true;
}

static enum status read_rows(FILE *file, const char *path, struct html_volumes *volumes)
{
	char *line = NULL;
	size_t size = 0;
	ssize_t length;
	unsigned long long number = 0;
	enum status status = STATUS_OK;
	while ((length = getline(&line, &size, file)) > 0) {
		number++;
		if (line[length - 1] != '\n')
			break; /* a kill may have torn the last line */
		if (number > 1)
			TRY_OR(done, make_room(volumes));
		if (number == 1 ? strcmp(line, HEADER) != 0 : volumes->count == ROWS_MOST || !take(line, volumes))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s:%llu: is no line of such a file; give a folder that furrow drive left, or remove "
					       "the file", path, number));
	}
	if (ferror(file))
		TRY_OR(done, fail_with(STATUS_INPUT, "%s: %s; give a folder that can be read", path, input_problem()));
done:
	free(line);
	return status;
}

enum status html_volumes_read(struct html_run *run)
{
	char path[4200];
	snprintf(path, sizeof path, "%s/volume.csv", run->folder);
	if (!html_is_file(path))
		return STATUS_OK;
	FILE *file = input_open(path);
	if (file == NULL)
		return fail_with(STATUS_INPUT, "%s: %s; give a folder that can be read", path, strerror(errno));
	enum status status = read_rows(file, path, &run->volumes);
	fclose(file);
	return status;
}

void html_volumes_finish(struct html_volumes *volumes)
{
	mem_free(volumes->time);
	for (int k = 0; k < HTML_VOLUMES; k++)
		mem_free(volumes->values[k]);
	*volumes = (struct html_volumes){.count = 0};
}

/* --- the plot --- */

void html_volume_plot(const struct html_report *report)
{
	static const char *const names[HTML_VOLUMES] = {"removed", "raised", "compacted", "net: raised less removed"};
	struct html_line lines[HTML_RUNS * HTML_VOLUMES];
	const bool one = report->count == 1;
	size_t count = 0;
	for (size_t i = 0; i < report->count; i++) {
		const struct html_volumes *volumes = &report->runs[i].volumes;
		if (volumes->count < 2)
			html_sentence(report, &report->runs[i],
				      volumes->count == 1 ? "No volume over time: the drive made one commit" : "No volume over time: the folder has no volume.csv");
		for (size_t k = 0; k < HTML_VOLUMES && volumes->count > 1; k++)
			lines[count++] = (struct html_line){.colour = one ? k : i, .dash = one ? 0 : k, .count = volumes->count, .x = volumes->time, .y = volumes->values[k],
							    .dots = volumes->count <= 60};
	}
	if (count == 0)
		return;
	html_legend_begin(report);
	for (size_t i = 0, at = 0; i < report->count; i++)
		for (size_t k = 0; k < HTML_VOLUMES && report->runs[i].volumes.count > 1; k++)
			html_legend_line(report, &lines[at++], report->runs[i].folder, names[k]);
	html_legend_end(report);
	const struct html_plot plot = {.title = "Volume over time", .across = "time, s", .up = "volume, m3", .lines = lines, .count = count, .zero = true, .upright = (double)NAN};
	fputs("<div class=\"plots wide\">\n", report->file);
	html_plot_write(&plot, report->file);
	fputs("</div>\n<p class=\"small\">A point for each commit, which are some seconds of wall clock apart. Volumes are those below and above the ground as it was imported.</p>\n",
	      report->file);
}
