/* Places as people give them; see place.h. */
#include "place.h"

#include <string.h>

#include "dem/dem.h"

enum status place_local(const struct store_meta *meta, const char *srs, const char *command, const char *option, double *x, double *y)
{
	if (srs == NULL)
		return STATUS_OK;
	if (strcmp(srs, "store") != 0) {
		if (meta->srs[0] == '\0')
			return fail_with(STATUS_INPUT, "%s: the store has no reference system; leave %s out and give metres from its south-west post", command,
					 option);
		enum status status = dem_transform(srs, meta->srs, 1, x, y);
		if (status != STATUS_OK)
			return status;
	}
	*x -= meta->origin[0];
	*y -= meta->origin[1];
	return STATUS_OK;
}

const char *place_system(const char *wkt, int *length)
{
	const char *from = strchr(wkt, '"'), *to = from != NULL ? strchr(from + 1, '"') : NULL;
	*length = to != NULL ? (int)(to - from - 1) : 0;
	return to != NULL ? from + 1 : NULL;
}
