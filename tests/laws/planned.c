/* Law 7 for whole drives: each makes and runs what its plan says, and nothing that nobody asked for. */
#include <glob.h>

#include "effects.h"
#include "../support/program.h"

static void nothing_is_made_or_run_for_nothing(void **state)
{
	struct outcome outcome = drive(NOTHING);
	assert_int_equal(cJSON_GetArraySize(counts_get(outcome.counts, "programs")), 0);
	assert_int_equal(cJSON_GetArraySize(counts_get(outcome.counts, "passes")), 0);
	assert_int_equal(counts_integer(outcome.counts, "textures"), 0);
	finish(&outcome);
}

#define BUSY "scene: 1\ntime_step: 0.1\nend_time: 1\noutside: skip\ncache: {slots: 64, loaders: 2, prefetch: 0.5}\n"
#define FEW "scene: 1\ntime_step: 0.1\nend_time: 3\ncache: {slots: 9, loaders: 1, prefetch: 0}\n"
#define MANY                                                                                                            \
	"objects:\n  - {name: a, shape: {" WHEEL ", lugs: 8}}, sink: 0.3, " PATH "}\n"                                  \
	"  - {name: b, shape: {box: {size: [2, 1, 1]}}, sink: 0.2, path: {points: [[70, 70]], speed: 1}}\n"            \
	"  - {name: c, shape: {sphere: {radius: 1}}, sink: 0.2, path: {points: [[120, 90], [140, 90]], speed: 20}}\n"
#define CARRIED                                                                                                         \
	"objects:\n  - {name: a, shape: {" WHEEL "}}, load: 4000, slip: 0.2, " PATH "}\n"                               \
	"  - {name: b, shape: {box: {size: [2, 1, 1]}}, load: 3000, path: {points: [[70, 70]], speed: 1}}\n"           \
	"  - {name: c, shape: {sphere: {radius: 1}}, sink: 0.2, path: {points: [[80, 30], [60, 30]], speed: 8}}\n"
/* Two of each kind, far from each other. */
#define PAIRS                                                                                                           \
	"objects:\n  - {name: a, shape: {" WHEEL "}}, sink: 0.3, " PATH "}\n"                                           \
	"  - {name: b, shape: {" WHEEL "}}, load: 4000, path: {points: [[90, 80], [120, 60]], speed: 12}}\n"             \
	"  - {name: c, shape: {box: {size: [2, 1, 1]}}, sink: 0.2, path: {points: [[120, 20], [130, 40]], speed: 5}}\n"        \
	"  - {name: d, shape: {sphere: {radius: 1}}, sink: 0.2, path: {points: [[20, 110], [40, 100]], speed: 8}}\n"
#define CHASE "view: {size: [160, 90], camera: {chase: a, back: 12, up: 5}, effects: [texture, detail, fog, sky, geomorph, skirts, objects, shadow], images: 5}\n"

#define SHADED "view: {size: [160, 90], camera: {chase: a, back: 12, up: 5}, sun: {height: 12}, effects: [geomorph, skirts, objects, terrain_shadow], images: 5}\n"
#define BY_ERROR "view: {size: [160, 90], camera: {chase: a, back: 12, up: 5}, pixel_error: 1, images: 1}\n"

#define TWO_CAMERAS                                                                                                     \
	"cameras: [{name: x, kind: mounted, on: a, rate: 2, size: [64, 48], images: [colour, depth, height]},\n"              \
	"  {name: y, kind: overhead, on: b, height: 20, rate: 5, size: [160, 90], images: [normals, class]}]\n"

/* One pushes soil against others that stand: a plate, a wheel, a mesh. */
#define PARKED                                                                                                          \
	"objects:\n  - {name: a, shape: {box: {size: [3, 3, 1]}}, sink: 0.1, path: {points: [[66, 60]], speed: 1}}\n"        \
	"  - {name: b, shape: {" WHEEL ", lugs: 8}}, sink: 0.1, path: {points: [[62, 64]], speed: 1}}\n"                      \
	"  - {name: c, shape: {sphere: {radius: 1.5}}, sink: 0.6, path: {points: [[50, 60], [63, 61]], speed: 20}}\n"
/* Side by side, and none of them stands before the end. */
#define SIDE_BY_SIDE                                                                                                    \
	"objects:\n  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.4, path: {points: [[40, 60], [70, 60]], speed: 20}}\n" \
	"  - {name: b, shape: {sphere: {radius: 1.5}}, sink: 0.4, path: {points: [[40, 63], [70, 63]], speed: 20}}\n"

/* It comes down in between, and rises again. */
#define HOPS "objects:\n  - {name: a, shape: {sphere: {radius: 1}}, path: {file: hops.csv}}\n"

static void every_drive_counts_what_was_planned(void **state)
{
	static const char *const scenes[] = {
		BUSY MANY "spacing: 0.25\nattributes: [dirt]\nredistribute: {model: box}\n" CHASE,
		BUSY MANY SCM "output: {forces: 10}\n" CHASE,
		BUSY CARRIED SCM "spacing: 0.5\nattributes: [dirt]\n",
		BUSY MANY SOIL "redistribute: {model: sumner, iterations: 3}\nspacing: 0.5\n" VIEW("sky"),
		BUSY MANY SOIL "redistribute: {model: slippage, undisturbed: slides}\n",
		BUSY OBJECT("sphere: {radius: 90}") SOIL "redistribute: {model: slippage}\nspacing: 0.5\n",
		BUSY PARKED SOIL "redistribute: {model: slippage}\nspacing: 0.5\n",
		BUSY PARKED SOIL "redistribute: {model: sumner, iterations: 2}\nspacing: 0.25\n",
		BUSY PAIRS SCM "attributes: [dirt]\noutput: {forces: 10}\n",
		FEW SPHERE SCM,
		"compute: gpu\n" BUSY MANY "spacing: 0.25\nattributes: [dirt]\nredistribute: {model: sheet, tension: 20000, yield: 0.2}\n" CHASE,
		"compute: gpu\n" BUSY HOPS "redistribute: {model: sheet}\nattributes: [vegetation]\n",
		BUSY HOPS "redistribute: {model: sheet}\nattributes: [vegetation]\n" CHASE,
		"compute: cpu\n" BUSY MANY "spacing: 0.25\nattributes: [dirt]\nredistribute: {model: box}\n" CHASE,
		"compute: cpu\n" BUSY MANY SOIL "redistribute: {model: sumner, iterations: 3}\nspacing: 0.5\n" VIEW("sky"),
		"compute: cpu\n" BUSY MANY SOIL "redistribute: {model: slippage, undisturbed: slides}\n",
		"compute: cpu\n" BUSY OBJECT("sphere: {radius: 90}") SOIL "redistribute: {model: slippage}\nspacing: 0.5\n",
		"compute: cpu\n" BUSY HOPS "attributes: [dirt]\n" CHASE,
		"compute: cpu\n" BUSY MANY "soil: {map: classes.png, classes: {1: mud}, default: sand}\n" VIEW("splat, texture, fog"),
		FEW MANY "outside: skip\nattributes: [dirt]\nspacing: 0.5\n" VIEW("texture"),
		BUSY CHASE SPHERE,
		BUSY MANY BY_ERROR,
		/* At the world's edge what is left of it fits one window. */
		BUSY OBJECT("sphere: {radius: 62}") SCM "spacing: 0.5\n",
		BUSY HOPS "attributes: [dirt]\n" CHASE,
		BUSY HOPS SCM "spacing: 0.5\n",
		BUSY MANY MAP "spacing: 0.5\n" VIEW("texture, splat"),
		BUSY MANY "soil: {map: classes.png, classes: {1: mud}, default: sand}\n" VIEW("splat, texture, fog"),
		BUSY MANY "spacing: 0.5\n" TWO_CAMERAS,
		BUSY MANY CHASE TWO_CAMERAS,
		BUSY MANY SHADED TWO_CAMERAS,
		/* Relief does not raise level -1, which is interpolated. */
		BUSY MANY "spacing: 0.25\nrelief: {roughness: 0.02, wavelength: 0.6}\n" CHASE,
		BUSY MANY MAP "spacing: 0.5\n" TWO_CAMERAS,
		BUSY "view: {" CAMERA ", body: mars, effects: [texture, sky, fog]}\n",
	};
	write_files();
	support_write(support_path("hops.csv"), "t,x,y,z\n0,40,40,150\n0.5,50,50,98\n1,60,60,150\n");
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct outcome outcome = drive(scenes[i]);
		finish(&outcome);
	}
}

/* Counts the plan's lines of what bodies at rest need, and tells in *held how many of its passes ran. */
static size_t lines_of_roofs(const char *text, int64_t *held)
{
	struct outcome outcome = drive(text);
	struct report_plan plan;
	size_t count = 0;
	must(report_plan(outcome.scene, support_path("effects.furrow"), false, &plan));
	for (size_t i = 0; i < plan.plan.count; i++)
		count += strstr(plan.plan.lines[i].name, "roof") != NULL || strstr(plan.plan.lines[i].name, "ROOFS") != NULL;
	report_plan_finish(&plan);
	*held = counts_integer(counts_get(outcome.counts, "units"), plan_unit_name(PLAN_HELD));
	finish(&outcome);
	return count;
}

/* Bodies at rest keep soil out of themselves. Without one beside moved soil there is no pass, no program and no texture for it. */
static void bodies_that_move_need_no_roofs(void **state)
{
	int64_t held, none;
	assert_int_equal(lines_of_roofs(BUSY SIDE_BY_SIDE SOIL "redistribute: {model: slippage, interval: 10}\nspacing: 0.5\n", &none), 0);
	assert_int_equal(none, 0);
	assert_int_equal(lines_of_roofs(BUSY SPHERE SOIL "redistribute: {model: sumner, interval: 10}\nspacing: 0.5\n", &none), 0);
	assert_int_equal(none, 0);
	assert_true(lines_of_roofs(BUSY PARKED SOIL "redistribute: {model: slippage, interval: 10}\nspacing: 0.5\n", &held) >= 8);
	assert_true(held > 3);
}

/* How many pictures a drive drew, and how many its plan said it would. */
static int64_t pictures_of(const char *text, int64_t *planned_pictures)
{
	struct outcome outcome = drive(text);
	struct report_plan plan;
	must(report_plan(outcome.scene, support_path("effects.furrow"), false, &plan));
	*planned_pictures = plan.pictures;
	report_plan_finish(&plan);
	int64_t drawn = counts_integer(counts_get(outcome.counts, "units"), plan_unit_name(PLAN_FRAME));
	const cJSON *view = cJSON_GetObjectItemCaseSensitive(outcome.json, "view");
	assert_int_equal(drawn, view != NULL ? counts_integer(view, "images") : 0);
	finish(&outcome);
	return drawn;
}

/* Six steps. Each case: how many pictures. */
static void only_pictures_that_are_written_are_drawn(void **state)
{
	static const struct {
		const char *scene;
		int64_t pictures;
	} cases[] = {
		{HEAD SPHERE VIEW("texture, objects"), 3},
		{HEAD SPHERE "view: {size: [160, 90], camera: {chase: a}, images: 4}\n", 1},
		{HEAD SPHERE "view: {size: [160, 90], camera: {chase: a}, images: 7}\n", 0},
		{HEAD SPHERE UNSEEN, 0},
		{READ("loaders: 1, prefetch: 0.5") SPHERE VIEW(""), 3},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		int64_t planned_pictures, drawn = pictures_of(cases[i].scene, &planned_pictures);
		assert_int_equal(drawn, cases[i].pictures);
		assert_int_equal(planned_pictures, cases[i].pictures);
	}
}

/* Classes are read for tiles of the working level; for the picture, where it shows them, for all that are drawn. */
static void a_map_that_is_drawn_is_read_for_every_tile(void **state)
{
	write_files();
	for (int drawn = 0; drawn < 2; drawn++) {
		struct outcome outcome = drive(drawn ? HEAD SPHERE MAP VIEW("texture, splat") : HEAD SPHERE MAP VIEW("texture"));
		const cJSON *units = counts_get(outcome.counts, "units");
		int64_t classes = counts_integer(units, plan_unit_name(PLAN_HOST_CLASSES)), bases = counts_integer(units, plan_unit_name(PLAN_HOST_BASE));
		assert_true(classes > 0 && (classes == bases) == (drawn == 1));
		assert_int_equal(counts_integer(units, plan_unit_name(PLAN_CLASS_SLOT)) > 0, drawn);
		finish(&outcome);
	}
}

/* Numbers of the soil are read for tiles of the working level alone, also with a map that is drawn. */
static void rasters_are_read_for_contacts_alone(void **state)
{
	static const char both[] = HEAD SPHERE "soil: {map: classes.png, classes: {1: dry_sand}, default: dry_sand, rasters: {cohesion: "
					       "classes.png, friction_angle: classes.png}}\nredistribute: {model: scm}\n" VIEW("texture, splat");
	write_files();
	struct outcome outcome = drive(both);
	const cJSON *units = counts_get(outcome.counts, "units");
	int64_t numbers = counts_integer(units, plan_unit_name(PLAN_HOST_NUMBERS)), classes = counts_integer(units, plan_unit_name(PLAN_HOST_CLASSES));
	assert_true(numbers > 0 && numbers < classes);
	finish(&outcome);
}

/* What an earlier drive left is looked at where it matters, and the plan says so. */
static void a_deformed_store_is_planned_as_it_is(void **state)
{
	static const char *const scenes[] = {
		BUSY SPHERE SCM "attributes: [dirt]\n", /* its state is left */
		BUSY VIEW("texture"),
		BUSY SPHERE SCM CHASE,
		BUSY SPHERE,
		BUSY SPHERE SOIL "redistribute: {model: sumner}\n" CHASE,
		BUSY VIEW(""),
		BUSY MANY BY_ERROR,
		BUSY "view: {" CAMERA ", pixel_error: 1}\n",
	};
	const char *store = support_path("effects.furrow");
	support_store(store, extent, gentle);
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct outcome outcome = drive_on(scenes[i], store);
		finish(&outcome);
	}
}

/* With --keep-history, and after it without; with one named revision alone. */
static void a_history_is_planned_as_it_is(void **state)
{
	static const char *const scenes[] = {
		BUSY SPHERE SCM "attributes: [dirt]\n",
		BUSY SPHERE SCM CHASE,
		BUSY SPHERE SOIL "redistribute: {model: sumner}\n",
		BUSY VIEW("texture"),
	};
	const char *store = support_path("history.furrow");
	for (int named = 0; named < 2; named++) {
		support_store(store, extent, gentle);
		for (int i = 0; i < 8; i++) {
			struct store *open;
			planned_history = !named && i < 4;
			struct outcome outcome = drive_on(scenes[i % 4], store);
			const cJSON *kept = counts_get(counts_get(outcome.counts, "units"), plan_unit_name(PLAN_KEPT));
			assert_true(i % 4 == 3 || named || !planned_history || counts_integer(kept, "history") > 4);
			finish(&outcome);
			planned_history = false;
			if (!named || i > 0)
				continue;
			must(store_open(store, &(struct store_options){.mode = STORE_WRITE}, &open));
			must(store_snapshot(open, "first"));
			store_close(open);
		}
	}
}

/* Tiles that an overlay inherits are looked for in its own file, too. */
static void an_overlay_is_planned_as_it_is(void **state)
{
	static const char *const scenes[] = {
		BUSY SPHERE SCM "attributes: [dirt]\n",
		BUSY VIEW("texture"),
		BUSY SPHERE SCM CHASE,
		BUSY SPHERE SOIL "redistribute: {model: sumner}\n" CHASE,
	};
	const char *store = support_path("under.furrow"), *middle = support_path("middle.furrow"), *over = support_path("over.furrow");
	support_store(store, extent, gentle);
	struct outcome outcome = drive_on(scenes[0], store);
	finish(&outcome);
	must(store_create_overlay(middle, store));
	outcome = drive_on(scenes[2], middle);
	finish(&outcome);
	must(store_create_overlay(over, middle));
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		outcome = drive_on(scenes[i], over);
		finish(&outcome);
	}
}

/* Variants multiply; those of all scenes that are shipped are few still. Bearing soil has none. */
static void few_programs_do_for_all_scenes(void **state)
{
	enum { MOST = 53 }; /* six of them for feet that stand beside soil that moves, five for ground of one named soil */
	const char *folder = getenv("SCENES"), *store = support_path("scenes.furrow");
	struct plan all = {NULL, 0, 0, false};
	glob_t found;
	assert_non_null(folder);
	char pattern[4096];
	snprintf(pattern, sizeof pattern, "%s/*.yaml", folder);
	assert_int_equal(glob(pattern, 0, NULL, &found), 0);
	support_store(store, extent, gentle);
	for (size_t i = 0; i < found.gl_pathc; i++) {
		struct scene *scene;
		struct plan plan;
		enum status status = scene_load(found.gl_pathv[i], NULL, 0, &scene);
		if (status != STATUS_OK && !has_meshes())
			continue;
		must(status);
		planned(scene, store, &plan);
		for (size_t k = 0; k < plan.count; k++)
			if (plan.lines[k].kind == PLAN_PROGRAM)
				plan_add(&all, &plan.lines[k], plan.lines[k].name);
		plan_finish(&plan);
		scene_destroy(scene);
	}
	must(plan_status(&all));
	print_message("%zu scenes, %zu programs\n", found.gl_pathc, all.count);
	assert_true(found.gl_pathc >= 7 && all.count > 0 && all.count <= MOST);
	plan_finish(&all);
	globfree(&found);
}

/* Passes of the model; of bearing soil, which has none, contacts and blocks of relaxing soil. */
/* on_cpu: a model that the CPU alone computes; NULL: another one. */
static long long work_of(const char *json, const char *on_cpu)
{
	const char *where = strstr(json, "\"where\"");
	if (on_cpu == NULL)
		return support_figure(json, "\"passes\"", "redistribute");
	assert_int_equal(support_figure(json, "\"passes\"", "redistribute"), 0);
	if (strcmp(on_cpu, "sheet") == 0)
		return support_figure(where, "\"sheet\"", "possible");
	return support_figure(where, "\"scm\"", "possible") + support_figure(where, "\"slide\"", "visited");
}

static void a_resting_object_runs_no_pass(void **state)
{
	static const char scene_text[] =
		"scene: 1\ntime_step: 0.1\nend_time: 4\n"
		"objects:\n"
		"  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[20, 20], [100, 90]], speed: 10}}\n";
	static const char *const models[] = {"box", "sumner", "slippage", "scm", "sheet"};
	const struct extent wide = {129, 129, 1, 64};
	for (int m = 0; m < 5; m++) {
		const bool soil = m > 0 && m < 4;
		char text[512];
		const char *scene = support_path("rests.yaml"), *store = support_path("rests.furrow");
		snprintf(text, sizeof text, "%s%sredistribute: {model: %s}\n", scene_text, soil ? SOIL : "", models[m]);
		support_write(scene, text);
		/* The path takes 10.6 s at 10 m/s; stopped at its end, and with the ground come to rest, further steps add
		 * nothing. */
		long long passes[2];
		bool repeats = false;
		const char *const ends[] = {"end_time=40", "end_time=80"};
		for (int i = 0; i < 2; i++) {
			support_store(store, wide, gentle);
			char *json = support_drive(scene, store, (const char *[]){ends[i], NULL});
			passes[i] = work_of(json, m >= 3 ? models[m] : NULL);
			if (soil)
				assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
			repeats = support_counts_repeat(json);
			mem_free(json);
		}
		assert_true(passes[0] > 100 && llabs(passes[1] - passes[0]) <= (repeats ? 0 : passes[0] / 20));
	}
}

TEST_PROGRAM(planned)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nothing_is_made_or_run_for_nothing),
		cmocka_unit_test(every_drive_counts_what_was_planned),
		cmocka_unit_test(bodies_that_move_need_no_roofs),
		cmocka_unit_test(only_pictures_that_are_written_are_drawn),
		cmocka_unit_test(a_map_that_is_drawn_is_read_for_every_tile),
		cmocka_unit_test(rasters_are_read_for_contacts_alone),
		cmocka_unit_test(a_deformed_store_is_planned_as_it_is),
		cmocka_unit_test(a_history_is_planned_as_it_is),
		cmocka_unit_test(an_overlay_is_planned_as_it_is),
		cmocka_unit_test(few_programs_do_for_all_scenes),
		cmocka_unit_test(a_resting_object_runs_no_pass),
	};
	return cmocka_run_group_tests_name("planned", tests, support_enter, support_leave);
}
