/*
 * What all ranks must have in common, or their bits would differ. Before anything is made they compare version, base and scene.
 */
#include "fleet/internal.h"

#include <string.h>

struct common {
	char version[64], scene[40];
	uint64_t base;
	double spacing, end_time, forces;
	int64_t step, steps;
	int32_t resumed;
};

static enum status compare(void *user, int rank, struct fleet_bytes *bytes)
{
	struct common *first = user, other;
	TRY(fleet_get(bytes, &other, sizeof other));
	if (rank == 0)
		*first = other;
	if (strncmp(other.version, first->version, sizeof other.version) != 0)
		return fail_with(STATUS_INPUT, "rank %d: it is furrow %.60s, and rank 0 is %.60s; start the same on all machines", rank, other.version,
				 first->version);
	if (other.base != first->base)
		return fail_with(STATUS_INPUT, "rank %d: its base is not that of rank 0; give all ranks the same --store", rank);
	if (strncmp(other.scene, first->scene, sizeof other.scene) != 0 || other.spacing != first->spacing)
		return fail_with(STATUS_INPUT, "rank %d: its scene is not that of rank 0; give all ranks the same file", rank);
	if (other.end_time != first->end_time || other.steps != first->steps)
		return fail_with(STATUS_INPUT, "rank %d: its end_time or --steps is not that of rank 0; give all ranks the same", rank);
	if (other.forces != first->forces)
		return fail_with(STATUS_INPUT, "rank %d: its output.forces is not that of rank 0; give all ranks the same", rank);
	if (other.step != first->step || other.resumed != first->resumed)
		return fail_with(STATUS_FAILED, "rank %d: it begins at step %lld, and rank 0 at step %lld; report this", rank, (long long)other.step,
				 (long long)first->step);
	return STATUS_OK;
}

static enum status put_common(struct fleet *fleet, const struct world *world)
{
	struct common mine;
	memset(&mine, 0, sizeof mine); /* its padding, too */
	snprintf(mine.version, sizeof mine.version, "%s", FURROW_VERSION);
	snprintf(mine.scene, sizeof mine.scene, "%s", world_scene(world)->hash);
	mine.base = store_base_hash(world_resident(world)->store);
	mine.spacing = world_resident(world)->spacing;
	mine.end_time = world_scene(world)->end_time;
	mine.steps = world_params(world)->steps;
	mine.forces = world_scene(world)->forces;
	mine.step = world_steps_done(world);
	mine.resumed = world_facts(world)->resumed.is;
	TRY(world_facts(world)->resumed.is && fleet->rank == 0 ? fleet_note_resumed(fleet) : STATUS_OK);
	return fleet_put(&fleet->sent, &mine, sizeof mine);
}

/* The first call comes when the files are open. Each later one tells only the status. */
enum status fleet_agree_on(void *user, struct world *world, enum status status)
{
	struct fleet *fleet = user;
	struct fleet_told told;
	struct common common;
	fleet->world = world;
	if (fleet->failed) /* all know it */
		return status;
	const int call = fleet->agreed++;
	enum status put = fleet_begin(fleet, FLEET_AGREE, status);
	if (call == 0 && status == STATUS_OK && put == STATUS_OK)
		put = put_common(fleet, world);
	const enum status any =
		fleet_tell(fleet, FLEET_AGREE, status != STATUS_OK ? status : put, &told, call == 0 ? compare : NULL, &common);
	return any != STATUS_OK ? any : status;
}
