/* furrow rig: lists of numbers of its command line. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "rig_table.h"

static enum status add(const char *option, double value, double *list, size_t *count)
{
	if (*count == RIG_VALUES_MOST)
		return fail_with(STATUS_USAGE, "rig: --%s: are more than %d numbers; give fewer", option, RIG_VALUES_MOST);
	list[(*count)++] = value;
	return STATUS_OK;
}

/* An item: a number, or LOW:HIGH:STEP. */
static enum status read_item(const char *option, const char *item, double *list, size_t *count)
{
	char text[128];
	const char *parts[3] = {NULL, NULL, NULL};
	double numbers[3];
	int found = 0;
	if (strcmp(option, "slip") == 0 && strcmp(item, "locked") == 0)
		return add(option, RIG_SLIP_LOCKED, list, count);
	snprintf(text, sizeof text, "%s", item);
	for (char *rest = text, *part; (part = strsep(&rest, ":")) != NULL && found < 4; found++)
		if (found < 3)
			parts[found] = part;
	bool good = strlen(item) < sizeof text && (found == 1 || found == 3);
	for (int i = 0; i < found && good; i++)
		good = parse_number(parts[i], &numbers[i]);
	if (!good || (found == 3 && !(numbers[2] > 0 && numbers[1] >= numbers[0])))
		return fail_with(STATUS_USAGE, "rig: --%s %s: is no number and no range; give one as in 0.2 or 0:0.8:0.1", option, item);
	if (found == 1)
		return add(option, numbers[0], list, count);
	const double steps = floor((numbers[1] - numbers[0]) / numbers[2] + 1e-9);
	for (double i = 0; i <= steps; i++) {
		const double value = numbers[0] + i * numbers[2];
		TRY(add(option, fabs(value) < 1e-9 * numbers[2] ? 0 : value, list, count));
	}
	return STATUS_OK;
}

enum status rig_list_read(const struct arguments *arguments, const char *option, const char *otherwise, double *list, size_t *count)
{
	const char *given = arguments_text(arguments, option);
	if (given == NULL)
		given = otherwise;
	if (given == NULL)
		return STATUS_OK;
	char *text = mem_strdup(given), *rest = text, *item;
	TRY_MEM(text, "a list");
	enum status status = STATUS_OK;
	while ((item = strsep(&rest, ",")) != NULL)
		TRY_OR(done, read_item(option, item, list, count));
done:
	mem_free(text);
	return status;
}
