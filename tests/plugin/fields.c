/* A height field of the model follows the ground. */
#include "engine.h"

#define FIELD "<asset><hfield name=\"terrain\" nrow=\"41\" ncol=\"81\" size=\"2 1 1 0.1\"/></asset>"
#define GEOM(more) "<geom name=\"ground\" type=\"hfield\" hfield=\"terrain\" pos=\"0 0 -0.5\" " more "/>"

static float *points(const mjModel *model)
{
	return model->hfield_data + model->hfield_adr[0];
}

static void a_field_shows_the_rut(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.002\"", "<config key=\"hfield\" value=\"terrain\"/>", GEOM("contype=\"0\" conaffinity=\"0\""), FIELD);
	if (model == NULL)
		print_error("%s\n", engine_error);
	assert_non_null(model);
	mjData *data = engine.mj_makeData(model);
	/* The ground is at 0, and the field's zero at -0.5 m. */
	for (int i = 0; i < 41 * 81; i++)
		assert_true(fabsf(points(model)[i] - 0.5f) < 1e-6f);
	engine_run(model, data, 1);
	const float middle = points(model)[20 * 81 + 40];
	print_message("below the ball: %.2f mm, where the ball is %.2f mm deep\n", 1e3 * ((double)middle - 0.5), 1e3 * (data->qpos[2] - 0.2));
	assert_true(fabs((double)middle - 0.5 - (data->qpos[2] - 0.2)) < 0.004 && (double)middle < 0.49);
	assert_true(fabsf(points(model)[0] - 0.5f) < 1e-6f);
	engine.mj_resetData(model, data);
	for (int i = 0; i < 41 * 81; i++)
		assert_true(fabsf(points(model)[i] - 0.5f) < 1e-6f);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

/* A copy gets the ground of the start, and so does what its viewer shows. */
static void a_copy_shows_no_ruts(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.002\"", "<config key=\"hfield\" value=\"terrain\"/>", GEOM("contype=\"0\" conaffinity=\"0\""), FIELD);
	assert_non_null(model);
	mjData *shown = engine.mj_makeData(model), *other = engine.mj_makeData(model);
	engine_run(model, shown, 1);
	const float deep = points(model)[20 * 81 + 40];
	assert_true(deep < 0.49f);
	engine.mj_copyData(shown, model, other);
	for (int i = 0; i < 41 * 81; i++)
		assert_true(fabsf(points(model)[i] - 0.5f) < 1e-6f);
	/* It goes on to be brought up to date, although its world's time is earlier now. */
	engine_run(model, shown, 0.9);
	assert_true(fabsf(points(model)[20 * 81 + 40] - deep) < 0.01f);
	engine.mj_deleteData(other);
	engine.mj_deleteData(shown);
	engine.mj_deleteModel(model);
}

/* Writes the file of a level skin with 81 x 41 vertices, 5 cm apart, that hang on a body. */
static const char *skin_file(const char *body)
{
	const char *path = support_path("ground.skn");
	FILE *file = fopen(path, "wb");
	const int columns = 81, rows = 41, count = columns * rows, head[4] = {count, 0, 2 * (columns - 1) * (rows - 1), 1};
	char name[40] = "";
	assert_non_null(file);
	fwrite(head, sizeof head, 1, file);
	for (int i = 0; i < count; i++)
		fwrite((const float[3]){0.05f * (float)(i % columns - 40), 0.05f * (float)(i / columns - 20), 0}, sizeof(float), 3, file);
	for (int i = 0; i < count - columns; i++)
		if (i % columns < columns - 1)
			fwrite((const int[6]){i, i + 1, i + 1 + columns, i, i + 1 + columns, i + columns}, sizeof(int), 6, file);
	snprintf(name, sizeof name, "%s", body);
	fwrite(name, sizeof name, 1, file);
	fwrite((const float[7]){0, 0, 0, 1, 0, 0, 0}, sizeof(float), 7, file);
	fwrite(&count, sizeof count, 1, file);
	for (int i = 0; i < count; i++)
		fwrite(&i, sizeof i, 1, file);
	for (int i = 0; i < count; i++)
		fwrite(&(const float){1}, sizeof(float), 1, file);
	fclose(file);
	return path;
}

static mjModel *skinned(const char *body, const char *key)
{
	char skin[600];
	snprintf(skin, sizeof skin, "<deformable><skin name=\"terrain\" file=\"%s\"/></deformable>", skin_file(body));
	return engine_ball("timestep=\"0.002\"", key, "", skin);
}

#define SKIN "<config key=\"skin\" value=\"terrain\"/>"

/* Viewers take its vertices for each picture, so nothing has to be told to them. */
static void a_skin_shows_the_rut(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = skinned("world", SKIN);
	if (model == NULL)
		print_error("%s\n", engine_error);
	assert_non_null(model);
	mjData *data = engine.mj_makeData(model);
	engine_run(model, data, 1);
	const float middle = model->skin_vert[3 * (20 * 81 + 40) + 2];
	print_message("below the ball: %.2f mm, where the ball is %.2f mm deep\n", 1e3 * (double)middle, 1e3 * (data->qpos[2] - 0.2));
	assert_true(fabs((double)middle - (data->qpos[2] - 0.2)) < 0.004 && (double)middle < -0.01);
	assert_true(fabsf(model->skin_vert[2]) < 1e-6f && fabsf(model->skin_vert[3 * (20 * 81 + 40)]) < 1e-6f);
	engine.mj_resetData(model, data);
	for (int i = 0; i < 41 * 81; i++)
		assert_true(fabsf(model->skin_vert[3 * i + 2]) < 1e-6f);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	assert_null(skinned("ball", SKIN));
	assert_non_null(strstr(engine_error, "that is not the world"));
	assert_null(skinned("world", "<config key=\"skin\" value=\"terain\"/>"));
	assert_non_null(strstr(engine_error, "names no skin"));
}

/* Makes a model that is refused. Returns why. */
static const char *refusal(const char *world, const char *more)
{
	engine_error[0] = '\0';
	assert_null(engine_ball("", more, world, FIELD));
	return engine_error;
}

static void a_field_that_cannot_follow_is_refused(void **state)
{
	(void)state;
	engine_store();
	assert_non_null(strstr(refusal(GEOM(""), "<config key=\"hfield\" value=\"terrain\"/>"), "collides"));
	assert_non_null(strstr(refusal(GEOM("euler=\"0 0 10\" contype=\"0\" conaffinity=\"0\""), "<config key=\"hfield\" value=\"terrain\"/>"), "turned"));
	assert_non_null(strstr(refusal(GEOM("contype=\"0\" conaffinity=\"0\""), "<config key=\"hfield\" value=\"terain\"/>"), "names no height field"));
}

TEST_PROGRAM(fields)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(a_field_shows_the_rut), cmocka_unit_test(a_skin_shows_the_rut), cmocka_unit_test(a_copy_shows_no_ruts), cmocka_unit_test(a_field_that_cannot_follow_is_refused)};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
