/* The recent motion of a body in the frame of the law: src/soil/faces/trend.c. */
#ifndef FURROW_SOIL_TREND_H
#define FURROW_SOIL_TREND_H

#include "soil/law/form.h"

#define TREND_LAST 30.0f /* the short mean forgets so many times as fast */

/* Sets form->recent, form->last and form->scooped, from which the law knows how a body slides. trend: at the motion's end. Pure. */
void soil_trend_put(const struct soil_law *law, const struct soil_body *body, const struct soil_trend *trend, struct soil_form *form);

#endif
