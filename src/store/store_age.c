/* The time of a store, in which marks fade. It is a part of the run's record, which otherwise is for the world alone to read. */
#include "store/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"

/* Reads a real number of 0 or more, as the record has it. *value stays as it is where there is none. Returns false if it is damaged. */
static bool take(const cJSON *root, const char *name, double *value)
{
	const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(root, name));
	char *end;
	if (!cJSON_HasObjectItem(root, name))
		return true;
	if (text == NULL || *text == '\0' || strspn(text, "+-.0123456789abcdefpx") != strlen(text))
		return false;
	*value = strtod(text, &end);
	return *end == '\0' && *value >= 0 && *value <= ldexp(PLANE_TIME_MOST, -PLANE_TIME_BITS);
}

static bool take_all(const char *state, struct store_marks *marks)
{
	cJSON *root = cJSON_ParseWithOpts(state, NULL, true);
	marks->any = root != NULL && cJSON_HasObjectItem(root, "since");
	const bool whole = !marks->any || (take(root, "since", &marks->since) && take(root, "heals", &marks->heals) && take(root, "rises", &marks->rises) &&
					   take(root, "grows", &marks->grows) && (marks->rises > 0) == (marks->grows > 0));
	cJSON_Delete(root);
	return whole;
}

enum status store_marks(struct store *store, struct store_marks *marks)
{
	struct store_run run;
	TRY(store_last_run(store, &run));
	return store_last_marks(store, marks);
}

enum status store_last_marks(const struct store *store, struct store_marks *marks)
{
	const struct store_run_copy *copy = &store->last_run;
	*marks = (struct store_marks){.any = false};
	if (!copy->found || strstr(copy->state, "\"since\"") == NULL)
		return STATUS_OK;
	if (!take_all(copy->state, marks) || !isfinite(copy->time) || copy->time < 0)
		return fail_with(STATUS_INPUT, "%s: the time of its last drive is damaged; furrow reset %s", store->path, shell_path(store->path).text);
	marks->time = marks->any ? copy->time : 0;
	return STATUS_OK;
}

static int32_t units(double seconds, int32_t most)
{
	const double units = ldexp(seconds, PLANE_TIME_BITS);
	return units < most ? (int32_t)units : most;
}

struct plane_marks store_marks_at(const struct store_marks *marks, double time)
{
	return (struct plane_marks){
		.now = units(marks->since + time, PLANE_TIME_MOST),
		.heals = units(marks->heals, PLANE_WHOLE_MOST),
		.rises = units(marks->rises, PLANE_WHOLE_MOST),
		.grows = units(marks->grows, PLANE_WHOLE_MOST),
	};
}
