/*
 * The relief over which a store is deformed. Only what it is made from is written, as a text beside the working level; heights never are.
 *
 * Invariant: while something is deformed, or the history has rows, relief_text is that of this ground. Before, it is what the drive asks
 * for.
 */
#include "store/internal.h"

#include <string.h>

const struct relief *store_relief(const struct store *store)
{
	return relief_any(&store->relief) ? &store->relief : NULL;
}

const struct rocks *store_rocks(const struct store *store)
{
	return rocks_any(&store->rocks) ? &store->rocks : NULL;
}

const char *store_relief_text(const struct store *store)
{
	return store->relief_text;
}

bool store_relief_equal(const char *one, const char *other)
{
	return one == NULL || other == NULL ? one == other : strcmp(one, other) == 0;
}

enum status store_meta_put_working(struct store *store, int level, const char *relief)
{
	TRY(store_meta_put_integer(store, "working", level));
	if (relief != NULL)
		return store_meta_put_text(store, "relief", relief);
	return store->relief_stored ? store_meta_drop(store, "relief") : STATUS_OK;
}

enum status store_relief_settle(struct store *store)
{
	struct relief_spec spec;
	struct rocks_spec rocks;
	const struct relief_map *map = store->relief.map;
	store->relief = (struct relief){.coarsest = -1};
	store->rocks = (struct rocks){.count = 0};
	if (store->relief_text == NULL)
		return STATUS_OK;
	if (!rocks_parse(store->relief_text, &spec, &rocks))
		return fail_with(STATUS_INPUT, "%s: its header is wrong: relief; restore or import it again", store->path);
	if (!store->has_working)
		return STATUS_OK;
	rocks_make(&rocks, store->meta.extent.spacing, &store->rocks);
	store->rocks.finest = store->working < 0 ? store->working : 0;
	if (spec.classes == 0 || store->working >= 0 || (spec.classes > 1 && map == NULL))
		return STATUS_OK;
	relief_make(&spec, store->meta.extent.spacing, store->working, &store->relief);
	store->relief.map = map;
	return STATUS_OK;
}

enum status store_set_relief(struct store *store, const struct relief_spec *spec, const struct relief_map *map)
{
	return store_set_ground(store, spec, NULL, map);
}

enum status store_set_ground(struct store *store, const struct relief_spec *spec, const struct rocks_spec *rocks, const struct relief_map *map)
{
	struct relief relief = {.coarsest = -1};
	char *text = NULL;
	if (spec != NULL && store->has_working && store->working < 0)
		relief_make(spec, store->meta.extent.spacing, store->working, &relief);
	if ((relief_any(&relief) || rocks != NULL) && (text = rocks_print(relief_any(&relief) ? spec : NULL, rocks)) == NULL)
		return fail_memory("relief");
	if ((store->working_stored || store->history.has_level) && !store_relief_equal(text, store->relief_text)) {
		const char *had = store->relief_text != NULL ? store->relief_text : "none";
		enum status status = fail_with(STATUS_INPUT, "%s: it was deformed over relief %s, not %s; give the scene that relief, or furrow reset %s",
					       store->path, had, text != NULL ? text : "none", shell_path(store->path).text);
		mem_free(text);
		return status;
	}
	mem_free(store->relief_text);
	store->relief_text = text;
	store->relief.map = map;
	return store_relief_settle(store);
}
