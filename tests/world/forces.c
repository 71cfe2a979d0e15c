/* objects.csv: its rows are those that were asked for, whatever the time step, the delay, and where the drive was cut. */
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

static const struct extent extent = {129, 129, 0.25, 64};

static const char scene_text[] =
	"scene: 1\ntime_step: 0.05\nend_time: 1.5\nspacing: 0.0625\n"
	"soil: {name: dry_sand}\nredistribute: {model: scm}\noutput: {forces: 8}\noutside: skip\n"
	"objects:\n"
	"  - {name: driven, shape: {wheel: {radius: 0.5, width: 0.4}}, load: 3000, slip: 0.3,\n"
	"     path: {points: [[5, 5], [9, 6]], speed: 2}}\n"
	"  - {name: resting, shape: {box: {size: [0.5, 0.5, 0.5]}}, load: 2000, path: {points: [[12, 12]], speed: 1}}\n"
	"  - {name: leaving, shape: {sphere: {radius: 0.4}}, sink: 0.1, path: {points: [[30, 20], [34, 20]], speed: 4}}\n";

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 10;
}

static char *text_of(const char *path)
{
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	char *text = calloc(1, 1 << 16);
	assert_non_null(text);
	size_t got = fread(text, 1, (1 << 16) - 1, file);
	assert_true(got < (1 << 16) - 1);
	fclose(file);
	return text;
}

static volatile sig_atomic_t stopped; /* a drive ends before its first step */

static struct drive_result drive(const char *store, const char *out, bool resume, int64_t steps, const char *const settings[][2])
{
	struct scene_setting split[8] = {{NULL, NULL}};
	size_t count = 0;
	for (; settings != NULL && settings[count][0] != NULL; count++)
		split[count] = (struct scene_setting){settings[count][0], settings[count][1]};
	const char *path = support_path("scene.yaml");
	struct scene *scene;
	support_write(path, scene_text);
	must(scene_load(path, split, count, &scene));
	struct drive_params params = {.scene = scene, .store = store, .directory = out, .resume = resume, .steps = steps, .stop = &stopped};
	struct drive_result result;
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	assert_int_equal(status, stopped ? STATUS_INTERRUPTED : STATUS_OK);
	return result;
}

static char *rows(const char *name, const char *const settings[][2])
{
	char file[64];
	const char *store = support_path("world.furrow"), *out = support_path(name);
	support_store(store, extent, flat);
	mem_free(drive(store, out, false, 0, settings).json);
	snprintf(file, sizeof file, "%s/objects.csv", name);
	return text_of(support_path(file));
}

struct row {
	double t, x, y, z, sinkage, force[3], moment[3], slip, area;
	char name[16], load[16], soil[16], state[16]; /* as they stand there; "": nothing does */
	double residual;
};

static size_t parse(const char *text, struct row *out)
{
	size_t count = 0;
	text = strchr(text, '\n') + 1;
	for (; *text != '\0'; text = strchr(text, '\n') + 1, count++) {
		struct row *r = &out[count];
		int at = 0;
		memset(r, 0, sizeof *r); /* rows are compared whole */
		assert_int_equal(sscanf(text, "%lf,%15[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%n", &r->t, r->name, &r->x,
					&r->y, &r->z, &r->sinkage, &r->force[0], &r->force[1], &r->force[2], &r->moment[0],
					&r->moment[1], &r->moment[2], &r->slip, &r->area, &at), 14);
		assert_true(at > 0);
		size_t load = strcspn(text + at, ",\n"), soil = strcspn(text + at + load + 1, ",\n");
		const char *rest = text + at + load + 1 + soil;
		assert_true(text[at + (int)load] == ',' && *rest == ',');
		assert_int_equal(sscanf(rest, ",%15[^,],%lf", r->state, &r->residual), 2);
		snprintf(r->load, sizeof r->load, "%.*s", (int)load, text + at);
		snprintf(r->soil, sizeof r->soil, "%.*s", (int)soil, text + at + load + 1);
	}
	return count;
}

static void each_object_has_its_row_at_each_time(void **state)
{
	static const char *const names[] = {"driven", "resting", "leaving"};
	struct row all[64];
	(void)state;
	char *text = rows("out", NULL);
	assert_memory_equal(text, "t,name,x,y,z,sinkage,fx,fy,fz,tx,ty,tz,slip,contact_area,load,soil,state,residual\n", 82);
	assert_int_equal(parse(text, all), 13 * 3);
	for (int i = 0; i < 39; i++) {
		const struct row *r = &all[i];
		assert_true(r->t == i / 3 / 8.0);
		assert_string_equal(r->name, names[i % 3]);
		assert_string_equal(r->load, i % 3 == 0 ? "3000" : i % 3 == 1 ? "2000" : "");
		assert_string_equal(r->soil, r->x > 32.03 ? "" : "dry_sand");
		assert_string_equal(r->state, i % 3 == 2 && r->x > 32 ? "air" : "touching");
		/* The ground is level, so that is the drawbar pull: they head east, but the first. */
		const double yaw = i % 3 == 0 ? atan2(r->y - 5, r->x - 5) : 0, pull = r->force[0] * cos(yaw) + r->force[1] * sin(yaw);
		assert_true(fabs(r->residual + pull) <= 1e-6 * fabs(pull) + 1e-3);
		if (i % 3 == 0) {
			double way = 2 * r->t, along = r->x - 5;
			assert_true(hypot(r->x - 5, r->y - 5) <= way + 1e-6 && hypot(r->x - 5, r->y - 5) > way - 0.0626);
			/* Normal stress and shear together bear it, also where the ground that it meets is heaped. */
			if (!(fabs(r->force[2] - 3000) < 0.4 && fabs(r->z - 10.46) < 0.04))
				fail_msg("at %g s: %g N at %g m", r->t, r->force[2], r->z);
			assert_true(r->slip == 0.3 && along >= 0 && r->area > 0);
			/* It pulls. */
			assert_true(i < 3 || (r->force[0] > 0 && r->force[1] > 0 && r->moment[1] < 0));
		} else if (i % 3 == 1) {
			assert_true(fabs(r->force[2] - 2000) < 0.4 && fabs(r->z - (10.25 - r->sinkage)) < 1e-6);
			assert_memory_equal(r->force, all[1].force, sizeof r->force);
			assert_memory_equal(r->moment, all[1].moment, sizeof r->moment);
		} else if (r->x > 32) {
			assert_true(r->force[2] == 0 && r->area == 0 && r->sinkage == 0);
		} else {
			assert_true(r->force[2] > 0 && r->area > 0);
		}
	}
	free(text);
}

static void rows_do_not_depend_on_the_time_step(void **state)
{
	(void)state;
	char *own = rows("out", NULL);
	char *finer = rows("out", (const char *const[][2]){{"time_step", "0.003"}, {NULL, NULL}});
	char *coarser = rows("out", (const char *const[][2]){{"time_step", "0.7"}, {NULL, NULL}});
	assert_string_equal(own, finer);
	assert_string_equal(own, coarser);
	free(own);
	free(finer);
	free(coarser);
}

/* A smooth rim pulls less, whatever it carries. Other objects' rows stay as they are. */
static void a_surface_changes_the_forces_of_its_object_alone(void **state)
{
	static const char *const smooth[][2] = {{"objects.driven.interface.friction_angle", "12"}, {NULL, NULL}};
	struct row rough_rows[64], smooth_rows[64];
	(void)state;
	char *without = rows("out", NULL), *with = rows("out", smooth);
	assert_int_equal(parse(without, rough_rows), 13 * 3);
	assert_int_equal(parse(with, smooth_rows), 13 * 3);
	for (int i = 0; i < 13 * 3; i++) {
		const struct row *a = &rough_rows[i], *b = &smooth_rows[i];
		if (i % 3 != 0) {
			assert_memory_equal(a, b, sizeof *a);
			continue;
		}
		assert_true(fabs(b->force[2] - 3000) < 0.4);
		/* Shear helps to carry it. */
		assert_true(i < 9 || (b->sinkage > a->sinkage && b->force[0] < a->force[0] - 200 && b->moment[1] > a->moment[1] + 50));
	}
	free(without);
	free(with);
	char *json = drive(support_path("world.furrow"), support_path("told"), false, 4, smooth).json;
	assert_non_null(strstr(json, "\"interface\":"));
	assert_int_equal(support_figure(json, "\"interface\"", "friction_angle"), 12);
	mem_free(json);
}

/* Lunar west of 6.875 m, which is half-way between two pixels: the first object drives across. */
static const char *const on_a_map[][2] = {{"soil", "{map: soils.png, classes: {7: lunar}, default: dry_sand}"}, {NULL, NULL}};

static void write_classes(void)
{
	const struct dem_raster raster = {.path = support_path("soils.png"), .width = 129, .height = 129, .type = DEM_UINT8, .spacing = 1};
	struct dem_writer *writer;
	double row[129];
	for (int x = 0; x < 129; x++)
		row[x] = x < 28 ? 7 : 1;
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 129; y++)
		must(dem_writer_rows(writer, 1, row));
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
}

static void on_a_map_each_row_says_the_soil_under_its_object(void **state)
{
	struct row all[64];
	int lunar = 0, sand = 0;
	(void)state;
	write_classes();
	char *text = rows("out", on_a_map);
	assert_int_equal(parse(text, all), 13 * 3);
	for (int i = 0; i < 39; i++) {
		const struct row *r = &all[i];
		if (r->x > 32.03) {
			assert_string_equal(r->soil, "");
		} else if (fabs(r->x - 6.875) > 0.0313) {
			assert_string_equal(r->soil, r->x < 6.875 ? "lunar" : "dry_sand");
			lunar += r->x < 6.875;
			sand += r->x > 6.875 && i % 3 == 0;
		}
	}
	assert_true(lunar > 3 && sand > 3);
	free(text);
}

static void cut_and_gone_on_with(const char *const settings[][2], const char *const later[][2])
{
	char *whole = rows("out", settings);
	static const int cuts[] = {0, 1, 8, 15, 22, 29};
	for (size_t i = 0; i < sizeof cuts / sizeof *cuts; i++) {
		const char *store = support_path("world.furrow");
		support_store(store, extent, flat);
		stopped = cuts[i] == 0;
		mem_free(drive(store, support_path("cut"), false, cuts[i], later).json);
		stopped = 0;
		/* What a kill may leave behind: rows beyond the commit, and a torn one. */
		FILE *file = fopen(support_path("cut/objects.csv"), "a");
		assert_non_null(file);
		if (cuts[i] == 0)
			fputs("0,driven,1,2,3,4,5,6,7,8,9,10,11,12,13,lunar\n", file);
		fputs("9.5,driven,1,2,3,4,5,6,7,8,9,10,11,12,13,lunar\n9.625,driven,1,2", file);
		fclose(file);
		mem_free(drive(store, support_path("cut"), true, 0, settings).json);
		char *text = text_of(support_path("cut/objects.csv"));
		assert_string_equal(text, whole);
		free(text);
	}
	free(whole);
}

static void a_drive_that_is_cut_goes_on_with_the_same_rows(void **state)
{
	(void)state;
	cut_and_gone_on_with(NULL, NULL);
	write_classes();
	cut_and_gone_on_with(on_a_map, on_a_map);
}

static void without_rows_there_is_no_file_and_a_load_is_still_told(void **state)
{
	(void)state;
	const char *store = support_path("world.furrow");
	support_store(store, extent, flat);
	support_write(support_path("out/objects.csv"), "another drive's\n");
	struct drive_result result = drive(store, support_path("out"), false, 0, (const char *const[][2]){{"output", "null"}, {NULL, NULL}});
	assert_int_equal(access(support_path("out/objects.csv"), F_OK), -1);
	const char *resting = strstr(result.json, "\"resting\"");
	assert_non_null(resting);
	assert_true(fabs(strtod(strstr(resting, "\"sinkage\":") + 10, NULL) + strtod(strstr(resting, "\"z\":") + 4, NULL) - 10.25) < 1e-6);
	mem_free(result.json);
}

TEST_PROGRAM(forces)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_object_has_its_row_at_each_time),
		cmocka_unit_test(rows_do_not_depend_on_the_time_step),
		cmocka_unit_test(a_surface_changes_the_forces_of_its_object_alone),
		cmocka_unit_test(on_a_map_each_row_says_the_soil_under_its_object),
		cmocka_unit_test(a_drive_that_is_cut_goes_on_with_the_same_rows),
		cmocka_unit_test(without_rows_there_is_no_file_and_a_load_is_still_told),
	};
	return cmocka_run_group_tests_name("world/forces", tests, support_enter, support_leave);
}
