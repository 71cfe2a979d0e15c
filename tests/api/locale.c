/* A host whose locale has a decimal comma: files are as in the locale "C", and the host keeps its locale. */
#include "../comma.h"
#include "../support/program.h"
#include "../support/skip.h"
#include "hosted.h"

#include <cjson/cJSON.h>

#define STEPS 40

static const char scene[] =
	"{time_step: 0.01, end_time: 0.4, gravity: 9.8125, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm}, output: {forces: 50},\n"
	" objects: [{name: a, shape: {sphere: {radius: 0.4375}}, sink: 0.0625, path: {points: [[10.5, 20.25], [14, 20.75]], speed: 5.5}},\n"
	"  {name: b, shape: {wheel: {radius: 0.4, width: 0.25}}, load: 250.5, path: {file: poses.csv}}]}\n";

/* Makes steps of a world, from where its last drive ended. */
static void drive(const char *store, const char *output, int steps)
{
	struct furrow_world *world;
	struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = store, .output = output, .resume = true};
	done(furrow_world_open(&open, &world));
	for (int i = 0; i < steps; i++)
		done(furrow_step(world, 0));
	done(furrow_world_close(world));
}

static void prepare(const char *store)
{
	support_write(support_path("scene.yaml"), scene);
	support_write(support_path("poses.csv"), "0,10.5,10.5\n0.4,13.25,10.75\n");
	support_store(store, hosted_extent, hosted_flat);
}

static void a_drive_and_its_resumption_leave_the_same_rows(void **state)
{
	const char *plain = support_path("plain.furrow"), *german = support_path("german.furrow");
	prepare(plain);
	prepare(german);
	drive(plain, support_path("plain"), STEPS);
	if (!comma_begin(support_folder))
		skip_since("no locale with a decimal comma");
	drive(german, support_path("german"), STEPS / 2);
	drive(german, support_path("german"), STEPS / 2);
	comma_end(state);
	char *rows = support_text(support_path("german/objects.csv")), *wanted = support_text(support_path("plain/objects.csv"));
	char *run = support_text(support_path("german/run.json"));
	assert_true(strlen(rows) > 2000);
	assert_string_equal(rows, wanted);
	cJSON *json = cJSON_Parse(run);
	assert_non_null(json);
	assert_true(support_hash(german) == support_hash(plain));
	cJSON_Delete(json);
	free(rows);
	free(wanted);
	free(run);
}

struct heard {
	int progress, notes;
	bool comma; /* the host's function had the host's locale, each time */
};

static bool count_progress(double share, void *user)
{
	struct heard *heard = user;
	heard->progress++;
	heard->comma = heard->comma && strtod("0,5", NULL) == 0.5;
	return true;
}

static void count_note(int level, const char *message, void *user)
{
	struct heard *heard = user;
	heard->notes++;
	heard->comma = heard->comma && strtod("0,5", NULL) == 0.5;
}

static void write_raster(const char *path)
{
	const struct dem_raster raster = {.path = path, .width = 65, .height = 65, .type = DEM_UINT16, .srs = "", .spacing = 1};
	struct dem_writer *writer;
	double row[65];
	for (int x = 0; x < 65; x++)
		row[x] = 200 + x % 7;
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 65; y++)
		must(dem_writer_rows(writer, 1, row));
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
}

static void an_import_makes_the_same_store(void **state)
{
	static const char options[] = "{spacing: 0.75, max_error: 0.0125, jobs: 2}";
	const char *source = support_path("ground.png"), *plain = support_path("a.furrow"), *german = support_path("b.furrow");
	struct heard heard = {.comma = true};
	write_raster(source);
	done(furrow_import(&source, 1, plain, options, NULL, NULL));
	if (!comma_begin(support_folder))
		skip_since("no locale with a decimal comma");
	done(furrow_import(&source, 1, german, options, count_progress, &heard));
	comma_end(state);
	assert_true(heard.progress > 0 && heard.comma);
	assert_true(support_hash(german) == support_hash(plain));
}

/* Of a thread that uses a locale of its own, too. */
static void the_host_keeps_its_locale(void **state)
{
	const char *store = support_path("kept.furrow");
	struct furrow_world *none;
	struct heard heard = {.comma = true};
	prepare(store);
	if (!comma_begin(support_folder))
		skip_since("no locale with a decimal comma");
	char before[256];
	snprintf(before, sizeof before, "%s", setlocale(LC_ALL, NULL));
	const locale_t own = duplocale(LC_GLOBAL_LOCALE), locales[] = {LC_GLOBAL_LOCALE, own};
	const struct furrow_open wrong = hosted_open("{cache: {prefetch: -0.5}, time_step: 0}", store);
	furrow_set_log(count_note, &heard);
	for (int i = 0; i < 2; i++) {
		uselocale(locales[i]);
		drive(store, NULL, 2); /* the first has nothing to resume: worth a note */
		refused(FURROW_INPUT, furrow_world_open(&wrong, &none));
		assert_non_null(strstr(furrow_last_error(), "-0.5 is out of range"));
		misused(furrow_step(NULL, 0));
		assert_ptr_equal(uselocale((locale_t)0), locales[i]);
		assert_string_equal(setlocale(LC_ALL, NULL), before);
	}
	furrow_set_log(NULL, NULL);
	uselocale(LC_GLOBAL_LOCALE);
	freelocale(own);
	assert_true(heard.notes > 0 && heard.comma);
}

TEST_PROGRAM(locale)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_teardown(a_drive_and_its_resumption_leave_the_same_rows, comma_end),
		cmocka_unit_test_teardown(an_import_makes_the_same_store, comma_end),
		cmocka_unit_test_teardown(the_host_keeps_its_locale, comma_end),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
