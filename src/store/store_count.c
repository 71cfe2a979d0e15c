/* Counts rows and bytes of a store, and reads its last run. */
#include "store/internal.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

static enum status count_history(struct store *store, struct store_numbers *numbers)
{
	const struct {
		const char *sql;
		int64_t *to;
	} sums[] = {
		{"SELECT count(*) FROM revision", &numbers->revisions},
		{"SELECT count(*) FROM snapshot", &numbers->snapshots},
		{"SELECT count(*) FROM history WHERE plane > 0", &numbers->history_rows},
		{"SELECT coalesce(sum(length(blob)), 0) FROM history WHERE plane > 0", &numbers->history_bytes},
	};
	for (size_t i = 0; i < sizeof sums / sizeof *sums; i++)
		TRY(store_sql_integer(store->db, store->path, sums[i].sql, sums[i].to));
	return STATUS_OK;
}

enum status store_count(struct store *store, struct store_numbers *numbers)
{
	*numbers = (struct store_numbers){0};
	struct stat file;
	if (stat(store->real_path, &file) != 0)
		return fail_with(STATUS_FAILED, "%s: %s; check the path", store->path, strerror(errno));
	numbers->file_bytes = file.st_size;
	TRY(store_rows_count(store->base, ROW_BASE, &numbers->base_tiles, &numbers->base_bytes));
	for (int plane = 0; plane < PLANES; plane++)
		TRY(store_rows_count(&store->rows, row_table_of((enum plane)plane), &numbers->plane_tiles[plane], &numbers->plane_bytes[plane]));
	TRY(store_meta_compacted(store->db, store->path, &numbers->compacted));
	TRY(store_meta_added(store->db, store->path, &numbers->added));
	TRY(count_history(store, numbers));
	TRY(store_last_run(store, &numbers->last_run));
	numbers->commits = store->last_run.commit;
	TRY(store_last_soil(store, &numbers->carried, &numbers->in_flight));
	return STATUS_OK;
}
