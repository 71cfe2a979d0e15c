/*
 * Law 3 over whole drives: however many slots and loaders there are, whatever is loaded ahead, and
 * whether or not somebody watches, the same rows are left, by one content hash.
 */
#include "../support.h"
#include "../support/program.h"

static const struct extent extent = {257, 257, 2, 64};

/* At 0.25 m a tile is 16 m wide; the paths cross: after 4.9 s `b` meets the rut of `a`, and after 5.8 s `c` does. */
static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.05\n"
	"end_time: 6.4\n"
	"spacing: 0.25\n"
	"redistribute: {model: box}\n"
	"attributes: [dirt]\n"
	"objects:\n"
	"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
	"     path: {points: [[20, 20], [480, 480], [470, 40]], speed: 80}}\n"
	"  - {name: b, shape: {sphere: {radius: 2.5}}, sink: 0.5,\n"
	"     path: {points: [[64, 400], [64, 100], [400, 128], [128, 140]], speed: 70}}\n"
	"  - {name: c, shape: {box: {size: [3, 2, 1]}}, sink: 0.3,\n"
	"     path: {points: [[250, 20], [256, 500]], speed: 40}}\n";

static const char view_text[] =
	"view:\n"
	"  size: [160, 90]\n"
	"  camera: {chase: a, back: 14, up: 9}\n"
	"  effects: [texture, sky, geomorph, skirts]\n"
	"  images: 40\n";

/* The fewest that a window needs; more than one window, fewer than are touched; all that are. */
#define FEWEST "4"
#define SOME "32"
#define ALL "2048"

struct setup {
	const char *slots, *loaders, *prefetch;
	bool view;
};

/* Drives a fresh store and returns its content hash; `numbers` its run.json, freed by the caller. */
static uint64_t drive(const struct setup *setup, char **json)
{
	char text[sizeof scene_text + sizeof view_text], settings[3][48];
	const char *store = support_path("slots.furrow"), *scene = support_path("scene.yaml");
	snprintf(text, sizeof text, "%s%s", scene_text, setup->view ? view_text : "");
	support_write(scene, text);
	support_store(store, extent, support_hills);
	snprintf(settings[0], sizeof settings[0], "cache.slots=%s", setup->slots);
	snprintf(settings[1], sizeof settings[1], "cache.loaders=%s", setup->loaders);
	snprintf(settings[2], sizeof settings[2], "cache.prefetch=%s", setup->prefetch);
	*json = support_drive(scene, store, (const char *[]){settings[0], settings[1], settings[2], NULL});
	struct store_check check = support_verify(store);
	assert_int_equal(check.finest, -3);
	return support_hash(store);
}

static void check_figures(const struct setup *setup, const char *json)
{
	long long touched = support_figure(json, "\"cache\"", "touched");
	long long evictions = support_figure(json, "\"cache\"", "evictions");
	assert_true(touched > 2 * atoi(SOME) && touched < atoi(ALL));
	assert_true(support_figure(json, "\"cache\"", "writebacks") >= touched);
	if (strcmp(setup->slots, ALL) == 0)
		assert_int_equal(evictions, 0);
	else
		assert_true(evictions >= touched - atoi(setup->slots));
}

static uint64_t first; /* the rows' hash */

/* Each number of slots with each way of prefetching; each number of loaders with the fewest slots. */
static void no_slots_loaders_or_prefetch_show_in_the_rows(void **state)
{
	static const struct setup setups[] = {
		{ALL, "2", "0", false},    {ALL, "2", "1.5", false},    {SOME, "2", "0", false},   {SOME, "2", "1.5", false},
		{FEWEST, "0", "0", false}, {FEWEST, "1", "1.5", false}, {FEWEST, "2", "1.5", false}, {FEWEST, "4", "1.5", false},
	};
	for (size_t i = 0; i < sizeof setups / sizeof *setups; i++) {
		char *json;
		uint64_t hash = drive(&setups[i], &json);
		check_figures(&setups[i], json);
		mem_free(json);
		first = i == 0 ? hash : first;
		if (hash != first)
			fail_msg("%s slots, %s loaders, prefetch %s: other rows", setups[i].slots, setups[i].loaders,
				 setups[i].prefetch);
	}
}

/* Those of the drives before, which drew none. */
static void no_picture_shows_in_the_rows(void **state)
{
	char *json;
	uint64_t hash = drive(&(struct setup){SOME, "2", "1.5", true}, &json);
	assert_int_equal(support_figure(json, "\"view\"", "frames"), 3);
	mem_free(json);
	assert_true(first != 0 && hash == first);
}

TEST_PROGRAM(slots)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_slots_loaders_or_prefetch_show_in_the_rows),
		cmocka_unit_test(no_picture_shows_in_the_rows),
	};
	return cmocka_run_group_tests_name("slots", tests, support_enter, support_leave);
}
