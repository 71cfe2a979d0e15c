/*
 * Drops a ball of 20 kg on soil and prints how high it is.
 *
 *     furrow synth -o plain.furrow --kind plain --posts 257x257 --spacing 0.25 --relief 2
 *     cc drop_ball.c -o drop_ball $(pkg-config --cflags --libs furrow)
 *     ./drop_ball plain.furrow drop_ball.furrow
 *
 * The ball's motion is this program's own: furrow tells the force of the soil, and the program integrates it. What the ball
 * presses into the ground is kept in drop_ball.furrow, an overlay; plain.furrow is only read.
 */
#include <furrow.h>

#include <stdio.h>
#include <stdlib.h>

#define RADIUS 0.2    /* m */
#define MASS 20.0     /* kg */
#define HEIGHT 0.5    /* m between the ball and the ground when it is let go */
#define STEP 0.0005   /* s */
#define STEPS 2000
#define TOLD_EVERY 100

static const char scene[] =
	"scene: 1\n"
	"spacing: 0.03125\n"
	"soil: {name: dry_sand, damping: 6e5} # Pa s/m: moist sand, so that the ball does not bounce for long\n"
	"redistribute: {model: scm}\n";

/* Says why a call failed, and ends the program. */
static void must(furrow_status status)
{
	if (status == FURROW_OK)
		return;
	fprintf(stderr, "drop_ball: %s\n", furrow_last_error());
	exit((int)status);
}

int main(int argc, char **argv)
{
	if (argc != 3) {
		fprintf(stderr, "usage: drop_ball STORE OVERLAY\n");
		return FURROW_USAGE;
	}
	struct furrow_open open = {.size = sizeof open, .scene = scene, .store = argv[1], .overlay = argv[2]};
	struct furrow_world *world;
	must(furrow_world_open(&open, &world));

	/* The ground in the middle of the terrain. */
	struct furrow_info info = {0};
	info.size = sizeof info;
	must(furrow_info(world, &info));
	const double middle[2] = {info.extent[0] / 2, info.extent[1] / 2};
	struct furrow_point ground;
	must(furrow_points(world, 1, middle, &ground));

	furrow_body ball;
	char object[64];
	snprintf(object, sizeof object, "{name: ball, shape: {sphere: {radius: %g}}}", RADIUS);
	must(furrow_body_add(world, object, &ball));
	struct furrow_state state = {{{middle[0], middle[1], ground.height + RADIUS + HEIGHT}, {1, 0, 0, 0}}, {0, 0, 0}, {0, 0, 0}};
	must(furrow_place(world, ball, &state.pose));

	struct furrow_contact contact = {0};
	printf("time_s,above_ground_m,velocity_m_s,force_N\n");
	for (int i = 0; i <= STEPS; i++) {
		if (i % TOLD_EVERY == 0)
			printf("%.3f,%.4f,%.3f,%.1f\n", furrow_time(world), state.pose.position[2] - RADIUS - ground.height, state.linear[2],
			       contact.force[2]);
		/* What the soil would do here, and how that changes with the motion. The soil is stiff, so its force is taken at the step's end. */
		must(furrow_probe(world, 1, &ball, &state, &contact, sizeof contact));
		const double stiff = contact.stiffness[2][2], damped = contact.damping[2][2], speed = state.linear[2];
		const double push = contact.force[2] - MASS * info.gravity + stiff * STEP * speed;
		state.linear[2] += push * STEP / (MASS - damped * STEP - stiff * STEP * STEP);
		state.pose.position[2] += state.linear[2] * STEP;
		must(furrow_set_states(world, 1, &ball, &state));
		must(furrow_step(world, STEP));
	}
	must(furrow_points(world, 1, middle, &ground));
	printf("# the ball left a hollow of %.4f m\n", -ground.offset);
	must(furrow_world_close(world));
	return 0;
}
