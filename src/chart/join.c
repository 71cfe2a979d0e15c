/*
 * Joins ways of a map that lie on each other, if their names differ in the number at the end only. They become one way with one name:
 * "left-1 ... left-10". So copies of a template that pass over one way do not crowd the map.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chart/internal.h"

#define NEAR 0.01 /* m: places that are no farther apart count as the same */

/* Returns the length of the name without "-NUMBER"; 0: it does not end so. */
static size_t stem(const char *name)
{
	const size_t length = strlen(name);
	size_t end = length;
	while (end > 0 && name[end - 1] >= '0' && name[end - 1] <= '9')
		end--;
	return end < length && end > 1 && name[end - 1] == '-' ? end - 1 : 0;
}

static bool same_place(const double a[2], const double b[2])
{
	return fabs(a[0] - b[0]) <= NEAR && fabs(a[1] - b[1]) <= NEAR;
}

/* The last place of the shorter way may be on its way to the next corner. */
static bool same_way(const struct chart_way *a, const struct chart_way *b)
{
	const size_t length = stem(a->name), least = a->count < b->count ? a->count : b->count;
	if (a->vehicle != b->vehicle || length == 0 || length != stem(b->name) || memcmp(a->name, b->name, length) != 0)
		return false;
	for (size_t i = 0; i + 1 < least; i++)
		if (!same_place(a->places[i], b->places[i]))
			return false;
	return least > 1 ? a->count != b->count || same_place(a->places[least - 1], b->places[least - 1]) : least == 0 || same_place(a->places[0], b->places[0]);
}

static bool is_before(const struct chart_way *a, const struct chart_way *b)
{
	return strtoul(a->name + stem(a->name) + 1, NULL, 10) < strtoul(b->name + stem(b->name) + 1, NULL, 10);
}

/* Joins to ways[first] all later ways that are the same, which `taken` then has. */
static enum status join(const struct chart_way *ways, size_t count, size_t first, bool *taken, struct chart_way *out, char **name)
{
	const struct chart_way *low = &ways[first], *high = low, *longest = low;
	size_t joined = 1;
	for (size_t i = first + 1; i < count; i++) {
		if (taken[i] || !same_way(&ways[first], &ways[i]))
			continue;
		taken[i] = true;
		joined++;
		low = is_before(&ways[i], low) ? &ways[i] : low;
		high = is_before(high, &ways[i]) ? &ways[i] : high;
		longest = ways[i].count > longest->count ? &ways[i] : longest;
	}
	*out = *longest;
	if (joined == 1)
		return STATUS_OK;
	const size_t room = strlen(low->name) + strlen(high->name) + 8;
	*name = mem_alloc(room, 1);
	if (*name == NULL)
		return fail_memory("a map's names");
	snprintf(*name, room, "%s%s%s", low->name, joined > 2 ? " ... " : ", ", high->name);
	out->name = *name;
	return STATUS_OK;
}

enum status chart_ways_join(const struct chart_way *ways, size_t count, struct chart_joined *out)
{
	bool *taken = mem_calloc(count + 1, sizeof *taken);
	*out = (struct chart_joined){mem_calloc(count + 1, sizeof *out->ways), mem_calloc(count + 1, sizeof *out->names), 0};
	enum status status;
	TRY_OR(done, taken != NULL && out->ways != NULL && out->names != NULL ? STATUS_OK : fail_memory("a map's names"));
	for (size_t i = 0; i < count; i++)
		if (!taken[i]) {
			TRY_OR(done, join(ways, count, i, taken, &out->ways[out->count], &out->names[out->count]));
			out->count++;
		}
done:
	mem_free(taken);
	if (status != STATUS_OK)
		chart_joined_finish(out);
	return status;
}

void chart_joined_finish(struct chart_joined *joined)
{
	mem_free_list(joined->names, joined->count);
	mem_free(joined->ways);
	*joined = (struct chart_joined){.ways = NULL};
}
