/*
 * Bodies that move as the soil pushes them: a host integrates by furrow_probe, and commits by furrow_set_states and furrow_step.
 * They settle where statics says, lose their energy and hold on slopes.
 */
#include "../support/near.h"
#include "probing.h"
#include "../support/program.h"

#define G 9.81
#define MASS 125.0
#define STEP 0.002

static const char ball[] = "{shape: {sphere: {radius: 0.3}}}", wheel[] = "{shape: {wheel: {radius: 0.3, width: 0.24}}}",
		  sledge[] = "{shape: {box: {size: [0.3, 0.3, 0.3]}}}";

struct mover {
	struct furrow_world *world;
	furrow_body body;
	struct furrow_state state;
	double mass, inertia; /* of turning about an axis through its centre */
	double energy, lowest, most; /* J: now, the least so far, and the most that it was above that once the hand let go */
	bool turns;           /* false: it is kept from turning */
	double turn;          /* rad about y */
	double support;       /* N up */
	struct furrow_contact contact;
};

/* `lies`: turned so that its lower side lies on the slope. */
static struct mover mover_on(struct furrow_world *world, const char *shape, double reach, double mass, bool lies)
{
	struct mover mover = {.world = world, .mass = mass, .inertia = 0.4 * mass * reach * reach, .energy = NAN, .lowest = INFINITY};
	const double tilt = atan(probing_slope);
	mover.state = hosted_state(15.013, 15.007, 0);
	mover.state.pose.position[2] = 100 + probing_slope * 15.013 + reach / cos(tilt);
	if (lies) {
		mover.state.pose.orientation[0] = cos(tilt / 2);
		mover.state.pose.orientation[2] = -sin(tilt / 2);
	}
	done(furrow_body_add(world, shape, &mover.body));
	done(furrow_place(world, mover.body, &mover.state.pose));
	done(furrow_set_states(world, 1, &mover.body, &mover.state));
	done(furrow_step(world, 0));
	return mover;
}

static double mechanical(const struct mover *mover)
{
	const double *v = mover->state.linear, w = mover->turns ? mover->state.angular[1] : 0;
	return 0.5 * mover->mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 0.5 * mover->inertia * w * w +
	       mover->mass * G * mover->state.pose.position[2];
}

/* Semi-implicit Euler. */
static void advance(struct mover *mover, double seconds)
{
	struct furrow_state *s = &mover->state;
	done(furrow_probe(mover->world, 1, &mover->body, s, &mover->contact, sizeof mover->contact));
	assert_int_not_equal(mover->contact.state, FURROW_UNKNOWN);
	if (getenv("PROBE_TRACE") != NULL)
		print_message("   E %.6f x %.7f z %.7f v %.6f %.6f w %.6f F %.3f %.3f M %.4f\n", mechanical(mover) - 122982.5, s->pose.position[0], s->pose.position[2], s->linear[0], s->linear[2], s->angular[1], mover->contact.force[0], mover->contact.force[2], mover->contact.moment[1]);
	const double energy = mechanical(mover);
	if (mover->support == 0 && !isnan(mover->energy))
		mover->most = support_most(mover->most, energy - mover->lowest);
	mover->energy = energy;
	mover->lowest = support_least(mover->lowest, energy);
	for (int k = 0; k < 3; k++) {
		const double gravity = k == 2 ? -mover->mass * G + mover->support : 0;
		s->linear[k] += (mover->contact.force[k] + gravity) / mover->mass * seconds;
		s->pose.position[k] += s->linear[k] * seconds;
	}
	if (mover->turns) {
		s->angular[1] += mover->contact.moment[1] / mover->inertia * seconds;
		mover->turn += s->angular[1] * seconds;
		s->pose.orientation[0] = cos(mover->turn / 2);
		s->pose.orientation[2] = sin(mover->turn / 2);
	}
	done(furrow_set_states(mover->world, 1, &mover->body, s));
	done(furrow_step(mover->world, seconds));
}

static double speed(const struct mover *mover)
{
	const double *v = mover->state.linear;
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Lets the body down in 3 s, and leaves it alone for the rest. Its energy, with the hand's, never rises. */
static struct mover let_down(struct furrow_world *world, const char *shape, double reach, bool turns, double seconds, double rest[2][3])
{
	struct mover mover = mover_on(world, shape, reach, MASS, shape == sledge);
	const int steps = (int)(seconds / STEP);
	mover.turns = turns;
	for (int step = 0; step < steps; step++) {
		mover.support = MASS * G * fmax(1 - step * STEP / 3, 0);
		advance(&mover, STEP);
		if (step == steps - (int)(2 / STEP))
			memcpy(rest[0], mover.state.pose.position, sizeof rest[0]);
	}
	memcpy(rest[1], mover.state.pose.position, sizeof rest[1]);
	return mover;
}

static double pressure(double width, double sinkage)
{
	return fmin((0.99e3 / width + 1528.43e3) * pow(sinkage, 1.1), 4e7 * sinkage);
}

/* The shear stress on a flank that sank by `deep` where it is so steep, Pa. */
static double sheared(double stress, double deep, double sine)
{
	return (1.04e3 + stress * tan(28 * DEGREES)) * (1 - exp(-deep * sine / 0.02));
}

/* The vertical force at a sinkage, as the body is let down: of the normal stress, and of the shear along its flanks. */
static double carried(const char *shape, double sinkage)
{
	const int parts = 4000;
	const double r = 0.3, reach = sqrt(r * r - (r - sinkage) * (r - sinkage));
	double sum = 0;
	if (shape == sledge)
		return 0.09 * pressure(0.3, sinkage);
	for (int i = 0; i < parts; i++) {
		/* The width of a sphere's patch is its radius. */
		const double x = reach * ((i + 0.5) / parts), deep = sqrt(r * r - x * x) - r + sinkage;
		const double stress = pressure(shape == wheel ? 0.24 : reach, deep);
		sum += (shape == wheel ? 2 * 0.24 : 2 * M_PI * x) * (stress + sheared(stress, deep, x / r) * x / sqrt(r * r - x * x));
	}
	return sum * reach / parts;
}

static double static_sinkage(const char *shape)
{
	double low = 0, high = 0.2;
	for (int i = 0; i < 60; i++)
		*(carried(shape, 0.5 * (low + high)) < MASS * G ? &low : &high) = 0.5 * (low + high);
	return low;
}

static void a_body_that_is_let_down_settles_where_statics_says(void **state)
{
	static const struct {
		const char *shape, *name;
		double reach, spacing;
	} rows[] = {{wheel, "wheel", 0.3, 0.03125}, {wheel, "wheel", 0.3, 0.015625}, {ball, "sphere", 0.3, 0.03125}, {ball, "sphere", 0.3, 0.015625}, {sledge, "box", 0.15, 0.03125}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct furrow_world *world = probing_world(&(struct probing_ground){"settle.furrow", "dry_sand", rows[i].spacing, 0, 100, 0, STEP, true});
		double rest[2][3];
		const struct mover mover = let_down(world, rows[i].shape, rows[i].reach, rows[i].shape == wheel, rows[i].shape == wheel ? 20 : 8, rest);
		const double sunk = 100 + rows[i].reach - rest[1][2], wanted = static_sinkage(rows[i].shape);
		print_message("%s, %g m: %.3f mm (%.3f), speed %.2g m/s, energy rose by at most %.2g J\n", rows[i].name, rows[i].spacing, sunk * 1e3, wanted * 1e3,
			      speed(&mover), mover.most);
		assert_near(sunk, wanted, 0.02 * wanted);
		assert_true(speed(&mover) < 1e-6);
		/* No more than what the soil may give back: the load times half of its elastic sinkage, of at most a millimetre. */
		assert_true(mover.most < MASS * G * 0.5e-3);
		done(furrow_world_close(world));
	}
}

static void on_a_slope_it_holds(void **state)
{
	static const struct {
		const char *shape, *name;
		double reach;
	} rows[] = {{wheel, "locked wheel", 0.3}, {ball, "sphere kept from turning", 0.3}, {sledge, "box", 0.15}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct furrow_world *world = probing_world(&(struct probing_ground){"hold.furrow", "dry_sand", 0.03125, 15, 100, 0, STEP, false});
		double rest[2][3];
		const struct mover mover = let_down(world, rows[i].shape, rows[i].reach, false, 12, rest);
		double creep = 0;
		for (int k = 0; k < 3; k++)
			creep += (rest[1][k] - rest[0][k]) * (rest[1][k] - rest[0][k]) / 4;
		print_message("%s: creeps %.3g um/s, speed %.2g m/s\n", rows[i].name, sqrt(creep) * 1e6, speed(&mover));
		assert_true(sqrt(creep) < 0.1e-6 && speed(&mover) < 1e-6);
		/* It is held by the soil, not by its place: on a slope a body that lies on it needs shear. */
		assert_near(mover.contact.force[2], MASS * G, 1e-3 * MASS * G);
		done(furrow_world_close(world));
	}
}

TEST_PROGRAM(probe_motion)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_body_that_is_let_down_settles_where_statics_says),
		cmocka_unit_test(on_a_slope_it_holds),
	};
	return cmocka_run_group_tests_name("api/probe_motion", tests, support_enter, support_leave);
}
