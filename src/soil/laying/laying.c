/*
 * Tells how a contact lays the soil that it displaces (SOIL.md, "Laying"). All lengths are metres: they come from the body, its motion and the
 * depth, not from the posts.
 */
#include <math.h>

#include "soil/laying/laying.h"
#include "soil/shape/body.h"

#define STEEPEST_TAN 1.0 /* steeper soil is laid as if it stood at 45 degrees */
#define ONE 65536.0
#define FARTHEST 8192.0  /* posts: more than a window has */

static int32_t fixed(double value)
{
	return (int32_t)lround(value * ONE);
}

/* A band's cross-section is 2/9 of its width squared, times the tangent of its sides. */
struct soil_laid soil_laid_of(double angle, double share, double spacing)
{
	double tangent = angle < M_PI / 4 ? fmax(tan(angle), 0.01) : STEEPEST_TAN;
	return (struct soil_laid){(int32_t)fmin(fmax(lround(4.5 * 64 * 16 / (tangent * spacing)), 1), 1 << 24), fixed(share),
				  (int32_t)lround(fmin(tangent * spacing * 0x1p20, 0x1p30))};
}

/* Computes by how much of its way a body pushes soil ahead of itself: forwards and to the left, each -1 .. 1. A wheel that rolls
 * pushes none ahead, a locked one as a sledge does. So does a belt. ran: how far the rim or the belt went over the body, m. */
static void push_of(double ran, double way, double forward, double aside, double push[2])
{
	push[0] = push[1] = 0;
	if (way == 0)
		return;
	bool braked = forward * ran >= 0 && fabs(ran) < fabs(forward);
	push[0] = braked ? (forward - ran) / way : 0;
	push[1] = aside / way;
}

/* A wheel that goes on lays its soil beside itself, from a whole to five eighths of its radius behind its axle. Laid farther ahead, it would slide
 * in front of the wheel. The more it moves sideways, the farther ahead it lays too. If it hardly goes on, it lays all along its patch. Returns the
 * length, metres, below 0 if the wheel rolls backwards; 0: all along. */
static double length_behind(double radius, double spacing, double forward, double aside, double down)
{
	double way = hypot(forward, aside);
	if (way == 0 || fabs(down) > way)
		return 0;
	double length = fmax(fmax(fabs(forward), spacing), 0.375 * radius) + aside * aside / (way * way) * radius;
	return copysign(length, forward);
}

/* Returns the widest band of a body, metres. */
static double widest(const struct soil_shape *shape)
{
	double x = shape->size[0], y = shape->size[1], z = shape->size[2];
	switch (shape->kind) {
	case SOIL_WHEEL:
		return shape->width;
	case SOIL_BOX: /* the middle one of its sizes: a plate may lie or stand */
		return fmax(fmin(x, y), fmin(fmax(x, y), z));
	case SOIL_ELLIPSOID: /* twice its middle half axis, halved */
		return fmax(fmin(x, y), fmin(fmax(x, y), z));
	case SOIL_MESH:
		return soil_shape_bound(shape) / 2;
	case SOIL_SPHERE:
	case SOIL_CYLINDER:
	case SOIL_CAPSULE:
	case SOIL_SHAPES:
		break;
	}
	return shape->radius;
}

double soil_laying_band(const struct soil_shape *shape, double spacing)
{
	return fmin(fmax(widest(shape) / spacing, 2), SOIL_BAND_POSTS);
}

/* Returns how far from a wheel's axle, along it, soil is laid beside the wheel, metres. A wheel that goes on lays it behind only. */
static double beside(double radius, double behind)
{
	return behind != 0 ? radius : radius / 2;
}

#define ROLLS_LEAST 0.1 /* of its way: a body whose surface runs over it by less does not roll */

/* Returns how far the surface of a body that is no wheel ran over it along its way, m. A body with flat sides does not roll. rotated: rad about local axes. */
static double rolled(const struct soil_shape *shape, const struct soil_pose *to, const double rotated[3], double heading)
{
	if (rotated == NULL || shape->kind == SOIL_BOX)
		return 0;
	return fmax(cos(heading) * rotated[1] - sin(heading) * rotated[0], 0) * soil_shape_reach(shape, to->pitch, to->roll);
}

/* Gives each face its share. Half of the pushed soil goes ahead, half aside. So a heap ahead stops growing at about the height that the cut is
 * deep. */
static void share(struct soil_laying *laying, const double push[2])
{
	double along = push[0] * push[0], across = push[1] * push[1], rolls = fmax(0, 1 - along - across), shares[SOIL_FACES];
	for (int face = 0; face < SOIL_FACES; face++)
		shares[face] = face < SOIL_LEFT ? across / 4 : rolls / 2 + along / 4;
	shares[push[0] > 0 ? SOIL_AHEAD : SOIL_BEHIND] += along / 2;
	shares[push[1] > 0 ? SOIL_LEFT : SOIL_RIGHT] += across / 2;
	laying->along = fixed(across);
	laying->rolls = fixed(rolls);
	laying->ends = shares[SOIL_AHEAD] + shares[SOIL_BEHIND] > 0;
	laying->sides = shares[SOIL_LEFT] + shares[SOIL_RIGHT] > 0;
	for (int face = 0; face < SOIL_FACES; face++)
		laying->shares[face] = laying->around ? (face == SOIL_AHEAD) * (int32_t)ONE : (int32_t)(shares[face] * ONE);
}

/* Tells where the body pushes soil that it displaces, and how much. A body that goes down as it goes along slides less: none at 45 degrees. */
static void put_push(struct soil_laying *laying, const double push[2], double way, double down)
{
	const double length = hypot(push[0], push[1]), c = cos(laying->heading), s = sin(laying->heading);
	if (laying->around || way == 0 || length == 0)
		return;
	laying->push[0] = (c * push[0] - s * push[1]) / length;
	laying->push[1] = (s * push[0] + c * push[1]) / length;
	laying->pushed = (int32_t)ONE - laying->rolls;
	laying->slides = fmin(length * length, 1) * fmax(1 - down * down / (way * way), 0);
}

void soil_laying_ahead(struct soil_laying *laying)
{
	laying->front = laying->pushed > 0;
	/* What rolls, and what finds no room ahead, goes to both sides. */
	for (int face = 0; face < SOIL_FACES && laying->front; face++)
		laying->shares[face] = face < SOIL_LEFT ? 0 : (int32_t)ONE / 2;
}

/* Puts the frame's x axis, and the place of its post, which lies so many posts east and north of the body's centre. */
static void turn_frame(struct soil_laying *laying, const double ahead[2])
{
	const double east = laying->post[0], north = laying->post[1];
	laying->axis[0] = fixed(ahead[0]);
	laying->axis[1] = fixed(ahead[1]);
	laying->at[0] = fixed(east * ahead[0] + north * ahead[1]);
	laying->at[1] = fixed(north * ahead[0] - east * ahead[1]);
}

struct soil_laying soil_laying_turned(const struct soil_laying *laying, const double ahead[2])
{
	struct soil_laying turned = *laying;
	turn_frame(&turned, ahead);
	return turned;
}

/* Finds the post south-west of the body's centre, and where it lies in the frame. */
static void place_frame(struct soil_laying *laying, const struct soil_pose *to, double spacing)
{
	const double ahead[2] = {cos(laying->heading), sin(laying->heading)};
	laying->x = (int64_t)floorl(soil_body_from_post(to->x, 0, spacing) / spacing);
	laying->y = (int64_t)floorl(soil_body_from_post(to->y, 0, spacing) / spacing);
	laying->post[0] = -(double)soil_body_from_post(to->x, laying->x, spacing) / spacing;
	laying->post[1] = -(double)soil_body_from_post(to->y, laying->y, spacing) / spacing;
	turn_frame(laying, ahead);
}

struct soil_laying soil_laying_of(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double turned,
				  const double rotated[3], double spacing)
{
	double dx = lattice_offset_metres(to->x - from->x), dy = lattice_offset_metres(to->y - from->y);
	double dz = lattice_offset_metres(to->z - from->z), way = hypot(dx, dy), push[2] = {1, 0};
	double radius = shape->radius;
	struct soil_laying laying = {.heading = to->yaw};
	if (soil_only_set_down(from, to))
		way = 0;
	const bool wheel = shape->kind == SOIL_WHEEL;
	if (wheel || (shape->belt && (way > fabs(dz) || turned != 0))) {
		double ahead[2] = {cos(laying.heading), sin(laying.heading)};
		double forward = dx * ahead[0] + dy * ahead[1], aside = dy * ahead[0] - dx * ahead[1];
		push_of(soil_shape_ran(shape, turned), way, forward, aside, push);
		laying.behind = wheel && way > 0 ? length_behind(radius, spacing, forward, aside, dz) : 0;
	} else if (way > fabs(dz)) {
		laying.heading = atan2(dy, dx);
		const double ran = rolled(shape, to, rotated, laying.heading);
		push_of(ran, way, way, 0, push);
		if (ran > ROLLS_LEAST * way) {
			radius = soil_shape_reach(shape, to->pitch, to->roll);
			laying.behind = length_behind(radius, spacing, way, 0, dz);
		}
	} else {
		laying.around = true;
		laying.heading = 0;
		push[0] = 0;
	}
	laying.tall = (int64_t)(0x1p20 * (soil_shape_reach(shape, to->pitch, to->roll) + soil_shape_reach(shape, -to->pitch, to->roll + M_PI)));
	share(&laying, push);
	put_push(&laying, push, way, dz);
	place_frame(&laying, to, spacing);
	laying.widest = (int32_t)ceil(64 * soil_laying_band(shape, spacing));
	laying.half_width = wheel ? fixed(shape->width / 2 / spacing) : 0;
	laying.beside = wheel || laying.behind != 0 ? fixed(fmax(beside(radius, laying.behind) / spacing, 1)) : INT32_MAX;
	laying.goes_on = fixed(fmax(fmin(laying.behind / spacing, FARTHEST), -FARTHEST));
	return laying;
}

/* --- the posts on which soil may be laid --- */

/* Widens `rect` by places of the body's frame: x from first to last, y from -far to far, metres. */
static struct post_rect with_band(struct post_rect rect, const struct soil_pose *to, double heading, double spacing, double first, double last,
				  double far)
{
	double c = cos(heading), s = sin(heading), middle[2] = {(first + last) / 2 * c, (first + last) / 2 * s};
	double half[2] = {(last - first) / 2 * fabs(c) + far * fabs(s), (last - first) / 2 * fabs(s) + far * fabs(c)};
	double x = lattice_offset_metres(to->x) + middle[0], y = lattice_offset_metres(to->y) + middle[1];
	const struct post_rect band = {(int64_t)floor((x - half[0]) / spacing), (int64_t)floor((y - half[1]) / spacing),
				       (int64_t)ceil((x + half[0]) / spacing) + 1, (int64_t)ceil((y + half[1]) / spacing) + 1};
	return post_rect_around(rect, band);
}

static struct post_rect wheel_posts(const struct soil_laying *laying, const struct soil_shape *shape, const struct soil_pose *to, double spacing,
				    double band, struct post_rect shadow)
{
	double along = soil_body_wheel_radius(shape), across = shape->width / 2, ends = beside(shape->radius, laying->behind);
	double last = laying->behind != 0 ? fmin(fabs(laying->behind) - ends, ends) : ends;
	double low = laying->behind < 0 ? -last : -ends, high = laying->behind < 0 ? ends : last;
	if (laying->ends)
		shadow = with_band(shadow, to, laying->heading, spacing, -along - band, along + band, across);
	if (laying->sides)
		shadow = with_band(shadow, to, laying->heading, spacing, low, high, across + band);
	return shadow;
}

struct post_rect soil_laying_posts(const struct soil_laying *laying, const struct soil_shape *shape, const struct soil_pose *to, double spacing,
				   struct post_rect shadow)
{
	const double band = soil_laying_band(shape, spacing) * spacing;
	if (shape->kind == SOIL_WHEEL)
		return wheel_posts(laying, shape, to, spacing, band, shadow);
	/* Around a rectangle that turns with the body. */
	double ahead[2] = {fabs(cos(laying->heading)), fabs(sin(laying->heading))}, reach[2] = {band, band};
	for (int k = 0; k < 2 && !laying->around; k++)
		reach[k] = fmax(laying->ends ? band * ahead[k] : 0, laying->sides ? band * ahead[1 - k] : 0);
	return (struct post_rect){shadow.x0 - (int64_t)ceil(reach[0] / spacing), shadow.y0 - (int64_t)ceil(reach[1] / spacing),
				  shadow.x1 + (int64_t)ceil(reach[0] / spacing), shadow.y1 + (int64_t)ceil(reach[1] / spacing)};
}
