/*
 * Draws a wheel's grousers over its lower envelope. The smooth wheel was drawn before. Here the lower faces of the bars
 * (soil_grouser_facets) are drawn over it. The lower of the two is the lower envelope.
 */
#include "soil/shape/facets.h"
#include "deform/internal.h"

enum status deform_grousers(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct facets_motion motion = deform_facets_motion(deform, contact, window);
	TRY(deform_facets_begin(deform, window->read, layer));
	soil_grouser_facets(&motion, deform_facets_add, deform);
	deform_facets_end(deform);
	return STATUS_OK;
}
