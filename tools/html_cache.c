#include "html_cache.h"


#include "command.h"

static enum status go_on(void *user, int64_t done, int64_t total)
{
	return STATUS_OK;
}

static enum status simulate(const struct html_run *run, const char *path, struct html_cache *out)
{
	static const enum sim_policy policies[HTML_POLICIES] = {SIM_LRU, SIM_OPT};
	struct sim_accesses accesses = {.count = 0};
	enum status status = sim_accesses_read(path, &accesses);
	struct cache_curves curves = {.title = path, .accesses = &accesses};
	if (status == STATUS_INPUT) {
		snprintf(out->why, sizeof out->why, "No cache curve: %.450s", failure_message());
		sim_accesses_finish(&accesses);
		return STATUS_OK;
	}
	const bool same = (double)accesses.hits[PAGE_ACCESS_PIN] == html_number(run, "cache.hits") &&
			  (double)accesses.misses[PAGE_ACCESS_PIN] == html_number(run, "cache.misses");
	if (status == STATUS_OK && !same)
		snprintf(out->why, sizeof out->why, "No cache curve: %.400s is the trace of another drive", path);
	if (status == STATUS_OK && same && accesses.count == 0)
		snprintf(out->why, sizeof out->why, "No cache curve: the drive asked for no tile");
	if (status == STATUS_OK && same && accesses.count > 0)
		cache_sizes(&curves);
	if (curves.count == 1)
		snprintf(out->why, sizeof out->why, "No cache curve: the drive touched %u tile%s, fewer than the smallest cache has slots", accesses.tile_count,
			 accesses.tile_count == 1 ? "" : "s");
	if (curves.count > 1) {
		for (int policy = 0; policy < HTML_POLICIES && status == STATUS_OK; policy++)
			status = sim_misses(&accesses, policies[policy], curves.slots, curves.count, go_on, NULL, curves.misses[policies[policy]]);
		for (size_t i = 0; i < curves.count && status == STATUS_OK; i++) {
			out->slots[i] = curves.slots[i];
			for (int policy = 0; policy < HTML_POLICIES; policy++)
				out->misses[policy][i] = (double)curves.misses[policies[policy]][i];
		}
		out->count = status == STATUS_OK ? curves.count : 0;
		out->accesses = accesses.count;
		out->tiles = accesses.tile_count;
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
