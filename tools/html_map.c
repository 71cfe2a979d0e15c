/* The maps that drives drew, as data within the page. */
#include <errno.h>
#include <string.h>

#include "html_report.h"
#include "scene/scene_file.h"
#include "svg.h"

#define PNG_BYTES (16u << 20)
#define HEAD 24 /* bytes of a PNG until its height ends */

static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/* Base64, as RFC 4648 has it. */
static void write_data(const unsigned char *bytes, size_t length, FILE *file)
{
	for (size_t i = 0; i < length; i += 3) {
		const unsigned a = bytes[i], b = i + 1 < length ? bytes[i + 1] : 0, c = i + 2 < length ? bytes[i + 2] : 0;
		fputc(digits[a >> 2], file);
		fputc(digits[(a & 3) << 4 | b >> 4], file);
		fputc(i + 1 < length ? digits[(b & 15) << 2 | c >> 6] : '=', file);
		fputc(i + 2 < length ? digits[c & 63] : '=', file);
	}
}

static unsigned number(const unsigned char *at)
{
	return (unsigned)at[0] << 24 | (unsigned)at[1] << 16 | (unsigned)at[2] << 8 | at[3];
}

static enum status write_map(const struct html_report *report, const struct html_run *run)
{
	char path[4200], why[4300];
	char *bytes;
	size_t length;
	snprintf(path, sizeof path, "%s/map.png", run->folder);
	if (!html_is_file(path)) {
		html_sentence(report, run, "No map: the drive left no map.png");
		return STATUS_OK;
	}
	enum status status = scene_file_read(path, path, PNG_BYTES, &bytes, &length);
	if (status == STATUS_INPUT) {
		snprintf(why, sizeof why, "No map: %s", failure_message());
		html_sentence(report, run, why);
		return STATUS_OK;
	}
	if (status != STATUS_OK)
		return status;
	const unsigned char *head = (const unsigned char *)bytes;
	if (length < HEAD || memcmp(bytes, "\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) != 0 || number(head + 16) - 1 >= 65536 || number(head + 20) - 1 >= 65536) {
		html_sentence(report, run, "No map: map.png is no PNG");
	} else {
		fprintf(report->file, "<figure><img width=\"%u\" height=\"%u\" alt=\"Map: ways on the hillshade, and by how much the ground changed\" src=\"data:image/png;base64,",
			number(head + 16), number(head + 20));
		write_data(head, length, report->file);
		fputs("\"/>", report->file);
		if (report->count > 1) {
			fputs("<figcaption>", report->file);
			svg_text(run->folder, report->file);
			fputs("</figcaption>", report->file);
		}
		fputs("</figure>\n", report->file);
	}
	mem_free(bytes);
	return STATUS_OK;
}

enum status html_map_write(const struct html_report *report)
{
	enum status status = STATUS_OK;
	html_section(report, "map", "Map");
	fputs("<div class=\"plots\">\n", report->file);
	for (size_t i = 0; i < report->count && status == STATUS_OK; i++)
		status = write_map(report, &report->runs[i]);
	fputs("</div>\n", report->file);
	html_section_end(report);
	return status;
}
