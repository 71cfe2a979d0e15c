/* How furrow log and furrow prune tell the overlays that depend on a store. */
#ifndef FURROW_TOOLS_PINS_H
#define FURROW_TOOLS_PINS_H

#include <cjson/cJSON.h>
#include <stddef.h>

#include "store/store.h"

/* Writes what a pin is of: "revision 2", or "the base". */
void pin_of(const struct store_pin *pin, char *text, size_t room);
/* Makes an object of a pin: file, revision, hash, base, state, found. */
cJSON *pin_json(const struct store_pin *pin);

#endif
