/* furrow export --mesh: a window of the surface as triangles. */
#include <stdio.h>
#include <string.h>

#include "dem/dem.h"
#include "exchange/exchange.h"
#include "export.h"

/* The terrain's name: its file's, without the folder and the ending. */
static void name_of(const char *path, char *name, size_t room)
{
	static const char ending[] = ".furrow";
	const char *slash = strrchr(path, '/');
	snprintf(name, room, "%s", slash != NULL ? slash + 1 : path);
	const size_t length = strlen(name), tail = sizeof ending - 1;
	if (length > tail && strcmp(name + length - tail, ending) == 0)
		name[length - tail] = '\0';
}

enum status export_mesh(const struct export_request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	struct progress progress;
	char name[256];
	struct exchange_mesh_params params = {
		.meta = meta,
		.path = request->path,
		.name = name,
		.up = (enum exchange_up)request->up,
		.level = (int)request->level,
		.progress = progress_step,
		.progress_user = &progress,
	};
	struct exchange_mesh_result made;
	struct store_reader *reader = NULL;
	name_of(request->store, name, sizeof name);
	params.deformed = store_has_working_level(store, &params.working);
	TRY(export_find_rect(request, &meta->extent, &params.rect));
	interrupt_catch();
	TRY(store_reader_create(store, &reader));
	params.reader = reader;
	progress_start(&progress, request->path, "rows");
	enum status status = exchange_mesh(&params, &made);
	progress_end(&progress);
	store_reader_destroy(reader);
	TRY(status);
	printf("%s: %llu triangles, %llu vertices, %g m apart; origin %.10g m east, %.10g m north, height %g m; up is %s\n", request->path,
	       (unsigned long long)made.triangles, (unsigned long long)made.vertices, extent_spacing(&meta->extent, params.level),
	       made.origin[0], made.origin[1], made.origin[2], made.y_up ? "y" : "z");
	return STATUS_OK;
}
