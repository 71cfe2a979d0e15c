/* The first example of docs/MUJOCO.md runs as it is. */
#include <stdlib.h>

#include "engine.h"

/* Returns the block of a language, which the caller frees. */
static char *block_of(const char *page, const char *language)
{
	char begin[32];
	snprintf(begin, sizeof begin, "```%s\n", language);
	const char *from = strstr(page, begin);
	assert_non_null(from);
	from += strlen(begin);
	const char *end = strstr(from, "```");
	assert_non_null(end);
	return strndup(from, (size_t)(end - from));
}

/* Runs the commands of a block, and looks for what each is to print; ... is anything. */
static void run_console(char *block)
{
	char line[1024], printed[4096] = "";
	for (char *word = strtok(block, "\n"); word != NULL; word = strtok(NULL, "\n")) {
		if (strncmp(word, "$ furrow ", 9) == 0) {
			snprintf(line, sizeof line, "%s %s 2>&1", getenv("FURROW"), word + 9);
			FILE *command = popen(line, "r");
			assert_non_null(command);
			printed[fread(printed, 1, sizeof printed - 1, command)] = '\0';
			assert_int_equal(pclose(command), 0);
		} else if (strcmp(word, "...") != 0) {
			assert_non_null(strstr(printed, word));
		}
	}
}

static void the_rover_of_the_page_drives(void **state)
{
	char path[512], before[512];
	(void)state;
	snprintf(path, sizeof path, "%s/MUJOCO.md", getenv("DOCS"));
	char *page = support_text(path), *console = block_of(page, "console"), *scene = block_of(page, "yaml"), *xml = block_of(page, "xml");
	assert_non_null(getcwd(before, sizeof before));
	assert_int_equal(chdir(support_folder), 0);
	run_console(console);
	support_write("ground.yaml", scene);
	mjModel *model = engine_accepted(xml);
	mjData *data = engine.mj_makeData(model);
	for (int i = 0; i < model->nu; i++)
		data->ctrl[i] = 2;
	engine_run(model, data, 2);
	print_message("%.3f m ahead, %.3f m up; slip %.3f, sinkage %.1f mm, %.1f N\n", data->qpos[0], data->qpos[2], data->sensordata[0], 1e3 * data->sensordata[1], data->sensordata[4]);
	assert_int_equal(model->nsensordata, 5);
	assert_true(data->qpos[0] > 0.3 && data->qpos[0] < 0.6 && fabs(data->qpos[2] - 0.22) < 0.05);
	assert_true(data->sensordata[1] > 0.005 && data->sensordata[1] < 0.05 && data->sensordata[4] > 50);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	assert_int_equal(chdir(before), 0);
	free(xml);
	free(scene);
	free(console);
	free(page);
}

TEST_PROGRAM(pages)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(the_rover_of_the_page_drives)};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
