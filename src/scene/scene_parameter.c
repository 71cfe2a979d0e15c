/*
 * Tells what a scene may have at a key: its type, and the range, unit and default of a number. The answers come from the table of keys.
 */
#include <math.h>
#include <stdio.h>

#include "scene/scene.h"
#include "scene/scene_error.h"
#include "scene/scene_row.h"

bool scene_parameter(const char *key, struct scene_parameter *parameter)
{
	static const char *const kinds[] = {
		[ROW_NUMBER] = "number", [ROW_WHOLE] = "whole number", [ROW_SWITCH] = "switch", [ROW_WORD] = "word", [ROW_TEXT] = "text",
		[ROW_MAPPING] = "mapping",
	};
	bool entry = true;
	const struct scene_row *row = scene_row_at(key, &entry);
	if (row == NULL)
		return false;
	*parameter = (struct scene_parameter){.kind = entry ? kinds[row->type] : "list", .low = NAN, .high = NAN, .absent = NAN};
	if (entry && (row->type == ROW_NUMBER || row->type == ROW_WHOLE)) {
		parameter->unit = row->unit;
		parameter->low = row->low;
		parameter->high = row->high;
		parameter->above = row->above;
		parameter->absent = row->has_default ? row->absent : NAN;
		parameter->otherwise = row->otherwise;
	}
	struct scene_list words = {.length = 0};
	for (const struct scene_word *word = entry && row->type == ROW_WORD ? row->words : NULL; word != NULL && word->word != NULL; word++)
		scene_list_add(&words, word->word);
	snprintf(parameter->words, sizeof parameter->words, "%.95s", words.text);
	return true;
}
