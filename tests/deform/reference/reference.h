/*
 * References in floating point: lower envelopes by brute force, closed forms of bearing soil, and the kinematic models for bench_accuracy.
 * They share nothing with what they check but the poses and the soils. No state but the ground's; any thread, a ground at a time.
 *
 * What it must agree with is ../SOIL.md. Its soil is divisible: no fixed-point units, nothing is rounded.
 */
#ifndef FURROW_DEFORM_REFERENCE_H
#define FURROW_DEFORM_REFERENCE_H

#include "deform/deform.h"

/* The lowest that the lower envelope of the swept object is above (x, y), in metres from the start of the
 * sweep (its `from`): x, y along the ground and *z up. False if the object never is above it. */
bool reference_underside(const struct deform_contact *sweep, long double x, long double y,
			 long double *z);

/* Of it, what a mesh and a wheel's grousers are: `axes` the object's own at the end, `way` from start to end in metres. The
 * grousers are sampled in time: a place on them is right to a 100th of their way. */
bool reference_mesh(const struct deform_contact *sweep, long double axes[3][3], const long double way[3], long double x,
		    long double y, long double *z);
bool reference_lugs(const struct deform_contact *sweep, long double axes[3][3], const long double way[3], long double x, long double y,
		    long double *z);

#define REFERENCE_SWEPT 1 /* contact: the contact pressed the post */
#define REFERENCE_HELD 2  /* contact: the object rests on it at the end */

/*
 * A field of posts, row 0 the southern, row by row; metres. Volume: the sum of the offsets, times a
 * post's area, plus `compacted`, never changes but for what rounding in doubles does.
 */
struct reference_ground {
	int width, height;
	int64_t left, bottom;   /* the global post that the first one is */
	double spacing;
	struct post_rect written; /* posts of the field: spreading and sliding stay within */
	double *base, *offset;    /* surface: base + offset */
	double *carried;          /* what the last press has lifted and not yet laid down, of height */
	uint8_t *contact;         /* of the last press */
	bool *hole;
	double compacted;         /* m3, gone for good */
	double confined;          /* m3 of it: had no free post to go to */
};

/* Flat at 0, no hole, all of it written. */
enum status reference_ground_init(struct reference_ground *ground, int width, int height, double spacing) FURROW_CHECKED;
void reference_ground_finish(struct reference_ground *ground);
/* Press: what becomes of each post under the object. Sets contact and carried. */
void reference_none(struct reference_ground *ground, const double *under, const double *rest);
void reference_sumner(struct reference_ground *ground, const struct soil_numbers *soil, const double *under,
		      const double *rest);
void reference_slippage(struct reference_ground *ground, const double *under, const double *rest);
/* How carried soil was laid down. */
struct reference_laying {
	double rate;      /* the most soil of height for each metre of weight */
	double share;     /* of the carried soil for each metre of weight, the most */
	double width;     /* of the bands, m; a weight is at most a third of it */
	bool undecided;   /* a post lies where it may count or not */
};
/* Lays down what is carried. */
enum status reference_spread(struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
			     struct reference_laying *laying) FURROW_CHECKED;

/* Slides `iterations` times, or fewer once nothing moves more than `tolerance` metres; how far the last moved
 * any post is *moved. DEFORM_SUMNER, DEFORM_SLIPPAGE. */
enum status reference_slide(struct reference_ground *ground, const struct deform_params *params, long iterations,
			    double tolerance, double *moved) FURROW_CHECKED;
/* The difference of height that stands between two posts `distance` metres apart. */
double reference_stands(const struct deform_params *params, double distance);

/* Closed forms: wheel.c. Width: the k_c / b of Bekker's formula. */
double reference_stiffness(const struct soil_numbers *soil, double width);                    /* Pa/m^n */
double reference_bekker(const struct soil_numbers *soil, double width, double sinkage);       /* Pa */
double reference_plate(const struct soil_numbers *soil, double width, double pressure);       /* sinkage, m */
double reference_janosi(const struct soil_numbers *soil, double pressure, double displacement); /* Pa */
/* The most shear stress at an object's surface, Pa: the soil shears within itself or slides along the surface. */
double reference_strength(const struct soil_numbers *soil, const struct soil_interface *interface, double pressure);
double reference_adhesion(double cohesion); /* Pa: of a surface of which none is given */
/* Bekker's towed rigid wheel, m; and the resistance that compaction makes at a sinkage, N. */
double reference_towed(const struct soil_numbers *soil, double load, double width, double diameter);
double reference_resistance(const struct soil_numbers *soil, double width, double sinkage);
/* The load that the exact arc of a rigid wheel carries with vertical stresses alone, N: in front of the
 * axle the soil yields; behind it it springs back (`rebound`) or is not touched. And its inverse. */
double reference_arc_load(const struct soil_numbers *soil, double sinkage, double width, double radius, bool rebound);
double reference_arc(const struct soil_numbers *soil, double load, double width, double radius, bool rebound);

struct reference_wheel {
	double radius, width; /* m */
	double slip;          /* 1 - way / (radius x turned); below 0: it is dragged */
	double a0, a1;        /* where the greatest stress is: (a0 + a1 slip) of the entry angle */
};
struct reference_wheel_forces {
	double load, drawbar, torque; /* N, N, N m */
};
struct reference_wheel_forces reference_wong_reece(const struct soil_numbers *soil, const struct reference_wheel *wheel,
						   double sinkage);
/* The sinkage at which it carries the load, m. */
double reference_wong_reece_sinkage(const struct soil_numbers *soil, const struct reference_wheel *wheel, double load);

/*
 * Closed forms: statics.c. The pressure of scm soil in yield is p(z) = min(K_s z^n, K_e z): Bekker's curve, nowhere steeper than
 * elastic unloading. z is along the ground's normal. n above 0; K_s = k_c / width + k_phi above 0; all angles in rad.
 */
double reference_yield(const struct soil_numbers *soil, double width, double sinkage);          /* p, Pa, at z in m */
double reference_yield_sinkage(const struct soil_numbers *soil, double width, double pressure); /* its inverse, m */
double reference_yield_work(const struct soil_numbers *soil, double width, double sinkage);     /* integral of p dz, J/m2 */
/* Returns the sinkage at which the two curves cross, m. Elastic below it if n < 1, above it if n > 1; INFINITY if n = 1. */
double reference_yield_crossing(const struct soil_numbers *soil, double width);

/* Returns how deep a plate sinks, m, when its whole load is applied at once and nothing damps: integral of p dz = pressure z.
 * That is (n + 1)^(1/n) times as deep as under a slow load, where all of it follows Bekker's curve. Width m, pressure Pa. */
double reference_plate_at_once(const struct soil_numbers *soil, double width, double pressure);

/*
 * Returns the load in N that carries a sphere of `radius` m at `sinkage` m, 0 .. radius, below level ground. Each ring of it
 * is a plate of its own: F = 2 pi ((R - z) integral of p dz + integral of z p dz), exact for the circle. The width in K_s is the
 * patch's radius, sqrt(z (2 R - z)).
 */
double reference_sphere_load(const struct soil_numbers *soil, double radius, double sinkage);
/* Its inverse: the sinkage in m under a load in N that is applied slowly. NAN: half of the sphere does not carry it. */
double reference_sphere(const struct soil_numbers *soil, double load, double radius);

/*
 * A box at rest on a slope. Its guide is vertical: it can push along the level, and carries no weight. The soil's vertical force
 * is the load: N cos a + T sin a = W. The shear T holds what acts along the slope, W sin a, up to Coulomb's limit:
 * T = min(W sin a, c A + N tan phi). Where T is W sin a, N is W cos a, as of a body without a guide.
 * The vertical force grows with the sinkage, so there is one sinkage, and it is the least.
 * It exists for each load above 0 and slope from 0 to below pi / 2, since p has no bound. `width` is across the slope.
 * Soil with K_s or K_e of 0 carries nothing: the results are infinite or NAN. A box whose height is below the sinkage is buried;
 * these functions do not know its height.
 */
struct reference_rest {
	double sinkage;  /* m, along the ground's normal; of a level box at its upper edge */
	double normal;   /* N, across the slope, N */
	double shear;    /* T, up the slope, N */
	double vertical; /* N cos a + T sin a, N */
	double residual; /* W sin a - T, N: what the soil leaves along the slope; above 0 the body slides. The guide's push is
			  * residual / cos a */
};
/* The box lies on the slope: the same sinkage everywhere. length x width is measured along the ground. A closed form. */
struct reference_rest reference_rest_flat(const struct soil_numbers *soil, double length, double width, double load, double slope);
/* The box is level: a wedge of soil is below it. length x width is measured along the level. The normal force is
 * width (W(z) - W(z - length sin a)) / (sin a cos a), where W is reference_yield_work. The sinkage z is found by halving. */
struct reference_rest reference_rest_level(const struct soil_numbers *soil, double length, double width, double load, double slope);

/*
 * Closed forms: wheel_forms.c. A rigid wheel rolls straight over level, undisturbed scm soil at a constant slip, without grousers.
 * The soil yields at p(z), z vertical, in front of the lowest point, and springs back with K_e behind it.
 * Shear is Janosi's and Hanamoto's, tau = (c + p tan phi)(1 - exp(-j / K)), against the sign of the slip displacement j. The strength
 * in the first brackets is that of the rim's surface if that is less.
 */
enum reference_normals {
	REFERENCE_NORMALS_GROUND,  /* p is vertical and tau horizontal, both per area of ground: Project Chrono's SCM */
	REFERENCE_NORMALS_SURFACE, /* p is normal to the rim and tau along it, both per area of rim: Wong and Reece 1967 */
};
/* What the slip displacement is of. Both add up the rim's speed along the ground or the rim, from first touch. */
enum reference_follows {
	REFERENCE_FOLLOWS_SOIL, /* a place of the soil that the rim passes over: what a post remembers, and Chrono's SCM */
	REFERENCE_FOLLOWS_RIM,  /* a point of the rim that passes over the soil: Wong and Reece */
};
struct reference_rolling {
	double radius, width; /* m */
	double turned;        /* rim's way / axle's way, 0 or more: 0 locked, 1 rolls, above 1 driven */
	enum reference_normals normals;
	enum reference_follows follows;
	bool rebound;         /* false: contact ends at the lowest point */
	struct soil_interface interface; /* its rim's */
};
/* On the wheel, at its axle. */
struct reference_rolling_force {
	double drawbar;        /* N, forwards */
	double vertical;       /* N, upwards: normal and shear */
	double moment;         /* N m, about the axle to the left: below 0 it resists a driven wheel */
	double shear_moment;   /* N m of it: vertical pressure has a moment about the axle too, one along the rim has none */
	double shear_vertical; /* N of the vertical force */
};
/* Returns `turned` of a slip: below 0 turned = 1 + slip (the measured wheel's: -1 locked), else 1 / (1 - slip), slip below 1.
 * A scene's slip, 1 - way / rim, is 1 / (1 - slip) below 0 too: there the measured -0.2 is -0.25, and -0.5 is -1. */
double reference_turned(double slip);
/* Returns the forces at a sinkage in m, 0 .. radius, with an error below 1e-9 of radius x width x (p + c) x arc (times radius for
 * moments). Any n above 0. The displacement j is signed: where it changes its sign within the arc, a law of |j| differs. */
struct reference_rolling_force reference_rolling(const struct soil_numbers *soil, const struct reference_rolling *wheel,
						 double sinkage);
/* Returns the least sinkage in m at which the vertical force is the load in N. NAN: none up to the radius. It is found between
 * sinkages that are 8 % apart: a force that reaches the load only between two of these is missed. */
double reference_rolling_sinkage(const struct soil_numbers *soil, const struct reference_rolling *wheel, double load);
/* Returns the load in N that carries a wheel let down slowly without rolling: both halves of its arc yield vertically. */
double reference_standing_load(const struct soil_numbers *soil, double sinkage, double width, double radius);

/*
 * An integral: leaning.c. A rigid wheel with camber is set down on level, undisturbed scm soil, or has rolled straight over it at a constant slip,
 * without grousers and without sinking by slip. In planes across its axle it is a level wheel: REFERENCE_NORMALS_SURFACE, REFERENCE_FOLLOWS_RIM,
 * with rebound. The displacement counts from where the rim came to a place of the ground. At a camber of 0 the two agree. The lower side wall bears by its
 * area in plan.
 */
struct reference_leaning {
	double radius, width; /* m */
	double camber;        /* rad, 0 or more, below pi / 2: its right side is down */
	double sinkage;       /* m, of its lowest place: that of the side wall's edge */
	bool rolls;           /* false: it was set down straight */
	double turned;        /* rim's way / axle's way, above 0, if it rolls */
};
struct reference_wrench {
	double force[3], moment[3]; /* N forward, to the left and up; N m about the wheel's centre */
};
/* Returns the soil's force on the wheel. Its error is about 1e-3 of it. */
struct reference_wrench reference_leaning(const struct soil_numbers *soil, const struct reference_leaning *wheel);
/* Returns the sinkage in m, up to the radius, at which the vertical force is the load in N. */
double reference_leaning_sinkage(const struct soil_numbers *soil, const struct reference_leaning *wheel, double load);

/* Closed forms: slope.c. Slopes in rad. The least factor of safety of a slope over all planes, and the height at
 * which that is 1 (INFINITY: for no height). */
double reference_safety(const struct soil_numbers *soil, double slope, double height);
double reference_culmann(const struct soil_numbers *soil, double slope);

#endif
