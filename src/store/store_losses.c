/* Tells what would be lost with a store: overlays that depend on it, and snapshots. */
#include "store/internal.h"

#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define TOLD_MOST 4

struct losses {
	bool whole;
	int64_t count;
	char text[1024];
};

/* The folder is there, and the file is not. Otherwise its disk may be elsewhere. */
static bool was_removed(const char *path)
{
	char folder[PATH_MAX];
	snprintf(folder, sizeof folder, "%s", path);
	return access(dirname(folder), F_OK) == 0;
}

static enum status count_loss(void *user, const struct store_pin *pin)
{
	struct losses *losses = user;
	const size_t used = strlen(losses->text);
	if (pin->base && !losses->whole)
		return STATUS_OK; /* the base stays */
	if (pin->base && pin->state == STORE_PIN_GONE && was_removed(pin->path))
		return STATUS_OK;
	if (losses->count++ >= TOLD_MOST)
		return STATUS_OK;
	const char *path = pin->found != NULL ? pin->found : pin->path != NULL ? pin->path : "an overlay that is not known";
	const char *slash = strrchr(path, '/');
	snprintf(losses->text + used, sizeof losses->text - used, "%s%s%s", used > 0 ? ", " : "", slash != NULL ? slash + 1 : path,
		 pin->state == STORE_PIN_GONE ? " (gone)" : "");
	return STATUS_OK;
}

enum status store_losses(struct store *store, bool whole, char *text, size_t room, int64_t *count)
{
	struct losses losses = {.whole = whole};
	int64_t names = 0;
	TRY(store_each_pin(store, count_loss, &losses));
	TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM snapshot", &names));
	*count = losses.count + names;
	int used = losses.count == 0 ? 0
				     : snprintf(text, room, "%lld overlay%s depend%s on it: %s%s", (long long)losses.count, losses.count == 1 ? "" : "s",
						losses.count == 1 ? "s" : "", losses.text, losses.count > TOLD_MOST ? ", ..." : "");
	if (names > 0 && used >= 0 && (size_t)used < room)
		snprintf(text + used, room - (size_t)used, "%sit has %lld snapshot%s", used > 0 ? ", and " : "", (long long)names, names == 1 ? "" : "s");
	return STATUS_OK;
}

enum status store_losses_refuse(struct store *store, bool whole)
{
	char text[1400];
	int64_t count = 0;
	TRY(store_losses(store, whole, text, sizeof text, &count));
	if (count > 0)
		return fail_with(STATUS_INPUT, "%s: %s, which would be lost; furrow log tells them, furrow flatten makes an overlay a store of its own, furrow "
				   "prune drops those that are gone, and --force loses them", store->path, text);
	return STATUS_OK;
}
