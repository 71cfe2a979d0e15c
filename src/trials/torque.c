/*
 * Finds the slip of a wheel from its torque, of a belt from its pull. Torque grows with slip, so a few slips bracket each torque. A straight line between
 * the two nearest gives a slip to try, which then replaces one of them. This ends when its torque is near enough. Of objects that follow each
 * other the last one has that torque, and those ahead slip as it does.
 */
#include <math.h>

#include "trials/internal.h"

#define NEAR 0.005 /* of the torque, or of a twentieth of load x arm, whichever is more */
#define TRIES 5

static const double bracketing[] = {RIG_SLIP_LEAST, -0.6, -0.35, -0.15, 0, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, RIG_SLIP_MOST};
#define BRACKETING (sizeof bracketing / sizeof *bracketing)

/* The search for one torque. */
struct search {
	double torque;
	size_t place; /* which load and angle it has */
	double load;  /* N; NaN: it is at a depth */
	struct rig_row low, high, best; /* at both sides, and the nearest so far */
	bool inside, done;
};

static bool is_near(const struct rig *rig, const struct search *search, const struct rig_row *row)
{
	const double load = isnan(search->load) ? row->fz : search->load;
	const double scale = fmax(fabs(search->torque), 0.05 * load * rig->found.arm);
	return fabs(row->torque - search->torque) <= NEAR * scale;
}

/* The object of a lane whose torque is asked for. */
static const struct rig_row *last_of(const struct rig *rig, const struct rig_lane *lane)
{
	return &lane->rows[rig->passes - 1];
}

static void look(const struct rig *rig, struct search *search, const struct rig_row *row)
{
	if (!isfinite(search->best.torque) || fabs(row->torque - search->torque) < fabs(search->best.torque - search->torque))
		search->best = *row;
	search->done = is_near(rig, search, &search->best);
}

/* Brackets a torque between two neighbouring slips. */
static void bracket(const struct rig *rig, struct search *search, const struct rig_lane *lanes)
{
	search->best.torque = NAN;
	for (size_t i = 0; i < BRACKETING; i++) {
		look(rig, search, last_of(rig, &lanes[i]));
		if (i == 0 || search->inside || (last_of(rig, &lanes[i - 1])->torque > search->torque) == (last_of(rig, &lanes[i])->torque > search->torque))
			continue;
		search->low = *last_of(rig, &lanes[i - 1]);
		search->high = *last_of(rig, &lanes[i]);
		search->inside = true;
	}
}

static bool is_open(const struct search *search)
{
	return !search->done && search->inside;
}

/* Tries one slip for each search that is open. *any: there was one. */
static enum status try_slips(struct rig *rig, size_t soil, struct search *searches, size_t count, struct rig_lane *lanes, bool *any)
{
	size_t open = 0;
	for (size_t i = 0; i < count; i++) {
		const struct search *s = &searches[i];
		if (!is_open(s))
			continue;
		const double share = (s->torque - s->low.torque) / (s->high.torque - s->low.torque);
		lanes[open++] = trials_rig_lane(rig->params, s->place, s->low.slip + (s->high.slip - s->low.slip) * share);
	}
	*any = open > 0;
	if (!*any)
		return STATUS_OK;
	rig->total += (int64_t)open;
	TRY(trials_lanes_drive(rig, soil, lanes, open));
	open = 0;
	for (size_t i = 0; i < count; i++) {
		struct search *s = &searches[i];
		if (!is_open(s))
			continue;
		const struct rig_row *row = last_of(rig, &lanes[open++]);
		look(rig, s, row);
		*((row->torque > s->torque) == (s->high.torque > s->torque) ? &s->high : &s->low) = *row;
	}
	return STATUS_OK;
}

static enum status refine(struct rig *rig, size_t soil, struct search *searches, size_t count)
{
	struct rig_lane *lanes = mem_calloc(count, sizeof *lanes);
	TRY_MEM(lanes, "the rig's lanes");
	enum status status = STATUS_OK;
	bool any = true;
	for (int try = 0; try < TRIES && any; try++)
		TRY_OR(done, try_slips(rig, soil, searches, count, lanes, &any));
done:
	mem_free(lanes);
	return status;
}

static enum status give_all(const struct search *searches, size_t count, rig_row_fn give, void *user)
{
	for (size_t i = 0; i < count; i++) {
		struct rig_row row = searches[i].best;
		if (!searches[i].inside && !searches[i].done)
			row = (struct rig_row){.soil = row.soil, .load = row.load, .angle = row.angle, .pass = row.pass, .slip = NAN, .torque = searches[i].torque,
					       .sinkage = NAN, .drawbar = NAN, .side = NAN, .fz = NAN, .efficiency = NAN, .overturning = NAN, .aligning = NAN,
					       .against = NAN, .against_least = NAN, .against_most = NAN, .heap = NAN, .heap_volume = NAN, .deeper = NAN,
					       .state = RIG_SPINS};
		TRY(give(user, &row));
	}
	return STATUS_OK;
}

/* Drives the slips that bracket torques, and searches between them. `lanes`: room for them; `searches`: for each place and torque. */
static enum status search_all(struct rig *rig, size_t soil, struct rig_lane *lanes, struct search *searches, size_t count)
{
	const struct rig_params *params = rig->params;
	const size_t all = trials_rig_places(params) * BRACKETING;
	for (size_t i = 0; i < all; i++)
		lanes[i] = trials_rig_lane(params, i / BRACKETING, bracketing[i % BRACKETING]);
	TRY(trials_lanes_drive(rig, soil, lanes, all));
	for (size_t i = 0; i < count; i++) {
		const size_t place = i / params->torque_count;
		searches[i] = (struct search){.torque = params->torques[i % params->torque_count], .place = place, .load = lanes[place * BRACKETING].load};
		bracket(rig, &searches[i], &lanes[place * BRACKETING]);
	}
	return refine(rig, soil, searches, count);
}

enum status trials_torques(struct rig *rig, size_t soil, rig_row_fn give, void *user)
{
	const size_t places = trials_rig_places(rig->params), count = places * rig->params->torque_count;
	struct rig_lane *lanes = mem_calloc(places * BRACKETING, sizeof *lanes);
	struct search *searches = mem_calloc(count, sizeof *searches);
	enum status status;
	TRY_OR(done, lanes == NULL || searches == NULL ? fail_memory("the rig's lanes") : STATUS_OK);
	TRY_OR(done, search_all(rig, soil, lanes, searches, count));
	TRY_OR(done, give_all(searches, count, give, user));
done:
	mem_free_all(lanes, searches);
	return status;
}
