/* How much there is of what, and the last run. */
#include "store/internal.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static enum status count_table(const struct rows *rows, enum row_table table, int64_t *tiles, int64_t *bytes)
{
	char sql[96];
	sqlite3_stmt *statement = NULL;
	snprintf(sql, sizeof sql, "SELECT count(*), coalesce(sum(length(blob)), 0) FROM %s", rows_sql_name(table));
	enum status status = sql_prepare(rows->db, rows->path, &statement, sql);
	if (status != STATUS_OK)
		return status;
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW) {
		*tiles = sqlite3_column_int64(statement, 0);
		*bytes = sqlite3_column_int64(statement, 1);
	} else {
		status = sql_fail(rows->db, code, rows->path, "counting its tiles");
	}
	sqlite3_finalize(statement);
	return status;
}

static enum status keep_text(char **kept, const unsigned char *text)
{
	mem_free(*kept);
	*kept = mem_strdup(text != NULL ? (const char *)text : "");
	return *kept != NULL ? STATUS_OK : fail_memory("the run's record");
}

static enum status last_run(struct store *store, int64_t *epoch, struct store_run *run)
{
	sqlite3_stmt *statement = NULL;
	*epoch = 0;
	*run = (struct store_run){0};
	enum status status = sql_prepare(store->db, store->path, &statement,
					 "SELECT epoch, scene_hash, step, time, state FROM run WHERE id = 1");
	if (status != STATUS_OK)
		return status;
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW) {
		status = keep_text(&store->api_scene, sqlite3_column_text(statement, 1));
		if (status == STATUS_OK)
			status = keep_text(&store->run_state, sqlite3_column_text(statement, 4));
		*epoch = sqlite3_column_int64(statement, 0);
		*run = (struct store_run){
			.scene_hash = store->api_scene,
			.step = sqlite3_column_int64(statement, 2),
			.time = sqlite3_column_double(statement, 3),
			.state = store->run_state,
		};
	} else if (code != SQLITE_DONE) {
		status = sql_fail(store->db, code, store->path, "reading the run's record");
	}
	sqlite3_finalize(statement);
	return status;
}

enum status store_last_run(struct store *store, struct store_run *run)
{
	int64_t epoch;
	return last_run(store, &epoch, run);
}

enum status store_count(struct store *store, struct store_numbers *numbers)
{
	*numbers = (struct store_numbers){0};
	struct stat file;
	if (stat(store->real_path, &file) != 0)
		return fail_with(STATUS_FAILED, "%s: %s; check the path", store->path, strerror(errno));
	numbers->file_bytes = file.st_size;
	enum status status = count_table(store->base, ROW_BASE, &numbers->base_tiles, &numbers->base_bytes);
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++)
		status = count_table(&store->rows, row_table_of((enum plane)plane), &numbers->plane_tiles[plane],
				     &numbers->plane_bytes[plane]);
	if (status == STATUS_OK)
		status = meta_compacted(store->db, store->path, &numbers->compacted);
	return status == STATUS_OK ? last_run(store, &numbers->epochs, &numbers->last_run) : status;
}
