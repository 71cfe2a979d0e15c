/*
 * Evaluates the law over the posts of a body, a block of lanes at a time. For each post:
 *
 *  1. how deep the body is, and for which share of its motion it has been there;
 *  2. how its surface slid over the post, and what slip digs;
 *  3. what the post remembers of its largest sinkage, and which part of a line across its cell bears;
 *  4. at two places of that part (Gauss): pressure, damping, shear; their sum. Beside it what the lower end of a rim that leans bears.
 *
 * Each step is a loop over the lanes without a branch. The loops are compiled for each form of body, with and without what a probe asks.
 */
#include "soil/law/bear.h"

#include "soil/law/face.h"

#define LANES POSTS_LANES
_Static_assert(LANES == 16, "total_real");
/* At rest a body would rock and slide to and fro for long, since soil springs back without loss. So what moves slower than these is damped more. */
#define STICKS 0.003f    /* m/s along a surface: by the soil's own damping */
#define SETTLES 0.002f   /* m/s across it: by SETTLING times as much */
#define SETTLING 10.0f
#define EACH_LANE for (int i = 0; i < LANES; i++)

/* The numbers of a block of posts. A copy, since a compiler may read all lanes of it, whatever a choice between two numbers needs. */
struct lane_posts {
#define LANE_WHOLE(name) int32_t name[LANES];
#define LANE_REAL(name) float name[LANES];
	POSTS_WHOLES_EACH(LANE_WHOLE)
	POSTS_REALS_EACH(LANE_REAL)
#undef LANE_WHOLE
#undef LANE_REAL
};

SOIL_INLINED void take_lanes(const struct soil_posts *posts, size_t b, struct lane_posts *p)
{
#define LANE_TAKE(name) memcpy(p->name, posts->name + b, sizeof p->name);
	POSTS_WHOLES_EACH(LANE_TAKE)
	POSTS_REALS_EACH(LANE_TAKE)
#undef LANE_TAKE
}

/* What one evaluation knows of a block of posts. Heights and depths are in metres. */
struct block {
	float ground[LANES];            /* above the centre, less what slip digs */
	float depth[LANES];             /* of the end pose below the ground, vertically */
	float was[LANES], plastic[LANES]; /* along the normal: the largest sinkage before, less what slip digs; its plastic part */
	float passed[LANES], slides[LANES], direction[2][LANES]; /* share of the motion; way in units of the modulus; where it slid to */
	float more[LANES];              /* what slip digs */
	float stamped[LANES], printed[LANES], lasts[LANES], back[LANES];
	float beneath[LANES];           /* how much lower than now the body passed the post, or passes it before it leaves the cell */
	float centre[2][LANES], end[2][LANES], first[LANES], last[LANES], share[LANES];
};

SOIL_INLINED struct stress_soil soil_of(const struct lane_posts *p, int i)
{
	return (struct stress_soil){p->k[i], p->n[i], p->elastic[i], p->by_elastic[i], p->cohesion[i], p->tan_phi[i], p->modulus[i], p->by_modulus[i], p->damping[i]};
}

SOIL_INLINED bool any_above(const float numbers[LANES], float than)
{
	float highest = numbers[0];
	for (int i = 1; i < LANES; i++)
		highest = most(highest, numbers[i]);
	return highest > than;
}

/* --- how a surface slides --- */

SOIL_INLINED void normal_of(const struct soil_form *f, const struct lane_posts *p, int i, const struct face *face, float normal[3])
{
	const float ground = f->ground_normals, body = 1 - f->ground_normals; /* products, so that no lane skips reading a raster */
	normal[0] = body * face->normal[0] - ground * p->rise_x[i] * p->up[i];
	normal[1] = body * face->normal[1] - ground * p->rise_y[i] * p->up[i];
	normal[2] = body * face->normal[2] + ground * p->up[i];
}

/* Gives how the surface moves over the body at a place, by the body's turning and by its belt, along `across`. */
SOIL_INLINED void running_at(const struct soil_form *f, const float spin[3], float ran, const float arm[3], const float normal[3], float across[2][3],
			     float along[2])
{
	float moved[3], belt[3];
	cross3(spin, arm, moved);
	cross3(normal, f->belt, belt);
	for (int k = 0; k < 3; k++)
		moved[k] += ran * belt[k];
	along[0] = dot3(moved, across[0]);
	along[1] = dot3(moved, across[1]);
}

/* How long a body's rolling surface is above a place, of the time for which the soil lies below the body. A rim passes over the soil faster than the
 * axle if it slips, and its surface is longer than its way. 1: the surface does not roll. */
SOIL_INLINED float time_of(const struct soil_form *f, const float running[2], float passes, float up)
{
	const float squares = running[0] * running[0] + running[1] * running[1], ran = sqrtf(squares), way = f->passes[0];
	const float along = running[0] * f->way[0] + running[1] * f->way[1], both = squares * way * way;
	const float aligned = either(both > 0, along * along / most(both, 1e-30f), 1) * f->rolls;
	const float share = either(ran > 0.1f * passes, most(passes / most(ran, 1e-30f), 0.1f), 10), rolls = clamped(10 * ran / most(passes, 1e-30f), 0, 1);
	return 1 + rolls * ((1 + (share - 1) * aligned) * up - 1);
}

struct slip {
	float direction[2], size, time; /* along the surface; m; time_of */
};

SOIL_INLINED struct slip slip_at(const struct soil_form *f, const float arm[3], const float normal[3], float across[2][3])
{
	float running[2];
	running_at(f, f->spin, f->ran, arm, normal, across, running);
	const float x = dot3(f->way, across[0]) + running[0], y = dot3(f->way, across[1]) + running[1], squares = x * x + y * y, by = 1 / sqrtf(most(squares, 1e-20f));
	return (struct slip){{x * by, y * by}, squares * by, time_of(f, running, f->passes[0], f->level * f->belt_level / normal[2])};
}

/* How far the surface slips over the ground, m, as if the place were at the body's lowest level. So a rim that rolls slips nowhere. It counts for
 * the time in which a rolling surface passes. */
SOIL_INLINED float dig_way(const struct soil_form *f, float x, float y)
{
	const float running[2] = {-f->spin[1] * f->reach - f->spin[2] * y - f->ran * f->belt[1], f->spin[2] * x + f->spin[0] * f->reach + f->ran * f->belt[0]};
	const float u = f->way[0] * f->along_ground + running[0], v = f->way[1] * f->along_ground + running[1], way = sqrtf(u * u + v * v);
	return either(way >= (float)SOIL_SLIP_LEAST, way, 0) * time_of(f, running, f->passes[1], 1);
}

/* --- 1 to 3 --- */

/* Returns for which last share of the motion the body has been deeper than the soil was compacted. Below 0: it is not so deep at the end. */
SOIL_INLINED float passed_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, float gains)
{
	const float x = p->x[i], y = p->y[i];
	float share;
	if (is_round(kind)) {
		/* When the circle in which the body is cut along its motion leaves the place. */
		const float squares = ring_squares(f, kind, y), ahead = ring_ahead(f, kind, x, y), moves = f->run * f->run + f->plunge * f->plunge;
		const float level = gains / f->lift - root(squares - ahead * ahead), nears = ahead * f->run + level * f->plunge;
		const float beyond = ahead * ahead + level * level - squares, rooted = nears * nears - moves * beyond;
		share = either(rooted >= 0, -beyond / most(nears + root(rooted), 1e-18f), -4);
		share = either(moves > 0, share, 1e3f);
	} else if (kind == FORM_RASTER) {
		/* A parabola through the heights above the post at the motion's start, halfway, and at its end. */
		const float whole = p->begun[i], half = p->halfway[i];
		const float speed = 4 * half - whole, bends = 2 * whole - 4 * half, rooted = speed * speed + 4 * bends * gains, by = speed + root(rooted);
		share = either(rooted >= 0, either(fabsf(by) > 1e-12f, 2 * gains / either(fabsf(by) > 1e-12f, by, 1), 1e3f), either(gains > 0, 1e3f, -4));
		share = least(share, either(p->over[i] > 0, p->entered[i], 1e3f));
	} else {
		const float speed = p->print[i] - p->height[i] - f->way[2];
		share = either(speed > 0, gains / most(speed, 1e-18f), 1e3f);
	}
	/* Then its sides pass. */
	const float ahead_by = 1 / most(fabsf(f->way[0]), 1e-9f), aside_by = 1 / most(fabsf(f->way[1]), 1e-9f), over = p->over[i];
	if (kind == FORM_BOX) {
		const float beyond = most(f->half[0] - x * either(f->way[0] < 0, -1, 1), 0) * ahead_by;
		share = least(share, either((over > 0) & (f->half[0] > 0) & (fabsf(f->way[0]) > 1e-9f), beyond, 1e3f));
	}
	if (kind == FORM_BOX || kind == FORM_RIM) {
		const float beyond = most(f->half[1] - aside_of(f, kind, x, y) * either(f->way[1] < 0, -1, 1), 0) * aside_by;
		share = least(share, either((over > 0) & (f->half[1] > 0) & (fabsf(f->way[1]) > 1e-9f), beyond, 1e3f));
	}
	return clamped(share, -4, 1e3f);
}

SOIL_INLINED float lasted(const struct lane_posts *p, int i, float passed)
{
	return either(p->over[i] > 0, least(passed, 1), passed);
}

SOIL_INLINED void put_depths(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int32_t raised, struct block *l)
{
	EACH_LANE {
		l->ground[i] = (float)(p->ground[i] - raised) * SOIL_UNIT - f->beyond;
		l->depth[i] = l->ground[i] - p->height[i] - p->above[i];
		l->was[i] = p->was[i];
		l->more[i] = 0;
		l->share[i] = either(p->room[i] > (float)raised * SOIL_UNIT + f->beyond, p->share[i], 0);
		l->plastic[i] = 0;
	}
	if (any_above(p->was, 0))
		EACH_LANE {
			const struct stress_soil s = soil_of(p, i);
			l->plastic[i] = plastic_of(&s, l->was[i]);
		}
	EACH_LANE l->passed[i] = passed_at(f, kind, p, i, l->depth[i] - l->plastic[i] * p->by_up[i]);
}

/* Returns the mean share of the shear strength, by size, that is mobilised in the motion: Simpson's rule. */
SOIL_INLINED float mean_mobilised(float x, float y, const float direction[2], float halfway)
{
	const float dx = x - direction[0], dy = y - direction[1];
	const float mx = direction[0] + halfway * dx, my = direction[1] + halfway * dy, ex = direction[0] + halfway * halfway * dx, ey = direction[1] + halfway * halfway * dy;
	return (sqrtf(x * x + y * y) + 4 * sqrtf(mx * mx + my * my) + sqrtf(ex * ex + ey * ey)) * (1 / 6.0f);
}

/* Slip digs soil from below the body, so the body must sink by that much more to be borne as before. For each way that it slips
 * dD = |e| (kappa K - D) / K, D what slip has dug. Compacted soil stays where it is, so it lies less deep below the lowered ground. */
SOIL_INLINED void dig(const struct soil_form *f, const struct lane_posts *p, struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float half = 0.5f * most(lasted(p, i, l->passed[i]), 0), x = p->x[i] + half * f->way[0], y = p->y[i] + half * f->way[1];
		const float lowest = p->height[i] + p->above[i] - p->lowered[i], up = p->up[i];
		const float deepest = most(up * (l->ground[i] - lowest), 0), sunk = up * l->depth[i], after = most(l->was[i], deepest);
		const float stays = least(plastic_of(&s, after), after - SOIL_UNIT), touching = clamped(l->passed[i], 0, 1);
		const float halfway = exp_minus(0.5f * l->slides[i] * touching), direction[2] = {l->direction[0][i], l->direction[1][i]};
		const float mean = mean_mobilised(p->shear_x[i], p->shear_y[i], direction, halfway);
		const float limit = least(f->digs_most * s.modulus * p->by_up[i], 95) - p->dug[i];
		const float digs = most(limit, 0) * (1 - exp_minus(dig_way(f, x, y) * touching * s.by_modulus * mean));
		const float room = l->depth[i] - 2 * SOIL_UNIT; /* it never digs itself free */
		l->more[i] = either((p->over[i] > 0) & (sunk > most(stays, 0)), most(least(digs, room), 0), 0);
		l->ground[i] -= l->more[i];
		l->depth[i] -= l->more[i];
		l->was[i] = most(l->was[i] - up * l->more[i], 0);
	}
	if (any_above(l->was, 0))
		EACH_LANE {
			const struct stress_soil s = soil_of(p, i);
			l->plastic[i] = plastic_of(&s, l->was[i]);
		}
}

SOIL_INLINED void put_slides(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, struct block *l)
{
	EACH_LANE {
		const float half = 0.5f * most(lasted(p, i, l->passed[i]), 0), x = p->x[i] + half * f->way[0], y = p->y[i] + half * f->way[1];
		struct face then;
		float normal[3], across[2][3];
		face_at(f, kind, p->own[i], x, y, &then);
		normal_of(f, p, i, &then, normal);
		put_across(normal, across);
		const float arm[3] = {x, y, then.height + p->above[i]};
		const struct slip slip = slip_at(f, arm, normal, across);
		l->slides[i] = slip.size * slip.time * p->by_modulus[i];
		l->direction[0][i] = slip.direction[0];
		l->direction[1][i] = slip.direction[1];
	}
}

/* A way in plan of the motion: its direction, and how the body rose along it. */
struct course {
	float x, y, rise;
};

SOIL_INLINED struct course course_of(const struct soil_form *f)
{
	const float by = f->passes[0] > 0 ? 1 / most(f->passes[0], 1e-9f) : 0;
	return (struct course){f->way[0] * by, f->way[1] * by, clamped(f->way[2] * by, -1, 1)};
}

/* Of a form that is known at posts alone: how much lower than now it passed a post. A body that is not flat may pass its lowest place within the
 * cell, after the post. */
SOIL_INLINED void put_beneath(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, struct block *l)
{
	const struct course course = course_of(f);
	EACH_LANE {
		struct face face = {.height = 0};
		float bends[3];
		face_at(f, kind, p->own[i], p->x[i], p->y[i], &face);
		put_bends(f, kind, p->own[i], p->x[i], p->y[i], &face, bends);
		const float leans = face.slope[0] * course.x + face.slope[1] * course.y - course.rise;
		const float curved = bends[0] * course.x * course.x + 2 * bends[1] * course.x * course.y + bends[2] * course.y * course.y;
		const bool within = (leans > 0) & (leans < curved * least(f->passes[0] + f->half_across, 2 * f->half_across));
		const float later = either(within, 0.5f * leans * leans / most(curved, 1e-9f), 0);
		l->beneath[i] = either(p->lowered[i] > 0, p->lowered[i], later);
	}
}

/* Returns how much lower than now the body was above a place of a cell. Of a form that is known at posts alone: its lowest height goes on along the
 * motion from the post, where it was lower before. */
SOIL_INLINED float lower_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, const struct block *l, float x, float y,
			    float *since)
{
	*since = f->passes[0];
	if (knows_places(kind))
		return lowered_at(f, kind, x, y, l->back[i], p->rise_x[i], since);
	const struct course course = course_of(f);
	struct face face = {.height = 0};
	face_at(f, kind, p->own[i], x, y, &face);
	const float dx = x - p->x[i], dy = y - p->y[i], along = dx * course.x + dy * course.y, aside = course.x * dy - course.y * dx;
	const float leans = face.slope[0] * course.x + face.slope[1] * course.y - course.rise, across = course.x * p->slope_y[i] - course.y * p->slope_x[i];
	/* In a short motion it was lower by no more than it rose since. */
	const float lowest = p->height[i] - l->beneath[i] + course.rise * along + across * aside, rose = most(l->beneath[i], -leans * f->passes[0]);
	const float lower = either(leans < 0, clamped(face.height - lowest, 0, rose), 0);
	return either(f->passes[0] > 0, lower, p->lowered[i]) * p->over[i];
}

/* The stored sinkage counts for the post's whole cell. Where the body bore at the motion's start, it has the shape of the lower envelope there
 * (printed). Else it is a flat rut, or the impression of a body that hardly moved (stamped). */
SOIL_INLINED void put_memory(const struct soil_form *f, const struct lane_posts *p, struct block *l)
{
	EACH_LANE {
		const float stays = l->plastic[i] * p->by_up[i], whole = l->was[i] * p->by_up[i] - stays;
		const float before = l->depth[i] + p->height[i] - p->print[i] + f->way[2];
		l->printed[i] = clamped((before - stays + 4 * SOIL_LEAST) / most(whole, 1e-9f), 0, 1);
		l->stamped[i] = either(l->was[i] > 0, f->stamps, 0);
		l->back[i] = either(p->over[i] > 0, f->run + least(f->run, f->half_across), 1e3f);
		/* Of the places in a cell, those farther ahead came into contact later, so they slid less. But if the post stores less shear than the
		 * motion since the first touch gives, the body stood on it before it moved. Then the places differ less. */
		const float mobilised = sqrtf(p->shear_x[i] * p->shear_x[i] + p->shear_y[i] * p->shear_y[i]);
		const float way = either(mobilised > 0.9999f, 1e3f, -0.69314718f * log2_of(most(1 - mobilised, 1e-4f)));
		const float known = clamped(way / most(l->slides[i] * (l->passed[i] - 1), 1e-9f), 0, 1);
		l->lasts[i] = either((p->over[i] > 0) & (l->passed[i] > 1), known, 1) * f->moved;
	}
}

/* Returns the largest sinkage that a place of the cell remembers, vertically. depth: of the body there; rise: of the ground from the post. */
SOIL_INLINED float remembered_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, const struct block *l, int lane,
				 float x, float y, float depth, float rise)
{
	const float print = rise + p->print[i] - height_at(f, kind, p->own[i], x + f->way[0], y + f->way[1]);
	const float leans = kind == FORM_RIM ? (1 - l->stamped[lane]) * (p->rise_y[i] - f->lean * f->lift) * (y - p->y[i]) : 0;
	const float hollow = l->stamped[lane] * (depth - l->depth[lane]) + leans;
	const float all = l->was[lane] * p->by_up[i] + l->printed[lane] * print + (1 - l->printed[lane]) * hollow;
	return all * either(l->was[lane] > 0, 1, 0);
}

/* A line across the cell, in the direction in which the depth of the lower envelope changes most. The depth along it is taken as a parabola. An end of
 * what bears lies where the body leaves the surface; where it unloads, where it leaves the plastic part of the earlier sinkage. */
SOIL_INLINED void put_line(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, struct block *l)
{
	float depths[3][LANES], mosts[3][LANES], unloads[2][LANES], stays[3][LANES];
	const bool known = any_above(l->was, 0);
	EACH_LANE {
		const float x = p->rise_x[i] - p->slope_x[i], y = p->rise_y[i] - p->slope_y[i], squares = x * x + y * y;
		const float by = f->half_across / sqrtf(most(squares, 1e-8f));
		const bool turns = kind != FORM_RIM && squares >= 1e-8f;
		l->end[0][i] = either(turns, x * by, f->half_across);
		l->end[1][i] = either(turns, y * by, 0);
		l->centre[0][i] = p->x[i] + p->middle_x[i];
		l->centre[1][i] = p->y[i] + p->middle_y[i];
	}
	for (int k = 0; k < 3; k++) {
		EACH_LANE {
			const float x = l->centre[0][i] + (float)(k - 1) * l->end[0][i], y = l->centre[1][i] + (float)(k - 1) * l->end[1][i];
			const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
			const float depth = l->depth[i] + p->height[i] + rise - height_at(f, kind, p->own[i], x, y);
			float since;
			const float lower = lower_at(f, kind, p, i, l, x, y, &since);
			depths[k][i] = depth;
			mosts[k][i] = depth + lower;
		}
		if (known)
			EACH_LANE {
				const float x = l->centre[0][i] + (float)(k - 1) * l->end[0][i], y = l->centre[1][i] + (float)(k - 1) * l->end[1][i];
				const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
				mosts[k][i] = most(mosts[k][i], remembered_at(f, kind, p, i, l, i, x, y, depths[k][i], rise));
			}
	}
	for (int k = 0; k < 2; k++)
		EACH_LANE unloads[k][i] = either(mosts[2 * k][i] > most(depths[2 * k][i], 0) + SOIL_LEAST, 1, 0);
	const bool any = any_above(unloads[0], 0) || any_above(unloads[1], 0);
	for (int k = 0; k < 3; k++)
		if (any)
			EACH_LANE {
				const struct stress_soil s = soil_of(p, i);
				stays[k][i] = plastic_of(&s, mosts[k][i] * p->up[i]) * p->by_up[i];
			}
		else
			memset(stays[k], 0, sizeof stays[k]);
	EACH_LANE {
		float from[3], to[3];
		for (int k = 0; k < 3; k++) {
			from[k] = depths[k][i] - stays[k][i] * unloads[0][i];
			to[k] = depths[k][i] - stays[k][i] * unloads[1][i];
		}
		l->first[i] = root_from(-1, from);
		l->last[i] = most(l->first[i], root_from(1, to));
		/* A wheel that sank to its axle does not bear on the soil in front of its rim. */
		const bool ahead = (p->over[i] == 0) & (fabsf(p->x[i]) > f->radius) & (l->depth[i] > 0);
		l->share[i] = either((kind == FORM_RIM) & ahead, 0, l->share[i]);
	}
}

/* --- 4: places --- */

/* The soil at a place of each lane. */
struct spots {
	float x[LANES], y[LANES], deep[LANES], most[LANES], yields[LANES], unloads[LANES], stays[LANES], touching[LANES], part[LANES];
};

SOIL_INLINED void put_spots(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, const struct block *l, float at,
			    struct spots *spots)
{
	const bool known = any_above(l->was, 0);
	EACH_LANE {
		const float on = 0.5f * (l->first[i] + l->last[i]) + at * (l->last[i] - l->first[i]);
		const float x = l->centre[0][i] + on * l->end[0][i], y = l->centre[1][i] + on * l->end[1][i];
		const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
		const float deep = l->depth[i] + p->height[i] + rise - height_at(f, kind, p->own[i], x, y);
		float since;
		const float lower = lower_at(f, kind, p, i, l, x, y, &since);
		spots->x[i] = x;
		spots->y[i] = y;
		spots->deep[i] = deep;
		spots->most[i] = deep + lower;
		/* Where the body was deeper before in its motion, its deepest pose sinks by less than the last one. */
		spots->unloads[i] = either(lower > 0, 1, 0) * either(f->passes[0] > 0, least(since / most(f->passes[0], 1e-9f), 1), 1);
		spots->part[i] = 0.25f * l->share[i] * (l->last[i] - l->first[i]); /* of two places, on a line from -1 to 1 */
		const float later = ((x - p->x[i]) * f->by_way[0] + (y - p->y[i]) * f->by_way[1]) * l->lasts[i];
		spots->touching[i] = l->slides[i] * most(lasted(p, i, l->passed[i]) - later, 0);
	}
	if (known)
		EACH_LANE {
			const float rise = p->rise_x[i] * (spots->x[i] - p->x[i]) + p->rise_y[i] * (spots->y[i] - p->y[i]);
			const float before = remembered_at(f, kind, p, i, l, i, spots->x[i], spots->y[i], spots->deep[i], rise);
			spots->unloads[i] = either(before >= spots->most[i], 1, spots->unloads[i]);
			spots->most[i] = most(spots->most[i], before);
		}
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		spots->most[i] *= p->up[i];
		spots->yields[i] = yield_stress(&s, spots->most[i]);
		spots->stays[i] = exp_minus(spots->touching[i]);
	}
}

/* One place, as a probe needs it. Amounts are those of the place's share of a post's area. */
struct place {
	float arm[3], normal[3], across[2][3];
	float area, ground;              /* of the surface, and of the ground that bears; posts */
	float stress, strength, holds;   /* Pa: normal, with damping; the most that shear can be; how that grows with the normal stress */
	float mobilised[2], dragged[2];  /* shear along `across`: share of the strength; Pa, of damping */
	float sinks, damps;              /* growth of the normal stress: Pa/m as the surface goes down, Pa s/m with its speed along the normal */
	float shears[2][2], drags[2][2]; /* 1/m, Pa s/m: growth of `mobilised` and `dragged` with a way, a speed along `across` */
};

/* How a damping that is for slow motion alone fades. squares: of the speed, as a share of the speed at which it is halved. */
SOIL_INLINED float fade(float squares)
{
	return 1 / (1 + squares);
}

/* Returns how the stress of such a damping grows with the speed; 0 where it falls. */
SOIL_INLINED float fade_slope(float fades)
{
	return fades * most(2 * fades - 1, 0);
}

/* Adds damping: of soil that is pushed down fast, and of a surface that hardly slides. damping: Pa s/m, what counts of the soil's. Grousers do not count
 * for the speed: a bar that passes pushes no more soil down. */
SOIL_INLINED void put_rates(const struct soil_form *f, float damping, float down, struct place *place)
{
	const float slow = fade(down * down / (SETTLES * SETTLES)), settles = SETTLING * damping, damps = either(down >= 0, damping, 0);
	float along[2];
	place->stress = most(place->stress + (damps + settles * slow) * down, 0);
	place->damps = damps + settles * fade_slope(slow);
	running_at(f, f->angular, f->runs, place->arm, place->normal, place->across, along);
	along[0] += dot3(f->linear, place->across[0]);
	along[1] += dot3(f->linear, place->across[1]);
	const float squares = along[0] * along[0] + along[1] * along[1], fades = fade(squares / (STICKS * STICKS));
	const float sticks = damping * fades, drops = either(squares > 0, damping * (fades - fade_slope(fades)) / most(squares, 1e-30f), 0);
	for (int k = 0; k < 2; k++) {
		place->dragged[k] = sticks * along[k];
		for (int j = 0; j < 2; j++)
			place->drags[k][j] = (k == j ? sticks : 0) - drops * along[k] * along[j];
	}
}

/* Returns how fast the surface at a place goes down along its normal, m/s. */
SOIL_INLINED float down_at(const struct soil_form *f, const float arm[3], float above, const float normal[3])
{
	const float place[3] = {arm[0], arm[1], arm[2] - above};
	float moves[3];
	cross3(f->angular, place, moves);
	return -(dot3(f->linear, normal) + dot3(moves, normal));
}

SOIL_INLINED void put_place(const struct soil_form *f, enum soil_form_kind kind, bool asked, const struct lane_posts *p, int i,
			    const struct spots *spots, int lane, struct face *face, struct place *place)
{
	const struct stress_soil s = soil_of(p, i);
	const float up = p->up[i], x = spots->x[lane], y = spots->y[lane], largest = spots->most[lane], z = up * spots->deep[lane], yields = spots->yields[lane];
	face_at(f, kind, p->own[i], x, y, face);
	normal_of(f, p, i, face, place->normal);
	put_across(place->normal, place->across);
	place->arm[0] = x;
	place->arm[1] = y;
	place->arm[2] = face->height + p->above[i];
	const float plastic = plastic_part(&s, largest, yields), by_elastic = 1 / most(largest - plastic, 1e-9f);
	const float springs = clamped((z + SOIL_LEAST - plastic) * by_elastic, 0, 1), share = either(z >= largest, 1, springs);
	const float down = down_at(f, place->arm, p->above[i], place->normal);
	place->ground = either(least(z, share) > 0, spots->part[lane], 0);
	/* A flat end that is as wide as several cells bears by its area in plan: all of it on level ground. */
	const float level = clamped(1 - (place->normal[0] * p->rise_x[i] + place->normal[1] * p->rise_y[i]) / most(place->normal[2], 1e-6f), 0, 1);
	const float plane = either(f->ground_normals + face->end > 0, 1, place->normal[2]), bears = either((kind == FORM_END) & (face->end > 0) & (f->ground_normals == 0), level, 1);
	place->area = place->ground * bears / plane;
	place->stress = yields * share;
	/* At the yield surface the soil yields if the body goes on down, and springs back if it does not. */
	const float flows = either(z >= largest - SOIL_LEAST, either((down > 0) | (f->rates == 0), 1, 0), 0), unloads = (1 - flows) * either(z >= largest - SOIL_LEAST, 1, spots->unloads[lane]);
	place->sinks = up * ((1 - unloads) * yield_growth(&s, yields, largest) + unloads * yields * by_elastic);
	put_rates(f, s.damping * least(4 * share, 1) * least(4 * most(largest, 0) * s.by_modulus, 1), down, place);
	const struct slip slip = slip_at(f, place->arm, place->normal, place->across);
	place->mobilised[0] = sheared(p->shear_x[i], slip.direction[0], spots->stays[lane]);
	place->mobilised[1] = sheared(p->shear_y[i], slip.direction[1], spots->stays[lane]);
	place->strength = strength_of(&f->surface, &s, place->stress, &place->holds);
	if (asked) {
		const float touching = spots->touching[lane], turning = either(touching > 0, (1 - spots->stays[lane]) / most(slip.size, 1e-9f), 0);
		const float by = s.by_modulus * slip.time; /* where it begins to slide it is half as stiff on, and half as much stiffer back */
		for (int k = 0; k < 2; k++)
			for (int j = 0; j < 2; j++) {
				const float grows = (slip.direction[k] - place->mobilised[k]) * slip.direction[j] * by + ((k == j) - slip.direction[k] * slip.direction[j]) * turning;
				place->shears[k][j] = either(slip.size > 1e-9f, grows, k == j ? s.by_modulus : 0);
			}
	}
}

/* --- the lower end of a rim that leans --- */

/* It covers less than a post in plan, so it is summed beside the last cell. Its shear is followed along its way, in so many steps: it turns over the
 * soil, downwards ahead of the axle and upwards behind it. */
#define BRIM_STEPS 4

/* The edge of the lower end beside a cell. */
struct edge {
	float at[2], lowest, depth; /* its lowest place beside the part that bears; m below the ground there */
	float length, strip;        /* of that part, in lines across a cell; half the width of the strip there */
};

SOIL_INLINED struct edge edge_of(const struct soil_form *f, const struct lane_posts *p, const struct block *l, int i)
{
	const float beside = low_side(f) * f->half_axis * f->level, x = l->centre[0][i], y = l->centre[1][i], rise_x = p->rise_x[i], rise_y = p->rise_y[i];
	const float height = l->ground[i] + rise_x * (x - p->x[i]) + rise_y * (y - p->y[i]) - p->above[i];
	float depths[3];
	for (int k = 0; k < 3; k++) {
		const float along = (float)(k - 1) * f->half_across, strip = half_strip(f, x + along), aside = f->lean * strip + beside;
		depths[k] = height + rise_x * along + rise_y * (aside - y) - (f->lean * aside - strip) * f->lift;
	}
	const float first = root_from(-1, depths), last = most(first, root_from(1, depths)), at = 0.5f * (first + last) * f->half_across;
	const float strip = half_strip(f, x + at), aside = f->lean * strip + beside, lowest = (f->lean * aside - strip) * f->lift;
	return (struct edge){{x + at, aside}, lowest, height + rise_x * at + rise_y * (aside - y) - lowest, 0.5f * (last - first), strip};
}

/* How long the end has slid over the soil beside its edge, in motions. It began when the rim came from ahead, or the end from above. A short motion
 * says little of it. mean: m, of its depth; below: its place on the rim, ahead of the axle. */
SOIL_INLINED float brim_since(const struct soil_form *f, const struct edge *edge, float mean, float below)
{
	const float came = either(f->run > 0, most(half_strip(f, below) - edge->at[0], 0) / most(f->run, 1e-12f), 1e9f);
	const float sank = either(f->way[2] < 0, mean / most(-f->way[2], 1e-12f), 1e9f), since = least(came, sank), rolled = least(f->run / f->half_across, 1);
	return either(since < 1e9f, either(since > 1, 1 + (since - 1) * rolled * rolled, since), 1);
}

/* Gives what the end bears beside a post's cell. It bears the mean of the pressure from 0 to the depth of its edge, by its area in plan. */
SOIL_INLINED void put_brim(const struct soil_form *f, bool asked, const struct lane_posts *p, const struct block *l, int i, struct place *place)
{
	const struct stress_soil s = soil_of(p, i);
	const struct edge edge = edge_of(f, p, l, i);
	const float low = low_side(f), leans = most(fabsf(f->lean), 1e-6f), steep = f->level / leans, up = p->up[i], rise_x = p->rise_x[i], rise_y = p->rise_y[i];
	const float width = clamped(edge.depth / most(steep - low * rise_y, 1e-6f), 0, 2 * edge.strip * fabsf(f->lean));
	const float deep = most(edge.depth, SOIL_UNIT), mean = deep * power_of(s.n + 1, -1 / s.n), out_by = width / (s.n + 2);
	const float bears = either(f->ground_normals > 0, 1, clamped(1 + low * f->level * rise_y / leans, 0, 1));
	const bool is = ((low < 0 ? p->side_right[i] : p->side_left[i]) > 0) & (l->share[i] > 0) & (edge.depth > 0);
	place->area = place->ground = either(is, edge.length * width * f->by_step * bears, 0);
	place->stress = yield_stress(&s, up * mean);
	place->sinks = place->stress * (s.n + 1) / deep;
	place->arm[0] = edge.at[0];
	place->arm[1] = edge.at[1] + low * out_by;
	place->arm[2] = edge.lowest + out_by * steep + p->above[i];
	place->normal[0] = either(f->ground_normals > 0, -rise_x * up, 0);
	place->normal[1] = either(f->ground_normals > 0, -rise_y * up, -low * f->level);
	place->normal[2] = either(f->ground_normals > 0, up, leans);
	put_across(place->normal, place->across);
	put_rates(f, s.damping * least(4 * up * mean * s.by_modulus, 1), down_at(f, place->arm, p->above[i], place->normal), place);
	place->strength = strength_of(&f->surface, &s, place->stress, &place->holds);
	const float since = brim_since(f, &edge, mean, edge.strip - out_by / leans), each = since * (1.0f / BRIM_STEPS);
	place->mobilised[0] = place->mobilised[1] = 0;
	for (int n = BRIM_STEPS - 1; n >= 0; n--) {
		const float back = ((float)n + 0.5f) * each, arm[3] = {place->arm[0] + back * f->way[0], place->arm[1] + back * f->way[1], place->arm[2] + back * f->way[2]};
		const struct slip slip = slip_at(f, arm, place->normal, place->across);
		const float stays = exp_minus(slip.size * each * s.by_modulus);
		place->mobilised[0] = sheared(place->mobilised[0], slip.direction[0], stays);
		place->mobilised[1] = sheared(place->mobilised[1], slip.direction[1], stays);
	}
	if (asked) { /* how the way before this motion changes is left out */
		const struct slip slip = slip_at(f, place->arm, place->normal, place->across);
		const float turning = (1 - exp_minus(slip.size * least(since, 1) * s.by_modulus)) / most(slip.size, 1e-9f);
		for (int k = 0; k < 2; k++)
			for (int j = 0; j < 2; j++) {
				const float grows = (slip.direction[k] - place->mobilised[k]) * slip.direction[j] * s.by_modulus + ((k == j) - slip.direction[k] * slip.direction[j]) * turning;
				place->shears[k][j] = either(slip.size > 1e-9f, grows, k == j ? s.by_modulus : 0);
			}
	}
}

/* --- sums --- */

/* Whole numbers of each lane. */
struct counts {
	int32_t force[3][LANES], moment[3][LANES], pull[LANES], area[LANES], saturated[LANES], deepest[LANES];
	float grows[LANES];
};

/* What a probe adds up, for each lane. */
struct lane_changes {
	float normal[3][LANES], normal_force[LANES], shear_limit[LANES], sheared[3][LANES];
	float stiffness[6][6][LANES], damping[6][6][LANES];
};

/* Gives the stress on the body at a place, Pa of its surface. shear: of its shear, the direction times the share of the strength. */
SOIL_INLINED void stress_at(const struct place *place, float shear[3], float stress[3])
{
	for (int k = 0; k < 3; k++) {
		shear[k] = place->mobilised[0] * place->across[0][k] + place->mobilised[1] * place->across[1][k];
		stress[k] = place->stress * place->normal[k] - place->strength * shear[k] - place->dragged[0] * place->across[0][k] -
			    place->dragged[1] * place->across[1][k];
	}
}

/* The places of the lanes, as a probe needs them: means of both places of a lane, by area. */
struct lane_places {
	float area[LANES], ground[LANES], stress[LANES], strength[LANES], holds[LANES], sinks[LANES], damps[LANES];
	float arm[3][LANES], normal[3][LANES], across[2][3][LANES], mobilised[2][LANES], dragged[2][LANES], shears[2][2][LANES], drags[2][2][LANES], bends[3][LANES];
};

/* Adds a place, times its area. */
SOIL_INLINED void add_place(const struct place *place, const float bends[3], int i, struct lane_places *all)
{
	const float area = place->area;
	all->area[i] += area;
	all->ground[i] += place->ground;
	all->stress[i] += area * place->stress;
	all->strength[i] += area * place->strength;
	all->holds[i] += area * place->holds;
	all->sinks[i] += area * place->sinks;
	all->damps[i] += area * place->damps;
	for (int k = 0; k < 3; k++) {
		all->arm[k][i] += area * place->arm[k];
		all->normal[k][i] += area * place->normal[k];
		all->across[0][k][i] += area * place->across[0][k];
		all->across[1][k][i] += area * place->across[1][k];
		all->bends[k][i] += area * bends[k];
	}
	for (int k = 0; k < 2; k++) {
		all->mobilised[k][i] += area * place->mobilised[k];
		all->dragged[k][i] += area * place->dragged[k];
		for (int j = 0; j < 2; j++) {
			all->shears[k][j][i] += area * place->shears[k][j];
			all->drags[k][j][i] += area * place->drags[k][j];
		}
	}
}

/* Returns the mean of a lane. Without any area it is a level surface. */
SOIL_INLINED struct place mean_of(const struct lane_places *all, int i)
{
	const float by = 1 / most(all->area[i], 1e-30f);
	struct place mean = {
		.area = all->area[i], .ground = all->ground[i], .stress = all->stress[i] * by, .strength = all->strength[i] * by, .holds = all->holds[i] * by,
		.sinks = all->sinks[i] * by, .damps = all->damps[i] * by,
	};
	for (int k = 0; k < 3; k++) {
		mean.arm[k] = all->arm[k][i] * by;
		mean.normal[k] = all->normal[k][i] * by;
		mean.across[0][k] = all->across[0][k][i] * by;
		mean.across[1][k] = all->across[1][k][i] * by;
	}
	mean.normal[2] = either(mean.area > 0, mean.normal[2], 1);
	for (int k = 0; k < 2; k++) {
		mean.mobilised[k] = all->mobilised[k][i] * by;
		mean.dragged[k] = all->dragged[k][i] * by;
		for (int j = 0; j < 2; j++) {
			mean.shears[k][j] = all->shears[k][j][i] * by;
			mean.drags[k][j] = all->drags[k][j][i] * by;
		}
	}
	return mean;
}

/* Adds a column times a row. */
SOIL_INLINED void add_product(const float a[3], float by, const float b[3], float matrix[3][3])
{
	for (int i = 0; i < 3; i++) {
		const float times = a[i] * by;
		matrix[i][0] += times * b[0];
		matrix[i][1] += times * b[1];
		matrix[i][2] += times * b[2];
	}
}

/* How the force at the lanes' places changes with a way, and with a speed, of the surface there: N/m, N s/m. */
struct lane_growths {
	float stiff[3][3][LANES], slow[3][3][LANES], stress[3][LANES];
};

/* Adds what shear along one of the two directions adds to how the stress grows. along: growths with ways, speeds along both. */
SOIL_INLINED void add_along(const struct place *place, int r, float by, const float along[2], float matrix[3][3])
{
	float both[3];
	for (int k = 0; k < 3; k++)
		both[k] = along[0] * place->across[0][k] + along[1] * place->across[1][k];
	add_product(place->across[r], -by, both, matrix);
}

SOIL_INLINED void put_matrix(const float matrix[3][3], int i, float to[3][3][LANES])
{
	for (int k = 0; k < 3; k++) {
		to[k][0][i] = matrix[k][0];
		to[k][1][i] = matrix[k][1];
		to[k][2][i] = matrix[k][2];
	}
}

/* The body's surface rises above a place of the ground by n . motion / n_z. */
SOIL_INLINED void put_growths(const struct soil_form *f, const struct lane_places *all, struct lane_growths *growths)
{
	const float post = f->spacing * f->spacing;
	EACH_LANE {
		const struct place place = mean_of(all, i);
		const float *n = place.normal, area = place.area * post, strength = area * place.strength;
		float shear[3], stress[3], grows[3], stiff[3][3] = {{0}}, slow[3][3] = {{0}};
		stress_at(&place, shear, stress);
		for (int k = 0; k < 3; k++) {
			grows[k] = (n[k] - place.holds * shear[k]) * area;
			growths->stress[k][i] = stress[k];
		}
		add_product(grows, -place.sinks / n[2], n, stiff);
		add_product(grows, -place.damps, n, slow);
		add_along(&place, 0, strength, place.shears[0], stiff);
		add_along(&place, 1, strength, place.shears[1], stiff);
		add_along(&place, 0, area, place.drags[0], slow);
		add_along(&place, 1, area, place.drags[1], slow);
		put_matrix((const float(*)[3])stiff, i, growths->stiff);
		put_matrix((const float(*)[3])slow, i, growths->slow);
	}
}

/* Adds how the normals turn as the body moves, while the place on the ground stays. They turn with the body, and since a body that is not flat shows
 * another part of its surface. Adds also how the arm grows as the surface rises. */
SOIL_INLINED void add_turning(const struct soil_form *f, const struct lane_places *all, struct lane_growths *growths, float matrix[6][6][LANES])
{
	const float post = f->spacing * f->spacing, turns = f->ground_normals > 0 ? 0 : 1;
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), area = all->area[i] * post;
		const float n[3] = {all->normal[0][i] * by, all->normal[1][i] * by, either(all->area[i] > 0, all->normal[2][i] * by, 1)};
		const float arm[3] = {all->arm[0][i] * by, all->arm[1][i] * by, all->arm[2][i] * by};
		const float by_up = 1 / n[2], x = n[0] * by_up, y = n[1] * by_up, force = turns * area * n[2] * all->stress[i] * by;
		const float rows[2][3] = {{-x * y * force, (1 + x * x) * force, -y * force}, {(-1 - y * y) * force, x * y * force, x * force}};
		float rise[3];
		growths->stiff[0][0][i] += force * all->bends[0][i] * by;
		growths->stiff[0][1][i] += force * all->bends[1][i] * by;
		growths->stiff[1][0][i] += force * all->bends[1][i] * by;
		growths->stiff[1][1][i] += force * all->bends[2][i] * by;
		cross3(arm, n, rise);
		const float pull_x = growths->stress[0][i] * area * by_up, pull_y = growths->stress[1][i] * area * by_up;
		for (int k = 0; k < 3; k++) {
			matrix[0][3 + k][i] += rows[0][k];
			matrix[1][3 + k][i] += rows[1][k];
			matrix[3][k][i] -= pull_y * n[k];
			matrix[4][k][i] += pull_x * n[k];
			matrix[3][3 + k][i] -= arm[2] * rows[1][k] + pull_y * rise[k];
			matrix[4][3 + k][i] += arm[2] * rows[0][k] + pull_x * rise[k];
			matrix[5][3 + k][i] += arm[0] * rows[1][k] - arm[1] * rows[0][k];
		}
	}
}

/* Adds to a matrix those of the places: [1; S] by_place [1, S'], S the cross product with the arm. Forces, then moments, of motions, then turns. */
SOIL_INLINED void add_placed(const struct lane_places *all, float by_place[3][3][LANES], float matrix[6][6][LANES])
{
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), arm[3] = {all->arm[0][i] * by, all->arm[1][i] * by, all->arm[2][i] * by};
		float rows[6][3], turned[3];
		for (int k = 0; k < 3; k++) {
			for (int r = 0; r < 3; r++)
				rows[r][k] = by_place[r][k][i];
			rows[3][k] = arm[1] * rows[2][k] - arm[2] * rows[1][k];
			rows[4][k] = arm[2] * rows[0][k] - arm[0] * rows[2][k];
			rows[5][k] = arm[0] * rows[1][k] - arm[1] * rows[0][k];
		}
		for (int r = 0; r < 6; r++) {
			cross3(arm, rows[r], turned);
			for (int k = 0; k < 3; k++) {
				matrix[r][k][i] += rows[r][k];
				matrix[r][3 + k][i] += turned[k];
			}
		}
	}
}

/* Adds how the part of the cell grows as a side of the body moves over it. side: 0 .. 3: behind, ahead, right, left. */
SOIL_INLINED void add_side(const struct soil_form *f, enum soil_form_kind kind, const float sides[LANES], int side, const struct block *l,
			   const struct lane_places *all, const struct lane_growths *growths, float matrix[6][6][LANES])
{
	const int axis = side / 2;
	const float ahead = side % 2 == 0 ? -1 : 1, edge = ahead * f->half[axis], post = f->spacing * f->spacing;
	if (!any_above(sides, 0))
		return;
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), was = all->arm[1][i] * by;
		const float grows = either(sides[i] > 0, ahead * f->by_step * all->area[i] * post / most(l->share[i], 1e-6f), 0);
		float arm[3] = {all->arm[0][i] * by, was, all->arm[2][i] * by}, column[6], row[6] = {0};
		arm[axis] = edge + (axis == 1 ? was - aside_of(f, kind, arm[0], was) : 0);
		/* The side of a cylinder that leans is deeper or less deep than the place. */
		const float deeper = kind == FORM_RIM ? -f->lean * f->lift * (arm[1] - was) * all->sinks[i] * by : 0;
		for (int k = 0; k < 3; k++)
			column[k] = growths->stress[k][i] + deeper * all->normal[k][i] * by;
		row[axis] = grows;
		cross3(arm, column, column + 3);
		cross3(arm, row, row + 3);
		for (int r = 0; r < 6; r++)
			for (int k = 0; k < 6; k++)
				matrix[r][k][i] += column[r] * row[k];
	}
}

/* Adds what a probe asks. */
SOIL_INLINED void add_changes(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, const struct block *l, const struct lane_places *all,
			      struct lane_changes *changes)
{
	struct lane_growths growths;
	const float post = f->spacing * f->spacing;
	put_growths(f, all, &growths);
	EACH_LANE {
		const struct place mean = mean_of(all, i);
		const float up = mean.ground * p->up[i], area = mean.area * post;
		float shear[3], stress[3];
		stress_at(&mean, shear, stress);
		changes->normal_force[i] += area * mean.stress;
		changes->shear_limit[i] += area * mean.strength;
		for (int k = 0; k < 3; k++)
			changes->sheared[k][i] += area * mean.strength * shear[k];
		changes->normal[0][i] -= up * p->rise_x[i];
		changes->normal[1][i] -= up * p->rise_y[i];
		changes->normal[2][i] += up;
	}
	add_turning(f, all, &growths, changes->stiffness);
	add_placed(all, growths.stiff, changes->stiffness);
	add_placed(all, growths.slow, changes->damping);
	if (kind == FORM_RIM || kind == FORM_BOX) {
		add_side(f, kind, p->side_right, 2, l, all, &growths, changes->stiffness);
		add_side(f, kind, p->side_left, 3, l, all, &growths, changes->stiffness);
	}
	if (kind == FORM_BOX) {
		add_side(f, kind, p->side_behind, 0, l, all, &growths, changes->stiffness);
		add_side(f, kind, p->side_ahead, 1, l, all, &growths, changes->stiffness);
	}
}

/* Adds what one place of each lane bears. */
SOIL_INLINED void add_places(const struct soil_form *f, enum soil_form_kind kind, bool asked, float unit, const struct lane_posts *p,
			     const struct spots *spots, float stresses[7][LANES], struct counts *counts, struct lane_places *all)
{
	EACH_LANE {
		struct face face;
		struct place place;
		float shear[3], stress[3], moment[3], belt[3];
		put_place(f, kind, asked, p, i, spots, i, &face, &place);
		stress_at(&place, shear, stress);
		cross3(place.arm, stress, moment);
		cross3(place.normal, f->belt, belt);
		for (int k = 0; k < 3; k++) {
			stresses[k][i] += place.area * stress[k];
			stresses[3 + k][i] += place.area * moment[k];
		}
		stresses[6][i] -= place.area * dot3(stress, belt);
		counts->grows[i] += place.area * place.sinks * (place.normal[2] - place.holds * shear[2]) * unit;
		counts->area[i] += (int32_t)(place.ground * BEAR_AREA_UNITS + 0.5f);
		if (asked) {
			float bends[3];
			put_bends(f, kind, p->own[i], spots->x[i], spots->y[i], &face, bends);
			add_place(&place, bends, i, all);
		}
	}
}

/* Adds a column times a row to a matrix of a lane. */
SOIL_INLINED void add_outer(const float column[6], const float row[6], float by, int i, float matrix[6][6][LANES])
{
	for (int r = 0; r < 6; r++) {
		const float times = by * column[r];
		matrix[r][0][i] += times * row[0];
		matrix[r][1][i] += times * row[1];
		matrix[r][2][i] += times * row[2];
		matrix[r][3][i] += times * row[3];
		matrix[r][4][i] += times * row[4];
		matrix[r][5][i] += times * row[5];
	}
}

SOIL_INLINED void put_both(const float arm[3], const float v[3], float both[6])
{
	both[0] = v[0];
	both[1] = v[1];
	both[2] = v[2];
	cross3(arm, v, both + 3);
}

/* Adds what the lower end of a rim bears beside each cell. Its place moves with the body, and it bears more where its edge sinks below the ground. */
SOIL_INLINED void add_brims(const struct soil_form *f, bool asked, float unit, const struct lane_posts *p, const struct block *l, float stresses[7][LANES],
			    struct counts *counts, struct lane_changes *changes)
{
	const float post = f->spacing * f->spacing;
	if (!any_above(f->lean < 0 ? p->side_left : p->side_right, 0))
		return;
	EACH_LANE {
		struct place place;
		float shear[3], stress[3], moment[3];
		put_brim(f, asked, p, l, i, &place);
		stress_at(&place, shear, stress);
		cross3(place.arm, stress, moment);
		for (int k = 0; k < 3; k++) {
			stresses[k][i] += place.area * stress[k];
			stresses[3 + k][i] += place.area * moment[k];
		}
		counts->grows[i] += place.area * place.sinks * place.normal[2] * unit;
		counts->area[i] += (int32_t)(place.ground * BEAR_AREA_UNITS + 0.5f);
		if (asked) {
			const float area = place.area * post, up[3] = {-p->rise_x[i], -p->rise_y[i], 1}, bears = place.ground * p->up[i];
			float column[6], row[6], along[2][6];
			put_both(place.arm, place.normal, column);
			put_both(place.arm, up, row);
			put_both(place.arm, place.across[0], along[0]);
			put_both(place.arm, place.across[1], along[1]);
			add_outer(column, column, -area * place.damps, i, changes->damping);
			add_outer(column, row, -area * place.sinks, i, changes->stiffness);
			for (int j = 0; j < 2; j++)
				for (int k = 0; k < 2; k++) {
					add_outer(along[j], along[k], -area * place.strength * place.shears[j][k], i, changes->stiffness);
					add_outer(along[j], along[k], -area * place.drags[j][k], i, changes->damping);
				}
			changes->normal_force[i] += area * place.stress;
			changes->shear_limit[i] += area * place.strength;
			for (int k = 0; k < 3; k++)
				changes->sheared[k][i] += area * place.strength * shear[k];
			changes->normal[0][i] -= bears * p->rise_x[i];
			changes->normal[1][i] -= bears * p->rise_y[i];
			changes->normal[2][i] += bears;
		}
	}
}

SOIL_INLINED int64_t total(const int32_t counts[LANES])
{
	int64_t sum = 0;
	for (int i = 0; i < LANES; i++)
		sum += counts[i];
	return sum;
}

/* Rounds what the lanes bear to whole numbers, and adds them up. */
SOIL_INLINED void count(const struct soil_form *f, const struct lane_posts *p, float unit, const struct block *l, const float stresses[7][LANES],
			struct counts *c, struct soil_sums *sums)
{
	EACH_LANE {
		float large = 0;
		for (int k = 0; k < 3; k++) {
			const float force = stresses[k][i] * unit, moment = stresses[3 + k][i] * unit * f->by_arm;
			large = most(large, most(fabsf(force), fabsf(moment)));
			c->force[k][i] = whole_of(clamped(force, -BEAR_MOST, BEAR_MOST));
			c->moment[k][i] = whole_of(clamped(moment, -BEAR_MOST, BEAR_MOST));
		}
		c->pull[i] = whole_of(clamped(stresses[6][i] * unit, -BEAR_MOST, BEAR_MOST));
		c->saturated[i] = large > BEAR_MOST ? 1 : 0;
		const bool bears = (c->area[i] > 0) & (p->over[i] > 0);
		const float deep = l->depth[i] + l->more[i]; /* below the base: */
		c->deepest[i] = bears ? whole_of(least(deep, 2000) * 1048576.0f) - p->deposited[i] : 0;
	}
	for (int k = 0; k < 3; k++) {
		sums->force[k] += total(c->force[k]);
		sums->moment[k] += total(c->moment[k]);
	}
	sums->pull += total(c->pull);
	sums->area += total(c->area);
	sums->saturated += total(c->saturated);
	EACH_LANE {
		sums->deepest = c->deepest[i] > sums->deepest ? c->deepest[i] : sums->deepest;
		sums->grows += (double)c->grows[i];
	}
}

/* --- a block --- */

SOIL_INLINED void keep(const struct lane_posts *p, size_t b, const struct block *l, struct soil_kept *kept)
{
	EACH_LANE {
		const float stays = exp_minus(l->slides[i] * clamped(lasted(p, i, l->passed[i]), 0, 1));
		kept->more[b + i] = l->more[i];
		kept->shear_x[b + i] = sheared(p->shear_x[i], l->direction[0][i], stays);
		kept->shear_y[b + i] = sheared(p->shear_y[i], l->direction[1][i], stays);
	}
}

/* What an evaluation asks and finds. */
struct asked {
	int32_t raised;
	float share;
	struct soil_sums *sums;
	struct soil_kept *kept;
	struct lane_changes *changes; /* NULL: not asked */
};

SOIL_INLINED void bear(const struct soil_form *f, enum soil_form_kind kind, bool asked, const struct soil_posts *posts, const struct asked *a)
{
	const float unit = BEAR_UNITS_A_PASCAL / a->share;
	for (size_t b = 0; b < posts->count; b += LANES) {
		if (a->kept == NULL && !any_above(posts->room + b, (float)a->raised * SOIL_UNIT + f->beyond))
			continue;
		struct lane_posts lanes;
		const struct lane_posts *p = &lanes;
		struct block l;
		struct spots spots;
		struct counts counts;
		struct lane_places all;
		float stresses[7][LANES] = {{0}};
		take_lanes(posts, b, &lanes);
		memset(counts.area, 0, sizeof counts.area);
		memset(counts.grows, 0, sizeof counts.grows);
		put_depths(f, kind, p, a->raised, &l);
		put_slides(f, kind, p, &l);
		if (f->digs_most > 0)
			dig(f, p, &l);
		if (a->kept != NULL)
			keep(p, b, &l, a->kept);
		if (!any_above(l.share, 0))
			continue;
		put_memory(f, p, &l);
		if (!knows_places(kind))
			put_beneath(f, kind, p, &l);
		put_line(f, kind, p, &l);
		if (asked)
			memset(&all, 0, sizeof all);
		for (int k = 0; k < 2; k++) {
			put_spots(f, kind, p, &l, k == 0 ? -0.28867513f : 0.28867513f, &spots);
			add_places(f, kind, asked, unit, p, &spots, stresses, &counts, &all);
		}
		if (kind == FORM_RIM && f->lean != 0)
			add_brims(f, asked, unit, p, &l, stresses, &counts, a->changes);
		if (asked)
			add_changes(f, kind, p, &l, &all, a->changes);
		count(f, p, unit, &l, (const float(*)[LANES])stresses, &counts, a->sums);
	}
}

#define BEAR_OF(kind, name) \
	SOIL_CLONED static void bear_##name(const struct soil_form *restrict f, const struct soil_posts *restrict p, const struct asked *restrict a) \
	{ \
		if (a->changes != NULL) \
			bear(f, kind, true, p, a); \
		else \
			bear(f, kind, false, p, a); \
	}
BEAR_OF(FORM_RIM, rim)
BEAR_OF(FORM_BALL, ball)
BEAR_OF(FORM_CAPSULE, capsule)
BEAR_OF(FORM_BOX, box)
BEAR_OF(FORM_END, end)
BEAR_OF(FORM_RASTER, raster)

static double total_real(const float lanes[LANES])
{
	float fours[4];
	for (int i = 0; i < 4; i++)
		fours[i] = (lanes[i] + lanes[i + 8]) + (lanes[i + 4] + lanes[i + 12]);
	return ((double)fours[0] + (double)fours[2]) + ((double)fours[1] + (double)fours[3]);
}

static void total_matrix(float (*lanes)[6][LANES], struct soil_matrix *matrix)
{
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k++)
			matrix->at[i][k] = total_real(lanes[i][k]);
}

void soil_bear(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
	       struct soil_changes *changes)
{
	static void (*const forms[])(const struct soil_form *restrict, const struct soil_posts *restrict, const struct asked *restrict) = {
		[FORM_RIM] = bear_rim, [FORM_BALL] = bear_ball, [FORM_CAPSULE] = bear_capsule, [FORM_BOX] = bear_box, [FORM_END] = bear_end, [FORM_RASTER] = bear_raster,
	};
	struct lane_changes lanes;
	if (changes != NULL)
		memset(&lanes, 0, sizeof lanes);
	*sums = (struct soil_sums){.deepest = 0};
	const struct asked asked = {raised, share, sums, kept, changes != NULL ? &lanes : NULL};
	forms[form->kind](form, posts, &asked);
	if (changes == NULL)
		return;
	for (int k = 0; k < 3; k++) {
		changes->normal[k] = total_real(lanes.normal[k]);
		changes->sheared[k] = total_real(lanes.sheared[k]);
	}
	changes->normal_force = total_real(lanes.normal_force);
	changes->shear_limit = total_real(lanes.shear_limit);
	total_matrix(lanes.stiffness, &changes->stiffness);
	total_matrix(lanes.damping, &changes->damping);
}
