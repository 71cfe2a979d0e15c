/* furrow export --mesh: a window of the surface as triangles. */
#include <stdio.h>

#include "dem/dem.h"
#include "exchange/exchange.h"
#include "export.h"

enum status export_mesh(const struct export_request *request, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	struct progress progress;
	struct exchange_mesh_params params = {
		.meta = meta,
		.path = request->path,
		.level = (int)request->level,
		.progress = progress_step,
		.progress_user = &progress,
	};
	struct exchange_mesh_result made;
	struct store_reader *reader = NULL;
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
	       made.origin[0], made.origin[1], made.origin[2], dem_path_ends(request->path, ".glb") ? "y" : "z");
	return STATUS_OK;
}
