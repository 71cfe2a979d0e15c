/*
 * A wheel's grousers: bars across its rim, as long as the wheel is wide. They turn with the wheel.
 *
 * The wheel moves straight during a contact, but a bar also turns about the axle. Here a bar moves straight from its place at
 * the start to its place at the end. For the first half it has its attitude at the start, for the second half its attitude
 * at the end. A bar of a rolling wheel hardly moves on the ground, so this is close. The error is at most half the turn times
 * half the bar's diagonal. A large turn, as of a spinning wheel, is divided into steps of at most STEP.
 *
 * The turn comes from the contact, since poses may leave whole turns out. A wheel that turns by the angle between two bars
 * has the same bits as before. For that the phase is a whole number of 2^-32 of this angle.
 */
#include "soil/shape/bars.h"

#include <math.h>

#define STEP 0.2     /* radians */
#define STEPS_MAX 32 /* so large a turn within one post moves a bar past every place on the rim */

/* A place in the wheel's plane: u along its heading, w up in that plane; metres. */
struct spot {
	double u, w;
};

struct bars {
	const struct soil_shape *shape;
	const struct bars_motion *motion;
	double axes[3][3]; /* along its heading, along the axle to the left, up in the wheel's plane */
	bool leans;        /* the axle is not level */
	bars_fn face;
	void *user;
};

/* Computes the corners of a bar's section. `angle`: from straight down, positive towards the back and up. The inner corners lie
 * inside the rim. */
static void section(const struct soil_shape *shape, double angle, struct spot corners[4])
{
	double half = shape->grouser_thickness / 2;
	double inner = sqrt(fmax(0, shape->radius * shape->radius - half * half)), outer = shape->radius + shape->grouser_height;
	double c = cos(angle), s = sin(angle);
	const double out[4] = {inner, outer, outer, inner}, along[4] = {-half, -half, half, half};
	for (int k = 0; k < 4; k++)
		corners[k] = (struct spot){-s * out[k] - c * along[k], -c * out[k] + s * along[k]};
}

static struct spot centre_of(const struct soil_shape *shape, double angle)
{
	return (struct spot){-sin(angle) * shape->radius, -cos(angle) * shape->radius};
}

/* Returns true if the bar can lower the envelope: it is in the wheel's lower half, or sticks out beyond the rim. */
static bool shows(const struct soil_shape *shape, const struct spot corners[4])
{
	for (int k = 0; k < 4; k++)
		if (corners[k].w < 0 || fabs(corners[k].u) > shape->radius)
			return true;
	return false;
}

/* Gives where a place of the wheel is after `share` of the motion. `side`: metres along the axle. */
static void place_of(const struct bars *bars, struct spot spot, double side, double share, double at[3])
{
	const struct bars_motion *m = bars->motion;
	const double(*axes)[3] = (const double(*)[3])bars->axes;
	at[0] = (double)(m->x + share * m->dx) + spot.u * axes[0][0] + side * axes[1][0] + spot.w * axes[2][0];
	at[1] = (double)(m->y + share * m->dy) + spot.u * axes[0][1] + side * axes[1][1] + spot.w * axes[2][1];
	at[2] = m->z + share * m->dz + (side * axes[1][2] + spot.w * axes[2][2]);
}

/* Shows a bar whose motion `face` has. `corners`: its section at the end of the motion. */
static void show_bar(const struct bars *bars, const struct spot corners[4], double share, struct bar_face *face)
{
	double half = bars->shape->width / 2;
	for (int k = 0; k < 3; k++) { /* the fourth face lies inside the wheel */
		const struct spot *a = &corners[k], *b = &corners[k + 1];
		if (b->u >= a->u && !bars->leans)
			continue; /* the face looks up or aside, so another face is lower */
		place_of(bars, *a, -half, share, face->at[0]);
		place_of(bars, *b, -half, share, face->at[1]);
		place_of(bars, *b, half, share, face->at[2]);
		place_of(bars, *a, half, share, face->at[3]);
		bars->face(bars->user, face);
	}
	if (!bars->leans)
		return;
	for (int k = 0; k < 4; k++) /* the lower end */
		place_of(bars, corners[k], bars->axes[1][2] > 0 ? -half : half, share, face->at[k]);
	bars->face(bars->user, face);
}

/* Shows a bar whose middle moves from middle[0] to middle[1]. `corners`: its section at the end. */
static void show_half(const struct bars *bars, const struct spot corners[4], const struct spot middle[2], const double shares[2], bool resting)
{
	struct bar_face face = {.resting = resting};
	place_of(bars, middle[0], 0, shares[0], face.from);
	place_of(bars, middle[1], 0, shares[1], face.to);
	show_bar(bars, corners, shares[1], &face);
}

/* Shows a bar that turns from angles[0] to angles[1], while the wheel moves from one share of its motion to the other. */
static void show_step(const struct bars *bars, const double angles[2], const double shares[2], bool last)
{
	struct spot corners[2][4];
	for (int k = 0; k < 2; k++)
		section(bars->shape, angles[k], corners[k]);
	if (!bars->leans && !shows(bars->shape, corners[0]) && !shows(bars->shape, corners[1]))
		return;
	struct spot from = centre_of(bars->shape, angles[0]), to = centre_of(bars->shape, angles[1]);
	if (angles[0] == angles[1]) {
		show_half(bars, corners[1], (const struct spot[2]){from, to}, shares, last);
		return;
	}
	struct spot middle = {(from.u + to.u) / 2, (from.w + to.w) / 2};
	double half = (shares[0] + shares[1]) / 2;
	for (int k = 0; k < 4; k++) {
		corners[0][k].u += middle.u - from.u;
		corners[0][k].w += middle.w - from.w;
	}
	show_half(bars, corners[0], (const struct spot[2]){from, middle}, (const double[2]){shares[0], half}, false);
	show_half(bars, corners[1], (const struct spot[2]){middle, to}, (const double[2]){half, shares[1]}, last);
}

/* Returns the angle of the first bar. It is less than `share`, the angle between two bars. */
static double phase_of(double turn, double share)
{
	double bars = turn / share;
	return (double)(uint32_t)(int64_t)llrint(ldexp(bars - floor(bars), 32)) * ldexp(share, -32);
}

void soil_bars(const struct soil_shape *shape, const struct soil_pose *pose, const struct bars_motion *motion, bars_fn face, void *user)
{
	struct bars bars = {.shape = shape, .motion = motion, .leans = pose->roll != 0, .face = face, .user = user};
	soil_axes(pose->yaw, 0, pose->roll, 0, bars.axes);
	double share = 2 * M_PI / shape->grousers, turned = motion->turned;
	double end = phase_of(pose->turn, share);
	int steps = (int)fmin(fmax(ceil(fabs(turned) / STEP), 1), STEPS_MAX);
	for (int i = 0; i < shape->grousers; i++)
		for (int k = 0; k < steps; k++) {
			const double shares[2] = {(double)k / steps, (double)(k + 1) / steps};
			double angle = end + i * share;
			show_step(&bars, (const double[2]){angle - (1 - shares[0]) * turned, angle - (1 - shares[1]) * turned}, shares, k + 1 == steps);
		}
}

/* A bar carries the soil before it as far as its wedge reaches. That is about twice its height times tan(45 degrees + phi / 2): 3.4 heights at 29 degrees. */
#define BAR_WEDGE 3.4

double soil_bars_carry(const struct soil_shape *shape)
{
	if (shape->kind != SOIL_WHEEL || shape->grousers <= 0)
		return 0;
	const double outer = shape->radius + shape->grouser_height;
	return fmin(shape->grousers * (shape->grouser_thickness + BAR_WEDGE * shape->grouser_height) / (2 * M_PI * outer), 1);
}
