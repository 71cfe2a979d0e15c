/* What the plugin cannot do it refuses in one line. */
#include <stdlib.h>

#include "engine.h"

static const char *refusal(const char *geoms, const char *more, const char *sensors)
{
	char xml[4096];
	engine_error[0] = '\0';
	snprintf(xml, sizeof xml, "<mujoco>%s<worldbody><body name=\"ball\" pos=\"0 0 0.25\"><freejoint/><plugin plugin=\"furrow.soil\" instance=\"ground\"/>"
				  "<geom name=\"ball\" type=\"sphere\" size=\"0.2\" mass=\"20\"/></body></worldbody>%s</mujoco>", engine_extension(geoms, more), sensors);
	assert_null(engine_model(xml));
	print_message("%s\n", engine_error);
	assert_null(strchr(engine_error, '\n'));
	return engine_error;
}

static void models_that_do_not_fit(void **state)
{
	(void)state;
	engine_store();
	assert_non_null(strstr(refusal("bal", "", ""), "geoms: bal names no geom of a body that moves; the model has: ball"));
	assert_non_null(strstr(refusal(" ", "", ""), "names nothing"));
	assert_non_null(strstr(refusal("ball", "<config key=\"reads\" value=\"slip depth\"/>", "<sensor><plugin plugin=\"furrow.soil\" instance=\"ground\" objtype=\"geom\" objname=\"ball\"/></sensor>"),
			       "reads has a word"));
	assert_non_null(strstr(refusal("ball", "", "<sensor><plugin plugin=\"furrow.soil\" instance=\"ground\" objtype=\"body\" objname=\"ball\"/></sensor>"), "no geom that presses"));
}

static void one_instance(void **state)
{
	char more[512];
	(void)state;
	engine_store();
	snprintf(more, sizeof more, "</instance><instance name=\"other\"><config key=\"scene\" value=\"" ENGINE_SCENE "\"/><config key=\"store\" value=\"%s\"/>",
		 support_path("ground.furrow"));
	assert_non_null(strstr(refusal("ball", more, ""), "several instances"));
}

/* Without an overlay the ruts would go into the terrain. */
static void no_folder_for_the_ruts(void **state)
{
	char *const before = getenv("TMPDIR") != NULL ? strdup(getenv("TMPDIR")) : NULL;
	(void)state;
	engine_store();
	setenv("TMPDIR", support_path("missing"), 1);
	assert_non_null(strstr(refusal("ball", "", ""), "set TMPDIR to a folder that can be written, or give its key overlay"));
	if (before != NULL)
		setenv("TMPDIR", before, 1);
	else
		unsetenv("TMPDIR");
	free(before);
}

/* Makes a step that is refused. Returns why. */
static const char *step_refusal(mjModel *model, mjData *data)
{
	const char *told = engine_refuses(model, data, 100);
	print_message("%s\n", told);
	return told;
}

static void steps_that_cannot_be(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("", "", "", "");
	mjData *data = engine.mj_makeData(model);
	data->qpos[0] = -50;
	assert_non_null(strstr(step_refusal(model, data), "ball"));
	engine.mj_deleteData(data);
	model->opt.disableflags |= mjDSBL_SPRING | mjDSBL_DAMPER;
	data = engine.mj_makeData(model);
	assert_non_null(strstr(step_refusal(model, data), "no passive force"));
	model->opt.disableflags = 0;
	model->opt.enableflags |= mjENBL_SLEEP;
	engine.mj_resetData(model, data);
	assert_non_null(strstr(step_refusal(model, data), "leave the flag sleep out"));
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

TEST_PROGRAM(refusals)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(models_that_do_not_fit), cmocka_unit_test(one_instance), cmocka_unit_test(no_folder_for_the_ruts), cmocka_unit_test(steps_that_cannot_be)};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
