/* What the cameras of a drive did, and their first and last pictures. */
#include <math.h>
#include <string.h>

#include "html_picture.h"
#include "html_report.h"
#include "svg.h"

#define THUMB 320        /* pixels of a picture's longer side */
#define CAMERAS_MOST 6   /* of a drive, whose pictures are shown */
#define ROWS_MOST 200    /* of a drive, in the table */

static const cJSON *member(const cJSON *object, const char *key)
{
	return cJSON_GetObjectItemCaseSensitive(object, key);
}

static double number(const cJSON *object, const char *key)
{
	const cJSON *value = member(object, key);
	return cJSON_IsNumber(value) && isfinite(value->valuedouble) ? value->valuedouble : (double)NAN;
}

static void text_cell(const struct html_report *report, const char *text)
{
	if (text == NULL || text[0] == '\0') {
		fputs("<td class=\"none\">&#8211;</td>", report->file);
		return;
	}
	fputs("<td>", report->file);
	svg_text(text, report->file);
	fputs("</td>", report->file);
}

static void number_cell(const struct html_report *report, double value)
{
	char text[40] = "";
	if (isfinite(value))
		snprintf(text, sizeof text, "%.6g", value);
	text_cell(report, text);
}

/* Where a camera was: metres of the scene, and where it looked. */
static void place_cell(const struct html_report *report, const cJSON *frame)
{
	const cJSON *at = member(frame, "position"), *turn = member(frame, "orientation");
	double p[3], q[4];
	char text[160] = "";
	bool whole = cJSON_GetArraySize(at) == 3 && cJSON_GetArraySize(turn) == 4;
	for (int i = 0; i < 3 && whole; i++)
		whole = cJSON_IsNumber(cJSON_GetArrayItem(at, i)) && fabs(p[i] = cJSON_GetArrayItem(at, i)->valuedouble) < 1e12;
	for (int i = 0; i < 4 && whole; i++)
		whole = cJSON_IsNumber(cJSON_GetArrayItem(turn, i)) && fabs(q[i] = cJSON_GetArrayItem(turn, i)->valuedouble) < 2;
	if (whole) { /* the third column of the rotation: where its axis ahead points */
		const double ahead[3] = {2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]), 1 - 2 * (q[0] * q[0] + q[1] * q[1])};
		const double level = hypot(ahead[0], ahead[1]), bearing = fmod(atan2(ahead[0], ahead[1]) * 180 / M_PI + 360, 360);
		snprintf(text, sizeof text, "%.2f, %.2f, %.2f m; looks to %.0f°, %.0f° %s", p[0], p[1], p[2], bearing, fabs(atan2(ahead[2], level)) * 180 / M_PI,
			 ahead[2] < 0 ? "down" : "up");
	}
	fprintf(report->file, "<td class=\"place\">");
	svg_text(text, report->file);
	fputs("</td>", report->file);
}

static void camera_row(const struct html_report *report, const struct html_run *run, const cJSON *camera)
{
	char text[200];
	const cJSON *image;
	size_t used = 0;
	fputs("<tr><th scope=\"row\">", report->file);
	if (report->count > 1) {
		svg_text(run->folder, report->file);
		fputs(": ", report->file);
	}
	svg_text(camera->string, report->file);
	fputs("</th>", report->file);
	const char *kind = cJSON_GetStringValue(member(camera, "kind")), *on = cJSON_GetStringValue(member(camera, "on"));
	snprintf(text, sizeof text, "%.60s%s%.100s", kind != NULL ? kind : "", on != NULL ? ", on " : "", on != NULL ? on : "");
	text_cell(report, text);
	snprintf(text, sizeof text, "%.0f x %.0f", number(camera, "width"), number(camera, "height"));
	text_cell(report, isfinite(number(camera, "width") + number(camera, "height")) ? text : NULL);
	number_cell(report, number(camera, "fov_horizontal"));
	number_cell(report, number(camera, "rate"));
	number_cell(report, number(camera, "frames"));
	text[0] = '\0';
	cJSON_ArrayForEach(image, member(camera, "images")) {
		const char *name = cJSON_GetStringValue(image);
		if (name != NULL && used < sizeof text - 40)
			used += (size_t)snprintf(text + used, sizeof text - used, "%s%.30s", used > 0 ? ", " : "", name);
	}
	text_cell(report, text);
	place_cell(report, member(camera, "first"));
	place_cell(report, member(camera, "last"));
	fputs("</tr>\n", report->file);
}

/* --- pictures --- */

/* Names of folders come from run.json, which is not trusted: no name leads out of the drive's folder. */
static bool is_name(const char *name)
{
	return name != NULL && name[0] != '\0' && name[0] != '.' && strchr(name, '/') == NULL && strlen(name) < 200;
}

static enum status write_thumb(const struct html_report *report, const struct html_run *run, const cJSON *camera, const char *image, const char *which)
{
	char path[4800];
	struct html_picture picture;
	const double frame = number(member(camera, which), "frame"), time = number(member(camera, which), "time");
	if (!(frame >= 0 && frame < 1e9))
		return STATUS_OK;
	snprintf(path, sizeof path, "%s/cameras/%s/%s/%06.0f.png", run->folder, camera->string, image, floor(frame));
	enum status status = html_picture_read(path, THUMB, &picture);
	if (status == STATUS_INPUT) {
		html_sentence(report, run, failure_message());
		return STATUS_OK;
	}
	TRY(status);
	fprintf(report->file, "<figure><img width=\"%u\" height=\"%u\" alt=\"The %s picture\" src=\"data:image/png;base64,", picture.width, picture.height, which);
	html_base64(picture.png, picture.length, report->file);
	fputs("\"/><figcaption>", report->file);
	if (report->count > 1) {
		svg_text(run->folder, report->file);
		fputs(", ", report->file);
	}
	svg_text(camera->string, report->file);
	fprintf(report->file, ", %s picture, %.4g s</figcaption></figure>\n", which, time);
	html_picture_finish(&picture);
	return STATUS_OK;
}

static enum status write_pictures(const struct html_report *report, const struct html_run *run)
{
	const cJSON *camera;
	size_t shown = 0;
	char text[120];
	const int count = cJSON_GetArraySize(html_members(run, "cameras"));
	cJSON_ArrayForEach(camera, html_members(run, "cameras")) {
		const char *image = cJSON_GetStringValue(cJSON_GetArrayItem(member(camera, "images"), 0));
		if (shown == CAMERAS_MOST)
			break;
		shown++;
		if (!is_name(camera->string) || !is_name(image))
			continue;
		TRY(write_thumb(report, run, camera, image, "first"));
		if (number(camera, "frames") > 1)
			TRY(write_thumb(report, run, camera, image, "last"));
	}
	if (count > CAMERAS_MOST) {
		snprintf(text, sizeof text, "The page shows the pictures of the first %d of %d cameras", CAMERAS_MOST, count);
		html_sentence(report, run, text);
	}
	return STATUS_OK;
}

enum status html_cameras_write(const struct html_report *report)
{
	bool any = false;
	for (size_t i = 0; i < report->count; i++)
		any = any || cJSON_GetArraySize(html_members(&report->runs[i], "cameras")) > 0;
	if (!any)
		return STATUS_OK;
	html_section(report, "cameras", "Cameras");
	fputs("<div class=\"scroll\"><table><thead><tr><th scope=\"col\">camera</th><th scope=\"col\">kind</th><th scope=\"col\">pixels</th><th scope=\"col\">field of view, degrees</th>"
	      "<th scope=\"col\">frames a second</th><th scope=\"col\">frames</th><th scope=\"col\">images</th><th scope=\"col\">first frame from</th><th scope=\"col\">last frame from</th>"
	      "</tr></thead><tbody>\n", report->file);
	for (size_t i = 0; i < report->count; i++) {
		const cJSON *camera;
		size_t rows = 0;
		cJSON_ArrayForEach(camera, html_members(&report->runs[i], "cameras")) {
			if (rows++ < ROWS_MOST && camera->string != NULL)
				camera_row(report, &report->runs[i], camera);
		}
	}
	html_table_end(report);
	fputs("<p class=\"small\">Places are east, north and height, in metres of the scene. Directions are degrees clockwise from north, and below or above the horizon.</p>\n"
	      "<div class=\"thumbs\">\n", report->file);
	for (size_t i = 0; i < report->count; i++)
		TRY(write_pictures(report, &report->runs[i]));
	fputs("</div>\n", report->file);
	html_section_end(report);
	return STATUS_OK;
}
