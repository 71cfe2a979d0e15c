/* One step of the powertrain: all its torques, solved together for the step's end. */
#include <math.h>

#include "vehicle/linear.h"
#include "vehicle/powertrain.h"

#define RPM (M_PI / 30)    /* rad/s */
#define GOVERNOR 10.0      /* throttle by the share of idle that the engine is slower */
#define CUT 0.02           /* of the last speed of the engine: over so much its fuel is cut */
#define GIVES 1e-9         /* of a row's own mobility, added to it: so the matrix is positive where two rows say the same, and these share their torque */
#define BACK 0.2           /* of the angle that a held wheel has turned, in a step */
#define TANGENTS 4         /* times that the engine's torque is made linear anew */
#define TANGENT 1e-3       /* of its speed */
#define NEAR 1e-6          /* of its torque: so well must the line fit */

/* --- the engine --- */

static double full_torque(const struct scene_powertrain *scene, double rpm)
{
	const double(*map)[2] = (const double(*)[2])scene->engine;
	size_t i = 1;
	if (rpm <= map[0][0])
		return map[0][1];
	while (i + 1 < scene->engine_count && map[i][0] < rpm)
		i++;
	const double share = fmin((rpm - map[i - 1][0]) / (map[i][0] - map[i - 1][0]), 1);
	return map[i - 1][1] + share * (map[i][1] - map[i - 1][1]);
}

double vehicle_engine_torque(const struct scene_powertrain *scene, double speed, double throttle)
{
	const double rpm = speed / RPM, most = scene->engine[scene->engine_count - 1][0], full = full_torque(scene, rpm), idles = full_torque(scene, scene->idle);
	const double needs = idles + scene->drag > 0 ? scene->drag / (idles + scene->drag) : 0;
	const double governed = fmin(fmax(needs + GOVERNOR * (scene->idle - rpm) / scene->idle, 0), 1);
	const double fuel = fmin(fmax(1 - (rpm - most) / (CUT * most), 0), 1), opened = fmax(fmin(fmax(throttle, 0), 1), governed) * fuel;
	return opened * full - (1 - opened) * scene->drag;
}

/* --- the gearbox --- */

static double ratio_of(const struct scene_powertrain *scene, double gear)
{
	return scene->final * (gear < 0 ? -scene->reverse : gear > 0 ? scene->gears[(size_t)gear - 1] : 0);
}

/* Chooses the gear by the lever, and by the speed of the gearbox's input, rad/s in a gear of ratio 1. */
static void shift(struct powertrain *train, double shaft, double h)
{
	const struct scene_powertrain *scene = train->scene;
	const double asked = train->controls[POWERTRAIN_GEAR], most = (double)scene->gear_count;
	const double lever = fmin(fmax(floor(asked + 0.5), -1), most);
	double gear = lever;
	train->shifting = fmax(train->shifting - h, 0);
	if (train->shifting > 0)
		return;
	if (lever > 0 && scene->shifts) {
		const double rpm = ratio_of(scene, train->gear) * shaft / RPM;
		gear = train->gear < 1 ? 1 : train->gear + (rpm > scene->up) - (rpm < scene->down);
		gear = fmin(fmax(gear, 1), lever);
	}
	if (gear == train->gear)
		return;
	train->gear = gear;
	train->shifting = scene->shift_time;
}

/* --- rows --- */

struct system {
	struct vehicle *vehicle;
	struct powertrain *train;
	double h, ratio;
	double *mobility;       /* wheels x wheels: 1/(kg m2) */
	double *free;           /* wheels: rad/s at the end without torques */
	double *q, *c, *limits, *x, *gives, *room;
	double *way;            /* rows x wheels, of the rows that are in it */
	size_t *rows;           /* their numbers */
	double *pull;           /* of each: change of its speed by that of the engine */
	size_t count;
	double inertia, alone;  /* of the engine, with what its torque gives; its speed at the end without the clutch */
};

/* Fills the lower triangle of the vehicle's part of M + h D: of its own freedoms, count x count. */
static void fill_inertia(const struct vehicle *vehicle, double h, double *inertia)
{
	const mjModel *model = vehicle->model;
	const int first = vehicle->own.dof.first, end = vehicle->own.dof.end, count = end - first;
	mju_zero(inertia, count * count);
	for (int row = first; row < end; row++) {
		for (int k = 0; k < model->M_rownnz[row]; k++) {
			const int at = (int)model->M_rowadr[row] + k, column = model->M_colind[at];
			inertia[(row - first) * count + column - first] = vehicle->data->M[at];
		}
		inertia[(row - first) * (count + 1)] += h * vehicle_damping_of(vehicle, row);
	}
}

/* The mobility of the wheels among each other, and their speeds at the step's end without powertrain and brakes. qfrc_smooth has all other forces. */
static bool find_response(struct system *system)
{
	const struct vehicle *vehicle = system->vehicle;
	const struct powertrain *train = system->train;
	const int first = vehicle->own.dof.first;
	const size_t nv = range_count(vehicle->own.dof), n = train->wheel_count;
	double *inertia = system->room, *velocity = inertia + nv * nv, *column = velocity + nv;
	fill_inertia(vehicle, system->h, inertia);
	if (!vehicle_factor(inertia, nv))
		return false;
	mju_copy(velocity, vehicle->data->qfrc_smooth + first, (int)nv);
	vehicle_solve_factored(inertia, velocity, nv);
	for (size_t i = 0; i < n; i++) {
		mju_zero(column, (int)nv);
		column[train->wheels[i].dof - first] = 1;
		vehicle_solve_factored(inertia, column, nv);
		for (size_t k = 0; k < n; k++)
			system->mobility[i * n + k] = column[train->wheels[k].dof - first];
		system->free[i] = vehicle->data->qvel[train->wheels[i].dof] + system->h * velocity[train->wheels[i].dof - first];
	}
	return true;
}

static double angle_of(const struct vehicle *vehicle, const struct powertrain_wheel *wheel)
{
	return vehicle->data->qpos[vehicle->model->jnt_qposadr[vehicle->model->dof_jntid[wheel->dof]]];
}

/* Turns of the gearbox's output, rad/s, by speeds of the dofs. */
static double shaft_of(const struct powertrain *train, const double *speeds)
{
	double shaft = 0;
	for (size_t k = 0; k < train->wheel_count; k++)
		shaft += train->wheels[k].share * train->wheels[k].side * speeds[train->wheels[k].dof];
	return shaft;
}

/* What the clutch transmits at most: it holds more and more from idle on. */
static double clutch_limit(const struct powertrain *train)
{
	const struct scene_powertrain *scene = train->scene;
	return scene->clutch * fmin(fmax((train->before / RPM - scene->idle) / (scene->engage - scene->idle), 0), 1);
}

/* The converter as a damper between pump and turbine, N m s. *boost: what its turbine has more than its pump takes, N m. */
static double converter(const struct scene_powertrain *scene, double pump, double turbine, double *boost)
{
	const double fast = fmax(fabs(turbine), pump), ratio = pump > 0 ? turbine / pump : turbine > 0 ? INFINITY : 0;
	const double couples = fast * scene->capacity / (1 - scene->coupling);
	*boost = 0;
	if (ratio >= 1)
		return couples;
	const double damper = fmin(scene->capacity * pump / (1 - ratio), couples), back = fmax(ratio, 0);
	if (back < scene->coupling)
		*boost = (scene->stall_ratio - 1) * (1 - back / scene->coupling) * damper * (pump - turbine);
	return damper;
}

/* Adds a row to the system, if it may give any torque. */
static void add_row(struct system *system, size_t row, double limit, double gives, double target)
{
	const struct powertrain *train = system->train;
	const size_t n = train->wheel_count, at = system->count;
	const bool input = train->rows[row].kind == POWERTRAIN_INPUT;
	double *way = system->way + at * n;
	if (!(limit > 0))
		return;
	mju_scl(way, train->ways + row * n, input ? system->ratio : 1, (int)n);
	system->c[at] = mju_dot(way, system->free, (int)n) - target;
	system->pull[at] = input ? -1 : 0;
	system->limits[at] = limit;
	system->gives[at] = gives;
	system->rows[at] = row;
	system->count++;
}

static double limit_of(const struct powertrain *train, const struct powertrain_row *row)
{
	const double bias = train->scene->bias;
	if (row->differential == SCENE_LOCKED)
		return INFINITY;
	return train->scene->lock + fabs(train->input * ratio_of(train->scene, train->shifting > 0 ? 0 : train->gear)) * row->share * (bias - 1) / (bias + 1);
}

static void add_rows(struct system *system, double shaft)
{
	struct powertrain *train = system->train;
	const bool in = train->scene != NULL && train->gear != 0 && train->shifting == 0;
	for (size_t r = 0; r < train->row_count; r++) {
		const struct powertrain_row *row = &train->rows[r];
		if (row->kind == POWERTRAIN_HOLDS) {
			const struct powertrain_wheel *wheel = &train->wheels[row->wheel];
			const double turned = isnan(wheel->held) ? 0 : angle_of(system->vehicle, wheel) - wheel->held;
			add_row(system, r, train->brakes * fmin(fmax(train->controls[POWERTRAIN_BRAKE], 0), 1), 0, -BACK * turned / system->h);
		} else if (row->kind != POWERTRAIN_INPUT) {
			add_row(system, r, limit_of(train, row), 0, 0);
		} else if (in && train->scene->clutch > 0) {
			add_row(system, r, clutch_limit(train), 0, 0);
		} else if (in) {
			const double damper = converter(train->scene, train->before, system->ratio * shaft, &train->boost);
			for (size_t k = 0; k < train->wheel_count; k++) /* the boost is known at the step's start */
				for (size_t i = 0; i < train->wheel_count; i++)
					system->free[i] += system->h * system->mobility[i * train->wheel_count + k] * system->ratio * train->ways[r * train->wheel_count + k] * train->boost;
			add_row(system, r, damper > 0 ? INFINITY : 0, damper > 0 ? 1 / damper : 0, 0);
		}
	}
}

/* Fills q and solves for the torques. The engine's speed at the end is `alone` less what the input row takes. */
static void solve(struct system *system, double *c)
{
	const size_t n = system->train->wheel_count, count = system->count;
	for (size_t i = 0; i < count; i++) {
		for (size_t k = 0; k < count; k++) {
			double sum = system->pull[i] * system->pull[k] / system->inertia;
			for (size_t a = 0; a < n; a++)
				sum += system->way[i * n + a] * mju_dot(system->mobility + a * n, system->way + k * n, (int)n);
			system->q[i * count + k] = system->h * sum;
		}
		system->q[i * count + i] += system->gives[i] + GIVES * system->q[i * count + i];
		c[i] = system->c[i] + system->pull[i] * system->alone;
	}
	vehicle_solve_bounded(system->q, c, system->limits, count, system->x, c + count, system->train->bound);
}

/* Solves with the engine's torque as a line at its speed, and again where the line does not fit at the speed that comes out. */
static void solve_engine(struct system *system, double *c)
{
	struct powertrain *train = system->train;
	if (train->scene == NULL) {
		solve(system, c);
		return;
	}
	const double throttle = train->shifting > 0 ? 0 : train->controls[POWERTRAIN_THROTTLE], now = train->before;
	const double torque = vehicle_engine_torque(train->scene, now, throttle), beside = now * TANGENT + TANGENT;
	double slope = fmin((vehicle_engine_torque(train->scene, now + beside, throttle) - torque) / beside, 0), ends = now;
	for (int turn = 0; turn < TANGENTS; turn++) {
		double taken = 0;
		system->inertia = train->scene->inertia - system->h * slope;
		system->alone = now + system->h * torque / system->inertia;
		solve(system, c);
		for (size_t i = 0; i < system->count; i++)
			taken -= system->pull[i] * system->x[i];
		ends = fmax(system->alone - system->h * taken / system->inertia, 0);
		train->slipping = taken;
		train->torque = torque + slope * (ends - now);
		const double really = vehicle_engine_torque(train->scene, ends, throttle), secant = ends != now ? (really - torque) / (ends - now) : slope;
		if (fabs(really - train->torque) <= NEAR * (fabs(torque) + fabs(really)) || !(secant < 0))
			break;
		slope = secant;
	}
	train->speed = ends;
}

/* Gives the torques to MuJoCo: those of the engine by its actuators, those of brakes as applied ones. */
static void apply(struct system *system)
{
	struct powertrain *train = system->train;
	const size_t n = train->wheel_count;
	mjData *data = system->vehicle->data;
	double input = train->boost;
	for (size_t k = 0; k < n; k++) {
		struct powertrain_wheel *wheel = &train->wheels[k];
		wheel->drive = wheel->brake = 0;
		wheel->holds = false;
		if (train->boost != 0)
			wheel->drive = system->ratio * wheel->share * wheel->side * train->boost;
	}
	for (size_t i = 0; i < system->count; i++) {
		const struct powertrain_row *row = &train->rows[system->rows[i]];
		if (row->kind == POWERTRAIN_INPUT)
			input += system->x[i];
		for (size_t k = 0; k < n; k++)
			*(row->kind == POWERTRAIN_HOLDS ? &train->wheels[k].brake : &train->wheels[k].drive) += system->way[i * n + k] * system->x[i];
		if (row->kind == POWERTRAIN_HOLDS)
			train->wheels[row->wheel].holds = fabs(system->x[i]) < system->limits[i];
	}
	for (struct powertrain_wheel *wheel = train->wheels; wheel < train->wheels + n; wheel++) {
		if (wheel->motor >= 0)
			*vehicle_ctrl(system->vehicle, wheel->motor) = wheel->drive;
		data->qfrc_applied[wheel->dof] += wheel->brake;
	}
	train->now = input;
}

static void train_step(struct vehicle *vehicle, double h, bool begins)
{
	struct powertrain *train = vehicle->train;
	const size_t n = train->wheel_count, m = train->row_count;
	struct system system = {.vehicle = vehicle, .train = train, .h = h, .rows = train->listed, .inertia = 1, .mobility = train->room};
	system.free = system.mobility + n * n;
	system.way = system.free + n;
	system.q = system.way + m * n;
	system.c = system.q + m * m;
	system.limits = system.c + m;
	system.gives = system.limits + m;
	system.pull = system.gives + m;
	system.x = system.pull + m;
	double *c = system.x + m;
	system.room = c + m * (m + 4);
	const double shaft = shaft_of(train, vehicle->data->qvel);
	train->boost = 0;
	if (begins)
		train->before = train->speed;
	if (begins && train->scene != NULL)
		shift(train, shaft, h);
	system.ratio = train->scene != NULL ? ratio_of(train->scene, train->gear) : 0;
	if (!find_response(&system))
		system.free[0] = (double)NAN; /* told as a motion that diverges */
	for (size_t k = 0; k < n && train->controls[POWERTRAIN_BRAKE] <= 0; k++)
		train->wheels[k].held = (double)NAN;
	add_rows(&system, shaft);
	solve_engine(&system, c);
	apply(&system);
}

void vehicle_trains_solve(struct vehicles *vehicles, double h, bool begins)
{
	mjData *data = vehicles->data;
	bool any = false;
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		for (size_t i = 0; vehicle->train != NULL && i < vehicle->train->wheel_count; i++)
			if (vehicle->train->wheels[i].motor >= 0)
				*vehicle_ctrl(vehicle, vehicle->train->wheels[i].motor) = 0;
		any = any || vehicle->train != NULL;
	}
	if (!any)
		return;
	mj_fwdActuation(vehicles->model, data);
	mj_fwdAcceleration(vehicles->model, data);
	for (size_t v = 0; v < vehicles->all; v++)
		if (vehicles->list[v].train != NULL)
			train_step(&vehicles->list[v], h, begins);
}

void vehicle_train_sum(struct vehicle *vehicle, double h, const double *before)
{
	struct powertrain *train = vehicle->train;
	const double *after = vehicle->data->qvel;
	double driven = 0, braked = 0;
	if (train == NULL)
		return;
	train->input = train->now;
	for (struct powertrain_wheel *wheel = train->wheels; wheel < train->wheels + train->wheel_count; wheel++) {
		const double speed = (before[wheel->dof] + after[wheel->dof]) / 2;
		driven += wheel->drive * speed;
		braked -= wheel->brake * speed;
		/* At the step's start it stood as the brake found it. */
		wheel->held = !wheel->holds ? (double)NAN : isnan(wheel->held) ? angle_of(vehicle, wheel) - after[wheel->dof] * h : wheel->held;
	}
	train->brake_work += braked * h;
	if (train->scene == NULL)
		return;
	const double mean = (train->before + train->speed) / 2;
	train->engine_work += train->torque * mean * h;
	train->loss += (train->slipping * mean - driven) * h;
}
