#include "relief_told.h"

#include <string.h>

void relief_tell_missing(const char *path, const struct store *store)
{
	if (store_relief_text(store) != NULL && strstr(store_relief_text(store), "\"classes\"") != NULL && store_has_working_level(store, NULL) && store_relief(store) == NULL)
		note("%s: it was deformed over relief by class of soil, whose map only a scene names: heights between the source's posts are told "
		     "without it", path);
}
