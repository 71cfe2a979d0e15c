/* Finds rows in the table of a scene's keys; see scene_row.h. */
#include "scene/scene_row.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

struct scene_rows scene_rows_begin(const struct scene_row *rows)
{
	return (struct scene_rows){.next = {rows}};
}

const struct scene_row *scene_rows_next(struct scene_rows *walk)
{
	for (;;) {
		const struct scene_row *row = walk->next[walk->depth];
		if (row->key != NULL) {
			walk->next[walk->depth]++;
			return row;
		}
		if (row->include != NULL) {
			walk->next[walk->depth++]++;
			assert(walk->depth < (int)(sizeof walk->next / sizeof *walk->next));
			walk->next[walk->depth] = row->include;
		} else if (walk->depth-- == 0) {
			walk->depth = 0;
			return NULL;
		}
	}
}

const struct scene_row *scene_row_find(const struct scene_row *rows, const char *key, size_t length)
{
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	while ((row = scene_rows_next(&walk)) != NULL)
		if (strncmp(row->key, key, length) == 0 && row->key[length] == '\0')
			return row;
	return NULL;
}

int scene_row_lists(const struct scene_row *row)
{
	return (row->form == ROW_FIXED || row->form == ROW_LIST) + (row->each > 0);
}

const struct scene_row *scene_row_at(const char *path, bool *entry)
{
	const struct scene_row *rows = scene_schema, *row = NULL;
	while (*path != '\0') {
		const size_t length = strcspn(path, ".[");
		row = rows != NULL ? scene_row_find(rows, path, length) : NULL;
		if (row == NULL)
			return NULL;
		path += length;
		int lists = 0;
		for (; strncmp(path, "[]", 2) == 0; path += 2)
			lists++;
		*entry = lists == scene_row_lists(row);
		if (lists > scene_row_lists(row) || (*path != '\0' && *path != '.'))
			return NULL;
		rows = *entry && row->type == ROW_MAPPING ? row->rows : NULL;
		path += *path == '.';
	}
	return row;
}

/* A visit of all rows, and the arrays that it has been in. */
struct visit {
	scene_row_visit_fn visit;
	void *user;
	const struct scene_row *seen[96];
	size_t count;
};

static enum status visit_rows(struct visit *visit, const struct scene_row *rows, const char *path)
{
	char place[160];
	for (size_t i = 0; i < visit->count; i++)
		if (visit->seen[i] == rows)
			return STATUS_OK;
	assert(visit->count < sizeof visit->seen / sizeof *visit->seen);
	visit->seen[visit->count++] = rows;
	for (const struct scene_row *row = rows; row->key != NULL || row->include != NULL; row++) {
		if (row->key == NULL) {
			TRY(visit_rows(visit, row->include, path));
			continue;
		}
		snprintf(place, sizeof place, "%s%s%s", path, path[0] != '\0' ? "." : "", row->key);
		TRY(visit->visit(visit->user, place, row));
		if (row->type != ROW_MAPPING)
			continue;
		const size_t used = strlen(place);
		snprintf(place + used, sizeof place - used, "%s", row->form == ROW_LIST ? "[]" : "");
		TRY(visit_rows(visit, row->rows, place));
	}
	return STATUS_OK;
}

enum status scene_row_visit(scene_row_visit_fn visit, void *user)
{
	struct visit all = {.visit = visit, .user = user};
	return visit_rows(&all, scene_schema, "");
}

double scene_absent(const char *path)
{
	bool entry;
	const struct scene_row *row = scene_row_at(path, &entry);
	assert(row != NULL && row->has_default);
	return row->absent;
}
