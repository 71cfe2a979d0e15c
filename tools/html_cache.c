#include "html_cache.h"


#include "command.h"

static enum status go_on(void *user, int64_t done, int64_t total)
{
	return STATUS_OK;
}

/* Takes the curves of a trace that is this drive's own; else says in `out` why there are none. */
static enum status take_curves(const struct html_run *run, const char *path, const struct sim_accesses *accesses, struct html_cache *out)
{
	static const enum sim_policy policies[HTML_POLICIES] = {SIM_LRU, SIM_OPT};
	struct cache_curves curves = {.title = path, .accesses = accesses};
	if ((double)accesses->hits[PAGE_ACCESS_PIN] != html_number(run, "cache.hits") ||
	    (double)accesses->misses[PAGE_ACCESS_PIN] != html_number(run, "cache.misses")) {
		snprintf(out->why, sizeof out->why, "No cache curve: %.400s is the trace of another drive", path);
		return STATUS_OK;
	}
	if (accesses->count == 0) {
		snprintf(out->why, sizeof out->why, "No cache curve: the drive asked for no tile");
		return STATUS_OK;
	}
	cache_sizes(&curves);
	if (curves.count == 1)
		snprintf(out->why, sizeof out->why, "No cache curve: the drive touched %u tile%s, fewer than the smallest cache has slots",
			 accesses->tile_count, accesses->tile_count == 1 ? "" : "s");
	if (curves.count <= 1)
		return STATUS_OK;
	for (int policy = 0; policy < HTML_POLICIES; policy++)
		TRY(sim_misses(accesses, policies[policy], curves.slots, curves.count, go_on, NULL, curves.misses[policies[policy]]));
	for (size_t i = 0; i < curves.count; i++) {
		out->slots[i] = curves.slots[i];
		for (int policy = 0; policy < HTML_POLICIES; policy++)
			out->misses[policy][i] = (double)curves.misses[policies[policy]][i];
	}
	out->count = curves.count;
	out->accesses = accesses->count;
	out->tiles = accesses->tile_count;
	return STATUS_OK;
}

static enum status simulate(const struct html_run *run, const char *path, struct html_cache *out)
{
	struct sim_accesses accesses = {.count = 0};
	enum status status = sim_accesses_read(path, &accesses);
	if (status == STATUS_OK) {
		status = take_curves(run, path, &accesses, out);
	} else if (status == STATUS_INPUT) {
		snprintf(out->why, sizeof out->why, "No cache curve: %.450s", failure_message());
		status = STATUS_OK;
	}
	sim_accesses_finish(&accesses);
	return status;
}

enum status html_cache_read(const struct html_run *run, struct html_cache *out)
{
	const char *path = html_string(run, "trace");
	*out = (struct html_cache){.count = 0};
	if (path != NULL && html_is_file(path))
		return simulate(run, path, out);
	if (path == NULL)
		snprintf(out->why, sizeof out->why, "No cache curve: the drive wrote no trace; drive with --trace FILE");
	else
		snprintf(out->why, sizeof out->why, "No cache curve: %.400s is not there any more", path);
	return STATUS_OK;
}
