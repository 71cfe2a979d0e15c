/* What import and synth say of the store that they made. */
#ifndef FURROW_TOOLS_MADE_H
#define FURROW_TOOLS_MADE_H

#include "intake/intake.h"

void print_made(const struct intake *made); /* on stdout: posts, spacing, bytes, speed */

#endif
