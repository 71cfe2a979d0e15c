/* furrow prune: drops what a store keeps for overlays that are gone. */
#include <stdio.h>

#include "command.h"
#include "json.h"
#include "pins.h"
#include "store/store.h"

static const struct command_option options[] = {
	{"json", .help = "one JSON object"},
	{.name = NULL},
};

struct pruned {
	int64_t stand, moved, found, gone;
	cJSON *pins; /* NULL: text is printed */
};

static enum status tell(void *user, const struct store_pin *pin)
{
	static const char *const did[] = {
		[STORE_PIN_THERE] = "stays", [STORE_PIN_MOVED] = "moved", [STORE_PIN_GONE] = "dropped", [STORE_PIN_FOUND] = "listed",
	};
	struct pruned *pruned = user;
	char of[64];
	pruned->stand += pin->state == STORE_PIN_THERE;
	pruned->moved += pin->state == STORE_PIN_MOVED;
	pruned->found += pin->state == STORE_PIN_FOUND;
	pruned->gone += pin->state == STORE_PIN_GONE;
	if (pruned->pins != NULL) {
		cJSON *object = pin_json(pin);
		cJSON_AddStringToObject(object, "done", did[pin->state]);
		cJSON_AddItemToArray(pruned->pins, object);
		return STATUS_OK;
	}
	pin_of(pin, of, sizeof of);
	if (pin->state == STORE_PIN_THERE)
		printf("stays    %s of %s\n", pin->path, of);
	else if (pin->state == STORE_PIN_MOVED)
		printf("moved    %s of %s: it is at %s\n", pin->path, of, pin->found);
	else if (pin->state == STORE_PIN_FOUND)
		printf("listed   %s of %s: the list lacked it\n", pin->path, of);
	else
		printf("dropped  %s of %s: %s\n", pin->path != NULL ? pin->path : "an overlay that is not known", of,
		       pin->path != NULL ? "no file there or beside it depends on that" : "the list lacks it, and no file beside the store depends on that");
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct pruned pruned = {0};
	const char *path = arguments_at(arguments, 0);
	cJSON *object = arguments_flag(arguments, "json") ? cJSON_CreateObject() : NULL;
	if (object != NULL)
		pruned.pins = cJSON_AddArrayToObject(object, "pins");
	enum status status;
	TRY_OR(failed, store_prune(path, tell, &pruned));
	if (object != NULL) {
		json_integer(object, "dropped", pruned.gone);
		return json_print(object);
	}
	printf("%s: %lld pin%s dropped, %lld stay\n", path, (long long)pruned.gone, pruned.gone == 1 ? "" : "s",
	       (long long)(pruned.stand + pruned.moved + pruned.found));
	return STATUS_OK;
failed:
	cJSON_Delete(object);
	return status;
}

const struct command command_prune = {
	.name = "prune",
	.summary = "drop what a store keeps for branches and overlays that are gone",
	.arguments = COMMAND_ARGUMENTS(COMMAND_STORE),
	.options = options,
	.details = "A store keeps what its branches and overlays depend on, and lists them in the file STORE-pins. furrow log shows the list. prune looks for each "
		   "file. A file that was moved is sought in the folder that it was in and in the store's folder, by hash, and listed where it is. Where none is found, the "
		   "pin is dropped, and what was kept for it alone. Put a disk in before you prune, if overlays are on it.\n",
	.see = "furrow-branch(1), furrow-log(1)",
	.run = run,
};
