/*
 * A copy of the base on a disk of each machine. One rank of each machine makes it, or checks the one that is there; the others wait. Then all
 * ranks read the base from it. A run by one process does the same alone.
 */
#include "fleet/internal.h"

#include <unistd.h>

struct staging {
	const struct fleet_params *params;
	int rank;
	bool told; /* that it waits */
};

static enum status progress(void *user, int64_t done, int64_t total)
{
	struct staging *staging = user;
	const struct fleet_params *params = staging->params;
	if (params->stop != NULL && *params->stop)
		return fail_with(STATUS_INTERRUPTED, "%s: interrupted; the copy of the base is begun anew the next time", params->stage);
	if (total == 0) {
		if (!staging->told)
			note("%s: another process copies the base there; waiting for it", params->stage);
		staging->told = true;
		return STATUS_OK;
	}
	return params->progress != NULL && staging->rank == 0 ? params->progress(params->progress_user, done, total) : STATUS_OK;
}

/* Returns the failure of any rank on all ranks. If any was interrupted, all are. */
static enum status agree(const struct staging *staging, int ranks, enum status status)
{
	const int32_t interrupted = status == STATUS_INTERRUPTED;
	const void *const *all;
	const size_t *sizes;
	status = fleet_agree(status);
	if (ranks == 0 || (status != STATUS_OK && status != STATUS_INTERRUPTED))
		return status;
	/* No other rank has failed. They all come here, so the interrupted one does, too. */
	fleet_comm_exchange(&interrupted, sizeof interrupted, &all, &sizes);
	TRY(status);
	for (int i = 0; i < ranks; i++)
		if (sizes[i] == sizeof interrupted && *(const int32_t *)all[i] != 0)
			return fail_with(STATUS_INTERRUPTED, "%s: interrupted on rank %d; the copy of the base is begun anew the next time",
					 staging->params->stage, i);
	return STATUS_OK;
}

/* The base is that of the overlay. It may lie elsewhere than the store that was given, with the same content. */
static enum status name_copy(const struct fleet_params *params, struct store_staged *staged)
{
	const char *base = params->store != NULL ? params->store : params->scene->store;
	if (base == NULL)
		return fail_with(STATUS_INPUT, "%s: names no store; add store:, or give --store", params->scene->file);
	return store_stage_name(access(params->overlay, F_OK) == 0 ? params->overlay : base, params->stage, staged);
}

enum status fleet_stage(const struct fleet_params *params, struct store_staged *staged)
{
	struct staging staging = {.params = params};
	const int ranks = fleet_joined(&staging.rank);
	bool made = false;
	*staged = (struct store_staged){.original = NULL};
	if (params->stage == NULL)
		return STATUS_OK;
	enum status status;
	TRY_OR(failed, fleet_agree(name_copy(params, staged)));
	TRY_OR(failed, agree(&staging, ranks, fleet_comm_first_here() ? store_stage(staged, progress, &staging, &made) : STATUS_OK));
	note("%s: read from %s, %s", staged->original, staged->copy, made ? "to which it was copied" : "a copy that was there");
	return STATUS_OK;
failed:
	store_staged_finish(staged);
	return status;
}
