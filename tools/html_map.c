/*
 * The map of each drive: its ways over the ground that it left. Lines and words are the page's, the ground is a picture. Where the store does
 * not show any more what the drive left, the map that the drive drew itself stands in its place.
 */
#include <math.h>
#include <string.h>

#include "html_report.h"
#include "scene/scene_file.h"
#include "svg.h"

#define PNG_BYTES (16u << 20)
#define HEAD 24 /* bytes of a PNG until its height ends */

static unsigned number(const unsigned char *at)
{
	return (unsigned)at[0] << 24 | (unsigned)at[1] << 16 | (unsigned)at[2] << 8 | at[3];
}

static void caption(const struct html_report *report, const struct html_run *run)
{
	if (report->count < 2)
		return;
	fputs("<figcaption>", report->file);
	svg_text(run->folder, report->file);
	fputs("</figcaption>", report->file);
}

/* --- the picture that the drive drew --- */

static enum status write_picture(const struct html_report *report, const struct html_run *run, const char *why)
{
	char path[4200], text[5000];
	char *bytes;
	size_t length;
	snprintf(path, sizeof path, "%s/map.png", run->folder);
	if (!html_is_file(path)) {
		snprintf(text, sizeof text, "No map: %s; and the drive left no map.png", why);
		html_sentence(report, run, text);
		return STATUS_OK;
	}
	enum status status = scene_file_read(path, path, PNG_BYTES, &bytes, &length);
	if (status == STATUS_INPUT) {
		snprintf(text, sizeof text, "No map: %s", failure_message());
		html_sentence(report, run, text);
		return STATUS_OK;
	}
	TRY(status);
	const unsigned char *head = (const unsigned char *)bytes;
	if (length < HEAD || memcmp(bytes, "\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) != 0 || number(head + 16) - 1 >= 65536 || number(head + 20) - 1 >= 65536) {
		html_sentence(report, run, "No map: map.png is no PNG");
	} else {
		snprintf(text, sizeof text, "This is the map that the drive drew at its end, since %s", why);
		html_sentence(report, run, text);
		fprintf(report->file, "<figure><img width=\"%u\" height=\"%u\" alt=\"Map: ways on the hillshade, and by how much the ground changed\" src=\"data:image/png;base64,",
			number(head + 16), number(head + 20));
		html_base64(head, length, report->file);
		fputs("\"/>", report->file);
		caption(report, run);
		fputs("</figure>\n", report->file);
	}
	mem_free(bytes);
	return STATUS_OK;
}

/* --- the map of the page --- */

/* Writes a length with the unit that it needs: mm below 1 m. */
static void length_text(double metres, double largest, char *text, size_t size)
{
	const bool small = largest < 1;
	snprintf(text, size, "%s%.4g%s", metres > 0 ? "+" : "", metres * (small ? 1e3 : 1), metres == 0 ? "" : small ? " mm" : " m");
}

static void write_key(const struct html_report *report, const struct html_map *map)
{
	FILE *file = report->file;
	char low[40], high[40];
	const double largest = fmax(fabs(map->range.low), map->range.high);
	if (largest == 0) {
		fputs("<p class=\"small\">The drive changed no height here.</p>\n", file);
		return;
	}
	length_text(map->range.low, largest, low, sizeof low);
	length_text(map->range.high, largest, high, sizeof high);
	fputs("<svg class=\"ramp\" viewBox=\"0 0 260 34\" role=\"img\"><title>Colours of the change of height</title>", file);
	for (int i = 0; i < HTML_KEY; i++)
		fprintf(file, "<path fill=\"#%02x%02x%02x\" d=\"M%d 0h10.5v12h-10.5z\"/>", map->key[i].r, map->key[i].g, map->key[i].b, 10 + 10 * i);
	fprintf(file, "<text x=\"10\" y=\"27\">%s%s</text>%s<text x=\"250\" y=\"27\" text-anchor=\"end\">%s%s</text></svg>\n", low,
		map->beyond[0] ? " or less" : "", map->range.low < 0 && map->range.high > 0 ? "<text x=\"130\" y=\"27\" text-anchor=\"middle\">0</text>" : "",
		high, map->beyond[1] ? " or more" : "");
	fputs("<p class=\"small\">Colours: by how much the drive changed the height of the ground. Blue is lower, red is higher.", file);
	if (map->holes)
		fputs(" Hatched ground has no data.", file);
	fprintf(file, " Posts of this picture are %g m apart.", map->raster.spacing);
	if (map->raster.rut > 0)
		fprintf(file, " Ruts are drawn at least %g m wide, so that they are seen.", map->raster.rut);
	fputs("</p>\n", file);
}

static void write_coordinates(const struct html_report *report, const struct html_map *map)
{
	FILE *file = report->file;
	if (map->system[0] != '\0' || map->origin[0] != 0 || map->origin[1] != 0) {
		fprintf(file, "<p class=\"small\">Metres are those of the scene: from the terrain's south-west post. That post lies at %.10g, %.10g of ", map->origin[0],
			map->origin[1]);
		svg_text(map->system[0] != '\0' ? map->system : "the terrain's source", file);
		fputs(".</p>\n", file);
	} else {
		fputs("<p class=\"small\">Metres are those of the scene: from the terrain's south-west post.</p>\n", file);
	}
}

static void write_map(const struct html_report *report, size_t index)
{
	const struct html_map *map = &report->maps[index];
	struct html_line lines[HTML_COLOURS + 1];
	double ends[2][2];
	size_t count = 0;
	const struct html_bodies *ways = html_ways(&report->runs[index]);
	for (size_t k = 0; k < ways->count && k < html_bodies_most(report); k++) {
		lines[count] = html_line_of(report, index, k);
		lines[count].x = ways->list[k].x;
		lines[count].y = ways->list[k].y;
		lines[count].count = ways->list[k].count;
		lines[count].begins = true;
		count += lines[count].count > 0;
	}
	if (html_profile(report, index, ends))
		lines[count++] = (struct html_line){.colour = HTML_COLOURS - 1, .dash = 2, .count = 2, .x = ends[0], .y = ends[1], .dots = true};
	const struct html_plot plot = {.title = "Map: the ways over the ground that the drive left", .across = "east, m", .up = "north, m", .lines = lines, .count = count,
				       .map = true, .upright = (double)NAN, .ground = &map->ground};
	fputs("<figure>\n", report->file);
	caption(report, &report->runs[index]);
	html_plot_write(&plot, report->file);
	write_key(report, map);
	fputs("</figure>\n", report->file);
}

enum status html_map_write(const struct html_report *report)
{
	size_t first = report->count;
	html_section(report, "map", "Map");
	for (size_t i = report->count; i-- > 0;)
		if (report->maps[i].ground.png != NULL)
			first = i;
	if (first < report->count)
		html_legend_ways(report);
	fprintf(report->file, "<div class=\"plots%s\">\n", report->count > 1 ? "" : " wide");
	for (size_t i = 0; i < report->count; i++)
		if (report->maps[i].ground.png != NULL)
			write_map(report, i);
		else
			TRY(write_picture(report, &report->runs[i], report->maps[i].why));
	fputs("</div>\n", report->file);
	if (first < report->count) {
		fputs("<p class=\"small\">A way begins at its large dot. A dotted line between two small dots shows where the rut profile lies.</p>\n", report->file);
		if (report->count > 1)
			fputs("<p class=\"small\">All maps that this page draws have one colour scale: the largest of the drives.</p>\n", report->file);
		write_coordinates(report, &report->maps[first]);
	}
	html_section_end(report);
	return STATUS_OK;
}
