/* Pure compaction: the soil that the object displaces is lost (dissertation 4.4.2). */
#include "deform/internal.h"

enum status deform_none(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct contact_params params = deform_contact_params(deform, contact, window, layer);
	return deform_run_contact(deform, &params, sizeof params, window, layer);
}
