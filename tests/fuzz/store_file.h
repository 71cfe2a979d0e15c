/* What the parts of the target for store files share. */
#ifndef FURROW_FUZZ_STORE_FILE_H
#define FURROW_FUZZ_STORE_FILE_H

#include "fuzz.h"
#include "store/internal.h"

/* The store's file in the folder, and nothing else of a store. */
const char *store_file_fresh(void);

#endif
