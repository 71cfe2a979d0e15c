/* The tables of src/scene/SCENE.md. Each key is in the table of its section; keys of the scene itself are in the first. */
#include <string.h>

#include "scene_cells.h"

static const struct section {
	const char *heading;
	const char *of[4]; /* keys of the scene whose own keys are here */
} sections[] = {
	{"The drive", {"relief", "stuck"}},
	{"Attributes", {"attributes"}},
	{"Objects", {"objects"}},
	{"Vehicles", {"vehicles"}},
	{"Soil and what it does", {"soil", "ground", "redistribute"}},
	{"Output, view, cache", {"output", "view", "cache"}},
	{"Cameras", {"cameras"}},
	{"Lidars", {"lidars"}},
};

struct table {
	FILE *file;
	const struct section *section;
};

static bool is_in(const struct section *section, const char *path)
{
	const size_t length = strcspn(path, ".[");
	if (path[length] == '\0')
		return section == sections;
	for (size_t i = 0; i < sizeof section->of / sizeof *section->of && section->of[i] != NULL; i++)
		if (strncmp(section->of[i], path, length) == 0 && section->of[i][length] == '\0')
			return true;
	return false;
}

static enum status put_row(void *user, const char *path, const struct scene_row *row)
{
	const struct table *table = user;
	if (is_in(table->section, path))
		fprintf(table->file, "| `%s` | %s | %s | %s | %s | %s | %s |\n", path, scene_cell_type(row).text, row->unit != NULL ? row->unit : "",
			scene_cell_range(row).text, scene_cell_default(row).text, row->text != NULL ? row->text : "", scene_cell_effects(path).text);
	return STATUS_OK;
}

enum status scene_tables_print(FILE *file)
{
	for (size_t i = 0; i < sizeof sections / sizeof *sections; i++) {
		fprintf(file, "## %s\n\n| key | type | unit | range | default | what it does | effect |\n| --- | --- | --- | --- | --- | --- | --- |\n", sections[i].heading);
		TRY(scene_row_visit(put_row, &(struct table){file, &sections[i]}));
		fputc('\n', file);
	}
	return STATUS_OK;
}
