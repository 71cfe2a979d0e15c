/* The table of a scene's keys as text: what furrow scene, the tables of SCENE.md, the schema for editors and the completions are made of. */
#ifndef FURROW_TOOLS_SCENE_CELLS_H
#define FURROW_TOOLS_SCENE_CELLS_H

#include <stdio.h>

#include "json.h"
#include "scene/scene_row.h"

struct scene_cell {
	char text[800];
};

/* --- scene_cells.c --- */
struct scene_cell scene_cell_type(const struct scene_row *row);    /* "list of 2 numbers" */
struct scene_cell scene_cell_range(const struct scene_row *row);   /* "above 0 .. 1000", "`on`, `off`", "64 bytes"; "": none */
struct scene_cell scene_cell_default(const struct scene_row *row); /* "0.02", "the named soil's", "needed with points" */
/* The effects that the key at `path` calls for, in **bold**, and those that it is a parameter of. */
struct scene_cell scene_cell_effects(const char *path);
/* Markdown without its marks: links become their labels. */
struct scene_cell scene_cell_plain(const char *markdown);
/* Makes `text` a path with [] behind each list, as the table has it: objects.sink and objects.NAME.sink become objects[].sink. Returns its row, or NULL. */
const struct scene_row *scene_cell_find(const char *text, struct scene_cell *path);

/* --- scene_tables.c: the tables of SCENE.md, each below the heading of its section --- */
enum status scene_tables_print(FILE *file) FURROW_CHECKED;

/* --- scene_editor.c: JSON Schema, draft 2020-12. NULL: out of memory --- */
cJSON *scene_editor_schema(void);

#endif
