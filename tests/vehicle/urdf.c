/* URDFs as people have them: what they lack is added, and told. */
#include <math.h>
#include <sys/stat.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/program.h"

#define STEP "time_step: 0.002"
#define INERTIAL(mass, moments) "<inertial><mass value='" mass "'/><inertia " moments " ixy='0' ixz='0' iyz='0'/></inertial>"
#define ROUND "ixx='.2' iyy='.3' izz='.2'"

/* A cart of 112 kg. %s in turn: what stands before the base, the base's own inertial, its collision, what stands at the end. */
static const char cart[] = "<robot name='cart'>%s<link name='base'>%s%s</link>"
#define WHEEL(name, x, y) \
	"<link name='" name "'>" INERTIAL("8", ROUND) "<collision><origin rpy='1.5708 0 0'/><geometry><cylinder radius='.3' length='.2'/></geometry></collision></link>" \
	"<joint name='wheel_" name "' type='continuous'><parent link='base'/><child link='" name "'/><origin xyz='" x " " y " -.2'/><axis xyz='0 1 0'/></joint>"
	WHEEL("fl", ".6", ".5") WHEEL("fr", ".6", "-.5") WHEEL("rl", "-.6", ".5") WHEEL("rr", "-.6", "-.5") "%s</robot>";

#define OWN INERTIAL("80", "ixx='5' iyy='8' izz='8'")

static void write_cart(const char *before, const char *inertial, const char *collision, const char *end)
{
	char text[8192];
	snprintf(text, sizeof text, cart, before, inertial, collision, end);
	support_write(support_path("model.xml"), text);
}

static char told[8192];

static void take(const char *text)
{
	const size_t length = strlen(told);
	snprintf(told + length, sizeof told - length, "%s\n", text);
}

struct loaded {
	struct scene *scene;
	struct vehicles *vehicles;
	const struct vehicle *car;
	struct vehicle_info info;
};

/* Loads it, and checks that a note says each text. NULL ends them. */
static struct loaded load(const char *more, const char *const says[])
{
	struct loaded loaded;
	told[0] = '\0';
	note_to(take);
	must(rig_load(STEP, more, &loaded.scene, &loaded.vehicles));
	note_to(NULL);
	for (int i = 0; says[i] != NULL; i++)
		if (strstr(told, says[i]) == NULL)
			fail_msg("no note says \"%s\":\n%s", says[i], told);
	loaded.car = &loaded.vehicles->list[0];
	vehicle_info(loaded.vehicles, 0, &loaded.info);
	return loaded;
}

/* The same, with start.fixed. */
static struct loaded load_set(const char *set, const char *const says[])
{
	struct loaded loaded = load("", says);
	vehicle_destroy(loaded.vehicles);
	scene_destroy(loaded.scene);
	must(scene_load(support_path("scene.yaml"), &(struct scene_setting){"vehicles.car.start.fixed", set}, 1, &loaded.scene));
	must(vehicle_load(loaded.scene, &loaded.vehicles));
	loaded.car = &loaded.vehicles->list[0];
	vehicle_info(loaded.vehicles, 0, &loaded.info);
	return loaded;
}

static void unload(struct loaded *loaded)
{
	vehicle_destroy(loaded->vehicles);
	scene_destroy(loaded->scene);
}

static void its_root_is_free_and_keeps_its_mass(void **state)
{
	(void)state;
	write_cart("", OWN, "", "");
	struct loaded loaded = load("", (const char *const[]){"its root base has no joint, as in every URDF: it moves freely", NULL});
	assert_int_equal(loaded.car->model->nv, 6 + 4);
	assert_true(fabs(loaded.info.mass - 112) < 1e-9);
	assert_int_equal(loaded.info.geom_count, 4);
	for (size_t i = 0; i < 4; i++)
		assert_int_equal(loaded.car->geoms[i].shape.kind, SOIL_WHEEL);
	unload(&loaded);
	/* Held: its joints alone move. */
	loaded = load_set("true", (const char *const[]){NULL});
	assert_int_equal(loaded.car->model->nv, 4);
	unload(&loaded);
	/* A dummy root without a mass, as ROS wants it, is a frame. */
	write_cart("<link name='footprint'/><joint name='foot' type='fixed'><parent link='footprint'/><child link='base'/><origin xyz='0 0 .5'/></joint>", OWN, "", "");
	loaded = load("", (const char *const[]){"its root footprint has no joint", NULL});
	assert_int_equal(loaded.car->model->nv, 6 + 4);
	assert_true(fabs(loaded.info.mass - 112) < 1e-9);
	unload(&loaded);
	/* A link named world holds it, unless the scene says no. */
	write_cart("<link name='world'/><joint name='foot' type='fixed'><parent link='world'/><child link='base'/></joint>", OWN, "", "");
	loaded = load("", (const char *const[]){"is fixed to its link world", NULL});
	assert_int_equal(loaded.car->model->nv, 4);
	unload(&loaded);
	loaded = load_set("false", (const char *const[]){NULL});
	assert_int_equal(loaded.car->model->nv, 6 + 4);
	unload(&loaded);
}

static void joints_that_the_driver_names_get_servos(void **state)
{
	(void)state;
	write_cart("", OWN, "", "");
	struct loaded loaded = load(", servo: {torque: 20}, driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, drive: [wheel_f*], steer: [wheel_rl]}",
				    (const char *const[]){"wheel_fl, wheel_fr have no actuator: each gets a velocity servo", "wheel_rl has no actuator: it gets a position servo", NULL});
	const mjModel *model = loaded.car->model;
	assert_int_equal(model->nactuator, 3);
	assert_int_equal(loaded.car->driver.drive_count, 2);
	assert_int_equal(loaded.car->driver.steer_count, 1);
	assert_true(model->actuator_forcerange[1] == 20 && model->actuator_biasprm[2] == -200);
	unload(&loaded);
	/* Without `torque` that of the joint. */
	write_cart("", OWN, "", "<link name='arm'>" INERTIAL("1", ROUND) "</link><joint name='lift' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 1 0'/>"
				"<limit lower='-1' upper='1' effort='33' velocity='1'/></joint>");
	loaded = load(", driver: {hold: {lift: 0.5}}", (const char *const[]){"lift has no actuator: it gets a position servo, the last with at most 33 N m", NULL});
	assert_int_equal(loaded.car->model->nactuator, 1);
	unload(&loaded);
	rig_refused(STEP, ", driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, drive: [rolls_*]}", STATUS_INPUT, "rolls_*");
}

static void what_no_body_can_have_is_mended(void **state)
{
	(void)state;
	static const struct {
		const char *inertial, *says;
		double least, most; /* kg m2: of the moments */
	} cases[] = {
		{INERTIAL("80", "ixx='5' iyy='8' izz='20'"), "1 inertia that no body can have, one moment above the sum of the others (base): their mean is taken", 11, 11},
		{INERTIAL("80", "ixx='0' iyy='0' izz='0'"), "1 inertia that is not positive (base): that of a ball is taken", 2.2, 2.4},
		{INERTIAL("80", "ixx='-1' iyy='3' izz='3'"), "1 inertia that is not positive (base)", 2.2, 2.4},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		write_cart("", cases[i].inertial, "", "");
		struct loaded loaded = load("", (const char *const[]){cases[i].says, NULL});
		const double *moments = &loaded.car->model->body_inertia[3 * vehicle_find_part(loaded.car, mjOBJ_BODY, "base")];
		for (int k = 0; k < 3; k++)
			assert_true(moments[k] >= cases[i].least - 1e-9 && moments[k] <= cases[i].most + 1e-9);
		assert_true(fabs(loaded.info.mass - 112) < 1e-9);
		unload(&loaded);
	}
	/* A link that moves and has no mass. */
	write_cart("", OWN, "", "<link name='dial'/><joint name='turn' type='continuous'><parent link='base'/><child link='dial'/><axis xyz='0 0 1'/></joint>");
	struct loaded loaded = load("", (const char *const[]){"1 link that moves without a mass (dial): 0.001 kg each is added", NULL});
	assert_true(fabs(loaded.info.mass - 112.001) < 1e-9);
	unload(&loaded);
	/* The mass of shapes is told with its kilograms: a box of 0.2 m3 of water. */
	write_cart("", "", "<collision><geometry><box size='1 1 .2'/></geometry></collision>", "");
	loaded = load("", (const char *const[]){"its links' inertials have 32 kg together, and the model has 232 kg", NULL});
	unload(&loaded);
}

static void write_box(const char *path)
{
	char text[600] = "";
	for (int i = 0; i < 8; i++)
		snprintf(text + strlen(text), sizeof text - strlen(text), "v %g %g %g\n", i & 4 ? 0.5 : -0.5, i & 2 ? 0.3 : -0.3, i & 1 ? 0.1 : -0.1);
	strcat(text, "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n");
	support_write(path, text);
}

static void meshes_are_found_in_packages(void **state)
{
	char scene[256], collision[400];
	(void)state;
	assert_int_equal(mkdir(support_path("lib"), 0777), 0);
	assert_int_equal(mkdir(support_path("lib/parts"), 0777), 0);
	write_box(support_path("lib/parts/hull.obj"));
	write_box(support_path("beside.obj"));
	static const struct {
		const char *name, *more;
		bool found;
	} cases[] = {
		{"package://parts/hull.obj", ", model_path: [lib]", true}, {"package://parts/hull.obj", ", model_path: [lib/parts]", true},
		{"package://parts/hull.obj", "", false}, {"lib/parts/hull.obj", "", true}, {"beside.obj", "", true}, {"file://%s/beside.obj", "", true},
		{"%s/beside.obj", "", true}, {"hull.obj", ", model_path: [lib/parts]", true}, {"package://other/parts/hull.obj", ", model_path: [lib]", true}, {"nothing.obj", "", false},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		char name[200], folder[160];
		snprintf(folder, sizeof folder, "%s", support_path(""));
		folder[strlen(folder) - 1] = '\0';
		const char *at = strstr(cases[i].name, "%s");
		snprintf(name, sizeof name, "%.*s%s%s", at != NULL ? (int)(at - cases[i].name) : 0, cases[i].name, at != NULL ? folder : "", at != NULL ? at + 2 : cases[i].name);
		snprintf(collision, sizeof collision, "<collision><geometry><mesh filename='%s'/></geometry></collision>", name);
		write_cart("", OWN, collision, "");
		snprintf(scene, sizeof scene, "%s", cases[i].more);
		struct loaded loaded = load(scene, (const char *const[]){cases[i].found ? "it moves freely" : "1 mesh is not found", NULL});
		assert_int_equal(loaded.info.geom_count, cases[i].found ? 5 : 4);
		assert_true(fabs(loaded.info.mass - 112) < 1e-9);
		unload(&loaded);
	}
	/* No file of the machine is read because a model names it. */
	write_cart("", OWN, "<collision><geometry><mesh filename='/etc/passwd'/></geometry></collision>", "");
	rig_refused(STEP, "", STATUS_INPUT, "neither in the model's folder nor in the one above");
	write_cart("", OWN, "<collision><geometry><mesh filename='package://parts/../../../../../../etc/passwd'/></geometry></collision>", "");
	rig_refused(STEP, ", model_path: [lib]", STATUS_INPUT, "neither in the model's folder nor in the one above");
	write_cart("", OWN, "<collision><geometry><mesh filename='${dir}/hull.obj'/></geometry></collision>", "");
	rig_refused(STEP, "", STATUS_INPUT, "it has parts of xacro, a macro language (${dir}/hull.obj); expand it first: xacro ");
	write_cart("<xacro:include filename='x'/>", OWN, "", "");
	rig_refused(STEP, "", STATUS_INPUT, "it has parts of xacro");
}

/* A drum of `sides` sides about the y axis, or one whose corners stand out in turn by `bars` of its radius. */
static void write_drum(int sides, double bars)
{
	static char text[200000];
	size_t at = 0;
	for (int i = 0; i < sides; i++)
		for (int end = -1; end < 2; end++) {
			const double angle = 2 * M_PI * i / sides, radius = 0.3 * (i % 4 < 2 ? 1 : 1 - bars);
			at += (size_t)snprintf(text + at, sizeof text - at, "v %.9g %.9g %.9g\n", radius * cos(angle), 0.1 * end, radius * sin(angle));
		}
	for (int i = 0; i < sides; i++) {
		const int a = 3 * i + 1, b = 3 * ((i + 1) % sides) + 1;
		for (int k = 0; k < 2; k++)
			at += (size_t)snprintf(text + at, sizeof text - at, "f %d %d %d\nf %d %d %d\n", a + k, a + k + 1, b + k + 1, a + k, b + k + 1, b + k);
		if (i > 1)
			at += (size_t)snprintf(text + at, sizeof text - at, "f 1 %d %d\nf 3 %d %d\n", 3 * (i - 1) + 1, a, a + 2, 3 * (i - 1) + 3);
	}
	support_write(support_path("drum.obj"), text);
}

/* A mesh that is round about its hinge is a wheel; one with bars stays as it is. */
static void round_meshes_are_wheels(void **state)
{
	static const struct {
		int sides;
		double bars;
		const char *axis, *origin;
		enum soil_shape_kind kind;
	} cases[] = {
		{48, 0, "0 1 0", "0 0 0", SOIL_WHEEL}, {48, 0, "0 -1 0", "0 0 0", SOIL_WHEEL}, {24, 0, "0.03 1 0", "0.005 0 0", SOIL_WHEEL}, {48, 0.1, "0 1 0", "0 0 0", SOIL_MESH},
		{8, 0, "0 1 0", "0 0 0", SOIL_MESH}, {48, 0, "0 0 1", "0 0 0", SOIL_MESH}, {48, 0, "0 1 0", "0.1 0 0", SOIL_MESH},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		char end[900];
		write_drum(cases[i].sides, cases[i].bars);
		snprintf(end, sizeof end, "<link name='drum'>" INERTIAL("8", ROUND) "<collision><origin xyz='%s'/><geometry><mesh filename='drum.obj'/></geometry></collision></link>"
			 "<joint name='spin' type='continuous'><parent link='base'/><child link='drum'/><origin xyz='1.5 0 -.2'/><axis xyz='%s'/></joint>", cases[i].origin, cases[i].axis);
		write_cart("", OWN, "", end);
		struct loaded loaded = load("", (const char *const[]){NULL});
		const struct soil_geom *drum = &loaded.car->geoms[4];
		if (drum->shape.kind != cases[i].kind)
			fail_msg("case %zu: kind %d", i, drum->shape.kind);
		if (drum->shape.kind == SOIL_WHEEL) {
			struct furrow_state at;
			double axes[3][3];
			vehicle_geom_state(loaded.car, drum, &at, NULL);
			world_axes(at.pose.orientation, axes);
			const double off = cases[i].axis[0] == '0' && cases[i].axis[1] != '.' ? 1e-4 : 0.02; /* a hinge that leans sees the drum lean */
			if (!(fabs(drum->shape.radius - 0.3) < off && fabs(drum->shape.width - 0.2) < off))
				fail_msg("case %zu: radius %.9g m, width %.9g m", i, drum->shape.radius, drum->shape.width);
			assert_true(axes[1][1] > 0.99); /* its axle looks to the left */
			assert_int_equal(drum->dof, 6 + 4);
		}
		unload(&loaded);
	}
}

static void columns_of_a_table_get_servos(void **state)
{
	static const char arm[] = "<link name='arm'>" INERTIAL("2", ROUND) "</link><joint name='bend' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 1 0'/>"
				  "<limit lower='-1' upper='1' effort='30' velocity='1'/></joint>";
	(void)state;
	write_cart("", OWN, "", arm);
	support_write(support_path("controls.csv"), "t,wheel_fl,bend\r\n0,2,0.5\n");
	struct loaded loaded = load(", driver: {controls: controls.csv}", (const char *const[]){"bend has no actuator: it gets a position servo", "wheel_fl has no actuator: it gets a velocity servo", NULL});
	const mjModel *model = loaded.car->model;
	const int wheel = vehicle_find_part(loaded.car, mjOBJ_ACTUATOR, "wheel_fl"), bend = vehicle_find_part(loaded.car, mjOBJ_ACTUATOR, "bend");
	assert_true(loaded.info.actuator_count == 2 && vehicle_keeps_rate(model, wheel) && vehicle_keeps_place(model, bend));
	vehicle_control(&loaded.vehicles->list[0], 1, true);
	assert_true(*vehicle_ctrl(loaded.car, wheel) == 2 && *vehicle_ctrl(loaded.car, bend) == 0.5);
	unload(&loaded);
	support_write(support_path("controls.csv"), "t,wheel_fl,elbow\n0,2,0.5\n");
	rig_refused(STEP, ", driver: {controls: controls.csv}", STATUS_INPUT, "controls.csv:1: elbow; allowed: names of the model's actuators");
}

TEST_PROGRAM(urdf)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(its_root_is_free_and_keeps_its_mass),
		cmocka_unit_test(joints_that_the_driver_names_get_servos),
		cmocka_unit_test(what_no_body_can_have_is_mended),
		cmocka_unit_test(columns_of_a_table_get_servos),
		cmocka_unit_test(meshes_are_found_in_packages),
		cmocka_unit_test(round_meshes_are_wheels),
	};
	return cmocka_run_group_tests_name("URDFs", tests, support_enter, support_leave);
}
