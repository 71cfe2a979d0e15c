/* What is asked of the rig: checks it, chooses spacing and way, and runs soil after soil. */
#include "trials/trials.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "trials/internal.h"

#define POSTS 20         /* below the object's width or height, by default */
#define WAY 8.0          /* the way, in radii or half lengths */
#define PITCH 10.0       /* from lane to lane, in half widths or heights */
#define BEHIND 4.0       /* from one object of a lane to the next, in the same */
#define TAKEN 0.25       /* of the way, at its end, in which a row is taken */
#define LEVELS 16        /* posts of the bed's base are so many times as far apart: less to store */

const char *const trials_rig_states[] = {
	[RIG_STEADY] = "steady", [RIG_DIGS] = "digs", [RIG_SUNK] = "sunk", [RIG_SPINS] = "spins", [RIG_GROWS] = "grows",
};

static enum status check_list(const char *what, const double *values, size_t count, double low, double high)
{
	if (count > RIG_VALUES_MOST)
		return fail_with(STATUS_USAGE, "rig: %s: are %zu numbers; give at most %d", what, count, RIG_VALUES_MOST);
	for (size_t i = 0; i < count; i++)
		if (!(values[i] >= low && values[i] <= high))
			return fail_with(STATUS_USAGE, "rig: %s: %g is out of range; give %g to %g", what, values[i], low, high);
	return STATUS_OK;
}

static enum status check(const struct rig_params *params)
{
	if (params->soil_count == 0 || params->load_count + params->depth_count == 0)
		return fail_with(STATUS_USAGE, "rig: no soil or no load; give one of each at least");
	if (params->load_count > 0 && params->depth_count > 0)
		return fail_with(STATUS_USAGE, "rig: loads and depths are both given; give one of them");
	if (params->slip_count > 0 && params->torque_count > 0)
		return fail_with(STATUS_USAGE, "rig: slips and torques are both given; give one of them");
	if (!(params->rake >= 0 && params->rake <= 180))
		return fail_with(STATUS_USAGE, "rig: rake: %g is out of range; give 0 to 180", params->rake);
	if (params->passes > RIG_PASSES_MOST)
		return fail_with(STATUS_USAGE, "rig: passes: %zu are too many; give 1 to %d", params->passes, RIG_PASSES_MOST);
	TRY(check_list("load", params->loads, params->load_count, 1e-3, 1e9));
	TRY(check_list("depth", params->depths, params->depth_count, 0, 1000));
	TRY(check_list("angle", params->angles, params->angle_count, -180, 180));
	if (params->leads != NULL)
		TRY(check_list("load ahead", params->leads, params->load_count, 1e-3, 1e9));
	TRY(check_list("slip", params->slips, params->slip_count, -1000, 0.999));
	return check_list("torque", params->torques, params->torque_count, -1e9, 1e9);
}

bool trials_rig_is_driven(const struct rig *rig)
{
	return rig->found.wheel || rig->found.belt;
}

static size_t angles_of(const struct rig_params *params)
{
	return params->angle_count > 0 ? params->angle_count : 1;
}

size_t trials_rig_places(const struct rig_params *params)
{
	return (params->load_count + params->depth_count) * angles_of(params);
}

struct rig_lane trials_rig_lane(const struct rig_params *params, size_t place, double slip)
{
	const size_t load = place / angles_of(params), angle = place % angles_of(params);
	struct rig_lane lane = {.place = place, .load = NAN, .lead = NAN, .depth = NAN, .slip = slip};
	if (params->depth_count > 0)
		lane.depth = params->depths[load];
	else
		lane.load = params->loads[load];
	lane.lead = params->leads != NULL ? params->leads[load] : lane.load;
	lane.angle = params->angle_count > 0 ? params->angles[angle] * M_PI / 180 : 0;
	return lane;
}

bool trials_in_braces(const char *text)
{
	return text[strspn(text, " ")] == '{';
}

static char *in_braces(const char *shape)
{
	const bool has = trials_in_braces(shape);
	char *text = mem_alloc(strlen(shape) + 3, 1);
	if (text != NULL)
		sprintf(text, has ? "%s" : "{%s}", shape);
	return text;
}

enum status trials_told(furrow_status status)
{
	static const enum status of[] = {[FURROW_OK] = STATUS_OK, [FURROW_FAILED] = STATUS_FAILED, [FURROW_USAGE] = STATUS_USAGE, [FURROW_INPUT] = STATUS_INPUT,
					 [FURROW_NO_GL] = STATUS_NO_GL};
	if (status == FURROW_OK)
		return STATUS_OK;
	char message[4096];
	snprintf(message, sizeof message, "%s", furrow_last_error());
	return fail_with(status == FURROW_INTERRUPTED ? STATUS_INTERRUPTED : of[status], "%s", message);
}

/* Reads the shape as a host's body, whose messages name its own text. */
static enum status measure(struct rig *rig)
{
	struct furrow_shape shape = {.size = sizeof shape};
	char *text = mem_alloc(strlen(rig->shape) + 16, 1);
	enum status status = text != NULL ? STATUS_OK : fail_memory("a shape");
	if (status == STATUS_OK) {
		sprintf(text, "{shape: %s}", rig->shape);
		status = trials_told(furrow_measure(text, &shape));
	}
	mem_free(text);
	if (status != STATUS_OK) {
		char why[512];
		snprintf(why, sizeof why, "%s", failure_message());
		return fail_with(status, "rig: shape %s: %.400s", rig->shape, why);
	}
	struct rig_found *found = &rig->found;
	found->wheel = !isnan(shape.radius);
	found->belt = shape.belt;
	found->radius = shape.radius;
	found->arm = found->wheel ? shape.radius : 1;
	found->width = shape.width;
	const double least = found->wheel ? fmin(shape.radius, shape.width) : shape.bound / sqrt(3);
	const double most = found->wheel ? fmax(shape.radius, shape.width) : shape.bound;
	found->spacing = rig->params->spacing > 0 ? rig->params->spacing : least / POSTS;
	/* Whole posts, so that each step is a path sample. */
	const double way = ceil((rig->params->way > 0 ? rig->params->way : WAY * most) / found->spacing) * found->spacing;
	rig->speed = rig->params->speed > 0 ? rig->params->speed : RIG_SPEED;
	rig->passes = rig->params->passes > 1 ? rig->params->passes : 1;
	rig->behind = ceil(BEHIND * most / found->spacing) * found->spacing;
	rig->taken = TAKEN * way;
	/* The last one's rows are taken where the first one's were: each goes on for longer. */
	found->way = way + (double)(rig->passes - 1) * rig->behind;
	rig->levels = LEVELS;
	rig->pitch = ceil(PITCH * most / found->spacing) * found->spacing;
	rig->start = rig->pitch;
	return STATUS_OK;
}

/* One row a load, angle and slip. */
static enum status slips(struct rig *rig, size_t soil, rig_row_fn give, void *user)
{
	const struct rig_params *params = rig->params;
	const size_t each = trials_rig_is_driven(rig) ? params->slip_count : 1, count = trials_rig_places(params) * each;
	struct rig_lane *lanes = mem_calloc(count, sizeof *lanes);
	TRY_MEM(lanes, "the rig's lanes");
	for (size_t i = 0; i < count; i++)
		lanes[i] = trials_rig_lane(params, i / each, trials_rig_is_driven(rig) ? params->slips[i % each] : (double)NAN);
	enum status status;
	TRY_OR(done, trials_lanes_drive(rig, soil, lanes, count));
	for (size_t i = 0; i < count * rig->passes; i++)
		TRY_OR(done, give(user, &lanes[i / rig->passes].rows[i % rig->passes]));
done:
	mem_free(lanes);
	return status;
}

/* Notes of the library are those of the command. */
static void tell_note(int level, const char *message, void *user)
{
	(void)level, (void)user;
	fprintf(stderr, "furrow: note: %s\n", message);
}

#define ACROSS 12 /* posts across a wheel, from which on a second wheel in its rut is as near as the first */

/* Tells how far a second wheel in a rut is off: bench/second_wheel.py measured it, beside posts of 1 cm, at a slip of 0.29. */
static void advise_second(const struct rig *rig)
{
	const struct rig_found *found = &rig->found;
	if (rig->passes < 2 || !found->wheel || !rig->params->advise || !(found->width < ACROSS * found->spacing))
		return;
	note("rig: a wheel in the rut of another is off by up to about 9 %% of its sinkage and 2 %% of its load with %.2g posts across it; from %d posts across on by 1 %%: "
	     "--spacing %.2g", found->width / found->spacing, ACROSS, found->width / ACROSS);
}

/* Measures the object, and runs all soils over it. */
static enum status run(struct rig *rig, struct rig_found *found, rig_row_fn give, void *user)
{
	const struct rig_params *params = rig->params;
	TRY(measure(rig));
	*found = rig->found;
	advise_second(rig);
	const bool driven = trials_rig_is_driven(rig), torques = params->torque_count > 0;
	if (driven && params->slip_count + params->torque_count == 0)
		return fail_with(STATUS_USAGE, "rig: a wheel or a belt needs slips or torques; give some");
	if (!driven && torques)
		return fail_with(STATUS_USAGE, "rig: %s is no wheel and has no belt, so that no torque turns it; give loads alone", params->shape);
	if (found->wheel && params->rake != 0 && params->rake != 90)
		return fail_with(STATUS_USAGE, "rig: a wheel has no rake, since it turns about its axle; give it with another shape");
	rig->total = (int64_t)(params->soil_count * trials_rig_places(params) * (torques ? 12 : driven ? params->slip_count : 1));
	for (size_t soil = 0; soil < params->soil_count; soil++) {
		rig->advised = false;
		TRY(torques ? trials_torques(rig, soil, give, user) : slips(rig, soil, give, user));
	}
	return STATUS_OK;
}

enum status trials_rig_run(const struct rig_params *params, struct rig_found *found, rig_row_fn give, void *user)
{
	struct rig rig = {.params = params};
	*found = rig.found;
	TRY(check(params));
	furrow_set_log(tell_note, NULL);
	rig.shape = in_braces(params->shape);
	enum status status;
	TRY_OR(done, rig.shape != NULL ? trials_bed_begin(&rig) : fail_memory("the rig"));
	TRY_OR(done, run(&rig, found, give, user));
done:;
	struct failure failure;
	failure_capture(&failure, status);
	trials_bed_remove(&rig);
	mem_free(rig.shape);
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}
