/* The lower envelope of a body's triangles at the posts of a patch: of a mesh, and of a wheel's grousers. */
#ifndef FURROW_DEFORM_PROBE_LOW_H
#define FURROW_DEFORM_PROBE_LOW_H

#include "deform/probe/law.h"

/* Sets `form->low` for a body that has triangles. It uses the patch's own room, until the next call. `below`: posts that may be below the body. */
void deform_low_of(const struct deform_patch *patch, const struct deform_probe *probe, const struct post_rect *below, struct probe_form *form);
/* Returns true if all of the body is above all of the ground below it. For a body that is known only at posts. */
bool deform_low_is_aloft(const struct probe_law *law, const struct post_rect *below);

#endif
