/* What tests of furrow_probe share: worlds on an even slope. */
#ifndef FURROW_TESTS_PROBING_H
#define FURROW_TESTS_PROBING_H

#include <math.h>

#include "../support/near.h"
#include "hosted.h"

#define DEGREES (M_PI / 180)

static const struct extent probing_extent = {257, 257, 0.25, 64};
static double probing_slope, probing_base; /* of the ground: to the east; m */

static inline double probing_incline(int64_t x, int64_t y)
{
	return probing_base + probing_slope * probing_extent.spacing * (double)x;
}

struct probing_ground {
	const char *name, *soil; /* of the store; its soil */
	double spacing, degrees, height;
	int slots;               /* 0: enough */
	double time_step;
	bool bare;               /* no soil is laid around bodies */
};

static const char *probing_more = ""; /* other keys of `redistribute`: ", KEY: VALUE" */

static inline struct furrow_world *probing_world(const struct probing_ground *ground)
{
	char scene[400];
	struct furrow_world *world = NULL;
	const char *store = support_path(ground->name);
	snprintf(scene, sizeof scene, "{scene: 1, time_step: %g, spacing: %.10g, soil: {name: %s}, redistribute: {model: scm, bulldozing: %g%s}, cache: {slots: %d}}",
		 ground->time_step > 0 ? ground->time_step : 0.01, ground->spacing, ground->soil, ground->bare ? 0 : 0.5, probing_more, ground->slots > 0 ? ground->slots : 64);
	probing_slope = tan(ground->degrees * DEGREES);
	probing_base = ground->height;
	support_store(store, probing_extent, probing_incline);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	assert_non_null(world);
	return world;
}

static const char probing_wheel[] = "{shape: {wheel: {radius: 0.25, width: 0.2}}}", probing_ball[] = "{shape: {sphere: {radius: 0.25}}}",
		  probing_box[] = "{shape: {box: {size: [0.3, 0.2, 0.2]}}}";

static inline void probing_step(struct furrow_world *world, furrow_body body, const struct furrow_state *state, double seconds)
{
	done(furrow_set_states(world, 1, &body, state));
	done(furrow_step(world, seconds));
}

static inline struct furrow_contact probing_ask(struct furrow_world *world, furrow_body body, const struct furrow_state *state)
{
	struct furrow_contact contact;
	done(furrow_probe(world, 1, &body, state, &contact, sizeof contact));
	return contact;
}

/* --- how the force changes --- */

static inline void probing_turn(const double axis[3], double angle, double q[4])
{
	const double s = sin(angle / 2), r[4] = {cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]}, p[4] = {q[0], q[1], q[2], q[3]};
	q[0] = r[0] * p[0] - r[1] * p[1] - r[2] * p[2] - r[3] * p[3];
	q[1] = r[0] * p[1] + r[1] * p[0] + r[2] * p[3] - r[3] * p[2];
	q[2] = r[0] * p[2] - r[1] * p[3] + r[2] * p[0] + r[3] * p[1];
	q[3] = r[0] * p[3] + r[1] * p[2] - r[2] * p[1] + r[3] * p[0];
}

/* Moves a state along one of its six freedoms, or changes its velocity. */
static inline struct furrow_state probing_moved(const struct furrow_state *from, int freedom, double by, bool rate)
{
	struct furrow_state to = *from;
	const double axis[3] = {freedom == 3, freedom == 4, freedom == 5};
	if (rate)
		*(freedom < 3 ? &to.linear[freedom] : &to.angular[freedom - 3]) += by;
	else if (freedom < 3)
		to.pose.position[freedom] += by;
	else
		probing_turn(axis, by, to.pose.orientation);
	return to;
}

static inline double probing_part(const struct furrow_contact *contact, int i)
{
	return i < 3 ? contact->force[i] : contact->moment[i - 3];
}

struct probing_off {
	double worst, least, most; /* as a share of the diagonal; quotients of diagonals */
};

/* Compares a matrix with quotients of differences. freedoms: a bit for each. */
static inline struct probing_off probing_off_by(struct furrow_world *world, furrow_body body, const struct furrow_state *at, unsigned freedoms, bool rate)
{
	const struct furrow_contact here = probing_ask(world, body, at);
	const double (*matrix)[6] = rate ? here.damping : here.stiffness;
	struct probing_off off = {0, INFINITY, 0};
	for (int k = 0; k < 6; k++) {
		if (!(freedoms & 1u << k))
			continue;
		const double by = rate ? 1e-5 : 4e-6;
		const struct furrow_state more = probing_moved(at, k, by, rate), less = probing_moved(at, k, -by, rate);
		const struct furrow_contact high = probing_ask(world, body, &more), low = probing_ask(world, body, &less);
		for (int i = 0; i < 6; i++) {
			const double slope = (probing_part(&high, i) - probing_part(&low, i)) / (2 * by);
			if (freedoms & 1u << i)
				off.worst = support_most(off.worst, fabs(matrix[i][k] - slope) / sqrt(fabs(matrix[i][i] * matrix[k][k])));
			if (i == k) {
				off.least = support_least(off.least, matrix[i][i] / slope);
				off.most = support_most(off.most, matrix[i][i] / slope);
			}
		}
	}
	return off;
}

#endif
