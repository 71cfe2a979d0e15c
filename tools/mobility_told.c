/* furrow mobility: what it says at its end: the steepest slopes, shares of the terrain, and as JSON the whole table. */
#include <math.h>
#include <stdio.h>

#include "json.h"
#include "mobility.h"

#define SLIPS 2
static const int headings[] = {0, MOBILITY_HEADINGS - 1};

/* The steepest slope of a table at which it goes straight up, or along the slope; NaN: at none. */
static double steepest(const struct mobility_table *table, int heading)
{
	double slope = NAN;
	for (int i = 0; i < MOBILITY_SLOPES && table->verdicts[i][heading].reason == MOBILITY_GO; i++)
		slope = i * MOBILITY_SLOPE_STEP;
	return slope;
}

static const char *ends_by(const struct mobility_table *table, int heading)
{
	for (int i = 0; i < MOBILITY_SLOPES; i++)
		if (table->verdicts[i][heading].reason != MOBILITY_GO)
			return trials_reason_names[table->verdicts[i][heading].reason];
	return "the table's end";
}

/* The steepest slopes that all of the spread's soils carry it straight up, and that any of them does. */
static void print_spread(const struct mobility_map *map)
{
	double all = NAN, any = NAN;
	for (int i = 0; i < MOBILITY_SLOPES; i++) {
		const double probability = trials_probability(map->columns, map->samples, i * MOBILITY_SLOPE_STEP);
		if (probability == 1)
			all = i * MOBILITY_SLOPE_STEP;
		if (probability > 0)
			any = i * MOBILITY_SLOPE_STEP;
	}
	printf("straight up, of %zu soils of the spread: all of them up to %.1f degrees, one at least up to %.1f\n", map->samples, all, any);
}

static const double slips[SLIPS] = {0.2, 0.3};

/* The steepest slope that it climbs straight up while no wheel slips by more; NaN: none. */
static double steepest_at(const struct mobility_table *table, double slip)
{
	double slope = NAN;
	for (int i = 0; i < MOBILITY_SLOPES && table->verdicts[i][0].reason == MOBILITY_GO && table->verdicts[i][0].slip <= slip; i++)
		slope = i * MOBILITY_SLOPE_STEP;
	return slope;
}

/* The end of climbing is no slope to plan with: there the wheels hardly move it. */
static void print_slips(const struct mobility_map *map)
{
	for (int i = 0; i < SLIPS; i++) {
		const double slope = steepest_at(map->table, slips[i]);
		printf(i == 0 ? "straight up with a slip of at most %g: " : "; %g: ", slips[i]);
		if (isnan(slope))
			fputs("not even on level ground", stdout);
		else
			printf("up to %.1f degrees", slope);
	}
	putchar('\n');
}

void mobility_print(const struct mobility_map *map)
{
	static const char *const ways[] = {"straight up", "along the slope"};
	printf("%s, %g kg, in %s at %g m/s2\n", map->vehicle, map->mass, map->soil, map->gravity);
	for (int i = 0; i < 2; i++) {
		const double slope = steepest(map->table, headings[i]);
		if (isnan(slope)) {
			printf("%s: not even on level ground (%s)\n", ways[i], ends_by(map->table, headings[i]));
			continue;
		}
		const struct mobility_verdict *last = &map->table->verdicts[(int)(slope / MOBILITY_SLOPE_STEP)][headings[i]];
		printf("%s: up to %.1f degrees, slip %.2f there%s", ways[i], slope, last->slip, i == 0 ? ", where climbing ends" : "");
		if (last->crab > 0)
			printf(", nose %.0f degrees up the slope", last->crab);
		printf("; steeper: %s\n", ends_by(map->table, headings[i]));
		if (i == 0)
			print_slips(map);
	}
	if (map->samples > 0)
		print_spread(map);
	for (int i = 0; i < CLASSES; i++)
		printf("%s%s %.1f %%", i > 0 ? ", " : "of the terrain: ", mobility_classes[i], 100 * map->shares[i]);
	printf("\n%s: %lld x %lld cells of %g m\n", map->path, (long long)(map->rect.x1 - map->rect.x0), (long long)(map->rect.y1 - map->rect.y0),
	       extent_spacing(&map->meta->extent, map->level));
}

/* A row of the table: one slope. */
static cJSON *slope_of(const struct mobility_map *map, int slope)
{
	cJSON *row = cJSON_CreateObject(), *verdicts = cJSON_CreateArray();
	json_number(row, "slope", slope * MOBILITY_SLOPE_STEP);
	json_number(row, "probability", trials_probability(map->columns, map->samples, slope * MOBILITY_SLOPE_STEP));
	for (int i = 0; i < MOBILITY_HEADINGS; i++) {
		const struct mobility_verdict *verdict = &map->table->verdicts[slope][i];
		cJSON *one = cJSON_CreateObject();
		json_number(one, "heading", 90 - i * MOBILITY_HEADING_STEP);
		cJSON_AddStringToObject(one, "reason", trials_reason_names[verdict->reason]);
		json_number(one, "slip", verdict->slip);
		json_number(one, "crab", verdict->crab);
		json_number(one, "torque", verdict->torque);
		json_number(one, "sinkage", verdict->sinkage);
		cJSON_AddItemToArray(verdicts, one);
	}
	cJSON_AddItemToObject(row, "verdicts", verdicts);
	return row;
}

enum status mobility_print_json(const struct mobility_map *map)
{
	cJSON *object = cJSON_CreateObject(), *shares = cJSON_CreateObject(), *slopes = cJSON_CreateArray();
	cJSON_AddStringToObject(object, "vehicle", map->vehicle);
	cJSON_AddStringToObject(object, "soil", map->soil);
	json_number(object, "mass", map->mass);
	json_number(object, "gravity", map->gravity);
	cJSON_AddItemToObject(object, "spread", cJSON_CreateDoubleArray(map->spread, 3));
	json_integer(object, "samples", (int64_t)map->samples);
	json_integer(object, "seed", map->seed);
	json_number(object, "cell", extent_spacing(&map->meta->extent, map->level));
	json_number(object, "steepest_up", steepest(map->table, headings[0]));
	for (int i = 0; i < SLIPS; i++) {
		char key[40];
		snprintf(key, sizeof key, "steepest_up_slip_%g", slips[i]);
		json_number(object, key, steepest_at(map->table, slips[i]));
	}
	json_number(object, "steepest_along", steepest(map->table, headings[1]));
	for (int i = 0; i < CLASSES; i++)
		json_number(shares, mobility_classes[i], map->shares[i]);
	cJSON_AddItemToObject(object, "shares", shares);
	for (int i = 0; i < MOBILITY_SLOPES; i++)
		cJSON_AddItemToArray(slopes, slope_of(map, i));
	cJSON_AddItemToObject(object, "slopes", slopes);
	return json_print(object);
}
