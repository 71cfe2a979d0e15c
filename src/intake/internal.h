/* Parts of intake_import_open. */
#ifndef FURROW_INTAKE_INTERNAL_H
#define FURROW_INTAKE_INTERNAL_H

#include "intake/intake.h"

/* Opens the insets, and sets the step of heights by the finest of all. STATUS_INPUT: an inset cannot be used. */
enum status intake_import_open_insets(struct import *import) FURROW_CHECKED;
/* Fills meta.sources, meta.insets and meta.request. The import owns the texts. Fails only when memory runs out. */
enum status intake_import_describe(struct import *import) FURROW_CHECKED;

#endif
