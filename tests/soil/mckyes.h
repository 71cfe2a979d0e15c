/*
 * The earthmoving equation: the force on a wide blade that goes forwards through soil, by the wedge of soil that it lifts. A. R. Reece, The fundamental
 * equation of earth-moving mechanics, 1964; E. McKyes, Soil cutting and tillage, 1985. Derived anew in mckyes.c. Pure.
 */
#ifndef FURROW_TESTS_MCKYES_H
#define FURROW_TESTS_MCKYES_H

/* SI, radians. */
struct mckyes_blade {
	double depth, width;        /* m: of the cutting edge below the surface; along the edge */
	double rake;                /* of the blade above the level, on the side that the soil is on: pi / 2 is upright. 0.5 to pi / 2 */
	double friction, tool;      /* inner friction of the soil; that between soil and blade */
	double unit_weight;         /* N/m3 */
	double cohesion, adhesion;  /* Pa; of the soil; between soil and blade */
	double surcharge;           /* Pa on the surface of the wedge: what lies on it */
};

/* P = (unit_weight depth^2 weight + cohesion depth cohesion + surcharge depth surcharge + adhesion depth adhesion) width */
struct mckyes_factors {
	double weight, cohesion, surcharge, adhesion;
};

struct mckyes_force {
	double total;   /* P, N: at the angle `tool` to the blade's normal, without adhesion */
	double draft;   /* N: on the blade, against its motion */
	double lift;    /* N: on the blade, upwards; negative: it is drawn in */
	double failure; /* rad: of the plane of failure above the level */
	double ahead;   /* m: from the cutting edge to where that plane meets the surface */
	struct mckyes_factors factors;
};

/* Returns the N factors of a wedge whose plane of failure rises by this angle, rad. */
struct mckyes_factors mckyes_factors_at(const struct mckyes_blade *blade, double failure);
/* Returns the least force of all wedges. */
struct mckyes_force mckyes_force_of(const struct mckyes_blade *blade);

#endif
