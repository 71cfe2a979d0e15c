/*
 * A ball that MuJoCo moves and Furrow's soil carries: it falls, rolls and comes to rest in its own rut.
 *
 *     furrow synth -o plain.furrow --kind plain --posts 257x257 --spacing 0.25 --relief 2
 *     MUJOCO=the folder of MuJoCo 4: mujoco-4.0.0 where tools/packages.sh brought it
 *     cc mujoco_ball.c -o mujoco_ball $(pkg-config --cflags --libs furrow) -I$MUJOCO/include $MUJOCO/libmujoco.so.4.0.0 -Wl,-rpath,$MUJOCO
 *     ./mujoco_ball mujoco_ball.xml plain.furrow mujoco_ball.furrow
 *
 * The model has no ground: the soil's force is applied to the body, as any other force from outside. For whole vehicles,
 * `furrow drive` does this itself (vehicles in a scene).
 */
#include <furrow.h>
#include <mujoco/mujoco.h>

#include <stdio.h>
#include <stdlib.h>

#define RADIUS 0.2 /* m, as in the model */
#define SECONDS 3.0
#define TOLD_EVERY 0.25

static const char scene[] =
	"spacing: 0.03125\n"
	"soil: {name: dry_sand, damping: 3e5}\n"
	"redistribute: {model: scm}\n"
	"objects: [{name: ball, shape: {sphere: {radius: 0.2}}}]\n";

/* Says why a call of Furrow failed, and ends the program. */
static void must(furrow_status status)
{
	if (status == FURROW_OK)
		return;
	fprintf(stderr, "mujoco_ball: %s\n", furrow_last_error());
	exit((int)status);
}

/* Reads where the body is from MuJoCo. Furrow's angular velocity is in local axes; that of a free joint is in the body's own. */
static struct furrow_state state_of(const mjModel *model, const mjData *data, int body)
{
	struct furrow_state state;
	mjtNum velocity[6];
	mju_copy3(state.pose.position, data->xpos + 3 * body);
	mju_copy4(state.pose.orientation, data->xquat + 4 * body);
	mj_objectVelocity(model, data, mjOBJ_BODY, body, velocity, 0); /* turning first, then moving, in local axes */
	mju_copy3(state.angular, velocity);
	mju_copy3(state.linear, velocity + 3);
	return state;
}

/*
 * Applies the soil's force and moment. Soil is stiff, so its force up is that at the end of the step, from what it would be there:
 * the same as an implicit step, in one direction.
 */
static void apply(const mjModel *model, mjData *data, int body, const struct furrow_contact *contact, double speed)
{
	const double step = model->opt.timestep, mass = model->body_mass[body], gravity = model->opt.gravity[2];
	const double stiff = contact->stiffness[2][2], damped = contact->damping[2][2];
	mjtNum *applied = data->xfrc_applied + 6 * body;
	mju_copy3(applied, contact->force);
	mju_copy3(applied + 3, contact->moment);
	const double push = contact->force[2] + mass * gravity + stiff * step * speed;
	applied[2] = mass * (push / (mass - damped * step - stiff * step * step) - gravity);
}

int main(int argc, char **argv)
{
	char error[300] = "";
	if (argc != 4) {
		fprintf(stderr, "usage: mujoco_ball MODEL STORE OVERLAY\n");
		return FURROW_USAGE;
	}
	mjModel *model = mj_loadXML(argv[1], NULL, error, sizeof error);
	if (model == NULL) {
		fprintf(stderr, "mujoco_ball: %s\n", error);
		return FURROW_INPUT;
	}
	mjData *data = mj_makeData(model);
	const int body = mj_name2id(model, mjOBJ_BODY, "ball");
	struct furrow_open open = {.size = sizeof open, .scene = scene, .store = argv[2], .overlay = argv[3]};
	struct furrow_world *world;
	furrow_body ball;
	struct furrow_point ground;
	must(furrow_world_open(&open, &world));
	must(furrow_body_find(world, "ball", &ball));
	must(furrow_points(world, 1, (const double[]){30, 30}, &ground));

	/* A free joint: x, y, z and a quaternion; velocities after that. */
	data->qpos[0] = data->qpos[1] = 30;
	data->qpos[2] = ground.height + RADIUS + 0.2;
	data->qvel[0] = 1;
	mj_forward(model, data);
	struct furrow_state state = state_of(model, data, body);
	must(furrow_place(world, ball, &state.pose));

	printf("time_s,x_m,above_ground_m,velocity_x_m_s,force_N\n");
	for (int told = 0; data->time < SECONDS;) {
		struct furrow_contact contact;
		mj_step1(model, data); /* positions and velocities */
		state = state_of(model, data, body);
		must(furrow_probe(world, 1, &ball, &state, &contact, sizeof contact));
		apply(model, data, body, &contact, state.linear[2]);
		if (data->time >= told * TOLD_EVERY) {
			told++;
			must(furrow_points(world, 1, (const double[]){state.pose.position[0], state.pose.position[1]}, &ground));
			printf("%.2f,%.3f,%.4f,%.3f,%.1f\n", data->time, state.pose.position[0],
			       state.pose.position[2] - RADIUS - (ground.height - ground.offset), state.linear[0], contact.force[2]);
		}
		mj_step2(model, data); /* forces, and the step */
		state = state_of(model, data, body);
		must(furrow_set_states(world, 1, &ball, &state));
		must(furrow_step(world, model->opt.timestep));
	}
	must(furrow_world_close(world));
	mj_deleteData(data);
	mj_deleteModel(model);
	return 0;
}
