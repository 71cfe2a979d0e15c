/*
 * Law 7: an effect that the scene does not name costs nothing; one that it names, only itself.
 *
 * Each effect in turn is taken into a scene and out again. Every drive's counts are held to its plan: lines times units,
 * and nothing else. What differs between two plans must be the effect's own; and where it leaves the others' work as it
 * was, their units too are the same. So what was counted differs by the effect's own rows, and by no other.
 */
#include <glob.h>

#include "../counts.h"
#include "../planned.h"

static const struct extent extent = {129, 129, 1, 32};

static double gentle(int64_t x, int64_t y)
{
	return 100 + (double)(x * y % 7) / 1024;
}

/* --- scenes --- */

/* Nothing is loaded ahead, so that what is loaded when does not go by the clock. */
#define READ(how) "scene: 1\ntime_step: 0.1\nend_time: 0.6\ncache: {slots: 48, " how "}\n"
#define HEAD READ("loaders: 0, prefetch: 0")
#define PATH "path: {points: [[30, 30], [60, 50]], speed: 10}"
#define OBJECT(shape) "objects:\n  - {name: a, shape: {" shape "}, sink: 0.3, " PATH "}\n"
#define SPHERE OBJECT("sphere: {radius: 1.5}")
#define WHEEL "wheel: {radius: 1.5, width: 1"
#define SOIL "soil: {name: dry_sand}\n"
#define SCM SOIL "redistribute: {model: scm}\n"
#define LOADED SCM "objects:\n  - {name: a, shape: {sphere: {radius: 1.5}}, load: 3000, " PATH "}\n"
#define CAMERA "size: [160, 90], camera: {fixed: {eye: [20, 10, 120], target: [50, 45, 100]}}, images: 2"
#define VIEW(effects) "view: {" CAMERA ", effects: [" effects "]}\n"
#define VIEW_BY_ERROR(effects) "view: {" CAMERA ", pixel_error: 4, effects: [" effects "]}\n"
#define SAMPLED "view: {" CAMERA ", samples: 4}\n"
/* Nothing is written. */
#define UNSEEN "view: {size: [160, 90], camera: {fixed: {eye: [20, 10, 120], target: [50, 45, 100]}}, effects: [texture, sky]}\n"
#define SEEN SPHERE "attributes: [dirt]\n"
#define MAP "soil: {map: classes.png, classes: {1: dry_sand}, default: dry_sand}\nredistribute: {model: scm}\n"

/* Neither objects nor a view: no file may say that. */
#define NOTHING ""

/* What is asked of the pair: nothing changes what is deformed, so all else is done as often. */
struct pair {
	enum scene_effect effect;
	const char *without, *with;
	bool same_work;
};

static const struct pair pairs[] = {
	{EFFECT_OF(DEFORM_NONE), NOTHING, HEAD SPHERE, false},
	{EFFECT_OF(DEFORM_BOX_FILTER), HEAD SPHERE, HEAD SPHERE "redistribute: {model: box}\n", true},
	{EFFECT_OF(DEFORM_SUMNER), HEAD SPHERE, HEAD SPHERE SOIL "redistribute: {model: sumner}\n", false},
	{EFFECT_OF(DEFORM_SLIPPAGE), HEAD SPHERE, HEAD SPHERE SOIL "redistribute: {model: slippage}\n", false},
	{EFFECT_OF(DEFORM_SCM), HEAD SPHERE, HEAD SPHERE SCM, false},
	{EFFECT_SPREAD, HEAD SPHERE, HEAD SPHERE SCM, false},
	{EFFECT_SHED, HEAD SPHERE, HEAD SPHERE SOIL "redistribute: {model: sumner}\n", false},
	{EFFECT_SLIDE, HEAD SPHERE, HEAD SPHERE SCM, false},
	{EFFECT_SOIL_MAP, HEAD SPHERE SCM, HEAD SPHERE MAP, true},
	{EFFECT_MESH, HEAD SPHERE, HEAD OBJECT("mesh: {file: block.obj}"), false},
	{EFFECT_GROUSERS, HEAD OBJECT(WHEEL "}"), HEAD OBJECT(WHEEL ", lugs: 12}"), false},
	{EFFECT_LOAD, HEAD SPHERE SCM, HEAD LOADED, false},
	{EFFECT_FORCES, HEAD SPHERE SCM, HEAD SPHERE SCM "output: {forces: 20}\n", true},
	{EFFECT_FORCES, HEAD LOADED, HEAD LOADED "output: {forces: 20}\n", true},
	{EFFECT_DISTURBANCE, HEAD SPHERE, HEAD SEEN, true},
	{EFFECT_DISTURBANCE, HEAD SPHERE VIEW(""), HEAD SEEN VIEW(""), true},
	{EFFECT_SUBDIVIDE, HEAD SPHERE, HEAD SPHERE "spacing: 0.5\n", false},
	{EFFECT_PYRAMID, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_PICTURE, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_NORMALS, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_IMAGES, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_LOADERS, HEAD SPHERE, READ("loaders: 2, prefetch: 0") SPHERE, false},
	{EFFECT_PREFETCH, HEAD SPHERE, READ("loaders: 0, prefetch: 0.5") SPHERE, false},
	{EFFECT_TEXTURE, HEAD SEEN VIEW(""), HEAD SEEN VIEW("texture"), true},
	{EFFECT_DETAIL, HEAD SEEN VIEW("texture"), HEAD SEEN VIEW("texture, detail"), true},
	{EFFECT_FOG, HEAD SEEN VIEW(""), HEAD SEEN VIEW("fog"), true},
	{EFFECT_SKY, HEAD SEEN VIEW(""), HEAD SEEN VIEW("sky"), true},
	{EFFECT_GEOMORPH, HEAD SEEN VIEW(""), HEAD SEEN VIEW("geomorph"), true},
	{EFFECT_SKIRTS, HEAD SEEN VIEW(""), HEAD SEEN VIEW("skirts"), true},
	{EFFECT_ANTIALIAS, HEAD SEEN VIEW(""), HEAD SEEN SAMPLED, true},
	{EFFECT_PIXEL_ERROR, HEAD SEEN VIEW("geomorph"), HEAD SEEN VIEW_BY_ERROR("geomorph"), false},
	{EFFECT_TEXTURE, HEAD VIEW(""), HEAD VIEW("texture"), true},
	{EFFECT_OBJECTS, HEAD SEEN VIEW(""), HEAD SEEN VIEW("objects"), true},
	{EFFECT_SHADOW, HEAD SEEN VIEW("objects"), HEAD SEEN VIEW("objects, shadow"), true},
	{EFFECT_SPLAT, HEAD SPHERE MAP VIEW("texture"), HEAD SPHERE MAP VIEW("texture, splat"), true},
	{EFFECT_SPLAT, HEAD MAP VIEW("texture"), HEAD MAP VIEW("texture, splat"), true},
};
#define PAIRS (sizeof pairs / sizeof *pairs)

/* --- drives --- */

struct outcome {
	struct scene *scene;
	size_t taken; /* objects that were taken out of it */
	struct plan plan;
	uint64_t effects; /* called for */
	cJSON *json;
	const cJSON *counts;
};

static void finish(struct outcome *outcome)
{
	outcome->scene->object_count += outcome->taken;
	scene_destroy(outcome->scene);
	plan_finish(&outcome->plan);
	cJSON_Delete(outcome->json);
}

static struct scene *load(const char *text)
{
	const char *path = support_path("effects.yaml");
	struct scene *scene;
	support_write(path, text);
	must(scene_load(path, NULL, 0, &scene));
	return scene;
}

/* Whether this build reads meshes. */
static bool has_meshes(void)
{
	struct scene *scene;
	const char *path = support_path("mesh.yaml");
	support_write(support_path("plane.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 3 2 1\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
	support_write(path, HEAD OBJECT("mesh: {file: plane.obj}"));
	enum status status = scene_load(path, NULL, 0, &scene);
	if (status == STATUS_OK)
		scene_destroy(scene);
	return status == STATUS_OK;
}

/* Every drive: what it counted is what was planned, and its threads are gone. */
static struct outcome drive_on(const char *text, const char *store)
{
	bool nothing = strcmp(text, NOTHING) == 0;
	struct outcome outcome = {.scene = load(nothing ? HEAD SPHERE : text)};
	outcome.taken = nothing ? outcome.scene->object_count : 0;
	outcome.scene->object_count -= outcome.taken;
	outcome.effects = planned(outcome.scene, store, &outcome.plan);
	struct api_params params = {.scene = outcome.scene, .store = store, .directory = support_path("out")};
	struct api_result result;
	enum status status = api_drive(&params, &result);
	if (status == STATUS_NO_GL)
		skip();
	must(status);
	outcome.json = cJSON_Parse(result.json);
	mem_free(result.json);
	assert_non_null(outcome.json);
	outcome.counts = counts_get(outcome.json, "counts");
	if (counts_check(&outcome.plan, outcome.counts, outcome.scene) != 0) {
		print_error("in this scene:\n%s", text);
		fail();
	}
	assert_int_equal(thread_running(), 0);
	return outcome;
}

static struct outcome drive(const char *text)
{
	const char *store = support_path("effects.furrow");
	support_store(store, extent, gentle);
	return drive_on(text, store);
}

/* --- what may differ --- */

static bool same_line(const struct plan_line *a, const struct plan_line *b)
{
	return a->kind == b->kind && a->unit == b->unit && a->object == b->object && a->amount == b->amount &&
	       a->bytes == b->bytes && strcmp(a->name, b->name) == 0 &&
	       (a->effect == NULL ? b->effect == NULL : b->effect != NULL && strcmp(a->effect, b->effect) == 0);
}

static bool has_line(const struct plan *plan, const struct plan_line *line)
{
	for (size_t i = 0; i < plan->count; i++)
		if (same_line(&plan->lines[i], line))
			return true;
	return false;
}

static bool is_called_for(const struct plan_line *line, uint64_t effects)
{
	for (int i = 0; i < EFFECT_COUNT; i++)
		if ((effects >> i & 1) && line->effect != NULL && strcmp(line->effect, scene_effect_row((enum scene_effect)i)->name) == 0)
			return true;
	return false;
}

static bool has_word(const char *text, const char *word)
{
	size_t length = strlen(word);
	for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word)) {
		bool begins = at == text || at[-1] == ' ', ends = at[length] == ' ' || at[length] == '\0';
		if (begins && ends)
			return true;
	}
	return false;
}

/* Every word of `less` is one of `more`; what a define's value is, is free. */
static bool has_words(const char *more, const char *less)
{
	char words[96];
	snprintf(words, sizeof words, "%s", less);
	for (char *word = strtok(words, " "); word != NULL; word = strtok(NULL, " "))
		if ((*word < '0' || *word > '9') && !has_word(more, word))
			return false;
	return true;
}

/* Whether the line has taken the place of one of `plan` that `instead` has not: a program of the same files with defines
 * more or fewer; a buffer that an effect makes longer. */
static bool takes_a_place(const struct plan *plan, const struct plan *instead, const struct plan_line *line, uint64_t effects)
{
	for (size_t i = 0; i < plan->count; i++) {
		const struct plan_line *other = &plan->lines[i];
		if (other->kind != line->kind || other->unit != line->unit || has_line(instead, other))
			continue;
		if (line->kind == PLAN_PROGRAM && (has_words(other->name, line->name) || has_words(line->name, other->name)))
			return true;
		bool own = is_called_for(other, effects) || is_called_for(line, effects);
		if (line->kind != PLAN_PROGRAM && own && strcmp(other->name, line->name) == 0)
			return true;
	}
	return false;
}

/* The lines of `more` that `less` has not are of the effects that only it has, or take a place for their sake. */
static int check_lines(const struct plan *less, const struct plan *more, uint64_t own)
{
	int problems = 0;
	for (size_t i = 0; i < more->count; i++) {
		const struct plan_line *line = &more->lines[i];
		if (has_line(less, line) || is_called_for(line, own) || takes_a_place(less, more, line, own))
			continue;
		/* A closed form's underside, where the shape is a mesh instead. */
		if ((own >> EFFECT_MESH & 1) && strstr(line->name, "under") != NULL)
			continue;
		/* As many images of tiles as loaders may bring at once. */
		if ((own >> EFFECT_LOADERS & 1) && strncmp(line->name, "loads: ", strlen("loads: ")) == 0)
			continue;
		print_error("%s %s (%s) comes and goes without a reason\n", plan_kind_name(line->kind), line->name,
			    line->effect != NULL ? line->effect : "always");
		problems++;
	}
	return problems;
}

/* What follows from when an epoch ends, and from how far the driver is. */
static bool goes_by_the_clock(const char *unit)
{
	static const enum plan_unit units[] = {PLAN_PAGE, PLAN_RING, PLAN_COMMITTED, PLAN_COMMITTED_COARSER, PLAN_CHANGED, PLAN_COMMIT};
	for (size_t i = 0; i < sizeof units / sizeof *units; i++)
		if (strcmp(unit, plan_unit_name(units[i])) == 0)
			return true;
	return false;
}

static int check_units(const cJSON *a, const cJSON *b)
{
	int problems = 0;
	for (const cJSON *unit = counts_get(a, "units")->child; unit != NULL; unit = unit->next) {
		const cJSON *other = counts_get(counts_get(b, "units"), unit->string);
		/* Slots of classes are the map's own, and counted for it; so are draws of objects. */
		if (goes_by_the_clock(unit->string) || strcmp(unit->string, plan_unit_name(PLAN_CLASS_SLOT)) == 0 ||
		    strcmp(unit->string, plan_unit_name(PLAN_LEFT)) == 0 || strcmp(unit->string, plan_unit_name(PLAN_OBJECTS)) == 0 ||
		    strcmp(unit->string, plan_unit_name(PLAN_SHADOWED)) == 0)
			continue;
		if (!cJSON_Compare(unit, other, true)) {
			print_error("unit %s differs\n", unit->string);
			problems++;
		}
	}
	return problems;
}

static void check_pair(const struct pair *pair, const struct outcome *without, const struct outcome *with)
{
	uint64_t before = without->effects, after = with->effects;
	assert_false(before >> pair->effect & 1);
	assert_true(after >> pair->effect & 1);
	/* An effect is for its own sake: what it takes the place of goes, and what it needs comes along. */
	int problems = check_lines(&without->plan, &with->plan, after & ~before), own = 0;
	for (size_t i = 0; i < with->plan.count; i++)
		own += !has_line(&without->plan, &with->plan.lines[i]);
	assert_true(own > 0);
	problems += check_lines(&with->plan, &without->plan, (before & ~after) | (after & ~before));
	if (pair->same_work)
		problems += check_units(without->counts, with->counts);
	if (problems > 0) {
		print_error("of %s\n", scene_effect_row(pair->effect)->name);
		fail();
	}
}

static void write_files(void)
{
	support_write(support_path("block.obj"),
		      "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 2\nv 1 -1 2\nv 1 1 2\nv -1 1 2\n"
		      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
	struct dem_raster raster = {.path = support_path("classes.png"), .width = 129, .height = 129, .type = DEM_UINT8, .spacing = 1};
	struct dem_writer *writer;
	double row[129];
	must(dem_writer_create(&raster, &writer));
	for (int y = 0; y < 129; y++) {
		for (int x = 0; x < 129; x++)
			row[x] = x / 7 % 2;
		must(dem_writer_rows(writer, 1, row));
	}
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
}

static void each_effect_comes_and_goes_alone(void **state)
{
	bool done[PAIRS] = {false};
	uint64_t seen = 0;
	write_files();
	if (!has_meshes())
		seen |= EFFECT_BIT(EFFECT_MESH);
	for (size_t i = 0; i < PAIRS; i++) {
		if (done[i])
			continue;
		struct outcome without = drive(pairs[i].without);
		for (size_t k = i; k < PAIRS; k++) {
			if (strcmp(pairs[k].without, pairs[i].without) != 0)
				continue;
			done[k] = true;
			if (seen >> pairs[k].effect & 1 && pairs[k].effect == EFFECT_MESH)
				continue;
			struct outcome with = drive(pairs[k].with);
			check_pair(&pairs[k], &without, &with);
			seen |= EFFECT_BIT(pairs[k].effect);
			finish(&with);
		}
		/* All taken out again: the first numbers again. */
		struct outcome again = drive(pairs[i].without);
		assert_int_equal(check_lines(&without.plan, &again.plan, 0) + check_lines(&again.plan, &without.plan, 0), 0);
		assert_int_equal(check_units(without.counts, again.counts), 0);
		finish(&again);
		finish(&without);
	}
	assert_int_equal(seen, EFFECT_BIT(EFFECT_COUNT) - 1); /* none was forgotten */
}

/* --- whatever the scene --- */

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
#define CHASE "view: {size: [160, 90], camera: {chase: a, back: 12, up: 5}, effects: [texture, detail, fog, sky, geomorph, skirts, objects, shadow], images: 5}\n"

#define BY_ERROR "view: {size: [160, 90], camera: {chase: a, back: 12, up: 5}, pixel_error: 1, images: 1}\n"

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
		FEW SPHERE SCM,
		FEW MANY "outside: skip\nattributes: [dirt]\nspacing: 0.5\n" VIEW("texture"),
		BUSY CHASE SPHERE,
		BUSY MANY BY_ERROR,
		/* At the world's edge what is left of it fits one window. */
		BUSY OBJECT("sphere: {radius: 62}") SCM "spacing: 0.5\n",
		BUSY HOPS "attributes: [dirt]\n" CHASE,
		BUSY HOPS SCM "spacing: 0.5\n",
		BUSY MANY MAP "spacing: 0.5\n" VIEW("texture, splat"),
		BUSY MANY "soil: {map: classes.png, classes: {1: mud}, default: sand}\n" VIEW("splat, texture, fog"),
		BUSY "view: {" CAMERA ", body: mars, effects: [texture, sky, fog]}\n",
	};
	support_write(support_path("hops.csv"), "t,x,y,z\n0,40,40,150\n0.5,50,50,98\n1,60,60,150\n");
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct outcome outcome = drive(scenes[i]);
		finish(&outcome);
	}
}

/* How many pictures a drive drew, and how many its plan said it would. */
static int64_t pictures_of(const char *text, int64_t *planned_pictures)
{
	struct outcome outcome = drive(text);
	struct report_plan plan;
	must(report_plan(outcome.scene, support_path("effects.furrow"), &plan));
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

/* A view of which no picture is written makes and runs nothing. */
static void a_view_that_nobody_asked_for_costs_nothing(void **state)
{
	struct outcome without = drive(HEAD SPHERE), with = drive(HEAD SPHERE UNSEEN);
	assert_true(with.effects == without.effects);
	assert_int_equal(check_lines(&without.plan, &with.plan, 0) + check_lines(&with.plan, &without.plan, 0), 0);
	assert_int_equal(check_units(without.counts, with.counts), 0);
	finish(&with);
	finish(&without);
}

/* Classes are read for tiles of the working level; for the picture, where it shows them, for all that are drawn. */
static void a_map_that_is_drawn_is_read_for_every_tile(void **state)
{
	write_files();
	for (int drawn = 0; drawn < 2; drawn++) {
		struct outcome outcome = drive(drawn ? HEAD SPHERE MAP VIEW("texture, splat") : HEAD SPHERE MAP VIEW("texture"));
		const cJSON *units = counts_get(outcome.counts, "units");
		int64_t classes = counts_integer(units, plan_unit_name(PLAN_CLASS_SLOT)), bases = counts_integer(units, plan_unit_name(PLAN_BASE_SLOT));
		assert_true(classes > 0 && (classes == bases) == (drawn == 1));
		finish(&outcome);
	}
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

/* Variants multiply; those of all scenes that are shipped are few still. */
static void few_programs_do_for_all_scenes(void **state)
{
	enum { MOST = 40 };
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

static void a_resting_object_runs_no_pass(void **state)
{
	static const char scene_text[] =
		"scene: 1\ntime_step: 0.1\nend_time: 4\n"
		"objects:\n"
		"  - {name: a, shape: {sphere: {radius: 1.5}}, sink: 0.3, path: {points: [[20, 20], [100, 90]], speed: 10}}\n";
	static const char *const models[] = {"box", "sumner", "slippage", "scm"};
	const struct extent wide = {129, 129, 1, 64};
	for (int m = 0; m < 4; m++) {
		char text[512];
		const char *scene = support_path("rests.yaml"), *store = support_path("rests.furrow");
		snprintf(text, sizeof text, "%s%sredistribute: {model: %s}\n", scene_text, m > 0 ? SOIL : "", models[m]);
		support_write(scene, text);
		/* The path takes 10.6 s at 10 m/s; stopped at its end, and with the ground come to rest, further steps add
		 * nothing. */
		long long passes[2];
		const char *const ends[] = {"end_time=40", "end_time=80"};
		for (int i = 0; i < 2; i++) {
			support_store(store, wide, gentle);
			char *json = support_drive(scene, store, (const char *[]){ends[i], NULL});
			passes[i] = support_figure(json, "\"passes\"", "redistribute");
			if (m > 0)
				assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
			mem_free(json);
		}
		assert_true(passes[0] > 100);
		assert_int_equal(passes[0], passes[1]);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_effect_comes_and_goes_alone),
		cmocka_unit_test(nothing_is_made_or_run_for_nothing),
		cmocka_unit_test(every_drive_counts_what_was_planned),
		cmocka_unit_test(only_pictures_that_are_written_are_drawn),
		cmocka_unit_test(a_view_that_nobody_asked_for_costs_nothing),
		cmocka_unit_test(a_map_that_is_drawn_is_read_for_every_tile),
		cmocka_unit_test(a_deformed_store_is_planned_as_it_is),
		cmocka_unit_test(few_programs_do_for_all_scenes),
		cmocka_unit_test(a_resting_object_runs_no_pass),
	};
	return cmocka_run_group_tests_name("effects", tests, support_enter, support_leave);
}
