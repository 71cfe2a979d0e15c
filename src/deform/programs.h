/* The programs of deform, each request built in one place: for the stages that run them and for the plan. */
#ifndef FURROW_DEFORM_PROGRAMS_H
#define FURROW_DEFORM_PROGRAMS_H

#include "deform/deform.h"

/* Points into itself: never copied. */
struct deform_request {
	struct gpu_program_request gl;
	char own[16]; /* a define that is made */
};

/* Of the press of a model that tells forces: what of an object it depends on. */
enum { WITH_FORCES = 1, WITH_PATCH = 2, WITH_LOAD = 4 };

/* Of scm's search: where first contact is; how many posts are touched; what the soil bears. */
enum find_what { FIND_GAP, FIND_COUNT, FIND_BEARS };

/* A pass of an iteration: in one pass, or to shed soil and then to take it. */
enum slide_what { SLIDE_EXCESS, SLIDE_SHED, SLIDE_TAKE };

/* Each fills `out` anew. Pure. */
void deform_programs_underside(const struct deform_params *params, enum deform_shape_kind kind, bool sideways,
			struct deform_request *out);
void deform_programs_facet(const struct deform_params *params, struct deform_request *out);
void deform_programs_press(const struct deform_params *params, unsigned with, struct deform_request *out);
void deform_programs_find(const struct deform_params *params, enum find_what what, bool patch, struct deform_request *out);
void deform_programs_box(const struct deform_params *params, struct deform_request *out);
void deform_programs_spread(struct deform_request *out);
/* Over blocks, or over a window (`loaded`: of an object with a load). */
void deform_programs_begin(const struct deform_params *params, bool blocks, bool loaded, struct deform_request *out);
void deform_programs_slide(const struct deform_params *params, enum slide_what what, bool blocks, bool last,
		    struct deform_request *out);
void deform_programs_held(bool loaded, struct deform_request *out);
void deform_programs_dirt(struct deform_request *out);

/* Every program that an object can ask for, some of them twice. As deform_warm. */
typedef void (*programs_fn)(void *user, const char *effect, const struct gpu_program_request *request);
void deform_programs_each(const struct deform_params *params, const struct deform_planned *object, bool forces, programs_fn each,
		   void *user);

/* Whether an object's patch is counted on the ground: of a shape that has no width of its own, and lies in one window
 * wherever it is. */
bool deform_is_counted(const struct deform_params *params, const struct deform_shape *shape, bool loaded);

#endif
