/* Soil that a plate carries: it scoops it, takes it along over tile borders, and empties when it is tilted. All of it to the unit, with any tiles and threads. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../support/near.h"
#include "../support/program.h"
#include "hard.h"

#define LOW 20.0      /* m: the ground */
#define WAY 14.142136 /* m: east and north, together 20 m */
#define WEIGHT 16000.0 /* N/m3 */

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return LOW;
}

/* A plate of 1 x 2 x 0.1 m. It digs 0.15 m deep for 0.9 m, is lifted, goes 20 m at 45 degrees, and is tilted or not. */
struct way {
	double spacing, tilt; /* m; degrees */
	uint32_t cells;
	double until;         /* s */
	int threads;          /* 0: as many as are worth it */
	bool pair;            /* another plate is below it where it is tilted */
};

static long long carried_by(const char *json, const char *name)
{
	return support_figure(json, "\"plate\"", name);
}

static void write_way(const struct way *way)
{
	char text[900];
	const double x = 6 + 0.9, y = 6;
	snprintf(text, sizeof text,
		 "t,x,y,z,yaw,pitch,roll\n0,6,6,%.9g,0,0,0\n2,%.9g,6,%.9g,0,0,0\n4,%.9g,6,%.9g,0,0,0\n14,%.9g,%.9g,%.9g,0,0,0\n16,%.9g,%.9g,%.9g,0,%.9g,0\n20,%.9g,%.9g,%.9g,0,%.9g,0\n",
		 LOW - 0.1, x, LOW - 0.1, x + 0.05, LOW + 0.9, x + WAY, y + WAY, LOW + 0.9, x + WAY, y + WAY, LOW + 0.9, way->tilt, x + WAY, y + WAY, LOW + 0.9, way->tilt);
	support_write(support_path("plate.csv"), text);
	snprintf(text, sizeof text, "t,x,y,z,yaw,pitch,roll\n0,%.9g,%.9g,%.9g,30,0,0\n20,%.9g,%.9g,%.9g,30,0,0\n", x + WAY, y + WAY, LOW + 0.35, x + WAY, y + WAY, LOW + 0.35);
	support_write(support_path("other.csv"), text);
}

/* Drives, and holds the ledger to its law: offsets + carried + compacted = 0. Returns run.json. */
static char *drive(const struct way *way, const char *store)
{
	char text[900];
	support_store(store, (struct extent){129, 129, 0.25, way->cells}, flat);
	write_way(way);
	snprintf(text, sizeof text,
		 "scene: 1\nspacing: %g\ntime_step: 0.1\nend_time: %g\nsoil: {name: dry_sand, unit_weight: %g}\nredistribute: {model: scm}\noutput: {forces: 10}\n"
		 "objects:\n  - {name: plate, shape: {box: {size: [1, 2, 0.1]}}, carry: true, path: {file: plate.csv}}\n%s", way->spacing, way->until, WEIGHT,
		 way->pair ? "  - {name: other, shape: {box: {size: [1.5, 1.5, 0.1]}}, carry: true, path: {file: other.csv}}\n" : "");
	support_write(support_path("carried.yaml"), text);
	struct scene *scene = support_scene(support_path("carried.yaml"), NULL);
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path("out"), .threads = way->threads};
	struct drive_result result;
	must(drive_run(&params, &result));
	scene_destroy(scene);
	char *json = result.json;
	assert_int_equal(support_figure(json, "\"counts\"", "unplanned"), 0);
	const struct store_check check = support_verify(store);
	const long long offsets = check.offset_sum[-(int)lround(log2(0.25 / way->spacing)) - TILE_LEVEL_MIN];
	const long long compacted = support_figure(json, "\"quanta\"", "compacted"), carried = support_figure(json, "\"quanta\"", "carried");
	assert_int_equal(offsets + compacted + carried, 0);
	assert_true(way->pair ? carried > carried_by(json, "quanta") : carried == carried_by(json, "quanta"));
	return json;
}

/* Returns column `number` of the row of objects.csv at a time, s. */
static double row_at(double time, int number)
{
	char path[160], line[1024];
	double found = NAN;
	snprintf(path, sizeof path, "%s/objects.csv", support_path("out"));
	FILE *rows = fopen(path, "r");
	assert_non_null(rows);
	while (fgets(line, sizeof line, rows) != NULL) {
		char *at = line;
		if (fabs(atof(line) - time) > 1e-6 || line[0] == 't')
			continue;
		for (int i = 0; i < number; i++)
			at = strchr(at, ',') + 1;
		found = atof(at);
	}
	fclose(rows);
	return found;
}

static void a_plate_keeps_its_soil_for_20_m(void **state)
{
	static const struct way ways[] = {{0.0625, 0, 32, 5, 0, false}, {0.0625, 0, 32, 14, 0, false}, {0.03125, 0, 16, 5, 0, false}, {0.03125, 0, 16, 14, 0, false}};
	long long units = 0;
	(void)state;
	for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
		char *json = drive(&ways[i], support_path("carried.furrow"));
		const long long carried = carried_by(json, "quanta");
		const double litres = 1e3 * ldexp((double)carried, -OFFSET_BITS) * ways[i].spacing * ways[i].spacing, force = row_at(ways[i].until, 8);
		print_message("%g m, tiles of %u cells, after %g s: %.3f l aboard, %lld units, the force is %.4f N\n", ways[i].spacing, ways[i].cells, ways[i].until, litres, carried, force);
		assert_true(litres > 50 && litres < 200);
		assert_true(fabs(force + WEIGHT * litres * 1e-3) < 0.001 * WEIGHT * litres * 1e-3);
		assert_true(i % 2 == 0 || carried == units);
		units = carried;
		mem_free(json);
	}
}

/* Litres of ground above the level ground where the plate is tilted. */
static double landed(const char *store, double spacing)
{
	const int64_t side = (int64_t)lround(6 / spacing), x0 = (int64_t)lround((6.95 + WAY - 3) / spacing), y0 = (int64_t)lround((6 + WAY - 3) / spacing);
	double *quanta = support_quanta(store, -(int)lround(log2(0.25 / spacing)), (struct post_rect){x0, y0, x0 + side, y0 + side}), sum = 0;
	for (int64_t i = 0; i < side * side; i++)
		sum += quanta[i];
	mem_free(quanta);
	return ldexp(sum, -OFFSET_BITS) * spacing * spacing * 1e3;
}

static void a_tilted_plate_empties(void **state)
{
	static const double tilts[] = {-50, 60, -20};
	(void)state;
	for (size_t i = 0; i < sizeof tilts / sizeof *tilts; i++) {
		struct way way = {0.0625, tilts[i], 32, 14, 0, false};
		const char *store = support_path("carried.furrow");
		char *json = drive(&way, store);
		const long long before = carried_by(json, "quanta");
		mem_free(json);
		way.until = 20;
		json = drive(&way, store);
		const long long after = carried_by(json, "quanta");
		const double unit = 1e3 * ldexp(way.spacing * way.spacing, -OFFSET_BITS), litres = landed(store, way.spacing);
		print_message("tilted by %g degrees: %.3f of %.3f l stay aboard, %.6f l landed\n", tilts[i], (double)after * unit, (double)before * unit, litres);
		assert_true(fabs(tilts[i]) > 40 ? (double)after < 0.02 * (double)before : (double)after > 0.3 * (double)before);
		assert_true(fabs(litres - (double)(before - after) * unit) < 1e-6); /* what landed is what was carried */
		mem_free(json);
	}
}

static void tiles_and_threads_do_not_show(void **state)
{
	static const struct way ways[] = {{0.0625, 60, 32, 15.1, 1, true}, {0.0625, 60, 8, 15.1, 1, true}, {0.0625, 60, 128, 15.1, 3, true}, {0.0625, 60, 32, 15.1, 2, true}};
	const int64_t side = (int64_t)lround(32 / 0.0625);
	double *first = NULL;
	long long units = 0;
	(void)state;
	for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
		const char *store = support_path("carried.furrow");
		char *json = drive(&ways[i], store);
		double *quanta = support_quanta(store, -2, (struct post_rect){0, 0, side, side});
		if (i == 0)
			units = carried_by(json, "quanta");
		assert_int_equal(carried_by(json, "quanta"), units);
		if (first != NULL)
			assert_memory_equal(first, quanta, (size_t)(side * side) * sizeof *quanta);
		if (first == NULL)
			first = quanta;
		else
			mem_free(quanta);
		mem_free(json);
	}
	mem_free(first);
}

TEST_PROGRAM(carried)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plate_keeps_its_soil_for_20_m),
		cmocka_unit_test(a_tilted_plate_empties),
		cmocka_unit_test(tiles_and_threads_do_not_show),
	};
	return cmocka_run_group_tests_name("carried", tests, support_enter, support_leave);
}
