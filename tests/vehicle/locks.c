/* Joints that nothing drives: those of arms and legs are locked, those of a suspension move, and the scene may say otherwise. */
#include <math.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/near.h"
#include "../support/program.h"

#define STEP "time_step: 0.002"
#define PATH ", driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, drive: [wheel_*]}"
#define LINK(name, mass, more) "<link name='" name "'><inertial><origin xyz='.2 0 0'/><mass value='" mass "'/><inertia ixx='.2' iyy='.2' izz='.2' ixy='0' ixz='0' iyz='0'/></inertial>" more "</link>"
#define BOX "<collision><geometry><box size='1 .6 .2'/></geometry></collision>"
#define ROLLER "<collision><origin rpy='1.5708 0 0'/><geometry><cylinder radius='.3' length='.2'/></geometry></collision>"
#define WHEEL(name, of, at) LINK(name, "5", ROLLER) "<joint name='wheel_" name "' type='continuous'><parent link='" of "'/><child link='" name "'/><origin xyz='" at "'/><axis xyz='0 1 0'/></joint>"
#define HINGE(name, of, limits) LINK(name, "2", "") "<joint name='" name "' type='revolute'><parent link='" of "'/><child link='" name "'/><axis xyz='0 1 0'/><limit " limits " effort='9' velocity='1'/></joint>"
#define CART "<robot name='r'>" LINK("base", "50", BOX) WHEEL("fl", "base", ".6 .5 -.2") WHEEL("fr", "base", ".6 -.5 -.2") WHEEL("rl", "base", "-.6 .5 -.2") WHEEL("rr", "base", "-.6 -.5 -.2")
#define ARM HINGE("arm", "base", "lower='.3' upper='2'")

static char told[8192];

static void take(const char *text)
{
	const size_t length = strlen(told);
	snprintf(told + length, sizeof told - length, "%s\n", text);
}

/* Loads a model, and checks that a note says a text. `joints`: of start; NULL: none. */
static struct vehicles *load(const char *text, const char *keys, const char *joints, const char *says, struct scene **scene)
{
	struct vehicles *vehicles = NULL;
	support_write(support_path("model.xml"), text);
	told[0] = '\0';
	note_to(take);
	must(rig_load(STEP, keys, scene, &vehicles));
	if (joints != NULL) {
		vehicle_destroy(vehicles);
		scene_destroy(*scene);
		must(scene_load(support_path("scene.yaml"), &(struct scene_setting){"vehicles.car.start.joints", joints}, 1, scene));
		must(vehicle_load(*scene, &vehicles));
	}
	note_to(NULL);
	if (says != NULL && strstr(told, says) == NULL)
		fail_msg("no note says \"%s\":\n%s", says, told);
	return vehicles;
}

static void unload(struct vehicles *vehicles, struct scene *scene)
{
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

static double *place_of(const struct vehicles *vehicles, const char *joint)
{
	const struct vehicle *car = &vehicles->list[0];
	const int number = vehicle_find_part(car, mjOBJ_JOINT, joint);
	assert_true(number >= 0);
	return &car->data->qpos[car->model->jnt_qposadr[number]];
}

/* Turns a joint with 20 N m for half a second. Returns how far it moves. */
static double given_way(const struct vehicles *vehicles, const char *joint)
{
	const struct vehicle *car = &vehicles->list[0];
	const double from = *place_of(vehicles, joint);
	double most = 0;
	car->data->qfrc_applied[car->model->jnt_dofadr[vehicle_find_part(car, mjOBJ_JOINT, joint)]] = 20;
	for (int i = 0; i < 250; i++) {
		mj_step1(car->model, car->data);
		mj_step2(car->model, car->data);
		most = support_most(most, fabs(*place_of(vehicles, joint) - from));
	}
	print_message("%s from %.3f gives way by %.4f\n", joint, from, most);
	return most;
}

static void an_arm_is_locked_on_a_path(void **state)
{
	struct scene *scene;
	(void)state;
	struct vehicles *vehicles = load(CART ARM "</robot>", PATH, NULL,
					 "1 joint with limits (arm) has no actuator, and the driver does not name it: it is locked in its first pose; servo: {free: [JOINT]} lets it move", &scene);
	assert_near(*place_of(vehicles, "arm"), 0.3, 1e-12);
	assert_non_null(strstr(told, "1 joint (arm) is outside its limits at 0: it begins at the nearest one"));
	assert_int_equal(range_count(vehicles->list[0].own.actuator), 4);
	assert_true(given_way(vehicles, "arm") < 0.02);
	unload(vehicles, scene);
	/* In the pose of the start. */
	vehicles = load(CART ARM "</robot>", PATH, "{arm: 1}", NULL, &scene);
	assert_near(*place_of(vehicles, "arm"), 1, 1e-12);
	assert_true(given_way(vehicles, "arm") < 0.02);
	unload(vehicles, scene);
	vehicles = load(CART ARM "</robot>", ", servo: {free: [arm]}" PATH, NULL, "(arm) has no actuator, and the driver does not name it: it moves freely", &scene);
	assert_true(given_way(vehicles, "arm") > 0.2);
	unload(vehicles, scene);
	/* A joint that the driver names has a servo. */
	vehicles = load(CART ARM "</robot>", ", driver: {hold: {arm: 0.5}}", NULL, "arm has no actuator: it gets a position servo", &scene);
	assert_null(strstr(told, "with limits"));
	unload(vehicles, scene);
}

/* 3 + 1 joints stand on four wheels; 3 + 2 do not. */
static void a_suspension_moves(void **state)
{
	static const char one[] = "<robot name='r'>" LINK("base", "50", BOX) HINGE("rocker", "base", "lower='-.3' upper='.3'") WHEEL("fl", "rocker", ".6 .5 -.2") WHEEL("fr", "rocker", ".6 -.5 -.2")
		WHEEL("rl", "base", "-.6 .5 -.2") WHEEL("rr", "base", "-.6 -.5 -.2") ARM "</robot>";
	static const char two[] = "<robot name='r'>" LINK("base", "50", BOX) HINGE("left", "base", "lower='-.3' upper='.3'") HINGE("right", "base", "lower='-.3' upper='.3'")
		WHEEL("fl", "left", ".6 .5 -.2") WHEEL("fr", "right", ".6 -.5 -.2") WHEEL("rl", "left", "-.6 .5 -.2") WHEEL("rr", "right", "-.6 -.5 -.2") "</robot>";
	struct scene *scene;
	(void)state;
	struct vehicles *vehicles = load(one, PATH, NULL, "1 joint with limits (rocker) has no actuator, and the driver does not name it: it moves freely", &scene);
	assert_non_null(strstr(told, "1 joint with limits (arm) has no actuator, and the driver does not name it: it is locked"));
	assert_true(given_way(vehicles, "rocker") > 0.1);
	unload(vehicles, scene);
	vehicles = load(two, PATH, NULL, "2 joints with limits (left, right) have no actuator, and the driver does not name them: they are locked in their first pose", &scene);
	assert_true(given_way(vehicles, "left") < 0.02);
	unload(vehicles, scene);
	/* Wheels that trail at the same height carry, too: those of a trailer behind a hitch. */
	vehicles = load("<robot name='r'>" LINK("base", "50", BOX) WHEEL("rl", "base", "-.3 .5 -.2") WHEEL("rr", "base", "-.3 -.5 -.2") HINGE("hitch", "base", "lower='-.3' upper='.3'")
			LINK("tl", "5", ROLLER) "<joint name='trails_l' type='continuous'><parent link='hitch'/><child link='tl'/><origin xyz='-2 .5 -.2'/><axis xyz='0 1 0'/></joint>"
			LINK("tr", "5", ROLLER) "<joint name='trails_r' type='continuous'><parent link='hitch'/><child link='tr'/><origin xyz='-2 -.5 -.2'/><axis xyz='0 1 0'/></joint></robot>",
			PATH, NULL, "1 joint with limits (hitch) has no actuator, and the driver does not name it: it moves freely", &scene);
	unload(vehicles, scene);
}

/* Limits of many turns are those of a wheel: a castor's turns. A slide between equal limits has no way. */
static void limits_may_be_odd(void **state)
{
	struct scene *scene;
	(void)state;
	struct vehicles *vehicles = load("<robot name='r'>" LINK("base", "50", BOX) WHEEL("fl", "base", ".3 .5 -.2") WHEEL("fr", "base", ".3 -.5 -.2") LINK("castor", "5", ROLLER)
					 "<joint name='castor' type='revolute'><parent link='base'/><child link='castor'/><origin xyz='-.6 0 -.2'/><axis xyz='0 1 0'/><limit lower='-180' upper='180' effort='1' velocity='1'/></joint></robot>",
					 PATH, NULL, NULL, &scene);
	assert_null(strstr(told, "with limits"));
	assert_true(given_way(vehicles, "castor") > 0.2);
	unload(vehicles, scene);
	vehicles = load(CART LINK("box", "2", "") "<joint name='box' type='prismatic'><parent link='base'/><child link='box'/><axis xyz='1 0 0'/><limit lower='0' upper='0' effort='0' velocity='0'/></joint></robot>",
			", driver: {hold: {wheel_fl: 1}}", NULL, "1 joint with limits (box) has no actuator, and the driver does not name it: it is locked", &scene);
	assert_true(given_way(vehicles, "box") < 0.02);
	unload(vehicles, scene);
}

/* Joints of any model, with or without limits and actuators. */
static void the_scene_locks_joints(void **state)
{
	static const char model[] = "<mujoco><worldbody><body name='base'><freejoint/><geom type='box' size='.4 .3 .1' mass='9'/>"
				    "<body name='leg' pos='0 .4 -.1'><joint name='knee' axis='0 1 0'/><geom type='box' size='.2 .05 .05' mass='1'/></body></body></worldbody>"
				    "<actuator><motor name='knee' joint='knee'/></actuator></mujoco>";
	struct scene *scene;
	(void)state;
	struct vehicles *vehicles = load(model, "", NULL, NULL, &scene);
	assert_true(given_way(vehicles, "knee") > 0.2);
	unload(vehicles, scene);
	vehicles = load(model, ", servo: {lock: [kn*, knee]}", "{knee: -0.4}", NULL, &scene);
	assert_near(*place_of(vehicles, "knee"), -0.4, 1e-12);
	assert_true(given_way(vehicles, "knee") < 0.05);
	unload(vehicles, scene);
	rig_refused(STEP, ", servo: {lock: [hip]}", STATUS_INPUT, "vehicles.car: servo.lock: hip names no hinge or slide of the model");
	rig_refused(STEP, ", servo: {free: [hip]}", STATUS_INPUT, "vehicles.car: servo.free: hip names no hinge or slide of the model");
}

/* A model of a leg that begins outside its limits would be thrown into them. Its keyframe stays as it is. */
static void joints_begin_within_their_limits(void **state)
{
	static const char model[] = "<mujoco><compiler autolimits='true'/><worldbody><body name='base'><freejoint/><geom type='box' size='.4 .3 .1' mass='9'/>"
				    "<body pos='0 .4 -.1'><joint name='knee' axis='0 1 0' range='-70 -30'/><geom type='box' size='.2 .05 .05' mass='1'/></body></body></worldbody>"
				    "<keyframe><key name='odd' qpos='0 0 0 1 0 0 0 0.1'/></keyframe></mujoco>";
	struct scene *scene;
	(void)state;
	struct vehicles *vehicles = load(model, "", NULL, "1 joint (knee) is outside its limits at 0: it begins at the nearest one", &scene);
	assert_near(*place_of(vehicles, "knee"), -30 * M_PI / 180, 1e-9);
	unload(vehicles, scene);
	must(scene_load(support_path("scene.yaml"), &(struct scene_setting){"vehicles.car.start.keyframe", "odd"}, 1, &scene));
	must(vehicle_load(scene, &vehicles));
	assert_near(*place_of(vehicles, "knee"), 0.1, 1e-12);
	unload(vehicles, scene);
}

#define MJ_CART(more, end) "<mujoco><worldbody><body name='base'><freejoint/><geom type='box' size='.6 .3 .1' mass='50'/>" \
	MJ_WHEEL("fl", ".6 .5 -.2") MJ_WHEEL("fr", ".6 -.5 -.2") MJ_WHEEL("rl", "-.6 .5 -.2") MJ_WHEEL("rr", "-.6 -.5 -.2") more "</body></worldbody><actuator>" \
	"<velocity name='wheel_fl' joint='fl' kv='9'/><velocity name='wheel_fr' joint='fr' kv='9'/><velocity name='wheel_rl' joint='rl' kv='9'/><velocity name='wheel_rr' joint='rr' kv='9'/>" end "</mujoco>"
#define MJ_WHEEL(name, at) "<body pos='" at "'><joint name='" name "' axis='0 1 0'/><geom type='cylinder' size='.3 .1' mass='5' zaxis='0 1 0'/></body>"
#define MJ_ARM(more) "<body pos='0 0 .3'><joint name='arm' axis='0 1 0' range='-1 1' limited='true'" more "/><geom type='capsule' size='.05' fromto='0 0 0 .5 0 0' mass='3'/></body>"

static void a_limb_that_nothing_holds_is_told_once(void **state)
{
	static const struct {
		const char *model, *keys, *says; /* says: NULL: nothing is told */
	} rows[] = {
		{CART ARM "</robot>", "", "vehicles.car: 1 joint with limits (arm) has no actuator, spring or friction: nothing holds it"},
		{MJ_CART(MJ_ARM(""), "</actuator>"), PATH, "vehicles.car: 1 joint with limits (arm) has no actuator, spring or friction: nothing holds it"},
		{MJ_CART(MJ_ARM(""), "</actuator>"), "", "nothing holds it, and what is below hangs; servo: {lock: [JOINT, ...]} locks it"},
		{MJ_CART(MJ_ARM(""), "<motor name='arm' joint='arm' ctrlrange='-5 5'/></actuator>"), PATH, "1 joint with limits (arm) has motors that the driver does not name"},
		{MJ_CART(MJ_ARM(""), "<motor name='arm' joint='arm' ctrlrange='-5 5'/></actuator>"), "", NULL}, /* a host may use it */
		{MJ_CART(MJ_ARM(""), "<position name='arm' joint='arm' kp='500'/></actuator>"), PATH, NULL},
		{MJ_CART(MJ_ARM(" stiffness='90'"), "</actuator>"), PATH, NULL},
		{MJ_CART(MJ_ARM(""), "</actuator>"), PATH ", servo: {lock: [arm]}", NULL},
		{MJ_CART(MJ_ARM(""), "</actuator><equality><joint joint1='arm'/></equality>"), PATH, NULL},
		{MJ_CART(MJ_ARM(""), "</actuator><tendon><fixed name='t' stiffness='9'><joint joint='arm' coef='1'/></fixed></tendon>"), PATH, NULL},
		{MJ_CART("<body><joint name='rocker' axis='0 1 0' range='-1 1' limited='true'/><geom type='box' size='.1 .1 .1' mass='3'/>" MJ_WHEEL("more", "0 .6 -.2") "</body>", "</actuator>"), PATH, NULL},
	};
	(void)state;
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct scene *scene;
		struct vehicles *vehicles = load(rows[i].model, rows[i].keys, NULL, rows[i].says, &scene);
		unload(vehicles, scene);
		const char *first = strstr(told, "nothing holds"), *second = first != NULL ? strstr(first + 1, "nothing holds") : NULL;
		if ((first != NULL) != (rows[i].says != NULL) || second != NULL)
			fail_msg("row %zu told:\n%s", i, told);
	}
}

TEST_PROGRAM(locks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_arm_is_locked_on_a_path),
		cmocka_unit_test(a_suspension_moves),
		cmocka_unit_test(limits_may_be_odd),
		cmocka_unit_test(the_scene_locks_joints),
		cmocka_unit_test(joints_begin_within_their_limits),
		cmocka_unit_test(a_limb_that_nothing_holds_is_told_once),
	};
	return cmocka_run_group_tests_name("joints that nothing drives", tests, support_enter, support_leave);
}
