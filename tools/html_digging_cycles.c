/* The cycles of a body that digs: it fills, holds what it brought, and dumps it. */
#include "html_digging.h"

#define SWING 0.1  /* of the most that was aboard: a smaller rise or fall is part of what it interrupts */
#define LEVEL 0.05 /* of a peak's rise: a load that changes by less is held */

static double largest_of(const double *volume, size_t count)
{
	double most = 0;
	for (size_t i = 0; i < count; i++)
		most = volume[i] > most ? volume[i] : most;
	return most;
}

/* Finds the longest time behind the peak in which the volume falls by no more than a twentieth. Smaller rises count as level: `highest` is the highest from a row on. */
static enum status find_hold(const struct html_body *body, struct html_cycle *cycle)
{
	const double *volume = body->digging->values[DIG_VOLUME], *time = body->time;
	const double within = LEVEL * (volume[cycle->peak] - volume[cycle->low]);
	const size_t from = cycle->peak, count = cycle->end - from + 1;
	double *highest, longest = -1;
	size_t last = from;
	TRY(mem_make(&highest, count, sizeof *highest, "cycles"));
	for (size_t i = count; i-- > 0;)
		highest[i] = i + 1 < count && highest[i + 1] > volume[from + i] ? highest[i + 1] : volume[from + i];
	for (size_t a = 0, b = 0; a < count; a++) {
		b = b > a ? b : a;
		while (b + 1 < count && highest[b + 1] >= highest[a] - within)
			b++;
		if (time[from + b] - time[from + a] > longest) {
			longest = time[from + b] - time[from + a];
			cycle->holds = from + a;
			last = from + b;
		}
	}
	for (cycle->held = cycle->holds; cycle->held < last && time[cycle->held] < time[cycle->holds] + longest / 2;)
		cycle->held++;
	mem_free(highest);
	return STATUS_OK;
}

/* Fills the phases of a cycle whose low, peak and end are known. A fall of less than `swing` from what it holds is no dump. */
static enum status find_phases(const struct html_body *body, double swing, struct html_cycle *cycle)
{
	const double *volume = body->digging->values[DIG_VOLUME];
	TRY(find_hold(body, cycle));
	cycle->dumped = volume[cycle->held] - volume[cycle->end] >= swing;
	const double low = volume[cycle->low], brought = volume[cycle->held] - low;
	for (cycle->fills = cycle->low; cycle->fills + 1 < cycle->peak && volume[cycle->fills + 1] <= low + 0.01 * brought;)
		cycle->fills++;
	for (cycle->half = cycle->fills; cycle->half < cycle->peak && volume[cycle->half] < low + 0.5 * brought;)
		cycle->half++;
	cycle->dumps = cycle->fallen = cycle->emptied = cycle->end;
	if (!cycle->dumped)
		return STATUS_OK;
	const double left = volume[cycle->end], fell = volume[cycle->held] - left;
	while (cycle->dumps > cycle->held && volume[cycle->dumps] < left + 0.99 * fell)
		cycle->dumps--;
	for (cycle->fallen = cycle->dumps; cycle->fallen < cycle->end && volume[cycle->fallen] > left + 0.5 * fell;)
		cycle->fallen++;
	for (cycle->emptied = cycle->fallen; cycle->emptied < cycle->end && volume[cycle->emptied] > left + 0.01 * fell;)
		cycle->emptied++;
	return STATUS_OK;
}

/* What was seen since the last cycle. */
struct search {
	size_t low, peak, end;
	bool falls; /* the peak is behind; `end` is the lowest row since */
};

/* Takes the next row. Returns true if the cycle is over: the volume rises again. */
static bool look(struct search *search, const double *volume, size_t i, double swing)
{
	if (search->falls) {
		search->end = volume[i] < volume[search->end] ? i : search->end;
		return volume[i] >= volume[search->end] + swing;
	}
	if (volume[search->peak] - volume[search->low] >= swing && volume[i] <= volume[search->peak] - swing) {
		search->falls = true;
		search->end = i;
	} else if (volume[i] > volume[search->peak]) {
		search->peak = i;
	} else if (volume[i] < volume[search->low]) {
		search->low = search->peak = i;
	}
	return false;
}

enum status html_digging_cycles(const struct html_body *body, struct html_cycle *list, size_t most, size_t *count)
{
	const double *volume = body->digging->values[DIG_VOLUME];
	const double swing = SWING * largest_of(volume, body->count);
	struct search search = {.falls = false};
	*count = 0;
	for (size_t i = 0; i <= body->count && swing > 0; i++) {
		const bool over = i == body->count;
		if (over ? !search.falls && volume[search.peak] - volume[search.low] < swing : !look(&search, volume, i, swing))
			continue;
		struct html_cycle cycle = {.low = search.low, .peak = search.peak, .end = search.falls && !over ? search.end : body->count - 1};
		if (*count < most) {
			TRY(find_phases(body, swing, &cycle));
			list[*count] = cycle;
		}
		++*count;
		search = (struct search){.low = search.end, .peak = i};
	}
	return STATUS_OK;
}
