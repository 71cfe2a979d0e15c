/*
 * Law 7: an effect that the scene does not name costs nothing; one that it names, only itself.
 *
 * Each effect in turn is taken into a scene and out again. Every drive's counts are held to its plan: lines times units,
 * and nothing else. What differs between two plans must be the effect's own; and where it leaves the others' work as it
 * was, their units too are the same. So what was counted differs by the effect's own rows, and by no other.
 */
#include "effects.h"
#include "../support/program.h"

/* --- scenes --- */

#define LOADED SCM "objects:\n  - {name: a, shape: {sphere: {radius: 1.5}}, load: 3000, " PATH "}\n"

#define STANDING "objects:\n  - {name: a, shape: {box: {size: [2, 2, 1]}}, sink: 0.2, path: {points: [[40, 40]], speed: 1}}\n"

#define PLATE(how) "objects:\n  - {name: a, shape: {box: {size: [4, 4, 0.4]}}, sink: 0.8, " how PATH "}\n"

#define VIEW_BY_ERROR(effects) "view: {" CAMERA ", pixel_error: 4, effects: [" effects "]}\n"
#define SAMPLED "view: {" CAMERA ", samples: 4}\n"
#define EXPOSED "view: {" CAMERA ", exposure: auto}\n"

#define SEEN SPHERE "attributes: [dirt]\n"

/* What is asked of the pair: nothing changes what is deformed, so all else is done as often. */
#define ONE_CAMERA "cameras: [{name: x, kind: fixed, pose: {at: [40, 40, 150], pitch: -60}, rate: 2, size: [64, 48], images: [colour, depth, normals]}]\n"

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
	{EFFECT_OF(DEFORM_SHEET), HEAD SPHERE, HEAD SPHERE "redistribute: {model: sheet, tension: 50000}\n", false},
	{EFFECT_OF(DEFORM_SHEET), HEAD SPHERE, "compute: gpu\n" HEAD SPHERE "redistribute: {model: sheet, tension: 50000}\n", false},
	{EFFECT_SPREAD, HEAD SPHERE, HEAD SPHERE SCM, false},
	{EFFECT_SHED, HEAD SPHERE, HEAD SPHERE SOIL "redistribute: {model: sumner}\n", false},
	{EFFECT_SLIDE, HEAD SPHERE, HEAD SPHERE SCM, false},
	{EFFECT_SLIP, HEAD SPHERE STILL_SCM, HEAD SPHERE SCM, false},
	{EFFECT_LOOSE, HEAD SPHERE SCM, HEAD SPHERE LOOSE_SCM, false},
	{EFFECT_DENSE, HEAD SPHERE SCM, HEAD SPHERE DENSE_SCM, false},
	{EFFECT_THROWN, HEAD SPHERE SCM, HEAD SPHERE THROWN_SCM, false},
	{EFFECT_THROWN, HEAD SPHERE SCM VIEW("objects"), HEAD SPHERE THROWN_SCM VIEW("objects"), false},
	{EFFECT_THROWN, HEAD SPHERE SCM VIEW(""), HEAD SPHERE THROWN_SCM VIEW(""), false},
	{EFFECT_CARRIED, HEAD PLATE("") SCM, HEAD PLATE("carry: true, ") SCM, true},
	{EFFECT_CARRIED, HEAD PLATE("") SCM VIEW("objects"), HEAD PLATE("carry: true, ") SCM VIEW("objects"), false},
	{EFFECT_CARRIED, HEAD PLATE("") SCM VIEW("texture"), HEAD PLATE("carry: true, ") SCM VIEW("texture"), false},
	{EFFECT_SOIL_MAP, HEAD SPHERE SCM, HEAD SPHERE MAP, true},
	{EFFECT_SOIL_RASTERS, HEAD SPHERE SCM, HEAD SPHERE RASTERS, true},
	{EFFECT_MESH, HEAD SPHERE, HEAD OBJECT("mesh: {file: block.obj}"), false},
	{EFFECT_GROUSERS, HEAD OBJECT(WHEEL "}"), HEAD OBJECT(WHEEL ", lugs: 12}"), false},
	{EFFECT_TYRES, HEAD OBJECT(WHEEL "}") SCM, HEAD OBJECT(WHEEL ", tyre: {stiffness: 1e5, load: 900}}") SCM, false},
	{EFFECT_LOAD, HEAD SPHERE SCM, HEAD LOADED, false},
	{EFFECT_FORCES, HEAD SPHERE SCM, HEAD SPHERE SCM "output: {forces: 20}\n", true},
	{EFFECT_FORCES, HEAD SPHERE SCM, HEAD LOADED, false},
	{EFFECT_DISTURBANCE, HEAD SPHERE, HEAD SEEN, true},
	{EFFECT_DISTURBANCE, HEAD SPHERE VIEW(""), HEAD SEEN VIEW(""), true},
	{EFFECT_VEGETATION, HEAD SPHERE, HEAD SPHERE "attributes: [vegetation]\n", true},
	{EFFECT_VEGETATION, HEAD SPHERE VIEW(""), HEAD SPHERE "attributes: [vegetation]\n" VIEW(""), true},
	{EFFECT_DISTURBANCE, HEAD SPHERE SCM, HEAD SPHERE SCM "attributes: {disturbance: {heals: 100}}\n", false},
	{EFFECT_SUBDIVIDE, HEAD SPHERE, HEAD SPHERE "spacing: 0.5\n", false},
	{EFFECT_ROCKS, HEAD SPHERE SCM, HEAD SPHERE SCM "ground: {rocks: {cover: 0.1, largest: 5}}\n", false},
	{EFFECT_RELIEF, HEAD SPHERE "spacing: 0.25\n", HEAD SPHERE "spacing: 0.25\nrelief: {roughness: 0.02, wavelength: 2}\n", true},
	{EFFECT_PYRAMID, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_PICTURE, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_NORMALS, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_IMAGES, HEAD SPHERE, HEAD SPHERE VIEW(""), false},
	{EFFECT_CAMERAS, HEAD SEEN VIEW(""), HEAD SEEN VIEW("") ONE_CAMERA, false},
	{EFFECT_LOADERS, SCARCE_HEAD SPHERE, SCARCE("loaders: 2, prefetch: 0") SPHERE, false},
	{EFFECT_PREFETCH, SCARCE_HEAD SPHERE, SCARCE("loaders: 0, prefetch: 0.5") SPHERE, false},
	{EFFECT_TEXTURE, HEAD SEEN VIEW(""), HEAD SEEN VIEW("texture"), true},
	{EFFECT_DETAIL, HEAD SEEN VIEW("texture"), HEAD SEEN VIEW("texture, detail"), true},
	{EFFECT_FOG, HEAD SEEN VIEW(""), HEAD SEEN VIEW("fog"), true},
	{EFFECT_SKY, HEAD SEEN VIEW(""), HEAD SEEN VIEW("sky"), true},
	{EFFECT_GEOMORPH, HEAD SEEN VIEW(""), HEAD SEEN VIEW("geomorph"), true},
	{EFFECT_SKIRTS, HEAD SEEN VIEW(""), HEAD SEEN VIEW("skirts"), true},
	{EFFECT_ANTIALIAS, HEAD SEEN VIEW(""), HEAD SEEN SAMPLED, true},
	{EFFECT_LIGHT, HEAD SEEN VIEW(""), HEAD SEEN EXPOSED, true},
	{EFFECT_PIXEL_ERROR, HEAD SEEN VIEW("geomorph"), HEAD SEEN VIEW_BY_ERROR("geomorph"), false},
	{EFFECT_TEXTURE, HEAD VIEW(""), HEAD VIEW("texture"), true},
	{EFFECT_OBJECTS, HEAD SEEN VIEW(""), HEAD SEEN VIEW("objects"), true},
	{EFFECT_SHADOW, HEAD SEEN VIEW("objects"), HEAD SEEN VIEW("objects, shadow"), true},
	{EFFECT_TERRAIN_SHADOW, HEAD SEEN VIEW(""), HEAD SEEN VIEW("terrain_shadow"), false},
	{EFFECT_IMAGERY, HEAD SEEN VIEW(""), HEAD SEEN VIEW("imagery"), true},
	{EFFECT_SPLAT, HEAD SPHERE MAP VIEW("texture"), HEAD SPHERE MAP VIEW("texture, splat"), true},
	{EFFECT_SPLAT, HEAD MAP VIEW("texture"), HEAD MAP VIEW("texture, splat"), true},
};
#define PAIRS (sizeof pairs / sizeof *pairs)

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
	char words[256];
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

/* The lines of slots, which every drive has. Where the CPU alone computes, the home of tiles is host memory, and otherwise slots of the GPU. */
static bool is_home(const struct plan_line *line)
{
	return line->effect == NULL && (line->unit == PLAN_BASE_SLOT || line->unit == PLAN_RING || line->unit == PLAN_HOST_BASE ||
					strcmp(line->name, "loads: base") == 0);
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
		if (((own >> EFFECT_OF(DEFORM_SCM) & 1) || (own >> EFFECT_OF(DEFORM_SHEET) & 1)) && is_home(line))
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

/* What follows from when an epoch ends, and from how far the driver is; where counts do not repeat, visits too. */
static bool goes_by_the_clock(const char *unit, bool repeats)
{
	static const enum plan_unit units[] = {PLAN_PAGE, PLAN_HOST_OFFSET, PLAN_HOST_DISTURBANCE, PLAN_HOST_DEPOSITED, PLAN_HOST_SINKAGE, PLAN_HOST_SHEAR,
					       PLAN_HOST_DUG, PLAN_HOST_SETTLED, PLAN_HOST_LOOSE, PLAN_HOST_FLOOR, PLAN_HOST_DENSITY, PLAN_HOST_SLOPE, PLAN_RING, PLAN_COMMITTED, PLAN_COMMITTED_COARSER, PLAN_CHANGED, PLAN_COMMIT,
					       PLAN_HELD, PLAN_RESTING, PLAN_ATLAS};
	enum { VISITS = 3 };
	for (size_t i = 0; i < sizeof units / sizeof *units - (repeats ? VISITS : 0); i++)
		if (strcmp(unit, plan_unit_name(units[i])) == 0)
			return true;
	return false;
}

static int check_units(const struct outcome *first, const struct outcome *second)
{
	const cJSON *a = first->counts, *b = second->counts;
	int problems = 0;
	for (const cJSON *unit = counts_get(a, "units")->child; unit != NULL; unit = unit->next) {
		const cJSON *other = counts_get(counts_get(b, "units"), unit->string);
		/* Slots of classes are the map's own, and counted for it; so are numbers in memory, and draws of objects. */
		if (goes_by_the_clock(unit->string, first->repeats) || strcmp(unit->string, plan_unit_name(PLAN_CLASS_SLOT)) == 0 ||
		    strcmp(unit->string, plan_unit_name(PLAN_WINDOW_SCRATCH)) == 0 || /* has numbers of each soil */
		    strcmp(unit->string, plan_unit_name(PLAN_HOST_CLASSES)) == 0 || strcmp(unit->string, plan_unit_name(PLAN_HOST_NUMBERS)) == 0 ||
		    strcmp(unit->string, plan_unit_name(PLAN_LEFT)) == 0 || strcmp(unit->string, plan_unit_name(PLAN_INHERITED)) == 0 || strcmp(unit->string, plan_unit_name(PLAN_KEPT)) == 0 || strcmp(unit->string, plan_unit_name(PLAN_OBJECTS)) == 0 ||
		    strcmp(unit->string, plan_unit_name(PLAN_SHADOWED)) == 0)
			continue;
		if (!cJSON_Compare(unit, other, true)) {
			print_error("unit %s differs: %g, %g\n", unit->string, unit->valuedouble, other != NULL ? other->valuedouble : NAN);
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
	/* A contact sums forces, whoever asks for them: rows of forces alone cost nothing. A tyre is another law in the same contacts. */
	assert_true((own > 0) != ((pair->effect == EFFECT_FORCES && pair->same_work) || pair->effect == EFFECT_TYRES));
	problems += check_lines(&with->plan, &without->plan, (before & ~after) | (after & ~before));
	if (pair->same_work)
		problems += check_units(without, with);
	if (problems > 0) {
		print_error("of %s\n", scene_effect_row(pair->effect)->name);
		fail();
	}
}

static void each_effect_comes_and_goes_alone(void **state)
{
	bool done[PAIRS] = {false};
	uint64_t seen = 0;
	write_files();
	if (!has_meshes())
		seen |= EFFECT_BIT(EFFECT_MESH);
	if (!store_imagery_possible())
		seen |= EFFECT_BIT(EFFECT_IMAGERY);
	for (size_t i = 0; i < PAIRS; i++) {
		if (done[i])
			continue;
		struct outcome without = drive(pairs[i].without);
		for (size_t k = i; k < PAIRS; k++) {
			if (strcmp(pairs[k].without, pairs[i].without) != 0)
				continue;
			done[k] = true;
			if (seen >> pairs[k].effect & 1 && (pairs[k].effect == EFFECT_MESH || pairs[k].effect == EFFECT_IMAGERY))
				continue;
			struct outcome with = drive(pairs[k].with);
			check_pair(&pairs[k], &without, &with);
			seen |= EFFECT_BIT(pairs[k].effect);
			finish(&with);
		}
		/* All taken out again: the first numbers again. */
		struct outcome again = drive(pairs[i].without);
		assert_int_equal(check_lines(&without.plan, &again.plan, 0) + check_lines(&again.plan, &without.plan, 0), 0);
		if (check_units(&without, &again) != 0)
			fail_msg("a scene that is run twice: %s", pairs[i].without);
		finish(&again);
		finish(&without);
	}
	assert_int_equal(seen, EFFECT_BIT(EFFECT_COUNT) - 1); /* none was forgotten */
}

/* --- whatever the scene --- */

/* A view of which no picture is written makes and runs nothing. */
static void a_view_that_nobody_asked_for_costs_nothing(void **state)
{
	struct outcome without = drive(HEAD SPHERE), with = drive(HEAD SPHERE UNSEEN);
	assert_true(with.effects == without.effects);
	assert_int_equal(check_lines(&without.plan, &with.plan, 0) + check_lines(&with.plan, &without.plan, 0), 0);
	assert_int_equal(check_units(&without, &with), 0);
	finish(&with);
	finish(&without);
}

/* Settings that call for nothing here make and run nothing: the plan is that of the scene without them, and so is what was counted. */
static void what_is_not_called_for_costs_nothing(void **state)
{
	static const struct {
		const char *without, *with;
		enum scene_effect effect;
	} cases[] = {
		/* Every tile has a slot. */
		{HEAD SPHERE, READ("loaders: 2, prefetch: 0.5") SPHERE, EFFECT_LOADERS},
		{HEAD SPHERE VIEW(""), READ("loaders: 2, prefetch: 0.5") SPHERE VIEW(""), EFFECT_PREFETCH},
		/* Nothing slips: a wheel that rolls straight ahead, and a body that stands. */
		{HEAD OBJECT(WHEEL "}") STILL_SCM, HEAD OBJECT(WHEEL "}") SCM, EFFECT_SLIP},
		{HEAD STANDING STILL_SCM, HEAD STANDING SCM, EFFECT_SLIP},
		/* Loads sum forces, whether or not rows tell them. */
		{HEAD LOADED, HEAD LOADED "output: {forces: 20}\n", EFFECT_IMAGES},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct outcome without = drive(cases[i].without), with = drive(cases[i].with);
		assert_true(with.effects == without.effects);
		assert_false(with.effects >> cases[i].effect & 1);
		assert_int_equal(check_lines(&without.plan, &with.plan, 0) + check_lines(&with.plan, &without.plan, 0), 0);
		assert_int_equal(check_units(&without, &with), 0);
		assert_true(cJSON_Compare(counts_get(without.json, "volume"), counts_get(with.json, "volume"), true));
		finish(&with);
		finish(&without);
	}
}

TEST_PROGRAM(effects)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_effect_comes_and_goes_alone),
		cmocka_unit_test(what_is_not_called_for_costs_nothing),
		cmocka_unit_test(a_view_that_nobody_asked_for_costs_nothing),
	};
	return cmocka_run_group_tests_name("effects", tests, support_enter, support_leave);
}
