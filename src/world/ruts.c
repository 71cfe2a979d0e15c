/*
 * Says before the first step that the ground already has ruts, or that it gets its first. Who drives a second time may have wanted the ground as
 * imported.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world/internal.h"

enum status world_find_ruts(struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	const struct tile all = {extent_coarsest(extent), 0, 0}; /* the row has the range of every tile below it */
	double low = 0, high = 0;
	bool found = false;
	char heaps[48] = "";
	if (!world->resident.was_deformed)
		return STATUS_OK;
	enum status status = store_read_offset_range(resident_ground_reader(world->resident.ground), all, &low, &high, &found);
	if (status != STATUS_OK || world->params.resume || !found || (low >= 0 && high <= 0))
		return status;
	world->facts.began = (struct world_began){fmin(low, 0), fmax(high, 0)};
	if (high > 0)
		snprintf(heaps, sizeof heaps, " and heaps up to %.3g m high", high);
	if (world->params.readonly)
		return STATUS_OK;
	note("%s: the ground has ruts already, up to %.3g m deep%s; this run goes on over them; for the ground as it was imported %s"
	     "run furrow reset %s", world->facts.path, fmax(-low, 0), heaps, store_base_path(world->resident.store) != NULL ? "give another --overlay, or " : "",
	     shell_path(world->facts.path).text);
	return STATUS_OK;
}

void world_tell_written(const struct world *world)
{
	const struct scene *scene = world->scene;
	const bool made_here = strncmp(world->resident.meta->sources, "synthetic ", strlen("synthetic ")) == 0; /* furrow synth makes the same again */
	if (world->resident.was_deformed || made_here || store_base_path(world->resident.store) != NULL || world->params.resume || world->params.keep_history ||
	    (scene->object_count == 0 && scene->vehicle_count == 0))
		return;
	note("%s: this run writes its ruts into the imported store itself; to keep the store as it is, give --overlay FILE. furrow reset %s removes ruts",
	     world->facts.path, shell_path(world->facts.path).text);
}
