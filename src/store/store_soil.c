/* What the last drive had aboard bodies and in flight. It is a part of the run's record, which otherwise is for the world alone to read. */
#include "store/internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"

/* Reads a whole number of 0 or more, as the record has it; 0 where there is none. Returns false if it is damaged. */
static bool take(const cJSON *root, const char *name, int64_t *value)
{
	const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(root, name));
	char *end;
	*value = 0;
	if (!cJSON_HasObjectItem(root, name))
		return true;
	if (text == NULL || *text < '0' || *text > '9')
		return false;
	errno = 0;
	*value = strtoll(text, &end, 10);
	return *end == '\0' && errno == 0;
}

enum status store_last_soil(struct store *store, int64_t *carried, int64_t *in_flight)
{
	struct store_run_copy run = {.found = false}; /* a copy: store_last_run would overwrite the texts that its caller still holds */
	bool whole = true;
	*carried = *in_flight = 0;
	enum status status = store_run_copy(store, &run);
	if (status == STATUS_OK && run.found && run.scene_hash[0] != '\0' && (strstr(run.state, "\"carried\"") != NULL || strstr(run.state, "\"in_flight\"") != NULL)) {
		cJSON *root = cJSON_ParseWithOpts(run.state, NULL, true);
		whole = root != NULL && take(root, "carried", carried) && take(root, "in_flight", in_flight);
		cJSON_Delete(root);
	}
	store_run_copy_finish(&run);
	TRY(status);
	return whole ? STATUS_OK : fail_with(STATUS_INPUT, "%s: the soil that its last drive had aboard or in flight is damaged; furrow reset %s", store->path,
					     shell_path(store->path).text);
}
