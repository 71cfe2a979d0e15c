/*
 * The engine plugin furrow.soil: deformable ground for any program that uses MuJoCo. docs/MUJOCO.md tells how it is used.
 *
 * MuJoCo calls in this order:
 *
 *     init -> reset -> (compute [4 times with RK4] -> advance) ...        destroy
 *
 * `compute` comes in mj_passive, between the inertia and the accelerations. There the inertia in data->M gets how the soil answers a change of the velocities
 * (src/vehicle/coupling.c), and qfrc_passive gets its forces. So MuJoCo's own step is implicit in the soil's forces, whatever its integrator is. RK4 takes the same
 * law, linear about the step's end, at its four states: that is stable for any stiffness, and of first order in the soil's forces.
 *
 * What the soil does is limited: it does not pull. Whether a contact is beyond its limit is known when the velocities at the step's end are. So `compute` lets
 * MuJoCo make the rest of a step first, up to the accelerations; what that writes the step itself writes again.
 *
 * Invariants: (1) The ground changes where a step has ended, at the next `compute` before it is asked, since there the places of geoms are known. (2) After
 * `advance` the inertia is MuJoCo's own again.
 */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"
#include "plugin.h"

#define LIMITED_MOST 3 /* times that a step is tried whose contacts reach their limits */
#define STAGE 1e-9     /* of a timestep: rounding of RK4's times */
#define LONG_STEP 0.005 /* s: with a longer step legs that strike the ground may be thrown */

void plugin_fail(const char *format, ...)
{
	char text[900];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	mju_error("furrow.soil: %s", text);
}

void plugin_must(furrow_status status)
{
	if (status != FURROW_OK)
		plugin_fail("%s", furrow_last_error());
}

static int no_state(const mjModel *model, int instance)
{
	(void)model, (void)instance;
	return 0;
}

static struct plugin_soil *soil_of(const mjData *data, int instance)
{
	return (struct plugin_soil *)data->plugin_data[instance];
}

/* --- a mjData's life --- */

static const char *config(const mjModel *model, int instance, const char *key)
{
	const char *value = mj_getPluginConfig(model, instance, key);
	return value != NULL && value[0] != '\0' ? value : NULL;
}

/* Reads `origin`, "x y" or "x y z". */
static bool read_origin(const mjModel *model, int instance, double origin[3])
{
	const char *text = config(model, instance, "origin");
	int end = 0;
	memset(origin, 0, 3 * sizeof *origin);
	if (text == NULL)
		return true;
	const int count = sscanf(text, "%lf %lf %n%lf %n", &origin[0], &origin[1], &end, &origin[2], &end);
	return count >= 2 && text[end] == '\0' && isfinite(origin[0]) && isfinite(origin[1]) && isfinite(origin[2]);
}

/* The places of the model's first pose, in which the geoms are looked at. A reset follows. */
static void pose(const mjModel *model, mjData *data)
{
	for (int i = 0; i < model->nq; i++)
		data->qpos[i] = model->qpos0[i];
	memset(data->qvel, 0, (size_t)model->nv * sizeof *data->qvel);
	mj_kinematics(model, data);
	mj_comPos(model, data);
	mj_makeM(model, data);
	mj_factorM(model, data);
}

static furrow_status open_world(const mjModel *model, int instance, struct plugin_soil *soil)
{
	const char *scene = config(model, instance, "scene");
	const bool text = scene != NULL && strchr(scene, '{') != NULL; /* as in Python: the scene itself */
	const struct furrow_open open = {
		.size = sizeof open,
		.scene = text ? scene : NULL,
		.scene_file = text ? NULL : scene,
		.store = config(model, instance, "store"),
		.overlay = soil->overlay, /* without one the world would write the store */
	};
	return furrow_world_open(&open, &soil->world);
}

static furrow_status open_soil(const mjModel *model, const mjData *data, int instance, const double origin[3], struct plugin_soil *soil)
{
	const char *name = mj_id2name(model, mjOBJ_PLUGIN, instance);
	struct furrow_mujoco_open open = {.size = sizeof open, .world = soil->world, .name = name != NULL ? name : "soil", .model = model, .data = data,
					  .geoms = config(model, instance, "geoms"), .carry = config(model, instance, "carry"), .tyres = config(model, instance, "tyres")};
	memcpy(open.origin, origin, sizeof open.origin);
	const furrow_status status = furrow_mujoco_open(&open, &soil->soil);
	if (status != FURROW_OK)
		return status;
	soil->count = (int)furrow_mujoco_count(soil->soil);
	soil->geoms = calloc((size_t)soil->count + 1, sizeof *soil->geoms);
	for (int i = 0; i < soil->count && soil->geoms != NULL; i++)
		furrow_mujoco_geom(soil->soil, (size_t)i, &soil->geoms[i], NULL, NULL, 0);
	return FURROW_OK;
}

/* Soil aboard is in no overlay: it is gone with the data. */
static void tell_aboard(const struct plugin_soil *soil)
{
	double volume = 0;
	for (int i = 0; i < soil->count && soil->folder == NULL; i++) {
		struct furrow_contact contact = {.carried = 0};
		if (furrow_mujoco_geom(soil->soil, (size_t)i, NULL, NULL, &contact, sizeof contact) == FURROW_OK && contact.carried > 0)
			volume += contact.carried;
	}
	if (volume > 0)
		mju_warning("furrow.soil: %.3g l of soil lie on geoms that carry, and go with the data: %s keeps the hole that they left, and not them; lay them down before",
			    1e3 * volume, soil->overlay);
}

static void free_soil(struct plugin_soil *soil)
{
	if (soil == NULL)
		return;
	tell_aboard(soil);
	plugin_free_field(soil->field);
	plugin_free_field(soil->skin);
	if (furrow_world_close(soil->world) != FURROW_OK)
		mju_warning("furrow.soil: %s", furrow_last_error());
	furrow_mujoco_close(soil->soil); /* last: else the ground would spring back below its bodies, and an overlay that is kept would have that */
	plugin_give_overlay(soil);
	free(soil->geoms);
	free(soil->forces);
	free(soil->passive);
	free(soil->end);
	free(soil->damping);
	free(soil->mass);
	free(soil);
}

/* Warns once of a model, although each mjData of it is made in the same way. `told`: the model of the last warning. */
static void warn_once(const mjModel *model, uint64_t *told, const char *text)
{
	if (*told != model->signature)
		mju_warning("furrow.soil: %s", text);
	*told = model->signature;
}

/* Tells what gives a motion that nobody means. */
static void doubt(const mjModel *model, const struct plugin_soil *soil)
{
	static uint64_t gravity_told, floor_told, step_told; /* two threads may tell both: no harm */
	struct furrow_info info = {.size = sizeof info};
	char text[400];
	if (furrow_info(soil->world, &info) == FURROW_OK && fabs(-model->opt.gravity[2] - info.gravity) > 0.01 * info.gravity) {
		snprintf(text, sizeof text, "the model's gravity is %.4g m/s2, and the scene's is %.4g: give both the same", -model->opt.gravity[2], info.gravity);
		warn_once(model, &gravity_told, text);
	}
	if (model->opt.timestep > LONG_STEP) {
		snprintf(text, sizeof text, "the model's timestep is %.3g s, and what strikes the ground may be thrown with one above %g s; give a shorter one", model->opt.timestep, LONG_STEP);
		warn_once(model, &step_told, text);
	}
	for (int i = 0; i < model->ngeom; i++)
		if (model->geom_type[i] == mjGEOM_PLANE && (model->geom_contype[i] != 0 || model->geom_conaffinity[i] != 0)) {
			const char *name = mj_id2name(model, mjOBJ_GEOM, i);
			snprintf(text, sizeof text, "bodies also stand on the model's own plane %.100s, where that is higher than the ground; give it contype=\"0\" conaffinity=\"0\", or take it out",
				 name != NULL ? name : "without a name");
			warn_once(model, &floor_told, text);
		}
}

/* More than one would each take the inertia as the other has left it. */
static bool is_alone(const mjModel *model, int instance)
{
	for (int i = 0; i < model->nplugin; i++)
		if (i != instance && model->plugin[i] == model->plugin[instance])
			return false;
	return true;
}

/* Returns what is wrong; NULL: nothing. */
static const char *make_soil(const mjModel *model, mjData *data, int instance, struct plugin_soil *soil)
{
	double origin[3];
	const size_t nv = (size_t)model->nv;
	if (config(model, instance, "scene") == NULL)
		return "its key scene is missing; give the path of a scene, or its text in braces";
	if (!is_alone(model, instance))
		return "the model has several instances of it; give one, which names all geoms";
	if (config(model, instance, "powertrain") != NULL || config(model, instance, "brakes") != NULL)
		return "it has no powertrain and no brakes, since the model's actuators turn its joints; give the model actuators that do, or let furrow drive it as a vehicle of a scene, "
		       "which has both";
	if (!read_origin(model, instance, origin))
		return "its key origin is no place; give where MuJoCo's origin is in the terrain, m: x y, or x y z";
	soil->forces = calloc(nv + 1, sizeof *soil->forces);
	soil->passive = calloc(nv + 1, sizeof *soil->passive);
	soil->end = calloc(nv + 1, sizeof *soil->end);
	soil->damping = calloc(nv + 1, sizeof *soil->damping);
	soil->mass = calloc((size_t)model->nC + 1, sizeof *soil->mass);
	if (soil->forces == NULL || soil->passive == NULL || soil->end == NULL || soil->damping == NULL || soil->mass == NULL)
		return "no memory";
	if (!plugin_take_overlay(soil, config(model, instance, "overlay")))
		return "no folder for its ruts can be made in TMPDIR, or without TMPDIR in /tmp; set TMPDIR to a folder that can be written, or give its key overlay";
	if (open_world(model, instance, soil) != FURROW_OK)
		return furrow_last_error();
	pose(model, data);
	if (open_soil(model, data, instance, origin, soil) != FURROW_OK)
		return furrow_last_error();
	if (soil->geoms == NULL)
		return "no memory";
	doubt(model, soil);
	const char *wrong = plugin_check_sensors(model, instance, soil);
	return wrong != NULL ? wrong : plugin_make_fields(model, instance, soil, origin);
}

static int init(const mjModel *model, mjData *data, int instance)
{
	struct plugin_soil *soil = calloc(1, sizeof *soil);
	const char *wrong = soil != NULL ? make_soil(model, data, instance, soil) : "no memory";
	data->plugin_data[instance] = 0;
	if (wrong != NULL) {
		char text[900];
		snprintf(text, sizeof text, "%s", wrong);
		free_soil(soil);
		mju_error("furrow.soil: %s", text); /* MuJoCo's own error for a plugin that fails names no reason */
		return -1;
	}
	soil->fresh = true;
	data->plugin_data[instance] = (uintptr_t)soil;
	return 0;
}

static void destroy(mjData *data, int instance)
{
	free_soil(soil_of(data, instance));
	data->plugin_data[instance] = 0;
}

static void reset_soil(struct plugin_soil *soil)
{
	if (soil->used)
		plugin_must(furrow_mujoco_reset(soil->soil));
	soil->used = soil->moved = soil->foreign = soil->computed = false;
	soil->fresh = true;
}

static void reset(const mjModel *model, mjtNum *state, void *plugin_data, int instance)
{
	(void)state, (void)instance;
	struct plugin_soil *soil = plugin_data;
	if (soil == NULL)
		return;
	const bool moved = soil->moved;
	reset_soil(soil);
	if (moved)
		plugin_follow(model, soil, true);
}

/* The ground is not copied. Where it is that of the start in both, nothing is missing. */
static void copy(mjData *to, const mjModel *model, const mjData *from, int instance)
{
	struct plugin_soil *soil = soil_of(to, instance);
	const struct plugin_soil *source = soil_of(from, instance);
	if (soil == NULL || source == NULL)
		return;
	reset_soil(soil);
	plugin_follow(model, soil, true);
	soil->foreign = source->moved || source->foreign;
}

/* --- steps --- */

/* How a damper's force answers the rate: its terms are the rate to the powers 1, 2, 3. */
static double damper(double linear, const mjtNum *more, double rate)
{
	double damping = linear;
	for (int i = 0; i < mjNPOLY; i++)
		damping += (i + 2) * more[i] * pow(fabs(rate), i + 1);
	return damping;
}

/* How the force of a motor on its joint answers the joint's rate, in the two integrators that know it. One at its limit does not answer. */
static double motor(const mjModel *model, const mjData *data, int i)
{
	const int out = model->actuator_outadr[i], control = model->actuator_ctrladr[i], act = model->actuator_actadr[i] + model->actuator_actnum[i] - 1;
	const mjtNum *range = model->actuator_forcerange + 2 * i, *most = model->actuator_ctrlrange + 2 * control;
	double damping = 0, input = 0;
	if ((model->opt.disableflags & mjDSBL_ACTUATION) != 0 ||
	    (model->actuator_forcelimited[i] && (data->actuator_force[out] <= range[0] || data->actuator_force[out] >= range[1])))
		return 0;
	if (model->actuator_biastype[i] == mjBIAS_AFFINE)
		damping -= model->actuator_biasprm[i * mjNBIAS + 2];
	if (model->actuator_gaintype[i] == mjGAIN_AFFINE && model->actuator_gainprm[i * mjNGAIN + 2] != 0) {
		input = model->actuator_actnum[i] > 0 ? data->act[act] : data->ctrl[control];
		if (model->actuator_actnum[i] == 0 && model->actuator_ctrllimited[control])
			input = fmin(fmax(input, most[0]), most[1]);
		damping -= input * model->actuator_gainprm[i * mjNGAIN + 2];
	}
	return damping;
}

/* Fills the damping of each freedom that the integrator takes at the step's end: of its joint, and of its motors. Returns false if there is none. */
static bool find_damping(const mjModel *model, const mjData *data, double *damping)
{
	const bool euler = model->opt.integrator == mjINT_EULER, dampers = (model->opt.disableflags & mjDSBL_DAMPER) == 0;
	bool any = false;
	if (model->opt.integrator == mjINT_RK4 || (euler && (model->opt.disableflags & mjDSBL_EULERDAMP) != 0))
		return false;
	for (int i = 0; i < model->nv; i++)
		damping[i] = dampers ? damper(model->dof_damping[i], model->dof_dampingpoly + mjNPOLY * i, data->qvel[i]) : 0;
	for (int i = 0; i < model->nactuator; i++) {
		const int joint = model->actuator_trnid[2 * i];
		if (model->actuator_trntype[i] != mjTRN_JOINT || (model->jnt_type[joint] != mjJNT_HINGE && model->jnt_type[joint] != mjJNT_SLIDE))
			continue;
		const int dof = model->jnt_dofadr[joint];
		const double gear = model->actuator_gear[6 * model->actuator_outadr[i]];
		const double own = dampers ? damper(model->actuator_damping[i], model->actuator_dampingpoly + mjNPOLY * i, gear * data->qvel[dof]) : 0;
		damping[dof] += gear * gear * (own + (euler ? 0 : motor(model, data, i)));
	}
	for (int i = 0; i < model->nv; i++)
		any = any || damping[i] != 0;
	return any;
}

/* Finds the velocities at the step's end, as the integrator would, with the soil's forces as they are now. */
static void find_end(const mjModel *model, mjData *data, struct plugin_soil *soil)
{
	const double h = model->opt.timestep;
	const int nv = (int)model->nv;
	for (int i = 0; i < nv; i++)
		data->qfrc_passive[i] = soil->passive[i] + soil->forces[i];
	mj_fwdAcceleration(model, data);
	mj_fwdConstraint(model, data);
	const double *rate = data->qacc;
	if (find_damping(model, data, soil->damping)) {
		memcpy(soil->mass, data->M, (size_t)model->nC * sizeof *data->M);
		for (int i = 0; i < nv; i++) {
			data->M[model->M_rowadr[i] + model->M_rownnz[i] - 1] += h * soil->damping[i];
			soil->end[i] = data->qfrc_smooth[i] + data->qfrc_constraint[i];
		}
		mj_factorM(model, data);
		mj_solveM(model, data, soil->end, soil->end, 1);
		memcpy(data->M, soil->mass, (size_t)model->nC * sizeof *data->M);
		mj_factorM(model, data);
		rate = soil->end;
	}
	for (int i = 0; i < nv; i++)
		soil->end[i] = data->qvel[i] + h * rate[i];
}

static void project(const mjModel *model, mjData *data)
{
	if (data->nefc > 0 && (model->opt.solver == mjSOL_PGS || model->opt.noslip_iterations > 0))
		mj_projectConstraint(model, data);
}

static void push(const mjModel *model, mjData *data, struct plugin_soil *soil)
{
	const size_t bytes = (size_t)model->nv * sizeof *data->qvel;
	memcpy(soil->passive, data->qfrc_passive, bytes);
	mj_referenceConstraint(model, data);
	mj_rne(model, data, 0, data->qfrc_bias);
	mj_fwdActuation(model, data);
	project(model, data);
	bool again = true;
	for (int turn = 0; again && turn < LIMITED_MOST; turn++) {
		find_end(model, data, soil);
		plugin_must(furrow_mujoco_limit(soil->soil, soil->end, &again, soil->forces));
		if (again)
			project(model, data);
	}
	for (int i = 0; i < model->nv; i++)
		data->qfrc_passive[i] = soil->passive[i] + soil->forces[i];
}

/* A state of another time, as rollouts set it, has the ground of that time. Only that of the start is known. */
static void look_at_time(const mjModel *model, const mjData *data, struct plugin_soil *soil)
{
	if (!soil->moved) {
		soil->start = data->time;
		return;
	}
	const double expected = soil->fresh ? soil->until : soil->base; /* where the last step ended, or of what was computed since */
	if (fabs(data->time - expected) <= STAGE * model->opt.timestep + 4 * DBL_EPSILON * fabs(expected))
		return;
	if (data->time != soil->start)
		plugin_fail("the time went %s to %g s from %g s, and the ground of that time is not known; begin at %g s, or call mj_resetData",
			    data->time < expected ? "back" : "on", data->time, expected, soil->start);
	reset_soil(soil);
	plugin_follow(model, soil, true);
}

static void compute(const mjModel *model, mjData *data, int instance, int capability)
{
	struct plugin_soil *soil = soil_of(data, instance);
	const double h = model->opt.timestep;
	if (soil == NULL)
		return;
	if (capability == mjPLUGIN_SENSOR) {
		plugin_sense(model, data, instance, soil);
		return;
	}
	if (soil->foreign)
		plugin_fail("this mjData was copied from one whose ground has changed, and the ground is not copied with it; call mj_resetData on it");
	if ((model->opt.enableflags & mjENBL_SLEEP) != 0)
		plugin_fail("a body that sleeps does not feel what the ground does; leave the flag sleep out of the model's option");
	const bool stage = model->opt.integrator == mjINT_RK4 && !soil->fresh && data->time > soil->base && data->time <= soil->base + h * (1 + STAGE);
	if (!stage) {
		look_at_time(model, data, soil);
		plugin_must(furrow_mujoco_touch(soil->soil, data));
		plugin_follow(model, soil, false);
		soil->base = data->time;
	}
	soil->used = true;
	plugin_must(furrow_mujoco_begin(soil->soil, data, h, stage, soil->forces));
	soil->fresh = false;
	soil->computed = true;
	push(model, data, soil);
}

static void advance(const mjModel *model, mjData *data, int instance)
{
	struct plugin_soil *soil = soil_of(data, instance);
	if (soil == NULL)
		return;
	if (!soil->computed)
		plugin_fail("MuJoCo asked for no passive force in this step; leave disable=\"spring damper\" out of the model's flags");
	plugin_must(furrow_mujoco_end(soil->soil, data->qvel));
	mj_factorM(model, data);
	soil->until = soil->base + model->opt.timestep;
	soil->computed = false;
	soil->fresh = soil->moved = true;
}

static void registers(void)
{
	static const char *const keys[] = {"scene", "store", "overlay", "geoms", "origin", "reads", "hfield", "skin", "carry", "tyres", "powertrain", "brakes"};
	mjpPlugin plugin;
	mjp_defaultPlugin(&plugin);
	plugin.name = "furrow.soil";
	plugin.nattribute = sizeof keys / sizeof keys[0];
	plugin.attributes = keys;
	plugin.capabilityflags = mjPLUGIN_PASSIVE | mjPLUGIN_SENSOR;
	plugin.needstage = mjSTAGE_ACC;
	plugin.nstate = no_state;
	plugin.nsensordata = plugin_sensor_size;
	plugin.init = init;
	plugin.destroy = destroy;
	plugin.copy = copy;
	plugin.reset = reset;
	plugin.compute = compute;
	plugin.advance = advance;
	mjp_registerPlugin(&plugin);
}

mjPLUGIN_LIB_INIT(furrow)
{
	if (plugin_find_host())
		registers();
}
