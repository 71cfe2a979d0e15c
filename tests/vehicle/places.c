/*
 * A wheel drives over a ridge of 0.3 m. The place does not matter: other tiles, 8,000 m up or down, 10,000 km away, few slots. Nowhere does it
 * lose the ground.
 */
#include <math.h>

#include "../support/near.h"
#include "drive.h"
#include "../support/program.h"

#define STEPS 500 /* rows */

static double height, crest; /* m; posts */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	const double along = fabs((double)x - crest) / 8;
	return height + (along < 1 ? 0.15 * (1 + cos(M_PI * along)) : 0);
}

struct place {
	const char *name;
	double height, east, north; /* m: of the ground; of the store's south-west post */
	double x, y;                /* m: where the wheel starts, from there */
	const char *const *settings;
};

static size_t drive(const struct place *place, struct drive_row *rows)
{
	static const struct extent extent = {257, 129, 0.25, 64};
	char text[1024], *model, path[512];
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	snprintf(path, sizeof path, "%s/one_wheel.xml", getenv("MODELS"));
	model = support_text(path);
	support_write(support_path("one_wheel.xml"), model);
	free(model);
	height = place->height;
	crest = (place->x + 2.5) / 0.25;
	support_store_at(store, extent, ground, place->east, place->north);
	snprintf(text, sizeof text, "scene: 1\nend_time: 5\ntime_step: 0.002\nspacing: 0.125\ncoordinates: store\nsoil: {name: sandy_loam_15}\n"
				    "redistribute: {model: scm}\nvehicles:\n  - {name: v, model: one_wheel.xml, start: {at: [%.3f, %.3f]}, driver: {hold: {drive: 4}}}\n"
				    "output: {forces: 100, vehicles: 100}\n", place->east + place->x, place->north + place->y);
	support_write(scene, text);
	must(make_drive(scene, store, place->settings, &(struct drive_cut){.out = support_path("out"), .overlay = support_path("over.furrow")}, NULL));
	unlink(support_path("over.furrow"));
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, STEPS + 1);
}

/* Rows of objects.csv in which the wheel does not touch. */
static int lost(void)
{
	char *text = support_text(support_path("out/objects.csv"));
	int count = 0;
	for (char *line = strchr(text, '\n'); line != NULL && line[1] != '\0'; line = strchr(line + 1, '\n')) {
		char *end = strchr(line + 1, '\n');
		*end = '\0';
		count += strstr(line + 1, "touching") == NULL;
		*end = '\n';
	}
	free(text);
	return count;
}

static void the_place_does_not_matter(void **state)
{
	static const char *const few[] = {"cache.slots=4", "cache.loaders=0", NULL}, *const many[] = {"cache.slots=256", NULL};
	static const struct place places[] = {
		{"here", 20, 0, 0, 10, 16, many},
		{"through four slots", 20, 0, 0, 10, 16, few},
		{"over other tiles", 20, 0, 0, 10 + 24.5, 16 + 3.25, many},
		{"8,000 m up", 8000, 0, 0, 10, 16, many},
		{"8,000 m down", -8000, 0, 0, 10, 16, many},
		{"10,000 km away", 20, 1e7, -1e7, 10, 16, many},
	};
	static struct drive_row rows[STEPS + 1], first[STEPS + 1];
	(void)state;
	for (size_t p = 0; p < sizeof places / sizeof places[0]; p++) {
		const struct place *place = &places[p];
		assert_int_equal(drive(place, rows), STEPS + 1);
		if (p == 0)
			memcpy(first, rows, sizeof rows);
		double worst = 0, highest = 0;
		for (int r = 0; r <= STEPS; r++) {
			const double way[3] = {rows[r].x - place->x - (first[r].x - places[0].x), rows[r].y - place->y - (first[r].y - places[0].y),
					       rows[r].z - place->height - (first[r].z - places[0].height)};
			worst = support_most(worst, sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]));
			highest = support_most(highest, rows[r].z - rows[0].z);
		}
		const int air = lost();
		print_message("%s: came %.3f m far, rose by %.3f m, at most %.2g m elsewhere, %d rows in the air\n", place->name,
			      rows[STEPS].x - rows[0].x, highest, worst, air);
		assert_true(highest > 0.25 && rows[STEPS].x - rows[0].x > 3.5 && air == 0);
		/* 8,000 m up a place is rounded to 1e-12 m; over 5 m of way through heaps that grows. */
		assert_true(p == 1 ? worst == 0 : worst < 5e-4);
	}
}

TEST_PROGRAM(places)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(the_place_does_not_matter)};
	return cmocka_run_group_tests_name("places of vehicles", tests, support_enter, support_leave);
}
