/*
 * A body as the law sees it: its lower envelope between posts, and its motion since its last contact. Places are in metres from the body's
 * centre, in plan, in the body's frame: x forwards, y to its left. Heights are above the centre. Prepared once a contact or probe. Pure.
 */
#ifndef FURROW_SOIL_FORM_H
#define FURROW_SOIL_FORM_H

#include "soil/law/real.h"
#include "soil/law/stress.h"
#include "soil/shape/lower_envelope.h"
#include "soil/soil.h"

/* The forms that the law knows. A rim: the side of a wheel or of a cylinder whose axis is level enough. An end: a steeper cylinder. */
enum soil_form_kind { FORM_RIM, FORM_BALL, FORM_CAPSULE, FORM_BOX, FORM_END, FORM_RASTER, FORM_WALL /* of no body: a wall of a box (bear_walls.h) */ };

#define FORM_LEANS_MOST 0.5      /* rise of an axis: up to it a cylinder is a rim, and its lower end a brim beside that */
#define FORM_LEVEL_LEAST 1e-5    /* length in plan of an axis: an upright one counts as this, so that all numbers are finite */
#define FINE_NONE 1e9f      /* m: height of a place that a mesh or a bar is not above */
#define FORM_BESIDE 2e-9         /* m: a place that lies beside a body by less is below its edge */
#define FORM_WALL_LEAST 0.5547002 /* z of a normal: steeper faces are walls */
#define FORM_UPRIGHT 0.05f       /* z of a unit normal: steeper slopes are taken as the one with this z, */
#define FORM_STEEPEST 19.974984f /* which is this slope, */
#define FORM_STEEPEST_PART 0.99874922f /* and whose normal has this length in plan */

/*
 * The lower envelope of triangles at places `step` apart, m above the centre, row by row. The first place is (x, y) from the centre, east and north.
 * A post's cell has parts x parts places; `parts` is odd, so the post is the middle one. Drawn by fine.c.
 */
/* The edges in a cell from which steep walls rise, as sums over the length of these edges. Divided by the length: means. Places are to the east and
 * north. */
struct soil_brim {
	float length;           /* m */
	float x, y, z;          /* place on the edge, m from the body's centre */
	float out[2], aside[2]; /* unit vectors in plan, away from the body: where the wall rises, and across the edge */
	float flat, tall;       /* how far the wall goes out for each metre that it rises; m: its height */
	float end;              /* 1: it is the flat end of a drum, which bears by its area in plan */
};

struct soil_fine {
	const float *heights;       /* also beside the mesh, where they go on from its edge */
	const float *drawn;         /* the same, but FINE_NONE beside the mesh */
	const float *walls;         /* as `drawn`, with steep walls, which bear beside the cells. NULL: there are none */
	float moved;                /* 1: the mesh moved in plan; 0: the next three do not count */
	const float *less, *since;  /* how much lower it was during its motion and half a cell before, and how many motions ago */
	const float *passed;        /* of cells: its lowest height at the post during its motion, or beside a post that it passed closely. FINE_NONE: none */
	int32_t columns, rows, stride, east; /* stride, east: elements to the next row and column. `east` is 1: gcc's gathers need a variable */
	float x, y, step, by_step;
	float axis[2];              /* of the frame's x axis: east, north */
	int32_t parts, cells[2];    /* cells: columns and rows of cells */
	/* Of cells: the share that the post bears, and the middle of that share from the post, in posts to the east and north. lows: the
	 * lowest place during the motion, of the cell and those beside it. */
	const float *areas, *middles[2], *lows;
	/* A mesh whose facets turn: its height at the posts of cells halfway through the motion, and at its start. m above the centre at the end. NULL:
	 * turning does not change its lower envelope. */
	const float *earlier[2];
	/* Of lines along the motion, a step apart: how far ahead and behind the mesh reaches there, m. aside: m, of the first line. sides: m, of the mesh. */
	const float *front, *rear;
	int32_t strips;
	/* Of cells, if walls hang from edges of what bears: `struct soil_brim`, or NULL. */
	const struct soil_brim *brims;
	float aside, sides[2];
};

/*
 * The lower faces of a box that is tilted, in plan and in its frame; m from its centre. Each is a parallelogram, and together they are what it covers. A steep
 * one is a wall: in soil it is narrower than a cell, so it bears beside the edge from which it rises (bear_walls.h). The others are soles, whose posts bear.
 */
struct soil_box_sole {
	float middle[2], half[2][2];
};
struct soil_box_wall {
	int sole, face;               /* of the sole from whose edge it rises; its own among the box' three faces */
	float at[2], along[2], low;   /* the middle of that edge; half of it; its height */
	float up[3], back[3];         /* from the edge to the wall's top; across the sole, to its other edge. Both rise */
	float normal[3], wide;        /* into the box, unit; area in plan for each metre of edge, m */
};

/* Heights of a wheel's grousers at posts, row by row, m above the centre. FINE_NONE: no bar is there. Drawn by grousers.c. */
struct soil_grousers {
	const float *rests, *lowest; /* in the end pose; during the motion. NULL: it has none */
	int32_t columns, rows;
	float x, y;                  /* of the first post from the centre, m east and north */
};

/* The recent motion of a body in its frame (struct soil_trend), and its two parts of turning: those of `spin` below. */
struct soil_recent {
	float way[3], turn[3], rolling[3], turning[3], ran;
	float along_ground; /* a way along the ground over the same in plan */
};

/* About what a body rolls. */
enum soil_rolls { ROLLS_NOT, ROLLS_ABOUT_AXIS, ROLLS_ABOUT_LEVEL }; /* not at all; about roll_axis; about any level axis */

struct soil_form {
	enum soil_form_kind kind;
	float radius, by_radius;   /* of other shapes: of a sphere around the body */
	float half[2];             /* half of its length and of its width in plan; 0: it has no straight sides there */
	float enters[2][2];        /* how far it reaches behind and ahead, right and left, together with bodies that abut it, m */
	float spacing;
	float half_across;         /* half the length of a line across a post's cell */
	float step_aside, by_step; /* between two posts across the body's way */
	float cut[2][2];           /* from a post to the next, along the lattice's axis that is nearest to the frame's x, and y */
	/* Its circles: upright planes along the motion cut it in circles, `lift` times as high, and sheared. */
	float run, rise, sine;     /* way forwards; rise for each metre, less the shear; sine of that slope of the circle */
	float plunge;              /* how far the circle moved up, in units of `lift` */
	float lift;
	/* The axis of a rim, an end, a capsule. lean: its rise (rim, end: towards the left); level: its length in plan; half_axis: half of its straight part. */
	float lean, level, half_axis;
	float rim_level;           /* a rim, and a mesh of a drum: level; other forms, which may turn about any axis: 1 */
	float bulges;              /* 1/m: how the edge of a drum's end bends in plan; 0: it is straight */
	float along[2];            /* capsule: the axis in plan */
	float faces[3][3];         /* box: lower faces: height at the centre, slope along the frame's axes */
	/* A box that is tilted. tilts: 1: its cells are cut along its soles' edges, and its walls bear. Less below a tilt of a degree; 0: it is level. */
	float tilts;
	struct soil_box_sole soles[3]; /* of `faces` */
	bool is_sole[3];
	struct soil_box_wall walls[2];
	int wall_count;
	float slabs[3][3];         /* box: in plan it lies in three slabs: unit vector across, half the width; m */
	/* Ball and ellipsoid: height = tilt . at - drop sqrt(1 - squares), squares = ahead_by (x + skew y)^2 + aside_by y^2 <= (shrinks |at|)^2 */
	float tilt[2], drop, ahead_by, skew, aside_by, shrinks;
	struct soil_fine fine;     /* raster */
	struct soil_grousers grousers;
	float outer;               /* radius of a wheel with its grousers, m; of a drum over them, where faces push */
	/* The motion since the last contact: m; rad about the centre, a wheel's turning included; m that a belt ran. */
	float way[3], spin[3], ran;
	/* The two parts of spin. A body rolls off the soil as it turns about the axis of its rim, or without one about a level axis. As it yaws it stays,
	 * and so does a body with flat faces as it rocks. */
	float rolling[3], turning[3];
	enum soil_rolls rolls_about;
	float roll_axis[3];
	float bars;                /* share of a rim's circumference along which its grousers carry the soil with them; 0: it has none, or `all_round` is 0 */
	float bars_beyond;         /* by which share of its way the drum over these bars runs farther than the rim does */
	float scooped;             /* m: how deep its grousers have taken the soil away from below it (struct soil_trend) */
	float all_round;           /* 1: soil pushes on its faces as it slides: `recent` is set. 0: on its lower envelope alone */
	float slides;              /* 1: it slides at some place, so faces push there; 0: nowhere, so the lower envelope bears all */
	float sole;                /* a flat sole that only slides: the share of the lower envelope's stress that it keeps, 0 .. 1 (faces/footing.c). 0: it has none */
	struct soil_recent recent, last; /* of struct soil_trend: whole, last */
	float by_way[2];
	float moved;               /* 0: it stood still; 1: it moved over half a cell */
	float stamps;              /* 1: the hollow that it left has its shape; 0: it is a flat rut */
	float prints;              /* 1: a cell has the body's shape at the motion's start, where it bore then. 0: it went on by a post, and left a flat rut */
	float passes[2];           /* how far it went: in plan, and along the ground, m */
	float along_ground;        /* the second over the first */
	float rolls;               /* how much its surface may roll off: less for a motion that is steeper than 45 degrees, 0 from 63 on */
	float ahead;               /* of a rim or a belt: the part of its way along which it runs, squared */
	float locked;              /* 1: a rim or a belt, which rolls off even if it does not run. Less if the body yaws. 0: another body */
	float rim_time[2];         /* of a rim: how long it is above a place (time_of): one number, and one times its slope's 1 / cosine */
	float rim_digs;            /* of a rim: the same for its slip along the ground */
	float reach;               /* of its lowest place below the centre, grousers apart, m */
	float rim_reach;           /* of the surface that rolls, below the axis about which it rolls, m */
	float belt[3];             /* the body's axis to its left; 0: it has no belt */
	float belt_level;          /* its length in plan; 1 without a belt */
	float digs_most;           /* how deep slip digs at most, in units of the shear modulus; 0: slip digs nothing */
	float beyond;              /* m: the very height of the centre above the rounded one */
	float by_arm;              /* 1/m: of moments that are summed as whole numbers */
	float rates;               /* 1: how it moves now is known; 0: its velocity is 0 or not known, and it counts as going down */
	float ground_normals;      /* 1: stresses act along the ground's normals; 0: along the body's */
	float linear[3], angular[3], runs; /* m/s, rad/s, m/s of the belt: how it moves now */
	float goes[3], turns[3];   /* m/s, rad/s: the same, and of a body on a path the mean of its motion. 0: not known */
	float bulldozing;
	struct stress_surface surface;
	float tyre_holds, tyre_stiff, tyre_grows, tyre_damps; /* pressure, stiffness, growth and damping of struct soil_tyre; tyre_stiff 0: a rigid wheel */
};

/* What the posts need beside that, in doubles. */
struct soil_body {
	const struct soil_motion *motion;
	double axis[2];            /* the frame's x axis: east, north */
	double centre[3];          /* m: `to` and what lies beyond it, from the south-west post */
	double way[3];             /* m, along the frame's axes */
	double outer;              /* m: radius of a wheel with its grousers; of a drum over them, where faces push */
	struct soil_shape smooth;  /* without grousers */
	struct lower_envelope lower;
};

/* Tells a form of kind FORM_RASTER that it is a drum of this radius, m, about an axis: a unit vector, east, north, up. It rolls as a cylinder does. */
void soil_form_drum(const struct soil_body *body, const double axis[3], double radius, struct soil_form *form);
/* Returns how much of a rise counts as a way along the ground, for a way forward in plan. From a slope of 1 to one of 2 that is less and less. */
double soil_form_level_share(double forward, double rise);
/* Gives how a body turned during its motion, rad about local axes. A wheel's turning about its axle comes beside that of its attitude. */
void soil_form_spin(const struct soil_motion *motion, double spin[3]);
/* Parts a turning, rad, into that by which the body rolls off the soil, and the rest. */
void soil_form_split(const struct soil_form *form, const float spin[3], float rolling[3], float turning[3]);
/* Fills both. `body` points to itself and to the motion, so it is not copied. The raster is not set. */
void soil_form_of(const struct soil_law *law, const struct soil_motion *motion, struct soil_body *body, struct soil_form *form);

/* Returns half the width of a rim's strip, `ahead` of its axis. */
SOIL_INLINED float half_strip(const struct soil_form *f, float ahead)
{
	return root(f->radius * f->radius - ahead * ahead);
}

/* Returns how far to the left of the middle between its sides a place is. */
SOIL_INLINED float aside_of(const struct soil_form *f, enum soil_form_kind kind, float x, float y)
{
	return kind == FORM_RIM || kind == FORM_END ? y - f->lean * half_strip(f, x) : y;
}

/* Returns on which side a leaning cylinder's lower end is. -1: to the right. */
SOIL_INLINED float low_side(const struct soil_form *f)
{
	return f->lean < 0 ? 1 : -1;
}

#endif
