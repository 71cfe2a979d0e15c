/* For tests that press a ball into the ground of a hosted world and look at what it leaves. */
#ifndef FURROW_TESTS_RUT_H
#define FURROW_TESTS_RUT_H

#include "hosted.h"

static inline struct furrow_point point_at(struct furrow_world *world, double x, double y)
{
	const double xy[2] = {x, y};
	struct furrow_point point;
	done(furrow_points(world, 1, xy, &point));
	return point;
}

static inline struct furrow_contact contact_of(struct furrow_world *world, furrow_body body)
{
	struct furrow_contact contact;
	done(furrow_get_contacts(world, 1, &body, &contact, sizeof contact));
	return contact;
}

/* Presses a ball 0.1 m deep and moves it east, `steps` steps of 0.05 m. */
static inline void make_rut(struct furrow_world *world, furrow_body ball, double x, double y, int steps)
{
	for (int i = 0; i <= steps; i++)
		hosted_move(world, ball, x + 0.05 * i, y, 100.4);
}

#endif
