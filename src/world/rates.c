/*
 * Velocities of a host's bodies: those that the host gives, or those of its poses.
 *
 * A host may give all NaN for `linear` or `angular`. Then the velocity is that of the straight motion from the pose after the last step to the
 * next one. A body that is not set before a step does not move in it, so such a velocity is 0 then.
 *
 * Where given velocities and poses differ by far in STEPS steps on end, a note says so, once for each body. One step may be an impact.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define STEPS 3
#define FAR 0.5          /* of the greater velocity */
#define SLOW 0.01        /* m/s and rad/s: less than this is no difference */
#define TURNS 0.1        /* of the given rate: a round body whose poses turn less is not turned by its host */
#define ALIKE 2.5        /* rad in a step: from half a turn on, poses do not tell how far and which way a body turned */

static double length_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

bool world_rates_given(const double rate[3])
{
	return !isnan(rate[0]);
}

static void rates_of(const struct furrow_pose *from, const struct furrow_pose *to, double seconds, double linear[3], double angular[3])
{
	world_rotation_between(from->orientation, to->orientation, angular);
	for (int k = 0; k < 3; k++) {
		linear[k] = seconds > 0 ? (to->position[k] - from->position[k]) / seconds : 0;
		angular[k] = seconds > 0 ? angular[k] / seconds : 0;
	}
}

void world_rates_fill(const struct furrow_pose *from, double seconds, struct furrow_state *state)
{
	double linear[3], angular[3];
	if (world_rates_given(state->linear) && world_rates_given(state->angular))
		return;
	rates_of(from, &state->pose, seconds, linear, angular);
	if (!world_rates_given(state->linear))
		memcpy(state->linear, linear, sizeof linear);
	if (!world_rates_given(state->angular))
		memcpy(state->angular, angular, sizeof angular);
}

/* --- notes --- */

static bool are_far(const double given[3], const double posed[3])
{
	const double between[3] = {given[0] - posed[0], given[1] - posed[1], given[2] - posed[2]};
	return length_of(between) > fmax(FAR * fmax(length_of(given), length_of(posed)), SLOW);
}

/* Nothing shows how a round body is turned about its axle, so many hosts leave its orientation as it is. given, posed: rad/s. */
static bool leaves_turns(const struct body *body, const double given[3], const double posed[3])
{
	const enum soil_shape_kind kind = body->object->shape.kind;
	return (kind == SOIL_WHEEL || kind == SOIL_SPHERE) && length_of(posed) < TURNS * length_of(given);
}

/* Remembers whether the host leaves the turns of this body out of its poses. While it does not turn, what was known holds. */
static void see_turns(struct body *body, const struct furrow_state *next, double seconds)
{
	double linear[3], posed[3];
	rates_of(&body->host.now.pose, &next->pose, seconds, linear, posed);
	if (!world_rates_given(next->angular))
		body->host.unposed = false;
	else if (length_of(next->angular) > 0 && seconds > 0)
		body->host.unposed = leaves_turns(body, next->angular, posed);
}

double world_rates_unposed(const struct body *body, const struct furrow_state *state)
{
	const double *from = body->host.now.pose.position, *to = state->pose.position, *v = state->linear;
	double along = 0, squares = 0;
	for (int k = 0; k < 3; k++) {
		along += (to[k] - from[k]) * v[k];
		squares += v[k] * v[k];
	}
	return body->host.unposed && along > 0 ? along / squares : 0;
}

static bool turns_are_far(const struct body *body, const double given[3], const double posed[3], double seconds)
{
	if (length_of(given) * seconds > ALIKE || length_of(posed) * seconds > ALIKE)
		return false;
	return !leaves_turns(body, given, posed) && are_far(given, posed);
}

static void watch(struct body *body, const struct furrow_state *next, double seconds)
{
	double linear[3], angular[3];
	const char *name = body->object->name;
	if (body->host.rates_told || !(seconds > 0))
		return;
	rates_of(&body->host.now.pose, &next->pose, seconds, linear, angular);
	const bool moves = world_rates_given(next->linear) && are_far(next->linear, linear);
	const bool turns = world_rates_given(next->angular) && turns_are_far(body, next->angular, angular, seconds);
	body->host.rates_far = moves || turns ? body->host.rates_far + 1 : 0;
	if (body->host.rates_far >= STEPS) {
		body->host.rates_told = true;
		if (moves)
			note("%s: its linear velocity is given as %.3g m/s, and its poses move at %.3g m/s; slip comes from the velocities, so give those of "
			     "the motion, or NaN for what the poses give", name, length_of(next->linear), length_of(linear));
		else
			note("%s: its angular velocity is given as %.3g rad/s, and its poses turn at %.3g rad/s; slip and spin come from the velocities, so "
			     "give those of the motion, or NaN for what the poses give", name, length_of(next->angular), length_of(angular));
	} else if (!world_rates_given(next->angular) && length_of(angular) * seconds > ALIKE) {
		body->host.rates_told = true;
		note("%s: its poses turn by %.0f degrees in a step of %g s; from half a turn on they do not tell how far and which way, so give `angular`, or "
		     "step more often", name, length_of(angular) * seconds * 180 / M_PI, seconds);
	}
}

void world_rates_take(struct body *body, double seconds)
{
	static const double none[3] = {0, 0, 0};
	if (body->host.has_next) {
		struct furrow_state next = body->host.next;
		watch(body, &next, seconds);
		body->host.posed_linear = !world_rates_given(next.linear);
		body->host.posed_angular = !world_rates_given(next.angular);
		see_turns(body, &next, seconds);
		world_rates_fill(&body->host.now.pose, seconds, &next);
		body->host.now = next;
	} else {
		if (body->host.posed_linear)
			memcpy(body->host.now.linear, none, sizeof none);
		if (body->host.posed_angular)
			memcpy(body->host.now.angular, none, sizeof none);
	}
	body->host.has_next = false;
}
