/* Where a store has ruts. */
#ifndef FURROW_TOOLS_RUTS_H
#define FURROW_TOOLS_RUTS_H

#include "base/base.h"
#include "store/store.h"

/* Fills `window` with west, south, east and north of the tiles that have ruts, in metres from the south-west post. *any is false if no tile
 * has. */
enum status ruts_window(struct store *store, double window[4], bool *any) FURROW_CHECKED;

#endif
