/* mj_resetData goes back to the ground at the start, without end; copies and second datas have a ground of their own. */
#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "../long.h"
#include "engine.h"

/* What a short episode ends with. */
struct end {
	double qpos[7], qvel[6];
};

static struct end episode(const mjModel *model, mjData *data, double push)
{
	struct end end;
	engine.mj_resetData(model, data);
	data->qpos[2] = 0.199;
	data->qvel[0] = push;
	engine_run(model, data, 0.05);
	memcpy(end.qpos, data->qpos, sizeof end.qpos);
	memcpy(end.qvel, data->qvel, sizeof end.qvel);
	return end;
}

static long resident_kilobytes(void)
{
	long pages = 0, resident = 0;
	FILE *file = fopen("/proc/self/statm", "r");
	assert_non_null(file);
	assert_int_equal(fscanf(file, "%ld %ld", &pages, &resident), 2);
	fclose(file);
	return resident * 4;
}

static long bytes_of(const char *path)
{
	static const char *const ends[] = {"", "-wal"};
	long sum = 0;
	for (int i = 0; i < 2; i++) {
		char name[256];
		struct stat is;
		snprintf(name, sizeof name, "%s%s", path, ends[i]);
		sum += stat(name, &is) == 0 ? (long)is.st_size : 0;
	}
	return sum;
}

static mjModel *kept_ball(void)
{
	char more[256];
	snprintf(more, sizeof more, "<config key=\"overlay\" value=\"%s\"/>", support_path("run.furrow"));
	mjModel *model = engine_ball("timestep=\"0.005\"", more, "", "");
	assert_non_null(model);
	return model;
}

static void a_reset_is_the_start_again(void **state)
{
	const int count = long_run() ? 10000 : 1000;
	(void)state;
	engine_store();
	mjModel *model = kept_ball();
	mjData *data = engine.mj_makeData(model);
	const struct end first = episode(model, data, 0.5);
	assert_true(first.qpos[0] > 0.01 && first.qpos[2] < 0.199);
	long memory = 0, file = 0;
	for (int i = 0; i < count; i++) {
		const struct end end = episode(model, data, 0.5);
		assert_memory_equal(&end, &first, sizeof end);
		if (i == count / 10) {
			memory = resident_kilobytes();
			file = bytes_of(support_path("run.furrow"));
		}
	}
	print_message("%d resets: %ld kB more, and a file of %ld bytes after %ld\n", count, resident_kilobytes() - memory, bytes_of(support_path("run.furrow")), file);
	assert_true(resident_kilobytes() - memory < 1024);
	assert_true(bytes_of(support_path("run.furrow")) <= file);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

/* Returns how many folders of ours are in TMPDIR, which is this test's own. */
static int own_folders(void)
{
	int count = 0;
	DIR *folder = opendir(support_folder);
	for (const struct dirent *entry; folder != NULL && (entry = readdir(folder)) != NULL;)
		count += strncmp(entry->d_name, "furrow-", 7) == 0;
	closedir(folder);
	return count;
}

static void a_second_data_has_a_ground_of_its_own(void **state)
{
	(void)state;
	engine_store();
	setenv("TMPDIR", support_folder, 1);
	unlink(support_path("run.furrow"));
	mjModel *model = kept_ball();
	mjData *one = engine.mj_makeData(model), *other = engine.mj_makeData(model);
	assert_int_equal(own_folders(), 1);
	const struct end first = episode(model, one, 0.5);
	engine_run(model, one, 1);
	const struct end second = episode(model, other, 0.5);
	assert_memory_equal(&second, &first, sizeof first);
	engine.mj_deleteData(other);
	assert_int_equal(own_folders(), 0);
	engine.mj_deleteData(one);
	assert_int_equal(access(support_path("run.furrow"), F_OK), 0);
	engine.mj_deleteModel(model);
}

static void a_copy_of_a_rutted_ground_is_refused(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.005\"", "", "", "");
	mjData *one = engine.mj_makeData(model), *other = engine.mj_makeData(model);
	engine.mj_copyData(other, model, one); /* both have the ground of the start */
	engine_run(model, other, 0.1);
	engine_run(model, one, 0.1);
	assert_memory_equal(one->qpos, other->qpos, 7 * sizeof(double));
	engine.mj_copyData(other, model, one);
	assert_non_null(strstr(engine_refuses(model, other, 1), "the ground is not copied with it; call mj_resetData on it"));
	const struct end again = episode(model, other, 0.5), first = episode(model, one, 0.5);
	assert_memory_equal(&again, &first, sizeof first);
	engine.mj_deleteData(other);
	engine.mj_deleteData(one);
	engine.mj_deleteModel(model);
}

/* What sets states and calls no reset, as rollouts do: at the time of the start it is one. */
static void a_time_that_goes_back(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.005\"", "", "", "");
	mjData *data = engine.mj_makeData(model);
	const struct end first = episode(model, data, 0.5);
	engine_run(model, data, 0.5);
	memcpy(data->qpos, model->qpos0, 7 * sizeof(double));
	memset(data->qvel, 0, 6 * sizeof(double));
	memset(data->qacc_warmstart, 0, 6 * sizeof(double));
	data->time = 0;
	data->qpos[2] = 0.199;
	data->qvel[0] = 0.5;
	engine_run(model, data, 0.05);
	assert_memory_equal(data->qpos, first.qpos, sizeof first.qpos);
	data->time = 0.01;
	assert_non_null(strstr(engine_refuses(model, data, 1), "the time went back to 0.01 s"));
	data->time = 7;
	assert_non_null(strstr(engine_refuses(model, data, 1), "the time went on to 7 s"));
	/* Also where the step's start was computed already. */
	engine.mj_resetData(model, data);
	engine_run(model, data, 0.05);
	engine.mj_forward(model, data);
	data->time = 7;
	assert_non_null(strstr(engine_refuses(model, data, 1), "the time went on to 7 s from 0.05 s"));
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

/* Whoever puts a body elsewhere makes no rut on its way. */
static void a_body_is_put_elsewhere(void **state)
{
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.002\"", "", "", "");
	mjData *data = engine.mj_makeData(model), *fresh = engine.mj_makeData(model);
	data->qpos[2] = 0.19;
	engine_run(model, data, 0.5);
	for (int k = 0; k < 2; k++) {
		mjData *at = k == 0 ? data : fresh;
		at->qpos[0] = 5; /* it would make a rut of 5 m on its way */
		at->qpos[1] = 0;
		at->qpos[2] = 0.19;
		memset(at->qvel, 0, 6 * sizeof(double));
		at->qpos[3] = 1;
		memset(at->qpos + 4, 0, 3 * sizeof(double));
		engine_run(model, at, 0.5);
	}
	print_message("it rests at %.6f and %.6f m\n", data->qpos[2], fresh->qpos[2]);
	assert_true(fabs(data->qpos[2] - fresh->qpos[2]) < 1e-4 && fabs(data->qpos[0] - 5) < 1e-3);
	engine.mj_deleteData(data);
	engine.mj_deleteData(fresh);
	engine.mj_deleteModel(model);
}

/* The same episode in two processes: this program again, for that. */
static void two_processes_have_the_same_bits(void **state)
{
	char told[2][2048];
	(void)state;
	engine_store();
	mjModel *model = engine_ball("timestep=\"0.002\"", "", "", "");
	mjData *data = engine.mj_makeData(model);
	if (getenv("FURROW_EPISODE") != NULL) {
		data->qvel[0] = 0.4;
		engine_run(model, data, 0.4);
		printf("episode");
		for (int i = 0; i < 7; i++)
			printf(" %a", data->qpos[i]);
		printf("\n");
	}
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	if (getenv("FURROW_EPISODE") != NULL)
		return;
	setenv("FURROW_EPISODE", "1", 1);
	for (int i = 0; i < 2; i++) {
		char line[2048];
		told[i][0] = '\0';
		snprintf(line, sizeof line, "/proc/%ld/exe resets two_processes_have_the_same_bits", (long)getpid());
		FILE *other = popen(line, "r");
		assert_non_null(other);
		while (fgets(line, sizeof line, other) != NULL)
			if (strncmp(line, "episode", 7) == 0)
				memcpy(told[i], line, sizeof line);
		assert_int_equal(pclose(other), 0);
	}
	unsetenv("FURROW_EPISODE");
	assert_true(strlen(told[0]) > 40);
	assert_string_equal(told[0], told[1]);
}

TEST_PROGRAM(resets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_reset_is_the_start_again),
		cmocka_unit_test(a_second_data_has_a_ground_of_its_own),
		cmocka_unit_test(a_copy_of_a_rutted_ground_is_refused),
		cmocka_unit_test(a_time_that_goes_back),
		cmocka_unit_test(a_body_is_put_elsewhere),
		cmocka_unit_test(two_processes_have_the_same_bits),
	};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
