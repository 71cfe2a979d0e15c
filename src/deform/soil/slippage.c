/* Li and Moshell 1993: the object pushes all soil aside, and slopes that are too steep slip. */
#include "deform/internal.h"

enum status deform_slippage(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			    uint32_t layer)
{
	const struct contact_params params = deform_contact_params(deform, contact, window, layer);
	enum status status = deform_run_contact(deform, &params, sizeof params, window, layer);
	if (status == STATUS_OK)
		status = deform_spread(deform, window, layer);
	return status == STATUS_OK ? deform_slide(deform, window, layer) : status;
}
