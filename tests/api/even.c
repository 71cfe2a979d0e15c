/*
 * The forces of soil with `faces: on` change evenly. Bodies that slide are probed as they are moved and turned, by micrometres at last. There the lower envelope
 * bears next to nothing, so the forces are those of the faces. Slips and angles through 0, and a first touch, are those of soil as it is.
 */
#include "../support/program.h"
#include "probing.h"

#define REACHES 0.01   /* m: how far a probe moves a body, either way */
#define PARTS 50      /* of that way both ways */
#define BACK 3e-6      /* m: where a body turns back, what it carries is laid, so there the ground is another one */
#define RISES 0.0009   /* m: a contact ends where a body rises by a twentieth of a post, too */
#define FINEST 1.5e-6  /* m */
#define JUMP 0.005     /* of the body's load */
#define ARM 0.25       /* m: a turn by so much is a way, and a moment over this is a force */
#define ROW 0.01       /* s */
#define HEADING 0.35   /* rad */

/* slip: of a wheel; of other bodies it is whole. aside: rad from its heading to its way. */
static const struct even_body {
	const char *name, *shape;
	double reach, radius, slip, aside;
	bool moved, turned; /* it is probed as it is moved, and tipped */
} bodies[] = {
	{"a wheel with slip", "wheel: {radius: 0.25, width: 0.2}", 0.25, 0.25, 0.3, 0, false, false},
	{"a locked wheel", "wheel: {radius: 0.25, width: 0.2}", 0.25, 0.25, -1, 0, true, true},
	{"a wheel that is angled", "wheel: {radius: 0.25, width: 0.2}", 0.25, 0.25, 0.1, 0.5, false, false},
	{"a wheel with bars", "wheel: {radius: 0.25, width: 0.2, grousers: 18, grouser_height: 0.02, grouser_thickness: 0.01}", 0.27, 0.27, 0.3, 0.2, false, false},
	{"a sphere", "sphere: {radius: 0.15}", 0.15, 0, 0, 0, true, true},
	{"a box", "box: {size: [0.3, 0.2, 0.2]}", 0.1, 0, 0, 0.3, true, true},
	{"a cylinder that stands", "cylinder: {radius: 0.12, length: 0.3}", 0.15, 0, 0, 0, false, false},
	{"an ellipsoid", "ellipsoid: {radii: [0.2, 0.15, 0.12]}", 0.12, 0, 0, 0.2, true, true},
};
#define BODIES (sizeof bodies / sizeof *bodies)

/* soil: of the scene. */
static struct furrow_world *even_world(double spacing, const char *soil)
{
	char scene[300];
	struct furrow_world *world = NULL;
	const char *store = support_path("even.furrow");
	snprintf(scene, sizeof scene, "{scene: 1, time_step: %g, spacing: %g, soil: {%s, damping: 0}, redistribute: {model: scm, faces: on}, cache: {slots: 64}}", ROW, spacing, soil);
	probing_slope = 0;
	probing_base = 100;
	support_store(store, probing_extent, probing_incline);
	const struct furrow_open open = hosted_open(scene, store);
	done(furrow_world_open(&open, &world));
	return world;
}

struct even {
	struct furrow_world *world;
	furrow_body body;
	struct furrow_state state;
};

static const char firm[] = "name: dry_sand", bears_nothing[] = "name: dry_sand, bekker_kc: 1, bekker_kphi: 1, cohesion: 0";

static struct even even_begin(double spacing, const char *soil, const struct even_body *body, double heading, double above)
{
	char text[300];
	struct even even = {.world = even_world(spacing, soil), .state = hosted_state(15.013, 15.007, 100 + body->reach + above)};
	snprintf(text, sizeof text, "{shape: {%s}}", body->shape);
	probing_turn((const double[]){0, 0, 1}, heading, even.state.pose.orientation);
	done(furrow_body_add(even.world, text, &even.body));
	done(furrow_place(even.world, even.body, &even.state.pose));
	return even;
}

static void even_go(struct even *even, double x, double y, double z, double turn, double heading, int rows)
{
	const double axis[3] = {-sin(heading), cos(heading), 0}, by = 1.0 / rows;
	for (int row = 0; row < rows; row++) {
		struct furrow_state *s = &even->state;
		const double way[3] = {x * by, y * by, z * by};
		for (int k = 0; k < 3; k++) {
			s->pose.position[k] += way[k];
			s->linear[k] = way[k] / ROW;
			s->angular[k] = axis[k] * turn * by / ROW;
		}
		probing_turn(axis, turn * by, s->pose.orientation);
		probing_step(even->world, even->body, s, ROW);
	}
}

/* Presses a body into the soil, and lets it slide. */
static struct even even_slid(double spacing, const char *soil, const struct even_body *body, double heading, double slip)
{
	struct even even = even_begin(spacing, soil, body, heading, 0.005);
	const double way = 0.15, along = heading + body->aside, turn = body->radius > 0 ? (slip < 0 ? way * (1 + slip) : way / (1 - slip)) / body->radius : 0;
	even_go(&even, 0, 0, -0.035, 0, heading, 20);
	even_go(&even, way * cos(along), way * sin(along), 0, turn, heading, 60);
	return even;
}

static void even_end(struct even *even)
{
	done(furrow_world_close(even->world));
}

/* Returns the largest difference of two contacts' forces, N. */
static double apart(const struct furrow_contact *a, const struct furrow_contact *b)
{
	double most = 0;
	for (int k = 0; k < 3; k++)
		most = fmax(most, fmax(fabs(a->force[k] - b->force[k]), fabs(a->moment[k] - b->moment[k]) / ARM));
	return most;
}

static double load_of(const struct furrow_contact *contact)
{
	return sqrt(contact->force[0] * contact->force[0] + contact->force[1] * contact->force[1] + contact->force[2] * contact->force[2]);
}

static struct furrow_contact at_place(struct even *even, int freedom, double by)
{
	const struct furrow_state state = probing_moved(&even->state, freedom, freedom < 3 ? by : by / ARM, false);
	return probing_ask(even->world, even->body, &state);
}

/* Returns the largest step of the force between two places as the place is halved, N. *where: m. */
static double steepest(struct even *even, int freedom, double from, double to, const struct furrow_contact *first, const struct furrow_contact *last, double *where)
{
	struct furrow_contact low = *first, high = *last;
	while (to - from > FINEST) {
		const double middle = 0.5 * (from + to);
		const struct furrow_contact half = at_place(even, freedom, middle);
		if (apart(&low, &half) > apart(&half, &high)) {
			high = half;
			to = middle;
		} else {
			low = half;
			from = middle;
		}
	}
	*where = from;
	return apart(&low, &high);
}

/* Returns the largest step along a freedom, N. */
static double largest_step(struct even *even, int freedom, double low, double high, double worth, double *where)
{
	const double by = (high - low) / PARTS;
	struct furrow_contact before = at_place(even, freedom, low);
	double most = 0;
	for (int i = 0; i < PARTS; i++) {
		const struct furrow_contact now = at_place(even, freedom, low + by * (i + 1));
		double at;
		if (apart(&before, &now) > fmax(worth, most)) {
			const double step = steepest(even, freedom, low + by * i, low + by * (i + 1), &before, &now, &at);
			if (step > most) {
				most = step;
				*where = at;
			}
		}
		before = now;
	}
	return most;
}

static void places_and_turns_show_no_jump(void **state)
{
	bool fails = false;
	(void)state;
	for (size_t b = 0; b < BODIES; b++) {
		if (!bodies[b].moved)
			continue;
		/* The ground ahead is looked for along other lines where a body goes north-east. */
		struct even even = even_slid(0.02, bears_nothing, &bodies[b], M_PI / 4 - bodies[b].aside, bodies[b].slip);
		const struct furrow_contact here = probing_ask(even.world, even.body, &even.state);
		const double load = load_of(&here);
		assert_true(load > 10);
		for (int k = 0; k < 6; k++) {
			double where = 0;
			if ((k == 3 || k == 4) && !bodies[b].turned)
				continue;
			double step = largest_step(&even, k, -REACHES, -BACK, JUMP * load, &where);
			step = fmax(step, largest_step(&even, k, BACK, k == 2 ? RISES : REACHES, fmax(JUMP * load, step), &where));
			if (step > JUMP * load || getenv("EVEN_TRACE") != NULL)
				print_message("%s, freedom %d: load %.1f N, step %.3f %% at %.5f mm\n", bodies[b].name, k, load, 100 * step / load, where * 1e3);
			fails = fails || step > JUMP * load;
		}
		even_end(&even);
	}
	assert_false(fails);
}

static void a_first_touch_shows_no_jump(void **state)
{
	bool fails = false;
	(void)state;
	for (size_t b = 0; b < BODIES; b++) {
		struct even even = even_slid(0.04, firm, &bodies[b], HEADING, bodies[b].slip);
		const struct furrow_contact here = probing_ask(even.world, even.body, &even.state);
		/* On ground that it has not touched, just as it has slid. */
		even_go(&even, 0, 0, 0.05, 0, HEADING, 4);
		even_go(&even, 0, 0.6, 0, 0, HEADING, 4);
		even_go(&even, 0, 0, -0.019, 0, HEADING, 2);
		even_go(&even, 0.05, 0, 0, 0, HEADING, 20);
		double where = 0;
		const double load = load_of(&here), step = largest_step(&even, 2, -0.003, 0.001, JUMP * load, &where);
		print_message("%s touches: load %.1f N, step %.3f %% at %.5f mm\n", bodies[b].name, load, 100 * step / load, where * 1e3);
		fails = fails || step > JUMP * load;
		even_end(&even);
	}
	assert_false(fails);
}

/* Slips and angles that differ by little, through 0 and through where the blend begins. */
static void slip_and_angle_through_0_show_no_jump(void **state)
{
	static const double slips[] = {-0.00225, -0.00205, -0.002, -0.00195, -0.00175, -0.0001, 0, 0.0001};
	static const struct even_body smooth = {"a wheel", "wheel: {radius: 0.25, width: 0.2}", 0.25, 0.25, 0, 0, true, true};
	bool fails = false;
	(void)state;
	for (int angled = 0; angled < 2; angled++) {
		struct furrow_contact before;
		for (size_t i = 0; i < sizeof slips / sizeof *slips; i++) {
			struct even_body body = smooth;
			body.aside = angled ? slips[i] : 0;
			struct even even = even_slid(0.04, firm, &body, HEADING, angled ? 0 : slips[i]);
			const struct furrow_contact now = probing_ask(even.world, even.body, &even.state);
			if (i > 0) {
				const double share = apart(&before, &now) / load_of(&now);
				print_message("%s %g: load %.1f N, step %.3f %%\n", angled ? "angle" : "slip", slips[i], load_of(&now), 100 * share);
				fails = fails || share > JUMP;
			}
			before = now;
			even_end(&even);
		}
	}
	assert_false(fails);
}

TEST_PROGRAM(even)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(places_and_turns_show_no_jump),
		cmocka_unit_test(a_first_touch_shows_no_jump),
		cmocka_unit_test(slip_and_angle_through_0_show_no_jump),
	};
	return cmocka_run_group_tests_name("api/even", tests, support_enter, support_leave);
}
