/*
 * Builds the requests for the shader programs of deform. The stages and the plan both call these functions, so that both name the
 * same programs.
 */
#ifndef FURROW_DEFORM_PROGRAMS_H
#define FURROW_DEFORM_PROGRAMS_H

#include "deform/deform.h"

/* Points into itself: do not copy it. */
struct deform_request {
	struct gpu_program_request gl;
	char own[24]; /* text of a define with a number */
};

/* Passes of an iteration of sliding: EXCESS alone, or SHED and TAKE. */
enum slide_what { SLIDE_EXCESS, SLIDE_SHED, SLIDE_TAKE };

/* Hops along slopes: the first, those between, the last. */
enum slope_hop { SLOPE_FIRST, SLOPE_BETWEEN, SLOPE_LAST, SLOPE_HOPS };

/* Passes below bodies at rest: note roofs, limit what is laid, make posts below them still while soil slides along lines, and end that. */
enum roof_pass { ROOF_NOTE, ROOF_LIMIT, ROOF_CLOSE, ROOF_OPEN, ROOF_PASSES };

/* Passes that lay down carried soil. */
enum spread_pass { SPREAD_MEASURE, SPREAD_WEIGH, SPREAD_LAY, SPREAD_PASSES };

/* What a pass computes in one draw: a window, or blocks of the atlas. */
enum deform_over { OVER_WINDOW, OVER_BLOCKS, OVERS };

/* Each fills `out` completely. Pure. */
void deform_programs_envelope(const struct deform_params *params, enum soil_shape_kind kind, bool sideways, struct deform_request *out);
void deform_programs_facet(const struct deform_params *params, struct deform_request *out);
void deform_programs_contact(const struct deform_params *params, struct deform_request *out);
void deform_programs_box(const struct deform_params *params, struct deform_request *out);
void deform_programs_spread(const struct deform_params *params, enum spread_pass pass, struct deform_request *out);
void deform_programs_begin(const struct deform_params *params, enum deform_over over, struct deform_request *out);
/* roofed: below roofs. */
void deform_programs_slide(const struct deform_params *params, enum slide_what what, enum deform_over over, bool last, bool roofed,
		    struct deform_request *out);
void deform_programs_roof(enum roof_pass pass, struct deform_request *out);
/* Along lines of a window. `diagonal`: these cross the window's sides. */
void deform_programs_lines(const struct deform_params *params, bool diagonal, struct deform_request *out);
void deform_programs_steep(struct deform_request *out); /* marks where soil may slide */
void deform_programs_slope(const struct deform_params *params, enum slope_hop hop, struct deform_request *out);
void deform_programs_held(struct deform_request *out);
void deform_programs_disturbance(struct deform_request *out);
void deform_programs_marks(const struct deform_params *params, struct deform_request *out);
/* Passes of an elastic sheet, in their order (soil/sheet.c). */
enum sheet_pass { SHEET_FREE, SHEET_CONTACT, SHEET_MARK_ROWS, SHEET_MARK_COLUMNS, SHEET_BEND, SHEET_SET, SHEET_PASSES };
void deform_programs_sheet(enum sheet_pass pass, struct deform_request *out);

/* Passes over a batch of windows (batch.c). */
/* Contacts of straight wheels, of wheels that also move sideways, of spheres, of other shapes. Then the copy of the ground, before them, and
 * the passes after them. _STORE: a pass writes the tiles. */
enum deform_batch_pass {
	BATCH_WHEELS, BATCH_SIDEWAYS_WHEELS, BATCH_SPHERES, BATCH_OTHERS, BATCH_GATHER, BATCH_BOX, BATCH_BOX_STORE, BATCH_STORE, BATCH_DISTURBANCE
};
/* Passes over a fixed region that read or write its tile (fixed.c). FIXED_CONTACT_KEPT writes offsets to the window's layer, where smoothing
 * reads them. FIXED_BOX is the last pass of smoothing. */
enum deform_fixed_pass { FIXED_CONTACT, FIXED_CONTACT_KEPT, FIXED_BOX, FIXED_DISTURBANCE, FIXED_PASSES };
void deform_programs_fixed(const struct deform_params *params, enum deform_fixed_pass pass, struct deform_request *out);

#define DEFORM_BATCH_RECORD 25 /* numbers of 16 bytes for each window */
void deform_programs_batch(const struct deform_params *params, enum deform_batch_pass pass, struct deform_request *out);

/* Calls `each` for every program that an object can need, for some of them twice. */
typedef void (*programs_fn)(void *user, const char *effect, const struct gpu_program_request *request);
void deform_programs_each(const struct deform_params *params, const struct deform_planned *object, programs_fn each, void *user);

#endif
