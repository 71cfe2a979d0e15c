/* Sumner's rule, by which steep soil sheds. See shed.h. */
#include "soil/kinematic/shed.h"

#include <math.h>

#include "soil/kinematic/rows.h"
#include "soil/stability.h"

#define SHARE_BITS 23
#define SHARE ((1 << SHARE_BITS) - 1)
#define SHED_MOST (1 << 22)       /* most soil that two posts exchange in an iteration, fixed-point units */
#define DIFFERENCE_MOST (1 << 26) /* the sum of eight fits 32 bits */

/* The neighbours: four axial, four diagonal. Row: 0 south, 2 north. */
static const struct {
	int row, column;
} near[8] = {{0, 0}, {1, -1}, {1, 1}, {2, 0}, {0, -1}, {0, 1}, {2, -1}, {2, 1}};

static int32_t with_tolerance(int32_t critical, int32_t tolerance)
{
	return critical < INT32_MAX - tolerance ? critical + tolerance : INT32_MAX;
}

void soil_shed_prepare(const struct soil_numbers *soil, double spacing, int32_t tolerance, struct soil_shed_class *to)
{
	for (int k = 0; k < 2; k++) {
		const double apart = k == 0 ? spacing : spacing * M_SQRT2;
		to->critical[k] = with_tolerance(soil_critical_difference(soil->theta_out, apart), tolerance);
		to->held[k] = with_tolerance(soil_critical_difference(soil->theta_in, apart), tolerance);
		to->stop[k] = with_tolerance(soil_critical_difference(soil->theta_stop, apart), tolerance);
	}
	for (int n = 1; n <= 8; n++)
		to->share[n - 1] = (uint32_t)floor(ldexp(soil->roughness, 32) / (n * n));
}

void soil_shed_begin(struct soil_shed *rule, const struct soil_numbers *soils, int count, double spacing, double tolerance, bool undisturbed_stable)
{
	*rule = (struct soil_shed){.undisturbed_stable = undisturbed_stable, .tolerance = (int32_t)floor(ldexp(tolerance, OFFSET_BITS))};
	for (int i = 0; i < count; i++)
		soil_shed_prepare(&soils[i], spacing, rule->tolerance, &rule->classes[i]);
}

void soil_shed_least(const struct soil_shed *rule, int count, int32_t least[2])
{
	least[0] = least[1] = INT32_MAX;
	for (int i = 0; i < count; i++)
		for (int k = 0; k < 2; k++)
			least[k] = lane_least(least[k], rule->classes[i].stop[k]);
}

bool soil_shed_held_is_stable(const struct soil_shed *rule, int count)
{
	bool is = true;
	for (int i = 0; i < count; i++)
		for (int k = 0; k < 2; k++)
			is = is && rule->classes[i].held[k] >= rule->classes[i].critical[k];
	return is;
}

#define PART 64 /* posts of a row that are computed together */

/* The limits of each of these posts: axial, diagonal. */
struct limits {
	int32_t critical[2][PART], held[2][PART], stop[2][PART];
};

/* What these posts have found about their neighbours. */
struct shedding {
	int32_t to[PART], count[PART], sum[PART], starts[PART];
};

static void limit(const struct soil_shed *rule, const uint8_t *classes, int32_t count, struct limits *limits)
{
	for (int32_t i = 0; i < count; i++) {
		const uint8_t class = classes != NULL ? classes[i] : 0;
		const struct soil_shed_class *soil = &rule->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1];
		for (int apart = 0; apart < 2; apart++) {
			limits->critical[apart][i] = soil->critical[apart];
			limits->held[apart][i] = soil->held[apart];
			limits->stop[apart][i] = soil->stop[apart];
		}
	}
}

/* Adds a neighbour. k: its number. `stood` is a literal: undisturbed ground is stable. So is `roofed`: a post without room takes nothing. */
SOIL_INLINED void add_neighbour(int32_t count, int k, bool stood, bool roofed, int32_t tolerance, const int32_t *restrict heights,
				       const int32_t *restrict others, const int32_t *restrict grounds, const int32_t *restrict other_grounds, const uint8_t *restrict holds,
				       const uint8_t *restrict other_holds, const int32_t *restrict other_rooms, const struct limits *restrict limits, struct shedding *restrict s)
{
	const int apart = k < 4 ? 0 : 1;
	const int32_t bit = (int32_t)(1u << (SHARE_BITS + k));
	for (int32_t i = 0; i < count; i++) {
		const int32_t difference = (int32_t)((uint32_t)heights[i] - (uint32_t)others[i]);
		const bool held = ((holds[i] | other_holds[i]) & SOIL_HELD) != 0;
		bool open = others[i] != SHED_STILL;
		if (stood)
			open = open & ((int32_t)((uint32_t)difference - ((uint32_t)grounds[i] - (uint32_t)other_grounds[i])) > tolerance);
		if (roofed)
			open = open & (other_rooms[i] > 0);
		const int32_t most = held ? limits->held[apart][i] : limits->critical[apart][i];
		const bool steep = open & (difference > most);
		s->starts[i] |= open & (difference > limits->stop[apart][i]);
		s->to[i] |= steep ? bit : 0;
		s->count[i] += steep;
		s->sum[i] += steep ? lane_least(difference, DIFFERENCE_MOST) : 0;
	}
}

/* Fills the share of each post: of the sum of differences, what each neighbour gets. */
static void share_of(const struct soil_shed *rule, const uint8_t *classes, int32_t count, const int32_t *counts, uint32_t *shares)
{
	for (int32_t i = 0; i < count; i++) {
		const uint8_t class = classes != NULL ? classes[i] : 0;
		shares[i] = rule->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1].share[counts[i] > 0 ? counts[i] - 1 : 0];
	}
}

SOIL_INLINED void finish(int32_t count, const struct shedding *restrict s, const uint32_t *restrict shares, const int32_t *restrict heights,
				int32_t *restrict shed)
{
	for (int32_t i = 0; i < count; i++) {
		const int32_t share = (int32_t)((int64_t)s->sum[i] * (int64_t)shares[i] >> 32);
		const bool sheds = (s->starts[i] != 0) & (s->count[i] > 0) & (heights[i] != SHED_STILL);
		shed[i] = sheds ? s->to[i] | lane_least(share, SHED_MOST) : 0;
	}
}

/* Computes what up to PART posts of a row shed, from `first` on. */
SOIL_INLINED void shed_part(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t first, int32_t count, bool stood, bool roofed,
				   const struct limits *limits, int32_t *shed)
{
	const uint8_t *classes = rows->classes != NULL ? rows->classes + first : NULL;
	struct shedding s;
	uint32_t shares[PART];
	for (int32_t i = 0; i < count; i++)
		s.to[i] = s.count[i] = s.sum[i] = s.starts[i] = 0;
	/* Each with a literal number, so that each is a loop of vector instructions. */
#define NEIGHBOUR(k) \
	add_neighbour(count, k, stood, roofed, rule->tolerance, rows->heights[1] + first, rows->heights[near[k].row] + first + near[k].column, \
		      stood ? rows->grounds[1] + first : NULL, stood ? rows->grounds[near[k].row] + first + near[k].column : NULL, rows->contacts[1] + first, \
		      rows->contacts[near[k].row] + first + near[k].column, roofed ? rows->rooms[near[k].row] + first + near[k].column : NULL, limits, &s)
	NEIGHBOUR(0);
	NEIGHBOUR(1);
	NEIGHBOUR(2);
	NEIGHBOUR(3);
	NEIGHBOUR(4);
	NEIGHBOUR(5);
	NEIGHBOUR(6);
	NEIGHBOUR(7);
#undef NEIGHBOUR
	share_of(rule, classes, count, s.count, shares);
	finish(count, &s, shares, rows->heights[1] + first, shed + first);
}

SOIL_LANES void soil_shed_row(const struct soil_shed *rule, const struct soil_shed_rows *given, int32_t *shed)
{
	const struct soil_shed_rows own = *given, *rows = &own; /* nothing that is written lies in it */
	struct limits limits;
	if (rows->classes == NULL)
		limit(rule, NULL, lane_least(rows->count, PART), &limits);
	for (int32_t first = 0; first < rows->count; first += PART) {
		const int32_t count = lane_least(rows->count - first, PART);
		if (rows->classes != NULL)
			limit(rule, rows->classes + first, count, &limits);
		const bool roofed = rows->rooms[1] != NULL;
		if (rule->undisturbed_stable && roofed)
			shed_part(rule, rows, first, count, true, true, &limits, shed);
		else if (rule->undisturbed_stable)
			shed_part(rule, rows, first, count, true, false, &limits, shed);
		else if (roofed)
			shed_part(rule, rows, first, count, false, true, &limits, shed);
		else
			shed_part(rule, rows, first, count, false, false, &limits, shed);
	}
}

SOIL_INLINED int32_t bits_of(int32_t shed)
{
	int32_t count = 0;
	for (int k = 0; k < 8; k++)
		count += (shed >> (SHARE_BITS + k)) & 1;
	return count;
}

/* `shares_count`, `tells` and `roofed` are literals. roofed: each of two posts knows the room of the one that takes, so both compute the same amount. */
SOIL_INLINED void take_row(int32_t count, const int32_t *const sheds[3], const int32_t *const rooms[3], bool shares_count, bool tells, bool roofed,
				  int32_t *restrict change, uint8_t *restrict moves)
{
	const int32_t *own = sheds[1];
	const int32_t *const from[8] = {sheds[0], sheds[1] - 1, sheds[1] + 1, sheds[2], sheds[0] - 1, sheds[0] + 1, sheds[2] - 1, sheds[2] + 1};
	for (int32_t i = 0; i < count; i++) {
		const int32_t shed = own[i], share = shed & SHARE;
		int32_t gives = roofed ? 0 : bits_of(shed) * share, comes = 0, any = shed;
		for (int k = 0; k < 8; k++) {
			const int back = k < 4 ? 3 - k : 11 - k; /* the way from there to here */
			const int32_t other = from[k][i], goes_here = (other >> (SHARE_BITS + back)) & 1 ? other : 0;
			if (roofed) {
				const int32_t room = rooms[near[k].row][i + near[k].column];
				gives += (shed >> (SHARE_BITS + k)) & 1 ? lane_least(share, lane_most(room, 0)) : 0;
				comes += lane_least(goes_here & SHARE, lane_most(rooms[1][i], 0));
			} else {
				comes += goes_here & SHARE;
			}
			any |= goes_here;
		}
		change[i] = comes - gives;
		if (tells)
			moves[i] = shares_count ? any != 0 : (gives != 0) | (comes != 0);
	}
}

static SOIL_LANES void take_quietly(int32_t count, const int32_t *const sheds[3], int32_t *change)
{
	take_row(count, sheds, NULL, false, false, false, change, NULL);
}

static SOIL_LANES void take_of_window(int32_t count, const int32_t *const sheds[3], int32_t *change, uint8_t *moves)
{
	take_row(count, sheds, NULL, true, true, false, change, moves);
}

static SOIL_LANES void take_of_blocks(int32_t count, const int32_t *const sheds[3], int32_t *change, uint8_t *moves)
{
	take_row(count, sheds, NULL, false, true, false, change, moves);
}

static void take_below(int32_t count, const int32_t *const sheds[3], const int32_t *const rooms[3], bool shares_count, int32_t *change, uint8_t *moves)
{
	if (moves == NULL)
		take_row(count, sheds, rooms, false, false, true, change, NULL);
	else if (shares_count)
		take_row(count, sheds, rooms, true, true, true, change, moves);
	else
		take_row(count, sheds, rooms, false, true, true, change, moves);
}

void soil_shed_take_row(int32_t count, const int32_t *const sheds[3], const int32_t *const rooms[3], bool shares_count, int32_t *change, uint8_t *moves)
{
	if (rooms != NULL)
		take_below(count, sheds, rooms, shares_count, change, moves);
	else if (moves == NULL)
		take_quietly(count, sheds, change);
	else
		(shares_count ? take_of_window : take_of_blocks)(count, sheds, change, moves);
}
