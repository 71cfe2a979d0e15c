/*
 * A wheel's grousers: bars across its rim, as long as the wheel is wide. They turn with the wheel. The smooth wheel was drawn
 * before. Here the lower faces of the bars are drawn over it. The lower of the two is the lower envelope.
 *
 * The wheel moves straight during a contact, but a bar also turns about the axle. Here a bar moves straight from its place at
 * the start to its place at the end. For the first half it has its attitude at the start, for the second half its attitude
 * at the end. A bar of a rolling wheel hardly moves on the ground, so this is close. The error is at most half the turn times
 * half the bar's diagonal. A large turn, as of a spinning wheel, is divided into steps of at most STEP.
 *
 * The turn comes from the contact, since poses may leave whole turns out. A wheel that turns by the angle between two bars
 * has the same bits as before. For that the phase is a whole number of 2^-32 of this angle.
 */
#include <math.h>
#include <string.h>

#include "deform/shape/body.h"
#include "deform/shape/facet.h"
#include "deform/internal.h"

#define STEP 0.2     /* radians */
#define STEPS_MAX 32 /* so large a turn within one post moves a bar past every place on the rim */

/* A place in the wheel's plane: u along its heading, w up in that plane; metres. */
struct spot {
	double u, w;
};

/* The state while one window is drawn. */
struct grousers {
	struct deform *deform;
	const struct deform_shape *shape;
	const struct body_motion *motion;
	struct facet_window window;
	double axes[3][3]; /* along its heading, along the axle to the left, up in the wheel's plane */
	bool leans;        /* the axle is not level */
};

/* Computes the corners of a bar's section. `angle`: from straight down, positive towards the back and up. The inner corners lie
 * inside the rim. */
static void section(const struct deform_shape *shape, double angle, struct spot corners[4])
{
	double half = shape->grouser_thickness / 2;
	double inner = sqrt(fmax(0, shape->radius * shape->radius - half * half)), outer = shape->radius + shape->grouser_height;
	double c = cos(angle), s = sin(angle);
	const double out[4] = {inner, outer, outer, inner}, along[4] = {-half, -half, half, half};
	for (int k = 0; k < 4; k++)
		corners[k] = (struct spot){-s * out[k] - c * along[k], -c * out[k] + s * along[k]};
}

static struct spot centre_of(const struct deform_shape *shape, double angle)
{
	return (struct spot){-sin(angle) * shape->radius, -cos(angle) * shape->radius};
}

/* Returns true if the bar can lower the envelope: it is in the wheel's lower half, or sticks out beyond the rim. */
static bool shows(const struct deform_shape *shape, const struct spot corners[4])
{
	for (int k = 0; k < 4; k++)
		if (corners[k].w < 0 || fabs(corners[k].u) > shape->radius)
			return true;
	return false;
}

/* Returns where a place of the wheel is after `share` of the motion. `side`: metres along the axle. */
static struct facet_corner corner_of(const struct grousers *grousers, struct spot spot, double side, double share)
{
	const struct body_motion *m = grousers->motion;
	double posts = ldexp(1, FACET_BITS) / grousers->deform->spacing;
	const double(*axes)[3] = (const double(*)[3])grousers->axes;
	double x = (double)(m->x + share * m->dx) + spot.u * axes[0][0] + side * axes[1][0] + spot.w * axes[2][0];
	double y = (double)(m->y + share * m->dy) + spot.u * axes[0][1] + side * axes[1][1] + spot.w * axes[2][1];
	return (struct facet_corner){
		.x = (int32_t)lrint(x * posts),
		.y = (int32_t)lrint(y * posts),
		.z = (double)m->z + share * (double)m->dz + ldexp(side * axes[1][2] + spot.w * axes[2][2], OFFSET_BITS),
	};
}

static void draw_face(struct grousers *grousers, const struct facet_corner at[4], const struct facet_motion *motion, bool resting)
{
	const struct facet_corner halves[2][3] = {{at[0], at[1], at[2]}, {at[0], at[2], at[3]}};
	for (int i = 0; i < 2; i++)
		if (deform_facet_of(halves[i], motion, resting, &grousers->window, deform_facets_next(grousers->deform)))
			deform_facets_keep(grousers->deform);
}

/* Draws a bar that moves by `motion`. `corners`: its section at the end of the motion. */
static void draw_bar(struct grousers *grousers, const struct spot corners[4], double share, const struct facet_motion *motion,
		     bool resting)
{
	double half = grousers->shape->width / 2;
	for (int k = 0; k < 3; k++) { /* the fourth face lies inside the wheel */
		const struct spot *a = &corners[k], *b = &corners[k + 1];
		if (b->u >= a->u && !grousers->leans)
			continue; /* the face looks up or aside, so another face is lower */
		const struct facet_corner at[4] = {corner_of(grousers, *a, -half, share), corner_of(grousers, *b, -half, share),
						   corner_of(grousers, *b, half, share), corner_of(grousers, *a, half, share)};
		draw_face(grousers, at, motion, resting);
	}
	if (!grousers->leans)
		return;
	struct facet_corner at[4]; /* the lower end */
	for (int k = 0; k < 4; k++)
		at[k] = corner_of(grousers, corners[k], grousers->axes[1][2] > 0 ? -half : half, share);
	draw_face(grousers, at, motion, resting);
}

/* Draws a bar whose middle moves from middle[0] to middle[1]. `corners`: its section at the end. */
static void draw_half(struct grousers *grousers, const struct spot corners[4], const struct spot middle[2], const double shares[2],
		      bool resting)
{
	struct facet_corner start = corner_of(grousers, middle[0], 0, shares[0]), end = corner_of(grousers, middle[1], 0, shares[1]);
	struct facet_motion motion = {end.x - start.x, end.y - start.y, (int32_t)lrint(end.z - start.z)};
	draw_bar(grousers, corners, shares[1], &motion, resting);
}

/* Draws a bar that turns from angles[0] to angles[1], while the wheel moves from one share of its motion to the other. */
static void draw_step(struct grousers *grousers, const double angles[2], const double shares[2], bool last)
{
	struct spot corners[2][4];
	for (int k = 0; k < 2; k++)
		section(grousers->shape, angles[k], corners[k]);
	if (!grousers->leans && !shows(grousers->shape, corners[0]) && !shows(grousers->shape, corners[1]))
		return;
	struct spot from = centre_of(grousers->shape, angles[0]), to = centre_of(grousers->shape, angles[1]);
	if (angles[0] == angles[1]) {
		draw_half(grousers, corners[1], (const struct spot[2]){from, to}, shares, last);
		return;
	}
	struct spot middle = {(from.u + to.u) / 2, (from.w + to.w) / 2};
	double half = (shares[0] + shares[1]) / 2;
	for (int k = 0; k < 4; k++) {
		corners[0][k].u += middle.u - from.u;
		corners[0][k].w += middle.w - from.w;
	}
	draw_half(grousers, corners[0], (const struct spot[2]){from, middle}, (const double[2]){shares[0], half}, false);
	draw_half(grousers, corners[1], (const struct spot[2]){middle, to}, (const double[2]){half, shares[1]}, last);
}

/* Returns the angle of the first bar. It is less than `share`, the angle between two bars. */
static double phase_of(double turn, double share)
{
	double bars = turn / share;
	return (double)(uint32_t)(int64_t)llrint(ldexp(bars - floor(bars), 32)) * ldexp(share, -32);
}

enum status deform_grousers(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer)
{
	const struct deform_shape *shape = contact->shape;
	const struct post_rect read = window->read;
	const struct body_frame frame = {.x0 = read.x0, .y0 = read.y0, .spacing = deform->spacing, .zero = contact->to.z};
	const struct deform_pose *from = deform_is_contact_only(contact) ? &contact->to : &contact->from;
	enum status status = deform_facets_begin(deform, read, layer);
	if (status != STATUS_OK)
		return status;
	struct body_motion motion = deform_body_motion_of(from, &contact->to, &frame);
	struct grousers grousers = {
		.deform = deform,
		.shape = shape,
		.motion = &motion,
		.window = {motion.x0, motion.y0, (int32_t)(read.x1 - read.x0), (int32_t)(read.y1 - read.y0)},
		.leans = contact->to.roll != 0,
	};
	deform_axes(contact->to.yaw, 0, contact->to.roll, 0, grousers.axes);
	double share = 2 * M_PI / shape->grousers, turned = deform_is_contact_only(contact) ? 0 : contact->turned;
	double end = phase_of(contact->to.turn, share);
	int steps = (int)fmin(fmax(ceil(fabs(turned) / STEP), 1), STEPS_MAX);
	for (int i = 0; i < shape->grousers; i++)
		for (int k = 0; k < steps; k++) {
			const double shares[2] = {(double)k / steps, (double)(k + 1) / steps};
			double angle = end + i * share;
			draw_step(&grousers, (const double[2]){angle - (1 - shares[0]) * turned, angle - (1 - shares[1]) * turned}, shares,
				  k + 1 == steps);
		}
	deform_facets_end(deform);
	return STATUS_OK;
}
