/*
 * Draws a wheel's grousers over its lower envelope. The smooth wheel was drawn before. Here the lower faces of the bars (soil_bars) are
 * drawn over it. The lower of the two is the lower envelope.
 */
#include <math.h>

#include "deform/internal.h"
#include "soil/shape/bars.h"
#include "soil/shape/body.h"
#include "soil/shape/facet.h"

/* The state while one window is drawn. */
struct grousers {
	struct deform *deform;
	struct facet_window window;
};

static struct facet_corner corner_of(const struct grousers *grousers, const double at[3])
{
	const double posts = ldexp(1, FACET_BITS) / grousers->deform->spacing;
	return (struct facet_corner){.x = (int32_t)lrint(at[0] * posts), .y = (int32_t)lrint(at[1] * posts), .z = ldexp(at[2], OFFSET_BITS)};
}

static void draw_face(void *user, const struct bar_face *face)
{
	struct grousers *grousers = user;
	const struct facet_corner start = corner_of(grousers, face->from), end = corner_of(grousers, face->to);
	const struct facet_motion motion = {end.x - start.x, end.y - start.y, (int32_t)lrint(end.z - start.z)};
	struct facet_corner at[4];
	for (int k = 0; k < 4; k++)
		at[k] = corner_of(grousers, face->at[k]);
	const struct facet_corner halves[2][3] = {{at[0], at[1], at[2]}, {at[0], at[2], at[3]}};
	for (int i = 0; i < 2; i++)
		if (soil_facet_of(halves[i], &motion, face->resting, &grousers->window, deform_facets_next(grousers->deform)))
			deform_facets_keep(grousers->deform);
}

enum status deform_grousers(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct soil_shape *shape = contact->shape;
	const struct post_rect read = window->read;
	const struct body_frame frame = {.x0 = read.x0, .y0 = read.y0, .spacing = deform->spacing, .zero = contact->to.z};
	const bool moves = !deform_is_contact_only(contact);
	enum status status = deform_facets_begin(deform, read, layer);
	if (status != STATUS_OK)
		return status;
	const struct body_motion motion = soil_body_motion_of(moves ? &contact->from : &contact->to, &contact->to, &frame);
	const struct bars_motion bars = {
		.x = motion.x, .y = motion.y, .dx = motion.dx, .dy = motion.dy, .z = ldexp((double)motion.z, -OFFSET_BITS),
		.dz = ldexp((double)motion.dz, -OFFSET_BITS), .turned = moves ? contact->turned : 0,
	};
	struct grousers grousers = {deform, {motion.x0, motion.y0, (int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0)}};
	soil_bars(shape, &contact->to, &bars, draw_face, &grousers);
	deform_facets_end(deform);
	return STATUS_OK;
}
