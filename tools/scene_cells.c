/* A row of the table of a scene's keys as cells of text. */
#include "scene_cells.h"

#include <string.h>

#include "scene/scene.h"

static void put(struct scene_cell *cell, const char *text)
{
	const size_t used = strlen(cell->text);
	snprintf(cell->text + used, sizeof cell->text - used, "%s", text);
}

static struct scene_cell count_of(uint32_t least, uint32_t most)
{
	struct scene_cell cell;
	if (least == most)
		snprintf(cell.text, sizeof cell.text, "%u", least);
	else if (most == ENDLESS)
		snprintf(cell.text, sizeof cell.text, "at least %u", least);
	else
		snprintf(cell.text, sizeof cell.text, "%u .. %u", least, most);
	return cell;
}

struct scene_cell scene_cell_type(const struct scene_row *row)
{
	static const char *const kinds[] = {
		[ROW_NUMBER] = "number", [ROW_WHOLE] = "whole number", [ROW_SWITCH] = "switch", [ROW_WORD] = "word", [ROW_TEXT] = "text", [ROW_MAPPING] = "mapping",
	};
	const bool numbers = row->type == ROW_NUMBER || row->type == ROW_WHOLE;
	struct scene_cell cell;
	if (scene_row_lists(row) == 0)
		snprintf(cell.text, sizeof cell.text, "%s", kinds[row->type]);
	else if (row->each > 0)
		snprintf(cell.text, sizeof cell.text, "list of %.40s, each of %u %ss", count_of(row->least, row->most).text, row->each, kinds[row->type]);
	else
		snprintf(cell.text, sizeof cell.text, "list of %.40s%s%s%s", count_of(row->least, row->most).text, numbers ? " " : "", numbers ? kinds[row->type] : "",
			 numbers ? "s" : "");
	return cell;
}

/* A bound as people write it: 1e9, 134217728, 0.001. */
static struct scene_cell bound(double number)
{
	struct scene_cell cell;
	snprintf(cell.text, sizeof cell.text, "%.10g", number);
	char *zeros = strpbrk(cell.text, "e");
	if (zeros != NULL && (zeros[1] == '+' || zeros[1] == '-')) { /* 1e+12 and 1e-06 */
		char *digits = zeros + 1 + (zeros[1] == '+');
		size_t skip = strspn(zeros + 2, "0") + (zeros[1] == '+');
		memmove(digits + (zeros[1] == '-'), zeros + (zeros[1] == '-' ? 2 : 1) + skip, strlen(zeros + (zeros[1] == '-' ? 2 : 1) + skip) + 1);
	}
	if (number >= 1e6 || number <= -1e6)
		for (int power = 6; power < 16; power++) {
			struct scene_cell round;
			snprintf(round.text, sizeof round.text, "%s1e%d", number < 0 ? "-" : "", power);
			double value = 0;
			if (sscanf(round.text, "%lf", &value) == 1 && value == number)
				return round;
		}
	return cell;
}

struct scene_cell scene_cell_range(const struct scene_row *row)
{
	struct scene_cell cell = {""};
	switch (row->type) {
	case ROW_NUMBER:
	case ROW_WHOLE:
		if (row->low == row->high)
			return bound(row->low);
		snprintf(cell.text, sizeof cell.text, "%s%.40s .. %.40s", row->above ? "above " : "", bound(row->low).text, bound(row->high).text);
		return cell;
	case ROW_SWITCH:
		return (struct scene_cell){"`true`, `false`"};
	case ROW_WORD:
		for (const struct scene_word *word = row->words; word->word != NULL; word++) {
			put(&cell, word != row->words ? ", `" : "`");
			put(&cell, word->word);
			put(&cell, "`");
		}
		return cell;
	case ROW_TEXT:
		if (scene_row_lists(row) == 0)
			snprintf(cell.text, sizeof cell.text, "%u bytes", row->longest);
		return cell;
	default:
		return cell;
	}
}

struct scene_cell scene_cell_default(const struct scene_row *row)
{
	struct scene_cell cell;
	if (row->has_default)
		snprintf(cell.text, sizeof cell.text, "%.10g", row->absent);
	else
		snprintf(cell.text, sizeof cell.text, "%s", row->otherwise != NULL ? row->otherwise : row->needs != NULL ? row->needs : "needed");
	return cell;
}

/* Whether an effect names `path`: as objects.load, or as view.size[] of its entries. */
static bool is_of(const char *named, const char *path)
{
	static const char objects[] = "objects.";
	if (strncmp(named, objects, strlen(objects)) == 0 && strncmp(path, "objects[].", strlen("objects[].")) == 0)
		return strcmp(named + strlen(objects), path + strlen("objects[].")) == 0;
	const size_t length = strlen(named);
	const bool entries = length > 2 && strcmp(named + length - 2, "[]") == 0;
	return strlen(path) == length - (entries ? 2 : 0) && strncmp(named, path, strlen(path)) == 0;
}

struct scene_cell scene_cell_effects(const char *path)
{
	struct scene_cell cell = {""};
	for (int e = 0; e < EFFECT_COUNT; e++) {
		const struct effect_row *effect = scene_effect_row((enum scene_effect)e);
		const bool calls = is_of(effect->key, path);
		bool uses = false;
		for (const char *const *key = effect->parameters; *key != NULL && !uses; key++)
			uses = is_of(*key, path);
		if (!calls && !uses)
			continue;
		put(&cell, cell.text[0] != '\0' ? ", " : "");
		put(&cell, calls ? "**" : "");
		put(&cell, effect->name);
		put(&cell, calls ? "**" : "");
	}
	return cell;
}

struct scene_cell scene_cell_plain(const char *markdown)
{
	struct scene_cell cell = {""};
	size_t used = 0;
	for (const char *c = markdown; *c != '\0' && used + 1 < sizeof cell.text; c++) {
		if (*c == '`' || (c[0] == '*' && c[1] == '*')) {
			c += *c == '*';
			continue;
		}
		const char *label = *c == '[' ? strchr(c, ']') : NULL;
		if (label != NULL && label[1] == '(' && label > c + 1) { /* [label](target) */
			used += (size_t)snprintf(cell.text + used, sizeof cell.text - used, "%.*s", (int)(label - c - 1), c + 1);
			c = strchr(label, ')');
			continue;
		}
		cell.text[used++] = *c;
	}
	cell.text[used < sizeof cell.text ? used : sizeof cell.text - 1] = '\0';
	return cell;
}

const struct scene_row *scene_cell_find(const char *text, struct scene_cell *path)
{
	const struct scene_row *rows = scene_schema, *row = NULL;
	bool named = false; /* the last part may be the name of an entry */
	*path = (struct scene_cell){""};
	while (*text != '\0') {
		const size_t length = strcspn(text, ".[");
		const struct scene_row *found = rows != NULL ? scene_row_find(rows, text, length) : NULL;
		if (found == NULL && (!named || text[length] == '\0'))
			return NULL;
		named = found != NULL && found->form == ROW_LIST && found->type == ROW_MAPPING;
		if (found != NULL) {
			row = found;
			put(path, path->text[0] != '\0' ? "." : "");
			put(path, row->key);
			rows = row->type == ROW_MAPPING ? row->rows : NULL;
			text += length;
			text += strncmp(text, "[]", 2) == 0 ? 2 : 0;
			if (*text != '\0' && named)
				put(path, "[]");
		} else {
			text += length;
		}
		if (*text != '\0' && *text++ != '.')
			return NULL;
	}
	return row;
}
