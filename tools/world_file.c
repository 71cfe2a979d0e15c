/* The world file of a map's picture, and GDAL's file with its reference system: see world_file.h. */
#include "world_file.h"

#include <stdio.h>
#include <string.h>

#include "base/aside.h"
#include "xml.h"

/* Places in a world file are those of pixels' centres. */
static void put_lines(FILE *file, const struct store_meta *meta, const struct chart_place *place)
{
	fprintf(file, "%.15g\n0\n0\n%.15g\n%.15g\n%.15g\n", place->east, -place->south, meta->origin[0] + place->west_edge + place->east / 2,
		meta->origin[1] + place->north_edge - place->south / 2);
}

static void put_system(FILE *file, const struct store_meta *meta)
{
	fputs("<PAMDataset>\n  <SRS dataAxisToSRSAxisMapping=\"1,2\">", file);
	xml_text(meta->srs, file);
	fputs("</SRS>\n</PAMDataset>\n", file);
}

enum status world_file_write(const char *picture, const struct store_meta *meta, const struct chart_place *place)
{
	const size_t length = strlen(picture), stem = length - strlen(".png");
	struct aside lines = {.path = NULL}, system = {.path = NULL};
	char *names = mem_alloc(2, length + sizeof ".aux.xml");
	TRY_MEM(names, "a world file");
	char *lines_name = names, *system_name = names + length + sizeof ".aux.xml";
	snprintf(lines_name, length + 1, "%.*s.pgw", (int)stem, picture);
	snprintf(system_name, length + sizeof ".aux.xml", "%s.aux.xml", picture);
	enum status status;
	TRY_OR(done, aside_begin(&lines, lines_name));
	put_lines(lines.file, meta, place);
	TRY_OR(done, aside_whole(&lines, false));
	if (meta->srs[0] != '\0') {
		TRY_OR(done, aside_begin(&system, system_name));
		put_system(system.file, meta);
		TRY_OR(done, aside_end(&system, false, STATUS_OK));
	}
	TRY_OR(done, aside_publish(&lines));
done:
	aside_finish(&lines);
	aside_finish(&system);
	mem_free(names);
	return status;
}
