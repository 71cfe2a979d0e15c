/* What tests of furrow_probe share: worlds on an even slope. */
#ifndef FURROW_TESTS_PROBING_H
#define FURROW_TESTS_PROBING_H

#include <math.h>

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

static inline struct furrow_world *probing_world(const struct probing_ground *ground)
{
	char scene[400];
	struct furrow_world *world = NULL;
	const char *store = support_path(ground->name);
	snprintf(scene, sizeof scene, "{scene: 1, time_step: %g, spacing: %.10g, soil: {name: %s}, redistribute: {model: scm, bulldozing: %g}, cache: {slots: %d}}",
		 ground->time_step > 0 ? ground->time_step : 0.01, ground->spacing, ground->soil, ground->bare ? 0 : 0.5, ground->slots > 0 ? ground->slots : 64);
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

#endif
