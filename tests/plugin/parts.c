/* What of a scene's vehicles the plugin's instance has, too: tyres, and geoms that carry soil. */
#include <stdlib.h>

#include "../support/near.h"
#include "engine.h"

#define GRAVITY 9.80665

/* --- tyres --- */

static mjModel *on_concrete(const char *keys)
{
	char xml[4096];
	engine_store();
	snprintf(xml, sizeof xml,
		 "<mujoco><option timestep=\"0.002\" integrator=\"implicit\" gravity=\"0 0 -9.80665\"/><extension><plugin plugin=\"furrow.soil\"><instance name=\"ground\">"
		 "<config key=\"scene\" value=\"{scene: 1, spacing: 0.0625, soil: {name: concrete}, redistribute: {model: scm}}\"/><config key=\"store\" value=\"%s\"/>"
		 "<config key=\"origin\" value=\"10 10.5\"/>%s</instance></plugin></extension><worldbody><body name=\"cart\" pos=\"0 0 0.301\">"
		 "<plugin plugin=\"furrow.soil\" instance=\"ground\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"90\" diaginertia=\"1 1 1\"/>"
		 "<body name=\"wheel\"><joint name=\"turn\" axis=\"0 1 0\"/><inertial pos=\"0 0 0\" mass=\"10\" diaginertia=\"0.5 0.5 0.5\"/>"
		 "<geom name=\"wheel\" type=\"cylinder\" size=\"0.3 0.1\" euler=\"90 0 0\"/></body></body></worldbody></mujoco>",
		 support_path("ground.furrow"), keys);
	return engine_model(xml);
}

static double rests_at(const char *keys)
{
	mjModel *model = on_concrete(keys);
	if (model == NULL)
		print_error("%s\n", engine_error);
	assert_non_null(model);
	mjData *data = engine.mj_makeData(model);
	engine_run(model, data, 6);
	const double height = 0.301 + data->qpos[0];
	print_message("%s: its axle rests at %.2f mm, at %.2g m/s\n", keys, 1e3 * height, fabs(data->qvel[0]));
	assert_true(fabs(data->qvel[0]) < 1e-3);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	return height;
}

#define TYRES(text) "<config key=\"tyres\" value=\"" text "\"/>"

static void a_tyre_gives_way_as_told(void **state)
{
	(void)state;
	const double rigid = rests_at(""), tyre = rests_at(TYRES("wheel stiffness 50000 load 980.665"));
	assert_near((0.3 - tyre) / (100 * GRAVITY / 50000), 1, 0.02);
	assert_true(rigid > 0.299); /* on concrete */
}

static const char *refusal(const char *keys)
{
	engine_error[0] = '\0';
	assert_null(on_concrete(keys));
	return engine_error;
}

static void what_it_has_not_is_told(void **state)
{
	(void)state;
	assert_non_null(strstr(refusal(TYRES("wheel stiffness 50000")), "has no stiffness or no load; give each as PATTERN stiffness N/m load N"));
	assert_non_null(strstr(refusal(TYRES("wheel hardness 3 load 1")), "hardness 3 is not understood"));
	assert_non_null(strstr(refusal(TYRES("wheel stiffness -2 load 1")), "stiffness -2 is out of range"));
	assert_non_null(strstr(refusal(TYRES("leg stiffness 5e4 load 900")), "leg names no wheel"));
	assert_non_null(strstr(refusal(TYRES("wheel stiffness 1000 load 900")), "wheel"));
	assert_non_null(strstr(refusal("<config key=\"carry\" value=\"wheel\"/>"), "soil rolls off"));
	assert_non_null(strstr(refusal("<config key=\"carry\" value=\"bucket\"/>"), "bucket names no geom"));
	assert_non_null(strstr(refusal("<config key=\"powertrain\" value=\"{}\"/>"), "it has no powertrain and no brakes"));
	assert_non_null(strstr(refusal("<config key=\"brakes\" value=\"500\"/>"), "a vehicle of a scene"));
}

/* --- soil aboard --- */

/* Times, s, and places of its three joints: it digs, lifts, and holds still. */
static const double controls[][4] = {{0, 0, 0, 0}, {0.5, 0, 0.06, 0.35}, {1.5, 0.3, -0.08, 0.35}, {3, 1.0, -0.1, 0.05}, {3.5, 1.05, 0.3, 0}, {9, 1.05, 0.3, 0}};

static void control(mjData *data)
{
	size_t k = 0;
	while (data->time >= controls[k + 1][0])
		k++;
	const double share = (data->time - controls[k][0]) / (controls[k + 1][0] - controls[k][0]);
	for (int i = 0; i < 3; i++)
		data->ctrl[i] = controls[k][1 + i] * (1 - share) + controls[k + 1][1 + i] * share;
}

static mjModel *digger(const char *keys)
{
	char path[512], xml[8192];
	engine_store();
	snprintf(path, sizeof path, "%s/tray.xml", getenv("MODELS"));
	char *text = support_text(path), *world = strstr(text, "<worldbody>"), *joint = strstr(text, "<joint name=\"along\""), *end = strstr(text, "</mujoco>");
	assert_true(world != NULL && joint != NULL && end != NULL);
	snprintf(xml, sizeof xml,
		 "%.*s<extension><plugin plugin=\"furrow.soil\"><instance name=\"ground\"><config key=\"scene\" value=\"{scene: 1, spacing: 0.0625, "
		 "soil: {name: dry_sand, damping: 30000}, redistribute: {model: scm}}\"/><config key=\"store\" value=\"%s\"/><config key=\"geoms\" value=\"tray\"/>"
		 "<config key=\"reads\" value=\"carried\"/><config key=\"origin\" value=\"10 10.5 -0.17\"/>%s</instance></plugin></extension>%.*s"
		 "<plugin plugin=\"furrow.soil\" instance=\"ground\"/>%.*s<sensor><plugin plugin=\"furrow.soil\" instance=\"ground\" objtype=\"geom\" objname=\"tray\"/></sensor></mujoco>",
		 (int)(world - text), text, support_path("ground.furrow"), keys, (int)(joint - world), world, (int)(end - joint), joint);
	free(text);
	return engine_accepted(xml);
}

struct aboard {
	double volume, pull; /* m3; N, of the hoist that holds still */
};

static struct aboard dig(const mjModel *model, mjData *data)
{
	while (data->time < 4.999) {
		control(data);
		engine.mj_step(model, data);
	}
	print_message("%.1f l aboard; the hoist pulls %.2f N\n", 1e3 * data->sensordata[0], data->actuator_force[1]);
	return (struct aboard){data->sensordata[0], data->actuator_force[1]};
}

static void a_tray_is_as_heavy_as_its_soil(void **state)
{
	(void)state;
	mjModel *model = digger(""), *carrying = digger("<config key=\"carry\" value=\"tray\"/>");
	mjData *data = engine.mj_makeData(model), *laden = engine.mj_makeData(carrying);
	const struct aboard empty = dig(model, data), full = dig(carrying, laden);
	assert_true(empty.volume == 0 && fabs(empty.pull - 50 * 9.81) < 1); /* the model has MuJoCo's own gravity */
	assert_true(full.volume > 0.005);
	const double density = (full.pull - empty.pull) / (full.volume * GRAVITY);
	print_message("%.0f kg/m3\n", density);
	assert_true(density > 1300 && density < 1800);
	/* A reset empties it, and what follows is the same to the bit. */
	engine.mj_resetData(carrying, laden);
	engine.mj_step(carrying, laden);
	assert_true(laden->sensordata[0] == 0);
	engine.mj_resetData(carrying, laden);
	const struct aboard again = dig(carrying, laden);
	assert_memory_equal(&again, &full, sizeof full);
	engine.mj_deleteData(laden);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(carrying);
	engine.mj_deleteModel(model);
}

static void soil_aboard_is_told_where_ruts_are_kept(void **state)
{
	char keys[700];
	(void)state;
	for (int keeps = 0; keeps < 2; keeps++) {
		snprintf(keys, sizeof keys, keeps ? "<config key=\"carry\" value=\"tray\"/><config key=\"overlay\" value=\"%s\"/>" : "<config key=\"carry\" value=\"tray\"/>",
			 support_path("kept.furrow"));
		mjModel *model = digger(keys);
		mjData *data = engine.mj_makeData(model);
		const struct aboard full = dig(model, data);
		engine_warning[0] = '\0';
		engine.mj_deleteData(data);
		engine.mj_deleteModel(model);
		const char *told = strstr(engine_warning, "l of soil lie on geoms that carry");
		assert_true(keeps ? told != NULL && fabs(strtod(engine_warning + strlen("furrow.soil: "), NULL) - 1e3 * full.volume) < 0.01e3 * full.volume : told == NULL);
	}
}

TEST_PROGRAM(parts)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(a_tyre_gives_way_as_told), cmocka_unit_test(what_it_has_not_is_told), cmocka_unit_test(a_tray_is_as_heavy_as_its_soil),
					   cmocka_unit_test(soil_aboard_is_told_where_ruts_are_kept)};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
