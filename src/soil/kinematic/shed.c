/* Sumner's rule, by which steep soil sheds. See shed.h. */
#include "soil/kinematic/shed.h"

#include <math.h>

#include "soil/kinematic/kinematic.h"
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

/* What LANES posts have found about their neighbours. */
struct shedding {
	int32_t to[LANES], count[LANES], sum[LANES], starts[LANES];
};

/* Adds a neighbour. `k`, `stood` and `has_classes` are literals. */
static SOIL_INLINED void add_neighbour(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t first, int32_t count, int k, bool stood,
				       bool has_classes, struct shedding *s)
{
	const int32_t *heights = rows->heights[1] + first, *others = rows->heights[near[k].row] + first + near[k].column;
	const uint8_t *holds = rows->contacts[1] + first, *other_holds = rows->contacts[near[k].row] + first + near[k].column;
	const int32_t *grounds = stood ? rows->grounds[1] + first : NULL, *other_grounds = stood ? rows->grounds[near[k].row] + first + near[k].column : NULL;
	const uint8_t *classes = has_classes ? rows->classes + first : NULL;
	const int apart = k < 4 ? 0 : 1;
	const struct soil_shed_class *all = rule->classes;
	for (int32_t i = 0; i < count; i++) {
		const struct soil_shed_class *soil = has_classes ? &all[classes[i] < SOIL_CLASSES ? classes[i] : SOIL_CLASSES - 1] : all;
		const int32_t difference = (int32_t)((uint32_t)heights[i] - (uint32_t)others[i]);
		const bool held = ((holds[i] | other_holds[i]) & SOIL_HELD) != 0;
		bool open = others[i] != SHED_STILL;
		if (stood)
			open = open & ((int32_t)((uint32_t)difference - ((uint32_t)grounds[i] - (uint32_t)other_grounds[i])) > rule->tolerance);
		const bool steep = open & (difference > (held ? soil->held[apart] : soil->critical[apart]));
		s->starts[i] |= open & (difference > soil->stop[apart]);
		s->to[i] |= steep ? (int32_t)(1u << (SHARE_BITS + k)) : 0;
		s->count[i] += steep;
		s->sum[i] += steep ? lane_least(difference, DIFFERENCE_MOST) : 0;
	}
}

static SOIL_INLINED void shed_lanes(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t first, int32_t count, bool stood,
				    bool has_classes, int32_t *restrict shed)
{
	struct shedding s = {{0}, {0}, {0}, {0}};
	for (int k = 0; k < 8; k++)
		add_neighbour(rule, rows, first, count, k, stood, has_classes, &s);
	for (int32_t i = 0; i < count; i++) {
		const uint8_t class = has_classes ? rows->classes[first + i] : 0;
		const struct soil_shed_class *soil = &rule->classes[class < SOIL_CLASSES ? class : SOIL_CLASSES - 1];
		const uint32_t part = soil->share[s.count[i] > 0 ? s.count[i] - 1 : 0];
		const int32_t share = (int32_t)((uint64_t)(uint32_t)s.sum[i] * part >> 32);
		const bool sheds = (s.starts[i] != 0) & (s.count[i] > 0) & (rows->heights[1][first + i] != SHED_STILL);
		shed[first + i] = sheds ? s.to[i] | lane_least(share, SHED_MOST) : 0;
	}
}

static SOIL_INLINED void shed_row(const struct soil_shed *rule, const struct soil_shed_rows *rows, bool stood, bool has_classes, int32_t *shed)
{
	int32_t first = 0;
	for (; first + LANES <= rows->count; first += LANES)
		shed_lanes(rule, rows, first, LANES, stood, has_classes, shed);
	if (first < rows->count)
		shed_lanes(rule, rows, first, rows->count - first, stood, has_classes, shed);
}

static SOIL_CLONED void shed_plain(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed)
{
	shed_row(rule, rows, false, false, shed);
}

static SOIL_CLONED void shed_of_classes(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed)
{
	shed_row(rule, rows, false, true, shed);
}

static SOIL_CLONED void shed_stood(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed)
{
	shed_row(rule, rows, true, false, shed);
}

static SOIL_CLONED void shed_stood_of_classes(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed)
{
	shed_row(rule, rows, true, true, shed);
}

void soil_shed_row(const struct soil_shed *rule, const struct soil_shed_rows *rows, int32_t *shed)
{
	if (rule->undisturbed_stable)
		(rows->classes != NULL ? shed_stood_of_classes : shed_stood)(rule, rows, shed);
	else
		(rows->classes != NULL ? shed_of_classes : shed_plain)(rule, rows, shed);
}

static SOIL_INLINED int32_t bits_of(int32_t shed)
{
	int32_t count = 0;
	for (int k = 0; k < 8; k++)
		count += (shed >> (SHARE_BITS + k)) & 1;
	return count;
}

static SOIL_INLINED void take_row(int32_t count, const int32_t *const sheds[3], bool shares_count, bool tells, int32_t *restrict change, uint8_t *restrict moves)
{
	const int32_t *own = sheds[1];
	const int32_t *const from[8] = {sheds[0], sheds[1] - 1, sheds[1] + 1, sheds[2], sheds[0] - 1, sheds[0] + 1, sheds[2] - 1, sheds[2] + 1};
	for (int32_t i = 0; i < count; i++) {
		const int32_t shed = own[i], gives = bits_of(shed) * (shed & SHARE);
		int32_t comes = 0, any = shed;
		for (int k = 0; k < 8; k++) {
			const int back = k < 4 ? 3 - k : 11 - k; /* the way from there to here */
			const int32_t other = from[k][i], goes_here = (other >> (SHARE_BITS + back)) & 1 ? other : 0;
			comes += goes_here & SHARE;
			any |= goes_here;
		}
		change[i] = comes - gives;
		if (tells)
			moves[i] = shares_count ? any != 0 : (gives != 0) | (comes != 0);
	}
}

static SOIL_CLONED void take_quietly(int32_t count, const int32_t *const sheds[3], int32_t *change)
{
	take_row(count, sheds, false, false, change, NULL);
}

static SOIL_CLONED void take_of_window(int32_t count, const int32_t *const sheds[3], int32_t *change, uint8_t *moves)
{
	take_row(count, sheds, true, true, change, moves);
}

static SOIL_CLONED void take_of_blocks(int32_t count, const int32_t *const sheds[3], int32_t *change, uint8_t *moves)
{
	take_row(count, sheds, false, true, change, moves);
}

void soil_shed_take_row(int32_t count, const int32_t *const sheds[3], bool shares_count, int32_t *change, uint8_t *moves)
{
	if (moves == NULL)
		take_quietly(count, sheds, change);
	else
		(shares_count ? take_of_window : take_of_blocks)(count, sheds, change, moves);
}
