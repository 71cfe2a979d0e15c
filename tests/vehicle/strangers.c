/* Models as strangers bring them: what MuJoCo refuses or mixes up is mended, and told. */
#include <math.h>
#include <sys/stat.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/program.h"

#define STEP "time_step: 0.002"
#define INERTIAL(mass) "<inertial><mass value='" mass "'/><inertia ixx='.2' iyy='.2' izz='.2' ixy='0' ixz='0' iyz='0'/></inertial>"
#define CYLINDER "<origin rpy='1.5708 0 0'/><geometry><cylinder radius='.3' length='.2'/></geometry>"
#define JOINT(name, type, child, more) "<joint name='" name "' type='" type "'><parent link='base'/><child link='" child "'/><axis xyz='0 1 0'/>" more "</joint>"
#define BOX(a, b, c) "<geometry><box size='" a " " b " " c "'/></geometry>"

static char told[8192];

static void take(const char *text)
{
	const size_t length = strlen(told);
	snprintf(told + length, sizeof told - length, "%s\n", text);
}

struct loaded {
	struct scene *scene;
	struct vehicles *vehicles;
	const mjModel *model;
	struct vehicle_info info;
};

/* Loads model.xml, and checks that notes say each text. NULL ends them. */
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
	loaded.model = loaded.vehicles->list[0].model;
	vehicle_info(loaded.vehicles, 0, &loaded.info);
	return loaded;
}

static struct loaded load_text(const char *text, const char *const says[])
{
	support_write(support_path("model.xml"), text);
	return load("", says);
}

static void unload(struct loaded *loaded)
{
	vehicle_destroy(loaded->vehicles);
	scene_destroy(loaded->scene);
}

static const struct soil_geom *geom_of(const struct loaded *loaded, const char *name)
{
	for (size_t g = 0; g < loaded->info.geom_count; g++)
		if (strcmp(loaded->vehicles->list[0].geoms[g].name, name) == 0)
			return &loaded->vehicles->list[0].geoms[g];
	fail_msg("no soil geom %s", name);
	return NULL;
}

/* --- meshes --- */

static void write_box(const char *path, double half)
{
	char text[600] = "";
	for (int i = 0; i < 8; i++)
		snprintf(text + strlen(text), sizeof text - strlen(text), "v %g %g %g\n", i & 4 ? half : -half, i & 2 ? half : -half, i & 1 ? half : -half);
	strcat(text, "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n");
	support_write(path, text);
}

static double half_of(const struct loaded *loaded, const char *name)
{
	const struct soil_geom *geom = geom_of(loaded, name);
	assert_int_equal(geom->shape.kind, SOIL_MESH);
	return geom->mesh->high[0];
}

/* Files of the same name in two folders are two meshes. */
static void meshes_of_one_name_stay_apart(void **state)
{
	(void)state;
	assert_int_equal(mkdir(support_path("left"), 0777), 0);
	assert_int_equal(mkdir(support_path("right"), 0777), 0);
	write_box(support_path("left/part.obj"), 0.2);
	write_box(support_path("right/part.obj"), 0.4);
	struct loaded loaded = load_text("<robot name='r'><link name='base'>" INERTIAL("5") "<collision name='a'><geometry><mesh filename='left/part.obj'/></geometry></collision>"
					 "<collision name='b'><geometry><mesh filename='right/part.obj'/></geometry></collision>"
					 "<collision name='c'><geometry><mesh filename='right/part.obj' scale='.5 .5 .5'/></geometry></collision></link></robot>",
					 (const char *const[]){NULL});
	assert_true(fabs(half_of(&loaded, "car.a") - 0.2) < 1e-6);
	assert_true(fabs(half_of(&loaded, "car.b") - 0.4) < 1e-6);
	assert_true(fabs(half_of(&loaded, "car.c") - 0.2) < 1e-6);
	unload(&loaded);
}

static const char dae[] =
	"<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><asset><unit name='centimeter' meter='0.01'/><up_axis>Z_UP</up_axis></asset>"
	"<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='12'>0 0 0 100 0 0 0 50 0 0 0 25</float_array><technique_common>"
	"<accessor source='#pa' count='4' stride='3'><param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor></technique_common></source>"
	"<vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles count='4'><input semantic='VERTEX' source='#v' offset='0'/>"
	"<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries><library_lights><light id='l' name='l'><technique_common><point><color>1 1 1</color></point></technique_common></light></library_lights>"
	"<library_visual_scenes><visual_scene id='s'><node id='l1' name='L'><instance_light url='#l'/></node><node id='l2' name='L'><instance_light url='#l'/></node><node id='n'>%s<instance_geometry url='#g'/></node>"
	"</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";

static void dae_meshes_are_read(void **state)
{
	(void)state;
	char text[4096];
	snprintf(text, sizeof text, dae, "<translate>10 0 0</translate>");
	support_write(support_path("part.dae"), text);
	static const char model[] = "<robot name='r'><link name='base'>" INERTIAL("5") "<collision name='a'><geometry><mesh filename='part.dae' scale='2 2 2'/></geometry></collision>"
				    "<collision name='b'>" BOX("1", "1", "1") "</collision></link></robot>";
	struct loaded loaded = load_text(model, (const char *const[]){NULL});
	/* 100 cm, twice as large; MuJoCo puts the origin into the middle, so only lengths are compared. */
	const int mesh = loaded.model->geom_dataid[geom_of(&loaded, "car.a")->geom];
	const float *at = loaded.model->mesh_vert + 3 * loaded.model->mesh_vertadr[mesh];
	double longest = 0;
	for (int i = 0; i < loaded.model->mesh_vertnum[mesh]; i++)
		for (int k = 0; k < i; k++)
			longest = fmax(longest, hypot(hypot((double)at[3 * i] - (double)at[3 * k], (double)at[3 * i + 1] - (double)at[3 * k + 1]), (double)at[3 * i + 2] - (double)at[3 * k + 2]));
	assert_true(fabs(longest - 2 * hypot(1, 0.5)) < 1e-5);
	unload(&loaded);
	/* One that is cut off is left out, and told. */
	text[strlen(text) / 2] = '\0';
	support_write(support_path("part.dae"), text);
	loaded = load_text(model, (const char *const[]){"1 mesh is not read (part.dae): the shape is left out", NULL});
	assert_int_equal(loaded.info.geom_count, 1);
	unload(&loaded);
}

/* A package whose folder has another name, beside the model's own. */
static void packages_are_found_by_their_own_file(void **state)
{
	(void)state;
	static const char *const folders[] = {"ws", "ws/robot", "ws/robot/urdf", "ws/meshes-1.2", "ws/meshes-1.2/parts"};
	for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++)
		assert_int_equal(mkdir(support_path(folders[i]), 0777), 0);
	support_write(support_path("ws/meshes-1.2/package.xml"), "<package><name> robot_meshes </name></package>");
	write_box(support_path("ws/meshes-1.2/parts/hull.obj"), 0.3);
	for (int other = 0; other < 2; other++) {
		char text[700];
		snprintf(text, sizeof text, "<robot name='r'><link name='base'>" INERTIAL("5") "<collision name='a'><geometry><mesh filename='package://robot_meshes%s/parts/hull.obj'/></geometry></collision>"
			 "<collision name='b'>" BOX("1", "1", "1") "</collision></link></robot>", other ? "_2" : "");
		support_write(support_path("ws/robot/urdf/model.urdf"), text);
		support_write(support_path("scene.yaml"), "scene: 1\nend_time: 1\ntime_step: 0.002\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
							  "  - {name: car, model: ws/robot/urdf/model.urdf, start: {at: [5, 5]}}\n");
		struct loaded loaded;
		must(scene_load(support_path("scene.yaml"), NULL, 0, &loaded.scene));
		must(vehicle_load(loaded.scene, &loaded.vehicles));
		vehicle_info(loaded.vehicles, 0, &loaded.info);
		assert_int_equal(loaded.info.geom_count, other ? 1 : 2);
		unload(&loaded);
	}
}

static void a_model_whose_meshes_are_elsewhere_says_so(void **state)
{
	(void)state;
	support_write(support_path("model.xml"), "<robot name='r'><link name='base'>" INERTIAL("5") "<collision><geometry><mesh filename='package://far/a.stl'/></geometry></collision></link></robot>");
	rig_refused(STEP, "", STATUS_INPUT, "1 of its meshes is not found or not read (a.stl), and nothing else of it collides; name the folder of its packages in model_path");
}

/* --- shapes and masses --- */

static void what_is_only_seen_collides(void **state)
{
	(void)state;
	/* No collision at all: each link's visual. */
	struct loaded loaded = load_text("<robot name='r'><link name='base'>" INERTIAL("5") "<visual name='a'>" BOX("1", "1", ".2") "<material name='m'/></visual></link>"
					 "<link name='arm'>" INERTIAL("1") "<visual>" BOX(".1", ".1", ".5") "</visual></link>" JOINT("lift", "revolute", "arm", "<limit lower='-1' upper='1' effort='9' velocity='1'/>")
					 "</robot>", (const char *const[]){"none of its links has a collision: what is seen of 2 collides", NULL});
	assert_int_equal(loaded.info.geom_count, 2);
	assert_true(fabs(loaded.info.mass - 6) < 1e-9);
	unload(&loaded);
	/* Wheels without a collision; a lid that does not turn stays as it is. */
	loaded = load_text("<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link>"
			   "<link name='wheel'>" INERTIAL("1") "<visual>" CYLINDER "</visual></link>" JOINT("turn", "continuous", "wheel", "<origin xyz='0 .6 -.1'/>")
			   "<link name='lid'>" INERTIAL("1") "<visual>" BOX(".1", ".1", ".5") "</visual></link>" JOINT("open", "revolute", "lid", "<limit lower='-1' upper='1' effort='9' velocity='1'/>")
			   "</robot>", (const char *const[]){"wheel turns and has no collision: what is seen of it collides", NULL});
	assert_int_equal(loaded.info.geom_count, 2);
	assert_int_equal(geom_of(&loaded, "car.wheel")->shape.kind, SOIL_WHEEL);
	unload(&loaded);
}

static void links_that_are_fixed_and_weigh_nothing_stay_so(void **state)
{
	(void)state;
	static const char lid[] = "<link name='lid'>%s<collision>" BOX("1", "1", "1") "</collision></link>" JOINT("screw", "fixed", "lid", "") "</robot>";
	static const char *const inertials[] = {"", "<inertial><mass value='0'/><inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial>",
						"<inertial><mass value='4e-15'/><inertia ixx='1e-27' iyy='1e-27' izz='1e-27' ixy='-3e-45' ixz='0' iyz='0'/></inertial>"};
	for (size_t i = 0; i < 3; i++) {
		char text[2048];
		snprintf(text, sizeof text, "<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link>");
		snprintf(text + strlen(text), sizeof text - strlen(text), lid, inertials[i]);
		struct loaded loaded = load_text(text, (const char *const[]){"1 link without an inertial (lid) has no mass, as in ROS", NULL});
		assert_true(fabs(loaded.info.mass - 5) < 1e-9);
		assert_int_equal(loaded.info.geom_count, 2);
		unload(&loaded);
	}
	/* The root's own inertial may be in a link that is fixed to it. */
	struct loaded loaded = load_text("<robot name='r'><link name='base'><collision>" BOX("1", "1", ".2") "</collision></link><link name='heart'>" INERTIAL("7") "</link>"
					 JOINT("screw", "fixed", "heart", "") "</robot>", (const char *const[]){"(base) has no mass", NULL});
	assert_true(fabs(loaded.info.mass - 7) < 1e-9);
	unload(&loaded);
	/* No inertial at all: the mass of water, told with its kilograms. */
	loaded = load_text("<robot name='r'><link name='base'><collision>" BOX("1", "1", ".2") "</collision></link></robot>", (const char *const[]){"0 kg together, and the model has 200 kg", NULL});
	unload(&loaded);
	/* Shapes of no size, and a part that is too light to move. */
	loaded = load_text("<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision><collision>" BOX("0", "1", ".2") "</collision></link>"
			   "<link name='dial'><inertial><mass value='1e-4'/><inertia ixx='1e-18' iyy='1e-18' izz='1e-18' ixy='0' ixz='0' iyz='0'/></inertial></link>"
			   JOINT("turn", "continuous", "dial", "") "</robot>", (const char *const[]){"1 shape of size 0 (base) is left out", NULL});
	assert_int_equal(loaded.info.geom_count, 1);
	unload(&loaded);
}

/* --- text --- */

static void texts_that_others_take_are_taken(void **state)
{
	(void)state;
	struct loaded loaded = load_text("<robot name='r'>\n<link name='base'>" INERTIAL("5") "<visual>" BOX("1", "1", "1") "<material name='a'><color rgba='1 0 0 1'/></material>\n"
					 "<material name='b'><color rgba='1 0 0 1'/></material></visual><collision><origin xyz='0.5, 0, -.2'/>" BOX("1,", "1", ".2") "</collision></link>\n"
					 "<gazebo reference='${name}'><plugin filename='$(arg x)'/></gazebo></robot>",
					 (const char *const[]){"2 of its attributes have commas between numbers", NULL});
	const int geom = geom_of(&loaded, "car.base")->geom;
	assert_true(fabs(loaded.model->geom_pos[3 * geom] - 0.5) < 1e-9);
	assert_true(fabs(loaded.model->geom_pos[3 * geom + 2] + 0.2) < 1e-9);
	unload(&loaded);
	/* MuJoCo's own messages keep the file's lines. */
	support_write(support_path("model.xml"), "<robot name='r'>\n<link name='base'>\n<visual>" BOX("1", "1", "1") "<material name='a'/>\n<material name='b'/></visual></link>\n<joint name='j'/>\n</robot>");
	rig_refused(STEP, "", STATUS_INPUT, "line 5");
	support_write(support_path("model.xml"), "<robot name='r'>\n<link name='base'>\n<visual>\n</robot>");
	rig_refused(STEP, "", STATUS_INPUT, "line 4: its XML is not whole");
}

static void joints_that_mimic_follow(void **state)
{
	(void)state;
	struct loaded loaded = load_text("<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link>"
					 "<link name='a'>" INERTIAL("1") "</link>" JOINT("left", "continuous", "a", "")
					 "<link name='b'>" INERTIAL("1") "</link>" JOINT("right", "continuous", "b", "<mimic joint='left' multiplier='-2' offset='.1'/>") "</robot>",
					 (const char *const[]){"1 joint (right) follows another one, as mimic says", NULL});
	assert_int_equal(loaded.model->neq, 1);
	assert_true(loaded.model->eq_data[0] == 0.1 && loaded.model->eq_data[1] == -2);
	assert_int_equal(loaded.model->eq_obj1id[0], vehicle_find_part(&loaded.vehicles->list[0], mjOBJ_JOINT, "right"));
	assert_int_equal(loaded.model->eq_obj2id[0], vehicle_find_part(&loaded.vehicles->list[0], mjOBJ_JOINT, "left"));
	unload(&loaded);
}

/* MuJoCo has free joints at roots alone. */
static void a_joint_without_its_link_is_refused(void **state)
{
	(void)state;
	support_write(support_path("model.xml"), "<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link><link name='a'/>" JOINT("arm", "fixed", "b", "") "</robot>");
	rig_refused(STEP, "", STATUS_INPUT, "joint arm: its child b is no link of the file; correct the name, or take the joint out");
	support_write(support_path("model.xml"), "<robot name='r'><link name='bas'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link><link name='b'/>" JOINT("arm", "fixed", "b", "") "</robot>");
	rig_refused(STEP, "", STATUS_INPUT, "joint arm: its parent base is no link of the file");
}

static void links_that_float_are_held(void **state)
{
	(void)state;
	struct loaded loaded = load_text("<robot name='r'><link name='ground'/><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link>"
					 "<joint name='six' type='floating'><parent link='ground'/><child link='base'/></joint></robot>",
					 (const char *const[]){"six floats between links: it is held", "its root ground has no joint", NULL});
	assert_int_equal(loaded.model->nv, 6);
	assert_true(fabs(loaded.info.mass - 5) < 1e-9);
	unload(&loaded);
}

/* --- MJCF --- */

static void files_that_an_mjcf_lacks_are_left_out(void **state)
{
	(void)state;
	static const char model[] =
		"<mujoco><asset><mesh name='a' file='none.stl'/><mesh name='b' file='there.obj'/><texture name='t' type='2d' file='none.png'/><material name='m' texture='t'/></asset>"
		"<worldbody><body name='base'><freejoint/><inertial pos='0 0 0' mass='5' diaginertia='1 1 1'/><geom type='mesh' mesh='a'/><geom name='b' type='mesh' mesh='b' material='m'/>"
		"<body><joint axis='0 1 0'/><geom type='box' size='.1 .1 .1' mass='1'/></body></body></worldbody><actuator><motor joint='joint'/></actuator></mujoco>";
	assert_int_equal(mkdir(support_path("elsewhere"), 0777), 0);
	write_box(support_path("elsewhere/there.obj"), 0.3);
	support_write(support_path("model.xml"), model);
	struct loaded loaded = load(", model_path: [elsewhere]", (const char *const[]){"1 mesh is not found (none.stl)", "1 image is not found (none.png): plain grey is taken", NULL});
	assert_int_equal(loaded.info.geom_count, 2);
	assert_true(fabs(loaded.info.mass - 6) < 1e-9);
	assert_true(fabs(half_of(&loaded, "car.b") - 0.3) < 1e-6);
	unload(&loaded);
	/* A mass that the mesh would give is told. */
	loaded = load_text("<mujoco><asset><mesh name='a' file='none.stl'/></asset><worldbody><body name='base'><freejoint/><geom type='box' size='.1 .1 .1' mass='1'/>"
			   "<geom type='mesh' mesh='a'/></body></worldbody></mujoco>", (const char *const[]){"its shape is left out, and the mass that it gives base", NULL});
	unload(&loaded);
}

static void parts_without_a_name_get_one(void **state)
{
	(void)state;
	struct loaded loaded = load_text("<mujoco><asset><skin name='s' file='none.skn'/></asset><worldbody><body name='base'><freejoint/><geom type='box' size='.4 .3 .1' mass='9'/>"
					 "<body name='wheel' pos='0 .4 -.1'><joint axis='0 1 0'/><geom type='cylinder' size='.2 .05' euler='90 0 0' mass='1'/></body>"
					 "<body name='lift'><joint name='up' axis='0 1 0'/><geom type='box' size='.1 .1 .1' mass='1'/></body></body></worldbody>"
					 "<actuator><motor joint='up'/><velocity joint='up' kv='1'/></actuator></mujoco>",
					 (const char *const[]){"1 joint without a name is called after its body: wheel", "2 actuators without a name are called after what they move: up, up_2", "1 skin is left out", NULL});
	assert_true(vehicle_find_part(&loaded.vehicles->list[0], mjOBJ_JOINT, "wheel") >= 0);
	assert_true(vehicle_find_part(&loaded.vehicles->list[0], mjOBJ_ACTUATOR, "up_2") >= 0);
	unload(&loaded);
}

/* A part whose assets are in another file. */
static void materials_that_are_not_there_are_left_out(void **state)
{
	(void)state;
	struct loaded loaded = load_text("<mujoco><asset><material name='red' rgba='1 0 0 1'/></asset><worldbody><body name='base'><freejoint/><geom type='box' size='.4 .3 .1' material='red'/>"
					 "<geom type='box' size='.1 .1 .3' material='grid'/><site material='grid'/></body></worldbody></mujoco>",
					 (const char *const[]){"it has no material grid: the shapes' own colours are taken", NULL});
	assert_int_equal(loaded.info.geom_count, 2);
	assert_true(loaded.model->nmat == 1 && loaded.model->geom_matid[0] == 0 && loaded.model->geom_matid[1] == -1);
	unload(&loaded);
}

/* A table of controls moves joints that have no actuator; an effort that is far too large makes no servo that is too stiff. */
static void columns_of_a_table_get_servos(void **state)
{
	(void)state;
	support_write(support_path("table.csv"), "t,arm\n0,0\n1,0.5\n");
	support_write(support_path("model.xml"), "<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link><link name='a'>" INERTIAL("1") "</link>"
						 JOINT("arm", "revolute", "a", "<limit lower='-1' upper='1' effort='100000' velocity='1'/>") "</robot>");
	struct loaded loaded = load(", driver: {controls: table.csv}", (const char *const[]){"arm has no actuator: it gets a position servo", NULL});
	assert_int_equal(loaded.model->nactuator, 1);
	assert_null(strstr(told, "with limits"));
	assert_true(loaded.model->actuator_forcerange[1] == 100000);
	/* The weight at the end of the largest shape, times ten, in 0.02 rad. */
	assert_true(fabs(loaded.model->actuator_gainprm[0] - 10 * 6 * 9.81 * 0.5 / 0.02) < 1);
	unload(&loaded);
}

#define LIGHT(name, of, at) "<link name='" name "'><inertial><origin xyz='.02 0 0'/><mass value='.005'/><inertia ixx='1e-7' iyy='1e-7' izz='1e-7' ixy='0' ixz='0' iyz='0'/></inertial></link>" \
	"<joint name='" name "' type='revolute'><parent link='" of "'/><child link='" name "'/><origin xyz='" at "'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1000' velocity='1'/></joint>"

static void servos_of_light_fingers_are_stable(void **state)
{
	static const char *const says[] = {"3 position servos (near, middle, tip) would be too stiff for the mass that they move, in steps of 0.002 s: softened", NULL};
	(void)state;
	support_write(support_path("table.csv"), "t,near,middle,tip,arm\n0,0.2,0.2,0.2,0.5\n");
	support_write(support_path("model.xml"), "<robot name='r'><link name='base'>" INERTIAL("50") "<collision>" BOX("1", ".6", ".2") "</collision></link>"
						 "<link name='arm'>" INERTIAL("5") "</link><joint name='arm' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 1 0'/>"
						 "<limit lower='-1' upper='1' effort='100' velocity='1'/></joint>" LIGHT("near", "arm", ".5 0 0") LIGHT("middle", "near", ".04 0 0") LIGHT("tip", "middle", ".04 0 0") "</robot>");
	struct loaded loaded = load(", driver: {controls: table.csv}", says);
	mjData *data = loaded.vehicles->data;
	const struct vehicle *car = &loaded.vehicles->list[0];
	assert_null(strstr(told, "arm,")); /* its servo is not too stiff */
	for (int i = 0; i < loaded.model->nu; i++)
		data->ctrl[i] = 0.2;
	for (int i = 0; i < 500; i++) {
		mj_step1(loaded.model, data);
		mj_step2(loaded.model, data);
	}
	for (const char *const *name = (const char *const[]){"near", "middle", "tip", "arm", NULL}; *name != NULL; name++) {
		const int joint = vehicle_find_part(car, mjOBJ_JOINT, *name);
		assert_true(fabs(data->qpos[loaded.model->jnt_qposadr[joint]] - 0.2) < 0.02);
	}
	unload(&loaded);
}

static void joints_that_nothing_moves_are_told(void **state)
{
	(void)state;
	support_write(support_path("model.xml"), "<robot name='r'><link name='base'>" INERTIAL("5") "<collision>" BOX("1", "1", ".2") "</collision></link><link name='a'>" INERTIAL("1") "</link>"
						 JOINT("arm", "revolute", "a", "<limit lower='-1' upper='1' effort='9' velocity='1'/>")
						 "<link name='b'>" INERTIAL("1") "</link>" JOINT("hand", "revolute", "b", "<limit lower='-1' upper='1' effort='9' velocity='1'/>") "</robot>");
	struct loaded loaded = load(", driver: {hold: {hand: 0}}", (const char *const[]){"1 joint with limits (arm) has no actuator, and the driver does not name it: it moves freely", NULL});
	unload(&loaded);
}

/* --- surfaces, and where it looks --- */

#define SKID(more) "<mujoco><worldbody><body name='base'><freejoint/><geom name='hull' type='box' size='.4 .3 .1' mass='9'/><geom name='skid' type='sphere' size='.1' pos='.3 0 -.2' " more "/></body></worldbody></mujoco>"

/* MuJoCo's own contact has the condim of the geom with the higher priority: the ground's counts without one. */
static void a_skid_without_friction_slides(void **state)
{
	(void)state;
	static const char note_of_it[] = "car.skid slides on the soil without friction, as its condim 1 and its priority say";
	struct loaded loaded = load_text(SKID("condim='1' priority='1'"), (const char *const[]){note_of_it, NULL});
	struct soil_interface interface = vehicle_surface(&loaded.vehicles->list[0], geom_of(&loaded, "car.skid"));
	assert_true(interface.has_friction && interface.friction_angle == 0 && interface.has_adhesion && interface.adhesion == 0);
	assert_false(vehicle_surface(&loaded.vehicles->list[0], geom_of(&loaded, "car.hull")).has_friction);
	unload(&loaded);
	loaded = load(", interface: {skid: {friction_angle: 20}}", (const char *const[]){NULL});
	interface = vehicle_surface(&loaded.vehicles->list[0], geom_of(&loaded, "car.skid"));
	assert_true(interface.has_friction && fabs(interface.friction_angle - 20 * M_PI / 180) < 1e-9 && strstr(told, "without friction") == NULL);
	unload(&loaded);
	loaded = load(", interface: {skid: rubber}", (const char *const[]){NULL});
	assert_false(vehicle_surface(&loaded.vehicles->list[0], geom_of(&loaded, "car.skid")).has_friction);
	unload(&loaded);
	loaded = load_text(SKID("condim='1'"), (const char *const[]){NULL});
	assert_false(vehicle_surface(&loaded.vehicles->list[0], geom_of(&loaded, "car.skid")).has_friction);
	assert_null(strstr(told, "without friction"));
	unload(&loaded);
}

/* Wheels whose axles look along the way cannot roll along it. */
static void axles_that_look_forward_are_told(void **state)
{
	(void)state;
	static const char path[] = ", driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, drive: [left, right]}", aside[] = "its axles look along its x axis, so it cannot roll along its path; give forward: +y or -y";
	support_write(support_path("model.xml"), "<mujoco><worldbody><body name='base'><freejoint/><geom type='box' size='.3 .4 .1' mass='9'/>"
						 "<body pos='-.4 0 -.1'><joint name='left' axis='1 0 0'/><geom type='cylinder' size='.2 .05' euler='0 90 0' mass='1'/></body>"
						 "<body pos='.4 0 -.1'><joint name='right' axis='1 0 0'/><geom type='cylinder' size='.2 .05' euler='0 90 0' mass='1'/></body></body></worldbody></mujoco>");
	struct loaded loaded = load(path, (const char *const[]){aside, NULL});
	unload(&loaded);
	char keys[256];
	assert_null(strstr(told, "no joint by which"));
	snprintf(keys, sizeof keys, ", forward: +y%s", path);
	loaded = load(keys, (const char *const[]){NULL});
	assert_null(strstr(told, "cannot roll"));
	unload(&loaded);
}

/* A part that others attach to something. */
static void a_root_that_cannot_go_is_told(void **state)
{
	(void)state;
	support_write(support_path("model.xml"), "<mujoco><worldbody><body name='base'><joint name='yaw' axis='0 0 1'/><geom type='box' size='.3 .4 .1' mass='9'/>"
						 "<body pos='0 .4 -.1'><joint name='left' axis='0 1 0'/><geom type='cylinder' size='.2 .05' euler='90 0 0' mass='1'/></body></body></worldbody></mujoco>");
	struct loaded loaded = load(", driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, drive: [left]}",
				    (const char *const[]){"its root body base has no joint by which it could go along its path; give it a free joint", NULL});
	unload(&loaded);
}

/* --- what a model has --- */

static void parts_know_what_they_are_for(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		enum vehicle_role role;
		double radius;
	} wanted[] = {{"drive_l", VEHICLE_ROLE_DRIVES, 0.3}, {"ball_r", VEHICLE_ROLE_DRIVES, 0.3}, {"swing", VEHICLE_ROLE_FOLLOWS, 0}, {"small", VEHICLE_ROLE_FOLLOWS, 0.1},
		      {"link", VEHICLE_ROLE_HOLDS, 0}, {"steering", VEHICLE_ROLE_STEERS, 0}, {"front", VEHICLE_ROLE_DRIVES, 0.3}, {"arm", VEHICLE_ROLE_HOLDS, 0}};
	struct loaded loaded = load_text("<mujoco><worldbody><body name='base'><freejoint/><geom type='box' size='.8 .3 .1' mass='9'/>"
					 "<body pos='0 .4 -.2'><joint name='drive_l' axis='0 1 0'/><geom type='cylinder' size='.3 .05' euler='90 0 0' mass='1'/></body>"
					 "<body pos='0 -.4 -.2'><joint name='ball_r' axis='0 -1 0'/><geom type='sphere' size='.3' mass='1'/></body>"
					 "<body pos='-.7 0 -.3'><joint name='swing' axis='0 0 1'/><geom type='box' size='.02 .02 .02' mass='.1'/>"
					 "<body pos='-.1 0 -.1'><joint name='small' axis='0 1 0'/><geom type='cylinder' size='.1 .02' euler='90 0 0' mass='1'/></body></body>"
					 "<body pos='.3 0 0'><joint name='link' axis='0 0 1'/><geom type='box' size='.02 .02 .02' mass='.1'/><body pos='.4 0 -.2'><joint name='steering' axis='0 0 1' range='-40 40'/><geom type='box' size='.02 .02 .02' mass='.1'/>"
					 "<body><joint name='front' axis='0 1 0'/><geom type='cylinder' size='.3 .05' euler='90 0 0' mass='1'/></body></body></body>"
					 "<body pos='.5 0 .5'><joint name='arm' axis='0 1 0'/><geom type='cylinder' size='.1 .05' euler='90 0 0' mass='1'/></body></body></worldbody></mujoco>",
					 (const char *const[]){NULL});
	assert_int_equal(loaded.info.joint_count, sizeof wanted / sizeof wanted[0]);
	for (size_t i = 0; i < loaded.info.joint_count; i++) {
		struct vehicle_joint joint;
		vehicle_part_joint(loaded.vehicles, 0, i, &joint);
		assert_string_equal(joint.name, wanted[i].name);
		if (joint.role != wanted[i].role || fabs(joint.radius - wanted[i].radius) > 1e-9)
			fail_msg("%s: role %d, radius %g", joint.name, joint.role, joint.radius);
	}
	struct vehicle_size size;
	vehicle_part_size(loaded.vehicles, 0, &size);
	assert_true(size.free && fabs(size.low[2] + 0.5) < 1e-6 && fabs(size.high[0] - 1) < 1e-6);
	unload(&loaded);
}

TEST_PROGRAM(strangers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(meshes_of_one_name_stay_apart),
		cmocka_unit_test(dae_meshes_are_read),
		cmocka_unit_test(packages_are_found_by_their_own_file),
		cmocka_unit_test(a_model_whose_meshes_are_elsewhere_says_so),
		cmocka_unit_test(what_is_only_seen_collides),
		cmocka_unit_test(links_that_are_fixed_and_weigh_nothing_stay_so),
		cmocka_unit_test(texts_that_others_take_are_taken),
		cmocka_unit_test(joints_that_mimic_follow),
		cmocka_unit_test(a_joint_without_its_link_is_refused),
		cmocka_unit_test(links_that_float_are_held),
		cmocka_unit_test(files_that_an_mjcf_lacks_are_left_out),
		cmocka_unit_test(parts_without_a_name_get_one),
		cmocka_unit_test(materials_that_are_not_there_are_left_out),
		cmocka_unit_test(columns_of_a_table_get_servos),
		cmocka_unit_test(servos_of_light_fingers_are_stable),
		cmocka_unit_test(joints_that_nothing_moves_are_told),
		cmocka_unit_test(a_skid_without_friction_slides),
		cmocka_unit_test(axles_that_look_forward_are_told),
		cmocka_unit_test(a_root_that_cannot_go_is_told),
		cmocka_unit_test(parts_know_what_they_are_for),
	};
	return cmocka_run_group_tests_name("models of strangers", tests, support_enter, support_leave);
}
