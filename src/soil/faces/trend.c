/*
 * The recent motion M of a body changes with each motion x, a twist of the body, by
 *
 *     dM = (dx - M |dx|) / K,    K the shear modulus of the soil
 *
 * |dx| is the way that counts: that of the centre, of a rim, or of the body's outer parts, where these go farther. So M forgets what is older than a few K, as
 * Janosi's shear does. With several soils K is the mean of theirs: so M is known without the ground.
 *
 * What a wheel's grousers scoop. Between its bars a wheel carries wedges of soil, in the share chi of its rim. On average they are half as thick as its bars are
 * high. So while its rim runs ds farther than it goes, it moves a volume chi h b ds / 2. It takes that from ahead of its middle to behind it, and comes upon soil
 * that is still there. For each square metre below the wheel, which is about as long as the radius R of the drum over its tips, it has taken
 *
 *     dV = (chi h / 2 ds - V dx) / R,    dx = |ahead| + |aside| R / b
 *
 * The sides of the trench slide in at the friction angle, so a trench of depth D takes D + D^2 / (b tan phi) = V.
 */
#include "soil/faces/trend.h"

#include "soil/shape/bars.h"
#include "soil/shape/body.h"

#define TURNS_AT 0.5 /* of the distance from the centre that holds the whole body: where turning counts as a way */

static double length_of(const double v[3])
{
	return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Returns the way that counts in a motion, m. */
static double way_of(const struct soil_motion *motion, const double way[3], const double spin[3])
{
	const struct soil_shape *shape = motion->shape;
	double turns[3], axes[3][3];
	soil_axes(motion->to.yaw, 0, motion->to.roll, 0, axes);
	for (int k = 0; k < 3; k++)
		turns[k] = spin[k] - (shape->kind == SOIL_WHEEL ? motion->turned * axes[1][k] : 0);
	const double counts = fmax(length_of(way), TURNS_AT * soil_shape_bound(shape) * length_of(turns));
	return shape->kind == SOIL_WHEEL || shape->belt ? fmax(counts, (shape->belt ? 1 : soil_body_wheel_radius(shape)) * fabs(motion->turned)) : counts;
}

/* Lets a motion enter the mean. by: one over its way, 1/m; stays: share that stays of what was before. */
static void mix(const double way[3], const double spin[3], double ran, double by, double stays, struct soil_recent_motion *mean)
{
	for (int k = 0; k < 3; k++) {
		mean->way[k] = way[k] * by + stays * (mean->way[k] - way[k] * by);
		mean->turn[k] = spin[k] * by + stays * (mean->turn[k] - spin[k] * by);
	}
	mean->ran = ran * by + stays * (mean->ran - ran * by);
}

/* Lets what the bars of a wheel do in a motion change what they have scooped. axes: of its attitude. */
static void scoop(const struct soil_motion *motion, const double way[3], const double axes[3][3], double *scooped)
{
	const struct soil_shape *shape = motion->shape;
	const double share = soil_bars_carry(shape), reach = shape->radius + share * shape->grouser_height, runs = reach * motion->turned;
	const double plan = fmax(hypot(axes[0][0], axes[0][1]), 1e-9), ahead = (way[0] * axes[0][0] + way[1] * axes[0][1]) / plan;
	const double aside = (way[0] * axes[0][1] - way[1] * axes[0][0]) / plan;
	const double spins = fabs(runs) - fmin(fmax(runs < 0 ? -ahead : ahead, 0), fabs(runs)), goes = (fabs(ahead) + fabs(aside) * reach / shape->width) / reach;
	const double takes = 0.5 * share * shape->grouser_height * spins / reach, stays = (double)exp_minus((float)goes);
	*scooped = goes > 1e-6 ? *scooped * stays + takes * (1 - stays) / goes : *scooped * (1 - goes) + takes;
}

struct soil_trend soil_trend_after(const struct soil_law *law, const struct soil_motion *motion)
{
	struct soil_trend after = motion->trend;
	const int64_t moved[3] = {motion->to.x - motion->from.x, motion->to.y - motion->from.y, motion->to.z - motion->from.z};
	double way[3], spin[3], modulus = 0;
	if (motion->jumped || !law->faces)
		return (struct soil_trend){.whole = {.ran = 0}};
	for (int i = 0; i < law->soil_count; i++)
		modulus += law->soils[i].janosi_shear / law->soil_count;
	for (int k = 0; k < 3; k++)
		way[k] = lattice_offset_metres(moved[k]) + motion->beyond[k];
	soil_form_spin(motion, spin);
	if (motion->shape->kind == SOIL_WHEEL && motion->shape->grousers > 0 && law->slip_sinkage > 0) {
		double axes[3][3];
		soil_axes(motion->to.yaw, 0, motion->to.roll, 0, axes);
		scoop(motion, way, (const double(*)[3])axes, &after.scooped);
	}
	const double counts = way_of(motion, way, spin), ran = motion->shape->belt ? motion->turned : 0;
	if (!(counts > 0))
		return after;
	mix(way, spin, ran, 1 / counts, (double)exp_minus((float)(counts / modulus)), &after.whole);
	mix(way, spin, ran, 1 / counts, (double)exp_minus((float)(counts / modulus * TREND_LAST)), &after.last);
	return after;
}

_Static_assert(sizeof(struct soil_trend) == SOIL_TREND_NUMBERS * sizeof(double), "plain numbers");

void soil_trend_save(const struct soil_trend *trend, double numbers[SOIL_TREND_NUMBERS])
{
	memcpy(numbers, trend, sizeof *trend);
}

void soil_trend_load(const double numbers[SOIL_TREND_NUMBERS], struct soil_trend *trend)
{
	memcpy(trend, numbers, sizeof *trend);
}

static void into_frame(const struct soil_body *body, const double v[3], float out[3])
{
	out[0] = (float)(body->axis[0] * v[0] + body->axis[1] * v[1]);
	out[1] = (float)(body->axis[0] * v[1] - body->axis[1] * v[0]);
	out[2] = (float)v[2];
}

static void put_recent(const struct soil_body *body, const struct soil_form *form, const struct soil_recent_motion *motion, struct soil_recent *recent)
{
	const double plan = hypot(motion->way[0], motion->way[1]);
	into_frame(body, motion->way, recent->way);
	into_frame(body, motion->turn, recent->turn);
	soil_form_split(form, recent->turn, recent->rolling, recent->turning);
	recent->ran = (float)motion->ran;
	recent->along_ground = plan > 0 ? (float)(hypot(plan, soil_form_level_share(plan, motion->way[2]) * motion->way[2]) / plan) : 1;
}

/* Returns how deep the trench is that bars have scooped, m. Its sides slide in at the mean friction angle of the soils. */
static double trench_of(const struct soil_law *law, const struct soil_shape *shape, double scooped)
{
	double tangent = 0;
	for (int i = 0; i < law->soil_count; i++)
		tangent += tan(law->soils[i].friction_angle) / law->soil_count;
	return fmin(2 * scooped / (1 + sqrt(1 + 4 * scooped / fmax(shape->width * tangent, 1e-9))), shape->radius);
}

void soil_trend_put(const struct soil_law *law, const struct soil_body *body, const struct soil_trend *trend, struct soil_form *form)
{
	form->scooped = trend->scooped > 0 ? (float)trench_of(law, body->motion->shape, trend->scooped) : 0;
	put_recent(body, form, &trend->whole, &form->recent);
	put_recent(body, form, &trend->last, &form->last);
}
