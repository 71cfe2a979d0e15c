/* Counts rows and bytes of a store, and reads its last run. */
#include "store/internal.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static enum status count_table(const struct rows *rows, enum row_table table, int64_t *tiles, int64_t *bytes)
{
	char sql[96];
	sqlite3_stmt *statement = NULL;
	snprintf(sql, sizeof sql, "SELECT count(*), coalesce(sum(length(blob)), 0) FROM %s", store_rows_sql_name(table));
	enum status status = store_sql_prepare(rows->db, rows->path, &statement, sql);
	if (status != STATUS_OK)
		return status;
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW) {
		*tiles = sqlite3_column_int64(statement, 0);
		*bytes = sqlite3_column_int64(statement, 1);
	} else {
		status = store_sql_fail(rows->db, code, rows->path, "counting its tiles");
	}
	sqlite3_finalize(statement);
	return status;
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
		status = store_meta_compacted(store->db, store->path, &numbers->compacted);
	if (status == STATUS_OK)
		status = store_last_run(store, &numbers->last_run);
	numbers->commits = store->last_run.commit;
	return status;
}
