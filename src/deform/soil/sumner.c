/* Sumner, O'Brien and Hodgins 1999: the object pushes aside the soil that it does not compact, and the ground erodes. */
#include <math.h>

#include "deform/internal.h"

struct sumner_params {
	struct contact_params contact;
	uint32_t kept[DEFORM_SOILS][4];
};

enum status deform_sumner(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			  uint32_t layer)
{
	struct sumner_params params = {.contact = deform_contact_params(deform, contact, window, layer)};
	for (int i = 0; i < deform->params.soil_count; i++)
		params.kept[i][0] = (uint32_t)floor(ldexp(1 - deform->params.soils[i].compression, 31));
	enum status status = deform_run_contact(deform, &params, sizeof params, window, layer);
	if (status == STATUS_OK)
		status = deform_spread(deform, window, layer);
	return status == STATUS_OK ? deform_slide(deform, window, layer) : status;
}
