/*
 * The passive wedge of soil ahead of a wide face: how much its weight and its cohesion push on the face, by the face's rake. McKyes, Soil Cutting and
 * Tillage (1985), after Reece's earthmoving equation: a plane wedge whose angle gives the least force. Pure.
 */
#ifndef FURROW_SOIL_WEDGE_H
#define FURROW_SOIL_WEDGE_H

#define WEDGE_RAKES 17   /* rakes from 10 to 90 degrees, 5 degrees apart */

struct soil_wedge {
	double phi, delta;   /* of which it is; rad */
	float weight[WEDGE_RAKES], cohesion[WEDGE_RAKES]; /* normal pressure for each N/m3 and metre of depth, and for each pascal of cohesion */
};

/* Fills the table for a friction angle of the soil and one along the face, rad. Does nothing if it is of these already. A wedge that was zeroed is of none. */
void soil_wedge_of(double phi, double delta, struct soil_wedge *wedge);
/* Gives the numbers of both tables for a face whose normal has this z, 0 (upright) to 1; linear between rakes. */
void soil_wedge_at(const struct soil_wedge *wedge, float up, float *weight, float *cohesion);

#endif
