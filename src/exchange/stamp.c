/*
 * What a folder of tiles holds, and what of an export is done.
 *
 *   no stamp -> journal -> stamp          the first export
 *      stamp -> stamp and journal -> stamp    a later one
 *
 * The stamp, furrow-tiles.json, says of which terrain and revision the complete tiles are. The journal, furrow-tiles.journal, is
 * there while an export is unfinished. Its first line is the export's request. Each other line has the number of a unit of work
 * that is complete, and a full stop. A line without it was cut short.
 */
#include "exchange/internal.h"

#include <cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/json.h"
#include "base/limits.h"

#define STAMP "furrow-tiles.json"
#define JOURNAL "furrow-tiles.journal"
#define FORMAT 1

static enum status path_in(const char *directory, const char *name, char path[EXCHANGE_PATH])
{
	int length = snprintf(path, EXCHANGE_PATH, "%s/%s", directory, name);
	return length < EXCHANGE_PATH - 64 ? STATUS_OK : fail_with(STATUS_INPUT, "%.80s...: the path is too long; give a shorter one", directory);
}

static enum status parse(const struct exchange_bytes *bytes, const char *path, struct exchange_stamp *stamp)
{
	cJSON *root = cJSON_ParseWithLength((const char *)bytes->data, bytes->size);
	const cJSON *format = cJSON_GetObjectItem(root, "format"), *terrain = cJSON_GetObjectItem(root, "terrain");
	const cJSON *revision = cJSON_GetObjectItem(root, "revision"), *range = cJSON_GetObjectItem(root, "ruts_range");
	const cJSON *look = cJSON_GetObjectItem(root, "look"), *low = cJSON_GetArrayItem(range, 0), *high = cJSON_GetArrayItem(range, 1);
	const cJSON *version = cJSON_GetObjectItem(root, "version"), *resets = cJSON_GetObjectItem(root, "resets");
	const bool whole = cJSON_IsNumber(format) && format->valuedouble == FORMAT && cJSON_IsString(terrain) && cJSON_IsNumber(revision) &&
			   cJSON_IsNumber(low) && cJSON_IsNumber(high) && cJSON_IsString(look) && low->valuedouble < 0 && high->valuedouble > 0;
	if (whole) {
		snprintf(stamp->terrain, sizeof stamp->terrain, "%s", terrain->valuestring);
		stamp->revision = (int64_t)revision->valuedouble;
		stamp->resets = cJSON_IsNumber(resets) ? (int64_t)resets->valuedouble : 0;
		stamp->range[0] = low->valuedouble;
		stamp->range[1] = high->valuedouble;
		stamp->look = strtoull(look->valuestring, NULL, 16);
		snprintf(stamp->version, sizeof stamp->version, "%s", cJSON_IsString(version) ? version->valuestring : "");
	}
	cJSON_Delete(root);
	return whole ? STATUS_OK
		     : fail_with(STATUS_INPUT, "%s: is not the record of a folder of tiles; remove the folder, or give another", path);
}

enum status exchange_stamp_read(const char *directory, struct exchange_stamp *stamp, bool *found)
{
	char path[EXCHANGE_PATH];
	struct exchange_bytes bytes = {.data = NULL};
	*stamp = (struct exchange_stamp){.revision = 0};
	TRY(path_in(directory, STAMP, path));
	enum status status = exchange_file_get(path, 1 << 20, &bytes, found);
	if (status == STATUS_OK && *found)
		status = parse(&bytes, path, stamp);
	exchange_bytes_finish(&bytes);
	return status;
}

enum status exchange_stamp_remove(const char *directory)
{
	char path[EXCHANGE_PATH];
	bool removed;
	TRY(path_in(directory, STAMP, path));
	return exchange_file_remove(path, &removed);
}

enum status exchange_stamp_write(const char *directory, const struct exchange_stamp *stamp)
{
	char path[EXCHANGE_PATH], look[20];
	TRY(path_in(directory, STAMP, path));
	cJSON *root = cJSON_CreateObject();
	snprintf(look, sizeof look, "%016llx", (unsigned long long)stamp->look);
	json_integer(root, "format", FORMAT);
	cJSON_AddStringToObject(root, "terrain", stamp->terrain);
	json_integer(root, "revision", stamp->revision);
	if (stamp->resets > 0)
		json_integer(root, "resets", stamp->resets);
	cJSON_AddItemToObject(root, "ruts_range", cJSON_CreateDoubleArray(stamp->range, 2));
	cJSON_AddStringToObject(root, "look", look);
	cJSON_AddStringToObject(root, "version", stamp->version);
	char *text = cJSON_Print(root);
	cJSON_Delete(root);
	TRY_MEM(text, path);
	bool written;
	const struct exchange_bytes bytes = {.data = (uint8_t *)text, .size = strlen(text)};
	enum status status = exchange_file_put(path, &bytes, &written);
	cJSON_free(text);
	return status;
}

/* Reads what an unfinished export has done. Returns false if the journal is that of another request. */
static bool read_done(struct exchange_journal *journal, const char *request)
{
	char line[2048];
	if (fgets(line, sizeof line, journal->file) == NULL || strcspn(line, "\n") != strlen(request) ||
	    strncmp(line, request, strlen(request)) != 0)
		return false;
	while (fgets(line, sizeof line, journal->file) != NULL) {
		char *end;
		long long unit = strtoll(line, &end, 10);
		if (end == line || strcmp(end, ".\n") != 0 || unit < 0 || unit >= journal->units)
			continue; /* a line that was cut short */
		journal->kept += !journal->done[unit];
		journal->done[unit] = 1;
	}
	return true;
}

enum status exchange_journal_begin(struct exchange_journal *journal, const char *directory, const char *request, int64_t units)
{
	*journal = (struct exchange_journal){.units = units};
	TRY(path_in(directory, JOURNAL, journal->path));
	TRY(mem_zeroed(&journal->done, (size_t)units + 1, 1, "the journal of tiles"));
	journal->file = output_open(journal->path, "a+");
	if (journal->file == NULL)
		return fail_with(STATUS_FAILED, "%s: cannot be written: %s; %s", journal->path, input_problem(),
				 limits_advice(errno, "give a folder that can be written"));
	if (flock(fileno(journal->file), LOCK_EX | LOCK_NB) != 0)
		return fail_with(STATUS_FAILED, "%s: another export writes to this folder; wait for it, or give another folder", directory);
	rewind(journal->file);
	bool goes_on = read_done(journal, request);
	if (!goes_on && ftruncate(fileno(journal->file), 0) != 0)
		return fail_with(STATUS_FAILED, "%s: cannot be written: %s; check its permissions", journal->path, strerror(errno));
	/* A line that was cut short is ended, and is then none. */
	fseek(journal->file, 0, SEEK_END);
	bool written = goes_on ? fputs("\n", journal->file) >= 0 : fprintf(journal->file, "%s\n", request) >= 0;
	return written && fflush(journal->file) == 0
		       ? STATUS_OK
		       : fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", journal->path, strerror(errno));
}

enum status exchange_journal_add(struct exchange_journal *journal, int64_t unit)
{
	bool written = fprintf(journal->file, "%lld.\n", (long long)unit) > 0 && fflush(journal->file) == 0;
	return written ? STATUS_OK
		       : fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space", journal->path, strerror(errno));
}

enum status exchange_journal_end(struct exchange_journal *journal)
{
	bool removed;
	return exchange_file_remove(journal->path, &removed);
}

void exchange_journal_finish(struct exchange_journal *journal)
{
	if (journal->file != NULL)
		fclose(journal->file);
	mem_free(journal->done);
	*journal = (struct exchange_journal){.file = NULL};
}
